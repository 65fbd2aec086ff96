"""Stopping a render from another thread, and going on afterwards."""

import threading
import time

import numpy as np
import pytest

import glimt
from glimt.errors import GlimtError, RenderCancelled

SMALL = glimt.RenderSettings(64, 48, samples=2, max_bounces=1)
ENDLESS = {16: glimt.RenderSettings(8192, 8192, samples=16, max_bounces=1),
           "adaptive": glimt.RenderSettings(8192, 8192, samples="adaptive", max_bounces=1)}


@pytest.fixture
def renderer():
    scene = glimt.Scene(settings=SMALL)
    floor = glimt.Mesh([[-9, 0, -9], [9, 0, -9], [9, 0, 9], [-9, 0, 9]], [[0, 2, 1], [0, 3, 2]])
    scene.add(floor, glimt.Sphere((0, 1, 0), 1.0, glimt.Material(reflectivity=0.5)),
              glimt.PointLight(position=(2, 4, 3), radius=5))
    scene.camera = glimt.Camera((0, 2, 6), (0, 1, 0))
    return glimt.Renderer(scene, threads=2)


def cancelled(renderer, render, when):
    """Return what `render` raised after another thread, at `when`, had called `cancel`."""
    def cancel():
        when.wait()
        renderer.cancel()

    thread = threading.Thread(target=cancel)
    thread.start()
    try:
        with pytest.raises(RenderCancelled) as raised:
            render()
        return raised.value
    finally:
        thread.join()


@pytest.mark.parametrize("samples", ENDLESS)
def test_a_render_stops_at_once_and_the_next_one_is_whole(renderer, samples):
    before = renderer.render()
    renderer.scene.settings, began, told = ENDLESS[samples], threading.Event(), []

    def progress(stage, share):
        told.append(share)
        if share > 0:
            began.set()

    error = cancelled(renderer, lambda: renderer.render(progress=progress), began)
    assert isinstance(error, GlimtError)
    assert 0 < max(told) < 0.5  # of about a minute
    renderer.scene.settings = SMALL
    after = renderer.render()
    assert after.sums.tobytes() == before.sums.tobytes()
    assert after.counters == before.counters


def test_a_cancel_between_the_halves_of_an_adaptive_picture_counts(renderer):
    """The first half is done, no ray of the second is traced yet."""
    renderer.scene.settings = glimt.RenderSettings(64, 48, samples="adaptive")
    run, kernels = renderer._engine._run, []

    def cancel_after_the_first(kernel, *rest):
        run(kernel, *rest)
        kernels.append(kernel)
        renderer.cancel()

    renderer._engine._run = cancel_after_the_first
    with pytest.raises(RenderCancelled):
        renderer.render()
    assert len(kernels) == 1
    renderer._engine._run = run
    assert renderer.render().sums[..., 3].min() >= 1


def test_a_cancel_with_nothing_to_stop_does_nothing(renderer):
    renderer.cancel()
    before = renderer.render()
    renderer.cancel()
    assert renderer.render().sums.tobytes() == before.sums.tobytes()


def test_a_film_that_was_being_written_over_can_be_used_again(renderer):
    film = renderer.render()
    expected = film.sums.copy()

    def cancel(stage, share):
        renderer.cancel()  # before the first tile

    with pytest.raises(RenderCancelled):
        renderer.render(progress=cancel, film=film)
    assert renderer.render(film=film).sums is film.sums
    np.testing.assert_array_equal(film.sums, expected)


def test_cancels_from_many_threads_while_pictures_are_made(renderer):
    """Every picture is whole or cancelled, and none is lost for ever."""
    expected, stop, made = renderer.render().sums, threading.Event(), []

    def cancel():
        while not stop.is_set():
            renderer.cancel()
            time.sleep(0.0005)

    threads = [threading.Thread(target=cancel) for _ in range(4)]
    for thread in threads:
        thread.start()
    try:
        for _ in range(200):
            try:
                made.append(renderer.render().sums)
            except RenderCancelled:
                made.append(None)
    finally:
        stop.set()
        for thread in threads:
            thread.join()
    assert any(sums is None for sums in made)
    assert all(np.array_equal(sums, expected) for sums in made if sums is not None)
    np.testing.assert_array_equal(renderer.render().sums, expected)
