"""Small scenes and float64 references that the tests of shading share."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from glimt import Camera, Instance, Material, Mesh, Renderer, RenderSettings, Scene, Texture
from glimt.film import Film

Array = NDArray[np.float64]


def film(*things: Any, camera: Camera, size: tuple[int, int] = (1, 1), **settings: Any) -> Film:
    """Return the film of a scene made of `things`."""
    scene = Scene(camera=camera, settings=RenderSettings(*size, **settings)).add(*things)
    return Renderer(scene, threads=1).render()


def picture(*things: Any, camera: Camera, size: tuple[int, int] = (1, 1), **settings: Any) -> Array:
    """Return the linear radiance, (h, w, 3), of a scene made of `things`."""
    return film(*things, camera=camera, size=size, **settings).radiance.astype(np.float64)


def pixel(*things: Any, camera: Camera, **settings: Any) -> Array:
    """Return the radiance (3,) along the camera's line of sight."""
    return picture(*things, camera=camera, **settings)[0, 0]


def plane(material: Material | None = None, half: float = 1.0, *, smooth: bool = False, flip_u: bool = False,
          texcoords: ArrayLike | None = None) -> Mesh:
    """Return a square in the plane z = 0 that faces +Z; the texture stands upright as seen from there."""
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], np.float64)
    u, v = (corners[:, 0] + 1) / 2, (1 - corners[:, 1]) / 2
    if texcoords is None:
        texcoords = np.column_stack([1 - u if flip_u else u, v])
    normals = np.tile([0.0, 0.0, 1.0], (4, 1)) if smooth else None
    return Mesh(np.column_stack([corners * half, np.zeros(4)]), [[0, 1, 2], [0, 2, 3]], normals, texcoords,
                [material or Material()])


def placed(mesh: Mesh, matrix: ArrayLike, material: Material | None = None) -> Instance:
    """Return an instance with the linear part `matrix` (3, 3)."""
    return Instance(mesh, np.column_stack([np.asarray(matrix, np.float64), np.zeros(3)]), material)


def facing(distance: float = 3.0, half: float = 1.0, x: float = 0.0, y: float = 0.0) -> Camera:
    """Return a camera on the +Z side whose picture shows exactly ±half around (x, y) of the plane z = 0."""
    return Camera((x, y, distance), (x, y, 0), (0, 1, 0), float(np.degrees(2 * np.arctan(half / distance))))


def ray_directions(camera: Camera, width: int, height: int) -> Array:
    """Return unit directions, (height, width, 3), through the pixels' centres."""
    right, up, look = camera.basis()
    reach = np.tan(np.radians(camera.fov_deg) / 2)
    x = (2 * (np.arange(width) + 0.5) / width - 1) * reach * width / height
    y = (1 - 2 * (np.arange(height) + 0.5) / height) * reach
    directions = look + x[None, :, None] * right + y[:, None, None] * up
    return unit(directions)


def plane_points(camera: Camera, width: int, height: int) -> Array:
    """Return where the pixels' rays meet the plane z = 0, (height, width, 3)."""
    directions = ray_directions(camera, width, height)
    return np.asarray(camera.position) - directions * (camera.position[2] / directions[..., 2:])


def sphere_distance(origin: ArrayLike, directions: Array, center: ArrayLike, radius: float) -> Array:
    """Return the first distance in front of unit rays to a sphere, NaN for a miss."""
    to_center = np.asarray(center, np.float64) - origin
    nearest = (to_center * directions).sum(-1)
    discriminant = radius**2 - ((to_center - directions * nearest[..., None])**2).sum(-1)
    half_chord = np.sqrt(np.where(discriminant >= 0, discriminant, 0))
    t = np.where(nearest > half_chord, nearest - half_chord, nearest + half_chord)
    return np.where((discriminant >= 0) & (t > 0), t, np.nan)


def unit(vectors: ArrayLike) -> Array:
    """Return (..., 3) vectors at unit length."""
    vectors = np.asarray(vectors, np.float64)
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def direction(tilt_deg: float, around_deg: float = 0.0) -> Array:
    """Return the unit vector that leans `tilt_deg` from +Z towards the direction `around_deg` in the xy plane."""
    tilt, around = np.radians(tilt_deg), np.radians(around_deg)
    return np.array([np.sin(tilt) * np.cos(around), np.sin(tilt) * np.sin(around), np.cos(tilt)])


def normal_texture(normal: ArrayLike) -> tuple[Texture, Array]:
    """Return a normal map of one normal (any length), and that normal as 10 bits keep it, at unit length."""
    value = (unit(normal) / 2 + 0.5).astype(np.float32)
    kept = np.floor(value * np.float32(1023) + np.float32(0.5)) / 1023 * 2 - 1
    return Texture(np.tile(value, (4, 4, 1)), "linear"), unit(kept)


def stored_color(linear: ArrayLike) -> Array:
    """Return what 10 bits per square root keep of linear colours 0..1."""
    root = np.sqrt(np.asarray(linear, np.float64))
    return (np.floor(root * 1023 + 0.5) / 1023)**2


def terminator(ng: ArrayLike, ns: ArrayLike, wi: ArrayLike) -> float:
    """Return the shadow terminator's factor, eqs. 3 and 4 of Chiang, Li, Burley (2019)."""
    ng, ns, wi = (np.asarray(v, np.float64) for v in (ng, ns, wi))
    g = (ng @ wi) / ((ns @ wi) * (ng @ ns))
    return float(np.clip(-g**3 + g**2 + g, 0, 1)) if 0 < g < 1 else float(g >= 1)
