"""The scenes whose frames are timed."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from glimt import linalg
from glimt.errors import GlimtError
from glimt.io import load
from glimt.io.obj import read_obj
from glimt.scene.camera import Camera
from glimt.scene.instance import Instance
from glimt.scene.light import DirectionalLight, Light, PointLight
from glimt.scene.material import Material
from glimt.scene.mesh import Mesh
from glimt.scene.scene import RenderSettings, Scene

BUNNY, ARMADILLO, NEFERTITI = "stanford-bunny.obj", "armadillo.obj", "nefertiti.obj"


class Row(NamedTuple):
    """One row of the table: what is rendered, how, and which of the models it needs.

    make: from the paths of those models (of the scene file for a row that needs none) to a scene.
    """

    title: str
    size: tuple[int, int]
    samples: int
    bounces: int
    models: tuple[str, ...]
    make: Callable[[list[Path]], Scene]


class Missing(NamedTuple):
    """A row that is left out, and why."""

    row: str
    reason: str


def _paper(paths: list[Path]) -> Scene:
    return load(paths[0])


def _plane(half: float) -> Mesh:
    corners = [(-half, 0, -half), (-half, 0, half), (half, 0, half), (half, 0, -half)]
    return Mesh(np.array(corners, np.float32), np.array([(0, 1, 2), (0, 2, 3)]), name="plane",
                materials=[Material(diffuse=(0.42, 0.4, 0.37))])


def _lit(scene: Scene, reach: float) -> Scene:
    scene.settings = RenderSettings(background=(0.5, 0.68, 0.95), ambient=0.15)
    return scene.add(DirectionalLight(direction=(-0.5, -1.0, -0.6), diffuse=0.9),
                     PointLight(position=(-reach, 1.5 * reach, reach), radius=1.5 * reach, diffuse=(0.8, 0.6, 0.45)))


def _standing(mesh: Mesh, turn: linalg.Array) -> linalg.Array:
    """Return the transform that turns a mesh and stands it on the origin, 1 high."""
    lo, hi = linalg.transform_box(turn, *mesh.bounds())
    foot = linalg.translation((-(lo[0] + hi[0]) / 2, -lo[1], -(lo[2] + hi[2]) / 2))
    return linalg.compose(linalg.scaling(float(1 / (hi[1] - lo[1]))), foot, turn)


def _statues(paths: list[Path]) -> Scene:
    """Three scanned models in a group; each is moved in its mesh, so that Embree gets one tree over all of them."""
    scene = Scene(name="statues").add(_plane(6.0))
    stands = [((-0.1, 0, 0.55), 0.55, linalg.identity()), ((-0.42, 0, -0.1), 1.0, linalg.rotation((0, 1, 0), 180)),
              ((0.42, 0, -0.1), 1.1, linalg.rotation((1, 0, 0), -90))]
    for path, (foot, height, turn) in zip(paths, stands, strict=True):
        mesh = read_obj(path)
        place = linalg.compose(linalg.translation(foot), linalg.scaling(height), _standing(mesh, turn))
        normals = mesh.normals  # go by the same matrix, since it scales all axes alike
        if normals is not None:
            normals = linalg.transform_vectors(place, normals).astype(np.float32)
        scene.add(replace(mesh, positions=linalg.transform_points(place, mesh.positions).astype(np.float32),
                          normals=normals))
    scene.camera = Camera((0.0, 1.05, 2.75), (0.0, 0.46, 0.0), fov_deg=34.0)
    return _lit(scene, 2.0)


def field_of(mesh: Mesh, count: int) -> Scene:
    """Return a field of `count` turned and scaled instances on a plane, nearly all of them in view."""
    random = np.random.default_rng(7)
    side = int(np.ceil(np.sqrt(count)))
    scene = Scene(name="field").add(_plane(1.2 * side))
    for index in range(count):
        x, z = np.array([index % side, index // side]) - (side - 1) / 2 + random.uniform(-0.2, 0.2, 2)
        axis = (random.uniform(-0.3, 0.3), 1.0, random.uniform(-0.3, 0.3))
        place = linalg.compose(linalg.translation((x, 0, z)), linalg.rotation(axis, random.uniform(0, 360)),
                               linalg.scaling(random.uniform(0.7, 1.2)), _standing(mesh, linalg.identity()))
        scene.add(Instance(mesh, place))
    scene.camera = Camera((0.0, 0.75 * side, 0.9 * side), (0.0, 0.0, 0.05 * side), fov_deg=42.0)
    return _lit(scene, 0.7 * side)


def _instances(paths: list[Path]) -> Scene:
    return field_of(read_obj(paths[0]), 1000)


ROWS = {
    "room": Row("paper's scene", (400, 400), 1, 0, (), _paper),
    "mirrors": Row("paper's scene, mirrors", (400, 400), 1, 3, (), _paper),
    "hd": Row("paper's scene, mirrors", (1920, 1080), 2, 3, (), _paper),
    "statues": Row("bunny, armadillo, Nefertiti", (1024, 1024), 1, 0, (BUNNY, ARMADILLO, NEFERTITI), _statues),
    "instances": Row("1,000 bunnies", (1024, 1024), 1, 0, (BUNNY,), _instances),
}
"""The rows by name; all of them have two lights."""


def chosen_rows(names: str | None) -> list[str]:
    """Return the names of rows in a comma-separated list, all of them for None."""
    rows = list(ROWS) if names is None else [name.strip() for name in names.split(",")]
    for name in rows:
        if name not in ROWS:
            raise GlimtError(f"there is no row {name!r}; expected some of {', '.join(ROWS)}")
    return rows


def find_sources(names: Iterable[str], scene: Path, models: Path | None
                 ) -> tuple[dict[str, list[Path]], list[Missing]]:
    """Return the files of each row that can be made, and which rows cannot.

    `scene` is the paper's scene; `models` is a folder that is searched for models, with all folders below it. A path
    that is given must exist.
    """
    if not scene.is_file():
        raise GlimtError(f"{scene}: no such file")
    if models is not None and not models.is_dir():
        raise GlimtError(f"{models}: no such folder")
    found: dict[str, list[Path]] = {}
    missing = []
    for name in names:
        wanted = ROWS[name].models
        hits = {model: next(iter(sorted(models.rglob(model))), None) if models else None for model in wanted}
        absent = [model for model, path in hits.items() if path is None]
        if absent:
            remedy = f"not below {models}" if models else "give --models FOLDER"
            missing.append(Missing(name, f"{', '.join(absent)} not found; {remedy}"))
        else:
            found[name] = [path for path in hits.values() if path] or [scene]
    return found, missing


def make_scene(name: str, paths: list[Path], *, quick: bool = False) -> Scene:
    """Return the scene of a row with its settings; `quick` makes the picture an eighth as wide and high."""
    row = ROWS[name]
    scene = row.make(paths)
    width, height = (length // 8 if quick else length for length in row.size)
    scene.settings = replace(scene.settings, width=width, height=height, samples=row.samples, max_bounces=row.bounces)
    scene.camera = scene.camera_or_framing()
    return scene


def ring_of_lights(scene: Scene, count: int) -> list[Light]:
    """Return point lights that stand around the middle of a scene, above it; the first are the same for any count."""
    lo, hi = scene.bounds()
    center, reach = (lo + hi) / 2, (hi - lo) / 4
    angles = 2 * np.pi * np.arange(count) * 0.618  # neighbours in the list stand apart
    ring = center + reach * np.stack([np.cos(angles), np.full_like(angles, 1.2), np.sin(angles)], -1)
    return [PointLight(position=tuple(place), radius=float(reach.max()), diffuse=0.3) for place in ring.tolist()]
