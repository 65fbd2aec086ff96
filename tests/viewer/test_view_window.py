"""Every key and every move of the mouse, in a window on a display that nobody sees."""

import subprocess
import sys

import numpy as np
import pytest
from PIL import Image
from view_client import STONE_ROOM, viewing
from xvfb import xvfb

from glimt.viewer.keys import KEYS, POINTER

X11_NAMES = {"ArrowUp": "Up", "ArrowDown": "Down", "ArrowLeft": "Left", "ArrowRight": "Right", "Space": "space",
             "Shift": "shift", "+": "plus", "=": "equal", "-": "minus", "_": "underscore", "?": "question"}
WAYS = {"forward": ("look", 1), "back": ("look", -1), "right": ("right", 1), "left": ("right", -1), "up": ("up", 1),
        "down": ("up", -1)}
SCENE = np.s_[:180, 230:]
"""A part of the window that numbers and messages leave free."""
ANYWHERE = np.s_[:]
BALL, FLOOR = ("89", "168"), ("40", "215")
"""Where the lacquer ball and the floor are seen at first."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("kept")


@pytest.fixture(scope="module")
def app(folder):
    with xvfb() as display, viewing(display, STONE_ROOM, "--size", "320x240", cwd=folder) as app:
        app.ask("app.hurry()")
        yield app


@pytest.fixture
def view(app):
    app.reset()
    return app


def way(before, after):
    return np.subtract(after["position"], before["position"])


def turned(before, after):
    """Return how far the camera has turned to the right, 0 to 2π."""
    yaw, was = (np.arctan2(state["look"][0], -state["look"][2]) for state in (after, before))
    return (yaw - was) % (2 * np.pi)


def becomes(**fields):
    return lambda before, after: fields.items() <= after.items() and not fields.items() <= before.items()


def grows(name, factor):
    return lambda before, after: after[name] == pytest.approx(before[name] * factor)


def lights(number):
    return lambda before, after: len(after["lights"]) == len(before["lights"]) + number


def stands_back(before, after):
    return after["look"] == before["look"] and np.linalg.norm(way(before, after)) > 0.1


def looks_at_the_ball(before, after):
    to_ball = np.subtract((-0.85, 0.36, 0.35), after["position"])
    return 1 < np.linalg.norm(to_ball) < 2 and np.dot(to_ball, after["look"]) > 0.999 * np.linalg.norm(to_ball)


def is_home(before, after):
    home = [2.7, 1.9, 3.5], 50
    return (after["position"], after["fov"]) == home != (before["position"], before["fov"])


def has_a_target(before, after):
    return after["target"] and not before["target"]


def lights_move(before, after):
    return after["time"] > before["time"]


CHECKS = {
    "faster": (grows("speed", 1.4), ANYWHERE),
    "slower": (grows("speed", 1 / 1.4), ANYWHERE),
    "release": (becomes(help_shown=False), SCENE, "h"),
    "orbit": (has_a_target, ANYWHERE),
    "frame_all": (stands_back, SCENE),
    "frame_picked": (looks_at_the_ball, SCENE, "click"),
    "reset": (is_home, SCENE, "walk"),
    "narrower": (grows("fov", 1 / 1.1), SCENE),
    "wider": (grows("fov", 1.1), SCENE),
    "save_view": (becomes(saving_view=True), ANYWHERE),
    "add_light": (lights(1), SCENE),
    "remove_light": (lights(-1), SCENE),
    "toggle_time": (lights_move, SCENE),
    "add_bounce": (becomes(bounces=1), SCENE),
    "remove_bounce": (becomes(bounces=1), SCENE, "b", "b"),
    "samples": (becomes(samples=2), ANYWHERE),
    "pause": (becomes(paused=True), ANYWHERE),
    "overlay": (becomes(overlay_level=2), ANYWHERE),
    "help": (becomes(help_shown=True), SCENE),
    "next_debug_view": (becomes(debug_view="normals"), SCENE),
    "debug_picture": (becomes(debug_view=None), SCENE, "F2"),
    **{f"debug_{name}": (becomes(debug_view=name), SCENE)
       for name in ("normals", "depth", "barycentrics", "instances", "nodes", "shadows")},
    **{f"recall_{n}": (is_home, SCENE, "v", str(n), "z") for n in range(1, 10)},
}
"""By action: what it must come to, which part of the window must change, and what is done before."""


def begin(view, steps):
    """Do what is done before a key, and return the state and the picture it finds."""
    for step in steps:
        if step == "click":
            view.display.do("mousemove", *BALL, "click", "1")
            view.wait_for(lambda state: state["picked"])
        elif step == "walk":
            view.hold("d", 0.2)
            view.wait_for(lambda state: not state["moving"] and state["position"] != [2.7, 1.9, 3.5])
        else:
            before = view.state()
            view.press(step)
            view.wait_for(lambda state, before=before: state != before)
    return view.rest(), view.picture()


@pytest.mark.parametrize(("name", "action"), [
    (name, key.action) for key in KEYS for name in key.keys
    if not key.held and key.action not in ("mouse_look", "fullscreen", "screenshot")])  # which have their own
def test_a_key_does_what_the_help_says(view, name, action):
    right, part, *steps = CHECKS[action]
    before, picture = begin(view, steps)
    view.press(X11_NAMES.get(name, name).replace("Shift", "shift"))
    view.wait_for(lambda after: right(before, after))
    view.wait_for_change(picture, part)


@pytest.mark.parametrize(("name", "action"), [(name, key.action) for key in KEYS if key.held for name in key.keys])
def test_a_held_key_moves_the_camera_its_way_and_no_longer(view, name, action):
    before, picture = begin(view, [])
    view.hold(X11_NAMES.get(name, name), 0.35 if name == "Shift" else 0.15)
    view.wait_for_change(picture, SCENE)
    after = view.wait_for(lambda state: not state["moving"])
    axis, sign = WAYS[action]
    moved = way(before, after)
    assert sign * np.dot(moved, before[axis]) > 0.999 * np.linalg.norm(moved) > 0.05
    assert after["look"] == before["look"]


def test_shift_that_is_held_for_another_key_does_not_move_the_camera(view):
    before, _ = begin(view, [])
    view.display.do("keydown", "shift", "key", "l", "sleep", "0.3", "key", "b", "z", "keyup", "shift")
    after = view.wait_for(lambda state: state["fov"] > 50 and state["at_rest"])
    assert (len(after["lights"]), after["position"]) == (1, before["position"])


def test_v_and_a_number_save_a_view_and_any_other_key_does_not(view):
    view.press("v", "5", "v", "Tab", "6")
    state = view.wait_for(lambda state: state["message"] and "no view 6" in state["message"])
    assert (state["saved"], state["saving_view"]) == ([5], False)


def test_samples_go_round(view):
    seen = []
    for _ in range(4):
        before = view.state()["samples"]
        view.press("n")
        seen.append(view.wait_for(lambda state, before=before: state["samples"] != before)["samples"])
    assert seen == [2, 3, "adaptive", 1]


@pytest.mark.parametrize(("start", "end"), [("F11", "F11"), ("u", "Escape"), ("F11", "u")])
def test_full_screen_and_back(view, start, end):
    view.press(start)
    view.wait_for(lambda state: state["size"] == [800, 600] and state["at_rest"])
    assert view.picture()[400:, 700:].any()
    view.press(end)
    state = view.wait_for(lambda state: state["size"] == [320, 240] and state["at_rest"])
    assert not state["fullscreen"]


def test_mouse_look_turns_as_far_as_the_mouse_goes(view):
    before, picture = begin(view, [])
    view.display.do("mousemove", "150", "110")  # GLFW will ignore moves to this very place, where it puts the pointer
    view.press("m")
    view.wait_for(lambda state: state["mouse_look"])
    view.display.do("mousemove_relative", "1", "0", "sleep", "0.1")  # from where it goes
    for _ in range(7):
        view.display.do("mousemove_relative", "200", "0")
    view.wait_for_change(picture, SCENE)
    after = view.wait_for(lambda state: not state["moving"])
    assert turned(before, after) == pytest.approx(2 * np.radians(50) * 7 * 200 / 240 - 2 * np.pi, rel=0.01)
    view.press("Escape")
    view.wait_for(lambda state: not state["mouse_look"])
    view.display.do("mousemove", "10", "10")
    assert view.rest()["look"] == after["look"]


def test_a_saved_picture_is_what_was_seen_and_its_view_file_makes_it_again(view, folder):
    view.press("b", "l", "d")
    view.wait_for(lambda state: state["bounces"] and len(state["lights"]) == 3 and state["position"][0] != 2.7
                  and not state["moving"] and state["at_rest"])
    seen = view.picture()
    view.press("p")
    saved = view.wait_for(lambda state: "saved" in (state["message"] or ""))["message"].removeprefix("saved ")
    with Image.open(folder / saved) as image:
        picture = np.asarray(image)
    np.testing.assert_array_equal(picture[SCENE], seen[SCENE])
    view_file = next(folder.glob("*.toml"))
    subprocess.run([sys.executable, "-m", "glimt", "render", STONE_ROOM, "--view", view_file, "--output",
                    folder / "again.png"], check=True, capture_output=True, timeout=60)
    with Image.open(folder / "again.png") as image:
        np.testing.assert_array_equal(np.asarray(image), picture)


# ---- the mouse -------------------------------------------------------------------------------------------------------


def drag(button):
    return ["mousemove", "160", "120", "sleep", "0.05", "mousedown", button, "mousemove", "190", "120", "sleep", "0.05",
            "mousemove", "220", "120", "sleep", "0.05", "mouseup", button]


def turns_right(before, after):
    """Return whether 60 of 240 pixels have turned the camera by a quarter of the field of view."""
    return not after["moving"] and turned(before, after) == pytest.approx(np.radians(50 / 4), rel=0.01)


def slides_left(before, after):
    aside = np.dot(way(before, after), before["right"])
    return not after["moving"] and aside < -0.2 and after["look"] == before["look"]


def comes_nearer(before, after):
    return not after["moving"] and np.dot(way(before, after), before["look"]) > 0.2


POINTER_CHECKS = {
    "drag": (drag("1"), turns_right, SCENE),
    "right drag": (drag("3"), slides_left, SCENE),
    "wheel": (["mousemove", "160", "120", "click", "4"], comes_nearer, SCENE),
    "click": (["mousemove", *BALL, "click", "1"], becomes(picked=["lacquer ball", "lacquer", None]), ANYWHERE),
    "double click": (["mousemove", *BALL, "click", "--repeat", "2", "--delay", "30", "1"], has_a_target, ANYWHERE),
}


@pytest.mark.parametrize("what", [what for what, _, _ in POINTER])
def test_the_mouse_does_what_the_help_says(view, what):
    words, right, part = POINTER_CHECKS[what]
    before, picture = begin(view, [])
    view.display.do(*words)
    view.wait_for(lambda after: right(before, after))
    view.wait_for_change(picture, part)


def test_a_triangle_is_picked(view):
    view.display.do("mousemove", *FLOOR, "click", "1")
    name, _, triangle = view.wait_for(lambda state: state["picked"])["picked"]
    assert name == "room"
    assert triangle >= 0


def test_in_orbit_a_drag_goes_around_what_was_clicked(view):
    view.display.do(*POINTER_CHECKS["double click"][0])
    before = view.wait_for(lambda state: state["target"] and state["at_rest"])
    view.display.do(*drag("1"))
    after = view.wait_for(lambda state: state["look"] != before["look"] and not state["moving"])
    assert after["target"] == before["target"]
    distances = [np.linalg.norm(np.subtract(state["target"], state["position"])) for state in (before, after)]
    assert distances[0] == pytest.approx(distances[1])
    assert np.linalg.norm(way(before, after)) > 1
