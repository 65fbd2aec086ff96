"""From what was rendered to what is shown: developed, stretched to the canvas, with the overlay over it."""

import itertools
import time
from concurrent.futures import ThreadPoolExecutor, wait
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from glimt.color import develop
from glimt.film import Film
from glimt.scene.scene import RenderSettings
from glimt.viewer.keys import help_table
from glimt.viewer.overlay import FrameInfo, Overlay
from glimt.viewer.stretch import stretch

if TYPE_CHECKING:
    from glimt.viewer.viewer import Viewer

Picture = Any
"""(h, w, 4) uint8 RGBA; or, from a presenter that leaves it on a GPU, what a window of that GPU shows."""
_BUFFERS = 3
"""One is on the canvas, one may be waiting for it, one is written to."""
_WORTH_SHARING = 100_000
"""Pixels from which on developing is shared by threads."""


class Presenter:
    """Keeps the picture without its overlay, and a few to hand out.

    Attributes
    ----------
    overlay : Overlay
        Draws over the pictures that are handed out.
    """

    def __init__(self, threads: int) -> None:
        self.clock = time.perf_counter
        self._pool = ThreadPoolExecutor(threads, "glimt-develop")
        self._threads = threads
        self.overlay = Overlay()
        self._base = self._small = np.zeros((0, 0, 4), np.uint8)
        self._ring: list[NDArray[np.uint8]] = []
        self.develop(Film(np.zeros((1, 1, 4), np.float32)), RenderSettings(), (2, 2))  # compiles what it needs

    def develop(self, film: Film, settings: RenderSettings, size: tuple[int, int]) -> None:
        """Take over a film for a canvas of `size`."""
        height, width = film.sums.shape[:2]
        small = self._target((width, height), size)
        parts = self._threads if width * height >= _WORTH_SHARING else 1
        rows = [height * part // parts for part in range(parts + 1)]
        jobs = [self._pool.submit(develop, film.sums[first:end], settings.exposure, settings.tone_curve,
                                  small[first:end]) for first, end in itertools.pairwise(rows[1:])]
        develop(film.sums[:rows[1]], settings.exposure, settings.tone_curve, small[:rows[1]])
        wait(jobs)
        for job in jobs:
            job.result()
        self._fit(small)

    def show(self, image: NDArray[np.uint8], size: tuple[int, int]) -> None:
        """Take over a picture, (h, w, 3), for a canvas of `size`."""
        small = self._target((image.shape[1], image.shape[0]), size)
        small[..., :3], small[..., 3] = image, 255
        self._fit(small)

    def compose(self, viewer: "Viewer") -> Picture:
        """Return the picture with its overlay, in memory that is written again two pictures later."""
        picture = self._ring.pop(0)
        self._ring.append(picture)
        np.copyto(picture, self._base)
        self._draw_overlay(viewer, picture)
        return picture

    def leave_gpu(self) -> None:
        """Do nothing: pictures are in memory."""

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture."""
        return self._base.shape[1], self._base.shape[0]

    def picture(self) -> NDArray[np.uint8]:
        """Return the picture without overlay, (h, w, 4) uint8."""
        return self._base.copy()

    def close(self) -> None:
        """End the threads."""
        self._pool.shutdown()

    def _draw_overlay(self, viewer: "Viewer", picture: NDArray[np.uint8]) -> None:
        self.overlay.pixel_ratio = viewer.pixel_ratio
        has_help = viewer.help_shown and self.overlay.draw_help(picture, help_table())  # which takes all the room
        self.overlay.draw(picture, frame_info(viewer), viewer.times, 0 if has_help else viewer.overlay_level)

    def _target(self, rendered: tuple[int, int], size: tuple[int, int]) -> NDArray[np.uint8]:
        """Return where a picture is written: at once where it is shown, if it has that size."""
        width, height = size
        if self._base.shape[:2] != (height, width):
            self._base = np.zeros((height, width, 4), np.uint8)
            self._ring = [np.zeros_like(self._base) for _ in range(_BUFFERS)]
        if rendered == size:
            return self._base
        if self._small.shape[:2] != rendered[::-1]:
            self._small = np.zeros((rendered[1], rendered[0], 4), np.uint8)
        return self._small

    def _fit(self, picture: NDArray[np.uint8]) -> None:
        if picture is not self._base:
            stretch(picture, self._base)


def frame_info(viewer: "Viewer") -> FrameInfo:
    """Return what the overlay shows."""
    film, times = viewer.film, viewer.times
    width, height = viewer.rendered_size
    return FrameInfo(
        frame_seconds=viewer.frame_seconds, p50=times.percentile(50), p95=times.percentile(95),
        rays=film.counters.rays if film else 0, width=width, height=height,
        shown_width=viewer.size[0], shown_height=viewer.size[1], max_bounces=viewer.scene.settings.max_bounces,
        lights=len(viewer.scene.lights), samples=viewer.film_samples, triangles=viewer.triangles,
        budget=viewer.governor.budget,
        mode="fly" if viewer.motion.target is None else "orbit", debug_view=viewer.debug_view, paused=viewer.paused,
        engine=viewer.renderer.engine_name, stages=film.stages if film else {},
        message=viewer.message, error=viewer.error, picked=picked_text(viewer))


def picked_text(viewer: "Viewer") -> str | None:
    """Return what is told of the picked point."""
    pick = viewer.picked
    if pick is None:
        return None
    x, y, z = pick.position
    triangle = "" if pick.triangle is None else f", triangle {pick.triangle:,}"
    return (f"{pick.object.name}{triangle}\nmaterial {pick.material.name}\n"
            f"at {x:.4g} {y:.4g} {z:.4g}, {pick.distance:.4g} away")
