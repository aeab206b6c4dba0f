"""The lightest bracket that lives long enough: sizes that may be chosen, tried one by one.

A sheet that is thicker never lives shorter; that is all the search takes for granted. So of
sizes that differ in thickness alone the thinnest that does is found by halving, and a heavier
set is not tried where a lighter one does. Each try hangs the line in its own bracket. A first
mesh tells which are far off; who wins is judged like any bracket, and falls where it must:
where it lives too short, its sheet yields, a recording wears it out, or its bolts slip.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import inf

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.errors import DesignError, NotConverged
from cardan.base.units import Kilogram, Metre, hour, mm
from cardan.base.verdict import Check, Limit, badness
from cardan.bracket.elastic import Progress
from cardan.bracket.elastic import silent as hushed
from cardan.bracket.refine import LEVELS
from cardan.bracket.solve import weighed_apart
from cardan.files.metals import key_of
from cardan.model.application import Application
from cardan.model.bracket import ZONES, Bracket, Search, Shape
from cardan.model.material import Material
from cardan.study.bracket import Bench, BracketAnswer, checks_of
from cardan.study.bracket_judge import Judged, Slip
from cardan.study.bracket_life import strengths
from cardan.study.finding import BRACKET, SLIP, limits_of

DOUBT, LOOSE = 2.0, 4.0
"""Times the most its own error leaves it, a life by the first mesh may be: a U of 6 mm had 832 h by
it, 1,400 at most, and 2,100 by finer ones. And where contact counts, which that mesh leaves out."""


@dataclass(frozen=True, kw_only=True)
class Tried:
    """Sizes that were tried.

    Attributes
    ----------
    sizes
        What is chosen, by name, m.
    life
        Hours over the duty cycle, at the worst place.
    refined
        Whether its mesh was made finer until its maxima stayed.
    slips : Slip
        What asks most of its bolts, where that is more than they may be asked; else None.
    fails : Check
        Where it yields, or a recording wears it out, by most; None where nowhere.
    judged : Judged
        All of it.
    """

    sizes: dict[str, float]
    mass: Kilogram
    life: float
    refined: bool
    judged: Judged
    slips: Slip | None = None
    fails: Check | None = None

    @property
    def holds(self) -> bool:
        """Whether it fails nowhere, however long it lives."""
        return self.slips is None and self.fails is None

    @property
    def at_most(self) -> float:
        """Hours that its error leaves it at most."""
        return float(np.fmax(self.life, self.judged.life_meshed))

    @property
    def at_least(self) -> float:
        """Hours that its error leaves it at least."""
        return float(np.fmin(self.life, self.judged.life_within[0]))


@dataclass(frozen=True, kw_only=True)
class Searched:
    """What a search found.

    Attributes
    ----------
    target
        Hours.
    best : Tried
        The lightest that lives as long, in bolts that hold; None where none does.
    tried
        All that were solved, in order.
    count, refused
        How many sets of sizes there are, and those that make no shape, with the reason.
    """

    target: float
    best: Tried | None
    tried: tuple[Tried, ...]
    count: int
    refused: tuple[tuple[dict[str, float], str], ...]


def lightest(
    masses: Sequence[Sequence[float]], *, does: Callable[[int, int], bool]
) -> tuple[int, int] | None:
    """Return which row and column is the lightest that does; None where none is.

    In each row masses rise, and who does is followed by those who do. `does` is asked of as few
    as that allows, light rows first.
    """
    best, least = None, inf
    for row in sorted(range(len(masses)), key=lambda r: masses[r][0] if masses[r] else inf):
        end = int(np.searchsorted(np.asarray(masses[row]), least))
        if end == 0 or not does(row, end - 1):
            continue
        low, high = -1, end - 1
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (low, middle) if does(row, middle) else (middle, high)
        best, least = (row, high), masses[row][high]
    return best


def search(application: Application, *, tell: Progress = hushed) -> Searched:
    """Search the lightest bracket an application's `optimise` allows.

    Raises
    ------
    DesignError
        If it gives nothing to choose from, no duty cycle or no S-N curve, or no set of sizes
        makes a shape.
    """
    bracket, wanted = _asked(application)
    families, refused = _families(bracket.shape, wanted)
    tell(f"weighing {sum(map(len, families))} shapes")
    masses = weighed_apart([s for row in families for _, s in row], bracket.material)
    rows = _rows(families, masses, refused)
    # Gauges sit on the shape that is installed, and so do strains that they read.
    bare = replace(
        bracket, gauges=(), recordings=tuple(r for r in bracket.recordings if r.strain is None)
    )
    bench = Bench.of(replace(application, bracket=bare))
    limits = limits_of(BRACKET, application)
    slip = [m for m in limits if m.quantity == SLIP]
    tried: list[Tried] = []
    known: dict[tuple[int, int, bool], Tried | None] = {}
    fallen: set[tuple[int, int]] = set()

    def asked(row: int, column: int, *, refined: bool) -> Tried | None:
        """Return a set of sizes, judged; None where it cannot be meshed."""
        key = (row, column, refined)
        if key not in known:
            sizes, shape, mass = rows[row][column]
            known[key] = None
            try:
                judged = bench.judged(
                    shape, name=named(sizes), levels=LEVELS if refined else 1, tell=tell
                )
            except (DesignError, NotConverged) as error:
                refused.append((sizes, str(error)))
                return None
            _yield_known(bracket.material, judged)
            known[key] = one = Tried(
                sizes=sizes, mass=mass, life=judged.life, refined=refined, judged=judged,
                slips=_slips(judged, slip), fails=_fails(bench, judged, limits),
            )  # fmt: skip
            tried.append(one)
        return known[key]

    def does(row: int, column: int) -> bool:
        if any(r == row and column <= c for r, c in fallen):
            return False
        if (row, column, True) in known:
            return True  # it would have fallen
        first = asked(row, column, refined=False)
        return first is not None and first.at_most >= target / (LOOSE if bracket.bolts else DOUBT)

    target = wanted.life / hour
    best: Tried | None = None
    while (at := lightest([[m for *_, m in row] for row in rows], does=does)) is not None:
        one = asked(*at, refined=True)
        if one is not None and one.life >= target and one.holds:
            best = one
            break
        # Whether bolts slip or sheet yields may not go with thickness, but what is thinner was
        # found to live too short, or fell before.
        fallen.add(at)
    return Searched(
        target=target,
        best=best,
        tried=tuple(tried),
        count=int(np.prod([len(v) for v in wanted.sizes.values()])),
        refused=tuple(refused),
    )


def named(sizes: Mapping[str, Metre]) -> str:
    """Return sizes as a name: thickness 5, flange 40 mm."""
    return ", ".join(f"{k.replace('_', ' ')} {v / mm:g}" for k, v in sizes.items()) + " mm"


def _yield_known(material: Material, judged: Judged) -> None:
    """Refuse to choose among shapes of which nobody knows what they yield at beside their welds."""
    welded = any(f.beside_weld for f in judged.features)
    if welded and material.yield_strength and not material.yield_beside_weld:
        msg = (
            f"a bracket to search for needs `welded_yield_MPa` of {material.name}: a weld's heat "
            "makes it softer, and nobody says by how much"
        )
        raise DesignError(msg, about="bracket.material")


def _slips(judged: Judged, limits: Sequence[Limit]) -> Slip | None:
    """Return what asks most of the bolts, where they slip, or come nearer than allowed."""
    worst = max(judged.slips, key=lambda s: s.share, default=None)
    if worst is None or (worst.share <= 1 and all(m.grade(worst.share) != "fail" for m in limits)):
        return None
    return worst


def _fails(bench: Bench, judged: Judged, limits: Sequence[Limit]) -> Check | None:
    """Return where a bracket fails most by yield, or under a recording."""
    of = BracketAnswer(
        title="", bracket=bench.bracket, top_speed=bench.top_speed, variants=(judged,)
    )
    asked = [m for m in limits if m.quantity in ("bracket_stress_utilisation", "bracket_life")]
    found = checks_of(of, judged, asked)
    failed = [c for c in found if c.grade == "fail" and c.when.kind == "case"]
    return min(failed, key=badness, default=None)


def _asked(application: Application) -> tuple[Bracket, Search]:
    bracket = application.bracket
    if bracket is None or bracket.search is None:
        msg = "nothing to choose from: give the bracket `optimise`, with life_h and sizes"
        raise DesignError(msg, about="bracket.optimise")
    if bracket.fatigue is None or not (application.duty or application.duty_cycle):
        missing = "`fatigue` of the bracket" if bracket.fatigue is None else "a `duty` cycle"
        msg = f"a life to search for needs {missing}"
        raise DesignError(msg, about="bracket.optimise")
    if untold := [key_of(zone) for zone in ZONES if zone not in strengths(bracket)]:
        msg = (
            f"a life to search for needs `{untold[0]}` in `fatigue` of the bracket: no code says "
            f"what it is of {bracket.material.name}, {bracket.material.metal}"
        )
        raise DesignError(msg, about="bracket.optimise")
    return bracket, bracket.search


def _families(
    shape: Shape, wanted: Search
) -> tuple[list[list[tuple[dict[str, float], Shape]]], list[tuple[dict[str, float], str]]]:
    """Return the shapes by all sizes but thickness, thin ones first; and what makes none."""
    others = [name for name in wanted.sizes if name != "thickness"]
    thick = sorted(wanted.sizes.get("thickness", ())) or [None]
    rows: list[list[tuple[dict[str, float], Shape]]] = []
    refused: list[tuple[dict[str, float], str]] = []
    for chosen in product(*(wanted.sizes[name] for name in others)):
        row: list[tuple[dict[str, float], Shape]] = []
        for t in thick:
            sizes = dict(zip(others, chosen, strict=True))
            sizes |= {} if t is None else {"thickness": t}
            try:
                row.append((sizes, replace(shape, **sizes)))
            except DesignError as error:
                refused.append((sizes, str(error)))
        rows.append(row)
    return rows, refused


def _rows(
    families: list[list[tuple[dict[str, float], Shape]]],
    masses: FloatArray,
    refused: list[tuple[dict[str, float], str]],
) -> list[list[tuple[dict[str, float], Shape, float]]]:
    """Return the shapes with their masses; those that the CAD kernel cannot build are refused."""
    each = iter(masses.tolist())
    rows: list[list[tuple[dict[str, float], Shape, float]]] = []
    for family in families:
        weighed = [(sizes, shape, next(each)) for sizes, shape in family]
        refused += [(s, "the CAD kernel cannot build it") for s, _, m in weighed if np.isnan(m)]
        rows.append([w for w in weighed if not np.isnan(w[2])])
    if not any(rows):
        said = refused[0][1] if refused else ""
        msg = f"no set of sizes of `optimise` makes a shape: {said}"
        raise DesignError(msg, about="bracket.optimise")
    return rows
