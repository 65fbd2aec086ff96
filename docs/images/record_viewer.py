"""Records the pictures of the viewer in README.md and docs/viewer.md: `python docs/images/record_viewer.py`.

The viewer is driven by events as a window would, with a clock of its own, so the flight is the same on every machine.
The frame times in the overlay are this machine's.
"""

from collections.abc import Iterator
from pathlib import Path

from PIL import Image

import glimt
from glimt.viewer.viewer import Viewer

HERE = Path(__file__).parent
SCENE = HERE.parents[1] / "examples" / "stone_room.toml"
SIZE = (560, 350)
FRAME_SECONDS = 1 / 14
STEP_SECONDS = 1 / 56
"""The viewer makes four pictures for each that is kept, so that motion is as smooth as in a window."""
LARGEST_BYTES = 3_000_000

# (seconds, keys held meanwhile, keys pressed before)
FLIGHT = (
    (0.7, "", ""), (1.3, "w", ""), (0.6, "", "b"), (0.6, "", "b"), (1.2, "d", ""), (0.9, "", "l"), (1.3, "a", ""),
    (0.9, "", "l"), (1.0, "s", ""), (0.9, "", "c"), (0.9, "", "7"), (0.9, "", "0"), (0.5, "", "r"),
)
FUNCTION_KEYS = {"7": "F7", "0": "F1"}


class Recorder:
    """A viewer and its clock."""

    def __init__(self, size: tuple[int, int]) -> None:
        self.viewer = Viewer(glimt.load(SCENE))
        self.viewer.resize(*size)
        self.viewer.overlay_level = 2
        self.viewer.governor.size = lambda shown: shown  # whatever it takes
        self.now = 0.0

    def send(self, kind: str, key: str) -> None:
        """Press a key or let it go."""
        name = FUNCTION_KEYS.get(key, key)
        self.viewer.handle({"event_type": kind, "key": name, "modifiers": ()}, self.now)

    def run(self, seconds: float) -> Iterator[Image.Image]:
        """Yield a picture for each frame of the recording."""
        end = self.now + seconds
        while self.now < end - 1e-9:
            for _ in range(round(FRAME_SECONDS / STEP_SECONDS)):
                self.now += STEP_SECONDS
                picture = self.viewer.frame(self.now)
            if picture is None:
                picture = self.viewer.presenter.compose(self.viewer)
            yield Image.fromarray(picture[..., :3])


def record() -> list[Image.Image]:
    """Return the frames of the flight."""
    recorder, frames = Recorder(SIZE), []
    recorder.viewer.motion.speed *= 0.6
    for seconds, held, pressed in FLIGHT:
        for key in pressed:
            recorder.send("key_down", key)
            recorder.send("key_up", key)
        for key in held:
            recorder.send("key_down", key)
        frames += recorder.run(seconds)
        for key in held:
            recorder.send("key_up", key)
    return frames


def still() -> Image.Image:
    """Return the viewer at rest, with its numbers."""
    recorder = Recorder((1120, 630))
    for key in ("b", "b", "b", "l"):
        recorder.send("key_down", key)
    *_, last = recorder.run(2.0)
    recorder.send("key_down", "t")
    *_, last = recorder.run(4.0)
    return last


def debug_views() -> Image.Image:
    """Return three debug views side by side."""
    recorder, views = Recorder((373, 315)), []
    recorder.viewer.overlay_level = 0
    for key in ("l", "t"):
        recorder.send("key_down", key)
    for key in ("F7", "F2", "F8"):
        recorder.send("key_down", key)
        *_, last = recorder.run(3.0)
        views.append(last)
    whole = Image.new("RGB", (sum(view.width for view in views), views[0].height))
    for place, view in enumerate(views):
        whole.paste(view, (place * views[0].width, 0))
    return whole


def main() -> None:
    """Write all pictures."""
    still().save(HERE / "viewer.jpg", quality=88)
    debug_views().save(HERE / "viewer_debug.jpg", quality=88)
    frames = record()
    target = HERE / "viewer.webp"
    frames[0].save(target, save_all=True, append_images=frames[1:], duration=round(1000 * FRAME_SECONDS), loop=0,
                   quality=62, method=4)
    size = target.stat().st_size
    print(f"{target}: {len(frames)} frames, {size / 1e6:.2f} MB")
    if size > LARGEST_BYTES:
        raise SystemExit(f"more than {LARGEST_BYTES / 1e6:g} MB: lower the quality or the size")


if __name__ == "__main__":
    main()
