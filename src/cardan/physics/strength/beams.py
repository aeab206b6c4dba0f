"""A line as Timoshenko beams, hinged to each other at its joints: mass, stiffness, gyroscopes.

A joint carries force across, but no bending moment. Gearbox and axle hold the first and
the last joint, rigidly or as springs with a mass. The line is taken as straight: at truck
angles of a few degrees, what a bent line adds is of the order of the angle squared. Torque,
axial force and damping are left out.
"""

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray, stack_on_last_axis, stack_vectors_on_last_axes
from cardan.core.errors import DesignError
from cardan.core.lazy_dataclass import dataclass
from cardan.model.parts import Line


@dataclass(frozen=True, slots=True, kw_only=True)
class BeamModel:
    """A line as beams, s shafts from gearbox to axle; cases on leading axes.

    All but the last shaft hang on a centre bearing.

    Attributes
    ----------
    length : (..., s) m
    bending_stiffness : (..., s) N m²
    shear_stiffness : (..., s) N
        κ G A; infinite for Euler's beam.
    mass_per_length : (..., s) kg/m
    rotary_inertia : (..., s) kg m
        ρ I per length, about a diameter; the polar one is twice that.
    yoke_mass : (..., s, 2) kg
        At the front and rear joint centre of each shaft.
    yoke_inertia : (..., s, 2) kg m²
        About the shaft's axis, and as much about a diameter: a yoke is about as long as
        it is wide.
    spline_mass, spline_position : (..., s) kg, m
        What the spline adds to the tube, and how far behind the front joint.
    overhang : (..., s-1) m
        Rear joint centre behind the bearing.
    bearing_stiffness : (..., s-1, 2) N/m
        Vertical and lateral; infinite where rigid.
    flange_stiffness : (..., 2, 2) N/m
        The same of what holds the first joint and the last.
    flange_mass : (..., 2) kg
        What moves with them.
    """

    length: FloatArray
    bending_stiffness: FloatArray
    shear_stiffness: FloatArray
    mass_per_length: FloatArray
    rotary_inertia: FloatArray
    yoke_mass: FloatArray
    yoke_inertia: FloatArray
    spline_mass: FloatArray
    spline_position: FloatArray
    overhang: FloatArray
    bearing_stiffness: FloatArray
    flange_stiffness: FloatArray
    flange_mass: FloatArray


def beam_model(line: Line, *, lengths: ArrayLike | None = None) -> BeamModel:
    """Return a line as beams, its shafts as long as given or as `lengths` (..., s) m say.

    Raises
    ------
    DesignError
        If a shaft has no tube.
    """
    for k, shaft in enumerate(line.shafts, 1):
        if shaft.tube is None:
            msg = f"shaft {k} of line {line.name} has no tube: give its outer and wall size"
            raise DesignError(msg, about=f"drivelines.{line.name}.shafts[{k}]")
    tubes = [s.tube for s in line.shafts if s.tube]
    bearings = [s.centre_bearing for s in line.shafts if s.centre_bearing]
    splines = [s.spline for s in line.shafts]
    return BeamModel(
        length=stack_on_last_axis(line.lengths)
        if lengths is None
        else np.asarray(lengths, dtype=float),
        bending_stiffness=stack_on_last_axis(t.bending_stiffness for t in tubes),
        shear_stiffness=stack_on_last_axis(t.shear_stiffness for t in tubes),
        mass_per_length=stack_on_last_axis(t.mass_per_length for t in tubes),
        rotary_inertia=stack_on_last_axis(t.polar_inertia_per_length / 2 for t in tubes),
        yoke_mass=stack_vectors_on_last_axes((s.yoke_mass for s in line.shafts), size=2),
        yoke_inertia=stack_vectors_on_last_axes(
            ([s.yoke_inertia / 2] * 2 for s in line.shafts), size=2
        ),
        spline_mass=stack_on_last_axis(s.mass if s else 0.0 for s in splines),
        spline_position=stack_on_last_axis(s.from_front_joint if s else 0.0 for s in splines),
        overhang=stack_on_last_axis(b.from_rear_joint for b in bearings),
        bearing_stiffness=stack_vectors_on_last_axes(
            (b.transverse_stiffness or (np.inf, np.inf) for b in bearings), size=2
        ),
        flange_stiffness=stack_vectors_on_last_axes(
            (f.stiffness or (np.inf, np.inf) for f in line.flanges), size=2
        ),
        flange_mass=stack_on_last_axis(f.mass for f in line.flanges),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class BeamMatrices:
    """A line in N coordinates p per plane, scaled to a stiffness of one: K = L Lᵀ, p = Lᵀ q.

    Attributes
    ----------
    flexibility : (..., 2, N, N)
        L⁻¹ M L⁻ᵀ of each plane.
    gyroscopic, mass : (..., N, N)
        The same of G, and of M, between the planes.
    bearing_strain : (..., 2, b, N)
        Strains of bearings and flanges; their squares add up to twice their energy.
    displacement : (..., 2, p, N)
        Of the stations.
    station : (..., p) m
    """

    flexibility: FloatArray
    gyroscopic: FloatArray
    mass: FloatArray
    bearing_strain: FloatArray
    displacement: FloatArray
    station: FloatArray


@dataclass(frozen=True, slots=True)
class _Element:
    """A piece of a shaft; its motion and strain are rows of coefficients of the coordinates.

    Attributes
    ----------
    shaft : counts from 0
    length : (...) m
    motion : four of (N,) or (..., 2, N)
        Displacement and rotation of its front, then of its rear.
    strain : two of (N,) or (..., 2, N)
        Their squares add up to twice its energy.
    """

    shaft: int
    length: FloatArray
    motion: tuple[FloatArray, FloatArray, FloatArray, FloatArray]
    strain: tuple[FloatArray, FloatArray]


def _mesh(beams: BeamModel, elements: int) -> tuple[list[_Element], list[FloatArray]]:
    """Divide a line; return its elements, and the rows of its bearings' and flanges' strains.

    Two limits get their care in the choice of coordinates, so that neither is a special
    case. A bearing moves by its coordinate times a slack, 0 for a rigid one; so do flanges,
    where one of them gives. Behind a bearing the coordinates are the strains of the elements,
    which move nothing where the joint sits in the bearing and they have no length.
    """
    shafts, behind = beams.length.shape[-1], max(1, elements // 2)
    soft = bool(np.isfinite(beams.flange_stiffness).any())
    size = 2 * elements * shafts + (1 + 2 * behind) * (shafts - 1) + 2 * soft
    free = iter(np.eye(size))
    mesh: list[_Element] = []
    bearings: list[FloatArray] = []

    def sprung(stiffness: FloatArray, unit: FloatArray) -> FloatArray:
        """Return how a spring (..., 2) N/m lets its place move, over a shaft's `unit` N/m."""
        way, unit = next(free), unit[..., None]
        slack = (1 + stiffness / unit) ** -0.5
        bearings.append(np.sqrt(unit * (1 - slack**2))[..., None] * way)
        return slack[..., None] * way

    def flange(end: int) -> FloatArray:
        if not soft:
            return np.zeros(size)
        unit = (beams.bending_stiffness / beams.length**3)[..., end]
        return sprung(beams.flange_stiffness[..., end, :], unit)

    w = flange(0)
    for k in range(shafts):
        hung = k < shafts - 1
        back = beams.overhang[..., k] if hung else np.zeros(())
        span = beams.length[..., k] - back
        EI = beams.bending_stiffness[..., k]
        root = np.sqrt(EI)[..., None, None]
        shear = 12 * EI / beams.shear_stiffness[..., k]
        t = next(free)
        h = (span / elements)[..., None, None]
        stretch, rho = _stretch(h, shear[..., None, None])
        for j in range(1, elements + 1):
            if j < elements:
                far_w = next(free)
            elif hung:
                far_w = sprung(beams.bearing_stiffness[..., k, :], EI / span**3)
            else:
                far_w = flange(-1)
            far_t = next(free)
            sheared, bent = (far_w - w - h * t) / stretch, (far_t - t) / np.sqrt(h)
            strain = root * (12**0.5 * sheared - 3**0.5 * rho * bent), root * bent
            mesh.append(_Element(k, h[..., 0, 0], (w, t, far_w, far_t), strain))
            w, t = far_w, far_t
        h = (back / behind)[..., None, None]
        stretch, rho = _stretch(h, shear[..., None, None])
        for _ in range(behind if hung else 0):
            strain = next(free), next(free)
            bent = strain[1] / root
            sheared = (strain[0] / root + 3**0.5 * rho * bent) / 12**0.5
            far_w, far_t = w + h * t + stretch * sheared, t + np.sqrt(h) * bent
            mesh.append(_Element(k, h[..., 0, 0], (w, t, far_w, far_t), strain))
            w, t = far_w, far_t
    return mesh, bearings


def _stretch(h: FloatArray, soft: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return √(h (h² + 12 EI/κGA)), and ρ = h / √(h² + 12 EI/κGA) which is 1 without shear."""
    size = np.sqrt(h**2 + soft)
    return np.sqrt(h) * size, h / np.where(size > 0, size, 1.0)


def _shapes(
    xi: FloatArray,
    h: FloatArray,
    soft: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Displacement and rotation at shares ξ of an element, (..., 4) of those of its ends.

    The static shapes of a Timoshenko beam: ρ² of Hermite's cubic, 1 - ρ² of a beam that
    only shears. Source: Przemieniecki, Theory of Matrix Structural Analysis (1968), 11.
    """
    size = np.where(h**2 + soft > 0, h**2 + soft, 1.0)
    cubic, bow = h**2 / size, xi - xi**2
    ease, turn = cubic * bow * (2 * xi - 1), 6 * bow * h / size
    w = (
        1 - xi - ease,
        h * bow * (0.5 + cubic * (0.5 - xi)),
        xi + ease,
        -h * bow * (0.5 - cubic * (0.5 - xi)),
    )
    t = (-turn, 1 - xi - 3 * cubic * bow, turn, xi - 3 * cubic * bow)
    return np.stack(np.broadcast_arrays(*w), axis=-1), np.stack(np.broadcast_arrays(*t), axis=-1)


_NEAR, _FAR = (np.sqrt(3 / 7 + sign * 2 / 7 * np.sqrt(6 / 5)) for sign in (-1, 1))
_XI = (1 + np.array([-_FAR, -_NEAR, _NEAR, _FAR])) / 2
_WEIGHT = (18 + np.sqrt(30) * np.array([-1, 1, 1, -1])) / 72
"""Four Gauss points and weights on [0, 1], exact for the masses of cubic shapes."""


def _inertia(beams: BeamModel, mesh: list[_Element]) -> tuple[FloatArray, FloatArray]:
    """Return mass and gyroscopic matrices (..., E, 4, 4) of the elements.

    All mass sits in points: those of Gauss for the tube, one for the spline, the ends for
    the yokes.
    """
    shaft = np.array([e.shaft for e in mesh])
    first, last = np.diff(shaft, prepend=-1) > 0, np.diff(shaft, append=shaft[-1] + 1) > 0
    h = np.stack(np.broadcast_arrays(*(e.length for e in mesh)), axis=-1)
    end = np.cumsum(h, axis=-1)
    start = np.concatenate([np.zeros_like(end[..., :1]), end[..., :-1]], axis=-1)
    place = beams.spline_position[..., shaft] + start[..., first][..., shaft]
    holds = ((place >= start) | first) & ((place < end) | last)
    soft = (12 * beams.bending_stiffness / beams.shear_stiffness)[..., shaft]
    tube, spline = beams.mass_per_length[..., shaft] * h, beams.spline_mass[..., shaft] * holds
    rotary = beams.rotary_inertia[..., shaft] * h
    ends = beams.yoke_mass + np.zeros_like(beams.flange_mass[..., :1, None])
    ends[..., 0, 0] += beams.flange_mass[..., 0]
    ends[..., -1, 1] += beams.flange_mass[..., 1]
    yokes = ends[..., shaft, :] * np.stack([first, last], axis=-1)
    turning = beams.yoke_inertia[..., shaft, :] * np.stack([first, last], axis=-1)
    share = (np.clip(place - start, 0, h) / np.where(h > 0, h, 1.0))[..., None]
    xi = _joined(_XI, share, np.array([0.0, 1.0]))
    nothing = np.zeros(1)
    mass = _joined(tube[..., None] * _WEIGHT, spline[..., None], yokes)
    across = _joined(rotary[..., None] * _WEIGHT, nothing, turning)
    polar = _joined(2 * rotary[..., None] * _WEIGHT, nothing, turning)
    w, t = _shapes(xi, h[..., None], soft[..., None])
    M = (w * mass[..., None]).mT @ w + (t * across[..., None]).mT @ t
    return M, (t * polar[..., None]).mT @ t


def _joined(*parts: FloatArray) -> FloatArray:
    """Concatenate along the last axis what broadcasts along the others."""
    lead = np.broadcast_shapes(*(p.shape[:-1] for p in parts))
    return np.concatenate([np.broadcast_to(p, (*lead, p.shape[-1])) for p in parts], axis=-1)


def _stacked(rows: list[FloatArray], lead: tuple[int, ...]) -> FloatArray:
    """Stack rows (..., 2 or 1, N) or (N,) to (*lead, 2, rows, N)."""
    found = np.empty((*lead, 2, len(rows), rows[0].shape[-1]))
    for k, row in enumerate(rows):
        found[..., k, :] = row
    return found


def assemble_beams(beams: BeamModel, elements: int) -> BeamMatrices:
    """Assemble a line from `elements` between its supports and half as many behind them."""
    mesh, bearings = _mesh(beams, elements)
    mass, gyroscopic = _inertia(beams, mesh)
    strains = [*bearings, *(row for e in mesh for row in e.strain)]
    motions = [row for e in mesh for row in e.motion]
    lead = np.broadcast_shapes(
        mass.shape[:-3], *(r.shape[:-2] for r in strains), *(r.shape[:-2] for r in motions)
    )
    B = _stacked(strains, lead)
    unscaled = np.linalg.inv(np.linalg.cholesky(B.mT @ B)).mT
    R = _stacked(motions, lead) @ unscaled
    nodes = R.reshape(*lead, 2, len(mesh), 4, -1)
    MR = (mass[..., None, :, :, :] @ nodes).reshape(R.shape)
    GR = (gyroscopic[..., None, :, :, :] @ nodes).reshape(R.shape)
    h = np.stack(np.broadcast_arrays(np.zeros(lead), *(e.length for e in mesh)), axis=-1)
    return BeamMatrices(
        flexibility=R.mT @ MR,
        gyroscopic=R[..., 0, :, :].mT @ GR[..., 1, :, :],
        mass=R[..., 0, :, :].mT @ MR[..., 1, :, :],
        bearing_strain=B[..., : len(bearings), :] @ unscaled,
        displacement=np.concatenate([nodes[..., :1, 0, :], nodes[..., :, 2, :]], axis=-2),
        station=np.cumsum(h, axis=-1),
    )
