"""The server: on this machine's own addresses, one page, one socket.

An unused socket is closed, more than a page needs are not accepted, and what is
served is the front as it was built, nothing of the disk besides.
"""

import asyncio
import secrets
import socket
from collections.abc import Callable, Mapping
from contextlib import suppress
from importlib.resources import files
from typing import Any
from weakref import WeakSet

from cardan.core.errors import CardanError, MissingDependencyError
from cardan.web.security import WEBSOCKET_SUBPROTOCOL, RequestGuard
from cardan.web.session import MAX_MESSAGE_BYTES, InvalidMessageError, Session
from cardan.web.worker_pool import PATIENT_ANSWER_TIMEOUT_S, WorkerQueue, WorkerQueues
from cardan.web.workspace import Workspace

LOOPBACK_ADDRESSES = ((socket.AF_INET, "127.0.0.1"), (socket.AF_INET6, "::1"))

MAX_OPEN_BROWSER_PAGES = 16
"""Sockets at a time: tabs of one person."""

MAX_CONNECTIONS = 128
"""Connections at a time: a browser has six, and some pages."""

FIRST_REQUEST_TIMEOUT_S = 10.0
"""Seconds a connection may take to send a request."""

JOB_TIMEOUT_S = 600.0
"""Seconds a job may take: a search, a map, a report."""

MEDIA_TYPES = {
    ".html": "text/html; charset=utf-8", ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8", ".svg": "image/svg+xml", ".png": "image/png",
}  # fmt: skip


def static_files() -> dict[str, tuple[bytes, str]]:
    """Return the built front by path: contents and media type.

    Raises
    ------
    MissingDependencyError
        If it has not been built.
    """
    folder = files("cardan.web").joinpath("static")
    found: dict[str, tuple[bytes, str]] = {}
    for place, prefix in ((folder, "/"), (folder.joinpath("assets"), "/assets/")):
        if place.is_dir():
            for entry in place.iterdir():
                kind = MEDIA_TYPES.get("." + entry.name.rpartition(".")[2])
                if entry.is_file() and kind:
                    found[prefix + entry.name] = entry.read_bytes(), kind
    if "/index.html" not in found:
        msg = (
            "the workbench's page is not built: `make serve` builds it where Node is installed; "
            "a released package contains it"
        )
        raise MissingDependencyError(msg)
    found["/"] = found["/index.html"]
    return found


def listening_sockets(port: int) -> list[socket.socket]:
    """Return listening sockets on this machine's own addresses, of one port; 0 is any.

    Raises
    ------
    CardanError
        If the port is taken.
    """
    for _ in range(8):
        opened: list[socket.socket] = []
        wanted = port
        try:
            for family, address in LOOPBACK_ADDRESSES:
                found = _bind(family, address, wanted)
                if found is not None:
                    opened.append(found)
                    wanted = found.getsockname()[1]
        except OSError as error:
            for one in opened:
                one.close()
            if port:
                msg = f"port {port} cannot be used: {error.strerror or error}; choose another"
                raise CardanError(msg) from None
            continue  # free on one address, taken on the other
        if opened:
            return opened
        break
    msg = "no port of this machine can be listened on"
    raise CardanError(msg)


def _bind(family: int, address: str, port: int) -> socket.socket | None:
    """Return a socket; None where the machine does not have such addresses."""
    try:
        one = socket.socket(family, socket.SOCK_STREAM)
    except OSError:
        return None
    try:
        if family == socket.AF_INET6:
            one.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
        # Windows lets two listen where the other option is set.
        alone = getattr(socket, "SO_EXCLUSIVEADDRUSE", socket.SO_REUSEADDR)
        one.setsockopt(socket.SOL_SOCKET, alone, 1)
        try:
            one.bind((address, port))
        except OSError:
            if family == socket.AF_INET6 and not has_ipv6():
                one.close()
                return None
            raise
        one.listen(64)
    except OSError:
        one.close()
        raise
    return one


def has_ipv6() -> bool:
    """Return whether this machine has an address of the newer kind."""
    with suppress(OSError), socket.socket(socket.AF_INET6, socket.SOCK_STREAM) as one:
        one.bind(("::1", 0))
        return True
    return False


class WorkbenchApp:
    """A running workbench: files in the workspace, four worker processes, one page."""

    def __init__(
        self, desk: Workspace, *, port: int, built: Mapping[str, tuple[bytes, str]] | None = None
    ) -> None:
        self.workspace, self.port = desk, port
        self.built = static_files() if built is None else built
        self.token = secrets.token_urlsafe(24)
        self.workers = WorkerQueues(
            quick=WorkerQueue(),
            limits=WorkerQueue(),
            slow=WorkerQueue(PATIENT_ANSWER_TIMEOUT_S, patient=True),
            jobs=WorkerQueue(JOB_TIMEOUT_S, patient=True),
            view_jobs=WorkerQueue(JOB_TIMEOUT_S, patient=True),
        )
        self.open_pages = 0
        self.transports: WeakSet[Any] = WeakSet()
        self.server: Any = None
        self.app = RequestGuard(self._application(), token=self.token, port=port)

    @property
    def address(self) -> str:
        """Where the page is; the token stands behind #, which browsers never send."""
        return f"http://127.0.0.1:{self.port}/#{self.token}"

    @property
    def one_time_address(self) -> str:
        """Where a browser is sent: every user of this machine can see what it is started with."""
        return f"http://127.0.0.1:{self.port}/#{self.app.one_time_code()}"

    def _application(self) -> Any:
        from starlette.applications import Starlette
        from starlette.responses import Response
        from starlette.routing import Route, WebSocketRoute
        from starlette.websockets import WebSocket, WebSocketDisconnect

        async def page(request: Any) -> Response:
            found = self.built.get(request.url.path)
            if found is None:
                return Response("there is no such page\n", 404, media_type="text/plain")
            return Response(found[0], media_type=found[1])

        async def ask(ws: WebSocket) -> None:
            if self.open_pages >= MAX_OPEN_BROWSER_PAGES:
                await ws.close(1013)
                return
            self.open_pages += 1
            try:
                await ws.accept(subprotocol=WEBSOCKET_SUBPROTOCOL)
                await Session(ws, self.workspace, self.workers, token=self.token).run()
            except WebSocketDisconnect:
                pass
            except TimeoutError:  # it reads nothing: no goodbye would reach it
                self._abort(ws.client)
            except (InvalidMessageError, KeyError):  # a KeyError: bytes where text belongs
                with suppress(RuntimeError):
                    await ws.close(1003)
            finally:
                self.open_pages -= 1

        return Starlette(
            routes=[
                WebSocketRoute("/ask", ask),
                Route("/{path:path}", page, methods=["GET", "HEAD"]),
            ]
        )

    def _abort(self, client: Any) -> None:
        """End the connection of a client, whatever it still has to read."""
        for transport in tuple(self.transports):
            if client and transport.get_extra_info("peername")[:2] == tuple(client):
                transport.abort()

    def stop(self) -> None:
        """Serve no longer."""
        self.server.should_exit = True

    async def start(self) -> None:
        """Start what answers."""
        await asyncio.gather(self.workers.quick.start(), self.workers.slow.start())

    def close(self) -> None:
        """End what answers."""
        for lane in self.workers:
            lane.close()

    async def wait_closed(self) -> None:
        """Wait until what answers has ended."""
        await asyncio.gather(*(lane.wait_closed() for lane in self.workers))


def serve(
    house: WorkbenchApp, listening: list[socket.socket], *, ready: Callable[[], None] = lambda: None
) -> None:
    """Serve until the process is stopped; `ready` is called once it listens."""
    asyncio.run(serve_async(house, listening, ready))


async def serve_async(
    house: WorkbenchApp, listening: list[socket.socket], ready: Callable[[], None] = lambda: None
) -> None:
    """Serve, in a loop that runs already."""
    import uvicorn

    config = uvicorn.Config(
        house.app, http=_bounded_protocol(house.transports), ws="websockets-sansio", loop="asyncio",
        lifespan="off",
        log_config=None, log_level="critical", access_log=False, server_header=False,
        date_header=False, proxy_headers=False, ws_max_size=MAX_MESSAGE_BYTES,
        ws_per_message_deflate=False, ws_ping_interval=20, ws_ping_timeout=20,
        timeout_keep_alive=20, timeout_graceful_shutdown=1, h11_max_incomplete_event_size=16_384,
    )  # fmt: skip
    server = house.server = uvicorn.Server(config)
    await house.start()
    try:
        told = asyncio.get_running_loop().create_task(_call_when_started(server, ready))
        await server.serve(sockets=listening)
        told.cancel()
    finally:
        house.close()  # at once: a second Ctrl-C leaves nothing behind either
        await house.wait_closed()


async def _call_when_started(server: Any, ready: Callable[[], None]) -> None:
    while not server.started:
        await asyncio.sleep(0.01)
    ready()


def _bounded_protocol(transports: WeakSet[Any]) -> Any:
    """Return uvicorn's protocol, with an end to connections without requests, or too many."""
    from uvicorn.protocols.http.h11_impl import H11Protocol

    class Bounded(H11Protocol):
        opened = 0
        counted = False
        patience: asyncio.TimerHandle | None = None

        def connection_made(self, transport: Any) -> None:
            super().connection_made(transport)
            transports.add(transport)
            Bounded.opened += 1
            self.counted = True
            if Bounded.opened > MAX_CONNECTIONS:
                transport.abort()
            else:
                self.patience = self.loop.call_later(FIRST_REQUEST_TIMEOUT_S, transport.abort)

        def connection_lost(self, exc: Exception | None) -> None:
            self._heard()
            self._gone()
            super().connection_lost(exc)

        def data_received(self, data: bytes) -> None:
            super().data_received(data)
            if getattr(self, "cycle", None) is not None:
                self._heard()

        def handle_websocket_upgrade(self, event: Any) -> None:
            self._heard()
            self._gone()  # the socket counts itself, as a page
            super().handle_websocket_upgrade(event)

        def _heard(self) -> None:
            if self.patience:
                self.patience.cancel()

        def _gone(self) -> None:
            if self.counted:
                self.counted = False
                Bounded.opened -= 1

    return Bounded
