"""The last occluder of a light, tested first, changes no film."""

import numpy as np
import pytest

import glimt
from glimt import linalg
from glimt.renderer import Renderer

SIZE = 64
LIGHTS = {"one light": 1, "more lights than are remembered": 35}


def square(cells, half=1.0, height=0.0):
    """Return a level square of `cells` × `cells` × 2 triangles around the y axis."""
    ticks = np.linspace(-half, half, cells + 1)
    x, z = np.meshgrid(ticks, ticks)
    corner = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    across = corner + cells + 1
    triangles = np.stack([corner, across, across + 1, corner, across + 1, corner + 1], 1).reshape(-1, 3)
    return glimt.Mesh(np.stack([x, 0 * x + height, z], -1).reshape(-1, 3), triangles)


def seen_from_above(*objects, lights=1):
    """Return a scene of a floor with lamps that stand higher than the camera, which no object hides."""
    scene = glimt.Scene(settings=glimt.RenderSettings(SIZE, SIZE, 1, 0, ambient=0.0)).add(*objects)
    scene.add(*(glimt.PointLight(position=(-3 + 0.01 * k, 4, 0.02 * k), radius=9) for k in range(lights)))
    scene.camera = glimt.Camera((0, 3, 0.01), (0, 0, 0), fov_deg=36)
    return scene


TURNED = linalg.compose(linalg.translation((-1.6, 1, 0)), linalg.rotation((0, 1, 0), 30), linalg.scaling((0.5, 1, 0.8)))
OCCLUDERS = {"triangle": lambda: glimt.Mesh([[-1.9, 2, -4], [-1.9, 2, 4], [-1.1, 2, 0]], [[0, 1, 2]]),
             "instance": lambda: glimt.Instance(square(1, height=1), TURNED),
             "many triangles": lambda: glimt.Instance(square(30, height=1), TURNED),
             "sphere": lambda: glimt.Sphere((-1.6, 2, 0.1), 0.5)}


@pytest.mark.parametrize("lights", LIGHTS.values(), ids=LIGHTS)
@pytest.mark.parametrize("make", OCCLUDERS.values(), ids=OCCLUDERS)
def test_shadows_are_those_of_the_debug_view(make, lights):
    """Which asks each block anew."""
    renderer = Renderer(seen_from_above(square(1, 3.0), make(), lights=lights), threads=1)
    lit = renderer.render().radiance.any(-1)
    np.testing.assert_array_equal(lit, renderer.render_debug("shadows").values[..., :3].any(-1))
    assert 0.05 < lit.mean() < 0.95


def test_occluders_are_forgotten_between_scenes():
    """Here what shadows all of the first scene would be a piece of floor that hovers in the second."""
    floor, roof = square(1, 3.0), square(1, 20.0, 3.5)
    roof = glimt.Mesh(roof.positions, np.tile(roof.triangles, (2, 1)))  # as many triangles as a leaf holds
    small = glimt.Mesh(1e-3 * square(1).positions, square(1).triangles)
    open_air = seen_from_above(square(2, 3.0), glimt.Instance(small, linalg.translation((-3, 3.5, -1))))
    renderer = Renderer(open_air, threads=1)
    before = renderer.render()
    assert before.radiance.all()
    for scene in (seen_from_above(floor, roof), open_air):
        renderer.scene = scene
        renderer.update()
        film = renderer.render()
        assert film.radiance.any() == (scene is open_air)
    assert film.sums.tobytes() == before.sums.tobytes()
