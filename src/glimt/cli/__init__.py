"""The command line: one module a command. Exit codes: 0 done, 1 our error, 2 usage, 130 interrupted."""

import contextlib
import gc
import os
import sys

INTERRUPTED = 130
"""Exit code of a program that Ctrl-C ended, as shells have it: 128 + SIGINT."""


def main() -> None:
    """Run the command that `sys.argv` names, and end the process."""
    # What modules are made of lives until the end: looking for garbage in it is a tenth of the time of a small picture.
    gc.set_threshold(200_000)
    code = _run()
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError):  # whoever read it has gone
            stream.flush()
    # At once: Python would take longer to clear away Numba than a small picture takes to render, and it would wait
    # for threads that are still inside a kernel.
    os._exit(code)


def _run() -> int:
    try:
        from glimt.cli.app import app  # in here: Ctrl-C can come while modules are read
        app()
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 0
    return 0
