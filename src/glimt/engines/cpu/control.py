"""What the threads of one render share."""

import numpy as np
from numpy.typing import NDArray

from glimt.engines.options import DEFAULT_OPTIONS, EngineOptions
from glimt.layout import CONTROL_WORDS, TILE_SIDE, TOGETHER


def new_control(options: EngineOptions = DEFAULT_OPTIONS) -> NDArray[np.int64]:
    """Return a render's counter of tiles, its flag to stop, and how its work is divided."""
    control = np.zeros(CONTROL_WORDS, np.int64)
    control[TILE_SIDE], control[TOGETHER] = options.tile, options.packets
    return control
