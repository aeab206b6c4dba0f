"""Bearing forces while friction holds the spline: where they count, and where they do not."""

import csv
import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from repository import EXAMPLES

from cardan.application import reader
from cardan.approval.applied_adjustments import all_adjustments, response_with_adjustments
from cardan.approval.driveline_study import line_checks
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.checks.stuck_spline_estimate import BATCH_SAFETY_FACTOR
from cardan.documents.bearing_force_table import bearing_force_csv
from cardan.documents.criteria import condition_texts, full_condition_text
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.json_contract import check_json
from cardan.render.phrases import check_location

COLLECTOR = EXAMPLES / "refuse-collector-6x2.yaml"
REBOUND = 0


def line(old: str = "", new: str = "", *, path: Path = COLLECTOR) -> LineResponse:
    text = path.read_text(encoding="utf-8")
    assert old in text
    application = reader.loads(text.replace(old, new) if old else text)
    return compute_line_response(
        application, line_state_demand(resolve_line_references(application, application.lines[0]))
    )


@pytest.fixture(scope="module")
def collector() -> LineResponse:
    return line()


def test_larger_force_with_spline_stuck_is_the_dynamic_force(collector):
    """Bearing 1 at full rebound, in reverse: 1811 N for 1394 N sliding."""
    loads = collector.mount_loads
    stuck = loads.stuck_forces.forces["dynamic"]
    assert loads.is_stuck("dynamic")[REBOUND, 0]
    assert loads.evaluated_force("dynamic")[REBOUND, 0] == stuck[REBOUND, 0]
    assert stuck[REBOUND, 0] > 1.2 * loads.bearing_force("dynamic")[REBOUND, 0]
    assert loads.points_of_evaluated_force("dynamic").operating_point((REBOUND, 0)).is_spline_stuck


def test_force_of_sliding_spline_counts_where_it_is_larger(collector):
    loads, kind = collector.mount_loads, "dynamic"
    slides = ~loads.is_stuck(kind)
    assert slides.any()
    assert (
        np.nan_to_num(loads.stuck_forces.forces[kind][slides])
        <= 1.01 * loads.evaluated_force(kind)[slides]
    ).all()  # fmt: skip
    state, bearing = np.argwhere(slides)[0]
    point = loads.points_of_evaluated_force(kind).operating_point((int(state), int(bearing)))
    assert not point.is_spline_stuck


def test_motion_counts_only_where_its_thrust_is_below_slip_force(collector):
    """With a tenth of the friction the spline is held only off the resonances."""
    slippery = line("friction: 0.08,", "friction: 0.008,").mount_loads
    usual = collector.mount_loads.stuck_forces.forces["dynamic"]
    least = slippery.stuck_forces
    most = 0.0 if least is None else np.nan_to_num(least.forces["dynamic"]).max()
    assert most < 0.7 * np.nanmax(usual)


def test_estimate_of_many_designs_is_above_stuck_forces(collector):
    """Where the stuck force exceeds the sliding one; a batch has the estimate of one design."""
    loads = collector.mount_loads
    for kind in ("dynamic", "peak"):
        stuck = loads.is_stuck(kind)
        assert stuck.any()
        solved = loads.stuck_forces.forces[kind][stuck]
        assert (BATCH_SAFETY_FACTOR * loads.stuck_force_estimate[kind][stuck] > solved).all()
        assert (loads.stuck_force_estimate[kind][stuck] < 1.5 * solved).all()
    shim = next(a for a in all_adjustments(collector) if a.adjustment_key == "shim")
    batch = response_with_adjustments(collector, (shim,), np.array([[0.0], [0.01]])).mount_loads
    assert batch.stuck_forces is None
    assert batch.stuck_force_estimate["peak"][0] == pytest.approx(
        loads.stuck_force_estimate["peak"], rel=1e-9
    )


def test_margin_is_unproved_where_estimate_exceeds_threshold(collector):
    shim = next(a for a in all_adjustments(collector) if a.adjustment_key == "shim")
    loads = response_with_adjustments(collector, (shim,), np.array([[0.0]])).mount_loads
    estimate = BATCH_SAFETY_FACTOR * loads.stuck_force_estimate["dynamic"]
    assert collector.mount_loads.unproved_margin("dynamic", 1.0) is None  # it is solved
    margin = loads.unproved_margin("dynamic", estimate.max() / 1.1)
    assert margin.min() < -0.0999
    peak = BATCH_SAFETY_FACTOR * loads.stuck_force_estimate["peak"]
    meets_stop = peak > loads.least_force_at_stop
    counts = estimate > 1.01 * loads.bearing_force("dynamic")
    assert counts.any()
    assert ((loads.unproved_margin("dynamic", 1e9) < 0) == (meets_stop & counts)).all()


def test_spline_of_unknown_radius_has_no_stuck_forces():
    loads = line("mean_radius_mm: 32, friction: 0.08, ", "").mount_loads
    assert loads.stuck_forces is None
    assert not loads.is_stuck("dynamic").any()


def test_condition_says_spline_stuck(collector):
    found = next(
        c for c in line_checks(collector)
        if c.quantity == "centre_bearing_dynamic" and c.when.name == "full rebound"
        and c.part.number == 1
    )  # fmt: skip
    assert full_condition_text(found, ENGLISH).endswith("rpm, spline stuck")
    assert "spline stuck" in check_location(found, ENGLISH)
    assert check_json(found)["point"]["spline"] == "stuck"
    assert found.mode is None  # modes are those of a line whose spline slides
    assert condition_texts(found, ENGLISH)[-2:] == (
        "full rebound, spline stuck", "full rebound",
    )  # fmt: skip
    assert "luva travada" in full_condition_text(found, Translator("pt"))
    slides = replace(found, point=replace(found.point, is_spline_stuck=False))
    assert "spline" not in check_location(slides, ENGLISH)
    assert "spline" not in check_json(slides)["point"]


def test_table_of_forces_marks_where_the_verdict_has_more_with_spline_stuck(collector):
    """At full rebound in the first bearing: forces listed are those of a spline that slides."""
    rows = list(csv.DictReader(io.StringIO(bearing_force_csv([collector]))))
    marked = {(r["state"], r["bearing"]) for r in rows if r["stuck_spline"] == "1"}
    loads, states = collector.mount_loads, collector.demand.states
    stuck = loads.is_stuck("dynamic") | loads.is_stuck("peak")
    assert marked == {(states[s], str(b + 1)) for s, b in np.argwhere(stuck)}
    assert ("full rebound", "1") in marked
    assert len(marked) < stuck.size


def test_motion_beyond_stop_is_a_lower_bound(collector):
    """The 6x6 on its bump stops: its rubber would go 2.2 times as far as it can."""
    r = line(path=EXAMPLES / "mtv-6x6.yaml")
    loads, kind, state = r.mount_loads, "dynamic", r.demand.states.index("jounce")
    assert loads.is_stuck(kind)[state, 0]
    assert loads.stuck_forces.travel_share[kind][state, 0] > 1
    assert loads.force_validity_margin(kind)[state, 0] < 0
    assert loads.force_at_stop(kind)[state, 0] == loads.stuck_forces.forces[kind][state, 0]
    within = collector.mount_loads
    held = within.is_stuck(kind) & (within.stuck_forces.travel_share[kind] <= 1)
    margin = np.broadcast_to(within.force_validity_margin(kind), held.shape)
    assert (margin[held] > 0).all()
