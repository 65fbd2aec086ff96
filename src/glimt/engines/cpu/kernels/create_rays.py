"""Stage 1: pixels to rays."""

import numpy as np

from glimt.engines.cpu.kernels.block import PACKETS, PATH, RAY, SLOTS
from glimt.engines.cpu.kernels.camera import camera_ray
from glimt.kernel import inline
from glimt.lanes import LANES, any_lane, bits, f32, fma, i32, lane_numbers, store, store3, store_scalar, to_float
from glimt.layout import MISS

PACKET_WIDTH = 2 if LANES == 4 else 4
PACKET_HEIGHT = LANES // PACKET_WIDTH
"""A packet is 4×4, 4×2 or 2×2 pixels."""
BLOCK_WIDTH = BLOCK_HEIGHT = 8

_COLUMNS = BLOCK_WIDTH // PACKET_WIDTH  # packets in a row of a block
_COLUMN_BITS = np.int32(PACKET_WIDTH - 1)
_ROW_SHIFT = np.int32(PACKET_WIDTH.bit_length() - 1)


@inline
def first_pixel(k, x, y):
    """Return the (column, row) of the first lane of packet k of the block whose first pixel is (x, y)."""
    return x + k % _COLUMNS * PACKET_WIDTH, y + k // _COLUMNS * PACKET_HEIGHT


@inline
def packet_pixels(k, x, y):
    """Return the (column, row) of each lane of packet k of the block whose first pixel is (x, y)."""
    lanes, (left, top) = lane_numbers(), first_pixel(k, x, y)
    return (lanes & _COLUMN_BITS) + np.int32(left), (lanes >> _ROW_SHIFT) + np.int32(top)


@inline
def put_rays(scene, block, k, columns, rows, shift_x, shift_y, width, height):
    """Write the rays of packet k through pixels, shifts counted in pixels from their corner."""
    slot = np.int64(k * LANES)
    u = fma(to_float(columns) + shift_x, np.float32(2) / np.float32(width), f32(-1.0))
    v = fma(to_float(rows) + shift_y, np.float32(-2) / np.float32(height), f32(1.0))
    origin, direction = camera_ray(scene, u, v)
    store3(block.rays, RAY.origin + slot, SLOTS, origin)
    store3(block.rays, RAY.direction + slot, SLOTS, direction)
    store(block.paths, PATH.pixel + slot, lane_numbers() + np.int32(slot))
    store(block.paths, PATH.throughput + slot, f32(1.0))
    store(block.paths, PATH.travelled + slot, f32(0.0))
    store(block.paths, PATH.clear + slot, f32(0.0))
    store(block.paths, PATH.source + slot, i32(MISS))


@inline
def create_rays(scene, block, x, y, shift_x, shift_y, width, height):
    """Write rays through the pixels of the block at (x, y), shifts counted in pixels from their corner.

    Return the packets that have a pixel in the picture.
    """
    packets = np.int32(0)
    for k in range(PACKETS):
        columns, rows = packet_pixels(k, x, y)
        inside = (columns < np.int32(width)) & (rows < np.int32(height))
        store_scalar(block.active, k, bits(inside))
        if any_lane(inside):
            packets |= np.int32(1) << np.int32(k)
        put_rays(scene, block, k, columns, rows, shift_x, shift_y, width, height)
    return packets
