"""A line's bearings at many points, nearly: where a force is largest is sought on this.

Points of one state differ in torque and speed, and the torque moves the axle. What follows
from angles alone, how one newton metre pushes the coordinates, how that follows their motion and
what statics makes of it, is smooth in that: a parabola through three rides of the axle. What
is left to do at a point is the algebra of a few coordinates (`cardan.loads.shaken`).

Left out is the shafts' inertia, whose share is small where resonance is.
"""

from collections.abc import Iterator, Sequence
from math import prod
from typing import Any, TypeAlias

import numpy as np

from cardan.base.arrays import ArrayLike, BoolArray, ComplexArray, FloatArray, steps
from cardan.base.frozen import dataclass
from cardan.base.small import (
    CACHED,
    Stretch,
    leading,
    packed,
    product,
    solve,
    stretch,
    stretches,
    trailing,
    wide,
)
from cardan.kinematics.chain import turn
from cardan.loads.cycle import major_axis
from cardan.loads.rubber import Suspended
from cardan.loads.running import out_of_balance
from cardan.loads.statics import loads, resting
from cardan.model.layout import Layout
from cardan.model.parts import Line

_ALONG = ((-1.0, 0.0), (0.0, 0.0), (1.0, 0.0))
_BESIDE = ((0.0, -1.0), (0.0, 1.0), (1.0, 1.0))

_Bent: TypeAlias = tuple[Any, ...]
"""Coefficients of 1, x, x², y, y² and xy of what follows a ride (x, y): the first three if an axle
goes straight, the first alone if nothing moves it. Components first, the cases (..., S) last."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Sizes:
    """Sizes of what `Running` has of the centre bearings, (..., n-2): forces in N, or m."""

    static: FloatArray
    dynamic: FloatArray
    peak: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Reach:
    """How far shafts reach into what they face, (..., R) m: below 0 there is room."""

    reach: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Rides:
    """Where an axle rides at some points: by the torque on it, and how high its springs have it.

    Attributes
    ----------
    least, largest : (..., S) N m
        Torques on the axle.
    lowest, highest : (..., S) m
        Its travel under these; between them it goes nearly straight.
    away : (..., S) m
        How far it goes off that at most.
    moves
        Whether it rides in more ways than one.
    """

    least: FloatArray
    largest: FloatArray
    lowest: FloatArray
    highest: FloatArray
    away: FloatArray
    moves: bool

    @property
    def nodes(self) -> tuple[tuple[float, float], ...]:
        """Rides (x, y), -1 to 1, at which the line's angles are asked."""
        if not self.moves:
            return _ALONG[1:2]
        return (*_ALONG, *_BESIDE) if self.away.any() else _ALONG

    def ridden(self, x: float, y: float) -> tuple[FloatArray, FloatArray]:
        """Return the torque on the axle and its travel of a ride, (..., S) N m, m."""
        torque, travel = (
            (a + b) / 2 + x * (b - a) / 2
            for a, b in ((self.least, self.largest), (self.lowest, self.highest))
        )
        return torque, travel + y * self.away

    def of(self, on_axle: ArrayLike, travel: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return the rides (x, y) of torques on the axle and travels, (P, ..., S) N m, m."""
        half = (self.largest - self.least) / 2
        x = (np.asarray(on_axle) - (self.largest + self.least) / 2) / np.where(half > 0, half, 1.0)
        line = (self.lowest + self.highest) / 2 + x * (self.highest - self.lowest) / 2
        return x, (np.asarray(travel) - line) / np.where(self.away > 0, self.away, 1.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Facing:
    """Where shafts may hit something: R places that face it.

    Attributes
    ----------
    free : (rides, ..., S, R) m
        Distance there at each of the nodes of `Rides`.
    nearer : (..., S, R, n-1, 2, 3)
        How much nearer it comes for each metre of the ends of the shafts.
    """

    free: FloatArray
    nearer: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Sketch:
    """A line on its rubber at all rides of its axle; N coordinates, B = 3 (n-2) directions.

    Attributes
    ----------
    on
        How it can move.
    rides
        Where the axle is.
    pushes : (N, ...) N
        What orders 0 and 2 of 1 N m do on the coordinates.
    swing : (N, N, ...)
        How order 2 of that follows the coordinates.
    borne : (B, ...) N
        Orders 0 and 2 of 1 N m on the bearings, less what the coordinates take at rest.
    twisted
        What order 2 of the three, in this order, gains for each N m more: it twists the shafts.
    weight, pulled : (B, ...) N
        On the bearings, of weight and of 1 N of thrust.
    rows : (B, N, ...)
        Motion in the bearings' directions.
    springs, loss : (B, ...) N/m, 1
    gives : (B, ...) m/N
        Of the rubber across the shafts; 0 along them.
    turning : (N, 2 (n-1), ...) N s²
        What unbalance of each end does on the coordinates at 1 rad/s; None leaves it out.
    free : (R, ...) m
        How far off is what shafts face.
    nearer : (R, N, ...)
        How much nearer the coordinates bring it.
    drawn : (R, ...) m
        How much nearer 1 N of thrust does.
    """

    on: Suspended
    rides: Rides
    pushes: tuple[_Bent, _Bent]
    swing: _Bent
    borne: tuple[_Bent, _Bent]
    twisted: tuple[_Bent, _Bent, _Bent]
    weight: _Bent
    pulled: _Bent
    rows: FloatArray
    springs: FloatArray
    loss: FloatArray
    gives: FloatArray
    turning: ComplexArray | None
    free: _Bent
    nearer: FloatArray
    drawn: _Bent

    def at(
        self,
        torque: ArrayLike,
        *,
        speed: ArrayLike,
        on_axle: ArrayLike,
        travel: ArrayLike,
        slip: ArrayLike,
        gives: bool = False,
    ) -> tuple[Sizes, Reach]:
        """Return what the bearings carry at points (P, ..., S), and how far shafts reach.

        Parameters
        ----------
        torque, speed, on_axle, travel : (P, ..., S) N m, rad/s, N m, m
            Where a torque is nan there is no point, and no force.
        slip : (P, ..., S) N
            Thrust at which the sliding fit slips; nan where nobody knows, and none counts.
        gives
            Return how far rubber gives across the shafts, in m for N, weight apart.
        """
        there = ~np.isnan(torque)
        ride = self.rides.of(on_axle, travel)
        given = np.broadcast_arrays(*(np.nan_to_num(v) for v in (torque, speed, *ride, slip)))
        cases = given[0].shape
        if len(cases) != 3 or prod(cases) <= CACHED:
            sizes = np.empty((self._told, *cases))
            for some in stretches(cases):
                stretch(sizes, some)[...] = self._some(
                    some, *(stretch(v, some) for v in given), gives=gives
                )
        else:
            sizes = self._packed(np.broadcast_to(there, cases), given, gives=gives)
        sizes = np.moveaxis(sizes + np.where(there, 0.0, np.nan), 0, -1)
        bearings = len(self.rows) // 3
        static, dynamic, peak, reach = np.split(sizes, np.arange(1, 4) * bearings, axis=-1)
        return Sizes(static=static, dynamic=dynamic, peak=peak), Reach(reach=reach)

    @property
    def order_2(self) -> Iterator[tuple[_Bent, _Bent]]:
        """Order 2 of pushes, swing and what is borne; each without torque, and what it gains."""
        return zip((self.pushes[1], self.swing, self.borne[1]), self.twisted, strict=True)

    @property
    def _told(self) -> int:
        """How many sizes there are: three of each bearing, one of each place that faces what."""
        return len(self.rows) + len(self.nearer)

    def _packed(self, there: BoolArray, given: Sequence[FloatArray], *, gives: bool) -> FloatArray:
        """Return sizes (X, P, V, S), state by state: one has many points, another few."""
        packs, counts, place = packed(there, *given)
        packs = [np.ascontiguousarray(np.moveaxis(v, -1, 0)) for v in packs]
        found = np.zeros((self._told, *packs[0].shape))
        for state, count in enumerate(counts.tolist()):
            step = max(1, CACHED // max(count, 1))
            for start in range(0, there.shape[1], step) if count else ():
                some = slice(start, start + step)
                each = (v[state, :count, some, None] for v in packs)
                found[:, state, :count, some] = self._some(
                    (some, slice(state, state + 1)), *each, gives=gives
                )[..., 0]
        _, variant, state = steps(there.shape)
        return found[:, state, place, variant]

    def passed(
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
            As `at` has them, at each instant.
        """
        ride = self.rides.of(on_axle, travel)

        def bent(values: _Bent) -> Any:
            return _at_ride([v[..., None] for v in values], *ride)

        wave = np.exp(2j * turned)
        f0, r0 = (torque * bent(v[0]) for v in (self.pushes, self.borne))
        f2, swing, r2 = (
            torque * (bent(still) + torque * bent(more)) for still, more in self.order_2
        )
        on, N = self.on, len(f0)
        squares, shapes, decay = on.decaying(0.0)
        modal = on.mass @ shapes
        K = trailing(on.first.some(slice(None), 1).wound(torque) - (swing * wave).real, of=2)
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
        pulled = self.springs[:, None] * (self.rows[:, None, :] * give).sum(-1)
        mean = r0 + (r2 * wave).real + bent(self.weight) + pulled
        drawn = slip * bent(self.pulled)
        return np.maximum.reduce([_size(mean + k * drawn) for k in (0.0, 1.0, -1.0)]).T

    def _some(
        self, some: Stretch, T: Any, omega: Any, x: Any, y: Any, slip: Any, *, gives: bool
    ) -> FloatArray:
        """Return mean, orders, peak and reach (X, P, ...) N, or m, of a stretch of the cases."""

        def own(values: Any, of: int) -> Any:
            return stretch(wide(values, T.ndim, of=of), some)

        def bent(values: _Bent, of: int = 1) -> Any:
            return _at_ride([own(v, of) for v in values], x, y)

        line = self.on.first.some(some, T.ndim)
        f0, r0 = (T * bent(v[0]) for v in (self.pushes, self.borne))
        f2, swing, r2 = (
            T * (bent(still, of) + T * bent(more, of))
            for (still, more), of in zip(self.order_2, (1, 2, 1), strict=True)
        )
        q0, q2, q4 = line.balanced(f0, f2, None, (swing, None), speed=omega, torque=T)
        rows, springs = own(self.rows, 2), own(self.springs, 1)
        firm = springs * (1 + 1j * np.sign(omega) * own(self.loss, 1))
        weight, pulled = bent(self.weight), bent(self.pulled)
        if gives:
            soft = own(self.gives, 1)
            r0, r2, weight, pulled = soft * r0, soft * r2, 0.0 * weight, soft * pulled
            springs = firm = soft * springs  # what rubber loses turns its force, not its motion
        mean = r0 + weight + springs * product(rows, q0)
        drawn = slip * pulled
        static = np.maximum.reduce([_size(mean + k * drawn) for k in (0.0, 1.0, -1.0)])
        dynamic = _axis(r2 + firm * product(rows, q2)) + _axis(firm * product(rows, q4))
        peak = static + dynamic
        nearer = own(self.nearer, 2)
        reach = product(nearer, q0) - bent(self.free) + np.abs(slip * bent(self.drawn))
        reach += np.abs(product(nearer, q2)) + np.abs(product(nearer, q4))
        if self.turning is not None:
            moved = solve(line.at(omega, omega, T), omega**2 * own(self.turning, 2))
            peak = peak + _axis(firm[:, None] * product(rows, moved)).sum(axis=1)
            reach += np.abs(product(nearer, moved)).sum(axis=1)
        return np.concatenate([static, dynamic, peak, reach])


def sketch(
    on: Suspended,
    layouts: Layout,
    line: Line,
    phases: ArrayLike,
    *,
    rides: Rides,
    most: ArrayLike,
    gravity: float = 0.0,
    balanced_at: ArrayLike | None = None,
    facing: Facing | None = None,
) -> Sketch:
    """Return a line for all points of some rides of its axle.

    Where it runs at each of their nodes is on the first axis of `layouts` (rides, ..., S, n, 3);
    what it is `facing` there. The `most` torque of the points,
    (..., S) N m, twists its shafts either way, and others in proportion. Other arguments are
    those of `cardan.loads.running.running`.
    """
    most = np.where(np.asarray(most) > 0, most, 1.0)
    ahead, back = (_of_one(on, layouts, line, line.twisted(phases, T)) for T in (most, -most))
    # Between the two it goes straight, and where there is no torque nothing is left of it.
    f0, f2, r0, r2, swing = ((a + b) / 2 for a, b in zip(ahead, back, strict=True))
    gains = [
        (a - b) / (2 * most.reshape(*most.shape, *(1,) * of))
        for a, b, of in zip(ahead, back, (1, 1, 1, 1, 2), strict=True)
    ]
    weight, pulled = resting(layouts, line, gravity=gravity)
    if facing is None:
        free = drawn = np.empty((1, *layouts.points.shape[1:-2], 0))
        nearer = np.empty((*layouts.points.shape[1:-2], 0, on.mass.shape[-1]))
    else:
        free, nearer = facing.free, on.brought(facing.nearer)
        moved = on.still(on.on_bearings(pulled))
        if moved.ndim < nearer.ndim:
            moved = moved[:, None]
        drawn = (nearer @ moved[..., None])[..., 0].real
    return Sketch(
        on=on,
        rides=rides,
        pushes=(_parabola(f0.real), _parabola(f2)),
        swing=_parabola(swing, of=2),
        borne=(_parabola(r0.real), _parabola(r2)),
        twisted=(_parabola(gains[1]), _parabola(gains[4], of=2), _parabola(gains[3])),
        weight=_parabola(_across(on, weight)),
        pulled=_parabola(_across(on, pulled)),
        rows=leading(on.rows, of=2),
        springs=leading(on.springs, of=1),
        loss=leading(np.repeat(on.loss, 3, axis=-1), of=1),
        gives=leading(on.gives, of=1),
        turning=None if balanced_at is None
        else leading(out_of_balance(line, on, balanced_at=balanced_at).mT, of=2),
        free=_parabola(free),
        nearer=leading(nearer, of=2),
        drawn=_parabola(drawn),
    )  # fmt: skip


def _of_one(on: Suspended, layouts: Layout, line: Line, phases: FloatArray) -> list[Any]:
    """Return what 1 N m does, orders 0 and 2 on coordinates and bearings, and their swing."""
    turned = turn(layouts.directions, phases=phases, crosses=line.crosses, samples=16)
    one = loads(layouts, turned, line, torque=1.0)
    moments, still = ((c.order(0), c.order(2)) for c in (one.joint_moments, one.bearing_forces))
    pushes = [on.pushed(m) for m in moments]
    # Less what the coordinates take at rest.
    borne = [_across(on, s - on.borne(p)) for s, p in zip(still, pushes, strict=True)]
    return [*pushes, *borne, on.swing(turned)]


def _across(on: Suspended, force: Any) -> Any:
    """Return forces (..., n-2, 3) N in the bearings' own directions, (..., B) N."""
    local = (on.frame @ force[..., None])[..., 0]
    return local.reshape(*local.shape[:-2], -1)


def _parabola(values: Any, *, of: int = 1) -> _Bent:
    """Return the coefficients of values (rides, ..., S, M) at the nodes of `Rides`."""
    low, *others = (np.ascontiguousarray(leading(v, of=of)) for v in values)
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
    return major_axis(_by_bearing(force))
