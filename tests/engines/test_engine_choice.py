"""Which engine a name stands for, and why."""

import subprocess
import sys

import pytest

from glimt.engines import choice, get_engine
from glimt.engines.cpu.engine import CpuEngine
from glimt.engines.gpu.adapters import AdapterInfo
from glimt.errors import GlimtError

REAL = AdapterInfo("GeForce (DiscreteGPU) via Vulkan", "discrete", "Vulkan")
SOFTWARE = AdapterInfo("llvmpipe (CPU) via Vulkan", "software", "Vulkan")


@pytest.fixture
def machine(monkeypatch):
    """Return a function that makes choices see certain adapters."""
    def be(*adapters, installed=True, wanted=""):
        monkeypatch.setattr(choice, "is_installed", lambda: installed)
        monkeypatch.setattr(choice, "list_adapters", lambda: list(adapters))
        monkeypatch.setenv("GLIMT_GPU", wanted)
    return be


def test_auto_takes_a_real_gpu(machine):
    machine(REAL, SOFTWARE)
    assert choice.choose_engine() == ("gpu", REAL.summary)
    assert choice.choose_engine("cpu").engine == "cpu"


@pytest.mark.parametrize(("adapters", "options", "reason"), [
    ([], {}, "no GPU was found"),
    ([SOFTWARE], {}, "no GPU was found"),
    ([REAL], {"installed": False}, "glimt[gpu]"),
    ([REAL, SOFTWARE], {"wanted": "software"}, "llvmpipe (CPU) via Vulkan would use the CPU"),
    ([REAL, SOFTWARE], {"wanted": "llvm"}, "llvmpipe (CPU) via Vulkan would use the CPU"),
    ([REAL], {"wanted": "Radeon"}, "GLIMT_GPU is 'Radeon'"),
])
def test_auto_is_else_the_cpu_and_says_why(machine, adapters, options, reason):
    machine(*adapters, **options)
    chosen = choice.choose_engine("auto")
    assert chosen.engine == "cpu"
    assert reason in chosen.reason


def test_gpu_is_what_is_asked_for_or_an_error(machine):
    machine(REAL, SOFTWARE, wanted="software")
    assert choice.choose_engine("gpu") == ("gpu", SOFTWARE.summary)
    machine(SOFTWARE)
    with pytest.raises(GlimtError, match="no GPU was found"):
        choice.choose_engine("gpu")


def test_an_engine_that_is_none():
    with pytest.raises(GlimtError, match="no engine 'tpu'; expected 'auto', 'cpu' or 'gpu'"):
        get_engine("tpu")
    assert isinstance(get_engine("cpu", 1), CpuEngine)


def test_the_cpu_engine_does_not_import_wgpu():
    code = ("import sys\nfrom glimt import Renderer, Scene\nfrom glimt.engines import begin_preparing\n"
            "begin_preparing('cpu')\nRenderer(Scene(), engine='cpu')\nassert 'wgpu' not in sys.modules")
    subprocess.run([sys.executable, "-W", "ignore", "-c", code], timeout=120, check=True)
