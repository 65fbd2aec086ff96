"""Stage 5: pixel samples to pixels."""

import numpy as np

from glimt.engines.cpu.kernels.arrays import count
from glimt.kernel import inline
from glimt.lanes import LANES, bits, extract, f32, population_count, select3
from glimt.layout import COUNT_NON_FINITE


@inline
def drop_non_finite(scene, radiance, active):
    """Return radiance with samples that are not finite replaced by black, and count them."""
    wrong = radiance - radiance  # NaN for NaN and infinity
    finite = (wrong.x == 0.0) & (wrong.y == 0.0) & (wrong.z == 0.0)
    count(scene, COUNT_NON_FINITE, population_count(bits(active & ~finite)))
    return select3(finite, radiance, f32(0.0))


@inline
def resolve(film, sums, samples, columns, rows, width, height):
    """Write the sums of a packet's samples, and how many there were, to the pixels inside the picture."""
    for lane in range(LANES):
        column, row = np.int64(extract(columns, lane)), np.int64(extract(rows, lane))
        if column < width and row < height:
            film[row, column, 0] = extract(sums.x, lane)
            film[row, column, 1] = extract(sums.y, lane)
            film[row, column, 2] = extract(sums.z, lane)
            film[row, column, 3] = samples
