"""A study as one HTML file that needs nothing else: no script, no network."""

import base64
from collections.abc import Callable, Sequence
from html import escape
from importlib.resources import files

from glimt.study import plots
from glimt.study.results import Figure, Number, Series, StudyResult

Named = Sequence[tuple[str, StudyResult]]
"""One study with "" for its name, or some to be compared, each with what tells it apart."""

_METHOD = (
    "The settings of a figure are timed in turn, in an order drawn anew for each round, so that a machine whose speed "
    "drifts draws no slope; the times of a round are divided by how slow the whole round was. A point is the median "
    "of its rounds with a {confidence:.0%} interval (bootstrap over rounds); every frame that was timed is a dot. Laws "
    "are fitted with deviations as shares of the time; their intervals come from resampling rounds and what the law "
    "leaves over. A law is chosen by Schwarz's criterion, a line where R² is 0.98 or more and the exponent agrees.")


def report(result: StudyResult) -> str:
    """Return the report of one study."""
    named = [("", result)]
    found = [f"<li><a href='#figure-{figure.number}'>Figure {figure.number}, {escape(figure.title.lower())}</a>: "
             f"{escape(series.name)}. {escape(series.verdict)}</li>"
             for figure in result.figures for series in figure.series if series.verdict]
    body = [f"<h1>What the frame time of {escape(result.scene.name)} depends on</h1>",
            f"<p>Around a base configuration of {escape(result.base)}, one thing at a time is varied.</p>",
            "<h2>In short</h2>", f"<ul>{''.join(found)}</ul>",
            *(_figure([("", figure)]) for figure in result.figures),
            "<h2>How it was measured</h2>", f"<p>{escape(_METHOD.format(confidence=result.confidence))}</p>",
            "<h2>Machine</h2>", _machines(named)]
    return _page(f"Frame time of {result.scene.name}", body)


def comparison(named: Named) -> str:
    """Return the report of two studies: each figure in one plot, and the ratio of every setting's times."""
    (first, before), (second, after) = named
    body = [f"<h1>{escape(first)} and {escape(second)}</h1>",
            "<p>Ratios are times of the second study through those of the first. Two runs were not timed in turn: a "
            "machine's drift between them is part of every ratio.</p>"]
    if before.scene.sha256 != after.scene.sha256:
        body.append("<p class='warning'>The two studies are about different scenes.</p>")
    for figure in before.figures:
        other = after.figure(figure.number)
        if other is None:
            body.append(f"<p>Figure {figure.number} is only in {escape(first)}.</p>")
        else:
            body += [_figure([(first, figure), (second, other)]), _ratios(figure, other)]
    body += [f"<p>Figure {figure.number} is only in {escape(second)}.</p>" for figure in after.figures
             if before.figure(figure.number) is None]
    return _page(f"{first} and {second}", [*body, "<h2>Machines</h2>", _machines(named)])


def _figure(named: Sequence[tuple[str, Figure]]) -> str:
    """Return the section of one figure, of one study or of some."""
    figure = named[0][1]
    parts = [f"<section id='figure-{figure.number}'><h2>Figure {figure.number}. {escape(figure.title)}</h2>"]
    drawn = [(label, each) for label, each in named if each.series]
    if drawn:
        data = base64.b64encode(plots.svg(drawn).encode()).decode()
        parts.append(f"<img alt='Frame time by {escape(figure.x_title)}' src='data:image/svg+xml;base64,{data}'>")
    for label, each in named:
        owner = f"{escape(label)}, " if label else ""
        parts += [f"<p><b>{owner}{escape(series.name)}.</b> {escape(series.verdict)}</p>" for series in each.series]
        parts += [f"<p class='warning'>{owner}{escape(note)}</p>" for note in each.notes]
        if not each.complete:
            parts.append(f"<p class='warning'>{owner}interrupted after {each.rounds} rounds.</p>")
    if figure.paper:
        parts.append(f"<p class='paper'>The paper: {escape(figure.paper)}.</p>")
    if len(named) == 1:
        parts += [_table(series) for series in figure.series]
        parts.append(f"<p class='small'>{figure.rounds} rounds.</p>")
    return "".join([*parts, "</section>"])


def _table(series: Series) -> str:
    stages = list(dict.fromkeys(stage for point in series.points for stage in point.stages_ms))
    rows = [[point.label, _ms(point.ms), f"{point.rays.primary:,}", f"{point.rays.shadow:,}",
             f"{point.rays.mirror:,}", f"{point.rays_per_second / 1e6:.1f}",
             *(f"{point.stages_ms.get(stage, 0):.2f}" for stage in stages)] for point in series.points]
    heads = [series.name, "ms", "camera rays", "shadow rays", "mirror rays", "Mrays/s", *stages]
    laws = [[law.law, ", ".join(f"{name} {_number(number)}" for name, number in law.numbers.items()), f"{law.r2:.4f}",
             f"{law.deviation:.1%}"] for law in series.laws]
    fitted = _rows(["law", "numbers (ms)", "R²", "deviation"], laws) if laws else ""
    return f"<details><summary>Numbers of {escape(series.name)}</summary>{_rows(heads, rows)}{fitted}</details>"


def _ratios(before: Figure, after: Figure) -> str:
    rows = []
    for series in before.series:
        other = next((each for each in after.series if each.name == series.name), None)
        points = {point.label: point for point in other.points} if other else {}
        rows += [[series.name, point.label, _ms(point.ms), _ms(points[point.label].ms),
                  f"{points[point.label].ms.value / point.ms.value:.2f}"]
                 for point in series.points if point.label in points]
    return _rows(["series", "setting", "ms", "ms, second", "ratio"], rows)


def _machines(named: Named) -> str:
    facts: dict[str, Callable[[StudyResult], str]] = {
        "scene": lambda each: f"{each.scene.name}, {each.scene.triangles:,} triangles, SHA-256 {each.scene.sha256}",
        "processor": lambda each: each.machine.processor,
        "instruction sets": lambda each: f"{', '.join(each.machine.features)}; {each.machine.lanes} lanes",
        "cores, threads": lambda each: f"{each.machine.cores}, {each.machine.threads}",
        "clock": lambda each: f"{each.machine.clock_mhz:,.0f} MHz" if each.machine.clock_mhz else "not told",
        "engine": lambda each: each.engine.upper() + (f", {each.machine.adapter}" if each.machine.adapter else ""),
        "system": lambda each: each.machine.system,
        "versions": lambda each: ", ".join(f"{name} {text}" for name, text in each.machine.versions.items()),
        "command": lambda each: each.command,
        "begun": lambda each: each.created,
    }
    return _rows(["", *(label for label, _ in named)],
                 [[name, *(told(each) for _, each in named)] for name, told in facts.items()])


def _rows(heads: list[str], rows: list[list[str]]) -> str:
    head = "".join(f"<th>{escape(text)}</th>" for text in heads)
    lines = "".join(f"<tr>{''.join(f'<td>{escape(text)}</td>' for text in row)}</tr>" for row in rows)
    return f"<div class='wide'><table><thead><tr>{head}</tr></thead><tbody>{lines}</tbody></table></div>"


def _ms(number: Number) -> str:
    return f"{number.value:.2f} ({number.lo:.2f}–{number.hi:.2f})"


def _number(number: Number) -> str:
    return f"{number.value:.4g} ({number.lo:.4g}–{number.hi:.4g})"


def _page(title: str, body: list[str]) -> str:
    style = files("glimt.study").joinpath("report.css").read_text(encoding="utf-8")
    return ("<!doctype html><html lang='en'><head><meta charset='utf-8'><meta name='viewport' "
            "content='width=device-width, initial-scale=1'><link rel='icon' href='data:,'>"
            f"<title>{escape(title)}</title>"
            f"<style>{style}</style></head><body>{''.join(body)}</body></html>\n")
