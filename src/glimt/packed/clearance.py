"""How far from each triangle nothing stands in the way of rays that leave it, worked out beside the pictures.

It takes three to five microseconds a triangle: too long to wait for, and more than one picture of the mesh can win
back. So it is begun with the second picture, in a thread of its own; until then nothing is known, which is no less
right.
"""

import contextlib
import os
import sys
import threading
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from glimt.kernel import compile_elsewhere, is_ready
from glimt.packed.clearance_kernels import find_clearances
from glimt.packed.meshes import CLEAR_UNIT, note_clearances
from glimt.scene.mesh import Mesh

_LIFT = 2.0**-21
"""Rays start at least this share of the mesh's size above the triangle they leave: a quarter of OFFSET_ERROR."""
_BLOCKS = 2048  # leaf blocks at a time: about 30 ms
_NICENESS = 10


class LookAround(NamedTuple):
    """A mesh to look around in, and where it is in the arrays of a scene.

    first_block, end_block: of its leaves; first_triangle: where its faces begin.
    """

    mesh: Mesh
    root: int
    first_block: int
    end_block: int
    first_triangle: int
    clear_unit: float


class ClearanceFinder:
    """Finds the clearances of meshes in a thread.

    Parameters
    ----------
    nodes, blocks, faces : float32
        Those of a `PackedScene`.
    meshes : list of LookAround
    """

    def __init__(self, nodes: NDArray[np.float32], blocks: NDArray[np.float32], faces: NDArray[np.float32],
                 meshes: list[LookAround]) -> None:
        self._arrays, self._faces = (nodes, blocks), faces.view(np.int32)
        self._meshes = meshes
        self._pictures, self._stopped = 0, False
        self._thread: threading.Thread | None = None

    def begin_picture(self) -> None:
        """Start with the second picture: one alone does not win back what this costs."""
        self._pictures += 1
        if self._pictures == 2:
            self.begin()

    def begin(self) -> None:
        """Start, unless that was done before."""
        if self._thread is None and self._meshes and not self._stopped:
            self._thread = threading.Thread(target=self._find, name="glimt-clearance", daemon=True)
            self._thread.start()

    def finish(self) -> None:
        """Start, and wait until all is found."""
        self.begin()
        if self._thread:
            self._thread.join()

    def stop(self) -> None:
        """Leave it at what is found so far: the arrays are no longer used."""
        self._stopped = True

    def _find(self) -> None:
        if sys.platform == "linux":  # where threads have priorities: pictures come first
            with contextlib.suppress(OSError):
                os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICENESS)
        if not is_ready(find_clearances) and not _compile():
            return
        for each in self._meshes:
            unit = abs(each.clear_unit)
            side, lift, per_unit = (np.float32(number) for number in (
                np.sign(each.clear_unit), unit / CLEAR_UNIT * _LIFT, 1 / unit))
            for first in range(each.first_block, each.end_block, _BLOCKS):
                if self._stopped:
                    return
                find_clearances(*self._arrays, each.root, first, min(first + _BLOCKS, each.end_block),
                                each.first_triangle, side, lift, per_unit, self._faces)
            note_clearances(each.mesh, self._faces)


def compile_kernel() -> None:
    """Compile the kernel, and put it in the cache, by running it on nothing."""
    none, one = np.zeros(64, np.float32), np.float32(1)
    find_clearances(none, none, 0, 0, 0, 0, one, one, one, none.view(np.int32))


def _compile() -> bool:
    """Compile the kernel by another process, which does not hold up this one; return whether it can be loaded now."""
    compiling = compile_elsewhere("from glimt.packed.clearance import compile_kernel; compile_kernel()")
    return compiling is not None and compiling.wait() == 0 and is_ready(find_clearances)
