"""A dahlia of 1,000 petals: instances of one mesh along a Fibonacci spiral."""

import numpy as np
from numpy.typing import NDArray

from shapes import panel, petal
from text_files import table, turn

PETALS = 1000

MESHES = {"ground": [panel("", (-12, 0, 12), (24, 0, 0), (0, 0, -24), 24)], "petal": petal("")}


def scene() -> str:
    """Return the scene file."""
    sand = {"file": "textures/plaster.png", "scale": [7, 7]}
    relief = {"file": "textures/plaster_normal.png", "scale": [7, 7]}
    return "".join((
        "# A dahlia: 1,000 instances of one petal along a Fibonacci spiral, every second one mirrored.\n",
        table("render", size=[800, 600], samples=2, background=[0.02, 0.03, 0.05], ambient=0.2),
        table("camera", position=[0, 5.4, 5.4], target=[0, 0.3, 0.15], fov_deg=32),
        table("light", name="sun", type="directional", direction=[0.75, -1, -0.45], diffuse=[1.25, 1.17, 1.05]),
        table("light", name="lantern", type="point", position=[3.2, 1.6, 1.8], radius=2, diffuse=[1.4, 0.65, 0.25]),
        table("material", name="heart", diffuse=[0.80, 0.50, 0.06], specular=0.15, exponent=20),
        table("material", name="inner", diffuse=[0.85, 0.22, 0.05], specular=0.2, exponent=30),
        table("material", name="middle", diffuse=[0.75, 0.06, 0.09], specular=0.25, exponent=40),
        table("material", name="rim", diffuse=[0.72, 0.10, 0.30], specular=0.25, exponent=40),
        table("material", name="sand", diffuse=[0.50, 0.46, 0.42], specular=0.1, exponent=20,
              diffuse_texture=sand, normal_texture=relief, normal_scale=2.5),
        table("mesh", name="ground", file="meshes/ground.obj", material="sand"),
        table("mesh", name="petal", file="meshes/petal.obj"),
        *(_petal(i) for i in range(PETALS))))


def _petal(i: int) -> str:
    """Return one petal of the flower: `i` counts from the heart outwards."""
    share = (i + 0.5) / PETALS
    around = i * np.pi * (3 - 5**0.5)  # the golden angle: no two petals cover each other
    rise = np.radians(84 - 80 * share**0.5)
    length = 0.2 + 1.1 * share**0.5
    material = ("heart", "inner", "middle", "rim")[np.searchsorted((0.05, 0.22, 0.55), share)]
    out, up = np.array([np.cos(around), 0, np.sin(around)]), np.array([0.0, 1, 0])
    foot = 0.9 * share**0.5 * out + (0.75 - 0.70 * share) * up
    # The petal's own axes: x along it, z to its side.
    x = np.cos(rise) * out + np.sin(rise) * up
    z = np.array([-np.sin(around), 0, np.cos(around)])
    axis, angle_deg = _axis_angle(np.stack([x, np.cross(z, x), z], 1))
    mirror = -1 if i % 2 else 1
    return table("instance", mesh="petal", material=material, scale=[length, length, mirror * length],
                 rotate=turn(axis, angle_deg), translate=foot.tolist())


def _axis_angle(rotation: NDArray[np.float64]) -> tuple[list[float], float]:
    """Return the axis and the angle in degrees of a (3, 3) rotation."""
    axis = np.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]])
    length = float(np.linalg.norm(axis))
    return (axis / length).tolist(), float(np.degrees(np.arctan2(length, np.trace(rotation) - 1)))
