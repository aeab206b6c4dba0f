"""The study of vibration as approvals know it; what it computes with is imported when it runs."""

from typing import TYPE_CHECKING

from cardan.approval.study import VIBRATION_STUDY_NAME, StudyRegistration, StudyResult
from cardan.checks.quantities.declaration import NEEDS_SHAFT_LENGTHS, NEEDS_TUBE_OF_SHAFT
from cardan.core.lazy_dataclass import dataclass
from cardan.core.status import ProgressCallback, ignore_status
from cardan.model.application import Application, GearboxAndAxleRotors

if TYPE_CHECKING:
    from cardan.topics.torsion.vibration_result import VibrationResult


@dataclass(frozen=True)
class VibrationStudy:
    """Every gear's speeds against torsional resonances, parametric zones and flutter.

    What `adjacent_rotors` say goes before the application's own; what is not given is assumed.
    """

    adjacent_rotors: GearboxAndAxleRotors | None = None
    name: str = VIBRATION_STUDY_NAME

    def applies_to(self, application: Application) -> bool:
        """Whether the application is about this: every line vibrates."""
        del application
        return True

    def missing_inputs(self, application: Application) -> tuple[str, ...]:
        """Return what a vibration study needs of every line."""
        lines = [i.line for i in application.lines]
        shafts = [s for line in lines for s in line.shafts]
        known = all(s.tube is not None or s.polar_inertia_given is not None for s in shafts)
        short = any(s.tube and not line.has_lengths for line in lines for s in line.shafts)
        return tuple(
            n.required_input
            for n, missed in ((NEEDS_TUBE_OF_SHAFT, not known), (NEEDS_SHAFT_LENGTHS, short))
            if missed
        )

    def run(
        self, application: Application, tell: ProgressCallback = ignore_status
    ) -> "StudyResult[VibrationResult]":
        """Run the study on every line."""
        from cardan.topics.torsion.study import run_vibration_study

        return run_vibration_study(application, surroundings=self.adjacent_rotors, tell=tell)


REGISTRATION = StudyRegistration(
    name=VIBRATION_STUDY_NAME,
    title="Vibration and stability",
    study=VibrationStudy(),
    runs_by_default=lambda application: application.has_rotor_data,
    chapters="cardan.topics.torsion.chapter:vibration_chapters",
    json_entries="cardan.topics.torsion.presentation_json:vibration_json_entries",
)
