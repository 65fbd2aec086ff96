"""Visitors of the viewer's server that are no browsers."""

import asyncio
import contextlib
import http.client
import json
import socket

import websockets

SIZE = {"type": "resize", "pwidth": 320, "pheight": 200, "ratio": 1}


class Client:
    """A visitor that is no browser."""

    def __init__(self, ws):
        self.ws = ws
        self.messages = []
        self.frames = []

    async def send(self, message=None, **fields):
        await self.ws.send(message if isinstance(message, str | bytes) else json.dumps({**(message or {}), **fields}))

    async def key(self, key, kind="key_down"):
        await self.send(type=kind, key=key, modifiers=[])

    async def read(self):
        """Take one message, and the bytes that belong to it."""
        message = json.loads(await self.ws.recv())
        if "nbuffers" in message:
            message["data"] = await self.ws.recv()
        (self.frames if message["type"] == "framebufferdata" else self.messages).append(message)
        return message

    async def wait_for(self, kind, **fields):
        async with asyncio.timeout(10):
            while not {"type": kind, **fields}.items() <= (message := await self.read()).items():
                pass
        return message

    async def confirm(self):
        await self.send(type="_framefeedback", index=self.frames[-1]["index"], timestamp=0)

    async def drain(self, seconds=0.3):
        """Take what comes for a while, and confirm nothing."""
        try:
            async with asyncio.timeout(seconds):
                while True:
                    await self.read()
        except TimeoutError:
            pass


@contextlib.asynccontextmanager
async def visit(host, **options):
    where = host.url.replace("http", "ws", 1)
    query = where.partition("?")[2]
    url = f"ws://127.0.0.1:{host.port}/ws" + (f"?{query}" if query else "")
    options = {"origin": f"http://127.0.0.1:{host.port}", "compression": None, "max_size": None, **options}
    async with websockets.connect(url, **options) as ws:
        yield Client(ws)


def get(host, path, method="GET", **headers):
    connection = http.client.HTTPConnection("127.0.0.1", host.port, timeout=10)
    try:
        connection.request(method, path, headers=headers)
        response = connection.getresponse()
        return response.status, response.getheader("content-type"), response.read()
    finally:
        connection.close()


async def answers_still(host):
    """Whether a new visitor is served."""
    async with visit(host) as client:
        await client.send(SIZE)
        await client.wait_for("framebufferdata")


def connect_raw(host):
    """Return a socket on which a websocket has just been opened."""
    raw = socket.create_connection(("127.0.0.1", host.port), timeout=10)
    raw.sendall(f"GET /ws HTTP/1.1\r\nHost: localhost:{host.port}\r\nOrigin: http://localhost:{host.port}\r\n"
                "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n".encode())
    assert raw.recv(4096).startswith(b"HTTP/1.1 101 ")
    return raw


def fill(raw):
    """Send pings, whose answers nobody reads, until the server takes no more."""
    raw.settimeout(0.7)
    with contextlib.suppress(TimeoutError):
        raw.sendall(300_000 * (b"\x89\xf8\0\0\0\0" + bytes(120)))
