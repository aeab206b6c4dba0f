"""Ask whether an application vibrates: the whole vehicle in torsion, and each hung shaft.

Every gear is asked in every state, at the speeds it has there: from idling with the clutch
closed, from standstill while it slips, up to what governs it or the state's own speed.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, partial
from itertools import combinations_with_replacement, pairwise
from typing import TypeAlias

import numpy as np

from cardan.base.arrays import FloatArray, IntArray
from cardan.base.errors import DesignError, NotConverged
from cardan.base.part import LINE, Occasion, Part
from cardan.base.units import rpm
from cardan.base.verdict import Check, Limit, Unanswered
from cardan.demand.states import Demand, demand, demand_under, said_speed
from cardan.demand.torque import from_standstill
from cardan.dynamics.branched import (
    Branched,
    Modes,
    Running,
    by_torque,
    carried,
    coupling,
    damped,
    first_order,
    forced,
    modes,
    zone_growth,
)
from cardan.dynamics.lateral import flexible_shaft
from cardan.dynamics.periodic import growth
from cardan.dynamics.torsion import pins
from cardan.model.application import Application, Surroundings
from cardan.model.parts import JointSize, Line, Shaft
from cardan.model.turning import Launch
from cardan.quantity.declared import RUBBER
from cardan.study.finding import VIBRATION, Finding, Tell, limits_of, silent
from cardan.study.launching import Started, default_launches, held_speed, start
from cardan.study.powertrain import Assumption, Drivetrain, Powertrain, drivetrain

Index: TypeAlias = tuple[IntArray, IntArray]
"""Places of a gear and a state, (P,) each."""

ORDERS = (2, 4)
"""Orders of the turning that joints excite."""

CRAWL = 0.01
"""Share of its top speed from which on a line with a motor is asked."""

SHOWN = 8
"""Modes that are told, at most: higher ones no speed of a vehicle meets."""

RUBBER_LOSS = 0.1
"""Loss factor of a centre bearing's rubber where nobody gives one: assumed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Shift:
    """How the modes of a gear move with something assumed, over its range.

    `frequencies` (2, modes) rad/s are those at its low and at its high end, `gear` the one in
    which they move most.
    """

    assumption: Assumption
    gear: str
    frequencies: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Zone:
    """Where twice the speed meets a sum of two torsional frequencies, or one of them twice.

    Attributes
    ----------
    modes
        Counted from 1, the rigid turning apart.
    speed : (G, S) rad/s
        At its middle.
    nearest : (G, S) rad/s
        The nearest speed that the gear has; nan where it has none.
    growth : (G, S) 1/s
        Of the zone's own multiplier, at that speed.
    openness : (G, S) 1
        What the joints feed at its middle over what damping takes: above 1 it is open.
    """

    modes: tuple[int, int]
    speed: FloatArray
    nearest: FloatArray
    growth: FloatArray
    openness: FloatArray

    @property
    def part(self) -> Part:
        """What a check of it is of."""
        return Part("zone", *self.modes)

    @property
    def opens_at_angle(self) -> FloatArray:
        """Joint angles over those there are, (G, S) 1, at which the zone opens."""
        return 1 / np.sqrt(np.maximum(self.openness, 1e-300))

    @property
    def opens_at_damping(self) -> FloatArray:
        """Damping over what there is, (G, S) 1, below which the zone opens."""
        return self.openness


@dataclass(frozen=True, kw_only=True, eq=False)
class Driven:
    """The vehicle with its clutch closed, or slipping, in G gears and S states.

    Attributes
    ----------
    powertrain
        Its parts.
    modes : (G, S, n)
        With the tyres stuck to the road; the first is no mode, the line turning as one.
    damping : (G, S, n) 1
        Ratio of each mode where order 2 meets it, or at the nearest speed the gear has.
    ranges : (G, S, 2) rad/s
        Speeds of the main line; nan where there are none.
    torque, speed : (G, S, orders, springs) N m, rad/s
        Largest vibratory torque of each order in each spring, and the speed it has it at.
    mean : (G, S, springs) N m
        Torque that the springs carry at the gear's full torque, each sign kept.
    worst : (G, S, springs) N m
        Largest sum of the orders' torques at one speed.
    peak, ratio : (G, S, springs) N m, 1
        Largest sum of mean and vibratory torque at one speed; largest vibratory torque over
        the mean at the same speed.
    acceleration : (G, S, lines) rad/s²
        Largest of each line's pinion.
    """

    powertrain: Powertrain
    modes: Modes
    damping: FloatArray
    ranges: FloatArray
    torque: FloatArray
    speed: FloatArray
    mean: FloatArray
    worst: FloatArray
    peak: FloatArray
    ratio: FloatArray
    acceleration: FloatArray

    @property
    def frequencies(self) -> FloatArray:
        """Of the modes without the rigid turning, (G, S, n - 1) rad/s."""
        return self.modes.frequency[..., 1:]


@dataclass(frozen=True, kw_only=True, eq=False)
class LineVibration:
    """What of the vibration is one line's own.

    Attributes
    ----------
    line, number
        Which line.
    lateral : (G, hung shafts) 1/s
        Largest growth of each shaft on a rubber bearing; nan where the bearing is rigid.
    """

    line: Line
    lateral: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Stability:
    """The answer: the vehicle in torsion, and each line's hung shafts.

    Attributes
    ----------
    application, surroundings
        What was asked, and what went before it; `given` names those of the latter.
    drivetrain
        The parts, and what was assumed of them.
    gears : the G ranges of speed
    states : the S states
    closed, slipping
        The vehicle with its clutch closed and slipping.
    zones
        Parametric zones of first order, the clutch closed.
    speeds, amplitudes : (k,) rad/s, (G, S, orders, k) N m
        Largest torque of the main line in forced motion; nan where a gear has no such speed.
    firing : (G, springs) N m
        Largest torque of the engine's firing order in each spring at the gear's speeds.
    shifts
        How the modes move with what was assumed.
    launches
        Starts from rest: those of the file, or a smooth one and a dropped clutch.
    unstarted
        Those that could not be followed, and why.
    doubts
        What could not be asked, in words.
    """

    application: Application
    surroundings: Surroundings
    given: frozenset[str]
    drivetrain: Drivetrain
    gears: tuple[Occasion, ...]
    states: tuple[str, ...]
    closed: Driven
    slipping: Driven
    zones: tuple[Zone, ...]
    speeds: FloatArray
    amplitudes: FloatArray
    firing: FloatArray
    shifts: tuple[Shift, ...]
    lines: tuple[LineVibration, ...]
    launches: tuple[Started, ...] = ()
    unstarted: tuple[tuple[Launch, str], ...] = ()
    doubts: tuple[str, ...] = ()


def vibration(
    application: Application, *, surroundings: Surroundings | None, tell: Tell
) -> Finding[Stability]:
    """Ask every line how it vibrates, and hold it against the limits on that.

    Raises
    ------
    DesignError
        If nothing says how fast the line turns or what torque it carries.
    """
    answer = stability(application, surroundings=surroundings, tell=tell)
    limits = limits_of(VIBRATION, application)
    found = [_held(answer, limit) for limit in limits]
    return Finding(
        study=VIBRATION,
        answer=answer,
        checks=tuple(c for checks, _ in found for c in checks),
        unanswered=tuple(u for _, silent_of in found for u in silent_of),
        doubts=answer.doubts,
    )


def stability(
    application: Application,
    *,
    surroundings: Surroundings | None = None,
    tell: Tell = silent,
) -> Stability:
    """Return how an application vibrates, in every gear and state."""
    said = {
        f.name: value
        for source in (application.torsion, surroundings)
        for f in fields(Surroundings)
        if (value := getattr(source, f.name, None)) is not None
    }
    around = Surroundings(**said)
    parts = drivetrain(application, surroundings=around)
    asked = tuple(demand(line) for line in parts.lines)
    if np.isnan(asked[0].speed).all() or np.isnan(asked[0].torque).all():
        msg = (
            f"line {asked[0].installed.line.name} needs a speed and a torque to ask how it vibrates"
        )
        raise DesignError(msg)
    tell(VIBRATION, 0, 4)
    running = _Running(parts=parts, asked=asked, around=around)
    closed = running.driven(parts.closed, running.closed_ranges)
    tell(VIBRATION, 1, 4)
    slipping = running.driven(parts.slipping, running.slipping_ranges)
    tell(VIBRATION, 2, 4)
    zones = tuple(running.zones(closed))
    speeds, amplitudes = running.curve(closed)
    tell(VIBRATION, 3, 4)
    loss = around.rubber_loss or RUBBER_LOSS
    launches = tuple(running.launches())
    return Stability(
        application=application,
        surroundings=around,
        given=frozenset(said),
        drivetrain=parts,
        gears=running.gears,
        states=parts.states,
        closed=closed,
        slipping=slipping,
        zones=zones,
        speeds=speeds,
        amplitudes=amplitudes,
        firing=running.firing(closed),
        shifts=tuple(_shifts(application, around, parts, closed)),
        lines=tuple(
            LineVibration(line=d.installed.line, lateral=running.lateral(d, loss)) for d in asked
        ),
        launches=launches,
        unstarted=tuple(running.unstarted),
        doubts=tuple(running.doubts),
    )


@dataclass(frozen=True, kw_only=True)
class _Running:
    """A vehicle's gears and states with the torque, speed and geometry that go together."""

    parts: Drivetrain
    asked: tuple[Demand, ...]
    around: Surroundings = field(default_factory=Surroundings)
    lost: list[str] = field(default_factory=list[str])
    unstarted: list[tuple[Launch, str]] = field(default_factory=list[tuple[Launch, str]])

    @property
    def main(self) -> Demand:
        """The line whose speed everything is referred to."""
        return self.asked[0]

    @property
    def gears(self) -> tuple[Occasion, ...]:
        """The gears, or the top speed where there are none."""
        if self.main.gears is None:
            return (Occasion("speed", "top speed"),)
        return tuple(Occasion("gear", name) for name in self.main.gears.names)

    @property
    def doubts(self) -> Iterator[str]:
        """What is left out."""
        for name in self.parts.left_out:
            yield f"line {name} turns at another speed: its joints are not counted in torsion"
        if self.lost:
            where = "; ".join(dict.fromkeys(self.lost))
            yield f"no steady forced motion settles, amplitudes by the joints' leads alone: {where}"
        for wanted, why in self.unstarted:
            yield f"launch in gear {wanted.gear}: {why}"

    @cached_property
    def _driven(self) -> FloatArray:
        """1 where a state drives, nan where brakes alone hold the axle, (S,)."""
        return np.where(self.main.standing.line.winds("windup brake"), np.nan, 1.0)

    @cached_property
    def _fastest(self) -> FloatArray:
        """Highest speed of each gear in each state, (G, S) rad/s."""
        said = said_speed(self.main.standing.line)
        if self.main.gears is None:
            return (self.main.speed * self._driven)[None]
        return np.fmin(self.main.gears.speed.max(-1)[:, None], said) * self._driven

    @cached_property
    def closed_ranges(self) -> FloatArray:
        """Speeds with the clutch closed, (G, S, 2) rad/s: from idling, or a crawl of a motor."""
        top = self._fastest
        if self.main.gears is None:
            return np.stack([top, top], axis=-1)
        low = np.maximum((self.parts.idle / self.parts.ratios)[:, None], CRAWL * top)
        there = low <= top
        return np.stack([np.where(there, low, np.nan), np.where(there, top, np.nan)], axis=-1)

    @cached_property
    def slipping_ranges(self) -> FloatArray:
        """Speeds while the clutch slips, (G, S, 2) rad/s: gears that vehicles start in.

        Up to where the clutch locks: the line turns as the engine is held at in first gear or
        those of the file's launches ahead; below a fifth of it the launch itself is asked.
        """
        top = self._fastest
        if self.main.gears is None or self.parts.starts_by == "motor":
            return np.full((*top.shape, 2), np.nan)
        ahead = [x for x in default_launches(self.application) if x.gear in self.parts.gears]
        held = dict.fromkeys({x.gear for x in ahead} or {"1"}, self.parts.idle)
        if self.application.engine is not None:
            for launch in ahead:
                turning = held_speed(self.parts, launch)
                held[launch.gear] = max(held.get(launch.gear, 0.0), turning)
        turns = np.array([held.get(name, np.nan) for name in self.parts.gears])
        high = np.fmin((turns / self.parts.ratios)[:, None], top)
        high = np.where(np.isfinite(turns)[:, None] & np.isfinite(top), high, np.nan)
        return np.stack([0.2 * high, high], axis=-1)

    @property
    def application(self) -> "Application":
        """What is asked."""
        return self.parts.application

    def torque(self, speed: FloatArray) -> FloatArray:
        """Return the main line's full torque at speeds (G, S, ...) rad/s, N m.

        That of the gear from standstill, the smaller of it and what the state's own says:
        what its tyres hold, or a torque given.
        """
        most = np.abs(self.main.torque)
        most = most.reshape(1, -1, *(1,) * (speed.ndim - 2))
        if self.main.gears is None:
            return np.broadcast_to(most, speed.shape).copy()
        n, T = from_standstill(self.main.gears.speed, self.main.gears.torque)
        found = [np.interp(speed[k], n[k], T[k]) for k in range(len(n))]
        return np.fmin(np.stack(found), most)

    @cached_property
    def geometry(self) -> tuple[FloatArray, FloatArray]:
        """Angles and places of all joints that count, (G, S, J) rad, wound up by full torque."""
        beta: list[FloatArray] = []
        place: list[FloatArray] = []
        low = np.zeros(self._fastest.shape)
        T = self.torque(low)
        for asked in self.asked:
            line = asked.standing.line
            share = line.usual_share / self.main.standing.line.usual_share
            under = demand_under(asked, torque=share * T, speed=low)
            if line.line.name in self.parts.left_out:
                continue
            b, p = pins(under.layout.directions, line.line.phases, line.line.crosses)
            beta.append(b)
            place.append(p)
        return np.concatenate(beta, axis=-1), np.concatenate(place, axis=-1)

    def at(self, powertrain: Powertrain, found: Modes, speed: FloatArray, index: Index) -> "_At":
        """Return what counts at speeds (P,) rad/s of gears and states `index`, (P,) each."""
        g, s = index
        line = replace(powertrain, line=powertrain.line.case(g, s),
                       slip_length=powertrain.slip_length[s]).rolling(speed)  # fmt: skip
        one = Modes(frequency=found.frequency[g, s], shape=found.shape[g, s])
        every = np.broadcast_to(speed[:, None, None], (len(speed), *self._fastest.shape))
        T = self.torque(np.moveaxis(every, 0, -1))[g, s, np.arange(len(speed))]
        force = powertrain.balanced(T, one.shape[..., 0])
        twist, torque = carried(line, one, force)
        beta, place = (v[g, s] for v in self.geometry)
        turned = twist[..., line.joints]
        return _At(
            line=line, modes=one, mean=torque,
            running=Running(beta=beta, place=place, force=force, speed=speed),
            pins=place + turned - turned[..., :1],
            through=_through(powertrain, torque),
        )  # fmt: skip

    def driven(self, powertrain: Powertrain, ranges: FloatArray) -> Driven:
        """Return the modes, and the largest torques at the speeds that there are."""
        found = modes(powertrain.line)
        G, S, n = found.frequency.shape
        damping = np.zeros((G, S, n))
        known = np.isfinite(ranges).all(-1)
        low, high = (np.where(known, ranges[..., k], 1.0) for k in (0, 1))
        shown = min(n, SHOWN + 1)
        for k in range(1, shown):
            speed = np.clip(found.frequency[..., k] / 2, low, high)
            mode = Modes(
                frequency=found.frequency[..., k : k + 1], shape=found.shape[..., k : k + 1]
            )
            damping[..., k] = damped(powertrain.rolling(speed), mode)[1][..., 0]
        springs = len(powertrain.springs)
        torque = np.full((G, S, len(ORDERS), springs), np.nan)
        speed_at = np.full_like(torque, np.nan)
        mean = np.full((G, S, springs), np.nan)
        total, peak, ratio = (np.full_like(mean, np.nan) for _ in range(3))
        acceleration = np.full((G, S, len(self.asked)), np.nan)
        index, speeds = _candidates(found, damping, ranges, shown)
        if not len(speeds):
            return Driven(
                powertrain=powertrain, modes=found, damping=damping, ranges=ranges, torque=torque,
                speed=speed_at, mean=mean, worst=total, peak=peak, ratio=ratio,
                acceleration=acceleration,
            )  # fmt: skip
        speeds = self._at_peaks(powertrain, found, speeds, index)
        now = self.at(powertrain, found, speeds, index)
        moved = forced(now.line, now.running, found=now.modes, tolerance=1e-7, strict=False)
        size = np.stack([np.abs(moved.order(o)) for o in ORDERS], axis=-2)
        lost = np.asarray(np.isnan(size).any((-1, -2)))
        size = np.where(lost[:, None, None], self._leads_alone(now), size)
        self.lost.extend(
            f"gear {self.parts.gears[g]}, {self.parts.states[s]}, {speeds[c] / rpm:.0f} rpm"
            for c, (g, s) in enumerate(zip(*index, strict=True))
            if lost[c]
        )
        together = size.sum(-2)
        pinions = [
            powertrain.freedoms.index((d.installed.line.name, Part("pinion"))) for d in self.asked
        ]
        faster = [(o * speeds[:, None]) ** 2 for o in ORDERS]
        turned = [np.abs(moved.rotation[..., o // 2, pinions]) for o in ORDERS]
        shaken = faster[0] * turned[0] + faster[1] * turned[1]
        for c, (g, s) in enumerate(zip(*index, strict=True)):
            bigger = ~(size[c] <= torque[g, s])
            speed_at[g, s] = np.where(bigger, speeds[c], speed_at[g, s])
            torque[g, s] = np.fmax(torque[g, s], size[c])
            mean[g, s] = np.where(np.abs(now.mean[c]) >= np.abs(np.nan_to_num(mean[g, s])),
                                  now.mean[c], mean[g, s])  # fmt: skip
            total[g, s] = np.fmax(total[g, s], together[c])
            held = np.abs(now.mean[c])
            peak[g, s] = np.fmax(peak[g, s], held + together[c])
            ratio[g, s] = np.fmax(ratio[g, s], together[c] / np.where(held > 0, held, np.nan))
            acceleration[g, s] = np.fmax(acceleration[g, s], shaken[c])
        return Driven(
            powertrain=powertrain, modes=found, damping=damping, ranges=ranges, torque=torque,
            speed=speed_at, mean=mean, worst=total, peak=peak, ratio=ratio,
            acceleration=acceleration,
        )  # fmt: skip

    @staticmethod
    def _leads_alone(now: "_At") -> FloatArray:
        """Orders of every spring's torque by the joints' leads alone, (P, orders, springs) N m."""
        each = (
            first_order(now.line, now.running, pins=now.pins, torque=now.through,
                        order=np.full(now.running.speed.shape, order))
            for order in ORDERS
        )  # fmt: skip
        return np.abs(np.stack(list(each), axis=-2))

    def _at_peaks(
        self,
        powertrain: Powertrain,
        found: Modes,
        brackets: FloatArray,
        index: Index,
    ) -> FloatArray:
        """Return the speed of the largest order 2 or 4 within brackets (P, 3): golden section.

        The third of a bracket is its order. Where its ends are one the speed is there.
        """
        low, high, order = brackets.T
        mine = self._of_line(powertrain)
        shrink = (np.sqrt(5) - 1) / 2

        def size(speed: FloatArray) -> FloatArray:
            now = self.at(powertrain, found, speed, index)
            doubled = first_order(
                now.line, now.running, pins=now.pins, torque=now.through, order=order
            )
            return np.abs(doubled[..., mine]).max(-1)

        a, b = low.copy(), high.copy()
        c, d = b - shrink * (b - a), a + shrink * (b - a)
        fc, fd = size(c), size(d)
        while np.any((b - a) > 1e-6 * b):
            left = fc > fd
            b, a = np.where(left, d, b), np.where(left, a, c)
            c2, d2 = b - shrink * (b - a), a + shrink * (b - a)
            new = size(np.where(left, c2, d2))
            fc, fd = np.where(left, new, fd), np.where(left, fc, new)
            c, d = c2, d2
        return (a + b) / 2

    def zones(self, closed: Driven) -> Iterator[Zone]:
        """Yield the zones that speeds come near, at the nearest speed of each gear and state."""
        w, zeta, ranges = closed.modes.frequency, closed.damping, closed.ranges
        known = np.isfinite(ranges).all(-1)
        if not known.any():
            return
        top = float(np.nanmax(ranges))
        low, high = (np.where(known, ranges[..., k], 1.0) for k in (0, 1))
        g, s = np.nonzero(np.ones(known.shape, dtype=bool))
        for i, j in combinations_with_replacement(range(1, min(w.shape[-1], SHOWN + 1)), 2):
            centre = (w[..., i] + w[..., j]) / 2
            if (i, j) != (1, 1) and centre.min() > 1.1 * top:
                continue
            nearest = np.clip(centre, low, high)
            now = self.at(closed.powertrain, closed.modes, nearest.ravel(), (g, s))
            H = coupling(now.line, now.modes, now.running, pins=now.pins, torque=now.through)
            pair = tuple(w[..., k].ravel() for k in (i, j))
            decay = tuple((zeta[..., k] * w[..., k]).ravel() for k in (i, j))
            rate, openness = zone_growth(
                H, modes=(i, j), frequency=(pair[0], pair[1]), decay=(decay[0], decay[1]),
                speed=nearest.ravel(),
            )  # fmt: skip
            yield Zone(
                modes=(i, j),
                speed=centre,
                nearest=np.where(known, nearest, np.nan),
                growth=np.where(known, rate.reshape(known.shape), np.nan),
                openness=np.where(known, openness.reshape(known.shape), np.nan),
            )

    def curve(self, closed: Driven, points: int = 60) -> tuple[FloatArray, FloatArray]:
        """Return speeds (k,) and the main line's largest torque (G, S, orders, k) there."""
        ranges = closed.ranges
        if not np.isfinite(ranges).any():
            return np.zeros(0), np.zeros((*ranges.shape[:2], len(ORDERS), 0))
        low, high = float(np.nanmin(ranges[..., 0])), float(np.nanmax(ranges[..., 1]))
        met = closed.speed[np.isfinite(closed.speed)]
        speeds = np.unique(np.concatenate([np.linspace(low, high, points), np.unique(met)]))
        spread = np.empty((*ranges.shape[:2], len(ORDERS), len(speeds)))
        spread[:] = np.nan
        inside = (speeds >= ranges[..., :1] - 1e-9) & (speeds <= ranges[..., 1:] + 1e-9)
        g, s, k = np.nonzero(inside)
        mine = self._of_line(closed.powertrain)
        for part in np.array_split(np.arange(len(g)), max(1, len(g) // 400)):
            now = self.at(closed.powertrain, closed.modes, speeds[k[part]], (g[part], s[part]))
            for o, order in enumerate(ORDERS):
                size = np.abs(
                    first_order(now.line, now.running, pins=now.pins, torque=now.through,
                                order=np.full(len(part), order))
                )  # fmt: skip
                spread[g[part], s[part], o, k[part]] = size[:, mine].max(-1)
        return speeds, spread

    def _of_line(self, powertrain: Powertrain) -> list[int]:
        """Return the places of the lines' own springs: shafts and pinions."""
        return [k for k, (_, p) in enumerate(powertrain.springs) if p.kind in {"shaft", "pinion"}]

    def firing(self, closed: Driven) -> FloatArray:
        """Largest torque of the firing order in each spring, (G, springs) N m, in any state."""
        out = np.zeros((len(self.gears), len(closed.powertrain.springs)))
        if not self.parts.firing_torque:
            return out
        w = closed.modes.frequency
        for k, ratio in enumerate(self.parts.ratios.tolist()):
            order = self.parts.cylinders / 2 * ratio
            low, high = closed.ranges[k, :, 0], closed.ranges[k, :, 1]
            for s in np.flatnonzero(np.isfinite(low)).tolist():
                met = np.clip(w[k, s, 1:] / order, low[s], high[s])
                speeds = np.unique(np.concatenate([met, np.linspace(low[s], high[s], 12)]))
                same = (np.full(len(speeds), k), np.full(len(speeds), s))
                now = self.at(closed.powertrain, closed.modes, speeds, same)
                force = np.zeros_like(now.running.force)
                force[:, 0] = self.parts.firing_torque * ratio
                size = np.abs(by_torque(now.line, order * speeds, force))
                out[k] = np.maximum(out[k], size.max(0))
        return out

    def launches(self) -> Iterator[Started]:
        """Yield the vehicle's starts from rest."""
        if self.application.engine is None or self.main.gears is None:
            return
        for wanted in default_launches(self.application):
            try:
                ahead = wanted.gear in self.parts.gears
                yield start(self.parts if ahead else self.astern, self.asked, wanted)
            except NotConverged as error:
                self.unstarted.append((wanted, str(error)))

    @cached_property
    def astern(self) -> Drivetrain:
        """The vehicle in its reverse gears."""
        return drivetrain(self.application, surroundings=self.around, astern=True)

    def lateral(self, asked: Demand, loss: float) -> FloatArray:
        """Return the largest lateral growth of each hung shaft in each gear, (G, shafts) 1/s."""
        shafts = asked.installed.line.shafts[:-1]
        ranges = self.closed_ranges
        pace = asked.installed.speed_ratio / self.main.installed.speed_ratio
        share = asked.standing.line.usual_share / self.main.standing.line.usual_share
        found: list[list[float]] = []
        for k in range(len(self.gears)):
            if np.isnan(ranges[k]).all():  # nothing turns in this gear
                found.append([float("nan")] * len(shafts))
                continue
            low, high = np.nanmin(ranges[k, :, 0]), np.nanmax(ranges[k, :, 1])
            T = float(np.nanmax(self.torque(np.full(ranges.shape[:2], low))[k]))
            between = np.array([low, high]) * pace
            found.append([_lateral(shaft, between, share * T, loss) for shaft in shafts])
        return np.array(found).reshape(len(self.gears), len(shafts))


@dataclass(frozen=True, kw_only=True, eq=False)
class _At:
    """A line at P speeds of its gears and states."""

    line: Branched
    modes: Modes
    running: Running
    pins: FloatArray
    mean: FloatArray
    through: FloatArray


def _through(powertrain: Powertrain, torque: FloatArray) -> FloatArray:
    """Torque that each joint passes on, (..., J) N m: that of what is twisted behind it."""
    n = powertrain.line.size
    behind = powertrain.line.springs[:, n:]
    return torque @ behind


def _candidates(
    found: Modes, damping: FloatArray, ranges: FloatArray, shown: int
) -> tuple[Index, FloatArray]:
    """Brackets (P, 3) low, high, order in which a torque may be largest, of gears and states.

    Both ends of every range, its thirds, and the neighbourhood of each resonance in it.
    """
    index: list[tuple[int, int]] = []
    brackets: list[tuple[float, float, float]] = []
    for g, s in np.argwhere(np.isfinite(ranges).all(-1)).tolist():
        low, high = ranges[g, s].tolist()
        for end in {low, high}:
            index.append((g, s))
            brackets.append((end, end, ORDERS[0]))
        # Between resonances a hump may be broad: a few parts of the range are looked at too.
        parts = np.linspace(low, high, 4).tolist()
        for a, b in pairwise(parts):
            if a < b:
                index.append((g, s))
                brackets.append((a, b, ORDERS[0]))
        for k in range(1, shown):
            for order in ORDERS:
                met = found.frequency[g, s, k] / order
                wide = max(0.02, 2.5 * float(damping[g, s, k]))
                a, b = max(met * (1 - wide), low), min(met * (1 + wide), high)
                if a < b:
                    index.append((g, s))
                    brackets.append((a, b, order))
    if not index:
        none = np.zeros(0, dtype=int)
        return (none, none), np.zeros((0, 3))
    g, s = np.array(index).T
    return (g, s), np.array(brackets, dtype=float)


def _shifts(
    application: Application, around: Surroundings, parts: Drivetrain, closed: Driven
) -> Iterator[Shift]:
    """Yield how far the modes move with what is assumed, those that move any by 2 % alone."""
    state = -1
    base = closed.frequencies[:, state]
    count = min(4, base.shape[-1])
    seen: set[str] = set()
    for assumption in parts.assumed:
        q = assumption.typical
        if q.quantity in seen or q.low == q.high:
            continue
        seen.add(q.quantity)
        ends: list[FloatArray] = []
        for value in (q.low, q.high):
            other = drivetrain(application, surroundings=around, replaced={q.quantity: value})
            line = other.closed.line.case(slice(None), [state])
            ends.append(modes(line).frequency[:, 0, 1 : 1 + count])
        moved = np.stack(ends)
        gear = int(np.abs(moved / base[:, :count] - 1).max((0, 2)).argmax())
        if np.abs(moved[:, gear] / base[gear, :count] - 1).max() > 0.02:
            yield Shift(assumption=assumption, gear=parts.gears[gear], frequencies=moved[:, gear])


def _lateral(shaft: Shaft, between: FloatArray, torque: float, loss: float) -> float:
    """Return the largest growth of a hung shaft in a range of speeds; nan if held rigidly.

    Of the shaft swinging on its rubber: nobody gives the damping its bending modes have.
    """
    bearing, tube = shaft.centre_bearing, shaft.tube
    across = bearing and bearing.across
    if bearing is None or across is None or tube is None:
        return float("nan")
    vertical, lateral = across
    k = (vertical + lateral) / 2
    length = shaft.length - bearing.from_rear_joint
    # On its bearing the shaft swings about the joint like a rod: k L² = m L²/3 w².
    swing = np.sqrt(k / (tube.mass_per_length * length / 3 + shaft.yoke_mass[1]))
    whirl = flexible_shaft(
        speed=np.linspace(between[0], between[1], 8), torque=torque, length=length,
        bending_stiffness=tube.bending_stiffness, mass_per_length=tube.mass_per_length,
        bearing=k, bearing_difference=(vertical - lateral) / 2,
        bearing_damping=loss * k / swing,
        rotary_inertia=tube.polar_inertia_per_length / 2, end_mass=shaft.yoke_mass[1],
        follower=1.0, functions=1,
    )  # fmt: skip
    return float(growth(whirl.system, tolerance=1e-8).max())


# ----- verdicts ------------------------------------------------------------------------------


Row = tuple[str, Occasion, Part, float]
"""What a limit is asked of: a line, when, a part of it, and the value."""

SLIPPING = "the clutch slipping"
"""What an occasion says of a gear while its clutch slips."""


def _held(of: Stability, limit: Limit) -> tuple[list[Check], list[Unanswered]]:
    """Return a limit's checks, and where it got no number."""
    rows = {
        "torsional_resonance": _resonances,
        "torsional_growth": _zones,
        "lateral_growth": _hung,
        "torsional_amplitude_utilisation": partial(_rated, rating="reversing_torque"),
        "torsional_peak_utilisation": partial(_rated, rating="peak_torque"),
        "torsional_reversal": _reversals,
        "torsional_pinion_acceleration": _accelerations,
        "launch_peak_utilisation": _launch_peaks,
        "launch_reversal": _launch_reversals,
        "launch_bearing_force": _launch_bearings,
    }[limit.quantity](of)
    checks: list[Check] = []
    silent_of: list[Unanswered] = []
    for line, when, part, value in rows:
        if np.isnan(value):
            silent_of.append(
                Unanswered(
                    limit=limit, line=line, when=when, part=part, needs=(_NEEDS[limit.quantity],)
                )
            )
        else:
            checks.append(
                Check(
                    quantity=limit.quantity,
                    line=line,
                    when=when,
                    part=part,
                    value=value,
                    limit=limit,
                )
            )
    if limit.quantity.startswith("launch_"):
        silent_of += [
            Unanswered(
                limit=limit, line=of.lines[0].line.name, when=launch_occasion(launch), part=LINE,
                needs=(why,),
            )
            for launch, why in of.unstarted
            if _is_judged(of, launch)
        ]  # fmt: skip
    return checks, silent_of


_NEEDS = {
    "torsional_amplitude_utilisation": "a joint size with its reversing torque",
    "torsional_peak_utilisation": "a joint size with its peak torque",
    "launch_peak_utilisation": "a joint size with its peak torque",
    "launch_bearing_force": RUBBER.gives,
}


def _resonances(of: Stability) -> Iterator[Row]:
    """Yield for each mode, order and gear the speed nearest to resonance, over that speed.

    The clutch closed, in the state that comes nearest. Modes that no gear comes within a
    quarter of are left out, but for the first.
    """
    w, ranges = of.closed.frequencies, of.closed.ranges
    name = of.lines[0].line.name
    top = np.nanmax(ranges)
    for i in range(w.shape[-1]):
        for order in ORDERS:
            met = w[..., i] / order
            if (i, order) != (0, ORDERS[0]) and met.min() > 1.25 * top:
                continue
            nearest = np.clip(met, ranges[..., 0], ranges[..., 1]) / met
            for g, gear in enumerate(of.gears):
                each = nearest[g][np.isfinite(nearest[g])]
                if each.size:
                    worst = each[np.abs(np.log(each)).argmin()]
                    yield name, gear, Part("mode", i + 1, order), float(worst)


def _zones(of: Stability) -> Iterator[Row]:
    """Yield the growth in each parametric zone and state, in the gear where it is worst."""
    for zone in of.zones:
        for s, state in enumerate(of.states):
            if np.isfinite(zone.growth[:, s]).any():
                rate = float(np.nanmax(zone.growth[:, s]))
                yield of.lines[0].line.name, Occasion("state", state), zone.part, rate


def _hung(of: Stability) -> Iterator[Row]:
    """Yield the lateral growth of each shaft on rubber, in each gear."""
    for line in of.lines:
        for gear, rates in zip(of.gears, line.lateral.tolist(), strict=True):
            for k, rate in enumerate(rates, 1):
                if not np.isnan(rate):
                    yield line.line.name, gear, Part("shaft", k), rate


def _spring_behind(of: Driven, line: Line, joint: int) -> int:
    """Return the place of the spring behind a joint of a line: its shaft, or the pinion."""
    part = Part("shaft", joint) if joint < line.joint_count else Part("pinion")
    return of.powertrain.springs.index((line.name, part))


def clutched(of: Stability) -> Iterator[tuple[Driven, int, Occasion]]:
    """Yield each gear with its clutch closed, and slipping where it does."""
    for driven, how in ((of.closed, ""), (of.slipping, SLIPPING)):
        for g, gear in enumerate(of.gears):
            if np.isfinite(driven.ranges[g]).any():
                yield driven, g, replace(gear, what=how)


def _rated(of: Stability, *, rating: str) -> Iterator[Row]:
    """Yield vibratory, or largest, torque of each joint over its rating, in each gear."""
    for line in (v.line for v in of.lines):
        sizes: tuple[JointSize | None, ...] = line.joints or (None,) * line.joint_count
        for k, size in enumerate(sizes, 1):
            held = getattr(size, rating, None)
            for driven, g, when in clutched(of):
                values = driven.worst if rating == "reversing_torque" else driven.peak
                mine = values[g, :, _spring_behind(driven, line, k)]
                if np.isfinite(mine).any():
                    share = float(np.nanmax(mine)) / held if held else np.nan
                    yield line.name, when, Part("joint", k), share


def _reversals(of: Stability) -> Iterator[Row]:
    """Yield the largest vibratory torque of each line over its mean, in each gear."""
    for line in (v.line for v in of.lines):
        for driven, g, when in clutched(of):
            joints = range(1, line.joint_count + 1)
            mine = driven.ratio[g][:, [_spring_behind(driven, line, k) for k in joints]]
            if np.isfinite(mine).any():
                yield line.name, when, LINE, float(np.nanmax(mine))


def _accelerations(of: Stability) -> Iterator[Row]:
    """Yield the largest acceleration of each line's pinion, in each gear."""
    for k, line in enumerate(v.line for v in of.lines):
        for driven, g, when in clutched(of):
            mine = driven.acceleration[g, :, k]
            if np.isfinite(mine).any():
                yield line.name, when, Part("pinion"), float(np.nanmax(mine))


def launch_occasion(of: Launch) -> Occasion:
    """Return when the numbers of a launch were asked for."""
    return Occasion("launch", of.gear, f"{of.ramp:g}")


def _is_judged(of: Stability, launch: Launch) -> bool:
    """Whether a launch is held against limits: a dropped clutch only if the file asks."""
    return bool(of.application.launches) or launch.capacity <= 1


def _judged(of: Stability) -> Iterator[Started]:
    """Yield the launches that are held against limits."""
    yield from (started for started in of.launches if _is_judged(of, started.launch))


def _launch_peaks(of: Stability) -> Iterator[Row]:
    """Yield the peak torque of each joint in each launch over its rating."""
    for started in _judged(of):
        for line in (v.line for v in of.lines):
            sizes: tuple[JointSize | None, ...] = line.joints or (None,) * line.joint_count
            for k, size in enumerate(sizes, 1):
                part = Part("shaft", k) if k < line.joint_count else Part("pinion")
                peak = float(started.peak[started.springs.index((line.name, part))])
                held = size and size.peak_torque
                share = peak / held if held else np.nan
                yield line.name, launch_occasion(started.launch), Part("joint", k), share


def _launch_reversals(of: Stability) -> Iterator[Row]:
    """Yield how far each line's torque swings back in each launch, over its peak."""
    for started in _judged(of):
        for line in (v.line for v in of.lines):
            at = started.springs.index((line.name, Part("shaft", 1)))
            back = -float(started.lowest[at]) / float(started.peak[at])
            yield line.name, launch_occasion(started.launch), LINE, back


def _launch_bearings(of: Stability) -> Iterator[Row]:
    """Yield the largest force on each centre bearing as a launch passes its resonances."""
    for started in _judged(of):
        for b, force in enumerate(started.bearing_passed.max(0).tolist(), 1):
            yield (
                of.lines[0].line.name, launch_occasion(started.launch),
                Part("centre bearing", b), force,
            )  # fmt: skip
