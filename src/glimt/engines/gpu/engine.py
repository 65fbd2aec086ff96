"""The engine for graphics processors: the five stages over buffers of rays, area by area."""

import contextlib
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from glimt.debug_view import DebugView
from glimt.engines.engine import Hits, Progress, Samples
from glimt.engines.gpu.adapters import import_wgpu
from glimt.engines.gpu.buffers import Buffer, Download
from glimt.engines.gpu.commands import Commands, Timer
from glimt.engines.gpu.device import Device, open_device
from glimt.engines.gpu.pace import LONGEST_SECONDS, Area, Areas, Pace
from glimt.engines.gpu.scene_buffers import SceneBuffers
from glimt.engines.gpu.stages import Group, Stages, counter_words, frame_records, path_bytes
from glimt.errors import GlimtError, RenderCancelled
from glimt.film import Counters, DistantFilm, Film, sums_for
from glimt.layout import COUNTER, FRAME, MISS, PATH, VIEW, dtype
from glimt.packed import PackedScene

_FINEST = 4
"""Adaptive sampling is not for GPUs, whose neighbours go the same way: every pixel has the samples of the finest."""
_MOST_PIXELS = 1 << 20
"""Pixels at once: with two paths each, the 128 MiB of a binding that every adapter owes."""
_SHOWS: tuple[DebugView, ...] = ("depth", "barycentrics", "instances", "normals", "shadows", "nodes")
"""In the order of the constants of debug.wgsl."""


class GpuEngine:
    """Renders with compute kernels in WGSL, on Vulkan, Metal or Direct3D 12.

    Parameters
    ----------
    threads : int, optional
        What the host may use beside it.
    group : (width, height)
        The shape of a workgroup.
    counting : bool
        Count visited nodes and triangle blocks too, in `visits`; slower.

    Attributes
    ----------
    visits : dict
        With `counting`, of the last film: "nodes" and "blocks", (3,) int64 each, by primary, shadow and mirror rays.
    """

    def __init__(self, threads: int | None = None, *, group: tuple[int, int] = (8, 8), counting: bool = False) -> None:
        self.threads = threads or 1
        self._group, self._counting = Group(*group), counting
        self._device = open_device(group=group)
        self._scene = SceneBuffers(self._device)
        own = {name: Buffer(self._device, name) for name in ("frame", "paths", "film", "counters")}
        own["dispatch"] = Buffer(self._device, "dispatch", 16, extra_usage=import_wgpu().BufferUsage.INDIRECT)
        self._buffers = {**own, **self._scene.buffers}
        self._timer, self._download = Timer(self._device), Download(self._device)
        self._clock, self._pace = time.perf_counter, Pace()
        self._stages: Stages | None = None
        self._light_count = 0
        self._too_slow = False  # of the last submission
        self._keeps_films = False
        self._cancelled: threading.Event | None = None  # of the render at work
        self._one_at_a_time = threading.Lock()
        self.visits: dict[str, NDArray[np.int64]] = {}

    @property
    def description(self) -> str:
        """What computes."""
        return self._device.adapter.summary

    @property
    def uses_clearances(self) -> bool:
        """Rays begin where they leave."""
        return False

    def prepare(self, progress: Progress | None = None) -> None:
        """Do nothing: pipelines depend on how deep a scene's trees are."""

    def is_ready(self, samples: Samples, shows: DebugView | None = None) -> bool:
        """Return True: what its driver compiles late takes less than a second."""
        return True

    def keep_films(self) -> Device:
        """Leave films on the GPU from now on (see `Engine.keep_films`); return its device."""
        self._keeps_films = True
        return self._device

    def upload(self, scene: PackedScene, light_count: int) -> None:
        """Take over what has changed of a scene."""
        with self._one_at_a_time:
            if self._scene.upload(scene, light_count):
                self._pace.restart()
            self._light_count = light_count
            if self._stages is None:
                self._stages = Stages(self._device, self._group, self._counting)
            self._stages.suit(self._scene.walk, self._scene.stack_entries)

    def render(self, view: NDArray[np.float32], size: tuple[int, int], samples: Samples, max_bounces: int,
               progress: Progress | None = None, film: Film | None = None) -> Film:
        """Render the uploaded scene (see `Engine.render`); "adaptive" is 4×4 samples everywhere."""
        start = time.perf_counter()
        width, height = size
        grid = _FINEST if samples == "adaptive" else samples
        keeps = self._keeps_films and 16 * width * height <= self._device.limits["max-storage-buffer-binding-size"]
        sums = self._kept_sums(size, film) if keeps else sums_for(size, film)
        totals = np.zeros(counter_words(max_bounces), np.int64)
        stages: dict[str, float] = {}
        with self._one_at_a_time, self._begin() as stop_if_cancelled:
            left, done = self._divide(size, max_bounces), 0.0
            while area := left.take(self._most_pixels()):
                if progress:
                    progress("rendering", done)
                self._tell(view, size, area, grid, max_bounces)
                taken = self._run_samples(area, grid * grid, max_bounces, self._bringing(area, width, sums),
                                          stop_if_cancelled)
                if taken is None:
                    left.put_back(area)
                    continue
                totals, done = totals + taken[0], left.done
                _add(taken[1], stages)
            stop_if_cancelled()
        self.visits = {"nodes": totals[COUNTER.nodes:][:3], "blocks": totals[COUNTER.blocks:][:3]}
        counters = Counters(width * height * grid * grid, int(totals[COUNTER.shadow]),
                            int(totals[COUNTER.paths + 1:].sum()), int(totals[COUNTER.non_finite]))
        seconds = time.perf_counter() - start
        if isinstance(sums, Buffer):
            return DistantFilm(size, sums, lambda: self._fetch(sums, size), counters, seconds, stages)
        return Film(sums, counters, seconds, stages)

    def render_debug(self, view: NDArray[np.float32], size: tuple[int, int], shows: DebugView,
                     light_tints: NDArray[np.float32]) -> NDArray[np.float32]:
        """Render numbers a pixel instead of radiance (see `Engine.render_debug`)."""
        values = np.empty((size[1], size[0], 4), np.float32)
        with self._one_at_a_time, self._begin() as stop_if_cancelled:
            self._scene.write("tints", light_tints)
            left = self._divide(size, 0)
            while area := left.take(self._most_pixels()):
                stop_if_cancelled()
                self._tell(view, size, area, 1, 0, shows=_SHOWS.index(shows))
                self._run(["create_rays", "debug"], 0, self._capacity(area), self._bringing(area, size[0], values))
            stop_if_cancelled()
        if shows == "instances":  # floats up to here: GPUs may take the bits of small integers for zeros
            values[..., :2] = values[..., :2].astype(np.int32).view(np.float32)
        return values

    def find_hits(self, rays: NDArray[np.float32]) -> Hits:
        """Return what rays meet first (see `Engine.find_hits`)."""
        paths = np.zeros(rays.shape[1], dtype(PATH))
        paths["origin"], paths["direction"] = rays[:3].T, rays[3:6].T
        paths["t"] = np.minimum(rays[6], np.float32(3e38))
        with self._one_at_a_time:
            self._need_scene()
            self._pace.expect(1)
            first = 0
            while first < len(paths):
                count = min(self._most_pixels(), len(paths) - first)
                self._follow(paths[first:first + count])
                first += count
        inst = paths["inst"].copy()
        return Hits(np.where(inst == MISS, np.float32(np.inf), paths["t"]), paths["u"].copy(), paths["v"].copy(),
                    paths["prim"].copy(), inst)

    def cancel(self) -> None:
        """Stop what is being rendered after the sample at work."""
        cancelled = self._cancelled
        if cancelled:
            cancelled.set()

    def _need_scene(self) -> None:
        if self._stages is None:
            raise GlimtError("no scene was uploaded to the engine")

    @contextlib.contextmanager
    def _begin(self) -> Iterator[Callable[[], None]]:
        """Give what raises RenderCancelled once `cancel` was called; each render has its own."""
        self._need_scene()
        cancelled = self._cancelled = threading.Event()

        def stop_if_cancelled() -> None:
            if cancelled.is_set():
                raise RenderCancelled

        try:
            yield stop_if_cancelled
        finally:
            self._cancelled = None

    def _divide(self, size: tuple[int, int], max_bounces: int) -> Areas:
        """Return the areas of a picture, for rays to its lights from each bounce at most."""
        self._pace.expect((1 + max_bounces) * (1 + self._light_count))
        return Areas(size, self._group)

    def _most_pixels(self) -> int:
        """Return how many may be rendered at once: in good time, and as the buffers may hold."""
        return min(self._pace.pixels, _MOST_PIXELS,
                   self._device.limits["max-storage-buffer-binding-size"] // path_bytes(1))

    def _capacity(self, area: Area) -> int:
        """Return how many paths an area begins with: those of whole tiles."""
        return -(-area.width // self._group.width) * -(-area.height // self._group.height) * self._group.size

    def _tell(self, view: NDArray[np.float32], size: tuple[int, int], area: Area, grid: int, max_bounces: int,
              shows: int = 0, capacity: int = 0) -> None:
        """Write what all dispatches of an area are told, and have room for its paths."""
        capacity = capacity or self._capacity(area)
        self._buffers["paths"].reserve(path_bytes(capacity))
        self._buffers["film"].reserve(2 * 16 * capacity)
        base = np.zeros(1, dtype(FRAME))
        for name, value in {**self._scene.starts, "width": size[0], "height": size[1], "first_column": area.column,
                            "first_row": area.row, "columns": area.width, "rows": area.height, "capacity": capacity,
                            "light_count": self._light_count, "shows": shows}.items():
            base[name] = value
        base["view"] = view
        records = frame_records(base, grid, max_bounces, float(view[VIEW.spread]))
        self._buffers["frame"].upload(records.view(np.uint32))

    def _follow(self, paths: NDArray[Any]) -> None:
        """Write into PATH records what they meet."""
        count = len(paths)
        self._tell(np.zeros(int(VIEW.words), np.float32), (count, 1), Area(0, 0, count, 1), 1, 0, capacity=count)
        self._buffers["paths"].upload(paths)
        counters = np.zeros(counter_words(0), np.uint32)
        counters[COUNTER.paths] = count
        self._buffers["counters"].upload(counters)
        self._run(["intersect"], 0, count, None, counters)
        self._download.read(self._buffers["paths"], paths)

    def _kept_sums(self, size: tuple[int, int], film: Film | None) -> Buffer:
        """Return where the sums of a picture stay on the GPU: over those of `film`, if they fit."""
        if isinstance(film, DistantFilm) and film.size == size:
            kept: Buffer = film.place
            return kept
        return Buffer(self._device, "film that is shown", 16 * size[0] * size[1])

    def _fetch(self, sums: Buffer, size: tuple[int, int]) -> NDArray[np.float32]:
        """Bring back what was left on the GPU."""
        with self._one_at_a_time:
            return self._download.read(sums, np.empty((size[1], size[0], 4), np.float32))

    def _bringing(self, area: Area, columns: int, sums: NDArray[np.float32] | Buffer) -> Callable[[Commands], None]:
        """Return what has an area brought to its place in a picture of so many columns, with what is submitted next."""
        def bring(commands: Commands) -> None:
            film = self._buffers["film"]
            if not isinstance(sums, Buffer):
                self._download.want(film, sums[area.row:area.row + area.height, area.column:area.column + area.width])
            elif area.width == columns:
                commands.copy(film, 0, sums, 16 * area.row * columns, 16 * columns * area.height)
            else:
                for row in range(area.height):
                    commands.copy(film, 16 * row * area.width, sums, 16 * ((area.row + row) * columns + area.column),
                                  16 * area.width)

        return bring

    def _run_samples(self, area: Area, samples: int, max_bounces: int, bring: Callable[[Commands], None],
                     stop_if_cancelled: Callable[[], None]) -> tuple[NDArray[np.int64], dict[str, float]] | None:
        """Render an area and have it brought; return its counters and the seconds of its stages.

        None where it takes too long and has samples to come: it is to be begun again, in smaller parts.
        """
        totals, stages = np.zeros(counter_words(max_bounces), np.int64), dict[str, float]()
        for sample in range(samples):
            stop_if_cancelled()
            if sample and self._too_slow and self._capacity(area) > self._group.size:
                return None
            totals += self._run_sample(sample, self._capacity(area), max_bounces,
                                       bring if sample == samples - 1 else None)
            _add(self._timer.seconds(), stages)  # there already, with the counters
        return totals, stages

    def _run_sample(self, sample: int, capacity: int, max_bounces: int,
                    bring: Callable[[Commands], None] | None) -> NDArray[np.int64]:
        """Run all stages of one sample of an area, and have its sums brought if wanted; return its counters."""
        counters = np.zeros(counter_words(max_bounces), np.uint32)
        counters[COUNTER.paths] = capacity
        self._buffers["counters"].upload(counters)
        stages = ["create_rays", "intersect", "shade"]
        for _ in range(max_bounces):
            stages += ["bounce", "prepare", "intersect", "shade"]
        self._run([*stages, "resolve"], sample * (max_bounces + 1), capacity, bring, counters)
        taken: NDArray[np.int64] = counters.astype(np.int64)
        return taken

    def _run(self, stages: list[str], record: int, capacity: int, bring: Callable[[Commands], None] | None = None,
             counters: NDArray[np.uint32] | None = None) -> None:
        """Submit dispatches, each after the one before, and bring back what is asked for."""
        assert self._stages is not None
        commands, depth = Commands(self._device, self._download, self._timer), 0
        self._stages.bind(self._buffers)
        for stage in stages:
            depth += stage == "prepare"  # the mirror rays of the next depth are there
            whole = depth == 0 or stage == "resolve"
            self._stages.record(commands, stage, self._buffers, record + (0 if stage == "resolve" else depth),
                                capacity if whole else 1 if stage == "prepare" else None)
        if counters is not None:
            self._download.want(self._buffers["counters"], counters)
        if bring is not None:
            bring(commands)
        start = self._clock()
        commands.submit()
        self._download.take()
        seconds = self._clock() - start
        self._pace.learn(capacity, seconds)
        self._too_slow = seconds > LONGEST_SECONDS


def _add(more: dict[str, float], totals: dict[str, float]) -> None:
    """Add seconds by stage to those of before."""
    for stage, seconds in more.items():
        totals[stage] = totals.get(stage, 0.0) + seconds


assert set(_SHOWS) == set(get_args(DebugView)), "a debug view that debug.wgsl does not know"
