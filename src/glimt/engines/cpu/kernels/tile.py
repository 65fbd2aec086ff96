"""Tiles of a picture, handed out by atomic counters: what one thread alone writes to.

Each thread has a share of the picture and helps with the others' when it is done with its own. So it works where it did
in the frame before: what it wrote and read there is still in the caches of its core.
"""

from glimt.kernel import inline
from glimt.lanes import atomic_add, atomic_load
from glimt.layout import FIRST_SHARE, OWN_SHARE, SHARE_STRIDE, SHARES, TILE


@inline
def take_tile(control, counters, width, height, side=TILE):
    """Return (left, top) of the next tile for the thread that counts in `counters`, top below 0 when none is left."""
    across = (width + side - 1) // side
    count, shares = across * ((height + side - 1) // side), control[SHARES]
    for step in range(shares):
        share = (counters[OWN_SHARE] + step) % shares
        first, end = count * share // shares, count * (share + 1) // shares
        place = FIRST_SHARE + share * SHARE_STRIDE
        if atomic_load(control, place) < end - first:
            tile = first + atomic_add(control, place, 1)
            if tile < end:
                return (tile % across) * side, (tile // across) * side
    return 0, -1
