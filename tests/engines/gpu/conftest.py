"""What the tests of the GPU engine share."""

import pytest
from gpu_device import need_adapter


@pytest.fixture
def software_gpu(monkeypatch):
    """Have the engine "gpu" be a driver that computes on the CPU, or skip."""
    need_adapter()
    monkeypatch.setenv("GLIMT_GPU", "software")
