"""Quantities as they are declared."""

from dataclasses import replace

import pytest

from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.units import UNITS


@pytest.mark.parametrize("unit", ["kJ", "", "deg/min "])
def test_unknown_unit_is_refused_where_quantity_is_declared(unit):
    """It was `cardan itself is at fault: KeyError`, wherever the quantity was printed."""
    assert unit not in UNITS
    with pytest.raises(ValueError, match=rf"^joint_angle: .* has no unit {unit!r}$"):
        replace(QUANTITIES["joint_angle"], unit=unit)
