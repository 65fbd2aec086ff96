"""The stack of a walk down a tree: child codes, and how far away each child is."""

from glimt.kernel import inline
from glimt.lanes import scalar, scalar_int, store_scalar


@inline
def push(stack, distances, place, distance, code):
    """Write an entry at `place`."""
    store_scalar(distances, place, distance)
    store_scalar(stack, place, code)


@inline
def push_sorted(stack, distances, bottom, size, distance, code):
    """Insert an entry among those from `bottom` to `size`, the nearest on top."""
    place = size
    while place > bottom and scalar(distances, place - 1) < distance:
        push(stack, distances, place, scalar(distances, place - 1), scalar_int(stack, place - 1))
        place -= 1
    push(stack, distances, place, distance, code)
