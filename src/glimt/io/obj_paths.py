"""Where the files are that an OBJ or MTL file names.

A file from somewhere else must not make glimt open whatever it likes: a reference stays within the folder above the
one its file lies in (so that ``../textures/brick.png`` works). One that leads elsewhere, and an absolute path is
usually the exporter's own, is looked for by its base name beside the file.
"""

import os
import unicodedata
from pathlib import Path


class FileFinder:
    """Finds referenced files; lists each folder at most once."""

    def __init__(self) -> None:
        self._listings: dict[str, dict[str, str]] = {}

    def find(self, reference: str, folder: Path, beside: bool = True) -> Path | None:
        """Return the regular file that `reference`, written in a file in `folder`, means; None where there is none.

        Either slash separates folders; where the exact name does not exist, upper and lower case do not matter.
        `beside` says whether the base name is looked for in `folder`.
        """
        reference = reference.strip().strip('"').replace("\\", "/")
        if not reference or "\0" in reference:
            return None
        base = os.path.abspath(folder)
        wanted = os.path.normpath(os.path.join(base, reference))
        root = os.path.dirname(base)
        if wanted.startswith(os.path.join(root, "")):
            found = self._existing(root, os.path.relpath(wanted, root))
            if found is not None:
                return found
        return self._existing(base, reference.rsplit("/", 1)[-1]) if beside else None

    def _existing(self, root: str, relative: str) -> Path | None:
        """Return the file at `relative` below `root`, each part in any case where the exact one is missing."""
        path = root
        for part in relative.split(os.sep):
            exact = os.path.join(path, part)
            path = exact if os.path.exists(exact) else os.path.join(path, self._listing(path).get(_fold(part), part))
        return Path(path) if os.path.isfile(path) else None

    def _listing(self, folder: str) -> dict[str, str]:
        if folder not in self._listings:
            try:
                names = sorted(os.listdir(folder))
            except (OSError, ValueError):
                names = []
            self._listings[folder] = {_fold(name): name for name in names}
        return self._listings[folder]


def _fold(name: str) -> str:
    return unicodedata.normalize("NFC", name).casefold()
