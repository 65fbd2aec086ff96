"""The graph of frame times: a bar a frame, written straight into the picture."""

import bisect

import numpy as np
from numpy.typing import NDArray

from glimt.viewer.overlay.panel import Color

COLORS: tuple[Color, ...] = ((104, 205, 134), (245, 190, 84), (242, 106, 98))
"""Of a frame within the budget, within two, and beyond."""
_PIXELS = np.array([(*color, 255) for color in COLORS], np.uint8).view(np.uint32)[:, 0]
_LINE = np.array([225, 228, 234, 255], np.uint8).view(np.uint32)[0]
_LIMITS = np.array([1.05, 2.1])  # budgets; a display's clock is not exact
_LEAST_BUDGETS = 1.5


def axis_top(times: NDArray[np.float64], budget: float) -> float:
    """Return the seconds at the upper end of the axis: at least 1.5 budgets, else 1, 2 or 5 times a power of ten.

    One frame in twenty may go beyond, so that a single late one does not flatten all others.
    """
    place = int(0.95 * (len(times) - 1))
    usual = min(1.1 * float(np.partition(times, place)[place]), 1e6) if len(times) else 0.0
    if usual <= _LEAST_BUDGETS * budget:
        return _LEAST_BUDGETS * budget
    power = 10.0 ** np.floor(np.log10(usual))
    return float(next(step * power for step in (1, 2, 5, 10) if step * power >= usual))


def budget_color(seconds: float, budget: float) -> Color:
    """Return the colour of a bar."""
    return COLORS[bisect.bisect_left(_LIMITS, seconds / budget)]


def bar_rows(times: NDArray[np.float64], top: float, rows: int) -> NDArray[np.int64]:
    """Return the height of each bar, 1 to `rows`, that stands for a time on an axis from 0 to `top`."""
    return np.clip(np.rint(times * (rows / top)), 1, rows).astype(np.int64)


def draw_bars(area: NDArray[np.uint8], times: NDArray[np.float64], top: float, budget: float,
              thickness: int = 1) -> None:
    """Draw the last frame times into a rectangle of the picture, and lines at one and two budgets.

    Parameters
    ----------
    area : (h, w, 4) uint8
        RGBA; what is above the bars is left as it is.
    times : (n,) float64
        Seconds, oldest first; the newest is on the right.
    top : float
        Seconds at the upper edge; a bar that goes beyond ends there.
    budget : float
        Seconds that a frame may take.
    thickness : int
        Columns of a bar and rows of a line.
    """
    pixels = area.view(np.uint32)[..., 0]
    rows = len(pixels)
    times = times[-(pixels.shape[1] // thickness):]
    if len(times):
        colors = _PIXELS[np.searchsorted(_LIMITS * budget, times)].repeat(thickness)
        heights = bar_rows(times, top, rows).repeat(thickness)
        covered = np.arange(rows, 0, -1)[:, None] <= heights
        np.copyto(pixels[:, -len(colors):], colors, where=covered)
    for seconds in (budget, 2 * budget):
        if seconds < top:
            row = line_row(seconds, top, rows)
            pixels[row:row + thickness] = _LINE


def line_row(seconds: float, top: float, rows: int) -> int:
    """Return the row of a time on the axis."""
    return rows - 1 - int((rows - 1) * seconds / top)
