"""The viewer's server as clients meet it: who is let in, and how it ends."""

import asyncio
import json
import signal
import socket

import pytest
import websockets
from web_client import SIZE, answers_still, connect_raw, fill, get, visit
from web_host import WebHost

from glimt import GlimtError
from glimt.viewer.web.canvas import MAX_FILE_SIZE, WebCanvas
from glimt.viewer.web.server import _listen, serve


@pytest.fixture(scope="module")
def host():
    with WebHost() as host:
        yield host


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


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signals_end_it_with_clients_that_do_not_read(number):
    with WebHost("--moving", "--size", "1200x900") as host:
        async def run():
            async with visit(host) as client, visit(host):
                await client.send(SIZE)
                stuck = [socket.create_connection(("127.0.0.1", host.port)), connect_raw(host)]
                stuck[0].sendall(b"GET / HT")
                fill(stuck[1])
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


def test_it_can_be_served_again_and_leaves_signals_as_they_were(monkeypatch):
    own = lambda *_: None  # noqa: E731
    terminate = signal.signal(signal.SIGTERM, own)
    interrupt = signal.getsignal(signal.SIGINT)
    for _ in range(2):
        canvas = WebCanvas()
        opened, announced = [], []
        monkeypatch.setattr("webbrowser.open", lambda url, opened=opened, canvas=canvas: (opened.append(url),
                                                                                          canvas.stop()))
        serve(canvas, open_browser=True, on_ready=announced.append)
        assert opened == announced
        assert announced[0].startswith("http://127.0.0.1:")
        assert canvas.get_closed()
    assert signal.getsignal(signal.SIGINT) is interrupt
    assert signal.signal(signal.SIGTERM, terminate) is own


def test_its_connections_send_at_once():
    with _listen("localhost", 0) as listener:
        assert listener.proto == socket.IPPROTO_TCP  # or asyncio would not set TCP_NODELAY


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
