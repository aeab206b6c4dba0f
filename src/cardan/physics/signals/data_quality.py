"""How far a gauge's answer may be trusted: what its faults change, and which are decided.

Each kind of fault is counted twice, with it and without. Where that changes the damage by
more than a fifth and its cause is not given, there is no single result, only two.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from cardan.core.arrays import FloatArray, IntArray
from cardan.core.finding import Finding
from cardan.physics.signals.conditioning import (
    ChannelReport,
    Conditioning,
    running_median_baseline,
)
from cardan.physics.signals.faults.fault_kind import Correction
from cardan.physics.signals.faults.gain_change import FAULT_GAIN, cumulative_factor_of_gain_changes
from cardan.physics.signals.faults.intervals import NO_FAULTS, FaultIntervals, merge_runs
from cardan.physics.signals.faults.registry import (
    CORRECTABLE_FAULTS,
    FAULTS_BY_CODE,
    IMPOSSIBLE_STRESS_FAULTS,
    MASKABLE_FAULTS,
    MASKABLE_OR_CORRECTABLE_FAULTS,
)
from cardan.physics.signals.faults.stuck_bit import FAULT_BIT
from cardan.physics.signals.faults.waveform import FAULT_CLIP, FAULT_MISSING_SAMPLES
from cardan.physics.signals.faults.whole_channel import (
    FAULT_ABOVE_TENSILE_STRENGTH,
    FAULT_DRIFT,
    FAULT_RATE,
    FAULT_UNIT,
)
from cardan.physics.signals.faults.zero_step import (
    FAULT_ZERO_SHIFT,
    cumulative_offset_of_zero_steps,
)

MAX_UNDECIDED_DAMAGE_CHANGE = 0.2
"""Change of damage, relative, beyond which an undecided fault leaves the result undetermined."""
MAX_CLIPPED_SHARE = 0.01
"""Share of samples cut off that leaves the result undetermined, whatever replaces their peaks."""
MIN_VALID_TIME_SHARE = 0.25
"""Share of the time a gauge must have lived to be answered for."""
MIN_CREST_HEIGHT_SHARE_LOST_BY_SAMPLING = 0.01
"""What crests may lose between samples before they are looked for there: 5 % at slope 5."""
MAX_STRESS_PA = 3e9
"""Stress beyond which no metal of a vehicle bears a cycle, Pa: strongest wire breaks there."""
MIN_RECORDING_STRESS_RANGE_PA = 0.1e6
"""Range of a whole recording below which it is the noise of a strain gauge, Pa: 0.5 µm/m."""
MIN_SAMPLE_RATE_HZ, MAX_SAMPLE_RATE_HZ = 50.0, 1e6
"""Samples a second of a strain gauge: a wheel hops at 10 to 15 Hz, and a converter ends."""
MIN_SHARE_OF_SAMPLES_WITH_SLOPE_CHANGE = 0.5
"""Share of the samples at which what moves bends, below which lines were laid between others."""
MIN_SAMPLES_PER_PERIOD = 2.5
"""Samples that a turn of what moves fastest takes to be met at all."""
MAX_HIGH_FREQUENCY_POWER_SHARE = 0.05
"""Share of power above 0.4 of the sample rate that makes a recording look undersampled."""


@dataclass(frozen=True, kw_only=True)
class FaultRule:
    """Whether what looks wrong is masked or accepted.

    Attributes
    ----------
    mask
        Make holes of it; else it is what the part felt.
    kind
        Of fault; "" for whatever was recorded in the time given.
    channel
        "" for every one.
    first, last : s
        What begins in this time.
    """

    mask: bool
    kind: str = ""
    channel: str = ""
    first: float = 0.0
    last: float = float("inf")

    @property
    def covers_all_time(self) -> bool:
        """Whether it names no time."""
        return (self.first, self.last) == (0.0, float("inf"))

    def applies_to(self, channel: str, kind: str) -> bool:
        """Whether it decides on this kind of this channel."""
        return self.kind in ("", kind) and self.channel in ("", channel)

    def contradicts(self, other: "FaultRule") -> bool:
        """Whether another rule, saying as much, decides otherwise on the same."""
        alike = (self.kind, self.channel, self.covers_all_time) == (
            other.kind,
            other.channel,
            other.covers_all_time,
        )
        together = self.first <= other.last and other.first <= self.last
        return alike and together and self.mask != other.mask


@dataclass(frozen=True, kw_only=True)
class RuleDecision:
    """What rules make of one kind of fault in one channel.

    Attributes
    ----------
    intervals
        All of them.
    masked, undecided : (k, 2) samples
        Those replaced by holes, and those undecided.
    """

    intervals: FaultIntervals
    masked: IntArray
    undecided: IntArray


def apply_rules(
    health: ChannelReport, *, channel: str, rules: Sequence[FaultRule], rate: float
) -> dict[str, RuleDecision]:
    """Return what rules make of each kind of fault of a channel; the last rule counts."""
    out: dict[str, RuleDecision] = {}
    for kind, where in health.faults.items():
        start = where.runs[:, 0] / rate
        mask, free = np.zeros(where.count, bool), np.ones(where.count, bool)
        for rule in rules:
            if rule.applies_to(channel, kind):
                inside = (start >= rule.first) & (start <= rule.last)
                mask[inside], free[inside] = rule.mask, False
        mask &= kind in MASKABLE_OR_CORRECTABLE_FAULTS
        out[kind] = RuleDecision(
            intervals=where, masked=where.runs[mask], undecided=where.runs[free]
        )
    if health.drifts:
        whole = np.array([[0, health.samples]], np.intp)
        told = any(r.kind and r.applies_to(channel, FAULT_DRIFT) for r in rules)
        where = FaultIntervals(whole, np.array([health.drift]))
        out[FAULT_DRIFT] = RuleDecision(
            intervals=where, masked=whole[:0], undecided=whole[: 0 if told else 1]
        )
    for kind, fault in health.whole_channel_faults.items():
        if kind not in CORRECTABLE_FAULTS:
            continue
        whole = np.array([[0, health.samples]], np.intp)
        told = [r.mask for r in rules if r.kind and r.applies_to(channel, kind)]
        off = bool(told) and told[-1]
        where = FaultIntervals(whole, np.array([fault.size]))
        out[kind] = RuleDecision(
            intervals=where, masked=whole[: int(off)], undecided=whole[: int(not told)]
        )
    return out


def sample_intervals_masked_by_time(
    *, channel: str, rules: Sequence[FaultRule], rate: float, samples: int
) -> IntArray:
    """Return the runs (k, 2) of samples that rules mask by time alone."""
    rows = [
        (max(int(np.ceil(r.first * rate)), 0), int(min(r.last * rate, samples - 1)) + 1)
        for r in rules
        if r.mask and not r.kind and r.channel in ("", channel)
    ]
    return merge_runs([np.array([r], np.intp) for r in rows if r[1] > r[0]])


def _drift_baseline(health: ChannelReport) -> FloatArray:
    """Return what a channel creeps by, five spans at a time: a step of its zero goes too."""
    return running_median_baseline(health, spans=5)


def _removed_intervals(of: RuleDecision, *, every: bool, none: bool) -> FaultIntervals:
    """Return the places that are taken off: those that rules mask, all, or none."""
    if none:
        return NO_FAULTS
    if every:
        return of.intervals
    mine = np.isin(of.intervals.runs[:, 0], of.masked[:, 0])
    return FaultIntervals(of.intervals.runs[mine], of.intervals.sizes[mine])


def _without_steps(health: ChannelReport, removed: Mapping[str, FaultIntervals]) -> ChannelReport:
    """Return a channel's health with steps and gains taken off its levels."""
    steps, gains = (removed.get(k, NO_FAULTS) for k in (FAULT_ZERO_SHIFT, FAULT_GAIN))
    if not (steps.count or gains.count):
        return health
    middle = (np.arange(health.levels.size) + 0.5) * health.span
    return replace(
        health,
        levels=(health.levels - cumulative_offset_of_zero_steps(steps, middle))
        / cumulative_factor_of_gain_changes(gains, middle),
    )


def _corrections(
    health: ChannelReport, removed: Mapping[str, FaultIntervals]
) -> Iterator[Callable[[FloatArray, int], FloatArray]]:
    """Yield what takes faults off a channel, in the order of their kinds."""
    for kind, where in removed.items():
        correction = FAULTS_BY_CODE[kind].correction
        if where.count and correction is not None:
            yield partial(_apply_correction, correction, where)
        elif where.count:
            yield health.whole_channel_faults[kind].removed_from


def _apply_correction(
    correction: Correction, where: FaultIntervals, x: FloatArray, start: int
) -> FloatArray:
    return correction(x, start, where)


ALL_UNDECIDED_FAULT_KINDS = "together"
"""Key of the variant without any undecided kind: each may hide what another does."""


@dataclass(frozen=True, kw_only=True)
class FaultTreatmentVariant:
    """One way to treat the channels: as ruled, or one kind of fault the other way."""

    kind: str = ""
    without: bool = True
    treatments: Mapping[str, Conditioning]


def fault_treatment_variants(
    healths: Mapping[str, ChannelReport], *, rules: Sequence[FaultRule], rate: float,
    baseline: Callable[[ChannelReport], FloatArray],
) -> list[FaultTreatmentVariant]:  # fmt: skip
    """Return the ways to treat channels: as ruled first, then each kind with and without.

    A kind that rules mask whole, or not at all, is once what the first way does already.
    """
    book = {c: apply_rules(h, channel=c, rules=rules, rate=rate) for c, h in healths.items()}

    def way(*kinds: str, without: bool = True) -> FaultTreatmentVariant:
        made: dict[str, Conditioning] = {}
        for channel, health in healths.items():
            own = book[channel]
            runs = [
                sample_intervals_masked_by_time(
                    channel=channel, rules=rules, rate=rate, samples=health.samples
                )
            ]
            runs += [d.masked for k, d in own.items() if k not in (*kinds, *CORRECTABLE_FAULTS)]
            if without:
                runs += [own[k].intervals.runs for k in kinds if k in MASKABLE_FAULTS and k in own]
            removed = {
                k: _removed_intervals(
                    own[k], every=without and k in kinds, none=k in kinds and not without
                )
                for k in CORRECTABLE_FAULTS
                if k in own
            }
            level = baseline
            if FAULT_DRIFT in kinds and without and FAULT_DRIFT in own:
                level = _drift_baseline
            crowns = (
                own[FAULT_CLIP].intervals if FAULT_CLIP in kinds and FAULT_CLIP in own else None
            )
            made[channel] = Conditioning(
                masked=merge_runs(runs),
                baseline=level(_without_steps(health, removed)),
                span=health.span,
                corrections=tuple(_corrections(health, removed)),
                **({"crowned": crowns} if crowns is not None else {}),
            )
        return FaultTreatmentVariant(
            kind=kinds[0] if len(kinds) == 1 else ALL_UNDECIDED_FAULT_KINDS * bool(kinds),
            without=without,
            treatments=made,
        )

    out = [way()]
    open_: list[str] = []
    for kind in dict.fromkeys(k for told in book.values() for k in told):
        if kind == FAULT_MISSING_SAMPLES:  # no cycle comes or goes with them, only time
            continue
        of = [told[kind] for told in book.values() if kind in told]
        masked = sum(len(d.masked) for d in of)
        if masked < sum(d.intervals.count for d in of):
            out.append(way(kind))
        if masked:
            out.append(way(kind, without=False))
        if any(len(d.undecided) for d in of):
            open_.append(kind)
    return [*out, way(*open_)] if len(open_) > 1 else out


REASON_STRESS_TOO_HIGH = Finding("stress-too-high")
REASON_STRESS_TOO_LOW = Finding("stress-too-low")
REASON_RATE_TOO_LOW = Finding("rate-too-low")
REASON_INTERPOLATED = Finding("interpolated")
REASON_RATE_TOO_HIGH = Finding("rate-too-high")
REASON_RATE_TOO_LOW_FOR_SPEED = Finding("rate-too-low-for-speed")
REASON_ABOVE_TENSILE_STRENGTH = Finding("above-tensile-strength")
DOUBT_DAMAGE_ABOVE_FAILURE = Finding("damage-above-failure")
DOUBT_STRESS_NAMED_AS_STRAIN = Finding("named-strain")
DOUBT_STRAIN_NAMED_AS_STRESS = Finding("named-stress")

REASON_STUCK_BIT = Finding("stuck-bit")


@dataclass(frozen=True, kw_only=True)
class DeclaredRecordingProperties:
    """What was said of a recording that its numbers may contradict.

    Attributes
    ----------
    rate : Hz
        Of its samples.
    bend_share
        Share of them at which it does not go straight on (`ChannelReport.bend_share`).
    max_known_frequency : Hz
        Known to move there, an order 2; 0 if unknown.
    ultimate : Pa
        Tensile strength; infinite if not given.
    """

    rate: float
    bend_share: float = 1.0
    max_known_frequency: float = 0.0
    ultimate: float = float("inf")
    stuck_bit_value: float = 0.0

    def contradictions(
        self, *, low: float, high: float, typical: float, sound: bool, plane: bool = False
    ) -> dict[str, Finding]:
        """Return why a stress (Pa) cannot be what it is said to be, by kind.

        Parameters
        ----------
        low, high : Pa
            Smallest and largest.
        typical : Pa
            What it usually is.
        sound
            Whether the largest is of the part, and no undecided spike.
        plane
            Whether it is one measure of a rosette, of which some are zero.
        """
        found: dict[str, Finding] = {}
        crest = max(high, -low)
        size = crest if sound else typical
        if size > MAX_STRESS_PA:
            found[FAULT_UNIT] = REASON_STRESS_TOO_HIGH.with_values(size=size, most=MAX_STRESS_PA)
        elif high - low < MIN_RECORDING_STRESS_RANGE_PA and not plane:
            found[FAULT_UNIT] = REASON_STRESS_TOO_LOW.with_values(
                size=high - low, least=MIN_RECORDING_STRESS_RANGE_PA
            )
        elif sound and crest > self.ultimate:
            found[FAULT_ABOVE_TENSILE_STRENGTH] = REASON_ABOVE_TENSILE_STRENGTH.with_values(
                size=crest, ultimate=self.ultimate
            )
        least = max(MIN_SAMPLE_RATE_HZ, MIN_SAMPLES_PER_PERIOD * self.max_known_frequency)
        if (
            self.bend_share < MIN_SHARE_OF_SAMPLES_WITH_SLOPE_CHANGE
            and self.bend_share * self.rate < least <= self.rate
        ):
            found[FAULT_RATE] = REASON_INTERPOLATED.with_values(
                rate=self.bend_share * self.rate, least=least
            )
        elif self.rate < MIN_SAMPLE_RATE_HZ:
            found[FAULT_RATE] = REASON_RATE_TOO_LOW.with_values(
                rate=self.rate, least=MIN_SAMPLE_RATE_HZ
            )
        elif self.rate > MAX_SAMPLE_RATE_HZ:
            found[FAULT_RATE] = REASON_RATE_TOO_HIGH.with_values(rate=self.rate)
        elif self.rate < MIN_SAMPLES_PER_PERIOD * self.max_known_frequency:
            found[FAULT_RATE] = REASON_RATE_TOO_LOW_FOR_SPEED.with_values(
                frequency=self.max_known_frequency,
                rate=self.rate,
                most=self.rate / MIN_SAMPLES_PER_PERIOD,
            )
        if self.stuck_bit_value:
            found[FAULT_BIT] = REASON_STUCK_BIT.with_values(width=self.stuck_bit_value)
        return found


@dataclass(frozen=True, kw_only=True)
class FaultEffect:
    """What one kind of fault changes at a gauge.

    Attributes
    ----------
    kind
        Of fault.
    count, samples
        How many there are in the gauge's channels.
    share
        Of the channels' samples.
    undecided
        How many of them no rule accepts or masks.
    damage_recorded, damage_without
        Damage with all of them as recorded, and with none: masked, or a clipped crest put back,
        a drift or a hum taken off; nan of what is impossible.
    reason
        What is impossible, of a gauge as a whole.
    damage_if_worst
        Damage if what it hides were the worst that was recorded; nan where it hides nothing.
    hidden_time : s
        Time in which the stress is unknown.
    """

    kind: str
    count: int
    samples: int
    share: float
    undecided: int
    damage_recorded: float
    damage_without: float
    reason: Finding | None = None
    damage_if_worst: float = float("nan")
    hidden_time: float = 0.0

    @property
    def change(self) -> float:
        """How much more the largest of its damages is than the smallest, relative."""
        change = _relative_difference(self.damage_recorded, self.damage_without)
        return max(change, self.change_if_worst)

    @property
    def change_if_worst(self) -> float:
        """How much more the damage may be by what it hides, relative; 0 where that is nothing."""
        if np.isnan(self.damage_if_worst):
            return 0.0
        return _relative_difference(self.damage_recorded, self.damage_if_worst)


def _relative_difference(one: float, other: float) -> float:
    """Return how much more the larger of two damages is than the smaller, relative."""
    low, high = sorted((one, other))
    return high / low - 1 if low > 0 else (np.inf if high > 0 else 0.0)


@dataclass(frozen=True, kw_only=True)
class AssumedUnit:
    """A unit that only the user's word gives, and what it would be in one as likely.

    Attributes
    ----------
    unit, other_unit
        As they are written.
    factor
        How many times as large the stress is in the other.
    damage
        Of that.
    """

    unit: str
    other_unit: str
    factor: float
    damage: float


@dataclass(frozen=True, kw_only=True)
class DataQuality:
    """How far one gauge's answer may be trusted.

    Attributes
    ----------
    live_time, recorded_time : s
        Time the gauge was alive, neither missing, masked nor frozen; and time recorded.
    effects
        One a kind of fault that changes cycles, takes time away or hides damage.
    damage_of_samples_only
        Damage by the samples alone, where crests were looked for between them; else nan.
    high_frequency_share
        Share of the stress's power above 0.4 of the sample rate, of all or where it is loudest.
    biaxiality
        Of a rosette, where the stress is high; nan of single gauges.
    damage_by_measure
        Damage of a rosette by each measure of its stress, where it is sheared.
    doubts
        What looks as if it had been said wrongly.
    assumed_unit
        Its unit, where the recording does not say it: no number of it shows that it is right.
    damage, damage_without_undecided
        As ruled, and without all undecided faults, if these are of several kinds; else nan.
    """

    live_time: float
    recorded_time: float
    effects: tuple[FaultEffect, ...] = ()
    damage_of_samples_only: float = float("nan")
    high_frequency_share: float = 0.0
    biaxiality: float = float("nan")
    damage_by_measure: Mapping[str, float] = field(default_factory=dict[str, float])
    doubts: tuple[Finding, ...] = ()
    assumed_unit: AssumedUnit | None = None
    damage: float = float("nan")
    damage_without_undecided: float = float("nan")

    @property
    def damage_if_worst(self) -> float:
        """Damage if what its faults hide were the worst recorded; nan where they hide nothing."""
        hidden = [e.damage_if_worst - self.damage for e in self.effects]
        known = [more for more in hidden if not np.isnan(more)]
        return self.damage + sum(known) if known else float("nan")

    @property
    def live_share(self) -> float:
        """Share of the time recorded in which the gauge was alive."""
        return self.live_time / self.recorded_time if self.recorded_time > 0 else 0.0

    @property
    def vetoes(self) -> tuple[str, ...]:
        """Kinds of fault that leave the result undetermined; "hole" if little data is valid."""
        found = [
            e.kind
            for e in self.effects
            # What is put on top of a clipped crest may be less than what was there.
            if e.undecided
            and (
                e.kind in IMPOSSIBLE_STRESS_FAULTS
                or e.change
                > (
                    MAX_UNDECIDED_DAMAGE_CHANGE / 2
                    if e.kind == FAULT_CLIP
                    else MAX_UNDECIDED_DAMAGE_CHANGE
                )
                or (e.kind == FAULT_CLIP and e.share > MAX_CLIPPED_SHARE)
            )
        ]
        if (
            not found
            and _relative_difference(self.damage, self.damage_without_undecided)
            > MAX_UNDECIDED_DAMAGE_CHANGE
        ):
            # Of what one fault did a part is taken for one kind, a part for another.
            found = [
                e.kind for e in self.effects if e.undecided and e.kind != FAULT_MISSING_SAMPLES
            ]
        return (
            (*found, FAULT_MISSING_SAMPLES)
            if self.live_share < MIN_VALID_TIME_SHARE
            else tuple(found)
        )

    @property
    def shear_dominated(self) -> bool:
        """Whether a rosette's stress is mostly shear, so that its measure decides."""
        return self.biaxiality < -0.5

    @property
    def verdict(self) -> str:
        """Return "data rejected", "doubtful" or "good"."""
        if self.vetoes:
            return "data rejected"
        doubtful = any(e.undecided for e in self.effects) or self.live_share < 0.9
        doubtful = (
            doubtful
            or self.shear_dominated
            or self.high_frequency_share > MAX_HIGH_FREQUENCY_POWER_SHARE
            or bool(self.doubts)
        )
        return "doubtful" if doubtful else "good"
