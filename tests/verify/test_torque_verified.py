"""Torques against Dana Spicer J3311-1, Driveshaft torque, and Souza (2014), eq. 1 to 3."""

import numpy as np
import pytest

from cardan.core.units import inch, lbf, lbft, rpm
from cardan.model.vehicle import Engine, Gearbox
from cardan.physics.vehicle.torque import (
    gear_table,
    j3311_low_gear_torque,
    j3311_wheel_slip_torque,
    slip_torque_at_friction,
)


def test_low_gear_torque_matches_j3311():
    """Printed to the whole lb-ft."""
    torque = j3311_low_gear_torque(1567.5 * lbft, ratio=10.96, efficiency=0.85)
    assert torque / lbft == pytest.approx(14603, abs=0.5)


def test_wheel_slip_torque_matches_j3311():
    """Printed to the whole lb-ft; 11.4 is 12 inches to the foot times 0.95."""
    torque = j3311_wheel_slip_torque(40000 * lbf, radius=19.5 * inch, ratio=3.73)
    assert torque / lbft == pytest.approx(13024, abs=0.5)
    assert torque / lbft == pytest.approx(0.71 * 40000 * 19.5 / (11.4 * 3.73), rel=1e-12)


def test_general_torque_equations_match_j3311():
    """J3311 is Souza's equations 1 and 3 with its own efficiencies and friction."""
    engine = Engine(speed=(1200 * rpm,), torque=(1567.5 * lbft,))
    table = gear_table(engine, Gearbox(ratios=(10.96, 1.0), efficiency=0.85))
    assert table.peak_torque[0] / lbft == pytest.approx(14603, abs=0.5)
    load, axle = 40000 * lbf, {"friction": 0.71, "ratio": 3.73, "efficiency": 0.95}
    slip = slip_torque_at_friction(load, radius=19.5 * inch, **axle)
    assert slip / lbft == pytest.approx(13024, abs=0.5)


def test_slip_torque_satisfies_work_balance():
    """One turn of the pinion: torque times 2 pi pays the friction's way and the losses."""
    load, friction, radius, ratio, efficiency = 98e3, 0.75, 0.47, 4.3, 0.96
    torque = slip_torque_at_friction(
        load, friction=friction, radius=radius, ratio=ratio, efficiency=efficiency
    )
    way = 2 * np.pi * radius / ratio
    assert torque * 2 * np.pi * efficiency == pytest.approx(friction * load * way, rel=1e-12)
