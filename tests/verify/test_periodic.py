"""Stability of periodic systems against NIST DLMF 28.6, Liouville's formula and SciPy.

The Mathieu values are those of DLMF table 28.6.1 (and of SciPy's `mathieu_a`, `mathieu_b`).
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import mathieu_a, mathieu_b

from cardan.physics.dynamics.floquet import (
    PeriodicSystem,
    differentiation_matrix,
    evaluate_in_chunks,
    floquet_exponents,
    floquet_modes,
    floquet_multipliers,
    growth_rate,
    hill_determinant,
    hill_multipliers,
    liouville_determinant,
    monodromy_matrix,
    periodic_response,
)
from cardan.physics.dynamics.stability_chart import (
    find_zeros,
    instability_tongue,
    trace_zero_contour_from_point,
    zero_contour,
)

RNG = np.random.default_rng(5)
PARTS = 0.15 * RNG.normal(size=(5, 2, 2))


def mathieu(a, q=1.0, damping=0.0):
    """y'' + c y' + (a - 2 q cos 2t) y = 0."""
    a, q = np.broadcast_arrays(np.asarray(a, float), np.asarray(q, float))
    return PeriodicSystem(
        period=np.full(a.shape, np.pi),
        matrices=lambda t: (
            np.eye(1),
            damping * np.eye(1),
            (a[..., None] - 2 * q[..., None] * np.cos(2 * np.pi * t))[..., None, None],
        ),
    )


def shaken(periods=(2.0, 3.5)):
    """Two coordinates with everything periodic: mass, damping, gyroscopic, stiffness."""
    wave = lambda f, t: f(2 * np.pi * t)[:, None, None]  # noqa: E731
    return PeriodicSystem(
        period=np.asarray(periods),
        matrices=lambda t: (
            np.eye(2) + wave(np.cos, t) * PARTS[0],
            0.1 * np.eye(2) + PARTS[1] + wave(np.sin, t) * PARTS[2],
            2 * np.eye(2) + PARTS[3] + 3 * wave(np.cos, t) * PARTS[4],
        ),
    )


def matched(a, b):
    """Largest distance from each of a to its nearest of b."""
    return np.abs(a[..., :, None] - b[..., None, :]).min(-1).max()


@pytest.mark.parametrize(
    ("printed", "exact"),
    [
        (-0.455139, mathieu_a(0, 1)),
        (1.859108, mathieu_a(1, 1)),
        (-0.110249, mathieu_b(1, 1)),
        (3.917025, mathieu_b(2, 1)),
    ],
)
def test_characteristic_values_match_mathieu_tables(printed, exact):
    trace = lambda a: np.trace(monodromy_matrix(mathieu(a), tolerance=1e-12), axis1=-2, axis2=-1)  # noqa: E731
    found = find_zeros(lambda a: np.abs(trace(a)) - 2, between=(-1, 4.2))
    nearest = found[np.abs(found - printed).argmin()]
    assert nearest == pytest.approx(printed, abs=5e-7)  # its printed digits
    assert nearest == pytest.approx(float(exact), abs=1e-9)


def test_monodromy_matches_general_integrator():
    system = shaken()
    P = monodromy_matrix(system, tolerance=1e-11)
    for k, period in enumerate(system.period):

        def rate(t, z, period=period):
            M, C, K = (part[0] for part in system.matrices(np.array([t / period])))
            q, v = z.reshape(2, 2, 4)
            return np.concatenate([v, -np.linalg.solve(M, C @ v + K @ q)]).ravel()

        done = solve_ivp(
            rate, (0, period), np.eye(4).ravel(), method="DOP853", rtol=1e-12, atol=1e-13
        )
        # Both run at 1e-11 or better; the integrator gathers about ten times its step error.
        np.testing.assert_allclose(P[k], done.y[:, -1].reshape(4, 4), atol=3e-10)


def test_monodromy_determinant_satisfies_liouville():
    system = shaken()
    np.testing.assert_allclose(
        np.linalg.det(monodromy_matrix(system)), liouville_determinant(system), rtol=1e-9
    )


def test_hill_exponents_match_monodromy_matrix():
    for system in (shaken(), mathieu([0.3, 2.6], damping=0.1)):
        found, exact = hill_multipliers(system), floquet_multipliers(system, tolerance=1e-12)
        assert matched(found, exact) < 1e-8


def test_hill_determinant_vanishes_at_exponent():
    system = shaken()
    for k in range(4):
        assert np.abs(hill_determinant(system, floquet_exponents(system)[:, k])).max() < 1e-8
    assert np.abs(hill_determinant(system, np.full(2, 0.3 + 0.2j))).min() > 0.1


def test_floquet_modes_satisfy_equation():
    """p of q = e^{λt} p is put back into the equation, differentiated spectrally."""
    system = shaken()
    rates, shapes = floquet_modes(system, samples=64)
    k = np.fft.fftfreq(64, 1 / 64)
    for case, period in enumerate(system.period):
        M, C, K = system.matrices(np.arange(64) / 64)
        for rate, p in zip(rates[case], shapes[case], strict=True):
            spectrum = np.fft.fft(p, axis=0)
            s = rate + 2j * np.pi * k[:, None] / period
            q, v, a = (np.fft.ifft(s**n * spectrum, axis=0) for n in range(3))
            left = np.einsum("sij,sj->si", np.broadcast_to(M, (64, 2, 2)), a)
            left += np.einsum("sij,sj->si", C, v) + np.einsum("sij,sj->si", K, q)
            assert np.abs(left).max() < 1e-6 * np.abs(a).max()


def test_periodic_response_repeats_after_one_period():
    """The state the response starts from comes back after a period of plain integration."""
    system = shaken()
    phase = np.arange(41) / 41
    force = np.stack([np.cos(2 * np.pi * phase), 0.3 + np.sin(4 * np.pi * phase)], -1)
    q = periodic_response(system, force)
    v = np.einsum("ij,...ja->...ia", differentiation_matrix(41), q) / system.period[:, None, None]
    for k, period in enumerate(system.period):

        def rate(t, z, period=period):
            M, C, K = (part[0] for part in system.matrices(np.array([t / period])))
            wave = 2 * np.pi * t / period
            f = np.array([np.cos(wave), 0.3 + np.sin(2 * wave)])
            return np.concatenate([z[2:], np.linalg.solve(M, f - C @ z[2:] - K @ z[:2])])

        start = np.concatenate([q[k, 0], v[k, 0]])
        done = solve_ivp(rate, (0, period), start, method="DOP853", rtol=1e-11, atol=1e-12)
        np.testing.assert_allclose(done.y[:, -1], start, atol=1e-8)


@pytest.mark.slow
def test_stability_chart_boundary_has_zero_margin():
    """Refined boundary, continued curve and damped Mathieu equation agree."""
    margin = lambda a, q: evaluate_in_chunks(  # noqa: E731
        lambda a, q: growth_rate(mathieu(a, q, 0.1)), a, q
    )
    line = zero_contour(margin, x=(-0.5, 2.0), y=(0.0, 0.8), start=(8, 8), levels=3)
    assert np.abs(margin(*line.points.T)).max() < 1e-6
    assert line.evaluations < 0.6 * 65 * 65 + 15 * len(line.segments)
    tongue = line.points[line.points[:, 0] > 0.6]  # left of it is divergence, a < -q²/2
    tip = tongue[tongue[:, 1].argmin()]
    followed = trace_zero_contour_from_point(margin, start=tip, x=(-0.5, 2.0), y=(0.0, 0.8))
    # First-order theory: the tongue at a = 1 opens at q = c; second order is c²/8.
    assert followed[:, 1].min() == pytest.approx(0.1, rel=0.01)


@pytest.mark.slow
def test_narrow_instability_tongue_is_traced_to_its_tip():
    """Damped Mathieu, c 0.01: at a = 1 it opens at q = c, at a = 4 near q = √(4c) (DLMF 28.6).

    a_2 - b_2 = q²/2 there, so q² / 4 = 2 c to first order. A grid's cells end it higher,
    where one of its corners happens to fall inside.
    """
    c = 0.01

    def margin(a, q):
        return growth_rate(mathieu(a, q, c))

    first = instability_tongue(margin, centre=1.0, x=(0.2, 5.0), y=(0.0, 0.5))
    second = instability_tongue(margin, centre=4.0, x=(0.2, 5.0), y=(0.0, 1.0), reach=0.1)
    assert first.tip[1] == pytest.approx(c, rel=1e-3)
    assert first.tip[0] == pytest.approx(1.0, abs=1e-3)
    assert second.tip[1] == pytest.approx(np.sqrt(8 * c), rel=0.02)
    for found in (first, second):
        assert np.abs(margin(*found.low[:-1].T)).max() < 1e-5
        assert np.abs(margin(*found.high[:-1].T)).max() < 1e-5
        # Just below its tip nothing grows, however near one looks.
        near = found.tip[0] + np.linspace(-0.02, 0.02, 401)
        assert margin(near, np.full(401, 0.99 * found.tip[1])).max() < 0
    assert instability_tongue(margin, centre=2.5, x=(0.2, 5.0), y=(0.0, 1.0), reach=0.02) is None
    # The edges of the wide end are Mathieu's own, but for the damping.
    assert first.low[0, 0] == pytest.approx(float(mathieu_b(1, 0.5)), abs=2e-4)
    assert first.high[0, 0] == pytest.approx(float(mathieu_a(1, 0.5)), abs=2e-4)


def test_case_without_solution_gives_nan_for_that_case_only():
    system = mathieu(np.array([0.3, np.nan, 2.6]), damping=0.1)
    found = growth_rate(system)
    alone = growth_rate(mathieu(np.array([0.3, 2.6]), damping=0.1))
    np.testing.assert_allclose(found[[0, 2]], alone, rtol=1e-12)
    assert np.isnan(found[1])
    # Nor is a zero looked for beside it.
    np.testing.assert_allclose(
        find_zeros(lambda x: np.where(abs(x - 0.25) < 0.2, np.nan, x - 0.7), between=(0, 1)), [0.7]
    )


def test_closed_boundary_curve_closes():
    round_trip = trace_zero_contour_from_point(
        lambda x, y: x**2 + 4 * y**2 - 1, start=(1, 0.1), x=(-2, 2), y=(-2, 2)
    )
    np.testing.assert_array_equal(round_trip[0], round_trip[-1])
    np.testing.assert_allclose((round_trip**2 @ [1, 4]), 1, atol=1e-9)
    steps = np.diff(round_trip, axis=0)
    # Perimeter of the ellipse 1 by 1/2 is 4.8442; chords of 0.08 fall short by about 0.1 %.
    assert np.linalg.norm(steps, axis=1).sum() == pytest.approx(4.8442, rel=2e-3)
