"""A viewer on a canvas: the one place where rendercanvas, the viewer and its thread meet."""

import logging
from typing import Any

from glimt.viewer.render_thread import RenderThread
from glimt.viewer.viewer import Viewer

EVENTS = ("key_down", "key_up", "pointer_down", "pointer_move", "pointer_up", "double_click", "wheel", "resize")


def connect(canvas: Any, viewer: Viewer, ahead: int = 0) -> RenderThread:
    """Show a viewer on a canvas of rendercanvas that takes bitmaps; the thread ends when the canvas is closed.

    Events are handed to the thread, pictures are taken from it: the canvas' own thread does nothing that lasts. If
    the thread ends by an error, the canvas is closed; the error is in `RenderThread.error`. `ahead`: see there.
    """
    logging.getLogger("rendercanvas").setLevel(logging.ERROR)  # Ctrl-C is no warning
    context = canvas.get_bitmap_context()
    # A draw that is asked for is a flag, which the canvas' scheduler looks at: any thread may set it.
    thread = RenderThread(viewer, canvas.request_draw, ahead)

    def draw() -> None:
        if not thread.running:
            canvas.close()
            return
        picture = thread.take()
        if picture is not None:
            context.set_bitmap(picture)

    def close(event: dict[str, Any]) -> None:
        del event
        thread.stop()

    if hasattr(canvas, "on_lost"):  # a window that may be a GPU's
        canvas.on_lost = lambda: thread.do(viewer.leave_gpu)
    canvas.add_event_handler(thread.post, *EVENTS)
    canvas.add_event_handler(close, "close")
    canvas.request_draw(draw)
    thread.start()
    return thread
