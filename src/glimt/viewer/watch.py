"""Loads a scene again when one of its files changes."""

import threading
import time
from collections.abc import Callable
from pathlib import Path

from glimt.errors import GlimtError
from glimt.io import load
from glimt.io.files_read import recorded
from glimt.scene.scene import Scene

POLL_SECONDS = 0.15
"""How often the files' times are looked at: works on every file system, network folders included."""

State = dict[Path, tuple[int, int] | None]


class Watcher:
    """Watches the files of a scene from a thread.

    Parameters
    ----------
    path : Path
        Scene file.
    files : set of Path
        What the last load has read.
    on_scene, on_error : functions
        Are called in the watcher's thread, with the new scene or with the text of what is wrong with it.
    """

    def __init__(self, path: Path, files: set[Path], on_scene: Callable[[Scene], None],
                 on_error: Callable[[str], None]) -> None:
        self._path, self._files = path, files | {path.absolute()}
        self._on_scene, self._on_error = on_scene, on_error
        self._stopping = threading.Event()
        self._seen = _state(self._files)
        self._thread = threading.Thread(target=self._run, name="glimt-watch", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End, and wait for the end."""
        self._stopping.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._stopping.wait(POLL_SECONDS):
            now = _state(self._files)
            if now != self._seen:
                self._settle(now)
                self._load()

    def _settle(self, now: State) -> None:
        """Wait until nothing has changed for one poll: editors and exporters write in several steps."""
        while not self._stopping.wait(POLL_SECONDS):
            before, now = now, _state(self._files)
            if before == now:
                break
        self._seen = now

    def _load(self) -> None:
        start = time.time_ns()
        with recorded() as files:
            try:
                scene = load(self._path)
            except GlimtError as error:
                self._on_error(str(error))
            except Exception as error:  # the watch goes on, whatever a half-written file does to a reader
                self._on_error(f"{self._path}: {type(error).__name__}: {error}")
            else:
                self._files = {self._path.absolute()}  # what it no longer names is of no interest
                self._on_scene(scene)
        self._files |= files
        now = _state(self._files)
        for path in now.keys() - self._seen.keys():
            state = now[path]  # a file that changed while it was read counts as changed once more
            self._seen[path] = None if state and state[0] >= start else state
        self._seen = {path: self._seen[path] for path in self._files}


def _state(files: set[Path]) -> State:
    """Return time of change and size of each file; None for one that is not there."""
    found: State = {}
    for path in files:
        try:
            status = path.stat()
            found[path] = status.st_mtime_ns, status.st_size
        except OSError:
            found[path] = None
    return found
