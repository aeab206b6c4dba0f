"""Whether tube and joints carry the torque: stress, ratings, and the smallest size that does."""

from collections.abc import Iterable
from math import inf, pi, sqrt

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray, array_library_and_floats
from cardan.core.errors import DesignError
from cardan.core.lazy_dataclass import dataclass
from cardan.core.symbolic import ConstantWithDisplayText
from cardan.core.units import NewtonMetre
from cardan.model.parts import JointSize
from cardan.physics.strength.bearing_life import (
    joint_life,
    life_consumption_rate,
    rated_torque_from_catalogue,
    rated_torque_if_life_computable,
    speed_angle_product,
)

_ROOT3 = ConstantWithDisplayText(sqrt(3), "√3", "SQRT(3)")

ULTIMATE_SHEAR_RATIO = 0.67
"""Ultimate shear strength of steel over its ultimate strength (Shigley)."""


def tube_shear_stress(torque: ArrayLike, *, outer: ArrayLike, inner: ArrayLike) -> FloatArray:
    """Shear stress at the outside of a tube, (...) Pa: τ = 16 T D / (π (D⁴ − d⁴)).

    `torque` in N m, diameters `outer` D and `inner` d in m, all (...). Away from welds and
    yokes. Source: any handbook; Seherr-Thoss et al. (2006).

    Examples
    --------
    >>> round(float(tube_shear_stress(10e3, outer=0.1, inner=0.09)) / 1e6, 1)
    148.1
    """
    xp, T, D, d = array_library_and_floats(torque, outer, inner)
    return 16 * T * D / (xp.pi * (D**4 - d**4))


def tube_bending_stress(moment: ArrayLike, *, outer: ArrayLike, inner: ArrayLike) -> FloatArray:
    """Bending stress at the outside of a tube, (...) Pa: σ = 32 M D / (π (D⁴ − d⁴)).

    A joint at angle β under torque T bends the shaft behind it by at most T tan β.
    """
    return 2 * tube_shear_stress(moment, outer=outer, inner=inner)


def von_mises_stress(shear: ArrayLike, *, normal: ArrayLike = 0.0) -> FloatArray:
    """Equivalent stress of shear and normal stress, (...) Pa: √(σ² + 3 τ²)."""
    xp, tau, sigma = array_library_and_floats(shear, normal)
    return xp.sqrt(sigma**2 + 3 * tau**2)


def tube_utilisation(
    torque: ArrayLike,
    *,
    outer: ArrayLike,
    inner: ArrayLike,
    yield_strength: ArrayLike,
    shock_factor: ArrayLike,
) -> FloatArray:
    """Share of a tube's yield strength in shear that a torque uses, (...).

    τ / (Re/√3), with τ of the torque (...) N m times the shock factor. Source: von Mises.
    """
    _, T, Re, shock = array_library_and_floats(torque, yield_strength, shock_factor)
    return tube_shear_stress(abs(T) * shock, outer=outer, inner=inner) / (Re / _ROOT3)


_SLENDER = (
    0.5, 0.7, 1.0, 1.4, 1.8, 2.2, 2.6, 3.0, 3.5, 4.0, 4.5, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 15.0,
    20.0, 60.0,
)  # fmt: skip
_SHARE = (
    0.247, 0.293, 0.348, 0.422, 0.474, 0.510, 0.558, 0.627, 0.694, 0.744, 0.783, 0.814, 0.862,
    0.894, 0.916, 0.944, 0.962, 0.976, 0.985, 1.0,
)  # fmt: skip
"""Buckling torque of an endless tube over that of one L long, at L/r √(t/r): the largest for
t/r of 0.003 to 0.05 by `composite.min_buckling_torque`, which takes 0.05 s a tube, too long for a
study, and 0.8 % more for what lies between."""


def tube_buckling_torque(
    *, outer: ArrayLike, inner: ArrayLike, modulus: ArrayLike, poisson: ArrayLike, length: ArrayLike
) -> FloatArray:
    r"""Torque (...) N m that buckles the wall of a tube of metal, pinned where it ends.

    That of an endless one, at the mean radius r of a wall t,

    $$T = 2 \pi r^2 t \, \frac{E}{3 \sqrt 2 \, (1 - \nu^2)^{3/4}} \left(\frac{t}{r}\right)^{3/2}$$

    raised by the ends, which keep it round: on one curve over $(L/r) \sqrt{t/r}$ whatever its wall.

    Parameters
    ----------
    outer, inner, length : (...) m
        A length of nan counts as endless, the safe side.
    modulus, poisson : (...) Pa and 1

    Returns
    -------
    (...) N m

    Notes
    -----
    0 to 6 % below the shell's own eigenvalue for t/r up to 0.05; thicker ones, which yield before,
    from 16 % below to 3 % above. Source: Flügge, Stresses in Shells (1973), ch. 8; the curve by
    `composite.min_buckling_torque`.
    """
    _, d, inside, E, nu, L = array_library_and_floats(outer, inner, modulus, poisson, length)
    t, r = (d - inside) / 2, (d + inside) / 4
    thin = t / r
    endless = 2 * pi * r**2 * t * E * thin**1.5 / (3 * sqrt(2) * (1 - nu**2) ** 0.75)
    slender = np.nan_to_num(L / r * thin**0.5, nan=inf)
    # Shorter than the curve: as the root of the length, as short shells have it.
    share = np.interp(slender, _SLENDER, _SHARE) * np.minimum(slender / _SLENDER[0], 1.0) ** 0.5
    return endless / share


def tube_fatigue_utilisation(
    highest: ArrayLike,
    *,
    lowest: ArrayLike,
    outer: ArrayLike,
    inner: ArrayLike,
    fatigue_shear: ArrayLike,
    ultimate_shear: ArrayLike = inf,
) -> FloatArray:
    """Share of a tube's endurance in shear that a swing of torque uses, (...).

    τa/τf + |τm|/τu, with τa and τm the amplitude and mean of the stress (Goodman).

    Parameters
    ----------
    highest, lowest : (...) N m
        Ends of the swing: drive torque, and 0 or overrun torque, which is negative.
    outer, inner : (...) m
    fatigue_shear : (...) Pa
        Amplitude endured for ever about zero: of the weld, where there is one.
    ultimate_shear : (...) Pa
        Infinite leaves the mean out, as tests of smooth steel in torsion do.

    Returns
    -------
    (...) 1

    Notes
    -----
    Source: Shigley, Mechanical Engineering Design; on the mean, Smith, Univ. of Illinois
    Bulletin 334 (1942).
    """
    xp, top, bottom, endured, ultimate = array_library_and_floats(
        highest, lowest, fatigue_shear, ultimate_shear
    )
    swing = tube_shear_stress((top - bottom) / 2, outer=outer, inner=inner)
    mean = tube_shear_stress((top + bottom) / 2, outer=outer, inner=inner)
    return xp.abs(swing) / endured + xp.abs(mean) / ultimate


def joint_fatigue_utilisation(
    highest: ArrayLike,
    *,
    lowest: ArrayLike,
    reversing: ArrayLike,
    pulsating: ArrayLike | None = None,
) -> FloatArray:
    """Share of a joint's fatigue rating that a swing of torque uses, (...).

    (Ta + (2 Tdw/Tds − 1) |Tm|) / Tdw: the straight line of amplitude Ta over mean Tm through
    a catalogue's two ratings, T/Tdw for reversing and T/Tds for pulsating torque.

    Parameters
    ----------
    highest, lowest : (...) N m
        Ends of the swing: drive torque, and 0 or overrun torque, which is negative.
    reversing : (...) N m
        Tdw, carried for ever from −Tdw to Tdw.
    pulsating : (...) N m
        Tds, carried for ever from 0 to Tds; by default no more than Tdw. GWB takes 1.4 Tdw.

    Notes
    -----
    Source: ratings as Dana GWB defines them; the line between them derived.
    """
    xp, top, bottom, Tdw = array_library_and_floats(highest, lowest, reversing)
    _, Tds = array_library_and_floats(reversing if pulsating is None else pulsating)
    amplitude, mean = xp.abs(top - bottom) / 2, xp.abs(top + bottom) / 2
    return (amplitude + (2 * Tdw / Tds - 1) * mean) / Tdw


def cross_journal_force(
    torque: ArrayLike, *, across: ArrayLike, angle: ArrayLike = 0.0
) -> FloatArray:
    """Largest force on a journal of the cross in a turn, (...) N: T / (a cos β).

    `torque` (...) N m of the driving yoke, `across` (...) m between the middles of opposite
    needle rows (width over the cups less one cup), joint angle `angle` (...) rad. Derived:
    the couple of the journals stands square to the cross, T tilted by at most β.
    """
    xp, T, a, beta = array_library_and_floats(torque, across, angle)
    return xp.abs(T) / (a * xp.cos(beta))


def bearing_cup_pressure(force: ArrayLike, *, diameter: ArrayLike, length: ArrayLike) -> FloatArray:
    """Mean pressure of a cup in its yoke, or of needles on a journal, (...) Pa: F / (d l)."""
    _, F, d, b = array_library_and_floats(force, diameter, length)
    return F / (d * b)


@dataclass(frozen=True, slots=True, kw_only=True)
class JointTorqueAndDutyDemand:
    """What a joint has to bear: a torque to survive, and a duty cycle to live through.

    Attributes
    ----------
    peak_torque : N m
        The largest, shocks included.
    torque, speed, angle, shares : (p,) N m, rad/s, rad, 1
        Points of the duty cycle, and their shares of the time.
    life : s
    prime_mover_factor
        K1 of the life formula.
    """

    peak_torque: NewtonMetre
    torque: FloatArray
    speed: FloatArray
    angle: FloatArray
    shares: FloatArray
    life: float
    prime_mover_factor: float


def joint_size_utilisations(size: JointSize, demand: JointTorqueAndDutyDemand) -> dict[str, float]:
    """Return the share of each of a joint's ratings that a demand uses, by quantity.

    Ratings that its catalogue does not publish are left out.
    """
    ratings = {
        "joint_torque_utilisation": (demand.peak_torque, size.peak_torque),
        "joint_angle": (np.max(demand.angle), size.angle_max),
        "n_beta": (
            np.max(speed_angle_product(demand.speed, angle=demand.angle)),
            size.speed_angle_max,
        ),
        "joint_speed": (np.max(np.abs(demand.speed)), size.speed_max),
    }
    used = {key: float(asked / rating) for key, (asked, rating) in ratings.items() if rating}
    rated = rated_torque_if_life_computable(size)
    if rated:
        wearing = life_consumption_rate(
            size,
            demand.torque,
            speed=demand.speed,
            angle=demand.angle,
            prime_mover_factor=demand.prime_mover_factor,
        )
        used["joint_life"] = float(demand.life / joint_life(wearing, shares=demand.shares))
    return used


def smallest_joint_size(sizes: Iterable[JointSize], demand: JointTorqueAndDutyDemand) -> JointSize:
    """Return the joint of the least life rating that no demand is too much for.

    Joints whose catalogue publishes no peak torque or no life rating are passed over: it
    is unknown whether they carry it.

    Raises
    ------
    DesignError
        If none does; the message names the one that comes nearest, and what it lacks.
    """
    known = [
        s for s in sizes if s.kind == "cross" and s.peak_torque and rated_torque_from_catalogue(s)
    ]
    used = {s.name: joint_size_utilisations(s, demand) for s in known}
    enough = [s for s in known if max(used[s.name].values()) <= 1]
    if enough:
        return min(enough, key=lambda s: rated_torque_from_catalogue(s) or inf)
    if not known:
        msg = "no joint on offer publishes both peak torque and life rating; give them"
        raise DesignError(msg)
    nearest = min(known, key=lambda s: max(used[s.name].values()))
    key, most = max(used[nearest.name].items(), key=lambda item: item[1])
    msg = (
        f"none of {len(known)} joints carries this: {nearest.name} comes nearest, at {most:.3g} "
        f"times its {key.replace('_', ' ')}; offer larger sizes"
    )
    raise DesignError(msg)
