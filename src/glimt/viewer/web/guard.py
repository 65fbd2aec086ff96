"""Who may see the page and steer: checked before anything else, for the page, its files and the websocket alike.

A viewer's server has three kinds of enemies. Somebody else on the network: unless it listens to this machine only,
every address needs a random token. A page of another site, in the browser of somebody who may: its `Origin` gives it
away. Such a page whose name has been made to mean this machine (DNS rebinding): its `Host` does.
"""

import hmac
import ipaddress
import socket
from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any
from urllib.parse import parse_qs, urlsplit

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

_LOOPBACK_NAMES = {"localhost", "127.0.0.1", "::1"}


def is_loopback(host: str) -> bool:
    """Whether `host`, a name or an address, is this machine as only its own programs can reach it."""
    address = _address(host)
    return address.is_loopback if address else host.lower() == "localhost"


class Guard:
    """ASGI middleware that lets only those through who may, and sends security headers with all that is answered.

    The token stays in the address, `?token=…`, for the page, its files and the websocket. A cookie would go to every
    other server on the same machine too, since cookies know no ports, and with SameSite=Strict a link in a mail would
    not open. It leaks nowhere: no `Referer`, no link leads out, nothing is logged, and it ends with the server.

    Parameters
    ----------
    app : ASGI application
    host : str
        What the server is bound to. Loopback answers to its own names only, an address of the network to itself, and
        0.0.0.0 to any address and the machine's name. The port is not compared: it says nothing about who asks, and
        one that was forwarded (`ssh -L`) has another number.
    token : str or None
        What `?token=` must be; None lets everybody in who passes the rest.
    """

    def __init__(self, app: App, host: str, token: str | None) -> None:
        self._app = app
        self._token = token
        self._any_address = bool((address := _address(host)) and address.is_unspecified)
        self._hosts = {host.lower().strip("[]")} | (_LOOPBACK_NAMES if is_loopback(host) else set())
        if self._any_address:
            name = socket.gethostname().lower()
            self._hosts |= {"localhost", name, f"{name}.local"}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer 403 or 405, or pass the request on."""
        host = _header(scope, b"host") or ""
        if refusal := self._refusal(scope, host):
            await _refuse(scope, receive, _with_headers(send, "'self'"), *refusal)
        else:
            await self._app(scope, receive, _with_headers(send, f"'self' ws://{host} wss://{host}"))

    def _refusal(self, scope: Scope, host: str) -> tuple[int, str] | None:
        if not self._knows(host):
            return 403, "This server does not go by that name."
        origin = _header(scope, b"origin")
        # Browsers always send it with a websocket, and other programs can.
        if origin is None and scope["type"] == "websocket":
            return 403, "A websocket needs an Origin header."
        if origin is not None and origin.lower() not in (f"http://{host}".lower(), f"https://{host}".lower()):
            return 403, "Pages of other sites may not use this server."
        if not self._has_token(scope):
            return 403, "Use the address that glimt has shown: it ends in ?token= and a token, new at each start."
        if scope["type"] == "http" and scope["method"] not in ("GET", "HEAD"):
            return 405, "There are only pages to get here."
        return None

    def _knows(self, host: str) -> bool:
        try:
            parts = urlsplit(f"//{host}")
            name, _ = parts.hostname, parts.port  # a port that is no number raises
        except ValueError:
            return False
        if not name or parts.netloc != host or "@" in host or not host.isascii():
            return False
        return name in self._hosts or (self._any_address and _address(name) is not None)

    def _has_token(self, scope: Scope) -> bool:
        if self._token is None:
            return True
        try:
            given = parse_qs(scope["query_string"].decode("ascii"), max_num_fields=8).get("token", [""])
        except ValueError:
            return False
        return hmac.compare_digest(given[0].encode(errors="replace"), self._token.encode())


def _header(scope: Scope, name: bytes) -> str | None:
    """Return the header `name`; two of them are as good as a wrong one."""
    values = [value for key, value in scope["headers"] if key == name]
    return ", ".join(value.decode("latin-1") for value in values) if values else None


def _address(host: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    try:
        return ipaddress.ip_address(host.strip("[]"))
    except ValueError:
        return None


def _with_headers(send: Send, connect: str) -> Send:
    policy = (f"default-src 'self'; img-src 'self' blob: data:; connect-src {connect}; base-uri 'none'; "
              "form-action 'none'; frame-ancestors 'none'; object-src 'none'")
    headers = [(b"content-security-policy", policy.encode()), (b"x-content-type-options", b"nosniff"),
               (b"referrer-policy", b"no-referrer"), (b"cross-origin-resource-policy", b"same-origin"),
               (b"cache-control", b"no-store")]

    async def send_with_headers(message: MutableMapping[str, Any]) -> None:
        if message["type"] == "http.response.start":
            message["headers"] = [*message.get("headers", ()), *headers]
        await send(message)

    return send_with_headers


async def _refuse(scope: Scope, receive: Receive, send: Send, status: int, reason: str) -> None:
    if scope["type"] == "websocket":
        await receive()  # "websocket.connect"
        await send({"type": "websocket.close"})  # before it is accepted: the server answers 403
        return
    body = f"{status}: {reason}\n".encode()
    headers = [(b"content-type", b"text/plain; charset=utf-8"), (b"content-length", b"%d" % len(body))]
    if status == 405:
        headers.append((b"allow", b"GET, HEAD"))
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": b"" if scope["method"] == "HEAD" else body})
