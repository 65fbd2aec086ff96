"""``glimt info``: the machine as glimt sees it, or what a scene is made of."""

import dataclasses
import json
import os
import platform
from pathlib import Path
from typing import Annotated, Any

import typer

from glimt.cli.options import Engine
from glimt.cli.outcome import WarningLog, outcome
from glimt.cli.progress import ConsoleProgress
from glimt.errors import GlimtError

_FEATURES = ("sse4.2", "avx", "avx2", "fma", "avx512f", "avx512bw", "avx512dq", "avx512vl", "neon")


def info(
    scene: Annotated[Path | None, typer.Argument(metavar="SCENE", help="Scene file (.toml) or mesh (.obj).")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    engine: Engine = "auto",
) -> None:
    """Show version, processor, kernel cache, and what would render; with SCENE, what it is made of."""
    with outcome():
        facts = _machine(engine) if scene is None else _scene(scene)
        if as_json:
            print(json.dumps(facts, indent=2))
            return
        for key, value in facts.items():
            print(f"{key.removesuffix('_bytes').replace('_', ' '):18}{_readable(key, value)}")


def _machine(engine: str) -> dict[str, Any]:
    from importlib.metadata import version

    from glimt import __version__, kernel
    from glimt.engines import choose_engine
    from glimt.engines.cpu.engine import available_threads
    from glimt.engines.cpu.kernels.frame import render_tiles
    folder, chosen = kernel.cache_folder(), choose_engine(engine)
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
        "engine": chosen.engine,
        "reason": chosen.reason,
        "adapters": _adapters(),
    }


def _adapters() -> list[str]:
    """Return what the GPU engine could run on; nothing when wgpu is not there, or cannot be loaded."""
    from glimt.engines.gpu.adapters import list_adapters
    try:
        return [found.summary for found in list_adapters()]
    except GlimtError:
        return []


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
        stats = Renderer(scene, engine="cpu", progress=progress).stats()
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
    if isinstance(value, list):
        return (", " if key == "adapters" else " ").join(value)
    return str(value)
