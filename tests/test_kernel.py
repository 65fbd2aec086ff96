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


@pytest.mark.parametrize(("kind", "content"), [("nbc", b"not machine code"), ("nbi", b"")], ids=["code", "index"])
def test_a_damaged_cache_is_compiled_anew(program, tmp_path, kind, content):
    run(program, tmp_path)
    for file in (tmp_path / "kernels").rglob(f"*.{kind}"):
        file.write_bytes(content)
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


_BESIDE = """
import gc
import numba
from numba.core.registry import cpu_target
from numba.extending import overload
from glimt.kernel import inline, kernel

@numba.njit
def triangular(n):
    total = 0.0
    for k in range(int(n)):
        total += k
    return total

def shared(n):
    pass

@overload(shared)
def shared_by_all(n):
    return lambda n: triangular(n) + 1.0

@inline
def half(n):
    return 0.5 * n

@inline
def part(n):
    return half(half(n)) + shared(n)

@kernel
def ours(n):
    return part(n) + half(n)

@kernel
def broken(n):
    return part(n) + "text"

@numba.njit
def theirs(n):
    return shared(n)

@numba.njit
def with_parts(n):
    return part(n) + half(n)

codegen = cpu_target.target_context.codegen()
try:
    broken(4.0)
except numba.TypingError:
    print("refused", ours(4.0), theirs(4.0), triangular(4.0), with_parts(4.0))
print(type(codegen.create_library("some")).__name__, gc.isenabled())
gc.disable()
ours(4)
print(gc.isenabled())
"""


def test_what_is_not_ours_is_compiled_as_ever(program, tmp_path):
    program.write_text(_BESIDE)
    assert run(program, tmp_path) == ["refused", "10.0", "7.0", "6.0", "10.0", "JITCodeLibrary", "True", "False"]


_NEVER_CALLED = """
import numpy
from glimt.kernel import inline, kernel

@inline
def half(n):
    return 0.5 * n

@inline
def never_called(n):
    return half(n)

@inline
def called(n):
    return half(n) + 1.0

@kernel
def before(numbers):
    if numbers[0] == 0.1:  # no float32 is, so that LLVM leaves the call out
        return never_called(numbers[1])
    return called(numbers[1])

@kernel
def after(numbers):
    if numbers[0] != 0.1:
        return called(numbers[1])
    return never_called(numbers[1])

print(before(numpy.ones(2, numpy.float32)), after(numpy.ones(2, numpy.float32)))
"""


def test_what_a_part_needs_is_linked_though_a_part_that_is_never_called_needs_it_first(program, tmp_path):
    program.write_text(_NEVER_CALLED)
    assert run(program, tmp_path) == ["1.5", "1.5"]


KERNEL_SOURCES = [*PACKAGE.glob("lanes/*.py"), *PACKAGE.glob("engines/cpu/kernels/[a-z]*.py"),
                  *(PACKAGE / name for name in ("kernel.py", "layout.py", "packed/packed_scene.py", "bvh/wide.py",
                                                "bvh/binned_sah.py", "io/obj_parser.py", "io/obj_kernels.py"))]
OTHERS = ["scene/camera.py", "scene/mesh.py", "io/mtl.py"]

_KEYS = """
import sys
from pathlib import Path
from glimt import kernel
package = Path(kernel.__file__).parent
print(kernel._cache_key())
for name in sys.argv[1:]:
    text = (package / name).read_bytes()
    (package / name).write_bytes(text + b"# changed")
    print(kernel._cache_key())
    (package / name).write_bytes(text)
print(kernel._cache_key())
"""


def test_the_folder_is_named_after_every_kernel_source(tmp_path):
    names = [path.relative_to(PACKAGE).as_posix() for path in KERNEL_SOURCES]
    assert len(names) > 25
    shutil.copytree(PACKAGE, tmp_path / "glimt", ignore=shutil.ignore_patterns("__pycache__"))
    done = subprocess.run([sys.executable, "-c", _KEYS, *names, *OTHERS], capture_output=True, text=True, check=True,
                          env=os.environ | {"PYTHONPATH": str(tmp_path)}, timeout=120)
    before, *changed, after = done.stdout.split()
    assert before == after
    assert {name for name, key in zip([*names, *OTHERS], changed, strict=True) if key == before} == set(OTHERS)
    assert len(set(changed)) == len(names) + 1


def test_a_kernel_outside_the_package_is_compiled_anew_when_its_file_changes(program, tmp_path):
    assert run(program, tmp_path)[1] == "6.0"
    program.write_text(program.read_text().replace("2.0 * x", "4.0 * x"))
    assert run(program, tmp_path)[1] == "12.0"


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no limit for the size of files")
def test_a_full_disk_is_done_without(program, tmp_path):
    program.write_text("import resource\nresource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))\n"
                       + program.read_text())
    assert run(program, tmp_path)[1] == "6.0"


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
