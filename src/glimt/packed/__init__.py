"""The contract between scene and engines: flat arrays of 4-byte words."""

from glimt.packed.pack import pack, pack_lights, pack_view
from glimt.packed.packed_scene import PackedScene

__all__ = ["PackedScene", "pack", "pack_lights", "pack_view"]
