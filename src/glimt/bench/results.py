"""Results as JSON files, and against each other."""

import json
from pathlib import Path
from typing import Any, NamedTuple

from glimt.errors import GlimtError

Result = dict[str, Any]

AT_ONCE = "glimt, no clearances"
"""Name of the rate of rays that know nothing of the surface they leave, in a row of "rays"."""


class Kind(NamedTuple):
    """A benchmark: the version of its results, what tells their rows apart, and what `ratio` is."""

    version: int
    keys: tuple[str, ...]
    ratio: str


KINDS = {
    "rays": Kind(1, ("mesh", "kind", "threads"), "glimt's rate through Embree's best, higher is better"),
    "frames": Kind(1, ("row", "size", "threads"), "frame time through Embree's for just its rays, lower is better"),
    "growth": Kind(1, ("series", "count", "threads"), "frame time through that of the first setting in the series, "
                                                      "lower is better"),
    "flight": Kind(1, ("size", "bounces", "lights", "threads", "budget_ms"), "the frame time that 95 of 100 frames "
                   "keep within, through the budget, lower is better"),
}


def save(path: Path, result: Result) -> None:
    """Write a result."""
    try:
        path.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    except OSError as error:
        raise GlimtError(f"{path}: cannot be written: {error.strerror}") from None


def read(path: Path) -> Result:
    """Read a result that `save` wrote."""
    try:
        result = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise GlimtError(f"{path}: cannot be read as a result: {error}") from None
    kind = KINDS.get(str(result.get("benchmark"))) if isinstance(result, dict) else None
    if kind is None or result.get("version") != kind.version or not _has_rows(result, kind):
        raise GlimtError(f"{path}: is no result of `glimt bench`, or one of another version; measure again")
    return dict(result)


def _has_rows(result: Result, kind: Kind) -> bool:
    rows = result.get("rows")
    return isinstance(rows, list) and all(
        isinstance(row, dict) and row.keys() >= {*kind.keys, "ratio"} and isinstance(row["ratio"], int | float)
        and row["ratio"] > 0 for row in rows)


def compare(before: Result, after: Result) -> str:
    """Return a Markdown table of the rows both have: each ratio, and how it changed.

    Ratios are compared and not times or rates, since both halves of a ratio were measured in turn in one run.
    """
    if before["benchmark"] != after["benchmark"]:
        raise GlimtError(f"a result of `glimt bench {before['benchmark']}` cannot be compared with one of `glimt bench "
                         f"{after['benchmark']}`")
    kind = KINDS[after["benchmark"]]

    def key(row: Result) -> tuple[str, ...]:
        return tuple(str(row[name]) for name in kind.keys)

    old = {key(row): row["ratio"] for row in before["rows"]}
    lines = [f"| {' | '.join(kind.keys)} | ratio before | after | change |", "|---" * (len(kind.keys) + 3) + "|"]
    for row in after["rows"]:
        if key(row) in old:
            earlier, now = old[key(row)], row["ratio"]
            lines.append(f"| {' | '.join(key(row))} | {earlier:.2f} | {now:.2f} | {100 * (now / earlier - 1):+.0f} % |")
    if len(lines) == 2:
        raise GlimtError(f"the two results have no row in common ({', '.join(kind.keys)})")
    return "\n".join([*lines, "", f"Ratio: {kind.ratio}."])
