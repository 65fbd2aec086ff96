"""The rays of a frame, as the engine traces them: for measurements and for looking at."""

import numpy as np
from numpy.typing import NDArray

from glimt.engines.cpu.control import new_control, new_counters
from glimt.engines.cpu.kernels.frame import render_tiles
from glimt.film import Counters
from glimt.layout import aligned_copy
from glimt.packed import PackedScene

KINDS = ("primary", "shadow", "mirror")


def record_rays(packed: PackedScene, light_count: int, view: NDArray[np.float32], size: tuple[int, int], samples: int,
                max_bounces: int) -> dict[str, NDArray[np.float32]]:
    """Return the rays of one frame by kind, in the order in which one thread traces them.

    Parameters are those of `Engine.upload` and `Engine.render`.

    Returns
    -------
    "primary", "shadow", "mirror" : (7, n) float32
        Origin, direction, and how far a ray looks in lengths of its direction.
    """
    counted = _trace(packed, light_count, view, size, samples, max_bounces, np.zeros((3, 7, 0), np.float32))
    rays = np.zeros((3, 7, max(counted[:3])), np.float32)
    _trace(packed, light_count, view, size, samples, max_bounces, rays)
    return {kind: aligned_copy(rays[k, :, :counted[k]]) for k, kind in enumerate(KINDS)}


def _trace(packed: PackedScene, light_count: int, view: NDArray[np.float32], size: tuple[int, int], samples: int,
           max_bounces: int, recorded: NDArray[np.float32]) -> Counters:
    width, height = size
    counters = new_counters(1)[0]
    render_tiles(packed, light_count, view, np.zeros((height, width, 4), np.float32), samples, max_bounces,
                 new_control(), counters, recorded)
    return Counters(*counters[:len(Counters._fields)].tolist())
