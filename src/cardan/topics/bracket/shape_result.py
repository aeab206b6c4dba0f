"""The result of the assessment of one bracket shape: features, cases, duty cycle, resonances."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.labels import EvaluationCondition, OperatingPoint, Part
from cardan.core.units import Metre, RadianPerSecond
from cardan.model.bracket import FatigueZone
from cardan.physics.fem.solve import SolvedBracket
from cardan.topics.bracket.contact_assessment import ContactResult
from cardan.topics.bracket.forced_response import ForcedResponse
from cardan.topics.bracket.life import DamageResult
from cardan.topics.bracket.load_cases import BearingLoadCase

_MIN_BENDING_ENERGY_SHARE = 0.5
"""Of a mode's energy, what bends a bracket that swings itself."""


@dataclass(frozen=True, slots=True)
class LocatedStress:
    """A stress and where it is."""

    value: float
    point: tuple[Metre, Metre, Metre]


@dataclass(frozen=True, slots=True)
class LocatedDisplacement:
    """A displacement, m, and where it is."""

    value: Metre
    point: tuple[Metre, Metre, Metre]


@dataclass(frozen=True, kw_only=True)
class FatigueFeature:
    """A bend, a face, an edge, a hole, a weld's toe, a bolt's border: what cracks by itself.

    Attributes
    ----------
    zone, number
        What it is, counted within the zone over all the drawing has.
    point : m
        Where it is worst: by damage over the duty cycle, else by stress over the cases.
    error
        Share of its highest stress that its error may be.
    beside_weld
        Whether the heat of a weld reaches it, where that makes its material softer.
    """

    zone: FatigueZone
    number: int
    point: tuple[Metre, Metre, Metre]
    error: float
    beside_weld: bool = False

    @property
    def part(self) -> Part:
        """The feature as a part of checks."""
        return Part(self.zone, self.number)


@dataclass(frozen=True)
class CaseResult:
    """What one case does to one bracket.

    Attributes
    ----------
    von_mises, max_principal, min_principal : LocatedStress
        Extremes over all places where fatigue is evaluated: equivalent, largest tension, largest
        compression.
    max_nodal_von_mises : LocatedStress
        Largest von Mises stress at any node. Where it exceeds `von_mises` it sits in a notch
        or at a clamp and depends on the mesh alone.
    feature_stress, feature_stress_error : (features,) Pa
        Largest von Mises stress of each feature, and its estimated error.
    min_feature_stress : (features,) Pa
        The same stress where the flange is held the way that makes it less.
    mean, amplitude : (features,) Pa
        Of the normal stress at the place of each feature, and on the plane, that use most of its
        fatigue limit (where none is stated, that swing most), wherever `feature_stress` is.
    utilisation : (features,)
        That swing at zero mean over the amplitude its zone bears at the knee; nan where none
        is known, or of a load by itself.
    favourable_utilisation : (features,)
        The same where the flange is held the way that makes it less; in contact the same.
    utilisation_bounds : (features, 2)
        The same where its stress is lower, and higher, by its error, and the flange is held the way
        that makes it less, and more.
    gauge_strain_range : (gauges, 2)
        Smallest and largest reading.
    bolt_forces : (b,) N
        Largest force on each bolt.
    seat_displacement : Metre
        Largest movement of the seat under the bearing.
    damage_result : DamageResult
        Damage and life; None without an S-N curve, or of a load by itself.
    slip_utilisation : float
        Its loads over those along them under which the bolts slip or open; nan where their force
        is not known.
    slip_point : OperatingPoint
        Where that is most, of the operating points evaluated; None at the state's own.
    stress_factors : (features,)
        Swing of each feature in contact over that by the two ways held; None where that was
        not requested.
    pulls_off : bool
        Whether its largest force pulls the flange straight off the frame: softer, where bolts
        give, than either way it is held (`tests/verify/test_bracket_contact.py`).
    """

    case: BearingLoadCase
    von_mises: LocatedStress
    max_principal: LocatedStress
    min_principal: LocatedStress
    max_nodal_von_mises: LocatedStress
    feature_stress: FloatArray
    feature_stress_error: FloatArray
    min_feature_stress: FloatArray
    mean: FloatArray
    amplitude: FloatArray
    utilisation: FloatArray
    favourable_utilisation: FloatArray
    utilisation_bounds: FloatArray
    gauge_strain_range: FloatArray
    bolt_forces: FloatArray
    seat_displacement: Metre
    damage_result: DamageResult | None = None
    slip_utilisation: float = np.nan
    slip_point: OperatingPoint | None = None
    stress_factors: FloatArray | None = None
    pulls_off: bool = False


class BoltSlipUtilisation(NamedTuple):
    """Share of its bolts' strength that loads use: above 1 they slip or open."""

    when: EvaluationCondition
    utilisation: float
    point: OperatingPoint | None = None
    stop_margin: float = np.inf


@dataclass(frozen=True, slots=True)
class ResonanceCrossing:
    """A natural frequency that an order of the shaft's speed meets."""

    mode: int
    frequency: float
    order: int
    speed: RadianPerSecond
    in_range: bool
    """Whether that speed is one the shaft reaches."""


@dataclass(frozen=True, kw_only=True)
class ShapeAssessment:
    """One shape of a bracket, judged.

    Attributes
    ----------
    solved : SolvedBracket
        The last solution, whose mesh is drawn.
    features : (FatigueFeature, ...)
        Worst first.
    listed_count : int
        How many of them tables show: the worst, and the worst of each zone.
    damage_map : (surface nodes,)
        Of an hour of the duty cycle, in the state where it is largest; empty without one.
    duty_damage : (DamageResult, ...)
        A mean second of the application's duty cycle, in each state that lasts.
    forced_response : ForcedResponse
        The listed features over speed; None if what hangs in it is unknown.
    contact_result : ContactResult
        What contact made of the fatigue and life given here; None if not requested.
    duty_slips : (BoltSlipUtilisation, ...)
        What the duty cycle uses of the bolts in each state that lasts; nothing where their force
        is not known.
    """

    name: str
    solved: SolvedBracket
    features: tuple[FatigueFeature, ...]
    listed_count: int
    crossings: tuple[ResonanceCrossing, ...]
    case_results: tuple[CaseResult, ...]
    duty_damage: tuple[DamageResult, ...] = ()
    damage_map: FloatArray
    forced_response: ForcedResponse | None = None
    contact_result: ContactResult | None = None
    duty_slips: tuple[BoltSlipUtilisation, ...] = ()

    @property
    def bolt_slips(self) -> tuple[BoltSlipUtilisation, ...]:
        """What each case uses of the bolts, then what the duty cycle does."""
        cases = (
            BoltSlipUtilisation(o.case.when, o.slip_utilisation, o.slip_point, o.case.stop_margin)
            for o in self.case_results
        )
        return (*(s for s in cases if not np.isnan(s.utilisation)), *self.duty_slips)

    @property
    def mass(self) -> float:
        """Mass, kg."""
        return self.solved.mass

    @property
    def compliance(self) -> FloatArray:
        """Mean motion of the seat under forces and moments, (6, 6), the flange sliding."""
        return self.solved.sliding.compliance

    @property
    def influence(self) -> FloatArray:
        """Strain (gauges, 9) of each gauge under each unit load, the flange sliding."""
        return self.solved.sliding.influence

    @property
    def frequencies(self) -> FloatArray:
        """Natural frequencies (6,) Hz of the bracket by itself, the flange sliding."""
        return self.solved.sliding.frequencies

    @property
    def loaded_frequencies(self) -> FloatArray:
        """Natural frequencies (6,) Hz with the mass it carries, the flange sliding."""
        return self.solved.sliding.loaded_frequencies

    @property
    def lowest_frequency(self) -> tuple[float, float]:
        """The lowest frequency, Hz, at which it swings itself; the share it may be too high by.

        By itself, and with what hangs in it the lowest of the modes in which it gives more than the
        rubber does: of the line where that is known, else of the mass that it carries. What it
        carries weighs what it weighs: no more than half of the stiffness's own share.
        """
        of = self.solved.sliding
        bends = self.loaded_frequencies[of.bending_energy_share >= _MIN_BENDING_ENERGY_SHARE]
        if self.forced_response is not None:
            line = self.forced_response.sweep
            bends = line.frequencies[np.array(line.mode_names) == "bracket"]
        loaded = float(of.stiffness_error.max()) / 2
        alone = float(of.frequency_error[0]) if len(of.frequency_error) else 0.0
        return min([(float(self.frequencies[0]), alone), *((f, loaded) for f in bends.tolist())])

    @property
    def listed_features(self) -> tuple[FatigueFeature, ...]:
        """The features that tables show."""
        return self.features[: self.listed_count]

    @cached_property
    def worst_case(self) -> CaseResult:
        """The case with the highest converged stress."""
        return max(self.case_results, key=lambda o: float(o.feature_stress.max()))

    @property
    def life_results(self) -> tuple[DamageResult, ...]:
        """What hours refer to: the duty cycle in each state that lasts, else each recording."""
        return self.duty_damage or recording_damage(self.case_results)

    @property
    def life_hours(self) -> float:
        """Hours to failure at the worst feature over the duty cycle; nan without one."""
        return min((e.hours_to_failure for e in self.duty_damage), default=np.nan)

    @property
    def life_hours_bounds(self) -> tuple[float, float]:
        """Between what hours that life lies, by errors and by the flange; nan without one."""
        low, high = np.min([e.hours_bounds for e in self.duty_damage] or [(np.nan, np.nan)], axis=0)
        return float(low), float(high)

    @property
    def max_life_hours_by_mesh_error(self) -> float:
        """Hours that finer elements may make of that life at most, the flange held alike."""
        return min((e.max_hours_by_mesh_error for e in self.duty_damage), default=np.nan)


def recording_damage(outcomes: Iterable[CaseResult]) -> tuple[DamageResult, ...]:
    """Return what is endured of what was driven as it was recorded: no turn of a state's shaft."""
    every = (o.damage_result for o in outcomes if np.isnan(o.case.turns))
    return tuple(e for e in every if e is not None and e.duration > 0)


def vector_as_tuple(at: FloatArray) -> tuple[Metre, Metre, Metre]:
    """Return a point (3,) as a tuple."""
    x, y, z = at.tolist()
    return x, y, z
