"""A scene file becomes the objects it describes."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from glimt import linalg
from glimt.errors import GlimtWarning
from glimt.io import load
from glimt.scene.light import DirectionalLight, PointLight, SpotLight
from glimt.scene.motion import Orbit
from glimt.scene.motion import Path as MotionPath
from glimt.scene.scene import Scene

TRIANGLE = "positions = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\ntriangles = [[0, 1, 2]]\n"
LIGHT = '[[light]]\ntype = "point"\nposition = [0, 3, 0]\n'
SPHERE = "[[sphere]]\ncenter = [0, 0, 0]\nradius = 1\n"


@pytest.fixture
def read(tmp_path: Path):
    """Write a text as a scene file and load it."""
    def write_and_load(text: str) -> Scene:
        (tmp_path / "room.toml").write_text(text, "utf-8")
        return load(tmp_path / "room.toml")
    return write_and_load


def test_settings_and_camera(read):
    scene = read('[render]\nsize = [80, 60]\nsamples = 3\nmax_bounces = 4\nbackground = "#ff8000"\nambient = 0.25\n'
                 'exposure = -1\ntone_curve = "filmic"\n[camera]\nposition = [1, 2, 3]\ntarget = [0, 1, 0]\n'
                 'up = [0, 0, 1]\nfov_deg = 30\n' + SPHERE + LIGHT)
    settings, camera = scene.settings, scene.camera
    assert (settings.width, settings.height, settings.samples, settings.max_bounces) == (80, 60, 3, 4)
    # sRGB 128 is 0.21586 in linear light (IEC 61966-2-1).
    assert settings.background == pytest.approx((1.0, 0.2158605, 0.0), abs=1e-6)
    assert settings.ambient == (0.25, 0.25, 0.25)
    assert (settings.exposure, settings.tone_curve) == (-1.0, "filmic")
    assert (camera.position, camera.target, camera.up, camera.fov_deg) == ((1, 2, 3), (0, 1, 0), (0, 0, 1), 30)
    assert scene.name == "room"


def test_without_tables_the_defaults_of_the_scene_hold(read):
    scene = read(SPHERE + LIGHT)
    assert scene.camera is None
    assert vars(scene.settings) == vars(Scene().settings)
    assert scene.spheres()[0].material.diffuse == (0.8, 0.8, 0.8)


def test_materials_and_textures(read, tmp_path):
    Image.fromarray(np.arange(48, dtype=np.uint8).reshape(4, 4, 3)).save(tmp_path / "brick.png")
    scene = read('[[material]]\nname = "brick"\nambient = 0.1\ndiffuse = [1, 0.5, 0]\nspecular = 0.3\nexponent = 9\n'
                 'reflectivity = 0.5\nnormal_scale = 2\ndiffuse_texture = "brick.png"\n'
                 'normal_texture = { file = "brick.png", wrap = "clamp", scale = [2, 3], offset = [0.5, 0] }\n'
                 + SPHERE + 'material = "brick"\n' + LIGHT)
    material = scene.spheres()[0].material
    assert (material.ambient, material.diffuse, material.specular) == ((0.1,) * 3, (1, 0.5, 0), (0.3,) * 3)
    assert (material.exponent, material.reflectivity, material.normal_scale) == (9, 0.5, 2)
    diffuse, normal = material.diffuse_texture, material.normal_texture
    assert (diffuse.encoding, diffuse.wrap, normal.encoding, normal.wrap) == ("srgb", "repeat", "linear", "clamp")
    assert (normal.scale, normal.offset) == ((2, 3), (0.5, 0))
    assert np.array_equal(diffuse.pixels.ravel(), np.arange(48))
    assert np.shares_memory(diffuse.pixels, normal.pixels)


def test_a_texture_from_the_folder_above(tmp_path):
    (tmp_path / "scenes").mkdir()
    (tmp_path / "images").mkdir()
    Image.fromarray(np.zeros((2, 2, 3), np.uint8)).save(tmp_path / "images" / "a.png")
    file = tmp_path / "scenes" / "room.toml"
    file.write_text('[[material]]\nname = "a"\ndiffuse_texture = \'..\\images\\a.png\'\n' + SPHERE
                    + 'material = "a"\n' + LIGHT)
    assert load(file).spheres()[0].material.diffuse_texture.pixels.shape == (2, 2, 3)


def test_inline_mesh_stands_where_it_was_modelled(read):
    scene = read('[[material]]\nname = "red"\ndiffuse = [1, 0, 0]\n[[mesh]]\nname = "leaf"\nmaterial = "red"\n'
                 + TRIANGLE + "normals = [[0, 0, 1], [0, 0, 1], [0, 0, 1]]\n"
                 + "texcoords = [[0, 0], [1, 0], [0, 1]]\n" + LIGHT)
    [instance] = scene.instances()
    assert np.array_equal(instance.object_to_world, linalg.identity())
    mesh = instance.mesh
    assert mesh.name == "leaf"
    assert (mesh.positions.shape, mesh.normals.shape, mesh.texcoords.shape) == ((3, 3), (3, 3), (3, 2))
    assert [material.diffuse for material in mesh.materials] == [(1, 0, 0)]


def test_material_replaces_all_those_of_an_obj_file(read, tmp_path):
    (tmp_path / "two.mtl").write_text("newmtl a\nKd 1 0 0\nnewmtl b\nKd 0 1 0\n")
    (tmp_path / "two.obj").write_text("mtllib two.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
                                      "usemtl a\nf 1 2 3\nusemtl b\nf 1 2 4\n")
    mesh = '[[mesh]]\nname = "{}"\nfile = "two.obj"\n'
    scene = read('[[material]]\nname = "blue"\ndiffuse = [0, 0, 1]\n' + mesh.format("own") + mesh.format("blue")
                 + 'material = "blue"\n' + LIGHT)
    own, blue = (instance.mesh for instance in scene.instances())
    assert {material.diffuse for material in own.materials} >= {(1, 0, 0), (0, 1, 0)}
    assert [material.diffuse for material in blue.materials] == [(0, 0, 1)]
    assert not blue.material_ids.any()


def test_obj_files_share_the_images_they_have_in_common(read, tmp_path):
    Image.new("RGB", (2, 2)).save(tmp_path / "a.png")
    (tmp_path / "a.mtl").write_text("newmtl a\nmap_Kd a.png\n")
    for name in ("one.obj", "two.obj"):
        (tmp_path / name).write_text("mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n")
    scene = read('[[mesh]]\nfile = "one.obj"\n[[mesh]]\nfile = "two.obj"\n' + LIGHT)
    one, two = (instance.mesh.materials[0].diffuse_texture.pixels for instance in scene.instances())
    assert np.shares_memory(one, two)


def test_scale_then_rotations_in_order_then_translation(read):
    scene = read('[[mesh]]\nname = "leaf"\n' + TRIANGLE
                 + '[[instance]]\nname = "one"\nmesh = "leaf"\nscale = [2, 3, -4]\n'
                 "rotate = [{ axis = [0, 0, 2], angle_deg = 90 }, { axis = [1, 0, 0], angle_deg = 90 }]\n"
                 'translate = [10, 20, 30]\n[[instance]]\nmesh = "leaf"\nscale = 2\n'
                 "rotate = { axis = [0, 1, 0], angle_deg = 180 }\n" + LIGHT)
    one, two = scene.instances()
    # By hand: (1, 1, 1) is scaled to (2, 3, -4), turned about z to (-3, 2, -4), about x to (-3, 4, 2), then moved.
    assert linalg.transform_points(one.object_to_world, [1, 1, 1]) == pytest.approx((7, 24, 32))
    assert linalg.transform_points(two.object_to_world, [1, 1, 1]) == pytest.approx((-2, 2, -2))
    assert one.name == "one"
    assert one.mesh is two.mesh  # and it does not stand in its own place as well


@pytest.mark.parametrize("matrix", [
    "[1, 0, 0, 5, 0, 2, 0, 6, 0, 0, 3, 7]",
    "[1, 0, 0, 5, 0, 2, 0, 6, 0, 0, 3, 7, 0, 0, 0, 1]",
    "[[1, 0, 0, 5], [0, 2, 0, 6], [0, 0, 3, 7]]",
    "[[1, 0, 0, 5], [0, 2, 0, 6], [0, 0, 3, 7], [0, 0, 0, 1]]",
])
def test_matrix(read, matrix):
    scene = read('[[mesh]]\nname = "leaf"\n' + TRIANGLE + f'[[instance]]\nmesh = "leaf"\nmatrix = {matrix}\n' + LIGHT)
    assert scene.instances()[0].object_to_world.tolist() == [[1, 0, 0, 5], [0, 2, 0, 6], [0, 0, 3, 7]]


def test_lights(read):
    scene = read(SPHERE + '[[light]]\ntype = "point"\nname = "lamp"\nposition = [1, 2, 3]\nradius = 4\nambient = 0.1\n'
                 "attenuation = [1, 1, 0]\ndiffuse = [2, 1, 0]\nspecular = 0.5\nmotion = { orbit = { period = 4 } }\n"
                 '[[light]]\ntype = "spot"\nposition = [0, 4, 0]\ndirection = [0, -1, 0]\ninner_angle_deg = 5\n'
                 'outer_angle_deg = 10\n[[light]]\ntype = "directional"\ndirection = [0, -2, 0]\n'
                 "[light.motion.path]\ntimes = [0, 1]\npoints = [[0, -1, 0], [1, 0, 0]]\nloop = false\n")
    lamp, spot, sun = scene.lights
    assert isinstance(lamp, PointLight)
    assert (lamp.name, lamp.position, lamp.radius, lamp.attenuation) == ("lamp", (1, 2, 3), 4, (1, 1, 0))
    assert (lamp.ambient, lamp.diffuse, lamp.specular) == ((0.1,) * 3, (2, 1, 0), (0.5,) * 3)
    assert lamp.motion == Orbit((0, 0, 0), (0, 1, 0), 4)
    assert isinstance(spot, SpotLight)
    assert (spot.direction, spot.inner_angle_deg, spot.outer_angle_deg) == ((0, -1, 0), 5, 10)
    assert isinstance(sun, DirectionalLight)
    assert sun.motion == MotionPath((0, 1), ((0, -1, 0), (1, 0, 0)), loop=False)


def test_byte_order_mark_and_crlf(tmp_path):
    (tmp_path / "room.toml").write_bytes(b"\xef\xbb\xbf" + (SPHERE + LIGHT).replace("\n", "\r\n").encode())
    assert len(load(tmp_path / "room.toml").spheres()) == 1


def test_empty_file_warns_once_of_each_thing_missing(read):
    with pytest.warns(GlimtWarning) as caught:
        scene = read("")
    assert sorted(str(entry.message).split(": ")[-1] for entry in caught) == [
        "no lights, only ambient light is seen; add a [[light]]",
        "no objects, only the background is seen; add a [[mesh]] or [[sphere]]"]
    assert not scene.objects


def test_warnings_of_an_obj_file_are_counted_for_the_scene(read, tmp_path):
    (tmp_path / "flat.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n" + "f 1 2 2\n" * 5)
    with pytest.warns(GlimtWarning, match=r"flat\.obj") as caught:
        read('[[mesh]]\nfile = "flat.obj"\n' + LIGHT)
    assert [entry.message.count for entry in caught] == [5]
