"""Compiling the kernels on the first run, in two or three processes at once, with progress.

Most of the time is Python's, in Numba, so threads would take turns: this process compiles the frame kernel, others what
that calls, the tree builder and what develops films, which are then found in the cache.
"""

import os
import subprocess
import threading
import time
from typing import Any

import numpy as np
from numba.core import event

from glimt import bvh
from glimt.color import develop
from glimt.engines.cpu.control import new_control, new_counters
from glimt.engines.cpu.kernels.frame import render_tiles
from glimt.engines.cpu.kernels.traverse import TRACE
from glimt.engines.engine import Progress
from glimt.kernel import compile_elsewhere, is_ready, remove_stale_caches
from glimt.layout import VIEW
from glimt.packed import PackedScene

STAGE = "compiling kernels, first run only"
_FUNCTIONS = 82
"""About how many functions Numba compiles on the way; only the progress bar depends on it."""
_PATIENCE_SECONDS = 300
_CODE = "from glimt.engines.cpu.warm_up import compile_before_and_after, compile_traversal; "


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


def compile_traversal() -> None:
    """Compile what the frame kernel calls."""
    TRACE.get_ready()


def compile_before_and_after() -> None:
    """Compile what comes before and after a frame, the tree builder and what develops films, by using them."""
    box = np.zeros((2, 3), np.float32)
    bvh.build(box, box + 1)
    develop(np.zeros((1, 1, 4), np.float32))


class Helpers:
    """The processes that compile the rest, the first of them the traversal."""

    def __init__(self, processes: "list[subprocess.Popen[bytes]]") -> None:
        self._processes = processes

    def wait_for_traversal(self) -> None:
        """Wait until the traversal is compiled, or nothing more can be expected."""
        for _ in range(20 * _PATIENCE_SECONDS):
            if is_ready(TRACE) or self._processes[0].poll() is not None:
                return
            time.sleep(0.05)

    def wait(self) -> None:
        """Wait until they are done; whatever became of them, they are gone afterwards."""
        end = time.monotonic() + _PATIENCE_SECONDS
        try:
            for process in self._processes:
                process.wait(max(0.0, end - time.monotonic()))
        except subprocess.TimeoutExpired:
            pass
        finally:
            for process in self._processes:
                process.kill()
                process.wait()


_helpers: Helpers | None = None


def begin() -> None:
    """Start in the background to load machine code; or to compile it, and `compile_kernels` takes the result."""
    global _helpers
    if is_ready(render_tiles):
        threading.Thread(target=_load, name="glimt-load", daemon=True).start()  # LLVM works without the GIL
        return
    cores = os.cpu_count() or 1
    if _helpers is None and cores > 1:
        rest = ["compile_traversal()", "compile_before_and_after()"]
        started = [compile_elsewhere(_CODE + each) for each in (rest if cores > 2 else ["; ".join(rest)])]
        processes = [each for each in started if each]
        _helpers = Helpers(processes) if processes else None


def _load() -> None:
    _compile_rest()
    compile_frame(lambda stage, share: None)


def _compile_rest() -> None:
    compile_traversal()
    compile_before_and_after()


def compile_kernels(progress: Progress) -> None:
    """Compile every kernel of the engine and put it in the cache."""
    global _helpers
    progress(STAGE, 0.0)
    remove_stale_caches()
    begin()
    helpers, _helpers = _helpers, None
    try:
        if helpers:
            TRACE.awaited = helpers.wait_for_traversal
        compile_frame(progress)
    finally:
        if helpers:
            helpers.wait()
    _compile_rest()  # from the cache, unless a helper failed
    progress(STAGE, 1.0)
