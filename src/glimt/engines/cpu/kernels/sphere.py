"""Spheres against a packet."""

from glimt.engines.cpu.kernels.hit import block, replace
from glimt.kernel import inline
from glimt.lanes import any_lane, dot, f32, maximum, reciprocal, scalar, scalar3, select, sqrt
from glimt.layout import INSTANCE


@inline
def sphere_hit(scene, inst, record, rays, hit, occlusion):
    """Test one sphere in world space.

    Haines et al., "Precision improvements for ray/sphere intersection" (Ray Tracing Gems, 2019): the discriminant comes
    from the distance between the centre and the line. Directions need not be of unit length.
    """
    radius = scalar(scene.instances, record + INSTANCE.radius)
    to_center = scalar3(scene.instances, record + INSTANCE.center) - rays.origin
    inverse = reciprocal(dot(rays.direction, rays.direction))
    nearest = dot(to_center, rays.direction) * inverse
    beside = to_center - rays.direction * nearest
    discriminant = radius * radius - dot(beside, beside)
    met = (discriminant >= 0.0) & (hit.t > 0.0)
    if any_lane(met):
        half_chord = sqrt(maximum(discriminant, 0.0) * inverse)
        enter = nearest - half_chord
        t = select(enter > 0.0, enter, nearest + half_chord)
        if occlusion:
            return block(hit, met & (t > 0.0) & (t < hit.t), 0, inst)
        first = (t < hit.t) | ((t == hit.t) & (hit.inst > inst))
        return replace(hit, met & (t > 0.0) & first, t, f32(0.0), f32(0.0), 0, inst)
    return hit
