"""Films: means, counters, images."""

import numpy as np

from glimt import Film
from glimt.color import develop
from glimt.film import Counters, sums_for


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


def test_films_begin_on_a_cache_line_and_are_written_over_where_they_fit():
    """A packet's pixels are then never in two lines."""
    films = [Film(sums_for((width, 5), None)) for width in range(1, 40)]
    assert all(film.sums.ctypes.data % 64 == 0 and film.sums.flags.c_contiguous for film in films)
    assert [film.sums.shape for film in films] == [(5, width, 4) for width in range(1, 40)]
    assert sums_for((7, 5), films[6]) is films[6].sums
    assert sums_for((5, 7), films[6]).shape == (7, 5, 4)


def test_counters_add_up():
    assert Counters(1, 20, 300, 4000).rays == 321
    assert Film(np.zeros((1, 1, 4), np.float32)).counters.rays == 0
