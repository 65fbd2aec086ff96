"""An image and how it is looked up."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from glimt.errors import GlimtError
from glimt.scene import checks

Encoding = Literal["srgb", "linear"]
Wrap = Literal["repeat", "clamp"]


@dataclass(eq=False)
class Texture:
    """An image for a material; several textures may share one pixel array.

    Parameters
    ----------
    pixels : (height, width, 3) uint8 or float32
        Row 0 on top. uint8 counts 0..255, float32 0..1. Never changed in place (the engine keeps their mip levels): for
        another image give the texture another array.
    encoding : "srgb" or "linear"
        "srgb" for colour, decoded before use. "linear" for data: a normal map stores ``normal / 2 + 1 / 2`` in RGB,
        +X right, +Y up (OpenGL's convention), +Z out of the surface.
    wrap : "repeat" or "clamp"
        What lies beyond texcoords 0..1.
    scale, offset : pair of float
        Looked up at ``texcoord * scale + offset``, as `-s` and `-o` of MTL files say.
    name : str
        For messages; usually the file's name.
    """

    pixels: NDArray[Any]
    encoding: Encoding = "srgb"
    wrap: Wrap = "repeat"
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)
    name: str = "texture"

    def __post_init__(self) -> None:
        owner = f"texture {self.name!r}"
        if self.encoding not in ("srgb", "linear"):
            raise GlimtError(f"{owner}: encoding is {self.encoding!r}, expected 'srgb' or 'linear'")
        if self.wrap not in ("repeat", "clamp"):
            raise GlimtError(f"{owner}: wrap is {self.wrap!r}, expected 'repeat' or 'clamp'")
        given = getattr(self.pixels, "dtype", np.dtype(np.float32))
        if given.kind != "f" and given != np.uint8:
            raise GlimtError(f"{owner}: pixels are {given}, expected uint8 0..255 or floats 0..1")
        dtype = np.uint8 if given == np.uint8 else np.float32
        self.pixels = checks.array(owner, "pixels", self.pixels, (None, None, 3), dtype)
        if 0 in self.pixels.shape:
            raise GlimtError(f"{owner}: the image has no pixels")
        if self.pixels.flags.writeable:
            self.pixels = self.pixels.view()
            self.pixels.flags.writeable = False
        self.scale = checks.pair(owner, "scale", self.scale)
        self.offset = checks.pair(owner, "offset", self.offset)
