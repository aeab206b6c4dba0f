"""Every unit a key may end in, against NIST SP 811 (2008), appendix B, as printed there.

Printed to seven digits unless exact: half a unit of the seventh is 5e-7 of a number that
starts with 1.
"""

import math

import pytest

from cardan.core.units import UNITS

PRINTED = {
    "1": 1, "percent": 0.01, "m": 1, "mm": 1e-3, "in": 2.54e-2, "ft": 3.048e-1,
    "kg": 1, "lb": 4.535924e-1, "t": 1e3, "kgm2": 1,
    "N": 1, "kN": 1e3, "lbf": 4.448222, "kgf": 9.80665,
    "Nm": 1, "kNm": 1e3, "lbft": 1.355818,
    "N_m": 1, "N_mm": 1e3, "kN_m": 1e3, "lbf_in": 1.751268e2,
    "Nm_deg": 57.29578, "kNm_deg": 5.729578e4, "Nm_rad": 1, "kNm_rad": 1e3, "Nms_rad": 1, "l": 1e-3,
    "kW": 1e3,
    "Pa": 1, "MPa": 1e6, "GPa": 1e9, "psi": 6.894757e3, "kg_m3": 1,
    "rad": 1, "deg": 1.745329e-2, "deg_mm": 17.45329, "gmm": 1e-6,
    "rpm": 1.047198e-1, "rad_s": 1, "rad_s2": 1, "per_s": 1,
    # rpm times degrees; 1.047198e-1 * 1.745329e-2, to six digits.
    "deg_min": 1.827705e-3,
    "Hz": 1, "h": 3.6e3, "s": 1, "km_h": 2.777778e-1,
}  # fmt: skip


@pytest.mark.parametrize("unit", UNITS)
def test_unit_matches_nist_sp_811(unit):
    assert UNITS[unit] == pytest.approx(PRINTED[unit], rel=6e-7)


def test_rpm_and_degree_match_full_circle():
    assert 60 * UNITS["rpm"] == pytest.approx(360 * UNITS["deg"], rel=1e-15)
    assert 360 * UNITS["deg"] == pytest.approx(2 * math.pi, rel=1e-15)
