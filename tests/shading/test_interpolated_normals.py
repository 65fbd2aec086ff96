"""Normals of instances: the inverse transpose against an ellipsoid's analytic normals."""

import functools

import numpy as np
import pytest
from pictures import direction, picture, plane, ray_directions, sphere_distance, unit

from glimt import Camera, DirectionalLight, Instance, Material, Mesh, linalg

SIZE = (48, 48)


@functools.cache
def _ball(rows=128, columns=256, inside_out=False):
    """Return a tessellated unit sphere with its analytic normals."""
    polar, around = np.meshgrid(np.linspace(0, np.pi, rows + 1), np.linspace(0, 2 * np.pi, columns + 1), indexing="ij")
    points = np.stack([np.sin(polar) * np.cos(around), np.cos(polar), np.sin(polar) * np.sin(around)], -1)
    points = points.reshape(-1, 3)
    corner = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    below = corner + columns + 1
    triangles = np.concatenate([np.column_stack([corner, corner + 1, below]),
                                np.column_stack([corner + 1, below + 1, below])])
    if inside_out:
        triangles = triangles[:, ::-1]
    return Mesh(points, triangles, 7 * points, materials=[Material(diffuse=1)])


def _seen_and_expected(mesh, matrix):
    camera = Camera((0, 0, 12), (0, 0, 0), fov_deg=30)
    wi = direction(30, 60)
    seen = picture(Instance(mesh, matrix), DirectionalLight(direction=-wi), camera=camera, size=SIZE)[..., 0]
    inverse = linalg.inverse(matrix)
    origin = linalg.transform_points(inverse, camera.position)
    directions = linalg.transform_vectors(inverse, ray_directions(camera, *SIZE))
    t = sphere_distance(origin, unit(directions), (0, 0, 0), 1)
    points = origin + unit(directions) * t[..., None]
    normals = unit(points @ inverse[:, :3])
    cosine = normals @ wi
    facing = -(normals * ray_directions(camera, *SIZE)).sum(-1)
    clear = (cosine > 0.2) & (facing > 0.3)  # chords hide a silhouette by more than they tilt a normal
    assert clear.sum() > 100
    return seen[clear], cosine[clear]


@pytest.mark.parametrize("inside_out", [False, True])
@pytest.mark.parametrize("matrix", [
    linalg.identity(), linalg.scaling((2.5, 0.7, 1)), linalg.scaling((0.8, 2, -1.5)),
    linalg.compose(linalg.rotation((1, 1, 0), 40), linalg.scaling((2.5, 0.6, 1))),
    linalg.compose(linalg.scaling((1.8, 1, 0.5)), linalg.rotation((0, 1, 1), 30), linalg.scaling((1, 1.5, 0.8))),
])
def test_normals_of_an_ellipsoid(matrix, inside_out):
    """Whatever the winding: normals say where the outside is, and the viewer's side is the one lit."""
    seen, expected = _seen_and_expected(_ball(inside_out=inside_out), matrix)
    np.testing.assert_allclose(seen, expected, atol=4e-3)
    assert np.abs(seen - expected).mean() < 4e-4


@pytest.mark.parametrize("scale", [(1, 1, 1), (4, 1, 0.5), (-2, 1, 3)])
def test_normals_are_interpolated_before_they_are_placed(scale):
    """One triangle pair with a normal per corner, float64 interpolation as the reference."""
    square = plane(Material(diffuse=1))
    normals = unit([[-0.3, -0.2, 1], [0.4, -0.1, 1], [0.2, 0.5, 1], [0, 0.1, 1]])
    mesh = Mesh(square.positions, square.triangles, normals * [[1], [5], [0.1], [3]], materials=square.materials)
    camera = Camera((0, 0, 60), (0, 0, 0), fov_deg=1)
    wi = direction(10, 45)
    seen = picture(Instance(mesh, linalg.scaling(scale)), DirectionalLight(direction=-wi), camera=camera,
                   size=(16, 16))[..., 0]
    directions = ray_directions(camera, 16, 16)
    points = (np.array([0, 0, 60]) - directions * (60 / directions[..., 2:])) / scale
    x, y = points[..., 0], points[..., 1]
    # Barycentrics of (0, 1, 2) where x >= y, else of (0, 2, 3).
    right = np.stack([(1 - x) / 2, (x - y) / 2, (y + 1) / 2], -1) @ normals[[0, 1, 2]]
    left = np.stack([(1 - y) / 2, (x + 1) / 2, (y - x) / 2], -1) @ normals[[0, 2, 3]]
    ns = unit(np.where((x >= y)[..., None], right, left) / scale)
    cosine, g = ns @ wi, wi[2] / (ns @ wi * ns[..., 2])
    expected = cosine * np.where(g < 1, g + g * g - g**3, 1)
    np.testing.assert_allclose(seen, expected, rtol=2e-5)
