"""Figures of a study as plots, for SVG and PNG."""

import io
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure as Plot
from matplotlib.ticker import FuncFormatter

from glimt.layout import STAGES
from glimt.study.laws import value_at
from glimt.study.results import Figure, Law, Point, Series

Named = Sequence[tuple[str, Figure]]
"""The same figure of one study, or of some with what tells them apart; "" for one alone."""

_COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#555555", "#a0522d")
"""Okabe and Ito's, which colour-blind people tell apart, and two more."""
_STAGE_COLORS = dict(zip(STAGES, _COLORS, strict=False))
_STYLE: Any = {"font.size": 10, "axes.grid": True, "axes.axisbelow": True, "grid.alpha": 0.3, "axes.spines.top": False,
               "axes.spines.right": False, "svg.hashsalt": "glimt", "figure.facecolor": "white"}


def svg(named: Named) -> str:
    """Return a figure as the text of an SVG image; letters are outlines, so that it looks the same everywhere."""
    with io.StringIO() as text:
        _save(named, text, "svg")
        return text.getvalue()


def png(named: Named) -> bytes:
    """Return a figure as a PNG image, 1,200 pixels wide."""
    with io.BytesIO() as data:
        _save(named, data, "png")
        return data.getvalue()


def _save(named: Named, target: Any, form: str) -> None:
    with rc_context(_STYLE):
        plot = _draw(named)
        plot.savefig(target, format=form, dpi=150, metadata={"Date": None} if form == "svg" else None)


def _draw(named: Named) -> Plot:
    kind = named[0][1].kind
    if kind == "curve":
        return _curves(named)
    rows = [(label, point) for label, figure in named for series in figure.series for point in series.points]
    plot = Plot(figsize=(8, 1.2 + 0.34 * max(3, len(rows))), layout="constrained")
    axes = plot.add_subplot()
    (_bars if kind == "bars" else _stacks)(axes, rows)
    axes.set_yticks(range(len(rows)), [_name(label, point.label) for label, point in rows])
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.set_xlim(left=0)
    axes.set_xlabel("frame time, ms (95 % interval)")
    axes.set_title(named[0][1].title, loc="left", pad=28 if kind == "stages" else None)
    return plot


def _curves(named: Named) -> Plot:
    """Draw frame times with their intervals, all that was measured and the law; below, rays a second."""
    plot = Plot(figsize=(8, 6), layout="constrained")
    above, below = plot.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    figure = named[0][1]
    drawn = [(_name(label, series.name), series) for label, each in named for series in each.series]
    for (name, series), color in zip(drawn, _COLORS * (1 + len(drawn) // len(_COLORS)), strict=False):
        _curve(above, name, series, color, figure.log)
        x = [point.x for point in series.points]
        below.plot(x, [point.rays_per_second / 1e6 for point in series.points], "o-", color=color, markersize=3)
    if figure.log:
        above.set_xscale("log")
        above.set_yscale("log")
        above.yaxis.set_major_formatter(FuncFormatter(lambda value, place: f"{value:g}"))
        above.yaxis.set_minor_formatter(FuncFormatter(_minor_label))
        above.xaxis.set_major_formatter(FuncFormatter(lambda value, place: f"{value:,.0f}"))
    else:
        above.set_xlim(left=0)
        above.set_ylim(bottom=0)
    above.set_ylabel("frame time, ms (95 % interval)")
    above.set_title(figure.title, loc="left")
    above.legend(frameon=False, fontsize=9)
    below.set_ylim(bottom=0)
    below.set_ylabel("Mrays/s")
    below.set_xlabel(figure.x_title)
    return plot


def _minor_label(value: float, place: int | None) -> str:
    """Return the label of a tick between powers of ten, where there is room for one."""
    del place
    text = f"{value:g}"
    return text if text.lstrip("0.")[:1] in "25" else ""


def _curve(axes: Any, name: str, series: Series, color: str, log: bool) -> None:
    x = np.array([point.x for point in series.points])
    ms = [point.ms for point in series.points]
    middle = np.array([each.value for each in ms])
    bars = [middle - [each.lo for each in ms], [each.hi for each in ms] - middle]
    for point in series.points:  # all that was measured: outliers too
        times = [time for block in point.times_ms for time in block]
        axes.plot([point.x] * len(times), times, ".", color=color, alpha=0.15, markersize=3, zorder=1)
    law = series.fitted(series.law) if series.law else None
    axes.errorbar(x, middle, bars, fmt="o", color=color, markersize=4, capsize=2, zorder=3, label=_legend(name, law))
    if law is not None:
        finely = np.geomspace(x.min(), x.max(), 200) if log else np.linspace(x.min(), x.max(), 200)
        numbers = {key: number.value for key, number in law.numbers.items()}
        axes.plot(finely, value_at(law.law, numbers, finely), "-", color=color, alpha=0.7, linewidth=1.2, zorder=2)


def _legend(name: str, law: Law | None) -> str:
    if law is None:
        return name
    exponent = law.numbers.get("exponent")
    return f"{name}: {law.law}{f', exponent {exponent.value:.2f}' if exponent else ''}"


def _bars(axes: Any, rows: list[tuple[str, Point]]) -> None:
    for place, (_, point) in enumerate(rows):
        axes.barh(place, point.ms.value, color=_COLORS[0], alpha=0.75)
        times = [time for block in point.times_ms for time in block]
        axes.plot(times, [place] * len(times), ".", color=_COLORS[0], alpha=0.15, markersize=3)
        axes.errorbar(point.ms.value, place, xerr=[[point.ms.value - point.ms.lo], [point.ms.hi - point.ms.value]],
                      color="black", capsize=3)


def _stacks(axes: Any, rows: list[tuple[str, Point]]) -> None:
    for place, (_, point) in enumerate(rows):
        left = 0.0
        for stage in [name for name in STAGES if name in point.stages_ms]:
            axes.barh(place, point.stages_ms[stage], left=left, color=_STAGE_COLORS[stage],
                      label=stage if place == 0 else None)
            left += point.stages_ms[stage]
        if point.ms.value > 1.005 * left:
            axes.barh(place, point.ms.value - left, left=left, color="#cccccc", label="rest" if place == 0 else None)
    axes.legend(frameon=False, fontsize=9, ncols=len(STAGES) + 1, loc="lower left", bbox_to_anchor=(0.0, 1.0),
                borderaxespad=0.2)


def _name(label: str, name: str) -> str:
    return " · ".join(part for part in (name, label) if part)
