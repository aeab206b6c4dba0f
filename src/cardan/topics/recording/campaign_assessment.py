"""What the recordings of a campaign did together: the result of its study."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from cardan.physics.fatigue.damage import LifeEstimate, RepeatedSequence
from cardan.physics.fatigue.rainflow import Cycles, concatenate_cycles
from cardan.physics.signals.assessment import GaugeAssessment
from cardan.physics.signals.attribution_result import JointAttribution, combine_attributions
from cardan.physics.signals.usage_profile import customer_damage_rate_percentile
from cardan.topics.recording.alternative_life_models import AlternativeLives, SequencedCycles
from cardan.topics.recording.options import AnalysisOptions
from cardan.topics.recording.recording_assessment import RecordingAssessment

MIN_SEGMENT_TRANSITION_DAMAGE_SHARE = 0.1
"""Share of a mix's damage from which cycles between its parts are reported."""

MIN_CUSTOMERS = 3
"""Recordings from which shares of customers are reported."""


@dataclass(frozen=True)
class MixGaugeResult:
    """One gauge in a mix of recordings.

    Attributes
    ----------
    name
        Of the gauge.
    parts
        What each recording did to it, and how often that is driven in the mix.
    transition_damage
        Damage of cycles from one part to another, were they driven in turn again and again.
    sequence
        How they follow each other then; None if not requested.
    undecided_faults
        Kinds of fault for which a recording would be undetermined as a whole, and of which its
        segments show nothing: their levels decide, and whether the part felt that is not given.
    """

    name: str
    parts: tuple[tuple[GaugeAssessment, float], ...]
    transition_damage: float = 0.0
    sequence: RepeatedSequence | None = None
    undecided_faults: tuple[str, ...] = ()

    @property
    def life(self) -> LifeEstimate:
        """Of the mix: damages, times and ways, each as often as it is driven."""

        def total(of: Callable[[LifeEstimate], float]) -> float:
            return sum(times * of(one.life) for one, times in self.parts)

        return LifeEstimate(
            damage=total(lambda one: one.damage), duration=total(lambda one: one.duration),
            distance=total(lambda one: one.distance), allowed=self.parts[0][0].life.allowed,
        )  # fmt: skip

    @property
    def sequenced_life(self) -> LifeEstimate | None:
        """Of the mix with its parts driven in turn; None where that says nothing else."""
        if not self.transition_damage > MIN_SEGMENT_TRANSITION_DAMAGE_SHARE * self.life.damage:
            return None
        return replace(self.life, damage=self.life.damage + self.transition_damage)

    @property
    def sequenced_cycles(self) -> SequencedCycles | None:
        """The same with its cycles; None where it says nothing else."""
        if self.sequenced_life is None or self.sequence is None:
            return None
        return SequencedCycles(
            concatenate_cycles([self.cycles, self.sequence.additional_cycles]),
            self.sequenced_life,
            self.sequence,
        )

    @property
    def cycles(self) -> Cycles:
        """Of the mix: those of each recording as often as it is driven."""
        return concatenate_cycles(one.cycles.repeated(times) for one, times in self.parts)

    @property
    def has_signal(self) -> bool:
        """Whether it said something in every recording."""
        return all(one.has_signal for one, _ in self.parts)

    @property
    def vetoes(self) -> tuple[str, ...]:
        """Kinds of fault that spoil it in any of them."""
        each = (kind for one, _ in self.parts for kind in one.vetoes)
        return tuple(dict.fromkeys((*each, *self.undecided_faults)))


@dataclass(frozen=True)
class CustomerPercentile:
    """One gauge of a share of customers: what they do in the time of the mix, and at most."""

    name: str
    life: LifeEstimate
    upper_bound: LifeEstimate
    has_signal: bool = True
    vetoes: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class CampaignAssessment:
    """The answer of a campaign: its recordings, and what they come to together.

    Attributes
    ----------
    title
        Of the campaign.
    parts
        Name, how often it is driven, and what was recorded in each.
    lives
        One a gauge.
    profile
        The limits' name; "" if no profile applies.
    customer_share
        Share of customers that is requested; 0 for none.
    recording_indices
        Which recording of the file each part is of, in their order.
    damage_at_failure
        Damage at failure.
    options
        Settings of every recording.
    alternative_lives
        The mix's gauges judged by strain, by a crack, by odds; none if not requested.
    """

    title: str
    parts: tuple[tuple[str, float, RecordingAssessment], ...]
    lives: tuple[MixGaugeResult, ...]
    profile: str
    customer_share: float = 0.0
    recording_indices: tuple[int, ...] = ()
    damage_at_failure: float = 1.0
    options: AnalysisOptions | None = None
    alternative_lives: tuple[AlternativeLives, ...] = ()

    @property
    def customer_damage_rates(self) -> dict[str, tuple[float, float]]:
        """Damage a second that a share of customers stays below at each gauge, and its bound.

        Each recording of the file is taken for a customer, its segments for what he drives; a
        gauge that some did no damage to has no result.
        """
        found: dict[str, tuple[float, float]] = {}
        for one in self.lives if self.customer_share else ():
            driven: dict[int, list[tuple[GaugeAssessment, float]]] = {}
            for whose, part in zip(self.recording_indices, one.parts, strict=True):
                driven.setdefault(whose, []).append(part)
            each = [MixGaugeResult(one.name, tuple(parts)).life for parts in driven.values()]
            rates = [life.damage / life.duration for life in each if life.duration > 0]
            if len(rates) >= MIN_CUSTOMERS and min(rates) > 0 and not one.vetoes:
                found[one.name] = customer_damage_rate_percentile(
                    rates, quantile=self.customer_share
                )
        return found

    def evidence(self, gauge: str) -> JointAttribution | None:
        """Return what the joints are answerable for at a gauge, of the mix's damage."""
        told: list[tuple[JointAttribution, float]] = []
        for (_, times, heard), (one, _) in zip(
            self.parts, next(m for m in self.lives if m.name == gauge).parts, strict=True
        ):
            if heard.causes is not None and gauge in heard.causes.gauges:
                where = heard.causes.gauges.index(gauge)
                told.append((heard.causes.joint_attributions[where], times * one.life.damage))
        return combine_attributions([e for e, _ in told], [w for _, w in told]) if told else None
