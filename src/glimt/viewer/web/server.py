"""The server of a `WebCanvas`: its page, its files and its websocket, from start to end."""

import asyncio
import contextlib
import errno
import html
import json
import logging
import os
import secrets
import signal
import socket
import threading
import webbrowser
from collections.abc import Callable, Iterator
from importlib.resources import files
from urllib.parse import quote

import uvicorn

from glimt.errors import GlimtError
from glimt.viewer.web.canvas import WebCanvas, loop
from glimt.viewer.web.connection import BoundedWebSocket
from glimt.viewer.web.guard import Guard, Receive, Scope, Send, is_loopback
from glimt.viewer.web.visitor import Visitor

_MAX_VISITORS = 16
_MAX_MESSAGE = 1 << 16  # bytes; an event has some hundred
_PING = 5.0  # s between pings, and until one that is not answered ends a connection
_SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGBREAK") if hasattr(signal, name)]
_log = logging.getLogger(__name__)
_PAGE = files("glimt.viewer.web") / "page"


def serve(canvas: WebCanvas, host: str = "127.0.0.1", port: int = 0, token: str | None = None,
          open_browser: bool = False, on_ready: Callable[[str], object] | None = None) -> None:
    """Serve `canvas` until it is closed or stopped (`WebCanvas.stop`), or the process is interrupted or terminated.

    Prints nothing and returns normally in all these cases; the port is free then. Only a second signal, which comes
    while it is still ending, raises KeyboardInterrupt.

    Parameters
    ----------
    canvas : WebCanvas
    host : str
        Name or address to listen on: the default can be reached from this machine only, 0.0.0.0 from all.
    port : int
        0 is any free one.
    token : str, optional
        What addresses must end in, as `?token=…`. By default a random one, or none where only this machine can ask.
    open_browser : bool
    on_ready : callable, optional
        Called with the page's address, token and all, once it can be opened.

    Raises
    ------
    GlimtError
        The port is taken, or the host is none of this machine.
    """
    with _listen(host, port) as listener:
        address, port = listener.getsockname()[:2]
        if not token and not is_loopback(address):
            token = secrets.token_urlsafe(32)
        query = f"?token={quote(token, safe='')}" if token else ""
        url = f"http://{_reachable(host, address)}:{port}/{query}"

        def announce() -> None:
            if on_ready:
                on_ready(url)
            if open_browser:  # some of them return only when they are closed
                threading.Thread(target=webbrowser.open, args=(url,), daemon=True).start()

        app = Guard(_App(canvas, query), host, token or None)
        config = uvicorn.Config(
            app, loop="asyncio", http="h11", ws=BoundedWebSocket, lifespan="off", interface="asgi3", log_config=None,
            log_level="critical", access_log=False, proxy_headers=False, server_header=False, limit_concurrency=64,
            ws_max_size=_MAX_MESSAGE, ws_ping_interval=_PING, ws_ping_timeout=_PING, ws_per_message_deflate=False,
            timeout_graceful_shutdown=1)
        asyncio.run(_run(_Server(config, canvas, announce), listener))


async def _run(server: "_Server", listener: socket.socket) -> None:
    drawing = asyncio.create_task(loop.run_async())
    drawing_started = asyncio.Event()
    loop.call_soon(drawing_started.set)
    with _stop_on_signals(server.canvas):
        # rendercanvas takes SIGINT for itself when its loop starts, and gives it back when it ends: ours goes between.
        await drawing_started.wait()
        with _stop_on_signals(server.canvas):
            await server.serve(sockets=[listener])
        loop.stop(force=True)
        await drawing


class _App:
    """The page, its files, and a visitor for each websocket."""

    def __init__(self, canvas: WebCanvas, query: str) -> None:
        self._canvas = canvas
        self._query = query
        self._files = {f"/{name}": (mimetype, (_PAGE / name).read_bytes())
                       for name, mimetype in (("page.js", "text/javascript"), ("input.js", "text/javascript"),
                                      ("page.css", "text/css"))}
        self._template = (_PAGE / "index.html").read_text(encoding="utf-8")

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request that the guard has let through."""
        if scope["type"] == "websocket":
            await self._visit(scope, receive, send)
            return
        mimetype, body = self._find(scope["path"])
        headers = [(b"content-type", f"{mimetype}; charset=utf-8".encode()), (b"content-length", b"%d" % len(body))]
        await send({"type": "http.response.start", "status": 200 if mimetype != "text/plain" else 404,
                    "headers": headers})
        await send({"type": "http.response.body", "body": b"" if scope["method"] == "HEAD" else body})

    def _find(self, path: str) -> tuple[str, bytes]:
        """Return the media type and the content of what is at `path`. Only what is listed here can be had."""
        if path == "/":
            page = self._template.replace("$query", html.escape(self._query))
            return "text/html", page.replace("$title", html.escape(self._canvas.title)).encode()
        if path == "/keys.json":
            return "application/json", json.dumps(self._canvas.keys).encode()
        return self._files.get(path, ("text/plain", b"404: There is nothing here.\n"))

    async def _visit(self, scope: Scope, receive: Receive, send: Send) -> None:
        await receive()  # "websocket.connect"
        if scope["path"] != "/ws" or self._canvas.count_visitors() >= _MAX_VISITORS:
            await send({"type": "websocket.close"})  # before it is accepted: 403
            return
        await send({"type": "websocket.accept"})
        visitor = Visitor()
        self._canvas.join(visitor)
        try:
            await visitor.run(receive, send, lambda text: self._canvas.receive(visitor, text))
        except Exception:
            _log.exception("the connection to a page has ended with an error")
        finally:
            self._canvas.leave(visitor)


class _Server(uvicorn.Server):
    """Uvicorn's server, which ends with the canvas, and without waiting for anybody."""

    def __init__(self, config: uvicorn.Config, canvas: WebCanvas, on_started: Callable[[], None]) -> None:
        super().__init__(config)
        self.canvas = canvas
        self._on_started = on_started

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Leave signals to `_stop_on_signals`: Uvicorn's own way raises them again in the end."""
        yield

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Say when it has started."""
        await super().startup(sockets)
        self._on_started()

    async def on_tick(self, counter: int) -> bool:
        """Whether to end, asked ten times a second."""
        return await super().on_tick(counter) or self.canvas.should_stop

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Close all connections, those whose clients do not read as well."""
        await super().shutdown(sockets)
        for connection in list(self.server_state.connections):
            connection.transport.abort()


@contextlib.contextmanager
def _stop_on_signals(canvas: WebCanvas) -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(*_: object) -> None:
        if canvas.should_stop:  # for the second time: whatever it waits for
            raise KeyboardInterrupt
        canvas.stop()

    before = {number: signal.signal(number, stop) for number in _SIGNALS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _listen(host: str, port: int) -> socket.socket:
    """Return a socket that listens there, or explain why there is none."""
    if not 0 <= port < 65536:
        raise GlimtError(f"port {port}: there is none: choose one from 1024 to 65535, or 0 for any free one")
    try:
        family, kind, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM,
                                                         flags=socket.AI_PASSIVE)[0]
        # With the protocol named: asyncio sets TCP_NODELAY on no other, and each frame would wait 40 ms for an answer.
        listener = socket.socket(family, kind, socket.IPPROTO_TCP)
        try:
            if os.name == "posix":  # elsewhere it would let two listen
                listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listener.bind(address)
            listener.listen(64)
        except BaseException:
            listener.close()
            raise
    except (OSError, UnicodeError) as error:
        code = getattr(error, "errno", None)
        if code == errno.EADDRINUSE:
            raise GlimtError(f"port {port} of {host} is in use: choose another, or 0 for any free one") from error
        if code == errno.EACCES:
            raise GlimtError(f"port {port} needs an administrator: choose one from 1024 on") from error
        raise GlimtError(f"host {host!r}: cannot listen there ({error}): "
                         "use 127.0.0.1 for this machine only, 0.0.0.0 for all others too") from error
    listener.setblocking(False)
    return listener


def _reachable(host: str, address: str) -> str:
    """Return what stands for `host` in an address that works in a browser, here and, if possible, elsewhere."""
    if address in ("0.0.0.0", "::"):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe, contextlib.suppress(OSError):
            probe.connect(("192.0.2.1", 9))  # sends nothing, only chooses the interface; an address for documentation
            return str(probe.getsockname()[0])
        return "127.0.0.1"
    return f"[{host}]" if ":" in host else host
