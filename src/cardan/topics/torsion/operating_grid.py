"""Torque, speed and geometry of a vehicle in every gear and state, and its vibration there."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations_with_replacement, pairwise
from typing import TypeAlias

import numpy as np

from cardan.core.arrays import FloatArray, IntArray
from cardan.core.errors import ConvergenceError
from cardan.core.labels import EvaluationCondition, Part
from cardan.core.units import rpm
from cardan.model.application import Application, GearboxAndAxleRotors
from cardan.model.parts import Shaft
from cardan.model.powertrain import Launch
from cardan.physics.dynamics.floquet import growth_rate
from cardan.physics.dynamics.lateral import flexible_shaft_system
from cardan.physics.dynamics.torsional_line import joint_angles_and_pin_angles
from cardan.physics.dynamics.torsional_network import (
    TorsionalModes,
    TorsionalNetwork,
    TorsionalOperatingPoint,
    damped_modes,
    first_order_torques,
    forced_torsional_response,
    modal_coupling_by_joint_order_2,
    spring_torque_response,
    static_response,
    torsional_modes,
    zone_growth_rate,
)
from cardan.physics.vehicle.state_demand import (
    LineStateDemand,
    demand_with_axle_moved_by_torque,
)
from cardan.physics.vehicle.state_torques import speed_stated_by_application
from cardan.physics.vehicle.torque import largest_torque_from_standstill
from cardan.topics.torsion.launch_study import (
    LaunchResult,
    default_launches,
    launch_engine_speed,
    simulate_launch,
)
from cardan.topics.torsion.powertrain_model import (
    PowertrainModel,
    VehicleTorsionModel,
    vehicle_torsion_model,
)
from cardan.topics.torsion.vibration_result import (
    EXCITED_ORDERS,
    ParametricResonance,
    PowertrainVibration,
)

GearAndStateIndices: TypeAlias = tuple[IntArray, IntArray]
"""Places of a gear and a state, (P,) each."""

MIN_MOTOR_SPEED_SHARE_OF_TOP_SPEED = 0.01
"""Share of its top speed from which on a line with a motor is evaluated."""

MAX_SHOWN_MODES = 8
"""Modes that are reported, at most: higher ones no speed of a vehicle meets."""


@dataclass(frozen=True, kw_only=True)
class OperatingGrid:
    """A vehicle's gears and states with the torque, speed and geometry that go together."""

    parts: VehicleTorsionModel
    demands: tuple[LineStateDemand, ...]
    adjacent_rotors: GearboxAndAxleRotors = field(default_factory=GearboxAndAxleRotors)
    unsettled_motions: list[str] = field(default_factory=list[str])
    failed_launches: list[tuple[Launch, str]] = field(default_factory=list[tuple[Launch, str]])

    @property
    def main(self) -> LineStateDemand:
        """The line whose speed everything is referred to."""
        return self.demands[0]

    @property
    def gears(self) -> tuple[EvaluationCondition, ...]:
        """The gears, or the top speed where there are none."""
        if self.main.gears is None:
            return (EvaluationCondition("speed", "top speed"),)
        return tuple(EvaluationCondition("gear", name) for name in self.main.gears.names)

    @property
    def doubts(self) -> Iterator[str]:
        """What is left out."""
        for name in self.parts.excluded_lines:
            yield f"line {name} turns at another speed: its joints are not counted in torsion"
        if self.unsettled_motions:
            where = "; ".join(dict.fromkeys(self.unsettled_motions))
            yield f"no steady forced motion settles, amplitudes by the joints' leads alone: {where}"
        for wanted, why in self.failed_launches:
            yield f"launch in gear {wanted.gear}: {why}"

    @cached_property
    def _driven(self) -> FloatArray:
        """1 where a state drives, nan where brakes alone hold the axle, (S,)."""
        return np.where(
            self.main.static_state.line.in_suspension_state("windup brake"), np.nan, 1.0
        )

    @cached_property
    def _fastest(self) -> FloatArray:
        """Highest speed of each gear in each state, (G, S) rad/s."""
        said = speed_stated_by_application(self.main.static_state.line)
        if self.main.gears is None:
            return (self.main.speed * self._driven)[None]
        return np.fmin(self.main.gears.speed.max(-1)[:, None], said) * self._driven

    @cached_property
    def closed_ranges(self) -> FloatArray:
        """Speeds with the clutch closed, (G, S, 2) rad/s: from idling, or a crawl of a motor."""
        top = self._fastest
        if self.main.gears is None:
            return np.stack([top, top], axis=-1)
        low = np.maximum(
            (self.parts.idle / self.parts.ratios)[:, None], MIN_MOTOR_SPEED_SHARE_OF_TOP_SPEED * top
        )
        there = low <= top
        return np.stack([np.where(there, low, np.nan), np.where(there, top, np.nan)], axis=-1)

    @cached_property
    def slipping_ranges(self) -> FloatArray:
        """Speeds while the clutch slips, (G, S, 2) rad/s: gears that vehicles start in.

        Up to where the clutch locks: the line turns as the engine is held at in first gear or
        those of the file's launches ahead; below a fifth of it the launch itself is evaluated.
        """
        top = self._fastest
        if self.main.gears is None or self.parts.starting_device == "motor":
            return np.full((*top.shape, 2), np.nan)
        ahead = [x for x in default_launches(self.application) if x.gear in self.parts.gears]
        held = dict.fromkeys({x.gear for x in ahead} or {"1"}, self.parts.idle)
        if self.application.engine is not None:
            for launch in ahead:
                turning = launch_engine_speed(self.parts, launch)
                held[launch.gear] = max(held.get(launch.gear, 0.0), turning)
        turns = np.array([held.get(name, np.nan) for name in self.parts.gears])
        high = np.fmin((turns / self.parts.ratios)[:, None], top)
        high = np.where(np.isfinite(turns)[:, None] & np.isfinite(top), high, np.nan)
        return np.stack([0.2 * high, high], axis=-1)

    @property
    def application(self) -> "Application":
        """Settings of the study."""
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
        n, T = largest_torque_from_standstill(self.main.gears.speed, self.main.gears.torque)
        found = [np.interp(speed[k], n[k], T[k]) for k in range(len(n))]
        return np.fmin(np.stack(found), most)

    @cached_property
    def geometry(self) -> tuple[FloatArray, FloatArray]:
        """Angles and places of all joints that count, (G, S, J) rad, wound up by full torque."""
        beta: list[FloatArray] = []
        place: list[FloatArray] = []
        low = np.zeros(self._fastest.shape)
        T = self.torque(low)
        for asked in self.demands:
            line = asked.static_state.line
            share = line.nominal_torque_share / self.main.static_state.line.nominal_torque_share
            under = demand_with_axle_moved_by_torque(asked, torque=share * T, speed=low)
            if line.line.name in self.parts.excluded_lines:
                continue
            b, p = joint_angles_and_pin_angles(
                under.layout.directions, line.line.phases, line.line.is_cross
            )
            beta.append(b)
            place.append(p)
        return np.concatenate(beta, axis=-1), np.concatenate(place, axis=-1)

    def at(
        self,
        powertrain: PowertrainModel,
        found: TorsionalModes,
        speed: FloatArray,
        index: GearAndStateIndices,
    ) -> "_OperatingSamples":
        """Return what counts at speeds (P,) rad/s of gears and states `index`, (P,) each."""
        g, s = index
        line = replace(powertrain, line=powertrain.line.select_case(g, s),
                       slip_length=powertrain.slip_length[s]).with_rolling_tyres(speed)  # fmt: skip
        one = TorsionalModes(frequency=found.frequency[g, s], shape=found.shape[g, s])
        every = np.broadcast_to(speed[:, None, None], (len(speed), *self._fastest.shape))
        T = self.torque(np.moveaxis(every, 0, -1))[g, s, np.arange(len(speed))]
        force = powertrain.balanced_torques(T, one.shape[..., 0])
        twist, torque = static_response(line, one, force)
        beta, place = (v[g, s] for v in self.geometry)
        turned = twist[..., line.joints]
        return _OperatingSamples(
            line=line,
            modes=one,
            mean=torque,
            running=TorsionalOperatingPoint(
                beta=beta, pin_angle=place, mean_torque=force, speed=speed
            ),
            pins=place + turned - turned[..., :1],
            through=_through(powertrain, torque),
        )

    def driven(self, powertrain: PowertrainModel, ranges: FloatArray) -> PowertrainVibration:
        """Return the modes, and the largest torques at the speeds that there are."""
        found = torsional_modes(powertrain.line)
        G, S, n = found.frequency.shape
        damping = np.zeros((G, S, n))
        known = np.isfinite(ranges).all(-1)
        low, high = (np.where(known, ranges[..., k], 1.0) for k in (0, 1))
        shown = min(n, MAX_SHOWN_MODES + 1)
        for k in range(1, shown):
            speed = np.clip(found.frequency[..., k] / 2, low, high)
            mode = TorsionalModes(
                frequency=found.frequency[..., k : k + 1], shape=found.shape[..., k : k + 1]
            )
            damping[..., k] = damped_modes(powertrain.with_rolling_tyres(speed), mode)[1][..., 0]
        springs = len(powertrain.springs)
        torque = np.full((G, S, len(EXCITED_ORDERS), springs), np.nan)
        speed_at = np.full_like(torque, np.nan)
        mean = np.full((G, S, springs), np.nan)
        total, peak, ratio = (np.full_like(mean, np.nan) for _ in range(3))
        acceleration = np.full((G, S, len(self.demands)), np.nan)

        def vibration() -> PowertrainVibration:
            return PowertrainVibration(
                powertrain=powertrain,
                modes=found,
                damping=damping,
                ranges=ranges,
                torque=torque,
                speed=speed_at,
                mean_torque=mean,
                worst_vibratory_torque=total,
                peak_torque=peak,
                vibratory_ratio=ratio,
                acceleration=acceleration,
            )

        index, speeds = _candidates(found, damping, ranges, shown)
        if not len(speeds):
            return vibration()
        speeds = self._at_peaks(powertrain, found, speeds, index)
        now = self.at(powertrain, found, speeds, index)
        moved = forced_torsional_response(
            now.line, now.running, found=now.modes, tolerance=1e-7, strict=False
        )
        size = np.stack([np.abs(moved.order(o)) for o in EXCITED_ORDERS], axis=-2)
        lost = np.asarray(np.isnan(size).any((-1, -2)))
        size = np.where(lost[:, None, None], self._leads_alone(now), size)
        self.unsettled_motions.extend(
            f"gear {self.parts.gears[g]}, {self.parts.states[s]}, {speeds[c] / rpm:.0f} rpm"
            for c, (g, s) in enumerate(zip(*index, strict=True))
            if lost[c]
        )
        together = size.sum(-2)
        pinions = [
            powertrain.freedoms.index((d.installed.line.name, Part("pinion"))) for d in self.demands
        ]
        faster = [(o * speeds[:, None]) ** 2 for o in EXCITED_ORDERS]
        turned = [np.abs(moved.rotation[..., o // 2, pinions]) for o in EXCITED_ORDERS]
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
        return vibration()

    @staticmethod
    def _leads_alone(now: "_OperatingSamples") -> FloatArray:
        """Orders of every spring's torque by the joints' leads alone, (P, orders, springs) N m."""
        each = (
            first_order_torques(now.line, now.running, pins=now.pins, torque=now.through,
                        order=np.full(now.running.speed.shape, order))
            for order in EXCITED_ORDERS
        )  # fmt: skip
        return np.abs(np.stack(list(each), axis=-2))

    def _at_peaks(
        self,
        powertrain: PowertrainModel,
        found: TorsionalModes,
        brackets: FloatArray,
        index: GearAndStateIndices,
    ) -> FloatArray:
        """Return the speed of the largest order 2 or 4 within brackets (P, 3): golden section.

        The third of a bracket is its order. Where its ends are one the speed is there.
        """
        low, high, order = brackets.T
        mine = self._of_line(powertrain)
        shrink = (np.sqrt(5) - 1) / 2

        def size(speed: FloatArray) -> FloatArray:
            now = self.at(powertrain, found, speed, index)
            doubled = first_order_torques(
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

    def zones(self, closed: PowertrainVibration) -> Iterator[ParametricResonance]:
        """Yield the zones that speeds come near, at the nearest speed of each gear and state."""
        w, zeta, ranges = closed.modes.frequency, closed.damping, closed.ranges
        known = np.isfinite(ranges).all(-1)
        if not known.any():
            return
        top = float(np.nanmax(ranges))
        low, high = (np.where(known, ranges[..., k], 1.0) for k in (0, 1))
        g, s = np.nonzero(np.ones(known.shape, dtype=bool))
        for i, j in combinations_with_replacement(
            range(1, min(w.shape[-1], MAX_SHOWN_MODES + 1)), 2
        ):
            centre = (w[..., i] + w[..., j]) / 2
            if (i, j) != (1, 1) and centre.min() > 1.1 * top:
                continue
            nearest = np.clip(centre, low, high)
            now = self.at(closed.powertrain, closed.modes, nearest.ravel(), (g, s))
            H = modal_coupling_by_joint_order_2(
                now.line, now.modes, now.running, pins=now.pins, torque=now.through
            )
            pair = tuple(w[..., k].ravel() for k in (i, j))
            decay = tuple((zeta[..., k] * w[..., k]).ravel() for k in (i, j))
            rate, openness = zone_growth_rate(
                H, modes=(i, j), frequency=(pair[0], pair[1]), decay=(decay[0], decay[1]),
                speed=nearest.ravel(),
            )  # fmt: skip
            yield ParametricResonance(
                modes=(i, j),
                speed=centre,
                nearest_speed=np.where(known, nearest, np.nan),
                growth=np.where(known, rate.reshape(known.shape), np.nan),
                openness=np.where(known, openness.reshape(known.shape), np.nan),
            )

    def curve(self, closed: PowertrainVibration, points: int = 60) -> tuple[FloatArray, FloatArray]:
        """Return speeds (k,) and the main line's largest torque (G, S, orders, k) there."""
        ranges = closed.ranges
        if not np.isfinite(ranges).any():
            return np.zeros(0), np.zeros((*ranges.shape[:2], len(EXCITED_ORDERS), 0))
        low, high = float(np.nanmin(ranges[..., 0])), float(np.nanmax(ranges[..., 1]))
        met = closed.speed[np.isfinite(closed.speed)]
        speeds = np.unique(np.concatenate([np.linspace(low, high, points), np.unique(met)]))
        spread = np.empty((*ranges.shape[:2], len(EXCITED_ORDERS), len(speeds)))
        spread[:] = np.nan
        inside = (speeds >= ranges[..., :1] - 1e-9) & (speeds <= ranges[..., 1:] + 1e-9)
        g, s, k = np.nonzero(inside)
        mine = self._of_line(closed.powertrain)
        for part in np.array_split(np.arange(len(g)), max(1, len(g) // 400)):
            now = self.at(closed.powertrain, closed.modes, speeds[k[part]], (g[part], s[part]))
            for o, order in enumerate(EXCITED_ORDERS):
                size = np.abs(
                    first_order_torques(now.line, now.running, pins=now.pins, torque=now.through,
                                order=np.full(len(part), order))
                )  # fmt: skip
                spread[g[part], s[part], o, k[part]] = size[:, mine].max(-1)
        return speeds, spread

    def _of_line(self, powertrain: PowertrainModel) -> list[int]:
        """Return the places of the lines' own springs: shafts and pinions."""
        return [k for k, (_, p) in enumerate(powertrain.springs) if p.kind in {"shaft", "pinion"}]

    def largest_firing_torque(self, closed: PowertrainVibration) -> FloatArray:
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
                force = np.zeros_like(now.running.mean_torque)
                force[:, 0] = self.parts.firing_torque * ratio
                size = np.abs(spring_torque_response(now.line, order * speeds, force))
                out[k] = np.maximum(out[k], size.max(0))
        return out

    def launches(self) -> Iterator[LaunchResult]:
        """Yield the vehicle's starts from rest."""
        if self.application.engine is None or self.main.gears is None:
            return
        for wanted in default_launches(self.application):
            try:
                ahead = wanted.gear in self.parts.gears
                yield simulate_launch(self.parts if ahead else self.astern, self.demands, wanted)
            except ConvergenceError as error:
                self.failed_launches.append((wanted, str(error)))

    @cached_property
    def astern(self) -> VehicleTorsionModel:
        """The vehicle in its reverse gears."""
        return vehicle_torsion_model(
            self.application, surroundings=self.adjacent_rotors, astern=True
        )

    def lateral(self, asked: LineStateDemand, loss: float) -> FloatArray:
        """Return the largest lateral growth of each hung shaft in each gear, (G, shafts) 1/s."""
        shafts = asked.installed.line.shafts[:-1]
        ranges = self.closed_ranges
        pace = asked.installed.speed_ratio / self.main.installed.speed_ratio
        share = (
            asked.static_state.line.nominal_torque_share
            / self.main.static_state.line.nominal_torque_share
        )
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
class _OperatingSamples:
    """A line at P speeds of its gears and states."""

    line: TorsionalNetwork
    modes: TorsionalModes
    running: TorsionalOperatingPoint
    pins: FloatArray
    mean: FloatArray
    through: FloatArray


def _through(powertrain: PowertrainModel, torque: FloatArray) -> FloatArray:
    """Torque that each joint passes on, (..., J) N m: that of what is twisted behind it."""
    n = powertrain.line.size
    behind = powertrain.line.springs[:, n:]
    return torque @ behind


def _candidates(
    found: TorsionalModes, damping: FloatArray, ranges: FloatArray, shown: int
) -> tuple[GearAndStateIndices, FloatArray]:
    """Brackets (P, 3) low, high, order in which a torque may be largest, of gears and states.

    Both ends of every range, its thirds, and the neighbourhood of each resonance in it.
    """
    index: list[tuple[int, int]] = []
    brackets: list[tuple[float, float, float]] = []
    for g, s in np.argwhere(np.isfinite(ranges).all(-1)).tolist():
        low, high = ranges[g, s].tolist()
        for end in {low, high}:
            index.append((g, s))
            brackets.append((end, end, EXCITED_ORDERS[0]))
        # Between resonances a hump may be broad: a few parts of the range are looked at too.
        parts = np.linspace(low, high, 4).tolist()
        for a, b in pairwise(parts):
            if a < b:
                index.append((g, s))
                brackets.append((a, b, EXCITED_ORDERS[0]))
        for k in range(1, shown):
            for order in EXCITED_ORDERS:
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


def _lateral(shaft: Shaft, between: FloatArray, torque: float, loss: float) -> float:
    """Return the largest growth of a hung shaft in a range of speeds; nan if held rigidly.

    Of the shaft swinging on its rubber: the damping of its bending modes is not given.
    """
    bearing, tube = shaft.centre_bearing, shaft.tube
    across = bearing and bearing.transverse_stiffness
    if bearing is None or across is None or tube is None:
        return float("nan")
    vertical, lateral = across
    k = (vertical + lateral) / 2
    length = shaft.length - bearing.from_rear_joint
    # On its bearing the shaft swings about the joint like a rod: k L² = m L²/3 w².
    swing = np.sqrt(k / (tube.mass_per_length * length / 3 + shaft.yoke_mass[1]))
    whirl = flexible_shaft_system(
        speed=np.linspace(between[0], between[1], 8), torque=torque, length=length,
        bending_stiffness=tube.bending_stiffness, mass_per_length=tube.mass_per_length,
        bearing=k, bearing_difference=(vertical - lateral) / 2,
        bearing_damping=loss * k / swing,
        rotary_inertia=tube.polar_inertia_per_length / 2, end_mass=shaft.yoke_mass[1],
        follower=1.0, functions=1,
    )  # fmt: skip
    return float(growth_rate(whirl.periodic_system, tolerance=1e-8).max())
