"""What a line does: every quantity of the method, for cases on leading axes.

One code path serves one design and a million: the states of an application stand on the
last leading axis, variants of a study on axes before it.
"""

from dataclasses import dataclass
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from cardan.base.arrays import ArrayLike, FloatArray, stacked
from cardan.base.units import g
from cardan.demand.clearance import clearances
from cardan.demand.states import Demand
from cardan.demand.suspension import AT_LIMIT
from cardan.kinematics import equivalent
from cardan.kinematics.chain import Turn, joint_angles, turn
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
from cardan.model.application import Application, Obstacle
from cardan.model.layout import Layout
from cardan.model.parts import JointSize, Line
from cardan.shaft import beams, life, strength, whirl

SAMPLES = 16
"""Samples of a turn for the loads: under a constant torque they have orders 0 and 2 alone."""


PASSING = (*AT_LIMIT, "windup", "windup brake")
"""Suspension states nobody drives in for long."""


@dataclass(frozen=True, kw_only=True)
class Response:
    """Everything computed for one line; leading axes are (variants ..., states).

    What the application gives no grounds for is nan, and no limit asks about it.
    """

    application: Application
    demand: Demand
    layout: Layout
    phases: FloatArray

    @property
    def line(self) -> Line:
        """The line this is about."""
        return self.demand.installed.line

    @property
    def sizes(self) -> tuple[JointSize | None, ...]:
        """The catalogue's size of each joint, None where it is not given."""
        return self.line.joints or (None,) * self.line.joint_count

    @cached_property
    def turn(self) -> Turn:
        """The exact turn of the chain."""
        return turn(self.layout.directions, phases=self.phases, samples=SAMPLES)

    @cached_property
    def angles(self) -> FloatArray:
        """True joint angles, (..., n) rad."""
        return joint_angles(self.layout.directions)

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
        known = [j for s in self.line.shafts if (j := s.polar_inertia) is not None]
        return stacked(known) if len(known) == len(self.line.shafts) else None

    @cached_property
    def excitation(self) -> Excitation:
        """Torsional and inertia excitation at top speed, exactly."""
        return equivalent.excitation(self.turn, speed=self.demand.speed, inertias=self.inertias)

    @cached_property
    def approximations(self) -> dict[str, Excitation]:
        """The same by each approximation of the field, by name."""
        return equivalent.approximations(
            self.side_angles,
            self.top_angles,
            phases=self.phases,
            speed=self.demand.speed,
            inertias=self.inertias,
        )

    @cached_property
    def loads(self) -> Loads:
        """Forces round the turn at the state's torque, with weight where it is asked for."""
        return loads(
            self.layout, self.turn, self.line, torque=self.demand.torque, gravity=self.gravity
        )

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

    @cached_property
    def bearing_peaks(self) -> FloatArray:
        """Largest force on each centre bearing, (..., n-2) N."""
        once = self.unbalance
        peak = self.loads.bearing_forces.peak
        return peak + once.bearing_forces if once else peak

    @cached_property
    def end_bearings(self) -> dict[str, FloatArray]:
        """Largest radial force on the bearings behind the flanges, (...) N by GWB's letters.

        A and B carry the gearbox output, E and F the pinion; B and E are nearer the joint.
        nan where spacing and overhang are not given.
        """
        line, forces, d = self.line, self.loads, self.layout.directions
        ends = {
            "AB": (forces.gearbox_force, forces.gearbox_moment, d[..., 0, :],
                   line.gearbox_bearing_spacing, line.gearbox_bearing_overhang),
            "FE": (forces.pinion_force, forces.pinion_moment, -d[..., -1, :],
                   line.pinion_bearing_spacing, line.pinion_bearing_overhang),
        }  # fmt: skip
        found = dict.fromkeys("ABEF", np.full(d.shape[:-2], np.nan))
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
        spline = self.line.shafts[-1].spline
        radius = spline.mean_radius if spline else None
        if spline is None or radius is None:
            return np.full(self.layout.directions.shape[:-2], np.nan)
        force = slip_force(self.demand.torque, friction=spline.friction, mean_radius=radius)
        return force + np.zeros(self.layout.directions.shape[:-2])

    @cached_property
    def small_angle_bearings(self) -> tuple[FloatArray, FloatArray]:
        """Static (..., n-2, 3) N and dynamic (..., n-2) N force by the small-angle formula.

        Weight, where it is asked for, is added as it is: it knows no small angles.
        """
        cycle = small_angle(self.layout, self.line, torque=self.demand.torque)
        weight = loads(self.layout, self.turn, self.line, torque=0.0, gravity=self.gravity)
        return cycle.static + weight.bearing_forces.static, cycle.dynamic

    @cached_property
    def critical_speeds(self) -> FloatArray:
        """Critical speed of each shaft by itself, (..., n-1) rad/s; nan without a tube."""
        tubes = [s.tube for s in self.line.shafts]
        lengths = np.moveaxis(self.layout.lengths, -1, 0)
        of = [
            whirl.critical_speed(
                length,
                outer=tube.outer,
                inner=tube.inner,
                youngs_modulus=tube.material.youngs_modulus,
                density=tube.material.density,
            )
            if tube
            else np.full_like(length, np.nan)
            for tube, length in zip(tubes, lengths, strict=True)
        ]
        return stacked(of)

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

        From the engine where it is known, times the application's shock factor.
        """
        demand = self.demand
        asked = np.where(np.isnan(demand.engine_torque), demand.torque, demand.engine_torque)
        uneven = np.abs(self.turn.phasors[..., :-1])
        uneven = np.concatenate([np.zeros_like(uneven[..., :1]), uneven], axis=-1)
        largest = self.application.shock_factor * np.abs(asked)
        return largest[..., None] * (1 + uneven) / (1 - uneven)

    @property
    def joint_torque_utilisation(self) -> FloatArray:
        """Largest torque at each joint over its elastic limit, (..., n); nan where not known."""
        return self.sizing_torque / self._rating("peak_torque")

    @cached_property
    def joint_fatigue_utilisation(self) -> FloatArray:
        """Share of each joint's fatigue rating, from coast to drive torque, (..., n).

        Every state's torques taken as a swing that comes back for ever; nan where the
        catalogue has no reversing torque.
        """
        reversing, pulsating = self._rating("reversing_torque"), self._rating("pulsating_torque")
        return strength.joint_fatigue_utilisation(
            np.maximum(self.demand.torque, 0.0)[..., None],  # where it coasts: from 0
            lowest=-np.nan_to_num(self.demand.coast_torque)[..., None],
            reversing=reversing,
            pulsating=np.where(np.isnan(pulsating), reversing, pulsating),
        )

    def _rating(self, name: str) -> FloatArray:
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
        """Shear stress of each tube over yield in shear, (..., n-1); nan where not known."""
        torque = np.abs(self.demand.torque)
        shock = self.application.shock_factor
        used = [
            strength.tube_utilisation(
                torque,
                outer=tube.outer,
                inner=tube.inner,
                yield_strength=tube.material.yield_strength,
                shock_factor=shock,
            )
            if tube and tube.material.yield_strength is not None
            else np.full_like(torque, np.nan)
            for tube in (s.tube for s in self.line.shafts)
        ]
        return stacked(used)

    @cached_property
    def life(self) -> FloatArray:
        """Life of each joint's needle bearings, (..., n) s; nan where not known.

        Over the duty cycle where there is one, at the joint angles of each state unless
        the cycle gives its own; otherwise at a torque and speed that the application
        itself states. Worst-case torque and top speed of a vehicle never meet, so they
        make no life; neither does a moment on a stop or in wind-up.
        """
        application = self.application
        ratings = (life.life_rating(size) if size else None for size in self.sizes)
        rated = stacked(np.nan if r is None else r for r in ratings)[..., None]
        duty = application.duty
        if not duty:
            given = application.engine is None
            torque = np.where(given, self.demand.torque, np.nan)[..., None, None]
            speed, angle = self.demand.speed[..., None, None], self.angles[..., None]
            shares = np.ones(1)
        else:
            torque, speed, shares = (
                stacked(getattr(p, v) for p in duty)[..., None, :]
                for v in ("torque", "speed", "share")
            )
            fixed = stacked(np.nan if p.angle is None else p.angle for p in duty)[..., None, :]
            angle = np.where(np.isnan(fixed), self.angles[..., None], fixed)
        wear = life.wear(
            torque,
            speed=speed,
            angle=angle,
            rated_torque=rated,
            prime_mover_factor=application.prime_mover_factor,
        )
        lasts = [[s.kind not in PASSING] for s in application.states]
        return np.where(lasts, life.joint_life(wear, shares=shares), np.nan)

    @cached_property
    def spline_travel_margin(self) -> FloatArray:
        """Travel left in the spline, (...) m; nan where its stroke is not given."""
        spline = self.line.shafts[-1].spline
        plunge, draw = (spline.plunge, spline.draw) if spline else (None, None)
        travel = self.spline_travel
        left = np.full_like(travel, np.inf)
        left = left if plunge is None else np.minimum(left, plunge + travel)
        left = left if draw is None else np.minimum(left, draw - travel)
        return np.where(np.isinf(left), np.nan, left)


_MODES: WeakKeyDictionary[Demand, whirl.Modes | None] = WeakKeyDictionary()
"""Critical modes of each line asked about: once for all layouts that keep its shafts."""


def _line_modes(line: Line, lengths: FloatArray) -> whirl.Modes | None:
    """Return a line's critical modes; None without tubes."""
    if any(s.tube is None for s in line.shafts):
        return None
    return whirl.critical_modes(beams.line_beams(line, lengths=lengths))


def respond(
    application: Application,
    demand: Demand,
    *,
    layout: Layout | None = None,
    phases: ArrayLike | None = None,
) -> Response:
    """Return the response of a line, as installed or with another layout and yoke phases.

    `layout` (..., S) and `phases` (..., n-1) may bring variants on axes before the states;
    give the phases of V variants as (V, 1, n-1).
    """
    line = demand.installed.line
    return Response(
        application=application,
        demand=demand,
        layout=demand.layout if layout is None else layout,
        phases=stacked(line.phases) if phases is None else np.asarray(phases, dtype=float),
    )
