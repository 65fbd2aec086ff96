"""The viewer's server as clients meet it: who is let in, what they may send, and how it ends."""

import asyncio
import http.client
import json
import signal
import socket
import struct
from contextlib import asynccontextmanager

import pytest
import simplejpeg
import websockets
from web_host import WebHost

from glimt import GlimtError
from glimt.viewer.web import MAX_FILE_SIZE, WebCanvas
from glimt.viewer.web_server import serve

SIZE = {"type": "resize", "pwidth": 320, "pheight": 200, "ratio": 1}


@pytest.fixture(scope="module")
def host():
    with WebHost() as host:
        yield host


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


@asynccontextmanager
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


def test_the_page_and_its_files(host):
    code, kind, page = get(host, "/")
    assert (code, kind) == (200, "text/html; charset=utf-8")
    assert "<title>glimt — &lt;test &amp; more&gt;</title>".encode() in page
    for path, kind in (("/page.js", "text/javascript"), ("/input.js", "text/javascript"), ("/page.css", "text/css")):
        assert get(host, path)[:2] == (200, f"{kind}; charset=utf-8")
    assert json.loads(get(host, "/keys.json")[2])[0] == {"keys": ["W", "↑"], "help": "forward", "group": "Move"}
    assert get(host, "/", "HEAD")[2] == b""


@pytest.mark.parametrize("path", ["/x", "/../web.py", "/page/../../web.py", "/..%2f..%2fweb.py", "//etc/passwd", "/ws",
                                  "/page.js/", "/__init__.py", "/%00", "/" + "x" * 9000])
def test_there_is_nothing_else(host, path):
    assert get(host, path)[0] == 404


def test_strangers_are_refused(host):
    assert get(host, "/", Host="evil.example")[0] == 403
    assert get(host, "/", Origin="http://evil.example")[0] == 403
    assert get(host, "/", "POST")[0] == 405

    async def refused(**options):
        with pytest.raises(websockets.InvalidStatus) as refusal:
            async with visit(host, **options):
                pass
        return refusal.value.response.status_code

    assert asyncio.run(refused(origin="http://evil.example")) == 403
    assert asyncio.run(refused(origin=None)) == 403


def test_others_than_this_machine_need_the_token():
    with WebHost("--host", "0.0.0.0") as host:
        token = host.url.partition("/?token=")[2]
        assert len(token) >= 43
        for path in ("/", "/page.js", "/keys.json"):
            assert get(host, path)[0] == 403
            assert get(host, f"{path}?token=wrong")[0] == 403
            assert get(host, f"{path}?token={token}")[0] == 200
        assert f'src="page.js?token={token}"'.encode() in get(host, f"/?token={token}")[2]
        asyncio.run(answers_still(host))
        host.url = host.url.replace(token, "wrong")
        with pytest.raises(websockets.InvalidStatus):
            asyncio.run(answers_still(host))
        assert host.end()[1:] == (0, "")  # nothing is written anywhere, let alone the token


def test_frames_come_small_and_once_more_without_loss(host):
    async def run():
        async with visit(host) as client:
            await client.send(SIZE)
            for subsampling in ("420", "444"):
                frame = await client.wait_for("framebufferdata")
                assert simplejpeg.decode_jpeg_header(frame["data"])[:4] == (100, 160, "YCbCr", subsampling)
            await client.drain(0.5)
            assert len(client.frames) == 2

    asyncio.run(run())


def test_unknown_and_damaged_messages_are_ignored(host):
    key = {"type": "key_down", "key": "k", "modifiers": []}
    pointer = {"type": "pointer_move", "x": 1, "y": 2, "button": 0, "buttons": [], "modifiers": []}
    bad = ["", "{", "null", "[]", "7", '"text"', "[" * 30_000, "{}", '{"type": 7}', '{"type": null}', "\0", b"\xff\x00",
           '{"type": "pointer_move", "x": NaN, "y": 1}',
           '{"type": "resize", "pwidth": 1e999, "pheight": 1, "ratio": 1}',
           *('{"type": "_framefeedback", "index": ' + "9" * digits + "}" for digits in (20, 400, 5000))]
    bad += [{"type": kind} for kind in ("close", "before_draw", "animate", "char", "_clients_change", "show", "resize",
                                        "key_down", "wheel", "pointer_down", "_framefeedback", "fullscreen", "")]
    bad += [{**key, "key": value} for value in (7, None, "", "x" * 33, "\ud800", "\n", ["k"], {})]
    bad += [{**pointer, "x": value} for value in (None, "1", True, 1e300, [], {})]
    bad += [{**SIZE, name: value} for name in ("pwidth", "pheight", "ratio")
            for value in (0, -5, None, "9", True, 1e300, [])]
    bad += [{"type": "_framefeedback", "index": value} for value in (None, -1, 1e300, "1", [])]

    async def run():
        async with visit(host) as client:
            await client.send(SIZE)
            start = len(host.said)
            for message in bad:
                await client.send(message)
            await client.send(pointer, buttons=[1, 1, 9, None, {}], modifiers=[{}, "Shift", "x"], button=1e9)
            await client.key("end")
            await asyncio.to_thread(host.wait_for_event, "key_down", start, key="end")
            return [event for event in host.events(start) if event["event_type"] != "resize"]

    move, key_down = asyncio.run(run())[:2]
    assert (move["event_type"], key_down["event_type"]) == ("pointer_move", "key_down")
    assert (move["buttons"], move["modifiers"], move["button"]) == ([1], ["Shift"], 0)


def test_a_size_beyond_all_screens_is_made_smaller(host):
    async def run():
        async with visit(host) as client:
            start = len(host.said)
            await client.send({**SIZE, "pwidth": 500_000, "pheight": 250_000, "ratio": 2})
            return await asyncio.to_thread(host.wait_for_event, "resize", start)

    event = asyncio.run(run())
    assert event["width"] == pytest.approx(250_000, rel=1e-3)  # logical size stays
    assert event["width"] * event["height"] * event["pixel_ratio"] ** 2 <= 4096 ** 2


def test_a_message_too_large_ends_its_sender_only(host):
    async def run():
        async with visit(host) as other, visit(host) as client:
            await client.send("x" * 100_000)
            with pytest.raises(websockets.ConnectionClosed):
                await client.drain(5)
            await other.send(SIZE)
            await other.wait_for("framebufferdata")

    asyncio.run(run())


def test_a_flood_is_read_more_slowly_and_nothing_is_lost(host):
    async def run():
        async with visit(host) as client:
            start = len(host.said)
            for number in range(1500):
                await client.key(str(number), "key_up")
            await answers_still(host)
            await asyncio.to_thread(host.wait_for_event, "key_up", start, key="1499")
            return [event["key"] for event in host.events(start) if event["event_type"] == "key_up"]

    assert asyncio.run(run()) == [str(number) for number in range(1500)]


def test_who_does_not_read_gets_no_more_and_then_the_newest():
    async def run(host):
        async with visit(host) as fast, visit(host) as slow:
            for client in (fast, slow):
                await client.send(SIZE)
            await slow.send(type="_framefeedback", index=10**9)  # it has not been sent any
            for _ in range(20):
                await fast.wait_for("framebufferdata")
                await fast.confirm()
            await slow.drain()
            assert [frame["index"] for frame in slow.frames] == [1, 2]
            await slow.confirm()
            await slow.drain()
            assert [frame["index"] for frame in slow.frames] == [1, 2, 3, 4]
            assert slow.frames[2]["data"] not in [frame["data"] for frame in fast.frames[:15]]

    with WebHost("--moving") as host:
        asyncio.run(run(host))


def test_the_first_visitor_steers_and_the_next_takes_over(host):
    async def run():
        async with visit(host) as second_to_come:
            async with visit(host) as first:
                pass  # whoever comes and goes
            del first
            async with visit(host) as watcher:
                await second_to_come.send(SIZE)
                await watcher.wait_for("active", value=False)
                await watcher.send({**SIZE, "pwidth": 640})
                await watcher.key("ignored")
                await second_to_come.key("w")
                await second_to_come.send(type="pointer_down", x=3, y=4, button=1, buttons=[1], modifiers=[])
                await asyncio.to_thread(host.wait_for_event, "pointer_down", start)
                before = host.events(start)
                taken_over = len(host.said)
                await second_to_come.ws.close()
                await watcher.wait_for("active", value=True)
                await watcher.key("mine")
                await asyncio.to_thread(host.wait_for_event, "key_down", taken_over, key="mine")
                return before, host.events(taken_over)

    start = len(host.said)
    before, after = asyncio.run(run())
    assert "ignored" not in [event.get("key") for event in before]
    assert 640 not in [event.get("width") for event in before]
    assert [(event["event_type"], event.get("key")) for event in after] == [
        ("pointer_up", None), ("key_up", "w"), ("resize", None), ("key_down", "mine")]
    assert (after[0]["x"], after[0]["button"], after[0]["buttons"]) == (3, 1, [])
    assert after[2]["width"] == 640


def test_there_is_room_for_sixteen(host):
    async def run():
        clients = [visit(host) for _ in range(16)]
        for client in clients:
            await client.__aenter__()
        with pytest.raises(websockets.InvalidStatus):
            await answers_still(host)
        for client in clients:
            await client.__aexit__(None, None, None)
        await answers_still(host)

    asyncio.run(run())


def test_nothing_is_drawn_for_nobody():
    with WebHost("--moving") as host:
        assert host.ask()["draws"] == 0

        async def run():
            async with visit(host) as client:
                await client.drain()
                assert host.ask()["draws"] == 0  # it has not said how large it is
                await client.send(SIZE)
                await client.wait_for("framebufferdata")

        asyncio.run(run())
        host.wait_for(lambda said: host.ask()["visitors"] == 0)
        draws = host.ask()["draws"]
        assert draws > 0
        asyncio.run(asyncio.sleep(0.3))
        assert host.ask()["draws"] == draws


def test_a_visitor_that_falls_silent_is_forgotten():
    with WebHost("--ping", "0.2") as host, socket.create_connection(("127.0.0.1", host.port)) as silent:
        silent.sendall(f"GET /ws HTTP/1.1\r\nHost: localhost:{host.port}\r\nOrigin: http://localhost:{host.port}\r\n"
                       "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                       "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n".encode())
        assert silent.recv(4096).startswith(b"HTTP/1.1 101 ")
        text = b'{"type": "key_down", "key": "w"}'
        silent.sendall(struct.pack("!BB4s", 0x81, 0x80 | len(text), bytes(4)) + text)
        host.wait_for_event("key_down", key="w")
        host.wait_for_event("key_up", key="w")  # though it has sent none
        assert host.ask()["visitors"] == 0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signals_end_it_with_clients_that_do_not_read(number):
    with WebHost("--moving", "--size", "1200x900") as host:
        async def run():
            async with visit(host) as client, visit(host):
                await client.send(SIZE)
                stuck = [socket.create_connection(("127.0.0.1", host.port)) for _ in range(2)]
                stuck[0].sendall(b"GET / HT")
                await client.wait_for("framebufferdata")
                ended = await asyncio.to_thread(host.end, number)
                for connection in stuck:
                    connection.close()
                return ended

        assert asyncio.run(run())[1:] == (0, "")
        assert host.said[-2:] == [{"ended": True}, {"exit": True}]
        with socket.create_server(("127.0.0.1", host.port)):
            pass


@pytest.mark.parametrize("way", ["stop", "close"])
def test_it_ends_from_another_thread_and_with_the_canvas(way):
    async def press():
        async with visit(host) as client:
            await client.key("x")
            await client.drain(5)

    with WebHost() as host:
        if way == "stop":
            host.process.stdin.write("stop\n")
            host.process.stdin.flush()
        else:
            with pytest.raises(websockets.ConnectionClosed):
                asyncio.run(press())
        host.wait_for(lambda said: "ended" in said)
        assert host.process.wait(10) == 0


@pytest.mark.parametrize(("where", "message"), [
    ({"port": None}, "port {port} of 127.0.0.1 is in use: choose another"),
    ({"port": 70000}, "port 70000: there is none: choose one from"),
    ({"port": -1}, "port -1: there is none: choose one from"),
    ({"host": "no such host.invalid"}, "host 'no such host.invalid': cannot listen there"),
    ({"host": "192.0.2.1"}, "host '192.0.2.1': cannot listen there"),
])
def test_where_it_cannot_listen_it_says_why(where, message):
    canvas = WebCanvas()
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(GlimtError) as error:
            serve(canvas, **{name: value or port for name, value in where.items()})
    assert message.format(port=port) in str(error.value)
    canvas.close()


def test_a_file_is_offered_only_if_it_can_be_sent():
    canvas = WebCanvas()
    with pytest.raises(GlimtError, match=r"a\.png: no browser is connected"):
        canvas.offer_file("a.png", b"", "image/png")
    with pytest.raises(GlimtError, match=r"a\.png: 64 MB is too much"):
        canvas.offer_file("a.png", bytes(MAX_FILE_SIZE + 1), "image/png")
    canvas.close()
