"""Loops compiled by numba where it is installed."""

from collections.abc import Callable
from functools import cache
from typing import Any


@cache
def compiled(
    function: Callable[..., Any], *called: Callable[..., Any]
) -> Callable[..., Any] | None:
    """Return a function compiled with those that it calls; None without numba."""
    try:
        import numba  # pyright: ignore[reportMissingTypeStubs]
        from numba.extending import (  # pyright: ignore[reportMissingTypeStubs]
            register_jitable,
        )
    except ImportError:
        return None
    for one in called:
        register_jitable(one)
    options: dict[str, Any] = {"nogil": True, "error_model": "numpy"}
    try:
        return numba.njit(cache=True, **options)(function)
    except RuntimeError:  # no folder for the cache can be written: compiled for this run alone
        return numba.njit(**options)(function)
