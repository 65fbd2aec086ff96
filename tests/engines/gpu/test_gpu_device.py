"""Which adapter is taken, what is said when there is none, and what a device is opened for."""

import logging
import os
import subprocess
import sys

import numpy as np
import pytest
from gpu_device import need_adapter, software_device

from glimt.engines.gpu import adapters, device
from glimt.engines.gpu.adapters import LEAST_LIMITS, AdapterInfo, choose_adapter, list_adapters, shortfall
from glimt.engines.gpu.buffers import Buffer, Download
from glimt.errors import GlimtError

DISCRETE = AdapterInfo("GeForce RTX 4070 (DiscreteGPU) via Vulkan", "discrete", "Vulkan")
INTEGRATED = AdapterInfo("Intel Graphics (IntegratedGPU) via Vulkan", "integrated", "Vulkan")
SOFTWARE = AdapterInfo("llvmpipe (CPU) via Vulkan", "software", "Vulkan")
WEAK = AdapterInfo("Old Card (DiscreteGPU) via OpenGL", "discrete", "OpenGL", "max-a is 1, needed 8")


def test_the_best_gpu_is_taken():
    assert choose_adapter([DISCRETE, INTEGRATED, SOFTWARE]) is DISCRETE
    assert choose_adapter([WEAK, INTEGRATED, SOFTWARE]) is INTEGRATED


def test_one_can_be_named():
    assert choose_adapter([DISCRETE, INTEGRATED, SOFTWARE], "intel") is INTEGRATED
    assert choose_adapter([DISCRETE, INTEGRATED, SOFTWARE], "software") is SOFTWARE
    assert choose_adapter([DISCRETE, INTEGRATED, SOFTWARE], "llvmpipe") is SOFTWARE


@pytest.mark.parametrize(("found", "wanted", "parts"), [
    ([], "", ["no GPU was found"]),
    ([SOFTWARE], "", ["no GPU was found", "GLIMT_GPU=software takes llvmpipe (CPU) via Vulkan"]),
    ([DISCRETE], "software", ["no software adapter was found"]),
    ([DISCRETE, SOFTWARE], "Radeon", ["GLIMT_GPU is 'Radeon'", DISCRETE.summary, SOFTWARE.summary]),
    ([WEAK], "", ["Old Card", "max-a is 1, needed 8", "CPU engine"]),
])
def test_what_is_said_when_there_is_none(found, wanted, parts):
    with pytest.raises(GlimtError) as error:
        choose_adapter(found, wanted)
    assert all(part in str(error.value) for part in parts)


@pytest.mark.parametrize(("system", "remedy"), [("linux", "mesa-vulkan-drivers"), ("win32", "Direct3D 12"),
                                                ("darwin", "Metal")])
def test_the_remedy_is_that_of_the_system(monkeypatch, system, remedy):
    monkeypatch.setattr(sys, "platform", system)
    with pytest.raises(GlimtError, match=remedy):
        choose_adapter([])


def test_limits_that_fall_short_are_named():
    assert shortfall(LEAST_LIMITS, LEAST_LIMITS) == ""
    assert shortfall(LEAST_LIMITS | {"max-storage-buffers-per-shader-stage": 4}, LEAST_LIMITS) == \
        "max-storage-buffers-per-shader-stage is 4, needed 8"
    assert "max-buffer-size is 0" in shortfall({}, LEAST_LIMITS)


def test_adapters_are_listed_best_first():
    need_adapter()
    found = list_adapters()
    assert [info for info in found if info.kind == "software" and info.backend == "Vulkan" and not info.lacks]
    ranks = [(("discrete", "integrated", "unknown", "software").index(info.kind), info.backend == "OpenGL")
             for info in found]
    assert ranks == sorted(ranks)


def test_only_what_is_needed_is_asked_for():
    """A kernel that uses more must not work by chance."""
    need_adapter()
    opened = device.open_device(software=True)
    sizes = {"max-storage-buffer-binding-size", "max-buffer-size"}
    assert all(opened.limits[name] == least for name, least in LEAST_LIMITS.items() if name not in sizes)
    assert all(opened.limits[name] >= LEAST_LIMITS[name] for name in sizes)
    assert software_device().limits["max-compute-invocations-per-workgroup"] == 1024
    assert opened.has_timestamps == ("timestamp-query" in opened.adapter.handle.features)
    assert opened.tick_seconds > 0
    opened.close()


def test_a_group_that_is_too_large():
    need_adapter()
    with pytest.raises(GlimtError, match=r"workgroups of 1000×1000: max-compute-invocations-per-workgroup is [\d,]+, "
                                         "needed 1,000,000"):
        device.open_device(software=True, group=(1000, 1000))


def test_the_environment_names_an_adapter(monkeypatch):
    need_adapter()
    monkeypatch.setenv("GLIMT_GPU", "no such card")
    with pytest.raises(GlimtError, match="GLIMT_GPU is 'no such card'"):
        device.open_device()
    monkeypatch.setenv("GLIMT_GPU", "software")
    opened = device.open_device()
    assert opened.adapter.kind == "software"
    opened.close()


def test_wgpu_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "wgpu", None)
    adapters.import_wgpu.cache_clear()
    try:
        with pytest.raises(GlimtError, match=r"needs the package wgpu: pip install 'glimt\[gpu\]'"):
            adapters.import_wgpu()
    finally:
        adapters.import_wgpu.cache_clear()


def test_a_lost_device_is_our_error(capfd, caplog):
    need_adapter()
    opened = device.open_device(software=True)
    buffer, download = Buffer(opened, "numbers", 16), Download(opened)
    opened.close()
    with pytest.raises(GlimtError, match="the GPU was lost while making room for what comes back"):
        download.read(buffer, np.zeros(4, np.uint32))
    with pytest.raises(GlimtError, match="the GPU was lost while making room for more"):
        Buffer(opened, "more")
    assert capfd.readouterr() == ("", "")
    assert not caplog.records


def test_what_nobody_else_says_is_still_logged():
    record = logging.LogRecord("wgpu", logging.ERROR, "", 0, "something new", (), None)
    assert adapters.wgpu_log.filter(record)
    with adapters.wgpu_log.silent():
        assert not adapters.wgpu_log.filter(record)
    assert adapters.wgpu_log.filter(record)


def test_drivers_are_silent_and_the_environment_is_as_before():
    need_adapter()
    code = ("import os; from glimt.engines.gpu.device import open_device\n"
            "open_device(software=True).close()\nprint(os.environ.get('XDG_RUNTIME_DIR'))")
    environment = {name: value for name, value in os.environ.items() if name != "XDG_RUNTIME_DIR"}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, timeout=60,
                          check=False)
    assert (done.stdout, done.stderr, done.returncode) == ("None\n", "", 0)
