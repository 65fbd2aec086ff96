"""The packed scene as a kernel sees it."""

from typing import NamedTuple

from glimt.kernel import inline
from glimt.lanes import pointer


class Arrays(NamedTuple):
    """Pointers to the arrays of a `PackedScene`, to its view, and to this thread's counters."""

    tlas_nodes: object
    tlas_blocks: object
    blas_nodes: object
    blas_blocks: object
    instances: object
    triangles: object
    vertices: object
    tangents: object
    materials: object
    textures: object
    levels: object
    texels: object
    lights: object
    light_count: object
    view_words: object
    counters: object


@inline
def arrays(scene, light_count, view, counters):
    """Return the pointers: cheap to pass down, without reference counts."""
    return Arrays(pointer(scene.tlas_nodes), pointer(scene.tlas_blocks), pointer(scene.blas_nodes),
                  pointer(scene.blas_blocks), pointer(scene.instances), pointer(scene.triangles),
                  pointer(scene.vertices), pointer(scene.tangents), pointer(scene.materials),
                  pointer(scene.textures), pointer(scene.levels), pointer(scene.texels), pointer(scene.lights),
                  light_count, pointer(view), pointer(counters))


@inline
def count(scene, which, number):
    """Add to one of this thread's counters."""
    scene.counters[which] += number
