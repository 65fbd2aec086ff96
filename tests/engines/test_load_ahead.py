"""Machine code is loaded while a scene is read."""

import subprocess
import sys

import glimt

CODE = """
import threading
from glimt.engines import begin_preparing
begin_preparing()
for thread in threading.enumerate():
    if thread.name == "glimt-load":
        thread.join(60)
from glimt.engines.cpu.kernels.frame import render_tiles
print(len(render_tiles.overloads))
"""


def test_kernels_in_the_cache_are_loaded_ahead():
    glimt.render(glimt.Scene(), size=(1, 1))  # now they are there
    result = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True, timeout=120, check=True)
    assert result.stdout.split() == ["1"]
