"""What debug views look like: numbers to colours."""

import numpy as np
import pytest

from glimt.color import linear_to_srgb, srgb_to_linear
from glimt.debug_view import DebugFilm, light_tints

RANDOM = np.random.default_rng(3)


def film(view, numbers, met=True):
    """Return a DebugFilm of one row with up to three numbers a pixel."""
    numbers = np.atleast_2d(np.asarray(numbers, np.float32).T).T
    values = np.zeros((1, len(numbers), 4), np.float32)
    values[0, :, :numbers.shape[1]] = numbers
    values[0, :, 3] = met
    values[values[..., 3] == 0, 0] *= view == "nodes"
    return DebugFilm(view, values)


def colors(view, numbers, met=True, scale=None):
    image = film(view, numbers, met).image(scale)
    assert image.dtype == np.uint8
    assert image.flags.c_contiguous
    return image[0].tolist()


def objects(numbers):
    values = np.ones((1, len(numbers), 4), np.float32)
    values.view(np.int32)[0, :, 0] = numbers
    return DebugFilm("instances", values).image()[0]


def lightness(codes):
    """Return CIE L*, 0 to 100."""
    luminance = srgb_to_linear(np.asarray(codes) / 255).astype(np.float64) @ (0.2126, 0.7152, 0.0722)
    return np.where(luminance > 216 / 24389, 116 * np.cbrt(luminance) - 16, luminance * 24389 / 27)


def test_normals_are_halved_and_moved_to_the_middle():
    assert colors("normals", [(1, 0, 0), (0, -1, 0), (0, 0, 1)]) == [[255, 128, 128], [128, 0, 128], [128, 128, 255]]
    assert colors("normals", [(0, 0, 0)], met=False) == [[0, 0, 0]]


def test_barycentrics_are_red_green_and_blue():
    assert colors("barycentrics", [*np.eye(3), (0.5, 0.25, 0.25)]) == [[255, 0, 0], [0, 255, 0], [0, 0, 255],
                                                                      [128, 64, 64]]
    assert colors("barycentrics", [(-1e-7, 1 + 1e-7, 0)]) == [[0, 255, 0]]


def test_near_is_bright_and_far_dark_but_not_as_dark_as_nothing():
    image = colors("depth", [1, 2, 3, 9], [1, 1, 1, 0], scale=(1, 3))
    assert image == [[255] * 3, [140] * 3, [26] * 3, [0] * 3]
    assert colors("depth", [0.5, 7], scale=(1, 3)) == [[255] * 3, [26] * 3]
    assert colors("depth", [5, 5]) == [[255] * 3] * 2


def test_depths_range_leaves_out_the_outermost():
    distances = np.concatenate([[1e-6], RANDOM.uniform(10, 20, 998), [1e9]])
    near, far = film("depth", distances).range()
    assert 10 <= near < 10.3
    assert 19.7 < far <= 20
    assert film("depth", distances, RANDOM.uniform(size=1000) < 0.5).range() == pytest.approx((10, 20), abs=0.5)
    assert film("depth", [1, 2, 3], met=False).range() == (0, 1)


def test_a_large_films_range_is_that_of_all():
    values = np.zeros((1000, 1500, 4), np.float32)
    values[..., 0], values[..., 3] = np.linspace(5, 6, 1500), 1
    assert DebugFilm("depth", values).range() == pytest.approx((5.01, 5.99), abs=0.01)
    values[400:600, 400:600, 0] = 90
    assert DebugFilm("nodes", values).range() == (0, 90)


def test_every_object_has_its_colour():
    image = objects(np.arange(200))
    assert len(np.unique(image, axis=0)) == 200
    assert (image.max(1) - image.min(1) > 40).all()  # none is grey
    assert image.min() > 0
    steps = np.abs(np.diff(image.astype(int), axis=0)).max(1)
    assert steps.min() > 60  # neighbours are told apart
    shuffled = RANDOM.permutation(200)
    np.testing.assert_array_equal(objects(shuffled), image[shuffled])
    assert objects([2**31 - 1]).max() > 0


def test_no_object_is_black():
    values = np.zeros((1, 2, 4), np.float32)
    values[0, 0, 3] = 1
    assert DebugFilm("instances", values).image()[0].any(1).tolist() == [True, False]


def test_the_heat_map_is_ordered_by_lightness():
    image = colors("nodes", np.arange(256), scale=(0, 255))
    assert image[0] == [0, 0, 0]
    assert image[-1] == [255, 255, 255]
    assert (np.diff(lightness(image)) > 0).all()
    np.testing.assert_allclose(lightness(image), np.linspace(0, 100, 256), atol=3)
    assert np.argmax(image[40]) == 2  # blue


def test_nodes_are_shown_where_nothing_is_met():
    few, many = colors("nodes", [1, 40], met=False)
    assert lightness(few) < lightness(many)
    assert many == [255, 255, 255]


def test_the_heat_maps_range_leaves_out_the_few_most_expensive():
    counts = np.concatenate([np.full(9999, 20), [500]])
    assert film("nodes", counts).range() == (0, 20)
    assert film("nodes", [0, 0]).range() == (0, 1)
    assert film("nodes", [3, 70]).range() == (0, 70)


def test_lights_are_added_up_as_light():
    image = colors("shadows", [(1, 1, 1), (0, 0, 0), (0, 1, 1), (0.25, 0, 0)])
    assert image[:3] == [[255] * 3, [0] * 3, [0, 255, 255]]
    assert image[3] == [round(float(linear_to_srgb(np.array([0.25]))[0]) * 255), 0, 0]


@pytest.mark.parametrize("count", range(1, 20))
def test_tints_differ_and_add_up_to_white(count):
    tints = light_tints(count)
    assert tints.shape == (count, 3)
    assert tints.dtype == np.float32
    np.testing.assert_allclose(tints.sum(0), 1, rtol=1e-6)
    assert len(np.unique(tints.round(4), axis=0)) == count


def test_a_light_by_itself_is_white():
    assert light_tints(3, 1).tolist() == [[0, 0, 0], [1, 1, 1], [0, 0, 0]]
    assert light_tints(0).shape == (0, 3)
