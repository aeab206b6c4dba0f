"""Hot spots: where a crack would start, and how well the stress there is known."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cardan.base.arrays import ArrayLike, BoolArray, FloatArray
from cardan.base.units import Metre
from cardan.bracket.elastic import Progress, elastic, silent
from cardan.bracket.stress import superpose, von_mises
from cardan.bracket.surface import away_from, nearest, peaks, sharp_edges
from cardan.bracket.unit import Units, solved, unit_solutions


@dataclass(frozen=True)
class Searched:
    """Where on the surface stress is searched for.

    `sound` (n,) marks the surface nodes away from sharp edges: beside those the stress of
    the model grows as elements shrink, so a maximum there says nothing.
    """

    nodes: FloatArray
    stress: FloatArray
    sound: BoolArray


def searched(units: Units, *, clear: Metre | None = None) -> Searched:
    """Points (n, 3) m and unit stresses (n, 9, 6) Pa on the surface, the unsound ones marked.

    `clear` is how far from a sharp edge stress counts, by default one and a half of the
    wall's thickness.
    """
    nodes = units.elastic.nodes
    points, stress = nodes.points[nodes.surface], units.at_nodes[1][nodes.surface]
    edges = sharp_edges(nodes, held=units.solid.bolts)
    distance = 1.5 * units.solid.thickness if clear is None else clear
    return Searched(points, stress, away_from(points, edges, distance=distance))


def hot_spots(
    where: Searched, peak_stress: ArrayLike, *, count: int = 3, apart: Metre
) -> FloatArray:
    """Points (k, 3) m of the highest values (n,) among the sound ones, a distance apart."""
    values = np.where(where.sound, np.asarray(peak_stress, dtype=float), -np.inf)
    return where.nodes[peaks(where.nodes, values, count=count, apart=apart)]


@dataclass(frozen=True)
class Converged:
    """Unit stresses at some points from three solutions, each better than the one before.

    Attributes
    ----------
    points : (k, 3) m
    first, higher, stress : (k, 9, 6) Pa
        As first solved; one degree higher; and of that degree with elements a third as long
        round the points, which is the answer.
    units : Units
        The last solution.
    """

    points: FloatArray
    first: FloatArray
    higher: FloatArray
    stress: FloatArray
    units: Units

    def error(self, loads: ArrayLike) -> FloatArray:
        """Estimate the error (k,) Pa of the largest von Mises stress under loads (t, 9).

        The larger of what the last step, smaller elements, still changed, and a quarter of
        what the step before, one degree more, had: by a point's own scatter the last change
        may be small by luck. It estimates, to about a factor of two.
        """
        last, higher, first = (
            np.max(von_mises(superpose(s, loads)), axis=-1)
            for s in (self.stress, self.higher, self.first)
        )
        return np.maximum(np.abs(last - higher), np.abs(higher - first) / 4)

    def settled(self, loads: ArrayLike, *, within: float = 0.05) -> BoolArray:
        """Whether the stress (k,) is known to a share of itself: if not, it may have no limit."""
        top = np.max(von_mises(superpose(self.stress, loads)), axis=-1)
        return self.error(loads) <= within * top


def converged(
    units: Units,
    points: ArrayLike,
    *,
    also: Sequence[tuple[ArrayLike, Metre]] = (),
    tell: Progress = silent,
) -> Converged:
    """Solve again, of higher degree and then finer, for the stress at points (k, 3) m.

    `also` are other points with the edge of elements wanted there.
    """
    points = np.asarray(points, dtype=float).reshape(-1, 3)
    body = units.elastic
    degree = body.degree + 1
    tell(f"again with degree {degree}")
    held = dict.fromkeys(units.solid.bolts, "xyz")
    again = elastic(body.mesh, body.material, held=held, degree=degree, tell=tell)
    higher = _on_surface(solved(units.solid, again, size=units.size, tell=tell), points)
    tell("again with smaller elements at the hot spots")
    best = unit_solutions(
        units.solid, body.material, size=units.size, degree=degree,
        finer=[*also, *(spot for p in points for spot in _star(p, _edge(units, p)))], tell=tell,
    )  # fmt: skip
    return Converged(
        points, _on_surface(units, points), higher, _on_surface(best, points), units=best
    )


def _on_surface(units: Units, points: FloatArray) -> FloatArray:
    """Return stresses (k, 9, 6) on the surface nearest to points (k, 3) m.

    The surface of a coarse mesh lies a little off that of a fine one, and in bending stress
    falls quickly with depth: points are lifted off, then drawn back.
    """
    near = nearest(units.elastic.nodes, points)
    return units.stress_at(near.points + units.solid.thickness / 20 * near.normals)


def _star(point: FloatArray, edge: Metre) -> list[tuple[FloatArray, Metre]]:
    """Seven points round a hot spot: the mesher lets elements grow at once beyond a point."""
    steps = np.concatenate([np.zeros((1, 3)), np.eye(3), -np.eye(3)])
    return [(point + edge / 2 * step, edge / 3) for step in steps]


def _edge(units: Units, point: FloatArray) -> Metre:
    """Mean edge of the element a point lies in."""
    body = units.elastic
    place = body.locate([point])[0]
    corners = body.nodes.points[body.nodes.elements[place.element, :4]]
    gaps = np.linalg.norm(corners[:, None] - corners[None], axis=-1)
    return float(gaps[gaps > 0].mean())
