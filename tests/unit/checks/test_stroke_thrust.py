"""The spline's thrust as an application has it: what its states say of the stroke, and what not."""

import re

import numpy as np
import pytest
from repository import EXAMPLES

from cardan.application import overrides, reader
from cardan.approval.applied_adjustments import line_response_in_states
from cardan.approval.driveline_study import unevaluated_line_checks
from cardan.checks import stroke_thrust
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.checks.mount_loads import MountLoads
from cardan.checks.quantities.registry import QUANTITIES
from cardan.physics.vehicle.state_demand import (
    axle_motion_under_torque,
    demand_at_axle_motion,
    line_state_demand,
    resolve_line_references,
)

COLLECTOR = (EXAMPLES / "refuse-collector-6x2.yaml").read_text(encoding="utf-8")
GVW = 2
FORCES = {"centre_bearing_static", "centre_bearing_peak", "centre_bearing_travel"}
FRICTION = "driveline.shafts[3].spline.friction"


def line(text: str = COLLECTOR, **changes: object) -> LineResponse:
    application = reader.loads(text)
    if changes:
        application = overrides.change(application, changes)
    return compute_line_response(
        application, line_state_demand(resolve_line_references(application, application.lines[0]))
    )


def unknown_stroke(text: str = COLLECTOR) -> str:
    """The collector without the state on its bump stops."""
    return text.replace("  - jounce\n", "")


def value(r: LineResponse, key: str) -> np.ndarray:
    return QUANTITIES[key].values(r) / QUANTITIES[key].si_factor


def test_dead_load_matches_method_with_its_shortening():
    """3295 N on bearing 2 for 2.90 mm; METHOD's matrices are those of the bent line, its tubes
    rigid: 1 %."""
    r = line()
    assert value(r, "centre_bearing_dead_load")[GVW, 1] == pytest.approx(3295, rel=0.01)
    assert value(r, "spline_dead_load_shortening")[GVW] == pytest.approx(2.90, rel=0.015)


def test_states_of_both_ends_give_stroke():
    """The spline goes in by 17.2 mm from its longest place to its shortest, with the axle low."""
    r = line()
    assert value(r, "spline_stroke_shortening")[GVW] == pytest.approx(17.2, abs=0.05)
    alone = re.sub(r"(?s)(states:\n).*?(obstacles:)", r"\1  - gvw\n\n\2", COLLECTOR)
    assert value(line(alone), "spline_stroke_shortening") == pytest.approx(0.0)


def test_static_force_over_stroke_is_limited_by_tyres(monkeypatch):
    """METHOD: 1580 N over 40 mm, 2795 N down to 110 mm, both under all of first gear's torque.

    Its tyres hold all of it down to 13 mm, and less the longer its springs: between the two.
    """
    found = value(line(), "centre_bearing_static")[:, 1].max()
    assert 1580 < found < 2795
    monkeypatch.setattr(stroke_thrust, "_SHARES", np.arange(24) / 24)
    fine = value(line(), "centre_bearing_static")[:, 1].max()
    assert found <= fine * (1 + 1e-9)
    assert found == pytest.approx(fine, rel=0.09)


@pytest.mark.slow
def test_tyres_that_hold_all_torque_let_more_of_the_stroke_thrust():
    """Half as much grip again lets the axle rise farther under all of the torque."""
    r = line(COLLECTOR.replace("friction: 0.8 ", "friction: 1.2 ", 1))
    assert (
        value(r, "centre_bearing_static")[:, 1].max()
        > 1.1 * value(line(), "centre_bearing_static")[:, 1].max()
    )


def test_unknown_stroke_holds_whole_slip_force():
    """Then the line where it lies carries its dead load, not that of its fixed shape: 2229 N."""
    r = line(unknown_stroke())
    dead = value(r, "centre_bearing_dead_load")[GVW, 1]
    static = value(r, "centre_bearing_static")[GVW, 1]
    assert dead == pytest.approx(3309, rel=0.001)
    assert static == pytest.approx(dead, rel=0.05)
    assert r.mount_loads.bearing_force("static")[GVW, 1] >= dead * (1 - 1e-3)


@pytest.mark.slow
def test_unknown_stroke_above_critical_compression_is_not_evaluated():
    """At 0.12 the slip force is 27.5 kN, and 25.3 buckle the line."""
    text = unknown_stroke().replace("friction: 0.08", "friction: 0.12")
    r = line(text)
    assert value(r, "spline_compression_utilisation")[GVW] == pytest.approx(27522 / 25371, rel=5e-3)
    for key in FORCES:
        assert np.isnan(value(r, key)[GVW]).all(), key
    missed = [u for u in unevaluated_line_checks(r) if u.limit.quantity == "centre_bearing_peak"]
    assert any("full rebound and bump" in need for u in missed for need in u.missing_inputs)


def test_known_stroke_above_critical_compression_is_evaluated():
    r = line(COLLECTOR.replace("friction: 0.08", "friction: 0.12"))
    assert np.isfinite(value(r, "centre_bearing_static")[GVW]).all()
    assert 0.8 < value(r, "spline_compression_utilisation")[GVW, 0] < 1


def test_spline_without_radius_slides_freely():
    r = line(COLLECTOR.replace("mean_radius_mm: 32, ", ""))
    assert r.mounts.stroke_thrust is None
    assert np.isfinite(value(r, "centre_bearing_static")).all()
    assert np.isnan(value(r, "spline_compression_utilisation")).all()


def test_line_in_one_state_keeps_stroke_of_all_states():
    """A plot of one state, or a move tried in one, has the suspension go through all the same."""
    whole = line()
    (alone, two) = (line_response_in_states(whole, states) for states in ((GVW,), (4, GVW)))
    for r, at in ((alone, 0), (two, 1), (line_response_in_states(two, (1,)), 0)):
        for name in ("centre_bearing_dead_load", "spline_stroke_shortening"):
            assert value(r, name)[at] == pytest.approx(value(whole, name)[GVW], rel=1e-12), name
        ours, all_of = r.mounts.stroke_thrust, whole.mounts.stroke_thrust
        np.testing.assert_array_equal(ours.force[:, :, at], all_of.force[:, :, GVW])
        np.testing.assert_array_equal(ours._shaft_ends[:, :, at], all_of._shaft_ends[:, :, GVW])


def test_stiff_mounts_carry_thrust_of_fixed_shape():
    """On a thousand times stiffer rubber the critical compression is as much farther off."""
    stiff = COLLECTOR.replace("N_mm: 200", "N_mm: 200000").replace("N_mm: 120,", "N_mm: 120000,")
    stiff = stiff.replace("lateral_stiffness_N_mm: 120}", "lateral_stiffness_N_mm: 120000}")
    r, soft = line(stiff), line()
    share = value(r, "spline_compression_utilisation") / value(
        soft, "spline_compression_utilisation"
    )
    assert share.max() < 0.02


def test_spline_rests_at_its_length_under_no_torque(monkeypatch):
    """The place where it was before the launch: the line as the axle stands without torque."""
    asked = {}

    def seen(of, **given):
        asked.update(given)
        return stroke_compression(of, **given)

    stroke_compression = stroke_thrust.stroke_compression
    monkeypatch.setattr(stroke_thrust, "stroke_compression", seen)
    r = line()
    assert r.mounts.stroke_thrust is not None
    none = np.zeros(len(r.demand.states))
    motion = axle_motion_under_torque(
        r.inputs.demand, none, coasts=none.astype(bool), brakes=none.astype(bool)
    )
    still = demand_at_axle_motion(r.inputs.demand, motion, torque=none, speed=none)
    at_rest = r.inputs.layout_for(still).lengths[..., -1]
    assert asked["rest_length"][0, 0] == pytest.approx(at_rest, rel=1e-9)
    assert np.abs(asked["length"][0, 0] - at_rest).max() > 1e-4


def test_spline_that_is_pushed_in_has_a_thrust_below_zero_and_one_drawn_out_above():
    r = line()
    slip = r.inputs.spline_force_at(np.asarray(r.demand.torque))
    pushed, drawn = r.mounts.stroke_thrust.effect(r.demand.torque, slip).thrust
    assert pushed.min() < -1000
    assert pushed.max() <= 0
    assert drawn.min() >= 0
    assert drawn.max() > 1000


@pytest.mark.slow
def test_batch_of_frictions_equals_single_lines(monkeypatch):
    monkeypatch.setattr(MountLoads, "stop_response", None)  # of one design alone
    drawn = {
        FRICTION: np.array([0.06, 0.08, 0.11]),
        "driveline.shafts[1].centre_bearing.lateral_stiffness_N_mm": np.array(
            [100.0, 120.0, 160.0]
        ),
    }
    together = line(**drawn)
    keys = "spline_compression_utilisation", "centre_bearing_dead_load", "clearance_on_rubber"
    for k in range(3):
        alone = line(**{name: float(values[k]) for name, values in drawn.items()})
        for key in keys:
            expected = value(alone, key)
            assert value(together, key)[k] == pytest.approx(expected, rel=1e-6, nan_ok=True), key
        for kind in ("static", "dynamic"):  # on linear rubber: a batch does not solve its stop
            expected = alone.mount_loads.bearing_force(kind)
            assert together.mount_loads.bearing_force(kind)[k] == pytest.approx(expected, rel=1e-6)
