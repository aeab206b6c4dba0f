"""Life of a joint's needle bearings, which rock by the joint angle twice a turn.

Catalogues rate a joint in one of two ways, which are one law:

    inch series   Lh = 1.5·10⁶ / (n β) · (Td/T)^(10/3)           Td: 5000 h at 100 rpm, 3 deg
    GWB           Lh = Lc·10¹⁰ / (n β T^(10/3) K1), T in kN m     Lc = 1.5·10⁻⁴ Td^(10/3)

with n in rpm and β in degrees. Lives are B10: nine joints in ten live longer, if greased.
"""

from typing import cast

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray, array_library_and_floats
from cardan.core.symbolic import ConstantWithDisplayText
from cardan.core.units import NewtonMetre, deg, hour, kNm, rpm
from cardan.model.parts import JointSize

MIN_LIFE_ANGLE_RAD = ConstantWithDisplayText(3 * deg, "3°", "3")
"""Needles that rock less wear as if they rocked so much (SAE AE-7; GWB)."""

PRIME_MOVER_FACTORS = {"electric": 1.0, "petrol": 1.2, "diesel": 1.25}
"""K1 of GWB's life formula, by what drives the line."""

_RATED = ConstantWithDisplayText(
    5000 * hour * 100 * rpm * MIN_LIFE_ANGLE_RAD, "1.5·10⁶", "1.5*10^6"
)
"""What a joint under its rated torque has behind it at the end of its life, rad²; h rpm deg."""


def gwb_rated_torque(bearing_factor: ArrayLike) -> FloatArray:
    """Return Td (...) N m of GWB's bearing capacity factor Lc (...): (Lc / 1.5·10⁻⁴)^0.3 kN m."""
    _, Lc = array_library_and_floats(bearing_factor)
    return (Lc / 1.5e-4) ** 0.3 * kNm


def rated_torque_from_catalogue(size: JointSize) -> NewtonMetre | None:
    """Return Td of a joint, whichever way its catalogue rates it; None if it does not."""
    if size.bearing_torque is None and size.bearing_factor is not None:
        return cast("NewtonMetre", gwb_rated_torque(size.bearing_factor))
    return size.bearing_torque


def rated_torque_if_life_computable(size: JointSize) -> NewtonMetre | None:
    """Return the torque a joint is rated for, if all is known that its life follows from."""
    rolls = size.kind in ("rzeppa", "tripod")
    if rolls and (size.rated_life is None or size.rated_speed is None):
        return None
    return rated_torque_from_catalogue(size)


def cross_joint_life_consumption_rate(
    torque: ArrayLike,
    *,
    speed: ArrayLike,
    angle: ArrayLike,
    rated_torque: ArrayLike,
    prime_mover_factor: ArrayLike,
) -> FloatArray:
    r"""Share of its life that a joint uses up in a second.

    $$\frac{1}{L} = K_1 \frac{\omega \beta}{5000\,\mathrm{h} \cdot 100\,\mathrm{rpm} \cdot
    3^\circ} \left( \frac{|T|}{T_d} \right)^{10/3}, \qquad \beta \ge 3^\circ$$

    Wear adds up, lives do not: this is the number to average, and it is 0 at rest.

    Parameters
    ----------
    torque : (...) N m
    speed : (...) rad/s
    angle : (...) rad
        Joint angle.
    rated_torque : (...) N m
        Td: carried for 5000 h at 100 rpm and 3 deg.
    prime_mover_factor : (...) 1
        K1, of `PRIME_MOVER_FACTORS`; 1 in the inch series' formula.

    Returns
    -------
    (...) 1/s

    Notes
    -----
    The exponent is that of roller bearings (ISO 281): a rocking of β to and fro twice is a
    turn's share β/90° per turn of the shaft, and 10⁶ turns of the needles are their rated
    life, hence 1.5·10⁶. Source: SAE AE-7 p. 31; Dana GWB catalogue, selection.
    """
    xp, T, n, beta, Td, K1 = array_library_and_floats(
        torque, speed, angle, rated_torque, prime_mover_factor
    )
    travel = xp.abs(n) * xp.maximum(beta, xp.asarray(MIN_LIFE_ANGLE_RAD))
    return K1 * travel / _RATED * (xp.abs(T) / Td) ** (10 / 3)


def life_consumption_rate(
    size: JointSize,
    torque: ArrayLike,
    *,
    speed: ArrayLike,
    angle: ArrayLike,
    prime_mover_factor: ArrayLike = 1.0,
) -> FloatArray:
    r"""Share of its life (...) 1/s that a joint of any kind uses up in a second.

    A cross by `wear`; the two of a double cardan at half its angle each. A Rzeppa's balls and
    a tripod's rollers from the maker's rating, M_r for L_r at n_r and β_r:

    $$L = L_r\,\frac{n_r}{n}\left(\frac{A(\beta) M_r}{A(\beta_r) |M|}\right)^p$$

    with p = 3 and A = (1 - sin β) cos² β of balls; of rollers p = 10/3, and as needles do they
    roll with the angle, by β_r/β at 3 deg or more, in place of A.

    Parameters
    ----------
    size
        Its kind and ratings; nan where they are not all given.
    torque, speed, angle : (...) N m, rad/s, rad
    prime_mover_factor : (...) 1

    Notes
    -----
    Sources: the exponents ISO 281; A of Rzeppa joints Seherr-Thoss et al. (2006), ch. 4,
    quoted, unverified; the tripod's angle derived from its rollers' travel.
    """
    _, M, n, beta, K1 = array_library_and_floats(torque, speed, angle, prime_mover_factor)
    rated = rated_torque_if_life_computable(size)
    shape = np.broadcast_shapes(M.shape, n.shape, beta.shape, K1.shape)
    if rated is None:
        return np.full(shape, np.nan)
    if size.kind in ("cross", "double cardan"):
        share = 1.0 if size.kind == "cross" else 0.5
        return cross_joint_life_consumption_rate(
            M, speed=n, angle=share * beta, rated_torque=rated, prime_mover_factor=K1
        )
    assert size.rated_life is not None  # or the rating were not complete
    assert size.rated_speed is not None
    at = np.asarray(0.0 if size.rated_angle is None else size.rated_angle)
    if size.kind == "rzeppa":
        stronger, p = _ball_share(beta) / _ball_share(at), 3.0
        rolling = 1.0 + 0 * beta
    else:
        stronger, p = 1.0, 10 / 3
        rolling = np.maximum(beta, MIN_LIFE_ANGLE_RAD) / np.maximum(at, MIN_LIFE_ANGLE_RAD)
    turned = np.abs(n) / size.rated_speed
    return K1 * turned * rolling / size.rated_life * (np.abs(M) / (stronger * rated)) ** p


def _ball_share(beta: ArrayLike) -> FloatArray:
    """Share A (...) of its torque that a Rzeppa joint carries at an angle (...) rad."""
    beta = np.asarray(beta, dtype=float)
    return (1 - np.sin(beta)) * np.cos(beta) ** 2


def joint_life(wear: ArrayLike, *, shares: ArrayLike | None = None) -> FloatArray:
    """Return the life (...) s of a joint that wears by `wear` (...) 1/s.

    With `shares` (..., p) of the time, the last axis of `wear` holds the points of a duty
    cycle, 1/L = Σ pᵢ/Lᵢ; what the shares leave of 1 is rest. Source: SAE AE-7 p. 31.

    Raises
    ------
    ValueError
        If shares add up to more than 1.

    Examples
    --------
    >>> used = cross_joint_life_consumption_rate(
    ...     500, speed=1500 * rpm, angle=5 * deg, rated_torque=2000, prime_mover_factor=1
    ... )
    >>> round(float(joint_life(used) / hour))
    20319
    """
    xp, rate = array_library_and_floats(wear)
    if shares is not None:
        _, p = array_library_and_floats(shares)
        total = p.sum(-1)
        if not xp.all(total <= 1 + 1e-9):
            msg = f"shares of a duty cycle must add up to at most 1, got {float(xp.max(total)):g}"
            raise ValueError(msg)
        rate = (p * rate).sum(-1)
    with np.errstate(divide="ignore"):
        return 1 / rate


def speed_angle_product(speed: ArrayLike, *, angle: ArrayLike) -> FloatArray:
    """Speed times joint angle, (...) rad²/s of (...) rad/s and (...) rad.

    The needles' rocking and the heat they make; catalogues limit it per size, in deg/min.
    For the GWB Compact sizes from 27 000 (2015, 6000 rpm at most) over 19 000 (2045, 4700)
    to 17 000 (2065, 3900).
    """
    xp, n, beta = array_library_and_floats(speed, angle)
    return xp.abs(n) * beta
