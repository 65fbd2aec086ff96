"""The experiments: which settings each figure compares, one thing varied at a time."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

from glimt.bench.frame_scenes import ring_of_lights
from glimt.bench.growth import squares_of_instances
from glimt.engines import DEFAULT_OPTIONS, EngineOptions
from glimt.engines.cpu.engine import PACKET_COUNTS, available_threads
from glimt.errors import GlimtError
from glimt.scene.instance import Instance
from glimt.scene.light import PointLight
from glimt.scene.scene import Samples, Scene
from glimt.scene.sphere import Sphere
from glimt.study.vertices import finer, first_vertices, in_order, placed_vertices

SIDE = 400
"""Pixels along the base configuration's picture, as in the paper."""
_MOST_TRIANGLES = 1_500_000
_MOST_BRUTE_TRIANGLES = 25_000
"""A frame of these takes some seconds; with --quick a quarter of them."""


@dataclass(frozen=True)
class Setting:
    """One configuration that is timed.

    Parameters
    ----------
    x : float, optional
        The value that is varied; None: the camera's rays to a pixel, which only the frame tells.
    label : str
        It in words.
    scene : Scene
        With the settings it is rendered by.
    threads : int, optional
        None: those of the study.
    """

    x: float | None
    label: str
    scene: Scene
    options: EngineOptions = DEFAULT_OPTIONS
    threads: int | None = None


Curves = dict[str, list[Setting]]
"""The settings of each series of a figure, by its name."""


class Study(NamedTuple):
    """What all figures have in common.

    base : Scene
        The configuration around which one thing at a time is varied.
    engine : "cpu" or "gpu"
    quick : bool
        Shorter series.
    brute_force : bool
        Whether the figure of vertices has the curve without trees too.
    """

    base: Scene
    engine: str
    quick: bool = False
    brute_force: bool = False


class Kind(NamedTuple):
    """What a figure is about.

    paper : str
        What the paper found, as the report says it after "the paper:".
    settings : function
        From a study to the series.
    engines : tuple of str
        Which engines it makes sense for.
    """

    name: str
    title: str
    x_title: str
    kind: Literal["curve", "bars", "stages"]
    log: bool
    paper: str
    settings: Callable[[Study], Curves]
    engines: tuple[str, ...] = ("cpu", "gpu")


def base_of(scene: Scene) -> Scene:
    """Return the base configuration of a scene: 400×400 pixels, a sample each, no bounces; its lights and camera."""
    base = with_settings(scene)
    base.camera = base.camera_or_framing()
    return base


def with_settings(scene: Scene, *, samples: Samples = 1, max_bounces: int = 0, side: int = SIDE) -> Scene:
    """Return a scene with other settings."""
    return replace(scene, settings=replace(scene.settings, width=side, height=side, samples=samples,
                                           max_bounces=max_bounces))


def all_mirrors(scene: Scene, share: float = 0.5) -> Scene:
    """Return a scene whose surfaces all reflect, at least so much: every ray that meets one goes on."""
    mirrored = {}
    for thing in scene.objects:
        for material in [thing.material] if isinstance(thing, Sphere) else [*thing.mesh.materials, thing.material]:
            if material is not None and material not in mirrored:
                mirrored[material] = replace(material, reflectivity=max(material.reflectivity, share))
    meshes = {thing.mesh: replace(thing.mesh, materials=[mirrored[each] for each in thing.mesh.materials])
              for thing in scene.instances()}
    objects: list[Instance | Sphere] = []
    for thing in scene.objects:
        if isinstance(thing, Sphere):
            objects.append(replace(thing, material=mirrored[thing.material]))
        else:
            own = mirrored[thing.material] if thing.material is not None else None
            objects.append(replace(thing, mesh=meshes[thing.mesh], material=own))
    return replace(scene, objects=objects)


def _grouping(study: Study) -> Curves:
    if study.engine == "gpu":
        shapes = [(8, 8), (16, 16), (32, 32)]  # the paper's
        if not study.quick:
            shapes = [(8, 8), (64, 1), (16, 8), (16, 16), (32, 8), (256, 1), (32, 16), (32, 32)]
        return {"workgroups": [Setting(x * y, f"{x}×{y}", study.base, EngineOptions(group=(x, y)))
                               for x, y in shapes]}
    return {"tiles": [Setting(side * side, f"tiles {side}×{side}", study.base, EngineOptions(tile=side))
                      for side in (8, 16, 32, 64, 128)],
            "packets": [Setting(count, f"{count} packet{'s' * (count > 1)}", study.base, EngineOptions(packets=count))
                        for count in PACKET_COUNTS]}


def _pixels(study: Study) -> Curves:
    sides = (100, 200, 400, 566, 800) if study.quick else (100, 141, 200, 283, 400, 566, 800, 1131, 1600)
    return {"pixels": [Setting(side * side, f"{side}×{side}", with_settings(study.base, side=side)) for side in sides]}


def _bounces(study: Study) -> Curves:
    counts = range(0, 11, 2) if study.quick else range(11)
    mirrors = all_mirrors(study.base)
    return {"the scene's own mirrors": [Setting(count, f"{count}", with_settings(study.base, max_bounces=count))
                                        for count in counts],
            "every surface a mirror": [Setting(count, f"{count}", with_settings(mirrors, max_bounces=count))
                                       for count in counts]}


def _lights(study: Study) -> Curves:
    counts = (0, 1, 2, 4, 8, 12, 16) if study.quick else (0, 1, 2, 3, 4, 6, 8, 10, 12, 14, 16)
    others = [light for light in study.base.lights if not isinstance(light, PointLight)]
    return {"point lights": [Setting(count, f"{count}", replace(
        study.base, lights=[*others, *ring_of_lights(study.base, count)])) for count in counts]}


def _vertices(study: Study) -> Curves:
    total = placed_vertices(study.base)
    if not total:
        raise GlimtError("the scene has no meshes")
    before_last = total - 3 * len(in_order(study.base)[-1].mesh.triangles)
    steps = 5 if study.quick else 10
    counts = {max(3, before_last * k // steps // 3 * 3) for k in range(steps)} | {10 // 3 * 3} if before_last else set()
    last = {before_last + (total - before_last) * k // 3 // 3 * 3 for k in range(4)} - {0}
    added = [Setting(count, f"{count:,}", first_vertices(study.base, count)) for count in sorted(counts | last)]
    grown = list(_finer(study))
    curves = {"objects added, the outermost last": added, "the same surfaces cut finer": grown}
    if study.brute_force:
        most = 3 * _MOST_BRUTE_TRIANGLES // (4 if study.quick else 1)
        few = [each for each in grown if (each.x or 0) <= most]
        for name, settings in (("objects added, brute force", added), ("cut finer, brute force", few)):
            curves[name] = [replace(each, options=EngineOptions(brute_force=True)) for each in settings]
    return curves


def _finer(study: Study) -> Iterator[Setting]:
    scene, most = study.base, _MOST_TRIANGLES // 4 if study.quick else _MOST_TRIANGLES
    while True:
        count = placed_vertices(scene)
        yield Setting(count, f"{count:,}", scene)
        if 4 * count > 3 * most:
            return
        scene = finer(scene)


def _threads(study: Study) -> Curves:
    most = available_threads()
    counts = sorted({*(count for count in (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128) if count < most),
                     most, 2 * most})
    return {"threads": [Setting(count, f"{count}", study.base, threads=count) for count in counts]}


def _instances(study: Study) -> Curves:
    meshes = [thing.mesh for thing in in_order(study.base)]
    if not meshes:
        raise GlimtError("the scene has no meshes")
    mesh = max(meshes, key=lambda each: (each is not meshes[-1], len(each.triangles)))
    return {f"instances of {mesh.name!r}, {len(mesh.triangles)} triangles": [
        Setting(count, f"{count:,}", scene)
        for count, scene in squares_of_instances(mesh, SIDE, 1024 if study.quick else 10_000)]}


def _samples(study: Study) -> Curves:
    curves = {"n×n samples": [Setting(n * n, f"{n}×{n}", with_settings(study.base, samples=n)) for n in (1, 2, 3, 4)]}
    if study.engine == "cpu":
        curves["adaptive"] = [Setting(None, "adaptive, up to 4×4", with_settings(study.base, samples="adaptive"))]
    return curves


def _stages(study: Study) -> Curves:
    timed = EngineOptions(time_stages=True)
    base = study.base
    lit = replace(base, lights=[*base.lights, *ring_of_lights(base, 8)])
    chosen = [("base", base), ("3 bounces", with_settings(base, max_bounces=3)),
              ("3 bounces, all mirrors", with_settings(all_mirrors(base), max_bounces=3)),
              ("8 lights more", lit), ("2×2 samples", with_settings(base, samples=2)),
              ("triangles cut in 256", finer(finer(finer(finer(base)))))]
    few = [(label, scene) for label, scene in chosen if placed_vertices(scene) <= 3 * _MOST_TRIANGLES]
    return {"stages": [Setting(k, label, scene, timed) for k, (label, scene) in enumerate(few)]}


_LINEAR = "frame time grows linearly"
FIGURES = {
    2: Kind("groups", "Threads in a group", "work at a time", "bars", False,
            "the size of a thread group matters, and has a best value", _grouping),
    3: Kind("pixels", "Pixels", "pixels", "curve", True, _LINEAR, _pixels),
    4: Kind("bounces", "Bounces", "mirror bounces", "curve", False, _LINEAR, _bounces),
    5: Kind("lights", "Lights", "point lights", "curve", False, _LINEAR, _lights),
    6: Kind("vertices", "Vertices", "vertices", "curve", True,
            "frame time grows linearly, but for a jump when the outer box comes into view", _vertices),
    7: Kind("threads", "Threads", "threads", "curve", False, "", _threads, ("cpu",)),
    8: Kind("instances", "Instances", "instances", "curve", True, "", _instances),
    9: Kind("samples", "Samples", "samples a pixel", "curve", False, "", _samples),
    10: Kind("stages", "Stages", "configuration", "stages", False, "", _stages),
}
"""By number; those of the paper have its numbers."""


def chosen_figures(text: str | None) -> list[int]:
    """Return the figures in a comma-separated list, all of them for None."""
    numbers = []
    for part in text.split(",") if text is not None else map(str, FIGURES):
        if not part.strip().isdecimal() or int(part) not in FIGURES:
            raise GlimtError(f"there is no figure {part.strip()!r}; expected some of "
                             f"{', '.join(map(str, FIGURES))}")
        numbers.append(int(part))
    return sorted(set(numbers))
