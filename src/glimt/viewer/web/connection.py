"""Uvicorn's websocket protocol, with an end to what it leaves without one."""

from typing import Any

from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

_MAX_FRAGMENTS = 1024


class BoundedWebSocket(WebSocketsSansIOProtocol):
    """A connection that is cut when its client is silent, and read no faster than it is written."""

    def keepalive_timeout(self) -> None:
        """Cut the connection at once: closing it would first wait until all is sent, to one who does not read."""
        super().keepalive_timeout()
        self.transport.abort()

    def pause_writing(self) -> None:
        """Stop reading as well: each ping is answered, and answers that nobody reads would pile up."""
        super().pause_writing()
        self.transport.pause_reading()

    def resume_writing(self) -> None:
        """Read again, unless a message still waits for the application."""
        super().resume_writing()
        if not self.read_paused:
            self.transport.resume_reading()

    def handle_cont(self, event: Any) -> None:
        """Refuse a message in too many parts: the limit on its size does not count empty ones."""
        if len(self.frames) >= _MAX_FRAGMENTS:
            self.transport.abort()
            return
        super().handle_cont(event)
