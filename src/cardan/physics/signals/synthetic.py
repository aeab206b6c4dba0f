"""Synthetic recordings with known truth. Not measurements: every one says so in its name.

A truck drives a random route: speed in phases, gears, torque from acceleration, grade and
drag. Its bracket gauges feel the driving torque, unbalance (order 1, with speed squared),
joints (orders 2 and 4, with torque), engine orders, wheels, road roughness and events, each
by a gain the caller chooses, so the cause of damage is known beforehand.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.units import MPa
from cardan.physics.signals.conditioning import low_pass
from cardan.physics.signals.damage_attribution import (
    CAUSE_ENGINE,
    CAUSE_JOINTS,
    CAUSE_REMAINDER,
    CAUSE_ROAD,
    CAUSE_SLOW_LOAD,
    CAUSE_SUDDEN_EVENTS,
    CAUSE_UNBALANCE,
)
from cardan.physics.signals.order_tracking import ShaftRotation
from cardan.physics.signals.recording import Recording, recording_from_arrays

GEARBOX_RATIOS = (6.4, 3.6, 2.1, 1.37, 1.0)
AXLE_RATIO = 4.3
TYRE_RADIUS_M = 0.5
"""Metres; with the axle ratio a shaft speed of 38 turns/s at 100 km/h."""


@dataclass(frozen=True, kw_only=True)
class GaugeStressPerCause:
    """How much stress each cause makes at one gauge, Pa 0-to-peak unless said otherwise.

    Attributes
    ----------
    load : Pa
        At 10 kN m of shaft torque.
    unbalance : Pa
        Order 1 at 50 turns/s; grows with speed squared.
    joints : Pa
        Order 2 at 10 kN m; grows with torque.
    order4_share : 1
        Order 4 as a share of order 2.
    engine : Pa
        Order n/2 at full torque.
    wheel : Pa
        Wheel order 1 at 20 m/s.
    road : Pa rms
        Random, 1.5 to 20 Hz, at 20 m/s; grows with the root of speed.
    events : Pa
        Typical peak of a pothole.
    noise : Pa rms
        White.
    """

    load: float = 25 * MPa
    unbalance: float = 3 * MPa
    joints: float = 6 * MPa
    order4_share: float = 0.05
    engine: float = 2 * MPa
    wheel: float = 2 * MPa
    road: float = 6 * MPa
    events: float = 60 * MPa
    noise: float = 0.3 * MPa


@dataclass(frozen=True)
class SyntheticRecording:
    """A made-up recording and the truth behind it.

    Attributes
    ----------
    recording
        Gauges in MPa, `shaft_speed` and `engine_speed` in rpm, `torque` in kN m, a `tacho`
        with one pulse a turn, `speed` in km/h.
    parts
        Stress of each gauge by cause, (gauges, n) Pa.
    shaft, engine
        True rotations.
    torque : (n,) N m
        At the shaft.
    """

    recording: Recording
    parts: Mapping[str, FloatArray] = field(repr=False)
    shaft: ShaftRotation
    engine: ShaftRotation
    torque: FloatArray = field(repr=False)


def synthetic_recording(
    *,
    seconds: float = 600.0,
    rate: float = 1000.0,
    gains: Mapping[str, GaugeStressPerCause] | None = None,
    cylinders: int = 6,
    events_per_hour: float = 60.0,
    seed: int = 0,
) -> SyntheticRecording:
    """Make a synthetic recording of a truck on a route.

    Parameters
    ----------
    seconds, rate
        Length s and samples a second Hz.
    gains
        By gauge name; S1 with the usual gains unless given.
    cylinders
        Of a four-stroke engine: order cylinders/2 and its double.
    events_per_hour
        Mean number of potholes.
    seed
        Everything random follows from it.
    """
    rng = np.random.default_rng(seed)
    gains = {"S1": GaugeStressPerCause()} if gains is None else gains
    n = round(seconds * rate)
    t = np.arange(n) / rate
    v = _route(rng, t)
    shaft_speed = v / (2 * np.pi * TYRE_RADIUS_M) * AXLE_RATIO
    gear = _gear(shaft_speed, rate)
    engine_speed = np.maximum(shaft_speed * gear, 10.0)
    torque = _torque(rng, t, v, rate)
    turned, engine_turned = (np.cumsum(s) / rate for s in (shaft_speed, engine_speed))
    share = torque / 10e3
    order = cylinders / 2
    starts = np.sort(rng.uniform(0, seconds, rng.poisson(events_per_hour * seconds / 3600)))
    blows = _unit_impacts(rng, t, starts, rate) * (v > 1)
    wheel_turned = turned / AXLE_RATIO
    parts: dict[str, list[FloatArray]] = {
        name: []
        for name in (
            CAUSE_SLOW_LOAD,
            CAUSE_UNBALANCE,
            CAUSE_JOINTS,
            CAUSE_ENGINE,
            CAUSE_ROAD,
            CAUSE_SUDDEN_EVENTS,
            CAUSE_REMAINDER,
        )
    }
    for gain in gains.values():
        phase = 2 * np.pi * rng.uniform(size=6)
        rough = _road(rng, n, rate)

        def tone(turns: FloatArray, k: float, shift: float) -> FloatArray:
            return np.cos(2 * np.pi * k * turns + shift)

        parts[CAUSE_SLOW_LOAD].append(gain.load * share)
        parts[CAUSE_UNBALANCE].append(
            gain.unbalance * (shaft_speed / 50) ** 2 * tone(turned, 1, phase[0])
        )
        joints = tone(turned, 2, phase[1]) + gain.order4_share * tone(turned, 4, phase[2])
        parts[CAUSE_JOINTS].append(gain.joints * share * joints)
        firing = tone(engine_turned, order, phase[3]) + 0.3 * tone(
            engine_turned, 2 * order, phase[4]
        )
        parts[CAUSE_ENGINE].append(gain.engine * np.abs(share) * firing)
        parts[CAUSE_ROAD].append(
            gain.road * np.sqrt(v / 20) * rough
            + gain.wheel * np.minimum(v / 20, 2) * tone(wheel_turned, 1, phase[5])
        )
        parts[CAUSE_SUDDEN_EVENTS].append(gain.events * blows)
        parts[CAUSE_REMAINDER].append(gain.noise * rng.normal(size=n))
    truth = {cause: np.stack(found) for cause, found in parts.items()}
    stress = np.sum(list(truth.values()), axis=0)
    channels = np.concatenate(
        [
            stress / MPa,
            [shaft_speed * 60, engine_speed * 60, torque / 1e3, (turned % 1 < 0.2) * 5.0, v * 3.6],
        ]
    ).astype(float)
    recording = recording_from_arrays(
        channels,
        rate=rate,
        names=[*gains, "shaft_speed", "engine_speed", "torque", "tacho", "speed"],
        units=[*["MPa"] * len(gains), "rpm", "rpm", "kNm", "V", "km/h"],
        name=f"synthetic route (seed {seed})",
        notes=("synthetic: made by a generator, not measured",),
    )
    every = max(round(0.005 * rate), 1)
    return SyntheticRecording(
        recording=recording,
        parts=truth,
        shaft=ShaftRotation(t[::every], turned[::every]),
        engine=ShaftRotation(t[::every], engine_turned[::every]),
        torque=torque,
    )


def _smooth(x: FloatArray, width: int) -> FloatArray:
    """Return the running mean over `width` samples, twice: no corners, nothing shifted."""
    for _ in range(2):
        padded = np.pad(x, (width // 2, width - width // 2), mode="edge")
        total = np.cumsum(padded)
        x = (total[width:] - total[:-width]) / width
    return x


def _route(rng: np.random.Generator, t: FloatArray) -> FloatArray:
    """Vehicle speed (n,) m/s: targets held for 15 to 60 s, some of them standing."""
    rate = 1 / (t[1] - t[0])
    holds = rng.uniform(15, 60, int(t[-1] / 15) + 2)
    kinds = rng.choice([0, 8, 14, 20, 25], size=holds.size, p=[0.12, 0.18, 0.2, 0.3, 0.2])
    target = np.where(kinds > 0, kinds + rng.normal(0, 1.5, holds.size), 0.0)
    held = target[np.searchsorted(np.cumsum(holds), t)]
    return np.maximum(_smooth(held, int(6 * rate)), 0)


def _gear(shaft_speed: FloatArray, rate: float) -> FloatArray:
    """Gear ratio (n,): the tallest that keeps the engine above 18 turns/s, shifts in 0.5 s."""
    ratio = np.full(shaft_speed.shape, GEARBOX_RATIOS[0])
    for g in GEARBOX_RATIOS[1:]:
        ratio = np.where(shaft_speed * g > 18, g, ratio)
    return _smooth(ratio, max(int(0.25 * rate), 2))


def _torque(rng: np.random.Generator, t: FloatArray, v: FloatArray, rate: float) -> FloatArray:
    """Shaft torque (n,) N m of a 17 t truck: inertia, drag, rolling, hills; overrun too."""
    grade = _smooth(rng.normal(0, 0.02, t.size // int(20 * rate) + 2)[
        (t / 20).astype(int)
    ], int(10 * rate))  # fmt: skip
    force = 17e3 * (np.gradient(v, t) + 9.81 * (0.007 + grade)) + 3.5 * v**2
    force = np.clip(np.where(v > 0.2, force, 0.0), -20e3, 70e3)
    return _smooth(force * TYRE_RADIUS_M / AXLE_RATIO, int(0.3 * rate))


def _road(rng: np.random.Generator, n: int, rate: float) -> FloatArray:
    """Random vibration (n,) of unit rms, 1.5 to 20 Hz, falling with frequency."""
    f = np.fft.rfftfreq(n, 1 / rate)
    shape = np.where((f > 1.5) & (f < 20), 1 / np.maximum(f, 1.0), 0.0)
    x = np.fft.irfft(shape * (rng.normal(size=f.size) + 1j * rng.normal(size=f.size)), n)
    return x / x.std()


def _unit_impacts(
    rng: np.random.Generator, t: FloatArray, starts: FloatArray, rate: float
) -> FloatArray:
    """Return unit blows (n,): damped swings of 8 to 14 Hz, sizes lognormal about one."""
    out = np.zeros_like(t)
    for start in starts:
        size = np.exp(rng.normal(0, 0.3)) * rng.choice([-1, 1])
        f = rng.uniform(8, 14)
        k = slice(int(start * rate), int((start + 0.6) * rate))
        s = t[k] - start
        out[k] += size * np.exp(-8 * s) * np.sin(2 * np.pi * f * s) * (s >= 0)
    smooth = low_pass(min(60.0, 0.4 * rate), rate=rate)
    return smooth.apply(np.pad(out, smooth.reach))
