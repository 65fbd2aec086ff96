"""WGSL kernels: the structs and constants of `glimt.layout` for them, files put together, errors by file and line.

A kernel reads words: the scene's arrays are ``array<u32>``, and a field is read by its offset,
``bitcast<f32>(materials[i + MATERIAL_exponent])``, or as part of a vector where they are ``array<vec4<u32>>``.
"""

import importlib.resources
import itertools
import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from glimt import layout
from glimt.engines.gpu.adapters import import_wgpu
from glimt.engines.gpu.device import Device
from glimt.errors import GlimtError

_CONSTANTS = "layout.wgsl"


class Part(NamedTuple):
    """A piece of a module: the name of its file, and its text."""

    name: str
    text: str


class _Line(NamedTuple):
    """A line of a module: where it came from."""

    file: str
    number: int
    text: str


def layout_constants() -> Part:
    """Return `glimt.layout` as WGSL.

    Word offsets are named like ``MATERIAL_diffuse``, a struct's size ``MATERIAL_words``. Integers are all u32, those
    below zero as their two's complement: MISS is 0xffffffffu. Floats are the shortest text that gives the same float32.
    """
    lines = []
    for name, value in vars(layout).items():
        if hasattr(value, "words"):
            lines += [f"const {name}_{field}: u32 = {_literal(offset)};"
                      for field, offset in zip(value._fields, value, strict=True)]
        elif name.isupper() and isinstance(value, int | float | np.number):
            lines.append(f"const {name}: {'f32' if isinstance(value, float | np.floating) else 'u32'} = "
                         f"{_literal(value)};")
    return Part(_CONSTANTS, "\n".join(lines) + "\n")


def _literal(value: Any) -> str:
    if isinstance(value, float | np.floating):
        return f"{np.float32(value)!s}f"
    number = int(value)
    if not -(2**31) <= number < 2**32:
        raise GlimtError(f"layout.py: {number} does not fit into 32 bits")
    return f"{number}u" if number >= 0 else f"{number % 2**32:#x}u"


def kernel(stem: str) -> Part:
    """Return a kernel file by its stem: "shade" is kernels/shade.wgsl."""
    file = importlib.resources.files("glimt.engines.gpu") / "kernels" / f"{stem}.wgsl"
    return Part(file.name, file.read_text(encoding="utf-8"))


def build(device: Device, stems: Sequence[str], declarations: str = "") -> Any:
    """Return a module of kernel files in the order given, after the layout's constants; made once for each device.

    `declarations` are WGSL too, for what only the caller knows, such as the size of an array.
    """
    key = ("module", declarations, *stems)
    if key not in device.kept:
        device.kept[key] = compile_parts(
            device, [layout_constants(), Part("declarations", declarations), *map(kernel, stems)])
    return device.kept[key]


def pipeline(device: Device, stems: Sequence[str], entry_point: str, layouts: Sequence[Any],
             constants: Mapping[str, float] | None = None, declarations: str = "") -> Any:
    """Return a compute pipeline; made once for each device.

    Parameters
    ----------
    device : Device
    stems : sequence of str
        Kernel files, in order.
    entry_point : str
    layouts : sequence of wgpu.GPUBindGroupLayout
        Of groups 0, 1, and so on.
    constants : mapping, optional
        Values of the module's ``override`` declarations; a workgroup's size is given as GROUP_WIDTH and GROUP_HEIGHT.
    declarations : str
        See `build`.
    """
    given = dict(constants or {})
    group = given.get("GROUP_WIDTH", 1) * given.get("GROUP_HEIGHT", 1)
    most = device.limits["max-compute-invocations-per-workgroup"]
    if group > most:  # wgpu does not check sizes that are overridden
        raise GlimtError(f"a workgroup of {group:g} invocations is more than the {most} that the GPU was opened for")
    key = ("pipeline", tuple(stems), entry_point, tuple(layouts), tuple(sorted(given.items())), declarations)
    if key not in device.kept:
        module = build(device, stems, declarations)
        with device.doing(f"compiling {entry_point} of {', '.join(stems)}"):
            device.kept[key] = device.gpu.create_compute_pipeline(
                label=entry_point, layout=device.gpu.create_pipeline_layout(bind_group_layouts=list(layouts)),
                compute={"module": module, "entry_point": entry_point, "constants": given})
    return device.kept[key]


def compile_parts(device: Device, parts: Sequence[Part]) -> Any:
    """Return a module of the parts, one after another; a GlimtError names the part and line of a mistake."""
    wgpu = import_wgpu()
    lines = [_Line(part.name, number, text) for part in parts
             for number, text in enumerate([f"// {part.name}", *part.text.rstrip().split("\n")])]
    with device.doing("compiling kernels"):
        try:
            return device.gpu.create_shader_module(label="glimt", code="\n".join(line.text for line in lines))
        except wgpu.GPUValidationError as error:
            raise GlimtError(_located(str(error), lines)) from error


def _located(diagnostic: str, lines: Sequence[_Line]) -> str:
    """Return naga's diagnostic as "file:line: message" and the line itself."""
    heading = re.search(r"^Shader .*?error: (.*)$", diagnostic, re.MULTILINE)
    number, label = _place(diagnostic)
    if not heading or not number:
        return diagnostic
    line = lines[min(number, len(lines)) - 1]  # what is missing at the end is reported behind it
    message = "; ".join([heading[1], *filter(None, [label]), *re.findall(r"^ *= (.*)$", diagnostic, re.MULTILINE)])
    return f"{line.file}:{line.number}: {message}\n    {line.text.strip()}"


def _place(diagnostic: str) -> tuple[int, str]:
    """Return the line that is underlined first, else the one of the heading, and what is said of it."""
    for above, below in itertools.pairwise(diagnostic.splitlines()):
        numbered = re.match(r" *(\d+) │", above)
        marked = re.match(r"[ ·]*│[ │]*\^+ *(.*)$", below)
        if numbered and marked:
            label = marked[1].lstrip("^ ")
            return int(numbered[1]), "" if label.startswith("naga::") else label
    heading = re.search(r"┌─ \S*?:(\d+):\d+", diagnostic)
    return (int(heading[1]) if heading else 0), ""
