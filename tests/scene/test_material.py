"""Materials and textures as plain objects."""

import numpy as np
import pytest

from glimt import Material, Texture


def test_colours_are_one_number_or_three():
    material = Material(diffuse=0.25, specular=(1, 2, 3))
    assert material.diffuse == material.ambient == (0.25, 0.25, 0.25)
    assert material.specular == (1, 2, 3)
    assert Material(ambient=0, diffuse=np.array([0.5, 0.25, 1])).ambient == (0, 0, 0)
    assert Material(diffuse=np.float32(0.5)).diffuse == Material(diffuse=np.array(0.5)).diffuse == (0.5, 0.5, 0.5)


def test_defaults_are_plain_grey():
    material = Material()
    assert material.diffuse == (0.8, 0.8, 0.8)
    assert (material.specular, material.reflectivity) == ((0, 0, 0), 0)


@pytest.mark.parametrize(("pixels", "dtype"), [
    (np.zeros((2, 3, 3), np.uint8), np.uint8), (np.zeros((2, 3, 3)), np.float32), (np.zeros((2, 3, 3), "f4"), "f4"),
    ([[[0.5, 0.25, 1.0]]], np.float32),
])
def test_pixels_are_bytes_or_floats(pixels, dtype):
    texture = Texture(pixels)
    assert texture.pixels.dtype == dtype
    assert texture.pixels.flags.c_contiguous
    assert texture.encoding == "srgb"


def test_textures_share_a_pixel_array():
    pixels = np.zeros((4, 4, 3), np.uint8)
    assert np.shares_memory(Texture(pixels).pixels, Texture(pixels, "linear", "clamp").pixels)


def test_pixels_are_not_changed_in_place():
    texture = Texture(np.zeros((4, 4, 3), np.uint8))
    with pytest.raises(ValueError, match="read-only"):
        texture.pixels[0] = 1


def test_scale_and_offset_keep_their_precision():
    assert Texture(np.zeros((1, 1, 3), np.uint8), scale=(0.1, 2), offset=[0.3, -0.7]).scale == (0.1, 2)


def test_objects_are_themselves_only():
    assert Material() != Material()
    assert len({Material(), Material()}) == 2
