"""Run a function in a child process, with limits of its memory and processor time.

Some libraries (CAD kernel, mesher, readers of damaged files) can crash, run for ever or fill the
memory. In a child process they end that process only, and the caller gets an exception.
"""

import errno
import os
import pickle
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from cardan.core.errors import CardanError, DesignError

_BEGIN = (
    "import pickle,sys; sys.path[:] = pickle.loads(bytes.fromhex(sys.argv[1])); "
    "from cardan.core.subprocess_call import run_in_child; run_in_child(sys.argv[2])"
)
_EXIT_CODE_DISK_FULL = 74
"""Exit code of a child that could not write its result: EX_IOERR of sysexits.h."""
_CHECK_INTERVAL_S = 0.05
"""s between two readings of a child's memory and time. In it, memory can grow by about 0.2 GB."""
_MAX_WALL_TIME_FACTOR = 4.0
"""Wall time allowed over processor time allowed: other processes may hold the processor."""


class ChildProcessCrashedError(CardanError):
    """The child process ended without a result: by a signal, or because it was stopped."""


class ChildProcessKilledError(ChildProcessCrashedError):
    """The child process was stopped because it exceeded a limit; nothing in it broke."""


class ChildProcessResult(NamedTuple):
    """The value that the function returned in the child process, or the error it raised."""

    value: Any
    error: BaseException | None


def call_in_subprocess(
    function: Callable[..., Any],
    *args: Any,
    tell: Callable[[str], None] | None = None,
    memory: float | None = None,
    seconds: float | None = None,
) -> Any:
    """Return what a function returns that runs in a child process, within limits.

    Starting the child takes about 0.1 s, and as long as the function's module takes to import.

    Parameters
    ----------
    function
        A function at the top level of an importable module. It is called with `args` and, as its
        last argument, with a function that sends one line of progress to `tell`.
    args
        Values that can be pickled; so must be the returned value.
    tell
        Called here with each line of progress. `None`: progress is dropped.
    memory
        Limit of the resident memory, bytes. `None`: no limit. It is read every 0.05 s, from
        /proc: on a system without it there is no limit.
    seconds
        Limit of the processor time, s; the limit of the wall time is four times that. On a system
        without /proc the limit of the wall time is `seconds`. `None`: no limit.

    Raises
    ------
    ChildProcessKilledError
        If the child exceeds a limit; the message says which.
    ChildProcessCrashedError
        If the child ends without a result; the message names the signal or exit code. An
        exception that is no `CardanError` ends the child so, with exit code 1.
    DesignError
        If the folder for temporary files cannot be written.
    CardanError
        The function's own.
    """
    with _temporary_folder() as folder:
        question, reply = Path(folder, "question"), Path(folder, "reply")
        try:
            question.write_bytes(pickle.dumps((function.__module__, function.__qualname__, args)))
        except OSError as error:
            raise _temporary_folder_error(folder, error.strerror) from error
        path = pickle.dumps([p or str(Path.cwd()) for p in sys.path]).hex()
        why: list[str] = []
        ended = threading.Event()
        with subprocess.Popen(
            [sys.executable, "-c", _BEGIN, path, folder],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
            text=True, encoding="utf-8",
            env={**dict.fromkeys(("NGS_NUM_THREADS", "OPENBLAS_NUM_THREADS"), _threads()),
                 **os.environ},
        ) as child:  # fmt: skip
            watch = threading.Thread(
                target=_stop_beyond_limits, args=(child, ended, memory, seconds, why), daemon=True
            )
            watch.start()
            try:
                assert child.stdout is not None
                for line in child.stdout:
                    if tell is not None:
                        tell(line.rstrip("\n"))
                child.wait()
            finally:  # an interrupt from the keyboard stops the child too
                if child.poll() is None:
                    child.kill()
                    child.wait()
                ended.set()
                watch.join()
        if child.returncode == _EXIT_CODE_DISK_FULL:
            raise _temporary_folder_error(folder, "no room for an answer")
        if not reply.exists():
            raise (
                ChildProcessKilledError(why[0])
                if why
                else ChildProcessCrashedError(_ending(child.returncode))
            )
        with reply.open("rb") as stream:
            told: ChildProcessResult = pickle.load(stream)  # our own, from a folder of our own
    if told.error is not None:
        raise told.error
    return told.value


def _temporary_folder() -> "tempfile.TemporaryDirectory[str]":
    try:
        return tempfile.TemporaryDirectory(prefix="cardan-", ignore_cleanup_errors=True)
    except OSError as error:
        raise _temporary_folder_error(str(error.filename), error.strerror) from error


def _temporary_folder_error(folder: str, why: str | None) -> DesignError:
    return DesignError(
        f"the folder for temporary files, {Path(folder).parent}, cannot be written ({why}): free "
        "it, or name another by the environment's TMPDIR"
    )


def run_in_child(folder: str) -> None:
    """Run the call that stands in a folder, write its result there, and end the process."""
    parent, code = os.getppid(), 1
    try:
        code = _write_result(Path(folder))
    finally:
        if os.getppid() != parent:  # the parent was killed and cannot delete the folder
            shutil.rmtree(folder, ignore_errors=True)
        os._exit(code)  # the CAD kernel's own clean-up at exit has crashed before


def _write_result(folder: Path) -> int:
    """Run the call, write its result, and return the exit code."""
    module, name, args = pickle.loads(Path(folder, "question").read_bytes())

    def tell(what: str) -> None:
        sys.stdout.write(what.replace("\n", " ") + "\n")
        sys.stdout.flush()

    try:
        told = ChildProcessResult(getattr(import_module(module), name)(*args, tell), None)
    except CardanError as error:
        told = ChildProcessResult(None, error)
    except OSError as error:
        if error.errno not in (errno.ENOSPC, errno.EDQUOT):
            raise
        return _EXIT_CODE_DISK_FULL
    part = Path(folder, "part")
    try:
        with part.open("wb") as stream:  # straight to the file: results can be large
            pickle.dump(told, stream, protocol=pickle.HIGHEST_PROTOCOL)
        part.rename(Path(folder, "reply"))
    except OSError:
        return _EXIT_CODE_DISK_FULL
    return 0


def _stop_beyond_limits(
    child: "subprocess.Popen[str]",
    ended: threading.Event,
    memory: float | None,
    seconds: float | None,
    why: list[str],
) -> None:
    """Stop a child process that exceeds a limit, and add the reason to `why`."""
    start = time.monotonic()
    while not ended.wait(_CHECK_INTERVAL_S):
        if seconds is not None:
            gone = time.monotonic() - start
            if (
                gone > _MAX_WALL_TIME_FACTOR * seconds
                or min(gone, cpu_seconds(child.pid)) > seconds
            ):
                why.append(f"it took longer than {seconds / 60:.3g} minutes")
        if memory is not None and not why and (held := resident_memory_bytes(child.pid)) > memory:
            why.append(f"it held {held / 1e9:.2g} GB of the {memory / 1e9:.2g} GB allowed")
        if why:
            child.kill()
            return


def resident_memory_bytes(process: int) -> float:
    """Return the resident memory of a process in bytes; 0 if the system does not report it."""
    try:
        return float(
            int(Path(f"/proc/{process}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
        )
    except (OSError, ValueError, IndexError, AttributeError):
        return 0.0


def cpu_seconds(process: int) -> float:
    """Return the processor time of a process in s; infinite if the system does not report it."""
    try:
        # A name in brackets, which may have spaces in it, stands before them.
        told = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
        return (int(told[11]) + int(told[12])) / os.sysconf("SC_CLK_TCK")
    except (OSError, ValueError, IndexError, AttributeError):
        return float("inf")


def _threads() -> str:
    """Return how many threads NGSolve and BLAS may use: idle ones spin and slow other processes."""
    cores = os.cpu_count() or 1
    try:
        busy = os.getloadavg()[0]
    except (AttributeError, OSError):
        busy = 0.0
    return str(max(1, min(4, round(cores - busy))))


def _ending(code: int) -> str:
    """Return how a process ended, as a sentence."""
    import signal

    if code < 0:
        try:
            return f"it was ended by {signal.Signals(-code).name}"
        except ValueError:
            return f"it was ended by signal {-code}"
    return f"it ended with code {code}"
