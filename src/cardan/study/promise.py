"""What a changed line promises: the damage of a recording had it been driven with that line.

What was recorded stays as it is, road, engine and all, but for the joints' force on the
bearing: that of the line as it was identified is taken off, that of the changed line driven at
the same torque and speed is put on, each through the stress that a unit force was found to make
at the gauge. Held against a multibody engine that drives the changed line: `docs/case.md`.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.fatigue.damage import Life
from cardan.fatigue.life import GaugeLife, Plan
from cardan.fatigue.orders import Rotation
from cardan.fatigue.usage import usage
from cardan.model.application import Application
from cardan.study.identification import Identification, load_history


@dataclass(frozen=True, kw_only=True)
class Promised:
    """One gauge, as recorded and as the changed line would have it."""

    gauge: str
    recorded: Life
    changed: Life


def promised(
    of: Identification, changed: Application, stress: Iterable[FloatArray], *, rate: float,
    rotation: Rotation, torque: tuple[FloatArray, float], seconds: float,
    plan: Plan, lives: Sequence[GaugeLife],
) -> tuple[Promised, ...]:  # fmt: skip
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
        The drive, as `load_history` takes it.
    plan, lives
        How cycles count, and what they came to as recorded.

    Raises
    ------
    DesignError
        If the changed line is not on rubber, or has no such state or bearing.
    """
    time, was = load_history(of, rotation, torque, seconds=seconds)
    _, then = load_history(of, rotation, torque, seconds=seconds, application=changed)
    units = of.units[[of.gauges.index(g.name) for g in plan.gauges]]
    moved = units @ (then - was).T

    def felt() -> Iterator[FloatArray]:
        done = 0
        for piece in stress:
            at = (done + np.arange(piece.shape[-1])) / rate
            done += piece.shape[-1]
            yield piece + np.stack([np.interp(at, time, row) for row in moved])

    counted = usage(felt(), rate=rate, curve=plan.curve, correction=plan.correction, rule=plan.rule)
    return tuple(
        Promised(
            gauge=g.name, recorded=one.life,
            changed=replace(one.life, damage=float(u.damage.sum() + u.open)),
        )
        for g, one, u in zip(plan.gauges, lives, counted, strict=True)
    )  # fmt: skip
