"""OBJ files from the wild: each loads, with the triangles its source says and the warnings it deserves."""

import warnings

import numpy as np
import pytest

from glimt.errors import WarningCounter
from glimt.io.obj import read_obj

NO_WARNING: dict[str, int] = {}

# file: (triangles, of these without area and dropped, materials in use, {start of a warning: its count})
FILES = {
    "stone_room/room.obj": (114, 0, 3, NO_WARNING),
    "stone_room/light_ball.obj": (80, 0, 1, {"Ke is not drawn": 1}),
    "windmill/windmill.obj": (2722, 0, 2, {"map_ns": 1}),
    "medieval_building/Medieval_building.obj": (16715, 112, 20, {"a triangle without area": 112, "a material is": 28}),
    "brick_suzanne/brick_suzanne.obj": (968, 0, 1, NO_WARNING),
    "brick_suzanne/suzanne.obj": (968, 0, 1, NO_WARNING),
    "cornell_box/cornell_box.obj": (36, 0, 4, NO_WARNING),
    "spider/spider.obj": (1368, 56, 4, {"a triangle without area": 56}),
    "stanford_bunny/stanford-bunny.obj": (69451, 0, 1, NO_WARNING),
    "spot/spot.obj": (5856, 0, 1, NO_WARNING),
    "kuka_segment/segment.obj": (1536, 0, 2, NO_WARNING),
    "box_complex_material/box-complex-material.obj": (12, 0, 1, {
        "box-complex-material.mtl has transparent": 1, "Ke is": 1, "map_ka": 1, "map_ke": 1, "map_ks": 1, "map_ns": 1}),
    "box_complex_material/box-complex-material-alpha.obj": (12, 0, 1, {
        "box-complex-material-alpha.mtl has transparent": 1, "Ke is": 1, "map_ka": 1, "map_ke": 1, "map_ks": 1,
        "map_ns": 1, "map_d": 1}),
    "obj_features/cube.obj": (12, 0, 3, NO_WARNING),
    "obj_features/cube-vertexcol.obj": (12, 0, 3, {"vertex colours": 8}),
    "obj_features/map-bump.obj": (400, 0, 2, {"there is no file 'bump.jpg'; no bump map": 1}),
    "obj_features/smoothing-normal.obj": (6, 0, 1, NO_WARNING),
    "obj_features/mtllib-multiple-files-issue-112.obj": (1, 0, 1, {
        "there is no MTL file 'invalid-file-aaa.mtl'": 1, "there is no MTL file 'invalid-file-bbb.mtl'": 1,
        "Kd 0 0 0": 1, "there is no file 'tmp.png'; a checker": 1}),
    "obj_features/texture-options-issue-85.obj": (1, 0, 1, {
        "map_ks": 1, "map_ns": 1, "map_ka": 1, "Kd 0 0 0": 1, "there is no file 'diffuse.jpg'": 1,
        "there is no file 'bumpmap.jpg'": 1}),
    "obj_features/usemtl-issue-68.obj": (400, 0, 2, NO_WARNING),
    "obj_features/issue-295-trianguation-failure.obj": (28, 0, 1, NO_WARNING),
    "obj_features/tr-and-d-issue-43.obj": (400, 0, 2, {"tr-and-d-issue-43.mtl has transparent": 1}),
    "obj_features/pbr-mat-ext.obj": (2, 0, 1, {
        "Ke is": 1, "map_ke": 1, "map_pr": 1, "map_pm": 1, "map_ps": 1, "there is no file 'normalmap.tex'": 1}),
    "obj_features/catmark_torus_creases0.obj": (64, 0, 1, {
        "a face refers to a normal that the file does not have": 128, "statement 't' is not part of OBJ": 8}),
    "obj_features/box-negative-indices.obj": (12, 0, 1, NO_WARNING),
    "obj_features/box-textured.obj": (12, 0, 1, NO_WARNING),
    "obj_features/box-groups.obj": (36, 0, 3, NO_WARNING),
    "meshes/armadillo.obj": (50000, 0, 1, NO_WARNING),
    "meshes/nefertiti.obj": (99938, 0, 1, NO_WARNING),
}


@pytest.mark.parametrize("name", FILES)
def test_real_file(real_scenes, name):
    triangles, dropped, materials, expected = FILES[name]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        mesh = read_obj(real_scenes / name)
    assert len(mesh.triangles) == triangles - dropped
    assert len(mesh.materials) == materials
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=2e-3)
    found = {}
    for warning in caught:
        text = str(warning.message).split(": ", 1)[1]
        kind = next((start for start in expected if text.startswith(start)), text)
        found[kind] = found.get(kind, 0) + warning.message.count
    assert found == expected


def test_all_real_files_are_listed(real_scenes):
    assert {path.relative_to(real_scenes).as_posix() for path in real_scenes.glob("*/*.obj")} == set(FILES)


def test_polygons_of_the_stone_room_do_not_overlap(real_scenes):
    """Its floor and ceiling are concave; all their triangles must face the way the corners' normals do."""
    mesh = read_obj(real_scenes / "stone_room" / "room.obj", warnings=WarningCounter())
    a, b, c = np.moveaxis(mesh.positions[mesh.triangles].astype(float), 1, 0)
    facing = np.einsum("ij,ij->i", np.cross(b - a, c - a), mesh.normals[mesh.triangles].sum(1))
    assert (facing > 0).all()


def test_maps_of_the_real_files(real_scenes):
    counter = WarningCounter()
    windmill = read_obj(real_scenes / "windmill" / "windmill.obj", warnings=counter)
    assert all(m.normal_texture and m.diffuse_texture for m in windmill.materials)
    assert windmill.materials[0].normal_texture.pixels.dtype == np.uint8  # map_Bump names a normal map
    box = read_obj(real_scenes / "box_complex_material" / "box-complex-material.obj", warnings=counter)
    assert box.materials[0].normal_texture is not None
    assert box.materials[0].diffuse_texture.name == "diffuse.png"
