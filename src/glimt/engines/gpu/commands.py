"""What is sent to the GPU at once: dispatches in order, each with its time if wanted."""

import itertools
from typing import Any

import numpy as np

from glimt.engines.gpu.adapters import import_wgpu
from glimt.engines.gpu.buffers import Buffer, Download
from glimt.engines.gpu.device import Device
from glimt.layout import FRAME

MOST_TICKS = 256
"""Timestamps of one submission; stages that begin after the last one run untimed."""
_TICK_BYTES = 8


class Timer:
    """Times the stages of one submission after the other.

    A timestamp begins the time of a label, or of none, which lasts to the next timestamp.

    Parameters
    ----------
    device : Device
        With timestamps; without them no time is ever measured.

    Attributes
    ----------
    marks_inside : bool
        Whether timestamps are written within a pass, by `mark`; else each stage is a pass of its own, told of `writes`.
    """

    def __init__(self, device: Device) -> None:
        self.marks_inside = device.has_inner_timestamps
        self._tick_seconds = device.tick_seconds
        self._queries: Any = None
        self._labels: list[str] = []
        self._taken = np.zeros(0, np.uint64)
        if device.has_timestamps:
            wgpu = import_wgpu()
            self._write = wgpu.backends.wgpu_native.extras.write_timestamp
            self._queries = device.gpu.create_query_set(type="timestamp", count=MOST_TICKS)
            self._ticks = Buffer(device, "timestamps", MOST_TICKS * _TICK_BYTES,
                                 extra_usage=wgpu.BufferUsage.QUERY_RESOLVE)

    def begin(self) -> None:
        """Forget the last submission."""
        self._labels.clear()

    def mark(self, work: Any, label: str) -> None:
        """Write a timestamp in a pass: from here on it is the time of a label, or of none."""
        if self._queries is None or len(self._labels) == MOST_TICKS:
            return
        self._write(work, self._queries, len(self._labels))
        self._labels.append(label if len(self._labels) < MOST_TICKS - 1 else "")

    def writes(self, label: str) -> dict[str, Any] | None:
        """Return what wgpu is told at the beginning of a pass whose time is that of a label."""
        at = len(self._labels)
        if self._queries is None or at + 2 > MOST_TICKS:
            return None
        self._labels += [label, ""]
        return {"query_set": self._queries, "beginning_of_pass_write_index": at, "end_of_pass_write_index": at + 1}

    def record(self, encoder: Any, download: Download) -> None:
        """Have the times brought back."""
        self._taken = np.zeros(len(self._labels), np.uint64)
        if self._labels:
            encoder.resolve_query_set(self._queries, 0, len(self._labels), self._ticks.handle, 0)
            download.want(self._ticks, self._taken)

    def seconds(self) -> dict[str, float]:
        """Return what the stages of the last submission took, by label, once the download was taken."""
        totals = {label: 0.0 for label in self._labels if label}
        ticks = self._taken.astype(np.int64).tolist()
        for label, (start, end) in zip(self._labels[:-1], itertools.pairwise(ticks), strict=True):
            if label:
                totals[label] += max(0, end - start) * self._tick_seconds
        return totals


class Commands:
    """Records dispatches and copies, which then run in that order; each dispatch sees what the ones before it wrote.

    Parameters
    ----------
    device : Device
    download : Download
        Brings back what is wanted.
    timer : Timer, optional
        Times the dispatches.
    """

    def __init__(self, device: Device, download: Download, timer: Timer | None = None) -> None:
        self._device, self._download, self._timer = device, download, timer
        self._label = ""
        self._pass: Any = None  # of the dispatch before
        download.begin()
        if timer:
            timer.begin()
        with device.doing("recording commands"):
            self._encoder = device.gpu.create_command_encoder()

    def dispatch(self, label: str, pipeline: Any, groups: list[Any], size: tuple[int, int, int] | Buffer,
                 offset: int = 0, frame: int | None = None) -> None:
        """Run a kernel.

        Parameters
        ----------
        label : str
            What its time is counted under; dispatches of one label in a row are timed as one.
        pipeline : wgpu.GPUComputePipeline
        groups : list of wgpu.GPUBindGroup
        size : (x, y, z) or Buffer
            How many workgroups; of an indirect buffer, the three words from byte `offset` on when the dispatch begins.
        offset : int
        frame : int, optional
            Which FRAME record group 0 is to see.
        """
        with self._device.doing("recording a dispatch"):
            if self._pass is None or label != self._label:
                self._begin_stage(label)
            work = self._pass
            work.set_pipeline(pipeline)
            for number, group in enumerate(groups):
                offsets = [4 * FRAME.words * frame] if frame is not None and number == 0 else []
                work.set_bind_group(number, group, offsets)
            if isinstance(size, Buffer):
                work.dispatch_workgroups_indirect(size.handle, offset)
            else:
                work.dispatch_workgroups(*size)

    def copy(self, source: Buffer, first: int, target: Buffer, to: int, nbytes: int) -> None:
        """Copy bytes from one buffer, from byte `first` on, into another, from byte `to` on."""
        with self._device.doing("recording a copy"):
            self._end_pass()
            self._encoder.copy_buffer_to_buffer(source.handle, first, target.handle, to, nbytes)

    def clear(self, buffer: Buffer) -> None:
        """Fill what is in use of a buffer with zeros."""
        with self._device.doing("recording a clear"):
            self._end_pass()
            self._encoder.clear_buffer(buffer.handle, 0, -(-buffer.nbytes // 4) * 4)

    def submit(self) -> None:
        """Have everything run, and what is wanted be brought back after it; at once returns."""
        with self._device.doing("submitting commands"):
            self._end_pass()
            if self._timer:
                self._timer.record(self._encoder, self._download)
            self._download.record(self._encoder)
            self._device.gpu.queue.submit([self._encoder.finish()])

    def _begin_stage(self, label: str) -> None:
        """Begin a pass, or go on with the one at hand, where its time can be taken within."""
        self._label = label
        timer = self._timer
        if timer and not timer.marks_inside:
            self._end_pass()
            self._pass = self._encoder.begin_compute_pass(label=label, timestamp_writes=timer.writes(label))
            return
        if self._pass is None:
            self._pass = self._encoder.begin_compute_pass(label="glimt")
        if timer:
            timer.mark(self._pass, label)

    def _end_pass(self) -> None:
        if self._pass is not None:
            if self._timer and self._timer.marks_inside:
                self._timer.mark(self._pass, "")
            self._pass.end()
            self._pass = None
