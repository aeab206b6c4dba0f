"""Solve, search, refine where it is worst, and search afresh, until the maxima stay.

A maximum converges where the mesh does, not where the first mesh put it. So each mesh is
searched anew, feature by feature: each bend, edge, hole and toe. Where a feature is among
the worst and its elements disagree, the next mesh is finer.
"""

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from cardan.core.arrays import ArrayLike, BoolArray, FloatArray, IntArray
from cardan.core.status import StatusCallback, ignore_status
from cardan.core.units import Metre
from cardan.model.bracket import FATIGUE_ZONES
from cardan.model.material import Material
from cardan.physics.fem.elasticity import ElasticSolid, assemble_elastic_solid
from cardan.physics.fem.fatigue_zones import (
    NEAR_REFERENCE_POINT_RATIO,
    ZONE_WELD_TOE,
    FatigueZones,
    find_fatigue_zones,
)
from cardan.physics.fem.meshing import MeshNodes, mesh
from cardan.physics.fem.pollution_error import pollution_error
from cardan.physics.fem.stress import subsample_load_history, superpose, von_mises
from cardan.physics.fem.surface import SurfaceProjection, project_to_surface

MAX_MESHES = 4
"""Meshes at most."""
_TOLD = 0.03
"""Elements may disagree by this share of the stress before they are made smaller."""
_STILL = 0.03
"""A maximum that moved by less from one mesh to the next has settled."""
_HIGH, _AMONG = 0.8, 0.7
"""What is refined: within a feature above this share of its top, in features above this of all."""
_PLAIN = 0.9
"""Share of the highest plain stress above which a feature is among the worst too: fatigue may have
the worst elsewhere, and yield needs where stress itself is highest."""
ASSUMED_STRESS_ERROR_SHARE_UNREFINED, _ANYWHERE = 0.25, 0.02
"""Share of its stress by which a feature may be off that was not looked at twice, and share of the
highest of all by which any may be: of a hundred such on five brackets one in fourteen was."""
_ALONG = 0.6
"""Along a toe the same: coarse elements hide the worst of its places."""
_READ = 0.5
"""Of the way from a toe to where its stress is read, an element there: as long as that way, the
toe of a sharp end read 110 MPa where halves, thirds and fifths read 77."""
_LONG, _SHORT = 1.5, 0.6
"""Ways to where structural stress is read that elements there may be long; and what it may be short
of by each way more. Where a clamped plane ends round a bend, elements 1.2 and 1.4 thicknesses long
read 1 / 1.8 and 1 / 2.2 of what is there, those of 0.6 mostly within a tenth."""
_MOMENTS = 24
"""Of a history, by which loads are compared."""
_TWICE = 2
"""Meshes in which the tops are made finer whatever elements say: two steps show a trend."""
_GREW = 1.1
"""Times as many unknowns as the mesh before, below which the next would be such another: what still
moves is where its nodes came to lie."""
_HIGHER = 1.05
"""Times a sliding flange's top, above which a feature is followed as the clamped one makes it."""
_HALF, _TOP = 0.55, 0.95
"""How much finer a top is looked at a second time; what counts as the top of a feature."""
_GOALS = 8
"""Features, the worst, for which the loss by coarse elements elsewhere is computed."""
_MOST_OF = 0.7
"""Share of what they take that is made finer at once."""
_LOADS = 8
"""Loads, the most relevant, under which the mesh is made; the last solves every load."""


@dataclass(frozen=True, kw_only=True)
class ElasticityProblem:
    """An elastic solid, how it is held, and the loads it is solved under.

    Attributes
    ----------
    shape
        Of the CAD kernel, in metres.
    fixed_faces, fixed_edges
        Names of faces and edges, with the axes they may not move along.
    alternative_fixed_faces
        The faces of a second way to be held, whose maxima are followed where they are the worse
        ones; none where there is no such way.
    clamp_faces
        Those of the held faces whose border a real clamp has, and no plane of symmetry.
    loads
        From the assembled solid to its load vectors (c, unknowns).
    element_size
        Largest edge of an element of the first mesh.
    always_solved_loads
        Which of the loads are solved for on each mesh, whatever cases have of them; what none has
        is solved on the last mesh alone.
    """

    shape: Any
    material: Material
    fixed_faces: Mapping[str, str]
    loads: Callable[[ElasticSolid], FloatArray]
    element_size: Metre
    thickness: Metre
    clamp_faces: tuple[str, ...] = ()
    alternative_fixed_faces: Mapping[str, str] = field(default_factory=dict[str, str])
    fixed_edges: Mapping[str, str] = field(default_factory=dict[str, str])
    degree: int = 2
    grading: float = 0.5
    always_solved_loads: tuple[int, ...] = ()


@dataclass(frozen=True)
class MeshSolution:
    """A problem solved on one mesh.

    Attributes
    ----------
    displacements : (c, unknowns)
        Zero for loads not solved yet, and so is their stress.
    stress : (n, c, 6) Pa
        At the nodes.
    unit_stress : (places, c, 6) Pa
        Stress at the places where fatigue is evaluated.
    """

    elastic: ElasticSolid
    loads: FloatArray
    displacements: FloatArray
    stress: FloatArray
    zones: FatigueZones
    unit_stress: FloatArray

    def with_loads_solved(self, some: BoolArray) -> "MeshSolution":
        """Return it solved for some more of its loads (c,)."""
        moved, stress = self.displacements.copy(), self.stress.copy()
        moved[some] = self.elastic.solve(self.loads[some])
        stress[:, some] = self.elastic.stress_at_nodes(moved[some])
        unit_stress = self.zones.stress(self.elastic.nodes, stress)
        return replace(self, displacements=moved, stress=stress, unit_stress=unit_stress)

    def without_factorisation(self) -> "MeshSolution":
        """Return it without the factors of its solid."""
        return replace(self, elastic=self.elastic.without_factorisation())


FeatureKey: TypeAlias = tuple[int, int]
StressMaximaByFeature: TypeAlias = dict[FeatureKey, FloatArray]
"""Highest von Mises stress (loads,) Pa of each feature."""


@dataclass(frozen=True)
class AdaptiveSolution:
    """The last of a row of solutions, and how far the maxima still are from settled.

    Attributes
    ----------
    final_solution, alternative_solution
        On the last mesh; held the second way where the problem has one.
    error
        Share of the highest stress of each feature that its error may be, held either way.
    stress_maxima
        Highest von Mises stress (loads,) Pa of each feature, on each mesh, of both ways the worse.
    watched_stress : (w, c, 6) Pa
        Stress at the points that were watched.
    watched_error : (w,) 1
        Share of the stress there that its error may be.
    """

    final_solution: MeshSolution
    alternative_solution: MeshSolution | None
    error: dict[FeatureKey, float]
    stress_maxima: tuple[StressMaximaByFeature, ...]
    watched_stress: FloatArray
    watched_error: FloatArray


def solve_on_mesh(
    problem: ElasticityProblem,
    made: Any,
    *,
    some: BoolArray | None = None,
    tell: StatusCallback = ignore_status,
) -> MeshSolution:
    """Solve a problem on a mesh, under all of its loads or some (c,)."""
    body = assemble_elastic_solid(
        made, problem.material, held=problem.fixed_faces, held_edges=problem.fixed_edges,
        degree=problem.degree, tell=tell,
    )  # fmt: skip
    return _under(problem, body, problem.loads(body), some, tell=tell)


def solve_with_second_constraints(
    problem: ElasticityProblem,
    before: MeshSolution,
    *,
    some: BoolArray | None = None,
    tell: StatusCallback = ignore_status,
) -> MeshSolution:
    """Solve a problem held its second way on the mesh of its first."""
    tell("the flange clamped")
    firm = replace(
        problem,
        fixed_faces=problem.alternative_fixed_faces,
        clamp_faces=tuple(problem.alternative_fixed_faces),
    )
    body = before.elastic.with_constraints(firm.fixed_faces, tell=tell)
    return _under(firm, body, before.loads, some, tell=tell)


def _under(
    problem: ElasticityProblem,
    body: ElasticSolid,
    loads: FloatArray,
    some: BoolArray | None,
    *,
    tell: StatusCallback,
) -> MeshSolution:
    """Solve for some of the load vectors (c, unknowns), and read stress at places of fatigue."""
    some = np.ones(len(loads), dtype=bool) if some is None else some
    tell(f"solving for {np.count_nonzero(some)} loads")
    zones = find_fatigue_zones(body.nodes, held=problem.clamp_faces, thickness=problem.thickness)
    nil = np.zeros((len(body.nodes.points), len(loads), 6))
    return MeshSolution(body, loads, np.zeros_like(loads), nil, zones, nil[:0]).with_loads_solved(
        some
    )


def solve_adaptively(
    problem: ElasticityProblem,
    *,
    cases: Sequence[ArrayLike],
    weights: Sequence[float] = (1.0,) * len(FATIGUE_ZONES),
    watch: ArrayLike = (),
    finer: Sequence[tuple[ArrayLike, Metre]] = (),
    most: int = 400_000,
    levels: int = MAX_MESHES,
    tell: StatusCallback = ignore_status,
    seen: Callable[[MeshSolution], None] | None = None,
) -> AdaptiveSolution:
    """Solve on finer and finer meshes until no feature's highest stress moves any more.

    Parameters
    ----------
    cases : ((t, c), ...)
        Load histories, in the loads of the problem, under which maxima are sought.
    weights
        How much a stress weighs in each of `FATIGUE_ZONES`: a toe bears less than a sheet.
    watch : (w, 3) m
        Points whose own stress must settle too.
    finer
        Points with the edge wanted there from the start.
    most
        Unknowns; a mesh that would have more is not made.
    levels
        Meshes at most.
    seen
        Is shown the solution of each mesh.
    """
    points = np.asarray(watch, dtype=float).reshape(-1, 3)
    wanted = list(finer)
    looks: list[_MeshSearchResult] = []
    combos: FloatArray = np.zeros((0, 0))
    weight = np.asarray(weights, dtype=float)
    both, follow = bool(problem.alternative_fixed_faces), True
    some = np.any([np.any(np.reshape(c, (-1, np.shape(c)[-1])), axis=0) for c in cases], axis=0)
    some[list(problem.always_solved_loads)] = True
    ways: list[MeshSolution] = []
    sizes: list[int] = []
    for level in range(levels):
        tell("meshing" if level == 0 else f"mesh {level + 1}, finer where it is worst")
        made = mesh(
            problem.shape, size=problem.element_size, degree=problem.degree, finer=wanted,
            grading=problem.grading,
        )  # fmt: skip
        if ways and ways[0].elastic.unknowns * made.ne > most * ways[0].elastic.mesh.ne:
            break
        ways.clear()  # nothing else holds on to them: their factors go before the next are made
        ways.append(solve_on_mesh(problem, made, some=some, tell=tell))
        sizes.append(ways[0].elastic.unknowns)
        if level == 0:
            combos = select_loads_of_highest_stress(ways[0].unit_stress, cases)
        if seen:
            seen(ways[0])
        if both and follow:
            ways.append(solve_with_second_constraints(problem, ways[0], some=some, tell=tell))
        tell("errors from afar")
        looks.append(_look(problem, ways, combos, weight, points, before=looks))
        if both and level == 0:
            follow = looks[0].firm_matters
        if not looks[-1].finer or (level >= _TWICE and sizes[-1] < _GREW * sizes[-2]):
            break
        if (
            level >= _TWICE
            and _settled(looks, weight)
            and (not len(points) or looks[-1].moved.max() <= _STILL)
        ):
            break
        wanted += map(_rounded, looks[-1].finer)
    if not some.all():
        tell(f"solving for {np.count_nonzero(~some)} loads that no case has")
        ways = [way.with_loads_solved(~some) for way in ways]
    drawn = project_to_surface(ways[0].elastic.nodes, points)
    tops, watched = [look.tops for look in looks], [look.watched for look in looks]
    error = _of_features(tops, looks[-1].off, weight)
    if both and len(ways) == 1:
        ways.append(solve_with_second_constraints(problem, ways[0], tell=tell))
        short = _Field.of(ways[1], combos, problem.thickness).short
        error |= {
            f: max(share, error.get(f, ASSUMED_STRESS_ERROR_SHARE_UNREFINED))
            for f, share in short.items()
        }
    return AdaptiveSolution(
        final_solution=ways[0],
        alternative_solution=ways[1] if both else None,
        error=error,
        stress_maxima=tuple(tops),
        watched_stress=drawn.interpolate(ways[0].elastic.nodes, ways[0].stress),
        watched_error=_share(np.maximum(_drift(watched), looks[-1].off_watched), watched),
    )


@dataclass(frozen=True, kw_only=True)
class _MeshSearchResult:
    """What is kept of a mesh that was searched, when the next is made.

    Attributes
    ----------
    tops, may_be, off
        Highest von Mises stress (k,) Pa of each feature, what it may be as far as elements are too
        large to read it, and what its error may be.
    watched, off_watched, moved : (w, k) Pa, (w, k) Pa, (w,) 1
        The same of the points that are watched, and how far they moved.
    firm_matters
        Whether one of the worst is higher than it is with the flange sliding.
    finer
        Points at which the next mesh is to be finer, with the edge wanted there.
    """

    tops: StressMaximaByFeature
    may_be: StressMaximaByFeature
    off: StressMaximaByFeature
    watched: FloatArray
    off_watched: FloatArray
    moved: FloatArray
    firm_matters: bool
    finer: list[tuple[ArrayLike, Metre]]


def _look(
    problem: ElasticityProblem,
    ways: Sequence[MeshSolution],
    combos: FloatArray,
    weight: FloatArray,
    points: FloatArray,
    *,
    before: Sequence[_MeshSearchResult],
) -> _MeshSearchResult:
    """Search a mesh, held in one or two ways, under loads (k, c)."""
    first = len(before) < _TWICE
    fields = [_Field.of(way, combos, problem.thickness) for way in ways]
    of_ways, could = [f.tops for f in fields], [f.may_be for f in fields]
    tops, may_be = _worse(of_ways, of_ways), _worse(could, could)
    nodes = ways[0].elastic.nodes
    drawn = project_to_surface(nodes, points)
    watched = drawn.interpolate(nodes, von_mises(fields[0].smooth))
    # Of the face round it: at a corner that one element has to itself nothing disagrees.
    faces = nodes.faces[drawn.faces]
    rough = fields[0].scatter(np.unique(faces))[faces].max(axis=1)
    moved = np.full(len(watched), np.inf) if first else _moved(before[-1].watched, watched)
    goals = [_goals(k, fields, tops, weight) for k in range(len(ways))]
    goals[0] += _watched(nodes, drawn, watched)
    offs, off_watched = [f.told_by_elements() for f in fields], rough / 2
    finer: list[tuple[ArrayLike, Metre]] = []
    for field_, asked, into in zip(fields, goals, offs, strict=True):
        afar = field_.from_afar(asked)
        for g, taken in zip(asked, afar.sum(axis=1).tolist(), strict=True):
            if g.feature is None:
                off_watched[g.watched, g.load] = max(off_watched[g.watched, g.load], taken)
            else:
                into[g.feature][g.load] = max(into[g.feature][g.load], taken)
        finer += _worst_places(field_, tops, may_be, weight, problem.thickness, first=first)
        finer += _taking(field_.found, asked, afar)
    finer += _round(ways[0], drawn.points, watched, rough, moved=moved)
    off = {f: np.maximum(o, may_be[f] - tops[f]) for f, o in _worse(of_ways, offs).items()}
    return _MeshSearchResult(
        tops=tops, may_be=may_be, off=off, watched=watched, off_watched=off_watched, moved=moved,
        firm_matters=_firm_matters(fields[0].may_be, tops, may_be, weight), finer=finer,
    )  # fmt: skip


def _rounded(wanted: tuple[ArrayLike, Metre]) -> tuple[FloatArray, Metre]:
    """Return a point with the edge wanted there, to a nanometre and a thousandth.

    Threads add up in an order of their own, and the mesher lays another mesh for another last
    digit: the same bracket is to get the same result.
    """
    point, edge = np.asarray(wanted[0], dtype=float), wanted[1]
    return point.round(9), float(f"{edge:.3g}")


def select_loads_of_highest_stress(
    unit: FloatArray, cases: Sequence[ArrayLike], *, count: int = _LOADS
) -> FloatArray:
    """Return loads (k, c) that stress a surface most, each in a way of its own.

    Of each case the moment of its highest stress; then, from the highest down and as long as
    there is room, those that are not nearly in proportion to one before.
    """
    step = max(1, len(unit) // 3000)
    searched = unit[::step]
    loads: list[FloatArray] = []
    high: list[float] = []
    for case in cases:
        history = subsample_load_history(np.reshape(case, (-1, unit.shape[1])), _MOMENTS)
        level = von_mises(superpose(searched, history))
        at = int(level.max(axis=0).argmax())
        loads.append(history[at])
        high.append(float(level[:, at].max()))
    kept: list[int] = []
    fields = [superpose(searched, load[None])[:, 0].ravel() for load in loads]
    for k in np.argsort(high)[::-1].tolist():
        if high[k] <= 0 or len(kept) == count:
            continue
        size = np.linalg.norm(fields[k])
        alike = (abs(fields[k] @ fields[j]) / size / np.linalg.norm(fields[j]) for j in kept)
        if all(a < 0.97 for a in alike):
            kept.append(k)
    # Each counts for itself: scaled to the same highest stress, a small one is not forgotten.
    return np.stack([loads[k] / high[k] for k in kept]) * max(high)


@dataclass(frozen=True)
class _Field:
    """What the most relevant loads do to a solid held one way, on one mesh.

    Attributes
    ----------
    moved_by : (k, unknowns)
    smooth : (n, k, 6) Pa
        Stress at the nodes.
    level : (places, k) Pa
        Von Mises stress where fatigue is evaluated.
    edge : (places,) m
        Of the elements it is read from.
    could : (places, k) Pa
        What it may be, as far as those are too large to read it.
    tops, where, may_be
        The highest of each feature, at which place, and what it may be.
    """

    found: MeshSolution
    moved_by: FloatArray
    smooth: FloatArray
    level: FloatArray
    edge: FloatArray
    could: FloatArray
    tops: StressMaximaByFeature
    where: dict[FeatureKey, IntArray]
    may_be: StressMaximaByFeature

    @classmethod
    def of(cls, found: MeshSolution, combos: FloatArray, thickness: Metre) -> "_Field":
        """Return the field of a solution under loads (k, c)."""
        moved_by, smooth = combos @ found.displacements, superpose(found.stress, combos)
        level = von_mises(superpose(found.unit_stress, combos))
        zones, edge = found.zones, _edge_at_places(found)
        short = _SHORT * np.maximum(edge / (NEAR_REFERENCE_POINT_RATIO * thickness) - _LONG, 0.0)
        short[: len(zones.surface_stress_nodes)] = 0.0  # there elements that are too large disagree
        could = level * (1 + short)[:, None]
        highest, where = _tops(zones, level)
        tops, at, may_be = (
            dict(zip(zones.features, of, strict=True))
            for of in (highest, where, _tops(zones, could)[0])
        )
        return cls(found, moved_by, smooth, level, edge, could, tops, at, may_be)

    @property
    def short(self) -> dict[FeatureKey, float]:
        """Share of its top that each feature may be higher, where elements are too large."""
        most = {f: top.max() / max(self.tops[f].max(), 1e-300) for f, top in self.may_be.items()}
        return {f: float(m) - 1 for f, m in most.items()}

    def scatter(self, at: IntArray) -> FloatArray:
        """Return what the elements that meet at nodes disagree by, (n, k) Pa; nil elsewhere."""
        return self.found.elastic.stress_error_estimate(self.moved_by, self.smooth, at)

    def told_by_elements(self) -> StressMaximaByFeature:
        """Return half of what elements disagree by (k,) Pa at tops, carried on to toes."""
        zones, nodes = self.found.zones, self.found.elastic.nodes
        scatter = self.scatter(zones.source_nodes(nodes, np.unique([*self.where.values()])))
        doubt = (
            np.concatenate(
                [
                    scatter[zones.surface_stress_nodes],
                    zones.lines.structural_stress_error(nodes, scatter),
                ]
            )
            / 2
        )
        return {f: np.take_along_axis(doubt, at[None], 0)[0] for f, at in self.where.items()}

    def from_afar(self, goals: "Sequence[_ErrorGoal]") -> FloatArray:
        """Return what each element may have put goals off by, (goals, elements) Pa."""
        asked = [(g.node, g.load) for g in goals]
        return pollution_error(self.found.elastic, self.moved_by, self.smooth, asked)


def _worse(
    tops: Sequence[StressMaximaByFeature], values: Sequence[StressMaximaByFeature]
) -> StressMaximaByFeature:
    """Return values (k,) of each feature, held the way its top (k,) is the higher one."""
    found: StressMaximaByFeature = {}
    for f in dict.fromkeys(f for of_way in tops for f in of_way):
        has = [k for k, of_way in enumerate(tops) if f in of_way]
        high = np.stack([tops[k][f] for k in has])
        each = np.stack([values[k][f] for k in has])
        found[f] = np.take_along_axis(each, high.argmax(axis=0)[None], 0)[0]
    return found


def _firm_matters(
    sliding: StressMaximaByFeature,
    tops: StressMaximaByFeature,
    may_be: StressMaximaByFeature,
    weight: FloatArray,
) -> bool:
    """Whether a top that may be among the worst may be higher than with the flange sliding."""
    counts = _shares(may_be, weight, tops) >= _AMONG
    less = np.stack([sliding.get(f, 0.0 * top) for f, top in may_be.items()])
    return bool((counts & (np.stack([*may_be.values()]) > _HIGHER * less)).any())


def _shares(
    tops: StressMaximaByFeature, weight: FloatArray, of: StressMaximaByFeature | None = None
) -> FloatArray:
    """Return how near tops (f, k) Pa come to the worst of all, those of both ways to be held."""
    high, every = (np.stack([*t.values()]) for t in (tops, of or tops))
    kinds, all_kinds = ([kind for kind, _ in t] for t in (tops, of or tops))
    used = every * weight[all_kinds][:, None]
    return _share_of_worst(high, weight[kinds], (every.max(axis=0), used.max(axis=0)))


def _share_of_worst(
    high: FloatArray, weight: FloatArray, worst: tuple[FloatArray, FloatArray] | None = None
) -> FloatArray:
    """Return how near tops (f, k) Pa come to the worst of all under each load, (f, k) 1.

    By what they weigh (f,); and where the plain stress is nearly the highest, by that.
    """
    used = high * weight[:, None]
    most, most_used = worst or (high.max(axis=0), used.max(axis=0))
    plain, used = high / np.maximum(most, 1e-300), used / np.maximum(most_used, 1e-300)
    return np.where(plain >= _PLAIN, np.maximum(plain, used), used)


class _ErrorGoal(NamedTuple):
    """A stress whose error from elsewhere is sought: of a feature or a watched point, at a node."""

    feature: FeatureKey | None
    watched: int
    node: int
    load: int
    level: float


def _goals(
    way: int, fields: Sequence[_Field], worst: StressMaximaByFeature, weight: FloatArray
) -> list[_ErrorGoal]:
    """Return the tops of the worst features that a way to be held makes, each under its load."""
    mine = fields[way]
    zones, nodes = mine.found.zones, mine.found.elastic.nodes
    share = _shares(worst, weight)
    near = zones.lines.near
    goals: list[_ErrorGoal] = []
    for row in np.argsort(-share.max(axis=1), kind="stable")[:_GOALS].tolist():
        k = int(share[row].argmax())
        f = (*worst,)[row]
        if share[row, k] < _AMONG:
            break
        if f not in mine.tops or mine.tops[f][k] < worst[f][k]:
            continue  # the other way to be held makes it
        line = int(mine.where[f][k]) - len(zones.surface_stress_nodes)
        node = (
            zones.surface_stress_nodes[line]
            if line < 0
            else nodes.faces[near.faces[line], near.weights[line].argmax()]
        )
        goals.append(_ErrorGoal(f, -1, int(node), k, float(worst[f][k])))
    return goals


def _watched(nodes: MeshNodes, drawn: SurfaceProjection, level: FloatArray) -> list[_ErrorGoal]:
    """Return watched points, each under the load that is worst for it."""
    load = level.argmax(axis=1) if len(level) else np.zeros(0, dtype=np.int64)
    node = nodes.faces[drawn.faces, drawn.weights.argmax(axis=1)]
    return [
        _ErrorGoal(None, w, int(node[w]), int(k), float(level[w, k]))
        for w, k in enumerate(load.tolist())
    ]


def _taking(
    found: MeshSolution, goals: Sequence[_ErrorGoal], afar: FloatArray
) -> Iterator[tuple[FloatArray, Metre]]:
    """Yield which elements, wherever they lie, take too much from a stress, and the edge wanted."""
    nodes = found.elastic.nodes
    corners = nodes.points[nodes.elements[:, :4]]
    for goal, taken in zip(goals, afar, strict=True):
        if taken.sum() <= _TOLD * goal.level:
            continue
        order = np.argsort(-taken)
        enough = int(np.searchsorted(np.cumsum(taken[order]), _MOST_OF * taken.sum())) + 1
        for e in order[:enough].tolist():
            a = corners[e]
            edge = np.linalg.norm(a[:, None] - a[None], axis=-1).max()
            yield a.mean(axis=0), float(_HALF * edge)


def _at_places(found: MeshSolution, values: FloatArray) -> FloatArray:
    """Return a field of the nodes (n, k) at each place, (places, k)."""
    read = np.abs(found.zones.lines.near.interpolate(found.elastic.nodes, values))
    return np.concatenate([values[found.zones.surface_stress_nodes], read])


def _tops(zones: FatigueZones, level: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the highest value of each feature (features, k), and its place."""
    places = np.stack([
        (rows := np.flatnonzero(zones.feature == f))[level[rows].argmax(axis=0)]
        for f in range(len(zones.features))
    ])  # fmt: skip
    return np.take_along_axis(level, places, axis=0), places


def _edge_at_places(found: MeshSolution) -> FloatArray:
    """Return the edge (places,) m of the elements that the stress of each place is read from."""
    nodes, zones = found.elastic.nodes, found.zones
    edge = _edge(nodes)
    return np.concatenate(
        [edge[zones.surface_stress_nodes], edge[nodes.faces[zones.lines.near.faces]].mean(axis=1)]
    )


def _edge(nodes: MeshNodes) -> FloatArray:
    """Mean edge (n,) m of the triangles that meet at each node of the surface."""
    corners = nodes.points[nodes.faces[:, :3]]
    length = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1).mean(axis=1)
    total, count = np.zeros(len(nodes.points)), np.zeros(len(nodes.points))
    for k in range(6):
        np.add.at(total, nodes.faces[:, k], length)
        np.add.at(count, nodes.faces[:, k], 1.0)
    return total / np.maximum(count, 1.0)


def _worst_places(
    mine: _Field,
    tops: StressMaximaByFeature,
    may_be: StressMaximaByFeature,
    weight: FloatArray,
    thickness: Metre,
    *,
    first: bool,
) -> Iterator[tuple[FloatArray, Metre]]:
    """Yield where the next mesh is to be finer, with the edge wanted there."""
    zones, nodes, level = mine.found.zones, mine.found.elastic.nodes, mine.level

    def worst_of(
        own: StressMaximaByFeature, either: StressMaximaByFeature
    ) -> tuple[BoolArray, FloatArray]:
        """Return whether the feature of a place is among the worst, and its top."""
        highest = np.stack([*own.values()])
        # What the other way to be held makes higher by far is looked at there.
        makes = _HIGHER * highest >= np.stack([either[f] for f in own])
        among = makes & (_shares(own, weight, tops) >= _AMONG)
        return among[zones.feature], highest[zones.feature]

    worst, feature = worst_of(mine.tops, tops)
    among = worst & (level >= _HIGH * feature)
    there = zones.source_nodes(nodes, np.flatnonzero(among.any(axis=1)))
    off = _at_places(mine.found, mine.scatter(there))
    rough = np.where(among, off / np.maximum(level, 1e-300), 0.0).max(axis=1)
    near, here = zones.lines.near, mine.edge
    finer = here * np.clip(np.sqrt(_TOLD / np.maximum(rough, 1e-300)), 0.35, 1.0)
    if first:
        # That elements agree is no proof, at a face least of all: tops are looked at twice.
        top = among.any(axis=1) & (level >= _TOP * feature).any(axis=1)
        finer = np.where(top, np.minimum(finer, _HALF * here), finer)
    # Where structural stress is read, elements are to be no larger than the distance between;
    # from a toe half of it, by the thickness of its own plate, along all of it that may be worst.
    own = len(zones.surface_stress_nodes)
    may_be_worst, feature_could = worst_of(mine.may_be, may_be)
    read = among | (may_be_worst & (mine.could >= _HIGH * feature_could))
    fit = np.where(read.any(axis=1), NEAR_REFERENCE_POINT_RATIO * thickness, np.inf)[own:]
    along = (worst & (level >= _ALONG * feature)).any(axis=1)
    toe = (along & (zones.kind == ZONE_WELD_TOE))[own:] & zones.lines.can_extrapolate
    reach = np.linalg.norm(near.points - zones.lines.points, axis=1)
    fit = np.where(toe, np.minimum(fit, _READ * reach), fit)
    finer = np.minimum(finer, np.concatenate([np.full(own, np.inf), fit]))
    places = zones.points(nodes)
    for k in np.flatnonzero(finer < 0.8 * here).tolist():
        yield places[k], float(finer[k])
        if k >= len(zones.surface_stress_nodes):
            yield near.points[k - len(zones.surface_stress_nodes)], float(finer[k])


def _round(
    found: MeshSolution,
    points: FloatArray,
    level: FloatArray,
    off: FloatArray,
    *,
    moved: FloatArray,
) -> Iterator[tuple[FloatArray, Metre]]:
    """Yield where it is to be finer round points that are watched."""
    edge = _edge(found.elastic.nodes)
    drawn = project_to_surface(found.elastic.nodes, points)
    for point, face, high, rough, step_ in zip(points, drawn.faces, level, off, moved, strict=True):
        share = float((rough / np.maximum(high.max(), 1e-300)).max())
        if share > _TOLD or step_ > _STILL:
            here = float(edge[found.elastic.nodes.faces[face]].mean())
            size = here * float(np.clip(np.sqrt(_TOLD / max(share, _TOLD)), 0.35, _HALF))
            # The mesher lets elements grow at once beyond a point: seven keep them small.
            for step in np.concatenate([np.zeros((1, 3)), np.eye(3), -np.eye(3)]):
                yield point + size * step, size


def _moved(before: FloatArray, last: FloatArray) -> FloatArray:
    """Return the share (w,) of itself that watched stress (w, k) Pa moved by."""
    step = np.abs(last - before).max(axis=-1, initial=0.0)
    return step / np.maximum(last.max(axis=-1, initial=0.0), 1e-300)


def _settled(looks: Sequence[_MeshSearchResult], weight: FloatArray) -> bool:
    """Whether the last mesh moved no top that is among the worst by more than it may.

    Nor has one that may be among them from elements much too large to read it.
    """
    last, before, may_be = looks[-1].tops, looks[-2].tops, looks[-1].may_be
    high, could = (np.stack([*t.values()]) for t in (last, may_be))
    step = np.abs(high - np.stack([before.get(key, 0.0 * top) for key, top in last.items()]))
    moved = (step > _STILL * high) & (_shares(last, weight) >= _AMONG)
    short = (could > (1 + ASSUMED_STRESS_ERROR_SHARE_UNREFINED) * high) & (
        _shares(may_be, weight, last) >= _AMONG
    )
    return not (moved | short).any()


def _of_features(
    tops: Sequence[StressMaximaByFeature], off: StressMaximaByFeature, weight: FloatArray
) -> dict[FeatureKey, float]:
    """Return the share of each feature's top that its error may be.

    Only the worst are followed until they settle. Of others one mesh after the other is alike,
    and says little.
    """
    last = tops[-1]
    highs = [np.stack([t.get(f, 0.0 * top) for f, top in last.items()]) for t in tops]
    # They add up: maxima rise as elements shrink, so what was gained and what is still to come
    # lie on one side.
    error, high = _share(_drift(highs) + np.stack([*off.values()]), highs), highs[-1]
    settled = (_shares(last, weight) >= _AMONG).any(axis=1)
    anywhere = _ANYWHERE * high.max() / np.maximum(high.max(axis=1), 1e-300)
    share = np.maximum(
        np.where(settled, error, np.maximum(error, ASSUMED_STRESS_ERROR_SHARE_UNREFINED)), anywhere
    )
    return dict(zip(last, share.tolist(), strict=True))


def _drift(tops: list[FloatArray]) -> FloatArray:
    """Return what meshes still changed of (f, k) Pa.

    By the last one, or half of what the one before did: each mesh lies anew, so the last change
    may be small by luck.
    """
    steps = [np.abs(b - a) for a, b in itertools.pairwise(tops)]
    moved = [steps[-1]] if steps else []
    moved += [steps[-2] / 2] if len(steps) > 1 else []
    return np.max([np.zeros_like(tops[-1]), *moved], axis=0)


def _share(error: FloatArray, tops: list[FloatArray]) -> FloatArray:
    """Return an error (f, k) Pa as a share (f,) of the highest stress."""
    return error.max(axis=-1) / np.maximum(tops[-1].max(axis=-1), 1e-300)
