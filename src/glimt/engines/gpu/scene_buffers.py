"""A packed scene in the buffers of the GPU, and where in them each kind of record begins."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from glimt.engines.gpu.buffers import Buffer
from glimt.engines.gpu.device import Device
from glimt.layout import (
    COMPRESSED_NODE,
    FACE,
    INSTANCE,
    LIGHT,
    MESH_KIND,
    PLACEMENT,
    SPHERE_KIND,
    TRIANGLE,
    TRIANGLE_BLOCK,
    WALK_OF_MANY,
    WALK_OF_ONE,
    WALK_WITHOUT_TREES,
    dtype,
)
from glimt.packed import PackedScene
from glimt.packed.compressed_nodes import CompressedTrees, compress

_LIGHTS_AHEAD = 16
"""Lights there is room for without laying the records out anew."""
_LEFT_OVER = 7
"""Children of a node that a ray may have to come back to, when it goes on with the eighth."""
_LABELS = {"nodes": "the trees", "blocks": "triangles", "records": "instances and materials", "geometry": "vertices",
           "texels": "textures"}
"""What errors call the buffers."""


class SceneBuffers:
    """Five buffers: of nodes, leaf blocks, records, geometry and texels.

    Attributes
    ----------
    buffers : dict
        By the names that kernels have for them.
    starts : dict
        First word of each kind of record in its buffer, and how many placements there are, by the names of FRAME's
        fields.
    walk : int
        WALK_OF_MANY and so on.
    stack_entries : int
        What a walk down both trees may have to come back to, at most.
    """

    def __init__(self, device: Device) -> None:
        self.buffers = {name: Buffer(device, label) for name, label in _LABELS.items()}
        self.starts: dict[str, int] = {}
        self.walk, self.stack_entries = WALK_OF_MANY, 0
        self._light_room = 0
        self._scene: PackedScene | None = None
        self._trees: CompressedTrees | None = None
        self._device = device

    def upload(self, scene: PackedScene, light_count: int) -> bool:
        """Take over what differs from the scene before; lights alone are one small write.

        Returns
        -------
        Whether rays may take much longer now than before: meshes are others, or placed more often.
        """
        before, self._scene = self._scene, None  # of what fails halfway, nothing counts as taken over
        dearer = self._take_over(scene, before, light_count)
        self._scene = scene
        return dearer

    def _take_over(self, scene: PackedScene, before: PackedScene | None, light_count: int) -> bool:
        if before is not None and _same_but_lights(before, scene) and light_count <= self._light_room:
            self.write("lights", scene.lights)
            return False
        self._upload_trees(scene, before)
        self._upload_records(scene, light_count)
        if before is None or scene.texels is not before.texels:
            self.buffers["texels"].upload(scene.texels)
        if before is None or any(new is not old for new, old in zip(
                (scene.triangles, scene.vertices, scene.tangents),
                (before.triangles, before.vertices, before.tangents), strict=True)):
            self.starts |= _join(self.buffers["geometry"], triangles=_triangles_by_number(scene),
                                 vertices=scene.vertices, tangents=scene.tangents)
        return (before is None or scene.blas_blocks is not before.blas_blocks
                or scene.instances.size > before.instances.size)

    def _upload_trees(self, scene: PackedScene, before: PackedScene | None) -> None:
        same_meshes = before is not None and (scene.blas_nodes is before.blas_nodes
                                              and scene.blas_blocks is before.blas_blocks)
        if not same_meshes or scene.spans.size:
            scene = scene._replace(blas_blocks=_blocks_with_numbers(scene))
        trees = self._trees = compress(scene, self._trees if same_meshes else None)
        mesh_nodes = trees.blas_nodes.size // COMPRESSED_NODE.words
        upper = trees.tlas_nodes.reshape(-1, COMPRESSED_NODE.words).copy()
        upper[:, COMPRESSED_NODE.child_base] += np.uint32(mesh_nodes)
        self.buffers["nodes"].upload(np.concatenate([trees.blas_nodes, upper.ravel()]))
        # Without trees, leaves are tested in the order that spans count them in.
        blocks = scene.blas_blocks.view(np.uint32) if scene.spans.size else trees.blas_blocks
        places = _placements(scene, trees)
        self.buffers["blocks"].upload(np.concatenate([blocks, places.view(np.uint32)]))
        self.starts |= {"scene_root": mesh_nodes, "placements": blocks.size, "placement_count": len(places)}
        self.walk = (WALK_WITHOUT_TREES if scene.spans.size else WALK_OF_ONE if len(places) == 1 else WALK_OF_MANY)
        levels = trees.blas_depth + (trees.tlas_depth if self.walk == WALK_OF_MANY else 0)
        self.stack_entries = levels * _LEFT_OVER

    def _upload_records(self, scene: PackedScene, light_count: int) -> None:
        self._light_room = light_count + _LIGHTS_AHEAD
        lights = np.zeros(self._light_room * LIGHT.words, np.float32)
        lights[:scene.lights.size] = scene.lights
        self.starts |= _join(self.buffers["records"], instances=scene.instances, materials=scene.materials,
                             textures=scene.textures, levels=scene.levels, lights=lights,
                             tints=np.zeros(3 * self._light_room, np.float32), spans=scene.spans)

    def write(self, name: str, values: NDArray[np.float32]) -> None:
        """Write records of a kind that there is room for: "lights", or their "tints"."""
        if values.size:
            with self._device.doing(f"writing {name}"):
                self._device.gpu.queue.write_buffer(self.buffers["records"].handle, 4 * self.starts[name],
                                                    np.ascontiguousarray(values).reshape(-1).view(np.uint32))


def _triangles_by_number(scene: PackedScene) -> NDArray[Any]:
    """Return the TRIANGLE records in the order of the triangles' numbers: what `_blocks_with_numbers` refers to."""
    faces, starts = scene.faces.view(dtype(FACE)), _mesh_starts(scene)
    triangles = np.empty((len(faces), TRIANGLE.words), np.float32)
    place = np.repeat(starts, np.diff([*starts, len(faces)])) + faces["number"]
    triangles[place] = scene.triangles.reshape(-1, TRIANGLE.words)
    return triangles


def _blocks_with_numbers(scene: PackedScene) -> NDArray[np.float32]:
    """Return the leaf blocks with the triangles' numbers in their meshes, by which ties are broken."""
    blocks = scene.blas_blocks.copy()
    prims = blocks.view(np.int32).reshape(-1, TRIANGLE_BLOCK.words)[:, TRIANGLE_BLOCK.prim:]
    mesh = np.cumsum(prims[:, :1] == 0) - 1  # a mesh begins with its triangle 0
    used, numbers = prims >= 0, scene.faces.view(dtype(FACE))["number"]
    prims[used] = numbers[(_mesh_starts(scene)[mesh][:, None] + prims)[used]]
    return blocks


def _mesh_starts(scene: PackedScene) -> NDArray[Any]:
    """Return where the triangles of each mesh begin."""
    records = scene.instances.view(dtype(INSTANCE))
    return np.union1d(0, records["first_triangle"][records["kind"] == MESH_KIND])


def _placements(scene: PackedScene, trees: CompressedTrees) -> NDArray[Any]:
    """Return a PLACEMENT for each leaf of the scene's tree."""
    records = scene.instances.view(dtype(INSTANCE))[trees.tlas_instances]
    places = np.zeros(len(records), dtype(PLACEMENT))
    places["world_to_object"], places["kind"] = records["world_to_object"], records["kind"]
    places["inst"], places["root"] = trees.tlas_instances, trees.roots[trees.tlas_instances]
    spheres = records["kind"] == SPHERE_KIND
    places["world_to_object"][spheres, :3] = records["center"][spheres]
    places["world_to_object"][spheres, 3] = records["radius"][spheres]
    return places


def _same_but_lights(a: PackedScene, b: PackedScene) -> bool:
    return all(old is new for name, old, new in zip(a._fields, a, b, strict=True) if name != "lights")


def _join(buffer: Buffer, **arrays: NDArray[Any]) -> dict[str, int]:
    """Upload arrays one after another; return where each begins, in words."""
    starts, first = {}, 0
    for name, array in arrays.items():
        starts[name], first = first, first + array.size
    buffer.upload(np.concatenate([array.reshape(-1).view(np.uint32) for array in arrays.values()]))
    return starts
