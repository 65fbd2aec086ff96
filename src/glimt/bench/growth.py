"""How a frame's time grows: with triangles, instances, lights and bounces, each at a view that stays the same."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from glimt import linalg
from glimt.bench.frame_scenes import ring_of_lights
from glimt.bench.measure import Tell, interleave_blocks, machine, milliseconds, quotient
from glimt.bench.mesh_sizes import sizes
from glimt.bench.steady import SteadyFrames
from glimt.scene.camera import Camera
from glimt.scene.instance import Instance
from glimt.scene.light import DirectionalLight, Light, PointLight
from glimt.scene.mesh import Mesh
from glimt.scene.scene import RenderSettings, Scene

SIDES = (1, 3, 10, 32, 100)
"""Instances along each side of the square that fills the picture."""
LIGHTS = (0, 1, 2, 4, 8, 12, 16)
BOUNCES = (0, 1, 2, 3, 4, 6, 8, 10)


class Limits(NamedTuple):
    """How far the series go."""

    least_triangles: int = 1000
    most_triangles: int = 1_200_000
    most_instances: int = 10_000


def measure(mesh: Mesh, scene: Scene, size: int, threads: int, frames: int, rounds: int,
            limits: Limits, tell: Tell = lambda text: None) -> dict[str, Any]:
    """Return the result of all series, to be written as JSON; those of lights and bounces are of `scene`.

    A row holds a setting's frame time in ms and `ratio`, through the time of the first setting of its series, both
    measured in turn. Instances are of the mesh with the fewest triangles. `fits` has a line through each series by
    least squares: ms for ten times as many triangles or instances, for each light, for each bounce.
    """
    rows: list[dict[str, Any]] = []
    fits: dict[str, dict[str, Any]] = {}
    meshes = sizes(mesh, limits.least_triangles, limits.most_triangles)
    series: dict[str, Iterator[tuple[int, Scene]]] = {
        "triangles": _triangles(meshes, size),
        "instances": squares_of_instances(meshes[0], size, limits.most_instances),
        "lights": _lights(scene), "bounces": _bounces(scene)}
    for name, settings in series.items():
        tell(f"growth: {name}")
        films = {str(count): SteadyFrames(one, threads) for count, one in settings}
        blocks = interleave_blocks(films, rounds, frames)
        first = next(iter(blocks.values()))
        added = [{"series": name, "count": int(count), "threads": threads, "frame_ms": milliseconds(times),
                  "ratio": quotient(times, first)} for count, times in blocks.items()]
        fits[name] = _fit(added, "each" if name in ("lights", "bounces") else "tenfold")
        rows += added
    return {"benchmark": "growth", "version": 1, "machine": machine(), "mesh": mesh.name, "threads": threads,
            "instance_triangles": len(meshes[0].triangles), "rows": rows, "fits": fits}


def _fit(rows: list[dict[str, Any]], per: str) -> dict[str, Any]:
    """Return the slope of ms over the settings, over their decimal logarithm for `per` "tenfold", and its R².

    Through ratios and the first setting's ms, since ratios do not drift.
    """
    counts = np.array([row["count"] for row in rows], np.float64)
    x = np.log10(counts) if per == "tenfold" else counts
    y = np.array([row["ratio"] for row in rows]) * rows[0]["frame_ms"]["median"]
    if len(rows) < 2:
        return {"ms": 0.0, "at_first": float(y[0]), "per": per, "r2": 1.0}
    slope, start = np.polyfit(x, y, 1)
    spread = ((y - y.mean()) ** 2).sum()
    r2 = 1 - ((y - slope * x - start) ** 2).sum() / spread if spread > 0 else 1.0
    return {"ms": float(slope), "at_first": float(start + slope * x[0]), "per": per, "r2": float(r2)}


def _settings(size: int) -> RenderSettings:
    return RenderSettings(size, size, background=0.5, ambient=0.1)


def _two_lights(center: linalg.Array, reach: float) -> list[Light]:
    place = center + reach * np.array([-0.6, 0.8, 1.0])
    return [DirectionalLight(direction=(-0.5, -1.0, -0.6)),
            PointLight(position=tuple(place.tolist()), radius=1.5 * reach)]


def _triangles(meshes: list[Mesh], size: int) -> Iterator[tuple[int, Scene]]:
    """Yield the same shape at the same place with more and more triangles."""
    lo, hi = (bound.astype(np.float64) for bound in meshes[0].bounds())
    camera, lights = Camera.framing(lo, hi), _two_lights((lo + hi) / 2, float((hi - lo).max()))
    for one in meshes:
        yield len(one.triangles), Scene([Instance(one)], lights, camera, _settings(size))


def squares_of_instances(mesh: Mesh, size: int, most: int) -> Iterator[tuple[int, Scene]]:
    """Yield a square of n×n instances, each an nth as large, so that they always fill the same part of the picture."""
    lo, hi = (bound.astype(np.float64) for bound in mesh.bounds())
    to_unit = linalg.compose(linalg.scaling(float(1 / (hi - lo).max())), linalg.translation(-(lo + hi) / 2))
    camera = Camera((0.0, 0.0, 2.0), (0.0, 0.0, 0.0), fov_deg=float(2 * np.degrees(np.arctan(0.25))))
    for side in SIDES:
        if side > 1 and side * side > most:
            return
        places = ((np.arange(side) + 0.5) / side - 0.5).tolist()
        objects: list[Any] = [Instance(mesh, linalg.compose(linalg.translation((x, y, 0)), linalg.scaling(1 / side),
                                                            to_unit)) for y in places for x in places]
        yield side * side, Scene(objects, _two_lights(np.zeros(3), 1.0), camera, _settings(size))


def _lights(scene: Scene) -> Iterator[tuple[int, Scene]]:
    """Yield the scene under a ring of point lights instead of its own lights."""
    for count in LIGHTS:
        yield count, replace(scene, lights=ring_of_lights(scene, count))


def _bounces(scene: Scene) -> Iterator[tuple[int, Scene]]:
    """Yield the scene with more and more mirror bounces."""
    for count in BOUNCES:
        yield count, replace(scene, settings=replace(scene.settings, max_bounces=count))


