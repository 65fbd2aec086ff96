"""One browser that looks at the canvas: what it has been sent, and what waits to be."""

import asyncio
import contextlib
import json
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from glimt.viewer.web.guard import Receive, Send

_MAX_IN_FLIGHT = 2  # frames; more would only add delay
_MAX_WAITING = 64  # messages other than frames
_ALIVE_INTERVAL = 4.0  # s; a page that hears nothing for longer looks for the server anew
_MAX_MESSAGE_RATE = 1000  # a second; the page sends at most a few for each refresh of the screen
_RATE_WINDOW = 0.25  # s


@dataclass(frozen=True)
class Frame:
    """An encoded picture. Its number says which of two is newer."""

    number: int
    data: bytes


class Visitor:
    """A websocket's both directions. All that waits is bounded: the newest frame, and a few messages.

    A visitor that does not read is sent no more than fits; one that writes too fast is read more slowly.
    """

    def __init__(self) -> None:
        self.size: tuple[int, int, float] | None = None
        """Physical width and height and their ratio to logical ones, as the page last said; None until then."""
        self._frame: Frame | None = None
        self._seen = 0  # number of the last frame sent
        self._sent = self._confirmed = 0
        self._waiting: deque[tuple[str, bytes | None]] = deque()
        self._wake = asyncio.Event()
        self._has_ended = False

    def wants_frame(self) -> bool:
        """Whether a new frame would go out at once."""
        return (self.size is not None and self._sent - self._confirmed < _MAX_IN_FLIGHT
                and (self._frame is None or self._frame.number <= self._seen))

    def show(self, frame: Frame | None) -> None:
        """Send `frame` when there is room for it, unless a newer one is there by then."""
        self._frame = frame
        self._wake.set()

    def confirm(self, count: int) -> None:
        """Note that the page has shown the first `count` frames it was sent."""
        self._confirmed = max(self._confirmed, min(count, self._sent))
        self._wake.set()

    def post(self, message: dict[str, Any], data: bytes | None = None) -> None:
        """Send a message, and bytes that belong to it. A visitor too slow even for messages is sent away."""
        self._waiting.append((json.dumps(message), data))
        self._has_ended |= len(self._waiting) > _MAX_WAITING
        self._wake.set()

    def has_file_waiting(self) -> bool:
        """Whether bytes posted earlier are still waiting."""
        return any(data is not None for _, data in self._waiting)

    async def run(self, receive: Receive, send: Send, on_text: Callable[[str], None]) -> None:
        """Serve an accepted websocket until either side ends it."""
        tasks = [asyncio.create_task(self._receive_all(receive, on_text)), asyncio.create_task(self._send_all(send))]
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in tasks:
                task.cancel()
            self._waiting.clear()
        for result in await asyncio.gather(*tasks, return_exceptions=True):
            if isinstance(result, Exception):
                raise result

    async def _receive_all(self, receive: Receive, on_text: Callable[[str], None]) -> None:
        window_end, count = 0.0, 0
        while (message := await receive())["type"] == "websocket.receive":
            if text := message.get("text"):
                on_text(text)
            now = time.monotonic()
            if now > window_end:
                window_end, count = now + _RATE_WINDOW, 0
            count += 1
            # Reading later is all it takes: the rest waits in the sender's own buffers.
            await asyncio.sleep(window_end - now if count > _RATE_WINDOW * _MAX_MESSAGE_RATE else 0)

    async def _send_all(self, send: Send) -> None:
        with contextlib.suppress(OSError, RuntimeError):  # it has gone, or the server has closed it
            while not self._has_ended:
                if self._waiting:
                    text, data = self._waiting[0]
                    await send({"type": "websocket.send", "text": text})
                    if data is not None:
                        await send({"type": "websocket.send", "bytes": data})
                    self._waiting.popleft()
                elif self._frame and self._frame.number > self._seen and self._sent - self._confirmed < _MAX_IN_FLIGHT:
                    await self._send_frame(self._frame, send)
                else:
                    self._wake.clear()
                    try:
                        await asyncio.wait_for(self._wake.wait(), _ALIVE_INTERVAL)
                    except TimeoutError:
                        await send({"type": "websocket.send", "text": '{"type": "alive"}'})
            await send({"type": "websocket.close", "code": 1013})

    async def _send_frame(self, frame: Frame, send: Send) -> None:
        self._seen = frame.number
        self._sent += 1
        header = {"type": "framebufferdata", "nbuffers": 1, "mimetype": "image/jpeg", "index": self._sent,
                  "timestamp": time.time()}
        await send({"type": "websocket.send", "text": json.dumps(header)})
        await send({"type": "websocket.send", "bytes": frame.data})
