"""What centre bearings carry where their rubber meets its stop, solved by harmonic balance.

A line is solved again in the states in which linear rubber would go beyond a stop, along each of
its curves of torque over speed on which it does. Between the stops the motion is that of linear
rubber, so everywhere else the linear answer holds.
"""

from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from cardan.checks.clearance_at_stop import ObstaclesAlongSweeps, obstacles_along_sweeps
from cardan.checks.line_on_mounts import LineOnMounts
from cardan.checks.operating_envelope import PointRows
from cardan.checks.operating_point_results import OperatingPointResults, largest_point, point_rows
from cardan.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from cardan.core.lazy_dataclass import dataclass
from cardan.physics.kinematics.joint_chain import rotate_chain
from cardan.physics.loads.centre_bearing import bearing_forces
from cardan.physics.loads.half_turn_fourier import semi_major_axis
from cardan.physics.loads.rubber_mount import MountedLine
from cardan.physics.loads.rubber_stop_contact import components, forces_at_stop, largest_travel
from cardan.physics.loads.rubber_stop_receptance import (
    StoppedLine,
    StopReceptance,
    at_places,
    receptance_alone,
    tied_receptance,
)
from cardan.physics.loads.rubber_stop_response import StoppedMotion, all_motions
from cardan.physics.loads.statics import bearing_forces_of_weight_and_thrust
from cardan.physics.vehicle.operating_points import (
    LineOperatingPoints,
    demand_at_operating_points,
)

FORCE_KINDS = ("static", "dynamic", "peak")

NEAR_STOP_SHARE = 0.97
"""Of the travel to its stop, from which on linear rubber's motion is followed."""

SPEED_REACH = (0.7, 2.2)
"""How far below and above the speeds of such motions they are followed."""

SPEED_COUNT = 80
"""Speeds at which a line is evaluated there; between two it is taken as linear."""

SLIDING_TOLERANCE = 1e-3
"""Of the slip force: a thrust that is less by more is what the stroke reaches, and held."""

_LARGEST_GAP = 2.5 * SPEED_COUNT / 40
"""Speeds of the grid between two motions found, beyond which a line is not solved."""


@dataclass(frozen=True, kw_only=True, eq=False)
class StopResponse:
    """Forces of the bearings of states in which rubber meets its stop; R ratios of stiffness.

    Attributes
    ----------
    ratios : (R, n-2) 1
        Stiffness beyond the stop over that before it, smallest first. With the smallest the state
        alone in which linear rubber has the largest peak force is solved.
    is_solved : (S,)
        Whether the line meets a stop in a state and its motion is found.
    forces : (R, S, n-2) N, by `FORCE_KINDS`
        Largest at any operating point of the state. Of a state that is not solved, at least
        that; nan of one that meets no stop.
    points
        The points (S, n-2) of the largest of them, with the largest ratio.
    peak_parts : (S, n-2) N, of "static" and "dynamic"
        What the peak force consists of at its point, beside unbalance.
    travel : (R, S, n-2) m
        Largest way across the shaft.
    reach : (S, A) m
        How far the shafts reach into the obstacles at most, of A pairs, obstacles of the first
        shaft before those of the second; -inf where no motion is found.
    """

    ratios: FloatArray
    is_solved: BoolArray
    forces: dict[str, FloatArray]
    points: dict[str, LineOperatingPoints]
    peak_parts: dict[str, FloatArray]
    travel: FloatArray
    reach: FloatArray

    def force(self, kind: str) -> FloatArray:
        """Return one of `FORCE_KINDS` with the larger ratio, (S, n-2) N."""
        return self.forces[kind][-1]


@dataclass(frozen=True, kw_only=True, eq=False)
class _Sweeps:
    """Curves along which a line is followed, C of them, and between what speeds rad/s.

    `crests` (K, C) are speeds of linear rubber's largest forces; `ends_with_curve` says whether
    `high` is the highest speed of the curve.
    """

    state: IntArray
    curve: IntArray
    low: FloatArray
    high: FloatArray
    crests: FloatArray
    ends_with_curve: BoolArray

    @cached_property
    def speeds(self) -> FloatArray:
        """The speeds of the grid, (Q, C) rad/s, a share apart; `crests` (K, C) are among them."""
        first = np.maximum(self.low, self.high / SPEED_REACH[1] / 4)
        share = np.linspace(0, 1, SPEED_COUNT - 1)[:, None]
        span = np.divide(self.high, first, out=np.ones_like(first), where=first > 0)
        grid = first * span**share  # of a line that does not turn all at 0
        start = np.where(self.low < first, self.low, 0.5 * (3 * grid[0] - grid[1]))
        found = np.concatenate([np.minimum(start, grid[0])[None], grid])
        for crest in self.crests:
            nearest = np.abs(found[1:-1] - crest).argmin(axis=0) + 1
            inside = (crest > found[0]) & (crest < found[-1])
            here = nearest, np.arange(len(crest))
            found[here] = np.where(inside, crest, found[here])
        return np.sort(found, axis=0)

    def holds(self, curve: IntArray, speed: FloatArray) -> BoolArray:
        """Return which of points (P, S) lie on them."""
        found = np.zeros(curve.shape, dtype=bool)
        for s, c, low, high in zip(self.state, self.curve, self.low, self.high, strict=True):
            found[:, s] |= (curve[:, s] == c) & (speed[:, s] >= low) & (speed[:, s] <= high)
        return found


def stop_response(
    mounts: LineOnMounts,
    travel: OperatingPointResults,
    forces: OperatingPointResults,
    *,
    stop: FloatArray,
    ratios: FloatArray,
    states: BoolArray,
    held: MountedLine,
    reaches: bool = True,
) -> StopResponse | None:
    """Return what bearings carry in `states` (S,) in which linear rubber goes beyond its stop.

    Parameters
    ----------
    travel, forces
        How far linear rubber goes at points (P, S), and what it carries.
    stop : (n-2,) m
    ratios : (R, n-2)
    held
        How the line can move on its rubber.
    reaches
        Whether how far shafts reach into obstacles is evaluated too.
    """
    sweeps = _sweeps(mounts, travel, forces, stop, states)
    if sweeps is None:
        return None
    grid = _Grid.of(mounts, sweeps, held)
    others = _others(mounts, forces, sweeps)
    of, thrust = grid.cases()
    told, worst = np.full(len(of), len(ratios) - 1), 0
    if len(ratios) > 1:  # the range is evaluated where linear rubber has the largest force
        met = np.isin(np.arange(len(states)), sweeps.state)[:, None]
        most = np.where(met, np.nan_to_num(forces.results.peak.max(axis=0)), -1).max(-1)
        worst = int(most.argmax())
        some = np.flatnonzero(sweeps.state[of] == worst)
        of, thrust = np.concatenate([of, of[some]]), np.concatenate([thrust, thrust[some]])
        told = np.concatenate([told, np.zeros(len(some), dtype=int)])
    both, of_forces, of_reach = _both_kinds_of_cases(
        np.stack([of, thrust, told]), grid.cases_of_reach(len(ratios) if reaches else 0)
    )
    line = grid.line(both[0], both[1], stop, ratios[both[2]])
    motion = all_motions(line)
    own, found = line.select_cases(of_forces), motion.select_cases(of_forces)
    cases = _FollowedCases(
        grid=grid, sweep=of, thrust=thrust, stop=stop, place=found.place,
        sizes=grid.sizes(own, found, of, thrust),
    )  # fmt: skip
    each = [
        _solved(cases.select(np.flatnonzero(told == r)), others, len(states))
        for r in range(len(ratios))
    ]
    stiff = each[-1]
    if len(ratios) > 1:
        stiff.is_solved[worst] &= each[0].is_solved[worst]
    return StopResponse(
        ratios=ratios,
        is_solved=stiff.is_solved,
        forces={k: np.stack([one.forces[k] for one in each]) for k in FORCE_KINDS},
        points={k: _points(mounts, *stiff.points[k]) for k in FORCE_KINDS},
        peak_parts=stiff.peak_parts,
        travel=np.stack([one.travel for one in each]),
        reach=grid.reach(motion.select_cases(of_reach), both[0, of_reach], states=len(states)),
    )


def _both_kinds_of_cases(forces: IntArray, reach: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return all cases once, sweeps, thrusts and ratios (3, C), and which are of either kind."""
    each, own = np.unique(np.concatenate([forces, reach], axis=1), axis=1, return_inverse=True)
    own = own.reshape(-1)
    return each, own[: forces.shape[1]], own[forces.shape[1] :]


@dataclass(frozen=True, kw_only=True, eq=False)
class _SolvedStates:
    """Largest forces and travel in states (S, n-2) with one ratio of stiffness, nan where none.

    `points` are curves and speeds of the forces.
    """

    is_solved: BoolArray
    forces: dict[str, FloatArray]
    points: dict[str, PointRows]
    peak_parts: dict[str, FloatArray]
    travel: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class _FollowedCases:
    """Cases C whose motions were followed: sweeps of a grid, a thrust each.

    Attributes
    ----------
    sweep, thrust : (C,)
    stop : (n-2,) m
    place : (T, C)
        Where along the speeds a motion was found, nan where none.
    sizes : (T, C, n-2), by kind
        Forces N and travel m there, -inf where none.
    """

    grid: "_Grid"
    sweep: IntArray
    thrust: IntArray
    stop: FloatArray
    place: FloatArray
    sizes: dict[str, FloatArray]

    def select(self, which: IntArray) -> "_FollowedCases":
        """Return some of the cases."""
        return replace(
            self,
            sweep=self.sweep[which],
            thrust=self.thrust[which],
            place=self.place[:, which],
            sizes={kind: values[:, which] for kind, values in self.sizes.items()},
        )

    @property
    def is_unsettled(self) -> BoolArray:
        """In which cases thrust that the stroke limits takes the mean beyond a stop, (C,)."""
        return self.grid.is_thrust_unsettled(self.sweep, self.thrust, self.stop)

    @property
    def is_lost(self) -> BoolArray:
        """Whether motions are not found all along, or at a stop where the speeds end, (C,)."""
        last = SPEED_COUNT - 1.0
        found = np.sort(np.where(np.isnan(self.place), np.inf, self.place), axis=0)
        ends = np.array([[0.0], [last]]) + 0 * self.sweep
        every = np.sort(np.concatenate([np.minimum(found, last), ends]), axis=0)
        gap = np.diff(every, axis=0).max(axis=0) > _LARGEST_GAP
        at_end = (self.place > last - 0.5)[..., None] & (self.sizes["travel"] > self.stop)
        return gap | (at_end.any(axis=(0, -1)) & ~self.grid.sweeps.ends_with_curve[self.sweep])


def _solved(
    cases: _FollowedCases, others: dict[str, OperatingPointResults], states: int
) -> _SolvedStates:
    """Return the largest forces in states along cases, and among `others` off their speeds."""
    sweeps, of, sizes = cases.grid.sweeps, cases.sweep, cases.sizes
    loose = cases.is_unsettled
    met, solved = (np.isin(np.arange(states), sweeps.state[of]) for _ in range(2))
    solved[sweeps.state[of[loose | cases.is_lost]]] = False
    speeds = at_places(sweeps.speeds, cases.place, of)
    forces: dict[str, FloatArray] = {}
    points: dict[str, PointRows] = {}
    parts = {k: getattr(others["peak"].results, k).copy() for k in ("static", "dynamic")}
    for kind in FORCE_KINDS:
        linear, size = others[kind], sizes[kind]
        most = np.nan_to_num(getattr(linear.results, kind), nan=-np.inf)
        curve, speed = linear.curve_index.copy(), linear.speed.copy()
        top = size.argmax(axis=0)
        largest = np.take_along_axis(size, top[None], axis=0)[0]
        for c in np.flatnonzero(~loose).tolist():
            s = int(sweeps.state[of[c]])
            more = largest[c] > most[s]
            most[s] = np.where(more, largest[c], most[s])
            curve[s] = np.where(more, sweeps.curve[of[c]], curve[s])
            speed[s] = np.where(more, speeds[top[c], c], speed[s])
            if kind == "peak":
                for k, values in parts.items():
                    own = sizes[k][top[c], c, np.arange(len(cases.stop))]
                    values[s] = np.where(more, own, values[s])
        forces[kind] = np.where(met[:, None] & np.isfinite(most), most, np.nan)
        points[kind] = curve, speed
    far = np.full((states, len(cases.stop)), -np.inf)
    np.maximum.at(far, sweeps.state[of], sizes["travel"].max(axis=0))
    return _SolvedStates(
        is_solved=solved,
        forces=forces,
        points=points,
        peak_parts=parts,
        travel=np.where(solved[:, None], far, np.nan),
    )


def _points(mounts: LineOnMounts, curve: IntArray, speed: FloatArray) -> LineOperatingPoints:
    """Return points by their curves and speeds, (S, n-2)."""
    rows = np.moveaxis(curve, -1, 0), np.moveaxis(speed, -1, 0)
    asked = demand_at_operating_points(
        mounts.inputs.demand, mounts.torque_curves, curve=rows[0], speed=rows[1]
    )
    return LineOperatingPoints(
        curves=mounts.torque_curves,
        curve_index=curve,
        speed=np.moveaxis(asked.speed, 0, -1),
        torque=np.moveaxis(asked.torque, 0, -1),
    )


def _sweeps(
    mounts: LineOnMounts,
    travel: OperatingPointResults,
    forces: OperatingPointResults,
    stop: FloatArray,
    states: BoolArray,
) -> _Sweeps | None:
    """Return the curves of `states` on which linear rubber comes to a stop; None without one."""
    between: dict[tuple[int, int], list[float]] = {}
    beyond = (np.nan_to_num(travel.results.peak) > NEAR_STOP_SHARE * stop).any(axis=-1)
    for p, s in np.argwhere(beyond & states).tolist():
        key = s, int(travel.curve_index[p, s])
        between.setdefault(key, []).append(float(travel.speed[p, s]))
    if not between:
        return None
    most = mounts.torque_curves.max_speed
    keys = sorted(between)
    low, high = SPEED_REACH
    fastest = np.array([most[c, s] for s, c in keys])
    reach = high * np.maximum(np.array([max(between[k]) for k in keys]), 1e-3 * fastest)
    return _Sweeps(
        state=np.array([s for s, _ in keys], dtype=int),
        curve=np.array([c for _, c in keys], dtype=int),
        low=np.array([low * min(between[k]) for k in keys]),
        high=np.minimum(reach, fastest),
        ends_with_curve=reach >= fastest,
        crests=np.array([_crests(forces, s, c) for s, c in keys]).reshape(len(keys), -1).T,
    )  # fmt: skip


def _crests(forces: OperatingPointResults, state: int, curve: int) -> list[float]:
    """Return the speeds at which each bearing's dynamic force is largest on a curve of a state."""
    own = forces.curve_index[:, state] == curve
    size = np.where(own[:, None], np.nan_to_num(forces.results.dynamic[:, state]), -1.0)
    return forces.speed[size.argmax(axis=0), state].tolist()


def _others(
    mounts: LineOnMounts, forces: OperatingPointResults, sweeps: _Sweeps
) -> dict[str, OperatingPointResults]:
    """Return the largest linear forces (S, n-2) at points off the sweeps, by kind."""
    off = ~sweeps.holds(forces.curve_index, forces.speed)

    def left(values: FloatArray) -> FloatArray:
        return np.where(off[..., None], values, np.nan)

    tried = OperatingPointResults(
        curves=forces.curves,
        curve_index=forces.curve_index,
        speed=np.where(off, forces.speed, np.nan),
        torque=np.where(off, forces.torque, np.nan),
        results=type(forces.results)(
            **{k: left(getattr(forces.results, k)) for k in FORCE_KINDS},
        ),
    )
    rows: PointRows = point_rows(*(largest_point(tried, kind) for kind in FORCE_KINDS))
    exact = mounts.bearing_forces_at_points(*rows)
    return {kind: largest_point(exact, kind) for kind in FORCE_KINDS}


def _waves(force: FloatArray) -> ComplexArray:
    """Return the amplitudes (..., B, K, 3) of components (..., M, 3 B)."""
    waves = force[..., 1::2, :] + 1j * force[..., 2::2, :]
    return np.moveaxis(waves.reshape(*waves.shape[:-1], -1, 3), -3, -2)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Grid:
    """A line on linear rubber at the speeds Q of sweeps C, in the bearings' directions.

    Attributes
    ----------
    sweeps
        Whose speeds they are.
    force : (Q, C, M, 3 B) N
        Weight included, without thrust.
    thrust : (V, Q, C, 3 B) N
        What thrust adds to its mean: none, pushed in, drawn out.
    order1 : (Q, C, B) N
    weight : (Q, C, 3 B) N
    on, coupling, speed, torque
        The line on its slowest modes in the states of the sweeps, (C), and at their points, (Q, C).
    compression : (V, Q, C) N
        Of the spline with those thrusts where it slides, and takes stiffness off; else 0.
    is_sliding : (V, C)
        Whether friction limits that, not the stroke.
    stiffness, loss : (C, B, 2) N/m, (Q, C, B) signed as the speed
    obstacles
        What stands next to it; None where nothing does.
    """

    sweeps: _Sweeps
    force: FloatArray
    thrust: FloatArray
    order1: FloatArray
    weight: FloatArray
    on: MountedLine
    coupling: ComplexArray
    speed: FloatArray
    torque: FloatArray
    compression: FloatArray
    is_sliding: BoolArray
    stiffness: FloatArray
    loss: FloatArray
    obstacles: ObstaclesAlongSweeps | None

    @classmethod
    def of(cls, mounts: LineOnMounts, sweeps: _Sweeps, held: MountedLine) -> "_Grid":
        """Return a line along its sweeps."""
        inputs = mounts.inputs
        quick = held.modal_reduction(inputs.line.rigid_body_mode_count)
        states = inputs.layout.directions.shape[-3]
        place = np.array([(sweeps.state[:k] == s).sum() for k, s in enumerate(sweeps.state)])
        depth, count = int(place.max()) + 1, SPEED_COUNT
        speed = np.full((count, depth, states), np.nan)
        curve = np.zeros((count, depth, states), dtype=int)
        speed[:, place, sweeps.state], curve[:, place, sweeps.state] = sweeps.speeds, sweeps.curve
        asked = demand_at_operating_points(
            inputs.demand,
            mounts.torque_curves,
            curve=curve.reshape(-1, states),
            speed=speed.reshape(-1, states),
        )
        laid, how = inputs.layout_for(asked), mounts.force_inputs(asked, inertia=True)
        found = bearing_forces(laid, inputs.line, inputs.phases, held=held, **how)
        weight, _ = bearing_forces_of_weight_and_thrust(laid, inputs.line, gravity=inputs.gravity)
        under = inputs.line.phases_under_torque(inputs.phases, how["torque"])
        turned = rotate_chain(
            laid.directions, phases=under, crosses=inputs.line.is_cross, samples=16
        )
        coupling = quick.order2_coupling(turned)

        def own(values: Any, own_axes: int) -> Any:
            """Return values (P, S, ...) of the sweeps, (Q, C, ...)."""
            rest = values.shape[values.ndim - own_axes :]
            values = np.broadcast_to(values, (count * depth, states, *rest))
            return values.reshape(count, depth, states, *rest)[:, place, sweeps.state]

        on = quick.select_states(sweeps.state.tolist())
        signed, torque = own(how["speed"], 0), own(how["torque"], 0)
        frame = np.broadcast_to(on.bearing_frame, (len(sweeps.state), *on.bearing_frame.shape[-3:]))

        def local(values: FloatArray) -> FloatArray:
            """Return vectors (..., C, B, 3) in the bearings' directions, (..., C, 3 B)."""
            turned = (frame @ values[..., None])[..., 0]
            return turned.reshape(*turned.shape[:-2], -1)

        waves = np.moveaxis(own(found.waves, 3), -2, 0)  # as time goes, not as the line turns
        waves = np.where(signed[..., None, None] < 0, np.conj(waves), waves)
        thrust = mounts.thrust_effect(asked)
        none = np.zeros_like(found.mean)
        effects, pressed = [none], [np.zeros_like(signed)]
        slides = [np.ones(len(sweeps.state), dtype=bool)]
        if thrust is not None:
            effects += [*thrust.force]
            slip = own(np.nan_to_num(inputs.spline_force_at(asked.torque)), 0)
            for each in thrust.thrust:
                P = -own(each, 1)
                limit = (1 - SLIDING_TOLERANCE) * slip[..., None]
                slides.append((np.abs(P) >= limit).all(axis=(0, -1)))
                pressed.append(slides[-1] * np.take_along_axis(
                    P, np.abs(P).argmax(axis=-1, keepdims=True), axis=-1)[..., 0])  # fmt: skip
        B = frame.shape[-3]
        size = (len(sweeps.state), B)
        return cls(
            sweeps=sweeps,
            force=components(
                local(own(found.mean, 2)), np.moveaxis(np.stack([local(w) for w in waves]), 0, -2)
            ),
            thrust=np.stack([local(own(e, 2)) for e in effects]),
            order1=own(found.order1, 1),
            weight=local(own(weight, 2)),
            on=on,
            coupling=own(coupling, 2),
            speed=signed,
            torque=torque,
            compression=np.stack(pressed),
            is_sliding=np.stack(slides),
            stiffness=np.broadcast_to(on.stiffness[..., :2], (*size, 2)),
            loss=np.sign(signed)[..., None] * np.broadcast_to(on.loss, size),
            obstacles=obstacles_along_sweeps(
                inputs, laid, travel=asked.travel, thrust=thrust, on=on, own=own
            )
            if inputs.obstacles
            else None,
        )

    def travel(self, of: IntArray, thrust: IntArray) -> FloatArray:
        """Return how far linear rubber goes in sweeps under a thrust each, (Q, C', M, 2 B) m."""
        force = self.force_of(of, thrust)
        force[..., 0, :] -= self.weight[:, of]
        across = force.reshape(*force.shape[:-1], -1, 3)[..., :2]
        moved = across / self.stiffness[of][:, None]
        eta = self.loss[:, of][..., None, :, None]
        real, imaginary = moved[..., 1::2, :, :].copy(), moved[..., 2::2, :, :].copy()
        scale = 1 / (1 + eta**2)
        moved[..., 1::2, :, :] = scale * (real + eta * imaginary)
        moved[..., 2::2, :, :] = scale * (imaginary - eta * real)
        return moved.reshape(*moved.shape[:-2], -1)

    def force_of(self, of: IntArray, thrust: IntArray) -> FloatArray:
        """Return the linear forces of sweeps under a thrust each, (Q, C', M, 3 B) N."""
        force = self.force[:, of].copy()
        force[..., 0, :] += self.thrust[thrust, :, of].swapaxes(0, 1)
        return force

    def cases(self) -> tuple[IntArray, IntArray]:
        """Return sweeps and thrusts to be followed: what moves or loads each bearing most.

        They differ, as weight is in the force and not in the travel.
        """
        sweeps, kinds = len(self.sweeps.state), len(self.thrust)
        every, thrusts = (v.ravel() for v in np.indices((sweeps, kinds)))
        found: set[tuple[int, int]] = set()
        for mean, axes in ((self.travel(every, thrusts), 2), (self.force_of(every, thrusts), 3)):
            still = mean[..., 0, :]
            far = np.linalg.norm(still.reshape(*still.shape[:-1], -1, axes)[..., :2], axis=-1)
            worst = far.max(axis=0).reshape(sweeps, kinds, -1).argmax(axis=1)
            found |= {(c, int(v)) for c in range(sweeps) for v in worst[c]}
        of, thrust = np.array(sorted(found)).T
        return of, thrust

    def is_thrust_unsettled(self, of: IntArray, thrust: IntArray, stop: FloatArray) -> BoolArray:
        """Return in which cases thrust that the stroke limits takes the mean beyond a stop, (C',).

        The stop then holds the bow that takes up the stroke, and with it the thrust.
        """
        still = self.travel(of, thrust)[..., 0, :]
        far = np.linalg.norm(still.reshape(*still.shape[:-1], -1, 2), axis=-1)
        return ~self.is_sliding[thrust, of] & (far > stop).any(axis=(0, -1))

    def line(
        self, of: IntArray, thrust: IntArray, stop: FloatArray, ratios: FloatArray
    ) -> StoppedLine:
        """Return cases of the sweeps with their stops and a ratio (C', B) each."""
        return StoppedLine(
            free=self.travel(of, thrust),
            receptance=self.receptance(of, thrust),
            stiffness=self.stiffness[of],
            stop=np.broadcast_to(stop, (len(of), self.stiffness.shape[-2])),
            ratio=ratios,
        )

    def receptance(self, of: IntArray, thrust: IntArray) -> StopReceptance:
        """Return what a stop's forces move in cases of the sweeps."""
        each, own = np.unique(np.stack([of, thrust]), axis=1, return_inverse=True)
        return StopReceptance(
            tied=tied_receptance(
                self.on.select_states(each[0].tolist()),
                self.coupling[:, each[0]],
                speed=self.speed[:, each[0]],
                torque=self.torque[:, each[0]],
                compression=self.compression[each[1], :, each[0]].T,
            ),
            alone=receptance_alone(self.on, speed=self.speed, torque=self.torque),
            tied_of=own.reshape(-1),
            alone_of=of,
        )

    def sizes(
        self, line: StoppedLine, motion: StoppedMotion, of: IntArray, thrust: IntArray
    ) -> dict[str, FloatArray]:
        """Return sizes of forces and travel of motions, (T, C', B), by kind; -inf where none."""
        there = np.nonzero(~np.isnan(motion.place))
        far = largest_travel(motion.travel[there])
        stops = (far > line.stop[there[1]]).any(axis=-1)
        sizes = {kind: np.empty_like(far) for kind in FORCE_KINDS} | {"travel": far}
        linear = self.force_of(of, thrust)
        for which in (w for w in (stops, ~stops) if w.any()):
            place, case = motion.place[there][which], there[1][which]
            force = at_places(linear, place, case)
            if which is stops:
                found = forces_at_stop(
                    motion.travel[there][which],
                    at_places(line.free, place, case),
                    force,
                    stiffness=line.stiffness[case],
                    loss=self.loss[-1, of[case]],
                    stop=line.stop[case],
                    ratio=line.ratio[case],
                )
                static, dynamic = found.static, found.dynamic
            else:  # orders add up as they do elsewhere
                mean = force[:, 0].reshape(*far[which].shape, 3)
                static = np.linalg.norm(mean, axis=-1)
                dynamic = semi_major_axis(_waves(force)).sum(-1)
            sizes["static"][which], sizes["dynamic"][which] = static, dynamic
            sizes["peak"][which] = static + dynamic + at_places(self.order1, place, of[case])
        whole: dict[str, FloatArray] = {}
        for kind, values in sizes.items():
            whole[kind] = np.full((*motion.place.shape, values.shape[-1]), -np.inf)
            whole[kind][there] = values
        return whole

    def cases_of_reach(self, ratios: int) -> IntArray:
        """Return sweeps, thrusts and ratios (3, C) with which shafts may reach into obstacles.

        Thrust is in how far the line lies from these, and moves it as on linear rubber.
        """
        count = 0 if self.obstacles is None else ratios
        ratio, sweep = (v.ravel() for v in np.indices((count, len(self.sweeps.state))))
        return np.stack([sweep, 0 * sweep, ratio])

    def reach(self, motion: StoppedMotion, of: IntArray, *, states: int) -> FloatArray:
        """Return how far shafts reach into obstacles in states at most, (S, A) m.

        In motions of `cases_of_reach`, of sweeps (C',); -inf where none is found.
        """
        if self.obstacles is None:
            return np.empty((states, 0))
        there = np.nonzero(~np.isnan(motion.place))
        own = of[there[1]]
        found = self.obstacles.reach(motion.travel[there], motion.place[there], own)
        most = np.full((states, found.shape[-1]), -np.inf)
        np.maximum.at(most, self.sweeps.state[own], found)
        return most
