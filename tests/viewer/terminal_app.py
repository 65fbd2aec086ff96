"""Shows the test's scene in the terminal that is the standard input; with "fail", frames fail once B is pressed."""

import fcntl
import sys
import termios
from pathlib import Path

from viewer_driver import make_scene

from glimt.viewer import show
from glimt.viewer.session import Session
from glimt.viewer.viewer import Viewer


def _frame(viewer, now):
    if viewer.scene.settings.max_bounces:
        raise ZeroDivisionError("no such frame")
    return frame(viewer, now)


if __name__ == "__main__":
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)  # Ctrl-C in it is for us
    frame = Viewer.frame
    if "fail" in sys.argv:
        Viewer.frame = _frame
    show.in_terminal(Session(make_scene(), folder=Path.cwd()))
    print("ended")
