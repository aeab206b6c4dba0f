"""Laws of vibration: what holds for every line, shaft and ply, whatever its numbers."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cardan.model.laminate import CARBON_EPOXY, CompositeTube
from cardan.physics.dynamics.floquet import (
    PeriodicSystem,
    floquet_multipliers,
    growth_rate,
    hill_multipliers,
    monodromy_matrix,
)
from cardan.physics.dynamics.lateral import rigid_shaft_system
from cardan.physics.dynamics.run_up import resonance_passage
from cardan.physics.dynamics.suspended_body import BodySuspendedFromJoint
from cardan.physics.dynamics.torsional_line import (
    TorsionalLine,
    linearised_about_periodic_motion,
    linearised_about_rigid_rotation,
    output_angle_derivatives,
    periodic_motion,
)
from cardan.physics.strength.composite_tube import ply_stresses, strength_ratio

few = settings(max_examples=25)
angles = st.floats(0.0, 0.6)
sizes = st.floats(0.2, 5.0)
speeds = st.floats(0.2, 3.0)


some_damping, no_damping = st.floats(0.0, 0.2), st.just(0.0)


@st.composite
def lines(draw, damping=some_damping):
    """Lines of two joints and an inertia, any twist."""
    three = lambda s: np.array([draw(s) for _ in range(3)])  # noqa: E731
    return TorsionalLine(
        beta=np.array([draw(angles), draw(angles), 0.0]), stiffness=three(sizes),
        driving=three(sizes), driven=np.array([draw(sizes), draw(sizes), 0.0]),
        damping=draw(damping) * np.ones(3), twist=three(st.floats(-3, 3)),
        front=np.array(draw(angles)),
    )  # fmt: skip


@few
@given(line=lines(), speed=speeds)
def test_monodromy_determinant_satisfies_liouville(line, speed):
    """What damping takes out of a volume of states in half a turn is its trace."""
    system = linearised_about_rigid_rotation(line, speed)
    M, C, _ = system.matrices(np.arange(256) / 256)
    mean = np.trace(np.linalg.solve(M, C), axis1=-2, axis2=-1).mean(-1)
    expected = float(np.exp(-mean * system.period))
    assert np.linalg.det(monodromy_matrix(system)) == pytest.approx(expected, rel=1e-7)


@few
@given(line=lines(damping=no_damping), speed=speeds)
def test_undamped_multipliers_occur_in_reciprocal_pairs(line, speed):
    """About a motion the equations allow, with no damping, ρ comes with 1/ρ: energy's law."""
    try:
        rho = floquet_multipliers(linearised_about_periodic_motion(line, speed), tolerance=1e-12)
    except Exception as error:  # noqa: BLE001  an undamped line in resonance has no orbit
        pytest.skip(str(error))
    product = rho[:, None] * rho
    # Near a double multiplier rounding splits it by the square root of 1e-13.
    assert np.abs(product - 1).min(-1).max() < 1e-5


@few
@given(line=lines(), speed=speeds)
def test_straight_joints_give_no_excitation(line, speed):
    straight = TorsionalLine(
        beta=0 * line.beta, stiffness=line.stiffness, driving=line.driving, driven=line.driven,
        damping=line.damping + 0.01, twist=line.twist,
    )  # fmt: skip
    assert np.abs(periodic_motion(straight, speed).order(2)).max() < 1e-9
    assert growth_rate(linearised_about_periodic_motion(straight, speed)) < 0


@few
@given(line=lines(), speed=speeds, turned=st.floats(-3, 3))
def test_start_angle_does_not_change_growth_rate(line, speed, turned):
    """Twisting what lies ahead of everything shifts time, and no growth rate."""
    again = TorsionalLine(
        beta=line.beta, stiffness=line.stiffness, driving=line.driving, driven=line.driven,
        damping=line.damping, twist=line.twist, front=0.0, front_twist=turned,
    )  # fmt: skip
    plain = TorsionalLine(
        beta=line.beta, stiffness=line.stiffness, driving=line.driving, driven=line.driven,
        damping=line.damping, twist=line.twist,
    )  # fmt: skip
    rates = [
        growth_rate(linearised_about_rigid_rotation(one, speed), tolerance=1e-12)
        for one in (again, plain)
    ]
    # Undamped, a double multiplier on the unit circle is known to the square root only.
    assert rates[0] == pytest.approx(float(rates[1]), abs=2e-6)


@few
@given(theta=st.floats(-10, 10), beta=st.floats(0.0, 1.2))
def test_joint_derivatives_match_finite_differences(theta, beta):
    h = 1e-4
    ahead, behind = (output_angle_derivatives(theta + s, beta=beta) for s in (h, -h))
    here = output_angle_derivatives(theta, beta=beta)
    scale = 1 / np.cos(beta) ** 4
    for k in range(3):
        assert (ahead[k] - behind[k]) / (2 * h) == pytest.approx(
            float(here[k + 1]), abs=100 * h**2 * scale**2
        )


@few
@given(a=st.floats(0.3, 4), q=st.floats(0, 1.5), c=st.floats(0.02, 0.3), period=st.floats(0.5, 5))
def test_hill_multipliers_agree_with_time_integration(a, q, c, period):
    system = PeriodicSystem(
        period=np.array(period),
        matrices=lambda t: (
            np.eye(1), c * np.eye(1), (a + q * np.cos(2 * np.pi * t))[:, None, None]
        ),
    )  # fmt: skip
    rho, hill = floquet_multipliers(system, tolerance=1e-12), hill_multipliers(system)
    # Sum and product are well conditioned even where the two meet.
    assert hill.sum() == pytest.approx(rho.sum(), abs=1e-8 * np.abs(rho).max())
    assert hill.prod() == pytest.approx(rho.prod(), abs=1e-8 * np.abs(rho).max() ** 2)


@few
@given(speed=speeds, torque=st.floats(0, 0.8), sigma=st.floats(0, 1), ia=st.floats(0, 0.5))
def test_symmetric_shaft_is_constant_in_rotating_frame(speed, torque, sigma, ia):
    shaft = rigid_shaft_system(
        speed=speed, torque=torque, transverse_inertia=1.0, polar_inertia=ia, stiffness=1.0,
        damping=0.05, follower=sigma,
    )  # fmt: skip
    exact = shaft.rotating_frame_exponents().real.max()
    assert growth_rate(shaft.periodic_system, tolerance=1e-12) == pytest.approx(exact, abs=1e-6)


@few
@given(rate=st.floats(1e-3, 0.05), more=st.floats(1.1, 3), zeta=st.floats(0, 0.05))
def test_faster_sweep_through_resonance_has_lower_peak(rate, more, zeta):
    slow, fast = resonance_passage(rate=np.array([rate, more * rate]), damping_ratio=zeta).peak
    assert fast < slow


@few
@given(
    A=sizes, B=sizes, share=st.floats(0.1, 0.95), mgl=st.floats(0.1, 30), speed=st.floats(0.1, 20)
)
def test_stability_of_hung_body_follows_friction_criterion(A, B, share, mgl, speed):
    body = BodySuspendedFromJoint(
        driving_inertia=A, driven_inertia=B, polar_inertia=share * (A + B), weight_moment=mgl,
        friction=0.3,
    )  # fmt: skip
    if np.abs(body.stiffness(speed)).min() < 1e-3:
        return  # on the edge itself rounding decides
    assert (body.exponents(speed).real.max() < 0) == bool(body.stable_with_friction(speed))


@few
@given(fibres=st.lists(st.floats(0, np.pi / 2), min_size=1, max_size=5), torque=st.floats(10, 2000))
def test_laminate_is_linear_and_balanced_layup_does_not_twist(fibres, torque):
    tube = CompositeTube.from_ply_angles(
        CARBON_EPOXY, [s * a for a in fibres for s in (1, -1)], outer=0.1
    )
    assert np.abs(tube.membrane_stiffness[:2, 2]).max() < 1e-6 * tube.membrane_stiffness[2, 2]
    once, twice = ply_stresses(tube, torque), ply_stresses(tube, 2 * torque)
    np.testing.assert_allclose(twice, 2 * once, rtol=1e-12, atol=1e-3)
    ratios = strength_ratio(once, CARBON_EPOXY), strength_ratio(twice, CARBON_EPOXY)
    np.testing.assert_allclose(ratios[0], 2 * ratios[1], rtol=1e-9)
