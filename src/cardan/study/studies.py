"""The studies of an application: each imports what it computes with when it is asked.

A check of a driveline is not to wait for finite elements that nobody asks for.
"""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cardan.base.errors import DesignError
from cardan.base.frozen import dataclass
from cardan.model.application import Application, Surroundings
from cardan.quantity.declared import LENGTHS, TUBES
from cardan.study.driveline import DrivelineStudy
from cardan.study.finding import (
    BRACKET,
    RECORDING,
    VIBRATION,
    Finding,
    Study,
    Tell,
    limits_of,
    silent,
)

if TYPE_CHECKING:
    from cardan.study.bracket import BracketAnswer, Case
    from cardan.study.recording import Mix
    from cardan.study.stability import Stability


@dataclass(frozen=True)
class VibrationStudy:
    """Every gear's speeds against torsional resonances, parametric zones and flutter.

    What `surroundings` say goes before the application's own; what nobody says is assumed.
    """

    surroundings: Surroundings | None = None
    name: str = VIBRATION

    def concerns(self, application: Application) -> bool:
        """Whether the application is about this: every line vibrates."""
        del application
        return True

    def missing(self, application: Application) -> tuple[str, ...]:
        """Return what every line needs to be asked how it vibrates."""
        lines = [i.line for i in application.lines]
        shafts = [s for line in lines for s in line.shafts]
        known = all(s.tube is not None or s.polar_inertia_given is not None for s in shafts)
        short = any(s.tube and not line.measured for line in lines for s in line.shafts)
        return tuple(n.gives for n, missed in ((TUBES, not known), (LENGTHS, short)) if missed)

    def run(self, application: Application, tell: Tell = silent) -> "Finding[Stability]":
        """Ask every line."""
        from cardan.study.stability import vibration

        return vibration(application, surroundings=self.surroundings, tell=tell)


@dataclass(frozen=True)
class BracketStudy:
    """The bracket a centre bearing hangs in, under the driveline's loads and those by hand.

    `extra` cases count beside those of the application.
    """

    extra: "tuple[Case, ...]" = ()
    name: str = BRACKET

    def concerns(self, application: Application) -> bool:
        """Whether the application is about this: it has a bracket."""
        return application.bracket is not None

    def missing(self, application: Application) -> tuple[str, ...]:
        """Return what the application would have to give."""
        return () if application.bracket else ("bracket, with a shape",)

    def run(self, application: Application, tell: Tell = silent) -> "Finding[BracketAnswer]":
        """Judge the bracket in the shape that is installed, a reinforced one beside it."""
        from cardan.study.bracket import judged

        return judged(application, extra=self.extra, tell=tell)


@dataclass(frozen=True)
class CampaignStudy:
    """What a campaign's recordings did to its gauges, held against its limits and the file's.

    `draw` where a report is to show it; `allow_outside` lets the campaign name files outside
    its own folder.
    """

    campaign: Path
    draw: bool = False
    allow_outside: bool = False
    name: str = RECORDING

    def concerns(self, application: Application) -> bool:
        """Whether the application is about this: somebody named a recording of it."""
        del application
        return True

    def missing(self, application: Application) -> tuple[str, ...]:
        """Return what the application would have to give: nothing, the campaign has it."""
        del application
        return ()

    def run(self, application: Application, tell: Tell = silent) -> "Finding[Mix]":
        """Ask every recording of the campaign."""
        from cardan.study.recording import listen_to_all, unheard

        try:
            found = listen_to_all(
                self.campaign, limits=limits_of(RECORDING, application),
                allow_outside=self.allow_outside, tell=tell, draw=self.draw, checked=application,
            )  # fmt: skip
        except DesignError as error:  # the application is not at fault
            msg = f"{self.campaign.name}: {error}"
            raise DesignError(msg) from error
        return replace(found, unanswered=(*found.unanswered, *unheard(found)))


STUDIES: dict[str, Study[Any]] = {
    s.name: s for s in (DrivelineStudy(), VibrationStudy(), BracketStudy())
}
"""The studies of an application by name, as they are where nobody says more."""
