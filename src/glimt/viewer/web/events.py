"""What a browser may say: JSON in, events of rendercanvas out, nothing else.

Every field is checked and copied into a new dict, so that no handler meets a missing key, a NaN or a megabyte.
"""

import json
import math
from typing import Any

Event = dict[str, Any]

MAX_PIXELS = 4096 * 4096
MAX_SIDE = 16384

_MODIFIERS = ("Alt", "Control", "Meta", "Shift")
_POINTER_EVENTS = {"pointer_down", "pointer_up", "pointer_move", "pointer_enter", "pointer_leave", "double_click"}
_KEY_EVENTS = {"key_down", "key_up"}
_MAX_COORDINATE = 1e9  # a captured pointer moves without bound
_MAX_KEY_LENGTH = 32
_MAX_HELD = 64  # keys; nobody has more fingers


def parse_message(text: str) -> Event:
    """Return the JSON object in `text`, with its "type"; an empty dict for anything else."""
    try:
        message = json.loads(text, parse_constant=_refuse)
    except (ValueError, RecursionError):
        return {}
    return message if isinstance(message, dict) and isinstance(message.get("type"), str) else {}


def parse_event(message: Event) -> Event | None:
    """Return the pointer, wheel or key event of rendercanvas that `message` describes, or None if it is none.

    Coordinates are logical pixels from the canvas's upper left corner; time stamps are left to the server's clock.
    """
    kind = message.get("type")
    event: Event = {"event_type": kind, "modifiers": _chosen(_MODIFIERS, message.get("modifiers"))}
    if kind in _KEY_EVENTS:
        key = message.get("key")
        if not isinstance(key, str) or not 0 < len(key) <= _MAX_KEY_LENGTH or not key.isprintable():
            return None
        return {**event, "key": key}
    if kind not in _POINTER_EVENTS and kind != "wheel":
        return None
    numbers = {name: parse_number(message.get(name), _MAX_COORDINATE)
               for name in (("x", "y", "dx", "dy") if kind == "wheel" else ("x", "y"))}
    if None in numbers.values():
        return None
    event |= numbers
    event["buttons"] = _chosen((1, 2, 3, 4, 5), message.get("buttons"))
    if kind != "wheel":
        button = message.get("button")
        event |= {"button": button if type(button) is int and 0 <= button <= 5 else 0, "ntouches": 0, "touches": {}}
    return event


def parse_size(message: Event) -> tuple[int, int, float] | None:
    """Return a canvas's width and height in physical pixels, and how many of them make a logical one; None if none.

    What has more than `MAX_PIXELS` is made smaller, with the same logical size.
    """
    width, height = (parse_number(message.get(name), 1e6) for name in ("pwidth", "pheight"))
    ratio = parse_number(message.get("ratio"), 64)
    if width is None or height is None or ratio is None or min(width, height) < 1 or ratio < 1 / 64:
        return None
    scale = min(1.0, MAX_SIDE / max(width, height), math.sqrt(MAX_PIXELS / (width * height)))
    return max(1, int(width * scale)), max(1, int(height * scale)), ratio * scale


class Held:
    """The keys and buttons that are down, as far as events have told."""

    def __init__(self) -> None:
        self._keys: dict[str, None] = {}  # in the order they were pressed
        self._pointer: Event | None = None  # the last event with a button down

    def note(self, event: Event) -> None:
        """Follow what `event` presses or lets go."""
        kind = event["event_type"]
        if kind == "key_down" and len(self._keys) < _MAX_HELD:
            self._keys[event["key"]] = None
        elif kind == "key_up":
            self._keys.pop(event["key"], None)
        elif kind in _POINTER_EVENTS:
            self._pointer = event if event["buttons"] else None

    def release(self) -> list[Event]:
        """Return the events of letting go of everything, and forget it."""
        events = [{"event_type": "key_up", "key": key, "modifiers": ()} for key in self._keys]
        if self._pointer:
            for button in self._pointer["buttons"]:
                events.append({**self._pointer, "event_type": "pointer_up", "button": button, "buttons": ()})
        self._keys, self._pointer = {}, None
        return events


def parse_number(value: object, limit: float) -> float | None:
    """Return `value` as a float if it is a number of at most `limit` in size, else None."""
    return float(value) if type(value) in (int, float) and -limit <= value <= limit else None  # type: ignore


def _chosen(allowed: tuple[Any, ...], given: object) -> tuple[Any, ...]:
    return tuple(item for item in allowed if item in given) if isinstance(given, list) else ()


def _refuse(constant: str) -> None:
    raise ValueError(f"{constant} is not JSON")
