"""Orbits and paths."""

import pytest

from glimt import Orbit, Path


@pytest.mark.parametrize(("time", "expected"), [(0, (3, 1, 0)), (1, (1, 1, -2)), (2, (-1, 1, 0)), (3, (1, 1, 2)),
                                                (4, (3, 1, 0)), (-1, (1, 1, 2)), (4e9 + 2, (-1, 1, 0))])
def test_orbit_turns_right_handed_around_its_axis(time, expected):
    assert Orbit((1, 0, 0), (0, 7, 0), 4).position((3, 1, 0), time) == pytest.approx(expected, abs=1e-5)


def test_a_negative_period_turns_the_other_way():
    assert Orbit((0, 0, 0), (0, 0, 1), -4).position((1, 0, 0), 1) == pytest.approx((0, -1, 0), abs=1e-12)


def test_orbit_of_a_direction_ignores_the_center():
    assert Orbit((100, 0, 0), (0, 0, 1), 4).direction((1, 0, 5), 1) == pytest.approx((0, 1, 5))


PATH = ((1.0, 2.0, 4.0), ((0, 0, 0), (1, 0, 0), (1, 4, 0)))


@pytest.mark.parametrize(("time", "loop", "expected"), [
    (1, True, (0, 0, 0)), (1.5, True, (0.5, 0, 0)), (2, True, (1, 0, 0)), (3, True, (1, 2, 0)), (4, True, (0, 0, 0)),
    (4.5, True, (0.5, 0, 0)), (0, True, (1, 2, 0)), (0, False, (0, 0, 0)), (3, False, (1, 2, 0)), (9, False, (1, 4, 0)),
])
def test_path(time, loop, expected):
    path = Path(*PATH, loop=loop)
    assert path.position((9, 9, 9), time) == pytest.approx(expected)
    assert path.direction((9, 9, 9), time) == pytest.approx(expected)
