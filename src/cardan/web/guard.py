"""Who may ask at all: this machine's own browser, from the page that was served to it.

A page of somebody else's, in the same browser, can send requests to this machine too. Its
requests name a foreign host or origin, or say that they come from another site: they are
refused before anything is read. The token keeps out other users of this machine.
"""

import secrets
from collections.abc import Awaitable, Callable, MutableMapping
from hmac import compare_digest
from time import monotonic
from typing import Any, TypeAlias

Scope: TypeAlias = MutableMapping[str, Any]
Receive: TypeAlias = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send: TypeAlias = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App: TypeAlias = Callable[[Scope, Receive, Send], Awaitable[None]]

PROTOCOL = "cardan.1"
"""What the socket speaks; the token stands beside it, where no log and no history keeps it."""

LONGEST_TARGET = 200
"""Bytes of a path: those of the page's own files are shorter."""

HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
        "font-src 'self'; connect-src 'self'; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'; require-trusted-types-for 'script'"
    ),
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), microphone=(), geolocation=(), usb=(), serial=()",
    "Cache-Control": "no-store",
}


ONCE = 60.0
"""Seconds in which a browser that was started has to come."""


class Guard:
    """Lets through what comes from the page itself; `port` is set once it is known."""

    def __init__(self, app: App, *, token: str, port: int) -> None:
        self.app, self.token = app, token
        self._once, self._until = "", 0.0
        self.hosts = {f"{name}:{port}" for name in ("127.0.0.1", "localhost", "[::1]")}

    def once(self) -> str:
        """Return a code that lets one page in, once and soon: others see how a browser is started.

        That page is told the token.
        """
        self._once, self._until = secrets.token_urlsafe(24), monotonic() + ONCE
        return self._once

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Refuse, or pass on with the headers that every answer has."""
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
        elif scope["type"] == "websocket":
            if self._foreign(scope, socket=True) or not self._known(scope):
                await send({"type": "websocket.close", "code": 1008})  # before it opens: 403
            else:
                await self.app(scope, receive, send)
        else:
            await self._page(scope, receive, send)

    async def _page(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def guarded(message: MutableMapping[str, Any]) -> None:
            if message["type"] == "http.response.start":
                ours = [(k.lower().encode(), v.encode()) for k, v in HEADERS.items()]
                names = {k for k, _ in ours}
                rest = [h for h in message["headers"] if h[0].lower() not in names]
                message = {**message, "headers": rest + ours}
            await send(message)

        if self._foreign(scope, socket=False):
            await refuse(403, "this page is not yours to ask", guarded)
        elif scope["method"] not in ("GET", "HEAD"):
            await refuse(405, "nothing is taken here", guarded)
        elif _has_body(scope):
            await refuse(413, "nothing is taken here", guarded)
        elif len(scope["path"]) > LONGEST_TARGET or scope["query_string"]:
            await refuse(404, "there is no such page", guarded)
        else:
            await self.app(scope, receive, guarded)

    def _foreign(self, scope: Scope, *, socket: bool) -> bool:
        """Return whether a request comes from anywhere but the page, or asks another host."""
        hosts, origins = _of(scope, b"host"), _of(scope, b"origin")
        sites = _of(scope, b"sec-fetch-site")
        ours = {f"http://{host}" for host in hosts}
        return (
            len(hosts) != 1
            or hosts[0] not in self.hosts
            or any(origin not in ours for origin in origins)
            or (socket and len(origins) != 1)
            or any(site not in ("same-origin", "none") for site in sites)
        )

    def _known(self, scope: Scope) -> bool:
        """Return whether a socket brings the token, beside what it speaks."""
        spoken = [p.strip() for h in _of(scope, b"sec-websocket-protocol") for p in h.split(",")]
        if len(spoken) != 2 or spoken[0] != PROTOCOL:
            return False
        said = spoken[1].encode()
        if self._once and monotonic() < self._until and compare_digest(said, self._once.encode()):
            self._once = ""
            return True
        return compare_digest(said, self.token.encode())


async def refuse(status: int, why: str, send: Send) -> None:
    """Answer with a status and a line, and read no more."""
    body = f"{why}\n".encode()
    headers = [(b"content-type", b"text/plain; charset=utf-8"),
               (b"content-length", str(len(body)).encode()), (b"connection", b"close")]  # fmt: skip
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": body})


def _of(scope: Scope, name: bytes) -> list[str]:
    return [v.decode("latin-1") for k, v in scope["headers"] if k.lower() == name]


def _has_body(scope: Scope) -> bool:
    """Return whether a request says that it brings something."""
    return bool(_of(scope, b"transfer-encoding")) or any(
        length.strip() != "0" for length in _of(scope, b"content-length")
    )
