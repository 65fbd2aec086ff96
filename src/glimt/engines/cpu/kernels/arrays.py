"""The packed scene as a kernel sees it."""

from typing import NamedTuple

from glimt.engines.cpu.kernels.block import HIT, RAY, SLOTS, first_slot
from glimt.kernel import inline
from glimt.lanes import bits, compress_store, load, pointer, population_count
from glimt.layout import SPAN


class Arrays(NamedTuple):
    """Pointers to the arrays of a `PackedScene`, to its view, and to this thread's counters.

    spans, span_count: the leaves of each instance, when rays are to test them all.
    recorded, room: where rays are written, and how many of each kind there is room for.
    """

    tlas_nodes: object
    tlas_blocks: object
    blas_nodes: object
    blas_blocks: object
    instances: object
    triangles: object
    faces: object
    vertices: object
    tangents: object
    materials: object
    textures: object
    levels: object
    texels: object
    lights: object
    spans: object
    light_count: object
    span_count: object
    view_words: object
    counters: object
    recorded: object
    room: object


@inline
def arrays(scene, light_count, view, counters, recorded):
    """Return the pointers: cheap to pass down, without reference counts."""
    return Arrays(pointer(scene.tlas_nodes), pointer(scene.tlas_blocks), pointer(scene.blas_nodes),
                  pointer(scene.blas_blocks), pointer(scene.instances), pointer(scene.triangles),
                  pointer(scene.faces), pointer(scene.vertices), pointer(scene.tangents),
                  pointer(scene.materials), pointer(scene.textures), pointer(scene.levels), pointer(scene.texels),
                  pointer(scene.lights), pointer(scene.spans), light_count, len(scene.spans) // SPAN.words,
                  pointer(view), pointer(counters), pointer(recorded), recorded.shape[2])


class Trees(NamedTuple):
    """Pointers to what rays are traced through."""

    tlas_nodes: object
    tlas_blocks: object
    blas_nodes: object
    blas_blocks: object
    instances: object
    faces: object
    spans: object
    span_count: object


@inline
def trees(scene):
    """Return the pointers of a `PackedScene`."""
    return Trees(pointer(scene.tlas_nodes), pointer(scene.tlas_blocks), pointer(scene.blas_nodes),
                 pointer(scene.blas_blocks), pointer(scene.instances), pointer(scene.faces),
                 pointer(scene.spans), len(scene.spans) // SPAN.words)


@inline
def count(scene, which, number):
    """Add to one of this thread's counters."""
    scene.counters[which] += number


@inline
def count_rays(scene, which, rays, hits, packets):
    """Count the rays of some packets of a block that are about to be traced, and record them when that is wished."""
    while packets:
        slot = first_slot(packets)
        packets &= packets - 1
        t_max = load(hits, HIT.t + slot)
        asked = t_max > 0.0
        place, number = scene.counters[which], population_count(bits(asked))
        count(scene, which, number)
        if place + number <= scene.room:
            at = 7 * which * scene.room + place
            for k in range(6):
                compress_store(scene.recorded, at + k * scene.room, load(rays, RAY.origin + k * SLOTS + slot), asked)
            compress_store(scene.recorded, at + 6 * scene.room, t_max, asked)
