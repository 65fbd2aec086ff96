"""The viewer in a terminal."""

import contextlib
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

if sys.platform == "win32":
    pytest.skip("no pseudoterminals", allow_module_level=True)

from terminal_screen import Terminal

HERE = Path(__file__).parent


@contextlib.contextmanager
def shown(*arguments, **options):
    """Run the app until its first picture is there."""
    environment = {**os.environ, "TERM": "xterm-256color", "COLORTERM": "truecolor", **options.pop("environment", {})}
    for name in ("LINES", "COLUMNS", "NO_COLOR"):
        environment.pop(name, None)
    terminal = Terminal([sys.executable, str(HERE / "terminal_app.py"), *arguments], environment, **options)
    try:
        terminal.wait_for(lambda: "H keys" in terminal.text())
        yield terminal
    finally:
        terminal.close()


def _is_restored(terminal):
    """Check that the terminal is as it was."""
    assert terminal.modes == {"25"}, "modes: alternate screen, cursor, mouse"
    assert terminal.attributes() == terminal.attributes_before


def test_a_picture_keys_and_ctrl_c():
    with shown() as terminal:
        terminal.wait_for(lambda: (terminal.picture()[:-2].sum(axis=2) > 0).all())
        picture = terminal.picture()
        assert picture.shape == (48, 80, 3)
        red, green = picture[24, 24].astype(int), picture[24, 60].astype(int)
        assert red[0] > 2 * red[1]
        assert green[1] > 2 * green[0]

        terminal.press("w")
        terminal.wait_for(lambda: np.abs(terminal.picture().astype(int) - picture).mean() > 1)
        terminal.type("b")
        terminal.wait_for(lambda: "1 bounce\n" in terminal.text())
        terminal.type("B")
        terminal.wait_for(lambda: "0 bounces\n" in terminal.text())
        terminal.type("\x1bOP\x1bOQ")  # F1, F2
        terminal.wait_for(lambda: "normals" in terminal.text())

        assert {"1049", "1006"} <= terminal.modes
        assert "25" not in terminal.modes
        terminal.type("\x03")
        assert terminal.end() == 0
        _is_restored(terminal)
        assert terminal.printed.endswith("ended\r\n")


def test_help_covers_the_picture_until_it_is_left():
    with shown() as terminal:
        terminal.wait_for(lambda: terminal.picture()[0].any())
        terminal.press("h")
        terminal.wait_for(lambda: "turn" in terminal.text())
        text = terminal.text()
        for line in ("W ↑", "forward", "this help", "double click"):
            assert line in text
        assert not terminal.picture()[:40].any()
        terminal.type("h")
        terminal.wait_for(lambda: terminal.picture()[:46].any(axis=(1, 2)).all())
        assert "forward" not in terminal.text()


def test_two_keys_at_once_and_both_come_up():
    with shown() as terminal:
        terminal.type("wa")
        terminal.wait_for(lambda: _rests(terminal))
        first = terminal.picture()
        assert _rests(terminal, 0.5)
        assert np.array_equal(terminal.picture(), first)


def _rests(terminal, seconds=0.4):
    before = terminal.picture()
    with contextlib.suppress(AssertionError):
        terminal.wait_for(lambda: not np.array_equal(terminal.picture(), before), seconds)
        return False
    return True


def test_a_mouse_drags_with_its_button_only_and_clicks():
    with shown() as terminal:
        terminal.wait_for(lambda: _rests(terminal))
        before = terminal.picture()
        for x in range(20, 40):
            terminal.type(f"\x1b[<35;{x};10M")
        assert _rests(terminal)
        assert np.array_equal(terminal.picture(), before)
        terminal.type("\x1b[<0;61;13M\x1b[<0;61;13m")
        terminal.wait_for(lambda: "quad, triangle" in terminal.text())
        terminal.type("\x1b[<0;30;10M" + "".join(f"\x1b[<32;{x};10M" for x in range(30, 40)) + "\x1b[<0;40;10m")
        terminal.wait_for(lambda: np.abs(terminal.picture()[:40].astype(int) - before[:40]).mean() > 1)
        terminal.type("r")
        terminal.wait_for(lambda: np.abs(terminal.picture()[:40].astype(int) - before[:40]).mean() < 1)
        terminal.type("\x1b[<0;61;13M\x1b[<0;61;13m" * 2)
        terminal.wait_for(lambda: "orbit around quad" in terminal.text())


def test_a_terminal_that_tells_when_keys_come_up():
    with shown(kind="kitty") as terminal:
        terminal.wait_for(lambda: _rests(terminal))
        terminal.type("\x1b[119;1:1;119u")
        terminal.wait_for(lambda: not _rests(terminal, 0.1))
        before = terminal.picture()
        terminal.wait_for(lambda: not np.array_equal(terminal.picture(), before))
        terminal.type("\x1b[119;1:3u")
        terminal.wait_for(lambda: _rests(terminal))
        terminal.type("\x1b[98;5:1u\x1b[98;5:3u")  # Ctrl-B is none of ours
        terminal.type("\x1b[98;1:1;98u\x1b[98;1:2;98u\x1b[98;1:3u")
        terminal.wait_for(lambda: "1 bounce\n" in terminal.text())
        terminal.type("\x1b[57441;2:1u\x1b[98;2:1;66u\x1b[57441;1:3u\x1b[98;1:3u")  # Shift goes up first
        terminal.wait_for(lambda: "0 bounces\n" in terminal.text())
        terminal.wait_for(lambda: _rests(terminal))
        terminal.type("\x1b[99;5:1u")
        assert terminal.end() == 0
        _is_restored(terminal)


def test_the_window_changes_its_size():
    with shown() as terminal:
        for size in ((80, 30), (60, 30), (100, 40), (7, 3)):
            terminal.resize(*size)
            terminal.wait_for(lambda: terminal.picture()[:-4].any(axis=2).all())
            terminal.press("h")
            terminal.wait_for(lambda: not terminal.picture()[:4].any())
            terminal.press("h")
        terminal.type("\x03")
        assert terminal.end() == 0
        assert "Error" not in terminal.printed


def test_a_terminal_that_answers_nothing():
    with shown(kind="silent", environment={"BLESSED_QUERY_TIMEOUT_SECONDS": "0.2"}) as terminal:
        terminal.type("b")
        terminal.wait_for(lambda: "1 bounce\n" in terminal.text())


def test_terminated():
    with shown() as terminal:
        terminal.process.send_signal(signal.SIGTERM)
        assert terminal.end() == 0
        _is_restored(terminal)


def test_an_error_in_a_frame_restores_the_terminal_and_is_told():
    with shown("fail") as terminal:
        terminal.type("b")
        assert terminal.end() == 1
        _is_restored(terminal)
        assert "ZeroDivisionError: no such frame" in terminal.printed


def test_no_colours():
    terminal = Terminal([sys.executable, str(HERE / "terminal_app.py")], {**os.environ, "TERM": "vt100"})
    try:
        assert terminal.end() == 1
        assert "GlimtError: the terminal shows no colours (TERM=vt100); use --web" in terminal.printed
    finally:
        terminal.close()


def test_no_terminal(tmp_path):
    (tmp_path / "quad.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    result = subprocess.run([sys.executable, "-m", "glimt", "view", str(tmp_path / "quad.obj"), "--terminal"],
                            capture_output=True, text=True, timeout=30, check=False)
    assert result.returncode != 0
    assert "no terminal; use --web" in result.stderr
