"""How a light moves over time; evaluated on the host, once per frame."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from glimt import linalg
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
        return self._turn(np.subtract(start, self.center), time, np.asarray(self.center, np.float64))

    def direction(self, start: Point, time: float) -> Point:
        """Return what becomes of direction `start` after `time` seconds."""
        return self._turn(np.asarray(start, np.float64), time, np.zeros(3))

    def _turn(self, arm: NDArray[Any], time: float, center: NDArray[Any]) -> Point:
        turn = linalg.rotation(self.axis, 360.0 * (time / self.period % 1.0))
        x, y, z = (linalg.transform_vectors(turn, arm) + center).tolist()
        return x, y, z


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
        times, points = np.asarray(self.times), np.asarray(self.points)
        if self.loop:
            time = times[0] + (time - times[0]) % (times[-1] - times[0])
        x, y, z = (float(np.interp(time, times, points[:, axis])) for axis in range(3))
        return x, y, z

    direction = position


Motion = Orbit | Path
