"""The lane code at widths this processor would not choose."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from glimt.errors import GlimtError
from glimt.kernel import host_lanes
from glimt.lanes import LANES


@pytest.mark.parametrize("width", sorted({4, 8, 16} - {LANES}))
def test_lanes_of_another_width(width):
    environment = {**os.environ, "GLIMT_LANES": str(width)}
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(Path(__file__).parent),
               "-k", "ieee or across or halves or gathers or vector or eight or compress or shuffled or four or lowest"]
    result = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120, check=False)
    assert result.returncode == 0, result.stdout[-3000:]
    assert "passed" in result.stdout


def test_the_width_can_be_chosen(monkeypatch):
    for width in (4, 8, 16):
        monkeypatch.setenv("GLIMT_LANES", str(width))
        assert host_lanes() == width
    monkeypatch.setenv("GLIMT_LANES", "5")
    with pytest.raises(GlimtError, match="GLIMT_LANES is '5', expected 4, 8 or 16"):
        host_lanes()
