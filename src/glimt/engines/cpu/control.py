"""What the threads of one render share."""

import numpy as np
from numpy.typing import NDArray

from glimt.engines.cpu.kernels.block import PACKETS
from glimt.engines.options import DEFAULT_OPTIONS, EngineOptions
from glimt.layout import COUNTER_STRIDE, FIRST_SHARE, OWN_SHARE, SHARE_STRIDE, SHARES, TILE_SIDE, TOGETHER


def new_control(shares: int = 1, options: EngineOptions = DEFAULT_OPTIONS) -> NDArray[np.int64]:
    """Return a render's flag to stop, how its work is divided, and a counter of tiles for each share."""
    control = np.zeros(FIRST_SHARE + shares * SHARE_STRIDE, np.int64)
    control[SHARES], control[TILE_SIDE], control[TOGETHER] = shares, options.tile, options.packets or PACKETS
    return control


def new_counters(shares: int) -> NDArray[np.int64]:
    """Return a row of counters for the thread of each share."""
    counters = np.zeros((shares, int(COUNTER_STRIDE)), np.int64)
    counters[:, OWN_SHARE] = range(shares)
    return counters


def tiles_taken(control: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return how many tiles of each share are taken, as a view."""
    taken: NDArray[np.int64] = control[FIRST_SHARE::SHARE_STRIDE]
    return taken
