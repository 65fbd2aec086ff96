"""Every struct and constant that two places share, declared once.

A struct's fields are given in memory order, in 4-byte words, without gaps. From that come the word offsets that
kernels use (``MATERIAL.diffuse``, ``MATERIAL.words``) and the NumPy dtype that the packer fills
(``dtype(MATERIAL)``): a kernel never writes a number for an offset.
"""

from collections import namedtuple
from typing import Any

import numpy as np
from numpy.typing import NDArray

_DTYPES: dict[str, np.dtype[Any]] = {}


def _struct(name: str, **fields: str) -> Any:
    """Declare a struct; a field is "f" or "i", with a count in front when it is more than one word ("3f")."""
    offsets, formats, offset = [], [], 0
    for spec in fields.values():
        count = int(spec[:-1] or 1)
        offsets.append(offset)
        formats.append((spec[-1] + "4", (count,)) if count > 1 else spec[-1] + "4")
        offset += count
    _DTYPES[name] = np.dtype(list(zip(fields, formats, strict=True)))
    make: Any = namedtuple  # mypy wants literal names
    return make(name, [*fields, "words"])(*offsets, offset)


def dtype(struct: Any) -> np.dtype[Any]:
    """Return the NumPy dtype of a struct declared here."""
    return _DTYPES[type(struct).__name__]


def aligned(words: int, dtype: Any = np.float32) -> NDArray[Any]:
    """Return an uninitialised array of 4-byte words that starts on a cache line: 16 lanes are then never in two."""
    raw = np.empty(words * 4 + 64, np.uint8)
    start = -raw.ctypes.data % 64
    return raw[start:start + words * 4].view(dtype)


def aligned_copy(words: NDArray[Any]) -> NDArray[Any]:
    """Return a copy that starts on a cache line, as all rows of it do where they are a multiple of 16 words."""
    copy = aligned(words.size, words.dtype).reshape(words.shape)
    copy[...] = words
    return copy


NODE = _struct("Node", lo_x="8f", lo_y="8f", lo_z="8f", hi_x="8f", hi_y="8f", hi_z="8f", child="8i", order="8i")
"""Eight children of a tree: box by box side, then what each is. A child >= 0 is another node; below 0 it is a leaf,
``~(block * LEAF_STEP + count)``. An unused child has an empty box. `order` has the children's numbers for each octant,
bit a of which is set for rays that go down axis a: the farthest child first, in the lowest of four bits each."""

BOTH_X, BOTH_Y, BOTH_Z = (np.int64(lo + hi) for lo, hi in ((NODE.lo_x, NODE.hi_x), (NODE.lo_y, NODE.hi_y),
                                                           (NODE.lo_z, NODE.hi_z)))
"""The offset of one plane of a pair minus this is the offset of the other."""

BOX_SLACK = np.float32(1 + 2.0**-20)
"""A box is visited when it starts up to this factor behind what was found: never missed by rounding."""

COMPRESSED_NODE = _struct("CompressedNode", origin="3f", exponents="i", child_base="i", block_base="i", meta="2i",
                          lo_x="2i", lo_y="2i", lo_z="2i", hi_x="2i", hi_y="2i", hi_z="2i")
"""Eight children of a tree in 80 bytes, for engines that wait for memory more than they compute.

A plane is ``origin + byte * 2**exponent``: bytes of `lo_x` to `hi_z`, one a slot, slot 0 lowest; signed exponents of x,
y and z in the low three bytes of `exponents`. Its highest byte has a bit for each slot whose child is another node.
A byte of `meta` for each slot says what is there, so that its low six bits are all that is to be added:

- ``INNER_META | rank``: the node ``child_base + rank``
- ``LEAF_META | rank * LEAF_STEP + count``: the leaf ``block_base * LEAF_STEP + (rank * LEAF_STEP + count)``
- 0: nothing. The box is inside out; a ray that meets it by its margin of error finds a leaf of no triangles.

Ranks count in slot order. Slots are the corners of a box, bit a set at its far end of axis a: in order of ``slot ^
octant``, where bit a of `octant` is set for a ray that goes down axis a, children come about from front to back."""

INNER_META, LEAF_META = np.int32(0x40), np.int32(0x80)

TRIANGLE_BLOCK = _struct("TriangleBlock", x0="4f", y0="4f", z0="4f", x1="4f", y1="4f", z1="4f", x2="4f", y2="4f",
                         z2="4f", prim="4i")
"""A leaf of a mesh's tree: corners of up to four triangles in object space, and their TRIANGLE records."""

INSTANCE_BLOCK = _struct("InstanceBlock", instance="4i")
"""A leaf of the scene's tree."""

VERTEX = _struct("Vertex", position="3f", normal="3f", texcoord="2f")
TANGENT = _struct("Tangent", tangent="3f", sign="f")
TRIANGLE = _struct("Triangle", vertex="3i", material="i")
"""Global indices of the corners and of the material."""

FACE = _struct("Face", number="i", clearance="i")
"""What else belongs to a TRIANGLE. Both are in the order of the tree's leaves, and vertices in that of the triangles:
what is seen side by side lies close together in memory.

`number`: which triangle of its mesh it is.

`clearance`: how far from the triangle nothing of its mesh is higher above it than each of CLEAR_SINES: a byte b for
each, the lowest elevation in the lowest, for ``2**(b // 8) * (1 + b % 8 / 8) - 1`` units; 255 for any distance, 0 for
not known."""

CLEAR_SINES = tuple(np.float32(sine) for sine in (0.15, 0.35, 0.55, 0.8))
CLEAR_SHIFT, CLEAR_BIAS = np.int32(20), np.int32(127 << 23)
"""A byte, shifted and biased, has the bits of the float that is a unit more than its distance."""

INSTANCE = _struct("Instance", kind="i", root="i", first_triangle="i", material="i", tangent_shift="i", flat="i",
                   untextured="i", identity="i", extent="f", clear_unit="f", object_to_world="12f",
                   world_to_object="12f", center="3f", radius="f")
"""A placed mesh or a sphere. `root` is a child code, `material` -1 leaves the choice to the triangle,
`tangent_shift` turns a vertex index into a tangent index (NO_TANGENTS: there are none), `flat` is 1 for a mesh
without normals, `untextured` for one without texcoords, `identity` is 1 when both matrices change nothing, `extent` is
the size of the world box, `clear_unit` the length of a unit of clearances, below 0 where that is of the clockwise side
and 0 where it says nothing; `center` and `radius` are a sphere's."""

PLACEMENT = _struct("Placement", world_to_object="12f", inst="i", root="i", kind="i", unused="i")
"""What a ray on a GPU has to know of an instance: a leaf of the scene's tree there. The first four words of a sphere
are its center and radius."""

SPAN = _struct("Span", first_block="i", blocks="i")
"""The leaves of an instance's mesh, which lie side by side; none for a sphere."""

MATERIAL = _struct("Material", ambient="3f", diffuse="3f", specular="3f", exponent="f", reflectivity="f",
                   normal_scale="f", diffuse_texture="i", normal_texture="i", unused="2i")
TEXTURE = _struct("Texture", first_level="i", levels="i", clamp="i", unused="i", scale="2f", offset="2f")
LEVEL = _struct("Level", first_texel="i", width="i", height="i", unused="i")
"""One size of a mip-mapped texture; a texel is one word of 10:10:10 bits, red lowest. A row is stored as width + 1
texels, its first one again at the end, so that a texel and its right neighbour always lie side by side."""

LIGHT = _struct("Light", kind="i", position="3f", direction="3f", diffuse="3f", specular="3f", inverse_radius="f",
                attenuation="3f", cone_scale="f", cone_offset="f", unused="i")
"""`direction` points the way the light travels. Within the cone is ``clamp(cos * cone_scale + cone_offset)²``."""

VIEW = _struct("View", origin="3f", right="3f", up="3f", look="3f", spread="f", background="3f", ambient="3f",
               exposure="f", filmic="i")
"""What changes from frame to frame: the camera (right and up reach to the picture's edge at distance 1 along look,
`spread` is a pixel's width there), light from nowhere and light from everywhere, and how the film will be developed:
what radiance is multiplied by, and 1 for the filmic tone curve."""

FRAME = _struct("Frame", width="f", height="f", first_column="i", first_row="i", columns="i", rows="i", capacity="i",
                shift_x="f", shift_y="f", spread="f", sample="i", depth="i", max_bounces="i", half="i", light_count="i",
                scene_root="i", placements="i", instances="i", materials="i", textures="i", levels="i", lights="i",
                triangles="i", vertices="i", tangents="i", tints="i", spans="i", placement_count="i", shows="i",
                view="21f", unused="14f")
"""What one dispatch on a GPU is told: columns and rows of a picture of `width` by `height`, which sample and bounce,
which half of the paths is read, and where each kind of record begins in its buffer, in words. 256 bytes, as dynamic
offsets want it."""
PATH = _struct("Path", origin="3f", t="f", direction="3f", pixel="i", u="f", v="f", prim="i", inst="i", throughput="f",
               travelled="f", reflectivity="f", unused="i")
"""A ray on a GPU, and what it has hit. After shading: the mirror ray."""
COUNTER = _struct("Counter", shadow="i", non_finite="i", nodes="3i", blocks="3i", paths="i")
"""Counts of a GPU: shadow rays, samples that were not finite, nodes and triangle blocks visited by primary, shadow and
mirror rays; then paths by depth."""

MESH_KIND, SPHERE_KIND = np.int32(0), np.int32(1)
POINT_LIGHT, SPOT_LIGHT, DIRECTIONAL_LIGHT = np.int32(0), np.int32(1), np.int32(2)

WALK_OF_MANY, WALK_OF_ONE, WALK_WITHOUT_TREES = np.int32(0), np.int32(1), np.int32(2)
"""How a GPU finds what a ray hits: by the scene's tree, by that of the only instance, or by testing everything."""

MISS = np.int32(-1)
"""`inst` of a ray that left the scene (0xFFFFFFFF as unsigned)."""

NO_TANGENTS = np.int32(-(2**31))
LEAF_SIZE = np.int32(4)
LEAF_STEP = np.int32(8)

STACK_SIZE = 512
"""Entries of a traversal's stack; the builder keeps every tree shallow enough for it."""

TEXEL_BITS = np.int32(10)
TEXEL_MAX = np.int32(2**10 - 1)

OFFSET_ERROR = np.float32(32 * 2.0**-24)
"""A ray leaves a surface at this share of (|point| + size of the instance): about 10 times the rounding error of the
point and of the plane it came from, and invisible."""

COUNT_PRIMARY, COUNT_SHADOW, COUNT_MIRROR, COUNT_NON_FINITE = (np.int64(k) for k in range(4))
STAGES = ("create_rays", "intersect", "shade", "bounce", "resolve")
"""The five stages of a frame, in order."""
CREATE_RAYS, INTERSECT, SHADE, BOUNCE, RESOLVE = (np.int64(k) for k in range(5))
TIMES_STAGES, OWN_SHARE, FIRST_STAGE = np.int64(4), np.int64(5), np.int64(8)
COUNTER_STRIDE = np.int64(16)
"""Each thread counts in int64s of its own, two cache lines apart: rays by kind, and samples that were not finite; then
whether stages are to be timed, which share of the tiles it begins with, and the ticks of each stage."""

MOST_SAMPLES = 64
"""Samples along each side of a pixel."""
TILE = 16
"""Pixels along the side of a tile, the piece of a picture that a thread of the CPU takes at once where nobody says
otherwise."""
CANCEL, SHARES, TILE_SIDE, TOGETHER = (np.int64(k) for k in range(4))
FIRST_SHARE = SHARE_STRIDE = np.int64(16)
"""Places in the int64s that threads share: whether to stop, and how work is divided, into shares, by pixels along a
tile and packets that travel together; then how many tiles of each share are taken, two cache lines apart."""
