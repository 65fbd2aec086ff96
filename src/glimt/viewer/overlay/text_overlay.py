"""The overlay as lines of text, for canvases whose pixels are too large to draw it with: a terminal's."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from glimt.viewer.overlay.frame_info import FrameInfo
from glimt.viewer.overlay.frame_panel import detail_rows, headline
from glimt.viewer.overlay.frame_times import FrameTimes
from glimt.viewer.overlay.help_screen import Table
from glimt.viewer.overlay.overlay import Overlay

_HINT = "H keys, Ctrl-C ends"
_NARROWEST_COLUMN = 38


@dataclass(frozen=True)
class OverlayText:
    """What is to be told.

    Attributes
    ----------
    notices : tuple of str
        Lines for the lower edge of the picture, the last one lowest.
    error : str
        What is wrong with the scene's files, one line; or nothing.
    help : sequence of (group, keys, help), or None
    """

    notices: tuple[str, ...] = ()
    error: str = ""
    help: Table | None = None


class TextOverlay(Overlay):
    """Leaves pictures as they are and keeps what is to be told as text.

    Attributes
    ----------
    text : OverlayText
        Of the last picture; any thread may read it.
    """

    def __init__(self) -> None:
        super().__init__()
        self.text = OverlayText()
        self._help: Table | None = None

    def draw(self, picture: NDArray[np.uint8], info: FrameInfo, times: FrameTimes, level: int) -> None:
        """Keep the numbers and notices."""
        del picture, times
        notices = [*(info.picked or "").splitlines(), *([info.message] if info.message else [])]
        if level > 0:
            details = (f"{label} {value}" for row in detail_rows(info)[1:] for label, value in row)
            notices.append(" · ".join([_HINT, *headline(info), *details]))
        self.text, self._help = OverlayText(tuple(notices), " ".join((info.error or "").split()), self._help), None

    def draw_help(self, picture: NDArray[np.uint8], table: Table) -> bool:
        """Keep the help for the next `draw`."""
        del picture
        self._help = table
        return True


def help_lines(table: Table, columns: int, rows: int) -> list[str]:
    """Return the table as lines of text, as wide as `columns`: with the groups' names, if those fit into `rows`."""
    for with_names in (True, False):
        entries = _entries(table, with_names)
        for parts in range(1, max(columns // _NARROWEST_COLUMN, 1) + 1):
            height = math.ceil(len(entries) / parts)
            if height <= rows:
                width = columns // parts
                return ["".join(_fitted(entry, width - 2).ljust(width) for entry in entries[row::height]).ljust(columns)
                        for row in range(height)]
    kept = [_fitted(entry, columns).ljust(columns) for entry in entries[:max(rows - 1, 0)]]
    return [*kept, _fitted("… more in a larger window", columns).ljust(columns)]


def _entries(table: Table, with_names: bool) -> list[str]:
    width = max(len(keys) for _, keys, _ in table)
    entries, last = [], None
    for group, keys, text in table:
        if with_names and group != last:
            entries += ["", group.upper()]
            last = group
        entries.append(f" {keys:{width}}  {text}")
    return entries[1:] if with_names else entries


def _fitted(text: str, width: int) -> str:
    return text if len(text) <= width else text[:max(width - 1, 0)] + "…"
