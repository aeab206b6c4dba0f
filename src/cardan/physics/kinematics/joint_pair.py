r"""Two Hooke joints with one shaft between them: what is left of the fluctuation, exactly.

The yoke phase δ and the angle ψ between the planes of the two joints act as their difference
alone. With r = tan²(β/2) of each joint the output turns as one joint of phasor

$$E = \frac{r_1 - r_2\,e^{2i(\delta - \psi)}}{1 - r_1 r_2\,e^{2i(\delta - \psi)}},
  \qquad \tan^2\frac{\beta_{eq}}{2} = |E|$$

would drive it: the composition of phasors of `cardan.physics.kinematics.joint_chain` for two
crosses. δ and ψ count right-handed about the shaft between the joints, in the direction from the
driving to the driven side: δ from the driven pin axis of joint 1 to the driving pin axis of
joint 2, as `phase_deg` of a shaft in an application file; ψ from the plane of joint 1 to that of
joint 2. ψ = 0 is the W arrangement, ψ = 180° the Z arrangement; both have the same output.

Massless, rigid, no clearance. Source: derived from first principles; AE-7 for small angles.
"""

from math import pi

from cardan.core.arrays import ArrayLike, ComplexArray, FloatArray, array_library_and_floats


def pair_phasor(
    beta: ArrayLike, beta2: ArrayLike, *, phase: ArrayLike, plane_angle: ArrayLike
) -> ComplexArray:
    """Phasor E (...) of the output of two joints, θ counted from the pin in the plane of joint 1.

    Parameters
    ----------
    beta, beta2 : (...) rad
        Angle of the driving and of the driven joint, from 0 to below π/2.
    phase : (...) rad
        Yoke phase δ of the shaft between the joints.
    plane_angle : (...) rad
        Angle ψ from the plane of joint 1 to the plane of joint 2.
    """
    xp, first, second, phase, plane = array_library_and_floats(beta, beta2, phase, plane_angle)
    r, step = xp.tan(first / 2) ** 2, xp.tan(second / 2) ** 2 * xp.exp(2j * (phase - plane))
    return (r - step) / (1 - r * step)


def equivalent_angle_of_phasor(phasor: ArrayLike) -> FloatArray:
    """Angle (...) rad of the single joint with the same fluctuation: 2 atan √|E|."""
    xp, size = array_library_and_floats(abs(phasor))  # type: ignore[arg-type]
    return 2 * xp.atan(xp.sqrt(size))


def phase_of_least_fluctuation(plane_angle: ArrayLike) -> FloatArray:
    """Yoke phase δ (...) rad that leaves the least fluctuation, in (-π/2, π/2].

    δ = ψ up to half a turn, whatever the two joint angles are.
    """
    _, plane = array_library_and_floats(plane_angle)
    return pi / 2 - (pi / 2 - plane) % pi


def phase_tolerance(beta: ArrayLike, beta2: ArrayLike, *, limit: ArrayLike) -> FloatArray:
    """Largest deviation (...) rad from the best phase that keeps an equivalent angle (...) rad.

    Solves |E| = tan²(limit/2) for δ - ψ. nan if no phase keeps the limit, π/2 if every phase
    does.
    """
    xp, first, second, limit = array_library_and_floats(beta, beta2, limit)
    r, r2 = xp.tan(first / 2) ** 2, xp.tan(second / 2) ** 2
    k, both = xp.tan(limit / 2) ** 4, r * r2
    least, most = xp.abs(r - r2) / (1 - both), (r + r2) / (1 + both)
    cos = (r**2 + r2**2 - k * (1 + both**2)) / xp.where(both > 0, 2 * both * (1 - k), 1.0)
    inside = xp.acos(xp.clip(cos, -1.0, 1.0)) / 2
    found = xp.where(most <= xp.sqrt(k), pi / 2 + 0 * inside, inside)
    return xp.where(least <= xp.sqrt(k) * (1 + 1e-12), found, xp.nan)
