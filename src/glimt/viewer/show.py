"""The places where a scene can be looked at: a window, a browser, a terminal."""

import contextlib
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from glimt.engines.choice import choose_engine
from glimt.errors import EngineError, GlimtError
from glimt.extras import need
from glimt.viewer.keys import help_table
from glimt.viewer.overlay.text_overlay import TextOverlay
from glimt.viewer.session import CanvasHost, Session
from glimt.viewer.viewer import Viewer


def in_window(session: Session) -> None:
    """Show a scene in a desktop window until it is closed.

    Raises
    ------
    GlimtError
        Where there is no display; the message names the other places.
    """
    from glimt.viewer.window import canvas as window

    screen: Any = window.GlScreen
    on_gpu = choose_engine(session.engine).engine == "gpu"
    if on_gpu:
        from glimt.viewer.window.gpu_screen import GpuScreen

        screen = GpuScreen
    canvas = window.WindowCanvas(size=session.window_size, title=session.title, max_fps=session.max_fps,
                                 make_screen=screen)
    try:
        viewer = session.viewer(CanvasHost(canvas, window.loop.call_soon_threadsafe))
        if on_gpu:
            _leave_pictures_on_gpu(viewer, canvas.screen)
        session.run(canvas, viewer, window.loop.run)
        if canvas.error is not None:
            raise canvas.error
    finally:
        canvas.close()


def _leave_pictures_on_gpu(viewer: Viewer, screen: Any) -> None:
    """Have pictures go from the GPU to its window, where it can do that; else they come by memory as elsewhere."""
    from glimt.viewer.gpu_presenter import GpuPresenter

    device = viewer.renderer.keep_films()
    if device is None:  # could not be opened
        return
    with contextlib.suppress(EngineError):
        screen.open(device)
        presenter = GpuPresenter(viewer.renderer.threads, device)
        viewer.presenter.close()
        viewer.presenter = presenter


def in_browser(session: Session, host: str = "127.0.0.1", port: int = 0, open_browser: bool = False,
               on_ready: Callable[[str], object] = print) -> None:
    """Serve a scene as a web page until Ctrl-C; whoever comes first steers, others watch.

    Parameters
    ----------
    session : Session
    host : str
        Address to listen on. Others than this machine's own ask for a token, which is part of the page's address.
    port : int
        0: any that is free.
    open_browser : bool
    on_ready : function
        Is told the page's address once it can be opened.
    """
    web, server = (need(f"glimt.viewer.{name}", "web") for name in ("web.canvas", "web.server"))
    keys = [{"keys": keys, "help": help, "group": group} for group, keys, help in help_table()]
    canvas = web.WebCanvas(title=session.title, max_fps=session.max_fps, keys=keys, size=session.window_size)
    viewer = session.viewer(_PageHost(canvas, web.loop.call_soon_threadsafe))
    session.run(canvas, viewer, lambda: server.serve(canvas, host, port, None, open_browser, on_ready))


class _PageHost(CanvasHost):
    """Gives files to the browser instead of the server's disk: whoever steers may be anywhere."""

    def keep(self, folder: Path, files: dict[str, bytes]) -> str:
        """Have the browser download the files."""
        del folder
        for name, data in files.items():
            self._call_soon(self._canvas.offer_file, name, data, "image/png" if name.endswith("png") else "text/plain")
        return f"{next(iter(files))}, by the browser"


def in_terminal(session: Session) -> None:
    """Show a scene as coloured characters until Ctrl-C: good for a look over SSH."""
    if not (sys.stdout.isatty() and sys.stdin.isatty()):
        raise GlimtError("standard input and output are no terminal; use --web for a page in a browser")
    terminal = need("glimt.viewer.terminal", "terminal")
    overlay = TextOverlay()
    canvas = terminal.TerminalCanvas(overlay, title=session.title, max_fps=min(session.max_fps, 30.0))
    viewer = session.viewer(CanvasHost(canvas, terminal.loop.call_soon_threadsafe))
    viewer.presenter.overlay = overlay
    session.run(canvas, viewer, terminal.run)
