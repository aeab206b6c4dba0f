"""Judge a bracket: the driveline's own loads in it, stresses, gauges, modes, life, a variant.

Everything follows from the unit solutions by adding them up, so a load case costs no solve.
What the bearing hands to its bracket follows the line on its rubber, in series with the
bracket itself, where the masses of the line are known; and the bracket answers as it swings.
Loads of a state on rigid bearings, and those by hand, it bears quasi-statically.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, cast

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.errors import DesignError
from cardan.base.part import Occasion, Part, Point
from cardan.base.units import RadianPerSecond, hour
from cardan.base.verdict import Check, Limit, Unanswered
from cardan.bracket.elastic import Progress
from cardan.bracket.elastic import silent as hushed
from cardan.bracket.gauges import recover_held, reread
from cardan.bracket.refine import LEVELS
from cardan.bracket.solve import Solved
from cardan.bracket.unit import UNITS
from cardan.demand.states import demand, demand_under, resolve
from cardan.files.metals import key_of
from cardan.loads.cycle import Cycle
from cardan.model.application import RIDING, Application
from cardan.model.bracket import Bracket, BracketCase, Shape, Zone
from cardan.model.material import Material
from cardan.quantity.points import Points, every, run
from cardan.quantity.response import Response, respond
from cardan.study.bracket_contact import EASED
from cardan.study.bracket_forced import hung, on_rubber, swept
from cardan.study.bracket_judge import Case, Feature, Judged, Mounted, judge
from cardan.study.bracket_life import loads_of, strengths
from cardan.study.finding import BRACKET, Finding, Tell, limits_of

SAMPLES = 32
"""Angles of half a turn, in which loads of order 2 come back: a peak is met to 0.5 %."""
SHAKEN = 2
"""The order that shakes a bracket: the joints'."""
CONTACT = "bracket.bolts"
"""What has one answer where the two ways to hold a flange have two."""
TOP = "highest speed"
"""The occasion at which frequencies are held against an order."""


@dataclass(frozen=True, kw_only=True)
class BracketAnswer:
    """A bracket judged, and its reinforced variant beside it where there is one."""

    title: str
    bracket: Bracket
    top_speed: RadianPerSecond
    variants: tuple[Judged, ...]
    series: tuple[float, float] | None = None
    """Stiffness of rubber and bracket in series, up and level, N/m, where no other is given."""
    lasts: bool = False
    """Whether there is a duty cycle, or a recording, whose life curves alone would tell."""


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
    bench = Bench.of(application, extra=extra)
    variants = [bench.judged(bracket.shape, name="original", tell=tell)]
    if bracket.reinforced is not None:
        # What gauges read, they read on the bracket that is installed.
        bench = replace(bench, installed=variants[0].solved)
        variants.append(bench.judged(bracket.reinforced, name="reinforced", tell=tell))
    return BracketAnswer(
        title=application.title,
        bracket=bracket,
        top_speed=bench.top_speed,
        variants=tuple(variants),
        series=bench.series,
        lasts=bool(bench.response.duty or bracket.recordings),
    )


@dataclass(frozen=True, kw_only=True)
class Bench:
    """An application's line, ready to be hung in one shape of its bracket after the other.

    `installed` is the bracket whose gauges recordings were made with, known once it is solved.
    """

    bracket: Bracket
    response: Response
    extra: tuple[Case, ...] = ()
    installed: Solved | None = None

    @classmethod
    def of(cls, application: Application, *, extra: Sequence[Case] = ()) -> "Bench":
        """Return the bench of an application."""
        bracket = _bracket(application)
        installed = next(i for i in application.lines if i.line.name == bracket.line)
        response = respond(application, demand(resolve(application, installed)))
        return cls(bracket=bracket, response=response, extra=tuple(extra))

    @property
    def top_speed(self) -> RadianPerSecond:
        """The line's highest speed, in a state or not; nan where nobody knows."""
        fastest = float(np.max(self.response.balanced_at))
        return fastest if np.isfinite(fastest) else np.nan

    @property
    def series(self) -> tuple[float, float] | None:
        """Stiffness of rubber and bracket in series, up and level, where no other is given."""
        bearing = self.response.line.shafts[self.bracket.bearing - 1].centre_bearing
        if self.bracket.rubber is not None or bearing is None or bearing.bracket_stiffness:
            return None
        return bearing.stiffness

    def mounted(self, solved: Solved) -> Mounted:
        """Return the loads of the line hung in a bracket that gives, and those measured on it."""
        bracket, on = self.bracket, self.response
        read = self.installed or solved
        hangs = on_rubber(on, bracket)
        if hangs:
            on = hung(on, bracket, solved.sliding.swing.seat)
        return Mounted(
            cases=(*cases_of(bracket, on), *recorded(bracket, read), *self.extra),
            duty=duty_of(bracket, on),
            swept=swept(on, bracket.bearing - 1) if hangs else None,
        )

    def judged(
        self, shape: Shape, *, name: str, levels: int = LEVELS, tell: Progress = hushed
    ) -> Judged:
        """Judge one shape, on as many meshes at most; the first is made for a rigid bracket."""
        bracket, response = self.bracket, self.response
        if levels == 1:  # of a first mesh, which tells what is far off, contact is not asked
            bracket = replace(bracket, bolts=None)
        cases = (*cases_of(bracket, response), *recorded(bracket, None), *self.extra)
        if not cases and bracket.recordings:  # of strains, which no mesh can be made for
            cases = tuple(Case(UNITS[k], 1e3 * np.eye(3, len(UNITS))[[k]]) for k in range(3))
        return judge(
            bracket, shape, cases, duty=duty_of(bracket, response), mounted=self.mounted,
            name=name, top_speed=self.top_speed, levels=levels, tell=tell,
        )  # fmt: skip


def checks_of(of: BracketAnswer, variant: Judged, limits: Sequence[Limit]) -> Iterator[Check]:
    """Yield a check for each limit and load case, or duty cycle, of one shape of a bracket."""
    for limit in limits:
        for v in _values(of, variant, limit.quantity):
            one = Check(
                quantity=limit.quantity, line=of.bracket.line, when=v.when, part=v.part,
                value=v.value, limit=limit, point=v.point, within=v.within,
            )  # fmt: skip
            yield replace(one, settled_by=(CONTACT,)) if _parted(of, one, v.kinder) else one


def _parted(of: BracketAnswer, one: Check, kinder: float) -> bool:
    """Return whether the two ways to hold the flange part a verdict, of which the worse is told.

    Or leave a life that may fall short more open than contact does. Nowhere where `kinder` is nan.
    """
    if np.isnan(kinder):
        return False
    if one.limit.grade(kinder) != one.grade:
        return True
    if one.quantity != "bracket_life" or one.may_be == "pass":
        return False
    slope = strengths(of.bracket)[cast("Zone", one.part.kind)].curve.slope
    return kinder > EASED**-slope * one.value


class _Value(NamedTuple):
    """Where something is worst, how much it is there, SI, and between what by its error.

    `kinder` is how much it is with the flange held the kinder way, where contact would say which.
    """

    when: Occasion
    part: Part
    value: float
    point: Point | None = None
    within: tuple[float, float] | None = None
    kinder: float = np.nan


def _values(of: BracketAnswer, variant: Judged, quantity: str) -> Iterator[_Value]:
    """Yield under which loads, at which point and where what a limit asks about is worst, SI."""
    if quantity == "bracket_stress_utilisation":
        bears = np.array([yields(of.bracket.material, f) for f in variant.features])
        known = np.flatnonzero(np.isfinite(bears))
        for o in variant.outcomes if len(known) else ():
            used, off, least = (v[known] / bears[known] for v in (o.hot, o.error, o.least))
            worst = int(np.argmax(used))
            yield _Value(
                o.case.when, variant.features[known[worst]].part, float(used[worst]), o.case.point,
                within=(max(float((least - off).max()), 0.0), float((used + off).max())),
            )  # fmt: skip
    either = of.bracket.bolts is None
    if quantity == "bracket_fatigue_utilisation":
        yield from _fatigue(variant, either=either)
    if quantity == "bracket_life":
        measured = {one.name for one in of.bracket.recordings}
        # A recording may have the name of a state, whose cases say what they are of it.
        lives = (
            o.life for o in variant.outcomes
            if o.case.name in measured and not o.case.what and o.life
        )  # fmt: skip
        for endured in (*variant.duty, *lives):
            for _, mine in _by_zone(variant):
                if np.isnan(endured.spots[mine]).all():
                    continue  # nobody knows what it bears
                worst = max(mine, key=lambda k: float(endured.spots[k]))
                low, high = (h * hour for h in endured.at(mine).hours_within)
                yield _Value(
                    endured.when, variant.features[worst].part, endured.at([worst]).hours * hour,
                    within=None if np.isnan(low) else (low, high),
                    kinder=endured.at(mine).hours_kinder * hour if either else np.nan,
                )  # fmt: skip
    if quantity == "bracket_slip_utilisation":
        for when, share, point in variant.slips:
            yield _Value(when, Part("bolts"), share, point)
    if quantity == "bracket_resonance" and np.isfinite(of.top_speed) and of.top_speed > 0:
        own, too_high = variant.first
        ratio = own * 2 * np.pi / (SHAKEN * of.top_speed)
        yield _Value(
            Occasion("speed", TOP), Part("mode", 1, SHAKEN), ratio,
            within=(ratio / (1 + too_high), ratio),
        )  # fmt: skip


def yields(material: Material, at: Feature) -> float:
    """Return at what stress, Pa, a material yields at a feature; nan where nobody knows."""
    strength = material.yield_beside_weld if at.beside_weld else material.yield_strength
    return strength or np.nan


def _by_zone(variant: Judged) -> list[tuple[Zone, list[int]]]:
    """Return the zones of a shape, each with its features."""
    zones: dict[Zone, list[int]] = {}
    for k, f in enumerate(variant.features):
        zones.setdefault(f.zone, []).append(k)
    return list(zones.items())


def _fatigue(variant: Judged, *, either: bool) -> Iterator[_Value]:
    """Yield for each zone the case, and the feature, that comes nearest its fatigue limit.

    With the flange held in `either` of two ways, what the kinder makes of it too.
    """
    lasting = [o for o in variant.outcomes if not np.isnan(o.used).all()]
    for _, mine in _by_zone(variant):
        if all(np.isnan(o.used[mine]).all() for o in lasting):
            continue
        worst = max(lasting, key=lambda o: float(np.nanmax(o.used[mine], initial=0.0)))
        at = max(mine, key=lambda k: float(np.nan_to_num(worst.used[k])))
        part, used = variant.features[at].part, float(worst.used[at])
        # Where the error may lie that way, another feature may use more, or another case.
        ends = np.nan_to_num([o.used_within[mine] for o in lasting], posinf=np.inf)
        low, high = ends.max(axis=(0, 1)).tolist()
        kinder = max(float(np.nan_to_num(o.used_kinder[mine]).max()) for o in lasting)
        yield _Value(
            worst.case.when, part, used, worst.case.point, within=(low, high),
            kinder=kinder if either else np.nan,
        )  # fmt: skip


def _unanswered(
    of: BracketAnswer, variant: Judged, limits: Sequence[Limit]
) -> Iterator[Unanswered]:
    """Yield the limits that got no number, with what they need.

    Where a number has nothing of some places, nothing is approved without them.
    """
    curves = "bracket.fatigue" if of.lasts else "duty, and bracket.fatigue"
    needs = {
        "bracket_stress_utilisation": ("bracket.material with its yield strength",),
        "bracket_fatigue_utilisation": ("bracket.fatigue",),
        "bracket_life": ("duty" if of.bracket.fatigue else curves,),
        "bracket_slip_utilisation": ("bracket.bolts",),
        "bracket_resonance": ("speed_rpm",),
    }

    def missed(limit: Limit, part: Part, *needs: str) -> Unanswered:
        return Unanswered(
            limit=limit, line=of.bracket.line, when=Occasion("case", "all"), part=part, needs=needs
        )

    features = variant.features
    found = strengths(of.bracket)
    untold = [zone for zone, _ in _by_zone(variant) if found and zone not in found]
    soft = [f for f in features if np.isnan(yields(of.bracket.material, f))]
    for limit in limits:
        must = replace(limit, required=True)
        if not any(_values(of, variant, limit.quantity)):
            yield missed(limit, Part("sheet", 1), *needs[limit.quantity])
        elif limit.quantity == "bracket_stress_utilisation" and soft:
            yield missed(must, soft[0].part, "bracket.material with its welded_yield_MPa")
        elif limit.quantity in ("bracket_fatigue_utilisation", "bracket_life"):
            for zone in untold:
                part = next(f.part for f in features if f.zone == zone)
                yield missed(must, part, f"bracket.fatigue.{key_of(zone)}")


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
    yield from (Case(c.name, _by_hand(bracket, c)[None]) for c in bracket.cases if not c.state)
    if response.line.joint_count < 3:
        return
    found = every(response)
    for s, state in enumerate(response.demand.states):
        yield from (own := [*_of_state(bracket, response, s, found)])
        if not any(c.state == state for c in bracket.cases):
            continue
        # What the case adds may be worst where the state alone is not.
        under = own[-1].among or own[-1:] if own else ()
        for c in bracket.cases:
            if c.state == state:
                if not under:
                    msg = (
                        f"case {c.name} of the bracket comes on top of {state}, whose torque "
                        "nobody knows: give torque_Nm or an engine"
                    )
                    raise DesignError(msg, about="bracket.cases")
                more = _by_hand(bracket, c, standing=response.gravity)
                among = tuple(
                    replace(u, name=c.name, what="", loads=u.loads + more, once=True) for u in under
                )
                yield replace(among[0], among=among)


def _by_hand(bracket: Bracket, case: BracketCase, *, standing: float = 0.0) -> FloatArray:
    """Return the loads (9,) of a case given by hand.

    What stands still feels `standing` m/s², which is not counted twice where loads that the
    case comes on top of have it, nor taken from them by a case that says nothing of it.
    """
    a = np.asarray(case.acceleration)
    if a[2]:
        a = a - np.array([0.0, 0.0, standing])
    force = np.asarray(case.force) - bracket.carried_mass * a
    return np.concatenate([force, case.moment, a])


def _of_state(bracket: Bracket, response: Response, s: int, found: Points | None) -> Iterator[Case]:
    """Yield the cases of one state, that of its worst point, of those found, last."""
    state, at = response.demand.states[s], (s, bracket.bearing - 1)
    forces, once = response.loads.bearing_forces, response.unbalance
    speed, gravity = float(response.demand.speed[s]), response.gravity
    if np.isfinite(response.demand.torque[s]):
        yield from _round_the_turn(
            state, forces=Cycle(forces.waves[at]), gravity=gravity, speed=speed,
            once=float(once.bearing_forces[at]) if once else None,
        )  # fmt: skip
    worst = response.worst.get("peak")
    point = worst.named(at) if worst else None
    if worst and point:
        *_, case = _round_the_turn(
            state, forces=Cycle(worst.running.cycle.waves[at]), gravity=gravity,
            speed=point.speed, once=float(worst.running.order1[at]) if once else None,
        )  # fmt: skip
        # Where its force is most by its parts, neither stress nor swing need be.
        here = replace(case, what="worst point", point=point, shakes=bool(response.seats))
        others = _elsewhere(bracket, response, s, found) if found else ()
        yield replace(here, among=(here, *others))


def _elsewhere(bracket: Bracket, response: Response, s: int, found: Points) -> Iterator[Case]:
    """Yield the case of each operating point of a state that its bearing was asked at."""
    state, once = response.demand.states[s], response.unbalance
    for p in range(len(found.speed)):
        point = found.named((p, s))
        if point is None:
            continue
        at = (p, s, bracket.bearing - 1)
        *_, case = _round_the_turn(
            state, forces=Cycle(found.running.cycle.waves[at]), gravity=response.gravity,
            speed=point.speed, once=float(found.running.order1[at]) if once else None,
        )  # fmt: skip
        yield replace(case, what="worst point", point=point, shakes=bool(response.seats))


def recorded(bracket: Bracket, on: Solved | None) -> Iterator[Case]:
    """Yield a case of each recording; strains become forces by the gauges of a bracket solved.

    Who read forces back himself did so by the sliding flange, whose influence is told. Without a
    bracket solved, a case of each recording of forces.
    """
    for one in bracket.recordings:
        force, read = one.force, None
        if one.read and on is not None:
            sliding, clamped = (held.influence[:, :3] for held in on.both)
            if one.strain is not None:
                read = recover_held(sliding, clamped, one.strain, unsure=on.sliding.unsure)
                force = read.loads
            elif force is not None:
                read = reread(sliding, clamped, force, unsure=on.sliding.unsure)
        if force is None:
            continue
        # Forces are those on the bearing: the bracket swings on top of them. What gauges read
        # has its swing in it.
        yield Case(
            one.name, loads_of(force), duration=len(force) / one.rate, shakes=not one.read,
            read=read,
        )  # fmt: skip


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
        # Nobody knows where the heavy spot is: each of eight places is tried. Those opposite are
        # the same half a turn later, when all else has come back.
        starts = [np.roll(round_, 2 * SAMPLES // 8 * j, axis=0) for j in range(4)]
        peak = np.concatenate([turn + once * start for start in starts])
        yield Case(state, _history(peak, weight), 1.0, second, places=len(starts), what="peak")


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
                found[Occasion("duty", state.name)].append(
                    (point.share, replace(case, shakes=bool(response.seats)))
                )
    return found


def _history(
    force: FloatArray, acceleration: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> FloatArray:
    """Return loads (t, 9) of forces (t, 3) with an acceleration of the frame."""
    loads = np.zeros((len(force), len(UNITS)))
    loads[:, :3], loads[:, 6:] = force, acceleration
    return loads
