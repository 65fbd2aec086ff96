"""A software adapter for the tests of the GPU engine; they are skipped where there is none."""

import functools

import pytest

from glimt.errors import GlimtError


@functools.cache
def _opened():
    from glimt.engines.gpu.device import open_device
    return open_device(software=True, group=(32, 32))


def software_device():
    """Return a device, the same for all tests, or skip."""
    pytest.importorskip("wgpu", reason="the package wgpu is missing: pip install 'glimt[gpu]'")
    try:
        return _opened()
    except GlimtError as error:
        pytest.skip(str(error))
