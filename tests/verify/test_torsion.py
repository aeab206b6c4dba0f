"""Torsional zones of Porter (1961), Chang (2000), Asokanthan & Hwang (1996), Bulut & Parlar (2011).

The numbers were computed from the authors' equations by an independent program and, at
engine settings, confirmed by a 3-D multibody engine; the printed digits set the tolerance.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh
from torsional_integration import integrated_motion

from cardan.application import reader, templates
from cardan.core.errors import ConvergenceError, DesignError
from cardan.core.units import deg
from cardan.model.layout import direction_from_slopes
from cardan.model.parts import CentreBearing, Line, Shaft, Tube
from cardan.physics.dynamics.floquet import growth_rate, hill_multipliers, monodromy_matrix
from cardan.physics.dynamics.stability_chart import find_zeros
from cardan.physics.dynamics.torsional_line import (
    TorsionalLine,
    instability_zones,
    linearised_about_periodic_motion,
    linearised_about_rigid_rotation,
    natural_frequencies,
    output_angle_derivatives,
    periodic_motion,
    torsional_line_model,
)
from cardan.physics.kinematics.joint_chain import rotate_chain


def mode_shapes(line):
    """Mass-normalised mode shapes (n, n), lowest frequency first."""
    M, _, K = line.mean_matrices
    return eigh(K, M)[1]


def one(beta, zeta=0.0):
    """Unit inertia behind one joint, unit spring ahead of it."""
    beta = np.asarray(beta, dtype=float)[..., None]
    return TorsionalLine(
        beta=beta, stiffness=np.ones(1), driving=np.zeros(1), driven=np.ones(1), damping=2 * zeta
    )


def two(beta=20 * deg, damping=0.0):
    """Asokanthan's system, all ones: spring, inertia, joint, spring, inertia."""
    return TorsionalLine(
        beta=np.array([beta, 0.0]), stiffness=np.ones(2), driving=np.ones(2), driven=np.zeros(2),
        damping=damping,
    )  # fmt: skip


GENERAL = TorsionalLine(
    beta=np.radians([20, 10, 0]), stiffness=np.array([1.0, 3, 2]), driving=np.array([1.0, 0.5, 1]),
    driven=np.array([0.2, 0.3, 0]), damping=np.array([1.0, 0.8, 0.6]),
    twist=np.array([0.3, 0, 0]), front=np.array(8 * deg), torque=np.array(0.2),
)  # fmt: skip


@pytest.mark.parametrize(
    ("beta", "low", "high"), [(10, 0.99250689, 1.00781536), (20, 0.97157168, 1.03375048)]
)
def test_principal_zone_of_one_coordinate_matches_reference(beta, low, high):
    (zone,) = instability_zones(one(beta * deg))
    assert zone.kind == "principal"
    assert (zone.low, zone.high) == (pytest.approx(low, abs=1e-8), pytest.approx(high, abs=1e-8))


def test_damping_closes_instability_zone():
    """At Omega = w0 below 16.1317 deg for zeta 0.02; first order says tan²(beta/2) = zeta."""

    def at_centre(b):
        return growth_rate(linearised_about_rigid_rotation(one(b, 0.02), 1.0), tolerance=1e-12)

    (closed,) = find_zeros(at_centre, between=(15 * deg, 17 * deg), start=4)
    assert closed / deg == pytest.approx(16.1317, abs=5e-5)
    assert np.tan(closed / 2) ** 2 == pytest.approx(0.02, rel=5e-3)  # next order: r² ~ 4e-4
    assert not instability_zones(one(15.9 * deg, 0.02))[0].is_open
    assert instability_zones(one(16.3 * deg, 0.02))[0].is_open


@pytest.mark.slow
def test_zones_of_two_coordinates_match_reference():
    found = {(z.kind, z.modes): z for z in instability_zones(two())}
    printed = {
        ("principal", (1, 1)): (0.60958, 0.62668),
        ("sum", (1, 2)): (1.1108, 1.1247),
        ("principal", (2, 2)): (1.59548, 1.64049),
    }
    for key, (low, high) in printed.items():
        digits = 1e-4 if low == 1.1108 else 1e-5  # the last one printed
        assert found[key].low == pytest.approx(low, abs=digits)
        assert found[key].high == pytest.approx(high, abs=digits)
    assert not found["difference", (1, 2)].is_open


@pytest.mark.slow
def test_second_order_sum_zone_is_not_a_difference_zone():
    """Near (w2 - w1)/2 = 0.5 stands (w1 + w2)/4, 0.5582 to 0.5592 at 20 deg: of sums, order 2.

    Hill's determinant has it too: its multipliers are off the unit circle and not real.
    """
    found = {(z.kind, z.modes, z.order): z for z in instability_zones(two(), window=0.15, orders=2)}
    assert not found["difference", (1, 2), 1].is_open
    second = found["sum", (1, 2), 2]
    assert (second.low, second.high) == (pytest.approx(0.5582, abs=5e-5),
                                         pytest.approx(0.5592, abs=5e-5))  # fmt: skip
    rho = hill_multipliers(linearised_about_rigid_rotation(two(), (second.low + second.high) / 2))
    largest = rho.ravel()[np.abs(rho).argmax()]
    assert np.log(abs(largest)) > 1e-3
    assert abs(largest.imag) > 0.1


def test_missing_orbit_gives_nan_for_that_case_only():
    """Slow and undamped, wound up by three units of torque at 45 deg, it wanders off."""
    line = replace(GENERAL, beta=np.radians([45, 10, 0]), torque=np.array(3.0), damping=np.zeros(3))
    speeds = np.array([2.0, 0.05, 2.5])
    found = periodic_motion(line, speeds)
    assert np.isnan(found.rotation[1]).all()
    np.testing.assert_allclose(found.rotation[0], periodic_motion(line, 2.0).rotation, rtol=1e-12)
    rates = growth_rate(linearised_about_periodic_motion(line, speeds))
    assert np.isnan(rates).tolist() == [False, True, False]
    with pytest.raises(ConvergenceError, match="no periodic motion found"):
        periodic_motion(line, 0.05)


@pytest.mark.slow
def test_zone_widths_match_first_order_formula():
    """Omega = w -+ r |Kh| / (2 w), and with both modes for the sum; error of order r²."""
    beta = 4 * deg
    r = np.tan(beta / 2) ** 2
    line = two(beta)
    w, shape = natural_frequencies(line), mode_shapes(line)
    Kh = shape.T @ np.array([[2, -1], [-1, 0]]) @ shape
    for zone in instability_zones(line):
        i, j = (k - 1 for k in zone.modes)
        half = r * abs(Kh[i, j]) / (2 * np.sqrt(w[i] * w[j]))
        if zone.kind == "difference":
            assert not zone.is_open
        else:
            assert (zone.high - zone.low) / 2 == pytest.approx(half, rel=3 * r + 1e-3)


def test_linearisations_differ_in_second_order_only():
    rates = [
        growth_rate(about(two(6 * deg, 1e-3), np.array([0.618, 1.118, 1.618])))
        for about in (
            linearised_about_rigid_rotation,
            linearised_about_periodic_motion,
        )
    ]
    r = np.tan(3 * deg) ** 2
    # A zone shifts by about w r² relative to its half-width w r / 2.
    np.testing.assert_allclose(rates[0], rates[1], atol=8 * r**2)


@pytest.mark.slow
def test_forced_orbit_is_attractor_of_equations():
    speed = np.array(0.5)
    found = periodic_motion(GENERAL, speed, samples=65)
    turns = 24
    decay = (
        growth_rate(linearised_about_periodic_motion(GENERAL, speed)) * turns * 2 * np.pi / speed
    )
    assert np.exp(decay) < 1e-7  # nothing is left of the start
    deviation, rate = integrated_motion(GENERAL, speed, turns=turns)
    # Fourth order: (2 pi / 256)^4 of the fastest motion.
    np.testing.assert_allclose(deviation[-1], found.rotation[0], atol=2e-7)
    np.testing.assert_allclose(rate[-1], found.rate[0], atol=2e-7)


@pytest.mark.slow
def test_monodromy_is_derivative_of_motion():
    """Half a turn of the nonlinear equations from pushed starts, against the linear matrix."""
    speed, push = np.array(0.5), 1e-4
    found = periodic_motion(GENERAL, speed, samples=65)
    (rigid,), (rigid_rate,) = integrated_motion(GENERAL, speed, turns=0)
    ends = []
    for sign in (1, -1):
        pushed = sign * push * np.eye(6)
        deviation, rate = integrated_motion(
            GENERAL, np.full(6, speed), turns=0.5, steps_per_turn=2000,
            start=found.rotation[0] - rigid + pushed[:, :3],
            start_rate=found.rate[0] - rigid_rate + pushed[:, 3:],
        )  # fmt: skip
        ends.append(np.concatenate([deviation[:, -1], rate[:, -1]], axis=-1))
    # Central differences: the error is of third order in the push.
    P = (ends[0] - ends[1]).T / (2 * push)
    np.testing.assert_allclose(
        P, monodromy_matrix(linearised_about_periodic_motion(GENERAL, speed)), atol=1e-6
    )


def test_off_resonance_orbit_equals_linear_forced_motion():
    """Unit inertia behind a joint: y = order 2 of the lead, magnified by 1/(1 - (2W/w)²)."""
    beta, speed = 2 * deg, 0.3
    r = np.tan(beta / 2) ** 2
    found = periodic_motion(one(beta), np.array(speed))
    driven, *_ = output_angle_derivatives(found.rotation[:, 0], beta=beta)
    lead = np.fft.rfft(driven - np.pi * np.arange(33) / 33)[1] * 2 / 33
    magnified = r / (1 - (2 * speed) ** 2)
    assert abs(lead) == pytest.approx(magnified, rel=5 * r)


def test_stiff_springs_give_exact_chain():
    side, top = np.radians([3.0, 1, 4.5, 2]), np.radians([0, 1.5, -0.8, 0.6])
    line = Line(
        shafts=(
            Shaft(length=1.2, tube=Tube(outer=0.1, wall=0.003), phase=0.4,
                  centre_bearing=CentreBearing()),
            Shaft(length=1.5, tube=Tube(outer=0.1, wall=0.003), phase=1.2),
        )
    )  # fmt: skip
    d = direction_from_slopes(side=side, top=top)
    model = torsional_line_model(line, d, axle_inertia=0.3, damping_ratio=0.01)
    slow = 1e-4 * natural_frequencies(model)[0]
    found = periodic_motion(model, np.array(slow), samples=33)
    exact = rotate_chain(d, phases=line.phases, samples=66)
    # Driving yoke of joint 2 turns with shaft 1, the pinion behind it; instants differ.
    swing = found.rate[:, 0] / slow
    assert np.ptp(swing) == pytest.approx(np.ptp(exact.speed[0]), rel=1e-2)
    assert np.abs(np.fft.rfft(swing))[1] / 33 == pytest.approx(
        np.abs(np.fft.rfft(exact.speed[0]))[2] / 66, rel=1e-6
    )
    last = (
        output_angle_derivatives(found.rotation[:, 1], beta=model.beta[1])[1]
        * found.rate[:, 1]
        / slow
    )
    spread = exact.speed[-1].max() - exact.speed[-1].min()
    assert last.max() - last.min() == pytest.approx(spread, rel=1e-2)
    np.testing.assert_allclose(
        np.abs(np.fft.rfft(last))[1] * 2 / 33,
        np.abs(np.fft.rfft(exact.speed[-1]))[2] * 2 / 66, rtol=1e-5,
    )  # fmt: skip
    # Who leads: a line whose yokes are twisted the other way swings as far, mirrored in time.
    ours = np.fft.rfft(last)[1] / np.fft.rfft(swing)[1]
    theirs = np.fft.rfft(exact.speed[-1])[2] / np.fft.rfft(exact.speed[0])[2]
    assert abs(theirs.imag) > 0.1 * abs(theirs)
    assert ours == pytest.approx(theirs, rel=1e-3)


def test_natural_frequencies_are_those_of_the_mean_matrices():
    _, _, K = GENERAL.mean_matrices
    shape, w = mode_shapes(GENERAL), natural_frequencies(GENERAL)
    np.testing.assert_allclose(shape.T @ K @ shape, np.diag(w**2), atol=1e-12)


def test_single_case_equals_batched_case():
    beta = np.radians([5, 12, 25])
    many = growth_rate(linearised_about_periodic_motion(one(beta, 0.01), np.array([0.9, 1.0, 1.1])))
    single = [
        growth_rate(linearised_about_periodic_motion(one(b, 0.01), s))
        for b, s in zip(beta, [0.9, 1.0, 1.1], strict=True)
    ]
    np.testing.assert_allclose(many, single, atol=1e-11)


def test_massless_joint_is_rejected():
    with pytest.raises(DesignError, match="inertia above 0"):
        TorsionalLine(
            beta=np.zeros(1), stiffness=np.ones(1), driving=np.zeros(1), driven=np.zeros(1)
        )


def test_natural_frequencies_match_springs_by_hand():
    """Two shafts and an axle between a uniform gearbox and free: springs by hand."""
    (installed,) = reader.loads(templates.template_text("truck")).lines
    line = installed.line
    made = torsional_line_model(line, installed.layout.directions, axle_inertia=2.0)
    first, second = line.shafts
    k1, k2 = (
        s.tube.material.shear_modulus * 2 * s.tube.second_moment / s.length for s in (first, second)
    )
    J1 = (first.polar_inertia + second.polar_inertia) / 2
    J2 = second.polar_inertia / 2 + 2.0
    # Two by two: w^2 of J1 q1'' + (k1 + k2) q1 - k2 q2, J2 q2'' + k2 (q2 - q1).
    trace, product = (k1 + k2) / J1 + k2 / J2, k1 * k2 / (J1 * J2)
    low = (trace - np.sqrt(trace**2 - 4 * product)) / 2
    found = natural_frequencies(made)
    assert found[0] == pytest.approx(np.sqrt(low), rel=1e-9)
    assert np.prod(found**2) == pytest.approx(product, rel=1e-9)


@pytest.mark.parametrize("ratio", [0.02, 0.11])
def test_first_mode_has_given_damping_ratio(ratio):
    """Its motion alone is q'' + 2 ζ w q' + w² q = 0: the mass-normalised shape says C to ζ."""
    (installed,) = reader.loads(templates.template_text("truck")).lines
    made = torsional_line_model(
        installed.line, installed.layout.directions, axle_inertia=2.0, damping_ratio=ratio
    )
    _, C, _ = made.mean_matrices
    shape, w = mode_shapes(made)[:, 0], natural_frequencies(made)[0]
    assert shape @ C @ shape == pytest.approx(2 * ratio * w, rel=1e-9)


@pytest.mark.slow
def test_zones_are_classified_by_their_multipliers():
    """Three of them lie within 8 %: mode 1's own, a sum at second order, and a shut difference.

    Half the modes' difference is 0.936, a quarter of their sum 0.930. The growth over speed
    itself, swept finely, has two humps; in mode 1's own a multiplier is real and below -1, in
    the other all are complex.
    """
    line = TorsionalLine(
        beta=np.array([35 * deg, 0.0]), stiffness=np.ones(2), driving=np.array([1.0, 0.15]),
        driven=np.zeros(2),
    )  # fmt: skip
    found = {(z.kind, z.modes, z.order): z for z in instability_zones(line, orders=2)}
    own, twice = found["principal", (1, 1), 1], found["sum", (1, 2), 2]
    assert not found["difference", (1, 2), 1].is_open
    speed = np.arange(0.84, 0.96, 2e-4)
    grows = speed[growth_rate(linearised_about_rigid_rotation(line, speed), tolerance=1e-12) > 1e-6]
    first, second = np.split(grows, np.flatnonzero(np.diff(grows) > 3e-4) + 1)
    for zone, hump, real in ((own, first, True), (twice, second, False)):
        assert (zone.low, zone.high) == pytest.approx((hump[0], hump[-1]), abs=3e-4)
        middle = linearised_about_rigid_rotation(line, hump[len(hump) // 2][None])
        largest = max(np.linalg.eigvals(monodromy_matrix(middle)[0]), key=abs)
        assert (abs(largest.imag) < 1e-6) == real
        assert real == (largest.real < -1)
