"""Meshes, materials and scenes as the text of OBJ, MTL and TOML files."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

from shapes import Patch

SINGLE_TABLES = ("render", "camera")


def number(value: float) -> str:
    """Return a number with as few of five decimals as it needs; never "-0"."""
    text = f"{value:.5f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def obj_text(patches: Sequence[Patch], library: str) -> str:
    """Return patches as the text of an OBJ file whose materials are in `library`; material "" is none."""
    materials = {patch.material for patch in patches} - {""}
    lines, first, material = [f"mtllib {library}"] if materials else [], 1, ""
    for patch in patches:
        for keyword, rows in (("v", patch.positions), ("vt", patch.texcoords), ("vn", patch.normals)):
            lines += [f"{keyword} " + " ".join(number(x) for x in row) for row in rows]
        if patch.material != material:
            material = patch.material
            lines.append(f"usemtl {material}")
        lines += ["f " + " ".join(f"{i}/{i}/{i}" for i in polygon + first) for polygon in patch.polygons]
        first += len(patch.positions)
    return "\n".join(lines) + "\n"


def mtl_text(highlights: Mapping[str, tuple[float, float]]) -> str:
    """Return a material library; `highlights` has the specular colour and exponent of each textured material."""
    return "\n".join(f"newmtl {name}\nKa 1 1 1\nKd 1 1 1\nKs {ks:g} {ks:g} {ks:g}\nNs {ns:g}\nillum 2\n"
                     f"map_Kd ../textures/{name}.png\nnorm ../textures/{name}_normal.png\n"
                     for name, (ks, ns) in highlights.items())


def table(kind: str, comment: str = "", **keys: Any) -> str:
    """Return one table of a scene file, ``[camera]`` or ``[[sphere]]``, below a blank line and a comment."""
    header = f"[{kind}]" if kind in SINGLE_TABLES else f"[[{kind}]]"
    lines = [f"\n# {comment}\n"] if comment else [""]
    return "\n".join([*lines, header, *(f"{key} = {_value(value)}" for key, value in keys.items())]) + "\n"


def _value(value: Any) -> str:
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_value(part)}" for key, part in value.items()) + " }"
    if isinstance(value, Sequence):
        return "[" + ", ".join(_value(part) for part in value) + "]"
    return number(value)


def turn(axis: Sequence[float], angle_deg: float) -> dict[str, Any]:
    """Return one entry of an instance's `rotate`."""
    return {"axis": axis, "angle_deg": angle_deg}
