"""What goes to the GPU at once is little at first, and grows while that is quick; the picture is the same."""

from pathlib import Path

import numpy as np
import pytest
from both_engines import on_gpu, shared_engine, sized

import glimt
from glimt.engines.gpu.commands import Commands
from glimt.engines.gpu.pace import LONGEST_SECONDS, Area, Areas, Pace

STONE_ROOM = Path(__file__).resolve().parents[3] / "examples" / "stone_room.toml"


def _areas(size, tile, most):
    areas = Areas(size, tile)
    return list(iter(lambda: areas.take(most), None))


@pytest.mark.parametrize("size", [(75, 53), (8, 8), (1, 1), (500, 3), (3, 500)])
@pytest.mark.parametrize("tile", [(8, 8), (64, 1), (16, 4)])
@pytest.mark.parametrize("most", [1, 63, 64, 700, 5000, 10**7])
def test_areas_cover_each_pixel_once_and_are_no_larger_than_they_may(size, tile, most):
    covered, down = np.zeros(size[::-1], int), -1
    for area in _areas(size, tile, most):
        column, row, width, height = area
        covered[row:row + height, column:column + width] += 1
        assert column % tile[0] == row % tile[1] == 0
        tiles = -(-width // tile[0]) * -(-height // tile[1])
        assert tiles == 1 or tiles * tile[0] * tile[1] <= most
        assert row >= down
        down = row
    assert (covered == 1).all()


def test_a_picture_that_may_go_at_once_is_not_divided():
    assert _areas((1920, 1080), (8, 8), 1920 * 1080) == [Area(0, 0, 1920, 1080)]


def test_an_area_that_is_put_back_comes_again_in_parts():
    areas = Areas((32, 32), (8, 8))
    assert areas.done == 0
    first = areas.take(512)
    assert (first, areas.done) == (Area(0, 0, 32, 16), 0.5)
    areas.put_back(first)
    assert [areas.take(128) for _ in range(2)] == [Area(0, 0, 16, 8), Area(16, 0, 16, 8)]


def _submissions(pace, pixels, seconds_a_pixel):
    """Return what each submission takes until so many pixels are done."""
    taken = []
    while pixels > 0:
        now = min(pixels, pace.pixels)
        taken.append(now * seconds_a_pixel)
        pace.learn(now, taken[-1])
        pixels -= now
    return taken


@pytest.mark.parametrize("rays", [1, 24, 200])
@pytest.mark.parametrize("seconds_a_ray", [1e-10, 1e-9, 1e-8, 1e-7, 1e-6])
def test_no_submission_is_long_from_the_first_one_on(rays, seconds_a_ray):
    pace = Pace()
    pace.expect(rays)
    assert max(_submissions(pace, 2_000_000, rays * seconds_a_ray)) < LONGEST_SECONDS
    later = _submissions(pace, 2_000_000, rays * seconds_a_ray)
    assert max(later) < 0.2
    assert len(later) <= 1 + 2e6 * rays * seconds_a_ray / 0.05  # and not divided without need


def test_a_view_that_becomes_dearer_is_divided_in_time():
    pace, cost = Pace(), 1e-9
    _submissions(pace, 10**6, cost)
    while cost < 1e-5:
        cost *= 4
        taken = _submissions(pace, 10**6, cost)
        assert taken[0] < LONGEST_SECONDS
        assert max(taken) < LONGEST_SECONDS


def test_parts_of_a_picture_may_cost_four_times_as_much_as_others():
    pace = Pace()
    sky, ground = 2e-7, 8e-7
    _submissions(pace, 10**6, sky)
    assert pace.pixels * ground < LONGEST_SECONDS


def test_more_rays_a_pixel_are_fewer_pixels_and_another_scene_begins_anew():
    pace = Pace()
    pace.expect(4)
    first = pace.pixels
    pace.learn(first, 0.001)
    pace.learn(pace.pixels, 0.001)
    assert pace.pixels == 16 * first
    pace.expect(8)
    assert pace.pixels == 8 * first
    pace.expect(2)
    assert pace.pixels == 8 * first
    pace.restart()
    assert pace.pixels <= 2 * first + 1


class SlowGpu:
    """An engine whose pixels take a set time each, by a clock that nothing else moves."""

    def __init__(self, monkeypatch):
        self.engine, self.now, self.seconds_a_pixel, self.taken = shared_engine(), 0.0, 0.0, []
        self._run, submit = self.engine._run, Commands.submit
        monkeypatch.setattr(self.engine, "_run", self.run)
        monkeypatch.setattr(Commands, "submit", lambda commands: submit(commands) or self.wait())
        monkeypatch.setattr(self.engine, "_clock", lambda: self.now)
        monkeypatch.setattr(self.engine, "_pace", Pace())

    def run(self, stages, record, capacity, *rest):
        self._capacity = capacity
        self._run(stages, record, capacity, *rest)

    def wait(self):
        self.taken.append(self._capacity * self.seconds_a_pixel)
        self.now += self.taken[-1]


@pytest.fixture
def slow(software_gpu, monkeypatch):
    """Return a slow GPU."""
    return SlowGpu(monkeypatch)


def _renderer(engine=None):
    renderer = on_gpu(sized(glimt.load(STONE_ROOM), 75, 53, 2, 2), engine)
    renderer.render()
    return renderer


def test_a_slow_gpu_makes_the_same_picture_without_a_long_submission(slow):
    renderer = _renderer()
    wanted = renderer.render()
    quick, slow.seconds_a_pixel, slow.taken = slow.engine._pace.pixels, 1e-4, []
    for _ in range(2):
        got = renderer.render()
        assert got.sums.tobytes() == wanted.sums.tobytes()
        assert got.counters == wanted.counters
    assert max(slow.taken) < LONGEST_SECONDS
    assert max(slow.taken[4:]) < 0.11
    assert len(slow.taken) > 20
    assert quick >= 75 * 53 > slow.engine._pace.pixels


def test_an_area_that_turns_out_slow_is_begun_again_in_parts(slow):
    renderer = _renderer()
    wanted = renderer.render()
    slow.seconds_a_pixel, slow.taken = 1e-3, []
    got = renderer.render()
    assert got.sums.tobytes() == wanted.sums.tobytes()
    assert got.counters == wanted.counters
    assert slow.taken[0] > LONGEST_SECONDS  # nobody could know
    assert max(slow.taken[1:]) < LONGEST_SECONDS


def test_pixels_slower_than_the_longest_submission_come_one_tile_at_a_time(slow):
    renderer = _renderer()
    slow.seconds_a_pixel = 1.0
    renderer.render()
    slow.taken = []
    renderer.render()
    assert slow.taken == [64.0] * (10 * 7 * 4)


def test_debug_views_and_hits_are_divided_as_well(slow):
    renderer = _renderer()
    rays = np.concatenate([np.zeros((3, 900)), np.random.default_rng(1).normal(size=(3, 900)),
                           np.full((1, 900), np.inf)]).astype(np.float32)
    numbers, hits = renderer.render_debug("nodes").values, slow.engine.find_hits(rays)
    slow.seconds_a_pixel = 1e-3
    renderer.render()
    slow.taken = []
    assert renderer.render_debug("nodes").values.tobytes() == numbers.tobytes()
    assert max(slow.taken) < LONGEST_SECONDS
    slow.taken = []
    for got, wanted in zip(slow.engine.find_hits(rays), hits, strict=True):
        np.testing.assert_array_equal(got, wanted)
    assert len(slow.taken) > 4
    assert max(slow.taken) < LONGEST_SECONDS
