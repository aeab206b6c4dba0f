"""What a line does: every quantity of the method, for cases on leading axes.

One code path serves one design and a million: the states of an application stand on the
last leading axis, variants of a study on axes before it.
"""

from collections.abc import Callable, Mapping
from dataclasses import field, fields, replace
from functools import cached_property
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from cardan.base.arrays import ArrayLike, BoolArray, FloatArray, stacked
from cardan.base.frozen import dataclass
from cardan.base.part import Mode
from cardan.base.units import g
from cardan.demand.clearance import clearances
from cardan.demand.points import Curves, curves
from cardan.demand.states import Demand, demand_under, each_axle_load
from cardan.kinematics import constant_velocity, equivalent
from cardan.kinematics.chain import Turn, joint_angles, pin_phases, turn
from cardan.kinematics.equivalent import Excitation
from cardan.loads import (
    Loads,
    Rotating,
    bearing_pair,
    loads,
    slip_force,
    small_angle,
    unbalance,
)
from cardan.loads.cycle import Cycle
from cardan.loads.rubber import Suspended
from cardan.loads.running import Running
from cardan.model import layout
from cardan.model.application import (
    RIDING,
    Application,
    DutyPoint,
    Obstacle,
    cycle_points,
)
from cardan.model.laminate import CompositeTube
from cardan.model.layout import Layout
from cardan.model.parts import JointKind, JointSize, Line, Tube
from cardan.model.seat import Seat
from cardan.quantity import points
from cardan.quantity.points import Points, Spread, Tries
from cardan.shaft import beams, composite, life, strength, whirl

SAMPLES = 16
"""Samples of a turn for the loads: under a constant torque they have orders 0 and 2 alone."""


def _as_it_is(demand: Demand) -> Layout:
    return demand.layout


@dataclass(frozen=True, kw_only=True)
class Response:
    """Everything computed for one line; leading axes are (variants ..., states).

    What the application gives no grounds for is nan, and no limit asks about it.
    """

    application: Application
    demand: Demand
    layout: Layout
    phases: FloatArray
    lay: Callable[[Demand], Layout] = field(default=_as_it_is, repr=False, compare=False)
    """Where the line runs at other torques: with its bearings and axle moved like here."""
    seats: Mapping[int, Seat] = field(default_factory=dict[int, Seat], repr=False, compare=False)
    """Brackets that give, by the bearing, from 0, that hangs in them; others are rigid."""
    under_torque: bool = False
    """Whether its turn is asked as torque twists its shafts (`points.settled`)."""

    @property
    def line(self) -> Line:
        """The line this is about."""
        return self.demand.installed.line

    @property
    def sizes(self) -> tuple[JointSize | None, ...]:
        """The catalogue's size of each joint, None where it is not given."""
        return self.line.joints or (None,) * self.line.joint_count

    @property
    def kinds(self) -> tuple[str, ...]:
        """What kind of state each is, as limits know it."""
        return tuple(s.counts_as for s in self.application.states)

    @property
    def lasting(self) -> BoolArray:
        """Which states are driven in for long, (states,): the axle rides under its load."""
        return np.array([kind in RIDING for kind in self.kinds])

    @property
    def duty(self) -> tuple[DutyPoint, ...]:
        """The duty cycle as the line turns in it; empty where the application has none.

        An application's cycle is that of the gearbox output, of which the line has its share.
        A named one is of the line's largest torque and top speed in the states that last.
        """
        line, named = self.demand.standing.line, self.application.duty_cycle
        if named is not None:
            torque = np.abs(self.demand.torque)
            if np.any(line.share != line.usual_share):  # behind a locked differential, at times
                usual = line.usual_share / line.share * self.demand.engine_torque
                torque = np.fmin(torque, np.abs(usual))
            most, speed = map(self._largest, (torque, self.demand.speed))
            return cycle_points(named, torque=most, speed=speed)
        ratio = self.demand.installed.speed_ratio
        return tuple(
            replace(p, torque=line.usual_share * p.torque, speed=ratio * p.speed)
            for p in self.application.duty
        )

    def _largest(self, values: FloatArray) -> Any:
        """Return the largest size of values (..., states) in states that last, (..., 1)."""
        lasting = np.where(self.lasting, np.abs(values), np.nan)
        if np.isnan(lasting).all():
            return np.nan
        most = np.nanmax(lasting, axis=-1, keepdims=values.ndim > 1)
        return most if values.ndim > 1 else float(most)

    @cached_property
    def turn(self) -> Turn:
        """The exact turn of the chain; its shafts as they are welded, as limits ask of it."""
        return self._turned(self.demand.torque if self.under_torque else 0.0)

    @cached_property
    def twisted(self) -> Turn:
        """The same as torque twists its shafts, which is how it carries that."""
        return self._turned(self.demand.torque)

    def _turned(self, torque: ArrayLike, *, samples: int = SAMPLES) -> Turn:
        phases = self.line.twisted(self.phases, np.nan_to_num(torque))
        d = self.layout.directions
        return turn(d, phases=phases, crosses=self.line.crosses, samples=samples)

    @cached_property
    def angles(self) -> FloatArray:
        """True joint angles, (..., n) rad."""
        return joint_angles(self.layout.directions)

    @property
    def pairs(self) -> tuple[int, ...]:
        """Shafts, from 0, whose two joints are there to cancel: every other, from the rear.

        With an odd number of joints the first stands alone, as service procedures have it.
        Both are crosses: a joint of constant velocity has nothing to cancel.
        """
        crosses, found, k = self.line.crosses, list[int](), self.line.joint_count - 1
        while k > 0:
            paired = crosses[k] and crosses[k - 1]
            if paired:
                found.append(k - 1)
            k -= 2 if paired else 1
        return tuple(found[::-1])

    @property
    def lone(self) -> tuple[int, ...]:
        """Joints, from 0, that are crosses without another on their shaft to cancel them."""
        paired = {j for k in self.pairs for j in (k, k + 1)}
        return tuple(k for k, cross in enumerate(self.line.crosses) if cross and k not in paired)

    @property
    def uneven(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Side and top view angles (..., n) and phases (..., n-1), rad, for AE-7's phasors.

        Those of crosses: others count as straight, with the yokes behind them a quarter turn on.
        """
        kinds = np.array(self.line.crosses)
        phases = pin_phases(self.phases, self.line.crosses)
        return self.side_angles * kinds, self.top_angles * kinds, phases

    @cached_property
    def pair_differences(self) -> FloatArray:
        """What is left of each pair's two angles, yoke phase considered, (..., pairs) rad.

        |D_k² - e^{2iε} D_{k+1}²| / (|D_k| + |D_{k+1}|): the difference of the two angles
        where both lie in one plane and the yokes are in line.
        """
        bend = self.angles * np.exp(1j * self.positions)
        k = list(self.pairs)
        front, rear = bend[..., k], bend[..., [j + 1 for j in k]]
        left = np.abs(front**2 - np.exp(2j * self.phases[..., k]) * rear**2)
        both = np.abs(front) + np.abs(rear)
        return np.divide(left, both, out=np.zeros_like(left), where=both > 0)

    @cached_property
    def side_angles(self) -> FloatArray:
        """Side view angles at the joints, (..., n) rad."""
        return np.diff(self.layout.side, axis=-1)

    @cached_property
    def top_angles(self) -> FloatArray:
        """Top view angles at the joints, (..., n) rad."""
        return np.diff(self.layout.top, axis=-1)

    @cached_property
    def positions(self) -> FloatArray:
        """Positions of the joint planes, (..., n) rad in [0, 2 pi)."""
        return equivalent.position(self.side_angles, self.top_angles)

    @cached_property
    def inertias(self) -> FloatArray | None:
        """Polar inertias of the shafts, (..., n-1) kg m²; None where one is not known."""
        known = [
            j for s in self.line.shafts
            if (j := s.polar_inertia) is not None and not np.isnan(j).all()
        ]  # fmt: skip
        return stacked(known) if len(known) == len(self.line.shafts) else None

    @cached_property
    def excitation(self) -> Excitation:
        """Torsional and inertia excitation at top speed, exactly; without torques."""
        return equivalent.excitation(self.turn, speed=self.demand.speed)

    @cached_property
    def shaft_torques(self) -> tuple[FloatArray, FloatArray]:
        """Torques to accelerate the shafts, in drive and coast, (...) N m; nan without inertias."""
        if self.inertias is None:
            return np.asarray(np.nan), np.asarray(np.nan)
        return equivalent.shaft_torques(self.turn, speed=self.demand.speed, inertias=self.inertias)

    @cached_property
    def approximations(self) -> dict[str, Excitation]:
        """The same by each approximation of the field, by name."""
        side, top, phases = self.uneven
        return equivalent.approximations(
            side,
            top,
            phases=phases,
            speed=self.demand.speed,
            inertias=self.inertias,
        )

    @cached_property
    def loads(self) -> Loads:
        """Forces round the turn at the state's torque, with weight where it is asked for."""
        return loads(
            self.layout, self.twisted, self.line, torque=self.demand.torque, gravity=self.gravity
        )

    @cached_property
    def forced(self) -> tuple[Loads, ...]:
        """The same with what speeds the shafts up: with no thrust, and with either one.

        At the state's speed, the gearbox turning uniformly; a sliding fit that sticks holds any
        thrust between plus and minus its slip force.
        """
        slip = np.nan_to_num(self.spline_force)
        speed = np.nan_to_num(self.demand.speed)[..., None, None]
        turned = self._turned(self.demand.torque, samples=4 * SAMPLES)
        return tuple(
            loads(
                self.layout,
                turned,
                self.line,
                torque=self.demand.torque,
                inertias=self.inertias,
                accelerations=speed**2 * turned.acceleration,
                gravity=self.gravity,
                thrust=sign * slip,
            )
            for sign in (0, 1, -1)
        )

    @property
    def joint_forces(self) -> FloatArray:
        """Largest force through each joint at the worst thrust, (..., n) N."""
        return np.maximum.reduce([f.joint_forces.peak for f in self.forced])

    @property
    def gravity(self) -> float:
        """Standard gravity where the application counts weight, else 0, m/s²."""
        return g if self.application.include_gravity else 0.0

    @cached_property
    def unbalance(self) -> Rotating | None:
        """Forces once a turn at top speed; None unless asked for."""
        if not self.application.include_unbalance:
            return None
        return unbalance(self.layout, self.line, speed=self.demand.speed)

    @property
    def balanced_at(self) -> FloatArray:
        """Speed the shafts are balanced for: the line's highest, in a state or not, (..., 1) rad/s.

        Shafts that never turn are as good as balanced for any: inf.
        """
        line = self.demand.standing.line
        given, top = (np.asarray(np.nan if v is None else v, dtype=float) for v in (
            line.speed, line.gears and line.gears.top_speed
        ))  # fmt: skip
        top = np.where(np.isnan(given), top, given * line.installed.speed_ratio)
        fastest = np.nan_to_num(self.demand.speed).max(axis=-1, keepdims=True)
        fastest = np.maximum(fastest, np.nan_to_num(top))
        return np.where(fastest > 0, fastest, np.inf)

    @cached_property
    def held(self) -> Suspended | None:
        """How the line can move on its rubber, in each state; None where it has none."""
        return points.held(self)

    @cached_property
    def quick(self) -> Suspended | None:
        """The same on its slowest modes alone, on which what is worst is sought."""
        return None if self.held is None else self.held.slowest(self.line.swings)

    @cached_property
    def own_curves(self) -> Curves:
        """What torque it can have over its speed, in each case that its demand knows of."""
        return curves(self.demand)

    @cached_property
    def curves(self) -> Curves:
        """The same in each case of whatever varies."""
        return points.curves_of(self)

    @cached_property
    def running(self) -> Running:
        """What the bearings carry on their rubber at the state's own torque and top speed."""
        return points.run(self, self.demand, self.layout)

    @cached_property
    def worst(self) -> dict[str, Points]:
        """The operating point at which each bearing's mean, orders and peak are largest."""
        return points.worst(self)

    @cached_property
    def tries(self) -> Tries | None:
        """The operating points among which its bearings' worst ones are sought."""
        return points.tries(self)

    @cached_property
    def tried(self) -> points.Tried | None:
        """What it nearly does there; None of a line that is not on rubber."""
        return points.tried(self)

    @cached_property
    def worst_travel(self) -> Points | None:
        """The operating point at which each bearing goes farthest across its rubber, in m."""
        return points.worst_travel(self)

    @cached_property
    def worst_reach(self) -> Points | None:
        """The operating point at which each shaft comes nearest to each obstacle, on rubber."""
        return points.worst_reach(self)

    @cached_property
    def stops(self) -> FloatArray:
        """How far the rubber of each centre bearing goes, (..., n-2) m; nan where nobody says."""
        told = (b.travel for b in self.line.centre_bearings)
        return stacked(np.nan if t is None else t for t in told)

    @cached_property
    def worst_joints(self) -> Points | None:
        """The operating point at which each joint is shaken most on rubber."""
        return points.worst_joints(self)

    @cached_property
    def worst_growth(self) -> Points | None:
        """The operating point at which the line's swinging grows most, or dies away least."""
        return points.worst_growth(self)

    @cached_property
    def spread(self) -> Spread | None:
        """The line at the corners of its torque over speed; None where nobody knows them."""
        return points.spread(self)

    def bearing_force(self, name: str) -> FloatArray:
        """Return a force of `points.FORCES` on each bearing where it is largest, (..., n-2) N.

        Where a line has no operating point it is that of rigid bearings at its own torque.
        """
        found = getattr(self.worst[name].running, name) if name in self.worst else None
        if found is not None and not np.isnan(found).any():
            return found
        rigid = {
            "static": lambda: layout.size(self.loads.bearing_forces.static),
            "dynamic": lambda: self.loads.bearing_forces.dynamic,
            "peak": lambda: self.bearing_peaks,
        }[name]()
        return rigid if found is None else np.where(np.isnan(found), rigid, found)

    @cached_property
    def bearing_peaks(self) -> FloatArray:
        """Largest force on each centre bearing if it is rigid, (..., n-2) N."""
        once = self.unbalance
        peak = self.loads.bearing_forces.peak
        return peak + once.bearing_forces if once else peak

    @cached_property
    def axle_loads(self) -> tuple[FloatArray, FloatArray]:
        """Load of every axle of the vehicle at rest and at the slip limit, (..., axles) N each."""
        return each_axle_load(self.demand.standing.line)

    @cached_property
    def axle_to_frame(self) -> FloatArray:
        """From the axle's centre up to the frame, (...) m; nan where nobody gives it."""
        suspension = self.demand.standing.line.suspension
        given = suspension.axle_to_frame if suspension else None
        return (np.nan if given is None else given) - self.demand.travel

    @cached_property
    def couples(self) -> tuple[FloatArray, FloatArray]:
        """Largest secondary couple of each joint on the member ahead and behind, (..., n) N m.

        What is left of a cross's moment across a member: T tan β at most on the driving one.
        """
        moment, d = self.loads.joint_moments.waves, self.layout.directions
        ahead, behind = (_across(moment, axis).peak for axis in (d[..., :-1, :], d[..., 1:, :]))
        return ahead, behind

    @cached_property
    def bending(self) -> FloatArray:
        """Largest bending moment in each shaft, (..., n-1) N m, at the state's torque.

        Without weight a shaft carries nothing between its joints and its bearing, so the
        moment is largest at one of them.
        """
        ahead, behind = self.couples
        ends = np.maximum(behind[..., :-1], ahead[..., 1:])
        hung = [s.centre_bearing.from_rear_joint for s in self.line.shafts if s.centre_bearing]
        if not hung:
            return ends
        light = (
            loads(self.layout, self.twisted, self.line, torque=self.demand.torque)
            if self.gravity
            else self.loads
        )
        force = light.joint_forces.waves[..., 1:-1, :, :]
        moment = light.joint_moments.waves[..., 1:-1, :, :]
        d = self.layout.directions[..., 1:-2, :]
        arm = (stacked(hung)[..., None] * d)[..., None, :]
        inside = np.maximum(ends[..., :-1], _across(-moment - np.cross(arm, force), d).peak)
        last = np.broadcast_to(ends[..., -1:], (*inside.shape[:-1], 1))
        return np.concatenate([inside, last], axis=-1)

    @cached_property
    def tube_stress_utilisation(self) -> FloatArray:
        """Von Mises stress of torque and bending in each tube over yield, (..., n-1)."""
        torque, bending = np.abs(self.demand.torque), self.bending

        def used(tube: Tube | CompositeTube | None, moment: FloatArray) -> FloatArray:
            if not isinstance(tube, Tube) or tube.material.yield_strength is None:
                return np.full_like(moment, np.nan)
            shear = strength.tube_shear(torque, outer=tube.outer, inner=tube.inner)
            normal = strength.tube_bending(moment, outer=tube.outer, inner=tube.inner)
            stress = strength.von_mises(shear, normal=normal)
            return self.application.shock_factor * stress / tube.material.yield_strength

        tubes = (s.tube for s in self.line.shafts)
        return stacked(used(t, m) for t, m in zip(tubes, np.moveaxis(bending, -1, 0), strict=True))

    @cached_property
    def journal_force(self) -> FloatArray:
        """Largest force on a journal of each cross and its fork arm, (..., n) N.

        At the state's torque; nan where the size of the cross is not known.
        """
        across = stacked(np.nan if s is None or s.across is None else s.across for s in self.sizes)
        uneven = np.abs(self.turn.phasors[..., :-1])
        uneven = np.concatenate([np.zeros_like(uneven[..., :1]), uneven], axis=-1)
        largest = np.abs(self.demand.torque)[..., None] * (1 + uneven) / (1 - uneven)
        return strength.cross_force(largest, across=across, angle=self.angles)

    @property
    def cup_pressure(self) -> FloatArray:
        """Mean pressure of each joint's cups in their yokes, (..., n) Pa; nan where unknown."""
        sizes = [(s and s.cup_diameter, s and s.cup_length) for s in self.sizes]
        diameter, length = (
            stacked(np.nan if v is None else v for v in column)
            for column in zip(*sizes, strict=True)
        )
        return strength.cup_pressure(self.journal_force, diameter=diameter, length=length)

    @cached_property
    def joint_swing(self) -> FloatArray:
        """Speed swing of each double cardan by itself, (..., n) 1; nan of others."""
        return self._of_kind(
            "double cardan",
            lambda size, beta: (
                constant_velocity.double_cardan_swing(
                    beta, length=size.centre_distance, ball=size.ball_from_rear
                )
                if size.centre_distance is not None and size.ball_from_rear is not None
                else np.full_like(beta, np.nan)
            ),
        )

    @cached_property
    def joint_orbit(self) -> FloatArray:
        """Radius in which the centre of each tripod goes round, (..., n) m; nan of others."""
        return self._of_kind(
            "tripod",
            lambda size, beta: (
                constant_velocity.tripod_orbit(beta, radius=size.pitch_radius)
                if size.pitch_radius is not None
                else np.full_like(beta, np.nan)
            ),
        )

    def _of_kind(
        self, kind: JointKind, value: Callable[[JointSize, FloatArray], FloatArray]
    ) -> FloatArray:
        return stacked(
            value(size, beta) if size and size.kind == kind else np.full_like(beta, np.nan)
            for size, beta in zip(self.sizes, np.moveaxis(self.angles, -1, 0), strict=True)
        )

    @cached_property
    def end_bearings(self) -> dict[str, FloatArray]:
        """Largest radial force on the bearings behind the flanges, (...) N by GWB's letters.

        A and B carry the gearbox output, E and F the pinion; B and E are nearer the joint.
        At the worst thrust, and with the shafts' inertia. nan where spacing and overhang are
        not given.
        """
        each = [self._behind(forces) for forces in self.forced]
        return {letter: np.maximum.reduce([f[letter] for f in each]) for letter in "ABEF"}

    @cached_property
    def static_end_bearings(self) -> dict[str, FloatArray]:
        """The same without thrust and inertia."""
        return self._behind(self.loads)

    def _behind(self, forces: Loads) -> dict[str, FloatArray]:
        line, d = self.line, self.layout.directions
        ends = {
            "AB": (forces.gearbox_force, forces.gearbox_moment, d[..., 0, :],
                   line.gearbox_bearing_spacing, line.gearbox_bearing_overhang),
            "FE": (forces.pinion_force, forces.pinion_moment, -d[..., -1, :],
                   line.pinion_bearing_spacing, line.pinion_bearing_overhang),
        }  # fmt: skip
        cases = forces.joint_forces.waves.shape[:-3]
        found = dict.fromkeys("ABEF", np.full(cases, np.nan))
        for letters, (force, moment, outward, spacing, overhang) in ends.items():
            if spacing is not None and overhang is not None:
                pair = bearing_pair(
                    force, moment, outward=outward, spacing=spacing, overhang=overhang
                )
                found |= {k: c.peak for k, c in zip(letters, pair, strict=True)}
        return found

    @cached_property
    def spline_force(self) -> FloatArray:
        """Axial force that slides the spline at the state's torque, (...) N; nan if not known."""
        return self.slip_at(self.demand.torque) + np.zeros(self.layout.directions.shape[:-2])

    def slip_at(self, torque: FloatArray) -> FloatArray:
        """Return the axial force (...) N that slides the spline at torques (...) N m."""
        spline = self.line.shafts[-1].spline
        if spline is None or spline.mean_radius is None:
            return np.full(np.shape(torque), np.nan)
        return slip_force(torque, friction=spline.friction, mean_radius=spline.mean_radius)

    @cached_property
    def small_angle_bearings(self) -> tuple[FloatArray, FloatArray]:
        """Static (..., n-2, 3) N and dynamic (..., n-2) N force by the small-angle formula.

        Weight, where it is asked for, is added as it is: it knows no small angles.
        """
        with np.errstate() if self.line.measured else np.errstate(invalid="ignore"):
            cycle = small_angle(self.layout, self.line, torque=self.demand.torque)
        weight = loads(self.layout, self.turn, self.line, torque=0.0, gravity=self.gravity)
        return cycle.static + weight.bearing_forces.static, cycle.dynamic

    @cached_property
    def critical_speeds(self) -> FloatArray:
        """Critical speed of each shaft by itself, (..., n-1) rad/s; nan without a tube."""
        tubes = [s.tube for s in self.line.shafts]
        lengths = np.moveaxis(self.layout.lengths, -1, 0)
        return stacked(
            np.full_like(length, np.nan) if tube is None else _alone(tube, length)
            for tube, length in zip(tubes, lengths, strict=True)
        )

    @property
    def line_modes(self) -> whirl.Modes | None:
        """How the line whirls as beams on its bearings; None without tubes.

        As installed: a spline's travel changes it by less than its own uncertainty.
        """
        if self.demand not in _MODES:
            _MODES[self.demand] = _line_modes(self.line, self.demand.installed.layout.lengths)
        return _MODES[self.demand]

    @cached_property
    def line_critical_speed(self) -> FloatArray:
        """Lowest speed that bends the line as beams on its bearings, (...) rad/s.

        The same in every state; nan without tubes.
        """
        modes = self.line_modes
        return whirl.line_critical_speed(modes) if modes else np.asarray(np.nan)

    @cached_property
    def bearing_resonance(self) -> FloatArray:
        """Lowest speed at which the line bounces on its rubber, (...) rad/s; nan if it has none."""
        modes = self.line_modes
        found = whirl.bearing_resonance(modes) if modes else np.asarray(np.nan)
        return np.where(np.isfinite(found), found, np.nan)

    @cached_property
    def sizing_torque(self) -> FloatArray:
        """Largest torque round a turn at each joint, (..., n) N m, for the joints' size.

        From the engine where it is known, of an operating point in its gear, unless a state
        carries more, times the application's shock factor; where brakes wind the axle up, what
        the line carries.
        """
        demand = self.demand
        braked = np.array([kind == "windup brake" for kind in self.kinds])
        own = np.isnan(demand.engine_torque) | braked
        asked = np.where(own, demand.torque, np.fmax(demand.engine_torque, np.abs(demand.torque)))
        uneven = np.abs(self.turn.phasors[..., :-1])
        uneven = np.concatenate([np.zeros_like(uneven[..., :1]), uneven], axis=-1)
        largest = self.application.shock_factor * np.abs(asked)
        return largest[..., None] * (1 + uneven) / (1 - uneven)

    @property
    def joint_torque_utilisation(self) -> FloatArray:
        """Largest torque at each joint over its elastic limit, (..., n); nan where not known."""
        return self.sizing_torque / self.rating("peak_torque")

    @cached_property
    def joint_fatigue_utilisation(self) -> FloatArray:
        """Share of each joint's fatigue rating, from coast to drive torque, (..., n).

        Every state's torques taken as a swing that comes back for ever; nan where the
        catalogue has no reversing torque.
        """
        reversing, pulsating = self.rating("reversing_torque"), self.rating("pulsating_torque")
        return strength.joint_fatigue_utilisation(
            np.maximum(self.demand.torque, 0.0)[..., None],  # where it coasts: from 0
            lowest=-np.nan_to_num(self.demand.coast_torque)[..., None],
            reversing=reversing,
            pulsating=np.where(np.isnan(pulsating), reversing, pulsating),
        )

    def rating(self, name: str) -> FloatArray:
        """Return a rating of every joint, (..., n); nan where the catalogue has none."""
        values = [getattr(s, name) if s else None for s in self.sizes]
        return stacked(np.nan if v is None else v for v in values)

    @cached_property
    def clearances(self) -> FloatArray:
        """Free distance of shafts and this line's obstacles, (..., n-1, obstacles) m."""
        return clearances(self.layout, self.line, self.obstacles, travel=self.demand.travel)

    @property
    def obstacles(self) -> tuple[Obstacle, ...]:
        """The obstacles of this line."""
        return tuple(o for o in self.application.obstacles if o.line == self.line.name)

    @cached_property
    def spline_travel(self) -> FloatArray:
        """Length of the last shaft less that of the reference layout, (...) m."""
        return self.layout.lengths[..., -1] - self.demand.installed.layout.lengths[..., -1]

    @cached_property
    def tube_shear_utilisation(self) -> FloatArray:
        """Shear stress of each tube over yield in shear, (..., n-1); nan where not known.

        Of a composite tube the share of its strength, at the ply that fails first.
        """
        torque = np.abs(self.demand.torque)
        shock = self.application.shock_factor

        def used(tube: Tube | CompositeTube | None) -> FloatArray:
            if isinstance(tube, CompositeTube):
                return composite.strength_share(tube, torque * shock)
            if tube is None or tube.material.yield_strength is None:
                return np.full_like(torque, np.nan)
            return strength.tube_utilisation(
                torque,
                outer=tube.outer,
                inner=tube.inner,
                yield_strength=tube.material.yield_strength,
                shock_factor=shock,
            )

        return stacked(used(s.tube) for s in self.line.shafts)

    @cached_property
    def tube_buckling_utilisation(self) -> FloatArray:
        """Torque over what buckles the wall of each tube, (..., n-1); nan without a tube.

        Between the joint centres, ends pinned, in the sense plies hold less well.
        """
        lengths = np.moveaxis(self.demand.installed.layout.lengths, -1, 0)

        def holds(tube: Tube | CompositeTube | None, length: FloatArray) -> ArrayLike:
            if tube is None:
                return np.nan
            if isinstance(tube, Tube):
                return strength.tube_buckling_torque(
                    outer=tube.outer, inner=tube.inner, length=length,
                    modulus=tube.material.youngs_modulus, poisson=tube.material.poisson,
                )  # fmt: skip
            return composite.buckling_torque(tube, length)

        tubes = (s.tube for s in self.line.shafts)
        held = stacked(holds(t, length) for t, length in zip(tubes, lengths, strict=True))
        torque = np.abs(self.demand.torque) * self.application.shock_factor
        return torque[..., None] / held

    @property
    def life_ratings(self) -> FloatArray:
        """Torque Td of each joint for its rated life, (n,) N m; nan where not published."""
        found = (life.complete_rating(size) if size else None for size in self.sizes)
        return stacked(np.nan if rating is None else rating for rating in found)

    @cached_property
    def duty_angles(self) -> FloatArray:
        """Joint angles (points, ..., n) rad as the torques of the duty cycle have the axle."""
        each = [(p.torque, p.speed) for p in self.duty]
        cases = np.broadcast_shapes(self.angles.shape[:-1], *(np.shape(v) for p in each for v in p))
        torque, speed = (
            np.stack([np.broadcast_to(v, cases) for v in column])
            for column in zip(*each, strict=True)
        )

        def named(case: tuple[int, ...]) -> str:
            return f"point {case[0] + 1} of the duty cycle with {torque[case]:.4g} N m"

        under = demand_under(self.demand, torque=torque, speed=speed, named=named)
        found = joint_angles(self.lay(under).directions)
        return np.broadcast_to(found, (len(each), *cases, found.shape[-1]))

    @cached_property
    def life(self) -> FloatArray:
        """Life of each joint's needle bearings, (..., n) s; nan where not known.

        Over the duty cycle, at the joint angles of each state that lasts as each point's torque
        has them, unless the cycle gives its own. Worst torque and top speed of a vehicle never
        meet, so without a cycle there is no life.
        """
        duty = self.duty
        if not duty:
            return np.full(self.angles.shape, np.nan)
        torque, speed, shares = (
            stacked(getattr(p, v) for p in duty)[..., None, :] for v in ("torque", "speed", "share")
        )
        fixed = stacked(np.nan if p.angle is None else p.angle for p in duty)[..., None, :]
        angle = np.where(np.isnan(fixed), np.moveaxis(self.duty_angles, 0, -1), fixed)
        wear = life.wear(
            torque,
            speed=speed,
            angle=angle,
            rated_torque=self.life_ratings[..., None],
            prime_mover_factor=self.application.prime_mover_factor,
        )
        each = list(np.moveaxis(wear, -2, 0))
        for k, size in enumerate(self.sizes):
            if size and size.kind != "cross":
                each[k] = life.wear_of(
                    _over_duty(size),
                    torque[..., 0, :],
                    speed=speed[..., 0, :],
                    angle=angle[..., k, :],
                    prime_mover_factor=self.application.prime_mover_factor,
                )
        wear = np.stack(np.broadcast_arrays(*each), axis=-2)
        hours = life.joint_life(wear, shares=shares)
        return np.where(self.lasting[:, None], hours, np.nan)

    def met(self, spots: points.Spots) -> list[list[Mode | None]]:
        """Return the mode on the rubber that an order meets at points (S, parts), None where none.

        Met is what lies within its resonance's width at half its power, ζ each way, and swings
        across the shafts: nothing of a joint pushes along them.
        """
        found: list[list[Mode | None]] = [[None] * spots.speed.shape[1] for _ in spots.speed]
        if self.held is None:
            return found
        orders = np.array([2, 1] if self.application.include_unbalance else [2])
        for part, (torque, speed) in enumerate(zip(spots.torque.T, spots.speed.T, strict=True)):
            modes = self.held.modes(torque=np.nan_to_num(torque))
            slow = np.maximum(modes.frequency, 1e-300)  # torque may buckle a line
            off = np.abs(np.multiply.outer(orders, speed)[..., None] / slow - 1)
            off = np.where(modes.unmoved, np.inf, off)
            for state in range(len(speed)):
                order, k = np.unravel_index(off[:, state].argmin(), off[:, state].shape)
                if off[order, state, k] <= modes.damping[state, k]:
                    shape, frequency = modes.names(state)[k], float(slow[state, k])
                    found[state][part] = Mode(shape, frequency, int(orders[order]))
        return found

    @cached_property
    def resonance_distance(self) -> FloatArray:
        """How far a duty cycle's speeds stay off the modes on the rubber, (...) 1.

        The least |k Ω / ω - 1| of its speeds Ω, of order 2 of the joints, and order 1 where
        unbalance counts, and of the modes ω that its torques leave the line; nan where nobody
        knows, and in states that do not last.
        """
        orders = (1, 2) if self.application.include_unbalance else (2,)
        found = np.full(self.layout.directions.shape[:-2], np.nan)
        if self.held is None or not (duty := self.duty):
            return found
        like = np.zeros(self.held.first.cases)
        each = np.broadcast_arrays(*(v for p in duty for v in (p.torque, p.speed)), like)[:-1]
        torque, speed = np.stack(each[::2]), np.stack(each[1::2])
        modes = self.held.frequencies(torque=torque)[..., : self.line.swings]  # others bend tubes
        modes = np.where(modes > 0, modes, 1e-300)  # torque may buckle a line
        off = np.stack([np.abs(k * speed[..., None] / modes - 1).min(axis=-1) for k in orders])
        found = np.fmin.reduce(off, axis=(0, 1))
        return np.where(self.lasting, found, np.nan)

    @cached_property
    def spline_travel_margin(self) -> FloatArray:
        """Travel left in the spline, (...) m; nan where its stroke is not given.

        Without a spline, in the joints of the last shaft that plunge.
        """
        spline = self.line.shafts[-1].spline
        plunge, draw = (spline.plunge, spline.draw) if spline else (None, None)
        if spline is None:
            slides = [s.plunge for s in self.sizes[-2:] if s and s.plunge is not None]
            plunge = draw = sum(slides) if slides else None
        travel = self.spline_travel
        left = np.full_like(travel, np.inf)
        left = left if plunge is None else np.minimum(left, plunge + travel)
        left = left if draw is None else np.minimum(left, draw - travel)
        return np.where(np.isinf(left), np.nan, left)


_MODES: WeakKeyDictionary[Demand, whirl.Modes | None] = WeakKeyDictionary()
"""Critical modes of each line asked about: once for all layouts that keep its shafts."""


def _alone(tube: Tube | CompositeTube, length: FloatArray) -> FloatArray:
    """Return the critical speed of a shaft by itself: with shear, if it is of plies."""
    if isinstance(tube, CompositeTube):
        return composite.critical_speed(tube, length)
    return whirl.critical_speed(
        length,
        outer=tube.outer,
        inner=tube.inner,
        youngs_modulus=tube.material.youngs_modulus,
        density=tube.material.density,
    )


def _line_modes(line: Line, lengths: FloatArray) -> whirl.Modes | None:
    """Return a line's critical modes; None without tubes."""
    if any(s.tube is None for s in line.shafts) or not np.isfinite(lengths).all():
        return None
    return whirl.critical_modes(beams.line_beams(line, lengths=lengths))


def _across(moment: Any, axis: FloatArray) -> Cycle:
    """Return what is across axes (..., 3) of moments with waves (..., K, 3)."""
    along = axis[..., None, :]
    return Cycle(moment - (moment * along).sum(-1, keepdims=True) * along)


def _over_duty(size: JointSize) -> JointSize:
    """Return a joint whose own numbers, where they vary, leave an axis for a duty cycle."""
    varied = {f.name: getattr(size, f.name) for f in fields(size)}
    return replace(size, **{k: np.asarray(v)[..., None] for k, v in varied.items() if np.ndim(v)})


def respond(
    application: Application,
    demand: Demand,
    *,
    lay: Callable[[Demand], Layout] = _as_it_is,
    phases: ArrayLike | None = None,
) -> Response:
    """Return the response of a line, as installed or moved, and with other yoke phases.

    `lay` says where the line runs, (..., S), at the torques of a demand: as its own layout, or
    with bearings and axle moved (`Demand.corrected`). That and `phases` (..., n-1) may bring
    variants on axes before the states; give the phases of V variants as (V, 1, n-1).
    """
    line = demand.installed.line
    return Response(
        application=application,
        demand=demand,
        layout=lay(demand),
        lay=lay,
        phases=stacked(line.phases) if phases is None else np.asarray(phases, dtype=float),
    )
