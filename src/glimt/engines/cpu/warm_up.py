"""Compiling the kernels on the first run, in two processes at once, with progress.

Most of the time is Python's, in Numba, so threads would take turns: a second process compiles the frame kernel, and
this one finds it in the cache.
"""

import os
import subprocess
import sys
import threading
from typing import Any

import numpy as np
from numba.core import caching, event

from glimt import bvh
from glimt.engines.cpu.kernels.frame import render_tiles
from glimt.engines.engine import Progress
from glimt.kernel import is_ready, remove_stale_caches
from glimt.layout import VIEW
from glimt.packed import PackedScene

STAGE = "compiling kernels, first run only"
_FUNCTIONS = 75
"""About how many functions Numba compiles on the way; only the progress bar depends on it."""
_PATIENCE_SECONDS = 300
_CODE = "from glimt.engines.cpu.warm_up import report_frame; report_frame()"


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
    """Compile the frame kernel and put it in the cache, by running it on nothing."""
    with event.install_listener("numba:compile", _Steps(progress)):
        none = np.zeros((0, 3), np.float32)
        nodes, empty = bvh.build(none, none).nodes, np.zeros(64, np.float32)
        scene = PackedScene(nodes, empty, nodes, *[empty] * 10)
        view, film = np.zeros(VIEW.words, np.float32), np.zeros((1, 1, 4), np.float32)
        render_tiles(scene, 0, view, film, 1, 0, np.zeros(16, np.int64), np.zeros(16, np.int64),
                     np.zeros((3, 7, 0), np.float32))


def report_frame() -> None:
    """Compile the frame kernel for another process, which reads the progress, 0 to 1, from our output."""
    compile_frame(lambda stage, share: print(f"{share:.3f}", flush=True))


class Helper:
    """The process that compiles the frame kernel."""

    def __init__(self) -> None:
        self.share = 0.0
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(path or os.getcwd() for path in sys.path)}
        self._process = subprocess.Popen([sys.executable, "-c", _CODE], stdin=subprocess.DEVNULL, text=True,
                                         stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment)
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout as lines:
            for line in lines:
                self.share = float(line)

    def wait(self, progress: Progress) -> None:
        """Wait until it is done; whatever became of it, it is gone afterwards."""
        try:
            for _ in range(10 * _PATIENCE_SECONDS):
                progress(STAGE, self.share)
                try:
                    self._process.wait(0.1)
                    return
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
    alone = (os.cpu_count() or 1) == 1 or "python" not in os.path.basename(sys.executable or "").lower()
    uncached = isinstance(render_tiles._cache, caching.NullCache)
    if _helper is None and not (alone or uncached):
        _helper = Helper()


def _load() -> None:
    box = np.zeros((2, 3), np.float32)
    bvh.build(box, box + 1)
    compile_frame(lambda stage, share: None)


def compile_kernels(progress: Progress) -> None:
    """Compile every kernel of the engine and put it in the cache."""
    global _helper
    progress(STAGE, 0.0)
    remove_stale_caches()
    begin()
    box = np.zeros((2, 3), np.float32)
    bvh.build(box, box + 1)
    helper, _helper = _helper, None
    if helper:
        helper.wait(progress)
    compile_frame(progress)  # from the cache, unless the helper failed
    progress(STAGE, 1.0)
