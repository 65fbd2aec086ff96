"""docs/scene-format.md is held to the schema: every key with its type, default and meaning; and its example works."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from pydantic import BaseModel

from glimt.io import load, scene_schema

PAGE = Path(__file__).resolve().parents[2] / "docs" / "scene-format.md"

SECTIONS = {
    "`[render]`": (scene_schema.RenderTable, ()),
    "`[camera]`": (scene_schema.CameraTable, ()),
    "`[[material]]`": (scene_schema.MaterialTable, ()),
    "Texture table": (scene_schema.TextureTable, ()),
    "`[[mesh]]`": (scene_schema.MeshTable, ()),
    "`[[instance]]`": (scene_schema.InstanceTable, ()),
    "Rotation table": (scene_schema.RotationTable, ()),
    "`[[sphere]]`": (scene_schema.SphereTable, ()),
    "`[[light]]`": (scene_schema.LightTable, ()),
    '`type = "point"`': (scene_schema.PointLightTable, (scene_schema.LightTable,)),
    '`type = "spot"`': (scene_schema.SpotLightTable, (scene_schema.PointLightTable,)),
    '`type = "directional"`': (scene_schema.DirectionalLightTable, (scene_schema.LightTable,)),
    "Motion table": (scene_schema.MotionTable, ()),
    "Orbit table": (scene_schema.OrbitTable, ()),
    "Path table": (scene_schema.PathTable, ()),
}


def rows(model: type[BaseModel], described: tuple[type[BaseModel], ...]) -> list[str]:
    """What the page must say about the keys of a table, without those described for other tables."""
    schema = model.model_json_schema()
    known = {"type"}.union(*(other.model_fields for other in described)) if described else set()
    result = []
    for key, entry in schema["properties"].items():
        if key in known:
            continue
        kind = next((option["title"] for option in entry.get("anyOf", ()) if "title" in option), entry.get("title"))
        required = key in schema.get("required", ())
        default = "required" if required else "–" if entry["default"] is None else f"`{json.dumps(entry['default'])}`"
        result.append(f"| `{key}` | {kind} | {default} | {entry['description']} |")
    return result


@pytest.mark.parametrize("title", SECTIONS)
def test_each_key_is_documented_as_it_is(title: str) -> None:
    section = re.search(rf"^#+ {re.escape(title)}\n(.*?)(?=^#|\Z)", PAGE.read_text("utf-8"), re.DOTALL | re.MULTILINE)
    assert section, f"no section {title}"
    assert re.findall(r"^\| `.*$", section[1], re.MULTILINE) == rows(*SECTIONS[title])


def test_every_table_of_the_schema_has_a_section() -> None:
    documented = {model for model, _ in SECTIONS.values()}
    tables = {thing for name, thing in vars(scene_schema).items() if name.endswith("Table")
              and isinstance(thing, type) and issubclass(thing, BaseModel) and not name.startswith("_")}
    assert tables - documented == {scene_schema.Table, scene_schema.SceneTable}


def test_the_example_is_a_scene(tmp_path: Path) -> None:
    example = re.findall(r"^```toml\n(.*?)^```", PAGE.read_text("utf-8"), re.DOTALL | re.MULTILINE)[0]
    (tmp_path / "room.toml").write_text(example, "utf-8")
    (tmp_path / "block.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    for name in ("brick.png", "brick_normal.png"):
        Image.fromarray(np.full((4, 4, 3), 128, np.uint8)).save(tmp_path / name)
    scene = load(tmp_path / "room.toml")
    assert len(scene.spheres()) == 1
    assert len(scene.instances()) == 3
    assert [type(light).__name__ for light in scene.lights] == ["PointLight", "SpotLight", "DirectionalLight"]
