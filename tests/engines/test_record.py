"""The rays of a frame, written down: those that the engine counts, and no others."""

from dataclasses import replace

import numpy as np
import pytest

import closed_meshes
import glimt
import tracing
from glimt import linalg
from glimt.engines.cpu.record import record_rays
from glimt.packed import pack, pack_view

COLORS = [(0.25, 0.5, 0.75), (0.5, 0.125, 0.0), (0.75, 0.25, 1.0), (0.125, 1.0, 0.25)]
BACKGROUND = (0.0625, 0.03125, 0.015625)
NEAR = 1e-4
"""How far from its surface a ray may start."""


@pytest.fixture(scope="module", params=[(67, 45, 1, 3), (24, 40, 2, 0), (1, 1, 3, 5)], ids=str)
def scene(request):
    """A mesh, an instance that is turned and stretched, a mirror and a ball; a light of each kind."""
    width, height, samples, bounces = request.param
    floor, ball, mirror, half = (glimt.Material(ambient=color, reflectivity=share)
                                 for color, share in zip(COLORS, (0, 0.25, 1, 0.5), strict=True))
    plane = glimt.Mesh([[-3, -1, -3], [3, -1, -3], [3, -1, 3], [-3, -1, 3]], [[0, 2, 1], [0, 3, 2]],
                       materials=[floor])
    matrix = linalg.compose(linalg.translation((1, 0, 0)), linalg.rotation((1, 2, 3), 40),
                            linalg.scaling((0.9, 0.4, 0.9)))
    scene = glimt.Scene(settings=glimt.RenderSettings(width, height, samples, bounces, BACKGROUND, ambient=1.0))
    scene.add(plane, glimt.Instance(closed_meshes.icosphere(3), matrix, ball), glimt.Sphere((-1, 0, 0), 0.8, mirror),
              glimt.Sphere((0, 0.2, -1.5), 0.7, half))
    scene.add(glimt.PointLight(position=(1, 4, 2), radius=5), glimt.DirectionalLight(direction=(1, -2, -0.5)),
              glimt.SpotLight(position=(-1, 3, 1), direction=(0.2, -1, -0.2), radius=5))
    scene.camera = glimt.Camera((0.5, 1, 4), (0, 0, 0), fov_deg=50)
    return scene


def record(scene):
    settings = scene.settings
    view = pack_view(scene.camera, settings, scene.lights)
    return record_rays(pack(scene), len(scene.lights), view, (settings.width, settings.height), settings.samples,
                       settings.max_bounces)


@pytest.fixture(scope="module")
def rays(scene):
    return record(scene)


def pixels(scene, directions):
    """Return where the camera's rays cross a picture with a place for each sample, in samples: (n, 2) float64."""
    basis, settings = scene.camera.basis(), scene.settings
    x, y, depth = (directions.T.astype(np.float64) @ np.stack(basis).T).T
    half = settings.height * settings.samples / 2
    scale = half / np.tan(np.radians(scene.camera.fov_deg) / 2)
    return np.stack([settings.width * settings.samples / 2 + x / depth * scale, half - y / depth * scale], 1)


def test_as_many_rays_as_the_engine_counts(scene, rays):
    counters = glimt.Renderer(scene).render().counters
    assert {kind: recorded.shape for kind, recorded in rays.items()} == {
        kind: (7, getattr(counters, kind)) for kind in ("primary", "shadow", "mirror")}
    assert rays["mirror"].shape[1] > 0 or scene.settings.max_bounces == 0


def test_primary_rays_are_those_of_the_camera(scene, rays):
    primary, settings = rays["primary"], scene.settings
    assert (primary[:3] == np.float32(scene.camera.position)[:, None]).all()
    assert (primary[6] == np.inf).all()
    np.testing.assert_allclose(np.linalg.norm(primary[3:6], axis=0), 1, atol=1e-6)
    at = pixels(scene, primary[3:6])
    np.testing.assert_allclose(at % 1, 0.5, atol=1e-3)
    columns, rows = np.floor(at).astype(int).T
    expected = np.mgrid[:settings.height * settings.samples, :settings.width * settings.samples].reshape(2, -1)
    order = np.lexsort((columns, rows))
    np.testing.assert_array_equal([rows[order], columns[order]], expected)


def surface_points(scene, rays):
    """Return what the recorded primary and mirror rays hit."""
    points = []
    for kind in ("primary", "mirror"):
        origins, directions = rays[kind][:3].T, rays[kind][3:6].T
        hits = tracing.closest(pack(scene), origins, directions)
        found = hits.inst >= 0
        points.append(origins[found] + hits.t[found, None] * directions[found])
    return np.concatenate(points)


def farthest_from(points, starts):
    """Return how far that start is from all points which is the farthest from any."""
    worst = 0.0
    for some in np.array_split(starts.astype(np.float64), len(starts) // 500 + 1):
        squared = ((some[:, None] - points) ** 2).sum(2)
        worst = max(worst, np.sqrt(squared.min(1)).max(initial=0))
    return worst


@pytest.mark.parametrize("kind", ["shadow", "mirror"])
def test_other_rays_start_where_a_ray_has_hit_something(scene, rays, kind):
    points = surface_points(scene, rays)
    assert len(points) > 0
    assert farthest_from(points, rays[kind][:3].T) < NEAR


def test_shadow_rays_end_at_their_light(scene, rays):
    starts, directions, ends = rays["shadow"][:3].T, rays["shadow"][3:6].T, rays["shadow"][6]
    endless = ends == np.inf
    sun = np.float32(scene.lights[1].direction) / np.linalg.norm(scene.lights[1].direction)
    np.testing.assert_allclose(directions[endless], np.broadcast_to(-sun, directions[endless].shape), atol=1e-6)
    lamps = np.array([scene.lights[0].position, scene.lights[2].position])
    reached = (starts + directions)[~endless]
    assert (np.linalg.norm(reached[:, None] - lamps, axis=2).min(1) < 1e-5).all()
    assert ((ends[~endless] > 0.999) & (ends[~endless] < 1)).all()
    assert endless.any()
    assert not endless.all()


def test_recorded_rays_see_what_the_film_has_seen(scene):
    """With no light but that from everywhere, and no mirrors, a pixel's colour tells what its rays have met."""
    settings = replace(scene.settings, max_bounces=0)
    plain = replace(scene, lights=[], settings=settings)
    radiance = glimt.Renderer(plain).render().radiance
    rays = record(plain)
    assert rays["shadow"].shape == rays["mirror"].shape == (7, 0)
    hits = tracing.closest(pack(plain), np.float32(scene.camera.position), rays["primary"][3:6].T)
    seen = np.array([*COLORS, BACKGROUND])[hits.inst]  # the last for a miss, which is -1
    columns, rows = np.floor(pixels(plain, rays["primary"][3:6]) / settings.samples).astype(int).T
    expected = np.zeros(radiance.shape)
    np.add.at(expected, (rows, columns), seen)
    np.testing.assert_allclose(radiance, expected / settings.samples**2, rtol=1e-6)
