"""A flight through a scene as the viewer makes it: whether the governor keeps the budget, and the picture its size."""

import math
import time
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from glimt.bench.frame_scenes import ring_of_lights
from glimt.bench.measure import Tell, machine
from glimt.errors import GlimtError
from glimt.scene.scene import Scene
from glimt.viewer.viewer import Viewer

LATE = 1.5
"""Budgets a frame may take before it counts as late."""
_LEG_SECONDS = 1.5
_TURN = 0.7


def measure(scene: Scene, size: tuple[int, int], bounces: int, lights: int | None, seconds: float, budget: float,
            threads: int | None, engine: str = "auto", tell: Tell = lambda text: None) -> dict[str, Any]:
    """Return what a flight of some seconds gave, to be written as JSON; `lights`: instead of the scene's own.

    The camera turns all the time and walks to and fro, by the keys and the pointer of the viewer's own controls. A
    frame's time is that from events to the picture with its overlay, as it is handed to a window. `ratio`: the frame
    time that 95 of 100 frames keep within, through the budget. `stage_ms`: the mean time of each stage in a picture,
    where the engine times them by itself, as a GPU does.
    """
    tell(f"flight: {seconds:g} s at {size[0]}×{size[1]}")
    lit = replace(scene, settings=replace(scene.settings, max_bounces=bounces),
                  lights=scene.lights if lights is None else ring_of_lights(scene, lights))
    viewer = Viewer(lit, budget=budget, threads=threads, engine=engine)
    viewer.resize(*size)
    viewer.overlay_level = 2
    computes = viewer.renderer.engine_name
    frames, stages = _fly(viewer, seconds)
    viewer.presenter.close()
    if viewer.renderer.engine_name != computes:
        raise GlimtError(f"{computes} failed during the flight: {viewer.message or 'the CPU took over'}")
    times, widths, ends = frames[:, 1], frames[:, 2], frames[:, 0]
    row = {
        "engine": computes, "size": f"{size[0]}x{size[1]}", "bounces": bounces, "lights": len(lit.lights),
        "threads": viewer.renderer.threads,
        "budget_ms": 1000 * budget, "seconds": seconds, "frames": len(frames), "fps": len(frames) / seconds,
        "p50_ms": 1000 * float(np.percentile(times, 50)), "p95_ms": 1000 * float(np.percentile(times, 95)),
        "longest_ms": 1000 * float(times.max()), "in_time": float((times <= LATE * budget).mean()),
        "scale": float(np.mean(widths)) / size[0], "changes": int((np.diff(widths) != 0).sum()),
        "most_changes_a_second": _most_changes(ends, widths), "ratio": float(np.percentile(times, 95)) / budget,
        "stage_ms": {stage: 1000 * total / len(frames) for stage, total in stages.items()}}
    return {"benchmark": "flight", "version": 1, "machine": machine(), "scene": scene.name, "rows": [row]}


def _fly(viewer: Viewer, seconds: float) -> tuple[NDArray[np.float64], dict[str, float]]:
    """Return of each frame when it ended, how long it took, and how wide it was rendered; and seconds of stages."""
    frames: list[tuple[float, float, int]] = []
    stages: dict[str, float] = {}
    start = end = time.perf_counter()
    held = ""
    while end - start < seconds:
        leg = int((end - start) / _LEG_SECONDS)
        wanted = "wdsa"[leg % 4]
        if wanted != held:
            for kind, key in (("key_up", held), ("key_down", wanted)):
                viewer.handle({"event_type": kind, "key": key, "modifiers": ()}, end)
            held = wanted
        viewer.motion.turn(_TURN * (frames[-1][1] if frames else 0.0), 0.1 * math.cos(end - start) / 60)
        before = end
        viewer.frame(before)
        end = time.perf_counter()
        frames.append((end - start, end - before, viewer.rendered_size[0]))
        for stage, taken in (viewer.film.stages if viewer.film else {}).items():
            stages[stage] = stages.get(stage, 0.0) + taken
    return np.array(frames), stages


def _most_changes(ends: NDArray[np.float64], widths: NDArray[np.float64]) -> int:
    """Return how often the size changed in the second in which it changed most."""
    changes = ends[1:][np.diff(widths) != 0]
    return max((int(((changes >= first) & (changes < first + 1)).sum()) for first in changes), default=0)
