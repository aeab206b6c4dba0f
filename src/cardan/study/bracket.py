"""Judge a bracket: the driveline's own loads in it, stresses, gauges, modes, life, a variant.

Everything follows from the unit solutions by adding them up, so a load case costs no solve.
What the bearing hands to its bracket follows the line on its rubber where the stiffness of
that is known. The bracket itself bears it quasi-statically: the load of an order is right
below its natural frequencies, which stand beside it.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.errors import DesignError
from cardan.base.part import Occasion, Part, Point
from cardan.base.units import Metre, RadianPerSecond, hour
from cardan.base.verdict import Check, Limit, Unanswered
from cardan.bracket.elastic import Progress
from cardan.bracket.elastic import silent as hushed
from cardan.bracket.gauges import influence
from cardan.bracket.hotspot import Converged, Searched, converged, hot_spots, searched
from cardan.bracket.shape import solid
from cardan.bracket.stress import (
    Extreme,
    along,
    critical_direction,
    envelope,
    extremes,
    superpose,
    von_mises,
)  # fmt: skip
from cardan.bracket.unit import UNITS, Units, unit_solutions
from cardan.demand.states import demand, demand_under, resolve
from cardan.loads.cycle import Cycle
from cardan.model.application import RIDING, Application
from cardan.model.bracket import Bracket, Shape
from cardan.quantity.points import run
from cardan.quantity.response import Response, respond
from cardan.study.bracket_life import Endured, Strength, endured, mixed
from cardan.study.finding import BRACKET, Finding, Tell, limits_of

SAMPLES = 32
"""Angles of half a turn, in which loads of order 2 come back: a peak is met to 0.5 %."""
ORDERS = (1, 2, 4)
"""Unbalance; joints; joints at large angles."""
HOT_SPOTS = 3


@dataclass(frozen=True)
class Case:
    """A load history on the bearing, (t, 9) as in `cardan.bracket.unit.UNITS`.

    Where `turns` of the shaft or `duration` (s) are known it is one pass of a history that
    repeats, and does damage; else a load by itself. `places` counts passes one after the
    other of which only the worst happens. A case of a state is called after it and `what`
    it takes of its loads.
    """

    name: str
    loads: FloatArray
    turns: float = np.nan
    duration: float = np.nan
    places: int = 1
    what: str = ""
    point: Point | None = None
    """The operating point whose loads these are, where it is not the state's own."""

    @property
    def when(self) -> Occasion:
        """The case as an occasion of checks."""
        return Occasion("case", self.name, self.what)

    @property
    def repeats(self) -> bool:
        """Whether it is a pass of something, and no load by itself."""
        return not (np.isnan(self.turns) and np.isnan(self.duration))


@dataclass(frozen=True, slots=True)
class Found:
    """A stress and where it is."""

    value: float
    point: tuple[Metre, Metre, Metre]


@dataclass(frozen=True)
class Outcome:
    """What one case does to one bracket.

    Attributes
    ----------
    von_mises, highest, lowest : Found
        Extremes away from sharp edges: equivalent, largest tension, largest compression.
    on_edge : Found
        Largest von Mises stress anywhere. Where it exceeds `von_mises` it sits on a sharp
        edge and depends on the mesh alone.
    hot, error : (k,) Pa
        Largest von Mises stress at each hot spot, converged, and its estimated error.
    mean, amplitude : (k,) Pa
        Of the normal stress at each hot spot, on the plane where it swings most.
    strain : (gauges, 2)
        Smallest and largest reading.
    bolts : (b,) N
        Largest force on each bolt.
    motion : Metre
        Largest movement of the seat under the bearing.
    life : Endured
        Damage and life; None without an S-N curve, or of a load by itself.
    """

    case: Case
    von_mises: Found
    highest: Found
    lowest: Found
    on_edge: Found
    hot: FloatArray
    error: FloatArray
    mean: FloatArray
    amplitude: FloatArray
    strain: FloatArray
    bolts: FloatArray
    motion: Metre
    life: Endured | None = None


@dataclass(frozen=True, slots=True)
class Crossing:
    """A natural frequency that an order of the shaft's speed meets."""

    mode: int
    frequency: float
    order: int
    speed: RadianPerSecond
    in_range: bool
    """Whether that speed is one the shaft reaches."""


@dataclass(frozen=True, kw_only=True)
class Judged:
    """One shape of a bracket, judged.

    Attributes
    ----------
    units : Units
        The first solution, whose mesh is drawn.
    hot_spots : Converged
        Unit stresses at the hot spots.
    influence : (gauges, 9)
        Strain of each gauge under each unit load, from the best solution.
    influence_change : float
        Largest change of those since the first solution, over the largest of them.
    frequencies, carried : (6,) Hz
        Natural frequencies of the bracket by itself, and with the mass it carries.
    duty : Endured
        A mean second of the application's duty cycle, in each state that lasts.
    """

    name: str
    units: Units
    hot_spots: Converged
    influence: FloatArray
    influence_change: float
    frequencies: FloatArray
    carried: FloatArray
    crossings: tuple[Crossing, ...]
    outcomes: tuple[Outcome, ...]
    duty: tuple[Endured, ...] = ()

    @property
    def mass(self) -> float:
        """Mass, kg."""
        return self.units.mass

    @property
    def worst(self) -> Outcome:
        """The case with the highest converged stress at a hot spot."""
        return max(self.outcomes, key=lambda o: float(o.hot.max()))


@dataclass(frozen=True, kw_only=True)
class BracketAnswer:
    """A bracket judged, and its reinforced variant beside it where there is one."""

    title: str
    bracket: Bracket
    top_speed: RadianPerSecond
    variants: tuple[Judged, ...]


def judged(
    application: Application, *, extra: Sequence[Case], tell: Tell
) -> Finding[BracketAnswer]:
    """Judge an application's bracket, and hold the shape that is installed against the limits.

    Raises
    ------
    DesignError
        If the application has no bracket, or its shape cannot be built or meshed.
    NotInstalled
        Without the extra `cardan[bracket]`.
    """
    answer = study(application, extra=extra, tell=lambda said: tell(said, 0, 0))
    limits = limits_of(BRACKET, application)
    installed = answer.variants[0]
    return Finding(
        study=BRACKET,
        answer=answer,
        checks=tuple(checks_of(answer, installed, limits)),
        unanswered=tuple(_unanswered(answer, installed, limits)),
    )


def study(
    application: Application, *, extra: Sequence[Case] = (), tell: Progress = hushed
) -> BracketAnswer:
    """Return what an application's bracket bears, and its reinforced variant beside it."""
    bracket = _bracket(application)
    installed = next(i for i in application.lines if i.line.name == bracket.line)
    response = respond(application, demand(resolve(application, installed)))
    cases = (*cases_of(bracket, response), *extra)
    speeds = response.demand.speed
    top = float(np.nanmax(speeds)) if np.isfinite(speeds).any() else np.nan
    shapes = {"original": bracket.shape}
    if bracket.reinforced is not None:
        shapes["reinforced"] = bracket.reinforced
    duty = duty_of(bracket, response)
    return BracketAnswer(
        title=application.title,
        bracket=bracket,
        top_speed=top,
        variants=tuple(
            judge(bracket, shape, cases, duty=duty, name=name, top_speed=top, tell=tell)
            for name, shape in shapes.items()
        ),
    )


def checks_of(of: BracketAnswer, variant: Judged, limits: Sequence[Limit]) -> Iterator[Check]:
    """Yield a check for each limit and load case, or duty cycle, of one shape of a bracket."""
    for limit in limits:
        for under, part, value in _values(of, variant, limit.quantity):
            yield Check(
                quantity=limit.quantity, line=of.bracket.line, when=under.when, part=part,
                value=value, limit=limit, point=under.point if isinstance(under, Case) else None,
            )  # fmt: skip


def _values(
    of: BracketAnswer, variant: Judged, quantity: str
) -> Iterator[tuple[Case | Endured, Part, float]]:
    """Yield under which loads and where what a limit asks about is worst, SI."""
    strength = of.bracket.material.yield_strength
    if quantity == "bracket_stress_utilisation" and strength:
        for o in variant.outcomes:
            worst = int(np.argmax(o.hot))
            used = float(o.hot[worst]) / strength
            yield o.case, Part("hot spot", worst + 1), used
    if quantity == "bracket_life":
        for endured in variant.duty:
            worst = int(np.argmax(endured.spots))
            yield endured, Part("hot spot", worst + 1), endured.hours * hour


def _unanswered(
    of: BracketAnswer, variant: Judged, limits: Sequence[Limit]
) -> Iterator[Unanswered]:
    """Yield the limits that got no number, with what they need."""
    needs = {
        "bracket_stress_utilisation": ("bracket.material with its yield strength",),
        "bracket_life": ("duty, and bracket.fatigue",),
    }
    for limit in limits:
        if not any(_values(of, variant, limit.quantity)):
            yield Unanswered(
                limit=limit, line=of.bracket.line, when=Occasion("case", "all"),
                part=Part("hot spot", 1), needs=needs[limit.quantity],
            )  # fmt: skip


def _bracket(application: Application) -> Bracket:
    if application.bracket is None:
        msg = "the application has no bracket: give it a `bracket` with a shape"
        raise DesignError(msg)
    return application.bracket


# --------------------------------------------------------------------------- load cases


def cases_of(bracket: Bracket, response: Response) -> Iterator[Case]:
    """Yield the cases a bracket is judged under: by hand, then of each state of the check.

    Of each state, at its own torque and top speed and on rigid bearings: the mean over a
    turn; the part of order 2 by itself; both together over the turn; and, where unbalance
    counts, with that on top. Then where the bearing carries most, on its rubber.
    """
    for case in bracket.cases:
        a = np.asarray(case.acceleration)
        force = np.asarray(case.force) - bracket.carried_mass * a
        yield Case(case.name, np.concatenate([force, case.moment, a])[None])
    if response.line.joint_count < 3:
        return
    forces, once = response.loads.bearing_forces, response.unbalance
    speeds, gravity = response.demand.speed.tolist(), response.gravity
    worst = response.worst.get("peak")
    for s, state in enumerate(response.demand.states):
        at = s, bracket.bearing - 1
        if np.isfinite(response.demand.torque[s]):
            yield from _round_the_turn(
                state, forces=Cycle(forces.waves[at]), gravity=gravity, speed=speeds[s],
                once=float(once.bearing_forces[at]) if once else None,
            )  # fmt: skip
        point = worst.named(at) if worst else None
        if worst and point:
            *_, case = _round_the_turn(
                state, forces=Cycle(worst.running.cycle.waves[at]), gravity=gravity,
                speed=point.speed, once=float(worst.running.order1[at]) if once else None,
            )  # fmt: skip
            yield replace(case, what="worst point", point=point)


def _round_the_turn(
    state: str, *, forces: Cycle, once: float | None, gravity: float, speed: RadianPerSecond
) -> Iterator[Case]:
    """Yield the cases of the force on a bearing at a speed, nan where that is not known.

    `once` is what unbalance makes, N 0-to-peak; None where it does not count.
    """
    mean = forces.static
    turn = forces.values(2 * SAMPLES)
    # Where weight counts the shafts' is in the forces already, the bracket's is not.
    weight = (0.0, 0.0, gravity)
    second = 2 * np.pi / speed if speed else np.inf  # of one turn, which never ends at rest
    yield Case(state, _history(mean[None], weight), what="static")
    yield Case(state, _history((turn - mean)[:SAMPLES]), 0.5, second / 2, what="order 2")
    yield Case(state, _history(turn[:SAMPLES], weight), 0.5, second / 2, what="combined")
    if once is not None:
        theta = 2 * np.pi * np.arange(2 * SAMPLES) / (2 * SAMPLES)
        round_ = np.stack([np.zeros_like(theta), np.cos(theta), np.sin(theta)], axis=-1)
        # Nobody knows where the heavy spot is: each of eight places is tried.
        starts = [np.roll(round_, 2 * SAMPLES // 8 * j, axis=0) for j in range(8)]
        peak = np.concatenate([turn + once * start for start in starts])
        yield Case(state, _history(peak, weight), 1.0, second, places=8, what="peak")


def duty_of(bracket: Bracket, response: Response) -> dict[Occasion, list[tuple[float, Case]]]:
    """Return the duty cycle's load histories with their shares, by each state that lasts.

    At the torque and speed of each point of the cycle, the axle wound up by it, on rubber
    where that is known. The joint angles are the state's: those of the cycle itself say
    nothing about where the bearings pull.
    """
    application = response.application
    if not response.duty or response.line.joint_count < 3:
        return {}
    found: dict[Occasion, list[tuple[float, Case]]] = {
        Occasion("duty", s.name): [] for s in application.states if s.counts_as in RIDING
    }
    every = np.ones(len(application.states))
    for point in response.duty:
        under = demand_under(
            response.demand, torque=point.torque * every, speed=point.speed * every,
            coasts=point.torque < 0,
        )  # fmt: skip
        carried = run(response, under, response.lay(under))
        for s, state in enumerate(application.states):
            at = s, bracket.bearing - 1
            *_, case = _round_the_turn(
                state.name, forces=Cycle(carried.cycle.waves[at]),
                once=float(carried.order1[at]) if application.include_unbalance else None,
                gravity=response.gravity, speed=point.speed,
            )  # fmt: skip
            if state.counts_as in RIDING:
                found[Occasion("duty", state.name)].append((point.share, case))
    return found


def _history(
    force: FloatArray, acceleration: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> FloatArray:
    """Return loads (t, 9) of forces (t, 3) with an acceleration of the frame."""
    loads = np.zeros((len(force), len(UNITS)))
    loads[:, :3], loads[:, 6:] = force, acceleration
    return loads


# --------------------------------------------------------------------------- one shape


def judge(
    bracket: Bracket,
    shape: Shape,
    cases: Sequence[Case],
    *,
    duty: Mapping[Occasion, Sequence[tuple[float, Case]]] | None = None,
    name: str = "original",
    top_speed: RadianPerSecond = np.nan,
    tell: Progress = hushed,
) -> Judged:
    """Judge one shape of a bracket under load cases, and over a duty cycle's.

    Damage is counted where the bracket states what it bears in fatigue.
    """
    if not cases:
        msg = "the bracket has no load case: give the application a torque, or the bracket cases"
        raise DesignError(msg)

    def told(what: str) -> None:
        tell(f"{name}: {what}")

    told("building the shape")
    body = solid(shape)
    grids = [(gauge.point, max(gauge.length, body.thickness / 3)) for gauge in bracket.gauges]
    units = unit_solutions(
        body, bracket.material, size=bracket.element, degree=bracket.order, finer=grids, tell=told
    )
    try:
        first = influence(units, bracket.gauges)  # now: a misplaced gauge is told at once
    except DesignError as error:
        msg = f"{name} bracket: {error}"
        raise DesignError(msg) from None
    told("natural frequencies")
    alone, _ = units.modes(6)
    carried = alone
    if bracket.carried_mass > 0:
        carried, _ = units.modes(6, mass=bracket.carried_mass, rubber=bracket.rubber)
    told(f"stresses of {len(cases)} load cases")
    where = searched(units)
    highest = np.max([envelope(where.stress, case.loads) for case in cases], axis=0)
    spots = hot_spots(where, highest, count=HOT_SPOTS, apart=2 * body.thickness)
    best = converged(units, spots, also=grids, tell=told)
    readings = influence(best.units, bracket.gauges)
    change = float(np.abs(readings - first).max() / np.abs(readings).max()) if len(first) else 0.0
    strength = Strength.of(bracket)

    def life(case: Case, when: Occasion) -> Endured | None:
        if strength is None or not case.repeats:
            return None
        return endured(
            case.loads, when=when, unit=best.stress, influence=readings,
            modulus=bracket.material.youngs_modulus, strength=strength,
            places=case.places, turns=case.turns, duration=case.duration,
        )  # fmt: skip

    spent: list[Endured] = []
    for cycle, parts in (duty or {}).items():
        lives = [(share, life(case, cycle)) for share, case in parts]
        known = [(share, one) for share, one in lives if one is not None]
        if known:
            spent.append(mixed(cycle, known))
    return Judged(
        name=name,
        units=units,
        hot_spots=best,
        influence=readings,
        influence_change=change,
        frequencies=alone,
        carried=carried,
        crossings=tuple(crossings(carried, top_speed)),
        outcomes=tuple(
            replace(_outcome(case, units, where, best, readings), life=life(case, case.when))
            for case in cases
        ),
        duty=tuple(spent),
    )


def _outcome(
    case: Case, units: Units, where: Searched, best: Converged, readings: FloatArray
) -> Outcome:
    """Return what one case does."""
    sound, points = where.sound, where.nodes

    def found(extreme: Extreme, among: FloatArray) -> Found:
        x, y, z = among[extreme.point].tolist()
        return Found(extreme.value, (x, y, z))

    inner, everywhere = (
        extremes(where.stress[sound], case.loads),
        extremes(where.stress, case.loads),
    )
    history = superpose(best.stress, case.loads)
    swinging = np.stack([along(one, critical_direction(one)) for one in history])
    strain = superpose(readings[..., None], case.loads)[..., 0]
    bolts = superpose(units.reactions, case.loads)
    motion = case.loads[:, :6] @ units.compliance[:, :3]
    return Outcome(
        case=case,
        von_mises=found(inner.von_mises, points[sound]),
        highest=found(inner.highest, points[sound]),
        lowest=found(inner.lowest, points[sound]),
        on_edge=found(everywhere.von_mises, points),
        hot=von_mises(history).max(axis=-1),
        error=best.error(case.loads),
        mean=(swinging.max(axis=-1) + swinging.min(axis=-1)) / 2,
        amplitude=np.ptp(swinging, axis=-1) / 2,
        strain=np.stack([strain.min(axis=-1), strain.max(axis=-1)], axis=-1),
        bolts=np.linalg.norm(bolts, axis=-1).max(axis=-1),
        motion=float(np.linalg.norm(motion, axis=-1).max()),
    )


def crossings(
    frequencies: FloatArray, top_speed: RadianPerSecond, *, orders: Sequence[int] = ORDERS
) -> Iterator[Crossing]:
    """Yield the speeds at which orders meet natural frequencies (m,) Hz, up to twice the top."""
    for k, frequency in enumerate(frequencies.tolist(), 1):
        for order in orders:
            speed = 2 * np.pi * frequency / order
            if not speed > 2 * top_speed:
                yield Crossing(k, frequency, order, speed, in_range=bool(speed <= top_speed))
