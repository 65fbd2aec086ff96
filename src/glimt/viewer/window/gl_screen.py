"""A window for pictures in memory, on any machine that has OpenGL, were it Mesa's without a GPU."""

from typing import Any

import glfw
import numpy as np
from numpy.typing import NDArray

from glimt.viewer.window.blit import Blitter
from glimt.viewer.window.gl_window import create_gl_window, may_wait


class GlScreen:
    """A hidden window with an OpenGL context, and what it shows.

    Parameters
    ----------
    size : (width, height) in the screen's coordinates
    title : str
    vsync : bool
        Whether showing a picture waits for the screen, which keeps it in one piece.
    """

    def __init__(self, size: tuple[int, int], title: str, vsync: bool) -> None:
        self.window = create_gl_window(*size, title)
        glfw.make_context_current(self.window)
        glfw.swap_interval(1 if may_wait(vsync) else 0)
        self._blitter = Blitter()

    def can_show(self, picture: Any) -> bool:
        """Return whether it is a picture in memory, (h, w, 4) uint8."""
        return isinstance(picture, np.ndarray)

    def take(self, picture: NDArray[np.uint8]) -> None:
        """Show a picture from the next `paint` on."""
        glfw.make_context_current(self.window)
        self._blitter.upload(picture)

    def paint(self, width: int, height: int) -> bool:
        """Stretch the picture over the window, which has so many pixels; return True: it is there."""
        glfw.make_context_current(self.window)
        self._blitter.draw(width, height)
        glfw.swap_buffers(self.window)
        return True

    def close(self) -> None:
        """Do nothing: the context goes with its window."""
