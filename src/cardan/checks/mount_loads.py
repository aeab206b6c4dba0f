"""What the centre bearings of a line carry at its worst operating points."""

from functools import cached_property
from typing import Literal

import numpy as np

from cardan.checks import worst_points as search
from cardan.checks.candidate_points import (
    CandidatePoints,
    ScreenedForces,
    candidate_points,
    refined_candidates,
    screen_candidates,
)
from cardan.checks.line_on_mounts import LineOnMounts
from cardan.checks.operating_point_results import OperatingPointResults
from cardan.checks.rigid_line_loads import RigidLineLoads
from cardan.checks.rubber_at_stop import StopResponse, stop_response
from cardan.checks.stuck_spline import STUCK_FORCE_KINDS, StuckForces, stuck_forces
from cardan.checks.stuck_spline_estimate import (
    BATCH_SAFETY_FACTOR,
    stuck_force_estimate,
)
from cardan.core.arrays import ArrayLike, BoolArray, FloatArray, stack_on_last_axis
from cardan.core.labels import OrderCrossing
from cardan.core.lazy_dataclass import dataclass
from cardan.model import layout
from cardan.physics.loads.centre_bearing import BearingForces
from cardan.physics.loads.rubber_mount import DEFAULT_STOP_TRAVEL_M, MountedLine
from cardan.physics.loads.rubber_stop_response import STOP_STIFFNESS_RANGE
from cardan.physics.loads.statics import bearing_forces_of_weight_and_thrust
from cardan.physics.vehicle.operating_points import LineOperatingPoints
from cardan.physics.vehicle.state_demand import LineStateDemand

LEAST_STUCK_EXCESS = 0.01
"""By which a force with the spline stuck must exceed that with it sliding to count instead."""

NEAR_STOP_SHARE = 0.95
"""Share of the force at a stop below which no travel is sought: less than any bearing needs."""


@dataclass(frozen=True, kw_only=True)
class MountLoads:
    """Loads and travel of the centre bearings, and of joints on them, where they are worst."""

    mounts: LineOnMounts
    rigid_loads: RigidLineLoads

    @cached_property
    def mounted_bearing_forces(self) -> BearingForces:
        """What the bearings carry on their rubber at the state's own torque and top speed."""
        return self.mounts.bearing_forces_at(self.mounts.inputs.demand, self.mounts.inputs.layout)

    @cached_property
    def candidate_points(self) -> CandidatePoints | None:
        """The operating points among which its bearings' worst ones are sought."""
        return candidate_points(self.mounts)

    @cached_property
    def screened_forces(self) -> ScreenedForces | None:
        """What it nearly does there; None of a line that is not on rubber."""
        return screen_candidates(self.mounts, self.candidate_points)

    @cached_property
    def refined_forces(self) -> OperatingPointResults | None:
        """What bearings nearly carry there, and next to the worst of those points."""
        of, found = self.candidate_points, self.screened_forces
        return of and found and refined_candidates(self.mounts, of, found.forces)

    @cached_property
    def worst_bearing_forces(self) -> dict[str, OperatingPointResults]:
        """The operating point at which each bearing's mean, orders and peak are largest."""
        return search.worst_bearing_forces(self.mounts, self.candidate_points, self.refined_forces)

    @cached_property
    def worst_bearing_travel(self) -> OperatingPointResults | None:
        """The operating point at which each bearing goes farthest across its rubber, in m."""
        return search.worst_bearing_travel(self.mounts, self.candidate_points, self.screened_forces)

    @cached_property
    def worst_obstacle_clearance(self) -> OperatingPointResults | None:
        """The operating point at which each shaft comes nearest to each obstacle, on rubber."""
        return search.worst_obstacle_clearance(self.mounts, self.screened_forces)

    @cached_property
    def worst_joint_forces(self) -> OperatingPointResults | None:
        """The operating point at which each joint is shaken most on rubber."""
        return search.worst_joint_forces(self.mounts)

    @cached_property
    def worst_growth_rate(self) -> OperatingPointResults | None:
        """The operating point at which the line's swinging grows most, or decays least."""
        return search.worst_growth_rate(self.mounts)

    def all_points(self) -> OperatingPointResults | None:
        """Return all points (P, ..., S) evaluated for the worst on bearings; None if none."""
        return search.all_bearing_operating_points(
            self.mounts, self.candidate_points, self.refined_forces, self.worst_bearing_forces
        )

    def forces_with_other_loss_factors(self, assumed: FloatArray) -> BearingForces:
        """Return what bearings carry at their points of most orders, of `assumed` (F, 1)."""
        worst = self.worst_bearing_forces["dynamic"]
        return search.bearing_forces_at_loss_factors(self.mounts, worst, assumed=assumed)

    @cached_property
    def rubber_stop_travel(self) -> FloatArray:
        """How far the rubber of each bearing goes to its stop, (..., n-2) m; inf of rigid ones.

        `DEFAULT_STOP_TRAVEL_M`, assumed, where a file does not give it.
        """
        assumed = np.where(np.isnan(self.mount_stop_travel), DEFAULT_STOP_TRAVEL_M, np.inf)
        hung = [bool(b.stiffness) for b in self.mounts.inputs.line.centre_bearings]
        return np.where(hung, np.fmin(self.mount_stop_travel, assumed), np.inf)

    def stop_margin(self, kind: Literal["static", "peak"]) -> FloatArray:
        """Return the share of the travel to each bearing's stop still free, (..., S, n-2) 1.

        By the mean, or at most. Negative where linear rubber goes beyond: a motion that stays
        within is linear, so then none does. 1 where no force comes near. Where one bearing goes
        beyond, the others have its margin: what a stop takes on or throws off they carry.
        """
        own = self._own_stop_margin(kind)
        least = own.min(axis=-1, keepdims=True, initial=1.0)
        return np.where(least < 0, least, own)

    def _own_stop_margin(self, kind: Literal["static", "peak"]) -> FloatArray:
        """Return the share of the travel to its own stop that each bearing has free."""
        if kind not in self._own_stop_margins:
            self._own_stop_margins[kind] = self._computed_stop_margin(kind)
        return self._own_stop_margins[kind]

    @cached_property
    def _own_stop_margins(self) -> dict[str, FloatArray]:
        """Those that were evaluated, by kind: every limit on forces needs them."""
        return {}

    def _computed_stop_margin(self, kind: Literal["static", "peak"]) -> FloatArray:
        on, worst = self.mounts.mounted_line, self.worst_bearing_forces
        stop = self.rubber_stop_travel
        none = np.ones((1, stop.shape[-1]))
        if on is None or not worst:
            return none
        largest = np.nan_to_num(worst["peak"].results.peak)
        if not (largest > NEAR_STOP_SHARE * self.least_force_at_stop).any():
            return none
        goes = self.worst_bearing_travel
        assert goes is not None  # where forces on rubber are known
        travel = getattr(goes.results, kind)
        if kind == "static":  # whose own worst point may be another one
            mean = worst["static"].results.mean - self._weight
            travel = np.maximum(travel, np.linalg.norm(on.rubber_deflection(mean).real, axis=-1))
        return np.where(np.isnan(travel), 1.0, 1 - travel / stop)

    def stop_margin_under(self, demand: LineStateDemand) -> FloatArray:
        """Return `stop_margin` at most, under one demand instead of all points, (S, n-2) 1."""
        on, stop = self.mounts.mounted_line, self.rubber_stop_travel
        if on is None:
            return np.ones((1, stop.shape[-1]))
        goes = self.mounts.bearing_forces_at(
            demand, self.mounts.inputs.layout_for(demand), gives=True
        )
        own = np.where(np.isnan(goes.peak), 1.0, 1 - goes.peak / stop)
        least = own.min(axis=-1, keepdims=True, initial=1.0)
        return np.where(least < 0, least, own)

    def force_at_stop(self, name: str) -> FloatArray:
        """Return one of `FORCE_KINDS` on each bearing at least, where a stop is met, (..., n-2) N.

        `bound_of_linear_rubber`, or what is solved of the line there, as without thrust, if that is
        larger. Where all of it is solved it is `evaluated_force`. With the spline stuck, if that
        is more.
        """
        sliding = self._sliding_force_at_stop(name)
        if self.stuck_forces is None or name not in STUCK_FORCE_KINDS:
            return sliding
        return np.where(self.is_stuck(name), self.stuck_forces.forces[name], sliding)

    def _sliding_force_at_stop(self, name: str) -> FloatArray:
        """Return `force_at_stop` of a line whose spline slides."""
        least, solved = self.bound_of_linear_rubber(name), self.stop_response
        if solved is None:
            return least
        own = np.where(self._is_beyond_own_stop(name), solved.force(name), -np.inf)
        return np.where(solved.is_solved[:, None], solved.force(name), np.fmax(least, own))

    def bound_of_linear_rubber(self, name: str) -> FloatArray:
        """Return what linear rubber says of one of `FORCE_KINDS` at a stop, (..., n-2) N.

        The larger of its force and `least_force_at_stop`, less the mean where only what shakes
        counts. The former alone of a bearing that stays within its own stop.
        """
        contact, linear = self.least_force_at_stop, self.bearing_force(name)
        if name == "dynamic":
            contact = np.maximum(contact - self.bearing_force("static"), 0.0)
        return np.where(self._is_beyond_own_stop(name), np.fmax(contact, linear), linear)

    def _is_beyond_own_stop(self, name: str) -> BoolArray:
        return self._own_stop_margin("static" if name == "static" else "peak") < 0

    def crest_over_linear(self, name: str) -> FloatArray:
        """Return one of `FORCE_KINDS` over what linear rubber says of it, (S, n-2) 1."""
        if self.stop_response is None and not self.is_stuck(name).any():
            return np.ones((1, 1))
        linear = self.bound_of_linear_rubber(name)
        return self.force_at_stop(name) / np.where(linear > 0, linear, np.inf)

    @cached_property
    def stop_response(self) -> StopResponse | None:
        """What bearings carry in states in which rubber meets its stop; None where none does.

        Of one design. Of many it is too dear: their forces there are lower bounds.
        """
        held = self.mounts.mounted_line
        return held and self.stop_response_on(held)

    def stop_response_on(self, held: MountedLine, *, reaches: bool = True) -> StopResponse | None:
        """Return `stop_response` of a line that moves otherwise, as with another loss factor.

        `reaches` is whether how far shafts reach into obstacles is evaluated too.
        """
        screened, refined = self.screened_forces, self.refined_forces
        if screened is None or refined is None:
            return None
        beyond = np.asarray((self._own_stop_margin("peak") < 0).any(axis=-1))
        if beyond.ndim > 1 or not beyond.any():  # of many designs it is too dear
            return None
        return stop_response(
            self.mounts,
            screened.travel,
            refined,
            stop=self.rubber_stop_travel.reshape(-1),
            ratios=self.stop_stiffness_ratios,
            states=beyond,
            held=held,
            reaches=reaches,
        )

    @property
    def stop_stiffness_ratios(self) -> FloatArray:
        """Stiffness of each bearing beyond its stop over that before it, (R, n-2).

        `STOP_STIFFNESS_RANGE`, assumed, where a file does not give it: R is 2, or 1.
        """
        told = [b.stop_stiffness_ratio for b in self.mounts.inputs.line.centre_bearings]
        hung = [bool(b.stiffness) for b in self.mounts.inputs.line.centre_bearings]
        each = [
            [1.0 if not soft else end if t is None else float(t) for t, soft in zip(
                told, hung, strict=True)]
            for end in STOP_STIFFNESS_RANGE
        ]  # fmt: skip
        return np.array(each[:1] if each[0] == each[1] else each)

    @property
    def is_solved_at_stop(self) -> BoolArray:
        """Whether rubber meets its stop in a state and the forces there are solved, (S, 1)."""
        solved = self.stop_response
        return np.array([[False]]) if solved is None else solved.is_solved[:, None]

    def evaluated_force(self, name: str) -> FloatArray:
        """Return one of `FORCE_KINDS` on each bearing where it is largest, (..., n-2) N.

        `bearing_force`; in a state in which rubber meets its stop, where it is solved, with it;
        with the spline stuck, if that is more.
        """
        found, solved = self.bearing_force(name), self.stop_response
        if solved is not None:
            found = np.where(solved.is_solved[:, None], solved.force(name), found)
        if self.stuck_forces is None or name not in STUCK_FORCE_KINDS:
            return found
        return np.where(self.is_stuck(name), self.stuck_forces.forces[name], found)

    @cached_property
    def stuck_forces(self) -> StuckForces | None:
        """What bearings carry while friction holds the spline; None where it is not evaluated.

        Of one design. Of many it is too dear: `unproved_margin` is what their estimate leaves open.
        """
        if self._is_of_many or not self.worst_bearing_forces:
            return None
        return stuck_forces(
            self.mounts,
            self.rubber_stop_travel.reshape(-1),
            sliding={k: self._sliding_force_at_stop(k) for k in STUCK_FORCE_KINDS},
        )

    @cached_property
    def stuck_force_estimate(self) -> dict[str, FloatArray]:
        """What bearings nearly carry with the spline stuck, (..., S, n-2) N by kind, or nothing.

        0 where friction holds nothing.
        """
        return stuck_force_estimate(self.mounts) if self.worst_bearing_forces else {}

    @property
    def _is_of_many(self) -> bool:
        """Whether designs have an axis, of one design too: then no stuck spline is solved."""
        of, thrust = self.mounts, self.mounts.stroke_thrust
        return (
            self.rubber_stop_travel.ndim > 1
            or of.torque_curves.max_speed.ndim > 2
            or of.inputs.layout.points.ndim > 3
            or (thrust is not None and thrust.own_compression.ndim > 3)
        )

    def unproved_margin(self, name: str, threshold: ArrayLike) -> FloatArray | None:
        """Return the share of a force that no stuck spline exceeds for certain, (..., S, n-2) 1.

        Negative where the spline that sticks may put more than a `threshold` (..., 1, 1) N on a
        bearing, or take its rubber to a stop. None where forces with it are solved, or are none.
        """
        if not self._is_of_many or not (estimate := self.stuck_force_estimate):
            return None
        of = BATCH_SAFETY_FACTOR * estimate[name]
        margin = 1 - of / np.asarray(threshold)
        peak = BATCH_SAFETY_FACTOR * estimate["peak"]
        at_stop = 1 - peak / np.maximum(self.least_force_at_stop, 1.0)
        counts = of > (1 + LEAST_STUCK_EXCESS) * self.bearing_force(name)
        return np.where(counts, np.minimum(margin, at_stop), np.maximum(margin, 0.0))

    def is_stuck(self, name: str) -> BoolArray:
        """Return where one of `FORCE_KINDS` is largest with the spline stuck, (S, n-2)."""
        if name not in self._is_stuck:
            found = np.zeros((1, 1), dtype=bool)
            if self.stuck_forces is not None and name in STUCK_FORCE_KINDS:
                sliding = (1 + LEAST_STUCK_EXCESS) * self._sliding_force_at_stop(name)
                found = np.nan_to_num(self.stuck_forces.forces[name]) > sliding
            self._is_stuck[name] = found
        return self._is_stuck[name]

    def stuck_forces_of(self, name: str, state: int, bearing: int) -> dict[str, float]:
        """Return what a force consists of, N by kind, where it is largest with the spline stuck."""
        found, stuck = self.stuck_forces, self.is_stuck(name)
        if found is None or not np.broadcast_to(stuck, found.forces["peak"].shape)[state, bearing]:
            return {}
        each = found.peak_parts if name == "peak" else {name: found.forces[name]}
        return {kind: float(values[state, bearing]) for kind, values in each.items()}

    @cached_property
    def _is_stuck(self) -> dict[str, BoolArray]:
        """Those that were evaluated, by name."""
        return {}

    def points_of_evaluated_force(self, name: str) -> LineOperatingPoints | None:
        """Return the points (..., S, n-2) of `evaluated_force`; None where a line has none."""
        found, solved = self.worst_bearing_forces.get(name), self.stop_response
        if found is None:
            return None
        others = [] if solved is None else [(solved.points[name], solved.is_solved[:, None])]
        if self.stuck_forces is not None and self.is_stuck(name).any():
            others.append((self.stuck_forces.points[name], self.is_stuck(name)))
        for own, of in others:
            found = LineOperatingPoints(
                curves=found.curves,
                curve_index=np.where(of, own.curve_index, found.curve_index),
                speed=np.where(of, own.speed, found.speed),
                torque=np.where(of, own.torque, found.torque),
                is_spline_stuck=np.broadcast_to(self.is_stuck(name), found.speed.shape),
            )
        return found

    def force_validity_margin(self, name: str) -> FloatArray:
        """Return `stop_margin` where one of `FORCE_KINDS` is not solved with the stop, else 1.

        Of a force with the spline stuck, where its motion goes beyond a stop, what that leaves.
        """
        margin = self.stop_margin("static" if name == "static" else "peak")
        if self.stop_response is not None:
            margin = np.where(self.is_solved_at_stop, 1.0, margin)
        if self.stuck_forces is None or not (stuck := self.is_stuck(name)).any():
            return margin
        return np.where(stuck, np.minimum(margin, 1 - self.stuck_forces.travel_share[name]), margin)

    @cached_property
    def _weight(self) -> FloatArray:
        """What weight puts on each bearing, (..., n-2, 3) N."""
        inputs = self.mounts.inputs
        return bearing_forces_of_weight_and_thrust(
            inputs.layout, inputs.line, gravity=inputs.gravity
        )[0]

    @cached_property
    def least_force_at_stop(self) -> FloatArray:
        """What each bearing carries at least with its rubber at its stop, (..., S, n-2) N.

        The rubber pushes with its stiffness times the travel to it, that of its softer direction
        here; weight, which set the line where it hangs, may help. inf of rigid bearings.
        """
        on, stop = self.mounts.mounted_line, self.rubber_stop_travel
        if on is None:
            return np.full((1, stop.shape[-1]), np.inf)
        gives = on.rubber_compliance.reshape(*on.rubber_compliance.shape[:-1], -1, 3).max(axis=-1)
        return np.maximum(stop / gives - np.linalg.norm(self._weight, axis=-1), 0.0)

    @cached_property
    def mount_stop_travel(self) -> FloatArray:
        """How far the rubber of each centre bearing goes, (..., n-2) m; nan where unknown."""
        told = (b.travel for b in self.mounts.inputs.line.centre_bearings)
        return stack_on_last_axis(np.nan if t is None else t for t in told)

    def bearing_force(self, name: str) -> FloatArray:
        """Return one of `FORCE_KINDS` on each bearing where it is largest, (..., n-2) N.

        Where a line has no operating point it is that of rigid bearings at its own torque.
        """
        found = (
            getattr(self.worst_bearing_forces[name].results, name)
            if name in self.worst_bearing_forces
            else None
        )
        if found is not None and not np.isnan(found).any():
            return found
        rigid = {
            "static": lambda: layout.vector_length(
                self.rigid_loads.joint_loads.bearing_forces.static
            ),
            "dynamic": lambda: self.rigid_loads.joint_loads.bearing_forces.dynamic,
            "peak": lambda: self.rigid_loads.rigid_bearing_peaks,
        }[name]()
        return rigid if found is None else np.where(np.isnan(found), rigid, found)

    def order_crossings(self, spots: LineOperatingPoints) -> list[list[OrderCrossing | None]]:
        """Return the mode on the rubber that an order meets at points (S, parts), None where none.

        Met is what lies within its resonance's width at half its power, ζ each way, and swings
        across the shafts: nothing of a joint pushes along them.
        """
        found: list[list[OrderCrossing | None]] = [
            [None] * spots.speed.shape[1] for _ in spots.speed
        ]
        if self.mounts.mounted_line is None:
            return found
        stuck = spots.is_spline_stuck
        orders = np.array([2, 1] if self.mounts.inputs.application.include_unbalance else [2])
        for part, (torque, speed) in enumerate(zip(spots.torque.T, spots.speed.T, strict=True)):
            modes = self.mounts.mounted_line.modes(torque=np.nan_to_num(torque))
            slow = np.maximum(modes.frequency, 1e-300)  # torque may buckle a line
            off = np.abs(np.multiply.outer(orders, speed)[..., None] / slow - 1)
            off = np.where(modes.not_excited, np.inf, off)
            for state in range(len(speed)):
                order, k = np.unravel_index(off[:, state].argmin(), off[:, state].shape)
                held = stuck is not None and stuck[state, part]  # which has other modes
                if off[order, state, k] <= modes.damping_ratio[state, k] and not held:
                    shape, frequency = modes.mode_names(state)[k], float(slow[state, k])
                    found[state][part] = OrderCrossing(shape, frequency, int(orders[order]))
        return found

    @cached_property
    def resonance_distance(self) -> FloatArray:
        """How far a duty cycle's speeds stay off the modes on the rubber, (...) 1.

        The least |k Ω / ω - 1| of its speeds Ω, of order 2 of the joints, and order 1 where
        unbalance counts, and of the modes ω that its torques leave the line; nan if
        unknown, and in states that do not last.
        """
        orders = (1, 2) if self.mounts.inputs.application.include_unbalance else (2,)
        found = np.full(self.mounts.inputs.layout.directions.shape[:-2], np.nan)
        if self.mounts.mounted_line is None or not (duty := self.mounts.inputs.duty_points):
            return found
        like = np.zeros(self.mounts.mounted_line.case_last_matrices.cases)
        each = np.broadcast_arrays(*(v for p in duty for v in (p.torque, p.speed)), like)[:-1]
        torque, speed = np.stack(each[::2]), np.stack(each[1::2])
        modes = self.mounts.mounted_line.natural_frequencies(torque=torque)[
            ..., : self.mounts.inputs.line.rigid_body_mode_count
        ]  # others bend tubes
        modes = np.where(modes > 0, modes, 1e-300)  # torque may buckle a line
        off = np.stack([np.abs(k * speed[..., None] / modes - 1).min(axis=-1) for k in orders])
        found = np.fmin.reduce(off, axis=(0, 1))
        return np.where(self.mounts.inputs.sustained_states, found, np.nan)
