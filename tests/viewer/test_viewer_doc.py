"""The guide lists the keys of the table."""

from pathlib import Path

from glimt.viewer.keys import help_table

GUIDE = Path(__file__).resolve().parents[2] / "docs" / "viewer.md"


def key_table() -> str:
    """Return the keys as the guide has them."""
    lines = ["| | keys | |", "|---|---|---|"]
    shown = ""
    for group, keys, help in help_table():
        lines.append(f"| {group if group != shown else ''} | {keys} | {help} |")
        shown = group
    return "\n".join(lines)


def test_the_guide_lists_every_key():
    text = GUIDE.read_text(encoding="utf-8")
    between = text.partition("<!-- keys -->")[2].partition("<!-- /keys -->")[0]
    assert between.strip() == key_table(), f"docs/viewer.md should say:\n{key_table()}"
