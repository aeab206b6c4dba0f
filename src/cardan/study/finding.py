"""What every question about an application has in common: a study, and what it finds.

A study says what it can ask, what it misses to ask it, and what it found. Its limits are
rows of the application's profile like any other, and it has no verdict of its own: that
belongs to `cardan.study.approval` alone.
"""

from collections.abc import Callable, Iterator
from typing import Generic, Protocol, TypeAlias, TypeVar

from cardan.base.frozen import dataclass
from cardan.base.part import LINE, Occasion
from cardan.base.verdict import Check, Limit, Unanswered
from cardan.model.application import Application
from cardan.quantity.quantities import QUANTITIES

Answer = TypeVar("Answer", covariant=True)

DRIVELINE, VIBRATION, BRACKET, RECORDING = "driveline", "vibration", "bracket", "recording"
"""Names of the studies; a quantity says by them which one answers it."""
SLIP = "bracket_slip_utilisation"
"""The one that only bolts whose force is known make a question."""

Tell: TypeAlias = Callable[[str, int, int], None]
"""Takes what is being done, how much of it is done, and of how much (0: nobody knows)."""


def silent(doing: str, done: int, count: int) -> None:
    """Tell nobody."""


@dataclass(frozen=True, kw_only=True)
class Finding(Generic[Answer]):
    """What a study found.

    Attributes
    ----------
    study
        Its name.
    answer
        Its own numbers, for its chapter of a report; None where it could not be asked.
    checks, unanswered
        Demands held against limits, and limits that got no number.
    doubts
        Why there is no answer, in the words of what refused.
    asked
        Whether the study was asked at all.
    refused
        Whether it was, and ended without an answer: nothing it is about is approved.
    """

    study: str
    answer: Answer | None
    checks: tuple[Check, ...] = ()
    unanswered: tuple[Unanswered, ...] = ()
    doubts: tuple[str, ...] = ()
    asked: bool = True
    refused: bool = False


class Study(Protocol[Answer]):
    """A question about an application."""

    @property
    def name(self) -> str:
        """What it is called, in files, options and reports."""
        ...

    def concerns(self, application: Application) -> bool:
        """Whether the application has what the study is about: a bracket, say."""
        ...

    def missing(self, application: Application) -> tuple[str, ...]:
        """Return what the application would have to give, by its keys; nothing if it can run."""
        ...

    def run(self, application: Application, tell: Tell = silent) -> Finding[Answer]:
        """Ask."""
        ...


def limits_of(study: str, application: Application) -> tuple[Limit, ...]:
    """Return the limits of the application's profile that a study answers.

    Without `bolts` a bracket's file says nothing that could slip, and does not miss it.
    """
    bolted = application.bracket is not None and application.bracket.bolts is not None
    return tuple(
        m
        for m in application.limits
        if QUANTITIES[m.quantity].study == study and (bolted or m.quantity != SLIP)
    )


def silence(study: str, application: Application, needs: tuple[str, ...]) -> Iterator[Unanswered]:
    """Yield what stays unanswered where a study is not asked, for want of `needs`."""
    for limit in limits_of(study, application):
        yield Unanswered(
            limit=limit,
            line=application.lines[0].line.name,
            when=Occasion("state", application.states[0].name),
            part=LINE,
            needs=needs,
        )
