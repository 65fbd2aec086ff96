"""Stage 3: hits to light: every light, with its shadow rays."""

import numpy as np

from glimt.engines.cpu.kernels.arrays import count_rays
from glimt.engines.cpu.kernels.block import HIT, POINT, RAY, SLOTS, first_slot, lanes_of
from glimt.engines.cpu.kernels.clearance import clear_until
from glimt.engines.cpu.kernels.hit import begin_hits
from glimt.engines.cpu.kernels.light import light_sample
from glimt.engines.cpu.kernels.material import material_eval
from glimt.engines.cpu.kernels.occluder import trace_shadow_rays
from glimt.engines.cpu.kernels.packet import fill_idle, set_up
from glimt.kernel import inline
from glimt.lanes import (
    any_lane,
    dot,
    f32,
    load,
    load3,
    load_int,
    maximum,
    reciprocal,
    scalar3,
    select,
    select3,
    store,
    store3,
)
from glimt.layout import COUNT_SHADOW, LIGHT


@inline
def terminator(ng, ns, wi):
    """Return how much of the light survives where the shading normal sees it but the surface hardly does.

    Chiang, Li, Burley, "Taming the shadow terminator" (2019): 1 wherever both normals agree, and a smooth way to 0
    where the geometric one turns away, instead of a hard edge.
    """
    agreement = maximum(dot(ns, wi) * dot(ng, ns), np.float32(1e-6))
    g = dot(ng, wi) * reciprocal(agreement)
    soft = ((1.0 - g) * g + 1.0) * g
    return select(g >= 1.0, f32(1.0), select(g > 0.0, soft, 0.0))


@inline
def put_shadow_rays(scene, block, packets, index):
    """Write what arrives from one light at the points of some packets, and shadow rays to where anything does.

    Return the packets with any: a surface that faces away from a light, or is outside of its cone, has none.
    """
    towards = np.int32(0)
    while packets:
        slot, packet = first_slot(packets), packets & -packets
        packets &= packets - 1
        point, ng = load3(block.points, POINT.point + slot, SLOTS), load3(block.points, POINT.ng + slot, SLOTS)
        ns = load3(block.points, POINT.ns + slot, SLOTS)
        start = load3(block.points, POINT.start + slot, SLOTS)
        light = light_sample(scene, index, point, start)
        cosine = dot(ns, light.wi)
        arriving = light.attenuation * terminator(ng, ns, light.wi)
        lit = lanes_of(block.found, slot) & (cosine > 0.0) & (arriving > 0.0)
        if any_lane(lit):
            towards |= packet
            store3(block.points, POINT.wi + slot, SLOTS, light.wi)
            store(block.points, POINT.cosine + slot, cosine)
            store(block.points, POINT.arriving + slot, arriving)
            set_up(block.shadow_rays, slot, fill_idle(lit, start), fill_idle(lit, light.reach))
            clear = clear_until(load_int(block.points, POINT.clearance + slot),
                                load(block.points, POINT.clear_unit + slot), ng, start - point, light.reach)
            begin_hits(block.shadow_hits, slot, lit, light.t_max, clear, load_int(block.hits, HIT.inst + slot))
    return towards


@inline
def shade(scene, block, packets):
    """Add the light that the surface points of some packets send back along their rays, mirrors aside, to `lit`."""
    for index in range(scene.light_count):
        todo = put_shadow_rays(scene, block, packets, index)
        if todo == 0:
            continue
        count_rays(scene, COUNT_SHADOW, block.shadow_rays, block.shadow_hits, todo)
        trace_shadow_rays(scene, block, todo, index)
        while todo:
            slot = first_slot(todo)
            todo &= todo - 1
            lit = load(block.shadow_hits, HIT.t + slot) > 0.0
            if any_lane(lit):
                wo = load3(block.rays, RAY.direction + slot, SLOTS) * -1.0
                diffuse, specular = material_eval(
                    load3(block.points, POINT.diffuse + slot, SLOTS), load3(block.points, POINT.specular + slot, SLOTS),
                    load(block.points, POINT.exponent + slot), load3(block.points, POINT.ns + slot, SLOTS), wo,
                    load3(block.points, POINT.wi + slot, SLOTS), load(block.points, POINT.cosine + slot))
                sent = (diffuse * scalar3(scene.lights, index * LIGHT.words + LIGHT.diffuse)
                        + specular * scalar3(scene.lights, index * LIGHT.words + LIGHT.specular))
                before = load3(block.points, POINT.lit + slot, SLOTS)
                after = before + sent * load(block.points, POINT.arriving + slot)
                store3(block.points, POINT.lit + slot, SLOTS, select3(lit, after, before))
