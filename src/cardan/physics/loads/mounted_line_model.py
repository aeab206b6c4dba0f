"""The matrices of a line on its rubber: masses, stiffness and torque on its small motions.

The equations are those of `cardan.physics.loads.rubber_mount`.
"""

from math import pi

import numpy as np

from cardan.core.arrays import (
    ArrayLike,
    FloatArray,
    stack_on_last_axis,
)
from cardan.model.layout import Layout, unit_vector
from cardan.model.parts import Line
from cardan.physics.loads.rubber_mount import (
    DEFAULT_LOSS_FACTOR,
    RIGID_BEARING_STIFFNESS,
    MountedLine,
)

BENDING_SINES_PER_SHAFT = 1
"""Sines in which each tube bends between its joints: its second one is above any order 2."""


def _gauss(count: int) -> tuple[FloatArray, FloatArray]:
    """Return places on [0, 1] and weights that integrate polynomials up to 2 `count` - 1.

    Golub and Welsch (1969): eigenvalues of the Legendre polynomials' recurrence.
    """
    k = np.arange(1, count)
    beside = np.diag(k / np.sqrt(4.0 * k**2 - 1), 1)
    places, vectors = np.linalg.eigh(beside + beside.T)
    return (1 + places) / 2, vectors[0] ** 2


_XI, _WEIGHT = _gauss(6)


def mounted_line(
    layout: Layout,
    line: Line,
    *,
    stiffness: ArrayLike,
    loss: ArrayLike = DEFAULT_LOSS_FACTOR,
    sines: int = BENDING_SINES_PER_SHAFT,
    cut: bool = False,
) -> MountedLine:
    """Return a line as it can move on its centre bearings, and its flanges.

    Parameters
    ----------
    layout : (..., n, 3) m
        Where it runs.
    line
        Its tubes (each shaft needs one), yokes, spline, the places of its bearings, and what
        holds its flanges.
    stiffness : (..., n-2, 3) N/m
        Of the rubber across the shaft, vertical and lateral, and along it.
    loss : (..., n-2) 1
        Share of energy η that it loses in a radian.
    sines
        In how many a tube bends; 0 takes the shafts as rigid.
    cut
        Add three coordinates for each joint, behind all others: what lies behind it moves
        along x, y and z while what is ahead stays, and the axle; at the last joint the last
        shaft moves against the axle. Nothing moves so; what it
        would take is the force that the joint carries
        (`cardan.physics.loads.centre_bearing.joint_forces`).
    """
    d = layout.directions[..., 1:-1, :]
    lengths = layout.lengths
    frames = _frames(d)
    soft = [f.stiffness is not None for f in line.flanges]
    fields = _fields(d, frames, sines=sines)
    given = [_flange(layout.directions, fields.shape, end=k) for k in (0, -1) if soft[k]]
    fields = np.concatenate([fields, *given], axis=-1)
    flanges = _flanges(line, fields.shape[-1], behind=3 * line.joint_count if cut else 0)
    if cut:
        fields = np.concatenate([fields, _cuts(d, fields.shape)], axis=-1)
    turned = _skew(d) @ fields.reshape(*fields.shape[:-2], -1)
    turned = turned.reshape(fields.shape)
    at, mass, across, polar = _masses(line, lengths)
    w, e, _ = _shapes(at, lengths, sines)
    kinetic = (w * mass[..., None]).mT @ w + (e * across[..., None]).mT @ e
    spin = (e * polar[..., None]).mT @ e
    ends = _shapes(np.broadcast_to([0.0, 1.0], (*lengths.shape, 2)), lengths, sines)
    front, rear, front_tilt, rear_tilt = (
        _of(shape[..., k, :], fields) for shape in ends[:2] for k in (0, 1)
    )
    ahead = stack_on_last_axis(
        s.centre_bearing.from_rear_joint for s in line.shafts if s.centre_bearing
    )
    hung = _shapes((1 - ahead / lengths[..., :-1])[..., None], lengths[..., :-1], sines)
    bearing = np.concatenate([frames, d[..., None]], axis=-1)[..., :-1, :, :].mT
    stiff = np.asarray(stiffness, dtype=float)
    stiff = np.broadcast_to(stiff, np.broadcast_shapes(stiff.shape, bearing.shape[:-1]))
    eta = np.asarray(loss, dtype=float)
    between = _skew(unit_vector(d[..., :-1, :] + d[..., 1:, :]))
    at_joints = (rear_tilt[..., :-1, :, :].mT @ between @ front_tilt[..., 1:, :, :]).sum(-3)
    half = -(at_joints + _summed(_wound(lengths, sines), fields, turned)) / 2
    return MountedLine(
        mass=_summed(kinetic, fields, fields) + flanges[2],
        gyroscopic=-_summed(spin, fields, turned),
        bending=_summed(_bending(line, lengths, sines), fields, fields),
        torsion=half + half.mT,
        geometric=_summed(_shortened(d, lengths, sines), fields, fields),
        bearing=bearing @ _of(hung[0][..., 0, :], fields[..., :-1, :, :, :]),
        bearing_frame=bearing,
        stiffness=stiff,
        loss=np.broadcast_to(eta, np.broadcast_shapes(eta.shape, stiff.shape[:-1])),
        front=front,
        rear=rear,
        front_tilt=front_tilt,
        rear_tilt=rear_tilt,
        shaft_directions=d,
        flanges=flanges[0] if any(soft) else None,
        flanges_lost=flanges[1] if any(soft) else None,
    )


def _flanges(line: Line, size: int, *, behind: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return stiffness N/m, what is lost of it, and mass kg at the flanges, (..., N, N) each.

    Their coordinates are the last ones of `size`, the gearbox's first: up and level; so many
    others come `behind`.
    """
    soft = [(f, *f.stiffness) for f in line.flanges if f.stiffness is not None]
    rows = [
        (
            np.minimum(k, RIGID_BEARING_STIFFNESS),
            f.loss_factor * np.minimum(k, RIGID_BEARING_STIFFNESS),
            f.mass,
        )
        for f, *both in soft
        for k in both
    ]
    held, lost, mass = (
        stack_on_last_axis([0.0] * (size - len(rows)) + [row[n] for row in rows] + [0.0] * behind)[
            ..., None, :
        ]
        * np.eye(size + behind)
        for n in range(3)
    )
    return held, lost, mass


def _skew(d: FloatArray) -> FloatArray:
    """Return the matrices (..., 3, 3) that cross vectors (..., 3) with what follows."""
    x, y, z = d[..., 0], d[..., 1], d[..., 2]
    o = np.zeros_like(x)
    return np.stack([o, -z, y, z, o, -x, -y, x, o], axis=-1).reshape(*d.shape, 3)


def _frames(d: FloatArray) -> FloatArray:
    """Directions across members (..., 3) in columns, (..., 3, 2): up, and level."""
    level = unit_vector(np.cross(np.array([0.0, 0.0, 1.0]), d))
    return np.stack([np.cross(d, level), level], axis=-1)


def _fields(d: FloatArray, frames: FloatArray, *, sines: int) -> FloatArray:
    """Return what the coordinates move of each shaft, (..., n-1, 3, 2 + sines, N).

    Its front joint, its rear joint against the front one, and the sines it bends in.
    """
    shafts = d.shape[-2]
    hung = 2 * (shafts - 1)
    found = np.zeros((*d.shape[:-2], shafts, 3, 2 + sines, hung + 2 * sines * shafts))
    for k in range(shafts - 1):
        here = slice(2 * k, 2 * k + 2)
        found[..., k, :, 1, here] = frames[..., k, :, :]
        found[..., k + 1 :, :, 0, here] = frames[..., None, k, :, :]
    # The last shaft takes what comes along it in its spline.
    last = d[..., -1, :]
    ahead = found[..., -1, :, 0, :]
    ahead = ahead - last[..., :, None] * (last[..., None, :] @ ahead)
    found[..., -1, :, 0, :], found[..., -1, :, 1, :] = ahead, -ahead
    for k in range(shafts):
        for j in range(sines):
            start = hung + 2 * (k * sines + j)
            found[..., k, :, 2 + j, start : start + 2] = frames[..., k, :, :]
    return found


def _flange(directions: FloatArray, shape: tuple[int, ...], *, end: int) -> FloatArray:
    """Return what moving a flange up and level moves of each shaft, (..., n-1, 3, 2 + sines, 2).

    The gearbox's takes all shafts along, the axle's the last one alone, whose tube is on the
    axle's side of the spline. A flange does not tilt.
    """
    across, last = _frames(directions[..., end, :]), directions[..., -2, :]
    along = last[..., :, None] * (last[..., None, :] @ across)
    moved = np.zeros((*shape[:-1], 2))
    if end == 0:
        moved[..., :-1, :, 0, :] = across[..., None, :, :]
        moved[..., -1, :, 0, :], moved[..., -1, :, 1, :] = across - along, along - across
    else:
        moved[..., -1, :, 0, :], moved[..., -1, :, 1, :] = along, across - along
    return moved


def _cuts(d: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    """Return what breaks at the joints would move of each shaft, (..., n-1, 3, 2 + sines, 3 n)."""
    count = d.shape[-2]
    moved = np.zeros((*shape[:-1], 3 * (count + 1)))
    last = d[..., -1, :]
    along = last[..., :, None] * last[..., None, :]
    across = np.eye(3) - along
    for k in range(count):
        here = slice(3 * k, 3 * k + 3)
        moved[..., k:-1, :, 0, here] = np.eye(3)
        moved[..., -1, :, 0, here], moved[..., -1, :, 1, here] = across, -across
    moved[..., -1, :, 0, -3:], moved[..., -1, :, 1, -3:] = along, across
    return moved


def _shapes(
    at: FloatArray, lengths: FloatArray, sines: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return motion, tilt and curvature (..., P, 2 + sines) at places (..., P) of shafts."""
    L = lengths[..., None]
    one, none = np.ones_like(at), np.zeros_like(at)
    w, e, bent = [one, at], [none, one / L], [none, none]
    for j in range(1, sines + 1):
        wave = j * pi * at
        w.append(np.sin(wave))
        e.append(j * pi / L * np.cos(wave))
        bent.append(-((j * pi / L) ** 2) * np.sin(wave))
    first, second, third = (np.stack(np.broadcast_arrays(*rows), axis=-1) for rows in (w, e, bent))
    return first, second, third


def _masses(
    line: Line, lengths: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return where the masses of the shafts sit, and how much there, (..., n-1, P) each.

    Places as shares of the length, kg, and kg m² about a diameter and about the axis: the
    tube at Gauss's points, the yokes at the ends, the spline where it is.
    """
    tubes = [s.tube for s in line.shafts]
    splines = [s.spline for s in line.shafts]
    tube = stack_on_last_axis(t.mass_per_length if t else np.nan for t in tubes) * lengths
    turning = (
        stack_on_last_axis(t.polar_inertia_per_length if t else np.nan for t in tubes) * lengths
    )
    yoke = stack_on_last_axis(s.yoke_inertia / 2 for s in line.shafts)
    polar = stack_on_last_axis(
        np.nan if s.polar_inertia is None else s.polar_inertia for s in line.shafts
    )
    share = polar / (turning + 2 * yoke)  # 1, unless a given inertia takes the place of both
    ends = np.moveaxis(
        stack_on_last_axis(stack_on_last_axis(s.yoke_mass) for s in line.shafts), -1, -2
    )
    slide = stack_on_last_axis(s.mass if s else 0.0 for s in splines)
    where = stack_on_last_axis(s.from_front_joint if s else 0.0 for s in splines) / lengths

    def joined(*parts: FloatArray) -> FloatArray:
        lead = np.broadcast_shapes(lengths.shape, *(p.shape[:-1] for p in parts))
        return np.concatenate([np.broadcast_to(p, (*lead, p.shape[-1])) for p in parts], axis=-1)

    both, none = np.stack([yoke, yoke], axis=-1), np.zeros_like(where)[..., None]
    return (
        joined(_XI, where[..., None], np.array([0.0, 1.0])),
        joined(tube[..., None] * _WEIGHT, slide[..., None], ends),
        joined(turning[..., None] / 2 * _WEIGHT, none, both),
        joined((share * turning)[..., None] * _WEIGHT, none, share[..., None] * both),
    )


def _of(shape: FloatArray, fields: FloatArray) -> FloatArray:
    """Return what the coordinates move where a shaft has a shape, (..., n-1, 3, N)."""
    return (shape[..., None, None, :] @ fields)[..., 0, :]


def _summed(form: FloatArray, one: FloatArray, other: FloatArray) -> FloatArray:
    """Sum shafts' forms (..., n-1, B, B) in their fields (..., n-1, 3, B, N) to (..., N, N)."""
    right = form[..., None, :, :] @ other
    left = one.reshape(*one.shape[:-4], -1, one.shape[-1])
    return left.mT @ right.reshape(*right.shape[:-4], -1, right.shape[-1])


def _bending(line: Line, lengths: FloatArray, sines: int) -> FloatArray:
    """Return the tubes' stiffness, (..., n-1, B, B) N/m: of sines it is exact, with shear."""
    tubes = [s.tube for s in line.shafts]
    EI = stack_on_last_axis(t.bending_stiffness if t else np.nan for t in tubes)
    shear = stack_on_last_axis(t.shear_stiffness if t else np.nan for t in tubes)
    wave = pi * np.arange(1, sines + 1) / lengths[..., None]
    stiff = EI[..., None] * wave**4 * lengths[..., None] / 2
    stiff = stiff / (1 + wave**2 * (EI / shear)[..., None])
    diagonal = np.concatenate([np.zeros((*stiff.shape[:-1], 2)), stiff], axis=-1)
    return diagonal[..., None] * np.eye(2 + sines)


def _wound(lengths: FloatArray, sines: int) -> FloatArray:
    """Return ∫ e e' of the shafts' shapes, (..., n-1, B, B): how a torque works on their bend."""
    at = np.broadcast_to(_XI, (*lengths.shape, len(_XI)))
    _, e, bent = _shapes(at, lengths, sines)
    return (e * (_WEIGHT * lengths[..., None])[..., None]).mT @ bent


def _shortened(d: FloatArray, lengths: FloatArray, sines: int) -> FloatArray:
    """Return ∫ e'^2 of the shafts' shapes, (..., n-1, B, B) 1/m: twice what tilting shortens.

    Along the last shaft, whose spline takes it up: each shaft by the cosine between the two.
    """
    at = np.broadcast_to(_XI, (*lengths.shape, len(_XI)))
    _, e, _ = _shapes(at, lengths, sines)
    along = (d * d[..., -1:, :]).sum(-1)
    return (e * (_WEIGHT * (along * lengths)[..., None])[..., None]).mT @ e
