"""One interactive viewer: in a window, a browser, a notebook and a terminal."""

from os import PathLike, fspath
from pathlib import Path
from typing import Any

from glimt.scene.scene import Scene


def view(scene: Scene | str | PathLike[str], *, size: tuple[int, int] | None = None, budget_ms: float = 1000 / 30,
         max_fps: float = 120.0, threads: int | None = None, engine: str = "auto", web: bool = False,
         port: int = 0, watch: bool = False) -> Any:
    """Look at a scene: fly through it, add lights and bounces, pick. Press H for all keys.

    In a notebook (Jupyter, VS Code, Marimo) this returns a widget, elsewhere it opens a window and returns when that is
    closed. The scene itself is not changed.

    Parameters
    ----------
    scene : Scene or path
        A scene, or a `.toml` or `.obj` file.
    size : (width, height), optional
        Of the window or widget in logical pixels; None: as the scene's settings say.
    budget_ms : float
        Milliseconds that a frame may take while anything moves: the picture becomes smaller, never slower.
    max_fps : float
        Frames a second, at most.
    threads : int, optional
        None: as many as the process may use.
    engine : "auto", "cpu" or "gpu"
        "auto" is a GPU where there is one and wgpu is installed.
    web : bool
        Serve a page for browsers on this machine, instead of opening a window; ends with Ctrl-C.
    port : int
        Of the page; 0: any that is free.
    watch : bool
        Load the scene's files again when one changes; for a path only.

    Returns
    -------
    A widget in a notebook, or a still picture where widgets are not installed; else None.

    Raises
    ------
    GlimtError
        Where the file cannot be read, or there is no display.
    """
    from glimt.errors import GlimtError
    from glimt.io import load
    from glimt.io.files_read import recorded
    from glimt.scene import checks
    from glimt.viewer import show
    from glimt.viewer.notebook import in_notebook, notebook_widget
    from glimt.viewer.session import Session

    budget = checks.number("view", "budget_ms", budget_ms, 1, 10_000) / 1000
    max_fps = checks.number("view", "max_fps", max_fps, 1, 1000)
    if size is not None:
        width, height = (int(checks.number("view", "size", side, 16, 16384)) for side in size)
        size = width, height
    path = None if isinstance(scene, Scene) else Path(fspath(scene))
    if watch and path is None:
        raise GlimtError("view: only a scene that is given as a file can be watched")
    with recorded() as files:
        loaded = scene if isinstance(scene, Scene) else load(scene)
    session = Session(loaded, size, budget, max_fps, threads, path=path if watch else None, files=files,
                      engine=engine)
    if in_notebook() and not web:
        return notebook_widget(session)
    if web:
        show.in_browser(session, port=port, open_browser=True)
    else:
        show.in_window(session)
    return None
