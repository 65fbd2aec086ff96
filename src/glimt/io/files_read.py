"""Which files a load has read: for whoever wants to know when one of them changes."""

import contextlib
from collections.abc import Iterator
from contextvars import ContextVar
from pathlib import Path

_FILES: ContextVar[set[Path] | None] = ContextVar("files_read", default=None)


@contextlib.contextmanager
def recorded() -> Iterator[set[Path]]:
    """Collect the absolute paths of files that are read meanwhile, also when reading ends with an error."""
    files: set[Path] = set()
    token = _FILES.set(files)
    try:
        yield files
    finally:
        _FILES.reset(token)


def note_read(path: Path) -> None:
    """Take note that a file is about to be read."""
    files = _FILES.get()
    if files is not None:
        files.add(path.absolute())
