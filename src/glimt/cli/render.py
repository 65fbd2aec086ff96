"""``glimt render``: a scene to an image file."""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from glimt.cli.options import Engine, load_with_options, parse_finite, parse_samples, parse_size
from glimt.cli.outcome import WarningLog, outcome
from glimt.cli.progress import ConsoleProgress
from glimt.errors import GlimtError

if TYPE_CHECKING:
    from glimt.film import Film
    from glimt.scene.scene import RenderSettings, Scene


def render(
    scene: Annotated[Path, typer.Argument(metavar="SCENE", help="Scene file (.toml) or mesh (.obj).")],
    output: Annotated[Path | None, typer.Option(
        "--output", "-o", metavar="FILE", help="Image to write, by default SCENE's name with .png, here.")] = None,
    size: Annotated[str | None, typer.Option(metavar="WIDTHxHEIGHT", help="Size of the picture in pixels.")] = None,
    samples: Annotated[Any, typer.Option(
        parser=parse_samples, metavar="N",
        help="n gives a grid of n×n samples a pixel; 'adaptive' as many as it needs.")] = None,
    bounces: Annotated[int | None, typer.Option(help="Mirror bounces; 0 shows no mirror.")] = None,
    threads: Annotated[int | None, typer.Option(
        min=1, max=1024, help="Threads to use, by default one for each processor core.")] = None,
    engine: Engine = "cpu",
    time: Annotated[float, typer.Option(
        parser=parse_finite, metavar="SECONDS", help="Moment that moving lights are shown at.")] = 0.0,
    exposure: Annotated[float | None, typer.Option(
        parser=parse_finite, metavar="STOPS", help="1 doubles the light, -1 halves it.")] = None,
    view: Annotated[Path | None, typer.Option(
        metavar="FILE", help="View file, as the viewer saves with a picture: its camera, lights and settings.")] = None,
) -> None:
    """Render SCENE to an image file. Options take the place of what the scene or view file says."""
    width, height = parse_size(size) if size else (None, None)
    overrides = {"width": width, "height": height, "samples": samples, "max_bounces": bounces, "exposure": exposure}
    with outcome():
        output = output or Path(scene.stem + ".png")
        _check_output(output)
        log = WarningLog()
        with log.collect(), ConsoleProgress() as progress:
            from glimt.engines import begin_preparing
            begin_preparing(engine)
            loaded = load_with_options(scene, view, overrides)
            film = _trace(loaded, threads, engine, time, progress)
        from glimt.io.image import save_image
        save_image(output, film.image(loaded.settings.exposure, loaded.settings.tone_curve))
        print(_summary(output, loaded.settings, film, log))


def _trace(scene: "Scene", threads: int | None, engine: str, time: float, progress: ConsoleProgress) -> "Film":
    from glimt.renderer import Renderer
    return Renderer(scene, threads=threads, engine=engine, progress=progress).render(time, progress)


def _check_output(path: Path) -> None:
    """Refuse what could not be written, before anybody waits for the picture."""
    from glimt.io.image import WRITABLE
    if path.suffix.lower() not in WRITABLE:
        raise GlimtError(f"{path}: cannot tell the format from {path.suffix!r}, use one of {', '.join(WRITABLE)}")
    if path.is_dir():
        raise GlimtError(f"{path}: is a folder; name a file in it")
    if not path.parent.is_dir():
        raise GlimtError(f"{path}: there is no folder {path.parent}; create it")
    if not os.access(path.parent, os.W_OK):
        raise GlimtError(f"{path}: the folder {path.parent} cannot be written to")


def _summary(output: Path, settings: "RenderSettings", film: "Film", log: WarningLog) -> str:
    rays, seconds = film.counters.rays, film.seconds
    line = (f"{output}: {settings.width}×{settings.height}, {_count(rays)} rays in {seconds:.2f} s, "
            f"{rays / max(seconds, 1e-9) / 1e6:.1f} Mrays/s, {log.count} warning{'' if log.count == 1 else 's'}")
    lost = film.counters.non_finite
    return line + (f", {lost:,} non-finite samples dropped" if lost else "")


def _count(value: int) -> str:
    for factor, prefix in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if value >= factor:
            return f"{value / factor:.1f} {prefix}"
    return str(value)
