"""The help screen holds the whole table wherever there is room."""

import pytest

from glimt.viewer.overlay.glyph import line_height
from glimt.viewer.overlay.help_screen import help_layout, help_panel
from glimt.viewer.overlay.panel import DIM
from glimt.viewer.overlay.text import LEGIBLE, text_width

TABLE = tuple((group, f"Key {group[0]}{number}", f"what key {number} of {group} does to it")
              for group, count in (("Move", 7), ("Light", 4), ("Picture", 8), ("Scene", 3)) for number in range(count))


def _boxes(layout):
    return [(text.x, text.y, text.x + text_width(text.text, text.size), text.y + line_height(text.size))
            for text in layout.texts]


@pytest.mark.parametrize("room", [(386, 386), (640, 360), (1264, 704), (3800, 2120), (250, 1200)])
def test_all_rows_are_placed_within_the_panel_and_apart(room):
    layout = help_layout(TABLE, 26 if room[1] > 2000 else 15, room)
    assert layout.is_whole
    assert layout.width <= room[0]
    assert layout.height <= room[1]
    words = " ".join(text.text for text in layout.texts)
    assert [text.text for text in layout.texts if text.text.startswith("Key ")] == [keys for _, keys, _ in TABLE]
    assert all(group in words for group, *_ in TABLE)
    assert " ".join(text for *_, text in TABLE) == " ".join(
        text.text for text in layout.texts if text.color == DIM)
    boxes = _boxes(layout)
    for place, (left, top, right, bottom) in enumerate(boxes):
        assert min(left, top) >= 0
        assert right <= layout.width
        assert bottom <= layout.height
        for x0, y0, x1, y1 in boxes[:place]:
            assert x1 <= left or right <= x0 or y1 <= top + 1 or bottom <= y0 + 1
    panel = help_panel(layout)
    assert (panel.width, panel.height) == (layout.width, layout.height)


def test_text_gets_smaller_before_anything_is_left_out():
    sizes = [help_layout(TABLE, 15, (800, rows)).texts[-1].size for rows in (900, 400, 330)]
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[0] == 15
    assert sizes[-1] >= LEGIBLE


def test_what_does_not_fit_is_left_out_at_the_end():
    layout = help_layout(TABLE, 15, (400, 120))
    assert not layout.is_whole
    assert layout.height <= 120
    assert layout.texts[0].text == "Keys"
    assert max(bottom for *_, bottom in _boxes(layout)) <= 120


@pytest.mark.parametrize("room", [(90, 50), (10, 500), (500, 10), (0, 0), (-5, -5)])
def test_there_is_none_where_nothing_could_be_read(room):
    assert help_layout(TABLE, 15, room) is None


def test_an_empty_table_is_a_title():
    assert [text.text for text in help_layout((), 13, (400, 400)).texts] == ["Keys"]
