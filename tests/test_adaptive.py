"""Adaptive supersampling: few samples where a picture is smooth, those of the 4×4 grid where it is not."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from glimt import Camera, GlimtError, Material, RenderSettings, Scene, Sphere, load, render
from glimt.engines import get_engine
from glimt.kernel import host_features
from glimt.renderer import Renderer

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
CAMERA = Camera((0, 0, 4), (0, 0, 0), fov_deg=40)
BALL = Sphere((0.1, 0.2, 0), 1, material=Material(diffuse=0.8))
WIDTH, HEIGHT = 97, 61
PROGRAM = """
import sys, test_adaptive
sys.stdout.buffer.write(test_adaptive.film_of(test_adaptive.room()).sums.tobytes())
"""


def film_of(scene, samples="adaptive", threads=None, **changes):
    settings = replace(scene.settings, samples=samples, **changes)
    return Renderer(replace(scene, settings=settings), threads=threads).render()


def room():
    """Normal maps, mirrors and shadows, at a size that is a multiple of nothing."""
    scene = load(EXAMPLES / "stone_room.toml")
    scene.settings = replace(scene.settings, width=WIDTH, height=HEIGHT, max_bounces=3)
    return scene


def ball(**settings):
    """Light from everywhere: a disc of one colour."""
    return Scene([BALL], camera=CAMERA, settings=RenderSettings(WIDTH, HEIGHT, ambient=0.9, **settings))


@pytest.fixture(scope="module")
def adaptive():
    return film_of(room())


def test_a_flat_background_costs_one_sample_a_pixel():
    scene = Scene(camera=CAMERA, settings=RenderSettings(WIDTH, HEIGHT, background=(0.2, 0.5, 0.7)))
    film = film_of(scene)
    assert (film.sums == np.float32([0.2, 0.5, 0.7, 1])).all()
    assert film.counters.rays == WIDTH * HEIGHT


def test_counters_tell_what_was_traced(adaptive):
    samples = adaptive.sums[..., 3]
    assert set(np.unique(samples)) == {1, 5, 9, 13, 16}
    replaced = samples == 16  # the first sample was traced, and is not among them
    assert adaptive.counters.primary == samples.sum() + replaced.sum()


def test_pixels_are_those_of_the_grid_where_it_is_full(adaptive):
    grid = film_of(room(), 4)
    full = adaptive.sums[..., 3] == 16
    assert full.sum() > 100
    np.testing.assert_allclose(adaptive.sums[full], grid.sums[full], rtol=1e-5, atol=1e-6)


def test_the_picture_is_close_to_that_of_the_grid():
    scene = load(EXAMPLES / "stone_room.toml")
    films = [film_of(scene, samples, width=400, height=400, max_bounces=3) for samples in ("adaptive", 4)]
    images = [film.image().astype(int) for film in films]
    assert (np.abs(images[0] - images[1]).max(-1) <= 4).mean() > 0.995
    assert films[0].counters.rays < 0.36 * films[1].counters.rays


def test_only_the_edge_of_a_disc_takes_more_samples():
    film, grid = film_of(ball()), film_of(ball(), 4)
    mixed = (grid.radiance[..., 0] > 0.01) & (grid.radiance[..., 0] < 0.7)
    more = film.sums[..., 3] > 1
    assert mixed.sum() > 50
    assert more[mixed].all()
    inner = np.zeros_like(more)
    inner[25:30, 45:55] = True
    assert not more[inner].any()
    assert not more[:2].any()
    assert np.abs(film.radiance - grid.radiance).max() < 0.2


def test_what_counts_is_the_developed_picture():
    """An edge in what is shown black or white needs no samples; filmic white is not reached so soon."""
    def more(**settings):
        return (film_of(ball(**settings)).sums[..., 3] > 1).sum()

    assert more() > 50
    assert more(exposure=-20) == 0
    assert more(exposure=20, background=0.5) == 0
    assert more(exposure=0.5, background=3) == 0
    assert more(exposure=0.5, background=3, tone_curve="filmic") > 50


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_any_number_of_threads_gives_the_same_film(adaptive, threads):
    film = film_of(room(), threads=threads)
    assert film.sums.tobytes() == adaptive.sums.tobytes()
    assert film.counters == adaptive.counters


@pytest.mark.parametrize("size", [(1, 1), (16, 16), (17, 33), (200, 3)])
def test_any_size(size):
    film = film_of(room(), width=size[0], height=size[1])
    assert np.isfinite(film.sums).all()
    assert (film.sums[..., 3] >= 1).all()


def test_any_lane_width_gives_the_same_film():
    films = []
    for lanes in ("4", "8", "16"):
        done = subprocess.run([sys.executable, "-c", PROGRAM], env=os.environ | {"GLIMT_LANES": lanes}, timeout=300,
                              cwd=Path(__file__).parent, capture_output=True)
        assert done.returncode == 0, done.stderr.decode()
        films.append(np.frombuffer(done.stdout, np.float32).reshape(HEIGHT, WIDTH, 4))
    if {"avx512f", "avx512vl"} <= host_features():  # others have no reciprocals that are the same at all widths
        assert films[0].tobytes() == films[1].tobytes() == films[2].tobytes()
    for film in films[:2]:
        same = (film[..., 3] == films[2][..., 3]) & np.isclose(film, films[2], rtol=1e-4, atol=1e-5).all(-1)
        assert same.mean() > 0.999


def test_progress_goes_on_to_the_end():
    told = []
    renderer = Renderer(replace(room(), settings=replace(room().settings, samples="adaptive")), threads=2)
    renderer.render(progress=lambda stage, share: told.append(share))
    assert told[0] == 0
    assert told == sorted(told)
    assert told[-1] <= 1


def test_light_that_is_not_finite_is_dropped_and_counted():
    scene = ball(samples="adaptive")
    scene.settings.background = (2e38, 0.0, 0.0)  # what the checks of a constructor would refuse
    film = Renderer(scene).render()
    assert film.counters.non_finite > 0
    assert np.isfinite(film.sums).all()
    assert (film.sums[0, 0] == [0, 0, 0, 1]).all()


def test_render_takes_it():
    image = render(room(), samples="adaptive")
    assert (image == film_of(room()).image()).all()


@pytest.mark.parametrize("value", ["Adaptive", "", "2.5", "x" * 1000])
def test_other_words_are_refused(value):
    with pytest.raises(GlimtError, match=r"settings: samples is .*, expected 1 to 64 or 'adaptive'"):
        RenderSettings(samples=value)


def test_a_scene_file_says_so(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text('[render]\nsamples = "adaptive"\n[[light]]\ntype = "directional"\ndirection = [0, -1, 0]\n'
                    "[[sphere]]\ncenter = [0, 0, 0]\nradius = 1\n")
    assert load(path).settings.samples == "adaptive"
    path.write_text('[render]\nsamples = "many"\n')
    with pytest.raises(GlimtError, match=r"scene.toml:2: render.samples: is 'many', expected 1 to 64 or 'adaptive'"):
        load(path)


def test_an_engine_needs_a_scene():
    with pytest.raises(GlimtError, match="no scene was uploaded"):
        get_engine().render(np.zeros(21, np.float32), (4, 4), "adaptive", 0)
