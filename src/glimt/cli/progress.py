"""What a long render shows on stderr."""

import sys
import time
from types import TracebackType
from typing import Any, Self

_DELAY = 0.5
_INTERVAL = 0.1


class _Bar:
    """A bar on stderr, from when it is first shown to the end of the block."""

    def __init__(self) -> None:
        self._bar: Any = None
        self._shown = 0.0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        if self._bar is not None:
            self._bar.stop()

    def _show(self, text: str, share: float) -> None:
        """Show a text and a share, 0 to 1, unless that was done just now."""
        now = time.monotonic()
        if now - self._shown < _INTERVAL:
            return
        self._shown = now
        if self._bar is None:
            self._bar = _start_bar()
        self._bar.update(self._bar.task_ids[0], description=text, completed=share, refresh=True)


class ConsoleProgress(_Bar):
    """A progress callback that shows a bar, on a terminal and only once the work has taken half a second.

    That kernels are compiled is said in any case, once, so that nobody wonders about the first run.
    """

    def __init__(self) -> None:
        super().__init__()
        self._started = time.monotonic()
        self._told_of_compiling = False

    def __call__(self, stage: str, fraction: float) -> None:
        """Show that `fraction` (0 to 1) of `stage` is done."""
        if stage.startswith("compiling") and not self._told_of_compiling:
            self._told_of_compiling = True
            print(stage, file=sys.stderr, flush=True)
        if time.monotonic() - self._started >= _DELAY and sys.stderr.isatty():
            self._show(stage, fraction)


class TimeLeft(_Bar):
    """Shows how far a long measurement is and how much time is left, on a terminal; elsewhere a line for each part."""

    def __init__(self) -> None:
        super().__init__()
        self._last = ""

    def __call__(self, text: str, share: float, seconds: float) -> None:
        """Show that `share` (0 to 1) is done, `text` under way, and about so many seconds left."""
        line = f"{text}, about {_readable(seconds)} left"
        if sys.stderr.isatty():
            self._show(line, share)
        elif text != self._last:
            print(line, file=sys.stderr, flush=True)
        self._last = text


def _readable(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 100 else f"{seconds / 60:.0f} min"


def _start_bar() -> Any:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn
    # Refreshed by the callback: a thread of its own would take time from the kernels.
    bar = Progress(TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), console=Console(stderr=True),
                   transient=True, auto_refresh=False)
    bar.add_task("", total=1.0)
    bar.start()
    return bar
