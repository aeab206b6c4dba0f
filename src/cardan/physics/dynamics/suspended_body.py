r"""A body hung from a universal joint and spun: when pin friction lets it go.

Small rotations a and b about the two pins, in the frame that turns with the shaft:

$$A\ddot a + c\,\dot a + (C-A-B)\Omega\,\dot b + [(C-B)\Omega^2 + mgl]\,a = 0$$
$$B\ddot b + c\,\dot b - (C-A-B)\Omega\,\dot a + [(C-A)\Omega^2 + mgl]\,b = 0$$

Without friction gyroscopic moments can hold a body up; with it, however little, only a
positive stiffness does (Kelvin, Chetaev). Source: Storozhenko, on the rotation of a rigid
body suspended on a universal joint; equations derived again from the Lagrangian.
"""

from dataclasses import dataclass

import numpy as np

from cardan.core.arrays import BoolArray, ComplexArray, FloatArray
from cardan.physics.dynamics.floquet import eigenvalues


@dataclass(frozen=True, slots=True, kw_only=True)
class BodySuspendedFromJoint:
    """A rigid body below a universal joint; cases on leading axes.

    Attributes
    ----------
    driving_inertia, driven_inertia : (...) kg m²
        A and B, about the joint's centre, of the axes along the driving and driven pin.
    polar_inertia : (...) kg m²
        C, about the body's own axis.
    weight_moment : (...) N m
        m g l, of the mass centre below the joint (negative above it).
    friction : (...) N m s/rad
        c, viscous in both pins.
    """

    driving_inertia: FloatArray | float
    driven_inertia: FloatArray | float
    polar_inertia: FloatArray | float
    weight_moment: FloatArray | float
    friction: FloatArray | float = 0.0

    def stiffness(self, speed: FloatArray | float) -> FloatArray:
        """Stiffness (..., 2) N m/rad about the driving and the driven pin at a speed, rad/s."""
        W2 = np.asarray(speed, dtype=float) ** 2
        A, B, C = (np.asarray(v, float) for v in (
            self.driving_inertia, self.driven_inertia, self.polar_inertia
        ))  # fmt: skip
        mgl = np.asarray(self.weight_moment, dtype=float)
        return np.stack(np.broadcast_arrays((C - B) * W2 + mgl, (C - A) * W2 + mgl), axis=-1)

    def stable_with_friction(self, speed: FloatArray | float) -> BoolArray:
        """Return whether (C-B)Ω² + mgl > 0 and (C-A)Ω² + mgl > 0, (...) bool."""
        return np.all(self.stiffness(speed) > 0, axis=-1)

    def speed_limit(self) -> FloatArray:
        """Speed (...) rad/s up to which it hangs steadily with friction: √(mgl / (max(A, B) - C)).

        Infinite for a body flatter than a ball, C >= A and B; 0 for one standing up.
        """
        A, B, C, mgl = np.broadcast_arrays(*(np.asarray(v, float) for v in (
            self.driving_inertia, self.driven_inertia, self.polar_inertia, self.weight_moment
        )))  # fmt: skip
        slender = np.maximum(A, B) - C
        with np.errstate(divide="ignore", invalid="ignore"):
            limit = np.sqrt(np.maximum(mgl, 0.0) / slender)
        return np.where((slender <= 0) & (mgl > 0), np.inf, np.where(mgl > 0, limit, 0.0))

    def exponents(self, speed: FloatArray | float) -> ComplexArray:
        """Exponents (..., 4) 1/s of small motions seen from the turning shaft."""
        A, B, C, c, W = np.broadcast_arrays(*(np.asarray(v, float) for v in (
            self.driving_inertia, self.driven_inertia, self.polar_inertia, self.friction, speed
        )))  # fmt: skip
        k = np.broadcast_to(self.stiffness(speed), (*A.shape, 2))
        G = (C - A - B) * W
        rate = np.zeros((*A.shape, 4, 4))
        rate[..., 0, 2] = rate[..., 1, 3] = 1.0
        rate[..., 2, 0], rate[..., 2, 2], rate[..., 2, 3] = -k[..., 0] / A, -c / A, -G / A
        rate[..., 3, 1], rate[..., 3, 3], rate[..., 3, 2] = -k[..., 1] / B, -c / B, G / B
        return eigenvalues(rate)
