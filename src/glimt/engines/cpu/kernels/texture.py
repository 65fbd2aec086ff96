"""Texture look-ups: bilinear within a level, linear between levels."""

import numpy as np

from glimt.kernel import inline, routine
from glimt.lanes import (
    all_lanes,
    any_lane,
    bits,
    count_trailing_zeros,
    extract,
    floor,
    gather_int,
    gather_pairs,
    i32,
    log2,
    maximum,
    minimum,
    scalar,
    scalar_int,
    select,
    select3,
    to_float,
    to_int,
    vector3,
)
from glimt.layout import LEVEL, TEXEL_BITS, TEXEL_MAX, TEXTURE

_FAR_TEXCOORD = np.float32(1e6)
"""Texcoords beyond this are taken to the nearest end: float32 has no fraction left there worth a texture."""


@inline
def _texel(word):
    """Return the three parts of a texel, each 0..TEXEL_MAX."""
    return vector3(to_float(word & TEXEL_MAX), to_float((word >> TEXEL_BITS) & TEXEL_MAX),
                   to_float((word >> (TEXEL_BITS + TEXEL_BITS)) & TEXEL_MAX))


@inline
def _position(coordinate, size, clamp):
    """Return (first texel, weight of the one after it) along one axis; repeated texels go from -1 to size - 1."""
    position = coordinate * size - 0.5
    if clamp:
        position = minimum(maximum(position, 0.0), size - 1.0)
    first = floor(position)
    return first, position - first


@inline
def _lerp(a, b, weight):
    return a + (b - a) * weight


@inline
def _level(scene, lanes, level):
    """Return (first texel, width, height) of each lane's level; most packets agree on one."""
    first = extract(level, count_trailing_zeros(bits(lanes)))
    if all_lanes(~lanes | (level == first)):
        at = np.int64(first) * LEVEL.words
        return (i32(scalar_int(scene.levels, at + LEVEL.first_texel)), i32(scalar_int(scene.levels, at + LEVEL.width)),
                i32(scalar_int(scene.levels, at + LEVEL.height)))
    record = level * np.int32(LEVEL.words)
    return (gather_int(scene.levels, record + np.int32(LEVEL.first_texel), lanes),
            gather_int(scene.levels, record + np.int32(LEVEL.width), lanes),
            gather_int(scene.levels, record + np.int32(LEVEL.height), lanes))


@inline
def _bilinear(scene, lanes, level, u, v, clamp, squared):
    """Return the texture at (u, v) in 0..1 of the level whose record index is `level`."""
    start, width, height = _level(scene, lanes, level)
    columns, rows = to_float(width), to_float(height)
    x0, x = _position(u, columns, clamp)
    y0, y = _position(v, rows, clamp)
    y1 = y0 + 1.0
    last = rows - 1.0
    if clamp:
        y1 = minimum(y1, last)
    else:
        x0, y0 = select(x0 < 0.0, columns - 1.0, x0), select(y0 < 0.0, last, y0)
        y1 = select(y1 > last, 0.0, y1)
    first = start + to_int(x0)
    stride = width + 1
    left0, right0 = gather_pairs(scene.texels, to_int(y0) * stride + first, lanes)
    left1, right1 = gather_pairs(scene.texels, to_int(y1) * stride + first, lanes)
    a, b, c, d = _texel(left0), _texel(right0), _texel(left1), _texel(right1)
    if squared:
        a, b, c, d = a * a, b * b, c * c, d * d
    return _lerp(_lerp(a, b, x), _lerp(c, d, x), y)


@routine
def sample_texture(scene, texture, lanes, texcoord_u, texcoord_v, footprint, is_color):
    """Return the texture with record index `texture` (the same for all lanes) as values 0..1.

    `footprint` is the area of a pixel on the surface in texcoord units. The level is the one where that is a texel's,
    after Akenine-Möller et al., "Improved shader and texture level of detail using ray cones" (2021).
    """
    record = np.int64(texture) * TEXTURE.words
    clamp = scalar_int(scene.textures, record + TEXTURE.clamp) != 0
    scale_u = scalar(scene.textures, record + TEXTURE.scale)
    scale_v = scalar(scene.textures, record + TEXTURE.scale + 1)
    u = texcoord_u * scale_u + scalar(scene.textures, record + TEXTURE.offset)
    v = texcoord_v * scale_v + scalar(scene.textures, record + TEXTURE.offset + 1)
    u = minimum(maximum(u, -_FAR_TEXCOORD), _FAR_TEXCOORD)
    v = minimum(maximum(v, -_FAR_TEXCOORD), _FAR_TEXCOORD)
    if clamp:
        u, v = minimum(maximum(u, 0.0), 1.0), minimum(maximum(v, 0.0), 1.0)
    else:
        u, v = u - floor(u), v - floor(v)

    # Level of detail; squares keep the geometric mean of both directions without a root.
    first = scalar_int(scene.textures, record + TEXTURE.first_level)
    last = scalar_int(scene.textures, record + TEXTURE.levels) - 1
    at = np.int64(first) * LEVEL.words
    texels = (np.float32(scalar_int(scene.levels, at + LEVEL.width)) * abs(scale_u)
              * np.float32(scalar_int(scene.levels, at + LEVEL.height)) * abs(scale_v))
    detail = log2(maximum(footprint * texels, 1.0)) * 0.5
    detail = minimum(maximum(detail, 0.0), np.float32(last))
    lower = floor(detail)
    weight = detail - lower
    level = to_int(lower)

    value = _bilinear(scene, lanes, level + first, u, v, clamp, is_color)
    between = lanes & (weight > 0.0)
    if any_lane(between):
        coarser = _bilinear(scene, between, level + (first + 1), u, v, clamp, is_color)
        value = select3(between, _lerp(value, coarser, weight), value)
    one = np.float32(1) / np.float32(TEXEL_MAX)
    return value * (one * one if is_color else one)
