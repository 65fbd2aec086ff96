"""Materials as records."""

import numpy as np
from numpy.typing import NDArray

from glimt.layout import MATERIAL, dtype
from glimt.packed.frame import color
from glimt.packed.textures import TexturePacker
from glimt.scene.material import Material


def pack_materials(materials: list[Material], textures: TexturePacker) -> NDArray[np.float32]:
    """Return MATERIAL records, one that is never read for none; `textures` is told of the textures."""
    records = np.zeros(max(1, len(materials)), dtype(MATERIAL))
    if materials:
        for name in ("ambient", "diffuse", "specular"):
            records[name] = [color(f"material {each.name!r}", name, getattr(each, name)) for each in materials]
        for name in ("exponent", "reflectivity", "normal_scale"):
            records[name] = [getattr(each, name) for each in materials]
        for record, each in zip(records, materials, strict=True):
            record["diffuse_texture"] = textures.add(each.diffuse_texture, "color")
            record["normal_texture"] = textures.add(each.normal_texture, "data")
    return records.view(np.float32)
