"""The viewer in a notebook: a widget, with a still picture for where widgets do not work."""

import base64
import io
import sys
from typing import Any

from PIL import Image

from glimt.viewer.session import Session
from glimt.viewer.viewer import Viewer


def in_notebook() -> bool:
    """Return whether this runs in a notebook: Jupyter, VS Code, Colab or Marimo."""
    if "marimo" in sys.modules and sys.modules["marimo"].running_in_notebook():
        return True
    interactive = sys.modules.get("IPython")
    shell = interactive.get_ipython() if interactive else None
    return shell is not None and hasattr(shell, "kernel")


class Still:
    """A picture of a scene, for notebooks without widgets.

    Parameters
    ----------
    png : bytes
    hint : str
        Why it is only a picture.
    """

    def __init__(self, png: bytes, hint: str) -> None:
        self.png, self.hint = png, hint

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, str]:
        del include, exclude
        encoded = base64.b64encode(self.png).decode()
        return {"image/png": encoded, "text/plain": f"<picture; {self.hint}>",
                "text/html": f'<img src="data:image/png;base64,{encoded}"><br><small>{self.hint}</small>'}


def notebook_widget(session: Session) -> Any:
    """Return a widget that shows a scene, or a `Still` where the widgets' package is not there."""
    try:
        from glimt.viewer.notebook_canvas import NotebookCanvas
    except ModuleNotFoundError as error:
        if (error.name or "").startswith("glimt"):
            raise
        viewer = session.viewer()
        viewer.resize(*session.window_size)
        return Still(png_of(viewer), "for a view to fly through: pip install 'glimt[notebook]', and restart")
    return NotebookCanvas.show(session)


def png_of(viewer: Viewer) -> bytes:
    """Return the picture at full quality as a PNG file."""
    file = io.BytesIO()
    Image.fromarray(viewer.finest()[..., :3]).save(file, "PNG", compress_level=2)
    return file.getvalue()
