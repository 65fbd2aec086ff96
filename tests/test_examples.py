"""The example scenes are what their script makes, and they are what they are said to be."""

import importlib
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from glimt import linalg, load, render
from glimt.io.example import example_path
from glimt.io.files_read import recorded
from glimt.scene.light import DirectionalLight, PointLight, SpotLight

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES = ROOT / "examples"
SCENES = ["stone_room", "instances", "mirrors"]
TEXTURES = ["wall", "floor", "plaster", "granite"]


@pytest.fixture(scope="module")
def example():
    """Import a module of the examples by name."""
    sys.path.insert(0, str(EXAMPLES))
    yield importlib.import_module
    sys.path.remove(str(EXAMPLES))


def pixels(path: Path) -> np.ndarray:
    with Image.open(path) as image:
        assert image.mode == "RGB"
        return np.asarray(image)


def world_corners(scene) -> np.ndarray:
    """Return the corners of all placed triangles, (n, 3, 3)."""
    return np.concatenate([linalg.transform_points(i.object_to_world, i.mesh.positions[i.mesh.triangles])
                           for i in scene.instances()])


def hits(corners: np.ndarray, origin: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Return which triangles a ray hits, by the signs of the volumes it spans with their edges."""
    a, b, c = np.moveaxis(corners - origin, 1, 0)
    volumes = np.stack([np.cross(p, q) @ direction for p, q in ((a, b), (b, c), (c, a))])
    inside = (volumes >= 0).all(0) | (volumes <= 0).all(0)
    ahead = (np.cross(b - a, c - a) * a).sum(-1) * (np.cross(b - a, c - a) @ direction) > 0
    return inside & ahead


def test_script_writes_the_files_that_are_kept(tmp_path):
    subprocess.run([sys.executable, str(EXAMPLES / "make_examples.py"), str(tmp_path)], check=True, timeout=120)
    made = {path.relative_to(tmp_path) for path in tmp_path.rglob("*") if path.is_file()}
    kept = {path.relative_to(EXAMPLES) for suffix in ("*.png", "*.obj", "*.mtl", "*.toml")
            for path in EXAMPLES.rglob(suffix)}
    assert made == kept
    for name in made:
        if name.suffix == ".png":
            # One level: FFTs and square roots may differ in the last bit between processors.
            difference = pixels(tmp_path / name).astype(int) - pixels(EXAMPLES / name)
            assert np.abs(difference).max() <= 1, name
        else:
            assert (tmp_path / name).read_bytes() == (EXAMPLES / name).read_bytes(), name


def test_files_stay_small():
    assert sum(path.stat().st_size for path in EXAMPLES.rglob("*") if path.is_file()) < 3e6


@pytest.mark.parametrize("name", TEXTURES + [f"{name}_normal" for name in TEXTURES])
@pytest.mark.parametrize("axis", [0, 1])
def test_textures_tile(name, axis):
    texture = np.moveaxis(pixels(EXAMPLES / "textures" / f"{name}.png").astype(int), axis, 0)
    steps = np.abs(np.roll(texture, -1, 0) - texture).mean((1, 2))
    assert steps[-1] <= steps[:-1].max(), "the seam stands out more than any line within"


@pytest.mark.parametrize("name", TEXTURES)
def test_normal_maps_hold_unit_vectors_that_follow_the_height_field(example, name):
    texture = getattr(example("stones"), name)()
    tile = getattr(example("stones"), f"{name.upper()}_TILE")
    normal = texture.normal / 127.5 - 1
    assert np.abs(np.linalg.norm(normal, axis=-1) - 1).max() <= 3**0.5 / 255
    height = texture.height * len(texture.height) / tile
    right = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) / 2
    up = (np.roll(height, 1, 0) - np.roll(height, -1, 0)) / 2
    assert right.std() > 0.01
    assert up.std() > 0.01
    np.testing.assert_allclose(normal[..., 0], -right * normal[..., 2], atol=0.03)
    np.testing.assert_allclose(normal[..., 1], -up * normal[..., 2], atol=0.03)


def test_normal_map_of_a_bump_points_away_from_its_middle(example):
    y, x = np.mgrid[-1:1:65j, -1:1:65j]  # y runs down, as rows do
    bump = np.maximum(0, 0.5 - np.hypot(x, y))
    red, green, _ = np.moveaxis(example("procedural").normal_map(bump, 2.0).astype(int) - 128, -1, 0)
    assert red[32, 24] < -60  # left of the middle
    assert red[32, 40] > 60
    assert green[24, 32] > 60  # above the middle: +Y is up
    assert green[40, 32] < -60


@pytest.mark.parametrize("name", ["room", "pedestal", "block", "gem", "ground", "petal", "torus", "quad"])
def test_meshes_are_wound_as_their_normals_say(example, name):
    modules = [example(module) for module in ("stone_room", "dahlia", "mirrors")]
    patches = next(module.MESHES[name] for module in modules if name in module.MESHES)
    for patch in patches:
        corners, normals = patch.positions[patch.polygons], patch.normals[patch.polygons].mean(1)
        wound = np.cross(corners, np.roll(corners, -1, 1)).sum(1)
        assert ((wound * normals).sum(-1) > 0).all()


def test_stone_room_is_the_papers_scene():
    scene = load(EXAMPLES / "stone_room.toml")
    assert len(world_corners(scene)) == 330
    assert (scene.settings.width, scene.settings.height) == (400, 400)
    assert (scene.settings.samples, scene.settings.max_bounces) == (1, 0)
    assert sorted(type(light).__name__ for light in scene.lights) == ["DirectionalLight", "PointLight"]
    assert len([sphere for sphere in scene.spheres() if sphere.material.reflectivity >= 0.6]) >= 2
    room = next(i.mesh for i in scene.instances() if i.mesh.name == "room")
    assert {material.name for material in room.materials} >= {"wall", "floor", "plaster"}
    assert all(material.diffuse_texture and material.normal_texture for material in room.materials)


def test_stone_room_is_closed_but_for_the_skylight(example):
    stone_room = example("stone_room")
    room = next(i for i in load(EXAMPLES / "stone_room.toml").instances() if i.mesh.name == "room")
    corners = room.mesh.positions[room.mesh.triangles].astype(np.float64)
    rim, escaped, origin = stone_room.HEIGHT + stone_room.CURB, 0, np.array([0.31, 1.7, 0.23])
    for direction in np.random.default_rng(0).standard_normal((500, 3)):
        if hits(corners, origin, direction).any():
            continue
        escaped += 1
        x, _, z = origin + direction * (rim - origin[1]) / direction[1]
        assert direction[1] > 0
        assert stone_room.LEFT <= x <= stone_room.RIGHT
        assert stone_room.BACK <= z <= stone_room.FRONT
    assert escaped > 10


def test_sun_falls_on_the_floor_and_the_wall_of_the_stone_room():
    scene = load(EXAMPLES / "stone_room.toml")
    corners = world_corners(scene)
    sun = next(light for light in scene.lights if isinstance(light, DirectionalLight))
    lit = {}
    for name, points in {"floor": np.mgrid[-3.9:3.9:20j, 0.001:0.001:1j, -3.9:3.9:20j],
                         "wall": np.mgrid[-3.9:3.9:20j, 0.1:3.9:20j, -3.999:-3.999:1j]}.items():
        lit[name] = np.mean([not hits(corners, point, -np.array(sun.direction)).any()
                             for point in points.reshape(3, -1).T])
    assert 0.05 < lit["floor"] < 0.5
    assert 0.02 < lit["wall"] < 0.5


def test_instances_are_a_thousand_of_one_mesh_in_four_materials():
    scene = load(EXAMPLES / "instances.toml")
    petals = [instance for instance in scene.instances() if instance.mesh.name == "petal"]
    assert len(petals) == 1000
    assert len({id(petal.mesh) for petal in petals}) == 1
    assert len({petal.material.name for petal in petals}) == 4
    mirrored = [np.linalg.det(petal.object_to_world[:, :3]) < 0 for petal in petals]
    assert sum(mirrored) == 500


def test_mirrors_has_mirrors_that_face_each_other_and_a_spot_light():
    scene = load(EXAMPLES / "mirrors.toml")
    assert scene.settings.max_bounces == 6
    assert [type(light) for light in scene.lights] == [SpotLight, PointLight, PointLight]
    facing = [linalg.transform_vectors(i.object_to_world, (0, 0, 1)) for i in scene.instances()
              if i.mesh.name == "quad" and i.material is None]
    assert len(facing) == 2
    assert facing[0] @ facing[1] < -0.99


@pytest.mark.parametrize("name", SCENES)
def test_every_example_renders(name):
    """Without a warning, too: warnings are errors in the tests."""
    image = render(load(EXAMPLES / f"{name}.toml"), size=(64, 48), samples=1, linear=True)
    assert image.shape == (48, 64, 3)
    assert np.isfinite(image).all()
    assert (image > 0).all()
    assert 0.05 < image.mean() < 0.5
    assert np.mean(image > 1) < 0.05, "over-exposed"


def test_bounces_show_the_mirrors_of_the_stone_room():
    scene = load(EXAMPLES / "stone_room.toml")
    without, with_mirrors = (render(scene, size=(64, 64), max_bounces=n, linear=True) for n in (0, 3))
    changed = np.abs(without - with_mirrors).max(-1) > 0.02
    assert 0.08 < changed.mean() < 0.5


def test_the_package_holds_all_that_the_stone_room_reads():
    """`glimt study` finds it where there is no checkout."""
    shipped = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    places = shipped["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]
    assert all(target == f"glimt/{source}" for source, target in places.items())
    with recorded() as files:
        load(example_path("stone_room.toml"))
    assert len(files) > 10
    for file in files:
        within = file.relative_to(ROOT)
        assert any(within.is_relative_to(source) for source in places), within
