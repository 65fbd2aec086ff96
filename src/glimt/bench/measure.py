"""Timing that survives a machine whose speed drifts: everything is timed in turn, in one run."""

import os
import platform
import statistics
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from glimt import __version__
from glimt.kernel import host_features, host_lanes, host_name

Run = Callable[[], None]


def interleave(runs: Mapping[str, Run], rounds: int) -> dict[str, list[float]]:
    """Return the seconds of each run, one for each round; every round starts with another run, after one to warm up."""
    names = list(runs)
    for name in names:
        runs[name]()
    seconds: dict[str, list[float]] = {name: [] for name in names}
    for turn in range(rounds):
        for name in names[turn % len(names):] + names[:turn % len(names)]:
            start = time.perf_counter()
            runs[name]()
            seconds[name].append(time.perf_counter() - start)
    return seconds


def over_threads(pool: ThreadPoolExecutor, threads: int, work: Callable[[NDArray[np.int64]], None]) -> None:
    """Call work(chunk) in each of `threads` threads; `chunk` is the counter that they share."""
    chunk = np.zeros(1, np.int64)
    for job in [pool.submit(work, chunk) for _ in range(threads)]:
        job.result()


def median(values: list[float]) -> float:
    """Return the median."""
    return statistics.median(values)


def machine() -> dict[str, Any]:
    """Return what the numbers depend on."""
    wanted = ("avx512f", "avx2", "fma", "sse4.2", "neon")
    return {"processor": host_name(), "features": [name for name in wanted if name in host_features()],
            "lanes": host_lanes(), "cores": os.cpu_count(), "system": platform.platform(terse=True),
            "python": platform.python_version(), "numba": numba.__version__, "glimt": __version__}
