"""The kernels become NEON instructions on 64-bit Arm; that they compute the same is for such a machine to tell."""

import os
import re
import subprocess
import sys
from pathlib import Path

import llvmlite.binding as llvm
import numpy as np
import pytest

from glimt import kernel

KERNELS = ["render_tiles", "radiance_of_rays", "trace_rays", "debug_tiles", "count_visits", "prepare_boxes",
           "build_subtrees", "lay_out", "find_clearances"]
SYMBOL = np.dtype([("name", "<u4"), ("info", "u1"), ("other", "u1"), ("section", "<u2"), ("value", "<u8"),
                   ("size", "<u8")])
"""An entry of the symbol table of a 64-bit ELF file."""


@pytest.fixture(scope="module", params=[4, 8])
def folder(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp(f"arm64-{request.param}")
    variables = {"GLIMT_LANES": str(request.param), "GLIMT_CACHE_DIR": str(folder), "NUMBA_CPU_NAME": "generic",
                 "NUMBA_CPU_FEATURES": "+neon"}
    done = subprocess.run([sys.executable, str(Path(__file__).with_name("arm64.py")), str(folder)], timeout=300,
                          env=os.environ | variables, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder


def undefined(code):
    """Return the names that object code expects to find elsewhere."""
    sections = {section.name(): section.data() for section in llvm.ObjectFileRef.from_data(code).sections()}
    names, symbols = sections[b".strtab"], np.frombuffer(sections[b".symtab"], SYMBOL)
    starts = symbols["name"][(symbols["section"] == 0) & (symbols["name"] > 0)]
    return {names[start:names.index(b"\0", start)].decode() for start in starts}


@pytest.mark.parametrize("name", KERNELS)
def test_a_kernel_needs_nothing_but_numba_and_python(folder, name):
    """No function of libm, which would be called once per lane, and none that only another processor has."""
    assert "llvm.x86" not in (folder / f"{name}.ll").read_text()
    needed = {symbol for symbol in undefined((folder / f"{name}.o").read_bytes())
              if not re.match("_?Py|NRT_|numba_", symbol)}
    shared = {"render_tiles": {"glimt_radiance_of_rays_address"}, "radiance_of_rays": {"glimt_trace_rays_address"},
              "debug_tiles": {"glimt_radiance_of_rays_address", "glimt_trace_rays_address"}}
    assert needed - {"memset", "memcpy", "memmove"} == shared.get(name, set())


@pytest.mark.parametrize(("name", "instructions"), [
    ("radiance_of_rays", {"fmla", "fmul", "fadd", "fsqrt", "fdiv", "fcmgt", "fcvtzs", "scvtf"}),
    ("trace_rays", {"fmla", "fmul", "fadd", "fcmgt"}),
    ("build_subtrees", {"fminnm", "fadd", "fmul"}),
])
def test_lanes_are_registers(folder, name, instructions):
    """Four floats each, with multiplications and additions fused."""
    found = re.findall(r"^\t(\w+)\tv\d+\.4s", (folder / f"{name}.s").read_text(), re.MULTILINE)
    assert set(found) >= instructions
    assert len(found) > 200


def test_the_width_on_an_arm_processor(monkeypatch):
    """Two registers a value: the nodes' eight children fill two as well, and there are 32."""
    monkeypatch.delenv("GLIMT_LANES", raising=False)
    monkeypatch.setattr(kernel, "host_features", lambda: frozenset(["neon", "fp-armv8"]))
    assert kernel.host_lanes() == 8
