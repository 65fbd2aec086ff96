"""The widget: rendercanvas's, with a still picture for pages that show no widgets."""

import base64
from typing import Any

from rendercanvas.anywidget import AnywidgetRenderCanvas, loop

from glimt.viewer.canvas import connect
from glimt.viewer.notebook import png_of
from glimt.viewer.render_thread import RenderThread
from glimt.viewer.session import CanvasHost, Session

_QUALITY = 90


class NotebookCanvas(AnywidgetRenderCanvas):  # type: ignore[misc]
    """A canvas of rendercanvas in a notebook's output.

    It lives until it is closed (`close()`) or the kernel ends; while no view of it is visible nothing is rendered.

    Attributes
    ----------
    thread : RenderThread
        `thread.viewer` has the camera, the lights and the settings that are seen.
    """

    thread: RenderThread
    _still: str

    @classmethod
    def show(cls, session: Session) -> "NotebookCanvas":
        """Return a widget that shows a scene."""
        canvas = cls(size=session.window_size, title="", max_fps=min(session.max_fps, 60.0))
        canvas._quality = _QUALITY
        viewer = session.viewer(CanvasHost(canvas, loop.call_soon_threadsafe, session.folder))
        viewer.resize(*session.window_size)
        canvas._still = base64.b64encode(png_of(viewer)).decode()
        canvas.thread = connect(canvas, viewer)
        return canvas

    def _repr_mimebundle_(self, **options: Any) -> Any:
        """Return what the notebook shows: a page without widgets takes the picture."""
        bundle = super()._repr_mimebundle_(**options)
        data, metadata = bundle if isinstance(bundle, tuple) else (bundle, {})
        return {**data, "image/png": self._still}, metadata

    def _rfb_schedule_lossless_draw(self, array: Any, delay: float = 0.3) -> None:
        """Leave the last JPEG as it is: the base would compress a PNG in Python, and the kernel would wait for it."""
