"""The names users type."""

import subprocess
import sys
import types

import numpy as np
import pytest

import glimt


def test_all_is_sorted_and_resolves():
    assert sorted(glimt.__all__) == glimt.__all__
    assert set(glimt.__all__) == set(glimt._HOMES)
    for name in glimt.__all__:
        assert getattr(glimt, name).__name__ == name
    assert dir(glimt) == glimt.__all__


def test_all_is_what_there_is():
    assert glimt.__all__ == [
        "Camera", "DirectionalLight", "Film", "GlimtError", "GlimtWarning", "Instance", "Material", "Mesh", "Orbit",
        "Path", "PointLight", "RenderSettings", "Renderer", "Scene", "Sphere", "SpotLight", "Texture", "load", "render",
        "save_image", "view"]


def test_every_public_thing_says_what_it_is():
    for name in glimt.__all__:
        assert len(getattr(glimt, name).__doc__.strip()) > 20, name


def test_unknown_names_are_attribute_errors():
    with pytest.raises(AttributeError, match="module 'glimt' has no attribute 'rendr'"):
        _ = glimt.rendr


@pytest.mark.parametrize("first", ["glimt.renderer", "glimt.cli", "glimt.io", "glimt.engines.cpu.engine", "glimt.film"])
def test_functions_stay_functions_whatever_is_imported_first(first):
    code = f"import {first}, glimt; print(*map(type, (glimt.render, glimt.load, glimt.save_image)))"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert result.stdout.count("<class 'function'>") == 3


def test_from_import_star():
    names = {}
    exec("from glimt import *", names)
    assert set(glimt.__all__) <= set(names)
    assert isinstance(names["render"], types.FunctionType)


def test_a_picture_in_ten_lines(tmp_path):
    scene = glimt.Scene()
    floor = glimt.Mesh([[-9, 0, -9], [9, 0, -9], [9, 0, 9], [-9, 0, 9]], [[0, 2, 1], [0, 3, 2]])
    mirror = glimt.Material(diffuse=(0.9, 0.9, 1.0), specular=0.8, exponent=200, reflectivity=0.7)
    scene.add(floor, glimt.Sphere((0, 1, 0), 1.0, mirror), glimt.Sphere((2.2, 0.7, 0.5), 0.7))
    scene.add(glimt.PointLight(position=(3, 5, 4), radius=6), glimt.DirectionalLight(direction=(1, -2, -1)))
    scene.camera = glimt.Camera(position=(0, 2.5, 7), target=(0.6, 0.7, 0))
    image = glimt.render(scene, size=(80, 60), samples=2, max_bounces=3)
    glimt.save_image(str(tmp_path / "spheres.png"), image)
    assert image.shape == (60, 80, 3)
    assert len(np.unique(image.reshape(-1, 3), axis=0)) > 200
    assert (tmp_path / "spheres.png").stat().st_size > 1000
