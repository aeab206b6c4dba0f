"""The bearings behind the flanges of gearbox and axle: exactly, and as GWB's catalogue has it."""

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray
from cardan.core.lazy_dataclass import dataclass
from cardan.physics.kinematics.joint_chain import cross_product, dot_product
from cardan.physics.loads.half_turn_fourier import HalfTurnSeries


def flange_bearing_forces(
    force: HalfTurnSeries,
    moment: HalfTurnSeries,
    *,
    outward: ArrayLike,
    spacing: ArrayLike,
    overhang: ArrayLike,
) -> tuple[HalfTurnSeries, HalfTurnSeries]:
    """Return the radial forces on the two bearings that carry a flange, exactly.

    Parameters
    ----------
    force, moment
        Of N and N m, on the flange at the joint centre: `JointLoads.gearbox_force` and
        `gearbox_moment`, or the pinion's.
    outward : (..., 3) 1
        Unit vector from the bearings towards the joint: member 0's direction at the
        gearbox, the opposite of member n's at the axle.
    spacing : (...) m
        Between the two bearings.
    overhang : (...) m
        From the bearing near the joint to the joint centre.

    Returns
    -------
    far, near : HalfTurnSeries, HalfTurnSeries
        Forces on the bearings, square to the axis; near is the one by the joint. GWB's
        catalogue calls them A and B at the gearbox, F and E at the axle.
    """
    out = np.asarray(outward, dtype=float)[..., None, :]
    a, b = (np.asarray(x, dtype=float)[..., None, None] for x in (spacing, overhang))
    across = force.waves - dot_product(force.waves, out)[..., None] * out
    far = (cross_product(out, moment.waves) - b * across) / a
    return HalfTurnSeries(far), HalfTurnSeries(across - far)


@dataclass(frozen=True)
class FlangeReactions:
    """Radial forces (...) N on the bearings A, B of the gearbox and E, F of the axle."""

    A: FloatArray
    B: FloatArray
    E: FloatArray
    F: FloatArray


def gwb_flange_reactions(
    torque: ArrayLike,
    *,
    beta_1: ArrayLike,
    beta_2: ArrayLike,
    length: ArrayLike,
    gearbox: tuple[float, float],
    axle: tuple[float, float],
) -> tuple[FlangeReactions, FlangeReactions]:
    r"""Bearing forces at the two positions of one shaft that the GWB catalogue gives.

    $$A_0 = T\,\frac{b \cos\beta_1}{L a}(\tan\beta_1 - \tan\beta_2), \quad
      B_0 = \frac{a+b}{b} A_0, \quad
      A_{90} = B_{90} = \frac{T\tan\beta_1}{a}, \quad
      E_{90} = F_{90} = \frac{T \sin\beta_2}{f \cos\beta_1}$$

    and E₀, F₀ as B₀, A₀ with e, f for b, a.

    Parameters
    ----------
    torque : (...) N m
        Torque of the gearbox output.
    beta_1, beta_2 : (...) rad
        Joint angles; `beta_2` is positive where it turns the line back (Z arrangement),
        negative where it bends it on (W arrangement).
    length : (...) m
        Between the joint centres.
    gearbox, axle : m
        Spacing of the two bearings, and overhang from the nearer one to the joint centre:
        (a, b) and (f, e). B and E are the nearer ones.

    Returns
    -------
    FlangeReactions, FlangeReactions
        At position 0, where the gearbox yoke's pin axis lies in the plane of the shafts,
        and a quarter turn on.

    Notes
    -----
    Exact for an aligned shaft whose members all lie in one plane; see `flange_bearing_forces` for
    any other. Source: Dana GWB, Cardan shafts for industrial applications, p. 46, which
    names its positions by the plane of the yoke.
    """
    T, b1, b2, L = (np.asarray(x, dtype=float) for x in (torque, beta_1, beta_2, length))
    (a, b), (f, e) = gearbox, axle
    force = np.abs(T * np.cos(b1) / L * (np.tan(b1) - np.tan(b2)))
    front = np.abs(T * np.tan(b1)) / a
    rear = np.abs(T * np.sin(b2) / np.cos(b1)) / f
    still = FlangeReactions(
        A=force * b / a, B=force * (a + b) / a, E=force * (e + f) / f, F=force * e / f
    )
    return still, FlangeReactions(A=front, B=front, E=rear, F=rear)
