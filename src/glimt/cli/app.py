"""The command line's commands."""

from typing import Annotated

import typer

from glimt import __version__
from glimt.cli.bench import bench
from glimt.cli.info import info
from glimt.cli.render import render
from glimt.cli.study import study
from glimt.cli.view import view

# Without markup and pretty tracebacks Typer has no use for Rich, whose import takes longer than a small picture.
app = typer.Typer(add_completion=False, no_args_is_help=True, rich_markup_mode=None, pretty_exceptions_enable=False,
                  context_settings={"help_option_names": ["-h", "--help"]})
app.command()(render)
app.command()(view)
app.command()(info)
app.command()(study)
app.add_typer(bench, name="bench")


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"glimt {__version__}")
        raise typer.Exit()


@app.callback()
def glimt(version: Annotated[bool, typer.Option("--version", callback=_print_version, is_eager=True,
                                                help="Print the version and exit.")] = False) -> None:
    """Real-time ray tracing on the CPU."""
    del version
