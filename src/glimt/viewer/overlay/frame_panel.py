"""The panel in the corner: how fast it runs and what is drawn."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from glimt.viewer.overlay.frame_graph import axis_top, budget_color, draw_bars, line_row
from glimt.viewer.overlay.frame_info import FrameInfo, samples_text
from glimt.viewer.overlay.glyph import line_height
from glimt.viewer.overlay.panel import BRIGHT, DIM, Panel
from glimt.viewer.overlay.text import LEGIBLE, shorten, text_width

Row = tuple[tuple[str, str], ...]
"""One or two pairs of a label and a value."""
_USUAL_TIME = "00.0 ms"  # has its place, so that shorter ones end where it does


@dataclass(frozen=True)
class Graph:
    """Where the graph is in the panel, its axis in seconds, and how many columns a bar has."""

    x: int
    y: int
    width: int
    height: int
    top: float
    budget: float
    thickness: int


@dataclass(frozen=True)
class FramePanel:
    """The panel, drawn, and its graph, which changes with each frame."""

    panel: Panel
    graph: Graph | None

    def draw(self, picture: NDArray[np.uint8], x: int, y: int, times: NDArray[np.float64]) -> None:
        """Blend into (h, w, 4) pixels with the top-left corner at column x, row y, and draw the bars."""
        self.panel.draw(picture, x, y)
        if self.graph is not None:
            left, top = x + self.graph.x, y + self.graph.y
            area = picture[top:top + self.graph.height, left:left + self.graph.width]
            draw_bars(area, times, self.graph.top, self.graph.budget, self.graph.thickness)


def milliseconds(seconds: float) -> str:
    """Return a time in milliseconds, as exact as it is worth."""
    value = 1000 * seconds
    return f"{value:.1f}" if value < 100 else f"{min(value, 999999):.0f}"


def headline(info: FrameInfo) -> tuple[str, str]:
    """Return the time of the last frame and the frames a second that recent ones make."""
    rate = 1 / info.p50 if info.p50 > 0 else 0.0
    return f"{milliseconds(info.frame_seconds)} ms", f"{rate:.0f} fps" if rate >= 10 else f"{rate:.1f} fps"


def detail_rows(info: FrameInfo) -> list[Row]:
    """Return what is said below the headline, in order of weight."""
    mrays = info.rays / info.frame_seconds * 1e-6 if info.frame_seconds > 0 else 0.0
    scale = 100 * info.height / info.shown_height if info.shown_height else 100.0
    mode = " · ".join([info.mode, *([info.debug_view] if info.debug_view else []), *(["paused"] * info.paused)])
    return [
        (("p50", milliseconds(info.p50)), ("p95", milliseconds(info.p95))),
        (("Mrays/s", f"{mrays:.1f}"),),
        (("size", f"{info.width}×{info.height} · {scale:.0f} %"),),
        (("mode", mode),),
        (("bounces", str(info.max_bounces)), ("lights", str(info.lights))),
        (("samples", samples_text(info.samples)),),
        (("triangles", f"{info.triangles:,}"),),
        *([(("engine", info.engine),)] if info.engine else []),
        *(((stage.replace("_", " "), f"{milliseconds(seconds)} ms"),) for stage, seconds in info.stages.items()),
    ]


def frame_panel(info: FrameInfo, times: NDArray[np.float64], size: int, room: tuple[int, int],
                with_graph: bool) -> FramePanel | None:
    """Draw the panel, with the rows that fit.

    Parameters
    ----------
    info : FrameInfo
    times : (n,) float64
        Seconds, for the axis of the graph.
    size : int
        Pixels of an em.
    room : pair of int
        Columns and rows that the panel may have; None is returned when not even the headline fits.
    with_graph : bool
        Whether a place for the graph is left.
    """
    padding, large = round(0.75 * size), round(1.55 * size)
    time, rate = headline(info)
    width = 2 * padding + round(14.5 * size)
    row_height = line_height(size) + round(0.22 * size)
    spare = room[1] - 2 * padding - line_height(large) - round(0.3 * size)
    if room[0] < width or spare < 0:
        return _small_panel(time, size, room)
    graph_height = round(4.6 * size)
    with_graph = with_graph and spare >= graph_height + padding
    rows = detail_rows(info)[:max((spare - with_graph * (graph_height + padding)) // row_height, 0)]
    graph_top = padding + line_height(large) + round(0.3 * size) + len(rows) * row_height + round(0.5 * padding)
    height = graph_top + padding + graph_height if with_graph else graph_top + round(0.5 * padding)
    panel = Panel(width, height, 0.6 * size)
    time_end = padding + max(text_width(_USUAL_TIME, large), text_width(time, large))
    panel.write(time, time_end, padding - round(0.2 * size), large, align=1)
    panel.write(rate, width - padding, padding - round(0.2 * size), large, budget_color(info.p50, info.budget), align=1)
    for place, row in enumerate(rows):
        _write_row(panel, row, padding, graph_top - round(0.5 * padding) - (len(rows) - place) * row_height, size)
    graph = None
    if with_graph:
        thickness = max(round(size / 13), 1)
        columns = width - 2 * padding - text_width("0000", max(round(0.85 * size), LEGIBLE))
        graph = Graph(padding, graph_top, columns - columns % thickness, graph_height, axis_top(times, info.budget),
                      info.budget, thickness)
        _draw_axis(panel, graph, size)
    return FramePanel(panel, graph)


def _small_panel(time: str, size: int, room: tuple[int, int]) -> FramePanel | None:
    """Return a panel with nothing but the time of the last frame."""
    padding = max(round(0.3 * size), 2)
    width = max(text_width(_USUAL_TIME, size), text_width(time, size)) + 2 * padding
    height = line_height(size) + 2 * padding
    if width > room[0] or height > room[1]:
        return None
    panel = Panel(width, height, 0.4 * size)
    panel.write(time, width - padding, padding, size, align=1)
    return FramePanel(panel, None)


def _write_row(panel: Panel, row: Row, padding: int, y: int, size: int) -> None:
    """Write labels on the left and values on the right of each part of a row."""
    gap = 2 * padding if len(row) > 1 else 0
    part = (panel.width - 2 * padding - gap) // len(row)
    for place, (label, value) in enumerate(row):
        x = padding + place * (part + gap)
        panel.write(label, x, y, size, DIM)
        room = part - text_width(label + " ", size)
        panel.write(shorten(value, size, room), x + part, y, size, BRIGHT, align=1)


def _draw_axis(panel: Panel, graph: Graph, size: int) -> None:
    """Darken the place of the graph and write the milliseconds of its upper end and its lines beside it."""
    panel.fill(graph.x, graph.y, graph.width, graph.height, (0, 0, 0), 0.35)
    free, small = 0, max(round(0.85 * size), LEGIBLE)
    marks = [(line_row(seconds, graph.top, graph.height), f"{1000 * seconds:.0f}")
             for seconds in (graph.top, 2 * graph.budget, graph.budget) if seconds <= graph.top]
    for row, label in (*marks, (graph.height, "ms")):
        y = min(max(row - line_height(small) // 2, 0), graph.height - line_height(small) + small // 5)
        if y >= free:
            panel.write(label, panel.width - graph.x, graph.y + y - small // 5, small, DIM, align=1)
            free = y + small
