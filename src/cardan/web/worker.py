"""The process that answers: questions on standard input, answers on standard output.

Each is a length of four bytes and as much JSON; before an answer may go parts of it, under the
key `part`. It ends when its input is closed,
so it never outlives its parent process; what takes too long is ended from outside.
"""

import gc
import json
import os
import struct
import sys
from contextlib import suppress
from typing import Any, BinaryIO

from cardan.core.interrupts import ignore_interrupts

FRAME_LENGTH_STRUCT = struct.Struct(">I")
MAX_FRAME_BYTES = 64_000_000
"""Bytes of a question or an answer."""

PARTIAL_RESULT_KEY = "part"
"""The key of what is not the answer yet."""

MAX_MEMORY_BYTES = 4_000_000_000
"""Bytes of address space, where a process can be held to that."""

MAX_CPU_S = 1800
"""Seconds of processors that an answer may take: past them the system ends the process."""


def main() -> None:
    """Answer requests until the input ends."""
    questions, answers = _open_streams()
    _limit_resources()
    if "patient" in sys.argv[1:] and hasattr(os, "nice"):
        os.nice(10)
    from cardan.web.handlers import handle_request, referenced_file_stamps

    def write(found: dict[str, Any]) -> None:
        said = json.dumps(found, ensure_ascii=False, separators=(",", ":"))
        data = said.encode("utf-8", "surrogatepass")  # half a letter, as it came
        try:
            answers.write(FRAME_LENGTH_STRUCT.pack(len(data)) + data)
            answers.flush()
        except BrokenPipeError:  # the caller is gone
            os._exit(0)

    while (question := _read_frame(questions)) is not None:
        _extend_cpu_limit()
        try:
            found = handle_request(question, lambda part: write({PARTIAL_RESULT_KEY: part}))
            if question["job"] == "live":
                found["beside"] = referenced_file_stamps(question, found["text"])
        except MemoryError:
            found = {"fault": "MemoryError"}
        except Exception as error:  # noqa: BLE001  a fault of ours is reported, and can be retried
            import traceback

            traceback.print_exc()
            found = {"fault": type(error).__name__}
        write(found)


def _open_streams() -> tuple[BinaryIO, BinaryIO]:
    """Return the streams of questions and answers; anything else printed goes elsewhere."""
    ignore_interrupts()  # the caller ends both
    # What a check makes lasts as long as it does; see `cardan.cli.main`.
    gc.set_threshold(50_000, 20, 50)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    return sys.stdin.buffer, answers


def _limit_resources() -> None:
    with suppress(ImportError, ValueError, OSError):
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))
        _, hard = resource.getrlimit(resource.RLIMIT_AS)
        most = MAX_MEMORY_BYTES if hard == resource.RLIM_INFINITY else min(MAX_MEMORY_BYTES, hard)
        resource.setrlimit(resource.RLIMIT_AS, (most, hard))


def _extend_cpu_limit() -> None:
    """Give the next answer its seconds of processors."""
    with suppress(ImportError, ValueError, OSError):
        import resource

        used = resource.getrusage(resource.RUSAGE_SELF)
        _, hard = resource.getrlimit(resource.RLIMIT_CPU)
        most = int(used.ru_utime + used.ru_stime) + MAX_CPU_S
        resource.setrlimit(resource.RLIMIT_CPU, (most, hard))


def _read_frame(stream: BinaryIO) -> dict[str, Any] | None:
    """Return the next question; None where there is no more."""
    head = stream.read(FRAME_LENGTH_STRUCT.size)
    if len(head) < FRAME_LENGTH_STRUCT.size:
        return None
    size = FRAME_LENGTH_STRUCT.unpack(head)[0]
    data = stream.read(size)
    return json.loads(data) if len(data) == size else None


if __name__ == "__main__":
    main()
