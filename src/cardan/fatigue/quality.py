"""How far a gauge's answer may be trusted: what its faults change, and who decided on them.

Each kind of fault is counted twice, with it and without. Where that changes the damage by
more than a fifth and nobody said what it was, there is no answer to give, only two.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from cardan.base.arrays import FloatArray, IntArray
from cardan.fatigue.conditioning import Health, Treatment, shifts, slow_drift
from cardan.fatigue.fault import (
    CLIP,
    DRIFT,
    FREEZE,
    HOLE,
    MASKABLE,
    NOWHERE,
    REMOVABLE,
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

    def concerns(self, channel: str, kind: str) -> bool:
        """Whether it decides on this kind of this channel."""
        return self.kind in ("", kind) and self.channel in ("", channel)


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
    """Return the steps of the zero that are taken off: those that rules mask, all, or none."""
    if none:
        return NOWHERE
    if every:
        return of.places
    mine = np.isin(of.places.runs[:, 0], of.masked[:, 0])
    return Places(of.places.runs[mine], of.places.sizes[mine])


def _less(health: Health, steps: Places) -> Health:
    """Return a channel's health with steps taken off its levels."""
    if not steps.count:
        return health
    middle = (np.arange(health.levels.size) + 0.5) * health.span
    return replace(health, levels=health.levels - shifts(steps, middle))


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

    def way(kind: str = "", *, without: bool = True) -> Way:
        made: dict[str, Treatment] = {}
        for channel, health in healths.items():
            said = book[channel]
            runs = [windows(channel=channel, rules=rules, rate=rate, samples=health.samples)]
            runs += [d.masked for k, d in said.items() if k not in (kind, ZERO_STEP)]
            if without and kind in MASKABLE and kind in said:
                runs.append(said[kind].places.runs)
            steps = NOWHERE
            if ZERO_STEP in said:
                every = without and kind == ZERO_STEP
                steps = _off(said[ZERO_STEP], every=every, none=kind == ZERO_STEP and not without)
            level = baseline
            if kind == DRIFT and without and kind in said:
                level = _creep
            crowns = said[CLIP].places if kind == CLIP and kind in said else None
            made[channel] = Treatment(
                masked=union(runs), baseline=level(_less(health, steps)), span=health.span,
                steps=steps,
                **({"crowned": crowns} if crowns is not None else {}),
            )  # fmt: skip
        return Way(kind=kind, without=without, treatments=made)

    out = [way()]
    for kind in dict.fromkeys(k for said in book.values() for k in said):
        if kind in (HOLE, FREEZE):  # no cycle comes or goes with them, only time
            continue
        of = [said[kind] for said in book.values() if kind in said]
        masked = sum(len(d.masked) for d in of)
        if masked < sum(d.places.count for d in of):
            out.append(way(kind))
        if masked:
            out.append(way(kind, without=False))
    return out


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
        a drift taken off.
    """

    kind: str
    count: int
    samples: int
    share: float
    undecided: int
    recorded: float
    without: float

    @property
    def change(self) -> float:
        """How much more the larger of the two damages is than the smaller, relative."""
        low, high = sorted((self.recorded, self.without))
        return high / low - 1 if low > 0 else (np.inf if high > 0 else 0.0)


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
        Share of the stress's power above 0.4 of the sample rate.
    biaxiality
        Of a rosette, where the stress is high; nan of single gauges.
    measures
        Damage of a rosette by each measure of its stress, where it is sheared.
    """

    live: float
    recorded: float
    effects: tuple[Effect, ...] = ()
    samples_only: float = float("nan")
    fast: float = 0.0
    biaxiality: float = float("nan")
    measures: Mapping[str, float] = field(default_factory=dict[str, float])

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
                e.change > (VETO / 2 if e.kind == CLIP else VETO)
                or (e.kind == CLIP and e.share > CLIPPED)
            )
        ]
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
        return "doubtful" if doubtful or self.sheared or self.fast > FAST else "good"
