"""The renderer: what changes from frame to frame, what needs an update, and scenes with little in them."""

import numpy as np
import pytest

import glimt
from glimt import (
    Camera,
    DirectionalLight,
    GlimtError,
    GlimtWarning,
    Instance,
    Material,
    Mesh,
    Orbit,
    PointLight,
    Renderer,
    RenderSettings,
    Scene,
    Sphere,
    Texture,
    linalg,
)

FRONT = Camera((0.5, 0.25, 3), (0.5, 0.25, 0))
SUN = DirectionalLight(direction=(0, 0, -1))


def square(*materials, ids=None):
    return Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]],
                materials=materials or [Material(diffuse=0.5)], material_ids=ids)


def scene_of(*things, camera=FRONT, **settings):
    return Scene(camera=camera, settings=RenderSettings(**{"width": 1, "height": 1, **settings})).add(*things)


def seen(renderer, time=0.0):
    return renderer.render(time).radiance[0, 0].tolist()


def test_lights_camera_and_settings_change_without_an_update():
    scene = scene_of(square(), SUN)
    renderer = Renderer(scene)
    assert seen(renderer) == [0.5] * 3
    scene.lights.append(DirectionalLight(direction=(0, 0, -1), diffuse=(0, 1, 0)))
    assert seen(renderer) == [0.5, 1, 0.5]
    sun = scene.lights.pop(0)
    assert seen(renderer) == [0, 0.5, 0]
    scene.lights[0].diffuse = (0, 0, 3)
    assert seen(renderer) == [0, 0, 1.5]
    scene.lights = [sun]
    scene.camera = Camera((5, 5, 3), (5, 5, 0))
    scene.settings.background = (0.25, 0, 0)
    assert seen(renderer) == [0.25, 0, 0]
    scene.camera = FRONT
    scene.settings.ambient = (1, 0, 0)
    assert seen(renderer) == [1, 0.5, 0.5]
    scene.settings.width, scene.settings.height = 7, 3
    assert renderer.render().radiance.shape == (3, 7, 3)


def test_objects_and_materials_change_with_an_update():
    material = Material(diffuse=0.5)
    scene = scene_of(square(material), SUN)
    renderer = Renderer(scene)
    assert seen(renderer) == [0.5] * 3
    material.diffuse = (0.25, 0, 1)
    renderer.update()
    assert seen(renderer) == [0.25, 0, 1]
    material.diffuse_texture = Texture(np.zeros((1, 1, 3), np.uint8))
    scene.objects[0].mesh.texcoords = np.zeros((4, 2), np.float32)
    scene.objects.append(Sphere((0.5, 0.25, 0.5), 0.25, Material(diffuse=1)))
    renderer.update()
    assert seen(renderer) == pytest.approx([1, 1, 1], rel=1e-5)
    scene.objects[1].center = (9, 9, 9)
    renderer.update()
    assert seen(renderer) == [0, 0, 0]
    scene.objects[0].object_to_world = linalg.translation((50, 0, 0))
    scene.settings.background = 0.125, 0.125, 0.125
    renderer.update()
    assert seen(renderer) == [0.125] * 3


def test_a_normal_map_can_be_added_later():
    material = Material(diffuse=1)
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]],
                texcoords=[[0, 1], [1, 1], [1, 0], [0, 0]], materials=[material])
    renderer = Renderer(scene_of(mesh, SUN))
    assert seen(renderer) == [1, 1, 1]
    tilted = np.float32([0.6, 0, 0.8]) / 2 + 0.5
    material.normal_texture = Texture(np.tile(tilted, (1, 1, 1)), "linear")
    renderer.update()
    assert seen(renderer) == pytest.approx([0.8] * 3, abs=2e-3)
    material.normal_texture = None
    renderer.update()
    assert seen(renderer) == [1, 1, 1]


def test_lights_move_with_time():
    lamp = PointLight(position=(0.5, 0.25, 1), attenuation=(1, 0, 0), motion=Orbit((0.5, 0.25, 0), (1, 0, 0), 2))
    renderer = Renderer(scene_of(square(Material(diffuse=1)), lamp))
    assert seen(renderer, 0) == pytest.approx([1] * 3)
    assert seen(renderer, 0.25) == pytest.approx([np.sqrt(0.5)] * 3, rel=1e-5)
    assert seen(renderer, 1) == [0] * 3
    assert glimt.render(renderer.scene, time=0.25, linear=True)[0, 0] == pytest.approx([np.sqrt(0.5)] * 3, rel=1e-5)


def test_materials_of_triangles_and_instances():
    red, blue, green = (Material(ambient=color, diffuse=0) for color in ((1, 0, 0), (0, 0, 1), (0, 1, 0)))
    mesh = square(red, blue, ids=[0, 1])
    settings = {"width": 8, "height": 8, "ambient": 1,
                "camera": Camera((0.5, 0.5, 4), (0.5, 0.5, 0), fov_deg=float(np.degrees(2 * np.arctan(0.5 / 4))))}
    picture = Renderer(scene_of(mesh, **settings)).render().radiance
    rows, columns = np.indices((8, 8))
    lower_right, upper_left = columns + rows > 7, columns + rows < 7
    np.testing.assert_array_equal(picture[lower_right], np.broadcast_to([1, 0, 0], (28, 3)))
    np.testing.assert_array_equal(picture[upper_left], np.broadcast_to([0, 0, 1], (28, 3)))
    whole = Renderer(scene_of(Instance(mesh, material=green), **settings)).render().radiance
    np.testing.assert_array_equal(whole, np.broadcast_to([0, 1, 0], (8, 8, 3)))


def test_no_lights():
    assert seen(Renderer(scene_of(square()))) == [0] * 3
    assert seen(Renderer(scene_of(square(), ambient=0.5))) == [0.25] * 3


@pytest.mark.parametrize("things", [[], [SUN], [Mesh(np.zeros((0, 3)), np.zeros((0, 3)))],
                                    [Mesh(np.zeros((3, 3)), np.zeros((0, 3))), SUN]])
def test_scenes_without_anything_show_the_background(things):
    scene = scene_of(*things, camera=None, width=5, height=4, background=(1, 2, 3), samples=2, max_bounces=3)
    film = Renderer(scene).render()
    np.testing.assert_array_equal(film.radiance, np.broadcast_to(np.float32([1, 2, 3]), (4, 5, 3)))
    assert film.counters.shadow == film.counters.mirror == film.counters.non_finite == 0
    stats = Renderer(scene).stats()
    assert (stats.triangles, stats.spheres, stats.tree_depth) == (0, 0, 0)


def test_triangles_without_area_are_not_seen_and_do_no_harm():
    flat = Mesh([[0, 0, 0], [1, 1, 0], [0.5, 0.5, 0], [0.5, 0.25, 0]], [[0, 1, 2], [3, 3, 3], [0, 0, 1]])
    film = Renderer(scene_of(flat, SUN, width=9, height=9, background=1)).render()
    np.testing.assert_array_equal(film.radiance, np.ones((9, 9, 3), np.float32))


def test_textures_without_texcoords_show_one_colour():
    texture = Texture(np.full((2, 2, 3), 0.25, np.float32), "linear")
    scene = scene_of(square(Material(diffuse=1, diffuse_texture=texture, normal_texture=texture)), SUN, width=4,
                     height=4, camera=Camera((0.5, 0.5, 3), (0.5, 0.5, 0), fov_deg=5))
    with pytest.warns(GlimtWarning, match="no texcoords"):
        picture = Renderer(scene).render().radiance
    np.testing.assert_allclose(picture, 0.25, rtol=3e-3)


def test_render_takes_options_and_leaves_the_scene_alone():
    scene = scene_of(square(), SUN, exposure=1)
    picture = glimt.render(scene, size=(6, 4), samples=2, max_bounces=1, threads=1)
    assert picture.shape == (4, 6, 3)
    assert picture.dtype == np.uint8
    linear = glimt.render(scene, size=(6, 4), linear=True)
    assert linear.dtype == np.float32
    assert linear.flags.c_contiguous
    assert (scene.settings.width, scene.settings.samples) == (1, 1)
    assert glimt.render(scene).tolist() == [[[255] * 3]]  # 0.5, one stop up
    assert glimt.render(scene_of(square(), SUN)).tolist() == [[[188] * 3]]


@pytest.mark.parametrize(("options", "message"), [
    ({"size": (0, 5)}, "settings: width is 0"), ({"samples": 0}, "settings: samples is 0"),
    ({"max_bounces": -1}, "settings: max_bounces is -1"), ({"threads": 0}, "threads is 0, expected 1 to 1024"),
    ({"threads": 10**6}, "threads is 1000000"), ({"time": float("nan")}, "render: time is nan"),
])
def test_render_refuses_what_makes_no_sense(options, message):
    with pytest.raises(GlimtError, match=message):
        glimt.render(scene_of(square()), **options)


def test_unknown_engines_are_refused():
    with pytest.raises(GlimtError, match="there is no engine 'tpu'; expected 'auto', 'cpu' or 'gpu'"):
        Renderer(Scene(), engine="tpu")


def test_supersampling_averages_a_grid():
    """An edge through the middle of a pixel: n×n samples see it to 1/n."""
    camera = Camera((0, 0.5, 3), (0, 0.5, 0), fov_deg=1)
    for samples in (2, 4, 8):
        picture = scene_of(square(Material(diffuse=1)), camera=camera, ambient=1, samples=samples)
        assert glimt.render(picture, linear=True)[0, 0, 0] == 0.5
    third = Camera((-0.01, 0.5, 3), (-0.01, 0.5, 0), fov_deg=float(np.degrees(2 * np.arctan(0.03 / 3))))
    picture = scene_of(square(Material(diffuse=1)), camera=third, ambient=1, samples=6)
    assert glimt.render(picture, linear=True)[0, 0, 0] == pytest.approx(1 / 3, abs=1e-6)


def test_stats():
    texture = Texture(np.zeros((4, 4, 3), np.uint8))
    mesh = square(Material(diffuse_texture=texture), Material(), ids=[0, 1])
    mesh.texcoords = np.zeros((4, 2), np.float32)
    scene = scene_of(mesh, Instance(mesh, linalg.scaling(2), Material()), Sphere((0, 0, 0), 1), SUN)
    stats = Renderer(scene).stats()
    assert (stats.triangles, stats.placed_triangles, stats.meshes, stats.instances) == (2, 4, 1, 2)
    assert (stats.spheres, stats.lights, stats.materials, stats.textures) == (1, 1, 4, 1)
    assert stats.texture_bytes == 4 * (4 * 5 + 2 * 3 + 2)
    assert stats.tree_depth == 1


def test_progress_is_told():
    told = []
    scene = scene_of(square(), SUN)
    Renderer(scene, progress=lambda stage, share: told.append((stage, share))).render(
        progress=lambda stage, share: told.append((stage, share)))
    assert ("building trees", 0.0) in told
    assert all(0 <= share <= 1 for _, share in told)


def test_what_computes_is_told():
    assert [Renderer(Scene(), threads=threads, engine="cpu").engine_name for threads in (1, 3)] == [
        "CPU, 1 thread", "CPU, 3 threads"]
