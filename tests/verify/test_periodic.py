"""Stability of periodic systems against NIST DLMF 28.6, Liouville's formula and SciPy.

The Mathieu values are those of DLMF table 28.6.1 (and of SciPy's `mathieu_a`, `mathieu_b`).
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import mathieu_a, mathieu_b

from cardan.physics.dynamics.floquet import (
    PeriodicSystem,
    evaluate_in_chunks,
    floquet_multipliers,
    growth_rate,
    hill_determinant,
    hill_multipliers,
    monodromy_matrix,
)
from cardan.physics.dynamics.stability_chart import (
    find_zeros,
    instability_tongue,
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
    """exp(-∫ tr M⁻¹C dt) over a period, by the trapezoidal rule, which is exact to rounding."""
    system = shaken()
    M, C, _ = system.matrices(np.arange(256) / 256)
    mean = np.trace(np.linalg.solve(M, C), axis1=-2, axis2=-1).mean(-1)
    np.testing.assert_allclose(
        np.linalg.det(monodromy_matrix(system)), np.exp(-mean * system.period), rtol=1e-9
    )


def test_hill_exponents_match_monodromy_matrix():
    for system in (shaken(), mathieu([0.3, 2.6], damping=0.1)):
        found, exact = hill_multipliers(system), floquet_multipliers(system, tolerance=1e-12)
        assert matched(found, exact) < 1e-8


def test_hill_determinant_vanishes_at_exponent():
    system = shaken()
    exponents = np.log(floquet_multipliers(system)) / system.period[:, None]
    for k in range(4):
        assert np.abs(hill_determinant(system, exponents[:, k])).max() < 1e-8
    assert np.abs(hill_determinant(system, np.full(2, 0.3 + 0.2j))).min() > 0.1


@pytest.mark.slow
def test_stability_chart_boundary_has_zero_margin():
    """Refined boundary and damped Mathieu equation agree."""
    margin = lambda a, q: evaluate_in_chunks(  # noqa: E731
        lambda a, q: growth_rate(mathieu(a, q, 0.1)), a, q
    )
    line = zero_contour(margin, x=(-0.5, 2.0), y=(0.0, 0.8), start=(8, 8), levels=3)
    assert np.abs(margin(*line.points.T)).max() < 1e-6
    assert line.evaluations < 0.6 * 65 * 65 + 15 * len(line.segments)
    tongue = line.points[line.points[:, 0] > 0.6]  # left of it is divergence, a < -q²/2
    # First-order theory: the tongue at a = 1 opens at q = c; the grid's cells end it higher.
    assert 0.1 <= tongue[:, 1].min() < 0.1 + 2 * 0.8 / 64


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
