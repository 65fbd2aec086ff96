"""The frame loop: what a frame does not do again, and memory over thousands of frames."""

import gc
import tracemalloc

import numpy as np
import pytest

from glimt import Camera, DirectionalLight, Instance, Mesh, Orbit, PointLight, Renderer, RenderSettings, Scene, linalg
from glimt.layout import LIGHT, dtype

TRIANGLE = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])


@pytest.fixture
def scene():
    scene = Scene(camera=Camera(), settings=RenderSettings(16, 16))
    return scene.add(TRIANGLE, DirectionalLight(direction=(0, 0, -1)), PointLight(position=(1, 1, 1)))


def lights(renderer):
    return renderer._packed.lights.view(dtype(LIGHT))


def test_a_moved_camera_packs_nothing_again(scene):
    renderer = Renderer(scene)
    film = renderer.render()
    packed = renderer._packed
    scene.camera.position = (0.5, 0, 4)
    scene.settings.background = (1.0, 0.0, 0.0)
    moved = renderer.render(7.0, film=film)
    assert renderer._packed is packed
    assert moved.sums is film.sums
    assert moved.radiance[0, 0].tolist() == [1, 0, 0]


def test_changed_lights_pack_the_lights_alone(scene):
    renderer = Renderer(scene)
    renderer.render()
    before = renderer._packed
    scene.lights[1].position = (2, 3, 4)
    renderer.render()
    after = renderer._packed
    assert [name for name in before._fields if getattr(before, name) is not getattr(after, name)] == ["lights"]
    assert lights(renderer)["position"][1].tolist() == [2, 3, 4]


@pytest.mark.parametrize(("field", "value", "expected"), [
    ("diffuse", (1, 2, 3), [1, 2, 3]), ("diffuse", 0.5, [0.5] * 3), ("specular", np.float32([3, 2, 1]), [3, 2, 1]),
    ("attenuation", [1, 0, 2], [1, 0, 2]), ("position", np.array([9, 8, 7]), [9, 8, 7]),
    ("position", [1, 0, 1], [1, 0, 1])])
def test_a_light_changed_in_place_is_noticed(scene, field, value, expected):
    renderer = Renderer(scene)
    renderer.render()
    setattr(scene.lights[1], field, value)
    renderer.render()
    assert lights(renderer)[field][1].tolist() == expected
    if isinstance(value, np.ndarray | list):
        value[0] = 5
        renderer.render()
        assert lights(renderer)[field][1].tolist() == [5, *expected[1:]]


def test_time_moves_lights_that_have_a_motion_only(scene):
    renderer = Renderer(scene)
    renderer.render(0.0)
    packed = renderer._packed
    renderer.render(1.0)
    assert renderer._packed is packed
    scene.lights[1].motion = Orbit((0, 1, 0), (0, 1, 0), 4)
    renderer.render(1.0)
    assert lights(renderer)["position"][1] == pytest.approx([1, 1, -1])
    renderer.render(2.0)
    assert lights(renderer)["position"][1] == pytest.approx([-1, 1, -1])


def test_without_a_camera_the_picture_frames_the_objects_of_the_last_update(scene):
    scene.camera = None
    renderer = Renderer(scene)
    first = renderer.render().sums.copy()
    scene.objects[0] = Instance(TRIANGLE, linalg.translation((50, 0, 0)))
    np.testing.assert_array_equal(renderer.render().sums, first)
    renderer.update()
    np.testing.assert_allclose(renderer.render().sums[..., 3], first[..., 3])
    assert renderer.render().radiance.max() > 0
    scene.settings.width = 64
    assert renderer.render().radiance.max() > 0


def test_a_frame_allocates_next_to_nothing_and_keeps_nothing(scene):
    renderer = Renderer(scene)
    film = renderer.render()

    def frames(count):
        nonlocal film
        for k in range(count):
            scene.camera.position = (0.001 * k, 0, 5)
            scene.lights[1].position = (0.001 * k, 1, 1)
            film = renderer.render(0.1 * k, film=film)
        return tracemalloc.get_traced_memory()

    gc.collect()
    gc.disable()  # it lets go of what Python keeps for later, which then grows again; and cycles would be kept as well
    tracemalloc.start()
    try:
        before, _ = frames(2500)  # Python's own tables grow at first
        tracemalloc.reset_peak()
        after, peak = frames(2500)
    finally:
        tracemalloc.stop()
        gc.enable()
    assert after - before < 4000
    assert peak - before < 40_000
