"""Spot cones, attenuation and moving lights, in closed form."""

import numpy as np
import pytest
from pictures import direction, facing, picture, pixel, plane, plane_points, unit

from glimt import DirectionalLight, Material, Orbit, Path, PointLight, SpotLight

WHITE = Material(diffuse=1)
SIZE = (65, 65)


def _spot(position, aim, inner, outer):
    """Return the expected picture of a spot without attenuation over the plane, and the cosines to its axis."""
    reach = np.asarray(position, np.float64) - plane_points(facing(), *SIZE)
    wi = unit(reach)
    cosines = -(wi @ unit(aim))
    low, high = np.cos(np.radians(outer)), np.cos(np.radians(inner))
    cone = np.clip((cosines - low) / max(high - low, 1e-5), 0, 1)**2
    return cone * wi[..., 2], cosines


@pytest.mark.parametrize(("position", "aim", "inner", "outer"), [
    ((0, 0, 2), (0, 0, -1), 10, 20),
    ((0.5, -0.2, 1.5), (-0.4, 0.3, -1), 5, 25),
    ((-0.3, 0.1, 0.7), (1, 0, -3), 3, 40),
    ((0.1, 0.2, 2), (0, 0, -5), 15, 15),  # a hard edge
    ((0, 0, 1), (0, 0, -1), 20, 180),
])
def test_spot_cone_over_a_plane(position, aim, inner, outer):
    light = SpotLight(position=position, direction=aim, attenuation=(1, 0, 0), inner_angle_deg=inner,
                      outer_angle_deg=outer)
    seen = picture(plane(WHITE), light, camera=facing(), size=SIZE)[..., 0]
    expected, cosines = _spot(position, aim, inner, outer)
    low, high = np.cos(np.radians(outer)), np.cos(np.radians(inner))
    inside, outside = cosines > high + 1e-4, cosines < low - 1e-4
    assert inside.any()
    np.testing.assert_allclose(seen[inside], expected[inside], rtol=2e-5)
    assert not seen[outside].any()
    if high - low > 1e-3:
        np.testing.assert_allclose(seen, expected, rtol=2e-5, atol=1e-5 / (high - low) * 0.1)
        assert (~inside & ~outside).any()


@pytest.mark.parametrize("outer", [5.0, 20.0])
def test_spot_edge_stands_where_the_cone_meets_the_plane(outer):
    light = SpotLight(position=(0, 0, 2), direction=(0, 0, -1), inner_angle_deg=outer, outer_angle_deg=outer)
    lit = picture(plane(WHITE), light, camera=facing(), size=(129, 129))[..., 0] > 0
    distance = np.linalg.norm(plane_points(facing(), 129, 129)[..., :2], axis=-1)
    edge = 2 * np.tan(np.radians(outer))
    assert distance[lit].max() < edge < distance[~lit].min() + 1e-4
    assert edge - distance[lit].max() < 2 / 129


@pytest.mark.parametrize("outer", [0.1, 0.3, 1])
def test_narrow_spots_are_as_bright_as_wide_ones(outer):
    aimed = {"position": (0, 0, 1), "attenuation": (1, 0, 0), "inner_angle_deg": outer, "outer_angle_deg": outer}
    assert pixel(plane(WHITE), SpotLight(direction=(0, 0, -1), **aimed), camera=facing()) == pytest.approx(1, rel=1e-5)
    beside = np.tan(np.radians(2 * outer))
    assert not pixel(plane(WHITE), SpotLight(direction=(beside, 0, -1), **aimed), camera=facing()).any()


def test_spot_shines_through_its_own_side_only():
    light = SpotLight(position=(0, 0, 1), direction=(0, 0, 1), outer_angle_deg=90, inner_angle_deg=80)
    assert not picture(plane(WHITE), light, camera=facing(), size=(9, 9)).any()


@pytest.mark.parametrize("attenuation", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0.5, 2), (0.1, 3, 0), (4, 0, 0.01)])
@pytest.mark.parametrize("radius", [0.5, 1, 30])
def test_attenuation_is_the_polynomial_of_distance_over_radius(attenuation, radius):
    a0, a1, a2 = attenuation
    for distance in (1.0, 2.5, 40.0):
        light = PointLight(position=distance * direction(30, 200), radius=radius, attenuation=attenuation)
        x = distance / radius
        np.testing.assert_allclose(pixel(plane(WHITE), light, camera=facing()),
                                   np.cos(np.radians(30)) / (a0 + a1 * x + a2 * x * x), rtol=3e-5)


def test_attenuation_of_a_spot_multiplies_its_cone():
    light = SpotLight(position=(0, 0, 2), direction=(0, 0, -1), radius=4, attenuation=(0, 0, 1))
    assert pixel(plane(WHITE), light, camera=facing()) == pytest.approx(4.0, rel=1e-5)


def test_scene_and_radius_twice_as_large_look_the_same():
    small = picture(plane(WHITE), PointLight(position=(0.5, 0, 1), radius=0.7), camera=facing(), size=(9, 9))
    large = picture(plane(WHITE, half=2), PointLight(position=(1, 0, 2), radius=1.4), camera=facing(6, 2), size=(9, 9))
    np.testing.assert_array_equal(small, large)


def test_lights_that_move_are_seen_where_they_are():
    def at(light, time):
        from glimt import Renderer, RenderSettings, Scene
        scene = Scene([], [light], facing(), RenderSettings(1, 1)).add(plane(WHITE))
        return Renderer(scene, threads=1).render(time).radiance[0, 0, 0]

    orbiting = PointLight(position=(1, 0, 1), attenuation=(1, 0, 0), motion=Orbit((0, 0, 1), (0, 1, 0), 8))
    assert at(orbiting, 0) == pytest.approx(np.sqrt(0.5), rel=1e-5)
    assert at(orbiting, 7) == pytest.approx(1 / np.sqrt(1 + (np.sqrt(0.5) / (1 + np.sqrt(0.5)))**2), rel=1e-5)
    assert at(orbiting, 6) == pytest.approx(1, rel=1e-5)
    sun = DirectionalLight(direction=(0, 0, -1), motion=Path((0, 1), ((0, 0, -1), (1, 0, -1)), loop=False))
    assert at(sun, 0) == pytest.approx(1, rel=1e-6)
    assert at(sun, 0.5) == pytest.approx(1 / np.sqrt(1.25), rel=1e-5)
    assert at(sun, 9) == pytest.approx(np.sqrt(0.5), rel=1e-5)
