"""Textures as mip-mapped texels of 10:10:10 bits."""

from concurrent.futures import ThreadPoolExecutor
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from glimt.color import srgb_to_linear
from glimt.layout import LEVEL, TEXEL_BITS, TEXEL_MAX, TEXTURE, dtype
from glimt.scene.texture import Texture

Use = Literal["color", "data"]
_BAND = 256  # rows of the largest level that are decoded at a time: bounds the memory of huge images


class _Pyramid(NamedTuple):
    """The levels of one image: their sizes (width, height), and all their texels as a part of the joined ones."""

    pixels: NDArray[Any]  # known by their place in memory, which must not be given away
    sizes: list[tuple[int, int]]
    texels: NDArray[np.int32]


_Key = tuple[Any, ...]


class TexturePacker:
    """Collects the textures of a scene, again and again; equal pixel arrays are stored once for each use.

    Pyramids of the scene before are kept, as parts of its joined texels.

    A colour is stored as the square root of its linear value, which spends the bits about as sRGB does and averages
    in linear light; data (normals) is stored as it is.
    """

    def __init__(self, threads: int = 1) -> None:
        self._threads = threads
        self._used: dict[tuple[Texture, Use], int] = {}
        self._pyramids: dict[_Key, _Pyramid] = {}
        self._joined: tuple[NDArray[np.float32], NDArray[np.float32]] | None = None

    def add(self, texture: Texture | None, use: Use) -> int:
        """Return the index that the texture's record will have, -1 for none."""
        return -1 if texture is None else self._used.setdefault((texture, use), len(self._used))

    def finish(self) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
        """Return (textures, levels, texels) of all that was added, one empty entry each for none; then start anew."""
        used, self._used = self._used, {}
        wanted = {_key(texture, use): (texture, use) for texture, use in used}
        if self._joined is None or list(wanted) != list(self._pyramids):
            new = {key: wanted[key] for key in wanted if key not in self._pyramids}
            with ThreadPoolExecutor(self._threads) as pool:  # NumPy lets go of the GIL
                made = dict(zip(new, pool.map(lambda each: _pyramid(*each), new.values()), strict=True))
            self._pyramids = {key: self._pyramids.get(key) or made[key] for key in wanted}
            self._joined = self._join()
        records = np.zeros(max(1, len(used)), dtype(TEXTURE))
        first_level, first = {}, 0
        for key, known in self._pyramids.items():
            first_level[key], first = first, first + len(known.sizes)
        for record, (texture, use) in zip(records, used, strict=False):
            key = _key(texture, use)
            record["first_level"], record["levels"] = first_level[key], len(self._pyramids[key].sizes)
            record["clamp"] = texture.wrap == "clamp"
            record["scale"], record["offset"] = texture.scale, texture.offset
        return records.view(np.float32), *self._joined

    def _join(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return (levels, texels) of all pyramids, which become parts of them."""
        sizes = np.array([size for known in self._pyramids.values() for size in known.sizes], np.int64).reshape(-1, 2)
        counts = (sizes[:, 0] + 1) * sizes[:, 1]
        levels = np.zeros(max(1, len(sizes)), dtype(LEVEL))
        levels["first_texel"][:len(sizes)] = np.cumsum(counts) - counts
        levels["width"][:len(sizes)], levels["height"][:len(sizes)] = sizes.T
        texels, first = np.zeros(max(1, int(counts.sum())), np.int32), 0
        for key, known in self._pyramids.items():
            part = texels[first:first + known.texels.size]
            part[:] = known.texels
            self._pyramids[key] = known._replace(texels=part)
            first += part.size
        return levels.view(np.float32), texels.view(np.float32)


def _key(texture: Texture, use: Use) -> _Key:
    """Return what equal pixel arrays share, be they views of each other."""
    pixels = texture.pixels
    return pixels.__array_interface__["data"][0], pixels.shape, pixels.strides, texture.encoding, use


def _pyramid(texture: Texture, use: Use) -> _Pyramid:
    """Return an image's levels, rows ending with their first texel."""
    levels = pyramid(texture, use)
    texels = np.concatenate([np.concatenate([level, level[:, :1]], 1).ravel() for level in levels])
    return _Pyramid(texture.pixels, [(level.shape[1], level.shape[0]) for level in levels], texels)


def pyramid(texture: Texture, use: Use) -> list[NDArray[np.int32]]:
    """Return the texels of all levels, (h, w) each, halving down to one texel."""
    height = len(texture.pixels)
    levels = [_encode_image(texture, use)]
    if height <= _BAND:
        level = _decode(texture, 0, height)
    else:
        level = _halve_in_bands(texture)
        levels.append(_encode(level, use))
    while level.shape[0] > 1 or level.shape[1] > 1:
        level = _halve(_halve(level, 0), 1)
        levels.append(_encode(level, use))
    return levels


def _encode_image(texture: Texture, use: Use) -> NDArray[np.int32]:
    """Return the texels of level 0: of bytes through a table, of floats in bands."""
    pixels = texture.pixels
    if pixels.dtype == np.uint8:
        codes = _codes(_byte_values(texture), use)
        red, green, blue = (np.take(codes << (TEXEL_BITS * k), pixels[..., k]) for k in range(3))
        red |= green
        red |= blue
        return np.asarray(red, np.int32)
    return np.concatenate([_encode(_decode(texture, start, start + _BAND), use)
                           for start in range(0, len(pixels), _BAND)])


def _byte_values(texture: Texture) -> NDArray[np.float32]:
    """Return the linear values of bytes, (256,)."""
    values = np.arange(256, dtype=np.float32) / np.float32(255)
    return srgb_to_linear(values) if texture.encoding == "srgb" else values


def _decode(texture: Texture, start: int, end: int) -> NDArray[np.float32]:
    """Return rows of the image as linear float32."""
    rows = texture.pixels[start:end]
    if rows.dtype == np.uint8:
        return np.take(_byte_values(texture), rows)
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
    bits = _codes(level, use)
    return bits[..., 0] | bits[..., 1] << TEXEL_BITS | bits[..., 2] << (2 * TEXEL_BITS)


def _codes(values: NDArray[np.float32], use: Use) -> NDArray[np.int32]:
    """Return the bits of each value by itself."""
    values = np.clip(values, np.float32(0), np.float32(1))
    values = (np.sqrt(values) if use == "color" else values) * np.float32(TEXEL_MAX) + np.float32(0.5)
    return values.astype(np.int32)
