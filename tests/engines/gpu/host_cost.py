"""What a GPU frame costs the host: processor time of the calling thread, ms, median of frames with a moving camera.

    GLIMT_GPU=software python tests/engines/gpu/host_cost.py

To compare two versions, start one process for each with PYTHONPATH, and let them take turns: the machine drifts.
"""

import sys
import time
from pathlib import Path

import numpy as np

import glimt
from glimt.renderer import Renderer

STONE_ROOM = Path(__file__).resolve().parents[3] / "examples" / "stone_room.toml"


def cost(renderer: Renderer, bounces: int, frames: int) -> float:
    """Return the median, in ms."""
    scene, film, taken = renderer.scene, None, []
    scene.settings.max_bounces = bounces
    for number in range(frames):
        scene.camera.position = tuple(np.array(scene.camera.position) + 1e-4 * np.sin(number))
        start = time.thread_time()
        film = renderer.render(film=film)
        taken.append(time.thread_time() - start)
    return 1000 * float(np.median(taken))


def main(frames: int = 500) -> None:
    """Print it, without bounces and with three."""
    scene = glimt.load(STONE_ROOM)
    scene.settings.width, scene.settings.height, scene.settings.samples = 64, 48, 1
    renderer = Renderer(scene, engine="gpu")
    for bounces in (0, 3):
        cost(renderer, bounces, 50)
        print(f"{bounces} bounces: {cost(renderer, bounces, frames):.2f} ms")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
