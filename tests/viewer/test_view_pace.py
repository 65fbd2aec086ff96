"""How soon a window answers to a key, and how little it does when nothing happens: two promises that are counted.

The only times that tests hold anything to; each has room for a busy machine, and is printed (``pytest -s``).
"""

import os
import time
from pathlib import Path

import numpy as np
import pytest
from view_client import STONE_ROOM, viewing
from xtest import Keyboard
from xvfb import xvfb

FRAME_BUDGET = 1 / 30
PRESSES = 20
MOST_AT_REST = 0.03


@pytest.fixture(scope="module")
def view():
    with xvfb() as display, viewing(display, STONE_ROOM, "--size", "400x400") as view:
        yield view


@pytest.fixture
def keyboard(view):
    keyboard = Keyboard(view.display.name)
    yield keyboard
    keyboard.close()


def processor_seconds(process):
    """Return what a process has used of the processors, all its threads together."""
    fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return sum(map(int, fields[11:13])) / os.sysconf("SC_CLK_TCK")


def test_a_lamp_moves_by_itself_and_without_it_nothing_is_computed(view):
    view.wait_for_change(view.picture(), np.s_[:, 300:])
    view.press("t")
    state = view.wait_for(lambda state: not state["time_runs"] and state["at_rest"] and not state["message"])
    picture, shares = view.picture(), []
    while not shares or (shares[-1] >= MOST_AT_REST and len(shares) < 4):
        used, start = processor_seconds(view.process), time.perf_counter()
        time.sleep(3)
        shares.append((processor_seconds(view.process) - used) / (time.perf_counter() - start))
    print(f"\nat rest, share of one core: {', '.join(f'{share:.1%}' for share in shares)}")
    assert shares[-1] < MOST_AT_REST
    assert view.state()["shown"] == state["shown"]
    assert np.array_equal(view.picture(), picture)


def latency(view, keyboard, key):
    """Press a key; return the seconds until a picture that shows what it does is on the screen, and let go of it."""
    before = view.state()
    start = keyboard.send(key, True)
    end = time.monotonic() + 5
    while not (seen := [frame[0] - start for frame in view.ask(f"app.frames_since({start})")
                        if frame[3] != before["fov"] or (key != "z" and np.abs(way(before, frame)) > 1e-4)]):
        assert time.monotonic() < end, "no picture shows what the key does"
        time.sleep(0.005)
    keyboard.send(key, False)
    return seen[0]


def way(before, frame):
    """Return how far to the right a frame was taken."""
    return np.dot(np.subtract(frame[2], before["position"]), before["right"])


def tell(what, latencies):
    values = 1000 * np.sort(latencies)
    print(f"\nmilliseconds from a key to the picture, {what}: median {np.median(values):.1f}, p95 "
          f"{np.percentile(values, 95):.1f}, all {' '.join(f'{value:.0f}' for value in values)}")


@pytest.mark.parametrize("key", ["d", "z"])
def test_a_key_is_answered_from_rest(view, keyboard, key):
    latencies = []
    for number in range(PRESSES // 2):
        view.reset()
        time.sleep(0.01 * number)  # at any point of the rounds at rest
        latencies.append(latency(view, keyboard, key))
    tell(f"{key} from rest", latencies)
    assert np.median(latencies) <= 2 * FRAME_BUDGET


def test_a_key_is_answered_in_movement(view, keyboard):
    view.reset()
    latencies = []
    for number in range(PRESSES):
        view.press("r")
        keyboard.send("ws"[number % 2], True)
        time.sleep(0.1 + 0.003 * number)
        assert view.state()["moving"]
        latencies.append(latency(view, keyboard, "z"))
        keyboard.send("ws"[number % 2], False)
    tell("z in movement", latencies)
    assert np.median(latencies) <= 2 * FRAME_BUDGET
