"""`glimt view --engine gpu`: the stone room in a window, with what the GPU's stages took over it."""

import sys
from pathlib import Path

import numpy as np
import pytest
from gpu_device import need_adapter

import glimt
from glimt.engines.gpu.adapters import choose_adapter, list_adapters

SIZE = 320, 240
LOSE = ("__import__('wgpu.backends.wgpu_native', fromlist=['lib']).lib.wgpuDeviceDestroy("
        "viewer.renderer._engine._engine._device.gpu._internal)")
"""What a reset of the driver does to a device."""
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
    app.display.wait_for_pixels(picture[:, FREE:], x=FREE)
    assert (app.picture()[PANEL] != picture[PANEL]).mean() > 0.9
    assert app.ask("viewer.renderer.engine_name") == choose_adapter(list_adapters(), "software").summary
    stages, seconds = app.ask("(viewer.film.stages, viewer.film.seconds)")
    assert set(stages) == STAGES
    assert min(stages.values()) > 0
    assert sum(stages.values()) < seconds


def test_a_window_outlives_its_gpu(app):
    app, path = app
    app.ask("app.reset()")
    app.wait_for(lambda state: state["at_rest"], 60)
    assert app.ask(LOSE) is None
    app.press("d")
    app.wait_for(lambda state: app.ask("viewer.renderer.engine_name").startswith("CPU"), 60)
    assert app.ask("viewer.message").startswith("the GPU was lost while")
    app.reset()
    expected = glimt.render(glimt.load(path), size=SIZE, samples=4, max_bounces=1)
    picture = np.array(app.ask("viewer.presenter.picture()[..., :3].tolist()"), np.uint8)
    np.testing.assert_array_equal(picture, expected)
    app.display.wait_for_pixels(picture[:, FREE:], x=FREE)
    assert app.process.poll() is None
