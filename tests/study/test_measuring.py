"""Timing in turn: by a clock that the tests turn."""

import numpy as np
import pytest

from glimt.study.laws import steadied
from glimt.study.measuring import LEAST_ROUNDS, measure


class Machine:
    """A clock, and runs that take their time on it; `slowness` may depend on the time."""

    def __init__(self, slowness=lambda now: 1.0):
        self.now, self.slowness, self.log = 0.0, slowness, []

    def clock(self):
        return self.now

    def run(self, name, seconds):
        def once():
            taken = seconds * self.slowness(self.now)
            self.now += taken
            self.log.append(name)
            return taken
        return once


def medians(rounds):
    return np.array([[np.median(block) for block in row] for row in rounds])


def test_all_settings_are_timed_in_every_round():
    machine = Machine()
    rounds, complete = measure([machine.run(k, 0.001 * (k + 1)) for k in range(4)], 1.0, clock=machine.clock)
    assert complete
    assert len(rounds) == LEAST_ROUNDS  # known exactly: more would tell nothing
    assert all(len(row) == 4 and all(len(block) == 3 for block in row) for row in rounds)
    np.testing.assert_allclose(medians(rounds), np.tile([0.001, 0.002, 0.003, 0.004], (LEAST_ROUNDS, 1)))
    assert len(machine.log) == LEAST_ROUNDS * 4 * 4  # three, and one to warm up


def test_each_round_has_an_order_of_its_own():
    machine = Machine()
    measure([machine.run(k, 0.01) for k in range(6)], 1.0, clock=machine.clock)
    order = [name for name, before in zip(machine.log, [None, *machine.log[:-1]], strict=True) if name != before]
    first, second = order[:6], order[6:12]
    assert sorted(first) == sorted(second) == list(range(6))
    assert first != second


def test_a_machine_that_slows_down_draws_no_slope():
    machine = Machine(lambda now: 1 + now / 3)
    rounds, _ = measure([machine.run(k, 0.01) for k in range(5)], 6.0, clock=machine.clock)
    middle = np.median(steadied(medians(rounds)), axis=0)
    assert medians(rounds).max() > 1.5 * medians(rounds).min()
    assert np.ptp(middle) / middle.mean() < 0.05


def test_noise_is_measured_until_the_time_is_over():
    random = np.random.default_rng(1)
    machine = Machine(lambda now: float(np.exp(random.normal(0, 0.3))))
    rounds, complete = measure([machine.run(k, 0.01) for k in range(3)], 3.0, clock=machine.clock)
    assert complete
    assert LEAST_ROUNDS < len(rounds) < 40
    assert 3.0 <= machine.now < 3.5


def test_slow_settings_are_neither_warmed_up_nor_repeated():
    machine = Machine()
    rounds, _ = measure([machine.run("slow", 2.0), machine.run("quick", 0.01)], 1.0, clock=machine.clock)
    assert len(rounds) == LEAST_ROUNDS
    assert all(len(slow) == 1 and len(quick) == 3 for slow, quick in rounds)
    assert machine.log.count("slow") == LEAST_ROUNDS + 1  # that it is slow is known after the first


def test_ctrl_c_keeps_whole_rounds():
    machine = Machine()
    usual, calls = machine.run("a", 0.001), []

    def interrupted():
        calls.append(1)
        if len(calls) > 14:
            raise KeyboardInterrupt
        return usual()

    rounds, complete = measure([machine.run("b", 0.001), interrupted], 1.0, clock=machine.clock)
    assert not complete
    assert len(rounds) == 3
    assert all(len(block) == 3 for row in rounds for block in row)


def test_progress_goes_up_to_its_end():
    random, told = np.random.default_rng(1), []
    machine = Machine(lambda now: float(np.exp(random.normal(0, 0.3))))
    measure([machine.run(k, 0.01) for k in range(3)], 2.0, told.append, machine.clock)
    assert told == sorted(told)
    assert told[-1] == 1
    assert 0 < told[0] < 0.2


def test_an_error_of_a_frame_comes_through():
    def broken():
        raise ValueError("broken")

    with pytest.raises(ValueError, match="broken"):
        measure([broken], 1.0)
