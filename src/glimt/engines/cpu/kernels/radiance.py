"""The integrator: a ray to radiance (Whitted, "An improved illumination model for shaded display", 1980)."""

from glimt.engines.cpu.kernels.arrays import count
from glimt.engines.cpu.kernels.bounce import bounce
from glimt.engines.cpu.kernels.intersect import intersect
from glimt.engines.cpu.kernels.material import material_at
from glimt.engines.cpu.kernels.shade import shade
from glimt.engines.cpu.kernels.surface import surface_at
from glimt.kernel import routine
from glimt.lanes import any_lane, bits, f32, population_count, scalar3, select, select3, splat3
from glimt.layout import COUNT_MIRROR, COUNT_PRIMARY, VIEW


@routine
def radiance(scene, origin, direction, spread, active, max_bounces):
    """Return the radiance along the rays of `active`: ``(1 - r) * lit + r * mirrored`` at every hit.

    `spread` is the width of a pixel's cone at distance 1.
    """
    sum_ = splat3(f32(0.0))      # radiance so far
    throughput = f32(1.0)        # share of what comes next
    travelled = f32(0.0)         # length of the path, for the width of its cone
    count(scene, COUNT_PRIMARY, population_count(bits(active)))
    for depth in range(max_bounces + 1):
        hit, found = intersect(scene, origin, direction, active, depth == 0)
        sum_ = select3(active & ~found, sum_ + scalar3(scene.view_words, VIEW.background) * throughput, sum_)
        if not any_lane(found):
            break
        travelled = travelled + select(found, hit.t, 0.0)
        surface = surface_at(scene, hit, found, origin, direction)
        material = material_at(scene, surface, found, direction, travelled * spread)
        lit = shade(scene, surface, material, direction, found)
        if depth == max_bounces:  # the last surface shows itself only
            sum_ = select3(found, sum_ + lit * throughput, sum_)
            break
        sum_ = select3(found, sum_ + lit * (throughput * (1.0 - material.reflectivity)), sum_)
        active = found & (material.reflectivity > 0.0)
        if not any_lane(active):
            break
        count(scene, COUNT_MIRROR, population_count(bits(active)))
        throughput = throughput * material.reflectivity
        origin, direction = bounce(surface, material, direction)
    return sum_
