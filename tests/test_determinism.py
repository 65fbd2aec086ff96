"""The same bits: for any number of threads, on every run, and for every lane width of one processor."""

import dataclasses
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import glimt
from glimt.kernel import host_lanes

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"

_RENDER = """
import dataclasses, sys, numpy, glimt
scene = glimt.load(sys.argv[1])
scene.settings = dataclasses.replace(scene.settings, width=97, height=61, samples=2, max_bounces=3)
numpy.save(sys.argv[2], glimt.Renderer(scene).render().sums)
"""


def stone_room(width, height):
    scene = glimt.load(EXAMPLES / "stone_room.toml")
    scene.settings = dataclasses.replace(scene.settings, width=width, height=height, samples=2, max_bounces=3)
    return scene


@pytest.mark.parametrize("size", [(200, 150), (97, 61), (1, 1)])
def test_threads_do_not_matter(size):
    scene = stone_room(*size)
    films = [glimt.Renderer(scene, threads=threads).render() for threads in (1, 2, 5)]
    assert films[0].counters.rays > 0
    for film in films[1:]:
        assert film.sums.tobytes() == films[0].sums.tobytes()
        assert film.counters == films[0].counters


def test_runs_do_not_matter():
    renderer = glimt.Renderer(stone_room(97, 61))
    first = renderer.render().sums.tobytes()
    assert all(renderer.render().sums.tobytes() == first for _ in range(5))


@pytest.fixture(scope="module")
def native_film(tmp_path_factory):
    return render_elsewhere(tmp_path_factory.mktemp("native") / "film.npy", {})


def render_elsewhere(path, environment):
    """Render the stone room in a process of its own: a lane width is chosen at import."""
    subprocess.run([sys.executable, "-c", _RENDER, str(EXAMPLES / "stone_room.toml"), str(path)], check=True,
                   env=os.environ | environment, timeout=300)
    return np.load(path)


@pytest.mark.parametrize("lanes", [width for width in (4, 8, 16) if width != host_lanes()])
def test_lane_widths_do_not_matter(lanes, native_film, tmp_path):
    film = render_elsewhere(tmp_path / "film.npy", {"GLIMT_LANES": str(lanes)})
    np.testing.assert_allclose(film, native_film, rtol=1e-5, atol=1e-6)
