"""Polygons of every shape become triangles that cover them once."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from glimt.io import triangulate as module
from glimt.io.triangulate import doubled_areas, triangulate


def cut(*polygons, tilt=True):
    """Return (triangles' signed areas, areas of the polygons) for polygons (n, 2) laid into space."""
    frame = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0]]) if tilt else np.eye(3)[:2]
    flat = [np.asarray(polygon, float) for polygon in polygons]
    points = np.concatenate(flat) @ frame
    starts = np.cumsum([0] + [len(p) for p in flat])
    triangles = triangulate(points.astype(np.float32), starts)
    assert triangles.complete
    assert np.bincount(triangles.faces).tolist() == [len(p) - 2 for p in flat]
    for face, corners in zip(triangles.faces, triangles.corners, strict=True):
        assert starts[face] <= corners.min() <= corners.max() < starts[face + 1]
        assert len(set(corners.tolist())) == 3
    normal = np.cross(frame[0], frame[1])
    signed = doubled_areas(points.astype(np.float32), triangles.corners) @ normal / 2
    areas = [np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) / 2 for x, y in (p.T for p in flat)]
    return signed, np.array(areas)


def assert_covers(polygon, **options):
    """Triangles that add up to the polygon's area with their signs and without cover it exactly once.

    Corners on a line are no longer quite on it in float32, hence the tolerance.
    """
    signed, areas = cut(polygon, **options)
    np.testing.assert_allclose(signed.sum(), areas[0], rtol=1e-5)
    np.testing.assert_allclose(np.abs(signed).sum(), np.abs(areas[0]), rtol=1e-5)


def comb(teeth):
    top = [(x, 5 if x % 2 else 1) for x in range(2 * teeth, -1, -1)]
    return [(0, 0), (2 * teeth, 0), *top]


def spiral(turns):
    angle = np.linspace(0, 2 * np.pi * turns, 20 * turns)
    outside = np.stack([np.cos(angle), np.sin(angle)], 1) * (1 + angle)[:, None]
    inside = np.stack([np.cos(angle), np.sin(angle)], 1) * (0.5 + angle)[:, None]
    return np.concatenate([outside, inside[::-1]])


SHAPES = {
    "triangle": [(0, 0), (1, 0), (0, 1)],
    "square": [(0, 0), (1, 0), (1, 1), (0, 1)],
    "dart": [(0, 0), (2, -1), (1, 0), (2, 1)],
    "dart from its notch": [(1, 0), (2, 1), (0, 0), (2, -1)],
    "L": [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)],
    "corner in the middle of a side": [(0, 0), (1, 0), (2, 0), (2, 2), (0, 2)],
    "sides cut in many": [(i, 0) for i in range(9)] + [(8, 8), (0, 8), (0, 4)],
    "plus": [(1, 0), (2, 0), (2, 1), (3, 1), (3, 2), (2, 2), (2, 3), (1, 3), (1, 2), (0, 2), (0, 1), (1, 1)],
    "hole with a bridge": [(0, 0), (4, 0), (4, 4), (0, 4), (0, 0), (1, 1), (1, 3), (3, 3), (3, 1), (1, 1)],
    "comb": comb(50),
    "spiral": spiral(5),
}


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("tilt", [False, True])
def test_shapes_are_covered_once_from_every_start(name, mirrored, tilt):
    shape = SHAPES[name][::-1] if mirrored else SHAPES[name]
    for start in range(0, len(shape), max(1, len(shape) // 20)):
        assert_covers(np.roll(shape, start, axis=0), tilt=tilt)


@given(st.lists(st.floats(0.05, 1), min_size=3, max_size=40), st.integers(0, 39))
def test_stars_are_covered_once(radii, start):
    angle = np.arange(len(radii)) * 2 * np.pi / len(radii)
    assert_covers(np.roll(np.stack([np.cos(angle), np.sin(angle)], 1) * np.array(radii)[:, None], start, axis=0))


@given(st.lists(st.tuples(st.integers(0, 6), st.integers(0, 6)), min_size=3, max_size=30))
def test_any_polygon_at_all_gives_corners_minus_two_triangles(polygon):
    signed, areas = cut(polygon)
    np.testing.assert_allclose(signed.sum(), areas[0], atol=1e-3)


def test_faces_of_many_sizes_stay_in_order():
    signed, areas = cut(SHAPES["L"], SHAPES["triangle"], SHAPES["dart"], SHAPES["square"], SHAPES["plus"])
    assert (signed > 0).all()
    np.testing.assert_allclose(signed.sum(), areas.sum(), rtol=1e-5)


def test_a_polygon_of_many_corners_is_cut():
    angle = np.linspace(0, 2 * np.pi, 16384, endpoint=False)
    ring = np.stack([np.cos(angle), np.sin(angle)], 1)
    signed, areas = cut(ring * np.where(np.arange(16384) % 2, 1, 0.999)[:, None])
    np.testing.assert_allclose(signed.sum(), areas[0], rtol=1e-3)


def test_beyond_the_budget_polygons_are_still_cut(monkeypatch):
    monkeypatch.setattr(module, "BUDGET", 10)
    points = np.column_stack([SHAPES["spiral"], np.zeros(200)]).astype(np.float32)
    triangles = triangulate(points, np.array([0, 200]))
    assert not triangles.complete
    assert len(triangles.corners) == 198
