"""A canvas that is a page in a browser: pictures go out as JPEG, what is done there comes back as events.

The protocol is that of `rendercanvas.http`, whose canvas does the same and trusts whoever it talks to: its queues are
unbounded, its last frame is compressed in Python in the event loop, and a page can close it.
"""

import asyncio
import contextlib
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import simplejpeg
from numpy.typing import NDArray
from rendercanvas.asyncio import AsyncioLoop
from rendercanvas.base import BaseCanvasGroup, BaseRenderCanvas

from glimt.errors import GlimtError
from glimt.viewer.web.events import Held, parse_event, parse_message, parse_number, parse_size
from glimt.viewer.web.visitor import Frame, Visitor

__all__ = ["WebCanvas", "loop"]

MAX_FILE_SIZE = 64 << 20
"""Bytes that `WebCanvas.offer_file` takes at most."""

_REST_DELAY = 0.3  # s without a new frame, after which the last one is sent again, finer


class WebLoop(AsyncioLoop):  # type: ignore[misc]
    """The loop of web canvases, which `glimt.viewer.web.server.serve` runs."""

    def _rc_call_soon_threadsafe(self, callback: Any) -> None:
        # A thread that renders may be there before the loop runs, when the call waits, and after, when it is moot.
        running = self._interactive_loop or self._run_loop
        if running is not None:
            with contextlib.suppress(RuntimeError):  # it has just been closed
                running.call_soon_threadsafe(callback)
        elif self.get_canvases():
            self.call_soon(callback)


loop = WebLoop()


def encode_jpeg(picture: NDArray[np.uint8], is_fine: bool) -> bytes:
    """Return `picture`, (height, width, 4), as JPEG: small for one of many, without visible loss when `is_fine`."""
    quality, subsampling = (97, "444") if is_fine else (85, "420")
    return bytes(simplejpeg.encode_jpeg(picture, quality=quality, colorspace="RGBA", colorsubsampling=subsampling,
                                        fastdct=True))


class WebCanvas(BaseRenderCanvas):  # type: ignore[misc]
    """A canvas of rendercanvas (present method "bitmap") for pages in browsers.

    Who comes first steers, others watch; when the first one leaves, the next one takes over, and the keys and buttons
    that were held come up. Nothing is drawn while nobody looks. The canvas is as large as the window of whoever steers.

    All methods are for the loop's thread, `stop` excepted: from others, use `loop.call_soon_threadsafe`.

    Parameters
    ----------
    title : str
        Of the page.
    max_fps : float
        Draws a second, at most.
    keys : sequence of {"keys": str or list of str, "help": str, "group": str}
        What the page's help lists.
    size : (width, height) in logical pixels
        Until the first page says how large it is.
    """

    _rc_canvas_group = BaseCanvasGroup(loop)

    def __init__(self, *, title: str = "glimt", max_fps: float = 120.0, keys: Sequence[dict[str, Any]] = (),
                 size: tuple[float, float] = (640, 480)) -> None:
        super().__init__(size=size, title=title, max_fps=max_fps)
        self.keys = list(keys)
        self.title = title
        self.is_fullscreen = False
        """Whether the page fills the screen, as it last said."""
        self.should_stop = False
        self._is_closed = False
        self._cursor = "default"
        self._pointer_captured = False
        self._visitors: list[Visitor] = []  # the first one steers
        self._held = Held()
        self._draw_wanted = False
        self._frame: Frame | None = None
        self._picture: NDArray[np.uint8] | None = None
        self._rest: asyncio.TimerHandle | None = None
        self._encoder = ThreadPoolExecutor(1, "encoder")
        self._final_canvas_init()

    # ---- visitors

    def count_visitors(self) -> int:
        """Return how many pages are connected."""
        return len(self._visitors)

    def join(self, visitor: Visitor) -> None:
        """Let `visitor` steer if nobody does, else watch."""
        self._visitors.append(visitor)
        visitor.post({"type": "title", "value": self.title})
        visitor.post({"type": "cursor", "value": self._cursor})
        visitor.post({"type": "active", "value": visitor is self._visitors[0]})
        visitor.show(self._frame)

    def leave(self, visitor: Visitor) -> None:
        """Forget `visitor`; the next one takes over if it has steered."""
        steered = visitor is self._visitors[0]
        self._visitors.remove(visitor)
        if not steered or self._is_closed:
            return
        self._let_go()
        self.is_fullscreen = False
        if self._visitors:
            self._visitors[0].post({"type": "active", "value": True})
            self._resize(self._visitors[0])

    def receive(self, visitor: Visitor, text: str) -> None:
        """Take a message from `visitor`: its size, a frame it has shown, an event. Anything else is ignored."""
        message = parse_message(text)
        kind = message.get("type")
        steers = bool(self._visitors) and visitor is self._visitors[0]
        if kind == "_framefeedback":
            visitor.confirm(int(parse_number(message.get("index"), 1e15) or 0))
        elif kind == "resize":
            visitor.size = parse_size(message) or visitor.size
            visitor.show(self._frame)
            if steers:
                self._resize(visitor)
        elif kind == "fullscreen" and steers:
            self.is_fullscreen = message.get("value") is True
        elif steers and (event := parse_event(message)):
            self._held.note(event)
            self.submit_event(event)
            self._process_events()
            return
        self._draw_if_wanted()

    def _resize(self, visitor: Visitor) -> None:
        if visitor.size:
            self._size_info.set_physical_size(*visitor.size)
            self._process_events()
            self.request_draw()

    def _let_go(self) -> None:
        """Send what would have come if whoever steered had let go of everything."""
        escape = ({"event_type": kind, "key": "Escape", "modifiers": ()} for kind in ("key_down", "key_up"))
        for event in [*(escape if self._pointer_captured else ()), *self._held.release()]:
            self.submit_event(event)
        self._pointer_captured = False
        self._process_events()

    # ---- what the viewer may ask of the page

    def set_pointer_captured(self, captured: bool) -> None:
        """Hide the pointer and let it move without end, or give it back.

        Browsers allow it only on a click or key, so it may begin with the next one. When the page loses the pointer by
        itself, by Esc or another window, "Escape" is pressed: call this with False then.
        """
        self._pointer_captured = captured
        self._ask("pointer_lock", captured)

    def set_fullscreen(self, fullscreen: bool) -> None:
        """Fill the screen, with the next click or key at the latest, or leave it."""
        self._ask("fullscreen", fullscreen)

    def offer_file(self, name: str, data: bytes, mimetype: str) -> None:
        """Let the browser of whoever steers save `data` as a file, as after a click on a link.

        Raises
        ------
        GlimtError
            It is larger than `MAX_FILE_SIZE`, nobody is there, or the file before it is still on its way.
        """
        if len(data) > MAX_FILE_SIZE:
            raise GlimtError(f"{name}: {len(data) >> 20} MB is too much for the page, which takes "
                             f"{MAX_FILE_SIZE >> 20} MB: save a smaller picture")
        if not self._visitors:
            raise GlimtError(f"{name}: no browser is connected that could save it: open the page first")
        if self._visitors[0].has_file_waiting():
            raise GlimtError(f"{name}: the file before it is still on its way: try again in a moment")
        self._visitors[0].post({"type": "file", "name": name, "mimetype": mimetype, "nbuffers": 1}, data)

    def stop(self) -> None:
        """End the server, from any thread or a signal's handler."""
        self.should_stop = True

    def _ask(self, kind: str, value: object) -> None:
        if self._visitors:
            self._visitors[0].post({"type": kind, "value": value})

    def _tell_all(self, kind: str, value: object) -> None:
        for visitor in self._visitors:
            visitor.post({"type": kind, "value": value})

    # ---- frames

    def _draw_if_wanted(self) -> None:
        if self._draw_wanted and any(visitor.wants_frame() for visitor in self._visitors):
            self._draw_wanted = False
            self._time_to_draw()

    def _show(self, data: bytes) -> None:
        self._frame = Frame(self._frame.number + 1 if self._frame else 1, data)
        for visitor in self._visitors:
            visitor.show(self._frame)

    def _refine(self, picture: NDArray[np.uint8]) -> None:
        """Send the last picture again, without visible loss; in another thread, for a large one takes long."""
        encoded = asyncio.get_running_loop().run_in_executor(self._encoder, encode_jpeg, picture, True)

        def show(_: object) -> None:
            if picture is self._picture and not self._is_closed:
                self._show(encoded.result())

        encoded.add_done_callback(show)

    # ---- what a backend of rendercanvas has to have

    def _rc_get_present_info(self, present_methods: list[str]) -> dict[str, Any] | None:
        return {"method": "bitmap", "formats": ["rgba-u8"]} if "bitmap" in present_methods else None

    def _rc_request_draw(self) -> None:
        self._draw_wanted = True
        self._draw_if_wanted()

    def _rc_request_paint(self) -> None:
        pass  # `_rc_present_bitmap` has shown the picture

    def _rc_force_paint(self) -> None:
        pass

    def _rc_present_bitmap(self, *, data: NDArray[np.uint8], format: str, **_: Any) -> None:
        if self._rest:
            self._rest.cancel()
        # A copy, 0.25 ms for 1280×720: whoever drew may go on in the same array.
        self._picture = np.array(data, order="C")
        # Here and now, 2.8 ms: measured, another thread gives neither more frames nor a shorter delay.
        self._show(encode_jpeg(self._picture, False))
        self._rest = asyncio.get_running_loop().call_later(_REST_DELAY, self._refine, self._picture)

    def _rc_set_logical_size(self, width: float, height: float) -> None:
        if not self._visitors:  # a page fills its window
            self._size_info.set_physical_size(round(width), round(height), 1)

    def _rc_set_title(self, title: str) -> None:
        self.title = title
        self._tell_all("title", title)

    def _rc_set_cursor(self, cursor: str) -> None:
        self._cursor = cursor
        self._tell_all("cursor", cursor)

    def _rc_close(self) -> None:
        if not self._is_closed:
            self._is_closed = self.should_stop = True
            if self._rest:
                self._rest.cancel()
            self._encoder.shutdown(wait=False)

    def _rc_get_closed(self) -> bool:
        return self._is_closed
