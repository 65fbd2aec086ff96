"""The viewer's camera: position, look, right and up."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from glimt.scene.camera import Camera
from glimt.viewer.pose import Pose, cross, dot, minus

ANGLES = st.floats(-3, 3)
LENGTHS = st.floats(-100, 100)


def pose(position=(1.0, 2.0, 3.0), target=(0.0, 0.0, 0.0), up=(0.0, 1.0, 0.0)):
    return Pose.of(Camera(position, target, up, 50.0))


def assert_square(p):
    axes = np.array([p.right, p.up, p.look])
    assert np.allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert np.allclose(cross(p.right, p.up), -np.array(p.look), atol=1e-12)


def test_a_camera_and_back():
    camera = Camera((1.0, 2.0, 3.0), (-4.0, 0.0, 2.0), (0.0, 0.0, 1.0), 33.0)
    again = Pose.of(camera).camera()
    assert again.position == camera.position
    assert again.fov_deg == 33.0
    assert np.allclose(np.stack(again.basis()), np.stack(camera.basis()), atol=1e-12)


def test_far_from_the_origin_the_view_does_not_turn():
    camera = Camera((1e9, 2e9, 3e9), (1e9, 2e9, 2e9))
    again = Pose.of(camera).camera()
    assert np.allclose(np.stack(again.basis()), np.stack(camera.basis()), atol=1e-12)


@given(LENGTHS, LENGTHS, LENGTHS)
def test_a_move_is_along_the_three_directions(right, up, forward):
    before = pose()
    offset = minus(before.moved(right, up, forward).position, before.position)
    moved = [dot(offset, axis) for axis in (before.right, before.up, before.look)]
    assert np.allclose(moved, (right, up, forward), atol=1e-9)


@given(st.lists(st.tuples(ANGLES, ANGLES), max_size=30), st.sampled_from([(0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]))
def test_turns_keep_it_square_and_level_and_never_go_over_the_top(turns, up):
    p = pose(up=up)
    for yaw, pitch in turns:
        p = p.turned(yaw, pitch)
    assert_square(p)
    assert abs(dot(p.right, p.sky)) < 1e-9
    assert abs(dot(p.look, p.sky)) <= math.sin(math.radians(89)) + 1e-9
    assert dot(p.up, p.sky) > 0


def test_yaw_turns_to_the_right_and_pitch_up():
    p = pose((0.0, 0.0, 5.0)).turned(math.pi / 2, 0.0)
    assert np.allclose(p.look, (1, 0, 0), atol=1e-12)
    assert np.allclose(pose((0.0, 0.0, 5.0)).turned(0.0, 0.5).look, (0, math.sin(0.5), -math.cos(0.5)))


@given(ANGLES, st.floats(-0.5, 0.5))
def test_orbiting_keeps_the_target_where_it_is_seen(yaw, pitch):
    target, before = (0.5, 0.25, 0.1), pose()
    after = before.orbited(target, yaw, pitch)

    def seen(p):
        offset = minus(target, p.position)
        return [dot(offset, axis) for axis in (p.right, p.up, p.look)]

    assert np.allclose(seen(after), seen(before), atol=1e-9)
    assert_square(after)
