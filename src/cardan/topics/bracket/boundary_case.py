"""One boundary condition of the flange, sliding or clamped: unit stresses, loads, worst places."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from cardan.core.arrays import FloatArray, IntArray
from cardan.physics.fatigue.critical_plane import (
    load_envelope,
    mohr_components,
    normal_stress_on_planes,
    plane_directions,
    principal_extremes,
    principal_load_projections,
)
from cardan.physics.fatigue.rainflow import turning_points
from cardan.physics.fem.solve import ConstrainedBracketSolution, SolvedBracket
from cardan.physics.fem.stress import von_mises_envelope
from cardan.physics.fem.unit_loads import UNIT_LOAD_NAMES
from cardan.topics.bracket.load_cases import BearingLoadCase

_MAX_UNTHINNED_MOMENTS = 2000
"""Moments beyond which a history is thinned to those that any stress turns at."""
_MIN_TURN_SHARE = 0.01
"""Share of a history's range that its turns must have to be kept."""
PLACES_PER_FEATURE = 6
"""The most stressed places of a feature, whose stress is computed at every moment."""


@dataclass(frozen=True)
class BoundaryCase:
    """One way of holding a bracket, its features numbered as those of both.

    Loads have the columns of `UNIT_LOAD_NAMES`, and beyond them those of the modes it swings in.
    """

    held: ConstrainedBracketSolution
    points: FloatArray
    feature: IntArray
    kinds: IntArray
    """Of its features the place of their zone in `FATIGUE_ZONES`, (features,)."""

    @property
    def count(self) -> int:
        """How many features both ways have."""
        return len(self.kinds)

    @cached_property
    def unit(self) -> FloatArray:
        """Stress (places, c, 6) Pa of each column of its loads."""
        return np.concatenate([self.held.unit_stress, self.held.modal_model.unit_stress], axis=1)

    @cached_property
    def flat(self) -> FloatArray:
        """Stress in the surface (places, 3, c) Pa of each column of its loads."""
        return mohr_components(self.unit, self.held.zones.normals)

    def planes(self, at: IntArray) -> FloatArray:
        """Return the normal stress (m, planes, c) Pa of each column of its loads at places (m,)."""
        return normal_stress_on_planes(self.unit[at], plane_directions(self.held.zones.normals[at]))

    def held_by(self, passes: FloatArray) -> "BoundingCycles":
        """Return what no place's stress leaves under passes (p, t, c)."""
        found = load_envelope(passes, self.rms_stress_per_load)
        return BoundingCycles(found.cycle_levels, *found.mean_and_amplitude(self.flat))

    @cached_property
    def rms_stress_per_load(self) -> FloatArray:
        """How much each column of its loads stresses, (c,) Pa."""
        return np.sqrt(np.mean(self.unit**2, axis=(0, 2)))

    @cached_property
    def influence(self) -> FloatArray:
        """Strain (gauges, c) of each column of its loads."""
        return np.concatenate([self.held.influence, self.held.modal_model.influence], axis=1)

    @cached_property
    def reactions(self) -> FloatArray:
        """Force on each bolt (b, c, 3) N of each column of its loads."""
        return np.concatenate([self.held.reactions, self.held.modal_model.reactions], axis=1)

    @cached_property
    def moves(self) -> FloatArray:
        """Motion of the seat (c, 3) m of each column of its loads; forces and modes alone."""
        own = self.held.modal_model.bracket_compliance.seat_mode_shapes[
            : self.held.modal_model.unit_stress.shape[1]
        ]
        rest = np.zeros((len(UNIT_LOAD_NAMES) - 6, 3))
        return np.concatenate([self.held.compliance[:, :3], rest, own])

    def loads(self, case: BearingLoadCase) -> FloatArray:
        """Return the loads of a case (t, c), with what the bracket swings on top of them."""
        swings = self.held.modal_model.unit_stress.shape[1]
        found = np.pad(case.loads, ((0, 0), (0, swings)))
        if not (case.is_dynamic and np.isfinite(case.duration)):
            return found if case.pass_count > 1 else self.telling(found)
        columns = [*range(3), *range(len(UNIT_LOAD_NAMES), len(UNIT_LOAD_NAMES) + swings)]
        each = found.reshape(case.pass_count, -1, found.shape[1])  # a view: what is added stays
        each[..., columns] += self.held.modal_model.bracket_compliance.dynamic_increment_history(
            each[..., :3], case.duration
        )
        return found if case.pass_count > 1 else self.telling(found)

    def telling(self, loads: FloatArray, share: float = _MIN_TURN_SHARE) -> FloatArray:
        """Return the moments of a long history that any stress turns at, the others left out.

        Kept is where any of the ways in which they go `along` turns by more than a share of the
        range of the way that stresses most: a hundredth, which no cycle that does harm is below.
        """
        if len(loads) <= _MAX_UNTHINNED_MOMENTS:
            return loads
        ways = principal_load_projections(loads, self.rms_stress_per_load, alike=False)
        most = share * float(np.ptp(ways, axis=0).max())
        if not most:  # a sensor that stands still, or reads nothing
            return loads[:1]
        kept = [
            turning_points(gone, gate=most / np.ptp(gone)) for gone in ways.T if np.ptp(gone) > 0
        ]
        return loads[np.unique(np.concatenate(kept))]

    def places(self, loads: FloatArray) -> IntArray:
        """Return the places (features, k) where loads may be worst, a feature's own repeated."""
        return self.highest(
            von_mises_envelope(self.unit, principal_extremes(loads, self.rms_stress_per_load))
        )

    def highest(self, values: FloatArray) -> IntArray:
        """Return the places (features, k) where values (places,) are highest, highest first."""
        order = np.lexsort((-values, self.feature))
        starts = np.searchsorted(self.feature[order], np.arange(self.count))
        ends = np.searchsorted(self.feature[order], np.arange(self.count), side="right")
        # A feature that this way of holding does not have shows the first place, and no stress.
        at = np.minimum(
            starts[:, None] + np.arange(PLACES_PER_FEATURE), np.maximum(ends[:, None] - 1, 0)
        )
        return order[np.minimum(at, len(order) - 1)]

    @cached_property
    def has(self) -> IntArray:
        """Return whether it has each feature, 1 or 0."""
        return np.bincount(self.feature, minlength=self.count).clip(max=1)


class BoundingCycles(NamedTuple):
    """Mean and amplitude (places,) Pa that harm as any cycle of a pass; shares it has of them."""

    levels: tuple[tuple[float, float], ...]
    mean: FloatArray
    amplitude: FloatArray


@dataclass(frozen=True)
class FeaturePeaks:
    """The place (features,) of each feature that is worst, held one way, and how bad it is there.

    Below nothing where the feature is not there, held that way.
    """

    way: BoundaryCase
    places: IntArray
    values: FloatArray

    @classmethod
    def of(cls, way: BoundaryCase, places: IntArray, values: FloatArray) -> "FeaturePeaks":
        """Return the peaks of a way of holding."""
        return cls(way, places, np.where(way.has, values, -1.0))


def boundary_cases_of(
    solved: SolvedBracket,
) -> tuple[tuple[BoundaryCase, ...], tuple[tuple[int, int], ...]]:
    """Return both ways of holding, and the features (kind, number) of both together."""
    every = sorted({f for held in solved.boundary_cases for f in held.zones.features})
    place = {key: k for k, key in enumerate(every)}
    ways = tuple(
        BoundaryCase(
            held,
            held.zones.points(solved.nodes),
            np.array([place[f] for f in held.zones.features])[held.zones.feature],
            np.array([kind for kind, _ in every]),
        )
        for held in solved.boundary_cases
    )
    return ways, tuple(every)
