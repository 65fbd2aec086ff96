"""The same picture to the bit, whatever the threads and the lanes."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from glimt import load
from glimt.debug_view import DEBUG_VIEWS
from glimt.kernel import host_features
from glimt.renderer import Renderer

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
SIZES = [(200, 150), (97, 61), (1, 1)]


@pytest.fixture(scope="module", params=SIZES, ids=str)
def scene(request):
    """Textures, instances, spheres, mirrors; one size is a multiple of nothing."""
    scene = load(EXAMPLES / "stone_room.toml")
    width, height = request.param
    scene.settings = replace(scene.settings, width=width, height=height, samples=2, max_bounces=3)
    return scene


@pytest.fixture(scope="module")
def film(scene):
    return Renderer(scene, threads=1).render()


@pytest.mark.parametrize("threads", [1, 2, 5, 64])
def test_any_number_of_threads_gives_the_same_film(scene, film, threads):
    renderer = Renderer(scene, threads=threads)
    for _ in range(3):
        again = renderer.render()
        assert again.sums.tobytes() == film.sums.tobytes()
        assert again.counters == film.counters


def test_every_sample_is_counted(scene, film):
    width, height = scene.settings.width, scene.settings.height
    assert film.counters.primary == width * height * 4
    assert (film.sums[..., 3] == 4).all()
    assert film.counters.mirror > 0
    assert film.counters.non_finite == 0


def test_a_picture_is_part_of_no_other(scene, film):
    """Frames in between, of another size and time, leave nothing behind."""
    renderer = Renderer(replace(scene, settings=replace(scene.settings)), threads=2)
    renderer.scene.settings.width, renderer.scene.settings.samples = 31, 1
    renderer.render(time=3.0)
    renderer.scene.settings = scene.settings
    assert renderer.render().sums.tobytes() == film.sums.tobytes()


# ---- other lane widths and processors, each a process of its own ----------------------------------------------------

WIDTHS = [4, 8, 16]
OLD_PROCESSOR = "nehalem"
OLD_FEATURES = frozenset(["64bit", "cmov", "cx8", "cx16", "fxsr", "mmx", "popcnt", "sse", "sse2", "sse3", "ssse3",
                          "sse4.1", "sse4.2"])
"""x86-64-v2, LLVM's names."""


def picture(folder, **environment):
    """Return what `picture.py` writes in a process with these variables set."""
    path = folder / "picture.npz"
    script = Path(__file__).with_name("picture.py")
    done = subprocess.run([sys.executable, str(script), str(path)], env=os.environ | environment, timeout=300,
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    with np.load(path) as stored:
        return dict(stored)


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    return {width: picture(tmp_path_factory.mktemp(f"lanes{width}"), GLIMT_LANES=str(width)) for width in WIDTHS}


def same_radiance(ours, theirs, relative):
    """Pixels agree, but for those few where a ray may pass an edge on the other side."""
    differ = (np.abs(ours - theirs) > relative * np.maximum(np.abs(ours), 0.01)).any(-1)
    assert differ.mean() < 1e-3, f"{differ.sum()} of {differ.size} pixels differ, by {np.abs(ours - theirs).max()}"


def same_debug_views(ours, theirs):
    """Pixels agree, but for those few where a ray may pass an edge of a triangle or a box on the other side.

    Of boxes that begin in one plane, rounding says which is walked first, and so how many nodes are.
    """
    for view, a, b in zip(DEBUG_VIEWS, ours, theirs, strict=True):
        if view == "instances":
            a, b = a.view(np.int32), b.view(np.int32)
        differ = (np.abs(a - b) > 1e-3).any(-1)
        assert differ.mean() < (0.05 if view == "nodes" else 2e-3), f"{view}: {differ.sum()} of {differ.size} differ"


@pytest.mark.parametrize("width", WIDTHS)
def test_every_lane_width_gives_the_same_picture(pictures, width):
    assert pictures[width]["lanes"] == width
    assert pictures[width]["wrong_hits"] == 0
    assert pictures[width]["wrong_shadows"] == 0
    if {"avx512f", "avx512vl"} <= host_features():
        assert pictures[width]["radiance"].tobytes() == pictures[16]["radiance"].tobytes()
        assert pictures[width]["debug"].tobytes() == pictures[16]["debug"].tobytes()
    same_radiance(pictures[width]["radiance"], pictures[16]["radiance"], 1e-5)
    same_debug_views(pictures[width]["debug"], pictures[16]["debug"])


@pytest.mark.skipif(not host_features() >= OLD_FEATURES, reason="not an x86-64 processor")
def test_an_old_processor_gives_the_same_picture(pictures, tmp_path):
    """Without fused multiply-adds, approximate reciprocals, gathers and masks."""
    features = ",".join(("+" if name in OLD_FEATURES else "-") + name for name in sorted(host_features()))
    made = picture(tmp_path, GLIMT_LANES="4", NUMBA_CPU_NAME=OLD_PROCESSOR, NUMBA_CPU_FEATURES=features)
    assert made["wrong_hits"] == made["wrong_shadows"] == 0
    same_radiance(made["radiance"], pictures[16]["radiance"], 1e-4)
    same_debug_views(made["debug"], pictures[16]["debug"])
