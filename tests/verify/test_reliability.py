"""FORM, SORM and Monte Carlo against Wirsching's closed form (1984), spheres and OpenTURNS."""

import math

import numpy as np
import pytest

from cardan.base.errors import NotConverged
from cardan.fatigue.crack import paris_cycles
from cardan.fatigue.reliability import (
    Gumbel,
    Lognormal,
    Normal,
    Weibull,
    form,
    monte_carlo,
    sn_limit,
    sorm,
)

VARIABLES = (
    Lognormal(median=1e12, cov=0.4),
    Lognormal(median=1.0, cov=0.3),
    Lognormal(median=1.0, cov=0.2),
)
LIMIT = sn_limit(slope=3, load=1e11)


def test_lognormal_sn_limit_is_exact():
    answer = form(LIMIT, VARIABLES)
    by_hand = math.log(10) / math.sqrt(math.log(1.16) + math.log(1.09) + 9 * math.log(1.04))
    assert by_hand == pytest.approx(3.00386675, abs=5e-9)
    assert answer.beta == pytest.approx(by_hand, rel=1e-9)
    assert answer.failure == pytest.approx(1.33286e-3, abs=5e-9)
    shares = np.log([1.16, 1.09, 1.04]) * [1, 1, 9]
    np.testing.assert_allclose(answer.importance, shares / shares.sum(), rtol=1e-6)
    assert abs(LIMIT(answer.point)) < 1e-7


def test_monte_carlo_covers_it():
    plain = monte_carlo(LIMIT, VARIABLES, samples=400_000, seed=1)
    assert abs(plain.failure - 1.33286e-3) < 4 * plain.error
    near = monte_carlo(LIMIT, VARIABLES, samples=20_000, seed=1, around=form(LIMIT, VARIABLES))
    assert abs(near.failure - 1.33286e-3) < 4 * near.error
    assert near.error < plain.error / 2  # twenty times fewer samples, and still surer
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
def test_curved_limit_is_openturns():
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
    assert form(crack_limit, CRACK).beta == pytest.approx(theirs, rel=2e-6)


def test_curved_limit_by_sampling():
    answer = form(crack_limit, CRACK)
    sampled = monte_carlo(crack_limit, CRACK, samples=40_000, seed=2, around=answer)
    # First order: right in the index to a per cent or two, not in the last digit.
    assert sampled.beta == pytest.approx(answer.beta, rel=0.02)


def test_variables_have_their_quantiles():
    u = np.array([-2.0, 0.0, 1.5])
    from scipy import stats

    p = stats.norm.cdf(u)
    np.testing.assert_allclose(
        Weibull(scale=2, shape=1.5).value(u), stats.weibull_min.ppf(p, 1.5, scale=2), rtol=1e-12
    )
    np.testing.assert_allclose(
        Gumbel(mode=3, scale=0.5).value(u), stats.gumbel_r.ppf(p, 3, 0.5), rtol=1e-12
    )


def test_failing_at_the_median_has_a_negative_index():
    answer = form(sn_limit(slope=3, load=1e13), VARIABLES)
    assert answer.beta == pytest.approx(-3.00386675, abs=1e-8)
    assert answer.failure == pytest.approx(1 - 1.33286e-3, abs=5e-9)


def test_no_design_point_is_said():
    with pytest.raises(NotConverged, match="limit state"):
        form(lambda x: 1 + 0 * x[..., 0], (Normal(mean=0, deviation=1),))


@pytest.mark.parametrize(("beta", "bend"), [(3.0, 0.3), (2.0, -0.15), (3.5, 1.0)])
def test_second_order_of_a_parabola(beta, bend):
    """g = β - u1 + κ u2²/2: Pf = ∫ Φ(-β - κ v²/2) φ(v) dv, by quadrature."""
    from scipy.integrate import quad
    from scipy.stats import norm

    def limit(x):
        return beta - x[..., 0] + bend / 2 * x[..., 1] ** 2

    both = (Normal(mean=0.0, deviation=1.0),) * 2
    first = form(limit, both)
    assert first.beta == pytest.approx(beta, rel=1e-6)
    second = sorm(limit, both, around=first)
    assert second.curvatures == pytest.approx([bend], rel=1e-5)
    exact, _ = quad(lambda v: norm.cdf(-beta - bend / 2 * v * v) * norm.pdf(v), -9, 9)
    # Asymptotic: some per cent, where first order misses by 12 to 140 %.
    assert second.failure == pytest.approx(exact, rel=0.03)
    assert abs(first.failure / exact - 1) > 4 * abs(second.failure / exact - 1)


@pytest.mark.parametrize("beta", [30.0, -30.0])
def test_what_hardly_ever_fails_has_odds_and_what_always_does(beta):
    """Φ(-30) is 5e-198, not 0: 1 - Φ(30) is, and by that second order divided."""
    from scipy.stats import norm

    both = (Normal(mean=0.0, deviation=1.0),) * 2
    first = form(lambda x: beta - x[..., 0], both, tolerance=1e-6)
    second = sorm(lambda x: beta - x[..., 0], both, around=first)
    assert [first.failure, second.failure] == pytest.approx(2 * [norm.sf(beta)], rel=1e-3, abs=0)


def test_second_order_of_a_crack_is_nearer():
    first = form(crack_limit, CRACK)
    second = sorm(crack_limit, CRACK, around=first)
    sampled = monte_carlo(crack_limit, CRACK, samples=400_000, seed=2, around=first)
    assert second.failure == pytest.approx(sampled.failure, rel=0.02)
    assert abs(first.failure / sampled.failure - 1) > 2 * abs(second.failure / sampled.failure - 1)


def test_second_order_of_a_plane_is_first_order():
    first = form(LIMIT, VARIABLES)
    assert sorm(LIMIT, VARIABLES, around=first).failure == pytest.approx(first.failure, rel=1e-5)


@pytest.mark.parametrize(("off", "radius", "inside"), [(6.0, 10.0, False), (9.0, 5.5, True)])
def test_second_order_of_a_sphere(off, radius, inside):
    """Failing outside a sphere about (-off, 0, 0, 0), or inside: non-central chi-squared.

    It bends by 1/radius everywhere, towards the median from inside it and away from outside.
    """
    from scipy.stats import ncx2

    def limit(x):
        away = np.sqrt((x[..., 0] + off) ** 2 + (x[..., 1:] ** 2).sum(-1))
        return away - radius if inside else radius - away

    four = (Normal(mean=0.0, deviation=1.0),) * 4
    first = form(limit, four)
    assert first.beta == pytest.approx(abs(radius - off), rel=1e-6)
    second = sorm(limit, four, around=first)
    bend = 1 / radius if inside else -1 / radius
    assert second.curvatures == pytest.approx([bend] * 3, rel=1e-5)
    law = ncx2(4, off**2)
    exact = law.cdf(radius**2) if inside else law.sf(radius**2)
    assert second.failure == pytest.approx(exact, rel=0.07)
    assert abs(math.log(first.failure / exact)) > 8 * abs(math.log(second.failure / exact))


def test_a_point_is_found_as_near_as_differences_tell():
    """It was given up as one where no step leads nearer, 1e-9 beside it."""

    def limit(x):
        u, v, w = x[..., 0], x[..., 1], x[..., 2]
        return 3 - u + 0.2 * v**2 - 0.05 * w**2 + 0.1 * v * w + 0.01 * u * v

    found = form(limit, (Normal(mean=0.0, deviation=1.0),) * 3)
    u, v, w = found.u
    slope = np.array([-1 + 0.01 * v, 0.4 * v + 0.1 * w + 0.01 * u, -0.1 * w + 0.1 * v])
    assert limit(found.u) == pytest.approx(0, abs=1e-8)
    # Nearest to the middle: there the surface stands across the way.
    assert found.u / found.beta == pytest.approx(-slope / np.linalg.norm(slope), abs=1e-7)


@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore")
def test_second_order_is_openturns():
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
    ours = sorm(limit, three, around=form(limit, three))
    np.testing.assert_allclose(
        np.sort(np.abs(ours.curvatures)),
        np.sort(np.abs(np.array(theirs.getSortedCurvatures())))[-2:], rtol=1e-4,
    )  # fmt: skip
    assert ours.failure == pytest.approx(theirs.getEventProbabilityHohenbichler(), rel=1e-4)
