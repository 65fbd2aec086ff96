"""Each thing that can be wrong with a scene file is named with file, line and key."""

import os
from pathlib import Path

import pytest
from PIL import Image

from glimt.errors import GlimtError
from glimt.io import load
from glimt.io.scene_document import LARGEST_FILE

MESH = '[[mesh]]\nname = "leaf"\npositions = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\ntriangles = [[0, 1, 2]]\n'
MATERIAL = '[[material]]\nname = "stone"\n'
LIGHT = '[[light]]\ntype = "point"\nposition = [0, 1, 0]\n'

# The text of a file; what the message says behind the file's name.
BROKEN = {
    "syntax": ("[camera]\nposition = 1 2\n", ":2: not valid TOML: "),
    "end of document": ("[camera]\nposition = [1,\n", ":3: not valid TOML: "),
    "key twice": ("[camera]\nfov_deg = 1\nfov_deg = 2\n", ":3: not valid TOML: "),
    "deep brackets": ("a = " + "[" * 100_000, ": brackets are nested too deeply"),
    "endless key": ("\n\n" + ".".join("a" * 50_000) + " = 1\n", ":3: a key of 64 parts or more"),
    "endless quoted key": (".".join(['","'] * 50_000) + " = 1\n", ":1: a key of 64 parts or more"),
    "digits": ("a = " + "1" * 5000, ": a number of more than 4300 digits"),
    "unknown table": ("[scene]\n", ":1: scene: unknown key; known: camera, instance, light, m"),
    "unknown key": ("[camera]\n\nfov = 3\n", ":3: camera.fov: unknown key, did you mean 'fov_deg'?"),
    "misspelt key": (MATERIAL + "reflectvity = 1\n", ":3: material[0].reflectvity: unknown key, did you mean 'reflect"),
    "key of another light": (LIGHT + "direction = [0, 1, 0]\n", ":4: light[0].direction: unknown key; known: "),
    "key in an inline table": (LIGHT + "motion = { orbit = { perod = 1 } }\n",
                               ":4: light[0].motion.orbit.perod: unknown key, did you mean 'period'?"),
    "one bracket": ("[light]\n", ":1: light: write [[light]] with two brackets"),
    "two brackets": ("[[camera]]\n", ":1: camera: expected a table, found a list"),
    "value for table": ("camera = 3\n", ":1: camera: expected a table, found 3"),
    "text for number": ("[camera]\nfov_deg = '30'\n", ":2: camera.fov_deg: expected a number, found '30'"),
    "true for number": ("[camera]\nfov_deg = true\n", ":2: camera.fov_deg: expected a number, found true"),
    "nan": ("[camera]\nposition = [0, nan, 0]\n", ":2: camera.position[1]: is not a finite number"),
    "two numbers": ("[camera]\nposition = [0, 1]\n", ":2: camera.position: has 2 entries, expected at least 3"),
    "float for size": ("[render]\nsize = [1.5, 2]\n", ":2: render.size[0]: expected a whole number, found 1.5"),
    "huge size": ("[render]\nsize = [100000, 2]\n", ":2: render.size: width is 100000, expected 1 to 32768"),
    "huge number": ("[render]\nsamples = 1" + "0" * 400, ":2: render.samples: "),
    "hexadecimal": ("[camera]\nfov_deg = 0x" + "f" * 9000, ":2: camera.fov_deg: "),
    "tone curve": ("[render]\ntone_curve = 'aces'\n", ":2: render.tone_curve: is 'aces', expected 'clamp' or 'filmic'"),
    "colour": ("[render]\nambient = '#12345g'\n", ":2: render.ambient: expected a colour: a number, [r, g, b] or"),
    "true for colour": ("[render]\nambient = [true, 1, 1]\n", ":2: render.ambient: expected a colour"),
    "negative colour": ("[render]\nambient = -1\n", ":2: render.ambient: has a negative part"),
    "infinite colour": ("[render]\nambient = inf\n", ":2: render.ambient: has values that are not finite"),
    "fov": ("[camera]\nup = [0, 1, 0]\nfov_deg = 180\n", ":3: camera.fov_deg: is 180, expected 0.001 to 179"),
    "looking along up": ("[camera]\nposition = [0, 5, 0]\n", ":1: camera: up (0.0, 1.0, 0.0) lies along the line of"),
    "nowhere to look": ("[camera]\nposition = [0, 0, 0]\n", ":2: camera.position: position and target are the same p"),
    "no name": ("[[material]]\n", ":1: material[0].name: missing; it has no default"),
    "material twice": (MATERIAL + MATERIAL, ":4: material[1].name: a second material called 'stone', rename one"),
    "mesh twice": (MESH + MESH, ":6: mesh[1].name: a second mesh called 'leaf', rename one"),
    "exponent": (MATERIAL + "exponent = -1\n", ":3: material[0].exponent: is -1, expected 0 to 1e+06"),
    "texture missing": (MATERIAL + "diffuse_texture = 'a.png'\n",
                        ":3: material[0].diffuse_texture: 'a.png' is not there"),
    "texture outside": (MATERIAL + "normal_texture = { file = '/etc/passwd' }\n",
                        ":3: material[0].normal_texture.file: '/etc/passwd' lies outside "),
    "texture far above": (MATERIAL + "diffuse_texture = '../../a.png'\n", "'../../a.png' lies outside "),
    "texture is no image": (MATERIAL + "diffuse_texture = 'room.toml'\n", ":3: material[0].diffuse_texture: "),
    "texture is a folder": (MATERIAL + "diffuse_texture = '.'\n", "'.' is not a regular file"),
    "texture with NUL": (MATERIAL + 'diffuse_texture = "a\\u0000b"\n', ":3: material[0].diffuse_texture: 'a\\x00b' is"),
    "texture path too long": (MATERIAL + f"diffuse_texture = '{'a' * 999}'\n", ":3: material[0].diffuse_texture: 'aa"),
    "texture empty": (MATERIAL + "diffuse_texture = ''\n", "diffuse_texture: has 0 entries, expected at least 1"),
    "normal map of colours": (MATERIAL + "normal_texture = { file = 'a.bmp', encoding = 'srgb' }\n",
                              ":3: material[0].normal_texture: normal_texture must have encoding 'linear'"),
    "empty mesh": ("[[mesh]]\nname = 'leaf'\n", ":1: mesh[0]: expected either file or positions"),
    "file and positions": (MESH + "file = 'a.obj'\n", ":1: mesh[0]: expected either file or positions"),
    "file and normals": ("[[mesh]]\nfile = 'a.obj'\nnormals = [[0, 0, 1]]\n", ":3: mesh[0].normals: not with file"),
    "positions alone": ("[[mesh]]\npositions = [[0, 0, 0]]\n", ":1: mesh[0].triangles: missing"),
    "empty list": ("[[mesh]]\npositions = []\ntriangles = [[0, 0, 0]]\n", ":2: mesh[0].positions: has 0 entries"),
    "bad row": ("[[mesh]]\ntriangles = [[0, 0, 0]]\npositions = [\n [0, 0, 0],\n [1, 'a', 0],\n]\n",
                ":5: mesh[0].positions[1][1]: expected a number, found 'a'"),
    "vertex": ("[[mesh]]\npositions = [[0, 0, 0]]\ntriangles = [[0, 0, 1]]\n", ":1: mesh[0]: triangle 0 refers to"),
    "normals": (MESH + "normals = [[0, 0, 1]]\n", ":5: mesh[0].normals: has shape (1, 3), expected (3, 3)"),
    "mesh format": ("[[mesh]]\nfile = 'a.bmp'\n", ":2: mesh[0].file: 'a.bmp' is not an OBJ file"),
    "mesh missing": ("[[mesh]]\nfile = 'a.obj'\n", ":2: mesh[0].file: 'a.obj' is not there"),
    "broken obj": ("[[mesh]]\nfile = 'broken.obj'\n", ":2: mesh[0].file: "),
    "unknown mesh": (MESH + "[[instance]]\nmesh = 'laef'\n", ":6: instance[0].mesh: no [[mesh]] is called 'laef', did"),
    "no meshes": ("[[instance]]\nmesh = 'a'\n", ":2: instance[0].mesh: no [[mesh]] is called 'a'"),
    "unknown material": ("[[sphere]]\nradius = 1\ncenter = [0, 0, 0]\nmaterial = 'stoon'\n" + MATERIAL,
                         ":4: sphere[0].material: no [[material]] is called 'stoon', did you mean 'stone'?"),
    "matrix and scale": (MESH + "[[instance]]\nmesh = 'leaf'\nmatrix = [1,0,0,0,0,1,0,0,0,0,1,0]\nscale = 2\n",
                         ":7: instance[0].matrix: either matrix or scale, rotate and translate"),
    "11 numbers": (MESH + "[[instance]]\nmesh = 'leaf'\nmatrix = [1,0,0,0,0,1,0,0,0,0,1]\n", ":7: instance[0].matrix"),
    "singular matrix": (MESH + "[[instance]]\nmesh = 'leaf'\nscale = [1, 0, 1]\n",
                        ":5: instance[0]: object_to_world is singular"),
    "last row": (MESH + "[[instance]]\nmesh = 'leaf'\nmatrix = [1,0,0,0,0,1,0,0,0,0,1,0,1,1,1,1]\n",
                 ":5: instance[0]: the last row of object_to_world"),
    "overflow": (MESH + "[[instance]]\nmesh = 'leaf'\nscale = 1e300\nrotate = [{axis=[0,1,1], angle_deg=1}]\n",
                 ":5: instance[0]: object_to_world has "),
    "axis": (MESH + "[[instance]]\nmesh = 'leaf'\nrotate = { axis = [0, 0, 0], angle_deg = 1 }\n",
             ":7: instance[0].rotate: has a zero vector as axis"),
    "rotation": (MESH + "[[instance]]\nmesh = 'leaf'\nrotate = { axis = [0, 1, 0] }\n",
                 ":7: instance[0].rotate.angle_deg: missing"),
    "no rotations": (MESH + "[[instance]]\nmesh = 'leaf'\nrotate = []\n", ":7: instance[0].rotate: has 0 entries"),
    "radius": ("[[sphere]]\ncenter = [0, 0, 0]\nradius = 0\n", ":3: sphere[0].radius: is 0"),
    "light type": ("[[light]]\ntype = 'spott'\n", ":2: light[0].type: is 'spott', did you mean 'spot'?"),
    "no light type": ("[[light]]\n", ":1: light[0].type: missing, expected 'point', 'spot' or 'directional'"),
    "second light": (LIGHT + "\n[[light]]\ntype = 'point'\n\nposition = 3\n", ":8: light[1].position: expected a list"),
    "attenuation": (LIGHT + "attenuation = [0, 0, 0]\n", ":4: light[0].attenuation: is 0 0 0, which divides by zero"),
    "angles": ("[[light]]\ntype = 'spot'\nposition = [0,1,0]\ndirection = [0,1,0]\ninner_angle_deg = 40\n",
               ":5: light[0].inner_angle_deg: is 40, expected 0 to 30"),
    "direction": ("[[light]]\ntype = 'directional'\ndirection = [0, 0, 0]\n", ":3: light[0].direction: is a zero"),
    "period": (LIGHT + "[light.motion.orbit]\nperiod = 0\n", ":5: light[0].motion.orbit.period: is 0 seconds"),
    "no motion": (LIGHT + "motion = {}\n", ":4: light[0].motion: expected orbit or path, one of the two"),
    "times": (LIGHT + "motion = { path = { times = [1, 0], points = [[0, 0, 0], [1, 1, 1]] } }\n",
              ":4: light[0].motion.path.times: times must be two or more"),
    "the first of several": ("[camera]\nposition = 3\nup = 'b'\n", ":2: camera.position: expected a list, found 3"),
}


@pytest.mark.parametrize(("text", "message"), BROKEN.values(), ids=BROKEN)
def test_broken_file(tmp_path: Path, text: str, message: str) -> None:
    folder = tmp_path / "above" / "scenes"
    folder.mkdir(parents=True)
    Image.new("RGB", (2, 2)).save(folder / "a.bmp")
    (folder / "broken.obj").write_text("v 0 0 0\nf 1 2 3\n")
    path = folder / "room.toml"
    path.write_text(text, "utf-8")
    with pytest.raises(GlimtError) as caught:
        load(path)
    assert str(caught.value).startswith(f"{path}:")
    assert message in str(caught.value).removeprefix(str(path))
    assert len(str(caught.value)) < 1500
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("content", "message"), [
    (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", ": not a text file"),
    (b"a = 1\nb = '\xe9'\n", ":2: not UTF-8 text; save the file as UTF-8"),
    (b"#" * (LARGEST_FILE + 1), ": larger than 8 MiB; put meshes into OBJ files"),
])
def test_bytes_that_are_no_scene(tmp_path, content, message):
    path = tmp_path / "room.toml"
    path.write_bytes(content)
    with pytest.raises(GlimtError) as caught:
        load(path)
    assert str(caught.value) == f"{path}{message}"


def test_a_link_out_of_the_folder_is_refused(tmp_path):
    folder = tmp_path / "above" / "scenes"
    folder.mkdir(parents=True)
    (tmp_path / "secret.obj").write_text("v 0 0 0\n")
    os.symlink(tmp_path / "secret.obj", folder / "a.obj")
    (folder / "room.toml").write_text("[[mesh]]\nfile = 'a.obj'\n")
    with pytest.raises(GlimtError, match=r"room\.toml:2: mesh\[0\]\.file: 'a\.obj' lies outside"):
        load(folder / "room.toml")
