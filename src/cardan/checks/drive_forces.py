"""Forces on the centre bearings along a drive in time."""

from dataclasses import replace
from typing import Any

import numpy as np

from cardan.checks.candidate_points import axle_positions, demand_at_nodes
from cardan.checks.line_on_mounts import LineOnMounts
from cardan.core.arrays import FloatArray
from cardan.core.lazy_dataclass import dataclass
from cardan.model.layout import Layout
from cardan.physics.loads.screening import (
    bearing_force_screening_model,
)
from cardan.physics.vehicle.state_demand import (
    axle_housing_torque,
    axle_motion_under_torque,
    demand_with_axle_moved_by_torque,
)


@dataclass(frozen=True, kw_only=True, eq=False)
class TorqueSpeedTimeHistory:
    """A drive of the line in time: P instants of even steps.

    Attributes
    ----------
    time, input_angle : (P,) s, rad
        And how far the gearbox's yoke has turned.
    torque, speed : (P,) N m, rad/s
        Signed, as how far it has turned.
    """

    time: FloatArray
    input_angle: FloatArray
    torque: FloatArray
    speed: FloatArray


def bearing_forces_over_time_history(
    mounts: LineOnMounts, of: TorqueSpeedTimeHistory, *, state: int
) -> tuple[FloatArray, FloatArray] | None:
    """Return what the bearings carry along a drive in a state, (P, n-2) N twice.

    Steadily at each instant's torque and speed, and as the line passes through; the axle where
    the torque of the instant has it. Rigid bearings carry the same either way. None if it is
    unknown how the line moves on its rubber.
    """
    inputs = mounts.inputs
    if mounts.is_rigid:
        steady = _rigid_bearing_forces(mounts, of)[:, state]
        return steady, steady
    if mounts.mounted_line is None:
        return None
    on = mounts.mounted_line.select_case(state).modal_reduction(inputs.line.rigid_body_mode_count)
    every = np.repeat(of.torque[:, None], len(inputs.demand.states), axis=1)
    on_axle = np.nan_to_num(axle_housing_torque(inputs.demand, every))
    ridden = axle_motion_under_torque(inputs.demand, every)
    rides = axle_positions(on_axle, ridden, inputs.demand.axle_motion)
    laid, count = inputs.layout_for(demand_at_nodes(inputs.demand, rides)), len(rides.nodes)
    where = Layout(
        points=np.broadcast_to(laid.points, (count, *laid.points.shape[-3:]))[:, state],
        directions=np.broadcast_to(laid.directions, (count, *laid.directions.shape[-3:]))[:, state],
    )
    drawn = bearing_force_screening_model(
        on, where, inputs.line, inputs.phases,
        rides=replace(
            rides,
            **{
                name: getattr(rides, name)[state]
                for name in ("least", "largest", "lowest", "highest", "away")
            },
        ),
        most=np.abs(of.torque).max(), gravity=inputs.gravity,
        thrust=mounts.stroke_thrust and mounts.stroke_thrust.screened(state),
    )  # fmt: skip
    asked: dict[str, Any] = {
        "torque": of.torque,
        "speed": of.speed,
        "on_axle": on_axle[:, state],
        "travel": np.broadcast_to(np.asarray(ridden.shift)[..., 2], on_axle.shape)[:, state],
        "slip": np.nan_to_num(inputs.spline_force_at(every)[:, state]),
    }
    return drawn.bearing_forces_at(**asked)[0].peak, drawn.transient_bearing_forces(
        of.time, of.input_angle, **asked
    )


def _rigid_bearing_forces(mounts: LineOnMounts, of: TorqueSpeedTimeHistory) -> FloatArray:
    """Return the peak force of rigid bearings at each instant, in each state, (P, S, n-2) N."""
    torque, speed = (
        np.repeat(v[:, None], len(mounts.inputs.demand.states), axis=1)
        for v in (of.torque, of.speed)
    )
    under = demand_with_axle_moved_by_torque(
        mounts.inputs.demand,
        torque=torque,
        speed=np.abs(speed),
        sense=np.where(speed < 0, -1.0, 1.0),
        coasts=torque * speed < 0,
    )
    return mounts.bearing_forces_at(under, mounts.inputs.layout_for(under)).peak
