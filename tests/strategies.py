"""Hypothesis strategies: small scenes that are out for trouble, and rays that look for it.

What kinds of things a scene has is drawn by Hypothesis, so that it shrinks to the kinds that matter; the numbers come
from a generator whose seed is drawn too.
"""

import numpy as np
from hypothesis import strategies as st

from glimt import linalg
from glimt.scene.instance import Instance
from glimt.scene.mesh import Mesh
from glimt.scene.scene import Scene
from glimt.scene.sphere import Sphere

seeds = st.integers(0, 2**32 - 1)


# ---- matrices -----------------------------------------------------------------------------------------------------

def _rotation(random):
    return linalg.rotation(random.normal(size=3), random.uniform(0, 360))


MATRICES = {
    "identity": lambda random: linalg.identity(),
    "moved": lambda random: linalg.translation(random.uniform(-3, 3, 3)),
    "turned": _rotation,
    "quarter turn": lambda random: linalg.rotation(np.eye(3)[random.integers(3)], 90),
    "mirrored": lambda random: linalg.compose(_rotation(random), linalg.scaling([-1, 1, 1])),
    "stretched": lambda random: linalg.compose(_rotation(random), linalg.scaling(10 ** random.uniform(-1, 1, 3)),
                                               _rotation(random)),
    "flattened": lambda random: linalg.compose(_rotation(random), linalg.scaling([1, 1, 1e-3])),
    "far away": lambda random: linalg.compose(linalg.translation(random.normal(size=3) * 1000), _rotation(random)),
    "large": lambda random: linalg.scaling(1e9),
    "small": lambda random: linalg.scaling(10 ** random.uniform(-9, 0)),
}


# ---- meshes -------------------------------------------------------------------------------------------------------

def _soup(random):
    count = random.integers(1, 13)
    return random.uniform(-1, 1, (count, 3, 3))


def _lattice(random):
    """Corners on a coarse lattice: shared edges, coincident and degenerate triangles, faces in coordinate planes."""
    return random.integers(-2, 3, (random.integers(1, 13), 3, 3)) / 2


def _fan(random):
    """Triangles around one corner, as on a closed surface."""
    rim = random.uniform(-1, 1, (random.integers(3, 9), 3))
    return np.stack([np.broadcast_to(random.uniform(-1, 1, 3), rim.shape), rim, np.roll(rim, 1, 0)], 1)


def _slivers(random):
    """Triangles a thousand times longer than wide."""
    first, along = random.uniform(-1, 1, (2, 6, 3))
    return np.stack([first, first + along, first + along / 2 + random.normal(size=(6, 3)) * 1e-3], 1)


def _degenerate(random):
    """Points and lines among true triangles."""
    corners = _soup(random)
    corners[::3, 2] = corners[::3, 1]
    corners[1::3, 2] = (corners[1::3, 0] + corners[1::3, 1]) / 2
    corners[2::9] = corners[2::9, :1]
    return corners


def _twice(random):
    """Every triangle twice, in another place of the order."""
    corners = _lattice(random)
    return np.concatenate([corners, corners[random.permutation(len(corners))]])


MESHES = {"soup": _soup, "lattice": _lattice, "fan": _fan, "slivers": _slivers, "degenerate": _degenerate,
          "twice": _twice}


def mesh_of(corners):
    """Return a mesh of triangles that share no vertices, from (m, 3, 3) corners."""
    return Mesh(np.reshape(corners, (-1, 3)), np.arange(3 * len(corners)).reshape(-1, 3))


# ---- scenes and rays ----------------------------------------------------------------------------------------------

@st.composite
def scenes(draw):
    """Return a Scene of one to five instances and spheres."""
    scene = Scene()
    for kind in draw(st.lists(st.sampled_from(["sphere", *MESHES]), min_size=1, max_size=5)):
        random = np.random.default_rng(draw(seeds))
        if kind == "sphere":
            scene.add(Sphere(random.integers(-4, 5, 3) / 2, random.choice([0.01, 0.5, 1, 2, 1000])))
        else:
            matrix = MATRICES[draw(st.sampled_from(list(MATRICES)))](random)
            scene.add(Instance(mesh_of(MESHES[kind](random)), matrix))
    return scene


def _along_axes(random, points):
    """Directions along axes and coordinate planes, with zeros of either sign."""
    directions = random.integers(-1, 2, points.shape) * random.choice([1, 1, 0.3], points.shape)
    directions[(directions == 0).all(1), 0] = 1
    return points - directions * random.integers(1, 5, (len(points), 1)), np.where(
        directions == 0, random.choice([0.0, -0.0], points.shape), directions)


def _in_plane(random, points):
    """From a point of a surface towards others of the same scene: often in the plane of a face, starting on it."""
    return points, random.permutation(points) - points


def _from_outside(random, points):
    origins = points + random.normal(size=points.shape) * 3
    return origins, points - origins


def _from_far(random, points):
    origins = points + linalg.normalize(random.normal(size=points.shape)) * 10.0 ** random.uniform(3, 5)
    return origins, points - origins


def _from_surface(random, points):
    return points, random.normal(size=points.shape)


def _long_and_short(random, points):
    """Directions of any length."""
    origins, directions = _from_outside(random, points)
    return origins, directions * 10.0 ** random.integers(-12, 13, (len(points), 1))


RAYS = {"outside": _from_outside, "axes": _along_axes, "plane": _in_plane, "far": _from_far, "surface": _from_surface,
        "length": _long_and_short}


def interesting_points(scene, random, count):
    """Return (count, 3) points of a scene in world space: corners, edge midpoints and insides of triangles; points on
    and beside spheres."""
    points = []
    for thing in scene.objects:
        if isinstance(thing, Sphere):
            around = linalg.normalize(random.normal(size=(count, 3)))
            points.append(thing.center + around * thing.radius * random.choice([1, 1, 0.5, 1.1], (count, 1)))
        else:
            corners = thing.mesh.positions[thing.mesh.triangles][random.integers(len(thing.mesh.triangles), size=count)]
            weights = random.choice([0.0, 0.0, 1.0, 0.5], (count, 3)) + random.uniform(0, 0.5, (count, 3)) * (
                random.uniform(size=(count, 1)) < 0.5)
            weights[weights.sum(1) == 0] = 1
            inside = np.einsum("nk,nka->na", weights / weights.sum(1, keepdims=True), corners)
            points.append(linalg.transform_points(thing.object_to_world, inside))
    return random.permutation(np.concatenate(points))[:count]


def rays_for(scene, kinds, seed, count):
    """Return (origins, directions), (count, 3) float32 each, of rays of all `kinds` that go for a scene."""
    random = np.random.default_rng(seed)
    parts = []
    for kind in kinds:
        points = interesting_points(scene, random, -(-count // len(kinds)))
        parts.append(RAYS[kind](random, points))
    origins, directions = (np.concatenate(part)[:count].astype(np.float32) for part in zip(*parts, strict=True))
    order = random.permutation(count)
    directions[np.abs(directions).max(1) < 1e-12] = 0, -1, 0
    return origins[order], directions[order]


ray_kinds = st.lists(st.sampled_from(list(RAYS)), min_size=1, max_size=4, unique=True)
