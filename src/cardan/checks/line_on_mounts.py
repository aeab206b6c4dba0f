"""A line on the rubber of its centre bearings: how it moves, and what its bearings carry."""

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from cardan.checks.line_inputs import LineInputs
from cardan.checks.operating_envelope import curves_for_cases
from cardan.checks.operating_point_results import OperatingPointResults, map_results
from cardan.checks.stroke_thrust import StrokeThrust, stroke_thrust
from cardan.core.arrays import ArrayLike, FloatArray, IntArray
from cardan.core.lazy_dataclass import dataclass
from cardan.model.bracket_compliance import bracket_compliance_from_stiffness
from cardan.model.layout import Layout
from cardan.physics.loads.centre_bearing import (
    BearingForces,
    ThrustEffect,
    bearing_forces,
)
from cardan.physics.loads.mounted_line_model import mounted_line
from cardan.physics.loads.rubber_mount import DEFAULT_LOSS_FACTOR, MountedLine
from cardan.physics.vehicle.operating_points import (
    TorqueCurves,
    demand_at_operating_points,
    torque_curves,
)
from cardan.physics.vehicle.state_demand import (
    LineStateDemand,
)

RIGID_STIFFNESS_N_PER_M = 1e14
"""N/m, of a bearing without rubber in a bracket that gives: a millionth of what brackets give,
and rounding is as small."""


@dataclass(frozen=True, kw_only=True)
class LineOnMounts:
    """How a line moves on the rubber of its centre bearings, and what these carry."""

    inputs: LineInputs

    @property
    def is_rigid(self) -> bool:
        """Whether none of its centre bearings gives: no rubber, and no bracket that bends.

        Statics gives what such bearings carry, at any speed.
        """
        return not self.inputs.bracket_compliances and all(
            b.stiffness is None and not b.bracket_stiffness
            for b in self.inputs.line.centre_bearings
        )

    @cached_property
    def mounted_line(self) -> MountedLine | None:
        """How the line can move on its rubber, in each state; None where it has none."""
        return mounted_line_of(self.inputs)

    @cached_property
    def reduced_mounted_line(self) -> MountedLine | None:
        """The same on its slowest modes alone, on which what is worst is sought."""
        return (
            None
            if self.mounted_line is None
            else self.mounted_line.modal_reduction(self.inputs.line.rigid_body_mode_count)
        )

    @cached_property
    def demand_torque_curves(self) -> TorqueCurves:
        """What torque it can have over its speed, in each case that its demand knows of."""
        return torque_curves(self.inputs.demand)

    @cached_property
    def torque_curves(self) -> TorqueCurves:
        """The same in each case of whatever varies."""
        found = self.demand_torque_curves
        if not found.gears:
            return found
        return curves_for_cases(found, _cases(self.inputs, found, self.mounted_line))

    @cached_property
    def stroke_thrust(self) -> StrokeThrust | None:
        """What thrust its spline reaches over the suspension's stroke; None if unknown."""
        whole = self.inputs.in_stroke_states
        if whole is None:
            return stroke_thrust(self.inputs, self.reduced_mounted_line, self.torque_curves)
        found = LineOnMounts(inputs=whole).stroke_thrust
        return found and found.in_states(
            [whole.demand.states.index(name) for name in self.inputs.demand.states]
        )

    def thrust_effect(self, of: LineStateDemand) -> ThrustEffect | None:
        """Return what thrust does under a demand to a line on its rubber; None if unknown."""
        found = self.stroke_thrust
        return found and found.effect(of.torque, self.inputs.spline_force_at(of.torque))

    def bearing_forces_at(
        self,
        of: LineStateDemand,
        layout: Layout,
        *,
        inertia: bool = True,
        on: MountedLine | None = None,
        gives: bool = False,
    ) -> BearingForces:
        """Return what the bearings carry under a demand, where the line then runs.

        On its own rubber, or on that of `on`; or how far that gives across the shafts, in m.
        """
        asked = self.force_inputs(of, inertia=inertia)
        found = bearing_forces(
            layout,
            self.inputs.line,
            self.inputs.phases,
            held=on or self.mounted_line,
            slip=self.inputs.spline_force_at(of.torque),
            thrust=self.thrust_effect(of),
            gives=gives,
            **asked,
        )
        return nan_where_no_point(found, of)

    def force_inputs(self, of: LineStateDemand, *, inertia: bool) -> dict[str, Any]:
        """Return what a line's forces as it runs depend on, besides where it lies."""
        return {
            "torque": np.nan_to_num(of.torque),
            "speed": np.nan_to_num(of.signed_speed),
            "inertias": self.inputs.shaft_inertias if inertia else None,
            "gravity": self.inputs.gravity,
            "balanced_at": self.inputs.balancing_speed
            if self.inputs.application.include_unbalance
            else None,
        }

    def bearing_forces_at_points(
        self,
        curve: IntArray,
        speed: FloatArray,
        *,
        quick: MountedLine | None = None,
        gives: bool = False,
    ) -> OperatingPointResults:
        """Return what the bearings carry at points, their curves and speeds (P, ..., S).

        Or nearly that, as they move on `quick` and without the shafts' inertia; or how far their
        rubber `gives`.
        """
        found = self.torque_curves
        asked = demand_at_operating_points(self.inputs.demand, found, curve=curve, speed=speed)
        return OperatingPointResults(
            curves=found,
            curve_index=np.broadcast_to(curve, asked.speed.shape),
            speed=asked.speed,
            torque=asked.torque,
            results=self.bearing_forces_at(
                asked, self.inputs.layout_for(asked), inertia=quick is None, on=quick, gives=gives
            ),
        )

    def forces_over_speed(
        self, speed: FloatArray, *, curves: Sequence[int] | None = None
    ) -> OperatingPointResults:
        """Return what a line's bearings carry along its curves at speeds (Q,) rad/s.

        On its slowest modes, as they are drawn: points (C, Q, S), of all curves or of some.
        """
        found, quick = self.torque_curves, self.reduced_mounted_line
        of = np.arange(len(found.gears)) if curves is None else np.asarray(curves)
        shape = (len(of), len(speed), *found.max_speed.shape[1:])
        curve = np.broadcast_to(of[:, None, None], shape).reshape(-1, *shape[2:])
        every = np.broadcast_to(speed[:, None], shape).reshape(curve.shape)
        flat = self.bearing_forces_at_points(curve, every, quick=quick)

        def gear_by_gear(values: Any) -> Any:
            return values.reshape(*shape[:2], *values.shape[1:])

        return map_results(gear_by_gear, flat)


def mounted_line_of(
    inputs: LineInputs, *, assumed: ArrayLike = DEFAULT_LOSS_FACTOR, cut: bool = False
) -> MountedLine | None:
    """Return how a line can move on its rubber in each state; None where it cannot.

    It needs a length and a tube of each shaft for its mass, and a stiffness of one bearing. A
    loss factor that is not given is `assumed` (...). Its joints may be `cut` for what they carry.
    """
    bearings = [s.centre_bearing for s in inputs.line.shafts if s.centre_bearing]
    told = {
        k: bracket_compliance_from_stiffness(b.bracket_stiffness, loss=b.bracket_loss)
        for k, b in enumerate(bearings)
        if b.bracket_stiffness
    }
    seats = {**told, **inputs.bracket_compliances}
    unknown = not seats and all(b.stiffness is None for b in bearings)
    if any(s.tube is None for s in inputs.line.shafts) or unknown or not inputs.line.has_lengths:
        return None
    stiffness = [
        [
            *(
                b.stiffness
                or (
                    (RIGID_STIFFNESS_N_PER_M, RIGID_STIFFNESS_N_PER_M)
                    if k in seats
                    else (np.inf, np.inf)
                )
            ),
            0.0 if b.axial_stiffness is None else b.axial_stiffness,
        ]
        for k, b in enumerate(bearings)
    ]
    loss = [assumed if b.loss_factor is None else b.loss_factor for b in bearings]
    columns = np.broadcast_arrays(*(np.asarray(v, dtype=float) for row in stiffness for v in row))
    k = np.stack(columns, axis=-1).reshape(*columns[0].shape, len(bearings), 3)
    eta = np.stack(np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in loss)), axis=-1)
    found = mounted_line(inputs.layout, inputs.line, stiffness=k, loss=eta, cut=cut)
    for bearing, seat in seats.items():
        found = found.with_bracket(bearing, seat)
    return found


def nan_where_no_point(found: BearingForces, of: LineStateDemand) -> BearingForces:
    """Return forces with nan where a demand is no point."""
    nothing = np.where(np.isfinite(of.torque), 0.0, np.nan)[..., None]
    return BearingForces(
        mean=found.mean + nothing[..., None],
        thrust=found.thrust + nothing,
        order1=found.order1 + nothing,
        waves=found.waves + nothing[..., None, None],
    )


def _cases(inputs: LineInputs, found: TorqueCurves, held: MountedLine | None) -> tuple[int, ...]:
    """Return the cases (..., S) that a line on its bearings has: of whatever varies."""
    of_parts: list[Any] = [n for s in inputs.line.shafts for n in (s.mass, s.balance_grade)]
    of_parts += [s.centre_bearing.from_rear_joint for s in inputs.line.shafts if s.centre_bearing]
    for o in inputs.obstacles:
        of_parts += [*o.start, *o.end, o.radius, o.travel_share, inputs.demand.travel]
    of_parts += [
        *inputs.line.torsional_flexibilities,
        *(inputs.line.joint_bending_stiffnesses or ()),
    ]
    shapes = [
        found.max_speed.shape[1:],
        inputs.layout.directions.shape[:-2],
        inputs.phases.shape[:-1],
        inputs.demand.torque.shape,
        inputs.spline_force.shape,
        *(np.shape(n) or (1,) for n in of_parts if n is not None),
    ]
    if inputs.shaft_inertias is not None:
        shapes.append(inputs.shaft_inertias.shape[:-1])
    if held is not None:
        shapes.append(held.case_last_matrices.cases)
    return np.broadcast_shapes(*shapes)
