"""Lines whose rubber has stops, and what forces of these stops move.

The equations: `cardan.physics.loads.rubber_stop_response`.
"""

from dataclasses import replace

import numpy as np

from cardan.core.arrays import ComplexArray, FloatArray, IntArray
from cardan.core.batched_linalg import broadcast_cases, matrix_axes_first, matrix_product, solve
from cardan.core.lazy_dataclass import dataclass
from cardan.physics.loads.rubber_mount import MountedLine
from cardan.physics.loads.rubber_stop_contact import PLACES_OF_ORDERS, STOP_ORDERS

_LAST_TIED_ORDER = 4
_TIED_COMPONENTS = 1 + 2 * sum(order <= _LAST_TIED_ORDER for order in STOP_ORDERS)


@dataclass(frozen=True, kw_only=True, eq=False)
class StopReceptance:
    """What a stop's forces at the bearings move them, with what it loses, at speeds Q; m/N.

    Attributes
    ----------
    tied : (Q, U, 5 2B, 5 2B)
        Of the mean and orders 2 and 4, which the torque ties to one another, components as
        `StoppedLine.free` has them.
    alone : (Q, W, K, 4 B, 4 B)
        Of each order above: the real parts, then the imaginary ones.
    tied_of, alone_of : (C,)
        Which of the lines U and W each case is.
    """

    tied: FloatArray
    alone: FloatArray
    tied_of: IntArray
    alone_of: IntArray

    def select_cases(self, which: IntArray) -> "StopReceptance":
        """Return that of some of the cases."""
        return replace(self, tied_of=self.tied_of[which], alone_of=self.alone_of[which])

    def at_places(self, place: FloatArray, cases: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return `tied` and `alone` of cases (C',) at a place of the speeds each."""
        return (
            at_places(self.tied, place, self.tied_of[cases]),
            at_places(self.alone, place, self.alone_of[cases]),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class StoppedLine:
    """Lines whose rubber has stops, at speeds Q of cases C; B bearings, two directions each.

    Attributes
    ----------
    free : (Q, C, M, 2 B) m
        Travel on linear rubber across the shafts, M components: mean, then real and imaginary
        part of each of `STOP_ORDERS`.
    receptance
        What a stop's forces at the bearings move them.
    stiffness : (C, B, 2) N/m
    stop : (C, B) m
        Travel to the stop; inf where there is none.
    ratio : (C, B)
        Stiffness beyond it over that before it.
    """

    free: FloatArray
    receptance: StopReceptance
    stiffness: FloatArray
    stop: FloatArray
    ratio: FloatArray

    def select_cases(self, which: IntArray) -> "StoppedLine":
        """Return some of the cases."""
        return StoppedLine(
            free=self.free[:, which],
            receptance=self.receptance.select_cases(which),
            stiffness=self.stiffness[which],
            stop=self.stop[which],
            ratio=self.ratio[which],
        )


def tied_receptance(
    on: MountedLine,
    coupling: ComplexArray,
    *,
    speed: FloatArray,
    torque: FloatArray,
    compression: FloatArray,
) -> FloatArray:
    """Return `StopReceptance.tied` of lines, (..., 5 2B, 5 2B) m/N.

    Of a line in small motion at a speed rad/s under a torque N m, signed, whose order 2
    (`coupling` (..., N, N) of 1 N m, `MountedLine.order2_coupling`) ties orders 0, 2 and 4.
    A compression (...) N of the spline, which slides, takes stiffness off the mean.
    """
    N = on.mass.shape[-1]
    across = _across(on)
    S = torque[..., None, None] * coupling / 2
    Sr, Si = S.real, S.imag
    cases, size = np.broadcast_shapes(S.shape[:-2], speed.shape), across.shape[-2]
    tied = np.zeros((*cases, 5, N, 5, N))
    tied[..., 0, :, 0, :] = (
        on.stiffness_under_torque(torque) - compression[..., None, None] * on.geometric
    )
    tied[..., 0, :, 1, :], tied[..., 0, :, 2, :] = -Sr, -Si
    tied[..., 1, :, 0, :], tied[..., 2, :, 0, :] = -2 * Sr, -2 * Si
    tied[..., 1, :, 3, :], tied[..., 1, :, 4, :] = -Sr, -Si
    tied[..., 2, :, 3, :], tied[..., 2, :, 4, :] = Si, -Sr
    tied[..., 3, :, 1, :], tied[..., 3, :, 2, :] = -Sr, Si
    tied[..., 4, :, 1, :], tied[..., 4, :, 2, :] = -Si, -Sr
    for at, order in PLACES_OF_ORDERS[: _TIED_COMPONENTS // 2]:
        D = on.dynamic_stiffness(order * speed, speed, torque)
        tied[..., at, :, at, :] = tied[..., at + 1, :, at + 1, :] = D.real
        tied[..., at, :, at + 1, :], tied[..., at + 1, :, at, :] = -D.imag, D.imag
    each = np.zeros((*cases, 5, N, 5, size))
    for k in range(5):
        each[..., k, :, k, :] = across.mT
    pushes = each.reshape(*cases, 5 * N, 5 * size)
    moved = pushes.mT @ np.linalg.solve(tied.reshape(*cases, 5 * N, 5 * N), pushes)
    found = moved.reshape(*cases, 5, size, 5, size)
    for at, order in PLACES_OF_ORDERS[: _TIED_COMPONENTS // 2]:
        lost = order / 2 * _loss(on, speed)[..., None, None, :]  # times 1 + i η m/2
        real, imaginary = found[..., at, :].copy(), found[..., at + 1, :].copy()
        found[..., at, :] = real + lost * imaginary
        found[..., at + 1, :] = imaginary - lost * real
    return found.reshape(*cases, 5 * size, 5 * size)


def receptance_alone(on: MountedLine, *, speed: FloatArray, torque: FloatArray) -> FloatArray:
    """Return `StopReceptance.alone` of the same lines, (..., K, 4 B, 4 B) m/N."""
    orders = np.array([order for order in STOP_ORDERS if order > _LAST_TIED_ORDER], dtype=float)
    each, rows = orders.reshape(-1, *(1,) * speed.ndim), _across(on)
    axes = max(each.ndim, len(on.case_last_matrices.cases))
    line = on.case_last_matrices.select_cases(slice(None), axes)
    across = broadcast_cases(matrix_axes_first(rows, of=2), axes, of=2)
    D = line.dynamic_stiffness(each * speed, speed, torque)
    moved = matrix_product(across, solve(D, across.swapaxes(0, 1)))
    loss = 0.5j * orders[:, None, None] * _loss(on, speed)[..., None, None, :]
    H = np.moveaxis(moved, (2, 0, 1), (-3, -2, -1)) * (1 + loss)
    size = H.shape[-1]
    found = np.empty((*H.shape[:-2], 2, size, 2, size))
    found[..., 0, :, 0, :] = found[..., 1, :, 1, :] = H.real
    found[..., 0, :, 1, :], found[..., 1, :, 0, :] = -H.imag, H.imag
    return found.reshape(*H.shape[:-2], 2 * size, 2 * size)


def _across(on: MountedLine) -> FloatArray:
    """Return the bearings' motions across the shafts, (..., 2 B, N)."""
    return on.bearing[..., :2, :].reshape(*on.bearing.shape[:-3], -1, on.mass.shape[-1])


def _loss(on: MountedLine, speed: FloatArray) -> FloatArray:
    """Return the loss factors of each travel, signed as the speed, (..., 2 B)."""
    return np.sign(speed)[..., None] * np.repeat(on.loss, 2, axis=-1)


def at_places(values: FloatArray, place: FloatArray, cases: IntArray | None = None) -> FloatArray:
    """Return values (Q, C, ...) at places (T, C) or (C,) between the speeds, linear between two.

    Of all cases, or of those that `cases` names.
    """
    last = len(values) - 1
    of = np.arange(values.shape[1]) if cases is None else cases
    place = np.where(np.isnan(place), 0.0, place)
    low = np.minimum(place.astype(int), max(last - 1, 0))
    share = place - low
    share = share.reshape(*share.shape, *(1,) * (values.ndim - 2))
    if not share.any():
        return values[low, of]
    return (1 - share) * values[low, of] + share * values[np.minimum(low + 1, last), of]


def moved_by(tied: FloatArray, alone: FloatArray, forces: FloatArray) -> FloatArray:
    """Return the travels m that forces (C', M D, R) N make, as many as forces.

    With receptances (C', 5 D, 5 D) and (C', K, 2 D, 2 D) as `StopReceptance` has them.
    """
    first = tied.shape[-1]
    found = np.empty_like(forces)
    found[:, :first] = tied @ forces[:, :first]
    rest = forces[:, first:].reshape(*alone.shape[:-1], -1)
    found[:, first:] = (alone @ rest).reshape(len(forces), -1, forces.shape[-1])
    return found
