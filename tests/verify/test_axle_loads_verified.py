"""Axle loads against Gillespie (1992), ch. 1-2, Wong (2008), ch. 3, and a force balance."""

import numpy as np
import pytest

from cardan.core.units import deg, g
from cardan.model.vehicle import AuxiliaryAxle, LoadState, Vehicle
from cardan.physics.vehicle.axle_loads import (
    axle_loads_at_wheel_slip,
    driveline_axle_loads,
    static_axle_loads,
)

MASS, LF, L, H, MU = 16000.0, 3.4, 5.2, 1.35, 0.8
W, LR = MASS * g, L - LF
LADEN = LoadState(name="gvw", mass=MASS, cg_behind_front=LF, cg_height=H)


def loads(*, front_share, rear_share, grade=0.0, friction=MU, auxiliary=()):
    vehicle = Vehicle(drive="6x2" if auxiliary else "4x2", wheelbase=L, auxiliary=auxiliary)
    return axle_loads_at_wheel_slip(
        static_axle_loads(vehicle, LADEN, grade=grade),
        friction=friction,
        cg_height=H,
        wheelbase=L,
        front_share=front_share,
        rear_share=rear_share,
    )


def test_static_axle_loads_match_gillespie():
    """Gillespie: Wf = W c/L, Wr = W b/L."""
    found = static_axle_loads(Vehicle(drive="4x2", wheelbase=L), LADEN)
    assert found.front == pytest.approx(W * LR / L, rel=1e-14)
    assert found.rear == pytest.approx(W * LF / L, rel=1e-14)


def test_axle_loads_on_grade_match_gillespie():
    """Gillespie: Wr = (W b cos θ + W h sin θ)/L; h takes part with the tyres' force alone."""
    theta = 12 * deg
    found = static_axle_loads(Vehicle(drive="4x2", wheelbase=L), LADEN, grade=theta)
    assert found.rear == pytest.approx(W * LF * np.cos(theta) / L, rel=1e-14)
    assert found.front == pytest.approx(W * LR * np.cos(theta) / L, rel=1e-14)


def test_rear_drive_at_the_slip_limit():
    """Gillespie: Fx = μ W b/L / (1 - μ h/L); Wong the same without rolling resistance."""
    found = loads(front_share=0, rear_share=1)
    assert MU * found.rear == pytest.approx(MU * W * LF / L / (1 - MU * H / L), rel=1e-14)


def test_front_drive_at_the_slip_limit():
    """Gillespie: Fx = μ W c/L / (1 + μ h/L)."""
    found = loads(front_share=1, rear_share=0)
    assert MU * found.front == pytest.approx(MU * W * LR / L / (1 + MU * H / L), rel=1e-14)


def test_all_wheel_drive_at_the_slip_limit():
    """All tyres slip: Fx = μ W, so Wr = W (b + μ h)/L."""
    found = loads(front_share=1, rear_share=1)
    assert found.rear == pytest.approx(W * (LF + MU * H) / L, rel=1e-14)
    assert found.front == pytest.approx(W * (LR - MU * H) / L, rel=1e-14)


def test_bogie_driven_by_share_of_load_matches_force_balance():
    """F = μ s N and N = W lf/(L - μ s h)."""
    s = 0.62
    found = loads(front_share=0, rear_share=s)
    assert found.rear == pytest.approx(W * LF / (L - MU * s * H), rel=1e-14)


@pytest.mark.parametrize("grade", [0, 8 * deg, -5 * deg])
@pytest.mark.parametrize("friction", [0.8, 0.3, -0.6])
@pytest.mark.parametrize("shares", [(0, 1), (1, 0), (1, 1), (0, 0.6), (1, 0.5), (0.5, 1)])
@pytest.mark.parametrize(
    "auxiliary", [(), (AuxiliaryAxle(behind_front=6.5, load=30e3),)], ids=["none", "tag axle"]
)
def test_forces_and_moments_balance(grade, friction, shares, auxiliary):
    """Newton and Euler of the whole vehicle, solved as three equations for Nf, Nr, m a.

    The centre of gravity is the centre of moments: nothing of the closed form is used.
    Rounding of a 3 x 3 solve.
    """
    front_share, rear_share = shares
    air = [(a.load, a.behind_front) for a in auxiliary]
    # Along the road (forward), square to it, about the centre of gravity (nose up).
    push = friction * front_share, friction * rear_share
    matrix = [
        [push[0], push[1], -1.0],
        [1.0, 1.0, 0.0],
        [LF + push[0] * H, LF - L + push[1] * H, 0.0],
    ]
    right = [
        W * np.sin(grade),
        W * np.cos(grade) - sum(a for a, _ in air),
        sum(a * (x - LF) for a, x in air),
    ]
    front, rear, _ = np.linalg.solve(matrix, right)
    found = loads(
        front_share=front_share,
        rear_share=rear_share,
        grade=grade,
        friction=friction,
        auxiliary=auxiliary,
    )
    assert found.front == pytest.approx(front, rel=1e-12)
    assert found.rear == pytest.approx(rear, rel=1e-12)


def test_grade_adds_no_second_load_transfer():
    """At the slip limit the grade only takes cos θ off: its W sin θ is part of F.

    Adding W sin θ h/L to the closed form counts it twice: at 10 deg, 5.5 % too much here.
    """
    level, slope = (loads(front_share=0, rear_share=1, grade=a).rear for a in (0, 10 * deg))
    assert slope == pytest.approx(level * np.cos(10 * deg), rel=1e-14)
    twice = slope + W * np.sin(10 * deg) * H / L
    assert twice / slope - 1 == pytest.approx(np.tan(10 * deg) * H * (L - MU * H) / (L * LF))


@pytest.mark.parametrize(
    ("drive", "drives", "share", "expected"),
    [
        ("4x2", "rear", 1.0, W * LF / (L - MU * H)),
        ("4x4", "front", 1.0, W * LR / (L + MU * H)),  # as in front drive: the rear on ice
        ("4x4", "rear", 1.0, W * (LF + MU * H) / L),
        ("4x4", "all", 1.0, W),
        ("6x2", "rear", 1.0, 0.5 * W * LF / (L - 0.5 * MU * H)),
        ("6x4", "rear", 1.0, W * LF / (L - MU * H)),
        ("6x4", "rear", 0.5, 0.5 * W * LF / (L - MU * H)),
        ("6x6", "all", 1.0, W),
        ("8x2", "rear", 1.0, 0.5 * W * LF / (L - 0.5 * MU * H)),
        ("8x4", "rear", 1.0, W * LF / (L - MU * H)),
        ("8x8", "front", 0.5, 0.5 * W * LR / (L + 0.5 * MU * H)),
    ],
)
def test_line_traction_uses_load_of_its_driven_axle(drive, drives, share, expected):
    vehicle = Vehicle(drive=drive, wheelbase=L, loads=(LADEN,))
    found = driveline_axle_loads(vehicle, LADEN, drives=drives, load_share=share, friction=MU)
    assert found.traction == pytest.approx(expected, rel=1e-14)
