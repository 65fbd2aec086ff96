"""Materials: parameters at a surface point, and the light they reflect."""

from typing import NamedTuple

import numpy as np

from glimt.engines.cpu.kernels.texture import sample_texture
from glimt.kernel import inline, routine
from glimt.lanes import (
    absolute,
    any_lane,
    bits,
    count_trailing_zeros,
    dot,
    extract,
    f32,
    maximum,
    normalize,
    power,
    reciprocal,
    reciprocal_sqrt,
    scalar,
    scalar3,
    scalar_int,
    select,
    select3,
    splat3,
)
from glimt.layout import MATERIAL

_FAINT = np.float32(1e-30)
"""Highlights below this are none: times a colour they would be denormal, which processors multiply at a tenth of the
pace."""
_GRAZING = np.float32(0.02)
"""The least cosine between a shading normal and the way back to the viewer."""


class Material(NamedTuple):
    """What a surface point reflects; `ns` is the shading normal after the normal map, on the viewer's side."""

    ambient: object
    diffuse: object
    specular: object
    exponent: object
    reflectivity: object
    ns: object


@inline
def _bend(ns, wo):
    """Return shading normals, turned towards the viewer where they point away (mapped ones may, and go black)."""
    cosine = dot(ns, wo)
    bent = ns + wo * (_GRAZING - cosine)
    return select3(cosine < _GRAZING, bent * reciprocal_sqrt(dot(bent, bent)), ns)


@inline
def _mapped_normal(scene, texture, lanes, surface, footprint, strength):
    """Return the shading normal by a normal map, as modelled; JPEG leaves normals of any length, so it is set anew."""
    n = sample_texture(scene, texture, lanes, surface.texcoord_u, surface.texcoord_v, footprint, np.bool_(False))
    n = n * 2.0 - 1.0
    mapped = surface.tangent * (n.x * strength) + surface.bitangent * (n.y * strength) + surface.normal * n.z
    squared = dot(mapped, mapped)
    usable = squared > np.float32(1e-12)
    return select3(usable, mapped * reciprocal_sqrt(select(usable, squared, 1.0)), surface.normal)


@routine
def material_at(scene, surface, found, direction, cone_width):
    """Return the Material of the lanes in `found`, peeled by distinct material.

    `cone_width` is the width of a pixel's cone across the ray. On the surface it is an ellipse, longer by 1 / cosine; a
    circle of the same area stands for it, between the blur of the long axis and the shimmer of the short one.
    """
    zero = splat3(f32(0.0))
    ambient, diffuse, specular, ns = zero, zero, zero, surface.ns
    exponent, reflectivity = f32(1.0), f32(0.0)
    cosine = maximum(absolute(dot(surface.ng, direction)), _GRAZING)
    footprint = cone_width * cone_width * surface.texcoord_density * reciprocal(cosine)
    todo = bits(found)
    while todo:
        index = extract(surface.material, count_trailing_zeros(todo))
        same = found & (surface.material == index)
        todo &= ~bits(same)
        record = np.int64(index) * MATERIAL.words
        ka = scalar3(scene.materials, record + MATERIAL.ambient)
        kd = scalar3(scene.materials, record + MATERIAL.diffuse)
        texture = scalar_int(scene.materials, record + MATERIAL.diffuse_texture)
        if texture >= 0:
            texel = sample_texture(scene, texture, same, surface.texcoord_u, surface.texcoord_v, footprint,
                                   np.bool_(True))
            ka, kd = ka * texel, kd * texel
        texture = scalar_int(scene.materials, record + MATERIAL.normal_texture)
        mapped = same & (surface.has_tangent > 0.0)
        if texture >= 0 and any_lane(mapped):
            strength = scalar(scene.materials, record + MATERIAL.normal_scale)
            ns = select3(mapped, _mapped_normal(scene, texture, mapped, surface, footprint, strength), ns)
        ambient, diffuse = select3(same, ka, ambient), select3(same, kd, diffuse)
        specular = select3(same, scalar3(scene.materials, record + MATERIAL.specular), specular)
        exponent = select(same, scalar(scene.materials, record + MATERIAL.exponent), exponent)
        reflectivity = select(same, scalar(scene.materials, record + MATERIAL.reflectivity), reflectivity)

    # Turn to the viewer: the geometric normal decides the side, whatever the winding.
    ns = ns * select(dot(surface.normal, surface.ng) < 0.0, f32(-1.0), 1.0)
    return Material(ambient, diffuse, specular, exponent, reflectivity, _bend(ns, direction * -1.0))


@inline
def material_eval(diffuse, specular, exponent, ns, wo, wi, cosine):
    """Return (diffuse, specular) reflected towards wo of light from wi, the cosine of incidence included in the first.

    Phong's model with Blinn's halfway vector, "Models of light reflection for computer synthesized pictures" (1977).
    """
    highlight = f32(0.0)
    if any_lane((specular.x != 0.0) | (specular.y != 0.0) | (specular.z != 0.0)):
        halfway = normalize(wi + wo)
        highlight = power(maximum(dot(ns, halfway), np.float32(1e-6)), exponent)
        highlight = select(highlight < _FAINT, f32(0.0), highlight)
    return diffuse * cosine, specular * highlight
