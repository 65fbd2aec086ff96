"""Whatever a scene file holds, reading it ends in a Scene or a GlimtError."""

import json
import tomllib
import warnings
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from glimt.errors import GlimtError, GlimtWarning
from glimt.io import load, scene_schema
from glimt.io.toml_lines import find_line
from glimt.scene.scene import Scene

GOOD = """# a room
[render]
size = [64, 48]
background = "#a0c0e0"
[camera]
position = [3, 2, 5]
target = [0, 0.5, 0]
[[material]]
name = "red"
diffuse = [1.0, 0.2, 0.1]
[[mesh]]
name = "leaf"
positions = [[0, 0, 0], [1, 0, 0],
             [0, 1, 0]]
triangles = [[0, 1, 2]]
[[instance]]
mesh = "leaf"
scale = 2
rotate = [{ axis = [0, 1, 0], angle_deg = 30 }, { axis = [1, 0, 0], angle_deg = 9 }]
[[instance]]
mesh = "leaf"
material = "red"
matrix = [1, 0, 0, 2, 0, 1, 0, 0, 0, 0, 1, -1]
[[sphere]]
center = [0, 0, 0]
radius = 1
[[light]]
type = "point"
position = [1, 2, 3]
motion = { path = { times = [0, 1], points = [[1, 2, 3], [3, 2, 1]] } }
[[light]]
type = "spot"
position = [0, 4, 0]
direction = [0, -1, 0]
[light.motion.orbit]
period = 2
"""

KEYS = sorted({key for table in vars(scene_schema).values() if hasattr(table, "model_fields")
               for key in table.model_fields})

fuzz = settings(deadline=None, max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])


@pytest.fixture
def survives(tmp_path: Path):
    """Read bytes as a scene file and check how that ends."""
    path = tmp_path / "scenes" / "room.toml"
    path.parent.mkdir()

    def read(content: bytes) -> None:
        path.write_bytes(content)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", GlimtWarning)
            try:
                result = load(path)
            except GlimtError as error:
                result = str(error)
        assert isinstance(result, Scene) or result.startswith(f"{path}:")
    return read


def toml(value: object) -> str:
    """Write a value as inline TOML; Python's `inf` and `nan` happen to be TOML's."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {toml(entry)}" for key, entry in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value) if isinstance(value, str | bool) else repr(value)


numbers = st.integers(-3, 3) | st.integers() | st.floats() | st.sampled_from([1e18, 1e300, -1e-300, 2**63, 10**400])
words = st.sampled_from(["point", "spot", "directional", "leaf", "red", "clamp", "filmic", "#ff0000", "", "x",
                         "room.toml", "../x.obj", "/dev/zero", ".", "\0"])
leaves = numbers | words | st.booleans()
vectors = st.lists(numbers, min_size=3, max_size=3)
values = st.recursive(leaves | vectors, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(
    st.sampled_from(KEYS) | st.text("ab\"'é", max_size=3), inner, max_size=4), max_leaves=12)


@fuzz
@given(st.binary(max_size=300))
@example(b"\xff\xfe[\0r\0")
@example(b"a = 1979-05-27 07:32:00\n")
@example(b"\xef\xbb\xbf")
def test_any_bytes(survives, content):
    survives(content)


@fuzz
@given(st.text("[]{}=.,#\"'\\ \n\r\t0123456789abcxe+-_:", max_size=80))
def test_any_punctuation(survives, text):
    survives(text.encode())


@fuzz
@given(st.dictionaries(st.sampled_from(KEYS), values, max_size=5))
@example({"render": {"samples": 10**400}})
@example({"sphere": [{"center": [0, 0, 0], "radius": 10**400}]})
@example({"light": [{"type": "point", "position": [0, 0, 0], "attenuation": [1e300, 1e300, 1e300]}]})
def test_any_structure_of_known_keys(survives, tables):
    survives("".join(f"{key} = {toml(value)}\n" for key, value in tables.items()).encode())


@fuzz
@given(st.data())
def test_a_good_file_with_one_value_replaced(survives, data):
    lines = GOOD.splitlines()
    index = data.draw(st.sampled_from([number for number, line in enumerate(lines) if line.find(" = ") > 0]))
    key = lines[index].split(" = ")[0]
    lines[index] = f"{key} = {toml(data.draw(values))}"
    survives("\n".join(lines).encode())


@fuzz
@given(st.lists(st.tuples(st.integers(0, len(GOOD)), st.integers(0, 20), st.text("[]{}=.,#\"'\n 0-", max_size=4)),
                min_size=1, max_size=3))
def test_a_good_file_with_pieces_cut_out_and_put_in(survives, edits):
    text = GOOD
    for start, length, piece in edits:
        text = text[:start] + piece + text[start + length:]
    survives(text.encode())


def test_the_good_file_is_good(tmp_path):
    (tmp_path / "room.toml").write_text(GOOD)
    scene = load(tmp_path / "room.toml")
    assert (len(scene.instances()), len(scene.spheres()), len(scene.lights)) == (2, 1, 2)


@pytest.mark.parametrize(("place", "line"), [
    (("render",), 2), (("render", "size"), 3), (("render", "size", 1), 3), (("camera", "fov_deg"), 5),
    (("mesh", 0, "positions", 2, 0), 14), (("mesh", 0, "triangles"), 15), (("instance", 0), 16),
    (("instance", 1, "matrix", 3), 23), (("instance", 0, "rotate", 1, "axis"), 19),
    (("light", 0, "motion", "path"), 30), (("light", 1), 31), (("light", 1, "motion"), 35),
    (("light", 1, "motion", "orbit", "period"), 36), ((), 1),
])
def test_lines_of_places(place, line):
    assert find_line(GOOD, place) == line


def test_lines_among_strings_comments_and_quoted_keys():
    text = ('# [a]\na = """\n[b]\n\\"""b = 1\n"""\nc = \'\'\'\nd = 2\'\'\'\n"d.e".f = "#"  # g\n[[x]]\n[[x.y]]\n'
            "[[x.y]]\nh.i = 1979-05-27 07:32:00\nz = [ # ]\n  { k = 1 },\n\n  { k = ']', l = 2 } ]\n"
            "[[x]]\n[[x.y]]\nh = 1\n")
    assert tomllib.loads(text)["x"][1]["y"][0]["h"] == 1  # it is TOML
    for place, line in {("a",): 2, ("b",): 1, ("c",): 6, ("d",): 1, ("d.e", "f"): 8, ("x", 0, "y", 1): 11,
                        ("x", 0, "y", 1, "h", "i"): 12, ("x", 0, "y", 1, "z", 0, "k"): 14,
                        ("x", 0, "y", 1, "z", 1, "l"): 16, ("x", 1): 17, ("x", 1, "y", 0, "h"): 19}.items():
        assert find_line(text, place) == line, place


@given(st.data())
def test_the_line_of_each_top_level_key(data):
    entries = data.draw(st.dictionaries(st.text("ab.\"' é#[]", max_size=4), values, max_size=6))
    text = "".join(f"{json.dumps(key)} = {toml(value)}\n" for key, value in entries.items())
    for number, key in enumerate(entries):
        assert find_line(text, (key, "x")) == number + 1
