"""MTL files to materials. Nothing in one stops a load: what cannot be read or drawn is a warning with its line."""

import math
import os
from dataclasses import dataclass, field
from pathlib import Path

from glimt.errors import GlimtError, WarningCounter
from glimt.io.image import TextureCache
from glimt.io.mtl_maps import Map, MapReader, parse_map
from glimt.io.obj_text import decode, read_bytes, without_comment
from glimt.scene.material import Material

LARGEST_FILE = 16 * 2**20

_COLORS = ("ka", "kd", "ks", "ke")
_NUMBERS = ("ns", "d", "tr", "illum")
_NORMAL_MAPS = ("norm", "map_kn")
_BUMP_MAPS = ("map_bump", "bump")
_DISPLACEMENT_MAPS = ("map_disp", "disp")
_MAPS = ("map_kd", "map_ka", *_NORMAL_MAPS, *_BUMP_MAPS, *_DISPLACEMENT_MAPS)
_UNUSED_MAPS = ("map_ks", "map_ns", "map_d", "map_tr", "map_ke", "map_pr", "map_pm", "map_ps", "map_opacity", "refl",
                "map_refl", "decal")
_SILENT = ("ni", "tf", "kt", "km", "sharpness", "map_aat", "pr", "pm", "ps", "pc", "pcr", "aniso", "anisor")
_MIRRORS = (3, 4, 5, 6, 7)  # the illumination models with ray-traced reflection
_WITHOUT_HIGHLIGHT = (0, 1)

Color = tuple[float, float, float]


@dataclass
class _Draft:
    """The statements of one `newmtl`, the last of each kind."""

    name: str
    where: str
    colors: dict[str, Color] = field(default_factory=dict)
    numbers: dict[str, float] = field(default_factory=dict)
    maps: dict[str, Map] = field(default_factory=dict)

    def opacity(self) -> float:
        """Return `d`, or where there is none 1 - `Tr`."""
        return self.numbers.get("d", 1 - self.numbers.get("tr", 0))


def read_mtl(path: str | os.PathLike[str], warnings: WarningCounter,
             textures: TextureCache | None = None, used: set[str] | None = None) -> dict[str, Material]:
    """Read the materials of an MTL file by name.

    Parameters
    ----------
    path : str or path
        At most 16 MiB; the textures it names are looked for from its folder (see `obj_paths`).
    warnings : WarningCounter
        Receives everything that is missing, wrong, or not drawn.
    textures : TextureCache, optional
        Shared by the files of one load.
    used : set of str, optional
        Names of the materials wanted; None: all. Textures of others are not read.

    Returns
    -------
    dict of str to Material
        Empty where the file cannot be read. Everything is opaque: `d` and `Tr` are a warning. A missing colour texture
        becomes a checker. The illumination models with ray-traced reflection make a mirror of the mean of `Ks`.
    """
    path = Path(path)
    drafts = _read_drafts(path, warnings, used)
    _warn_transparent(path, list(drafts.values()), warnings)
    reader = MapReader(textures or TextureCache(), warnings)
    return {name: _material(draft, reader, warnings) for name, draft in drafts.items()}


def _read_drafts(path: Path, warnings: WarningCounter, used: set[str] | None) -> dict[str, _Draft]:
    drafts: dict[str, _Draft] = {}
    draft = None
    issued, unused = warnings, WarningCounter()
    for number, word, text in _statements(path, warnings):
        where = f"{path}:{number}"
        if word == "newmtl":
            draft = _Draft(text, where)
            wanted = used is None or text in used or without_comment(text) in used
            warnings = issued if wanted else unused
            if text in drafts:
                warnings.add("a material is defined again; the last one is used", where)
            if wanted:
                drafts[text] = draft
        elif draft is None:
            warnings.add("a statement before the first newmtl is ignored", where)
        elif word in _MAPS:
            statement = parse_map(text, where, path.parent, warnings)
            if statement.name:
                draft.maps[word] = statement
        else:
            _add_value(draft, word, text.split("#")[0].split(), where, warnings)
    return drafts


def _statements(path: Path, warnings: WarningCounter) -> list[tuple[int, str, str]]:
    """Return (line number, word in lower case, rest of the line) for each line that says something."""
    try:
        content = read_bytes(path)
        if len(content) > LARGEST_FILE:
            raise GlimtError(f"{path}: more than {LARGEST_FILE // 2**20} MiB for an MTL file")
    except GlimtError as error:
        warnings.add(f"{error}; its materials are left out")
        return []
    result = []
    text = decode(content.tobytes().removeprefix(b"\xef\xbb\xbf"))
    for number, line in enumerate(text.replace("\r\n", "\n").replace("\r", "\n").split("\n"), 1):
        word, _, rest = line.strip().replace("\t", " ").partition(" ")
        if word and not word.startswith("#"):
            result.append((number, word.lower(), rest.strip()))
    return result


def _add_value(draft: _Draft, word: str, values: list[str], where: str, warnings: WarningCounter) -> None:
    """Store a colour or a number, or count why not."""
    if word in _COLORS:
        color = _color(values)
        if color is None:
            warnings.add(f"{word.capitalize()} is not one or three numbers from 0 on; it is ignored", where)
        else:
            draft.colors[word] = color
    elif word in _NUMBERS:
        numbers = [_number(value) for value in values if value != "-halo"]
        if len(numbers) != 1 or numbers[0] is None:
            warnings.add(f"{word.capitalize()} is not a number; it is ignored", where)
        else:
            draft.numbers[word] = numbers[0]
    elif word in _UNUSED_MAPS:
        warnings.add(f"{word} is not drawn", where)
    elif word not in _SILENT:
        warnings.add(f"statement {word[:40]!r} is not part of MTL; it is ignored", where)


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) and abs(value) <= 1e6 else None


def _color(values: list[str]) -> Color | None:
    numbers = [_number(value) for value in values]
    parts = [number for number in numbers if number is not None and number >= 0]
    if len(parts) != len(values) or len(parts) not in (1, 3):
        return None
    return (parts[0], parts[0], parts[0]) if len(parts) == 1 else (parts[0], parts[1], parts[2])


def _warn_transparent(path: Path, drafts: list[_Draft], warnings: WarningCounter) -> None:
    see_through = [draft for draft in drafts if draft.opacity() < 1]
    if drafts and all(draft.opacity() <= 0 for draft in drafts):
        warnings.add("every material is invisible (d 0 or Tr 1), most likely written the wrong way round; "
                     "all are drawn opaque", drafts[0].where)
    elif see_through:
        warnings.add(f"{path.name} has transparent materials (d or Tr); they are drawn opaque", see_through[0].where)


def _material(draft: _Draft, reader: MapReader, warnings: WarningCounter) -> Material:
    diffuse_map = draft.maps.get("map_kd")
    material = Material(name=draft.name, ambient=draft.colors.get("ka"),
                        diffuse=_diffuse(draft, diffuse_map, warnings),
                        diffuse_texture=reader.color(diffuse_map) if diffuse_map else None)
    specular = draft.colors.get("ks", (0.0, 0.0, 0.0))
    illumination = draft.numbers.get("illum", 2)
    if illumination not in _WITHOUT_HIGHLIGHT:
        material.specular = specular
    if illumination in _MIRRORS:
        material.reflectivity = min(sum(specular) / 3, 1.0)
    material.exponent = max(draft.numbers.get("ns", material.exponent), 0.0)
    _add_normal_map(material, draft, reader)
    ambient_map = draft.maps.get("map_ka")
    if ambient_map and (diffuse_map is None or ambient_map.name != diffuse_map.name):
        warnings.add("map_ka is not drawn", ambient_map.where)
    if max(draft.colors.get("ke", (0.0,))) > 0:
        warnings.add("Ke is not drawn: nothing glows by itself; add a light", draft.where)
    return material


def _diffuse(draft: _Draft, diffuse_map: Map | None, warnings: WarningCounter) -> Color | float:
    diffuse = draft.colors.get("kd")
    if diffuse_map is None:
        return 0.8 if diffuse is None else diffuse
    if diffuse == (0, 0, 0):
        warnings.add("Kd 0 0 0 would make map_Kd black; it is taken for 1 1 1", diffuse_map.where)
        return 1.0
    return 1.0 if diffuse is None else diffuse


def _add_normal_map(material: Material, draft: _Draft, reader: MapReader) -> None:
    """Set the first normal map there is: of `norm`, else `map_Bump`, else `map_Disp`."""
    for word in (*_NORMAL_MAPS, *_BUMP_MAPS, *_DISPLACEMENT_MAPS):
        if word not in draft.maps or material.normal_texture is not None:
            continue
        if word in _NORMAL_MAPS:
            material.normal_texture = reader.normal(draft.maps[word])
        elif word in _DISPLACEMENT_MAPS:
            material.normal_texture = reader.displacement(draft.maps[word])
        elif found := reader.bump(draft.maps[word]):
            material.normal_texture, material.normal_scale = found
