"""Linear elasticity on curved tetrahedra: one factorisation, any number of loads and modes.

Displacements are polynomials of degree 2 or more in each element; isotropic, small strains.
Arrays that leave this module are SI, components last, six-vectors of stress and strain in
the order xx, yy, zz, xy, yz, zx (strains as tensor components, not engineering ones).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from cardan.base.arrays import ArrayLike, FloatArray
from cardan.base.errors import DesignError, NotConverged
from cardan.base.units import Metre, mm
from cardan.bracket.engine import engine
from cardan.bracket.stress import von_mises
from cardan.model.parts import Material

IntArray: TypeAlias = npt.NDArray[np.int64]
Progress: TypeAlias = Callable[[str], None]

_VOIGT = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
# The engine's corners with the first two swapped: VTK's and Abaqus's sense of rotation.
_SWAP = [1, 0, 2, 3]
_CORNERS = np.array([(0, 1, 0), (1, 0, 0), (0, 0, 1), (0, 0, 0)], dtype=float)
_EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))  # the order of VTK and Abaqus


_BALANCED = 1e-8
"""Equilibrium that is missed by less, as a share of the load: displacements are right to 1e-9."""
_CLOSEST = 6
"""Elements of those round a point that are searched closely, where it lies nearly in one."""
_NEARLY = 0.1
"""How far out of an element a point nearly in it lies, in reference coordinates."""
_FLAT = 0.3
"""Smallest over largest Jacobian of an element that is trusted at a node."""


def silent(_: str) -> None:
    """Tell nobody."""


def mesh(
    shape: Any,
    *,
    size: Metre,
    degree: int = 2,
    finer: Sequence[tuple[ArrayLike, Metre]] = (),
    grading: float = 0.5,
    per_radius: float = 1.5,
) -> Any:
    """Mesh a solid of the CAD kernel with tetrahedra that follow its curved faces.

    Parameters
    ----------
    shape
        OpenCASCADE solid, in metres.
    size
        Largest edge of an element.
    degree
        Degree of the curves that follow the faces.
    finer : [((3,) m, m), ...]
        Points to refine at, each with the edge wanted there.
    grading
        How fast elements grow away from small ones, 0 to 1.
    per_radius
        Elements to a radius of curvature.

    Raises
    ------
    DesignError
        If the mesher fails.
    """
    ngs, occ, mesher = engine()
    if not size > 0:
        msg = f"elements need a size above 0, got {size:g} m"
        raise ValueError(msg)
    # Netgen's own floor for edges, 1e-3, is meant for millimetres.
    wanted = mesher.MeshingParameters(
        maxh=size, grading=grading, curvaturesafety=per_radius, minedgelen=1e-7
    )
    for point, edge in finer:
        x, y, z = np.asarray(point, dtype=float)
        wanted.RestrictH(x=x, y=y, z=z, h=edge)
    failed = (
        f"the mesher failed on this shape with elements of {size / mm:.3g} mm: try smaller "
        "elements; slivers and gaps in a STEP file are the usual cause"
    )
    try:
        made = ngs.Mesh(occ.OCCGeometry(shape).GenerateMesh(mp=wanted))
    except Exception as error:  # the mesher raises bare exceptions of its own
        raise DesignError(failed, about="bracket") from error
    if made.ne == 0:
        raise DesignError(failed, about="bracket")
    made.Curve(degree)
    return made


@dataclass(frozen=True)
class Nodes:
    """Corners and edge middles of a mesh: where fields are drawn and searched.

    Attributes
    ----------
    points : (n, 3) m
    elements : (e, 10)
        Node numbers of each tetrahedron, four corners and six edge middles in the order of
        VTK's quadratic tetrahedron.
    faces : (f, 6)
        Node numbers of each surface triangle: three corners, then the middles of edges 01,
        12, 20; seen from outside they run anticlockwise.
    face_names : (f,)
        Name of the face each triangle lies on.
    face_numbers : (f,)
        Number of that face in the drawing: names are shared, numbers are not.
    """

    points: FloatArray
    elements: IntArray
    faces: IntArray
    face_names: npt.NDArray[np.str_]
    face_numbers: IntArray

    @cached_property
    def surface(self) -> IntArray:
        """Numbers of the nodes on the surface."""
        return np.unique(self.faces)


@dataclass(frozen=True)
class Place:
    """A point inside an element: which, and its reference coordinates."""

    element: int
    reference: tuple[float, float, float]
    point: FloatArray
    distance: Metre
    """From the point that was asked for."""


@dataclass(frozen=True)
class Elastic:
    """An elastic solid held at some of its faces, ready to be loaded; see `elastic`."""

    mesh: Any
    material: Material
    space: Any
    stiffness: Any
    free: Any
    inverse: Any
    degree: int

    @property
    def unknowns(self) -> int:
        """Number of displacements in the system of equations."""
        return int(self.space.ndof)

    @cached_property
    def mass(self) -> Any:
        """The engine's matrix of the solid's mass: only what swings asks for it."""
        ngs = engine().ngs
        u, v = self.space.TnT()
        form = self.material.density * ngs.InnerProduct(u, v) * ngs.dx
        with ngs.TaskManager():
            return ngs.BilinearForm(form, symmetric=True).Assemble().mat

    def held_otherwise(self, held: Mapping[str, str], *, tell: Progress = silent) -> "Elastic":
        """Return the same solid held at other faces: a factorisation, and nothing else, anew."""
        free = _free(self.space, self.mesh, held)
        tell("factorising")
        other = replace(self, free=free, inverse=_factors(self.stiffness, free))
        for known in ("mass", "nodes", "rigid", "_worth"):  # the same however it is held
            other.__dict__[known] = getattr(self, known)
        return other

    @cached_property
    def free_dofs(self) -> npt.NDArray[np.bool_]:
        """Which displacements are not held, (unknowns,)."""
        return np.fromiter(self.free, dtype=bool, count=self.space.ndof)

    def traction(self, face: str, vector: Any) -> FloatArray:
        """Load vector (unknowns,) of a traction, N/m², on the faces of a name.

        `vector` is three numbers, or a coefficient function of the engine with three.
        """
        ngs = engine().ngs
        known = set(self.mesh.GetBoundaries())
        if face not in known:
            msg = f"no face is called {face!r}; there are {', '.join(sorted(known))}"
            raise ValueError(msg)
        v = self.space.TestFunction()
        value = vector if isinstance(vector, ngs.CoefficientFunction) else ngs.CF(tuple(vector))
        form = ngs.LinearForm(ngs.InnerProduct(value, v) * ngs.ds(face, bonus_intorder=2))
        return self._assembled(form)

    def inertia(self, acceleration: ArrayLike) -> FloatArray:
        """Load vector (unknowns,) of the solid's own mass when its frame accelerates, m/s²."""
        ngs = engine().ngs
        a = -self.material.density * np.asarray(acceleration, dtype=float)
        v = self.space.TestFunction()
        return self._assembled(ngs.LinearForm(ngs.InnerProduct(ngs.CF(tuple(a)), v) * ngs.dx))

    def strained(self, weights: FloatArray, direction: ArrayLike) -> FloatArray:
        """Load vector (unknowns,) whose work on a displacement is a mean of its stress.

        `weights` (elements,) m^-3 are those of the elements' volume, `direction` (6,) what
        of the stress is asked: the sum of its products with stress, shear counted twice.
        """
        ngs = engine().ngs
        v = self.space.TestFunction()
        share = ngs.GridFunction(ngs.L2(self.mesh, order=0))
        share.vec.FV().NumPy()[:] = weights
        xx, yy, zz, xy, yz, zx = np.asarray(direction, dtype=float).tolist()
        asked = ngs.CF((xx, xy, zx, xy, yy, yz, zx, yz, zz), dims=(3, 3))
        stress = _stress_of(v, self.material)
        where = ngs.BitArray((np.asarray(weights) != 0).tolist())
        volume = ngs.dx(definedonelements=where)
        return self._assembled(ngs.LinearForm(share * ngs.InnerProduct(asked, stress) * volume))

    @staticmethod
    def _assembled(form: Any) -> FloatArray:
        form.Assemble()
        return np.array(form.vec.FV().NumPy(), dtype=float)

    def solve(self, loads: ArrayLike) -> FloatArray:
        """Displacement vectors (..., unknowns) under load vectors (..., unknowns).

        Raises
        ------
        NotConverged
            If equilibrium is missed by more than 1e-8 of the load: the solid is not held.
        """
        loads = np.asarray(loads, dtype=float)
        f, u = self.stiffness.CreateColVector(), self.stiffness.CreateColVector()
        r = self.stiffness.CreateColVector()
        found = np.empty_like(loads)
        free = self.free_dofs
        with engine().ngs.TaskManager():
            for case in np.ndindex(loads.shape[:-1]):
                f.FV().NumPy()[:] = loads[case]
                u.data = self.inverse * f
                size = max(float(np.linalg.norm(loads[case])), 1e-300)
                miss = np.inf
                for _ in range(2):
                    r.data = f - self.stiffness * u
                    miss = float(np.linalg.norm(r.FV().NumPy()[free]))
                    if miss <= _BALANCED * size:
                        break
                    u.data += self.inverse * r  # a step of refinement: another back-substitution
                if not miss <= _BALANCED * size:
                    msg = (
                        "the bracket is not in equilibrium: is every direction held? "
                        "Pick bolt faces that keep it from moving and turning"
                    )
                    raise NotConverged(msg)
                found[case] = u.FV().NumPy()
        return found

    def residual(self, displacement: ArrayLike) -> FloatArray:
        """Return the forces K u (unknowns,) that a displacement vector needs."""
        u, r = self.stiffness.CreateColVector(), self.stiffness.CreateColVector()
        u.FV().NumPy()[:] = displacement
        r.data = self.stiffness * u
        return np.array(r.FV().NumPy())

    def inert(self, displacement: ArrayLike) -> FloatArray:
        """Return the mass times a displacement vector, M u (unknowns,)."""
        u, r = self.mass.CreateColVector(), self.mass.CreateColVector()
        u.FV().NumPy()[:] = displacement
        r.data = self.mass * u
        return np.array(r.FV().NumPy())

    @cached_property
    def rigid(self) -> FloatArray:
        """Displacement vectors (6, unknowns) of unit motions and turns about the origin.

        Their product with a load vector is its resultant force and moment.
        """
        ngs = engine().ngs
        one = ngs.GridFunction(self.space.components[0])
        place: list[FloatArray] = []
        for field in (ngs.CF(1.0), ngs.x, ngs.y, ngs.z):
            one.Set(field)
            place.append(np.array(one.vec.FV().NumPy()))
        unit, x, y, z = place
        nil = np.zeros_like(unit)
        turns = [(nil, -z, y), (z, nil, -x), (-y, x, nil)]
        motions = [(unit, nil, nil), (nil, unit, nil), (nil, nil, unit)]
        return np.stack([np.concatenate(parts) for parts in (*motions, *turns)])

    def dofs_on(self, face: str) -> npt.NDArray[np.bool_]:
        """Which displacements (unknowns,) belong to the faces of a name."""
        held = self.space.GetDofs(self.mesh.Boundaries(face))
        return np.fromiter(held, dtype=bool, count=self.space.ndof)

    def field(self, displacement: ArrayLike) -> Any:
        """Return a displacement vector (unknowns,) as the engine's function of place."""
        g = engine().ngs.GridFunction(self.space)
        g.vec.FV().NumPy()[:] = displacement
        return g

    def strain_of(self, displacement: ArrayLike) -> Any:
        """Strain (6 components) of a displacement vector as the engine's function of place."""
        ngs = engine().ngs
        G = ngs.Grad(self.field(displacement))
        return ngs.CF(tuple((G[i, j] + G[j, i]) / 2 for i, j in _VOIGT))

    @cached_property
    def nodes(self) -> Nodes:
        """Nodes of the mesh, on its curved faces."""
        return _nodes(self.mesh)

    def at_nodes(self, displacements: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Displacement and stress at the nodes.

        Parameters
        ----------
        displacements : (c, unknowns)

        Returns
        -------
        u : (n, c, 3) m
        stress : (n, c, 6) Pa
            Mean over the elements that meet at the node.
        """
        ngs = engine().ngs
        displacements = np.asarray(displacements, dtype=float)
        where = self.mesh.MapToAllElements(_nodal_rule(), ngs.VOL)
        u = np.empty((len(self.nodes.points), len(displacements), 3))
        for c, vector in enumerate(displacements):
            field = self.field(vector)
            with ngs.TaskManager():  # no longer than it works: its idle threads spin
                u[self.nodes.elements.ravel(), c] = field(where)
        return u, self.stress_at_nodes(displacements)

    def stress_at_nodes(self, displacements: ArrayLike) -> FloatArray:
        """Stress (n, c, 6) Pa at the nodes of displacement vectors (c, unknowns).

        Mean over the elements that meet at the node.
        """
        displacements = np.asarray(displacements, dtype=float)
        where = self.mesh.MapToAllElements(_nodal_rule(), engine().ngs.VOL)
        flat, count = self.nodes.elements.ravel(), len(self.nodes.points)
        worth = self._worth.ravel()
        share = np.bincount(flat, weights=worth, minlength=count)
        stress = np.empty((count, len(displacements), 6))
        for c, vector in enumerate(displacements):
            raw = self._stress(vector, where)
            for k in range(6):
                summed = np.bincount(flat, weights=worth * raw[:, k], minlength=count)
                stress[:, c, k] = summed / share
        return stress

    def scatter(self, displacements: ArrayLike, smooth: FloatArray) -> FloatArray:
        """How far the elements that meet at a node disagree on its stress, (n, c) Pa.

        The largest von Mises stress of what an element says, less the mean `smooth`
        (n, c, 6) Pa of them all: the estimate of Zienkiewicz and Zhu, Int. J. Numer. Meth.
        Eng. 24 (1987) 337, at a point. Elements pressed flat there have no say,
        but where all are.
        """
        ngs = engine().ngs
        where = self.mesh.MapToAllElements(_nodal_rule(), ngs.VOL)
        flat, trusted = self.nodes.elements.ravel(), self._worth.ravel() > 0.5
        heard = np.bincount(flat, weights=trusted, minlength=len(self.nodes.points)) > 0
        trusted = trusted | ~heard[flat]  # where all are pressed flat, all are heard
        order = np.argsort(flat, kind="stable")
        starts = np.searchsorted(flat[order], np.arange(len(self.nodes.points)))
        found = np.zeros(smooth.shape[:2])
        for c, vector in enumerate(np.asarray(displacements, dtype=float)):
            off = von_mises(self._stress(vector, where) - smooth[flat, c]) * trusted
            found[:, c] = np.maximum.reduceat(off[order], starts)
        return found

    def _stress(self, displacement: FloatArray, where: Any) -> FloatArray:
        """Stress (k, 6) Pa of a displacement vector at points of the engine."""
        ngs = engine().ngs
        gradient = ngs.Grad(self.field(displacement))
        with ngs.TaskManager():
            G = np.reshape(gradient(where), (-1, 3, 3))
        return hooke(
            np.stack([(G[:, i, j] + G[:, j, i]) / 2 for i, j in _VOIGT], -1), self.material
        )

    def stress_on(self, rule: Any, displacement: FloatArray) -> FloatArray:
        """Stress (elements, q, 6) Pa at the points of an integration rule of the engine."""
        where = self.mesh.MapToAllElements(rule, engine().ngs.VOL)
        return self._stress(displacement, where).reshape(-1, len(rule.weights), 6)

    @cached_property
    def _worth(self) -> FloatArray:
        """How much each element's word at each of its nodes is worth, (e, 10).

        An element bent round a small radius can be pressed flat at a corner, where its
        strain is then nonsense: its neighbours know better.
        """
        ngs = engine().ngs
        volume = ngs.Det(ngs.specialcf.JacobianMatrix(3))
        here = volume(self.mesh.MapToAllElements(_nodal_rule(), ngs.VOL)).reshape(-1, 10)
        return np.where(here > _FLAT * here.max(axis=1, keepdims=True), 1.0, 1e-12)

    def locate(self, points: ArrayLike) -> list[Place]:
        """Find the point of the solid nearest to each of some points (k, 3) m."""
        return [self._nearest(p) for p in np.asarray(points, dtype=float).reshape(-1, 3)]

    def _nearest(self, point: FloatArray) -> Place:
        """Search the elements round the nearest nodes by Gauss and Newton's method."""
        ngs = engine().ngs
        nodes, touching = self.nodes, self._touching
        close = np.argsort(np.sum((nodes.points - point) ** 2, axis=-1))[:6]
        elements = list(dict.fromkeys(int(e) for n in close for e in touching(n)))
        maps = [self.mesh.GetTrafo(ngs.ElementId(ngs.VOL, e)) for e in elements]
        # Which it lies in, or nearly: a step that may leave the element tells, and costs little.
        outside = [_beyond(self._stepped(t, point, np.full(3, 0.25), free=True)) for t in maps]
        # Of a point further away it tells nothing: its shortest way may lead to any of them.
        count = _CLOSEST if min(outside) < _NEARLY else len(maps)
        best: Place | None = None
        for k in np.argsort(outside, kind="stable")[:count].tolist():
            xi = self._stepped(maps[k], point, np.full(3, 0.25), free=False)
            here = maps[k](*xi)
            found = np.array([here.point[i] for i in range(3)])
            away = float(np.linalg.norm(point - found))
            if best is None or away < best.distance:
                best = Place(elements[k], (float(xi[0]), float(xi[1]), float(xi[2])), found, away)
            if outside[k] == 0:
                break
        assert best is not None  # a mesh has elements
        return best

    @staticmethod
    def _stepped(trafo: Any, point: FloatArray, xi: FloatArray, *, free: bool) -> FloatArray:
        """Return the reference coordinates of the point of an element nearest to another.

        Or, where they are free to leave it, of the point itself as its shape goes on.
        """
        for _ in range(3 if free else 12):
            here = trafo(*xi)
            J = np.array([[here.jacobi[i, j] for j in range(3)] for i in range(3)])
            gap = point - np.array([here.point[i] for i in range(3)])
            step = xi + np.linalg.solve(J, gap)
            new = np.clip(step, -1.0, 2.0) if free else _into_tetrahedron(step, J)
            done = np.abs(new - xi).max() < 1e-12
            xi = new
            if done:
                break
        return xi

    @cached_property
    def _touching(self) -> Callable[[int], IntArray]:
        """Return a function from a node to the elements that meet at it."""
        elements = self.nodes.elements
        order = np.argsort(elements.ravel(), kind="stable")
        ends = np.searchsorted(elements.ravel()[order], np.arange(len(self.nodes.points) + 1))
        owners = order // elements.shape[1]
        return lambda n: owners[ends[n] : ends[n + 1]]

    def between_nodes(self, places: Sequence[Place], values: FloatArray) -> FloatArray:
        """Values (k, ...) at places of a field known at the nodes (n, ...)."""
        quadratic = shape_functions(np.array([place.reference for place in places]).reshape(-1, 3))
        nodes = self.nodes.elements[[place.element for place in places]]
        return np.einsum("kq,kq...->k...", quadratic, values[nodes])

    def strains_at(self, places: Sequence[Place], displacements: ArrayLike) -> FloatArray:
        """Strains (k, c, 6) at places of displacement vectors (c, unknowns)."""
        return self._at(places, [self.strain_of(u) for u in np.asarray(displacements, float)])

    def displacements_at(self, places: Sequence[Place], displacements: ArrayLike) -> FloatArray:
        """Displacements (k, c, 3) at places of displacement vectors (c, unknowns), m."""
        return self._at(places, [self.field(u) for u in np.asarray(displacements, float)])

    def _at(self, places: Sequence[Place], fields: Sequence[Any]) -> FloatArray:
        ngs = engine().ngs
        # The engine's own record of a point: reference coordinates, mesh, element.
        middle = ngs.IntegrationRule([(0.25, 0.25, 0.25)], [0.0])
        spots = self.mesh.MapToAllElements(middle, ngs.VOL)[[p.element for p in places]]
        for k, axis in enumerate("xyz"):
            spots[axis] = [p.reference[k] for p in places]
        return np.stack([field(spots) for field in fields], axis=1)

    def modes(self, count: int, *, rider: "Rider | None" = None) -> tuple[FloatArray, FloatArray]:
        """Natural frequencies (count,) Hz and mode shapes (count, unknowns), from the same factor.

        Lanczos on the inverse of the stiffness. Shapes have unit modal mass.
        """
        from scipy.sparse.linalg import LinearOperator, eigsh

        free = np.flatnonzero(self.free_dofs)
        n, more = len(free), 0 if rider is None else 3
        a, b = self.stiffness.CreateColVector(), self.stiffness.CreateColVector()
        shape = (n + more, n + more)

        def product(matrix: Any, x: FloatArray) -> FloatArray:
            a.FV().NumPy()[:] = 0.0
            a.FV().NumPy()[free] = x
            with engine().ngs.TaskManager():
                b.data = matrix * a
            return np.array(b.FV().NumPy()[free])

        seat = None if rider is None else rider.seat[:, free]

        def inverse(x: FloatArray) -> FloatArray:
            x = x.ravel()
            if rider is None or seat is None:
                return product(self.inverse, x)
            # The spring carries all that acts on the rider, so the seat feels it too.
            u = product(self.inverse, x[:n] + x[n:] @ seat)
            return np.concatenate([u, seat @ u + rider.compliance * x[n:]])

        def mass(x: FloatArray) -> FloatArray:
            x = x.ravel()
            own = product(self.mass, x[:n])
            return own if rider is None else np.concatenate([own, rider.mass * x[n:]])

        M = LinearOperator(shape, matvec=mass, dtype=float)
        inv = LinearOperator(shape, matvec=inverse, dtype=float)
        start = np.random.default_rng(1).standard_normal(n + more)
        squares, vectors = eigsh(
            M, k=count, M=M, sigma=0.0, OPinv=inv, v0=start, ncv=3 * count + 4, tol=1e-8
        )
        order = np.argsort(squares)
        shapes = np.zeros((count, self.unknowns))
        shapes[:, free] = vectors[:n, order].T
        return np.sqrt(squares[order]) / (2 * np.pi), shapes


@dataclass(frozen=True)
class Rider:
    """A mass that rides on the seat, through springs or rigidly.

    `seat` (3, unknowns) are the load vectors of unit forces on the seat along x, y, z,
    `compliance` (3,) m/N that of the springs, 0 where rigid; `mass` in kg.
    """

    seat: FloatArray
    compliance: FloatArray
    mass: float


def _beyond(xi: FloatArray) -> float:
    """Return how far reference coordinates lie outside the tetrahedron, 0 inside."""
    return max(-float(xi.min()), float(xi.sum()) - 1, 0.0)


def _into_tetrahedron(xi: FloatArray, J: FloatArray) -> FloatArray:
    """Nearest point of the reference tetrahedron, near in space rather than in reference."""
    if xi.min() >= 0 and xi.sum() <= 1:
        return xi
    best, least = _CORNERS[3], np.inf
    for corners in ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)):
        a, b, c = (_CORNERS[k] for k in corners)
        for basis, start in (
            (np.stack([b - a, c - a], 1), a), ((b - a)[:, None], a), ((c - a)[:, None], a),
            ((c - b)[:, None], b), (np.zeros((3, 0)), a), (np.zeros((3, 0)), b),
            (np.zeros((3, 0)), c),
        ):  # fmt: skip
            local = start
            if basis.shape[1]:
                s = np.linalg.lstsq(J @ basis, J @ (xi - start), rcond=None)[0]
                if s.min() < 0 or s.sum() > 1:
                    continue
                local = start + basis @ s
            away = float(np.linalg.norm(J @ (xi - local)))
            if away < least:
                best, least = local, away
    return best


def shape_functions(reference: FloatArray) -> FloatArray:
    """Return the weights (k, 10) of an element's nodes at reference coordinates (k, 3)."""
    xi = np.column_stack([reference, 1 - reference.sum(axis=1)])
    L = xi[:, np.argmax(np.column_stack([_CORNERS, _CORNERS.sum(axis=1) == 0]), axis=1)]
    return np.column_stack([L * (2 * L - 1), *(4 * L[:, a] * L[:, b] for a, b in _EDGES)])


def _stress_of(w: Any, material: Material) -> Any:
    """Stress of a displacement as the engine's function of place."""
    ngs = engine().ngs
    E, nu = material.youngs_modulus, material.poisson
    mu, lam = E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))
    strain = (ngs.Grad(w) + ngs.Grad(w).trans) / 2
    return 2 * mu * strain + lam * ngs.Trace(strain) * ngs.Id(3)


def _nodal_rule() -> Any:
    """Corners and edge middles of the reference tetrahedron, as the engine samples them."""
    middles = [tuple((_CORNERS[a] + _CORNERS[b]) / 2) for a, b in _EDGES]
    return engine().ngs.IntegrationRule([*map(tuple, _CORNERS), *middles], [0.0] * 10)


def _nodes(made: Any) -> Nodes:
    """Count corners and edge middles of a mesh of the engine."""
    ngs = engine().ngs
    raw = made.ngmesh
    corners = raw.Elements3D().NumPy()["nodes"][:, _SWAP].astype(np.int64) - 1
    faces = raw.Elements2D().NumPy()
    triangles = faces["nodes"][:, :3].astype(np.int64) - 1
    count = len(raw.Coordinates())
    pairs = np.sort(np.stack([corners[:, list(e)] for e in _EDGES], axis=1), axis=-1)
    keys = pairs[..., 0] * count + pairs[..., 1]
    edges, numbers = np.unique(keys, return_inverse=True)
    elements = np.concatenate([corners, count + numbers.reshape(keys.shape)], axis=1)
    points = np.empty((count + len(edges), 3))
    where = made.MapToAllElements(_nodal_rule(), ngs.VOL)
    points[elements.ravel()] = ngs.CF((ngs.x, ngs.y, ngs.z))(where)
    # A face inside, where solids are glued, is no surface: two elements share it.
    four = np.sort(corners[:, [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]].reshape(-1, 3), -1)
    shared = (four[:, 0] * count + four[:, 1]) * count + four[:, 2]
    known, times = np.unique(shared, return_counts=True)
    mine = np.sort(triangles, -1)
    mine = (mine[:, 0] * count + mine[:, 1]) * count + mine[:, 2]
    outer = times[np.searchsorted(known, mine)] == 1
    triangles, faces = triangles[outer], faces[outer]
    sides = np.sort(
        np.stack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]], 1), -1
    )
    middles = count + np.searchsorted(edges, sides[..., 0] * count + sides[..., 1])
    names = np.array([str(n) for n in made.GetBoundaries()])
    return Nodes(
        points=points,
        elements=elements,
        faces=np.concatenate([triangles, middles], axis=1),
        face_names=names[faces["index"].astype(int) - 1],
        face_numbers=faces["index"].astype(np.int64),
    )


def elastic(
    made: Any,
    material: Material,
    *,
    held: Mapping[str, str],
    held_edges: Mapping[str, str] | None = None,
    degree: int = 2,
    tell: Progress = silent,
) -> Elastic:
    """Assemble and factorise a solid.

    Parameters
    ----------
    made
        The mesh (`mesh`).
    material
        Of the whole solid.
    held, held_edges
        Names of faces and of edges, with the axes they may not move along: `{"bolt 1":
        "xyz", "symmetry": "y"}`.
    degree
        Of the displacements in an element.
    tell
        Is told what is being done.

    Raises
    ------
    ValueError
        If a name is not that of a face or edge of the mesh.
    """
    ngs = engine().ngs
    space = ngs.VectorH1(made, order=degree)
    free = _free(space, made, held, held_edges)
    u, v = space.TnT()
    strain = (ngs.Grad(v) + ngs.Grad(v).trans) / 2
    with ngs.TaskManager():
        tell(f"assembling {space.ndof} unknowns, {made.ne} elements")
        stiff = ngs.InnerProduct(_stress_of(u, material), strain)
        K = ngs.BilinearForm(stiff * ngs.dx, symmetric=True).Assemble().mat
    tell("factorising")
    return Elastic(
        mesh=made, material=material, space=space, stiffness=K, free=free,
        inverse=_factors(K, free), degree=degree,
    )  # fmt: skip


def _free(
    space: Any, made: Any, held: Mapping[str, str], held_edges: Mapping[str, str] | None = None
) -> Any:
    """Return the engine's mark of displacements that are not held."""
    free = engine().ngs.BitArray(space.ndof)
    free.Set()
    regions = ((held, made.GetBoundaries(), made.Boundaries),
               (held_edges or {}, made.GetBBoundaries(), made.BBoundaries))  # fmt: skip
    for wanted, known, region in regions:
        for name, axes in wanted.items():
            if name not in set(known):
                msg = f"nothing is called {name!r}; there are {', '.join(sorted(set(known)))}"
                raise ValueError(msg)
            for axis in axes:
                k = "xyz".index(axis)
                for dof in np.flatnonzero(list(space.components[k].GetDofs(region(name)))):
                    free.Clear(space.Range(k).start + int(dof))
    return free


def _factors(stiffness: Any, free: Any) -> Any:
    """Factorise a stiffness."""
    try:
        with engine().ngs.TaskManager():
            return stiffness.Inverse(free, inverse="sparsecholesky")
    except Exception as error:  # the engine raises bare exceptions of its own
        msg = f"the stiffness cannot be factorised ({error}): is every direction held?"
        raise NotConverged(msg) from error


def hooke(strain: ArrayLike, material: Material) -> FloatArray:
    """Stress (..., 6) Pa of a strain (..., 6) in an isotropic material."""
    strain = np.asarray(strain, dtype=float)
    E, nu = material.youngs_modulus, material.poisson
    mu, lam = E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))
    stress = 2 * mu * strain
    stress[..., :3] += lam * strain[..., :3].sum(axis=-1, keepdims=True)
    return stress
