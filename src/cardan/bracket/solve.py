"""From a bracket's drawing to plain arrays: everything its study needs of the finite elements.

The work is done in a process of its own (`cardan.bracket.apart`), after an estimate of what
it takes, and with smaller welds and fillets where the CAD kernel breaks on those drawn.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.errors import DesignError
from cardan.base.units import Metre, mm
from cardan.bracket.afar import too_high, too_stiff
from cardan.bracket.apart import Crashed, Stopped, apart
from cardan.bracket.elastic import IntArray, Nodes, Progress, silent
from cardan.bracket.estimate import MEMORY, MINUTES, Estimate, Model, affordable, triangles
from cardan.bracket.gauges import influence, misplaced
from cardan.bracket.joint import PATCH, Joint, condensed, forces_of
from cardan.bracket.refine import (
    LEVELS,
    Problem,
    Refined,
    Solution,
    refined,
    telling,
)  # fmt: skip
from cardan.bracket.shape import MOUNT, WASHER, Picked, Solid, longest_on, round_off, solid
from cardan.bracket.stress import superpose, von_mises
from cardan.bracket.unit import UNITS, Units, unit_loads
from cardan.bracket.zones import Zones
from cardan.model.bracket import ZONES, Gauge, Hold, Shape, StepShape, Vector
from cardan.model.material import Material
from cardan.model.seat import LOSS, Seat

MODES = 6
OWN = 3
"""Modes by which a bracket swings beyond statics: orders of the shaft reach none of them."""
_HIGH = 0.6
"""Share of a feature's highest stress above which a place of it may be the worst in contact."""
_READ, _AFFORDED = 2, 150_000
"""Meshes on which gauges that forces rest on are read by elements of a degree more, and unknowns
beyond which they are not: about 1.3 GB."""
_FORCES = (0, 1, 2)
"""Of the unit loads those of which gauges say what a mesh still changed."""
_SMALLER = (0.7, 0.45)
"""Shares of the drawn fillet that are tried, one after the other."""


@dataclass(frozen=True, kw_only=True)
class Task:
    """What is asked of the finite elements.

    Attributes
    ----------
    cases : ((t, 9), ...)
        Load histories under which maxima are sought.
    weights
        How much a stress weighs in each of `ZONES` when the mesh is made finer.
    """

    shape: Shape
    material: Material
    cases: tuple[FloatArray, ...]
    weights: tuple[float, ...] = (1.0,) * len(ZONES)
    element: Metre | None = None
    order: int = 2
    gauges: tuple[Gauge, ...] = ()
    carried_mass: float = 0.0
    rubber: Vector | None = None
    loss: float = LOSS
    levels: int = LEVELS
    """Meshes at most."""
    bolted: bool = False
    """Whether its flange's contact with the frame is condensed."""
    reads: bool = False
    """Whether forces are read back from its gauges."""


@dataclass(frozen=True, kw_only=True)
class Swing:
    """How a bracket swings in modes of its own, of unit modal mass, k of them.

    Attributes
    ----------
    seat : Seat
        What it gives under the bearing; made of unit forces and of these modes.
    unit : (places, k, 6) Pa kg^-1/2
    reactions : (bolts, k, 3) N kg^-1/2
    influence : (gauges, k) kg^-1/2
    """

    seat: Seat
    unit: FloatArray
    reactions: FloatArray
    influence: FloatArray


@dataclass(frozen=True, kw_only=True)
class Held:
    """A bracket held in one of two ways, under its unit loads (`cardan.bracket.unit.UNITS`).

    Attributes
    ----------
    unit : (places, 9, 6) Pa
        Stress that counts at each place of `zones`.
    compliance : (6, 6) m/N, rad/(N m)
        Mean motion of the seat under forces and moments.
    reactions : (bolts, 9, 3) N
        Force each bolt takes from the frame; where the whole plane is held, its share alone.
    frequencies, carried : Hz
        Natural frequencies, six by itself and with what it carries; of the clamped flange
        three and two.
    bends : (k,) 1
        Share of the energy of each mode with what it carries that bends it, and no rubber.
    too_high : (k,) 1
        Share by which the natural frequencies by itself may be above those of finer elements; of
        the clamped flange nobody asks it.
    too_stiff : (3,) 1
        The same of the stiffness against each force; of the clamped flange neither.
    influence : (gauges, 9)
        Strain of each gauge.
    unsure : (gauges, 3) 1/N
        Strain by which each gauge may read a unit force wrong, where forces are read from them.
    swing : Swing
        What comes on top where it is shaken.
    """

    hold: Hold
    zones: Zones
    unit: FloatArray
    compliance: FloatArray
    reactions: FloatArray
    frequencies: FloatArray
    carried: FloatArray
    bends: FloatArray
    too_high: FloatArray
    too_stiff: FloatArray
    influence: FloatArray
    unsure: FloatArray
    swing: Swing


@dataclass(frozen=True, kw_only=True)
class Bolted:
    """A flange's joint with its frame, and where its stress is read: `places` of each way held."""

    joint: Joint
    places: tuple[IntArray, ...]


@dataclass(frozen=True, kw_only=True)
class Solved:
    """A bracket solved: what is left of it when the process that did it is gone.

    Attributes
    ----------
    displacement : (n, 9, 3) m, stress : (n, 9, 6) Pa
        At the nodes, the flange sliding: for pictures and files.
    sliding, clamped
        The two ways its flange is held, which have the truth between them.
    error
        Share of the highest stress of each feature (kind, number) that its error may be.
    influence_change : float
        Largest change by refining of what a gauge reads of a force, over the largest of all such
        readings.
    unknowns, meshes
        Of the last mesh; how many were made.
    fillet : (m, m)
        As it is drawn, and as it was solved with where the CAD kernel breaks on that.
    found
        What a STEP file had where faces were picked.
    bolted : Bolted
        Its flange in its bolts; None where that was not asked.
    expected
        What was estimated beforehand.
    """

    nodes: Nodes
    thickness: Metre
    mass: float
    displacement: FloatArray
    stress: FloatArray
    sliding: Held
    clamped: Held
    error: dict[tuple[int, int], float]
    influence_change: float
    unknowns: int
    meshes: int
    expected: Estimate
    fillet: tuple[Metre, Metre] | None = None
    found: tuple[Picked, ...] = ()
    bolted: Bolted | None = None

    @property
    def both(self) -> tuple[Held, Held]:
        """The two ways it is held."""
        return self.sliding, self.clamped

    @cached_property
    def on_surface(self) -> tuple[FloatArray, FloatArray]:
        """Stress (surface nodes, 9, 6) Pa, the flange sliding; how much each load does, (9,)."""
        stress = self.stress[self.nodes.surface]
        return stress, np.sqrt(np.mean(stress**2, axis=(0, 2)))


def solved_apart(task: Task, *, tell: Progress) -> Solved:
    """Solve a bracket in a process of its own, with smaller fillets where it must.

    Raises
    ------
    DesignError
        If it cannot be built, meshed or afforded; with each way that was tried.
    """
    tried: list[str] = []
    for shape in _ways(task.shape):
        fillet = (_fillet(task.shape), _fillet(shape))
        try:
            found = apart(
                solve, replace(task, shape=shape), tell=tell,
                memory=MEMORY, seconds=60 * MINUTES,
            )  # fmt: skip
        except Stopped as error:  # which no smaller fillet mends
            msg = f"solving this bracket was stopped: {error}; a larger `element_mm` takes less"
            raise DesignError(msg, about="bracket") from None
        except Crashed as error:
            tried.append(f"fillet {fillet[1] / mm:.3g} mm: {error}" if fillet[1] else str(error))
            tell(f"the CAD kernel or the mesher broke ({error}); trying again")
            continue
        return replace(found, fillet=fillet) if fillet[0] != fillet[1] else found
    msg = (
        "the CAD kernel or the mesher broke on this bracket, in a process of its own "
        f"({'; '.join(tried)}): change its fillet, or the size of its elements"
    )
    raise DesignError(msg, about="bracket")


def weighed_apart(shapes: Sequence[Shape], material: Material) -> FloatArray:
    """Return what shapes weigh, (k,) kg, in a process of its own; nan where one cannot be built."""
    try:
        masses: list[float] = apart(
            weigh, tuple(shapes), material.density, tell=silent, memory=MEMORY, seconds=60 * MINUTES
        )
    except Crashed:
        if len(shapes) == 1:
            return np.array([np.nan])
        half = len(shapes) // 2
        parts = [weighed_apart(shapes[:half], material), weighed_apart(shapes[half:], material)]
        return np.concatenate(parts)
    return np.array(masses)


def drawn_apart(shape: Shape) -> bytes:
    """Return a shape as a STEP file in millimetres, its faces named, from a process of its own."""
    written: bytes = apart(drawn, shape, tell=silent, memory=MEMORY, seconds=60 * MINUTES)
    return written


def drawn(shape: Shape, _: Progress) -> bytes:
    """Return a shape as a STEP file."""
    with TemporaryDirectory(prefix="cardan-") as folder:
        path = Path(folder, "bracket.step")
        solid(shape).write(path)
        return path.read_bytes()


def weigh(shapes: tuple[Shape, ...], density: float, _: Progress) -> list[float]:
    """Return what shapes weigh, kg; nan where one cannot be built."""
    found: list[float] = []
    for shape in shapes:
        try:
            found.append(solid(shape).volume * density)
        except DesignError:
            found.append(float("nan"))
    return found


def _ways(shape: Shape) -> Iterator[Shape]:
    """Yield the shape as it is drawn, then with smaller fillets."""
    yield shape
    if not isinstance(shape, StepShape):
        for share in _SMALLER:
            yield replace(shape, fillet=share * shape.fillet)


def _fillet(shape: Shape) -> Metre:
    return 0.0 if isinstance(shape, StepShape) else shape.fillet


def solve(task: Task, tell: Progress) -> Solved:
    """Solve a bracket: CAD, mesh, unit loads, refinement, modes, gauges."""
    tell("building the shape")
    body = solid(task.shape)
    size = task.element or 1.5 * body.thickness
    finer = _asked_of_faces(body, size, bolted=task.bolted)
    expected = affordable(Model(
        volume=body.volume, area=_area(body.shape.faces), size=size, degree=task.order,
        finer=finer, forces=_forces(body) if task.bolted else 0.0,
    ))  # fmt: skip
    tell(f"expecting {expected}")
    problem = Problem(
        shape=body.shape, material=task.material, held=body.held("sliding"),
        clamps=tuple(body.held("sliding")), firm=body.held("clamped"), loads=unit_loads, size=size,
        thickness=body.thickness, degree=task.order, asked=_FORCES,
    )  # fmt: skip
    read: list[FloatArray] = []

    def seen(found: Solution) -> None:
        units = _units(body, found, size)
        if not read:  # now: a misplaced gauge is told at once
            read.append(influence(units, task.gauges))
        if task.reads and len(read) <= _READ and units.unknowns(task.order + 1) <= _AFFORDED:
            tell("gauges, by elements of a degree more")
            held = problem.held
            read.append(influence(units.of_degree(task.order + 1, held=held), task.gauges))

    grids = [(gauge.point, max(gauge.length, body.thickness / 3)) for gauge in task.gauges]
    done = refined(
        problem, cases=task.cases, weights=task.weights, finer=grids, tell=tell, seen=seen,
        levels=task.levels,
    )  # fmt: skip
    tell("natural frequencies")
    sliding = _held("sliding", body, done.last, task, size)
    assert done.firm is not None
    clamped = _held("clamped", body, done.firm, task, size)
    # In contact a third factorisation comes: these two have done their work.
    done = replace(done, last=done.last.kept(), firm=done.firm.kept())
    if len(read) == 1:
        read.append(sliding.influence)
    before, last = (of[:, :3] for of in read[-2:])
    changed = np.abs(last - before).max(axis=0, initial=0.0)
    if task.reads:
        # How it is held is felt far from it, where any elements tell what it changes.
        other = read[-1] + clamped.influence - sliding.influence
        glued = misplaced(_units(body, done.last, size), task.gauges)[:, :3]
        unsure = np.hypot(changed, glued)
        clamped = replace(clamped, influence=other, unsure=unsure)
        sliding = replace(sliding, unsure=unsure)
    sliding = replace(sliding, influence=read[-1])
    return Solved(
        nodes=done.last.elastic.nodes,
        thickness=body.thickness,
        mass=body.volume * task.material.density,
        displacement=done.last.elastic.motion_at_nodes(done.last.displacements),
        stress=done.last.stress,
        sliding=sliding,
        clamped=clamped,
        error=done.error,
        influence_change=float(changed.max() / np.abs(last).max()) if last.size else 0.0,
        unknowns=done.last.elastic.unknowns,
        meshes=len(done.tops),
        expected=expected,
        found=body.found,
        bolted=_bolted(body, done, task, tell) if task.bolted else None,
    )


def _asked_of_faces(body: Solid, size: Metre, *, bolted: bool) -> float:
    """Ask of some faces for edges below `size`; return how many triangles there will be on them."""
    finer = 0.0
    for face in body.shape.faces:
        edge = longest_on(face, body.thickness)
        if face.name in body.bolts:  # at a washer's border stress is read close by
            edge = 0.5 * body.thickness
            if bolted:
                edge = min(edge, PATCH * _hole(face))
        if edge < size:
            face.maxh = edge
            finer += triangles(face.mass, edge)
        elif (small := round_off(face, body.thickness)) < size:  # the mesher asks by itself
            finer += triangles(face.mass, small)
    return finer


def _forces(body: Solid) -> float:
    """Return about how many forces there will be between its flange and the frame."""
    faces = body.shape.faces
    hole = min(_hole(face) for face in faces if face.name in body.bolts)
    plane = _area(face for face in faces if face.name == MOUNT)
    return forces_of(hole=hole, thickness=body.thickness, bolts=len(body.bolts), plane=plane)


def _hole(ring: Any) -> Metre:
    """Return the diameter of the hole in a washer's ring."""
    low, high = ring.bounding_box
    return float(high.x - low.x + high.y - low.y + high.z - low.z) / (2 * WASHER)


def _area(faces: Iterable[Any]) -> float:
    return float(sum(face.mass for face in faces))


def _units(body: Solid, found: Solution, size: Metre) -> Units:
    return Units(
        solid=body, elastic=found.elastic, loads=found.loads,
        displacements=found.displacements, size=size,
    )  # fmt: skip


def _held(hold: Hold, body: Solid, found: Solution, task: Task, size: Metre) -> Held:
    """Return what is left of a solution."""
    units = _units(body, found, size)
    # The clamped flange's frequencies only say how far the first ones may be off.
    many = hold == "sliding"
    alone, shapes = units.modes(MODES if many else OWN)
    own = shapes[:OWN]
    every = replace(units, displacements=np.concatenate([units.displacements, own]))
    read = influence(every, task.gauges)
    carried, bends = alone, np.ones_like(alone)
    if task.carried_mass > 0:
        carried, bends = units.carried(alone, shapes, mass=task.carried_mass, rubber=task.rubber)
        carried = carried if many else carried[:2]
    return Held(
        hold=hold, zones=found.zones, unit=found.unit, compliance=units.compliance,
        reactions=units.reactions, frequencies=alone, carried=carried,
        bends=bends,
        too_high=too_high(found.elastic, alone, shapes) if many else np.zeros(0),
        too_stiff=too_stiff(
            found.elastic, found.displacements[:3], units.compliance.diagonal()[:3]
        ) if many else np.zeros(0),
        influence=read[:, : len(UNITS)],
        unsure=np.zeros((len(task.gauges), 3)),
        swing=_swing(units, found, alone[:OWN], own, read[:, len(UNITS) :], loss=task.loss),
    )  # fmt: skip


def _swing(
    units: Units,
    found: Solution,
    frequencies: FloatArray,
    shapes: FloatArray,
    read: FloatArray,
    *,
    loss: float,
) -> Swing:
    """Return how a bracket swings in modes (k,) Hz, (k, unknowns), which gauges read (g, k)."""
    body = found.elastic
    inert = np.stack([
        (2 * np.pi * f) ** 2 * body.inert(u) for f, u in zip(frequencies, shapes, strict=True)
    ])  # fmt: skip
    return Swing(
        seat=units.seat(frequencies, shapes, loss=loss),
        unit=found.zones.stress(body.nodes, body.stress_at_nodes(shapes)),
        reactions=units.borne(shapes, inert),
        influence=read,
    )


def _bolted(body: Solid, done: Refined, task: Task, tell: Progress) -> Bolted:
    """Return the flange's joint, and the places of either way held where its stress is read.

    Those are the highest of each feature, under the loads that tell most; of the plane against the
    frame none: what presses it is no crack's business.
    """
    ways, nodes = (done.last, done.firm), done.last.elastic.nodes
    pressed = np.zeros(len(nodes.points), dtype=bool)
    pressed[nodes.faces[nodes.face_names == MOUNT]] = True
    places: list[IntArray] = []
    for way in ways:
        assert way is not None
        level = von_mises(superpose(way.unit, telling(way.unit, task.cases)))
        own = way.zones.own
        level[: len(own)][pressed[own]] = 0.0
        top = np.zeros((len(way.zones.features), level.shape[1]))
        np.maximum.at(top, way.zones.feature, level)
        high = (level > 0) & (level >= _HIGH * top[way.zones.feature])
        places.append(np.flatnonzero(high.any(axis=1)))

    def read(displacements: FloatArray) -> FloatArray:
        stress = done.last.elastic.stress_at_nodes(displacements)
        return np.concatenate([
            way.zones.stress(nodes, stress)[at]
            for way, at in zip(ways, places, strict=True) if way is not None
        ])  # fmt: skip

    joint = condensed(
        done.last.elastic, done.last.loads, bolts=body.bolts, upright=body.upright,
        thickness=body.thickness, read=read, tell=tell,
    )  # fmt: skip
    return Bolted(joint=joint, places=tuple(places))
