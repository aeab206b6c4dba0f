"""Stress, use of the fatigue limit, damage, strains and bolt forces under each load case."""

from collections.abc import Mapping, Sequence

import numpy as np

from cardan.core.arrays import FloatArray, IntArray
from cardan.model.bracket import FatigueZone
from cardan.physics.fatigue.critical_plane import (
    LoadHistory,
    extreme_load_vectors,
    principal_extremes,
)
from cardan.physics.fem.bracket_solid import HOLE_WALL_NAME_SUFFIX
from cardan.physics.fem.meshing import MeshNodes
from cardan.physics.fem.solve import SolvedBracket
from cardan.physics.fem.strain_gauges import RecoveredLoads
from cardan.physics.fem.stress import (
    StressExtreme,
    StressExtremes,
    stress_extremes,
    superpose,
    von_mises,
    von_mises_envelope,
)
from cardan.topics.bracket.boundary_case import PLACES_PER_FEATURE, BoundaryCase, FeaturePeaks
from cardan.topics.bracket.contact_assessment import MIN_CONTACT_TO_COMPUTED_STRESS_RATIO
from cardan.topics.bracket.feature_fatigue import (
    damage_bounds_of,
    error_stress_factors,
    favourable_values,
    known_zone_factors,
    swing_utilisation,
    worst_place_damage,
    zone_utilisation,
)
from cardan.topics.bracket.life import (
    DamageResult,
    ZoneFatigueStrength,
    gauge_damage,
    load_history_of_forces,
)
from cardan.topics.bracket.load_cases import BearingLoadCase
from cardan.topics.bracket.shape_result import CaseResult, LocatedStress, vector_as_tuple

_MIN_PULL_OFF_COSINE = np.cos(np.radians(30))
"""Of the angle between a force and the way out of the frame, below which it pulls straight off."""
_TENSOR_NORM = np.diag([1.0, 1, 1, 2, 2, 2])
"""Of a stress (6,) the square of its size as a tensor, which no principal stress is above."""
_VON_MISES_NORM = _TENSOR_NORM * 1.5 - np.pad(np.full((3, 3), 0.5), (0, 3))
"""And of von Mises."""


def evaluate_cases(
    cases: Sequence[BearingLoadCase],
    solved: SolvedBracket,
    ways: tuple[BoundaryCase, ...],
    error: FloatArray,
    strength: Mapping[FatigueZone, ZoneFatigueStrength],
    modulus: float,
) -> tuple[list[CaseResult], list[list[FeaturePeaks]]]:
    """Return what each case does, and the peaks of each way held."""
    both = [_evaluate_case(case, solved, ways, error, strength, modulus) for case in cases]
    return [outcome for outcome, _ in both], [peaks for _, peaks in both]


def _evaluate_case(
    case: BearingLoadCase,
    solved: SolvedBracket,
    ways: tuple[BoundaryCase, ...],
    error: FloatArray,
    strength: Mapping[FatigueZone, ZoneFatigueStrength],
    modulus: float,
) -> tuple[CaseResult, list[FeaturePeaks]]:
    """Return what one case does, the worse of both ways of holding, and the peaks of each.

    In fatigue, so many `times` its own stress.
    """
    count = ways[0].count
    times = np.ones(count) if case.stress_factors is None else case.stress_factors
    if not np.isfinite(case.loads).all():
        load_history_of_forces(case.loads)  # which says what is wrong
    hot, mean, amplitude, swung, off = np.zeros((5, count))
    least, spent = np.full((2, count), np.nan)
    span = np.full((count, 2), np.nan)
    swung_ends, eased = list[FloatArray](), list[FloatArray]()
    each_used, each_spent = list[FloatArray](), list[FloatArray]()
    ease = 1.0 if case.stress_factors is None else MIN_CONTACT_TO_COMPUTED_STRESS_RATIO
    best: list[tuple[LocatedStress, LocatedStress, LocatedStress]] = []
    peaks: list[FeaturePeaks] = []
    for way in ways:
        loads = way.loads(case)
        places = way.places(loads)
        flat = places.ravel()
        unit = way.unit[flat]
        level, found = _stressed(unit, loads, way.rms_stress_per_load)
        best.append(tuple(
            LocatedStress(e.value, vector_as_tuple(way.points[flat[e.point]]))
            for e in (found.von_mises, found.max_principal, found.min_principal)
        ))  # type: ignore[arg-type]  # fmt: skip
        level = level.reshape(places.shape)
        level *= way.has[:, None]
        top = places[np.arange(count), level.argmax(axis=1)]
        peaks.append(FeaturePeaks.of(way, top, level.max(axis=1)))
        peak, swing = np.abs(loads[:, :3]).max(axis=0), np.ptp(loads[:, :3], axis=0) / 2
        off = np.where(
            level.max(axis=1) > hot, _gauge_reading_error(way, top, case.recovered_loads, peak), off
        )
        hot = np.maximum(hot, level.max(axis=1))
        least = np.fmin(least, np.where(way.has, level.max(axis=1), np.nan))
        passes = np.stack(np.split(loads, case.pass_count))
        held = way.held_by(passes)
        share, m, a = swing_utilisation(way, passes, held, strength, times)
        most = way.highest(share)[:, 0]
        each_used.append(share[most])
        worse = share[most] * way.has > swung
        swung = np.where(worse, share[most], swung)
        mean, amplitude = np.where(worse, m[most], mean), np.where(worse, a[most], amplitude)
        doubt = _gauge_reading_error(way, most, case.recovered_loads, swing) / np.maximum(
            a[most], 1e-9
        )
        if strength and case.repeats:
            ends = times * error_stress_factors(error + doubt, ease)
            swung_ends.append(np.stack([
                zone_utilisation(way.kinds, more * m[most], more * a[most], strength)
                for more in ends
            ]))  # fmt: skip
            does = [LoadHistory(passes, scale=times)]
            worn, done = worst_place_damage(way, does, [held], strength)
            kind, low, high = damage_bounds_of(way, worn, does, strength, error + doubt, ease)
            eased.append(kind)
            span = np.fmax(span, np.stack([low, high], axis=-1))
            spent = np.fmax(spent, done)
            each_spent.append(done)
    tight = case.stress_factors is not None
    used_within, known = np.full((count, 2), np.nan), known_zone_factors(ways[0].kinds, strength)
    if swung_ends:
        least_used = [kind for kind, *_ in swung_ends]
        most_used = [np.where(w.has, e[-1], 0.0) for w, e in zip(ways, swung_ends, strict=True)]
        used_within[:, 0] = favourable_values(ways, least_used, tight=tight)
        used_within[:, 1] = np.max(most_used, axis=0)
        used_within *= known[:, None]
    sliding = ways[0]
    loads = sliding.loads(case)
    strain = superpose(sliding.influence[..., None], loads)[..., 0]
    bolts = superpose(sliding.reactions, loads)
    motion = loads @ sliding.moves
    life = None
    if strength and case.repeats:
        gauges = worst_gauge_damage(case, sliding, modulus, strength["sheet"])
        life = DamageResult(
            when=case.when, hot_spot_damage=known * spent, gauge_damage=gauges,
            turns=case.turns, duration=case.duration, damage_bounds=known[:, None] * span,
            stop_margin=case.stop_margin,
            favourable_lower_bound=known * favourable_values(ways, eased, tight=tight),
            favourable_damage=known * favourable_values(ways, each_spent, tight=tight),
        )  # fmt: skip
    found = CaseResult(
        case=case,
        von_mises=max((b[0] for b in best), key=lambda f: f.value),
        max_principal=max((b[1] for b in best), key=lambda f: f.value),
        min_principal=min((b[2] for b in best), key=lambda f: f.value),
        max_nodal_von_mises=_max_nodal_von_mises(solved, case.loads),
        feature_stress=hot,
        feature_stress_error=error * hot + off,
        min_feature_stress=np.nan_to_num(least),
        mean=mean,
        amplitude=amplitude,
        utilisation=known * swung if case.repeats else np.full(count, np.nan),
        favourable_utilisation=(
            known * favourable_values(ways, each_used, tight=tight)
            if case.repeats
            else np.full(count, np.nan)
        ),
        utilisation_bounds=used_within,
        gauge_strain_range=np.stack([strain.min(axis=-1), strain.max(axis=-1)], axis=-1),
        bolt_forces=np.linalg.norm(bolts, axis=-1).max(axis=-1),
        seat_displacement=float(np.linalg.norm(motion, axis=-1).max()),
        damage_result=life,
        pulls_off=_pulls_off(solved.nodes, case.loads[:, :3]),
    )
    return found, peaks


def _stressed(
    unit: FloatArray, loads: FloatArray, worth: FloatArray
) -> tuple[FloatArray, StressExtremes]:
    """Return the highest von Mises stress (m,) Pa of unit stresses (m, c, 6) under loads (t, c).

    And the extremes of all. Of a long history at the moments that lie farthest from no load, and at
    all of them where one of the others may make more: of compression they may.
    """
    outer, ways = extreme_load_vectors(loads, worth)
    level, found = von_mises_envelope(unit, outer), stress_extremes(unit, outer)
    beyond = superpose(unit, ways.T)
    mises, tension = (
        np.sqrt(np.linalg.eigvalsh(beyond @ of @ beyond.mT).max(axis=1, initial=0.0))
        for of in (_VON_MISES_NORM, _TENSOR_NORM)
    )
    left = np.flatnonzero((mises > level) | (tension > found.max_principal.value))
    if len(left):
        level[left], also = (
            von_mises_envelope(unit[left], loads),
            stress_extremes(unit[left], loads),
        )
        found = StressExtremes(
            max(found.von_mises, also.with_point_numbers(left).von_mises, key=_value),
            max(found.max_principal, also.with_point_numbers(left).max_principal, key=_value),
            min(found.min_principal, also.with_point_numbers(left).min_principal, key=_value),
        )
    return level, found


def _value(of: StressExtreme) -> float:
    return of.value


def _gauge_reading_error(
    way: BoundaryCase, at: IntArray, read: RecoveredLoads | None, size: FloatArray
) -> FloatArray:
    """Return the stress (m,) Pa at places that what gauges read wrong makes of forces (3,) N.

    Nothing where no forces are read from gauges.
    """
    if read is None:
        return np.zeros(len(at))
    each = von_mises(superpose(way.unit[at, :3], read.load_error_components(size).T))
    return np.linalg.norm(each, axis=1)


def _pulls_off(nodes: MeshNodes, forces: FloatArray) -> bool:
    """Return whether the largest of forces (t, 3) N pulls all washers' rings off their frame."""
    rings = np.char.startswith(nodes.face_names, "bolt ") & ~np.char.endswith(
        nodes.face_names, HOLE_WALL_NAME_SUFFIX
    )
    a, b, c = (nodes.points[nodes.faces[rings, k]] for k in range(3))
    out = np.cross(b - a, c - a).sum(axis=0)
    largest = forces[np.linalg.norm(forces, axis=1).argmax()]
    size = np.linalg.norm(out) * np.linalg.norm(largest)
    return bool(size > 0 and -out @ largest > _MIN_PULL_OFF_COSINE * size)


def worst_gauge_damage(
    case: BearingLoadCase, way: BoundaryCase, modulus: float, strength: ZoneFatigueStrength
) -> FloatArray:
    """Return the damage (g,) a pass does at the gauges, by the sheet's curve."""
    passes = np.split(way.loads(case), case.pass_count)
    return np.max([
        gauge_damage(way.influence, one, modulus=modulus, strength=strength) for one in passes
    ], axis=0)  # fmt: skip


def _max_nodal_von_mises(solved: SolvedBracket, loads: FloatArray) -> LocatedStress:
    """Return the largest von Mises stress at any node of the surface."""
    surface, (stress, worth) = solved.nodes.surface_nodes, solved.surface_stress
    level = von_mises_envelope(stress, principal_extremes(loads, worth))
    top = np.argsort(-level)[:PLACES_PER_FEATURE]
    level = von_mises_envelope(stress[top], loads)
    worst = int(level.argmax())
    return LocatedStress(
        float(level[worst]), vector_as_tuple(solved.nodes.points[surface[top[worst]]])
    )
