"""The scene: what is drawn, what lights it, where it is seen from, and how it is rendered."""

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from glimt.errors import GlimtError
from glimt.layout import MOST_SAMPLES
from glimt.scene import checks
from glimt.scene.camera import Camera
from glimt.scene.instance import Instance
from glimt.scene.light import Light
from glimt.scene.mesh import Mesh
from glimt.scene.sphere import Sphere

Color = tuple[float, float, float]
ToneCurve = Literal["clamp", "filmic"]
Samples = int | Literal["adaptive"]

LARGEST_SIZE = 32768
"""Pixels along one side of a picture."""
LARGEST_AREA = 100_000_000
"""Pixels of a picture: a film of that size takes 1.6 GB."""


@dataclass(eq=False)
class RenderSettings:
    """How a scene is rendered.

    Parameters
    ----------
    width, height : int
        Size of the picture in pixels.
    samples : int or "adaptive"
        n gives a grid of n×n pixel samples, 1 to 64; "adaptive" up to 4×4, and one where the picture is smooth.
    max_bounces : int
        Mirror bounces; 0 shows no mirror.
    background, ambient : linear colour
        What rays see that leave the scene; light that reaches every surface from all sides.
    exposure : float
        Stops: 1 doubles the radiance before it is developed.
    tone_curve : "clamp" or "filmic"
        How radiance above 1 is shown: cut off, or rolled off.
    """

    width: int = 640
    height: int = 480
    samples: Samples = 1
    max_bounces: int = 0
    background: Color | float = 0.0
    ambient: Color | float = 0.0
    exposure: float = 0.0
    tone_curve: ToneCurve = "clamp"

    def __post_init__(self) -> None:
        self.width = _whole("width", self.width, 1, LARGEST_SIZE)
        self.height = _whole("height", self.height, 1, LARGEST_SIZE)
        if self.width * self.height > LARGEST_AREA:
            raise GlimtError(f"settings: {self.width}×{self.height} is more than {LARGEST_AREA // 10**6} million "
                             "pixels; choose a smaller size")
        self.samples = _samples(self.samples)
        self.max_bounces = _whole("max_bounces", self.max_bounces, 0, 1000)
        self.background = checks.color("settings", "background", self.background)
        self.ambient = checks.color("settings", "ambient", self.ambient)
        self.exposure = checks.number("settings", "exposure", self.exposure, -100, 100)
        if self.tone_curve not in ("clamp", "filmic"):
            raise GlimtError(f"settings: tone_curve is {self.tone_curve!r}, expected 'clamp' or 'filmic'")


def _samples(value: Any) -> Samples:
    if isinstance(value, str) and value == "adaptive":
        return "adaptive"
    if isinstance(value, str) and not value.isdecimal():
        raise GlimtError(f"settings: samples is {value!r:.60}, expected 1 to {MOST_SAMPLES} or 'adaptive'")
    return _whole("samples", value, 1, MOST_SAMPLES)


def _whole(name: str, value: Any, lo: int, hi: int) -> int:
    number = checks.number("settings", name, value, lo, hi)
    if number != int(number):
        raise GlimtError(f"settings: {name} is {value}, expected a whole number")
    return int(number)


@dataclass(eq=False)
class Scene:
    """Everything a picture needs; ``Scene().add(mesh, sphere, light)`` is enough to render one.

    Parameters
    ----------
    objects : list of Instance or Sphere
    lights : list of Light
    camera : Camera, optional
        None: a camera that frames all objects is chosen when the scene is rendered.
    settings : RenderSettings
    """

    objects: list[Instance | Sphere] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)
    camera: Camera | None = None
    settings: RenderSettings = field(default_factory=RenderSettings)
    name: str = "scene"

    def add(self, *things: Mesh | Instance | Sphere | Light) -> "Scene":
        """Add objects and lights, a mesh as an instance that stands where it was modelled; return the scene."""
        for thing in things:
            if isinstance(thing, Mesh):
                self.objects.append(Instance(thing, name=thing.name))
            elif isinstance(thing, Instance | Sphere):
                self.objects.append(thing)
            elif isinstance(thing, Light):
                self.lights.append(thing)
            else:
                raise GlimtError(f"scene: cannot add a {type(thing).__name__}; expected a mesh, instance, sphere "
                                 "or light")
        return self

    def instances(self) -> list[Instance]:
        """Return the placed meshes, in order."""
        return [thing for thing in self.objects if isinstance(thing, Instance)]

    def spheres(self) -> list[Sphere]:
        """Return the spheres, in order."""
        return [thing for thing in self.objects if isinstance(thing, Sphere)]

    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return (lo, hi) of all objects in world space; a box from -1 to 1 for an empty scene."""
        boxes = [thing.bounds() for thing in self.objects if isinstance(thing, Sphere) or len(thing.mesh.triangles)]
        if not boxes:
            return np.full(3, -1.0), np.full(3, 1.0)
        return np.min([lo for lo, _ in boxes], 0), np.max([hi for _, hi in boxes], 0)

    def placed_triangles(self) -> int:
        """Return how many triangles there are, those of a mesh once for each instance."""
        return sum(len(thing.mesh.triangles) for thing in self.instances())

    def camera_or_framing(self) -> Camera:
        """Return the camera, or one that frames all objects."""
        if self.camera is not None:
            return self.camera
        return Camera.framing(*self.bounds(), self.settings.width / self.settings.height)
