"""Lights: defaults and where they are over time."""

import math

import pytest

from glimt import DirectionalLight, Orbit, Path, PointLight, SpotLight


def test_colours_are_one_number_or_three():
    light = PointLight(position=(1, 2, 3), ambient=0.5, diffuse=(1, 2, 3))
    assert light.ambient == (0.5, 0.5, 0.5)
    assert light.diffuse == light.specular == (1, 2, 3)
    assert PointLight(position=(0, 0, 0), specular=0).specular == (0, 0, 0)
    assert light.position == (1.0, 2.0, 3.0)


def test_cosines_of_a_spot():
    inner, outer = SpotLight(position=(0, 0, 0), direction=(0, 0, -2), inner_angle_deg=30,
                             outer_angle_deg=60).cosines()
    assert inner == pytest.approx(math.sqrt(3) / 2)
    assert outer == pytest.approx(0.5)


def test_lights_without_motion_stay():
    assert PointLight(position=(1, 2, 3)).position_at(7) == (1, 2, 3)
    assert DirectionalLight(direction=(0, -2, 0)).direction_at(7) == (0, -2, 0)


def test_lights_follow_their_motion():
    orbit = Orbit((0, 0, 0), (0, 1, 0), 4)
    assert PointLight(position=(1, 5, 0), motion=orbit).position_at(1) == pytest.approx((0, 5, -1))
    assert DirectionalLight(direction=(1, -1, 0), motion=orbit).direction_at(1) == pytest.approx((0, -1, -1))
    spot = SpotLight(position=(0, 0, 0), direction=(0, 0, 1), motion=Path((0, 2), ((0, 0, 0), (4, 0, 0))))
    assert spot.position_at(1) == (2, 0, 0)


def test_a_direction_never_vanishes():
    light = DirectionalLight(direction=(0, -1, 0), motion=Path((0, 2), ((-1, 0, 0), (1, 0, 0)), loop=False))
    assert light.direction_at(1) == (0, -1, 0)
