"""Scene objects to the arrays that engines read."""

import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from glimt import bvh, linalg
from glimt.errors import GlimtWarning
from glimt.layout import (
    INSTANCE,
    LEAF_STEP,
    MATERIAL,
    MESH_KIND,
    NO_TANGENTS,
    NODE,
    SPHERE_KIND,
    TANGENT,
    TRIANGLE,
    TRIANGLE_BLOCK,
    VERTEX,
    dtype,
)
from glimt.packed.frame import pack_lights
from glimt.packed.meshes import PackedMesh, pack_mesh
from glimt.packed.packed_scene import PackedScene
from glimt.packed.textures import TexturePacker
from glimt.scene import checks
from glimt.scene.instance import Instance
from glimt.scene.material import Material
from glimt.scene.mesh import Mesh
from glimt.scene.scene import Scene
from glimt.scene.sphere import Sphere

_BOX_PAD = 2e-6
"""World boxes grow by this share of their size and place: more than rounding takes from a ray on its way into object
space."""


def pack(scene: Scene, time: float = 0.0, threads: int = 1) -> PackedScene:
    """Return the arrays of a scene with its lights as they stand at `time` seconds."""
    for thing in scene.objects:
        checks.kind("scene", "one of objects", thing, Instance, Sphere)
    packer, shown = _Packer(threads), _materials_shown(scene)
    for thing in scene.objects:
        if isinstance(thing, Sphere):
            packer.add_sphere(thing)
        elif len(thing.mesh.triangles):
            packer.add_instance(thing, shown[id(thing.mesh)])
    return packer.finish(pack_lights(scene.lights, time))


def _materials_shown(scene: Scene) -> dict[int, list[Material]]:
    """Return the materials that the instances of a mesh show, by the mesh's id."""
    shown: dict[int, dict[int, Material]] = {}
    for thing in scene.instances():
        materials = [thing.material] if thing.material else thing.mesh.materials
        shown.setdefault(id(thing.mesh), {}).update((id(material), material) for material in materials)
    return {mesh: list(materials.values()) for mesh, materials in shown.items()}


class _Packer:
    """Gathers the parts of a scene, each mesh, material and texture once."""

    def __init__(self, threads: int) -> None:
        self.threads = threads
        self.textures = TexturePacker()
        self.materials: list[Any] = []
        self.instances: list[Any] = []
        self.boxes: list[tuple[NDArray[Any], NDArray[Any]]] = []
        self.meshes: list[tuple[PackedMesh, NDArray[np.int32]]] = []
        self._material_ids: dict[int, int] = {}
        self._placed: dict[int, dict[str, int]] = {}
        self._size = dict.fromkeys(("nodes", "blocks", "vertices", "tangents", "triangles"), 0)

    def add_material(self, material: Material) -> int:
        """Return the material's index."""
        if id(material) not in self._material_ids:
            self._material_ids[id(material)] = len(self.materials)
            record = np.zeros((), dtype(MATERIAL))
            for name in ("ambient", "diffuse", "specular", "exponent", "reflectivity", "normal_scale"):
                record[name] = getattr(material, name)
            record["diffuse_texture"] = self.textures.add(material.diffuse_texture, "color")
            record["normal_texture"] = self.textures.add(material.normal_texture, "data")
            self.materials.append(record)
        return self._material_ids[id(material)]

    def add_mesh(self, mesh: Mesh, shown: list[Material]) -> dict[str, int]:
        """Return the INSTANCE fields that say where the arrays of a mesh start on which materials `shown` are seen."""
        if id(mesh) not in self._placed:
            mapped = any(material.normal_texture is not None for material in shown)
            packed = pack_mesh(mesh, mapped and mesh.texcoords is not None, self.threads)
            size = self._size
            has_tangents = len(packed.tangents) > 0  # and then normals as well
            self._placed[id(mesh)] = {
                "root": size["nodes"], "first_triangle": size["triangles"],
                "flat": mesh.normals is None and not has_tangents,
                "tangent_shift": size["tangents"] - size["vertices"] if has_tangents else int(NO_TANGENTS)}
            ids = np.array([self.add_material(material) for material in mesh.materials], np.int32)
            assert mesh.material_ids is not None
            self.meshes.append((packed, ids[mesh.material_ids]))
            for name, rows in (("nodes", packed.tree.nodes.reshape(-1, NODE.words)), ("blocks", packed.blocks),
                               ("vertices", packed.vertices), ("tangents", packed.tangents),
                               ("triangles", packed.triangles)):
                size[name] += len(rows)
            textured = mapped or any(material.diffuse_texture is not None for material in shown)
            if textured and mesh.texcoords is None:
                warnings.warn(GlimtWarning(f"mesh {mesh.name!r} has textures but no texcoords; each shows the colour "
                                           "of its corner"), stacklevel=2)
        return self._placed[id(mesh)]

    def add_instance(self, instance: Instance, shown: list[Material]) -> None:
        """Place a mesh; `shown` are the materials of all its instances."""
        record = np.zeros((), dtype(INSTANCE))
        for name, value in self.add_mesh(instance.mesh, shown).items():
            record[name] = value
        matrix = instance.object_to_world
        record["kind"] = MESH_KIND
        record["material"] = self.add_material(instance.material) if instance.material else -1
        record["identity"] = np.array_equal(matrix, linalg.identity())
        record["object_to_world"] = matrix.ravel()
        record["world_to_object"] = linalg.inverse(matrix).ravel()
        self._append(record, *linalg.transform_box(matrix, *instance.mesh.bounds()))

    def add_sphere(self, sphere: Sphere) -> None:
        """Place a sphere."""
        record = np.zeros((), dtype(INSTANCE))
        record["kind"], record["material"] = SPHERE_KIND, self.add_material(sphere.material)
        record["center"], record["radius"] = sphere.center, sphere.radius
        self._append(record, np.subtract(sphere.center, sphere.radius), np.add(sphere.center, sphere.radius))

    def _append(self, record: Any, lo: NDArray[Any], hi: NDArray[Any]) -> None:
        record["extent"] = (hi - lo).max()
        pad = _BOX_PAD * (np.maximum(np.abs(lo), np.abs(hi)) + (hi - lo).max())
        self.boxes.append((lo - pad, hi + pad))
        self.instances.append(record)

    def finish(self, lights: NDArray[np.float32]) -> PackedScene:
        """Join everything; one empty record stands where a kind is absent, since no array may be empty."""
        boxes = np.array(self.boxes, np.float32).reshape(-1, 2, 3)
        tlas = bvh.build(boxes[:, 0], boxes[:, 1], self.threads, leaf_size=1)
        nodes, blocks, triangles, start = [], [], [], dict.fromkeys(self._size, 0)
        for mesh, material_ids in self.meshes:
            nodes.append(_shift_codes(mesh.tree.nodes, start["nodes"], start["blocks"]))
            blocks.append(mesh.blocks)
            rows = np.empty((len(mesh.triangles), TRIANGLE.words), np.int32)
            rows[:, :3], rows[:, 3] = mesh.triangles + start["vertices"], material_ids
            triangles.append(rows.view(np.float32))
            start["nodes"] += len(mesh.tree.nodes) // NODE.words
            start["blocks"] += len(mesh.blocks)
            start["vertices"] += len(mesh.vertices)
        textures, levels, texels = self.textures.arrays()
        return PackedScene(
            tlas_nodes=tlas.nodes, tlas_blocks=_words([tlas.leaf_prims.view(np.float32)], 4),
            blas_nodes=_words(nodes, NODE.words), blas_blocks=_words(blocks, TRIANGLE_BLOCK.words),
            instances=_records(self.instances, INSTANCE), triangles=_words(triangles, TRIANGLE.words),
            vertices=_words([mesh.vertices for mesh, _ in self.meshes], VERTEX.words),
            tangents=_words([mesh.tangents for mesh, _ in self.meshes], TANGENT.words),
            materials=_records(self.materials, MATERIAL), textures=textures, levels=levels, texels=texels,
            lights=lights)


def _shift_codes(nodes: NDArray[np.float32], first_node: int, first_block: int) -> NDArray[np.float32]:
    """Return a copy of a tree's nodes whose child codes count from the start of the joined arrays."""
    shifted = nodes.copy()
    codes = shifted.view(np.int32).reshape(-1, NODE.words)[:, NODE.child:NODE.unused]
    codes += np.where(codes >= 0, np.int32(first_node), np.int32(-first_block * LEAF_STEP))
    return shifted


def _words(parts: list[NDArray[np.float32]], record: int) -> NDArray[np.float32]:
    """Join arrays into one of words that starts on a cache line; at least one record long."""
    total = sum(part.size for part in parts)
    joined = bvh.aligned(max(total, record))
    joined[total:] = 0
    np.concatenate([part.ravel() for part in parts] or [joined[:0]], out=joined[:total])
    return joined


def _records(rows: list[Any], struct: Any) -> NDArray[np.float32]:
    return np.array(rows or [np.zeros((), dtype(struct))], dtype(struct)).view(np.float32)
