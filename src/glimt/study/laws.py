"""Laws of growth fitted to measured times, each number with its interval."""

from collections.abc import Callable
from typing import Any, Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Values = dict[str, Floats]
"""A law's numbers, (rows,) each."""

LawName = Literal["constant", "linear", "logarithmic", "power", "step"]
"""Simplest first: constant, ``start + slope * x``, ``start + per_tenfold * log10(x)``, ``scale * x**exponent`` (with a
start where x begins with 0), and a line with a jump at a setting."""

CONFIDENCE = 0.95
LINEAR_R2 = 0.98
"""From here on a line is called a line."""
_LINEAR_EXPONENTS, _LOOSE_EXPONENTS = (0.8, 1.25), (0.75, 1.35)
"""Where the exponent of what may be called a line lies: what a frame takes however little it shows bends a line that
much. The second ones are for laws with a start of their own, which leaves an exponent more room."""
_RESAMPLES = 400
_FLOOR = 0.03
"""Deviations below this share of a time prefer no law: caches and clocks are worth as much."""
_EXPONENTS = np.linspace(0.02, 3.0, 299)


class Estimate(NamedTuple):
    """A number with the interval that holds it at the stated confidence."""

    value: float
    lo: float
    hi: float


class Fit(NamedTuple):
    """A law through measured times.

    law : LawName
    numbers : dict of Estimate
        Times in the unit that was given.
    r2 : float
        Squared correlation of what it says with the times: of a line, the R² of ordinary least squares.
    deviation : float
        Root mean square of what is left, each part as a share of its time.
    """

    law: LawName
    numbers: dict[str, Estimate]
    r2: float
    deviation: float


def steadied(times: Floats) -> Floats:
    """Return (rounds, settings) times without the drift of the machine.

    Every round has timed all settings in turn: its times are divided by how slow the whole round was, told by their
    geometric mean against that of the median round.
    """
    slowness = np.exp(np.log(times).mean(1))
    return np.asarray(times * (np.median(slowness) / slowness)[:, None])


def interval(values: Floats) -> tuple[Floats, Floats]:
    """Return (lo, hi) of resampled values, (resamples, …), at the stated confidence."""
    outside = 50 * (1 - CONFIDENCE)
    lo, hi = np.percentile(values, [outside, 100 - outside], axis=0)
    return lo, hi


def resampled_medians(times: Floats, random: np.random.Generator) -> Floats:
    """Return (resamples, settings) medians of (rounds, settings) times, whole rounds drawn with replacement."""
    rounds = len(times)
    drawn = times[random.integers(0, rounds, (_RESAMPLES, rounds))]
    return np.asarray(np.median(drawn, axis=1))


def medians(times: Floats) -> list[Estimate]:
    """Return the median time of each setting."""
    lo, hi = interval(resampled_medians(times, np.random.default_rng(1)))
    middle = np.median(times, axis=0)
    return [Estimate(*map(float, row)) for row in zip(middle, lo, hi, strict=True)]


def fit(law: LawName, x: Floats, times: Floats) -> Fit:
    """Return a law through the medians of (rounds, settings) times at settings x.

    The intervals come from resampling: rounds, for the noise of measuring, and what the law leaves over at each
    setting, for what else the times depend on (Efron and Tibshirani, "An introduction to the bootstrap", 1993, chapter
    9; what differs: both at once, residuals as shares of the time).
    """
    solve, random = _LAWS[law][0], np.random.default_rng(1)
    y = np.median(times, axis=0)
    numbers, expected = solve(x, y[None])
    free = len(x) - _parameters(law, x)
    left = (y / expected[0] - 1) * np.sqrt(len(x) / free)
    noise = resampled_medians(times, random) / y
    drawn = expected[0] * noise * (1 + left[random.integers(0, len(x), noise.shape)])
    lo_hi = {name: interval(values) for name, values in solve(x, np.maximum(drawn, 1e-12))[0].items()}
    estimates = {name: Estimate(float(value[0]), float(min(lo_hi[name][0], value[0])),
                                float(max(lo_hi[name][1], value[0]))) for name, value in numbers.items()}
    deviation = float(np.sqrt(((y / expected[0] - 1) ** 2).mean()))
    return Fit(law, estimates, _squared_correlation(y, expected[0]), deviation)


def value_at(law: LawName, numbers: dict[str, float], x: Floats) -> Floats:
    """Return what a law with such numbers says at x."""
    if law == "constant":
        return np.full_like(x, numbers["time"])
    if law == "logarithmic":
        return numbers["start"] + numbers["per_tenfold"] * np.log10(x)
    if law == "power":
        return np.asarray(numbers.get("start", 0.0) + numbers["scale"] * x ** numbers["exponent"])
    jump = numbers["jump"] * (x >= numbers["at"]) if law == "step" else 0.0
    return np.asarray(numbers["start"] + numbers["slope"] * x + jump)


def _squared_correlation(y: Floats, expected: Floats) -> float:
    away, told = y - y.mean(), expected - expected.mean()
    both = (away**2).sum() * (told**2).sum()
    return float((away @ told) ** 2 / both) if both > 0 else 0.0


def fits(x: Floats, times: Floats) -> list[Fit]:
    """Return all laws that there are enough settings for, simplest first; a logarithm has no place for x = 0."""
    return [fit(law, x, times) for law in _LAWS
            if len(x) > _parameters(law, x) and not (law == "logarithmic" and x.min() <= 0)]


def best(found: list[Fit], x: Floats, noise: float = 0.0) -> Fit:
    """Return the law that tells the times best: a line where that will do, else the simplest of those about as good.

    Parameters
    ----------
    found : list of Fit
        From `fits`.
    x : (settings,)
    noise : float
        Half the width of a typical time's interval, as a share of the time.

    By Schwarz's criterion (1978) on relative deviations, with a floor below which they say nothing; a more complicated
    law has to be better by more than 2, which is called positive evidence (Kass and Raftery, 1995).
    """
    floor, count = max(_FLOOR, noise / 2), len(x)
    scores = {each.law: count * np.log(each.deviation**2 + floor**2) + _parameters(each.law, x) * np.log(count)
              for each in found}
    laws: dict[str, Fit] = {each.law: each for each in found}
    if is_linear(laws) and not ("constant" in scores and scores["constant"] <= scores["linear"]):
        return laws["linear"]
    least = min(scores.values())
    return next(each for each in found if scores[each.law] <= least + 2)


def _parameters(law: LawName, x: Floats) -> int:
    """Return how many numbers a law has; a power law has a start where x begins with 0."""
    return _LAWS[law][1] + (law == "power" and x.min() <= 0)


def is_linear(laws: dict[str, Fit]) -> bool:
    """Return whether a line tells the times, and the exponent of a power law agrees."""
    if "linear" not in laws or laws["linear"].r2 < LINEAR_R2 or laws["linear"].numbers["slope"].value <= 0:
        return False
    if "power" not in laws:
        return True
    numbers = laws["power"].numbers
    lo, hi = _LOOSE_EXPONENTS if "start" in numbers else _LINEAR_EXPONENTS
    return numbers["exponent"].hi >= lo and numbers["exponent"].lo <= hi


def _constant(x: Floats, y: Floats) -> tuple[Values, Floats]:
    mean = np.exp(np.log(y).mean(1))
    return {"time": mean}, np.broadcast_to(mean[:, None], y.shape)


def _least_squares(basis: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return (numbers, expected) of the columns of a basis, (settings, columns), through each row of times y.

    Deviations count as shares of the time: that is how times are uncertain.
    """
    size = np.abs(basis).max(0)
    columns = basis / size / y[:, :, None]
    turned = columns.transpose(0, 2, 1)
    numbers = np.linalg.solve(turned @ columns, turned.sum(2)[..., None])[..., 0] / size
    return numbers, numbers @ basis.T


def _linear(x: Floats, y: Floats) -> tuple[Values, Floats]:
    numbers, expected = _least_squares(np.stack([np.ones_like(x), x], 1), y)
    return {"start": numbers[:, 0], "slope": numbers[:, 1]}, expected


def _logarithmic(x: Floats, y: Floats) -> tuple[Values, Floats]:
    numbers, expected = _least_squares(np.stack([np.ones_like(x), np.log10(x)], 1), y)
    return {"start": numbers[:, 0], "per_tenfold": numbers[:, 1]}, expected


def _power(x: Floats, y: Floats) -> tuple[Values, Floats]:
    """``scale * x**exponent``; ``start + scale * x**exponent`` where x begins with 0."""
    if x.min() <= 0:
        return _offset_power(x, y)
    away = np.log(x) - np.log(x).mean()
    exponent = (np.log(y) * away).sum(1) / (away**2).sum()
    scale = np.exp(np.log(y).mean(1) - exponent * np.log(x).mean())
    return {"scale": scale, "exponent": exponent}, scale[:, None] * x ** exponent[:, None]


def _best_of(tried: list[tuple[Floats, Floats]], y: Floats) -> tuple[Floats, Floats]:
    """Return for each row of times the (numbers, expected) that come nearest to it."""
    errors = [((expected / y - 1) ** 2).sum(1) for _, expected in tried]
    chosen, rows = np.argmin(errors, axis=0), np.arange(len(y))
    numbers, expected = (np.array(column) for column in zip(*tried, strict=True))
    return numbers[chosen, rows], expected[chosen, rows]


def _offset_power(x: Floats, y: Floats) -> tuple[Values, Floats]:
    """Least squares for each exponent, of which the best is taken: what is curved in one number needs no more."""
    tried = []
    for exponent in _EXPONENTS:
        numbers, expected = _least_squares(np.stack([np.ones_like(x), x**exponent], 1), y)
        tried.append((np.column_stack([numbers, np.full(len(y), exponent)]), expected))
    numbers, expected = _best_of(tried, y)
    return {"start": numbers[:, 0], "scale": numbers[:, 1], "exponent": numbers[:, 2]}, expected


def _step(x: Floats, y: Floats) -> tuple[Values, Floats]:
    """Try a jump at each setting that leaves two or more on both sides."""
    tried = []
    for place in range(2, len(x) - 1):
        after = (np.arange(len(x)) >= place).astype(np.float64)
        numbers, expected = _least_squares(np.stack([np.ones_like(x), x, after], 1), y)
        tried.append((np.column_stack([numbers, np.full(len(y), x[place])]), expected))
    numbers, expected = _best_of(tried, y)
    return dict(zip(("start", "slope", "jump", "at"), numbers.T, strict=True)), expected


_LAWS: dict[LawName, tuple[Callable[[Any, Any], tuple[Values, Floats]], int]] = {
    "constant": (_constant, 1), "linear": (_linear, 2), "logarithmic": (_logarithmic, 2), "power": (_power, 2),
    "step": (_step, 4)}
assert tuple(_LAWS) == get_args(LawName)
