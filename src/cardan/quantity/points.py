"""Where its centre bearings are worst: a line at its operating points, on its rubber.

Each state is asked along its curves of torque over speed, in every gear and direction: where
a curve starts, bends and ends, and where an order crosses a mode of the line on its rubber.
Around the worst of these the speed is sought more closely.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from cardan.base.arrays import FloatArray, IntArray
from cardan.base.part import Point
from cardan.demand.points import Curves, curves, demand_at
from cardan.demand.states import Demand
from cardan.loads.rubber import LOSS, Suspended, suspended
from cardan.loads.running import Running, running
from cardan.model.layout import Layout

if TYPE_CHECKING:
    from cardan.quantity.response import Response

FORCES = ("static", "dynamic", "peak")
"""The forces that are sought where they are largest."""

CLOSER = 0.25
"""How far beside the worst speed it is sought again, in loss factors: a mode's width is one."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Points:
    """A line at points of its curves, and what its bearings carry there.

    Of P points (P, ..., S), or of the worst one of each bearing (..., S, n-2).

    Attributes
    ----------
    curves
        What the line's torque is over its speed.
    curve
        Which of them each point is on.
    speed, torque : rad/s, N m
        Of the line there; nan where a state has no such point.
    running : (..., n-2) N
        What the bearings carry.
    """

    curves: Curves
    curve: IntArray
    speed: FloatArray
    torque: FloatArray
    running: Running

    def named(self, at: tuple[int, ...]) -> Point | None:
        """Return one of them; None where there is none."""
        curve, speed, torque = int(self.curve[at]), float(self.speed[at]), float(self.torque[at])
        if np.isnan(torque):
            return None
        return Point(self.curves.gears[curve], self.curves.directions[curve], speed, torque)


def _each(change: Callable[..., Any], *of: Points) -> Points:
    """Return points whose arrays are changed alike from those of others."""
    first = of[0]
    return Points(
        curves=first.curves,
        curve=change(*(p.curve for p in of)),
        speed=change(*(p.speed for p in of)),
        torque=change(*(p.torque for p in of)),
        running=Running(
            **{f.name: change(*(getattr(p.running, f.name) for p in of)) for f in fields(Running)}
        ),
    )


def held(r: "Response", *, assumed: float = LOSS) -> Suspended | None:
    """Return how a line can move on its rubber in each state; None where it cannot, or who knows.

    It needs a tube of each shaft for its mass, and a stiffness of one bearing. A loss factor
    that nobody gives is `assumed`.
    """
    bearings = [s.centre_bearing for s in r.line.shafts if s.centre_bearing]
    if any(s.tube is None for s in r.line.shafts) or all(b.stiffness is None for b in bearings):
        return None
    stiffness = [[*(b.stiffness or (np.inf, np.inf)), b.axial_stiffness or 0.0] for b in bearings]
    loss = [assumed if b.loss_factor is None else b.loss_factor for b in bearings]
    columns = np.broadcast_arrays(*(np.asarray(v, dtype=float) for row in stiffness for v in row))
    k = np.stack(columns, axis=-1).reshape(*columns[0].shape, len(bearings), 3)
    eta = np.stack(np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in loss)), axis=-1)
    return suspended(r.layout, r.line, stiffness=k, loss=eta)


def otherwise(r: "Response", assumed: float) -> Running:
    """Return what the bearings carry at the points of most orders with another loss factor."""
    p = r.worst["dynamic"]
    curve, speed = _apart(p)
    asked = demand_at(r.demand, p.curves, curve=curve, speed=speed)
    found = run(r, asked, r.lay(asked), on=held(r, assumed=assumed))

    def own(values: Any) -> Any:
        return np.stack([values[b, ..., b] for b in range(len(curve))], axis=-1)

    return Running(
        static=own(found.static),
        thrust=own(found.thrust),
        order1=own(found.order1),
        orders=np.stack([own(found.orders[..., k]) for k in range(3)], axis=-1),
    )


def run(
    r: "Response",
    of: Demand,
    layout: Layout,
    *,
    inertia: bool = True,
    on: Suspended | None = None,
) -> Running:
    """Return what the bearings carry under a demand, where the line then runs.

    On its own rubber, or on that of `on`.
    """
    known = np.isfinite(of.torque)
    found = running(
        layout,
        r.line,
        r.phases,
        torque=np.nan_to_num(of.torque),
        speed=np.nan_to_num(of.speed),
        held=on or r.held,
        inertias=r.inertias if inertia else None,
        gravity=r.gravity,
        slip=r.slip_at(of.torque),
        balanced_at=r.balanced_at if r.application.include_unbalance else None,
    )
    nothing = np.where(known, 0.0, np.nan)[..., None]
    return Running(
        static=found.static + nothing,
        thrust=found.thrust + nothing,
        order1=found.order1 + nothing,
        orders=found.orders + nothing[..., None],
    )


def worst(r: "Response") -> dict[str, Points]:
    """Return the point where each of `FORCES` is largest on each bearing, (..., S, n-2).

    Nothing where the line has no point, or no bearing. It is sought without the shafts'
    inertia, whose share is small where resonance is; what is found has it.
    """
    found = curves(r.demand)
    if not found.gears or r.line.joint_count < 3:
        return {}
    # Whatever varies shows in what the bearings carry at the states' own torques.
    cases = np.broadcast_shapes(found.fastest.shape[1:], r.running.peak.shape[:-1])
    found = _beside_variants(found, cases)
    best = _best(_at(r, found, *_candidates(r, found), inertia=False))
    ends = [_apart(p) for p in best.values()]
    if r.held is not None:
        ends.append(_crests(r, found, best))
    curve, speed = (np.concatenate(values) for values in zip(*ends, strict=True))
    return _best(_at(r, found, curve, speed))


def _candidates(r: "Response", found: Curves) -> tuple[IntArray, FloatArray]:
    """Return curves and speeds (P, ..., S) that may be worst, of each direction.

    The corners of the curve of most torque, the highest speed, and with most torque each
    speed at which an order meets a mode on rubber: order 2, and the first where unbalance
    counts.
    """
    standing = np.where(np.isnan(found.fastest), -1.0, np.abs(found.torque[..., 0]))
    standing = np.minimum(standing, found.most)
    reach = np.nan_to_num(found.fastest, nan=-1.0)
    corners, meets = found.corners(), _crossings(r, found)
    size = np.abs(found.torque_at(np.broadcast_to(meets[:, None], (len(meets), *reach.shape))))
    size = np.nan_to_num(size, nan=-1.0)
    curves_, speeds = [], []
    for direction in dict.fromkeys(found.directions):
        of = np.flatnonzero([d == direction for d in found.directions])
        strong, quick = (of[values[of].argmax(axis=0)] for values in (standing, reach))
        bends = np.take_along_axis(corners, strong[None, None], axis=1)[:, 0]
        top = np.take_along_axis(reach, quick[None], axis=0)
        curves_ += [
            np.broadcast_to(strong, bends.shape),
            quick[None],
            of[size[:, of].argmax(axis=1)],
        ]
        speeds += [bends, top, meets]
    if r.application.include_unbalance:  # grows with the speed, as torque falls from gear to gear
        curves_.append(_beside_cases(np.arange(len(reach)), reach))
        speeds.append(reach)
    return np.concatenate(curves_), np.concatenate(speeds)


def _beside_cases(values: IntArray, like: FloatArray) -> IntArray:
    """Return one number for each curve (C,) as (C, ..., S)."""
    return np.broadcast_to(values.reshape(-1, *(1,) * (like.ndim - 1)), like.shape)


def _crossings(r: "Response", found: Curves) -> FloatArray:
    """Return the speeds (Q, ..., S) at which an order meets a mode within reach."""
    cases = found.fastest.shape[1:]
    if r.held is None:
        return np.zeros((0, *cases))
    modes = r.held.modes().frequency
    frequency = np.moveaxis(np.broadcast_to(modes, (*cases, modes.shape[-1])), -1, 0)
    orders = (2, 1) if r.application.include_unbalance else (2,)
    meets = np.concatenate([frequency / k for k in orders])
    within = meets <= np.nanmax(found.fastest, initial=0.0)
    return meets[within.any(axis=tuple(range(1, meets.ndim)))]


def _crests(r: "Response", found: Curves, best: dict[str, Points]) -> tuple[IntArray, FloatArray]:
    """Return the points of largest forces beside those found, for each bearing: (P, ..., S).

    Where a mode alone shakes, 1/F² is a parabola over the square of the speed.
    """
    assert r.held is not None
    seeds = list(best.values())
    curve, speed = (np.concatenate(v) for v in zip(*map(_apart, seeds), strict=True))
    centre = np.concatenate([np.moveaxis(p.running.dynamic, -1, 0) for p in seeds])
    width = CLOSER * r.held.loss.min(axis=-1)  # as narrow as the narrowest mode
    speeds = np.stack([speed * (1 - width), speed * (1 + width)])
    sides = _at(r, found, np.concatenate([curve] * 2), np.concatenate(speeds), inertia=False)
    bearings = centre.shape[0] // len(seeds)
    own = (np.arange(len(sides.speed)) % bearings).reshape(-1, *(1,) * speed.ndim)
    before, after = np.split(np.take_along_axis(sides.running.dynamic, own, axis=-1)[..., 0], 2)
    with np.errstate(divide="ignore", invalid="ignore"):
        x = np.stack([speeds[0], speed, speeds[1]]) ** 2
        y = np.stack([before, centre, after]) ** -2.0
        slopes = np.diff(y, axis=0) / np.diff(x, axis=0)
        bend = (slopes[1] - slopes[0]) / (x[2] - x[0])
        crest = (x[0] + x[1]) / 2 - slopes[0] / (2 * bend)
    reach = x[2] - x[0]  # the crest of two modes that overlap lies outside
    crest = np.where(bend > 0, np.clip(crest, x[0] - reach / 2, x[2] + reach / 2), x[1])
    # What order 2 adds to the mean is largest half a width beside its own crest.
    ways = [np.sqrt(crest) * (1 + k * width / CLOSER) for k in (-0.5, -0.25, 0.0, 0.25, 0.5)]
    return np.concatenate([curve] * len(ways)), np.concatenate(ways)


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
    r: "Response", found: Curves, curve: IntArray, speed: FloatArray, *, inertia: bool = True
) -> Points:
    """Return what the bearings carry at points, their curves and speeds (P, ..., S)."""
    asked = demand_at(r.demand, found, curve=curve, speed=speed)
    return Points(
        curves=found,
        curve=np.broadcast_to(curve, asked.speed.shape),
        speed=asked.speed,
        torque=asked.torque,
        running=run(r, asked, r.lay(asked), inertia=inertia),
    )


def _best(p: Points) -> dict[str, Points]:
    """Return the point where each force is largest, of each bearing by itself, (..., S, n-2)."""
    found: dict[str, Points] = {}
    for name in FORCES:
        value = getattr(p.running, name)
        at = np.where(np.isnan(value), -1.0, value).argmax(axis=0)[None]

        def taken(values: Any, at: IntArray = at) -> Any:
            if values.ndim < at.ndim:  # of points, not of their bearings
                values = np.broadcast_to(values[..., None], (len(values), *at.shape[1:]))
            at = at if values.ndim == at.ndim else at[..., None]
            return np.take_along_axis(values, at, axis=0)[0]

        found[name] = _each(taken, p)
    return found


def _apart(p: Points) -> tuple[IntArray, FloatArray]:
    """Return curves and speeds of the points of each bearing, (n-2, ..., S)."""
    return np.moveaxis(p.curve, -1, 0), np.moveaxis(p.speed, -1, 0)
