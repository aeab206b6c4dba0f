"""What torque, speed and geometry a line has together: its operating points, state by state.

Torque and speed that cannot occur together prove nothing, and angles belong to a torque: the
axle winds up under it. `curves` says what torque each gear and direction has over the line's
speed in each state; `demand_at_operating_points` lays the line out at points of them.

Points come first, then curves where there are all of them, then the variants of a study, and
the states last: so the numbers of a line, which come as (V, 1), broadcast with all of it.
"""

from collections.abc import Iterator
from dataclasses import field
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np

from cardan.core.arrays import (
    ArrayLike,
    BoolArray,
    FloatArray,
    IntArray,
    broadcastable_axis_indices,
    collapse_broadcast_axes,
    stack_on_last_axis,
)
from cardan.core.compiled import POINT_LOOP_CASE_FACTOR, is_compiled_batch
from cardan.core.labels import OperatingPoint
from cardan.core.lazy_dataclass import dataclass
from cardan.physics.vehicle.axle_motion import AxleMotion
from cardan.physics.vehicle.compiled_torque import TorqueKernel, torque_kernel
from cardan.physics.vehicle.resolved_line import LineWithResolvedReferences
from cardan.physics.vehicle.state_demand import (
    LineStateDemand,
    axle_housing_torque,
    axle_motion_under_torque,
    demand_with_axle_moved_by_torque,
)
from cardan.physics.vehicle.state_torques import speed_stated_by_application
from cardan.physics.vehicle.torque import (
    GearTable,
    largest_torque_from_standstill,
    retarding_torques,
)

DriveMode: TypeAlias = Literal["drive", "coast", "reverse", "brake"]
"""The engine drives ahead or is driven; it drives astern; the brakes hold while it is driven."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TorqueCurves:
    """Torque over speed that a line can have in each state, a curve for each gear and direction.

    C curves of E corners in S states; the dots are the variants of a study.

    Attributes
    ----------
    gears : C
        "1", "2", ..., "low 1", ..., "R", "low R"; "" where no gear says the torque.
    directions : C
        What turns the line, and which way.
    speed : (C, ..., S, E) rad/s
        Size, from 0; it never falls, and repeats where a curve has fewer corners than others.
    torque : (C, ..., S, E) N m
        Above 0 in drive, below in overrun, braking and reverse; straight between corners, its
        size never rising. What the tyres hold is not in it.
    torque_limit : (C, ..., S) N m
        Size of torque that the tyres hold there; inf where unknown, or it is no matter.
    max_speed : (C, ..., S) rad/s
        Where the curve ends in a state; nan where that state has no such points.
    """

    gears: tuple[str, ...]
    directions: tuple[DriveMode, ...]
    speed: FloatArray
    torque: FloatArray
    torque_limit: FloatArray
    max_speed: FloatArray

    def torque_at(self, speed: ArrayLike) -> FloatArray:
        """Return the torque at speeds (Q, C, ..., S) rad/s, N m; nan where a curve has none."""
        return _torque(np.asarray(speed, dtype=float), *self._all)

    def curves_to_draw(self, state: int) -> list[int]:
        """Return the curves (C, S) to draw of a state: those that drive it, or else brake it."""
        moves = np.flatnonzero(self.max_speed[:, state] > 0).tolist()
        drives = [k for k in moves if self.directions[k] in ("drive", "reverse")]
        return drives or [k for k in moves if self.directions[k] == "brake"]

    def select(self, which: IntArray) -> "TorqueCurves":
        """Return some of the curves."""
        return TorqueCurves(
            gears=tuple(self.gears[k] for k in which.tolist()),
            directions=tuple(self.directions[k] for k in which.tolist()),
            speed=self.speed[which],
            torque=self.torque[which],
            torque_limit=self.torque_limit[which],
            max_speed=self.max_speed[which],
        )

    @property
    def _all(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        return self.speed, self.torque, self.torque_limit, self.max_speed

    @cached_property
    def corner_speeds(self) -> FloatArray:
        """Speeds (Q, C, ..., S) rad/s where a curve starts, bends or ends; rising.

        A curve bends where its line does and where it meets what the tyres hold. Between
        neighbours it is straight, so no torque is larger than at its corners. nan fills up.
        """
        x, size, most, end = (
            self.speed,
            np.abs(self.torque),
            self.torque_limit[..., None],
            self.max_speed,
        )
        flat = np.diff(size, axis=-1) == 0
        bends = np.zeros(x.shape, dtype=bool)
        bends[..., 1:-1] = ~(flat[..., :-1] & flat[..., 1:]) & (size[..., 1:-1] <= most)
        before, after = size[..., :-1], size[..., 1:]
        meets = (before > most) & (after < most)  # a size never rises with speed
        share = (before - most) / np.where(meets, before - after, 1.0)
        meeting = x[..., :-1] + np.where(meets, share, 0.0) * np.diff(x, axis=-1)
        found = np.concatenate(
            [np.where(bends, x, np.nan), np.where(meets, meeting, np.nan),
             np.zeros_like(end)[..., None], end[..., None]], axis=-1,
        )  # fmt: skip
        found = np.sort(np.where(found <= end[..., None], found, np.nan), axis=-1)
        again = np.diff(found, axis=-1) == 0
        found = np.sort(np.where(np.insert(again, 0, False, axis=-1), np.nan, found), axis=-1)
        some = ~np.isnan(found).all(axis=tuple(range(found.ndim - 1)))
        return np.moveaxis(found[..., some], -1, 0)

    def points_at(self, speed: ArrayLike) -> tuple[IntArray, FloatArray]:
        """Return the points that speeds (Q, C, ..., S) make, in one row.

        Which curve each is on, (P,), and its speed (P, ..., S); where no state has the
        point it is left out, and where some has not its speed is nan there.
        """
        x = np.asarray(speed, dtype=float)
        x = np.where((x >= 0) & (x <= self.max_speed), x, np.nan)
        some = ~np.isnan(x).all(axis=tuple(range(2, x.ndim)))
        _, curve = np.nonzero(some)
        return curve, x[some]


@dataclass(frozen=True, kw_only=True, eq=False)
class LineOperatingPoints:
    """Points of a line's curves.

    P points (P, ..., S), or the worst one of each part (..., S, parts).

    Attributes
    ----------
    curves, curve_index
        The curves, and which of them each point is on.
    speed, torque : rad/s, N m
        nan where a curve has no such point.
    is_spline_stuck
        Where friction holds the line's spline; None is nowhere.
    """

    curves: TorqueCurves
    curve_index: IntArray
    speed: FloatArray
    torque: FloatArray
    is_spline_stuck: BoolArray | None = None

    @property
    def sense(self) -> FloatArray:
        """-1 where the line turns backwards, else 1."""
        return np.where(self.is_mode("reverse"), -1.0, 1.0)

    def is_mode(self, direction: DriveMode) -> BoolArray:
        """Return where the line is turned in a direction."""
        return np.array([d == direction for d in self.curves.directions])[self.curve_index]

    def describe(self, case: tuple[int, ...]) -> str:
        """Return one of them in words, for errors."""
        k = int(self.curve_index[case])
        gear = f" in gear {self.curves.gears[k]}" if self.curves.gears[k] else ""
        return f"{self.curves.directions[k]}{gear} with {self.torque[case]:.4g} N m"

    def operating_point(self, at: tuple[int, ...]) -> OperatingPoint | None:
        """Return one of them; None where there is none."""
        curve, speed, torque = (
            int(self.curve_index[at]),
            float(self.speed[at]),
            float(self.torque[at]),
        )
        if np.isnan(torque):
            return None
        return OperatingPoint(
            self.curves.gears[curve],
            self.curves.directions[curve],
            speed,
            torque,
            is_spline_stuck=self.is_spline_stuck is not None and bool(self.is_spline_stuck[at]),
        )

    @property
    def first_variant(self) -> "LineOperatingPoints":
        """The points (P, S) of the first variant, where there is an axis of them."""
        return LineOperatingPoints(
            curves=self.curves,
            curve_index=self.curve_index[:, 0],
            speed=self.speed[:, 0],
            torque=self.torque[:, 0],
        )

    def points_of_parts(self, which: IntArray) -> "LineOperatingPoints":
        """Return which point (..., S, parts) each part has; below 0 none."""
        here = (np.maximum(which, 0), *broadcastable_axis_indices(which.shape)[:-1])
        cases = len(self.speed), *which.shape[:-1]
        of = [np.broadcast_to(v, cases)[here] for v in (self.speed, self.torque)]
        return LineOperatingPoints(
            curves=self.curves,
            curve_index=np.broadcast_to(self.curve_index, cases)[here],
            speed=of[0],
            torque=np.where(which < 0, np.nan, of[1]),
        )


def operating_points_on_curves(
    found: TorqueCurves, *, curve: ArrayLike, speed: ArrayLike
) -> LineOperatingPoints:
    """Return points of curves, by which curve each is on, (P,) or (P, ..., S), and its speed."""
    speed = np.asarray(speed, dtype=float)
    speed = np.broadcast_to(speed, np.broadcast_shapes(speed.shape, found.max_speed.shape[1:]))
    curve = np.asarray(curve)
    curve = np.broadcast_to(
        curve.reshape(*curve.shape, *(1,) * (speed.ndim - curve.ndim)), speed.shape
    )

    each = (found.speed, found.torque, found.torque_limit, found.max_speed)
    # Of points, variants and states: points of one design are too few to load a compiler for.
    many = speed.ndim == 3 and is_compiled_batch(speed.shape[1:], points=POINT_LOOP_CASE_FACTOR)
    kernel = torque_kernel() if many else None
    if kernel is None:
        here = curve, *broadcastable_axis_indices(curve.shape)[1:]
        torque = _torque(speed, *(_taken(v, here) for v in each))
    else:
        torque = _torque_by_loop(kernel, curve, speed, each)
    speed = np.where(np.isnan(torque), np.nan, speed)
    return LineOperatingPoints(curves=found, curve_index=curve, speed=speed, torque=torque)


def demand_at_operating_points(
    asked: LineStateDemand, found: TorqueCurves, *, curve: ArrayLike, speed: ArrayLike
) -> LineStateDemand:
    """Return what a line has to bear at points of its curves, (P, ..., S).

    Parameters
    ----------
    asked
        The line in its states, whose curves they are.
    found
        `curves` of it.
    curve : (P,) or (P, ..., S)
        Which curve each point is on.
    speed : (P, ..., S) rad/s
        How fast the line turns there. Where a curve has no such speed there is no point:
        torque and speed are nan, and the layout is that of the state.
    """
    at = operating_points_on_curves(found, curve=curve, speed=speed)
    return demand_with_axle_moved_by_torque(
        asked, torque=at.torque, speed=at.speed, sense=at.sense,
        coasts=at.is_mode("coast"), brakes=at.is_mode("brake"), named=at.describe,
    )  # fmt: skip


def axle_motion_at_points(asked: LineStateDemand, at: LineOperatingPoints) -> AxleMotion:
    """Return how the axle rides at points of a line's curves, (P, ..., S)."""
    return axle_motion_under_torque(
        asked, at.torque, coasts=at.is_mode("coast"), brakes=at.is_mode("brake")
    )


def housing_torque_at_points(asked: LineStateDemand, at: LineOperatingPoints) -> FloatArray:
    """Return the torque on the axle's housing there, (P, ..., S) N m; 0 where it is unknown."""
    brakes, coasts = at.is_mode("brake"), at.is_mode("coast")
    return np.nan_to_num(axle_housing_torque(asked, at.torque, coasts=coasts, brakes=brakes))


def _torque(
    x: FloatArray, speed: FloatArray, torque: FloatArray, most: FloatArray, fastest: FloatArray
) -> FloatArray:
    """Torque at speeds (..., S) of curves (..., S, E); nan where they have none."""
    speed, torque, most, fastest = (
        collapse_broadcast_axes(v) for v in (speed, torque, most, fastest)
    )
    there = torque[..., 0]
    for k in range(speed.shape[-1] - 1):
        start, end = speed[..., k], speed[..., k + 1]
        wide, rise = end > start, torque[..., k + 1] - torque[..., k]
        slope = np.where(wide, rise / np.where(wide, end - start, 1.0), 0.0)
        if slope.any():
            there = there + slope * (np.minimum(np.maximum(x, start), end) - start)
        jump = np.where(wide, 0.0, rise)
        if jump.any():
            there = there + np.where(x >= start, jump, 0.0)
    held = np.copysign(np.minimum(np.abs(there), most), there)
    return np.where((x >= 0) & (x <= fastest), held, np.nan)


def _torque_by_loop(
    kernel: TorqueKernel, curve: IntArray, x: FloatArray, each: tuple[FloatArray, ...]
) -> FloatArray:
    """Return `_torque` of a compiled loop at points (P, V, S): of curves, not of their corners."""

    def table(values: FloatArray, own: int) -> FloatArray:
        """Return a number of each curve, variant and state, or 1 where all have one, and corner."""
        cases = values.strides[1 : values.ndim - own]
        first = tuple(slice(None) if step else slice(1) for step in cases)
        values = np.ascontiguousarray(values[:, *first])
        return values.reshape(len(values), *(1,) * (2 - len(cases)), *values.shape[1:])

    found = np.empty(x.shape)
    kernel(
        *(np.ascontiguousarray(v) for v in (curve, x)), *(table(v, 1) for v in each[:2]),
        *(table(v, 0) for v in each[2:]), found,
    )  # fmt: skip
    return found


def _taken(values: FloatArray, here: tuple[IntArray, ...]) -> FloatArray:
    """Return values (C, ..., S) or corners (C, ..., S, E) at points; each corner by itself."""
    if values.ndim == len(here):
        return values[here]
    return stack_on_last_axis(values[..., k][here] for k in range(values.shape[-1]))


# --------------------------------------------------------------------------- curves


@dataclass(frozen=True, kw_only=True)
class _Curve:
    """One curve, of shapes that `curves` makes alike: (..., S or 1, E) and (..., S)."""

    gear: str
    direction: DriveMode
    speed: FloatArray
    torque: FloatArray
    most: FloatArray = field(default_factory=lambda: np.asarray(np.inf))
    fastest: FloatArray


def torque_curves(asked: LineStateDemand) -> TorqueCurves:
    """Return the torque over speed that a line can have in each state.

    In drive and reverse each gear gives its largest torque from standstill, a clutch slipping
    or a converter stalled, then what full load gives up to governed speed; in overrun and
    braking it holds with engine brake and retarder, as much at any speed that the gear
    reaches; tyres hold no more than their grip.
    What a state or the application says replaces it: a torque that of all gears in drive, a
    overrun torque that in overrun, and no point is faster than a speed said. A wind-up state has
    drive, a brake wind-up state braking alone; others all that is known, braking where the
    suspension's `brake_torque` is given.

    Notes
    -----
    A converter's stall ratio counts at any speed, and overrun and braking take the engine
    brake's largest torque at any speed of a gear: upper bounds. Without a known speed
    the line stands still. Part load is not evaluated. Derived from Souza (2014), eq. 1 to 3.
    """
    found = [c for c in (*_drive(asked), *_coast(asked), *_reverse(asked), *_brake(asked))
             if not np.isnan(c.fastest).all()]  # fmt: skip
    cases = np.broadcast_shapes(
        asked.torque.shape,
        *(s for c in found for s in (c.speed.shape[:-1], c.torque.shape[:-1], c.fastest.shape)),
    )
    most = max((c.speed.shape[-1] for c in found), default=2)

    def alike(values: list[FloatArray], *shape: int) -> FloatArray:
        filled = [v if not shape else _filled(v, *shape) for v in values]
        each = [np.broadcast_to(v, (*cases, *shape)) for v in filled]
        return np.stack(each) if each else np.zeros((0, *cases, *shape))

    return TorqueCurves(
        gears=tuple(c.gear for c in found),
        directions=tuple(c.direction for c in found),
        speed=alike([c.speed for c in found], most),
        torque=alike([c.torque for c in found], most),
        torque_limit=alike([np.where(np.isnan(c.most), np.inf, c.most) for c in found]),
        max_speed=alike([c.fastest for c in found]),
    )


def _filled(values: FloatArray, size: int) -> FloatArray:
    """Return corners (..., E) with the last repeated to (..., size)."""
    last = np.repeat(values[..., -1:], size - values.shape[-1], axis=-1)
    return np.concatenate([values, last], axis=-1)


def _driven(asked: LineStateDemand) -> BoolArray:
    """Where the axle is not wound up by definition, (S,)."""
    line = asked.static_state.line
    return ~(line.in_suspension_state("windup") | line.in_suspension_state("windup brake"))


def _level(
    asked: LineStateDemand, direction: DriveMode, torque: FloatArray, *, there: BoolArray
) -> Iterator[_Curve]:
    """Yield the curve of one torque (..., S) N m from standstill to the line's speed."""
    end = np.where(there & ~np.isnan(torque), np.nan_to_num(asked.speed), np.nan)
    reach = np.nan_to_num(asked.speed)
    yield _Curve(
        gear="",
        direction=direction,
        speed=np.stack([np.zeros_like(reach), reach], axis=-1),
        torque=np.stack([torque, torque], axis=-1),
        fastest=end,
    )


def _geared(
    asked: LineStateDemand,
    direction: DriveMode,
    gears: GearTable,
    torque: FloatArray,
    speed: FloatArray,
    *,
    most: FloatArray,
    there: BoolArray,
) -> Iterator[_Curve]:
    """Yield a curve for each gear from its corners (..., G, E), at most as fast as is said.

    What is said may be faster than the engine turns in its fastest gear, downhill: its brake
    holds as much there.
    """
    said, reach = speed_stated_by_application(asked.static_state.line), speed[..., -1]
    for g, name in enumerate(gears.names):
        end = np.fmin(reach[..., g], said)
        at, gives = (_beside_states(v[..., g, :]) for v in (speed, torque))
        rolls = (reach[..., g] == reach.max(-1)) & (said > reach[..., g])
        if rolls.any() and direction in ("coast", "brake"):
            end = np.where(rolls, said, end)
            at = _followed(at, np.where(rolls, said, reach[..., g]))
            gives = _followed(gives, np.broadcast_to(gives[..., -1], rolls.shape))
        yield _Curve(
            gear=name, direction=direction, speed=at, torque=gives, most=most,
            fastest=np.where(there, end, np.nan),
        )  # fmt: skip


def _followed(corners: FloatArray, by: FloatArray) -> FloatArray:
    """Return corners (..., S or 1, E) with one more of each state (..., S), (..., S, E + 1)."""
    before = np.broadcast_to(corners, (*by.shape, corners.shape[-1]))
    return np.concatenate([before, by[..., None]], axis=-1)


def _beside_states(values: FloatArray) -> FloatArray:
    """Corners (E,), or (V, 1, E) of variants, as (..., 1, E): alike in every state."""
    return values[None] if values.ndim == 1 else values


def _drive(asked: LineStateDemand) -> Iterator[_Curve]:
    line = asked.static_state.line
    there = ~line.in_suspension_state("windup brake")
    said = np.array([(s.torque is not None) or (line.torque is not None) for s in line.states])
    if line.gears is None:
        yield from _level(asked, "drive", asked.torque, there=there)
        return
    if said.any():
        yield from _level(asked, "drive", asked.torque, there=there & said)
    speed, torque = largest_torque_from_standstill(line.gears.speed, line.gears.torque)
    yield from _geared(
        asked, "drive", line.gears, torque, speed, most=asked.slip_torque, there=there & ~said
    )
    rolls = there & ~said & (speed_stated_by_application(line) > speed[..., -1].max(-1))
    if rolls.any():  # faster than any gear drives it the line rolls without torque
        yield from _level(asked, "drive", 0.0 * asked.torque, there=rolls)


def _coast(asked: LineStateDemand) -> Iterator[_Curve]:
    there = _driven(asked)
    if (held := _held_back(asked.static_state.line)) is None:
        yield from _level(asked, "coast", 0.0 - asked.coast_torque, there=there)
    elif not np.isnan(held[1]).any():
        yield from _geared(
            asked, "coast", *held, most=asked.static_state.slip_torque_coast, there=there
        )


def _held_back(line: LineWithResolvedReferences) -> tuple[GearTable, FloatArray, FloatArray] | None:
    """Return gears, torques and speeds (..., G, 2) at which each holds a line back.

    None if an overrun torque is given, or the gears are unknown.
    """
    if line.engine is None or line.gears is None or line.coast_torque is not None:
        return None
    held = np.asarray(line.max_torque_share)[..., None] * retarding_torques(
        line.engine, line.gearbox
    )
    both = np.broadcast_arrays(held, line.gears.speed.max(-1))
    torque, reach = (np.stack([v, v], axis=-1) for v in both)
    return line.gears, 0.0 - torque, reach * (0.0, 1.0)


def _reverse(asked: LineStateDemand) -> Iterator[_Curve]:
    line = asked.static_state.line
    if line.reverse_gears is None:
        return
    speed, torque = largest_torque_from_standstill(
        line.reverse_gears.speed, line.reverse_gears.torque
    )
    yield from _geared(
        asked, "reverse", line.reverse_gears, 0.0 - torque, speed,
        most=asked.static_state.slip_torque_reverse, there=_driven(asked),
    )  # fmt: skip


def _brake(asked: LineStateDemand) -> Iterator[_Curve]:
    line = asked.static_state.line
    wound = line.in_suspension_state("windup brake")
    given = np.asarray(line.suspension.brake_torque if line.suspension else 0.0) > 0
    there = wound | (given & ~line.in_suspension_state("windup"))
    coasting = np.nan_to_num(np.where(wound, asked.torque, 0.0 - asked.coast_torque))
    held = _held_back(line)
    if held is None or np.isnan(held[1]).any():
        yield from _level(asked, "brake", coasting, there=there)
        return
    said = wound & np.array([s.torque is not None for s in line.states])
    if said.any():
        yield from _level(asked, "brake", coasting, there=there & said)
    yield from _geared(asked, "brake", *held, most=np.abs(coasting), there=there & ~said)
