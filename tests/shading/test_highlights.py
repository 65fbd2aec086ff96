"""Blinn-Phong highlights: specular * (n·h)^exponent, in closed form."""

from dataclasses import replace

import numpy as np
import pytest
from pictures import direction, facing, picture, pixel, plane, unit

from glimt import Camera, DirectionalLight, Material, PointLight

KS = np.array([0.3, 0.6, 1.0])
LIGHT = np.array([2.0, 1.0, 0.5])


def _tolerance(exponent):
    """Rounding of n·h, and the error of `power`, both grow with the exponent."""
    return 1e-5 + 1e-6 * exponent


@pytest.mark.parametrize("exponent", [1, 2.5, 10, 32, 100, 1000])
@pytest.mark.parametrize("lean", [0, 1, 4, 10, 25])
def test_highlight_on_and_off_the_mirror_angle(exponent, lean):
    # The viewer stands 50° from the normal, the halfway vector leans `lean` from it, sideways.
    wo, halfway = direction(50), direction(lean, 90)
    wi = 2 * (wo @ halfway) * halfway - wo
    square = plane(Material(diffuse=0, specular=KS, exponent=exponent))
    light = DirectionalLight(direction=-wi, diffuse=5, specular=LIGHT)
    seen = pixel(square, light, camera=Camera(3 * wo, (0, 0, 0), (0, 0, 1)))
    np.testing.assert_allclose(seen, KS * LIGHT * np.cos(np.radians(lean))**exponent, rtol=_tolerance(exponent),
                               atol=1e-12)


@pytest.mark.parametrize(("lean", "exponent"), [(25, 1000), (40, 300), (40, 262)])
def test_a_highlight_too_faint_for_a_float32_is_none(lean, exponent):
    """Processors slow down at numbers below 1e-38, which it would be times a colour or two."""
    halfway = direction(lean, 90)
    wi = 2 * halfway[2] * halfway - [0, 0, 1]
    square = plane(Material(diffuse=0, specular=KS, exponent=exponent))
    light = DirectionalLight(direction=-wi, diffuse=0, specular=LIGHT)
    assert np.cos(np.radians(lean)) ** exponent < 1e-30
    assert not pixel(square, light, camera=facing()).any()


def test_exponent_0_shines_wherever_light_falls():
    square = plane(Material(diffuse=0, specular=KS, exponent=0))
    for tilt in (0, 40, 80):
        seen = pixel(square, DirectionalLight(direction=-direction(tilt)), camera=facing())
        np.testing.assert_allclose(seen, KS, rtol=1e-6)


def test_highlights_of_a_point_light_fade_with_distance():
    place = np.array([0.5, 0.5, 2.0])
    halfway = unit(unit(place) + [0, 0, 1])
    square = plane(Material(diffuse=0, specular=KS, exponent=20))
    seen = pixel(square, PointLight(position=place, radius=0.5, attenuation=(0, 0, 1)), camera=facing())
    np.testing.assert_allclose(seen, KS * halfway[2]**20 * 0.25 / (place @ place), rtol=5e-5)


def test_specular_light_is_the_diffuse_light_unless_given():
    square = plane(Material(diffuse=0, specular=1, exponent=1))
    assert pixel(square, DirectionalLight(direction=(0, 0, -1), diffuse=LIGHT), camera=facing()) == pytest.approx(LIGHT)
    assert not pixel(square, DirectionalLight(direction=(0, 0, -1), diffuse=LIGHT, specular=0), camera=facing()).any()


def test_diffuse_and_specular_add_up():
    wi = direction(35, 20)
    square = plane(Material(diffuse=0.4, specular=KS, exponent=12))
    seen = pixel(square, DirectionalLight(direction=-wi, diffuse=LIGHT, specular=3), camera=facing())
    halfway = unit(wi + [0, 0, 1])
    np.testing.assert_allclose(seen, 0.4 * LIGHT * wi[2] + KS * 3 * halfway[2]**12, rtol=3e-5)


def test_matte_and_shining_pixels_side_by_side():
    """Where no pixel of a packet shines there is no highlight to work out; packets on the diagonal have both kinds."""
    matte, shining = (Material(diffuse=0.4, specular=ks, exponent=12) for ks in (0, KS))
    light, pictures = DirectionalLight(direction=-direction(10), diffuse=LIGHT, specular=3), []
    for materials in ([matte, matte], [shining, shining], [matte, shining]):
        square = replace(plane(), materials=materials, material_ids=[0, 1])
        pictures.append(picture(square, light, camera=facing(), size=(16, 16)))
    lower_right = np.tri(16, dtype=bool)[:, ::-1, None]
    assert (pictures[0] < pictures[1]).all()
    np.testing.assert_array_equal(pictures[2], np.where(lower_right, pictures[0], pictures[1]))
