"""Files to objects and images to files."""

from os import PathLike, fspath
from pathlib import Path

from glimt.errors import GlimtError
from glimt.scene.scene import Scene


def load(path: str | PathLike[str]) -> Scene:
    """Read a scene from a `.toml` scene file, or from a bare `.obj` that is framed and lit for you.

    Raises
    ------
    GlimtError
        Naming file, line and key: what cannot be read or makes no sense.

    Warns
    -----
    GlimtWarning
        Once for each kind of thing that was dropped or replaced, with its count.
    """
    path = Path(fspath(path))
    suffix = path.suffix.lower()
    if suffix not in (".toml", ".obj"):
        raise GlimtError(f"{path}: cannot load {suffix or 'a file without an extension'}; "
                         "glimt loads scene files (.toml) and meshes (.obj)")
    try:
        if not path.is_file():
            raise GlimtError(f"{path}: {'not a regular file' if path.exists() else 'no such file'}")
    except (OSError, ValueError):  # a NUL in the name, a folder that may not be entered
        raise GlimtError(f"{str(path)!r}: not a file that can be opened") from None
    # Imported late: pydantic, Pillow and Numba take longer to import than all the rest.
    if suffix == ".toml":
        from glimt.io.scene_file import read_scene
        return read_scene(path)
    from glimt.io.bare_mesh import read_bare_mesh
    return read_bare_mesh(path)
