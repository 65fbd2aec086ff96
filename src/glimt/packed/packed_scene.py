"""What an engine gets to see of a scene."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from glimt.layout import FACE, INSTANCE, MESH_KIND, MISS, TEXTURE, dtype

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
    triangles: Words  # TRIANGLE, those of a mesh in the order of its leaves
    faces: Words  # FACE of each triangle; clearances may change from not known to known while they are read
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

    def numbers_in_mesh(self, prim: NDArray[np.int32], inst: NDArray[np.int32]) -> NDArray[np.int32]:
        """Return which triangles of their meshes the primitives of instances are; as it is where there is no mesh."""
        numbers, records = np.array(prim), self.instances.view(dtype(INSTANCE))
        met = inst != MISS
        met[met] = records["kind"][inst[met]] == MESH_KIND
        numbers[met] = self.faces.view(dtype(FACE))["number"][records["first_triangle"][inst[met]] + prim[met]]
        return numbers

    def memory_bytes(self) -> int:
        """Return the size of all arrays."""
        return sum(array.nbytes for array in self)
