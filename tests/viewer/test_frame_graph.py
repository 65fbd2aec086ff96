"""Bars are as high as frames took, and coloured by what a frame may take."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from glimt.viewer.overlay.frame_graph import COLORS, axis_top, bar_rows, budget_color, draw_bars, line_row

BUDGET = 1 / 60
times_of = st.lists(st.floats(0, 100), max_size=240).map(np.array)


def _bars(times, top, rows=60, columns=200, thickness=1):
    """Return what was drawn, without its lines: the colour's number + 1 of each pixel, or 0."""
    area = np.zeros((rows, columns, 4), np.uint8)
    draw_bars(area, times, top, BUDGET, thickness)
    found = np.zeros((rows, columns), int)
    for number, color in enumerate(COLORS):
        found[(area == (*color, 255)).all(-1)] = number + 1
    lines = [line_row(seconds, top, rows) for seconds in (BUDGET, 2 * BUDGET) if seconds < top]
    for row in lines:
        assert (area[row, :, 3] == 255).all()
        found[row:row + thickness] = -1
    return found


@pytest.mark.parametrize("thickness", [1, 2, 3])
def test_heights_and_colors_match_the_times(thickness):
    times = np.array([0.001, 0.010, 0.016, BUDGET, 0.02, 0.033, 0.04, 0.049, 0.2])
    found = _bars(times, 0.05, thickness=thickness)
    for place, seconds in enumerate(reversed(times)):
        first = 200 - (place + 1) * thickness
        columns = found[:, first:first + thickness]
        rows = bar_rows(np.array([seconds]), 0.05, 60)[0]
        assert abs(rows - min(60 * seconds / 0.05, 60)) <= 0.5 or rows == 1
        number = 1 + (seconds > 1.05 * BUDGET) + (seconds > 2.1 * BUDGET)
        drawn = np.where(np.arange(60)[:, None] >= 60 - rows, number, 0)
        assert ((columns == drawn) | (columns == -1)).all()
    assert (found[:, :200 - len(times) * thickness] <= 0).all()


def test_only_as_many_bars_as_there_are_columns_the_newest_on_the_right():
    found = _bars(np.append(np.full(300, 0.01), 0.1), 0.05)
    assert (found[-1, :-1] == 1).all()
    assert found[-1, -1] == 3


def test_no_times_are_no_bars():
    assert (_bars(np.zeros(0), axis_top(np.zeros(0), BUDGET)) <= 0).all()


@given(times_of)
def test_the_axis_is_round_and_holds_nearly_all_frames(times):
    top = axis_top(times, BUDGET)
    assert top >= 1.1 * BUDGET
    digits = f"{top:.6e}".split("e")[0]
    assert float(digits) in (1, 2, 5, 2.5)
    assert (times > top).sum() <= max(0.05 * len(times) + 1, 1)
    usual = np.sort(times)[: int(0.95 * (len(times) - 1)) + 1] if len(times) else [0]
    assert top <= max(0.025, 2.5 * 1.1 * max(usual) * 1.0001)


def test_a_display_that_keeps_to_its_clock_is_in_time():
    assert [budget_color(seconds, BUDGET) for seconds in (0, BUDGET * 1.03, BUDGET * 2.05, BUDGET * 2.2)] == [
        COLORS[0], COLORS[0], COLORS[1], COLORS[2]]
