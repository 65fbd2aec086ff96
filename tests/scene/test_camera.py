"""The camera's basis, and framing a box."""

import numpy as np
import pytest

from glimt import Camera, GlimtError


@pytest.mark.parametrize(("position", "target", "up"), [
    ((0, 0, 5), (0, 0, 0), (0, 1, 0)), ((3, 1, -2), (0.5, 9, 4), (0.2, 1, 0.3)), ((0, 0, 0), (0, 1e-9, -1), (0, 1, 0)),
    ((1e12, 0, 0), (0, 1e12, 0), (0, 0, 1e-12)),
])
def test_basis_is_right_handed_and_unit(position, target, up):
    right, upward, look = Camera(position, target, up).basis()
    np.testing.assert_allclose(np.stack([right, upward, look]) @ np.stack([right, upward, look]).T, np.eye(3),
                               atol=1e-12)
    np.testing.assert_allclose(np.cross(right, upward), -look, atol=1e-12)
    np.testing.assert_allclose(np.cross(look, np.subtract(target, position)), 0, atol=1e-3)
    assert upward @ up > 0


def test_default_camera_looks_along_minus_z():
    right, up, look = Camera().basis()
    np.testing.assert_allclose([right, up, look], [[1, 0, 0], [0, 1, 0], [0, 0, -1]], atol=1e-15)


def test_a_camera_moved_to_a_senseless_place_says_so():
    camera = Camera()
    camera.position = camera.target
    with pytest.raises(GlimtError, match="camera: position and target are the same point"):
        camera.basis()


def _projected(camera, points):
    """Return places in the picture, -1 to 1 in height, and depths."""
    right, up, look = camera.basis()
    rays = points - np.asarray(camera.position)
    depth = rays @ look
    reach = np.tan(np.radians(camera.fov_deg) / 2)
    return rays @ right / depth / reach, rays @ up / depth / reach, depth


@pytest.mark.parametrize(("lo", "hi"), [((-1, -1, -1), (1, 1, 1)), ((5, 0, 0), (5.001, 30, 2)), ((0, 0, 0), (9, 0, 9)),
                                        ((-1e6, 0, 0), (1e6, 1, 1)), ((1e-6, 0, 0), (2e-6, 1e-6, 1e-6))])
@pytest.mark.parametrize("aspect", [0.3, 1.0, 2.5])
@pytest.mark.parametrize("fov_deg", [10.0, 40.0, 100.0])
def test_framing_shows_the_whole_box_and_fills_the_picture(lo, hi, aspect, fov_deg):
    camera = Camera.framing(lo, hi, aspect, fov_deg)
    corners = np.stack(np.meshgrid(*zip(lo, hi, strict=True)), -1).reshape(8, 3)
    x, y, depth = _projected(camera, corners)
    assert (depth > 0).all()
    fill = max(np.abs(x).max() / aspect, np.abs(y).max())
    assert 0.9 < fill < 1
    assert camera.fov_deg == fov_deg


def test_framing_a_single_point_looks_at_it():
    camera = Camera.framing((3, 4, 5), (3, 4, 5))
    assert camera.target == (3, 4, 5)
    assert np.linalg.norm(np.subtract(camera.position, camera.target)) > 0.1
