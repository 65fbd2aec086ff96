"""WGSL from layout.py reads what NumPy wrote, and mistakes in kernels are found by file and line."""

import numpy as np
import pytest
from gpu_device import software_device

from glimt import layout
from glimt.engines.gpu import shader
from glimt.engines.gpu.buffers import Bindings, Buffer, Download
from glimt.engines.gpu.commands import Commands
from glimt.engines.gpu.shader import Part, compile_parts, layout_constants, pipeline
from glimt.errors import GlimtError

STRUCTS = {name: struct for name, struct in vars(layout).items() if hasattr(struct, "words")}
NUMBERS = {name: value for name, value in vars(layout).items()
           if name.isupper() and isinstance(value, int | float | np.number)}
HEAD = ("@group(0) @binding(0) var<storage, read> source: array<u32>;\n"
        "@group(0) @binding(1) var<storage, read_write> result: array<u32>;\n")


def _run(body, words, count):
    """Return `count` words that a kernel's body writes to `result`, given `words` as `source`."""
    device = software_device()
    text = f"{HEAD}@compute @workgroup_size(1) fn run() {{\n{body}\n}}\n"
    key = ("module", "", text)
    device.kept[key] = compile_parts(device, [layout_constants(), Part("test.wgsl", text)])
    bindings = Bindings(device, [(0, "read"), (1, "write")])
    source, result, download = Buffer(device, "source"), Buffer(device, "result", 4 * count), Download(device)
    source.upload(words)
    commands, answer = Commands(device, download), np.zeros(count, np.uint32)
    commands.dispatch("run", pipeline(device, [text], "run", [bindings.layout]), [bindings.group([source, result])],
                      (1, 1, 1))
    download.want(result, answer)
    commands.submit()
    download.take()
    return answer


def test_every_field_of_every_struct_is_where_numpy_wrote_it():
    """The second record of each, with bits that are distinct, and NaN or denormal as floats; last field first."""
    rng = np.random.default_rng(3)
    given, wanted, lines, first = [], [], [], 0
    for name, struct in STRUCTS.items():
        records = rng.integers(0, 2**32, 2 * struct.words, np.uint32).view(layout.dtype(struct))
        given.append(records)
        for field in reversed(struct._fields[:-1]):
            values = np.ascontiguousarray(records[1][field]).view(np.uint32).reshape(-1)
            lines += [f"result[{len(wanted) + k}u] = source[{first}u + {name}_words + {name}_{field} + {k}u];"
                      for k in range(len(values))]
            wanted += values.tolist()
        first += 2 * struct.words
    words = np.concatenate([records.view(np.uint32) for records in given])
    assert len(wanted) == sum(struct.words for struct in STRUCTS.values()) == len(words) / 2
    assert _run("\n".join(lines), words, len(wanted)).tolist() == wanted


def test_floats_come_through_as_floats():
    record = np.zeros(1, layout.dtype(layout.MATERIAL))
    record["exponent"], record["diffuse"] = 12.5, (0.1, 0.2, 0.3)
    body = ("let light = bitcast<f32>(source[MATERIAL_exponent]) + bitcast<f32>(source[MATERIAL_diffuse + 1u]);\n"
            "result[0] = bitcast<u32>(light);")
    assert _run(body, record, 1).view(np.float32)[0] == np.float32(12.5) + np.float32(0.2)


def test_every_constant_has_its_exact_value():
    lines = [f"result[{k}u] = bitcast<u32>({name});" for k, name in enumerate(NUMBERS)]
    got = _run("\n".join(lines), np.zeros(1, np.uint32), len(lines))
    wanted = [int(np.float32(value).view(np.uint32)) if isinstance(value, float | np.floating) else int(value) % 2**32
              for value in NUMBERS.values()]
    assert dict(zip(NUMBERS, got.tolist(), strict=True)) == dict(zip(NUMBERS, wanted, strict=True))
    assert {"MISS", "MESH_KIND", "LEAF_SIZE", "OFFSET_ERROR", "TEXEL_BITS", "BOX_SLACK", "STACK_SIZE"} <= NUMBERS.keys()


@pytest.mark.parametrize(("text", "line", "message", "source"), [
    ("fn f() -> f32 {\n    let z = 1.0;\n    return nix;\n}", 3, "no definition in scope", "return nix;"),
    ("fn f() {\n    var y = 2u;\n\n    y = 1.0f;\n}", 4, "f32", "y = 1.0f;"),
    ("fn f(x: u32) -> f32 {\n    let a = x;\n    let z = f32(x) * vec3i(1);\n    return z.x;\n}", 3, "Multiply",
     "let z = f32(x) * vec3i(1);"),
    ("fn f() {\n    let a = ", 2, "expected expression", "let a ="),
    ("fn good() {}", 1, "redefinition", "fn good() {}"),
])
def test_a_mistake_is_reported_by_file_and_line(capfd, text, line, message, source):
    parts = [layout_constants(), Part("good.wgsl", "fn good() {}\n"), Part("shade.wgsl", text)]
    with pytest.raises(GlimtError) as error:
        compile_parts(software_device(), parts)
    where, told = str(error.value).split("\n    ")
    assert where.startswith((f"shade.wgsl:{line}: ", "good.wgsl:1: redefinition"))
    assert message in where
    assert told == source
    assert capfd.readouterr() == ("", "")


def test_parts_keep_their_lines_after_one_without_a_last_newline():
    parts = [Part("a.wgsl", "fn a() {}"), Part("b.wgsl", "\n\nfn b() { c(); }\n\n")]
    with pytest.raises(GlimtError, match=r"^b\.wgsl:3: .*`c`"):
        compile_parts(software_device(), parts)


def test_kernel_files_are_read_by_stem_and_built_once(monkeypatch, tmp_path):
    (tmp_path / "kernels").mkdir()
    (tmp_path / "kernels" / "one.wgsl").write_text("fn one() -> u32 { return VIEW_words; }\n")
    (tmp_path / "kernels" / "two.wgsl").write_text(
        HEAD + "override GROUP_WIDTH: u32 = 1u;\n"
        "@compute @workgroup_size(GROUP_WIDTH) fn two() { result[0] = source[0] + one() + GROUP_WIDTH; }\n")
    monkeypatch.setattr(shader.importlib.resources, "files", lambda package: tmp_path)
    device = software_device()
    bindings = Bindings(device, [(0, "read"), (1, "write")])
    assert shader.build(device, ["one", "two"]) is shader.build(device, ["one", "two"])
    made = [pipeline(device, ["one", "two"], "two", [bindings.layout], {"GROUP_WIDTH": width}) for width in (8, 64, 8)]
    assert made[0] is made[2] is not made[1]
    result, source, download = Buffer(device, "result", 4), Buffer(device, "source", 4), Download(device)
    for work, width in ((made[0], 8), (made[1], 64)):
        source.upload(np.array([1000], np.uint32))
        commands = Commands(device, download)
        commands.dispatch("two", work, [bindings.group([source, result])], (1, 1, 1))
        commands.submit()
        assert download.read(result, np.zeros(1, np.uint32))[0] == 1000 + layout.VIEW.words + width
    with pytest.raises(GlimtError, match="workgroup of 2048 invocations is more than the 1024"):
        pipeline(device, ["one", "two"], "two", [bindings.layout], {"GROUP_WIDTH": 2048})
    with pytest.raises(GlimtError, match=r"compiling nix of one, two .*nix"):
        pipeline(device, ["one", "two"], "nix", [bindings.layout])


def test_a_number_that_is_too_large_for_a_word(monkeypatch):
    monkeypatch.setattr(layout, "MISS", 2**32)
    with pytest.raises(GlimtError, match="4294967296 does not fit"):
        layout_constants()
