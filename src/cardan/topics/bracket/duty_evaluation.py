"""Damage over the duty cycle, in each state that lasts."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.labels import EvaluationCondition
from cardan.core.units import hour
from cardan.model.bracket import FatigueZone
from cardan.physics.fatigue.critical_plane import MIN_FULL_COUNT_DAMAGE_SHARE, LoadHistory
from cardan.physics.fem.solve import SolvedBracket
from cardan.topics.bracket.boundary_case import BoundaryCase, FeaturePeaks
from cardan.topics.bracket.case_evaluation import worst_gauge_damage
from cardan.topics.bracket.contact_assessment import MIN_CONTACT_TO_COMPUTED_STRESS_RATIO
from cardan.topics.bracket.feature_fatigue import (
    damage_at_places,
    damage_bounds_of,
    favourable_values,
    known_zone_factors,
    worst_place_damage,
)
from cardan.topics.bracket.life import DamageResult, ZoneFatigueStrength, duty_cycle_damage
from cardan.topics.bracket.load_cases import BearingLoadCase


def evaluate_duty_cycle(
    solved: SolvedBracket,
    ways: tuple[BoundaryCase, ...],
    duty: Mapping[EvaluationCondition, Sequence[tuple[float, BearingLoadCase]]],
    strength: Mapping[FatigueZone, ZoneFatigueStrength],
    modulus: float,
    error: FloatArray,
) -> tuple[list[DamageResult], FloatArray, list[FeaturePeaks]]:
    """Return the mean second of the duty cycle in each state, and the worst one's map.

    The map is damage of an hour (surface nodes,), in the state where it is largest; with it,
    its peaks for each way of holding. Of each feature the worst of all places is reported; those
    that are a thousandth as bad as the worst stand in the map by their largest cycle alone.
    """
    spent: list[DamageResult] = []
    if not strength:
        return spent, np.zeros(0), []
    for when, parts in duty.items():
        if not _duty_passes(ways[0], parts):
            continue
        worst, span = np.zeros(ways[0].count), np.zeros((ways[0].count, 2))
        tight = any(case.stress_factors is not None for _, case in parts)
        eased, each = list[FloatArray](), list[FloatArray]()
        for way in ways:
            passes = _duty_passes(way, parts)
            held = [way.held_by(p.loads) for p in passes]
            top, done = worst_place_damage(way, passes, held, strength)
            worst = np.maximum(worst, done)
            each.append(done)
            kind, low, high = damage_bounds_of(
                way,
                top,
                passes,
                strength,
                error,
                MIN_CONTACT_TO_COMPUTED_STRESS_RATIO if tight else 1.0,
            )
            eased.append(kind)
            span = np.maximum(span, np.stack([low, high], axis=-1))
        gauges = [
            (share, DamageResult(
                when=when, hot_spot_damage=np.zeros(0), turns=case.turns, duration=case.duration,
                gauge_damage=worst_gauge_damage(case, ways[0], modulus, strength["sheet"]),
            ))
            for share, case in parts
        ]  # fmt: skip
        known = known_zone_factors(ways[0].kinds, strength)
        spent.append(
            replace(
                duty_cycle_damage(when, gauges),
                hot_spot_damage=known * worst,
                damage_bounds=known[:, None] * span,
                stop_margin=min(case.stop_margin for _, case in parts),
                favourable_lower_bound=known * favourable_values(ways, eased, tight=tight),
                favourable_damage=known * favourable_values(ways, each, tight=tight),
            )
        )
    if not spent:
        return spent, np.zeros(0), []
    state = max(range(len(spent)), key=lambda k: spent[k].worst_damage)
    damage, peaks = np.zeros(len(solved.nodes.surface_nodes)), list[FeaturePeaks]()
    for way in ways:
        passes = _duty_passes(way, duty[spent[state].when])
        every = damage_at_places(
            way, np.arange(len(way.feature)), passes, strength, closely=MIN_FULL_COUNT_DAMAGE_SHARE
        )
        top = way.highest(every)[:, 0]
        peaks.append(FeaturePeaks.of(way, top, every[top]))
        damage = np.maximum(damage, every[way.held.zones.nearest_place])
    return spent, damage * hour, peaks


def _duty_passes(
    way: BoundaryCase, parts: Sequence[tuple[float, BearingLoadCase]]
) -> list[LoadHistory]:
    """Return the passes of a mean second of a duty cycle."""
    known = [(share, case) for share, case in parts if case.repeats and case.duration > 0]
    whole = sum(share for share, _ in known)
    return [
        LoadHistory(
            np.stack(np.split(way.loads(case), case.pass_count)), share / whole / case.duration,
            scale=1.0 if case.stress_factors is None else case.stress_factors,
        )
        for share, case in known
    ]  # fmt: skip
