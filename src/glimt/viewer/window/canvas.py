"""A desktop window: rendercanvas's on GLFW, with a screen of ours.

rendercanvas shows a picture only through wgpu, which wants a GPU's driver, and the picture in memory. Here OpenGL shows
what is in memory, with or without a GPU, and the GPU what it has rendered itself (`gl_screen`, `gpu_screen`).
"""

import functools
import time
from collections.abc import Callable
from typing import Any, ClassVar, Protocol

from glimt.viewer.window.gl_window import silence

# isort: split
# After gl_window, which chooses among the libraries of GLFW:
import glfw
from rendercanvas.contexts import BaseContext
from rendercanvas.glfw import GlfwCanvasGroup, GlfwRenderCanvas

from glimt.errors import EngineError, GlimtError
from glimt.viewer.window.gl_screen import GlScreen
from glimt.viewer.window.loop import loop

__all__ = ["GlScreen", "WindowCanvas", "loop"]

_REPAINT_INTERVAL = 0.01
"""Seconds between repaints that the system asks for, so that a hundred uncovered rectangles are not a hundred."""

_KEYPAD = {glfw.KEY_KP_0 + n: glfw.KEY_0 + n for n in range(10)} | {
    glfw.KEY_KP_DECIMAL: ord("."), glfw.KEY_KP_DIVIDE: ord("/"), glfw.KEY_KP_MULTIPLY: ord("*"),
    glfw.KEY_KP_SUBTRACT: ord("-"), glfw.KEY_KP_ADD: ord("+"), glfw.KEY_KP_EQUAL: ord("="),
    glfw.KEY_KP_ENTER: glfw.KEY_ENTER,
}
"""Keys of the number pad, which rendercanvas has no names for, to the same keys elsewhere."""
_CALLBACKS = [getattr(glfw, f"set_{name}_callback") for name in (
    "framebuffer_size", "window_close", "window_refresh", "window_focus", "window_content_scale", "window_maximize",
    "window_iconify", "mouse_button", "cursor_pos", "cursor_enter", "scroll", "key", "char")]
"""What rendercanvas wants to be told of its window."""


class Screen(Protocol):
    """A window of GLFW, hidden at first, and how pictures of some kind get into it."""

    window: Any

    def can_show(self, picture: Any) -> bool:
        """Return whether the picture is of the kind."""

    def take(self, picture: Any) -> None:
        """Show a picture from the next `paint` on."""

    def paint(self, width: int, height: int) -> bool:
        """Stretch the picture over the window, which has so many pixels; return whether that could be done just now.

        Raises
        ------
        EngineError
            When what draws is lost.
        """

    def close(self) -> None:
        """Let go of the window, which is about to be destroyed."""


class _PictureContext(BaseContext):  # type: ignore[misc]
    """What a draw puts its picture into, in memory or not: rendercanvas's own takes arrays only."""

    present_methods: ClassVar[list[str]] = ["bitmap"]
    _picture: Any = None

    def set_bitmap(self, picture: Any) -> None:
        """Have a picture shown."""
        self._picture = picture

    def _rc_present(self, **_: Any) -> dict[str, Any]:
        return {"method": "skip"} if self._picture is None else {"method": "bitmap", "data": self._picture}

    def _rc_close(self) -> None:
        self._picture = None


class WindowCanvas(GlfwRenderCanvas):  # type: ignore[misc]
    """A window that shows RGBA pictures: a canvas of rendercanvas whose present method is "bitmap".

    The picture may have any size: it is stretched over the window, its bytes shown as they are. Between draws the last
    one is shown again whenever the system asks.

    A window for pictures on a GPU becomes another one, at the same place, when a picture in memory comes: what the GPU
    has drawn on, OpenGL cannot, on most systems.

    Events are those of rendercanvas. About keys: names go by the place on a keyboard of the US layout; letters are in
    lower case, with Shift in upper case, but "5" and "/" stay what they are ("char" events have "%" and "?"). Space is
    " ", other keys are named as in browsers ("ArrowUp", "Escape", "F11"), those of the number pad like their
    counterparts elsewhere. A key that is held comes once. When the window loses the focus, "key_up" and "pointer_up"
    come for all that was held. A letter pressed with Shift may come up without: compare in one case.

    Parameters
    ----------
    size : (width, height) in logical pixels
    title : str
    max_fps : float
        Draws, and rounds of looking for events, a second.
    vsync : bool
        Whether showing a picture waits for the screen, which keeps it in one piece. With False for measurements.
    make_screen : Screen
        Begin with this kind: GlScreen for pictures in memory, GpuScreen for those on a GPU.

    Attributes
    ----------
    on_lost : function
        Is called when the GPU fails that is to draw the window.
    error : GlimtError, or None
        Why the window closed by itself: no other could be opened.

    Raises
    ------
    GlimtError
        There is no display, or no OpenGL.
    """

    _rc_canvas_group = GlfwCanvasGroup(loop)

    def __init__(self, *, size: tuple[float, float] = (640, 480), title: str = "glimt", max_fps: float = 120.0,
                 vsync: bool = True,
                 make_screen: Callable[[tuple[int, int], str, bool], Screen] = GlScreen) -> None:
        self.screen = make_screen((int(size[0]), int(size[1])), title, vsync)
        self.on_lost: Callable[[], None] = lambda: None
        self.error: GlimtError | None = None
        self._given = title, vsync
        self._needs_paint = False
        self._last_paint = 0.0
        self._pointer_captured = False
        self._windowed: tuple[int, int, int, int] | None = None  # x, y, width, height before full screen

        # The base class creates a window without OpenGL, and there is no hook between its hints and the call. So the
        # call gives it the window that we have; all else there is right for us.
        create_window, glfw.create_window = glfw.create_window, lambda *_: self.screen.window
        try:
            super().__init__(size=size, title=title, max_fps=max_fps, vsync=vsync, present_method="bitmap")
        finally:
            glfw.create_window = create_window
        self._prepare_pointer()

    def _prepare_pointer(self) -> None:
        if glfw.raw_mouse_motion_supported():  # a captured pointer needs none of the acceleration that others have
            glfw.set_input_mode(self._window, glfw.RAW_MOUSE_MOTION, True)

    # %% Showing the picture

    def get_bitmap_context(self) -> Any:
        """Return what a draw puts its picture into, in memory or on a GPU."""
        return self.get_context(_PictureContext)

    def request_draw(self, draw_function: Callable[[], None] | None = None) -> None:
        """Have the picture drawn soon, by `draw_function` from now on if given. Any thread may ask."""
        super().request_draw(draw_function)
        glfw.post_empty_event()  # wakes the loop

    def _rc_get_present_info(self, present_methods: list[str]) -> dict[str, Any] | None:
        return {"method": "bitmap", "formats": ["rgba-u8"]} if "bitmap" in present_methods else None

    def _rc_present_bitmap(self, *, data: Any) -> None:
        try:
            if not self.screen.can_show(data):
                self._take_another_window()
            self.screen.take(data)
        except GlimtError as error:  # rendercanvas would write it to its log, and go on
            self.error = error
            self.close()

    def _rc_request_paint(self) -> None:
        self._paint()

    def _rc_force_paint(self) -> None:
        """Do nothing: a draw has shown its picture already."""

    def _paint(self) -> None:
        """Show the last picture, stretched to what the window measures now."""
        self._needs_paint = False
        width, height = self.get_physical_size()
        if self._window is None or self._is_minimized or width < 1 or height < 1:
            return
        try:
            self._needs_paint = not self.screen.paint(width, height)
        except EngineError:
            self.on_lost()
        self._last_paint = time.perf_counter()

    def _on_window_dirty(self, *_: Any) -> None:
        # At once, since the system may not return from poll_events for as long as the window is being resized.
        self._needs_paint = True
        if time.perf_counter() - self._last_paint > _REPAINT_INTERVAL:
            self._paint()

    def _on_size_change(self, *_: Any) -> None:
        self._determine_size()
        self._on_window_dirty()
        self.request_draw()

    def _rc_gui_poll(self) -> None:
        glfw.poll_events()
        if self._needs_paint:
            self._paint()
        self._maybe_close()

    def _rc_close(self) -> None:
        if self._window is not None:
            self.screen.close()
        super()._rc_close()

    def _take_another_window(self) -> None:
        """Go on, for pictures in memory, with another window where this one is."""
        before, captured, fullscreen = self.screen, self._pointer_captured, self.is_fullscreen
        with silence():  # Wayland tells nobody where a window is
            left, top, width, height = self._windowed or (*glfw.get_window_pos(before.window),
                                                          *glfw.get_window_size(before.window))
            self.screen = GlScreen((width, height), *self._given)
            glfw.set_window_pos(self.screen.window, left, top)
        self.set_pointer_captured(False)
        self._release_all()
        self._window, self._windowed = self.screen.window, None
        for set_callback in _CALLBACKS:
            set_callback(self._window, set_callback(before.window, None))
        glfw.show_window(self._window)
        before.close()
        glfw.destroy_window(before.window)
        self._prepare_pointer()
        self.set_pointer_captured(captured)
        self.set_fullscreen(fullscreen)
        self._on_size_change()

    def _release_all(self) -> None:
        """Have keys and buttons come up that are held: nobody will tell when they do."""
        for key in range(glfw.KEY_SPACE, glfw.KEY_LAST + 1):
            if glfw.get_key(self._window, key) == glfw.PRESS:
                self._on_key(self._window, key, 0, glfw.RELEASE, 0)
        for button in range(glfw.MOUSE_BUTTON_LAST + 1):
            if glfw.get_mouse_button(self._window, button) == glfw.PRESS:
                self._on_mouse_button(self._window, button, glfw.RELEASE, 0)

    # %% Mouse look, full screen

    def set_pointer_captured(self, captured: bool) -> None:
        """Hide the pointer and keep it in the window, for mouse look, or let it go to where it was.

        While captured, "pointer_move" tells of all motion, wherever the pointer would be: "x" and "y" go on from where
        it was and grow without bound, so the motion is the difference of one event and the next. When it is let go,
        they jump back: forget the last position at each change.
        """
        if self._window is None or captured == self._pointer_captured:
            return
        self._pointer_captured = captured
        glfw.set_input_mode(self._window, glfw.CURSOR, glfw.CURSOR_DISABLED if captured else glfw.CURSOR_NORMAL)
        # The base class drops the motion of a pointer that is elsewhere, and a captured one is nowhere.
        self._pointer_inside = captured or bool(glfw.get_window_attrib(self._window, glfw.HOVERED))

    def _on_cursor_enter(self, window: Any, entered: int) -> None:
        if not self._pointer_captured:
            super()._on_cursor_enter(window, entered)

    @property
    def is_fullscreen(self) -> bool:
        """Whether the window fills a screen."""
        return self._windowed is not None

    def set_fullscreen(self, fullscreen: bool) -> None:
        """Fill the screen that shows most of the window, in its own resolution, or go back to where the window was."""
        if self._window is None or fullscreen == self.is_fullscreen:
            return
        windowed, self._windowed = self._windowed, None
        with silence():  # Wayland tells nobody where a window is
            if windowed:
                no_monitor: Any = None
                glfw.set_window_monitor(self._window, no_monitor, *windowed, glfw.DONT_CARE)
            elif monitors := glfw.get_monitors():
                self._windowed = *glfw.get_window_pos(self._window), *glfw.get_window_size(self._window)
                monitor = max(monitors, key=functools.partial(_shared_area, self._windowed))
                mode = glfw.get_video_mode(monitor)
                glfw.set_window_monitor(self._window, monitor, 0, 0, *mode.size, mode.refresh_rate)

    def _on_key(self, window: Any, key: int, scancode: int, action: int, mods: int) -> None:
        super()._on_key(window, _KEYPAD.get(key, key), scancode, action, mods)


def _shared_area(window: tuple[int, int, int, int], monitor: Any) -> int:
    """Return how much of a window (x, y, width, height) a monitor shows, in the screen's coordinates squared."""
    x, y, width, height = window
    left, top = glfw.get_monitor_pos(monitor)
    size = glfw.get_video_mode(monitor).size
    return (max(0, min(x + width, left + size.width) - max(x, left))
            * max(0, min(y + height, top + size.height) - max(y, top)))
