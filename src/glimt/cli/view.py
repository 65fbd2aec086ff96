"""``glimt view``: fly through a scene."""

from pathlib import Path
from typing import Annotated, Any

import typer

from glimt.cli.options import Engine, load_with_options, parse_samples, parse_size
from glimt.cli.outcome import WarningLog, outcome
from glimt.cli.progress import ConsoleProgress
from glimt.errors import GlimtError


def view(
    scene: Annotated[Path, typer.Argument(metavar="SCENE", help="Scene file (.toml) or mesh (.obj).")],
    web: Annotated[bool, typer.Option("--web", help="Serve a web page instead of opening a window.")] = False,
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port of the page, 0 for any that is free.")] = 0,
    host: Annotated[str, typer.Option(
        metavar="ADDRESS", help="Where the page can be reached: 0.0.0.0 from other machines too, with a token in the "
        "page's address.")] = "127.0.0.1",
    terminal: Annotated[bool, typer.Option("--terminal", help="Show it as characters in this terminal.")] = False,
    watch: Annotated[bool, typer.Option("--watch", help="Follow changes of the scene's files.")] = False,
    size: Annotated[str | None, typer.Option(metavar="WIDTHxHEIGHT", help="Size of the window.")] = None,
    budget: Annotated[float, typer.Option(
        min=1, max=10000, metavar="MS", help="Milliseconds a frame may take: while anything moves, the picture becomes "
        "smaller, never slower.")] = 33.0,
    max_fps: Annotated[float, typer.Option(min=1, max=1000, help="Frames a second, at most.")] = 120.0,
    samples: Annotated[Any, typer.Option(
        parser=parse_samples, metavar="N", help="n gives a grid of n×n samples a pixel, or 'adaptive'.")] = None,
    bounces: Annotated[int | None, typer.Option(help="Mirror bounces to begin with.")] = None,
    threads: Annotated[int | None, typer.Option(
        min=1, max=1024, help="Threads to use, by default one for each processor core.")] = None,
    engine: Engine = "auto",
    view: Annotated[Path | None, typer.Option(
        metavar="FILE", help="View file to begin with: its camera, lights and settings.")] = None,
) -> None:
    """Fly through SCENE. Press H for the keys."""
    window_size = parse_size(size) if size else None
    with outcome():
        if web and terminal:
            raise GlimtError("--web and --terminal: choose one of them")
        if not (web or terminal):
            from glimt.viewer.window.gl_window import check_display
            check_display()  # before kernels are compiled for nothing
        from glimt.engines import begin_preparing
        from glimt.io.files_read import recorded
        from glimt.viewer import show
        from glimt.viewer.session import Session
        begin_preparing(engine)
        with WarningLog().collect(), recorded() as files:
            loaded = load_with_options(scene, view, {"samples": samples, "max_bounces": bounces})
        with ConsoleProgress() as progress:
            session = Session(loaded, window_size, budget / 1000, max_fps, threads, progress,
                              scene if watch else None, files, Path.cwd(), engine)
            if web:
                show.in_browser(session, host, port, on_ready=lambda url: print(f"{url}\nCtrl-C ends it", flush=True))
            elif terminal:
                show.in_terminal(session)
            else:
                show.in_window(session)
