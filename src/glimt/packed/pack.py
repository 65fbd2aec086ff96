"""Scene objects to the arrays that engines read."""

import warnings
import weakref
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from glimt import bvh
from glimt.errors import GlimtWarning
from glimt.layout import INSTANCE_BLOCK, SPAN, aligned
from glimt.packed.clearance import ClearanceFinder, LookAround
from glimt.packed.frame import pack_lights
from glimt.packed.geometry import Geometry, MeshUse, join_meshes
from glimt.packed.instances import PackedInstances, pack_instances
from glimt.packed.materials import pack_materials
from glimt.packed.packed_scene import PackedScene
from glimt.packed.textures import TexturePacker
from glimt.scene import checks
from glimt.scene.instance import Instance
from glimt.scene.material import Material
from glimt.scene.mesh import Mesh
from glimt.scene.scene import Scene
from glimt.scene.sphere import Sphere


def pack(scene: Scene, time: float = 0.0, threads: int = 1) -> PackedScene:
    """Return the arrays of a scene with its lights as they stand at `time` seconds."""
    return Packer(threads).pack(scene, time)


class _Contents(NamedTuple):
    """What a scene is made of, each thing once, in order of first appearance."""

    objects: list[Instance | Sphere]
    materials: dict[Material, int]
    shown: dict[Mesh, set[Material | None]]  # what instances of a mesh show: its own materials for None


class Packer:
    """Packs a scene that changes: what is as it was the last time is kept.

    Parameters
    ----------
    threads : int
    brute_force : bool
        Whether engines are to test everything instead of walking trees.

    Meshes and pixels of textures are never changed in place, and so are known again by identity. Materials and
    instances are read anew.
    """

    def __init__(self, threads: int = 1, brute_force: bool = False) -> None:
        self._threads, self._brute_force = threads, brute_force
        self._textures = TexturePacker(threads)
        self._uses: list[MeshUse] | None = None
        self._geometry: Geometry
        self._finder: ClearanceFinder | None = None
        self._boxes: tuple[NDArray[np.float32], NDArray[np.float32]] | None = None
        self._last_spans = np.zeros(0, np.float32)
        self._tlas: tuple[NDArray[np.float32], NDArray[np.float32]]  # nodes, blocks

    def pack(self, scene: Scene, time: float = 0.0) -> PackedScene:
        """Return the arrays of a scene with its lights as they stand at `time` seconds."""
        contents = _survey(scene)
        uses = [_mesh_use(mesh, shown, contents.materials) for mesh, shown in contents.shown.items()]
        if uses != self._uses:
            self._forget_finder()
            self._geometry = join_meshes(uses, self._threads)
            self._uses = uses
        geometry = self._geometry
        places = {mesh: k for k, mesh in enumerate(contents.shown)}
        instances = pack_instances(contents.objects, places, geometry.placements, contents.materials)
        tlas_nodes, tlas_blocks = self._upper_tree(instances)
        materials = pack_materials(list(contents.materials), self._textures)
        textures, levels, texels = self._textures.finish()
        return PackedScene(
            tlas_nodes=tlas_nodes, tlas_blocks=tlas_blocks,
            blas_nodes=geometry.nodes, blas_blocks=geometry.blocks, instances=instances.records,
            triangles=geometry.triangles, faces=geometry.faces, vertices=geometry.vertices,
            tangents=geometry.tangents,
            materials=materials, textures=textures, levels=levels, texels=texels,
            lights=pack_lights(scene.lights, time), spans=self._spans(contents.objects, places))

    def clearances(self) -> ClearanceFinder:
        """Return what finds the clearances of the meshes last packed, of those where they are not known."""
        if self._finder is None:
            here = self._geometry
            meshes = [LookAround(use.mesh, place.root, first, first + blocks, place.first_triangle, place.clear_unit)
                      for use, place, (first, blocks), found in zip(self._uses or [], here.placements, here.spans,
                                                                    here.clearances_found, strict=True)
                      if place.clear_unit and not found]
            self._finder = ClearanceFinder(here.nodes, here.blocks, here.faces, meshes)
            self._stop_finder = weakref.finalize(self, self._finder.stop)
        return self._finder

    def _forget_finder(self) -> None:
        if self._finder:
            self._stop_finder()  # and is not kept for later
        self._finder = None

    def _spans(self, objects: list[Instance | Sphere], places: dict[Mesh, int]) -> NDArray[np.float32]:
        """Return the SPAN records of instances and spheres, when everything is to be tested; the last ones if alike."""
        if self._brute_force:
            spans = np.zeros((len(objects), SPAN.words), np.int32)
            for span, thing in zip(spans, objects, strict=True):
                if isinstance(thing, Instance):
                    span[:] = self._geometry.spans[places[thing.mesh]]
            if not np.array_equal(spans.ravel(), self._last_spans.view(np.int32)):
                self._last_spans = spans.view(np.float32).ravel()
        return self._last_spans

    def _upper_tree(self, instances: PackedInstances) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return (nodes, blocks) of the tree over the instances: the last ones while no box has changed."""
        boxes = instances.lo, instances.hi
        if self._boxes is None or not all(map(np.array_equal, boxes, self._boxes)):
            tree = bvh.build(*boxes, self._threads, leaf_size=1)
            blocks = aligned(max(tree.leaf_prims.size, INSTANCE_BLOCK.words), np.int32)
            blocks[:tree.leaf_prims.size], blocks[tree.leaf_prims.size:] = tree.leaf_prims.ravel(), 0
            self._tlas, self._boxes = (tree.nodes, blocks.view(np.float32)), boxes
        return self._tlas


def _survey(scene: Scene) -> _Contents:
    contents = _Contents([], {}, {})
    objects, materials, shown = contents
    for thing in scene.objects:
        checks.kind("scene", "one of objects", thing, Instance, Sphere)
        if isinstance(thing, Sphere):
            materials.setdefault(thing.material, len(materials))
        elif len(thing.mesh.triangles):
            if thing.mesh not in shown:
                shown[thing.mesh] = set()
                for material in thing.mesh.materials:
                    materials.setdefault(material, len(materials))
            if thing.material is not None:
                materials.setdefault(thing.material, len(materials))
            shown[thing.mesh].add(thing.material)
        else:
            continue
        objects.append(thing)
    return contents


def _mesh_use(mesh: Mesh, shown: set[Material | None], material_ids: dict[Material, int]) -> MeshUse:
    """Return how a scene uses a mesh; warn of textures that it has no texcoords for."""
    seen = [material for material in shown if material is not None] + (mesh.materials if None in shown else [])
    mapped = any(material.normal_texture is not None for material in seen)
    if mesh.texcoords is None and (mapped or any(material.diffuse_texture is not None for material in seen)):
        warnings.warn(GlimtWarning(f"mesh {mesh.name!r} has textures but no texcoords; each shows the colour of its "
                                   "corner"), stacklevel=2)
    return MeshUse(mesh, mapped and mesh.texcoords is not None, tuple(material_ids[each] for each in mesh.materials))
