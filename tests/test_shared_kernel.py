"""Kernels that others call by their address: one copy for all, in the cache like any other."""

import inspect

import pytest

from glimt.engines.cpu.kernels.debug import debug_tiles
from glimt.engines.cpu.kernels.frame import render_tiles
from glimt.engines.cpu.kernels.query import find_blocked, find_hits
from glimt.engines.cpu.kernels.radiance import RADIANCE
from glimt.engines.cpu.kernels.refine import refine_tiles
from glimt.engines.cpu.kernels.traverse import TRACE
from glimt.kernel import KERNELS
from test_kernel import run

_PROGRAM = """
from concurrent.futures import ThreadPoolExecutor
import numpy
from numba import types
from glimt.kernel import KERNELS, SharedKernel, calls, is_ready, kernel
from glimt.lanes import pointer

def scaled_sum(numbers, count, factor):
    total = numpy.float32(0)
    for k in range(count):
        total += numbers[k]
    return total * factor

SHARED = SharedKernel(scaled_sum, (types.CPointer(types.float32), types.int64, types.float32))
call = SHARED.call

@calls(SHARED)
@kernel
def whole(numbers):
    return call((pointer(numbers), len(numbers), 2))  # an integer becomes the float that is asked for

@calls(SHARED)
@kernel
def start(numbers):
    return call((pointer(numbers), numpy.int32(1), 10.0)) + 0.5

waited = []
SHARED.awaited = lambda: waited.append(True)
numbers = numpy.array([1, 2, 4], numpy.float32)
print(is_ready(SHARED), len(SHARED.overloads))
"""

_IN_TURN = _PROGRAM + """
print(whole(numbers), start(numbers))
address = SHARED._address.value
SHARED.get_ready()
same = address == SHARED._address.value
print(is_ready(SHARED), len(SHARED.overloads), len(waited), SHARED._compiled.cache_hits, same)
"""

_AT_ONCE = _PROGRAM + """
with ThreadPoolExecutor(4) as pool:
    jobs = [pool.submit(kernel, numbers) for kernel in (whole, start, whole, start)]
print(*[job.result() for job in jobs], len(waited))
"""


@pytest.fixture
def program(tmp_path):
    def write(text):
        path = tmp_path / "program.py"
        path.write_text(text)
        return path

    return write


def machine_code(folder):
    """Return the files of a cache that hold the shared function."""
    return sorted((folder / "kernels").rglob("program.scaled_sum-*.nbc"))


def test_two_kernels_share_one_copy(program, tmp_path):
    assert run(program(_IN_TURN), tmp_path) == ["False", "0", "14", "10.5", "True", "1", "1", "0", "True"]
    assert len(machine_code(tmp_path)) == 1


def test_a_second_process_finds_it(program, tmp_path):
    run(program(_IN_TURN), tmp_path)
    assert run(program(_IN_TURN), tmp_path) == ["True", "0", "14", "10.5", "True", "1", "1", "1", "True"]


def test_threads_that_need_it_at_once_compile_it_once(program, tmp_path):
    assert run(program(_AT_ONCE), tmp_path) == ["False", "0", "14", "10.5", "14", "10.5", "1"]


@pytest.mark.parametrize("kind", ["nbc", "nbi"])
def test_a_damaged_file_is_written_anew(program, tmp_path, kind):
    run(program(_IN_TURN), tmp_path)
    sound = machine_code(tmp_path)[0].stat().st_size
    for file in (tmp_path / "kernels").rglob(f"*.{kind}"):
        file.write_bytes(b"not machine code")
    assert run(program(_IN_TURN), tmp_path)[2:4] == ["14", "10.5"]
    assert [file.stat().st_size for file in machine_code(tmp_path)] == [sound]
    assert run(program(_IN_TURN), tmp_path) == ["True", "0", "14", "10.5", "True", "1", "1", "1", "True"]


def test_a_folder_that_cannot_be_written_is_done_without(program, tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("a file where the cache's folder should be")
    assert run(program(_IN_TURN), blocked) == ["False", "0", "14", "10.5", "True", "1", "1", "0", "True"]


def test_it_is_ready_before_a_kernel_from_the_cache_runs(program, tmp_path):
    """The kernel is found, the shared function is not."""
    run(program(_IN_TURN), tmp_path)
    for file in machine_code(tmp_path):
        file.unlink()
    assert run(program(_IN_TURN), tmp_path)[2:4] == ["14", "10.5"]


def reached(function):
    """Return what a function, and what it calls, refers to by name."""
    seen, todo, values = set(), [function], []
    while todo:
        function = todo.pop()
        if function in seen:
            continue
        seen.add(function)
        found = [function.__globals__.get(name) for name in function.__code__.co_names]
        values += found
        todo += [value.py_func for value in found if hasattr(value, "py_func")]
    return values


def shared_by(function):
    """Return the shared kernels that a function calls, and those that they call."""
    values = reached(function)
    called = {shared for shared in (TRACE, RADIANCE) if any(value is shared.call for value in values)}
    return called.union(*(shared_by(shared.py_func) for shared in called))


def test_every_kernel_makes_ready_what_it_calls():
    """Else it would call the address 0."""
    callers = {kernel: shared_by(kernel.py_func) for kernel in KERNELS}
    assert callers[render_tiles] == callers[refine_tiles] == callers[debug_tiles] == {TRACE, RADIANCE}
    assert callers[find_hits] == callers[find_blocked] == {TRACE}
    for kernel, called in callers.items():
        if called:
            assert set(inspect.getclosurevars(kernel.compile).nonlocals["shared"]) == called
