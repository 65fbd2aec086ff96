"""The stones of the example scenes: what each looks like, as a height field in metres and colours in sRGB."""

import numpy as np

from procedural import Field, Texture, courses, noise, normal_map, smoothstep, to_bytes

WALL_TILE = 4.0
"""Metres of wall that one copy of the wall texture covers; the others likewise."""
FLOOR_TILE = 4.0
PLASTER_TILE = 3.0
GRANITE_TILE = 1.0


def wall(size: int = 512) -> Texture:
    """Return rough-hewn sandstone blocks, about 0.4 m × 0.7 m, with sunken mortar."""
    rng = np.random.default_rng(1)
    blocks = courses(rng, size, WALL_TILE, 10, 6, corner=0.05, irregular=0.8, bond=True, wander=0.008)
    count = blocks.block.max() + 1
    lumps, grain, stain = noise(rng, size, 1.6, 8, 90), noise(rng, size, 0.8, 40, 160), noise(rng, size, 1.4, 2, 60)
    edge = blocks.edge + 0.006 * lumps  # chipped
    face = np.sqrt(smoothstep(0.008, 0.07, edge))  # a steep flank, then a rounded shoulder
    lift, lean, tip = (rng.random(count)[blocks.block] - 0.5 for _ in range(3))
    height = (0.030 * face + face * (0.012 * lift + 0.030 * lean * blocks.across + 0.024 * tip * blocks.along)
              + 0.0048 * lumps * face + 0.0007 * grain)
    warm, dark = rng.random(count)[blocks.block], rng.random(count)[blocks.block]
    stone = mix(mix((0.66, 0.62, 0.56), (0.71, 0.60, 0.47), warm), (0.50, 0.48, 0.47), dark**3)
    stone *= (1 + 0.18 * (rng.random(count)[blocks.block] - 0.5) + 0.05 * stain + 0.035 * grain)[..., None]
    mortar = np.array([0.50, 0.47, 0.42]) * (0.82 + 0.04 * grain + 0.04 * stain)[..., None]
    return Texture(to_bytes(mix(mortar, stone, smoothstep(0.1, 0.6, face))), normal_map(height, WALL_TILE), height)


def floor(size: int = 512) -> Texture:
    """Return worn flags of pale limestone and dark slate, 1 m × 1 m, chequered."""
    rng = np.random.default_rng(2)
    blocks = courses(rng, size, FLOOR_TILE, 4, 4, corner=0.02, wander=0.0025)
    lumps, grain, stain = noise(rng, size, 1.8, 4, 50), noise(rng, size, 0.9, 40, 160), noise(rng, size, 1.5, 3, 80)
    face = np.sqrt(smoothstep(0.006, 0.045, blocks.edge + 0.0015 * lumps))
    lean, tip = (rng.random(16)[blocks.block] - 0.5 for _ in range(2))
    height = 0.010 * face + face * (0.007 * lean * blocks.across + 0.007 * tip * blocks.along)
    height += 0.0022 * lumps + 0.00035 * grain
    veins = np.exp(-((noise(rng, size, 1.7, 3, 90) / 0.06) ** 2))
    pale = np.array([0.70, 0.66, 0.59]) * (1 + 0.05 * stain + 0.03 * grain - 0.10 * veins)[..., None]
    slate = np.array([0.30, 0.32, 0.35]) * (1 + 0.07 * stain + 0.04 * grain + 0.25 * veins)[..., None]
    row, column = np.divmod(blocks.block, 4)
    flags = mix(slate, pale, ((row + column) % 2).astype(np.float64))
    flags *= (1 + 0.14 * (rng.random(16)[blocks.block] - 0.5))[..., None]
    joint = np.array([0.30, 0.28, 0.25]) * (1 + 0.08 * stain)[..., None]
    return Texture(to_bytes(mix(joint, flags, smoothstep(0.1, 0.7, face))), normal_map(height, FLOOR_TILE), height)


def plaster(size: int = 256) -> Texture:
    """Return trowelled lime plaster."""
    rng = np.random.default_rng(3)
    trowel, stain = noise(rng, size, 1.9, 3, 40), noise(rng, size, 1.6, 1, 40)
    height = 0.006 * trowel
    color = np.array([0.74, 0.70, 0.63]) * (1 + 0.025 * stain + 0.012 * trowel)[..., None]
    return Texture(to_bytes(color), normal_map(height, PLASTER_TILE), height)


def granite(size: int = 256) -> Texture:
    """Return pitted, speckled granite."""
    rng = np.random.default_rng(4)
    swell, grain, specks = noise(rng, size, 1.6, 3, 30), noise(rng, size, 0.7, 14, 60), noise(rng, size, 0.4, 20, 70)
    height = 0.0018 * swell + 0.0010 * grain - 0.003 * smoothstep(1.2, 2.4, grain)
    color = np.array([0.58, 0.57, 0.56]) * (1 + 0.05 * swell + 0.06 * grain)[..., None]
    color = mix(color, (0.74, 0.69, 0.64), 0.6 * smoothstep(1.0, 1.8, specks))
    color = mix(color, (0.28, 0.28, 0.30), 0.7 * smoothstep(1.0, 1.8, -specks))
    return Texture(to_bytes(color), normal_map(height, GRANITE_TILE), height)


TEXTURES = {"wall": wall, "floor": floor, "plaster": plaster, "granite": granite}
HIGHLIGHTS = {"wall": (0.05, 12), "floor": (0.30, 60), "plaster": (0, 1), "granite": (0.18, 40)}
"""Specular colour and exponent of each stone."""


def mix(a: Field | tuple[float, ...], b: Field | tuple[float, ...], share: Field) -> Field:
    """Return (size, size, 3) colours: `a` where `share` (size, size) is 0, `b` where it is 1."""
    return np.asarray(a) * (1 - share[..., None]) + np.asarray(b) * share[..., None]
