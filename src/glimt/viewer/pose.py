"""Where the viewer's camera stands and which way it looks."""

import math
from dataclasses import dataclass, replace

from glimt.scene.camera import Camera

Point = tuple[float, float, float]

_STEEPEST = math.radians(89.0)
"""How far the camera may look up or down: straight up there would be no telling which way is right."""


@dataclass(frozen=True)
class Pose:
    """A camera as position, look, right and up; the three directions are unit vectors at right angles.

    Parameters
    ----------
    position, look, right, up : (x, y, z)
    sky : (x, y, z)
        The scene's up, a unit vector: turning sideways is turning around it.
    fov_deg : float
        Vertical field of view in degrees.
    """

    position: Point
    look: Point
    right: Point
    up: Point
    sky: Point
    fov_deg: float

    @classmethod
    def of(cls, camera: Camera) -> "Pose":
        """Return the pose of a scene's camera."""
        basis = camera.basis()
        look, right, up = (_point(axis.tolist()) for axis in (basis.look, basis.right, basis.up))
        position = _point(camera.position)
        return cls(position, look, right, up, unit(_point(camera.up)), camera.fov_deg)

    def camera(self) -> Camera:
        """Return the scene's camera for this pose."""
        # The target is as far away as the numbers are large: rounding does not turn the view.
        reach = max(1.0, *map(abs, self.position))
        return Camera(self.position, along(self.position, self.look, reach), self.up, self.fov_deg)

    def moved(self, right: float, up: float, forward: float) -> "Pose":
        """Return the pose after a walk in its own directions; lengths in world units."""
        position = along(along(along(self.position, self.right, right), self.up, up), self.look, forward)
        return replace(self, position=position)

    def turned(self, yaw: float, pitch: float) -> "Pose":
        """Return the pose after a turn to the right and up, in radians, never over the top."""
        steep = math.asin(max(-1.0, min(1.0, dot(self.look, self.sky))))
        pitch = max(-_STEEPEST, min(_STEEPEST, steep + pitch)) - steep
        look = rotated(rotated(self.look, self.right, pitch), self.sky, -yaw)
        right = unit(rotated(self.right, self.sky, -yaw))
        # Made square again each time, or rounding would add up over an hour of flying.
        look = unit(along(look, right, -dot(look, right)))
        return replace(self, look=look, right=right, up=cross(right, look))

    def orbited(self, target: Point, yaw: float, pitch: float) -> "Pose":
        """Return the pose after it was carried around a target that keeps its place in the picture."""
        offset = minus(self.position, target)
        inside = dot(offset, self.right), dot(offset, self.up), dot(offset, self.look)
        turned = self.turned(yaw, pitch)
        position = along(along(along(target, turned.right, inside[0]), turned.up, inside[1]), turned.look, inside[2])
        return replace(turned, position=position)


def along(start: Point, direction: Point, t: float) -> Point:
    """Return start + t * direction."""
    return start[0] + t * direction[0], start[1] + t * direction[1], start[2] + t * direction[2]


def minus(a: Point, b: Point) -> Point:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def dot(a: Point, b: Point) -> float:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Point, b: Point) -> Point:
    """Return the vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def unit(a: Point) -> Point:
    """Return a vector at unit length."""
    length = math.hypot(*a)
    return a[0] / length, a[1] / length, a[2] / length


def rotated(a: Point, axis: Point, angle: float) -> Point:
    """Return a turned around a unit axis, right-handed (Rodrigues' formula)."""
    c, s = math.cos(angle), math.sin(angle)
    share = dot(axis, a) * (1 - c)
    side = cross(axis, a)
    x, y, z = (c * a[k] + s * side[k] + share * axis[k] for k in range(3))
    return x, y, z


def _point(values: "tuple[float, ...] | list[float]") -> Point:
    x, y, z = values
    return float(x), float(y), float(z)
