"""Pictures that go from a film on the GPU to a window of the same GPU, and never through memory."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from glimt.color import ToneCurve, exposure_scale
from glimt.engines.gpu.adapters import import_wgpu
from glimt.engines.gpu.buffers import Buffer
from glimt.engines.gpu.device import Device
from glimt.engines.gpu.shader import compile_parts, kernel
from glimt.film import DistantFilm

_GROUP = 8
"""Side of the workgroups of develop.wgsl."""
_FORMATS = ("bgra8unorm", "rgba8unorm")
"""Of windows, best first: they take sRGB codes as they are."""


class GpuPicture(NamedTuple):
    """What a window shows: views of two textures. Those who draw it see the last content that was finished by then."""

    picture: Any
    overlay: Any


class Display:
    """A picture for a window: developed, and with a layer over it.

    There is one of it, and no ring: a queue does one thing after the other, so that whoever draws it meanwhile gets
    either the whole picture before or the whole next one.
    """

    def __init__(self, device: Device) -> None:
        self._device = device
        self._orders = Buffer(device, "how films are developed", 16)
        self._picture, self._overlay = (_texture(device, (1, 1)) for _ in range(2))
        self._layer = np.zeros((1, 1, 4), np.uint8)  # what is in the overlay
        self._views = GpuPicture(self._picture.create_view(), self._overlay.create_view())
        with device.doing("compiling develop.wgsl"):
            self._pipeline = device.gpu.create_compute_pipeline(
                label="develop", layout="auto", compute={"module": compile_parts(device, [kernel("develop")])})

    def develop(self, film: DistantFilm, exposure: float, tone_curve: ToneCurve) -> None:
        """Take over a film (see `glimt.color.develop`)."""
        self._resize(film.size)
        width, height = film.size
        orders = np.array([width, height, 0, tone_curve == "filmic"], np.uint32)
        orders[2:3].view(np.float32)[0] = exposure_scale(exposure)
        self._orders.upload(orders)
        gpu, sums = self._device.gpu, film.place.handle
        with self._device.doing("developing"):
            group = gpu.create_bind_group(layout=self._pipeline.get_bind_group_layout(0), entries=[
                {"binding": 0, "resource": {"buffer": self._orders.handle, "offset": 0, "size": 16}},
                {"binding": 1, "resource": {"buffer": sums, "offset": 0, "size": 16 * width * height}},
                {"binding": 2, "resource": self._views.picture}])
            encoder = gpu.create_command_encoder()
            work = encoder.begin_compute_pass()
            work.set_pipeline(self._pipeline)
            work.set_bind_group(0, group)
            work.dispatch_workgroups(-(-width // _GROUP), -(-height // _GROUP))
            work.end()
            gpu.queue.submit([encoder.finish()])

    def upload(self, image: NDArray[np.uint8]) -> None:
        """Take over a picture from memory, (h, w, 4) uint8."""
        self._resize((image.shape[1], image.shape[0]))
        self._write(self._picture, image, 0)

    def cover(self, layer: NDArray[np.uint8]) -> None:
        """Lay (h, w, 4) uint8 over the picture, colours multiplied by opacity; only rows that changed are uploaded."""
        height, width = layer.shape[:2]
        if layer.shape != self._layer.shape:
            with self._device.doing("making room for the overlay"):
                self._overlay = _texture(self._device, (width, height))
                self._views = self._views._replace(overlay=self._overlay.create_view())
            self._layer = np.zeros_like(layer)  # as textures are at first
        words, before = (rows.view(np.uint32)[..., 0] for rows in (layer, self._layer))
        changed = np.flatnonzero((words != before).any(1))
        if len(changed):
            first, end = int(changed[0]), int(changed[-1]) + 1
            self._write(self._overlay, layer[first:end], first)
            self._layer[first:end] = layer[first:end]

    def picture(self) -> GpuPicture:
        """Return what a window is given: the same object for as long as sizes stay."""
        return self._views

    def _resize(self, size: tuple[int, int]) -> None:
        """Have room for a picture of that (width, height)."""
        if self._picture.size[:2] != size:
            with self._device.doing("making room for a picture"):
                self._picture = _texture(self._device, size)
                self._views = self._views._replace(picture=self._picture.create_view())

    def _write(self, texture: Any, rows: NDArray[np.uint8], first: int) -> None:
        """Write whole rows, from `first` on."""
        height, width = rows.shape[:2]
        with self._device.doing("uploading a picture"):
            self._device.gpu.queue.write_texture({"texture": texture, "origin": (0, first, 0)}, rows,
                                                 {"bytes_per_row": 4 * width, "rows_per_image": height},
                                                 (width, height, 1))


class Surface:
    """A window that shows pictures of one GPU; for the thread of the window.

    Parameters
    ----------
    device : Device
    place : dict
        What rendercanvas tells wgpu of a window, and "vsync".

    Raises
    ------
    EngineError
        Where this GPU cannot show anything in this window.
    """

    def __init__(self, device: Device, place: dict[str, Any]) -> None:
        self._device, gpu = device, device.gpu
        self._shown: GpuPicture | None = None
        self._group: Any = None
        with device.doing("opening a window"):
            self._context = import_wgpu().gpu.get_canvas_context(place)
            preferred = self._context.get_preferred_format(gpu.adapter).removesuffix("-srgb")
            form = preferred if preferred in _FORMATS else _FORMATS[0]
            self._context.configure(device=gpu, format=form)
            self._sampler = gpu.create_sampler(mag_filter="linear", min_filter="linear")
            module = compile_parts(device, [kernel("show")])
            self._pipeline = gpu.create_render_pipeline(
                label="show", layout="auto", vertex={"module": module, "entry_point": "corner"},
                primitive={"topology": "triangle-list"},
                fragment={"module": module, "entry_point": "show", "targets": [{"format": form}]})

    def draw(self, picture: GpuPicture, width: int, height: int) -> bool:
        """Draw over the whole window, which has so many pixels; return whether it could be drawn on just now."""
        gpu = self._device.gpu
        with self._device.doing("showing a picture"):
            gpu.create_command_encoder().finish()  # an error when the device is lost: wgpu would panic over the rest
            encoder = gpu.create_command_encoder()
            self._context.set_physical_size(width, height)
            try:
                target = self._context.get_current_texture().create_view()
            except import_wgpu().DrawCancelled:
                return False
            work = encoder.begin_render_pass(color_attachments=[
                {"view": target, "load_op": "clear", "store_op": "store", "clear_value": (0, 0, 0, 1)}])
            work.set_pipeline(self._pipeline)
            work.set_bind_group(0, self._bound(picture))
            work.draw(3)
            work.end()
            gpu.queue.submit([encoder.finish()])
            self._context.present()
            return True

    def close(self) -> None:
        """Let go of the window, which is about to be closed."""
        self._context.unconfigure()
        self._context = self._group = self._shown = None

    def _bound(self, picture: GpuPicture) -> Any:
        """Return the bind group of a picture; the last one if it is the same."""
        if picture is not self._shown:
            self._group = self._device.gpu.create_bind_group(layout=self._pipeline.get_bind_group_layout(0), entries=[
                {"binding": 0, "resource": picture.picture}, {"binding": 1, "resource": picture.overlay},
                {"binding": 2, "resource": self._sampler}])
            self._shown = picture
        return self._group


def _texture(device: Device, size: tuple[int, int]) -> Any:
    """Return a texture for a picture of that (width, height), which is black and transparent."""
    usage = import_wgpu().TextureUsage
    with device.doing("making room for a picture"):
        return device.gpu.create_texture(label="picture", size=(*size, 1), format="rgba8unorm",
                                         usage=usage.STORAGE_BINDING | usage.TEXTURE_BINDING | usage.COPY_DST
                                         | usage.COPY_SRC)
