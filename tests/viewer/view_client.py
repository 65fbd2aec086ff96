"""`glimt view` in a process of its own, seen and steered from a test."""

import contextlib
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from lines import Lines

APP = Path(__file__).with_name("view_app.py")
STONE_ROOM = Path(__file__).parents[2] / "examples" / "stone_room.toml"


class View:
    """A running viewer and the display it is on."""

    def __init__(self, process, display):
        self.process, self.display = process, display
        self._lines = Lines(process.stdout)

    def ask(self, expression, timeout=20):
        """Return what an expression of `app` and `viewer` is."""
        self.process.stdin.write(expression + "\n")
        self.process.stdin.flush()
        line = self._lines.next(timeout)
        assert line, f"the viewer has ended: {self.end()}"
        return json.loads(line)

    def state(self):
        return self.ask("app.state()")

    def wait_for(self, right, timeout=10.0):
        """Return the first state that is right; fail with the last one when none is."""
        end = time.monotonic() + timeout
        while not right(state := self.state()):
            assert time.monotonic() < end, f"it does not come to that: {state}"
            time.sleep(0.01)
        return state

    def rest(self):
        """Wait until the picture on the screen is as good as it gets."""
        return self.wait_for(lambda state: state["at_rest"])

    def reset(self):
        """Have it begin anew, with lights that stand still, and wait for the picture."""
        assert self.ask("app.reset()")
        self.rest()

    def press(self, *keys):
        """Press keys by their names in X11, one after the other; "shift+l" holds Shift meanwhile."""
        self.display.do("key", *keys)

    def hold(self, key, seconds=0.3):
        """Keep a key down for a while."""
        self.display.do("keydown", key, "sleep", str(seconds), "keyup", key)

    def picture(self):
        """Return what the window shows, (h, w, 3) uint8; it is at the screen's top left corner."""
        width, height = self.ask("viewer.size")
        return self.display.screenshot()[:height, :width].copy()

    def wait_for_change(self, before, part=np.s_[:], timeout=10.0):
        """Wait until a part of the window shows something other than in the picture `before`."""
        end = time.monotonic() + timeout
        while np.array_equal(self.picture()[part], before[part]):
            assert time.monotonic() < end, "the picture on the screen stays as it was"
            time.sleep(0.01)

    def end(self, timeout=3.0):
        """Wait for the end, of every process it started too; return exit code and what it wrote on standard error."""
        code = self.process.wait(timeout)
        with pytest.raises(ProcessLookupError):
            os.killpg(self.process.pid, 0)
        return code, self.process.stderr.read()


@contextlib.contextmanager
def viewing(display, *arguments, cwd=None):
    """Run ``glimt view`` with arguments, showing and focused in the block."""
    process = subprocess.Popen(
        [sys.executable, APP, "view", *map(str, arguments)], env=display.environment, cwd=cwd, text=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)
    view = View(process, display)
    try:
        view.wait_for(lambda state: state["shown"] > 0, 60)
        window = display.do("search", "--sync", "--onlyvisible", "--class", "glimt").split()[0]
        display.do("windowfocus", "--sync", window)
        view.window = int(window)
        yield view
    finally:
        process.kill()
        process.communicate()
