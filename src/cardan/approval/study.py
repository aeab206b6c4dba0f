"""What every question about an application has in common: a study, and what it finds.

A study says what it can evaluate, what it lacks for it, and what it found. Its limits are
rows of the application's profile like any other, and it has no verdict of its own: that
belongs to `cardan.approval.approval` alone.
"""

from collections.abc import Callable, Iterator
from importlib import import_module
from typing import Any, Generic, Protocol, TypeVar

from cardan.application.quantity_lookup import declared_quantity
from cardan.core.labels import WHOLE_LINE, EvaluationCondition
from cardan.core.lazy_dataclass import dataclass
from cardan.core.status import ProgressCallback, ignore_status
from cardan.core.verdict import Check, Limit, UnevaluatedCheck
from cardan.model.application import Application

Answer = TypeVar("Answer", covariant=True)

DRIVELINE_STUDY_NAME, VIBRATION_STUDY_NAME, BRACKET_STUDY_NAME, RECORDING_STUDY_NAME = (
    "driveline",
    "vibration",
    "bracket",
    "recording",
)
"""Names of the studies; a quantity says by them which one answers it."""
BOLT_SLIP_QUANTITY = "bracket_slip_utilisation"
"""The one that only bolts whose force is known make a question."""


@dataclass(frozen=True, kw_only=True)
class StudyResult(Generic[Answer]):
    """What a study found.

    Attributes
    ----------
    study
        Its name.
    answer
        Its own results, for its chapter of a report; None if it could not run.
    checks, unevaluated
        Values compared with limits, and limits that got no number.
    failure_reasons
        Why there is no result, in the words of what refused.
    was_run
        Whether the study was run at all.
    run_failed
        Whether it was, and ended without a result: nothing it is about is approved.
    """

    study: str
    answer: Answer | None
    checks: tuple[Check, ...] = ()
    unevaluated: tuple[UnevaluatedCheck, ...] = ()
    failure_reasons: tuple[str, ...] = ()
    was_run: bool = True
    run_failed: bool = False


class Study(Protocol[Answer]):
    """A question about an application."""

    @property
    def name(self) -> str:
        """What it is called, in files, options and reports."""
        ...

    def applies_to(self, application: Application) -> bool:
        """Whether the application has what the study is about: a bracket, say."""
        ...

    def missing_inputs(self, application: Application) -> tuple[str, ...]:
        """Return what the application would have to give, by its keys; nothing if it can run."""
        ...

    def run(
        self, application: Application, tell: ProgressCallback = ignore_status
    ) -> StudyResult[Answer]:
        """Run the study."""
        ...


def _never(application: Application) -> bool:
    """Return False: the study runs only if it is chosen."""
    del application
    return False


@dataclass(frozen=True, kw_only=True)
class StudyRegistration:
    """What a topic registers: its study, and the functions that present what it found.

    Functions are dotted names, `module:function`, imported on first use; empty for none. Each
    takes the study's result.

    Attributes
    ----------
    name, title
        Name of the study, and the title of its chapter and sheet.
    study
        The study as it runs on an application alone; None if it needs another input.
    required_input
        That other input.
    runs_by_default
        Whether an approval of an application includes it unasked.
    chapters
        Yields chapters of a report: (result, say, *, short).
    text_lines
        Yields lines for a terminal: (result, say).
    json_entries
        Returns entries of the JSON document by key: (result).
    """

    name: str
    title: str = ""
    study: Study[Any] | None = None
    required_input: str = ""
    runs_by_default: Callable[[Application], bool] = _never
    chapters: str = ""
    text_lines: str = ""
    json_entries: str = ""


def load_function(dotted_name: str) -> Callable[..., Any]:
    """Return the function of a dotted name, `module:function`."""
    module, name = dotted_name.split(":")
    return getattr(import_module(module), name)


def limits_of_study(study: str, application: Application) -> tuple[Limit, ...]:
    """Return the limits of the application's profile that a study answers.

    Without `bolts` a bracket's file says nothing that could slip, and does not miss it.
    """
    bolted = application.bracket is not None and application.bracket.bolts is not None
    return tuple(
        m
        for m in application.limits
        if declared_quantity(m.quantity).study == study
        and (bolted or m.quantity != BOLT_SLIP_QUANTITY)
    )


def unevaluated_checks(
    study: str, application: Application, needs: tuple[str, ...]
) -> Iterator[UnevaluatedCheck]:
    """Yield what is not evaluated if a study is not run, for want of `needs`."""
    for limit in limits_of_study(study, application):
        yield UnevaluatedCheck(
            limit=limit,
            line=application.lines[0].line.name,
            when=EvaluationCondition("state", application.states[0].name),
            part=WHOLE_LINE,
            missing_inputs=needs,
        )
