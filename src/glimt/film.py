"""What an engine makes: linear sums and counts per pixel."""

import functools
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from glimt.color import ToneCurve, develop
from glimt.layout import aligned


class Counters(NamedTuple):
    """What was traced for a film.

    primary, shadow, mirror : int
        Rays by kind.
    non_finite : int
        Samples that were NaN or infinite and were replaced by black.
    """

    primary: int = 0
    shadow: int = 0
    mirror: int = 0
    non_finite: int = 0

    @property
    def rays(self) -> int:
        """All rays."""
        return self.primary + self.shadow + self.mirror


@dataclass
class Film:
    """Sums of radiance over pixel samples.

    Parameters
    ----------
    sums : (h, w, 4) float32
        Linear RGB, Rec. 709 primaries, summed over the samples of each pixel, and their number; row 0 on top.
        Of adaptive sampling the number is 1, 5, 9, 13 (the first sample among them) or 16 (the 4×4 grid).
    counters : Counters
        What was traced for it.
    seconds : float
        How long that took.
    stages : dict
        Seconds of each stage by its name, over all samples; empty where they are not timed. Of a GPU they are its own,
        and what is left of `seconds` went to the host and to bringing the picture back. Of the CPU, where stages are
        timed on demand, they are the shares of all threads' time, and make up `seconds`.
    """

    sums: NDArray[np.float32]
    counters: Counters = field(default_factory=Counters)
    seconds: float = 0.0
    stages: dict[str, float] = field(default_factory=dict)

    @property
    def radiance(self) -> NDArray[np.float32]:
        """The mean radiance per pixel, (h, w, 3) float32; 0 where there is no sample."""
        return (self.sums[..., :3] / np.maximum(self.sums[..., 3:], 1)).astype(np.float32)

    def image(self, exposure: float = 0.0, tone_curve: ToneCurve = "clamp") -> NDArray[np.uint8]:
        """Return the developed picture, (h, w, 3) uint8 sRGB (see `glimt.color.develop`)."""
        return develop(self.sums, exposure, tone_curve)


class DistantFilm(Film):
    """A film whose sums stay in a GPU's memory; they come when `sums` is read for the first time.

    Parameters
    ----------
    size : (width, height)
    place : object
        Where they are, for those who have to do with this GPU.
    fetch : function
        Returns the sums; raises an `EngineError` when the GPU is lost, and the film with it.
    counters, seconds, stages
        As for `Film`.
    """

    def __init__(self, size: tuple[int, int], place: Any, fetch: Callable[[], NDArray[np.float32]],
                 counters: Counters, seconds: float, stages: dict[str, float]) -> None:
        self.size, self.place = size, place
        self._fetch = fetch
        self.counters, self.seconds, self.stages = counters, seconds, stages

    @functools.cached_property
    def sums(self) -> NDArray[np.float32]:  # type: ignore[override]
        """See `Film`; good until the film's memory is given to another render."""
        return self._fetch()


def sums_for(size: tuple[int, int], film: Film | None) -> NDArray[np.float32]:
    """Return where the sums of a picture of that (width, height) may be written: over those of `film`, if they fit."""
    shape = (size[1], size[0], 4)
    if film is None or isinstance(film, DistantFilm) or film.sums.shape != shape:
        return aligned(size[0] * size[1] * 4).reshape(shape)
    return film.sums
