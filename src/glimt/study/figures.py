"""From measured settings to a figure: points, laws and what follows from them."""

import numpy as np

from glimt.film import Counters
from glimt.study import laws
from glimt.study.experiments import FIGURES, Curves, Setting
from glimt.study.measuring import Measurement
from glimt.study.results import Figure, Law, Number, Point, Rays, Series
from glimt.study.verdicts import tell


def make_figure(number: int, curves: Curves, measured: Measurement, notes: list[str]) -> Figure:
    """Return a figure of measured curves, whose settings were measured one curve after the other."""
    kind = FIGURES[number]
    series, first = [], 0
    for name, settings in curves.items():
        series.append(_series(name, settings, measured, range(first, first + len(settings)), kind.kind == "curve"))
        first += len(settings)
    figure = empty_figure(number, notes)
    figure.series, figure.rounds, figure.complete = series, len(measured.times), measured.complete
    tell(figure)
    return figure


def empty_figure(number: int, notes: list[str]) -> Figure:
    """Return a figure without series; its notes say why."""
    kind = FIGURES[number]
    return Figure(number=number, name=kind.name, title=kind.title, x_title=kind.x_title, kind=kind.kind, log=kind.log,
                  paper=kind.paper, series=[], rounds=0, complete=True, notes=notes)


def _series(name: str, settings: list[Setting], measured: Measurement, which: range, ordered: bool) -> Series:
    times = 1e3 * measured.by_round(which)
    points = [_point(setting, middle, [row[place] for row in measured.times], measured.counters[place],
                     measured.stages[place])
              for setting, place, middle in zip(settings, which, laws.medians(times), strict=True)]
    series = Series(name=name, points=points, brute_force=all(each.options.brute_force for each in settings))
    if ordered and len(points) > 2:
        _add_laws(series, times)
    return series


def _add_laws(series: Series, times: laws.Floats) -> None:
    x = np.array([point.x for point in series.points])
    noise = np.median([(point.ms.hi - point.ms.lo) / 2 / point.ms.value for point in series.points])
    found = laws.fits(x, times)
    series.laws = [_law(each) for each in found]
    series.law = laws.best(found, x, float(noise)).law
    rays = np.array([point.rays.total for point in series.points], np.float64)
    if np.ptp(rays) > 0.05 * rays.max():
        series.rays_law = _law(laws.fit("linear", rays, times))


def _law(fit: laws.Fit) -> Law:
    return Law(law=fit.law, numbers={name: _number(value) for name, value in fit.numbers.items()}, r2=fit.r2,
               deviation=fit.deviation)


def _number(estimate: laws.Estimate) -> Number:
    return Number(value=estimate.value, lo=estimate.lo, hi=estimate.hi)


def _point(setting: Setting, middle: laws.Estimate, rounds: list[list[float]], counters: Counters,
           stages: dict[str, float]) -> Point:
    size = setting.scene.settings
    x = counters.primary / (size.width * size.height) if setting.x is None else setting.x
    return Point(x=x, label=setting.label, ms=_number(middle),
                 times_ms=[[round(1e3 * seconds, 4) for seconds in block] for block in rounds],
                 rays=Rays(primary=counters.primary, shadow=counters.shadow, mirror=counters.mirror),
                 stages_ms={stage: share * middle.value for stage, share in stages.items()})
