"""What can go wrong, and what to try.

    CardanError
        DesignError       a part or a layout that cannot exist
            RefusedInFile what a file asks, refused by who knows it by other words
        BadFile           a file that cannot be read as meant: all its problems at once
        NotConverged      a solver stopped early
        NotInstalled      something optional is needed and absent

A wrong argument in code is a plain `ValueError`.
"""

from collections.abc import Callable, Generator
from contextlib import contextmanager

import numpy as np
import numpy.typing as npt

from cardan.base.frozen import dataclass


class CardanError(Exception):
    """Anything this package refuses, with a reason a user can act on."""


class DesignError(CardanError):
    """A part or a layout that cannot exist.

    `about` is the address of what is wrong, as keys of an application file have it
    (`suspension.linkage`, `states[3]`); empty where the message says it all.
    """

    def __init__(self, message: str = "", *, about: str = "") -> None:
        super().__init__(message)
        self.about = about


class RefusedInFile(DesignError):  # noqa: N818  the name says whose words they are
    """What a file asks, refused by who knows it by the options of a command.

    `worded` puts a refusal, in any language, into the words of `file`.
    """

    def __init__(self, why: CardanError, *, file: str, worded: Callable[[str], str]) -> None:
        super().__init__(f"{file}: {worded(str(why))}")
        self.why, self.file, self.worded = why, file, worded


class NotConverged(CardanError):  # noqa: N818  the name is the news
    """A solver stopped before it had an answer worth returning."""


class NotInstalled(CardanError):  # noqa: N818  the name is the news
    """Something optional is needed and absent; the message says how to install it."""


def failing(kept: npt.ArrayLike, *values: npt.ArrayLike) -> tuple[float, ...] | None:
    """Return the values of the first case that a condition does not keep; None if it keeps all.

    Conditions are comparisons that nan does not pass.
    """
    if kept is True or np.all(kept):  # of one number NumPy takes longer than all the rest
        return None
    spread = np.broadcast_arrays(kept, *values)
    first = np.argmin(spread[0])
    return tuple(float(v.flat[first]) for v in spread[1:])


@contextmanager
def about(address: str) -> Generator[None, None, None]:
    """Put an address before that of a `DesignError` raised inside: callers know where."""
    try:
        yield
    except DesignError as error:
        error.about = ".".join(filter(None, (address, error.about)))
        raise


def positive(part: str, **values: float | None) -> None:
    """Refuse values of a part that are not above zero; the comparison refuses nan too."""
    for name, value in values.items():
        if value is not None and (wrong := failing(value > 0, value)):
            msg = f"{name} of {part} must be above 0, got {wrong[0]:g}"
            raise DesignError(msg)


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """Where something stands in a file: its key, as errors print it, line and column from 1."""

    key: str
    line: int
    column: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Problem:
    """One thing wrong in a file: where it is, what it says, what is allowed.

    `line` and `column` count from 1; 0 where the problem has no single place.
    """

    message: str
    key: str = ""
    value: str = ""
    hint: str = ""
    line: int = 0
    column: int = 0

    def located(self, file: str) -> str:
        """Return the problem as one line a user can click on and act on."""
        at = f"{self.line}:{self.column}" if self.column else f"{self.line}"
        place = f"{file}:{at}" if self.line else file
        key = f"{self.key}: " if self.key else ""
        value = f" (got {self.value})" if self.value else ""
        hint = f"; {self.hint}" if self.hint else ""
        return f"{place}: {key}{self.message}{value}{hint}"


class BadFile(CardanError):  # noqa: N818  the name is the news
    """A file with problems; the message lists every one, in the order of the file."""

    def __init__(self, file: str, problems: tuple[Problem, ...]) -> None:
        self.file = file
        self.problems = tuple(sorted(problems, key=lambda p: (p.line, p.column)))
        super().__init__("\n".join(p.located(file) for p in self.problems))
