"""Compiling the kernels on the first run, in two processes at once, with progress.

Most of the time is Python's, in Numba, so threads would take turns: this process compiles the frame kernel, a second
one what that calls and the tree builder, which are then found in the cache.
"""

import os
import subprocess
import threading
import time
from typing import Any

import numpy as np
from numba.core import event

from glimt import bvh
from glimt.engines.cpu.control import new_control, new_counters
from glimt.engines.cpu.kernels.frame import render_tiles
from glimt.engines.cpu.kernels.traverse import TRACE
from glimt.engines.engine import Progress
from glimt.kernel import compile_elsewhere, is_ready, remove_stale_caches
from glimt.layout import VIEW
from glimt.packed import PackedScene

STAGE = "compiling kernels, first run only"
_FUNCTIONS = 97
"""About how many functions Numba compiles on the way; only the progress bar depends on it."""
_PATIENCE_SECONDS = 300
_CODE = "from glimt.engines.cpu.warm_up import compile_rest; compile_rest()"


class _Steps(event.Listener):  # type: ignore[misc]
    """Counts the functions Numba has compiled."""

    def __init__(self, progress: Progress) -> None:
        self.progress, self.done = progress, 0

    def on_start(self, event: Any) -> None:
        pass

    def on_end(self, event: Any) -> None:
        self.done += 1
        self.progress(STAGE, min(0.99, self.done / _FUNCTIONS))


def compile_frame(progress: Progress) -> None:
    """Compile the frame kernel, and what it calls, and put it in the cache, by running it on nothing."""
    with event.install_listener("numba:compile", _Steps(progress)):
        none = np.zeros(64, np.float32)
        scene = PackedScene(*[none] * len(PackedScene._fields))
        render_tiles(scene, 0, np.zeros(VIEW.words, np.float32), np.zeros((0, 0, 4), np.float32), 1, 0,
                     new_control(), new_counters(1)[0], np.zeros((3, 7, 0), np.float32))


def compile_rest() -> None:
    """Compile the traversal and the tree builder."""
    TRACE.get_ready()
    box = np.zeros((2, 3), np.float32)
    bvh.build(box, box + 1)


class Helper:
    """Waits for the process that compiles the rest."""

    def __init__(self, process: "subprocess.Popen[bytes]") -> None:
        self._process = process

    def wait_for_traversal(self) -> None:
        """Wait until the traversal is compiled, which comes first, or nothing more can be expected."""
        for _ in range(20 * _PATIENCE_SECONDS):
            if is_ready(TRACE) or self._process.poll() is not None:
                return
            time.sleep(0.05)

    def wait(self) -> None:
        """Wait until it is done; whatever became of it, it is gone afterwards."""
        try:
            self._process.wait(_PATIENCE_SECONDS)
        except subprocess.TimeoutExpired:
            pass
        finally:
            self._process.kill()
            self._process.wait()


_helper: Helper | None = None


def begin() -> None:
    """Start in the background to load machine code; or to compile it, and `compile_kernels` takes the result."""
    global _helper
    if is_ready(render_tiles):
        threading.Thread(target=_load, name="glimt-load", daemon=True).start()  # LLVM works without the GIL
        return
    if _helper is None and (os.cpu_count() or 1) > 1:
        process = compile_elsewhere(_CODE)
        _helper = Helper(process) if process else None


def _load() -> None:
    compile_rest()
    compile_frame(lambda stage, share: None)


def compile_kernels(progress: Progress) -> None:
    """Compile every kernel of the engine and put it in the cache."""
    global _helper
    progress(STAGE, 0.0)
    remove_stale_caches()
    begin()
    helper, _helper = _helper, None
    try:
        if helper:
            TRACE.awaited = helper.wait_for_traversal
        compile_frame(progress)
    finally:
        if helper:
            helper.wait()
    compile_rest()  # from the cache, unless the helper failed
    progress(STAGE, 1.0)
