"""How far a centre bearing goes on its rubber: by hand, and against the stop that a file tells."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from repository import EXAMPLES
from slender_shafts import LEVEL, LOSS, UP, rods

import cardan
from cardan.application import overrides, reader
from cardan.approval.driveline_study import evaluate_limits
from cardan.checks.line_response import compute_line_response
from cardan.checks.quantities.registry import QUANTITIES
from cardan.cli import cli
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references

COLLECTOR = (EXAMPLES / "refuse-collector-6x2.yaml").read_text(encoding="utf-8")
KEY = "centre_bearing_travel_utilisation"
FORCES_AT_PEAK = ("centre_bearing_dynamic", "centre_bearing_peak")


def told(folder: Path, text: str) -> dict:
    file, out = folder / "line.yaml", folder / "line.json"
    file.write_text(text, encoding="utf-8")
    done = CliRunner().invoke(cli, ["check", str(file), "--json", str(out), "-q"])
    assert done.exit_code in (0, 1), done.output
    return json.loads(out.read_text(encoding="utf-8"))


def bearing(folder: Path, text: str) -> dict:
    return told(folder, text)["states"][0]["centre_bearings"][0]


PLANES = pytest.mark.parametrize(("plane", "stiffness"), [("level", LEVEL), ("upright", UP)])


@PLANES
def test_quasi_static_travel_is_force_over_stiffness(tmp_path, plane, stiffness):
    """The mean of crosses that bend in a plane lies in it, and order 2 goes round in a circle.

    So the mean presses the rubber of its own way, and order 2 goes farthest where that is softer:
    at standstill, as rubber that turns loses, and is stiffer.
    """
    found = bearing(tmp_path, rods(10, plane=plane))
    steady, swing = np.linalg.norm(found["static_N"]), found["orders"]["2"]
    goes = found["on_rubber"]["travel"]
    assert goes["steady_mm"] == pytest.approx(steady / stiffness, rel=1e-5)
    assert goes["travel_mm"] == pytest.approx(steady / stiffness + swing / LEVEL, rel=1e-3)
    assert goes["speed_rpm"] == 0
    assert goes["stop_mm"] is None


def swung(swing: float, speed: np.ndarray) -> np.ndarray:
    """Return how far a force that goes round twice a turn swings 15 kg on two springs, in mm.

    Level x and upright y are masses on one spring each, x = F/(k (1 + iη) - m W²); half the
    longer axis of the ellipse of (x, i y) is √((|x|² + |y|² + |x² - y²|)/2).
    """
    W = 2 * speed * np.pi / 30
    x, y = (swing / (1000 * k * (1 + 1j * LOSS) - 15 * W**2) for k in (LEVEL, UP))
    return 1000 * np.sqrt((abs(x) ** 2 + abs(y) ** 2 + abs(x**2 - y**2)) / 2)


@pytest.mark.slow
@PLANES
@pytest.mark.parametrize("top", [300, 800])
def test_travel_in_resonance_matches_single_mass_oscillator(tmp_path, plane, stiffness, top):
    """Its modes are at 427 and 551 rpm: at 300 it is worst at its highest speed, at 800 there."""
    found = bearing(tmp_path, rods(top, plane=plane))
    steady, swing = np.linalg.norm(found["static_N"]), found["orders"]["2"]
    speeds = np.arange(1.0, top + 0.5, 0.5)
    closed = swung(swing, speeds)
    goes = found["on_rubber"]["travel"]
    assert goes["travel_mm"] == pytest.approx(steady / stiffness + closed.max(), rel=2e-3)
    assert goes["speed_rpm"] == pytest.approx(speeds[closed.argmax()], rel=2e-3)


def test_bearing_travel_excludes_bracket_deflection(tmp_path):
    """The same force goes through both, and a bracket as soft as the rubber gives as much."""
    seat = "bracket: {stiffness_N_mm: [1e6, 120, 200]}"
    alone, hung = (bearing(tmp_path, rods(10, plane="level", more=m)) for m in ("", seat))
    alone, hung = (b["on_rubber"]["travel"]["travel_mm"] for b in (alone, hung))
    assert hung == pytest.approx(alone, rel=0.01)


def test_gravity_does_not_change_bearing_travel(tmp_path):
    light, heavy = (bearing(tmp_path, rods(10, plane="level") + more)
                    for more in ("", "include: [gravity]\n"))  # fmt: skip
    assert heavy["static_N"][2] < light["static_N"][2] - 100
    light, heavy = (b["on_rubber"]["travel"]["steady_mm"] for b in (light, heavy))
    assert heavy == pytest.approx(light, rel=1e-6)


def without(key: str) -> str:
    """Return the collector without a key at its left edge."""
    return re.sub(rf"(?ms)^{key}:.*?(?=^\w|\Z)", "", COLLECTOR)


def stopped(at: str, *, bearings: int = 2) -> str:
    """Return the collector whose bearings' rubber ends somewhere."""
    return COLLECTOR.replace("centre_bearing: {", f"centre_bearing: {{travel_mm: {at}, ", bearings)


@pytest.mark.slow
def test_travel_over_stop_is_checked_for_every_state(tmp_path):
    """Its second bearing goes 36.3 mm in jounce: 37 hold that, 36.2 do not.

    Just beyond the stop forces of that state are next to those of linear rubber; others stay.
    """
    plain = told(tmp_path, stopped("100"))
    plain["checks"] = [c for c in plain["checks"] if c["quantity"] != KEY]
    assert not [c for c in plain["checks"] if c["quantity"] == KEY]
    assert not any("beyond its stop" in n for n in plain["notes"])
    goes = {
        (s["name"], k): b["on_rubber"]["travel"]["travel_mm"]
        for s in plain["states"] for k, b in enumerate(s["centre_bearings"], 1)
    }  # fmt: skip
    farthest = max(goes.values())
    assert farthest == goes["jounce", 2] == pytest.approx(36.30, abs=0.05)
    for stop, verdict in ((37, "pass"), (36.2, "fail")):
        found = told(tmp_path, stopped(str(stop)))
        checks = {(c["state"], c["part"]): c for c in found["checks"] if c["quantity"] == KEY}
        assert len(checks) == len(goes)
        for (state, k), mm in goes.items():
            one = checks[state, f"centre bearing {k}"]
            assert one["value"] == pytest.approx(mm / stop, rel=1e-6)
            assert one["limit"] == 1.0
        assert checks["jounce", "centre bearing 2"]["verdict"] == verdict
        assert checks["jounce", "centre bearing 2"]["mode"]["order"] == 2
        beyond = [n for n in found["notes"] if "meets its stop" in n]
        assert len(beyond) == (verdict == "fail")
        others = [c for c in found["checks"] if c["quantity"] != KEY]
        for one, was in zip(others, plain["checks"], strict=True):
            at_stop = verdict == "fail" and one["state"] == "jounce"
            free = not (at_stop and one["quantity"].startswith("centre_bearing"))
            assert one["value"] == pytest.approx(was["value"], rel=1e-9 if free else 0.03)
        assert not any(c.get("is_lower_bound") for c in others)
    assert beyond[0].startswith(
        "centre bearing 2 of line main meets its stop in jounce: linear rubber would move by up to "
        "36.3 mm, and has 36.2; beyond that it is taken as 5–20 times as stiff, peak force "
    )


AMPLE = "\n".join((
    "limits:",
    *(f"  - {{quantity: centre_bearing_{kind}, unit: N, maximum: 1e5, source: ours}}"
      for kind in ("static", "dynamic", "peak")),
))  # fmt: skip


def forces(folder: Path, *, torque: float, travel: float | None = None) -> dict[str, dict]:
    """Return the checks of rods' forces by kind, all far within their limits."""
    more = "" if travel is None else f"travel_mm: {travel}"
    text = rods(800, plane="level", torque=torque, more=more)
    checks = told(folder, text.replace("limits: protractor", AMPLE))["checks"]
    return {c["quantity"].removeprefix("centre_bearing_"): c for c in checks}


@pytest.mark.parametrize(
    ("torque", "travel", "beyond"),
    [(8000, None, False), (12000, None, True), (8000, 12, False), (8000, 11, True)],
)
def test_force_beyond_given_or_assumed_stop_is_solved(tmp_path, torque, travel, beyond):
    """At 8 kN m the mass goes 11.5 mm in resonance, at 12 kN m 17; a stop is assumed at 15 mm.

    At its stop rubber pushes with 120 N/mm on the softer side, and its crest is higher.
    """
    found = forces(tmp_path, torque=torque, travel=travel)
    linear = forces(tmp_path, torque=torque, travel=100)
    assert found["static"]["verdict"] == "pass"
    for kind in ("dynamic", "peak"):
        assert found[kind]["verdict"] == "pass"
        assert "is_lower_bound" not in found[kind]
        if beyond:
            assert 1.02 < found[kind]["value"] / linear[kind]["value"] < 1.6
        else:
            assert found[kind]["value"] == linear[kind]["value"]
    if beyond:
        assert found["peak"]["value"] > LEVEL * (travel or 15)


def test_required_limit_is_evaluated_beyond_given_stop(tmp_path):
    """Some 1500 N, of 1300 or of 3000."""
    limit = (
        "limits: [{quantity: centre_bearing_peak, unit: N, maximum: 3000, required: true, "
        "source: ours}]"
    )
    text = rods(800, plane="level", torque=8000, more="travel_mm: 11")
    text = text.replace("limits: protractor", limit)
    assert told(tmp_path, text)["verdict"] == "pass"
    (failed,) = told(tmp_path, text.replace("maximum: 3000", "maximum: 1300"))["checks"]
    assert (failed["verdict"], failed["value"] > LEVEL * 11) == ("fail", True)


def test_stop_no_stiffer_than_rubber_changes_nothing(tmp_path):
    """With a stop as stiff as the rubber before it a line is linear."""
    more = "travel_mm: 6\n        stop_stiffness_ratio: 1"
    text = rods(800, plane="level", torque=8000, more=more)
    free = text.replace(more, "travel_mm: 60")
    at, plain = (bearing(tmp_path, t)["on_rubber"] for t in (text, free))
    assert at["at_stop"]["stiffness_ratio"] == [1]
    assert at["at_stop"]["dynamic_N"][0] == pytest.approx(plain["worst"]["dynamic_N"], rel=0.01)
    assert at["at_stop"]["peak_N"][0] == pytest.approx(plain["worst"]["peak_N"], rel=0.01)
    assert at["at_stop"]["travel_mm"][0] == pytest.approx(plain["travel"]["travel_mm"], rel=0.01)
    assert "at_stop" not in plain


def test_stiffer_stop_carries_more_and_its_range_is_told(tmp_path):
    text = rods(800, plane="level", torque=8000, more="travel_mm: 9")
    found = bearing(tmp_path, text)["on_rubber"]["at_stop"]
    assert found["stiffness_ratio"] == [5, 20]
    soft, stiff = found["peak_N"]
    far, near = found["travel_mm"]
    assert soft < stiff
    assert 9 < near < far
    for k, ratio in enumerate((5, 20)):
        given = text.replace("travel_mm: 9", f"travel_mm: 9\n        stop_stiffness_ratio: {ratio}")
        alone = bearing(tmp_path, given)["on_rubber"]["at_stop"]
        assert alone["peak_N"] == pytest.approx([found["peak_N"][k]], rel=1e-6)


def test_verdict_that_turns_with_stiffness_beyond_stop_says_so(tmp_path):
    text = rods(800, plane="level", torque=8000, more="travel_mm: 9")
    soft, stiff = bearing(tmp_path, text)["on_rubber"]["at_stop"]["peak_N"]
    limit = f"maximum: {(soft + stiff) / 2:.0f}"
    (peak,) = (
        c for c in told(tmp_path, text.replace("limits: protractor", AMPLE.replace(
            "maximum: 1e5", limit)))["checks"] if c["quantity"] == "centre_bearing_peak"
    )  # fmt: skip
    assert peak["verdict"] == "fail"
    assert peak["may_be_as_good_as"] == "pass"
    names = {a["input"]: (a["low"], a["high"]) for a in peak["assumed"]}
    assert names["centre_bearing.stop_stiffness_ratio"] == (5, 20)
    assert peak["value_within"][0] <= soft


def test_hot_rubber_that_meets_its_stop_is_solved_with_it(tmp_path):
    """Rubber as given goes 11.5 mm of 12; hot, of 0.7 of its stiffness, linear rubber 16."""
    text = rods(800, plane="level", torque=8000, more="travel_mm: 12")
    cold = bearing(tmp_path, text)["on_rubber"]["worst"]["peak_N"]
    soft = text.replace(f"N_mm: {UP}", f"N_mm: {0.7 * UP}").replace(
        f"N_mm: {LEVEL}", f"N_mm: {0.7 * LEVEL}"
    )
    hot = bearing(tmp_path, soft)["on_rubber"]["at_stop"]["peak_N"][-1]
    assert hot > 1.05 * cold
    limit = AMPLE.replace("maximum: 1e5", f"maximum: {1.02 * cold:.1f}")
    (peak,) = (
        c
        for c in told(tmp_path, text.replace("limits: protractor", limit))["checks"]
        if c["quantity"] == "centre_bearing_peak"
    )
    assert (peak["verdict"], peak["may_be"]) == ("pass", "fail")
    assert "centre_bearing.stiffness_range" in {a["input"] for a in peak["assumed"]}
    assert peak["value_within"][1] >= hot * 0.999


@pytest.mark.slow
@pytest.mark.parametrize(("ratio", "tolerance"), [(5, 0.02)])
def test_force_at_stop_matches_integration_in_time(tmp_path, ratio, tolerance):
    """15 kg on two springs with a stop at 5 mm, by SciPy through rising speeds, the motion kept.

    The rubber's damper is that of order 2, the stop's as the rubber's; the force is without the
    stop's damper, which jumps where the stop is met.
    """
    from scipy.integrate import solve_ivp

    more = f"travel_mm: 5\n        stop_stiffness_ratio: {ratio}"
    at = bearing(tmp_path, rods(800, plane="level", torque=8000, more=more))
    swing, steady = at["orders"]["2"], np.linalg.norm(at["static_N"])
    found = at["on_rubber"]["at_stop"]
    k, stop = 1000 * np.array([LEVEL, UP]), 5e-3

    def rubber(x):
        far = np.hypot(*x)
        if far <= stop:
            return k * x
        n, gap = x / far, far - stop
        kn = k @ n**2
        return k * x + (ratio - 1) * gap * (kn * n + gap / far * (k - kn) * n)

    def motion(t, state, W):
        x, v = state[:2], state[2:]
        lost = LOSS / W * (rubber(x + 1e-7 * v) - rubber(x - 1e-7 * v)) / 2e-7
        pushed = np.array([steady + swing * np.cos(W * t), swing * np.sin(W * t)])
        return np.concatenate([v, (pushed - rubber(x) - lost) / 15])

    state, largest = np.zeros(4), 0.0
    for rpm in np.arange(380.0, found["speed_rpm"] * 1.04, 0.015 * found["speed_rpm"]):
        W = 2 * rpm * np.pi / 30
        turns = 20 * 2 * np.pi / W
        times = np.linspace(0.9 * turns, turns, 400)
        done = solve_ivp(motion, (0, turns), state, args=(W,), t_eval=times, rtol=1e-4, atol=1e-7)
        state = done.y[:, -1]
        forces = np.array([rubber(x) + LOSS / W * k * v for x, v in zip(
            done.y[:2].T, done.y[2:].T, strict=True)])  # fmt: skip
        mean = forces[:-1].mean(axis=0)
        largest = max(largest, np.linalg.norm(forces - mean, axis=1).max())
    assert found["dynamic_N"][0] == pytest.approx(largest, rel=tolerance)


@pytest.mark.slow
def test_stop_of_one_bearing_is_checked_for_that_bearing_only(tmp_path):
    text = stopped("20").replace("travel_mm: 20, ", "", 1)
    parts = {c["part"] for c in told(tmp_path, text)["checks"] if c["quantity"] == KEY}
    assert parts == {"centre bearing 2"}


@pytest.mark.slow
def test_travel_is_noted_if_stop_is_unknown(tmp_path):
    """Beside a stop that is known, and nothing in the way, the stop speaks for itself."""
    text = without("obstacles")
    loose = [n for n in told(tmp_path, text)["notes"] if "linear" in n]
    assert "centre bearing 2" in loose[0]
    kept = text.replace("centre_bearing: {", "centre_bearing: {travel_mm: 40, ")
    assert not [n for n in told(tmp_path, kept)["notes"] if "linear" in n]
    (other,) = (n for n in told(tmp_path, kept.replace("travel_mm: 40, ", "", 1))["notes"]
                if "linear" in n)  # fmt: skip
    assert "centre bearing 1" in other


def test_travel_of_rigid_bearing_is_rejected(tmp_path):
    file = tmp_path / "line.yaml"
    text = rods(10, plane="level", more="travel_mm: 15")
    for name, value in (("vertical", UP), ("lateral", LEVEL)):
        text = text.replace(f"{name}_stiffness_N_mm: {value}\n", "\n")
    file.write_text(text, encoding="utf-8")
    done = CliRunner().invoke(cli, ["check", str(file)])
    assert done.exit_code == 2
    assert "centre_bearing.travel_mm: what gives has a travel" in done.output


@pytest.mark.slow
def test_rigid_bearing_has_no_travel_to_limit(tmp_path):
    limits = "limits: [{quantity: centre_bearing_travel, unit: mm, maximum: 36.2, source: ours}]\n"
    checks = told(tmp_path, without("limits") + "\n" + limits)["checks"]
    about = "centre_bearing_travel"
    failed = {
        (c["state"], c["part"]) for c in checks if c["quantity"] == about and c["verdict"] == "fail"
    }
    assert failed == {("jounce", "centre bearing 2")}
    rigid = rods(10, plane="level").replace("limits: protractor\n", limits)
    for name, value in (("vertical", UP), ("lateral", LEVEL)):
        rigid = rigid.replace(f"{name}_stiffness_N_mm: {value}\n", "\n")
    found = told(tmp_path, rigid)
    assert about not in {u["quantity"] for u in found["coverage"]["unanswered"]}
    assert about not in {c["quantity"] for c in found["checks"]}
    assert any("evaluated as rigid" in note for note in found["notes"])


@pytest.mark.slow
def test_batch_of_stops_and_stiffness_equals_single_variants():
    """Of a batch each variant has the numbers of a batch of its own, lower bounds too."""
    truck = reader.loads(stopped("60"))
    at = "driveline.shafts[2].centre_bearing."
    drawn = {
        at + "travel_mm": np.array([30.0, 40.0, 60.0]),
        at + "lateral_stiffness_N_mm": np.array([100.0, 120.0, 150.0]),
    }

    def answers(changes):
        changed = overrides.change(truck, changes)
        r = compute_line_response(
            changed, line_state_demand(resolve_line_references(changed, changed.lines[0]))
        )
        found = {q.limit.quantity: q for q in evaluate_limits(r)}
        peak = found["centre_bearing_peak"]
        return (
            found[KEY].values,
            QUANTITIES["centre_bearing_travel"].values(r),
            peak.values,
            *peak.grades_and_margins(),
        )

    together = answers(drawn)
    for k in range(3):
        alone = answers({name: values[k : k + 1] for name, values in drawn.items()})
        for found, expected in zip(together, alone, strict=True):
            assert found[k] == pytest.approx(expected[0], rel=1e-9, nan_ok=True)
    assert together[0][0].max() > 1.2 > together[0][2].max()


@pytest.mark.slow
def test_study_computes_travel_over_stop_for_each_variant():
    """Every variant's worst is the 36.30 mm of the second bearing in jounce, over its own stop."""
    at = "driveline.shafts[2].centre_bearing.travel_mm"
    found = cardan.study(reader.loads(stopped("40")), {at: [30, 44]}, n=8).to_frame()
    assert list(found[KEY]) == pytest.approx(list(36.3036 / found[at]), rel=1e-4)
    assert found[KEY].min() < 1 < found[KEY].max()
