"""What the keys of the table do; each takes a viewer."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from glimt.debug_view import DEBUG_VIEWS, DebugView
from glimt.scene.camera import Camera
from glimt.scene.light import PointLight
from glimt.scene.motion import Orbit
from glimt.scene.scene import Samples
from glimt.viewer.keys import KEYS
from glimt.viewer.overlay.frame_info import samples_text
from glimt.viewer.pose import Pose, along
from glimt.viewer.screenshot import save_screenshot

if TYPE_CHECKING:
    from glimt.viewer.viewer import Viewer

MOST_LIGHTS = 64
MOST_BOUNCES = 64
_SAMPLES: tuple[Samples, ...] = (1, 2, 3, "adaptive")
_ORBIT_SECONDS = 12.0
_FOV_STEP = 1.1
_SPEED_STEP = 1.4
_COLORS = ((1.0, 0.86, 0.65), (0.65, 0.8, 1.0), (1.0, 0.65, 0.6), (0.7, 1.0, 0.7), (0.85, 0.7, 1.0), (1.0, 1.0, 0.7))

# ---- lights and rays -------------------------------------------------------------------------------------------------


def add_light(viewer: "Viewer") -> None:
    """Add a point light where the camera is; it goes around the middle of the scene."""
    lights = viewer.scene.lights
    if len(lights) >= MOST_LIGHTS:
        viewer.say(f"{MOST_LIGHTS} lights are enough")
        return
    lo, hi = viewer.scene.bounds()
    x, y, z = ((lo + hi) / 2).tolist()
    orbit = Orbit((x, y, z), viewer.pose.sky, _ORBIT_SECONDS)
    # An orbit says where a light stands at time 0; this one is to be here now.
    start = orbit.position(viewer.pose.position, -viewer.time)
    color = _COLORS[len(lights) % len(_COLORS)]
    lights.append(PointLight(position=start, diffuse=color, radius=viewer.scene_size() / 4, motion=orbit,
                             name=f"light {len(lights)}"))
    _count(viewer, "light", len(lights))


def remove_light(viewer: "Viewer") -> None:
    """Remove the light that came last."""
    if viewer.scene.lights:
        viewer.scene.lights.pop()
    _count(viewer, "light", len(viewer.scene.lights))


def toggle_time(viewer: "Viewer") -> None:
    """Let the lights move, or stand still."""
    viewer.time_runs = not viewer.time_runs
    viewer.say("lights move" if viewer.time_runs else "lights stand still")


def add_bounce(viewer: "Viewer", step: int = 1) -> None:
    """Follow mirror rays for one bounce more."""
    settings = viewer.scene.settings
    settings.max_bounces = min(max(settings.max_bounces + step, 0), MOST_BOUNCES)
    _count(viewer, "bounce", settings.max_bounces)


def remove_bounce(viewer: "Viewer") -> None:
    """Follow mirror rays for one bounce less."""
    add_bounce(viewer, -1)


def next_samples(viewer: "Viewer") -> None:
    """Take the next number of samples a pixel."""
    now = _SAMPLES.index(viewer.samples) if viewer.samples in _SAMPLES else -1
    viewer.samples = _SAMPLES[(now + 1) % len(_SAMPLES)]
    viewer.say(f"{samples_text(viewer.samples)} samples a pixel")
    viewer.changed()


def _count(viewer: "Viewer", thing: str, number: int) -> None:
    viewer.say(f"{number} {thing}{'' if number == 1 else 's'}")
    viewer.changed()


# ---- camera ----------------------------------------------------------------------------------------------------------


def faster(viewer: "Viewer", factor: float = _SPEED_STEP) -> None:
    """Move faster."""
    viewer.motion.speed *= factor
    viewer.say(f"{viewer.motion.speed:.3g} units a second")


def slower(viewer: "Viewer") -> None:
    """Move slower."""
    faster(viewer, 1 / _SPEED_STEP)


def zoom(viewer: "Viewer", factor: float) -> None:
    """Change the field of view."""
    fov = min(max(viewer.pose.fov_deg * factor, 1.0), 150.0)
    viewer.pose = replace(viewer.pose, fov_deg=fov)
    viewer.say(f"field of view {fov:.0f}°")
    viewer.changed()


def mouse_look(viewer: "Viewer", on: bool | None = None) -> None:
    """Look around by moving the mouse, or no longer."""
    viewer.mouse_look = not viewer.mouse_look if on is None else on
    viewer.controls.forget_pointer()
    if viewer.host:
        viewer.host.set_pointer_captured(viewer.mouse_look)
    viewer.say("mouse look: Esc ends it" if viewer.mouse_look else "mouse look off")


def release(viewer: "Viewer") -> None:
    """End mouse look, the help and the full screen, whichever is on."""
    if viewer.mouse_look:
        mouse_look(viewer, False)
    elif viewer.help_shown:
        toggle_help(viewer)
    elif viewer.host and viewer.host.is_fullscreen:
        toggle_fullscreen(viewer)
    viewer.picked = None
    viewer.uncover()


def orbit(viewer: "Viewer") -> None:
    """Go around what is in the middle of the picture; or fly again."""
    if viewer.motion.target is not None:
        viewer.motion.target = None
        viewer.say("fly")
        return
    found = viewer.find(viewer.size[0] / 2, viewer.size[1] / 2)
    pose = viewer.pose
    distance = found.distance if found else max(viewer.target_distance(), viewer.motion.speed)
    viewer.motion.target = found.position if found else along(pose.position, pose.look, distance)
    viewer.say("orbit")


def orbit_around(viewer: "Viewer", x: float, y: float) -> None:
    """Go around the point that is seen at a pixel."""
    found = viewer.find(x, y)
    if found:
        viewer.picked, viewer.motion.target = found, found.position
        viewer.say(f"orbit around {found.object.name}")


def pick(viewer: "Viewer", x: float, y: float) -> None:
    """Show what is seen at a pixel."""
    viewer.picked = viewer.find(x, y)
    viewer.uncover()


def reset(viewer: "Viewer") -> None:
    """Go back to where the viewer began."""
    go_to(viewer, viewer.first_pose)
    viewer.motion.target = None


def frame_all(viewer: "Viewer") -> None:
    """Show everything, from the side that is seen now."""
    _frame(viewer, *viewer.scene.bounds())


def frame_picked(viewer: "Viewer") -> None:
    """Show the picked object as large as it fits."""
    if viewer.picked is None:
        viewer.say("click on an object first")
        return
    _frame(viewer, *viewer.picked.object.bounds())


def _frame(viewer: "Viewer", lo: np.ndarray, hi: np.ndarray) -> None:
    pose, aspect = viewer.pose, viewer.size[0] / viewer.size[1]
    camera = Camera.framing(lo, hi, aspect, pose.fov_deg, pose.look)
    x, y, z = ((lo + hi) / 2).tolist()
    go_to(viewer, replace(pose, position=camera.position))
    if viewer.motion.target is not None:
        viewer.motion.target = x, y, z


def go_to(viewer: "Viewer", pose: Pose) -> None:
    """Take another pose at once."""
    viewer.motion.stop()
    viewer.pose = pose
    viewer.changed()


def begin_saving_view(viewer: "Viewer") -> None:
    """Wait for the number under which the view is saved."""
    viewer.saving_view = True
    viewer.say("save this view as 1-9")


def save_view(viewer: "Viewer", name: str) -> None:
    """Save the view under the number that was pressed; any other key drops the wish."""
    viewer.saving_view = False
    if len(name) == 1 and name in "123456789":
        viewer.saved[int(name)] = viewer.pose
        viewer.say(f"view {name} saved")
    else:
        viewer.say("view not saved")


def recall_view(viewer: "Viewer", number: int) -> None:
    """Go to a saved view."""
    if number in viewer.saved:
        go_to(viewer, viewer.saved[number])
        viewer.say(f"view {number}")
    else:
        viewer.say(f"no view {number} yet: V, then {number} saves one")


# ---- picture ---------------------------------------------------------------------------------------------------------


def toggle_pause(viewer: "Viewer") -> None:
    """Stop rendering, or go on."""
    viewer.paused = not viewer.paused
    viewer.motion.stop()
    viewer.say("paused: K goes on" if viewer.paused else "goes on")


def next_overlay(viewer: "Viewer") -> None:
    """Show numbers, numbers and graph, or neither."""
    viewer.overlay_level = (viewer.overlay_level + 1) % 3
    viewer.uncover()


def toggle_help(viewer: "Viewer") -> None:
    """Show the help, or no longer."""
    viewer.help_shown = not viewer.help_shown
    viewer.uncover()


def toggle_fullscreen(viewer: "Viewer") -> None:
    """Fill the screen, or no longer."""
    if viewer.host:
        viewer.host.set_fullscreen(not viewer.host.is_fullscreen)


def debug_view(viewer: "Viewer", name: DebugView | None) -> None:
    """Show numbers of the rays instead of light."""
    viewer.debug_view = name
    viewer.governor.forget()
    viewer.say(name or "picture")
    viewer.changed()


def next_debug_view(viewer: "Viewer") -> None:
    """Show the next debug view; after the last, the picture."""
    views = (None, *DEBUG_VIEWS)
    debug_view(viewer, views[(views.index(viewer.debug_view) + 1) % len(views)])


COMMANDS: dict[str, Callable[["Viewer"], None]] = {
    "add_light": add_light, "remove_light": remove_light, "toggle_time": toggle_time, "add_bounce": add_bounce,
    "remove_bounce": remove_bounce, "samples": next_samples, "faster": faster, "slower": slower,
    "narrower": partial(zoom, factor=1 / _FOV_STEP), "wider": partial(zoom, factor=_FOV_STEP),
    "mouse_look": mouse_look, "release": release, "orbit": orbit, "frame_all": frame_all,
    "frame_picked": frame_picked, "reset": reset, "save_view": begin_saving_view, "pause": toggle_pause,
    "screenshot": save_screenshot, "overlay": next_overlay, "help": toggle_help, "fullscreen": toggle_fullscreen,
    "next_debug_view": next_debug_view, "debug_picture": partial(debug_view, name=None),
    **{f"recall_{n}": partial(recall_view, number=n) for n in range(1, 10)},
    **{f"debug_{name}": partial(debug_view, name=name) for name in DEBUG_VIEWS},
}
"""By action of the table of keys."""
assert {key.action for key in KEYS if not key.held} == set(COMMANDS), "a key without a command, or the reverse"
