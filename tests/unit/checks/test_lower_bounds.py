"""Forces of rubber beyond its stop are solved, or lower bounds wherever counted, shown or used."""

import csv
import io
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from slender_shafts import rods

import cardan
from cardan.application import reader
from cardan.approval.approval import approve_driveline
from cardan.checks.mount_loads import MountLoads
from cardan.cli import cli
from cardan.core.labels import EvaluationCondition
from cardan.core.provenance import MINER_1945
from cardan.core.units import MPa, hour
from cardan.core.verdict import Limit
from cardan.documents.approval_sheet import approval_sheet
from cardan.documents.bearing_force_table import bearing_force_csv
from cardan.documents.first_screen import points_before_signing
from cardan.model.bracket import Bracket, UShape
from cardan.model.material import Material
from cardan.render.check_texts import lower_bound_explanation, value_text
from cardan.render.i18n import ENGLISH
from cardan.topics.bracket.assessment import bracket_checks, duty_cycle_cases, load_cases
from cardan.topics.bracket.life import DamageResult
from cardan.topics.bracket.load_cases import BearingLoadCase
from cardan.topics.bracket.phrases import stop_notes
from cardan.topics.bracket.shape_result import BoltSlipUtilisation, FatigueFeature
from cardan.topics.design.correction import verdict_beyond_bounds

WITHIN, BEYOND = 8000, 12000
"""N m at which the mass goes 11.5 and 17 mm in resonance; a stop is assumed at 15 mm."""

AMPLE = (
    "limits: [{quantity: centre_bearing_peak, unit: N, normal: 1e5, maximum: 1e6, source: ours}]"
)
EXPLAINED = "≥ lower bound: rubber goes beyond its stop"
SHAPE = UShape(
    seat_diameter=0.1, width=0.07, thickness=0.006, height=0.09, flange=0.055,
    bend_radius=0.01, bolt_diameter=0.011, bolt_pitch=0.04,
)  # fmt: skip
PLAIN = Material(name="plain", youngs_modulus=200e9, density=7850)
SLOW, RESONANT = 100, 427
"""rpm of duty points: at the second order 2 meets the level mode on rubber, at 14.2 Hz."""


def text(torque: float, more: str = "") -> str:
    return rods(800, plane="level", torque=torque).replace("limits: protractor", AMPLE) + more


def response(torque: float, more: str = ""):
    return approve_driveline(reader.loads(text(torque, more))).line_responses[0]


def shown(tmp_path: Path, *torques: float, options: tuple[str, ...] = ()) -> str:
    files = []
    for torque in torques:
        files.append(str(tmp_path / f"{torque}.yaml"))
        Path(files[-1]).write_text(text(torque), encoding="utf-8")
    done = CliRunner(env={"COLUMNS": "120"}).invoke(cli, ["check", *files, *options])
    assert done.exit_code == 0, done.output
    return done.output


def test_variant_with_lower_bound_is_not_counted_as_buildable():
    """Both are within the limit; of one the force is only known to be at least so much."""
    found = cardan.study(
        reader.loads(text(WITHIN)), {"torque_Nm": {"grid": [WITHIN, BEYOND, 2]}}, n=2
    )
    assert found.shares == {"pass": 0.5, "warn": 0.0, "incomplete": 0.5, "fail": 0.0}
    assert found.yield_ == 0.5
    assert found.to_dict()["lower_bounds_alone"] == 0.5
    assert "Not shown to pass: 50.0 % do not fail" in str(found)


def test_margins_of_failing_variants_beyond_stop_are_marked_as_upper_bounds():
    """The check of one design solves the stop and finds more; the study says that it does not."""
    app = reader.loads(text(BEYOND).replace("normal: 1e5, maximum: 1e6", "maximum: 1000"))
    found = cardan.study(app, {"torque_Nm": {"grid": [BEYOND, BEYOND + 1, 2]}}, n=2)
    (limit,) = found.to_dict()["limits"]
    assert limit["lower_bounds"] == 1.0
    assert found.shares["fail"] == 1.0
    (solved,) = (c for c in approve_driveline(app).checks if c.margin < 0)
    assert solved.margin < 1.1 * limit["smallest_margin"]
    assert "≤ upper bound of a margin: in 100.0 %" in str(found)


@pytest.fixture
def unsolved(monkeypatch):
    """Let no line be solved with its stop: forces there are lower bounds."""
    monkeypatch.setattr(MountLoads, "stop_response_on", lambda *_: None)


def test_screen_holds_no_lower_bound_where_stop_is_solved(tmp_path):
    assert "≥" not in shown(tmp_path, BEYOND, options=("--all",))


@pytest.mark.parametrize(("shown", "marks"), [("12", ""), ("≥ 12", "≥"), ("≤ 12", "≤")])
def test_marks_of_bounds_are_explained_where_they_stand(shown, marks):
    assert [s[0] for s in lower_bound_explanation(["5", shown], ENGLISH)] == list(marks)


@pytest.mark.usefixtures("unsolved")
def test_approval_sheet_explains_lower_bounds_once():
    found = approve_driveline(reader.loads(text(BEYOND)))
    blocks = approval_sheet(found, helps=(), fixes=(), say=ENGLISH, state=None).blocks
    said = [p for b in blocks for p in getattr(b, "paragraphs", ()) if EXPLAINED in p]
    assert len(said) == 1


@pytest.mark.usefixtures("unsolved")
def test_correction_does_not_rest_on_a_lower_bound():
    """Its check warns; what the force is stays open."""
    bounded, known = (approve_driveline(reader.loads(text(t))) for t in (BEYOND, WITHIN))
    assert bounded.verdict == "warn"
    assert verdict_beyond_bounds("warn", bounded) == "incomplete"
    assert verdict_beyond_bounds("fail", bounded) == "fail"
    assert verdict_beyond_bounds("warn", known) == "warn"


@pytest.mark.usefixtures("unsolved")
@pytest.mark.parametrize(("torque", "beyond"), [(WITHIN, False), (BEYOND, True)])
def test_screens_and_tables_mark_and_explain_lower_bounds(tmp_path, torque, beyond):
    first, compared = shown(tmp_path, torque), shown(tmp_path, torque, WITHIN, options=("--all",))
    for screen in (first, compared):
        assert ("≥" in screen) == (EXPLAINED in screen) == beyond
    rows = list(csv.DictReader(io.StringIO(bearing_force_csv([response(torque)]))))
    assert ("1" in {row["lower_bound"] for row in rows}) == beyond
    slow = [row for row in rows if float(row["speed_rpm"]) < 200]
    assert {row["lower_bound"] for row in slow} == {"0"}


@pytest.mark.usefixtures("unsolved")
@pytest.mark.parametrize(("torque", "beyond"), [(WITHIN, False), (BEYOND, True)])
def test_quantity_in_python_is_what_the_verdict_has_and_says_where_a_bound(torque, beyond):
    """It was linear rubber's force, less than the bound that the verdict is of."""
    found = cardan.check(reader.loads(text(torque)))
    listed = found.quantity("centre_bearing_peak")
    checks = {(c.when, c.part): c for c in found.checks if c.quantity == "centre_bearing_peak"}
    assert len(listed.values) == len(checks) > 0
    for v in listed.values:
        check = checks[v.when, v.part]
        assert (v.value, v.is_lower_bound) == (check.value, check.is_lower_bound)
        assert (">= " in repr(v)) == v.is_lower_bound == beyond
    assert listed.to_frame()["is_lower_bound"].tolist() == [beyond] * len(checks)


def test_load_cases_of_bracket_beyond_stop_are_lower_bounds():
    bracket = Bracket(shape=SHAPE, material=PLAIN)
    for torque, beyond in ((WITHIN, False), (BEYOND, True)):
        points = [
            {"share_percent": 50, "torque_Nm": torque, "speed_rpm": speed}
            for speed in (SLOW, RESONANT)
        ]
        r = response(torque, yaml.safe_dump({"duty": points}))
        cases = {c.component: c for c in load_cases(bracket, r)}
        assert (cases["worst point"].stop_margin < 0) == beyond
        assert all((c.stop_margin < 0) == beyond for c in cases["worst point"].alternatives)
        assert cases["combined"].stop_margin == np.inf  # of rigid bearings
        for parts in duty_cycle_cases(bracket, r).values():
            assert [case.stop_margin < 0 for _, case in parts] == [False, beyond]


@pytest.mark.parametrize("margin", [np.inf, -0.3])
def test_bracket_check_of_loads_beyond_stop_warns_at_best(margin):
    """A stress is at least, a life at most, that of linear rubber; what fails fails."""
    beyond = margin < 0
    case = BearingLoadCase("gvw", np.zeros((1, 9)), stop_margin=margin)
    sheet = FatigueFeature(zone="sheet", number=1, point=(0, 0, 0), error=0.0)
    when = EvaluationCondition("duty", "gvw")
    spent = DamageResult(
        when=when, hot_spot_damage=np.array([1e-4]), gauge_damage=np.zeros(0), turns=1.0,
        duration=hour, stop_margin=margin,
    )  # fmt: skip
    outcome = SimpleNamespace(
        case=case, damage_result=None, feature_stress=np.array([100 * MPa]),
        feature_stress_error=np.zeros(1), min_feature_stress=np.array([100 * MPa]),
        utilisation=np.array([0.5]), favourable_utilisation=np.array([0.5]),
        utilisation_bounds=np.array([[0.5, 0.5]]),
    )  # fmt: skip
    judged: Any = SimpleNamespace(
        case_results=(outcome,), duty_damage=(spent,), features=(sheet,),
        bolt_slips=(BoltSlipUtilisation(when, 0.5, None, margin),),
    )  # fmt: skip
    steel = replace(PLAIN, yield_strength=355 * MPa)
    of: Any = SimpleNamespace(bracket=Bracket(shape=SHAPE, material=steel))
    shares = [
        Limit(quantity=f"bracket_{q}_utilisation", maximum=1.0, source=MINER_1945)
        for q in ("stress", "fatigue", "slip")
    ]
    life = Limit(quantity="bracket_life", maximum=5000 * hour, sense=">=", source=MINER_1945)
    checks = list(bracket_checks(of, judged, (*shares, life)))
    assert {c.grade for c in checks} == {"warn" if beyond else "pass"}
    assert [c.is_lower_bound for c in checks] == [beyond] * 4
    assert [value_text(c, ENGLISH)[0] for c in checks if beyond] == list("≥≥≥≤") * beyond
    assert len(list(stop_notes(judged, ENGLISH))) == beyond
    (failed,) = bracket_checks(of, judged, [Limit(
        quantity="bracket_stress_utilisation", maximum=0.1, source=MINER_1945)])  # fmt: skip
    assert failed.grade == "fail"


def test_value_that_looks_wrong_is_first_before_signing():
    slip = text(BEYOND).replace("length_mm: 1500", "length_mm: 1500\n      phase_deg: 3")
    points = points_before_signing(approve_driveline(reader.loads(slip)), ENGLISH)
    assert points[0].startswith("values, given or assumed, that look wrong: ")
    assert "driveline.shafts[2].phase_deg" in points[0]
    assert "assumed" in " ".join(points[1:])


@pytest.mark.usefixtures("unsolved")
def test_numbers_of_a_state_are_those_of_the_checks_beyond_a_stop(tmp_path):
    """Linear rubber gave another number in the table of states than in the check, unmarked."""
    found = approve_driveline(reader.loads(text(BEYOND)))
    (check,) = (c for c in found.checks if c.quantity == "centre_bearing_peak")
    assert check.is_lower_bound
    printed = shown(tmp_path, BEYOND, options=("--states",))
    assert f"≥ {ENGLISH.number(check.value)}" in printed
