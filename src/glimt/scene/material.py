"""The Phong material of MTL files."""

from dataclasses import dataclass

from glimt.errors import GlimtError
from glimt.scene import checks
from glimt.scene.texture import Texture

Color = tuple[float, float, float]


@dataclass(eq=False)
class Material:
    """Parameters of a surface; colours are linear RGB, given as one number or three.

    Parameters
    ----------
    ambient : colour, optional
        Share of ambient light reflected. None: the same as `diffuse`.
    diffuse : colour
        Lambert reflectance, multiplied by `diffuse_texture`.
    specular, exponent : colour, float
        Highlight ``specular * max(0, n·h)^exponent`` (Blinn's halfway vector).
    reflectivity : float
        0 (no mirror) to 1 (all mirror): ``(1 - r) * lit + r * mirrored``.
    diffuse_texture : Texture, optional
        Multiplies `diffuse` and `ambient`. Encoding "srgb" unless it holds linear data.
    normal_texture : Texture, optional
        Tangent-space normal map, encoding "linear".
    normal_scale : float
        Multiplies x and y of the mapped normal: 0 is flat, 1 as painted.
    """

    ambient: Color | float | None = None
    diffuse: Color | float = 0.8
    specular: Color | float = 0.0
    exponent: float = 32.0
    reflectivity: float = 0.0
    diffuse_texture: Texture | None = None
    normal_texture: Texture | None = None
    normal_scale: float = 1.0
    name: str = "material"

    def __post_init__(self) -> None:
        owner = f"material {self.name!r}"
        for field in ("diffuse_texture", "normal_texture"):
            checks.kind(owner, field, getattr(self, field), Texture, type(None))
        self.diffuse = checks.color(owner, "diffuse", self.diffuse)
        self.ambient = self.diffuse if self.ambient is None else checks.color(owner, "ambient", self.ambient)
        self.specular = checks.color(owner, "specular", self.specular)
        self.exponent = checks.number(owner, "exponent", self.exponent, 0, 1e6)
        self.reflectivity = checks.number(owner, "reflectivity", self.reflectivity, 0, 1)
        self.normal_scale = checks.number(owner, "normal_scale", self.normal_scale, -100, 100)
        if self.normal_texture is not None and self.normal_texture.encoding != "linear":
            raise GlimtError(f"{owner}: normal_texture must have encoding 'linear', a normal map is not a colour")
