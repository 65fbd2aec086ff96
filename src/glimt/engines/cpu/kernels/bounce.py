"""Stage 4: the mirror ray."""

import numpy as np

from glimt.kernel import inline
from glimt.lanes import dot, maximum, normalize, select3

_LEAST_RISE = np.float32(1e-3)
"""The least cosine between a mirror ray and the geometric normal."""


@inline
def bounce(surface, material, direction):
    """Return (origin, direction) of the mirror ray.

    One that a shading normal would send below the surface is lifted to graze it.
    """
    mirrored = direction - material.ns * (2.0 * dot(direction, material.ns))
    rise = dot(mirrored, surface.ng)
    lifted = normalize(mirrored + surface.ng * maximum(_LEAST_RISE - rise, 0.0))
    return surface.point + surface.ng * surface.offset, select3(rise < _LEAST_RISE, lifted, mirrored)
