"""Texture look-ups on a plane: bilinear values, borders, scale and offset, encodings."""

import numpy as np
import pytest
from pictures import facing, picture, pixel, plane, stored_color

from glimt import DirectionalLight, Material, Texture
from glimt.color import srgb_to_linear

RNG = np.random.default_rng(8)
PIXELS = RNG.random((5, 4, 3)).astype(np.float32)


def _bilinear(values, u, v, wrap):
    """Look (h, w, 3) values up in float64 at arrays of texcoords."""
    height, width = values.shape[:2]
    x, y = np.asarray(u, np.float64) * width - 0.5, np.asarray(v, np.float64) * height - 0.5
    x0, y0 = np.floor(x).astype(int), np.floor(y).astype(int)
    wx, wy = (x - x0)[..., None], (y - y0)[..., None]

    def at(row, column):
        if wrap == "clamp":
            return values[row.clip(0, height - 1), column.clip(0, width - 1)]
        return values[row % height, column % width]

    top = at(y0, x0) * (1 - wx) + at(y0, x0 + 1) * wx
    bottom = at(y0 + 1, x0) * (1 - wx) + at(y0 + 1, x0 + 1) * wx
    return top * (1 - wy) + bottom * wy


def _at(texture, u, v):
    """Return the texture at one texcoord: a plane whose corners all have it."""
    material = Material(diffuse=1, diffuse_texture=texture)
    return pixel(plane(material, texcoords=np.tile([u, v], (4, 1))), camera=facing(), ambient=1)


def _window(texture, lo, hi, size):
    """Return a picture of the texture from texcoords (lo, lo) on top left to (hi, hi) on bottom right."""
    corners = [[lo, hi], [hi, hi], [hi, lo], [lo, lo]]
    return picture(plane(Material(diffuse=1, diffuse_texture=texture), texcoords=corners), camera=facing(3, 1),
                   size=(size, size), ambient=1)


@pytest.mark.parametrize("shape", [(5, 4), (1, 1), (1, 7), (6, 1), (2, 2), (3, 64)])
@pytest.mark.parametrize("wrap", ["repeat", "clamp"])
def test_bilinear_values_inside_and_beyond(shape, wrap):
    pixels = RNG.random((*shape, 3)).astype(np.float32)
    size = 96
    seen = _window(Texture(pixels, "linear", wrap), -1.25, 1.75, size)
    places = -1.25 + 3 * (np.arange(size) + 0.5) / size
    u, v = np.meshgrid(places, places)
    if max(shape) * 3 / size > 1:  # minified: the next level is mixed in
        assert np.isfinite(seen).all()
        return
    np.testing.assert_allclose(seen, _bilinear(stored_color(pixels), u, v, wrap), atol=3e-5)


def test_texel_centres_are_exact():
    texture = Texture(PIXELS, "linear")
    for row in range(5):
        for column in range(4):
            np.testing.assert_allclose(_at(texture, (column + 0.5) / 4, (row + 0.5) / 5),
                                       stored_color(PIXELS[row, column]), rtol=2e-6)


def test_ten_bits_are_enough_for_any_8_bit_colour():
    codes = np.arange(256, dtype=np.uint8)
    seen = _window(Texture(np.repeat(codes[None, :, None], 3, 2), "srgb", "clamp"), 0, 1, 256)[128, :, 0]
    exact = srgb_to_linear(codes / np.float32(255)).astype(np.float64)
    assert np.abs(np.sqrt(seen) - np.sqrt(exact)).max() < 0.5 / 1023 + 1e-6
    back = 1.055 * np.maximum(seen, 0.0031308)**(1 / 2.4) - 0.055
    back = np.where(seen <= 0.0031308, seen * 12.92, back) * 255
    assert np.abs(back - codes).max() < 0.6


def test_linear_data_is_not_decoded():
    codes = np.array([0, 1, 100, 128, 254, 255], np.uint8)
    texture = Texture(np.repeat(codes[None, :, None], 3, 2), "linear", "clamp")
    for column, code in enumerate(codes):
        np.testing.assert_allclose(_at(texture, (column + 0.5) / 6, 0.5), stored_color(code / 255), rtol=1e-5,
                                   atol=1e-9)


def test_light_is_mixed_in_linear():
    """Half-way between black and white is half the light, not half the code."""
    texture = Texture(np.array([[[0] * 3, [255] * 3]], np.uint8), "srgb", "clamp")
    np.testing.assert_allclose(_at(texture, 0.5, 0.5), 0.5, rtol=1e-6)


@pytest.mark.parametrize("wrap", ["repeat", "clamp"])
@pytest.mark.parametrize(("u", "v"), [
    (0, 0), (1, 1), (-0.0, 1), (-1e-9, 0.3), (-7.25, -0.125), (1 - 2**-24, 2**-24), (-1, -3), (12345.25, -4096.5),
    (999999.5, -999999.5),
])
def test_borders(u, v, wrap):
    texture = Texture(PIXELS, "linear", wrap)
    wide_u, wide_v = np.float64(np.float32(u)), np.float64(np.float32(v))
    if wrap == "clamp":
        wide_u, wide_v = np.clip(wide_u, 0, 1), np.clip(wide_v, 0, 1)
    np.testing.assert_allclose(_at(texture, u, v), _bilinear(stored_color(PIXELS), wide_u, wide_v, wrap), atol=2e-6)


@pytest.mark.parametrize(("u", "v"), [(1e7, -1e7), (-1e15, 1e15), (1e15, 0.5)])
@pytest.mark.parametrize("scale", [(1, 1), (1e6, -1e6)])
def test_huge_texcoords_show_some_texel(u, v, scale):
    repeated = _at(Texture(PIXELS, "linear", scale=scale), u, v)
    assert (repeated >= stored_color(PIXELS).min((0, 1)) - 1e-6).all()
    assert (repeated <= stored_color(PIXELS).max((0, 1)) + 1e-6).all()
    clamped = _at(Texture(PIXELS, "linear", "clamp", scale=scale), u, v)
    row, column = ((-1 if place * factor > 1 else 0) for place, factor in ((v, scale[1]), (u, scale[0])))
    if v != 0.5:
        np.testing.assert_allclose(clamped, stored_color(PIXELS)[row, column], rtol=1e-5)


@pytest.mark.parametrize(("scale", "offset"), [((2, 3), (0, 0)), ((1, 1), (0.25, -0.5)), ((-1, 0.5), (0.3, 10.2)),
                                               ((0, 0), (0.6, 0.4))])
def test_scale_and_offset(scale, offset):
    seen = _window(Texture(PIXELS, "linear", scale=scale, offset=offset), 0, 1, 64)
    places = (np.arange(64) + 0.5) / 64
    u, v = np.meshgrid(places * scale[0] + offset[0], places * scale[1] + offset[1])
    np.testing.assert_allclose(seen, _bilinear(stored_color(PIXELS), u, v, "repeat"), atol=5e-5)


def test_top_left_of_the_texture_is_texcoord_0_0():
    pixels = np.zeros((2, 2, 3), np.float32)
    pixels[0, 0] = (1, 0, 0)
    seen = picture(plane(Material(diffuse=1, diffuse_texture=Texture(pixels, "linear", "clamp"))), camera=facing(),
                   size=(4, 4), ambient=1)
    assert seen[0, 0, 0] == pytest.approx(1, rel=1e-5)
    assert seen[0, 3, 0] == seen[3, 0, 0] == seen[3, 3, 0] == 0


def test_texture_multiplies_diffuse_and_ambient_but_not_specular():
    texture = Texture(np.full((1, 1, 3), 0.25, np.float32), "linear")
    material = Material(ambient=0.5, diffuse=(1, 0.5, 0), specular=0, diffuse_texture=texture)
    texel, sun = stored_color([0.25] * 3), DirectionalLight(direction=(0, 0, -1))
    np.testing.assert_allclose(pixel(plane(material), camera=facing(), ambient=1), texel * 0.5, rtol=1e-5)
    np.testing.assert_allclose(pixel(plane(material), sun, camera=facing()), texel * [1, 0.5, 0], rtol=1e-5)
    shiny = Material(diffuse=0, specular=0.7, exponent=4, diffuse_texture=texture)
    np.testing.assert_allclose(pixel(plane(shiny), sun, camera=facing()), 0.7, rtol=1e-5)
