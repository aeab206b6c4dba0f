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

from cardan.approval.study import BRACKET_STUDY_NAME, StudyResult, limits_of_study
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.checks.operating_point_results import OperatingPointResults
from cardan.core.arrays import FloatArray
from cardan.core.errors import DesignError
from cardan.core.labels import EvaluationCondition, OperatingPoint, Part
from cardan.core.status import ProgressCallback, StatusCallback, ignore_status
from cardan.core.units import RadianPerSecond, hour
from cardan.core.verdict import Check, Limit, UnevaluatedCheck
from cardan.model.application import STATE_KINDS_AT_LOADED_RIDE_HEIGHT, Application
from cardan.model.bracket import Bracket, BracketLoadCase, FatigueZone, Shape
from cardan.model.material import Material
from cardan.physics.fem.adaptive_refinement import MAX_MESHES
from cardan.physics.fem.solve import SolvedBracket
from cardan.physics.fem.strain_gauges import (
    correct_loads_for_flange_clamping,
    recover_loads_and_flange_clamping,
)
from cardan.physics.fem.unit_loads import UNIT_LOAD_NAMES
from cardan.physics.loads.half_turn_fourier import HalfTurnSeries
from cardan.physics.vehicle.state_demand import (
    demand_with_axle_moved_by_torque,
    line_state_demand,
    resolve_line_references,
)
from cardan.topics.bracket.contact_assessment import MIN_CONTACT_TO_COMPUTED_STRESS_RATIO
from cardan.topics.bracket.forced_response import (
    bearing_force_sweep,
    has_elastic_mount,
    line_response_on_bracket,
)
from cardan.topics.bracket.life import fatigue_strength_by_zone, load_history_of_forces
from cardan.topics.bracket.load_cases import BearingLoadCase, BracketLoads
from cardan.topics.bracket.metal_fatigue_data import zone_curve_key
from cardan.topics.bracket.shape_assessment import assess_shape
from cardan.topics.bracket.shape_result import FatigueFeature, ShapeAssessment

SAMPLES_PER_HALF_TURN = 32
"""Angles of half a turn, in which loads of order 2 come back: a peak is met to 0.5 %."""
JOINT_EXCITATION_ORDER = 2
"""The order that shakes a bracket: the joints'."""
BOLT_CONTACT_SETTLED_BY_KEY = "bracket.bolts"
"""What has one answer where the two ways to hold a flange have two."""
HIGHEST_SPEED_CONDITION_LABEL = "highest speed"
"""The occasion at which frequencies are held against an order."""


@dataclass(frozen=True, kw_only=True)
class BracketResult:
    """A bracket assessed, and its reinforced variant if there is one."""

    title: str
    bracket: Bracket
    top_speed: RadianPerSecond
    variants: tuple[ShapeAssessment, ...]
    series_stiffness: tuple[float, float] | None = None
    """Stiffness of rubber and bracket in series, up and level, N/m, where no other is given."""
    has_life_loads: bool = False
    """Whether there is a duty cycle, or a recording, whose life needs S-N curves only."""


def run_bracket_study(
    application: Application, *, extra: Sequence[BearingLoadCase], tell: ProgressCallback
) -> StudyResult[BracketResult]:
    """Judge an application's bracket, and hold the shape that is installed against the limits.

    Raises
    ------
    DesignError
        If the application has no bracket, or its shape cannot be built or meshed.
    MissingDependencyError
        Without the extra `cardan[bracket]`.
    """
    answer = analyse_bracket(application, extra=extra, tell=lambda said: tell(said, 0, 0))
    limits = limits_of_study(BRACKET_STUDY_NAME, application)
    installed = answer.variants[0]
    return StudyResult(
        study=BRACKET_STUDY_NAME,
        answer=answer,
        checks=tuple(bracket_checks(answer, installed, limits)),
        unevaluated=tuple(_unanswered(answer, installed, limits)),
    )


def analyse_bracket(
    application: Application,
    *,
    extra: Sequence[BearingLoadCase] = (),
    tell: StatusCallback = ignore_status,
) -> BracketResult:
    """Return what an application's bracket bears, and its reinforced variant."""
    bracket = _bracket(application)
    bench = BracketShapeAssessor.from_application(application, extra=extra)
    variants = [bench.assess(bracket.shape, name="original", tell=tell)]
    if bracket.reinforced is not None:
        # What gauges read, they read on the bracket that is installed.
        bench = replace(bench, installed_solution=variants[0].solved)
        variants.append(bench.assess(bracket.reinforced, name="reinforced", tell=tell))
    return BracketResult(
        title=application.title,
        bracket=bracket,
        top_speed=bench.top_speed,
        variants=tuple(variants),
        series_stiffness=bench.series_stiffness,
        has_life_loads=bool(bench.response.inputs.duty_points or bracket.recordings),
    )


@dataclass(frozen=True, kw_only=True)
class BracketShapeAssessor:
    """An application's line, ready to be hung in one shape of its bracket after the other.

    `installed_solution` is the bracket whose gauges recordings were made with, known once it is
    solved.
    """

    bracket: Bracket
    response: LineResponse
    extra_cases: tuple[BearingLoadCase, ...] = ()
    installed_solution: SolvedBracket | None = None

    @classmethod
    def from_application(
        cls, application: Application, *, extra: Sequence[BearingLoadCase] = ()
    ) -> "BracketShapeAssessor":
        """Return the bench of an application."""
        bracket = _bracket(application)
        installed = next(i for i in application.lines if i.line.name == bracket.line)
        response = compute_line_response(
            application, line_state_demand(resolve_line_references(application, installed))
        )
        return cls(bracket=bracket, response=response, extra_cases=tuple(extra))

    @property
    def top_speed(self) -> RadianPerSecond:
        """The line's highest speed, in a state or not; nan where unknown."""
        fastest = float(np.max(self.response.inputs.balancing_speed))
        return fastest if np.isfinite(fastest) else np.nan

    @property
    def series_stiffness(self) -> tuple[float, float] | None:
        """Stiffness of rubber and bracket in series, up and level, where no other is given."""
        bearing = self.response.line.shafts[self.bracket.bearing - 1].centre_bearing
        if self.bracket.rubber is not None or bearing is None or bearing.bracket_stiffness:
            return None
        return bearing.stiffness

    def mounted_loads(self, solved: SolvedBracket) -> BracketLoads:
        """Return the loads of the line hung in a bracket that gives, and those measured on it."""
        bracket, on = self.bracket, self.response
        read = self.installed_solution or solved
        hangs = has_elastic_mount(on, bracket)
        if hangs:
            on = line_response_on_bracket(
                on, bracket, solved.sliding.modal_model.bracket_compliance
            )
        return BracketLoads(
            cases=(
                *load_cases(bracket, on),
                *load_cases_from_recordings(bracket, read),
                *self.extra_cases,
            ),
            duty=duty_cycle_cases(bracket, on),
            sweep=bearing_force_sweep(on, bracket.bearing - 1) if hangs else None,
        )

    def assess(
        self,
        shape: Shape,
        *,
        name: str,
        levels: int = MAX_MESHES,
        tell: StatusCallback = ignore_status,
    ) -> ShapeAssessment:
        """Judge one shape, on as many meshes at most; the first is made for a rigid bracket."""
        bracket, response = self.bracket, self.response
        if levels == 1:  # on a first mesh, a rough estimate, contact is not computed
            bracket = replace(bracket, bolts=None)
        cases = (
            *load_cases(bracket, response),
            *load_cases_from_recordings(bracket, None),
            *self.extra_cases,
        )
        if not cases and bracket.recordings:  # of strains, which no mesh can be made for
            cases = tuple(
                BearingLoadCase(UNIT_LOAD_NAMES[k], 1e3 * np.eye(3, len(UNIT_LOAD_NAMES))[[k]])
                for k in range(3)
            )
        return assess_shape(
            bracket,
            shape,
            cases,
            duty=duty_cycle_cases(bracket, response),
            mounted=self.mounted_loads,
            name=name,
            top_speed=self.top_speed,
            levels=levels,
            tell=tell,
        )


def bracket_checks(
    of: BracketResult, variant: ShapeAssessment, limits: Sequence[Limit]
) -> Iterator[Check]:
    """Yield a check for each limit and load case, or duty cycle, of one shape of a bracket."""
    for limit in limits:
        for v in _values(of, variant, limit.quantity):
            one = Check(
                quantity=limit.quantity, line=of.bracket.line, when=v.when, part=v.part,
                value=v.value, limit=limit, point=v.point, within=v.within,
                validity_margin=v.stop_margin,
            )  # fmt: skip
            yield (
                replace(one, deciding_inputs=(BOLT_CONTACT_SETTLED_BY_KEY,))
                if _parted(of, one, v.favourable)
                else one
            )


def _parted(of: BracketResult, one: Check, favourable: float) -> bool:
    """Return whether the two ways to hold the flange give two verdicts; the worse is reported.

    Or leave a life that may fall short more open than contact does. Nowhere where `favourable` is
    nan.
    """
    if np.isnan(favourable):
        return False
    if one.limit.grade(favourable) != one.grade:
        return True
    if one.quantity != "bracket_life" or one.worst_possible_grade == "pass":
        return False
    slope = fatigue_strength_by_zone(of.bracket)[cast("FatigueZone", one.part.kind)].curve.slope
    return favourable > MIN_CONTACT_TO_COMPUTED_STRESS_RATIO**-slope * one.value


class _Value(NamedTuple):
    """Where something is worst, how much it is there, SI, and between what by its error.

    `favourable` is how much it is with the flange held the more favourable way, where contact would
    say which.
    `stop_margin` is negative where the loads are at least those that it is of.
    """

    when: EvaluationCondition
    part: Part
    value: float
    point: OperatingPoint | None = None
    within: tuple[float, float] | None = None
    favourable: float = np.nan
    stop_margin: float = np.inf


def _values(of: BracketResult, variant: ShapeAssessment, quantity: str) -> Iterator[_Value]:
    """Yield under which loads, at which point and where the value under a limit is worst, SI."""
    if quantity == "bracket_stress_utilisation":
        bears = np.array(
            [yield_strength_at_feature(of.bracket.material, f) for f in variant.features]
        )
        known = np.flatnonzero(np.isfinite(bears))
        for o in variant.case_results if len(known) else ():
            used, off, least = (
                v[known] / bears[known]
                for v in (o.feature_stress, o.feature_stress_error, o.min_feature_stress)
            )
            worst = int(np.argmax(used))
            yield _Value(
                o.case.when,
                variant.features[known[worst]].part,
                float(used[worst]),
                o.case.operating_point,
                within=(max(float((least - off).max()), 0.0), float((used + off).max())),
                stop_margin=o.case.stop_margin,
            )
    either = of.bracket.bolts is None
    if quantity == "bracket_fatigue_utilisation":
        yield from _fatigue(variant, either=either)
    if quantity == "bracket_life":
        measured = {one.name for one in of.bracket.recordings}
        # A recording may have the name of a state, whose cases say what they are of it.
        lives = (
            o.damage_result for o in variant.case_results
            if o.case.name in measured and not o.case.component and o.damage_result
        )  # fmt: skip
        for endured in (*variant.duty_damage, *lives):
            for _, mine in _by_zone(variant):
                if np.isnan(endured.hot_spot_damage[mine]).all():
                    continue  # its strength is unknown
                worst = max(mine, key=lambda k: float(endured.hot_spot_damage[k]))
                low, high = (h * hour for h in endured.at_spots(mine).hours_bounds)
                yield _Value(
                    endured.when,
                    variant.features[worst].part,
                    endured.at_spots([worst]).hours_to_failure * hour,
                    within=None if np.isnan(low) else (low, high),
                    favourable=endured.at_spots(mine).favourable_hours * hour if either else np.nan,
                    stop_margin=endured.stop_margin,
                )
    if quantity == "bracket_slip_utilisation":
        for when, share, point, margin in variant.bolt_slips:
            yield _Value(when, Part("bolts"), share, point, stop_margin=margin)
    if quantity == "bracket_resonance" and np.isfinite(of.top_speed) and of.top_speed > 0:
        own, too_high = variant.lowest_frequency
        ratio = own * 2 * np.pi / (JOINT_EXCITATION_ORDER * of.top_speed)
        yield _Value(
            EvaluationCondition("speed", HIGHEST_SPEED_CONDITION_LABEL),
            Part("mode", 1, JOINT_EXCITATION_ORDER),
            ratio,
            within=(ratio / (1 + too_high), ratio),
        )


def yield_strength_at_feature(material: Material, at: FatigueFeature) -> float:
    """Return at what stress, Pa, a material yields at a feature; nan where unknown."""
    strength = material.yield_strength_at_weld if at.beside_weld else material.yield_strength
    return strength or np.nan


def _by_zone(variant: ShapeAssessment) -> list[tuple[FatigueZone, list[int]]]:
    """Return the zones of a shape, each with its features."""
    zones: dict[FatigueZone, list[int]] = {}
    for k, f in enumerate(variant.features):
        zones.setdefault(f.zone, []).append(k)
    return list(zones.items())


def _fatigue(variant: ShapeAssessment, *, either: bool) -> Iterator[_Value]:
    """Yield for each zone the case, and the feature, that comes nearest its fatigue limit.

    With the flange held in `either` of two ways, what the more favourable makes of it too.
    """
    lasting = [o for o in variant.case_results if not np.isnan(o.utilisation).all()]
    for _, mine in _by_zone(variant):
        if all(np.isnan(o.utilisation[mine]).all() for o in lasting):
            continue
        worst = max(lasting, key=lambda o: float(np.nanmax(o.utilisation[mine], initial=0.0)))
        at = max(mine, key=lambda k: float(np.nan_to_num(worst.utilisation[k])))
        part, used = variant.features[at].part, float(worst.utilisation[at])
        # Where the error may lie that way, another feature may use more, or another case.
        ends = np.nan_to_num([o.utilisation_bounds[mine] for o in lasting], posinf=np.inf)
        low, high = ends.max(axis=(0, 1)).tolist()
        favourable = max(
            float(np.nan_to_num(o.favourable_utilisation[mine]).max()) for o in lasting
        )
        yield _Value(
            worst.case.when, part, used, worst.case.operating_point, within=(low, high),
            favourable=favourable if either else np.nan,
            stop_margin=min(o.case.stop_margin for o in lasting),
        )  # fmt: skip


def _unanswered(
    of: BracketResult, variant: ShapeAssessment, limits: Sequence[Limit]
) -> Iterator[UnevaluatedCheck]:
    """Yield the limits that got no number, with what they need.

    Where a number has nothing of some places, nothing is approved without them.
    """
    curves = "bracket.fatigue" if of.has_life_loads else "duty, and bracket.fatigue"
    needs = {
        "bracket_stress_utilisation": ("bracket.material with its yield strength",),
        "bracket_fatigue_utilisation": ("bracket.fatigue",),
        "bracket_life": ("duty" if of.bracket.fatigue else curves,),
        "bracket_slip_utilisation": ("bracket.bolts",),
        "bracket_resonance": ("speed_rpm",),
    }

    def missed(limit: Limit, part: Part, *needs: str) -> UnevaluatedCheck:
        return UnevaluatedCheck(
            limit=limit,
            line=of.bracket.line,
            when=EvaluationCondition("case", "all"),
            part=part,
            missing_inputs=needs,
        )

    features = variant.features
    found = fatigue_strength_by_zone(of.bracket)
    untold = [zone for zone, _ in _by_zone(variant) if found and zone not in found]
    soft = [f for f in features if np.isnan(yield_strength_at_feature(of.bracket.material, f))]
    for limit in limits:
        must = replace(limit, required=True)
        if not any(_values(of, variant, limit.quantity)):
            yield missed(limit, Part("sheet", 1), *needs[limit.quantity])
        elif limit.quantity == "bracket_stress_utilisation" and soft:
            yield missed(must, soft[0].part, "bracket.material with its welded_yield_MPa")
        elif limit.quantity in ("bracket_fatigue_utilisation", "bracket_life"):
            for zone in untold:
                part = next(f.part for f in features if f.zone == zone)
                yield missed(must, part, f"bracket.fatigue.{zone_curve_key(zone)}")


def _bracket(application: Application) -> Bracket:
    if application.bracket is None:
        msg = "the application has no bracket: add `bracket` with its shape"
        raise DesignError(msg)
    return application.bracket


# --------------------------------------------------------------------------- load cases


def load_cases(bracket: Bracket, response: LineResponse) -> Iterator[BearingLoadCase]:
    """Yield the cases a bracket is judged under: by hand, then of each state of the check.

    Of each state, at its own torque and top speed and on rigid bearings: the mean over a
    turn; the part of order 2 by itself; both together over the turn; and, where unbalance
    counts, with that on top. Then where the bearing carries most, on its rubber.
    """
    yield from (
        BearingLoadCase(c.name, _by_hand(bracket, c)[None]) for c in bracket.cases if not c.state
    )
    if response.line.joint_count < 3:
        return
    found = response.mount_loads.all_points()
    for s, state in enumerate(response.demand.states):
        yield from (own := [*_of_state(bracket, response, s, found)])
        if not any(c.state == state for c in bracket.cases):
            continue
        # What the case adds may be worst where the state alone is not.
        under = own[-1].alternatives or own[-1:] if own else ()
        for c in bracket.cases:
            if c.state == state:
                if not under:
                    msg = (
                        f"case {c.name} of the bracket comes on top of {state}, whose torque is "
                        "unknown: give torque_Nm or an engine"
                    )
                    raise DesignError(msg, about="bracket.cases")
                more = _by_hand(bracket, c, standing=response.inputs.gravity)
                among = tuple(
                    replace(u, name=c.name, component="", loads=u.loads + more, occurs_once=True)
                    for u in under
                )
                yield replace(among[0], alternatives=among)


def _by_hand(bracket: Bracket, case: BracketLoadCase, *, standing: float = 0.0) -> FloatArray:
    """Return the loads (9,) of a case given by hand.

    What stands still feels `standing` m/s², which is not counted twice where loads that the
    case comes on top of have it, nor taken from them by a case that says nothing of it.
    """
    a = np.asarray(case.acceleration)
    if a[2]:
        a = a - np.array([0.0, 0.0, standing])
    force = np.asarray(case.force) - bracket.carried_mass * a
    return np.concatenate([force, case.moment, a])


def _of_state(
    bracket: Bracket, response: LineResponse, s: int, found: OperatingPointResults | None
) -> Iterator[BearingLoadCase]:
    """Yield the cases of one state, that of its worst point, of those found, last."""
    state, at = response.demand.states[s], (s, bracket.bearing - 1)
    forces, once = (
        response.rigid_loads.joint_loads.bearing_forces,
        response.rigid_loads.unbalance_forces,
    )
    speed, gravity = float(response.demand.speed[s]), response.inputs.gravity
    if np.isfinite(response.demand.torque[s]):
        yield from _round_the_turn(
            state, forces=HalfTurnSeries(forces.waves[at]), gravity=gravity, speed=speed,
            once=float(once.bearing_forces[at]) if once else None,
        )  # fmt: skip
    worst = response.mount_loads.worst_bearing_forces.get("peak")
    point = worst.operating_point(at) if worst else None
    if worst and point:
        *_, case = _round_the_turn(
            state, forces=HalfTurnSeries(worst.results.half_turn_series.waves[at]), gravity=gravity,
            speed=point.speed, once=float(worst.results.order1[at]) if once else None,
        )  # fmt: skip
        margin = _stop_margin(response, at)
        # Where its force is most by its parts, neither stress nor swing need be.
        here = replace(
            case, component="worst point", operating_point=point,
            is_dynamic=bool(response.inputs.bracket_compliances), stop_margin=margin,
        )  # fmt: skip
        others = _elsewhere(bracket, response, s, found) if found else ()
        yield replace(here, alternatives=(here, *others))


def _elsewhere(
    bracket: Bracket, response: LineResponse, s: int, found: OperatingPointResults
) -> Iterator[BearingLoadCase]:
    """Yield the case of each operating point of a state at which its bearing was evaluated."""
    state, once = response.demand.states[s], response.rigid_loads.unbalance_forces
    for p in range(len(found.speed)):
        point = found.operating_point((p, s))
        if point is None:
            continue
        at = (p, s, bracket.bearing - 1)
        *_, case = _round_the_turn(
            state, forces=HalfTurnSeries(found.results.half_turn_series.waves[at]),
            gravity=response.inputs.gravity, speed=point.speed,
            once=float(found.results.order1[at]) if once else None,
        )  # fmt: skip
        yield replace(
            case, component="worst point", operating_point=point,
            is_dynamic=bool(response.inputs.bracket_compliances),
            stop_margin=_stop_margin(response, at[1:]),
        )  # fmt: skip


def _stop_margin(response: LineResponse, at: tuple[int, int]) -> float:
    """Return what travel to its stop the rubber of a bearing has free in a state; inf within."""
    margins = response.mount_loads.stop_margin("peak")
    free = float(np.broadcast_to(margins, (len(response.demand.states), margins.shape[-1]))[at])
    return free if free < 0 else np.inf


def load_cases_from_recordings(
    bracket: Bracket, on: SolvedBracket | None
) -> Iterator[BearingLoadCase]:
    """Yield a case of each recording; strains become forces by the gauges of a bracket solved.

    A user who read forces back did so by the sliding flange, whose influence is given. Without a
    bracket solved, a case of each recording of forces.
    """
    for one in bracket.recordings:
        force, read = one.force, None
        if one.read and on is not None:
            sliding, clamped = (held.influence[:, :3] for held in on.boundary_cases)
            if one.strain is not None:
                read = recover_loads_and_flange_clamping(
                    sliding, clamped, one.strain, unsure=on.sliding.influence_error
                )
                force = read.loads
            elif force is not None:
                read = correct_loads_for_flange_clamping(
                    sliding, clamped, force, unsure=on.sliding.influence_error
                )
        if force is None:
            continue
        # Forces are those on the bearing: the bracket swings on top of them. What gauges read
        # has its swing in it.
        yield BearingLoadCase(
            one.name,
            load_history_of_forces(force),
            duration=len(force) / one.rate,
            is_dynamic=not one.read,
            recovered_loads=read,
        )


def _round_the_turn(
    state: str,
    *,
    forces: HalfTurnSeries,
    once: float | None,
    gravity: float,
    speed: RadianPerSecond,
) -> Iterator[BearingLoadCase]:
    """Yield the cases of the force on a bearing at a speed, nan where that is not known.

    `once` is what unbalance makes, N 0-to-peak; None where it does not count.
    """
    mean = forces.static
    turn = forces.values(2 * SAMPLES_PER_HALF_TURN)
    # Where weight counts the shafts' is in the forces already, the bracket's is not.
    weight = (0.0, 0.0, gravity)
    second = 2 * np.pi / speed if speed else np.inf  # of one turn, which never ends at rest
    yield BearingLoadCase(state, _history(mean[None], weight), component="static")
    yield BearingLoadCase(
        state, _history((turn - mean)[:SAMPLES_PER_HALF_TURN]), 0.5, second / 2, component="order 2"
    )
    yield BearingLoadCase(
        state, _history(turn[:SAMPLES_PER_HALF_TURN], weight), 0.5, second / 2, component="combined"
    )
    if once is not None:
        theta = 2 * np.pi * np.arange(2 * SAMPLES_PER_HALF_TURN) / (2 * SAMPLES_PER_HALF_TURN)
        round_ = np.stack([np.zeros_like(theta), np.cos(theta), np.sin(theta)], axis=-1)
        # Where the heavy spot is, is unknown: each of eight places is tried. Those opposite are
        # the same half a turn later, when all else has come back.
        starts = [np.roll(round_, 2 * SAMPLES_PER_HALF_TURN // 8 * j, axis=0) for j in range(4)]
        peak = np.concatenate([turn + once * start for start in starts])
        yield BearingLoadCase(
            state, _history(peak, weight), 1.0, second, pass_count=len(starts), component="peak"
        )


def duty_cycle_cases(
    bracket: Bracket, response: LineResponse
) -> dict[EvaluationCondition, list[tuple[float, BearingLoadCase]]]:
    """Return the duty cycle's load histories with their shares, by each state that lasts.

    At the torque and speed of each point of the cycle, the axle wound up by it, on rubber
    where that is known. The joint angles are the state's: those of the cycle itself say
    nothing about where the bearings pull.
    """
    application = response.application
    if not response.inputs.duty_points or response.line.joint_count < 3:
        return {}
    found: dict[EvaluationCondition, list[tuple[float, BearingLoadCase]]] = {
        EvaluationCondition("duty", s.name): []
        for s in application.states
        if s.limit_state_kind in STATE_KINDS_AT_LOADED_RIDE_HEIGHT
    }
    every = np.ones(len(application.states))
    for point in response.inputs.duty_points:
        under = demand_with_axle_moved_by_torque(
            response.demand, torque=point.torque * every, speed=point.speed * every,
            coasts=point.torque < 0,
        )  # fmt: skip
        carried = response.mounts.bearing_forces_at(under, response.layout_for(under))
        free = response.mount_loads.stop_margin_under(under)
        margins = np.broadcast_to(np.where(free < 0, free, np.inf), carried.static.shape)
        for s, state in enumerate(application.states):
            at = s, bracket.bearing - 1
            *_, case = _round_the_turn(
                state.name, forces=HalfTurnSeries(carried.half_turn_series.waves[at]),
                once=float(carried.order1[at]) if application.include_unbalance else None,
                gravity=response.inputs.gravity, speed=point.speed,
            )  # fmt: skip
            if state.limit_state_kind in STATE_KINDS_AT_LOADED_RIDE_HEIGHT:
                found[EvaluationCondition("duty", state.name)].append(
                    (
                        point.share,
                        replace(
                            case,
                            is_dynamic=bool(response.inputs.bracket_compliances),
                            stop_margin=float(margins[at]),
                        ),
                    )
                )
    return found


def _history(
    force: FloatArray, acceleration: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> FloatArray:
    """Return loads (t, 9) of forces (t, 3) with an acceleration of the frame."""
    loads = np.zeros((len(force), len(UNIT_LOAD_NAMES)))
    loads[:, :3], loads[:, 6:] = force, acceleration
    return loads
