"""What is sent to the GPU at once: passes in order, each with its time if wanted."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from glimt.engines.gpu.adapters import import_wgpu
from glimt.engines.gpu.buffers import Buffer, Download
from glimt.engines.gpu.device import Device
from glimt.layout import FRAME

MOST_TIMED = 128
"""Passes of one submission that are timed; those after that run untimed."""
_TICK_BYTES = 8


@dataclass
class _Slot:
    """Timestamps of one submission: where the GPU writes them, and how they come back."""

    queries: Any
    ticks: Buffer
    download: Download
    labels: list[str] = field(default_factory=list)


class Timer:
    """Times passes by label. Results of one submission are there until `depth` later ones were made.

    Parameters
    ----------
    device : Device
        With timestamps; without them no time is ever measured.
    depth : int
        How many submissions are remembered.
    """

    def __init__(self, device: Device, depth: int = 3) -> None:
        self._device = device
        self._slots: list[_Slot] = []
        self._next = 0
        if device.has_timestamps:
            usage = import_wgpu().BufferUsage
            for _ in range(depth):
                queries = device.gpu.create_query_set(type="timestamp", count=2 * MOST_TIMED)
                ticks = Buffer(device, "timestamps", 2 * MOST_TIMED * _TICK_BYTES, extra_usage=usage.QUERY_RESOLVE)
                self._slots.append(_Slot(queries, ticks, Download(device)))

    def begin(self) -> _Slot | None:
        """Return the timestamps of the next submission, the oldest ones; None when passes cannot be timed."""
        if not self._slots:
            return None
        slot = self._slots[self._next % len(self._slots)]
        self._next += 1
        slot.labels.clear()
        return slot

    def seconds(self, back: int = 0) -> dict[str, float]:
        """Return what passes took, by label, in the submission so many before the last; waits until it has run."""
        if not 0 <= back < min(len(self._slots), self._next):
            return {}
        slot = self._slots[(self._next - 1 - back) % len(self._slots)]
        if not slot.labels:
            return {}
        ticks = slot.download.take(np.empty((len(slot.labels), 2), np.uint64))
        totals = dict.fromkeys(slot.labels, 0.0)
        for label, (start, end) in zip(slot.labels, ticks.astype(np.int64), strict=True):
            totals[label] += max(0, int(end - start)) * self._device.tick_seconds
        return totals


class Commands:
    """Records passes and copies, which then run in that order; each pass sees what the ones before it wrote.

    Parameters
    ----------
    device : Device
    timer : Timer, optional
        Times the passes.
    """

    def __init__(self, device: Device, timer: Timer | None = None) -> None:
        self._device = device
        self._slot = timer.begin() if timer else None
        with device.doing("recording commands"):
            self._encoder = device.gpu.create_command_encoder()

    def dispatch(self, label: str, pipeline: Any, groups: list[Any], size: tuple[int, int, int] | Buffer,
                 offset: int = 0, frame: int | None = None) -> None:
        """Run a kernel as a pass of its own.

        Parameters
        ----------
        label : str
            What its time is counted under.
        pipeline : wgpu.GPUComputePipeline
        groups : list of wgpu.GPUBindGroup
        size : (x, y, z) or Buffer
            How many workgroups; of an indirect buffer, the three words from byte `offset` on when the pass begins.
        offset : int
        frame : int, optional
            Which FRAME record group 0 is to see.
        """
        with self._device.doing(f"recording {label}"):
            work = self._encoder.begin_compute_pass(label=label, timestamp_writes=self._timestamps(label))
            work.set_pipeline(pipeline)
            for number, group in enumerate(groups):
                offsets = [4 * FRAME.words * frame] if frame is not None and number == 0 else []
                work.set_bind_group(number, group, offsets)
            if isinstance(size, Buffer):
                work.dispatch_workgroups_indirect(size.handle, offset)
            else:
                work.dispatch_workgroups(*size)
            work.end()

    def clear(self, buffer: Buffer) -> None:
        """Fill what is in use of a buffer with zeros."""
        with self._device.doing("recording a clear"):
            self._encoder.clear_buffer(buffer.handle, 0, -(-buffer.nbytes // 4) * 4)

    def download(self, download: Download, source: Buffer, nbytes: int | None = None, offset: int = 0) -> None:
        """Have a buffer copied for `Download.take`."""
        with self._device.doing("recording a download"):
            download.record(self._encoder, source, nbytes, offset)

    def submit(self) -> None:
        """Have everything run; at once returns."""
        with self._device.doing("submitting commands"):
            if self._slot and self._slot.labels:
                count = 2 * len(self._slot.labels)
                self._encoder.resolve_query_set(self._slot.queries, 0, count, self._slot.ticks.handle, 0)
                self._slot.download.record(self._encoder, self._slot.ticks, count * _TICK_BYTES)
            self._device.gpu.queue.submit([self._encoder.finish()])

    def _timestamps(self, label: str) -> dict[str, Any] | None:
        if self._slot is None or len(self._slot.labels) == MOST_TIMED:
            return None
        self._slot.labels.append(label)
        at = 2 * len(self._slot.labels) - 2
        return {"query_set": self._slot.queries, "beginning_of_pass_write_index": at,
                "end_of_pass_write_index": at + 1}
