"""However a window ends, its process ends soon and with the right code, and nothing is left of it."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from view_client import STONE_ROOM, viewing
from xvfb import xvfb

SCENE = np.s_[:120, 230:]  # where neither numbers nor errors are
LONGEST_END = 3.0


@pytest.fixture(scope="module")
def display():
    with xvfb() as display:
        yield display


@pytest.fixture(params=["moving", "at rest"])
def view(display, request):
    with viewing(display, STONE_ROOM, "--size", "320x240") as view:
        if request.param == "at rest":
            view.press("t")
            view.rest()
        yield view


def test_ctrl_c(view):
    view.process.send_signal(signal.SIGINT)
    assert view.end(LONGEST_END) == (0, "")


def test_the_window_is_closed(view):
    view.display.ask_to_close(view.window)
    assert view.end(LONGEST_END) == (0, "")


def test_sigterm(view):
    view.process.send_signal(signal.SIGTERM)
    assert view.end(LONGEST_END) == (-signal.SIGTERM, "")


@pytest.mark.parametrize(("error", "told"), [
    ("RuntimeError('a bug')", r"Traceback .*RuntimeError: a bug\n"), ("GlimtError('so it is')", "error: so it is\n")])
def test_a_frame_fails(display, error, told):
    with viewing(display, STONE_ROOM, "--size", "320x240") as view:
        view.ask(f"app.fail_later(5, {error})")
        code, text = view.end(LONGEST_END)
        assert code == 1
        assert re.fullmatch(told, text, re.DOTALL)


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere there always is a display")
def test_without_a_display_it_says_so_and_compiles_nothing(tmp_path):
    environment = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "WAYLAND_DISPLAY")}
    start = time.perf_counter()
    result = subprocess.run([sys.executable, "-m", "glimt", "view", STONE_ROOM], capture_output=True, text=True,
                            env=environment | {"GLIMT_CACHE_DIR": str(tmp_path)}, timeout=30, check=False)
    print(f"\n{time.perf_counter() - start:.2f} s until it is said that there is no display")
    assert (result.returncode, result.stdout, result.stderr.count("\n")) == (1, "", 1)
    assert result.stderr.startswith("error: no display: ")
    for other_way in ("--web", "--terminal", "glimt render"):
        assert other_way in result.stderr
    assert not any(tmp_path.rglob("*.nb?"))


def test_the_scene_is_edited_while_it_is_watched(display, tmp_path):
    shutil.copytree(STONE_ROOM.parent, tmp_path / "examples")
    path = tmp_path / "examples" / STONE_ROOM.name
    text = re.sub("\nmotion = .*", "", path.read_text())
    path.write_text(text)
    with viewing(display, path, "--size", "320x240", "--watch") as view:
        view.rest()
        first = view.picture()
        start = time.perf_counter()
        path.write_text(text.replace("diffuse = [1.9, 1.45, 0.95]", "diffuse = [0.2, 0.4, 1.9]"))
        view.wait_for_change(first, SCENE)
        seconds = time.perf_counter() - start
        print(f"\n{seconds:.2f} s from the change of a file to the picture")
        assert seconds < 3
        view.rest()
        blue = view.picture()
        path.write_text(text.replace("radius = 2.8", "radiance = 2.8"))
        error = view.wait_for(lambda state: state["error"] and state["at_rest"])["error"]
        assert re.search(r"stone_room\.toml:\d+: .*radiance", error)
        broken = view.picture()
        assert np.array_equal(broken[SCENE], blue[SCENE])
        assert not np.array_equal(broken, blue)
        path.write_text(text)
        view.wait_for(lambda state: not state["error"] and state["at_rest"])
        assert np.array_equal(view.picture()[SCENE], first[SCENE])
