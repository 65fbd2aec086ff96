"""How the camera moves: held keys and drags in, poses out; all of it eased."""

import math
from dataclasses import dataclass, field

from glimt.viewer.pose import Point, Pose, along, dot, minus

_EASE_SECONDS = 0.06
"""How fast a walk reaches its speed, and how fast a turn that is still to be made is made."""
_DIRECTIONS = {"right": (1, 0, 0), "left": (-1, 0, 0), "up": (0, 1, 0), "down": (0, -1, 0), "forward": (0, 0, 1),
               "back": (0, 0, -1)}
_STILL = 1e-3
"""What is left of a move, as a share of what can be seen, when it counts as over."""
_TAP_SECONDS = 0.05
"""A key that is only tapped counts as held for that long, even if it came and went between two frames."""
NEAREST_SECONDS = 1e-3
"""How near a target may come, as the time a flight there would take."""
_LONGEST_STEP = 0.1
"""Seconds: whoever comes back from a long pause has not walked through it."""


@dataclass
class Motion:
    """Flies or orbits, with damping.

    Parameters
    ----------
    speed : float
        World units a second.
    target : (x, y, z), optional
        What the camera orbits around; None: it flies.
    """

    speed: float
    target: Point | None = None
    _velocity: Point = (0.0, 0.0, 0.0)
    _turn: Point = (0.0, 0.0, 0.0)
    _slide: Point = (0.0, 0.0, 0.0)
    _held: dict[str, float] = field(default_factory=dict)  # for how many seconds it has moved the camera

    def hold(self, direction: str) -> None:
        """Begin to move in a direction: a key went down."""
        self._held.setdefault(direction, 0.0)

    def release(self, direction: str) -> None:
        """End moving in a direction: its key came up."""
        if direction in self._held:
            left = max(0.0, _TAP_SECONDS - self._held.pop(direction)) * self.speed
            right, up, forward = _DIRECTIONS[direction]
            self.slide(left * right, left * up, left * forward)

    def turn(self, yaw: float, pitch: float) -> None:
        """Ask for a turn in radians; it is made over the next frames."""
        self._turn = self._turn[0] + yaw, self._turn[1] + pitch, 0.0

    def slide(self, right: float, up: float, forward: float) -> None:
        """Ask for a move in world units, in the camera's directions; it is made over the next frames."""
        self._slide = self._slide[0] + right, self._slide[1] + up, self._slide[2] + forward

    def stop(self) -> None:
        """Drop whatever is still to be done, held keys excepted."""
        self._velocity = self._slide = self._turn = (0.0, 0.0, 0.0)

    @property
    def moving(self) -> bool:
        """Whether the next step would move the camera."""
        return bool(self._held) or any(self._velocity) or any(self._slide) or any(self._turn)

    def step(self, pose: Pose, seconds: float) -> Pose:
        """Return the pose some seconds later."""
        seconds = min(max(seconds, 0.0), _LONGEST_STEP)
        share = 1 - math.exp(-seconds / _EASE_SECONDS)
        wanted = [0.0, 0.0, 0.0]
        for direction in self._held:
            self._held[direction] += seconds
            for axis, way in enumerate(_DIRECTIONS[direction]):
                wanted[axis] += way * self.speed
        x, y, z = (old + share * (new - old) for old, new in zip(self._velocity, wanted, strict=True))
        self._velocity = (x, y, z) if self._held or max(abs(x), abs(y), abs(z)) > _STILL * self.speed else (0., 0., 0.)
        slide = _share_of(self._slide, share, _STILL * self.speed)
        turn = _share_of(self._turn, share, _STILL)
        self._slide, self._turn = minus(self._slide, slide), minus(self._turn, turn)
        right, up, forward = (v * seconds + s for v, s in zip(self._velocity, slide, strict=True))
        if self.target is None:
            return pose.turned(turn[0], turn[1]).moved(right, up, forward)
        return self._orbit(pose, turn[0], turn[1], right, up, forward)

    def _orbit(self, pose: Pose, yaw: float, pitch: float, right: float, up: float, forward: float) -> Pose:
        """Go around the target; sideways moves take it along, forward ones come near it and never pass it."""
        assert self.target is not None
        room = dot(minus(self.target, pose.position), pose.look) - NEAREST_SECONDS * self.speed
        pose = pose.orbited(self.target, yaw, pitch)
        if forward > 0:
            forward = room * (1 - math.exp(-forward / room)) if room > 0 else 0.0
        self.target = along(along(self.target, pose.right, right), pose.up, up)
        return pose.moved(right, up, forward)


def _share_of(left: Point, share: float, least: float) -> Point:
    """Return what is done now of what is left to do; a small rest is done at once."""
    x, y, z = left
    return left if max(abs(x), abs(y), abs(z)) <= least else (share * x, share * y, share * z)
