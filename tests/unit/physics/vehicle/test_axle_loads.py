"""Which axles carry what."""

from dataclasses import replace

import numpy as np
import pytest

from cardan.core.errors import DesignError
from cardan.core.units import g
from cardan.model.vehicle import AuxiliaryAxle, LoadState, Vehicle
from cardan.physics.vehicle.axle_loads import (
    axle_loads_at_wheel_slip,
    driveline_axle_loads,
    driven_axle_count,
    load_of_each_axle,
    static_axle_loads,
)

LADEN = LoadState(name="gvw", mass=20e3, cg_behind_front=3.5, cg_height=1.4)


@pytest.mark.parametrize(
    ("drive", "front", "rear", "driven_front", "driven_rear"),
    [
        ("4x2", 1, 1, 0, 1),
        ("4x4", 1, 1, 1, 1),
        ("6x2", 1, 2, 0, 1),
        ("6x4", 1, 2, 0, 2),
        ("6x6", 1, 2, 1, 2),
        ("8x2", 2, 2, 0, 1),
        ("8x4", 2, 2, 0, 2),
        ("8x8", 2, 2, 2, 2),
    ],
)
def test_drive_formula_gives_axle_and_driven_axle_counts(
    drive, front, rear, driven_front, driven_rear
):
    vehicle = Vehicle(drive=drive, wheelbase=5.0)
    assert (vehicle.front_group, vehicle.rear_group) == (front, rear)
    assert driven_axle_count(vehicle, drives="front") == driven_front
    assert driven_axle_count(vehicle, drives="rear") == driven_rear
    points, driven = map(int, drive.split("x"))
    assert 2 * driven_axle_count(vehicle, drives="all") == driven
    assert len(load_of_each_axle(static_axle_loads(vehicle, LADEN), vehicle)) == points // 2


def test_front_driven_flag_overrides_drive_formula():
    van = Vehicle(drive="4x2", wheelbase=3.5, front_driven=True)
    assert (van.driven_front, van.driven_rear, van.rear_share) == (1, 0, 0.0)
    part_time = Vehicle(drive="4x4", wheelbase=3.5, front_driven=False)
    assert (part_time.driven_front, part_time.driven_rear) == (0, 1)


def test_single_front_axle_with_rear_tridem_is_supported():
    tridem = Vehicle(drive="8x4", wheelbase=5.0, front_axles=1)
    assert (tridem.rear_group, tridem.driven_rear) == (3, 2)
    assert tridem.rear_share == pytest.approx(2 / 3, rel=1e-15)


def test_mass_and_axle_loads_inputs_are_equivalent():
    vehicle = Vehicle(drive="4x2", wheelbase=5.0)
    by_mass = static_axle_loads(vehicle, LADEN)
    front, rear = float(by_mass.front), float(by_mass.rear)
    for load in (
        LoadState(name="gvw", front_load=front, rear_load=rear),
        LoadState(name="gvw", mass=20e3, rear_load=rear),
        LoadState(name="gvw", mass=20e3, front_load=front),
    ):
        for grade in (0.0, 0.1):
            found, same = (
                static_axle_loads(vehicle, load, grade=grade),
                static_axle_loads(vehicle, LADEN, grade=grade),
            )
            assert found.front == pytest.approx(same.front, rel=1e-12)
            assert found.rear == pytest.approx(same.rear, rel=1e-12)


def test_tag_axle_unloads_other_axles_by_moment_balance():
    tag = AuxiliaryAxle(behind_front=6.25, load=40e3)
    vehicle = Vehicle(drive="6x2", wheelbase=5.0, auxiliary=(tag,))
    found = static_axle_loads(vehicle, LADEN)
    # Moments about the front axle, by hand.
    assert found.rear == pytest.approx((20e3 * g * 3.5 - 40e3 * 6.25) / 5.0, rel=1e-14)
    assert found.total == pytest.approx(20e3 * g, rel=1e-14)
    lifted = static_axle_loads(vehicle, replace(LADEN, auxiliary_lifted=True))
    assert lifted.rear == pytest.approx(20e3 * g * 3.5 / 5.0, rel=1e-14)
    assert lifted.auxiliary.size == 0


def test_lifted_axle_carries_no_load():
    short = Vehicle(drive="4x2", wheelbase=1.0)
    load = LoadState(name="gvw", mass=20e3, cg_behind_front=0.8, cg_height=1.4)
    for friction in (0.3, 0.8):  # the closed form says more than the weight; then less than none
        found = axle_loads_at_wheel_slip(
            static_axle_loads(short, load), friction=friction, cg_height=1.4, wheelbase=1.0
        )
        assert found.front == 0
        assert found.rear == pytest.approx(20e3 * g, rel=1e-14)


def test_traction_loads_rear_axle_and_braking_unloads_it():
    vehicle = Vehicle(drive="6x4", wheelbase=5.0, loads=(LADEN,))
    found = driveline_axle_loads(vehicle, LADEN, friction=0.7)
    assert found.braked * 2 < found.coast < found.rest < found.traction
    assert found.axle * 2 == pytest.approx(found.rest, rel=1e-14)


@pytest.mark.parametrize(
    ("drive", "drives", "axles", "share"),
    [("4x2", "rear", 1, 1.0), ("6x4", "rear", 2, 1.0), ("6x2", "rear", 1, 0.5),
     ("6x6", "front", 1, -1.0), ("8x8", "front", 2, -1.0), ("6x6", "all", 3, 0.0)],
)  # fmt: skip
def test_each_newton_of_pull_moves_height_over_wheelbase_to_the_rear(drive, drives, axles, share):
    """Moments about the front axle: F h = L ΔN, which the driven axles of a group share."""
    vehicle = Vehicle(drive=drive, wheelbase=5.0)
    found = driveline_axle_loads(vehicle, LADEN, drives=drives).transfer_per_force
    assert found == pytest.approx(share * 1.4 / 5.0 / axles, abs=1e-15)


def test_auxiliary_axle_braking_unloads_rear_axle():
    """Every wheel holds 0.7 of its load: 0.7 W h / L leaves the rear, W the whole weight."""
    tag = AuxiliaryAxle(behind_front=6.25, load=40e3)
    vehicle = Vehicle(drive="6x2", wheelbase=5.0, auxiliary=(tag,))
    rear = static_axle_loads(vehicle, LADEN).rear - 0.7 * 20e3 * g * 1.4 / 5.0
    found = driveline_axle_loads(vehicle, LADEN, friction=0.7)
    assert found.braked == pytest.approx(rear, rel=1e-14)


def test_no_load_transfer_without_cg_height():
    vehicle = Vehicle(drive="4x2", wheelbase=5.0)
    found = driveline_axle_loads(vehicle, replace(LADEN, cg_height=None), friction=0.8)
    assert found.traction == found.coast == found.rest


def test_overload_factor_scales_every_axle_load():
    vehicle = Vehicle(drive="6x2", wheelbase=5.0)
    one, more = (driveline_axle_loads(vehicle, LADEN, friction=0.8, times=t) for t in (1.0, 1.1))
    for name in ("axle", "rest", "traction", "coast", "braked"):
        assert getattr(more, name) == pytest.approx(1.1 * getattr(one, name), rel=1e-14)


def test_line_to_undriven_axle_is_rejected():
    with pytest.raises(DesignError, match="drives no front axle"):
        driveline_axle_loads(Vehicle(drive="4x2", wheelbase=5.0), LADEN, drives="front")


@pytest.mark.parametrize(
    "part",
    [
        lambda: LoadState(name="gvw"),
        lambda: LoadState(name="gvw", mass=20e3),
        lambda: LoadState(name="gvw", cg_behind_front=3.0),
        lambda: LoadState(name="gvw", mass=20e3, front_load=1e5, rear_load=1e5),
        lambda: LoadState(name="gvw", mass=20e3, rear_load=1e5, cg_behind_front=3.0),
        lambda: LoadState(name="gvw", mass=np.nan, cg_behind_front=3.0),
        lambda: Vehicle(drive="4x2", wheelbase=0.0),
        lambda: Vehicle(drive="6x2", wheelbase=5.0, driven_share=1.2),
        lambda: Vehicle(drive="6x4", wheelbase=5.0, driven_share=0.7),
        lambda: Vehicle(
            drive="4x2", wheelbase=5.0, auxiliary=(AuxiliaryAxle(behind_front=6, load=1e4),)
        ),
    ],
)
def test_impossible_vehicle_is_rejected(part):
    with pytest.raises(DesignError):
        part()


def test_bogie_load_is_split_by_driven_share():
    vehicle = Vehicle(drive="6x2", wheelbase=5.0, driven_share=0.6)
    loads = static_axle_loads(vehicle, LADEN)
    np.testing.assert_allclose(
        load_of_each_axle(loads, vehicle),
        [loads.front, 0.6 * loads.rear, 0.4 * loads.rear],
        rtol=1e-14,
    )
    assert driveline_axle_loads(vehicle, LADEN).axle == pytest.approx(0.6 * loads.rear, rel=1e-14)


def test_grade_reduces_traction_but_not_static_axle_load():
    """The springs' state is found on the level; on the grade the tyres hold cos of it."""
    flat = Vehicle(drive="4x2", wheelbase=5.0)
    one, two = (
        driveline_axle_loads(v, LADEN, friction=0.8) for v in (flat, replace(flat, grade=0.2))
    )
    assert two.axle == one.axle
    assert two.traction == pytest.approx(one.traction * np.cos(0.2), rel=1e-14)


@pytest.mark.parametrize(
    ("load", "behind", "said"),
    [(6e3 * g, 6.15, "the rear axles would bear"), (12e3 * g, 0.1, "the front axles would bear")],
)
def test_negative_axle_load_is_rejected(load, behind, said):
    """By moments: 9 t at 2.2 m of 4.8 and 6 t at 6.15 leave the rear 9·2.2 − 6·6.15 < 0."""
    lifted = AuxiliaryAxle(load=load, behind_front=behind)
    vehicle = Vehicle(drive="6x2", wheelbase=4.8, auxiliary=(lifted,))
    light = LoadState(name="empty", mass=9e3, cg_behind_front=2.2)
    rear = (9e3 * g * 2.2 - load * behind) / 4.8
    borne = rear if "rear" in said else 9e3 * g - load - rear
    with pytest.raises(DesignError, match=rf"{said} {borne:.0f} N"):
        static_axle_loads(vehicle, light)
    assert static_axle_loads(vehicle, replace(light, auxiliary_lifted=True)).rear > 0
