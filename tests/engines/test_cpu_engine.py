"""The CPU engine around its kernels: stopping, counting, memory, errors."""

import resource
import signal
import threading
import time

import numpy as np
import pytest

import glimt
from glimt.engines import get_engine
from glimt.engines.cpu.kernels.traverse import TRACE
from glimt.errors import GlimtError
from glimt.kernel import KERNELS

SIZE = 64


@pytest.fixture
def scene():
    scene = glimt.Scene(settings=glimt.RenderSettings(SIZE, SIZE, max_bounces=1, background=0.2))
    floor = glimt.Mesh([[-9, 0, -9], [9, 0, -9], [9, 0, 9], [-9, 0, 9]], [[0, 2, 1], [0, 3, 2]])
    scene.add(floor, glimt.Sphere((0, 1, 0), 1.0, glimt.Material(reflectivity=0.5)),
              glimt.PointLight(position=(2, 4, 3), radius=5))
    scene.camera = glimt.Camera((0, 2, 6), (0, 1, 0))
    return scene


def test_ctrl_c_stops_at_once_and_the_engine_goes_on(scene):
    scene.settings = glimt.RenderSettings(8192, 8192, samples=32, max_bounces=1)
    renderer = glimt.Renderer(scene)
    sent = []

    def interrupt():
        sent.append(time.perf_counter())
        signal.raise_signal(signal.SIGINT)

    timer = threading.Timer(1.0, interrupt)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        renderer.render()
    assert time.perf_counter() - sent[0] < 0.5
    scene.settings = glimt.RenderSettings(SIZE, SIZE)
    assert renderer.render().counters.primary == SIZE * SIZE


@pytest.mark.parametrize("samples", [1, 2, 3])
def test_rays_are_counted(scene, samples):
    scene.settings.samples = samples
    counters = glimt.Renderer(scene).render().counters
    assert counters.primary == SIZE * SIZE * samples**2
    assert 0 < counters.mirror < counters.primary
    assert 0 < counters.shadow <= counters.primary + counters.mirror
    assert counters.rays == counters.primary + counters.shadow + counters.mirror
    assert counters.non_finite == 0


def test_samples_that_are_not_finite_are_dropped_and_counted(scene):
    scene.lights[0].diffuse = (3e38, 0.0, 0.0)  # what the checks of a constructor would refuse
    scene.objects[0].mesh.materials[0].diffuse = (1e30, 1.0, 1.0)
    film = glimt.Renderer(scene).render()
    assert film.counters.non_finite > 0
    assert np.isfinite(film.sums).all()


def test_samples_too_large_to_add_up_are_dropped_and_counted(scene):
    """Each is finite, the sum of four would not be."""
    scene.settings = glimt.RenderSettings(SIZE, SIZE, samples=2)
    scene.settings.background = (2e38, 0.0, 0.0)
    film = glimt.Renderer(glimt.Scene(settings=scene.settings)).render()
    assert film.counters.non_finite == film.counters.primary
    assert (film.sums == [0, 0, 0, 4]).all()


def test_ctrl_c_while_work_is_handed_out_leaves_no_job_behind(scene, monkeypatch):
    """Else it would take tiles away from the next film."""
    scene.settings = glimt.RenderSettings(2048, 2048, samples=8)
    renderer = glimt.Renderer(scene, threads=2)
    team = renderer._engine._team
    give, given = team.give, []

    def interrupted(number, jobs, job):
        if given:
            raise KeyboardInterrupt
        give(number, jobs, job)
        given.append(jobs)

    with monkeypatch.context() as patched:
        patched.setattr(team, "give", interrupted)
        with pytest.raises(KeyboardInterrupt):
            renderer.render()
    assert given[0].have_ended(0.0)
    scene.settings = glimt.RenderSettings(SIZE, SIZE)
    assert renderer.render().sums[..., 3].min() == 1


def test_memory_does_not_grow_over_frames(scene):
    renderer = glimt.Renderer(scene)

    def frames(count):
        for i in range(count):
            scene.camera = glimt.Camera((0.01 * i, 2, 6), (0, 1, 0))
            scene.lights[0].position = (2, 4, 3 + 0.01 * i)
            renderer.render(0.1 * i).image()
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

    before = frames(50)
    assert frames(500) - before < 10_000  # KiB


def test_every_scene_uses_the_same_machine_code(scene):
    glimt.render(scene)
    textured = glimt.Material(diffuse_texture=glimt.Texture(np.full((4, 4, 3), 200, np.uint8)))
    mesh = glimt.Mesh(np.eye(3), [[0, 1, 2]], normals=np.ones((3, 3)), texcoords=np.zeros((3, 2)),
                      materials=[textured])
    glimt.render(glimt.Scene().add(glimt.Instance(mesh, np.eye(4))), size=(16, 16))
    glimt.render(glimt.Scene(), size=(16, 16))
    ours = [kernel for kernel in KERNELS if kernel.py_func.__module__.startswith("glimt.engines")]
    assert len(ours) >= 1
    assert all(len(kernel.signatures) <= 1 for kernel in ours)
    assert len(TRACE.overloads) == 1


@pytest.mark.parametrize("threads", [0, -1, 100_000])
def test_a_strange_number_of_threads_is_refused(threads):
    with pytest.raises(GlimtError, match="threads"):
        get_engine("cpu", threads)


def test_an_unknown_engine_is_refused():
    with pytest.raises(GlimtError, match="'gpuu'"):
        get_engine("gpuu")


def test_rendering_needs_a_scene():
    with pytest.raises(GlimtError, match="no scene"):
        get_engine("cpu").render(np.zeros(20, np.float32), (4, 4), 1, 0)


def test_progress_is_told(scene):
    told = []
    scene.settings = glimt.RenderSettings(1024, 1024, samples=4)
    glimt.Renderer(scene, progress=lambda stage, share: told.append((stage, share))).render(
        0.0, lambda stage, share: told.append((stage, share)))
    assert {stage for stage, _ in told} >= {"building trees", "rendering"}
    assert all(0 <= share <= 1 for _, share in told)


def test_a_film_may_be_written_over(scene):
    renderer = glimt.Renderer(scene)
    first = renderer.render()
    kept = first.sums.copy()
    scene.lights[0].diffuse = (0.0, 0.0, 0.0)
    second = renderer.render(film=first)
    assert second.sums is first.sums
    assert not np.array_equal(second.sums, kept)
    scene.settings = glimt.RenderSettings(SIZE, 2 * SIZE)
    assert renderer.render(film=second).sums.shape == (2 * SIZE, SIZE, 4)  # another size: a new film


def test_a_picture_is_ready_when_its_kernel_is(scene, monkeypatch):
    renderer = glimt.Renderer(scene)
    pictures = [(1, None), ("adaptive", None), (1, "nodes"), (1, "depth")]
    for missing, ready in (("", [True] * 4), ("refine_tiles", [True, False, True, True]),
                           ("count_visits", [True, True, False, True]), ("debug_tiles", [True, True, True, False])):
        monkeypatch.setattr("glimt.engines.cpu.engine.is_ready",
                            lambda kernel, missing=missing: kernel.py_func.__name__ != missing)
        assert [renderer.is_ready(*picture) for picture in pictures] == ready
