"""Meshes with moved vertices."""

import gc
import weakref

import numpy as np
import pytest

from glimt import Camera, DirectionalLight, GlimtError, Material, Mesh, Renderer, RenderSettings, Scene, Texture
from glimt.layout import NODE
from glimt.packed.meshes import mesh_tree

SIDE = 24


def sheet(**options):
    """A square of SIDE×SIDE quads in the xy plane, with normals unless told otherwise."""
    row, column = (part.ravel() for part in np.indices((SIDE, SIDE)))
    corner = row * (SIDE + 1) + column
    triangles = np.concatenate([np.column_stack([corner, corner + 1, corner + SIDE + 1]),
                                np.column_stack([corner + 1, corner + SIDE + 2, corner + SIDE + 1])])
    y, x = np.indices((SIDE + 1, SIDE + 1)).reshape(2, -1) / SIDE
    points = np.column_stack([x, y, 0 * x])
    normals = np.broadcast_to([0, 0, 1], points.shape)
    return Mesh(points, triangles, **{"normals": normals, "texcoords": points[:, :2], **options})


def wave(mesh, phase):
    points = mesh.positions.copy()
    points[:, 2] = 0.1 * np.sin(7 * points[:, 0] + phase) + 0.1 * np.cos(5 * points[:, 1])
    return points


def picture(mesh):
    scene = Scene(camera=Camera((0.6, 0.3, 2), (0.5, 0.5, 0)), settings=RenderSettings(48, 48, background=0.1))
    return Renderer(scene.add(mesh, DirectionalLight(direction=(0.3, 0, -1)))).render().sums


def test_the_rest_is_shared():
    mesh = sheet()
    moved = mesh.with_positions(wave(mesh, 0))
    assert moved.triangles is mesh.triangles
    assert moved.texcoords is mesh.texcoords
    assert moved.material_ids is mesh.material_ids
    assert moved.materials == mesh.materials
    assert not mesh.positions[:, 2].any()
    assert mesh.bounds()[1].tolist() == [1, 1, 0]
    np.testing.assert_array_equal(moved.bounds(), [moved.positions.min(0), moved.positions.max(0)])


def test_normals_are_given_or_follow():
    mesh = sheet()
    given = mesh.with_positions(wave(mesh, 0), np.ones_like(mesh.positions))
    assert (given.normals == 1).all()
    tilted = mesh.positions @ np.array([[1, 0, 1], [0, 1, 0], [0, 0, 1]], np.float32)
    np.testing.assert_allclose(mesh.with_positions(tilted).normals, [[-np.sqrt(0.5), 0, np.sqrt(0.5)]] * (SIDE + 1)**2,
                               atol=1e-6)
    np.testing.assert_array_equal(mesh.with_positions(np.zeros_like(tilted)).normals, mesh.normals)  # nothing to go by
    assert sheet(normals=None).with_positions(tilted).normals is None


def test_normals_are_means_weighted_by_area():
    roof = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 3]], [[0, 1, 2], [0, 2, 3]], np.ones((4, 3)))
    moved = roof.with_positions(roof.positions)
    np.testing.assert_allclose(moved.normals[0], np.array([3, 0, 1]) / np.sqrt(10), atol=1e-6)
    np.testing.assert_allclose(moved.normals[[1, 3]], [[0, 0, 1], [1, 0, 0]], atol=1e-6)


@pytest.mark.parametrize(("positions", "normals", "message"), [
    (np.zeros((3, 3)), None, r"mesh 'sheet': positions has shape \(3, 3\), expected \(625, 3\)"),
    (np.full((625, 3), np.nan), None, "mesh 'sheet': positions has values that are not finite"),
    (np.zeros((625, 3)), np.zeros((625, 2)), "mesh 'sheet': normals has shape"),
])
def test_senseless_positions_are_refused(positions, normals, message):
    with pytest.raises(GlimtError, match=message):
        sheet(name="sheet").with_positions(positions, normals)


@pytest.mark.parametrize("options", [
    {}, {"normals": None}, {"materials": [Material(normal_texture=Texture(np.full((2, 2, 3), 0.7), "linear"))]}])
def test_pictures_are_those_of_a_new_mesh(options):
    mesh = sheet(**options)
    still = picture(mesh)
    for phase in range(3):
        moved = mesh.with_positions(wave(mesh, phase))
        anew = Mesh(moved.positions, moved.triangles, moved.normals, moved.texcoords, moved.materials)
        np.testing.assert_array_equal(picture(moved), picture(anew))
        mesh = moved
    assert not np.array_equal(picture(mesh), still)


def test_meshes_before_are_forgotten():
    scene = Scene().add(sheet())
    renderer = Renderer(scene)
    gone = []
    for phase in range(4):
        mesh = scene.objects[0].mesh
        gone.append(weakref.ref(mesh))
        scene.objects[0].mesh = mesh.with_positions(wave(mesh, phase))
        gone.append(weakref.ref(scene.objects[0].mesh))
        scene.objects[0].mesh = scene.objects[0].mesh.with_positions(wave(mesh, -phase))
        renderer.update()
    del mesh
    gc.collect()
    assert [each() for each in gone] == [None] * 8
    assert mesh_tree(scene.objects[0].mesh).depth > 1


def test_the_tree_keeps_its_shape_and_fits_the_moved_triangles():
    mesh = sheet()
    picture(mesh)
    moved = mesh.with_positions(wave(mesh, 0))
    picture(moved)
    before, after = mesh_tree(mesh), mesh_tree(moved)
    np.testing.assert_array_equal(after.leaf_prims, before.leaf_prims)
    codes = [tree.nodes.view(np.int32).reshape(-1, NODE.words)[:, NODE.child:NODE.order] for tree in (before, after)]
    np.testing.assert_array_equal(*codes)
    root = after.nodes[:NODE.words]
    lo, hi = root[NODE.lo_x:NODE.hi_x].reshape(3, 8), root[NODE.hi_x:NODE.child].reshape(3, 8)
    used = lo[0] <= hi[0]
    np.testing.assert_allclose(lo[:, used].min(1), moved.bounds()[0], atol=1e-5)
    np.testing.assert_allclose(hi[:, used].max(1), moved.bounds()[1], atol=1e-5)
