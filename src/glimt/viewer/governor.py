"""The governor: how large a picture may be so that a frame keeps within its budget."""

import math
import statistics
from collections import deque

DEFAULT_BUDGET = 1 / 30
"""Seconds a frame may take where nobody says otherwise."""
_STEP = 2 ** -0.25
"""Each level has 0.84 times the side of the one before: the next smaller has 0.71 times the pixels."""
_LEVELS = 13
"""The last has an eighth of the side."""
_FIRST_LEVEL = 4
"""Before anything is measured: half of the side."""
_AIM = 0.75
"""Share of the budget that a new level is chosen for: what comes next may be dearer."""
_RAISE = 0.7
"""Share of the budget that the next larger level must be expected to keep within, to be taken."""
_HOLD_SECONDS = 0.5
"""A level is kept for at least that long."""
_CALM_SECONDS = 1.0
"""How long frames must have been cheap before the picture becomes larger."""
_SETTLING = 3
"""Frames before the first choice."""
_SMALLEST_SIDE = 32


class Governor:
    """Chooses the size of the pictures that are rendered while anything moves.

    Frames that take longer than the budget make it smaller, at once but for a change less than half a second ago;
    frames that have been well within it for a second make it larger. So the size changes at most twice a second.

    Parameters
    ----------
    budget : float
        Seconds a frame may take.
    """

    def __init__(self, budget: float) -> None:
        self.budget = budget
        self._level = _FIRST_LEVEL
        self._changed = -math.inf
        self._costs: deque[tuple[float, float]] = deque()

    @property
    def scale(self) -> float:
        """Side of the rendered picture as a share of the shown one's."""
        return _STEP ** self._level

    def size(self, shown: tuple[int, int]) -> tuple[int, int]:
        """Return the (width, height) to render for a canvas of that size."""
        width, height = shown
        scale = max(self.scale, min(1.0, _SMALLEST_SIDE / max(1, min(width, height))))
        return max(1, round(width * scale)), max(1, round(height * scale))

    def add(self, seconds: float, now: float) -> None:
        """Take note of a frame that took some seconds at the present size and ended `now`."""
        self._costs.append((now, seconds / self.scale ** 2))
        while now - self._costs[0][0] > _CALM_SECONDS:
            self._costs.popleft()
        if self._changed == -math.inf:
            if len(self._costs) >= _SETTLING:  # the first ones bring code and textures into the caches
                self._choose(self._typical(), _AIM, now)
        elif now - self._changed >= _HOLD_SECONDS and seconds > self.budget:
            # One slow frame alone may be the machine's; two in three are the picture's.
            typical = self._typical()
            if typical * self.scale ** 2 > _AIM * self.budget:
                self._choose(typical, _AIM, now)
        elif now - self._changed >= _CALM_SECONDS and self._level:
            dearest = self._high_cost()
            if dearest * _STEP ** (2 * self._level - 2) <= _RAISE * self.budget:
                self._choose(dearest, _RAISE, now)

    def learn(self, seconds: float, now: float) -> None:
        """Take note of a frame that was rendered at full size while nothing moved: the next to move may be as large."""
        self._costs.clear()
        self._choose(seconds, _AIM, now)

    def forget(self) -> None:
        """Drop what was measured: the next frames are of another kind. The size stays."""
        self._costs.clear()

    def _typical(self) -> float:
        """Return the median cost of the last three frames, in seconds at full size."""
        return statistics.median(cost for _, cost in list(self._costs)[-3:])

    def _high_cost(self) -> float:
        """Return what all but one frame in twenty of the last second cost at most, in seconds at full size."""
        costs = sorted(cost for _, cost in self._costs)
        return costs[min(len(costs) - 1, int(0.95 * len(costs)))]

    def _choose(self, cost: float, share: float, now: float) -> None:
        """Take the largest size whose frames are expected to keep within a share of the budget."""
        level = math.ceil(math.log(max(1.0, cost / (share * self.budget))) / (-2 * math.log(_STEP)) - 1e-9)
        level = min(level, _LEVELS - 1)
        if level != self._level or self._changed == -math.inf:
            self._level, self._changed = level, now
