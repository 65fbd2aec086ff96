"""Frames of one scene in steady state."""

import math
from dataclasses import replace
from itertools import cycle

from glimt import linalg
from glimt.film import Counters
from glimt.renderer import Renderer
from glimt.scene.camera import Camera
from glimt.scene.scene import Scene

_FRAMES = 32
"""Frames in which the camera swings to both sides and back."""


def orbited(camera: Camera, angle_deg: float) -> Camera:
    """Return the camera, gone round its target about its up axis."""
    arm = [p - t for p, t in zip(camera.position, camera.target, strict=True)]
    x, y, z = linalg.transform_vectors(linalg.rotation(camera.up, angle_deg), arm) + camera.target
    return replace(camera, position=(float(x), float(y), float(z)))


class SteadyFrames:
    """Calling it renders the scene's next frame into the film of the last one.

    The camera swings about its target by up to `swing_deg` to each side, a little for each frame. The cameras are made
    before: to find their places is no part of a frame.

    Attributes
    ----------
    counters : Counters
        What was traced for the frame at the scene's own camera.
    """

    counters: Counters

    def __init__(self, scene: Scene, threads: int, swing_deg: float = 0.0) -> None:
        own = replace(scene)  # to move its camera
        self._renderer = Renderer(own, threads=threads, engine="cpu")
        camera = scene.camera_or_framing()
        self._cameras = cycle([orbited(camera, swing_deg * math.sin(math.tau * k / _FRAMES)) for k in range(_FRAMES)])
        self._film = self._renderer.render()
        self._renderer.settle()
        self.counters = self._film.counters

    def __call__(self) -> None:
        """Render a frame."""
        self._renderer.scene.camera = next(self._cameras)
        self._film = self._renderer.render(film=self._film)
