"""A line follows its axle."""

import numpy as np
import pytest

from cardan.core.units import deg, mm
from cardan.model.layout import layout_from_slopes
from cardan.model.parts import CentreBearing, Line, Shaft
from cardan.physics.vehicle.axle_motion import layout_after_axle_motion

BEARING = CentreBearing(from_rear_joint=0.2)
LINE = Line(shafts=(Shaft(length=1.2, centre_bearing=BEARING), Shaft(length=1.5)))
LAYOUT = layout_from_slopes(side=[0, 0, 0, 0], top=[0, 0, 0, 0], lengths=[1.2, 1.5])


def test_forward_facing_pinion_rises_in_windup():
    """A 400 mm arm: its joint rises by 400 sin 5 deg, and the pinion slopes 5 deg more down."""
    new = layout_after_axle_motion(LAYOUT, LINE, pinion_pitch=5 * deg, pinion_arm=(-400 * mm, 0, 0))
    rise, back = 400 * mm * np.sin(5 * deg), 400 * mm * (1 - np.cos(5 * deg))
    np.testing.assert_allclose(new.points[-1] - LAYOUT.points[-1], [back, 0, rise], atol=1e-15)
    assert new.side[-1] == pytest.approx(5 * deg, rel=1e-13)


def test_raised_centre_bearing_tilts_first_propshaft():
    """Raised 20 mm at 1 m: the shaft rises 1:50 and its rear joint by 1.2/1 of 20 mm."""
    new = layout_after_axle_motion(LAYOUT, LINE, bearing_shift=[[0, 0, 20 * mm]])
    slope = np.arctan(0.02)
    assert new.side[1] == pytest.approx(-slope, rel=1e-13)
    np.testing.assert_allclose(
        new.points[1], [1.2 * np.cos(slope), 0, 1.2 * np.sin(slope)], rtol=1e-13
    )
    np.testing.assert_array_equal(new.points[-1], LAYOUT.points[-1])


def test_last_propshaft_length_follows_axle_travel():
    new = layout_after_axle_motion(LAYOUT, LINE, last_shift=(10 * mm, 0, 150 * mm))
    assert new.lengths[-1] == pytest.approx(np.hypot(1.51, 0.15), rel=1e-14)
