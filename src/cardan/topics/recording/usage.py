"""Where and when a recording did its damage, and what it comes to in the long run."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.units import rpm
from cardan.physics.signals.assessment import AssessmentSettings, GaugeAssessment
from cardan.physics.signals.damage_extrapolation import LongTermDamage, extrapolate_damage
from cardan.physics.signals.order_tracking import ShaftRotation
from cardan.physics.signals.shaft_angle import ShaftAngle, estimate_gear_ratios
from cardan.physics.signals.usage_profile import (
    INTERVAL_S,
    UsageBin,
    UsageHistory,
    accelerated_test_time_share,
    band_labels,
    damage_by_bin,
    damage_equivalent_stress_amplitude,
    stress_peaks,
)

SPEED_BAND_WIDTH_REV_S, TORQUE_BAND_WIDTH_NM = 250 * rpm / (2 * np.pi), 500.0
"""Width of the bands that damage is reported in, turns/s and N m."""

SHORTENED_TEST_DAMAGE_SHARE = 0.95
"""Share of the damage that a shortened test keeps."""

MAX_TORQUE_GAP_S = 1.0
"""Seconds from the next value of a torque beyond which none is assigned."""

GEAR_SAMPLING_RATE_HZ = 10
"""Times a second at which it is known what gear was in."""


@dataclass(frozen=True)
class StressPeakWithOperatingState:
    """A largest stress: Pa, s, m since the start, turns/s, N m, ratio of the gear; nan unknown.

    Speed, torque and gear are those at its own time.
    """

    stress: float
    time: float
    distance: float
    speed: float
    torque: float
    gear: str


@dataclass(frozen=True, kw_only=True)
class UsageDamage:
    """One gauge's damage by what was driven.

    Attributes
    ----------
    gauge
        Its name.
    bins
        Damage by "gear", "speed" and "torque", where these are known: of each second by its mean
        speed, and by torque and gear when its stress was farthest from its level.
    unassigned
        By the same, damage of the seconds that are in none of these groups.
    residue_share
        Share of the damage that is of the open residue, of no second.
    residue_damage
        What that is; with `bins` and `unassigned` it is the whole damage.
    stress_peaks
        The largest stresses.
    long_run
        The damage rate as recorded and in the long run.
    shortened_test_share
        Share of the time that a test takes which does `SHORTENED_TEST_DAMAGE_SHARE` of the damage.
    equivalent_amplitude : Pa
        Of a test of as many cycles as the S-N curve's knee that does a recording's damage.
    """

    gauge: str
    bins: Mapping[str, list[UsageBin]]
    unassigned: Mapping[str, UsageBin]
    residue_share: float
    residue_damage: float
    stress_peaks: list[StressPeakWithOperatingState]
    long_run: LongTermDamage
    shortened_test_share: float
    equivalent_amplitude: float


def damage_by_usage(
    found: Iterable[UsageHistory],
    lives: Sequence[GaugeAssessment],
    *,
    count: int,
    plan: AssessmentSettings,
    angle: ShaftAngle | None,
    engine: ShaftRotation | None,
    torque: tuple[FloatArray, float] | None,
    per_turn: float,
    begins: float = 0.0,
    held: bool = True,
    second: float = INTERVAL_S,
) -> tuple[UsageDamage, ...]:
    """Return the damage of gauges by what was driven.

    Parameters
    ----------
    found, lives
        Of the gauges that said something; one after the other, in the memory of one.
    count
        Length of each interval, in seconds.
    angle, engine
        Of the shaft, and what the engine turns, where they are known. No band, place or gear is
        reported if the shaft's speed is unknown.
    torque : (n,) N m and Hz
        As it was read.
    per_turn : m
        Way of the vehicle for a turn of the shaft; nan where unknown.
    begins : s
        Where the recording does on the clock of its file, by which times are given.
    held
        Whether the way there is counted with the neighbouring speed; unknown otherwise.
    second : s
        How long each interval lasts.
    """
    driven = _DriveConditions(count, second, angle, engine, torque)
    metres = None if driven.turns is None or np.isnan(per_turn) else driven.turns * per_turn
    if metres is not None and not held:
        metres[driven.unknown] = np.nan
    way = None if metres is None else np.append(0.0, np.cumsum(metres))

    def gone(time: float) -> float:
        if way is None:
            return np.nan
        return float(np.interp(time, second * np.arange(count + 1), way))

    def told(one: UsageHistory, life: GaugeAssessment) -> UsageDamage:
        n = one.damage.size
        sorts = {
            name: damage_by_bin(one, sort[:n], metres=None if metres is None else metres[:n])
            for name, sort in driven.sorts(one.time_of_max_deviation).items()
        }
        largest = stress_peaks(one)
        when: FloatArray = np.array([p.time for p in largest], float)
        beside = zip(
            largest, driven.speed_at(when), driven.torque_at(when), driven.gear_at(when),
            strict=True,
        )  # fmt: skip
        return UsageDamage(
            gauge=life.name,
            bins={name: [g for g in groups if g.name] for name, groups in sorts.items()},
            unassigned={
                name: next((g for g in groups if not g.name), EMPTY_USAGE_BIN)
                for name, groups in sorts.items()
            },
            residue_share=one.total_open_damage / one.total_damage if one.total_damage else 0.0,
            residue_damage=one.total_open_damage,
            stress_peaks=[
                StressPeakWithOperatingState(
                    p.stress, begins + p.time, gone(p.time), float(speed), float(load), gear
                )
                for p, speed, load, gear in beside
            ],
            # Of a life: its crests between samples, and its valid time without what is frozen.
            long_run=extrapolate_damage(
                one, curve=plan.curve, spoiled=life.vetoed
            ).scaled_to_recorded_rate(life.life.damage / max(life.life.duration, 1e-9)),
            shortened_test_share=accelerated_test_time_share(
                one,
                keep=SHORTENED_TEST_DAMAGE_SHARE,
                curve=plan.curve,
                correction=plan.correction,
                rule=plan.residue_rule,
            ),
            equivalent_amplitude=damage_equivalent_stress_amplitude(
                one.total_damage, cycles=plan.curve.cycles, curve=plan.curve
            )
            if one.total_damage > 0
            else 0.0,
        )

    return tuple(map(told, found, lives))  # which releases each before the next


EMPTY_USAGE_BIN = UsageBin("", 0.0, 0.0, 0.0, 0.0, 0.0)
"""What is in no group where every second is in one."""


class _DriveConditions:
    """What was driven at any time: some numbers for each second of it."""

    def __init__(
        self, count: int, second: float, angle: ShaftAngle | None, engine: ShaftRotation | None,
        torque: tuple[FloatArray, float] | None,
    ) -> None:  # fmt: skip
        middle: FloatArray = np.asarray(second * (np.arange(count) + 0.5), float)
        self.angle, self.middle = angle, middle
        self.unknown = np.zeros(count, bool) if angle is None else angle.is_unknown(middle)
        self.turns: FloatArray | None = None
        self.speed = np.full(count, np.nan)
        self.names, self.codes, self.often = (
            [""],
            np.zeros(1, np.intp),
            GEAR_SAMPLING_RATE_HZ / second,
        )
        if angle is not None:
            self.turns = np.diff(angle.rotation.at(second * np.arange(count + 1.0)))
            self.speed = np.where(self.unknown, np.nan, self.turns / second)
        if angle is not None and engine is not None:
            at: FloatArray = np.asarray(
                (np.arange(count * GEAR_SAMPLING_RATE_HZ) + 0.5) / self.often, float
            )
            ratio = estimate_gear_ratios(angle.rotation, engine, at)
            ratio[angle.is_unknown(at)] = np.nan
            known = ~np.isnan(ratio)
            told, place = np.unique(ratio[known].round(9), return_inverse=True)  # few: gears
            self.names = ["", *(f"{r:.3g}" for r in told)]
            self.codes = np.zeros(at.size, np.intp)
            self.codes[known] = place + 1
        self.read, self.at, self.alone = np.empty(0), np.empty(0), MAX_TORQUE_GAP_S
        if torque is not None:
            read, often = torque
            known = ~np.isnan(read)
            self.read, self.at = read[known], np.flatnonzero(known) / often
            self.alone = max(MAX_TORQUE_GAP_S, 1 / often)

    def speed_at(self, time: FloatArray) -> FloatArray:
        """Return the shaft's speed (n,) turns/s at times (n,) s."""
        if self.angle is None:
            return np.full(time.size, np.nan)
        return np.where(self.angle.is_unknown(time), np.nan, self.angle.rotation.speed(time))

    def torque_at(self, time: FloatArray) -> FloatArray:
        """Return the torque (n,) N m at times (n,) s."""
        if not self.at.size:
            return np.full(time.size, np.nan)
        load = np.interp(time, self.at, self.read)
        load[_far(time, self.at) > self.alone] = np.nan
        return load

    def gear_at(self, time: FloatArray) -> list[str]:
        """Return the gear's name at each time (n,) s, "" in none."""
        place = np.nan_to_num(time * self.often).astype(np.intp).clip(0, self.codes.size - 1)
        there = np.where(np.isnan(time), 0, self.codes[place])
        return [self.names[k] for k in there.tolist()]

    def sorts(self, time: FloatArray) -> dict[str, list[str]]:
        """Name the sort of each second (n,), with torque and gear at a time (n,) s within it."""
        found: dict[str, list[str]] = {}
        # How it was driven is reported for what was not recorded, too.
        time = np.where(np.isnan(time), self.middle[: time.size], time)
        if any(self.names):
            found["gear"] = self.gear_at(time)
        if self.angle is not None:
            found["speed"] = [
                _scaled(b, 60.0) for b in band_labels(self.speed, step=SPEED_BAND_WIDTH_REV_S)
            ]
        if self.at.size:
            found["torque"] = band_labels(self.torque_at(time), step=TORQUE_BAND_WIDTH_NM)
        return found


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
