"""From what a GPU rendered to what its window shows, without a way through memory."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from glimt.engines.gpu.device import Device
from glimt.engines.gpu.display import Display
from glimt.errors import EngineError
from glimt.film import DistantFilm, Film
from glimt.scene.scene import RenderSettings
from glimt.viewer.presenter import Picture, Presenter

if TYPE_CHECKING:
    from glimt.viewer.viewer import Viewer


class GpuPresenter(Presenter):
    """Develops on the GPU and lays the overlay over there, for as long as films come from there.

    From then on it does what `Presenter` does, which it also does for those who ask for the picture's bytes.
    """

    def __init__(self, threads: int, device: Device) -> None:
        self._display: Display | None = None
        self._failed = False
        self._layer = np.zeros((0, 0, 4), np.uint8)
        self._shown_size = 0, 0
        self._bring: Callable[[], None] | None = None  # the picture into memory, if it is not there
        super().__init__(threads)
        self._display = Display(device)

    def develop(self, film: Film, settings: RenderSettings, size: tuple[int, int]) -> None:
        """Take over a film for a canvas of `size`."""
        by_memory = partial(super().develop, film, replace(settings), size)
        if isinstance(film, DistantFilm):
            self._show(lambda display: display.develop(film, settings.exposure, settings.tone_curve), by_memory, size)
            return
        self._display = None  # another engine has taken over
        self._shown_size, self._bring = size, None
        by_memory()

    def show(self, image: NDArray[np.uint8], size: tuple[int, int]) -> None:
        """Take over a picture, (h, w, 3), for a canvas of `size`."""
        self._show(lambda display: display.upload(np.dstack([image, np.full(image.shape[:2], 255, np.uint8)])),
                   partial(super().show, image, size), size)

    def compose(self, viewer: "Viewer") -> Picture:
        """Return what a window of the GPU shows; or the picture in memory, once the GPU has failed."""
        if self._display is not None:
            try:
                if not self._failed:
                    self._cover(viewer, self._display)
                    return self._display.picture()
            except EngineError:
                pass
            viewer.leave_gpu()
        return super().compose(viewer)

    def leave_gpu(self) -> None:
        """Have pictures pass through memory from now on; the one at hand is black if it cannot be brought back."""
        self._display = None
        try:
            self._bring_back()
        except EngineError:
            self._bring = None
            super().show(np.zeros((1, 1, 3), np.uint8), self._shown_size)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture as it is shown."""
        return self._shown_size

    def picture(self) -> NDArray[np.uint8]:
        """Return the picture without overlay, (h, w, 4) uint8: brought back if it is on the GPU.

        Raises
        ------
        EngineError
            When the GPU is lost, and the picture with it.
        """
        self._bring_back()
        return super().picture()

    def _show(self, on_gpu: Callable[[Display], None], by_memory: Callable[[], None], size: tuple[int, int]) -> None:
        """Take over a picture, on the GPU if that still works."""
        self._shown_size, self._bring = size, by_memory
        if self._display is None:
            self._bring_back()
            return
        try:
            on_gpu(self._display)
        except EngineError:
            self._failed = True  # `compose` can ask for another picture

    def _bring_back(self) -> None:
        """Have the picture in memory too."""
        if self._bring is not None:
            self._bring()
            self._bring = None

    def _cover(self, viewer: "Viewer", display: Display) -> None:
        """Lay the overlay over the picture."""
        if self._layer.shape[:2] != self._shown_size[::-1]:
            self._layer = np.zeros((self._shown_size[1], self._shown_size[0], 4), np.uint8)
        self._layer[...] = 0  # over which a panel leaves its colours times its opacity, and its opacity
        self._draw_overlay(viewer, self._layer)
        display.cover(self._layer)
