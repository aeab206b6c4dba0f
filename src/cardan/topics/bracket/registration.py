"""The study of a bracket as approvals know it; what it computes with is imported when it runs."""

from typing import TYPE_CHECKING

from cardan.approval.study import BRACKET_STUDY_NAME, StudyRegistration, StudyResult
from cardan.core.lazy_dataclass import dataclass
from cardan.core.status import ProgressCallback, ignore_status
from cardan.model.application import Application

if TYPE_CHECKING:
    from cardan.topics.bracket.assessment import BracketResult
    from cardan.topics.bracket.load_cases import BearingLoadCase


@dataclass(frozen=True)
class BracketStudy:
    """The bracket a centre bearing hangs in, under the driveline's loads and those by hand.

    `extra_cases` count with those of the application.
    """

    extra_cases: "tuple[BearingLoadCase, ...]" = ()
    name: str = BRACKET_STUDY_NAME

    def applies_to(self, application: Application) -> bool:
        """Whether the application is about this: it has a bracket."""
        return application.bracket is not None

    def missing_inputs(self, application: Application) -> tuple[str, ...]:
        """Return what the application would have to give."""
        return () if application.bracket else ("the shape of the bracket",)

    def run(
        self, application: Application, tell: ProgressCallback = ignore_status
    ) -> "StudyResult[BracketResult]":
        """Assess the bracket in the shape that is installed, and a reinforced one."""
        from cardan.topics.bracket.assessment import run_bracket_study

        return run_bracket_study(application, extra=self.extra_cases, tell=tell)


REGISTRATION = StudyRegistration(
    name=BRACKET_STUDY_NAME,
    title="Bracket",
    study=BracketStudy(),
    chapters="cardan.topics.bracket.chapter:bracket_chapters",
)
