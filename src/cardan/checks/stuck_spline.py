"""What centre bearings carry while friction holds the spline: order 2 on a line of fixed length.

Other forces are those of a line whose spline slides. A spline that sticks takes one mode from the
line and moves the others, so order 2 may be larger, at another speed. It is caught at compressions
that the stroke reaches. A motion counts only where its thrust stays below the slip force all round
the turn: friction that holds for a part of it leaves a line between both.
"""

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from cardan.checks.line_on_mounts import LineOnMounts
from cardan.checks.stuck_spline_estimate import rows_at_speeds, speed_range
from cardan.core.arrays import BoolArray, FloatArray
from cardan.core.lazy_dataclass import dataclass
from cardan.physics.loads.centre_bearing import bearing_forces, loads_of_turning_line
from cardan.physics.loads.half_turn_fourier import semi_major_axis
from cardan.physics.loads.mean_line_loads import mean_line_loads
from cardan.physics.loads.rubber_mount import MountedLine
from cardan.physics.loads.spline_thrust import CompressedLine, compressed_line
from cardan.physics.loads.stuck_spline import (
    COMPONENT_COUNT,
    HARMONIC_COUNT,
    StuckLine,
    StuckMotion,
    followed_stuck_motion,
    stiffness_of_orders,
)
from cardan.physics.loads.stuck_spline_estimate import held_line_wave
from cardan.physics.vehicle.operating_points import (
    LineOperatingPoints,
    demand_at_operating_points,
)

STUCK_FORCE_KINDS = ("dynamic", "peak")

CAUGHT_SHARES = (-0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75)
"""Of the compressions that the stroke reaches, at which the spline is caught."""

LEAST_CAUGHT_SHARE = 0.02
"""Of the slip force: a spline caught at less is as one caught without compression."""

LINEAR_SAFETY_FACTOR = 2.0
"""Times the force of a linear line of fixed length that motions must have to be solved."""

SPEEDS_BESIDE = 6
"""Speeds next to those at which a motion may count, at which it is solved as well."""

SPEED_COUNT = 48
"""Speeds at which a line is evaluated: the crest of a mode with loss 0.1 is met to 3 %."""

LEAST_TORQUE_SHARE = 0.25
"""Of the largest torque either way: with less, order 2 is not evaluated."""


@dataclass(frozen=True, kw_only=True, eq=False)
class StuckForces:
    """Largest forces on bearings while the spline is held, (S, n-2).

    Attributes
    ----------
    forces : (S, n-2) N, by `STUCK_FORCE_KINDS`
        nan where friction never holds the spline.
    points
        Where they are largest.
    travel_share : (S, n-2) 1, by `STUCK_FORCE_KINDS`
        Largest way across the shaft there over that to the stop, of the bearing with the most.
    peak_parts : (S, n-2) N, of "static" and "dynamic"
        What the peak force consists of, without unbalance.
    """

    forces: dict[str, FloatArray]
    points: dict[str, LineOperatingPoints]
    travel_share: dict[str, FloatArray]
    peak_parts: dict[str, FloatArray]


def stuck_forces(
    mounts: LineOnMounts, stop: FloatArray, *, sliding: Mapping[str, FloatArray]
) -> StuckForces | None:
    """Return what bearings carry while the spline is held; None of a line without such points.

    Of one design, on linear rubber. A spline is caught where the line's mean shape stays within
    the travel to the `stop` (n-2,) m. Motions are solved where a linear line of fixed length may
    exceed the forces of the `sliding` spline, (S, n-2) N by kind; nan in states without one.
    """
    inputs, held, thrust = mounts.inputs, mounts.reduced_mounted_line, mounts.stroke_thrust
    if held is None or thrust is None or not mounts.torque_curves.gears:
        return None
    low, high = speed_range(mounts, held)
    speeds = low * (high / low) ** np.linspace(0, 1, SPEED_COUNT)[:, None]
    curve, speed = rows_at_speeds(mounts, speeds)
    asked = demand_at_operating_points(
        inputs.demand, mounts.torque_curves, curve=curve, speed=speed
    )
    slip = np.nan_to_num(inputs.spline_force_at(asked.torque))
    line = _LineAtPoints.of(mounts, held, asked)
    ahead = (line.torque >= 0)[None]
    pushed, drawn = np.where(ahead, *thrust.own_compression[:, :, None])
    share = np.array(CAUGHT_SHARES)[:, None, None]
    caught = np.clip(np.where(share >= 0, share * pushed, -share * drawn), -slip, slip)
    rest = line.at_rest.coordinates(caught)
    size = np.abs(line.torque)
    counts = (size >= LEAST_TORQUE_SHARE * size.max(axis=0)) & (slip > 0)
    counts = counts & np.isfinite(asked.torque) & (np.abs(caught) < slip)
    counts &= line.at_rest.is_stable & (caught < line.at_rest.critical)
    counts &= (share == 0) | (np.abs(caught) > LEAST_CAUGHT_SHARE * slip)
    counts &= (np.linalg.norm(line.travel(rest), axis=-1) <= stop).all(-1)
    if not counts.any():
        return None
    linear = line.forces(line.linear_motion(caught, rest))
    may_count = np.any(
        [LINEAR_SAFETY_FACTOR * linear[k] > sliding[k] for k in STUCK_FORCE_KINDS], axis=(0, -1)
    )
    motion = line.stuck_motion(caught, rest, counts & may_count)
    holds = counts & motion.is_found & (motion.largest_thrust <= slip)
    if not holds.any():
        return None
    sizes = line.forces(motion)
    far = np.linalg.norm(line.travel(motion.coordinates[..., 0, :]), axis=-1)
    for q in _waves(motion.coordinates):
        far = far + semi_major_axis(line.travel(q))
    over = np.broadcast_to((far / stop).max(-1, keepdims=True), far.shape)

    def at(values: FloatArray, here: Any) -> FloatArray:
        return np.take_along_axis(values.reshape(-1, *values.shape[2:]), here[None], axis=0)[0]

    forces, points, shares = {}, {}, {}
    parts: dict[str, FloatArray] = {}
    for kind in STUCK_FORCE_KINDS:
        values = np.where(holds[..., None], sizes[kind], -np.inf)
        here = values.reshape(-1, *values.shape[2:]).argmax(axis=0)
        most = at(values, here)
        never = ~np.isfinite(most)
        forces[kind] = np.where(never, np.nan, most)
        shares[kind] = np.where(never, 0.0, at(over, here))
        row, state = here % len(speed), np.arange(speed.shape[-1])[:, None]
        points[kind] = LineOperatingPoints(
            curves=mounts.torque_curves,
            curve_index=np.broadcast_to(curve, speed.shape)[row, state],
            speed=asked.speed[row, state],
            torque=asked.torque[row, state],
            is_spline_stuck=~never,
        )
        if kind == "peak":
            parts = {k: at(sizes[k], here) for k in ("static", "dynamic")}
    return StuckForces(forces=forces, points=points, travel_share=shares, peak_parts=parts)


def _waves(values: Any) -> list[Any]:
    """Return orders 2, 4 and 6 of components (..., M, *) on the last axis but one."""
    return [
        values[..., 2 * k - 1, :] + 1j * values[..., 2 * k, :] for k in range(1, HARMONIC_COUNT + 1)
    ]


@dataclass(frozen=True, kw_only=True, eq=False)
class _LineAtPoints:
    """A line on its slowest modes at points (P, S) of one design, its spline held or not.

    Attributes
    ----------
    held
        How it can move.
    torque, speed : (P, S) N m, rad/s, signed
    push : (P, S, M, N) N
        Of the crosses' moments, components as `StuckLine` has them.
    linear : (P, S, M, N, M, N) N/m
    spline : (P, S, N) 1
        How much its coordinates lengthen the spline.
    at_rest
        The same line under its mean loads and a compression.
    mean : (P, S, n-2, 3) N, waves : (P, S, n-2, 3, 3) N, order1 : (P, S, n-2) N
        Force on its bearings while the spline slides without thrust.
    by_compression : (P, S, n-2, 3) 1
        What 1 N of compression adds where nothing moves.
    """

    held: MountedLine
    torque: FloatArray
    speed: FloatArray
    push: FloatArray
    linear: FloatArray
    spline: FloatArray
    at_rest: CompressedLine
    mean: FloatArray
    waves: Any
    order1: FloatArray
    by_compression: FloatArray

    @classmethod
    def of(cls, mounts: LineOnMounts, held: MountedLine, asked: Any) -> "_LineAtPoints":
        """Return a line under a demand at points."""
        inputs = mounts.inputs
        laid, how = inputs.layout_for(asked), mounts.force_inputs(asked, inertia=True)
        torque, speed = how["torque"], how["speed"]
        slides = bearing_forces(laid, inputs.line, inputs.phases, held=held, **how)
        loads = mean_line_loads(
            held, laid, inputs.line, inputs.phases, torque=torque, gravity=inputs.gravity
        )
        turned, carried = loads_of_turning_line(
            laid, inputs.line, inputs.phases,
            torque=torque, speed=speed, inertias=how["inertias"],
        )  # fmt: skip
        push = np.zeros((*speed.shape, COMPONENT_COUNT, held.mass.shape[-1]))
        for k in range(HARMONIC_COUNT + 1):
            wave = held.forces_from_joint_moments(carried.joint_moments.order(2 * k))
            push[..., max(2 * k - 1, 0), :] = wave.real
            if k:
                push[..., 2 * k, :] = wave.imag
        return cls(
            held=held,
            torque=torque,
            speed=speed,
            push=push,
            linear=stiffness_of_orders(
                held, held.order2_coupling(turned), speed=speed, torque=torque
            ),
            spline=np.broadcast_to(loads.spline_gradient, (*speed.shape, held.mass.shape[-1])),
            at_rest=compressed_line(
                held, forces=push[..., 0, :], spline=loads.spline_gradient, torque=torque
            ),
            mean=slides.mean,
            waves=slides.waves,
            order1=slides.order1,
            by_compression=loads.by_compression,
        )

    @cached_property
    def free(self) -> FloatArray:
        """How it moves while the spline slides, (P, S, M, N) m."""
        flat = COMPONENT_COUNT * self.push.shape[-1]
        found = np.linalg.solve(
            self.linear.reshape(*self.speed.shape, flat, flat),
            self.push.reshape(*self.speed.shape, flat, 1),
        )
        return found.reshape(self.push.shape).astype(float)

    def travel(self, coordinates: Any) -> Any:
        """Return how far coordinates (..., P, S, N) take the bearings across, (..., n-2, 2) m."""
        return (self.held.bearing[..., :2, :] @ coordinates[..., None, :, None])[..., 0]

    def linear_motion(self, caught: FloatArray, rest: FloatArray) -> StuckMotion:
        """Return motions (V, P, S, ...) by the length's slope at rest, other orders as sliding."""
        slope = self.spline + (self.held.geometric @ rest[..., None])[..., 0]
        tie = self.linear[..., 1, :, 0, :] + 1j * self.linear[..., 2, :, 0, :]
        (push, *_) = _waves(self.push)
        wave = held_line_wave(
            self.held,
            push - (tie @ rest[..., None])[..., 0],
            slope,
            order=2,
            speed=self.speed,
            torque=self.torque,
            compression=caught,
        )
        q = np.array(np.broadcast_to(self.free, (*caught.shape, *self.free.shape[-2:])))
        P = np.zeros(q.shape[:-1])
        q[..., 0, :], P[..., 0] = rest, caught
        q[..., 1, :], q[..., 2, :] = wave.coordinates.real, wave.coordinates.imag
        P[..., 1], P[..., 2] = wave.compression.real, wave.compression.imag
        return StuckMotion(
            coordinates=q,
            compression=P,
            largest_thrust=np.abs(wave.compression),
            is_found=np.ones(caught.shape, dtype=bool),
        )

    def stuck_motion(self, caught: FloatArray, rest: FloatArray, counts: BoolArray) -> StuckMotion:
        """Return motions (V, P, S, ...) of a spline caught at compressions (V, P, S) N.

        Cases (V, S) each way that the line is turned count at some speeds or at none.
        """
        V, P, S = caught.shape
        Q, N = SPEED_COUNT, self.push.shape[-1]

        def along(values: Any, own: int) -> Any:
            """Return values (V, P, S, *) by speed, then way, compression and state."""
            tail = values.shape[values.ndim - own :]
            wide = np.broadcast_to(values, (V, P, S, *tail)).reshape(V, -1, Q, S, *tail)
            return np.moveaxis(wide, 2, 0)

        own = along(counts, 0)
        needed = own.copy()
        for k in range(1, SPEEDS_BESIDE + 1):
            needed[k:] |= own[:-k]
            needed[:-k] |= own[k:]
        place = np.nonzero(needed.any(axis=0))

        def some(values: Any, own: int) -> Any:
            return np.ascontiguousarray(along(values, own)[:, *place])

        found = followed_stuck_motion(
            StuckLine(
                linear=some(self.linear, 4),
                push=some(self.push, 2),
                spline=some(self.spline, 1),
                geometric=np.broadcast_to(self.held.geometric, (S, N, N))[place[-1]],
                rest=some(rest, 1),
                compression=some(caught, 0),
            ),
            needed[:, *place],
        )

        def back(values: Any) -> Any:
            whole = np.zeros((Q, V, P // Q, S, *values.shape[2:]), dtype=values.dtype)
            whole[:, *place] = values
            return np.moveaxis(whole, 0, 2).reshape(V, P, S, *values.shape[2:])

        return StuckMotion(
            coordinates=back(found.coordinates),
            compression=back(found.compression),
            largest_thrust=back(found.largest_thrust),
            is_found=back(found.is_found),
        )

    def forces(self, motion: StuckMotion) -> dict[str, FloatArray]:
        """Return sizes of the forces on the bearings, (V, P, S, n-2) N, by kind."""
        held, free = self.held, self.free
        more, P = motion.coordinates - free, motion.compression[..., None, None]
        backwards = (self.speed < 0)[..., None, None]
        dynamic = np.zeros(())
        for k, (q, p) in enumerate(
            zip(_waves(more), _waves(motion.compression[..., None]), strict=True)
        ):
            added = held.motion(q, np.sign(self.speed)).bearing_forces
            added = added + p[..., None] * self.by_compression
            added = np.where(backwards, np.conj(added), added)
            dynamic = dynamic + semi_major_axis(self.waves[..., k, :] + added)
        mean = self.mean + held.motion(more[..., 0, :]).bearing_forces.real
        mean = mean + P[..., 0, :, :] * self.by_compression
        static = np.linalg.norm(mean, axis=-1)
        return {"static": static, "dynamic": dynamic, "peak": static + dynamic + self.order1}
