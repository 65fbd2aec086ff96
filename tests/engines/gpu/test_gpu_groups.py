"""A film is the same to the byte for workgroups of any shape, and of any parts."""

import functools
from pathlib import Path

import numpy as np
import pytest
from both_engines import on_gpu, shared_engine, sized

import glimt
from glimt.engines.gpu import engine as gpu_engine
from glimt.engines.gpu.engine import GpuEngine
from glimt.engines.gpu.pace import Pace

STONE_ROOM = Path(__file__).resolve().parents[3] / "examples" / "stone_room.toml"

pytestmark = pytest.mark.usefixtures("software_gpu")


@functools.cache
def _wanted():
    """Return the film of the usual workgroups, of a size that is a multiple of none."""
    return _render(shared_engine())


def _render(engine):
    return on_gpu(sized(glimt.load(STONE_ROOM), 75, 53, 2, 3), engine).render()


@pytest.mark.parametrize("group", [(8, 8), (16, 16), (32, 32), (64, 1), (256, 1)], ids=str)
def test_workgroups(group):
    film = _render(GpuEngine(group=group))
    assert film.sums.tobytes() == _wanted().sums.tobytes()
    assert film.counters == _wanted().counters


@pytest.mark.parametrize("most", [1, 700, 2000])
def test_parts(monkeypatch, most):
    monkeypatch.setattr(gpu_engine, "_MOST_PIXELS", most)
    engine = shared_engine()
    monkeypatch.setattr(engine, "_pace", Pace())  # on a busy machine it would make smaller parts
    monkeypatch.setattr(engine, "_clock", lambda: 0.0)
    areas, told = gpu_engine.Areas((75, 53), engine._group), engine._tell
    parts = list(iter(lambda: areas.take(most), None))
    assert len(parts) == {1: 70, 700: 7, 2000: 3}[most]
    seen = []
    monkeypatch.setattr(engine, "_tell", lambda view, size, area, *rest: seen.append(area) or told(
        view, size, area, *rest))
    film = _render(engine)
    assert film.sums.tobytes() == _wanted().sums.tobytes()
    assert film.counters == _wanted().counters
    assert set(seen) >= set(parts)


def test_parts_of_debug_views(monkeypatch):
    renderer = on_gpu(sized(glimt.load(STONE_ROOM), 75, 53))
    wanted = renderer.render_debug("instances").values
    monkeypatch.setattr(gpu_engine, "_MOST_PIXELS", 130)
    np.testing.assert_array_equal(renderer.render_debug("instances").values.view(np.int32), wanted.view(np.int32))


def test_a_pass_for_each_stage_where_there_are_no_timestamps_within(monkeypatch):
    engine = shared_engine()
    monkeypatch.setattr(engine._timer, "marks_inside", False)
    film = _render(engine)
    assert film.sums.tobytes() == _wanted().sums.tobytes()
    assert film.stages.keys() == _wanted().stages.keys()
    assert sum(film.stages.values()) < film.seconds
