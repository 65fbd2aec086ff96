"""The one table of keys: what is pressed, what it does, and what the help says."""

from dataclasses import dataclass
from typing import Any

Event = dict[str, Any]
"""An event as rendercanvas describes it: "event_type", "key", "modifiers", "x", "y" and so on."""


@dataclass(frozen=True)
class Key:
    """One line of the help.

    Parameters
    ----------
    keys : tuple of str
        Names as browsers have them, letters in lower case; "Shift+l" and the like. Any of them will do.
    action : str
        For a key that is held, what moves ("forward"); else the name of what is done.
    help : str
    group : str
    held : bool
        Whether it acts as long as it is down.
    label : str
        How the help writes the keys, where their names would not do.
    """

    keys: tuple[str, ...]
    action: str
    help: str
    group: str
    held: bool = False
    label: str = ""

    def __str__(self) -> str:
        return self.label or " ".join(_display(name) for name in self.keys)


def _held(keys: str, action: str, help: str, label: str = "") -> Key:
    return Key(tuple(keys.split()), action, help, "Move", True, label)


KEYS = (
    _held("w ArrowUp", "forward", "forward", "W ↑"),
    _held("s ArrowDown", "back", "back", "S ↓"),
    _held("a ArrowLeft", "left", "left", "A ←"),
    _held("d ArrowRight", "right", "right", "D →"),
    _held("e Space", "up", "up"),
    _held("q Shift", "down", "down"),
    Key(("+", "="), "faster", "move faster", "Move", label="+"),
    Key(("-", "_"), "slower", "move slower", "Move", label="-"),
    Key(("m",), "mouse_look", "mouse look on or off (Esc: off)", "Look"),
    Key(("Escape",), "release", "mouse look off, help off", "Look", label="Esc"),
    Key(("o",), "orbit", "orbit around what is in the middle, or fly", "Look"),
    Key(("f",), "frame_all", "show everything", "Look"),
    Key(("Shift+f",), "frame_picked", "show the picked object", "Look"),
    Key(("r",), "reset", "back to the first view", "Look"),
    Key(("z",), "narrower", "narrower field of view", "Look"),
    Key(("Shift+z",), "wider", "wider field of view", "Look"),
    *(Key((str(n),), f"recall_{n}", "", "Look", label="") for n in range(2, 10)),
    Key(("1",), "recall_1", "go to a saved view", "Look", label="1-9"),
    Key(("v",), "save_view", "save the view: then press 1-9", "Look"),
    Key(("l",), "add_light", "add a light here; it orbits", "Light and rays"),
    Key(("Shift+l",), "remove_light", "remove the last light", "Light and rays"),
    Key(("t",), "toggle_time", "lights move or stand still", "Light and rays"),
    Key(("b",), "add_bounce", "one mirror bounce more", "Light and rays"),
    Key(("Shift+b",), "remove_bounce", "one mirror bounce less", "Light and rays"),
    Key(("n",), "samples", "samples a pixel: 1, 2×2, 3×3, adaptive", "Light and rays"),
    Key(("k",), "pause", "pause and go on", "Picture"),
    Key(("p",), "screenshot", "save a picture, 4×4 samples a pixel", "Picture"),
    Key(("i",), "overlay", "numbers, with a graph, or none", "Picture"),
    Key(("h", "?"), "help", "this help", "Picture", label="H"),
    Key(("F11", "u"), "fullscreen", "full screen", "Picture"),
    Key(("c",), "next_debug_view", "next of the views below", "Debug views"),
    Key(("F1",), "debug_picture", "the picture", "Debug views"),
    Key(("F2",), "debug_normals", "normals", "Debug views"),
    Key(("F3",), "debug_depth", "depth", "Debug views"),
    Key(("F4",), "debug_barycentrics", "barycentrics", "Debug views"),
    Key(("F6",), "debug_instances", "instances", "Debug views"),
    Key(("F7",), "debug_nodes", "nodes visited", "Debug views"),
    Key(("F8",), "debug_shadows", "shadows of each light", "Debug views"),
)
POINTER = (
    ("drag", "turn", "Mouse"), ("right drag", "slide", "Mouse"), ("wheel", "dolly", "Mouse"),
    ("click", "pick: object, material, triangle", "Mouse"), ("double click", "orbit around this point", "Mouse"),
)
"""What the mouse does, for the help: (what, help, group)."""


def help_table() -> list[tuple[str, str, str]]:
    """Return the lines of the help: (group, keys, help)."""
    rows = [(key.group, str(key), key.help) for key in KEYS if key.help]
    return rows + [(group, what, help) for what, help, group in POINTER]


def key_name(event: Event) -> str:
    """Return the name that the table has for an event's key: "Shift+l" for an "L"."""
    name = str(event.get("key", ""))
    shift = "Shift" in event.get("modifiers", ())
    name = "Space" if name == " " else "?" if shift and name == "/" else name  # windows name the key, not its sign
    if len(name) == 1 and name.isalpha():
        return "Shift+" + name.lower() if shift or name.isupper() else name
    return name


def action_of(event: Event) -> Key | None:
    """Return what a key event stands for; keys pressed together with Ctrl, Alt or Meta are left to others."""
    if {"Control", "Alt", "Meta"} & set(event.get("modifiers", ())):
        return None
    name = key_name(event)
    found = _BY_NAME.get(name)
    if found is None and name.startswith("Shift+"):  # walking while Shift is held
        plain = _BY_NAME.get(name.removeprefix("Shift+"))
        found = plain if plain and plain.held else None
    return found


def _display(name: str) -> str:
    shift, _, key = name.rpartition("+")
    return f"{shift} {key.upper()}".strip() if len(key) == 1 else name


_BY_NAME = {name: key for key in KEYS for name in key.keys}
assert len(_BY_NAME) == sum(len(key.keys) for key in KEYS), "two lines of the table share a key"
