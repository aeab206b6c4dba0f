"""Executors that compute shards: threads, processes, a Dask cluster."""

import logging
import os
import pickle
import shutil
from collections.abc import Callable, Generator, Mapping
from concurrent.futures import (
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
)
from contextlib import contextmanager, suppress
from importlib import import_module
from multiprocessing import get_context, parent_process
from pathlib import Path
from queue import Empty, SimpleQueue
from tempfile import NamedTemporaryFile, TemporaryDirectory
from threading import Thread
from time import monotonic
from types import TracebackType
from typing import Any
from uuid import uuid4

from cardan.core.errors import DesignError, MissingDependencyError
from cardan.core.interrupts import ignore_interrupts, interrupts_held_back
from cardan.topics.variants.shard_job import forget_shard_job, hold_shard_job

MAX_PORT = 65535

SCHEDULER_TIMEOUT_S = 30
"""s: a cluster whose scheduler has not answered by then is given up."""

WORKER_COUNT_AGE_S = 1.0
"""s: a count of workers, which the scheduler gives, holds so long."""

# --------------------------------------------------------------------------- executors


@contextmanager
def open_executor(kind: str, count: int) -> Generator[Executor | None, None, None]:
    """Give the executor of shards: `threads`, `processes`, or a Dask cluster by its address.

    Raises
    ------
    MissingDependencyError
        If a cluster is named and Dask is not there.
    DesignError
        If an address is none of a scheduler that answers within `SCHEDULER_TIMEOUT_S`, or if
        it is gone for good.
    """
    gone = "; what was done is kept where --out names a folder: --resume goes on"
    if kind == "threads":
        yield None
    elif kind == "processes":
        with ProcessExecutor(count) as pool:
            try:
                yield pool
            except BrokenExecutor as error:
                msg = f"a process that computed a shard was killed{gone}"
                raise DesignError(msg) from error
    else:
        try:
            dask: Any = import_module("distributed")
        except ModuleNotFoundError as error:
            msg = "a Dask cluster needs its package: pip install 'cardan[cluster]'"
            raise MissingDependencyError(msg) from error
        # The library prints what it meets, with its tracebacks; errors here say what matters.
        logging.disable()
        with _connected_client(dask, kind) as client:
            try:
                yield DaskExecutor(client)
            except (CancelledError, dask.KilledWorker) as error:
                msg = f"the cluster at {kind} is gone, or loses every worker{gone}"
                raise DesignError(msg) from error


def _connected_client(dask: Any, address: str) -> Any:
    """Return a client of the scheduler at an address.

    Raises
    ------
    DesignError
        If it is no address, or no scheduler answers there.
    """
    scheme, _, place = address.partition("://")
    host, _, port = place.rpartition(":")
    if not (host and port.isdecimal() and 0 < int(port) <= MAX_PORT):
        msg = (
            f"--executor {address} is no address of a Dask scheduler: give its protocol, host and "
            f"port, as tcp://host:8786"
        )
        raise DesignError(msg)
    try:
        return _call_within(
            SCHEDULER_TIMEOUT_S, lambda: dask.Client(address, timeout=SCHEDULER_TIMEOUT_S)
        )
    except (OSError, TimeoutError) as error:
        msg = (
            f"no Dask scheduler answers at {address} within {SCHEDULER_TIMEOUT_S} s: start it, or "
            f"correct --executor"
        )
        raise DesignError(msg) from error
    except Exception as error:
        if scheme == "tls":
            msg = (
                f"--executor {address} needs certificates: name them in Dask's configuration, "
                f"distributed.comm.tls ({error})"
            )
            raise DesignError(msg) from error
        msg = f"--executor {address} is no address of a Dask scheduler ({error})"
        raise DesignError(msg) from error


def _call_within(seconds: float, function: Callable[[], Any]) -> Any:
    """Return what a function returns, or raise TimeoutError if that takes longer.

    The library's own limit does not hold where another kind of server answers.
    """
    result: Future[Any] = Future()

    def call() -> None:
        try:
            result.set_result(function())
        except BaseException as error:  # noqa: BLE001  raised again where it is waited for
            result.set_exception(error)

    Thread(target=call, daemon=True).start()
    return result.result(seconds)


class DaskExecutor(Executor):
    """A Dask cluster by its client: an executor that knows how many there are to work.

    Calls go out many at a time, and come back so: that halves what each costs client and scheduler.
    """

    def __init__(self, client: Any) -> None:
        self._client, self._executor = client, client.get_executor()
        self._pending: dict[str, tuple[Any, Any]] = {}
        self._done: SimpleQueue[Any] = SimpleQueue()
        self._threads, self._counted = 0, 0.0

    @contextmanager
    def held_by_workers(self, job: bytes) -> Generator[str, None, None]:
        """Send a job once to each worker, those that come later too; give its name there."""
        name = f"cardan-{uuid4().hex}"  # another study of the same job ends when it ends
        self._client.register_plugin(_job_holder(name, job), name=name)
        try:
            yield name
        finally:
            if not self.connection_lost:
                with suppress(OSError, TimeoutError, RuntimeError):  # it may be lost just now
                    self._client.unregister_worker_plugin(name)

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Hand a call to a free worker."""
        return self._executor.submit(fn, *args, **kwargs)

    def submit_all(self, calls: Mapping[Any, Callable[[], Any]]) -> None:
        """Hand out calls to free workers, in one message.

        Raises
        ------
        CancelledError
            If the scheduler is lost; so does `finished`.
        """
        with self._cancelled_if_lost():
            futures = self._client.map(_call_to_bytes, list(calls.values()), pure=False)
        for key, future in zip(calls, futures, strict=True):
            self._pending[future.key] = key, future
            future.add_done_callback(self._done.put)

    def finished(self, timeout: float) -> list[tuple[Any, Any]]:
        """Return calls that are done, each by its key with what it returned; wait for one."""
        done: list[Any] = []
        with suppress(Empty):
            done.append(self._done.get(timeout=timeout))
            while True:
                done.append(self._done.get_nowait())
        done = [f for f in done if f.key in self._pending]  # not of calls that were cancelled
        if any(f.status == "cancelled" for f in done):
            raise CancelledError
        with self._cancelled_if_lost():
            each = self._client.gather(done)
        # Our own, from a worker of ours.
        return [
            (self._pending.pop(f.key)[0], pickle.loads(v)) for f, v in zip(done, each, strict=True)
        ]

    @property
    def pending_count(self) -> int:
        """How many calls are out."""
        return len(self._pending)

    def cancel_all(self) -> None:
        """Take back what is out."""
        futures = [future for _, future in self._pending.values()]
        self._pending.clear()
        if futures and not self.connection_lost:
            with suppress(OSError, TimeoutError, RuntimeError):  # it may be lost just now
                self._client.cancel(futures)

    @contextmanager
    def _cancelled_if_lost(self) -> Generator[None, None, None]:
        """Raise what a lost scheduler raises as `CancelledError`."""
        try:
            yield
        except Exception as error:
            if self.connection_lost:
                raise CancelledError from error
            raise

    @property
    def connection_lost(self) -> bool:
        """Whether its client gave the scheduler up."""
        return self._client.status in ("closing", "closed")

    @property
    def worker_threads(self) -> int:
        """How many threads of workers there are; 1 where the scheduler does not answer.

        Some, and not none, are counted again after `WORKER_COUNT_AGE_S`.
        """
        if not self._threads or monotonic() - self._counted > WORKER_COUNT_AGE_S:
            self._counted = monotonic()
            try:
                self._threads = sum(self._client.ncores().values())
            except (OSError, TimeoutError, RuntimeError, AttributeError):
                self._threads = 1  # its client is closed, or closing: the shards it loses show that
        return self._threads


def _call_to_bytes(call: Callable[[], Any]) -> bytes:
    """Make a call on a worker, and return what it returned as bytes.

    Dask sends each array of a result by itself: dozens a shard, which cost more than their bytes.
    """
    return pickle.dumps(call(), protocol=pickle.HIGHEST_PROTOCOL)


def _job_holder(name: str, job: bytes) -> Any:
    """Return the plugin by which workers hold a job."""
    dask: Any = import_module("distributed")

    class JobHolder(dask.WorkerPlugin):
        def setup(self, worker: Any) -> None:
            del worker
            hold_shard_job(name, job)

        def teardown(self, worker: Any) -> None:
            del worker
            forget_shard_job(name)

    return JobHolder()


class ProcessExecutor(ProcessPoolExecutor):
    """Spawned processes, each of which writes what it returns to a file and sends the file's path.

    All send through one pipe. A path goes through it whole; a process killed half-way through a
    shard would leave the reader of the pipe waiting for the rest.
    """

    def __init__(self, count: int) -> None:
        self._folder = TemporaryDirectory(prefix="cardan-", ignore_cleanup_errors=True)
        super().__init__(
            count,
            mp_context=get_context("spawn"),  # a fork of a process with threads may never wake
            initializer=_begin_worker,
            initargs=(self._folder.name,),
        )

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Hand a call to whichever process is free."""
        with interrupts_held_back():  # the first call starts the processes
            return super().submit(_call_to_file, self._folder.name, fn, args, kwargs)

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_val: BaseException | None,
        exc_tb: TracebackType | None,
    ) -> None:
        """End the processes, when they have done what they were handed."""
        super().__exit__(exc_type, exc_val, exc_tb)
        self._folder.cleanup()


class _FileResult:
    """What a call returned, in a file; unpickled it is that again, and the file is gone."""

    def __init__(self, path: str) -> None:
        self.path = path

    def __reduce__(self) -> tuple[Callable[[str], Any], tuple[str]]:
        return _load_and_delete, (self.path,)


def _call_to_file(
    folder: str, fn: Callable[..., Any], args: tuple[Any, ...], kwargs: dict[str, Any]
) -> _FileResult:
    """Call a function in a worker process and write what it returns to a file."""
    returned = fn(*args, **kwargs)
    with NamedTemporaryFile(dir=folder, delete=False) as file:
        pickle.dump(returned, file, protocol=pickle.HIGHEST_PROTOCOL)
    return _FileResult(file.name)


def _load_and_delete(path: str) -> Any:
    with Path(path).open("rb") as file:
        found = pickle.load(file)  # our own, from a folder of our own
    Path(path).unlink()
    return found


def _begin_worker(folder: str) -> None:
    """Prepare a worker process: it ignores the keyboard, and ends with its parent."""
    ignore_interrupts()
    Thread(target=_end_with_parent, args=(folder,), daemon=True).start()


def _end_with_parent(folder: str) -> None:
    parent = parent_process()
    assert parent is not None
    parent.join()
    shutil.rmtree(folder, ignore_errors=True)
    os._exit(1)
