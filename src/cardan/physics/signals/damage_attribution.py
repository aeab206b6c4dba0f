"""Causes of damage: a stress divided by cause, and the share of damage of each cause.

Damage is not additive: two small cycles on top of each other make a large one, so the
damages of the parts do not sum to that of the whole, and "the damage without X" of all X
sums to more or less than it. The shares here are Shapley values. A cause's share is the
damage it adds, averaged over all orders in which the causes can be put together; the
shares sum to the whole exactly, equal causes get equal shares, and a cause that changes
nothing gets none. The damage without each cause, and of each alone, is given too.
Source: Shapley, A value for n-person games (1953).
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cardan.core.arrays import ArrayLike, ComplexArray, FloatArray
from cardan.physics.fatigue.damage import cycle_damages, miner_damage, omission_level
from cardan.physics.fatigue.mean_stress import MeanStressCorrection, uncorrected
from cardan.physics.fatigue.rainflow import (
    EMPTY_REVERSALS,
    CyclesOfManySignals,
    ResidueRule,
    four_point,
    four_point_of_many_signals,
    half_cycles,
    rainflow_of_cause_coalitions,
)
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.physics.signals.conditioning import ZeroPhaseFilter, low_pass
from cardan.physics.signals.order_tracking import (
    OrderComponent,
    OrderDecomposer,
    OrderDecomposition,
    ShaftRotation,
)

CAUSE_SLOW_LOAD, CAUSE_SUDDEN_EVENTS, CAUSE_ROAD, CAUSE_REMAINDER = (
    "load",
    "events",
    "road and wheel",
    "rest",
)
CAUSE_UNBALANCE, CAUSE_JOINTS, CAUSE_ENGINE = "unbalance", "joints", "engine"

CAUSE_DESCRIPTIONS = {
    CAUSE_SLOW_LOAD: "slow mean: driving torque, weight, manoeuvres",
    CAUSE_UNBALANCE: "shaft order 1",
    CAUSE_JOINTS: "shaft orders 2 and 4",
    CAUSE_ENGINE: "engine orders",
    CAUSE_ROAD: (
        "wheel orders, and what is neither locked nor sudden below the road's upper frequency"
    ),
    CAUSE_SUDDEN_EVENTS: "sudden and rare: potholes, kerbs, gear clunks",
    CAUSE_REMAINDER: "everything faster that is not locked to a rotation",
}


@dataclass(frozen=True)
class VibrationSource:
    """A tone and the cause it speaks for."""

    cause: str
    component: OrderComponent


SIX_CYLINDER_FIRING_ORDERS = (3.0, 6.0)
"""Orders of an engine of which nothing is said: six cylinders."""


def vibration_sources(
    shaft: ShaftRotation,
    *,
    joint_orders: Sequence[float] = (2.0, 4.0),
    engine: ShaftRotation | None = None,
    engine_orders: Sequence[float] = SIX_CYLINDER_FIRING_ORDERS,
    wheel: ShaftRotation | None = None,
    wheel_orders: Sequence[float] = (1.0, 2.0),
) -> tuple[VibrationSource, ...]:
    """Name the tones of a driveline: unbalance, joints, engine, wheels.

    Parameters
    ----------
    shaft, engine, wheel
        Rotations; engine and wheel only where they are known.
    joint_orders, engine_orders, wheel_orders
        Multiples of each one's own speed. A four-stroke engine of n cylinders excites n/2.
    """
    found = [VibrationSource(CAUSE_UNBALANCE, OrderComponent(shaft, 1.0))]
    found += [VibrationSource(CAUSE_JOINTS, OrderComponent(shaft, k)) for k in joint_orders]
    if engine is not None:
        found += [VibrationSource(CAUSE_ENGINE, OrderComponent(engine, k)) for k in engine_orders]
    if wheel is not None:
        found += [VibrationSource(CAUSE_ROAD, OrderComponent(wheel, k)) for k in wheel_orders]
    return tuple(found)


def coinciding_orders(
    named: Sequence[VibrationSource], *, times: FloatArray, resolution: float
) -> list[tuple[VibrationSource, VibrationSource, float]]:
    """Pairs of tones of two causes that run within `resolution` Hz, and the share of time.

    While they do, nothing in the signal distinguishes them, and their sum is shared evenly.
    """
    pairs: list[tuple[VibrationSource, VibrationSource, float]] = []
    if not times.size:
        return pairs
    for k, one in enumerate(named):
        for other in named[k + 1 :]:
            if one.cause != other.cause:
                f, g = one.component.frequency(times), other.component.frequency(times)
                moving = np.maximum(f, g) > resolution
                close = float((moving & (np.abs(f - g) < resolution)).mean())
                if close > 0.01:
                    pairs.append((one, other, close))
    return pairs


@dataclass(frozen=True, kw_only=True)
class SourceSeparation:
    """How a stress is taken apart into causes that sum to it exactly.

    Attributes
    ----------
    sources
        Tones and their causes.
    decomposer
        Finds them; its tones are those of the suspects, less what is identified elsewhere.
    road_cutoff : Hz
        Below it, what is left is road; above it, rest.
    """

    sources: tuple[VibrationSource, ...]
    decomposer: OrderDecomposer
    road_cutoff: float = 30.0

    @cached_property
    def _below(self) -> ZeroPhaseFilter | None:
        return (
            low_pass(self.road_cutoff, rate=self.decomposer.rate)
            if self.road_cutoff < self.decomposer.rate / 2
            else None
        )

    @property
    def causes(self) -> tuple[str, ...]:
        """Names of the causes, in the order of `parts`."""
        said = [
            CAUSE_SLOW_LOAD,
            *(s.cause for s in self.sources),
            CAUSE_SUDDEN_EVENTS,
            CAUSE_ROAD,
            CAUSE_REMAINDER,
        ]
        return tuple(dict.fromkeys(said))

    @property
    def without_joints(self) -> "SourceSeparation":
        """The same for a stress that the joints' own part has been taken off already."""
        tones = tuple(s.component for s in self.sources if s.cause != CAUSE_JOINTS)
        return replace(self, decomposer=replace(self.decomposer, components=tones))

    def parts(self, stretch: OrderDecomposition) -> FloatArray:
        """One stretch by cause, (causes, channels, n)."""
        names = self.causes
        out = np.zeros((len(names), *stretch.signal.shape))
        out[names.index(CAUSE_SLOW_LOAD)] = stretch.slow_mean
        sought = {id(tone) for tone in self.decomposer.components}
        looked_for = [s for s in self.sources if id(s.component) in sought]
        for k, suspect in enumerate(looked_for):
            out[names.index(suspect.cause)] += stretch.components[:, k]
        margin, n = stretch.margin, stretch.signal.shape[1]
        events = stretch.padded_residual * stretch.padded_event
        quiet = stretch.padded_residual - events
        out[names.index(CAUSE_SUDDEN_EVENTS)] = events[:, margin : margin + n]
        if (road := self._below) is not None:
            if road.reach > margin:
                msg = f"telling the road below {self.road_cutoff:g} Hz needs a longer span"
                raise ValueError(msg)
            near = quiet[:, margin - road.reach : margin + n + road.reach]
            below = road.apply(near)
        else:
            below = quiet[:, margin : margin + n]
        out[names.index(CAUSE_ROAD)] += below
        out[names.index(CAUSE_REMAINDER)] = quiet[:, margin : margin + n] - below
        return out


def source_separation(
    named: tuple[VibrationSource, ...], *, rate: float, road: float = 30.0
) -> SourceSeparation:
    """Return the usual separation of these suspects."""
    splitter = OrderDecomposer(components=tuple(s.component for s in named), rate=rate)
    return SourceSeparation(sources=named, decomposer=splitter, road_cutoff=road)


@dataclass(frozen=True)
class ShapleyAttribution:
    """Damage of every choice of causes, and the shares that follow from it.

    Attributes
    ----------
    causes
        Names, G of them.
    damage_by_coalition : (2^G,) 1
        Of the sum of the causes whose bits are set in the index; 0 for none.
    """

    causes: tuple[str, ...]
    damage_by_coalition: FloatArray

    @property
    def total_damage(self) -> float:
        """Damage of all causes together."""
        return float(self.damage_by_coalition[-1])

    def alone(self, cause: str) -> float:
        """Damage of one cause by itself."""
        return float(self.damage_by_coalition[1 << self.causes.index(cause)])

    def without(self, cause: str) -> float:
        """Damage that would have been, had this cause not acted."""
        return float(
            self.damage_by_coalition[
                self.damage_by_coalition.size - 1 - (1 << self.causes.index(cause))
            ]
        )

    def share(self, cause: str) -> float:
        """Shapley share of the whole damage, 1; negative where a cause spares the part."""
        G, bit = len(self.causes), 1 << self.causes.index(cause)
        rest = np.array([s for s in range(self.damage_by_coalition.size) if not s & bit])
        size = np.array([int(s).bit_count() for s in rest])
        weight = 1 / (G * np.array([math.comb(G - 1, int(k)) for k in size]))
        added = float(
            weight @ (self.damage_by_coalition[rest | bit] - self.damage_by_coalition[rest])
        )
        return added / self.total_damage if self.total_damage > 0 else 0.0

    @property
    def shares(self) -> dict[str, float]:
        """Shapley share of every cause; they sum to 1."""
        return {cause: self.share(cause) for cause in self.causes}


class _CoalitionDamage:
    """Damage of one channel over all choices of causes, as stretches pass.

    A cause that has done nothing so far changes nothing: until it acts, choices with it are
    those without. While the same ones act, those at rest are not evaluated: what was counted so is
    that of any choice of them, but for where it begins.
    """

    def __init__(self, curve: SNCurve, correction: MeanStressCorrection) -> None:
        self.curve, self.correction = curve, correction
        self.acted: list[int] = []
        self.damage: dict[int, float] = {0: 0.0}
        self.residue: dict[int, FloatArray] = {0: EMPTY_REVERSALS}
        self.here: list[int] = []
        self.lately: FloatArray = np.zeros(1)
        self.open = [EMPTY_REVERSALS]

    def update(self, parts: FloatArray, gate: float) -> None:
        """Count every choice of a stretch (causes, n), without cycles below a gate."""
        here = np.flatnonzero(parts.any(-1)).tolist()
        if here != self.here:
            self._spread()
            self.here = here
            self.lately, self.open = np.zeros(1 << len(here)), [EMPTY_REVERSALS] * (1 << len(here))
        some = parts if len(here) == len(parts) else parts[here]
        for choices, rows in rainflow_of_cause_coalitions(some, gate=gate, residues=self.open):
            self.lately[choices] += self._done(rows)
            for choice, left in zip(choices, rows.residues, strict=True):
                self.open[choice] = left

    def _spread(self) -> None:
        """Enter what was counted lately, with every choice of those that rested then."""
        for k in self.here:
            if k not in self.acted:
                self.acted.append(k)
                for book in (self.damage, self.residue):
                    book |= {choice | 1 << k: value for choice, value in book.items()}
        resting = [k for k in self.acted if k not in self.here]
        own, others = (
            [sum(1 << k for j, k in enumerate(of) if c >> j & 1) for c in range(1 << len(of))]
            for of in (self.here, resting)
        )
        every = [(k, mine | more) for k, mine in enumerate(own) for more in others]
        rows = four_point_of_many_signals(
            [self.open[k] for k, _ in every], residues=[self.residue[of] for _, of in every]
        )
        for (k, of), done, left in zip(every, self._done(rows), rows.residues, strict=True):
            self.damage[of] += float(self.lately[k] + done)
            self.residue[of] = left

    def _done(self, rows: CyclesOfManySignals) -> FloatArray:
        """Return the damage (rows,) of cycles: of few, none costs as much as a call."""
        done = cycle_damages(rows.cycles, curve=self.curve, correction=self.correction)
        return np.asarray(np.bincount(rows.row, done, len(rows.residues)), float)

    def total_damage(self, rule: ResidueRule, *, causes: int, whole: float) -> FloatArray:
        """Return the damage of every choice (2^causes,), with that of all causes known."""
        self._spread()
        acted = sum(1 << k for k in self.acted)
        done = {
            c: d + miner_damage(rule(self.residue[c]), curve=self.curve, correction=self.correction)
            for c, d in self.damage.items()
        }
        done[acted] = whole
        return np.array([done[c & acted] for c in range(1 << causes)])


MAX_COALITION_OMITTED_DAMAGE_SHARE = 1e-4
"""Share of a gauge's damage that cycles may have which are passed over in choices of causes."""


class _FullCoalitionCount:
    """One channel's stress with all causes, every cycle counted."""

    def __init__(self, curve: SNCurve, correction: MeanStressCorrection) -> None:
        self.curve, self.correction = curve, correction
        self.damage, self.residue = 0.0, EMPTY_REVERSALS

    def update(self, parts: FloatArray) -> float:
        """Take a stretch of it (causes, n); return the range of cycles that it cancels."""
        x = parts.sum(0)
        cycles, self.residue = four_point(x, residue=self.residue)
        self.damage += miner_damage(cycles, curve=self.curve, correction=self.correction)
        # No choice of causes reaches beyond all of them by their sizes; nan is no size.
        crest = float(np.nanmax(np.abs(parts).sum(0), initial=0.0))
        # As many cycles as a stretch can have.
        return omission_level(
            MAX_COALITION_OMITTED_DAMAGE_SHARE * self.damage,
            crest=crest,
            samples=x.size,
            curve=self.curve,
            correction=self.correction,
        )

    def total_damage(self, rule: ResidueRule) -> float:
        left = rule(self.residue)
        return self.damage + miner_damage(left, curve=self.curve, correction=self.correction)


def shapley_attributions(
    stretches: Iterable[FloatArray],
    *,
    causes: Sequence[str],
    curve: SNCurve,
    correction: MeanStressCorrection = uncorrected,
    rule: ResidueRule = half_cycles,
) -> list[ShapleyAttribution]:
    """Count every choice of causes and share the damage among them.

    Parameters
    ----------
    stretches : (causes, channels, n) Pa
        Parts of the stress, one stretch after the other.
    causes
        Their names; the cost doubles with each.
    curve, correction, rule
        As for the whole stress.

    Returns
    -------
    list of ShapleyAttribution
        One a channel.
    """
    choices: list[_CoalitionDamage] = []
    wholes: list[_FullCoalitionCount] = []
    for parts in stretches:
        if not choices:
            choices = [_CoalitionDamage(curve, correction) for _ in range(parts.shape[1])]
            wholes = [_FullCoalitionCount(curve, correction) for _ in choices]
        for one, whole, x in zip(choices, wholes, parts.swapaxes(0, 1), strict=True):
            x = np.ascontiguousarray(x)
            one.update(x, whole.update(x))
    found: list[ShapleyAttribution] = []
    for one, whole in zip(choices, wholes, strict=True):
        damage = one.total_damage(rule, causes=len(causes), whole=whole.total_damage(rule))
        found.append(ShapleyAttribution(tuple(causes), damage))
    return found


def stress_per_torque(force: ComplexArray, unit_stress: FloatArray) -> FloatArray:
    """Stress amplitude (...) Pa per N m that the joints are expected to cause.

    Parameters
    ----------
    force : (..., 3) N per N m, complex
        Order 2 of the force on the centre bearing, vehicle axes, per shaft torque.
    unit_stress : (..., 3) Pa/N
        Stress at the gauge for a unit force on the bearing along each axis.
    """
    return np.abs((force * unit_stress).sum(-1))


@dataclass(frozen=True)
class PredictionComparison:
    """A measured order-2 stress held against what the driveline's geometry predicts.

    Attributes
    ----------
    ratio
        Measured over predicted, by least squares through zero.
    correlation
        Of the two over time: near 1 the measured amplitude follows the torque.
    measured, predicted : Pa
        Root mean square over time of the 0-to-peak amplitudes.
    """

    ratio: float
    correlation: float
    measured: float
    predicted: float


def compare_with_prediction(
    amplitude: ArrayLike, *, torque: ArrayLike, per_torque: float
) -> PredictionComparison:
    """Compare measured order-2 amplitudes (m,) Pa with torque (m,) N m times `per_torque`."""
    a, p = np.abs(np.asarray(amplitude)), np.abs(np.asarray(torque, float)) * per_torque
    known = ~(np.isnan(a) | np.isnan(p)) & (a > 0)
    a, p = a[known], p[known]
    if a.size < 2 or not p.any():
        return PredictionComparison(math.nan, math.nan, math.nan, math.nan)
    spread = float(a.std() * p.std())
    together = float(((a - a.mean()) * (p - p.mean())).mean())
    return PredictionComparison(
        ratio=float(a @ p / (p @ p)),
        correlation=together / spread if spread > 0 else math.nan,
        measured=float(np.sqrt((a**2).mean())),
        predicted=float(np.sqrt((p**2).mean())),
    )


def separate_stress_by_cause_piecewise(
    stress: Iterable[FloatArray], *, how: SourceSeparation
) -> Iterator[tuple[OrderDecomposition, FloatArray]]:
    """Yield each stretch of a stress (channels, n) with its parts (causes, channels, n)."""
    for stretch in how.decomposer.decompose(stress):
        yield stretch, how.parts(stretch)
