"""What is seen at a point of the picture: against brute force in float64, and by hand."""

import threading

import numpy as np
import pytest

import oracle
import strategies
from glimt import (
    Camera,
    GlimtError,
    Instance,
    Material,
    Mesh,
    Orbit,
    PointLight,
    Renderer,
    RenderSettings,
    Scene,
    Sphere,
    linalg,
)

RED, GREEN, BLUE = (Material(diffuse=color) for color in np.eye(3))
SQUARE = Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]], materials=[RED, GREEN],
              material_ids=[0, 1])
NOTHING = Mesh(np.zeros((0, 3)), np.zeros((0, 3), int))


def facing(*things, width=100, height=100):
    """A camera at (0, 0, 10) that sees 2×2 units, or as wide as the picture is, of the plane z = 0."""
    camera = Camera((0, 0, 10), (0, 0, 0), fov_deg=float(np.degrees(2 * np.arctan(0.1))))
    return Renderer(Scene(camera=camera, settings=RenderSettings(width, height)).add(*things))


# ---- by hand ------------------------------------------------------------------------------------------------------

def test_everything_about_a_triangle():
    thing = Instance(SQUARE)
    pick = facing(NOTHING, Sphere((0, 0, 50), 1), thing).pick(75, 37.5)
    assert pick.object is thing
    assert (pick.object_index, pick.triangle) == (2, 0)
    assert pick.material is RED
    assert pick.position == pytest.approx((0.5, 0.25, 0), abs=1e-6)
    assert pick.normal == (0, 0, 1)
    assert pick.distance == pytest.approx((100 + 0.25 + 0.0625) ** 0.5, rel=1e-6)
    assert (pick.u, pick.v) == pytest.approx((0.25, 0.25), abs=1e-6)


def test_everything_about_a_sphere():
    ball = Sphere((0, 0, 0), 0.5, BLUE)
    pick = facing(ball, SQUARE).pick(50, 50)
    assert pick.object is ball
    assert (pick.object_index, pick.triangle, pick.u, pick.v) == (0, None, 0, 0)
    assert pick.material is BLUE
    assert pick.position == pytest.approx((0, 0, 0.5), abs=1e-6)
    assert pick.normal == pytest.approx((0, 0, 1), abs=1e-6)
    assert pick.distance == pytest.approx(9.5, rel=1e-6)


def test_each_triangle_has_its_own_material_unless_the_instance_has_one():
    renderer = facing(SQUARE)
    assert renderer.pick(60, 30).triangle == 1
    assert renderer.pick(60, 30).material is GREEN
    assert facing(Instance(SQUARE, material=BLUE)).pick(60, 30).material is BLUE


def test_the_background_is_none():
    renderer = facing(SQUARE)
    assert renderer.pick(25, 50) is None
    assert renderer.pick(-10, 500.5) is None  # beyond the picture
    assert facing().pick(50, 50) is None
    assert facing(NOTHING).pick(50, 50) is None


@pytest.mark.parametrize("matrix", [linalg.scaling((1, 1, -1)), linalg.scaling((-1, 1, 1)), linalg.identity()])
def test_the_normal_is_on_the_viewers_side(matrix):
    matrix = linalg.compose(matrix, linalg.translation((-0.5, -0.5, 0)))
    assert facing(Instance(SQUARE, matrix)).pick(55, 52).normal == (0, 0, 1)


def test_the_first_column_and_row_are_the_top_left_corner():
    renderer = facing(SQUARE, width=200)
    assert renderer.pick(100.5, 0.5).position == pytest.approx((0.01, 0.99, 0), abs=1e-6)
    assert renderer.pick(199.5, 0.5) is None  # the picture is 4 units wide
    renderer.scene.settings.width = 100
    assert renderer.pick(99.5, 0.5).position == pytest.approx((0.99, 0.99, 0), abs=1e-6)


def test_camera_and_objects_are_those_of_the_next_picture():
    renderer = facing(SQUARE)
    renderer.scene.camera = Camera((0.9, 0.5, -4), (0.9, 0.5, 0))
    assert renderer.pick(50, 50).position == pytest.approx((0.9, 0.5, 0), abs=1e-6)
    assert renderer.pick(50, 50).normal == (0, 0, -1)
    renderer.scene.objects.insert(0, Sphere((0.9, 0.5, -2), 0.5))
    assert renderer.pick(50, 50).object is renderer.scene.objects[1]
    renderer.update()
    assert renderer.pick(50, 50).object is renderer.scene.objects[0]
    renderer.scene.camera, renderer.scene.objects[1:] = None, []
    renderer.update()
    assert renderer.pick(50, 50).object is renderer.scene.objects[0]  # framed


@pytest.mark.parametrize("bad", [np.nan, np.inf, "left", None])
def test_points_that_are_none_are_refused(bad):
    with pytest.raises(GlimtError, match="pick: y"):
        facing(SQUARE).pick(0, bad)
    with pytest.raises(GlimtError, match="pick: x"):
        facing(SQUARE).pick(bad, 0)


def test_picking_leaves_the_lights_of_a_render_alone():
    """A pick at another time, between what a render prepares and what it draws."""
    orbit = Orbit(center=(0, 0, 0), axis=(0, 1, 0), period=2)
    renderer = facing(SQUARE, PointLight(position=(0, 0, 4), radius=9, motion=orbit))
    dark, draw = renderer.render(1.0).sums, renderer._engine.render  # the light is behind the square

    def pick_and_draw(*arguments):
        assert renderer.pick(75, 37.5, 0.0).triangle == 0
        return draw(*arguments)

    renderer._engine.render = pick_and_draw
    np.testing.assert_array_equal(renderer.render(1.0).sums, dark)
    assert renderer.render(0.0).sums[..., 0].max() > dark[..., 0].max()


def test_picking_beside_a_render():
    """From two threads: neither waits for the other, and the pictures stay what they are."""
    renderer = facing(SQUARE, Sphere((-0.5, -0.5, 0), 0.25))
    expected, done, films = renderer.render().sums, threading.Event(), []

    def render():
        while not done.is_set():
            films.append(renderer.render().sums)

    thread = threading.Thread(target=render)
    thread.start()
    try:
        for _ in range(300):
            assert renderer.pick(75, 37.5).triangle == 0
            assert renderer.pick(25, 75).object_index == 1
    finally:
        done.set()
        thread.join()
    assert films
    assert all(np.array_equal(film, expected) for film in films)


# ---- against the oracle -------------------------------------------------------------------------------------------

def nasty(seed):
    random = np.random.default_rng(seed)
    scene = Scene(settings=RenderSettings(64, 48)).add(NOTHING, Sphere((1, 0, 0), 0.75), Sphere((-1, 0.5, 0), 0.5))
    for name in ("identity", "moved", "turned", "mirrored", "stretched"):
        mesh = strategies.mesh_of(random.uniform(-1, 1, (12, 3, 3)))
        mesh.materials, mesh.material_ids = [Material(), Material()], random.integers(0, 2, 12)
        scene.add(NOTHING, Instance(mesh, strategies.MATRICES[name](random)))
    scene.camera = Camera(tuple(random.uniform(4, 6, 3)), tuple(random.uniform(-1, 1, 3)), fov_deg=50)
    return scene, random.uniform(0, 1, (150, 2)) * (64, 48)


def rays(scene, points):
    """Return (origins, directions) through points of the picture, in float64."""
    basis, reach = scene.camera.basis(), np.tan(np.radians(scene.camera.fov_deg) / 2)
    x, y = points.T / [[64], [48]] * 2 - 1
    directions = basis.look + reach * (x[:, None] * 64 / 48 * basis.right - y[:, None] * basis.up)
    return np.broadcast_to(scene.camera.position, directions.shape), linalg.normalize(directions)


@pytest.mark.parametrize("seed", range(6))
def test_random_scenes(seed):
    scene, points = nasty(seed)
    renderer = Renderer(scene)
    picks = [renderer.pick(x, y) for x, y in points]
    origins, directions = rays(scene, points)
    found = oracle.meetings(scene, origins, directions)
    clear = np.where(found.possible, found.sure & (found.spread < 1e-3), True).all(1)
    t, inst, prim = oracle.closest(found)
    placed = [k for k, thing in enumerate(scene.objects) if thing not in scene.instances() or len(thing.mesh.triangles)]
    assert clear.mean() > 0.9
    assert 0.3 < np.mean([pick is None for pick in picks]) < 0.95
    for k in np.flatnonzero(clear):
        pick = picks[k]
        assert (pick is None) == (inst[k] < 0)
        if pick is None:
            continue
        assert pick.object_index == placed[inst[k]]
        assert pick.object is scene.objects[pick.object_index]
        assert pick.distance == pytest.approx(t[k], rel=1e-5)
        assert pick.position == pytest.approx(origins[k] + t[k] * directions[k], abs=1e-4)
        check_surface(pick, prim[k], directions[k])


def check_surface(pick, prim, direction):
    """The triangle, normal and material fit the object and the place."""
    normal, position = np.array(pick.normal), np.array(pick.position)
    assert normal @ direction < 0
    assert np.linalg.norm(normal) == pytest.approx(1)
    if isinstance(pick.object, Sphere):
        assert pick.triangle is None
        assert pick.material is pick.object.material
        np.testing.assert_allclose(position, pick.object.center + pick.object.radius * normal * np.sign(
            normal @ (position - pick.object.center)), atol=1e-5)
        return
    mesh = pick.object.mesh
    assert pick.triangle == prim
    assert pick.material is mesh.materials[mesh.material_ids[prim]]
    a, b, c = linalg.transform_points(pick.object.object_to_world, mesh.positions[mesh.triangles[prim]])
    np.testing.assert_allclose([normal @ (b - a), normal @ (c - a)], 0, atol=1e-6)
    np.testing.assert_allclose((1 - pick.u - pick.v) * a + pick.u * b + pick.v * c, position, atol=1e-6)
