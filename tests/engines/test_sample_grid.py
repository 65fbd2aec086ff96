"""Pixels of several samples: which ones, and that each is added up where it belongs."""

from dataclasses import replace

import numpy as np
import pytest

from glimt import load
from glimt.io.example import example_path
from glimt.renderer import Renderer

SIZES = ((37, 23), (8, 8), (3, 40))
"""Whole blocks, and pictures that end within one, on either side."""


def film_of(scene, size, samples):
    settings = replace(scene.settings, width=size[0], height=size[1], samples=samples, max_bounces=2)
    return Renderer(replace(scene, settings=settings), engine="cpu", threads=2).render()


@pytest.mark.parametrize("samples", [2, 3, 4, 5, 8, 9])
@pytest.mark.parametrize("size", SIZES)
def test_samples_are_the_pixels_of_a_larger_picture(samples, size):
    """A pixel's samples are n×n pixels of the same picture with n times as many on each side."""
    width, height = size
    scene = load(example_path("stone_room.toml"))
    film = film_of(scene, size, samples)
    larger = film_of(scene, (width * samples, height * samples), 1)
    expected = larger.sums.reshape(height, samples, width, samples, 4).astype(np.float64).sum((1, 3))
    np.testing.assert_array_equal(film.sums[..., 3], samples**2)
    np.testing.assert_allclose(film.sums, expected, rtol=1e-5, atol=1e-6 * samples**2)
    assert film.counters == larger.counters


def test_the_most_samples_of_a_pixel():
    """64 a side, of which a block of rays covers an eighth."""
    scene = load(example_path("stone_room.toml"))
    film, larger = film_of(scene, (9, 5), 64), film_of(scene, (9 * 64, 5 * 64), 1)
    expected = larger.radiance.reshape(5, 64, 9, 64, 3).mean((1, 3), np.float64)
    np.testing.assert_allclose(film.radiance, expected, rtol=1e-4)
