"""What a reader should know: where an application contradicts itself, what is assumed."""

from collections.abc import Iterable, Iterator
from typing import Literal

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.frozen import dataclass
from cardan.base.units import Metre, mm
from cardan.base.verdict import EQUAL
from cardan.demand.suspension import spring_load, table_rates
from cardan.loads.rubber import LOSS
from cardan.model.application import Application
from cardan.model.vehicle import Spring, Suspension
from cardan.quantity import points
from cardan.quantity.quantities import QUANTITIES
from cardan.quantity.response import Response

MISMATCH = 0.005
"""Share by which stated rates may miss the loads of their table before it is worth a word."""

LINEAR = 10 * mm
"""How far the rubber of a centre bearing may be taken to go without stiffening: house practice."""

OTHERWISE = (LOSS / 2, 2 * LOSS)
"""Loss factors between which rubber mounts lie."""


@dataclass(frozen=True, kw_only=True)
class SpringMismatch:
    """A spring whose drawing states rates that do not give the loads of its own table.

    `apart` is the largest difference of load, as a share of the table's, at `deflection`;
    `stated` and `table` are the rates of both, N/m.
    """

    stated: tuple[float, ...]
    table: tuple[float, ...]
    apart: float
    deflection: Metre

    def __str__(self) -> str:
        """Return the mismatch as a sentence without its end."""
        stated, table = (
            " and ".join(f"{rate * mm:.4g}" for rate in rates)
            for rates in (self.stated, self.table)
        )
        return (
            f"a spring's stated {stated} N/mm are {100 * self.apart:+.1f} % off the load of its "
            f"own table at {self.deflection / mm:.4g} mm, which rises by {table} N/mm and counts"
        )


def spring_mismatch(spring: Spring) -> SpringMismatch | None:
    """Return how far stated rates are from a spring's table as a whole; None where they agree.

    Where fewer rates are stated than the table has slopes, a second one starts where the
    table's first slope ends.
    """
    stated, rates = spring.stated_rates, table_rates(spring)
    if not stated:
        return None
    at = np.asarray(spring.deflection, dtype=float)
    starts = at[: len(stated)]
    slope = np.asarray(stated, dtype=float)[: len(starts)]
    ends = np.append(starts[1:], np.inf)
    reach = np.clip(at[:, None], starts, ends) - starts
    carried = float(spring.load[0]) + reach @ slope
    table = spring_load(spring, at)
    apart = np.divide(carried, table, out=np.ones_like(table), where=table > 0) - 1
    worst = int(np.argmax(np.abs(apart)))
    if abs(apart[worst]) <= MISMATCH:
        return None
    return SpringMismatch(
        stated=tuple(stated),
        table=tuple(rates.tolist()),
        apart=float(apart[worst]),
        deflection=float(at[worst]),
    )


@dataclass(frozen=True, kw_only=True)
class AssumedLoss:
    """What rests on a loss factor that nobody gave: the largest dynamic force on a bearing.

    `forces` are those with `factors` in its place, N, at the same point.
    """

    line: str
    bearing: int
    state: str
    factor: float
    force: float
    factors: tuple[float, float]
    forces: tuple[float, float]

    def __str__(self) -> str:
        """Return it as a sentence without its end."""
        low, high = self.factors
        return (
            f"the rubber's loss factor {self.factor:g} is assumed: centre bearing "
            f"{self.bearing} of line {self.line} carries {self.force:.4g} N in {self.state}, "
            f"with {low:g} it would be {self.forces[0]:.4g} N, with {high:g} {self.forces[1]:.4g} N"
        )


def assumed_losses(responses: Iterable[Response]) -> Iterator[AssumedLoss]:
    """Yield, line by line, what rests on a loss factor that nobody gave."""
    for r in responses:
        bearings = [s.centre_bearing for s in r.line.shafts if s.centre_bearing]
        given = all(b.stiffness is None or b.loss_factor is not None for b in bearings)
        if given or r.held is None or "dynamic" not in r.worst or r.layout.points.ndim > 3:
            continue
        force = QUANTITIES["centre_bearing_dynamic"].values(r)
        if np.isnan(force).all():  # of a line whose speed nobody knows, or that swings
            continue
        s, k = np.unravel_index(int(np.nanargmax(force)), force.shape)
        less, more = points.otherwise(r, np.array(OTHERWISE)[:, None]).dynamic[:, s, k].tolist()
        yield AssumedLoss(
            line=r.line.name,
            bearing=int(k) + 1,
            state=r.demand.states[s],
            factor=LOSS,
            force=float(force[s, k]),
            factors=OTHERWISE,
            forces=(less, more),
        )


@dataclass(frozen=True, kw_only=True)
class GivingRubber:
    """How far a line moves on its rubber, taken as linear and without a stop.

    Clearances leave it out. Of the centre bearing that moves most `steady` is how far torque
    and thrust set it off, `moves` that with what shakes it besides. `clearance` is the smallest
    of the line in that state, nan where nothing is in its way.
    """

    line: str
    bearing: int
    state: str
    steady: Metre
    moves: Metre
    clearance: Metre

    def __str__(self) -> str:
        """Return it as a sentence without its end."""
        said = (
            "rubber is taken as linear and without a stop: centre bearing "
            f"{self.bearing} of line {self.line} moves by up to {self.moves / mm:.3g} mm in "
            f"{self.state}, {self.steady / mm:.3g} mm of it steadily"
        )
        if np.isnan(self.clearance):
            return said
        return (
            f"{said}; clearances leave that out, the smallest there is {self.clearance / mm:.4g} mm"
        )


def giving_rubber(responses: Iterable[Response]) -> Iterator[GivingRubber]:
    """Yield, line by line, how far rubber gives: if much, or if something is in the way.

    What has a stop that somebody knows is held against that, and told here where something is in
    the way alone.
    """
    for r, moves in _travels(responses):
        told = moves if r.obstacles else np.where(np.isnan(r.stops), moves, np.nan)
        if np.isnan(told).all():
            continue
        s, k = np.unravel_index(int(np.nanargmax(told)), told.shape)
        if r.obstacles or told[s, k] > LINEAR:
            assert r.worst_travel is not None  # or nothing moves
            yield GivingRubber(
                line=r.line.name,
                bearing=int(k) + 1,
                state=r.demand.states[s],
                steady=float(r.worst_travel.running.static[s, k]),
                moves=float(told[s, k]),
                clearance=_least_clearance(r, int(s)),
            )


@dataclass(frozen=True, kw_only=True)
class BeyondStop:
    """A centre bearing that meets its stop in some states, and by how much it would pass it.

    `moves` is how far it would go at most, `stop` how far its rubber does.
    """

    line: str
    bearing: int
    states: tuple[str, ...]
    moves: Metre
    stop: Metre

    def __str__(self) -> str:
        """Return it as a sentence without its end."""
        return (
            f"centre bearing {self.bearing} of line {self.line} goes beyond its stop in "
            f"{', '.join(self.states)}: up to {self.moves / mm:.3g} mm, where its rubber has "
            f"{self.stop / mm:.3g}; forces on rubber there are those of rubber that goes on"
        )


def beyond_stops(responses: Iterable[Response]) -> Iterator[BeyondStop]:
    """Yield the centre bearings that would go on where their rubber ends."""
    for r, moves in _travels(responses):
        for k, stop in enumerate(np.broadcast_to(r.stops, moves.shape[-1:]).tolist()):
            beyond = moves[:, k] > stop * (1 + EQUAL)
            if beyond.any():
                yield BeyondStop(
                    line=r.line.name,
                    bearing=k + 1,
                    states=tuple(
                        s for s, far in zip(r.demand.states, beyond.tolist(), strict=True) if far
                    ),
                    moves=float(np.nanmax(moves[:, k])),
                    stop=stop,
                )


def _travels(responses: Iterable[Response]) -> Iterator[tuple[Response, FloatArray]]:
    """Yield lines on rubber, and how far each bearing goes across its own, (S, n-2) m."""
    for r in responses:
        if r.held is None or r.worst_travel is None or r.layout.points.ndim > 3:
            continue
        # Of a line whose speed nobody knows, or that swings, no force has an answer.
        known = np.isfinite(QUANTITIES["centre_bearing_peak"].values(r))
        if known.any():
            yield r, np.where(known, r.worst_travel.running.peak, np.nan)


def _least_clearance(r: Response, state: int) -> float:
    """Return the smallest clearance in a state, at any of its points, m; nan without obstacles."""
    asked = (r, *((r.spread.response,) if r.spread else ()))
    gaps = [one.clearances[..., state, :, :].ravel() for one in asked]
    return float(np.nanmin(np.concatenate(gaps))) if r.obstacles else np.nan


@dataclass(frozen=True, kw_only=True)
class LiftedAxle:
    """States in which the front axle would lift before the driven wheels of a line slip.

    Slip torque is then what the whole weight on the driven wheels holds.
    """

    states: tuple[str, ...]

    def __str__(self) -> str:
        """Return it as a sentence without its end."""
        return (
            f"the front axle would lift before the driven wheels slip in {', '.join(self.states)}: "
            "the slip torque is what the whole weight on them holds"
        )


def lifted_axles(responses: Iterable[Response]) -> Iterator[LiftedAxle]:
    """Yield in which states a front axle lifts, once for all lines that ask the same."""
    seen = set[tuple[str, ...]]()
    for r in responses:
        if r.demand.standing.line.vehicle is None:
            continue
        rest, slip = (np.asarray(load)[..., 0] for load in r.axle_loads)
        lifts = (rest > 0) & (slip <= 0)
        states = tuple(s for s, up in zip(r.demand.states, lifts.tolist(), strict=True) if up)
        if states and states not in seen:
            seen.add(states)
            yield LiftedAxle(states=states)


@dataclass(frozen=True, kw_only=True)
class NotDriven:
    """A way in which a vehicle can be driven, and that no point asks, as the file lacks a number.

    `way` is coast, where nobody knows what holds back, or reverse, where nobody gives its ratio.
    """

    way: Literal["coast", "reverse"]

    def __str__(self) -> str:
        """Return it as a sentence without its end."""
        return NOT_DRIVEN[self.way]


NOT_DRIVEN = {
    "coast": "coasting is not asked, and the swing of a joint's torque starts from 0: brake_torque "
    "of the engine, retarder_torque of the gearbox or coast_torque would say what holds back",
    "reverse": "backing is not asked: reverse_ratio of the gearbox would say its torque",
}


def not_driven(responses: Iterable[Response]) -> Iterator[NotDriven]:
    """Yield the ways in which a vehicle is driven by its engine, and some line is not asked."""
    of = [
        r.demand for r in responses
        if (line := r.demand.standing.line).engine is not None and line.vehicle is not None
        and line.torque is None
    ]  # fmt: skip
    if any(np.isnan(d.coast_torque).all() for d in of):
        yield NotDriven(way="coast")
    if any(d.standing.line.reverse is None for d in of):
        yield NotDriven(way="reverse")


def mismatches(application: Application) -> Iterator[SpringMismatch]:
    """Yield the springs of an application that contradict themselves, each once."""
    seen: list[Suspension] = []
    for s in (application.suspension, *(i.suspension for i in application.lines)):
        if s is not None and not any(s is other for other in seen):
            seen.append(s)
            if found := spring_mismatch(s.spring):
                yield found
