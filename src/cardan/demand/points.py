"""What torque, speed and geometry a line has together: its operating points, state by state.

Torque and speed that cannot occur together prove nothing, and angles belong to a torque: the
axle winds up under it. `curves` says what torque each gear and direction has over the line's
speed in each state; `demand_at` lays the line out at points of them.

Points come first, then curves where there are all of them, then the variants of a study, and
the states last: so the numbers of a line, which come as (V, 1), stand beside all of it.
"""

from collections.abc import Iterator
from dataclasses import field
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np

from cardan.base.arrays import ArrayLike, BoolArray, FloatArray, IntArray, own, stacked, steps
from cardan.base.frozen import dataclass
from cardan.demand.line import ResolvedLine
from cardan.demand.motion import Ride
from cardan.demand.states import Demand, demand_under, on_axle_under, ride_under, said_speed
from cardan.demand.torque import Gears, brake_torques, from_standstill

Direction: TypeAlias = Literal["drive", "coast", "reverse", "brake"]
"""The engine drives ahead or is driven; it drives astern; the brakes hold while it is driven."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Curves:
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
        Above 0 in drive, below in coast, braking and reverse; straight between corners, its
        size never rising. What the tyres hold is not in it.
    most : (C, ..., S) N m
        Size of torque that the tyres hold there; inf where nobody knows, or it is no matter.
    fastest : (C, ..., S) rad/s
        Where the curve ends in a state; nan where that state has no such points.
    """

    gears: tuple[str, ...]
    directions: tuple[Direction, ...]
    speed: FloatArray
    torque: FloatArray
    most: FloatArray
    fastest: FloatArray

    def torque_at(self, speed: ArrayLike) -> FloatArray:
        """Return the torque at speeds (Q, C, ..., S) rad/s, N m; nan where a curve has none."""
        return _torque(np.asarray(speed, dtype=float), *self._all)

    def shown(self, state: int) -> list[int]:
        """Return the curves (C, S) to draw of a state: those that drive it, or else brake it."""
        moves = np.flatnonzero(self.fastest[:, state] > 0).tolist()
        drives = [k for k in moves if self.directions[k] in ("drive", "reverse")]
        return drives or [k for k in moves if self.directions[k] == "brake"]

    def of(self, which: IntArray) -> "Curves":
        """Return some of the curves."""
        return Curves(
            gears=tuple(self.gears[k] for k in which.tolist()),
            directions=tuple(self.directions[k] for k in which.tolist()),
            speed=self.speed[which],
            torque=self.torque[which],
            most=self.most[which],
            fastest=self.fastest[which],
        )

    @property
    def _all(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        return self.speed, self.torque, self.most, self.fastest

    @cached_property
    def corners(self) -> FloatArray:
        """Speeds (Q, C, ..., S) rad/s where a curve starts, bends or ends; rising.

        A curve bends where its line does and where it meets what the tyres hold. Between
        neighbours it is straight, so no torque is larger than at its corners. nan fills up.
        """
        x, size, most, end = self.speed, np.abs(self.torque), self.most[..., None], self.fastest
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

    def points(self, speed: ArrayLike) -> tuple[IntArray, FloatArray]:
        """Return the points that speeds (Q, C, ..., S) make, in one row.

        Which curve each is on, (P,), and its speed (P, ..., S); where no state has the
        point it is left out, and where some has not its speed is nan there.
        """
        x = np.asarray(speed, dtype=float)
        x = np.where((x >= 0) & (x <= self.fastest), x, np.nan)
        some = ~np.isnan(x).all(axis=tuple(range(2, x.ndim)))
        _, curve = np.nonzero(some)
        return curve, x[some]


@dataclass(frozen=True, kw_only=True, eq=False)
class Placed:
    """Points of a line's curves, (P, ..., S).

    Attributes
    ----------
    curves, curve
        The curves, and which of them each point is on.
    speed, torque : rad/s, N m
        nan where a curve has no such point.
    """

    curves: Curves
    curve: IntArray
    speed: FloatArray
    torque: FloatArray

    @property
    def sense(self) -> FloatArray:
        """-1 where the line turns backwards, else 1."""
        return np.where(self.turns("reverse"), -1.0, 1.0)

    def turns(self, direction: Direction) -> BoolArray:
        """Return where the line is turned in a direction."""
        return np.array([d == direction for d in self.curves.directions])[self.curve]

    def named(self, case: tuple[int, ...]) -> str:
        """Return one of them in words, for errors."""
        k = int(self.curve[case])
        gear = f" in gear {self.curves.gears[k]}" if self.curves.gears[k] else ""
        return f"{self.curves.directions[k]}{gear} with {self.torque[case]:.4g} N m"


def placed(found: Curves, *, curve: ArrayLike, speed: ArrayLike) -> Placed:
    """Return points of curves, by which curve each is on, (P,) or (P, ..., S), and its speed."""
    speed = np.asarray(speed, dtype=float)
    speed = np.broadcast_to(speed, np.broadcast_shapes(speed.shape, found.fastest.shape[1:]))
    curve = np.asarray(curve)
    curve = np.broadcast_to(
        curve.reshape(*curve.shape, *(1,) * (speed.ndim - curve.ndim)), speed.shape
    )

    here = curve, *steps(curve.shape)[1:]
    each = (found.speed, found.torque, found.most, found.fastest)
    torque = _torque(speed, *(_taken(v, here) for v in each))
    speed = np.where(np.isnan(torque), np.nan, speed)
    return Placed(curves=found, curve=curve, speed=speed, torque=torque)


def demand_at(asked: Demand, found: Curves, *, curve: ArrayLike, speed: ArrayLike) -> Demand:
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
    at = placed(found, curve=curve, speed=speed)
    return demand_under(
        asked, torque=at.torque, speed=at.speed, sense=at.sense,
        coasts=at.turns("coast"), brakes=at.turns("brake"), named=at.named,
    )  # fmt: skip


def ride_at(asked: Demand, at: Placed) -> Ride:
    """Return how the axle rides at points of a line's curves, (P, ..., S)."""
    return ride_under(asked, at.torque, coasts=at.turns("coast"), brakes=at.turns("brake"))


def on_axle_at(asked: Demand, at: Placed) -> FloatArray:
    """Return the torque on the axle's housing there, (P, ..., S) N m; 0 where nobody knows it."""
    brakes, coasts = at.turns("brake"), at.turns("coast")
    return np.nan_to_num(on_axle_under(asked, at.torque, coasts=coasts, brakes=brakes))


def _torque(
    x: FloatArray, speed: FloatArray, torque: FloatArray, most: FloatArray, fastest: FloatArray
) -> FloatArray:
    """Torque at speeds (..., S) of curves (..., S, E); nan where they have none."""
    speed, torque, most, fastest = (own(v) for v in (speed, torque, most, fastest))
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


def _taken(values: FloatArray, here: tuple[IntArray, ...]) -> FloatArray:
    """Return values (C, ..., S) or corners (C, ..., S, E) at points; each corner by itself."""
    if values.ndim == len(here):
        return values[here]
    return stacked(values[..., k][here] for k in range(values.shape[-1]))


# --------------------------------------------------------------------------- curves


@dataclass(frozen=True, kw_only=True)
class _Curve:
    """One curve, of shapes that `curves` makes alike: (..., S or 1, E) and (..., S)."""

    gear: str
    direction: Direction
    speed: FloatArray
    torque: FloatArray
    most: FloatArray = field(default_factory=lambda: np.asarray(np.inf))
    fastest: FloatArray


def curves(asked: Demand) -> Curves:
    """Return the torque over speed that a line can have in each state.

    In drive and reverse each gear gives its largest torque from standstill, a clutch slipping
    or a converter stalled, then what full load gives up to governed speed; in coast and
    braking it holds with engine brake and retarder, as much at any speed that the gear
    reaches; tyres hold no more than their grip.
    What a state or the application says replaces it: a torque that of all gears in drive, a
    coast torque that in coast, and no point is faster than a speed said. A wind-up state has
    drive, a brake wind-up state braking alone; others all that is known, braking where the
    suspension's `brake_torque` is given.

    Notes
    -----
    A converter's stall ratio counts at any speed, and coast and braking take the engine
    brake's largest torque at any speed of a gear: upper bounds. Where nobody knows a speed
    the line stands still. Part load is not asked. Derived from Souza (2014), eq. 1 to 3.
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

    return Curves(
        gears=tuple(c.gear for c in found),
        directions=tuple(c.direction for c in found),
        speed=alike([c.speed for c in found], most),
        torque=alike([c.torque for c in found], most),
        most=alike([np.where(np.isnan(c.most), np.inf, c.most) for c in found]),
        fastest=alike([c.fastest for c in found]),
    )


def _filled(values: FloatArray, size: int) -> FloatArray:
    """Return corners (..., E) with the last repeated to (..., size)."""
    last = np.repeat(values[..., -1:], size - values.shape[-1], axis=-1)
    return np.concatenate([values, last], axis=-1)


def _driven(asked: Demand) -> BoolArray:
    """Where the axle is not wound up by definition, (S,)."""
    line = asked.standing.line
    return ~(line.winds("windup") | line.winds("windup brake"))


def _level(
    asked: Demand, direction: Direction, torque: FloatArray, *, there: BoolArray
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
    asked: Demand,
    direction: Direction,
    gears: Gears,
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
    said, reach = said_speed(asked.standing.line), speed[..., -1]
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


def _drive(asked: Demand) -> Iterator[_Curve]:
    line = asked.standing.line
    there = ~line.winds("windup brake")
    said = np.array([(s.torque is not None) or (line.torque is not None) for s in line.states])
    if line.gears is None:
        yield from _level(asked, "drive", asked.torque, there=there)
        return
    if said.any():
        yield from _level(asked, "drive", asked.torque, there=there & said)
    speed, torque = from_standstill(line.gears.speed, line.gears.torque)
    yield from _geared(
        asked, "drive", line.gears, torque, speed, most=asked.slip_torque, there=there & ~said
    )
    rolls = there & ~said & (said_speed(line) > speed[..., -1].max(-1))
    if rolls.any():  # faster than any gear drives it the line rolls without torque
        yield from _level(asked, "drive", 0.0 * asked.torque, there=rolls)


def _coast(asked: Demand) -> Iterator[_Curve]:
    there = _driven(asked)
    if (held := _held_back(asked.standing.line)) is None:
        yield from _level(asked, "coast", 0.0 - asked.coast_torque, there=there)
    elif not np.isnan(held[1]).any():
        yield from _geared(asked, "coast", *held, most=asked.standing.slip_back, there=there)


def _held_back(line: ResolvedLine) -> tuple[Gears, FloatArray, FloatArray] | None:
    """Return gears, torques and speeds (..., G, 2) at which each holds a line back.

    None where a coast torque is said, or nobody knows the gears.
    """
    if line.engine is None or line.gears is None or line.coast_torque is not None:
        return None
    held = np.asarray(line.share)[..., None] * brake_torques(line.engine, line.gearbox)
    both = np.broadcast_arrays(held, line.gears.speed.max(-1))
    torque, reach = (np.stack([v, v], axis=-1) for v in both)
    return line.gears, 0.0 - torque, reach * (0.0, 1.0)


def _reverse(asked: Demand) -> Iterator[_Curve]:
    line = asked.standing.line
    if line.reverse is None:
        return
    speed, torque = from_standstill(line.reverse.speed, line.reverse.torque)
    yield from _geared(
        asked, "reverse", line.reverse, 0.0 - torque, speed,
        most=asked.standing.slip_reverse, there=_driven(asked),
    )  # fmt: skip


def _brake(asked: Demand) -> Iterator[_Curve]:
    line = asked.standing.line
    wound = line.winds("windup brake")
    given = np.asarray(line.suspension.brake_torque if line.suspension else 0.0) > 0
    there = wound | (given & ~line.winds("windup"))
    coasting = np.nan_to_num(np.where(wound, asked.torque, 0.0 - asked.coast_torque))
    held = _held_back(line)
    if held is None or np.isnan(held[1]).any():
        yield from _level(asked, "brake", coasting, there=there)
        return
    said = wound & np.array([s.torque is not None for s in line.states])
    if said.any():
        yield from _level(asked, "brake", coasting, there=there & said)
    yield from _geared(asked, "brake", *held, most=np.abs(coasting), there=there & ~said)
