"""``glimt bench``: measure, and compare two measurements."""

from pathlib import Path
from typing import Annotated

import typer

from glimt.cli.outcome import outcome

bench = typer.Typer(help="Measure glimt against Embree.", no_args_is_help=True, rich_markup_mode=None)


@bench.command()
def rays(
    meshes: Annotated[list[Path], typer.Argument(metavar="MESH...", help="OBJ files.")],
    size: Annotated[int, typer.Option(min=16, max=4096, help="Side of the picture whose rays are traced.")] = 1024,
    threads: Annotated[list[int] | None, typer.Option(min=1, max=1024, help="Threads; give it twice for two.")] = None,
    rounds: Annotated[int, typer.Option(min=1, max=1000, help="How often everything is timed, in turn.")] = 5,
    json: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the result here.")] = None,
) -> None:
    """Measure rays a second by kind, interleaved with Embree on the same rays."""
    with outcome():
        from glimt.bench import rays as bench_rays
        from glimt.bench import results
        from glimt.io.obj import read_obj
        rows = []
        for path in meshes:
            mesh = read_obj(path)
            rows += bench_rays.measure_mesh(mesh, size, tuple(threads or [1]), rounds,
                                            lambda text: typer.echo(text, err=True))
        result = bench_rays.report(rows)
        if json:
            results.save(json, result)
        print(results.table(result))


@bench.command()
def compare(before: Annotated[Path, typer.Argument(metavar="BEFORE")],
            after: Annotated[Path, typer.Argument(metavar="AFTER")]) -> None:
    """Show how the ratios of two results differ."""
    with outcome():
        from glimt.bench import results
        print(results.compare(results.read(before), results.read(after)))
