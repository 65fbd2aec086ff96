"""A GPU opened for compute, and what its errors mean."""

import math
import os
from typing import Any

from glimt.engines.gpu.adapters import (
    LEAST_LIMITS,
    AdapterInfo,
    choose_adapter,
    import_wgpu,
    list_adapters,
    shortfall,
    silent_drivers,
    wgpu_log,
)
from glimt.errors import EngineError, GlimtError

__all__ = ["AdapterInfo", "Device", "list_adapters", "open_device"]

MOST_BINDING_BYTES = (2 << 30) - 4
"""Of one storage buffer: what 32-bit offsets of words reach by far, and what drivers are good for."""
_TIMING = ("timestamp-query", "timestamp-query-inside-passes")
"""Features that are asked for where they are; the second one is wgpu's own."""
_LOOK_SECONDS = 0.5
_PATIENCE_SECONDS = 60.0


class Device:
    """A GPU opened for compute.

    Attributes
    ----------
    adapter : AdapterInfo
    gpu : wgpu.GPUDevice
    limits : dict
        By WebGPU's names, such as "max-storage-buffer-binding-size".
    has_timestamps : bool
        Whether passes can be timed.
    has_inner_timestamps : bool
        Whether parts of a pass can be timed.
    tick_seconds : float
        Of timestamps.
    kept : dict
        Shader modules and pipelines made so far, by what they were made of.
    patience : float
        Seconds that results may take.
    """

    def __init__(self, adapter: AdapterInfo, gpu: Any) -> None:
        self.adapter, self.gpu = adapter, gpu
        self.limits: dict[str, int] = dict(gpu.limits)
        self.has_timestamps, self.has_inner_timestamps = (name in gpu.features for name in _TIMING)
        self.tick_seconds = 1e-9 * _timestamp_period(gpu)
        self.kept: dict[Any, Any] = {}
        self.patience = math.inf if adapter.kind == "software" else _PATIENCE_SECONDS

    def doing(self, what: str) -> "_Doing":
        """Return a context that turns errors of wgpu into ours; `what` completes "the GPU failed while …"."""
        return _Doing(self, what)

    def explain(self, error: BaseException, what: str) -> EngineError | None:
        """Return our error for one of wgpu, or None for others."""
        wgpu = import_wgpu()
        if isinstance(error, wgpu.GPUOutOfMemoryError):
            return EngineError(f"the GPU has not enough memory while {what} ({self.adapter.summary})",
                               "choose a smaller picture or scene, or the CPU engine")
        if not isinstance(error, wgpu.GPUError | RuntimeError):
            return None
        if self._is_lost():
            return EngineError(f"the GPU was lost while {what} ({self.adapter.summary}): its driver was reset or it "
                               f"was taken away. {wgpu_log.reason}", "start again, or choose the CPU engine")
        return EngineError(f"the GPU failed while {what} ({self.adapter.summary}): {_gist(str(error))}",
                           "the CPU engine can do without")

    def wait(self, promise: Any) -> None:
        """Wait for what wgpu promises; awake for Ctrl-C.

        Raises
        ------
        EngineError
            When the device is lost meanwhile, or its GPU does not answer. One that computes on the CPU has all the time
            it wants: it compiles kernels late, on a machine that may be busy.
        """
        done = promise._thread_event  # `sync_wait` has no end when the device is lost
        waited = 0.0
        while not done.wait(_LOOK_SECONDS):
            self.gpu.create_command_encoder().finish()  # an error when the device is lost
            waited += _LOOK_SECONDS
            if waited >= self.patience:
                raise EngineError(f"the GPU has not answered for {waited:g} s ({self.adapter.summary})",
                                  "restart the machine if it stays so, or choose the CPU engine")
        promise.sync_wait()

    def close(self) -> None:
        """Give back all memory; the device is of no use any more."""
        self.kept.clear()
        self.gpu.destroy()

    def _is_lost(self) -> bool:
        wgpu = import_wgpu()
        try:
            with wgpu_log.silent():
                self.gpu.create_command_encoder().finish()
        except wgpu.GPUError as error:
            return "lost" in str(error)
        return False


class _Doing:
    """A context of `Device.doing`: a class, since a frame has dozens."""

    __slots__ = ("_device", "_what")

    def __init__(self, device: Device, what: str) -> None:
        self._device, self._what = device, what

    def __enter__(self) -> None:
        wgpu_log.begin_silence()

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, traceback: Any) -> None:
        wgpu_log.end_silence()
        ours = self._device.explain(error, self._what) if error is not None else None
        if ours is not None:
            raise ours from error


def open_device(*, software: bool = False, group: tuple[int, int] = (16, 16)) -> Device:
    """Open the best adapter.

    Limits that code is written for are asked for as they are needed, so that no kernel works by chance where it was
    written; sizes of buffers, which the scene decides, as large as the adapter has them.

    Parameters
    ----------
    software : bool
        True takes a driver that computes on the CPU, for tests. Else GLIMT_GPU says which adapter: "software", part of
        a summary, or when it is not set the best GPU.
    group : (width, height)
        Largest workgroup that will be asked for.

    Raises
    ------
    GlimtError
        When wgpu is not installed, there is no adapter, or it lacks something; EngineError when it cannot be opened.
    """
    info = choose_adapter(list_adapters(), "software" if software else os.environ.get("GLIMT_GPU", ""))
    limits = info.handle.limits
    needed = LEAST_LIMITS | {"max-compute-invocations-per-workgroup": max(256, group[0] * group[1]),
                             "max-compute-workgroup-size-x": max(256, group[0]),
                             "max-compute-workgroup-size-y": max(256, group[1])}
    missing = shortfall(limits, needed)
    if missing:
        raise GlimtError(f"{info.summary} cannot run workgroups of {group[0]}×{group[1]}: {missing}")
    for name in ("max-storage-buffer-binding-size", "max-buffer-size"):
        needed[name] = min(limits[name], MOST_BINDING_BYTES)
    features = [name for name in _TIMING if name in info.handle.features]
    try:
        with silent_drivers():
            gpu = info.handle.request_device_sync(label="glimt", required_features=features, required_limits=needed)
    except RuntimeError as error:
        raise EngineError(f"{info.summary} cannot be opened: {_gist(str(error))}",
                          "update its driver, or choose the CPU engine") from error
    return Device(info, gpu)


def _timestamp_period(gpu: Any) -> float:
    """Return the nanoseconds of a timestamp's tick, which wgpu leaves to its caller."""
    from wgpu.backends.wgpu_native import lib
    return float(lib.wgpuQueueGetTimestampPeriod(gpu.queue._internal))


def _gist(message: str) -> str:
    """Return wgpu's message as one line."""
    lines = [line.strip() for line in message.splitlines()]
    return " ".join(line for line in lines if line and line not in ("Validation Error", "Caused by:"))
