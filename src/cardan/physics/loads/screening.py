"""A line's bearings at many points, nearly: where a force is largest is sought on this.

Points of one state differ in torque and speed, and the torque moves the axle. What follows
from angles alone, how one newton metre pushes the coordinates, how that follows their motion and
what statics makes of it, is smooth in that: a parabola through three rides of the axle. What
is left to do at a point is the algebra of a few coordinates
(`cardan.physics.loads.frequency_response`).

Left out is the shafts' inertia, whose share is small where resonance is.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from math import prod
from typing import Any, TypeAlias

import numpy as np

from cardan.core.arrays import (
    ArrayLike,
    BoolArray,
    ComplexArray,
    FloatArray,
    broadcastable_axis_indices,
)
from cardan.core.batched_linalg import (
    CACHE_BLOCK_CASES,
    CaseBlockSlices,
    broadcast_cases,
    cache_blocks,
    case_table,
    matrix_axes_first,
    matrix_axes_last,
    matrix_product,
    move_valid_points_to_front,
    slice_case_block,
    solve,
)
from cardan.core.compiled import is_compiled_batch
from cardan.core.lazy_dataclass import dataclass
from cardan.model.layout import Layout
from cardan.model.parts import Line
from cardan.physics.kinematics.joint_chain import rotate_chain
from cardan.physics.loads.centre_bearing import unbalance_excitation
from cardan.physics.loads.compiled_response import (
    ResponseKernel,
    raise_if_singular,
    screening_kernel,
)
from cardan.physics.loads.half_turn_fourier import semi_major_axis
from cardan.physics.loads.rubber_mount import MountedLine
from cardan.physics.loads.statics import bearing_forces_of_weight_and_thrust, joint_loads

_ALONG = ((-1.0, 0.0), (0.0, 0.0), (1.0, 0.0))
_BESIDE = ((0.0, -1.0), (0.0, 1.0), (1.0, 1.0))

_Bent: TypeAlias = tuple[Any, ...]
"""Coefficients of 1, x, x², y, y² and xy of what follows a ride (x, y): the first three if an axle
goes straight, the first alone if nothing moves it. Components first, the cases (..., S) last."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ForceMagnitudes:
    """Sizes of what `BearingForces` has of the centre bearings, (..., n-2): forces in N, or m."""

    static: FloatArray
    dynamic: FloatArray
    peak: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class ShaftReachIntoObstacles:
    """How far shafts reach into what they face, (..., R) m: below 0 there is room."""

    reach: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class AxleTravelByTorque:
    """Where an axle rides at some points: by the torque on it, and how high its springs have it.

    Attributes
    ----------
    least, largest : (..., S) N m
        Torques on the axle.
    lowest, highest : (..., S) m
        Its travel under these; between them it goes nearly straight.
    away : (..., S) m
        How far it goes off that at most.
    has_motion
        Whether it rides in more ways than one.
    """

    least: FloatArray
    largest: FloatArray
    lowest: FloatArray
    highest: FloatArray
    away: FloatArray
    has_motion: bool

    @property
    def nodes(self) -> tuple[tuple[float, float], ...]:
        """Rides (x, y), -1 to 1, at which the line's angles are evaluated."""
        if not self.has_motion:
            return _ALONG[1:2]
        return (*_ALONG, *_BESIDE) if self.away.any() else _ALONG

    def torque_and_travel(self, x: float, y: float) -> tuple[FloatArray, FloatArray]:
        """Return the torque on the axle and its travel of a ride, (..., S) N m, m."""
        torque, travel = (
            (a + b) / 2 + x * (b - a) / 2
            for a, b in ((self.least, self.largest), (self.lowest, self.highest))
        )
        return torque, travel + y * self.away

    def normalised_coordinates(
        self, on_axle: ArrayLike, travel: ArrayLike
    ) -> tuple[FloatArray, FloatArray]:
        """Return the rides (x, y) of torques on the axle and travels, (P, ..., S) N m, m."""
        half = (self.largest - self.least) / 2
        x = (np.asarray(on_axle) - (self.largest + self.least) / 2) / np.where(half > 0, half, 1.0)
        line = (self.lowest + self.highest) / 2 + x * (self.highest - self.lowest) / 2
        return x, (np.asarray(travel) - line) / np.where(self.away > 0, self.away, 1.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class ObstacleCandidates:
    """Where shafts may hit something: R places that face it.

    Attributes
    ----------
    clearance : (rides, ..., S, R) m
        Distance there at each of the nodes of `AxleTravelByTorque`.
    approach_matrix : (..., S, R, n-1, 2, 3)
        How much nearer it comes for each metre of the ends of the shafts.
    """

    clearance: FloatArray
    approach_matrix: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class ScreenedThrust:
    """What thrust in the sliding fit does to a line on its rubber; cases last.

    The first axis has the largest torque ahead and astern, the second the spline pushed in and
    drawn out. A smaller slip force does less in proportion.

    Attributes
    ----------
    force : (2, 2, B, ...) N
        What is added to the mean on the bearings, in their directions.
    compression : (2, 2, n-2, ...) N
    own_compression : (2, 2, ...) N
        Where the line lies.
    moved : (2, 2, N, ...) m
        What that moves of the coordinates.
    """

    force: FloatArray
    compression: FloatArray
    own_compression: FloatArray
    moved: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class BearingForceScreeningModel:
    """A line on its rubber at all rides of its axle; N coordinates, B = 3 (n-2) directions.

    Attributes
    ----------
    mounted_line
        How it can move.
    axle_positions
        Where the axle is.
    coordinate_forces : (N, ...) N
        What orders 0 and 2 of 1 N m do on the coordinates.
    order2_coupling : (N, N, ...)
        How order 2 of that follows the coordinates.
    direct_bearing_forces : (B, ...) N
        Orders 0 and 2 of 1 N m on the bearings, less what the coordinates take at rest.
    twist_gains
        What order 2 of the three, in this order, gains for each N m more: it twists the shafts.
    weight_forces : (B, ...) N
        On the bearings.
    thrust
        What thrust in the sliding fit does; None where unknown.
    bearing_matrix : (B, N, ...)
        Motion in the bearings' directions.
    bearing_stiffness, loss : (B, ...) N/m, 1
    rubber_compliance : (B, ...) m/N
        Of the rubber across the shafts; 0 along them.
    unbalance_excitation : (N, 2 (n-1), ...) N s²
        What unbalance of each end does on the coordinates at 1 rad/s; None leaves it out.
    clearance : (R, ...) m
        How far off is what shafts face.
    approach_matrix : (R, N, ...)
        How much nearer the coordinates bring it.
    """

    mounted_line: MountedLine
    axle_positions: AxleTravelByTorque
    coordinate_forces: tuple[_Bent, _Bent]
    order2_coupling: _Bent
    direct_bearing_forces: tuple[_Bent, _Bent]
    twist_gains: tuple[_Bent, _Bent, _Bent]
    weight_forces: _Bent
    thrust: ScreenedThrust | None
    bearing_matrix: FloatArray
    bearing_stiffness: FloatArray
    loss: FloatArray
    rubber_compliance: FloatArray
    unbalance_excitation: ComplexArray | None
    clearance: _Bent
    approach_matrix: FloatArray

    def bearing_forces_at(
        self,
        torque: ArrayLike,
        *,
        speed: ArrayLike,
        on_axle: ArrayLike,
        travel: ArrayLike,
        slip: ArrayLike,
        gives: bool = False,
    ) -> tuple[ForceMagnitudes, ShaftReachIntoObstacles]:
        """Return what the bearings carry at points (P, ..., S), and how far shafts reach.

        Parameters
        ----------
        torque, speed, on_axle, travel : (P, ..., S) N m, rad/s, N m, m
            Where a torque is nan there is no point, and no force.
        slip : (P, ..., S) N
            Thrust at which the sliding fit slips; nan where unknown, and none counts.
        gives
            Return how far rubber gives across the shafts, in m for N, weight apart.
        """
        given = torque, speed, on_axle, travel, slip
        (found,), reach = self._sizes_at(*given, kinds=(gives,))
        return found, reach

    def bearing_forces_and_travel_at(
        self,
        torque: ArrayLike,
        *,
        speed: ArrayLike,
        on_axle: ArrayLike,
        travel: ArrayLike,
        slip: ArrayLike,
    ) -> tuple[ForceMagnitudes, ForceMagnitudes, ShaftReachIntoObstacles]:
        """Return `bearing_forces_at` in N, then in m, and the reach: the line is solved once."""
        (forces, gone), reach = self._sizes_at(
            torque, speed, on_axle, travel, slip, kinds=(False, True)
        )
        return forces, gone, reach

    def _sizes_at(
        self,
        torque: ArrayLike,
        speed: ArrayLike,
        on_axle: ArrayLike,
        travel: ArrayLike,
        slip: ArrayLike,
        *,
        kinds: tuple[bool, ...],
    ) -> tuple[list[ForceMagnitudes], ShaftReachIntoObstacles]:
        """Return sizes at points by `kinds`, what rubber gives where True; and the reach."""
        there = ~np.isnan(torque)
        ride = self.axle_positions.normalised_coordinates(on_axle, travel)
        given = np.broadcast_arrays(*(np.nan_to_num(v) for v in (torque, speed, *ride, slip)))
        cases = given[0].shape
        bearings = len(self.bearing_matrix) // 3
        count = 3 * bearings * len(kinds) + len(self.approach_matrix)
        kernel = screening_kernel() if is_compiled_batch(cases[1:]) else None
        if kernel:
            there = np.broadcast_to(there, cases)
            sizes = self._point_by_point(kernel, there, given, count, kinds=kinds)
        elif len(cases) != 3 or prod(cases) <= 2 * CACHE_BLOCK_CASES:
            sizes = np.empty((count, *cases))
            for some in cache_blocks(cases):
                slice_case_block(sizes, some)[...] = self._some(
                    some, *(slice_case_block(v, some) for v in given), kinds=kinds
                )
        else:
            sizes = self._packed(np.broadcast_to(there, cases), given, count, kinds=kinds)
        sizes = np.moveaxis(sizes + np.where(there, 0.0, np.nan), 0, -1)
        *each, reach = np.split(sizes, np.arange(1, 3 * len(kinds) + 1) * bearings, axis=-1)
        found = [
            ForceMagnitudes(static=static, dynamic=dynamic, peak=peak)
            for static, dynamic, peak in zip(each[::3], each[1::3], each[2::3], strict=True)
        ]
        return found, ShaftReachIntoObstacles(reach=reach)

    def without_obstacles(self) -> "BearingForceScreeningModel":
        """Return the same line with nothing in its way: what is not read is not computed."""
        return replace(
            self,
            clearance=tuple(v[:0] for v in self.clearance),
            approach_matrix=self.approach_matrix[:0],
        )

    @property
    def order2_terms(self) -> Iterator[tuple[_Bent, _Bent]]:
        """Order 2 of pushes, swing and what is borne; each without torque, and what it gains."""
        return zip(
            (self.coordinate_forces[1], self.order2_coupling, self.direct_bearing_forces[1]),
            self.twist_gains,
            strict=True,
        )

    def _packed(
        self,
        there: BoolArray,
        given: Sequence[FloatArray],
        sizes: int,
        *,
        kinds: tuple[bool, ...],
    ) -> FloatArray:
        """Return so many sizes (X, P, V, S), state by state: one has many points, another few."""
        packs, counts, place = move_valid_points_to_front(there, *given)
        packs = [np.ascontiguousarray(np.moveaxis(v, -1, 0)) for v in packs]
        found = np.zeros((sizes, *packs[0].shape))
        for state, count in enumerate(counts.tolist()):
            step = max(1, CACHE_BLOCK_CASES // max(count, 1))
            for start in range(0, there.shape[1], step) if count else ():
                some = slice(start, start + step)
                each = (v[state, :count, some, None] for v in packs)
                found[:, state, :count, some] = self._some(
                    (some, slice(state, state + 1)), *each, kinds=kinds
                )[..., 0]
        _, variant, state = broadcastable_axis_indices(there.shape)
        return found[:, state, place, variant]

    def _point_by_point(
        self,
        kernel: ResponseKernel,
        there: BoolArray,
        given: Sequence[FloatArray],
        sizes: int,
        *,
        kinds: tuple[bool, ...],
    ) -> FloatArray:
        """Return so many sizes (X, P, ..., S) by the compiled loop over points."""
        cases = there.shape
        found = np.empty((sizes, cases[0], prod(cases[1:])))
        points = np.stack(given).reshape(len(given), *found.shape[1:])
        exist = np.ascontiguousarray(there.reshape(found.shape[1:]))
        raise_if_singular(
            kernel(*self._case_tables(cases[1:]), points, exist, np.array(kinds), found)
        )
        return found.reshape(sizes, *cases)

    def _case_tables(self, cases: tuple[int, ...]) -> tuple[Any, ...]:
        """Return what `screened_sizes` takes of each case, in one piece of memory."""
        if cases not in self._tables_of_cases:
            self._tables_of_cases[cases] = self._computed_case_tables(cases)
        return self._tables_of_cases[cases]

    @cached_property
    def _tables_of_cases(self) -> dict[tuple[int, ...], tuple[Any, ...]]:
        """Those that were made."""
        return {}

    def _computed_case_tables(self, cases: tuple[int, ...]) -> tuple[Any, ...]:
        def table(parts: Sequence[tuple[Any, int]], *own: int) -> Any:
            return case_table(parts, cases).reshape(prod(cases), *own)

        line = self.mounted_line.case_last_matrices
        N, (R, B) = len(line.mass), (len(v) for v in (self.approach_matrix, self.bearing_matrix))
        rides: list[Any] = []
        for k in range(len(self.coordinate_forces[0])):
            order2 = [
                (part, of)
                for (still, more), of in zip(self.order2_terms, (1, 2, 1), strict=True)
                for part in (still[k].real, still[k].imag, more[k].real, more[k].imag)
            ]
            rides += [
                (self.coordinate_forces[0][k], 1), *order2[:8],
                (self.direct_bearing_forces[0][k], 1), *order2[8:],
                (self.weight_forces[k], 1), (self.clearance[min(k, len(self.clearance) - 1)], 1),
            ]  # fmt: skip
        thrust, unbalance = self.thrust, self.unbalance_excitation
        lead = [] if thrust is None else [
            part
            for towards in (0, 1) for way in (0, 1)
            for part in (
                (thrust.force[towards, way], 1), (thrust.compression[towards, way], 1),
                (thrust.own_compression[towards, way], 0), (thrust.moved[towards, way], 1),
            )
        ]  # fmt: skip
        ways = 2 if lead else 0
        return (
            line.case_table(cases),
            table(rides, len(self.coordinate_forces[0]), -1),
            table([(self.bearing_matrix, 2)], B, N),
            table([(v, 1) for v in (self.bearing_stiffness, self.loss, self.rubber_compliance)],
                  3, B),
            np.empty((prod(cases), N, 0), complex) if unbalance is None
            else table([(unbalance, 2)], N, -1),
            table([(self.approach_matrix, 2)], R, N),
            table(lead, 2, ways, -1) if lead else np.empty((prod(cases), 2, 0, 0)),
        )  # fmt: skip

    def transient_bearing_forces(
        self,
        time: FloatArray,
        turned: FloatArray,
        *,
        torque: FloatArray,
        speed: FloatArray,
        on_axle: FloatArray,
        travel: FloatArray,
        slip: FloatArray,
    ) -> FloatArray:
        """Return what the bearings carry along a drive, step by step from rest, (P, n-2) N.

        Of a sketch of one case, at the worst thrust of each instant, without unbalance. Steps
        by the implicit midpoint; the rubber's loss is that of dampers that lose as much at each
        mode. What modes beyond the sketch's bear, they bear at once.

        Parameters
        ----------
        time : (P,) s
            Of even steps, short against the fastest mode.
        turned : (P,) rad
            How far the gearbox's yoke has turned.
        torque, speed, on_axle, travel, slip : (P,)
            As `bearing_forces_at` has them, at each instant.
        """
        ride = self.axle_positions.normalised_coordinates(on_axle, travel)

        def bent(values: _Bent) -> Any:
            return _at_ride([v[..., None] for v in values], *ride)

        wave = np.exp(2j * turned)
        f0, r0 = (torque * bent(v[0]) for v in (self.coordinate_forces, self.direct_bearing_forces))
        f2, swing, r2 = (
            torque * (bent(still) + torque * bent(more)) for still, more in self.order2_terms
        )
        on, N = self.mounted_line, len(f0)
        squares, shapes, decay = on.modes_with_decay(0.0)
        modal = on.mass @ shapes
        K = matrix_axes_last(
            on.case_last_matrices.select_cases(slice(None), 1).stiffness_under_torque(torque)
            - (swing * wave).real,
            of=2,
        )
        C = (modal * (2 * decay)) @ modal.T + speed[:, None, None] * on.gyroscopic
        inverse = np.linalg.inv(on.mass)
        slope = np.zeros((len(time), 2 * N, 2 * N))
        slope[:, :N, N:], slope[:, N:, :N], slope[:, N:, N:] = np.eye(N), -inverse @ K, -inverse @ C
        given = np.zeros((len(time), 2 * N))
        given[:, N:] = (f0 + (f2 * wave).real).T @ inverse
        h, one = np.diff(time)[:, None, None], np.eye(2 * N)
        half = h / 4 * (slope[1:] + slope[:-1])
        kick = h / 2 * (given[1:] + given[:-1])[..., None]
        steps = np.linalg.solve(one - half, np.concatenate([one + half, kick], axis=-1))
        states = np.zeros((len(time), 2 * N))
        for k, step in enumerate(steps):
            states[k + 1] = step[:, :-1] @ states[k] + step[:, -1]
        # Rubber's dampers, which lose what it loses at each mode.
        slow = shapes / np.sqrt(squares) @ modal.T
        give = states[:, :N] + self.loss[:, None, None] * (states[:, N:] @ slow.T)
        pulled = self.bearing_stiffness[:, None] * (self.bearing_matrix[:, None, :] * give).sum(-1)
        mean = r0 + (r2 * wave).real + bent(self.weight_forces) + pulled
        drawn, _ = self._thrust(torque, slip, lambda values, _: values[..., None])
        return np.maximum.reduce([_size(mean + more) for more in (0.0, *drawn)]).T

    def _thrust(
        self, torque: Any, slip: Any, own: Callable[[Any, int], Any]
    ) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
        """Return what thrust adds to bearings (B, ...) and coordinates (N, ...), either way.

        `own` gives what the cases of the points have, of arrays with so many axes before them.
        """
        if self.thrust is None:
            return (), ()
        forces, moves = [], []
        for way in (0, 1):

            def here(values: Any, of: int, way: int = way) -> Any:
                return np.where(torque >= 0, *(own(v[way], of) for v in values))

            P = here(self.thrust.compression, 1)
            share = np.repeat(held_share(slip, P), 3, axis=0)
            forces.append(here(self.thrust.force, 1) * share)
            share = held_share(slip, here(self.thrust.own_compression, 0))
            moves.append(here(self.thrust.moved, 1) * share)
        return tuple(forces), tuple(moves)

    def _some(
        self,
        some: CaseBlockSlices,
        T: Any,
        omega: Any,
        x: Any,
        y: Any,
        slip: Any,
        *,
        kinds: tuple[bool, ...],
    ) -> FloatArray:
        """Return mean, orders and peak of each kind, and reach, of a stretch of the cases.

        (X, P, ...) N, or m of what rubber gives, where a kind is True.
        """

        def own(values: Any, of: int) -> Any:
            return slice_case_block(broadcast_cases(values, T.ndim, of=of), some)

        def bent(values: _Bent, of: int = 1) -> Any:
            return _at_ride([own(v, of) for v in values], x, y)

        line = self.mounted_line.case_last_matrices.select_cases(some, T.ndim)
        f0, r0 = (T * bent(v[0]) for v in (self.coordinate_forces, self.direct_bearing_forces))
        f2, swing, r2 = (
            T * (bent(still, of) + T * bent(more, of))
            for (still, more), of in zip(self.order2_terms, (1, 2, 1), strict=True)
        )
        q0, q2, q4 = line.harmonic_balance(f0, f2, None, (swing, None), speed=omega, torque=T)
        rows, springs = own(self.bearing_matrix, 2), own(self.bearing_stiffness, 1)
        firm = springs * (1 + 1j * np.sign(omega) * own(self.loss, 1))
        weight = bent(self.weight_forces)
        drawn, moved = self._thrust(T, slip, own)
        nearer = own(self.approach_matrix, 2)
        reach = matrix_product(nearer, q0) - bent(self.clearance)
        reach = reach + np.maximum.reduce([0 * reach, *(matrix_product(nearer, q) for q in moved)])
        reach += np.abs(matrix_product(nearer, q2)) + np.abs(matrix_product(nearer, q4))
        off = None
        if self.unbalance_excitation is not None:
            moved = solve(
                line.dynamic_stiffness(omega, omega, T),
                omega**2 * own(self.unbalance_excitation, 2),
            )
            off = matrix_product(rows, moved)
            reach += np.abs(matrix_product(nearer, moved)).sum(axis=1)
        still, twice, fourth = (matrix_product(rows, q) for q in (q0, q2, q4))
        found: list[FloatArray] = []
        for gives in kinds:
            if gives:
                soft = own(self.rubber_compliance, 1)
                r0, r2, weight = soft * r0, soft * r2, 0.0 * weight
                drawn = tuple(soft * more for more in drawn)
                springs = firm = soft * springs  # what rubber loses turns its force, not its motion
            mean = r0 + weight + springs * still
            static = np.maximum.reduce([_size(mean + more) for more in (0.0, *drawn)])
            dynamic = _axis(r2 + firm * twice) + _axis(firm * fourth)
            peak = static + dynamic
            if off is not None:
                peak = peak + _axis(firm[:, None] * off).sum(axis=1)
            found += [static, dynamic, peak]
        return np.concatenate([*found, reach])


def bearing_force_screening_model(
    on: MountedLine,
    layouts: Layout,
    line: Line,
    phases: ArrayLike,
    *,
    rides: AxleTravelByTorque,
    most: ArrayLike,
    gravity: float = 0.0,
    balanced_at: ArrayLike | None = None,
    facing: ObstacleCandidates | None = None,
    thrust: ScreenedThrust | None = None,
) -> BearingForceScreeningModel:
    """Return a line for all points of some rides of its axle.

    Where it runs at each of their nodes is on the first axis of `layouts` (rides, ..., S, n, 3);
    what it is `facing` there. The `most` torque of the points,
    (..., S) N m, twists its shafts either way, and others in proportion. Other arguments are
    those of `cardan.physics.loads.centre_bearing.bearing_forces`.
    """
    most = np.where(np.asarray(most) > 0, most, 1.0)
    ahead, back = (
        _of_one(on, layouts, line, line.phases_under_torque(phases, T)) for T in (most, -most)
    )
    # Between the two it goes straight, and where there is no torque nothing is left of it.
    f0, f2, r0, r2, swing = ((a + b) / 2 for a, b in zip(ahead, back, strict=True))
    gains = [
        (a - b) / (2 * most.reshape(*most.shape, *(1,) * of))
        for a, b, of in zip(ahead, back, (1, 1, 1, 1, 2), strict=True)
    ]
    weight, _ = bearing_forces_of_weight_and_thrust(layouts, line, gravity=gravity)
    if facing is None:
        free = np.empty((1, *layouts.points.shape[1:-2], 0))
        nearer = np.empty((*layouts.points.shape[1:-2], 0, on.mass.shape[-1]))
    else:
        free, nearer = facing.clearance, on.weighted_end_motion(facing.approach_matrix)
    return BearingForceScreeningModel(
        mounted_line=on,
        axle_positions=rides,
        coordinate_forces=(_parabola(f0.real), _parabola(f2)),
        order2_coupling=_parabola(swing, of=2),
        direct_bearing_forces=(_parabola(r0.real), _parabola(r2)),
        twist_gains=(_parabola(gains[1]), _parabola(gains[4], of=2), _parabola(gains[3])),
        weight_forces=_parabola(_across(on, weight)),
        thrust=thrust,
        bearing_matrix=matrix_axes_first(on.bearing_matrix, of=2),
        bearing_stiffness=matrix_axes_first(on.bearing_stiffness, of=1),
        loss=matrix_axes_first(np.repeat(on.loss, 3, axis=-1), of=1),
        rubber_compliance=matrix_axes_first(on.rubber_compliance, of=1),
        unbalance_excitation=None if balanced_at is None
        else matrix_axes_first(unbalance_excitation(line, on, balanced_at=balanced_at).mT, of=2),
        clearance=_parabola(free),
        approach_matrix=matrix_axes_first(nearer, of=2),
    )  # fmt: skip


def held_share(slip: ArrayLike, compression: FloatArray) -> FloatArray:
    """Return the share of a compression N that a slip force N holds, at most 1."""
    size = np.abs(compression)
    return np.minimum(1.0, np.asarray(slip) / np.where(size > 0, size, 1.0))


def _of_one(on: MountedLine, layouts: Layout, line: Line, phases: FloatArray) -> list[Any]:
    """Return what 1 N m does, orders 0 and 2 on coordinates and bearings, and their swing."""
    turned = rotate_chain(layouts.directions, phases=phases, crosses=line.is_cross, samples=16)
    one = joint_loads(layouts, turned, line, torque=1.0)
    moments, still = ((c.order(0), c.order(2)) for c in (one.joint_moments, one.bearing_forces))
    pushes = [on.forces_from_joint_moments(m) for m in moments]
    # Less what the coordinates take at rest.
    borne = [
        _across(on, s - on.static_bearing_forces(p)) for s, p in zip(still, pushes, strict=True)
    ]
    return [*pushes, *borne, on.order2_coupling(turned)]


def _across(on: MountedLine, force: Any) -> Any:
    """Return forces (..., n-2, 3) N in the bearings' own directions, (..., B) N."""
    local = (on.bearing_frame @ force[..., None])[..., 0]
    return local.reshape(*local.shape[:-2], -1)


def _parabola(values: Any, *, of: int = 1) -> _Bent:
    """Return the coefficients of values (rides, ..., S, M) at the nodes of `AxleTravelByTorque`."""
    low, *others = (np.ascontiguousarray(matrix_axes_first(v, of=of)) for v in values)
    if not others:
        return (low,)
    middle, high, *beside = others
    along = middle, (high - low) / 2, (high + low) / 2 - middle
    if not beside:
        return along
    below, above, corner = beside
    across = (above - below) / 2, (above + below) / 2 - middle
    return *along, *across, corner - sum(along) - sum(across)


def _at_ride(values: Sequence[Any], x: Any, y: Any) -> Any:
    """Return what coefficients say at rides (x, y)."""
    if len(values) == 1:
        return values[0]
    found = (values[2] * x + values[1]) * x + values[0]
    if len(values) > 3:
        found = found + (values[4] * y + values[3] + values[5] * x) * y
    return found


def _by_bearing(force: Any) -> Any:
    """Return forces (B, ...) N as (n-2, ..., 3): up, sideways, along."""
    return np.moveaxis(force.reshape(-1, 3, *force.shape[1:]), 1, -1)


def _size(force: FloatArray) -> FloatArray:
    """Return the sizes (n-2, ...) of forces (B, ...)."""
    x, y, z = np.moveaxis(_by_bearing(force), -1, 0)
    return np.sqrt(x * x + y * y + z * z)


def _axis(force: ComplexArray) -> FloatArray:
    """Return the longer half axes (n-2, ...) of forces (B, ...)."""
    return semi_major_axis(_by_bearing(force))
