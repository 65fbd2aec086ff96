"""Assembles the kernels for 64-bit Arm, in a process of its own: ``arm64.py folder``.

With `GLIMT_LANES`, and `NUMBA_CPU_FEATURES` as of such a processor, Numba lowers kernels as it would there. Where it
would optimize the result for this processor, LLVM does so for the other: all but running it needs no such machine.
"""

import sys
from pathlib import Path

import llvmlite.binding as llvm
import numba
import numpy as np
from numba.core.registry import cpu_target

from glimt.bvh import subtrees
from glimt.engines.cpu.kernels.debug import debug_tiles
from glimt.engines.cpu.kernels.frame import render_tiles
from glimt.engines.cpu.kernels.radiance import RADIANCE
from glimt.engines.cpu.kernels.traverse import TRACE
from glimt.engines.cpu.kernels.visits import count_visits
from glimt.kernel import _KernelLibrary, _PartLibrary
from glimt.layout import VIEW
from glimt.packed import PackedScene
from glimt.packed.clearance_kernels import find_clearances

TRIPLE = "aarch64-unknown-linux-gnu"


class _Lowered(Exception):  # noqa: N818 - not an error
    """Carries a kernel's LLVM module, with all that it calls."""


def hand_over(library):
    """Hand over the module of a kernel where Numba would optimize it."""
    raise _Lowered(str(library._final_module))


def lowered(name, compile_kernel):
    """Return the LLVM module of the kernel of that name as text, before it is optimized."""
    try:
        compile_kernel()
    except _Lowered as module:
        return str(module)
    raise AssertionError(f"{name} was not compiled")


def assembled(text):
    """Return (assembly, object code) of an LLVM module, optimized for the other processor."""
    target = llvm.Target.from_triple(TRIPLE).create_target_machine(
        cpu="generic", features="+neon", opt=3, reloc="default", codemodel="jitdefault", jit=True)  # as Numba does
    lines = [line for line in text.splitlines() if not line.startswith(("target triple", "target datalayout"))]
    module = llvm.parse_assembly("\n".join([f'target triple = "{TRIPLE}"', *lines]))
    module.data_layout = str(target.target_data)
    passes = llvm.create_pass_builder(target, llvm.create_pipeline_tuning_options(3))
    passes.getModulePassManager().run(module, passes)
    module.verify()
    return target.emit_assembly(module.clone()), target.emit_object(module)


def main(folder):
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    _KernelLibrary._optimize_final_module = hand_over
    cpu_target.target_context.codegen()._library_class = _PartLibrary  # nothing else is assembled either

    words, rows, ints, longs = (np.zeros(64, np.float32), np.zeros((2, 3), np.float32), np.zeros(64, np.int32),
                                np.zeros(64, np.int64))
    tasks = longs[:subtrees.TASK_WORDS].reshape(1, -1)
    picture = (PackedScene(*[words] * len(PackedScene._fields)), 0, words[:VIEW.words].copy(),
               np.zeros((1, 1, 4), np.float32))
    shared_by_tiles = longs, longs, np.zeros((3, 7, 0), np.float32)
    arguments = {
        render_tiles: (*picture, 1, 0, *shared_by_tiles),
        debug_tiles: (*picture, 0, rows, *shared_by_tiles),
        count_visits: (*picture, *shared_by_tiles),
        subtrees.prepare_boxes: (rows, rows, words, words, longs),
        subtrees.build_subtrees: (words, words, words, ints, ints, 4, tasks, 0, longs),
        subtrees.lay_out: (tasks, words, words, ints, ints, words, ints.reshape(-1, 4), longs),
        find_clearances: (words, words, 0, 0, 0, 0, *[np.float32(1)] * 3, ints),
    }
    modules = {shared.py_func.__name__: lowered(shared.py_func.__name__, shared.get_ready)
               for shared in (TRACE, RADIANCE)}
    for shared in (TRACE, RADIANCE):
        shared._address.value = 1  # nothing is called
    for kernel, values in arguments.items():
        kinds = tuple(numba.typeof(value) for value in values)
        name = kernel.py_func.__name__
        modules[name] = lowered(name, lambda kernel=kernel, kinds=kinds: kernel.compile(kinds))
    for name, text in modules.items():
        assembly, code = assembled(text)
        (folder / f"{name}.ll").write_text(text)
        (folder / f"{name}.s").write_text(assembly)
        (folder / f"{name}.o").write_bytes(code)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
