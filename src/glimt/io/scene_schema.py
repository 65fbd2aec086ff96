"""The tables of a TOML scene file and the keys each may have.

Types and spelling are checked here, value ranges by the constructors of `glimt.scene`. Defaults come from there too,
and `docs/scene-format.md` is held to the descriptions by a test: a key is described once.
"""

import difflib
from collections.abc import Collection
from typing import Annotated, Any, Literal, TypeVar

import numpy as np
from pydantic import (
    AllowInfNan,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainValidator,
    Strict,
    ValidatorFunctionWrapHandler,
    WithJsonSchema,
    WrapValidator,
    model_validator,
)
from pydantic_core import PydanticCustomError

from glimt.color import srgb_to_linear
from glimt.scene.camera import Camera
from glimt.scene.light import PointLight, SpotLight
from glimt.scene.material import Material
from glimt.scene.motion import Orbit
from glimt.scene.scene import RenderSettings, ToneCurve
from glimt.scene.texture import Encoding, Texture, Wrap


def nearest(word: str, known: Collection[str]) -> str:
    """Return ", did you mean 'x'?" for the known word nearest to `word`, else the known words, ready to append."""
    close = difflib.get_close_matches(word[:100], known, n=1)
    # fov for fov_deg: too short to be close, and still what was meant.
    close = close or [name for name in known if len(word) > 2 and (name.startswith(word) or word.startswith(name))]
    if close:
        return f", did you mean {close[0]!r}?"
    shown = ", ".join(sorted(known)[:20])
    return f"; known: {shown}" + (", ..." if len(known) > 20 else "") if known else ""


def parse_color(value: Any) -> tuple[float, float, float]:
    """Return a number, a list of three numbers (linear RGB) or "#rrggbb" (decoded from sRGB) as linear RGB."""
    if isinstance(value, str) and len(value) == 7 and value[0] == "#":
        try:
            red, green, blue = srgb_to_linear(np.frombuffer(bytes.fromhex(value[1:]), np.uint8) / 255).tolist()
        except ValueError:
            pass
        else:
            return red, green, blue
    parts = [value] * 3 if not isinstance(value, list) else value
    try:
        if len(parts) == 3 and not any(isinstance(part, bool | str) for part in parts):
            red, green, blue = (float(part) for part in parts)
            return red, green, blue
    except (TypeError, OverflowError):
        pass
    raise PydanticCustomError("color", "expected a colour: a number, [r, g, b] or '#rrggbb'")


def _as_list(value: Any) -> Any:
    return [value] if isinstance(value, dict) else value


def _as_rows(value: Any) -> Any:
    """Return a matrix that is given as 12 or 16 numbers in rows of 4; what is not one is left for the check."""
    if isinstance(value, list) and len(value) in (12, 16) and not any(isinstance(entry, list) for entry in value):
        return [value[start:start + 4] for start in range(0, len(value), 4)]
    return value


def _as_three(value: Any) -> Any:
    return value if isinstance(value, list) else [value] * 3


def _as_texture(value: Any) -> Any:
    return {"file": value} if isinstance(value, str) else value


def _or_word(value: Any, check: ValidatorFunctionWrapHandler) -> Any:
    """Leave a word to `RenderSettings`, which knows the one that is meant."""
    return value if isinstance(value, str) and not value.isdecimal() else check(value)


def _named(title: str) -> WithJsonSchema:
    """Return the metadata that names a type in the documentation."""
    return WithJsonSchema({"title": title})


# TOML tells 1, 1.0, "1" and true apart, so strictly: a whole number is a number, nothing else is.
Number = Annotated[float, Strict(), AllowInfNan(False), _named("number")]
Whole = Annotated[int, Strict(), Field(ge=-2**53, le=2**53), _named("whole number")]
PixelSamples = Annotated[Whole | str, WrapValidator(_or_word), _named('whole number or "adaptive"')]
Flag = Annotated[bool, Strict(), _named("true or false")]
Text = Annotated[str, Field(min_length=1, max_length=1000), _named("text")]
Name = Annotated[str, Field(min_length=1, max_length=1000), _named("name")]
FilePath = Annotated[str, Field(min_length=1, max_length=1000), _named("path")]
Color = Annotated[tuple[float, float, float] | float, PlainValidator(parse_color), _named("colour")]
Numbers = Annotated[list[Number], Field(min_length=1, fail_fast=True), _named("list of numbers")]
Pair = Annotated[list[Number], Field(min_length=2, max_length=2), _named("[x, y]")]
Pairs = Annotated[list[Pair], Field(min_length=1, fail_fast=True), _named("list of [x, y]")]
Vector = Annotated[list[Number], Field(min_length=3, max_length=3), _named("[x, y, z]")]
Vectors = Annotated[list[Vector], Field(min_length=1, fail_fast=True), _named("list of [x, y, z]")]
Scale = Annotated[Vector, BeforeValidator(_as_three), _named("number or [x, y, z]")]
Size = Annotated[list[Whole], Field(min_length=2, max_length=2), _named("[width, height]")]
_Corners = Annotated[list[Whole], Field(min_length=3, max_length=3)]
Triangles = Annotated[list[_Corners], Field(min_length=1, fail_fast=True), _named("list of [a, b, c]")]
_Row = Annotated[list[Number], Field(min_length=4, max_length=4)]
Matrix = Annotated[list[_Row], Field(min_length=3, max_length=4), BeforeValidator(_as_rows), _named("12 or 16 numbers")]


class Table(BaseModel):
    """A table that refuses unknown keys, naming the nearest known one."""

    model_config = ConfigDict(extra="forbid")

    @model_validator(mode="before")
    @classmethod
    def _check_keys(cls, data: Any) -> Any:
        if isinstance(data, dict):
            for key in data:
                if key not in cls.model_fields:
                    hint = nearest(key, cls.model_fields)
                    raise PydanticCustomError("unknown_key", "unknown key{hint}", {"key": key, "hint": hint})
        return data

    def given(self, *except_for: str) -> dict[str, Any]:
        """Return the keys that the file gives with their values, without those in `except_for`."""
        return {key: getattr(self, key) for key in self.model_fields_set if key not in except_for}


class RenderTable(Table):
    """[render]: how the scene is rendered."""

    size: Size = Field([RenderSettings.width, RenderSettings.height], description="Pixels.")
    samples: PixelSamples = Field(RenderSettings.samples, description=(
        "n gives a grid of n×n samples a pixel, 1 to 64; \"adaptive\" 1 to 16 of them, as many as a pixel needs."))
    max_bounces: Whole = Field(RenderSettings.max_bounces, description="Mirror bounces, 0 to 1000; 0 shows no mirror.")
    background: Color = Field(RenderSettings.background, description="What rays see that leave the scene.")
    ambient: Color = Field(RenderSettings.ambient, description="Light that reaches every surface from all sides.")
    exposure: Number = Field(RenderSettings.exposure, description="Stops: 1 doubles the light, -1 halves it.")
    tone_curve: Annotated[ToneCurve, _named('"clamp" or "filmic"')] = Field(
        RenderSettings.tone_curve, description="Light above 1 is cut off, or rolled off.")


class CameraTable(Table):
    """[camera]: where the picture is taken from."""

    position: Vector = Field(list(Camera.position), description="Where the camera stands.")
    target: Vector = Field(list(Camera.target), description="The point in the middle of the picture.")
    up: Vector = Field(list(Camera.up), description="What is up in the picture; not along the line of sight.")
    fov_deg: Number = Field(Camera.fov_deg, description="Vertical field of view in degrees, 0.001 to 179.")


class TextureTable(Table):
    """A texture that is more than a path."""

    file: FilePath = Field(description="Image, relative to the scene file.")
    wrap: Annotated[Wrap, _named('"repeat" or "clamp"')] = Field(
        Texture.wrap, description="What lies beyond texcoords 0 to 1.")
    scale: Pair = Field(list(Texture.scale), description="Looked up at `texcoord * scale + offset`.")
    offset: Pair = Field(list(Texture.offset), description="See `scale`.")
    encoding: Annotated[Encoding, _named('"srgb" or "linear"')] | None = Field(
        None, description="Left out: sRGB for a diffuse texture, linear for a normal texture.")


TextureKey = Annotated[TextureTable, BeforeValidator(_as_texture), _named("path or texture table")]


class MaterialTable(Table):
    """[[material]]: parameters of a surface."""

    name: Name = Field(description="What meshes, instances and spheres call it; once in a file.")
    ambient: Color | None = Field(None, description="Share of ambient light reflected; left out: as `diffuse`.")
    diffuse: Color = Field(Material.diffuse, description="Lambert reflectance.")
    specular: Color = Field(Material.specular, description="Strength of highlights.")
    exponent: Number = Field(Material.exponent, description="Sharpness of highlights, 0 to 1e6.")
    reflectivity: Number = Field(Material.reflectivity, description="0 is no mirror, 1 all mirror.")
    diffuse_texture: TextureKey | None = Field(None, description="Multiplies `diffuse` and `ambient`.")
    normal_texture: TextureKey | None = Field(None, description="Tangent-space normal map, +Y up.")
    normal_scale: Number = Field(Material.normal_scale, description="Strength of the map, -100 to 100; 0 is flat.")


class MeshTable(Table):
    """[[mesh]]: triangles, from a file or written out."""

    name: Name | None = Field(None, description="What instances call it; once in a file.")
    file: FilePath | None = Field(None, description="OBJ file, relative to the scene file; or `positions`.")
    positions: Vectors | None = Field(None, description="Vertices.")
    triangles: Triangles | None = Field(
        None, description="Vertex indices from 0, counter-clockwise seen from the front.")
    normals: Vectors | None = Field(None, description="One a vertex; left out: flat triangles.")
    texcoords: Pairs | None = Field(None, description="One a vertex; [0, 0] is the top-left corner of the image.")
    material: Name | None = Field(None, description="Replaces all materials of the mesh.")


class RotationTable(Table):
    """One rotation of an instance, right-handed."""

    axis: Vector = Field(description="Axis through the origin, any length.")
    angle_deg: Number = Field(description="Degrees.")


Rotations = Annotated[list[RotationTable], Field(min_length=1), BeforeValidator(_as_list),
                      _named("rotation table or list of them")]


class InstanceTable(Table):
    """[[instance]]: a mesh placed in the world."""

    name: Name | None = Field(None, description="For messages.")
    mesh: Name = Field(description="Name of a `[[mesh]]`.")
    material: Name | None = Field(None, description="Replaces all materials of the mesh.")
    matrix: Matrix | None = Field(
        None, description="Object to world in rows of 4, flat or nested, translation in the last column; "
        "instead of the three below.")
    scale: Scale | None = Field(None, description="Applied first; a negative factor mirrors.")
    rotate: Rotations | None = Field(None, description="Applied second, in order.")
    translate: Vector | None = Field(None, description="Applied last.")


class SphereTable(Table):
    """[[sphere]]: an analytic sphere."""

    name: Name | None = Field(None, description="For messages.")
    center: Vector = Field(description="In world space.")
    radius: Number = Field(description="Above 0.")
    material: Name | None = Field(None, description="Left out: plain grey.")


class OrbitTable(Table):
    """A circle around an axis, starting where the light stands at time 0."""

    center: Vector = Field(list(Orbit.center), description="A point on the axis.")
    axis: Vector = Field(list(Orbit.axis), description="Turning is right-handed around it.")
    period: Number = Field(Orbit.period, description="Seconds for one round; negative turns the other way.")


class PathTable(Table):
    """Straight lines through points."""

    times: Numbers = Field(
        description="Two or more times in seconds, each later than the one before.")
    points: Vectors = Field(
        description="Position at each time; directions for a directional light.")
    loop: Flag = Field(True, description="Start again after the last time, or stay at the ends.")


class MotionTable(Table):
    """How a light moves: an orbit or a path."""

    orbit: Annotated[OrbitTable, _named("orbit table")] | None = Field(None, description="A circle around an axis.")
    path: Annotated[PathTable, _named("path table")] | None = Field(None, description="Straight lines through points.")

    @model_validator(mode="after")
    def _check_one(self) -> "MotionTable":
        if (self.orbit is None) == (self.path is None):
            raise PydanticCustomError("motion", "expected orbit or path, one of the two")
        return self


Motion = Annotated[MotionTable, _named("motion table")]


class LightTable(Table):
    """Keys of every [[light]]."""

    name: Name | None = Field(None, description="For messages.")
    ambient: Color = Field(PointLight.ambient, description="Added to the scene's ambient light, without shadow.")
    diffuse: Color = Field(PointLight.diffuse, description="Light for the Lambert term; may exceed 1.")
    specular: Color | None = Field(None, description="Light for highlights; left out: as `diffuse`.")
    motion: Motion | None = Field(None, description="Moves the light over time.")


class _PlacedLightTable(LightTable):
    position: Vector = Field(description="Where it shines from.")
    radius: Number = Field(PointLight.radius, description="Distance that counts as 1 in the attenuation, above 0.")
    attenuation: Vector = Field(list(PointLight.attenuation), description=(
        "[a0, a1, a2] of 1 / (a0 + a1 x + a2 x²), x = distance / radius."))


class PointLightTable(_PlacedLightTable):
    """[[light]] of type "point"."""

    type: Literal["point"]


class SpotLightTable(_PlacedLightTable):
    """[[light]] of type "spot"."""

    type: Literal["spot"]
    direction: Vector = Field(description="Where it shines to.")
    inner_angle_deg: Number = Field(SpotLight.inner_angle_deg, description="Full light within, degrees off the axis.")
    outer_angle_deg: Number = Field(SpotLight.outer_angle_deg, description="No light beyond, up to 180.")


class DirectionalLightTable(LightTable):
    """[[light]] of type "directional"."""

    type: Literal["directional"]
    direction: Vector = Field(description="Where its light travels to.")


AnyLightTable = Annotated[PointLightTable | SpotLightTable | DirectionalLightTable, Field(discriminator="type")]


Item = TypeVar("Item")
Tables = Annotated[list[Item], Field(fail_fast=True)]  # one error is named; a million would take gigabytes


class SceneTable(Table):
    """A whole scene file."""

    render: RenderTable = RenderTable.model_validate({})
    camera: CameraTable | None = None
    material: Tables[MaterialTable] = []
    mesh: Tables[MeshTable] = []
    instance: Tables[InstanceTable] = []
    sphere: Tables[SphereTable] = []
    light: Tables[AnyLightTable] = []
