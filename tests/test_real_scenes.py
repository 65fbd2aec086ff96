"""Every OBJ file of the real scenes becomes a picture."""

import dataclasses
import warnings
from pathlib import Path

import numpy as np
import pytest

import glimt

SCENES = Path(__file__).resolve().parents[2] / "shared" / "scenes"
FILES = sorted(path.relative_to(SCENES).as_posix() for path in SCENES.rglob("*.obj"))


@pytest.mark.parametrize("name", FILES or ["none"])
def test_a_real_file_renders(real_scenes, name):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", glimt.GlimtWarning)  # test_obj_real says which are expected
        scene = glimt.load(real_scenes / name)
        scene.settings = dataclasses.replace(scene.settings, width=96, height=72, samples=2, max_bounces=2)
        film = glimt.Renderer(scene).render()
    assert film.counters.non_finite == 0
    assert np.isfinite(film.sums).all()
    background = np.asarray(scene.settings.background, np.float32)
    shown = (np.abs(film.radiance - background) > 1e-3).any(-1)
    assert shown.mean() > 0.02  # the object is in the picture


def test_there_are_real_files(real_scenes):
    assert len(FILES) >= 20
