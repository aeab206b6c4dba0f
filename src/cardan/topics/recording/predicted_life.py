"""What a changed line promises: the damage of a recording had it been driven with that line.

What was recorded stays as it is, road, engine and all, but for the joints' force on the
bearing: that of the line as it was identified is taken off, that of the changed line driven at
the same torque and speed is put on, each through the stress that a unit force was found to make
at the gauge. Held against a multibody engine that drives the changed line: `docs/case.md`.

The force on the bearing (`bearing_force_history`) is computed the same way: the joints' by the
line, the rest read back from the gauges. By the joints alone a bend whose joints are cured was
promised 31 000 hours where it has 10 440: at a slope of 9 a little road on what is left of order 2
counts thrice.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.model.application import Application
from cardan.physics.fatigue.damage import LifeEstimate
from cardan.physics.fem.strain_gauges import MIN_SENSITIVITY_SHARE_OF_STRONGEST_LOAD
from cardan.physics.signals.assessment import AssessmentSettings, GaugeAssessment
from cardan.physics.signals.order_tracking import ShaftRotation
from cardan.physics.signals.usage_profile import usage_histories
from cardan.topics.recording.identification_result import IdentificationResult

MAX_HISTORY_RATE_HZ = 500.0
"""Samples a second that a history has at most: those of a mode of 60 Hz miss 2 % of its crests."""


@dataclass(frozen=True, kw_only=True)
class PredictedLife:
    """One gauge, as recorded and as the changed line would have it."""

    gauge: str
    recorded: LifeEstimate
    changed: LifeEstimate


def predict_life(
    of: IdentificationResult, changed: Application, stress: Iterable[FloatArray], *, rate: float,
    rotation: ShaftRotation, torque: tuple[FloatArray, float], seconds: float,
    plan: AssessmentSettings, lives: Sequence[GaugeAssessment],
) -> tuple[PredictedLife, ...]:  # fmt: skip
    """Return what gauges would have felt of a changed line, and how long they would live.

    Parameters
    ----------
    of
        What the recording says of the line that was driven.
    changed
        The line as it would be, with a state of the same name.
    stress : (gauges, n) Pa
        Pieces of what was recorded, from the start, of the plan's gauges.
    rate : Hz
        Of its samples.
    rotation, torque, seconds
        The drive, as `bearing_force_history` takes it.
    plan, lives
        How cycles count, and what they came to as recorded.

    Raises
    ------
    DesignError
        If the changed line is not on rubber, or has no such state or bearing.
    """
    from cardan.topics.recording.identified_force import bearing_force_over_time

    drive = partial(bearing_force_over_time, of, rotation, torque, seconds=seconds)
    was, then = drive(), drive(application=changed)
    units = of.unit_stress[[of.gauges.index(g.name) for g in plan.gauges]]

    def felt() -> Iterator[FloatArray]:
        """Yield what was recorded, and below it what would have been."""
        done = 0
        for piece in stress:
            at = (done + np.arange(piece.shape[-1])) / rate
            done += piece.shape[-1]
            yield np.concatenate([piece, piece + units @ (then(at) - was(at)).T])

    counted = usage_histories(
        felt(), rate=rate, curve=plan.curve, correction=plan.correction, rule=plan.residue_rule
    )
    damage = np.array([u.damage.sum() + u.total_open_damage for u in counted]).reshape(2, -1)
    # As recorded crests may count that lie between samples: as a share of it nothing is gained.
    more = np.divide(damage[1], damage[0], out=np.ones_like(damage[1]), where=damage[0] > 0)
    return tuple(
        PredictedLife(
            gauge=g.name, recorded=one.life,
            changed=replace(one.life, damage=one.life.damage * m if d > 0 else float(would)),
        )
        for g, one, m, d, would in zip(plan.gauges, lives, more.tolist(), *damage, strict=True)
    )  # fmt: skip


def bearing_force_history(
    of: IdentificationResult, stress: Iterable[FloatArray], *, rate: float, rotation: ShaftRotation,
    torque: tuple[FloatArray, float], seconds: float, application: Application | None = None,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Force on the bearing over a recording, (n,) s and (n, 3) N, vehicle axes: all that shakes it.

    The joints' is that of the line as it was identified, or of another one driven so. What gauges
    feel in addition to the joints, road, engine and what is unbalanced, is the least force that
    does so, without what is slower than `MAX_SPEED_TO_ANGLE_INTEGRATION_S`: a zero that creeps. A
    gauge that has a hole is taken to have felt what the line says.

    Parameters
    ----------
    stress : (gauges, n) Pa
        Pieces of what was recorded, from the start, of the gauges of `of`.
    rate : Hz
        Of its samples.
    """
    from scipy.ndimage import uniform_filter1d

    from cardan.topics.recording.bearing_model import MAX_SPEED_TO_ANGLE_INTEGRATION_S
    from cardan.topics.recording.identified_force import joint_force_history

    step = max(1, round(rate / MAX_HISTORY_RATE_HZ))
    drive = partial(joint_force_history, of, rotation, torque, seconds=seconds, rate=rate / step)
    time, joints = drive()
    felt, back = (
        np.zeros_like(joints),
        np.linalg.pinv(of.unit_stress, rcond=MIN_SENSITIVITY_SHARE_OF_STRONGEST_LOAD),
    )
    done = 0
    for piece in stress:
        first = -(-done // step)
        own = piece[:, first * step - done :: step][:, : max(len(time) - first, 0)]
        here = slice(first, first + own.shape[-1])
        felt[here] = np.nan_to_num(own.T - joints[here] @ of.unit_stress.T) @ back.T
        done += piece.shape[-1]
    slow = uniform_filter1d(
        felt, max(1, round(MAX_SPEED_TO_ANGLE_INTEGRATION_S * rate / step)), axis=0, mode="nearest"
    )
    force = joints if application is None else drive(application=application)[1]
    return time, force + felt - slow
