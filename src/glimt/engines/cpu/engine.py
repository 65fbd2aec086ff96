"""Tiles over threads."""

import contextlib
import logging
import os
import time
from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from glimt.debug_view import DebugView
from glimt.engines.cpu.closest_hits import closest_hits
from glimt.engines.cpu.control import new_control, new_counters, tiles_taken
from glimt.engines.cpu.kernels.block import PACKETS
from glimt.engines.cpu.kernels.debug import BARYCENTRICS, DEPTH, INSTANCES, NORMALS, SHADOWS, debug_tiles
from glimt.engines.cpu.kernels.frame import render_tiles
from glimt.engines.cpu.kernels.refine import FIRST_FOOTPRINT, refine_tiles
from glimt.engines.cpu.kernels.visits import count_visits
from glimt.engines.cpu.team import Jobs, Team
from glimt.engines.cpu.warm_up import STAGE, compile_kernels
from glimt.engines.engine import Hits, Progress, Samples
from glimt.engines.options import DEFAULT_OPTIONS, EngineOptions
from glimt.errors import GlimtError, RenderCancelled
from glimt.film import Counters, Film, sums_for
from glimt.kernel import is_ready
from glimt.layout import (
    CANCEL,
    FIRST_STAGE,
    STAGES,
    TILE_SIDE,
    TIMES_STAGES,
    VIEW,
)
from glimt.packed import PackedScene

_POLL_SECONDS = 0.1
_MOST_THREADS = 1024
_SHOWS = {"depth": DEPTH, "barycentrics": BARYCENTRICS, "instances": INSTANCES, "normals": NORMALS, "shadows": SHADOWS}
PACKET_COUNTS = [2**k for k in range(PACKETS.bit_length())]
"""How many packets of a block may travel together."""
_NO_RAYS = np.zeros((3, 7, 0), np.float32)


def available_threads() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class CpuEngine:
    """Renders with all lanes of all cores.

    The film is the same to the bit for any number of threads: tiles share nothing, and each writes its own pixels.
    """

    def __init__(self, threads: int | None = None, options: EngineOptions = DEFAULT_OPTIONS) -> None:
        if threads is not None and not 1 <= threads <= _MOST_THREADS:
            raise GlimtError(f"threads is {threads}, expected 1 to {_MOST_THREADS}")
        if options.tile not in range(8, 1025, 8) or options.packets not in (None, *PACKET_COUNTS):
            raise GlimtError(f"tile is {options.tile} and packets {options.packets}; expected a multiple of 8 up to "
                             f"1024, and one of {', '.join(map(str, PACKET_COUNTS))} or None for all")
        self._options = options
        self.threads = threads or available_threads()
        self._team = Team()
        self._scene: tuple[PackedScene, int] | None = None  # with its number of lights
        self._running: dict[int, NDArray[np.int64]] = {}

    @property
    def description(self) -> str:
        """What computes."""
        return f"CPU, {self.threads} thread{'s' * (self.threads > 1)}"

    @property
    def uses_clearances(self) -> bool:
        """Whether rays that leave a surface begin where they can meet anything."""
        return True

    def prepare(self, progress: Progress | None = None) -> None:
        """Compile the kernels if this machine has not done so yet; say so, since it takes a while."""
        if is_ready(render_tiles):
            return
        if progress is None:
            logging.getLogger("glimt").warning("compiling kernels, first run only")
        compile_kernels(progress or (lambda stage, share: None))

    def is_ready(self, samples: Samples, shows: DebugView | None = None) -> bool:
        """Return whether no kernel has to be compiled first (see `Engine.is_ready`)."""
        if shows:
            return is_ready(count_visits if shows == "nodes" else debug_tiles)
        return is_ready(render_tiles) and (samples != "adaptive" or is_ready(refine_tiles))

    def keep_films(self) -> None:
        """Do nothing: films are in memory (see `Engine.keep_films`)."""

    def upload(self, scene: PackedScene, light_count: int) -> None:
        """Take over a scene; the arrays are used where they are."""
        self._scene = scene, light_count

    def render(self, view: NDArray[np.float32], size: tuple[int, int], samples: Samples, max_bounces: int,
               progress: Progress | None = None, film: Film | None = None) -> Film:
        """Render the uploaded scene (see `Engine.render`); Ctrl-C stops within a few packets' time."""
        start = time.perf_counter()
        sums = sums_for(size, film)
        counters = self._new_counters(sums)
        counters[:, TIMES_STAGES] = self._options.time_stages
        uploaded = self._uploaded()
        with self._begin(len(counters)) as control:
            if progress:
                progress("rendering", 0.0)
            if samples == "adaptive":
                first, first_view = np.empty_like(sums), view.copy()
                first_view[VIEW.spread] *= FIRST_FOOTPRINT
                self._run(render_tiles, (*uploaded, first_view, first, 1, max_bounces), control, counters,
                          _part(progress, 0.0))
                if progress and not is_ready(refine_tiles):
                    progress(STAGE, 0.5)
                self._run(refine_tiles, (*uploaded, view, sums, first, max_bounces), control, counters,
                          _part(progress, 0.5))
            else:
                self._run(render_tiles, (*uploaded, view, sums, samples, max_bounces), control, counters, progress)
        totals, seconds = counters.sum(0).tolist(), time.perf_counter() - start
        return Film(sums, Counters(*totals[:len(Counters._fields)]), seconds, _stage_seconds(totals, seconds))

    def render_debug(self, view: NDArray[np.float32], size: tuple[int, int], shows: DebugView,
                     light_tints: NDArray[np.float32]) -> NDArray[np.float32]:
        """Render numbers a pixel (see `Engine.render_debug`)."""
        values = np.empty((size[1], size[0], 4), np.float32)
        given, counters = (*self._uploaded(), view, values), self._new_counters(values)
        with self._begin(len(counters)) as control:
            if shows == "nodes":
                self._run(count_visits, given, control, counters)
            else:
                self._run(debug_tiles, (*given, _SHOWS[shows], light_tints), control, counters)
        if shows == "instances":
            met, numbers = values[..., 3] > 0, values.view(np.int32)
            numbers[met, 1] = given[0].numbers_in_mesh(numbers[met, 1], numbers[met, 0])
        return values

    def find_hits(self, rays: NDArray[np.float32]) -> Hits:
        """Return what rays meet first (see `Engine.find_hits`), by the calling thread: also beside a render."""
        floats, ids = closest_hits(self._uploaded()[0], np.ascontiguousarray(rays, np.float32))
        return Hits(*floats, *ids)

    def cancel(self) -> None:
        """Stop what is being rendered (see `Engine.cancel`)."""
        for control in self._running.copy().values():
            control[CANCEL] = 1

    def _uploaded(self) -> tuple[PackedScene, int]:
        """Return the scene and how many lights it has."""
        if self._scene is None:
            raise GlimtError("no scene was uploaded to the engine")
        return self._scene

    def _new_counters(self, picture: NDArray[np.float32]) -> NDArray[np.int64]:
        """Return a row of counters for each thread that has something to do."""
        return new_counters(min(self.threads, _tile_count(picture, self._options.tile)))

    @contextlib.contextmanager
    def _begin(self, shares: int) -> Iterator[NDArray[np.int64]]:
        """Give what the threads of one render share, where `cancel` finds it as long as the render lasts."""
        control = new_control(shares, self._options)
        self._running[id(control)] = control
        try:
            yield control
        finally:
            del self._running[id(control)]

    def _run(self, kernel: Any, given: tuple[Any, ...], control: NDArray[np.int64], counters: NDArray[np.int64],
             progress: Progress | None = None) -> None:
        """Let a kernel write all tiles of the picture `given[3]`, with a job for each row of counters."""
        taken, tiles = tiles_taken(control), _tile_count(given[3], int(control[TILE_SIDE]))
        taken[:] = 0
        jobs = Jobs()
        try:  # awake for Ctrl-C; whatever happens, no job outlives this call
            for number, own in enumerate(counters):
                self._team.give(number, jobs, partial(kernel, *given, control, own, _NO_RAYS))
            while not jobs.have_ended(_POLL_SECONDS):
                if progress:
                    progress("rendering", min(1.0, taken.sum() / tiles))
        except BaseException:
            control[CANCEL] = 1
            jobs.wait(_POLL_SECONDS)
            raise
        if control[CANCEL]:
            raise RenderCancelled


def _tile_count(picture: NDArray[np.float32], side: int) -> int:
    count: int = -(-picture.shape[1] // side) * -(-picture.shape[0] // side)
    return count


def _stage_seconds(counters: list[int], seconds: float) -> dict[str, float]:
    """Return each stage's share of a frame's seconds, by what all threads have spent in it; nothing if not timed."""
    ticks = counters[FIRST_STAGE:FIRST_STAGE + len(STAGES)]
    return {stage: seconds * part / sum(ticks) for stage, part in zip(STAGES, ticks, strict=True)} if any(ticks) else {}


def _part(progress: Progress | None, start: float) -> Progress | None:
    """Return what is told of one half of the work, as part of the whole."""
    return progress and (lambda stage, share: progress(stage, start + share / 2))
