"""Stage 3: hits to light: every light, with its shadow ray."""

import numpy as np

from glimt.engines.cpu.kernels.arrays import count
from glimt.engines.cpu.kernels.light import light_sample
from glimt.engines.cpu.kernels.material import material_eval
from glimt.engines.cpu.kernels.traverse import occluded
from glimt.kernel import inline, routine
from glimt.lanes import any_lane, bits, dot, f32, maximum, population_count, reciprocal, scalar3, select, select3
from glimt.layout import COUNT_SHADOW, LIGHT, VIEW


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


@routine
def shade(scene, surface, material, direction, found):
    """Return the light that the lanes of `found` send back along their rays, mirrors aside."""
    wo = direction * -1.0
    radiance = material.ambient * scalar3(scene.view_words, VIEW.ambient)
    start = surface.point + surface.ng * surface.offset
    for index in range(scene.light_count):
        light = light_sample(scene, index, surface.point, start)
        cosine = dot(material.ns, light.wi)
        arriving = light.attenuation * terminator(surface.ng, material.ns, light.wi)
        lit = found & (cosine > 0.0) & (arriving > 0.0)
        if any_lane(lit):
            count(scene, COUNT_SHADOW, population_count(bits(lit)))
            lit = lit & ~occluded(scene, start, light.reach, light.t_max, lit)
        if any_lane(lit):
            diffuse, specular = material_eval(material, wo, light.wi, cosine)
            sent = (diffuse * scalar3(scene.lights, index * LIGHT.words + LIGHT.diffuse)
                    + specular * scalar3(scene.lights, index * LIGHT.words + LIGHT.specular))
            radiance = select3(lit, radiance + sent * arriving, radiance)
    return radiance
