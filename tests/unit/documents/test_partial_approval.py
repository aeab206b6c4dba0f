"""What an approval is not of stands in its headline, in every medium and language."""

import io
import json
import re

import pytest
from click.testing import CliRunner
from repository import EXAMPLES

from cardan.application import reader, templates
from cardan.application.limit_profiles import load_profile, profile_names
from cardan.approval.approval import approve_application, approve_driveline
from cardan.cli import cli
from cardan.documents.workbook import workbook_bytes
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.phrases import verdict_text

SLOPES = """\
title: Under the truck
speed_rpm: 2500
torque_Nm: 3000
driveline:
  slopes: {side_deg: [4.0, 2.0, 4.0]}
  shafts: [{}]
limits: protractor
"""
SHAFT = SLOPES.replace("{}", "{length_mm: 1200, tube: 100x3}")
SPEED, STRENGTH = "critical_speed_ratio", "tube_shear_utilisation"
HEADLINES = {
    "en": "angles approved; speed and strength not evaluated",
    "pt": "ângulos aprovados; rotação e resistência não avaliadas",
    "it": "angoli conformi; velocità e resistenza non valutate",
}


def headline(text: str, lang: str = "en") -> str:
    return verdict_text(approve_driveline(reader.loads(text)), Translator(lang))


def check(folder, text: str, *options: str):
    file = folder / "line.yaml"
    file.write_text(text, encoding="utf-8")
    return CliRunner().invoke(cli, ["check", str(file), *options], catch_exceptions=False)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (SLOPES, "angles approved; speed and strength not evaluated"),
        (SHAFT.replace("speed_rpm: 2500\n", ""), "INCOMPLETE"),  # accelerations are required
        (SHAFT.replace("torque_Nm: 3000\n", ""), "angles approved; strength not evaluated"),
        (SHAFT.replace("tube: 100x3", "tube: {outer_mm: 100, wall_mm: 3, material: steel}"),
         "angles approved; strength not evaluated"),  # a steel without a strength
        (SHAFT, "APPROVED"),
        (SLOPES.replace("4.0]", "2.7]"), "angles approved with warnings; speed and strength not "
         "evaluated"),
        (SLOPES.replace("[4.0", "[20.0"), "NOT APPROVED"),
    ],
)  # fmt: skip
def test_headline_says_what_is_not_evaluated(text, said):
    assert headline(text) == said


@pytest.mark.slow
@pytest.mark.parametrize("lang", HEADLINES)
def test_every_medium_has_the_headline(tmp_path, lang):
    said = HEADLINES[lang]
    assert headline(SLOPES, lang) == said
    printed = check(tmp_path, SLOPES, "--lang", lang, "--html", str(tmp_path / "line.html"))
    assert said in " ".join(printed.stdout.split())
    assert "APPROVED" not in printed.stdout
    page = (tmp_path / "line.html").read_text(encoding="utf-8")
    assert said in re.sub(r"<[^>]+>", "", page)
    document = json.loads(check(tmp_path, SLOPES, "--json").stdout)
    assert document["headline"] == HEADLINES["en"]
    assert document["not_evaluated"] == ["speed", "strength"]
    openpyxl = pytest.importorskip("openpyxl")
    book = workbook_bytes(approve_driveline(reader.loads(SLOPES)), say=Translator(lang))
    cached = openpyxl.load_workbook(io.BytesIO(book), data_only=True).worksheets[0]
    cells = {str(c.value) for row in cached.iter_rows(max_row=8) for c in row}
    assert said in cells
    assert any(cell.startswith(f"{said} (") for cell in cells)  # as computed
    live = openpyxl.load_workbook(io.BytesIO(book)).worksheets[0]
    formulas = [str(c.value) for row in live.iter_rows(max_row=8) for c in row]
    assert any(f'"{said}"' in f for f in formulas if f.startswith("="))


def test_workbench_shows_the_headline():
    from cardan.web.handlers import _full_result
    from cardan.web.parsed_document import parse_document

    read = parse_document(SLOPES, "line.yaml", None)
    assert _full_result(read, {}, ENGLISH, lambda _: None)["headline"] == HEADLINES["en"]
    whole = parse_document(SHAFT, "line.yaml", None)
    assert _full_result(whole, {}, ENGLISH, lambda _: None)["headline"] == "APPROVED"


LONG = SHAFT.replace("length_mm: 1200", "length_mm: 2600")
OVERLOADED = SHAFT.replace("torque_Nm: 3000", "torque_Nm: 30000")


@pytest.mark.parametrize(
    "limits",
    [
        *profile_names(),
        "{profile: protractor, overrides: [{quantity: joint_angle, maximum: 9, source: us}]}",
    ],
)
@pytest.mark.parametrize(("text", "quantity"), [(LONG, SPEED), (OVERLOADED, STRENGTH)])
def test_speed_and_strength_are_criteria_of_every_profile(limits, text, quantity):
    """A shaft at 1.1 times its critical speed passed by a profile of angles."""
    found = approve_driveline(reader.loads(text.replace("protractor", limits)))
    assert found.verdict == "fail"
    assert quantity in {c.quantity for c in found.checks if c.grade == "fail"}


def test_vehicle_on_bearings_without_rubber_is_no_bare_approval():
    """Left out, the stiffness of the rubber turned 3144 N, a fail, into 300 N, a pass."""
    text = templates.template_text("bus").replace("limits: medium-truck", "limits: body-builder")
    soft = approve_driveline(reader.loads(text))
    assert soft.not_evaluated == ()
    rigid = re.sub(r", (vertical_|lateral_)?stiffness_N_mm: \d+|, loss_factor: [\d.]+", "", text)
    found = approve_driveline(reader.loads(rigid))
    assert found.not_evaluated == ("rubber of the centre bearings",)
    said = verdict_text(found, ENGLISH)
    assert said.startswith("approved")
    assert said.endswith("centre bearings taken as rigid, without rubber")


def test_limits_of_the_file_alone_tell_what_they_do_not_ask():
    own = LONG.replace("protractor", "[{quantity: joint_angle, maximum: 10, source: ours}]")
    found = approve_driveline(reader.loads(own))
    assert found.not_evaluated == ("speed", "strength")
    assert verdict_text(found, ENGLISH) == (
        "approved by the file's own limits; speed and strength not evaluated"
    )


def test_profile_keeps_its_own_bound_of_what_every_profile_limits():
    own = "{profile: protractor, overrides: [{quantity: critical_speed_ratio, maximum: 2, "
    own += "source: ours}]}"
    found = approve_driveline(reader.loads(LONG.replace("protractor", own)))
    bounds = {c.limit.maximum for c in found.checks if c.quantity == SPEED}
    assert bounds == {2.0}


def test_starter_with_a_long_shaft_and_much_torque_fails(tmp_path):
    """It passed in a document to sign: `protractor` evaluated neither speed nor strength."""
    text = templates.template_text("small")
    assert "limits: body-builder" in text
    assert approve_driveline(reader.loads(text)).verdict in ("pass", "warn")
    bad = text.replace("length_mm: 1500", "length_mm: 3000")
    bad = bad.replace("torque_Nm: 8000", "torque_Nm: 30000")
    for limits in ("body-builder", "protractor"):
        result = check(tmp_path, bad.replace("limits: body-builder", f"limits: {limits}"), "--json")
        document = json.loads(result.stdout)
        assert (document["verdict"], result.exit_code) == ("fail", 1)
        worst = {
            q: max(c["value"] for c in document["checks"] if c["quantity"] == q)
            for q in (SPEED, STRENGTH)
        }
        assert worst[SPEED] == pytest.approx(1.346, abs=5e-4)
        # τ = 16 T D / (π (D⁴ − d⁴)) of 101.6 x 3.2 mm over 355 MPa / √3, METHOD 9.
        assert worst[STRENGTH] == pytest.approx(635.7 / (355 / 3**0.5), rel=1e-3)


def test_what_a_body_builder_has_gives_a_verdict():
    text = """\
title: From the chassis sheet
engine: {speed_rpm: [1000, 1400, 2300], torque_Nm: [1100, 1100, 850]}
gearbox: {ratios: [6.35, 3.27, 1.77, 1.0]}
driveline:
  joints: 1710
  slopes: {side_deg: [3.0, 1.0, 4.5, 2.0]}
  shafts:
    - {length_mm: 1200, tube: 110x4, centre_bearing: {from_rear_joint_mm: 140}}
    - {length_mm: 1500, tube: 110 x 4}
limits: body-builder
"""
    found = approve_driveline(reader.loads(text))
    assert found.not_evaluated == ("rubber of the centre bearings",)
    assert (found.verdict, found.coverage.unevaluated) == ("pass", ())
    joints = [c.value for c in found.checks if c.quantity == "joint_torque_utilisation"]
    # 1100 N m x 6.35 over the 10847 N m of a 1710, swung by the angles ahead: cos 2 to 1/cos 2.
    assert max(joints) == pytest.approx(1100 * 6.35 / 10847, rel=2e-3)
    bare = approve_driveline(reader.loads(text.replace("  joints: 1710\n", "")))
    assert bare.verdict == "incomplete"


def test_body_builder_leaves_out_what_is_not_given():
    held = load_profile("body-builder")[1]
    required = {m.quantity for m in held if m.required}
    assert required >= {SPEED, STRENGTH, "joint_torque_utilisation", "tube_buckling_utilisation"}
    optional = {"spline_travel_margin", "joint_life", "centre_bearing_dynamic", "swing_growth"}
    assert all(m.if_given for m in held if m.quantity in optional)
    assert not required & optional


def test_missing_kinds_of_state_are_listed(tmp_path):
    """Of seven states of a van one was left: PASS, and no word."""
    van = reader.read(EXAMPLES / "van.yaml")
    alone = tuple(s for s in van.states if s.name == "gvw")
    from dataclasses import replace

    found = approve_application(replace(van, states=alone))
    missing = ("full rebound", "empty", "overload", "jounce", "windup", "windup brake")
    assert found.state_kinds_not_given == missing
    assert approve_application(van).state_kinds_not_given == ()
    assert approve_driveline(reader.loads(SHAFT)).state_kinds_not_given == ()  # no vehicle
    del tmp_path
