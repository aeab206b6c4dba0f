"""Who did the damage: a stress taken apart by cause, and the share each cause is answerable for.

Damage is not additive: two small cycles on top of each other make a large one, so the
damages of the parts do not sum to that of the whole, and "the damage without X" of all X
sums to more or less than it. The shares here are Shapley values. A cause's share is the
damage it adds, averaged over all orders in which the causes can be put together; the
shares sum to the whole exactly, equal causes get equal shares, and a cause that changes
nothing gets none. Beside them stand the damage without each cause and of each alone.
Source: Shapley, A value for n-person games (1953).
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cardan.base.arrays import ArrayLike, ComplexArray, FloatArray
from cardan.fatigue.conditioning import Filter, low_pass
from cardan.fatigue.correction import Correction, uncorrected
from cardan.fatigue.damage import damages, harmless, miner
from cardan.fatigue.orders import Rotation, Split, Splitter, Tone
from cardan.fatigue.rainflow import (
    NONE,
    ResidueRule,
    Rows,
    four_point,
    four_points,
    half_cycles,
    of_choices,
)
from cardan.fatigue.strength import SNCurve

LOAD, EVENTS, ROAD, REST = "load", "events", "road and wheel", "rest"
UNBALANCE, JOINTS, ENGINE = "unbalance", "joints", "engine"

MEANING = {
    LOAD: "slow mean: driving torque, weight, manoeuvres",
    UNBALANCE: "shaft order 1",
    JOINTS: "shaft orders 2 and 4",
    ENGINE: "engine orders",
    ROAD: "wheel orders, and what is neither locked nor sudden below the road's upper frequency",
    EVENTS: "sudden and rare: potholes, kerbs, gear clunks",
    REST: "everything faster that is not locked to a rotation",
}


@dataclass(frozen=True)
class Suspect:
    """A tone and the cause it speaks for."""

    cause: str
    tone: Tone


FIRING = (3.0, 6.0)
"""Orders of an engine of which nothing is said: six cylinders."""


def suspects(
    shaft: Rotation,
    *,
    joint_orders: Sequence[float] = (2.0, 4.0),
    engine: Rotation | None = None,
    engine_orders: Sequence[float] = FIRING,
    wheel: Rotation | None = None,
    wheel_orders: Sequence[float] = (1.0, 2.0),
) -> tuple[Suspect, ...]:
    """Name the tones of a driveline: unbalance, joints, engine, wheels.

    Parameters
    ----------
    shaft, engine, wheel
        Rotations; engine and wheel only where they are known.
    joint_orders, engine_orders, wheel_orders
        Multiples of each one's own speed. A four-stroke engine of n cylinders excites n/2.
    """
    found = [Suspect(UNBALANCE, Tone(shaft, 1.0))]
    found += [Suspect(JOINTS, Tone(shaft, k)) for k in joint_orders]
    if engine is not None:
        found += [Suspect(ENGINE, Tone(engine, k)) for k in engine_orders]
    if wheel is not None:
        found += [Suspect(ROAD, Tone(wheel, k)) for k in wheel_orders]
    return tuple(found)


def coincidences(
    named: Sequence[Suspect], *, times: FloatArray, resolution: float
) -> list[tuple[Suspect, Suspect, float]]:
    """Pairs of tones of two causes that run within `resolution` Hz, and the share of time.

    While they do, nothing in the signal tells them apart, and their sum is shared evenly.
    """
    pairs: list[tuple[Suspect, Suspect, float]] = []
    if not times.size:
        return pairs
    for k, one in enumerate(named):
        for other in named[k + 1 :]:
            if one.cause != other.cause:
                f, g = one.tone.frequency(times), other.tone.frequency(times)
                moving = np.maximum(f, g) > resolution
                close = float((moving & (np.abs(f - g) < resolution)).mean())
                if close > 0.01:
                    pairs.append((one, other, close))
    return pairs


@dataclass(frozen=True, kw_only=True)
class Separation:
    """How a stress is taken apart into causes that sum to it exactly.

    Attributes
    ----------
    suspects
        Tones and their causes.
    splitter
        Finds them; its tones are those of the suspects, less what is identified elsewhere.
    road : Hz
        Below it, what is left is road; above it, rest.
    """

    suspects: tuple[Suspect, ...]
    splitter: Splitter
    road: float = 30.0

    @cached_property
    def _below(self) -> Filter | None:
        return (
            low_pass(self.road, rate=self.splitter.rate)
            if self.road < self.splitter.rate / 2
            else None
        )

    @property
    def causes(self) -> tuple[str, ...]:
        """Names of the causes, in the order of `parts`."""
        said = [LOAD, *(s.cause for s in self.suspects), EVENTS, ROAD, REST]
        return tuple(dict.fromkeys(said))

    @property
    def beside_joints(self) -> "Separation":
        """The same for a stress that the joints' own part has been taken off already."""
        tones = tuple(s.tone for s in self.suspects if s.cause != JOINTS)
        return replace(self, splitter=replace(self.splitter, tones=tones))

    def parts(self, stretch: Split) -> FloatArray:
        """One stretch by cause, (causes, channels, n)."""
        names = self.causes
        out = np.zeros((len(names), *stretch.signal.shape))
        out[names.index(LOAD)] = stretch.slow
        sought = {id(tone) for tone in self.splitter.tones}
        looked_for = [s for s in self.suspects if id(s.tone) in sought]
        for k, suspect in enumerate(looked_for):
            out[names.index(suspect.cause)] += stretch.tones[:, k]
        margin, n = stretch.margin, stretch.signal.shape[1]
        events = stretch.padded_rest * stretch.padded_event
        quiet = stretch.padded_rest - events
        out[names.index(EVENTS)] = events[:, margin : margin + n]
        if (road := self._below) is not None:
            if road.reach > margin:
                msg = f"telling the road below {self.road:g} Hz needs a longer span"
                raise ValueError(msg)
            near = quiet[:, margin - road.reach : margin + n + road.reach]
            below = road.centred(near)
        else:
            below = quiet[:, margin : margin + n]
        out[names.index(ROAD)] += below
        out[names.index(REST)] = quiet[:, margin : margin + n] - below
        return out


def separation(named: tuple[Suspect, ...], *, rate: float, road: float = 30.0) -> Separation:
    """Return the usual separation of these suspects."""
    splitter = Splitter(tones=tuple(s.tone for s in named), rate=rate)
    return Separation(suspects=named, splitter=splitter, road=road)


@dataclass(frozen=True)
class Attribution:
    """Damage of every choice of causes, and the shares that follow from it.

    Attributes
    ----------
    causes
        Names, G of them.
    damage : (2^G,) 1
        Of the sum of the causes whose bits are set in the index; 0 for none.
    """

    causes: tuple[str, ...]
    damage: FloatArray

    @property
    def whole(self) -> float:
        """Damage of all causes together."""
        return float(self.damage[-1])

    def alone(self, cause: str) -> float:
        """Damage of one cause by itself."""
        return float(self.damage[1 << self.causes.index(cause)])

    def without(self, cause: str) -> float:
        """Damage that would have been, had this cause not acted."""
        return float(self.damage[self.damage.size - 1 - (1 << self.causes.index(cause))])

    def share(self, cause: str) -> float:
        """Shapley share of the whole damage, 1; negative where a cause spares the part."""
        G, bit = len(self.causes), 1 << self.causes.index(cause)
        rest = np.array([s for s in range(self.damage.size) if not s & bit])
        size = np.array([int(s).bit_count() for s in rest])
        weight = 1 / (G * np.array([math.comb(G - 1, int(k)) for k in size]))
        added = float(weight @ (self.damage[rest | bit] - self.damage[rest]))
        return added / self.whole if self.whole > 0 else 0.0

    @property
    def shares(self) -> dict[str, float]:
        """Shapley share of every cause; they sum to 1."""
        return {cause: self.share(cause) for cause in self.causes}


class _Choices:
    """Damage of one channel over all choices of causes, as stretches pass.

    A cause that has done nothing so far changes nothing: until it acts, choices with it are
    those without. While the same ones act, those that rest are not asked: what was counted so is
    that of any choice of them, but for where it begins.
    """

    def __init__(self, curve: SNCurve, correction: Correction) -> None:
        self.curve, self.correction = curve, correction
        self.acted: list[int] = []
        self.damage: dict[int, float] = {0: 0.0}
        self.residue: dict[int, FloatArray] = {0: NONE}
        self.here: list[int] = []
        self.lately: FloatArray = np.zeros(1)
        self.open = [NONE]

    def add(self, parts: FloatArray, gate: float) -> None:
        """Count every choice of a stretch (causes, n), without cycles below a gate."""
        here = np.flatnonzero(parts.any(-1)).tolist()
        if here != self.here:
            self._spread()
            self.here = here
            self.lately, self.open = np.zeros(1 << len(here)), [NONE] * (1 << len(here))
        some = parts if len(here) == len(parts) else parts[here]
        for choices, rows in of_choices(some, gate=gate, residues=self.open):
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
        rows = four_points(
            [self.open[k] for k, _ in every], residues=[self.residue[of] for _, of in every]
        )
        for (k, of), done, left in zip(every, self._done(rows), rows.residues, strict=True):
            self.damage[of] += float(self.lately[k] + done)
            self.residue[of] = left

    def _done(self, rows: Rows) -> FloatArray:
        """Return the damage (rows,) of cycles: of few, none costs as much as a call."""
        done = damages(rows.cycles, curve=self.curve, correction=self.correction)
        return np.asarray(np.bincount(rows.row, done, len(rows.residues)), float)

    def closed(self, rule: ResidueRule, *, causes: int, whole: float) -> FloatArray:
        """Return the damage of every choice (2^causes,), with that of all causes known."""
        self._spread()
        acted = sum(1 << k for k in self.acted)
        done = {
            c: d + miner(rule(self.residue[c]), curve=self.curve, correction=self.correction)
            for c, d in self.damage.items()
        }
        done[acted] = whole
        return np.array([done[c & acted] for c in range(1 << causes)])


PASSED_OVER = 1e-4
"""Share of a gauge's damage that cycles may have which are passed over in choices of causes."""


class _Whole:
    """One channel's stress with all causes, every cycle counted."""

    def __init__(self, curve: SNCurve, correction: Correction) -> None:
        self.curve, self.correction = curve, correction
        self.damage, self.residue = 0.0, NONE

    def add(self, parts: FloatArray) -> float:
        """Take a stretch of it (causes, n); return the range of cycles that do not count beside."""
        x = parts.sum(0)
        cycles, self.residue = four_point(x, residue=self.residue)
        self.damage += miner(cycles, curve=self.curve, correction=self.correction)
        # No choice of causes reaches beyond all of them by their sizes; nan is no size.
        crest = float(np.nanmax(np.abs(parts).sum(0), initial=0.0))
        # As many cycles as a stretch can have.
        return harmless(
            PASSED_OVER * self.damage, crest=crest, samples=x.size, curve=self.curve,
            correction=self.correction,
        )  # fmt: skip

    def closed(self, rule: ResidueRule) -> float:
        left = rule(self.residue)
        return self.damage + miner(left, curve=self.curve, correction=self.correction)


def attribute(
    stretches: Iterable[FloatArray],
    *,
    causes: Sequence[str],
    curve: SNCurve,
    correction: Correction = uncorrected,
    rule: ResidueRule = half_cycles,
) -> list[Attribution]:
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
    list of Attribution
        One a channel.
    """
    choices: list[_Choices] = []
    wholes: list[_Whole] = []
    for parts in stretches:
        if not choices:
            choices = [_Choices(curve, correction) for _ in range(parts.shape[1])]
            wholes = [_Whole(curve, correction) for _ in choices]
        for one, whole, x in zip(choices, wholes, parts.swapaxes(0, 1), strict=True):
            x = np.ascontiguousarray(x)
            one.add(x, whole.add(x))
    found: list[Attribution] = []
    for one, whole in zip(choices, wholes, strict=True):
        damage = one.closed(rule, causes=len(causes), whole=whole.closed(rule))
        found.append(Attribution(tuple(causes), damage))
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
class Comparison:
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


def held_against(amplitude: ArrayLike, *, torque: ArrayLike, per_torque: float) -> Comparison:
    """Compare measured order-2 amplitudes (m,) Pa with torque (m,) N m times `per_torque`."""
    a, p = np.abs(np.asarray(amplitude)), np.abs(np.asarray(torque, float)) * per_torque
    known = ~(np.isnan(a) | np.isnan(p)) & (a > 0)
    a, p = a[known], p[known]
    if a.size < 2 or not p.any():
        return Comparison(math.nan, math.nan, math.nan, math.nan)
    spread = float(a.std() * p.std())
    together = float(((a - a.mean()) * (p - p.mean())).mean())
    return Comparison(
        ratio=float(a @ p / (p @ p)),
        correlation=together / spread if spread > 0 else math.nan,
        measured=float(np.sqrt((a**2).mean())),
        predicted=float(np.sqrt((p**2).mean())),
    )


def parts_of(
    stress: Iterable[FloatArray], *, how: Separation
) -> Iterator[tuple[Split, FloatArray]]:
    """Yield each stretch of a stress (channels, n) with its parts (causes, channels, n)."""
    for stretch in how.splitter.split(stress):
        yield stretch, how.parts(stretch)
