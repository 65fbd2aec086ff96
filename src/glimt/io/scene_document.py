"""A TOML scene file as checked tables, and what its parts are called in messages."""

import contextlib
import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from glimt.errors import GlimtError
from glimt.io.files_read import note_read
from glimt.io.scene_schema import SceneTable, nearest
from glimt.io.toml_lines import Place, find_line

LARGEST_FILE = 8 * 2**20
"""Bytes of a scene file; what is larger belongs into an OBJ file, which is read much faster."""

# Reading a dotted key takes tomllib time that grows with the square of its parts.
_KEY_PART = r"""(?:"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+'|[\w-]++)[ \t]*+\.[ \t]*+"""
_ENDLESS_KEY = re.compile(rf"(?<![\w-])(?:{_KEY_PART}){{64}}")


class SceneDocument:
    """The tables of a scene file.

    Attributes
    ----------
    path : Path
        As it was given, for messages.
    tables : SceneTable
        Checked for keys and types; references and value ranges are not.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.text = _read_text(path)
        self._raw = self._parse()
        try:
            self.tables = SceneTable.model_validate(self._raw)
        except ValidationError as error:
            raise self._schema_error(error) from None

    def error(self, message: str, *place: str | int) -> GlimtError:
        """Return an error that names the file, the line and the key: ``room.toml:14: light[2].radius: message``."""
        place = self._existing(place)
        key = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in place).lstrip(".")
        return GlimtError(f"{self.path}:{find_line(self.text, place)}: {key}: {message}")

    @contextlib.contextmanager
    def blame(self, *place: str | int) -> Iterator[None]:
        """Re-raise the `GlimtError` of a reader or constructor as one of the table or key at `place`."""
        try:
            yield
        except GlimtError as error:
            # Constructors say "light 'lamp': radius is 0": the place says which light, and where the radius is.
            message = re.sub(r"^(?:camera|settings|orbit|path|\w+ (?:'.*?'|\".*?\")): ", "", str(error), count=1)
            field, _, rest = message.partition(" ")
            table = self._lookup(place)
            if isinstance(table, dict) and field in table:
                place += (field,)
                message = rest if rest.startswith(("is ", "has ")) else message
            raise self.error(message, *place) from None

    def _parse(self) -> dict[str, Any]:
        endless = _ENDLESS_KEY.search(self.text)
        if endless:
            before = self.text.count("\n", 0, endless.start())
            raise GlimtError(f"{self.path}:{before + 1}: a key of 64 parts or more")
        try:
            return tomllib.loads(self.text)
        except RecursionError:
            raise GlimtError(f"{self.path}: brackets are nested too deeply") from None
        except tomllib.TOMLDecodeError as error:
            message, _, position = str(error).rpartition(" (at ")
            found = re.search(r"line (\d+)", position)
            line = found[1] if found else str(self.text.count("\n") + 1)
            raise GlimtError(f"{self.path}:{line}: not valid TOML: {message} (at {position}") from None
        except ValueError:  # Python's own limit on the digits of an integer
            raise GlimtError(f"{self.path}: a number of more than 4300 digits") from None

    def _schema_error(self, error: ValidationError) -> GlimtError:
        first = error.errors(include_url=False)[0]
        context = first.get("ctx", {})
        place = first["loc"]
        if first["type"] == "unknown_key":
            place += (str(context["key"]),)
        elif first["type"].startswith("union_tag"):
            place += ("type",)
        return self.error(_explain(first, context), *place)

    def _existing(self, place: Place) -> Place:
        """Leave out of `place` what is not in the file: union tags, and the index of a list given as one element."""
        value: Any = self._raw
        kept: list[str | int] = []
        for number, part in enumerate(place):
            inside = part in value if isinstance(value, dict) else (
                isinstance(value, list) and isinstance(part, int) and part < len(value))
            if inside:
                value = value[part]
            if inside or (number == len(place) - 1 and isinstance(value, dict) and isinstance(part, str)):
                kept.append(part)
        return tuple(kept)

    def _lookup(self, place: Place) -> Any:
        value: Any = self._raw
        for part in self._existing(place):
            value = value[part]
        return value


def _read_text(path: Path) -> str:
    note_read(path)
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise GlimtError(f"{path}: larger than {LARGEST_FILE >> 20} MiB; put meshes into OBJ files")
        data = path.read_bytes()
    except OSError as error:
        raise GlimtError(f"{path}: cannot be read: {error.strerror}") from None
    if b"\0" in data:
        raise GlimtError(f"{path}: not a text file")
    try:
        return data.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise GlimtError(f"{path}:{line}: not UTF-8 text; save the file as UTF-8") from None


_EXPECTED = {
    "float_type": "a number", "int_type": "a whole number", "int_from_float": "a whole number",
    "string_type": "text", "bool_type": "true or false", "list_type": "a list", "model_type": "a table",
    "model_attributes_type": "a table", "dict_type": "a table",
}


def _explain(details: ErrorDetails, context: Mapping[str, Any]) -> str:
    """Return pydantic's error in the words of a TOML file."""
    kind, value = details["type"], details["input"]
    if kind == "missing":
        return "missing; it has no default"
    if kind == "list_type" and isinstance(value, dict) and len(details["loc"]) == 1:
        return f"write [[{details['loc'][0]}]] with two brackets, there can be several"
    if kind in _EXPECTED:
        return f"expected {_EXPECTED[kind]}, found {_describe(value)}"
    if kind in ("less_than_equal", "greater_than_equal"):
        return "is a huge number"
    if kind == "finite_number":
        return "is not a finite number"
    if kind in ("too_short", "too_long", "string_too_short", "string_too_long"):
        lo_hi = context.get("min_length", context.get("max_length"))
        bound = "at least" if kind.endswith("short") else "at most"
        return f"has {len(value)} entries, expected {bound} {lo_hi}"
    if kind == "literal_error":
        return f"is {_describe(value)}, expected {context['expected']}"
    if kind == "union_tag_not_found":
        return "missing, expected 'point', 'spot' or 'directional'"
    if kind == "union_tag_invalid":
        return f"is {context['tag']!r}" + nearest(str(context["tag"]), ("point", "spot", "directional"))
    return details["msg"]


def _describe(value: Any) -> str:
    if isinstance(value, str):
        return repr(value if len(value) <= 40 else value[:40] + "...")
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) or (isinstance(value, int) and abs(value) < 1e18):
        return str(value)
    names = {int: "a huge number", list: "a list", dict: "a table"}
    return names.get(type(value), f"a {type(value).__name__}")
