"""Lines of text as coverage masks, and text broken into lines."""

import functools

import numpy as np
from numpy.typing import NDArray

from glimt.viewer.overlay.glyph import glyph_of, line_height

LONGEST = 400
"""Characters of a line; what goes beyond is cut off."""
LEGIBLE = 9
"""Pixels of an em below which nobody can read a text."""
_ELLIPSIS = "…"


def text_width(text: str, size: int) -> int:
    """Return how many columns a line of text has."""
    return sum(glyph_of(character, size).advance for character in text[:LONGEST])


@functools.lru_cache(256)
def text_mask(text: str, size: int) -> NDArray[np.uint8]:
    """Return the coverage of a line of text.

    Parameters
    ----------
    text : str
        Characters that the font lacks are drawn as their nearest relatives or "?"; cut off after `LONGEST`.
    size : int
        Pixels of an em.

    Returns
    -------
    (line height, width) uint8, 255 where a pixel is covered. Read-only, since it is cached.
    """
    mask = np.zeros((line_height(size), max(text_width(text, size), 1)), np.uint8)
    pen = 0
    for character in text[:LONGEST]:
        glyph = glyph_of(character, size)
        first = max(pen - glyph.left, 0)
        last = min(pen - glyph.left + glyph.mask.shape[1], mask.shape[1])
        under = mask[:, first:last]
        offset = first - pen + glyph.left
        np.maximum(under, glyph.mask[:, offset:offset + last - first], out=under)
        pen += glyph.advance
    mask.flags.writeable = False
    return mask


def shorten(text: str, size: int, width: int) -> str:
    """Return as much of a text as `width` columns hold, with an ellipsis where something was cut off."""
    return text if _fitting(text, size, width) == len(text) else _cut(text, size, width)


def wrap(text: str, size: int, width: int, most_lines: int) -> list[str]:
    """Break a text into lines of at most `width` columns, at spaces if it has any; an ellipsis says that it goes on."""
    lines: list[str] = []
    for paragraph in text[:LONGEST * most_lines].splitlines():
        rest = paragraph.strip()
        while rest and len(lines) <= most_lines:
            line = _first_line(rest, size, width)
            lines.append(line.rstrip())
            rest = rest[len(line):].lstrip()
    if lines and (len(lines) > most_lines or len(text) > LONGEST * most_lines):
        lines = lines[:most_lines]
        lines[-1] = _cut(lines[-1], size, width)
    return lines


def _first_line(text: str, size: int, width: int) -> str:
    """Return what goes into the first line: whole words, or a part of a word that is too long; never nothing."""
    count = _fitting(text, size, width)
    if count == len(text):
        return text
    space = text.rfind(" ", 0, count + 1)
    return text[:space if space > 0 else max(count, 1)]


def _cut(text: str, size: int, width: int) -> str:
    """Return as much of a text as leaves room for an ellipsis, and the ellipsis."""
    return text[:_fitting(text, size, width - text_width(_ELLIPSIS, size))].rstrip() + _ELLIPSIS


def _fitting(text: str, size: int, width: int) -> int:
    """Return how many characters of a text `width` columns hold, `LONGEST` at most."""
    used = count = 0
    for character in text[:LONGEST]:
        used += glyph_of(character, size).advance
        if used > width:
            break
        count += 1
    return count
