"""What turns and twists in a recording: shaft angle, engine, torque, and what a bus left out."""

import math
from dataclasses import dataclass, replace

import numpy as np

from cardan.core.arrays import FloatArray, IntArray
from cardan.core.errors import DesignError
from cardan.physics.signals.channel_units import (
    RADIANS_PER_TURN,
    ROTATION_SPEED_UNITS,
    TORQUE_UNITS,
    VEHICLE_SPEED_UNITS,
)
from cardan.physics.signals.faults.waveform import FAULT_SENTINEL
from cardan.physics.signals.order_tracking import (
    ShaftRotation,
    estimate_rotation_from_vibration,
    rotation_from_pulses,
)
from cardan.physics.signals.recording import Recording, with_gaps_in_channel
from cardan.physics.signals.shaft_angle import (
    J1939_SHAFT_SPEED_SCALING,
    J1939_VEHICLE_SPEED_SCALING,
    ShaftAngle,
    bus_error_runs,
    shaft_angle,
    torque_error_runs,
)
from cardan.topics.recording.channel_reading import (
    channel_unit,
    check_unit_agrees,
    sampled_channel,
    split_unit,
    unit_factor,
)
from cardan.topics.recording.options import AnalysisOptions, parse_rule

MIN_MEASURABLE_TACHO_SPEED_REV_S = 25.0
"""Turns/s that a shaft's tacho must be able to resolve: 1500 rpm."""

MAX_SHAFT_SPEED_REV_S = 200.0
"""Turns a second that no propshaft makes: 12,000 rpm."""


@dataclass(frozen=True, kw_only=True)
class BusErrorValues:
    """A channel of speed or torque in which a bus wrote that it had no value.

    Attributes
    ----------
    channel
        Its name.
    intervals : (k, 2) s
        From when to when, flanks that a faster clock laid between readings among them.
    speed : turns/s
        What it would be as a speed; nan of a torque.
    accepted_count
        How many of them are taken for values all the same, as a rule has it.
    torque : N m
        What it would be as a torque; nan of a speed.
    """

    channel: str
    intervals: FloatArray
    speed: float = math.nan
    accepted_count: int = 0
    torque: float = math.nan


def max_tacho_speed(options: AnalysisOptions, recording: Recording) -> float:
    """Return up to how many turns a second the tacho's pulses are held apart."""
    return recording.rate / 2.5 / options.pulses


def measured_shaft_angle(options: AnalysisOptions, recording: Recording) -> ShaftAngle | None:
    """Return how far the shaft has turned: measured, counted, or found in a gauge.

    Raises
    ------
    DesignError
        If the tacho's pulses come faster than the recording can hold them apart.
    """
    if options.tacho is not None:
        fastest = max_tacho_speed(options, recording)
        if fastest < MIN_MEASURABLE_TACHO_SPEED_REV_S:
            needed_hz = MIN_MEASURABLE_TACHO_SPEED_REV_S * 2.5 * options.pulses
            msg = (
                f"{options.tacho}: {options.pulses} pulses a turn at {recording.rate:g} Hz are "
                f"held apart up to {fastest * 60:.0f} rpm, and no faster turn would show: a "
                f"shaft's tacho needs {needed_hz:g} Hz or a divided pulse"
            )
            raise DesignError(msg)
        counted = rotation_from_pulses(
            recording.pieces([options.tacho]), rate=recording.rate, per_turn=options.pulses
        )
        if (most := _fastest(counted, pulses=options.pulses)) > fastest:
            msg = (
                f"{options.tacho} is read up to {most * 60:.0f} rpm, and {options.pulses} pulses a "
                f"turn at {recording.rate:g} Hz are held apart up to {fastest * 60:.0f} rpm: "
                "what turns faster looks slower; it needs more samples or a divided pulse"
            )
            raise DesignError(msg)
        return ShaftAngle(counted, lag=0.02)
    if options.speed is not None:
        engine = None if options.engine is None else _read_speed(options, recording, options.engine)
        speed, rate = _read_speed(options, recording, options.speed)
        return shaft_angle(speed, rate=rate, engine=engine[0] if engine else None)
    if options.estimate_speed is not None:
        signal = recording.pieces([options.estimate_speed])
        return ShaftAngle(
            estimate_rotation_from_vibration(signal, rate=recording.rate),
            trusted=False,
            measured=False,
        )
    return None


def _read_speed(
    options: AnalysisOptions, recording: Recording, text: str
) -> tuple[FloatArray, float]:
    """Return a channel of speed, turns/s, as it is taken: nan where it has no value."""
    speed, rate, runs = speed_samples(recording, text, wheel=_turns_per_metre(options))
    if not _taken(options, text, runs, rate).size:
        return speed, rate
    for first, last in _taken(options, text, runs, rate):
        speed[first:last] = np.nan
    return speed, rate


def _taken(options: AnalysisOptions, text: str, runs: IntArray, rate: float) -> IntArray:
    """Return those runs of no value that are taken for holes: what no rule accepts."""
    open_ = np.ones(len(runs), bool)
    for rule in options.rules:
        if rule.applies_to(split_unit(text)[0], FAULT_SENTINEL) and rule.kind:
            inside = (runs[:, 0] / rate >= rule.first) & (runs[:, 0] / rate <= rule.last)
            open_[inside] = rule.mask
    return runs[open_]


def bus_error_values(options: AnalysisOptions, recording: Recording) -> tuple[BusErrorValues, ...]:
    """Return the channels in which a bus wrote that it had no value, and where."""
    found: list[BusErrorValues] = []
    for text in (options.speed, options.engine):
        if text is None or (options.tacho is not None and text == options.speed):
            continue
        speed, rate, runs = speed_samples(recording, text, wheel=_turns_per_metre(options))
        if len(runs):
            taken = _taken(options, text, runs, rate)
            top = float(np.nanmax(speed[runs[0, 0] : runs[0, 1]]))
            found.append(
                BusErrorValues(
                    channel=split_unit(text)[0], intervals=runs / rate, speed=top,
                    accepted_count=len(runs) - len(taken),
                )
            )  # fmt: skip
    if (named := torque_channel(options, recording)) is not None:
        values, rate = sampled_channel(recording, named[0])
        runs = torque_error_runs(values, rate=rate)
        if len(runs):
            found.append(
                BusErrorValues(
                    channel=named[0], intervals=runs / rate,
                    torque=float(np.nanmax(values)) * named[1],
                    accepted_count=len(runs)
                    - len(_taken(options, options.torque or "", runs, rate)),
                )
            )  # fmt: skip
    return tuple(found)


def mask_missing_torque(options: AnalysisOptions, recording: Recording) -> Recording:
    """Return a recording whose torque is missing where a bus wrote that it had none."""
    if (named := torque_channel(options, recording)) is None:
        return recording
    values, rate = sampled_channel(recording, named[0])
    taken = _taken(options, options.torque or "", torque_error_runs(values, rate=rate), rate)
    return with_gaps_in_channel(recording, named[0], taken / rate) if len(taken) else recording


def with_alternative_reading(options: AnalysisOptions, of: BusErrorValues) -> AnalysisOptions:
    """Return the campaign with what a bus wrote taken the other way: as speeds, or as none."""
    rule = (f"{of.channel}={FAULT_SENTINEL}",)
    if of.accepted_count:
        return replace(options, accept=tuple(r for r in options.accept if not _sentinel(r)))
    masked = tuple(r for r in options.mask if not r.startswith(rule))
    return replace(options, mask=masked, accept=(*options.accept, *rule))


def _turns_per_metre(options: AnalysisOptions) -> float | None:
    """Shaft turns a metre of the vehicle's way, where the axle and its tyres are given."""
    if options.axle_ratio is None or options.tyre_radius_m is None:
        return None
    return options.axle_ratio / (RADIANS_PER_TURN * options.tyre_radius_m)


def engine_rotation(options: AnalysisOptions, recording: Recording) -> ShaftRotation | None:
    """Return the engine's rotation, where it was measured."""
    if options.engine is None:
        return None
    speed, rate = _read_speed(options, recording, options.engine)
    return shaft_angle(speed, rate=rate).rotation


def torque_channel(options: AnalysisOptions, recording: Recording) -> tuple[str, float] | None:
    """Return the channel of the shaft torque, and N m in its unit."""
    if options.torque is None:
        return None
    channel, given = split_unit(options.torque)
    return channel, unit_factor(recording, channel, given, TORQUE_UNITS)


def read_torque(options: AnalysisOptions, recording: Recording) -> tuple[FloatArray, float]:
    """Return the shaft torque (m,) N m, nan where it has none, and how often it was looked at.

    Raises
    ------
    DesignError
        If no channel of it is named.
    """
    named = torque_channel(options, recording)
    if named is None:
        msg = "no channel of the shaft's torque is named: --torque"
        raise DesignError(msg)
    values, rate = sampled_channel(mask_missing_torque(options, recording), named[0])
    return values * named[1], rate


def _fastest(counted: ShaftRotation, *, pulses: int) -> float:
    """Return how fast a tacho turns at most, turns/s, over a turn or some pulses of it."""
    over = min(max(pulses, 9), counted.time.size - 1)
    return float((over / pulses / (counted.time[over:] - counted.time[:-over])).max())


def _sentinel(rule: str) -> bool:
    """Whether a rule, as it was written, is of sentinels."""
    return parse_rule(rule, mask=False).kind == FAULT_SENTINEL


def speed_samples(
    recording: Recording, text: str, *, wheel: float | None = None
) -> tuple[FloatArray, float, IntArray]:
    """Return a channel of speed in turns/s, as written, and at which rate it was looked at.

    `wheel` is how many turns go to a metre, for a speed of the vehicle. With it the runs (k, 2)
    of samples in which a bus wrote that it had no value.
    """
    channel, given = split_unit(text)
    taken = given or channel_unit(recording.channel(channel))
    check_unit_agrees(recording.channel(channel), taken)
    if taken in VEHICLE_SPEED_UNITS:
        if wheel is None:
            msg = (
                f"{channel}: {taken} is the vehicle's speed; the shaft turns with it by "
                "--axle-ratio and --tyre-radius-m"
            )
            raise DesignError(msg)
        unit = VEHICLE_SPEED_UNITS[taken] * wheel
    else:
        unit = unit_factor(recording, channel, given, ROTATION_SPEED_UNITS)
    values, rate = sampled_channel(recording, channel)
    if taken in VEHICLE_SPEED_UNITS:
        runs = bus_error_runs(
            values * VEHICLE_SPEED_UNITS[taken] * 3.6, rate=rate, of=J1939_VEHICLE_SPEED_SCALING
        )
        values *= unit
    else:
        values *= unit
        runs = bus_error_runs(values * 60, rate=rate, of=J1939_SHAFT_SPEED_SCALING)
    _turning(channel, values, taken or "")
    return values, rate, runs


def _turning(channel: str, speed: FloatArray, unit: str) -> None:
    """Refuse a speed (n,) turns/s, half of which no shaft of a vehicle makes."""
    moving = speed[speed > 0]
    typical = float(np.median(moving, overwrite_input=True)) if moving.size else 0.0
    if typical > MAX_SHAFT_SPEED_REV_S:
        msg = (
            f"{channel}: in {unit} it turns at {typical * 60:.4g} rpm, faster than any shaft or "
            f"engine of a vehicle ({MAX_SHAFT_SPEED_REV_S * 60:g} rpm); its unit is another"
        )
        raise DesignError(msg)


MAX_TACHO_LAG_S = 0.05
"""Largest lag, s, of an angle that was counted by a tacho and not integrated."""
