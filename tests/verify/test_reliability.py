"""FORM, SORM and Monte Carlo against Wirsching's closed form (1984), spheres and OpenTURNS."""

import math

import numpy as np
import pytest

from cardan.core.errors import ConvergenceError
from cardan.physics.fatigue.crack_growth import paris_cycles
from cardan.physics.fatigue.reliability import (
    Lognormal,
    Normal,
    first_order_reliability,
    monte_carlo,
    second_order_reliability,
    sn_limit_state,
)

VARIABLES = (
    Lognormal(median=1e12, cov=0.4),
    Lognormal(median=1.0, cov=0.3),
    Lognormal(median=1.0, cov=0.2),
)
LIMIT = sn_limit_state(slope=3, load=1e11)


def test_lognormal_sn_limit_state_matches_closed_form():
    answer = first_order_reliability(LIMIT, VARIABLES)
    by_hand = math.log(10) / math.sqrt(math.log(1.16) + math.log(1.09) + 9 * math.log(1.04))
    assert by_hand == pytest.approx(3.00386675, abs=5e-9)
    assert answer.beta == pytest.approx(by_hand, rel=1e-9)
    assert answer.failure_probability == pytest.approx(1.33286e-3, abs=5e-9)
    shares = np.log([1.16, 1.09, 1.04]) * [1, 1, 9]
    np.testing.assert_allclose(answer.importance, shares / shares.sum(), rtol=1e-6)
    assert abs(LIMIT(answer.design_point)) < 1e-7


def test_monte_carlo_estimate_covers_exact_probability():
    plain = monte_carlo(LIMIT, VARIABLES, samples=400_000, seed=1)
    assert abs(plain.failure_probability - 1.33286e-3) < 4 * plain.standard_error
    near = monte_carlo(
        LIMIT, VARIABLES, samples=20_000, seed=1, around=first_order_reliability(LIMIT, VARIABLES)
    )
    assert abs(near.failure_probability - 1.33286e-3) < 4 * near.standard_error
    assert (
        near.standard_error < plain.standard_error / 2
    )  # twenty times fewer samples, and still surer
    assert near.beta == pytest.approx(3.00386675, abs=0.02)


def crack_limit(x):
    a0, C, B = x[..., 0], x[..., 1], x[..., 2]
    n = paris_cycles(start=a0, end=10.0, stress=100 * B, C=C, m=3.0)
    return np.log(np.maximum(n, 1e-300)) - math.log(2e5)


CRACK = (
    Lognormal(median=0.5, cov=0.5),
    Lognormal(median=3e-13, cov=0.5),
    Normal(mean=1.0, deviation=0.1),
)


@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore")
def test_form_of_curved_limit_state_matches_openturns():
    import openturns as ot

    def lognormal(v):
        return ot.LogNormal(math.log(v.median), math.sqrt(math.log1p(v.cov**2)))

    law = ot.JointDistribution([lognormal(CRACK[0]), lognormal(CRACK[1]), ot.Normal(1.0, 0.1)])
    g = ot.PythonFunction(3, 1, lambda x: [float(crack_limit(np.array(x)))])
    # Its own step, 1e-7, is too long for a C of 3e-13.
    steps = ot.Point([1e-6, 1e-19, 1e-6])
    g.setGradient(ot.CenteredFiniteDifferenceGradient(steps, g.getEvaluation()))
    event = ot.ThresholdEvent(ot.CompositeRandomVector(g, ot.RandomVector(law)), ot.Less(), 0.0)
    solver = ot.AbdoRackwitz()
    solver.setStartingPoint(law.getMean())
    solver.setMaximumAbsoluteError(1e-10)
    solver.setMaximumIterationNumber(1000)
    study = ot.FORM(solver, event)
    study.run()
    theirs = study.getResult().getHasoferReliabilityIndex()
    assert first_order_reliability(crack_limit, CRACK).beta == pytest.approx(theirs, rel=2e-6)


def test_form_of_curved_limit_state_matches_sampling():
    answer = first_order_reliability(crack_limit, CRACK)
    sampled = monte_carlo(crack_limit, CRACK, samples=40_000, seed=2, around=answer)
    # First order: right in the index to a per cent or two, not in the last digit.
    assert sampled.beta == pytest.approx(answer.beta, rel=0.02)


def test_failure_at_median_gives_negative_reliability_index():
    answer = first_order_reliability(sn_limit_state(slope=3, load=1e13), VARIABLES)
    assert answer.beta == pytest.approx(-3.00386675, abs=1e-8)
    assert answer.failure_probability == pytest.approx(1 - 1.33286e-3, abs=5e-9)


def test_missing_design_point_is_reported():
    with pytest.raises(ConvergenceError, match="limit state"):
        first_order_reliability(lambda x: 1 + 0 * x[..., 0], (Normal(mean=0, deviation=1),))


@pytest.mark.parametrize(("beta", "bend"), [(3.0, 0.3), (2.0, -0.15), (3.5, 1.0)])
def test_sorm_of_parabolic_limit_state_matches_quadrature(beta, bend):
    """g = β - u1 + κ u2²/2: Pf = ∫ Φ(-β - κ v²/2) φ(v) dv, by quadrature."""
    from scipy.integrate import quad
    from scipy.stats import norm

    def limit(x):
        return beta - x[..., 0] + bend / 2 * x[..., 1] ** 2

    both = (Normal(mean=0.0, deviation=1.0),) * 2
    first = first_order_reliability(limit, both)
    assert first.beta == pytest.approx(beta, rel=1e-6)
    second = second_order_reliability(limit, both, around=first)
    assert second.curvatures == pytest.approx([bend], rel=1e-5)
    exact, _ = quad(lambda v: norm.cdf(-beta - bend / 2 * v * v) * norm.pdf(v), -9, 9)
    # Asymptotic: some per cent, where first order misses by 12 to 140 %.
    assert second.failure_probability == pytest.approx(exact, rel=0.03)
    assert abs(first.failure_probability / exact - 1) > 4 * abs(
        second.failure_probability / exact - 1
    )


@pytest.mark.parametrize("beta", [30.0, -30.0])
def test_extreme_failure_probabilities_keep_precision(beta):
    """Φ(-30) is 5e-198, not 0: 1 - Φ(30) is, and by that second order divided."""
    from scipy.stats import norm

    both = (Normal(mean=0.0, deviation=1.0),) * 2
    first = first_order_reliability(lambda x: beta - x[..., 0], both, tolerance=1e-6)
    second = second_order_reliability(lambda x: beta - x[..., 0], both, around=first)
    assert [first.failure_probability, second.failure_probability] == pytest.approx(
        2 * [norm.sf(beta)], rel=1e-3, abs=0
    )


def test_sorm_of_crack_is_closer_to_sampling_than_form():
    first = first_order_reliability(crack_limit, CRACK)
    second = second_order_reliability(crack_limit, CRACK, around=first)
    sampled = monte_carlo(crack_limit, CRACK, samples=400_000, seed=2, around=first)
    assert second.failure_probability == pytest.approx(sampled.failure_probability, rel=0.02)
    assert abs(first.failure_probability / sampled.failure_probability - 1) > 2 * abs(
        second.failure_probability / sampled.failure_probability - 1
    )


def test_sorm_of_planar_limit_state_equals_form():
    first = first_order_reliability(LIMIT, VARIABLES)
    assert second_order_reliability(
        LIMIT, VARIABLES, around=first
    ).failure_probability == pytest.approx(first.failure_probability, rel=1e-5)


@pytest.mark.parametrize(("off", "radius", "inside"), [(6.0, 10.0, False), (9.0, 5.5, True)])
def test_sorm_of_spherical_limit_state_matches_closed_form(off, radius, inside):
    """Failing outside a sphere about (-off, 0, 0, 0), or inside: non-central chi-squared.

    It bends by 1/radius everywhere, towards the median from inside it and away from outside.
    """
    from scipy.stats import ncx2

    def limit(x):
        away = np.sqrt((x[..., 0] + off) ** 2 + (x[..., 1:] ** 2).sum(-1))
        return away - radius if inside else radius - away

    four = (Normal(mean=0.0, deviation=1.0),) * 4
    first = first_order_reliability(limit, four)
    assert first.beta == pytest.approx(abs(radius - off), rel=1e-6)
    second = second_order_reliability(limit, four, around=first)
    bend = 1 / radius if inside else -1 / radius
    assert second.curvatures == pytest.approx([bend] * 3, rel=1e-5)
    law = ncx2(4, off**2)
    exact = law.cdf(radius**2) if inside else law.sf(radius**2)
    assert second.failure_probability == pytest.approx(exact, rel=0.07)
    assert abs(math.log(first.failure_probability / exact)) > 8 * abs(
        math.log(second.failure_probability / exact)
    )


def test_design_point_is_found_to_finite_difference_precision():
    """It was given up as one where no step leads nearer, 1e-9 beside it."""

    def limit(x):
        u, v, w = x[..., 0], x[..., 1], x[..., 2]
        return 3 - u + 0.2 * v**2 - 0.05 * w**2 + 0.1 * v * w + 0.01 * u * v

    found = first_order_reliability(limit, (Normal(mean=0.0, deviation=1.0),) * 3)
    u, v, w = found.u
    slope = np.array([-1 + 0.01 * v, 0.4 * v + 0.1 * w + 0.01 * u, -0.1 * w + 0.1 * v])
    assert limit(found.u) == pytest.approx(0, abs=1e-8)
    # Nearest to the middle: there the surface stands across the way.
    assert found.u / found.beta == pytest.approx(-slope / np.linalg.norm(slope), abs=1e-7)


@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore")
def test_sorm_matches_openturns():
    """Their main curvatures and the same correction, of a surface bent by two and twisted."""
    import openturns as ot

    def limit(x):
        u, v, w = x[..., 0], x[..., 1], x[..., 2]
        return 3 - u + 0.2 * v**2 - 0.05 * w**2 + 0.1 * v * w + 0.01 * u * v

    names = ["u", "v", "w"]
    g = ot.SymbolicFunction(names, ["3 - u + 0.2*v^2 - 0.05*w^2 + 0.1*v*w + 0.01*u*v"])
    law = ot.Normal(3)
    event = ot.ThresholdEvent(ot.CompositeRandomVector(g, ot.RandomVector(law)), ot.Less(), 0.0)
    solver = ot.AbdoRackwitz()
    solver.setStartingPoint(law.getMean())
    solver.setMaximumAbsoluteError(1e-10)
    study = ot.SORM(solver, event)
    study.run()
    theirs = study.getResult()
    three = (Normal(mean=0.0, deviation=1.0),) * 3
    ours = second_order_reliability(limit, three, around=first_order_reliability(limit, three))
    np.testing.assert_allclose(
        np.sort(np.abs(ours.curvatures)),
        np.sort(np.abs(np.array(theirs.getSortedCurvatures())))[-2:], rtol=1e-4,
    )  # fmt: skip
    assert ours.failure_probability == pytest.approx(
        theirs.getEventProbabilityHohenbichler(), rel=1e-4
    )
