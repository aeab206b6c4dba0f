"""Lines as one joint: Souza (2014), tables 2-4, eq. 6-14; SAE AE-7; Dana J3311-1; Elbe.

Digits of exact and phasor angles of Souza's line were computed independently of this
program, by pin axes as vectors.
"""

import numpy as np
import pytest

from cardan.core.units import deg, rpm
from cardan.model.layout import layout_from_joint_angles
from cardan.physics.kinematics import equivalent_angle as equivalent
from cardan.physics.kinematics import hooke_joint as joint
from cardan.physics.kinematics.equivalent_angle import (
    SPICER_ACCELERATION_FACTOR,
    ae7_excitation,
    excitation_of_rotating_chain,
    in_plane_excitation,
)
from cardan.physics.kinematics.joint_chain import joint_angles, rotate_chain

SIDE = np.array([-2.70, -1.25, 2.45]) * deg
TOP = np.array([0.67, 0.13, -0.80]) * deg
LAYOUT = layout_from_joint_angles(side=SIDE, top=TOP, lengths=[1.2, 1.5])
CROSSED = 90 * deg


def printed(text):
    """The number, with half a unit of its last printed digit as the tolerance."""
    decimals = len(text.partition(".")[2])
    return pytest.approx(float(text), abs=0.5 * 10**-decimals)


@pytest.mark.parametrize(
    ("k", "angle", "quadrant", "position"),
    [(0, "2.7819", 4, "283.94"), (1, "1.2567", 4, "275.94"), (2, "2.5773", 2, "108.08")],
)
def test_angles_match_souza_table_3(k, angle, quadrant, position):
    assert equivalent.true_angle_by_pythagoras(SIDE[k], TOP[k]) / deg == printed(angle)
    assert equivalent.joint_plane_quadrant(SIDE[k], TOP[k]) == quadrant
    assert equivalent.joint_plane_angle(SIDE[k], TOP[k]) / deg == printed(position)


def test_angle_approximations_match_souza_within_third_order():
    """The square root is short of the exact angle by a third order term, β³/3 or less."""
    exact = joint_angles(LAYOUT.directions)
    for of in equivalent.TRUE_ANGLE_FORMULAS.values():
        assert np.all(abs(of(SIDE, TOP) - exact) < exact**3 / 3 + 1e-4 * exact)
    # Joint 1 stands behind a level gearbox, where the tangents are exact.
    assert equivalent.true_angle_from_tangents(SIDE[0], TOP[0]) == pytest.approx(
        exact[0], rel=1e-12
    )


@pytest.mark.parametrize("angle", [1.0, 10.0, 44.0, 70.0])
def test_equivalent_angle_of_single_joint_is_its_angle(angle):
    """METHOD 3: 2 atan √|E|; the older 2 √A₂ made 46.298 deg of a joint of 44."""
    one = layout_from_joint_angles(side=[angle * deg, 0.0], top=[0.0, 0.0], lengths=[1.0])
    line = rotate_chain(one.directions, phases=[0.0])
    assert excitation_of_rotating_chain(line, speed=1.0).torsional.angle / deg == pytest.approx(
        angle, rel=1e-12
    )
    assert excitation_of_rotating_chain(line, speed=1.0).drive.angle / deg == pytest.approx(
        angle, rel=1e-12
    )


@pytest.mark.parametrize(
    ("phases", "exact", "phasor", "flat"),
    [
        ([0, 0], "3.5864", "3.5874", "3.5780"),
        ([CROSSED, 0], "1.7392", "1.7390", "1.6358"),
        ([0, CROSSED], "0.7912", "0.7941", "0.6950"),
        ([CROSSED, CROSSED], "3.9782", "3.9798", "3.9951"),
    ],
)
def test_torsional_angle_matches_souza_table_4(phases, exact, phasor, flat):
    """Table 4, eq. 11-14, are the last column."""
    line = rotate_chain(LAYOUT.directions, phases=phases)
    assert excitation_of_rotating_chain(line, speed=1.0).torsional.angle / deg == printed(exact)
    assert ae7_excitation(SIDE, TOP, phases=phases, speed=1.0).torsional.angle / deg == printed(
        phasor
    )
    assert in_plane_excitation(
        SIDE, TOP, phases=phases, speed=1.0
    ).torsional.angle / deg == printed(flat)


@pytest.mark.parametrize(
    ("phases", "signs"),
    [
        ([0, 0], [1, -1, 1]),
        ([CROSSED, 0], [1, 1, -1]),
        ([0, CROSSED], [1, -1, -1]),
        ([CROSSED, CROSSED], [1, 1, 1]),
    ],
)
def test_equivalent_angle_matches_souza_equations_11_to_14(phases, signs):
    beta = equivalent.true_angle_by_pythagoras(SIDE, TOP)
    direct = np.sqrt(abs(np.sum(signs * beta**2)))
    found = in_plane_excitation(SIDE, TOP, phases=phases, speed=1.0).torsional.angle
    assert found == pytest.approx(direct, rel=1e-13)


def test_ae7_weights_of_three_joints_match_page_50():
    """P. 50: 2 and 1 times the first two joints in drive, 1 and 2 times the last in coast."""
    D = TOP + 1j * SIDE
    s = np.array([1, -1, 1])
    found = ae7_excitation(SIDE, TOP, phases=[0, 0], speed=300.0)
    assert found.drive.angle == pytest.approx(np.sqrt(abs([2, 1, 0] @ (s * D**2))), rel=1e-13)
    assert found.coast.angle == pytest.approx(np.sqrt(abs([0, 1, 2] @ (s * D**2))), rel=1e-13)
    assert found.drive.acceleration == pytest.approx(300**2 * found.drive.angle**2, rel=1e-13)


def test_joint_angle_matches_j3311_figure_6():
    side, top = 2.50 * deg, 2.15 * deg
    for of in equivalent.TRUE_ANGLE_FORMULAS.values():
        assert of(side, top) / deg == printed("3.3")


@pytest.mark.parametrize(
    ("speed", "degrees", "minutes"), [(3000, 5, 50), (2500, 7, 0), (2000, 8, 40), (1500, 11, 30)]
)
def test_limit_angles_match_spicer_table(speed, degrees, minutes):
    """Printed to ten minutes of arc, on 1000 rad/s² (the table's own "100" is a misprint)."""
    angle = equivalent.angle_for_acceleration(1000.0, speed=speed * rpm) / deg * 60
    assert abs(angle - (60 * degrees + minutes)) <= 5
    assert abs(angle / np.sqrt(10) - (60 * degrees + minutes)) > 200


def test_spicer_constant_uses_rpm_and_degrees():
    """3.3403e-6 as printed; the units themselves say 3.3405e-6, 0.006 % more."""
    assert SPICER_ACCELERATION_FACTOR == 3.3403e-6
    assert (rpm * deg) ** 2 == printed("0.0000033405")
    assert abs(SPICER_ACCELERATION_FACTOR / (rpm * deg) ** 2 - 1) < 7e-5


def test_irregularity_limit_matches_elbe():
    """U <= 0.0027 is an equivalent angle of 2.98 deg."""
    assert joint.irregularity(2.98 * deg) == printed("0.0027")
    assert joint.angle_for_irregularity(0.0027) / deg == pytest.approx(2.98, abs=0.005)
    line = rotate_chain(
        layout_from_joint_angles(side=[2.98 * deg], top=[0], lengths=[]).directions, phases=[]
    )
    assert excitation_of_rotating_chain(line, speed=1.0).irregularity == printed("0.0027")
