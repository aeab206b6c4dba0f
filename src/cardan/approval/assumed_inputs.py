"""Checks whose verdict hangs on an input that the file leaves out, and on its range.

An input that is not given has a value that stands in, and a range about it. Where a criterion
lies near its bound it is evaluated at both ends of that range as well, and where its verdict
turns the check says between what it lies, and what moves it.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from cardan.application.typical_values import typical_value
from cardan.approval.driveline_study import EvaluatedLimit, evaluate_limits
from cardan.checks.line_on_mounts import mounted_line_of
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.checks.rubber_at_stop import FORCE_KINDS, StopResponse
from cardan.checks.rubber_stiffness import results_with_rubber_stiffness, with_rubber_stiffness
from cardan.core.arrays import FloatArray
from cardan.core.lazy_dataclass import dataclass
from cardan.core.verdict import CHECK_GRADES, AssumedRange, Check
from cardan.model.application import Application
from cardan.physics.loads.rubber_mount import LOSS_FACTOR_RANGE, RUBBER_STIFFNESS_RANGE
from cardan.physics.strength.bearing_life import PRIME_MOVER_FACTORS
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references

ValuesAtEnds = Mapping[tuple[str, int], FloatArray]
"""Values (2, states, parts) SI of limits by quantity and place among its limits."""


@dataclass(frozen=True, kw_only=True)
class AssumedInput:
    """An input of the driveline that a file may leave out.

    Attributes
    ----------
    quantities
        Limited quantities that it changes.
    reach
        Share of its bound that a criterion lies off at most, to be evaluated again: more than
        the input can move it.
    range_in
        Its range where a response stands on it, else None.
    values_at_ends
        Quantities whose limits are evaluated at both ends of the range.
    all_of_it_comes
        Whether the range is one that the line goes through, as rubber from cold to hot: then the
        worse end alone is reported, because no better one helps, and none where a check fails
        anyway.
    """

    quantities: frozenset[str]
    reach: float
    range_in: Callable[[LineResponse], AssumedRange | None]
    values_at_ends: Callable[[LineResponse, AssumedRange, frozenset[str]], ValuesAtEnds]
    all_of_it_comes: bool = False


def checks_with_assumed_ranges(
    responses: Sequence[LineResponse], checks: Iterable[Check]
) -> tuple[Check, ...]:
    """Return checks, those whose verdict an assumed input turns with between what they lie."""
    found = list(checks)
    for r in responses:
        for one in ASSUMED_INPUTS:
            if one.all_of_it_comes and any(c.grade == "fail" for c in found):
                continue  # no worse verdict is left
            assumed = one.range_in(r)
            if assumed is None:
                continue
            near = {
                k: c
                for k, c in enumerate(found)
                if c.line == r.line.name and c.quantity in one.quantities and _is_near(c, one)
            }
            if not near:
                continue
            quantities = frozenset(c.quantity for c in near.values())
            ends = one.values_at_ends(r, assumed, quantities)
            base = _by_place(evaluate_limits(r, quantities=quantities))
            for k, c in near.items():
                found[k] = _widened(c, r, base, ends, assumed, only_worse=one.all_of_it_comes)
    return tuple(found)


def _is_near(c: Check, one: AssumedInput) -> bool:
    """Whether a bound of its limit is within reach of a check's value: ahead, if worse counts."""
    bounds = (c.limit.normal, c.limit.maximum, *(c.limit.band or ()))
    near = [b for b in bounds if b is not None and abs(c.value - b) <= one.reach * (abs(b) or 1.0)]
    return any(not one.all_of_it_comes or (c.value <= b) == (c.limit.sense == "<=") for b in near)


def _by_place(
    questions: Iterable[EvaluatedLimit],
) -> dict[tuple[str, int], EvaluatedLimit]:
    """Return limits by quantity and place among those of the quantity."""
    found: dict[tuple[str, int], EvaluatedLimit] = {}
    counts: dict[str, int] = {}
    for q in questions:
        place = counts.get(q.limit.quantity, 0)
        counts[q.limit.quantity] = place + 1
        found[q.limit.quantity, place] = q
    return found


def _widened(
    c: Check,
    r: LineResponse,
    base: Mapping[tuple[str, int], EvaluatedLimit],
    ends: ValuesAtEnds,
    assumed: AssumedRange,
    *,
    only_worse: bool,
) -> Check:
    """Return a check with its range, if its verdict turns within it.

    Ranges of forces are those of a spline that slides: one with it stuck has none.
    """
    if c.point and c.point.is_spline_stuck:
        return c
    for place, question in base.items():
        if place not in ends or question.limit != c.limit or c.part not in question.parts:
            continue
        state = r.demand.states.index(c.when.name)
        values = ends[place][:, state, question.parts.index(c.part)]
        if not np.isfinite(values).all():
            return c
        if only_worse:
            values = (np.maximum if c.limit.sense == "<=" else np.minimum)(values, c.value)
            if all(replace(c, value=v).grade == c.grade for v in values.tolist()):
                return c
        within = (c.value, *(c.within or ()), *values.tolist())
        wider = replace(c, within=(min(within), max(within)), assumed=(*c.assumed, assumed))
        return wider if wider.best_possible_grade != wider.worst_possible_grade else c
    return c


# --------------------------------------------------------------------------- inputs


def _answers_of(
    vary: Callable[[Application, FloatArray], Application],
) -> Callable[[LineResponse, AssumedRange, frozenset[str]], ValuesAtEnds]:
    """Return how both ends of an input are evaluated in one batch: as two variants."""

    def values(r: LineResponse, of: AssumedRange, quantities: frozenset[str]) -> ValuesAtEnds:
        application = vary(r.application, np.array([[of.low], [of.high]]))
        installed = next(i for i in application.lines if i.line.name == r.line.name)
        demand = line_state_demand(resolve_line_references(application, installed))
        varied = compute_line_response(application, demand)
        shape = (2, len(demand.states))
        return {
            place: np.broadcast_to(q.values, (*shape, len(q.parts)))
            for place, q in _by_place(evaluate_limits(varied, quantities=quantities)).items()
        }

    return values


def _friction(r: LineResponse) -> AssumedRange | None:
    tyre, given = r.application.tyre, r.application.is_given("tyre.friction")
    if tyre is None or given or r.layout.points.ndim > 3:
        return None
    typical = typical_value("tyre.friction", "heavy truck")
    return AssumedRange("tyre.friction", typical.low, typical.high)


def _with_friction(application: Application, ends: FloatArray) -> Application:
    assert application.tyre is not None  # or it has no range
    return replace(application, tyre=replace(application.tyre, friction=ends))


def _prime_mover(r: LineResponse) -> AssumedRange | None:
    if r.application.is_given("prime_mover") or r.layout.points.ndim > 3:
        return None
    factors = PRIME_MOVER_FACTORS.values()
    return AssumedRange("prime_mover (K1)", min(factors), max(factors))


def _life_with_prime_movers(
    r: LineResponse, of: AssumedRange, quantities: frozenset[str]
) -> ValuesAtEnds:
    """Return lives, which are inverse to the factor of what drives the line."""
    shares = r.application.prime_mover_factor / np.array([of.low, of.high])
    return {
        place: shares[:, None, None] * q.values
        for place, q in _by_place(evaluate_limits(r, quantities=quantities)).items()
    }


def _loss_factor(r: LineResponse) -> AssumedRange | None:
    soft = [b for b in r.line.centre_bearings if b.stiffness is not None]
    known = all(b.loss_factor is not None for b in soft)
    worst = r.mount_loads.worst_bearing_forces if soft and not known else {}
    if "dynamic" not in worst or r.mounts.mounted_line is None or r.layout.points.ndim > 3:
        return None
    return AssumedRange("centre_bearing.loss_factor", *LOSS_FACTOR_RANGE)


def _forces_at_loss_factors(
    r: LineResponse, of: AssumedRange, quantities: frozenset[str]
) -> ValuesAtEnds:
    """Return forces at the points where they are largest, with other losses of the rubber.

    Where rubber meets its stop they are solved again, unless they fail all the same.
    """
    found = r.mount_loads.forces_with_other_loss_factors(np.array([[of.low], [of.high]]))
    names = {"centre_bearing_dynamic": found.dynamic, "centre_bearing_peak": found.peak}
    base = _by_place(evaluate_limits(r, quantities=quantities))
    at_stop = r.mount_loads.is_solved_at_stop
    if at_stop.any():
        fail = CHECK_GRADES.index("fail")
        fails = any(((q.grades() == fail) & at_stop & ~np.isnan(q.values)).any()
                    for q in base.values())  # fmt: skip
        solved = [None if fails else _at_stop_with_loss_factor(r, end) for end in (of.low, of.high)]
        for name in names:
            kind = name.removeprefix("centre_bearing_")
            ends = [np.nan if one is None else np.where(one.is_solved[:, None], one.force(kind),
                    np.nan) for one in solved]  # fmt: skip
            ends = np.stack(np.broadcast_arrays(*ends, names[name][0])[:-1])
            names[name] = np.where(at_stop, ends, names[name])
    return {
        place: np.broadcast_to(names[place[0]], (2, *q.values.shape[-2:]))
        for place, q in base.items()
    }


def _at_stop_with_loss_factor(r: LineResponse, assumed: float) -> StopResponse | None:
    """Return what bearings carry at their stops with another loss factor of the rubber."""
    held = mounted_line_of(r.inputs, assumed=assumed)
    return held and r.mount_loads.stop_response_on(held, reaches=False)


def _stop_stiffness_ratio(r: LineResponse) -> AssumedRange | None:
    solved = r.mount_loads.stop_response
    if solved is None or not solved.is_solved.any() or len(solved.ratios) == 1:
        return None
    return AssumedRange(
        "centre_bearing.stop_stiffness_ratio",
        float(solved.ratios[0].min()),
        float(solved.ratios[-1].max()),
    )


def _forces_at_stop_stiffness_ratios(
    r: LineResponse, of: AssumedRange, quantities: frozenset[str]
) -> ValuesAtEnds:
    """Return forces where rubber meets its stop, with both ends of its stiffness there."""
    del of  # both ends are solved
    solved = r.mount_loads.stop_response
    assert solved is not None  # or it has no range
    return {
        place: np.where(
            solved.is_solved[:, None], solved.forces[place[0].removeprefix(_FORCE)], np.nan
        )
        for place in _by_place(evaluate_limits(r, quantities=quantities))
    }


_FORCE = "centre_bearing_"

_OF_RUBBER = frozenset(
    {
        "centre_bearing_static",
        "centre_bearing_dynamic",
        "centre_bearing_peak",
        "centre_bearing_travel_utilisation",
        "spline_compression_utilisation",
        "resonance_distance",
        "clearance_on_rubber",
    }
)
"""Limited quantities that heat and cold change."""


def _stiffness_ranges(r: LineResponse) -> list[tuple[float, float]]:
    """Return how soft and how stiff each bearing's rubber gets, over its stiffness."""
    each = (b.stiffness_range for b in r.line.centre_bearings)
    return [RUBBER_STIFFNESS_RANGE if given is None else given for given in each]


def _rubber_stiffness(r: LineResponse) -> AssumedRange | None:
    soft = [b for b in r.line.centre_bearings if b.stiffness is not None]
    worst = r.mount_loads.worst_bearing_forces if soft else {}
    if "dynamic" not in worst or r.mounts.mounted_line is None or r.layout.points.ndim > 3:
        return None
    low, high = zip(*_stiffness_ranges(r), strict=True)
    given = all(b.stiffness_range is not None for b in soft)
    return AssumedRange("centre_bearing.stiffness_range", min(low), max(high), is_given=given)


def _results_at_rubber_stiffnesses(
    r: LineResponse, of: AssumedRange, quantities: frozenset[str]
) -> ValuesAtEnds:
    """Return what hangs on rubber, all of it hot and all of it cold."""
    del of  # each bearing has its own
    shares = [np.array(ends)[:, None] for ends in _stiffness_ranges(r)]
    stops = "centre_bearing_travel_utilisation"
    asked = quantities | ({"centre_bearing_travel"} if stops in quantities else set[str]())
    found = results_with_rubber_stiffness(r, shares, quantities=asked)
    found |= _forces_at_stop_of_tempered_rubber(r, found, quantities)
    if "centre_bearing_travel" in found:
        stopped = [k for k, b in enumerate(r.line.centre_bearings) if b.travel is not None]
        over = found["centre_bearing_travel"] / r.mount_loads.mount_stop_travel
        found[stops] = over[..., stopped]
    return {
        place: found[place[0]]
        for place in _by_place(evaluate_limits(r, quantities=quantities))
        if place[0] in found
    }


def _forces_at_stop_of_tempered_rubber(
    r: LineResponse, found: Mapping[str, FloatArray], quantities: frozenset[str]
) -> dict[str, FloatArray]:
    """Return forces of rubber hot and cold with its stop, where one of both may meet it."""
    loads, kinds = r.mount_loads, [q for q in quantities if q in found and q.startswith(_FORCE)]
    softest = min(low for low, _ in _stiffness_ranges(r))
    kinds = [q for q in kinds if q.removeprefix(_FORCE) in FORCE_KINDS]
    if not kinds or not (loads.stop_margin("peak") < 1 - softest).any():
        return {}
    each = [with_rubber_stiffness(r, ends).mount_loads for ends in zip(
        *_stiffness_ranges(r), strict=True)]  # fmt: skip
    margins = np.broadcast_arrays(*(one.stop_margin("peak") for one in each))
    known = np.stack([
        (margin >= 0) | one.is_solved_at_stop for one, margin in zip(each, margins, strict=True)
    ])  # fmt: skip
    meets = np.stack([margin < 0 for margin in margins]) | loads.is_solved_at_stop
    meets = meets.any(axis=(0, -1), keepdims=True)
    both = {q: np.stack([one.evaluated_force(q.removeprefix(_FORCE)) for one in each])
            for q in kinds}  # fmt: skip
    return {q: np.where(meets & known, both[q], found[q]) for q in kinds}


ASSUMED_INPUTS = (
    AssumedInput(
        quantities=frozenset(
            {
                "tube_shear_utilisation",
                "tube_buckling_utilisation",
                "joint_fatigue_utilisation",
                "tube_stress_utilisation",
                "tube_fatigue_utilisation",
                "joint_life",
                "joint_angle",
                "centre_bearing_static",
                "centre_bearing_dynamic",
                "centre_bearing_peak",
            }
        ),
        reach=0.35,
        range_in=_friction,
        values_at_ends=_answers_of(_with_friction),
    ),
    AssumedInput(
        quantities=frozenset({"joint_life"}),
        reach=0.25,
        range_in=_prime_mover,
        values_at_ends=_life_with_prime_movers,
    ),
    AssumedInput(
        quantities=frozenset({"centre_bearing_dynamic", "centre_bearing_peak"}),
        reach=0.6,
        range_in=_loss_factor,
        values_at_ends=_forces_at_loss_factors,
    ),
    AssumedInput(
        quantities=frozenset({"centre_bearing_dynamic", "centre_bearing_peak"}),
        reach=0.7,
        range_in=_stop_stiffness_ratio,
        values_at_ends=_forces_at_stop_stiffness_ratios,
    ),
    AssumedInput(
        quantities=_OF_RUBBER,
        reach=0.7,
        range_in=_rubber_stiffness,
        values_at_ends=_results_at_rubber_stiffnesses,
        all_of_it_comes=True,
    ),
)
"""What a file may leave out of a driveline and stands in with a stated range."""
