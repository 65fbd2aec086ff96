"""The widget: rendercanvas's, drawn by the notebook's event loop, and a still picture for pages without widgets."""

import asyncio
import base64
import contextlib
import contextvars
import sys
import time
import traceback
from collections.abc import Callable
from typing import Any

from anywidget import AnyWidget
from rendercanvas.anywidget import AnywidgetCanvasGroup, AnywidgetRenderCanvas

from glimt.viewer.canvas import connect
from glimt.viewer.notebook import replace_widgets
from glimt.viewer.render_thread import RenderThread
from glimt.viewer.screenshot import finest_png
from glimt.viewer.session import CanvasHost, Session

_QUALITY = 90


class NotebookCanvas(AnywidgetRenderCanvas):  # type: ignore[misc]
    """A canvas of rendercanvas in a notebook's output.

    It lives until it is closed (`close()`), its cell runs again or the kernel ends; while no view of it is visible
    nothing is rendered.

    rendercanvas's own loop is left out: it looks for events and draws on a timer even at rest, takes Ctrl-C from the
    notebook, and knows one asyncio loop for all canvases. Here events go on as they arrive, and each new picture is
    drawn by the loop of the cell that made the widget.

    Attributes
    ----------
    thread : RenderThread
        `thread.viewer` has the camera, the lights and the settings that are seen.
    """

    _rc_canvas_group = AnywidgetCanvasGroup(None)
    thread: RenderThread | None = None
    _is_closed: bool

    def __init__(self, session: Session) -> None:
        self._asyncio = asyncio.get_running_loop()
        self._cell = contextvars.copy_context()  # what is printed in it appears below the cell
        self._frame_seconds = 1 / session.max_fps
        self._next_frame = 0.0
        super().__init__(size=session.window_size)
        self._quality = _QUALITY
        viewer = session.viewer(CanvasHost(self, self._call_soon))
        viewer.resize(*session.window_size)
        self._still = base64.b64encode(finest_png(viewer)).decode()
        self.observe(self._begin_anew, names=["_has_visible_views"])
        self.thread = connect(self, viewer)
        replace_widgets(self)

    def request_draw(self, draw_function: Callable[[], None] | None = None) -> None:
        """Have the widget drawn once it is visible and the page ready for it; from any thread."""
        super().request_draw(draw_function)
        self._call_soon(self._want_draw)

    def _repr_mimebundle_(self, **options: Any) -> Any:
        """Return what the notebook shows: a page without widgets takes the picture."""
        bundle = super()._repr_mimebundle_(**options)
        data, metadata = bundle if isinstance(bundle, tuple) else (bundle, {})
        return {**data, "image/png": self._still}, metadata

    def _call_soon(self, function: Callable[..., None], *arguments: Any) -> None:
        with contextlib.suppress(RuntimeError):  # the loop has been closed: the kernel ends
            self._asyncio.call_soon_threadsafe(function, *arguments, context=self._cell.copy())

    def _want_draw(self) -> None:
        wait = self._next_frame - time.perf_counter()
        if wait > 0:
            self._asyncio.call_later(wait, self._want_draw)
        else:
            self._rfb_draw_requested = True
            self._rfb_maybe_draw()

    def _begin_anew(self, change: Any) -> None:
        """Show the picture to a page that may have been loaded again: it confirms no frame that the last one got."""
        if change["new"]:
            now = time.time()
            self._frame_feedback = {"index": self._rfb_frame_index, "timestamp": now, "localtime": now}
            self._rfb_draw_requested = True

    def _rfb_handle_msg(self, widget: Any, content: dict[str, Any], buffers: Any) -> None:
        """Take an event of the page, and hand it on at once."""
        super()._rfb_handle_msg(widget, content, buffers)
        self._process_events()

    def _rfb_send_frame(self, array: Any, is_lossless_redraw: bool = False) -> None:
        self._next_frame = time.perf_counter() + self._frame_seconds
        super()._rfb_send_frame(array, is_lossless_redraw)

    def _rfb_schedule_lossless_draw(self, array: Any, delay: float = 0.3) -> None:
        """Leave the last JPEG as it is: the base would compress a PNG in Python, and the kernel would wait for it."""

    def _rc_request_paint(self) -> None:
        """Do nothing: a frame that was sent is painted by the page."""

    def _rc_close(self) -> None:
        """Close once: the base would call itself without end. Below the cell, tell what rendering failed with."""
        if not self._is_closed:
            self._is_closed = True
            AnyWidget.close(self)
            if self.thread and self.thread.error:
                self._cell.run(traceback.print_exception, self.thread.error, file=sys.stderr)
