"""What the viewer knows of a frame, for showing it."""

from dataclasses import dataclass, field

from glimt.scene.scene import Samples


@dataclass(frozen=True)
class FrameInfo:
    """A frame and the state of the viewer beside it.

    Attributes
    ----------
    frame_seconds, p50, p95 : float
        Time of the last frame, and percentiles of the recent ones; 0 when there is none.
    rays : int
        Of the last frame.
    width, height, shown_width, shown_height : int
        Pixels that were rendered, and those of the canvas they are shown on.
    max_bounces, lights, triangles : int
    samples : int or "adaptive"
        Per pixel.
    budget : float
        Seconds that a frame may take.
    mode : str
        How the camera moves: "fly" or "orbit".
    debug_view : str or None
        What is shown in place of light, such as "normals".
    paused : bool
        Whether the scene's time stands still.
    engine : str
        What computes.
    stages : dict
        Seconds of the last frame by stage, where the engine times them apart.
    message, picked, error : str or None
        A notice of the moment; what was picked, in lines; what is wrong with the scene file.
    """

    frame_seconds: float
    p50: float
    p95: float
    rays: int
    width: int
    height: int
    shown_width: int
    shown_height: int
    max_bounces: int
    lights: int
    samples: Samples
    triangles: int
    mode: str
    budget: float = 1 / 30
    debug_view: str | None = None
    paused: bool = False
    engine: str = ""
    stages: dict[str, float] = field(default_factory=dict)
    message: str | None = None
    error: str | None = None
    picked: str | None = None


def samples_text(samples: Samples) -> str:
    """Return samples a pixel as they are shown: "adaptive", or "2×2"."""
    return samples if isinstance(samples, str) else f"{samples}×{samples}"
