"""Everything OBJ files do in the wild, one test each."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from glimt.errors import GlimtError, GlimtWarning, WarningCounter
from glimt.io.obj import read_obj
from glimt.io.obj_text import parse_text

SQUARE = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\n"


@pytest.fixture
def load(tmp_path):
    """Return a function that writes `text` to scene/mesh.obj, other files beside it, and reads the OBJ."""
    folder = tmp_path / "scene"
    folder.mkdir()

    def load(text, **files):
        for name, content in files.items():
            path = folder / name.replace("__", ".")
            path.write_text(content)
        path = folder / "mesh.obj"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_obj(path)

    load.folder = folder
    return load


def corner_positions(mesh):
    return mesh.positions[mesh.triangles]


def total_area(mesh):
    a, b, c = np.moveaxis(corner_positions(mesh).astype(float), 1, 0)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


def test_triangle(load):
    mesh = load("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert corner_positions(mesh).tolist() == [[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]
    assert mesh.normals.tolist() == [[0, 0, 1]] * 3
    assert mesh.texcoords is None
    assert mesh.name == "mesh"
    assert [m.name for m in mesh.materials] == ["default"]


def test_texcoords_have_their_origin_at_the_top_left(load):
    mesh = load("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.25 0\nvt 1 0.125\nvt 3 -2\nf 1/1 2/2 3/3\n")
    assert mesh.texcoords[mesh.triangles[0]].tolist() == [[0.25, 1], [1, 0.875], [3, 3]]


def test_corners_that_agree_share_a_vertex_and_others_do_not(load):
    mesh = load(SQUARE + "vt 0 0\nvt 1 1\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\nf 1/1/1 3/2/1 4/1/1\n")
    assert len(mesh.positions) == 5
    assert mesh.triangles[0, 0] == mesh.triangles[1, 0]
    assert mesh.triangles[0, 2] != mesh.triangles[1, 1]


@pytest.mark.parametrize("face", ["f 1 2 3", "f 1/1 2/2 3/3", "f 1//1 2//2 3//3", "f 1/1/1 2/2/2 3/3/3", "f 1/ 2/ 3/",
                                  "f 1// 2// 3//", "f -3 -2 -1", "f -3/-3/-3 -2/-2/-2 -1/-1/-1", "f +1 2 3", "fo 1 2 3",
                                  "  f\t1  2 3  # f 3 2 1", "f 1 2 3#", "f 1 \\\n2 3", "f 1 2 3 \\\n"])
def test_forms_of_a_face(load, face):
    mesh = load("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\nvn 0 0 1\nvn 0 0 1\n" + face)
    assert corner_positions(mesh).tolist() == [[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]


def test_negative_indices_count_back_from_what_has_been_read(load):
    mesh = load("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 5\nv 1 0 5\nv 0 1 5\nf -3 -2 -1\nf 1 2 -1\n")
    assert corner_positions(mesh)[:, :, 2].tolist() == [[0, 0, 0], [5, 5, 5], [0, 0, 5]]


def test_a_face_may_come_before_its_vertices(load):
    assert len(load("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n").triangles) == 1


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_line_ends_and_continuations(load, end):
    text = ["v 0 0 0", "v 2 0 \\", "0", "", "v 2 2 0", "v 0 2 0", "f 1 2 \\", "  3 \\", "4", "f 9 9 9"]
    with pytest.raises(GlimtError, match=r"mesh\.obj:10: face refers to vertex 9 of 4"):
        load(end.join(text))
    assert total_area(load(end.join(text[:-1]))) == 4


def test_a_comment_ends_with_its_line_whatever_it_ends_with(load):
    assert len(load("# C:\\meshes\\\nv 0 0 0\nv 1 0 0 # at home \\\nv 0 1 0\nf 1 2 3").triangles) == 1


@pytest.mark.parametrize(("text", "value"), [
    ("1.", 1), (".5", 0.5), ("-1e-3", -1e-3), ("+1", 1), ("1E2", 100), ("-.5e+1", -5), ("0007", 7), ("-0", 0),
    ("123456789012345678901234567890e-25", 12345.678901234567), ("0." + "0" * 300 + "1e301", 1), ("1e-400", 0),
    ("1" + "0" * 300 + "e-300", 1), ("0e99999999999999999999", 0), ("3.4028234e-38", 3.4028234e-38),
    ("16777217", 16777216), ("0.1", 0.1), ("1e-99999999999999999999", 0)])
def test_numbers(load, text, value):
    mesh = load(f"v {text} 0 0\nv 1 5 0\nv 0 1 9\nf 1 2 3\n")
    assert mesh.positions[0, 0] == np.float32(value)


@pytest.mark.parametrize("line", ["v 1 2 3 0.5", "v 1 2 3", "v\t1 \t2\t3\t", "  v 1 2 3", "v 1 2 3 # 4 5 6"])
def test_what_else_a_vertex_line_may_hold(load, line):
    assert load(line + "\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").positions[0].tolist() == [1, 2, 3]


def test_vertex_colors_are_ignored_and_counted(load):
    with pytest.warns(GlimtWarning, match=r"mesh\.obj:2: vertex colours are ignored \(2 times") as caught:
        mesh = load("v 0 0 0\nv 1 0 0 0.5 0.5 0.5\nv 0 1 0 1 1 1 1\nf 1 2 3\n")
    assert len(caught) == 1
    assert mesh.positions[1].tolist() == [1, 0, 0]


def test_texcoords_of_one_and_three_components(load):
    mesh = load("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5\nvt 0.25 0.5 0.75\nvt 1 1\nf 1/1 2/2 3/3\n")
    assert mesh.texcoords.tolist() == [[0.5, 1], [0.25, 0.5], [1, 0]]


def test_a_corner_without_texcoord_gets_zero(load):
    mesh = load("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5 0.5\nf 1/1 2 3\n")
    assert mesh.texcoords.tolist() == [[0.5, 0.5], [0, 0], [0, 0]]


def test_a_byte_order_mark_is_skipped(load):
    assert len(load(b"\xef\xbb\xbfv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").triangles) == 1


@pytest.mark.parametrize(("name", "encoding"), [
    ("Wände", "utf-8"), ("Wände", "latin-1"), ("стена", "utf-8"), ("wall #3", "utf-8")])
def test_material_names_of_any_alphabet(load, name, encoding):
    (load.folder / "m.mtl").write_bytes(f"newmtl {name}\nKd 1 0 0\n".encode(encoding))
    mesh = load(f"mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl {name}\nf 1 2 3\n".encode(encoding))
    assert [m.diffuse for m in mesh.materials] == [(1, 0, 0)]
    assert mesh.materials[0].name == name


# Materials

TWO = SQUARE + "usemtl red\nf 1 2 3\nusemtl blue\nf 1 3 4\n"
RED, BLUE = "newmtl red\nKd 1 0 0\n", "newmtl blue\nKd 0 0 1\n"


@pytest.mark.parametrize("lines", [
    "mtllib a.mtl b.mtl\n" + TWO, "mtllib a.mtl\nmtllib b.mtl\n" + TWO, TWO + "mtllib a.mtl b.mtl\n",
    "mtllib b.mtl \\\n a.mtl\n" + TWO, "mtllib a.mtl b.mtl # both\n" + TWO, "mtllib .\\a.mtl ./b.mtl\n" + TWO,
    "mtllib A.MTL B.mtl\n" + TWO, "mtllib /nowhere/a.mtl C:\\b.mtl\n" + TWO, "mtllib ../scene/a.mtl b.mtl\n" + TWO])
def test_where_materials_come_from(load, lines):
    mesh = load(lines, a__mtl=RED, b__mtl=BLUE)
    assert [mesh.materials[i].diffuse for i in mesh.material_ids] == [(1, 0, 0), (0, 0, 1)]


def test_an_mtl_name_with_spaces(load):
    (load.folder / "my materials.mtl").write_text(RED + BLUE)
    assert len(load("mtllib my materials.mtl\n" + TWO).materials) == 2
    assert len(load("mtllib my materials.mtl # mine\n" + TWO).materials) == 2


def test_faces_before_any_usemtl_and_of_unknown_names_have_the_default(load):
    with pytest.warns(GlimtWarning, match=r"mesh\.obj:7: there is no material 'green'"):
        mesh = load("mtllib a.mtl\n" + SQUARE + "f 1 2 3\nusemtl green\nf 1 2 4\nusemtl red\nf 1 3 4\n", a__mtl=RED)
    assert [m.name for m in mesh.materials] == ["default", "red"]
    assert mesh.material_ids.tolist() == [0, 0, 1]


def test_only_materials_in_use_are_kept(load):
    mesh = load("mtllib a.mtl\n" + SQUARE + "usemtl blue\nusemtl red\nf 1 2 3\nusemtl blue\n", a__mtl=RED + BLUE)
    assert [m.name for m in mesh.materials] == ["red"]


def test_of_two_materials_of_one_name_the_last_counts(load):
    with pytest.warns(GlimtWarning, match=r"b\.mtl: a material of an earlier MTL file is defined again"):
        mesh = load("mtllib a.mtl b.mtl\n" + SQUARE + "usemtl red\nf 1 2 3\n", a__mtl=RED,
                    b__mtl="newmtl red\nKd 0 1 0")
    assert mesh.materials[0].diffuse == (0, 1, 0)


def test_a_missing_mtl_file_is_a_warning_with_its_line(load):
    with pytest.warns(GlimtWarning) as caught:
        load("\nmtllib nowhere.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert [str(w.message).split("scene/")[1] for w in caught] == [
        "mesh.obj:2: there is no MTL file 'nowhere.mtl'; its materials are left out"]


def test_references_do_not_leave_the_folder_above(tmp_path, load):
    outside = tmp_path.parent / f"{tmp_path.name}-outside.mtl"
    outside.write_text(RED)
    with pytest.warns(GlimtWarning, match="there is no MTL file"):
        load(f"mtllib ../../{outside.name}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.warns(GlimtWarning, match="there is no MTL file"):
        load(f"mtllib {outside}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (tmp_path / "shared.mtl").write_text(RED)
    load("mtllib ../shared.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")


def test_textures_are_shared(load):
    Image.new("RGB", (3, 2), (1, 2, 3)).save(load.folder / "T.png")
    mtl = "newmtl red\nmap_Kd t.png\nnewmtl blue\nmap_Kd -s 2 2 .\\T.PNG\n"
    a, b = load("mtllib a.mtl\n" + TWO, a__mtl=mtl).materials
    assert a.diffuse_texture.pixels is b.diffuse_texture.pixels
    assert b.diffuse_texture.scale == (2, 2)


# Geometry that is dropped

def test_triangles_without_area_are_dropped_and_counted(load):
    faces = "f 1 2 2\nf 1 2 5\nf 1 2 3\nf 1 1 1 1\nf 6 7 8\n"
    with pytest.warns(GlimtWarning, match=r"mesh\.obj:9: a triangle without area is dropped \(5 times"):
        mesh = load(SQUARE + "v 4 0 0\nv 7 7 7\nv 7 7 7\nv 7 8 9\n" + faces)
    assert corner_positions(mesh).tolist() == [[[0, 0, 0], [2, 0, 0], [2, 2, 0]]]


@pytest.mark.parametrize("scale", [1e-20, 1e-3, 1, 1e5, 1e14])
def test_a_sliver_is_kept_at_any_scale(load, scale):
    assert len(load(f"v 0 0 0\nv {scale} 0 0\nv 0 {scale * 1e-6} 0\nf 1 2 3\n").triangles) == 1


def test_faces_of_fewer_than_three_corners_are_left_out(load):
    with pytest.warns(GlimtWarning, match=r"mesh\.obj:5: a face with fewer than three corners is left out \(3 times"):
        mesh = load(SQUARE + "f\nf 1\nf 1 2\nf 1 2 3\n")
    assert len(mesh.triangles) == 1


def test_corners_of_faces_that_are_left_out_are_forgotten():
    data = np.frombuffer((SQUARE + "f 1 2\nf 1 2 3\nf 4\n").encode(), np.uint8).copy()
    text = parse_text(data, Path("mesh.obj"), WarningCounter())
    assert len(text.corners) == text.starts[-1] == 3


def test_statements_that_are_not_drawn(load):
    text = SQUARE + "o name\ng a b\ng\nf 1 2 3\nl 1 2\np 1\np 2\nvp 1\ncstype bezier\ncurv 0 1\nlod 1\nhello there\n"
    with pytest.warns(GlimtWarning) as caught:
        load(text)
    assert [str(w.message).split("mesh.obj:")[1] for w in caught] == [
        "9: lines are not drawn", "10: points are not drawn (2 times, the first one here)",
        "12: curves and surfaces are not drawn; export them as faces (3 times, the first one here)",
        "16: statement 'hello' is not part of OBJ; it is ignored"]


def test_many_kinds_of_nonsense_make_few_warnings(load):
    with pytest.warns(GlimtWarning) as caught:
        load(SQUARE + "f 1 2 3\n" + "".join(f"nonsense{i}\nx{i}\n" for i in range(1000)))
    assert len(caught) == 16
    assert sum(w.message.count for w in caught) == 2000


# Normals

def test_given_normals_are_kept_even_against_the_winding(load):
    mesh = load("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 -2\nf 1//1 2//1 3//1\n")
    assert mesh.normals.tolist() == [[0, 0, -2]] * 3


@pytest.mark.parametrize("normal", ["nan nan nan", "0 0 0", "-nan 0 1", "inf 0 0", "1e300 0 0", "0 0 1e20"])
def test_an_unusable_normal_is_computed(load, normal):
    mesh = load(f"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn {normal}\nvn 0 1 0\nf 1//1 2//2 3//1\n")
    assert mesh.normals.tolist() == [[0, 0, 1], [0, 1, 0], [0, 0, 1]]


def test_corners_without_normal_in_a_file_with_some(load):
    mesh = load("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 1 0 0\nf 1//1 2 3\n")
    assert mesh.normals.tolist() == [[1, 0, 0], [0, 0, 1], [0, 0, 1]]


def test_a_normal_past_the_end_is_computed_and_counted(load):
    with pytest.warns(GlimtWarning, match=r"mesh\.obj:4: a face refers to a normal .* \(3 times"):
        mesh = load("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1//1 2//2 3//3\n")
    assert mesh.normals.tolist() == [[0, 0, 1]] * 3


ROOF = "v 0 0 0\nv 1 0 0\nv 1 1 {h}\nv 0 1 {h}\nv 1 2 0\nv 0 2 0\n"
FACES = "f 1 2 3 4\n{s}f 4 3 5 6\n"


def normals_at_ridge(mesh):
    return mesh.normals[np.isclose(mesh.positions[:, 1], 1)]


@pytest.mark.parametrize(("smoothing", "height", "smooth"), [
    ("", 0.5, True), ("", 0.9, False),  # the faces meet at 53 and 84 degrees
    ("s 1\n", 0.9, True), ("s on\n", 0.9, True), ("s 0\n", 0.1, False), ("s off\n", 0.1, False)])
def test_smoothing(load, smoothing, height, smooth):
    mesh = load(smoothing + ROOF.format(h=height) + FACES.format(s=""))
    ridge = normals_at_ridge(mesh)
    assert len(ridge) == (2 if smooth else 4)
    assert len(mesh.positions) == (6 if smooth else 8)
    if smooth:
        np.testing.assert_allclose(ridge, [[0, 0, 1]] * 2, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1, rtol=1e-6)


def test_smoothing_groups_are_apart(load):
    assert len(normals_at_ridge(load("s 1\n" + ROOF.format(h=0.1) + FACES.format(s="s 2\n")))) == 4


def test_a_smoothing_group_that_is_none(load):
    with pytest.warns(GlimtWarning, match=r"mesh\.obj:1: a smoothing group that is no number"):
        load("s banana\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")


# The call

def test_warnings_go_to_the_counter_that_is_given(tmp_path):
    path = tmp_path / "mesh.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2\n")
    counter = WarningCounter()
    read_obj(str(path), warnings=counter)
    with pytest.warns(GlimtWarning, match="lines are not drawn"):
        counter.issue()
