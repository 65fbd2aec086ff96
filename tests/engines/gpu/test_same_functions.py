"""Each function that both engines have gives the same numbers on both, at random places."""

import numpy as np
import pytest
from kernel_calls import both_answers

import closed_meshes
from glimt import (
    Camera,
    DirectionalLight,
    Material,
    Mesh,
    PointLight,
    RenderSettings,
    Scene,
    Sphere,
    SpotLight,
    Texture,
)
from glimt.engines.cpu.kernels.block import RAY, RAY_WORDS, SLOTS
from glimt.engines.cpu.kernels.bounce import mirror_direction
from glimt.engines.cpu.kernels.camera import camera_ray
from glimt.engines.cpu.kernels.hit import Hit, closer
from glimt.engines.cpu.kernels.light import light_sample
from glimt.engines.cpu.kernels.material import material_eval
from glimt.engines.cpu.kernels.packet import rays_at, set_up, shears_at
from glimt.engines.cpu.kernels.shade import terminator
from glimt.engines.cpu.kernels.sphere import sphere_hit
from glimt.engines.cpu.kernels.surface import Surface, above
from glimt.engines.cpu.kernels.texture import sample_texture
from glimt.engines.cpu.kernels.triangle import edges, meeting, within
from glimt.kernel import inline
from glimt.lanes import (
    f32,
    from_bits,
    load,
    load3,
    load_int,
    scalar,
    select,
    stack_floats,
    store,
    store3,
    to_float,
    to_int,
)
from glimt.layout import FACE, INSTANCE, MISS, dtype
from glimt.packed import pack

COUNT = 1024
CLOSE = 1e-5
ALL = np.int64(-1)

pytestmark = pytest.mark.usefixtures("software_gpu")


@pytest.fixture
def random():
    """Return a generator, the same for each test."""
    return np.random.default_rng(5)


def _unit(random, count=COUNT):
    vectors = random.normal(size=(3, count))
    return vectors / np.linalg.norm(vectors, axis=0)


def _numbered(choices, count=COUNT):
    """Return one of the first few integers for each call, the same for 16 in a row: packets have one."""
    return (np.arange(count) // 16 % choices)[None].astype(np.float32)


def _scene(random):
    """Return a scene with three kinds of lights, spheres and textures that repeat or do not, and a camera askew."""
    pixels = random.random((2, 5, 8, 3)).astype(np.float32)
    clamped = Texture(pixels[0], "linear", "clamp")
    repeated = Texture(pixels[1], "linear", "repeat", scale=(2, -0.5), offset=(0.25, 0.5))
    square = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], None, [[0, 0], [1, 0], [0, 1]],
                  [Material(diffuse_texture=clamped, normal_texture=repeated)])
    return Scene(camera=Camera((1, 2, 3), (-0.5, 0.1, 0), (0.1, 1, 0), 50), settings=RenderSettings(40, 30)).add(
        PointLight(position=(0.3, 2, 0.1), radius=2, attenuation=(0.1, 0.5, 2)),
        DirectionalLight(direction=(0.3, -1, 0.2)),
        SpotLight(position=(0, 3, 0.5), direction=(0.1, -1, 0), inner_angle_deg=10, outer_angle_deg=60),
        Sphere((0.2, 0.1, -0.3), 0.5), Sphere((-20, 4, 7), 11), square)


def assert_close(got, wanted, absolute=1e-6):
    """Compare answers of both engines."""
    assert np.isfinite(wanted).all()
    np.testing.assert_allclose(got, wanted, rtol=CLOSE, atol=absolute)


def test_camera_ray(random):
    @inline
    def on_lanes(scene, given, answers, n, i):
        origin, direction = camera_ray(scene, load(given, i), load(given, n + i))
        store3(answers, i, n, origin)
        store3(answers, 3 * n + i, n, direction)

    wanted, got = both_answers(_scene(random), on_lanes, "let ray = camera_ray(value(0u), value(1u));\n"
                               "put_vector(0u, ray.origin); put_vector(3u, ray.direction);",
                               random.uniform(-1, 1, (2, COUNT)), 6)
    np.testing.assert_allclose(np.linalg.norm(wanted[3:], axis=0), 1, rtol=1e-6)
    assert_close(got, wanted)


def test_terminator(random):
    @inline
    def on_lanes(scene, given, answers, n, i):
        store(answers, i, terminator(load3(given, i, n), load3(given, 3 * n + i, n), load3(given, 6 * n + i, n)))

    ng, wi = _unit(random), _unit(random)
    ns = ng + 0.5 * _unit(random)
    ns /= np.linalg.norm(ns, axis=0)
    wanted, got = both_answers(_scene(random), on_lanes, "put(0u, terminator(vector(0u), vector(3u), vector(6u)));",
                               np.concatenate([ng, ns, wi]), 1)
    assert {0.0, 1.0} < set(wanted[0].tolist())
    steady = np.abs((ns * wi).sum(0)) > 0.05  # elsewhere what dot products round off counts for more
    assert_close(got[:, steady], wanted[:, steady], CLOSE)


def test_mirror_direction(random):
    @inline
    def on_lanes(scene, given, answers, n, i):
        store3(answers, i, n, mirror_direction(load3(given, i, n), load3(given, 3 * n + i, n),
                                               load3(given, 6 * n + i, n)))

    given = np.concatenate([_unit(random), _unit(random), _unit(random)])
    wanted, got = both_answers(_scene(random), on_lanes,
                               "put_vector(0u, mirror_direction(vector(0u), vector(3u), vector(6u)));", given, 3)
    lifted = (wanted * given[3:6]).sum(0) < 2e-3
    assert 0 < lifted.sum() < COUNT
    assert_close(got, wanted, 5e-6)


def test_material_eval(random):
    @inline
    def on_lanes(scene, given, answers, n, i):
        diffuse, specular = material_eval(
            load3(given, i, n), load3(given, 3 * n + i, n), load(given, 6 * n + i), load3(given, 7 * n + i, n),
            load3(given, 10 * n + i, n), load3(given, 13 * n + i, n), load(given, 16 * n + i))
        store3(answers, i, n, diffuse)
        store3(answers, 3 * n + i, n, specular)

    given = np.concatenate([random.random((6, COUNT)), np.exp(random.uniform(0, 5, (1, COUNT))), _unit(random),
                            _unit(random), _unit(random), random.random((1, COUNT))])
    wanted, got = both_answers(
        _scene(random), on_lanes, "let sent = material_eval(vector(0u), vector(3u), value(6u), vector(7u), "
        "vector(10u), vector(13u), value(16u));\nput_vector(0u, sent.diffuse); put_vector(3u, sent.specular);",
        given, 6)
    assert (wanted[3:] > 0.1).any()
    assert_close(got, wanted, 2e-6)


def test_light_sample(random):
    @inline
    def on_lanes(scene, given, answers, n, i):
        light = light_sample(scene, np.int64(scalar(given, i)), load3(given, n + i, n), load3(given, 4 * n + i, n))
        store3(answers, i, n, light.wi)
        store3(answers, 3 * n + i, n, light.reach)
        store(answers, 6 * n + i, light.t_max)
        store(answers, 7 * n + i, light.attenuation)

    point = random.uniform(-2, 2, (3, COUNT))
    given = np.concatenate([_numbered(3), point, point + 1e-3])
    wanted, got = both_answers(
        _scene(random), on_lanes, "let light = light_sample(u32(value(0u)), vector(1u), vector(4u));\n"
        "put_vector(0u, light.wi); put_vector(3u, light.reach); put(6u, light.t_max); put(7u, light.attenuation);",
        given, 8)
    far = given[0] == 1
    assert np.isinf(wanted[6, far]).all()
    assert (got[6, far] > 1e38).all()
    wanted[6, far] = got[6, far] = 0
    spot = wanted[7, given[0] == 2]
    assert (spot == 0).any()
    assert (spot > 0).any()
    assert_close(got, wanted, 5e-6)


def test_sample_texture(random):
    @inline
    def on_lanes(scene, given, answers, n, i):
        texture = np.int64(scalar(given, i))
        for k in range(2):
            color = sample_texture(scene, texture, from_bits(ALL), load(given, n + i), load(given, 2 * n + i),
                                   load(given, 3 * n + i), k == 0)
            store3(answers, 3 * k * n + i, n, color)

    footprint = np.exp2(random.uniform(-12, 2, (1, COUNT)))
    given = np.concatenate([_numbered(2), random.uniform(-2, 3, (2, COUNT)), footprint])
    given[1:3, :64] = np.linspace(-1, 2, 13).repeat(5)[:64]  # at borders too
    wanted, got = both_answers(
        _scene(random), on_lanes, "let texcoord = vec2(value(1u), value(2u));\nlet texture = u32(value(0u));\n"
        "put_vector(0u, sample_texture(texture, texcoord, value(3u), true));\n"
        "put_vector(3u, sample_texture(texture, texcoord, value(3u), false));", given, 6)
    assert ((wanted >= 0) & (wanted <= 1)).all()
    for texture in range(2):
        own = wanted[:, given[0] == texture]
        coarse, fine = (np.ptp(own[:, chosen[given[0] == texture]], 1) for chosen in (footprint[0] > 2,
                                                                                     footprint[0] < 0.01))
        assert coarse.max() < 0.02 < fine.min(), "all levels are looked at"
    assert_close(got, wanted, CLOSE)


def _is_inside(w):
    """Return which triangles a ray at 0 is in by their edge functions, and which are clear of all rounding."""
    return (w > 0).all(0) | (w < 0).all(0), (np.abs(w) > 1e-4).all(0)


_CORNERS = """
fn only_here(number: f32) -> vec4<f32> {
    return select(vec4(0.0), vec4(number), vec4(0u, 1u, 2u, 3u) == vec4(at % 4u));
}
fn corner_here(plane: u32) -> Corners {
    return Corners(only_here(value(plane)), only_here(value(plane + 1u)), only_here(value(plane + 2u)));
}
"""
"""One corner of four triangles, of which three are nothing."""


def test_edges_and_meeting(random):
    @inline
    def on_lanes(scene, given, answers, n, i):
        a, b, c = load3(given, i, n), load3(given, 3 * n + i, n), load3(given, 6 * n + i, n)
        wa, wb, wc, inside = edges(a, b, c)
        t, u, v = meeting(wa, wb, wc, a.z, b.z, c.z, load(given, 9 * n + i))
        store(answers, i, select(inside & within(a, b, c), f32(1.0), 0.0))
        store(answers, n + i, t)
        store(answers, 2 * n + i, u)
        store(answers, 3 * n + i, v)

    given = np.concatenate([random.uniform(-1, 1, (9, COUNT)), random.uniform(0.5, 2, (1, COUNT))])
    given[[2, 5, 8]] += 3  # in front of the ray
    wanted, got = both_answers(
        _scene(random), on_lanes, "let place = at % 4u;\n"
        "let a = corner_here(0u); let b = corner_here(3u); let c = corner_here(6u);\n"
        "let w = edges(a, b, c);\nlet met = meeting(w.wa, w.wb, w.wc, a.z, b.z, c.z, value(9u));\n"
        "let here = w.inside & within(a, b, c) & met.anywhere;\n"
        "put_flag(0u, here[place]);\n"
        "put(1u, met.t[place]); put(2u, met.u[place]); put(3u, met.v[place]);", given, 4, _CORNERS)
    a, b, c = given[0:2], given[3:5], given[6:8]
    inside, sure = _is_inside(np.array([c[0] * b[1] - c[1] * b[0], a[0] * c[1] - a[1] * c[0],
                                        b[0] * a[1] - b[1] * a[0]]))
    assert 0.1 < inside.mean() < 0.5
    for flags in (wanted[0], got[0]):
        np.testing.assert_array_equal(flags[sure], inside[sure])
    assert_close(got[1:, inside & sure], wanted[1:, inside & sure], CLOSE)


def test_set_up(random):
    @inline
    def on_lanes(scene, given, answers, n, i):
        words = stack_floats(RAY_WORDS)
        set_up(words, 0, load3(given, i, n), load3(given, 3 * n + i, n))
        shears = shears_at(words, 0)
        store3(answers, i, n, shears.shear)
        store3(answers, 3 * n + i, n, shears.shear_origin)
        store3(answers, 6 * n + i, n, load3(words, RAY.inverse, SLOTS))
        store(answers, 9 * n + i, to_float(load_int(words, RAY.longest)))

    given = np.concatenate([random.uniform(-5, 5, (3, COUNT)), _unit(random) * np.exp(random.uniform(-9, 9, COUNT))])
    given[3:, :6 * 16] = np.eye(3).repeat(32, 1) * np.where(np.arange(96) % 2, 1, -1)  # along the axes
    given[3:, 96:128] = 2.0  # as long on all axes
    wanted, got = both_answers(
        _scene(random), on_lanes, "let ray = set_up(vector(0u), vector(3u));\nput_vector(0u, ray.shear); "
        "put_vector(3u, ray.shear_origin); put_vector(6u, ray.inverse); put(9u, f32(ray.axis));", given, 10)
    np.testing.assert_array_equal(got[9], wanted[9])
    assert set(wanted[9].tolist()) == {0, 1, 2}
    across = given[3:6] == 0  # neither engine divides by 0; how large that gets is its own affair
    assert (np.abs(got[6:9][across]) > 1e10).all()
    assert_close(got[:6], wanted[:6])
    assert_close(got[6:9][~across], wanted[6:9][~across])


def test_sphere_hit(random):
    @inline
    def on_lanes(scene, given, answers, n, i):
        words, inst = stack_floats(RAY_WORDS), np.int64(scalar(given, i))
        set_up(words, 0, load3(given, n + i, n), load3(given, 4 * n + i, n))
        hit = Hit(load(given, 7 * n + i), f32(0.5), f32(0.5), to_int(f32(MISS)), to_int(f32(MISS)))
        found = sphere_hit(scene, np.int32(inst), inst * INSTANCE.words, rays_at(words, 0), hit, False)
        shadowed = sphere_hit(scene, np.int32(inst), inst * INSTANCE.words, rays_at(words, 0), hit, True)
        store(answers, i, found.t)
        store(answers, n + i, to_float(found.inst))
        store(answers, 2 * n + i, select(shadowed.t < 0.0, f32(1.0), 0.0))

    scene, number = _scene(random), _numbered(2)
    spheres = np.array([[*sphere.center, sphere.radius] for sphere in scene.spheres()]).T[:, number[0].astype(int)]
    center, radius = spheres[:3], spheres[3]
    origin = center + radius * random.uniform(-2, 2, (3, COUNT))
    direction = (center + radius * 1.5 * _unit(random) - origin) * random.uniform(0.1, 3, COUNT)
    t_max = random.uniform(0.1, 10, (1, COUNT))
    given = np.concatenate([number, origin, direction, t_max])
    wanted, got = both_answers(
        scene, on_lanes, "let inst = u32(value(0u));\nvar hit = Hit(value(7u), 0.5, 0.5, MISS, MISS);\n"
        "var shadow = hit;\nlet ray = set_up(vector(1u), vector(4u));\n"
        "var record = placement(0u);\n"
        "while blocks[record + PLACEMENT_inst / 4u].x != inst { record += PLACEMENT_words / 4u; }\n"
        "_ = sphere_hit(inst, record, ray, &hit, false);\nput(0u, hit.t); put(1u, f32(bitcast<i32>(hit.inst)));\n"
        "put_flag(2u, sphere_hit(inst, record, ray, &shadow, true));", given, 3)
    along = direction / np.linalg.norm(direction, axis=0)
    beside = center - origin - along * ((center - origin) * along).sum(0)
    sure = np.abs(np.linalg.norm(beside, axis=0) / radius - 1) > 1e-3
    sure &= np.abs(wanted[0] / t_max[0] - 1) > 1e-4
    assert 0.1 < wanted[2].mean() < 0.9
    np.testing.assert_array_equal(got[1:, sure], wanted[1:, sure])
    np.testing.assert_array_equal(wanted[2], wanted[1] >= 0)
    assert_close(got[0, sure], wanted[0, sure], CLOSE)


def test_above(random):
    @inline
    def on_lanes(scene, given, answers, n, i):
        point, ng, zero = load3(given, i, n), load3(given, 3 * n + i, n), f32(0.0)
        surface = Surface(point, load(given, 6 * n + i), ng, ng, zero, zero, zero, ng, ng, ng, zero, to_int(zero),
                          to_int(zero), zero)
        store3(answers, i, n, above(surface) - point)

    given = np.concatenate([random.uniform(-100, 100, (3, COUNT)), _unit(random), random.uniform(0, 1e4, (1, COUNT))])
    wanted, got = both_answers(
        _scene(random), on_lanes, "let ng = vector(3u);\nlet surface = Surface(vector(0u), value(6u), ng, ng, "
        "vec2(0.0), 0.0, ng, ng, ng, false, 0);\nput_vector(0u, above(surface) - surface.point);", given, 3)
    assert (np.linalg.norm(wanted, axis=0) > 0).all()
    assert_close(got, wanted, 1.6e-5)  # the last place of a hundred


def test_closer(random):
    """Triangles of instances of one mesh; the CPU looks up the numbers that tell which of two comes first."""
    @inline
    def on_lanes(scene, given, answers, n, i):
        hit = Hit(load(given, i), f32(0.0), f32(0.0), to_int(load(given, n + i)), to_int(load(given, 2 * n + i)))
        t, inst, prim = load(given, 3 * n + i), to_int(load(given, 4 * n + i)), to_int(load(given, 5 * n + i))
        answer = f32(0.0)
        for one in range(3):
            for triangle in (0, 18, 36):
                asked = (inst == np.int32(one)) & (prim == np.int32(triangle))
                answer = select(closer(scene, hit, t, np.int32(one), np.int32(triangle), asked), f32(1.0), answer)
        store(answers, i, answer)

    scene = Scene().add(*[closed_meshes.icosphere(1)] * 3)
    given = random.integers(0, 3, (6, COUNT))
    given[3] -= 1
    given[[1, 5]] *= 18
    numbers = pack(scene).faces.view(dtype(FACE))["number"]
    assert (np.diff(numbers[[0, 18, 36]]) < 0).any()
    wanted, got = both_answers(
        scene, on_lanes, "let hit = Hit(value(0u), 0.0, 0.0, u32(value(6u)), u32(value(2u)));\n"
        "put_flag(0u, closer(hit, value(3u), u32(value(4u)), u32(value(7u))));",
        np.concatenate([given, numbers[given[[1, 5]]]]), 1)
    assert 0.1 < wanted.mean() < 0.9
    np.testing.assert_array_equal(got, wanted)
