"""What a canvas' events do to a viewer: keys that are held, keys that are pressed, drags, clicks and the wheel."""

import math
from typing import TYPE_CHECKING

from glimt.viewer import commands
from glimt.viewer.keys import Event, action_of, key_name

if TYPE_CHECKING:
    from glimt.viewer.viewer import Viewer

_CLICK_PIXELS = 4.0
"""How far the pointer may move between down and up for a click."""
_WHEEL_STEP = 100.0
"""What one notch of a wheel counts in an event."""
_DOLLY = 0.12
"""Share of the way to the target that one notch goes."""
_DOLLY_SECONDS = 0.4
"""How long a flight one notch is worth."""
_LOOK_GAIN = 2.0
"""Mouse look turns that much faster than a drag, of which one over the picture's height is a field of view."""
_SHIFT_SECONDS = 0.2
"""Shift belongs to other keys as well: held for less than that it does not move the camera."""


class Controls:
    """Knows which keys and buttons are down.

    Attributes
    ----------
    shift_due : float
        When a Shift that is down begins to move the camera; infinity: it is not, or does so already.
    """

    def __init__(self, viewer: "Viewer") -> None:
        self._viewer = viewer
        self._down: dict[str, str] = {}
        self._pointer: tuple[float, float] | None = None
        self._pressed: tuple[float, float] | None = None
        self.shift_due = math.inf

    def handle(self, event: Event) -> None:
        """Apply an event; one of no interest is ignored."""
        method = getattr(self, "_" + str(event.get("event_type")), None)
        if method:
            method(event)

    def step(self, now: float) -> None:
        """Let time pass."""
        if now >= self.shift_due:
            self._hold("Shift", "down")

    def forget_pointer(self) -> None:
        """Forget where the pointer was: it is about to jump."""
        self._pointer = self._pressed = None

    # ---- keys ----------------------------------------------------------------------------------------------------

    def _key_down(self, event: Event) -> None:
        viewer, name = self._viewer, key_name(event)
        key = action_of(event)
        if viewer.saving_view and name != "Shift":
            commands.save_view(viewer, name)
        elif key is None:
            return
        elif name == "Shift":
            self.shift_due = viewer.now + _SHIFT_SECONDS
        elif key.held:
            self._hold(name.removeprefix("Shift+"), key.action)
        else:
            self._let_up("Shift")
            commands.COMMANDS[key.action](viewer)

    def _key_up(self, event: Event) -> None:
        self._let_up(key_name(event).removeprefix("Shift+"))

    def _hold(self, name: str, direction: str) -> None:
        if name == "Shift":
            self.shift_due = math.inf
        self._down[name] = direction
        self._viewer.motion.hold(direction)

    def _let_up(self, name: str) -> None:
        if name == "Shift":
            self.shift_due = math.inf
        direction = self._down.pop(name, None)
        if direction and direction not in self._down.values():
            self._viewer.motion.release(direction)

    # ---- pointer -------------------------------------------------------------------------------------------------

    def _pointer_down(self, event: Event) -> None:
        self._pointer = self._pressed = float(event["x"]), float(event["y"])

    def _pointer_move(self, event: Event) -> None:
        viewer, here = self._viewer, (float(event["x"]), float(event["y"]))
        last, self._pointer = self._pointer, here
        buttons = tuple(event.get("buttons", ()))
        if last is None or not (buttons or viewer.mouse_look):
            return
        dx, dy = here[0] - last[0], here[1] - last[1]
        if self._pressed and math.dist(here, self._pressed) > _CLICK_PIXELS:
            self._pressed = None
        if buttons and self._pressed:
            return  # it may yet be a click
        if not viewer.mouse_look and (2 in buttons or 3 in buttons):
            distance = viewer.target_distance()
            step = 2 * distance * math.tan(math.radians(viewer.pose.fov_deg) / 2) / self._height()
            viewer.motion.slide(-dx * step, dy * step, 0.0)
            return
        step = math.pi if viewer.motion.target else math.radians(viewer.pose.fov_deg)
        step *= (_LOOK_GAIN if viewer.mouse_look else 1.0) / self._height()
        viewer.motion.turn(dx * step, -dy * step)

    def _pointer_up(self, event: Event) -> None:
        pressed, self._pressed = self._pressed, None
        if pressed and event.get("button") == 1 and not self._viewer.mouse_look:
            commands.pick(self._viewer, *self._pixel(event))

    def _double_click(self, event: Event) -> None:
        if not self._viewer.mouse_look:
            commands.orbit_around(self._viewer, *self._pixel(event))

    def _wheel(self, event: Event) -> None:
        viewer = self._viewer
        notches = max(-20.0, min(20.0, -float(event["dy"]) / _WHEEL_STEP))
        if viewer.motion.target:
            viewer.motion.slide(0.0, 0.0, notches * _DOLLY * viewer.target_distance())
        else:
            viewer.motion.slide(0.0, 0.0, notches * _DOLLY_SECONDS * viewer.motion.speed)

    # ---- the canvas ----------------------------------------------------------------------------------------------

    def _resize(self, event: Event) -> None:
        ratio = float(event.get("pixel_ratio", 1.0))
        self._viewer.resize(round(event["width"] * ratio), round(event["height"] * ratio), ratio)

    def _pixel(self, event: Event) -> tuple[float, float]:
        ratio = self._viewer.pixel_ratio
        return float(event["x"]) * ratio, float(event["y"]) * ratio

    def _height(self) -> float:
        return max(1.0, self._viewer.size[1] / self._viewer.pixel_ratio)
