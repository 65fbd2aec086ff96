"""Compiling the kernels, with progress."""

from typing import Any

import numpy as np
from numba.core import event

from glimt import bvh
from glimt.engines.cpu.kernels.frame import render_tiles
from glimt.engines.engine import Progress
from glimt.kernel import remove_stale_caches
from glimt.layout import VIEW
from glimt.packed import PackedScene

_FUNCTIONS = 160
"""About how many functions Numba compiles on the way; only the progress bar depends on it."""


class _Steps(event.Listener):  # type: ignore[misc]
    """Counts the functions Numba has compiled."""

    def __init__(self, progress: Progress) -> None:
        self.progress, self.done = progress, 0

    def on_start(self, event: Any) -> None:
        pass

    def on_end(self, event: Any) -> None:
        self.done += 1
        self.progress("compiling kernels, first run only", min(0.99, self.done / _FUNCTIONS))


def compile_kernels(progress: Progress) -> None:
    """Compile every kernel of the engine and put it in the cache, by running it on next to nothing."""
    remove_stale_caches()
    with event.install_listener("numba:compile", _Steps(progress)):
        tree = bvh.build(np.zeros((2, 3), np.float32), np.ones((2, 3), np.float32))
        empty = np.zeros(64, np.float32)
        scene = PackedScene(bvh.build(empty[:0].reshape(0, 3), empty[:0].reshape(0, 3)).nodes, empty, tree.nodes,
                            *[empty] * 10)
        film = np.zeros((1, 1, 4), np.float32)
        render_tiles(scene, 0, np.zeros(VIEW.words, np.float32), film, 1, 0, np.zeros(16, np.int64),
                     np.zeros(16, np.int64))
    progress("compiling kernels, first run only", 1.0)
