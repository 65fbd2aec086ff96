"""The overlay as text."""

import dataclasses

import numpy as np
import pytest

from glimt.viewer.keys import help_table
from glimt.viewer.overlay import FrameInfo, FrameTimes
from glimt.viewer.overlay.text_overlay import TextOverlay, help_lines

INFO = FrameInfo(frame_seconds=0.0123, p50=0.01, p95=0.02, rays=1000, width=80, height=48, shown_width=80,
                 shown_height=48, max_bounces=2, lights=1, samples=2, triangles=1234, mode="fly")


def _text(level=1, with_help=False, **changes):
    overlay = TextOverlay()
    picture = np.full((48, 80, 4), 7, np.uint8)
    if with_help:
        assert overlay.draw_help(picture, help_table())
    overlay.draw(picture, dataclasses.replace(INFO, **changes), FrameTimes(), level)
    assert (picture == 7).all()
    return overlay.text


def test_numbers_are_a_line():
    line, = _text().notices
    for part in ("H keys", "12.3 ms", "100 fps", "bounces 2", "lights 1", "samples 2×2", "triangles 1,234"):
        assert part in line


def test_notices_are_told_at_every_level():
    text = _text(0, message="saved", picked="ball\nmaterial red", error="no such\nfile")
    assert text.notices == ("ball", "material red", "saved")
    assert text.error == "no such file"
    assert _text(0).notices == ()


def test_the_help_is_for_one_picture():
    overlay = TextOverlay()
    overlay.draw_help(np.zeros((1, 1, 4), np.uint8), help_table())
    for expected in (help_table(), None):
        overlay.draw(np.zeros((1, 1, 4), np.uint8), INFO, FrameTimes(), 1)
        assert overlay.text.help == expected


@pytest.mark.parametrize(("columns", "rows"), [(80, 23), (100, 40), (200, 60), (40, 60), (80, 200)])
def test_every_key_is_in_the_help(columns, rows):
    lines = help_lines(help_table(), columns, rows)
    assert len(lines) <= rows
    assert {len(line) for line in lines} == {columns}
    text = "\n".join(lines)
    for _, keys, help in help_table():
        assert f" {keys} " in text
        assert help[:15] in text


@pytest.mark.parametrize(("columns", "rows"), [(80, 10), (20, 23), (5, 2), (1, 1)])
def test_what_does_not_fit_is_not_hidden_in_silence(columns, rows):
    lines = help_lines(help_table(), columns, rows)
    assert len(lines) <= rows
    assert {len(line) for line in lines} == {columns}
    assert lines[-1].startswith("…")
