"""The approval of an application: what its studies found, and the one verdict there is."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

from cardan.base.errors import DesignError, NotConverged
from cardan.base.frozen import dataclass
from cardan.base.said import Said
from cardan.base.verdict import GRADES, Check, Unanswered, Verdict, worst
from cardan.files.limit import DEFAULT
from cardan.files.limit import limits as profile
from cardan.model.application import Application
from cardan.quantity.quantities import QUANTITIES
from cardan.quantity.response import Response
from cardan.study.data import Datum, data_of
from cardan.study.driveline import DrivelineStudy
from cardan.study.finding import (
    DRIVELINE,
    RECORDING,
    Finding,
    Study,
    Tell,
    limits_of,
    silence,
    silent,
)
from cardan.study.notes import noted
from cardan.study.studies import STUDIES, VibrationStudy


@dataclass(frozen=True, kw_only=True)
class Coverage:
    """How many of the questions that a profile asks got an answer."""

    answered: int
    unanswered: tuple[Unanswered, ...]

    @property
    def asked(self) -> int:
        """Limits times the states and parts they ask about."""
        return self.answered + len(self.unanswered)

    @property
    def missed(self) -> tuple[Unanswered, ...]:
        """What leaves a verdict incomplete: required, and without an answer."""
        return tuple(u for u in self.unanswered if u.limit.required)


@dataclass(frozen=True, kw_only=True)
class Approval:
    """The answer to an application. Every medium reads it, so none can disagree.

    Only the application and what its studies found is stored.
    """

    application: Application
    findings: tuple[Finding[Any], ...]

    @property
    def checks(self) -> tuple[Check, ...]:
        """Every demand held against a limit, study by study."""
        return tuple(c for f in self.findings for c in f.checks)

    @property
    def coverage(self) -> Coverage:
        """What was asked, and what got an answer."""
        return coverage_of(*self.findings)

    @property
    def verdict(self) -> Verdict:
        """The worst of all checks, incomplete where nothing fails but an answer is missing.

        An application that nothing was asked of is incomplete too, and one of which a study was
        asked that could not answer.
        """
        refused = any(f.refused for f in self.findings)
        return verdict_of(self.checks, missed=refused or bool(self.coverage.missed))

    @property
    def smallest_margin(self) -> float | None:
        """The least share of its bound that a check leaves free which decides; None without any.

        Those of the worst grade decide: where something fails, what fails, to the maximum it
        passed; else what warns, or passes, to the normal bound.
        """
        worst = max((GRADES.index(c.grade) for c in self.checks), default=0)
        return min((c.margin for c in self.checks if c.grade == GRADES[worst]), default=None)

    @property
    def studies(self) -> tuple[str, ...]:
        """The studies that the verdict is of."""
        return tuple(f.study for f in self.findings if f.answer is not None)

    @property
    def not_asked(self) -> tuple[str, ...]:
        """Studies that the application gives grounds for, and that nobody asked."""
        return tuple(f.study for f in self.findings if not f.asked)

    @property
    def responses(self) -> tuple[Response, ...]:
        """What each line does in its states."""
        return self.of(DRIVELINE) or ()

    @cached_property
    def data(self) -> tuple[Datum, ...]:
        """The rows of catalogues that it stands on, and how each was read."""
        return tuple(data_of(self.application))

    @cached_property
    def noted(self) -> tuple[Said, ...]:
        """What a reader should know: where the application contradicts itself, what is assumed."""
        return tuple(noted(self.application, self.responses))

    @property
    def notes(self) -> tuple[str, ...]:
        """The same in English."""
        return tuple(map(str, self.noted))

    def of(self, study: str) -> Any:
        """Return the answer of a study; None where it was not asked or had none."""
        return next((f.answer for f in self.findings if f.study == study), None)

    def unasked(self) -> tuple[str, ...]:
        """Return the quantities that limits ask about and no number answered at all."""
        answered = {c.quantity for c in self.checks}
        missed = dict.fromkeys(u.quantity for u in self.coverage.unanswered)
        return tuple(q for q in missed if q not in answered)


UNHEARD = "a campaign of recordings, by --recording"
"""What limits of a recording need of whoever asks."""


def coverage_of(*findings: Finding[Any]) -> Coverage:
    """Return what studies were asked, and what got an answer."""
    return Coverage(
        answered=sum(len(f.checks) for f in findings),
        unanswered=tuple(u for f in findings for u in f.unanswered),
    )


def verdict_of(checks: Sequence[Check], *, missed: bool) -> Verdict:
    """Return what checks come to; `missed` where a required limit got no answer.

    Where nothing was asked nothing is approved either.
    """
    found: list[Verdict] = [c.grade for c in checks]
    return worst([*found, "incomplete"] if missed or not found else found)


def approve(
    application: Application,
    studies: Sequence[Study[Any]] | None = None,
    *,
    tell: Tell = silent,
) -> Approval:
    """Ask studies of an application, and gather what they find into one approval.

    Parameters
    ----------
    application
        Its profile says what is limited, and which limits are required; a study that it says
        nothing of is `held_to` those of another.
    studies
        Which, in this order; by default those of `default_studies`. What a study misses
        leaves its limits unanswered, and so does one that is not asked with the driveline
        though the application is about it.
    tell
        Told how far it has come.

    Raises
    ------
    DesignError
        If the driveline cannot exist in a state, or a study that is asked alone refuses.
        One that refuses beside others leaves its limits unanswered, with the reason.
    """
    chosen = default_studies(application) if studies is None else studies
    names = {study.name for study in chosen}
    # A profile that says nothing of the driveline asks nothing of it.
    for name in sorted(names - {DRIVELINE}):
        application = held_to(application, name)
    return Approval(
        application=application,
        findings=(
            *(_found(study, application, tell, alone=len(chosen) == 1) for study in chosen),
            *(_unasked(application, names) if DRIVELINE in names else ()),
        ),
    )


def default_studies(application: Application) -> tuple[Study[Any], ...]:
    """Return what an approval asks if nobody says: the driveline, and vibration if it is given.

    Vibration is asked where the file says what turns beside the lines, or how it starts. A
    bracket takes a while and has to be asked for.
    """
    if application.says_what_turns:
        return (DrivelineStudy(), VibrationStudy())
    return (DrivelineStudy(),)


def assess(application: Application) -> Approval:
    """Return the approval of the driveline in its states alone."""
    return approve(application, (DrivelineStudy(),))


def held_to(application: Application, study: str) -> Application:
    """Return an application for a study that is asked of it.

    Where the application's limits say nothing of the study, those of the profile that counts
    where none is named are held against it: an answer that nothing asks about would pass.
    """
    if limits_of(study, application):
        return application
    name, every = profile(DEFAULT)
    rows = tuple(m for m in every if QUANTITIES[m.quantity].study == study)
    if not rows:
        return application
    return replace(
        application,
        limits=(*application.limits, *rows),
        profile=f"{application.profile}; {study}: {name}",
    )


def _found(study: Study[Any], application: Application, tell: Tell, *, alone: bool) -> Finding[Any]:
    """Return what a study finds, or why it could not be asked."""
    needs, refused = study.missing(application), False
    if alone and needs:
        msg = f"{study.name} needs {', '.join(needs)}"
        raise DesignError(msg)
    if not needs:
        try:
            return study.run(application, tell)
        except (DesignError, NotConverged) as error:
            # A recording was named for its own sake: silence about it would be no answer.
            if alone or study.name in (DRIVELINE, RECORDING):
                raise
            needs, refused = (str(error),), True
    return Finding(
        study=study.name,
        answer=None,
        unanswered=tuple(silence(study.name, application, needs)),
        doubts=needs,
        refused=refused,
    )


def _unasked(application: Application, names: set[str]) -> Iterator[Finding[Any]]:
    """Yield the silence of studies that nobody asked."""
    for name, study in STUDIES.items():
        if name not in names and study.concerns(application):
            needs = (f"--with {name}",)
            unanswered = tuple(silence(name, application, needs))
            yield Finding(study=name, answer=None, unanswered=unanswered, asked=False)
        elif name not in names:  # what is required stays open, whatever the application is about
            needs = study.missing(application)
            required = tuple(u for u in silence(name, application, needs) if u.limit.required)
            if required:
                yield Finding(study=name, answer=None, unanswered=required)
    if RECORDING not in names:  # its limits stay open: no file names the campaign that answers them
        unheard = tuple(silence(RECORDING, application, (UNHEARD,)))
        if unheard:
            yield Finding(study=RECORDING, answer=None, unanswered=unheard)
