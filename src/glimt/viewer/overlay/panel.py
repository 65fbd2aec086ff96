"""Rounded translucent panels with text, and how they are laid over a picture."""

import functools

import numpy as np
from numpy.typing import NDArray

from glimt.viewer.overlay.text import text_mask, text_width

Color = tuple[int, int, int]

DARK: Color = (14, 16, 20)
RED: Color = (104, 18, 22)
BRIGHT: Color = (246, 247, 249)
DIM: Color = (186, 191, 200)
ACCENT: Color = (255, 200, 110)
OPACITY = 0.8
_CHUNK = 1 << 15


class Panel:
    """A rounded rectangle with text, laid over a picture by `new = (old * keep + add) / 256` in each channel.

    Parameters
    ----------
    width, height : int
        Pixels.
    radius : float
        Of the corners, in pixels.
    color : triple of int
        sRGB codes.
    opacity : float
        0 to 1.
    """

    def __init__(self, width: int, height: int, radius: float, color: Color = DARK, opacity: float = OPACITY) -> None:
        self.width, self.height = width, height
        self._keep, self._add = (part.copy() for part in _empty(width, height, radius, color, opacity))

    def write(self, text: str, x: int, y: int, size: int, color: Color = BRIGHT, align: float = 0.0) -> None:
        """Write a line with its top at row y, and column x at its left (align 0), middle (0.5) or right end (1)."""
        mask = text_mask(text, size)
        left = x - round(align * text_width(text, size))
        first = max(-left, 0)
        mask = mask[:max(self.height - y, 0), first:max(self.width - left, first)]
        left += first
        self._paint(slice(y, y + mask.shape[0]), slice(left, left + mask.shape[1]),
                    mask[..., None] * np.float32(1 / 255), color)

    def fill(self, x: int, y: int, width: int, height: int, color: Color, opacity: float) -> None:
        """Fill a rectangle inside the panel."""
        self._paint(slice(y, y + height), slice(x, x + width), np.full((height, width, 1), opacity, np.float32), color)

    def draw(self, picture: NDArray[np.uint8], x: int, y: int) -> None:
        """Blend into (h, w, 4) pixels with the top-left corner at column x, row y; what lies outside is left out."""
        left, top = max(x, 0), max(y, 0)
        right, bottom = min(x + self.width, picture.shape[1]), min(y + self.height, picture.shape[0])
        if left >= right:
            return
        rows = max(_CHUNK // (4 * (right - left)), 1)  # what is between stays in the cache
        for first in range(top, bottom, rows):
            last = min(first + rows, bottom)
            part = slice(first - y, last - y), slice(left - x, right - x)
            region = picture[first:last, left:right]
            blended = region * self._keep[part]
            blended += self._add[part]
            blended >>= 8
            region[...] = blended

    def _paint(self, rows: slice, columns: slice, alpha: NDArray[np.float32], color: Color) -> None:
        keep, add = self._keep[rows, columns], self._add[rows, columns]
        keep[...] = keep * (1 - alpha) + np.float32(0.5)
        # The sum of both products must stay below 65,536 however they were rounded.
        add[...] = np.minimum(add + (_opaque(color) - add) * alpha, 65535 - 255 * keep.astype(np.float32))


def _opaque(color: Color) -> NDArray[np.float32]:
    """Return what is added for an opaque pixel: rounded, and with an opacity of its own."""
    return np.array([*color, 255], np.float32) * 256 + 128


@functools.lru_cache(4)
def _empty(width: int, height: int, radius: float, color: Color,
           opacity: float) -> tuple[NDArray[np.uint16], NDArray[np.uint16]]:
    """Return what an empty panel keeps and adds, (h, w, 4) each: the same ones are asked for again and again."""
    radius = max(min(radius, width / 2, height / 2), 0.5)
    x = np.maximum(np.abs(np.arange(width) + 0.5 - width / 2) - (width / 2 - radius), 0)
    y = np.maximum(np.abs(np.arange(height) + 0.5 - height / 2) - (height / 2 - radius), 0)
    coverage = np.clip(radius + 0.5 - np.hypot(x, y[:, None]), 0, 1).astype(np.float32)
    keep = np.rint(256 - 256 * np.float32(opacity) * coverage)[..., None]
    add = (1 - keep / 256) * (_opaque(color) - 128) + 128
    return keep.repeat(4, axis=2).astype(np.uint16), add.astype(np.uint16)
