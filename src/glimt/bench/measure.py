"""Timing that survives a machine whose speed drifts: everything is timed in turn, in one run."""

import os
import platform
import statistics
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from glimt import __version__
from glimt.kernel import host_features, host_lanes, host_name

Clock = Callable[[], float]
Run = Callable[[], None]
Tell = Callable[[str], None]

_PAUSE_SECONDS = 0.05
"""Idle time before a block: threads that the one before has left spinning go to sleep."""
_MOST_BLOCK_SECONDS = 2.0


def interleave(runs: Mapping[str, Run], rounds: int, clock: Clock = time.perf_counter) -> dict[str, list[float]]:
    """Return the seconds of each run, one for each round; every round starts with another run, after one to warm up."""
    for run in runs.values():
        run()
    seconds: dict[str, list[float]] = {name: [] for name in runs}
    for name in _turns(runs, rounds):
        seconds[name].append(_timed(runs[name], clock))
    return seconds


class Blocks(NamedTuple):
    """What a run took: seconds of each time by round, and of processor time over all threads, the mean of a time."""

    seconds: list[list[float]]
    processor: float


def interleave_blocks(runs: Mapping[str, Run], rounds: int, length: int) -> dict[str, Blocks]:
    """Return what each run took, for runs whose steady state counts.

    Each turn is a pause, one run that is not timed and a block of `length` that are; a block ends early after two
    seconds.
    """
    seconds: dict[str, list[list[float]]] = {name: [] for name in runs}
    processor = dict.fromkeys(runs, 0.0)
    for name in _turns(runs, rounds):
        time.sleep(_PAUSE_SECONDS)
        runs[name]()
        block: list[float] = []
        start = time.process_time()
        while len(block) < length and sum(block) < _MOST_BLOCK_SECONDS:
            block.append(_timed(runs[name]))
        processor[name] += time.process_time() - start
        seconds[name].append(block)
    return {name: Blocks(seconds[name], processor[name] / sum(map(len, seconds[name]))) for name in runs}


def _turns(runs: Mapping[str, Run], rounds: int) -> Iterator[str]:
    """Yield names round by round, each time starting with another one."""
    names = list(runs)
    for turn in range(rounds):
        start = turn % len(names)
        yield from names[start:] + names[:start]


def _timed(run: Run, clock: Clock = time.perf_counter) -> float:
    start = clock()
    run()
    return clock() - start


def over_threads(pool: ThreadPoolExecutor, threads: int, work: Callable[[NDArray[np.int64]], None]) -> None:
    """Call work(chunk) in each of `threads` threads; `chunk` is the counter that they share."""
    chunk = np.zeros(1, np.int64)
    for job in [pool.submit(work, chunk) for _ in range(threads)]:
        job.result()


def median(values: Iterable[float]) -> float:
    """Return the median."""
    return statistics.median(values)


def quotient(above: Blocks, below: Blocks) -> float:
    """Return the median over rounds of the quotient of two blocks' medians: how fast a round was does not matter."""
    return median([median(a) / median(b) for a, b in zip(above.seconds, below.seconds, strict=True)])


def processor_quotient(above: Blocks, below: Blocks) -> float:
    """Return the quotient of the processor time that two runs took: whoever else used the machine does not matter."""
    tick = time.get_clock_info("process_time").resolution
    return max(above.processor, tick) / max(below.processor, tick)


def milliseconds(blocks: Blocks) -> dict[str, float]:
    """Return median, 10th and 90th percentile of all times of a run."""
    values = 1e3 * np.concatenate(blocks.seconds)
    return {name: float(np.percentile(values, share)) for name, share in (("median", 50), ("p10", 10), ("p90", 90))}


def machine() -> dict[str, Any]:
    """Return what the numbers depend on."""
    wanted = ("avx512f", "avx2", "fma", "sse4.2", "neon")
    return {"processor": host_name(), "features": [name for name in wanted if name in host_features()],
            "lanes": host_lanes(), "cores": os.cpu_count(), "system": platform.platform(terse=True),
            "python": platform.python_version(), "numba": numba.__version__, "glimt": __version__}
