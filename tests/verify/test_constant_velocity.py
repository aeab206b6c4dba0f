"""Constant-velocity arrangements against the exact chain and Seherr-Thoss et al. (2006), ch. 1."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cardan.base.errors import DesignError
from cardan.base.units import deg, mm
from cardan.kinematics.constant_velocity import (
    bisecting_ratio,
    centring_irregularity,
    double_cardan,
    halves,
    persian,
)

angles = st.floats(1 * deg, 50 * deg)


@given(beta=angles)
def test_well_centred_is_constant(beta):
    run = double_cardan(beta, front=40 * mm, rear=40 * mm)
    np.testing.assert_allclose(run.speed[-1], 1.0, atol=1e-13)
    assert centring_irregularity(beta, front=40 * mm, rear=40 * mm) < 1e-15


@given(beta=angles, error=st.floats(0.1 * mm, 10 * mm))
def test_closed_form_is_the_exact_chain(beta, error):
    run = double_cardan(beta, front=40 * mm + error, rear=40 * mm, samples=256)
    swing = run.speed[-1].max() - run.speed[-1].min()
    closed = centring_irregularity(beta, front=40 * mm + error, rear=40 * mm)
    # Extremes of an even function of the turn lie on the samples.
    assert swing == pytest.approx(closed, rel=1e-9, abs=1e-14)


def test_halves_are_a_triangle():
    shared = halves(0.6, front=0.05, rear=0.03)
    # Law of sines, and the projections on the line of the joints.
    assert np.sin(shared.front) / 0.03 == pytest.approx(np.sin(0.6) / shared.distance)
    assert np.sin(shared.rear) / 0.05 == pytest.approx(np.sin(0.6) / shared.distance)
    with pytest.raises(DesignError, match="between the joints"):
        halves(0.6, front=0.0, rear=0.03)


def test_a_small_error_costs_first_order():
    """β₁ - β₂ = δ: the ratio is off by β δ / 2 to both sides, the swing is their sum."""
    beta = 10 * deg
    shared = halves(beta, front=41 * mm, rear=40 * mm)
    apart = abs(float(shared.front - shared.rear))
    swing = centring_irregularity(beta, front=41 * mm, rear=40 * mm)
    assert swing == pytest.approx(beta * apart, rel=beta**2)


def test_persian_joint_runs_evenly_at_135_degrees():
    assert np.ptp(persian(135 * deg).speed[-1]) < 1e-12
    assert np.ptp(persian(135 * deg, error=1 * deg, samples=1024).speed[-1]) > 0.05


def test_rzeppa():
    theta = np.linspace(0, 2 * np.pi, 90)
    np.testing.assert_allclose(bisecting_ratio(theta, beta=0.7), 1.0, atol=1e-15)
    off = bisecting_ratio(theta, beta=0.7, error=0.01)
    assert off.mean() == pytest.approx(1.0, abs=2e-3)
    # The same as a Persian joint off by as much.
    run = persian(0.7, error=0.01, samples=256)
    off = bisecting_ratio(run.theta, beta=0.7, error=0.01)
    assert np.ptp(off) == pytest.approx(np.ptp(run.speed[-1]), rel=1e-6)
