"""How held keys and drags move the camera."""

import math

import numpy as np
import pytest

from glimt.scene.camera import Camera
from glimt.viewer.motion import Motion
from glimt.viewer.pose import Pose, dot, minus


def start():
    return Pose.of(Camera((0.0, 0.0, 5.0), (0.0, 0.0, 0.0)))


def run(motion, pose, seconds, step=0.01):
    for _ in range(round(seconds / step)):
        pose = motion.step(pose, step)
    return pose


@pytest.mark.parametrize(("direction", "way"), [
    ("forward", (0, 0, -1)), ("back", (0, 0, 1)), ("right", (1, 0, 0)), ("left", (-1, 0, 0)), ("up", (0, 1, 0)),
    ("down", (0, -1, 0))])
def test_a_held_key_moves_at_the_given_speed(direction, way):
    motion = Motion(speed=2.0)
    motion.hold(direction)
    early = run(motion, start(), 1.0)
    late = run(motion, early, 1.0)
    assert np.allclose(minus(late.position, early.position), 2.0 * np.array(way), rtol=1e-3, atol=1e-6)


def test_the_pace_does_not_depend_on_the_frame_rate():
    ends = []
    for step in (0.005, 0.02, 0.05):
        motion = Motion(speed=1.0)
        motion.hold("forward")
        ends.append(run(motion, start(), 2.0, step).position[2])
    assert np.ptp(ends) < 0.06  # a step in which it gains speed


def test_opposite_keys_cancel():
    motion = Motion(speed=1.0)
    motion.hold("forward")
    motion.hold("back")
    assert run(motion, start(), 1.0).position == start().position


@pytest.mark.parametrize("seconds", [0.0, 0.01, 0.04])
def test_a_tapped_key_moves_the_camera_however_short_it_is(seconds):
    motion = Motion(speed=2.0)
    motion.hold("right")
    pose = run(motion, start(), seconds)
    motion.release("right")
    motion.release("right")
    pose = run(motion, pose, 1.0)
    assert pose.position == pytest.approx((0.1, 0.0, 5.0), abs=0.012)
    assert not motion.moving


def test_letting_go_ends_in_rest_soon():
    motion = Motion(speed=1.0)
    motion.hold("forward")
    pose = run(motion, start(), 1.0)
    motion.release("forward")
    assert motion.moving
    stopped = run(motion, pose, 0.6)
    assert not motion.moving
    assert 0 < pose.position[2] - stopped.position[2] < 0.1
    assert run(motion, stopped, 1.0) == stopped


def test_a_turn_is_made_in_full_and_ends():
    motion = Motion(speed=1.0)
    motion.turn(0.5, 0.25)
    pose = run(motion, start(), 1.0)
    expected = start().turned(0.5, 0.25)
    assert np.allclose(pose.look, expected.look, atol=2e-3)
    assert not motion.moving


def test_a_slide_is_made_in_full():
    motion = Motion(speed=1.0)
    motion.slide(1.0, -2.0, 3.0)
    assert np.allclose(run(motion, start(), 1.0).position, (1, -2, 2), atol=1e-9)


def test_orbit_goes_around_the_target_at_its_distance():
    motion = Motion(speed=1.0, target=(0.0, 0.0, 0.0))
    motion.turn(math.pi / 2, 0.0)
    pose = run(motion, start(), 1.0)
    assert math.dist(pose.position, (0, 0, 0)) == pytest.approx(5.0)
    assert pose.position[0] == pytest.approx(-5.0, abs=0.02)  # a drag to the right turns the scene to the right
    assert dot(pose.look, (1.0, 0.0, 0.0)) == pytest.approx(1.0, abs=1e-4)


def test_dollying_never_passes_the_target():
    motion = Motion(speed=1.0, target=(0.0, 0.0, 0.0))
    for _ in range(50):
        motion.slide(0.0, 0.0, 3.0)
    pose = run(motion, start(), 2.0)
    assert 0 < pose.position[2] < 0.01


def test_sliding_takes_the_target_along():
    motion = Motion(speed=1.0, target=(0.0, 0.0, 0.0))
    motion.slide(1.0, 0.5, 0.0)
    run(motion, start(), 1.0)
    assert np.allclose(motion.target, (1, 0.5, 0), atol=1e-9)


def test_a_long_pause_is_not_walked_through():
    motion = Motion(speed=1.0)
    motion.hold("forward")
    assert start().position[2] - motion.step(start(), 3600.0).position[2] <= 0.1
