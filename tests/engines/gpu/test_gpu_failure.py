"""A GPU that is lost, full or silent: the CPU goes on with a warning, or there is an error, and never a hang."""

import threading
from pathlib import Path

import numpy as np
import pytest
from both_engines import on_cpu, sized

import glimt
from glimt.bench import flight
from glimt.engines import Choice, get_engine
from glimt.engines import engine as engines
from glimt.engines.cpu.engine import CpuEngine
from glimt.engines.gpu import engine as gpu_engine
from glimt.engines.gpu.adapters import import_wgpu
from glimt.engines.gpu.buffers import Buffer
from glimt.engines.gpu.commands import Commands
from glimt.errors import EngineError, GlimtError, GlimtWarning
from glimt.renderer import Renderer
from glimt.viewer.viewer import Viewer

STONE_ROOM = Path(__file__).resolve().parents[3] / "examples" / "stone_room.toml"

pytestmark = pytest.mark.usefixtures("software_gpu")


@pytest.fixture
def auto(monkeypatch):
    """Have "auto" take the software adapter, which it leaves alone otherwise."""
    choose = engines.choose_engine
    monkeypatch.setattr(engines, "choose_engine", lambda name: Choice("gpu", "for a test") if name == "auto" else
                        choose(name))


def _scene(samples=2):
    return sized(glimt.load(STONE_ROOM), 48, 36, samples, 1)


def _device(renderer):
    """Return the device of what may be replaced, or may not."""
    return getattr(renderer._engine, "_engine", renderer._engine)._device


def _lose(device):
    """Do what a reset of the driver does to a device, whatever its wrapper in Python believes."""
    from wgpu.backends.wgpu_native import lib
    lib.wgpuDeviceDestroy(device.gpu._internal)


def _lose_at_submission(monkeypatch, number):
    """Have the device be lost once so many submissions were made, before their results are there."""
    submit, made = Commands.submit, []

    def submit_and_lose(commands):
        submit(commands)
        made.append(commands)
        if len(made) == number:
            _lose(commands._device)

    monkeypatch.setattr(Commands, "submit", submit_and_lose)
    return made


def _fill_memory(monkeypatch, renderer):
    def create_buffer(**given):
        raise import_wgpu().GPUOutOfMemoryError("Not enough memory left.")

    monkeypatch.setattr(_device(renderer).gpu, "create_buffer", create_buffer)


def _shrink_limits(monkeypatch, renderer):
    monkeypatch.setitem(_device(renderer).limits, "max-buffer-size", 5000)


def _silence(monkeypatch, renderer):
    class Never:
        _thread_event = threading.Event()

    device = _device(renderer)
    wait = device.wait
    monkeypatch.setattr(device, "patience", 0.4)
    monkeypatch.setattr(device, "wait", lambda promise: wait(Never()))


FAILURES = {
    "lost": (lambda monkeypatch, renderer: _lose(_device(renderer)), "the GPU was lost while"),
    "lost at work": (lambda monkeypatch, renderer: _lose_at_submission(monkeypatch, 3), "the GPU was lost while"),
    "full": (_fill_memory, "the GPU has not enough memory while making room for"),
    "silent": (_silence, "the GPU has not answered for 0.5 s"),
    "too small": (_shrink_limits, "more than the 0 MiB of a buffer of"),
}


@pytest.mark.parametrize("failure", FAILURES)
def test_the_cpu_goes_on_with_one_warning(auto, monkeypatch, failure):
    fail, what = FAILURES[failure]
    scene = _scene()
    renderer = Renderer(scene)
    assert "llvmpipe" in renderer.engine_name
    renderer.render()
    scene.settings.width, scene.settings.height = 64, 48
    wanted = on_cpu(scene)
    fail(monkeypatch, renderer)
    with pytest.warns(GlimtWarning, match=f"{what}.*; the CPU engine goes on") as caught:
        film = renderer.render(0.5)
    assert len(caught) == 1
    assert film.sums.tobytes() == wanted.render(0.5).sums.tobytes()
    assert renderer.engine_name.startswith("CPU")
    scene.lights[0].diffuse = (0.3, 0.2, 0.1)
    assert renderer.render().sums.tobytes() == wanted.render().sums.tobytes()
    assert renderer.pick(30, 30) == wanted.pick(30, 30)
    np.testing.assert_array_equal(renderer.render_debug("normals").values, wanted.render_debug("normals").values)


@pytest.mark.parametrize("failure", FAILURES)
def test_gpu_is_the_gpu_or_an_error(monkeypatch, failure):
    fail, what = FAILURES[failure]
    scene = _scene()
    renderer = Renderer(scene, engine="gpu")
    renderer.render()
    scene.settings.width, scene.settings.height = 64, 48
    fail(monkeypatch, renderer)
    with pytest.raises(EngineError, match=f"{what}.*CPU engine"):
        renderer.render()
    assert "llvmpipe" in renderer.engine_name


def test_memory_that_is_there_again_is_used(monkeypatch):
    """Also that of what was not uploaded when there was none: textures come after trees."""
    scene = _scene()
    scene.objects = scene.objects[:1]
    renderer = Renderer(scene, engine="gpu")
    renderer.render()
    upload = Buffer.upload

    def fail(buffer, array):
        if buffer is renderer._engine._buffers["records"]:
            raise EngineError("no memory", "wait")
        upload(buffer, array)

    scene.objects = _scene().objects
    renderer.update()
    with monkeypatch.context() as full:
        full.setattr(Buffer, "upload", fail)
        for _ in range(2):
            with pytest.raises(EngineError, match="no memory"):
                renderer.render()
    assert renderer.render().sums.tobytes() == Renderer(scene, engine="gpu").render().sums.tobytes()


def test_a_gpu_that_cannot_be_opened(auto, monkeypatch):
    def fail(threads, group):
        raise EngineError("it cannot be opened", "choose the CPU engine")

    monkeypatch.setattr(gpu_engine, "GpuEngine", fail)
    with pytest.warns(GlimtWarning, match="it cannot be opened; the CPU engine goes on"):
        assert isinstance(get_engine("auto"), CpuEngine)
    for on_failure in (None, print):
        with pytest.raises(EngineError, match="it cannot be opened; choose the CPU engine"):
            get_engine("gpu", on_failure=on_failure)


def test_a_failure_in_an_upload_and_before_any(auto):
    scene, told = _scene(), []
    renderer = Renderer(scene, on_failure=told.append)
    _lose(_device(renderer))
    assert renderer.render().sums.tobytes() == on_cpu(scene).render().sums.tobytes()
    assert len(told) == 1
    engine = get_engine("gpu", on_failure=told.append)
    _lose(engine._engine._device)
    with pytest.raises(GlimtError, match="no scene was uploaded"):
        engine.find_hits(np.zeros((7, 1), np.float32))


def test_threads_that_fail_at_the_same_time_get_the_same_engine(auto):
    told = []
    renderer = Renderer(_scene(), on_failure=told.append)
    wanted = renderer.pick(20, 20)
    _lose(_device(renderer))
    picked = []
    threads = [threading.Thread(target=lambda: picked.append(renderer.pick(20, 20))) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [pick.triangle for pick in picked] == 4 * [wanted.triangle]
    assert len(told) == 1


def test_the_other_engine_is_the_last(auto, monkeypatch):
    renderer = Renderer(_scene(), on_failure=lambda failure: None)
    _lose(_device(renderer))
    renderer.render()

    def fail(*given):
        raise EngineError("the CPU melts", "cool it")

    monkeypatch.setattr(renderer._engine._engine, "render", fail)
    with pytest.raises(EngineError, match="the CPU melts; cool it"):
        renderer.render()


@pytest.mark.parametrize("engine", ["gpu", "auto"])
def test_the_viewer_goes_on_and_says_so(auto, monkeypatch, engine):
    scene = _scene()
    viewer = Viewer(scene, engine=engine)
    viewer.resize(96, 72)
    now = 0.0
    viewer.frame(now)
    made = _lose_at_submission(monkeypatch, 2)
    viewer.changed()
    while not viewer.message and now < 5:
        now += 0.02
        viewer.frame(now)
    assert len(made) >= 2
    assert viewer.message.startswith("the GPU was lost while")
    assert viewer.message.endswith("; the CPU goes on")
    assert viewer.renderer.engine_name.startswith("CPU")
    viewer.time_runs = False
    while not viewer.at_rest and now < 60:
        now += 0.1
        viewer.frame(now)
    assert viewer.message is None
    same = sized(scene, 96, 72, 4, 1)
    same.camera = viewer.pose.camera()
    np.testing.assert_array_equal(viewer.presenter.picture()[..., :3], glimt.render(same, time=viewer.time))
    viewer.presenter.close()


def test_a_flight_measures_one_engine_or_none(monkeypatch):
    _lose_at_submission(monkeypatch, 5)
    with pytest.raises(GlimtError, match=r"llvmpipe.* failed during the flight"):
        flight.measure(_scene(1), (64, 48), 0, None, 1.0, 1 / 30, None, "gpu")
