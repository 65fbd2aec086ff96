"""Rays through Embree, as fast as its callers get it to go."""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from glimt.bench.embree import EmbreeScene, embree_library
from glimt.lanes import atomic_add

_COHERENT = 1 << 16  # RTC_RAY_QUERY_FLAG_COHERENT
_ROWS = 21  # words of RTCRayHit: 12 of ray, 9 of hit with the two instance IDs of newer builds
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

    def get(self, how: Configuration, occlusion: bool) -> Trace:
        """Return f(rays, t, prims, chunk), which any number of threads may call with one `chunk`, the next to take.

        It traces (7, n) rays, their origins, directions and ends, n any number. Closest hits are answered by (n,) t,
        inf for none, and (n,) prims, -1 for none; occlusion by t below 0 where something is met, and no prims.
        """
        arguments = np.zeros(16, np.int32)  # RTCIntersectArguments: flags, feature mask, pointers
        arguments[0], arguments[1] = _COHERENT if how.coherent else 0, -1
        kernel, scene = _tracer(how.width, occlusion), self._scene

        def trace(rays: NDArray[np.float32], t: NDArray[np.float32], prims: NDArray[np.int32],
                  chunk: NDArray[np.int64]) -> None:
            kernel(scene.handles[how.quality, how.flat], rays, t, prims, arguments, chunk)

        return trace


@functools.cache
def _tracer(width: int, occlusion: bool) -> Any:
    """Compile a loop that hands rays to Embree `width` at a time.

    It copies each ray from arrays into Embree's struct and the answer back: some nanoseconds a packet that a program
    which makes its rays in that struct does not pay, as the engine pays for making its rays.
    """
    call = getattr(embree_library(), f"rtc{'Occluded' if occlusion else 'Intersect'}{width}")

    @numba.njit(nogil=True)
    def trace(scene, rays, t, prims, arguments, chunk):  # type: ignore[no-untyped-def]
        memory = np.zeros(_ROWS * width + 32, np.float32)
        first_word = (-memory.ctypes.data % 64) // 4
        floats = memory[first_word:first_word + _ROWS * width].reshape(_ROWS, width)
        words = floats.view(np.int32)
        where, how, n = floats.ctypes.data, arguments.ctypes.data, rays.shape[1]
        valid_memory = np.full(32, -1, np.int32)
        first_word = (-valid_memory.ctypes.data % 64) // 4
        valid = valid_memory[first_word:first_word + 16]
        all_valid = valid.ctypes.data
        words[_MASK] = -1
        while True:
            first = atomic_add(chunk, 0, 1) * _CHUNK
            if first >= n:
                return
            for i in range(first, min(first + _CHUNK, n), width):
                count = min(width, n - i)
                if count == width:
                    for axis in range(3):
                        for k in range(width):
                            floats[axis, k] = rays[axis, i + k]
                            floats[4 + axis, k] = rays[3 + axis, i + k]
                    for k in range(width):
                        floats[_FAR, k] = rays[6, i + k]
                        words[_GEOMETRY, k] = -1
                else:
                    for k in range(count):
                        for axis in range(3):
                            floats[axis, k] = rays[axis, i + k]
                            floats[4 + axis, k] = rays[3 + axis, i + k]
                        floats[_FAR, k] = rays[6, i + k]
                        words[_GEOMETRY, k] = -1
                    for k in range(16):
                        valid[k] = -1 if k < count else 0
                if width == 16:
                    call(all_valid, scene, where, how)
                else:
                    call(scene, where, how)
                for k in range(count):
                    t[i + k] = floats[_FAR, k]
                    if not occlusion:
                        prims[i + k] = words[_PRIM, k] if words[_GEOMETRY, k] != -1 else -1

    return trace
