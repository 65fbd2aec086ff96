"""Stage 2: rays to hits."""

from glimt.engines.cpu.kernels.arrays import count_rays
from glimt.engines.cpu.kernels.block import PATH, RAY, SLOTS, first_slot, lanes_of
from glimt.engines.cpu.kernels.hit import FAR, begin_hits
from glimt.engines.cpu.kernels.packet import fill_idle, set_up
from glimt.engines.cpu.kernels.traverse import NO_FLAGS, SHARED_ORIGIN, trace
from glimt.kernel import inline
from glimt.lanes import load, load3, load_int
from glimt.layout import COUNT_MIRROR, COUNT_PRIMARY


@inline
def intersect(scene, block, packets, from_camera):
    """Find what the rays of some packets hit."""
    todo = packets
    while todo:
        slot = first_slot(todo)
        todo &= todo - 1
        active = lanes_of(block.active, slot)
        origin = load3(block.rays, RAY.origin + slot, SLOTS)
        direction = load3(block.rays, RAY.direction + slot, SLOTS)
        set_up(block.rays, slot, fill_idle(active, origin), fill_idle(active, direction))
        begin_hits(block.hits, slot, active, FAR, load(block.paths, PATH.clear + slot),
                   load_int(block.paths, PATH.source + slot))
    which, flags = COUNT_MIRROR, NO_FLAGS
    if from_camera:
        which, flags = COUNT_PRIMARY, SHARED_ORIGIN
    count_rays(scene, which, block.rays, block.hits, packets)
    trace(scene, block.rays, block.local, block.hits, flags, packets)
