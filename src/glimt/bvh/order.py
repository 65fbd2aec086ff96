"""In which order rays meet the children of a node, as far as the signs of their directions tell.

After Fuetterling, Lojewski, Pfreundt, Hamann and Ebert, "Accelerated single ray tracing for wide vector units" (2017):
who walks a tree has nothing to sort. Here the order is that of the children's centers along the octant's diagonal.
"""

import numpy as np

from glimt.kernel import inline
from glimt.lanes import as_int, load8, numbers8, pack8, select, shuffle, sort8, store_scalar_int
from glimt.layout import NODE

_SIGN = np.int32(0x7FFFFFFF)


@inline
def _sortable(x):
    """Return integers in the order of floats."""
    word = as_int(x)
    return select(word < 0, word ^ _SIGN, word)


@inline
def put_order(nodes, base):
    """Write the `order` of the node at word `base`, whose boxes are there; opposite octants have opposite orders."""
    x = load8(nodes, base + NODE.lo_x) + load8(nodes, base + NODE.hi_x)
    y = load8(nodes, base + NODE.lo_y) + load8(nodes, base + NODE.hi_y)
    z = load8(nodes, base + NODE.lo_z) + load8(nodes, base + NODE.hi_z)
    backwards = np.int32(7) - numbers8()
    for octant in range(4):
        along_x, along_y = x, y
        if octant & 1:
            along_x = -x
        if octant & 2:
            along_y = -y
        farthest_first = sort8((_sortable(along_x + along_y + z) & np.int32(-8)) | numbers8())
        store_scalar_int(nodes, base + NODE.order + octant, pack8(farthest_first))
        store_scalar_int(nodes, base + NODE.order + 7 - octant, pack8(shuffle(farthest_first, backwards)))
