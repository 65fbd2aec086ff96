"""The numbers of debug views: closed forms, and the pictures they belong to."""

import threading
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import glimt
from glimt import Camera, DirectionalLight, Instance, Material, Mesh, PointLight, Sphere, SpotLight, linalg
from glimt.debug_view import DEBUG_VIEWS
from glimt.errors import GlimtError, RenderCancelled

SIZE = 65
FACING = Camera((0, 0, 10), (0, 0, 0), fov_deg=float(np.degrees(2 * np.arctan(0.1))))  # sees 2×2 of the plane z = 0
SQUARE = Mesh([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2], [0, 2, 3]])
NOTHING = Mesh(np.zeros((0, 3)), np.zeros((0, 3), int))
CENTRES = (2 * np.arange(SIZE) + 1) / SIZE - 1


def renderer_of(*things, camera=FACING, **settings):
    settings = {"width": SIZE, "height": SIZE, **settings}
    return glimt.Renderer(glimt.Scene(camera=camera, settings=glimt.RenderSettings(**settings)).add(*things))


def shown(view, *things, camera=FACING, light=None):
    """Return (numbers (h, w, 3), what is met)."""
    values = renderer_of(*things, camera=camera).render_debug(view, light=light).values
    assert set(np.unique(values[..., 3])) <= {0, 1}
    return values[..., :3], values[..., 3] > 0


def directions():
    """Return the unit directions of the rays of FACING."""
    x, y = np.meshgrid(CENTRES, -CENTRES)
    return linalg.normalize(np.stack([0.1 * x, 0.1 * y, -np.ones_like(x)], 2))


def ball_hits(radius):
    """Return (distance, whether there is one, unit normal) of the rays of FACING with a ball around (0, 0, 0)."""
    d = directions()
    along = 10 * -d[..., 2]
    squared = radius**2 - (100 - along**2)
    t = along - np.sqrt(np.maximum(squared, 0))
    return t, squared > 0, (t[..., None] * d + (0, 0, 10)) / radius


# ---- what is met --------------------------------------------------------------------------------------------------

def test_a_balls_normals_and_depth():
    t, hit, normal = ball_hits(0.8)
    normals, met = shown("normals", Sphere((0, 0, 0), 0.8))
    np.testing.assert_array_equal(met, hit)
    np.testing.assert_allclose(normals[met], normal[hit], atol=2e-3)  # float32 at the rim
    np.testing.assert_allclose(normals[20:45, 20:45], normal[20:45, 20:45], atol=2e-5)
    assert not normals[~met].any()
    depth, met = shown("depth", Sphere((0, 0, 0), 0.8))
    np.testing.assert_array_equal(met, hit)
    np.testing.assert_allclose(depth[met][:, 0], t[hit], atol=2e-3)
    np.testing.assert_allclose(depth[20:45, 20:45, 0], t[20:45, 20:45], rtol=2e-6)
    assert not depth[~met].any()


def test_depth_is_along_the_ray():
    depth, met = shown("depth", SQUARE)
    x, y = np.meshgrid(CENTRES, CENTRES)
    assert met.all()
    np.testing.assert_allclose(depth[..., 0], np.sqrt(100 + x**2 + y**2), rtol=1e-6)


@pytest.mark.parametrize("size", [1, 0.25, -1])
def test_a_quads_barycentrics(size):
    shares, met = shown("barycentrics", Instance(SQUARE, linalg.scaling((size, abs(size), 1))))
    x, y = np.meshgrid(CENTRES / size, -CENTRES / abs(size))
    inside = (np.abs(x) < 1) & (np.abs(y) < 1)
    np.testing.assert_array_equal(met, inside)
    first = x > y  # of the triangles (0, 1, 2): below the diagonal
    a, b = (x + 1) / 2, (y + 1) / 2
    expected = np.where(first[..., None], np.stack([1 - a, a - b, b], 2), np.stack([1 - b, a, b - a], 2))
    clear = inside & (np.abs(x - y) > 1e-4)
    np.testing.assert_allclose(shares[clear], expected[clear], atol=1e-5)
    np.testing.assert_allclose(shares[met].sum(1), 1, atol=1e-6)
    assert not shares[~met].any()


def test_instances_are_places_among_the_objects():
    things = [NOTHING, Sphere((-0.5, 0.5, 0), 0.3), Instance(SQUARE, linalg.scaling(0.1)), NOTHING,
              Instance(SQUARE, linalg.compose(linalg.translation((0.5, -0.5, 0)), linalg.scaling(0.31)))]
    renderer = renderer_of(*things)
    values = renderer.render_debug("instances").values
    numbers = values.view(np.int32)
    assert set(np.unique(numbers[values[..., 3] > 0, 0])) == {1, 2, 4}
    assert not values[values[..., 3] == 0].any()
    for y in range(1, SIZE, 3):
        for x in range(2, SIZE, 3):
            pick = renderer.pick(x + 0.5, y + 0.5)
            seen = (pick.object_index, pick.triangle or 0) if pick else None
            assert seen == (tuple(numbers[y, x, :2]) if values[y, x, 3] else None)


def test_normals_are_those_of_the_normal_map_on_the_viewers_side():
    """A map that leans by 30 degrees to the right, on a wall that is seen from behind as well."""
    lean = np.radians(30)
    code = np.round((np.array([np.sin(lean), 0, np.cos(lean)]) / 2 + 0.5) * 255).astype(np.uint8)
    texture = glimt.Texture(np.broadcast_to(code, (4, 4, 3)).copy(), encoding="linear")
    wall = Mesh(SQUARE.positions, SQUARE.triangles, texcoords=[[0, 1], [1, 1], [1, 0], [0, 0]],
                materials=[Material(normal_texture=texture)])
    normals, met = shown("normals", wall)
    assert met.all()
    np.testing.assert_allclose(normals, np.broadcast_to((np.sin(lean), 0, np.cos(lean)), normals.shape), atol=6e-3)
    behind, _ = shown("normals", wall, camera=Camera((0, 0, -10), (0, 0, 0), fov_deg=10))
    np.testing.assert_allclose(behind, np.broadcast_to((-np.sin(lean), 0, -np.cos(lean)), normals.shape), atol=6e-3)


def test_normals_are_those_of_the_corners():
    bent = Mesh(SQUARE.positions, SQUARE.triangles, normals=[[0, 1, 1]] * 4)
    normals, _ = shown("normals", bent)
    np.testing.assert_allclose(normals, np.broadcast_to(linalg.normalize((0, 1, 1)), normals.shape), atol=1e-6)


# ---- lights -------------------------------------------------------------------------------------------------------

LAMP, SUN = PointLight(position=(0, 0, 4), radius=9), DirectionalLight(direction=(0, 0, -1))
BLOCKER = Instance(SQUARE, linalg.compose(linalg.translation((0, 0, 3)), linalg.scaling(0.05)))


def shade_of_blocker():
    """Return the points of the wall that the blocker keeps from the lamp (within 0.2) or from the sun (0.05), and of
    the picture that it covers (within 0.05 * 10 / 7)."""
    x, y = np.meshgrid(np.abs(CENTRES), np.abs(CENTRES))
    away = np.maximum(x, y)
    return away < 0.2, away < 0.05, away < 0.05 * 10 / 7


def test_one_light_is_white_but_where_something_is_in_its_way():
    lamp, sun, covered = shade_of_blocker()
    for light, dark in ((LAMP, lamp), (SUN, sun)):
        tints, met = shown("shadows", SQUARE, BLOCKER, light)
        assert met.all()
        np.testing.assert_array_equal(tints[~covered] == 1, np.repeat(~dark[~covered, None], 3, 1))
        np.testing.assert_array_equal(tints[~covered] == 0, np.repeat(dark[~covered, None], 3, 1))


def test_each_light_has_its_tint_and_all_add_up_to_white():
    lamp, _, covered = shade_of_blocker()
    front, back = LAMP, DirectionalLight(direction=(0, 0, 1))
    tints, _ = shown("shadows", SQUARE, BLOCKER, front, SUN)
    red, cyan = (1, 0, 0), (0, 1, 1)
    np.testing.assert_allclose(tints[lamp & ~covered], np.broadcast_to(cyan, tints[lamp & ~covered].shape), atol=1e-6)
    np.testing.assert_allclose(tints[~lamp], 1, atol=1e-6)
    tints, _ = shown("shadows", SQUARE, BLOCKER, front, back)  # the wall does not face the second
    np.testing.assert_allclose(tints[~lamp], np.broadcast_to(red, tints[~lamp].shape), atol=1e-6)
    assert not tints[lamp & ~covered].any()


def test_one_of_the_lights():
    lamp, _, covered = shade_of_blocker()
    for light, dark in ((0, np.ones_like(lamp)), (1, lamp)):
        tints, _ = shown("shadows", SQUARE, BLOCKER, DirectionalLight(direction=(0, 0, 1)), LAMP, SUN, light=light)
        np.testing.assert_array_equal(tints[~covered], np.repeat(1.0 - dark[~covered, None], 3, 1))


def test_outside_of_a_cone_is_dark():
    spot = SpotLight(position=(0, 0, 1), direction=(0, 0, -1), radius=9, inner_angle_deg=20, outer_angle_deg=30)
    tints, _ = shown("shadows", SQUARE, spot)
    x, y = np.meshgrid(CENTRES, CENTRES)
    away = np.hypot(x, y) - np.tan(np.radians(30))
    assert (tints[away < -0.01] == 1).all()
    assert (tints[away > 0.01] == 0).all()


def test_without_lights_all_is_dark_and_there_is_none_to_choose():
    tints, met = shown("shadows", SQUARE)
    assert met.all()
    assert not tints.any()
    for bad in (0, -1, 1.5, "sun"):
        with pytest.raises(GlimtError, match="no light"):
            shown("shadows", SQUARE, light=bad)
    with pytest.raises(GlimtError, match="no light 2; the scene has 2"):
        shown("shadows", SQUARE, LAMP, SUN, light=2)


def test_lights_move():
    orbit = glimt.Orbit(center=(0, 0, 0), axis=(0, 1, 0), period=2)
    renderer = renderer_of(SQUARE, PointLight(position=(0, 0, 4), radius=9, motion=orbit))
    assert renderer.render_debug("shadows").values.min() == 1
    assert not renderer.render_debug("shadows", time=1.0).values[..., :3].any()  # it is behind the wall by then
    assert renderer.render_debug("shadows", time=2.0).values.min() == 1


# ---- all of them --------------------------------------------------------------------------------------------------

@pytest.fixture(scope="module")
def room():
    """Textures, normal maps, instances, spheres; a size that is a multiple of nothing."""
    scene = glimt.load(Path(__file__).resolve().parents[2] / "examples" / "stone_room.toml")
    scene.settings = glimt.RenderSettings(97, 61)
    return scene


@pytest.mark.parametrize("view", DEBUG_VIEWS)
def test_any_number_of_threads_gives_the_same_numbers(room, view):
    expected = glimt.Renderer(room, threads=1).render_debug(view).values
    assert expected.any()
    for threads in (2, 5):
        renderer = glimt.Renderer(room, threads=threads)
        for _ in range(2):
            assert renderer.render_debug(view).values.tobytes() == expected.tobytes()


@pytest.mark.parametrize("view", DEBUG_VIEWS)
def test_pictures_beside_it_stay_the_same(room, view):
    renderer = glimt.Renderer(room)
    before = renderer.render()
    renderer.render_debug(view)
    after = renderer.render()
    assert after.sums.tobytes() == before.sums.tobytes()
    assert after.counters == before.counters


@pytest.mark.parametrize("view", DEBUG_VIEWS)
def test_an_empty_scene(view):
    film = renderer_of().render_debug(view)
    assert film.values.shape == (SIZE, SIZE, 4)
    assert not film.values[..., 1:].any()
    assert (film.values[..., 0] == (1 if view == "nodes" else 0)).all()  # the root
    assert film.image().shape == (SIZE, SIZE, 3)


@pytest.mark.parametrize("view", ["normals", "nodes"])
def test_it_can_be_cancelled(room, view):
    renderer = glimt.Renderer(replace(room), threads=2)
    expected = renderer.render_debug(view).values

    def cancel():
        while not renderer._engine._running:
            time.sleep(0.001)
        renderer.cancel()

    renderer.scene.settings = glimt.RenderSettings(8192, 8192)
    thread = threading.Thread(target=cancel)
    thread.start()
    with pytest.raises(RenderCancelled):
        renderer.render_debug(view)
    thread.join()
    renderer.scene.settings = room.settings
    assert renderer.render_debug(view).values.tobytes() == expected.tobytes()


def test_an_unknown_view_is_refused():
    with pytest.raises(GlimtError, match="no debug view 'normal'; expected one of normals, depth"):
        renderer_of().render_debug("normal")
