"""Lateral stability of Mazzei et al. (1999), internal damping of Vatta & Vigliani (2008).

The growth rates were computed from the authors' equations by an independent program; eight
digits are printed. Beam frequencies are held against the transcendental equation.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from cardan.core.errors import ConvergenceError, DesignError
from cardan.physics.dynamics.floquet import (
    differentiation_matrix,
    floquet_multipliers,
    growth_rate,
    hill_multipliers,
    monodromy_matrix,
)
from cardan.physics.dynamics.internal_damping import (
    hysteretic_threshold,
    hysteretic_whirl_growth,
    viscous_threshold,
    viscous_whirl_exponents,
)
from cardan.physics.dynamics.lateral import (
    flexible_shaft_system,
    misaligned_shaft_system,
    natural_frequencies,
    rigid_shaft_system,
)

MAZZEI = {
    "transverse_inertia": 1.0,
    "polar_inertia": 0.1,
    "stiffness": 1.0,
    "damping": 0.05,
}
PRINTED = [(1, 0.2, 0.5, 0.02404822), (0, 0.2, 2.0, 0.02716749)]


@pytest.mark.parametrize(("follower", "torque", "speed", "rate"), PRINTED)
def test_growth_rate_of_rigid_shaft_matches_mazzei(follower, torque, speed, rate):
    shaft = rigid_shaft_system(speed=speed, torque=torque, follower=follower, **MAZZEI)
    assert growth_rate(shaft.periodic_system, tolerance=1e-12) == pytest.approx(rate, abs=5e-9)


def test_rotating_frame_and_floquet_agree():
    """What is periodic at rest is constant to one who turns with the shaft."""
    speed, torque, follower = np.meshgrid([0.5, 1.1, 2.0], [0.1, 0.6], [0.0, 0.4, 1.0])
    shaft = rigid_shaft_system(speed=speed, torque=torque, follower=follower, **MAZZEI)
    np.testing.assert_allclose(
        growth_rate(shaft.periodic_system, tolerance=1e-12),
        shaft.rotating_frame_exponents().real.max(-1),
        atol=1e-10,
    )
    # Each multiplier of half a turn is exp(λ π/Ω) of a rotating exponent, turned back half
    # a turn: a sign.
    rho = floquet_multipliers(shaft.periodic_system, tolerance=1e-12)
    turned = -np.exp(shaft.rotating_frame_exponents() * np.pi / speed[..., None])
    assert np.abs(rho[..., :, None] - turned[..., None, :]).min(-1).max() < 1e-9


def test_unequal_bearings_require_floquet():
    shaft = rigid_shaft_system(speed=1.3, torque=0.2, stiffness_difference=0.2, **MAZZEI)
    with pytest.raises(DesignError, match="equal all round"):
        shaft.rotating_frame_exponents()
    found, hill = (
        floquet_multipliers(shaft.periodic_system, tolerance=1e-12),
        hill_multipliers(shaft.periodic_system),
    )
    assert np.abs(found[:, None] - hill).min(-1).max() < 1e-8


def test_unequal_bearings_stabilise_follower_torque():
    """Flutter needs the two directions in step: their split detunes it (Mazzei 1999).

    At low speed; at high speed the gyroscopic moment keeps the motion round, split or not.
    """
    split = np.array([0.0, 0.1, 0.2])
    rate = growth_rate(
        rigid_shaft_system(
            speed=0.2, torque=0.3, stiffness_difference=split, **MAZZEI
        ).periodic_system
    )
    assert np.all(np.diff(rate) < 0)
    assert rate[0] > 0 > rate[-1]


def test_flutter_torque_is_four_damping_ratios_times_stiffness():
    """About 4 ζ k, away from the zones, without gyroscopic moments."""
    zeta = 0.01
    shaft = {"transverse_inertia": 1.0, "polar_inertia": 0.0, "stiffness": 1.0, "damping": 2 * zeta}
    edge = brentq(
        lambda T: float(
            growth_rate(
                rigid_shaft_system(speed=7.3, torque=T, **shaft).periodic_system, tolerance=1e-12
            )
        ),
        2 * zeta,
        6 * zeta,
    )
    # The joint's twice-a-turn term adds (T / 2k)² of first order; here 4e-4.
    assert edge == pytest.approx(4 * zeta, rel=2e-3)


def beam(**changes):
    shaft = {
        "speed": 0.5, "torque": 0.2, "length": 2.0, "bending_stiffness": 10.0,
        "mass_per_length": 0.35, "bearing": 0.25, "bearing_damping": 0.0125,
        "rotary_inertia": 0.025,
    }  # fmt: skip
    return flexible_shaft_system(**(shaft | changes))


@pytest.mark.parametrize(("follower", "torque", "speed", "rate"), PRINTED)
def test_stiff_flexible_shaft_equals_rigid_shaft(follower, torque, speed, rate):
    """ρA L³/3 + ρI L = 1 and 2 ρI L = 0.1 make it Mazzei's; flexibility is k L / 3EI ~ 1e-9."""
    shaft = beam(
        speed=speed, torque=torque, follower=follower, functions=1, mass_per_length=3 * 0.95 / 8
    )
    assert shaft.rotating_frame_exponents().real.max() == pytest.approx(rate, abs=5e-9)


def test_beam_on_spring_has_exact_frequencies():
    """Pinned at the joint, spring s at the end: a (cot a - coth a) = -2 s L³ / EI, w = a² ..."""
    L, EI, rhoA, k = 2.0, 10.0, 0.35, 4.0
    shaft = beam(
        bending_stiffness=EI, mass_per_length=rhoA, bearing=k, rotary_inertia=0.0, functions=12
    )
    # w = sin and sinh of a x / L; moment-free end, shear EI w''' = k w:
    residue = lambda a: a**3 * (1 / np.tan(a) - 1 / np.tanh(a)) + 2 * k * L**3 / EI  # noqa: E731
    roots = [brentq(residue, low + 1e-3, low + np.pi - 1e-3) for low in (0.0, np.pi, 2 * np.pi)]
    exact = np.array(roots) ** 2 * np.sqrt(EI / rhoA) / L**2
    np.testing.assert_allclose(natural_frequencies(shaft)[:3], exact, rtol=1e-7)


@pytest.mark.parametrize("follower", [0.0, 1.0])
def test_galerkin_solution_satisfies_differential_equation(follower):
    """Strong form of the bent, twisted shaft, seen turning: z = e^{iWt} (u e^{λt} + v* e^{λ*t}).

    ρA (λ + iW)² u + EI u_xxxx + iT u_xxx = 0 from the balance of moments and forces, the same
    for v with -i; at the joint iEI u_xx = T (u_x + v_x)/2, at the load EI u_xx = -iT (1 - σ) u_x,
    shear EI u_xxx + iT u_xx = (k + c (λ + iW)) u. Eight exponentials: their determinant vanishes.
    """
    W, T, L, EI, rhoA, k, c = 0.5, 0.6, 2.0, 3.0, 0.35, 0.5, 0.03
    shaft = flexible_shaft_system(
        speed=W, torque=T, length=L, bending_stiffness=EI, mass_per_length=rhoA, bearing=k,
        bearing_damping=c, follower=follower, functions=14,
    )  # fmt: skip
    found = shaft.rotating_frame_exponents()
    found = found[np.argsort(np.abs(found))][:8]

    def residue(s):
        rows = np.zeros((8, 8), dtype=complex)
        for half, sign in ((0, 1j), (1, -1j)):
            rate = s + sign * W
            r = np.roots([EI, sign * T, 0, 0, rhoA * rate**2])
            at = slice(4 * half, 4 * half + 4)
            # Columns scaled so that none of the exponentials grows large.
            start = np.exp(-np.maximum((r * L).real, 0))
            grown = np.exp(r * L - np.maximum((r * L).real, 0))
            rows[half, at] = start
            rows[2 + half, at] = (sign * EI * r**2 - T / 2 * r) * start
            rows[3 - half, at] = -T / 2 * r * start
            rows[4 + half, at] = (EI * r**2 + sign * T * (1 - follower) * r) * grown
            rows[6 + half, at] = (EI * r**3 + sign * T * r**2 - (k + c * rate)) * grown
        rows /= np.abs(rows).max(axis=1, keepdims=True)
        return np.linalg.svd(rows, compute_uv=False)[-1]

    for s in found:
        assert residue(s) < 1e-7
        assert residue(s + 0.01) > 1e-5


def test_galerkin_converges():
    low = []
    for functions in (3, 5, 7, 9):
        exponents = beam(functions=functions).rotating_frame_exponents()
        low.append(exponents[np.abs(exponents.imag) < 3].real.max())
    error = np.abs(np.array(low[:-1]) - low[-1])
    assert error[0] < 2e-5
    assert error[1] < 5e-9
    assert error[2] < 1e-11


def test_flexible_floquet_and_rotating_frame_agree():
    shaft = beam(functions=3, internal_damping=1e-3)
    assert growth_rate(shaft.periodic_system, tolerance=1e-12) == pytest.approx(
        shaft.rotating_frame_exponents().real.max(), abs=1e-9
    )


@pytest.mark.parametrize(("follower", "torque", "speed", "rate"), PRINTED)
def test_aligned_shaft_equals_mazzei(follower, torque, speed, rate):
    shaft = {k: v for k, v in MAZZEI.items() if k != "stiffness"}
    system, swing = misaligned_shaft_system(
        speed=speed, torque=torque, follower=follower, beta=0.0, stiffness=(1.0, 1.0), **shaft
    )
    assert growth_rate(system, tolerance=1e-12) == pytest.approx(rate, abs=5e-9)
    assert np.abs(swing).max() < 1e-15


def newton_euler(t, state, *, beta, T, W, c, It, Ia, k, follower):
    """Rates of direction d, pin axis b and angular velocity of the shaft, by moments alone.

    The cross's moment is a multiplier along a x b that keeps (w - W d0).(a x b) at 0: neither
    coordinates, nor Lagrange, nor the spin that the joint sets.
    """
    d, pin, w = state.reshape(3, 3)
    d0 = np.array([-np.sin(beta), 0, np.cos(beta)])
    across = np.array([np.cos(beta), 0, np.sin(beta)])
    a = np.cos(W * t) * across + np.sin(W * t) * np.array([0, 1.0, 0])
    normal = np.cross(a, pin)
    turning = np.cross(W * np.cross(d0, a), pin) + np.cross(a, np.cross(w, pin))
    rate = np.cross(w, d)
    push = -np.array([k[0], k[1], 0]) * d - c * rate * [1, 1, 0]
    moment = np.cross(d, push) - T * (d if follower else d0 / np.cos(beta))
    inertia = It * np.eye(3) + (Ia - It) * np.outer(d, d)
    change = (Ia - It) * (np.outer(rate, d) + np.outer(d, rate))
    free = np.linalg.solve(inertia, moment - change @ w)
    each = np.linalg.solve(inertia, normal)
    size = -(turning @ (w - W * d0) + normal @ free) / (normal @ each)
    return np.concatenate([rate, np.cross(w, pin), free + size * each])


@pytest.mark.slow
@pytest.mark.parametrize(("follower", "Ia"), [(0.0, 0.0001), (1.0, 0.0001), (0.0, 0.1), (1.0, 0.1)])
def test_forced_motion_of_misaligned_shaft_is_periodic(follower, Ia):
    """The forced motion comes back after half a turn, and pushes map as the matrix says."""
    beta, T, W, c, k = 0.3, 0.2, 0.8, 0.1, (1.0, 1.2)
    shaft = {"transverse_inertia": 1.0, "polar_inertia": Ia, "damping": c}
    system, swing = misaligned_shaft_system(
        speed=W, torque=T, follower=follower, beta=beta, stiffness=k, **shaft
    )
    d0 = np.array([-np.sin(beta), 0, np.cos(beta)])
    a = np.array([np.cos(beta), 0, np.sin(beta)])

    def whole(z):
        """Direction, pin axis and angular velocity of inclinations and their rates."""
        x, y, dx, dy = z
        up = np.sqrt(1 - x * x - y * y)
        d, rate = np.array([x, y, up]), np.array([dx, dy, -(x * dx + y * dy) / up])
        pin = np.cross(d, a) / np.linalg.norm(np.cross(d, a))
        normal, w = np.cross(a, pin), np.cross(d, rate)
        return np.concatenate([d, pin, w + d * (normal @ (W * d0 - w)) / (normal @ d)])

    def end(z):
        done = solve_ivp(
            lambda t, y: newton_euler(
                t, y, beta=beta, T=T, W=W, c=c, It=1.0, Ia=Ia, k=k, follower=follower
            ),
            (0, np.pi / W), whole(z), method="DOP853", rtol=1e-12, atol=1e-13,
        )  # fmt: skip
        d, _, w = done.y[:, -1].reshape(3, 3)
        return np.array([*d[:2], *np.cross(w, d)[:2]])

    start = np.concatenate([swing[0], (differentiation_matrix(33) @ swing)[0] * W / np.pi])
    np.testing.assert_allclose(end(start), start, atol=1e-9)
    push = 1e-5
    P = np.stack(
        [(end(start + push * e) - end(start - push * e)) / (2 * push) for e in np.eye(4)], 1
    )
    np.testing.assert_allclose(monodromy_matrix(system), P, atol=1e-7)


@pytest.mark.parametrize(
    ("speed", "torque", "beta", "Ia", "rate", "aligned"),
    [
        (0.7, 0.05, 25, 0.001, -0.02486859, -0.02491345),
        (1.5, 0.03, 30, 0.001, -0.02471354, -0.02476002),
        (0.5, 0.2, 10, 0.1, 0.02193952, 0.01769170),
    ],
)
def test_growth_rate_of_misaligned_shaft_matches_reference(speed, torque, beta, Ia, rate, aligned):
    """It 1, k 1 in the plane of the shafts and 1.1 across, c 0.05: another program's digits.

    The angle feeds flutter; without the curvature of the motion and the spin that answers to
    tilt it seemed to calm it. An engine with halved steps agrees to 1e-5.
    """
    for angle, printed in ((beta, rate), (0, aligned)):
        system, _ = misaligned_shaft_system(
            speed=speed, torque=torque, beta=np.radians(angle), transverse_inertia=1.0,
            polar_inertia=Ia, stiffness=(1.0, 1.1), damping=0.05,
        )  # fmt: skip
        assert growth_rate(system, tolerance=1e-12) == pytest.approx(printed, abs=6e-9)


def test_missing_forced_motion_gives_nan_for_that_case_only():
    """A torque that bends the shaft past its bearing's hold has no answer; its neighbours do."""
    shaft = {"transverse_inertia": 1.0, "polar_inertia": 0.1, "stiffness": (1.0, 1.1),
             "damping": 0.05, "speed": 0.5}  # fmt: skip
    torque, beta = np.array([0.1, 0.2, 0.15]), np.radians([20.0, 30.0, 10.0])
    system, swing = misaligned_shaft_system(torque=torque, beta=beta, **shaft)
    rates = growth_rate(system)
    assert np.isnan(rates).tolist() == [False, True, False]
    assert np.isnan(swing[1]).all()
    alone, _ = misaligned_shaft_system(torque=0.1, beta=np.radians(20.0), **shaft)
    assert rates[0] == pytest.approx(float(growth_rate(alone)), rel=1e-9)
    with pytest.raises(ConvergenceError, match="no forced motion"):
        misaligned_shaft_system(torque=0.2, beta=np.radians(30.0), **shaft)


def test_misalignment_excites_order_2():
    """Mean moment T tan(beta)/2 and as much at order 2, to first order in the angle."""
    beta, T = 0.02, 0.1
    shaft = {"transverse_inertia": 1.0, "polar_inertia": 0.0, "damping": 0.02}
    _, q = misaligned_shaft_system(speed=2.0, torque=T, beta=beta, stiffness=(1.0, 1.0), **shaft)
    spectrum = np.abs(np.fft.fft(q[:, 0] + 1j * q[:, 1])) / 33
    static, rolling = spectrum[0], spectrum[1]
    assert static == pytest.approx(T * beta / 2, rel=0.05)  # over k = 1; T / k adds its share
    assert rolling == pytest.approx(T * beta / 2 / (4.0**2 - 1), rel=0.05)


def test_internal_damping_threshold_matches_closed_form():
    """At w_n (1 + c_e/c_i) exactly, by closed form, Mazzei's model and Floquet."""
    m, k, ce, ci = 2.0, 50.0, 0.3, 0.2
    edge = viscous_threshold(frequency=5.0, external=ce, internal=ci)
    assert edge == pytest.approx(12.5, rel=1e-15)
    speeds = edge * np.array([0.999, 1.0, 1.001])
    own = viscous_whirl_exponents(speed=speeds, mass=m, stiffness=k, external=ce, internal=ci)
    forward = own[:, 0].real
    assert forward[0] < 0 < forward[2]
    assert abs(forward[1]) < 1e-14
    shaft = rigid_shaft_system(
        speed=speeds, torque=0.0, transverse_inertia=m, polar_inertia=0.0, stiffness=k,
        damping=ce, internal_damping=ci,
    )  # fmt: skip
    np.testing.assert_allclose(
        growth_rate(shaft.periodic_system, tolerance=1e-12), forward, atol=1e-10
    )


def test_hysteretic_damping_destabilises_at_critical_speed():
    shaft = {"mass": 2.0, "stiffness": 50.0, "external": 0.1}
    rates = hysteretic_whirl_growth(speed=np.array([4.9, 5.1, 50.0]), loss_factor=0.05, **shaft)
    # Small damping: -c_e/2m -+ η w/2.
    np.testing.assert_allclose(rates[:, 0], [-0.15, 0.1, 0.1], rtol=2e-3)
    assert np.all(rates[:, 1] < 0)
    assert hysteretic_threshold(loss_factor=0.05, **shaft) == 5.0
    assert hysteretic_threshold(loss_factor=0.009, **shaft) == np.inf
