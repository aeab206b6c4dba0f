"""Rosettes against the closed forms of Vishay Micro-Measurements, Tech Note TN-515."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cardan.core.units import GPa, MPa, deg
from cardan.physics.fatigue.strain_gauges import (
    DELTA_ROSETTE_ANGLES,
    RECTANGULAR_ROSETTE_ANGLES,
    PlaneStress,
    abs_max_principal,
    dominant_stress_direction,
    plane_stress_of_rosette,
    rosette_gauge,
    signed_mises,
    single_gauge,
)

E, NU = 206 * GPa, 0.3


def strains(stress, angles):
    """What grids at these angles feel, by Hooke and Mohr."""
    ex, ey = (stress.x - NU * stress.y) / E, (stress.y - NU * stress.x) / E
    g = stress.xy * 2 * (1 + NU) / E
    a = np.array(angles)
    return ex * np.cos(a) ** 2 + ey * np.sin(a) ** 2 + g * np.sin(a) * np.cos(a)


def test_rectangular_rosette_matches_closed_form():
    """ε1,2 = (εa+εc)/2 ± √½ √((εa-εb)² + (εb-εc)²), tan 2φ = (2εb-εa-εc)/(εa-εc)."""
    a, b, c = 850e-6, 420e-6, -310e-6
    found = plane_stress_of_rosette([a, b, c], modulus=E, poisson=NU)
    middle, radius = (a + c) / 2, np.sqrt(0.5 * ((a - b) ** 2 + (b - c) ** 2))
    e1, e2 = middle + radius, middle - radius
    plane = E / (1 - NU**2)
    expected = [plane * (e1 + NU * e2), plane * (e2 + NU * e1)]
    np.testing.assert_allclose(found.principal, expected, rtol=1e-12)
    assert found.direction == pytest.approx(np.arctan2(2 * b - a - c, a - c) / 2, rel=1e-12)


def test_delta_rosette_matches_closed_form():
    """ε1,2 = (εa+εb+εc)/3 ± (√2/3) √((εa-εb)² + (εb-εc)² + (εc-εa)²)."""
    a, b, c = 520e-6, -140e-6, 260e-6
    found = plane_stress_of_rosette([a, b, c], angles=DELTA_ROSETTE_ANGLES, modulus=E, poisson=NU)
    middle = (a + b + c) / 3
    radius = np.sqrt(2) / 3 * np.sqrt((a - b) ** 2 + (b - c) ** 2 + (c - a) ** 2)
    e1, e2 = middle + radius, middle - radius
    plane = E / (1 - NU**2)
    np.testing.assert_allclose(
        found.principal, [plane * (e1 + NU * e2), plane * (e2 + NU * e1)], rtol=1e-12
    )


@given(
    first=st.floats(-300, 300),
    second=st.floats(-300, 300),
    turned=st.floats(-89, 89),
    angles=st.sampled_from(
        [RECTANGULAR_ROSETTE_ANGLES, DELTA_ROSETTE_ANGLES, (-0.3, 0.4, 1.2), (0.0, 0.5, 1.0, 2.0)]
    ),
)
def test_known_stress_is_recovered(first, second, turned, angles):
    high, low = max(first, second) * MPa, min(first, second) * MPa
    c, s = np.cos(turned * deg), np.sin(turned * deg)
    stress = PlaneStress(
        np.asarray(high * c**2 + low * s**2),
        np.asarray(high * s**2 + low * c**2),
        np.asarray((high - low) * s * c),
    )
    found = plane_stress_of_rosette(strains(stress, angles), angles=angles, modulus=E, poisson=NU)
    np.testing.assert_allclose(found.principal, [high, low], atol=1e-6 * MPa)
    if high - low > 1 * MPa:
        assert abs((found.direction - turned * deg + np.pi / 2) % np.pi - np.pi / 2) < 1e-9
    assert found.normal(found.direction) == pytest.approx(high, abs=1e-3)
    assert found.mises == pytest.approx(np.sqrt(high**2 - high * low + low**2), abs=1e-3)


def test_pure_shear_and_uniaxial_stress_have_exact_biaxiality():
    shear = PlaneStress(np.zeros(1), np.zeros(1), np.full(1, 50.0))
    assert shear.biaxiality == pytest.approx(-1)
    assert shear.direction == pytest.approx(np.pi / 4)
    pull = PlaneStress(np.full(1, -80.0), np.zeros(1), np.zeros(1))
    assert pull.biaxiality == 0
    assert signed_mises(pull) == abs_max_principal(pull) == -80


def test_gauges_convert_channels_to_stress():
    assert single_gauge("S1", "e1", factor=206e9 * 1e-6).stress(np.array([[100.0]])) == 20.6 * MPa
    gauge = rosette_gauge("R1", ("a", "b", "c"), measure=abs_max_principal)
    pull = strains(
        PlaneStress(np.asarray(90 * MPa), np.asarray(0.0), np.asarray(0.0)),
        RECTANGULAR_ROSETTE_ANGLES,
    )
    assert gauge.stress(pull[:, None] / 1e-6) == pytest.approx(90 * MPa, rel=1e-9)


@pytest.mark.parametrize(
    ("torque", "axial", "low", "high"),
    [
        (lambda w: 60 * np.sin(w), 0.0, -104, 104),
        (lambda w: 60 * np.sin(w), 3.0, -104, 104),
        (lambda w: 60 * np.sin(w), 20.0, -106, 106),
        (lambda w: 60 + 10 * np.sin(w), 0.0, 86.6, 121.2),
        (lambda w: -60 + 10 * np.sin(w), 0.0, 86.6, 121.2),
    ],
)
def test_signed_mises_of_shear_has_sign_of_shear(torque, axial, low, high):
    """Derived: sqrt(3) of a shaft's shear, as it swings; noise or little beside turned its sign.

    60 MPa to and fro with 3 MPa along the shaft had 0.05 of its damage, none along it 70 times.
    """
    w, noise = np.arange(40_000) / 50, np.random.default_rng(0).normal(size=(2, 40_000))
    stress = PlaneStress(axial * MPa + 0.1 * MPa * noise[0], 0.1 * MPa * noise[1], torque(w) * MPa)
    # A logger's -9999 um/m in each grid, one sample in twenty.
    lost = np.arange(40_000) % 20 == 0
    each = (-2943 * MPa, stress.x), (-2943 * MPa, stress.y), (0.0, stress.xy)
    spoiled = PlaneStress(*(np.where(lost, none, x) for none, x in each))
    found = signed_mises(stress, along=dominant_stress_direction(spoiled)) / MPa
    assert found.min() == pytest.approx(low, abs=1)
    assert found.max() == pytest.approx(high, abs=1)
    # From one sample to the next it turns its sign where it is small.
    assert np.abs(np.diff(found)).max() < 2.5 + 2 * axial + 1


def test_signed_mises_keeps_sign_of_tension_and_compression():
    """A bar, whichever way it stands in the rosette."""
    w = np.arange(5000) / 50
    for angle in np.radians([0, 30, 77, 135]):
        c, s = np.cos(angle), np.sin(angle)
        size = (-80 + 30 * np.sin(w)) * MPa
        stress = PlaneStress(size * c * c, size * s * s, size * s * c)
        found = signed_mises(stress, along=dominant_stress_direction(stress))
        np.testing.assert_allclose(found, size, rtol=1e-9)


def test_rosette_with_repeated_grid_direction_is_rejected():
    with pytest.raises(ValueError, match="three or more different"):
        plane_stress_of_rosette([1, 2, 3], angles=(0.0, np.pi, 0.5))
