r"""Damping that turns with the shaft: it calms below a speed and drives whirl above it.

A disc of mass m on a shaft of stiffness k, with external damping c_e fixed in space and
internal damping that sees the shaft's deflection from the turning frame:

    viscous       m z'' + (c_e + c_i) z' + (k - i Ω c_i) z = 0
    hysteretic    m z'' + c_e z' + k (1 + i η sgn(w - Ω)) z = 0,  w the whirl's frequency

Source: Vatta & Vigliani, Internal damping in rotating shafts, Mech. Mach. Theory 43 (2008)
1376-1384; the equations are compared, the paper's figures were not at hand.
"""

import numpy as np

from cardan.core.arrays import ArrayLike, ComplexArray, FloatArray


def viscous_whirl_exponents(
    *,
    speed: ArrayLike,
    mass: ArrayLike,
    stiffness: ArrayLike,
    external: ArrayLike,
    internal: ArrayLike,
) -> ComplexArray:
    """Exponents (..., 2) 1/s of forward and backward whirl, in closed form.

    Parameters
    ----------
    speed, mass, stiffness : (...) rad/s, kg, N/m
        Ω, m and k.
    external, internal : (...) N s/m
        c_e and c_i.
    """
    W, m, k, ce, ci = (
        np.asarray(v, dtype=float) for v in (speed, mass, stiffness, external, internal)
    )
    half = (ce + ci) / (2 * m)
    root = _forward(half**2 - (k - 1j * W * ci) / m)
    return np.stack([-half + root, -half - root], axis=-1).astype(complex)


def viscous_threshold(
    *, frequency: ArrayLike, external: ArrayLike, internal: ArrayLike
) -> FloatArray:
    """Speed (...) rad/s above which forward whirl grows: w_n (1 + c_e / c_i).

    Exact at any damping. Infinite without internal damping.
    """
    with np.errstate(divide="ignore"):
        share = np.asarray(external, dtype=float) / np.asarray(internal, dtype=float)
    return np.asarray(frequency, dtype=float) * (1 + share)


def hysteretic_whirl_growth(
    *,
    speed: ArrayLike,
    mass: ArrayLike,
    stiffness: ArrayLike,
    external: ArrayLike,
    loss_factor: ArrayLike,
) -> FloatArray:
    """Growth (..., 2) 1/s of forward and backward whirl with hysteretic internal damping.

    The loss per cycle does not depend on how fast the shaft turns past its whirl, only on
    which of the two is faster; `loss_factor` is η.
    """
    W, m, k, ce, eta = (
        np.asarray(v, dtype=float) for v in (speed, mass, stiffness, external, loss_factor)
    )
    natural = np.sqrt(k / m)
    sense = np.sign(natural - W)
    half = ce / (2 * m)
    forward = -half + _forward(half**2 - k / m * (1 + 1j * eta * sense))
    # Backward whirl always sees the material turn the other way: it is always damped.
    backward = -half + _forward(half**2 - k / m * (1 + 1j * eta))
    return np.stack(np.broadcast_arrays(forward.real, backward.real), axis=-1)


def _forward(square: ComplexArray) -> ComplexArray:
    """Return the root that whirls forward."""
    root = np.asarray(np.sqrt(square + 0j), dtype=np.complex128)
    return np.where(root.imag < 0, -root, root)


def hysteretic_threshold(
    *, mass: ArrayLike, stiffness: ArrayLike, external: ArrayLike, loss_factor: ArrayLike
) -> FloatArray:
    """Speed (...) rad/s above which forward whirl grows: the critical speed itself, or never.

    Above it the internal damping feeds in η k a turn, and c_e w takes out: with
    c_e w_n >= η k (small damping) no speed is unstable.
    """
    m, k, ce, eta = (np.asarray(v, dtype=float) for v in (mass, stiffness, external, loss_factor))
    natural = np.sqrt(k / m)
    above = hysteretic_whirl_growth(
        speed=2 * natural, mass=m, stiffness=k, external=ce, loss_factor=eta
    )[..., 0]
    return np.where(above > 0, natural, np.inf)
