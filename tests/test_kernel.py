"""The kernel cache: found again by another process, never stale, never in the way."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import glimt
from glimt import kernel

PACKAGE = Path(glimt.__file__).parent

# A kernel of our own, so that no test waits for the engine's.
_PROGRAM = """
import numpy
from glimt.kernel import KERNELS, cache_folder, is_ready, inline, kernel

@inline
def twice(x):
    return 2.0 * x

@kernel
def total(numbers):
    result = 0.0
    for x in numbers:
        result += twice(x)
    return result

print(is_ready(total), total(numpy.ones(3)), is_ready(total), cache_folder().name)
"""


def run(program, folder, **environment):
    """Return the words that a program prints in a process of its own, with its kernel cache in `folder`."""
    done = subprocess.run([sys.executable, str(program)], env=os.environ | {"GLIMT_CACHE_DIR": str(folder)}
                          | environment, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


@pytest.fixture
def program(tmp_path):
    path = tmp_path / "program.py"
    path.write_text(_PROGRAM)
    return path


def test_a_second_process_finds_the_machine_code(program, tmp_path):
    assert run(program, tmp_path)[:3] == ["False", "6.0", "True"]
    assert run(program, tmp_path)[:3] == ["True", "6.0", "True"]


def test_a_damaged_cache_is_compiled_anew(program, tmp_path):
    run(program, tmp_path)
    for file in (tmp_path / "kernels").rglob("*.nbc"):
        file.write_bytes(b"not machine code")
    assert run(program, tmp_path)[1] == "6.0"
    assert run(program, tmp_path)[:2] == ["True", "6.0"]


def test_a_folder_that_cannot_be_written_is_done_without(program, tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("a file where the cache's folder should be")
    assert run(program, blocked)[1] == "6.0"


def test_lane_widths_have_folders_of_their_own(program, tmp_path):
    folders = {run(program, tmp_path, GLIMT_LANES=lanes)[3] for lanes in ("4", "8", "16")}
    assert len(folders) == 3


def test_a_strange_lane_width_is_refused(monkeypatch):
    monkeypatch.setenv("GLIMT_LANES", "5")
    with pytest.raises(glimt.GlimtError, match="GLIMT_LANES is '5', expected 4, 8 or 16"):
        kernel.host_lanes()


@pytest.mark.parametrize(("file", "changes"), [
    ("engines/cpu/kernels/sphere.py", True), ("layout.py", True), ("lanes/math.py", True), ("bvh/wide.py", True),
    ("io/obj_parser.py", True), ("cli/app.py", False), ("scene/camera.py", False)])
def test_the_folder_is_named_after_every_kernel_source(tmp_path, file, changes):
    copy = tmp_path / "glimt"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    ask = "from glimt.kernel import cache_folder; print(cache_folder().name)"

    def name():
        return subprocess.run([sys.executable, "-c", ask], env=os.environ | {"PYTHONPATH": str(tmp_path)},
                              capture_output=True, text=True, check=True).stdout

    before = name()
    with open(copy / file, "a") as source:
        source.write("\n# changed\n")
    assert (name() != before) == changes


def test_old_caches_are_removed(tmp_path, monkeypatch):
    monkeypatch.setenv("GLIMT_CACHE_DIR", str(tmp_path))
    kernel.cache_folder.cache_clear()
    current, stale, recent = kernel.cache_folder(), tmp_path / "kernels" / "stale", tmp_path / "kernels" / "recent"
    for folder in (current, stale, recent):
        folder.mkdir(parents=True)
    for folder in (current, stale):
        os.utime(folder, (0, 0))
    kernel.remove_stale_caches()
    assert current.is_dir()
    assert recent.is_dir()
    assert not stale.exists()
    kernel.cache_folder.cache_clear()
