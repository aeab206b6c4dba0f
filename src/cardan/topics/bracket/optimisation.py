"""The lightest bracket that lives long enough: sizes that may be chosen, tried one by one.

A sheet that is thicker never lives shorter; that is all the search takes for granted. So of
sizes that differ in thickness alone the thinnest that does is found by halving, and a heavier
set is not tried where a lighter one does. Each try hangs the line in its own bracket. A first
mesh shows which are far off; the winner is assessed like any bracket, and rejected
if its life is too short, its sheet yields, a recording wears it out, or its bolts slip.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import inf

import numpy as np

from cardan.approval.study import BOLT_SLIP_QUANTITY, BRACKET_STUDY_NAME, limits_of_study
from cardan.core.arrays import FloatArray
from cardan.core.errors import ConvergenceError, DesignError
from cardan.core.status import StatusCallback, ignore_status
from cardan.core.units import Kilogram, Metre, hour, mm
from cardan.core.verdict import Check, Limit, worst_first_key
from cardan.model.application import Application
from cardan.model.bracket import FATIGUE_ZONES, Bracket, OptimisationSpace, Shape
from cardan.model.material import Material
from cardan.physics.fem.adaptive_refinement import MAX_MESHES
from cardan.physics.fem.solve import bracket_masses_in_subprocess
from cardan.topics.bracket.assessment import BracketResult, BracketShapeAssessor, bracket_checks
from cardan.topics.bracket.life import fatigue_strength_by_zone
from cardan.topics.bracket.metal_fatigue_data import zone_curve_key
from cardan.topics.bracket.shape_result import BoltSlipUtilisation, ShapeAssessment

COARSE_MESH_LIFE_ERROR_FACTOR, FIRST_MESH_LIFE_ERROR_FACTOR_WITH_CONTACT = 2.0, 4.0
"""Times the most its own error leaves it, a life by the first mesh may be: a U of 6 mm had 832 h by
it, 1,400 at most, and 2,100 by finer ones. And where contact counts, which that mesh leaves out."""


@dataclass(frozen=True, kw_only=True)
class EvaluatedBracketDimensions:
    """Sizes that were tried.

    Attributes
    ----------
    sizes
        What is chosen, by name, m.
    life
        Hours over the duty cycle, at the worst place.
    refined
        Whether its mesh was made finer until its maxima stayed.
    bolt_slip : BoltSlipUtilisation
        What uses most of its bolts, if that is more than allowed; else None.
    failed_check : Check
        Where it yields, or a recording wears it out, by most; None where nowhere.
    assessment : ShapeAssessment
        All of it.
    """

    sizes: dict[str, float]
    mass: Kilogram
    life: float
    refined: bool
    assessment: ShapeAssessment
    bolt_slip: BoltSlipUtilisation | None = None
    failed_check: Check | None = None

    @property
    def has_no_failure(self) -> bool:
        """Whether it fails nowhere, however long it lives."""
        return self.bolt_slip is None and self.failed_check is None

    @property
    def max_life(self) -> float:
        """Hours that its error leaves it at most."""
        return float(np.fmax(self.life, self.assessment.max_life_hours_by_mesh_error))

    @property
    def min_life(self) -> float:
        """Hours that its error leaves it at least."""
        return float(np.fmin(self.life, self.assessment.life_hours_bounds[0]))


@dataclass(frozen=True, kw_only=True)
class OptimisationResult:
    """What a search found.

    Attributes
    ----------
    target_hours
        Required life, h.
    best : EvaluatedBracketDimensions
        The lightest that lives as long, in bolts that hold; None where none does.
    evaluated
        All that were solved, in order.
    combination_count, rejected
        How many sets of sizes there are, and those that make no shape, with the reason.
    """

    target_hours: float
    best: EvaluatedBracketDimensions | None
    evaluated: tuple[EvaluatedBracketDimensions, ...]
    combination_count: int
    rejected: tuple[tuple[dict[str, float], str], ...]


def lightest_feasible(
    masses: Sequence[Sequence[float]], *, does: Callable[[int, int], bool]
) -> tuple[int, int] | None:
    """Return which row and column is the lightest that does; None where none is.

    In each row masses rise, and all after one that does do too. `does` is called for as few
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


def find_lightest_bracket(
    application: Application, *, tell: StatusCallback = ignore_status
) -> OptimisationResult:
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
    masses = bracket_masses_in_subprocess([s for row in families for _, s in row], bracket.material)
    rows = _rows(families, masses, refused)
    # Gauges sit on the shape that is installed, and so do strains that they read.
    bare = replace(
        bracket, gauges=(), recordings=tuple(r for r in bracket.recordings if r.strain is None)
    )
    bench = BracketShapeAssessor.from_application(replace(application, bracket=bare))
    limits = limits_of_study(BRACKET_STUDY_NAME, application)
    slip = [m for m in limits if m.quantity == BOLT_SLIP_QUANTITY]
    tried: list[EvaluatedBracketDimensions] = []
    known: dict[tuple[int, int, bool], EvaluatedBracketDimensions | None] = {}
    fallen: set[tuple[int, int]] = set()

    def asked(row: int, column: int, *, refined: bool) -> EvaluatedBracketDimensions | None:
        """Return a set of sizes, judged; None where it cannot be meshed."""
        key = (row, column, refined)
        if key not in known:
            sizes, shape, mass = rows[row][column]
            known[key] = None
            try:
                judged = bench.assess(
                    shape, name=sizes_label(sizes), levels=MAX_MESHES if refined else 1, tell=tell
                )
            except (DesignError, ConvergenceError) as error:
                refused.append((sizes, str(error)))
                return None
            _yield_known(bracket.material, judged)
            known[key] = one = EvaluatedBracketDimensions(
                sizes=sizes, mass=mass, life=judged.life_hours, refined=refined, assessment=judged,
                bolt_slip=_slips(judged, slip), failed_check=_fails(bench, judged, limits),
            )  # fmt: skip
            tried.append(one)
        return known[key]

    def does(row: int, column: int) -> bool:
        if any(r == row and column <= c for r, c in fallen):
            return False
        if (row, column, True) in known:
            return True  # it would have fallen
        first = asked(row, column, refined=False)
        return first is not None and first.max_life >= target / (
            FIRST_MESH_LIFE_ERROR_FACTOR_WITH_CONTACT
            if bracket.bolts
            else COARSE_MESH_LIFE_ERROR_FACTOR
        )

    target = wanted.life / hour
    best: EvaluatedBracketDimensions | None = None
    while (at := lightest_feasible([[m for *_, m in row] for row in rows], does=does)) is not None:
        one = asked(*at, refined=True)
        if one is not None and one.life >= target and one.has_no_failure:
            best = one
            break
        # Whether bolts slip or sheet yields may not go with thickness, but what is thinner was
        # found to live too short, or fell before.
        fallen.add(at)
    return OptimisationResult(
        target_hours=target,
        best=best,
        evaluated=tuple(tried),
        combination_count=int(np.prod([len(v) for v in wanted.sizes.values()])),
        rejected=tuple(refused),
    )


def sizes_label(sizes: Mapping[str, Metre]) -> str:
    """Return sizes as a name: thickness 5, flange 40 mm."""
    return ", ".join(f"{k.replace('_', ' ')} {v / mm:g}" for k, v in sizes.items()) + " mm"


def _yield_known(material: Material, judged: ShapeAssessment) -> None:
    """Refuse to choose among shapes whose yield strength next to their welds is unknown."""
    welded = any(f.beside_weld for f in judged.features)
    if welded and material.yield_strength and not material.yield_strength_at_weld:
        msg = (
            f"a bracket to search for needs `welded_yield_MPa` of {material.name}: a weld's heat "
            "makes it softer, by an unknown amount"
        )
        raise DesignError(msg, about="bracket.material")


def _slips(judged: ShapeAssessment, limits: Sequence[Limit]) -> BoltSlipUtilisation | None:
    """Return what uses most of the bolts, where they slip, or come nearer than allowed."""
    worst = max(judged.bolt_slips, key=lambda s: s.utilisation, default=None)
    if worst is None or (
        worst.utilisation <= 1 and all(m.grade(worst.utilisation) != "fail" for m in limits)
    ):
        return None
    return worst


def _fails(
    bench: BracketShapeAssessor, judged: ShapeAssessment, limits: Sequence[Limit]
) -> Check | None:
    """Return where a bracket fails most by yield, or under a recording."""
    of = BracketResult(
        title="", bracket=bench.bracket, top_speed=bench.top_speed, variants=(judged,)
    )
    asked = [m for m in limits if m.quantity in ("bracket_stress_utilisation", "bracket_life")]
    found = bracket_checks(of, judged, asked)
    failed = [c for c in found if c.grade == "fail" and c.when.kind == "case"]
    return min(failed, key=worst_first_key, default=None)


def _asked(application: Application) -> tuple[Bracket, OptimisationSpace]:
    bracket = application.bracket
    if bracket is None or bracket.search is None:
        msg = "nothing to choose from: give the bracket `optimise`, with life_h and sizes"
        raise DesignError(msg, about="bracket.optimise")
    if bracket.fatigue is None or not (application.duty or application.duty_cycle):
        missing = "`fatigue` of the bracket" if bracket.fatigue is None else "a `duty` cycle"
        msg = f"a life to search for needs {missing}"
        raise DesignError(msg, about="bracket.optimise")
    if untold := [
        zone_curve_key(zone)
        for zone in FATIGUE_ZONES
        if zone not in fatigue_strength_by_zone(bracket)
    ]:
        msg = (
            f"a life to search for needs `{untold[0]}` in `fatigue` of the bracket: no code says "
            f"what it is of {bracket.material.name}, {bracket.material.metal}"
        )
        raise DesignError(msg, about="bracket.optimise")
    return bracket, bracket.search


def _families(
    shape: Shape, wanted: OptimisationSpace
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
