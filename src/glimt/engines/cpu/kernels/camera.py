"""The pinhole camera."""

from glimt.kernel import inline
from glimt.lanes import fma, normalize, scalar3, vector3
from glimt.layout import VIEW


@inline
def camera_ray(scene, x, y):
    """Return (origin, unit direction) through a point of the picture plane, x and y in -1..1, y up.

    Fused by hand: whether a compiler does it depends on the rays beside it, and a sample has one ray in every mode.
    """
    right, up = scalar3(scene.view_words, VIEW.right), scalar3(scene.view_words, VIEW.up)
    look = scalar3(scene.view_words, VIEW.look)
    return scalar3(scene.view_words, VIEW.origin), normalize(vector3(
        fma(up.x, y, fma(right.x, x, look.x)), fma(up.y, y, fma(right.y, x, look.y)),
        fma(up.z, y, fma(right.z, x, look.z))))
