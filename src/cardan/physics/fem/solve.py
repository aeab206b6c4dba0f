"""From a bracket's drawing to plain arrays: everything its study needs of the finite elements.

The work is done in a process of its own (`cardan.core.subprocess_call`), after an estimate of what
it takes, and with smaller welds and fillets where the CAD kernel breaks on those drawn.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from cardan.core.arrays import FloatArray, IntArray
from cardan.core.errors import DesignError
from cardan.core.status import StatusCallback, ignore_status
from cardan.core.subprocess_call import (
    ChildProcessCrashedError,
    ChildProcessKilledError,
    call_in_subprocess,
)
from cardan.core.units import Metre, mm
from cardan.model.bracket import (
    FATIGUE_ZONES,
    BracketStrainGauge,
    FlangeBoundaryCondition,
    Shape,
    StepFileShape,
    Vector3,
)
from cardan.model.bracket_compliance import DEFAULT_BRACKET_LOSS_FACTOR, BracketCompliance
from cardan.model.material import Material
from cardan.physics.fem.adaptive_refinement import (
    MAX_MESHES,
    AdaptiveSolution,
    ElasticityProblem,
    MeshSolution,
    select_loads_of_highest_stress,
    solve_adaptively,
)  # fmt: skip
from cardan.physics.fem.bolted_joint import (
    CONTACT_RING_WIDTH_TO_HOLE_RATIO,
    BoltedFlange,
    condense_bracket_to_flange_contact,
    contact_force_count,
)
from cardan.physics.fem.bracket_solid import (
    MOUNT_FACE_NAME,
    WASHER_DIAMETER_RATIO,
    BracketSolid,
    FaceSelection,
)
from cardan.physics.fem.cost_estimate import (
    MAX_MEMORY_BYTES,
    MAX_SOLVE_MINUTES,
    CostEstimate,
    ModelSize,
    check_affordable,
    triangle_count,
)
from cardan.physics.fem.fatigue_zones import FatigueZones
from cardan.physics.fem.geometry import build_solid
from cardan.physics.fem.meshing import MeshNodes
from cardan.physics.fem.pollution_error import frequency_error, stiffness_error
from cardan.physics.fem.round_faces import corner_round_element_size, max_element_size_on_face
from cardan.physics.fem.strain_gauges import (
    gauge_influence_matrix,
    gauge_strain_error_by_misplacement,
)
from cardan.physics.fem.stress import superpose, von_mises
from cardan.physics.fem.unit_loads import UNIT_LOAD_NAMES, UnitSolutions, unit_loads

COMPUTED_MODE_COUNT = 6
RETAINED_MODE_COUNT = 3
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
class SolveRequest:
    """What the finite elements are to compute.

    Attributes
    ----------
    cases : ((t, 9), ...)
        Load histories under which maxima are sought.
    zone_weights
        How much a stress weighs in each of `FATIGUE_ZONES` when the mesh is made finer.
    """

    shape: Shape
    material: Material
    cases: tuple[FloatArray, ...]
    zone_weights: tuple[float, ...] = (1.0,) * len(FATIGUE_ZONES)
    element_size: Metre | None = None
    element_degree: int = 2
    gauges: tuple[BracketStrainGauge, ...] = ()
    carried_mass: float = 0.0
    mount_stiffness: Vector3 | None = None
    loss_factor: float = DEFAULT_BRACKET_LOSS_FACTOR
    max_meshes: int = MAX_MESHES
    """Meshes at most."""
    condenses_contact: bool = False
    """Whether its flange's contact with the frame is condensed."""
    recovers_forces: bool = False
    """Whether forces are read back from its gauges."""


@dataclass(frozen=True, kw_only=True)
class ModalModel:
    """How a bracket swings in modes of its own, of unit modal mass, k of them.

    Attributes
    ----------
    bracket_compliance : BracketCompliance
        What it gives under the bearing; made of unit forces and of these modes.
    unit_stress : (places, k, 6) Pa kg^-1/2
    reactions : (bolts, k, 3) N kg^-1/2
    influence : (gauges, k) kg^-1/2
    """

    bracket_compliance: BracketCompliance
    unit_stress: FloatArray
    reactions: FloatArray
    influence: FloatArray


@dataclass(frozen=True, kw_only=True)
class ConstrainedBracketSolution:
    """Solution of a bracket under one boundary condition.

    Loads are those of `cardan.physics.fem.unit_loads.UNIT_LOAD_NAMES`.

    Attributes
    ----------
    fixed_faces
        Faces that are held, by name, with the axes along which they are.
    unit_stress : (places, 9, 6) Pa
        Stress that counts at each place of `zones`.
    compliance : (6, 6) m/N, rad/(N m)
        Mean motion of the seat under forces and moments.
    reactions : (bolts, 9, 3) N
        Force each bolt takes from the frame; where the whole plane is held, its share alone.
    frequencies, loaded_frequencies : Hz
        Natural frequencies, six by itself and with what it carries; of the clamped flange
        three and two.
    bending_energy_share : (k,) 1
        Share of the energy of each mode with what it carries that bends it, and no rubber.
    frequency_error : (k,) 1
        Share by which the natural frequencies by itself may be above those of finer elements; of
        the clamped flange it is not computed.
    stiffness_error : (3,) 1
        The same of the stiffness against each force; of the clamped flange neither.
    influence : (gauges, 9)
        Strain of each gauge.
    influence_error : (gauges, 3) 1/N
        Strain by which each gauge may read a unit force wrong, where forces are read from them.
    modal_model : ModalModel
        What comes on top where it is shaken.
    """

    hold: FlangeBoundaryCondition
    fixed_faces: dict[str, str]
    zones: FatigueZones
    unit_stress: FloatArray
    compliance: FloatArray
    reactions: FloatArray
    frequencies: FloatArray
    loaded_frequencies: FloatArray
    bending_energy_share: FloatArray
    frequency_error: FloatArray
    stiffness_error: FloatArray
    influence: FloatArray
    influence_error: FloatArray
    modal_model: ModalModel


@dataclass(frozen=True, kw_only=True)
class FlangeJointStressPlaces:
    """A flange's joint with its frame, and where its stress is read: `places` of each way held."""

    flange: BoltedFlange
    places: tuple[IntArray, ...]


@dataclass(frozen=True, kw_only=True)
class SolvedBracket:
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
    unknowns, mesh_count
        Of the last mesh; how many were made.
    fillet : (m, m)
        As it is drawn, and as it was solved with where the CAD kernel breaks on that.
    face_selections
        What a STEP file had where faces were picked.
    contact_model : FlangeJointStressPlaces
        Its flange in its bolts; None if not requested.
    cost_estimate
        What was estimated beforehand.
    """

    nodes: MeshNodes
    thickness: Metre
    mass: float
    displacement: FloatArray
    stress: FloatArray
    sliding: ConstrainedBracketSolution
    clamped: ConstrainedBracketSolution
    error: dict[tuple[int, int], float]
    influence_change: float
    unknowns: int
    mesh_count: int
    cost_estimate: CostEstimate
    fillet: tuple[Metre, Metre] | None = None
    face_selections: tuple[FaceSelection, ...] = ()
    contact_model: FlangeJointStressPlaces | None = None

    @property
    def boundary_cases(self) -> tuple[ConstrainedBracketSolution, ConstrainedBracketSolution]:
        """The two ways it is held."""
        return self.sliding, self.clamped

    @cached_property
    def surface_stress(self) -> tuple[FloatArray, FloatArray]:
        """Stress (surface nodes, 9, 6) Pa, the flange sliding; how much each load does, (9,)."""
        stress = self.stress[self.nodes.surface_nodes]
        return stress, np.sqrt(np.mean(stress**2, axis=(0, 2)))


def solve_in_subprocess(task: SolveRequest, *, tell: StatusCallback) -> SolvedBracket:
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
            found = call_in_subprocess(
                solve_bracket, replace(task, shape=shape), tell=tell,
                memory=MAX_MEMORY_BYTES, seconds=60 * MAX_SOLVE_MINUTES,
            )  # fmt: skip
        except ChildProcessKilledError as error:  # which no smaller fillet cures
            msg = f"solving this bracket was stopped: {error}; a larger `element_mm` takes less"
            raise DesignError(msg, about="bracket") from None
        except ChildProcessCrashedError as error:
            tried.append(f"fillet {fillet[1] / mm:.3g} mm: {error}" if fillet[1] else str(error))
            tell(f"the CAD kernel or the mesher broke ({error}); trying again")
            continue
        return replace(found, fillet=fillet) if fillet[0] != fillet[1] else found
    msg = (
        "the CAD kernel or the mesher broke on this bracket, in a process of its own "
        f"({'; '.join(tried)}): change its fillet, or the size of its elements"
    )
    raise DesignError(msg, about="bracket")


def bracket_masses_in_subprocess(shapes: Sequence[Shape], material: Material) -> FloatArray:
    """Return what shapes weigh, (k,) kg, in a process of its own; nan where one cannot be built."""
    try:
        masses: list[float] = call_in_subprocess(
            bracket_masses,
            tuple(shapes),
            material.density,
            tell=ignore_status,
            memory=MAX_MEMORY_BYTES,
            seconds=60 * MAX_SOLVE_MINUTES,
        )
    except ChildProcessCrashedError:
        if len(shapes) == 1:
            return np.array([np.nan])
        half = len(shapes) // 2
        parts = [
            bracket_masses_in_subprocess(shapes[:half], material),
            bracket_masses_in_subprocess(shapes[half:], material),
        ]
        return np.concatenate(parts)
    return np.array(masses)


def export_step_in_subprocess(shape: Shape) -> bytes:
    """Return a shape as a STEP file in millimetres, its faces named, from a process of its own."""
    written: bytes = call_in_subprocess(
        export_step,
        shape,
        tell=ignore_status,
        memory=MAX_MEMORY_BYTES,
        seconds=60 * MAX_SOLVE_MINUTES,
    )
    return written


def export_step(shape: Shape, _: StatusCallback) -> bytes:
    """Return a shape as a STEP file."""
    with TemporaryDirectory(prefix="cardan-") as folder:
        path = Path(folder, "bracket.step")
        build_solid(shape).write_step(path)
        return path.read_bytes()


def bracket_masses(shapes: tuple[Shape, ...], density: float, _: StatusCallback) -> list[float]:
    """Return what shapes weigh, kg; nan where one cannot be built."""
    found: list[float] = []
    for shape in shapes:
        try:
            found.append(build_solid(shape).volume * density)
        except DesignError:
            found.append(float("nan"))
    return found


def _ways(shape: Shape) -> Iterator[Shape]:
    """Yield the shape as it is drawn, then with smaller fillets."""
    yield shape
    if not isinstance(shape, StepFileShape):
        for share in _SMALLER:
            yield replace(shape, fillet=share * shape.fillet)


def _fillet(shape: Shape) -> Metre:
    return 0.0 if isinstance(shape, StepFileShape) else shape.fillet


def solve_bracket(task: SolveRequest, tell: StatusCallback) -> SolvedBracket:
    """Solve a bracket: CAD, mesh, unit loads, refinement, modes, gauges."""
    tell("building the shape")
    body = build_solid(task.shape)
    size = task.element_size or 1.5 * body.thickness
    finer = _asked_of_faces(body, size, bolted=task.condenses_contact)
    expected = check_affordable(
        ModelSize(
            volume=body.volume,
            area=_area(body.shape.faces),
            element_size=size,
            degree=task.element_degree,
            fine_face_triangles=finer,
            contact_forces=_forces(body) if task.condenses_contact else 0.0,
        )
    )
    tell(f"expecting {expected}")
    problem = ElasticityProblem(
        shape=body.shape,
        material=task.material,
        fixed_faces=body.fixed_faces("sliding"),
        clamp_faces=tuple(body.fixed_faces("sliding")),
        alternative_fixed_faces=body.fixed_faces("clamped"),
        loads=unit_loads,
        element_size=size,
        thickness=body.thickness,
        degree=task.element_degree,
        always_solved_loads=_FORCES,
    )
    read: list[FloatArray] = []

    def seen(found: MeshSolution) -> None:
        units = _units(body, found, size)
        if not read:  # now: a misplaced gauge is reported at once
            read.append(gauge_influence_matrix(units, task.gauges))
        if (
            task.recovers_forces
            and len(read) <= _READ
            and units.unknown_count(task.element_degree + 1) <= _AFFORDED
        ):
            tell("gauges, by elements of a degree more")
            held = problem.fixed_faces
            read.append(
                gauge_influence_matrix(
                    units.with_degree(task.element_degree + 1, held=held), task.gauges
                )
            )

    grids = [(gauge.point, max(gauge.length, body.thickness / 3)) for gauge in task.gauges]
    done = solve_adaptively(
        problem, cases=task.cases, weights=task.zone_weights, finer=grids, tell=tell, seen=seen,
        levels=task.max_meshes,
    )  # fmt: skip
    tell("natural frequencies")
    sliding = _held("sliding", body, done.final_solution, task, size)
    assert done.alternative_solution is not None
    clamped = _held("clamped", body, done.alternative_solution, task, size)
    # In contact a third factorisation comes: these two have done their work.
    done = replace(
        done,
        final_solution=done.final_solution.without_factorisation(),
        alternative_solution=done.alternative_solution.without_factorisation(),
    )
    if len(read) == 1:
        read.append(sliding.influence)
    before, last = (of[:, :3] for of in read[-2:])
    changed = np.abs(last - before).max(axis=0, initial=0.0)
    if task.recovers_forces:
        # How it is held is felt far from it, where any elements show what it changes.
        other = read[-1] + clamped.influence - sliding.influence
        glued = gauge_strain_error_by_misplacement(
            _units(body, done.final_solution, size), task.gauges
        )[:, :3]
        unsure = np.hypot(changed, glued)
        clamped = replace(clamped, influence=other, influence_error=unsure)
        sliding = replace(sliding, influence_error=unsure)
    sliding = replace(sliding, influence=read[-1])
    return SolvedBracket(
        nodes=done.final_solution.elastic.nodes,
        thickness=body.thickness,
        mass=body.volume * task.material.density,
        displacement=done.final_solution.elastic.displacement_at_nodes(
            done.final_solution.displacements
        ),
        stress=done.final_solution.stress,
        sliding=sliding,
        clamped=clamped,
        error=done.error,
        influence_change=float(changed.max() / np.abs(last).max()) if last.size else 0.0,
        unknowns=done.final_solution.elastic.unknowns,
        mesh_count=len(done.stress_maxima),
        cost_estimate=expected,
        face_selections=body.face_selections,
        contact_model=_bolted(body, done, task, tell) if task.condenses_contact else None,
    )


def _asked_of_faces(body: BracketSolid, size: Metre, *, bolted: bool) -> float:
    """Require edges below `size` on some faces; return how many triangles there will be on them."""
    finer = 0.0
    for face in body.shape.faces:
        edge = max_element_size_on_face(face, body.thickness)
        if face.name in body.bolts:  # at a washer's border stress is read close by
            edge = 0.5 * body.thickness
            if bolted:
                edge = min(edge, CONTACT_RING_WIDTH_TO_HOLE_RATIO * _hole(face))
        if edge < size:
            face.maxh = edge
            finer += triangle_count(face.mass, edge)
        elif (
            small := corner_round_element_size(face, body.thickness)
        ) < size:  # the mesher does so by itself
            finer += triangle_count(face.mass, small)
    return finer


def _forces(body: BracketSolid) -> float:
    """Return about how many forces there will be between its flange and the frame."""
    faces = body.shape.faces
    hole = min(_hole(face) for face in faces if face.name in body.bolts)
    plane = _area(face for face in faces if face.name == MOUNT_FACE_NAME)
    return contact_force_count(
        hole=hole, thickness=body.thickness, bolts=len(body.bolts), plane=plane
    )


def _hole(ring: Any) -> Metre:
    """Return the diameter of the hole in a washer's ring."""
    low, high = ring.bounding_box
    return float(high.x - low.x + high.y - low.y + high.z - low.z) / (2 * WASHER_DIAMETER_RATIO)


def _area(faces: Iterable[Any]) -> float:
    return float(sum(face.mass for face in faces))


def _units(body: BracketSolid, found: MeshSolution, size: Metre) -> UnitSolutions:
    return UnitSolutions(
        solid=body, elastic=found.elastic, loads=found.loads,
        displacements=found.displacements, element_size=size,
    )  # fmt: skip


def _held(
    hold: FlangeBoundaryCondition,
    body: BracketSolid,
    found: MeshSolution,
    task: SolveRequest,
    size: Metre,
) -> ConstrainedBracketSolution:
    """Return what is left of a solution."""
    units = _units(body, found, size)
    # The clamped flange's frequencies only say how far the first ones may be off.
    many = hold == "sliding"
    alone, shapes = units.modes(COMPUTED_MODE_COUNT if many else RETAINED_MODE_COUNT)
    own = shapes[:RETAINED_MODE_COUNT]
    every = replace(units, displacements=np.concatenate([units.displacements, own]))
    read = gauge_influence_matrix(every, task.gauges)
    carried, bends = alone, np.ones_like(alone)
    if task.carried_mass > 0:
        carried, bends = units.loaded_modes(
            alone, shapes, mass=task.carried_mass, rubber=task.mount_stiffness
        )
        carried = carried if many else carried[:2]
    return ConstrainedBracketSolution(
        hold=hold,
        fixed_faces=body.fixed_faces(hold),
        zones=found.zones,
        unit_stress=found.unit_stress,
        compliance=units.compliance,
        reactions=units.reactions,
        frequencies=alone,
        loaded_frequencies=carried,
        bending_energy_share=bends,
        frequency_error=frequency_error(found.elastic, alone, shapes) if many else np.zeros(0),
        stiffness_error=stiffness_error(
            found.elastic, found.displacements[:3], units.compliance.diagonal()[:3]
        )
        if many
        else np.zeros(0),
        influence=read[:, : len(UNIT_LOAD_NAMES)],
        influence_error=np.zeros((len(task.gauges), 3)),
        modal_model=_swing(
            units,
            found,
            alone[:RETAINED_MODE_COUNT],
            own,
            read[:, len(UNIT_LOAD_NAMES) :],
            loss=task.loss_factor,
        ),
    )


def _swing(
    units: UnitSolutions,
    found: MeshSolution,
    frequencies: FloatArray,
    shapes: FloatArray,
    read: FloatArray,
    *,
    loss: float,
) -> ModalModel:
    """Return how a bracket swings in modes (k,) Hz, (k, unknowns), which gauges read (g, k)."""
    body = found.elastic
    inert = np.stack([
        (2 * np.pi * f) ** 2 * body.mass_times(u) for f, u in zip(frequencies, shapes, strict=True)
    ])  # fmt: skip
    return ModalModel(
        bracket_compliance=units.bracket_compliance(frequencies, shapes, loss=loss),
        unit_stress=found.zones.stress(body.nodes, body.stress_at_nodes(shapes)),
        reactions=units.bolt_forces(shapes, inert),
        influence=read,
    )


def _bolted(
    body: BracketSolid, done: AdaptiveSolution, task: SolveRequest, tell: StatusCallback
) -> FlangeJointStressPlaces:
    """Return the flange's joint, and the places of either way held where its stress is read.

    Those are the highest of each feature, under the most relevant loads; of the plane against the
    frame none: what presses it is no crack's business.
    """
    ways, nodes = (
        (done.final_solution, done.alternative_solution),
        done.final_solution.elastic.nodes,
    )
    pressed = np.zeros(len(nodes.points), dtype=bool)
    pressed[nodes.faces[nodes.face_names == MOUNT_FACE_NAME]] = True
    places: list[IntArray] = []
    for way in ways:
        assert way is not None
        level = von_mises(
            superpose(way.unit_stress, select_loads_of_highest_stress(way.unit_stress, task.cases))
        )
        own = way.zones.surface_stress_nodes
        level[: len(own)][pressed[own]] = 0.0
        top = np.zeros((len(way.zones.features), level.shape[1]))
        np.maximum.at(top, way.zones.feature, level)
        high = (level > 0) & (level >= _HIGH * top[way.zones.feature])
        places.append(np.flatnonzero(high.any(axis=1)))

    def read(displacements: FloatArray) -> FloatArray:
        stress = done.final_solution.elastic.stress_at_nodes(displacements)
        return np.concatenate([
            way.zones.stress(nodes, stress)[at]
            for way, at in zip(ways, places, strict=True) if way is not None
        ])  # fmt: skip

    joint = condense_bracket_to_flange_contact(
        done.final_solution.elastic,
        done.final_solution.loads,
        bolts=body.bolts,
        upright=body.bolt_axis,
        thickness=body.thickness,
        read=read,
        tell=tell,
    )
    return FlangeJointStressPlaces(flange=joint, places=tuple(places))
