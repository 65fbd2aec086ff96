"""What is drawn over pictures: where, how legible, when anew, and that the rest stays as it is."""

import dataclasses

import numpy as np
import pytest

from glimt.color import srgb_to_linear
from glimt.errors import GlimtError
from glimt.viewer.overlay import frame_panel, panel
from glimt.viewer.overlay.frame_times import FrameTimes
from glimt.viewer.overlay.overlay import REFRESH_SECONDS, FrameInfo, Overlay, text_size
from glimt.viewer.overlay.text import text_mask

INFO = FrameInfo(0.0123, 0.0125, 0.0171, 1_500_000, 640, 360, 1280, 720, 2, 3, "adaptive", 144046, "fly")
NOTICES = {"message": "light added: 3", "error": "room.toml:4: light 2 has no position; give it one",
           "picked": "object  column\nmaterial  stone\ntriangle  18"}
TABLE = (("Move", "W A S D", "move"), ("Move", "wheel", "speed"), ("Light", "L", "add a light"))
TINY = [(1, 1), (2, 300), (300, 2), (12, 16), (48, 64), (60, 100), (100, 60), (150, 150)]


def _picture(rows=720, columns=1280, value=None):
    random = np.random.default_rng(rows)
    colors = random.integers(0, 256, (rows, columns, 3)) if value is None else np.full((rows, columns, 3), value)
    return np.dstack([colors, np.full((rows, columns), 255)]).astype(np.uint8)


def _times(count=240):
    times = FrameTimes()
    for one in np.random.default_rng(3).uniform(0.01, 0.02, count):
        times.add(one)
    return times


def _drawn(picture, info=INFO, level=2, overlay=None):
    drawn = picture.copy()
    (overlay or Overlay()).draw(drawn, info, _times(), level)
    return drawn


def _bounds(changed):
    """Return the first and last row and column that changed."""
    rows, columns = changed.any((1, 2)).nonzero()[0], changed.any((0, 2)).nonzero()[0]
    return rows[0], rows[-1], columns[0], columns[-1]


def _luminance(codes):
    """Relative luminance as in WCAG 2."""
    return srgb_to_linear(np.asarray(codes) / 255) @ np.array([0.2126, 0.7152, 0.0722])


def test_level_0_leaves_the_picture_alone():
    picture = _picture()
    assert (_drawn(picture, level=0) == picture).all()


@pytest.mark.parametrize("level", [1, 2])
def test_the_panel_is_in_the_corner_and_all_else_is_untouched(level):
    picture = _picture()
    changed = _drawn(picture, level=level) != picture
    top, bottom, left, right = _bounds(changed)
    assert 0 < top < 20
    assert 0 < left < 20
    assert bottom < 300
    assert right < 260
    assert changed.any(-1)[top:bottom, left:right].mean() > 0.98
    assert not changed[..., 3].any()  # stays opaque


def test_the_graph_makes_the_panel_higher():
    picture = _picture()
    lower, higher = (_bounds(_drawn(picture, level=level) != picture)[1] for level in (1, 2))
    assert higher > lower + 40


def test_the_graph_shows_each_frame_although_numbers_wait():
    picture = _picture(value=0)
    overlay, times = Overlay(clock=lambda: 1.0), _times()
    first, second = picture.copy(), picture.copy()
    overlay.draw(first, INFO, times, 2)
    times.add(0.04)
    overlay.draw(second, dataclasses.replace(INFO, frame_seconds=0.04), times, 2)
    top, *_ = _bounds(first != second)
    assert top > 150


def test_numbers_are_written_when_due_and_changes_at_once(monkeypatch):
    written = []
    monkeypatch.setattr("glimt.viewer.overlay.overlay.frame_panel",
                        lambda info, *rest: written.append(info) or frame_panel.frame_panel(info, *rest))
    now = [5.0]
    overlay, times, picture = Overlay(clock=lambda: now[0]), _times(), _picture()
    for frame in range(120):
        overlay.draw(picture, dataclasses.replace(INFO, frame_seconds=0.01 + frame * 1e-4, rays=frame), times, 2)
        now[0] += 1 / 60
    assert 10 <= len(written) <= 2 / REFRESH_SECONDS + 1
    for change in ({"paused": True}, {"mode": "orbit"}, {"debug_view": "normals"}, {"samples": 4}, {"lights": 4}):
        before = len(written)
        overlay.draw(picture, dataclasses.replace(INFO, **change), times, 2)
        assert len(written) == before + 1


@pytest.mark.parametrize("kind", NOTICES)
@pytest.mark.parametrize("level", [0, 2])
def test_notices_show_at_once_and_only_while_they_are_told(kind, level):
    picture = _picture()
    overlay = Overlay(clock=lambda: 1.0)
    without = _drawn(picture, level=level, overlay=overlay)
    shown = _drawn(picture, dataclasses.replace(INFO, **{kind: NOTICES[kind]}), level, overlay)
    other = _drawn(picture, dataclasses.replace(INFO, **{kind: "another"}), level, overlay)
    assert _bounds(shown != without)[0] > 500
    assert (other != shown).any()
    assert (_drawn(picture, level=level, overlay=overlay) == without).all()


def test_notices_do_not_cover_each_other():
    picture = _picture(value=0)
    drawn = _drawn(picture, dataclasses.replace(INFO, **NOTICES), 0)[..., :3].any((1, 2))
    assert (np.diff(drawn.astype(int)) == 1).sum() == 3  # three panels with rows between that nothing is drawn in


def test_an_error_is_red_wraps_and_has_at_most_a_third():
    picture = _picture(400, 400, value=128)
    for words, lines in ((3, 1), (20, 2), (5000, 5)):
        drawn = _drawn(picture, dataclasses.replace(INFO, error="word " * words), 0)
        top, bottom, *_ = _bounds(drawn != picture)
        assert bottom - top <= 400 / 3
        assert bottom - top >= 14 * lines
        panel_color = np.median(drawn[top:bottom, 20:60].reshape(-1, 4), 0)
        assert panel_color[0] > 2 * panel_color[1]


@pytest.mark.parametrize("value", [0, 128, 255])
@pytest.mark.parametrize("color", [panel.BRIGHT, panel.DIM, panel.ACCENT])
def test_text_is_legible_on_any_picture(value, color):
    """Contrast of 4.5 to 1 is what WCAG 2 asks of small text."""
    picture = _picture(40, 200, value)
    blank = panel.Panel(200, 40, 6)
    blank.draw(picture, 0, 0)
    ground = picture[20, 100, :3]
    blank.write("MMMM", 10, 5, 26, color)
    picture = _picture(40, 200, value)
    blank.draw(picture, 0, 0)
    inked = np.zeros((40, 200), bool)
    mask = text_mask("MMMM", 26)
    inked[5:5 + mask.shape[0], 10:10 + mask.shape[1]] = mask == 255
    light, dark = _luminance(picture[inked][:, :3].mean(0)), _luminance(ground)
    assert (light + 0.05) / (dark + 0.05) >= 4.5


@pytest.mark.parametrize("value", [0, 255])
def test_headline_and_bars_are_seen_on_black_and_white(value):
    drawn = _drawn(_picture(value=value))
    light = _luminance(drawn[20:240, 20:200, :3])
    assert np.percentile(light, 99) > 0.5
    assert np.percentile(light, 30) < 0.08


@pytest.mark.parametrize("shape", TINY)
def test_tiny_pictures_hold_what_fits(shape):
    for level in (0, 1, 2):
        for given in ({}, *({name: text} for name, text in NOTICES.items()), NOTICES):
            picture = _picture(*shape)
            _drawn(picture, dataclasses.replace(INFO, **given), level)
    Overlay().draw_help(_picture(*shape), TABLE)


def test_a_terminal_sees_the_frame_time_and_that_there_is_an_error():
    picture = _picture(60, 100, value=255)
    assert (_drawn(picture) != picture).any()
    drawn = _drawn(picture, dataclasses.replace(INFO, error=NOTICES["error"]))
    assert (drawn[..., 0] > 2.0 * drawn[..., 1]).sum() > 300


@pytest.mark.parametrize("shape", [(400, 400), (720, 1280), (200, 900), (900, 200)])
def test_panels_stay_within_the_picture_and_apart(shape):
    picture = _picture(*shape, value=0)
    notices = _drawn(picture, dataclasses.replace(INFO, **NOTICES), 0)[..., :3].any(-1)
    numbers = _drawn(picture, dataclasses.replace(INFO, **NOTICES), 2)[..., :3].any(-1) & ~notices
    if numbers.any():
        assert numbers.any(1).nonzero()[0][-1] < notices.any(1).nonzero()[0][0]


def test_help_is_centred_and_says_when_it_cannot_be_shown():
    picture = _picture(value=255)
    drawn = picture.copy()
    assert Overlay().draw_help(drawn, TABLE)
    top, bottom, left, right = _bounds(drawn != picture)
    assert abs(top - (719 - bottom)) <= 1
    assert abs(left - (1279 - right)) <= 1
    assert not Overlay().draw_help(_picture(30, 40), TABLE)


def test_text_grows_with_the_canvas():
    assert [text_size(rows, rows) for rows in (60, 400, 720, 1080, 2160)] == [11, 11, 13, 13, 26]
    assert text_size(2160, 2160, pixel_ratio=2) == 26
    assert text_size(540, 1080) == 9  # is shown twice as large, but has to be read in the picture
    assert text_size(1080, 2160) == 13


def test_scale_and_mode_are_told():
    rows = dict(pair for row in frame_panel.detail_rows(dataclasses.replace(INFO, paused=True, debug_view="normals"))
                for pair in row)
    assert rows["size"] == "640×360 · 50 %"
    assert rows["mode"] == "fly · normals · paused"
    assert rows["Mrays/s"] == "122.0"
    assert rows["triangles"] == "144,046"
    assert frame_panel.headline(INFO) == ("12.3 ms", "80 fps")
    assert frame_panel.headline(dataclasses.replace(INFO, frame_seconds=0.25, p50=0.25)) == ("250 ms", "4.0 fps")


def test_what_computes_and_its_stages_are_told():
    info = dataclasses.replace(INFO, engine="a GPU", stages={"create_rays": 0.00042, "shade": 0.0123})
    rows = frame_panel.detail_rows(info)
    assert rows[-3:] == [(("engine", "a GPU"),), (("create rays", "0.4 ms"),), (("shade", "12.3 ms"),)]
    assert rows[:-3] == frame_panel.detail_rows(INFO)


def test_before_the_first_frame_all_is_zero():
    start = dataclasses.replace(INFO, frame_seconds=0.0, p50=0.0, p95=0.0, rays=0, shown_height=0)
    drawn = _picture()
    Overlay().draw(drawn, start, FrameTimes(), 2)
    assert frame_panel.headline(start) == ("0.0 ms", "0.0 fps")


def test_blending_is_right_to_one_code():
    picture = _picture(64, 64)
    before = picture[..., :3].astype(float)
    one = panel.Panel(40, 40, 0, (200, 100, 0), 0.3)
    one.fill(0, 20, 40, 20, (0, 255, 10), 0.5)
    one.draw(picture, 10, -5)
    expected = before.copy()
    expected[:35, 10:50] = 0.7 * before[:35, 10:50] + 0.3 * np.array([200, 100, 0])
    expected[15:35, 10:50] = 0.5 * expected[15:35, 10:50] + 0.5 * np.array([0, 255, 10])
    assert np.abs(picture[..., :3] - expected).max() <= 1.5
    assert (picture[..., 3] == 255).all()


@pytest.mark.parametrize("picture", [np.zeros((9, 9, 3), np.uint8), np.zeros((9, 9, 4)),
                                     np.zeros((9, 18, 4), np.uint8)[:, ::2]])
def test_another_kind_of_picture_is_refused(picture):
    with pytest.raises(GlimtError, match="expected contiguous uint8"):
        Overlay().draw(picture, INFO, _times(), 1)


def test_blocks_are_kept_one_of_a_kind():
    overlay, picture = Overlay(), _picture(200, 300)
    for number in range(300):
        overlay.draw(picture, dataclasses.replace(INFO, message=f"light added: {number}", error=f"line {number}"),
                     _times(3), 0)
    assert len(overlay._kept) == 2
    assert panel._empty.cache_info().currsize <= panel._empty.cache_info().maxsize <= 8
