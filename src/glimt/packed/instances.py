"""Placed meshes and spheres as records, all at once: a thousand may move from frame to frame."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from glimt import linalg
from glimt.errors import GlimtError
from glimt.layout import INSTANCE, MESH_KIND, SPHERE_KIND, dtype
from glimt.packed.geometry import Placement
from glimt.scene import checks
from glimt.scene.instance import Instance
from glimt.scene.material import Material
from glimt.scene.mesh import Mesh
from glimt.scene.sphere import Sphere

_BOX_PAD = 2e-6
"""World boxes grow by this share of their size and place: more than rounding takes from a ray on its way into object
space."""

_SIMILAR = 1e-4
"""Matrices keep angles when no two axes differ by more than this share."""


class PackedInstances(NamedTuple):
    """INSTANCE records as words, and their world boxes, (n, 3) float32 each."""

    records: NDArray[np.float32]
    lo: NDArray[np.float32]
    hi: NDArray[np.float32]


def pack_instances(objects: list[Instance | Sphere], meshes: dict[Mesh, int], placements: list[Placement],
                   material_ids: dict[Material, int]) -> PackedInstances:
    """Return the records of objects in order, one that is never read for none.

    meshes : dict of int
        Each mesh's place in `placements`.
    """
    records = np.zeros(max(1, len(objects)), dtype(INSTANCE))
    lo, hi = np.empty((len(objects), 3)), np.empty((len(objects), 3))
    placed = [k for k, thing in enumerate(objects) if isinstance(thing, Instance)]
    if placed:
        things: list[Any] = [objects[k] for k in placed]
        records[placed], lo[placed], hi[placed] = _mesh_records(things, meshes, placements, material_ids)
    spheres = [k for k, thing in enumerate(objects) if isinstance(thing, Sphere)]
    if spheres:
        things = [objects[k] for k in spheres]
        records[spheres], lo[spheres], hi[spheres] = _sphere_records(things, material_ids)
    extent = (hi - lo).max(1, initial=0)
    records["extent"][:len(objects)] = extent
    pad = _BOX_PAD * (np.maximum(np.abs(lo), np.abs(hi)) + extent[:, None])
    return PackedInstances(records.view(np.float32), (lo - pad).astype(np.float32), (hi + pad).astype(np.float32))


def _mesh_records(instances: list[Instance], meshes: dict[Mesh, int], placements: list[Placement],
                  material_ids: dict[Material, int]) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Return records and world bounds (lo, hi)."""
    matrices = _matrices(instances)
    which = [meshes[thing.mesh] for thing in instances]
    records = np.zeros(len(instances), dtype(INSTANCE))
    records["kind"] = MESH_KIND
    for name, column in zip(Placement._fields, zip(*placements, strict=True), strict=True):
        records[name] = np.array(column)[which]
    records["material"] = [material_ids[thing.material] if thing.material else -1 for thing in instances]
    records["identity"] = (matrices == linalg.identity()).all((1, 2))
    records["object_to_world"] = matrices.reshape(-1, 12)
    records["world_to_object"] = _inverses(instances, matrices).reshape(-1, 12)
    records["clear_unit"] *= _signed_scale(matrices)
    bounds = np.array([mesh.bounds() for mesh in meshes], np.float64)[which]
    return records, *linalg.transform_box(matrices, bounds[:, 0], bounds[:, 1])


def _sphere_records(spheres: list[Sphere],
                    material_ids: dict[Material, int]) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Return records and world bounds (lo, hi)."""
    center, radius = np.array([ball.center for ball in spheres]), np.array([ball.radius for ball in spheres])
    records = np.zeros(len(spheres), dtype(INSTANCE))
    records["kind"], records["material"] = SPHERE_KIND, [material_ids[ball.material] for ball in spheres]
    records["center"], records["radius"] = center, radius
    return records, center - radius[:, None], center + radius[:, None]


def _matrices(instances: list[Instance]) -> NDArray[np.float64]:
    """Return the (n, 3, 4) matrices of instances, which may have been set by hand since a constructor checked them."""
    for thing in instances:
        if getattr(thing.object_to_world, "shape", None) != (3, 4):
            owner = f"instance {thing.name!r}"
            checks.array(owner, "object_to_world", thing.object_to_world, (3, 4), np.float64)
    return np.concatenate([thing.object_to_world for thing in instances]).astype(np.float64).reshape(-1, 3, 4)


def _signed_scale(matrices: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return by how much matrices make lengths longer, below 0 for a mirror; 0 for one that changes angles."""
    linear = matrices[..., :3]
    squares = linear.transpose(0, 2, 1) @ linear
    scale = np.sqrt(np.trace(squares, axis1=1, axis2=2) / 3)
    odd = np.abs(squares - (scale**2)[:, None, None] * np.eye(3)).max((1, 2)) > _SIMILAR * scale**2
    return np.where(odd, 0, scale * np.sign(np.linalg.det(linear)))


def _inverses(instances: list[Instance], matrices: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the (n, 3, 4) inverses, or say which instance has none."""
    try:
        inverses = linalg.inverse(matrices)
    except np.linalg.LinAlgError:
        inverses = np.array([_inverse_or_nan(matrix) for matrix in matrices])
    wrong = ~(np.abs(inverses[..., :3]).max((1, 2)) <= checks.LARGEST)
    if wrong.any():
        raise GlimtError(f"instance {instances[int(wrong.argmax())].name!r}: object_to_world has no inverse within "
                         f"{checks.LARGEST:g} (it flattens the mesh, or is not finite); give every axis a size")
    return inverses


def _inverse_or_nan(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    try:
        return linalg.inverse(matrix)
    except np.linalg.LinAlgError:
        return np.full((3, 4), np.nan)
