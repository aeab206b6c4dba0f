"""Callbacks by which long work reports how far it is."""

from collections.abc import Callable
from typing import TypeAlias

StatusCallback: TypeAlias = Callable[[str], None]
"""Called with one line that says what is being done."""

ProgressCallback: TypeAlias = Callable[[str, int, int], None]
"""Called with what is being done, how much of it is done, and of how much (0: unknown)."""


def ignore_status(*_: object) -> None:
    """Drop a report."""
