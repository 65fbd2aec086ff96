"""A scene with fewer vertices, or more of them, seen from where it always is.

Vertices are counted as the paper does, three for each triangle that is placed; spheres have none and always stay.
"""

from dataclasses import replace

import numpy as np

from glimt.bench.mesh_sizes import subdivided
from glimt.scene.instance import Instance
from glimt.scene.mesh import Mesh
from glimt.scene.scene import Scene
from glimt.scene.sphere import Sphere


def placed_vertices(scene: Scene) -> int:
    """Return how many vertices a scene has."""
    return 3 * scene.placed_triangles()


def in_order(scene: Scene) -> list[Instance]:
    """Return a scene's meshes as they are added: the outermost last, which is the one with the largest box."""
    instances = [thing for thing in scene.instances() if len(thing.mesh.triangles)]
    if not instances:
        return []
    sizes = [float(np.prod(np.maximum(np.subtract(*thing.bounds()[::-1]), 1e-6))) for thing in instances]
    last = int(np.argmax(sizes))
    return [*instances[:last], *instances[last + 1:], instances[last]]


def first_vertices(scene: Scene, count: int) -> Scene:
    """Return a scene with only so many of its vertices, whole triangles in the order of `in_order`."""
    left, kept = count // 3, []
    for thing in in_order(scene):
        triangles = len(thing.mesh.triangles)
        if left >= triangles:
            kept.append(thing)
        elif left:
            kept.append(replace(thing, mesh=_first_triangles(thing.mesh, left)))
        left -= min(left, triangles)
    return replace(scene, objects=[*kept, *scene.spheres()])


def _first_triangles(mesh: Mesh, count: int) -> Mesh:
    ids = None if mesh.material_ids is None else mesh.material_ids[:count]
    return replace(mesh, triangles=mesh.triangles[:count], material_ids=ids)


def finer(scene: Scene) -> Scene:
    """Return a scene whose triangles are each cut into four; its surfaces stay where they are."""
    cut: dict[Mesh, Mesh] = {}
    objects: list[Instance | Sphere] = []
    for thing in scene.objects:
        if isinstance(thing, Instance):
            if thing.mesh not in cut:
                cut[thing.mesh] = subdivided(thing.mesh)
            thing = replace(thing, mesh=cut[thing.mesh])
        objects.append(thing)
    return replace(scene, objects=objects)
