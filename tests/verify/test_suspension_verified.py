"""Springs against Souza (2014), table 1 and figure 13, and leaf springs against SAE HS-788."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from cardan.core.units import N, g, inch, mm
from cardan.model.vehicle import Spring, Suspension
from cardan.physics.vehicle.suspension import (
    deflection_in_state,
    natural_frequency,
    spring_deflection,
    spring_load,
    spring_table_rates,
)

LOADS = {"free": 0, "contact": 11562, "empty": 12749, "normal": 26233, "maximum": 43345}
DEFLECTIONS = {"free": 0, "contact": 96, "empty": 105, "normal": 185, "maximum": 273}
SPRING = Spring(
    load=tuple(v * N for v in LOADS.values()),
    deflection=tuple(v * mm for v in DEFLECTIONS.values()),
    stated_rates=(120.6 * N / mm, 192.2 * N / mm),
)


def test_spring_table_reproduces_its_points():
    for name, load in LOADS.items():
        assert spring_load(SPRING, DEFLECTIONS[name] * mm) == pytest.approx(load, abs=1e-9)
        assert spring_deflection(SPRING, load) / mm == pytest.approx(DEFLECTIONS[name], abs=1e-9)


def test_stated_rates_differ_from_table_slopes():
    """Stated 120.6 and 192.2 N/mm; the table's first and last slopes are 120.4 and 194.5."""
    rates = spring_table_rates(SPRING) / (N / mm)
    assert rates[0].round(1) == 120.4
    assert rates[-1].round(1) == 194.5
    np.testing.assert_allclose(
        [120.6 / rates[0] - 1, 192.2 / rates[-1] - 1], [0.0013, -0.0116], atol=5e-5
    )


def test_deflections_of_named_states_match_figure_13():
    """Two springs, 800 kg of axle and wheels; loads on the axle put together from table 1."""
    suspension = Suspension(spring=SPRING, unsprung_mass=800.0)

    def at(state, spring_load=np.nan):
        return deflection_in_state(suspension, state, axle_load=2 * spring_load + 800 * g) / mm

    assert at("empty", 12749) == pytest.approx(105, abs=1e-9)
    assert at("gvw", 26233) == pytest.approx(185, abs=1e-9)
    assert at("windup", 26233) == pytest.approx(185, abs=1e-9)
    assert at("jounce") == pytest.approx(273, abs=1e-9)
    assert at("rebound") * mm == pytest.approx(-1 * inch, abs=1e-12)
    # The axle hangs on two springs of 120.4375 N/mm.
    assert at("full rebound") == pytest.approx(-800 * g / (2 * 11562 / 96), rel=1e-12)


def test_natural_frequency_matches_integrated_motion():
    """A mass let go 0.5 mm off balance on the table's spring, its motion integrated.

    At 20 kN all within one straight line of the table; integration to 1e-10.
    """
    load = 20e3
    start = float(spring_deflection(SPRING, load))

    def fall(_, y):
        return [y[1], g - float(spring_load(SPRING, y[0])) * g / load]

    def top(_, y):
        return y[1]

    top.direction = -1  # at rest at the far end, half a turn away from the second crossing
    found = solve_ivp(
        fall, (0, 3), [start - 0.5 * mm, 0], events=top, rtol=1e-11, atol=1e-14, max_step=0.02
    )
    period = np.diff(found.t_events[0][-2:])[0]
    assert natural_frequency(SPRING, load) == pytest.approx(1 / period, rel=1e-8)
