"""The desktop window, on a display that nobody sees; each window is a process of its own."""

import contextlib
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from lines import Lines
from window_app import picture_of
from xvfb import xvfb

APP = Path(__file__).with_name("window_app.py")
TITLE = "glimt test"
STRICT = ["-X", "dev", "-W", "error"]


def _error(environment):
    """Return what opening a window complains about."""
    code = ("from glimt import GlimtError; from glimt.viewer.window.canvas import WindowCanvas\n"
            "try: WindowCanvas()\nexcept GlimtError as error: print(error)")
    result = subprocess.run([sys.executable, *STRICT, "-c", code], env=environment, capture_output=True, text=True,
                            timeout=20, check=True)
    assert result.stderr == ""
    return result.stdout


@pytest.fixture(scope="module")
def display():
    with xvfb() as display:
        if message := _error(display.environment):
            pytest.skip(f"{message.strip()}; on Debian and Ubuntu, apt install libgl1 libgl1-mesa-dri")
        yield display


class App:
    """A running window_app: its events in order, and orders to it."""

    def __init__(self, process):
        self.process = process
        self.seen = []
        self._lines = Lines(process.stdout)

    def next(self, event_type, timeout=10, **fields):
        """Return the next event of this type and with these fields; drop those before it."""
        wanted = {"event_type": event_type, **fields}
        while line := self._lines.next(timeout):
            event = json.loads(line)
            self.seen.append(event)
            if wanted.items() <= event.items():
                return event
        pytest.fail(f"no {wanted}: {self.seen}")

    def do(self, expression):
        """Evaluate an expression in the window's thread and return its value."""
        self.process.stdin.write(expression + "\n")
        self.process.stdin.flush()
        return self.next("done")["value"]

    def count(self, event_type):
        return sum(event["event_type"] == event_type for event in self.seen)

    def kill(self):
        self.process.kill()
        self._lines.join()
        self.process.communicate()

    def end(self):
        """Wait for the end and return what it complained about."""
        self.next("end")
        assert self.process.wait(10) == 0
        return self.process.stderr.read()


@contextlib.contextmanager
def window(display, *sizes, **environment):
    """Run window_app, showing and focused in the block."""
    process = subprocess.Popen([sys.executable, *STRICT, APP, *map(str, sizes)], env=display.environment | environment,
                               stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    app = App(process)
    try:
        app.next("draw")
        yield app
    finally:
        app.kill()


def _focus(display):
    display.do("windowfocus", "--sync", str(display.window(TITLE)))


@pytest.mark.parametrize("version", ["", "1.4"], ids=["texture", "pixels"])
def test_a_picture_as_large_as_the_window_is_shown_to_the_byte(display, version):
    with window(display, 301, 203, 301, 203, MESA_GL_VERSION_OVERRIDE=version):
        display.wait_for_pixels(picture_of(301, 203)[..., :3])


@pytest.mark.parametrize("version", ["", "1.4"], ids=["texture", "pixels"])
def test_another_is_stretched_over_the_window(display, version):
    corners = picture_of(2, 2)[..., :3]
    with window(display, 300, 200, 2, 2, MESA_GL_VERSION_OVERRIDE=version):
        display.wait_for_pixels(corners[:1, :1])
        screen = display.screenshot()[:200, :300]
        np.testing.assert_array_equal(screen[[0, 0, -1, -1], [0, -1, 0, -1]], corners.reshape(4, 3))
        if not version:  # interpolated
            np.testing.assert_allclose(screen[99:101, 149:151].mean((0, 1)), corners.mean((0, 1)), atol=2)


def test_the_last_picture_comes_back_without_a_draw(display):
    with window(display, 120, 90, 120, 90) as app:
        picture = picture_of(120, 90)[..., :3]
        display.wait_for_pixels(picture)
        handle = str(display.window(TITLE))
        app.do("0")
        draws = app.count("draw")
        display.do("windowunmap", "--sync", handle)
        display.wait_for_pixels(np.zeros_like(picture))
        display.do("windowmap", "--sync", handle)
        display.wait_for_pixels(picture)
        app.do("0")
        assert app.count("draw") == draws


def test_any_thread_may_ask_for_a_draw(display):
    with window(display, 120, 90, 120, 90) as app:
        app.do("__import__('threading').Thread(target=canvas.request_draw).start()")
        app.next("draw")


def test_resizing_tells_and_stretches(display):
    with window(display, 200, 100, 1, 1) as app:
        display.do("windowsize", str(display.window(TITLE)), "320", "240")
        app.next("resize", width=320, height=240, pixel_ratio=1)
        app.next("draw")
        display.wait_for_pixels(np.broadcast_to(picture_of(1, 1)[..., :3], (240, 320, 3)))


def test_keys(display):
    with window(display, 200, 100, 2, 2) as app:
        _focus(display)
        for name, arrives in (("w", "w"), ("space", " "), ("Up", "ArrowUp"), ("F11", "F11"), ("KP_5", "5"),
                              ("KP_Add", "+"), ("5", "5"), ("Escape", "Escape")):
            display.do("key", name)
            app.next("key_down", key=arrives, modifiers=[])
            app.next("key_up", key=arrives)
        display.do("key", "shift+l")
        app.next("key_down", key="Shift")
        app.next("key_down", key="L", modifiers=["Shift"])
        app.next("char", data="L")


def test_a_held_key_comes_once_and_comes_up_with_the_focus_gone(display):
    with window(display, 200, 100, 2, 2) as app:
        _focus(display)
        display.do("keydown", "w")
        display.do("mousemove", "50", "50", "mousedown", "1", "sleep", "0.8")  # X11 repeats after 0.66 s
        app.next("pointer_down", button=1)
        with window(display, 50, 50, 2, 2):
            app.next("key_up", key="w")
            app.next("pointer_up", button=1)
        display.do("keyup", "w", "mouseup", "1")
        assert app.count("key_down") == 1


def test_pointer_and_wheel(display):
    with window(display, 200, 100, 2, 2) as app:
        display.do("mousemove", "500", "400")
        display.do("mousemove", "20", "30")
        app.next("pointer_enter")
        app.next("pointer_move", x=20, y=30)
        display.do("mousedown", "3")
        app.next("pointer_down", x=20, y=30, button=2, buttons=[2])
        display.do("mousemove", "700", "500")  # goes on outside while a button is down
        app.next("pointer_move", x=700, y=500, buttons=[2])
        display.do("mouseup", "3")
        app.next("pointer_up", button=2, buttons=[])
        display.do("mousemove", "20", "30", "click", "4")
        app.next("wheel", dy=-100, x=20, y=30)


def test_a_captured_pointer_moves_without_bound(display):
    with window(display, 200, 100, 2, 2) as app:
        _focus(display)
        display.do("mousemove", "50", "50")
        app.next("pointer_move", x=50)
        app.do("canvas.set_pointer_captured(True)")
        for i in range(1, 11):
            display.do("mousemove_relative", "--", "-90", "30")
            app.next("pointer_move", x=50 - 90 * i, y=50 + 30 * i)
        display.do("click", "1")
        app.next("pointer_down", button=1)
        app.do("canvas.set_pointer_captured(False)")
        assert display.do("getmouselocation").startswith("x:50 y:50 ")
        display.do("mousemove", "60", "40")
        app.next("pointer_move", x=60, y=40)


def test_a_pointer_is_captured_from_outside_and_stays_so_while_another_window_has_the_focus(display):
    display.do("mousemove", "700", "500")
    with window(display, 200, 100, 2, 2) as app:
        _focus(display)
        app.do("canvas.set_pointer_captured(True)")
        with window(display, 50, 50, 2, 2):
            display.do("mousemove", "500", "400")
        _focus(display)
        display.do("mousemove_relative", "--", "-90", "30")
        app.next("pointer_move")
        assert app.count("pointer_leave") == 0


def test_full_screen_and_back(display):
    with window(display, 200, 100, 1, 1) as app:
        color = picture_of(1, 1)[..., :3]
        handle = str(display.window(TITLE))
        display.do("windowmove", "--sync", handle, "60", "70")
        app.do("canvas.set_fullscreen(True)")
        app.next("resize", width=800, height=600)
        display.wait_for_pixels(np.broadcast_to(color, (600, 800, 3)))
        app.do("canvas.set_fullscreen(False)")
        app.next("resize", width=200, height=100)
        display.wait_for_pixels(np.broadcast_to(color, (100, 200, 3)), 60, 70)
        display.wait_for_pixels(np.zeros((70, 800, 3), np.uint8))


def test_closing_by_the_window_manager(display):
    with window(display, 200, 100, 2, 2) as app:
        display.ask_to_close(display.window(TITLE))
        app.next("close")
        assert app.end() == ""


def test_closing_by_itself(display):
    with window(display, 200, 100, 2, 2) as app:
        app.do("canvas.set_pointer_captured(True) or canvas.set_fullscreen(True) or canvas.close()")
        assert app.end() == ""


def test_ctrl_c_closes(display):
    with window(display, 200, 100, 2, 2) as app:
        app.do("0")  # the loop runs
        app.process.send_signal(signal.SIGINT)
        app.next("close")
        assert app.end() == "Received signal Interrupt\n"


def test_ctrl_c_in_the_middle_of_painting_closes(display):
    with window(display, 200, 100, 2, 2) as app:
        app.do("setattr(canvas.screen._blitter, 'draw', lambda *size: __import__('signal').raise_signal(2))")
        app.do("canvas.request_draw()")
        app.next("close")
        assert app.end() == "Received signal Interrupt\n"


@pytest.mark.parametrize("at_the_end", ["", "canvas.close()"])
def test_a_window_that_never_ran_ends_in_silence(display, at_the_end):
    code = f"from glimt.viewer.window.canvas import WindowCanvas; canvas = WindowCanvas(vsync=False); {at_the_end}"
    result = subprocess.run([sys.executable, *STRICT, "-c", code], env=display.environment, capture_output=True,
                            text=True, timeout=20, check=False)
    assert (result.returncode, result.stdout, result.stderr) == (0, "", "")


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere there always is a display")
@pytest.mark.parametrize("name", [None, ":4711", "localhost:4711", "nonsense"])
def test_no_display(name):
    environment = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "WAYLAND_DISPLAY")}
    message = _error(environment | ({"DISPLAY": name} if name else {}))
    assert message.startswith("no display: ")
    for way in ("--web", "--terminal", "glimt render"):
        assert way in message


def test_without_glx_there_is_egl(display):
    with xvfb(400, 300, "-extension", "GLX") as bare:
        with window(bare, 90, 60, 90, 60):
            bare.wait_for_pixels(picture_of(90, 60)[..., :3])
        message = _error(bare.environment | {"__EGL_VENDOR_LIBRARY_FILENAMES": os.devnull})
        assert message.startswith("no OpenGL: ")
        assert "libgl1" in message
        assert "--web" in message
