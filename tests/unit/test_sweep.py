"""A sweep's variants are what a check says of each by itself."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cardan import files
from cardan.base.errors import BadFile
from cardan.base.part import LINE, Occasion
from cardan.base.source import Source
from cardan.base.units import deg, mm
from cardan.base.verdict import GRADES, Check, Limit, worst
from cardan.demand.states import demand, resolve
from cardan.model.application import Adjustable
from cardan.quantity.response import respond
from cardan.report.wording import worst_of_each
from cardan.study.approval import assess
from cardan.study.driveline import checks_of
from cardan.study.moves import tried
from cardan.study.sweep import NOTHING, sweep

ROOT = Path(__file__).parents[2]
TRUCK = ROOT / "examples" / "refuse-collector-6x2.yaml"
SAME = 1e-9
"""Sums over the states, the shafts and a turn cancel to some 1e-13 of the largest value about."""


def agrees(found, k, checks, verdict):
    """Hold one variant of a sweep against the checks of it by itself."""
    assert found.verdicts[k] == verdict
    _, smallest = min((-GRADES.index(c.grade), c.margin) for c in worst_of_each(checks))
    assert found.margins[k] == pytest.approx(smallest, rel=SAME, abs=SAME)
    for held in found.held:
        same = [c for c in checks if c.limit == held.limit and c.line == held.line]
        if not same:
            assert held.grades[k] == NOTHING
            assert np.isnan(held.margins[k])
            continue
        bad = min(same, key=lambda c: (-GRADES.index(c.grade), c.margin))
        assert GRADES[held.grades[k]] == bad.grade
        assert held.margins[k] == pytest.approx(bad.margin, rel=SAME, abs=SAME)
        # Of states that share the worst margin either may be named.
        values = [c.value for c in same if c.margin == pytest.approx(bad.margin, abs=SAME)]
        assert min(abs(held.values[k] - v) for v in values) <= SAME * abs(bad.value)
    assert sum(g != NOTHING for g in (h.grades[k] for h in found.held)) == len(
        {(c.line, c.limit) for c in checks}
    )


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
def test_each_variant_is_what_a_check_of_it_says(path, vary):
    application = files.read(path)
    found = sweep(application, vary, count=32)
    assert found.count == 32
    for k in range(32):
        changes = {v.name: float(v.values[k]) for v in found.varied}
        alone = assess(files.change(application, changes))
        agrees(found, k, alone.checks, alone.verdict)
    assert max(len(set(h.margins.tolist())) for h in found.held) > 30


@pytest.mark.slow
def test_what_a_workshop_moves_varies_beside_the_files_numbers():
    application = files.read(TRUCK)
    vary = {
        "bearing_height_mm[*]": {"normal": 5.0},
        "phase_deg[2]": {"choice": [0, 90]},
        "shim_deg": [-1, 1],
        "driveline.shafts[1].phase_deg": {"choice": [0, 90]},
    }
    found = sweep(application, vary, count=64)
    values = {v.name: v.values for v in found.varied}
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
        Adjustable(what=w, part=p, low=-1, high=1, line="main") for w, p, _ in moved.values()
    )
    for k in range(64):
        at = "driveline.shafts[1].phase_deg"
        changed = files.change(application, {at: float(values[at][k])})
        response = respond(changed, demand(resolve(changed, changed.lines[0])))
        amounts = np.array([values[n][k] * worth for n, (_, _, worth) in moved.items()])
        checks = tuple(checks_of(tried(response, parts, amounts)))
        agrees(found, k, checks, worst(c.grade for c in checks))


def test_a_required_limit_without_an_answer_leaves_every_variant_incomplete():
    text = TRUCK.read_text(encoding="utf-8").split("\nlimits:")[0]
    limits = """
limits:
  - {quantity: joint_angle, maximum: 80, required: true, source: ours}
  - {quantity: tube_shear_utilisation, maximum: 99, required: true, source: ours}
"""
    application = files.loads(text + limits)
    vary = {"axle.ratio": [5, 6]}
    assert set(sweep(application, vary, count=8).verdicts) == {"pass"}
    limits += "  - {quantity: torsional_growth, maximum: 0, required: true, source: ours}\n"
    missing = files.loads(text + limits)
    assert assess(missing).verdict == "incomplete"
    found = sweep(missing, vary, count=8)
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
def test_what_cannot_vary_is_told_with_its_name(vary, told):
    with pytest.raises(ValueError, match=r".") as error:
        sweep(files.read(TRUCK), vary, count=4)
    assert told in str(error.value)


def test_a_number_that_cannot_be_is_refused_as_a_file_with_it():
    application = files.read(TRUCK)
    with pytest.raises(BadFile, match=r"tube\.wall_mm"):
        sweep(application, {"driveline.shafts[2].tube.wall_mm": [-1, 4]}, count=16)


@pytest.mark.slow
def test_points_are_spread_evenly_and_come_back_with_their_seed():
    application = files.read(TRUCK)
    vary = {"axle.ratio": [5, 6], "shim_deg": {"uniform": 1}}
    first, again, other = (sweep(application, vary, count=64, seed=s) for s in (1, 1, 2))
    ratio, shim = (v.values for v in first.varied)
    # One point in each of 64 equal parts: what makes Sobol's points better than dice.
    assert sorted(np.floor((ratio - 5) * 64)) == list(range(64))
    assert sorted(np.floor((shim + 1) * 32)) == list(range(64))
    assert (ratio == again.varied[0].values).all()
    assert (ratio != other.varied[0].values).any()


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


@settings(deadline=None)
@given(limit=limits, values=st.lists(st.floats(-20, 20), min_size=1, max_size=9))
def test_many_values_are_graded_as_one(limit, values):
    every = np.array([*values, *(b for b in (limit.normal, limit.maximum) if b is not None)])
    grades, margins = limit.grades(every), limit.margins(every)
    for value, grade, margin in zip(every.tolist(), grades, margins, strict=True):
        one = Check(
            quantity="joint_angle", line="main", when=Occasion("state", "gvw"), part=LINE,
            value=value, limit=limit,
        )  # fmt: skip
        assert (GRADES[grade], float(margin)) == (one.grade, one.margin)
    assert GRADES[limit.grades(np.array([np.nan]))[0]] == "fail"
