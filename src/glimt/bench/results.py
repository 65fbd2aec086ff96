"""Results as JSON files, as tables, and against each other."""

import json
from pathlib import Path
from typing import Any

from glimt.errors import GlimtError

Result = dict[str, Any]
_KEYS = ("mesh", "kind", "threads")


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
    if not isinstance(result, dict) or result.get("benchmark") != "rays" or result.get("version") != 1:
        raise GlimtError(f"{path}: is no result of `glimt bench rays`, or one of another version; measure again")
    return result


def table(result: Result) -> str:
    """Return a Markdown table, with the machine under it."""
    lines = ["| mesh | rays | threads | glimt, Mrays/s | Embree's best | ratio | differing per million |",
             "|---|---|---|---|---|---|---|"]
    for row in result["rows"]:
        lines.append(f"| {row['mesh']} {row['triangles']:,} | {row['kind']} | {row['threads']} | "
                     f"{row['mrays']['glimt']:.1f} | {row['mrays'][row['best']]:.1f} ({row['best']}) | "
                     f"{row['ratio']:.2f} | {row['differing']:.1f} |")
    machine = result["machine"]
    lines.append("")
    lines.append(f"{machine['processor']} ({', '.join(machine['features'])}), {machine['lanes']} lanes, "
                 f"{machine['cores']} cores; Python {machine['python']}, Numba {machine['numba']}, "
                 f"glimt {machine['glimt']}.")
    return "\n".join(lines)


def compare(before: Result, after: Result) -> str:
    """Return a Markdown table of the rows both have: each ratio to Embree, and how it changed.

    Ratios are compared and not rates, since each was measured against the same yardstick in its own run.
    """
    old = {tuple(row[key] for key in _KEYS): row for row in before["rows"]}
    lines = ["| mesh | rays | threads | ratio before | after | change |", "|---|---|---|---|---|---|"]
    for row in after["rows"]:
        earlier = old.get(tuple(row[key] for key in _KEYS))
        if earlier:
            lines.append(f"| {row['mesh']} | {row['kind']} | {row['threads']} | {earlier['ratio']:.2f} | "
                         f"{row['ratio']:.2f} | {100 * (row['ratio'] / earlier['ratio'] - 1):+.0f} % |")
    if len(lines) == 2:
        raise GlimtError("the two results have no row in common (mesh, kind of rays, threads)")
    return "\n".join(lines)
