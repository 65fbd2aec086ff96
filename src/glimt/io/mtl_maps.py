"""The `map_` statements of MTL files: options, colour textures, normal maps and height maps."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from glimt.errors import GlimtError, WarningCounter
from glimt.io.image import TextureCache
from glimt.io.obj_paths import FileFinder
from glimt.io.obj_text import without_comment
from glimt.scene.texture import Texture, Wrap

HEIGHT_SHARE = 0.01
"""A height map's black and white are `-bm` times this share of the texture's width apart; MTL leaves it open."""

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_ARGUMENTS = {"-s": 3, "-o": 3, "-t": 3, "-mm": 2, "-bm": 1, "-boost": 1, "-texres": 1, "-blendu": 1, "-blendv": 1,
              "-cc": 1, "-clamp": 1, "-imfchan": 1, "-type": 1}
_NUMERIC = ("-s", "-o", "-t", "-mm", "-bm", "-boost")
_IGNORED = ("-t", "-mm", "-imfchan")
_LATER_OPTION = re.compile(r"\s-(?:s|o|t|mm|bm|boost|texres|blendu|blendv|cc|clamp|imfchan|type)\s")


@dataclass
class Map:
    """A `map_` statement.

    scale, offset : pair of float
        As written, for texcoords with their origin at the bottom left.
    bump : float
        `-bm`, the height of a bump map.
    where : str
        "room.mtl:12"
    """

    name: str
    where: str
    folder: Path
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)
    bump: float = 1.0
    wrap: Wrap = "repeat"

    def texcoord_scale_offset(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return scale and offset for texcoords with their origin at the top left, v' = 1 - v."""
        (su, sv), (ou, ov) = self.scale, self.offset
        return (su, sv), (ou, 1 - sv - ov)


def parse_map(text: str, where: str, folder: Path, warnings: WarningCounter) -> Map:
    """Return what follows `map_Kd` and the like: options before or after a file name that may hold spaces."""
    result = Map("", where, folder)
    rest = _options(text.strip(), result, warnings)
    later = _LATER_OPTION.search(rest)
    if later:
        _options(rest[later.start():].strip(), result, warnings)
        rest = rest[:later.start()]
    result.name = rest.strip()
    return result


def _options(text: str, result: Map, warnings: WarningCounter) -> str:
    """Apply the options that `text` starts with to `result`; return the rest."""
    while (match := re.match(r"(-\w+)\s+", text)) and match[1].lower() in _ARGUMENTS:
        option, text = match[1].lower(), text[match.end():]
        values: list[str] = []
        while len(values) < _ARGUMENTS[option]:
            word = re.match(r"\S+", text)
            if not word or (option in _NUMERIC and not _NUMBER.fullmatch(word[0])):
                break
            values.append(word[0])
            text = text[word.end():].lstrip()
        _apply(option, values, result, warnings)
    return text


def _apply(option: str, values: list[str], result: Map, warnings: WarningCounter) -> None:
    if not values:
        warnings.add(f"option {option} has no value", result.where)
    elif option == "-clamp":
        result.wrap = "clamp" if values[0].lower() == "on" else "repeat"
    elif option in _NUMERIC:
        numbers = [float(value) for value in values]
        if max(abs(number) for number in numbers) > 1e6:
            warnings.add(f"option {option} is beyond 1e6; it is ignored", result.where)
        elif option == "-bm":
            result.bump = numbers[0]
        elif option == "-s":
            result.scale = (numbers[0], numbers[1] if len(numbers) > 1 else 1.0)
        elif option == "-o":
            result.offset = (numbers[0], numbers[1] if len(numbers) > 1 else 0.0)
    if option in _IGNORED:
        warnings.add(f"option {option} is ignored", result.where)


class MapReader:
    """Makes textures of `map_` statements; a missing or damaged file is a warning."""

    def __init__(self, textures: TextureCache, warnings: WarningCounter) -> None:
        self._textures = textures
        self._warnings = warnings
        self._finder = FileFinder()
        self._from_heights: dict[tuple[int, float, Wrap], NDArray[np.float32]] = {}

    def color(self, statement: Map) -> Texture:
        """Return a colour texture; a magenta checker where the file is missing or damaged."""
        pixels = self._pixels(statement, "a checker is drawn instead")
        if pixels is None:
            pixels = checker()
        return self._texture(statement, pixels, "srgb")

    def normal(self, statement: Map) -> Texture | None:
        """Return the normal map that `norm` names; None where the file is missing or damaged."""
        pixels = self._pixels(statement, "no normal map is used")
        return None if pixels is None else self._texture(statement, pixels, "linear")

    def bump(self, statement: Map) -> tuple[Texture, float] | None:
        """Return (normal map, normal scale) for `map_Bump`, which in the wild names a height map or a normal map."""
        pixels = self._pixels(statement, "no bump map is used")
        if pixels is None:
            return None
        if is_normal_map(pixels):
            return self._texture(statement, pixels, "linear"), min(max(statement.bump, -100.0), 100.0)
        key = (id(pixels), statement.bump, statement.wrap)  # the cache keeps `pixels` alive
        if key not in self._from_heights:
            self._from_heights[key] = normals_from_heights(pixels, statement.bump, statement.wrap)
        return self._texture(statement, self._from_heights[key], "linear"), 1.0

    def displacement(self, statement: Map) -> Texture | None:
        """Return the normal map that `map_Disp` names by mistake; None for a real displacement map."""
        pixels = self._pixels(statement, "no normal map is used")
        if pixels is None or not is_normal_map(pixels):
            if pixels is not None:
                self._warnings.add("displacement maps are not drawn", statement.where)
            return None
        return self._texture(statement, pixels, "linear")

    def _pixels(self, statement: Map, remedy: str) -> NDArray[np.uint8] | None:
        path = (self._finder.find(statement.name, statement.folder)
                or self._finder.find(without_comment(statement.name), statement.folder))
        try:
            if path is None:
                raise GlimtError(f"there is no file {statement.name!r}")
            return self._textures.pixels(path)
        except GlimtError as error:
            self._warnings.add(f"{error}; {remedy}", statement.where)
            return None

    def _texture(self, statement: Map, pixels: NDArray[np.uint8] | NDArray[np.float32], encoding: str) -> Texture:
        scale, offset = statement.texcoord_scale_offset()
        name = re.split(r"[\\/]", statement.name)[-1]
        return Texture(pixels, "srgb" if encoding == "srgb" else "linear", statement.wrap, scale, offset, name)


def checker() -> NDArray[np.uint8]:
    """Return the 2 x 2 magenta and grey pixels that stand for a missing texture."""
    magenta, grey = (255, 0, 255), (128, 128, 128)
    return np.array([[magenta, grey], [grey, magenta]], np.uint8)


def is_normal_map(pixels: NDArray[np.uint8]) -> bool:
    """Return whether (h, w, 3) pixels look like a tangent-space normal map: bluish, around (0.5, 0.5, 1)."""
    step = max(1, int(np.sqrt(pixels.shape[0] * pixels.shape[1]) / 256))
    red, green, blue = pixels[::step, ::step].reshape(-1, 3).mean(0) / 255
    return bool(abs(red - 0.5) < 0.15 and abs(green - 0.5) < 0.15 and blue > 0.65 and blue - max(red, green) > 0.1)


def normals_from_heights(pixels: NDArray[np.uint8], bump: float, wrap: Wrap) -> NDArray[np.float32]:
    """Return the (h, w, 3) float32 normal map of a height map: white is up, slopes by central differences.

    The normal of the height field z = f(x, y) is (-df/dx, -df/dy, 1); x grows along rows, y up the columns.
    """
    heights = pixels.mean(-1, dtype=np.float32) / np.float32(255) * np.float32(bump * HEIGHT_SHARE * pixels.shape[1])
    padded = np.pad(heights, 1, mode="wrap" if wrap == "repeat" else "edge")
    normals = np.ones((*heights.shape, 3), np.float32)
    normals[..., 0] = (padded[1:-1, :-2] - padded[1:-1, 2:]) / 2
    normals[..., 1] = (padded[2:, 1:-1] - padded[:-2, 1:-1]) / 2  # row 0 is on top
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    return normals * np.float32(0.5) + np.float32(0.5)
