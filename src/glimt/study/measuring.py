"""Frames of many settings, timed in turn until their medians are known well enough."""

import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from glimt.film import Counters, Film
from glimt.renderer import Renderer
from glimt.study.experiments import Setting
from glimt.study.laws import Floats, medians, steadied

Clock = Callable[[], float]
Progress = Callable[[float], None]
"""Is told how far a measurement is, 0 to 1."""

LEAST_ROUNDS = 5
_MOST_ROUNDS = 200
_PRECISE = 0.01
"""Half the width of an interval, as a share of the time: then more rounds are not worth their time."""
_BLOCK = 3
_BLOCK_SECONDS = 0.1
_SLOW_SECONDS = 0.05
"""A frame that takes longer is not rendered once more to warm up, since no cache lasts so long."""


class Frames:
    """Calling it renders the next frame of a setting, into the film of the one before; it returns its seconds.

    Attributes
    ----------
    film : Film
        Of the last frame.
    """

    film: Film

    def __init__(self, setting: Setting, engine: str, threads: int | None, clock: Clock = time.perf_counter) -> None:
        self._renderer = Renderer(setting.scene, threads=setting.threads or threads, engine=engine,
                                  options=setting.options)
        self._clock = clock
        self.film = self._renderer.render()
        self._renderer.settle()
        self.stages: list[dict[str, float]] = []  # shares of a frame's time

    def __call__(self) -> float:
        """Render a frame."""
        start = self._clock()
        self.film = self._renderer.render(film=self.film)
        seconds = self._clock() - start
        self.stages.append({name: part / self.film.seconds for name, part in self.film.stages.items()})
        return seconds


class Measurement(NamedTuple):
    """What the settings of a figure took.

    times : list of list of list of float
        Seconds by round, setting and frame; only whole rounds.
    counters : list of Counters
        Rays of a frame of each setting.
    stages : list of dict
        The mean share of a frame's time that each stage takes, by setting; empty where they are not timed.
    complete : bool
        False when Ctrl-C came before it was finished.
    """

    times: list[list[list[float]]]
    counters: list[Counters]
    stages: list[dict[str, float]]
    complete: bool

    def by_round(self, which: Sequence[int]) -> Floats:
        """Return (rounds, settings) medians of the frames of a round, in seconds, without the machine's drift.

        The drift is told by all settings, also by those that are not wanted.
        """
        whole = np.array([[np.median(block) for block in row] for row in self.times])
        return np.asarray(steadied(whole)[:, list(which)])


def measure(runs: Sequence[Callable[[], float]], seconds: float, progress: Progress = lambda share: None,
            clock: Clock = time.perf_counter) -> tuple[list[list[list[float]]], bool]:
    """Return seconds by round, run and frame, and whether it came to its end; Ctrl-C ends it early.

    Runs take turns in an order drawn anew for each round. It goes on until all medians are known to one per cent or
    `seconds` have passed, but for five rounds at least.
    """
    random, start = np.random.default_rng(2), clock()
    rounds: list[list[list[float]]] = []
    try:
        while len(rounds) < LEAST_ROUNDS or (len(rounds) < _MOST_ROUNDS and clock() - start < seconds
                                             and not _is_precise(rounds)):
            blocks: list[list[float]] = [[] for _ in runs]
            for done, place in enumerate(random.permutation(len(runs))):
                slow = bool(rounds) and np.median(rounds[-1][place]) > _SLOW_SECONDS
                blocks[place] = _block(runs[place], slow)
                least = (len(rounds) + (done + 1) / len(runs)) / LEAST_ROUNDS
                progress(min(0.99, least, (clock() - start) / seconds))
            rounds.append(blocks)
    except KeyboardInterrupt:
        return rounds, False
    progress(1.0)
    return rounds, True


def _block(run: Callable[[], float], slow: bool) -> list[float]:
    if not slow:
        run()
    block: list[float] = []
    while len(block) < _BLOCK and sum(block) < _BLOCK_SECONDS:
        block.append(run())
    return block


def _is_precise(rounds: list[list[list[float]]]) -> bool:
    times = steadied(np.array([[np.median(block) for block in row] for row in rounds]))
    return all(each.hi - each.lo <= 2 * _PRECISE * each.value for each in medians(times))


def measure_frames(runs: Sequence[Frames], seconds: float, progress: Progress = lambda share: None) -> Measurement:
    """Return what settings take.

    Raises
    ------
    KeyboardInterrupt
        Before there are two whole rounds to keep.
    """
    rounds, complete = measure(runs, seconds, progress)
    if len(rounds) < 2:
        raise KeyboardInterrupt
    return Measurement(rounds, [run.film.counters for run in runs], [_mean_stages(run.stages) for run in runs],
                       complete)


def _mean_stages(frames: list[dict[str, float]]) -> dict[str, float]:
    return {name: float(np.mean([stages.get(name, 0.0) for stages in frames])) for name in frames[-1]}
