"""The thread between a canvas and a viewer."""

import threading
import time

import numpy as np
import pytest
from viewer_driver import make_scene

from glimt.viewer.render_thread import RenderThread
from glimt.viewer.viewer import Viewer


def wait_for(condition, seconds=20.0):
    end = time.perf_counter() + seconds
    while not condition():
        assert time.perf_counter() < end, "waited in vain"
        time.sleep(0.005)


@pytest.fixture
def thread():
    announced = threading.Event()
    thread = RenderThread(Viewer(make_scene(), threads=2), announced.set)
    thread.announced = announced
    thread.start()
    yield thread
    thread.stop()
    assert not thread.running


def settle(thread):
    """Take pictures until none is left to be made, nor is being made."""
    rounds_at_rest = 0
    while rounds_at_rest < 10:
        thread.take()
        rounds_at_rest = rounds_at_rest + 1 if thread.viewer.at_rest and thread._wanted else 0
        time.sleep(0.01)


def test_the_next_picture_waits_until_the_last_is_taken(thread):
    wait_for(lambda: thread.rendered == 1)
    time.sleep(0.4)
    assert thread.rendered == 1
    assert thread.take().shape == (60, 80, 4)
    wait_for(lambda: thread.rendered == 2)


def test_one_picture_may_be_made_ahead():
    viewer = Viewer(make_scene(), threads=1)
    thread = RenderThread(viewer, lambda: None, ahead=1)
    thread.start()
    wait_for(lambda: thread.rendered == 2)
    time.sleep(0.4)
    assert thread.rendered == 2
    assert thread.take() is not None
    assert thread.taken == 1
    wait_for(lambda: thread.rendered == 4)
    thread.stop()


def test_at_rest_it_sleeps_until_an_event(thread):
    settle(thread)
    time.sleep(3.0)  # until notices are gone
    settle(thread)
    rendered, start = thread.rendered, time.process_time()
    time.sleep(0.5)
    assert thread.rendered == rendered
    assert time.process_time() - start < 0.1
    before = thread.take().copy()
    thread.announced.clear()
    thread.post({"event_type": "key_down", "key": "z", "modifiers": ()})  # seen in a scene without mirrors too
    assert thread.announced.wait(10)
    settle(thread)
    assert not np.array_equal(thread.take(), before)


def test_events_count_while_nobody_takes_pictures(thread):
    wait_for(lambda: thread.rendered == 1)
    for _ in range(5):
        thread.post({"event_type": "key_down", "key": "b", "modifiers": ()})
    wait_for(lambda: thread.viewer.scene.settings.max_bounces == 5)
    assert thread.rendered == 1


def test_a_flood_of_events_is_bounded(thread):
    for k in range(100_000):
        thread.post({"event_type": "pointer_move", "x": float(k), "y": 0.0, "buttons": (), "modifiers": ()})
    assert len(thread._events) <= 10_000
    wait_for(lambda: not thread._events)


def test_jobs_are_done_in_the_thread(thread):
    done = []
    thread.do(lambda: done.append(threading.current_thread().name))
    wait_for(lambda: done)
    assert done == ["glimt-render"]


def test_it_stops_in_the_middle_of_a_long_picture():
    viewer = Viewer(make_scene(max_bounces=3), threads=2)
    viewer.samples = 64
    viewer.resize(4000, 4000)
    viewer.governor.learn(1e-9, 0.0)
    thread = RenderThread(viewer, lambda: None)
    thread.start()
    time.sleep(0.3)
    start = time.perf_counter()
    thread.stop()
    assert time.perf_counter() - start < 10
    assert thread.error is None


def test_an_error_in_a_frame_ends_it_and_is_kept():
    viewer = Viewer(make_scene(), threads=1)
    states = []
    thread = RenderThread(viewer, lambda: states.append((thread.running, thread.error)))
    viewer.frame = lambda now: 1 / 0
    thread.start()
    wait_for(lambda: states)
    (running, error), = states
    assert not running  # who is told may look at once
    assert isinstance(error, ZeroDivisionError)
    thread.stop()
