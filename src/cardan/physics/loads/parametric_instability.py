r"""Whether a line's swinging on its rubber grows by itself under the torque that swings with it.

The crosses' moments turn with the shafts, and half of that comes twice a turn
(`MountedLine.order2_coupling`): a stiffness that goes up and down at 2 Ω. Where that meets the sum
of two modes, one feeds the other and both grow, unless the rubber takes more than they are fed:
then the steady answer to what shakes the line (`MountedLine.harmonic_balance`) is there, but
nothing runs so.

In modes of unit mass, $x = e^{λt} (A e^{iΩt} + B e^{-iΩt})$ with

$$[(λ ± iΩ)^2 + (λ ± iΩ) (2 d + Ω G) + ω^2] \begin{pmatrix} A \\ B \end{pmatrix}
  = \frac T2 \begin{pmatrix} S B \\ \bar S A \end{pmatrix}$$

(`line_swing_growth_rate`), and of two modes alone to first order (`two_mode_growth`)

$$λ = -\frac{d_i + d_j}{2} +
  \mathrm{Re} \sqrt{\left(\frac{d_i - d_j + i s}{2}\right)^2 + \frac{T^2 |S_{ij}|^2}{16 ω_i ω_j}},
  \qquad s = 2 Ω - ω_i - ω_j$$

which grows in the middle of its zone from $T |S_{ij}| = 4 \sqrt{ω_i ω_j d_i d_j}$ on. Zones at
shares of that speed, 2 Ω = (ω_i + ω_j)/k, are of higher order in T S/ω², and rubber closes them.
A loss is taken as that of dampers that lose as much at each mode.

Source: harmonic balance of Hill's equation; two modes by averaging, as Asokanthan and Hwang have
it for torsion. Held against Floquet multipliers of a time integration in the tests.
"""

from math import prod

import numpy as np

from cardan.core.arrays import ArrayLike, ComplexArray, FloatArray
from cardan.core.batched_linalg import case_table, matrix_axes_first
from cardan.core.compiled import is_compiled_batch
from cardan.model.parts import Line
from cardan.physics.loads.compiled_line_loads import growth_kernel
from cardan.physics.loads.mean_line_loads import yoke_table
from cardan.physics.loads.rubber_mount import MountedLine


def two_mode_growth(
    on: MountedLine, swing: ComplexArray, *, speed: ArrayLike, torque: ArrayLike
) -> FloatArray:
    """Return the largest growth of any two modes by themselves, (...) 1/s.

    It is nearly `line_swing_growth_rate`.

    To this order it is the same whichever way the line turns.
    """
    speed, torque = np.asarray(speed, dtype=float), np.asarray(torque, dtype=float)
    squares, shapes, decay = on.modes_with_decay(torque)
    ω = np.sqrt(np.maximum(squares, 1e-9))
    i, j = np.triu_indices(ω.shape[-1])  # `swing` is symmetric
    parts = (shapes.mT @ part @ shapes for part in (swing.real, swing.imag))
    size2 = sum(part[..., i, j] ** 2 for part in parts) * torque[..., None] ** 2
    s = 2 * np.abs(speed)[..., None] - ω[..., i] - ω[..., j]
    d, e = decay[..., i], decay[..., j]
    fed = size2 / (16 * ω[..., i] * ω[..., j])
    beyond = np.sqrt(((d - e + 1j * s) / 2) ** 2 + fed)
    return (np.real(beyond) - (d + e) / 2).max(-1)


def two_mode_growth_of_line(
    on: MountedLine,
    line: Line,
    directions: FloatArray,
    phases: ArrayLike,
    *,
    speed: FloatArray,
    torque: FloatArray,
) -> FloatArray | None:
    """Return `two_mode_growth` (P, ..., S) of a large batch by a compiled loop.

    None where that serves nothing: few cases, no numba, or a joint that locks. The line lies alike
    at all points: `directions` (..., S, n+1, 3).
    """
    cases = speed.shape[1:]
    own = np.broadcast_shapes(
        on.case_last_matrices.cases, directions.shape[:-2], np.shape(phases)[:-1]
    )
    kernel = growth_kernel() if is_compiled_batch(cases) and len(own) <= len(cases) else None
    if kernel is None:
        return None
    C, n = prod(cases), line.joint_count
    points = np.stack([np.broadcast_to(v, speed.shape) for v in (speed, torque)])
    growth = np.empty((len(speed), C))
    runs = kernel(
        on.case_last_matrices.case_table(cases),
        case_table([(matrix_axes_first(directions, of=2), 2)], cases).reshape(C, n + 1, 3),
        yoke_table(line, phases, cases),
        np.array(line.is_cross, dtype=float),
        *on.tilt_tables(cases),
        points.reshape(2, len(speed), C),
        growth,
    )
    return growth.reshape(speed.shape) if runs else None


def line_swing_growth_rate(
    on: MountedLine, swing: ComplexArray, *, speed: ArrayLike, torque: ArrayLike
) -> FloatArray:
    """Return the largest growth λ of a line's swinging, (...) 1/s; below 0 it decays.

    Parameters
    ----------
    on
        The line, in as many modes as may meet (`MountedLine.modal_reduction`).
    swing : (..., N, N)
        `MountedLine.order2_coupling` where it runs.
    speed, torque : (...) rad/s, N m
        Signed.
    """
    speed, torque = (np.asarray(v, dtype=float)[..., None, None] for v in (speed, torque))
    squares, shapes, decay = on.modes_with_decay(torque[..., 0, 0])
    one = np.eye(squares.shape[-1])
    K = squares[..., None] * one
    C = K * 0 + 2 * decay[..., None] * one + speed * (shapes.mT @ on.gyroscopic @ shapes)
    S = K * 0 + torque / 2 * (shapes.mT @ swing @ shapes)
    W, one, none = K * 0 + speed * one, K * 0 + one, K * 0
    # Of a real motion B is A conjugate: the real and imaginary parts of A, then of its velocity.
    whole = np.block([
        [none, W, one, none],
        [-W, none, none, one],
        [S.real - K, S.imag, -C, W],
        [S.imag, -S.real - K, -W, -C],
    ])  # fmt: skip
    return np.linalg.eigvals(whole).real.max(-1)
