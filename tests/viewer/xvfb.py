"""A display that nobody sees: Xvfb, pictures of it, and hands on its keyboard and mouse.

There is no window manager: no decorations, nothing minimizes, and windows stay where they are put, (0, 0) at first.
Full screen goes round the manager as well, so what one does with it is not tested here.
"""

import contextlib
import ctypes
import os
import select
import shutil
import struct
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest

NEEDED = {"Xvfb": "xvfb", "xdotool": "xdotool"}
CLIENT_MESSAGE = 33


class Display:
    """What a test can do with a display; `name` is for DISPLAY."""

    def __init__(self, name, framebuffer):
        self.name = name
        self.environment = {**os.environ, "DISPLAY": name}
        self._framebuffer = framebuffer

    def screenshot(self):
        """Return what the screen shows, (h, w, 3) uint8."""
        # The XWD format: a header of 32-bit words, most significant byte first, the palette, then the rows.
        data = self._framebuffer.read_bytes()
        header = struct.unpack(">25I", data[:100])
        header_size, width, height, bits, row, colors = (header[i] for i in (0, 4, 5, 11, 12, 19))
        assert bits == 32
        rows = np.frombuffer(data, np.uint8, row * height, header_size + 12 * colors).reshape(height, row // 4, 4)
        return rows[:, :width, 2::-1]

    def wait_for_pixels(self, expected, x=0, y=0, timeout=5, within=0):
        """Wait until `expected`, (h, w, 3), is on the screen at (x, y), give or take some codes, or fail."""
        height, width = expected.shape[:2]
        end = time.monotonic() + timeout
        while not (same := _differ_at_most(self.screenshot()[y:y + height, x:x + width], expected, within)):
            if time.monotonic() > end:
                break
            time.sleep(0.02)
        assert same, "the screen shows another picture"

    def do(self, *words):
        """Let xdotool do something: ``do("key", "w")``; return what it says."""
        return subprocess.run(["xdotool", *words], env=self.environment, capture_output=True, text=True, timeout=10,
                              check=True).stdout.strip()

    def window(self, title):
        """Return the number of the window of this title, once it can be seen."""
        return int(self.do("search", "--sync", "--onlyvisible", "--name", f"^{title}$").split()[0])

    def ask_to_close(self, window):
        """Send what a window manager sends when its button is pressed, which this xdotool cannot."""
        x11 = ctypes.CDLL("libX11.so.6")
        x11.XOpenDisplay.restype = x11.XInternAtom.restype = ctypes.c_void_p
        x11.XInternAtom.argtypes = ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int
        x11.XSendEvent.argtypes = ctypes.c_void_p, ctypes.c_ulong, ctypes.c_int, ctypes.c_long, ctypes.c_void_p
        x11.XCloseDisplay.argtypes = (ctypes.c_void_p,)
        display = x11.XOpenDisplay(self.name.encode())
        protocols, delete = (x11.XInternAtom(display, name, 0) for name in (b"WM_PROTOCOLS", b"WM_DELETE_WINDOW"))
        x11.XSendEvent(display, window, 0, 0,
                       (ctypes.c_long * 24)(CLIENT_MESSAGE, 0, 1, 0, window, protocols, 32, delete))
        x11.XCloseDisplay(display)


@contextlib.contextmanager
def xvfb(width=800, height=600, *options):
    """Run a display as long as the block does, or skip the test, saying which packages of Debian it wants."""
    if missing := [package for program, package in NEEDED.items() if not shutil.which(program)]:
        pytest.skip(f"no {' and no '.join(missing)}: on Debian and Ubuntu, apt install xvfb xdotool libgl1-mesa-dri")
    read, write = os.pipe()
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as stack:
        server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write), "-screen", "0", f"{width}x{height}x24", "-fbdir", folder, "-nocursor",
             "-nolisten", "tcp", "-noreset", *options], pass_fds=[write], stderr=subprocess.DEVNULL)
        stack.callback(_stop, server)
        os.close(write)
        with open(read, "rb") as answer:  # ends without a line when the server does
            number = answer.readline() if select.select([answer], [], [], 20)[0] else b""
        assert number.strip(), "Xvfb does not start"
        yield Display(f":{int(number)}", Path(folder) / "Xvfb_screen0")


def _differ_at_most(one, other, most):
    return one.shape == other.shape and np.abs(one.astype(int) - other).max() <= most


def _stop(server):
    server.terminate()
    try:
        server.wait(5)
    except subprocess.TimeoutExpired:
        server.kill()
        server.wait()
