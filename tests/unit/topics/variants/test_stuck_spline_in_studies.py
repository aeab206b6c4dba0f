"""Studies with a spline that sticks: no variant passes whose force with it is not known."""

from functools import cache

import numpy as np
import pytest
from repository import EXAMPLES

from cardan.application import overrides, reader
from cardan.approval.applied_adjustments import response_with_adjustments
from cardan.approval.approval import approve_driveline
from cardan.approval.margins import margins_to_both_bounds
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.core.verdict import CHECK_GRADES
from cardan.model.adjustments import permitted_adjustments_by_name
from cardan.model.application import Application
from cardan.model.variants import VariantOutputs
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references
from cardan.topics.design.robustness import ToleranceModel
from cardan.topics.variants.evaluation import build_variants, evaluate_variants
from cardan.topics.variants.runner import run_study

DYNAMIC, PEAK = "centre_bearing_dynamic", "centre_bearing_peak"
HEIGHT, SHIM = "main.bearing_height_mm[1]", "main.shim_deg"
SLIDING_PASSES = f"- {{quantity: {DYNAMIC}, normal: 2700, maximum: 2800, source: ours}}"
LENIENT = f"- {{quantity: {DYNAMIC}, maximum: 90000, source: ours}}"
"""N: sliding, the 6x6's bearing has 2357 there; stuck, on rubber without a stop, 5000 and more."""


@cache
def army_truck(limits: str, *, travel: int = 200) -> Application:
    """The 6x6, its bearing with so many mm of travel, under other limits."""
    text = (EXAMPLES / "mtv-6x6.yaml").read_text(encoding="utf-8")
    old, new = "centre_bearing: {", f"centre_bearing: {{travel_mm: {travel}, "
    assert text.count(old) == text.count("limits: heavy-truck") == 1
    return reader.loads(
        text.replace(old, new).replace("limits: heavy-truck", f"limits:\n  {limits}")
    )


def moved(application: Application, shim: float, *, many: bool = False) -> LineResponse:
    """The rear line with its pinion shimmed, alone or as a batch of one."""
    response = approve_driveline(application).line_responses[0]
    way = permitted_adjustments_by_name(i.line for i in application.lines)[SHIM]
    amounts = np.radians([shim])
    return response_with_adjustments(response, (way,), amounts[None] if many else amounts)


def test_variant_that_only_its_stuck_spline_fails_does_not_pass():
    """In a range and in tolerances; its force is that of the check by itself."""
    application = army_truck(SLIDING_PASSES)
    assert set(evaluate_variants(application, {HEIGHT: [-1, 1]}, count=2).verdicts) == {"fail"}
    found = evaluate_variants(application, {SHIM: {"normal": 0.1}}, count=2)
    assert set(found.verdicts) == {"fail"}
    loads = moved(application, float(found.input_columns[0].values[1])).mount_loads
    assert found.results.values[0, 1] == pytest.approx(loads.evaluated_force("dynamic").max())
    assert loads.bearing_force("dynamic").max() < 2700


def test_map_shows_no_yield_where_only_stuck_spline_fails():
    vary = {HEIGHT: [-1, 1], SHIM: [-0.1, 0.1]}
    study = build_variants(vary, ask=VariantOutputs(maps=((HEIGHT, SHIM),)))
    ((_, state),) = run_study(army_truck(SLIDING_PASSES), study, count=2).maps
    assert state["count"].sum() == 2
    assert state["passes"].sum() == 0


def test_variant_that_fails_anyway_keeps_lower_bound():
    """Its peak force fails: no spline is solved for the dynamic one, which does not pass either."""
    limits = SLIDING_PASSES + f"\n  - {{quantity: {PEAK}, maximum: 5000, source: ours}}"
    found = evaluate_variants(army_truck(limits), {HEIGHT: [-1, 1]}, count=2)
    assert set(found.verdicts) == {"fail"}
    dynamic = [limit.quantity for _, limit in found.limits].index(DYNAMIC)
    assert found.results.bounded[dynamic].all()
    assert (found.results.grades[dynamic] == CHECK_GRADES.index("warn")).all()
    assert (found.results.values[dynamic] < 2700).all()


def test_limit_above_upper_estimate_needs_no_solution():
    """What no stuck spline exceeds stands as the sliding one has it, without a solution."""
    found = evaluate_variants(army_truck(LENIENT, travel=500), {HEIGHT: [-1, 1]}, count=2)
    assert set(found.verdicts) == {"pass"}
    assert not found.results.unproved.any()
    assert (found.results.values < 2700).all()


def test_trucks_of_correction_lose_what_stuck_spline_takes_from_it():
    """A limit just above the stuck force is lost by some, though all are far below it sliding."""
    stuck = moved(army_truck(LENIENT), 0.0).mount_loads.evaluated_force("dynamic").max()
    limit = f"- {{quantity: {DYNAMIC}, maximum: {1.005 * stuck:.0f}, source: ours}}"
    trucks = ToleranceModel.from_application(army_truck(limit), "main")
    slides = margins_to_both_bounds(moved(army_truck(limit), 0.0, many=True))
    as_sliding = {bound: margins[0] for bound, margins in slides.items()}
    assert trucks.survival((), np.empty(0), solved=as_sliding).share == 1
    for draws in (0, 64):
        assert 0.2 < trucks.survival((), np.empty(0), asked=draws).share < 0.9


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "limit"),
    [
        ("mtv-6x6", SLIDING_PASSES),
        ("vecto-6x2", f"- {{quantity: {DYNAMIC}, normal: 1000, maximum: 9000, source: ours}}"),
    ],
)
def test_variants_have_forces_of_their_single_checks(name, limit):
    """Solved by themselves where the stuck spline may decide; 30 of each were compared once."""
    text = (EXAMPLES / f"{name}.yaml").read_text(encoding="utf-8")
    text = text.replace("centre_bearing: {", "centre_bearing: {travel_mm: 200, ")
    application = reader.loads(text.replace("limits: heavy-truck", f"limits:\n  {limit}"))
    lead = "drivelines.main" if name == "mtv-6x6" else "driveline"
    at = f"{lead}.points_mm[2][3]"
    height = overrides.nominal_variable_values(application)[at]
    found = evaluate_variants(application, {at: [height - 6, height + 6]}, count=8)
    k = [limit.quantity for _, limit in found.limits].index(DYNAMIC)
    limit = found.limits[k][1]
    for v, value in enumerate(found.input_columns[0].values):
        changed = overrides.change(application, {at: float(value)})
        demand = line_state_demand(resolve_line_references(changed, changed.lines[0]))
        force = compute_line_response(changed, demand).mount_loads.evaluated_force("dynamic").max()
        assert found.results.values[k, v] == pytest.approx(force, rel=1e-9)
        assert CHECK_GRADES[found.results.grades[k, v]] == limit.grade(force)
