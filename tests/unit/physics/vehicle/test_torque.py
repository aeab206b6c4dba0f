"""Torque and speed gear by gear."""

from dataclasses import replace

import numpy as np
import pytest

from cardan.core.errors import DesignError
from cardan.model.vehicle import Axle, Engine, Gearbox, Tyre
from cardan.physics.vehicle.torque import (
    gear_table,
    j3311_low_gear_torque,
    max_retarding_torque,
    retarding_torques,
    smaller_of_engine_and_slip_torque,
)

ENGINE = Engine(speed=(100.0, 150.0, 200.0), torque=(900.0, 1000.0, 800.0), brake_torque=300.0)
GEARBOX = Gearbox(ratios=(10.0, 2.0, 0.8), efficiency=0.9)


def test_every_gear_has_its_torque_and_speed():
    table = gear_table(ENGINE, GEARBOX)
    assert table.names == ("1", "2", "3")
    np.testing.assert_allclose(table.peak_torque, [9000, 1800, 720], rtol=1e-14)
    np.testing.assert_allclose(table.speed_range, [[10, 20], [50, 100], [125, 250]], rtol=1e-14)
    np.testing.assert_allclose(table.torque[0], [8100, 9000, 7200], rtol=1e-14)


def test_a_low_range_follows_the_high_one():
    table = gear_table(ENGINE, replace(GEARBOX, transfer_ratio=2.0))
    assert table.names == ("1", "2", "3", "low 1", "low 2", "low 3")
    np.testing.assert_allclose(table.ratios, [10, 2, 0.8, 20, 4, 1.6], rtol=1e-14)
    assert table.peak_torque.max() == pytest.approx(18000, rel=1e-14)
    assert table.speed.max() == pytest.approx(250, rel=1e-14)  # still that of the high range


def test_a_converter_multiplies_torque_but_not_speed():
    with_one = gear_table(ENGINE, replace(GEARBOX, converter_ratio=1.8))
    without = gear_table(ENGINE, GEARBOX)
    np.testing.assert_allclose(with_one.torque, 1.8 * without.torque, rtol=1e-14)
    np.testing.assert_array_equal(with_one.speed, without.speed)


def test_a_line_gets_its_share():
    line = gear_table(ENGINE, GEARBOX, torque_ratio=0.5, speed_ratio=1.25)
    np.testing.assert_allclose(line.peak_torque, [4500, 900, 360], rtol=1e-14)
    assert line.speed.max() == pytest.approx(312.5, rel=1e-14)
    # The ratio says what the speeds say.
    np.testing.assert_allclose(line.speed * line.ratios[:, None], [ENGINE.speed] * 3, rtol=1e-14)


def test_without_a_gearbox_the_line_turns_with_the_engine():
    table = gear_table(ENGINE)
    np.testing.assert_array_equal(table.torque, [ENGINE.torque])
    np.testing.assert_array_equal(table.speed, [ENGINE.speed])


def test_braking_gains_what_the_gears_lose():
    assert max_retarding_torque(ENGINE, GEARBOX) == pytest.approx(300 * 10 / 0.9, rel=1e-14)
    low = replace(GEARBOX, transfer_ratio=2.0)
    assert max_retarding_torque(ENGINE, low) == pytest.approx(300 * 20 / 0.9, rel=1e-14)


def test_the_smaller_torque_governs_and_unknown_ones_do_not():
    torque = smaller_of_engine_and_slip_torque(
        [5.0, 3.0, 5.0, np.nan, np.nan], [4.0, 4.0, np.nan, 4.0, np.nan]
    )
    np.testing.assert_array_equal(torque, [4.0, 3.0, 5.0, 4.0, np.nan])


def test_j3311_multiplies_all_its_factors():
    torque = j3311_low_gear_torque(
        1000, ratio=3, efficiency=0.8, stall_ratio=1.9, transfer_ratio=2, transfer_efficiency=0.95
    )
    assert torque == pytest.approx(1000 * 3 * 0.8 * 1.9 * 2 * 0.95, rel=1e-14)


@pytest.mark.parametrize(
    "part",
    [
        lambda: Gearbox(ratios=()),
        lambda: Gearbox(ratios=(5.0, 0.0)),
        lambda: Gearbox(ratios=(5.0,), efficiency=float("nan")),
        lambda: Axle(ratio=-4.0),
        lambda: Tyre(static_radius=0.5, friction=0.0),
        lambda: Engine(speed=(2.0, 1.0), torque=(1.0, 1.0)),
    ],
)
def test_impossible_parts_are_refused(part):
    with pytest.raises(DesignError):
        part()


def test_a_low_range_multiplies_what_a_retarder_ahead_of_it_holds():
    gearbox = Gearbox(
        ratios=(6.0, 1.0), efficiency=0.9, retarder_torque=800.0, transfer_ratio=1.5
    )  # fmt: skip
    engine = replace(ENGINE, brake_torque=250.0)
    wanted = [250 * i * low / 0.9 + 800 * low for low in (1.0, 1.5) for i in (6.0, 1.0)]
    np.testing.assert_allclose(retarding_torques(engine, gearbox), wanted, rtol=1e-14)


@pytest.mark.parametrize(
    ("governed", "speeds", "torques"),
    [
        (None, (100, 200, 300), (500, 600, 400)),
        (360, (100, 200, 300, 360), (500, 600, 400, 0)),  # it droops straight to nothing
        (250, (100, 200, 250, 250), (500, 600, 500, 500)),  # what lies beyond is not reached
        (150, (100, 150, 150, 150), (500, 550, 550, 550)),
        (50, (50, 50, 50, 50), (500, 500, 500, 500)),
    ],
)
def test_full_load_ends_at_governed_speed(governed, speeds, torques):
    engine = Engine(speed=(100, 200, 300), torque=(500, 600, 400), governed=governed)
    assert np.array(engine.full_load[0]) == pytest.approx(np.array(speeds))
    assert np.array(engine.full_load[1]) == pytest.approx(np.array(torques))
    assert engine.peak_torque == max(torques)
    found = gear_table(engine, Gearbox(ratios=(4.0, 1.0)))
    assert found.top_speed == max(speeds)
    assert found.peak_torque == pytest.approx([4 * max(torques), max(torques)])
