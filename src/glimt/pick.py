"""What is seen at a point of the picture."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from glimt import linalg
from glimt.scene.instance import Instance
from glimt.scene.material import Material
from glimt.scene.sphere import Sphere

Point = tuple[float, float, float]


@dataclass(frozen=True)
class Pick:
    """A point of a surface.

    Parameters
    ----------
    object : Instance or Sphere
    object_index : int
        Its place in the scene's objects as they were at the last `Renderer.update`.
    triangle : int or None
        Index into the triangles of the instance's mesh; None for a sphere.
    material : Material
        The one that is seen there.
    position : (x, y, z)
        In the world.
    normal : (x, y, z)
        Unit normal of the triangle or sphere itself, on the viewer's side, in the world.
    distance : float
        From the viewer, in world units.
    u, v : float
        Barycentrics: ``p = (1 - u - v) * p0 + u * p1 + v * p2``; 0 for a sphere.
    """

    object: Instance | Sphere
    object_index: int
    triangle: int | None
    material: Material
    position: Point
    normal: Point
    distance: float
    u: float
    v: float


def pick_from(thing: Instance | Sphere, object_index: int, triangle: int, u: float, v: float,
              origin: NDArray[np.float64], end: NDArray[np.float64]) -> Pick:
    """Return the Pick of what a ray from `origin` has hit at `end`, where rounding has left that."""
    if isinstance(thing, Sphere):
        normal, material = linalg.normalize(end - thing.center), thing.material
        position = thing.center + thing.radius * normal
    else:
        mesh = thing.mesh
        a, b, c = linalg.transform_points(thing.object_to_world, mesh.positions[mesh.triangles[triangle]])
        position = (1 - u - v) * a + u * b + v * c
        normal = linalg.normalize(np.cross(linalg.normalize(b - a), linalg.normalize(c - a)))
        assert mesh.material_ids is not None  # a constructor's None means zeros
        material = thing.material or mesh.materials[mesh.material_ids[triangle]]
    towards = origin - position
    if normal @ towards < 0:
        normal = -normal
    return Pick(thing, object_index, None if isinstance(thing, Sphere) else triangle, material, _point(position),
                _point(normal), float(np.linalg.norm(towards)), u, v)


def _point(vector: NDArray[np.float64]) -> Point:
    x, y, z = vector.tolist()
    return x, y, z
