"""Embree 4 as the yardstick: the library inside the `embreex` wheel, called without its Python binding."""

import ctypes
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from glimt.errors import GlimtError
from glimt.lanes import atomic_add

_FLOAT3, _UINT3 = 0x9003, 0x5003
_INDEX_BUFFER, _VERTEX_BUFFER = 0, 1
_COHERENT = 1 << 16
_WORDS = 21 * 16  # RTCRayHit16: 12 rows of ray, 9 of hit
_CHUNK = 4096
QUALITIES = {"medium": 1, "high": 2}


class Configuration(NamedTuple):
    """One way to ask Embree: build quality, 16 rays or 1 at a time, and whether to say that they are coherent."""

    quality: str
    width: int
    coherent: bool

    def __str__(self) -> str:
        return f"{self.quality} {self.width}-wide{' coherent' if self.coherent else ''}"


def _library() -> ctypes.CDLL:
    spec = find_spec("embreex")
    if spec is None or spec.origin is None:
        raise GlimtError("the benchmark compares with Embree, which is not installed: pip install 'glimt[bench]'")
    package = Path(spec.origin).parent
    found = [*package.parent.glob("embreex.libs/*embree4*"), *package.glob("**/*embree4*")]
    if not found:
        raise GlimtError(f"there is no Embree library in or beside {package}; install embreex again")
    __import__("embreex")  # its import finds the libraries that Embree itself needs
    library = ctypes.CDLL(str(found[0]))
    for name, result, arguments in (
            ("rtcNewDevice", ctypes.c_void_p, [ctypes.c_char_p]), ("rtcNewScene", ctypes.c_void_p, [ctypes.c_void_p]),
            ("rtcNewGeometry", ctypes.c_void_p, [ctypes.c_void_p, ctypes.c_int]),
            ("rtcSetSharedGeometryBuffer", None, [ctypes.c_void_p, ctypes.c_int, ctypes.c_uint, ctypes.c_int,
                                                  ctypes.c_void_p, *[ctypes.c_size_t] * 3]),
            ("rtcCommitGeometry", None, [ctypes.c_void_p]),
            ("rtcAttachGeometry", ctypes.c_uint, [ctypes.c_void_p, ctypes.c_void_p]),
            ("rtcSetSceneBuildQuality", None, [ctypes.c_void_p, ctypes.c_int]),
            ("rtcCommitScene", None, [ctypes.c_void_p]), ("rtcReleaseScene", None, [ctypes.c_void_p]),
            *((name, None, [ctypes.c_size_t] * count) for name, count in (
                ("rtcIntersect1", 3), ("rtcOccluded1", 3), ("rtcIntersect16", 4), ("rtcOccluded16", 4)))):
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library


class Embree:
    """Embree's trees over one mesh, one for each build quality."""

    def __init__(self, positions: NDArray[np.float32], triangles: NDArray[np.int32]) -> None:
        self._library = _library()
        # Embree reads the buffers where they are, and up to 16 bytes past the end.
        self._positions = np.concatenate([positions.astype(np.float32), np.zeros((2, 3), np.float32)])
        self._triangles = np.concatenate([triangles.astype(np.uint32), np.zeros((2, 3), np.uint32)])
        self._device = self._library.rtcNewDevice(b"")
        self._scenes = {name: self._build(quality, len(positions), len(triangles))
                        for name, quality in QUALITIES.items()}
        self._tracers = {(width, occlusion): _tracer(self._library, width, occlusion)
                         for width in (1, 16) for occlusion in (False, True)}

    def _build(self, quality: int, vertex_count: int, triangle_count: int) -> int:
        library = self._library
        scene, geometry = library.rtcNewScene(self._device), library.rtcNewGeometry(self._device, 0)
        library.rtcSetSharedGeometryBuffer(geometry, _VERTEX_BUFFER, 0, _FLOAT3, self._positions.ctypes.data, 0, 12,
                                           vertex_count)
        library.rtcSetSharedGeometryBuffer(geometry, _INDEX_BUFFER, 0, _UINT3, self._triangles.ctypes.data, 0, 12,
                                           triangle_count)
        library.rtcCommitGeometry(geometry)
        library.rtcAttachGeometry(scene, geometry)
        library.rtcSetSceneBuildQuality(scene, quality)
        library.rtcCommitScene(scene)
        return int(scene)

    def tracer(self, how: Configuration, occlusion: bool) -> Callable[..., None]:
        """Return f(rays, t, prims, chunk): traces (6, n) rays to (n,) t and prims; t < 0 where blocked before 1."""
        arguments = np.zeros(16, np.int32)  # RTCIntersectArguments: flags, feature mask, pointers
        arguments[0], arguments[1] = _COHERENT if how.coherent else 0, -1
        kernel, scene = self._tracers[how.width, occlusion], self._scenes[how.quality]

        def trace(rays: NDArray[np.float32], t: NDArray[np.float32], prims: NDArray[np.int32],
                  chunk: NDArray[np.int64]) -> None:
            kernel(scene, rays, t, prims, arguments, np.float32(1 if occlusion else np.inf), chunk)

        return trace


def _tracer(library: ctypes.CDLL, width: int, occlusion: bool) -> Any:
    """Compile a loop that hands rays to Embree `width` at a time; like ours, it copies them from arrays."""
    call = getattr(library, f"rtc{'Occluded' if occlusion else 'Intersect'}{width}")
    geometry_row, prim_row = (18, 17)

    @numba.njit(nogil=True)
    def trace(scene, rays, t, prims, arguments, t_max, chunk):  # type: ignore[no-untyped-def]
        memory = np.zeros(_WORDS + 48, np.float32)
        start = (-memory.ctypes.data % 64) // 4
        floats = memory[start:start + _WORDS].reshape(21, 16)[:, :width] if width == 16 \
            else memory[start:start + 21].reshape(21, 1)
        words = memory.view(np.int32)[start:start + _WORDS].reshape(21, 16)[:, :width] if width == 16 \
            else memory.view(np.int32)[start:start + 21].reshape(21, 1)
        valid_memory = np.full(32, -1, np.int32)
        valid = valid_memory.ctypes.data + (-valid_memory.ctypes.data % 64)
        where, how, n = memory.ctypes.data + 4 * start, arguments.ctypes.data, rays.shape[1]
        while True:
            first = atomic_add(chunk, 0, 1) * _CHUNK
            if first >= n:
                return
            for i in range(first, min(first + _CHUNK, n), width):
                for k in range(width):
                    for axis in range(3):
                        floats[axis, k] = rays[axis, i + k]
                        floats[4 + axis, k] = rays[3 + axis, i + k]
                    floats[3, k] = 0
                    floats[8, k] = t_max
                    words[9, k] = -1
                    words[geometry_row, k] = -1
                    words[prim_row, k] = -1
                if width == 16:
                    call(valid, scene, where, how)
                else:
                    call(scene, where, how)
                for k in range(width):
                    t[i + k] = floats[8, k]
                    prims[i + k] = words[prim_row, k]

    return trace
