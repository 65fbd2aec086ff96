"""What a terminal tells of keys and mouse, as events of rendercanvas."""

import re
from typing import Any

from glimt.viewer.keys import Event

_RELEASE_SECONDS = 0.1
"""After so long without a repetition a key counts as released, where the terminal does not tell."""
_DOUBLE_CLICK_SECONDS = 0.4
_NAME = re.compile(r"(?:KEY|MOUSE)_((?:(?:CTRL|ALT|SHIFT|SUPER|HYPER|META)_)*)(.+)")
_MODIFIERS = {"CTRL": "Control", "ALT": "Alt", "SHIFT": "Shift", "SUPER": "Meta", "HYPER": "Meta", "META": "Meta"}
_KEYS = {"UP": "ArrowUp", "DOWN": "ArrowDown", "LEFT": "ArrowLeft", "RIGHT": "ArrowRight", "ESCAPE": "Escape",
         "LEFT_SHIFT": "Shift", "RIGHT_SHIFT": "Shift", **{f"F{n}": f"F{n}" for n in range(1, 13)}}
_BUTTONS = {"LEFT": 1, "RIGHT": 2, "MIDDLE": 3}
_NOTCH = {"SCROLL_UP": -100.0, "SCROLL_DOWN": 100.0}


class TerminalInput:
    """Remembers what is down.

    Parameters
    ----------
    cell : float
        Logical pixels that a character is wide; it is twice as high.
    """

    def __init__(self, cell: float) -> None:
        self._cell = cell
        self._down: dict[str, tuple[str, float]] = {}  # by name, else by character: key, last time
        self._last_click = (-1, -1), 0.0

    def events(self, stroke: Any, now: float) -> list[Event]:
        """Return what a keystroke of blessed stands for, at a time in seconds."""
        match = _NAME.fullmatch(stroke.key_name or "")
        modifiers = tuple(_MODIFIERS[name] for name in match[1].split("_")[:-1]) if match else ()
        name = match[2] if match else ""
        if match and match[0].startswith("MOUSE_"):
            return self._pointer(name, stroke.mouse_xy, modifiers, now)
        return self._key(stroke, name, modifiers, now)

    def released(self, now: float) -> list[Event]:
        """Return key_up for the keys that are no longer repeated."""
        gone = [which for which, (_, last) in self._down.items() if now - last > _RELEASE_SECONDS]
        return [_key_event("key_up", self._down.pop(which)[0], ()) for which in gone]

    def _key(self, stroke: Any, name: str, modifiers: tuple[str, ...], now: float) -> list[Event]:
        key = _KEYS.get(name) or stroke.value
        which = name or key
        if stroke.released:
            key, _ = self._down.pop(which, (key, 0.0))
            return [_key_event("key_up", key, modifiers)] if key else []
        repeated = stroke.repeated or which in self._down
        if not key:
            return []
        self._down[which] = self._down.get(which, (key, 0.0))[0], now
        return [] if repeated else [_key_event("key_down", key, modifiers)]

    def _pointer(self, name: str, cell: tuple[int, int], modifiers: tuple[str, ...], now: float) -> list[Event]:
        place = {"x": (cell[0] + 0.5) * self._cell, "y": (2 * cell[1] + 1.0) * self._cell, "modifiers": modifiers}
        if name in _NOTCH:
            return [{"event_type": "wheel", "dx": 0.0, "dy": _NOTCH[name], "buttons": (), **place}]
        button = _BUTTONS.get(name.split("_")[0], 0)
        if "MOTION" in name:
            return [{"event_type": "pointer_move", "button": 0, "buttons": (button,) if button else (), **place}]
        if name.endswith("RELEASED"):
            return [{"event_type": "pointer_up", "button": button, "buttons": (), **place}]
        if not button:
            return []
        events: list[Event] = [{"event_type": "pointer_down", "button": button, "buttons": (button,), **place}]
        if button == 1:
            (last, at), self._last_click = self._last_click, (cell, now)
            if last == cell and now - at < _DOUBLE_CLICK_SECONDS:
                events.append({**events[0], "event_type": "double_click"})
        return events


def _key_event(event_type: str, key: str, modifiers: tuple[str, ...]) -> Event:
    return {"event_type": event_type, "key": key, "modifiers": modifiers}
