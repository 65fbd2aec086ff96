"""The ray benchmark: its rays, its answers against Embree, its files."""

import numpy as np
import pytest

pytest.importorskip("embreex", reason="Embree, the yardstick, is not installed")

from glimt import Mesh
from glimt.bench import rays, tables
from glimt.packed import pack
from glimt.scene.scene import Scene


def bumpy_ball(rings: int = 40) -> Mesh:
    """A closed mesh of about 2 rings² triangles."""
    latitude, longitude = np.linspace(0, np.pi, rings + 1)[1:-1], np.linspace(0, 2 * np.pi, 2 * rings, endpoint=False)
    around, up = np.meshgrid(longitude, latitude)
    radius = 1 + 0.1 * np.sin(7 * around) * np.sin(5 * up)
    side = radius * np.sin(up)
    ring = np.stack([side * np.cos(around), radius * np.cos(up), side * np.sin(around)], -1)
    rows, columns = ring.shape[:2]
    i = np.arange(rows - 1)[:, None] * columns + np.arange(columns)
    j = np.arange(rows - 1)[:, None] * columns + (np.arange(columns) + 1) % columns
    quads = np.concatenate([np.stack([i, j, i + columns], -1), np.stack([j, j + columns, i + columns], -1)])
    return Mesh(ring.reshape(-1, 3), quads.reshape(-1, 3), name="ball")


@pytest.fixture(scope="module")
def result():
    return rays.report(rays.measure_mesh(bumpy_ball(), size=64, threads=(1, 2), rounds=1))


def test_every_kind_is_measured_and_agrees_with_embree(result):
    kinds = [(row["kind"], row["threads"]) for row in result["rows"]]
    assert kinds == [(kind, threads) for kind in ("primary", "shadow", "mirror", "incoherent") for threads in (1, 2)]
    for row in result["rows"]:
        assert row["differing"] * row["rays"] <= 2e6  # two rays: edges
        best = max(rate for name, rate in row["mrays"].items() if not name.startswith("glimt"))
        assert row["ratio"] == row["mrays"]["glimt"] / best


def test_ray_sets_are_what_they_say():
    mesh = bumpy_ball()
    packed = pack(Scene().add(mesh))
    sets = {ray_set.kind: ray_set for ray_set in rays.ray_sets(mesh, packed, 64)}
    primary = sets["primary"].rays
    assert primary.shape == (7, 64 * 64)
    np.testing.assert_allclose(np.linalg.norm(primary[3:6], axis=0), 1, atol=1e-6)
    assert (primary[:3] == primary[:3, :1]).all()
    assert len(np.unique(primary[3:6].T, axis=0)) == 64 * 64  # every pixel once
    assert 0 < sets["mirror"].rays.shape[1] <= 64 * 64
    for ray_set in sets.values():
        assert ray_set.rays.shape[1] % 16 == 0
        assert (ray_set.rays[6] == (1 if ray_set.occlusion else np.inf)).all()


def test_the_table_has_every_row(result):
    assert tables.table(result).count("| ball") == 8
