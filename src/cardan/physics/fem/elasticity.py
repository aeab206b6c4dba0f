"""Linear elasticity on curved tetrahedra: one factorisation, any number of loads and modes.

Displacements are polynomials of degree 2 or more in each element; isotropic, small strains.
Arrays that leave this module are SI, components last, six-vectors of stress and strain in
the order xx, yy, zz, xy, yz, zx (strains as tensor components, not engineering ones).
Vectors of displacements and loads (unknowns,) have x, y, z of one shape function after the
other: the stiffness is a matrix of 3 x 3 blocks, which is factorised block by block, in half
the time that its numbers one by one take.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any, TypeAlias

import numpy as np

from cardan.core.arrays import ArrayLike, BoolArray, FloatArray, IntArray
from cardan.core.errors import ConvergenceError
from cardan.core.status import StatusCallback, ignore_status
from cardan.model.material import Material
from cardan.physics.fem.meshing import REFERENCE_CORNERS, MeshNodes, mesh_nodes, nodal_rule
from cardan.physics.fem.multifrontal import MultifrontalFactor, multifrontal_cholesky
from cardan.physics.fem.ngsolve_import import import_ngsolve
from cardan.physics.fem.stress import von_mises

_Gradients: TypeAlias = Callable[..., FloatArray]
_VOIGT = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
_INSIDE = (5 - 5**0.5) / 20 + REFERENCE_CORNERS / 5**0.5
"""Points (4, 3) of the reference tetrahedron by which stresses that are parabolas add up right."""
_BALANCED = 1e-8
"""Equilibrium that is missed by less, as a share of the load: displacements are right to 1e-9."""
_STILL = 1e-8
"""Share of themselves that displacements still move by, below which they are right. Rounding moves
those of a sheet of 1.5 mm by 0.2 to 1.3e-9, anew at each step: threads add up as they come."""
_EVERY = slice(None)
_FEW = 3
"""Load vectors whose stress is held at once, in every element."""
_FLAT = 0.3
"""Smallest over largest Jacobian of an element that is trusted at a node."""
_PATCH = 12
"""Nodes at least from which a stress is carried on to one where no element is trusted."""


@dataclass(frozen=True)
class ElasticSolid:
    """An elastic solid held at some of its faces, ready to be loaded; see `assemble_elastic_solid`.

    Attributes
    ----------
    space
        The engine's shape functions, of three displacements each.
    stiffness
        The engine's matrix, nothing held.
    free_dofs : (unknowns,)
        Which displacements are not held.
    inverse
        The engine's factors of what is free, for few loads, or ours, for hundreds; where a
        displacement is held next to free ones of its function the engine's let it go, and a load on
        it must be nil.
    """

    mesh: Any
    material: Material
    space: Any
    stiffness: Any
    free_dofs: BoolArray
    inverse: Any
    degree: int

    @property
    def unknowns(self) -> int:
        """Number of displacements in the system of equations."""
        return 3 * int(self.space.ndof)

    @cached_property
    def mass(self) -> Any:
        """Sparse matrix (functions, functions) kg of the solid's mass, for each direction alike."""
        from scipy.sparse import csr_array

        ngs = import_ngsolve().ngs
        space = ngs.H1(self.mesh, order=self.degree)
        u, v = space.TnT()
        with ngs.TaskManager():
            made = ngs.BilinearForm(self.material.density * u * v * ngs.dx).Assemble().mat
        values, columns, starts = (np.array(part) for part in made.CSR())
        return csr_array((values, columns.astype(np.int64), starts.astype(np.int64)))

    def with_constraints(
        self, held: Mapping[str, str], *, tell: StatusCallback = ignore_status
    ) -> "ElasticSolid":
        """Return the same solid held at other faces: a factorisation, and nothing else, anew."""
        free = _free(self.space, self.mesh, held)
        tell("factorising")
        other = replace(self, free_dofs=free, inverse=_factors(self.stiffness, free))
        # The same however it is held.
        known_by = "mass nodes rigid _says _silent _mean _meeting _functions _nodal within volumes"
        for known in known_by.split():
            other.__dict__[known] = getattr(self, known)
        return other

    def without_factorisation(self) -> "ElasticSolid":
        """Return the same solid without its factors, most of its memory: it solves no more."""
        other = replace(self, inverse=None)
        other.__dict__.update(self.__dict__ | {"inverse": None})
        return other

    def with_isostatic_supports(self) -> "ElasticSolid":
        """Return the same solid held by nothing but three points: loads in balance strain it alone.

        The first is held, the second may move towards it, the third in the plane of all three.
        Its factors are for hundreds of loads.
        """
        points = np.array([v.point for v in self.mesh.vertices])
        first = int((points @ [1.0, 0.3, 0.1]).argmin())
        away = points - points[first]
        second = int(np.linalg.norm(away, axis=1).argmax())
        along = away[second]
        square = np.cross(along, away)
        third = int(np.linalg.norm(square, axis=1).argmax())
        free = np.ones((self.space.ndof, 3), dtype=bool)
        free[first] = False
        free[second, np.argsort(np.abs(along))[:2]] = False
        free[third, np.abs(square[third]).argmax()] = False
        inverse = multifrontal_cholesky(_blocks(self.stiffness), free.ravel())
        return replace(self, free_dofs=free.ravel(), inverse=inverse)

    def traction(self, face: str, vector: Any) -> FloatArray:
        """Load vector (unknowns,) of a traction, N/m², on the faces of a name.

        `vector` is three numbers, or a coefficient function of the engine with three.
        """
        ngs = import_ngsolve().ngs
        known = set(self.mesh.GetBoundaries())
        if face not in known:
            msg = f"no face is called {face!r}; there are {', '.join(sorted(known))}"
            raise ValueError(msg)
        v = self.space.TestFunction()
        value = vector if isinstance(vector, ngs.CoefficientFunction) else ngs.CF(tuple(vector))
        form = ngs.LinearForm(ngs.InnerProduct(value, v) * ngs.ds(face, bonus_intorder=2))
        return self.assemble_load(form)

    def inertia(self, acceleration: ArrayLike) -> FloatArray:
        """Load vector (unknowns,) of the solid's own mass when its frame accelerates, m/s²."""
        ngs = import_ngsolve().ngs
        a = -self.material.density * np.asarray(acceleration, dtype=float)
        v = self.space.TestFunction()
        return self.assemble_load(ngs.LinearForm(ngs.InnerProduct(ngs.CF(tuple(a)), v) * ngs.dx))

    def mean_stress_load(self, weights: FloatArray, direction: ArrayLike) -> FloatArray:
        """Load vector (unknowns,) whose work on a displacement is a mean of its stress.

        `weights` (elements,) m^-3 are those of the elements' volume, `direction` (6,) what
        of the stress is sought: the sum of its products with stress, shear counted twice.
        """
        ngs = import_ngsolve().ngs
        v = self.space.TestFunction()
        share = ngs.GridFunction(ngs.L2(self.mesh, order=0))
        share.vec.FV().NumPy()[:] = weights
        xx, yy, zz, xy, yz, zx = np.asarray(direction, dtype=float).tolist()
        asked = ngs.CF((xx, xy, zx, xy, yy, yz, zx, yz, zz), dims=(3, 3))
        stress = _stress_of(v, self.material)
        where = ngs.BitArray((np.asarray(weights) != 0).tolist())
        volume = ngs.dx(definedonelements=where)
        return self.assemble_load(ngs.LinearForm(share * ngs.InnerProduct(asked, stress) * volume))

    @staticmethod
    def assemble_load(form: Any) -> FloatArray:
        """Return the load vector (unknowns,) of a linear form of the engine."""
        form.Assemble()
        return np.array(form.vec.FV().NumPy(), dtype=float)

    def solve(self, loads: ArrayLike, *, still: float = _STILL) -> FloatArray:
        """Displacement vectors (..., unknowns) under load vectors (..., unknowns).

        Raises
        ------
        ConvergenceError
            If equilibrium is missed by more than 1e-8 of the load, and displacements still move by
            more than a share `still` of themselves: the solid is not held.
        """
        loads = np.asarray(loads, dtype=float)
        each, free = loads.reshape(-1, loads.shape[-1]), self.free_dofs
        found = self._yielding(each * free)
        if self._balances(found, each):
            return found.reshape(loads.shape)
        size, loose = np.linalg.norm(each, axis=1), np.arange(len(each))
        for _ in range(2):
            left = np.stack([each[k] - self.internal_forces(found[k]) for k in loose]) * free
            off = ~(np.linalg.norm(left, axis=1) <= _BALANCED * size[loose])
            loose, left = loose[off], left[off]
            if not loose.size:
                break
            step = self._yielding(left)  # of refinement: another substitution
            found[loose] += step
            # The forces inside a thin sheet are so much larger than its load that their last
            # digits miss it by more: that the displacements stay is what counts.
            moved = np.linalg.norm(found[loose], axis=1)
            loose = loose[~(np.linalg.norm(step, axis=1) <= still * moved)]
            if not loose.size:
                break
        else:
            msg = (
                "the bracket is not in equilibrium: is every direction held? "
                "Pick bolt faces that keep it from moving and turning"
            )
            raise ConvergenceError(msg)
        return found.reshape(loads.shape)

    def _yielding(self, loads: FloatArray) -> FloatArray:
        """Displacement vectors (c, unknowns) under loads (c, unknowns), by one substitution."""
        if isinstance(self.inverse, MultifrontalFactor):
            return self.inverse.solve(loads)
        found = np.empty_like(loads)
        for load, u in zip(loads, found, strict=True):
            u[:] = self._times(self.inverse, load)
        return found

    def _balances(self, found: FloatArray, loads: FloatArray) -> bool:
        """Whether displacements (c, unknowns) balance their loads, by one sum of them all.

        Each load as large as the others, its sign by chance: what they miss does not cancel.
        """
        size = np.linalg.norm(loads, axis=1)
        sign = np.random.default_rng(1).choice([-1.0, 1.0], len(loads))
        share = sign / np.where(size > 0, size, np.inf)
        missed = (share @ loads - self.internal_forces(share @ found)) * self.free_dofs
        return float(np.linalg.norm(missed)) <= _BALANCED

    def _times(self, matrix: Any, vector: FloatArray) -> FloatArray:
        """Return a matrix of the engine times a vector (unknowns,)."""
        a, b = self.stiffness.CreateColVector(), self.stiffness.CreateColVector()
        a.FV().NumPy()[:] = vector
        with import_ngsolve().ngs.TaskManager():  # no longer than it works: its idle threads spin
            b.data = matrix * a
        return np.array(b.FV().NumPy())

    def internal_forces(self, displacement: ArrayLike) -> FloatArray:
        """Return the forces K u (unknowns,) that a displacement vector needs."""
        return self._times(self.stiffness, np.asarray(displacement, dtype=float))

    def mass_times(self, displacement: ArrayLike) -> FloatArray:
        """Return the mass times a displacement vector, M u (unknowns,)."""
        moved = np.reshape(displacement, (-1, 3))
        return np.asarray(self.mass @ moved, dtype=float).ravel()

    @cached_property
    def rigid(self) -> FloatArray:
        """Displacement vectors (6, unknowns) of unit motions and turns about the origin.

        Their product with a load vector is its resultant force and moment.
        """
        ngs = import_ngsolve().ngs
        place = ngs.GridFunction(self.space)
        place.Set(ngs.CF((ngs.x, ngs.y, ngs.z)))
        x, y, z = np.array(place.vec.FV().NumPy()).reshape(-1, 3).T
        nil, unit = np.zeros_like(x), np.zeros_like(x)
        unit[: self.mesh.nv] = 1.0  # functions of corners add up to 1, the others bend that
        turns = [(nil, -z, y), (z, nil, -x), (-y, x, nil)]
        motions = [(unit, nil, nil), (nil, unit, nil), (nil, nil, unit)]
        return np.stack([np.stack(parts, axis=-1).ravel() for parts in (*motions, *turns)])

    def dofs_on(self, face: str) -> BoolArray:
        """Which displacements (unknowns,) belong to the faces of a name."""
        return np.repeat(_marked(self.space.GetDofs(self.mesh.Boundaries(face))), 3)

    def displacement_field(self, displacement: ArrayLike) -> Any:
        """Return a displacement vector (unknowns,) as the engine's function of place."""
        g = import_ngsolve().ngs.GridFunction(self.space)
        g.vec.FV().NumPy()[:] = displacement
        return g

    def strain_field(self, displacement: ArrayLike) -> Any:
        """Strain (6 components) of a displacement vector as the engine's function of place."""
        ngs = import_ngsolve().ngs
        G = ngs.Grad(self.displacement_field(displacement))
        return ngs.CF(tuple((G[i, j] + G[j, i]) / 2 for i, j in _VOIGT))

    @cached_property
    def nodes(self) -> MeshNodes:
        """Nodes of the mesh, on its curved faces."""
        return mesh_nodes(self.mesh)

    def at_nodes(self, displacements: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return motion (n, c, 3) m and stress (n, c, 6) Pa of displacements (c, unknowns)."""
        return self.displacement_at_nodes(displacements), self.stress_at_nodes(displacements)

    def displacement_at_nodes(self, displacements: ArrayLike) -> FloatArray:
        """Return how the nodes move, (n, c, 3) m, of displacement vectors (c, unknowns)."""
        displacements = np.asarray(displacements, dtype=float)
        functions, kinds, ways = self._functions
        moved = _rows(displacements)
        u = np.empty((len(self.nodes.points), 3 * len(displacements)))
        for kind, way in enumerate(ways):
            mine = kinds == kind
            N = np.array([way.CalcShape(*p.point) for p in nodal_rule()])
            u[self.nodes.elements[mine]] = N @ moved[functions[mine]]
        return u.reshape(len(u), -1, 3)

    def stress_at_nodes(self, displacements: ArrayLike) -> FloatArray:
        """Stress (n, c, 6) Pa at the nodes of displacement vectors (c, unknowns).

        Mean over the elements that meet at the node.
        """
        displacements = np.asarray(displacements, dtype=float)
        read, found = self._nodal, np.empty((len(self.nodes.points), len(displacements), 6))
        for c in range(0, len(displacements), _FEW):
            few = slice(c, c + _FEW)
            G = read(displacements[few])
            # Stress follows gradients in proportion, and so does its mean their mean.
            mean = self._mean @ G.reshape(-1, G[0, 0].size)
            found[:, few] = stress_of_gradients(mean.reshape(-1, *G.shape[2:]), self.material)
        return found

    @cached_property
    def _mean(self) -> Any:
        """Sparse matrix (n, 10 e) that takes the mean at the nodes of what elements say.

        Where none has a say it carries on in a straight line what is said round the node.
        """
        from scipy.sparse import csr_array, eye_array, lil_array

        flat, says = self.nodes.elements.ravel(), self._says.ravel()
        count = len(self.nodes.points)
        voices = np.bincount(flat, weights=says, minlength=count)
        order, starts = self._meeting
        share = says / np.maximum(voices, 1.0)[flat]
        mean = csr_array((share[order], order, starts), shape=(count, len(flat)))
        if not self._silent:
            return mean
        carried = lil_array((count, count))
        for node, (near, weights) in self._silent.items():
            carried[node, near] = weights
        return (eye_array(count, format="csr") + carried.tocsr()) @ mean

    @cached_property
    def _silent(self) -> dict[int, tuple[IntArray, FloatArray]]:
        """Of each node where no element has a say: nodes round it where one has, and weights."""
        points, elements = self.nodes.points, self.nodes.elements
        heard = np.zeros(len(points), dtype=bool)
        heard[elements[self._says]] = True
        found: dict[int, tuple[IntArray, FloatArray]] = {}
        for node in np.flatnonzero(~heard).tolist():
            near = np.array([node])
            while np.count_nonzero(heard[near]) < _PATCH and len(near) < len(points):
                near = np.unique(elements[np.concatenate([self._touching(n) for n in near])])
            near = near[heard[near]]
            away = points[near] - points[node]
            away /= np.abs(away).max()
            linear = np.linalg.pinv(np.column_stack([np.ones(len(near)), away]))
            found[node] = near, linear[0]
        return found

    @cached_property
    def _meeting(self) -> tuple[IntArray, IntArray]:
        """Which elements' nodes (10 e,) meet at each node, one node after the other, and where."""
        flat = self.nodes.elements.ravel()
        order = np.argsort(flat, kind="stable")
        return order, np.searchsorted(flat[order], np.arange(len(self.nodes.points) + 1))

    def stress_error_estimate(
        self, displacements: ArrayLike, smooth: FloatArray, at: IntArray | None = None
    ) -> FloatArray:
        """How far the elements that meet at a node disagree on its stress, (n, c) Pa.

        Of the nodes `at` which it is requested, by default of all; nil at others.

        The largest von Mises stress of what an element says, less the mean `smooth`
        (n, c, 6) Pa of them all: the estimate of Zienkiewicz and Zhu, Int. J. Numer. Meth.
        Eng. 24 (1987) 337, at a point. Elements pressed flat there have no say; where
        all are, what counts is what those round it disagree by.
        """
        asked = np.zeros(len(smooth), dtype=bool)
        asked[slice(None) if at is None else at] = True
        heard = asked.copy()
        silent = {node: near for node, (near, _) in self._silent.items() if asked[node]}
        for near in silent.values():
            heard[near] = True
        some = np.flatnonzero(heard[self.nodes.elements].any(axis=1))
        flat, says = self.nodes.elements[some].ravel(), self._says[some].ravel()
        order = np.argsort(flat, kind="stable")
        meet, starts = np.unique(flat[order], return_index=True)
        displacements = np.asarray(displacements, dtype=float)
        read, found = self._nodal, np.zeros(smooth.shape[:2])
        for c in range(0, len(displacements) if len(some) else 0, _FEW):
            few = slice(c, c + _FEW)
            raw = stress_of_gradients(read(displacements[few], some), self.material)
            off = von_mises(raw.reshape(len(flat), -1, 6) - smooth[flat, few])
            found[meet, few] = np.maximum.reduceat((off * says[:, None])[order], starts)
        for node, near in silent.items():
            found[node] = found[near].max(axis=0)
        found[~asked] = 0.0
        return found

    @cached_property
    def within(self) -> Callable[[FloatArray], FloatArray]:
        """What reads stress (elements, q, c, 6) Pa at points inside by which errors add up."""
        return self.stress_evaluator(self.quadrature_rule())

    @staticmethod
    @cache
    def quadrature_rule() -> Any:
        """Return those points, as the engine has them."""
        ngs = import_ngsolve().ngs
        return ngs.IntegrationRule(ngs.TET, 3)

    @cached_property
    def volumes(self) -> FloatArray:
        """Volume (elements, q) m³ that each of those points stands for."""
        ngs, rule = import_ngsolve().ngs, self.quadrature_rule()
        where = self.mesh.MapToAllElements(rule, ngs.VOL)
        volume = np.abs(np.asarray(ngs.Det(ngs.specialcf.JacobianMatrix(3))(where), dtype=float))
        return volume.reshape(-1, len(rule.weights)) * np.array(rule.weights)

    def stress_evaluator(self, rule: Any) -> Callable[[FloatArray], FloatArray]:
        """Return what reads stress (elements, q, c, 6) Pa at the points of a rule of the engine.

        Of displacement vectors (c, unknowns).
        """
        read, material = self._gradients(rule), self.material
        return lambda displacements: stress_of_gradients(read(displacements), material)

    def _gradients(self, rule: Any, carry: FloatArray | None = None) -> "_Gradients":
        """Return what reads gradients (elements, q, 3, c, 3) 1 of displacements (c, unknowns).

        Of all elements, or of some. The first three are the directions in which, the last the
        displacements that change. Those of the shape functions are known once, and multiply all
        vectors together; carried on from the rule's points to others, where weights (others, q) say
        so. What is returned does not hold on to the factors.
        """
        ngs = import_ngsolve().ngs
        functions, kinds, ways = self._functions
        where = self.mesh.MapToAllElements(rule, ngs.VOL)
        inverse = ngs.Inv(ngs.specialcf.JacobianMatrix(3))(where)
        inverse = np.reshape(inverse, (len(functions), -1, 3, 3))
        each = np.empty((*inverse.shape[:3], functions.shape[1]))
        for kind, way in enumerate(ways):
            mine = kinds == kind
            for q, p in enumerate(rule):
                D = np.array(way.CalcDShape(*p.point))
                each[mine, q] = np.tensordot(inverse[mine, q], D, axes=(1, 1))
        if carry is not None:
            q = each.shape[1]
            each = (carry @ each.reshape(len(each), q, -1)).reshape(-1, len(carry), *each.shape[2:])
        shape = each.shape[:3]
        each = each.reshape(len(functions), -1, functions.shape[1])

        def read(displacements: FloatArray, some: Any = _EVERY) -> FloatArray:
            found = each[some] @ _rows(displacements)[functions[some]]
            return found.reshape(len(found), *shape[1:], -1, 3)

        return read

    @cached_property
    def _nodal(self) -> "_Gradients":
        """What reads gradients at the nodes of each element.

        Elements of second degree are most right at four points inside, and on curved faces least
        at their nodes: what is read inside is carried on to them in a straight line. Source:
        Barlow, Int. J. Numer. Meth. Eng. 10 (1976) 243.
        """
        if self.degree > 2:
            return self._gradients(nodal_rule())
        nodes = np.array([p.point for p in nodal_rule()])
        flat = np.column_stack([np.ones(4), _INSIDE])
        carry = np.column_stack([np.ones(len(nodes)), nodes]) @ np.linalg.inv(flat)
        inside = import_ngsolve().ngs.IntegrationRule([*map(tuple, _INSIDE)], [0.0] * 4)
        return self._gradients(inside, carry)

    @cached_property
    def _functions(self) -> tuple[IntArray, IntArray, list[Any]]:
        """Numbers of each element's shape functions (e, f), its kind (e,), and one of each kind.

        In the reference element they depend on the order its corners are numbered in, no more.
        """
        ngs = import_ngsolve().ngs
        every = [ngs.ElementId(ngs.VOL, e) for e in range(self.mesh.ne)]
        functions = np.array([self.space.GetDofNrs(e) for e in every], dtype=np.int64)
        corners = self.mesh.ngmesh.Elements3D().NumPy()["nodes"][:, :4]
        order = np.argsort(corners, axis=1) @ [64, 16, 4, 1]
        _, first, kinds = np.unique(order, return_index=True, return_inverse=True)
        return functions, kinds, [self.space.GetFE(every[e]) for e in first]

    @cached_property
    def _says(self) -> BoolArray:
        """Whether each element has a say at each of its nodes, (e, 10).

        An element bent round a small radius can be pressed flat at a corner, where its
        strain is then nonsense: its neighbours know better.
        """
        ngs = import_ngsolve().ngs
        volume = ngs.Det(ngs.specialcf.JacobianMatrix(3))
        here = volume(self.mesh.MapToAllElements(nodal_rule(), ngs.VOL)).reshape(-1, 10)
        return here > _FLAT * here.max(axis=1, keepdims=True)

    @cached_property
    def _touching(self) -> Callable[[int], IntArray]:
        """Return a function from a node to the elements that meet at it."""
        order, ends = self._meeting
        owners = order // self.nodes.elements.shape[1]
        return lambda n: owners[ends[n] : ends[n + 1]]

    def modes(self, count: int) -> tuple[FloatArray, FloatArray]:
        """Natural frequencies (count,) Hz and mode shapes (count, unknowns), from the same factor.

        Lanczos on the inverse of the stiffness. Shapes have unit modal mass. Frequencies are
        right to the square of the 1e-5 that shapes are.
        """
        from scipy.sparse.linalg import LinearOperator, eigsh

        free = np.flatnonzero(self.free_dofs)
        whole = np.zeros(self.unknowns)

        def solved(x: FloatArray) -> FloatArray:
            whole[free] = x.ravel()
            return self._times(self.inverse, whole)[free]

        def weighed(x: FloatArray) -> FloatArray:
            whole[free] = x.ravel()
            return self.mass_times(whole)[free]

        shape = (len(free), len(free))
        M = LinearOperator(shape, matvec=weighed, dtype=float)
        inv = LinearOperator(shape, matvec=solved, dtype=float)
        start = np.random.default_rng(1).standard_normal(len(free))
        squares, vectors = eigsh(
            M, k=count, M=M, sigma=0.0, OPinv=inv, v0=start, ncv=3 * count // 2 + 5, tol=1e-5
        )
        order = np.argsort(squares)
        shapes = np.zeros((count, self.unknowns))
        shapes[:, free] = vectors[:, order].T
        return np.sqrt(squares[order]) / (2 * np.pi), shapes


def _stress_of(w: Any, material: Material) -> Any:
    """Stress of a displacement as the engine's function of place."""
    ngs = import_ngsolve().ngs
    E, nu = material.youngs_modulus, material.poisson
    mu, lam = E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))
    strain = (ngs.Grad(w) + ngs.Grad(w).trans) / 2
    return 2 * mu * strain + lam * ngs.Trace(strain) * ngs.Id(3)


def assemble_elastic_solid(
    made: Any,
    material: Material,
    *,
    held: Mapping[str, str],
    held_edges: Mapping[str, str] | None = None,
    degree: int = 2,
    tell: StatusCallback = ignore_status,
) -> ElasticSolid:
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
        Receives what is being done.

    Raises
    ------
    ValueError
        If a name is not that of a face or edge of the mesh.
    """
    ngs = import_ngsolve().ngs
    space = ngs.H1(made, order=degree, dim=3)
    free = _free(space, made, held, held_edges)
    u, v = space.TnT()
    strain = (ngs.Grad(v) + ngs.Grad(v).trans) / 2
    with ngs.TaskManager():
        tell(f"assembling {3 * space.ndof} unknowns, {made.ne} elements")
        stiff = ngs.InnerProduct(_stress_of(u, material), strain)
        K = ngs.BilinearForm(stiff * ngs.dx).Assemble().mat
    tell("factorising")
    return ElasticSolid(
        mesh=made, material=material, space=space, stiffness=K, free_dofs=free,
        inverse=_factors(K, free), degree=degree,
    )  # fmt: skip


def _marked(bits: Any) -> BoolArray:
    """Return the engine's marks (functions,) as an array."""
    return np.fromiter(bits, dtype=bool, count=len(bits))


def _rows(vectors: FloatArray) -> FloatArray:
    """Return vectors (c, unknowns) function by function, (functions, 3 c)."""
    by_function = vectors.reshape(len(vectors), -1, 3).swapaxes(0, 1)
    return np.ascontiguousarray(by_function).reshape(by_function.shape[0], -1)


def _free(
    space: Any, made: Any, held: Mapping[str, str], held_edges: Mapping[str, str] | None = None
) -> BoolArray:
    """Return which displacements (unknowns,) are not held."""
    free = np.ones((space.ndof, 3), dtype=bool)
    regions = ((held, made.GetBoundaries(), made.Boundaries),
               (held_edges or {}, made.GetBBoundaries(), made.BBoundaries))  # fmt: skip
    for wanted, known, region in regions:
        for name, axes in wanted.items():
            if name not in set(known):
                msg = f"nothing is called {name!r}; there are {', '.join(sorted(set(known)))}"
                raise ValueError(msg)
            on = _marked(space.GetDofs(region(name)))
            free[on] &= [axis not in axes for axis in "xyz"]
    return free.ravel()


def _factors(stiffness: Any, free: BoolArray) -> Any:
    """Factorise what is free (unknowns,) of a stiffness."""
    ngs = import_ngsolve().ngs
    each = free.reshape(-1, 3)
    held, some = _uncoupled(stiffness, each), ngs.BitArray(each.any(axis=1).tolist())
    try:
        with ngs.TaskManager():
            return held.Inverse(some, inverse="sparsecholesky")
    except Exception as error:  # the engine raises bare exceptions of its own
        msg = f"the stiffness cannot be factorised ({error}): is every direction held?"
        raise ConvergenceError(msg) from error


def _blocks(stiffness: Any) -> Any:
    """Return a stiffness of the engine as a sparse matrix of its 3 x 3 blocks."""
    from scipy.sparse import bsr_array

    values, *pattern = stiffness.CSR()
    columns, starts = (np.array(known, dtype=np.int32) for known in pattern)
    count = 3 * (len(starts) - 1)
    return bsr_array((np.reshape(values, (-1, 3, 3)), columns, starts), shape=(count, count))


def _uncoupled(stiffness: Any, free: BoolArray) -> Any:
    """Return a stiffness in which what is held next to what is free has no part.

    Of a function whose displacements (functions, 3) are held in part the held ones keep their
    own diagonal alone: the factors leave out whole functions only.
    """
    count = free.sum(axis=1)
    part: BoolArray = (count > 0) & (count < 3)
    if not part.any():
        return stiffness
    _, *pattern = stiffness.CSR()
    columns, starts = (np.array(known, dtype=np.int64) for known in pattern)
    rows = np.repeat(np.arange(len(free)), np.diff(starts))
    at = np.flatnonzero(part[rows] | part[columns])
    i, j = rows[at], columns[at]
    kept = free[i][:, :, None] & free[j][:, None, :]
    kept |= (i == j)[:, None, None] & np.eye(3, dtype=bool)
    other = stiffness.CreateMatrix()
    other.AsVector().FV().NumPy().reshape(-1, 3, 3)[at] *= kept
    return other


def stress_of_gradients(gradients: FloatArray, material: Material) -> FloatArray:
    """Stress (..., c, 6) Pa of gradients of displacement (..., 3, c, 3)."""
    strains = np.zeros((3, 3, 6))  # of a unit of each gradient
    for k, (i, j) in enumerate(_VOIGT):
        strains[i, j, k] += 0.5
        strains[j, i, k] += 0.5
    each = np.moveaxis(gradients, -2, -3)  # one product of matrices, of numbers that lie together
    stress = each.reshape(-1, 9) @ isotropic_stress(strains, material).reshape(9, 6)
    return stress.reshape(*each.shape[:-2], 6)


def isotropic_stress(strain: ArrayLike, material: Material) -> FloatArray:
    """Stress (..., 6) Pa of a strain (..., 6) in an isotropic material."""
    strain = np.asarray(strain, dtype=float)
    E, nu = material.youngs_modulus, material.poisson
    mu, lam = E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))
    stress = 2 * mu * strain
    trace = strain[..., 0] + strain[..., 1] + strain[..., 2]
    stress[..., :3] += lam * trace[..., None]
    return stress
