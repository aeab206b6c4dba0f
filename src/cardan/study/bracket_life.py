"""From a load history on the bearing to damage and life at a bracket's hot spots and gauges.

Unit stresses times loads are a stress history; its rainflow cycles, Goodman's mean stress
and the S-N curve make damage by Miner. A history is taken to repeat for ever.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from cardan.base.arrays import ArrayLike, FloatArray
from cardan.base.errors import DesignError
from cardan.base.part import Occasion
from cardan.base.units import hour
from cardan.bracket.stress import along, critical_direction, superpose
from cardan.bracket.unit import UNITS
from cardan.fatigue.correction import Correction, fkm, goodman, uncorrected
from cardan.fatigue.critical import counted
from cardan.fatigue.damage import miner
from cardan.fatigue.detail import ratio_bonus
from cardan.fatigue.rainflow import rainflow, repeating
from cardan.fatigue.strength import SNCurve
from cardan.files.catalogue import find
from cardan.files.metals import AS_SHEET, borne
from cardan.model.bracket import ZONES, Bracket, FatigueCurve, Zone
from cardan.model.material import Material

ALONE = Occasion("case", "")
"""A history that nobody named."""


def loads_of(history: ArrayLike) -> FloatArray:
    """Return loads (..., t, 9) of forces on a bearing (..., t, 3), or with moments (..., t, 6).

    Forces may be those of `cardan.bracket.gauges.recover`: measured strains make life too.
    """
    history = np.asarray(history, dtype=float)
    known = history.shape[-1]
    if history.ndim < 2 or known not in (3, 6, len(UNITS)):
        msg = f"a load history is (..., samples, 3, 6 or {len(UNITS)}), got {history.shape}"
        raise ValueError(msg)
    if not np.isfinite(history).all():
        msg = "a load history on a bracket has samples that are no numbers: mend it first"
        raise DesignError(msg)
    return np.pad(history, [(0, 0)] * (history.ndim - 1) + [(0, len(UNITS) - known)])


def round_the_turn(
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
    return loads_of(sum(waves, np.asarray(static) + np.zeros((len(angle), 1))))


@dataclass(frozen=True)
class Strength:
    """What a zone bears in fatigue: S-N curve and mean-stress correction, and who says so."""

    curve: SNCurve
    correction: Correction = uncorrected
    name: str = ""

    @classmethod
    def of(cls, bracket: Bracket, zone: Zone = "sheet") -> "Strength | None":
        """Return what a zone of a bracket bears as its file states it; None where it states none.

        Zones the file says nothing of bear what a cautious detail of their metal does; where no
        code has one nobody knows. Beyond the knee Haibach's slope holds. On the sheet tensile
        means count by Goodman where the material has an ultimate strength, else not at all; of
        what is no steel by the guideline's sensitivity where that is worse.
        """
        given = bracket.fatigue if zone == "sheet" else bracket.details.get(zone)
        if bracket.fatigue is not None and given is None:
            of = borne(bracket.material.metal)
            name = of.details.get(zone) if of else None
            given = bracket.fatigue if name == AS_SHEET else name and find(name, "detail")
        if bracket.fatigue is None or not given:
            return None
        curve = SNCurve(amplitude=given.amplitude, cycles=given.cycles, slope=given.slope)
        return cls(curve.modified(), _correction(given, bracket.material), given.name)

    def damage(self, stress: FloatArray) -> float:
        """Damage of one pass of a stress history (t,) Pa that repeats for ever."""
        cycles = rainflow(stress, rule=repeating)
        return miner(cycles, curve=self.curve, correction=self.correction)

    def harm(self, amplitude: FloatArray, mean: FloatArray) -> FloatArray:
        """Damage (...) of one cycle each, amplitude and mean (...) Pa."""
        return self.curve.damage(self.correction(amplitude, mean))

    def used(self, amplitude: ArrayLike, mean: ArrayLike) -> FloatArray:
        """Amplitude at zero mean (...) over the knee's: 1 lasts as long as the knee says."""
        at_zero = self.correction(np.asarray(amplitude, float), np.asarray(mean, float))
        return at_zero / self.curve.amplitude


def strengths(bracket: Bracket) -> dict[Zone, Strength]:
    """Return what each zone of a bracket bears; nothing where its file states no S-N curve."""
    found: dict[Zone, Strength] = {}
    for zone in ZONES:
        one = Strength.of(bracket, zone)
        if one is not None:
            found[zone] = one
    return found


def _correction(given: FatigueCurve, material: Material) -> Correction:
    """Return how a mean stress counts on a curve."""
    if given.mean == "ratio":
        return ratio_bonus
    ultimate = material.ultimate_strength
    if given.mean != "goodman" or not ultimate:
        return uncorrected
    line = partial(goodman, ultimate=ultimate)
    of = borne(material.metal)
    if of is None or material.metal == "steel":
        return line
    also = partial(fkm, sensitivity=of.endurance.sensitivity(ultimate))
    return partial(_worse, line, also)


def _worse(
    one: Correction, other: Correction, amplitude: FloatArray, mean: FloatArray
) -> FloatArray:
    """Return the amplitude by that of two corrections that makes more of it."""
    return np.maximum(one(amplitude, mean), other(amplitude, mean))


def spot_damage(unit: ArrayLike, loads: FloatArray, *, strength: Strength) -> FloatArray:
    """Damage (k,) that one pass of loads (t, 9) does at points, unit stresses (k, 9, 6) Pa.

    Of the normal stress on the plane where it swings most.
    """
    return np.array([
        strength.damage(along(one, critical_direction(one))) for one in superpose(unit, loads)
    ])  # fmt: skip


def gauge_damage(
    influence: ArrayLike, loads: FloatArray, *, modulus: float, strength: Strength
) -> FloatArray:
    """Damage (g,) one pass of loads (t, 9) does at gauges, influence (g, 9), modulus Pa.

    Of the stress their readings make of it, one way: Young's modulus times strain.
    """
    stress = modulus * np.asarray(influence, dtype=float) @ loads.T
    return strength.harm(*counted(stress)).sum(axis=1)


@dataclass(frozen=True, kw_only=True)
class Endured:
    """What one pass of a load history does, or a mean second of a duty cycle.

    Attributes
    ----------
    when
        The load case, or the duty cycle in a state.
    spots : (k,)
        Damage at each hot spot; 1 is failure. Where nobody knows what its zone bears, nan.
    gauges : (g,)
        Damage at each gauge.
    turns
        Turns of the shaft in a pass; nan where not known.
    duration : s
        Of a pass; nan where not known.
    span : (k, 2)
        Damage at each hot spot where stress is lower and higher than told, by its error; nan where
        nobody estimated that.
    eased : (k,)
        The same where it is lower and the flange is held the kinder way.
    kinder : (k,)
        The same of stress as told, and the flange held the kinder way; in contact as told.
    """

    when: Occasion
    spots: FloatArray
    gauges: FloatArray
    turns: float
    duration: float
    span: FloatArray | None = None
    eased: FloatArray | None = None
    kinder: FloatArray | None = None

    def at(self, places: ArrayLike) -> "Endured":
        """Return the same of some of its hot spots (places,), in their order."""
        picked = np.asarray(places)
        span, eased, kinder = (
            None if v is None else v[picked] for v in (self.span, self.eased, self.kinder)
        )
        return replace(self, spots=self.spots[picked], span=span, eased=eased, kinder=kinder)

    @property
    def worst(self) -> float:
        """Damage of a pass at the hot spot that fares worst, of those of which it is known."""
        return float(np.fmax.reduce(self.spots))

    @property
    def per_turn(self) -> float:
        """Damage of a turn there; nan where not known."""
        return self.worst / self.turns

    @property
    def per_hour(self) -> float:
        """Damage of an hour there; nan where not known."""
        return self.worst / self.duration * hour

    @property
    def hours(self) -> float:
        """Hours to failure there; infinite where it does no harm, nan where not known."""
        return _until(self.per_hour)

    @property
    def hours_within(self) -> tuple[float, float]:
        """Least and most hours to failure, each stress off by its error; nan where not known.

        At most with the flange held the kinder way. What fails first may be another spot than the
        one that fares worst.
        """
        if self.span is None:
            return math.nan, math.nan
        kind = self.span[:, 0] if self.eased is None else self.eased
        return self._hours(self.span[:, 1]), self._hours(kind)

    @property
    def hours_kinder(self) -> float:
        """Hours to failure with the flange held the kinder way; nan where not known."""
        return math.nan if self.kinder is None else self._hours(self.kinder)

    @property
    def hours_meshed(self) -> float:
        """Most hours to failure by the error of stresses alone, the flange held as it is told."""
        return math.nan if self.span is None else self._hours(self.span[:, 0])

    def _hours(self, spots: FloatArray) -> float:
        return _until(float(np.fmax.reduce(spots)) / self.duration * hour)


def _until(rate: float) -> float:
    return math.inf if rate == 0 else 1 / rate


def endured(
    loads: ArrayLike,
    *,
    when: Occasion = ALONE,
    unit: FloatArray,
    influence: FloatArray,
    modulus: float,
    strength: Strength,
    places: int = 1,
    turns: float = np.nan,
    duration: float = np.nan,
) -> Endured:
    """Damage of one pass of loads (places * t, 3, 6 or 9), the worst of as many as places.

    Raises
    ------
    DesignError
        If a load is not finite: counting would step over it, and find no harm.
    """
    passes = np.split(loads_of(loads), places)
    at_spots = [spot_damage(unit, one, strength=strength) for one in passes]
    at_gauges = [gauge_damage(influence, one, modulus=modulus, strength=strength) for one in passes]
    return Endured(
        when=when,
        spots=np.max(at_spots, axis=0),
        gauges=np.max(at_gauges, axis=0),
        turns=turns,
        duration=duration,
    )


def mixed(when: Occasion, parts: list[tuple[float, Endured]]) -> Endured:
    """Return the mean second of a duty cycle: parts with their shares of the time.

    Each part runs for long: cycles from one to the next are not counted.
    """
    shares = np.array([share for share, _ in parts])
    weights = shares / shares.sum() / np.array([e.duration for _, e in parts])
    return Endured(
        when=when,
        spots=weights @ np.array([e.spots for _, e in parts]),
        gauges=weights @ np.array([e.gauges for _, e in parts]),
        turns=float(weights @ np.array([e.turns for _, e in parts])),
        duration=1.0,
    )
