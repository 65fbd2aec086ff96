"""A thousand frames in which everything moves take no more memory than the first ones, here or on the GPU."""

import gc
import os
from pathlib import Path

import numpy as np
import pytest
from both_engines import on_gpu

from glimt import Camera, Instance, Material, Mesh, PointLight, RenderSettings, Scene, Sphere, linalg
from glimt.engines.gpu.engine import GpuEngine

STATM = Path("/proc/self/statm")
SQUARE = Mesh([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]], [[0, 2, 1], [0, 3, 2]])
TRIANGLE = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])

pytestmark = pytest.mark.usefixtures("software_gpu")


def _resident_bytes():
    return int(STATM.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def _counts():
    """Return how many objects of each kind wgpu holds, without those that a cycle keeps until it is collected."""
    import wgpu

    gc.collect()
    return {kind: counts["count"] for kind, counts in wgpu.diagnostics.object_counts.get_dict().items()}


def _moving_scene():
    scene = Scene(camera=Camera((1, 3, 6)), settings=RenderSettings(24, 16, max_bounces=1))
    return scene.add(Instance(SQUARE, linalg.scaling(5)), Sphere((0, 1, 0), 0.7, Material(reflectivity=0.5)),
                     Instance(TRIANGLE), PointLight(position=(0, 3, 0)))


def _frame(renderer, number, film):
    """Render frame `number`: the camera, a light, an instance and how many there are change."""
    scene, angle = renderer.scene, number / 50
    scene.camera.position = (6 * np.sin(angle), 3, 6 * np.cos(angle))
    scene.lights[0].position = (np.cos(angle), 3, np.sin(3 * angle))
    del scene.objects[2:]
    scene.add(*(Instance(TRIANGLE, linalg.compose(linalg.translation((k, 0.5, 0)), linalg.rotation((0, 1, 0), number)))
                for k in range(1 + number % 7)))
    renderer.update()
    return renderer.render(number / 30, film=film)


@pytest.mark.skipif(not STATM.exists(), reason="needs Linux's /proc")
def test_a_thousand_frames(monkeypatch, caplog):
    renderer = on_gpu(_moving_scene(), GpuEngine())
    gpu, made = renderer._engine._device.gpu, []
    create = gpu.create_buffer
    monkeypatch.setattr(gpu, "create_buffer", lambda **given: made.append(given) or create(**given))
    film = None
    for number in range(300):
        film = _frame(renderer, number, film)
    before, resident, buffers = _counts(), _resident_bytes(), len(made)
    for number in range(300, 1000):
        film = _frame(renderer, number, film)
    assert np.isfinite(film.sums).all()
    assert film.sums[..., :3].max() > 0.01
    assert len(made) == buffers
    assert _counts() == before
    assert _resident_bytes() - resident < 4 << 20
    assert not caplog.records


def test_engines_that_are_gone_leave_nothing_behind():
    before = _counts()
    for _ in range(3):
        renderer = on_gpu(_moving_scene(), GpuEngine())
        renderer.render()
        del renderer
    assert _counts() == before
