"""The contract between scene and engines: flat arrays of 4-byte words."""

from glimt.packed.frame import light_rows, pack_light_rows, pack_lights, pack_view
from glimt.packed.pack import Packer, pack
from glimt.packed.packed_scene import PackedScene

__all__ = ["PackedScene", "Packer", "light_rows", "pack", "pack_light_rows", "pack_lights", "pack_view"]
