"""A scene looked at in one place, from start to end: canvas, viewer, thread, and the watch over its files."""

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from glimt.engines import Progress
from glimt.scene.scene import Scene
from glimt.viewer.canvas import connect
from glimt.viewer.governor import DEFAULT_BUDGET
from glimt.viewer.screenshot import keep_in
from glimt.viewer.viewer import Host, Viewer
from glimt.viewer.watch import Watcher


@dataclass
class Session:
    """What is looked at, and how.

    Parameters
    ----------
    scene : Scene
    size : (width, height), optional
        Of the window in logical pixels; None: as the scene says.
    budget : float
        Seconds a frame may take while anything moves.
    max_fps : float
        Frames a second, at most.
    threads, progress
        As for `Renderer`.
    files : set of Path, optional
        What the scene was read from; the scene is loaded again when one changes.
    path : Path, optional
        Where from.
    folder : Path
        Where pictures are saved.
    engine : str
        As for `Renderer`.
    """

    scene: Scene
    size: tuple[int, int] | None = None
    budget: float = DEFAULT_BUDGET
    max_fps: float = 120.0
    threads: int | None = None
    progress: Progress | None = None
    path: Path | None = None
    files: set[Path] | None = None
    folder: Path = Path()
    engine: str = "auto"

    @property
    def title(self) -> str:
        """Of the window or page."""
        return f"glimt — {self.scene.name}"

    @property
    def window_size(self) -> tuple[int, int]:
        """Size to open a window with."""
        return self.size or (self.scene.settings.width, self.scene.settings.height)

    def viewer(self, host: Host | None = None) -> Viewer:
        """Return a viewer of the scene; the first on a machine takes its time to compile the kernels."""
        viewer = Viewer(self.scene, budget=self.budget, threads=self.threads, engine=self.engine,
                        progress=self.progress, host=host)
        viewer.folder = self.folder
        return viewer

    def run(self, canvas: Any, viewer: Viewer, run_loop: Callable[[], None]) -> None:
        """Show the viewer on a canvas until the canvas' loop ends; raise what the rendering thread failed with."""
        with ExitStack() as cleanup:
            thread = connect(canvas, viewer, ahead=1)
            cleanup.callback(thread.stop)
            if self.path is not None and self.files is not None:
                watcher = Watcher(self.path, self.files, lambda scene: thread.do(lambda: viewer.replace_scene(scene)),
                                  lambda error: thread.do(lambda: viewer.fail(error)))
                cleanup.callback(watcher.stop)
            run_loop()
        if thread.error is not None:
            raise thread.error


class CanvasHost:
    """A host whose canvas may be told things in its own thread only.

    Parameters
    ----------
    canvas : canvas of rendercanvas
        With `set_pointer_captured`, `set_fullscreen` and `is_fullscreen`, or without.
    call_soon : function
        Has a function called in the canvas' thread.
    """

    def __init__(self, canvas: Any, call_soon: Callable[..., None]) -> None:
        self._canvas, self._call_soon = canvas, call_soon

    @property
    def is_fullscreen(self) -> bool:
        """Whether the canvas fills the screen, as it last knew."""
        return bool(getattr(self._canvas, "is_fullscreen", False))

    def set_pointer_captured(self, captured: bool) -> None:
        """Hide the pointer, or give it back."""
        self._ask("set_pointer_captured", captured)

    def set_fullscreen(self, fullscreen: bool) -> None:
        """Fill the screen, or no longer."""
        self._ask("set_fullscreen", fullscreen)

    def keep(self, folder: Path, files: dict[str, bytes]) -> str:
        """Write files into the folder."""
        return keep_in(folder, files)

    def _ask(self, method: str, value: bool) -> None:
        if hasattr(self._canvas, method):
            self._call_soon(getattr(self._canvas, method), value)
