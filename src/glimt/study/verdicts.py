"""What follows from the numbers, in sentences that are made from them."""

from collections.abc import Callable

from glimt.study.results import Figure, Law, Number, Point, Series

_SPREAD, _SMALL_SPREAD = 0.03, 0.2
"""Differences up to the first share of a time say nothing, and up to the second little: another run gives others."""
_DYING = 1.5
"""With all bounces there are not so many times as many mirror rays as with one."""
_EXPLAINED, _PARTLY_EXPLAINED = 0.95, 0.8
"""R² of a line through time against rays."""
_FLAT = 0.25
"""An exponent below this is no growth but a first step."""


def tell(figure: Figure) -> None:
    """Write the verdict of each series."""
    for series in figure.series:
        series.verdict = _TELL.get(figure.name, _curve)(figure, series)


def _curve(figure: Figure, series: Series) -> str:
    """Say how frame time grows, whether the paper agrees, and what the rays have to do with it."""
    if not series.law:
        return ""
    law = series.fitted(series.law)
    assert law is not None
    return f"{_growth(law, series, figure.name)}{_against_paper(figure, series)}. {_rays(series)}"


def _growth(law: Law, series: Series, variable: str) -> str:
    numbers, power = law.numbers, series.fitted("power")
    if law.law == "constant":
        return f"Frame time does not depend on {variable}: {_ms(numbers['time'])} throughout"
    if law.law == "linear":
        return _line(law, power, _unit(series), variable)
    if law.law == "logarithmic":
        said = f", as a power law {variable}^{_exponent(power)}" if power else ""
        return (f"Frame time grows with the logarithm of {variable}: {_ms(numbers['per_tenfold'])} for ten times as "
                f"many (R² {law.r2:.3f}){said}")
    if law.law == "step":
        place = f"{numbers['at'].value:,.0f} {variable}"
        return (f"Frame time jumps by {_ms(numbers['jump'])} at {place}, and is a line "
                f"before and after (R² {law.r2:.3f})")
    if "start" in numbers and numbers["exponent"].value < _FLAT:
        first, last = series.points[0], series.points[-1]
        return (f"Frame time goes from {_ms(first.ms)} to {_ms(last.ms)}, nearly all of it with the first of the "
                f"{variable}")
    kind = "more slowly than linear" if numbers["exponent"].value < 1 else "faster than linear"
    return f"Frame time grows as {variable}^{_exponent(law)}: {kind} (R² {law.r2:.3f})"


def _line(law: Law, power: Law | None, unit: int, variable: str) -> str:
    of_what = f"{unit:,} {variable}" if unit > 1 else variable.removesuffix("s")
    line = (f"linear, {_ms(law.numbers['start'])} and {_ms(_scaled(law.numbers['slope'], unit))} for each {of_what} "
            f"(R² {law.r2:.3f})")
    if power and "start" not in power.numbers:
        return f"Frame time grows as {variable}^{_exponent(power)}: {line}"
    return f"Frame time grows with {variable}: {line}"


def _against_paper(figure: Figure, series: Series) -> str:
    """Return whether the paper's linear law holds; nothing where it has no such figure."""
    if not figure.paper:
        return ""
    if figure.name == "vertices":
        return _against_vertices(series)
    if series.law == "linear":
        return ", as the paper found"
    mirror = [point.rays.mirror / 1e3 for point in series.points if point.x > 0]
    if figure.name == "bounces" and mirror[-1] <= _DYING * mirror[0]:
        return ("; the paper's linear law does not hold here, since few rays meet one mirror after the other: "
                f"{_range(mirror)} thousand mirror rays")
    return "; the paper's linear law does not hold here"


def _against_vertices(series: Series) -> str:
    if series.brute_force and series.law in ("linear", "step"):
        return ", as the paper found, which tests everything as well"
    if series.brute_force:
        return "; the paper's linear law does not hold here"
    if series.law == "step":
        return ", as the paper found when the outer box came into view"
    if series.law == "linear":
        return ", as the paper found"
    return "; the paper's linear law does not hold, the tree removes it"


def _rays(series: Series) -> str:
    """Say what the rays explain: a constant rate makes a straight line."""
    rates = [point.rays_per_second / 1e6 for point in series.points]
    spoken = f"Mrays/s: {_range(rates)}."
    line = series.rays_law
    if line is None:
        return f"The rays of a frame hardly change; {spoken}"
    if line.r2 >= _EXPLAINED:
        return f"Against counted rays it is a line (R² {line.r2:.3f}): the rays explain it; {spoken}"
    if line.r2 >= _PARTLY_EXPLAINED:
        return f"Counted rays explain most of it (R² {line.r2:.3f}), but their cost changes; {spoken}"
    return f"Counted rays alone do not explain it (R² {line.r2:.3f}): their cost changes; {spoken}"


def _groups(figure: Figure, series: Series) -> str:
    ordered = sorted(series.points, key=lambda point: point.ms.value)
    best, worst = ordered[0], ordered[-1]
    spread = worst.ms.value / best.ms.value - 1
    if spread <= _SPREAD or worst.ms.lo <= best.ms.hi:
        return f"No difference is seen beyond the noise: all are within {max(spread, 0.001):.1%}."
    if spread <= _SMALL_SPREAD:
        return f"It matters little: all are within {spread:.1%}."
    as_good = [point.label for point in ordered[1:] if point.ms.lo <= best.ms.hi or
               point.ms.value <= (1 + _SPREAD) * best.ms.value]
    also = f" ({', '.join(as_good)} as good)" if as_good else ""
    return f"It matters: best is {best.label}{also}; {worst.label} takes {1 + spread:.2f} times as long."


def _threads(figure: Figure, series: Series) -> str:
    del figure
    one = series.points[0]
    ratios = [(point, one.ms.value / point.ms.value) for point in series.points[1:]]
    said = ", ".join(f"{point.label} threads {ratio:.2f} times as fast" for point, ratio in ratios)
    fastest = max(ratios, key=lambda pair: pair[1], default=(one, 1.0))
    share = fastest[1] / fastest[0].x
    return f"As compared to one: {said}. At {fastest[0].label}, each thread does {share:.0%} of what one does alone."


def _samples(figure: Figure, series: Series) -> str:
    if series.laws:
        return _curve(figure, series)
    full = next((point for each in figure.series for point in each.points if point.label == "4×4"), None)
    point = series.points[0]
    if full is None:
        return ""
    return (f"Adaptive sampling traces {point.rays.total / full.rays.total:.0%} of the rays of 4×4 samples, "
            f"{point.x:.1f} samples a pixel, in {point.ms.value / full.ms.value:.0%} of the time.")


def _stages(figure: Figure, series: Series) -> str:
    del figure
    if not any(point.stages_ms for point in series.points):
        return "This adapter has no timestamps: stages are not timed."
    said = [f"{point.label}: {_largest(point)}" for point in series.points if point.stages_ms]
    return f"Most time goes to: {'; '.join(said)}."


def _largest(point: Point) -> str:
    stage = max(point.stages_ms, key=lambda name: point.stages_ms[name])
    return f"{stage} {point.stages_ms[stage] / point.ms.value:.0%}"


_TELL: dict[str, Callable[[Figure, Series], str]] = {"groups": _groups, "threads": _threads, "samples": _samples,
                                                     "stages": _stages}


def _unit(series: Series) -> int:
    """Return how many of what is varied make a slope that can be read: one, a thousand, a million."""
    largest = max(point.x for point in series.points)
    return 1 if largest < 1000 else 1000 if largest < 100_000 else 1_000_000


def _scaled(number: Number, factor: float) -> Number:
    return Number(value=factor * number.value, lo=factor * number.lo, hi=factor * number.hi)


def _exponent(law: Law) -> str:
    number = law.numbers["exponent"]
    return f"{number.value:.2f} ({number.lo:.2f}–{number.hi:.2f})"


def _ms(number: Number) -> str:
    digits = 2 if abs(number.value) < 10 else 1
    return f"{number.value:.{digits}f} ({number.lo:.{digits}f}–{number.hi:.{digits}f}) ms"


def _range(values: list[float]) -> str:
    lo, hi = min(values), max(values)
    return f"{lo:.1f}" if f"{lo:.1f}" == f"{hi:.1f}" else f"{lo:.1f} to {hi:.1f}"
