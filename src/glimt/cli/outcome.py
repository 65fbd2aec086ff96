"""How a command ends: errors of ours as one line, warnings counted, everything else untouched."""

import contextlib
import os
import sys
import warnings
from collections.abc import Iterator

import typer

from glimt.cli import INTERRUPTED
from glimt.errors import GlimtError, GlimtWarning


@contextlib.contextmanager
def outcome() -> Iterator[None]:
    """Turn what ends a command early into a line on stderr and an exit code."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")  # a console that has no × still gets the rest
    try:
        yield
        sys.stdout.flush()
    except GlimtError as error:
        _end(f"error: {error}", 1)
    except MemoryError:
        _end("error: not enough memory; choose a smaller picture or scene", 1)
    except KeyboardInterrupt:
        _end("interrupted", INTERRUPTED)
    except BrokenPipeError:
        # Whoever read our output has gone; Python would complain once more when it closes stdout.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise typer.Exit(1) from None


def _end(line: str, code: int) -> None:
    print(line, file=sys.stderr)
    raise typer.Exit(code)


class WarningLog:
    """Counts our warnings and prints each kind once.

    Attributes
    ----------
    kinds : list of (str, int)
        Text and count of each.
    """

    def __init__(self) -> None:
        self.kinds: list[tuple[str, int]] = []

    @property
    def count(self) -> int:
        """How often something was warned of."""
        return sum(count for _, count in self.kinds)

    @contextlib.contextmanager
    def collect(self) -> Iterator[None]:
        """Count and print the warnings that come up meanwhile; those that are not ours are passed on."""
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", GlimtWarning)
            try:
                yield
            finally:
                recorded = list(caught)
        for entry in recorded:
            if isinstance(entry.message, GlimtWarning):
                self.kinds.append((str(entry.message), entry.message.count))
                print(f"warning: {entry.message}", file=sys.stderr)
            else:
                warnings.warn_explicit(entry.message, entry.category, entry.filename, entry.lineno)
