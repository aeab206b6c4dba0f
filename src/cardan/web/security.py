"""Accepted requests: only from this machine's own browser, from the page that was served to it.

A foreign page, in the same browser, can send requests to this machine too. Its
requests name a foreign host or origin, or say that they come from another site: they are
refused before anything is read. The token keeps out other users of this machine.
"""

import secrets
from collections.abc import Awaitable, Callable, MutableMapping
from hmac import compare_digest
from time import monotonic
from typing import Any, TypeAlias

AsgiScope: TypeAlias = MutableMapping[str, Any]
AsgiReceive: TypeAlias = Callable[[], Awaitable[MutableMapping[str, Any]]]
AsgiSend: TypeAlias = Callable[[MutableMapping[str, Any]], Awaitable[None]]
AsgiApp: TypeAlias = Callable[[AsgiScope, AsgiReceive, AsgiSend], Awaitable[None]]

WEBSOCKET_SUBPROTOCOL = "cardan.1"
"""What the socket speaks; the token stands next to it, where no log and no history keeps it."""

MAX_PATH_BYTES = 200
"""Bytes of a path: those of the page's own files are shorter."""

SECURITY_HEADERS = {
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


ONE_TIME_CODE_LIFETIME_S = 60.0
"""Seconds in which a browser that was started has to come."""


class RequestGuard:
    """Lets through what comes from the page itself; `port` is set once it is known."""

    def __init__(self, app: AsgiApp, *, token: str, port: int) -> None:
        self.app, self.token = app, token
        self._one_time_code, self._code_expiry = "", 0.0
        self.allowed_hosts = {f"{name}:{port}" for name in ("127.0.0.1", "localhost", "[::1]")}

    def one_time_code(self) -> str:
        """Return a code that lets one page in, once and soon: others see how a browser is started.

        That page receives the token.
        """
        self._one_time_code, self._code_expiry = (
            secrets.token_urlsafe(24),
            monotonic() + ONE_TIME_CODE_LIFETIME_S,
        )
        return self._one_time_code

    async def __call__(self, scope: AsgiScope, receive: AsgiReceive, send: AsgiSend) -> None:
        """Refuse, or pass on with the headers that every answer has."""
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
        elif scope["type"] == "websocket":
            if self._is_cross_origin(scope, socket=True) or not self._has_token(scope):
                await send({"type": "websocket.close", "code": 1008})  # before it opens: 403
            else:
                await self.app(scope, receive, send)
        else:
            await self._guard_page(scope, receive, send)

    async def _guard_page(self, scope: AsgiScope, receive: AsgiReceive, send: AsgiSend) -> None:
        async def guarded(message: MutableMapping[str, Any]) -> None:
            if message["type"] == "http.response.start":
                ours = [(k.lower().encode(), v.encode()) for k, v in SECURITY_HEADERS.items()]
                names = {k for k, _ in ours}
                rest = [h for h in message["headers"] if h[0].lower() not in names]
                message = {**message, "headers": rest + ours}
            await send(message)

        if self._is_cross_origin(scope, socket=False):
            await send_error_response(403, "this page is not yours to ask", guarded)
        elif scope["method"] not in ("GET", "HEAD"):
            await send_error_response(405, "nothing is taken here", guarded)
        elif _has_body(scope):
            await send_error_response(413, "nothing is taken here", guarded)
        elif len(scope["path"]) > MAX_PATH_BYTES or scope["query_string"]:
            await send_error_response(404, "there is no such page", guarded)
        else:
            await self.app(scope, receive, guarded)

    def _is_cross_origin(self, scope: AsgiScope, *, socket: bool) -> bool:
        """Return whether a request comes from anywhere but the page, or addresses another host."""
        hosts, origins = _header_values(scope, b"host"), _header_values(scope, b"origin")
        sites = _header_values(scope, b"sec-fetch-site")
        ours = {f"http://{host}" for host in hosts}
        return (
            len(hosts) != 1
            or hosts[0] not in self.allowed_hosts
            or any(origin not in ours for origin in origins)
            or (socket and len(origins) != 1)
            or any(site not in ("same-origin", "none") for site in sites)
        )

    def _has_token(self, scope: AsgiScope) -> bool:
        """Return whether a socket brings the token, next to its protocol."""
        spoken = [
            p.strip()
            for h in _header_values(scope, b"sec-websocket-protocol")
            for p in h.split(",")
        ]
        if len(spoken) != 2 or spoken[0] != WEBSOCKET_SUBPROTOCOL:
            return False
        said = spoken[1].encode()
        if (
            self._one_time_code
            and monotonic() < self._code_expiry
            and compare_digest(said, self._one_time_code.encode())
        ):
            self._one_time_code = ""
            return True
        return compare_digest(said, self.token.encode())


async def send_error_response(status: int, why: str, send: AsgiSend) -> None:
    """Answer with a status and a line, and read no more."""
    body = f"{why}\n".encode()
    headers = [(b"content-type", b"text/plain; charset=utf-8"),
               (b"content-length", str(len(body)).encode()), (b"connection", b"close")]  # fmt: skip
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": body})


def _header_values(scope: AsgiScope, name: bytes) -> list[str]:
    return [v.decode("latin-1") for k, v in scope["headers"] if k.lower() == name]


def _has_body(scope: AsgiScope) -> bool:
    """Return whether a request says that it brings something."""
    return bool(_header_values(scope, b"transfer-encoding")) or any(
        length.strip() != "0" for length in _header_values(scope, b"content-length")
    )
