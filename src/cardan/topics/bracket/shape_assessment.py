"""Judge one shape of a bracket: what each load case and the duty cycle do, zone by zone.

Everything follows from the unit stresses of the last mesh by adding them up. The flange is
held in two ways that have the truth between them, sliding and clamped, and the value reported of
a feature is the worse of the two.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain

import numpy as np

from cardan.core.arrays import BoolArray, FloatArray, IntArray
from cardan.core.errors import ConvergenceError, DesignError
from cardan.core.status import StatusCallback, ignore_status
from cardan.core.units import Metre, RadianPerSecond, mm
from cardan.model.bracket import FATIGUE_ZONES, Bolts, Bracket, FatigueZone, Shape
from cardan.physics.fem.adaptive_refinement import MAX_MESHES
from cardan.physics.fem.fatigue_zones import ZONE_WELD_TOE
from cardan.physics.fem.solve import SolvedBracket, SolveRequest, solve_in_subprocess
from cardan.physics.fem.unit_loads import UNIT_LOAD_NAMES
from cardan.topics.bracket.boundary_case import BoundaryCase, FeaturePeaks, boundary_cases_of
from cardan.topics.bracket.case_evaluation import evaluate_cases
from cardan.topics.bracket.contact_assessment import BoltedContactAnalysis, ContactResult
from cardan.topics.bracket.duty_evaluation import evaluate_duty_cycle
from cardan.topics.bracket.forced_response import (
    BearingForceSweep,
    ForcedResponse,
    largest_normal_stress_amplitude,
)
from cardan.topics.bracket.life import DamageResult, ZoneFatigueStrength, fatigue_strength_by_zone
from cardan.topics.bracket.load_cases import BearingLoadCase, BracketLoads, DutyCycleLoadHistories
from cardan.topics.bracket.operating_points import worst_operating_points
from cardan.topics.bracket.shape_result import (
    BoltSlipUtilisation,
    CaseResult,
    FatigueFeature,
    ResonanceCrossing,
    ShapeAssessment,
    recording_damage,
    vector_as_tuple,
)

RESONANCE_CHECK_ORDERS = (1, 2, 4)
"""Unbalance; joints; joints at large angles."""
_HEAT_AFFECTED_DISTANCES = (6 * mm, 20 * mm), (12 * mm, 30 * mm), (25 * mm, 35 * mm)
"""Wall thickness, and how far the heat of a weld reaches in a wall as thick at most."""
_MAX_HEAT_AFFECTED_DISTANCE = 40 * mm
"""How far it reaches in thicker walls."""


def assess_shape(
    bracket: Bracket,
    shape: Shape,
    cases: Sequence[BearingLoadCase],
    *,
    duty: DutyCycleLoadHistories | None = None,
    mounted: Callable[[SolvedBracket], BracketLoads] | None = None,
    name: str = "original",
    top_speed: RadianPerSecond = np.nan,
    levels: int = MAX_MESHES,
    tell: StatusCallback = ignore_status,
) -> ShapeAssessment:
    """Judge one shape of a bracket under load cases, and over a duty cycle's.

    Damage is counted where the bracket states what it bears in fatigue. `mounted` says what
    the cases and the cycle become on a bracket that gives; those given are what the mesh is
    made for, in as many `levels` at most.

    Raises
    ------
    DesignError
        If there is no case, or the shape cannot be built, meshed or afforded.
    """
    if not cases:
        msg = "the bracket has no load case: give the application a torque, or the bracket cases"
        raise DesignError(msg)

    def told(what: str) -> None:
        tell(f"{name}: {what}")

    strength = fatigue_strength_by_zone(bracket)
    riding = [case for parts in (duty or {}).values() for _, case in parts]
    task = SolveRequest(
        shape=shape,
        material=bracket.material,
        element_size=bracket.element,
        element_degree=bracket.order,
        cases=tuple(c.extreme_loads for c in (*cases, *riding)),
        zone_weights=_weights(strength),
        gauges=bracket.gauges,
        carried_mass=bracket.carried_mass,
        mount_stiffness=bracket.rubber,
        loss_factor=bracket.loss,
        max_meshes=levels,
        condenses_contact=bracket.bolts is not None,
        recovers_forces=any(one.read for one in bracket.recordings),
    )
    try:
        solved = solve_in_subprocess(task, tell=told)
    except DesignError as error:
        msg = f"{name} bracket: {error}"
        raise DesignError(msg, about=error.about) from None
    swept: BearingForceSweep | None = None
    if mounted is not None:
        told("the line on this bracket")
        on = mounted(solved)
        cases, duty, swept = on.cases, on.duty, on.sweep
    told(f"stresses of {len(cases)} load cases")
    ways, known = boundary_cases_of(solved)
    cases = [worst for case in cases for worst in worst_operating_points(case, ways, strength)]
    error = np.array([solved.error.get(key, 0.0) for key in known])
    modulus = bracket.material.youngs_modulus
    outcomes, peaks = evaluate_cases(cases, solved, ways, error, strength, modulus)
    in_bolts, riding = None, list[BoltSlipUtilisation]()
    if bracket.bolts is not None:
        told("contact between flange and frame")
        contact = _tightened(bracket.bolts, solved, ways, strength)
        alone, *_ = evaluate_duty_cycle(solved, ways, duty or {}, strength, modulus, error)
        two_ways = [o.utilisation for o in outcomes]
        cases = [_in_contact(case, contact, ways[0]) for case in cases]
        duty = {
            when: [(share, _in_contact(case, contact, ways[0])) for share, case in parts]
            for when, parts in (duty or {}).items()
        }
        outcomes, peaks = evaluate_cases(cases, solved, ways, error, strength, modulus)
        outcomes = [_held(o, contact, ways[0]) for o in outcomes]
        riding = [
            BoltSlipUtilisation(
                when,
                contact.slip_utilisation(
                    np.concatenate([_bare(case, ways[0]) for _, case in parts])
                ),
                stop_margin=min(case.stop_margin for _, case in parts),
            )
            for when, parts in duty.items()
            if parts
        ]
        life = min((e.hours_to_failure for e in alone), default=np.nan)
        in_bolts = _in_bolts(bracket.bolts, outcomes, two_ways, life)
    if duty and strength:
        told("damage over the duty cycle, at every place of the surface")
    spent, damage, worn = evaluate_duty_cycle(solved, ways, duty or {}, strength, modulus, error)
    order = _worst_first(known, outcomes, spent or recording_damage(outcomes), _weights(strength))
    spots = _spots(worn or [*chain.from_iterable(peaks)], order)
    # What its highest stress may be off by, read from gauges or not.
    high = np.array([o.feature_stress for o in outcomes])
    off = np.take_along_axis(
        np.array([o.feature_stress_error for o in outcomes]), high.argmax(axis=0)[None], 0
    )[0]
    share = np.where(high.any(axis=0), off / np.maximum(high.max(axis=0), 1e-300), error)
    soft = bracket.material.weld_softens
    heated = _beside_welds(ways, shape.thickness) if soft else np.zeros(len(known), dtype=bool)
    features = tuple(
        FatigueFeature(
            zone=FATIGUE_ZONES[known[f][0]], number=known[f][1],
            point=vector_as_tuple(way.points[at]),
            error=float(share[f]), beside_weld=bool(heated[f]),
        )
        for f, (way, at) in zip(order.tolist(), spots, strict=True)
    )  # fmt: skip
    return ShapeAssessment(
        name=name,
        solved=solved,
        features=features,
        listed_count=_listed(features),
        forced_response=None if swept is None else _forced(swept, spots[: _listed(features)]),
        crossings=tuple(resonance_crossings(solved.sliding.loaded_frequencies, top_speed)),
        case_results=tuple(_sorted(o, order) for o in outcomes),
        duty_damage=tuple(e.at_spots(order) for e in spent),
        damage_map=damage,
        contact_result=None
        if in_bolts is None
        else replace(
            in_bolts,
            stress_factors=in_bolts.stress_factors[order],
            utilisation_without_contact=in_bolts.utilisation_without_contact[order],
        ),
        duty_slips=tuple(riding),
    )


def _beside_welds(ways: Sequence[BoundaryCase], thickness: Metre) -> BoolArray:
    """Return which features (features,) have a place that a weld's heat reaches.

    As far as 20 mm from the weld's toe in 6 mm, 30 in 12, 35 in 25, else 40. Source: EN 1999-1-1,
    6.1.6.3, of MIG welds; quoted, unverified.
    """
    from scipy.spatial import cKDTree

    reach = next(
        (far for thick, far in _HEAT_AFFECTED_DISTANCES if thickness <= thick),
        _MAX_HEAT_AFFECTED_DISTANCE,
    )
    found = np.zeros(ways[0].count, dtype=bool)
    for way in ways:
        toes = way.points[way.held.zones.kind == ZONE_WELD_TOE]
        if len(toes):
            away, _ = cKDTree(toes).query(way.points)
            found[way.feature[away <= reach]] = True
    return found


def _tightened(
    bolts: Bolts,
    solved: SolvedBracket,
    ways: tuple[BoundaryCase, ...],
    strength: Mapping[FatigueZone, ZoneFatigueStrength],
) -> BoltedContactAnalysis:
    try:
        return BoltedContactAnalysis.from_solution(
            solved, [way.feature for way in ways], bolts=bolts,
            count=ways[0].count, strength=strength,
        )  # fmt: skip
    except ConvergenceError as error:
        raise DesignError(str(error), about="bracket.bolts") from error


def _bare(case: BearingLoadCase, way: BoundaryCase) -> FloatArray:
    """Return the loads (t, 9) of a case, with what it swings but for its own modes."""
    return way.loads(case)[:, : len(UNIT_LOAD_NAMES)]


def _held(o: CaseResult, contact: BoltedContactAnalysis, way: BoundaryCase) -> CaseResult:
    """Return an outcome with the use of its bolts, at the operating point that uses most."""
    among = o.case.alternatives or (o.case,)
    each = [_bare(case, way) for case in among]
    moment, share = contact.worst_slip(np.concatenate(each))
    which = int(np.searchsorted(np.cumsum([len(e) for e in each]), moment, side="right"))
    return replace(
        o,
        stress_factors=o.case.stress_factors,
        slip_utilisation=share,
        slip_point=among[which].operating_point,
    )


def _in_contact(
    case: BearingLoadCase, contact: BoltedContactAnalysis, way: BoundaryCase
) -> BearingLoadCase:
    """Return a case with what contact makes of its swings, where it repeats."""
    if not (contact.strength and case.repeats):
        return case
    return replace(
        case, stress_factors=contact.stress_factors(np.split(_bare(case, way), case.pass_count))
    )


def _in_bolts(
    bolts: Bolts, outcomes: Sequence[CaseResult], two_ways: Sequence[FloatArray], life: float
) -> ContactResult:
    """Return what contact makes of swings, in the case that uses most of a fatigue limit.

    Of those that its bolts hold.
    """
    lasting = [
        k
        for k, o in enumerate(outcomes)
        if o.stress_factors is not None and o.slip_utilisation <= 1
    ]
    if not lasting:
        nothing = np.full(len(two_ways[0]), np.nan)
        return ContactResult(
            bolts=bolts, when=None, stress_factors=nothing, utilisation_without_contact=nothing
        )
    k = max(lasting, key=lambda k: float(np.nanmax(outcomes[k].utilisation)))
    times = outcomes[k].stress_factors
    assert times is not None
    return ContactResult(
        bolts=bolts,
        when=outcomes[k].case.when,
        stress_factors=times,
        utilisation_without_contact=two_ways[k],
        life_without_contact=life,
    )


def _weights(strength: Mapping[FatigueZone, ZoneFatigueStrength]) -> tuple[float, ...]:
    """Return how much a stress weighs in each zone: a toe bears less than a sheet."""
    if not strength:
        return (1.0,) * len(FATIGUE_ZONES)
    sheet = strength["sheet"]
    return tuple(
        sheet.curve.amplitude / strength.get(zone, sheet).curve.amplitude for zone in FATIGUE_ZONES
    )


def _worst_first(
    known: tuple[tuple[int, int], ...],
    outcomes: Sequence[CaseResult],
    lasting: Sequence[DamageResult],
    weights: tuple[float, ...],
) -> IntArray:
    """Return the features, the worst first: by damage of a second, else by stress."""
    weight = np.array([weights[kind] for kind, _ in known])
    stress = np.max([o.feature_stress for o in outcomes], axis=0) * weight
    rates = [e.hot_spot_damage / e.duration for e in lasting] or [np.zeros(len(known))]
    damage = np.nan_to_num(np.max(rates, axis=0))
    return np.lexsort((-stress, -damage))


def _spots(peaks: Sequence[FeaturePeaks], order: IntArray) -> list[tuple[BoundaryCase, int]]:
    """Return how it is held, and the place, where each feature is worst."""
    highest = np.argmax([peak.values for peak in peaks], axis=0)
    return [(peaks[highest[f]].way, int(peaks[highest[f]].places[f])) for f in order.tolist()]


def _forced(swept: BearingForceSweep, spots: Sequence[tuple[BoundaryCase, int]]) -> ForcedResponse:
    """Return the response over speed at places."""
    found, rigid = [], []
    for way, at in spots:
        unit, normals = way.unit[[at]], way.held.zones.normals[[at]]
        found.append(
            largest_normal_stress_amplitude(
                unit,
                normals,
                swept.force_amplitudes,
                speed=swept.speed,
                seat=way.held.modal_model.bracket_compliance,
            )
        )
        rigid.append(
            largest_normal_stress_amplitude(
                unit, normals, swept.rigid_force_amplitudes, speed=swept.speed
            )
        )
    return ForcedResponse(
        sweep=swept,
        stress=np.concatenate(found, axis=-1),
        rigid_stress=np.concatenate(rigid, axis=-1),
    )


def _listed(features: Sequence[FatigueFeature]) -> int:
    """Return how many features tables show: eight, and on until each zone has been shown."""
    zones = {f.zone for f in features}
    first = [next(k for k, f in enumerate(features) if f.zone == zone) for zone in zones]
    return min(len(features), max(8, *(k + 1 for k in first if k < 16)))


def _sorted(o: CaseResult, order: IntArray) -> CaseResult:
    """Return an outcome with its features in order."""
    return replace(
        o,
        feature_stress=o.feature_stress[order],
        feature_stress_error=o.feature_stress_error[order],
        mean=o.mean[order],
        amplitude=o.amplitude[order],
        utilisation=o.utilisation[order],
        favourable_utilisation=o.favourable_utilisation[order],
        utilisation_bounds=o.utilisation_bounds[order],
        min_feature_stress=o.min_feature_stress[order],
        stress_factors=None if o.stress_factors is None else o.stress_factors[order],
        damage_result=o.damage_result.at_spots(order) if o.damage_result else None,
    )


def resonance_crossings(
    frequencies: FloatArray,
    top_speed: RadianPerSecond,
    *,
    orders: Sequence[int] = RESONANCE_CHECK_ORDERS,
) -> Iterator[ResonanceCrossing]:
    """Yield the speeds at which orders meet natural frequencies (m,) Hz, up to twice the top."""
    for k, frequency in enumerate(frequencies.tolist(), 1):
        for order in orders:
            speed = 2 * np.pi * frequency / order
            if not speed > 2 * top_speed:
                yield ResonanceCrossing(
                    k, frequency, order, speed, in_range=bool(speed <= top_speed)
                )
