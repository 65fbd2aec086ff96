"""The pinhole camera."""

from glimt.kernel import inline
from glimt.lanes import normalize, scalar3
from glimt.layout import VIEW


@inline
def camera_ray(scene, x, y):
    """Return (origin, unit direction) through a point of the picture plane, x and y in -1..1, y up."""
    right, up = scalar3(scene.view_words, VIEW.right), scalar3(scene.view_words, VIEW.up)
    look = scalar3(scene.view_words, VIEW.look)
    return scalar3(scene.view_words, VIEW.origin), normalize(look + right * x + up * y)
