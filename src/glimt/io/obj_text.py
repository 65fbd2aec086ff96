"""The text of an OBJ file as arrays; every error names its line."""

import os
import re
import stat
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from glimt.errors import GlimtError, WarningCounter
from glimt.io import obj_parser
from glimt.io.files_read import note_read
from glimt.scene import checks

LARGEST_FILE = 4 * 2**30

_CURVES = {"vp", "cstype", "deg", "bmat", "step", "curv", "curv2", "surf", "parm", "trim", "hole", "scrv", "sp", "end",
           "con", "bzp", "bsp", "cdc", "cdp", "res"}
_DISPLAY = {"mg", "bevel", "c_interp", "d_interp", "lod", "shadow_o", "trace_ob", "ctech", "stech", "usemap", "maplib"}
_NOT_READ = {"l": "lines are not drawn", "p": "points are not drawn",
             "call": "other files are not called", "csh": "commands are not run"}
_KINDS = ("vertex", "texture coordinate", "normal")


class Name(NamedTuple):
    """A `usemtl` or `mtllib` statement: what follows the word, comment included."""

    line: int
    text: str


class ObjText(NamedTuple):
    """What an OBJ file says, indices from 0.

    positions, texcoords, normals : (n, 3), (n, 2), (n, 3) float32
        As written: texcoords have their origin at the bottom left; a normal may be zero, infinite or NaN.
    corners : (n, 3) int32
        Indices of position, texcoord, normal; -1 for none.
    starts : (faces + 1,) int64
        Face i has the corners from starts[i] up to starts[i + 1], at least 3.
    lines, groups : (faces,) int64
        Where a face stands and its smoothing group, 0 for off.
    uses : (faces,) int64
        Index into `materials` of the `usemtl` in force, -1 before the first.
    materials, libraries : list of Name
    smoothing : bool
        Whether there is any `s` statement.
    """

    positions: NDArray[np.float32]
    texcoords: NDArray[np.float32]
    normals: NDArray[np.float32]
    corners: NDArray[np.int32]
    starts: NDArray[np.int64]
    lines: NDArray[np.int64]
    groups: NDArray[np.int64]
    uses: NDArray[np.int64]
    materials: list[Name]
    libraries: list[Name]
    smoothing: bool


def read_bytes(path: Path) -> NDArray[np.uint8]:
    """Return the bytes of a regular file of at most 4 GiB, or raise a `GlimtError` that says why not."""
    note_read(path)
    try:
        status = os.stat(path)
        if stat.S_ISDIR(status.st_mode):
            raise GlimtError(f"{path}: is a folder; name the .obj file in it")
        if not stat.S_ISREG(status.st_mode):
            raise GlimtError(f"{path}: is not a regular file")
        if status.st_size > LARGEST_FILE:
            raise GlimtError(f"{path}: {status.st_size / 2**30:.1f} GiB is more than the 4 GiB that are read; split it")
        return np.fromfile(path, np.uint8)
    except FileNotFoundError:
        raise GlimtError(f"{path}: no such file") from None
    except (OSError, ValueError) as error:
        raise GlimtError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None


def parse_text(data: NDArray[np.uint8], path: Path, warnings: WarningCounter) -> ObjText:
    """Parse the bytes of an OBJ file (they are changed where a line is continued)."""
    _prepare(data, path)
    counts = np.zeros(6, np.int64)
    obj_parser.count(data, counts)
    vertices, texcoords, normals, faces, corners, names = counts.tolist()
    text_positions = np.empty((vertices, 3), np.float32)
    text_texcoords = np.empty((texcoords, 2), np.float32)
    text_normals = np.empty((normals, 3), np.float32)
    text_corners = np.empty((corners, 3), np.int32)
    rows = np.empty((faces + 1, 4), np.int64)
    named = np.empty((names, 4), np.int64)
    others = np.zeros((16, 3), np.int64)
    notes = np.zeros((obj_parser.NOTES, 2), np.int64)
    error, line, word, place, kept = obj_parser.parse(
        data, counts[:3], np.zeros(3, np.int64), text_positions, text_texcoords, text_normals, text_corners, rows,
        named, others, notes, checks.LARGEST)
    if error != obj_parser.OK:
        totals = (vertices, texcoords, normals)
        raise GlimtError(f"{path}:{line}: {_explain(error, _name(word), data, place, totals)}")
    _warn(path, others, notes, warnings)
    is_use = named[:, 0] == obj_parser.USEMTL
    uses = np.concatenate([[0], np.cumsum(is_use)])[rows[:kept, 3]] - 1
    text_corners = text_corners[:rows[kept, 0]]  # faces that were left out had been counted
    return ObjText(text_positions, text_texcoords, text_normals, text_corners, rows[:kept + 1, 0], rows[:kept, 1],
                   rows[:kept, 2], uses, _names(data, named[is_use]), _names(data, named[~is_use]),
                   bool(notes[obj_parser.SMOOTHING, 0]))


def decode(text: bytes) -> str:
    """Return text that is UTF-8 or, where it is not, Latin-1."""
    try:
        return text.decode("utf-8")
    except UnicodeDecodeError:
        return text.decode("latin-1")


def without_comment(text: str) -> str:
    """Return a name without what may be a comment after it; names may hold a # of their own, so look for both."""
    return text.split(" #")[0].strip()


def _prepare(data: NDArray[np.uint8], path: Path) -> None:
    """Blank a byte-order mark, and turn continued line ends into `CONTINUED`."""
    mark = data[:3].tobytes()
    if mark[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise GlimtError(f"{path}:1: is UTF-16 text; save it as UTF-8")
    if mark == b"\xef\xbb\xbf":
        data[:3] = ord(" ")
    data[data == obj_parser.CONTINUED] = ord(" ")
    slashes = np.flatnonzero(data[:-1] == ord("\\"))
    ends = slashes[(data[slashes + 1] == ord("\n")) | (data[slashes + 1] == ord("\r"))]
    data[ends] = ord(" ")
    pairs = ends[ends + 2 < len(data)]
    pairs = pairs[(data[pairs + 1] == ord("\r")) & (data[pairs + 2] == ord("\n"))]
    data[pairs + 2] = ord(" ")
    data[ends + 1] = obj_parser.CONTINUED


def _name(word: int) -> str:
    return decode((word & (2**64 - 1)).to_bytes(8, "little").rstrip(b"\0"))


def _names(data: NDArray[np.uint8], rows: NDArray[np.int64]) -> list[Name]:
    return [Name(line, decode(data[begin:end].tobytes()).replace("\v", " ").strip())
            for _, line, begin, end in rows.tolist()]


def _explain(error: int, word: str, data: NDArray[np.uint8], place: int, totals: tuple[int, int, int]) -> str:
    """Return what is wrong at data[place] in a statement `word`."""
    token = decode(re.split(rb"[\s#]", data[place:place + 40].tobytes(), maxsplit=1)[0])
    if error == obj_parser.BAD_NUMBER:
        return f"{token!r} is not a number; numbers look like 1.5 or -2e-3"
    if error == obj_parser.TOO_LARGE:
        return f"{token!r} is not finite or beyond {checks.LARGEST:g}; scale the mesh down"
    if error == obj_parser.TOO_FEW:
        return f"'{word}' has too few numbers; it takes {1 if word == 'vt' else 3}"
    if error == obj_parser.INDEX_ZERO:
        return "face refers to item 0; OBJ counts from 1, or back from -1"
    if error == obj_parser.TOO_MANY_CORNERS:
        return f"face has more than {obj_parser.MAX_CORNERS} corners; split it"
    if error == obj_parser.OUT_OF_RANGE:
        part = re.split(rb"\s", data[max(place - 40, 0):place].tobytes())[-1].count(b"/")
        index = token.split("/")[0]
        if index.startswith("-"):
            return f"face refers to {_KINDS[part]} {index}, which is before the first one"
        return f"face refers to {_KINDS[part]} {index} of {totals[part]}"
    return f"{token!r} is no corner of a face; they look like 1, 1/2, 1//3 or 1/2/3"


def _warn(path: Path, others: NDArray[np.int64], notes: NDArray[np.int64], warnings: WarningCounter) -> None:
    """Count what the parser has noted."""
    for kind, message in (
            (obj_parser.COLORS, "vertex colours are ignored"),
            (obj_parser.FEW_CORNERS, "a face with fewer than three corners is left out"),
            (obj_parser.MISSING_NORMAL, "a face refers to a normal that the file does not have; it is computed"),
            (obj_parser.BAD_SMOOTHING, "a smoothing group that is no number is taken for 'off'")):
        count, line = notes[kind].tolist()
        if count:
            warnings.add(message, f"{path}:{line}", count)
    for word, count, line in others.tolist():
        name = _name(word)
        if count and name not in _DISPLAY:
            warnings.add(_not_read(name), f"{path}:{line}", count)


def _not_read(name: str) -> str:
    if name in _CURVES:
        return "curves and surfaces are not drawn; export them as faces"
    if not name:
        return "more statements are not part of OBJ; they are ignored"
    return _NOT_READ.get(name, f"statement {name!r} is not part of OBJ; it is ignored")
