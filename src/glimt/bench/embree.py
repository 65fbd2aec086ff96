"""Embree 4 as the yardstick: the library inside the `embreex` wheel, called without its Python binding."""

import ctypes
import functools
import weakref
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from glimt import linalg
from glimt.errors import GlimtError
from glimt.scene.instance import Instance
from glimt.scene.mesh import Mesh
from glimt.scene.scene import Scene

_FLOAT3, _FLOAT4, _UINT3, _FLOAT3X4_ROWS = 0x9003, 0x9004, 0x5003, 0x9134  # RTCFormat
_INDEX_BUFFER, _VERTEX_BUFFER = 0, 1  # RTCBufferType
_TRIANGLES, _SPHERES, _INSTANCE = 0, 50, 121  # RTCGeometryType
QUALITIES = {"medium": 1, "high": 2}  # RTCBuildQuality
_MOST_FLAT_TRIANGLES = 4_000_000
_SIGNATURES: dict[str, tuple[Any, list[Any]]] = {
    "rtcNewDevice": (ctypes.c_void_p, [ctypes.c_char_p]),
    "rtcGetDeviceError": (ctypes.c_int, [ctypes.c_void_p]),
    "rtcReleaseDevice": (None, [ctypes.c_void_p]),
    "rtcNewScene": (ctypes.c_void_p, [ctypes.c_void_p]),
    "rtcSetSceneBuildQuality": (None, [ctypes.c_void_p, ctypes.c_int]),
    "rtcCommitScene": (None, [ctypes.c_void_p]),
    "rtcReleaseScene": (None, [ctypes.c_void_p]),
    "rtcNewGeometry": (ctypes.c_void_p, [ctypes.c_void_p, ctypes.c_int]),
    "rtcSetSharedGeometryBuffer": (None, [ctypes.c_void_p, ctypes.c_int, ctypes.c_uint, ctypes.c_int, ctypes.c_void_p,
                                          *[ctypes.c_size_t] * 3]),
    "rtcSetGeometryInstancedScene": (None, [ctypes.c_void_p, ctypes.c_void_p]),
    "rtcSetGeometryTransform": (None, [ctypes.c_void_p, ctypes.c_uint, ctypes.c_int, ctypes.c_void_p]),
    "rtcCommitGeometry": (None, [ctypes.c_void_p]),
    "rtcAttachGeometry": (ctypes.c_uint, [ctypes.c_void_p, ctypes.c_void_p]),
    "rtcReleaseGeometry": (None, [ctypes.c_void_p]),
    "rtcIntersect1": (None, [ctypes.c_size_t] * 3),
    "rtcOccluded1": (None, [ctypes.c_size_t] * 3),
    "rtcIntersect16": (None, [ctypes.c_size_t] * 4),
    "rtcOccluded16": (None, [ctypes.c_size_t] * 4),
}


@functools.cache
def embree_library() -> ctypes.CDLL:
    """Return the library, its functions declared."""
    spec = find_spec("embreex")
    if spec is None or spec.origin is None:
        raise GlimtError("the benchmark compares with Embree, which is not installed: pip install 'glimt[bench]'")
    package = Path(spec.origin).parent
    found = [*package.parent.glob("embreex.libs/*embree4*"), *package.glob("**/*embree4*")]
    if not found:
        raise GlimtError(f"there is no Embree library in or beside {package}; install embreex again")
    __import__("embreex")  # its import finds the libraries that Embree itself needs
    library = ctypes.CDLL(str(found[0]))
    for name, (result, arguments) in _SIGNATURES.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library


class EmbreeScene:
    """Embree's trees over a scene: one set for each build quality and layout.

    Made as its users would make it: a mesh that stands where it was modelled is a geometry of the scene itself, any
    other placement an instance of its mesh's scene, and all spheres are one geometry of points. Where placements are
    few enough there is a second layout without instances, every placement moved in a mesh of its own: more memory,
    less work for a ray.

    Attributes
    ----------
    handles : dict of (str, bool) to int
        The RTCScene of each quality, with instances (False) or flattened (True).
    """

    def __init__(self, scene: Scene) -> None:
        self._library = embree_library()
        self._device = self._library.rtcNewDevice(None)
        self._buffers: list[Any] = []  # Embree reads the arrays where they are
        self._scenes: list[int] = []
        self._end = weakref.finalize(self, _release, self._library, self._device, self._scenes, self._buffers)
        moved = sum(len(thing.mesh.triangles) for thing in scene.instances() if not _stands(thing))
        layouts = (False, True) if 0 < moved <= _MOST_FLAT_TRIANGLES else (False,)
        self.handles = {(name, flat): self._build(scene, quality, flat) for flat in layouts
                        for name, quality in QUALITIES.items()}
        error = self._library.rtcGetDeviceError(self._device)
        if error:
            raise GlimtError(f"Embree cannot build the scene {scene.name!r}: its error {error}")

    def _build(self, scene: Scene, quality: int, flat: bool) -> int:
        whole, below = self._new_scene(quality), dict[int, int]()
        for thing in scene.instances():
            if not len(thing.mesh.triangles):
                continue
            if flat or _stands(thing):
                self._attach(whole, self._triangles(thing.mesh, thing.object_to_world))
                continue
            if id(thing.mesh) not in below:
                below[id(thing.mesh)] = self._new_scene(quality)
                self._attach(below[id(thing.mesh)], self._triangles(thing.mesh, linalg.identity()))
                self._library.rtcCommitScene(below[id(thing.mesh)])
            instance = self._library.rtcNewGeometry(self._device, _INSTANCE)
            matrix = np.ascontiguousarray(thing.object_to_world, np.float32)  # is copied
            self._library.rtcSetGeometryInstancedScene(instance, below[id(thing.mesh)])
            self._library.rtcSetGeometryTransform(instance, 0, _FLOAT3X4_ROWS, matrix.ctypes.data)
            self._attach(whole, instance)
        if scene.spheres():
            points = self._library.rtcNewGeometry(self._device, _SPHERES)
            records = np.array([[*thing.center, thing.radius] for thing in scene.spheres()], np.float32)
            self._share(points, _VERTEX_BUFFER, _FLOAT4, records)
            self._attach(whole, points)
        self._library.rtcCommitScene(whole)
        return whole

    def _new_scene(self, quality: int) -> int:
        handle = int(self._library.rtcNewScene(self._device))
        self._scenes.append(handle)
        self._library.rtcSetSceneBuildQuality(handle, quality)
        return handle

    def _triangles(self, mesh: Mesh, place: linalg.Array) -> int:
        geometry = int(self._library.rtcNewGeometry(self._device, _TRIANGLES))
        positions = linalg.transform_points(place, mesh.positions).astype(np.float32)
        self._share(geometry, _VERTEX_BUFFER, _FLOAT3, positions)
        self._share(geometry, _INDEX_BUFFER, _UINT3, mesh.triangles.astype(np.uint32))
        return geometry

    def _share(self, geometry: int, kind: int, layout: int, rows: NDArray[Any]) -> None:
        padded = np.concatenate([rows, np.zeros((2, rows.shape[1]), rows.dtype)])  # 16 bytes are read past the end
        self._buffers.append(padded)
        self._library.rtcSetSharedGeometryBuffer(geometry, kind, 0, layout, padded.ctypes.data, 0, padded.strides[0],
                                                len(rows))

    def _attach(self, scene: int, geometry: int) -> None:
        self._library.rtcCommitGeometry(geometry)
        self._library.rtcAttachGeometry(scene, geometry)
        self._library.rtcReleaseGeometry(geometry)


def _stands(thing: Instance) -> bool:
    return np.array_equal(thing.object_to_world, linalg.identity())


def _release(library: ctypes.CDLL, device: int, scenes: list[int], buffers: list[Any]) -> None:
    for scene in scenes:
        library.rtcReleaseScene(scene)
    library.rtcReleaseDevice(device)
    buffers.clear()
