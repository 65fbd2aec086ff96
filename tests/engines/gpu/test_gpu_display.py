"""Films and overlays on their way to a window of the GPU, against the same by memory."""

import numpy as np
import pytest
from both_engines import on_gpu, sized
from gpu_device import software_device

import glimt
from glimt.color import develop
from glimt.engines.gpu.buffers import Buffer
from glimt.engines.gpu.display import Display
from glimt.film import Counters, DistantFilm, Film


def _pixels(device, texture):
    """Return what is in a texture."""
    width, height = texture.size[:2]
    row = -(-4 * width // 256) * 256
    buffer = device.gpu.create_buffer(size=row * height, usage="COPY_DST|MAP_READ")
    encoder = device.gpu.create_command_encoder()
    encoder.copy_texture_to_buffer({"texture": texture}, {"buffer": buffer, "bytes_per_row": row}, (width, height, 1))
    device.gpu.queue.submit([encoder.finish()])
    buffer.map_sync("READ")
    pixels = np.frombuffer(buffer.read_mapped(), np.uint8).reshape(height, row)[:, :4 * width].copy()
    buffer.unmap()
    return pixels.reshape(height, width, 4)


@pytest.mark.parametrize("tone_curve", ["clamp", "filmic"])
@pytest.mark.parametrize("exposure", [0.0, -3.5, 4.0])
def test_films_are_developed_as_in_memory(tone_curve, exposure):
    device = software_device()
    rng = np.random.default_rng(3)
    sums = np.exp(rng.uniform(-12, 6, (37, 53, 4))).astype(np.float32)
    sums[..., 3] = rng.integers(0, 17, sums.shape[:2])
    sums[0, :4] = [0, 0, 0, 1], [1e34, 0.5, 0, 1], [-1, 1, 1, 4], [0.0031308, 0.04, 1, 1]
    buffer = Buffer(device, "sums")
    buffer.upload(sums)
    display = Display(device)
    display.develop(DistantFilm((53, 37), buffer, lambda: sums, Counters(), 0.0, {}), exposure, tone_curve)
    expected = develop(sums, exposure, tone_curve, np.empty((37, 53, 4), np.uint8))
    got = _pixels(device, display._picture)
    assert np.abs(got.astype(int) - expected).max() <= 1
    assert (got != expected).mean() < 0.1
    buffer.destroy()


def test_only_changed_rows_of_an_overlay_are_uploaded(monkeypatch):
    device = software_device()
    display, written = Display(device), []
    write = display._write
    monkeypatch.setattr(display, "_write", lambda texture, rows, first: (written.append((first, len(rows))),
                                                                         write(texture, rows, first)))
    layer = np.zeros((40, 30, 4), np.uint8)
    display.cover(layer)
    assert written == []
    layer[7, 3] = 200
    layer[11, 20, 3] = 9
    display.cover(layer)
    display.cover(layer)
    assert written == [(7, 5)]
    layer[...] = 0
    display.cover(layer)
    assert written == [(7, 5), (7, 5)]
    layer[39] = 77
    display.cover(layer)
    np.testing.assert_array_equal(_pixels(device, display._overlay), layer)


@pytest.mark.parametrize("pixels_at_once", [None, 64, 20 * 8])
def test_a_film_that_stays_is_the_film_that_comes_back(software_gpu, monkeypatch, pixels_at_once):
    """Whole, in bands, and in pieces of the height of a tile."""
    scene = sized(_scene(), 45, 37, 2, 1)
    expected = on_gpu(scene).render()
    renderer = glimt.Renderer(scene, engine="gpu")
    assert renderer.keep_films() is renderer._engine._device
    if pixels_at_once:
        monkeypatch.setattr(type(renderer._engine), "_most_pixels", lambda self: pixels_at_once)
    film = renderer.render()
    assert isinstance(film, DistantFilm)
    assert film.counters == expected.counters
    again = renderer.render(film=film)
    assert again.place is film.place
    np.testing.assert_array_equal(again.sums, expected.sums)
    assert renderer._engine._download._staging.size >= expected.sums.nbytes


def test_the_cpu_keeps_films_in_memory_and_writes_over_none_of_a_gpu():
    renderer = glimt.Renderer(sized(_scene(), 8, 6, 1, 0), engine="cpu")
    assert renderer.keep_films() is None

    def fetch():
        raise AssertionError("it is gone")

    film = renderer.render(film=DistantFilm((8, 6), None, fetch, Counters(), 0.0, {}))
    assert type(film) is Film


def _scene():
    scene = glimt.Scene(camera=glimt.Camera((0.0, 0.0, 4.0), (0.0, 0.0, 0.0)))
    return scene.add(glimt.Sphere((0.0, 0.0, 0.0), 1.0), glimt.PointLight(position=(2.0, 3.0, 4.0)))
