"""Lanes of questions, each answered by a process of its own, one after another.

Who asks again before the last question was answered takes its place: the latest value wins.
A process that takes too long, or ends, is replaced by a new one.
"""

import asyncio
import json
import os
import shutil
import signal
import sys
import tempfile
from asyncio.subprocess import PIPE, Process
from collections.abc import Awaitable, Callable
from contextlib import suppress
from math import nan
from typing import Any, NamedTuple, TypeAlias

from cardan.web.worker import LENGTH, MOST, PART

LONGEST = 30.0
"""Seconds an answer may take."""

DYING = 1.0
"""Seconds in which a process that no longer answers ends by itself, or is made to."""
XCPU = getattr(signal, "SIGXCPU", nan)
"""What ends a process that has used its seconds of processors; nothing does on Windows."""

Json: TypeAlias = dict[str, Any]
Tell: TypeAlias = Callable[[Json], Awaitable[None]]


class Lane:
    """One process, one question at a time; a patient one leaves processors to others."""

    def __init__(self, longest: float = LONGEST, *, patient: bool = False) -> None:
        self.longest = longest
        self.patient = patient
        self._process: Process | None = None
        self._turn = asyncio.Lock()
        self._closed = False
        self._folder = ""

    async def ask(self, question: Json, tell: Tell | None = None) -> Json:
        """Return an answer; one with a `fault` where there is none.

        `tell` is told of parts that come before it.
        """
        data = json.dumps(question, separators=(",", ":")).encode()
        if len(data) > MOST:
            return {"fault": "too long"}
        async with self._turn:
            if self._closed:
                return {"fault": "closed"}
            process = await self._running()
            try:
                return await asyncio.wait_for(self._asked(process, data, tell), self.longest)
            except TimeoutError:
                await self._end()
                return {"fault": "too slow"}
            except (OSError, asyncio.IncompleteReadError):
                if self._closed:  # it was ended: nobody waits for how
                    return {"fault": "closed"}
                spent = await self._end(by_itself=True) == -XCPU
                return {"fault": "too much work" if spent else "ended"}
            except asyncio.CancelledError:
                # Half an answer may be on its way: nobody could tell it from the next. Who asks
                # next need not wait for a process to start.
                await self._end()
                if not self._closed:
                    await self._running()
                raise

    @property
    def pid(self) -> int | None:
        """Which process answers; None where none runs."""
        running = self._process is not None and self._process.returncode is None
        return self._process.pid if self._process and running else None

    async def start(self) -> None:
        """Start the process before anybody asks."""
        async with self._turn:
            if not self._closed:
                await self._running()

    def close(self) -> None:
        """End the process for good, whatever it is doing."""
        self._closed = True
        if self._process is not None:
            with suppress(ProcessLookupError):
                self._process.kill()

    async def closed(self) -> None:
        """Wait until the process has ended."""
        if self._process is not None:
            await self._process.wait()
        self._clear()

    def _clear(self) -> None:
        """Throw away what a process that has ended was still at."""
        if self._folder:
            shutil.rmtree(self._folder, ignore_errors=True)
        self._folder = ""

    async def _asked(self, process: Process, data: bytes, tell: Tell | None) -> Json:
        assert process.stdin
        assert process.stdout
        process.stdin.write(LENGTH.pack(len(data)) + data)
        await process.stdin.drain()
        while True:
            size = LENGTH.unpack(await process.stdout.readexactly(LENGTH.size))[0]
            found = json.loads(await process.stdout.readexactly(size))
            if PART not in found:
                return found
            if tell:
                await tell(found[PART])

    async def _running(self) -> Process:
        """Return the process, a new one where there is none."""
        if self._process is None or self._process.returncode is not None:
            # What it leaves half done is gone with it, wherever it was ended.
            self._clear()
            with suppress(OSError):
                self._folder = tempfile.mkdtemp(prefix="cardan-")
            own = dict.fromkeys(("TMPDIR", "TEMP", "TMP"), self._folder) if self._folder else {}
            # -P: what lies in the folder it is started from is no module of ours.
            self._process = await asyncio.create_subprocess_exec(
                sys.executable, "-P", "-m", "cardan.web.worker",
                *(("patient",) if self.patient else ()),
                stdin=PIPE, stdout=PIPE, env={**os.environ, **own, "OPENBLAS_NUM_THREADS": "1"},
                limit=MOST,
            )  # fmt: skip
            if self._closed:  # meanwhile
                self.close()
        return self._process

    async def _end(self, *, by_itself: bool = False) -> int | None:
        """End the process; return what it ended with, its own end where that came first."""
        process, self._process = self._process, None
        if process is None:
            return None
        if by_itself:
            # A signal to one that has just ended takes its status from who waits for it.
            with suppress(TimeoutError):
                return await asyncio.wait_for(process.wait(), DYING)
        with suppress(ProcessLookupError):
            process.kill()
        with suppress(Exception):
            await process.wait()
        return process.returncode


class Lanes(NamedTuple):
    """What answers: each what would wait too long behind another's questions."""

    quick: Lane
    """A change, a hand's line, a slider."""
    limits: Lane
    """What a hand's move makes of the limits, while the line moves on; light jobs. It starts after
    `quick`."""
    slow: Lane
    """The verdict, and what would help."""
    work: Lane
    """Jobs. It starts once a page has its verdict."""
    beside: Lane
    """What a view shows by itself, files listed or held side by side. It starts after `work`."""


class Latest:
    """What one asker wants of a lane: a question that is not asked yet gives way to a newer."""

    def __init__(self, lane: Lane) -> None:
        self.lane = lane
        self._next: Json | None = None
        self._waiting = asyncio.Event()

    def put(self, question: Json) -> None:
        """Ask this next, in place of what waited."""
        self._next = question
        self._waiting.set()

    def drop(self) -> None:
        """Ask nothing next."""
        self._next = None

    async def take(self) -> tuple[Json, Json]:
        """Return the next question with its answer."""
        while self._next is None:
            self._waiting.clear()
            await self._waiting.wait()
        question, self._next = self._next, None
        # Who goes leaves the process to the others: its answer is thrown away, not its work.
        return question, await asyncio.shield(self.lane.ask(question))
