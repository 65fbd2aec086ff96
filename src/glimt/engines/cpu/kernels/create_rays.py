"""Stage 1: pixels to rays."""

import numpy as np

from glimt.engines.cpu.kernels.camera import camera_ray
from glimt.kernel import inline
from glimt.lanes import LANES, lane_numbers, to_float

BLOCK_WIDTH = 2 if LANES == 4 else 4
BLOCK_HEIGHT = LANES // BLOCK_WIDTH
"""A packet is a block of pixels: 4×4, 4×2 or 2×2."""

_COLUMN_BITS = np.int32(BLOCK_WIDTH - 1)
_ROW_SHIFT = np.int32(BLOCK_WIDTH.bit_length() - 1)


@inline
def block_pixels(x, y):
    """Return the (column, row) of each lane for the block whose first pixel is (x, y)."""
    lanes = lane_numbers()
    return (lanes & _COLUMN_BITS) + np.int32(x), (lanes >> _ROW_SHIFT) + np.int32(y)


@inline
def create_rays(scene, columns, rows, shift_x, shift_y, width, height):
    """Return (origin, direction) of rays through points of pixels, shifts counted in pixels from their corner."""
    x = (to_float(columns) + shift_x) * (np.float32(2) / np.float32(width)) - 1.0
    y = 1.0 - (to_float(rows) + shift_y) * (np.float32(2) / np.float32(height))
    return camera_ray(scene, x, y)
