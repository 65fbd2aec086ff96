"""Meshes as plain objects."""

import numpy as np

from glimt import Material, Mesh

CORNERS = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [9, 9, 9]]


def test_arrays_become_the_documented_types():
    mesh = Mesh(CORNERS, [[0, 1, 2]], np.ones((4, 3)), np.zeros((4, 2), np.int64), material_ids=[0])
    assert mesh.positions.dtype == mesh.normals.dtype == mesh.texcoords.dtype == np.float32
    assert mesh.triangles.dtype == mesh.material_ids.dtype == np.int32
    assert mesh.positions.shape == (4, 3)


def test_positions_are_copied():
    positions = np.array(CORNERS, np.float32)
    mesh = Mesh(positions, [[0, 1, 2]])
    positions[:] = 7
    assert mesh.positions[0].tolist() == [0, 0, 0]


def test_every_triangle_has_the_first_material_unless_told():
    assert Mesh(CORNERS, [[0, 1, 2], [0, 2, 1]]).material_ids.tolist() == [0, 0]
    two = Mesh(CORNERS, [[0, 1, 2]], materials=(Material(), Material()), material_ids=np.array([1], np.uint8))
    assert two.material_ids.tolist() == [1]
    assert isinstance(two.materials, list)


def test_bounds_are_those_of_the_triangles():
    lo, hi = Mesh(CORNERS, [[0, 1, 2]]).bounds()
    assert (lo.tolist(), hi.tolist()) == ([0, 0, 0], [1, 1, 0])
    lo, hi = Mesh(CORNERS, np.zeros((0, 3))).bounds()
    assert (lo.tolist(), hi.tolist()) == ([0, 0, 0], [0, 0, 0])


def test_whole_floats_are_vertex_numbers_too():
    assert Mesh(CORNERS, np.array([[0.0, 1.0, 2.0]])).triangles.tolist() == [[0, 1, 2]]


def test_a_mesh_may_be_empty():
    assert len(Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32)).triangles) == 0


def test_bounds_are_found_once():
    """A thousand instances ask for them, and so does every frame without a camera."""
    mesh = Mesh(CORNERS, [[0, 1, 2]])
    assert mesh.bounds() is mesh.bounds()
