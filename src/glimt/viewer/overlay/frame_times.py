"""How long the last frames took."""

import numpy as np
from numpy.typing import NDArray

KEPT = 240
"""Frames that are remembered."""
_RECENT_FRAMES = 120
_RECENT_SECONDS = 2.0


class FrameTimes:
    """A ring of the last frame times, and percentiles of those that tell how it runs now.

    Parameters
    ----------
    kept : int
        How many frames are remembered.
    """

    def __init__(self, kept: int = KEPT) -> None:
        self._kept = kept
        # Each time is written twice, `kept` apart: the last ones then lie side by side wherever the ring begins.
        self._ring = np.zeros(2 * kept)
        self._added = 0
        self._sorted: NDArray[np.float64] | None = None

    def __len__(self) -> int:
        return min(self._added, self._kept)

    def add(self, seconds: float) -> None:
        """Remember one more frame; the oldest is forgotten."""
        place = self._added % self._kept
        self._ring[place] = self._ring[place + self._kept] = seconds
        self._added += 1
        self._sorted = None

    def clear(self) -> None:
        """Forget all frames, as after another scene was loaded."""
        self._added = 0
        self._sorted = None

    @property
    def last(self) -> float:
        """Seconds of the last frame; 0 when there is none."""
        return float(self._ring[(self._added - 1) % self._kept]) if self._added else 0.0

    def array(self) -> NDArray[np.float64]:
        """Return the seconds of all frames that are remembered, oldest first."""
        return self._recent().copy()

    def percentile(self, q: float) -> float:
        """Return the time that q percent of recent frames kept to, between two of them as in `numpy.percentile`.

        Recent are the last 120 frames, or those of the last 2 seconds where they are fewer, and always the last one.
        0 when there is none.
        """
        if not self._added:
            return 0.0
        if self._sorted is None:
            newest_first = self._recent()[-_RECENT_FRAMES:][::-1]
            count = np.searchsorted(np.cumsum(newest_first), _RECENT_SECONDS, side="right")
            self._sorted = np.sort(newest_first[:max(count, 1)])
        rank = min(max(q, 0.0), 100.0) / 100 * (len(self._sorted) - 1)
        lower = int(rank)
        low, high = self._sorted[lower], self._sorted[min(lower + 1, len(self._sorted) - 1)]
        return float(low + (high - low) * (rank - lower))

    def _recent(self) -> NDArray[np.float64]:
        """Return a view of all frames that are remembered, oldest first."""
        end = (self._added - 1) % self._kept + 1 + self._kept
        return self._ring[end - len(self):end]
