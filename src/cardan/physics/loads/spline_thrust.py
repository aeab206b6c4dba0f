r"""Thrust of the sliding spline: a stiffness, limited by friction and by how far it is pushed in.

While a spline slides under torque T it carries P = ±μ T/r_m along the line, P > 0 in
compression. What is straight bends away from a compression, so P takes stiffness off:

$$K(P) = K + T K_T - P\, G, \qquad x' G x = \sum_j D_j^2/L_j$$

with D_j the lateral offset across shaft j. The line's mean shape under the crosses' moments f is

$$q(P) = K(P)^{-1} (f + P\, g), \qquad l(P) = g' q + q' G q/2$$

g is what a coordinate lengthens the spline by, l what the whole shape does. Bowing lengthens it:
dl/dP = (g + G q)' K(P)⁻¹ (g + G q) > 0 below the critical compression, the smallest P at which
det K(P) = 0. So a spline that friction holds takes up the suspension's shortening first, and P
is the one solution of l(P) = l of the held spline. Where that passes ±μ T/r_m, it slides there.

One eigenproblem of G in K + T K_T leaves sums over N modes for any P. The matrices are those
where the line lies; with the matrices of the bent line, by Newton's method, forces differ by 0.3 %
at three quarters of the critical compression.

Source: derived from first principles; forces and modes confirmed by a multibody engine.
"""

from math import prod

import numpy as np

from cardan.core.arrays import ArrayLike, BoolArray, FloatArray
from cardan.core.compiled import is_compiled_batch
from cardan.core.lazy_dataclass import dataclass
from cardan.physics.loads.compiled_line_loads import buckling_kernel, compression_kernel
from cardan.physics.loads.rubber_mount import MountedLine

LARGEST_SHARE_OF_CRITICAL = 1 - 1e-6
"""Of the critical compression, up to which the held spline's compression is sought."""

_ITERATIONS = 60
"""Halvings at most; Newton's method takes fewer than ten."""


PLACES_OF_A_STROKE = 64
"""Places of each case, about: a line is compressed at all of them at once."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CompressedLine:
    """A line on rubber under its torque, for any compression; cases on leading axes.

    Attributes
    ----------
    shapes : (..., N, N)
        Modes in columns, of K + T K_T = 1 and G = `softening`.
    softening : (..., N) 1/N
        Inverse of the compression at which a mode buckles.
    load, spline : (..., N)
        Moments f and gradient g of the spline's length on the modes.
    is_stable : (...)
        Whether the torque alone leaves it a stiffness.
    """

    shapes: FloatArray
    softening: FloatArray
    load: FloatArray
    spline: FloatArray
    is_stable: BoolArray

    @property
    def critical(self) -> FloatArray:
        """Smallest compression without a stiffness, (...) N; inf where there is none."""
        most = self.softening.max(-1)
        found = np.where(most > 0, 1 / np.where(most > 0, most, 1.0), np.inf)
        return np.where(self.is_stable, found, 0.0)

    def _modal(self, compression: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return the modes' displacements and what is left of their stiffness, (..., N)."""
        P = np.asarray(compression, dtype=float)[..., None]
        left = 1 - P * self.softening
        return (self.load + P * self.spline) / left, left

    def modal_motion(self, compression: ArrayLike) -> FloatArray:
        """Return the displacements (..., N) of the `shapes` at a compression (...) N."""
        return self._modal(compression)[0]

    def coordinates(self, compression: ArrayLike) -> FloatArray:
        """Return the mean shape at a compression (...) N, (..., N) m."""
        moved = self.modal_motion(compression)
        return (self.shapes @ moved[..., None])[..., 0]

    def lengthening(self, compression: ArrayLike) -> FloatArray:
        """Return how much longer that shape has the spline, (...) m."""
        moved = self.modal_motion(compression)
        return (moved * (self.spline + self.softening * moved / 2)).sum(-1)

    def spline_stiffness(self, compression: ArrayLike) -> FloatArray:
        """Return how fast compression rises as the held spline is shortened, (...) N/m."""
        moved, left = self._modal(compression)
        return 1 / ((self.spline + self.softening * moved) ** 2 / left).sum(-1)

    def compression_at_lengthening(
        self, lengthening: ArrayLike, *, least: ArrayLike, most: ArrayLike
    ) -> FloatArray:
        """Return the compression (...) N at which the shape lengthens the spline so much.

        Between `least` and `most` (...) N, below the critical one: there friction gives way.
        Newton's method, kept between bounds.
        """
        cases = np.broadcast_shapes(
            self.is_stable.shape, *(np.shape(v) for v in (lengthening, least, most))
        )
        low, high = (np.broadcast_to(np.asarray(v, dtype=float), cases) for v in (least, most))
        kernel = (
            compression_kernel() if is_compiled_batch(cases, points=PLACES_OF_A_STROKE) else None
        )
        if kernel:
            given = (np.broadcast_to(lengthening, cases), low, high)
            modes = (self.softening, self.load, self.spline)
            found = np.empty(prod(cases))
            kernel(
                *(
                    np.broadcast_to(v, (*cases, v.shape[-1])).reshape(-1, v.shape[-1])
                    for v in modes
                ),
                *(np.ascontiguousarray(v, dtype=float).reshape(-1) for v in given),
                _ITERATIONS,
                found,
            )
            return found.reshape(cases)
        first, last = (np.asarray(lengthening) - self.lengthening(P) for P in (low, high))
        # Where friction gives way first, that is the answer.
        low, high = np.where(last >= 0, high, low), np.where(first <= 0, low, high)
        found = np.clip(np.zeros(cases), low, high)
        for _ in range(_ITERATIONS):
            off = np.asarray(lengthening) - self.lengthening(found)
            low, high = np.where(off > 0, found, low), np.where(off < 0, found, high)
            guess = found + off * self.spline_stiffness(found)
            inside = (guess >= low) & (guess <= high)
            before, found = found, np.where(inside, guess, (low + high) / 2)
            if (np.abs(found - before) <= 1e-9 * (1 + np.abs(found))).all():
                break
        return found


def compressed_line(
    held: MountedLine, *, forces: FloatArray, spline: FloatArray, torque: ArrayLike
) -> CompressedLine:
    """Return a line on its mounts under forces and torque, for any compression.

    Parameters
    ----------
    held
        How it can move.
    forces, spline : (..., N) N, 1
        Mean moments of the crosses on its coordinates; the gradient of the spline's length
        (`MountedLine.spline_gradient`).
    torque : (...) N m
    """
    shapes, softening, stable = _buckling_modes(held, np.asarray(torque, dtype=float))
    return CompressedLine(
        shapes=shapes,
        softening=softening,
        load=(forces[..., None, :] @ shapes)[..., 0, :],
        spline=(spline[..., None, :] @ shapes)[..., 0, :],
        is_stable=stable,
    )


def _buckling_modes(
    held: MountedLine, torque: FloatArray
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return `shapes`, `softening` and `is_stable` of a `CompressedLine`."""
    own = np.broadcast_shapes(held.mass.shape[:-2], held.geometric.shape[:-2])
    lead, N = np.broadcast_shapes(torque.shape, own), held.mass.shape[-1]
    own = lead[len(lead) - len(own) :]
    kernel = buckling_kernel() if is_compiled_batch(own) else None
    if kernel is None:
        return _buckling_modes_by_lapack(held.stiffness_under_torque(torque), held.geometric)
    each = [
        np.broadcast_to(m, (*own, N, N)).reshape(-1, N, N)
        for m in (held.stiffness_under_torque(0.0), held.torsion, held.geometric)
    ]
    T = np.broadcast_to(torque, lead).reshape(-1, prod(own))
    shapes, softening = np.empty((*T.shape, N, N)), np.empty((*T.shape, N))
    stable = np.empty(T.shape, dtype=bool)
    kernel(*each, T, shapes, softening, stable)
    if not stable.all():
        case = np.nonzero(~stable)[1]
        K = each[0][case] + T[~stable][:, None, None] * each[1][case]
        shapes[~stable], softening[~stable], _ = _buckling_modes_by_lapack(K, each[2][case])
    return shapes.reshape(*lead, N, N), softening.reshape(*lead, N), stable.reshape(lead)


def _buckling_modes_by_lapack(
    K: FloatArray, geometric: FloatArray
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return the same of stiffnesses K (..., N, N) N/m under torque."""
    squares, vectors = np.linalg.eigh(K)
    stable = squares[..., 0] > 0
    squares = np.where(stable[..., None], squares, np.abs(squares) + squares[..., -1:])
    root = vectors / np.sqrt(squares)[..., None, :]
    softening, turned = np.linalg.eigh(root.mT @ geometric @ root)
    return root @ turned, softening, stable


@dataclass(frozen=True, kw_only=True, eq=False)
class StrokeCompression:
    """The compressions that a suspension's stroke reaches at its places, (..., places) N.

    Attributes
    ----------
    pushed, drawn
        Largest, and smallest: below 0 it is a tension.
    shortening : (..., 1) m
        How much the stroke would shorten a line that does not bow.
    """

    pushed: FloatArray
    drawn: FloatArray
    shortening: FloatArray


def stroke_compression(
    line: CompressedLine,
    *,
    length: FloatArray,
    rest_length: FloatArray,
    slip: ArrayLike,
    reached: ArrayLike = True,
    place_axes: tuple[int, ...] = (-1,),
) -> StrokeCompression:
    """Return the compression that friction leaves as a suspension goes through its stroke.

    The spline may have come to rest, P = 0, at any place of the stroke under the torque, or
    before the launch, under none. Held at the longest of these lengths it is pushed in
    everywhere else, to its slip force at most; held at the shortest, or where it was pushed to,
    it is drawn.

    Parameters
    ----------
    line
        Under the torque at the places of the stroke, on the last axis.
    length, rest_length : (..., places) m
        Of the spline, under the torque and under none, the line without a bow.
    slip : (..., places) N
        Thrust at which it slides there, μ T/r_m.
    reached : (..., places)
        Which places the stroke has.
    place_axes
        Axes of the places, where these are several.
    """
    slip = np.asarray(slip, dtype=float)
    most = np.minimum(slip, LARGEST_SHARE_OF_CRITICAL * line.critical)
    reached = np.asarray(reached, dtype=bool)

    def largest(values: FloatArray, sign: float = 1.0) -> FloatArray:
        kept = np.where(reached, sign * values, -np.inf)
        return sign * kept.max(place_axes, keepdims=True)

    still = length + line.lengthening(0.0)
    longest = np.maximum(largest(still), largest(rest_length))
    pushed = line.compression_at_lengthening(longest - length, least=-slip, most=most)
    held = np.minimum(longest, length + line.lengthening(most))
    shortest = np.minimum(largest(held, -1.0), largest(rest_length, -1.0))
    shortest = np.minimum(shortest, largest(still, -1.0))
    drawn = line.compression_at_lengthening(shortest - length, least=-slip, most=most)
    shortening = longest - largest(length + line.lengthening(0.0), -1.0)
    return StrokeCompression(pushed=pushed, drawn=drawn, shortening=shortening)
