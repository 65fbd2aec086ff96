"""The command line: one module a command. Exit codes: 0 done, 1 our error, 2 usage, 130 interrupted."""

import os
import sys

INTERRUPTED = 130
"""Exit code of a program that Ctrl-C ended, as shells have it: 128 + SIGINT."""


def main() -> None:
    """Run the command that `sys.argv` names, and end the process."""
    try:
        from glimt.cli.app import app  # after the try: Ctrl-C can come while modules are read
        app()
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        _leave_at_once()
    except SystemExit as end:
        if end.code == INTERRUPTED:
            _leave_at_once()
        raise


def _leave_at_once() -> None:
    """End the process without waiting for threads that are still inside a kernel."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(INTERRUPTED)
