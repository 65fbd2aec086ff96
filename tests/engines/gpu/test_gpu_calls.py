"""What a frame asks of wgpu: each call costs the host some microseconds, and a wait more than that."""

from collections import Counter
from pathlib import Path

import pytest
from both_engines import on_gpu, sized

import glimt
from glimt.engines.gpu.adapters import import_wgpu

STONE_ROOM = Path(__file__).resolve().parents[3] / "examples" / "stone_room.toml"


@pytest.fixture
def calls(software_gpu, monkeypatch):
    """Return how often functions of wgpu-native are called from now on, by their names."""
    counted = Counter()
    import_wgpu()
    from wgpu.backends.wgpu_native import _api as api

    def count(name, function):
        def counting(*given):
            counted[name] += 1
            return function(*given)

        return counting

    for name in dir(api.libf):
        if name.startswith("wgpu"):
            monkeypatch.setattr(api.libf, name, count(name, getattr(api.libf, name)))
    return counted


@pytest.mark.parametrize("bounces", [0, 3])
def test_a_frame_is_one_submission_and_one_wait(calls, bounces):
    renderer = on_gpu(sized(glimt.load(STONE_ROOM), 48, 36, 1, bounces))
    for _ in range(3):
        film = renderer.render()
    renderer.scene.camera.position = (0.1, 1.0, 0.2)
    renderer.scene.lights[0].diffuse = (0.5, 0.5, 0.5)
    calls.clear()
    renderer.render(film=film)
    once = {"wgpuQueueSubmit", "wgpuBufferMapAsync", "wgpuBufferUnmap", "wgpuDeviceCreateCommandEncoder",
            "wgpuCommandEncoderFinish"}
    assert {name: calls[name] for name in once} == dict.fromkeys(once, 1)
    assert calls["wgpuQueueWriteBuffer"] == 3  # what dispatches are told, lights, counters
    assert not [name for name in calls if name.startswith("wgpuDeviceCreate") and name not in once]
    device = renderer._engine._device
    if device.has_inner_timestamps:
        assert calls["wgpuCommandEncoderBeginComputePass"] == 1
        assert calls.total() <= 25 + 8 * bounces  # without those that wgpu has bound elsewhere
