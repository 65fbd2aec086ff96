"""What both engines do has the same names on both sides: functions, their parameters, fields of structs, constants.

For each WGSL file that has a Python file of the same name: a function stands for the one of that name there (a leading
underscore aside) or is listed here as the GPU's own; parameters that remain are the same in the same order. So whoever
renames, adds or moves anything on one side is told to look at the other.
"""

import ast
import importlib
import re
from pathlib import Path

import numpy as np
import pytest

import glimt.engines
from glimt.layout import FRAME

ENGINES = Path(glimt.engines.__path__[0])
CPU, GPU = ENGINES / "cpu" / "kernels", ENGINES / "gpu" / "kernels"
TWINS = {path.stem: path.stem for path in GPU.glob("*.wgsl") if (CPU / f"{path.stem}.py").exists()}
TWINS["ray"] = "packet"  # an invocation has one ray, where the CPU sets up a packet of them

PARTS = {"traverse": ("node", "traverse")}
"""Python files that stand for one of that name together."""

NEEDED = {
    "camera_ray", "create_rays", "closer", "sphere_hit", "light_sample", "terminator", "shade", "material_at",
    "material_eval", "sample_texture", "surface_at", "above", "mirror_direction", "bounce", "resolve", "intersect",
    "edges", "meeting", "triangle_leaf", "set_up", "walk_mesh", "walk_scene"}
OF_THE_GPU = {
    "create_rays": {"place_in_tile"},
    "triangle": {"least"},
    "traverse": {"bytes_of", "exponent_scale", "ordered", "meet", "greatest", "child", "pop", "is_done", "descend",
                 "placement", "enter_instance", "closest_hit", "occluded"},
    "debug": {"reaching", "numbers_of", "debug"},
}
"""Functions without a twin: pixels in the order of invocations; four triangles at once; compressed nodes; one
instance and one ray at a time; debug views, which have kernels of another make."""

OF_LANES = {"scene", "block", "words", "slot", "lanes", "active", "found", "packets", "bundle", "span", "stack",
            "pending"}
"""Parameters of the CPU's functions that say where a packet's data is and which of its lanes are meant."""
OF_ONE_RAY = {"ray", "hit", "occlusion", "counts"}
"""What the CPU's `bundle` and `stack` hold."""
OWN_PARAMETERS = {
    "mesh_surface": {"prim"},  # a packet is peeled by primitive
    "permute": {"longest_x", "longest_y", "axis"},  # lanes have different ones
    "push_children": {"nodes", "limit", "in_mesh", "t_max", "bottom", *OF_ONE_RAY},
    "walk_mesh": {"bottom", *OF_ONE_RAY},
    "walk_scene": OF_ONE_RAY,
    "in_space_of": OF_ONE_RAY,
    "test_everything": OF_ONE_RAY,
    "triangles_in": {"block"},
    "create_rays": {"x", "y"},  # which block, as dispatches know by themselves
    "intersect": {"from_camera"},
    "resolve": {"film", "totals", "samples", "left", "top"},
}
SAME = {"rays": "ray", "shears": "ray", "texcoord_u": "texcoord"}
DROPPED = {"texcoord_v"}
"""A packet's rays, and two numbers that are one vector of the GPU's."""
OF_THE_CPU = {"clearance", "clear_unit", "begin"}
"""Fields and parameters: rays that leave a mesh begin where they can meet something of it only there."""

OTHER_VALUES = {("ray", "SMALLEST")}  # of directions: inverses that can still be multiplied without infinities


def _parameters(text):
    return [re.sub(r"@builtin\(\w+\)", "@", part).split(":")[0].strip() for part in text.split(",") if part.strip()]


def _wgsl(stem):
    """Return (functions: parameters by name, structs: fields by name, constants: numbers by name) of a WGSL file."""
    text = re.sub(r"//.*|<[^<>;]*(<\w+>)?>", "", (GPU / f"{stem}.wgsl").read_text(encoding="utf-8"))
    functions = {name: _parameters(given)
                 for name, given in re.findall(r"\bfn (\w+)\(((?:[^()]|\([^()]*\))*)\)", text)}
    structs = {name: _parameters(fields) for name, fields in re.findall(r"\bstruct (\w+) \{([^}]*)\}", text)}
    numbers = {name: float(value) for name, value in re.findall(r"\bconst (\w+) = ([-\d.e]+);", text)}
    return functions, structs, numbers


def _python(stem):
    """Return the same of a Python file; constants are those of the imported module."""
    body = [node for part in PARTS.get(stem, (stem,))
            for node in ast.parse((CPU / f"{part}.py").read_text(encoding="utf-8")).body]
    functions = {node.name.lstrip("_"): [one.arg for one in node.args.args]
                 for node in body if isinstance(node, ast.FunctionDef)}
    structs = {node.name: [field.target.id for field in node.body if isinstance(field, ast.AnnAssign)]
               for node in body if isinstance(node, ast.ClassDef)}
    module = importlib.import_module(f"glimt.engines.cpu.kernels.{stem}")
    numbers = {name.lstrip("_"): float(value) for name, value in vars(module).items()
               if name.isupper() and isinstance(value, float | np.floating)}
    return functions, structs, numbers


def _plain(names, own=()):
    """Return names without those of one side only."""
    return [SAME.get(name, name).rstrip("_") for name in names if name not in own and name not in DROPPED]


def test_what_has_to_be_on_both_sides_is():
    found = [{name for stem in stems for name in read(stem)[0]}
             for read, stems in ((_wgsl, TWINS), (_python, TWINS.values()))]
    assert found[0] >= NEEDED
    assert found[1] >= NEEDED


@pytest.mark.parametrize(("stem", "twin"), TWINS.items(), ids=list(TWINS))
def test_functions_and_their_parameters(stem, twin):
    functions, twins = _wgsl(stem)[0], _python(twin)[0]
    assert functions.keys() - twins.keys() == OF_THE_GPU.get(stem, set())
    for name in functions.keys() & twins.keys():
        own = OWN_PARAMETERS.get(name, set())
        if functions[name][:1] == ["@ group"]:  # a stage is told by FRAME what the CPU's is told by parameters
            assert set(twins[name]) - OF_LANES - own <= set(FRAME._fields), name
        else:
            assert _plain(functions[name], own) == _plain(twins[name], OF_LANES | OF_THE_CPU | own), name


@pytest.mark.parametrize(("stem", "twin"), TWINS.items(), ids=list(TWINS))
def test_fields_of_structs(stem, twin):
    structs, twins = _wgsl(stem)[1], _python(twin)[1]
    for name in structs.keys() & twins.keys():
        assert structs[name] == _plain(twins[name], OF_THE_CPU), name
    assert structs.keys() & twins.keys() == {"hit": {"Hit"}, "light": {"LightSample"}, "material": {"Material"},
                                             "surface": {"Surface"}}.get(stem, set())


@pytest.mark.parametrize(("stem", "twin"), TWINS.items(), ids=list(TWINS))
def test_constants(stem, twin):
    numbers, twins = _wgsl(stem)[2], _python(twin)[2]
    for name in numbers.keys() & twins.keys():
        if (stem, name) not in OTHER_VALUES:
            assert np.float32(numbers[name]) == np.float32(twins[name]), name
    expected = {"texture": {"FAR_TEXCOORD"}, "light": {"SHORT_OF_LIGHT"}, "material": {"GRAZING"},
                "bounce": {"LEAST_RISE"}, "resolve": {"LARGEST"}, "ray": {"ROUNDING"}}
    assert numbers.keys() & twins.keys() >= expected.get(stem, set())


def test_exceptions_are_needed():
    """None of the lists outlives what it was made for."""
    functions = {name for stem in TWINS for name in _wgsl(stem)[0]}
    assert OWN_PARAMETERS.keys() <= functions
    assert TWINS.keys() >= OF_THE_GPU.keys()
    used = {name for twin in TWINS.values() for parameters in _python(twin)[0].values() for name in parameters}
    used |= {name for twin in TWINS.values() for fields in _python(twin)[1].values() for name in fields}
    assert used >= OF_LANES | OF_THE_CPU
