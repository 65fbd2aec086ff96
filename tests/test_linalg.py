"""Affine transforms against NumPy's 4x4 products."""

import numpy as np
import pytest

from glimt import linalg

RNG = np.random.default_rng(12)


def _square(matrix):
    return np.vstack([matrix, [0, 0, 0, 1]])


def _random():
    return RNG.normal(size=(3, 4))


def test_compose_is_the_matrix_product():
    a, b, c = _random(), _random(), _random()
    np.testing.assert_allclose(_square(linalg.compose(a, b, c)), _square(a) @ _square(b) @ _square(c))
    np.testing.assert_array_equal(linalg.compose(), np.eye(3, 4))
    np.testing.assert_array_equal(linalg.identity(), np.eye(3, 4))


def test_inverse():
    matrix = _random()
    np.testing.assert_allclose(_square(linalg.inverse(matrix)), np.linalg.inv(_square(matrix)))
    with pytest.raises(np.linalg.LinAlgError):
        linalg.inverse(linalg.scaling((1, 0, 1)))


def test_points_and_vectors():
    matrix, points = _random(), RNG.normal(size=(4, 5, 3))
    extended = np.concatenate([points, np.ones((4, 5, 1))], -1)
    np.testing.assert_allclose(linalg.transform_points(matrix, points), extended @ matrix.T)
    np.testing.assert_allclose(linalg.transform_vectors(matrix, points), points @ matrix[:, :3].T)


def test_translation_and_scaling():
    np.testing.assert_array_equal(linalg.transform_points(linalg.translation((1, 2, 3)), [1, 1, 1]), [2, 3, 4])
    np.testing.assert_array_equal(linalg.transform_vectors(linalg.translation((1, 2, 3)), [1, 1, 1]), [1, 1, 1])
    np.testing.assert_array_equal(linalg.transform_points(linalg.scaling(2), [1, 2, 3]), [2, 4, 6])
    np.testing.assert_array_equal(linalg.transform_points(linalg.scaling((1, -2, 0.5)), [1, 2, 3]), [1, -4, 1.5])


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 0, 2), (1, -2, 3), (1e-200, 0, 1e-200)])
@pytest.mark.parametrize("angle_deg", [0, 30, 180, -90, 400])
def test_rotation(axis, angle_deg):
    turn = linalg.rotation(axis, angle_deg)[:, :3]
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(turn) == pytest.approx(1)
    np.testing.assert_allclose(turn @ linalg.normalize(axis), linalg.normalize(axis), atol=1e-14)
    assert np.trace(turn) == pytest.approx(1 + 2 * np.cos(np.radians(angle_deg)))


def test_rotation_is_right_handed():
    np.testing.assert_allclose(linalg.rotation((0, 0, 1), 90)[:, :3] @ [1, 0, 0], [0, 1, 0], atol=1e-15)


def test_transform_box_bounds_the_corners_tightly():
    for _ in range(20):
        matrix, ends = _random(), np.sort(RNG.normal(size=(2, 3)), 0)
        corners = np.stack(np.meshgrid(*ends.T), -1).reshape(8, 3)
        placed = linalg.transform_points(matrix, corners)
        lo, hi = linalg.transform_box(matrix, *ends)
        np.testing.assert_allclose(lo, placed.min(0))
        np.testing.assert_allclose(hi, placed.max(0))


@pytest.mark.parametrize("scale", [1e-300, 1e-20, 1, 1e20, 1e300])
def test_normalize_at_any_size(scale):
    vectors = RNG.normal(size=(7, 2, 3))
    np.testing.assert_allclose(linalg.normalize(vectors * scale),
                               vectors / np.linalg.norm(vectors, axis=-1, keepdims=True), rtol=1e-12)


def test_normalize_leaves_zero_vectors():
    np.testing.assert_array_equal(linalg.normalize([[0, 0, 0], [0, -3, 0]]), [[0, 0, 0], [0, -1, 0]])
