"""Loops compiled by numba where it is installed."""

from collections.abc import Callable, Generator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from math import prod
from typing import Any

COMPILED_MIN_CASES = 256
"""Cases (variants times states) from which on a batch takes compiled loops.

A check of one design and its corrections stay below: to import numba costs more than they do.
"""


POINT_LOOP_CASE_FACTOR = 2.5
"""How many times as many cases take loops that only place points and turn shafts.

They save less than those of a line on rubber: batches of `fix`, of some 60 variants, and what a
check varies number by number do not load a compiler for them, shards of a study do.
"""

_LOOPS_ARE_ALLOWED: ContextVar[bool] = ContextVar("loops_are_allowed", default=True)


@contextmanager
def without_compiled_loops() -> Generator[None, None, None]:
    """Have batches of any size take the NumPy text: those of a check, which come only once."""
    before = _LOOPS_ARE_ALLOWED.set(False)
    try:
        yield
    finally:
        _LOOPS_ARE_ALLOWED.reset(before)


def is_compiled_batch(cases: tuple[int, ...], *, points: float = 1) -> bool:
    """Return whether a batch is large enough for loops that numba compiles.

    `cases` are variants and states; or `points` of each too, all in one axis.
    """
    return _LOOPS_ARE_ALLOWED.get() and prod(cases) >= points * COMPILED_MIN_CASES


@cache
def compiled(
    function: Callable[..., Any], *called: Callable[..., Any]
) -> Callable[..., Any] | None:
    """Return a function compiled with those that it calls; None where numba cannot be loaded."""
    try:
        import numba  # pyright: ignore[reportMissingTypeStubs]
        from numba.extending import (  # pyright: ignore[reportMissingTypeStubs]
            register_jitable,
        )
    except (ImportError, OSError):  # or no memory is left for its libraries
        return None
    for one in called:
        register_jitable(one)
    options: dict[str, Any] = {"nogil": True, "error_model": "numpy"}
    try:
        return numba.njit(cache=True, **options)(function)
    except RuntimeError:  # no folder for the cache can be written: compiled for this run alone
        return numba.njit(**options)(function)
