"""Packing again: as good as packing anew, nothing done twice, nothing held twice."""

import gc
import tracemalloc

import numpy as np
import pytest

from glimt import GlimtError, Instance, Material, Mesh, PointLight, Renderer, Scene, Sphere, Texture, linalg
from glimt.packed import Packer, pack
from glimt.packed.meshes import _PACKED, mesh_tree

RNG = np.random.default_rng(8)
IMAGE = RNG.integers(0, 256, (8, 4, 3)).astype(np.uint8)


def cloud(count, *materials, texcoords=False):
    triangles = np.arange(3 * count).reshape(-1, 3)
    points = RNG.random((count, 1, 3)) + 0.1 * RNG.random((count, 3, 3))
    return Mesh(points.reshape(-1, 3), triangles, RNG.random((3 * count, 3)),
                RNG.random((3 * count, 2)) if texcoords else None, list(materials) or [Material()],
                np.arange(count) % max(1, len(materials)))


def placement(seed):
    rng = np.random.default_rng(seed)
    return linalg.compose(linalg.translation(rng.normal(size=3) * 9), linalg.rotation(rng.normal(size=3), 50 * seed),
                          linalg.scaling(rng.uniform(0.5, 2, 3) * (-1, 1, 1)))


@pytest.fixture
def scene():
    plain = cloud(50)
    painted = cloud(40, Material(diffuse_texture=Texture(IMAGE)), Material(0.25), texcoords=True)
    scene = Scene().add(Instance(plain, placement(1)), Instance(painted), Sphere((1, 2, 3), 2), Instance(plain),
                        PointLight(position=(9, 9, 9)))
    scene.add(*[Instance(plain, placement(seed), Material(diffuse=seed / 40)) for seed in range(2, 30)])
    return scene


def move(scene):
    for k, thing in enumerate(scene.instances()):
        thing.object_to_world = placement(100 + k)
    scene.spheres()[0].center = (7, 7, 7)


def repaint(scene):
    material = scene.objects[1].mesh.materials[1]
    material.diffuse, material.exponent = (0.0, 0.5, 1.0), 3.0


def override(scene):
    scene.objects[0].material = Material(diffuse=0.125)


def normal_map(scene):
    scene.objects[1].mesh.materials[1].normal_texture = Texture(IMAGE, "linear")


def other_pixels(scene):
    scene.objects[1].mesh.materials[0].diffuse_texture = Texture(IMAGE[::2])


def same_pixels_in_linear(scene):
    scene.objects[1].mesh.materials[1].diffuse_texture = Texture(IMAGE, "linear")


def add_in_front(scene):
    scene.objects.insert(0, Instance(cloud(30, Material(0.75), Material(0.5)), placement(77)))


def remove(scene):
    del scene.objects[0:4]


def empty(scene):
    scene.objects.clear()


CHANGES = [move, repaint, override, normal_map, other_pixels, same_pixels_in_linear, add_in_front, remove, empty]


@pytest.mark.parametrize("change", CHANGES)
def test_packing_again_is_as_good_as_packing_anew(scene, change):
    packer = Packer()
    before = packer.pack(scene)
    kept = [array.copy() for array in before]
    change(scene)
    again = packer.pack(scene)
    for mesh in {thing.mesh for thing in scene.instances()}:
        _PACKED.pop(mesh)
    for name, one, other in zip(again._fields, again, pack(scene), strict=True):
        np.testing.assert_array_equal(one.view(np.int32), other.view(np.int32), name)
    for one, other in zip(before, kept, strict=True):
        np.testing.assert_array_equal(one.view(np.int32), other.view(np.int32))


@pytest.mark.parametrize(("change", "changed"), [
    (lambda scene: None, {"instances", "materials", "textures", "lights"}),
    (repaint, {"instances", "materials", "textures", "lights"}),
    (move, {"instances", "materials", "textures", "lights", "tlas_nodes", "tlas_blocks"}),
    (other_pixels, {"instances", "materials", "textures", "lights", "levels", "texels"}),
])
def test_what_has_not_changed_is_kept(scene, change, changed):
    packer = Packer()
    before = packer.pack(scene)
    change(scene)
    after = packer.pack(scene)
    assert {name for name in before._fields if getattr(before, name) is not getattr(after, name)} == changed


def test_a_mesh_shared_by_two_scenes_stays_right_in_both(scene):
    packer = Packer()
    first = packer.pack(scene)
    kept = [array.copy() for array in first]
    mesh = scene.objects[1].mesh
    alone = pack(Scene().add(Instance(mesh, material=Material(normal_texture=Texture(IMAGE, "linear"))), mesh))
    other = pack(Scene().add(cloud(5), mesh, scene.objects[0].mesh))
    for packed in (first, packer.pack(scene)):
        for name, one, before in zip(packed._fields, packed, kept, strict=True):
            np.testing.assert_array_equal(one.view(np.int32), before.view(np.int32), name)
    assert alone.tangents.size > 4
    assert other.tangents.size == 4


def test_trees_survive_joining(scene):
    mesh = scene.objects[1].mesh
    pack(Scene().add(mesh))
    alone = mesh_tree(mesh)
    pack(scene)
    joined = mesh_tree(mesh)
    np.testing.assert_array_equal(joined.nodes.view(np.int32), alone.nodes.view(np.int32))
    np.testing.assert_array_equal(joined.leaf_prims, alone.leaf_prims)
    assert joined.depth == alone.depth


@pytest.mark.parametrize("parts", [1, 3])
def test_a_large_mesh_takes_160_bytes_a_triangle_all_told(parts):
    """Mesh, tree, blocks and shading arrays; after updates too."""
    side = 120
    row, column = (part.ravel() for part in np.indices((side, side)))
    corner = row * (side + 1) + column
    triangles = np.concatenate([np.column_stack([corner, corner + 1, corner + side + 1]),
                                np.column_stack([corner + 1, corner + side + 2, corner + side + 1])])
    points = np.concatenate([np.indices((side + 1, side + 1)).reshape(2, -1), np.zeros((1, (side + 1)**2))]).T
    points[:, 2] = np.sin(points[:, 0]) + np.cos(points[:, 1])
    Renderer(Scene().add(cloud(9000)))  # what is allocated once
    gc.collect()
    tracemalloc.start()
    try:
        scene = Scene().add(*[Mesh(points, triangles, points) for _ in range(parts)])
        renderer = Renderer(scene)
        renderer.update()
        gc.collect()
        current, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert current / (parts * len(triangles)) < 160


@pytest.mark.parametrize(("matrix", "message"), [
    (np.eye(4), r"instance 'odd': object_to_world has shape \(4, 4\), expected \(3, 4\)"),
    (np.zeros((3, 4)), "instance 'odd': object_to_world has no inverse"),
    (np.full((3, 4), np.nan), "instance 'odd': object_to_world has no inverse"),
    (np.diag([1e-20, 1, 1, 1])[:3], "instance 'odd': object_to_world has no inverse"),
    ("turned", "instance 'odd': object_to_world"),
])
def test_a_senseless_placement_set_by_hand_is_named(scene, matrix, message):
    renderer = Renderer(scene)
    scene.objects[3].name = "odd"
    scene.objects[3].object_to_world = matrix
    with pytest.raises(GlimtError, match=message):
        renderer.update()
    scene.objects[3].object_to_world = linalg.identity()
    renderer.update()
