"""How far from a triangle nothing stands in the way: bounds that no ray may disprove, and that are worth having."""

import gc
import threading
import time
import weakref
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import glimt
from closed_meshes import UNEVEN, icosphere, torus
from glimt import linalg
from glimt.layout import CLEAR_SINES, FACE, INSTANCE, OFFSET_ERROR, dtype
from glimt.packed import Packer, clearance
from glimt.renderer import Renderer
from glimt.scene.scene import Scene
from tracing import closest

SIZE = 64


def packed_with(*objects):
    """Return a packed scene whose clearances are found."""
    packer = Packer(threads=2)
    packed = packer.pack(Scene().add(*objects))
    packer.clearances().finish()
    return packed


def clearances(packed):
    """Return the (n,) int32 clearances of a packed scene's triangles, mesh by mesh in their own order, a copy."""
    faces = packed.faces.view(dtype(FACE))
    starts = np.union1d(0, packed.instances.view(dtype(INSTANCE))["first_triangle"])
    place = np.repeat(starts, np.diff([*starts, len(faces)])) + faces["number"]
    return faces["clearance"][np.argsort(place)]


def distances_of(packed, inst=0, count=None):
    """Return (n, 4) clearances of an instance's triangles in world units, inf for endless."""
    record = packed.instances.view(dtype(INSTANCE))[inst]
    words = clearances(packed)[record["first_triangle"]:][:count]
    codes = words.view(np.uint8).reshape(-1, 4).astype(int)
    unit = abs(float(record["clear_unit"]))
    return np.where(codes == 255, np.inf, (2.0**(codes // 8) * (1 + codes % 8 / 8) - 1) * unit)


def grid(cells, height=lambda x, z: 0 * x):
    """Return a mesh of cells × cells × 2 triangles above [-1, 1]², facing up."""
    ticks = np.linspace(-1, 1, cells + 1)
    x, z = np.meshgrid(ticks, ticks)
    corner = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    across = corner + cells + 1
    triangles = np.stack([corner, across, across + 1, corner, across + 1, corner + 1], 1).reshape(-1, 3)
    return glimt.Mesh(np.stack([x, height(x, z), z], -1).reshape(-1, 3), triangles)


def joined(*meshes):
    """Return meshes as one."""
    shifts = np.cumsum([0, *(len(mesh.positions) for mesh in meshes)])
    return glimt.Mesh(np.concatenate([mesh.positions for mesh in meshes]),
                      np.concatenate([mesh.triangles + shift for mesh, shift in zip(meshes, shifts, strict=False)]))


def rising_rays(mesh, random, count, side=1):
    """Return (triangles, origins, directions, sines, offsets) of rays from random points above random triangles."""
    corners = mesh.positions[mesh.triangles].astype(np.float64)
    prims = random.integers(len(corners), size=count)
    a, b, c = corners[prims].transpose(1, 0, 2)
    u, v = random.uniform(0, 1, (2, count))
    u, v = np.where(u + v > 1, 1 - u, u)[:, None], np.where(u + v > 1, 1 - v, v)[:, None]
    normals = side * linalg.normalize(np.cross(b - a, c - a))
    directions = linalg.normalize(random.normal(size=(count, 3)))
    directions *= np.sign((directions * normals).sum(1, keepdims=True))
    extent = (corners.max((0, 1)) - corners.min((0, 1))).max()
    points = a + u * (b - a) + v * (c - a)
    offsets = float(OFFSET_ERROR) * (np.abs(points).max(1) + extent)
    return prims, points + normals * offsets[:, None], directions, (directions * normals).sum(1), offsets


def begins(clear, sines, offsets):
    """Return where rays begin that leave triangles with (n, 4) clearances."""
    said = np.zeros(len(sines))
    for k, sine in enumerate(CLEAR_SINES):
        said = np.where(sines > sine + 0.002, clear[:, k], said)
    return np.maximum(said - 2 * offsets, 0)


def assert_nothing_is_nearer(mesh, packed, random, count=20000, side=1):
    """Shoot rays: none may meet anything before what is said of its triangle and elevation."""
    clear = distances_of(packed, count=len(mesh.triangles))
    prims, origins, directions, sines, offsets = rising_rays(mesh, random, count, side)
    hits = closest(packed, origins.astype(np.float32), directions.astype(np.float32))
    said = begins(clear[prims], sines, offsets)
    wrong = hits.t < said * (1 - 1e-5)
    assert not wrong.any(), (prims[wrong][:5], hits.t[wrong][:5], said[wrong][:5])
    return said, hits.t


def test_a_plane_is_clear_for_ever():
    assert np.isinf(distances_of(packed_with(grid(20)))).all()


def test_from_above_a_ball_nothing_is_seen():
    """Convex: wherever one stands, the rest is below; and from within, all of it is above."""
    ball = icosphere(3)
    assert np.isinf(distances_of(packed_with(ball))).all()
    inside = glimt.Mesh(ball.positions, ball.triangles[:, ::-1])
    clear = distances_of(packed_with(inside))
    assert np.isfinite(clear).all()
    assert (np.diff(clear, axis=1) >= 0).all()  # the steeper, the further


def test_a_wall_is_as_far_as_it_is():
    """A wall along one side of a floor: low ones are below the steeper elevations, high ones are met at their foot."""
    floor = grid(24)
    center = floor.positions[floor.triangles].mean(1)
    for height in (0.1, 4.0):
        wall = grid(12)
        wall = glimt.Mesh(np.stack([np.full(len(wall.positions), 1.5), height * (wall.positions[:, 0] + 1) / 2,
                                    2 * wall.positions[:, 2]], 1), wall.triangles)
        clear = distances_of(packed_with(joined(floor, wall)), count=len(floor.triangles))
        away = 1.5 - center[:, 0]
        for k, sine in enumerate(CLEAR_SINES):
            needed = away / np.sqrt(1 - sine**2)  # to where the wall is higher than that
            seen = needed * sine <= height
            assert (clear[seen, k] <= needed[seen] * 1.001).all()
            assert (clear[seen, k] >= 0.6 * (away[seen] - 0.1)).all()  # boxes stand for what is in them
            assert (clear[needed * sine > 2.5 * height + 0.2, k] == np.inf).all()


@pytest.mark.parametrize("make", UNEVEN.values(), ids=UNEVEN)
def test_no_ray_meets_anything_nearer(make):
    mesh = make()
    assert_nothing_is_nearer(mesh, packed_with(mesh), np.random.default_rng(3))


def test_what_is_said_of_smooth_meshes_is_worth_having():
    tube = torus(96, 48, jitter=0.001)  # wound to be seen from within
    for mesh in (icosphere(4, roughness=0.0005), glimt.Mesh(tube.positions, tube.triangles[:, ::-1])):
        said, met = assert_nothing_is_nearer(mesh, packed_with(mesh), np.random.default_rng(3))
        assert (said > 0).mean() > 0.6
        assert (np.isinf(said) & np.isinf(met)).sum() > 0.5 * np.isinf(met).sum()  # most are told that they are free


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([1e-13, 1e-6, 1.0, 1e6, 1e11]), st.sampled_from([0.0, 30.0, 1000.0]),
       st.floats(0, 0.5))
def test_no_ray_over_rough_ground_meets_anything_nearer(seed, scale, shift, roughness):
    """Of any size, and far from its own origin."""
    random = np.random.default_rng(seed)
    bumps = random.normal(0, roughness * 0.1, (25, 25))
    ground = grid(24, lambda x, z: bumps[:len(x), :len(x)] + roughness * np.sin(3 * x) * np.cos(2 * z))
    ground = glimt.Mesh((ground.positions.astype(np.float64) + shift) * scale, ground.triangles)
    assert_nothing_is_nearer(ground, packed_with(ground), random, 2000)


def test_many_triangles_in_one_place():
    """Twice the same, flat ones, needles, all at one corner: bounds stay bounds."""
    random = np.random.default_rng(8)
    points = np.concatenate([random.uniform(-1, 1, (200, 3)), np.zeros((1, 3)), [[0, 0, 1e-7]]])
    triangles = random.integers(0, 200, (600, 3))
    triangles[:100, 1] = triangles[:100, 0]
    triangles[100:200] = triangles[200:300]
    triangles[300:400, :2] = 200, 201
    mesh = glimt.Mesh(points, triangles)
    packed = packed_with(mesh)
    solid = glimt.Mesh(points, triangles[100:300])
    prims, origins, directions, sines, offsets = rising_rays(solid, random, 4000)
    clear = distances_of(packed)[100:300][prims]
    assert (np.diff(clear, axis=1) >= 0).all()
    hits = closest(packed, origins.astype(np.float32), directions.astype(np.float32))
    assert (hits.t >= begins(clear, sines, offsets) * (1 - 1e-5)).all()


@pytest.mark.parametrize("edges", [[[-3, -3, -3], [-3, -2, 3]], [[1, 0, 0], [0, 0, -1]], [[5, 1, 2], [-1, 3, 4]],
                                   [[2, -7, 1], [3, 3, -8]], [[-4, 1, 6], [5, 5, 1]]])
def test_a_triangle_straight_above_is_seen(edges):
    """There is no direction in the plane towards it, nor up its slope; rounding must not make one up."""
    shape = np.array([[0, 0, 0], *edges], np.float64)
    above = np.cross(*shape[1:])
    above /= np.gcd.reduce(above.astype(int))
    for height in (1, 2, 3, 5):
        points = np.concatenate([shape, shape + height * above])
        mesh = glimt.Mesh(points, [[0, 1, 2], [3, 4, 5]] + [[0, 0, 0]] * 600)
        clear = distances_of(packed_with(mesh))
        assert (clear[0] <= height * np.linalg.norm(above) * (1 + 1e-6)).all()
        assert np.isinf(clear[1]).all()


@pytest.mark.parametrize("place", [(0, 0, 0), (1000, -300, 0)], ids=["here", "far away"])
@pytest.mark.parametrize("power", [4, 6, 9, 13, 15])
def test_a_ceiling_close_above_the_floor_keeps_its_shadow(power, place):
    """Where rays begin nearer to the ceiling than the floor itself is; a distance that is hardly rounded down."""
    gap = (1.25 * 2**power - 1) * 2 * 2.0**-20 * 1.0011
    floor, roof = grid(24), grid(1, lambda x, z: 0 * x + gap)
    scene = pictured(glimt.Instance(joined(floor, roof), linalg.translation(place)))
    renderer = Renderer(scene.add(glimt.DirectionalLight(direction=(0.02, -1, 0.01))), engine="cpu")
    eye = np.array(place) + [0.1, 0.6 * gap, 0.1]  # between them
    renderer.scene.camera = glimt.Camera(tuple(eye), tuple(eye + [0.3, -0.5 * gap, 0.3]), fov_deg=60)
    before = renderer.render().sums.copy()
    renderer.settle()
    np.testing.assert_array_equal(renderer.render().sums, before)


def test_normals_tell_the_side():
    mesh = torus(32, 16)
    a, b, c = mesh.positions[mesh.triangles].transpose(1, 0, 2)
    normals = np.zeros_like(mesh.positions)
    np.add.at(normals, mesh.triangles, np.cross(b - a, c - a)[:, None])
    for sign in (1, -1):
        side = glimt.Mesh(mesh.positions, mesh.triangles, normals=sign * linalg.normalize(normals))
        packed = packed_with(side)
        assert np.sign(packed.instances.view(dtype(INSTANCE))["clear_unit"][0]) == sign
        assert_nothing_is_nearer(side, packed, np.random.default_rng(4), side=sign)


def test_units_follow_instances():
    """Scaled by their size, signed by mirrors, none where angles change; and none for small meshes."""
    mesh = torus(32, 16)
    places = {"turned": (linalg.rotation((1, 2, 3), 50), 1), "larger": (linalg.scaling((3, 3, 3)), 3),
              "mirrored": (linalg.scaling((-2, 2, 2)), -2), "stretched": (linalg.scaling((1, 2, 1)), 0),
              "sheared": (np.array([[1, 0.3, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.0]]), 0)}
    packed = packed_with(*(glimt.Instance(mesh, matrix) for matrix, _ in places.values()), icosphere(2),
                         glimt.Sphere((0, 0, 0), 1))
    units = packed.instances.view(dtype(INSTANCE))["clear_unit"]
    own = float((mesh.positions.max(0) - mesh.positions.min(0)).max()) * 2.0**-20
    np.testing.assert_allclose(units, [own * scale for _, scale in places.values()] + [0, 0], rtol=1e-6)


MATRICES = {"modelled there": linalg.identity(),
            "turned and larger": linalg.compose(linalg.rotation((1, 2, 3), 50), linalg.scaling((2, 2, 2))),
            "mirrored": linalg.compose(linalg.rotation((3, 1, 2), 20), linalg.scaling((-1, 1, 1))),
            "stretched": linalg.scaling((1, 1.5, 0.7)),
            "far away": linalg.compose(linalg.translation((1000, 0, -500)), linalg.scaling((0.5, 0.5, 0.5)))}


def pictured(*objects):
    """Return a scene of shiny things under every kind of light."""
    scene = glimt.Scene(settings=glimt.RenderSettings(SIZE, SIZE, 1, 3)).add(*objects)
    lo, hi = scene.bounds()
    center, reach = (lo + hi) / 2, float(np.linalg.norm(hi - lo))
    return scene.add(glimt.PointLight(position=center + reach * np.array([0.7, 0.6, 0.9]), radius=9 * reach),
                     glimt.PointLight(position=(center[0], hi[1] + 1e-3 * reach, center[2]), radius=reach),
                     glimt.DirectionalLight(direction=(1, -0.4, -0.3)),
                     glimt.SpotLight(position=center + reach * np.array([-0.4, 1, 0.6]), radius=9 * reach,
                                     direction=(0.4, -1, -0.6)))


@pytest.mark.parametrize("matrix", MATRICES.values(), ids=MATRICES)
@pytest.mark.parametrize("make", UNEVEN.values(), ids=UNEVEN)
def test_pictures_are_the_same_to_the_bit(make, matrix):
    shiny = glimt.Material(reflectivity=0.5)
    mesh = make()
    turned = glimt.Mesh(mesh.positions, mesh.triangles[:, ::-1])  # its outside is its back
    beside = linalg.compose(matrix, linalg.translation((0.9, 0.2, 0.7)))
    renderer = Renderer(pictured(glimt.Instance(mesh, matrix, material=shiny),
                                 glimt.Instance(turned, beside, material=shiny)), engine="cpu")
    before = renderer.render().sums.copy()
    assert not clearances(renderer._packed).any()
    renderer.settle()
    assert clearances(renderer._packed).any()
    np.testing.assert_array_equal(renderer.render().sums, before)
    fewer = renderer.scene.camera_or_framing()
    renderer.scene.camera = replace(fewer, position=tuple(np.mean([fewer.position, fewer.target], 0)))  # from within
    inside = renderer.render().sums.copy()
    renderer._packed.faces.view(dtype(FACE))["clearance"] = 0
    np.testing.assert_array_equal(renderer.render().sums, inside)


def test_finding_begins_with_the_second_picture_and_ends():
    renderer = Renderer(pictured(torus(40, 20)), engine="cpu")
    clearance.compile_kernel()
    renderer.render()
    assert renderer._packer.clearances()._thread is None
    renderer.render()
    thread = renderer._packer.clearances()._thread
    assert thread is not None
    thread.join(20)
    assert clearances(renderer._packed).any()
    renderer.render()
    assert renderer._packer.clearances()._thread is thread


def test_what_is_found_is_kept_with_the_mesh():
    mesh = torus(40, 20)
    words = clearances(packed_with(mesh))
    renderer = Renderer(pictured(mesh, icosphere(4)), engine="cpu")
    np.testing.assert_array_equal(clearances(renderer._packed)[:len(words)], words)
    finder = renderer._packer.clearances()
    assert [len(each.mesh.triangles) for each in finder._meshes] == [20 * 4**4]
    renderer.settle()
    renderer.update()  # nothing has changed: the same arrays, and what is known of them
    assert renderer._packer.clearances() is finder
    renderer.scene.add(torus(20, 40))
    renderer.update()
    assert renderer._packer.clearances() is not finder
    assert clearances(renderer._packed)[len(words):].any()
    assert len(renderer._packer.clearances()._meshes) == 1


def test_scenes_that_share_a_mesh_know_it_each():
    mesh = torus(40, 20)
    first, second = Packer(), Packer()
    shared = first.pack(Scene().add(mesh, torus(20, 40)))
    alone = second.pack(Scene().add(mesh))
    for packer in (second, first):
        packer.clearances().finish()
    count = len(mesh.triangles)
    np.testing.assert_array_equal(clearances(shared)[:count], clearances(alone))
    assert clearances(alone).any()


def test_no_finder_outlives_its_meshes():
    packer, mesh = Packer(), torus(40, 20)
    packer.pack(Scene().add(mesh))
    finder = weakref.ref(packer.clearances())
    packer.pack(Scene().add(mesh.with_positions(mesh.positions * np.float32(2))))
    gc.collect()
    assert finder() is None


def test_moved_vertices_are_unknown_again():
    mesh = torus(40, 20)
    packed_with(mesh)
    moved = mesh.with_positions(mesh.positions * np.float32([1, 0.2, 1]))
    packer = Packer()
    packed = packer.pack(Scene().add(moved))
    assert not clearances(packed).any()
    packer.clearances().finish()
    assert_nothing_is_nearer(moved, packed, np.random.default_rng(5))


def test_a_finder_stops_with_its_packer():
    packer = Packer()
    packer.pack(Scene().add(icosphere(6)))
    finder = packer.clearances()
    finder.begin()
    del packer
    started = time.perf_counter()
    finder.finish()
    assert finder._stopped
    assert time.perf_counter() - started < 20
    assert not [thread for thread in threading.enumerate() if thread is finder._thread]


def test_without_a_cache_pictures_stay_as_they_are(monkeypatch):
    """Compiling in this process would hold the pictures up: nothing is found then."""
    monkeypatch.setattr(clearance, "is_ready", lambda kernel: False)
    monkeypatch.setattr(clearance, "compile_elsewhere", lambda code: None)
    packer = Packer()
    packed = packer.pack(Scene().add(torus(40, 20)))
    packer.clearances().finish()
    assert not clearances(packed).any()
