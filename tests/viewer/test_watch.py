"""A scene that is edited while it is watched."""

import queue
import shutil
import time
from pathlib import Path

import pytest

from glimt.errors import GlimtWarning
from glimt.io import load
from glimt.io.files_read import recorded
from glimt.viewer.watch import Watcher

ROOT = Path(__file__).resolve().parents[2]
SCENE = '''
[[mesh]]
file = "shape.obj"

[[light]]
type = "point"
position = [0, 2, 2]
'''
TRIANGLE = "mtllib shape.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n"


@pytest.fixture
def watched(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE)
    (tmp_path / "shape.obj").write_text(TRIANGLE)
    (tmp_path / "shape.mtl").write_text("newmtl m\nKd 1 0 0\n")
    with recorded() as files:
        load(path)
    news = queue.Queue()
    watcher = Watcher(path, files, news.put, news.put)
    yield path, files, news
    watcher.stop()


def test_the_files_of_a_load_are_known(watched):
    path, files, _ = watched
    assert files == {path, path.parent / "shape.obj", path.parent / "shape.mtl"}


def test_textures_count(tmp_path):
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    with recorded() as files:
        load(tmp_path / "examples" / "stone_room.toml")
    assert {"stone_room.toml", ".obj", ".png"} <= {"stone_room.toml"} | {file.suffix for file in files}


def test_nothing_is_recorded_outside(tmp_path):
    with recorded() as files:
        pass
    (tmp_path / "a.obj").write_text(TRIANGLE.split("\n", 1)[1])
    with pytest.warns(GlimtWarning, match="no material"):
        load(tmp_path / "a.obj")
    assert files == set()


@pytest.mark.parametrize("name", ["scene.toml", "shape.obj", "shape.mtl"])
def test_a_change_of_any_file_brings_the_new_scene(watched, name):
    path, _, news = watched
    file = path.parent / name
    text = file.read_text()
    changed = {"scene.toml": text + "\n[render]\nmax_bounces = 3\n", "shape.obj": text + "v 1 1 0\nf 2 4 3\n",
               "shape.mtl": text.replace("1 0 0", "0 1 0")}[name]
    time.sleep(0.2)
    file.write_text(changed)
    start = time.perf_counter()
    scene = news.get(timeout=20)
    print(f"{time.perf_counter() - start:.2f} s from the change to the new scene")
    mesh = scene.instances()[0].mesh
    assert (scene.settings.max_bounces, len(mesh.triangles), mesh.materials[0].diffuse) == {
        "scene.toml": (3, 1, (1, 0, 0)), "shape.obj": (0, 2, (1, 0, 0)), "shape.mtl": (0, 1, (0, 1, 0))}[name]
    time.sleep(0.5)
    assert news.empty()


def test_an_error_is_told_and_mended(watched):
    path, _, news = watched
    path.write_text(SCENE + "[render]\nbounces = 3\n")
    assert "scene.toml:9" in news.get(timeout=20)
    path.write_text(SCENE)
    assert len(news.get(timeout=20).instances()) == 1
    obj = path.parent / "shape.obj"
    obj.unlink()
    assert "shape.obj" in news.get(timeout=20)
    obj.write_text(TRIANGLE)
    assert len(news.get(timeout=20).instances()) == 1


def test_files_that_a_change_brings_are_watched_too(watched):
    path, _, news = watched
    (path.parent / "other.obj").write_text(TRIANGLE)
    path.write_text(SCENE.replace("shape.obj", "other.obj"))
    news.get(timeout=20)
    time.sleep(0.4)
    (path.parent / "other.obj").write_text(TRIANGLE + "v 1 1 0\nf 2 4 3\n")
    assert len(news.get(timeout=20).instances()[0].mesh.triangles) == 2
