"""Computed normals against closed forms."""

import numpy as np
import pytest

from glimt.io.smooth import smooth_normals, unique_rows, weld


def sphere(rings=12, radius=1.0):
    """Return positions and triangles of a latitude-longitude sphere whose seam and poles have vertices of their own."""
    theta, phi = np.meshgrid(np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, 2 * rings + 1), indexing="ij")
    points = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
    points = (points.round(12) * radius).astype(np.float32)
    ids = np.arange(theta.size, dtype=np.int32).reshape(theta.shape)
    a, b, c, d = ids[:-1, :-1], ids[1:, :-1], ids[1:, 1:], ids[:-1, 1:]
    upper, lower = np.stack([a, b, c], -1)[:-1], np.stack([a, c, d], -1)[1:]
    return points.reshape(-1, 3), np.concatenate([upper.reshape(-1, 3), lower.reshape(-1, 3)])


def normals_of(positions, triangles, groups=None, faces=None):
    faces = np.arange(len(triangles)) if faces is None else faces
    ids, normals = smooth_normals(positions, np.ascontiguousarray(triangles, np.int32), faces, groups)
    return normals[ids]


@pytest.mark.parametrize("radius", [1e-6, 1.0, 1e9])
@pytest.mark.parametrize("grouped", [False, True])
def test_a_sphere_is_smooth_over_its_seam(radius, grouped):
    positions, triangles = sphere(radius=radius)
    groups = np.full(len(triangles), 7) if grouped else None
    normals = normals_of(positions, triangles, groups)
    cosines = np.einsum("ijk,ijk->ij", normals, positions[triangles] / np.float32(radius))
    assert cosines.min() > 0.999


CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float32)
QUADS = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
CUBE_TRIANGLES = np.concatenate([QUADS[:, [0, 1, 2]], QUADS[:, [0, 2, 3]]])


def test_a_cube_has_edges():
    normals = normals_of(CUBE, CUBE_TRIANGLES)
    assert np.array_equal(np.sort(np.abs(normals), -1), np.broadcast_to([0, 0, 1], normals.shape))
    assert (np.einsum("ijk,ijk->ij", normals, CUBE[CUBE_TRIANGLES]) == 1).all()


def test_weighted_by_angle_a_smooth_cube_points_to_its_corners():
    """However its sides are cut: one right angle a side, in one triangle or in two."""
    normals = normals_of(CUBE, CUBE_TRIANGLES, np.ones(12, np.int64))
    np.testing.assert_allclose(normals, CUBE[CUBE_TRIANGLES] / np.sqrt(3), atol=1e-6)


def test_group_zero_is_flat_by_face():
    faces = np.tile(np.arange(6), 2)
    normals = normals_of(CUBE, CUBE_TRIANGLES, np.zeros(12, np.int64), faces)
    for face in range(6):
        same = normals[faces == face].reshape(-1, 3)
        assert (same == same[0]).all()


def test_faces_back_to_back_have_a_normal_all_the_same():
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
    normals = normals_of(positions, [[0, 1, 2], [0, 2, 1]], np.ones(2, np.int64))
    np.testing.assert_allclose(np.linalg.norm(normals, axis=-1), 1)


def test_triangles_wound_against_their_neighbour_are_not_joined():
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], np.float32)
    normals = normals_of(positions, [[0, 1, 2], [1, 2, 3]])
    assert normals[:, :, 2].tolist() == [[1] * 3, [-1] * 3]


def test_three_triangles_at_one_edge():
    positions = np.array([[0, 0, 0], [0, 0, 1], [1, 0, 0], [-1, 0.1, 0], [0, -1, 0]], np.float32)
    normals = normals_of(positions, [[0, 2, 1], [0, 1, 3], [0, 1, 4]])
    np.testing.assert_allclose(np.linalg.norm(normals, axis=-1), 1, rtol=1e-6)


def test_triangles_that_share_only_a_point_are_not_joined():
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0.2], [0, -1, 0.2]], np.float32)
    normals = normals_of(positions, [[0, 1, 2], [0, 3, 4]])
    assert normals[0].tolist() == [[0, 0, 1]] * 3


def test_unique_rows_against_numpy():
    rows = np.random.default_rng(1).integers(-3, 3, (5000, 3)).astype(np.int32)
    ids, firsts = unique_rows(rows)
    assert (rows[firsts][ids] == rows).all()
    assert len(firsts) == len(np.unique(rows, axis=0))
    assert (np.diff(firsts) > 0).all()
    assert (ids[firsts] == np.arange(len(firsts))).all()


def test_unique_rows_of_nothing():
    ids, firsts = unique_rows(np.empty((0, 3), np.int32))
    assert len(ids) == len(firsts) == 0


def test_weld_knows_one_zero():
    assert weld(np.array([[0.0, 1, 2], [-0.0, 1, 2], [0, 1, 3]], np.float32)).tolist() == [0, 0, 1]
