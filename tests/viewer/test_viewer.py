"""What the viewer renders and when: refinement at rest, interruptions, other scenes."""

import math
import threading
import time
from dataclasses import replace

import numpy as np
import pytest
from viewer_driver import Driver, make_scene

import glimt
from glimt.errors import GlimtError
from glimt.viewer.viewer import REST_SECONDS, Viewer


def rendered(viewer, **changes):
    """Return what glimt.render makes of what the viewer shows."""
    scene = replace(viewer.scene, camera=viewer.pose.camera(), settings=replace(viewer.scene.settings))
    return glimt.render(scene, size=viewer.size, time=viewer.time, **changes)


@pytest.mark.parametrize(("samples", "last"), [(1, 4), (3, 4), ("adaptive", 4), (5, 5)])
def test_at_rest_the_picture_is_that_of_render_to_the_byte(driver, samples, last):
    driver.viewer.samples = samples
    driver.viewer.scene.settings.max_bounces = 2
    driver.viewer.overlay_level = 0
    driver.viewer.resize(203, 117)
    driver.send("key_down", key="w", modifiers=())
    driver.run(0.3)
    driver.send("key_up", key="w", modifiers=())
    driver.rest()
    assert driver.viewer.film_samples == last
    assert np.array_equal(driver.picture[..., :3], rendered(driver.viewer, samples=last))
    assert (driver.picture[..., 3] == 255).all()


def test_refinement_goes_by_steps_and_ends(driver):
    seen = []
    for _ in range(60):
        driver.run(0.01)
        seen.append((driver.viewer.rendered_size, driver.viewer.film_samples))
    steps = list(dict.fromkeys(seen))
    assert steps == [((43, 32), 1), ((80, 60), 1), ((80, 60), 2), ((80, 60), 4)]
    pictures = driver.pictures
    driver.run(5.0)
    assert driver.pictures == pictures
    assert driver.viewer.due(driver.now) == math.inf


def test_nothing_is_refined_before_it_has_rested(driver):
    driver.rest()
    driver.press("w")
    driver.run(1.0)
    moments = []
    viewer = driver.viewer
    driver.send("key_down", key="d", modifiers=())
    driver.run(0.3)
    driver.send("key_up", key="d", modifiers=())
    while viewer.motion.moving:
        driver.run(0.01)
    still = driver.now
    while viewer.film_samples != 2:
        driver.run(0.01)
        moments.append(driver.now)
    assert moments[-1] - still >= REST_SECONDS - 0.02


def test_moving_lights_keep_it_moving(driver):
    driver.press("l")
    for _ in range(20):
        before = driver.picture
        driver.run(0.1)
        assert not np.array_equal(driver.picture, before)
    assert driver.viewer.film_samples == 1


def test_an_event_ends_a_long_refinement_at_once():
    viewer = Viewer(make_scene(max_bounces=2), threads=2)
    driver = Driver(viewer)
    viewer.resize(3000, 3000)
    driver.run(0.01)
    viewer.samples = 64
    driver.now += 1.0
    timer = threading.Timer(0.3, viewer.interrupt)
    timer.start()
    start = time.perf_counter()
    assert viewer.frame(driver.now) is None
    assert time.perf_counter() - start < 10  # 590 M samples would take minutes
    timer.join()
    assert not viewer.at_rest
    viewer.presenter.close()


def test_the_scene_that_was_given_is_left_alone():
    scene = make_scene()
    before = (list(scene.lights), scene.camera, replace(scene.settings), list(scene.objects))
    driver = Driver(Viewer(scene, threads=1))
    for key in ("l", "b", "n", "z"):
        driver.press(key)
    driver.rest() if not driver.viewer.scene.lights[-1].motion else driver.run(0.2)
    assert (list(scene.lights), scene.camera, list(scene.objects)) == (before[0], before[1], before[3])
    assert vars(scene.settings) == vars(before[2])
    driver.viewer.presenter.close()


def test_sizes_of_a_canvas(driver):
    for width, height in [(1, 1), (3, 200), (801, 3), (64, 48)]:
        driver.viewer.resize(width, height)
        driver.run(0.3)
        assert driver.picture.shape == (height, width, 4)
    driver.viewer.resize(0, 0)  # a minimized window
    driver.run(0.1)
    assert driver.picture.shape == (48, 64, 4)


def test_events_in_logical_pixels(driver):
    driver.send("resize", width=40.0, height=30.0, pixel_ratio=2.0)
    driver.run(0.1)
    assert driver.picture.shape == (60, 80, 4)
    driver.click(31.0, 10.0)
    assert driver.viewer.picked.object.name == "quad"


def test_another_version_of_the_scene_keeps_the_view(driver):
    driver.press("w")
    driver.run(0.5)
    pose = driver.viewer.pose
    other = make_scene()
    other.objects.pop()
    driver.viewer.error = "something"
    driver.viewer.replace_scene(other)
    driver.viewer.overlay_level = 0
    driver.rest()
    assert driver.viewer.pose == pose
    assert driver.viewer.error is None
    assert np.array_equal(driver.picture[..., :3], rendered(driver.viewer, samples=4))
    other.camera = glimt.Camera((0.0, 3.0, 5.0), (0.0, 0.0, 0.0))
    driver.viewer.replace_scene(other)
    assert driver.viewer.pose.position == (0.0, 3.0, 5.0)


def test_a_scene_without_objects_or_camera():
    driver = Driver(Viewer(glimt.Scene(settings=glimt.RenderSettings(32, 32, background=0.5)), threads=1))
    driver.viewer.overlay_level = 0
    driver.rest()
    assert (driver.picture[..., :3] == 188).all()
    for key in ("f", "o", "l", "t", "F7"):
        driver.press(key)
    driver.viewer.presenter.close()


def test_a_screenshot_and_its_view_make_the_same_picture_again(driver, tmp_path):
    driver.press("l")
    driver.run(0.7)
    driver.press("b")
    driver.press("p")
    driver.run(0.1)
    png, = tmp_path.glob("two-*.png")
    view, = tmp_path.glob("two-*.toml")
    assert "saved" in driver.viewer.message
    from glimt.io.image import TextureCache
    from glimt.io.view_file import apply_view
    again = apply_view(make_scene(), view)
    assert again.settings.samples == 4
    assert again.settings.max_bounces == 1
    assert np.array_equal(glimt.render(again), TextureCache().pixels(png))


def test_a_screenshot_that_cannot_be_kept_is_told(driver, tmp_path):
    driver.viewer.folder = tmp_path / "none"
    driver.press("p")
    driver.run(0.05)
    assert "not saved" in driver.viewer.message


def test_jobs_that_fail_are_not_hidden(driver):
    def fail():
        raise GlimtError("no")

    driver.viewer.jobs.append(fail)
    with pytest.raises(GlimtError):
        driver.viewer.frame(driver.now)


@pytest.mark.parametrize(("press", "drawn"), [("F2", "normals"), ("n", 2)])
def test_what_has_to_be_compiled_first_is_told_before(driver, press, drawn):
    viewer = driver.viewer
    driver.rest()
    picture, ready = viewer.presenter.picture(), viewer.renderer.is_ready
    viewer.renderer.is_ready = lambda samples, view=None: (view or samples) != drawn
    driver.press(press)
    assert "compiling" in viewer.message
    assert np.array_equal(viewer.presenter.picture(), picture)
    told = driver.picture
    driver.run(0.01)
    viewer.renderer.is_ready = ready
    assert viewer.message is None
    assert drawn in (viewer.debug_view, viewer.film_samples)
    assert not np.array_equal(driver.picture, told)
    driver.rest()
    assert driver.pictures < 100
