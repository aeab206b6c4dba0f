"""A flange in its bolts: what presses stays, what is pulled lifts off, what is pressed rubs.

The frame is a rigid plane that only pushes. Bolts press the flange against it by their heads,
each with a force that stays: as long as a joint does not open, its bolt hardly feels what comes
on top. Flange and frame rub by Coulomb's law, from the tightened state on.

The bracket floats: held at three points, so that forces in balance leave no reaction. Unit
forces on patches of the plane, on the heads' faces and on the bearing are solved once; all that
follows is small and dense: u = C q + R a, with q the forces, a the six rigid motions, and
balance R^T q = 0. Forces that elasticity requires and forces that contact and friction allow are
sought in turns, each drawn to the other, until they are the same (alternating directions).

How much a joint bears before it slips as a whole needs no elasticity: a load can be in balance
only if some forces that press and rub by no more than friction bears are in balance with it.

Sources: Wriggers, Computational Contact Mechanics (2006), section 5; Boyd et al., Distributed
optimization by the alternating direction method of multipliers (2011), section 3; Acary and
Brogliato, Numerical methods for nonsmooth dynamical systems (2008), section 13, for Coulomb's law
in it; VDI 2230 part 1 (2015) for the bolts. Held against CalculiX in
`tests/verify/test_bracket_contact.py`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from cardan.core.arrays import ArrayLike, FloatArray
from cardan.core.errors import ConvergenceError, DesignError
from cardan.core.status import StatusCallback
from cardan.core.units import Metre
from cardan.model.bracket import Bolts
from cardan.physics.fem.bracket_solid import MOUNT_FACE_NAME
from cardan.physics.fem.elasticity import ElasticSolid
from cardan.physics.fem.ngsolve_import import import_ngsolve
from cardan.physics.fem.unit_loads import UNIT_LOAD_NAMES

BOLT_HEAD_DIAMETER_RATIO = 1.45
"""Diameter a bolt's head bears on, over its hole's: M10, 16 mm across its flats, in 11 mm."""
CONTACT_RING_WIDTH_TO_HOLE_RATIO, _PARTS = 0.18, 10
"""Width of a ring of patches about a bolt, over its hole's diameter, and how many there are in it.

How far out a head's pressure reaches is what counts: a millimetre makes a flange a tenth softer.
"""
_COARSE = 0.5
"""Edge of a patch over a hole's diameter beyond a plate's thickness from the head.

There it rubs too: as a bracket sways nearly half of what bolts press comes to lie there, and
without friction there a joint was computed to slide at little more than half of what friction
bears.
"""
_STILL = 1e-6
"""Share of themselves that displacements may still move by: a thin sheet's floating have no more
digits, and contact needs fewer."""
_BATCH = 32
"""Unit forces solved at once: of 64 each takes a fifth less, and all half as much memory again."""
_STUCK = 0.05
"""What sticks gives by this share of what its patch gives by itself."""
_WAYS = 16
"""Ways along the plane in which a patch may rub at most; between two it is 2 % less."""
_ENDLESS = 3
"""Status of a linear programme without a limit."""
_FIRM, _TRIES = (0.05, 0.3, 2.0), (400, 400, 2000)
"""How firmly the two are drawn to each other, over what a patch gives by itself, and how often.

Loosely it settles fast where little slips; where nearly all does, firmly.
"""
_DRAWN = 1.7
"""How far, over just so far as to meet."""
_APART, _STEP = 1e-3, 1e-4
"""Share of all forces by which the two differ in the end, and by which they still move: stress is
then within 1 % of that after any number of tries."""
_HALVINGS = 7
"""By which the load is found that a joint bears, to a hundredth."""
_TELLS = 0.25
"""Share of what balance lets a joint bear, below which it is reported: contact bears 0.8 of it."""


@dataclass(frozen=True, kw_only=True)
class BoltedFlange:
    """A bracket's flange against its frame, condensed to the forces between them.

    Forces q are those of each patch: along two ways in the plane and out of it; then one on each
    bolt's head, and the nine unit loads.

    Attributes
    ----------
    compliance : (q, q)
        Of the floating bracket.
    rigid_body_work : (q, 6)
        Work of each force on the six rigid motions.
    stress : (q, places, 6) Pa
        At the places requested; in single precision, for there are many.
    bolt_axis : int
        Axis square to the plane.
    patch_areas : (patches,) m2
    frame_stiffness : N/m3
        Pressure over how far the frame gives under it: a hard one does not.
    elastic_frame_stiffness : N/m3
        That of a thick frame of the bracket's own metal.
    """

    compliance: FloatArray
    rigid_body_work: FloatArray
    stress: npt.NDArray[np.float32]
    bolt_axis: int
    bolt_count: int
    patch_areas: FloatArray
    elastic_frame_stiffness: float = np.inf
    frame_stiffness: float = np.inf

    @property
    def on_elastic_frame(self) -> "BoltedFlange":
        """The same on a thick frame that gives as its own metal does.

        A washer's pressure sinks a half space in by about what it would a bed of springs:
        p / w = 2 E / ((1 - nu^2) pi a) under a stiff disc of radius a. Source: Johnson, Contact
        Mechanics (1985), section 3.4.
        """
        return replace(self, frame_stiffness=self.elastic_frame_stiffness)

    @property
    def patch_count(self) -> int:
        """How many patches of the plane there are."""
        return len(self.patch_areas)

    def tighten(self, bolts: Bolts) -> "PreloadedFlange":
        """Return the joint with its bolts tightened, all at once, and nothing on the bearing.

        Friction counts here too: what heads squeeze out sideways rubs on the frame, and that keeps
        the flange from curling up about them. Without it a flange's edge stands off by two thirds
        more, and a load pushes that far before the edge bears.

        Raises
        ------
        ConvergenceError
            If its bolts cannot press it on: they lie in one line, say.
        """
        given = np.zeros(len(self.compliance))
        given[3 * self.patch_count + np.arange(self.bolt_count)] = bolts.preload
        start = np.zeros(3 * self.patch_count)
        start[2::3] = -bolts.preload
        settled = self.solve_contact(given, start, np.zeros_like(start), bolts.friction)
        if settled is None:
            msg = "the flange finds no rest against its frame: do its bolts lie in one line?"
            raise ConvergenceError(msg)
        return PreloadedFlange(
            flange=self, bolts=bolts, forces=settled[0], displacements=settled[1]
        )

    def solve_contact(
        self, given: FloatArray, start: FloatArray, asked: FloatArray, friction: float
    ) -> tuple[FloatArray, FloatArray] | None:
        """Return forces (q,) that press and rub under those given, and how all move (q,) m.

        `start` and `asked`, (3 patches,) N and m, as in `_settled`; None where none are found.
        """

        def allowed(force: FloatArray) -> FloatArray:
            each = force.reshape(-1, 3)
            presses = np.minimum(each[:, 2], 0.0)
            rub = np.hypot(each[:, 0], each[:, 1])
            share = np.minimum(1.0, -friction * presses / np.maximum(rub, 1e-300))
            return np.column_stack([share * each[:, 0], share * each[:, 1], presses]).ravel()

        return _settled(
            self._pulls, given, self.compliance, self.rigid_body_work, start=start, asked=asked,
            allowed=allowed,
        )  # fmt: skip

    @cached_property
    def contact_compliance(self) -> FloatArray:
        """What each force of a patch gives by itself, (3 patches,) m/N: a frame, what sticks."""
        gives = _STUCK * self._own.reshape(-1, 3)
        gives[:, 2] = 1 / (self.frame_stiffness * self.patch_areas)
        gives[:, :2] += gives[:, 2:]
        return gives.ravel()

    @cached_property
    def _own(self) -> FloatArray:
        """How far each patch moves under its own forces, (3 patches,) m/N."""
        own = np.diagonal(self.compliance)[: 3 * self.patch_count].reshape(-1, 3).copy()
        # Alike both ways, or friction would turn its force.
        own[:, :2] = own[:, :2].mean(axis=1, keepdims=True)
        return own.ravel()

    @cached_property
    def _pulls(self) -> list["_SelfEquilibratedLoads"]:
        return [
            _SelfEquilibratedLoads.of(
                self.compliance, self.rigid_body_work, self.contact_compliance, firm * self._own
            )
            for firm in _FIRM
        ]


@dataclass(frozen=True, kw_only=True)
class PreloadedFlange:
    """A tightened joint: forces (q,) N, and how they move (q,) m."""

    flange: BoltedFlange
    forces: FloatArray
    displacements: FloatArray
    bolts: Bolts

    def added_forces(self, loads: ArrayLike) -> FloatArray:
        """Return the forces (q,) N that loads (9,) add to those of tightening.

        Raises
        ------
        ConvergenceError
            If no forces that press and rub bear the loads: it slips or opens.
        """
        of = self.flange
        given = self.forces.copy()
        mine = slice(3 * of.patch_count)
        given[mine] = 0.0
        given[-len(UNIT_LOAD_NAMES) :] = loads
        asked = (
            self.displacements[mine] + of.contact_compliance * self.forces[mine]
        )  # what sticks, where it was left
        asked[2::3] = 0.0
        settled = of.solve_contact(given, self.forces[mine], asked, self.bolts.friction)
        if settled is None:
            msg = (
                f"no contact between flange and frame bears {np.round(np.asarray(loads)[:3])} N "
                f"with bolts of {self.bolts.preload:.4g} N: they slip or open; tighten them, or "
                "use more"
            )
            raise ConvergenceError(msg)
        return settled[0] - self.forces

    def slip_utilisation(self, loads: ArrayLike) -> tuple[float, FloatArray]:
        """Return what share loads (9,) are of those along them under which it slips or opens.

        If balance bears more than four times as much that is reported, which may be 0.8 of the
        truth; else the load is found under which there is no contact.

        Returns
        -------
        share
            Above 1 it slides or opens; 0 where no multiple does it.
        plane : (9,) per load
            By balance no other loads have a share below `plane @ loads`.
        """
        loads = np.asarray(loads, dtype=float)
        least, plane = self.equilibrium_slip_utilisation(loads)
        if least < _TELLS:
            return least, plane
        low, high = 0.0, 1 / least
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            try:
                self.added_forces(middle * loads)
            except ConvergenceError:
                high = middle
            else:
                low = middle
        return 2 / (low + high), plane

    def equilibrium_slip_utilisation(self, loads: ArrayLike) -> tuple[float, FloatArray]:
        """Return what share loads (9,) are of the largest along them that can be in balance.

        Bolts' forces stay. The largest factor by which loads can be multiplied and still be in
        balance with some forces that press, and rub by no more than that bears, is a linear
        programme. What really presses may bear less, never more.

        Returns
        -------
        share
            Above 1 the joint slides or opens; 0 where no multiple does it.
        plane : (9,) per load
            No other loads have a share below `plane @ loads`.

        Raises
        ------
        ConvergenceError
            If the programme finds no solution.
        """
        from scipy.optimize import linprog

        of, n = self.flange, self.flange.patch_count
        loads = np.asarray(loads, dtype=float)
        work = of.rigid_body_work[: 3 * n].reshape(n, 3, 6)
        angle = 2 * np.pi * np.arange(_WAYS) / _WAYS
        along = self.bolts.friction * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        rubbed = np.einsum("wk,pkr->pwr", along, work[:, :2]) - work[:, 2][:, None]
        rays = rubbed.reshape(-1, 6)
        heads = slice(3 * n, 3 * n + of.bolt_count)
        unit, whole = of.rigid_body_work[-len(UNIT_LOAD_NAMES) :], float(self.forces[heads].sum())
        # In shares of all bolts' force, and moments over the arms that there are.
        size = np.maximum(np.abs(rays).max(axis=0), 1e-12)
        load = unit.T @ loads / whole / size
        if not load.any():
            return 0.0, np.zeros(len(UNIT_LOAD_NAMES))
        found = linprog(
            np.append(np.zeros(len(rays)), -1.0),
            A_eq=np.column_stack([(rays / size).T, load]),
            b_eq=-(of.rigid_body_work[heads].T @ self.forces[heads]) / whole / size,
        )
        if found.status == _ENDLESS:
            return 0.0, np.zeros(len(UNIT_LOAD_NAMES))
        if found.status:
            msg = f"the load that bolts bear could not be found: {found.message}"
            raise ConvergenceError(msg)
        share = 1 / max(-(found.fun or 0.0), 1e-9)
        return share, -share * unit @ (found.eqlin.marginals / size) / whole


class _SelfEquilibratedLoads(NamedTuple):
    """Forces (k,) N in balance that elasticity requires, drawn towards others."""

    firm: FloatArray
    inverse: FloatArray
    """(k + m, k + m): of balance, and of what the forces give."""

    @classmethod
    def of(
        cls,
        compliance: FloatArray,
        rigid: FloatArray,
        gives: FloatArray,
        firm: FloatArray,
    ) -> "_SelfEquilibratedLoads":
        """Return it for the first (k,) forces, that give (k,) m/N, drawn by `firm` (k,) m/N."""
        k, m = len(gives), rigid.shape[1]
        system = np.zeros((k + m, k + m))
        system[:k, :k] = compliance[:k, :k] + np.diag(gives + firm)
        system[:k, k:], system[k:, :k] = rigid[:k], rigid[:k].T
        return cls(firm, np.asarray(np.linalg.inv(system), dtype=float))


def _settled(
    pulls: Sequence[_SelfEquilibratedLoads],
    given: FloatArray,
    compliance: FloatArray,
    rigid: FloatArray,
    *,
    start: FloatArray,
    asked: FloatArray,
    allowed: Callable[[FloatArray], FloatArray],
) -> tuple[FloatArray, FloatArray] | None:
    """Return forces (q,) that contact allows, in balance, and how all move (q,).

    The first (k,) come on top of the `given` (q,); `start` (k,) is where to begin, and
    where they stand is `asked` (k,) m of them. None where none are found.
    """
    k = len(asked)
    right = np.concatenate([asked - compliance[:k] @ given, -rigid.T @ given])
    to, debt = start, np.zeros(k)
    for pull, tries in zip(pulls, _TRIES, strict=True):
        # Of the larger firmness the same debt is a smaller force.
        debt = debt * (pulls[0].firm / pull.firm)
        constant = pull.inverse @ right
        gain = pull.inverse[:, :k] * pull.firm
        for _ in range(tries):
            found = constant + gain @ (to - debt)
            drawn = _DRAWN * found[:k] + (1 - _DRAWN) * to
            before, to = to, allowed(drawn + debt)
            debt = debt + drawn - to
            size = np.abs(to).sum()
            apart = np.abs(found[:k] - to).sum()
            moved = np.abs(to - before).sum()
            if not np.isfinite(apart):
                return None
            if apart <= _APART * size and moved <= _STEP * size:
                forces = given.copy()
                forces[:k] += to
                return forces, compliance @ forces + rigid @ found[k:]
        debt = debt * (pull.firm / pulls[0].firm)
    return None


# --------------------------------------------------------------------------- condensing


def contact_force_count(*, hole: Metre, thickness: Metre, bolts: int, plane: float) -> float:
    """Return about how many forces there will be between a flange and its frame.

    `hole` is its bolts' diameter, `plane` the surface m² of it beyond their washers.
    """
    rings = np.ceil(
        ((BOLT_HEAD_DIAMETER_RATIO - 1) * hole / 2 + thickness)
        / (CONTACT_RING_WIDTH_TO_HOLE_RATIO * hole)
    )
    return float(
        3 * (bolts * rings * _PARTS + plane / (_COARSE * hole) ** 2) + bolts + len(UNIT_LOAD_NAMES)
    )


def condense_bracket_to_flange_contact(
    held: ElasticSolid,
    loads: FloatArray,
    *,
    bolts: tuple[str, ...],
    upright: int,
    thickness: Metre,
    read: Callable[[FloatArray], FloatArray],
    tell: StatusCallback,
) -> BoltedFlange:
    """Condense a bracket to the forces between flange and frame.

    Parameters
    ----------
    held
        The solid, however it is held: here it floats.
    loads : (9, unknowns)
        The unit loads.
    bolts, upright, thickness
        Names of the rings, the axis square to their plane, and of the flange.
    read
        From displacements (c, unknowns) to stress (places, c, 6) Pa where it is evaluated.

    Raises
    ------
    DesignError
        If no face lies under a bolt's head.
    """
    from scipy.sparse import csr_array, vstack

    rounds = _rounds(held, bolts, upright)
    patches, area = _patches(held, rounds, bolts, upright, thickness)
    heads = _heads(held, rounds, upright, thickness)
    forces = csr_array(vstack([patches, csr_array(np.concatenate([heads, loads]))]))
    body, rigid = held.with_isostatic_supports(), np.asarray(forces @ held.rigid.T)
    # Each force with what its own mass would feel, so that it is in balance by itself: else three
    # points bear it, and what a patch gives is mostly how the sheet moves about them. Forces in
    # balance leave none of that.
    heavy = np.stack([held.mass_times(motion) for motion in held.rigid])
    felt = rigid @ np.linalg.inv(heavy @ held.rigid.T)
    count = forces.shape[0]
    tell(f"solving for {count} forces between flange and frame")
    compliance, stress = np.zeros((count, count)), np.zeros((count, 0, 6), dtype=np.float32)
    for start in range(0, count, _BATCH):
        some = slice(start, start + _BATCH)
        moved = body.solve(forces[some].toarray() - felt[some] @ heavy, still=_STILL)
        compliance[some] = np.asarray(forces @ moved.T).T - moved @ heavy.T @ felt.T
        told = read(moved).swapaxes(0, 1)
        if not stress.size:
            stress = np.zeros((count, *told.shape[1:]), dtype=np.float32)
        stress[some] = told
    metal, washer = held.material, 2 * max(r.radius for r in rounds)
    return BoltedFlange(
        compliance=compliance,
        rigid_body_work=rigid,
        stress=stress,
        bolt_axis=upright,
        bolt_count=len(bolts),
        patch_areas=area,
        elastic_frame_stiffness=2
        * metal.youngs_modulus
        / ((1 - metal.poisson**2) * np.pi * washer),
    )


class _BoltHole(NamedTuple):
    """Where a bolt goes through: its axis on the plane (3,) m, its hole's radius, which way out."""

    place: FloatArray
    radius: Metre
    out: float


def _rounds(held: ElasticSolid, bolts: tuple[str, ...], upright: int) -> list[_BoltHole]:
    nodes = held.nodes
    corners = nodes.points[nodes.faces[:, :3]]
    square = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, upright]
    found: list[_BoltHole] = []
    for bolt in bolts:
        mine = nodes.face_names == bolt
        ring = nodes.points[np.unique(nodes.faces[mine])]
        place = (ring.min(axis=0) + ring.max(axis=0)) / 2
        radius = float(np.linalg.norm(ring - place, axis=1).min())
        found.append(_BoltHole(place, radius, float(np.sign(square[mine].sum()))))
    return found


def _patches(
    held: ElasticSolid,
    rounds: Sequence[_BoltHole],
    bolts: tuple[str, ...],
    upright: int,
    thickness: Metre,
) -> tuple[Any, FloatArray]:
    """Return unit forces on patches of the plane, sparse (3 patches, unknowns), and their areas m².

    A patch is made of whole triangles of the mesh, near a bolt in rings about it.
    """
    from scipy.sparse import coo_array, csr_array

    ngs = import_ngsolve().ngs
    names = [*bolts, *({MOUNT_FACE_NAME} & set(held.mesh.GetBoundaries()))]
    functions, flat = ngs.H1(held.mesh, order=held.degree), ngs.SurfaceL2(held.mesh, order=0)
    u, v = flat.TrialFunction(), functions.TestFunction()
    form = ngs.BilinearForm(trialspace=flat, testspace=functions)
    form += u.Trace() * v.Trace() * ngs.ds("|".join(names))
    rows, columns, values = (np.array(part) for part in form.Assemble().mat.COO())
    spread = csr_array((values, (rows, columns)), shape=(functions.ndof, flat.ndof))
    triangles = [e for e in held.mesh.Elements(ngs.BND) if e.mat in names]
    own = np.array([flat.GetDofNrs(ngs.ElementId(ngs.BND, e.nr))[0] for e in triangles])
    middle = np.array([
        np.mean([held.mesh[c].point for c in e.vertices], axis=0) for e in triangles
    ])  # fmt: skip
    ways = [k for k in range(3) if k != upright]
    off = (middle[:, None] - np.stack([r.place for r in rounds]))[..., ways]
    away = np.linalg.norm(off, axis=-1)
    near = away.argmin(axis=1)
    hole = np.array([2 * r.radius for r in rounds])[near]
    away, off = away.min(axis=1), off[np.arange(len(near)), near]
    ring = np.floor((away - hole / 2) / (CONTACT_RING_WIDTH_TO_HOLE_RATIO * hole))
    angle = (np.arctan2(off[:, 1], off[:, 0]) / (2 * np.pi) + 0.5) % 1.0
    near_head = away < BOLT_HEAD_DIAMETER_RATIO * hole / 2 + thickness
    cells = np.floor(middle[:, ways] / (_COARSE * hole[:, None]))
    keys = np.where(
        near_head[:, None],
        np.column_stack([near, ring, np.floor(angle * _PARTS)]),
        np.column_stack([np.full(len(near), -1), cells]),
    )
    patches, patch = np.unique(keys, axis=0, return_inverse=True)
    belongs = csr_array(
        (np.ones(len(own)), (own, patch.ravel())), shape=(flat.ndof, len(patches))
    )  # fmt: skip
    each: Any = csr_array((spread @ belongs).T)
    # Functions of corners add up to 1: their share is the patch's area.
    area = np.asarray(each[:, : held.mesh.nv].sum(axis=1), dtype=float).ravel()
    each = each.tocoo()
    value = each.data / area[each.row]
    axes, way = (*ways, upright), np.arange(3)[:, None]
    pushes = value * np.where(way == 2, rounds[0].out, 1.0)
    places = 3 * each.row + way, 3 * each.col + np.array(axes)[:, None]
    forces = coo_array(
        (pushes.ravel(), tuple(place.ravel() for place in places)),
        shape=(3 * len(patches), 3 * functions.ndof),
    )  # fmt: skip
    return forces, area


def _heads(
    held: ElasticSolid, rounds: Sequence[_BoltHole], upright: int, thickness: Metre
) -> FloatArray:
    """Return the forces (bolts, unknowns) of bolts' heads of unit force, out to the frame."""
    ngs = import_ngsolve().ngs
    place = (ngs.x, ngs.y, ngs.z)
    square = ngs.specialcf.normal(3)[upright]
    found: list[FloatArray] = []
    for k, bolt in enumerate(rounds, 1):
        across = sum(
            (place[a] - float(bolt.place[a])) ** 2 for a in range(3) if a != upright
        )  # fmt: skip
        below = bolt.out * (float(bolt.place[upright]) - place[upright])
        on = ngs.IfPos((BOLT_HEAD_DIAMETER_RATIO * bolt.radius) ** 2 - across, 1, 0)
        on *= ngs.IfPos(across - (0.98 * bolt.radius) ** 2, 1, 0)
        on *= ngs.IfPos(below - 0.3 * thickness, 1, 0) * ngs.IfPos(2 * thickness - below, 1, 0)
        on *= ngs.IfPos(-0.7 - bolt.out * square, 1, 0)
        v = held.space.TestFunction()
        load = held.assemble_load(
            ngs.LinearForm(bolt.out * on * v[upright] * ngs.ds(".*", bonus_intorder=12))
        )
        force = bolt.out * float(load @ held.rigid[upright])
        if not force > 0:
            msg = f"no face for the head of bolt {k}, opposite to the frame, within 2 thicknesses"
            raise DesignError(msg, about="bracket.bolts")
        found.append(load / force)
    return np.stack(found)
