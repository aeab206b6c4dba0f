"""The approval of an application: what its studies found, and the one verdict there is."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

from cardan.application.limit_profiles import DEFAULT_PROFILE_NAME
from cardan.application.limit_profiles import load_profile as profile
from cardan.approval.assumed_inputs import checks_with_assumed_ranges
from cardan.approval.coverage import (
    ApprovalSubject,
    CheckCoverage,
    coverage_of,
    subjects_not_evaluated,
    verdict_of,
)
from cardan.approval.data_provenance import CatalogueDatum, catalogue_data_of
from cardan.approval.deciding_inputs import DecidingInputs, deciding_inputs
from cardan.approval.driveline_study import DrivelineStudy
from cardan.approval.notes import approval_notes
from cardan.approval.registry import study_registrations
from cardan.approval.study import (
    DRIVELINE_STUDY_NAME,
    RECORDING_STUDY_NAME,
    Study,
    StudyResult,
    limits_of_study,
    unevaluated_checks,
)
from cardan.checks.line_response import LineResponse
from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.errors import ConvergenceError, DesignError
from cardan.core.lazy_dataclass import dataclass
from cardan.core.message import TranslatableMessage
from cardan.core.status import ProgressCallback, ignore_status
from cardan.core.verdict import CHECK_GRADES, Check, CheckGrade, UnevaluatedCheck, Verdict
from cardan.model.application import Application, missing_state_kinds

PLACEHOLDER_INPUT = "values in place of placeholders"
"""What a check misses while an application holds placeholders."""


@dataclass(frozen=True, kw_only=True)
class Approval:
    """The answer to an application. Every medium reads it, so none can disagree.

    Only the application and what its studies found is stored.
    """

    application: Application
    study_results: tuple[StudyResult[Any], ...]

    @property
    def checks(self) -> tuple[Check, ...]:
        """Every demand held against a limit, study by study."""
        return tuple(c for f in self.study_results for c in f.checks)

    @property
    def coverage(self) -> CheckCoverage:
        """What was requested, and what got an answer."""
        return coverage_of(*self.study_results)

    @property
    def verdict(self) -> Verdict:
        """The worst of all checks, incomplete where nothing fails but an answer is missing.

        An application that nothing is requested of is incomplete too, and one with a requested
        study that could not run.
        """
        refused = any(f.run_failed for f in self.study_results)
        return verdict_of(self.checks, missed=refused or bool(self.coverage.missing_required))

    @cached_property
    def not_evaluated(self) -> tuple[ApprovalSubject, ...]:
        """What the verdict is not of, though a driveline was evaluated: speed, strength, rubber.

        An approval of angles alone says so wherever its verdict stands. Centre bearings of
        vehicles hang in rubber, on which order 2 shakes them several times as much as rigid
        ones; those of machines and bare lines are what the file says.
        """
        if self.answer_of(DRIVELINE_STUDY_NAME) is None:
            return ()
        found: list[ApprovalSubject] = [*subjects_not_evaluated(self.application, self.checks)]
        app = self.application
        rides = app.vehicle is not None or app.suspension is not None or app.gearbox is not None
        if rides and any(r.line.centre_bearings and r.mounts.is_rigid for r in self.line_responses):
            found.append("rubber of the centre bearings")
        return tuple(found)

    @cached_property
    def state_kinds_not_given(self) -> tuple[str, ...]:
        """Kinds of state that the profile expects of a vehicle, and that the file lacks."""
        return missing_state_kinds(self.application)

    @cached_property
    def deciding_inputs(self) -> DecidingInputs | None:
        """Given numbers that the check nearest to its maximum rests on; None if a check fails."""
        return deciding_inputs(self.line_responses, self.checks)

    @property
    def smallest_margin(self) -> float | None:
        """The least share of its bound that a check leaves free which decides; None without any.

        Those of the worst grade decide: where something fails, what fails, to the maximum it
        passed; else what warns, or passes, to the normal bound.
        """
        return min((c.margin for c in self.checks if c.grade == self.worst_grade), default=None)

    @property
    def worst_grade(self) -> CheckGrade:
        """The worst grade of a check; pass without any."""
        return CHECK_GRADES[max((CHECK_GRADES.index(c.grade) for c in self.checks), default=0)]

    @property
    def studies(self) -> tuple[str, ...]:
        """The studies that the verdict is of."""
        return tuple(f.study for f in self.study_results if f.answer is not None)

    @property
    def studies_not_run(self) -> tuple[str, ...]:
        """Studies that the application gives grounds for, and that were not requested."""
        return tuple(f.study for f in self.study_results if not f.was_run)

    @property
    def line_responses(self) -> tuple[LineResponse, ...]:
        """What each line does in its states."""
        return self.answer_of(DRIVELINE_STUDY_NAME) or ()

    @cached_property
    def catalogue_data(self) -> tuple[CatalogueDatum, ...]:
        """The rows of catalogues that it stands on, and how each was read."""
        return tuple(catalogue_data_of(self.application, self.studies))

    @cached_property
    def note_messages(self) -> tuple[TranslatableMessage, ...]:
        """What a reader should know: where the application contradicts itself, what is assumed."""
        return tuple(approval_notes(self.application, self.line_responses))

    @property
    def notes(self) -> tuple[str, ...]:
        """The same in English."""
        return tuple(map(str, self.note_messages))

    def answer_of(self, study: str) -> Any:
        """Return the result of a study; None if it was not run or has none."""
        return next((f.answer for f in self.study_results if f.study == study), None)

    def unevaluated_quantities(self) -> tuple[str, ...]:
        """Return the quantities that have limits and no value at all."""
        answered = {c.quantity for c in self.checks}
        missed = dict.fromkeys(u.quantity for u in self.coverage.unevaluated)
        return tuple(q for q in missed if q not in answered)


def approve_application(
    application: Application,
    studies: Sequence[Study[Any]] | None = None,
    *,
    tell: ProgressCallback = ignore_status,
) -> Approval:
    """Run studies of an application, and gather their results into one approval.

    Parameters
    ----------
    application
        Its profile says what is limited, and which limits are required; a study that it says
        nothing of is `with_default_limits` those of another.
    studies
        Which, in this order; by default those of `default_studies`. What a study misses
        leaves its limits not evaluated, and so does one that is not run with the driveline
        though the application is about it.
    tell
        Receives the progress.

    Raises
    ------
    DesignError
        If the driveline cannot exist in a state, or a study that is run alone refuses.
        One that refuses among others leaves its limits not evaluated, with the reason.
    """
    chosen = default_studies(application) if studies is None else studies
    names = {study.name for study in chosen}
    # A profile that says nothing of the driveline requires nothing of it.
    for name in sorted(names - {DRIVELINE_STUDY_NAME}):
        application = with_default_limits(application, name)
    return Approval(
        application=application,
        study_results=(
            *(
                _without_checks_of_placeholders(
                    _found(study, application, tell, alone=len(chosen) == 1), application
                )
                for study in chosen
            ),
            *(_unasked(application, names) if DRIVELINE_STUDY_NAME in names else ()),
        ),
    )


def default_studies(application: Application) -> tuple[Study[Any], ...]:
    """Return the studies that an approval includes unasked: those that register so."""
    return tuple(
        one.study
        for one in study_registrations().values()
        if one.study is not None and one.runs_by_default(application)
    )


def approve_driveline(application: Application) -> Approval:
    """Return the approval of the driveline in its states alone."""
    return approve_application(application, (DrivelineStudy(),))


def with_default_limits(application: Application, study: str) -> Application:
    """Return an application for a study that is run on it.

    Where the application's limits say nothing of the study, those of the profile that counts
    where none is named are held against it: a result without limits would pass.
    """
    if limits_of_study(study, application):
        return application
    name, every = profile(DEFAULT_PROFILE_NAME)
    rows = tuple(m for m in every if QUANTITIES[m.quantity].study == study)
    if not rows:
        return application
    return replace(
        application,
        limits=(*application.limits, *rows),
        profile=f"{application.profile}; {study}: {name}",
    )


def _found(
    study: Study[Any], application: Application, tell: ProgressCallback, *, alone: bool
) -> StudyResult[Any]:
    """Return what a study finds, or why it could not be run."""
    needs, refused = study.missing_inputs(application), False
    if alone and needs:
        msg = f"{study.name} needs {', '.join(needs)}"
        raise DesignError(msg)
    if not needs:
        try:
            found: StudyResult[Any] = study.run(application, tell)
            if study.name == DRIVELINE_STUDY_NAME and found.answer is not None:
                checks = checks_with_assumed_ranges(found.answer, found.checks)
                found = replace(found, checks=checks)
            return found
        except (DesignError, ConvergenceError) as error:
            # A recording was named for its own sake: silence about it would hide that it is
            # missing.
            if alone or study.name in (DRIVELINE_STUDY_NAME, RECORDING_STUDY_NAME):
                raise
            needs, refused = (str(error),), True
    return StudyResult(
        study=study.name,
        answer=None,
        unevaluated=tuple(unevaluated_checks(study.name, application, needs)),
        failure_reasons=needs,
        run_failed=refused,
    )


def _without_checks_of_placeholders(
    found: StudyResult[Any], application: Application
) -> StudyResult[Any]:
    """Return a result without checks while the application holds placeholders.

    Its numbers are those of a vehicle that does not exist: they neither approve nor reject.
    """
    if not application.placeholders:
        return found
    unevaluated = (
        UnevaluatedCheck(
            limit=c.limit, line=c.line, when=c.when, part=c.part,
            missing_inputs=(PLACEHOLDER_INPUT,),
        )
        for c in found.checks
    )  # fmt: skip
    return replace(found, checks=(), unevaluated=(*unevaluated, *found.unevaluated))


def _unasked(application: Application, names: set[str]) -> Iterator[StudyResult[Any]]:
    """Yield notes on studies that were not requested."""
    for name, registered in study_registrations().items():
        if name in names:
            continue
        study = registered.study
        if study is None:  # its limits stay open: the application does not name its input
            needs = (registered.required_input,)
            if unanswered := tuple(unevaluated_checks(name, application, needs)):
                yield StudyResult(study=name, answer=None, unevaluated=unanswered)
        elif study.applies_to(application):
            needs = (f"--with {name}",)
            unanswered = tuple(unevaluated_checks(name, application, needs))
            yield StudyResult(study=name, answer=None, unevaluated=unanswered, was_run=False)
        else:  # what is required stays open, whatever the application is about
            needs = study.missing_inputs(application)
            required = tuple(
                u for u in unevaluated_checks(name, application, needs) if u.limit.required
            )
            if required:
                yield StudyResult(study=name, answer=None, unevaluated=required)
