"""Standard streams that are open, and whose reader may go: no verdict depends on the reader."""

import io
import os
import sys
from typing import Any


def open_standard_streams() -> None:
    """Open closed standard streams onto the null device; drop messages without a reader.

    A file opened later would otherwise get the number of a closed stream, and what a library
    prints there would be written into it.
    """
    for descriptor, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        try:
            os.fstat(descriptor)
        except OSError:  # the lowest free number is this one
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)  # noqa: FBT003
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(descriptor, mode, encoding="utf-8", closefd=False))
    if sys.stderr is sys.__stderr__ and not sys.stderr.isatty():
        sys.stderr = io.TextIOWrapper(
            io.BufferedWriter(_FileWithoutReader(2, "w", closefd=False)),
            encoding=sys.stderr.encoding,
            errors=sys.stderr.errors,
            line_buffering=True,
        )


class _FileWithoutReader(io.FileIO):
    """A file that takes what cannot be written: a pipe without a reader, a full disk."""

    def write(self, data: Any, /) -> int:
        """Write bytes, and return how many were taken."""
        try:
            return super().write(data)
        except OSError:
            return memoryview(data).nbytes
