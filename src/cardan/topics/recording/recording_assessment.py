"""What a recording did to its gauges: the result of its study."""

from collections.abc import Mapping
from dataclasses import dataclass

from cardan.physics.signals.assessment import AssessmentSettings, GaugeAssessment
from cardan.physics.signals.attribution_result import JointAttribution
from cardan.physics.signals.cause_assessment import DamageCausesByGauge
from cardan.physics.signals.order_cuts import OrderCuts
from cardan.physics.signals.recording import Recording
from cardan.physics.signals.shaft_angle import ShaftAngle
from cardan.physics.signals.spectrograms import OrderMap, Spectrogram
from cardan.topics.recording.alternative_life_models import AlternativeLives
from cardan.topics.recording.identification_result import (
    IdentificationResult,
    ParameterChange,
    parameter_changes,
)
from cardan.topics.recording.options import AnalysisOptions
from cardan.topics.recording.predicted_life import PredictedLife
from cardan.topics.recording.shaft_signals import BusErrorValues
from cardan.topics.recording.stress_history import StressHistory
from cardan.topics.recording.usage import UsageDamage


@dataclass(frozen=True, kw_only=True)
class ReportFigures:
    """What a report draws of the gauges that said something, in their order.

    Attributes
    ----------
    gauges
        Their names.
    spectrograms
        Power over time and frequency, Pa²/Hz.
    order_maps
        Amplitude over speed and order, Pa; none where nothing is known to turn.
    cuts
        Orders 1, 2 and 4 window by window, Pa.
    histories
        Stress and damage over time.
    """

    gauges: tuple[str, ...]
    spectrograms: tuple[Spectrogram, ...]
    order_maps: tuple[OrderMap, ...]
    cuts: OrderCuts | None
    histories: tuple[StressHistory, ...] = ()


@dataclass(frozen=True, kw_only=True)
class AlternativeBusErrorInterpretation:
    """A channel with numbers that are none, and the answer with these taken otherwise.

    Attributes
    ----------
    bus_error_values
        Where they are, and how they are taken.
    additional_turns
        That the shaft would make more.
    evidence
        What the joints would be answerable for, by gauge.
    """

    bus_error_values: BusErrorValues
    additional_turns: float
    evidence: Mapping[str, JointAttribution]


@dataclass(frozen=True, kw_only=True)
class RecordingAssessment:
    """The answer: what a recording did to its gauges.

    Attributes
    ----------
    options
        Its settings.
    lives
        One a gauge of the plan; nan at those that have no samples.
    causes
        Of the gauges with a result, in their order; None if no speed separates the causes
        of damage.
    profile
        The limits' name; "" if no profile applies.
    angle
        How far the shaft has turned, as the stress has it; None where unknown.
    identification
        What the recording says of its application; None if not requested.
    figures
        Its gauges as arrays to draw; None if not needed.
    usage
        When and where its gauges' damage came; none if not requested.
    predicted_lives
        What gauges would do with the changed line; none where none was given.
    alternative_lives
        Its gauges judged by strain, by a crack, by odds; none if not requested.
    alternative_readings
        Channels of speed and torque in which a bus wrote that it had no value.
    """

    recording: Recording
    options: AnalysisOptions
    plan: AssessmentSettings
    lives: tuple[GaugeAssessment, ...]
    causes: DamageCausesByGauge | None
    profile: str
    angle: ShaftAngle | None = None
    identification: IdentificationResult | None = None
    figures: ReportFigures | None = None
    usage: tuple[UsageDamage, ...] = ()
    predicted_lives: tuple[PredictedLife, ...] = ()
    alternative_lives: tuple[AlternativeLives, ...] = ()
    alternative_readings: tuple[AlternativeBusErrorInterpretation, ...] = ()

    @property
    def parameter_changes(self) -> tuple[ParameterChange, ...]:
        """Where a changed line, of which something is promised, departs from what was found."""
        if self.options.changed is None or self.identification is None or not self.predicted_lives:
            return ()
        return parameter_changes(self.identification, self.options.changed)

    @property
    def lacks_prediction(self) -> bool:
        """Return whether a changed line was requested, and nothing is known of the driven one."""
        asked = self.options.changed is not None and self.identification is not None
        return asked and not self.predicted_lives
