"""What an engine gets to see of a scene."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from glimt.layout import TEXTURE, dtype

Words = NDArray[np.float32]


class PackedScene(NamedTuple):
    """Arrays of records, as float32 words whatever a field's type (see `glimt.layout` for each record).

    A tree below each mesh (BLAS, in object space) and one above the instances (TLAS, in world space). An index is
    global within its array; child codes of BLAS nodes count from the start of `blas_nodes` and `blas_blocks`.
    """

    tlas_nodes: Words  # NODE, root first
    tlas_blocks: Words  # INSTANCE_BLOCK
    blas_nodes: Words  # NODE
    blas_blocks: Words  # TRIANGLE_BLOCK
    instances: Words  # INSTANCE
    triangles: Words  # TRIANGLE
    clearances: Words  # CLEARANCE of each triangle; may change from not known to known while it is read
    vertices: Words  # VERTEX
    tangents: Words  # TANGENT
    materials: Words  # MATERIAL
    textures: Words  # TEXTURE
    levels: Words  # LEVEL
    texels: Words  # one word each
    lights: Words  # LIGHT
    spans: Words  # SPAN of each instance, when every ray is to test everything; empty: rays walk the trees

    @property
    def texture_count(self) -> int:
        """How many textures there are."""
        return int(np.count_nonzero(self.textures.view(dtype(TEXTURE))["levels"]))

    def memory_bytes(self) -> int:
        """Return the size of all arrays."""
        return sum(array.nbytes for array in self)
