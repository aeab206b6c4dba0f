"""Queues of requests, each served by a process of its own, one after another.

A request made before the last one was answered takes its place: the latest value wins.
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

from cardan.core.interrupts import interrupts_held_back
from cardan.web.worker import FRAME_LENGTH_STRUCT, MAX_FRAME_BYTES, PARTIAL_RESULT_KEY

ANSWER_TIMEOUT_S = 30.0
"""Seconds an answer may take."""

PATIENT_ANSWER_TIMEOUT_S = 120.0
"""The same of a process that leaves processors to others: on a busy machine it gets few, and
after 30 s a verdict of three seconds' work was given up."""

EXIT_TIMEOUT_S = 1.0
"""Seconds in which a process that no longer answers ends by itself, or is made to."""
CPU_LIMIT_SIGNAL = getattr(signal, "SIGXCPU", nan)
"""What ends a process that has used its seconds of processors; nothing does on Windows."""

Json: TypeAlias = dict[str, Any]
AsyncPartialResultCallback: TypeAlias = Callable[[Json], Awaitable[None]]


class WorkerQueue:
    """One process, one question at a time; a patient one leaves processors to others."""

    def __init__(self, longest: float = ANSWER_TIMEOUT_S, *, patient: bool = False) -> None:
        self.timeout = longest
        self.low_priority = patient
        self._process: Process | None = None
        self._lock = asyncio.Lock()
        self._closed = False
        self._folder = ""

    async def ask(self, question: Json, tell: AsyncPartialResultCallback | None = None) -> Json:
        """Return an answer; one with a `fault` where there is none.

        `tell` receives the parts that come before it.
        """
        data = json.dumps(question, separators=(",", ":")).encode()
        if len(data) > MAX_FRAME_BYTES:
            return {"fault": "too long"}
        async with self._lock:
            if self._closed:
                return {"fault": "closed"}
            process = await self._running_process()
            try:
                return await asyncio.wait_for(self._exchange(process, data, tell), self.timeout)
            except TimeoutError:
                await self._end_process()
                return {"fault": "too slow"}
            except (OSError, asyncio.IncompleteReadError):
                if self._closed:  # it was ended: how does not matter
                    return {"fault": "closed"}
                spent = await self._end_process(by_itself=True) == -CPU_LIMIT_SIGNAL
                return {"fault": "too much work" if spent else "ended"}
            except asyncio.CancelledError:
                # Half an answer may be on its way: it would be taken for the next. The caller
                # then need not wait for a process to start.
                await self._end_process()
                if not self._closed:
                    await self._running_process()
                raise

    @property
    def pid(self) -> int | None:
        """Which process answers; None where none runs."""
        running = self._process is not None and self._process.returncode is None
        return self._process.pid if self._process and running else None

    async def start(self) -> None:
        """Start the process before the first request."""
        async with self._lock:
            if not self._closed:
                await self._running_process()

    def close(self) -> None:
        """End the process for good, whatever it is doing."""
        self._closed = True
        if self._process is not None:
            with suppress(ProcessLookupError):
                self._process.kill()

    async def wait_closed(self) -> None:
        """Wait until the process has ended."""
        if self._process is not None:
            await self._process.wait()
        self._remove_folder()

    def _remove_folder(self) -> None:
        """Throw away what a process that has ended was still at."""
        if self._folder:
            shutil.rmtree(self._folder, ignore_errors=True)
        self._folder = ""

    async def _exchange(
        self, process: Process, data: bytes, tell: AsyncPartialResultCallback | None
    ) -> Json:
        assert process.stdin
        assert process.stdout
        process.stdin.write(FRAME_LENGTH_STRUCT.pack(len(data)) + data)
        await process.stdin.drain()
        while True:
            size = FRAME_LENGTH_STRUCT.unpack(
                await process.stdout.readexactly(FRAME_LENGTH_STRUCT.size)
            )[0]
            found = json.loads(await process.stdout.readexactly(size))
            if PARTIAL_RESULT_KEY not in found:
                return found
            if tell:
                await tell(found[PARTIAL_RESULT_KEY])

    async def _running_process(self) -> Process:
        """Return the process, a new one where there is none."""
        if self._process is None or self._process.returncode is not None:
            # What it leaves half done is gone with it, wherever it was ended.
            self._remove_folder()
            with suppress(OSError):
                self._folder = tempfile.mkdtemp(prefix="cardan-")
            own = dict.fromkeys(("TMPDIR", "TEMP", "TMP"), self._folder) if self._folder else {}
            # -P: what lies in the folder it is started from is no module of ours.
            with interrupts_held_back():
                self._process = await asyncio.create_subprocess_exec(
                    sys.executable, "-P", "-m", "cardan.web.worker",
                    *(("patient",) if self.low_priority else ()),
                    stdin=PIPE, stdout=PIPE, env={**os.environ, **own, "OPENBLAS_NUM_THREADS": "1"},
                    limit=MAX_FRAME_BYTES,
                )  # fmt: skip
            if self._closed:  # meanwhile
                self.close()
        return self._process

    async def _end_process(self, *, by_itself: bool = False) -> int | None:
        """End the process; return what it ended with, its own end where that came first."""
        process, self._process = self._process, None
        if process is None:
            return None
        if by_itself:
            # A signal to one that has just ended takes its status from the waiting process.
            with suppress(TimeoutError):
                return await asyncio.wait_for(process.wait(), EXIT_TIMEOUT_S)
        with suppress(ProcessLookupError):
            process.kill()
        with suppress(Exception):
            await process.wait()
        return process.returncode


class WorkerQueues(NamedTuple):
    """What answers: each what would wait too long behind another's questions."""

    quick: WorkerQueue
    """A change, a hand's line, a slider."""
    limits: WorkerQueue
    """What a hand's move makes of the limits, while the line moves on; light jobs. It starts after
    `quick`."""
    slow: WorkerQueue
    """The verdict, and what would help."""
    jobs: WorkerQueue
    """Jobs. It starts once a page has its verdict."""
    view_jobs: WorkerQueue
    """What a view shows by itself, files listed or held side by side. It starts after the jobs."""


class LatestOnlyQueue:
    """Requests of one caller to a worker: one that is not sent yet gives way to a newer."""

    def __init__(self, lane: WorkerQueue) -> None:
        self.worker = lane
        self._next: Json | None = None
        self._waiting = asyncio.Event()

    def put(self, question: Json) -> None:
        """Send this next, in place of what waited."""
        self._next = question
        self._waiting.set()

    def clear(self) -> None:
        """Send nothing next."""
        self._next = None

    async def get(self) -> tuple[Json, Json]:
        """Return the next question with its answer."""
        while self._next is None:
            self._waiting.clear()
            await self._waiting.wait()
        question, self._next = self._next, None
        # A leaving caller leaves the process to the others: its result is dropped, not its work.
        return question, await asyncio.shield(self.worker.ask(question))
