r"""Upper estimate of a line whose spline is held: its length's slope at rest alone, order by order.

Linear about the line at rest under a compression P₀, with s = g + G q₀ its spline's slope there:

$$D\, q_2 = f_2 + T K_2\, q_0 + s\, p_2, \quad s' q_2 = 0, \quad D = K + T K_T - P_0 G - W^2 M$$

One bordered solution for each point, where Newton's method has orders 0 to 6 at once. The square
of the length, which is left out here, stiffens the line and draws its spline, so it takes force
off a resonance (`stuck_spline`).

Source: derived from first principles; held against `stuck_spline` by tests.
"""

import numpy as np

from cardan.core.arrays import ComplexArray, FloatArray
from cardan.core.lazy_dataclass import dataclass
from cardan.physics.loads.rubber_mount import MountedLine


def held_line_frequencies(stiffness: FloatArray, mass: FloatArray, slope: FloatArray) -> FloatArray:
    """Return the frequencies of the N - 1 modes of a line of fixed length, (..., N - 1) rad/s.

    Parameters
    ----------
    stiffness, mass : (..., N, N) N/m, kg
    slope : (..., N) 1
        How much the coordinates lengthen its spline. 0 has no constraint; then the fastest N - 1
        modes are returned.
    """
    per = np.linalg.inv(np.linalg.cholesky(mass))
    along = (per @ slope[..., None])[..., 0]
    size = np.linalg.norm(along, axis=-1, keepdims=True)
    along = along / np.where(size > 0, size, 1.0)
    matrix = per @ stiffness @ per.mT
    # No coordinate moves along the constraint: out of the matrix on both sides.
    row = (along[..., None, :] @ matrix)[..., 0, :]
    twice = along[..., :, None] * row[..., None, :]
    matrix = matrix - twice - twice.mT
    matrix = matrix + (row * along).sum(-1)[..., None, None] * (
        along[..., :, None] * along[..., None, :]
    )
    if mass.shape[-1] == 2:  # whose other eigenvalue is 0
        squares = np.trace(matrix, axis1=-2, axis2=-1)[..., None]
    else:
        each = np.linalg.eigvalsh(matrix)
        gone = np.abs(each).argmin(-1)[..., None]
        kept = np.arange(each.shape[-1] - 1)
        squares = np.take_along_axis(each, kept + (kept >= gone), axis=-1)
    return np.sqrt(np.maximum(squares, 0.0))


@dataclass(frozen=True, kw_only=True, eq=False)
class HeldLineWave:
    """One order of a line of fixed length: coordinates (..., N) m and compression (...) N."""

    coordinates: ComplexArray
    compression: ComplexArray


def held_line_wave(
    on: MountedLine,
    push: ComplexArray,
    slope: FloatArray,
    *,
    order: int,
    speed: FloatArray,
    torque: FloatArray,
    compression: FloatArray,
) -> HeldLineWave:
    """Return how a line of fixed length moves at an order of its speed, about its place at rest.

    Parameters
    ----------
    on
        How it can move; cases (...) on leading axes.
    push, slope : (..., N) N, 1
        Complex amplitude of what pushes it; how much the coordinates lengthen the spline.
    speed, torque, compression : (...) rad/s, N m, N
        Signed; the compression is that at rest.
    """
    unpressed = on.dynamic_stiffness(order * speed, speed, torque)
    D = unpressed - compression[..., None, None] * on.geometric
    both = np.stack(np.broadcast_arrays(push, slope.astype(complex)), axis=-1)
    free, per_thrust = np.moveaxis(np.linalg.solve(D, both), -1, 0)
    P = -(slope * free).sum(-1) / (slope * per_thrust).sum(-1)
    return HeldLineWave(coordinates=free + P[..., None] * per_thrust, compression=P)
