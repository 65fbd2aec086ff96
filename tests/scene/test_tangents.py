"""Tangent frames against closed forms and against the definition."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from glimt.linalg import normalize, rotation
from glimt.scene.tangents import tangent_space, vertex_tangents

UP = np.array([0, 0, 1], np.float32)
SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
TWO = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
TEXCOORDS = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], np.float32)  # v grows downwards: the picture stands upright


def flat_normals(count):
    return np.tile(UP, (count, 1))


def bitangents(normals, tangents):
    return tangents[:, 3:] * np.cross(normals, tangents[:, :3])


def test_an_upright_picture():
    space = tangent_space(SQUARE, TWO, flat_normals(4), TEXCOORDS)
    assert space.tangents.tolist() == [[1, 0, 0, 1]] * 4
    assert (space.vertex_ids == np.arange(4)).all()
    assert (space.triangles == TWO).all()
    assert bitangents(flat_normals(4), space.tangents).tolist() == [[0, 1, 0]] * 4  # up in the picture, where v falls
    assert (vertex_tangents(SQUARE, TWO, flat_normals(4), TEXCOORDS) == space.tangents).all()


@pytest.mark.parametrize("angle", [0, 30, 90, 200])
@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("scale", [1e-6, 1, 1e9])
def test_a_turned_picture(angle, mirrored, scale):
    turn = rotation((0, 0, 1), angle)[:2, :2]
    upward = SQUARE[:, :2] @ turn * [-1 if mirrored else 1, 1]  # texcoords with v up
    texcoords = (upward * [1, -1] + [3, 7]).astype(np.float32)
    tangents = tangent_space(SQUARE * np.float32(scale), TWO, flat_normals(4), texcoords).tangents
    u_axis = turn[:, 0] * (-1 if mirrored else 1)
    np.testing.assert_allclose(tangents[:, :2], np.tile(u_axis, (4, 1)), atol=1e-5)
    assert (tangents[:, 3] == (-1 if mirrored else 1)).all()


def test_a_mirrored_seam_is_split():
    """Two squares side by side show one picture, the right one mirrored; they share the two vertices between."""
    positions = np.array([[-1, 0, 0], [0, 0, 0], [1, 0, 0], [-1, 1, 0], [0, 1, 0], [1, 1, 0]], np.float32)
    triangles = np.array([[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]], np.int32)
    texcoords = np.array([[0, 1], [1, 1], [0, 1], [0, 0], [1, 0], [0, 0]], np.float32)
    space = tangent_space(positions, triangles, flat_normals(6), texcoords)
    assert space.vertex_ids.tolist() == [0, 1, 2, 3, 4, 5, 1, 4]
    assert (space.vertex_ids[space.triangles] == triangles).all()
    tangents = space.tangents[space.triangles]
    assert tangents[:2].reshape(-1, 4).tolist() == [[1, 0, 0, 1]] * 6
    assert tangents[2:].reshape(-1, 4).tolist() == [[-1, 0, 0, -1]] * 6
    one_each = vertex_tangents(positions, triangles, flat_normals(6), texcoords)
    assert np.abs(one_each[:, 0]).tolist() == [1] * 6
    assert one_each[:, 3].tolist() == [1, one_each[1, 3], -1, 1, one_each[4, 3], -1]


def test_triangles_wound_against_their_normals():
    space = tangent_space(SQUARE, TWO[:, ::-1], flat_normals(4), TEXCOORDS)
    assert space.tangents.tolist() == [[1, 0, 0, 1]] * 4


def test_texcoords_without_area_take_the_neighbours_frame():
    texcoords = TEXCOORDS.copy()
    texcoords[3] = texcoords[0]  # the second triangle has a line for a picture
    space = tangent_space(SQUARE, TWO, flat_normals(4), texcoords)
    assert space.tangents[:3].tolist() == [[1, 0, 0, 1]] * 3
    assert len(space.vertex_ids) == 4
    assert np.dot(space.tangents[3, :3], UP) == 0
    mirrored = tangent_space(SQUARE, TWO, flat_normals(4), texcoords * np.float32([-1, 1]))
    assert mirrored.tangents[:3].tolist() == [[-1, 0, 0, -1]] * 3


def test_corners_count_by_their_angle():
    """At the tip of a fan of a right angle and one of 45 degrees, whose pictures are at right angles."""
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 1, 0]], np.float32)
    triangles = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    # u runs along x in the first; in the second, which agrees on their edge, along x - y
    texcoords = np.array([[0, 0], [1, 0], [0, -1], [-1.5, -1]], np.float32)
    tangent = tangent_space(positions, triangles, flat_normals(4), texcoords).tangents[0, :3]
    gradient = np.array([1.5, 0, 0])  # du per x in the second triangle: dP/du = x / 1.5, the same direction
    np.testing.assert_allclose(tangent, normalize(gradient), atol=1e-6)
    texcoords = np.array([[0, 0], [1, 0], [0, -1], [-1, -2]], np.float32)
    tangent = tangent_space(positions, triangles, flat_normals(4), texcoords).tangents[0, :3]
    second = normalize([1, 1, 0])  # u = x, v up = y - x: where v stays, x and y grow alike
    np.testing.assert_allclose(tangent, normalize(np.array([1, 0, 0]) * np.pi / 2 + second * np.pi / 4), atol=1e-6)


def test_a_cylinder():
    """Around a cylinder the tangent is the direction around it, although the triangles are flat."""
    angle = np.linspace(0, 2 * np.pi, 65)
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros(65)], 1)
    positions = np.concatenate([ring, ring + UP]).astype(np.float32)
    texcoords = np.concatenate([np.stack([angle, np.ones(65)], 1), np.stack([angle, np.zeros(65)], 1)])
    i = np.arange(64)
    triangles = np.concatenate([np.stack([i, i + 1, i + 66], 1), np.stack([i, i + 66, i + 65], 1)]).astype(np.int32)
    normals = np.concatenate([ring, ring]).astype(np.float32)
    space = tangent_space(positions, triangles, normals, texcoords.astype(np.float32))
    around = np.stack([-np.sin(angle), np.cos(angle), np.zeros(65)], 1)
    np.testing.assert_allclose(space.tangents[:, :3], np.concatenate([around, around]), atol=2e-2)
    np.testing.assert_allclose(bitangents(normals, space.tangents), np.tile(UP, (130, 1)), atol=2e-2)


# grid values, so that degenerate triangles and texcoords come often
value = st.integers(-2, 2)


@st.composite
def meshes(draw):
    count = draw(st.integers(3, 12))
    arrays = [draw(st.lists(st.tuples(*[value] * width), min_size=count, max_size=count)) for width in (3, 3, 2)]
    corner = st.integers(0, count - 1)
    triangles = draw(st.lists(st.tuples(corner, corner, corner), max_size=20))
    positions, normals, texcoords = (np.array(a, np.float32) for a in arrays)
    return positions, np.array(triangles, np.int32).reshape(-1, 3), normals, texcoords


@given(meshes(), st.sampled_from([1e-15, 1.0, 1e15]))
def test_frames_are_orthonormal_whatever_the_mesh(mesh, scale):
    positions, triangles, normals, texcoords = mesh
    positions, texcoords = positions * np.float32(scale), texcoords * np.float32(scale)
    space = tangent_space(positions, triangles, normals, texcoords)
    assert (space.vertex_ids[space.triangles] == triangles).all()
    assert (space.vertex_ids[:len(positions)] == np.arange(len(positions))).all()
    for tangents, ids in ((space.tangents, space.vertex_ids),
                          (vertex_tangents(positions, triangles, normals, texcoords), np.arange(len(positions)))):
        np.testing.assert_allclose(np.linalg.norm(tangents[:, :3], axis=1), 1, rtol=1e-5)
        assert np.isin(tangents[:, 3], (-1, 1)).all()
        along = np.einsum("ij,ij->i", normalize(normals[ids]), tangents[:, :3].astype(float))
        assert np.abs(along).max() < 1e-5
    for index, triangle in enumerate(space.triangles):
        assert_fits_texture(positions[triangles[index]], texcoords[triangles[index]], normals[triangles[index]],
                            space.tangents[triangle, 3])


def assert_fits_texture(points, texcoords, normals, signs):
    """Check w of a triangle whose normals agree with either of its sides against cross(dP/du, dP/dv up)."""
    points = points.astype(float)
    geometric = np.cross(points[1] - points[0], points[2] - points[0])
    sides = normals.astype(float) @ geometric
    (u1, v1), (u2, v2) = (texcoords[1:] - texcoords[0]).astype(float) * [1, -1]
    area = u1 * v2 - u2 * v1
    if area != 0 and ((sides > 0).all() or (sides < 0).all()):
        assert (signs == np.sign(area) * np.sign(sides[0])).all()


def test_no_triangles():
    space = tangent_space(SQUARE, np.empty((0, 3), np.int32), flat_normals(4), TEXCOORDS)
    assert len(space.tangents) == 4
