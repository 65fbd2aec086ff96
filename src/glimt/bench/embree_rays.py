"""Rays through Embree, as fast as its callers get it to go."""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from glimt.bench.embree import EmbreeScene, embree_library
from glimt.lanes import LANES, atomic_add, i32, load, load_int, scalar, select, store, store_scalar

_COHERENT = 1 << 16  # RTC_RAY_QUERY_FLAG_COHERENT
_WORDS = 21  # of RTCRayHit: 12 of ray, 9 of hit with the two instance IDs of newer builds
_PLACES = (0, 1, 2, 4, 5, 6, 8)  # of origin, direction and end
_FAR, _MASK, _PRIM, _GEOMETRY = 8, 9, 17, 18
_CHUNK = 4096
"""Rays that a thread takes at once."""

Trace = Callable[[NDArray[np.float32], NDArray[np.float32], NDArray[np.int32], NDArray[np.int64]], None]


class Configuration(NamedTuple):
    """One way to ask Embree: trees (see `EmbreeScene`), 16 rays or 1 at a time, called coherent or not."""

    quality: str
    flat: bool
    width: int
    coherent: bool

    def __str__(self) -> str:
        return f"{self.quality}{' flat' if self.flat else ''} {self.width}-wide{' coherent' if self.coherent else ''}"


class Tracers:
    """Answers rays by the Embree scene that it was made for, in any of its `configurations`."""

    def __init__(self, scene: EmbreeScene) -> None:
        self._scene = scene
        self.configurations = [Configuration(*trees, width, coherent) for trees in scene.handles
                               for width, coherent in ((16, True), (16, False), (1, False))]

    def get(self, how: Configuration, occlusion: bool, shared_origin: bool = False) -> Trace:
        """Return f(rays, t, prims, chunk), which any number of threads may call with one `chunk`, the next to take.

        It traces (7, n) rays, their origins, directions and ends, n any number. Closest hits are answered by (n,) t,
        inf for none, and (n,) prims, -1 for none; occlusion by t below 0 where something is met, and no prims.
        `shared_origin`: all start where the first does.
        """
        arguments = np.zeros(16, np.int32)  # RTCIntersectArguments: flags, feature mask, pointers
        arguments[0], arguments[1] = _COHERENT if how.coherent else 0, -1
        kernel, scene = _tracer(how.width, occlusion, shared_origin), self._scene

        def trace(rays: NDArray[np.float32], t: NDArray[np.float32], prims: NDArray[np.int32],
                  chunk: NDArray[np.int64]) -> None:
            kernel(scene.handles[how.quality, how.flat], rays, t, prims, arguments, chunk)

        return trace


@functools.cache
def _tracer(width: int, occlusion: bool, shared_origin: bool) -> Any:
    """Compile a loop that hands rays to Embree `width` at a time.

    It copies each ray from arrays into Embree's struct and the answer back, a nanosecond a ray in packets and five
    alone, which a program that makes its rays in that struct does not pay; nor is it charged for making them, as a
    frame is. An origin that all share is copied once: Embree leaves it there. Where packets lie across two cache lines
    it costs Embree a thirtieth of its camera rays and glimt a tenth.
    """
    first_row = 3 if shared_origin else 0
    call = getattr(embree_library(), f"rtc{'Occluded' if occlusion else 'Intersect'}{width}")

    @numba.njit(nogil=True)
    def trace(scene, rays, t, prims, arguments, chunk):  # type: ignore[no-untyped-def]
        memory = np.zeros(_WORDS * width + 32, np.float32)
        first_word = (-memory.ctypes.data % 64) // 4
        floats = memory[first_word:first_word + _WORDS * width]
        words = floats.view(np.int32)
        valid_memory = np.full(32, -1, np.int32)
        first_word = (-valid_memory.ctypes.data % 64) // 4
        valid = valid_memory[first_word:first_word + 16]
        where, how, mask, n = floats.ctypes.data, arguments.ctypes.data, valid.ctypes.data, rays.shape[1]
        words[_MASK * width:(_MASK + 1) * width] = -1
        for row in range(first_row if n else 0):
            floats[_PLACES[row] * width:(_PLACES[row] + 1) * width] = rays[row, 0]
        while True:
            first = atomic_add(chunk, 0, 1) * _CHUNK
            if first >= n:
                return
            for i in range(first, min(first + _CHUNK, n), width):
                count = min(width, n - i)
                if count == 16:
                    for k in range(0, 16, LANES):
                        for row in range(first_row, 7):
                            store(floats, _PLACES[row] * 16 + k, load(rays, row * n + i + k))
                        store(words, _GEOMETRY * 16 + k, i32(-1))
                else:
                    for k in range(count):
                        for row in range(first_row, 7):
                            store_scalar(floats, _PLACES[row] * width + k, scalar(rays, row * n + i + k))
                        store_scalar(words, _GEOMETRY * width + k, -1)
                if width == 16:
                    if count < 16:  # the last packet
                        valid[count:] = 0
                    call(mask, scene, where, how)
                else:
                    call(scene, where, how)
                if count == 16:
                    for k in range(0, 16, LANES):
                        store(t, i + k, load(floats, _FAR * 16 + k))
                        if not occlusion:
                            met = load_int(words, _GEOMETRY * 16 + k) != -1
                            store(prims, i + k, select(met, load_int(words, _PRIM * 16 + k), -1))
                else:
                    for k in range(count):
                        t[i + k] = floats[_FAR * width + k]
                        if not occlusion:
                            prims[i + k] = words[_PRIM * width + k] if words[_GEOMETRY * width + k] != -1 else -1

    return trace
