"""From a recording to life and cause: looks, counts and takes apart, in that order.

Two passes over the recording, one to see what is wrong with it and one to count; a third
where the causes are asked for. Memory holds a few pieces, whatever the length.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module
from itertools import islice, repeat, tee
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from cardan.base.arrays import FloatArray, single_threaded
from cardan.base.errors import DesignError
from cardan.base.said import Said, said
from cardan.base.units import MPa
from cardan.fatigue.angle import Angle
from cardan.fatigue.beside import FOUR_CYLINDERS
from cardan.fatigue.cause import (
    ENGINE,
    FIRING,
    JOINTS,
    ROAD,
    Attribution,
    Comparison,
    Separation,
    attribute,
    coincidences,
    held_against,
    parts_of,
)
from cardan.fatigue.conditioning import BETWEEN, Health, finer, low_pass, no_zero, survey, treated
from cardan.fatigue.correction import Correction, uncorrected
from cardan.fatigue.damage import Life, damage_exponent, miner, nearly, repeats_at
from cardan.fatigue.evidence import (
    DOUBLED,
    GUILTY,
    HALVED,
    INNOCENT,
    NEGATIVE,
    SCALED,
    STANDING,
    SWAPPED,
    UNSEEN,
    Evidence,
    together,
)
from cardan.fatigue.fault import DROPOUT, FREEZE, HOLE, SENTINEL, SPIKE, union
from cardan.fatigue.locked import FOUND
from cardan.fatigue.orders import Rotation
from cardan.fatigue.quality import (
    ALL_OF_THEM,
    SHORT,
    WOULD_BREAK,
    Assumed,
    Effect,
    Quality,
    Rule,
    Stated,
    Way,
    decided,
    ways,
)
from cardan.fatigue.rainflow import (
    NONE,
    Cycles,
    FromTo,
    ResidueRule,
    four_point,
    half_cycles,
    join,
)
from cardan.fatigue.recording import SIZE, Recording, cut
from cardan.fatigue.response import Identified, identified
from cardan.fatigue.spectral import (
    Spectrum,
    Welch,
    dirlik,
    periodograms,
    rayleigh,
    tovo_benasciutti,
)
from cardan.fatigue.strain import Gauge, PlaneStress, largest, signed_mises
from cardan.fatigue.strength import SNCurve

Progress = Callable[[str, float], None]
"""Told the name of the pass and the seconds of recording done."""


@dataclass(frozen=True, kw_only=True)
class Plan:
    """How damage is to be judged.

    Attributes
    ----------
    gauges
        Places on the part.
    curve
        S-N curve at the gauges; its slope beyond the knee is the Miner variant.
    correction
        For mean stress.
    rule
        For the residue of the count.
    baseline
        What is taken off as zero.
    low_pass : Hz
        Nothing faster counts; no filter unless given.
    allowed
        Damage at failure.
    gauge_error
        Relative standard deviation of the stress scale.
    failures
        Shares of parts for which life is asked.
    segment : samples
        Of the spectra.
    rules
        What is masked or accepted of what looks wrong; the last one that concerns it counts.
    between
        Whether crests are looked for between samples; None where they lose more than `SHORT`.
    ultimate : Pa
        Tensile strength, that no crest may pass; infinite where nobody said it.
    fastest : Hz
        What is known to move in the recording.
    """

    gauges: tuple[Gauge, ...]
    curve: SNCurve
    correction: Correction = uncorrected
    rule: ResidueRule = half_cycles
    baseline: Callable[[Health], FloatArray] = no_zero
    low_pass: float | None = None
    allowed: float = 1.0
    gauge_error: float = 0.0
    failures: tuple[float, ...] = (0.1, 0.5, 0.9)
    segment: int = 4096
    rules: tuple[Rule, ...] = ()
    between: bool | None = None
    ultimate: float = float("inf")
    fastest: float = 0.0

    @property
    def channels(self) -> tuple[str, ...]:
        """Channels the gauges need, each once."""
        return tuple(dict.fromkeys(c for g in self.gauges for c in g.channels))


@dataclass(frozen=True, kw_only=True)
class GaugeLife:
    """What the recording did to one place.

    Attributes
    ----------
    name
        Of the gauge.
    health
        Of its channels, by their names.
    low, high : Pa
        Smallest and largest stress.
    life
        Damage and what follows from it.
    closed : FromTo
        Closed cycles; the matrix rounds stresses to half a bin, 1e-3 in damage at most.
    residue : Pa
        Reversals left open.
    cycles
        Closed cycles, binned, and the residue by its rule.
    exponent
        Per cent of damage for a per cent of stress.
    repeats : share of failed parts to passages of the recording
        With the scatter of strength and gauge.
    spectrum : Pa²/Hz
        Of the stress; None if no stretch was long enough.
    spectral : name to damage
        Of the recording, by Rayleigh, Dirlik and Tovo-Benasciutti.
    quality
        How far to trust it.
    """

    name: str
    health: dict[str, Health]
    low: float
    high: float
    life: Life
    closed: FromTo
    residue: FloatArray
    cycles: Cycles
    exponent: float
    repeats: dict[float, float]
    spectrum: Spectrum | None
    spectral: dict[str, float]
    quality: Quality

    @property
    def heard(self) -> bool:
        """Whether it said anything: a stress that moved, of channels that all did."""
        return self.low < self.high and not any(h.dead for h in self.health.values())

    @property
    def vetoes(self) -> tuple[str, ...]:
        """Kinds of fault that spoil what it said."""
        return self.quality.vetoes if self.heard else ()

    @property
    def vetoed(self) -> bool:
        """Whether what it said is spoiled, so that its life cannot be known."""
        return bool(self.vetoes)


class _Tally:
    """Damage of one stress, as pieces pass."""

    def __init__(self, plan: Plan) -> None:
        self.plan, self.damage, self.residue = plan, 0.0, NONE

    def add(self, stress: FloatArray) -> Cycles:
        cycles, self.residue = four_point(stress, residue=self.residue)
        self.damage += miner(cycles, curve=self.plan.curve, correction=self.plan.correction)
        return cycles

    def closed(self) -> float:
        left = self.plan.rule(self.residue)
        return self.damage + miner(left, curve=self.plan.curve, correction=self.plan.correction)


class _Loud:
    """How much of a stress is too fast to be told where it is loudest, as pieces pass.

    A contact that chatters for some tenths of a second is white, and nothing of all the power; but
    it is all of the damage. So stretches count as damage does, by a power of how far they reach.
    """

    SIZE = 64

    def __init__(self, plan: Plan, rate: float) -> None:
        self.slope, self.rate = plan.curve.slope, rate
        self.most = self.weight = self.share = 0.0
        self.tail = NONE

    def add(self, stress: FloatArray) -> None:
        """Take a piece of it (n,)."""
        x = np.concatenate([self.tail, stress])
        full = x.size // self.SIZE * self.SIZE
        rows, self.tail = x[:full].reshape(-1, self.SIZE), x[full:].copy()
        if not full:
            return
        reach = np.ptp(rows, axis=-1)
        # Half as far does a thirtieth of the damage; nan reaches nowhere.
        so_far = np.fmax(np.fmax.accumulate(reach), self.most)
        self.most = float(so_far[-1])
        loud = reach > so_far / 2
        if not loud.any():
            return
        frequency, power = periodograms(rows[loud].ravel(), rate=self.rate, segment=self.SIZE)
        power = power[::2][: np.count_nonzero(loud)]  # those between two stretches are of neither
        weight = (reach[loud] / MPa) ** self.slope
        fast = power[:, frequency > 0.4 * self.rate].sum(-1)
        whole = np.maximum(power.sum(-1), 1e-300)
        self.weight += float(weight.sum())
        self.share += float(weight @ (fast / whole))

    def fast(self) -> float:
        """Return the share of power above 0.4 of the sample rate there."""
        return self.share / self.weight if self.weight > 0 else 0.0


class _Count(_Tally):
    """One gauge's count, as pieces pass."""

    def __init__(self, plan: Plan, rate: float) -> None:
        super().__init__(plan)
        self.rate, self.matrix, self.live = rate, FromTo.empty(), 0
        self.loud, self.welch = _Loud(plan, rate), Welch(rate, plan.segment)

    def add(self, stress: FloatArray) -> Cycles:
        cycles = super().add(stress)
        self.matrix = self.matrix.added(cycles)
        return cycles

    def hear(self, stress: FloatArray) -> None:
        self.live += int(np.count_nonzero(~np.isnan(stress)))
        self.loud.add(stress)
        self.welch.add(stress)

    def cycles(self) -> Cycles:
        return join([self.matrix.cycles(), self.plan.rule(self.residue)])

    def result(self, gauge: Gauge, healths: dict[str, Health], quality: Quality) -> GaugeLife:
        plan, curve, correction = self.plan, self.plan.curve, self.plan.correction
        if not self.residue.size:
            return self._silence(gauge, healths, quality)
        damage = self.closed()
        cycles = self.cycles()
        binned = miner(cycles, curve=curve, correction=correction)
        lives = repeats_at(
            cycles, curve=curve, failures=plan.failures,
            gauge_error=plan.gauge_error, correction=correction,
        )  # fmt: skip
        # The bins' rounding cancels: their ratio to the exact damage is the same in all.
        exact = plan.allowed * (binned / damage if damage > 0 else 1.0)
        spectrum, spectral = self.welch.spectrum(), dict[str, float]()
        if spectrum is not None and spectrum.moment(0) > 0:
            for method in (rayleigh, dirlik, tovo_benasciutti):
                spectral[method.__name__] = method(spectrum).damage_rate(curve) * quality.live
        return GaugeLife(
            name=gauge.name, health=healths,
            low=float(self.residue.min()), high=float(self.residue.max()),
            life=Life(damage=damage, duration=quality.live, allowed=plan.allowed),
            closed=self.matrix, residue=self.residue, cycles=cycles,
            exponent=damage_exponent(cycles, curve=curve, correction=correction),
            repeats={f: exact * n for f, n in lives.items()},
            spectrum=spectrum, spectral=spectral, quality=quality,
        )  # fmt: skip

    def _silence(self, gauge: Gauge, healths: dict[str, Health], quality: Quality) -> GaugeLife:
        nan = float("nan")
        return GaugeLife(
            name=gauge.name, health=healths, low=nan, high=nan,
            life=Life(damage=nan, duration=quality.live, allowed=self.plan.allowed),
            closed=self.matrix, residue=NONE, cycles=self.matrix.cycles(), exponent=nan,
            repeats=dict.fromkeys(self.plan.failures, nan), spectrum=None, spectral={},
            quality=quality,
        )  # fmt: skip


_PLANES = range(0, 180, 15)
_MEASURES: dict[str, Callable[[PlaneStress], FloatArray]] = {
    "principal": largest,
    **{f"@{a}": partial(PlaneStress.normal, angle=np.radians(a)) for a in _PLANES},
}
"""Measures of a rosette that are held beside each other where it is sheared."""


class _Shear:
    """How a rosette is sheared where it is stressed, and what each measure makes of it."""

    def __init__(self, plan: Plan, along: FloatArray | None) -> None:
        self.weight = self.total = 0.0
        self.ways = {"mises": partial(signed_mises, along=along), **_MEASURES}
        self.tallies = {name: _Tally(plan) for name in self.ways}

    def add(self, plane: PlaneStress) -> None:
        # The fifth power, as damage goes: what is small has no say.
        size = np.nan_to_num(plane.mises) ** 5
        self.weight += float(size.sum())
        self.total += float((size * np.nan_to_num(plane.biaxiality)).sum())
        for name, measure in self.ways.items():
            self.tallies[name].add(measure(plane))

    def biaxiality(self) -> float:
        return self.total / self.weight if self.weight > 0 else float("nan")

    def measures(self) -> dict[str, float]:
        found = {name: tally.closed() for name, tally in self.tallies.items()}
        return {
            "mises": found["mises"], "principal": found["principal"],
            "planes": max(found[f"@{a}"] for a in _PLANES),
        }  # fmt: skip


def _told(
    pieces: Iterable[FloatArray], *, name: str, rate: float, progress: Progress | None
) -> Iterator[FloatArray]:
    done = 0
    for piece in pieces:
        yield piece
        done += piece.shape[-1]
        if progress is not None:
            progress(name, done / rate)


def look(
    recording: Recording, *, channels: Iterable[str], progress: Progress | None = None
) -> dict[str, Health]:
    """Survey some channels of a recording: the first pass.

    Raises
    ------
    DesignError
        If it holds no samples at all.
    """
    names = tuple(channels)
    pieces = _told(recording.pieces(names), name="look", rate=recording.rate, progress=progress)
    found = survey(pieces, rate=recording.rate, names=names)
    if not found:
        msg = f"{recording.name} holds no samples"
        raise DesignError(msg)
    return dict(zip(names, found, strict=True))


def stresses(
    recording: Recording, *, plan: Plan, healths: dict[str, Health], name: str,
    progress: Progress | None = None,
) -> Iterator[FloatArray]:  # fmt: skip
    """Yield the stress of every gauge, treated by the plan's rules, (gauges, n) Pa."""
    how = ways(
        {c: healths[c] for c in plan.channels}, rules=plan.rules, rate=recording.rate,
        baseline=plan.baseline,
    )[:1]  # fmt: skip
    for felt in _felt(recording, plan=plan, how=how, name=name, progress=progress):
        yield felt[0]


def _few(rows: int) -> int:
    """Return the samples of a piece of which so many rows are held: gauges, in each way."""
    return SIZE >> min((rows // 4).bit_length(), 2)


def _felt(
    recording: Recording, *, plan: Plan, how: Sequence[Way], name: str,
    progress: Progress | None = None, seen: Callable[[int, FloatArray], None] | None = None,
) -> Iterator[FloatArray]:  # fmt: skip
    """Yield the stress of every gauge in each way of treatment, (ways, gauges, n) Pa.

    `seen` is shown each gauge's place, and its channels as treated in the first way.
    """
    names = plan.channels
    place = {n: k for k, n in enumerate(names)}
    pieces = recording.pieces(names, size=_few(len(how) * len(plan.gauges)))
    raw = _told(pieces, name=name, rate=recording.rate, progress=progress)

    def rows(clean: Iterable[FloatArray]) -> Iterator[FloatArray]:
        for way, x in enumerate(clean):
            for k, gauge in enumerate(plan.gauges):
                channels = x[[place[c] for c in gauge.channels]]
                if seen is not None and not way:
                    seen(k, channels)
                yield gauge.stress(channels)

    each = treated(raw, how=[[w.treatments[n] for n in names] for w in how])
    made = (np.stack([*rows(clean)]) for clean in each)
    if plan.low_pass is not None:
        made = low_pass(plan.low_pass, rate=recording.rate)(made)
    for felt in made:
        yield felt.reshape(len(how), len(plan.gauges), -1)


def life(
    recording: Recording, *, plan: Plan, healths: dict[str, Health] | None = None,
    distance: float = float("nan"), progress: Progress | None = None,
) -> list[GaugeLife]:  # fmt: skip
    """Damage and life at every gauge of a recording.

    Parameters
    ----------
    recording
        What was measured.
    plan
        How it is judged.
    healths
        Of the plan's channels, if already looked at.
    distance : m
        Driven in the recording, if known.
    progress
        Told how far it is.

    Raises
    ------
    DesignError
        If a gauge has no samples; `counted` leaves what it did to that one unknown.
    """
    found = counted(
        recording, plan=plan, healths=healths, distance=distance, progress=progress
    )  # fmt: skip
    for one in found:
        if not one.residue.size:
            msg = f"gauge {one.name} has no samples to count"
            raise DesignError(msg)
    return found


def counted(
    recording: Recording, *, plan: Plan, healths: dict[str, Health] | None = None,
    distance: float = float("nan"), progress: Progress | None = None,
) -> list[GaugeLife]:  # fmt: skip
    """Damage and life at every gauge, as by `life`; nan at those without a sample."""
    if healths is None:
        healths = look(recording, channels=plan.channels, progress=progress)
    own = {c: healths[c] for c in plan.channels}
    how = ways(own, rules=plan.rules, rate=recording.rate, baseline=plan.baseline)
    gauges = [
        _Listened(g, plan, recording.rate, {c: healths[c] for c in g.channels}, how)
        for g in plan.gauges
    ]
    samples = 0
    felt = _felt(
        recording, plan=plan, how=how, name="count", progress=progress,
        seen=lambda k, channels: gauges[k].see(channels),
    )  # fmt: skip
    sharp = [k for k, g in enumerate(gauges) if g.sharp]
    coarse, fine = tee(felt) if sharp else (felt, iter(()))
    # Of each sample there are so many more, of every gauge in every way.
    few = _few(len(how) * len(gauges)) // BETWEEN
    between = finer(x[:, sharp] for x in cut(fine, size=few))
    # Threads import parts of it when they first need them: two that meet at its own break it.
    import_module("scipy")
    with ThreadPoolExecutor(4) as pool:

        def sharpened(pieces: Iterable[FloatArray]) -> None:
            for more in pieces:
                jobs = [pool.submit(gauges[k].sharpen, more[:, m]) for m, k in enumerate(sharp)]
                for job in jobs:
                    job.result()

        for piece in coarse:
            samples += piece.shape[-1]
            jobs = [pool.submit(g.add, piece[:, k]) for k, g in enumerate(gauges)]
            sharpened(islice(between, -(-piece.shape[-1] // few)))
            for job in jobs:
                job.result()
        sharpened(between)
    return [g.result(samples, distance) for g in gauges]


class _Listened:
    """One gauge in every way of treatment, as pieces pass."""

    def __init__(
        self, gauge: Gauge, plan: Plan, rate: float, healths: dict[str, Health],
        how: Sequence[Way],
    ) -> None:  # fmt: skip
        self.gauge, self.plan, self.rate, self.healths = gauge, plan, rate, healths
        self.decided = {
            c: decided(h, channel=c, rules=plan.rules, rate=rate) for c, h in healths.items()
        }
        kinds = {kind for said in self.decided.values() for kind in said}
        short = max((h.short for h in healths.values() if not h.dead), default=0.0)
        self.sharp = short > SHORT if plan.between is None else plan.between
        self.count = _Count(plan, rate)
        self.others = {
            k: _Tally(plan) for k, w in enumerate(how) if w.kind in kinds or w.kind == ALL_OF_THEM
        }
        self.how = how
        self.samples_only = _Tally(plan)
        self.shear = _Shear(plan, gauge.along) if gauge.plane is not None else None

    def see(self, channels: FloatArray) -> None:
        """Take a piece of the channels (k, n)."""
        if self.shear is not None and self.gauge.plane is not None:
            self.shear.add(self.gauge.plane(channels))

    def add(self, stress: FloatArray) -> None:
        """Take a piece of the stress in each way (ways, n)."""
        self.count.hear(stress[0])
        if self.sharp:
            self.samples_only.add(stress[0])
        else:
            self.sharpen(stress)

    def sharpen(self, stress: FloatArray) -> None:
        """Take what is counted of a piece."""
        self.count.add(stress[0])
        for k, tally in self.others.items():
            tally.add(stress[k])

    def result(self, samples: int, distance: float) -> GaugeLife:
        """Return what it came to in a recording of so many samples."""
        frozen = union(d[FREEZE].open for d in self.decided.values() if FREEZE in d)
        live = self.count.live - int((frozen[:, 1] - frozen[:, 0]).sum())
        spectrum = self.count.welch.spectrum()
        fast = 0.0
        if spectrum is not None and (whole := spectrum.moment(0)) > 0:
            above = spectrum.frequency > 0.4 * self.rate
            fast = Spectrum(spectrum.frequency[above], spectrum.density[above]).moment(0) / whole
            fast = max(fast, self.count.loud.fast())
        quality = Quality(
            live=max(live, 0) / self.rate, recorded=samples / self.rate,
            effects=tuple(self._effects()), fast=fast,
            samples_only=self.samples_only.closed() if self.sharp else float("nan"),
            biaxiality=self.shear.biaxiality() if self.shear else float("nan"),
            measures=self.shear.measures() if self.shear else {},
            doubts=self.gauge.doubts, damage=self.count.closed(),
            without_all=next(
                (t.closed() for k, t in self.others.items() if self.how[k].kind == ALL_OF_THEM),
                float("nan"),
            ),
        )  # fmt: skip
        one = self.count.result(self.gauge, self.healths, quality)
        one = replace(one, quality=self._held(one))
        quality = one.quality
        return replace(one, life=replace(one.life, distance=distance * quality.share))

    def _held(self, one: GaugeLife) -> Quality:
        """Return a gauge's quality with what its numbers contradict of what was said."""
        of, damage, allowed = one.quality, one.life.damage, self.plan.allowed
        if not one.heard:
            return of
        told = list(self.healths.values())
        level = np.array(
            [[float(np.nanmedian(h.levels)) if h.levels.size else h.mean] for h in told]
        )
        swing = np.array([[h.typical] for h in told])
        typical = max(float(np.abs(self.gauge.stress(x))[0]) for x in (level, swing))
        # A spike that is there may be of nobody's stress, whoever accepts it.
        jumps = any(
            kind in (SENTINEL, SPIKE, DROPOUT) and d.places.count > len(d.masked)
            for own in self.decided.values()
            for kind, d in own.items()
        )
        stated = Stated(
            rate=self.rate, bends=min(h.bends for h in told), fastest=self.plan.fastest,
            ultimate=self.plan.ultimate, stuck=max(h.stuck for h in told),
        )  # fmt: skip
        against = stated.contradictions(
            low=one.low,
            high=one.high,
            typical=typical,
            sound=not jumps,
            plane=self.gauge.plane is not None,
        )
        accepted = {
            r.kind
            for r in self.plan.rules
            for c in self.healths
            if not r.mask and r.concerns(c, r.kind)
        }
        samples = max(h.samples for h in self.healths.values())
        effects = tuple(
            Effect(
                kind=kind, count=1, samples=samples, share=1.0, undecided=int(kind not in accepted),
                recorded=damage, without=float("nan"), why=why,
            )
            for kind, why in against.items()
        )  # fmt: skip
        doubts = of.doubts
        if not of.vetoes and damage >= allowed:
            doubts = (*doubts, said(WOULD_BREAK, times=f"{damage / allowed:.3g}"))
        assumed = None
        if self.gauge.otherwise is not None:
            other, factor = self.gauge.otherwise
            of_other = miner(
                one.cycles.scaled(factor), curve=self.plan.curve, correction=self.plan.correction
            )  # fmt: skip
            assumed = Assumed(
                unit=self.gauge.assumed, other=other, factor=factor, damage=of_other
            )  # fmt: skip
        return replace(of, effects=(*of.effects, *effects), doubts=doubts, assumed=assumed)

    def _effects(self) -> Iterator[Effect]:
        ruled = self.count.closed()
        for kind in dict.fromkeys(k for told in self.decided.values() for k in told):
            of = [told[kind] for told in self.decided.values() if kind in told]
            damage = {
                self.how[k].without: tally.closed()
                for k, tally in self.others.items()
                if self.how[k].kind == kind
            }
            samples = sum(d.places.samples for d in of)
            yield Effect(
                kind=kind, count=sum(d.places.count for d in of), samples=samples,
                share=samples / max(sum(h.samples for h in self.healths.values()), 1),
                undecided=0 if kind == HOLE else sum(len(d.open) for d in of),
                recorded=damage.get(False, ruled), without=damage.get(True, ruled),
            )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Causes:
    """Who did the damage at each gauge, and what it rests on.

    Attributes
    ----------
    gauges
        Their names, in the plan's order.
    attributions
        One a gauge, in that order.
    evidence
        What the joints are answerable for, one a gauge.
    without
        Cycles of the stress that is left without the joints' part, one a gauge.
    time : (m,) s
        Middles of the spans in which orders were found.
    speed : (m,) turns/s
        Of the shaft there.
    order2 : (gauges, m) Pa
        0-to-peak amplitude of the joints' order 2 there.
    torque : (m,) N m
        There, if a channel was named.
    comparisons
        Measured order 2 against the predicted, one a gauge, if a prediction was given.
    doubts
        What cannot be told apart in this recording, a sentence each.
    """

    gauges: tuple[str, ...]
    attributions: list[Attribution]
    evidence: list[Evidence]
    without: list[Cycles]
    time: FloatArray
    speed: FloatArray
    order2: FloatArray
    torque: FloatArray | None
    comparisons: list[Comparison]
    doubts: list[Said]

    @property
    def surest(self) -> Evidence | None:
        """Return the evidence of the gauge that knows the speed best; None where none found it."""
        best = max(self.evidence, key=lambda e: e.strength)
        return best if best.strength >= FOUND else None


TOGETHER = (
    "{one} order {order} and {other} order {second} run together for {share} of the time: nothing "
    "in the signal tells them apart there"
)
OF_GAUGE = "{gauge}: {doubt}"
NO_ENGINE = "no engine speed was given: an order of its that runs with order 2 would not show"
DIRECT = (
    "the engine turns with the shaft for {share} of the time: one whose order 2 is strong, of four "
    "cylinders, would do the same as the joints"
)
NO_TORQUE = "no torque was given, so phase alone tells the joints from others"

DOUBTS = (TOGETHER, OF_GAUGE, NO_ENGINE, DIRECT, NO_TORQUE)
"""What may leave a cause open."""

JUDGED = GUILTY, INNOCENT

IDENTIFIED = 300.0
"""Seconds of recording in which the joints' part is identified at once."""


@single_threaded()
def causes(
    recording: Recording, *, plan: Plan, healths: dict[str, Health], how: Separation,
    angle: Angle | None = None, torque: tuple[str, float] | None = None,
    predicted: dict[str, float] | None = None, engine_orders: Sequence[float] = (),
    progress: Progress | None = None,
) -> Causes:  # fmt: skip
    """Share the damage at every gauge among its causes.

    The joints' part is identified first, by phase and torque; what is left is taken apart
    into the other causes.

    Parameters
    ----------
    recording, plan, healths
        As for `life`.
    how
        Tones and their causes.
    angle
        Of the shaft, and how far to trust it; that of the first tone unless given.
    torque
        Channel of the shaft torque, and N m in its unit.
    predicted : Pa per N m
        Order-2 stress expected at a gauge per shaft torque, by gauge name.
    engine_orders
        The engine's own; if nobody says them, it may have four cylinders.
    progress
        Told how far it is.
    """
    # One by one: in the memory of one, and what stands beside a gauge changes nothing of it.
    parts = [
        _of_one(
            recording, plan=replace(plan, gauges=(gauge,)), healths=healths,
            how=how, angle=angle, torque=torque, predicted=predicted, engine_orders=engine_orders,
            progress=progress,
        )
        for gauge in plan.gauges
    ]  # fmt: skip
    gauges = tuple(name for p in parts for name in p.gauges)
    evidence = _of_one_speed([one for p in parts for one in p.evidence])
    doubts = [doubt for p in parts for doubt in p.doubts] + [
        said(OF_GAUGE, gauge=name, doubt=doubt)
        for name, one in zip(gauges, evidence, strict=True)
        for doubt in one.doubts
    ]
    return replace(
        parts[0],
        gauges=gauges,
        attributions=[one for p in parts for one in p.attributions],
        evidence=evidence,
        without=[one for p in parts for one in p.without],
        order2=np.concatenate([p.order2 for p in parts]),
        comparisons=[one for p in parts for one in p.comparisons],
        doubts=list(dict.fromkeys(doubts)),
    )


def _of_one_speed(evidence: list[Evidence]) -> list[Evidence]:
    """Judge at no gauge of a recording at one of which its speed seems to be another's.

    What is locked at another scale may be something else that turns: that only acquits nobody.
    """
    doubts = {d for one in evidence for d in one.doubts}
    for doubt, withheld in ((DOUBLED, JUDGED), (HALVED, JUDGED), (SCALED, (INNOCENT,))):
        if doubt in doubts:
            return [one.unknown(doubt) if one.finding in withheld else one for one in evidence]
    return evidence


def _of_one(
    recording: Recording, *, plan: Plan, healths: dict[str, Health], how: Separation,
    angle: Angle | None, torque: tuple[str, float] | None, predicted: dict[str, float] | None,
    engine_orders: Sequence[float], progress: Progress | None,
) -> Causes:  # fmt: skip
    """Share the damage among its causes at the gauge of a plan."""
    shaft = how.suspects[0].tone.rotation
    joints = _Joints(plan, recording, angle or Angle(shaft), torque, how, engine_orders)
    stress = stresses(recording, plan=plan, healths=healths, name="cause", progress=progress)
    # As numbers: of a day small arrays that stay would keep the room of large ones apart.
    times: list[float] = []
    amplitudes: list[list[float]] = [[] for _ in plan.gauges]
    row = how.causes.index(JOINTS)

    def stretches() -> Iterator[FloatArray]:
        for stretch, parts in parts_of(joints.taken_off(stress), how=how.beside_joints):
            theirs, order2 = joints.part(stretch.start, stretch.signal.shape[1])
            parts[row] += theirs
            times.extend(stretch.time.tolist())
            place = np.rint(stretch.time * recording.rate).astype(np.intp) - stretch.start
            middle = np.clip(place, 0, order2.shape[1] - 1)
            for known, more in zip(amplitudes, order2[:, middle].tolist(), strict=True):
                known.extend(more)
            yield parts

    found = attribute(
        stretches(), causes=how.causes, curve=plan.curve, correction=plan.correction,
        rule=plan.rule,
    )  # fmt: skip
    time, order2 = np.array(times), np.array(amplitudes)
    load = None
    comparisons: list[Comparison] = []
    if torque is not None:
        load = span_means(recording, torque[0], how=how)[: time.size] * torque[1]
        if predicted:
            comparisons = [
                held_against(a[: load.size], torque=load, per_torque=predicted.get(g.name, np.nan))
                for g, a in zip(plan.gauges, order2, strict=True)
            ]
    pairs = coincidences(how.suspects, times=time, resolution=1 / how.splitter.span)
    doubts = [
        said(
            TOGETHER, one=a.cause, order=f"{a.tone.order:g}", other=b.cause,
            second=f"{b.tone.order:g}", share=f"{100 * share:.0f} %",
        )
        for a, b, share in pairs
    ]  # fmt: skip
    evidence = joints.evidence()
    doubt = _no_shaft(joints.angle, joints.engine, time, step=how.splitter.span)
    if doubt is not None:
        evidence = [one.unknown(doubt) for one in evidence]
    if joints.engine is None:
        doubts.append(said(NO_ENGINE))
    elif (share := _direct(shaft, joints.engine, time)) > 0.2 and not engine_orders:
        doubts.append(said(DIRECT, share=f"{100 * share:.0f} %"))
    if torque is None:
        doubts.append(said(NO_TORQUE))
    return Causes(
        gauges=tuple(g.name for g in plan.gauges), attributions=found, evidence=evidence,
        without=[one.cycles() for one in joints.without],
        time=time, speed=shaft.speed(time), order2=order2, torque=load,
        comparisons=comparisons, doubts=doubts,
    )  # fmt: skip


TURNED = 2.0
"""Seconds that a shaft has to turn for, if anything is to be locked to it."""
UNKNOWN = 1 / 3
"""Share of the time under way without a speed, in which anybody may have done the damage."""
LOWEST = 0.6
"""Turns of an engine to one of the shaft that no gear has fewer of; it may coast out of gear."""


def _no_shaft(
    shaft: Angle, engine: Rotation | None, time: FloatArray, *, step: float
) -> Said | None:
    """Return why a speed cannot be the shaft's, as it is at times (n,) s, each for a step."""
    speed, below = shaft.rotation.speed(time), shaft.below(time)
    moving = speed > 1
    if below.any() and np.mean(below[moving | below]) > UNKNOWN:
        return NEGATIVE
    if shaft.dark > UNKNOWN:
        return UNSEEN
    if moving.sum() * step < TURNED:
        return STANDING
    if engine is not None and np.mean(engine.speed(time)[moving] < LOWEST * speed[moving]) > 0.5:
        return SWAPPED
    return None


def _direct(shaft: Rotation, engine: Rotation, time: FloatArray) -> float:
    """Share of the time under way in which engine and shaft turn as one, the gear direct."""
    own, other = shaft.speed(time), engine.speed(time)
    moving = own > 1
    return float(np.mean(np.abs(own - other)[moving] < 0.25)) if moving.any() else 0.0


_Coarse: TypeAlias = npt.NDArray[np.float32]


class _Joints:
    """The joints' part of every gauge, identified stretch by stretch as the stress passes."""

    def __init__(
        self, plan: Plan, recording: Recording, angle: Angle, torque: tuple[str, float] | None,
        how: Separation, engine_orders: Sequence[float],
    ) -> None:  # fmt: skip
        self.plan, self.recording, self.angle, self.torque = plan, recording, angle, torque
        engine = [s.tone for s in how.suspects if s.cause == ENGINE]
        self.engine = engine[0].rotation if engine else None
        wheel = [s.tone for s in how.suspects if s.cause == ROAD]
        self.wheel = wheel[0].rotation if wheel else None
        self.engine_orders = tuple(engine_orders) or (*FIRING, FOUR_CYLINDERS)
        self.told: list[list[tuple[Evidence, float]]] = [[] for _ in plan.gauges]
        self.held: list[tuple[int, _Coarse, _Coarse]] = []
        self.without = [_Count(plan, recording.rate) for _ in plan.gauges]

    def damage(self, stress: FloatArray) -> float:
        """Damage of a stretch of stress (n,)."""
        plan = self.plan
        return nearly(stress, rule=plan.rule, curve=plan.curve, correction=plan.correction)

    def taken_off(self, stress: Iterable[FloatArray]) -> Iterator[FloatArray]:
        """Yield the stress (gauges, n) without their part."""
        rate = self.recording.rate
        size = max(round(IDENTIFIED * rate), 1)
        loads: Iterator[FloatArray | None] = repeat(None)
        if self.torque is not None:
            loads = self.recording.pieces([self.torque[0]], size=size)
        start = 0
        for piece, load in zip(cut(stress, size=size), loads, strict=False):
            torque = None if load is None or self.torque is None else load[0] * self.torque[1]
            answers = [
                identified(
                    x, rate=rate, angle=self.angle, torque=torque, damage=self.damage,
                    engine=self.engine, engine_orders=self.engine_orders, wheel=self.wheel,
                    start=start / rate,
                )
                for x in piece
            ]  # fmt: skip
            yield from self._left(start, piece, answers)
            start += piece.shape[1]

    def _left(
        self, start: int, piece: FloatArray, answers: list[Identified]
    ) -> Iterator[FloatArray]:
        """Take a stretch's answers in, and yield what is left of it without their part."""
        for told, answer in zip(self.told, answers, strict=True):
            told.append((answer.evidence, answer.damage))
        # Held until the stretches that follow have passed: seven digits of it are taken off.
        theirs = np.stack([a.stress.astype(np.float32) for a in answers])
        theirs[np.isnan(piece)] = 0.0
        order2 = np.stack([a.order2.astype(np.float32) for a in answers])
        self.held.append((start, theirs, order2))
        left = piece - theirs
        for count, x in zip(self.without, left, strict=True):
            count.add(x)
        del answers, piece, theirs, order2
        for first in range(0, left.shape[1], SIZE // 8):
            yield left[:, first : first + SIZE // 8].copy()  # a view would hold all of it

    def part(self, start: int, n: int) -> "tuple[_Coarse, _Coarse]":
        """Return their stress and its order 2 in a stretch that has passed, (gauges, n) each."""
        self.held = [h for h in self.held if h[0] + h[1].shape[1] > start]
        rows = [
            [
                part[:, max(start - first, 0) : max(start + n - first, 0)]
                for part in (theirs, order2)
            ]
            for first, theirs, order2 in self.held
        ]
        theirs, order2 = (np.concatenate(parts, axis=-1) for parts in zip(*rows, strict=True))
        return theirs, order2

    def evidence(self) -> list[Evidence]:
        """Return what they are answerable for, one a gauge."""
        return [together([e for e, _ in told], [w for _, w in told]) for told in self.told]


def span_means(recording: Recording, channel: str, *, how: Separation) -> FloatArray:
    """Mean of a channel over each span of a splitter, (spans,)."""
    n = how.splitter.samples
    means: list[FloatArray] = []
    for piece in recording.pieces([channel], size=n * 64):
        x = piece[0]
        if x.size % n:
            x = np.concatenate([x, np.full(n - x.size % n, np.nan)])
        rows = x.reshape(-1, n)
        some = ~np.isnan(rows).all(-1)
        mean = np.full(len(rows), np.nan)
        mean[some] = np.nanmean(rows[some], axis=-1)
        means.append(mean)
    return np.concatenate(means) if means else NONE
