"""How far a ray that leaves a mesh meets nothing of it: what `packed.clearance` has found, looked up."""

import numpy as np

from glimt.kernel import inline
from glimt.lanes import as_float, dot, maximum, reciprocal_sqrt, select
from glimt.layout import CLEAR_BIAS, CLEAR_SHIFT, CLEAR_SINES

_ENDLESS = np.float32(np.inf)
_LONGEST = np.float32(2.0**31)
_SAFETY = np.float32(0.002)
"""By how much more a ray has to rise than the elevation says: a hundred times what float32 rounds off."""
_FIRST, _SECOND, _THIRD, _FOURTH = (sine + _SAFETY for sine in CLEAR_SINES)
_TINY = np.float32(1e-36)


@inline
def clear_distance(distances, unit, sine):
    """Return how far from its start a ray meets nothing of the mesh it leaves, rising at an angle of this sine.

    `distances` are those of FACE.clearance, `unit` is what their unit is in the world.
    """
    byte = select(sine > _FOURTH, distances, select(sine > _THIRD, distances << np.int32(8), select(
        sine > _SECOND, distances << np.int32(16), select(sine > _FIRST, distances << np.int32(24), 0))))
    code = (byte >> np.int32(24)) & np.int32(255)
    number = as_float((code << CLEAR_SHIFT) + CLEAR_BIAS)
    return select(number > _LONGEST, _ENDLESS, (number - 1.0) * unit)


@inline
def clear_until(distances, unit, ng, offset, direction):
    """Return the t before which rays in some direction, of any length, meet nothing of the mesh they leave.

    They begin at an `offset` from where they were shot at, on the side of ng: as much nearer is what they may meet.
    """
    per_length = reciprocal_sqrt(maximum(dot(direction, direction), _TINY))
    distance = clear_distance(distances, unit, dot(ng, direction) * per_length) - 2.0 * dot(ng, offset)
    return maximum(distance, 0.0) * per_length
