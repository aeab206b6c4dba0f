"""Fronts that are bred: NSGA-II held against brute force."""

import json
from functools import cache

import numpy as np
import pytest
from click.testing import CliRunner

from cardan import files
from cardan.base.errors import BadFile, CardanError
from cardan.base.verdict import VERDICTS
from cardan.cli import cli
from cardan.model.variants import Ask
from cardan.report import study as report
from cardan.study import breed
from cardan.study.breed import GENERATION, bred
from cardan.study.reduce import Front, costs
from cardan.study.shards import Stopped, study
from cardan.study.sweep import Bench, variants_of

pytest.importorskip("pymoo", reason="to breed needs pip install 'cardan[pareto]'")

LINE = """
title: Two-piece driveline
speed_rpm: 2500
torque_Nm: 3000
driveline:
  slopes:
    side_deg: [3.0, 1.0, 4.5, 2.0]
  joints: "1810"
  shafts:
    - length_mm: 1200
      tube: {outer_mm: 101.6, wall_mm: 3.2}
      centre_bearing: {from_rear_joint_mm: 140}
    - {length_mm: 1500, tube: {outer_mm: 101.6, wall_mm: 3.2}, phase_deg: 0}
limits:
  - {quantity: torsional_acceleration, normal: 350, maximum: 500, source: ours}
  - {quantity: critical_speed_ratio, normal: 0.6, maximum: 0.75, source: ours}
  - {quantity: joint_angle, maximum: 6, source: ours}
"""
STEPS = {
    "shim_deg": {"grid": [-2, 2, 9]},
    "phase_deg[2]": {"choice": [0, 90]},
    "driveline.shafts[2].tube.outer_mm": {"grid": [70, 125, 12]},
}
RANGES = {
    "shim_deg": [-3, 3],
    "bearing_height_mm[1]": [-20, 20],
    "driveline.shafts[2].tube.outer_mm": [70, 125],
    "driveline.shafts[1].tube.wall_mm": [2.5, 5],
}
GOALS = ("margin", "cost", "mass")


@cache
def application(more: str = ""):
    return files.loads(LINE + more)


def brute(bench, count):
    """Return what is unbeaten of so many variants drawn."""
    return Front(goals=GOALS, costs=costs(bench), drawing=bench.drawing).of(bench.rows(0, count), 0)


def filled(goals, worst):
    """Return the volume between three goals (F, 3) and the worst of each, by thin layers."""
    total, order = 0.0, goals[np.argsort(goals[:, 0])]
    edges = [*order[:, 0].tolist(), worst[0]]
    for k in range(len(order)):
        area, low = 0.0, worst[1]
        flat = order[: k + 1, 1:]
        for y, z in flat[np.argsort(flat[:, 1], kind="stable")].tolist():
            if y < low:  # nearer than all with less of the third goal
                area, low = area + (low - y) * (worst[2] - z), y
        total += area * (edges[k + 1] - edges[k])
    return total


def test_of_a_few_settings_it_finds_the_very_front_of_all():
    crossed = {n: s if "grid" in s else {"grid": [0, 90, 2]} for n, s in STEPS.items()}
    every = Bench.of(application(), variants_of(crossed))
    whole = brute(every, every.drawing.period)
    bench = Bench.of(application(), variants_of(STEPS))
    none = {k: v[:0] for k, v in whole.items()}
    found = bred(bench, GOALS, none, count=1500)
    assert found["verdict"].tolist() == [0] * len(found["verdict"])
    # The order of the same front: by goals.
    np.testing.assert_allclose(
        np.unique(found["goals"].round(9), axis=0), np.unique(whole["goals"].round(9), axis=0)
    )
    assert len(np.unique(whole["goals"].round(9), axis=0)) >= 5


@pytest.mark.slow
def test_over_ranges_it_reaches_farther_than_ten_times_as_many_drawn():
    bench = Bench.of(application(), variants_of(RANGES))
    drawn, few = brute(bench, 8192), brute(bench, 64)
    found = bred(bench, GOALS, few, count=768, start=64)
    worst = np.maximum(drawn["goals"].max(axis=0), found["goals"].max(axis=0))
    most, before, by_dice = (filled(f["goals"], worst) for f in (found, few, drawn))
    assert before < by_dice < most
    # Nobody on it is beaten, and who was drawn stays there if nothing bred beats it.
    g = found["goals"]
    beaten = (g[:, None] <= g).all(-1) & (g[:, None] < g).any(-1)
    assert not beaten.any()
    assert (found["place"] >= 64).any()
    # Each is what a check of its inputs says.
    at = int(np.argmin(g[:, 0]))
    again = bench.ask(found["inputs"][at][None])
    assert -g[at, 0] == pytest.approx(np.nanmin(again.margins), rel=1e-12)
    assert g[at, 2] == pytest.approx(float(again.mass[0]), rel=1e-12)


@pytest.mark.slow
def test_what_may_not_be_built_has_no_offspring_while_others_may():
    """The lightest tubes whirl: who breeds from them goes where nothing may be built."""
    thin = {n: v for n, v in RANGES.items() if "tube" in n}
    bench = Bench.of(
        application(), variants_of(thin | {"driveline.shafts[2].tube.outer_mm": [30, 125]})
    )
    goals = ("cost", "mass")
    drawn = Front(goals=goals, costs=costs(bench), drawing=bench.drawing).of(bench.rows(0, 8192), 0)
    none = {k: v[:0] for k, v in drawn.items()}
    found = bred(bench, goals, none, count=1024)
    assert found["verdict"].max() <= VERDICTS.index("warn")
    assert found["goals"][:, 1].min() < drawn["goals"][:, 1].min()


def test_the_same_seed_breeds_the_same():
    bench = Bench.of(application(), variants_of(RANGES))
    none = {k: v[:0] for k, v in brute(bench, 2).items()}
    one, same, other = (
        bred(bench, GOALS, none, count=130, seed=s)["inputs"].tolist() for s in (1, 1, 2)
    )
    assert one == same
    assert one != other


def test_a_study_tells_what_was_bred(tmp_path):
    told = """
study:
  vary: {shim_deg: [-3, 3], "driveline.shafts[2].tube.wall_mm": [2.5, 5]}
  ask: {pareto: [margin, mass], search: 200}
"""
    (tmp_path / "line.yaml").write_text(LINE + told)
    run = CliRunner().invoke(
        cli, ["study", str(tmp_path / "line.yaml"), "--n", "64", "--json", "-", "--quiet"]
    )
    assert run.exit_code == 0, run.stderr
    front = json.loads(run.stdout)["pareto"]
    assert max(p["variant"] for p in front) >= 64
    found = study(application(told), application(told).variants, count=64)
    assert f"of the {len(front)} variants of the front were bred" in "\n".join(
        report.terminal(found)
    )
    # What is told of shares is of those drawn alone.
    assert found.count == 64


def test_stopped_while_it_breeds_it_tells_of_what_was_drawn():
    asked = variants_of(RANGES, ask=Ask(pareto=GOALS, search=500))

    def stop(progress):
        assert progress.count == 564
        if progress.done > 64 + GENERATION:
            raise KeyboardInterrupt

    with pytest.raises(Stopped) as stopped:
        study(application(), asked, count=64, hear=stop)
    assert stopped.value.studied.count == 64
    assert (stopped.value.studied.states["pareto"]["place"] < 64).all()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("vary: {shim_deg: [-1, 1]}\n  ask: {search: 100}", "needs pareto"),
        ("vary: {shim_deg: [-1, 1]}\n  ask: {search: 0, pareto: [margin, cost]}", "from 1 to"),
        (
            "tolerances: {shim_deg: {normal: 1}}\n  ask: {search: 100, pareto: [margin, cost]}",
            "ask it without tolerances",
        ),
    ],
)
def test_what_cannot_be_bred_is_told_where_it_stands(text, told):
    with pytest.raises(BadFile, match=rf"(?s):2\d:\d+: .*{told}"):
        files.loads(f"{LINE}study:\n  {text}\n")


def test_without_tolerances_alone():
    bench = Bench.of(application(), variants_of({}, {"shim_deg": {"normal": 1.0}}))
    with pytest.raises(ValueError, match="without tolerances"):
        bred(bench, GOALS, {}, count=10)


def test_it_says_what_to_install(monkeypatch):
    def missing(name):
        raise ModuleNotFoundError(name)

    monkeypatch.setattr(breed, "import_module", missing)
    bench = Bench.of(application(), variants_of(RANGES))
    with pytest.raises(CardanError, match=r"cardan\[pareto\]"):
        bred(bench, GOALS, {}, count=10)
