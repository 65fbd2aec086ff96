"""``glimt info``: the machine as glimt sees it, or what a scene is made of."""

import dataclasses
import json
import os
import platform
from pathlib import Path
from typing import Annotated, Any

import typer

from glimt.cli.outcome import WarningLog, outcome
from glimt.cli.progress import ConsoleProgress

_FEATURES = ("sse4.2", "avx", "avx2", "fma", "avx512f", "avx512bw", "avx512dq", "avx512vl", "neon")


def info(
    scene: Annotated[Path | None, typer.Argument(metavar="SCENE", help="Scene file (.toml) or mesh (.obj).")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Show version, processor and kernel cache; with SCENE, what it is made of."""
    with outcome():
        facts = _machine() if scene is None else _scene(scene)
        if as_json:
            print(json.dumps(facts, indent=2))
            return
        for key, value in facts.items():
            print(f"{key.removesuffix('_bytes').replace('_', ' '):18}{_readable(key, value)}")


def _machine() -> dict[str, Any]:
    from importlib.metadata import version

    from glimt import __version__, kernel
    from glimt.engines.cpu.engine import available_threads
    from glimt.engines.cpu.kernels.frame import render_tiles
    folder = kernel.cache_folder()
    return {
        "glimt": __version__,
        "python": platform.python_version(),
        "numba": version("numba"),
        "processor": kernel.host_name(),
        "features": [name for name in _FEATURES if name in kernel.host_features()],
        "lanes": kernel.host_lanes(),
        "threads": available_threads(),
        "cache_folder": str(folder),
        "cache_bytes": _size(folder.parent),
        "kernels_compiled": kernel.is_ready(render_tiles),
    }


def _size(folder: Path) -> int:
    """Return the bytes of all files below `folder`; one that is deleted meanwhile counts nothing."""
    total = 0
    for parent, _, names in os.walk(folder):
        for name in names:
            try:
                total += os.stat(os.path.join(parent, name)).st_size
            except OSError:
                continue
    return total


def _scene(path: Path) -> dict[str, Any]:
    log = WarningLog()
    with log.collect(), ConsoleProgress() as progress:
        from glimt.io import load
        scene = load(path)
        from glimt.renderer import Renderer
        stats = Renderer(scene, progress=progress).stats()
    return {"scene": str(path), **dataclasses.asdict(stats), "warnings": log.count}


def _readable(key: str, value: Any) -> str:
    if key.endswith("_bytes"):
        return f"{value / 2**20:,.1f} MiB"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return f"{value:,}"
    if isinstance(value, float):
        return f"{value:,.4g}"
    return " ".join(value) if isinstance(value, list) else str(value)
