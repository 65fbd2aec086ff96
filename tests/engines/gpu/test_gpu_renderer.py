"""A renderer on the GPU, as a program uses it: changes between frames, scenes at the edge, cancelled renders."""

import threading
from pathlib import Path

import numpy as np
import pytest
from both_engines import assert_same_counts, assert_same_picture, on_cpu, on_gpu, shared_engine

import glimt
from glimt import (
    Camera,
    DirectionalLight,
    Instance,
    Material,
    Mesh,
    PointLight,
    RenderSettings,
    Scene,
    Sphere,
    SpotLight,
    Texture,
    linalg,
)
from glimt.engines.gpu.engine import GpuEngine
from glimt.errors import GlimtError, RenderCancelled
from glimt.layout import FACE, MISS, dtype

pytestmark = pytest.mark.usefixtures("software_gpu")

SETTINGS = RenderSettings(48, 36, samples=2, max_bounces=2)


def _grid(size, material=None):
    """Return a wavy square of 2 size² triangles."""
    x, z = np.meshgrid(np.linspace(-2, 2, size + 1), np.linspace(-2, 2, size + 1))
    positions = np.stack([x, 0.2 * np.sin(3 * x) * np.cos(2 * z), z], -1).reshape(-1, 3)
    at = (np.arange(size)[:, None] * (size + 1) + np.arange(size)).ravel()
    triangles = np.concatenate([np.stack([at, at + size + 1, at + 1], 1),
                                np.stack([at + 1, at + size + 1, at + size + 2], 1)])
    texcoords = (positions[:, [0, 2]] + 2) / 4
    return Mesh(positions, triangles, None, texcoords, [material or Material(diffuse=0.7)])


def _scene():
    scene = Scene(camera=Camera((1, 3, 6), (0, 0.3, 0)), settings=SETTINGS)
    return scene.add(Instance(_grid(6), linalg.translation((0, -0.2, 0))), Sphere((0.5, 0.8, 0), 0.6, Material(
        reflectivity=0.5)), PointLight(position=(2, 4, 3), radius=5), DirectionalLight(direction=(1, -2, -1)))


def _texture(seed):
    return Texture(np.random.default_rng(seed).random((16, 16, 3)).astype(np.float32))


def _swap_texture(scene):
    scene.objects[0] = Instance(_grid(6, Material(diffuse_texture=_texture(2))))


CHANGES = {
    "camera": lambda scene: setattr(scene.camera, "position", (-2, 2, 5)),
    "settings": lambda scene: setattr(scene, "settings", RenderSettings(61, 23, samples=1, max_bounces=1)),
    "light moved": lambda scene: setattr(scene.lights[0], "position", (-3, 2, 1)),
    "light removed": lambda scene: scene.lights.pop(),
    "lights added": lambda scene: scene.add(*(
        SpotLight(position=(k / 3 - 2, 2, 1), direction=(0, -1, 0), diffuse=0.2, radius=3) for k in range(20))),
    "no lights": lambda scene: scene.lights.clear(),
    "sphere moved": lambda scene: setattr(scene.objects[1], "center", (-0.5, 1, 0.5)),
    "instance moved": lambda scene: scene.objects.__setitem__(
        0, Instance(scene.objects[0].mesh, linalg.compose(linalg.rotation((0, 1, 0), 30), linalg.scaling(2)))),
    "instances added": lambda scene: scene.add(*(
        Instance(scene.objects[0].mesh, linalg.translation((k / 5, k / 9, -k / 4))) for k in range(30))),
    "material": lambda scene: scene.objects.__setitem__(
        0, Instance(scene.objects[0].mesh, material=Material(diffuse=(0.2, 0.9, 0.1), reflectivity=0.3))),
    "texture": lambda scene: _swap_texture(scene),
    "vertices": lambda scene: scene.objects.__setitem__(
        0, Instance(scene.objects[0].mesh.with_positions(scene.objects[0].mesh.positions * np.float32(0.7)))),
    "larger mesh": lambda scene: scene.objects.__setitem__(0, Instance(_grid(60, Material(
        diffuse_texture=_texture(3))))),
    "mesh added": lambda scene: scene.add(Instance(_grid(3), linalg.translation((0, 1, -1)))),
    "mesh removed": lambda scene: scene.objects.pop(0),
    "nothing left": lambda scene: scene.objects.clear(),
}


@pytest.mark.parametrize("name", CHANGES)
def test_a_change_shows_as_in_a_fresh_renderer(name):
    scene = _scene()
    renderer = on_gpu(scene, _long_lived())
    before = renderer.render().sums.copy()
    CHANGES[name](scene)
    renderer.update()
    after = renderer.render()
    fresh = on_gpu(scene).render()  # the other engine has seen other scenes
    assert after.sums.tobytes() == fresh.sums.tobytes()
    assert after.counters == fresh.counters
    assert after.sums.shape != before.shape or (after.sums != before).any()
    wanted = on_cpu(scene).render()
    assert_same_picture(after.image(), wanted.image())
    assert_same_counts(after.counters, wanted.counters)


_engines = {}


def _long_lived():
    """Return an engine that has all these changes in its past."""
    if not _engines:
        _engines["one"] = GpuEngine()
    return _engines["one"]


def test_changes_one_after_the_other():
    scene = _scene()
    renderer = on_gpu(scene, _long_lived())
    for name, change in CHANGES.items():
        if name in ("no lights", "mesh removed", "nothing left"):
            continue
        change(scene)
        renderer.update()
        assert renderer.render().sums.tobytes() == on_gpu(scene).render().sums.tobytes(), name


@pytest.mark.parametrize("things", [[], [Sphere((0, 0, 0), 1)], [PointLight(position=(1, 1, 1))], [_grid(2)], [
    Mesh(np.zeros((0, 3)), np.zeros((0, 3), int)), Sphere((0, 0, 0), 1)]],
    ids=["empty", "sphere", "light", "unlit", "no triangles"])
def test_scenes_at_the_edge(things):
    scene = Scene(camera=Camera((0, 2, 4), (0, 0, 0)), settings=RenderSettings(
        33, 17, samples=1, max_bounces=1, background=(0.1, 0.2, 0.3), ambient=0.2)).add(*things)
    cpu, gpu = on_cpu(scene), on_gpu(scene)
    got, wanted = gpu.render(), cpu.render()
    assert_same_picture(got.image(), wanted.image())
    assert got.counters == wanted.counters
    for view in ("depth", "instances", "shadows"):
        np.testing.assert_allclose(gpu.render_debug(view).values, cpu.render_debug(view).values, rtol=1e-5, atol=1e-5)
    assert (gpu.pick(16, 8) is None) == (cpu.pick(16, 8) is None)


def test_samples_that_are_not_finite_are_dropped_and_counted():
    scene = _scene()
    scene.lights[0].diffuse = (3e38, 0.0, 0.0)  # what the checks of a constructor would refuse
    scene.objects[0].mesh.materials[0].diffuse = (1e30, 1.0, 1.0)
    got, wanted = on_gpu(scene).render(), on_cpu(scene).render()
    assert got.counters.non_finite > 100
    assert got.counters.non_finite == pytest.approx(wanted.counters.non_finite, abs=2)
    assert np.isfinite(got.sums).all()


def test_samples_too_large_to_add_up_are_dropped_and_counted():
    settings = RenderSettings(8, 8, samples=2, background=(1, 1, 1))
    settings.background = (2e38, 0.0, 0.0)
    film = on_gpu(Scene(settings=settings)).render()
    assert film.counters.non_finite == film.counters.primary == 256
    assert (film.sums == (0, 0, 0, 4)).all()


def test_rays_that_look_nowhere_and_none_at_all():
    renderer = on_gpu(_scene())
    renderer.render()
    rays = np.array([[0.5, 5, 0, 0, -1, 0, np.inf], [0.5, 5, 0, 0, -1, 0, 1], [0.5, 5, 0, 0, -2, 0, 3],
                     [0.5, 5, 0, 0, -1, 0, 0]], np.float32).T
    hits = renderer._engine.find_hits(rays)
    assert hits.inst.tolist() == [1, MISS, 1, MISS]
    np.testing.assert_allclose(hits.t, [3.6, np.inf, 1.8, np.inf], rtol=1e-5)
    assert [part.shape for part in renderer._engine.find_hits(rays[:, :0])] == [(0,)] * 5


def test_rays_from_so_far_that_every_box_may_be_met():
    """Also boxes inside out, of children that are not there."""
    scene = Scene().add(*(Sphere((0.3 * k, 0, 0), 0.1) for k in range(11)), Instance(_grid(3)))
    ways = linalg.normalize(np.random.default_rng(3).normal(size=(256, 3)))
    far = np.concatenate([2e7 * ways, -ways, np.full((256, 1), np.inf)], 1).astype(np.float32).T
    near = np.concatenate([4 * ways, -ways, np.full((256, 1), np.inf)], 1).astype(np.float32).T
    renderer, other = on_gpu(scene), on_cpu(scene)
    renderer.render()
    other.render()
    got, wanted = (one._engine.find_hits(near).inst for one in (renderer, other))
    assert len(set(wanted.tolist())) > 5
    assert (got == wanted).mean() > 0.99
    got, wanted = (one._engine.find_hits(far).inst for one in (renderer, other))  # all at the same t, give or take 2
    assert 0.1 < (wanted != MISS).mean() < 1
    assert ((got == MISS) == (wanted == MISS)).mean() > 0.95
    assert ((got == MISS) | (got < 12)).all()


def test_an_engine_without_a_scene_says_so():
    engine = GpuEngine()
    view, tints = np.zeros(21, np.float32), np.zeros((0, 3), np.float32)
    for ask in (lambda: engine.render(view, (8, 8), 1, 0), lambda: engine.render_debug(view, (8, 8), "depth", tints),
                lambda: engine.find_hits(np.zeros((7, 1), np.float32))):
        with pytest.raises(GlimtError, match="no scene was uploaded"):
            ask()


def test_a_film_is_written_over_and_tells_how_far_it_is():
    renderer, told = on_gpu(_scene()), []
    film = renderer.render()
    wanted = film.sums.copy()
    film.sums[:] = 7
    again = renderer.render(film=film, progress=lambda stage, share: told.append((stage, share)))
    assert again.sums is film.sums
    np.testing.assert_array_equal(again.sums, wanted)
    assert told[0] == ("rendering", 0.0)


def test_adaptive_is_four_by_four_everywhere():
    scene = _scene()
    renderer = on_gpu(scene)
    scene.settings = RenderSettings(24, 18, samples="adaptive", max_bounces=1)
    adaptive = renderer.render()
    scene.settings = RenderSettings(24, 18, samples=4, max_bounces=1)
    assert adaptive.sums.tobytes() == renderer.render().sums.tobytes()


def test_a_cancelled_render_stops_and_the_next_one_is_whole():
    scene = _scene()
    renderer = on_gpu(scene)
    before = renderer.render()
    scene.settings = RenderSettings(2048, 2048, samples=16, max_bounces=2)
    began = threading.Event()

    def cancel():
        began.wait()
        renderer.cancel()

    thread = threading.Thread(target=cancel)
    thread.start()
    with pytest.raises(RenderCancelled):
        renderer.render(progress=lambda stage, share: began.set())
    thread.join()
    scene.settings = SETTINGS
    renderer.cancel()  # nothing to stop
    after = renderer.render()
    assert after.sums.tobytes() == before.sums.tobytes()
    assert after.counters == before.counters


def test_a_cancel_that_comes_late_does_not_stop_the_next_render():
    """`cancel` has looked which render is at work; that one ends, and another begins."""
    engine, scene = shared_engine(), _scene()
    renderer = on_gpu(scene)
    wanted, running = renderer.render().sums, []
    renderer.render(progress=lambda stage, share: running.append(engine._cancelled))

    def cancel_the_one_before(stage, share):
        running[0].set()

    np.testing.assert_array_equal(renderer.render(progress=cancel_the_one_before).sums, wanted)


def test_a_picture_from_the_top_level_function():
    scene = glimt.load(Path(__file__).resolve().parents[3] / "examples" / "stone_room.toml")
    got, wanted = (glimt.render(scene, size=(40, 30), max_bounces=1, engine=engine) for engine in ("gpu", "cpu"))
    assert_same_picture(got, wanted)


def test_nothing_is_worked_out_that_only_the_cpu_uses():
    renderer = on_gpu(Scene(settings=SETTINGS).add(_grid(20), PointLight(position=(0, 3, 1), radius=9)))
    for _ in range(3):
        renderer.render()
    renderer.settle()
    assert renderer._packer._finder is None
    assert not renderer._packed.faces.view(dtype(FACE))["clearance"].any()
