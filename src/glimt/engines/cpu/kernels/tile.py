"""Tiles of a picture, handed out by an atomic counter: what one thread alone writes to."""

from glimt.kernel import inline
from glimt.lanes import atomic_add
from glimt.layout import NEXT_TILE, TILE


@inline
def take_tile(control, width, height, side=TILE):
    """Return (left, top) of the next tile of a picture, top below 0 when none is left."""
    across = (width + side - 1) // side
    tile = atomic_add(control, NEXT_TILE, 1)
    if tile >= across * ((height + side - 1) // side):
        return 0, -1
    return (tile % across) * side, (tile // across) * side
