"""A mesh placed in the world."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from glimt import linalg
from glimt.errors import GlimtError
from glimt.scene import checks
from glimt.scene.material import Material
from glimt.scene.mesh import Mesh


@dataclass(eq=False)
class Instance:
    """One placement of a mesh: a thousand instances cost one mesh and a thousand matrices.

    Parameters
    ----------
    mesh : Mesh
    object_to_world : (3, 4) or (4, 4) float64
        Any affine matrix that can be inverted: rotated, mirrored, scaled differently by axis.
    material : Material, optional
        Replaces all materials of the mesh.
    """

    mesh: Mesh
    object_to_world: NDArray[np.float64] = field(default_factory=linalg.identity)
    material: Material | None = None
    name: str = "instance"

    def __post_init__(self) -> None:
        owner = f"instance {self.name!r}"
        checks.kind(owner, "mesh", self.mesh, Mesh)
        checks.kind(owner, "material", self.material, Material, type(None))
        matrix = checks.array(owner, "object_to_world", self.object_to_world, (None, 4), np.float64)
        if len(matrix) == 4:
            if not np.allclose(matrix[3], [0, 0, 0, 1]):
                raise GlimtError(f"{owner}: the last row of object_to_world is not 0 0 0 1")
            matrix = matrix[:3]
        self.object_to_world = checks.array(owner, "object_to_world", matrix, (3, 4), np.float64)
        if np.abs(self.object_to_world).max() > checks.LARGEST:
            raise GlimtError(f"{owner}: object_to_world has an entry beyond {checks.LARGEST:g}; scale the scene down")
        # Singular means: no inverse whose entries are worth anything in float32.
        linear = self.object_to_world[:, :3]
        rank = np.linalg.matrix_rank(linear, tol=np.abs(linear).max() * 1e-7)
        if rank < 3 or np.abs(np.linalg.inv(linear)).max() > checks.LARGEST:
            raise GlimtError(f"{owner}: object_to_world is singular (it flattens the mesh), give every axis a size")

    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return (lo, hi) in world space, tight for the box around the mesh."""
        return linalg.transform_box(self.object_to_world, *self.mesh.bounds())
