"""A software adapter for the tests of the GPU engine; they are skipped where there is none."""

import functools

import pytest

from glimt.engines.gpu.adapters import choose_adapter, is_installed, list_adapters
from glimt.engines.gpu.device import open_device
from glimt.errors import GlimtError


def need_adapter():
    """Skip where wgpu or a driver is missing; any other failure is one."""
    if not is_installed():
        pytest.skip("needs the package wgpu: pip install 'glimt[gpu]'")
    try:
        choose_adapter([info for info in list_adapters() if info.backend == "Vulkan"], "software")
    except GlimtError as error:
        pytest.skip(f"needs a software Vulkan driver: {error}")


@functools.cache
def _opened():
    return open_device(software=True, group=(32, 32))


def software_device():
    """Return a device, the same for all tests, or skip."""
    need_adapter()
    return _opened()
