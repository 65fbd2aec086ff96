"""Mirrors: the recursion (1 - r) * lit + r * mirrored in closed form, and where mirror rays go."""

import numpy as np
import pytest
from pictures import facing, film, normal_texture, picture, pixel, plane, ray_directions, sphere_distance, unit

from glimt import Camera, DirectionalLight, Instance, Material, PointLight, Sphere, linalg

A, B = np.array([0.9, 0.4, 0.1]), np.array([0.2, 0.3, 0.7])


def _facing_mirrors(lit, reflectivity, bounces):
    """Return what is seen in two facing mirrors; the last one shows its own light in full."""
    if bounces == 0:
        return lit[0]
    return (1 - reflectivity[0]) * lit[0] + reflectivity[0] * _facing_mirrors(lit[::-1], reflectivity[::-1],
                                                                              bounces - 1)


@pytest.mark.parametrize("bounces", range(7))
@pytest.mark.parametrize("reflectivity", [(0.5, 0.5), (0.8, 0.3), (1.0, 1.0), (0.7, 0.0), (0.0, 0.7)])
def test_two_facing_mirrors(bounces, reflectivity):
    first = plane(Material(diffuse=A, reflectivity=reflectivity[0]))
    second = Instance(plane(Material(diffuse=B, reflectivity=reflectivity[1])), linalg.translation((0, 0, 2)))
    camera = Camera((0.3, 0.2, 1), (0.3, 0.2, 0), (0, 1, 0))
    seen = pixel(first, second, camera=camera, ambient=1, background=9, max_bounces=bounces)
    np.testing.assert_allclose(seen, _facing_mirrors([A, B], reflectivity, bounces), rtol=1e-5)


@pytest.mark.parametrize("reflectivity", [0.25, 0.5, 1.0])
@pytest.mark.parametrize("bounces", [0, 1, 4])
def test_one_mirror_and_the_background(reflectivity, bounces):
    background = np.array([0.1, 0.5, 3.0])
    light = DirectionalLight(direction=(0, -1, -1))
    seen = pixel(plane(Material(diffuse=A, reflectivity=reflectivity)), light, camera=facing(), background=background,
                 max_bounces=bounces)
    lit = A * np.sqrt(0.5)
    expected = (1 - reflectivity) * lit + reflectivity * background if bounces else lit
    np.testing.assert_allclose(seen, expected, rtol=1e-5)


def test_rays_are_counted_by_kind():
    first = plane(Material(diffuse=A, reflectivity=0.5))
    second = Instance(plane(Material(diffuse=B)), linalg.translation((0, 0, 2)))
    lamp = PointLight(position=(0.1, 0.1, 1))
    counters = film(first, second, lamp, camera=facing(0.5, 0.1), max_bounces=5, size=(4, 4),
                    samples=2).counters
    assert (counters.primary, counters.mirror, counters.shadow) == (64, 64, 128)
    assert counters.rays == 256
    assert counters.non_finite == 0


@pytest.mark.parametrize("turn", [0, 20, 44])
def test_a_turned_mirror_shows_what_lies_there(turn):
    """A mirror turned by an angle turns the line of sight by twice that: through the bull's eye of a target."""
    mirror = Instance(plane(Material(diffuse=0, reflectivity=1)), linalg.rotation((0, 1, 0), turn))
    place = 6 * np.array([np.sin(np.radians(2 * turn)), 0, np.cos(np.radians(2 * turn))])
    target = Sphere(place, 0.01, Material(ambient=A, diffuse=0))
    camera = Camera((0, 0, 3), (0, 0, 0))
    np.testing.assert_allclose(pixel(mirror, target, camera=camera, ambient=1, max_bounces=1), A, rtol=1e-6)
    beside = Sphere(place + [0, 0.02, 0], 0.01, Material(ambient=A, diffuse=0))
    assert not pixel(mirror, beside, camera=camera, ambient=1, max_bounces=1).any()


@pytest.mark.parametrize("tilted", [(0.2, 0, 1), (-0.3, 0.2, 1), (0, 0.55, 1)])
def test_a_normal_map_turns_mirror_rays(tilted):
    texture, ns = normal_texture(tilted)
    mirrored = np.array([0, 0, -1]) + 2 * ns[2] * ns
    assert mirrored[2] > 0.3
    mirror = plane(Material(diffuse=0, reflectivity=1, normal_texture=texture))
    target = Sphere(6 * mirrored, 0.01, Material(ambient=A, diffuse=0))
    seen = pixel(mirror, target, camera=facing(), ambient=1, max_bounces=1)
    np.testing.assert_allclose(seen, A, rtol=1e-6)


def test_mirror_rays_never_go_below_the_surface():
    """A normal that leans by 60° would send the line of sight into the wall: it grazes it instead."""
    texture, ns = normal_texture((np.sqrt(3), 0, 1))
    mirrored = np.array([0, 0, -1]) + 2 * ns[2] * ns
    assert mirrored[2] < -0.4
    grazing = [*mirrored[:2], 1e-3]
    mirror = plane(Material(diffuse=0, reflectivity=1, normal_texture=texture))
    below = Instance(plane(Material(ambient=1), half=90), linalg.translation((0, 0, -1)))
    target = Sphere(np.multiply(90, grazing), 0.02, Material(ambient=B, diffuse=0))
    camera = facing(3, 0.05)
    seen = picture(mirror, below, camera=camera, size=(5, 5), ambient=1, background=A, max_bounces=1)
    np.testing.assert_allclose(seen, np.broadcast_to(A, (5, 5, 3)), rtol=1e-6)
    np.testing.assert_allclose(pixel(mirror, below, target, camera=camera, ambient=1, max_bounces=1), B, rtol=1e-6)


def test_a_mirror_sphere_reflects_by_its_normal():
    """Three lamps in a large sphere say, one per channel, which point of it was met."""
    small, large = 0.01, 10.0
    lamps = 0.5 * np.array([[1, 0.2, 0], [-0.3, 1, 0.1], [-0.5, -0.4, 1]])
    things = [PointLight(position=lamp, diffuse=color, attenuation=(0, 1, 0))
              for lamp, color in zip(lamps, np.eye(3), strict=True)]
    camera = Camera((0.02, 0.01, 0.05), (0, 0, 0), fov_deg=25)
    seen = picture(Sphere((0, 0, 0), small, Material(diffuse=0, reflectivity=1)),
                   Sphere((0, 0, 0), large, Material(diffuse=1)), *things, camera=camera, size=(49, 49), max_bounces=1)

    directions = ray_directions(camera, 49, 49)
    t = sphere_distance(camera.position, directions, (0, 0, 0), small)
    directions, t = directions[~np.isnan(t)], t[~np.isnan(t)]
    points = camera.position + directions * t[:, None]
    mirrored = directions - 2 * (directions * points).sum(-1, keepdims=True) * points / small**2
    met = points + mirrored * sphere_distance(points, mirrored, (0, 0, 0), large)[:, None]
    way = lamps - met[:, None]
    distance = np.linalg.norm(way, axis=-1)
    expected = -(way * met[:, None]).sum(-1) / (large * distance) / distance
    clear = np.linalg.norm(np.cross(-met[:, None], unit(way)), axis=-1) > small * 1.01  # of the small one's shadow
    got = seen[~np.isnan(sphere_distance(camera.position, ray_directions(camera, 49, 49), (0, 0, 0), small))]
    grazing = (directions * points).sum(-1) / small > -0.1
    assert clear.mean() > 0.95
    assert len(got) > 1000
    np.testing.assert_allclose(got[~grazing][clear[~grazing]], expected[~grazing][clear[~grazing]], rtol=2e-3)


def test_a_mirror_shows_shadows():
    mirror = Instance(plane(Material(diffuse=0, reflectivity=1), half=3), linalg.rotation((0, 1, 0), 45))
    wall = Instance(plane(Material(diffuse=1), half=5), linalg.compose(linalg.translation((6, 0, 0)),
                                                                       linalg.rotation((0, 1, 0), -90)))
    ball = Sphere((3, 0, 4.8), 0.5, Material(diffuse=0))
    sun = DirectionalLight(direction=(1, 0, -1))
    camera = Camera((0, 0, 6), (0, 0, 0), fov_deg=30)
    bare = picture(mirror, wall, sun, camera=camera, size=(33, 33), max_bounces=1)
    seen = picture(mirror, wall, ball, sun, camera=camera, size=(33, 33), max_bounces=1)
    np.testing.assert_allclose(bare, np.sqrt(0.5), rtol=1e-5)
    assert set(np.round(np.unique(seen), 4)) == {0.0, 0.7071}
    # The shadow's centre is at (6, 0, 1.8), seen as if from the camera's mirror image, (-6, 0, 0).
    rows, columns = np.nonzero(seen[..., 0] == 0)
    assert rows.mean() == pytest.approx(16, abs=0.01)
    assert columns.mean() == pytest.approx(16 - 16.5 * 1.8 / 12 / np.tan(np.radians(15)), abs=0.3)


def test_the_back_of_a_mirror_reflects_too():
    camera = Camera((0, 0, -3), (0, 0, 0))
    seen = pixel(plane(Material(diffuse=A, reflectivity=0.5)), camera=camera, background=2, ambient=1, max_bounces=1)
    np.testing.assert_allclose(seen, 0.5 * A + 1, rtol=1e-6)


def test_a_closed_hall_of_mirrors_ends():
    seen = film(Sphere((0, 0, 0), 1, Material(diffuse=0.5, reflectivity=1)), camera=Camera((0, 0, 0.5), (0, 0, 0)),
                size=(8, 8), ambient=1, background=50, max_bounces=1000)
    np.testing.assert_allclose(seen.radiance, 0.5, rtol=1e-5)
    assert seen.counters.mirror == 64 * 1000
