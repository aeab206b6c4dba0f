"""Where and when a recording did its damage, and what it comes to in the long run."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.units import rpm
from cardan.fatigue.angle import Angle, gear_ratios
from cardan.fatigue.life import GaugeLife, Plan
from cardan.fatigue.long_run import LongRun, long_run
from cardan.fatigue.orders import Rotation
from cardan.fatigue.usage import (
    Group,
    Usage,
    bands,
    equal_amplitude,
    grouped,
    peaks,
    shortened,
)

SPEED, TORQUE = 250 * rpm / (2 * np.pi), 500.0
"""Width of the bands that damage is told in, turns/s and N m."""

KEPT = 0.95
"""Share of the damage that a shortened test keeps."""

ALONE = 1.0
"""Seconds from the next value of a torque beyond which none is told."""


@dataclass(frozen=True)
class Place:
    """A largest stress: Pa, s, m since the start, turns/s, N m, ratio of the gear; nan unknown."""

    stress: float
    time: float
    way: float
    speed: float
    torque: float
    gear: str


@dataclass(frozen=True, kw_only=True)
class Used:
    """One gauge's damage by what was driven.

    Attributes
    ----------
    gauge
        Its name.
    groups
        Damage by "gear", "speed" and "torque", where these are known.
    open
        Share of the damage that is of the open residue, of no second.
    places
        The largest stresses.
    long_run
        The damage rate as recorded and in the long run.
    shortened
        Share of the time that a test takes which does `KEPT` of the damage.
    amplitude : Pa
        Of a test of as many cycles as the S-N curve's knee that does a recording's damage.
    """

    gauge: str
    groups: Mapping[str, list[Group]]
    open: float
    places: list[Place]
    long_run: LongRun
    shortened: float
    amplitude: float


def used(
    found: Iterable[Usage], lives: Sequence[GaugeLife], *, count: int, plan: Plan,
    angle: Angle | None, engine: Rotation | None, torque: tuple[FloatArray, float] | None,
    per_turn: float, begins: float = 0.0, held: bool = True,
) -> tuple[Used, ...]:  # fmt: skip
    """Return the damage of gauges by what was driven.

    Parameters
    ----------
    found, lives
        Of the gauges that said something; one after the other, in the memory of one.
    count
        Seconds that each tells apart.
    angle, engine
        Of the shaft, and what the engine turns, where they are known. No band, place or gear is
        told where nothing says the shaft's speed.
    torque : (n,) N m and Hz
        As it was read.
    per_turn : m
        Way of the vehicle for a turn of the shaft; nan where nobody knows.
    begins : s
        Where the recording does on the clock of its file, by which times are told.
    held
        Whether the way there is counted with the speed beside it; unknown otherwise.
    """
    middle: FloatArray = np.asarray(np.arange(count) + 0.5, float)
    shaft = None if angle is None else angle.rotation
    speed = np.full(count, np.nan) if shaft is None else shaft.speed(middle)
    turns = None if shaft is None else np.diff(shaft.at(np.arange(count + 1.0)))
    unknown = np.zeros(count, bool) if angle is None else angle.unsaid(middle)
    speed[unknown] = np.nan
    metres = None if turns is None or np.isnan(per_turn) else turns * per_turn
    if metres is not None and not held:
        metres[unknown] = np.nan
    load = np.full(count, np.nan)
    if torque is not None:
        read, often = torque
        known = ~np.isnan(read)
        if known.any():
            at = np.arange(read.size) / often
            load = np.interp(middle, at[known], read[known])
            load[_far(middle, at[known]) > max(ALONE, 1 / often)] = np.nan
    gear = [""] * count
    if shaft is not None and engine is not None:
        gear = ["" if np.isnan(r) else f"{r:.3g}" for r in gear_ratios(shaft, engine, middle)]
        gear = ["" if out else name for name, out in zip(gear, unknown, strict=True)]
    sorts: dict[str, list[str]] = {}
    if any(gear):
        sorts["gear"] = gear
    if shaft is not None:
        sorts["speed"] = [_scaled(b, 60.0) for b in bands(speed, step=SPEED)]
    if not np.isnan(load).all():
        sorts["torque"] = bands(load, step=TORQUE)
    way = None if metres is None else np.append(0.0, np.cumsum(metres))

    def gone(time: float) -> float:
        return np.nan if way is None else float(np.interp(time, np.arange(count + 1), way))

    def told(one: Usage, life: GaugeLife) -> Used:
        n = one.damage.size
        whole = float(one.damage.sum()) + one.open

        def placed(time: float) -> int:
            return min(int(time), n - 1)

        return Used(
            gauge=life.name,
            groups={
                name: grouped(one, sort[:n], metres=None if metres is None else metres[:n])
                for name, sort in sorts.items()
            },
            open=one.open / whole if whole else 0.0,
            places=[
                Place(
                    p.stress, begins + p.time,
                    gone(p.time),
                    float(speed[placed(p.time)]), float(load[placed(p.time)]),
                    gear[placed(p.time)],
                )
                for p in peaks(one)
            ],
            long_run=long_run(one, curve=plan.curve),
            shortened=shortened(
                one, keep=KEPT, curve=plan.curve, correction=plan.correction, rule=plan.rule
            ),
            amplitude=equal_amplitude(whole, cycles=plan.curve.cycles, curve=plan.curve)
            if whole > 0 else 0.0,
        )  # fmt: skip

    return tuple(map(told, found, lives))  # which lets go of each before it asks for the next


def _far(time: FloatArray, others: FloatArray) -> FloatArray:
    """Return how far times (n,) are from the next of others (m,), which rise."""
    after = np.searchsorted(others, time).clip(1, max(others.size - 1, 1))
    near = others[np.stack([after - 1, np.minimum(after, others.size - 1)])]
    return np.abs(near - time).min(0)


def _scaled(band: str, factor: float) -> str:
    """Return a band's name in another unit."""
    if not band:
        return ""
    low, high = (float(v) * factor for v in band.split(" .. "))
    return f"{low:.4g} .. {high:.4g}"
