"""Studies at scale: what is told of shards is what NumPy says of every variant."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from concurrent.futures import BrokenExecutor
from dataclasses import replace
from functools import cache
from importlib.util import find_spec
from itertools import pairwise
from multiprocessing import active_children
from pathlib import Path

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from scipy import stats

import cardan
from cardan import files
from cardan.base.errors import BadFile, CardanError
from cardan.base.verdict import GRADES, VERDICTS, badness
from cardan.cli import cli
from cardan.files.study import read as read_study
from cardan.model.variants import Ask, Spread, Variants
from cardan.report import study as report
from cardan.report.language import EN
from cardan.report.study import parallel
from cardan.report.svg import GRADED
from cardan.study import reduce, shards
from cardan.study.approval import assess
from cardan.study.draw import Drawing, Factor, drawing
from cardan.study.reduce import FINE, clopper_pearson, quantile, sobol, tighter, weights, wilson
from cardan.study.shards import MANIFEST, Job, Studied, study
from cardan.study.sweep import NOTHING, Bench, sweep, variants_of

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
ASK = Ask(
    quantiles=(0.05, 0.5, 0.99), worst=5, rows="float64", pareto=("margin", "cost", "mass"),
    maps=(("shim_deg", "driveline.shafts[2].tube.wall_mm"),),
)  # fmt: skip


@cache
def application(more: str = ""):
    return files.loads(LINE + more)


@cache
def studied() -> Studied:
    """A study of some shards, with every variant kept beside what is told of them."""
    return study(application(), variants_of(VARY, TOLERANCES, ask=ASK), count=900, shard=200)


# --------------------------------------------------------------------------- where they lie


@pytest.mark.parametrize(
    ("variants", "points"),
    [
        (variants_of(VARY, TOLERANCES), "random"),
        (variants_of({"shim_deg": [-1, 1], "driveline.shafts[2].length_mm": [1490, 1510]}), "even"),
        (variants_of(VARY, TOLERANCES, ask=Ask(sobol=True)), "saltelli"),
    ],
)
def test_a_stretch_of_variants_is_the_same_whoever_draws_it(variants, points):
    bench = Bench.of(application(), variants, seed=3)
    assert bench.drawing.points == points
    whole = bench.drawing.values(0, 240)
    cuts = [0, 24, 60, 180, 240] if points != "saltelli" else [0, 80, 160, 240]
    each = [bench.drawing.values(a, b) for a, b in pairwise(cuts)]
    np.testing.assert_array_equal(np.concatenate(each), whole)
    assert (whole != Bench.of(application(), variants, seed=4).drawing.values(0, 240)).any()


def test_what_is_drawn_has_the_spread_that_is_said():
    known = {"a": 5.0, "b": 1.0, "c": 0.0, "d": 7.0}
    variants = Variants(
        vary={
            "c": Spread(kind="range", values=(2.0, 4.0)),
            "d": Spread(kind="choice", values=(1, 9)),
        },
        tolerances={
            "a": Spread(kind="normal", values=(0.5,)), "b": Spread(kind="uniform", values=(0.3,)),
            "c": Spread(kind="normal", values=(0.01,)),
        },
        correlated=(("a", "b", -0.6),),
    )  # fmt: skip
    n = 40_000
    values = drawing(variants, known, seed=1).values(0, n)
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


def test_a_grid_is_gone_through_whole_and_crossed():
    variants = variants_of(
        {"shim_deg": {"grid": [-1, 1, 3]}, "phase_deg[2]": {"grid": [0, 90, 2]}},
        {"driveline.slopes.side_deg[1]": {"normal": 0.1}},
    )
    bench = Bench.of(application(), variants)
    assert bench.whole(8) == 12
    values = bench.drawing.values(0, 12)
    places, counts = np.unique(values[:, :2], axis=0, return_counts=True)
    assert places.tolist() == [[s, p] for s in (-1, 0, 1) for p in (0, 90)]
    assert set(counts) == {2}


def test_correlations_that_contradict_each_other_are_refused():
    known = dict.fromkeys("abc", 0.0)
    tolerances = dict.fromkeys("abc", Spread(kind="normal", values=(1.0,)))
    pairs = (("a", "b", 0.9), ("b", "c", 0.9), ("a", "c", -0.9))
    with pytest.raises(ValueError, match="contradict"):
        drawing(Variants(tolerances=tolerances, correlated=pairs), known)
    with pytest.raises(ValueError, match="independent"):
        drawing(Variants(tolerances=tolerances, correlated=pairs[:1], ask=Ask(sobol=True)), known)


def test_tolerances_that_go_together_are_told():
    pair = ("driveline.slopes.side_deg[1]", "driveline.slopes.side_deg[2]")
    asked = replace(variants_of({}, TOLERANCES), correlated=((*pair, 0.5),))
    found = study(application(), asked, count=20)
    assert f"{pair[0]} with {pair[1]} 0.5" in "\n".join(report.terminal(found))
    assert report.document(found)["correlated"] == [{"between": list(pair), "correlation": 0.5}]


@pytest.mark.parametrize("signs", [(-0.5, -0.5, -0.5), (0.6, 0.8, 0.0)])
def test_correlations_that_tie_a_number_to_others_are_told_as_that(signs):
    """Three that add up to nothing: no contradiction, but what weighs them divides by nothing."""
    known = dict.fromkeys("abc", 0.0)
    tolerances = {name: Spread(kind="normal", values=(1.0,)) for name in known}
    pairs = tuple((*p, r) for p, r in zip(("ab", "ac", "bc"), signs, strict=True))
    with pytest.raises(ValueError, match="leave one number no freedom of its own"):
        drawing(Variants(tolerances=tolerances, correlated=pairs), known)


# --------------------------------------------------------------------------- against NumPy


def test_counts_are_those_of_every_variant():
    found = studied()
    rows = found.rows
    assert found.count == rows.count == 900
    assert 0.2 < found.yield_ < 0.8
    assert found.shares == rows.shares
    assert found.yield_ == np.isin(rows.verdicts, ["pass", "warn"]).mean()
    counts = found.states["counts"]
    for k, held in enumerate(rows.held):
        for g in range(3):
            assert counts["grades"][k, g] == (held.grades == g).sum()
        others = [h.grades == 2 for i, h in enumerate(rows.held) if i != k]
        alone = (held.grades == 2) & ~np.any(others, axis=0)
        assert counts["alone"][k] == alone.sum()
    assert counts["alone"].sum() > 0


def test_every_variant_is_what_a_check_of_it_says():
    rows = studied().rows
    moved = list(rows.names).index("shim_deg")
    for k in np.flatnonzero(rows.inputs[:, moved] == 0)[:12]:
        changes = {n: float(v) for n, v in zip(rows.names, rows.inputs[k], strict=True)}
        del changes["shim_deg"]
        alone = assess(files.change(application(), changes))
        assert rows.verdicts[k] == alone.verdict
        worst = min(c.margin for c in alone.checks)
        assert rows.margins[k] == pytest.approx(worst, rel=1e-9, abs=1e-9)


def test_quantiles_are_those_of_every_variant_as_finely_as_is_said():
    found = studied()
    state, number = found.states["values"], len(found.limits)
    for column in range(2 * number + 1):
        every = (
            found.rows.answers.values[column] if column < number
            else found.rows.answers.margins[column - number] if column < 2 * number
            else found.rows.margins
        )  # fmt: skip
        assert state["known"][column] == np.isfinite(every).sum()
        assert state["least"][column] == every.min()
        assert state["most"][column] == every.max()
        assert state["sum"][column] == pytest.approx(every.sum(), rel=1e-12)
        for share in (0.0, 0.01, 0.05, 0.5, 0.93, 1.0):
            exact = np.quantile(every, share, method="lower")
            assert quantile(state, column, share) == pytest.approx(
                exact, rel=1.01 * FINE, abs=1e-11
            )


def test_the_worst_are_the_worst_with_their_inputs():
    found, rows = studied(), studied().rows
    state = found.states["worst"]
    order = sorted(range(900), key=lambda k: (-rows.grades[k], rows.margins[k]))[:5]
    assert state["place"].tolist() == order
    np.testing.assert_array_equal(state["inputs"], rows.inputs[order])
    for k, limit in zip(order, state["limit"].tolist(), strict=True):
        assert rows.answers.margins[limit, k] == rows.margins[k]


def test_the_first_are_drawn_across_what_varies(monkeypatch):
    found, rows = studied(), studied().rows
    state = found.states["first"]
    np.testing.assert_array_equal(state["inputs"], rows.inputs[:300])
    np.testing.assert_array_equal(state["margin"], rows.margins[:300])
    np.testing.assert_array_equal(state["verdict"], rows.grades[:300])
    lines = {c: parallel(found).svg.count(c) for c in GRADED.values()}
    told = [VERDICTS[v] for v in state["verdict"].tolist()]
    assert len(set(told)) > 1
    assert lines == {c: told.count(v) for v, c in GRADED.items()}
    monkeypatch.setattr(report, "AXES", 1)  # the one that goes most with the margin
    told = [abs(np.corrcoef(rows.inputs[:300, k], rows.margins[:300])[0, 1]) for k in range(
        len(rows.names))]  # fmt: skip
    assert f"1 {rows.names[int(np.argmax(told))]}, 2 smallest margin" in parallel(found).note


def test_the_front_is_what_brute_force_leaves():
    found, rows = studied(), studied().rows
    shim = list(rows.names).index("shim_deg")
    goals = np.stack([-rows.margins, np.abs(rows.inputs[:, shim]) / 3, rows.answers.mass], axis=-1)
    goals[:, 1] = np.abs(np.round(rows.inputs[:, shim], 9)) / 3
    fit = rows.grades <= VERDICTS.index("warn")
    beaten = [
        any(((g <= one).all() and (g < one).any() and f) for g, f in zip(goals, fit, strict=True))
        or not may
        for one, may in zip(goals, fit, strict=True)
    ]
    state = found.states["pareto"]
    assert sorted(state["place"].tolist()) == np.flatnonzero(~np.array(beaten)).tolist()
    assert len(state["place"]) >= 3
    assert fit.sum() < len(fit)


def test_a_map_counts_what_lies_in_each_cell():
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


def test_what_stands_for_a_cell_is_the_choice_in_it():
    """Of 0, 30 and 90 the middle one stood at 37.5, half way between its neighbours' edges."""
    vary = {"phase_deg[2]": {"choice": [90, 0, 30]}, "shim_deg": [-1, 1]}
    ask = Ask(maps=(("phase_deg[2]", "shim_deg"),))
    found = study(application(), variants_of(vary, ask=ask), count=64)
    ((chart, state),) = found.maps
    assert chart.middles[0] == (0, 30, 90)
    assert chart.middles[1][:2] == pytest.approx((-0.95, -0.85))
    only = {k: np.where(np.arange(3)[:, None] == 1, v, 0) for k, v in state.items()}
    assert "Best at 30 and" in report.heat(found, chart, only).alt


def test_a_front_of_many_inputs_has_their_numbers_for_heads(monkeypatch):
    """Eleven names beside each other ran into one another on paper."""
    monkeypatch.setattr(report, "BESIDE", 3)
    vary = {"driveline.slopes.side_deg[*]": {"normal": 0.1}, "shim_deg": [-1, 1]}
    ask = Ask(pareto=("margin", "cost"))
    found = study(application(), variants_of(vary, ask=ask), count=64)
    varied, *_ = tables = list(report.tables(found))
    assert [row[0] for row in varied.rows][3:] == ["4 driveline.slopes.side_deg[4]", "5 shim_deg"]
    fronts = [t for t in tables if "no other variant beats" in t.caption]
    assert [t.head[-2:] for t in fronts] == [("2", "3"), ("4", "5")]
    assert all("by their numbers" in t.caption for t in fronts)
    state = found.states["pareto"]
    for table, last in zip(fronts, (2, 4), strict=True):
        row = table.rows[-1]
        assert row[0] == str(state["place"][-1])
        assert float(row[-1]) == pytest.approx(state["inputs"][-1, last], rel=1e-3)
    few = study(application(), variants_of({"shim_deg": [-1, 1]}, ask=ask), count=16)
    assert list(report.tables(few))[-1].head[-1] == "shim_deg"


def test_a_bound_is_drawn_where_its_range_begins():
    """Of a limit from below the line stood at the range's other end."""
    angle = "  - {quantity: joint_angle_min, normal: 1, maximum: 0.5, source: ours}\n"
    limits = {m.quantity: m for m in files.loads(LINE + angle).limits}
    below = list(report._bands(limits["joint_angle_min"], 1.0, (0.0, 9.0)))
    above = list(report._bands(limits["torsional_acceleration"], 1.0, (0.0, 900.0)))
    assert [b.from_above for b in below] == [True, True]
    assert [b.from_above for b in above] == [False, False]
    angle = limits["joint_angle_min"]
    assert [(b.low, b.high) for b in below] == [(angle.maximum, angle.normal), (0.0, angle.maximum)]


def test_what_wins_nothing_is_drawn_against_a_per_cent():
    """Ticks of 2e-10 % stood under bars of none."""
    tolerances = {"driveline.shafts[*].length_mm": {"uniform": 0.1}}
    found = study(application(), variants_of({}, tolerances), count=40)
    svg = next(f for f in report.figures(found) if "halving" in f.title).svg
    assert "e-" not in "".join(re.findall(r"<text[^>]*>([^<]*)<", svg))


def test_shards_of_any_size_come_to_the_same_counts():
    variants = variants_of(VARY, TOLERANCES, ask=ASK)
    one = study(application(), variants, count=900, shard=900)
    for name, a in one.states["counts"].items():
        np.testing.assert_array_equal(a, studied().states["counts"][name])


# --------------------------------------------------------------------------- statistics


@pytest.mark.parametrize(
    ("share", "told"),
    [(1.0, "100.0 %"), (0.0, "0.0 %"), (0.8479, "84.8 %"), (1 - 1 / 8192, "99.99 %"),
     (1 / 8192, "0.01 %"), (0.1, "10.0 %"), (1e-6, "0.0001 %")],
)  # fmt: skip
def test_a_share_is_all_or_none_only_where_it_is(share, told):
    """One of 8192 that failed was told as 100.0 % that may be built."""
    assert report.share(share, EN) == told


def test_a_level_is_told_as_it_was_given():
    """A confidence of 99.5 % was told as 100 %, the quantile of 2.5 % as that of 2 %."""
    asked = variants_of({}, TOLERANCES, ask=Ask(confidence=0.995, quantiles=(0.025,)))
    told = "\n".join(report.terminal(study(application(), asked, count=16)))
    assert "with 99.5 % confidence" in told
    assert "2.5 %" in told


def test_intervals_are_those_of_the_binomial():
    for hits, count in ((0, 20), (3, 20), (17, 40), (40, 40), (250, 1000)):
        test = stats.binomtest(hits, count)
        for ours, method in ((wilson, "wilson"), (clopper_pearson, "exact")):
            low, high = test.proportion_ci(0.9, method=method)
            found = ours(hits, count, confidence=0.9)
            assert found == pytest.approx((low, high), rel=1e-9, abs=1e-12)


@pytest.mark.slow
def test_a_tolerance_half_as_wide_wins_what_a_study_of_it_says():
    correlated = (("driveline.slopes.side_deg[1]", "driveline.slopes.side_deg[2]", 0.5),)
    plain = variants_of({}, TOLERANCES)
    for pairs in ((), correlated):
        asked = replace(plain, correlated=pairs)
        found = study(application(), asked, count=6000, shard=1000, seed=5)
        names = [found.drawing.called(f) for f in found.drawing.factors]
        share, error = tighter(found.states["tighter"])
        gains = 0
        for t, name in enumerate(names):
            spread = found.drawing.factors[t].spread
            half = Spread(kind=spread.kind, values=(spread.values[0] / 2,))
            others = {n: f.spread for n, f in zip(names, found.drawing.factors, strict=True)}
            again = study(
                application(), replace(asked, tolerances={**others, name: half}), count=6000,
                shard=2000, seed=6 + t,
            )  # fmt: skip
            scatter = (error[t, 0] ** 2 + again.yield_ * (1 - again.yield_) / 6000) ** 0.5
            assert abs(share[t, 0] - again.yield_) < 4 * scatter
            gains += again.yield_ - found.yield_ > 4 * scatter
        assert gains  # or nothing here could tell weights from ones


def test_weights_leave_as_many_variants_as_there_are():
    factors = tuple(
        Factor(input=k, spread=Spread(kind=kind, values=(1.0,)), tolerance=True)
        for k, kind in enumerate(("normal", "uniform", "normal"))
    )
    lower = np.linalg.cholesky([[1, 0.5, 0.2], [0.5, 1, 0], [0.2, 0, 1]])
    drawn = Drawing(
        names=tuple("abc"), at=(0.0,) * 3, factors=factors, mix=tuple(map(tuple, lower)), seed=2
    )
    found = weights(drawn, drawn.unit(0, 100_000))
    error = found.std(0) / 100_000**0.5
    assert (abs(found.mean(0) - 1) < 5 * error).all()


class Made:
    """Rows of a function of three numbers, as a study would bring them."""

    def __init__(self, unit, function):
        self.count, self.inputs, self.unit = len(unit), unit, unit
        self.margins = function(unit)
        self.grades = np.where(self.margins > 0, 0, VERDICTS.index("fail"))
        self.answers = type("A", (), {"margins": self.margins[None]})


def test_sobol_indices_are_those_of_ishigamis_function():
    def ishigami(u):
        x = np.pi * (2 * u - 1)
        return np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])

    factors = tuple(
        Factor(input=k, spread=Spread(kind="range", values=(0.0, 1.0))) for k in range(3)
    )
    drawn = Drawing(names=tuple("abc"), at=(0.0,) * 3, factors=factors, points="saltelli", seed=1)
    pairs = reduce.Pairs(factors=3)
    step = 5 * 4000
    states = [
        pairs.of(Made(drawn.unit(k, k + step), ishigami), k) for k in range(0, 5 * step, step)
    ]
    found = sobol(reduce.joined(pairs, states))
    # Exact: Ishigami & Homma (1990), with a = 7, b = 0.1.
    for ours, error, exact in (
        (found.first, found.first_error, (0.3139, 0.4424, 0.0)),
        (found.total, found.total_error, (0.5576, 0.4424, 0.2437)),
    ):
        assert (abs(ours[0] - exact) < 5 * error[0] + 1e-4).all()
        assert (error[0] < 0.02).all()


def test_sobol_indices_of_a_study_are_those_of_its_rows():
    ask = Ask(sobol=True, rows="float64")
    found = study(application(), variants_of({}, TOLERANCES, ask=ask), count=700, shard=210)
    d = len(found.drawing.factors)
    y = found.rows.margins.reshape(-1, d + 2)
    a, b = y[:, 0], y[:, 1]
    variance = np.var(y[:, :2])
    indices = sobol(found.states["sobol"])
    for k in range(d):
        first = ((b - y[:, :2].mean()) * (y[:, 2 + k] - a)).mean() / variance
        total = ((a - y[:, 2 + k]) ** 2).mean() / 2 / variance
        assert indices.first[0, k] == pytest.approx(first, rel=1e-9, abs=1e-12)
        assert indices.total[0, k] == pytest.approx(total, rel=1e-9)
    own = found.rows.own
    assert own.sum() == found.own == 2 * len(y)
    assert found.yield_ == np.isin(np.array(found.rows.verdicts)[own], ["pass", "warn"]).mean()


# --------------------------------------------------------------------------- what cannot be


def test_what_nothing_moves_has_no_variance_to_share_out():
    asked = variants_of({}, {"phase_deg[2]": {"uniform": 5}}, ask=Ask(sobol=True))
    found = study(application(), asked, count=300)
    assert np.isnan(sobol(found.states["sobol"]).total[0]).all()  # the joint's angle decides
    told = "\n".join(report.terminal(found))
    assert "Sobol" in told
    assert "nan" not in told


def test_a_number_that_arrays_cannot_hold_is_read_anew_for_each_variant():
    spread = {
        "limits[1].maximum": {"choice": [300.0, 500.0]},
        "driveline.joints.peak_Nm": {"uniform": 500.0},
        "driveline.slopes.side_deg[2]": {"normal": 0.3},
    }
    more = LINE.replace(
        'joints: "1810"', "joints: {name: ours, peak_Nm: 6000, source: ours}"
    ).replace("normal: 350, ", "")
    own = files.loads(more + "  - {quantity: joint_torque_utilisation, maximum: 1, source: ours}\n")
    vary = {k: v for k, v in spread.items() if "choice" in v}
    scatter = {k: v for k, v in spread.items() if "choice" not in v}
    asked = variants_of(vary, scatter, ask=Ask(rows="float64"))
    found = study(own, asked, count=24, shard=8)
    assert set(found.bench.single) >= {"limits[1].maximum"}
    rows = found.rows
    for k in range(24):
        alone = assess(files.change(own, {v.name: float(v.values[k]) for v in rows.varied}))
        assert rows.verdicts[k] == alone.verdict
        assert rows.margins[k] == pytest.approx(min(c.margin for c in alone.checks), rel=1e-9)
    assert len(set(rows.verdicts)) > 1


def test_a_bound_that_varies_is_still_its_own_limits():
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
    own = files.loads(text)
    found = study(own, variants_of(vary, ask=Ask(rows="float64")), count=16)
    rows, seen = found.rows, set()
    for k in range(16):
        numbers = {v.name: float(v.values[k]) for v in rows.varied}
        alone = assess(files.change(own, numbers))
        for place, (_, limit) in enumerate(found.limits):
            mine = [
                c
                for c in alone.checks
                if c.quantity == limit.quantity and c.limit.source == limit.source
            ]
            worst = min(mine, key=badness)
            assert GRADES[rows.answers.grades[place, k]] == worst.grade
            assert rows.answers.values[place, k] == pytest.approx(worst.value)
            left = min(c.limit.margin(c.value, to="maximum") for c in mine)
            assert rows.answers.left[place, k] == pytest.approx(left)
            seen.add((limit.quantity, worst.grade))
    assert {("joint_angle", "fail"), ("joint_angle", "pass")} <= seen
    assert {("torsional_acceleration", "fail"), ("torsional_acceleration", "pass")} <= seen


def test_what_cannot_exist_fails_and_is_told():
    # A bearing 140 mm ahead of its joint needs a shaft longer than that.
    asked = variants_of({}, {"driveline.shafts[1].length_mm": {"normal": 800}}, ask=ASK)
    found = study(application(), replace(asked, ask=replace(ASK, maps=())), count=200, shard=64)
    rows = found.rows
    lengths = rows.inputs[:, 0]
    assert (rows.answers.refused >= (lengths <= 140)).all()
    assert 5 < rows.answers.refused.sum() < 100
    assert found.states["counts"]["refused"] == rows.answers.refused.sum()
    assert all(VERDICTS[g] == "fail" for g in rows.grades[rows.answers.refused])
    assert "length" in str(found.states["worst"]["why"][0])
    fine = np.flatnonzero(~rows.answers.refused)[0]
    alone = assess(files.change(application(), {rows.names[0]: float(lengths[fine])}))
    assert rows.verdicts[fine] == alone.verdict
    assert (rows.answers.grades[:, rows.answers.refused] == NOTHING).all()


def test_the_variance_says_of_how_many_groups_it_is():
    """Groups in which a variant cannot exist fell out of a margin's indices, and nobody said so."""
    wide = {"driveline.shafts[1].length_mm": {"normal": 800}}
    found = study(
        application(), variants_of({}, wide, ask=Ask(sobol=True, rows="float64")), count=96
    )
    refused = found.rows.answers.refused.reshape(-1, 3)
    known = int((~refused.any(axis=1)).sum())
    assert known < 32
    assert f"among the {known} of 32 groups" in "\n".join(report.terminal(found))


def test_ends_of_what_is_chosen_must_be_possible():
    wall = "driveline.shafts[2].tube.wall_mm"
    with pytest.raises(BadFile, match=r"wall_mm: cannot be -1, up to where .*: must be a number"):
        Bench.of(application(), variants_of({wall: [-1, 4]}))
    # What stands in the way may be another number, which nobody changed.
    told = r"length_mm: cannot be 120, up to where .*must sit on its shaft"
    with pytest.raises(BadFile, match=told):
        Bench.of(application(), variants_of({"driveline.shafts[1].length_mm": [120, 900]}))


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
def test_what_is_wrong_in_a_study_is_told_where_it_stands(tmp_path, written, told, inside):
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


def same(one: Studied, other: Studied) -> None:
    """Hold two studies against each other, to the last bit."""
    assert one.states.keys() == other.states.keys()
    for name, state in one.states.items():
        for array, value in state.items():
            np.testing.assert_array_equal(value, other.states[name][array], f"{name}.{array}")


def test_threads_and_processes_come_to_the_same_bits():
    variants = variants_of(VARY, TOLERANCES, ask=replace(ASK, rows=None))
    alone = study(application(), variants, count=300, shard=60)
    same(alone, study(application(), variants, count=300, shard=60, workers=3))
    with shards.workers_of("processes", 2) as pool:
        same(alone, study(application(), variants, count=300, shard=60, executor=pool, workers=2))


@pytest.mark.skipif(os.name == "nt", reason="has no such signal")
def test_a_killed_process_is_told_and_what_is_done_is_kept(tmp_path):
    variants = variants_of(VARY, TOLERANCES, ask=ASK)
    whole = study(application(), variants, count=600, shard=60)

    def kill(progress):
        if progress.done == 60:
            active_children()[0].kill()

    with (
        pytest.raises(CardanError, match=r"a process that asked a shard was killed; .*--resume"),
        shards.workers_of("processes", 1) as pool,
    ):
        study(
            application(), variants, count=600, shard=60, folder=tmp_path, executor=pool, hear=kill
        )
    same(whole, study(application(), variants, count=600, shard=60, folder=tmp_path, resume=True))


def cut_short():
    """End as a process killed half-way through what it says."""
    at = sys._getframe()
    while at and "pipe" not in at.f_locals:
        at = at.f_back
    assert at
    os.write(at.f_locals["pipe"].fileno(), (1 << 20).to_bytes(4, "big") + b"half")
    os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.skipif(os.name == "nt", reason="has no such signal")
def test_nobody_waits_for_the_rest_of_what_a_killed_process_was_saying():
    with shards.Processes(2) as pool:
        killed, other = pool.submit(cut_short), pool.submit(pow, 2, 10)
        assert isinstance(killed.exception(timeout=120), BrokenExecutor)
        assert other.result(timeout=120) == 1024


def test_what_goes_wrong_in_a_process_is_told_with_where():
    with shards.Processes(1) as pool, pytest.raises(ZeroDivisionError) as told:
        pool.submit(divmod, 1, 0).result()
    assert "fn(*args, **kwargs)" in told.value.__notes__[0]
    with shards.Processes(1) as pool, pytest.raises(TypeError, match="code"):
        pool.submit(compile, "lambda: 0", "", "eval").result()


ORPHANED = """
import time
from concurrent.futures import wait
from cardan.study.shards import workers_of
if __name__ == "__main__":
    with workers_of("processes", 2) as pool:
        wait([pool.submit(time.sleep, 0.1) for _ in range(2)])
        print("both wait", flush=True)
        time.sleep(600)
"""


def test_processes_end_with_who_hands_out_their_work(tmp_path):
    (tmp_path / "hand.py").write_text(ORPHANED)
    with subprocess.Popen([sys.executable, tmp_path / "hand.py"], stdout=subprocess.PIPE) as run:
        assert run.stdout
        assert run.stdout.readline().strip() == b"both wait"
        run.kill()
        run.communicate(timeout=30)  # the pipe's end is the end of all who hold it


def test_what_was_stopped_goes_on_to_the_same_bits(tmp_path):
    variants = variants_of(VARY, TOLERANCES, ask=ASK)
    whole = study(application(), variants, count=600, shard=60, folder=tmp_path / "whole")

    def stop(progress):
        if progress.done >= 180:
            raise KeyboardInterrupt

    with pytest.raises(shards.Stopped) as stopped:
        study(application(), variants, count=600, shard=60, folder=tmp_path / "cut", hear=stop)
    assert 180 <= stopped.value.studied.count < 600
    before = {p.name for p in (tmp_path / "cut").glob("shard-*")}
    told = []
    again = study(
        application(), variants, count=600, shard=60, folder=tmp_path / "cut", resume=True,
        hear=told.append,
    )  # fmt: skip
    same(whole, again)
    assert told[0].before == 60 * len(before)
    names = sorted(p.name for p in (tmp_path / "whole").iterdir())
    assert names == sorted(p.name for p in (tmp_path / "cut").iterdir())
    for name in names:
        assert (tmp_path / "whole" / name).read_bytes() == (tmp_path / "cut" / name).read_bytes()
    # More variants of the same study need only the new ones.
    more = study(application(), variants, count=900, shard=60, folder=tmp_path / "cut", resume=True)
    same(more, study(application(), variants, count=900, shard=60))


def test_a_folder_is_of_one_study(tmp_path):
    variants = variants_of({}, TOLERANCES)
    study(application(), variants, count=20, folder=tmp_path)
    with pytest.raises(CardanError, match="holds a study already"):
        study(application(), variants, count=20, folder=tmp_path)
    with pytest.raises(CardanError, match=r"holds another study, with other .*seed"):
        study(application(), variants, count=20, folder=tmp_path, resume=True, seed=1)
    other = files.loads(LINE.replace("3000", "3001"))
    with pytest.raises(CardanError, match="with other application: name another folder"):
        study(other, variants, count=20, folder=tmp_path, resume=True)
    other = files.loads(LINE.replace("maximum: 500", "maximum: 501"))
    with pytest.raises(CardanError, match="with other application, limits: name another"):
        study(other, variants, count=20, folder=tmp_path, resume=True)
    asked = replace(variants, ask=Ask(quantiles=(0.5,)))
    with pytest.raises(CardanError, match="with other vary, tolerances or ask: name another"):
        study(application(), asked, count=20, folder=tmp_path, resume=True)
    # Fewer would leave variants lying there that nothing is told of.
    with pytest.raises(CardanError, match=r"holds 20 variants, more than 19: .*\(--n 20\)"):
        study(application(), variants, count=19, folder=tmp_path, resume=True)
    for broken in ("", "[]", "{}"):
        (tmp_path / MANIFEST).write_text(broken)
        with pytest.raises(CardanError, match=r"manifest\.json is none of this version's"):
            study(application(), variants, count=20, folder=tmp_path, resume=True)
    # Shards of a study that nobody names were told as those of the next one.
    (tmp_path / MANIFEST).unlink()
    for resume in (False, True):
        with pytest.raises(CardanError, match=r"holds shards, but no manifest\.json says of which"):
            study(other, variants, count=20, folder=tmp_path, resume=resume)


@pytest.mark.parametrize("bytes_", [0, 300])
def test_half_a_shard_and_lost_rows_are_asked_again(tmp_path, bytes_):
    variants = variants_of({}, TOLERANCES, ask=Ask(rows="float64"))
    study(application(), variants, count=80, shard=20, folder=tmp_path)
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}
    (tmp_path / "shard-000001.npz").write_bytes(before["shard-000001.npz"][:bytes_])
    whole = bytearray(before["shard-000000.npz"])
    whole[len(whole) // 2] ^= 0xFF
    (tmp_path / "shard-000000.npz").write_bytes(whole)
    (rows,) = tmp_path.glob("rows-000002.*")
    rows.unlink()
    (rows,) = tmp_path.glob("rows-000003.*")
    rows.write_bytes(before[rows.name][:bytes_])
    study(application(), variants, count=80, shard=20, folder=tmp_path, resume=True)
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before


OURS = """
profile: ours
limits:
  - {quantity: joint_angle, unit: deg, maximum: 3.7, source: ours}
"""


def test_a_limits_file_that_changes_while_a_study_runs_stops_it(tmp_path):
    (tmp_path / "ours.yaml").write_text(OURS)
    (tmp_path / "line.yaml").write_text(LINE[: LINE.index("limits:")] + "limits: ours.yaml\n")
    truck, variants = files.read(tmp_path / "line.yaml"), variants_of({}, TOLERANCES)

    def meddle(progress):
        if progress.done:
            (tmp_path / "ours.yaml").write_text(OURS.replace("3.7", "3.75"))

    with pytest.raises(CardanError, match="files that it names changed while the study ran"):
        study(truck, variants, count=60, shard=20, folder=tmp_path / "o", hear=meddle)
    changed = files.read(tmp_path / "line.yaml")
    with pytest.raises(CardanError, match="with other limits, files that it names: name"):
        study(changed, variants, count=60, shard=20, folder=tmp_path / "o", resume=True)


def test_a_worker_elsewhere_finds_the_files_and_says_where_it_has_others(tmp_path, monkeypatch):
    """As in another folder of a cluster: a path that goes from here leads nowhere there."""
    (tmp_path / "ours.yaml").write_text(OURS)
    (tmp_path / "line.yaml").write_text(LINE[: LINE.index("limits:")] + "limits: ours.yaml\n")
    monkeypatch.chdir(tmp_path)
    job = Job.of(files.read(Path("line.yaml")), variants_of({}, TOLERANCES))
    here = job.shard(0, 20)
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    shards._bench.cache_clear()
    there = job.shard(0, 20)
    np.testing.assert_array_equal(here.states["counts"]["grades"], there.states["counts"]["grades"])
    assert not there.states["counts"]["refused"]
    shards._bench.cache_clear()
    (tmp_path / "ours.yaml").write_text(OURS.replace("3.7", "3.75"))
    with pytest.raises(CardanError, match="a worker has other files that it names than where"):
        job.shard(0, 20)
    (tmp_path / "ours.yaml").unlink()
    with pytest.raises(
        CardanError, match=r"ours.yaml, which the application names, cannot be read"
    ):
        job.shard(0, 20)


def test_a_grid_by_itself_is_asked_once():
    grid = {"driveline.slopes.side_deg[1]": {"grid": [2.0, 4.0, 5]}}
    found = study(application(), variants_of({**grid}), count=1000)
    assert (found.count, found.drawing.period) == (5, 5)
    # With something drawn each round of the grid is another.
    assert study(application(), variants_of({**grid, "shim_deg": [-1, 1]}), count=12).count == 15


def test_what_cannot_exist_is_not_among_the_worst():
    """Nothing decides it: it named the first limit, with an infinite margin."""
    wild = {"driveline.shafts[1].centre_bearing.from_rear_joint_mm": {"normal": 900.0}}
    found = study(application(), variants_of({}, wild, ask=Ask(worst=40)), count=40)
    refused = int(found.states["counts"]["refused"])
    assert 0 < refused < 40
    told = report.document(found)["worst"]
    assert len(told) == 40 - refused
    assert all(np.isfinite(one["margin"]) for one in told)


def test_rows_are_kept_as_asked(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    asked = variants_of(VARY, TOLERANCES, ask=replace(ASK, rows="float32"))
    study(application(), asked, count=300, shard=150, folder=tmp_path)
    tables = [parquet.read_table(p) for p in sorted(tmp_path.glob("rows-*.parquet"))]
    assert sum(t.num_rows for t in tables) == 300
    assert str(tables[0].schema.field("margin").type) == "float"
    found = study(application(), variants_of(VARY, TOLERANCES, ask=ASK), count=300).rows
    np.testing.assert_array_equal(
        np.concatenate([t["margin"] for t in tables]), found.margins.astype("float32")
    )


PRINTS = """
import sys
from pathlib import Path
from cardan import files
from cardan.study.shards import Job
from cardan.study.sweep import variants_of
for path in map(Path, sys.argv[1:]):
    variants = variants_of({}, {"driveline.points_mm[*]": {"normal": 1.0}})
    print(Job.of(files.read(path), variants).prints)
"""


def test_another_process_knows_the_study_again():
    """Sets of words, as the states that a limit is for, have an order of the process's own."""
    trucks = sorted((Path(__file__).parents[2] / "examples").glob("*.yaml"))
    assert any(limit.states for limit in files.read(trucks[0]).limits)
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
from cardan import files
from cardan.model.variants import Ask
from cardan.study.shards import study
from cardan.study.sweep import variants_of
text, folder = Path(sys.argv[1]).read_text(), Path(sys.argv[2])
app = files.loads(text)
asked = variants_of({}, {"driveline.slopes.side_deg[*]": {"normal": 0.2}}, ask=Ask(rows="float64"))
study(app, asked, count=800, shard=20, folder=folder, resume=folder.exists())
"""


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="has no such signal")
@pytest.mark.parametrize("shards_before", [1, 4, 9])
def test_killed_at_any_moment_it_goes_on_to_the_same_bits(tmp_path, shards_before):
    (tmp_path / "line.yaml").write_text(LINE)
    command = [sys.executable, "-c", KILLED, str(tmp_path / "line.yaml"), str(tmp_path / "out")]
    run = subprocess.Popen(command)
    deadline = time.monotonic() + 60
    while len(list((tmp_path / "out").glob("shard-*.npz"))) < shards_before:
        assert time.monotonic() < deadline
        time.sleep(0.002)
    os.kill(run.pid, signal.SIGKILL)
    assert run.wait() == -signal.SIGKILL
    done = len(list((tmp_path / "out").glob("shard-*.npz")))
    assert shards_before <= done < 40
    subprocess.run(command, check=True)
    asked = variants_of(
        {}, {"driveline.slopes.side_deg[*]": {"normal": 0.2}}, ask=Ask(rows="float64")
    )
    study(application(), asked, count=800, shard=20, folder=tmp_path / "whole")
    for path in sorted((tmp_path / "whole").iterdir()):
        assert path.read_bytes() == (tmp_path / "out" / path.name).read_bytes(), path.name


def test_a_job_crosses_to_another_process_whole():
    import pickle

    job = Job.of(application(), variants_of({}, TOLERANCES), seed=1)
    there = pickle.loads(pickle.dumps(job))
    a, b = job.shard(0, 30), there.shard(0, 30)
    np.testing.assert_array_equal(a.states["counts"]["grades"], b.states["counts"]["grades"])


def test_the_manifest_names_what_the_folder_holds(tmp_path):
    study(application(), variants_of({}, TOLERANCES), count=20, folder=tmp_path, seed=7)
    found = json.loads((tmp_path / MANIFEST).read_text())
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


def test_a_study_stands_in_the_file_or_beside_it(tmp_path):
    inside = files.loads(LINE + STUDY).variants
    assert inside.vary["shim_deg"] == Spread(kind="range", values=(-2, 2))
    assert inside.vary["driveline.shafts[2].tube.wall_mm"].values == (3, 4, 5)
    assert inside.tolerances["driveline.shafts[1].length_mm"] == Spread(kind="uniform", values=(2,))
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
        ("worst: 2", "worst: 0",
         "study.ask.worst: must be a whole number from 1 to 1000"),
        ("rows: float32", "rows: float16",
         "study.ask.rows: must be one of float32, float64 (got float16)"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_study_is_told_where_it_stands(was, now, told):
    text = LINE + STUDY.replace(was, now, 1)
    assert text != LINE + STUDY
    with pytest.raises(BadFile) as error:
        files.loads(text, name="line.yaml")
    assert told in str(error.value)


def test_nothing_is_weighed_against_itself():
    with pytest.raises(ValueError, match="pareto weighs each once, against others, got mass, mass"):
        cardan.study(application(), {"shim_deg": [-1, 1]}, n=8, pareto=("mass", "mass"))


def test_a_map_of_several_parts_is_of_the_first_however_they_are_named():
    names = ("a[10]", "a[2]", "b")
    spread = Spread(kind="normal", values=(1.0,))
    drawn = Drawing(
        names=names, at=(0.0,) * 3,
        factors=tuple(Factor(input=k, spread=spread, tolerance=True) for k in range(3)),
    )  # fmt: skip
    assert reduce.Map.over(("a[*]", "b"), drawn).columns == (1, 2)


def test_editors_know_what_a_study_may_hold():
    jsonschema = pytest.importorskip("jsonschema")
    described = json.loads(CliRunner().invoke(cli, ["schema", "--study"]).stdout)
    gallery = Path(__file__).parents[2] / "docs" / "gallery" / "tolerances.yaml"
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


def test_a_study_needs_something_that_varies():
    with pytest.raises(BadFile, match="needs vary or tolerances"):
        files.loads(LINE + "study: {ask: {worst: 3}}\n")


def test_sweeps_keep_grades_by_name():
    found = sweep(application(), {"shim_deg": [-1, 1]}, count=16)
    names = [name for name, _ in found.named()]
    assert len(set(names)) == len(names)
    assert {GRADES[g] for g in found.held[0].grades} <= set(GRADES)


# --------------------------------------------------------------------------- the command


def asked(tmp_path, *options, study_text=STUDY):
    (tmp_path / "line.yaml").write_text(LINE + study_text)
    said = () if "--n" in options else ("--n", 90)
    return CliRunner().invoke(
        cli, ["study", str(tmp_path / "line.yaml"), *map(str, (*said, *options))]
    )


def test_the_command_tells_and_writes(tmp_path):
    run = asked(tmp_path, "--html", tmp_path / "a.html", "--json", tmp_path / "a.json")
    assert run.exit_code == 0, run.output
    for said in (
        "Two-piece driveline: 90 variants", "May be built (pass or warn)", "What varies",
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
    assert json.loads(again.output) == document


@pytest.mark.parametrize("lang", ["pt", "it"])
def test_the_command_speaks_other_languages(tmp_path, lang):
    text = STUDY.replace("rows: float32", "sobol: true, rare: true, pareto: [margin, cost]")
    text = text.replace(text[text.index("  correlated:") : text.index("  ask:")], "")
    run = asked(
        tmp_path, "--lang", lang, "--n", 140, "--html", tmp_path / "a.html", study_text=text
    )
    assert run.exit_code == 0, run.output
    assert "May be built" not in run.output
    assert "Sobol" in run.output


def test_the_command_goes_on_in_its_folder(tmp_path):
    out = tmp_path / "out"
    first = asked(tmp_path, "--out", out, "--json", tmp_path / "a.json")
    assert first.exit_code == 0, first.output
    second = asked(tmp_path, "--out", out)
    assert second.exit_code == 2
    assert "--resume" in second.output
    third = asked(tmp_path, "--out", out, "--resume", "--json", tmp_path / "b.json")
    assert third.exit_code == 0
    assert (tmp_path / "a.json").read_text() == (tmp_path / "b.json").read_text()


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
def test_the_command_refuses_with_a_reason(tmp_path, options, text, told):
    if "cluster" in told and find_spec("distributed"):
        pytest.skip("the cluster's package is here")
    run = asked(tmp_path, *options, study_text=text)
    assert run.exit_code == 2
    assert told in run.output


def test_the_face_asks_the_same(tmp_path):
    (tmp_path / "line.yaml").write_text(LINE + STUDY)
    app = cardan.read(tmp_path / "line.yaml")
    found = cardan.study(app, n=90)
    assert len(found.to_frame()) == found.count == 90
    assert found.yield_ == np.isin(found.verdicts, ["pass", "warn"]).mean()
    assert found.to_dict()["variants"] == 90
    assert all("<svg" in f.svg for f in found.figures())
    assert "<svg" in found._repr_html_()
    narrow = cardan.study(app, {"shim_deg": [-1, 1]}, n=16, limits=("joint_angle",))
    assert {m.quantity for _, m in narrow.limits} == {"joint_angle"}
    with pytest.raises(CardanError, match="not kept"):
        cardan.study(app, {"shim_deg": [-1, 1]}, n=16, rows=None).to_frame()
