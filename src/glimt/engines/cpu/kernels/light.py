"""Lights: what arrives at a point, before anything stands in the way."""

from typing import NamedTuple

import numpy as np

from glimt.kernel import inline
from glimt.lanes import dot, f32, maximum, minimum, reciprocal, reciprocal_sqrt, scalar, scalar3, scalar_int, splat3
from glimt.layout import DIRECTIONAL_LIGHT, LIGHT, SPOT_LIGHT

_ENDLESS = np.float32(np.inf)
_TINY = np.float32(1e-36)
_SHORT_OF_LIGHT = np.float32(1 - 2.0**-16)
"""Where a shadow ray ends on its way to a lamp: a surface that the lamp lies in does not shadow it."""



class LightSample(NamedTuple):
    """Light from one light.

    wi: the unit way to it; reach, t_max: direction and end of the shadow ray; attenuation: 0 where nothing arrives.
    """

    wi: object
    reach: object
    t_max: object
    attenuation: object


@inline
def light_sample(scene, index, point, start):
    """Return the LightSample of light number `index` at a surface point whose shadow rays leave from `start`.

    Attenuation is the paper's polynomial of distance / radius; the cone is glTF's (KHR_lights_punctual).
    """
    record = index * LIGHT.words
    kind = scalar_int(scene.lights, record + LIGHT.kind)
    if kind == DIRECTIONAL_LIGHT:
        wi = splat3(f32(0.0)) - scalar3(scene.lights, record + LIGHT.direction)
        return LightSample(wi, wi, f32(_ENDLESS), f32(1.0))
    position = scalar3(scene.lights, record + LIGHT.position)
    to_light = position - point
    squared = maximum(dot(to_light, to_light), _TINY)
    inverse = reciprocal_sqrt(squared)
    wi = to_light * inverse
    x = squared * inverse * scalar(scene.lights, record + LIGHT.inverse_radius)
    at = record + LIGHT.attenuation
    polynomial = scalar(scene.lights, at) + x * (scalar(scene.lights, at + 1) + x * scalar(scene.lights, at + 2))
    attenuation = reciprocal(maximum(polynomial, _TINY))
    if kind == SPOT_LIGHT:
        cosine = f32(0.0) - dot(wi, scalar3(scene.lights, record + LIGHT.direction))
        cone = cosine * scalar(scene.lights, record + LIGHT.cone_scale) + scalar(scene.lights,
                                                                                record + LIGHT.cone_offset)
        cone = minimum(maximum(cone, 0.0), 1.0)
        attenuation = attenuation * cone * cone
    return LightSample(wi, position - start, f32(_SHORT_OF_LIGHT), attenuation)
