"""A pinhole camera."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from glimt.errors import GlimtError
from glimt.scene import checks

Point = tuple[float, float, float]

_MARGIN = 1.06
"""How much larger than the framed box the picture is."""


class Basis(NamedTuple):
    """Unit vectors of a camera, (3,) float64 each: right-handed, ``right × up = -look``."""

    right: NDArray[np.float64]
    up: NDArray[np.float64]
    look: NDArray[np.float64]


@dataclass(eq=False)
class Camera:
    """Where the picture is taken from.

    Parameters
    ----------
    position : (x, y, z)
    target : (x, y, z)
        The point in the middle of the picture.
    up : (x, y, z)
        What is up in the picture; must not lie along the line of sight.
    fov_deg : float
        Vertical field of view in degrees, above 0 and below 180.
    """

    position: Point = (0.0, 0.0, 5.0)
    target: Point = (0.0, 0.0, 0.0)
    up: Point = (0.0, 1.0, 0.0)
    fov_deg: float = 45.0

    def __post_init__(self) -> None:
        self.position = checks.vector("camera", "position", self.position)
        self.target = checks.vector("camera", "target", self.target)
        self.up = checks.direction("camera", "up", self.up)
        self.fov_deg = checks.number("camera", "fov_deg", self.fov_deg, 0.001, 179)
        self.axes()

    def axes(self) -> tuple[Point, Point, Point]:
        """Return the unit vectors of `basis` as plain numbers; an error where the camera looks at itself or along `up`.

        A camera moves each frame, and arrays of three numbers are ten times as slow.
        """
        (x, y, z), (tx, ty, tz) = self.position, self.target
        look = _unit(tx - x, ty - y, tz - z)
        if not any(look):
            raise GlimtError(f"camera: position and target are the same point {self.position}, move one of them")
        right = _cross(look, _unit(*self.up))
        if math.hypot(*right) < 1e-6:
            raise GlimtError(f"camera: up {self.up} lies along the line of sight, choose another up")
        right = _unit(*right)
        return right, _cross(right, look), look

    def basis(self) -> Basis:
        """Return the camera's unit vectors; an error where it looks at itself or along `up`."""
        return Basis(*map(np.array, self.axes()))

    @classmethod
    def framing(cls, lo: ArrayLike, hi: ArrayLike, aspect: float = 1.0, fov_deg: float = 40.0,
                direction: Point = (-0.45, -0.35, -1.0)) -> "Camera":
        """Return a camera that looks along `direction` and sees the whole box (lo, hi) at width / height `aspect`."""
        lo, hi = np.asarray(lo, np.float64), np.asarray(hi, np.float64)
        center = (lo + hi) / 2
        if not (hi > lo).any():
            lo, hi = center - 1, center + 1
        basis = cls((0.0, 0.0, 0.0), direction).basis()
        corners = np.stack(np.meshgrid(*zip(lo - center, hi - center, strict=True)), -1).reshape(8, 3)
        x, y, depth = (corners @ np.stack(basis).T).T
        reach = math.tan(math.radians(fov_deg) / 2) / _MARGIN
        distance = (np.maximum(np.abs(x) / (reach * aspect), np.abs(y) / reach) - depth).max()
        position = center - basis.look * distance
        return cls(tuple(position.tolist()), tuple(center.tolist()), (0.0, 1.0, 0.0), fov_deg)


def _cross(a: Point, b: Point) -> Point:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _unit(x: float, y: float, z: float) -> Point:
    """Return a vector at unit length; a zero vector stays zero."""
    length = math.hypot(x, y, z) or 1.0  # neither overflows nor vanishes
    return x / length, y / length, z / length
