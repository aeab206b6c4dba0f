"""What can go wrong, and what to try.

    CardanError
        DesignError                 a part or a layout that cannot exist
            OptionError             a setting of a file, refused where it has another name
        InvalidFileError            a file that cannot be read as meant: all its problems at once
        ConvergenceError            a solver stopped early
        MissingDependencyError      something optional is needed and absent

A wrong argument in code is a plain `ValueError`.
"""

from collections.abc import Callable, Generator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from cardan.core.lazy_dataclass import dataclass

if TYPE_CHECKING:  # the command line imports this before it sets NumPy's number of threads
    import numpy.typing as npt


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


class OptionError(DesignError):
    """A setting of a file, refused where it is known as an option of a command.

    `worded` puts a refusal, in any language, into the words of `file`.
    """

    def __init__(self, why: CardanError, *, file: str, worded: Callable[[str], str]) -> None:
        super().__init__(f"{file}: {worded(str(why))}")
        self.why, self.file, self.worded = why, file, worded


class ConvergenceError(CardanError):
    """A solver stopped before it had an answer worth returning."""


class MissingDependencyError(CardanError):
    """Something optional is needed and absent; the message says how to install it."""


def values_of_first_violating_case(
    kept: "npt.ArrayLike", *values: "npt.ArrayLike"
) -> tuple[float, ...] | None:
    """Return the values of the first case that a condition does not keep; None if it keeps all.

    Conditions are comparisons that nan does not pass.
    """
    if kept is True:  # of one number NumPy takes longer than all the rest
        return None
    import numpy as np

    if np.all(kept):
        return None
    spread = np.broadcast_arrays(kept, *values)
    first = np.argmin(spread[0])
    return tuple(float(v.flat[first]) for v in spread[1:])


@contextmanager
def prefix_error_address(address: str) -> Generator[None, None, None]:
    """Put an address before that of a `DesignError` raised inside: callers know where."""
    try:
        yield
    except DesignError as error:
        error.about = ".".join(filter(None, (address, error.about)))
        raise


def require_positive(part: str, **values: float | None) -> None:
    """Refuse values of a part that are not above zero; the comparison refuses nan too."""
    for name, value in values.items():
        if value is not None and (wrong := values_of_first_violating_case(value > 0, value)):
            msg = f"{name} of {part} must be above 0, got {wrong[0]:g}"
            raise DesignError(msg)


@dataclass(frozen=True, slots=True, kw_only=True)
class SourceLocation:
    """Where something stands in a file: its key, as errors print it, line and column from 1."""

    key: str
    line: int
    column: int


@dataclass(frozen=True, slots=True, kw_only=True)
class FileIssue:
    """One thing wrong in a file: where it is, what it says, what is allowed.

    `line` and `column` count from 1; 0 where the problem has no single place. A value that
    contradicts others names the `relation` that it breaks, the `source` of that relation's range,
    and the others: where each stands, and its numbers.
    """

    message: str
    key: str = ""
    value: str = ""
    hint: str = ""
    line: int = 0
    column: int = 0
    relation: str = ""
    source: str = ""
    against: tuple[tuple[SourceLocation, str], ...] = ()

    @property
    def against_text(self) -> str:
        """The values that it contradicts, with their lines; empty if there are none."""
        return ", ".join(
            f"{at.key}{f' {value}' if value else ''} (line {at.line})" for at, value in self.against
        )

    def format_with_location(self, file: str) -> str:
        """Return the problem as one line a user can click on and act on."""
        at = f"{self.line}:{self.column}" if self.column else f"{self.line}"
        place = f"{file}:{at}" if self.line else file
        key = f"{self.key}: " if self.key else ""
        value = f" (got {self.value})" if self.value else ""
        against = f"; compared with {self.against_text}" if self.against else ""
        hint = f"; {self.hint}" if self.hint else ""
        return f"{place}: {key}{self.message}{value}{against}{hint}"


class InvalidFileError(CardanError):
    """A file with problems; the message lists every one, in the order of the file."""

    def __init__(self, file: str, problems: tuple[FileIssue, ...]) -> None:
        self.file = file
        self.problems = tuple(sorted(problems, key=lambda p: (p.line, p.column)))
        super().__init__("\n".join(p.format_with_location(file) for p in self.problems))

    def __reduce__(self) -> tuple[type["InvalidFileError"], tuple[str, tuple[FileIssue, ...]]]:
        return type(self), (self.file, self.problems)
