"""The paper's scene: mirror spheres in a closed room of normal-mapped stone, a lamp and the sun."""

from shapes import Patch, block, gem, panel, prism
from stones import FLOOR_TILE, GRANITE_TILE, PLASTER_TILE, WALL_TILE
from text_files import table, turn

HALF_WIDTH, HEIGHT = 4.0, 4.0
# The skylight: its edges in x and z, and how high its sides reach above the ceiling.
LEFT, RIGHT, BACK, FRONT, CURB = 0.0, 3.2, -1.6, 3.4, 0.35
PEDESTAL_HEIGHT = 1.0


def room() -> list[Patch]:
    """Return a closed room of 8 m × 4 m × 8 m with one opening, a skylight of 3.2 m × 5 m in the ceiling."""
    w, h, depth = HALF_WIDTH, HEIGHT, FRONT - BACK
    return [
        panel("floor", (-w, 0, w), (2 * w, 0, 0), (0, 0, -w), FLOOR_TILE),
        panel("floor", (-w, 0, 0), (2 * w, 0, 0), (0, 0, -w), FLOOR_TILE),
        *(panel("wall", corner, side, (0, h, 0), WALL_TILE, offset) for corner, side, offset in [
            ((-w, 0, -w), (w, 0, 0), (0, 0)), ((0, 0, -w), (w, 0, 0), (1, 0)),
            ((-w, 0, w), (0, 0, -2 * w), (0.37, 0.3)),
            ((w, 0, -w), (0, 0, 2 * w), (0.71, 0.6)), ((w, 0, w), (-2 * w, 0, 0), (0.19, 0.8))]),
        # The ceiling around the skylight, then the skylight's four sides.
        *(panel("plaster", (x, h, z), (width, 0, 0), (0, 0, length), PLASTER_TILE, (x / PLASTER_TILE, z / PLASTER_TILE))
          for x, z, width, length in [(-w, -w, 2 * w, BACK + w), (-w, FRONT, 2 * w, w - FRONT),
                                      (-w, BACK, LEFT + w, depth), (RIGHT, BACK, w - RIGHT, depth)]),
        *(panel("plaster", (x, h, z), side, (0, CURB, 0), PLASTER_TILE) for x, z, side in [
            (LEFT, BACK, (RIGHT - LEFT, 0, 0)), (LEFT, FRONT, (0, 0, -depth)),
            (RIGHT, BACK, (0, 0, depth)), (RIGHT, FRONT, (LEFT - RIGHT, 0, 0))]),
    ]


def pedestal() -> list[Patch]:
    """Return an eight-sided pedestal, 1 m high."""
    profile = [(0.46, 0), (0.46, 0.14), (0.33, 0.24), (0.29, 0.80), (0.42, 0.88), (0.42, PEDESTAL_HEIGHT)]
    return prism("granite", profile, 8, GRANITE_TILE)


MESHES = {"room": room(), "pedestal": pedestal(), "block": block("granite", GRANITE_TILE), "gem": gem("")}


def scene() -> str:
    """Return the scene file."""
    return "".join((
        "# A closed room of normal-mapped stone: mirror spheres that mirror each other, a lamp that goes round under\n"
        "# the ceiling, and the sun through a barred skylight. 990 vertices (330 triangles), 400 x 400 pixels, as in\n"
        "# the paper; `--bounces 3` shows the mirrors.\n",
        table("render", size=[400, 400], samples=1, max_bounces=0, background=[0.50, 0.68, 0.95],
              ambient=[0.13, 0.14, 0.165]),
        table("camera", position=[2.7, 1.9, 3.5], target=[-0.55, 1.02, -1.6], fov_deg=50),
        _lights(), _materials(),
        table("mesh", "No instance names the room: it stands where it was modelled.", name="room",
              file="meshes/room.obj"),
        table("mesh", name="block", file="meshes/block.obj"),
        table("mesh", name="pedestal", file="meshes/pedestal.obj"),
        table("mesh", name="gem", file="meshes/gem.obj", material="emerald"),
        _skylight_bars(), _furniture()))


def _lights() -> str:
    orbit = {"center": [0, 3.25, 0], "axis": [0, 1, 0], "period": 12}
    return (table("light", name="sun", type="directional", direction=[-0.52, -1, -0.78], diffuse=[2.5, 2.3, 1.95])
            + table("light", name="lamp", type="point", position=[-2.1, 3.25, 0.7], radius=2.8,
                    diffuse=[1.9, 1.45, 0.95], motion={"orbit": orbit}))


def _materials() -> str:
    return (table("material", "Mirrors keep a little of their own colour, so that they are seen without bounces too.",
                  name="silver", diffuse=0.15, specular=0.8, exponent=300, reflectivity=0.85)
            + table("material", name="gold", diffuse=[0.60, 0.36, 0.08], specular=[1, 0.75, 0.35], exponent=150,
                    reflectivity=0.4)
            + table("material", name="lacquer", diffuse="#b01c14", specular=0.9, exponent=90, reflectivity=0.06)
            + table("material", name="emerald", diffuse=[0.02, 0.30, 0.13], specular=0.9, exponent=60,
                    reflectivity=0.3))


def _skylight_bars() -> str:
    thick, y, x, z = 0.16, HEIGHT + 0.1, (LEFT + RIGHT) / 2, (BACK + FRONT) / 2
    width, depth = RIGHT - LEFT + 0.1, FRONT - BACK + 0.1
    return (table("instance", "The bars of the skylight.", mesh="block", scale=[width, thick, thick],
                  translate=[x, y, z])
            + table("instance", mesh="block", scale=[thick, thick, depth], translate=[x - 0.55, y, z])
            + table("instance", mesh="block", scale=[depth, thick, thick], rotate=turn([0, 1, 0], 90),
                    translate=[x + 0.55, y, z]))


def _furniture() -> str:
    plinth, tall, mirror, gold = 0.3, 1.2, 0.8, 0.4
    tilt = [turn([0, 0, 1], 14), turn([0, 1, 0], 30)]
    return (table("instance", "What stands on the floor.", mesh="block", scale=[1.7, plinth, 1.7],
                  rotate=turn([0, 1, 0], 24), translate=[-0.75, 0, -1.55])
            + table("sphere", name="big mirror", center=[-0.75, plinth + mirror, -1.55], radius=mirror,
                    material="silver")
            + table("instance", mesh="pedestal", translate=[-2.75, 0, -1.35])
            + table("sphere", name="gold ball", center=[-2.75, PEDESTAL_HEIGHT + gold, -1.35], radius=gold,
                    material="gold")
            + table("instance", mesh="pedestal", scale=[0.9, tall, 0.9], rotate=turn([0, 1, 0], 22.5),
                    translate=[1.2, 0, -2.5])
            + table("instance", mesh="gem", scale=[0.4, 0.52, 0.4], rotate=tilt,
                    translate=[1.2, PEDESTAL_HEIGHT * tall + 0.5, -2.5])
            + table("sphere", name="small mirror", center=[0.75, 0.5, -0.55], radius=0.5, material="silver")
            + table("sphere", name="lacquer ball", center=[-0.85, 0.36, 0.35], radius=0.36, material="lacquer"))
