"""The damage of a recording shared among its causes: joints, engine, road and the rest."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import repeat
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from cardan.core.arrays import FloatArray, single_threaded_blas
from cardan.core.finding import Finding
from cardan.physics.fatigue.damage import damage_with_omission
from cardan.physics.fatigue.rainflow import EMPTY_REVERSALS, Cycles
from cardan.physics.signals.assessment import (
    AssessmentSettings,
    CycleCounter,
    ProgressCallback,
    gauge_stresses,
)
from cardan.physics.signals.attribution_result import (
    DOUBT_DOUBLE_SPEED,
    DOUBT_HALF_SPEED,
    DOUBT_NEGATIVE_SPEED,
    DOUBT_SHAFT_STOPPED,
    DOUBT_SPEED_MISSING,
    DOUBT_SPEED_SCALE,
    DOUBT_SPEEDS_SWAPPED,
    JOINTS_DOMINANT,
    JOINTS_NOT_DOMINANT,
    JointAttribution,
    combine_attributions,
)
from cardan.physics.signals.conditioning import ChannelReport
from cardan.physics.signals.confounders import FOUR_CYLINDER_FIRING_ORDER
from cardan.physics.signals.damage_attribution import (
    CAUSE_ENGINE,
    CAUSE_JOINTS,
    CAUSE_ROAD,
    SIX_CYLINDER_FIRING_ORDERS,
    PredictionComparison,
    ShapleyAttribution,
    SourceSeparation,
    coinciding_orders,
    compare_with_prediction,
    separate_stress_by_cause_piecewise,
    shapley_attributions,
)
from cardan.physics.signals.joint_attribution import JointCausedStress, separate_joint_caused_stress
from cardan.physics.signals.order_tracking import ShaftRotation
from cardan.physics.signals.recording import SAMPLES_PER_BLOCK, Recording, rechunk_to_block_size
from cardan.physics.signals.shaft_angle import ShaftAngle
from cardan.physics.signals.synchronous_fit import MIN_DETECTION_F_STATISTIC


@dataclass(frozen=True, kw_only=True)
class DamageCausesByGauge:
    """Causes of the damage at each gauge, and what it rests on.

    Attributes
    ----------
    gauges
        Their names, in the plan's order.
    attributions
        One a gauge, in that order.
    joint_attributions
        What the joints are answerable for, one a gauge.
    cycles_without_joints
        Cycles of the stress that is left without the joints' part, one a gauge.
    time : (m,) s
        Middles of the spans in which orders were found.
    speed : (m,) turns/s
        Of the shaft there.
    order2 : (gauges, m) Pa
        0-to-peak amplitude of the joints' order 2 there.
    torque : (m,) N m
        There, if a channel was named.
    comparisons
        Measured order 2 against the predicted, one a gauge, if a prediction was given.
    doubts
        What cannot be distinguished in this recording.
    """

    gauges: tuple[str, ...]
    attributions: list[ShapleyAttribution]
    joint_attributions: list[JointAttribution]
    cycles_without_joints: list[Cycles]
    time: FloatArray
    speed: FloatArray
    order2: FloatArray
    torque: FloatArray | None
    comparisons: list[PredictionComparison]
    doubts: list[Finding]

    @property
    def best_synchronised(self) -> JointAttribution | None:
        """Return the evidence of the gauge that knows the speed best; None where none found it."""
        best = max(self.joint_attributions, key=lambda e: e.f_statistic)
        return best if best.f_statistic >= MIN_DETECTION_F_STATISTIC else None


DOUBT_ORDERS_COINCIDE = Finding("orders-coincide")


DOUBT_OF_NAMED_GAUGE = Finding("of-gauge")


DOUBT_ENGINE_SPEED_NOT_GIVEN = Finding("engine-speed-not-given")


DOUBT_ENGINE_AT_SHAFT_SPEED = Finding("direct-gear")


DOUBT_TORQUE_NOT_GIVEN = Finding("torque-not-given")


VERDICTS_FOR_OR_AGAINST_JOINTS = JOINTS_DOMINANT, JOINTS_NOT_DOMINANT


JOINT_PART_IDENTIFICATION_BLOCK_S = 300.0
"""Seconds of recording in which the joints' part is identified at once."""


@single_threaded_blas()
def attribute_damage(
    recording: Recording,
    *,
    plan: AssessmentSettings,
    healths: dict[str, ChannelReport],
    how: SourceSeparation,
    angle: ShaftAngle | None = None,
    torque: tuple[str, float] | None = None,
    predicted: dict[str, float] | None = None,
    engine_orders: Sequence[float] = (),
    progress: ProgressCallback | None = None,
) -> DamageCausesByGauge:
    """Share the damage at every gauge among its causes.

    The joints' part is identified first, by phase and torque; what is left is taken apart
    into the other causes.

    Parameters
    ----------
    recording, plan, healths
        As for `life`.
    how
        Tones and their causes.
    angle
        Of the shaft, and how far to trust it; that of the first tone unless given.
    torque
        Channel of the shaft torque, and N m in its unit.
    predicted : Pa per N m
        Order-2 stress expected at a gauge per shaft torque, by gauge name.
    engine_orders
        Orders of the engine; if not given, four cylinders are possible.
    progress
        Receives the progress.
    """
    # One by one: in the memory of one gauge, and other gauges do not change its result.
    parts = [
        _attribute_damage_at_gauge(
            recording, plan=replace(plan, gauges=(gauge,)), healths=healths,
            how=how, angle=angle, torque=torque, predicted=predicted, engine_orders=engine_orders,
            progress=progress,
        )
        for gauge in plan.gauges
    ]  # fmt: skip
    gauges = tuple(name for p in parts for name in p.gauges)
    evidence = _withhold_verdicts_of_wrong_speed(
        [one for p in parts for one in p.joint_attributions]
    )
    doubts = [doubt for p in parts for doubt in p.doubts] + [
        DOUBT_OF_NAMED_GAUGE.with_values(gauge=name, doubt=doubt)
        for name, one in zip(gauges, evidence, strict=True)
        for doubt in one.doubts
    ]
    return replace(
        parts[0],
        gauges=gauges,
        attributions=[one for p in parts for one in p.attributions],
        joint_attributions=evidence,
        cycles_without_joints=[one for p in parts for one in p.cycles_without_joints],
        order2=np.concatenate([p.order2 for p in parts]),
        comparisons=[one for p in parts for one in p.comparisons],
        doubts=list(dict.fromkeys(doubts)),
    )


def _withhold_verdicts_of_wrong_speed(evidence: list[JointAttribution]) -> list[JointAttribution]:
    """Judge at no gauge of a recording at one of which its speed seems to be another's.

    What is locked at another scale may be something else that turns: it only widens the interval.
    """
    doubts = {d for one in evidence for d in one.doubts}
    for doubt, withheld in (
        (DOUBT_DOUBLE_SPEED, VERDICTS_FOR_OR_AGAINST_JOINTS),
        (DOUBT_HALF_SPEED, VERDICTS_FOR_OR_AGAINST_JOINTS),
        (DOUBT_SPEED_SCALE, (JOINTS_NOT_DOMINANT,)),
    ):
        if doubt in doubts:
            return [one.undetermined(doubt) if one.verdict in withheld else one for one in evidence]
    return evidence


def _attribute_damage_at_gauge(
    recording: Recording,
    *,
    plan: AssessmentSettings,
    healths: dict[str, ChannelReport],
    how: SourceSeparation,
    angle: ShaftAngle | None,
    torque: tuple[str, float] | None,
    predicted: dict[str, float] | None,
    engine_orders: Sequence[float],
    progress: ProgressCallback | None,
) -> DamageCausesByGauge:
    """Share the damage among its causes at the gauge of a plan."""
    shaft = how.sources[0].component.rotation
    joints = _JointContribution(
        plan, recording, angle or ShaftAngle(shaft), torque, how, engine_orders
    )
    stress = gauge_stresses(recording, plan=plan, healths=healths, name="cause", progress=progress)
    # As numbers: of a day small arrays that stay would keep the room of large ones apart.
    times: list[float] = []
    amplitudes: list[list[float]] = [[] for _ in plan.gauges]
    row = how.causes.index(CAUSE_JOINTS)

    def stretches() -> Iterator[FloatArray]:
        for stretch, parts in separate_stress_by_cause_piecewise(
            joints.remove_joints(stress), how=how.without_joints
        ):
            theirs, order2 = joints.part(stretch.start, stretch.signal.shape[1])
            parts[row] += theirs
            times.extend(stretch.time.tolist())
            place = np.rint(stretch.time * recording.rate).astype(np.intp) - stretch.start
            middle = np.clip(place, 0, order2.shape[1] - 1)
            for known, more in zip(amplitudes, order2[:, middle].tolist(), strict=True):
                known.extend(more)
            yield parts

    found = shapley_attributions(
        stretches(), causes=how.causes, curve=plan.curve, correction=plan.correction,
        rule=plan.residue_rule,
    )  # fmt: skip
    time, order2 = np.array(times), np.array(amplitudes)
    load = None
    comparisons: list[PredictionComparison] = []
    if torque is not None:
        load = channel_means_per_time_span(recording, torque[0], how=how)[: time.size] * torque[1]
        if predicted:
            comparisons = [
                compare_with_prediction(
                    a[: load.size], torque=load, per_torque=predicted.get(g.name, np.nan)
                )
                for g, a in zip(plan.gauges, order2, strict=True)
            ]
    pairs = coinciding_orders(how.sources, times=time, resolution=1 / how.decomposer.span)
    doubts = [
        DOUBT_ORDERS_COINCIDE.with_values(
            one=a.cause, order=a.component.order, other=b.cause, second=b.component.order,
            share=share,
        )
        for a, b, share in pairs
    ]  # fmt: skip
    evidence = joints.joint_attributions()
    doubt = _speed_doubt(joints.angle, joints.engine, time, step=how.decomposer.span)
    if doubt is not None:
        evidence = [one.undetermined(doubt) for one in evidence]
    if joints.engine is None:
        doubts.append(DOUBT_ENGINE_SPEED_NOT_GIVEN)
    elif (share := _direct_gear_share(shaft, joints.engine, time)) > 0.2 and not engine_orders:
        doubts.append(DOUBT_ENGINE_AT_SHAFT_SPEED.with_values(share=share))
    if torque is None:
        doubts.append(DOUBT_TORQUE_NOT_GIVEN)
    return DamageCausesByGauge(
        gauges=tuple(g.name for g in plan.gauges),
        attributions=found,
        joint_attributions=evidence,
        cycles_without_joints=[one.cycles() for one in joints.without],
        time=time,
        speed=shaft.speed(time),
        order2=order2,
        torque=load,
        comparisons=comparisons,
        doubts=doubts,
    )


MIN_TURNING_TIME_S = 2.0
"""Seconds that a shaft has to turn for, if anything is to be locked to it."""


MAX_UNKNOWN_SPEED_TIME_SHARE = 1 / 3
"""Share of the time under way without a speed, in which any cause may have done the damage."""


MIN_GEAR_RATIO = 0.6
"""Fewest engine turns per shaft turn in any gear; the vehicle may roll out of gear."""


def _speed_doubt(
    shaft: ShaftAngle, engine: ShaftRotation | None, time: FloatArray, *, step: float
) -> Finding | None:
    """Return why a speed cannot be the shaft's, as it is at times (n,) s, each for a step."""
    speed, below = shaft.rotation.speed(time), shaft.is_negative(time)
    moving = speed > 1
    if below.any() and np.mean(below[moving | below]) > MAX_UNKNOWN_SPEED_TIME_SHARE:
        return DOUBT_NEGATIVE_SPEED
    if shaft.unknown_speed_share > MAX_UNKNOWN_SPEED_TIME_SHARE:
        return DOUBT_SPEED_MISSING
    if moving.sum() * step < MIN_TURNING_TIME_S:
        return DOUBT_SHAFT_STOPPED
    if (
        engine is not None
        and np.mean(engine.speed(time)[moving] < MIN_GEAR_RATIO * speed[moving]) > 0.5
    ):
        return DOUBT_SPEEDS_SWAPPED
    return None


def _direct_gear_share(shaft: ShaftRotation, engine: ShaftRotation, time: FloatArray) -> float:
    """Share of the time under way in which engine and shaft turn as one, the gear direct."""
    own, other = shaft.speed(time), engine.speed(time)
    moving = own > 1
    return float(np.mean(np.abs(own - other)[moving] < 0.25)) if moving.any() else 0.0


_Float32Array: TypeAlias = npt.NDArray[np.float32]


class _JointContribution:
    """The joints' part of every gauge, identified stretch by stretch as the stress passes."""

    def __init__(
        self,
        plan: AssessmentSettings,
        recording: Recording,
        angle: ShaftAngle,
        torque: tuple[str, float] | None,
        how: SourceSeparation,
        engine_orders: Sequence[float],
    ) -> None:
        self.plan, self.recording, self.angle, self.torque = plan, recording, angle, torque
        engine = [s.component for s in how.sources if s.cause == CAUSE_ENGINE]
        self.engine = engine[0].rotation if engine else None
        wheel = [s.component for s in how.sources if s.cause == CAUSE_ROAD]
        self.wheel = wheel[0].rotation if wheel else None
        self.engine_orders = tuple(engine_orders) or (
            *SIX_CYLINDER_FIRING_ORDERS,
            FOUR_CYLINDER_FIRING_ORDER,
        )
        self.told: list[list[tuple[JointAttribution, float]]] = [[] for _ in plan.gauges]
        self.held: list[tuple[int, _Float32Array, _Float32Array]] = []
        self.without = [CycleCounter(plan, recording.rate) for _ in plan.gauges]

    def damage(self, stress: FloatArray) -> float:
        """Damage of a stretch of stress (n,)."""
        plan = self.plan
        return damage_with_omission(
            stress, rule=plan.residue_rule, curve=plan.curve, correction=plan.correction
        )

    def remove_joints(self, stress: Iterable[FloatArray]) -> Iterator[FloatArray]:
        """Yield the stress (gauges, n) without their part."""
        rate = self.recording.rate
        size = max(round(JOINT_PART_IDENTIFICATION_BLOCK_S * rate), 1)
        loads: Iterator[FloatArray | None] = repeat(None)
        if self.torque is not None:
            loads = self.recording.pieces([self.torque[0]], size=size)
        start = 0
        for piece, load in zip(rechunk_to_block_size(stress, size=size), loads, strict=False):
            torque = None if load is None or self.torque is None else load[0] * self.torque[1]
            answers = [
                separate_joint_caused_stress(
                    x, rate=rate, angle=self.angle, torque=torque, damage=self.damage,
                    engine=self.engine, engine_orders=self.engine_orders, wheel=self.wheel,
                    start=start / rate,
                )
                for x in piece
            ]  # fmt: skip
            beyond = self.angle.is_beyond_ends((start + np.arange(piece.shape[1])) / rate)
            yield from self._remainder(start, np.where(beyond, np.nan, piece), answers)
            start += piece.shape[1]

    def _remainder(
        self, start: int, piece: FloatArray, answers: list[JointCausedStress]
    ) -> Iterator[FloatArray]:
        """Take a stretch's answers in, and yield what is left of it without their part."""
        for told, answer in zip(self.told, answers, strict=True):
            told.append((answer.attribution, answer.damage))
        # Held until the stretches that follow have passed: seven digits of it are taken off.
        theirs = np.stack([a.stress.astype(np.float32) for a in answers])
        theirs[np.isnan(piece)] = 0.0
        order2 = np.stack([a.order2.astype(np.float32) for a in answers])
        self.held.append((start, theirs, order2))
        left = piece - theirs
        for count, x in zip(self.without, left, strict=True):
            count.update(x)
        del answers, piece, theirs, order2
        for first in range(0, left.shape[1], SAMPLES_PER_BLOCK // 8):
            yield left[
                :, first : first + SAMPLES_PER_BLOCK // 8
            ].copy()  # a view would hold all of it

    def part(self, start: int, n: int) -> "tuple[_Float32Array, _Float32Array]":
        """Return their stress and its order 2 in a stretch that has passed, (gauges, n) each."""
        self.held = [h for h in self.held if h[0] + h[1].shape[1] > start]
        rows = [
            [
                part[:, max(start - first, 0) : max(start + n - first, 0)]
                for part in (theirs, order2)
            ]
            for first, theirs, order2 in self.held
        ]
        theirs, order2 = (np.concatenate(parts, axis=-1) for parts in zip(*rows, strict=True))
        return theirs, order2

    def joint_attributions(self) -> list[JointAttribution]:
        """Return what they are answerable for, one a gauge."""
        return [
            combine_attributions([e for e, _ in told], [w for _, w in told]) for told in self.told
        ]


def channel_means_per_time_span(
    recording: Recording, channel: str, *, how: SourceSeparation
) -> FloatArray:
    """Mean of a channel over each span of a splitter, (spans,)."""
    n = how.decomposer.span_samples
    means: list[FloatArray] = []
    for piece in recording.pieces([channel], size=n * 64):
        x = piece[0]
        if x.size % n:
            x = np.concatenate([x, np.full(n - x.size % n, np.nan)])
        rows = x.reshape(-1, n)
        some = ~np.isnan(rows).all(-1)
        mean = np.full(len(rows), np.nan)
        mean[some] = np.nanmean(rows[some], axis=-1)
        means.append(mean)
    return np.concatenate(means) if means else EMPTY_REVERSALS
