"""What of a correction survives in trucks as they are built: settings and parts scatter.

A truck keeps what a setting promises where nothing fails in it that does not fail at the
setting itself.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cardan.base.arrays import BoolArray, FloatArray
from cardan.base.errors import BadFile, DesignError
from cardan.base.frozen import dataclass
from cardan.base.verdict import EQUAL, Limit
from cardan.demand.states import demand, resolve
from cardan.model.application import Adjustable, Application
from cardan.model.movable import MOVABLES, movable
from cardan.model.variants import Spread, Variants
from cardan.quantity.response import Response, respond
from cardan.study.draw import Drawing, drawing
from cardan.study.margins import PLENTY, Bound, both, limits
from cardan.study.moves import UNMEASURED, tried, turned
from cardan.study.sweep import CHUNK, names, with_numbers

ASSUMED = {"bearing_height_mm": 3.0, "bearing_side_mm": 3.0, "shim_deg": 0.5, "phase_deg": 2.0}
"""How far settings are off at three standard deviations where no file says. House practice,
assumed."""

DRAWS = 4096
"""Trucks that a share is of: it is off by 0.8 % at most, at one standard error."""

REACH = 1.5
"""Standard deviations (of a uniform one, quarters of its half width, times 2) to each side at
which margins are asked: between them and a little beyond they go like parabolas."""


CLASSES = 20
"""Settings that as many trucks survive, to a twentieth, are ranked by what they cost."""


@dataclass(frozen=True, kw_only=True)
class Survival:
    """How many trucks keep what a setting promises.

    Attributes
    ----------
    share : 1
        Of all trucks: what nothing fails in that does not fail at the setting.
    quiet : 1
        Of all trucks: what nothing warns in either that does not at the setting.
    asked
        Whether every truck was asked; otherwise their margins follow from slopes and bends
        at the setting.
    tighter
        The tolerance that wins most, the share with it half as wide; None where none does.
    lost
        The quantity whose limit fails most often; "" where none does.
    """

    share: float
    quiet: float
    asked: bool
    tighter: tuple[str, float] | None = None
    lost: str = ""

    @property
    def sure(self) -> int:
        """Which class of settings it is in: those that as many trucks keep, to a twentieth."""
        return min(int(self.share * CLASSES + 1e-9), CLASSES - 1)


@dataclass(frozen=True, kw_only=True)
class Trucks:
    """How trucks of an application scatter about a setting of one of its lines.

    `assumed` tells whether nobody said so.
    """

    application: Application
    line: str
    drawing: Drawing
    assumed: bool

    @classmethod
    def of(cls, application: Application, line: str) -> "Trucks | None":
        """Return how the trucks scatter: as the file's study says, or as assumed.

        None where nothing does that would move this line.
        """
        said = application.variants.tolerances if application.variants else {}
        own = _own(application, line, said)
        spread = own or dict(_assumed(application, line))
        if not spread:
            return None
        correlated = application.variants.correlated if own and application.variants else ()
        known = names(application) if own else dict.fromkeys(spread, 0.0)
        return cls(
            application=application,
            line=line,
            drawing=drawing(
                Variants(tolerances=spread, correlated=correlated), known, seed=1, points="random"
            ),
            assumed=not own,
        )

    @property
    def of_moves(self) -> bool:
        """Whether all that scatters are things a workshop moves, and no number of the file."""
        every = movable(i.line for i in self.application.lines)
        return all(name in every for name, _ in self.tolerances)

    @property
    def tolerances(self) -> tuple[tuple[str, Spread], ...]:
        """What scatters, and how."""
        return tuple((self.drawing.called(f), f.spread) for f in self.drawing.factors)

    def responses(
        self, ways: tuple[Adjustable, ...], amounts: FloatArray, off: FloatArray
    ) -> tuple[Response, ...]:
        """Return the line at a setting (ways) in trucks that are `off` (V, tolerances).

        And the lines that the ways turn with it.
        """
        every = movable(i.line for i in self.application.lines)
        called = self.drawing.names
        alone = off[0] if len(off) == 1 else off.T  # a number that arrays cannot hold, by itself
        numbers: dict[str, Any] = {
            n: self.drawing.at[k] + alone[k] for k, n in enumerate(called) if n not in every
        }
        changed = with_numbers(self.application, numbers)
        installed = next(i for i in changed.lines if i.line.name == self.line)
        moves = [k for k, n in enumerate(called) if n in every]
        parts = (*ways, *(every[called[k]] for k in moves))
        worth = np.array([MOVABLES[every[called[k]].what].worth for k in moves])
        set_ = np.broadcast_to(amounts, (len(off), len(ways)))
        both = np.concatenate([set_, off[:, moves] * worth], axis=1)
        merged = _merged(parts, both)
        lines = turned(respond(changed, demand(resolve(changed, installed))), ways)
        return tuple(tried(line, *merged) for line in lines)

    def left(
        self, ways: tuple[Adjustable, ...], amounts: FloatArray, off: FloatArray
    ) -> dict[Bound, FloatArray]:
        """Return the margins (V, M) to either bound of trucks (V, tolerances) at a setting.

        One by one where arrays cannot hold what scatters, as a joint's rating. A truck that
        cannot exist has none.
        """
        try:
            found = both(*self.responses(ways, amounts, off))
        except (BadFile, DesignError):
            if len(off) == 1:
                raise
        else:
            return {to: np.broadcast_to(m, (len(off), m.shape[-1])) for to, m in found.items()}
        lost: dict[Bound, FloatArray] = {
            to: np.full_like(m, -PLENTY)
            for to, m in self.left(ways, amounts, np.zeros_like(off[:1])).items()
        }
        some: list[dict[Bound, FloatArray]] = []
        for row in off:
            try:
                some.append(self.left(ways, amounts, row[None]))
            except (BadFile, DesignError):
                some.append(lost)
        return {to: np.concatenate([m[to] for m in some]) for to in lost}

    def survival(
        self, ways: tuple[Adjustable, ...], amounts: FloatArray, *, asked: int = 0
    ) -> Survival:
        """Return how many trucks keep what a setting promises.

        Parameters
        ----------
        ways, amounts
            The setting: what is moved, and by how much (ways) SI.
        asked
            How many trucks are asked each by itself; 0 takes margins as parabolas of what
            scatters, and 4096 of them.
        """
        still = np.zeros((1, len(self.drawing.names)))
        each = limits(*self.responses(ways, amounts, still))
        promised = self.left(ways, amounts, still)
        held = (promised["maximum"][0] >= -EQUAL) & [m.maximum is not None for m in each]
        calm = (promised["normal"][0] >= -EQUAL) & [m.warns for m in each]
        if asked:
            off = self.drawing.values(0, asked) - np.array(self.drawing.at)
            some = [self.left(ways, amounts, off[k : k + CHUNK]) for k in range(0, asked, CHUNK)]
            left, near = (np.concatenate([m[to] for m in some]) for to in ("maximum", "normal"))
            kept = _kept(left, held)
            return Survival(
                share=float(kept.mean()),
                quiet=float((kept & _kept(near, calm)).mean()),
                asked=True,
                lost=_lost(each, left, held),
            )
        parabolas = self._parabolas(ways, amounts)
        off = self._normal(self.drawing.unit(0, DRAWS))
        left = parabolas["maximum"](off)
        kept = _kept(left, held)
        halved = {}
        for k, factor in enumerate(self.drawing.factors):
            half = off.copy()
            half[:, k] /= 2
            halved[self.drawing.called(factor)] = float(
                _kept(parabolas["maximum"](half), held).mean()
            )
        best = max(halved, key=halved.__getitem__)
        share = float(kept.mean())
        return Survival(
            share=share,
            quiet=float((kept & _kept(parabolas["normal"](off), calm)).mean()),
            asked=False,
            tighter=(best, halved[best]) if halved[best] > share + 0.005 else None,
            lost=_lost(each, left, held),
        )

    def scatter(self, ways: tuple[Adjustable, ...], amounts: FloatArray, *, to: Any) -> FloatArray:
        """Return the standard deviation of each margin at a setting, from its slopes."""
        wide = self._wide
        each = np.concatenate([np.diag(wide), -np.diag(wide)]) * REACH
        found = self.left(ways, amounts, each)[to]
        forth, back = np.split(found, 2)
        return np.sqrt((((forth - back) / (2 * REACH)) ** 2).sum(0))

    def _parabolas(
        self, ways: tuple[Adjustable, ...], amounts: FloatArray
    ) -> dict[Bound, Callable[[FloatArray], FloatArray]]:
        """Return margins (V, M) to either bound of trucks so many deviations (V, T) off."""
        step = np.diag(self._wide) * REACH
        off = np.concatenate([np.zeros((1, len(step))), step, -step])
        found = self.left(ways, amounts, off)
        return {to: _parabola(m) for to, m in found.items()}

    def _normal(self, unit: FloatArray) -> FloatArray:
        """Return how far trucks are off in each tolerance, in its standard deviations."""
        return (self.drawing.of(unit) - np.array(self.drawing.at)) / self._wide

    @property
    def _wide(self) -> FloatArray:
        """Standard deviation of each tolerance, in the unit of its name."""
        return np.array([
            s.values[0] / (np.sqrt(3.0) if s.kind == "uniform" else 1.0) for _, s in self.tolerances
        ])  # fmt: skip


def _own(application: Application, line: str, said: Mapping[str, Spread]) -> dict[str, Spread]:
    """Return the tolerances of a file that are of this line: its moves, and any number."""
    from cardan.model.movable import meant

    if not said:
        return {}
    every, known = movable(i.line for i in application.lines), names(application)
    each = {n: s for name, s in said.items() for n in meant(name, known)}
    return {n: s for n, s in each.items() if n not in every or every[n].line == line}


def _assumed(application: Application, line: str) -> Iterator[tuple[str, Spread]]:
    measured = {i.line.name: i.line.measured for i in application.lines}
    for name, a in movable(i.line for i in application.lines).items():
        if not measured[a.line] and a.what not in UNMEASURED:
            continue
        kind = f"{a.what}_{MOVABLES[a.what].unit}"
        if a.line == line and kind in ASSUMED:
            yield name, Spread(kind="normal", values=(ASSUMED[kind] / 3,))


def _merged(
    parts: tuple[Adjustable, ...], amounts: FloatArray
) -> tuple[tuple[Adjustable, ...], FloatArray]:
    """Return things that are moved, each once, with what they are moved by in all."""
    if not parts:  # numbers of the file scatter alone, and nothing is moved
        return parts, amounts
    keys = [(a.what, a.part) for a in parts]
    first = {key: keys.index(key) for key in keys}
    sums = np.stack(
        [amounts[:, [k for k, other in enumerate(keys) if other == key]].sum(-1) for key in first],
        axis=-1,
    )
    return tuple(replace(parts[k]) for k in first.values()), sums


def _parabola(found: FloatArray) -> Callable[[FloatArray], FloatArray]:
    """Return margins (V, M) as a function of (V, T), from those in the middle and beside it."""
    # A limit that asks in some of these trucks alone has no slope: it counts where worst.
    jumps = (found == PLENTY).any(0) & (found < PLENTY).any(0)
    found = np.where(jumps, found.min(0), found)
    middle, forth, back = found[:1], *np.split(found[1:], 2)
    slope = (forth - back) / (2 * REACH)
    bend = (forth + back - 2 * middle) / (2 * REACH**2)

    def left(off: FloatArray) -> FloatArray:
        return middle + off @ slope + off**2 @ bend

    return left


def _kept(left: FloatArray, held: BoolArray) -> BoolArray:
    """Return in which trucks (V,) every margin that is held stays."""
    return np.asarray((left[:, held] >= -EQUAL).all(-1), bool)


def _lost(of: Sequence[Limit], left: FloatArray, held: BoolArray) -> str:
    """Return the quantity that most trucks fail of what was held."""
    bad = ((left < -EQUAL) & held).mean(0)
    return of[int(bad.argmax())].quantity if bad.any() else ""
