"""Example scenes that come with glimt."""

from pathlib import Path

from glimt.errors import GlimtError

_PACKAGE = Path(__file__).resolve().parents[1]
_FOLDERS = (_PACKAGE / "examples", _PACKAGE.parents[1] / "examples")
"""Where the wheel puts them, and where they are in a checkout."""


def example_path(name: str) -> Path:
    """Return the scene file of an example that the package holds.

    Raises
    ------
    GlimtError
        When this installation has no such file.
    """
    for folder in _FOLDERS:
        if (folder / name).is_file():
            return folder / name
    raise GlimtError(f"the example {name} is not part of this installation; name a scene file")
