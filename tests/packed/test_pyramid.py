"""Mip levels: sizes, means, and tall images that are decoded in bands."""

import itertools

import numpy as np
import pytest

from glimt import Texture
from glimt.layout import TEXEL_BITS, TEXEL_MAX
from glimt.packed import textures
from glimt.packed.textures import pyramid

RNG = np.random.default_rng(6)
SIZES = [(1, 1), (2, 2), (64, 64), (7, 5), (5, 8), (1, 33), (31, 1), (3, 3), (100, 37), (255, 2)]


def _decoded(level, use="data"):
    """Return the values, (h, w, 3), of a level's words."""
    values = np.stack([level >> (int(TEXEL_BITS) * k) & int(TEXEL_MAX) for k in range(3)], -1) / int(TEXEL_MAX)
    return values**2 if use == "color" else values


@pytest.mark.parametrize("size", SIZES)
def test_levels_halve_down_to_one_texel(size):
    shapes = [level.shape for level in pyramid(Texture(RNG.random((*size, 3)), "linear"), "data")]
    assert shapes[0] == size
    assert shapes[-1] == (1, 1)
    for (h, w), (h2, w2) in itertools.pairwise(shapes):
        assert (h2, w2) == (max(1, h // 2), max(1, w // 2))


@pytest.mark.parametrize("use", ["data", "color"])
@pytest.mark.parametrize("size", [*SIZES, (257, 3), (512, 6), (515, 9)])
def test_every_level_has_the_mean_of_the_image(size, use):
    pixels = RNG.random((*size, 3)).astype(np.float32)
    for level in pyramid(Texture(pixels, "linear"), use):
        # Rounding to 10 bits is even-handed: its mean error shrinks with the number of texels.
        np.testing.assert_allclose(_decoded(level, use).mean((0, 1)), pixels.mean((0, 1)),
                                   atol=1e-5 + 1.1e-3 / np.sqrt(level.size))


@pytest.mark.parametrize("size", [(6, 6), (5, 7), (9, 3)])
def test_texels_are_means_of_their_areas(size):
    """Each texel of level 1 covers size / half texels along an axis, the cut ones by their share."""
    def weights(count):
        half = max(1, count // 2)
        edges = np.arange(half + 1) * (count / half)
        k = np.arange(count)
        share = np.minimum(edges[1:, None], k + 1) - np.maximum(edges[:-1, None], k)
        return share.clip(0) / (count / half)

    pixels = RNG.random((*size, 3)).astype(np.float32)
    level = pyramid(Texture(pixels, "linear"), "data")[1]
    expected = np.einsum("yi,xj,ijk->yxk", weights(size[0]), weights(size[1]), pixels.astype(np.float64))
    np.testing.assert_allclose(_decoded(level), expected, atol=0.51 / 1023)


@pytest.mark.parametrize("use", ["data", "color"])
@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
@pytest.mark.parametrize("size", [(257, 5), (258, 4), (511, 1), (512, 7), (600, 3), (769, 6)])
def test_tall_images_in_bands_make_the_same_levels(monkeypatch, size, dtype, use):
    pixels = RNG.integers(0, 256, (*size, 3)).astype(dtype) if dtype == np.uint8 else RNG.random((*size, 3))
    texture = Texture(pixels, "srgb" if use == "color" else "linear")
    in_bands = pyramid(texture, use)
    monkeypatch.setattr(textures, "_BAND", 10**6)
    direct = pyramid(texture, use)
    assert [level.shape for level in in_bands] == [level.shape for level in direct]
    np.testing.assert_array_equal(in_bands[0], direct[0])
    for banded, whole in zip(in_bands, direct, strict=True):
        codes = [np.stack([level >> shift & 1023 for shift in (0, 10, 20)]) for level in (banded, whole)]
        difference = np.abs(codes[0] - codes[1])  # odd heights add in another order: a code may round the other way
        assert difference.max() <= (1 if size[0] % 2 else 0)
        assert difference.mean() < 0.02


def test_encodings():
    bytes_ = np.array([[[0, 128, 255]]], np.uint8)
    assert _decoded(pyramid(Texture(bytes_, "linear"), "data")[0]).ravel() == pytest.approx([0, 128 / 255, 1], abs=5e-4)
    linear = _decoded(pyramid(Texture(bytes_, "srgb"), "color")[0], "color").ravel()
    assert linear == pytest.approx([0, 0.2158605, 1], abs=5e-4)
    floats = Texture(np.array([[[-0.5, 0.5, 7.0]]]), "linear")
    assert _decoded(pyramid(floats, "data")[0]).ravel() == pytest.approx([0, 0.5, 1], abs=5e-4)


def test_colours_are_averaged_in_linear_light():
    checkers = Texture(np.array([[[0] * 3, [255] * 3], [[255] * 3, [0] * 3]], np.uint8), "srgb")
    assert _decoded(pyramid(checkers, "color")[1], "color").ravel() == pytest.approx([0.5] * 3, abs=1e-3)
