"""Fronts that are bred: NSGA-II held against brute force."""

import json
from functools import cache

import numpy as np
import pytest
from click.testing import CliRunner

from cardan.application import reader
from cardan.cli import cli
from cardan.core.errors import CardanError, InvalidFileError
from cardan.core.verdict import VERDICTS
from cardan.model.variants import VariantOutputs
from cardan.topics.variants import pareto as breed
from cardan.topics.variants.evaluation import VariantEvaluator, build_variants
from cardan.topics.variants.pareto import GENERATION_SIZE, evolve_pareto_front
from cardan.topics.variants.presentation import terminal_lines
from cardan.topics.variants.runner import run_study
from cardan.topics.variants.statistics import ParetoFront, adjustable_of_each_input
from cardan.topics.variants.study_result import StudyInterrupted

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
    return reader.loads(LINE + more)


def brute(bench, count):
    """Return what is unbeaten of so many variants drawn."""
    return ParetoFront(
        goals=GOALS, costs=adjustable_of_each_input(bench), sampling_plan=bench.sampling_plan
    ).shard_state(bench.evaluate_range(0, count), 0)


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


@pytest.mark.slow
def test_pareto_search_finds_exact_front_of_small_grid():
    crossed = {n: s if "grid" in s else {"grid": [0, 90, 2]} for n, s in STEPS.items()}
    every = VariantEvaluator.from_application(application(), build_variants(crossed))
    whole = brute(every, every.sampling_plan.group_size)
    bench = VariantEvaluator.from_application(application(), build_variants(STEPS))
    none = {k: v[:0] for k, v in whole.items()}
    found = evolve_pareto_front(bench, GOALS, none, count=1500)
    assert found["verdict"].tolist() == [0] * len(found["verdict"])
    # The order of the same front: by goals.
    np.testing.assert_allclose(
        np.unique(found["goals"].round(9), axis=0),
        np.unique(whole["goals"].round(9), axis=0),
    )
    assert len(np.unique(whole["goals"].round(9), axis=0)) >= 5


@pytest.mark.slow
def test_pareto_search_beats_ten_times_as_many_random_variants():
    bench = VariantEvaluator.from_application(application(), build_variants(RANGES))
    drawn, few = brute(bench, 8192), brute(bench, 64)
    found = evolve_pareto_front(bench, GOALS, few, count=768, start=64)
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
    again = bench.evaluate(found["inputs"][at][None])
    assert -g[at, 0] == pytest.approx(np.nanmin(again.margins), rel=1e-12)
    assert g[at, 2] == pytest.approx(float(again.mass[0]), rel=1e-12)


@pytest.mark.slow
def test_infeasible_variants_are_not_selected_as_parents():
    """The lightest tubes whirl: who breeds from them goes where nothing may be built."""
    thin = {n: v for n, v in RANGES.items() if "tube" in n}
    bench = VariantEvaluator.from_application(
        application(), build_variants(thin | {"driveline.shafts[2].tube.outer_mm": [30, 125]})
    )
    goals = ("cost", "mass")
    drawn = ParetoFront(
        goals=goals, costs=adjustable_of_each_input(bench), sampling_plan=bench.sampling_plan
    ).shard_state(bench.evaluate_range(0, 8192), 0)
    none = {k: v[:0] for k, v in drawn.items()}
    found = evolve_pareto_front(bench, goals, none, count=1024)
    assert found["verdict"].max() <= VERDICTS.index("warn")
    assert found["goals"][:, 1].min() < drawn["goals"][:, 1].min()


@pytest.mark.slow
def test_same_seed_gives_same_pareto_search():
    bench = VariantEvaluator.from_application(application(), build_variants(RANGES))
    none = {k: v[:0] for k, v in brute(bench, 2).items()}
    one, same, other = (
        evolve_pareto_front(bench, GOALS, none, count=130, seed=s)["inputs"].tolist()
        for s in (1, 1, 2)
    )
    assert one == same
    assert one != other


@pytest.mark.slow
def test_study_reports_pareto_search_results(tmp_path):
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
    found = run_study(application(told), application(told).variants, count=64)
    assert f"of the {len(front)} variants of the front were bred" in "\n".join(
        terminal_lines(found)
    )
    # What is told of shares is of those drawn alone.
    assert found.count == 64


def test_interrupted_pareto_search_keeps_sampled_results():
    asked = build_variants(RANGES, ask=VariantOutputs(pareto=GOALS, search=500))

    def stop(progress):
        assert progress.count == 564
        if progress.done > 64 + GENERATION_SIZE:
            raise KeyboardInterrupt

    with pytest.raises(StudyInterrupted) as stopped:
        run_study(application(), asked, count=64, hear=stop)
    assert stopped.value.result.count == 64
    assert (stopped.value.result.statistics["pareto"]["place"] < 64).all()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("vary: {shim_deg: [-1, 1]}\n  ask: {search: 100}", "needs pareto"),
        ("vary: {shim_deg: [-1, 1]}\n  ask: {search: 0, pareto: [margin, cost]}", "from 1 to"),
        (
            "tolerances: {shim_deg: {normal: 1}}\n  ask: {search: 100, pareto: [margin, cost]}",
            "remove tolerances",
        ),
    ],
)
def test_invalid_pareto_search_is_rejected_at_its_line(text, told):
    with pytest.raises(InvalidFileError, match=rf"(?s):2\d:\d+: .*{told}"):
        reader.loads(f"{LINE}study:\n  {text}\n")


def test_pareto_search_of_tolerances_alone_is_rejected():
    bench = VariantEvaluator.from_application(
        application(), build_variants({}, {"shim_deg": {"normal": 1.0}})
    )
    with pytest.raises(ValueError, match="remove tolerances"):
        evolve_pareto_front(bench, GOALS, {}, count=10)


def test_missing_pareto_package_error_names_extra_to_install(monkeypatch):
    def missing(name):
        raise ModuleNotFoundError(name)

    monkeypatch.setattr(breed, "import_module", missing)
    bench = VariantEvaluator.from_application(application(), build_variants(RANGES))
    with pytest.raises(CardanError, match=r"cardan\[pareto\]"):
        evolve_pareto_front(bench, GOALS, {}, count=10)
