"""A picture on the screen through the oldest OpenGL there is: what Windows has built in, and Mesa without a GPU."""

import ctypes
from types import SimpleNamespace
from typing import Any

import glfw
import numpy as np
from numpy.typing import NDArray

from glimt.errors import GlimtError

_VERSION, _MAX_TEXTURE_SIZE = 0x1F02, 0x0D33
_TEXTURE_2D, _RGBA, _RGBA8, _UNSIGNED_BYTE = 0x0DE1, 0x1908, 0x8058, 0x1401
_MAG_FILTER, _MIN_FILTER, _WRAP_S, _WRAP_T = 0x2800, 0x2801, 0x2802, 0x2803
_NEAREST, _LINEAR, _CLAMP_TO_EDGE = 0x2600, 0x2601, 0x812F
_TEXTURE_ENV, _TEXTURE_ENV_MODE, _REPLACE = 0x2300, 0x2200, 0x1E01
_QUADS, _COLOR_BUFFER_BIT = 0x0007, 0x4000

_int, _enum, _float, _bits = ctypes.c_int, ctypes.c_uint, ctypes.c_float, ctypes.c_void_p
_FUNCTIONS: dict[str, tuple[Any, ...]] = {
    "GetString": (ctypes.c_char_p, _enum),
    "GetIntegerv": (None, _enum, ctypes.POINTER(_int)),
    "Enable": (None, _enum),
    "Disable": (None, _enum),
    "Viewport": (None, _int, _int, _int, _int),
    "Clear": (None, _enum),
    "TexParameteri": (None, _enum, _enum, _int),
    "TexEnvi": (None, _enum, _enum, _int),
    "TexImage2D": (None, _enum, _int, _int, _int, _int, _int, _enum, _enum, _bits),
    "TexSubImage2D": (None, _enum, _int, _int, _int, _int, _int, _enum, _enum, _bits),
    "Begin": (None, _enum),
    "TexCoord2f": (None, _float, _float),
    "Vertex2f": (None, _float, _float),
    "End": (None,),
    "RasterPos2f": (None, _float, _float),
    "PixelZoom": (None, _float, _float),
    "DrawPixels": (None, _int, _int, _enum, _enum, _bits),
}


def _load_functions() -> SimpleNamespace:
    """Load what is used of OpenGL. ctypes lets other threads run while such a function does its work."""
    prototype: Any = getattr(ctypes, "WINFUNCTYPE", ctypes.CFUNCTYPE)
    functions = {}
    for name, types in _FUNCTIONS.items():
        address = glfw.get_proc_address("gl" + name)
        if not address:
            raise GlimtError(f"OpenGL has no function gl{name} here: install a driver, or use another way to view")
        functions[name] = prototype(*types)(address)
    return SimpleNamespace(**functions)


class Blitter:
    """Shows pictures of any size, stretched over a window. It belongs to the context that was current when it was made.

    Bytes go to the screen as they are, row 0 on top. A picture as large as the window keeps its exact pixels; another
    is interpolated linearly. Where OpenGL is older than 2.0, or the picture larger than textures may be, it is copied
    without a texture, and stretching repeats pixels.
    """

    def __init__(self) -> None:
        self._gl = _load_functions()
        version = (self._gl.GetString(_VERSION) or b"1.1").decode()
        largest = _int()
        self._gl.GetIntegerv(_MAX_TEXTURE_SIZE, largest)
        # Before 2.0, the sides of a texture are powers of two.
        self._max_texture_size = largest.value if int(version.split(".")[0]) >= 2 else 0
        self._size = (0, 0)  # width and height of the picture
        self._texture_size = (0, 0)
        self._pixels: NDArray[np.uint8] | None = None  # the picture, when it is not in the texture
        for name, value in ((_WRAP_S, _CLAMP_TO_EDGE), (_WRAP_T, _CLAMP_TO_EDGE)):
            self._gl.TexParameteri(_TEXTURE_2D, name, value)
        self._gl.TexEnvi(_TEXTURE_ENV, _TEXTURE_ENV_MODE, _REPLACE)

    def upload(self, picture: NDArray[np.uint8]) -> None:
        """Take a copy of `picture`, (h, w, 4) uint8 and contiguous, to be drawn from now on."""
        height, width = picture.shape[:2]
        self._size = width, height
        if max(width, height) > self._max_texture_size:
            self._pixels = picture.copy()
            return
        self._pixels = None
        if self._size != self._texture_size:
            self._texture_size = self._size
            self._gl.TexImage2D(_TEXTURE_2D, 0, _RGBA8, width, height, 0, _RGBA, _UNSIGNED_BYTE, None)
        self._gl.TexSubImage2D(_TEXTURE_2D, 0, 0, 0, width, height, _RGBA, _UNSIGNED_BYTE, picture.ctypes.data)

    def draw(self, width: int, height: int) -> None:
        """Draw the picture over a framebuffer of this size, or black when there is no picture yet."""
        gl = self._gl
        gl.Viewport(0, 0, width, height)
        if 0 in self._size:
            gl.Clear(_COLOR_BUFFER_BIT)
        elif self._pixels is not None:
            gl.RasterPos2f(-1, 1)
            gl.PixelZoom(width / self._size[0], -height / self._size[1])
            gl.DrawPixels(*self._size, _RGBA, _UNSIGNED_BYTE, self._pixels.ctypes.data)
        else:
            self._draw_texture(_NEAREST if self._size == (width, height) else _LINEAR)

    def _draw_texture(self, texture_filter: int) -> None:
        gl = self._gl
        gl.TexParameteri(_TEXTURE_2D, _MIN_FILTER, texture_filter)
        gl.TexParameteri(_TEXTURE_2D, _MAG_FILTER, texture_filter)
        gl.Enable(_TEXTURE_2D)
        gl.Begin(_QUADS)
        for x, y in ((0, 0), (1, 0), (1, 1), (0, 1)):
            gl.TexCoord2f(x, y)
            gl.Vertex2f(2 * x - 1, 1 - 2 * y)
        gl.End()
        gl.Disable(_TEXTURE_2D)
