"""The command as a process: exit codes, signals, pipes, and what a start imports."""

import os
import pty
import select
import signal
import subprocess
import sys

import glimt

COMMAND = [sys.executable, "-m", "glimt"]


def run(*arguments: str, **options) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*COMMAND, *arguments], capture_output=True, text=True, encoding="utf-8", timeout=600,
                          **options)


def test_exit_codes_of_the_process(ball, tmp_path):
    done = run("render", "ball.toml", cwd=tmp_path)
    assert (done.returncode, done.stdout[:9]) == (0, "ball.png:")
    assert (tmp_path / "ball.png").is_file()
    error = run("render", "nix.toml", cwd=tmp_path)
    assert (error.returncode, error.stdout, error.stderr) == (1, "", "error: nix.toml: no such file\n")
    assert run("rendr").returncode == 2


def test_a_console_without_the_times_sign(ball, tmp_path):
    done = subprocess.run([*COMMAND, "render", "ball.toml"], cwd=tmp_path, capture_output=True, timeout=600,
                          env={**os.environ, "PYTHONIOENCODING": "ascii"})
    assert done.returncode == 0
    assert done.stdout.startswith(b"ball.png: 24?16, ")


def test_a_reader_that_goes_away_is_no_traceback():
    reading, writing = os.pipe()
    os.close(reading)
    ended = subprocess.run([*COMMAND, "info"], stdout=writing, stderr=subprocess.PIPE, timeout=600)
    os.close(writing)
    assert (ended.returncode, ended.stderr) == (1, b"")


def test_ctrl_c_while_rendering(ball, tmp_path):
    """The render would take minutes; a terminal shows its bar, which says when it has begun."""
    terminal, theirs = pty.openpty()
    process = subprocess.Popen([*COMMAND, "render", "ball.toml", "--size", "4096x4096", "--samples", "64"],
                               cwd=tmp_path, stdout=subprocess.PIPE, stderr=theirs, env={**os.environ, "TERM": "xterm"})
    try:
        shown = b""
        while b"rendering" not in shown:
            assert select.select([terminal], [], [], 600)[0], shown
            shown += os.read(terminal, 4096)
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=60)
        while select.select([terminal], [], [], 1)[0]:  # all that it wrote; its end stays open, or some might be lost
            shown += os.read(terminal, 4096)
    finally:
        process.kill()
        os.close(theirs)
        os.close(terminal)
    assert b"interrupted" in shown
    assert process.returncode == 130
    assert out == b""
    assert b"Traceback" not in shown
    assert [path.name for path in tmp_path.iterdir()] == ["ball.toml"]


def test_help_and_version_import_nothing_heavy():
    script = ("import sys\nsys.argv = ['glimt', sys.argv[1]]\nfrom glimt.cli.app import app\n"
              "try: app()\nexcept SystemExit: pass\n"
              "print([name for name in ('numba', 'numpy', 'PIL', 'pydantic', 'rich') if name in sys.modules])\n")
    for option in ("--help", "--version"):
        done = subprocess.run([sys.executable, "-c", script, option], capture_output=True, text=True, timeout=600)
        assert done.stdout.splitlines()[-1] == "[]", done.stderr


def test_version_of_the_process():
    assert run("--version").stdout == f"glimt {glimt.__version__}\n"
