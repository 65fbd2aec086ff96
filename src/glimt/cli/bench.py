"""``glimt bench``: measure, and compare two measurements."""

from pathlib import Path
from typing import Annotated, Any

import typer

from glimt.cli.options import Engine, parse_size
from glimt.cli.outcome import outcome

bench = typer.Typer(help="Measure glimt against Embree.", no_args_is_help=True, rich_markup_mode=None)

Threads = Annotated[list[int] | None, typer.Option(min=1, max=1024, help="Threads; give it twice for two.")]
Rounds = Annotated[int, typer.Option(min=1, max=1000, help="How often everything is timed, in turn.")]
Frames = Annotated[int, typer.Option(min=1, max=10_000, help="Frames timed in each round.")]
Json = Annotated[Path | None, typer.Option(metavar="FILE", help="Write the result here.")]
Into = Annotated[Path | None, typer.Option(metavar="FILE", help="Write the table here, between <!-- NAME --> and "
                                                                "<!-- /NAME -->, NAME being that of the command.")]
PaperScene = Annotated[Path | None, typer.Option(metavar="FILE", help="The paper's scene, by default the example "
                                                                      "stone_room.toml.")]


@bench.command()
def rays(
    meshes: Annotated[list[Path], typer.Argument(metavar="MESH...", help="OBJ files.")],
    size: Annotated[int, typer.Option(min=16, max=4096, help="Side of the picture whose rays are traced.")] = 1024,
    subdivide: Annotated[int, typer.Option(min=0, max=6, help="How often each triangle is cut into four.")] = 0,
    threads: Threads = None, rounds: Rounds = 5, json: Json = None, into: Into = None,
) -> None:
    """Measure rays a second by kind, interleaved with Embree on the same rays."""
    with outcome():
        from glimt.bench import rays as bench_rays
        from glimt.bench.mesh_sizes import subdivided
        from glimt.io.obj import read_obj
        rows = []
        for path in meshes:
            mesh = read_obj(path)
            for _ in range(subdivide):
                mesh = subdivided(mesh)
            rows += bench_rays.measure_mesh(mesh, size, tuple(threads or [1]), rounds, _tell)
        _finish(bench_rays.report(rows), json, into)


@bench.command()
def frames(
    models: Annotated[Path | None, typer.Option(
        metavar="FOLDER", help="Where stanford-bunny.obj, armadillo.obj and nefertiti.obj are, at any depth.")] = None,
    scene: PaperScene = None,
    rows: Annotated[str | None, typer.Option(
        metavar="NAME,...", help="Some of room, mirrors, hd, statues, instances; by default all.")] = None,
    threads: Threads = None, frames: Frames = 10, rounds: Rounds = 5,
    first_image: Annotated[bool, typer.Option(help="Time whole processes to the first image as well.")] = True,
    quick: Annotated[bool, typer.Option(help="Small pictures: only to see that everything runs.")] = False,
    json: Json = None, into: Into = None,
) -> None:
    """Measure whole frames while the camera moves, each against Embree's time for just the frame's rays.

    Without --threads with one thread and with one for each processor.
    """
    with outcome():
        from glimt.bench import frames as bench_frames
        from glimt.bench.first_image import measure_first_image
        from glimt.bench.frame_scenes import chosen_rows, find_sources
        from glimt.engines.cpu.engine import available_threads
        paper = scene or _example()
        found, missing = find_sources(chosen_rows(rows), paper, models)
        for name, reason in missing:
            _tell(f"left out: {name}: {reason}")
        counts = tuple(sorted(set(threads or [1, available_threads()])))
        result = bench_frames.measure(found, missing, counts, frames, rounds, quick, _tell)
        if first_image:
            result["first_image"] = measure_first_image(paper, _tell)
        _finish(result, json, into)


@bench.command()
def growth(
    mesh: Annotated[Path, typer.Argument(metavar="MESH", help="OBJ file, best a closed one of 50,000 triangles or "
                                                              "more.")],
    scene: PaperScene = None,
    size: Annotated[int, typer.Option(min=16, max=4096, help="Side of the mesh's pictures.")] = 1024,
    threads: Annotated[int, typer.Option(min=1, max=1024, help="Threads.")] = 1,
    frames: Frames = 3, rounds: Rounds = 5,
    quick: Annotated[bool, typer.Option(help="Short series: only to see that everything runs.")] = False,
    json: Json = None, into: Into = None,
) -> None:
    """Measure how a frame's time grows with triangles, instances, lights and bounces."""
    with outcome():
        from glimt.bench import growth as bench_growth
        from glimt.io import load
        from glimt.io.obj import read_obj
        limits = bench_growth.Limits(100, 2000, 10) if quick else bench_growth.Limits()
        _finish(bench_growth.measure(read_obj(mesh), load(scene or _example()), size, threads, frames, rounds, limits,
                                     _tell), json, into)


@bench.command()
def flight(
    scene: PaperScene = None,
    size: Annotated[str, typer.Option(metavar="WIDTHxHEIGHT", help="Size of the canvas.")] = "1280x720",
    bounces: Annotated[int, typer.Option(min=0, max=64, help="Mirror bounces.")] = 3,
    lights: Annotated[int, typer.Option(min=0, max=64, help="Point lights instead of the scene's own.")] = 8,
    own_lights: Annotated[bool, typer.Option("--own-lights", help="Keep the scene's own lights.")] = False,
    seconds: Annotated[float, typer.Option(min=0.5, max=3600, help="How long.")] = 20.0,
    budget: Annotated[float, typer.Option(min=1, max=10000, metavar="MS", help="Milliseconds for a frame.")] = 33.0,
    threads: Annotated[int | None, typer.Option(min=1, max=1024, help="Threads.")] = None,
    engine: Engine = "auto",
    json: Json = None, into: Into = None,
) -> None:
    """Fly through a scene as the viewer does, and see whether frames keep within their budget."""
    with outcome():
        from glimt.bench import flight as bench_flight
        from glimt.io import load
        _finish(bench_flight.measure(load(scene or _example()), parse_size(size), bounces,
                                     None if own_lights else lights, seconds, budget / 1000, threads, engine,
                                     _tell), json, into)


@bench.command()
def compare(before: Annotated[Path, typer.Argument(metavar="BEFORE")],
            after: Annotated[Path, typer.Argument(metavar="AFTER")]) -> None:
    """Show how the ratios of two results differ."""
    with outcome():
        from glimt.bench import results
        print(results.compare(results.read(before), results.read(after)))


def _example() -> Path:
    """Return the paper's scene, which every installation has."""
    from glimt.io.example import example_path
    return example_path("stone_room.toml")


def _tell(text: str) -> None:
    typer.echo(text, err=True)


def _finish(result: dict[str, Any], json: Path | None, into: Path | None) -> None:
    """Print a result's table, and write what is asked for."""
    from glimt.bench import results, tables
    text = tables.table(result)
    print(text)
    if json:
        results.save(json, result)
    if into:
        tables.write_into(into, result["benchmark"], text)
