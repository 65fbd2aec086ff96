"""A frame's own rays, traced by Embree: what a frame's time is held against."""

import functools
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from glimt.bench.embree import EmbreeScene
from glimt.bench.embree_rays import Configuration, Trace, Tracers
from glimt.bench.measure import interleave
from glimt.engines.cpu.closest_hits import closest_hits
from glimt.engines.cpu.record import record_rays
from glimt.errors import GlimtError
from glimt.layout import aligned, aligned_copy
from glimt.packed import pack, pack_view
from glimt.scene.scene import Scene

Rays = NDArray[np.float32]
_TRIAL_RAYS, _TRIAL_ROUNDS = 1 << 18, 4
_STRETCH = 4096
_CLOSE = 1e-3
"""Distances that differ by less than this share are the same answer."""


class Yardstick:
    """The rays of a scene's frame at its camera, and Embree's quickest way to answer them.

    Primary and mirror rays are asked for the closest hit, shadow rays only whether something is met before their end.
    Each kind is asked in the configuration that wins a short trial. Rays are copied into Embree's structs (see
    `embree_rays`); making them, shading and the film are not in its time.

    Attributes
    ----------
    rays : dict of str to (7, n) float32
        Origins, directions and ends by kind, in the order the engine traces them; kinds without rays are left out.
    """

    def __init__(self, scene: Scene) -> None:
        self._packed, settings = pack(scene), scene.settings
        if isinstance(settings.samples, str):
            raise GlimtError("adaptive samples cannot be set against Embree's; choose samples from 1 to 64")
        view = pack_view(scene.camera_or_framing(), settings, scene.lights)
        recorded = record_rays(self._packed, len(scene.lights), view, (settings.width, settings.height),
                               settings.samples, settings.max_bounces)
        self.rays = {kind: rays for kind, rays in recorded.items() if rays.shape[1]}
        self._tracers = Tracers(EmbreeScene(scene))
        longest = max(rays.shape[1] for rays in self.rays.values())
        self._t, self._prims = aligned(longest), aligned(longest, np.int32)
        self._trials = {kind: self._trial(kind) for kind in self.rays}
        self._best = {kind: max(rates, key=lambda how, rates=rates: rates[how])  # type: ignore[misc]
                      for kind, rates in self._trials.items()}

    def _tracer(self, kind: str, how: Configuration) -> Trace:
        return self._tracers.get(how, kind == "shadow", kind == "primary")

    def _trial(self, kind: str) -> dict[Configuration, float]:
        """Return Mrays/s of one thread in each configuration, on stretches of the rays from all over the picture.

        The best of a few rounds, in processor time.
        """
        rays = self.rays[kind]
        step = max(1, rays.shape[1] // _TRIAL_RAYS)
        kept = np.arange(rays.shape[1]) // _STRETCH % step == 0
        sample = aligned_copy(rays[:, kept])

        def run(how: Configuration) -> None:
            self._tracer(kind, how)(sample, self._t, self._prims, np.zeros(1, np.int64))

        ways = self._tracers.configurations
        runs = {str(how): functools.partial(run, how) for how in ways}
        times = interleave(runs, _TRIAL_ROUNDS, time.thread_time)  # whoever else wants the processor
        return {how: sample.shape[1] / min(times[str(how)]) / 1e6 for how in ways}

    def trace(self, pool: ThreadPoolExecutor, threads: int) -> None:
        """Answer all rays once; a thread that runs out of one kind goes on to the next without waiting."""
        chunks = {kind: np.zeros(1, np.int64) for kind in self.rays}

        def work() -> None:
            for kind, rays in self.rays.items():
                self._tracer(kind, self._best[kind])(rays, self._t, self._prims, chunks[kind])

        for job in [pool.submit(work) for _ in range(threads)]:
            job.result()

    def describe(self) -> dict[str, dict[str, Any]]:
        """Return by kind: rays, the best configuration, and one thread's Mrays/s in the trial of it."""
        return {kind: {"rays": self.rays[kind].shape[1], "configuration": str(best),
                       "mrays": self._trials[kind][best]} for kind, best in self._best.items()}

    def differing(self) -> dict[str, float]:
        """Return by kind how many rays of a million Embree answers otherwise: hit or not, or at another distance."""
        return {kind: 1e6 * self._differing(kind) / rays.shape[1] for kind, rays in self.rays.items()}

    def _differing(self, kind: str) -> int:
        rays, occlusion, wrong = self.rays[kind], kind == "shadow", 0
        trace = self._tracer(kind, self._best[kind])
        for first in range(0, rays.shape[1], _TRIAL_RAYS):
            part = np.ascontiguousarray(rays[:, first:first + _TRIAL_RAYS])
            theirs, (floats, ids) = self._t[:part.shape[1]], closest_hits(self._packed, part)
            ours = np.where(ids[1] >= 0, floats[0], np.float32(np.inf))
            trace(part, theirs, self._prims, np.zeros(1, np.int64))
            if occlusion:
                wrong += int(np.count_nonzero((theirs < 0) != (ours < part[6])))
            else:
                met = np.isfinite(ours) & np.isfinite(theirs)
                same = np.isinf(ours) & np.isinf(theirs)
                same[met] = np.abs(ours[met] - theirs[met]) <= _CLOSE * theirs[met]
                wrong += int(np.count_nonzero(~same))
        return wrong
