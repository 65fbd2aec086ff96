"""Values of options that several commands have."""

import dataclasses
import math
import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from glimt.scene.scene import Scene


def parse_size(text: str) -> tuple[int, int]:
    """Return a size like 1920x1080 as (width, height)."""
    found = re.fullmatch(r"(\d{1,6})[x×](\d{1,6})", text)
    if not found:
        raise typer.BadParameter(f"{text!r} is not a size like 1920x1080", param_hint="'--size'")
    return int(found[1]), int(found[2])


def parse_samples(text: str) -> int | str:
    """Return a number of samples, or "adaptive"."""
    if text == "adaptive":
        return text
    try:
        return int(text)
    except ValueError:
        raise typer.BadParameter(f"{text!r} is neither a whole number nor 'adaptive'") from None


def parse_engine(text: str) -> str:
    """Return the name of an engine."""
    from glimt.engines.choice import ENGINES
    if text not in ENGINES:
        raise typer.BadParameter(f"{text!r} is none of {', '.join(ENGINES)}")
    return text


def parse_finite(text: str) -> float:
    """Return a number that is finite."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise typer.BadParameter(f"{text!r} is not a number")
    return value


def load_with_options(path: Path, view: Path | None, options: dict[str, Any]) -> "Scene":
    """Return a scene as a view file shows it, with what was given of the options, by names of RenderSettings."""
    from glimt.io import load
    scene = load(path)
    if view:
        from glimt.io.view_file import apply_view
        scene = apply_view(scene, view)
    given = {name: value for name, value in options.items() if value is not None}
    scene.settings = dataclasses.replace(scene.settings, **given)
    return scene


Engine = Annotated[str, typer.Option(parser=parse_engine, metavar="cpu|gpu|auto",
                                     help="What renders; 'auto' is a GPU where there is one, with glimt[gpu].")]
