"""Frames of one scene in steady state."""

import math
from dataclasses import replace

from glimt import linalg
from glimt.film import Counters
from glimt.renderer import Renderer
from glimt.scene.camera import Camera
from glimt.scene.scene import Scene


def orbited(camera: Camera, angle_deg: float) -> Camera:
    """Return the camera, gone round its target about its up axis."""
    arm = [p - t for p, t in zip(camera.position, camera.target, strict=True)]
    x, y, z = linalg.transform_vectors(linalg.rotation(camera.up, angle_deg), arm) + camera.target
    return replace(camera, position=(float(x), float(y), float(z)))


class SteadyFrames:
    """Calling it renders the scene's next frame into the film of the last one.

    The camera swings about its target by up to `swing_deg` to each side, a little for each frame.

    Attributes
    ----------
    counters : Counters
        What was traced for the frame at the scene's own camera.
    """

    counters: Counters

    def __init__(self, scene: Scene, threads: int, swing_deg: float = 0.0) -> None:
        own = replace(scene)  # to move its camera
        self._renderer = Renderer(own, threads=threads, engine="cpu")
        self._camera, self._swing_deg, self._frame = scene.camera_or_framing(), swing_deg, 0
        self._film = self._renderer.render()
        self._renderer.settle()
        self.counters = self._film.counters

    def __call__(self) -> None:
        """Render a frame."""
        if self._swing_deg:
            self._frame += 1
            self._renderer.scene.camera = orbited(self._camera, self._swing_deg * math.sin(0.2 * self._frame))
        self._film = self._renderer.render(film=self._film)
