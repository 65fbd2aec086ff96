"""Glyphs of Pillow's built-in font as coverage masks, and of signs that it lacks."""

import functools
import math
import unicodedata
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

_DIGITS = "0123456789"

# What the built-in font lacks: the advance and polylines, in em, from the baseline up.
_STROKES = {
    "×": (0.56, (((0.10, 0.10), (0.46, 0.46)), ((0.10, 0.46), (0.46, 0.10)))),
    "→": (0.90, (((0.08, 0.28), (0.80, 0.28)), ((0.56, 0.50), (0.80, 0.28), (0.56, 0.06)))),
    "←": (0.90, (((0.10, 0.28), (0.82, 0.28)), ((0.34, 0.50), (0.10, 0.28), (0.34, 0.06)))),
    "↑": (0.62, (((0.31, 0.00), (0.31, 0.66)), ((0.09, 0.42), (0.31, 0.66), (0.53, 0.42)))),
    "↓": (0.62, (((0.31, 0.04), (0.31, 0.70)), ((0.09, 0.28), (0.31, 0.04), (0.53, 0.28)))),
    "—": (0.96, (((0.04, 0.27), (0.92, 0.27)),)),
    "–": (0.60, (((0.04, 0.27), (0.56, 0.27)),)),
    "−": (0.56, (((0.08, 0.27), (0.48, 0.27)),)),
}
_PLAIN = {"×": "x", "→": ">", "←": "<", "↑": "^", "↓": "v", "—": "-", "–": "-", "−": "-", "…": ".", "·": ".", "²": "2",
          "³": "3", "µ": "u", "‘": "'", "’": "'", "“": '"', "”": '"', "\t": " "}
_SMOOTHING = 8


@dataclass(frozen=True)
class Glyph:
    """A character's coverage, (line height, width) uint8 with `left` columns before its origin, and its advance."""

    mask: NDArray[np.uint8]
    left: int
    advance: int


def line_height(size: int) -> int:
    """Return how many rows a line of text has, from the ascender to the descender."""
    return sum(_metrics(size))


@functools.lru_cache(1024)
def glyph_of(character: str, size: int) -> Glyph:
    """Return a character; all digits have the advance of the widest, so that numbers do not move."""
    if unicodedata.combining(character):
        return Glyph(np.zeros((line_height(size), 0), np.uint8), 0, 0)
    font = _font(size)
    if not isinstance(font, ImageFont.FreeTypeFont):
        return _bitmap_glyph(_replacement(character, 255), font, _magnification(size))
    if character in _STROKES:
        return _stroked(*_STROKES[character], size)
    if character in "²³":
        return _raised(unicodedata.normalize("NFKD", character), size)
    if not _has(font, character):
        character = _replacement(character, 126)
    left = math.ceil(size / 4)
    widest = max(font.getlength(digit) for digit in _DIGITS) if character in _DIGITS else font.getlength(character)
    image = Image.new("L", (math.ceil(widest) + 2 * left, line_height(size)))
    ImageDraw.Draw(image).text((left, 0), character, 255, font)
    least = math.ceil(0.27 * size) if character == " " else 0  # hinting makes small spaces too small
    return Glyph(np.asarray(image), left, max(round(widest), least))


@functools.lru_cache(16)
def _font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Return Pillow's own font, which needs no file; a bitmap font where Pillow was built without FreeType."""
    try:
        return ImageFont.load_default(size)
    except ImportError:
        return ImageFont.load_default()


@functools.lru_cache(16)
def _metrics(size: int) -> tuple[int, int]:
    """Return the rows above and below the baseline."""
    font = _font(size)
    if isinstance(font, ImageFont.FreeTypeFont):
        return font.getmetrics()
    return 9 * _magnification(size), 2 * _magnification(size)


def _magnification(size: int) -> int:
    """Return how often each pixel of the bitmap font, of 11 rows, is repeated."""
    return max(1, round(size / 11))


def _has(font: ImageFont.FreeTypeFont, character: str) -> bool:
    """Return whether a font draws a character, and not the box that stands for all that it lacks."""
    if not " " < character < "\ud800":
        return character == " "  # not control characters, nor half a pair that stands for a byte in a file's name
    missing, drawn = font.getmask("\uffff"), font.getmask(character)
    return drawn.size != missing.size or bytes(drawn) != bytes(missing)


def _replacement(character: str, last: int) -> str:
    """Return a character up to code `last` for one that a font lacks: without its accent, or "?"."""
    if " " <= character <= chr(last) and not "\x7f" <= character < "\xa0":
        return character
    plain = _PLAIN.get(character) or unicodedata.normalize("NFKD", character)[0]
    return plain if " " <= plain <= "~" else "?"


def _bitmap_glyph(character: str, font: ImageFont.ImageFont, times: int) -> Glyph:
    """Return a character of the bitmap font, magnified."""
    box = font.getbbox(character)
    image = Image.new("L", (int(box[2]), 11))
    ImageDraw.Draw(image).text((0, 0), character, 255, font)
    mask = np.asarray(image).repeat(times, 0).repeat(times, 1)
    return Glyph(mask, 0, mask.shape[1])


def _raised(character: str, size: int) -> Glyph:
    """Return a character as an exponent."""
    small = glyph_of(character, max(round(0.62 * size), 5))
    mask = np.zeros((line_height(size), small.mask.shape[1]), np.uint8)
    first = round(0.12 * size)
    rows = min(small.mask.shape[0], mask.shape[0] - first)
    mask[first:first + rows] = small.mask[:rows]
    return Glyph(mask, small.left, small.advance)


def _stroked(advance: float, strokes: tuple[tuple[tuple[float, float], ...], ...], size: int) -> Glyph:
    """Return a character drawn by polylines, smoothed by drawing it larger."""
    columns, rows = max(round(advance * size), 1), line_height(size)
    image = Image.new("L", (columns * _SMOOTHING, rows * _SMOOTHING))
    draw = ImageDraw.Draw(image)
    thickness = max(0.085 * size, 1.0) * _SMOOTHING
    for stroke in strokes:
        line = [(x * size * _SMOOTHING, (_metrics(size)[0] - y * size) * _SMOOTHING) for x, y in stroke]
        draw.line(line, 255, round(thickness), "curve")
    return Glyph(np.asarray(image.reduce(_SMOOTHING)), 0, columns)
