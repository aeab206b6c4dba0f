"""The bearings behind the flanges of gearbox and axle."""

import numpy as np

from cardan.core.arrays import ArrayLike
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
