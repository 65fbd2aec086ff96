"""Packing: what is stored once, where arrays start, what stands in each record."""

import numpy as np
import pytest

import closed_meshes
from glimt import (
    Camera,
    DirectionalLight,
    GlimtWarning,
    Instance,
    Material,
    Mesh,
    PointLight,
    Renderer,
    RenderSettings,
    Scene,
    Sphere,
    SpotLight,
    Texture,
    linalg,
)
from glimt.layout import (
    DIRECTIONAL_LIGHT,
    FACE,
    INSTANCE,
    INSTANCE_BLOCK,
    LEVEL,
    LIGHT,
    MATERIAL,
    MESH_KIND,
    MISS,
    NO_TANGENTS,
    NODE,
    POINT_LIGHT,
    SPAN,
    SPHERE_KIND,
    SPOT_LIGHT,
    TANGENT,
    TEXTURE,
    TRIANGLE,
    TRIANGLE_BLOCK,
    VERTEX,
    VIEW,
    dtype,
)
from glimt.packed import PackedScene, Packer, pack, pack_lights, pack_view

RECORDS = {"tlas_nodes": NODE, "tlas_blocks": INSTANCE_BLOCK, "blas_nodes": NODE, "blas_blocks": TRIANGLE_BLOCK,
           "instances": INSTANCE, "triangles": TRIANGLE, "faces": FACE, "vertices": VERTEX,
           "tangents": TANGENT, "materials": MATERIAL, "textures": TEXTURE, "levels": LEVEL, "lights": LIGHT,
           "spans": SPAN}
IMAGE = np.random.default_rng(0).integers(0, 256, (4, 4, 3)).astype(np.uint8)


def square(*materials, texcoords=True, normals=True, ids=None):
    return Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]],
                [[0, 0, 2]] * 4 if normals else None, [[0, 1], [1, 1], [1, 0], [0, 0]] if texcoords else None,
                materials or [Material()], ids)


def table(packed, name):
    return getattr(packed, name).view(dtype(RECORDS[name]))


SCENES = {
    "empty": Scene(),
    "sphere": Scene().add(Sphere((0, 0, 0), 1)),
    "mesh": Scene().add(square(), PointLight(position=(0, 0, 1))),
    "all": Scene().add(square(Material(diffuse_texture=Texture(IMAGE), normal_texture=Texture(IMAGE, "linear"))),
                       Instance(square(normals=False), linalg.scaling(2)), Sphere((0, 0, 3), 1),
                       *[DirectionalLight(direction=(0, 0, -1))] * 3),
}


@pytest.mark.parametrize("name", SCENES)
def test_arrays_are_whole_records_and_never_empty(name):
    packed = pack(SCENES[name])
    for field, array in packed._asdict().items():
        words = int(RECORDS[field].words) if field in RECORDS else 1
        assert array.dtype == np.float32, field
        assert array.ndim == 1, field
        assert array.flags.c_contiguous, field
        assert len(array) >= words or field == "spans", field  # which is there for brute force only
        assert len(array) % words == 0, field
    for field in ("tlas_nodes", "tlas_blocks", "blas_nodes", "blas_blocks", "vertices"):
        assert getattr(packed, field).ctypes.data % 64 == 0, field
    assert packed.memory_bytes() == sum(array.nbytes for array in packed)
    assert set(PackedScene._fields) == {*RECORDS, "texels"}


def test_indices_are_global():
    first, second = Material(), Material()
    meshes = square(first), square(second, first, ids=[1, 0])
    packed = pack(Scene().add(*meshes))
    triangles = table(packed, "triangles")
    np.testing.assert_array_equal(triangles["vertex"], [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])
    np.testing.assert_array_equal(triangles["material"], [0, 0, 0, 1])
    assert table(packed, "instances")["first_triangle"].tolist() == [0, 2]
    vertices = table(packed, "vertices")
    np.testing.assert_array_equal(vertices["position"], np.tile(meshes[0].positions, (2, 1)))
    np.testing.assert_array_equal(vertices["normal"], [[0, 0, 1]] * 8)  # at unit length
    np.testing.assert_array_equal(vertices["texcoord"], np.tile(meshes[0].texcoords, (2, 1)))


def test_meshes_materials_and_textures_are_stored_once():
    texture = Texture(IMAGE)
    shared = Material(diffuse_texture=texture)
    other = Material(diffuse_texture=Texture(IMAGE, wrap="clamp"), normal_texture=Texture(IMAGE, "linear"))
    mesh = square(shared, other, ids=[0, 1])
    scene = Scene().add(mesh, Instance(mesh, linalg.scaling(2)), Instance(mesh, linalg.scaling(3), other),
                        square(shared), Sphere((0, 0, 0), 1, shared))
    packed = pack(scene)
    assert len(table(packed, "materials")) == 2
    assert len(table(packed, "triangles")) == 4
    assert packed.texture_count == 3
    textures = table(packed, "textures")
    assert textures["first_level"].tolist() == [0, 0, 3]  # one pyramid for colour, one for data
    assert textures["clamp"].tolist() == [0, 1, 0]
    levels = table(packed, "levels")
    assert levels["width"].tolist() == levels["height"].tolist() == [4, 2, 1] * 2
    assert levels["first_texel"].tolist() == [0, 20, 26, 28, 48, 54]  # a row has one texel more
    assert len(packed.texels) == 56
    assert table(packed, "instances")["material"].tolist() == [-1, -1, 1, -1, 0]
    assert len({int(root) for root in table(packed, "instances")["root"][:3]}) == 1


def test_rows_of_texels_end_with_their_first():
    packed = pack(Scene().add(square(Material(diffuse_texture=Texture(IMAGE)))))
    rows = packed.texels[:20].view(np.int32).reshape(4, 5)
    np.testing.assert_array_equal(rows[:, 4], rows[:, 0])


def test_instance_records():
    matrix = linalg.compose(linalg.translation((1, 2, 3)), linalg.scaling((2, 4, -8)))
    scene = Scene().add(square(), Instance(square(normals=False), matrix), Sphere((5, 6, 7), 2))
    plain, placed, ball = table(pack(scene), "instances")
    assert [record["kind"] for record in (plain, placed, ball)] == [MESH_KIND, MESH_KIND, SPHERE_KIND]
    assert (plain["identity"], placed["identity"]) == (1, 0)
    assert (plain["flat"], placed["flat"]) == (0, 1)
    for mesh, untextured in ((square(), 0), (square(texcoords=False), 1)):
        assert table(pack(Scene().add(mesh)), "instances")["untextured"].tolist() == [untextured]
    np.testing.assert_array_equal(placed["object_to_world"].reshape(3, 4), matrix)
    product = linalg.compose(placed["object_to_world"].reshape(3, 4).astype(float),
                             placed["world_to_object"].reshape(3, 4).astype(float))
    np.testing.assert_allclose(product, np.eye(3, 4), atol=1e-6)
    assert placed["extent"] == 4
    assert ball["center"].tolist() == [5, 6, 7]
    assert (ball["radius"], ball["extent"]) == (2, 4)


def test_tangents_only_where_a_normal_map_needs_them():
    mapped = Material(normal_texture=Texture(IMAGE, "linear"))
    plain, bumpy, flat, bare = square(), square(mapped), square(mapped, normals=False), square(texcoords=False)
    overridden = square(mapped)
    scene = Scene().add(plain, bumpy, flat, bare, Instance(overridden, material=Material()))
    packed = pack(scene)
    shifts = table(packed, "instances")["tangent_shift"].tolist()
    assert [shift == NO_TANGENTS for shift in shifts] == [True, False, False, True, True]
    assert len(table(packed, "tangents")) == 4 + 6  # a flat square has three corners for each triangle
    np.testing.assert_allclose(table(packed, "tangents")["tangent"], [[1, 0, 0]] * 10, atol=1e-7)
    np.testing.assert_array_equal(table(packed, "tangents")["sign"], np.ones(10))
    assert (bumpy.normals is None, flat.normals is None) == (False, True)
    again = pack(Scene().add(Instance(plain, material=mapped)))
    assert table(again, "instances")["tangent_shift"][0] != NO_TANGENTS


def test_material_records():
    material = Material(ambient=0.5, diffuse=(0.25, 0.5, 1), specular=2, exponent=7, reflectivity=0.125,
                        normal_scale=-3, normal_texture=Texture(IMAGE, "linear", scale=(2, 3), offset=(4, 5)))
    packed = pack(Scene().add(square(material)))
    record, texture = table(packed, "materials")[0], table(packed, "textures")[0]
    assert record["ambient"].tolist() == [0.5] * 3
    assert record["diffuse"].tolist() == [0.25, 0.5, 1]
    assert record["specular"].tolist() == [2] * 3
    assert (record["exponent"], record["reflectivity"], record["normal_scale"]) == (7, 0.125, -3)
    assert (record["diffuse_texture"], record["normal_texture"]) == (-1, 0)
    assert (texture["scale"].tolist(), texture["offset"].tolist()) == ([2, 3], [4, 5])


def test_light_records():
    lights = [PointLight(position=(1, 2, 3), radius=4, attenuation=(1, 2, 3), diffuse=5, specular=6),
              SpotLight(position=(0, 0, 0), direction=(0, 0, -9), inner_angle_deg=30, outer_angle_deg=60),
              DirectionalLight(direction=(0, 3, 4))]
    point, spot, sun = pack_lights(lights).view(dtype(LIGHT))
    assert [record["kind"] for record in (point, spot, sun)] == [POINT_LIGHT, SPOT_LIGHT, DIRECTIONAL_LIGHT]
    assert (point["position"].tolist(), point["attenuation"].tolist()) == ([1, 2, 3], [1, 2, 3])
    assert (point["inverse_radius"], point["diffuse"][0], point["specular"][0]) == (0.25, 5, 6)
    assert spot["direction"].tolist() == [0, 0, -1]
    for angle, expected in ((30, 1), (60, 0)):
        cone = np.cos(np.radians(angle)) * spot["cone_scale"] + spot["cone_offset"]
        assert cone == pytest.approx(expected, abs=1e-6)
    assert sun["direction"] == pytest.approx([0, 0.6, 0.8])
    assert len(pack_lights([])) == LIGHT.words


def test_view_record():
    settings = RenderSettings(200, 100, background=0.5, ambient=0.25)
    lights = [DirectionalLight(direction=(0, 0, 1), ambient=0.5)]
    view = pack_view(Camera((1, 2, 3), (1, 2, 0), fov_deg=90), settings, lights).view(dtype(VIEW))[0]
    assert view["origin"].tolist() == [1, 2, 3]
    assert view["look"] == pytest.approx([0, 0, -1])
    assert view["right"] == pytest.approx([2, 0, 0])
    assert view["up"] == pytest.approx([0, 1, 0])
    assert view["spread"] == pytest.approx(0.02)
    assert (view["background"][0], view["ambient"][0]) == (0.5, 0.75)


def test_a_thousand_instances_cost_about_one_mesh():
    row, column = (part.ravel() for part in np.indices((100, 100)))
    corner = row * 101 + column
    points = np.concatenate([np.indices((101, 101)).reshape(2, -1), np.zeros((1, 101 * 101))]).T
    mesh = Mesh(points, np.concatenate([np.column_stack([corner, corner + 1, corner + 101]),
                                        np.column_stack([corner + 1, corner + 102, corner + 101])]))
    one = pack(Scene().add(mesh)).memory_bytes()
    scene = Scene().add(*[Instance(mesh, linalg.translation((k, 0, 0))) for k in range(1000)])
    packed = pack(scene)
    per_instance = (packed.memory_bytes() - one) / 1000
    assert per_instance < 400
    assert packed.memory_bytes() < 1.2 * one
    stats = Renderer(scene, threads=1).stats()
    assert (stats.meshes, stats.instances) == (1, 1000)
    assert (stats.triangles, stats.placed_triangles) == (20000, 20_000_000)
    assert stats.memory_bytes == packed.memory_bytes()


def test_textures_without_texcoords_are_warned_about_once_a_mesh():
    textured = Material(diffuse_texture=Texture(IMAGE))
    mesh = square(textured, texcoords=False)
    with pytest.warns(GlimtWarning, match="mesh 'mesh' has textures but no texcoords") as caught:
        pack(Scene().add(mesh, Instance(mesh, linalg.scaling(2))))
    assert len(caught) == 1
    with pytest.warns(GlimtWarning, match="no texcoords"):
        pack(Scene().add(Instance(square(texcoords=False), material=textured)))
    pack(Scene().add(Instance(mesh, material=Material())))  # where no texture is shown, none is missed


def shuffled(mesh, random):
    """Return a mesh with its triangles and vertices in any order, vertices that none uses, and three materials."""
    order, spare = random.permutation(len(mesh.positions) + 50), random.normal(size=(50, 3))
    place = np.argsort(order)
    return Mesh(np.concatenate([mesh.positions, spare])[order], place[random.permutation(mesh.triangles)],
                texcoords=random.random((len(order), 2)), materials=[Material() for _ in range(3)],
                material_ids=random.integers(3, size=len(mesh.triangles)))


@pytest.mark.parametrize("mapped", [False, True])
def test_triangles_and_vertices_are_in_the_order_of_the_leaves(mapped):
    random = np.random.default_rng(11)
    meshes = [shuffled(closed_meshes.icosphere(levels), random) for levels in (1, 3)]
    scene = Scene().add(*meshes)
    if mapped:  # with tangents, a flat mesh has vertices of its own for each triangle
        texture = Texture(np.full((2, 2, 3), 128, np.uint8), encoding="linear")
        for mesh in meshes:
            mesh.materials[0].normal_texture = texture
    packed = pack(scene)
    triangles, vertices, blocks = (table(packed, name) for name in ("triangles", "vertices", "blas_blocks"))
    assert len(vertices) == sum(3 * len(mesh.triangles) if mapped else len(mesh.positions) - 50 for mesh in meshes)
    prims = blocks["prim"][blocks["prim"] >= 0]
    np.testing.assert_array_equal(prims, np.concatenate([np.arange(len(mesh.triangles)) for mesh in meshes]))
    corners = triangles["vertex"].ravel()
    assert corners[0] == 0
    assert (corners[1:] <= np.maximum.accumulate(corners)[:-1] + 1).all()
    for k, record in enumerate(table(packed, "instances")):
        mesh, first = meshes[k], record["first_triangle"]
        here = slice(first, first + len(mesh.triangles))
        numbers = table(packed, "faces")["number"][here]
        np.testing.assert_array_equal(np.sort(numbers), np.arange(len(numbers)))
        own = mesh.triangles[numbers]
        np.testing.assert_array_equal(vertices["position"][triangles["vertex"][here]], mesh.positions[own])
        np.testing.assert_array_equal(vertices["texcoord"][triangles["vertex"][here]], mesh.texcoords[own])
        np.testing.assert_array_equal(triangles["material"][here], 3 * k + mesh.material_ids[numbers])
        asked = np.arange(len(numbers), dtype=np.int32)
        np.testing.assert_array_equal(packed.numbers_in_mesh(asked, np.full_like(asked, k)), numbers)


def test_numbers_of_spheres_and_of_nothing_stay():
    packed = pack(Scene().add(Sphere((0, 0, 0), 1), square()))
    inst, prim = np.array([[MISS, 0, MISS], [MISS, 0, 7]], np.int32)
    np.testing.assert_array_equal(packed.numbers_in_mesh(prim, inst), [MISS, 0, 7])
    np.testing.assert_array_equal(pack(Scene()).numbers_in_mesh(prim[:1], inst[:1]), [MISS])


def test_meshes_without_triangles_are_left_out():
    nothing = Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32))
    packed = pack(Scene().add(nothing, square()))
    assert len(table(packed, "instances")) == 1


def test_spans_tell_the_leaves_of_each_instance():
    small, large = square(), closed_meshes.icosphere(2)
    scene = Scene(objects=[Instance(large), Sphere((0, 0, 3), 1), Instance(small), Instance(large)])
    assert pack(scene).spans.size == 0
    packed = Packer(brute_force=True).pack(scene)
    spans = packed.spans.view(dtype(SPAN))
    blocks = packed.blas_blocks.view(dtype(TRIANGLE_BLOCK))["prim"]
    assert spans[0] == spans[3]
    assert spans[1]["blocks"] == 0
    for span, mesh in ((spans[0], large), (spans[2], small)):
        prims = blocks[span["first_block"]:span["first_block"] + span["blocks"]]
        assert sorted(prims[prims >= 0]) == list(range(len(mesh.triangles)))
        assert (np.diff((prims >= 0).astype(int), axis=1) <= 0).all()  # unused places come last
