r"""How the seat of a centre bearing gives: a bracket as the line that hangs in it feels it.

A bracket is a sum of modes. Those of its lowest frequencies are its own; three more make up
the rest of what it gives under the forces of the bearing, so that statics is exact. Force F
on the seat at a frequency W moves it by

$$u = \sum_i g_i \frac{g_i \cdot F}{ω_i^2 (1 + i η) - W^2}$$

and stresses the bracket as F at rest would, and as what the modes swing beyond that.

Source: mode displacement with residual flexibility, Craig & Kurdila, Fundamentals of
Structural Dynamics, 2nd ed. (2006), ch. 17; stresses by mode acceleration, ch. 11.
"""

import numpy as np

from cardan.core.arrays import ArrayLike, ComplexArray, FloatArray
from cardan.core.lazy_dataclass import dataclass

DEFAULT_BRACKET_LOSS_FACTOR = 0.02
"""Loss factor of a bolted bracket, assumed: steel frames in bolts have 0.01 to 0.04."""
_AT_ONCE = 1e-14
"""s², of a mode that follows at once: one without mass, or less than rounding leaves."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BracketCompliance:
    """A bracket reduced to m modes, as its seat moves in them; axes x, y, z of the vehicle.

    Attributes
    ----------
    frequencies : (m,) rad/s
    seat_mode_shapes : (m, 3) kg^-1/2
        Of the seat in each mode of unit modal mass.
    mode_composition : (m, c)
        Of what each mode is made: columns of unit forces at the seat and of mode shapes.
    loss_factor
        Share η of its energy that the bracket loses in a radian.
    """

    frequencies: FloatArray
    seat_mode_shapes: FloatArray
    mode_composition: FloatArray
    loss_factor: float = DEFAULT_BRACKET_LOSS_FACTOR

    @property
    def static_compliance(self) -> FloatArray:
        """Motion under unit forces at rest, (3, 3) m/N."""
        return self.dynamic_compliance(0.0).real

    def dynamic_compliance(self, frequency: ArrayLike) -> ComplexArray:
        """Return the motion under unit forces at frequencies (...) rad/s, (..., 3, 3) m/N."""
        return (
            self.seat_mode_shapes.T * self._swing(frequency)[..., None, :]
        ) @ self.seat_mode_shapes

    def dynamic_increment(self, forces: ArrayLike, frequency: ArrayLike) -> ComplexArray:
        """Return what a force does beyond what it does at rest, (..., c) as in `parts`.

        Parameters
        ----------
        forces : (..., 3) N
            Complex amplitudes.
        frequency : (...) rad/s
        """
        more = self._swing(frequency) - 1 / self.frequencies**2
        return (np.asarray(forces) @ self.seat_mode_shapes.T * more) @ self.mode_composition

    def dynamic_increment_history(self, forces: ArrayLike, duration: float) -> FloatArray:
        """Return the same of histories (..., t, 3) N that come back after a time in s, (..., t, c).

        Its mean rests. Exact where the history is sampled finely enough to know its orders.
        """
        forces = np.asarray(forces, dtype=float)
        waves = np.fft.rfft(forces, axis=-2)
        W = 2 * np.pi / duration * np.arange(waves.shape[-2])
        beyond = self.dynamic_increment(waves, W)
        beyond[..., 0, :] = 0.0
        return np.fft.irfft(beyond, n=forces.shape[-2], axis=-2)

    def _swing(self, frequency: ArrayLike) -> ComplexArray:
        """Return modal amplitude for a modal force of 1, (..., m) s²; at rest nothing is lost."""
        W = np.asarray(frequency, dtype=float)[..., None]
        lost = 1j * self.loss_factor * np.sign(W)
        return 1 / (self.frequencies**2 * (1 + lost) - W**2)


def reduce_to_bracket_compliance(
    compliance: ArrayLike,
    *,
    frequencies: ArrayLike,
    motion: ArrayLike,
    inertia: ArrayLike,
    loss: float = DEFAULT_BRACKET_LOSS_FACTOR,
) -> BracketCompliance:
    """Return a bracket reduced to k modes of its own and what they leave of its statics.

    Parameters
    ----------
    compliance : (3, 3) m/N
        Motion of the seat under unit forces at rest.
    frequencies : (k,) rad/s
    motion : (k, 3) kg^-1/2
        Of the seat in each mode, of unit modal mass.
    inertia : (3, 3) kg m²/N²
        Of what unit forces at rest move: u · M u.
    loss
        Share η of its energy that the bracket loses in a radian.

    Notes
    -----
    Less its share of the modes a static shape is square to them, both by mass and by stiffness:
    the three that are left are modes by themselves, by Rayleigh and Ritz.
    """
    ω, own = np.asarray(frequencies, dtype=float), np.asarray(motion, dtype=float)
    share = own / ω[:, None] ** 2  # of each mode in the static shapes
    rest = np.asarray(compliance, dtype=float) - own.T @ share
    mass = np.asarray(inertia, dtype=float) - share.T @ share
    # Whitened by the stiffness; what the modes leave nothing of is left out.
    size, axes = np.linalg.eigh((rest + rest.T) / 2)
    kept = size > 1e-9 * max(float(np.trace(np.asarray(compliance))), 1e-300)
    white = axes[:, kept] / np.sqrt(size[kept])
    slow, turned = np.linalg.eigh(white.T @ ((mass + mass.T) / 2) @ white)
    slow = np.maximum(slow, _AT_ONCE)
    shapes = white @ turned / np.sqrt(slow)
    extra = np.concatenate([shapes.T, -(share @ shapes).T], axis=1)
    mine = np.concatenate([np.zeros((len(ω), 3)), np.eye(len(ω))], axis=1)
    return BracketCompliance(
        frequencies=np.concatenate([ω, 1 / np.sqrt(slow)]),
        seat_mode_shapes=np.concatenate([own, (rest @ shapes).T]),
        mode_composition=np.concatenate([mine, extra]),
        loss_factor=loss,
    )


def bracket_compliance_from_stiffness(
    stiffness: tuple[float, float, float], *, loss: float = DEFAULT_BRACKET_LOSS_FACTOR
) -> BracketCompliance:
    """Return a bracket of which no more is known than its stiffness along x, y and z, N/m."""
    none = np.zeros((0, 3))
    return reduce_to_bracket_compliance(
        np.diag(1 / np.array(stiffness)), frequencies=none[:, 0], motion=none,
        inertia=np.zeros((3, 3)), loss=loss,
    )  # fmt: skip
