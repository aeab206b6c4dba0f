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

CLOSER = (0.25, 0.06)
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


def held(r: "Response") -> Suspended | None:
    """Return how a line can move on its rubber in each state; None where it cannot, or who knows.

    It needs a tube of each shaft for its mass, and a stiffness of one bearing.
    """
    bearings = [s.centre_bearing for s in r.line.shafts if s.centre_bearing]
    if any(s.tube is None for s in r.line.shafts) or all(b.stiffness is None for b in bearings):
        return None
    stiffness = [[*(b.stiffness or (np.inf, np.inf)), b.axial_stiffness or 0.0] for b in bearings]
    loss = [LOSS if b.loss_factor is None else b.loss_factor for b in bearings]
    columns = np.broadcast_arrays(*(np.asarray(v, dtype=float) for row in stiffness for v in row))
    k = np.stack(columns, axis=-1).reshape(*columns[0].shape, len(bearings), 3)
    eta = np.stack(np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in loss)), axis=-1)
    return suspended(r.layout, r.line, stiffness=k, loss=eta)


def run(r: "Response", of: Demand, layout: Layout, *, inertia: bool = True) -> Running:
    """Return what the bearings carry under a demand, where the line then runs."""
    known = np.isfinite(of.torque)
    found = running(
        layout,
        r.line,
        r.phases,
        torque=np.nan_to_num(of.torque),
        speed=np.nan_to_num(of.speed),
        held=r.held,
        inertias=r.inertias if inertia else None,
        gravity=r.gravity,
        slip=r.slip_at(of.torque),
        balanced_at=np.nan_to_num(r.demand.speed) if r.application.include_unbalance else None,
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
    inertia, whose share is small where resonance is; what is found has it. Of variants only
    the curves of most torque are asked, at their ends and where order 2 meets a mode.
    """
    found = curves(r.demand)
    if not found.gears or r.line.joint_count < 3:
        return {}
    many = r.layout.points.ndim > 3
    cases = np.broadcast_shapes(found.fastest.shape[1:], r.layout.points.shape[:-2])
    found = _beside_variants(_strongest(found) if many else found, cases)
    corners = np.stack([0 * found.fastest, found.fastest]) if many else found.corners()
    tried = [found.points(corners), *_crossings(r, found, many=many)]
    best = _best(_at(r, found, *_together(tried), inertia=False))
    loss = 0.0 if many or r.held is None else float(r.held.loss.max())
    for width in CLOSER if loss else ():
        closer = _together([_beside(p, width * loss) for p in best.values()])
        again = _best(_at(r, found, *closer, inertia=False))
        best = {name: _better(name, best[name], again[name]) for name in FORCES}
    return _best(_at(r, found, *_together([_apart(p) for p in best.values()])))


def _strongest(found: Curves) -> Curves:
    """Return of each direction the curve that starts with most torque in any state."""
    size = np.abs(np.where(np.isnan(found.fastest), 0.0, found.torque[..., 0]))
    size = np.minimum(size, found.most).reshape(len(found.gears), -1).max(axis=-1)
    of: dict[str, int] = {}
    for c in np.argsort(-size).tolist():
        of.setdefault(found.directions[c], c)
    keep = sorted(of.values())
    return Curves(
        gears=tuple(found.gears[c] for c in keep),
        directions=tuple(found.directions[c] for c in keep),
        speed=found.speed[keep],
        torque=found.torque[keep],
        most=found.most[keep],
        fastest=found.fastest[keep],
    )


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


def _together(points: list[tuple[IntArray, FloatArray]]) -> tuple[IntArray, FloatArray]:
    """Return curves and speeds (P, ..., S) of several sets of points in one row."""
    cases = np.broadcast_shapes(*(speed.shape[1:] for _, speed in points))

    def row(values: Any) -> Any:
        values = values.reshape(*values.shape, *(1,) * (1 + len(cases) - values.ndim))
        return np.broadcast_to(values, (len(values), *cases))

    curve, speed = ([row(values) for values in each] for each in zip(*points, strict=True))
    return np.concatenate(curve), np.concatenate(speed)


def _crossings(r: "Response", found: Curves, *, many: bool) -> list[tuple[IntArray, FloatArray]]:
    """Return points at which an order meets a mode: of each direction, that of most torque.

    Of variants the modes on rubber with order 2, else all that are met, with unbalance too.
    """
    if r.held is None:
        return []
    frequency = np.moveaxis(r.held.modes().frequency, -1, 0)
    meets = frequency / 2
    if many:
        meets = meets[: 2 * (r.line.joint_count - 2)]
    elif r.application.include_unbalance:
        meets = np.concatenate([meets, frequency])
    cases = found.fastest.shape[1:]
    meets = np.broadcast_to(meets, (len(meets), *cases))
    meets = meets[(meets <= np.nanmax(found.fastest)).any(axis=tuple(range(1, meets.ndim)))]
    size = np.abs(
        found.torque_at(np.broadcast_to(meets[:, None], (len(meets), *found.fastest.shape)))
    )
    size = np.where(np.isnan(size), -1.0, size)
    points: list[tuple[IntArray, FloatArray]] = []
    for direction in dict.fromkeys(found.directions):
        of = np.flatnonzero([d == direction for d in found.directions])
        points.append((of[size[:, of].argmax(axis=1)], meets))
    return points


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


def _beside(p: Points, width: float) -> tuple[IntArray, FloatArray]:
    """Return curves and speeds (P, ..., S) a little beside the points of each bearing."""
    steps = 1 + width * np.array([-1.0, -0.5, 0.5, 1.0])
    curve, speed = _apart(p)
    speeds = (steps.reshape(-1, *(1,) * speed.ndim) * speed).reshape(-1, *speed.shape[1:])
    return np.concatenate([curve] * len(steps)), speeds


def _better(name: str, one: Points, other: Points) -> Points:
    """Return the point of two at which a force is larger, of each bearing by itself."""
    first, second = (np.nan_to_num(getattr(p.running, name), nan=-1.0) for p in (one, other))
    take = second > first

    def chosen(a: Any, b: Any) -> Any:
        return np.where(take if a.ndim == take.ndim else take[..., None], b, a)

    return _each(chosen, one, other)
