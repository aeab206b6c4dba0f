"""A gauge's stress judged otherwise than by its S-N curve: by strain, by a crack, by odds."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.errors import NotConverged
from cardan.base.units import MPa, Pascal, hour
from cardan.fatigue import crack
from cardan.fatigue.damage import InTurn, Life, miner
from cardan.fatigue.life import Plan
from cardan.fatigue.local import Local, Loops, Material
from cardan.fatigue.rainflow import Cycles, ResidueRule, half_cycles, repeating
from cardan.fatigue.reliability import (
    Estimate,
    Form,
    Lognormal,
    Sorm,
    form,
    monte_carlo,
    sorm,
)


class Counted(Protocol):
    """A gauge of a recording or of a mix: its cycles, and what they came to."""

    @property
    def cycles(self) -> Cycles:
        """Closed cycles, and the residue by its rule."""
        ...

    @property
    def life(self) -> Life:
        """Damage and what follows from it."""
        ...


@dataclass(frozen=True)
class Turned:
    """A gauge of a mix whose parts are driven in turn: its cycles then, and what they come to."""

    cycles: Cycles
    life: Life
    order: InTurn


DRAWS = 2000
"""Parts drawn about the likeliest failure."""

BEND = 0.2
"""Standard deviations over which the surface of failure bends: at a knee of the curve every cycle
makes a kink, and one kink is no bend."""


@dataclass(frozen=True, kw_only=True)
class Strained:
    """How a place is judged by its local strain.

    Attributes
    ----------
    material
        Its cyclic and strain-life curves.
    law
        What the mean stress of a loop does, one of `local.LAWS`.
    notch
        K_t from the gauge to the place; None where the gauge felt the place's own strain.
    """

    material: Material
    law: str = "swt"
    notch: float | None = None


@dataclass(frozen=True, kw_only=True)
class Cracked:
    """How a crack is judged: lengths in m, growth C ΔK^m, m a cycle and MPa√m, above a threshold.

    `shape` is Y of K = Y S √(πa).
    """

    start: float
    end: float
    C: float
    m: float
    threshold: float = 0.0
    shape: float = 1.12


@dataclass(frozen=True, kw_only=True)
class Odds:
    """How often parts fail within some hours of service.

    Attributes
    ----------
    hours
        Of service.
    first, second
        By the nearest failure, and by how its surface bends there; None where there is none.
    sampled
        By parts drawn about it.
    """

    hours: float
    first: Form | None
    second: Sorm | None
    sampled: Estimate | None

    @property
    def shares(self) -> dict[str, float]:
        """What scatters, by its share of the doubt (β²)."""
        names = ("strength", "damage at failure", "stress scale")
        return {} if self.first is None else dict(zip(names, self.first.importance, strict=True))


@dataclass(frozen=True, kw_only=True)
class Otherwise:
    """The other answers of one gauge; None of what was not asked.

    Attributes
    ----------
    strain_damage, strain
        Of the recording or mix by strain-life, and the largest local strain amplitude.
    growth
        Passages of the recording or mix that grow the crack; infinite where it stops.
    duration : s
        The gauge was alive, of one passage.
    in_turn
        The same of a mix with its parts driven in turn; None where that says nothing else.
    """

    gauge: str
    duration: float
    allowed: float
    strain_damage: float | None = None
    strain: float = math.nan
    growth: float | None = None
    odds: Odds | None = None
    in_turn: "Otherwise | None" = None

    @property
    def strain_hours(self) -> float:
        """Hours until a crack is there, by strain-life."""
        if self.strain_damage is None or math.isnan(self.strain_damage):
            return math.nan
        if not self.strain_damage > 0:
            return math.inf
        return self.allowed / self.strain_damage * self.duration / hour

    @property
    def crack_hours(self) -> float:
        """Hours in which the crack grows."""
        return math.nan if self.growth is None else self.growth * self.duration / hour


def strained(
    pieces: Callable[[], Iterable[FloatArray]], largest: Sequence[Pascal], of: Strained, *,
    rule: ResidueRule,
) -> list[tuple[float, float]]:  # fmt: skip
    """Return damage and largest local strain amplitude of each gauge of a stress (gauges, n) Pa.

    `pieces` yields it from the beginning at each call; `largest` is how far each goes from zero.
    What no loop closes counts by the rule: as half loops, not at all, or where the route is driven
    again and again what its second passage closes, whose memory is the first's.
    """
    followers = [Local(of.material, largest=size, notch=of.notch) for size in largest]
    damage, strain = np.zeros(len(largest)), np.zeros(len(largest))

    def take(k: int, loops: Loops) -> None:
        damage[k] += loops.damage(of.material, law=of.law)
        strain[k] = max(strain[k], float(loops.amplitude.max(initial=0.0)))

    if rule is repeating:
        for piece in pieces():
            for k, follower in enumerate(followers):
                follower.add(piece[k])
    for piece in pieces():
        for k, follower in enumerate(followers):
            take(k, follower.add(piece[k]))
    for k, follower in enumerate(followers if rule is not repeating else ()):
        take(k, follower.rest(legs=rule is half_cycles))
    return [(float(d), float(s)) for d, s in zip(damage, strain, strict=True)]


def strained_in_turn(of: Strained, order: InTurn) -> tuple[float, float]:
    """Return the damage that an order does beyond its parts by themselves, and the largest strain.

    By local strain, of what the parts left open; loops that closed within one stay as they were.
    """
    largest = max((float(np.abs(left).max(initial=0.0)) for left in order.residues), default=0.0)
    if not largest > 0:
        return 0.0, 0.0

    def damage(stress: FloatArray, rule: ResidueRule) -> tuple[float, float]:
        (found,) = strained(lambda: [stress[None]], [largest], of, rule=rule)
        return found

    whole = [(damage(order.stress(which), repeating), n) for which, n in order.order]
    alone = [
        (damage(left, order.rule), n) for left, n in zip(order.residues, order.times, strict=True)
    ]
    more = sum(d * n for (d, _), n in whole) - sum(d * n for (d, _), n in alone)
    return more, max(strain for (_, strain), _ in whole)


def mixed(
    one: Counted, parts: Sequence[tuple[Otherwise, float]], plan: Plan, *, gauge: str,
    turned: Turned | None, strained: Strained | None, crack: Cracked | None, hours: float | None,
    miner_scatter: float,
) -> Otherwise:  # fmt: skip
    """Return the other answers of a gauge in a mix of recordings, each driven so many times.

    Damage by strain adds up, each recording beginning with a memory of nothing. A crack grows by
    the cycles of all in one, and odds are of those: what has to hold is the mix, and neither is
    a mean of what each recording would come to by itself. The same is told of the mix driven in
    turn, where that is given.
    """

    def judged(of: Counted, damage: float | None, strain: float) -> Otherwise:
        return Otherwise(
            gauge=gauge, duration=of.life.duration, allowed=plan.allowed,
            strain_damage=damage, strain=strain,
            growth=None if crack is None else grown(of, crack),
            odds=None if hours is None else odds(
                of, plan, hours=hours, miner_scatter=miner_scatter
            ),
        )  # fmt: skip

    damage, strain = None, max((p.strain for p, _ in parts), default=math.nan)
    if strained is not None:
        damage = sum(p.strain_damage * n for p, n in parts if p.strain_damage is not None)
    told = judged(one, damage, strain)
    if turned is None:
        return told
    if strained is not None and damage is not None:
        more, largest = strained_in_turn(strained, turned.order)
        damage, strain = damage + more, max(strain, largest)
    return replace(told, in_turn=judged(turned, damage, strain))


def grown(one: Counted, of: Cracked) -> float:
    """Return passages of a recording that grow a crack at a gauge; infinite where it stops."""
    law = partial(crack.paris, C=of.C * MPa**-of.m, m=of.m, threshold=of.threshold * MPa)
    return crack.repeats(
        start=of.start, end=of.end, cycles=one.cycles, law=law,
        shape=partial(crack.constant_shape, Y=of.shape),
    )  # fmt: skip


def odds(one: Counted, plan: Plan, *, hours: float, miner_scatter: float, seed: int = 1) -> Odds:
    """Return how often parts fail at a gauge within some hours of service.

    g = ln(Δ D₀) - ln D(B σ, A): strength A and stress scale B about the plan's, and damage at
    failure Δ about its allowed one D₀ with a coefficient of variation, all lognormal. Sources:
    Wirsching, J. Struct. Eng. 110 (1984); `fatigue.reliability`.
    """
    curve, correction, passages = plan.curve, plan.correction, hours * hour / one.life.duration
    binned = miner(one.cycles, curve=curve, correction=correction)
    exact = one.life.damage / binned if binned > 0 else 1.0

    def limit(x: FloatArray) -> FloatArray:
        each = [
            miner(one.cycles.scaled(float(b)), curve=curve.scaled(float(a)), correction=correction)
            for a, b in zip(x[..., 0].ravel(), x[..., 2].ravel(), strict=True)
        ]
        done = passages * exact * np.reshape(each, x.shape[:-1])
        with np.errstate(divide="ignore"):
            return np.log(plan.allowed * x[..., 1]) - np.log(done)

    deviation = curve.scatter * math.log(10)
    variables = (
        Lognormal(median=1.0, cov=math.sqrt(math.expm1(deviation**2))),
        Lognormal(median=1.0, cov=miner_scatter),
        Lognormal(median=1.0, cov=plan.gauge_error),
    )
    try:
        first = form(limit, variables, tolerance=1e-6)
    except NotConverged:
        return Odds(hours=hours, first=None, second=None, sampled=None)
    try:
        second = sorm(limit, variables, around=first, h=BEND)
    except NotConverged:
        second = None
    # About a failure that is likelier than not few draws would tell of the parts that hold.
    about = first if first.beta > 0 else ()
    sampled = monte_carlo(limit, variables, samples=DRAWS, seed=seed, around=about)
    return Odds(hours=hours, first=first, second=second, sampled=sampled)
