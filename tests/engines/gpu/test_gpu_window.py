"""`glimt view --engine gpu`: the stone room in a window, with what the GPU's stages took over it."""

import sys
from pathlib import Path

import numpy as np
import pytest
from gpu_device import need_adapter
from PIL import Image

import glimt
from glimt.engines.gpu.adapters import choose_adapter, list_adapters

SIZE = 320, 240
LOSE = ("__import__('wgpu.backends.wgpu_native', fromlist=['lib']).lib.wgpuDeviceDestroy("
        "viewer.renderer._engine._engine._device.gpu._internal)")
"""What a reset of the driver does to a device."""
ENGINE = "viewer.renderer._engine._engine"
MOST_BYTES = f"getattr({ENGINE}._download._staging, 'size', 0)"
"""That came back from the GPU at once, up to now: its memory on the way grows and never shrinks."""
BY_MEMORY = ("(lambda picture: (viewer.presenter._draw_overlay(viewer, picture), picture[..., :3].tolist())[1])"
             "(viewer.presenter.picture())")
"""The picture as windows of OpenGL get it."""
FREE = 230
"""The first column that numbers leave free."""
PANEL = np.s_[10:200, 10:180]
STAGES = {"create_rays", "intersect", "shade", "bounce", "resolve"}


@pytest.fixture
def app(monkeypatch):
    """Return the viewer of the stone room, and the module that drives it."""
    need_adapter()
    monkeypatch.setenv("GLIMT_GPU", "software")
    monkeypatch.syspath_prepend(Path(__file__).parents[2] / "viewer")
    for name in ("view_client", "xvfb"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    import view_client
    import xvfb

    with (xvfb.xvfb() as display,
          view_client.viewing(display, view_client.STONE_ROOM, "--engine", "gpu", "--bounces", "1",
                              "--size", "{}x{}".format(*SIZE)) as app):
        yield app, view_client.STONE_ROOM


def test_the_stone_room_appears_with_the_overlay(app):
    app, path = app
    app.ask("app.reset()")
    app.wait_for(lambda state: state["at_rest"], 60)
    picture = np.array(app.ask("viewer.presenter.picture()[..., :3].tolist()"), np.uint8)
    expected = glimt.render(glimt.load(path), size=SIZE, samples=4, max_bounces=1)
    assert (np.abs(picture.astype(int) - expected).max(-1) > 3).mean() < 0.002
    app.display.wait_for_pixels(picture[:, FREE:], x=FREE, within=2)
    assert (app.picture()[PANEL] != picture[PANEL]).mean() > 0.9
    assert app.ask("viewer.renderer.engine_name") == choose_adapter(list_adapters(), "software").summary
    stages, seconds = app.ask("(viewer.film.stages, viewer.film.seconds)")
    assert set(stages) == STAGES
    assert min(stages.values()) > 0
    assert sum(stages.values()) < seconds


def test_it_is_what_comes_by_memory_and_nothing_is_read_back(app):
    """With the help, a graph, notices and another size of the window; what comes back is counted."""
    app, _ = app
    app.ask("app.reset()")
    app.ask("setattr(viewer.presenter.overlay, '_clock', lambda: 0.0)")  # the numbers are not written anew
    app.wait_for(lambda state: state["at_rest"], 60)
    for step in ("", "i", "h", "size", "F2"):
        if step == "size":
            app.display.do("windowsize", str(app.window), "300", "260")
            app.wait_for(lambda state: state["size"] == [300, 260], 10)
        elif step:
            before = app.picture()
            app.press(step)
            app.wait_for_change(before)
        app.wait_for(lambda state: state["at_rest"] and not state["message"], 60)
        most = app.ask(MOST_BYTES)
        if step != "F2":  # whose numbers come back, to be coloured
            assert most < 4096, "more came back than counters and times"
        app.display.wait_for_pixels(np.array(app.ask(BY_MEMORY), np.uint8), within=2)
        assert app.ask("type(app.canvas.screen).__name__") == "GpuScreen"
        app.ask(f"setattr({ENGINE}._download, '_staging', None)")  # BY_MEMORY has had the picture brought back


def test_a_moving_camera_reads_nothing_back(app):
    app, _ = app
    app.wait_for(lambda state: state["rendered"] > 3, 60)
    before = app.state()
    app.hold("d", 1.5)
    after = app.wait_for(lambda state: not state["moving"])
    assert after["rendered"] > before["rendered"] + 3
    assert after["taken"] > before["taken"] + 3
    assert after["position"] != before["position"]
    assert app.ask(MOST_BYTES) < 4096


def test_a_saved_picture_is_that_of_the_engine_to_the_byte(app, tmp_path):
    app, path = app
    app.ask("app.reset()")
    app.ask(f"setattr(viewer, 'folder', __import__('pathlib').Path({str(tmp_path)!r}))")
    app.wait_for(lambda state: state["at_rest"], 60)
    app.press("p")
    saved = app.wait_for(lambda state: "saved" in (state["message"] or ""))["message"].removeprefix("saved ")
    expected = glimt.render(glimt.load(path), size=SIZE, samples=4, max_bounces=1, engine="gpu")
    with Image.open(saved) as image:
        np.testing.assert_array_equal(np.asarray(image), expected)


def test_a_window_outlives_its_gpu(app):
    app, path = app
    app.ask("app.reset()")
    app.wait_for(lambda state: state["at_rest"], 60)
    assert app.ask(LOSE) is None
    app.press("d")
    app.wait_for(lambda state: (app.ask("viewer.message") or "").startswith("the GPU was lost while"), 60)
    assert app.ask("viewer.renderer.engine_name").startswith("CPU")
    app.reset()
    expected = glimt.render(glimt.load(path), size=SIZE, samples=4, max_bounces=1)
    picture = np.array(app.ask("viewer.presenter.picture()[..., :3].tolist()"), np.uint8)
    np.testing.assert_array_equal(picture, expected)
    app.display.wait_for_pixels(picture[:, FREE:], x=FREE)
    assert app.ask("type(app.canvas.screen).__name__") == "GlScreen"
    assert app.process.poll() is None


def test_a_window_whose_gpu_is_lost_at_rest_comes_back_where_it_was_when_it_is_uncovered(app):
    app, path = app
    app.ask("app.reset()")
    app.display.do("windowmove", "--sync", str(app.window), "60", "70")
    app.wait_for(lambda state: state["at_rest"], 60)
    app.ask(LOSE)
    for step in ("windowunmap", "windowmap"):
        app.display.do(step, "--sync", str(app.window))
    app.wait_for(lambda state: app.ask("viewer.renderer.engine_name").startswith("CPU"), 60)
    app.reset()
    expected = glimt.render(glimt.load(path), size=SIZE, samples=4, max_bounces=1)
    app.display.wait_for_pixels(expected[:, FREE:], 60 + FREE, 70)
    window = app.display.do("search", "--onlyvisible", "--class", "glimt").split()
    assert len(window) == 1
    app.display.do("windowfocus", "--sync", *window, "key", "b")
    app.wait_for(lambda state: state["bounces"] == 2)


def test_a_held_key_comes_up_when_the_window_is_another(app):
    app, _ = app
    app.ask("app.reset()")
    app.wait_for(lambda state: state["at_rest"], 60)
    app.press("k")  # paused: nothing is rendered while the key is held
    app.display.do("keydown", "d")
    app.wait_for(lambda state: state["moving"])
    app.ask("app.thread.do(viewer.leave_gpu) or setattr(viewer, 'paused', False)")
    app.wait_for(lambda state: app.ask("type(app.canvas.screen).__name__") == "GlScreen", 30)
    app.wait_for(lambda state: not state["moving"], 30)
    assert app.ask("viewer.renderer.engine_name") == choose_adapter(list_adapters(), "software").summary
    app.display.do("keyup", "d")
