"""Upper estimate of what centre bearings carry while the spline is stuck, of any number of designs.

A linear line of fixed length, where its modes meet order 2. Where the estimate does not exceed
what limits are held against anyway, the spline that slides decides; elsewhere the line is solved
(`checks.stuck_spline`), or its force is a lower bound.
"""

import numpy as np

from cardan.checks.line_on_mounts import LineOnMounts
from cardan.checks.operating_envelope import PointRows, curves_by_direction, strongest_curves
from cardan.core.arrays import FloatArray
from cardan.physics.loads.centre_bearing import loads_of_turning_line
from cardan.physics.loads.half_turn_fourier import semi_major_axis
from cardan.physics.loads.mean_line_loads import mean_line_loads
from cardan.physics.loads.rubber_mount import MountedLine
from cardan.physics.loads.spline_thrust import LARGEST_SHARE_OF_CRITICAL, compressed_line
from cardan.physics.loads.stuck_spline_estimate import held_line_frequencies, held_line_wave
from cardan.physics.vehicle.operating_points import demand_at_operating_points

BATCH_SAFETY_FACTOR = 2.0
"""Times the estimate: what a force that exceeds all sliding ones of its line is not above.

Of 200 random lines the largest such force was 1.53 times the estimate.
"""

SPEED_REACH = (0.6, 1.3)
"""Times the speeds at which order 2 meets the slowest mode and the fastest one: their range."""

CAUGHT_SHARES = (-0.75, 0.75)
"""Of the compressions that the stroke reaches, at which the spline is caught."""

ANCHOR_COUNT = 3
"""Speeds each way at which a line's loads are evaluated; each serves those nearest to it."""

SLIP_REACH = 1.5
"""Times the slip force: the largest thrust of order 2 of a motion that may count."""


def speed_range(mounts: LineOnMounts, held: MountedLine) -> tuple[FloatArray, FloatArray]:
    """Return the lowest and highest speed at which order 2 may meet a mode, (..., S) rad/s.

    A rigid bearing's modes are far above what a line turns at.
    """
    curves = mounts.torque_curves
    modes = held.natural_frequencies() / 2
    modes = np.broadcast_to(modes, (*curves.max_speed.shape[1:], modes.shape[-1]))
    fastest = np.nan_to_num(curves.max_speed).max(axis=0)
    high = np.minimum(SPEED_REACH[1] * modes.max(-1), np.maximum(fastest, 1e-3))
    return np.clip(SPEED_REACH[0] * modes.min(-1), high / 10, high), high


def rows_at_speeds(mounts: LineOnMounts, speeds: FloatArray) -> PointRows:
    """Return points (ways x Q, ..., S) at speeds (Q, ..., S), with most torque each way."""
    ways = curves_by_direction(mounts.torque_curves)
    curve = np.concatenate([strongest_curves(mounts.torque_curves, of, speeds)[0] for of in ways])
    return curve, np.concatenate([speeds] * len(ways))


def stuck_force_estimate(mounts: LineOnMounts) -> dict[str, FloatArray]:
    """Return estimates of forces with the spline stuck, (..., S, n-2) N by kind.

    Without unbalance. 0 where friction holds nothing; nothing of a line without such points.
    """
    inputs, held, thrust = mounts.inputs, mounts.reduced_mounted_line, mounts.stroke_thrust
    if held is None or thrust is None or not mounts.torque_curves.gears:
        return {}
    low, high = speed_range(mounts, held)
    step = (high / low) ** (1 / ANCHOR_COUNT)
    anchors = low * step ** (np.arange(ANCHOR_COUNT).reshape(-1, *(1,) * low.ndim) + 0.5)
    curve, speed = rows_at_speeds(mounts, anchors)
    asked = demand_at_operating_points(
        inputs.demand, mounts.torque_curves, curve=curve, speed=speed
    )
    slip = np.nan_to_num(inputs.spline_force_at(asked.torque))
    laid, how = inputs.layout_for(asked), mounts.force_inputs(asked, inertia=True)
    torque, own = how["torque"], how["speed"]
    loads = mean_line_loads(
        held, laid, inputs.line, inputs.phases, torque=torque, gravity=inputs.gravity
    )
    at_rest = compressed_line(held, forces=loads.push, spline=loads.spline_gradient, torque=torque)
    ahead = (torque >= 0)[None]
    pushed, drawn = np.where(ahead, *thrust.own_compression[:, :, None])
    share = np.array(CAUGHT_SHARES).reshape(-1, *(1,) * pushed.ndim)
    most = np.minimum(slip, LARGEST_SHARE_OF_CRITICAL * np.maximum(at_rest.critical, 0.0))
    caught = np.clip(np.where(share >= 0, share * pushed, -share * drawn), -slip, most)
    rest = at_rest.coordinates(caught)
    slope = loads.spline_gradient + (held.geometric @ rest[..., None])[..., 0]
    stiffness = held.stiffness_under_torque(torque) - caught[..., None, None] * held.geometric
    crests = held_line_frequencies(stiffness, held.mass, slope) / 2
    crests = np.clip(
        np.moveaxis(crests, -1, 0), np.abs(own) / np.sqrt(step), np.abs(own) * np.sqrt(step)
    )
    crests = np.sign(own) * crests
    turned, carried = loads_of_turning_line(
        laid, inputs.line, inputs.phases, torque=torque, speed=own, inertias=how["inertias"]
    )
    coupling = torque[..., None, None] * held.order2_coupling(turned)
    push = held.forces_from_joint_moments(carried.joint_moments.order(2))
    fixed = carried.bearing_forces.order(2) - held.static_bearing_forces(push)
    wave = held_line_wave(
        held,
        push + (coupling @ rest[..., None])[..., 0],
        slope,
        order=2,
        speed=crests,
        torque=torque,
        compression=caught,
    )
    thrust_of_2 = wave.compression
    force = fixed + held.motion(wave.coordinates, np.sign(own)).bearing_forces
    size = semi_major_axis(force + thrust_of_2[..., None, None] * loads.by_compression)
    held_by_friction = SLIP_REACH * slip / np.maximum(np.abs(thrust_of_2), 1e-9)
    size = size * np.minimum(held_by_friction, 1.0)[..., None]
    dynamic = size.max(0) + semi_major_axis(carried.bearing_forces.order(4))
    mean = loads.fixed_bearing_forces + held.motion(rest).bearing_forces.real
    static = np.linalg.norm(mean + caught[..., None, None] * loads.by_compression, axis=-1)
    there = (np.isfinite(asked.torque) & (slip > 0) & at_rest.is_stable)[..., None]

    def largest(values: FloatArray) -> FloatArray:
        return np.where(there, np.nan_to_num(values), 0.0).max(axis=(0, 1))

    return {"dynamic": largest(dynamic), "peak": largest(static + dynamic)}
