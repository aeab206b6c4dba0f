"""From a load history on the bearing to damage and life at a bracket's hot spots and gauges.

Unit stresses times loads are a stress history; its rainflow cycles, Goodman's mean stress
and the S-N curve make damage by Miner. A history is taken to repeat for ever.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from cardan.application.catalogue import find_shipped_part
from cardan.core.arrays import ArrayLike, FloatArray
from cardan.core.errors import DesignError
from cardan.core.labels import EvaluationCondition
from cardan.core.units import hour
from cardan.model.bracket import FATIGUE_ZONES, Bracket, FatigueCurve, FatigueZone
from cardan.model.material import Material
from cardan.physics.fatigue.critical_plane import rainflow_of_repeating_signals
from cardan.physics.fatigue.damage import miner_damage
from cardan.physics.fatigue.detail_classes import stress_ratio_corrected_amplitude
from cardan.physics.fatigue.mean_stress import MeanStressCorrection, fkm, goodman, uncorrected
from cardan.physics.fatigue.rainflow import rainflow, repeating
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.physics.fem.stress import max_normal_stress_swing_direction, normal_stress, superpose
from cardan.physics.fem.unit_loads import UNIT_LOAD_NAMES
from cardan.topics.bracket.metal_fatigue_data import (
    DETAIL_NAME_SAME_AS_SHEET,
    fatigue_data_of_metal,
)

UNNAMED_LOAD_CASE = EvaluationCondition("case", "")
"""A history without a name."""


def load_history_of_forces(history: ArrayLike) -> FloatArray:
    """Return loads (..., t, 9) of forces on a bearing (..., t, 3), or with moments (..., t, 6).

    Forces may be those of `cardan.physics.fem.strain_gauges.recover_loads`: measured strains make
    life too.
    """
    history = np.asarray(history, dtype=float)
    known = history.shape[-1]
    if history.ndim < 2 or known not in (3, 6, len(UNIT_LOAD_NAMES)):
        msg = (
            f"a load history is (..., samples, 3, 6 or {len(UNIT_LOAD_NAMES)}), got {history.shape}"
        )
        raise ValueError(msg)
    if not np.isfinite(history).all():
        msg = "a load history on a bracket has samples that are not numbers: correct them first"
        raise DesignError(msg)
    return np.pad(history, [(0, 0)] * (history.ndim - 1) + [(0, len(UNIT_LOAD_NAMES) - known)])


def load_history_from_orders(
    static: ArrayLike, orders: Mapping[float, ArrayLike], *, samples: int = 64, turns: int = 1
) -> FloatArray:
    r"""Return loads (t, 9) of order content: $F_0 + \mathrm{Re} \sum_k F_k e^{i k \theta}$.

    Parameters
    ----------
    static : (3) N or (6) N, N m
        Mean over the turn.
    orders
        Complex amplitudes (3) or (6), 0 to peak, by order of the shaft's turn.
    samples
        Per turn.
    turns
        As many as it takes until the loads come back: 2 where an order is a half.
    """
    angle = 2 * np.pi * np.arange(samples * turns) / samples
    waves = [
        np.real(np.asarray(size, dtype=complex) * np.exp(1j * order * angle)[:, None])
        for order, size in orders.items()
    ]
    return load_history_of_forces(sum(waves, np.asarray(static) + np.zeros((len(angle), 1))))


@dataclass(frozen=True)
class ZoneFatigueStrength:
    """What a zone bears in fatigue: S-N curve and mean-stress correction, and its source."""

    curve: SNCurve
    correction: MeanStressCorrection = uncorrected
    name: str = ""

    @classmethod
    def from_bracket(
        cls, bracket: Bracket, zone: FatigueZone = "sheet"
    ) -> "ZoneFatigueStrength | None":
        """Return what a zone of a bracket bears as its file states it; None where it states none.

        Zones the file says nothing of bear what a cautious detail of their metal does; where no
        code has one it is unknown. Beyond the knee Haibach's slope holds. On the sheet tensile
        means count by Goodman where the material has an ultimate strength, else not at all; of
        what is no steel by the guideline's sensitivity where that is worse.
        """
        given = bracket.fatigue if zone == "sheet" else bracket.details.get(zone)
        if bracket.fatigue is not None and given is None:
            of = fatigue_data_of_metal(bracket.material.metal)
            name = of.details.get(zone) if of else None
            given = (
                bracket.fatigue
                if name == DETAIL_NAME_SAME_AS_SHEET
                else name and find_shipped_part(name, "detail")
            )
        if bracket.fatigue is None or not given:
            return None
        curve = SNCurve(amplitude=given.amplitude, cycles=given.cycles, slope=given.slope)
        return cls(curve.modified(), _correction(given, bracket.material), given.name)

    def damage(self, stress: FloatArray) -> float:
        """Damage of one pass of a stress history (t,) Pa that repeats for ever."""
        cycles = rainflow(stress, rule=repeating)
        return miner_damage(cycles, curve=self.curve, correction=self.correction)

    def cycle_damage(self, amplitude: FloatArray, mean: FloatArray) -> FloatArray:
        """Damage (...) of one cycle each, amplitude and mean (...) Pa."""
        return self.curve.damage(self.correction(amplitude, mean))

    def utilisation(self, amplitude: ArrayLike, mean: ArrayLike) -> FloatArray:
        """Amplitude at zero mean (...) over the knee's: 1 lasts as long as the knee says."""
        at_zero = self.correction(np.asarray(amplitude, float), np.asarray(mean, float))
        return at_zero / self.curve.amplitude


def fatigue_strength_by_zone(bracket: Bracket) -> dict[FatigueZone, ZoneFatigueStrength]:
    """Return what each zone of a bracket bears; nothing where its file states no S-N curve."""
    found: dict[FatigueZone, ZoneFatigueStrength] = {}
    for zone in FATIGUE_ZONES:
        one = ZoneFatigueStrength.from_bracket(bracket, zone)
        if one is not None:
            found[zone] = one
    return found


def _correction(given: FatigueCurve, material: Material) -> MeanStressCorrection:
    """Return how a mean stress counts on a curve."""
    if given.mean == "ratio":
        return stress_ratio_corrected_amplitude
    ultimate = material.ultimate_strength
    if given.mean != "goodman" or not ultimate:
        return uncorrected
    line = partial(goodman, ultimate=ultimate)
    of = fatigue_data_of_metal(material.metal)
    if of is None or material.metal == "steel":
        return line
    also = partial(fkm, sensitivity=of.metal.mean_stress_sensitivity(ultimate))
    return partial(_worse, line, also)


def _worse(
    one: MeanStressCorrection, other: MeanStressCorrection, amplitude: FloatArray, mean: FloatArray
) -> FloatArray:
    """Return the amplitude by that of two corrections that makes more of it."""
    return np.maximum(one(amplitude, mean), other(amplitude, mean))


def hot_spot_damage(
    unit: ArrayLike, loads: FloatArray, *, strength: ZoneFatigueStrength
) -> FloatArray:
    """Damage (k,) that one pass of loads (t, 9) does at points, unit stresses (k, 9, 6) Pa.

    Of the normal stress on the plane where it swings most.
    """
    return np.array(
        [
            strength.damage(normal_stress(one, max_normal_stress_swing_direction(one)))
            for one in superpose(unit, loads)
        ]
    )


def gauge_damage(
    influence: ArrayLike, loads: FloatArray, *, modulus: float, strength: ZoneFatigueStrength
) -> FloatArray:
    """Damage (g,) one pass of loads (t, 9) does at gauges, influence (g, 9), modulus Pa.

    Of the stress their readings make of it, one way: Young's modulus times strain.
    """
    stress = modulus * np.asarray(influence, dtype=float) @ loads.T
    return strength.cycle_damage(*rainflow_of_repeating_signals(stress)).sum(axis=1)


@dataclass(frozen=True, kw_only=True)
class DamageResult:
    """What one pass of a load history does, or a mean second of a duty cycle.

    Attributes
    ----------
    when
        The load case, or the duty cycle in a state.
    hot_spot_damage : (k,)
        Damage at each hot spot; 1 is failure. nan if the strength of its zone is unknown.
    gauge_damage : (g,)
        Damage at each gauge.
    turns
        Turns of the shaft in a pass; nan where not known.
    duration : s
        Of a pass; nan where not known.
    damage_bounds : (k, 2)
        Damage at each hot spot where stress is lower and higher than computed, by its error; nan
        where it was not estimated.
    favourable_lower_bound : (k,)
        The same where it is lower and the flange is held the more favourable way.
    favourable_damage : (k,)
        The same with the computed stress, the flange held the favourable way; in contact as
        computed.
    """

    when: EvaluationCondition
    hot_spot_damage: FloatArray
    gauge_damage: FloatArray
    turns: float
    duration: float
    damage_bounds: FloatArray | None = None
    stop_margin: float = np.inf
    """That of its load cases: negative where the damage is a lower bound."""
    favourable_lower_bound: FloatArray | None = None
    favourable_damage: FloatArray | None = None

    def at_spots(self, places: ArrayLike) -> "DamageResult":
        """Return the same of some of its hot spots (places,), in their order."""
        picked = np.asarray(places)
        span, eased, favourable = (
            None if v is None else v[picked]
            for v in (self.damage_bounds, self.favourable_lower_bound, self.favourable_damage)
        )
        return replace(
            self,
            hot_spot_damage=self.hot_spot_damage[picked],
            damage_bounds=span,
            favourable_lower_bound=eased,
            favourable_damage=favourable,
        )

    @property
    def worst_damage(self) -> float:
        """Damage of a pass at the hot spot that fares worst, of those of which it is known."""
        return float(np.fmax.reduce(self.hot_spot_damage))

    @property
    def damage_per_turn(self) -> float:
        """Damage of a turn there; nan where not known."""
        return self.worst_damage / self.turns

    @property
    def damage_per_hour(self) -> float:
        """Damage of an hour there; nan where not known."""
        return self.worst_damage / self.duration * hour

    @property
    def hours_to_failure(self) -> float:
        """Hours to failure there; infinite where it does no harm, nan where not known."""
        return _until(self.damage_per_hour)

    @property
    def hours_bounds(self) -> tuple[float, float]:
        """Least and most hours to failure, each stress off by its error; nan where not known.

        At most with the flange held the more favourable way. What fails first may be another spot
        than the one that fares worst.
        """
        if self.damage_bounds is None:
            return math.nan, math.nan
        kind = (
            self.damage_bounds[:, 0]
            if self.favourable_lower_bound is None
            else self.favourable_lower_bound
        )
        return self._hours(self.damage_bounds[:, 1]), self._hours(kind)

    @property
    def favourable_hours(self) -> float:
        """Hours to failure with the flange held the more favourable way; nan where not known."""
        return math.nan if self.favourable_damage is None else self._hours(self.favourable_damage)

    @property
    def max_hours_by_mesh_error(self) -> float:
        """Most hours to failure by the error of stresses alone, the flange held as reported."""
        return math.nan if self.damage_bounds is None else self._hours(self.damage_bounds[:, 0])

    def _hours(self, spots: FloatArray) -> float:
        return _until(float(np.fmax.reduce(spots)) / self.duration * hour)


def _until(rate: float) -> float:
    return math.inf if rate == 0 else 1 / rate


def damage_of_load_history(
    loads: ArrayLike,
    *,
    when: EvaluationCondition = UNNAMED_LOAD_CASE,
    unit: FloatArray,
    influence: FloatArray,
    modulus: float,
    strength: ZoneFatigueStrength,
    places: int = 1,
    turns: float = np.nan,
    duration: float = np.nan,
) -> DamageResult:
    """Damage of one pass of loads (places * t, 3, 6 or 9), the worst of as many as places.

    Raises
    ------
    DesignError
        If a load is not finite: counting would step over it, and find no harm.
    """
    passes = np.split(load_history_of_forces(loads), places)
    at_spots = [hot_spot_damage(unit, one, strength=strength) for one in passes]
    at_gauges = [gauge_damage(influence, one, modulus=modulus, strength=strength) for one in passes]
    return DamageResult(
        when=when,
        hot_spot_damage=np.max(at_spots, axis=0),
        gauge_damage=np.max(at_gauges, axis=0),
        turns=turns,
        duration=duration,
    )


def duty_cycle_damage(
    when: EvaluationCondition, parts: list[tuple[float, DamageResult]]
) -> DamageResult:
    """Return the mean second of a duty cycle: parts with their shares of the time.

    Each part runs for long: cycles from one to the next are not counted.
    """
    shares = np.array([share for share, _ in parts])
    weights = shares / shares.sum() / np.array([e.duration for _, e in parts])
    return DamageResult(
        when=when,
        hot_spot_damage=weights @ np.array([e.hot_spot_damage for _, e in parts]),
        gauge_damage=weights @ np.array([e.gauge_damage for _, e in parts]),
        turns=float(weights @ np.array([e.turns for _, e in parts])),
        duration=1.0,
    )
