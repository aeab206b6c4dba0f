"""Where a line is worst: at which of its operating points, and its centre bearings on rubber.

Each state is asked along its curves of torque over speed, in every gear and direction: where
a curve starts, bends and ends. What follows torque, speed and angles alone is worst there
(`spread`). Bearings on rubber are asked where an order crosses a mode of the line besides,
and around the worst of these the speed is sought more closely (`worst`).
"""

from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any, TypeAlias, get_args

import numpy as np

from cardan.base.arrays import ArrayLike, FloatArray, IntArray, steps
from cardan.base.frozen import dataclass
from cardan.base.part import Point
from cardan.demand.clearance import gaps
from cardan.demand.motion import Ride
from cardan.demand.points import (
    Curves,
    Direction,
    Placed,
    demand_at,
    on_axle_at,
    placed,
    ride_at,
)
from cardan.demand.states import Demand, demand_ridden, on_axle_under, ride_under
from cardan.kinematics.chain import turn
from cardan.loads.parametric import growth, of_two
from cardan.loads.rubber import LOSS, Suspended, suspended
from cardan.loads.running import Running, at_joints, running, set_down, shifted
from cardan.loads.sketch import Facing, Reach, Rides, Sketch, sketch
from cardan.model.layout import Layout
from cardan.model.seat import soft

if TYPE_CHECKING:
    from cardan.quantity.response import Response

FORCES = ("static", "dynamic", "peak")
"""The forces that are sought where they are largest."""

CLOSER = 0.25
"""How far beside the worst speed it is sought again, in loss factors: a mode's width is one."""

_Row: TypeAlias = tuple[IntArray, FloatArray]
"""Which curves points (P, ..., S) are on, and their speeds."""

FIRM = 1e14
"""N/m, of a bearing without rubber in a bracket that gives: a millionth of what brackets give,
and rounding is as small."""

SHARES = (0.7, 0.85, 1.0)
"""Of a gear's highest speed: there its torque falls, and an axle's springs stiffen somewhere."""

STRAIGHT = 1e-9
"""m, of travel that is rounding."""

FLANKS = (-1.5, -0.5, 0.5, 1.5)
"""Where beside a crest order 2 may add most to the mean, in the same."""

CRESTS = 3
"""How many crests are sought more closely: the next may prove the higher one."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Spots:
    """Points of a line's curves.

    P points (P, ..., S), or the worst one of each part (..., S, parts).

    Attributes
    ----------
    curves
        What the line's torque is over its speed.
    curve
        Which of them each point is on.
    speed, torque : rad/s, N m
        Of the line there; nan where a state has no such point.
    """

    curves: Curves
    curve: IntArray
    speed: FloatArray
    torque: FloatArray

    def named(self, at: tuple[int, ...]) -> Point | None:
        """Return one of them; None where there is none."""
        curve, speed, torque = int(self.curve[at]), float(self.speed[at]), float(self.torque[at])
        if np.isnan(torque):
            return None
        return Point(self.curves.gears[curve], self.curves.directions[curve], speed, torque)

    @property
    def first_variant(self) -> "Spots":
        """The points (P, S) of the first variant, where there is an axis of them."""
        return Spots(
            curves=self.curves,
            curve=self.curve[:, 0],
            speed=self.speed[:, 0],
            torque=self.torque[:, 0],
        )

    def of_parts(self, which: IntArray) -> "Spots":
        """Return which point (..., S, parts) each part has; below 0 none."""
        here = (np.maximum(which, 0), *steps(which.shape)[:-1])
        cases = len(self.speed), *which.shape[:-1]
        of = [np.broadcast_to(v, cases)[here] for v in (self.speed, self.torque)]
        return Spots(
            curves=self.curves,
            curve=np.broadcast_to(self.curve, cases)[here],
            speed=of[0],
            torque=np.where(which < 0, np.nan, of[1]),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Points(Spots):
    """Points of a line's curves, and what its bearings carry there.

    Attributes
    ----------
    running : (P, ..., S, n-2) or (..., S, n-2) N
        What the bearings carry; `Sizes` alone while the worst points are sought.
    """

    running: Any

    def of_bearings(self, which: Sequence[int]) -> "Points":
        """Return the worst points (..., S, n-2) of some bearings alone."""
        count = self.curve.shape[-1]
        if list(which) == list(range(count)):
            return self
        kept = np.asarray(which)
        # What bearings carry has the axis of the bearings where their points have it.
        axis = self.curve.ndim - 1

        def own(values: Any) -> Any:
            return np.take(values, kept, axis=axis)

        return _each(own, self)


@dataclass(frozen=True, kw_only=True, eq=False)
class Spread:
    """A line at the points where what follows torque, speed and angles is worst.

    Attributes
    ----------
    spots : (P, ..., S)
    response
        The line there: points on its first axis, then variants (one where there are none),
        the states last.
    """

    spots: Spots
    response: "Response"


def curves_of(r: "Response") -> Curves:
    """Return the torque over speed of a line, in each case (..., S) of whatever varies."""
    found = r.own_curves
    return _beside_variants(found, _cases(r, found)) if found.gears else found


def spread(r: "Response") -> Spread | None:
    """Return a line at the corners of its curves; None where it has none.

    Those of most torque each way it is turned, the highest speed of each gear and two `SHARES` of
    it: between them torque and speed go straight, and so does an axle, but where springs stiffen.
    """
    found = r.own_curves
    if not found.gears:
        return None
    # Curves that no variant changes have one axis of one: what follows from them alone is
    # asked once, and what a tube's wall makes of it, which no force shows, for each.
    if found.fastest.ndim == 2:
        found = _beside_variants(found, (1, *found.fastest.shape[1:]))
    rows = [row for of in _ways(found) for row in _corners(found, of)]
    every = np.arange(len(found.gears)).reshape(-1, *(1,) * (found.fastest.ndim - 1))
    every = np.broadcast_to(every, found.fastest.shape)
    shares = SHARES if r.demand.standing.squats.any() else SHARES[-1:]
    rows += [(every, share * found.fastest) for share in shares]
    # Many a gear ends where its way does.
    curve, speed = _gathered(found, [_once(*_gathered(found, rows))])
    asked = demand_at(r.demand, found, curve=curve, speed=speed)
    # What the engine gives ahead in the gear of the point, wherever the tyres slip.
    free = placed(replace(found, most=np.full_like(found.most, np.inf)), curve=curve, speed=speed)
    asked = replace(asked, engine_torque=np.where(free.turns("drive"), free.torque, np.nan))
    return Spread(
        spots=Spots(curves=found, curve=curve, speed=asked.speed, torque=asked.torque),
        response=replace(r, demand=asked, layout=r.lay(asked)),
    )


def _each(change: Callable[..., Any], *of: Points) -> Points:
    """Return points whose arrays are changed alike from those of others."""
    first, kind = of[0], type(of[0].running)
    return Points(
        curves=first.curves,
        curve=change(*(p.curve for p in of)),
        speed=change(*(p.speed for p in of)),
        torque=change(*(p.torque for p in of)),
        running=kind(
            **{f.name: change(*(getattr(p.running, f.name) for p in of)) for f in fields(kind)}
        ),
    )


def held(r: "Response", *, assumed: ArrayLike = LOSS, cut: bool = False) -> Suspended | None:
    """Return how a line can move on its rubber in each state; None where it cannot, or who knows.

    It needs a length and a tube of each shaft for its mass, and a stiffness of one bearing. A
    loss factor that nobody gives is `assumed` (...). Its joints may be `cut` for what they carry.
    """
    bearings = [s.centre_bearing for s in r.line.shafts if s.centre_bearing]
    told = {
        k: soft(b.bracket_stiffness, loss=b.bracket_loss)
        for k, b in enumerate(bearings)
        if b.bracket_stiffness
    }
    seats = {**told, **r.seats}
    unknown = not seats and all(b.stiffness is None for b in bearings)
    if any(s.tube is None for s in r.line.shafts) or unknown or not r.line.measured:
        return None
    stiffness = [
        [
            *(b.stiffness or ((FIRM, FIRM) if k in seats else (np.inf, np.inf))),
            0.0 if b.axial_stiffness is None else b.axial_stiffness,
        ]
        for k, b in enumerate(bearings)
    ]
    loss = [assumed if b.loss_factor is None else b.loss_factor for b in bearings]
    columns = np.broadcast_arrays(*(np.asarray(v, dtype=float) for row in stiffness for v in row))
    k = np.stack(columns, axis=-1).reshape(*columns[0].shape, len(bearings), 3)
    eta = np.stack(np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in loss)), axis=-1)
    found = suspended(r.layout, r.line, stiffness=k, loss=eta, cut=cut)
    for bearing, seat in seats.items():
        found = found.mounted(bearing, seat)
    return found


def otherwise(r: "Response", assumed: FloatArray) -> Running:
    """Return what the bearings carry at the points of most orders with other loss factors.

    For `assumed` (F, 1), beside the states: (F, S, n-2).
    """
    p = r.worst["dynamic"]
    curve, speed = (v[:, None] for v in _rows(p))
    curves_ = _beside_variants(p.curves, curve.shape[1:])
    asked = demand_at(r.demand, curves_, curve=curve, speed=speed)
    found = run(r, asked, r.lay(asked), on=held(r, assumed=assumed))

    def own(values: Any) -> Any:
        """Return of each bearing what it carries at its own point: (P, F, S, n-2, ...)."""
        return np.stack([values[b, :, :, b] for b in range(len(curve))], axis=2)

    return Running(**{f.name: own(getattr(found, f.name)) for f in fields(Running)})


def run(
    r: "Response",
    of: Demand,
    layout: Layout,
    *,
    inertia: bool = True,
    on: Suspended | None = None,
    gives: bool = False,
) -> Running:
    """Return what the bearings carry under a demand, where the line then runs.

    On its own rubber, or on that of `on`; or how far that gives across the shafts, in m.
    """
    asked = _asked(r, of, inertia=inertia)
    found = running(layout, r.line, r.phases, held=on or r.held, gives=gives, **asked)
    return _known(found, of)


def _asked(r: "Response", of: Demand, *, inertia: bool) -> dict[str, Any]:
    """Return what a line's forces as it runs depend on, beside where it lies."""
    return {
        "torque": np.nan_to_num(of.torque),
        "speed": np.nan_to_num(of.turning),
        "inertias": r.inertias if inertia else None,
        "gravity": r.gravity,
        "slip": r.slip_at(of.torque),
        "balanced_at": r.balanced_at if r.application.include_unbalance else None,
    }


def _known(found: Running, of: Demand) -> Running:
    """Return forces with nan where a demand is no point."""
    nothing = np.where(np.isfinite(of.torque), 0.0, np.nan)[..., None]
    return Running(
        mean=found.mean + nothing[..., None],
        thrust=found.thrust + nothing,
        order1=found.order1 + nothing,
        waves=found.waves + nothing[..., None, None],
    )


def worst(r: "Response") -> dict[str, Points]:
    """Return the point where each of `FORCES` is largest on each bearing, (..., S, n-2).

    Nothing where the line has no point, or no bearing. It is sought on the slowest modes of
    the line alone, and without the shafts' inertia, whose share is small where resonance is;
    what is found has all of it.
    """
    found, tries = r.curves, r.tries
    if tries is None:
        return {}
    tried = r.tried.forces if r.tried else _at(r, found, tries.curve, tries.speed)
    # Two means are often alike, and which is larger is for the whole line to say.
    still, next_ = _foremost(tried, "static", 2)
    seeds = still, *(_best(tried, name) for name in FORCES[1:]), next_
    last = _at(r, found, *_gathered(found, [_once(*_rows(*seeds))]))
    return {name: _best(last, name) for name in FORCES}


def every(r: "Response") -> Points | None:
    """Return all points (P, ..., S) that bearings were asked at for the worst; None without one.

    What is best for one load may be worst with another on top of it.
    """
    of = r.tries
    if of is None or not r.worst:
        return None
    tried = r.tried.forces if r.tried else of
    rows = [(tried.curve, tried.speed), _rows(*r.worst.values())]
    return _at(r, r.curves, *_gathered(r.curves, [_once(*_gathered(r.curves, rows))]))


def worst_travel(r: "Response") -> Points | None:
    """Return the point where each bearing goes farthest across its rubber, (..., S, n-2) m.

    Another one than that of its `worst` peak where rubber gives one way more than the other.
    None where the line is not on rubber, or has no point.
    """
    found = tried(r, gives=True)
    if found is None:
        return None
    seeds = _foremost(found.forces, "peak", 2)
    curve, speed = _gathered(r.curves, [_once(*_rows(*seeds))])
    return _best(_at(r, r.curves, curve, speed, gives=True), "peak")


def worst_reach(r: "Response") -> Points | None:
    """Return the point where each shaft comes nearest to each obstacle as rubber lets it.

    (..., S, parts), the obstacles of the first shaft before those of the second. None where the
    line is not on rubber, or has no point, or nothing is in its way. Of the points tried: none
    beside them has 0.1 mm more.

    The distance of a place on a shaft is convex in where it goes: along the way to the obstacle,
    what is left of it is never more than what there is.
    """
    if r.tried is None or not r.obstacles:
        return None
    curve, speed = _gathered(r.curves, [_once(*_rows(*_foremost(r.tried.reach, "reach", 2)))])
    asked = demand_at(r.demand, r.curves, curve=curve, speed=speed)
    assert r.held is not None  # or nothing is tried on it
    laid, how = r.lay(asked), _asked(r, asked, inertia=True)
    del how["gravity"]  # a layout is one of a line that already hangs
    gone = shifted(laid, r.line, r.phases, held=r.held, **how)
    there = gaps(laid, r.line, r.obstacles, travel=asked.travel)
    share = np.stack([1 - there.share, there.share], axis=-1)

    def along(ends: Any) -> Any:
        """Return how far that takes each shaft from each obstacle, where they may be nearest."""
        return ((there.away @ ends[..., None, :, :].mT) * share).sum(-1)

    waves = sum(np.abs(along(wave)) for wave in np.moveaxis(gone.waves, -4, 0))
    free = there.free + along(gone.mean) - np.abs(along(gone.thrust)) - waves
    free = np.where(np.isnan(asked.torque)[..., None, None], np.nan, free.min(axis=-1))
    every = Points(
        curves=r.curves,
        curve=np.broadcast_to(curve, asked.speed.shape),
        speed=asked.speed,
        torque=asked.torque,
        running=Reach(reach=-free.reshape(*free.shape[:-2], -1)),
    )
    return _best(every, "reach")


def _facing(r: "Response", laid: Layout, travel: FloatArray) -> Facing | None:
    """Return where shafts come nearest to obstacles, of layouts (rides, ...) at nodes."""
    if not r.obstacles:
        return None
    if laid.points.ndim < 5:  # obstacles may be of variants that lie alike
        laid = laid[:, None]
    if travel.ndim < 3:
        travel = travel[:, None]
    there = gaps(laid, r.line, r.obstacles, travel=travel)
    free = there.free.min(axis=-1)
    middle = 1 if len(free) > 1 else 0
    best = there.free[middle].argmin(axis=-1)[..., None]
    share = np.take_along_axis(there.share[middle], best, axis=-1)[..., 0]
    away = np.take_along_axis(there.away[middle], best[..., None], axis=-2)[..., 0, :]
    shafts, obstacles = free.shape[-2:]
    nearer = -np.stack([1 - share, share], axis=-1)[..., None] * away[..., None, :]
    own = np.eye(shafts)[:, None, :, None, None]  # of all shafts' ends its own ones
    nearer = (nearer[..., None, :, :] * own).reshape(
        *nearer.shape[:-4], shafts * obstacles, shafts, 2, 3
    )
    return Facing(free=free.reshape(*free.shape[:-2], -1), nearer=nearer)


def settled(r: "Response") -> "Response":
    """Return a line as its torque leaves it: shafts twisted, bearings moved on their rubber.

    The bearings at each operating point; of a line that has none they hang where they did. Its
    angles are to be asked: forces on rubber are those of a line before its rubber gives.
    """

    def lay(of: Demand) -> Layout:
        torque = np.nan_to_num(of.torque)
        if r.held is None:
            return r.lay(of)
        return set_down(r.lay(of), r.line, r.phases, torque=torque, held=r.held)

    return replace(r, lay=lay, under_torque=True)


@dataclass(frozen=True, kw_only=True, eq=False)
class Tries:
    """Points (P, ..., S) at which bearings may be worst, and the line `drawn` for all of them.

    It is None of a line that is not on rubber.
    """

    curve: IntArray
    speed: FloatArray
    drawn: Sketch | None


def tries(r: "Response") -> Tries | None:
    """Return where bearings may be worst; None where a line has no point, or no bearing."""
    found, quick = r.curves, r.quick
    if not found.gears or r.line.joint_count < 3:
        return None
    curve, speed = _candidates(r, found, quick)
    at = placed(found, curve=curve, speed=speed)
    return Tries(curve=curve, speed=speed, drawn=None if quick is None else _sketch(r, at, quick))


@dataclass(frozen=True, kw_only=True, eq=False)
class Tried:
    """What a line nearly does at points.

    Attributes
    ----------
    forces
        What its bearings carry, or how far their rubber gives, there and beside the worst.
    reach
        How far its shafts reach into obstacles.
    """

    forces: Points
    reach: Points


def tried(r: "Response", *, gives: bool = False) -> Tried | None:
    """Return what a line nearly does at its tries; or how far rubber gives, in m for N.

    None of a line that is not on rubber, or has no point.
    """
    of = r.tries
    if of is None or of.drawn is None:
        return None
    first, reach = _sketched(r, r.curves, of.curve, of.speed, of.drawn, gives=gives)
    return Tried(forces=_closer(r, first, of.drawn, gives=gives), reach=reach)


def worst_joints(r: "Response") -> Points | None:
    """Return the point where what shakes each joint is largest, (..., S, n).

    Of a line on its rubber, at the corners of its curves and where orders meet modes; None
    where it is not on rubber, or has no point. The first joint and the last are those of the
    flanges.
    """
    found, cut = r.curves, held(r, cut=True)
    if not found.gears or r.held is None or cut is None or r.line.joint_count < 3:
        return None
    curve, speed = _candidates(r, found, r.quick)
    asked = demand_at(r.demand, found, curve=curve, speed=speed)
    carried = at_joints(
        r.lay(asked), r.line, r.phases, held=r.held, cut=cut, **_asked(r, asked, inertia=True)
    )
    every = Points(
        curves=found,
        curve=np.broadcast_to(curve, asked.speed.shape),
        speed=asked.speed,
        torque=asked.torque,
        running=_known(carried, asked),
    )
    return _best(every, "dynamic")


@dataclass(frozen=True, kw_only=True, eq=False)
class Swinging:
    """How a line's swinging goes on, (..., 1) 1/s: above 0 it grows by itself."""

    growth: FloatArray


def worst_growth(r: "Response") -> Points | None:
    """Return the point where a line's swinging grows most, or dies away least, (..., S, 1).

    At the corners of its curves, and with most torque where twice the speed meets the sum of
    two modes; None where the line is not on rubber, or has no point.
    """
    found, quick = r.curves, r.quick
    if not found.gears or quick is None or r.line.joint_count < 3:
        return None
    rows: list[_Row] = []
    for of in _ways(found):
        rows += [*_corners(found, of), _sums(found, quick, of)]
    curve, speed = _gathered(found, rows)
    asked = placed(found, curve=curve, speed=speed)
    # Where the axle rides changes a shaft's length, and so this, by next to nothing.
    tried = _swinging(r, asked, quick, r.layout, how=of_two)
    # Zones lie close, and more than two modes feed each other.
    most = _foremost(tried, "growth", CRESTS)
    curve, speed = _gathered(found, [_once(*_rows(*most))])
    asked = placed(found, curve=curve, speed=speed)
    lies = r.lay(demand_at(r.demand, found, curve=curve, speed=speed))
    return _best(_swinging(r, asked, quick, lies, how=growth), "growth")


def _swinging(
    r: "Response",
    at: Placed,
    quick: Suspended,
    lies: Layout,
    *,
    how: Callable[..., FloatArray],
) -> Points:
    """Return how a line's swinging goes on at points (P, ..., S), where it lies."""
    torque, pace = np.nan_to_num(at.torque), at.sense * np.nan_to_num(at.speed)
    under = r.line.twisted(r.phases, torque)
    turned = turn(lies.directions, phases=under, crosses=r.line.crosses, samples=16)
    rate = how(quick, quick.swing(turned), speed=pace, torque=torque)
    return Points(
        curves=at.curves,
        curve=at.curve,
        speed=at.speed,
        torque=at.torque,
        running=Swinging(growth=np.where(np.isnan(at.torque), np.nan, rate)[..., None]),
    )


def _sums(found: Curves, quick: Suspended, of: IntArray) -> _Row:
    """Return where order 2 meets the sum of two modes with most torque of curves `of` C."""
    cases, modes = found.fastest.shape[1:], quick.mass.shape[-1]
    one, other = np.triu_indices(modes)
    free = np.broadcast_to(quick.frequencies(), (*cases, modes))
    meets = np.moveaxis(free[..., one] + free[..., other], -1, 0) / 2
    _, torque = _with_most(found, of, meets)
    under = quick.frequencies(torque=np.nan_to_num(torque))
    meets = np.stack([(under[q, ..., i] + under[q, ..., j]) / 2
                      for q, (i, j) in enumerate(zip(one, other, strict=True))])  # fmt: skip
    return _with_most(found, of, meets)[0], meets


def _candidates(r: "Response", found: Curves, quick: Suspended | None) -> _Row:
    """Return points (P, ..., S) at which bearings may be worst.

    Of each way to be turned: the corners of the curve of most torque, the highest speed, and
    with most torque each speed at which an order of the joints meets a mode on rubber. Where
    unbalance counts, which knows no torque: with most torque of all, where its order meets a
    mode, and the end of each gear, as it grows with the speed while torque falls from gear to
    gear.
    """
    rows: list[_Row] = []
    for of in _ways(found):
        rows += _corners(found, of)
        if quick is not None:
            rows.append(_crossings(found, quick, of, orders=(2, 4)))
    if r.application.include_unbalance:
        every = np.arange(len(found.gears))
        ends = np.nan_to_num(found.fastest[[d != "coast" for d in found.directions]], nan=-1.0)
        rows.append((_with_most(found, every, ends)[0], ends))
        if quick is not None:
            rows.append(_crossings(found, quick, every, orders=(1,)))
    return _gathered(found, rows)


def _ways(found: Curves) -> list[IntArray]:
    """Return which curves turn the line each way.

    Coast and reverse push alike and turn against each other: what shakes first up, then
    sideways shakes the other way round, and rubber that damps both tells these apart.
    """
    each = [np.flatnonzero([d == way for d in found.directions]) for way in get_args(Direction)]
    return [of for of in each if len(of)]


def _corners(found: Curves, of: IntArray) -> list[_Row]:
    """Return the corners of the strongest of curves `of` C, and the end of the quickest."""
    standing = np.where(np.isnan(found.fastest), -1.0, np.abs(found.torque[..., 0]))
    standing = np.minimum(standing, found.most)
    reach = np.nan_to_num(found.fastest, nan=-1.0)
    strong, quick = (of[values[of].argmax(axis=0)] for values in (standing, reach))
    cases = steps(strong.shape)
    bends = found.corners[:, strong, *cases]
    return [
        (np.broadcast_to(strong, bends.shape), bends),
        (quick[None], reach[quick, *cases][None]),
    ]


def _gathered(found: Curves, rows: list[_Row]) -> _Row:
    """Return points (P, ..., S) with those that a state has first, in no more rows than needed."""
    curve, speed = (np.concatenate(values) for values in zip(*rows, strict=True))
    cases = steps(speed.shape)[1:]
    there = (speed >= 0) & (speed <= found.fastest[curve, *cases])
    first = np.argsort(~there, axis=0, kind="stable")[: there.sum(axis=0).max(initial=1)]
    return curve[first, *cases], np.where(there, speed, np.nan)[first, *cases]


def _with_most(found: Curves, of: IntArray, speed: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return which curves `of` C have most torque at speeds (Q, ..., S), and how much."""
    size = found.of(of).torque_at(speed[:, None])
    strong = np.abs(np.nan_to_num(size)).argmax(axis=1)
    here, *cases = steps(strong.shape)
    return of[strong], size[here, strong, *cases]


def _crossings(found: Curves, quick: Suspended, of: IntArray, *, orders: tuple[int, ...]) -> _Row:
    """Return where orders meet modes with most torque of curves `of` C, (Q, ..., S).

    Which curve that is, and the speed: a mode has the frequency that the torque leaves it.
    """
    cases, modes = found.fastest.shape[1:], quick.mass.shape[-1]
    free = np.broadcast_to(quick.frequencies(), (*cases, modes))
    meets = np.concatenate([np.moveaxis(free / k, -1, 0) for k in orders])
    _, torque = _with_most(found, of, meets)
    under = quick.frequencies(torque=np.nan_to_num(torque))
    meets = np.stack([
        under[q, ..., q % modes] / orders[q // modes] for q in range(len(meets))
    ])  # fmt: skip
    return _with_most(found, of, meets)[0], meets


def _rows(*found: Points) -> _Row:
    """Return curves and speeds (P, ..., S) of points (..., S, n-2) of each bearing."""
    each = [(np.moveaxis(p.curve, -1, 0), np.moveaxis(p.speed, -1, 0)) for p in found]
    curve, speed = (np.concatenate(values) for values in zip(*each, strict=True))
    return curve, speed


def _sketch(r: "Response", at: Placed, on: Suspended) -> Sketch:
    """Return a line for all points between the least and the largest torque on its axle."""
    # A state without a point has its own ride, and no force.
    some = np.where(np.isnan(at.torque), np.nan, on_axle_at(r.demand, at))
    some = np.where(np.isnan(some).all(axis=0), 0.0, some)
    ridden = ride_at(r.demand, at)
    rides = _rides(some, ridden, r.demand.ride)
    each = [rides.ridden(*node) for node in rides.nodes]

    def named(case: tuple[int, ...]) -> str:
        """Name the point nearest to a ride."""
        away = np.abs(some[(slice(None), *case[1:])] - each[case[0]][0][case[1:]])
        return at.named((int(np.nanargmin(away)), *case[1:]))

    asked = _at_nodes(r, rides, named=named)
    laid = r.lay(asked)
    if laid.directions.ndim - 2 < asked.torque.ndim:  # however the axle rides, it lies as it lies
        laid = laid[None]
    return sketch(
        on, laid, r.line, r.phases, rides=rides,
        most=np.abs(np.nan_to_num(at.torque)).max(axis=0), gravity=r.gravity,
        balanced_at=r.balanced_at if r.application.include_unbalance else None,
        facing=_facing(r, laid, asked.travel),
    )  # fmt: skip


def _rides(on_axle: FloatArray, ride: Ride, own: Ride) -> Rides:
    """Return the rides of an axle at points: torques on it (P, ..., S), nan where there is none.

    It moves where it rides otherwise than in its `own` state, if only in one way.
    """
    travel = np.broadcast_to(np.asarray(ride.shift, dtype=float)[..., 2], on_axle.shape)
    pitch = np.broadcast_to(np.asarray(ride.pitch, dtype=float), on_axle.shape)
    travel, pitch = (np.where(np.isnan(on_axle), np.nan, v) for v in (travel, pitch))
    ends = [of(on_axle, axis=0)[None] for of in (np.nanargmin, np.nanargmax)]
    (least, lowest), (largest, highest) = (
        [np.take_along_axis(v, end, axis=0)[0] for v in (on_axle, travel)] for end in ends
    )
    found = Rides(
        least=least, largest=largest, lowest=lowest, highest=highest,
        away=np.zeros_like(least),
        moves=any(
            np.nanmax(np.abs(v - at), initial=0.0) > 0
            for v, at in ((travel, np.asarray(own.shift)[..., 2]), (pitch, own.pitch))
        ),
    )  # fmt: skip
    _, off = found.of(on_axle, travel)
    away = np.nanmax(np.abs(off), axis=0)
    return replace(found, away=np.where(away > STRAIGHT, away, 0.0))


def _at_nodes(
    r: "Response", rides: Rides, *, named: Callable[[tuple[int, ...]], str] = str
) -> Demand:
    """Return a line at each of the nodes of its axle's rides, (rides, ..., S)."""
    torque, travel = (
        np.stack(v) for v in zip(*(rides.ridden(*n) for n in rides.nodes), strict=True)
    )
    if not rides.moves:  # it rides as in its state
        ride = replace(r.demand.ride, pitch=np.broadcast_to(r.demand.ride.pitch, torque.shape))
    else:
        ride = r.demand.standing.at(torque, travel)
    return demand_ridden(r.demand, ride, torque=r.demand.torque, speed=r.demand.speed, named=named)


def _sketched(
    r: "Response",
    found: Curves,
    curve: IntArray,
    speed: FloatArray,
    drawn: Sketch,
    *,
    gives: bool = False,
) -> tuple[Points, Points]:
    """Return nearly what bearings carry at points, curves and speeds (P, ..., S), and the reach."""
    at = placed(found, curve=curve, speed=speed)
    told = drawn.at(
        at.torque,
        speed=at.sense * at.speed,
        on_axle=on_axle_at(r.demand, at),
        travel=np.asarray(ride_at(r.demand, at).shift)[..., 2],
        slip=r.slip_at(at.torque),
        gives=gives,
    )
    forces, reach = (
        Points(curves=found, curve=at.curve, speed=at.speed, torque=at.torque, running=of)
        for of in told
    )
    return forces, reach


def _once(curve: IntArray, speed: FloatArray) -> _Row:
    """Return points without those of a case that come again: their speed is nan."""
    same = (curve[:, None] == curve) & (speed[:, None] == speed)
    before = np.tri(len(curve), k=-1, dtype=bool)
    again = (same & before.reshape(*before.shape, *(1,) * (curve.ndim - 1))).any(axis=1)
    return curve, np.where(again, np.nan, speed)


def _closer(r: "Response", tried: Points, drawn: Sketch, *, gives: bool = False) -> Points:
    """Return points tried, and those beside the worst of them where they may be worse.

    The worst peak of each bearing, and the `CRESTS` of what shakes it most. Where a mode
    alone shakes, 1/F² is a parabola over the square of the speed; what order 2 adds to the
    mean is largest half a mode's width beside that crest, or farther where modes overlap
    (`FLANKS`).
    """
    found = tried.curves
    shaken = _foremost(tried, "dynamic", CRESTS)
    seeds = [("peak", _best(tried, "peak")), *(("dynamic", p) for p in shaken)]
    curve, speed = _rows(*(p for _, p in seeds))
    fastest = found.fastest[curve, *steps(curve.shape)[1:]]
    wide = drawn.on.loss.min(axis=-1)  # as narrow as the narrowest mode
    low, high = speed * (1 - CLOSER * wide), np.fmin(speed * (1 + CLOSER * wide), fastest)
    flanks = _rows(*shaken)
    sides, _ = _sketched(
        r,
        found,
        np.concatenate([curve, curve, *(flanks[0] for _ in FLANKS)]),
        np.concatenate([low, high, *(flanks[1] * (1 + k * wide) for k in FLANKS)]),
        drawn,
        gives=gives,
    )
    middle = [np.moveaxis(getattr(p.running, name), -1, 0) for name, p in seeds]
    bearings = len(middle[0])
    ends = np.stack([
        getattr(sides.running, name)[half * len(curve) + k * bearings + b, ..., b]
        for half in (0, 1) for k, (name, _) in enumerate(seeds) for b in range(bearings)
    ])  # fmt: skip
    with np.errstate(divide="ignore", invalid="ignore"):
        x = np.stack([low, speed, high]) ** 2
        y = np.stack([ends[: len(curve)], np.concatenate(middle), ends[len(curve) :]]) ** -2.0
        slopes = np.diff(y, axis=0) / np.diff(x, axis=0)
        bend = (slopes[1] - slopes[0]) / (x[2] - x[0])
        crest = (x[0] + x[1]) / 2 - slopes[0] / (2 * bend)
    reach = x[2] - x[0]  # the crest of two modes that overlap lies outside
    crest = np.where(bend > 0, np.clip(crest, x[0] - reach / 2, x[2] + reach / 2), x[1])
    crest = np.fmin(np.sqrt(np.maximum(crest, 0.0)), fastest)
    there, _ = _sketched(r, found, curve, crest, drawn, gives=gives)
    return _each(lambda *v: np.concatenate(v), tried, sides, there)


def swept(r: "Response", speed: FloatArray, *, curves_: Sequence[int] | None = None) -> Points:
    """Return what a line's bearings carry along its curves at speeds (Q,) rad/s.

    On its slowest modes, as they are drawn: points (C, Q, S), of all curves or of some.
    """
    found, quick = r.curves, r.quick
    of = np.arange(len(found.gears)) if curves_ is None else np.asarray(curves_)
    shape = (len(of), len(speed), *found.fastest.shape[1:])
    curve = np.broadcast_to(of[:, None, None], shape).reshape(-1, *shape[2:])
    every = np.broadcast_to(speed[:, None], shape).reshape(curve.shape)
    flat = _at(r, found, curve, every, quick=quick)

    def gear_by_gear(values: Any) -> Any:
        return values.reshape(*shape[:2], *values.shape[1:])

    return _each(gear_by_gear, flat)


@dataclass(frozen=True, kw_only=True, eq=False)
class Driven:
    """A drive of the line in time: P instants of even steps.

    Attributes
    ----------
    time, turned : (P,) s, rad
        And how far the gearbox's yoke has turned.
    torque, speed : (P,) N m, rad/s
        Signed, as how far it has turned.
    """

    time: FloatArray
    turned: FloatArray
    torque: FloatArray
    speed: FloatArray


def driven(r: "Response", of: Driven, *, state: int) -> tuple[FloatArray, FloatArray] | None:
    """Return what the bearings carry along a drive in a state, (P, n-2) N twice.

    Steadily at each instant's torque and speed, and as the line passes through; the axle where
    the torque of the instant has it. None where the line is not on rubber.
    """
    if r.held is None:
        return None
    on = r.held.of_case(state).slowest(r.line.swings)
    every = np.repeat(of.torque[:, None], len(r.demand.states), axis=1)
    on_axle = np.nan_to_num(on_axle_under(r.demand, every))
    ridden = ride_under(r.demand, every)
    rides = _rides(on_axle, ridden, r.demand.ride)
    laid, count = r.lay(_at_nodes(r, rides)), len(rides.nodes)
    where = Layout(
        points=np.broadcast_to(laid.points, (count, *laid.points.shape[-3:]))[:, state],
        directions=np.broadcast_to(laid.directions, (count, *laid.directions.shape[-3:]))[:, state],
    )
    drawn = sketch(
        on, where, r.line, r.phases,
        rides=replace(
            rides,
            **{
                name: getattr(rides, name)[state]
                for name in ("least", "largest", "lowest", "highest", "away")
            },
        ),
        most=np.abs(of.torque).max(), gravity=r.gravity,
    )  # fmt: skip
    asked: dict[str, Any] = {
        "torque": of.torque,
        "speed": of.speed,
        "on_axle": on_axle[:, state],
        "travel": np.broadcast_to(np.asarray(ridden.shift)[..., 2], on_axle.shape)[:, state],
        "slip": np.nan_to_num(r.slip_at(every)[:, state]),
    }
    return drawn.at(**asked)[0].peak, drawn.passed(of.time, of.turned, **asked)


def _cases(r: "Response", found: Curves) -> tuple[int, ...]:
    """Return the cases (..., S) that a line on its bearings has: of whatever varies."""
    of_parts: list[Any] = [n for s in r.line.shafts for n in (s.mass, s.balance_grade)]
    of_parts += [s.centre_bearing.from_rear_joint for s in r.line.shafts if s.centre_bearing]
    for o in r.obstacles:
        of_parts += [*o.start, *o.end, o.radius, o.travel_share, r.demand.travel]
    of_parts += [s.torsional_flexibility for s in r.line.shafts]
    shapes = [
        found.fastest.shape[1:],
        r.layout.directions.shape[:-2],
        r.phases.shape[:-1],
        r.demand.torque.shape,
        r.spline_force.shape,
        *(np.shape(n) or (1,) for n in of_parts if n is not None),
    ]
    if r.inertias is not None:
        shapes.append(r.inertias.shape[:-1])
    if r.held is not None:
        shapes.append(r.held.first.cases)
    return np.broadcast_shapes(*shapes)


def _beside_variants(found: Curves, cases: tuple[int, ...]) -> Curves:
    """Return curves (C, S) or (C, ..., S) for all cases (..., S) of a line."""

    def wide(values: FloatArray, *corners: int) -> FloatArray:
        lead = values.shape[1 : values.ndim - len(corners)]
        values = values.reshape(len(values), *(1,) * (len(cases) - len(lead)), *values.shape[1:])
        return np.broadcast_to(values, (len(values), *cases, *corners))

    corners = found.speed.shape[-1]
    return Curves(
        gears=found.gears,
        directions=found.directions,
        speed=wide(found.speed, corners),
        torque=wide(found.torque, corners),
        most=wide(found.most),
        fastest=wide(found.fastest),
    )


def _at(
    r: "Response",
    found: Curves,
    curve: IntArray,
    speed: FloatArray,
    *,
    quick: Suspended | None = None,
    gives: bool = False,
) -> Points:
    """Return what the bearings carry at points, their curves and speeds (P, ..., S).

    Or nearly that, as they move on `quick` and without the shafts' inertia; or how far their
    rubber `gives`.
    """
    asked = demand_at(r.demand, found, curve=curve, speed=speed)
    return Points(
        curves=found,
        curve=np.broadcast_to(curve, asked.speed.shape),
        speed=asked.speed,
        torque=asked.torque,
        running=run(r, asked, r.lay(asked), inertia=quick is None, on=quick, gives=gives),
    )


def _best(p: Points, force: str, rank: int = 0) -> Points:
    """Return the point where a force is largest, of each bearing by itself, (..., S, n-2).

    Or that of the next larger ones, by `rank`.
    """
    return _foremost(p, force, rank + 1)[-1]


def _foremost(p: Points, force: str, count: int) -> list[Points]:
    """Return the points where a force is largest, then the next larger ones, as `_best` does."""
    value = np.nan_to_num(getattr(p.running, force), nan=np.finfo(float).min)
    found: list[Points] = []
    for rank in range(count):
        here = (value.argmax(axis=0), *steps(value.shape[1:]))

        def taken(values: Any, here: tuple[IntArray, ...] = here) -> Any:
            return values[here[: values.ndim]]  # of points, or of their bearings

        found.append(_each(taken, p))
        if rank + 1 < min(count, len(value)):
            value[here] = -np.inf
    return found
