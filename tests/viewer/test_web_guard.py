"""Who may see the viewer's page: the middleware by itself, without sockets."""

import asyncio
import socket

import pytest

from glimt.viewer.web.guard import Guard, is_loopback

TOKEN = "kY3-right_token"
LOOPBACK = "127.0.0.1"
LAN = "192.168.1.5"


async def _page(scope, receive, send):
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.accept"})
        return
    await send({"type": "http.response.start", "status": 200, "headers": [(b"content-type", b"text/html")]})
    await send({"type": "http.response.body", "body": b"page"})


def ask(host, *headers, bound=LOOPBACK, token=None, query="", method="GET", path="/", kind="http"):
    """Return the status (101 for an open websocket), headers and body that a request gets."""
    sent = []

    async def receive():
        return {"type": f"{kind}.connect"}

    async def send(message):
        sent.append(message)

    given = [(b"host", host.encode("latin-1"))] if host is not None else []
    given += [(name, value.encode("latin-1")) for name, value in headers]
    scope = {"type": kind, "method": method, "path": path, "query_string": query.encode("latin-1"), "headers": given}
    asyncio.run(Guard(_page, bound, token)(scope, receive, send))
    if kind == "websocket":
        return {"websocket.accept": 101, "websocket.close": 403}[sent[0]["type"]], {}, b""
    return sent[0]["status"], dict(sent[0]["headers"]), sent[1]["body"]


def status(*args, **options):
    return ask(*args, **options)[0]


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "::1", "127.1.2.3", "LOCALHOST"])
def test_loopback_is_known(host):
    assert is_loopback(host)


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.1.5", "example.com", "localhost.example.com", ""])
def test_what_is_not_loopback_is_known(host):
    assert not is_loopback(host)


@pytest.mark.parametrize("host", ["127.0.0.1:8000", "localhost:8000", "[::1]:8000", "LocalHost:9000", "localhost"])
def test_loopback_answers_to_its_names(host):
    assert status(host) == 200


@pytest.mark.parametrize("host", [
    "evil.example:8000", "127.0.0.1.evil.example", "192.168.1.5:8000", "0.0.0.0:8000", "", "localhost:port", "[::1",
    "evil.example@localhost", "localhost/evil", "localhost, evil.example", "local\xadhost", "localhost:99999", " "])
def test_loopback_answers_to_no_other_name(host):
    assert status(host) == 403


def test_host_is_needed_and_only_once():
    assert status(None) == 403
    assert status("localhost:8000", (b"host", "evil.example")) == 403


def test_every_address_answers_to_literals_and_the_machines_name_but_no_other():
    def known(host):
        return status(host, bound="0.0.0.0", token=TOKEN, query=f"token={TOKEN}") == 200

    assert known("192.168.1.5:8000")
    assert known("[fe80::1]:8000")
    assert known(f"{socket.gethostname()}:8000")
    assert not known("evil.example:8000")


def test_an_address_of_the_network_answers_to_itself():
    def known(host):
        return status(host, bound=LAN, token=TOKEN, query=f"token={TOKEN}") == 200

    assert known(f"{LAN}:8000")
    assert not known("192.168.1.6:8000")
    assert not known("localhost:8000")


@pytest.mark.parametrize("kind", ["http", "websocket"])
@pytest.mark.parametrize("path", ["/", "/page.js", "/keys.json", "/ws", "/../../etc/passwd", "/%2e%2e/secret", "//"])
def test_everything_needs_the_token(kind, path):
    def answer(query):
        return status(f"{LAN}:80", (b"origin", f"http://{LAN}:80"), bound=LAN, token=TOKEN, query=query, path=path,
                      kind=kind)

    assert answer(f"token={TOKEN}") == (200 if kind == "http" else 101)
    for query in ("", "token=", "token=wrong", f"token={TOKEN}x", f"token={TOKEN[:-1]}", f"Token={TOKEN}",
                  f"token=wrong&token={TOKEN}", f"token={TOKEN.upper()}", "token=%ff%fe", "token=\xff", "&a" * 99):
        assert answer(query) == 403, query


def test_the_token_may_hold_anything():
    token = "a+b&c=ü %"
    assert status("localhost", token=token, query="token=a%2Bb%26c%3D%C3%BC%20%25") == 200
    assert status("localhost", token=token, query="token=a") == 403


def test_other_sites_may_neither_load_nor_connect():
    for kind, good in (("http", 200), ("websocket", 101)):
        def answer(origin, kind=kind):
            return status("localhost:8000", (b"origin", origin), kind=kind)

        assert answer("http://localhost:8000") == good
        assert answer("https://localhost:8000") == good
        for origin in ("null", "http://evil.example", "http://localhost:9000", "http://localhost",
                       "http://localhost:8000.evil.example", "file://", "", "http://127.0.0.1:8000"):
            assert answer(origin) == 403, origin


def test_a_websocket_needs_an_origin_and_a_page_does_not():
    assert status("localhost:8000", kind="websocket") == 403
    assert status("localhost:8000", kind="http") == 200


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS", "PATCH", "TRACE", "X"])
def test_only_get_and_head(method):
    code, headers, body = ask("localhost", method=method)
    assert code == 405
    assert headers[b"allow"] == b"GET, HEAD"
    assert int(headers[b"content-length"]) == len(body)


def test_head_has_no_body_even_when_refused():
    code, headers, body = ask("evil.example", method="HEAD")
    assert (code, body) == (403, b"")
    assert int(headers[b"content-length"]) > 0


@pytest.mark.parametrize("host", ["localhost:8000", "evil.example"])
def test_security_headers_are_with_all_that_is_answered(host):
    _, headers, _ = ask(host)
    policy = headers[b"content-security-policy"].decode()
    assert "default-src 'self'" in policy
    assert "frame-ancestors 'none'" in policy
    assert "evil" not in policy
    assert headers[b"x-content-type-options"] == b"nosniff"
    assert headers[b"referrer-policy"] == b"no-referrer"
    assert ("connect-src 'self' ws://localhost:8000" in policy) == (host == "localhost:8000")


def test_a_refusal_says_nothing_of_the_token():
    _, headers, body = ask("localhost", token=TOKEN, query="token=wrong")
    assert b"wrong" not in body
    assert TOKEN.encode() not in body + b"".join(headers.values())
