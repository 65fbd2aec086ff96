"""Text as masks: glyphs the font lacks, digits that do not move, lines that fit, memory that is bounded."""

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import ImageFont

from glimt.viewer.overlay import glyph
from glimt.viewer.overlay.glyph import glyph_of, line_height
from glimt.viewer.overlay.text import LONGEST, shorten, text_mask, text_width, wrap

SIZES = (9, 11, 13, 15, 20, 26, 40)
CACHES = (text_mask, glyph_of, glyph._font, glyph._metrics)


@pytest.fixture
def without_freetype(monkeypatch):
    """Pillow as it is where it was built without FreeType."""
    class Missing:
        def __getattr__(self, name):
            raise ImportError(name)

    for cache in CACHES:
        cache.cache_clear()
    monkeypatch.setattr(ImageFont, "core", Missing())
    yield
    for cache in CACHES:
        cache.cache_clear()


@pytest.mark.parametrize("size", SIZES)
def test_digits_do_not_move(size):
    before = text_width("12", size)
    for digit in "0123456789":
        assert text_width(f"1{digit}.5 ms", size) == text_width("88.5 ms", size)
        unlike = text_mask(f"1{digit}.5 ms", size) != text_mask("18.5 ms", size)
        assert not unlike[:, :before - text_width("8", size) - size // 6].any()
        assert not unlike[:, before + size // 6:].any()
    assert (text_mask("11", size) != text_mask("18", size)).any()


@pytest.mark.parametrize("character", "×·²³→←↑↓—–−…é")
@pytest.mark.parametrize("size", [9, 13, 26])
def test_signs_are_drawn_and_not_as_the_box_of_what_is_lacking(character, size):
    mask = text_mask(character, size)
    assert mask.max() > 100
    assert mask.shape == (line_height(size), text_width(character, size))
    box = glyph._font(size).getmask("\uffff")
    assert mask.sum() != sum(bytes(box))


def test_what_nobody_can_draw_is_a_question_mark_and_an_accent_is_dropped():
    assert (text_mask("漢", 13) == text_mask("?", 13)).all()
    assert (text_mask("\x07", 13) == text_mask("?", 13)).all()
    for form in ("NFC", "NFD"):
        assert (text_mask(unicodedata.normalize(form, "Zoë"), 13) == text_mask("Zoe", 13)).all()


@given(st.text(st.characters(codec=None), max_size=30), st.sampled_from((9, 13)))
def test_any_text_has_a_mask_of_its_width(text, size):
    assert text_mask(text, size).shape == (line_height(size), max(text_width(text, size), 1))


@pytest.mark.usefixtures("without_freetype")
def test_without_freetype_the_bitmap_font_is_used():
    for size, times in ((9, 1), (13, 1), (22, 2), (40, 4)):
        assert text_mask("8×8 → é漢…²", size).shape == (11 * times, 6 * times * 10)
    assert (text_mask("1", 13) != text_mask("8", 13)).any()
    assert (text_mask("漢", 13) == text_mask("?", 13)).all()
    assert text_mask("×", 13).any()
    assert wrap("one two", 13, 6 * 5, 9) == ["one", "two"]


def test_masks_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        text_mask("abc", 13)[:] = 0


def test_caches_are_bounded():
    for number in range(10_000):
        text_mask(f"{number} rays", 13)
    for code in range(0x20, 0x20 + 3000):
        text_width(chr(code), 11)
    assert text_mask.cache_info().currsize == text_mask.cache_info().maxsize <= 256
    assert glyph_of.cache_info().currsize == glyph_of.cache_info().maxsize <= 1024


def test_a_line_is_cut_off_somewhere():
    assert text_mask("x" * 10**6, 13).shape[1] == LONGEST * text_width("x", 13)


@given(st.text("ab c\n/…", max_size=200), st.integers(20, 200), st.integers(1, 6))
def test_wrapped_lines_fit_and_lose_nothing_but_what_the_ellipsis_stands_for(text, width, most_lines):
    lines = wrap(text, 11, width, most_lines)
    assert len(lines) <= most_lines
    assert all(text_width(line, 11) <= width for line in lines)
    words, seen = "".join(text.split()), "".join("".join(lines).split())
    assert seen == words or (seen.endswith("…") and len(lines) == most_lines and words.startswith(seen[:-1]))


def test_lines_break_at_spaces():
    lines = wrap("light two has\nno position", 13, text_width("light two", 13), 9)
    assert lines == ["light two", "has", "no", "position"]


def test_a_huge_text_is_wrapped_at_once():
    lines = wrap("word " * 10**6, 13, 300, 4)
    assert len(lines) == 4
    assert lines[-1].endswith("…")


@given(st.text(max_size=40), st.integers(12, 300))
def test_a_shortened_text_fits(text, width):
    short = shorten(text, 11, width)
    assert text_width(short, 11) <= width
    assert short == text if text_width(text, 11) <= width else short.endswith("…")
