"""A flange in its bolts: what presses stays, what is pulled lifts off, what is pressed rubs.

The frame is a rigid plane that only pushes. Bolts press the flange against it by their heads,
each with a force that stays: as long as a joint does not open, its bolt hardly feels what comes
on top. Flange and frame rub by Coulomb's law, from the tightened state on.

The bracket floats: held at three points, so that forces in balance leave no reaction. Unit
forces on patches of the plane, on the heads' faces and on the bearing are solved once; all that
follows is small and dense: u = C q + R a, with q the forces, a the six rigid motions, and
balance R^T q = 0. Which patches press, and which slip, is found by trying (active sets).

Sources: Wriggers, Computational Contact Mechanics (2006), sections 5.3 and 10; VDI 2230 part 1
(2015) for the bolts. Held against CalculiX in `tests/verify/test_bracket_contact.py`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cardan.base.arrays import ArrayLike, BoolArray, FloatArray
from cardan.base.errors import DesignError, NotConverged
from cardan.base.units import Metre
from cardan.bracket.elastic import Elastic, IntArray, Progress
from cardan.bracket.engine import engine
from cardan.bracket.shape import MOUNT
from cardan.bracket.unit import UNITS
from cardan.model.bracket import Bolts

HEAD = 1.45
"""Diameter a bolt's head bears on, over its hole's: M10, 16 mm across its flats, in 11 mm."""
PATCH, _PARTS = 0.18, 10
"""Width of a ring of patches about a bolt, over its hole's diameter, and how many there are in it.

How far out a head's pressure reaches is what counts: a millimetre makes a flange a tenth softer.
"""
_COARSE = 1.25
"""Edge of a patch over a hole's diameter beyond a plate's thickness from the head: there it rubs
no more."""
_BATCH = 9
"""Unit forces solved at once."""
_STUCK = 0.05
"""What sticks gives by this share of what its patch gives by itself."""
_SAME = 0.02
"""Share by which the flange may rub more than its friction bears, before it is tried again."""
_NIL = 1e-3
"""Share of all pressure that may pull where a patch presses, or is lacking where one lifts off."""
_TRIES, _ALL = 200, 20
"""Tries at most, and up to which all patches change at once that are wrong."""


@dataclass(frozen=True, kw_only=True)
class Joint:
    """A bracket's flange against its frame, condensed to the forces between them.

    Forces q are those of each patch: along two ways in the plane and out of it; then one on each
    bolt's head, and the nine unit loads.

    Attributes
    ----------
    compliance : (q, q)
        Of the floating bracket.
    rigid : (q, 6)
        Work of each force on the six rigid motions.
    rubs : (patches,)
        Whether a patch has forces along the plane: those far from bolts only push.
    stress : (places, q, 6) Pa
        At the places that were asked for.
    upright : int
        Axis square to the plane.
    """

    compliance: FloatArray
    rigid: FloatArray
    rubs: BoolArray
    stress: FloatArray
    upright: int
    bolts: int

    @property
    def patches(self) -> int:
        """How many patches of the plane there are."""
        return len(self.rubs)

    def tightened(self, bolts: Bolts) -> "Tight":
        """Return the joint with its bolts tightened: no friction, nothing on the bearing."""
        q = np.zeros(len(self.compliance))
        heads = 3 * self.patches + np.arange(self.bolts)
        q[heads] = bolts.preload
        # Without friction nothing holds it along the plane, and nothing pushes it there.
        up = self.upright
        free = [up, *(3 + k for k in range(3) if k != up)]
        forces, moved, pressed = _pressed(
            q, self.compliance, self.rigid[:, free], normal=3 * np.arange(self.patches) + 2
        )
        return Tight(joint=self, forces=forces, moved=moved, pressed=pressed, bolts=bolts)


@dataclass(frozen=True, kw_only=True)
class Tight:
    """A tightened joint: forces (q,) N, how they move (q,) m, which patches press (patches,)."""

    joint: Joint
    forces: FloatArray
    moved: FloatArray
    pressed: BoolArray
    bolts: Bolts

    def under(self, loads: ArrayLike) -> FloatArray:
        """Return the forces (q,) N that loads (9,) add to those of tightening.

        What presses sticks as by a stiff spring, which yields where it would rub by more than
        friction times its pressure: its stiffness is that of the chord, found by going on.

        Raises
        ------
        NotConverged
            If no set of patches that press, stick and slip bears the loads.
        """
        of, n = self.joint, self.joint.patches
        given = self.forces.copy()
        given[: 3 * n] = 0.0
        given[-len(UNITS) :] = loads
        own = np.diagonal(of.compliance)[: 3 * n].reshape(n, 3)
        least = _STUCK * own[:, :2].mean(axis=1)
        pressed, gives = self.pressed, least
        for tried in range(_TRIES):
            normal = 3 * np.flatnonzero(pressed) + 2
            stuck = np.flatnonzero(pressed & of.rubs)
            flat = (3 * stuck[:, None] + [0, 1]).ravel()
            forces, moved = _balanced(
                given, of.compliance, of.rigid, np.concatenate([normal, flat]),
                asked=np.concatenate([np.zeros(len(normal)), self.moved[flat]]),
                gives=np.concatenate([np.zeros(len(normal)), np.repeat(gives[stuck], 2)]),
            )  # fmt: skip
            each = forces[: 3 * n].reshape(n, 3)
            still = np.where(pressed, each[:, 2] < 0, moved[2 : 3 * n : 3] > 0)
            rub = np.linalg.norm(each[:, :2], axis=1)
            bears = self.bolts.friction * np.maximum(-each[:, 2], 0.0)
            over = float(np.maximum(rub - bears, 0.0).sum())
            off = np.where(pressed, each[:, 2], moved[2 : 3 * n : 3] / own[:, 2])
            wrong = float(off[still != pressed].sum())
            if wrong <= _NIL * np.abs(each[:, 2]).sum() and over <= _SAME * rub.sum():
                return forces - self.forces
            pressed = _flipped(pressed, still, off, tried)
            by = rub / np.maximum(bears, 1e-3 * rub + 1e-300)
            yields = np.maximum(least, gives * (by if tried < _ALL else np.sqrt(by)))
            gives = np.where(pressed, yields, gives)
        msg = (
            f"no contact between flange and frame bears {np.round(np.asarray(loads)[:3])} N with "
            f"bolts of {self.bolts.preload:.4g} N: they slip or open; tighten them, or use more"
        )
        raise NotConverged(msg)


def _pressed(
    given: FloatArray, compliance: FloatArray, rigid: FloatArray, *, normal: IntArray
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Press against a plane without friction: gap >= 0, force <= 0, one of them nil.

    A linear complementarity problem. Return forces and motion (q,), and which of the forces
    `normal` (k,) press.
    """
    pressed = np.ones(len(normal), dtype=bool)
    for tried in range(_TRIES):
        nil = np.zeros(int(pressed.sum()))
        forces, moved = _balanced(given, compliance, rigid, normal[pressed], asked=nil, gives=nil)
        still = np.where(pressed, forces[normal] < 0, moved[normal] > 0)
        if (still == pressed).all():
            return forces, moved, pressed
        own = np.diagonal(compliance)[normal]
        off = np.where(pressed, forces[normal], moved[normal] / own)
        pressed = _flipped(pressed, still, off, tried)
    msg = "the flange finds no rest against its frame: do its bolts lie in one line?"
    raise NotConverged(msg)


def _flipped(pressed: BoolArray, still: BoolArray, off: FloatArray, tried: int) -> BoolArray:
    """Return which patches press next: all that are wrong change, or they may go round for ever.

    After `_ALL` tries only the one changes that is furthest `off`, N.
    """
    wrong = still != pressed
    if tried < _ALL or not wrong.any():
        return still
    worst = np.zeros_like(wrong)
    worst[int(np.where(wrong, np.abs(off), -1.0).argmax())] = True
    return pressed ^ worst


def _balanced(
    given: FloatArray,
    compliance: FloatArray,
    rigid: FloatArray,
    rows: IntArray,
    *,
    asked: FloatArray,
    gives: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return forces (q,), in balance, that move `rows` as asked or yield, and how all move (q,).

    Those of the rows come on top of the given ones; each yields by its `gives` (rows,) m/N.
    """
    k, m = len(rows), rigid.shape[1]
    system = np.zeros((k + m, k + m))
    system[:k, :k], system[:k, k:] = compliance[np.ix_(rows, rows)] + np.diag(gives), rigid[rows]
    system[k:, :k] = rigid[rows].T
    right = np.concatenate([asked - compliance[rows] @ given, -rigid.T @ given])
    try:
        found = np.linalg.solve(system, right)
    except np.linalg.LinAlgError as error:
        msg = "the flange comes off its frame: tighten its bolts, or use more"
        raise NotConverged(msg) from error
    forces = given.copy()
    forces[rows] += found[:k]
    return forces, compliance @ forces + rigid @ found[k:]


# --------------------------------------------------------------------------- condensing


def condensed(
    held: Elastic,
    loads: FloatArray,
    *,
    bolts: tuple[str, ...],
    upright: int,
    thickness: Metre,
    read: Callable[[FloatArray], FloatArray],
    tell: Progress,
) -> Joint:
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
        From displacements (c, unknowns) to stress (places, c, 6) Pa where it is asked.

    Raises
    ------
    DesignError
        If no face lies under a bolt's head.
    """
    from scipy.sparse import csr_array

    rounds = _rounds(held, bolts, upright)
    patches, rubs = _patches(held, rounds, bolts, upright, thickness)
    heads = _heads(held, rounds, upright, thickness)
    forces = csr_array(np.concatenate([patches, heads, loads]))
    body = held.floating()
    # A patch that does not rub has no forces along the plane.
    rub = np.repeat(rubs, 3) | (np.arange(3 * len(rubs)) % 3 == 2)
    used = np.flatnonzero(np.pad(rub, (0, len(heads) + len(loads)), constant_values=True))
    tell(f"solving for {len(used)} forces between flange and frame")
    count = forces.shape[0]
    compliance, stress = np.zeros((count, count)), np.zeros((0, count, 6))
    for start in range(0, len(used), _BATCH):
        some = used[start : start + _BATCH]
        moved = body.solve(forces[some].toarray())
        compliance[some] = np.asarray(forces @ moved.T).T
        told = read(moved)
        stress = stress if len(stress) else np.zeros((len(told), count, 6))
        stress[:, some] = told
    return Joint(
        compliance=compliance, rigid=np.asarray(forces @ held.rigid.T), rubs=rubs, stress=stress,
        upright=upright, bolts=len(bolts),
    )  # fmt: skip


class _Round(NamedTuple):
    """Where a bolt goes through: its axis on the plane (3,) m, its hole's radius, which way out."""

    place: FloatArray
    radius: Metre
    out: float


def _rounds(held: Elastic, bolts: tuple[str, ...], upright: int) -> list[_Round]:
    nodes = held.nodes
    corners = nodes.points[nodes.faces[:, :3]]
    square = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, upright]
    found: list[_Round] = []
    for bolt in bolts:
        mine = nodes.face_names == bolt
        ring = nodes.points[np.unique(nodes.faces[mine])]
        place = (ring.min(axis=0) + ring.max(axis=0)) / 2
        radius = float(np.linalg.norm(ring - place, axis=1).min())
        found.append(_Round(place, radius, float(np.sign(square[mine].sum()))))
    return found


def _patches(
    held: Elastic,
    rounds: Sequence[_Round],
    bolts: tuple[str, ...],
    upright: int,
    thickness: Metre,
) -> tuple[FloatArray, BoolArray]:
    """Return unit forces (3 patches, unknowns) spread over patches of the plane, and which rub.

    A patch is made of whole triangles of the mesh, near a bolt in rings about it.
    """
    from scipy.sparse import csr_array

    ngs = engine().ngs
    names = [*bolts, *({MOUNT} & set(held.mesh.GetBoundaries()))]
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
    ring = np.floor((away - hole / 2) / (PATCH * hole))
    angle = (np.arctan2(off[:, 1], off[:, 0]) / (2 * np.pi) + 0.5) % 1.0
    rubs = away < HEAD * hole / 2 + thickness
    cells = np.floor(middle[:, ways] / (_COARSE * hole[:, None]))
    keys = np.where(
        rubs[:, None],
        np.column_stack([near, ring, np.floor(angle * _PARTS)]),
        np.column_stack([np.full(len(near), -1), cells]),
    )
    _, first, patch = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    belongs = csr_array(
        (np.ones(len(own)), (own, patch.ravel())), shape=(flat.ndof, len(first))
    )  # fmt: skip
    each = (spread @ belongs).toarray().T
    # Functions of corners add up to 1: their share is the patch's area.
    each /= each[:, : held.mesh.nv].sum(axis=1, keepdims=True)
    forces = np.zeros((len(first), 3, each.shape[1], 3))
    for k, axis in enumerate((*ways, upright)):
        forces[:, k, :, axis] = each * (rounds[0].out if k == 2 else 1.0)
    return forces.reshape(3 * len(first), -1), rubs[first]


def _heads(held: Elastic, rounds: Sequence[_Round], upright: int, thickness: Metre) -> FloatArray:
    """Return the forces (bolts, unknowns) of bolts' heads of unit force, out to the frame."""
    ngs = engine().ngs
    place = (ngs.x, ngs.y, ngs.z)
    square = ngs.specialcf.normal(3)[upright]
    found: list[FloatArray] = []
    for k, bolt in enumerate(rounds, 1):
        across = sum(
            (place[a] - float(bolt.place[a])) ** 2 for a in range(3) if a != upright
        )  # fmt: skip
        below = bolt.out * (float(bolt.place[upright]) - place[upright])
        on = ngs.IfPos((HEAD * bolt.radius) ** 2 - across, 1, 0)
        on *= ngs.IfPos(across - (0.98 * bolt.radius) ** 2, 1, 0)
        on *= ngs.IfPos(below - 0.3 * thickness, 1, 0) * ngs.IfPos(2 * thickness - below, 1, 0)
        on *= ngs.IfPos(-0.7 - bolt.out * square, 1, 0)
        v = held.space.TestFunction()
        load = held.assembled(
            ngs.LinearForm(bolt.out * on * v[upright] * ngs.ds(".*", bonus_intorder=12))
        )
        force = bolt.out * float(load @ held.rigid[upright])
        if not force > 0:
            msg = f"no face for the head of bolt {k}, opposite to the frame, within 2 thicknesses"
            raise DesignError(msg, about="bracket.bolts")
        found.append(load / force)
    return np.stack(found)
