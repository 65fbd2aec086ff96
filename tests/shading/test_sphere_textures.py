"""Textures and normal maps on spheres: which way round they go."""

import numpy as np
import pytest
from pictures import film, normal_texture, picture, ray_directions, sphere_distance, stored_color, terminator, unit

from glimt import Camera, DirectionalLight, Material, Sphere, Texture

SIZE = (33, 33)
CENTER, RADIUS = np.array([3.0, -1.0, 2.0]), 1.5


def _camera(side):
    return Camera(CENTER + 8 * unit(side), CENTER, (0, 1, 0), 24)


def _points(camera):
    """Return unit normals of the sphere as seen, (n, 3), and which pixels they belong to."""
    directions = ray_directions(camera, *SIZE)
    t = sphere_distance(camera.position, directions, CENTER, RADIUS)
    points = camera.position + directions * t[..., None]
    on_sphere = ~np.isnan(t)
    return (points[on_sphere] - CENTER) / RADIUS, on_sphere


def _texcoords(normals):
    """Return (u, v): u around +Y from -X through +Z, v from the north pole."""
    turn = np.arctan2(normals[:, 2], -normals[:, 0]) / (2 * np.pi)
    return turn % 1, np.arccos(normals[:, 1]) / np.pi


@pytest.mark.parametrize("side", [(0, 0, 1), (1, 0.4, 0.2), (-1, -0.5, 0.1), (0.2, 0.9, -1)])
def test_texcoords_go_around_as_documented(side):
    width, height = 256, 128
    u, v = (np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height
    pixels = np.zeros((height, width, 3), np.float32)
    pixels[..., 0], pixels[..., 1] = np.abs(2 * u - 1), v[:, None]
    pixels[..., 2] = (u > 0.5) * 1.0
    camera = _camera(side)
    ball = Sphere(CENTER, RADIUS, Material(diffuse=1, diffuse_texture=Texture(pixels, "linear")))
    seen = picture(ball, camera=camera, size=SIZE, ambient=1)
    normals, on_sphere = _points(camera)
    got, (u, v) = seen[on_sphere], _texcoords(normals)
    plain = (np.abs(normals[:, 1]) < 0.9) & (np.minimum(np.abs(u - 0.5), np.minimum(u, 1 - u)) > 0.02)
    assert plain.sum() > 300
    np.testing.assert_allclose(got[plain, 0], np.abs(2 * u - 1)[plain], atol=0.01)
    np.testing.assert_allclose(got[plain, 1], v[plain], atol=0.01)
    np.testing.assert_allclose(got[plain, 2], (u > 0.5)[plain], atol=1e-6)


def test_text_is_not_mirrored_as_seen_from_outside():
    """From +Z the first quarter of the texture stands left of the second one, its top on top."""
    pixels = np.zeros((32, 64, 3), np.float32)
    pixels[:, :16, 0], pixels[:, 16:32, 1], pixels[:16, :, 2] = 1, 1, 1
    ball = Sphere(CENTER, RADIUS, Material(diffuse=1, diffuse_texture=Texture(pixels, "linear")))
    seen = picture(ball, camera=_camera((0, 0, 1)), size=SIZE, ambient=1)
    for row, column, color in ((8, 8, (1, 0, 1)), (8, 24, (0, 1, 1)), (24, 8, (1, 0, 0)), (24, 24, (0, 1, 0))):
        np.testing.assert_allclose(seen[row, column], color, atol=1e-6)


@pytest.mark.parametrize("tilted", [(0.5, 0, 1), (0, 0.5, 1), (-0.4, 0.3, 1)])
@pytest.mark.parametrize("side", [(0, 0, 1), (1, 0.3, 0.2), (-1, 0.2, -1)])
def test_normal_map_on_a_sphere(tilted, side):
    """+X of the map points east, the way u grows; +Y north."""
    texture, kept = normal_texture(tilted)
    camera = _camera(side)
    wi = unit(np.asarray(side, np.float64) + [0.3, 0.5, 0.2])
    seen = picture(Sphere(CENTER, RADIUS, Material(diffuse=1, normal_texture=texture)),
                   DirectionalLight(direction=-wi), camera=camera, size=SIZE)[..., 0]
    normals, on_sphere = _points(camera)
    wo = -ray_directions(camera, *SIZE)[on_sphere]
    checked = 0
    for normal, back, got in zip(normals, wo, seen[on_sphere], strict=True):
        east = unit(np.cross([0, 1, 0], normal))
        ns = unit(east * kept[0] + np.cross(normal, east) * kept[1] + normal * kept[2])
        if abs(normal[1]) < 0.95 and ns @ back > 0.03 and ns @ wi > 0.05 and normal @ wi > 0.02:
            assert got == pytest.approx(ns @ wi * terminator(normal, ns, wi), rel=1e-3)
            checked += 1
    assert checked > 200


def test_poles_and_seam_are_whole():
    texture, _ = normal_texture((0.3, 0.2, 1))
    colors = Texture(np.full((8, 16, 3), 0.5, np.float32), "linear")
    ball = Sphere(CENTER, RADIUS, Material(diffuse=1, diffuse_texture=colors, normal_texture=texture))
    for side in ((1e-4, 1, 0), (1e-4, -1, 0), (-1, 0, 0)):
        camera = Camera(CENTER + 8 * np.array(side), CENTER, (0, 0, 1), 24)
        seen = film(ball, DirectionalLight(direction=-np.array(side)), camera=camera, size=SIZE, ambient=0.125)
        assert seen.counters.non_finite == 0
        assert (seen.radiance[_points(camera)[1]] >= stored_color(0.5) * 0.125 * 0.999).all()


def test_inside_of_a_sphere_shows_the_texture_too():
    pixels = np.zeros((1, 4, 3), np.float32)
    pixels[0, 1] = 1  # around +Z
    room = Sphere(CENTER, RADIUS, Material(diffuse=1, diffuse_texture=Texture(pixels, "linear")))
    for side, expected in (((0, 0, 1), 0.5), ((0, 0, -1), 0.0)):
        seen = picture(room, camera=Camera(CENTER, CENTER + side, (0, 1, 0)), size=(1, 1), ambient=1)[0, 0]
        assert seen == pytest.approx([expected] * 3, abs=2e-3)
