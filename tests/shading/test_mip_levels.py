"""Levels of detail: a checkered floor that goes grey in the distance, without shimmer, and stays sharp near by."""

import numpy as np
import pytest
from pictures import facing, picture, placed, plane, plane_points, ray_directions

from glimt import Camera, Instance, Material, Sphere, Texture, linalg

SIZE = (96, 96)
CHECKERS = np.kron([[1.0, 0.0], [0.0, 1.0]], np.ones((32, 32)))


def _texture(checkers=CHECKERS):
    return Texture(np.repeat(checkers[..., None], 3, 2).astype(np.float32), "linear")


def _floor_camera(shift=0.0):
    """Return a camera one unit above the floor, with the horizon at about a quarter of the picture."""
    return Camera((0.3 + shift, 0, 1), (0.3 + shift, 10, -1.5), (0, 0, 1), 40)


def _floor(camera, texture):
    """Return a picture of a floor that goes on to the horizon, one texture per unit."""
    half = 5000.0
    texcoords = np.array([[-half, half], [half, half], [half, -half], [-half, -half]])
    return picture(plane(Material(diffuse=1, diffuse_texture=texture), half, texcoords=texcoords), camera=camera,
                   size=SIZE, ambient=1, background=0.5)[..., 0]


def _distance(camera):
    directions = ray_directions(camera, *SIZE)
    return np.where(directions[..., 2] < 0, -camera.position[2] / np.minimum(directions[..., 2], -1e-9), np.inf)


def _point_sampled(camera):
    """Return the picture as it would be from the top level alone."""
    points = np.asarray(camera.position) + ray_directions(camera, *SIZE) * _distance(camera)[..., None].clip(0, 1e6)
    return 1.0 * ((np.floor(2 * points[..., 0]) + np.floor(-2 * points[..., 1])) % 2 == 0)


def test_distant_checkers_go_to_their_mean():
    seen, distance = _floor(_floor_camera(), _texture()), _distance(_floor_camera())
    for near, far, contrast in ((60, 4000, 0.02), (30, 60, 0.2)):
        ring = (distance > near) & (distance < far)
        assert ring.sum() > 150
        assert np.abs(seen[ring] - 0.5).max() < contrast
        assert seen[ring].mean() == pytest.approx(0.5, abs=contrast / 4)


def test_near_checkers_stay_sharp():
    camera = _floor_camera()
    seen, near = _floor(camera, _texture()), _distance(camera) < 4
    assert near.sum() > 2000
    crisp = np.minimum(seen[near], 1 - seen[near]) < 0.01
    assert crisp.mean() > 0.75
    agree = np.abs(seen - _point_sampled(camera))[near] < 0.5
    assert agree.mean() > 0.97


def test_a_small_step_of_the_camera_changes_distant_pixels_little():
    here, there = _floor_camera(), _floor_camera(0.23)
    far = (_distance(here) > 20) & (_distance(here) < 4000)
    assert far.sum() > 500
    change = np.abs(_floor(here, _texture()) - _floor(there, _texture()))[far]
    without = np.abs(_point_sampled(here) - _point_sampled(there))[far]
    assert without.mean() > 0.3
    assert change.mean() < 0.1 * without.mean()
    assert np.var(_floor(here, _texture())[far]) < 0.05 * np.var(_point_sampled(here)[far])


@pytest.mark.parametrize("magnification", [1.01, 4, 30])
def test_magnified_textures_are_read_from_the_top_level(magnification):
    """A pixel that is smaller than a texel sees no other level: stripes of one texel keep their contrast."""
    stripes = np.tile([[1.0, 0.0]], (64, 32))
    half = 64 / 2 / magnification / 64
    seen = picture(plane(Material(diffuse=1, diffuse_texture=_texture(stripes)), half=0.5),
                   camera=facing(200, half), size=(64, 64), ambient=1)[..., 0]
    x = plane_points(facing(200, half), 64, 64)[..., 0]
    phase = ((x + 0.5) * 32) % 1
    expected = np.interp(phase, [0, 0.25, 0.75, 1], [0.5, 1, 0, 0.5])
    np.testing.assert_allclose(seen, expected, atol=2e-4)


@pytest.mark.parametrize(("minification", "lo", "hi"), [(2, 0.5, 0.5), (1.4, 0.4, 0.62), (8, 0.5, 0.5)])
def test_minified_stripes_lose_their_contrast(minification, lo, hi):
    stripes = np.tile([[1.0, 0.0]], (64, 32))
    half = minification / 2
    seen = picture(plane(Material(diffuse=1, diffuse_texture=_texture(stripes)), half=4,
                         texcoords=[[0, 8], [8, 8], [8, 0], [0, 0]]),
                   camera=facing(200, half, x=1 / 256), size=(64, 64), ambient=1)[..., 0]
    assert lo - 1e-3 - 0.5 * (minification < 2) < seen.min()
    assert seen.max() < hi + 1e-3 + 0.5 * (minification < 2)
    assert seen.mean() == pytest.approx(0.5, abs=0.03)


def test_an_instance_twice_as_large_has_texels_twice_as_large():
    """Level selection looks at the placed triangle."""
    stripes = Material(diffuse=1, diffuse_texture=_texture(np.tile([[1.0, 0.0]], (64, 32))))
    small = picture(placed(plane(stripes, half=2), np.eye(3)), camera=facing(200, 1), size=(64, 64), ambient=1)
    same = picture(placed(plane(stripes, half=0.5), 4 * np.eye(3)), camera=facing(200, 1), size=(64, 64), ambient=1)
    np.testing.assert_allclose(small, same, atol=1e-4)


def test_supersampling_takes_finer_levels():
    stripes = Material(diffuse=1, diffuse_texture=_texture(np.tile([[1.0, 0.0]], (64, 32))))
    grey = picture(plane(stripes), camera=facing(200, 1), size=(32, 32), ambient=1)[..., 0]
    sharp = picture(plane(stripes), camera=facing(200, 1), size=(32, 32), ambient=1, samples=4)[..., 0]
    assert np.ptp(grey) < 0.01
    np.testing.assert_allclose(sharp, 0.5, atol=0.01)
    one = picture(plane(stripes), camera=facing(200, 1 / 32), size=(1, 1), ambient=1, samples=4)
    assert one[0, 0, 0] == pytest.approx(0.5, abs=0.01)


def test_mirrors_widen_the_cone_with_the_length_of_the_path():
    """A checkered wall seen in a flat mirror is as blurred as one at the same distance."""
    wall = placed(plane(Material(diffuse=1, diffuse_texture=_texture(np.kron(np.eye(2), np.ones((2, 2))))), half=6,
                        texcoords=[[0, 24], [24, 24], [24, 0], [0, 0]]), np.diag([1, 1, -1]))
    direct = picture(wall, camera=Camera((0.1, 0.2, 20), (0.1, 0.2, 0), fov_deg=25), size=(48, 48), ambient=1)
    mirror = Instance(plane(Material(diffuse=0, reflectivity=1), half=9), linalg.translation((0, 0, 10)))
    mirrored = picture(wall, mirror, camera=Camera((0.1, 0.2, 0.001), (0.1, 0.2, 10), fov_deg=25), size=(48, 48),
                       ambient=1, max_bounces=1)
    np.testing.assert_allclose(mirrored[:, ::-1], direct, atol=2e-3)
    assert np.ptp(direct) > 0.2


def test_levels_of_a_sphere_go_by_its_size():
    checkers = np.kron(np.indices((32, 64)).sum(0) % 2, np.ones((4, 4)))
    material = Material(diffuse=1, diffuse_texture=_texture(checkers))
    camera = Camera((3, 0, 0), (0, 0, 0), fov_deg=45)
    near = picture(Sphere((0, 0, 0), 1, material), camera=camera, size=(96, 96), ambient=1)[40:56, 40:56, 0]
    assert np.ptp(near) > 0.9
    far = picture(Sphere((0, 0, 0), 1, material), camera=Camera((300, 0, 0), (0, 0, 0), fov_deg=0.45), size=(12, 12),
                  ambient=1)[3:9, 3:9, 0]
    assert np.abs(far - 0.5).max() < 0.1
