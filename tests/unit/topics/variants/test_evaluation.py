"""A sweep's variants are what a check says of each by itself."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from repository import ROOT

from cardan.application import overrides, reader
from cardan.approval.applied_adjustments import response_with_adjustments
from cardan.approval.approval import approve_driveline
from cardan.approval.driveline_study import line_checks
from cardan.checks.line_response import compute_line_response
from cardan.checks.mount_loads import MountLoads
from cardan.checks.quantities.registry import LINE_QUANTITIES
from cardan.core.errors import InvalidFileError
from cardan.core.labels import WHOLE_LINE, EvaluationCondition
from cardan.core.provenance import Source
from cardan.core.units import deg, mm
from cardan.core.verdict import CHECK_GRADES, Check, Limit, worst_verdict
from cardan.model.application import PermittedAdjustment
from cardan.model.variants import VariantOutputs
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references
from cardan.render.phrases import worst_check_per_limit
from cardan.topics.variants.evaluation import (
    UNEVALUATED_GRADE_CODE,
    VariantEvaluator,
    build_variants,
    evaluate_variants,
)

TRUCK = ROOT / "examples" / "refuse-collector-6x2.yaml"
SAME = 1e-9
"""Sums over the states, the shafts and a turn cancel to some 1e-13 of the largest value about."""


def agrees(found, k, checks, verdict):
    """Hold one variant of a sweep against the checks of it by itself.

    A lower bound, of which a check warns, leaves a variant incomplete.
    """
    bounded = verdict in ("pass", "warn") and any(c.is_lower_bound for c in checks)
    assert found.verdicts[k] == ("incomplete" if bounded else verdict)
    _, smallest = min(
        (-CHECK_GRADES.index(c.grade), c.margin) for c in worst_check_per_limit(checks)
    )
    assert found.margins[k] == pytest.approx(smallest, rel=SAME, abs=SAME)
    for held in found.limit_columns:
        same = [c for c in checks if c.limit == held.limit and c.line == held.line]
        if not same:
            assert held.grades[k] == UNEVALUATED_GRADE_CODE
            assert np.isnan(held.margins[k])
            continue
        bad = min(same, key=lambda c: (-CHECK_GRADES.index(c.grade), c.margin))
        assert CHECK_GRADES[held.grades[k]] == bad.grade
        assert held.margins[k] == pytest.approx(bad.margin, rel=SAME, abs=SAME)
        # Of states that share the worst margin either may be named.
        values = [c.value for c in same if c.margin == pytest.approx(bad.margin, abs=SAME)]
        assert min(abs(held.values[k] - v) for v in values) <= SAME * abs(bad.value)
    assert sum(
        g != UNEVALUATED_GRADE_CODE for g in (h.grades[k] for h in found.limit_columns)
    ) == len({(c.line, c.limit) for c in checks})


@pytest.fixture
def linear_rubber(monkeypatch):
    """Single checks that do not solve a stop, as a batch does not: their forces are its bounds.

    Nor a stuck spline: of variants that fail anyway, or meet a stop, a batch does not solve it
    (`test_stuck_spline_in_studies.py` has the others).
    """
    monkeypatch.setattr(MountLoads, "stop_response", None)
    monkeypatch.setattr(MountLoads, "stuck_forces", None)
    monkeypatch.setattr(MountLoads, "stuck_force_estimate", {})


@pytest.mark.slow
@pytest.mark.usefixtures("linear_rubber")
@pytest.mark.parametrize(
    ("path", "vary"),
    [
        pytest.param(
            TRUCK, {
                "driveline.shafts[2].tube.wall_mm": [1.5, 5],
                "axle.ratio": {"normal": 0.3},
                "driveline.points_mm[3][3]": {"uniform": 25},
                "obstacles[1].radius_mm": {"choice": [20, 40]},
            },
            marks=pytest.mark.slow,
        ),
        pytest.param(
            ROOT / "examples" / "tandem-6x4.yaml", {"tyre.friction": {"uniform": 0.2}},
            marks=pytest.mark.slow,
        ),
        (ROOT / "tests" / "truck.yaml", {"shock_factor": [1, 9]}),
    ],
)  # fmt: skip
def test_each_variant_equals_its_single_check(path, vary):
    application = reader.read(path)
    found = evaluate_variants(application, vary, count=32)
    assert found.count == 32
    for k in range(32):
        changes = {v.name: float(v.values[k]) for v in found.input_columns}
        alone = approve_driveline(overrides.change(application, changes))
        agrees(found, k, alone.checks, alone.verdict)
    assert max(len(set(h.margins.tolist())) for h in found.limit_columns) > 30


@pytest.mark.slow
@pytest.mark.usefixtures("linear_rubber")
def test_adjustments_vary_together_with_file_values():
    application = reader.read(TRUCK)
    vary = {
        "bearing_height_mm[*]": {"normal": 5.0},
        "phase_deg[2]": {"choice": [0, 90]},
        "shim_deg": [-1, 1],
        "driveline.shafts[1].phase_deg": {"choice": [0, 90]},
    }
    found = evaluate_variants(application, vary, count=64)
    values = {v.name: v.values for v in found.input_columns}
    assert list(values) == [
        "bearing_height_mm[1]", "bearing_height_mm[2]", "phase_deg[2]", "shim_deg",
        "driveline.shafts[1].phase_deg",
    ]  # fmt: skip
    assert np.std(values["bearing_height_mm[1]"]) == pytest.approx(5, rel=0.1)
    moved = {
        "bearing_height_mm[1]": ("bearing_height", 1, mm),
        "bearing_height_mm[2]": ("bearing_height", 2, mm),
        "phase_deg[2]": ("phase", 2, deg),
        "shim_deg": ("shim", 1, deg),
    }
    parts = tuple(
        PermittedAdjustment(adjustment_key=w, part=p, low=-1, high=1, line="main")
        for w, p, _ in moved.values()
    )
    for k in range(64):
        at = "driveline.shafts[1].phase_deg"
        changed = overrides.change(application, {at: float(values[at][k])})
        response = compute_line_response(
            changed, line_state_demand(resolve_line_references(changed, changed.lines[0]))
        )
        amounts = np.array([values[n][k] * worth for n, (_, _, worth) in moved.items()])
        checks = tuple(line_checks(response_with_adjustments(response, parts, amounts)))
        agrees(found, k, checks, worst_verdict(c.grade for c in checks))


def test_required_limit_not_evaluated_makes_variants_incomplete():
    text = TRUCK.read_text(encoding="utf-8").split("\nlimits:")[0]
    limits = """
limits:
  - {quantity: joint_angle, maximum: 80, required: true, source: ours}
  - {quantity: tube_shear_utilisation, maximum: 99, required: true, source: ours}
"""
    application = reader.loads(text + limits)
    vary = {"axle.ratio": [5, 6]}
    assert set(evaluate_variants(application, vary, count=8).verdicts) == {"pass"}
    limits += "  - {quantity: torsional_growth, maximum: 0, required: true, source: ours}\n"
    missing = reader.loads(text + limits)
    assert approve_driveline(missing).verdict == "incomplete"
    found = evaluate_variants(missing, vary, count=8)
    assert set(found.verdicts) == {"incomplete"}
    assert found.yield_ == 0


@pytest.mark.parametrize(
    ("vary", "told"),
    [
        ({"driveline.shafts[2].tube.wal_mm": [3, 4]}, "mean driveline.shafts[2].tube.wall_mm?"),
        ({"bearing_heigth_mm[1]": [3, 4]}, "mean bearing_height_mm[1]?"),
        ({"bearing_height_mm[7]": [3, 4]}, "mean bearing_height_mm"),
        ({"axle.ratio": [4, 3]}, "axle.ratio varies over [low, high]"),
        ({"axle.ratio": [3, 4, 5]}, "axle.ratio varies over [low, high]"),
        ({"axle.ratio": {"gauss": 1}}, "one of choice, grid, normal, uniform"),
        ({"axle.ratio": {"normal": 0}}, "a number above 0"),
        ({"axle.ratio": {"choice": []}}, "choice needs values"),
        ({}, "nothing varies"),
    ],
)
def test_invalid_variable_is_rejected_by_name(vary, told):
    with pytest.raises(ValueError, match=r".") as error:
        evaluate_variants(reader.read(TRUCK), vary, count=4)
    assert told in str(error.value)


def test_impossible_value_is_rejected_like_in_file():
    application = reader.read(TRUCK)
    with pytest.raises(InvalidFileError, match=r"tube\.wall_mm"):
        evaluate_variants(application, {"driveline.shafts[2].tube.wall_mm": [-1, 4]}, count=16)


@pytest.mark.slow
def test_sample_points_are_even_and_reproducible_by_seed():
    application = reader.read(TRUCK)
    vary = {"axle.ratio": [5, 6], "shim_deg": {"uniform": 1}}
    first, again, other = (
        evaluate_variants(application, vary, count=64, seed=s) for s in (1, 1, 2)
    )
    ratio, shim = (v.values for v in first.input_columns)
    # One point in each of 64 equal parts: what makes Sobol's points better than dice.
    assert sorted(np.floor((ratio - 5) * 64)) == list(range(64))
    assert sorted(np.floor((shim + 1) * 32)) == list(range(64))
    assert (ratio == again.input_columns[0].values).all()
    assert (ratio != other.input_columns[0].values).any()


limits = st.builds(
    lambda normal, more, sense, which: Limit(
        quantity="joint_angle", source=Source("ours"), sense=sense,
        normal=normal if which != "maximum" else None,
        maximum=(normal + more if sense == "<=" else normal - more) if which != "normal" else None,
    ),
    st.floats(-5, 5).map(lambda x: round(x, 9)), st.floats(0, 5).map(lambda x: round(x, 9)),
    st.sampled_from(["<=", ">="]),
    st.sampled_from(["normal", "maximum", "both"]),
) | st.builds(
    lambda low, wide: Limit(quantity="joint_angle", source=Source("ours"), band=(low, low + wide)),
    st.floats(0.1, 5), st.floats(0.1, 5),
)  # fmt: skip


@given(
    limit=limits,
    values=st.lists(st.floats(-20, 20), min_size=1, max_size=9),
    validity_margin=st.sampled_from([np.inf, -0.3]),
)
def test_array_of_values_is_graded_like_single_values(limit, values, validity_margin):
    every = np.array([*values, *(b for b in (limit.normal, limit.maximum) if b is not None)])
    grades, margins = limit.grades_and_margins(every, validity_margin=validity_margin)
    for value, grade, margin in zip(every.tolist(), grades, margins, strict=True):
        one = Check(
            quantity="joint_angle",
            line="main",
            when=EvaluationCondition("state", "gvw"),
            part=WHOLE_LINE,
            value=value,
            limit=limit,
            validity_margin=validity_margin,
        )
        assert (CHECK_GRADES[grade], float(margin)) == (one.grade, one.margin)
    assert CHECK_GRADES[limit.grades(np.array([np.nan]))[0]] == "fail"


@pytest.mark.slow
def test_yield_alone_is_that_of_all_limits_and_stops_before_rubber(monkeypatch):
    scatter = {"bearing_height_mm[*]": {"normal": 3.0}, "phase_deg[*]": {"normal": 4.0}}
    moved = {"bearing_height_mm[2]": {"choice": [15]}, "shim_deg": {"choice": [0.5]}}
    ask = VariantOutputs(limits=("joint_angle_min", "clearance", "spline_compression_utilisation"))
    variants = build_variants(moved, scatter, ask=ask)
    whole = VariantEvaluator.from_application(reader.read(TRUCK), variants)
    every, count = whole.evaluate_range(0, 40), []
    alone = replace(whole, yield_only=True)
    evaluate = VariantEvaluator.evaluate

    def counted(of, inputs):
        asks = any(limit.quantity == "spline_compression_utilisation" for _, limit in of.limits)
        count.append(len(inputs) * asks)
        return evaluate(of, inputs)

    monkeypatch.setattr(VariantEvaluator, "evaluate", counted)
    found = alone.evaluate_range(0, 40)
    assert found.verdicts == every.verdicts
    assert len(set(found.verdicts)) > 1
    stopped = found.results.stopped
    assert 0 < stopped.sum() < 40
    assert sum(count) == 40 - stopped.sum()
    rubber = [LINE_QUANTITIES[limit.quantity].depends_on_mounts for _, limit in found.limits]
    assert (found.results.grades[rubber][:, stopped] == UNEVALUATED_GRADE_CODE).all()
    np.testing.assert_array_equal(
        found.results.grades[np.logical_not(rubber)], every.results.grades[np.logical_not(rubber)]
    )


@pytest.mark.parametrize("varied", ["phase_deg[2]", "bearing_height_mm[1]"])
def test_batch_that_varies_one_thing_gives_values_of_batch_that_varies_all(varied):
    every = {n: {"normal": 1.0} for n in ("phase_deg[*]", "bearing_height_mm[*]", "shim_deg")}
    bench = VariantEvaluator.from_application(reader.read(TRUCK), build_variants({}, every))
    inputs = np.zeros((5, len(bench.sampling_plan.names)))
    inputs[:, bench.sampling_plan.names.index(varied)] = [-3.0, -1.0, 0.0, 2.0, 4.0]
    found, beside = bench.evaluate(inputs), bench.evaluate(np.vstack([inputs, inputs[:1] + 0.5]))
    for name in ("values", "margins", "left"):
        one, other = getattr(found, name), getattr(beside, name)[:, :-1]
        largest = np.nanmax(np.abs(other), axis=1, keepdims=True, initial=1e-300)
        np.testing.assert_allclose(one / largest, other / largest, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(found.grades, beside.grades[:, :-1])
    np.testing.assert_array_equal(found.bounded, beside.bounded[:, :-1])


def test_layout_is_computed_once_if_phases_alone_vary():
    response = approve_driveline(reader.read(TRUCK)).line_responses[0]
    name = response.line.name
    turned, lifted = (
        PermittedAdjustment(adjustment_key=k, part=1, low=-1, high=1, line=name)
        for k in ("phase", "bearing_height")
    )
    amounts = np.array([[0.01, 0.0], [0.02, 0.0], [0.03, 0.0]])
    found = response_with_adjustments(response, (turned, lifted), amounts, shared=True)
    assert found.joint_angles.shape[0] == 1
    assert LINE_QUANTITIES["torsional_acceleration"].values(found).shape[0] == 3
    apart = response_with_adjustments(response, (turned, lifted), amounts)
    assert apart.joint_angles.shape[0] == 3
