"""A workbench on loopback for tests, in a thread or as the command, and a page that talks to it."""

import asyncio
import json
import os
import re
import subprocess
import sys
import threading
from contextlib import contextmanager
from pathlib import Path
from time import monotonic

from websockets.sync.client import connect

from cardan.web import server
from cardan.web.workspace import Workspace

ROOT = Path(__file__).parents[1]
FRONT = ROOT / "src" / "cardan" / "web" / "static" / "index.html"
"""The page, where it is built."""

BUILT = {
    "/": (b"<!doctype html>", "text/html; charset=utf-8"),
    "/assets/a.js": (b"1", "text/javascript; charset=utf-8"),
}
PATIENCE = 300.0
"""Seconds for an answer: beside two busy tests a patient worker gets a tenth of a processor."""


class Page:
    """What a page of the front does, without a browser."""

    def __init__(self, socket):
        self.socket, self.id = socket, 0

    def say(self, kind, **what):
        self.socket.send(json.dumps({"type": kind, **what}))

    def hear(self, *kinds):
        """Return the next message of some kinds; others are passed over."""
        end = monotonic() + PATIENCE
        while monotonic() < end:
            told = json.loads(self.socket.recv(timeout=PATIENCE))
            if told["type"] in kinds:
                return told
        raise TimeoutError(kinds)

    def hello(self, lang="en"):
        self.say("hello", lang=lang)
        return self.hear("welcome")

    def open(self, file=0):
        self.say("open", file=file)
        return self.hear("opened", "refused")

    def ask(self, text, **what):
        self.id += 1
        self.say("ask", id=self.id, text=text, **what)
        return self.hear("live")

    def full(self):
        return self.hear("full")


def reached(house, *, host=None, token=None, origin=True, port=None, **how):
    host = host or f"127.0.0.1:{house.port}"
    return connect(
        f"ws://127.0.0.1:{port or house.port}/ask",
        origin=f"http://{host}" if origin is True else origin,
        subprotocols=["cardan.1", token or house.token],
        max_size=None, open_timeout=PATIENCE, **how,
    )  # fmt: skip


@contextmanager
def page(house, **how):
    with reached(house, **how) as socket:
        yield Page(socket)


@contextmanager
def running(opened, drafts, *, built=BUILT):
    """Serve a file or folder from a thread of this process; yield the house."""
    listening = server.listening_sockets(0)
    house = server.WorkbenchApp(
        Workspace(opened, drafts=drafts), port=listening[0].getsockname()[1], built=built
    )
    up = threading.Event()
    loop = asyncio.new_event_loop()

    def work():
        loop.run_until_complete(server.serve_async(house, listening, up.set))
        loop.close()

    thread = threading.Thread(target=work, daemon=True)
    try:
        thread.start()
        assert up.wait(PATIENCE)
        yield house
    finally:
        house.stop()
        thread.join(PATIENCE)
        assert not thread.is_alive()


@contextmanager
def command(*arguments, state, cwd=ROOT, python=None):
    """Run `cardan serve` as a process of its own; yield it with the address it printed.

    Another `python` has a cardan of its own, and none of what this one was told.
    """
    environment = {**os.environ, "XDG_STATE_HOME": str(state), "OPENBLAS_NUM_THREADS": "1"}
    # Where no Node has built the page another stands in for it: what is asked is the process.
    whole = (
        "import sys; sys.path.insert(0, 'tests'); from workbench import BUILT;"
        "from cardan.web import server; server.static_files = lambda: BUILT;"
        "from cardan.cli import cli; cli()"
    )
    start = ["-m", "cardan"] if FRONT.is_file() else ["-c", whole]
    if python:
        start = ["-P", "-m", "cardan"]
        environment.pop("PYTHONPATH", None)
    process = subprocess.Popen(
        [python or sys.executable, *start, "serve", *map(str, arguments), "--no-browser"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment, cwd=cwd,
    )  # fmt: skip
    try:
        said = process.stdout.readline().strip()
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+/#[\w-]{20,}", said), process.stderr.read()
        yield process, said
    finally:
        process.kill()
        process.communicate()
