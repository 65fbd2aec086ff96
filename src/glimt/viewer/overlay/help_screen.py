"""The help screen: the table of keys in columns of groups, as large as the picture allows."""

from collections.abc import Sequence
from dataclasses import dataclass

from glimt.viewer.overlay.glyph import line_height
from glimt.viewer.overlay.panel import ACCENT, BRIGHT, DIM, Color, Panel
from glimt.viewer.overlay.text import LEGIBLE, text_width, wrap

Table = Sequence[tuple[str, str, str]]
"""Rows of group, keys and help; a group's rows follow each other."""
_TITLE = "Keys"
_WIDEST_HELP = 17  # em
_NARROWEST_HELP = 6  # em


@dataclass(frozen=True)
class PlacedText:
    """A line of text, its top-left corner in the panel and its look."""

    text: str
    x: int
    y: int
    size: int
    color: Color


@dataclass(frozen=True)
class HelpLayout:
    """Where everything is on the help screen, in pixels; `is_whole` tells whether nothing had to be left out."""

    width: int
    height: int
    padding: int
    texts: tuple[PlacedText, ...]
    is_whole: bool


def help_layout(table: Table, size: int, room: tuple[int, int]) -> HelpLayout | None:
    """Lay the table out in a panel of at most `room` columns and rows of pixels, with text of at most `size`.

    Two columns of groups if they fit, else one; smaller text if that does not help, down to `LEGIBLE`. Where even
    that is too large, rows at the end are left out; None if nothing is left.
    """
    for smaller in range(size, LEGIBLE - 1, -1):
        for columns in (2, 1):
            layout = _try(table, columns, smaller, room)
            if layout is not None and layout.height <= room[1]:
                return layout
    layout = _try(table, 2, LEGIBLE, room) or _try(table, 1, LEGIBLE, room)
    if layout is None:
        return None
    last = room[1] - layout.padding - line_height(LEGIBLE)
    texts = tuple(text for text in layout.texts if text.y <= last)
    return HelpLayout(layout.width, room[1], layout.padding, texts, False) if len(texts) > 1 else None


def help_panel(layout: HelpLayout) -> Panel:
    """Draw a layout."""
    panel = Panel(layout.width, layout.height, 0.8 * layout.padding, opacity=0.86)
    for text in layout.texts:
        panel.write(text.text, text.x, text.y, text.size, text.color)
    return panel


def _try(table: Table, columns: int, size: int, room: tuple[int, int]) -> HelpLayout | None:
    """Return the layout with so many columns, as high as it gets; None where they are too narrow."""
    padding = round(1.3 * size)
    gap = round(2.2 * size)
    title = round(1.5 * size)
    keys_width = max((text_width(keys, size) for _, keys, _ in table), default=0) + size
    help_width = max((text_width(text, size) for _, _, text in table), default=0)
    space = (room[0] - 2 * padding - (columns - 1) * gap) // columns - keys_width
    if space < min(help_width, _NARROWEST_HELP * size):
        return None
    help_width = min(space, help_width, _WIDEST_HELP * size)
    groups = [_group([row for row in table if row[0] == name], size, keys_width, help_width)
              for name in dict.fromkeys(row[0] for row in table)]
    top = padding + line_height(title) + round(0.6 * size)
    texts = [PlacedText(_TITLE, padding, padding - round(0.3 * size), title, BRIGHT)]
    bottom = top
    first = _break_after([height for _, height in groups]) if columns == 2 else len(groups)
    for column, part in enumerate((groups[:first], groups[first:])):
        y = top
        for lines, height in part:
            x = padding + column * (keys_width + help_width + gap)
            texts += [PlacedText(line.text, x + line.x, y + line.y, size, line.color) for line in lines]
            y += height
            bottom = max(bottom, y)
    width = 2 * padding + columns * (keys_width + help_width) + (columns - 1) * gap
    return HelpLayout(width, bottom - round(0.7 * size) + padding, padding, tuple(texts), True)


def _group(rows: Table, size: int, keys_width: int, help_width: int) -> tuple[list[PlacedText], int]:
    """Return the lines of a group, placed from its own corner, and its height with the gap below."""
    line, between = line_height(size), round(0.2 * size)
    texts = [PlacedText(rows[0][0], 0, 0, size, ACCENT)]
    y = line + round(0.35 * size)
    for _, keys, text in rows:
        texts.append(PlacedText(keys, 0, y, size, BRIGHT))
        wrapped = wrap(text, size, help_width, 4)
        texts += [PlacedText(part, keys_width, y + place * line, size, DIM) for place, part in enumerate(wrapped)]
        y += max(len(wrapped), 1) * line + between
    return texts, y + round(0.7 * size)


def _break_after(heights: list[int]) -> int:
    """Return how many groups go into the first of two columns, so that the higher one is as low as can be."""
    return min(range(len(heights) + 1), key=lambda first: (max(sum(heights[:first]), sum(heights[first:])), -first))
