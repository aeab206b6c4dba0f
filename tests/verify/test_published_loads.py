"""Bearing forces against multibody engines' figures, small angles, and Dana GWB catalogue p. 46."""

import numpy as np
import pytest

from cardan.core.arrays import FloatArray
from cardan.model.layout import Layout, layout_from_slopes
from cardan.model.parts import CentreBearing, Line, Shaft
from cardan.physics.kinematics.joint_chain import rotate_chain
from cardan.physics.loads.flange_reactions import flange_bearing_forces
from cardan.physics.loads.half_turn_fourier import HalfTurnSeries
from cardan.physics.loads.small_angle import small_angle_bearing_forces
from cardan.physics.loads.statics import JointLoads, joint_loads

LENGTHS = [1.2, 1.5]
LINE = Line(
    shafts=(
        Shaft(length=LENGTHS[0], centre_bearing=CentreBearing()),
        Shaft(length=LENGTHS[1]),
    )
)
LAYOUT = layout_from_slopes(
    side=np.radians([3, 1, 4.5, 2]), top=np.radians([0, 1.5, -0.8, 0.6]), lengths=LENGTHS
)


def round_a_turn(layout: Layout, line: Line, torque: float = 1000.0) -> JointLoads:
    return joint_loads(
        layout, rotate_chain(layout.directions, phases=line.phases), line, torque=torque
    )


def gwb_flange_reactions(
    torque: float,
    *,
    beta_1: float,
    beta_2: float,
    length: float,
    gearbox: tuple[float, float],
    axle: tuple[float, float],
) -> tuple[list[float], list[float]]:
    """Forces on bearings A, B of the gearbox and E, F of the axle at positions 0 and 90.

    Of an aligned shaft whose members lie in one plane; beta_2 is negative in a W arrangement.
    (a, b) and (f, e) are the bearings' spacing and the overhang to the joint. Source: Dana GWB,
    Cardan shafts for industrial applications, p. 46, by the plane of the yoke.
    """
    (a, b), (f, e) = gearbox, axle
    force = abs(torque * np.cos(beta_1) / length * (np.tan(beta_1) - np.tan(beta_2)))
    front = abs(torque * np.tan(beta_1)) / a
    rear = abs(torque * np.sin(beta_2) / np.cos(beta_1)) / f
    still = [force * b / a, force * (a + b) / a, force * (e + f) / f, force * e / f]
    return still, [front, front, rear, rear]


def size(vector: FloatArray) -> FloatArray:
    return np.linalg.norm(vector, axis=-1)


def test_bearing_force_matches_two_multibody_engines():
    """Static 5.139 N and twice a turn 20.090 N for 1000 N m, to the digits given."""
    force = round_a_turn(LAYOUT, LINE).bearing_forces
    assert size(force.static) == pytest.approx([5.139], abs=5e-4)
    assert force.dynamic == pytest.approx([20.090], abs=5e-4)


def test_small_angle_bearing_force_matches_two_engines():
    """Static 5.124 N and twice a turn 20.049 N, to the digits given."""
    force = small_angle_bearing_forces(LAYOUT, LINE, torque=1000.0)
    assert size(force.static) == pytest.approx([5.124], abs=5e-4)
    assert force.dynamic == pytest.approx([20.049], abs=5e-4)


def test_small_angle_force_matches_handbook_formula():
    """T/2 |(D1+D2)/L1 - (D2+D3)/L2| and T/2 |(s1 D1* - s2 D2*)/L1 - (s2 D2* - s3 D3*)/L2|."""
    D = np.diff(LAYOUT.top + 1j * LAYOUT.side)
    C, (L1, L2) = D.conj(), LENGTHS
    s = [1, -1, 1]  # an aligned shaft flips the sign
    static = 500 * abs((D[0] + D[1]) / L1 - (D[1] + D[2]) / L2)
    swing = 500 * abs((s[0] * C[0] - s[1] * C[1]) / L1 - (s[1] * C[1] - s[2] * C[2]) / L2)
    force = small_angle_bearing_forces(LAYOUT, LINE, torque=1000.0)
    assert size(force.static) == pytest.approx([static], rel=1e-12)
    assert force.dynamic == pytest.approx([swing], rel=1e-12)


@pytest.mark.parametrize("floating", ["last_shaft", "gearbox_flange"])
def test_small_angle_force_is_limit_of_exact_force(floating: str):
    """The difference is of third order: a quarter of the angles leave a 64th of it.

    Four shafts, odd phases, bearings ahead of their joints. What is left of 64 is the fifth
    order, a few per mille at these angles.
    """
    rng = np.random.default_rng(7)
    side, top = rng.uniform(-3, 3, (2, 6))
    shafts = tuple(
        Shaft(length=x, phase=p, centre_bearing=CentreBearing(from_rear_joint=o) if o else None)
        for x, p, o in zip(
            [1.1, 0.9, 1.3, 1.6], [0.3, 1.7, -0.4, 0.9], [0.1, 0.2, 0.3, None], strict=True
        )
    )
    line = Line(shafts=shafts, axial_freedom=floating)

    def missed(scale: float) -> HalfTurnSeries:
        layout = layout_from_slopes(
            side=np.radians(scale * side), top=np.radians(scale * top), lengths=line.lengths
        )
        exact = round_a_turn(layout, line).bearing_forces.waves
        near = small_angle_bearing_forces(layout, line, torque=1000.0).waves
        # Along the vehicle the small-angle force has no component: look across.
        return HalfTurnSeries((exact - near)[..., 1:])

    coarse, fine = missed(1.0), missed(0.25)
    assert size(coarse.static) / size(fine.static) == pytest.approx(64, rel=0.02)
    assert coarse.dynamic / fine.dynamic == pytest.approx(64, rel=0.02)


@pytest.mark.parametrize("beta_2", [7.0, -4.0], ids=["Z", "W"])
def test_catalogue_end_bearing_forces_are_exact_at_both_positions(beta_2: float):
    """One aligned shaft in the plane y = 0: bearings A, B of the gearbox and E, F of the axle."""
    beta_1, length, (a, b), (f, e) = 5.0, 1.4, (0.3, 0.12), (0.22, 0.15)
    line = Line(shafts=(Shaft(length=length),))
    layout = layout_from_slopes(
        side=np.radians([0, beta_1, beta_1 - beta_2]), top=[0, 0, 0], lengths=[length]
    )
    found = round_a_turn(layout, line, torque=900.0)
    d = layout.directions
    far = {"outward": d[0], "spacing": a, "overhang": b}
    near = {"outward": -d[-1], "spacing": f, "overhang": e}
    A, B = flange_bearing_forces(found.gearbox_force, found.gearbox_moment, **far)
    F, E = flange_bearing_forces(found.pinion_force, found.pinion_moment, **near)
    # The pin starts level, square to the plane: position 90; a quarter turn on it is 0.
    positions = gwb_flange_reactions(
        900.0,
        beta_1=np.radians(beta_1),
        beta_2=np.radians(beta_2),
        length=length,
        gearbox=(a, b),
        axle=(f, e),
    )
    for sample, expected in zip((1, 0), positions, strict=True):
        exact = [size(force.values(4)[sample]) for force in (A, B, E, F)]
        assert exact == pytest.approx(expected, rel=1e-12, abs=1e-9)


def test_z_arrangement_with_equal_angles_has_no_force_at_position_0():
    """The catalogue: A = B = E = F = 0 there, T tan β / a a quarter turn on."""
    beta = np.radians(6.0)
    flat, upright = gwb_flange_reactions(
        1000.0, beta_1=beta, beta_2=beta, length=1.5, gearbox=(0.3, 0.1), axle=(0.3, 0.1)
    )
    assert flat == pytest.approx([0, 0, 0, 0], abs=1e-12)
    assert upright == pytest.approx([1000.0 * np.tan(beta) / 0.3] * 4, rel=1e-12)


def test_w_arrangement_with_equal_angles_matches_catalogue():
    """The catalogue: A = F = 2 T sin β b / (L a) and B = E = 2 T sin β (a + b) / (L a)."""
    beta = np.radians(6.0)
    flat, _ = gwb_flange_reactions(
        1000.0, beta_1=beta, beta_2=-beta, length=1.5, gearbox=(0.3, 0.1), axle=(0.3, 0.1)
    )
    far = 2000.0 * np.sin(beta) * 0.1 / (1.5 * 0.3)
    near = 2000.0 * np.sin(beta) * 0.4 / (1.5 * 0.3)
    assert flat == pytest.approx([far, near, near, far], rel=1e-12)
