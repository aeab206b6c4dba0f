"""Numbers that the tables, chapter and JSON of a bracket study share."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.units import hour
from cardan.model.bracket import BracketRecording
from cardan.physics.fem.strain_gauges import RecoveredLoads
from cardan.topics.bracket.assessment import BracketResult
from cardan.topics.bracket.life import DamageResult
from cardan.topics.bracket.shape_result import CaseResult, ShapeAssessment

STRAIN_PER_MICROSTRAIN = 1e-6
MAX_LISTED_CASES = 8
"""Cases that tables show; the contract has all."""
MAX_MARKED_FATIGUE_FEATURES = 4
"""Features a picture marks."""
MAX_RELIABLE_ERROR_SHARE = 0.05
"""Share of a stress its error may be, before a report says that it is not known."""


def recordings_read_from_gauges(
    of: BracketResult, v: ShapeAssessment
) -> Iterator[tuple[BracketRecording, RecoveredLoads]]:
    """Yield the recordings whose forces are read from gauges."""
    known = {o.case.name: o.case.recovered_loads for o in v.case_results}
    for one in of.bracket.recordings:
        if (read := known.get(one.name)) is not None:
            yield one, read


def root_mean_square(residual: FloatArray) -> float:
    """Return the root mean square of what is left at each moment (t,)."""
    return float(np.sqrt((residual**2).mean()))


def max_fatigue_utilisation(v: ShapeAssessment) -> FloatArray:
    """Return the largest use of its zone's fatigue limit by each feature; nan without any."""
    every = np.array([o.utilisation for o in v.case_results])
    return np.where(np.isnan(every).all(axis=0), np.nan, np.fmax.reduce(every, axis=0))


def highest_stress(v: ShapeAssessment) -> tuple[FloatArray, list[CaseResult]]:
    """Return the highest stress (features,) Pa of each feature, and the case it is of."""
    every = np.array([o.feature_stress for o in v.case_results])
    return every.max(axis=0), [v.case_results[k] for k in every.argmax(axis=0).tolist()]


def feature_hours_to_failure(v: ShapeAssessment) -> FloatArray:
    """Return the hours (features,) to failure: the worst state of the duty cycle, or recording."""
    if not v.life_results:
        return np.full(len(v.features), np.nan)
    rate = np.max([e.hot_spot_damage / e.duration for e in v.life_results], axis=0)
    with np.errstate(divide="ignore"):
        return 1 / (rate * hour)


def feature_hours_bounds(v: ShapeAssessment) -> FloatArray:
    """Return between what hours (features, 2) each feature's life lies by its stress's error."""
    each = [[e.at_spots([k]).hours_bounds for k in range(len(v.features))] for e in v.life_results]
    return np.min(each, axis=0) if each else np.full((len(v.features), 2), np.nan)


def most_stressed_cases(v: ShapeAssessment) -> list[CaseResult]:
    """Return the cases a table shows: those of the highest stress."""
    return sorted(v.case_results, key=lambda o: -o.von_mises.value)[:MAX_LISTED_CASES]


def damage_results(v: ShapeAssessment) -> list[DamageResult]:
    """Return what fatigue does to a variant: cases that repeat, then the duty cycle."""
    return [o.damage_result for o in v.case_results if o.damage_result is not None] + list(
        v.duty_damage
    )


def most_damaging_results(v: ShapeAssessment) -> list[DamageResult]:
    """Return the duty cycle, and the cases that wear most: what a table shows.

    Cases of a state with equal rows of the table are one, reported as the last of them that the
    state has: order 2 is combined with a mean that may add nothing.
    """
    alike: dict[tuple[Any, ...], DamageResult] = {}
    for e in (o.damage_result for o in v.case_results if o.damage_result is not None):
        told = (e.damage_per_turn, e.damage_per_hour, e.hours_to_failure, *e.hours_bounds)
        worst = int(np.nanargmax(e.hot_spot_damage)) if e.worst_damage > 0 else None
        alike[e.when.name, worst, *(f"{x:.3g}" for x in told)] = e
    return [
        *v.duty_damage,
        *sorted(alike.values(), key=lambda e: e.hours_to_failure)[:MAX_LISTED_CASES],
    ]


def any_known(values: FloatArray) -> bool:
    """Return whether any of some features' values is known."""
    return not np.isnan(values).all()
