"""Hidden GLFW windows, with an OpenGL context or without, or an error that says what to do instead."""

import contextlib
import os
import socket
import sys
from collections.abc import Iterator
from typing import Any

if sys.platform == "linux":
    # GLFW comes as two libraries. That for X11 has decorations and full screen on every desktop, Wayland's too.
    os.environ.setdefault("PYGLFW_LIBRARY_VARIANT",
                          "wayland" if "WAYLAND_DISPLAY" in os.environ and "DISPLAY" not in os.environ else "x11")

import glfw

from glimt.errors import GlimtError

OTHER_WAYS = "`glimt view SCENE --web` shows it in a browser, `--terminal` in this terminal, `glimt render` in a file"
_DISPLAY_TIMEOUT = 5.0
"""Seconds that a display on another machine has to answer."""


@contextlib.contextmanager
def silence() -> Iterator[None]:
    """Keep GLFW from turning its errors into warnings: they are asked for, or do not matter."""
    before, glfw.ERROR_REPORTING = glfw.ERROR_REPORTING, "ignore"
    try:
        yield
    finally:
        glfw.ERROR_REPORTING = before


def check_display() -> None:
    """Raise a `GlimtError` where there is no display: within milliseconds, before anything else is done."""
    if sys.platform == "linux":
        _check_remote_display()
    with silence():
        if not glfw.init():
            raise GlimtError(f"no display: {_last_error()}; {OTHER_WAYS}")


def create_gl_window(width: int, height: int, title: str) -> Any:
    """Create a hidden window of this size (of the screen's coordinates) with an OpenGL context of the lowest kind.

    Raises
    ------
    GlimtError
        There is no display, or no OpenGL.
    """
    check_display()
    with silence():
        # EGL where there is no GLX: some servers of X11 come without.
        for api in (glfw.NATIVE_CONTEXT_API, glfw.EGL_CONTEXT_API):
            _hint()
            glfw.window_hint(glfw.CONTEXT_CREATION_API, api)
            for unused in (glfw.DEPTH_BITS, glfw.STENCIL_BITS, glfw.ALPHA_BITS):
                glfw.window_hint(unused, 0)
            if window := glfw.create_window(max(width, 1), max(height, 1), title, None, None):
                return window
        install = "; on Debian and Ubuntu: apt install libgl1 libgl1-mesa-dri" if sys.platform == "linux" else ""
        raise GlimtError(f"no OpenGL: {_last_error()}{install}; or without: {OTHER_WAYS}")


def create_bare_window(width: int, height: int, title: str) -> Any:
    """Create a hidden window of this size (of the screen's coordinates) that others than OpenGL draw.

    Raises
    ------
    GlimtError
        There is no display.
    """
    check_display()
    with silence():
        _hint()
        glfw.window_hint(glfw.CLIENT_API, glfw.NO_API)
        if window := glfw.create_window(max(width, 1), max(height, 1), title, None, None):
            return window
        raise GlimtError(f"no window: {_last_error()}; {OTHER_WAYS}")


def may_wait(vsync: bool) -> bool:
    """Return whether showing a picture may wait for the screen; once there is a window.

    On Wayland, the compositor shows whole pictures anyway, and waiting for one that is covered would not end.
    """
    return vsync and not (hasattr(glfw, "get_platform") and glfw.get_platform() == glfw.PLATFORM_WAYLAND)


def _hint() -> None:
    """Say how windows are created from now on."""
    glfw.default_window_hints()
    glfw.window_hint(glfw.VISIBLE, False)
    glfw.window_hint(glfw.AUTO_ICONIFY, False)  # full screen stays when another screen gets the focus
    glfw.window_hint_string(glfw.X11_CLASS_NAME, "glimt")


def _last_error() -> str:
    description: Any = glfw.get_error()[1]  # bytes, whatever its stub says
    return description.decode() if description else "GLFW does not say why"


def _check_remote_display() -> None:
    """Raise a `GlimtError` when DISPLAY names another machine that does not answer: Xlib would wait for minutes."""
    host, _, number = os.environ.get("DISPLAY", "").partition(":")
    if not host or not number or "/" in host or host == "unix":
        return
    try:
        socket.create_connection((host, 6000 + int(number.split(".")[0])), _DISPLAY_TIMEOUT).close()
    except (OSError, ValueError, OverflowError) as error:
        raise GlimtError(f"no display: {os.environ['DISPLAY']} does not answer ({error}); {OTHER_WAYS}") from None
