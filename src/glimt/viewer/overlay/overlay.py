"""What is drawn over the viewer's picture: numbers, the graph of frame times, notices, errors and the help screen."""

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from glimt.errors import GlimtError
from glimt.viewer.overlay.frame_info import FrameInfo
from glimt.viewer.overlay.frame_panel import FramePanel, frame_panel
from glimt.viewer.overlay.frame_times import FrameTimes
from glimt.viewer.overlay.glyph import line_height
from glimt.viewer.overlay.help_screen import Table, help_layout, help_panel
from glimt.viewer.overlay.panel import BRIGHT, DARK, OPACITY, RED, Color, Panel
from glimt.viewer.overlay.text import LEGIBLE, text_width, wrap

__all__ = ["FrameInfo", "Overlay", "text_size"]

REFRESH_SECONDS = 1 / 6
"""Numbers that change with each frame are written anew this often: more could neither be read nor paid for."""
_POINTS = 13
_LARGER_HELP = 1.15  # who asks for help wants to read
_LARGEST_SHARE = 3  # an error has at most a third of the picture, or else a line


def text_size(rows: int, shown_rows: int, pixel_ratio: float = 1.0) -> int:
    """Return the pixels of an em, in a picture of `rows` that is shown on `shown_rows` pixels of a canvas.

    13 logical pixels, fewer on canvases below 480 rows, more above 1080; never below what is legible in the picture.
    """
    shown_rows = shown_rows or rows
    logical_rows = shown_rows / pixel_ratio
    points = _POINTS * min(max(logical_rows / 480, 0.85), 1.0) * max(logical_rows / 1080, 1.0)
    return max(round(points * pixel_ratio * rows / shown_rows), LEGIBLE)


class Overlay:
    """Draws over pictures and keeps what it drew until something changes.

    Parameters
    ----------
    pixel_ratio : float
        Pixels of the canvas for one logical pixel.
    clock : callable
        Returns seconds.
    """

    def __init__(self, pixel_ratio: float = 1.0, clock: Callable[[], float] = time.perf_counter) -> None:
        self.pixel_ratio = pixel_ratio
        self._clock = clock
        self._frame_panel: FramePanel | None = None
        self._frame_panel_key: object = None
        self._written_at = -np.inf
        self._kept: dict[str, tuple[object, Panel | None]] = {}  # a panel of each kind, and what it was made from

    def draw(self, picture: NDArray[np.uint8], info: FrameInfo, times: FrameTimes, level: int) -> None:
        """Blend into a picture, in place.

        Parameters
        ----------
        picture : (h, w, 4) uint8
            RGBA, row 0 on top, C-contiguous.
        info : FrameInfo
        times : FrameTimes
        level : int
            0: only errors, notices and what was picked; 1: numbers too; 2: and the graph of frame times.

        Raises
        ------
        GlimtError
            The picture is of another kind.
        """
        if level <= 0 and not (info.message or info.error or info.picked):
            return
        _check(picture)
        size = text_size(picture.shape[0], info.shown_height, self.pixel_ratio)
        margin = round(0.6 * size)
        bottom = self._draw_notices(picture, info, size, margin)
        if level > 0:
            room = picture.shape[1] - 2 * margin, bottom - 2 * margin
            panel = self._current_frame_panel(info, times, size, room, level > 1)
            if panel is not None:
                panel.draw(picture, margin, margin, times.array())

    def draw_help(self, picture: NDArray[np.uint8], table: Table) -> bool:
        """Blend the help screen into the middle of a picture, in place, and return whether anything of it fits.

        Parameters
        ----------
        picture : (h, w, 4) uint8
            RGBA, row 0 on top, C-contiguous.
        table : sequence of (group, keys, help)
        """
        _check(picture)
        rows, columns = picture.shape[:2]
        size = round(_LARGER_HELP * text_size(rows, rows, self.pixel_ratio))
        margin = round(0.6 * size)
        room = columns - 2 * margin, rows - 2 * margin
        panel = self._panel("help", _help_panel, tuple(table), size, room)
        if panel is not None:
            panel.draw(picture, (columns - panel.width) // 2, (rows - panel.height) // 2)
        return panel is not None

    def _draw_notices(self, picture: NDArray[np.uint8], info: FrameInfo, size: int, margin: int) -> int:
        """Draw what must be seen at once, from the bottom up, and return the row above which there is room."""
        rows, columns = picture.shape[:2]
        bottom: int = rows
        width = columns - 2 * margin
        for kind, text, color, opacity, align in (("error", info.error, RED, 0.88, 0.0),
                                                  ("message", info.message, DARK, OPACITY, 0.5),
                                                  ("picked", info.picked, DARK, OPACITY, 0.0)):
            room = min(max(rows // _LARGEST_SHARE, 2 * line_height(size)), bottom - 2 * margin)
            panel = self._panel(kind, _text_panel, text, size, (width, room), color, opacity) if text else None
            if panel is not None:
                bottom -= margin + panel.height
                panel.draw(picture, margin + round(align * (width - panel.width)), bottom)
        return bottom

    def _panel(self, kind: str, make: Callable[..., Panel | None], *arguments: object) -> Panel | None:
        """Return the panel of a kind, made anew if it is to be made from something else than last time."""
        kept = self._kept.get(kind)
        if kept is None or kept[0] != arguments:
            kept = self._kept[kind] = arguments, make(*arguments)
        return kept[1]

    def _current_frame_panel(self, info: FrameInfo, times: FrameTimes, size: int, room: tuple[int, int],
                             with_graph: bool) -> FramePanel | None:
        """Return the panel of numbers: at once after a change that somebody made, else when it is due."""
        key = (size, room, with_graph, info.shown_width, info.shown_height, info.max_bounces, info.lights, info.samples,
               info.triangles, info.mode, info.debug_view, info.paused)
        now = self._clock()
        if key != self._frame_panel_key or not 0 <= now - self._written_at < REFRESH_SECONDS:
            self._frame_panel = frame_panel(info, times.array(), size, room, with_graph)
            self._frame_panel_key, self._written_at = key, now
        return self._frame_panel


def _text_panel(text: str, size: int, room: tuple[int, int], color: Color, opacity: float) -> Panel | None:
    """Return a panel with a text, wrapped, in at most `room` columns and rows; None if not even a line fits."""
    padding = round(0.45 * size)
    line = line_height(size) + round(0.15 * size)
    most_lines = (room[1] - 2 * padding) // line
    if most_lines < 1 or room[0] - 2 * padding < 3 * size:
        return None
    lines = wrap(text, size, room[0] - 2 * padding, most_lines)
    if not lines:
        return None
    width = max(text_width(part, size) for part in lines) + 2 * padding
    panel = Panel(width, len(lines) * line + 2 * padding, 0.6 * size, color, opacity)
    for place, part in enumerate(lines):
        panel.write(part, padding, padding + place * line, size, BRIGHT)
    return panel


def _help_panel(table: Table, size: int, room: tuple[int, int]) -> Panel | None:
    """Return the help screen in at most `room` columns and rows; None if nothing of it fits."""
    layout = help_layout(table, size, room)
    return help_panel(layout) if layout is not None else None


def _check(picture: NDArray[np.uint8]) -> None:
    if picture.dtype != np.uint8 or picture.ndim != 3 or picture.shape[2] != 4 or not picture.flags.c_contiguous:
        raise GlimtError(f"the picture is {picture.dtype}, shape {picture.shape}, expected contiguous uint8, (h, w, 4)")
