"""The line on which a key of a TOML document stands: `tomllib` does not tell, and messages name it."""

import itertools
import re
import tomllib
from collections.abc import Iterator

Place = tuple[str | int, ...]
"""Keys and list indices that lead to a value: ``("light", 2, "radius")``."""

_TOKEN = re.compile(
    r"""\#[^\n]*
    | \"{3}(?:\\.|[^\\])*?\"{3,5} | '{3}.*?'{3,5} | "(?:\\.|[^"\\\n])*" | '[^'\n]*'
    | \n | [\[\]{}=,] | [^\s\[\]{}=,\#"']+""", re.VERBOSE | re.DOTALL)


def find_line(text: str, place: Place) -> int:
    """Return the line, from 1, of the longest part of `place` that the valid TOML document `text` spells out."""
    scan = _Scan(text, place)
    scan.document()
    return scan.best_line


class _Scan:
    """Walks the tokens of a document once and remembers the line of the longest prefix of the place looked for."""

    def __init__(self, text: str, wanted: Place) -> None:
        self.wanted = wanted
        self.best: Place = ()
        self.best_line = 1
        self.line = 1  # of self.token, the first one not yet read
        self.tokens = self._tokens(text)
        self.token = next(self.tokens)

    def _tokens(self, text: str) -> Iterator[str]:
        for match in _TOKEN.finditer(text):
            token = match[0]
            if token[0] != "#":
                yield token
            self.line += token.count("\n")
        yield from itertools.repeat("")  # the end, as often as it is asked for

    def _next(self) -> str:
        token, self.token = self.token, next(self.tokens)
        return token

    def _found(self, place: Place) -> None:
        if len(place) > len(self.best) and place == self.wanted[:len(place)]:
            self.best, self.best_line = place, self.line
            if place == self.wanted:
                self.tokens = itertools.repeat("")  # nothing better will come

    def document(self) -> None:
        table: Place = ()
        last: dict[Place, int] = {}  # index of the newest element of each array of tables
        while self.token:
            if self.token == "\n":
                self._next()
            elif self.token == "[":
                table = self._header(last)
            else:
                self._key_and_value(table)

    def _header(self, last: dict[Place, int]) -> Place:
        self._next()
        element = self.token == "["
        if element:
            self._next()
        place: Place = ()
        parts = self._key("]")
        for number, part in enumerate(parts):
            place += (part,)
            if element and number == len(parts) - 1:
                last[place] = last.get(place, -1) + 1
            if place in last:
                place += (last[place],)
            self._found(place)
        for _ in range(1 + element):
            self._next()
        return place

    def _key(self, end: str) -> list[str]:
        """Read a key, dotted or quoted, up to `end`."""
        parts: list[str] = []
        while self.token not in (end, ""):
            token = self._next()
            parts += [tomllib.loads(f"key={token}")["key"]] if token[0] in "\"'" else filter(None, token.split("."))
        return parts

    def _key_and_value(self, table: Place) -> None:
        place = table
        for part in self._key("="):
            place += (part,)
            self._found(place)
        self._next()
        self._value(place)

    def _value(self, place: Place) -> None:
        opening = self._next()
        if opening == "{":
            while self.token not in ("}", ""):
                if self.token in (",", "\n"):
                    self._next()
                else:
                    self._key_and_value(place)
            self._next()
        elif opening == "[":
            index = 0
            while self.token not in ("]", ""):
                if self.token in (",", "\n"):
                    index += self._next() == ","
                else:
                    self._found((*place, index))
                    self._value((*place, index))
            self._next()
        else:
            while self.token not in ("\n", ",", "]", "}", ""):  # a date may have a space
                self._next()
