"""How a light moves over time; evaluated on the host once per frame, in plain floats: arrays of three are slower."""

import math
from bisect import bisect_right
from dataclasses import dataclass

import numpy as np

from glimt.errors import GlimtError
from glimt.scene import checks

Point = tuple[float, float, float]


@dataclass(frozen=True)
class Orbit:
    """A circle around an axis, starting where the light stands at time 0.

    Parameters
    ----------
    center : (x, y, z)
        A point on the axis. For a directional light only `axis` counts: its direction turns.
    axis : (x, y, z)
        Turning is right-handed around it.
    period : float
        Seconds for one round; negative turns the other way.
    """

    center: Point = (0.0, 0.0, 0.0)
    axis: Point = (0.0, 1.0, 0.0)
    period: float = 10.0

    def __post_init__(self) -> None:
        checks.vector("orbit", "center", self.center)
        checks.direction("orbit", "axis", self.axis)
        if abs(checks.number("orbit", "period", self.period, -1e9, 1e9)) < 1e-9:
            raise GlimtError("orbit: period is 0 seconds")

    def position(self, start: Point, time: float) -> Point:
        """Return where a point that is at `start` at time 0 is at `time` seconds."""
        (x, y, z), (cx, cy, cz) = start, self.center
        x, y, z = self.direction((x - cx, y - cy, z - cz), time)
        return x + cx, y + cy, z + cz

    def direction(self, start: Point, time: float) -> Point:
        """Return what becomes of direction `start` after `time` seconds (Rodrigues' formula)."""
        (x, y, z), (kx, ky, kz) = start, self.axis
        length = math.hypot(kx, ky, kz)
        kx, ky, kz = kx / length, ky / length, kz / length
        angle = math.tau * (time / self.period % 1.0)
        c, s = math.cos(angle), math.sin(angle)
        along = (kx * x + ky * y + kz * z) * (1 - c)
        return (float(x * c + (ky * z - kz * y) * s + kx * along), float(y * c + (kz * x - kx * z) * s + ky * along),
                float(z * c + (kx * y - ky * x) * s + kz * along))


@dataclass(frozen=True)
class Path:
    """Straight lines through `points`, reached at `times`.

    Parameters
    ----------
    times : n increasing seconds
    points : n positions, or directions for a directional light
    loop : bool
        True: start again after the last time. False: stay at the ends.
    """

    times: tuple[float, ...]
    points: tuple[Point, ...]
    loop: bool = True

    def __post_init__(self) -> None:
        times = checks.array("path", "times", self.times, (None,), np.float64)
        checks.coordinates("path", "points", self.points, (len(times), 3))
        if len(times) < 2 or (np.diff(times) <= 0).any():
            raise GlimtError("path: times must be two or more, each later than the one before")

    def position(self, start: Point, time: float) -> Point:
        """Return the position at `time` seconds; `start` is not used, the path says it all."""
        times = self.times
        if self.loop:
            time = times[0] + (time - times[0]) % (times[-1] - times[0])
        if not times[0] < time < times[-1]:
            x, y, z = self.points[0 if time <= times[0] else -1]
            return float(x), float(y), float(z)
        after = bisect_right(times, time)
        share = (time - times[after - 1]) / (times[after] - times[after - 1])
        x, y, z = (float(p + share * (q - p))
                   for p, q in zip(self.points[after - 1], self.points[after], strict=True))
        return x, y, z

    direction = position


Motion = Orbit | Path
