"""Broken files end in a `GlimtError` that names the place, or in a warning; never in anything else."""

import os

import pytest

from glimt.errors import GlimtError, WarningCounter
from glimt.io import obj_text
from glimt.io.image import read_texture
from glimt.io.mtl import read_mtl
from glimt.io.obj import read_obj

THREE = b"v 0 0 0\nv 1 0 0\nv 0 1 0\n"


@pytest.mark.parametrize(("content", "message"), [
    (b"", "mesh.obj: has no faces, and nothing else is drawn; export the mesh with its faces"),
    (b"\n\n# nothing\n", "mesh.obj: has no faces"),
    (THREE, "mesh.obj: has no faces"),
    (THREE + b"l 1 2\n", "mesh.obj: has no faces"),
    (b"\x00\x01\x02\xff" * 100, "mesh.obj: has no faces"),
    (bytes(range(256)) * 8, "mesh.obj: has no faces"),
    ("v 0 0 0\n".encode("utf-16"), "mesh.obj:1: is UTF-16 text; save it as UTF-8"),
    (b"v nan 0 0\nf 1 1 1\n", "mesh.obj:1: 'nan' is not finite or beyond 1e+15; scale the mesh down"),
    (b"v 0 0 0\nv 0 -inf 0\n", "mesh.obj:2: '-inf' is not finite"),
    (b"v 0 0 1e300\n", "mesh.obj:1: '1e300' is not finite or beyond"),
    (b"v 0 0 1e999999999999999999999\n", "mesh.obj:1: '1e999999999999999999999' is not finite"),
    (b"v 0 0 " + b"9" * 400, "mesh.obj:1: '" + "9" * 40 + "' is not finite"),
    (b"v 1,5 0 0\n", "mesh.obj:1: '1,5' is not a number; numbers look like 1.5 or -2e-3"),
    (b"v 1e 0 0\n", "mesh.obj:1: '1e' is not a number"),
    (b"v 1e+ 0 0\n", "mesh.obj:1: '1e+' is not a number"),
    (b"v . 0 0\n", "mesh.obj:1: '.' is not a number"),
    (b"v - 0 0\n", "mesh.obj:1: '-' is not a number"),
    (b"v 1.2.3 0 0\n", "mesh.obj:1: '1.2.3' is not a number"),
    (b"v 0x10 0 0\n", "mesh.obj:1: '0x10' is not a number"),
    (b"\n\nv one 0 0\n", "mesh.obj:3: 'one' is not a number"),
    (b"v \xff\xfe 0 0\n", "mesh.obj:1: 'ÿþ' is not a number"),
    (b"v 1 2\n", "mesh.obj:1: 'v' has too few numbers; it takes 3"),
    (b"v\n", "mesh.obj:1: 'v' has too few numbers"),
    (b"v 1 2 # 3\n", "mesh.obj:1: 'v' has too few numbers"),
    (b"vn 1\n", "mesh.obj:1: 'vn' has too few numbers; it takes 3"),
    (b"vn one two three\n", "mesh.obj:1: 'one' is not a number"),
    (b"vt\n", "mesh.obj:1: 'vt' has too few numbers; it takes 1"),
    (b"vt nan 0\n", "mesh.obj:1: 'nan' is not finite"),
    (THREE + b"f 0 1 2\n", "mesh.obj:4: face refers to item 0; OBJ counts from 1, or back from -1"),
    (THREE + b"f 1/0 2 3\n", "mesh.obj:4: face refers to item 0"),
    (THREE + b"f 1 2 4\n", "mesh.obj:4: face refers to vertex 4 of 3"),
    (THREE + b"f 1 2 99999999999999999999999999\n", "mesh.obj:4: face refers to vertex 999999999"),
    (THREE + b"f 1 2 -4\n", "mesh.obj:4: face refers to vertex -4, which is before the first one"),
    (b"v 0 0 0\nf -1 -2 -3\nv 0 0 0\nv 1 1 0\n", "mesh.obj:2: face refers to vertex -2, which is before the first"),
    (THREE + b"f 1/1 2/2 3/3\n", "mesh.obj:4: face refers to texture coordinate 1 of 0"),
    (THREE + b"vt 0 0\nf 1/1 2/2 3/1\n", "mesh.obj:5: face refers to texture coordinate 2 of 1"),
    (THREE + b"f 1//-1 2 3\n", "mesh.obj:4: face refers to normal -1, which is before the first one"),
    (THREE + b"f 1 2 three\n", "mesh.obj:4: 'three' is no corner of a face; they look like 1, 1/2, 1//3 or 1/2/3"),
    (THREE + b"f 1 2 3.0\n", "mesh.obj:4: '.0' is no corner of a face"),
    (THREE + b"f 1 2 3/1/1/1\n", "mesh.obj:4: face refers to texture coordinate 1 of 0"),
    (THREE + b"f 1 2 3///\n", "mesh.obj:4: '/' is no corner of a face"),
    (THREE + b"f 1 2 /3\n", "mesh.obj:4: '/3' is no corner of a face"),
    (THREE + b"f 1 2 -\n", "mesh.obj:4: '-' is no corner"),
    (THREE + b"f " + b"1 2 3 " * 30000, "mesh.obj:4: face has more than 65536 corners; split it"),
    (b"\nmtllib a b c\n" * 400 + THREE + b"f 1 2 3\n", "mesh.obj:2: names more than 1000 MTL files; join them"),
    (b"v 0 0 0\nf 1 1 1\n", "mesh.obj:2: none of the 1 triangles has an area"),
    (b"v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\nf 3 2 1\n", "mesh.obj:4: none of the 2 triangles has an area"),
])
def test_bad_obj(tmp_path, content, message):
    path = tmp_path / "mesh.obj"
    path.write_bytes(content)
    with pytest.raises(GlimtError) as caught:
        read_obj(path, warnings=WarningCounter())
    assert str(caught.value).startswith(f"{tmp_path}/{message}")


def test_a_folder_instead_of_a_file(tmp_path):
    with pytest.raises(GlimtError, match=r"is a folder; name the \.obj file in it"):
        read_obj(tmp_path)


def test_no_file(tmp_path):
    with pytest.raises(GlimtError, match=r"nothing\.obj: no such file"):
        read_obj(tmp_path / "nothing.obj")


@pytest.mark.parametrize("name", ["a\0b.obj", "x" * 5000 + ".obj"])
def test_impossible_names(name):
    with pytest.raises(GlimtError, match="cannot be read"):
        read_obj(name)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes")
def test_a_pipe_does_not_hang(tmp_path):
    os.mkfifo(tmp_path / "pipe.obj")
    with pytest.raises(GlimtError, match="is not a regular file"):
        read_obj(tmp_path / "pipe.obj")
    with pytest.raises(GlimtError, match="is not a regular file"):
        read_texture(tmp_path / "pipe.obj", encoding="srgb")


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() == 0, reason="this user may read everything")
def test_no_permission(tmp_path):
    path = tmp_path / "mesh.obj"
    path.write_text("f 1 1 1")
    path.chmod(0)
    with pytest.raises(GlimtError, match="Permission denied"):
        read_obj(path)


def test_a_file_beyond_4_gib(tmp_path):
    path = tmp_path / "mesh.obj"
    with open(path, "wb") as file:
        file.truncate(5 * 2**30)  # sparse
    with pytest.raises(GlimtError, match=r"5\.0 GiB is more than the 4 GiB that are read; split it"):
        read_obj(path)


def test_no_memory(tmp_path, monkeypatch):
    path = tmp_path / "mesh.obj"
    path.write_bytes(THREE + b"f 1 2 3\n")

    def count(data, counts):
        raise MemoryError

    monkeypatch.setattr(obj_text.obj_parser, "count", count)
    with pytest.raises(GlimtError, match="too large for this computer's memory"):
        read_obj(path)


@pytest.mark.parametrize("content", [
    b"", b"newmtl", b"newmtl\nnewmtl\nmap_Kd\n", b"\xff\xfe\x00" * 50, bytes(range(256)), b"Kd 1 1 1\n",
    b"newmtl a\nKd\nKd 1 2\nKd red\nKd nan 0 0\nKd -1 0 0\nKd 1e300 0 0\nKd xyz 1 1 1\nKd spectral a.rfl 1\n",
    b"newmtl a\nNs\nNs x\nNs inf\nNs -5\nd\nd -halo\nTr x\nillum 2.5\nillum many\n",
    b"newmtl a\nmap_Kd -s\nmap_Kd -s 1\nmap_Kd -s 1 2 3 4\nmap_Kd -s 1e99 1 a.png\nmap_Kd -clamp\nmap_Bump -bm x\n",
    b"newmtl a\nmap_Kd \0\nmap_Bump /dev/zero\nnorm ..\nmap_Kd " + b"x" * 10000,
])
def test_bad_mtl_never_raises(tmp_path, content):
    path = tmp_path / "bad.mtl"
    path.write_bytes(content)
    materials = read_mtl(path, WarningCounter())
    assert set(materials) <= {"a", ""}


@pytest.mark.parametrize("content", [
    b"", b"x", b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff\xe0" + b"\0" * 100, b"GIF89a" + b"\0" * 10, b"BM" + b"\xff" * 60,
    b"\0\0\2" + b"\0" * 9 + b"\xff\xff\xff\xff\x18\0", b"%PDF-1.4", b"RIFF\0\0\0\0WEBPVP8 ", b"\0" * 1000,
    b"II*\0\x08\0\0\0", b"P6 1 1 255 abc"])
def test_bad_images(tmp_path, content):
    path = tmp_path / "bad.png"
    path.write_bytes(content)
    with pytest.raises(GlimtError, match=r"^room\.mtl:7: .*bad\.png: "):
        read_texture(path, encoding="srgb", where="room.mtl:7")
