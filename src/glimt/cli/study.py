"""``glimt study``: what frame time depends on, as experiments that anyone can repeat."""

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from glimt.cli import INTERRUPTED
from glimt.cli.options import Engine
from glimt.cli.outcome import WarningLog, outcome
from glimt.cli.progress import ConsoleProgress, TimeLeft
from glimt.extras import need


def study(
    scene: Annotated[Path | None, typer.Argument(metavar="SCENE", help="Scene file (.toml) or mesh (.obj), by default "
                                                                       "the stone room.")] = None,
    output: Annotated[Path | None, typer.Option(
        "--output", "-o", metavar="DIR", help="Folder for report.html, results.json and the figures, by default "
                                              "study-SCENE here.")] = None,
    figures: Annotated[str | None, typer.Option(
        metavar="N,...", help="Some of 2 to 10: groups, pixels, bounces, lights, vertices, threads, instances, "
                              "samples, stages; by default all.")] = None,
    engine: Engine = "auto",
    threads: Annotated[int | None, typer.Option(min=1, max=1024, help="Threads, by default one for each core.")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="In under a minute: short series, wide intervals.")] = False,
    seconds: Annotated[float | None, typer.Option(
        min=0.1, max=86400, help="What measuring a figure may take; 25, 2 with --quick. Five rounds are timed in any "
                               "case.")] = None,
    brute_force: Annotated[bool, typer.Option(
        "--brute-force", help="Also without trees, as the paper did: every ray tests everything.")] = False,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the figures that DIR has not yet.")] = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Begin anew, whatever DIR holds.")] = False,
    compare: Annotated[tuple[Path, Path] | None, typer.Option(
        metavar="A B", help="Only put two results.json side by side, in a report.")] = None,
    schema: Annotated[bool, typer.Option("--schema", help="Only print the JSON schema of results.")] = False,
) -> None:
    """Measure what frame time depends on, one thing at a time, and write a report.

    Ctrl-C keeps what is done.
    """
    with outcome():
        if schema:
            from glimt.study.results import schema as schema_of_results
            print(schema_of_results(), end="")
        elif compare:
            _compare(*compare, output or Path("study-comparison"))
        else:
            _measure(scene, output, figures, engine, threads, quick, seconds, brute_force, resume, overwrite)


def _compare(before: Path, after: Path, folder: Path) -> None:
    from glimt.study.results import read
    output = need("glimt.study.output", "study")
    results = [read(before), read(after)]
    path = output.write_comparison(folder, list(zip(output.names_of(before, after), results, strict=True)))
    print(f"the report is {path}")


def _measure(scene: Path | None, folder: Path | None, figures: str | None, engine: str, threads: int | None,
             quick: bool, seconds: float | None, brute_force: bool, resume: bool, overwrite: bool) -> None:
    output = need("glimt.study.output", "study")  # before anything is measured
    from glimt.io.example import example_path
    from glimt.study.experiments import chosen_figures
    from glimt.study.run import QUICK_SECONDS, SECONDS, Order, run
    path = scene or example_path("stone_room.toml")
    folder = folder or Path(f"study-{path.stem}")
    order = Order(path, folder, chosen_figures(figures), engine, threads, quick, brute_force,
                  seconds or (QUICK_SECONDS if quick else SECONDS), resume, overwrite,
                  command=shlex.join(["glimt", *sys.argv[1:]]))
    with WarningLog().collect(), TimeLeft() as left, ConsoleProgress() as progress:
        from glimt.engines import begin_preparing
        begin_preparing(engine)
        result, complete = run(order, left, progress)
    if not result.figures:
        print("interrupted: nothing was measured yet", file=sys.stderr)
        raise typer.Exit(INTERRUPTED)
    try:
        report = output.write_report(folder, result)
    except KeyboardInterrupt:
        print(f"interrupted: {folder} keeps the numbers; --resume writes the report", file=sys.stderr)
        raise typer.Exit(INTERRUPTED) from None
    for figure in result.figures:
        for note in figure.notes:
            print(f"figure {figure.number}: left out: {note}")
        for series in figure.series:
            print(f"figure {figure.number}, {series.name}: {series.verdict}")
    print(f"the report is {report}")
    if not complete:
        print(f"interrupted: {folder} keeps what is done; go on with --resume", file=sys.stderr)
        raise typer.Exit(INTERRUPTED)

