"""Run a function in a process of its own: what breaks there breaks nothing here.

CAD kernel and mesher are libraries that can crash, run for ever or fill the memory, and take
the process with them. A report is not to die of a fillet.
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

from cardan.base.errors import CardanError, DesignError

_BEGIN = (
    "import pickle,sys; sys.path[:] = pickle.loads(bytes.fromhex(sys.argv[1])); "
    "from cardan.bracket.apart import answer; answer(sys.argv[2])"
)
_NO_ROOM = 74
"""With what a process ends that could not write down its answer: EX_IOERR of sysexits.h."""
_LOOK = 0.25  # s between looks at the memory
_STARVED = 4.0
"""Times its seconds, by the clock, that a process has whose processor others are on."""


class Crashed(CardanError):  # noqa: N818  the name is the news
    """The process ended without an answer: by a signal, for its memory, for its time."""


class Stopped(Crashed):
    """It was stopped: for its memory, for its time. Nothing in it broke."""


class Told(NamedTuple):
    """How a process ended: its answer, or what it raised."""

    answer: Any
    error: BaseException | None


def apart(
    function: Callable[..., Any],
    *args: Any,
    tell: Callable[[str], None],
    memory: float,
    seconds: float,
) -> Any:
    """Call a function of a module in a process of its own and return what it returns.

    Parameters
    ----------
    function
        Of the top of a module; its last argument is a function that is told what is being done.
    args
        Plain values, which go over as a pickle, as the answer comes back.
    tell
        Is told here what the process says there.
    memory
        Bytes it may hold; where the system tells how many it does.
    seconds
        It may take of a processor; by the clock four times that.

    Raises
    ------
    Crashed
        If it ends without an answer, with the reason.
    DesignError
        If the folder for temporary files cannot be written.
    CardanError
        What the function raised.
    """
    with _folder() as folder:
        question, reply = Path(folder, "question"), Path(folder, "reply")
        try:
            question.write_bytes(pickle.dumps((function.__module__, function.__qualname__, args)))
        except OSError as error:
            raise _no_room(folder, error.strerror) from error
        path = pickle.dumps([p or str(Path.cwd()) for p in sys.path]).hex()
        why: list[str] = []
        with subprocess.Popen(
            [sys.executable, "-c", _BEGIN, path, folder],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
            text=True, encoding="utf-8",
            env={**dict.fromkeys(("NGS_NUM_THREADS", "OPENBLAS_NUM_THREADS"), _threads()),
                 **os.environ},
        ) as child:  # fmt: skip
            watch = threading.Thread(target=_watch, args=(child, memory, seconds, why), daemon=True)
            watch.start()
            try:
                assert child.stdout is not None
                for line in child.stdout:
                    tell(line.rstrip("\n"))
                child.wait()
            finally:  # a stop from the keyboard stops it too
                if child.poll() is None:
                    child.kill()
                    child.wait()
                watch.join()
        if child.returncode == _NO_ROOM:
            raise _no_room(folder, "no room for an answer")
        if not reply.exists():
            raise Stopped(why[0]) if why else Crashed(_ending(child.returncode))
        with reply.open("rb") as stream:
            told: Told = pickle.load(stream)  # our own, from a folder of our own
    if told.error is not None:
        raise told.error
    return told.answer


def _folder() -> "tempfile.TemporaryDirectory[str]":
    try:
        return tempfile.TemporaryDirectory(prefix="cardan-", ignore_cleanup_errors=True)
    except OSError as error:
        raise _no_room(str(error.filename), error.strerror) from error


def _no_room(folder: str, why: str | None) -> DesignError:
    return DesignError(
        f"the folder for temporary files, {Path(folder).parent}, cannot be written ({why}): free "
        "it, or name another by the environment's TMPDIR"
    )


def answer(folder: str) -> None:
    """Answer the question in a folder: what the process does."""
    parent, code = os.getppid(), 1
    try:
        code = _answered(Path(folder))
    finally:
        if os.getppid() != parent:  # who asked was killed, and tidies up no more
            shutil.rmtree(folder, ignore_errors=True)
        os._exit(code)  # the kernel's own tidying up at the end has crashed before


def _answered(folder: Path) -> int:
    """Write down the answer; return with what the process is to end."""
    module, name, args = pickle.loads(Path(folder, "question").read_bytes())

    def tell(what: str) -> None:
        sys.stdout.write(what.replace("\n", " ") + "\n")
        sys.stdout.flush()

    try:
        told = Told(getattr(import_module(module), name)(*args, tell), None)
    except CardanError as error:
        told = Told(None, error)
    except OSError as error:
        if error.errno not in (errno.ENOSPC, errno.EDQUOT):
            raise
        return _NO_ROOM
    part = Path(folder, "part")
    try:
        with part.open("wb") as stream:  # not by way of bytes: an answer is large enough once
            pickle.dump(told, stream, protocol=pickle.HIGHEST_PROTOCOL)
        part.rename(Path(folder, "reply"))
    except OSError:
        return _NO_ROOM
    return 0


def _watch(child: "subprocess.Popen[str]", memory: float, seconds: float, why: list[str]) -> None:
    """Stop a process that takes too much."""
    start = time.monotonic()
    while child.poll() is None:
        gone = time.monotonic() - start
        if gone > _STARVED * seconds or min(gone, worked(child.pid)) > seconds:
            why.append(f"it took longer than {seconds / 60:.3g} minutes")
        elif (held := resident(child.pid)) > memory:
            why.append(f"it held {held / 1e9:.2g} GB of the {memory / 1e9:.2g} GB allowed")
        if why:
            child.kill()
            return
        time.sleep(_LOOK)


def resident(process: int) -> float:
    """Return the bytes of memory a process holds; 0 where the system does not say."""
    try:
        return float(
            int(Path(f"/proc/{process}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
        )
    except (OSError, ValueError, IndexError, AttributeError):
        return 0.0


def worked(process: int) -> float:
    """Return the seconds of a processor a process has had; endless where the system says none."""
    try:
        # A name in brackets, which may have spaces in it, stands before them.
        told = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
        return (int(told[11]) + int(told[12])) / os.sysconf("SC_CLK_TCK")
    except (OSError, ValueError, IndexError, AttributeError):
        return float("inf")


def _threads() -> str:
    """Return how many threads engine and BLAS may use: idle ones spin, and take from who works."""
    cores = os.cpu_count() or 1
    try:
        busy = os.getloadavg()[0]
    except (AttributeError, OSError):
        busy = 0.0
    return str(max(1, min(4, round(cores - busy))))


def _ending(code: int) -> str:
    """Return how a process ended, in words."""
    import signal

    if code < 0:
        try:
            return f"it was ended by {signal.Signals(-code).name}"
        except ValueError:
            return f"it was ended by signal {-code}"
    return f"it ended with code {code}"
