"""Tiles over threads."""

import logging
import os
import time
from concurrent.futures import Future, ThreadPoolExecutor, wait
from typing import Any

import numpy as np
from numpy.typing import NDArray

from glimt.engines.cpu.kernels.frame import render_tiles
from glimt.engines.cpu.kernels.refine import FIRST_FOOTPRINT, refine_tiles
from glimt.engines.cpu.kernels.tile import TILE
from glimt.engines.cpu.warm_up import STAGE, compile_kernels
from glimt.engines.engine import Progress, Samples
from glimt.errors import GlimtError
from glimt.film import Counters, Film
from glimt.kernel import is_ready
from glimt.layout import CANCEL, COUNTER_STRIDE, NEXT_TILE, VIEW
from glimt.packed import PackedScene

_POLL_SECONDS = 0.1
_MOST_THREADS = 1024
_NO_RAYS = np.zeros((3, 7, 0), np.float32)


def available_threads() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class CpuEngine:
    """Renders with all lanes of all cores.

    The film is the same to the bit for any number of threads: tiles share nothing, and each writes its own pixels.
    """

    def __init__(self, threads: int | None = None) -> None:
        if threads is not None and not 1 <= threads <= _MOST_THREADS:
            raise GlimtError(f"threads is {threads}, expected 1 to {_MOST_THREADS}")
        self.threads = threads or available_threads()
        self._pool = ThreadPoolExecutor(self.threads, "glimt")
        self._scene: PackedScene | None = None
        self._light_count = 0

    def prepare(self, progress: Progress | None = None) -> None:
        """Compile the kernels if this machine has not done so yet; say so, since it takes a while."""
        if is_ready(render_tiles):
            return
        if progress is None:
            logging.getLogger("glimt").warning("compiling kernels, first run only")
        compile_kernels(progress or (lambda stage, share: None))

    def upload(self, scene: PackedScene, light_count: int) -> None:
        """Take over a scene; the arrays are used where they are."""
        self._scene, self._light_count = scene, light_count

    def render(self, view: NDArray[np.float32], size: tuple[int, int], samples: Samples, max_bounces: int,
               progress: Progress | None = None, film: Film | None = None) -> Film:
        """Render the uploaded scene (see `Engine.render`); Ctrl-C stops within a few packets' time."""
        if self._scene is None:
            raise GlimtError("no scene was uploaded to the engine")
        width, height = size
        start = time.perf_counter()
        shape = (height, width, 4)
        sums = film.sums if film is not None and film.sums.shape == shape else np.empty(shape, np.float32)
        counters = np.zeros((min(self.threads, _tile_count(sums)), int(COUNTER_STRIDE)), np.int64)
        if progress:
            progress("rendering", 0.0)
        if samples == "adaptive":
            first, first_view = np.empty(shape, np.float32), view.copy()
            first_view[VIEW.spread] *= FIRST_FOOTPRINT
            self._run(render_tiles, first_view, first, 1, max_bounces, counters, _part(progress, 0.0))
            if progress and not is_ready(refine_tiles):
                progress(STAGE, 0.5)
            self._run(refine_tiles, view, sums, first, max_bounces, counters, _part(progress, 0.5))
        else:
            self._run(render_tiles, view, sums, samples, max_bounces, counters, progress)
        totals = counters[:, :len(Counters._fields)].sum(0).tolist()
        return Film(sums, Counters(*totals), time.perf_counter() - start)

    def _run(self, kernel: Any, view: NDArray[np.float32], sums: NDArray[np.float32],
             samples: int | NDArray[np.float32], max_bounces: int, counters: NDArray[np.int64],
             progress: Progress | None) -> None:
        """Let a kernel write all tiles of a film, with a job for each row of counters; `samples`: or first ones."""
        control = np.zeros(16, np.int64)
        jobs: list[Future[Any]] = []
        try:  # awake for Ctrl-C; whatever happens, no job outlives this call
            for own in counters:
                jobs.append(self._pool.submit(kernel, self._scene, self._light_count, view, sums, samples,
                                              max_bounces, control, own, _NO_RAYS))
            for job in jobs:
                while not _ends(job):
                    if progress:
                        progress("rendering", min(1.0, control[NEXT_TILE] / _tile_count(sums)))
        except BaseException:
            control[CANCEL] = 1
            wait(jobs)
            raise


def _tile_count(sums: NDArray[np.float32]) -> int:
    count: int = -(-sums.shape[1] // TILE) * -(-sums.shape[0] // TILE)
    return count


def _part(progress: Progress | None, start: float) -> Progress | None:
    """Return what is told of one half of the work, as part of the whole."""
    return progress and (lambda stage, share: progress(stage, start + share / 2))


def _ends(job: "Future[Any]") -> bool:
    """Return whether a job ends within the time of a poll; one that failed raises its error."""
    try:
        job.result(_POLL_SECONDS)  # in a small frame faster than `wait`
    except TimeoutError:
        return False
    return True
