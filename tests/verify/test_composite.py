"""Composite tubes after Jones (1999), Tsai & Hahn (1980), Khoshravan & Paykani (2012)."""

import numpy as np
import pytest

from cardan.base.errors import DesignError
from cardan.base.units import GPa, MPa, deg, mm, rpm
from cardan.shaft.composite import (
    CARBON_EPOXY,
    GLASS_EPOXY,
    CompositeTube,
    judged,
    lightest,
    steel_wall,
    strength_ratio,
    tsai_hill,
    tsai_wu,
)


def test_steel_tube_of_the_paper():
    """T 5 kN m, outside radius 30 mm, von Mises 750 MPa: 2.200 mm and 3.117 kg/m at 7800 kg/m³."""
    wall = steel_wall(5000.0, outer_radius=30 * mm, yield_strength=750 * MPa)
    assert wall / mm == pytest.approx(2.200, abs=5e-4)
    mass = 2 * np.pi * (0.03 - wall / 2) * wall * 7800
    assert mass == pytest.approx(3.117, abs=5.1e-4)


def test_reduced_stiffness_of_t300_5208():
    """Tsai & Hahn (1980), table 1.8: Q 181.81, 10.346, 2.897, 7.17 GPa."""
    Q = CARBON_EPOXY.stiffness / GPa
    np.testing.assert_allclose(
        [Q[0, 0], Q[1, 1], Q[0, 1], Q[2, 2]], [181.81, 10.346, 2.897, 7.17], rtol=2e-4
    )


def test_turned_stiffness_of_t300_5208():
    """Tsai & Hahn (1980), table 3.6, 45 deg: Q 56.66, 56.66, 42.32, 46.59 GPa."""
    tube = CompositeTube(outer=0.1, ply=CARBON_EPOXY, angles=(45 * deg,))
    Q = tube.membrane / tube.wall / GPa
    np.testing.assert_allclose(
        [Q[0, 0], Q[1, 1], Q[0, 1], Q[2, 2], Q[0, 2]], [56.66, 56.66, 42.32, 46.59, 42.87],
        rtol=3e-4,
    )  # fmt: skip


def test_quasi_isotropic_laminate_is_isotropic():
    angles = tuple(np.radians([0, 45, -45, 90]))
    axial, hoop, shear = CompositeTube(outer=0.1, ply=GLASS_EPOXY, angles=angles).moduli
    assert hoop == pytest.approx(axial, rel=1e-12)
    A = CompositeTube(outer=0.1, ply=GLASS_EPOXY, angles=angles).membrane
    poisson = A[0, 1] / A[0, 0]
    assert shear == pytest.approx(axial / (2 * (1 + poisson)), rel=1e-12)


def test_ply_stresses_carry_the_torque():
    """Turned back and summed through the wall they are T / (2π r²), and nothing else."""
    tube = CompositeTube(outer=0.09, ply=CARBON_EPOXY, angles=tuple(np.radians([45, -45, 0, 90])))
    T = 2000.0
    force = np.zeros(3)
    for angle, (s1, s2, s6) in zip(tube.angles, tube.ply_stresses(T), strict=True):
        c, s = np.cos(angle), np.sin(angle)
        force += tube.ply.thickness * np.array([
            c * c * s1 + s * s * s2 - 2 * c * s * s6,
            s * s * s1 + c * c * s2 + 2 * c * s * s6,
            c * s * (s1 - s2) + (c * c - s * s) * s6,
        ])  # fmt: skip
    flow = T / (2 * np.pi * tube.radius**2)
    np.testing.assert_allclose(force, [0, 0, flow], atol=1e-9 * flow)


@pytest.mark.parametrize("ply", [CARBON_EPOXY, GLASS_EPOXY])
def test_failure_criteria_at_the_corners(ply):
    """Each strength by itself is failure, index 1, and a strength ratio of 1."""
    corners = np.array([
        [ply.tension_along, 0, 0], [-ply.compression_along, 0, 0], [0, ply.tension_across, 0],
        [0, -ply.compression_across, 0], [0, 0, ply.shear_strength], [0, 0, -ply.shear_strength],
    ])  # fmt: skip
    np.testing.assert_allclose(tsai_hill(corners, ply), 1, rtol=1e-12)
    np.testing.assert_allclose(tsai_wu(corners, ply), 1, rtol=1e-12)
    np.testing.assert_allclose(strength_ratio(corners, ply), 1, rtol=1e-12)


def test_tsai_wu_coefficients_of_t300_5208():
    """Tsai & Hahn (1980), table 7.2, per GPa: 0.444, 101.6, -3.36, 216.2, 0 and 20.93."""
    index = lambda *s: float(tsai_wu(np.array(s, dtype=float) * GPa, CARBON_EPOXY))  # noqa: E731
    even = lambda s: (index(*s) + index(*(-x for x in s))) / 2  # noqa: E731
    F11, F22, F66 = even((1, 0, 0)), even((0, 1, 0)), even((0, 0, 1))
    F12 = (even((1, 1, 0)) - F11 - F22) / 2
    F1, F2 = ((index(*s) - index(*(-x for x in s))) / 2 for s in ((1, 0, 0), (0, 1, 0)))
    np.testing.assert_allclose([F11, F22, F12, F66], [0.444, 101.6, -3.36, 216.2], rtol=2e-3)
    np.testing.assert_allclose([F1, F2], [0, 20.93], rtol=1e-3, atol=1e-9)


def test_strength_ratio_scales_to_failure():
    rng = np.random.default_rng(3)
    stress = rng.normal(size=(50, 3)) * [300e6, 20e6, 30e6]
    ratio = strength_ratio(stress, CARBON_EPOXY)
    np.testing.assert_allclose(tsai_wu(ratio[:, None] * stress, CARBON_EPOXY), 1, rtol=1e-10)


def test_forty_five_is_stiffest_in_torsion_and_zero_in_bending():
    at = np.radians([0, 15, 30, 45, 60, 90])
    tubes = [CompositeTube(outer=0.09, ply=CARBON_EPOXY, angles=(a, -a) * 4) for a in at]
    assert max(tubes, key=lambda t: t.torsional_stiffness).angles[0] == at[3]
    assert max(tubes, key=lambda t: float(t.critical_speed(1.5))).angles[0] == at[0]


def test_lightest_layup_beats_steel():
    """5 kN m: steel of 60 mm weighs 3.117 kg/m; carbon of 90 mm a good third, and holds."""
    demand = {"torque": 5000.0, "speed": 4000 * rpm, "length": 1.2, "speed_limit": 0.75}
    found = lightest(outer=90 * mm, **demand)
    assert max(found.strength_share, found.buckling_share, found.speed_share) <= 1
    assert found == judged(found.tube, **demand)
    assert found.mass_per_length < 0.6 * 3.117
    # One pair of plies fewer, of whatever kind, does not hold.
    for k in range(0, len(found.tube.angles), 2):
        angles = found.tube.angles[:k] + found.tube.angles[k + 2 :]
        less = judged(CompositeTube(outer=90 * mm, ply=CARBON_EPOXY, angles=angles), **demand)
        assert max(less.strength_share, less.buckling_share, less.speed_share) > 1


def test_impossible_demands_are_refused():
    with pytest.raises(DesignError, match="larger diameter"):
        lightest(torque=20e3, speed=500.0, length=2.5, outer=60 * mm)
    with pytest.raises(DesignError, match="no thin steel tube"):
        steel_wall(50e3, outer_radius=30 * mm, yield_strength=750 * MPa)
