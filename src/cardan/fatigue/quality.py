"""How far a gauge's answer may be trusted: what its faults change, and who decided on them.

Each kind of fault is counted twice, with it and without. Where that changes the damage by
more than a fifth and nobody said what it was, there is no answer to give, only two.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from cardan.base.arrays import FloatArray, IntArray
from cardan.base.said import Said, said
from cardan.base.units import MPa
from cardan.fatigue.conditioning import Health, Treatment, gained, shifts, slow_drift
from cardan.fatigue.fault import (
    BIT,
    CLIP,
    DRIFT,
    FREEZE,
    GAIN,
    HOLE,
    HUM,
    IMPOSSIBLE,
    MASKABLE,
    NOWHERE,
    RATE,
    REMOVABLE,
    STRENGTH,
    TAKEN_OFF,
    UNIT,
    ZERO_STEP,
    Places,
    union,
)

VETO = 0.2
"""Change of damage, relative, beyond which a fault nobody decided on leaves no answer."""
CLIPPED = 0.01
"""Share of samples cut off that leaves no answer, whatever is put on top of them."""
LEAST_LIVE = 0.25
"""Share of the time a gauge must have lived to be answered for."""
SHORT = 0.01
"""What crests may lose between samples before they are looked for there: 5 % at slope 5."""
LARGEST = 3e9
"""Stress beyond which no metal of a vehicle bears a cycle, Pa: strongest wire breaks there."""
SMALLEST = 0.1e6
"""Range of a whole recording below which it is the noise of a strain gauge, Pa: 0.5 µm/m."""
SELDOM, OFTEN = 50.0, 1e6
"""Samples a second of a strain gauge: a wheel hops at 10 to 15 Hz, and a converter ends."""
HALF = 0.5
"""Share of the samples at which what moves bends, below which lines were laid between others."""
A_TURN = 2.5
"""Samples that a turn of what moves fastest takes to be met at all."""
FAST = 0.05
"""Share of power above 0.4 of the sample rate that makes a recording look undersampled."""


@dataclass(frozen=True, kw_only=True)
class Rule:
    """Whether what looks wrong is masked or accepted.

    Attributes
    ----------
    mask
        Make holes of it; else it is what the part felt.
    kind
        Of fault; "" for whatever was recorded in the time given.
    channel
        "" for every one.
    first, last : s
        What begins in this time.
    """

    mask: bool
    kind: str = ""
    channel: str = ""
    first: float = 0.0
    last: float = float("inf")

    @property
    def always(self) -> bool:
        """Whether it names no time."""
        return (self.first, self.last) == (0.0, float("inf"))

    def concerns(self, channel: str, kind: str) -> bool:
        """Whether it decides on this kind of this channel."""
        return self.kind in ("", kind) and self.channel in ("", channel)

    def contradicts(self, other: "Rule") -> bool:
        """Whether another rule, saying as much, decides otherwise on the same."""
        alike = (self.kind, self.channel, self.always) == (other.kind, other.channel, other.always)
        together = self.first <= other.last and other.first <= self.last
        return alike and together and self.mask != other.mask


@dataclass(frozen=True, kw_only=True)
class Decided:
    """What rules make of one kind of fault in one channel.

    Attributes
    ----------
    places
        All of them.
    masked, open : (k, 2) samples
        Those made holes of, and those nobody decided on.
    """

    places: Places
    masked: IntArray
    open: IntArray


def decided(
    health: Health, *, channel: str, rules: Sequence[Rule], rate: float
) -> dict[str, Decided]:
    """Return what rules make of each kind of fault of a channel; the last rule counts."""
    out: dict[str, Decided] = {}
    for kind, where in health.faults.items():
        start = where.runs[:, 0] / rate
        mask, free = np.zeros(where.count, bool), np.ones(where.count, bool)
        for rule in rules:
            if rule.concerns(channel, kind):
                inside = (start >= rule.first) & (start <= rule.last)
                mask[inside], free[inside] = rule.mask, False
        mask &= kind in REMOVABLE
        out[kind] = Decided(places=where, masked=where.runs[mask], open=where.runs[free])
    if health.drifts:
        whole = np.array([[0, health.samples]], np.intp)
        told = any(r.kind and r.concerns(channel, DRIFT) for r in rules)
        where = Places(whole, np.array([health.drift]))
        out[DRIFT] = Decided(places=where, masked=whole[:0], open=whole[: 0 if told else 1])
    if health.hum is not None:
        whole = np.array([[0, health.samples]], np.intp)
        told = [r.mask for r in rules if r.kind and r.concerns(channel, HUM)]
        off = bool(told) and told[-1]
        where = Places(whole, np.array([health.hum.amplitude]))
        out[HUM] = Decided(places=where, masked=whole[: int(off)], open=whole[: int(not told)])
    return out


def windows(*, channel: str, rules: Sequence[Rule], rate: float, samples: int) -> IntArray:
    """Return the runs (k, 2) of samples that rules mask by time alone."""
    rows = [
        (max(int(np.ceil(r.first * rate)), 0), int(min(r.last * rate, samples - 1)) + 1)
        for r in rules
        if r.mask and not r.kind and r.channel in ("", channel)
    ]
    return union([np.array([r], np.intp) for r in rows if r[1] > r[0]])


def _creep(health: Health) -> FloatArray:
    """Return what a channel creeps by, five spans at a time: a step of its zero goes too."""
    return slow_drift(health, spans=5)


def _off(of: Decided, *, every: bool, none: bool) -> Places:
    """Return the places that are taken off: those that rules mask, all, or none."""
    if none:
        return NOWHERE
    if every:
        return of.places
    mine = np.isin(of.places.runs[:, 0], of.masked[:, 0])
    return Places(of.places.runs[mine], of.places.sizes[mine])


def _less(health: Health, steps: Places, gains: Places) -> Health:
    """Return a channel's health with steps and gains taken off its levels."""
    if not (steps.count or gains.count):
        return health
    middle = (np.arange(health.levels.size) + 0.5) * health.span
    return replace(health, levels=(health.levels - shifts(steps, middle)) / gained(gains, middle))


ALL_OF_THEM = "together"
"""Of a way in which all kinds that nobody decided on are gone: each may hide what another does."""


@dataclass(frozen=True, kw_only=True)
class Way:
    """One way to treat the channels: as ruled, or one kind of fault the other way."""

    kind: str = ""
    without: bool = True
    treatments: Mapping[str, Treatment]


def ways(
    healths: Mapping[str, Health], *, rules: Sequence[Rule], rate: float,
    baseline: Callable[[Health], FloatArray],
) -> list[Way]:  # fmt: skip
    """Return the ways to treat channels: as ruled first, then each kind with and without.

    A kind that rules mask whole, or not at all, is once what the first way does already.
    """
    book = {c: decided(h, channel=c, rules=rules, rate=rate) for c, h in healths.items()}

    def way(*kinds: str, without: bool = True) -> Way:
        made: dict[str, Treatment] = {}
        for channel, health in healths.items():
            own = book[channel]
            runs = [windows(channel=channel, rules=rules, rate=rate, samples=health.samples)]
            runs += [d.masked for k, d in own.items() if k not in (*kinds, *TAKEN_OFF)]
            if without:
                runs += [own[k].places.runs for k in kinds if k in MASKABLE and k in own]
            steps, gains = (
                _off(own[k], every=without and k in kinds, none=k in kinds and not without)
                if k in own else NOWHERE
                for k in (ZERO_STEP, GAIN)
            )  # fmt: skip
            level = baseline
            if DRIFT in kinds and without and DRIFT in own:
                level = _creep
            quiet = without if HUM in kinds else HUM in own and len(own[HUM].masked) > 0
            crowns = own[CLIP].places if CLIP in kinds and CLIP in own else None
            made[channel] = Treatment(
                masked=union(runs), baseline=level(_less(health, steps, gains)), span=health.span,
                steps=steps, gains=gains, hum=health.hum if quiet else None,
                **({"crowned": crowns} if crowns is not None else {}),
            )  # fmt: skip
        return Way(kind=kinds[0] if len(kinds) == 1 else ALL_OF_THEM * bool(kinds),
                   without=without, treatments=made)  # fmt: skip

    out = [way()]
    open_: list[str] = []
    for kind in dict.fromkeys(k for told in book.values() for k in told):
        if kind in (HOLE, FREEZE):  # no cycle comes or goes with them, only time
            continue
        of = [told[kind] for told in book.values() if kind in told]
        masked = sum(len(d.masked) for d in of)
        if masked < sum(d.places.count for d in of):
            out.append(way(kind))
        if masked:
            out.append(way(kind, without=False))
        if any(len(d.open) for d in of):
            open_.append(kind)
    return [*out, way(*open_)] if len(open_) > 1 else out


NO_METAL = (
    "{size} MPa of stress, more than any metal bears ({most} MPa): are its numbers in another unit?"
)
NO_STRESS = (
    "it moves by {size} MPa in all, less than a gauge's noise ({least} MPa): are its numbers in "
    "another unit?"
)
SELDOM_MET = (
    "{rate} samples a second, fewer than a driveline's stress takes ({least}): what moves between "
    "them is lost; or does its clock count something else than seconds (--time CLOCK:ms)?"
)
LAID = (
    "lines go from one to the next of {rate} samples a second, fewer than {least}: what moves "
    "between them is lost, unless they are all its turns"
)
OFTEN_MET = (
    "{rate} samples a second, more than a strain gauge has: does its clock count something else "
    "(--time CLOCK:s)?"
)
TURNS_FASTER = (
    "the shaft's order 2 reaches {frequency} Hz, and {rate} samples a second hold what is below "
    "{most} Hz: larger cycles may have happened between them"
)
BROKEN = (
    "its crests reach {size} MPa, and the tensile strength that was given is {ultimate} MPa: no "
    "part bore both"
)
WOULD_BREAK = (
    "in this recording alone the damage is {times} times what breaks the part: if it did not "
    "break, unit, scale or S-N curve are not its own"
)
NAMED_STRAIN = "its name speaks of strain, and it is taken for a stress in {unit}"
NAMED_STRESS = "its name speaks of stress, and it is taken for a strain in {unit}"

STANDS_STILL = (
    "each second band of {width} of its values is empty: a bit of the converter stands still"
)

IMPOSSIBLES = (NO_METAL, NO_STRESS, SELDOM_MET, LAID, OFTEN_MET, TURNS_FASTER, BROKEN, STANDS_STILL)
"""Why a gauge's answer cannot be true."""
DOUBTS = (WOULD_BREAK, NAMED_STRAIN, NAMED_STRESS)
"""What makes it doubtful."""


@dataclass(frozen=True, kw_only=True)
class Stated:
    """What was said of a recording that its numbers may contradict.

    Attributes
    ----------
    rate : Hz
        Of its samples.
    bends
        Share of them at which it does not go straight on (`Health.bends`).
    fastest : Hz
        Known to move there, an order 2; 0 where nobody knows.
    ultimate : Pa
        Tensile strength; infinite where nobody said it.
    """

    rate: float
    bends: float = 1.0
    fastest: float = 0.0
    ultimate: float = float("inf")
    stuck: float = 0.0

    def contradictions(
        self, *, low: float, high: float, typical: float, sound: bool, plane: bool = False
    ) -> dict[str, Said]:
        """Return why a stress (Pa) cannot be what it is said to be, by kind.

        Parameters
        ----------
        low, high : Pa
            Smallest and largest.
        typical : Pa
            What it usually is.
        sound
            Whether the largest is of the part, and no spike that nobody decided on.
        plane
            Whether it is one measure of a rosette, of which some are nought.
        """
        found: dict[str, Said] = {}
        crest = max(high, -low)
        size = crest if sound else typical
        if size > LARGEST:
            found[UNIT] = said(NO_METAL, size=f"{size / MPa:.3g}", most=f"{LARGEST / MPa:g}")
        elif high - low < SMALLEST and not plane:
            size = f"{(high - low) / MPa:.2g}"
            found[UNIT] = said(NO_STRESS, size=size, least=f"{SMALLEST / MPa:g}")
        elif sound and crest > self.ultimate:
            found[STRENGTH] = said(
                BROKEN, size=f"{crest / MPa:.4g}", ultimate=f"{self.ultimate / MPa:g}"
            )
        rate, least = f"{self.rate:.4g}", max(SELDOM, A_TURN * self.fastest)
        if self.bends < HALF and self.bends * self.rate < least <= self.rate:
            found[RATE] = said(
                LAID, rate=f"{self.bends * self.rate:.2g}", least=f"{least:.3g}"
            )  # fmt: skip
        elif self.rate < SELDOM:
            found[RATE] = said(SELDOM_MET, rate=rate, least=f"{SELDOM:g}")
        elif self.rate > OFTEN:
            found[RATE] = said(OFTEN_MET, rate=rate)
        elif self.rate < A_TURN * self.fastest:
            found[RATE] = said(
                TURNS_FASTER, frequency=f"{self.fastest:.3g}", rate=rate,
                most=f"{self.rate / A_TURN:.3g}",
            )  # fmt: skip
        if self.stuck:
            found[BIT] = said(STANDS_STILL, width=f"{self.stuck:.3g}")
        return found


@dataclass(frozen=True, kw_only=True)
class Effect:
    """What one kind of fault changes at a gauge.

    Attributes
    ----------
    kind
        Of fault.
    count, samples
        How many there are in the gauge's channels.
    share
        Of the channels' samples.
    undecided
        How many of them no rule accepts or masks.
    recorded, without
        Damage with all of them as recorded, and with none: masked, or a clipped crest put back,
        a drift or a hum taken off; nan of what is impossible.
    why
        What is impossible, of a gauge as a whole.
    """

    kind: str
    count: int
    samples: int
    share: float
    undecided: int
    recorded: float
    without: float
    why: Said | None = None

    @property
    def change(self) -> float:
        """How much more the larger of the two damages is than the smaller, relative."""
        return _apart(self.recorded, self.without)


def _apart(one: float, other: float) -> float:
    """Return how much more the larger of two damages is than the smaller, relative."""
    low, high = sorted((one, other))
    return high / low - 1 if low > 0 else (np.inf if high > 0 else 0.0)


@dataclass(frozen=True, kw_only=True)
class Assumed:
    """A unit that only somebody's word says, and what it would be in one as likely.

    Attributes
    ----------
    unit, other
        As they are written.
    factor
        How many times as large the stress is in the other.
    damage
        Of that.
    """

    unit: str
    other: str
    factor: float
    damage: float


@dataclass(frozen=True, kw_only=True)
class Quality:
    """How far one gauge's answer may be trusted.

    Attributes
    ----------
    live, recorded : s
        Time the gauge was alive, neither missing, masked nor frozen; and time recorded.
    effects
        One a kind of fault that changes cycles, and of what only takes time away.
    samples_only
        Damage by the samples alone, where crests were looked for between them; else nan.
    fast
        Share of the stress's power above 0.4 of the sample rate, of all or where it is loudest.
    biaxiality
        Of a rosette, where the stress is high; nan of single gauges.
    measures
        Damage of a rosette by each measure of its stress, where it is sheared.
    doubts
        What looks as if it had been said wrongly, a sentence each.
    assumed
        Its unit, where the recording does not say it: no number of it shows that it is right.
    damage, without_all
        As ruled, and without all that nobody decided on, where that is of several kinds; else nan.
    """

    live: float
    recorded: float
    effects: tuple[Effect, ...] = ()
    samples_only: float = float("nan")
    fast: float = 0.0
    biaxiality: float = float("nan")
    measures: Mapping[str, float] = field(default_factory=dict[str, float])
    doubts: tuple[Said, ...] = ()
    assumed: Assumed | None = None
    damage: float = float("nan")
    without_all: float = float("nan")

    @property
    def share(self) -> float:
        """Share of the time recorded in which the gauge was alive."""
        return self.live / self.recorded if self.recorded > 0 else 0.0

    @property
    def vetoes(self) -> tuple[str, ...]:
        """Kinds of fault that leave no answer; "hole" where it hardly lived."""
        found = [
            e.kind
            for e in self.effects
            # What is put on top of a clipped crest may be less than what was there.
            if e.undecided
            and (
                e.kind in IMPOSSIBLE
                or e.change > (VETO / 2 if e.kind == CLIP else VETO)
                or (e.kind == CLIP and e.share > CLIPPED)
            )
        ]
        if not found and _apart(self.damage, self.without_all) > VETO:
            # Of what one fault did a part is taken for one kind, a part for another.
            found = [e.kind for e in self.effects if e.undecided and e.kind not in (HOLE, FREEZE)]
        return (*found, HOLE) if self.share < LEAST_LIVE else tuple(found)

    @property
    def sheared(self) -> bool:
        """Whether a rosette's stress is mostly shear, so that its measure decides."""
        return self.biaxiality < -0.5

    @property
    def verdict(self) -> str:
        """Return "vetoed", "doubtful" or "good"."""
        if self.vetoes:
            return "vetoed"
        doubtful = any(e.undecided for e in self.effects) or self.share < 0.9
        doubtful = doubtful or self.sheared or self.fast > FAST or bool(self.doubts)
        return "doubtful" if doubtful else "good"
