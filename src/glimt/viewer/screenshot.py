"""Pictures of what is seen, at full quality, with the view that made them beside."""

import datetime
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from glimt.errors import GlimtError
from glimt.io.image import encode_png
from glimt.io.view_file import view_text

if TYPE_CHECKING:
    from glimt.viewer.viewer import Viewer


def save_screenshot(viewer: "Viewer") -> None:
    """Render the view at 4×4 samples a pixel and keep picture and view file; the next frame waits for it."""
    viewer.say("rendering a picture")
    viewer.jobs.append(lambda: _save(viewer))


def _save(viewer: "Viewer") -> None:
    now = datetime.datetime.now()
    name = f"{viewer.scene.name}-{now:%Y%m%d-%H%M%S}-{now.microsecond // 1000:03}"
    png = finest_png(viewer)
    note = (f"What {name}.png shows: `glimt render SCENE --view {name}.toml --output again.png`\n"
            f"makes the same picture of {viewer.scene.name} again.")
    scene = replace(viewer.scene, settings=replace(viewer.scene.settings, samples=viewer.film_samples))
    view = view_text(scene, viewer.time, note)
    try:
        where = viewer.keep({f"{name}.png": png, f"{name}.toml": view.encode()})
        viewer.say(f"saved {where}")
    except (OSError, GlimtError) as error:
        viewer.say(f"not saved: {error}")


def finest_png(viewer: "Viewer") -> bytes:
    """Return the picture at full quality as the bytes of a PNG file."""
    return encode_png(viewer.finest()[..., :3])


def keep_in(folder: Path, files: dict[str, bytes]) -> str:
    """Write files that are not there yet; return the path of the first."""
    for name, data in files.items():
        with open(folder / name, "xb") as file:
            file.write(data)
    return str(folder / next(iter(files)))
