"""Mirror rays of a block close ranks after every bounce: which of them share a packet then changes nothing."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from glimt import load
from glimt.kernel import host_features
from glimt.renderer import Renderer

HALL = Path(__file__).resolve().parents[2] / "examples" / "mirrors.toml"
BOUNCES = 10
SIZES = [(61, 43), (16, 16), (9, 1)]
"""No whole number of blocks; whole tiles; one row."""

_PROGRAM = """
import sys
import numpy
from test_bounces import SIZES, film
films = [film(size, 1) for size in SIZES]
numpy.savez(sys.argv[1], *[film.sums for film in films], counts=[film.counters for film in films])
"""


def film(size, threads, bounces=BOUNCES):
    scene = load(HALL)
    scene.settings = replace(scene.settings, width=size[0], height=size[1], samples=2, max_bounces=bounces)
    return Renderer(scene, threads=threads).render()


@pytest.mark.parametrize("size", SIZES, ids=str)
def test_any_number_of_threads_gives_the_same_film(size):
    alone = film(size, 1)
    assert alone.counters.mirror > 0
    for threads in (2, 7):
        together = film(size, threads)
        assert together.sums.tobytes() == alone.sums.tobytes()
        assert together.counters == alone.counters


@pytest.fixture(scope="module", params=[4, 8, 16])
def films(request, tmp_path_factory):
    """Films of a process with another lane width, whose packets and blocks have other shapes."""
    path = tmp_path_factory.mktemp(f"bounces{request.param}") / "films.npz"
    variables = {"GLIMT_LANES": str(request.param),
                 "PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), *filter(None, sys.path)])}
    done = subprocess.run([sys.executable, "-c", _PROGRAM, str(path)], env=os.environ | variables, timeout=300,
                          capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    with np.load(path) as stored:
        return dict(stored)


def test_every_lane_width_gives_the_same_film(films):
    for k, size in enumerate(SIZES):
        ours, theirs = film(size, 1), films[f"arr_{k}"]
        if {"avx512f", "avx512vl"} <= host_features():
            assert theirs.tobytes() == ours.sums.tobytes()
            assert films["counts"][k].tolist() == list(ours.counters)
        else:  # a ray in many may pass an edge on the other side
            assert (np.abs(theirs - ours.sums) > 1e-3).any(-1).mean() < 0.01


def test_a_bounce_more_adds_its_rays_and_no_others():
    rays = [film(SIZES[0], 1, bounces).counters.mirror for bounces in range(BOUNCES + 1)]
    added = np.diff(rays)
    assert rays[0] == 0
    assert (added > 0).all()
    assert (np.diff(added) < 0).all()  # at every bounce some rays meet no mirror
