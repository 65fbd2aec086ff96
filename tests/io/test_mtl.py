"""MTL files and their maps."""

import warnings

import numpy as np
import pytest
from PIL import Image

from glimt.errors import GlimtWarning, WarningCounter
from glimt.io.mtl import read_mtl
from glimt.io.mtl_maps import HEIGHT_SHARE, is_normal_map, normals_from_heights, parse_map


@pytest.fixture
def read(tmp_path):
    """Return a function that writes `text` to scene/room.mtl and returns (its one material, texts of the warnings)."""
    folder = tmp_path / "scene"
    folder.mkdir()

    def read(text):
        path = folder / "room.mtl"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        counter = WarningCounter()
        materials = read_mtl(path, counter)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            counter.issue()
        assert len(materials) == 1
        return next(iter(materials.values())), [str(w.message).split("scene/")[-1] for w in caught]

    read.folder = folder
    return read


def save(folder, name, color=(100, 150, 200), size=(4, 4)):
    Image.new("RGB", size, color).save(folder / name, "PNG")


BLUISH = (128, 128, 255)


def test_all_values(read):
    text = "newmtl wall\nKa 0.1 0.2 0.3\nKd 0.4 0.5 0.6\nKs 0.7 0.8 0.9\nNs 50\nillum 2\nd 1\nNi 1.5"
    material, found = read(text)
    assert found == []
    assert material.name == "wall"
    assert material.ambient == (0.1, 0.2, 0.3)
    assert material.diffuse == (0.4, 0.5, 0.6)
    assert material.specular == (0.7, 0.8, 0.9)
    assert (material.exponent, material.reflectivity) == (50, 0)


def test_defaults(read):
    material, found = read("newmtl wall")
    assert found == []
    assert material.diffuse == material.ambient == (0.8, 0.8, 0.8)
    assert (material.specular, material.exponent, material.reflectivity) == ((0, 0, 0), 32, 0)


def test_ambient_is_diffuse_where_it_is_not_given(read):
    assert read("newmtl a\nKd 0.1 0.2 0.3")[0].ambient == (0.1, 0.2, 0.3)


@pytest.mark.parametrize("text", [
    "newmtl a\r\nKd 1 0 0\r\n", "newmtl a\rKd 1 0 0", "\tnewmtl\ta\n  Kd\t1  0 0", "newmtl a\nkd 1 0 0 # red",
    "# x\n\nNEWMTL a\nKD 1. 0 0e5", "\ufeffnewmtl a\nKd 1 0 0", "newmtl a\nKd 0 0 1\nKd 1 0 0"])
def test_spellings(read, text):
    material, found = read(text)
    assert (material.name, material.diffuse, found) == ("a", (1, 0, 0), [])


def test_one_number_is_grey(read):
    assert read("newmtl a\nKd 0.5")[0].diffuse == (0.5, 0.5, 0.5)


@pytest.mark.parametrize(("illumination", "specular", "reflectivity"), [
    (0, 0, 0), (1, 0, 0), (2, 0.5, 0), (3, 0.5, 0.5), (4, 0.5, 0.5), (5, 0.5, 0.5), (8, 0.5, 0), (10, 0.5, 0)])
def test_illumination_models(read, illumination, specular, reflectivity):
    material, _ = read(f"newmtl a\nKs 0.25 0.5 0.75\nillum {illumination}")
    assert sum(material.specular) / 3 == specular
    assert material.reflectivity == reflectivity


def test_a_mirror_reflects_no_more_than_everything(read):
    assert read("newmtl a\nKs 2 2 2\nillum 3")[0].reflectivity == 1


@pytest.mark.parametrize(("line", "warning"), [
    ("Kd", "room.mtl:2: Kd is not one or three numbers from 0 on; it is ignored"),
    ("Kd 1 2", "room.mtl:2: Kd is not"), ("Ks red", "room.mtl:2: Ks is not"), ("Ka nan 0 0", "room.mtl:2: Ka is not"),
    ("Ka -1 0 0", "room.mtl:2: Ka is not"), ("Kd spectral x.rfl", "room.mtl:2: Kd is not"),
    ("Ka xyz 1 1 1", "room.mtl:2: Ka is not"), ("Ks 1e300 1 1", "room.mtl:2: Ks is not"),
    ("Ns", "room.mtl:2: Ns is not a number; it is ignored"), ("Ns inf", "room.mtl:2: Ns is not"),
    ("illum two", "room.mtl:2: Illum is not"), ("d 0.5", "room.mtl:1: room.mtl has transparent materials"),
    ("Tr 0.5", "room.mtl:1: room.mtl has transparent materials"), ("d -halo 0.5", "room.mtl:1: room.mtl has transp"),
    ("Ke 1 1 1", "room.mtl:1: Ke is not drawn"), ("map_Ks a.png", "room.mtl:2: map_ks is not drawn"),
    ("map_d a.png", "room.mtl:2: map_d is not drawn"), ("map_Ka a.png", "room.mtl:2: map_ka is not drawn"),
    ("hello world", "room.mtl:2: statement 'hello' is not part of MTL; it is ignored"),
    ("d 0", "room.mtl:1: every material is invisible (d 0 or Tr 1), most likely written the wrong way round"),
    ("Tr 1.0", "room.mtl:1: every material is invisible"),
    ("map_Kd a.png", "room.mtl:2: there is no file 'a.png'; a checker is drawn instead"),
    ("norm a.png", "room.mtl:2: there is no file 'a.png'; no normal map is used"),
    ("map_Bump a.png", "room.mtl:2: there is no file 'a.png'; no bump map is used")])
def test_what_is_a_warning(read, line, warning):
    material, [found] = read(f"newmtl a\n{line}\n")
    assert found.startswith(warning)
    assert material.diffuse in ((0.8, 0.8, 0.8), (1, 1, 1))


@pytest.mark.parametrize("line", ["d 1", "Tr 0", "d 1\nTr 1", "Ke 0 0 0", "Ni 1", "Pr 0.5", "Tf 1 1 1",
                                  "map_Kd", "# x"])
def test_what_is_none(read, line):
    assert read(f"newmtl a\n{line}\n")[1] == []


def test_transparency_is_counted_once_a_file(tmp_path):
    path = tmp_path / "room.mtl"
    path.write_text("newmtl a\nd 0.5\nnewmtl b\nd 0\nnewmtl c\nTr 0.1\nnewmtl d\n")
    counter = WarningCounter()
    read_mtl(path, counter)
    with pytest.warns(GlimtWarning, match="has transparent materials") as caught:
        counter.issue()
    assert len(caught) == 1


def test_a_material_that_is_defined_twice(tmp_path):
    path = tmp_path / "room.mtl"
    path.write_text("newmtl a\nKd 1 0 0\nNs 5\nnewmtl b\nnewmtl a\nKd 0 1 0\n")
    counter = WarningCounter()
    materials = read_mtl(path, counter)
    with pytest.warns(GlimtWarning, match=r"room\.mtl:5: a material is defined again; the last one is used"):
        counter.issue()
    assert list(materials) == ["a", "b"]
    assert (materials["a"].diffuse, materials["a"].exponent) == ((0, 1, 0), 32)


def test_statements_before_the_first_newmtl(read):
    assert read("Kd 1 0 0\nNs 1\nnewmtl a")[1] == [
        "room.mtl:1: a statement before the first newmtl is ignored (2 times, the first one here)"]


@pytest.mark.parametrize("name", ["nothing.mtl", "."])
def test_a_file_that_cannot_be_read(tmp_path, name):
    counter = WarningCounter()
    assert read_mtl(tmp_path / name, counter) == {}
    with pytest.warns(GlimtWarning, match="its materials are left out"):
        counter.issue()


# Maps

@pytest.mark.parametrize("reference", [
    "brick.png", "BRICK.PNG", ".\\brick.png", "./brick.png", "sub\\..\\brick.png", "textures/brick.png",
    "C:\\Users\\me\\brick.png", "/home/me/textures/brick.png", '"brick.png"', "../scene/brick.png",
    "\\\\host\\d\\brick.png", "../../../../brick.png", "brick.png # red"])
def test_where_textures_are_found(read, reference):
    save(read.folder, "brick.png")
    material, found = read(f"newmtl a\nmap_Kd {reference}\n")
    assert found == []
    assert material.diffuse_texture.pixels[0, 0].tolist() == [100, 150, 200]
    assert (material.diffuse_texture.encoding, material.diffuse_texture.wrap) == ("srgb", "repeat")
    assert material.diffuse == (1, 1, 1)


@pytest.mark.parametrize("name", ["red brick.png", "brick -s.png", "wall#1.png", "Ziegel_ä.png", "1.png"])
def test_names_of_textures(read, name):
    save(read.folder, name)
    assert read(f"newmtl a\nmap_Kd -s 2 2 1 {name}  \n")[1] == []


def test_latin_1_names(read):
    save(read.folder, "Ziegel_ä.png")
    assert read("newmtl a\nmap_Kd Ziegel_ä.png".encode("latin-1"))[1] == []


@pytest.mark.parametrize(("text", "name", "scale", "offset"), [
    ("-s 2 3 4 a b.png", "a b.png", (2, 3), (0, 0)), ("-s 2 a.png", "a.png", (2, 1), (0, 0)),
    ("-o 0.1 a.png", "a.png", (1, 1), (0.1, 0)), ("-o .5 -.25 0 -s 2 2 2 a.png", "a.png", (2, 2), (0.5, -0.25)),
    ("-clamp on -blendu off -blendv on -cc on -texres 512 -boost 2 -type sphere a.png", "a.png", (1, 1), (0, 0)),
    ("a b.png -s 2 2 2", "a b.png", (2, 2), (0, 0)), ("-S 2 2 a.png", "a.png", (2, 2), (0, 0)),
    ("-unknown a.png", "-unknown a.png", (1, 1), (0, 0)), ("-s", "-s", (1, 1), (0, 0)), ("", "", (1, 1), (0, 0))])
def test_options(tmp_path, text, name, scale, offset):
    statement = parse_map(text, "here", tmp_path, WarningCounter())
    assert (statement.name, statement.scale, statement.offset) == (name, scale, offset)
    assert statement.wrap == ("clamp" if "-clamp on" in text else "repeat")


@pytest.mark.parametrize(("options", "warning"), [
    ("-t 1 1 1", "option -t is ignored"), ("-mm 0 1", "option -mm is ignored"), ("-s 1e9 1", "option -s is beyond 1e6"),
    ("-o", "option -o has no value"), ("-imfchan r", "option -imfchan is ignored")])
def test_options_that_are_not_drawn(read, options, warning):
    save(read.folder, "a.png")
    _, [found] = read(f"newmtl a\nmap_Kd {options} a.png")
    assert found.startswith(f"room.mtl:2: {warning}")


def test_scale_and_offset_are_turned_over_with_the_texcoords(read):
    """What is looked up at (u, 1 - v) must lie as far down as OBJ's v * s + o lies up."""
    save(read.folder, "a.png")
    texture = read("newmtl a\nmap_Kd -s 2 3 -o 0.1 0.2 a.png")[0].diffuse_texture
    u, v = 0.3, 0.4
    found = np.array([u, 1 - v]) * texture.scale + texture.offset
    np.testing.assert_allclose(found, [u * 2 + 0.1, 1 - (v * 3 + 0.2)])


def test_a_missing_texture_is_a_checker(read):
    material, _ = read("newmtl a\nmap_Kd -s 8 8 nothing.png")
    assert material.diffuse_texture.pixels.tolist() == [[[255, 0, 255], [128] * 3], [[128] * 3, [255, 0, 255]]]
    assert material.diffuse_texture.scale == (8, 8)


def test_a_damaged_texture_is_a_checker(read):
    (read.folder / "a.png").write_bytes(b"\x89PNG\r\n\x1a\nno")
    material, [warning] = read("newmtl a\nmap_Kd a.png\nmap_Bump a.png\n")[0], read("newmtl a\nmap_Kd a.png")[1]
    assert "a.png" in warning
    assert warning.endswith("a checker is drawn instead")
    assert material.diffuse_texture.pixels.shape == (2, 2, 3)
    assert material.normal_texture is None


def test_black_times_a_texture_is_taken_for_white(read):
    save(read.folder, "a.png")
    material, [warning] = read("newmtl a\nKd 0 0 0\nmap_Kd a.png")
    assert warning == "room.mtl:3: Kd 0 0 0 would make map_Kd black; it is taken for 1 1 1"
    assert material.diffuse == (1, 1, 1)
    assert read("newmtl a\nKd 0 0 0")[0].diffuse == (0, 0, 0)
    assert read("newmtl a\nKd 0.5 0.5 0.5\nmap_Kd a.png")[0].diffuse == (0.5, 0.5, 0.5)


def test_map_ka_that_repeats_map_kd_is_no_warning(read):
    save(read.folder, "a.png")
    assert read("newmtl a\nmap_Kd a.png\nmap_Ka a.png")[1] == []


@pytest.mark.parametrize("word", ["norm", "map_Kn", "map_kn", "map_Bump", "map_bump", "bump", "map_Disp", "disp"])
def test_a_normal_map_by_any_name(read, word):
    save(read.folder, "n.png", BLUISH)
    material, found = read(f"newmtl a\n{word} n.png")
    assert found == []
    assert material.normal_texture.encoding == "linear"
    assert material.normal_texture.pixels[0, 0].tolist() == list(BLUISH)
    assert material.normal_scale == 1


def test_norm_is_believed_without_looking(read):
    save(read.folder, "n.png", (250, 10, 10))
    assert read("newmtl a\nnorm n.png")[0].normal_texture.pixels.dtype == np.uint8


def test_which_normal_map_counts(read):
    for name, blue in (("n", 255), ("b", 254), ("d", 253)):
        save(read.folder, f"{name}.png", (128, 128, blue))
    text = "newmtl a\ndisp d.png\nbump b.png\nnorm n.png"
    for count, blue in ((4, 255), (3, 254), (2, 253)):
        material, _ = read("\n".join(text.split("\n")[:count]))
        assert material.normal_texture.pixels[0, 0, 2] == blue


def test_bm_scales_a_normal_map(read):
    save(read.folder, "n.png", BLUISH)
    assert read("newmtl a\nmap_Bump -bm 0.5 n.png")[0].normal_scale == 0.5
    assert read("newmtl a\nmap_Bump n.png -bm 1000")[0].normal_scale == 100


def test_a_displacement_map_is_a_warning(read):
    save(read.folder, "d.png", (90, 90, 90))
    material, found = read("newmtl a\ndisp d.png")
    assert material.normal_texture is None
    assert found == ["room.mtl:2: displacement maps are not drawn"]


def test_grey_bump_maps_become_normal_maps(read):
    save(read.folder, "h.png", (90, 90, 90))
    material, _ = read("newmtl a\nmap_Bump -bm 3 -s 2 2 h.png")
    assert material.normal_texture.pixels.dtype == np.float32
    np.testing.assert_allclose(material.normal_texture.pixels, np.broadcast_to([0.5, 0.5, 1], (4, 4, 3)), atol=1e-6)
    assert (material.normal_scale, material.normal_texture.scale) == (1, (2, 2))


@pytest.mark.parametrize(("axis", "normal_axis", "sign"), [(1, 0, -1), (0, 1, 1)])
@pytest.mark.parametrize("bump", [1.0, 5.0, -2.0])
def test_normals_of_a_ramp(axis, normal_axis, sign, bump):
    """Heights that grow to the right tilt normals to the left; heights that grow down tilt them up."""
    ramp = np.moveaxis(np.broadcast_to(np.arange(100, dtype=np.uint8)[:, None, None], (100, 100, 3)), 0, axis)
    normals = normals_from_heights(ramp, bump, "clamp")[1:-1, 1:-1] * 2 - 1
    slope = bump * HEIGHT_SHARE * 100 / 255
    expected = np.zeros(3)
    expected[normal_axis], expected[2] = sign * slope, 1
    np.testing.assert_allclose(normals, np.broadcast_to(expected / np.hypot(slope, 1), normals.shape), atol=1e-6)


def test_heights_repeat_or_end_at_the_edge():
    heights = np.zeros((4, 8, 3), np.uint8)
    heights[:, 0] = 255
    assert normals_from_heights(heights, 1, "repeat")[0, -1, 0] < 0.5
    assert normals_from_heights(heights, 1, "clamp")[0, -1, 0] == 0.5


@pytest.mark.parametrize(("color", "expected"), [
    (BLUISH, True), ((120, 140, 205), True), ((128, 128, 128), False), ((200, 200, 200), False),
    ((255, 255, 255), False), ((0, 0, 255), False), ((60, 90, 200), False), ((150, 120, 90), False)])
def test_what_looks_like_a_normal_map(color, expected):
    assert is_normal_map(np.broadcast_to(np.array(color, np.uint8), (3, 5, 3))) is expected


def test_the_normal_maps_of_the_real_scenes_look_like_it(real_scenes):
    for name in ("stone_room/brick-n.jpg", "stone_room/fieldstone-n.jpg", "stone_room/layingrock-n.jpg",
                 "brick_suzanne/brickwork_normal-map.png", "windmill/windmill_001_base_NOR.jpg"):
        assert is_normal_map(np.asarray(Image.open(real_scenes / name).convert("RGB"))), name
    for name in ("stone_room/layingrock-h.jpg", "stone_room/brick-c.jpg", "windmill/windmill_001_base_COL.jpg"):
        assert not is_normal_map(np.asarray(Image.open(real_scenes / name).convert("RGB"))), name


def test_only_the_materials_in_use_are_made(tmp_path):
    path = tmp_path / "two.mtl"
    path.write_text("newmtl plain\nKd 1 0 0\nnewmtl broken\nmap_Kd nowhere.png\n")
    counter = WarningCounter()
    assert list(read_mtl(path, counter, used={"plain"})) == ["plain"]
    counter.issue()  # nothing is said of a texture that nothing shows
