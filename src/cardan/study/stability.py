"""Ask whether an application vibrates: each gear's speeds against resonances and zones."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields
from itertools import combinations

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.errors import DesignError
from cardan.base.part import Occasion, Part
from cardan.base.units import NewtonMetre
from cardan.base.verdict import Check, Limit
from cardan.demand.states import Demand, demand, resolve
from cardan.dynamics.lateral import flexible_shaft
from cardan.dynamics.periodic import growth
from cardan.dynamics.torsion import (
    TorsionLine,
    about_forced_orbit,
    natural_frequencies,
    of_line,
    orbit,
)
from cardan.model.application import Application, Surroundings
from cardan.model.parts import Line, Shaft
from cardan.study.finding import VIBRATION, Finding, Tell, limits_of, silent

ORDERS = (2, 4)
"""Orders of the turning that joints excite."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Assumed(Surroundings):
    """Surroundings with something assumed wherever nobody knows.

    The gearbox turns uniformly and the pinion is rigid to the axle unless they are given.
    """

    axle_inertia: float = 2.0
    damping_ratio: float = 0.02
    rubber_loss: float = 0.1


@dataclass(frozen=True, kw_only=True)
class Zone:
    """Where twice the speed meets a sum of two torsional frequencies, or one of them twice.

    `modes` count from 1, `speed` is in rad/s, `growth` (states,) in 1/s at the nearest speed
    that a gear reaches.
    """

    modes: tuple[int, int]
    speed: float
    growth: FloatArray

    @property
    def part(self) -> Part:
        """What a check of it is of."""
        return Part("zone", *self.modes)


@dataclass(frozen=True, kw_only=True)
class LineVibration:
    """How one line vibrates.

    Attributes
    ----------
    line, states
        Which line, and the S states it was asked in.
    gears : the G ranges of speed
    ranges : (G, 2) rad/s
    frequencies : (n,) rad/s
        Torsional natural frequencies, rising.
    zones
        Parametric zones of first order.
    speeds : (k,) rad/s
        For the amplitudes.
    amplitudes : (S, orders, k) N m
        Of the largest torque in the line at orders 2 and 4, in the forced motion.
    lateral : (G, hung shafts) 1/s
        Largest growth of each shaft on a rubber bearing; nan where the bearing is rigid.
    """

    line: Line
    states: tuple[str, ...]
    gears: tuple[Occasion, ...]
    ranges: FloatArray
    frequencies: FloatArray
    zones: tuple[Zone, ...]
    speeds: FloatArray
    amplitudes: FloatArray
    lateral: FloatArray


@dataclass(frozen=True, kw_only=True)
class Stability:
    """The answer: every line's vibration.

    `given` names those of the `surroundings` that were given; the others are assumed.
    """

    application: Application
    surroundings: Assumed
    given: frozenset[str]
    lines: tuple[LineVibration, ...]


def vibration(
    application: Application, *, surroundings: Surroundings | None, tell: Tell
) -> Finding[Stability]:
    """Ask every line how it vibrates, and hold it against the limits on that.

    Raises
    ------
    DesignError
        If only one of the gearbox's two values is given, or nothing says how fast the line
        turns or what torque it carries.
    NotConverged
        If a line has no steady forced motion (no damping, in resonance).
    """
    answer = stability(application, surroundings=surroundings, tell=tell)
    limits = limits_of(VIBRATION, application)
    checks = tuple(c for line in answer.lines for c in _checks(line, limits))
    return Finding(study=VIBRATION, answer=answer, checks=checks)


def stability(
    application: Application,
    *,
    surroundings: Surroundings | None = None,
    tell: Tell = silent,
) -> Stability:
    """Return how every line of an application vibrates, in every gear and state."""
    known = {
        f.name: value
        for source in (application.torsion, surroundings)
        for f in fields(Surroundings)
        if (value := getattr(source, f.name, None)) is not None
    }
    around = Assumed(**known)
    lines: list[LineVibration] = []
    for k, installed in enumerate(application.lines):
        tell(VIBRATION, k, len(application.lines))
        lines.append(_vibration(demand(resolve(application, installed)), around))
    return Stability(
        application=application, surroundings=around, given=frozenset(known), lines=tuple(lines)
    )


def _ranges(of: Demand) -> tuple[tuple[Occasion, ...], FloatArray, FloatArray]:
    """Return names, speeds (G, 2) rad/s and torques (G,) N m of each gear, up to top speed."""
    if np.isnan(of.speed).all() or np.isnan(of.torque).all():
        msg = f"line {of.installed.line.name} needs a speed and a torque to ask how it vibrates"
        raise DesignError(msg)
    top, torque = float(np.nanmax(of.speed)), float(np.nanmax(np.abs(of.torque)))
    if of.gears is None:
        return (Occasion("speed", "top speed"),), np.array([[top, top]]), np.array([torque])
    ranges = of.gears.speed_range
    return (
        tuple(Occasion("gear", name) for name in of.gears.names), ranges,
        np.minimum(of.gears.peak, torque),
    )  # fmt: skip


def _vibration(of: Demand, around: Assumed) -> LineVibration:
    """Return how a line vibrates in all its states."""
    line = of.installed.line
    gears, ranges, torques = _ranges(of)

    def model(torque: NewtonMetre) -> TorsionLine:
        return of_line(
            line, of.layout.directions[:, None], axle_inertia=around.axle_inertia,
            axle_stiffness=around.axle_stiffness, gearbox_inertia=around.gearbox_inertia,
            gearbox_stiffness=around.gearbox_stiffness, damping_ratio=around.damping_ratio,
            torque=torque,
        )  # fmt: skip

    w = natural_frequencies(model(0.0))[0, 0]
    met = [(i, i) for i in range(w.size)] + list(combinations(range(w.size), 2))
    centres = np.array([(w[i] + w[j]) / 2 for i, j in met])
    # The speed nearest to each zone that a gear reaches, and that gear's torque.
    reached = np.clip(centres[:, None], ranges[:, 0], ranges[:, 1])
    gear = np.abs(reached / centres[:, None] - 1).argmin(-1)
    nearest = reached[np.arange(centres.size), gear]
    # Zones far above every gear have the same nearest speed: ask once.
    runs = list(zip(nearest, gear, strict=True))
    rates = {
        (speed, g): growth(
            about_forced_orbit(model(float(torques[g])), np.array([speed]), samples=17)
        )[:, 0]
        for speed, g in dict.fromkeys(runs)
    }
    grown = np.stack([rates[run] for run in runs], axis=-1)
    zones = tuple(
        Zone(modes=(i + 1, j + 1), speed=float(centre), growth=grown[:, k])
        for k, ((i, j), centre) in enumerate(zip(met, centres, strict=True))
    )
    speeds = _asked(max(0.3 * float(ranges.min()), 1.0), 1.05 * float(ranges.max()), w)
    forced = orbit(model(float(torques.max())), speeds, samples=17)
    amplitudes = np.stack([np.abs(forced.order(o)).max(-1) for o in ORDERS], axis=1)
    lateral = np.array(
        [[_lateral(shaft, r, torque, around) for shaft in line.shafts[:-1]]
         for r, torque in zip(ranges, torques, strict=True)]
    ).reshape(len(gears), len(line.shafts) - 1)  # fmt: skip
    return LineVibration(
        line=line, states=of.states, gears=gears, ranges=ranges, frequencies=w, zones=zones,
        speeds=speeds, amplitudes=amplitudes, lateral=lateral,
    )  # fmt: skip


def _asked(low: float, high: float, frequencies: FloatArray) -> FloatArray:
    """Return speeds for a curve: evenly spread ones, and some closely round each resonance."""
    met = frequencies[:, None] / np.array(ORDERS)
    beside = np.array([0.005, 0.015, 0.03, 0.06])
    # Not at the resonance itself: without damping nothing there is periodic.
    close = met[..., None] * (1 + np.concatenate([-beside, beside]))
    every = np.unique(np.concatenate([np.linspace(low, high, 80), close.ravel()]))
    return every[(every >= low) & (every <= high)]


def _lateral(shaft: Shaft, between: FloatArray, torque: float, around: Assumed) -> float:
    """Return the largest growth of a hung shaft in a range of speeds; nan if held rigidly.

    Of the shaft swinging on its rubber: nobody gives the damping its bending modes have.
    """
    bearing, tube = shaft.centre_bearing, shaft.tube
    if bearing is None or bearing.stiffness is None or tube is None:
        return float("nan")
    vertical, lateral = bearing.stiffness
    k = (vertical + lateral) / 2
    length = shaft.length - bearing.from_rear_joint
    # On its bearing the shaft swings about the joint like a rod: k L² = m L²/3 w².
    swing = np.sqrt(k / (tube.mass_per_length * length / 3 + shaft.yoke_mass[1]))
    whirl = flexible_shaft(
        speed=np.linspace(between[0], between[1], 8), torque=torque, length=length,
        bending_stiffness=tube.bending_stiffness, mass_per_length=tube.mass_per_length,
        bearing=k, bearing_difference=(vertical - lateral) / 2,
        bearing_damping=around.rubber_loss * k / swing,
        rotary_inertia=tube.polar_inertia_per_length / 2, end_mass=shaft.yoke_mass[1],
        follower=1.0, functions=1,
    )  # fmt: skip
    return float(growth(whirl.system, tolerance=1e-8).max())


def _checks(of: LineVibration, limits: Sequence[Limit]) -> Iterator[Check]:
    """Yield each limit's checks: resonances and hung shafts gear by gear, zones by state."""
    asked: dict[str, Callable[[LineVibration], Iterator[tuple[Occasion, Part, float]]]] = {
        "torsional_resonance": _resonances,
        "torsional_growth": _zones,
        "lateral_growth": _hung,
    }
    for limit in limits:
        for when, part, value in asked[limit.quantity](of):
            yield Check(
                quantity=limit.quantity, line=of.line.name, when=when, part=part, value=value,
                limit=limit,
            )  # fmt: skip


def _resonances(of: LineVibration) -> Iterator[tuple[Occasion, Part, float]]:
    """Yield for each mode, order and gear the speed nearest to resonance, over that speed."""
    for i, w in enumerate(of.frequencies.tolist(), 1):
        for order in ORDERS:
            for gear, (low, high) in zip(of.gears, of.ranges, strict=True):
                nearest = float(np.clip(w / order, low, high) / (w / order))
                yield gear, Part("mode", i, order), nearest


def _zones(of: LineVibration) -> Iterator[tuple[Occasion, Part, float]]:
    """Yield the growth in each parametric zone and state."""
    for zone in of.zones:
        for state, rate in zip(of.states, zone.growth.tolist(), strict=True):
            yield Occasion("state", state), zone.part, rate


def _hung(of: LineVibration) -> Iterator[tuple[Occasion, Part, float]]:
    """Yield the lateral growth of each shaft on rubber, in each gear."""
    for gear, rates in zip(of.gears, of.lateral.tolist(), strict=True):
        for k, rate in enumerate(rates, 1):
            if not np.isnan(rate):
                yield gear, Part("shaft", k), rate
