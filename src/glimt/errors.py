"""The one exception family, and warnings that are counted instead of repeated.

A message names the place, the thing and the remedy: ``room.obj:1841: face refers to vertex 431 of 400``.
"""

import warnings
from dataclasses import dataclass


class GlimtError(Exception):
    """Something a user can mend: a file, a scene, an option. Its text is complete and needs no traceback."""


class RenderCancelled(GlimtError):  # noqa: N818 - nothing went wrong
    """A render was stopped by `Renderer.cancel`. A film it was given to write over is part old, part new."""

    def __init__(self) -> None:
        super().__init__("the render was cancelled")


class EngineError(GlimtError):
    """An engine cannot go on: its GPU was lost, does not answer, or has no room for a scene or picture.

    Parameters
    ----------
    what : str
        What happened.
    remedy : str
        What to do, where no other engine takes over.
    """

    def __init__(self, what: str, remedy: str) -> None:
        super().__init__(f"{what}; {remedy}")
        self.what = what


class GlimtWarning(UserWarning):
    """The picture can be made, but something in the input was dropped, replaced or ignored.

    `count` says how many times the same thing happened; the text names the first place.
    """

    def __init__(self, message: str, count: int = 1) -> None:
        super().__init__(message)
        self.count = count


@dataclass
class _Tally:
    message: str
    first: str
    count: int


class WarningCounter:
    """Collects warnings by kind while a file is read, and issues each kind once, with its count, at the end.

    A file with 100,000 bad faces gives one warning, not 100,000.
    """

    def __init__(self) -> None:
        self._tallies: dict[str, _Tally] = {}

    def add(self, message: str, where: str = "", count: int = 1) -> None:
        """Count one more `message` (its text is its kind); `where` is kept for the first of a kind only."""
        tally = self._tallies.setdefault(message, _Tally(message, where, 0))
        tally.count += count

    def issue(self) -> None:
        """Issue one `GlimtWarning` for each kind collected so far, then forget them."""
        tallies, self._tallies = list(self._tallies.values()), {}
        for tally in tallies:
            place = f"{tally.first}: " if tally.first else ""
            times = f" ({tally.count} times, the first one here)" if tally.count > 1 else ""
            warnings.warn(GlimtWarning(f"{place}{tally.message}{times}", tally.count), stacklevel=2)
