"""Write the example scenes with their meshes and textures: ``python examples/make_examples.py [folder]``.

The files are kept in the repository, so nobody has to run this to render them; a test runs it and compares.
"""

import sys
from pathlib import Path

from PIL import Image

import dahlia
import mirrors
import stone_room
from stones import HIGHLIGHTS, TEXTURES
from text_files import mtl_text, obj_text

SCENES = {"stone_room": stone_room, "instances": dahlia, "mirrors": mirrors}


def make_examples(folder: Path) -> None:
    """Write ``textures/``, ``meshes/`` and the scene files into `folder`, which is made when it is missing."""
    for part in ("textures", "meshes"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    for name, make in TEXTURES.items():
        texture = make()
        Image.fromarray(texture.color).save(folder / "textures" / f"{name}.png", optimize=True)
        Image.fromarray(texture.normal).save(folder / "textures" / f"{name}_normal.png", optimize=True)
    for module in SCENES.values():
        for name, patches in module.MESHES.items():
            _write(folder / "meshes" / f"{name}.obj", obj_text(patches, "stones.mtl"))
    _write(folder / "meshes" / "stones.mtl", mtl_text(HIGHLIGHTS))
    for name, module in SCENES.items():
        _write(folder / f"{name}.toml", module.scene())


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8", newline="\n")


if __name__ == "__main__":
    make_examples(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
