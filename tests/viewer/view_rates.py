"""Frames a second of the window while the camera walks to and fro, as JSON: ``python tests/viewer/view_rates.py``.

On a display without a screen to wait for, at most 240 a second.
"""

import itertools
import json
import time

from view_client import STONE_ROOM, viewing
from xtest import Keyboard
from xvfb import xvfb

SECONDS = 6.0
STRIDE = 0.5


def rates(display, size, *arguments):
    """Return what is rendered and shown a second, and how large, while the camera walks; the lamp moves as well."""
    with viewing(display, STONE_ROOM, "--size", size, "--bounces", 2, "--max-fps", 240, *arguments) as view:
        keyboard = Keyboard(display.name)
        keys = itertools.cycle("ws")
        first = None
        for step in range(round((2 + SECONDS) / STRIDE)):  # the first two seconds are the governor's
            if step * STRIDE == 2:
                first, start = view.state(), time.perf_counter()
            key = next(keys)
            keyboard.send(key, True)
            time.sleep(STRIDE)
            keyboard.send(key, False)
        last, seconds = view.state(), time.perf_counter() - start
        shown = len({frame[1] for frame in view.ask(f"app.frames_since({start})")})
        keyboard.close()
        return {"size": size, "rendered_size": "{}x{}".format(*last["rendered_size"]), "lights": len(last["lights"]),
                "bounces": last["bounces"], "rendered_fps": round((last["rendered"] - first["rendered"]) / seconds, 1),
                "presented_fps": round(shown / seconds, 1), "p50_ms": round(1000 * last["p50"], 2),
                "p95_ms": round(1000 * last["p95"], 2)}


if __name__ == "__main__":
    with xvfb(1400, 900) as display:
        for size in ("400x400", "1280x720"):
            print(json.dumps(rates(display, size)), flush=True)
