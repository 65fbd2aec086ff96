"""Films: means, counters, images."""

import numpy as np

from glimt import Film
from glimt.color import develop
from glimt.film import Counters


def test_radiance_is_the_mean_over_samples():
    sums = np.zeros((2, 2, 4), np.float32)
    sums[0, 0], sums[0, 1], sums[1, 0] = (1, 2, 3, 1), (4, 8, 12, 4), (0.5, 0, 0, 0)
    radiance = Film(sums).radiance
    assert radiance.dtype == np.float32
    assert radiance.shape == (2, 2, 3)
    np.testing.assert_array_equal(radiance[0], [[1, 2, 3], [1, 2, 3]])
    np.testing.assert_array_equal(radiance[1], [[0.5, 0, 0], [0, 0, 0]])


def test_image_is_the_developed_mean():
    sums = np.random.default_rng(0).random((4, 5, 4)).astype(np.float32)
    sums[..., 3] = 3
    film = Film(sums)
    np.testing.assert_array_equal(film.image(0.5, "filmic"), develop(film.radiance, 0.5, "filmic"))


def test_counters_add_up():
    assert Counters(1, 20, 300, 4000).rays == 321
    assert Film(np.zeros((1, 1, 4), np.float32)).counters.rays == 0
