"""Whole frames in steady state, each against the time that Embree needs for just their rays."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from glimt.bench.frame_scenes import ROWS, Missing, make_scene
from glimt.bench.measure import Tell, interleave_blocks, machine, milliseconds, processor_quotient, quotient
from glimt.bench.steady import SteadyFrames
from glimt.bench.yardstick import Yardstick
from glimt.scene.scene import Scene

_SWING_DEG = 1.0


def measure_row(name: str, scene: Scene, threads: tuple[int, ...], frames: int, rounds: int,
                tell: Tell = lambda text: None) -> list[dict[str, Any]]:
    """Return the row of a table for each number of threads.

    A row holds the frame's and the yardstick's times in ms, rays by kind, Mrays/s of the frame, and `ratio`, the
    frame's time through the yardstick's: the median over rounds, in which both were timed in turn. `processor_ratio` is
    the same of the processor time of all threads, which holds on a busy machine too. `speedup` is how many times as
    quick the frame is as with the first number of threads.
    """
    tell(f"{name}: Embree's trees, and its best way for each kind of ray")
    yardstick = Yardstick(scene)
    films = {count: SteadyFrames(scene, count, _SWING_DEG) for count in threads}
    with ThreadPoolExecutor(max(threads)) as pool:
        def embree(count: int) -> Callable[[], None]:
            return lambda: yardstick.trace(pool, count)

        tell(f"{name}: frames")
        runs: dict[str, Callable[[], None]] = {}
        for count in threads:
            runs |= {f"glimt {count}": films[count], f"embree {count}": embree(count)}
        blocks = interleave_blocks(runs, rounds, frames)
    settings, rays = scene.settings, films[threads[0]].counters
    common = {"row": name, "title": ROWS[name].title, "size": [settings.width, settings.height],
              "samples": settings.samples, "bounces": settings.max_bounces, "lights": len(scene.lights),
              "triangles": scene.placed_triangles(),
              "instances": len(scene.instances()), "spheres": len(scene.spheres()),
              "rays": {"primary": rays.primary, "shadow": rays.shadow, "mirror": rays.mirror},
              "yardstick": yardstick.describe(), "differing": yardstick.differing()}
    rows = []
    for count in threads:
        ours, theirs = blocks[f"glimt {count}"], blocks[f"embree {count}"]
        frame_ms = milliseconds(ours)
        rows.append({**common, "threads": count, "frames": sum(map(len, ours.seconds)), "frame_ms": frame_ms,
                     "embree_ms": milliseconds(theirs), "mrays": rays.rays / frame_ms["median"] / 1e3,
                     "ratio": quotient(ours, theirs), "processor_ratio": processor_quotient(ours, theirs),
                     "speedup": quotient(blocks[f"glimt {threads[0]}"], ours),
                     "embree_speedup": quotient(blocks[f"embree {threads[0]}"], theirs)})
    return rows


def measure(sources: dict[str, Any], missing: list[Missing], threads: tuple[int, ...], frames: int, rounds: int,
            quick: bool = False, tell: Tell = lambda text: None) -> dict[str, Any]:
    """Return the result of the rows whose files were found (see `find_sources`), to be written as JSON."""
    rows: list[dict[str, Any]] = []
    for name, paths in sources.items():
        rows += measure_row(name, make_scene(name, paths, quick=quick), threads, frames, rounds, tell)
    return {"benchmark": "frames", "version": 1, "machine": machine(), "rows": rows,
            "missing": [entry._asdict() for entry in missing]}
