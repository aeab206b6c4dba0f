"""What the results of a line are computed from: where it runs, how it turns, its data.

One code path serves one design and a million: the states of an application stand on the
last leading axis, variants of a study on axes before it.
"""

from collections.abc import Callable, Mapping
from dataclasses import field, replace
from functools import cached_property
from typing import Any

import numpy as np

from cardan.core.arrays import ArrayLike, BoolArray, FloatArray, stack_on_last_axis
from cardan.core.lazy_dataclass import dataclass
from cardan.core.units import g
from cardan.model.application import (
    STATE_KINDS_AT_LOADED_RIDE_HEIGHT,
    Application,
    DutyPoint,
    Obstacle,
    duty_cycle_points,
)
from cardan.model.bracket_compliance import BracketCompliance
from cardan.model.layout import Layout
from cardan.model.parts import JointSize, Line
from cardan.physics.kinematics.joint_chain import (
    ChainRotation,
    joint_angles,
    rotate_chain,
)
from cardan.physics.loads.statics import (
    spline_slip_force,
)
from cardan.physics.vehicle.resolved_line import resolve_line_references
from cardan.physics.vehicle.state_demand import (
    LineStateDemand,
    line_state_demand,
)


def layout_of_demand(demand: LineStateDemand) -> Layout:
    """Return where the line of a demand runs."""
    return demand.layout


SAMPLES_PER_TURN = 16
"""Samples of a turn for the loads: under a constant torque they have orders 0 and 2 alone."""


@dataclass(frozen=True, kw_only=True)
class LineInputs:
    """One line in its states, and what follows from it at once, (variants ..., states).

    What the application gives no grounds for is nan, and no limit applies to it.
    """

    application: Application
    demand: LineStateDemand
    layout: Layout
    phases: FloatArray
    layout_for: Callable[[LineStateDemand], Layout] = field(
        default=layout_of_demand, repr=False, compare=False
    )
    """Where the line runs at other torques: with its bearings and axle moved like here."""
    bracket_compliances: Mapping[int, BracketCompliance] = field(
        default_factory=dict[int, BracketCompliance], repr=False, compare=False
    )
    """Brackets that give, by the bearing, from 0, that hangs in them; others are rigid."""
    twisted_by_torque: bool = False
    """Whether its turn is computed as torque twists its shafts (`line_response.deflected_line`)."""

    @property
    def line(self) -> Line:
        """The line this is about."""
        return self.demand.installed.line

    @property
    def joint_sizes(self) -> tuple[JointSize | None, ...]:
        """The catalogue's size of each joint, None where it is not given."""
        return self.line.joints or (None,) * self.line.joint_count

    @property
    def state_kinds(self) -> tuple[str, ...]:
        """What kind of state each is, as limits know it."""
        return tuple(s.limit_state_kind for s in self.application.states)

    @cached_property
    def in_stroke_states(self) -> "LineInputs | None":
        """The line in all states of its suspension's stroke; None where these are its own."""
        if not self.application.stroke_states:
            return None
        application = replace(
            self.application, states=self.application.stroke_states, stroke_states=()
        )
        demand = line_state_demand(resolve_line_references(application, self.demand.installed))
        layout = self.layout_for(demand)
        return replace(self, application=application, demand=demand, layout=layout)

    @property
    def sustained_states(self) -> BoolArray:
        """Which states are driven in for long, (states,): the axle rides under its load."""
        return np.array([kind in STATE_KINDS_AT_LOADED_RIDE_HEIGHT for kind in self.state_kinds])

    @property
    def duty_points(self) -> tuple[DutyPoint, ...]:
        """The duty cycle as the line turns in it; empty where the application has none.

        An application's cycle is that of the gearbox output, of which the line has its share.
        A named one is of the line's largest torque and top speed in the states that last.
        """
        line, named = self.demand.static_state.line, self.application.duty_cycle
        if named is not None:
            torque = np.abs(self.demand.torque)
            if np.any(
                line.max_torque_share != line.nominal_torque_share
            ):  # behind a locked differential, at times
                usual = (
                    line.nominal_torque_share / line.max_torque_share * self.demand.engine_torque
                )
                torque = np.fmin(torque, np.abs(usual))
            most, speed = map(self._largest, (torque, self.demand.speed))
            return duty_cycle_points(named, torque=most, speed=speed)
        ratio = self.demand.installed.speed_ratio
        return tuple(
            replace(p, torque=line.nominal_torque_share * p.torque, speed=ratio * p.speed)
            for p in self.application.duty
        )

    def _largest(self, values: FloatArray) -> Any:
        """Return the largest size of values (..., states) in states that last, (..., 1)."""
        lasting = np.where(self.sustained_states, np.abs(values), np.nan)
        if np.isnan(lasting).all():
            return np.nan
        most = np.nanmax(lasting, axis=-1, keepdims=values.ndim > 1)
        return most if values.ndim > 1 else float(most)

    @cached_property
    def chain_rotation(self) -> ChainRotation:
        """The exact turn of the chain; its shafts as they are welded, as limits use it."""
        return self.turned(self.demand.torque if self.twisted_by_torque else 0.0)

    @cached_property
    def twisted_chain_rotation(self) -> ChainRotation:
        """The same as torque twists its shafts, which is how it carries that."""
        return self.turned(self.demand.torque)

    def turned(self, torque: ArrayLike, *, samples: int = SAMPLES_PER_TURN) -> ChainRotation:
        """Return the exact turn of the chain as a torque (...) N m twists its shafts."""
        phases = self.line.phases_under_torque(self.phases, np.nan_to_num(torque))
        d = self.layout.directions
        return rotate_chain(d, phases=phases, crosses=self.line.is_cross, samples=samples)

    @cached_property
    def joint_angles(self) -> FloatArray:
        """True joint angles, (..., n) rad."""
        return joint_angles(self.layout.directions)

    @cached_property
    def shaft_inertias(self) -> FloatArray | None:
        """Polar inertias of the shafts, (..., n-1) kg m²; None where one is not known."""
        known = [
            j for s in self.line.shafts
            if (j := s.polar_inertia) is not None and not np.isnan(j).all()
        ]  # fmt: skip
        return stack_on_last_axis(known) if len(known) == len(self.line.shafts) else None

    @property
    def gravity(self) -> float:
        """Standard gravity where the application counts weight, else 0, m/s²."""
        return g if self.application.include_gravity else 0.0

    @property
    def obstacles(self) -> tuple[Obstacle, ...]:
        """The obstacles of this line."""
        return tuple(o for o in self.application.obstacles if o.line == self.line.name)

    @cached_property
    def follows_engine(self) -> BoolArray:
        """States whose speed is the application's or the engine's, not their own, (states,).

        A wind-up state turns at the speed of the lowest gear.
        """
        states = self.demand.static_state.line.states
        return np.array([s.speed is None and s.kind != "windup" for s in states])

    @cached_property
    def reached_speed(self) -> FloatArray:
        """Largest speed that the line reaches in each state, (..., S) rad/s.

        In a state without a speed of its own, the larger of the application's top speed and of the
        engine's largest speed over the smallest total ratio ahead of the line: what turns the
        shaft does not know what a file says.
        """
        gears = self.demand.static_state.line.gears
        top = np.nan if gears is None else gears.top_speed
        reached = np.where(self.follows_engine, top, np.nan)
        return np.fmax(self.demand.speed, reached)

    @property
    def balancing_speed(self) -> FloatArray:
        """Speed the shafts are balanced for: the line's highest, in a state or not, (..., 1) rad/s.

        Shafts that never turn are as good as balanced for any: inf.
        """
        line = self.demand.static_state.line
        given, top = (np.asarray(np.nan if v is None else v, dtype=float) for v in (
            line.speed, line.gears and line.gears.top_speed
        ))  # fmt: skip
        top = np.where(np.isnan(given), top, given * line.installed.speed_ratio)
        fastest = np.nan_to_num(self.demand.speed).max(axis=-1, keepdims=True)
        fastest = np.maximum(fastest, np.nan_to_num(top))
        return np.where(fastest > 0, fastest, np.inf)

    @cached_property
    def spline_force(self) -> FloatArray:
        """Axial force that slides the spline at the state's torque, (...) N; nan if not known."""
        return self.spline_force_at(self.demand.torque) + np.zeros(
            self.layout.directions.shape[:-2]
        )

    def spline_force_at(self, torque: FloatArray) -> FloatArray:
        """Return the axial force (...) N that slides the spline at torques (...) N m."""
        spline = self.line.shafts[-1].spline
        if spline is None or spline.mean_radius is None:
            return np.full(np.shape(torque), np.nan)
        return spline_slip_force(torque, friction=spline.friction, mean_radius=spline.mean_radius)

    def rating(self, name: str) -> FloatArray:
        """Return a rating of every joint, (..., n); nan where the catalogue has none."""
        values = [getattr(s, name) if s else None for s in self.joint_sizes]
        return stack_on_last_axis(np.nan if v is None else v for v in values)
