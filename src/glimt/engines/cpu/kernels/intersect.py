"""Stage 2: rays to hits."""

from glimt.engines.cpu.kernels.traverse import closest_hit
from glimt.kernel import inline
from glimt.layout import MISS


@inline
def intersect(scene, origin, direction, active, shared_origin):
    """Return (hit, lanes that hit something)."""
    hit = closest_hit(scene, origin, direction, active, shared_origin)
    return hit, active & (hit.inst != MISS)
