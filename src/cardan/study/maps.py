"""What a line comes to over a field of two moves, and over moves that scatter: batches of cases.

Every case goes through the same response and the same limits as one application does.
"""

from collections.abc import Container, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import sqrt

import numpy as np

from cardan.base.arrays import FloatArray, IntArray
from cardan.base.verdict import Limit
from cardan.model.application import Adjustable
from cardan.model.movable import MOVABLES
from cardan.quantity.quantities import ANSWERED
from cardan.quantity.response import Response
from cardan.study.driveline import asked
from cardan.study.moves import tried

PLENTY = 10.0
"""A margin where nothing is asked: more than any that counts."""

SURE = 1.96
"""Standard deviations to either side that hold 95 % of a normal distribution."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Outcomes:
    """What limits come to in each of V cases, where each is worst.

    Attributes
    ----------
    limits : L
        Those that got an answer in some case.
    grades : (L, V)
        0 pass, 1 warn, 2 fail.
    margins : (L, V)
        The smallest, to the bound that decides.
    """

    limits: tuple[Limit, ...]
    grades: IntArray
    margins: FloatArray

    @property
    def grade(self) -> IntArray:
        """The worst of all limits, (V,)."""
        return self.grades.max(axis=0, initial=0)

    @cached_property
    def decides(self) -> IntArray:
        """Which limit is the worst, (V,): the worst grade first, then the smallest margin."""
        return (np.minimum(self.margins, 0.99 * PLENTY) - PLENTY * self.grades).argmin(axis=0)

    @property
    def margin(self) -> FloatArray:
        """The margin of that limit, (V,)."""
        return np.take_along_axis(self.margins, self.decides[None], axis=0)[0]

    def beside(self, other: "Outcomes") -> "Outcomes":
        """Return these cases with further limits."""
        return Outcomes(
            limits=(*self.limits, *other.limits),
            grades=np.concatenate([self.grades, other.grades]),
            margins=np.concatenate([self.margins, other.margins]),
        )


def outcomes(
    response: Response,
    movable: tuple[Adjustable, ...],
    amounts: FloatArray,
    *,
    quantities: Container[str] = ANSWERED,
) -> Outcomes:
    """Return what a line comes to with things moved by amounts (V, movable), SI."""
    count = len(amounts)
    limits: list[Limit] = []
    grades: list[IntArray] = []
    margins: list[FloatArray] = []
    for q in asked(tried(response, movable, amounts), quantities=quantities):
        # What nothing moved changes has no axis of cases: it is the same in all of them.
        values = np.broadcast_to(q.values, (count, *q.values.shape[-2:])).reshape(count, -1)
        known = ~np.isnan(values)
        if not known.any():
            continue
        limits.append(q.limit)
        grades.append(np.where(known, q.limit.grades(values), 0).max(axis=-1))
        least = np.where(known, q.limit.margins(values), PLENTY).min(axis=-1)
        margins.append(np.minimum(least, PLENTY))
    return Outcomes(
        limits=tuple(limits),
        grades=np.array(grades, dtype=int).reshape(len(limits), count),
        margins=np.array(margins).reshape(len(limits), count),
    )


def field(across: Adjustable, up: Adjustable, count: int) -> FloatArray:
    """Return the moves (count², 2) of a field: the first from its low to its high end fastest."""
    x, y = (np.linspace(a.low, a.high, count) for a in (across, up))
    return np.stack(np.broadcast_arrays(x[None], y[:, None]), axis=-1).reshape(-1, 2)


def scattered(sigmas: Sequence[float], *, count: int, seed: int) -> FloatArray:
    """Return moves (count, movable) that scatter normally about 0, each by its own sigma.

    Sobol points, scrambled after Owen (1998), anew by each seed.
    """
    from scipy.special import ndtri
    from scipy.stats.qmc import Sobol  # slow to import: only a yield waits for it

    points = Sobol(len(sigmas), rng=np.random.default_rng(seed))
    unit = np.clip(points.random_base2(int(count - 1).bit_length())[:count], 2.0**-32, 1 - 2.0**-32)
    return ndtri(unit) * np.asarray(sigmas)


def share(of: int, count: int) -> tuple[float, float, float]:
    """Return the share of cases, and between which shares it lies with 95 %.

    Source: Wilson, Probable inference, the law of succession, and statistical inference (1927).
    """
    p, z = of / count, SURE
    middle = (p + z * z / (2 * count)) / (1 + z * z / count)
    wide = z / (1 + z * z / count) * sqrt(p * (1 - p) / count + z * z / (4 * count * count))
    return p, max(middle - wide, 0.0), min(middle + wide, 1.0)


def movables(response: Response) -> tuple[Adjustable, ...]:
    """Return everything that can be moved in a line: as far as its file allows, or by practice."""
    name = response.line.name
    said = {(a.what, a.part): a for a in response.application.adjustables if a.line == name}
    return tuple(
        said.get((m.key, k))
        or Adjustable(what=m.key, part=k, low=m.reach[0], high=m.reach[1], line=name)
        for m in MOVABLES.values()
        for k in range(1, m.count(response.line) + 1)
    )
