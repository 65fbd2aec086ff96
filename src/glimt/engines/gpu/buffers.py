"""Buffers that hold NumPy arrays on the GPU, and bind groups."""

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from glimt.engines.gpu.adapters import import_wgpu
from glimt.engines.gpu.device import Device
from glimt.errors import EngineError
from glimt.layout import FRAME

Kind = Literal["frame", "uniform", "read", "write"]
"""How kernels use a buffer: ``var<uniform>`` ("frame": a FRAME record, at an offset that each dispatch gives),
``var<storage, read>`` or ``var<storage, read_write>``."""

_TYPES = {"frame": "uniform", "uniform": "uniform", "read": "read-only-storage", "write": "storage"}
_LEAST_BYTES = 256
_GROWTH = 1.5


class Buffer:
    """Words on the GPU; memory is kept as long as it suffices.

    Parameters
    ----------
    device : Device
    label : str
        What is in it, for errors: "the meshes' trees".
    nbytes : int
        Room to begin with.
    extra_usage : int
        wgpu.BufferUsage beyond storage, uniform and copies: INDIRECT where it holds the size of a dispatch.

    Attributes
    ----------
    handle : wgpu.GPUBuffer
        Another one after it had to grow: bind groups that hold it are made anew.
    nbytes : int
        How much of it is in use.
    """

    def __init__(self, device: Device, label: str, nbytes: int = 0, *, extra_usage: int = 0) -> None:
        usage = import_wgpu().BufferUsage
        self._device, self._label = device, label
        self._usage = usage.STORAGE | usage.UNIFORM | usage.COPY_DST | usage.COPY_SRC | extra_usage
        self.handle: Any = None
        self.reserve(nbytes)

    def reserve(self, nbytes: int) -> None:
        """Have room for so many bytes; what was in it is lost when it grows."""
        self.nbytes = nbytes
        if self.handle is not None and nbytes <= self.handle.size:
            return
        most = min(self._device.limits[name] for name in ("max-storage-buffer-binding-size", "max-buffer-size"))
        if nbytes > most:
            raise EngineError(f"{self._label} takes {nbytes / 2**20:,.0f} MiB, more than the {most / 2**20:,.0f} MiB "
                              f"of a buffer of {self._device.adapter.summary}", "choose the CPU engine")
        size = max(nbytes, _LEAST_BYTES)
        if self.handle is not None:
            size = max(size, min(most, int(self.handle.size * _GROWTH)))
            self.destroy()
        with self._device.doing(f"making room for {self._label}"):
            self.handle = self._device.gpu.create_buffer(label=self._label, size=min(-(-size // 16) * 16, most),
                                                         usage=self._usage)

    def upload(self, array: NDArray[Any]) -> None:
        """Take over an array of 4-byte words, before what is submitted next runs."""
        words = np.ascontiguousarray(array)
        if words.dtype.itemsize % 4:
            raise TypeError(f"{self._label}: {words.dtype} is not made of 4-byte words")
        self.reserve(words.nbytes)
        if words.nbytes:
            with self._device.doing(f"uploading {self._label}"):
                self._device.gpu.queue.write_buffer(self.handle, 0, words.reshape(-1).view(np.uint32))

    def destroy(self) -> None:
        """Give back its memory, once what was submitted has run."""
        if self.handle is not None:
            self.handle.destroy()
            self.handle = None  # whatever comes next, a buffer that is gone is never used


class Download:
    """Brings words back from the GPU: of several buffers at once, through memory that is kept."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._staging: Any = None
        self._wanted: list[tuple[Buffer, int, NDArray[Any]]] = []

    def begin(self) -> None:
        """Forget what was wanted of a submission that failed."""
        self._wanted.clear()

    def want(self, source: Buffer, out: NDArray[Any], offset: int = 0) -> None:
        """Have an array filled by the next `take`, from byte `offset` of a buffer on."""
        if offset + out.nbytes > source.nbytes:
            raise ValueError(f"an array of {out.nbytes} bytes is more than the {source.nbytes - offset} of the buffer")
        self._wanted.append((source, offset, out))

    def record(self, encoder: Any) -> None:
        """Have what is wanted copied after what was recorded before."""
        nbytes = sum(out.nbytes for _, _, out in self._wanted)
        if nbytes and (self._staging is None or self._staging.size < nbytes):
            usage = import_wgpu().BufferUsage
            if self._staging is not None:
                self._staging.destroy()
            with self._device.doing("making room for what comes back"):
                self._staging = self._device.gpu.create_buffer(
                    label="download", size=nbytes, usage=usage.MAP_READ | usage.COPY_DST)
        first = 0
        for source, offset, out in self._wanted:
            if out.nbytes:
                encoder.copy_buffer_to_buffer(source.handle, offset, self._staging, first, out.nbytes)
                first += out.nbytes

    def take(self) -> None:
        """Wait for what was recorded and submitted, and fill the arrays with it."""
        wanted, self._wanted = self._wanted, []
        nbytes = sum(out.nbytes for _, _, out in wanted)
        if not nbytes:
            return
        with self._device.doing("waiting for results"):
            try:  # without the empty submission that wgpu makes first: ours is younger than the last write
                self._device.wait(self._staging.map_async("READ_NOSYNC", 0, nbytes))
            except BaseException:  # Ctrl-C: what is about to be mapped is of no use any more
                self._staging.destroy()
                self._staging = None
                raise
            try:
                words, first = np.frombuffer(self._staging.read_mapped(copy=False), np.uint8), 0
                for _, _, out in wanted:
                    end = first + out.nbytes
                    out[...], first = words[first:end].view(out.dtype).reshape(out.shape), end
                del words  # before its memory goes
            finally:
                self._staging.unmap()

    def read(self, source: Buffer, out: NDArray[Any]) -> NDArray[Any]:
        """Return what is in a buffer now, as `out`."""
        self.begin()
        self.want(source, out)
        with self._device.doing("reading results"):
            encoder = self._device.gpu.create_command_encoder()
            self.record(encoder)
            self._device.gpu.queue.submit([encoder.finish()])
        self.take()
        return out


class Bindings:
    """The layout of a bind group, and the group made for it last.

    Parameters
    ----------
    device : Device
    kinds : sequence of (binding, kind)
    """

    def __init__(self, device: Device, kinds: Sequence[tuple[int, Kind]]) -> None:
        self._device = device
        self._numbers = [number for number, _ in kinds]
        self._handles: list[Any] = []
        self._group: Any = None
        visible = import_wgpu().ShaderStage.COMPUTE
        with device.doing("laying out bindings"):
            self.layout = device.gpu.create_bind_group_layout(entries=[
                {"binding": number, "visibility": visible, "buffer": {"type": _TYPES[kind],
                                                                          "has_dynamic_offset": kind == "frame"}}
                for number, kind in kinds])
        self._sizes = [4 * FRAME.words if kind == "frame" else None for _, kind in kinds]

    def group(self, buffers: Sequence[Buffer]) -> Any:
        """Return the bind group of buffers, in the order of the kinds; the last one if they are the same."""
        handles = [buffer.handle for buffer in buffers]
        if self._group is None or any(a is not b for a, b in zip(handles, self._handles, strict=True)):
            entries = [{"binding": number, "resource": {"buffer": handle, "offset": 0, "size": size or handle.size}}
                       for number, handle, size in zip(self._numbers, handles, self._sizes, strict=True)]
            with self._device.doing("binding buffers"):
                self._group = self._device.gpu.create_bind_group(layout=self.layout, entries=entries)
            self._handles = handles
        return self._group
