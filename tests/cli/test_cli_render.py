"""`glimt render`."""

import dataclasses
import os
import re
import warnings

import numpy as np
import pytest
from PIL import Image

import glimt as api
from glimt import film, renderer
from glimt.cli.render import _count
from glimt.errors import GlimtWarning
from glimt.scene.scene import Scene


def pixels(path) -> np.ndarray:
    with Image.open(path) as image:
        return np.asarray(image)


def test_the_picture_is_the_one_of_the_api(glimt):
    end = glimt("render", "ball.toml")
    assert (end.code, end.err) == (0, "")
    assert re.fullmatch(r"ball\.png: 24×16, \d+(\.\d [kMG])? rays in \d+\.\d\d s, \d+\.\d Mrays/s, 0 warnings\n",
                        end.out)
    assert np.array_equal(pixels("ball.png"), api.render(api.load("ball.toml")))


def test_options_take_the_place_of_the_scene_file(glimt):
    end = glimt("render", "ball.toml", "-o", "other.bmp", "--size", "20x10", "--samples", "2", "--bounces", "1",
                "--threads", "1", "--engine", "cpu", "--time", "1.5", "--exposure", "0.5")
    assert end.code == 0
    assert end.out.startswith("other.bmp: 20×10, ")
    scene = api.load("ball.toml")
    scene.settings.exposure = 0.5
    expected = api.render(scene, size=(20, 10), samples=2, max_bounces=1, time=1.5)
    assert np.array_equal(pixels("other.bmp"), expected)
    assert not np.array_equal(expected, api.render(scene, size=(20, 10), samples=2, max_bounces=1))


def test_samples_may_be_adaptive(glimt):
    assert glimt("render", "ball.toml", "--samples", "adaptive").code == 0
    assert np.array_equal(pixels("ball.png"), api.render(api.load("ball.toml"), samples="adaptive"))


def test_warnings_are_counted_and_printed_once(glimt, tmp_path):
    (tmp_path / "flat.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n" + "f 1 2 2\n" * 7)
    end = glimt("render", "flat.obj", "--size", "8x8")
    assert end.code == 0
    assert end.out.endswith(", 7 warnings\n")
    assert re.fullmatch(r"warning: flat\.obj:5: [^\n]*\(7 times, [^\n]*\n", end.err)


def test_warnings_of_others_are_passed_on(glimt, monkeypatch):
    def warn_twice(path):
        warnings.warn("from elsewhere", DeprecationWarning, stacklevel=2)
        warnings.warn(GlimtWarning("ours"), stacklevel=2)
        return Scene(settings=api.RenderSettings(4, 4))
    monkeypatch.setattr("glimt.io.load", warn_twice)
    monkeypatch.setattr(warnings, "filters", [("default", None, DeprecationWarning, None, 0)])
    with pytest.warns(DeprecationWarning, match="from elsewhere"):
        end = glimt("render", "ball.toml")
    assert end.out.endswith(", 1 warning\n")
    assert end.err == "warning: ours\n"


@pytest.mark.parametrize(("output", "message"), [
    ("ball.xyz", "ball.xyz: cannot tell the format from '.xyz', use one of .png, "),
    ("ball", "ball: cannot tell the format from ''"),
    ("nowhere/ball.png", "nowhere/ball.png: there is no folder nowhere; create it"),
    ("folder.png", "folder.png: is a folder; name a file in it"),
    ("locked/ball.png", "locked/ball.png: the folder locked cannot be written to"),
])
def test_output_is_checked_before_anything_is_rendered(glimt, tmp_path, monkeypatch, output, message):
    (tmp_path / "folder.png").mkdir()
    (tmp_path / "locked").mkdir()
    monkeypatch.setattr(os, "access", lambda path, mode: path.name != "locked")
    monkeypatch.setattr(renderer, "Renderer", None)
    end = glimt("render", "ball.toml", "-o", output)
    assert (end.code, end.out) == (1, "")
    assert end.err.startswith(f"error: {message}")
    assert end.err.count("\n") == 1


@pytest.mark.parametrize(("arguments", "message"), [
    (["nix.toml"], "error: nix.toml: no such file\n"),
    (["ball.gltf"], "error: ball.gltf: cannot load .gltf; "),
    (["broken.toml"], "error: broken.toml:2: camera.fov: unknown key, did you mean 'fov_deg'?\n"),
    (["ball.toml", "--samples", "0"], "error: settings: samples is 0, expected 1 to 64\n"),
    (["ball.toml", "--bounces", "-1"], "error: settings: max_bounces is -1, expected 0 to 1000\n"),
    (["ball.toml", "--size", "99999x1"], "error: settings: width is 99999, expected 1 to 32768\n"),
    (["ball.toml", "--exposure", "1e9"], "error: settings: exposure is 1e+09, expected -100 to 100\n"),
])
def test_our_errors_are_one_line_and_1(glimt, tmp_path, arguments, message):
    (tmp_path / "broken.toml").write_text("[camera]\nfov = 3\n")
    end = glimt("render", *arguments)
    assert (end.code, end.out) == (1, "")
    assert end.err.startswith(message)
    assert end.err.count("\n") == 1
    assert not list(tmp_path.glob("*.png"))


@pytest.mark.parametrize("arguments", [
    [], ["ball.toml", "more.toml"], ["ball.toml", "--colour"], ["ball.toml", "--size", "3"],
    ["ball.toml", "--size", "0x1x2"], ["ball.toml", "--size", "axb"], ["ball.toml", "--threads", "0"],
    ["ball.toml", "--engine", "tpu"],
    ["ball.toml", "--samples", "two"], ["ball.toml", "--time", "nan"], ["ball.toml", "--exposure", "inf"],
])
def test_wrong_usage_is_2(glimt, arguments):
    end = glimt("render", *arguments)
    assert (end.code, end.out) == (2, "")
    assert "Usage: " in end.err
    assert "Error: " in end.err
    assert "Traceback" not in end.err


@pytest.mark.parametrize(("raised", "code", "line"), [
    (KeyboardInterrupt(), 130, "interrupted\n"),
    (MemoryError(), 1, "error: not enough memory; choose a smaller picture or scene\n"),
])
def test_what_ends_a_render_early(glimt, monkeypatch, raised, code, line):
    def fail(*arguments, **options):
        raise raised
    monkeypatch.setattr(renderer, "Renderer", fail)
    assert glimt("render", "ball.toml") == (code, "", line)


def test_samples_that_are_not_finite_are_reported(glimt, monkeypatch):
    whole = renderer.Renderer.render

    def render(self, *arguments):
        result = whole(self, *arguments)
        return dataclasses.replace(result, counters=film.Counters(1_200_000, 0, 300_000, 1234), seconds=0.25)
    monkeypatch.setattr(renderer.Renderer, "render", render)
    end = glimt("render", "ball.toml")
    assert end.out == ("ball.png: 24×16, 1.5 M rays in 0.25 s, 6.0 Mrays/s, 0 warnings, "
                       "1,234 non-finite samples dropped\n")


def test_compiling_is_said_once_and_not_on_stdout(glimt, monkeypatch):
    whole = renderer.Renderer.render

    def render(self, time, progress):
        progress("compiling kernels, first run only", 0.0)
        progress("compiling kernels, first run only", 0.5)
        progress("rendering", 0.5)
        return whole(self, time, progress)
    monkeypatch.setattr(renderer.Renderer, "render", render)
    end = glimt("render", "ball.toml")
    assert end.err == "compiling kernels, first run only\n"
    assert end.out.count("\n") == 1


@pytest.mark.parametrize(("value", "text"), [
    (7, "7"), (999, "999"), (1000, "1.0 k"), (1_240_000, "1.2 M"), (5_000_000_000, "5.0 G")])
def test_count(value, text):
    assert _count(value) == text
