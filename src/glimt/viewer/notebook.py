"""The viewer in a notebook: a widget, with a still picture for where widgets do not work."""

import asyncio
import base64
import sys
from typing import Any
from weakref import WeakSet

from glimt.errors import GlimtError
from glimt.extras import need
from glimt.viewer.screenshot import finest_png
from glimt.viewer.session import Session


def in_notebook() -> bool:
    """Return whether this runs in a notebook: Jupyter, VS Code, Colab or Marimo."""
    if "marimo" in sys.modules and sys.modules["marimo"].running_in_notebook():
        return True
    return hasattr(_shell(), "kernel")


_widgets: dict[str, tuple[str, WeakSet[Any]]] = {}
"""By cell: its last run, and what that made."""


def replace_widgets(widget: Any) -> None:
    """Close what an earlier run of this cell has made: its output is gone, and each holds some 40 bytes a pixel.

    Only Jupyter and VS Code tell what cell runs; elsewhere nothing is closed.
    """
    shell = _shell()
    parent = shell.get_parent() if hasattr(shell, "get_parent") else {}
    cell = parent.get("metadata", {}).get("cellId")
    if cell is None:
        return
    run = parent["header"]["msg_id"]
    last_run, widgets = _widgets.get(cell, (run, WeakSet()))
    if last_run != run:
        for former in list(widgets):
            former.close()
        widgets = WeakSet()
    widgets.add(widget)
    _widgets[cell] = run, widgets


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


def _shell() -> Any:
    """Return IPython's, or None."""
    interactive = sys.modules.get("IPython")
    return interactive.get_ipython() if interactive else None


def notebook_widget(session: Session) -> Any:
    """Return a widget that shows a scene, or a `Still` where the widgets' package or an event loop is not there."""
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return _still(session, "for a view to fly through: call it in a cell, not in a thread")
    try:
        canvas = need("glimt.viewer.notebook_canvas", "notebook")
    except GlimtError:
        return _still(session, "for a view to fly through: pip install 'glimt[notebook]', and restart")
    return canvas.NotebookCanvas(session)


def _still(session: Session, hint: str) -> Still:
    viewer = session.viewer()
    viewer.resize(*session.window_size)
    try:
        return Still(finest_png(viewer), hint)
    finally:
        viewer.presenter.close()
