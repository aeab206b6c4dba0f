"""Studies at scale: what is told of shards is what NumPy says of every variant."""

import functools
import json
import os
import pickle
import re
import select
import signal
import subprocess
import sys
import time
from concurrent.futures import BrokenExecutor
from dataclasses import replace
from functools import cache
from hashlib import sha256
from importlib.util import find_spec
from itertools import pairwise
from multiprocessing import active_children
from pathlib import Path

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from repository import EXAMPLES, ROOT
from scipy import stats

import cardan
from cardan.application import overrides, reader
from cardan.application.variant_sampling import SampledVariable, SamplingPlan, sampling_plan
from cardan.approval.approval import approve_driveline
from cardan.cli import cli
from cardan.core.errors import CardanError, FileIssue, InvalidFileError
from cardan.core.verdict import CHECK_GRADES, VERDICTS, worst_first_key
from cardan.model.variants import VariantOutputs, VariantStudy, VariedNumber
from cardan.render.i18n import ENGLISH, LANGUAGE_CODES
from cardan.render.screen_layout import percent_text
from cardan.render.svg import VERDICT_COLOURS
from cardan.topics.variants import presentation, presentation_figures
from cardan.topics.variants import statistics as reduce
from cardan.topics.variants.evaluation import (
    UNEVALUATED_GRADE_CODE,
    VariantEvaluator,
    build_variants,
    evaluate_variants,
)
from cardan.topics.variants.executors import ProcessExecutor, _call_to_file, open_executor
from cardan.topics.variants.presentation import (
    damaged_shards_text,
    result_tables,
    terminal_lines,
)
from cardan.topics.variants.presentation_figures import (
    _bands,
    figures,
    parallel_coordinates_figure,
    yield_map_figure,
)
from cardan.topics.variants.presentation_json import json_document
from cardan.topics.variants.runner import run_study
from cardan.topics.variants.schema import read_variant_study as read_study
from cardan.topics.variants.screen_presentation import screen_lines
from cardan.topics.variants.shard_job import ShardJob, _evaluator_of
from cardan.topics.variants.shard_log import log_entries
from cardan.topics.variants.shard_store import MANIFEST_FILE_NAME, SHARD_LOG_FILE_NAME
from cardan.topics.variants.shard_tree import merged_statistics, next_node, shards_of
from cardan.topics.variants.statistics import (
    QUANTILE_RELATIVE_ERROR,
    clopper_pearson_interval,
    halved_tolerance_weights,
    halved_tolerance_yields,
    quantile,
    sobol_indices,
    wilson_interval,
)
from cardan.topics.variants.study_result import StudyInterrupted, VariantStudyResult

LINE = """
title: Two-piece driveline
speed_rpm: 2500
torque_Nm: 3000
driveline:
  slopes:
    side_deg: [3.0, 1.0, 4.5, 2.0]
    top_deg: [0.0, 0.0, 0.0, 0.0]
  joints: "1810"
  shafts:
    - length_mm: 1200
      tube: {outer_mm: 101.6, wall_mm: 3.2}
      centre_bearing: {from_rear_joint_mm: 140}
    - {length_mm: 1500, tube: {outer_mm: 101.6, wall_mm: 3.2}, phase_deg: 0}
limits:
  - {quantity: torsional_acceleration, normal: 350, maximum: 500, source: ours}
  - {quantity: critical_speed_ratio, maximum: 0.75, source: ours}
  - {quantity: joint_angle, maximum: 3.7, source: ours}
"""
TOLERANCES = {
    "driveline.slopes.side_deg[*]": {"normal": 0.2},
    "driveline.shafts[2].length_mm": {"uniform": 40},
}
VARY = {"shim_deg": {"grid": [-1, 1, 3]}, "driveline.shafts[2].tube.wall_mm": [3, 4]}
ASK = VariantOutputs(
    quantiles=(0.05, 0.5, 0.99), worst=5, rows="float64", pareto=("margin", "cost", "mass"),
    maps=(("shim_deg", "driveline.shafts[2].tube.wall_mm"),),
)  # fmt: skip


@cache
def application(more: str = ""):
    return reader.loads(LINE + more)


@cache
def studied() -> VariantStudyResult:
    """A study of some shards, with every variant kept beside what is told of them."""
    return run_study(application(), build_variants(VARY, TOLERANCES, ask=ASK), count=900, shard=200)


# --------------------------------------------------------------------------- where they lie


@pytest.mark.slow
@pytest.mark.parametrize(
    ("variants", "points"),
    [
        (build_variants(VARY, TOLERANCES), "random"),
        (
            build_variants({"shim_deg": [-1, 1], "driveline.shafts[2].length_mm": [1490, 1510]}),
            "even",
        ),
        (build_variants(VARY, TOLERANCES, ask=VariantOutputs(sobol=True)), "saltelli"),
    ],
)
def test_sampled_variants_are_independent_of_sharding(variants, points):
    bench = VariantEvaluator.from_application(application(), variants, seed=3)
    assert bench.sampling_plan.method == points
    whole = bench.sampling_plan.values(0, 240)
    cuts = [0, 24, 60, 180, 240] if points != "saltelli" else [0, 80, 160, 240]
    each = [bench.sampling_plan.values(a, b) for a, b in pairwise(cuts)]
    np.testing.assert_array_equal(np.concatenate(each), whole)
    assert (
        whole
        != VariantEvaluator.from_application(application(), variants, seed=4).sampling_plan.values(
            0, 240
        )
    ).any()


def test_sampled_values_follow_given_distributions():
    known = {"a": 5.0, "b": 1.0, "c": 0.0, "d": 7.0}
    variants = VariantStudy(
        vary={
            "c": VariedNumber(kind="range", values=(2.0, 4.0)),
            "d": VariedNumber(kind="choice", values=(1, 9)),
        },
        tolerances={
            "a": VariedNumber(kind="normal", values=(0.5,)),
            "b": VariedNumber(kind="uniform", values=(0.3,)),
            "c": VariedNumber(kind="normal", values=(0.01,)),
        },
        correlated=(("a", "b", -0.6),),
    )
    n = 40_000
    values = sampling_plan(variants, known, seed=1).values(0, n)
    at = {name: values[:, k] for k, name in enumerate(("c", "d", "a", "b"))}
    # Five standard errors of a mean and of a deviation.
    assert at["a"].mean() == pytest.approx(5, abs=5 * 0.5 / n**0.5)
    assert at["a"].std() == pytest.approx(0.5, rel=5 / (2 * n) ** 0.5)
    assert stats.kstest(at["b"], stats.uniform(0.7, 0.6).cdf).pvalue > 1e-6
    assert at["c"].min() < 2.01
    assert at["c"].std() == pytest.approx(2 / 12**0.5, rel=0.02)
    assert np.mean(at["d"] == 9) == pytest.approx(0.5, abs=5 * 0.5 / n**0.5)
    normal = stats.norm.ppf((at["b"] - 0.7) / 0.6)
    assert np.corrcoef(at["a"], normal)[0, 1] == pytest.approx(-0.6, abs=5 * 0.64 / n**0.5)


def test_grids_are_crossed_and_evaluated_completely():
    variants = build_variants(
        {"shim_deg": {"grid": [-1, 1, 3]}, "phase_deg[2]": {"grid": [0, 90, 2]}},
        {"driveline.slopes.side_deg[1]": {"normal": 0.1}},
    )
    bench = VariantEvaluator.from_application(application(), variants)
    assert bench.whole_count(8) == 12
    values = bench.sampling_plan.values(0, 12)
    places, counts = np.unique(values[:, :2], axis=0, return_counts=True)
    assert places.tolist() == [[s, p] for s in (-1, 0, 1) for p in (0, 90)]
    assert set(counts) == {2}


def test_contradictory_correlations_are_rejected():
    known = dict.fromkeys("abc", 0.0)
    tolerances = dict.fromkeys("abc", VariedNumber(kind="normal", values=(1.0,)))
    pairs = (("a", "b", 0.9), ("b", "c", 0.9), ("a", "c", -0.9))
    with pytest.raises(ValueError, match="contradict"):
        sampling_plan(VariantStudy(tolerances=tolerances, correlated=pairs), known)
    with pytest.raises(ValueError, match="independent"):
        sampling_plan(
            VariantStudy(
                tolerances=tolerances, correlated=pairs[:1], ask=VariantOutputs(sobol=True)
            ),
            known,
        )


def test_correlated_tolerances_are_reported():
    pair = ("driveline.slopes.side_deg[1]", "driveline.slopes.side_deg[2]")
    asked = replace(build_variants({}, TOLERANCES), correlated=((*pair, 0.5),))
    found = run_study(application(), asked, count=20)
    assert f"{pair[0]} with {pair[1]} 0.5" in "\n".join(terminal_lines(found))
    assert json_document(found)["correlated"] == [{"between": list(pair), "correlation": 0.5}]


@pytest.mark.parametrize("signs", [(-0.5, -0.5, -0.5), (0.6, 0.8, 0.0)])
def test_linearly_dependent_correlations_are_rejected(signs):
    """Three that add up to nothing: no contradiction, but what weighs them divides by nothing."""
    known = dict.fromkeys("abc", 0.0)
    tolerances = {name: VariedNumber(kind="normal", values=(1.0,)) for name in known}
    pairs = tuple((*p, r) for p, r in zip(("ab", "ac", "bc"), signs, strict=True))
    with pytest.raises(ValueError, match="leave one number no freedom of its own"):
        sampling_plan(VariantStudy(tolerances=tolerances, correlated=pairs), known)


# --------------------------------------------------------------------------- against NumPy


@pytest.mark.slow
def test_study_counts_match_stored_rows():
    found = studied()
    rows = found.rows
    assert found.count == rows.count == 900
    assert 0.2 < found.yield_ < 0.8
    assert found.shares == rows.shares
    assert found.yield_ == np.isin(rows.verdicts, ["pass", "warn"]).mean()
    counts = found.statistics["counts"]
    for k, held in enumerate(rows.limit_columns):
        for g in range(3):
            assert counts["grades"][k, g] == (held.grades == g).sum()
        others = [h.grades == 2 for i, h in enumerate(rows.limit_columns) if i != k]
        alone = (held.grades == 2) & ~np.any(others, axis=0)
        assert counts["alone"][k] == alone.sum()
    assert counts["alone"].sum() > 0


def test_every_variant_matches_its_own_check():
    rows = studied().rows
    moved = list(rows.names).index("shim_deg")
    for k in np.flatnonzero(rows.inputs[:, moved] == 0)[:12]:
        changes = {n: float(v) for n, v in zip(rows.names, rows.inputs[k], strict=True)}
        del changes["shim_deg"]
        alone = approve_driveline(overrides.change(application(), changes))
        assert rows.verdicts[k] == alone.verdict
        worst = min(c.margin for c in alone.checks)
        assert rows.margins[k] == pytest.approx(worst, rel=1e-9, abs=1e-9)


def test_quantiles_match_rows_within_stated_resolution():
    found = studied()
    state, number = found.statistics["values"], len(found.limits)
    for column in range(2 * number + 1):
        every = (
            found.rows.results.values[column] if column < number
            else found.rows.results.margins[column - number] if column < 2 * number
            else found.rows.margins
        )  # fmt: skip
        assert state["known"][column] == np.isfinite(every).sum()
        assert state["least"][column] == every.min()
        assert state["most"][column] == every.max()
        assert state["sum"][column] == pytest.approx(every.sum(), rel=1e-12)
        for share in (0.0, 0.01, 0.05, 0.5, 0.93, 1.0):
            exact = np.quantile(every, share, method="lower")
            assert quantile(state, column, share) == pytest.approx(
                exact, rel=1.01 * QUANTILE_RELATIVE_ERROR, abs=1e-11
            )


def test_worst_variants_are_listed_with_their_inputs():
    found, rows = studied(), studied().rows
    state = found.statistics["worst"]
    order = sorted(range(900), key=lambda k: (-rows.grades[k], rows.margins[k]))[:5]
    assert state["place"].tolist() == order
    np.testing.assert_array_equal(state["inputs"], rows.inputs[order])
    for k, limit in zip(order, state["limit"].tolist(), strict=True):
        assert rows.results.margins[limit, k] == rows.margins[k]


def test_parallel_coordinates_figure_shows_first_variants(monkeypatch):
    found, rows = studied(), studied().rows
    state = found.statistics["first"]
    np.testing.assert_array_equal(state["inputs"], rows.inputs[:300])
    np.testing.assert_array_equal(state["margin"], rows.margins[:300])
    np.testing.assert_array_equal(state["verdict"], rows.grades[:300])
    lines = {c: parallel_coordinates_figure(found).svg.count(c) for c in VERDICT_COLOURS.values()}
    told = [VERDICTS[v] for v in state["verdict"].tolist()]
    assert len(set(told)) > 1
    assert lines == {c: told.count(v) for v, c in VERDICT_COLOURS.items()}
    monkeypatch.setattr(
        presentation_figures, "MAX_PARALLEL_AXES", 1
    )  # the one that goes most with the margin
    told = [abs(np.corrcoef(rows.inputs[:300, k], rows.margins[:300])[0, 1]) for k in range(
        len(rows.names))]  # fmt: skip
    assert (
        f"1 {rows.names[int(np.argmax(told))]}, 2 smallest margin"
        in parallel_coordinates_figure(found).note
    )


def test_pareto_front_matches_brute_force():
    found, rows = studied(), studied().rows
    shim = list(rows.names).index("shim_deg")
    goals = np.stack([-rows.margins, np.abs(rows.inputs[:, shim]) / 3, rows.results.mass], axis=-1)
    goals[:, 1] = np.abs(np.round(rows.inputs[:, shim], 9)) / 3
    fit = rows.grades <= VERDICTS.index("warn")
    beaten = [
        any(((g <= one).all() and (g < one).any() and f) for g, f in zip(goals, fit, strict=True))
        or not may
        for one, may in zip(goals, fit, strict=True)
    ]
    state = found.statistics["pareto"]
    assert sorted(state["place"].tolist()) == np.flatnonzero(~np.array(beaten)).tolist()
    assert len(state["place"]) >= 3
    assert fit.sum() < len(fit)


def test_yield_map_counts_variants_of_each_cell():
    found, rows = studied(), studied().rows
    ((chart, state),) = found.maps
    columns = [list(rows.names).index(n) for n in ("shim_deg", "driveline.shafts[2].tube.wall_mm")]
    assert chart.shape == (3, 20)
    fit = np.isin(rows.verdicts, ["pass", "warn"])
    for i in range(3):
        for j in range(20):
            (a, b), (c, d) = chart.edges[0][i : i + 2], chart.edges[1][j : j + 2]
            x, y = rows.inputs[:, columns].T
            inside = (x >= a) & (x < b) & (y >= c) & ((y < d) | (j == 19))
            assert state["count"][i, j] == inside.sum()
            assert state["passes"][i, j] == (inside & fit).sum()
            if inside.any():
                assert state["least"][i, j] == rows.margins[inside].min()
                assert state["sum"][i, j] == pytest.approx(rows.margins[inside].sum())
    assert state["count"].sum() == 900


def test_yield_map_cell_is_labelled_with_its_choice():
    """Of 0, 30 and 90 the middle one stood at 37.5, half way between its neighbours' edges."""
    vary = {"phase_deg[2]": {"choice": [90, 0, 30]}, "shim_deg": [-1, 1]}
    ask = VariantOutputs(maps=(("phase_deg[2]", "shim_deg"),))
    found = run_study(application(), build_variants(vary, ask=ask), count=64)
    ((chart, state),) = found.maps
    assert chart.cell_centres[0] == (0, 30, 90)
    assert chart.cell_centres[1][:2] == pytest.approx((-0.95, -0.85))
    only = {k: np.where(np.arange(3)[:, None] == 1, v, 0) for k, v in state.items()}
    assert "Best at 30 and" in yield_map_figure(found, chart, only).alt


def test_wide_pareto_table_has_numbered_input_columns(monkeypatch):
    """Eleven names beside each other ran into one another on paper."""
    monkeypatch.setattr(presentation, "MAX_INPUT_COLUMNS", 3)
    vary = {"driveline.slopes.side_deg[*]": {"normal": 0.1}, "shim_deg": [-1, 1]}
    ask = VariantOutputs(pareto=("margin", "cost"))
    found = run_study(application(), build_variants(vary, ask=ask), count=64)
    varied, *_ = tables = list(result_tables(found))
    assert [row[0] for row in varied.rows][3:] == ["4 driveline.slopes.side_deg[4]", "5 shim_deg"]
    fronts = [t for t in tables if "no other variant beats" in t.caption]
    assert [t.head[-2:] for t in fronts] == [("2", "3"), ("4", "5")]
    assert all("by their numbers" in t.caption for t in fronts)
    state = found.statistics["pareto"]
    for table, last in zip(fronts, (2, 4), strict=True):
        row = table.rows[-1]
        assert row[0] == str(state["place"][-1])
        assert float(row[-1]) == pytest.approx(state["inputs"][-1, last], rel=1e-3)
    few = run_study(application(), build_variants({"shim_deg": [-1, 1]}, ask=ask), count=16)
    assert list(result_tables(few))[-1].head[-1] == "shim_deg"


def test_limit_is_drawn_at_start_of_its_range():
    """Of a limit from below the line stood at the range's other end."""
    angle = "  - {quantity: joint_angle_min, normal: 1, maximum: 0.5, source: ours}\n"
    limits = {m.quantity: m for m in reader.loads(LINE + angle).limits}
    below = list(_bands(limits["joint_angle_min"], 1.0, (0.0, 9.0)))
    above = list(_bands(limits["torsional_acceleration"], 1.0, (0.0, 900.0)))
    assert [b.line_at_high_end for b in below] == [True, True]
    assert [b.line_at_high_end for b in above] == [False, False]
    angle = limits["joint_angle_min"]
    assert [(b.low, b.high) for b in below] == [(angle.maximum, angle.normal), (0.0, angle.maximum)]


def test_tightening_without_gain_is_drawn_on_percent_axis():
    """Ticks of 2e-10 % stood under bars of none."""
    tolerances = {"driveline.shafts[*].length_mm": {"uniform": 0.1}}
    found = run_study(application(), build_variants({}, tolerances), count=40)
    svg = next(f for f in figures(found) if "halving" in f.title).svg
    assert "e-" not in "".join(re.findall(r"<text[^>]*>([^<]*)<", svg))


def test_shard_size_does_not_change_counts():
    variants = build_variants(VARY, TOLERANCES, ask=ASK)
    one = run_study(application(), variants, count=900, shard=900)
    for name, a in one.statistics["counts"].items():
        np.testing.assert_array_equal(a, studied().statistics["counts"][name])


# --------------------------------------------------------------------------- statistics


@pytest.mark.parametrize(
    ("share", "told"),
    [(1.0, "100.0 %"), (0.0, "0.0 %"), (0.8479, "84.8 %"), (1 - 1 / 8192, "99.99 %"),
     (1 / 8192, "0.01 %"), (0.1, "10.0 %"), (1e-6, "0.0001 %")],
)  # fmt: skip
def test_share_is_displayed_as_0_or_100_percent_only_if_exact(share, told):
    """One of 8192 that failed was told as 100.0 % that may be built."""
    assert percent_text(share, ENGLISH) == told


def test_confidence_and_quantile_levels_are_displayed_as_given():
    """A confidence of 99.5 % was told as 100 %, the quantile of 2.5 % as that of 2 %."""
    asked = build_variants({}, TOLERANCES, ask=VariantOutputs(confidence=0.995, quantiles=(0.025,)))
    told = "\n".join(terminal_lines(run_study(application(), asked, count=16)))
    assert "with 99.5 % confidence" in told
    assert "2.5 %" in told


def test_wilson_and_clopper_pearson_intervals_match_scipy():
    for hits, count in ((0, 20), (3, 20), (17, 40), (40, 40), (250, 1000)):
        test = stats.binomtest(hits, count)
        for ours, method in ((wilson_interval, "wilson"), (clopper_pearson_interval, "exact")):
            low, high = test.proportion_ci(0.9, method=method)
            found = ours(hits, count, confidence=0.9)
            assert found == pytest.approx((low, high), rel=1e-9, abs=1e-12)


@pytest.mark.slow
@pytest.mark.long
def test_yield_gain_of_halved_tolerance_matches_study():
    correlated = (("driveline.slopes.side_deg[1]", "driveline.slopes.side_deg[2]", 0.5),)
    plain = build_variants({}, TOLERANCES)
    for pairs in ((), correlated):
        asked = replace(plain, correlated=pairs)
        found = run_study(application(), asked, count=6000, shard=1000, seed=5)
        names = [found.sampling_plan.name_of(f) for f in found.sampling_plan.factors]
        share, error = halved_tolerance_yields(found.statistics["tighter"])
        gains = 0
        for t, name in enumerate(names):
            spread = found.sampling_plan.factors[t].spread
            half = VariedNumber(kind=spread.kind, values=(spread.values[0] / 2,))
            others = {n: f.spread for n, f in zip(names, found.sampling_plan.factors, strict=True)}
            again = run_study(
                application(), replace(asked, tolerances={**others, name: half}), count=6000,
                shard=2000, seed=6 + t,
            )  # fmt: skip
            scatter = (error[t, 0] ** 2 + again.yield_ * (1 - again.yield_) / 6000) ** 0.5
            assert abs(share[t, 0] - again.yield_) < 4 * scatter
            gains += again.yield_ - found.yield_ > 4 * scatter
        assert gains  # or nothing here could tell weights from ones


def test_reweighting_preserves_variant_count():
    factors = tuple(
        SampledVariable(input=k, spread=VariedNumber(kind=kind, values=(1.0,)), tolerance=True)
        for k, kind in enumerate(("normal", "uniform", "normal"))
    )
    lower = np.linalg.cholesky([[1, 0.5, 0.2], [0.5, 1, 0], [0.2, 0, 1]])
    drawn = SamplingPlan(
        names=tuple("abc"),
        nominal=(0.0,) * 3,
        factors=factors,
        correlation_factor=tuple(map(tuple, lower)),
        seed=2,
    )
    found = halved_tolerance_weights(drawn, drawn.unit_points(0, 100_000))
    error = found.std(0) / 100_000**0.5
    assert (abs(found.mean(0) - 1) < 5 * error).all()


class Made:
    """Rows of a function of three numbers, as a study would bring them."""

    def __init__(self, unit, function):
        self.count, self.inputs, self.unit = len(unit), unit, unit
        self.margins = function(unit)
        self.grades = np.where(self.margins > 0, 0, VERDICTS.index("fail"))
        self.results = type("A", (), {"margins": self.margins[None]})


def test_sobol_indices_match_ishigami_function():
    def ishigami(u):
        x = np.pi * (2 * u - 1)
        return np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])

    factors = tuple(
        SampledVariable(input=k, spread=VariedNumber(kind="range", values=(0.0, 1.0)))
        for k in range(3)
    )
    drawn = SamplingPlan(
        names=tuple("abc"), nominal=(0.0,) * 3, factors=factors, method="saltelli", seed=1
    )
    pairs = reduce.SobolSamplePairs(factors=3)
    step = 5 * 4000
    states = [
        pairs.shard_state(Made(drawn.unit_points(k, k + step), ishigami), k)
        for k in range(0, 5 * step, step)
    ]
    found = sobol_indices(functools.reduce(pairs.merge, states))
    # Exact: Ishigami & Homma (1990), with a = 7, b = 0.1.
    for ours, error, exact in (
        (found.first, found.first_error, (0.3139, 0.4424, 0.0)),
        (found.total, found.total_error, (0.5576, 0.4424, 0.2437)),
    ):
        assert (abs(ours[0] - exact) < 5 * error[0] + 1e-4).all()
        assert (error[0] < 0.02).all()


def test_study_sobol_indices_match_its_rows():
    ask = VariantOutputs(sobol=True, rows="float64")
    found = run_study(application(), build_variants({}, TOLERANCES, ask=ask), count=700, shard=210)
    d = len(found.sampling_plan.factors)
    y = found.rows.margins.reshape(-1, d + 2)
    a, b = y[:, 0], y[:, 1]
    variance = np.var(y[:, :2])
    indices = sobol_indices(found.statistics["sobol"])
    for k in range(d):
        first = ((b - y[:, :2].mean()) * (y[:, 2 + k] - a)).mean() / variance
        total = ((a - y[:, 2 + k]) ** 2).mean() / 2 / variance
        assert indices.first[0, k] == pytest.approx(first, rel=1e-9, abs=1e-12)
        assert indices.total[0, k] == pytest.approx(total, rel=1e-9)
    own = found.rows.independent
    assert own.sum() == found.independent_count == 2 * len(y)
    assert found.yield_ == np.isin(np.array(found.rows.verdicts)[own], ["pass", "warn"]).mean()


# --------------------------------------------------------------------------- what cannot be


def test_sobol_indices_of_constant_quantity_are_undefined():
    asked = build_variants({}, {"phase_deg[2]": {"uniform": 5}}, ask=VariantOutputs(sobol=True))
    found = run_study(application(), asked, count=300)
    assert np.isnan(
        sobol_indices(found.statistics["sobol"]).total[0]
    ).all()  # the joint's angle decides
    told = "\n".join(terminal_lines(found))
    assert "Sobol" in told
    assert "nan" not in told


@pytest.mark.slow
def test_non_array_parameter_is_read_anew_for_each_variant():
    spread = {
        "limits[1].maximum": {"choice": [300.0, 500.0]},
        "driveline.joints.peak_Nm": {"uniform": 500.0},
        "driveline.slopes.side_deg[2]": {"normal": 0.3},
    }
    more = LINE.replace(
        'joints: "1810"', "joints: {name: ours, peak_Nm: 6000, source: ours}"
    ).replace("normal: 350, ", "")
    own = reader.loads(
        more + "  - {quantity: joint_torque_utilisation, maximum: 1, source: ours}\n"
    )
    vary = {k: v for k, v in spread.items() if "choice" in v}
    scatter = {k: v for k, v in spread.items() if "choice" not in v}
    asked = build_variants(vary, scatter, ask=VariantOutputs(rows="float64"))
    found = run_study(own, asked, count=24, shard=8)
    assert set(found.evaluator.unvectorised_inputs) >= {"limits[1].maximum"}
    rows = found.rows
    for k in range(24):
        alone = approve_driveline(
            overrides.change(own, {v.name: float(v.values[k]) for v in rows.input_columns})
        )
        assert rows.verdicts[k] == alone.verdict
        assert rows.margins[k] == pytest.approx(min(c.margin for c in alone.checks), rel=1e-9)
    assert len(set(rows.verdicts)) > 1


def test_varying_limit_is_attributed_to_its_own_limit():
    """A joint's cap that left those of its like was told of the limit behind it, or of none."""
    joints = "[{name: a, angle_max_deg: 5}, {name: b, angle_max_deg: 5}, {name: c}]"
    text = LINE.replace('"1810"', joints).replace("normal: 350, ", "") + (
        "  - {quantity: end_angle_difference, maximum: 1, source: ours}\n"
    )
    other = "driveline.joints[2].angle_max_deg"
    vary = {
        other: {"choice": [2.0, 5.0]}, "limits[1].maximum": {"choice": [30.0, 500.0]},
        "driveline.slopes.side_deg[4]": [1.9, 2.1],
    }  # fmt: skip
    own = reader.loads(text)
    found = run_study(own, build_variants(vary, ask=VariantOutputs(rows="float64")), count=16)
    rows, seen = found.rows, set()
    for k in range(16):
        numbers = {v.name: float(v.values[k]) for v in rows.input_columns}
        alone = approve_driveline(overrides.change(own, numbers))
        for place, (_, limit) in enumerate(found.limits):
            mine = [
                c
                for c in alone.checks
                if c.quantity == limit.quantity and c.limit.source == limit.source
            ]
            worst = min(mine, key=worst_first_key)
            assert CHECK_GRADES[rows.results.grades[place, k]] == worst.grade
            assert rows.results.values[place, k] == pytest.approx(worst.value)
            left = min(c.limit.margin(c.value, to="maximum") for c in mine)
            assert rows.results.left[place, k] == pytest.approx(left)
            seen.add((limit.quantity, worst.grade))
    assert {("joint_angle", "fail"), ("joint_angle", "pass")} <= seen
    assert {("torsional_acceleration", "fail"), ("torsional_acceleration", "pass")} <= seen


@pytest.mark.slow
def test_infeasible_variants_fail_and_are_reported():
    # A bearing 140 mm ahead of its joint needs a shaft longer than that.
    asked = build_variants({}, {"driveline.shafts[1].length_mm": {"normal": 800}}, ask=ASK)
    found = run_study(application(), replace(asked, ask=replace(ASK, maps=())), count=200, shard=64)
    rows = found.rows
    lengths = rows.inputs[:, 0]
    assert (rows.results.infeasible >= (lengths <= 140)).all()
    assert 5 < rows.results.infeasible.sum() < 100
    assert found.statistics["counts"]["refused"] == rows.results.infeasible.sum()
    assert all(VERDICTS[g] == "fail" for g in rows.grades[rows.results.infeasible])
    assert "length" in str(found.statistics["worst"]["why"][0])
    fine = np.flatnonzero(~rows.results.infeasible)[0]
    alone = approve_driveline(
        overrides.change(application(), {rows.names[0]: float(lengths[fine])})
    )
    assert rows.verdicts[fine] == alone.verdict
    assert (rows.results.grades[:, rows.results.infeasible] == UNEVALUATED_GRADE_CODE).all()


def test_sobol_report_states_number_of_feasible_groups():
    """Groups in which a variant cannot exist fell out of a margin's indices, and nobody said so."""
    wide = {"driveline.shafts[1].length_mm": {"normal": 800}}
    found = run_study(
        application(),
        build_variants({}, wide, ask=VariantOutputs(sobol=True, rows="float64")),
        count=96,
    )
    refused = found.rows.results.infeasible.reshape(-1, 3)
    known = int((~refused.any(axis=1)).sum())
    assert known < 32
    assert f"among the {known} of 32 groups" in "\n".join(terminal_lines(found))


def test_infeasible_range_end_is_rejected():
    wall = "driveline.shafts[2].tube.wall_mm"
    with pytest.raises(
        InvalidFileError, match=r"wall_mm: cannot be -1, up to where .*: must be a number"
    ):
        VariantEvaluator.from_application(application(), build_variants({wall: [-1, 4]}))
    # What stands in the way may be another number, which nobody changed.
    told = r"length_mm: cannot be 120, up to where .*must sit on its shaft"
    with pytest.raises(InvalidFileError, match=told):
        VariantEvaluator.from_application(
            application(), build_variants({"driveline.shafts[1].length_mm": [120, 900]})
        )


@pytest.mark.parametrize(
    ("written", "told"),
    [
        ("tolerances: {shim_deg: 0.2}", ":1:24: .*must be a table with normal, uniform "),
        ("tolerances: {shim_deg: {grid: [0, 1, 3]}}", ":1:25: .*there are: normal, uniform"),
        ("vary: {shim_deg: [-1, 1]}\nask: {quantiles: 5}", ":2:18: .*above 0 and below 1 "),
        ('vary:\n  "driveline.shafts[*].tube.wall_mm": [-1, 4]',
         r":2:3: vary.driveline.shafts\[1\].tube.wall_mm: cannot be -1, up to where"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("inside", [False, True])
def test_study_range_errors_name_file_and_line(tmp_path, written, told, inside):
    """A range beyond what is allowed was told of the application's file, without a line."""
    (tmp_path / "truck.yaml").write_text(LINE)
    (tmp_path / "study.yaml").write_text(written + "\n")
    arguments = ["--study", str(tmp_path / "study.yaml")]
    if inside:
        under = "".join(f"  {line}\n" for line in written.splitlines())
        (tmp_path / "truck.yaml").write_text("study:\n" + under + LINE)
        line, column = re.search(r"(\d+):(\d+)", told).groups()
        told = told.replace(f"{line}:{column}", f"{int(line) + 1}:{int(column) + 2}", 1)
        told, arguments = told.replace("vary.driveline", "(study.)?vary.driveline"), []
    found = CliRunner().invoke(cli, ["study", str(tmp_path / "truck.yaml"), *arguments])
    assert found.exit_code == 2
    assert re.search(f"{'truck' if inside else 'study'}.yaml{told}", found.output), found.output


# --------------------------------------------------------------------------- who computes


def stored(folder: Path) -> set[int]:
    """Return the shards that a folder holds."""
    return {e.about["shard"] for e in log_entries(folder / SHARD_LOG_FILE_NAME) if e}


def same(one: VariantStudyResult, other: VariantStudyResult) -> None:
    """Hold two studies against each other, to the last bit."""
    assert one.statistics.keys() == other.statistics.keys()
    for name, state in one.statistics.items():
        for array, value in state.items():
            np.testing.assert_array_equal(value, other.statistics[name][array], f"{name}.{array}")


@pytest.mark.slow
def test_threads_and_processes_give_identical_results():
    variants = build_variants(VARY, TOLERANCES, ask=replace(ASK, rows=None))
    alone = run_study(application(), variants, count=300, shard=60)
    same(alone, run_study(application(), variants, count=300, shard=60, workers=3))
    with open_executor("processes", 2) as pool:
        same(
            alone, run_study(application(), variants, count=300, shard=60, executor=pool, workers=2)
        )


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="has no such signal")
def test_killed_worker_process_is_reported_and_finished_shards_are_kept(tmp_path):
    variants = build_variants(VARY, TOLERANCES, ask=ASK)
    whole = run_study(application(), variants, count=600, shard=60)

    def kill(progress):
        if progress.done == 60:
            active_children()[0].kill()

    with (
        pytest.raises(CardanError, match=r"a process that computed a shard was killed; .*--resume"),
        open_executor("processes", 1) as pool,
    ):
        run_study(
            application(), variants, count=600, shard=60, folder=tmp_path, executor=pool, hear=kill
        )
    same(
        whole, run_study(application(), variants, count=600, shard=60, folder=tmp_path, resume=True)
    )


class KillsItsProcess:
    """Ends the process that pickles it, as one killed half-way through what it writes."""

    def __reduce__(self):
        os.kill(os.getpid(), signal.SIGKILL)


def cut_short():
    return [bytes(1 << 20), KillsItsProcess()]


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="has no such signal")
def test_process_killed_while_it_writes_its_result_does_not_block():
    with ProcessExecutor(2) as pool:
        killed = pool.submit(cut_short)
        assert isinstance(killed.exception(timeout=120), BrokenExecutor)


@pytest.mark.skipif(os.name == "nt", reason="has no pipes of this kind")
def test_result_of_worker_process_goes_through_pipe_whole(tmp_path):
    """Half a message would leave whoever reads the pipe waiting; one this short cannot be cut."""
    sent = pickle.dumps(_call_to_file(str(tmp_path), bytes, (1 << 20,), {}))
    assert len(sent) < select.PIPE_BUF
    assert pickle.loads(sent) == bytes(1 << 20)
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_invalid_file_error_of_worker_process_is_reported():
    error = InvalidFileError("truck.yaml", (FileIssue(message="is wrong", line=3, column=1),))
    with ProcessExecutor(1) as pool, pytest.raises(InvalidFileError, match=r"truck\.yaml:3:1"):
        pool.submit(raise_error, error).result()


def raise_error(error):
    raise error


@pytest.mark.slow
def test_worker_process_error_has_its_traceback_as_cause():
    with ProcessExecutor(1) as pool, pytest.raises(ZeroDivisionError) as told:
        pool.submit(divmod, 1, 0).result()
    assert "fn(*args, **kwargs)" in str(told.value.__cause__)
    with ProcessExecutor(1) as pool, pytest.raises(TypeError, match="code"):
        pool.submit(compile, "lambda: 0", "", "eval").result()


ORPHANED = """
import time
from concurrent.futures import wait
from cardan.topics.variants.executors import open_executor
if __name__ == "__main__":
    with open_executor("processes", 2) as pool:
        wait([pool.submit(time.sleep, 0.1) for _ in range(2)])
        print("both wait", flush=True)
        time.sleep(600)
"""


def test_worker_processes_end_with_their_parent(tmp_path):
    (tmp_path / "hand.py").write_text(ORPHANED)
    with subprocess.Popen([sys.executable, tmp_path / "hand.py"], stdout=subprocess.PIPE) as run:
        assert run.stdout
        assert run.stdout.readline().strip() == b"both wait"
        run.kill()
        run.communicate(timeout=30)  # the pipe's end is the end of all who hold it


@pytest.mark.slow
def test_resumed_study_gives_identical_results(tmp_path):
    variants = build_variants(VARY, TOLERANCES, ask=ASK)
    whole = run_study(application(), variants, count=600, shard=60, folder=tmp_path / "whole")

    def stop(progress):
        if progress.done >= 180:
            raise KeyboardInterrupt

    with pytest.raises(StudyInterrupted) as stopped:
        run_study(application(), variants, count=600, shard=60, folder=tmp_path / "cut", hear=stop)
    assert 180 <= stopped.value.result.count < 600
    before = stored(tmp_path / "cut")
    told = []
    again = run_study(
        application(), variants, count=600, shard=60, folder=tmp_path / "cut", resume=True,
        hear=told.append,
    )  # fmt: skip
    same(whole, again)
    assert told[0].done_before == 60 * len(before)
    names = sorted(p.name for p in (tmp_path / "whole").iterdir())
    assert names == sorted(p.name for p in (tmp_path / "cut").iterdir())
    for name in names:
        assert (tmp_path / "whole" / name).read_bytes() == (tmp_path / "cut" / name).read_bytes()
    # More variants of the same study need only the new ones.
    more = run_study(
        application(), variants, count=900, shard=60, folder=tmp_path / "cut", resume=True
    )
    same(more, run_study(application(), variants, count=900, shard=60))


@pytest.mark.slow
def test_study_folder_of_another_study_is_rejected(tmp_path):
    variants = build_variants({}, TOLERANCES)
    run_study(application(), variants, count=20, folder=tmp_path)
    with pytest.raises(CardanError, match="holds a study already"):
        run_study(application(), variants, count=20, folder=tmp_path)
    with pytest.raises(CardanError, match=r"holds another study, with other .*seed"):
        run_study(application(), variants, count=20, folder=tmp_path, resume=True, seed=1)
    other = reader.loads(LINE.replace("3000", "3001"))
    with pytest.raises(CardanError, match="with other application: name another folder"):
        run_study(other, variants, count=20, folder=tmp_path, resume=True)
    other = reader.loads(LINE.replace("maximum: 500", "maximum: 501"))
    with pytest.raises(CardanError, match="with other application, limits: name another"):
        run_study(other, variants, count=20, folder=tmp_path, resume=True)
    asked = replace(variants, ask=VariantOutputs(quantiles=(0.5,)))
    with pytest.raises(CardanError, match="with other vary, tolerances or ask: name another"):
        run_study(application(), asked, count=20, folder=tmp_path, resume=True)
    # Fewer would leave variants lying there that nothing is told of.
    with pytest.raises(CardanError, match=r"holds 20 variants, more than 19: .*\(--n 20\)"):
        run_study(application(), variants, count=19, folder=tmp_path, resume=True)
    for broken in ("", "[]", "{}"):
        (tmp_path / MANIFEST_FILE_NAME).write_text(broken)
        with pytest.raises(CardanError, match=r"manifest\.json is none of this version's"):
            run_study(application(), variants, count=20, folder=tmp_path, resume=True)
    # Shards of a study that nobody names were told as those of the next one.
    (tmp_path / MANIFEST_FILE_NAME).unlink()
    for resume in (False, True):
        with pytest.raises(CardanError, match=r"holds shards, but no manifest\.json says of which"):
            run_study(other, variants, count=20, folder=tmp_path, resume=resume)


@pytest.mark.slow
@pytest.mark.parametrize("bytes_", [0, 300])
def test_truncated_shards_and_lost_rows_are_recomputed(tmp_path, bytes_):
    variants = build_variants({}, TOLERANCES, ask=VariantOutputs(rows="float64"))
    run_study(application(), variants, count=80, shard=20, folder=tmp_path)
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}
    first, second, *_ = log_entries(tmp_path / SHARD_LOG_FILE_NAME)
    whole = bytearray(before[SHARD_LOG_FILE_NAME])
    whole[first.length // 2] ^= 0xFF
    del whole[second.offset + bytes_ : second.offset + second.length]
    (tmp_path / SHARD_LOG_FILE_NAME).write_bytes(whole)
    (rows,) = tmp_path.glob("rows-000002.*")
    rows.unlink()
    (rows,) = tmp_path.glob("rows-000003.*")
    rows.write_bytes(before[rows.name][:bytes_])
    told = []
    run_study(
        application(), variants, count=80, shard=20, folder=tmp_path, resume=True, hear=told.append
    )
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before
    # Where one is gone without a trace nothing is damaged.
    assert told[0].damaged == (4 if bytes_ else 3)


def test_study_resumes_from_a_log_that_ends_anywhere(tmp_path):
    variants = build_variants({}, TOLERANCES)
    whole = run_study(application(), variants, count=80, shard=20, folder=tmp_path)
    path = tmp_path / SHARD_LOG_FILE_NAME
    before, told = path.read_bytes(), []
    ends = [e.offset + e.length for e in log_entries(path)]
    assert len(ends) == 4
    for size in (0, 1, ends[0] - 1, ends[0], ends[1] + 60, ends[3] - 1):
        path.write_bytes(before[:size])
        again = run_study(
            application(), variants, count=80, shard=20, folder=tmp_path, resume=True,
            hear=told.append,
        )  # fmt: skip
        same(whole, again)
        assert path.read_bytes() == before
        at = next(p for p in told if p.done == p.done_before)
        assert at.done_before == 20 * sum(end <= size for end in ends)
        assert at.damaged == (size not in (0, *ends))
        told.clear()


def test_log_that_another_run_changed_is_not_read(tmp_path):
    variants = build_variants({}, TOLERANCES)
    path = tmp_path / SHARD_LOG_FILE_NAME

    def meddle(progress):
        if progress.done == 80:
            first, second, *_ = log_entries(path)
            log = path.read_bytes()
            path.write_bytes(log[second.offset :] + log[: first.length])

    with pytest.raises(CardanError, match=r"shards\.log was changed by another run: end that"):
        run_study(application(), variants, count=80, shard=20, folder=tmp_path, hear=meddle)


@pytest.mark.slow
def test_shards_that_differ_from_their_digest_are_recomputed(tmp_path):
    """Rows of the right number, and statistics that read well, were taken as they were."""
    variants = build_variants({}, TOLERANCES, ask=VariantOutputs(rows="float64"))
    run_study(application(), variants, count=80, shard=20, folder=tmp_path)
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}
    (rows,) = tmp_path.glob("rows-000000.*")
    changed = bytearray(before[rows.name])
    changed[len(changed) // 3] ^= 1
    rows.write_bytes(changed)
    log = bytearray(before[SHARD_LOG_FILE_NAME])
    _, second, third, _ = log_entries(tmp_path / SHARD_LOG_FILE_NAME)
    log[second.offset + 8] ^= 1  # its length
    log[third.offset + third.length - 1] ^= 1  # its content
    (tmp_path / SHARD_LOG_FILE_NAME).write_bytes(log)
    (rows,) = tmp_path.glob("rows-000003.*")
    other = rows.with_name(rows.name.replace("3", "2"))
    rows.write_bytes(before[other.name])  # whole, and of another shard
    told = []
    run_study(
        application(), variants, count=80, shard=20, folder=tmp_path, resume=True, hear=told.append
    )
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before
    assert (told[0].damaged, told[0].done_before) == (4, 0)
    assert "4 shards of here are damaged" in damaged_shards_text(4, "here")


OURS = """
profile: ours
limits:
  - {quantity: joint_angle, unit: deg, maximum: 3.7, source: ours}
"""


def test_changed_limits_file_stops_running_study(tmp_path):
    (tmp_path / "ours.yaml").write_text(OURS)
    (tmp_path / "line.yaml").write_text(LINE[: LINE.index("limits:")] + "limits: ours.yaml\n")
    truck, variants = reader.read(tmp_path / "line.yaml"), build_variants({}, TOLERANCES)

    def meddle(progress):
        if progress.done:
            (tmp_path / "ours.yaml").write_text(OURS.replace("3.7", "3.75"))

    with pytest.raises(CardanError, match="files that it names changed while the study ran"):
        run_study(truck, variants, count=60, shard=20, folder=tmp_path / "o", hear=meddle)
    changed = reader.read(tmp_path / "line.yaml")
    with pytest.raises(CardanError, match="with other limits, files that it names: name"):
        run_study(changed, variants, count=60, shard=20, folder=tmp_path / "o", resume=True)


def test_remote_worker_finds_files_and_reports_differing_ones(tmp_path, monkeypatch):
    """As in another folder of a cluster: a path that goes from here leads nowhere there."""
    (tmp_path / "ours.yaml").write_text(OURS)
    (tmp_path / "line.yaml").write_text(LINE[: LINE.index("limits:")] + "limits: ours.yaml\n")
    monkeypatch.chdir(tmp_path)
    job = ShardJob.from_study(reader.read(Path("line.yaml")), build_variants({}, TOLERANCES))
    here = job.run_shard(0, 20)
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    _evaluator_of.cache_clear()
    there = job.run_shard(0, 20)
    np.testing.assert_array_equal(
        here.statistics["counts"]["grades"], there.statistics["counts"]["grades"]
    )
    assert not there.statistics["counts"]["refused"]
    _evaluator_of.cache_clear()
    (tmp_path / "ours.yaml").write_text(OURS.replace("3.7", "3.75"))
    with pytest.raises(CardanError, match="a worker has other files that it names than where"):
        job.run_shard(0, 20)
    (tmp_path / "ours.yaml").unlink()
    with pytest.raises(
        CardanError, match=r"ours.yaml, which the application names, cannot be read"
    ):
        job.run_shard(0, 20)


def test_grid_without_tolerances_is_evaluated_once():
    grid = {"driveline.slopes.side_deg[1]": {"grid": [2.0, 4.0, 5]}}
    found = run_study(application(), build_variants({**grid}), count=1000)
    assert (found.count, found.sampling_plan.group_size) == (5, 5)
    # With something drawn each round of the grid is another.
    assert (
        run_study(application(), build_variants({**grid, "shim_deg": [-1, 1]}), count=12).count
        == 15
    )


def test_infeasible_variants_are_not_listed_as_worst():
    """Nothing decides it: it named the first limit, with an infinite margin."""
    wild = {"driveline.shafts[1].centre_bearing.from_rear_joint_mm": {"normal": 900.0}}
    found = run_study(
        application(), build_variants({}, wild, ask=VariantOutputs(worst=40)), count=40
    )
    refused = int(found.statistics["counts"]["refused"])
    assert 0 < refused < 40
    told = json_document(found)["worst"]
    assert len(told) == 40 - refused
    assert all(np.isfinite(one["margin"]) for one in told)


@pytest.mark.slow
def test_rows_are_stored_in_requested_precision(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    asked = build_variants(VARY, TOLERANCES, ask=replace(ASK, rows="float32"))
    run_study(application(), asked, count=300, shard=150, folder=tmp_path)
    tables = [parquet.read_table(p) for p in sorted(tmp_path.glob("rows-*.parquet"))]
    assert sum(t.num_rows for t in tables) == 300
    assert str(tables[0].schema.field("margin").type) == "float"
    found = run_study(application(), build_variants(VARY, TOLERANCES, ask=ASK), count=300).rows
    np.testing.assert_array_equal(
        np.concatenate([t["margin"] for t in tables]), found.margins.astype("float32")
    )


PRINTS = """
import sys
from pathlib import Path
from cardan.application import overrides, reader
from cardan.topics.variants.shard_job import ShardJob
from cardan.topics.variants.evaluation import build_variants
for path in map(Path, sys.argv[1:]):
    variants = build_variants({}, {"driveline.points_mm[*]": {"normal": 1.0}})
    print(ShardJob.from_study(reader.read(path), variants).fingerprints)
"""


@pytest.mark.slow
def test_study_fingerprint_is_identical_across_processes():
    """Sets of words, as the states that a limit is for, have an order of the process's own."""
    trucks = sorted(EXAMPLES.glob("*.yaml"))
    assert any(limit.states for limit in reader.read(trucks[0]).limits)
    prints = {
        subprocess.run(
            [sys.executable, "-c", PRINTS, *map(str, trucks)], check=True, text=True,
            stdout=subprocess.PIPE, env=os.environ | {"PYTHONHASHSEED": seed},
        ).stdout
        for seed in ("1", "2")
    }  # fmt: skip
    assert len(prints) == 1
    assert len(set(prints.pop().splitlines())) == len(trucks)


KILLED = """
import sys
from pathlib import Path
from cardan.application import overrides, reader
from cardan.model.variants import VariantOutputs
from cardan.topics.variants.runner import run_study
from cardan.topics.variants.evaluation import build_variants
text, folder = Path(sys.argv[1]).read_text(), Path(sys.argv[2])
app = reader.loads(text)
asked = build_variants({}, {"driveline.slopes.side_deg[*]": {"normal": 0.2}},
    ask=VariantOutputs(rows="float64"))
run_study(app, asked, count=800, shard=20, folder=folder, resume=folder.exists())
"""


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="has no such signal")
@pytest.mark.parametrize("shards_before", [1, 4, 9])
def test_study_killed_at_any_moment_resumes_identically(tmp_path, shards_before):
    (tmp_path / "line.yaml").write_text(LINE)
    command = [sys.executable, "-c", KILLED, str(tmp_path / "line.yaml"), str(tmp_path / "out")]
    run = subprocess.Popen(command)
    deadline = time.monotonic() + 60
    while len(stored(tmp_path / "out")) < shards_before:
        assert time.monotonic() < deadline
        time.sleep(0.002)
    os.kill(run.pid, signal.SIGKILL)
    assert run.wait() == -signal.SIGKILL
    done = len(stored(tmp_path / "out"))
    assert shards_before <= done < 40
    subprocess.run(command, check=True)
    asked = build_variants(
        {}, {"driveline.slopes.side_deg[*]": {"normal": 0.2}}, ask=VariantOutputs(rows="float64")
    )
    run_study(application(), asked, count=800, shard=20, folder=tmp_path / "whole")
    for path in sorted((tmp_path / "whole").iterdir()):
        assert path.read_bytes() == (tmp_path / "out" / path.name).read_bytes(), path.name


def test_shard_job_survives_pickling():
    job = ShardJob.from_study(application(), build_variants({}, TOLERANCES), seed=1)
    there = pickle.loads(pickle.dumps(job))
    a, b = job.run_shard(0, 30), there.run_shard(0, 30)
    np.testing.assert_array_equal(
        a.statistics["counts"]["grades"], b.statistics["counts"]["grades"]
    )


def test_manifest_describes_study_folder(tmp_path):
    run_study(application(), build_variants({}, TOLERANCES), count=20, folder=tmp_path, seed=7)
    found = json.loads((tmp_path / MANIFEST_FILE_NAME).read_text())
    assert (found["seed"], found["title"]) == (7, "Two-piece driveline")
    assert found["inputs"][:2] == ["driveline.slopes.side_deg[1]", "driveline.slopes.side_deg[2]"]


# --------------------------------------------------------------------------- in a file


STUDY = """
study:
  vary:
    shim_deg: [-2, 2]
    phase_deg[2]: {choice: [0, 90]}
    driveline.shafts[2].tube.wall_mm: {grid: [3, 5, 3]}
  tolerances:
    driveline.slopes.side_deg[*]: {normal: 0.1}
    driveline.shafts[1].length_mm: {uniform: 2}
  correlated:
    - {between: ["driveline.slopes.side_deg[1]", "driveline.slopes.side_deg[2]"], correlation: 0.5}
  ask: {quantiles: [0.95, 0.05], worst: 2, maps: [[shim_deg, "phase_deg[2]"]], rows: float32}
"""


def test_study_is_read_from_application_or_separate_file(tmp_path):
    inside = reader.loads(LINE + STUDY).variants
    assert inside.vary["shim_deg"] == VariedNumber(kind="range", values=(-2, 2))
    assert inside.vary["driveline.shafts[2].tube.wall_mm"].values == (3, 4, 5)
    assert inside.tolerances["driveline.shafts[1].length_mm"] == VariedNumber(
        kind="uniform", values=(2,)
    )
    assert inside.ask.quantiles == (0.05, 0.95)
    for text in (STUDY, STUDY.replace("study:\n", "").replace("\n  ", "\n")):
        (tmp_path / "study.yaml").write_text(text)
        assert read_study(tmp_path / "study.yaml", application()) == inside
    assert application().variants is None


SHAFT = "driveline.shafts[1].length_mm"


@pytest.mark.parametrize(
    ("was", "now", "told"),
    [
        ("shim_deg: [-2, 2]", "shim_dg: [-2, 2]",
         "22:5: study.vary.shim_dg: no number has this address; did you mean shim_deg?"),
        ("[-2, 2]", "[2, -2]",
         "22:15: study.vary.shim_deg: must rise (got [2, -2]); put the lowest first"),
        ("{uniform: 2}", "{uniform: -2}",
         f"27:46: study.tolerances.{SHAFT}.uniform: must be a number above 0 (got -2)"),
        ("{uniform: 2}", "{unform: 2}",
         f"study.tolerances.{SHAFT}.unform: unknown key; did you mean uniform?"),
        ("[3, 5, 3]", "[3, 5, 1]",
         "wall_mm.grid: must be [lowest, highest, how many], of 2 to 200"),
        ("[-2, 2]", '{grid: [-2, 2, 200]}\n    "driveline.slopes.side_deg[*]": {grid: [1, 2, 4]}',
         "study.vary: grids of 200 × 4 × 4 × 4 × 4 × 3 places are 153600 variants, of 100000"),
        # Of a number named twice, or a pair tied twice, what stood last counted.
        ("driveline.shafts[1].length_mm: {u", "driveline.slopes.side_deg[2]: {u",
         "27:5: study.tolerances.driveline.slopes.side_deg[2]: driveline.slopes.side_deg[2] goes "
         "by driveline.slopes.side_deg[*] too; name each number once"),
        ("correlation: 0.5}", 'correlation: 0.5}\n    - between: ["driveline.slopes.side_deg[*]", '
         '"driveline.slopes.side_deg[1]"]\n      correlation: 0',
         "30:7: study.correlated[2]: driveline.slopes.side_deg[1] and driveline.slopes.side_deg[2] "
         "have a correlation already; keep one"),
        ("correlation: 0.5", "correlation: 1.5",
         "must be a number above -1 and below 1 (got 1.5)"),
        ('"driveline.slopes.side_deg[2]"]', '"axle.ratio"]',
         "29:7: study.correlated[1]: there is no such tolerance (got axle.ratio)"),
        ('[[shim_deg, "phase_deg[2]"]]', '[[shim_deg, "phase_deg[1]"]]',
         "30:3: study.ask: maps: this does not vary (got phase_deg[1])"),
        ("worst: 2", "pareto: [margin, mass, margin]",
         "30:57: study.ask.pareto[3]: is weighed already (got margin); name each once"),
        ('[[shim_deg, "phase_deg[2]"]]', '[["driveline.slopes.side_deg[*]", '
         '"driveline.slopes.side_deg[1]"]]',
         "30:3: study.ask: maps: both axes are the same number (got driveline.slopes.side_deg[*], "
         "driveline.slopes.side_deg[1]); name two"),
        ("worst: 2", "yield_only: true",
         "30:46: study.ask.yield_only: reports nothing but the yield; remove quantiles, maps, "
         "rows"),
        ("worst: 2", "worst: 0",
         "study.ask.worst: must be a whole number from 1 to 1000"),
        ("rows: float32", "rows: float16",
         "study.ask.rows: must be one of float32, float64 (got float16)"),
    ],
)  # fmt: skip
def test_study_table_errors_name_key_and_line(was, now, told):
    text = LINE + STUDY.replace(was, now, 1)
    assert text != LINE + STUDY
    with pytest.raises(InvalidFileError) as error:
        reader.loads(text, name="line.yaml")
    assert told in str(error.value)


def test_repeated_pareto_goal_is_rejected():
    with pytest.raises(ValueError, match="pareto weighs each once, against others, got mass, mass"):
        cardan.study(application(), {"shim_deg": [-1, 1]}, n=8, pareto=("mass", "mass"))


def test_yield_map_of_several_parts_uses_first_part():
    names = ("a[10]", "a[2]", "b")
    spread = VariedNumber(kind="normal", values=(1.0,))
    drawn = SamplingPlan(
        names=names, nominal=(0.0,) * 3,
        factors=tuple(SampledVariable(input=k, spread=spread, tolerance=True) for k in range(3)),
    )  # fmt: skip
    assert reduce.YieldMap.for_pair(("a[*]", "b"), drawn).columns == (1, 2)


def test_study_json_schema_accepts_gallery_study():
    jsonschema = pytest.importorskip("jsonschema")
    described = json.loads(CliRunner().invoke(cli, ["schema", "--study"]).stdout)
    gallery = ROOT / "docs" / "gallery" / "tolerances.yaml"
    asked = yaml.safe_load(gallery.read_text(encoding="utf-8"))
    check = jsonschema.Draft202012Validator(described)
    for whole in (asked, {"study": asked}, yaml.safe_load(STUDY)):
        assert check.is_valid(whole)
    for wrong in (
        asked | {"askk": {}},
        asked | {"tolerances": {"shim_deg": {"normal": -1}}},
        asked | {"ask": {"foretold": 0}},
        {"study": asked, "title": "no application"},
    ):
        assert not check.is_valid(wrong)


def test_study_without_variables_is_rejected():
    with pytest.raises(InvalidFileError, match="needs vary or tolerances"):
        reader.loads(LINE + "study: {ask: {worst: 3}}\n")


def test_limit_columns_have_unique_names_and_known_grades():
    found = evaluate_variants(application(), {"shim_deg": [-1, 1]}, count=16)
    names = [name for name, _ in found.named_limit_columns()]
    assert len(set(names)) == len(names)
    assert {CHECK_GRADES[g] for g in found.limit_columns[0].grades} <= set(CHECK_GRADES)


# --------------------------------------------------------------------------- the command


def asked(tmp_path, *options, study_text=STUDY):
    (tmp_path / "line.yaml").write_text(LINE + study_text)
    said = () if "--n" in options else ("--n", 90)
    return CliRunner().invoke(
        cli, ["study", str(tmp_path / "line.yaml"), *map(str, (*said, *options))]
    )


def test_study_command_prints_and_writes_reports(tmp_path):
    run = asked(tmp_path, "--all", "--html", tmp_path / "a.html", "--json", tmp_path / "a.json")
    assert run.exit_code == 0, run.output
    for said in (
        "Two-piece driveline: 90 variants", "May be built (approved, also with warnings)",
        "What varies",
        "Which tolerance to tighten first", "The worst variants", "quantile",
    ):  # fmt: skip
        assert said in run.output
    document = json.loads((tmp_path / "a.json").read_text())
    assert document["variants"] == 90
    low, high = document["yield"]["clopper_pearson"]
    assert low <= document["yield"]["share"] <= high
    assert sum(document["shares"].values()) == pytest.approx(1)
    assert len(document["halved_tolerances"]) == 5
    page = (tmp_path / "a.html").read_text()
    assert page.count("<svg") >= 4
    again = asked(tmp_path, "--json")
    assert json.loads(again.stdout) == document


def test_study_command_prints_one_screen(tmp_path):
    text = STUDY.replace("rows: float32", "sobol: true, pareto: [margin, cost]")
    text = text.replace(text[text.index("  correlated:") : text.index("  ask:")], "")
    screens: dict[str, list[str]] = {}
    for lang in LANGUAGE_CODES:
        run = asked(
            tmp_path, "--lang", lang, "--n", 140, "--json", tmp_path / "a.json", study_text=text
        )
        assert run.exit_code == 0, run.output
        lines = screens[lang] = run.stdout.splitlines()
        assert len(lines) <= 32
        assert max(map(len, lines)) <= 80
    document = json.loads((tmp_path / "a.json").read_text())
    lines, said = screens["en"], " ".join(" ".join(screens["en"]).split())
    assert lines[0].split("  ")[0] == "Two-piece driveline"
    assert lines[0].endswith(f"{100 * document['yield']['share']:.1f} % may be built")
    failing = [one for one in document["limits"] if one["shares"]["fail"] > 0]
    assert len([line for line in lines if line.startswith("X  ")]) == len(failing) > 0
    for part in (
        "Evaluated: 140 variants; criteria:", "What varies:", "Variance of smallest margin (Sobol",
        "Worst variant:", "variants that no other beats (--all)", "Next: cardan study FILE --all",
    ):  # fmt: skip
        assert part in said
    for lang in LANGUAGE_CODES[1:]:
        assert {line for line in lines if re.search("[a-z]{4} ", line)} & set(
            screens[lang]
        ) == set()


def test_study_of_the_yield_alone_has_no_tables_of_limits(tmp_path):
    text = STUDY[: STUDY.index("  ask:")]
    asked(tmp_path, "--json", tmp_path / "whole.json", study_text=text)
    text += "  ask: {yield_only: true}\n"
    for lang in LANGUAGE_CODES:
        files = "--json", tmp_path / "a.json", "--html", tmp_path / "a.html"
        for option in ((), ("--all",)):
            run = asked(tmp_path, "--lang", lang, *option, *files, study_text=text)
            assert run.exit_code == 0, run.output
            said = " ".join(run.stdout.split())
            assert ("Limits and variants have no table." in said) == (lang == "en")
    whole, found = (json.loads((tmp_path / f"{n}.json").read_text()) for n in ("whole", "a"))
    assert found["shares"] == whole["shares"]
    assert found["yield"].pop("not_evaluated_on_rubber") == 0
    assert found["yield"] == whole["yield"]
    assert found["halved_tolerances"] == whole["halved_tolerances"]
    assert found["limits"] == found["worst"] == []


def test_stopped_study_says_so_at_the_top_of_its_screen():
    study = reader.loads(LINE + STUDY)
    found = run_study(study, study.variants, count=60)
    lines = list(screen_lines(replace(found, requested_count=90)))
    assert "Stopped: results of 60 of 90 variants." in lines[1:3]


@pytest.mark.slow
@pytest.mark.parametrize("lang", ["pt", "it"])
def test_study_command_output_is_translated(tmp_path, lang):
    text = STUDY.replace("rows: float32", "sobol: true, rare: true, pareto: [margin, cost]")
    text = text.replace(text[text.index("  correlated:") : text.index("  ask:")], "")
    run = asked(
        tmp_path, "--all", "--lang", lang, "--n", 140, "--html", tmp_path / "a.html",
        study_text=text,
    )  # fmt: skip
    assert run.exit_code == 0, run.output
    assert "May be built" not in run.output
    assert "Sobol" in run.output


def test_study_command_resumes_in_its_folder(tmp_path):
    out = tmp_path / "out"
    first = asked(tmp_path, "--out", out, "--json", tmp_path / "a.json")
    assert first.exit_code == 0, first.output
    second = asked(tmp_path, "--out", out)
    assert second.exit_code == 2
    assert "--resume" in second.output
    third = asked(tmp_path, "--out", out, "--resume", "--json", tmp_path / "b.json")
    assert third.exit_code == 0
    assert (tmp_path / "a.json").read_text() == (tmp_path / "b.json").read_text()


def test_application_changed_during_study_is_named_in_result(tmp_path, monkeypatch):
    path, out, page = (tmp_path / name for name in ("line.yaml", "a.json", "a.html"))
    asked(tmp_path, "--json", out, "--html", page)
    undisturbed = json.loads(out.read_text())
    assert "changed_while_running" not in undisturbed
    text = path.read_bytes()

    def edited(*args, **kwargs):
        path.write_text(path.read_text().replace("torque_Nm: 3000", "torque_Nm: 300"))
        return run_study(*args, **kwargs)

    monkeypatch.setattr("cardan.topics.variants.runner.run_study", edited)
    run = asked(tmp_path, "--json", out, "--html", page)
    assert run.exit_code == 0
    document = json.loads(out.read_text())
    assert document.pop("changed_while_running") == [
        {
            "file": "line.yaml",
            "sha256_at_start": sha256(text).hexdigest(),
            "sha256_at_end": sha256(path.read_bytes()).hexdigest(),
        }
    ]
    assert document == undisturbed
    told = "Warning: line.yaml changed while the study ran"
    assert told in " ".join(run.output.split())
    assert told in page.read_text()
    assert sha256(text).hexdigest()[:16] in page.read_text().partition(told)[0]


@pytest.mark.parametrize(
    ("options", "text", "told"),
    [
        (("--resume",), STUDY, "name it with --out"),
        ((), "", "has no study: say what varies"),
        (("--executor", "tcp://localhost:1"), STUDY, "cardan[cluster]"),
        (("--executor", "thread"), STUDY, "threads, processes or the address of a Dask cluster"),
        ((), STUDY.replace("rows: float32", "sobol: true"), "independent inputs"),
    ],
)
def test_study_command_rejects_bad_options_with_reason(tmp_path, options, text, told):
    if "cluster" in told and find_spec("distributed"):
        pytest.skip("the cluster's package is here")
    run = asked(tmp_path, *options, study_text=text)
    assert run.exit_code == 2
    assert told in run.output


def test_python_api_study_matches_file_study(tmp_path):
    (tmp_path / "line.yaml").write_text(LINE + STUDY)
    app = cardan.read(tmp_path / "line.yaml")
    found = cardan.study(app, n=90)
    assert len(found.to_frame()) == found.count == 90
    assert found.yield_ == np.isin(found.verdicts, ["pass", "warn"]).mean()
    assert found.to_dict()["variants"] == 90
    assert all("<svg" in f.svg for f in found.figures())
    assert "<svg" in found._repr_html_()
    alone = cardan.study(app, {"shim_deg": [-1, 1]}, n=16, yield_only=True)
    assert alone.rows is None
    assert alone.yield_ == cardan.study(app, {"shim_deg": [-1, 1]}, n=16).yield_
    with pytest.raises(ValueError, match="yield_only reports nothing else: remove quantiles"):
        cardan.study(app, {"shim_deg": [-1, 1]}, n=16, yield_only=True, quantiles=(0.5,))
    narrow = cardan.study(app, {"shim_deg": [-1, 1]}, n=16, limits=("joint_angle",))
    assert {m.quantity for _, m in narrow.limits} == {"joint_angle"}
    with pytest.raises(CardanError, match="not kept"):
        cardan.study(app, {"shim_deg": [-1, 1]}, n=16, rows=None).to_frame()


def test_shards_merge_to_the_same_bits_in_any_nodes():
    """Sums that round otherwise in another order, as those of quantiles and weights, do not."""
    variants = build_variants({}, TOLERANCES, ask=VariantOutputs(quantiles=(0.5,)))
    job = ShardJob.from_study(application(), variants)
    every = reduce.requested_statistics(job.evaluator, variants.ask)
    leaves = {(0, k): job.run_shard(7 * k, 7 * k + 7).statistics for k in range(11)}
    whole = merged_statistics(every, leaves)
    for most, beginning in ((2, 0), (4, 0), (8, 0), (8, 3)):
        nodes, todo = dict(list(leaves.items())[:beginning]), list(range(beginning, 11))
        at = 0
        while at < len(todo):
            node = next_node(todo, at, most)
            assert list(shards_of(node)) == todo[at : at + len(shards_of(node))]
            mine = {(0, k): leaves[0, k] for k in shards_of(node)}
            nodes[node] = merged_statistics(every, mine)
            at += len(mine)
        again = merged_statistics(every, nodes)
        for name, state in whole.items():
            for key, value in state.items():
                np.testing.assert_array_equal(value, again[name][key], err_msg=name)
    assert merged_statistics(every, {}) == {}
