"""Ctrl-C ends the program with exit code 130 and no traceback, whatever it is doing.

An interrupt that is raised inside an import is lost or comes out as another error: libraries
catch it, and Python drops what is raised in its own callbacks. The program ends there and then.
"""

import os
import signal
import sys
from collections.abc import Generator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any, NoReturn

EXIT_INTERRUPTED = 130


def exit_on_interrupts() -> None:
    """Let Ctrl-C end the program at once, unless it was started to ignore Ctrl-C."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, exit_at_once)
        sys.unraisablehook = _exit_on_lost_interrupt


@contextmanager
def interrupts_raised() -> Generator[None, None, None]:
    """Let Ctrl-C raise KeyboardInterrupt outside imports, where a command can report its part.

    It changes nothing in a program that `exit_on_interrupts` has not prepared.
    """
    if signal.getsignal(signal.SIGINT) is not exit_at_once:
        yield
        return
    signal.signal(signal.SIGINT, _raise_outside_imports)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, exit_at_once)


@contextmanager
def interrupts_held_back() -> Generator[None, None, None]:
    """Hold Ctrl-C back until the end, and in processes started here until `ignore_interrupts`.

    Several tasks of one thread may be in it at a time. Windows cannot hold it back: a process
    that starts may print a traceback there.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    token = object()
    _holders.add(token)
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        _holders.remove(token)
        if not _holders:
            signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})


_holders = set[object]()


def ignore_interrupts() -> None:
    """Ignore Ctrl-C in a process that is ended by its parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})


def exit_at_once(*_: object) -> NoReturn:
    """End the program without a traceback."""
    with suppress(OSError):
        os.write(2, b"\n")  # the line after the terminal's own ^C
    os._exit(EXIT_INTERRUPTED)


def _raise_outside_imports(_: int, frame: FrameType | None) -> None:
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            exit_at_once()
        frame = frame.f_back
    raise KeyboardInterrupt


def _exit_on_lost_interrupt(unraisable: Any) -> None:
    """End the program where Python would print an interrupt and go on."""
    if issubclass(unraisable.exc_type, KeyboardInterrupt):
        exit_at_once()
    sys.__unraisablehook__(unraisable)
