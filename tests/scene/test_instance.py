"""Instances as plain objects."""

import numpy as np
import pytest

from glimt import Instance, Mesh, linalg

MESH = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])


def test_an_instance_stands_where_the_mesh_was_modelled():
    np.testing.assert_array_equal(Instance(MESH).object_to_world, np.eye(3, 4))


@pytest.mark.parametrize("matrix", [np.eye(4), np.eye(3, 4).tolist(), np.eye(4, dtype=int), np.eye(4, dtype="f4")])
def test_matrices_of_3_or_4_rows(matrix):
    placed = Instance(MESH, matrix).object_to_world
    assert placed.shape == (3, 4)
    assert placed.dtype == np.float64
    np.testing.assert_array_equal(placed, np.eye(3, 4))


@pytest.mark.parametrize("matrix", [
    linalg.scaling((-1, 1, 1)), linalg.scaling(1e-12), linalg.scaling(1e12), linalg.scaling((1e-3, 1, 1e3)),
    linalg.compose(linalg.translation((1e6, 0, 0)), linalg.rotation((1, 1, 1), 50), linalg.scaling((1, 5, 0.2))),
])
def test_any_matrix_that_can_be_inverted(matrix):
    np.testing.assert_array_equal(Instance(MESH, matrix).object_to_world, matrix)
