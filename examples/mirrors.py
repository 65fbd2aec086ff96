"""A hall with a mirror at either end, and coloured lights."""

from shapes import panel, torus
from text_files import table, turn

MESHES = {"torus": torus("", 0.62, 0.2, 48, 24), "quad": [panel("", (-0.5, 0, 0), (1, 0, 0), (0, 1, 0), 1)]}

UP = [0, 1, 0]


def scene() -> str:
    """Return the scene file."""
    return "".join((
        "# A hall with a mirror at either end, not quite parallel, so that the row of reflections bends away; a ring,\n"
        "# spheres and coloured lights between them. The spot light draws a cone on the floor.\n",
        table("render", size=[800, 600], samples=2, max_bounces=6, background=[0.015, 0.02, 0.035], ambient=0.05),
        table("camera", position=[1.5, 1.9, 4.1], target=[-0.15, 0.85, -1], fov_deg=46),
        table("light", name="spot", type="spot", position=[0.4, 4.6, 1.2], direction=[-0.1, -1, -0.28],
              inner_angle_deg=17, outer_angle_deg=19, radius=4, diffuse=[3.2, 3, 2.6]),
        table("light", name="rose", type="point", position=[-2.3, 1.9, -0.4], radius=1.5, diffuse=[2.4, 0.45, 0.5]),
        table("light", name="azure", type="point", position=[2.3, 1.9, -1.2], radius=1.5, diffuse=[0.25, 0.75, 2.4]),
        _materials(),
        table("mesh", name="ground", file="meshes/ground.obj", material="flags"),
        table("mesh", name="quad", file="meshes/quad.obj", material="mirror"),
        table("mesh", name="block", file="meshes/block.obj", material="frame"),
        table("mesh", name="torus", file="meshes/torus.obj", material="gold"),
        table("mesh", name="gem", file="meshes/gem.obj", material="teal"),
        _hall(), _show_pieces()))


def _materials() -> str:
    def textures(name: str, scale: list[float]) -> dict[str, dict[str, object]]:
        return {"diffuse_texture": {"file": f"textures/{name}.png", "scale": scale},
                "normal_texture": {"file": f"textures/{name}_normal.png", "scale": scale}}

    return (table("material", name="mirror", diffuse=0.02, specular=0.2, exponent=400, reflectivity=0.88)
            + table("material", name="chrome", diffuse=0.12, specular=0.9, exponent=300, reflectivity=0.8)
            + table("material", name="gold", diffuse=[0.65, 0.38, 0.08], specular=[1, 0.75, 0.35], exponent=120,
                    reflectivity=0.35)
            + table("material", name="porcelain", diffuse=[0.70, 0.69, 0.66], specular=0.6, exponent=80,
                    reflectivity=0.05)
            + table("material", name="teal", diffuse=[0.02, 0.30, 0.32], specular=0.9, exponent=90, reflectivity=0.12)
            + table("material", name="frame", diffuse=[0.45, 0.27, 0.08], specular=[0.6, 0.45, 0.2], exponent=40)
            + table("material", name="stone", diffuse=0.9, **textures("wall", [2, 0.9]))
            + table("material", name="flags", diffuse=0.85, specular=0.4, exponent=80, reflectivity=0.1,
                    normal_scale=0.7, **textures("floor", [12, 12])))


def _hall() -> str:
    width, height, bar, back, front, side = 5.4, 2.7, 0.15, -2.9, 4.5, 2.85
    edge = (width + bar) / 2
    return (table("instance", "The back mirror and its frame.", mesh="quad", scale=[width, height, 1],
                  translate=[0, bar, back])
            + "".join(table("instance", mesh="block", scale=[width + 2 * bar, bar, 0.2], translate=[0, y, back - 0.05])
                      for y in (0, bar + height))
            + "".join(table("instance", mesh="block", scale=[bar, height, 0.2], translate=[x, bar, back - 0.05])
                      for x in (-edge, edge))
            + table("instance", "The mirror behind the camera, and the walls at the sides.", mesh="quad",
                    scale=[2 * side, 3, 1], rotate=turn(UP, 182), translate=[0, 0, front])
            + "".join(table("instance", mesh="quad", material="stone", scale=[8, 3.6, 1], rotate=turn(UP, angle_deg),
                            translate=[x, 0, 0.9]) for x, angle_deg in ((-side, 90), (side, -90))))


def _show_pieces() -> str:
    return (table("instance", "Between the mirrors.", mesh="torus", rotate=[turn([1, 0, 0], 90), turn(UP, 35)],
                  translate=[-0.2, 0.82, -0.5])
            + table("instance", mesh="gem", scale=[0.30, 0.42, 0.30], translate=[1.25, 0.40, 0.3])
            + table("sphere", name="chrome ball", center=[0.75, 0.55, -1.5], radius=0.55, material="chrome")
            + table("sphere", name="pearl", center=[-0.2, 0.82, -0.5], radius=0.26, material="porcelain")
            + table("sphere", name="small chrome ball", center=[-1.15, 0.32, 0.65], radius=0.32, material="chrome")
            + table("sphere", name="porcelain ball", center=[0.30, 0.22, 0.75], radius=0.22, material="porcelain"))
