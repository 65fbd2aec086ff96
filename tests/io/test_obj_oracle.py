"""The reader against tinyobjloader and trimesh, and against files made of anything."""

import io
import warnings

import numpy as np
import pytest
import tinyobjloader
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from glimt.errors import GlimtError, WarningCounter
from glimt.io.obj import read_obj
from glimt.io.triangulate import has_area

FILE = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)


def read(path, content):
    path.write_bytes(content)
    return read_obj(path, warnings=WarningCounter())


def read_or_explain(path, content):
    """Return (mesh, None) or (None, what is wrong)."""
    try:
        return read(path, content), None
    except GlimtError as error:
        return None, str(error)


def tinyobj_corners(path):
    """Return positions (m, 3, 3), texcoords (m, 3, 2) or None, normals (m, 3, 3) or None."""
    reader = tinyobjloader.ObjReader()
    assert reader.ParseFromFile(str(path), tinyobjloader.ObjReaderConfig()), reader.Error()
    attributes = reader.GetAttrib()
    corners = [index for shape in reader.GetShapes() for index in shape.mesh.indices]
    arrays = []
    for name, width in (("vertex", 3), ("texcoord", 2), ("normal", 3)):
        values = np.array(getattr(attributes, {"vertex": "vertices"}.get(name, f"{name}s"))).reshape(-1, width)
        ids = np.array([getattr(index, f"{name}_index") for index in corners])
        arrays.append(values[ids].reshape(-1, 3, width) if (ids >= 0).all() else None)
    return arrays


coordinate = st.floats(-1e3, 1e3, width=32)
spelling = st.sampled_from(["{:.9g}", "{:.12f}", "{:+.9e}", "{:.8E}"])


@st.composite
def triangle_files(draw, relative=True):
    """Return the text of an OBJ file of triangles: absolute and relative indices, statements in any order."""
    lines = []
    counts = [0, 0, 0]

    def add(word, width, part):
        values = draw(st.lists(coordinate, min_size=width, max_size=width))
        lines.append(" ".join([word, *(draw(spelling).format(value) for value in values)]))
        counts[part] += 1

    for _ in range(3):
        add("v", 3, 0)
    add("vt", 2, 1)
    add("vn", 3, 2)
    form = draw(st.sampled_from(["{0}", "{0}/{1}", "{0}//{2}", "{0}/{1}/{2}"]))
    for _ in range(draw(st.integers(1, 12))):
        for _ in range(draw(st.integers(0, 3))):
            word, width, part = draw(st.sampled_from([("v", 3, 0), ("vt", 2, 1), ("vn", 3, 2)]))
            add(word, width, part)
        if draw(st.booleans()):
            lines.append(draw(st.sampled_from(["", "# f 1 1 1", "o thing", "g a b", "s 1"])))
        corners = draw(st.lists(st.integers(1, counts[0]), min_size=3, max_size=3, unique=True))
        lines.append("f " + " ".join(form.format(
            corner - counts[0] - 1 if relative and draw(st.booleans()) else corner,
            draw(st.integers(1, counts[1])),
            draw(st.integers(-counts[2], -1) if relative else st.integers(1, counts[2]))) for corner in corners))
    return "\n".join(lines) + "\n"


def assert_same_positions(mesh, problem, positions):
    """Return which of the oracle's triangles (m, 3, 3) have an area; the mesh consists of these."""
    kept = has_area(positions.reshape(-1, 3).astype(np.float32), np.arange(3 * len(positions)).reshape(-1, 3))
    if mesh is None:
        assert "has an area" in problem
        assert not kept.any()
    else:
        np.testing.assert_allclose(mesh.positions[mesh.triangles], positions[kept], rtol=1e-6)
    return kept


@FILE
@given(triangle_files())
def test_triangles_agree_with_tinyobjloader(tmp_path, text):
    path = tmp_path / "mesh.obj"
    mesh, problem = read_or_explain(path, text.encode())
    positions, texcoords, normals = tinyobj_corners(path)
    kept = assert_same_positions(mesh, problem, positions)
    if mesh is not None and texcoords is not None:
        found = mesh.texcoords[mesh.triangles] * [1, -1] + [0, 1]
        np.testing.assert_allclose(found, texcoords[kept], rtol=1e-6, atol=1e-6)
    if mesh is not None and normals is not None:
        usable = (normals[kept] != 0).any(-1)
        np.testing.assert_allclose(mesh.normals[mesh.triangles][usable], normals[kept][usable], rtol=1e-6)


@FILE
@given(triangle_files(relative=False))  # trimesh misreads relative indices between vertices
def test_triangles_agree_with_trimesh(tmp_path, text):
    mesh, problem = read_or_explain(tmp_path / "mesh.obj", text.encode())
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        other = trimesh.load(io.StringIO(text), file_type="obj", process=False, force="mesh", maintain_order=True)
    assert_same_positions(mesh, problem, other.vertices[other.faces])


def corner_set(corners):
    """Return the corners (m, 3, k) as a set of rounded rows; shifted, as files write numbers that end in 5."""
    return {tuple(row) for row in (corners.astype(float) + 0.000137).round(3).reshape(-1, corners.shape[-1]).tolist()}


@pytest.mark.parametrize("name", [
    "spot/spot.obj", "windmill/windmill.obj", "kuka_segment/segment.obj", "brick_suzanne/suzanne.obj",
    "obj_features/box-negative-indices.obj", "obj_features/map-bump.obj", "obj_features/box-groups.obj"])
def test_real_files_agree_with_tinyobjloader(real_scenes, name):
    """The same corners with the same attributes; how quads are cut is each reader's own."""
    mesh = read_obj(real_scenes / name, warnings=WarningCounter())
    positions, texcoords, normals = tinyobj_corners(real_scenes / name)
    assert len(mesh.triangles) == len(positions)
    values = [mesh.positions[mesh.triangles]]
    others = [positions]
    if texcoords is not None:
        values.append(mesh.texcoords[mesh.triangles] * [1, -1] + [0, 1])
        others.append(texcoords)
    if normals is not None:
        values.append(mesh.normals[mesh.triangles])
        others.append(normals)
    found, expected = (corner_set(np.concatenate(v, -1)) for v in (values, others))
    assert len(found & expected) > 0.995 * max(len(found), len(expected))  # rounding may part a few


# Anything at all: a Mesh or a GlimtError

token = st.one_of(
    st.sampled_from(["v", "vt", "vn", "f", "s", "o", "g", "usemtl", "mtllib", "l", "p", "#", "\\", "\n", "\r\n", "\r",
                     "\t", "off", "1", "2", "3", "-1", "-2", "0", "1/1", "1//1", "1/1/1", "/", "//", "nan", "inf",
                     "1e9", "1e", ".", "-", "+", "1.5", "..", "m.mtl", "\v", "\0", "99999999999999999999", "é"]),
    st.integers(-5, 5).map(str), st.floats().map(repr), st.text(max_size=5))


def assert_loads_or_explains(tmp_path, content):
    mesh, problem = read_or_explain(tmp_path / "mesh.obj", content)
    if mesh is None:
        assert "mesh.obj" in problem
    else:
        assert len(mesh.triangles) > 0
        assert np.isfinite(mesh.normals).all()


@FILE
@given(st.binary(max_size=300))
def test_any_bytes(tmp_path, content):
    assert_loads_or_explains(tmp_path, content)


@FILE
@given(st.lists(token, max_size=60))
def test_any_tokens(tmp_path, tokens):
    assert_loads_or_explains(tmp_path, " ".join(tokens).encode("utf-8", "surrogatepass"))


VALID = b"""mtllib m.mtl
v 0 0 0
v 1.5 0 -2e-3
v 0 1 0 \\
0.5
v 1 1 1 0.5 0.5 0.5
vt 0 0
vt 1 1 # comment
vn 0 0 1
usemtl a
s 1
f 1/1/1 2/2/1 3/1/1
s off
f 1 2 4 3
f -1//1 -2 -3/1
"""


@FILE
@given(st.lists(st.tuples(st.integers(0, len(VALID) - 1), st.binary(max_size=3)), max_size=8))
def test_mutations_of_a_valid_file(tmp_path, mutations):
    content = bytearray(VALID)
    for place, replacement in mutations:
        content[place:place + 1] = replacement
    assert_loads_or_explains(tmp_path, bytes(content))


def test_every_truncation_of_a_valid_file(tmp_path):
    for length in range(len(VALID)):
        assert_loads_or_explains(tmp_path, VALID[:length])
    assert len(read(tmp_path / "mesh.obj", VALID).triangles) == 4
