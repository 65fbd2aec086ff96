"""`load` chooses the reader; a bare mesh gets what it needs to be seen."""

import os
from pathlib import Path

import numpy as np
import pytest

from glimt.errors import GlimtError, GlimtWarning
from glimt.io import load
from glimt.scene.camera import Camera


def test_a_bare_mesh_is_framed_and_lit(tmp_path):
    (tmp_path / "leaf.obj").write_text("v 0 0 0\nv 1000 0 0\nv 0 1000 0\nf 1 2 3\n")
    scene = load(tmp_path / "leaf.obj")
    [instance] = scene.instances()
    assert instance.mesh.positions.max() == 1000
    assert scene.camera is None
    assert (scene.settings.width, scene.settings.height, scene.settings.samples, scene.settings.max_bounces) == (
        640, 480, 2, 2)
    # What faces the camera gets light from all three, and not more than the picture can show.
    towards_camera = -Camera.framing(*scene.bounds()).basis().look
    cosines = [-np.dot(light.direction, towards_camera) / np.linalg.norm(light.direction) for light in scene.lights]
    assert len(cosines) == 3
    assert min(cosines) > 0.4
    assert 0.7 < np.dot(cosines, [light.diffuse[0] for light in scene.lights]) < 1
    key, fill, _ = scene.lights
    right, up, _ = Camera.framing(*scene.bounds()).basis()
    assert np.dot(key.direction, right) > 0 > np.dot(fill.direction, right)
    assert np.dot(key.direction, up) < 0
    assert key.diffuse > fill.diffuse


def test_path_and_case_of_the_ending(tmp_path):
    (tmp_path / "LEAF.OBJ").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert load(str(tmp_path / "LEAF.OBJ")).name == "LEAF"


def test_warnings_of_a_bare_mesh(tmp_path):
    (tmp_path / "flat.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 2\n")
    with pytest.warns(GlimtWarning, match=r"flat\.obj:5: "):
        load(tmp_path / "flat.obj")


def test_what_cannot_be_loaded(tmp_path):
    os.mkfifo(tmp_path / "pipe.toml")  # reading it would wait for ever
    (tmp_path / "folder.toml").mkdir()
    for name, message in {
        "a.gltf": "a.gltf: cannot load .gltf; glimt loads scene files (.toml) and meshes (.obj)",
        "room": "room: cannot load a file without an extension; ",
        "nix.toml": "nix.toml: no such file",
        "nix.obj": "nix.obj: no such file",
        "folder.toml": "folder.toml: not a regular file",
        "pipe.toml": "pipe.toml: not a regular file",
        "a\0b.toml": "b.toml",
        "a" * 5000 + ".toml": ".toml",
    }.items():
        with pytest.raises(GlimtError) as caught:
            load(tmp_path / name)
        assert message in str(caught.value)


def test_a_scene_at_the_root_of_the_disk_reaches_its_own_folder_only(tmp_path, monkeypatch):
    # /scenes/room.toml must not reach / : the folder above is the whole disk.
    monkeypatch.setattr(Path, "resolve", lambda self: Path("/scenes") if self == tmp_path else Path("/etc/a.obj"))
    (tmp_path / "room.toml").write_text("[[mesh]]\nfile = '../etc/a.obj'\n")
    with pytest.raises(GlimtError, match=r"lies outside /scenes; "):
        load(tmp_path / "room.toml")
