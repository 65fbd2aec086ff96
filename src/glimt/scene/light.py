"""Point, spot and directional lights: ambient, diffuse and specular light each."""

import math
from dataclasses import dataclass

from glimt.errors import GlimtError
from glimt.scene import checks
from glimt.scene.motion import Motion, Orbit, Path

Color = tuple[float, float, float]
Point = tuple[float, float, float]


@dataclass(eq=False, kw_only=True)
class Light:
    """What every light has; colours are linear RGB (one number or three) and may exceed 1.

    Parameters
    ----------
    ambient : colour
        Added to the scene's ambient light, everywhere and without shadow.
    diffuse, specular : colour
        Light for the Lambert term and for highlights. `specular` None: the same as `diffuse`.
    motion : Orbit or Path, optional
        Moves the light over time.
    """

    ambient: Color | float = 0.0
    diffuse: Color | float = 1.0
    specular: Color | float | None = None
    motion: Motion | None = None
    name: str = "light"

    def __post_init__(self) -> None:
        checks.kind(self.owner, "motion", self.motion, Orbit, Path, type(None))
        self.ambient = checks.color(self.owner, "ambient", self.ambient)
        self.diffuse = checks.color(self.owner, "diffuse", self.diffuse)
        self.specular = self.diffuse if self.specular is None else checks.color(self.owner, "specular", self.specular)

    @property
    def owner(self) -> str:
        """How messages call this light."""
        return f"light {self.name!r}"


@dataclass(eq=False, kw_only=True)
class PointLight(Light):
    """Shines to all sides from `position`.

    Attenuation is ``1 / (a0 + a1 * x + a2 * x²)`` with ``x = distance / radius``: no sharp cut-off, and a scene twice
    as large with a radius twice as large looks the same.
    """

    position: Point
    radius: float = 1.0
    attenuation: tuple[float, float, float] = (1.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        self.position = checks.vector(self.owner, "position", self.position)
        self.radius = checks.number(self.owner, "radius", self.radius, 1e-18, checks.LARGEST)
        self.attenuation = checks.color(self.owner, "attenuation", self.attenuation)
        if not any(self.attenuation):
            raise GlimtError(f"{self.owner}: attenuation is 0 0 0, which divides by zero; 1 0 0 means none")

    def position_at(self, time: float) -> Point:
        """Return the position at `time` seconds."""
        return self.motion.position(self.position, time) if self.motion else self.position


@dataclass(eq=False, kw_only=True)
class SpotLight(PointLight):
    """A point light that shines along `direction`: fully within the inner angle, not at all beyond the outer one.

    Angles are measured from the axis; in between the light falls off as
    ``((cos a - cos outer) / (cos inner - cos outer))²`` (glTF's KHR_lights_punctual).
    """

    direction: Point
    inner_angle_deg: float = 20.0
    outer_angle_deg: float = 30.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self.direction = checks.direction(self.owner, "direction", self.direction)
        self.outer_angle_deg = checks.number(self.owner, "outer_angle_deg", self.outer_angle_deg, 0.1, 180)
        self.inner_angle_deg = checks.number(self.owner, "inner_angle_deg", self.inner_angle_deg, 0,
                                             self.outer_angle_deg)

    def cosines(self) -> tuple[float, float]:
        """Return the cosines of the inner and the outer angle."""
        return math.cos(math.radians(self.inner_angle_deg)), math.cos(math.radians(self.outer_angle_deg))


@dataclass(eq=False, kw_only=True)
class DirectionalLight(Light):
    """Parallel light that travels along `direction`, like the sun's."""

    direction: Point

    def __post_init__(self) -> None:
        super().__post_init__()
        self.direction = checks.direction(self.owner, "direction", self.direction)

    def direction_at(self, time: float) -> Point:
        """Return the direction of travel at `time` seconds."""
        turned = self.motion.direction(self.direction, time) if self.motion else self.direction
        return turned if any(turned) else self.direction
