"""What the numbers of a study depend on besides the code: the machine, the versions, the scene's files."""

import hashlib
import platform
import re
import subprocess
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from glimt.bench.measure import machine
from glimt.engines.cpu.engine import available_threads
from glimt.io import load
from glimt.io.files_read import recorded
from glimt.scene.scene import Scene
from glimt.study.results import Machine, SceneFacts

_PACKAGES = ("numba", "llvmlite", "numpy", "wgpu", "matplotlib")


def load_scene(path: Path) -> tuple[Scene, SceneFacts]:
    """Return a scene and what a result says of it, with a hash over the contents of all files that were read."""
    with recorded() as files:
        scene = load(path)
    digest = hashlib.sha256()
    for file in sorted(files, key=lambda each: each.name):
        if file.is_file():
            digest.update(file.name.encode() + b"\0" + hashlib.sha256(file.read_bytes()).digest())
    return scene, SceneFacts(name=scene.name, sha256=digest.hexdigest(), triangles=scene.placed_triangles(),
                             spheres=len(scene.spheres()), lights=len(scene.lights))


def this_machine(threads: int | None, adapter: str | None) -> Machine:
    """Return what a result says of this machine; `adapter`: the GPU that renders."""
    facts = machine()
    versions = {"glimt": facts["glimt"], "python": facts["python"]}
    for name in _PACKAGES:
        try:
            versions[name] = version(name)
        except PackageNotFoundError:
            continue
    return Machine(processor=f"{_processor()} ({facts['processor']})", features=facts["features"],
                   lanes=facts["lanes"], cores=facts["cores"] or 1, threads=threads or available_threads(),
                   clock_mhz=_clock_mhz(), adapter=adapter, system=facts["system"], versions=versions)


def _processor() -> str:
    """Return the processor's name as its maker writes it, as far as the system tells."""
    found = re.search(r"^model name\s*:\s*(.+)$", _cpuinfo(), re.MULTILINE)
    return found[1].strip() if found else _sysctl("machdep.cpu.brand_string") or platform.processor() or "unknown"


def _clock_mhz() -> float | None:
    """Return the clock of the fastest core right now, as far as the system tells."""
    clocks = [float(text) for text in re.findall(r"^cpu MHz\s*:\s*([\d.]+)$", _cpuinfo(), re.MULTILINE)]
    if clocks:
        return max(clocks)
    hertz = _sysctl("hw.cpufrequency")
    return float(hertz) / 1e6 if hertz.isdecimal() else None


def _cpuinfo() -> str:
    try:
        return Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""


def _sysctl(name: str) -> str:
    if sys.platform != "darwin":
        return ""
    try:
        return subprocess.run(["sysctl", "-n", name], capture_output=True, text=True, timeout=5).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return ""
