"""Functions of kernels, called on both engines over the same arrays: a plane for each number they take or give."""

import numba
import numpy as np
from both_engines import on_cpu, on_gpu, shared_engine

from glimt.engines.cpu.kernels.arrays import arrays
from glimt.engines.gpu.buffers import Bindings, Buffer, Download
from glimt.engines.gpu.commands import Commands
from glimt.engines.gpu.pace import Area
from glimt.engines.gpu.shader import Part, compile_parts, kernel, layout_constants, pipeline
from glimt.engines.gpu.stages import STEMS
from glimt.lanes import LANES

GROUP = 64
_NAMED = ("frame", "nodes", "blocks", "records", "geometry", "texels")
_ENTRY = """
@group(0) @binding(10) var<storage, read> given: array<u32>;
@group(0) @binding(11) var<storage, read_write> answers: array<u32>;

var<private> at: u32;

fn value(plane: u32) -> f32 { return bitcast<f32>(given[plane * COUNT + at]); }
fn vector(plane: u32) -> vec3<f32> { return vec3(value(plane), value(plane + 1u), value(plane + 2u)); }
fn put(plane: u32, number: f32) { answers[plane * COUNT + at] = bitcast<u32>(number); }
fn put_flag(plane: u32, flag: bool) { put(plane, select(0.0, 1.0, flag)); }
fn put_vector(plane: u32, v: vec3<f32>) {
    put(plane, v.x);
    put(plane + 1u, v.y);
    put(plane + 2u, v.z);
}

@compute @workgroup_size(64)
fn call(@builtin(global_invocation_id) id: vec3<u32>) {
    at = id.x;
    BODY
}
"""


def both_answers(scene, lanes_body, wgsl_body, given, planes, wgsl_functions=""):
    """Return what the two say, (planes, n) float32 each, CPU first; `given` is (k, n), n a multiple of 64."""
    given = np.ascontiguousarray(given, np.float32)
    assert given.shape[1] % GROUP == 0
    return _on_lanes(scene, lanes_body, given, planes), on_invocations(scene, wgsl_body, given, planes, wgsl_functions)


def _on_lanes(scene, body, given, planes):
    """Call ``body(scene, given, answers, n, i)`` for the packet that starts at i of each plane of n numbers."""
    renderer, answers = on_cpu(scene), np.zeros((planes, given.shape[1]), np.float32)
    renderer._upload(0.0)
    packed, light_count = renderer._engine._scene

    def run(packed, light_count, view, counters, recorded, given, answers, n):
        here = arrays(packed, light_count, view, counters, recorded)
        for i in range(0, n, LANES):
            body(here, given, answers, n, i)

    compiled = numba.njit(error_model="numpy", nogil=True)(run)  # like `kernel`, but without a place in the cache
    compiled(packed, light_count, renderer._view(), np.zeros(16, np.int64), np.zeros((3, 7, 0), np.float32),
             given.reshape(-1), answers.reshape(-1), given.shape[1])
    return answers


def on_invocations(scene, body, given, planes, functions=""):
    """Run a WGSL body with `value`, `vector`, `put` and `put_vector` for the planes of one invocation."""
    engine, renderer, count = shared_engine(), on_gpu(scene), given.shape[1]
    renderer._upload(0.0)
    engine._tell(renderer._view(), (1, 1), Area(0, 0, 1, 1), 1, 0)
    device = engine._device
    text = f"const COUNT = {count}u;\n{functions}{_ENTRY.replace('BODY', body)}"
    declarations = engine._stages.declarations
    if ("module", declarations, text) not in device.kept:
        device.kept["module", declarations, text] = compile_parts(
            device, [layout_constants(), Part("declarations", declarations), *map(kernel, STEMS),
                     Part("call.wgsl", text)])
    bindings = Bindings(device, [(0, "frame"), *((k, "read") for k in range(1, len(_NAMED))), (10, "read"),
                                 (11, "write")])
    source, result, download = Buffer(device, "given"), Buffer(device, "answers", 4 * planes * count), Download(device)
    source.upload(given)
    group = bindings.group([*(engine._buffers[name] for name in _NAMED), source, result])
    commands, answers = Commands(device, download), np.empty((planes, count), np.float32)
    called = pipeline(device, [text], "call", [bindings.layout], declarations=declarations)
    commands.dispatch("call", called, [group], (count // GROUP, 1, 1), frame=0)
    download.want(result, answers)
    commands.submit()
    download.take()
    source.destroy()
    result.destroy()
    return answers

