"""The study of recordings as approvals know it; what it computes with is imported when it runs."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from cardan.approval.study import (
    RECORDING_STUDY_NAME,
    StudyRegistration,
    StudyResult,
    limits_of_study,
)
from cardan.core.errors import DesignError
from cardan.core.lazy_dataclass import dataclass
from cardan.core.status import ProgressCallback, ignore_status
from cardan.model.application import Application

if TYPE_CHECKING:
    from cardan.topics.recording.campaign_assessment import CampaignAssessment


@dataclass(frozen=True)
class RecordingCampaignStudy:
    """What a campaign's recordings did to its gauges, held against its limits and the file's.

    `with_figures` if a report is to show it; `allow_outside` lets the campaign name files outside
    its own folder.
    """

    campaign: Path
    with_figures: bool = False
    allow_outside: bool = False
    name: str = RECORDING_STUDY_NAME

    def applies_to(self, application: Application) -> bool:
        """Whether the application is about this: a recording of it is named."""
        del application
        return True

    def missing_inputs(self, application: Application) -> tuple[str, ...]:
        """Return what the application would have to give: nothing, the campaign has it."""
        del application
        return ()

    def run(
        self, application: Application, tell: ProgressCallback = ignore_status
    ) -> "StudyResult[CampaignAssessment]":
        """Assess every recording of the campaign."""
        from cardan.topics.recording.campaign_study import analyse_campaign
        from cardan.topics.recording.life_verdict import unevaluated_checks_of_unknown_lives

        try:
            found = analyse_campaign(
                self.campaign,
                limits=limits_of_study(RECORDING_STUDY_NAME, application),
                allow_outside=self.allow_outside,
                tell=tell,
                draw=self.with_figures,
                checked=application,
            )
        except DesignError as error:  # the application is not at fault
            msg = f"{self.campaign.name}: {error}"
            raise DesignError(msg) from error
        return replace(
            found, unevaluated=(*found.unevaluated, *unevaluated_checks_of_unknown_lives(found))
        )


REGISTRATION = StudyRegistration(
    name=RECORDING_STUDY_NAME,
    title="Recording",
    required_input="a campaign of recordings, by --recording",
    chapters="cardan.topics.recording.chapter:study_chapters",
    text_lines="cardan.topics.recording.presentation:study_text_lines",
    json_entries="cardan.topics.recording.json_presentation:study_json_entries",
)
