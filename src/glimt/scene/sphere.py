"""An analytic sphere."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from glimt.errors import GlimtError
from glimt.scene import checks
from glimt.scene.material import Material


@dataclass(eq=False)
class Sphere:
    """A sphere in world space, never tessellated.

    Texcoords for its textures: u goes once around +Y from -X through +Z, v from the north pole (0) to the south (1).

    Parameters
    ----------
    center : (x, y, z)
    radius : float, above 0
    material : Material
    """

    center: tuple[float, float, float]
    radius: float
    material: Material = field(default_factory=Material)
    name: str = "sphere"

    def __post_init__(self) -> None:
        owner = f"sphere {self.name!r}"
        self.center = checks.vector(owner, "center", self.center)
        self.radius = checks.number(owner, "radius", self.radius, 0, checks.LARGEST)
        if self.radius == 0:
            raise GlimtError(f"{owner}: radius is 0")
        checks.kind(owner, "material", self.material, Material)

    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return (lo, hi) in world space."""
        return np.subtract(self.center, self.radius), np.add(self.center, self.radius)
