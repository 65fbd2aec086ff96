"""Textures as mip-mapped texels of 10:10:10 bits."""

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from glimt.color import srgb_to_linear
from glimt.layout import LEVEL, TEXEL_BITS, TEXEL_MAX, TEXTURE, dtype
from glimt.scene.texture import Texture

Use = Literal["color", "data"]
_BAND = 256  # rows of the largest level that are decoded at a time: bounds the memory of huge images


@dataclass
class TexturePacker:
    """Collects textures; equal pixel arrays are stored once for each use.

    A colour is stored as the square root of its linear value, which spends the bits about as sRGB does and averages
    in linear light; data (normals) is stored as it is.
    """

    records: list[Any] = field(default_factory=list)
    levels: list[tuple[int, int, int]] = field(default_factory=list)
    texels: list[NDArray[np.int32]] = field(default_factory=list)
    _texel_count: int = 0
    _pyramids: dict[tuple[int, Use], tuple[int, int]] = field(default_factory=dict)
    _ids: dict[tuple[int, Use], int] = field(default_factory=dict)

    def add(self, texture: Texture | None, use: Use) -> int:
        """Return the index of the texture's record, -1 for none."""
        if texture is None:
            return -1
        if (id(texture), use) not in self._ids:
            self._ids[id(texture), use] = len(self.records)
            first, count = self._add_pyramid(texture, use)
            record = np.zeros((), dtype(TEXTURE))
            record["first_level"], record["levels"] = first, count
            record["clamp"] = texture.wrap == "clamp"
            record["scale"], record["offset"] = texture.scale, texture.offset
            self.records.append(record)
        return self._ids[id(texture), use]

    def _add_pyramid(self, texture: Texture, use: Use) -> tuple[int, int]:
        key = (id(texture.pixels), use)
        if key not in self._pyramids:
            first = len(self.levels)
            for level in pyramid(texture, use):
                height, width = level.shape
                self.levels.append((self._texel_count, width, height))
                wrapped = np.concatenate([level, level[:, :1]], 1)
                self.texels.append(wrapped.ravel())
                self._texel_count += wrapped.size
            self._pyramids[key] = first, len(self.levels) - first
        return self._pyramids[key]

    def arrays(self) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
        """Return (textures, levels, texels) as words, one empty entry each where there is nothing."""
        records = np.array(self.records or [np.zeros((), dtype(TEXTURE))], dtype(TEXTURE))
        levels = np.zeros(max(1, len(self.levels)), dtype(LEVEL))
        for name, column in zip(("first_texel", "width", "height"), zip(*self.levels, strict=True), strict=False):
            levels[name] = column
        texels = np.concatenate(self.texels) if self.texels else np.zeros(1, np.int32)
        return records.view(np.float32), levels.view(np.float32), texels.view(np.float32)


def pyramid(texture: Texture, use: Use) -> list[NDArray[np.int32]]:
    """Return the texels of all levels, (h, w) each, halving down to one texel."""
    height = len(texture.pixels)
    if height <= _BAND:
        level = _decode(texture, 0, height)
        levels = [_encode(level, use)]
    else:
        levels = [np.concatenate([_encode(_decode(texture, start, min(start + _BAND, height)), use)
                                  for start in range(0, height, _BAND)])]
        level = _halve_in_bands(texture)
        levels.append(_encode(level, use))
    while level.shape[0] > 1 or level.shape[1] > 1:
        level = _halve(_halve(level, 0), 1)
        levels.append(_encode(level, use))
    return levels


def _decode(texture: Texture, start: int, end: int) -> NDArray[np.float32]:
    """Return rows of the image as linear float32."""
    rows = texture.pixels[start:end]
    if rows.dtype == np.uint8:
        table = np.arange(256, dtype=np.float32) / np.float32(255)
        table = srgb_to_linear(table) if texture.encoding == "srgb" else table
        return np.asarray(table[rows], np.float32)
    return srgb_to_linear(rows) if texture.encoding == "srgb" else rows.astype(np.float32)


def _halve_in_bands(texture: Texture) -> NDArray[np.float32]:
    """Return level 1 of a tall image without ever holding level 0 as floats."""
    height = len(texture.pixels)
    if height % 2:  # odd heights need their neighbours' rows: decode at once, narrow first
        narrow = np.concatenate([_halve(_decode(texture, start, min(start + _BAND, height)), 1)
                                 for start in range(0, height, _BAND)])
        return _halve(narrow, 0)
    return np.concatenate([_halve(_halve(_decode(texture, start, min(start + _BAND, height)), 0), 1)
                           for start in range(0, height, _BAND)])


def _halve(level: NDArray[np.float32], axis: int) -> NDArray[np.float32]:
    """Return a level at half the size along one axis (floor), by exact areas: odd sizes take three texels each."""
    level = np.moveaxis(level, axis, 0)
    size = len(level)
    half = size // 2
    if size == 1:
        result = level
    elif size % 2 == 0:
        result = (level[0::2] + level[1::2]) * np.float32(0.5)
    else:
        j = np.arange(half, dtype=np.float32).reshape(-1, *[1] * (level.ndim - 1))
        result = ((half - j) * level[0:-2:2] + half * level[1:-1:2] + (j + 1) * level[2::2]) * np.float32(1 / size)
    return np.ascontiguousarray(np.moveaxis(result, 0, axis))


def _encode(level: NDArray[np.float32], use: Use) -> NDArray[np.int32]:
    """Return (h, w) words of 10:10:10 bits."""
    level = np.clip(level, np.float32(0), np.float32(1))
    values = (np.sqrt(level) if use == "color" else level) * np.float32(TEXEL_MAX) + np.float32(0.5)
    bits = values.astype(np.int32)
    return bits[..., 0] | bits[..., 1] << TEXEL_BITS | bits[..., 2] << (2 * TEXEL_BITS)
