"""The process that answers: questions on standard input, answers on standard output.

Each is a length of four bytes and as much JSON; before an answer may go parts of it, under the
key `part`. It ends when nobody writes to it any more,
so it never outlives who started it; what takes too long is ended from outside.
"""

import gc
import json
import os
import signal
import struct
import sys
from contextlib import suppress
from typing import Any, BinaryIO

LENGTH = struct.Struct(">I")
MOST = 64_000_000
"""Bytes of a question or an answer."""

PART = "part"
"""The key of what is not the answer yet."""

MEMORY = 4_000_000_000
"""Bytes of address space, where a process can be held to that."""

CPU = 1800
"""Seconds of processors that an answer may take: past them the system ends the process."""


def main() -> None:
    """Answer until nobody asks."""
    questions, answers = _alone()
    _limit()
    if "patient" in sys.argv[1:] and hasattr(os, "nice"):
        os.nice(10)
    from cardan.web.answer import answer, named

    def write(found: dict[str, Any]) -> None:
        said = json.dumps(found, ensure_ascii=False, separators=(",", ":"))
        data = said.encode("utf-8", "surrogatepass")  # half a letter, as it came
        try:
            answers.write(LENGTH.pack(len(data)) + data)
            answers.flush()
        except BrokenPipeError:  # who asked is gone
            os._exit(0)

    while (question := _read(questions)) is not None:
        _allow()
        try:
            found = answer(question, lambda part: write({PART: part}))
            if question["job"] == "live":
                found["beside"] = named(question, found["text"])
        except MemoryError:
            found = {"fault": "MemoryError"}
        except Exception as error:  # noqa: BLE001  a fault of ours is told, and asked about again
            import traceback

            traceback.print_exc()
            found = {"fault": type(error).__name__}
        write(found)


def _alone() -> tuple[BinaryIO, BinaryIO]:
    """Return the streams of questions and answers; whatever else is printed goes elsewhere."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # who asked ends both
    # What a check makes lasts as long as it does; see `cardan.cli.main`.
    gc.set_threshold(50_000, 20, 50)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    return sys.stdin.buffer, answers


def _limit() -> None:
    with suppress(ImportError, ValueError, OSError):
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))
        _, hard = resource.getrlimit(resource.RLIMIT_AS)
        most = MEMORY if hard == resource.RLIM_INFINITY else min(MEMORY, hard)
        resource.setrlimit(resource.RLIMIT_AS, (most, hard))


def _allow() -> None:
    """Give the next answer its seconds of processors."""
    with suppress(ImportError, ValueError, OSError):
        import resource

        used = resource.getrusage(resource.RUSAGE_SELF)
        _, hard = resource.getrlimit(resource.RLIMIT_CPU)
        most = int(used.ru_utime + used.ru_stime) + CPU
        resource.setrlimit(resource.RLIMIT_CPU, (most, hard))


def _read(stream: BinaryIO) -> dict[str, Any] | None:
    """Return the next question; None where there is no more."""
    head = stream.read(LENGTH.size)
    if len(head) < LENGTH.size:
        return None
    size = LENGTH.unpack(head)[0]
    data = stream.read(size)
    return json.loads(data) if len(data) == size else None


if __name__ == "__main__":
    main()
