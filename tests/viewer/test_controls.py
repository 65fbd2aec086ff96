"""Every control does what the help says: camera, lights, bounces, and that the picture changes."""

import math

import numpy as np
import pytest

import glimt
from glimt.viewer.commands import DEBUG_VIEWS
from glimt.viewer.keys import KEYS
from glimt.viewer.pose import Pose, dot, minus


def moved(driver, *keys, seconds=0.5):
    """Hold keys for a while; return how far the camera went right, up and forward."""
    before = driver.viewer.pose
    for key in keys:
        driver.send("key_down", key=key, modifiers=())
    driver.run(seconds)
    for key in keys:
        driver.send("key_up", key=key, modifiers=())
    driver.run(1.0)
    offset = minus(driver.viewer.pose.position, before.position)
    return np.array([dot(offset, axis) for axis in (before.right, before.up, before.look)])


@pytest.mark.parametrize(("key", "axis", "sign"), [
    ("w", 2, 1), ("ArrowUp", 2, 1), ("s", 2, -1), ("ArrowDown", 2, -1), ("a", 0, -1), ("ArrowLeft", 0, -1),
    ("d", 0, 1), ("ArrowRight", 0, 1), ("e", 1, 1), (" ", 1, 1), ("q", 1, -1), ("Shift", 1, -1)])
def test_held_keys_move_the_camera_and_the_picture(driver, key, axis, sign):
    driver.run(0.1)
    before = driver.picture
    way = moved(driver, key)
    assert way[axis] * sign > 0.1 * driver.viewer.motion.speed
    assert np.abs(np.delete(way, axis)).max() < 1e-6
    assert not np.array_equal(driver.picture, before)
    position = driver.viewer.pose.position
    driver.run(0.5)
    assert driver.viewer.pose.position == position


def test_walking_goes_on_when_shift_comes_and_goes(driver):
    driver.send("key_down", key="w", modifiers=())
    driver.send("key_down", key="Shift", modifiers=("Shift",))
    driver.send("key_up", key="W", modifiers=("Shift",))
    driver.send("key_up", key="Shift", modifiers=())
    driver.run(1.0)
    position = driver.viewer.pose.position
    driver.run(1.0)
    assert driver.viewer.pose.position == position


def test_shift_begins_to_move_the_camera_from_where_it_is(driver):
    driver.rest()
    before = driver.viewer.pose
    driver.send("key_down", key="Shift", modifiers=("Shift",))
    driver.now += 0.24  # nobody asked for a picture meanwhile
    driver.run(0.01)
    assert driver.viewer.motion.moving
    assert driver.viewer.pose == before


def test_shift_as_part_of_a_key_does_not_move_the_camera(driver):
    before = driver.viewer.pose
    driver.send("key_down", key="Shift", modifiers=("Shift",))
    driver.run(0.1)
    driver.press("L", "Shift")
    driver.run(0.5)
    driver.send("key_up", key="Shift", modifiers=())
    driver.run(0.5)
    assert driver.viewer.pose == before
    assert driver.viewer.scene.lights == []


def test_faster_and_slower(driver):
    plain = moved(driver, "w")[2]
    driver.press("+", "Shift")
    assert moved(driver, "w")[2] == pytest.approx(1.4 * plain, rel=1e-6)
    driver.press("-")
    driver.press("-")
    assert moved(driver, "w")[2] == pytest.approx(plain / 1.4, rel=1e-6)


def test_lights_come_where_the_camera_is_and_orbit(driver):
    viewer = driver.viewer
    driver.rest()
    before = driver.picture
    driver.press("l")
    assert len(viewer.scene.lights) == 2
    light = viewer.scene.lights[-1]
    assert np.allclose(light.position_at(viewer.time), viewer.pose.position, atol=0.1)
    assert not np.array_equal(driver.picture, before)
    early = light.position_at(viewer.time)
    driver.run(1.0)
    assert math.dist(early, light.position_at(viewer.time)) > 0.5
    driver.press("t")
    stopped = viewer.time
    driver.rest()
    assert viewer.time == stopped
    driver.press("t")
    driver.run(0.5)
    assert viewer.time == pytest.approx(stopped + 0.5, abs=0.05)
    for count in (1, 0, 0):
        driver.press("L", "Shift")
        assert len(viewer.scene.lights) == count
    driver.rest()
    assert driver.viewer.scene.lights == []


def test_a_light_added_later_is_where_the_camera_is_then(driver):
    driver.press("l")
    driver.run(3.0)
    moved(driver, "w")
    driver.press("l")
    light = driver.viewer.scene.lights[-1]
    assert np.allclose(light.position_at(driver.viewer.time), driver.viewer.pose.position, atol=0.1)


def test_the_scene_that_was_given_is_not_changed():
    pass


def test_bounces(driver):
    settings = driver.viewer.scene.settings
    for count in (1, 2, 3):
        driver.press("b")
        assert settings.max_bounces == count
    for count in (2, 1, 0, 0):
        driver.press("B", "Shift")
        assert settings.max_bounces == count


def test_samples(driver):
    for samples in (2, 3, "adaptive", 1):
        driver.press("n")
        driver.run(0.02)  # one frame may tell that a kernel is compiled first
        assert driver.viewer.samples == samples
        assert driver.viewer.film_samples == samples


def test_mouse_look(driver):
    viewer = driver.viewer
    before = viewer.pose
    driver.send("pointer_move", x=10.0, y=10.0, buttons=(), modifiers=())
    driver.send("pointer_move", x=50.0, y=10.0, buttons=(), modifiers=())
    driver.run(0.5)
    assert viewer.pose == before
    driver.press("m")
    assert viewer.mouse_look
    driver.send("pointer_move", x=50.0, y=10.0, buttons=(), modifiers=())
    driver.send("pointer_move", x=60.0, y=20.0, buttons=(), modifiers=())
    driver.run(0.5)
    assert viewer.pose.position == before.position
    assert dot(viewer.pose.look, before.right) > 0.05
    assert dot(viewer.pose.look, before.up) < -0.05
    driver.press("Escape")
    assert not viewer.mouse_look


def test_drags(driver):
    viewer = driver.viewer
    driver.drag(20, 0)
    assert dot(viewer.pose.look, (1.0, 0.0, 0.0)) > 0.05
    driver.press("r")
    driver.drag(0, -20, button=2)
    x, y, _ = minus(viewer.pose.position, viewer.first_pose.position)
    assert y < -0.1
    assert abs(x) < 1e-9


def test_orbit_keeps_its_distance_from_what_is_in_the_middle(driver):
    viewer = driver.viewer
    driver.send("pointer_move", x=60.0, y=30.0, buttons=(), modifiers=())
    driver.drag(8, 0)  # onto the quad
    driver.press("o")
    target = viewer.motion.target
    assert target[2] == pytest.approx(0.0, abs=1e-6)
    distance = math.dist(target, viewer.pose.position)
    driver.drag(15, 5)
    assert math.dist(target, viewer.pose.position) == pytest.approx(distance, rel=1e-6)
    driver.send("wheel", dx=0.0, dy=-100.0, x=40.0, y=30.0, modifiers=())
    driver.run(1.0)
    assert math.dist(target, viewer.pose.position) < 0.95 * distance
    driver.press("o")
    assert viewer.motion.target is None


def test_the_wheel_flies_forward_and_back(driver):
    driver.send("wheel", dx=0.0, dy=-200.0, x=40.0, y=30.0, modifiers=())
    driver.run(1.0)
    assert driver.viewer.pose.position[2] < 4.9
    driver.send("wheel", dx=0.0, dy=200.0, x=40.0, y=30.0, modifiers=())
    driver.run(1.0)
    assert driver.viewer.pose.position[2] == pytest.approx(5.0)


def test_clicks_pick_object_material_and_triangle(driver):
    driver.click(62.0, 20.0)
    picked = driver.viewer.picked
    assert (picked.object.name, picked.material.name, picked.triangle) == ("quad", "green", 1)
    driver.click(23.0, 30.0)
    assert (driver.viewer.picked.object.name, driver.viewer.picked.triangle) == ("ball", None)
    driver.click(2.0, 2.0)
    assert driver.viewer.picked is None


def test_a_drag_is_no_click(driver):
    driver.drag(15, 0)
    assert driver.viewer.picked is None


def test_a_double_click_orbits_around_that_point(driver):
    driver.click(62.0, 20.0, "double_click")
    assert driver.viewer.motion.target == driver.viewer.picked.position
    look = driver.viewer.pose.look
    driver.run(0.5)
    assert driver.viewer.pose.look == look


def test_framing(driver):
    viewer = driver.viewer
    driver.press("F", "Shift")
    assert viewer.pose == viewer.first_pose  # nothing is picked
    driver.click(23.0, 30.0)
    driver.press("F", "Shift")
    x, y, z = viewer.pose.position
    assert (x, y) == pytest.approx((-1.2, 0.0), abs=1e-6)
    assert 0.8 < z < 5
    driver.press("f")
    lo, hi = viewer.scene.bounds()
    assert viewer.pose.position[0] == pytest.approx((lo[0] + hi[0]) / 2)
    driver.press("r")
    assert viewer.pose == viewer.first_pose


def test_field_of_view(driver):
    driver.press("z")
    assert driver.viewer.pose.fov_deg == pytest.approx(45 / 1.1)
    driver.press("Z", "Shift")
    driver.press("Z", "Shift")
    assert driver.viewer.pose.fov_deg == pytest.approx(45 * 1.1)
    for _ in range(60):
        driver.press("Z", "Shift")
    assert driver.viewer.pose.fov_deg <= 150


def test_saved_views(driver):
    driver.press("4")
    assert driver.viewer.pose == driver.viewer.first_pose
    assert "no view 4" in driver.viewer.message
    moved(driver, "w")
    here = driver.viewer.pose
    driver.press("v")
    driver.press("4")
    assert driver.viewer.saved == {4: here}
    driver.press("r")
    driver.press("4")
    assert driver.viewer.pose == here
    driver.press("v")
    driver.press("x")
    driver.press("5")
    assert driver.viewer.saved == {4: here}


def test_debug_views(driver):
    keys = {key.action: key.keys[0] for key in KEYS}
    driver.viewer.overlay_level = 0
    driver.rest()
    driver.run(3.0)
    shown = [driver.picture]
    for name in DEBUG_VIEWS:
        driver.press(keys[f"debug_{name}"])
        assert driver.viewer.debug_view == name
        driver.rest()
        assert not any(np.array_equal(driver.picture, other) for other in shown)
        shown.append(driver.picture)
    driver.press("c")
    assert driver.viewer.debug_view is None
    driver.press("c")
    assert driver.viewer.debug_view == DEBUG_VIEWS[0]
    driver.press("F1")
    driver.rest()
    driver.run(3.0)
    assert np.array_equal(driver.picture, shown[0])


def test_overlay_and_help(driver):
    driver.viewer.resize(400, 300)
    driver.rest()
    plain, pictures = driver.viewer.finest(), [driver.picture]
    for level in (2, 0, 1):
        driver.press("i")
        assert driver.viewer.overlay_level == level
        pictures.append(driver.picture)
    numbers, graph, none, again = pictures
    assert np.array_equal(none, plain)
    assert np.array_equal(again[..., 3], plain[..., 3])
    drawn = [int((picture != plain).any(-1).sum()) for picture in (numbers, graph)]
    assert 0 < drawn[0] < drawn[1] < plain[..., 0].size / 2
    driver.press("h")
    assert driver.viewer.help_shown
    assert (driver.picture != plain).any(-1).sum() > drawn[1]
    with_help = driver.picture
    driver.press("i")
    driver.press("i")
    assert np.array_equal(driver.picture, with_help)  # the help has all the room
    driver.press("i")
    driver.press("Escape")
    assert not driver.viewer.help_shown
    assert (driver.picture != plain).any(-1).sum() < 2 * drawn[0]


def test_pause_stops_everything(driver):
    driver.press("l")
    driver.press("k")
    driver.run(3.0)
    time, pictures = driver.viewer.time, driver.pictures
    moved(driver, "w")
    assert driver.viewer.pose == driver.viewer.first_pose
    assert (driver.viewer.time, driver.pictures) == (time, pictures)
    driver.viewer.resize(100, 60)
    driver.run(0.1)
    assert driver.picture.shape == (60, 100, 4)
    driver.press("k")
    driver.run(0.5)
    assert driver.viewer.time > time


def test_nothing_a_canvas_sends_is_taken_amiss(driver):
    for name in ("", "close", "nonsense", "_hold", "key_up", "char", "before_draw", "animate"):
        driver.send(name, key="y", modifiers=())
    driver.send("key_up", key="w", modifiers=())
    driver.run(0.1)
    assert isinstance(driver.viewer.pose, Pose)
    assert isinstance(driver.viewer.scene, glimt.Scene)
