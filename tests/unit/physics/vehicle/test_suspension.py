"""Where the suspension puts the axle."""

from dataclasses import replace

import numpy as np
import pytest

from cardan.core.errors import DesignError
from cardan.core.units import deg, g, inch, kNm, mm
from cardan.model.vehicle import Linkage, Spring, Suspension
from cardan.physics.vehicle.suspension import (
    axle_path,
    axle_windup,
    deflection_in_state,
    spring_deflection,
    spring_load,
    spring_rate,
)

SPRING = Spring(load=(0.0, 10e3, 30e3), deflection=(0.0, 100 * mm, 200 * mm))
SUSPENSION = Suspension(spring=SPRING, unsprung_mass=500.0)


def test_a_table_goes_on_with_its_outer_slopes():
    assert spring_load(SPRING, -50 * mm) == pytest.approx(-5e3, rel=1e-12)
    assert spring_load(SPRING, 250 * mm) == pytest.approx(40e3, rel=1e-12)
    assert spring_deflection(SPRING, -5e3) == pytest.approx(-50 * mm, rel=1e-12)


def test_the_rate_is_the_slope_and_even_across_a_corner():
    rate = spring_rate(SPRING, np.array([50, 100, 150]) * mm)
    np.testing.assert_allclose(rate, [100e3, 150e3, 200e3], rtol=1e-9)
    near = spring_rate(SPRING, np.array([100 - 1e-6, 100 + 1e-6]) * mm)
    assert np.ptp(near) < 1e-3 * near[0]


def test_the_axle_rises_from_full_rebound_to_jounce():
    states = ["full rebound", "rebound", "curb", "empty", "gvw", "overload", "jounce"]
    spring_loads = [np.nan, np.nan, 4e3, 8e3, 20e3, 22e3, np.nan]
    found = [
        deflection_in_state(SUSPENSION, s, axle_load=2 * load + 500 * g)
        for s, load in zip(states, spring_loads, strict=True)
    ]
    assert np.all(np.diff(found) >= 0)
    assert found[2:6] == pytest.approx([40 * mm, 80 * mm, 150 * mm, 160 * mm], rel=1e-12)


def test_a_light_axle_hangs_as_low_as_rebound():
    """Without its mass nothing would pull the spring; the inch of rebound still counts."""
    light = replace(SUSPENSION, unsprung_mass=0.0)
    assert (
        deflection_in_state(light, "full rebound") == deflection_in_state(light, "rebound") == -inch
    )


def test_strap_and_stop_come_first():
    held = replace(SUSPENSION, full_rebound_deflection=-10 * mm, jounce_deflection=180 * mm)
    assert deflection_in_state(held, "full rebound") == -10 * mm
    assert deflection_in_state(held, "rebound") == -10 * mm  # the strap does not let it further
    assert deflection_in_state(held, "jounce") == 180 * mm


def test_a_table_that_starts_preloaded_has_its_free_length_below():
    """An air spring or helper given from 10 kN on is free where its first line ends."""
    late = Suspension(spring=Spring(load=(10e3, 30e3), deflection=(0.0, 100 * mm)))
    assert deflection_in_state(late, "rebound") == pytest.approx(-50 * mm - inch, rel=1e-12)


def test_a_load_that_is_not_known_is_asked_for():
    with pytest.raises(DesignError, match="gvw needs the axle's load"):
        deflection_in_state(SUSPENSION, "gvw")


def test_a_link_swings_about_its_pivot():
    link = Linkage(radius=0.6, angle=20 * deg, pitch_rate=0.5)
    travel = np.linspace(-0.1, 0.15, 11)
    dx, pitch = axle_path(link, travel)
    pivot = np.array([-0.6 * np.cos(20 * deg), 0.6 * np.sin(20 * deg)])  # from the axle
    axle = np.stack([dx, travel], axis=-1)
    np.testing.assert_allclose(np.linalg.norm(axle - pivot, axis=-1), 0.6, rtol=1e-14)
    np.testing.assert_allclose(pitch, 0.5 * travel, rtol=1e-14)


def test_a_pivot_above_the_axle_pushes_it_back_as_it_rises():
    dx, _ = axle_path(Linkage(radius=0.6, angle=10 * deg), np.array([-0.05, 0.05]))
    assert dx[0] < 0 < dx[1]


def test_a_table_from_cad_counts_from_the_reference():
    table = Linkage(travel=(-0.1, 0.0, 0.1), dx=(0.004, 0.005, 0.003), pitch=(-0.02, 0.0, 0.01))
    dx, pitch = axle_path(table, np.array([-0.2, -0.05, 0.0, 0.2]))
    np.testing.assert_allclose(dx, [-0.002, -0.0005, 0.0, -0.004], atol=1e-15)
    np.testing.assert_allclose(pitch, [-0.04, -0.01, 0.0, 0.02], atol=1e-15)
    only_pitch = Linkage(travel=(-0.1, 0.1), pitch=(-0.02, 0.02))
    dx, pitch = axle_path(only_pitch, 0.05)
    assert (dx, pitch) == (0.0, pytest.approx(0.01, rel=1e-14))


def test_no_linkage_means_straight_up():
    dx, pitch = axle_path(Linkage(), np.array([-0.1, 0.1]))
    assert not dx.any()
    assert not pitch.any()


def test_a_link_cannot_stretch():
    with pytest.raises(DesignError, match="cannot follow an axle travel of 700 mm"):
        axle_path(Linkage(radius=0.6), np.array([0.1, 0.7]))


def test_the_ground_turns_the_axle_the_way_windup_says():
    """Driving forward the ground pushes the tyre forward: -x, a radius below the centre."""
    moment = np.cross([0, 0, -0.5], [-10e3, 0, 0])
    np.testing.assert_array_equal(moment, [0, 5e3, 0])
    assert axle_windup(moment[1], stiffness=20 * kNm / deg) / deg == pytest.approx(0.25, rel=1e-12)


@pytest.mark.parametrize(
    "part",
    [
        lambda: Linkage(radius=0.0),
        lambda: Linkage(travel=(0.0,), dx=(0.0,)),
        lambda: Linkage(travel=(0.0, 0.1), dx=(0.0,)),
        lambda: Linkage(dx=(0.0, 0.1)),
        lambda: Linkage(travel=(0.1, 0.0), dx=(0.0, 0.1)),
        lambda: Suspension(spring=SPRING, unsprung_mass=-1.0),
        lambda: Suspension(spring=SPRING, windup_stiffness=0.0),
        lambda: Suspension(spring=SPRING, reference="windup"),
        lambda: Suspension(spring=SPRING, reference="laden"),
    ],
)
def test_impossible_suspensions_are_refused(part):
    with pytest.raises(DesignError):
        part()
