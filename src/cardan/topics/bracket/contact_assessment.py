"""A bracket in its bolts: what contact and friction make of the swings of every case.

What presses a flange lifts off and rubs, so stress is no sum of unit stresses. Of each load
history those moments are followed between which its features swing most, each from the
tightened state; the swing of each feature, over that the two ways to be held make of it, then
scales all its cycles in that history. The share of their strength that the bolts use is
reported for every case: where that is more than all, nothing is scaled, and the joint slides.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cardan.core.arrays import FloatArray, IntArray
from cardan.core.errors import ConvergenceError
from cardan.core.labels import EvaluationCondition
from cardan.model.bracket import FATIGUE_ZONES, Bolts, FatigueZone
from cardan.physics.fatigue.critical_plane import normal_stress_on_planes, plane_directions
from cardan.physics.fem.bolted_joint import PreloadedFlange
from cardan.physics.fem.solve import ConstrainedBracketSolution, SolvedBracket
from cardan.physics.fem.unit_loads import UNIT_LOAD_NAMES
from cardan.topics.bracket.life import ZoneFatigueStrength

MAX_CONTACT_STRESS_ERROR_SHARE = 0.2
"""Share by which stress in contact may be too low: CalculiX has at most 9 % more on the same mesh
under the same heads, 6 % with bolts that give, and shapes that were not compared may have more
(docs/bracket-method.md)."""
MIN_CONTACT_TO_COMPUTED_STRESS_RATIO = 1 / (1 + MAX_CONTACT_STRESS_ERROR_SHARE) ** 2
"""Least ratio of true to reported stress in contact: without that share, and as much below."""
_LOW = 0.2
"""Share of the most used feature below which one is left as the two ways have it."""
_ALIKE = 0.03
"""Share of a history's range within which two of its moments are one."""
_PLANES = 3
"""Of the planes of a place one in three is evaluated: both ways miss the same 2 % of shear."""
_SHARES = 8
"""Moments of a history at most of which the bolts are evaluated."""


@dataclass(frozen=True, kw_only=True)
class ContactResult:
    """What contact makes of a bracket's swings, in the case that uses most of a fatigue limit.

    Attributes
    ----------
    when
        That case; None where none that repeats is held, or no fatigue limit is known.
    stress_factors : (features,)
        Swing of each feature in contact, on its safe side, over that by the worse of the two
        ways held.
    utilisation_without_contact : (features,)
        What that case uses of each feature's fatigue limit by the two ways.
    life_without_contact
        Hours over the duty cycle by the two ways; nan without one.
    """

    bolts: Bolts
    when: EvaluationCondition | None
    stress_factors: FloatArray
    utilisation_without_contact: FloatArray
    life_without_contact: float = np.nan


@dataclass(frozen=True, kw_only=True)
class BoltedContactAnalysis:
    """A flange tightened against its frame, and the places where its stress is followed.

    `on_rigid_frame` is on a hard frame, `on_elastic_frame` on one as flexible as thick metal.
    `place_features` are those
    of the places of each way held, `feature_count` how many there are in all.
    """

    on_rigid_frame: PreloadedFlange
    on_elastic_frame: PreloadedFlange
    solved: SolvedBracket
    place_features: tuple[IntArray, ...]
    feature_count: int
    strength: Mapping[FatigueZone, ZoneFatigueStrength]

    @classmethod
    def from_solution(
        cls,
        solved: SolvedBracket,
        features: Sequence[IntArray],
        *,
        bolts: Bolts,
        count: int,
        strength: Mapping[FatigueZone, ZoneFatigueStrength],
    ) -> "BoltedContactAnalysis":
        """Return a bracket with its bolts tightened.

        Raises
        ------
        ConvergenceError
            If they cannot press it on.
        """
        assert solved.contact_model is not None
        joint = solved.contact_model.flange
        return cls(
            on_rigid_frame=joint.tighten(bolts),
            on_elastic_frame=joint.on_elastic_frame.tighten(bolts),
            solved=solved,
            place_features=tuple(features),
            feature_count=count,
            strength=strength,
        )

    def slip_utilisation(self, loads: FloatArray) -> float:
        """Return what share loads (t, 9) are of those under which the bolts slip or open."""
        return self.worst_slip(loads)[1]

    def worst_slip(self, loads: FloatArray) -> tuple[int, float]:
        """Return at which moment loads (t, 9) use most of the bolts' strength, and that `share`.

        The most of all moments: where no other can have more by the balance of those
        evaluated, or after so many. Balance knows no frame, contact does: of both frames the worse.
        """
        planes = np.zeros((0, len(UNIT_LOAD_NAMES)))
        asked: dict[int, float] = {}
        for k in _outermost(loads).tolist():
            asked[k], plane = self.on_rigid_frame.equilibrium_slip_utilisation(loads[k])
            planes = np.vstack([planes, plane])
        while len(asked) < len(loads) and len(asked) < 2 * _SHARES:
            least = (loads @ planes.T).max(axis=1)
            if (k := int(least.argmax())) in asked:
                break
            asked[k], plane = self.on_rigid_frame.equilibrium_slip_utilisation(loads[k])
            planes = np.vstack([planes, plane])
        worst = max(asked, key=lambda k: asked[k])
        return worst, max(
            on.slip_utilisation(loads[worst])[0]
            for on in (self.on_rigid_frame, self.on_elastic_frame)
        )

    def stress_factors(self, passes: Sequence[FloatArray]) -> FloatArray:
        """Return safe swings (features,) over those without contact, of a history (t, 9).

        It is given in passes of which only the worst happens. Where no contact bears its loads
        each is 1.
        """
        worst = [self._ends(one) for one in passes]
        widest = np.argmax([wide for _, wide in worst], axis=0)
        told, found = np.zeros((2, self.feature_count))
        for k, (one, (ends, _)) in enumerate(zip(passes, worst, strict=True)):
            mine = widest == k
            if not mine.any():
                continue
            loads = _apart(one[np.unique(ends[:, mine])])
            try:
                of_two, real = self._swings(loads)
            except ConvergenceError:
                return np.ones(self.feature_count)
            told, found = np.where(mine, of_two, told), np.where(mine, real, found)
        counts = (told > 0) & (told >= _LOW * told.max())
        times = enlarge_by_contact_error(found / np.where(counts, told, 1.0))
        return np.where(counts, times, 1.0)

    def _ends(self, loads: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return the moments (2, features) between which each swings most, and how far, Pa."""
        ends, widest = (
            np.zeros((2, self.feature_count), dtype=np.int64),
            np.zeros(self.feature_count),
        )
        for held, own, at in self._places():
            top, value = _highest(held, own, at, loads, self.feature_count)
            stress = normal_stress_on_planes(
                held.unit_stress[top], plane_directions(held.zones.normals[top])
            )
            history = stress @ loads.T
            swing = np.ptp(history, axis=-1)
            plane = swing.argmax(axis=1)[:, None]
            wide = np.take_along_axis(swing, plane, 1)[:, 0] * (value > 0)
            along = np.take_along_axis(history, plane[..., None], 1)[:, 0]
            more = wide > widest
            both = np.stack([along.argmax(axis=1), along.argmin(axis=1)])
            ends, widest = np.where(more, both, ends), np.where(more, wide, widest)
        return ends, widest

    def _swings(self, loads: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the use of each feature's limit between loads (t, 9): without and in contact.

        In contact with the frame that makes it worse.
        """
        assert self.solved.contact_model is not None
        joint = self.solved.contact_model.flange
        ways = [
            np.stack([on.added_forces(load) for load in loads])
            for on in (self.on_rigid_frame, self.on_elastic_frame)
        ]
        single = joint.stress.dtype
        real = [
            np.tensordot(forces.astype(single), joint.stress, 1).swapaxes(0, 1).astype(float)
            for forces in ways
        ]
        told, found = np.zeros((2, self.feature_count))
        start = 0
        for held, own, at in self._places():
            alone = np.einsum("pqs,tq->pts", held.unit_stress[at], loads)
            mine = [stress[start : start + len(at)] for stress in real]
            start += len(at)
            for into, stress in ((told, alone), *((found, one) for one in mine)):
                np.maximum.at(into, own[at], _used(held, at, stress, self.strength))
        return told, found

    def _places(self) -> list[tuple[ConstrainedBracketSolution, IntArray, IntArray]]:
        """Return of each way held: itself, the features of its places, and those followed."""
        assert self.solved.contact_model is not None
        return list(
            zip(
                self.solved.boundary_cases,
                self.place_features,
                self.solved.contact_model.places,
                strict=True,
            )
        )


def enlarge_by_contact_error(times: FloatArray) -> FloatArray:
    """Return swings over those without contact, as much larger as contact may be wrong.

    The two ways to be held are no bound: what lifts off pries, and neither of them does.
    """
    return times * (1 + MAX_CONTACT_STRESS_ERROR_SHARE)


def _outermost(loads: FloatArray) -> IntArray:
    """Return the moments at which each of a history's loads (t, 9) is highest and lowest."""
    moves = np.ptp(loads, axis=0) > 0
    ends = [loads.argmax(axis=0)[moves], loads.argmin(axis=0)[moves]]
    largest = np.linalg.norm(loads[:, :3], axis=1).argmax()
    return np.unique(np.concatenate([*ends, [largest]]))


def _apart(loads: FloatArray) -> FloatArray:
    """Return of loads (t, 9) those that are not nearly another."""
    size = np.maximum(np.ptp(loads, axis=0), 1e-12 + 1e-9 * np.abs(loads).max(axis=0))
    kept: list[FloatArray] = []
    for one in loads:
        if all(np.abs((one - other) / size).max() > _ALIKE for other in kept):
            kept.append(one)
    return np.stack(kept)


def _highest(
    held: ConstrainedBracketSolution, own: IntArray, at: IntArray, loads: FloatArray, count: int
) -> tuple[IntArray, FloatArray]:
    """Return the place (features,) of those followed where each swings most, roughly, and by what.

    By the largest change of any component between the outermost moments.
    """
    outer = loads[_outermost(loads)]
    level = np.ptp(np.einsum("pqs,tq->pts", held.unit_stress[at], outer), axis=1).max(axis=-1)
    order = np.lexsort((level, own[at]))
    last = np.searchsorted(own[at][order], np.arange(count), side="right") - 1
    first = np.searchsorted(own[at][order], np.arange(count), side="left")
    there = last >= first
    picked = order[np.maximum(last, 0)]
    return at[picked], np.where(there, level[picked], 0.0)


def _used(
    held: ConstrainedBracketSolution,
    at: IntArray,
    stress: FloatArray,
    strength: Mapping[FatigueZone, ZoneFatigueStrength],
) -> FloatArray:
    """Return what the widest swing of stresses (places, t, 6) uses of a zone's limit."""
    on = normal_stress_on_planes(stress, plane_directions(held.zones.normals[at])[:, ::_PLANES])
    low, high = on.min(axis=-1), on.max(axis=-1)
    plane = (high - low).argmax(axis=1)[:, None]
    low, high = (np.take_along_axis(x, plane, 1)[:, 0] for x in (low, high))
    used = np.zeros(len(at))
    for kind in np.unique(held.zones.kind[at]).tolist():
        mine = held.zones.kind[at] == kind
        amplitude, mean = (high - low)[mine] / 2, (high + low)[mine] / 2
        if one := strength.get(FATIGUE_ZONES[kind]):
            used[mine] = one.utilisation(amplitude, mean)
    return used
