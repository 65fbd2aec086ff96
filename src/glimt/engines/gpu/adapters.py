"""The adapters of this machine: what there is to compute on, and which of them is taken."""

import contextlib
import functools
import importlib.util
import logging
import os
import sys
import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from glimt.errors import GlimtError

_KINDS = {"DiscreteGPU": "discrete", "IntegratedGPU": "integrated", "CPU": "software"}
"""wgpu calls a virtual machine's GPU "CPU" as well: it must be asked for by name."""
_BEST_FIRST = ("discrete", "integrated", "unknown", "software")

LEAST_LIMITS = {
    "max-storage-buffer-binding-size": 128 << 20,
    "max-buffer-size": 128 << 20,
    "max-storage-buffers-per-shader-stage": 8,
    "max-uniform-buffer-binding-size": 16 << 10,
    "max-compute-invocations-per-workgroup": 256,
    "max-compute-workgroup-size-x": 256,
    "max-compute-workgroup-size-y": 256,
    "max-compute-workgroup-storage-size": 16 << 10,
    "max-compute-workgroups-per-dimension": 65535,
}
"""What every adapter of WebGPU owes; an old driver may fall short of it."""


@dataclass(frozen=True)
class AdapterInfo:
    """A GPU as one of its drivers shows it; a GPU with two drivers is there twice.

    Attributes
    ----------
    summary : str
        Name, kind and driver; GLIMT_GPU may be any part of it.
    kind : "discrete", "integrated", "unknown" or "software"
    backend : "Vulkan", "Metal", "D3D12" or "OpenGL"
    lacks : str
        Limits that fall short of what the engine needs; empty where it can be used.
    handle : wgpu.GPUAdapter
    """

    summary: str
    kind: str
    backend: str
    lacks: str = ""
    handle: Any = field(default=None, repr=False, compare=False)


class _Calls(threading.local):
    """How deep a thread is in calls whose log is not wanted."""

    depth = 0


class _Log(logging.Filter):
    """Keeps wgpu's log to what nobody is told otherwise: an error of a call is raised, the loss of a device as well."""

    def __init__(self) -> None:
        super().__init__()
        self.reason = ""
        self._calls = _Calls()

    @contextlib.contextmanager
    def silent(self) -> Iterator[None]:
        """Drop what this thread's calls log."""
        self.begin_silence()
        try:
            yield
        finally:
            self.end_silence()

    def begin_silence(self) -> None:
        """Drop what this thread's calls log from now on."""
        self._calls.depth += 1

    def end_silence(self) -> None:
        """Undo one `begin_silence`."""
        self._calls.depth -= 1

    def filter(self, record: logging.LogRecord) -> bool:
        """Return whether a message is to be written."""
        text = record.getMessage()
        if text.startswith("The WGPU device was lost"):
            self.reason = " ".join(text.split())
            return False
        return not (text == "DEVICE LOST!" or self._calls.depth)


wgpu_log = _Log()
_lock = threading.Lock()


def is_installed() -> bool:
    """Return whether wgpu is there, without importing it."""
    return importlib.util.find_spec("wgpu") is not None


@functools.cache
def import_wgpu() -> Any:
    """Return the package wgpu."""
    try:
        import wgpu
    except ModuleNotFoundError as error:
        raise GlimtError(f"the GPU engine needs the package {error.name}: pip install 'glimt[gpu]'") from None
    except (ImportError, OSError, RuntimeError) as error:
        raise GlimtError(f"wgpu cannot be loaded: {error}; pip install --force-reinstall 'glimt[gpu]'") from error
    logging.getLogger("wgpu").addFilter(wgpu_log)
    return wgpu


@contextlib.contextmanager
def silent_drivers() -> Iterator[None]:
    """Have drivers look for screens without a word on stderr: they compute, and need none."""
    name = "XDG_RUNTIME_DIR"  # libwayland complains when it is not set, and is content with a folder that has no socket
    unset = sys.platform.startswith("linux") and not os.environ.get(name)
    if unset:
        os.environ[name] = os.devnull
    try:
        with wgpu_log.silent():
            yield
    finally:
        if unset:
            os.environ.pop(name, None)


def list_adapters() -> list[AdapterInfo]:
    """Return what this machine has, best first; the first call takes some tenths of a second.

    Raises
    ------
    GlimtError
        When wgpu is not installed.
    """
    with _lock:
        return list(_find_adapters())


@functools.cache
def _find_adapters() -> list[AdapterInfo]:
    wgpu = import_wgpu()
    with silent_drivers():
        found = [_describe(adapter) for adapter in wgpu.gpu.enumerate_adapters_sync()]
    return sorted(found, key=lambda info: (_BEST_FIRST.index(info.kind), info.backend == "OpenGL"))


def _describe(adapter: Any) -> AdapterInfo:
    return AdapterInfo(adapter.summary, _KINDS.get(adapter.info["adapter_type"], "unknown"),
                       adapter.info["backend_type"], shortfall(adapter.limits, LEAST_LIMITS), adapter)


def shortfall(limits: dict[str, int], needed: dict[str, int]) -> str:
    """Return which limits fall short of what is needed, by how much; empty when none does."""
    return ", ".join(f"{name} is {limits.get(name, 0):,}, needed {least:,}" for name, least in needed.items()
                     if limits.get(name, 0) < least)


def choose_adapter(adapters: Sequence[AdapterInfo], wanted: str = "") -> AdapterInfo:
    """Return the adapter to compute on.

    Parameters
    ----------
    adapters : sequence of AdapterInfo
        Best first.
    wanted : str
        Empty for the best GPU; "software" for a driver that computes on the CPU; or part of a summary.

    Raises
    ------
    GlimtError
        When there is none, with how to get one, or none that will do, with what it lacks.
    """
    if wanted.lower() == "software":
        fitting = [info for info in adapters if info.kind == "software"]
        absent = f"no software adapter was found; {_remedy(software=True)}"
    elif wanted:
        fitting = [info for info in adapters if wanted.lower() in info.summary.lower()]
        absent = f"GLIMT_GPU is {wanted!r}, which is part of no adapter's summary; there are: {_names(adapters)}"
    else:
        fitting = [info for info in adapters if info.kind != "software"]
        absent = f"no GPU was found; {_remedy()}"
        if adapters:
            absent += f". GLIMT_GPU=software takes {adapters[0].summary}, for tests"
    if not fitting:
        raise GlimtError(absent)
    able = [info for info in fitting if not info.lacks]
    if not able:
        reasons = "; ".join(f"{info.summary}: {info.lacks}" for info in fitting)
        raise GlimtError(f"no adapter suffices ({reasons}); update its driver, or render with the CPU engine")
    return able[0]


def _names(adapters: Sequence[AdapterInfo]) -> str:
    return ", ".join(info.summary for info in adapters) or "none"


def _remedy(software: bool = False) -> str:
    """Return how to get a driver on this system."""
    if sys.platform == "darwin":
        return "macOS has Metal's with the system, from 10.15 on"
    if sys.platform == "win32":
        return "install the graphics card's driver, for Direct3D 12 or Vulkan"
    if software:
        return "Mesa has one (Debian, Ubuntu: apt install libvulkan1 mesa-vulkan-drivers)"
    return ("install its Vulkan driver (Debian, Ubuntu: apt install libvulkan1, with mesa-vulkan-drivers for AMD and "
            "Intel, nvidia-driver for NVIDIA)")
