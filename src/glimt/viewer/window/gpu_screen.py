"""A window for pictures on a GPU, which never pass through memory."""

from typing import Any

from rendercanvas.glfw import get_glfw_present_info

from glimt.engines.gpu.device import Device
from glimt.engines.gpu.display import GpuPicture, Surface
from glimt.viewer.window.gl_window import create_bare_window, may_wait


class GpuScreen:
    """A hidden window that a GPU will draw, and what it shows; black up to then. It is made like a `GlScreen`."""

    def __init__(self, size: tuple[int, int], title: str, vsync: bool) -> None:
        self.window = create_bare_window(*size, title)
        self._vsync = vsync
        self._surface: Surface | None = None
        self._picture: GpuPicture | None = None

    def open(self, device: Device) -> None:
        """Be drawn by a GPU from now on.

        Raises
        ------
        EngineError
            Where it cannot show anything in this window.
        """
        self._surface = Surface(device, {**get_glfw_present_info(self.window), "vsync": may_wait(self._vsync)})

    def can_show(self, picture: Any) -> bool:
        """Return whether it is a picture on the GPU."""
        return isinstance(picture, GpuPicture)

    def take(self, picture: GpuPicture) -> None:
        """Show a picture from the next `paint` on."""
        self._picture = picture

    def paint(self, width: int, height: int) -> bool:
        """Stretch the picture over the window, which has so many pixels; return whether that could be done just now.

        Raises
        ------
        EngineError
            When the GPU is lost.
        """
        if self._surface is None or self._picture is None:
            return True
        return self._surface.draw(self._picture, width, height)

    def close(self) -> None:
        """Let the GPU go, before the window is destroyed."""
        if self._surface is not None:
            self._surface.close()
            self._surface = None
