"""First screen of `cardan check`: names, numbers and budget of lines; `--why` with its numbers."""

import re
from dataclasses import replace

import jsonschema
import pytest
from brackets import BRACKET, LINE
from click.testing import CliRunner
from repository import ROOT

from cardan.application import reader
from cardan.approval.approval import Approval, approve_application, approve_driveline
from cardan.approval.data_provenance import catalogue_data_of
from cardan.approval.study import BRACKET_STUDY_NAME, DRIVELINE_STUDY_NAME
from cardan.cli import cli
from cardan.core.labels import EvaluationCondition, OperatingPoint, OrderCrossing, Part
from cardan.core.provenance import Source
from cardan.core.units import rpm
from cardan.core.verdict import AssumedRange, Check, Limit
from cardan.documents import first_screen
from cardan.documents.approval_report import verdict_report_blocks
from cardan.documents.approval_schema import schema
from cardan.documents.criteria import (
    NAMES_BY_PART,
    condition_texts,
    criteria_of,
    limit_qualifiers,
    short_name,
)
from cardan.documents.criterion_explanation import criteria_named, explanation_lines
from cardan.documents.first_screen import MAX_LINES, points_before_signing, screen_lines
from cardan.render.check_texts import limit_text, value_text
from cardan.render.i18n import ENGLISH, LANGUAGE_CODES, Translator, message_catalogue
from cardan.render.json_contract import catalogue_datum_json
from cardan.render.phrases import doubtful_value_count_text
from cardan.render.text_layout import without_colours

SHAFT = """\
title: Under the truck
speed_rpm: 2500
torque_Nm: 3000
driveline:
  slopes: {side_deg: [4.0, 2.0, 4.5]}
  joints: "2040"
  shafts: [{length_mm: 1200, tube: 100x3}]
limits: LIMITS
"""


def approved(limits: str) -> Approval:
    return approve_driveline(reader.loads(SHAFT.replace("LIMITS", limits)))


def screen(of: Approval, code: str = "en") -> list[str]:
    return without_colours(screen_lines(of, say=Translator(code))).splitlines()


def check(value: float, limit: Limit, **more: object) -> Check:
    return Check(
        quantity=limit.quantity,
        line="main",
        when=EvaluationCondition("state", "jounce"),
        part=Part("centre bearing", 2),
        value=value,
        limit=limit,
        **more,
    )


FORCE = Limit(quantity="centre_bearing_dynamic", normal=1500.0, maximum=2500.0, source=Source("us"))


# --------------------------------------------------------------------------- numbers


@pytest.mark.parametrize(
    ("value", "shown", "bound"),
    [
        (4001.0, "4.00", "max 2.5 kN"),
        (2500.001, "2.500001", "max 2.5 kN"),  # beyond, and never shown as equal
        (2499.6, "2.50", "max 1.5 kN"),
        (1500.0, "1.50", "max 1.5 kN"),
        (12.34, "0.0123", "max 1.5 kN"),
    ],
)
def test_value_has_three_figures_unless_equal_to_its_bound(value, shown, bound):
    one = check(value, FORCE)
    assert value_text(one, ENGLISH) == shown
    assert limit_text(one, ENGLISH) == bound


@pytest.mark.parametrize(
    ("margin", "shown"),
    [(-3.54, "far beyond"), (-1.0, "-100 %"), (-0.24, "-24 %"), (1.0, "+100 %"), (1.58, "ample")],
)
def test_margin_beyond_its_limit_by_all_of_it_is_words(margin, shown):
    assert ENGLISH.margin_text(margin) == shown
    assert Translator("it").margin_text(-3.54) == "molto oltre"


def test_limit_of_engineering_judgement_has_a_star():
    ours = replace(FORCE, source=Source("Engineering judgement", how_read="assumed"))
    assert limit_text(check(4001.0, ours), ENGLISH) == "max 2.5 kN*"
    assert limit_text(check(4001.0, ours), Translator("pt")) == "máx. 2,5 kN*"


def test_worst_case_uses_the_terms_of_the_field():
    reverse = OperatingPoint("R", "reverse", 312 * rpm, -7866.0)
    overrun = OperatingPoint("5", "coast", 2400 * rpm, -316.0)
    one = check(4001.0, FORCE, point=reverse, mode=OrderCrossing("pitch", 65.0, 2))
    assert condition_texts(one, ENGLISH) == (
        "bump, reverse, 312 rpm (pitch mode)", "bump, reverse, 312 rpm", "bump, reverse", "bump",
    )  # fmt: skip
    coasting = replace(one, point=overrun, mode=None)
    assert condition_texts(coasting, Translator("pt"))[0] == (
        "metal/metal, freio-motor, marcha 5, 2400 rpm"
    )
    assert condition_texts(coasting, Translator("it"))[0] == (
        "tampone, rilascio, marcia 5, 2400 rpm"
    )


# --------------------------------------------------------------------------- criteria


def test_criterion_is_one_limit_of_all_states_and_parts():
    low, high = check(1000.0, FORCE), check(3000.0, FORCE, point=None)
    other = replace(low, line="front")
    first, second = criteria_of([low, high, other])
    assert (first.worst, first.grade, first.checks) == (high, "fail", (high, low))
    assert second.checks == (other,)


def test_assumed_input_that_turns_a_verdict_is_named_worse_first():
    loss = (AssumedRange("centre_bearing.loss_factor", 0.05, 0.2),)
    passed = replace(check(1400.0, FORCE), within=(900.0, 2600.0), assumed=loss)
    failed = replace(
        check(4001.0, replace(FORCE, quantity="centre_bearing_peak")),
        within=(2134.0, 7669.0), assumed=loss,
    )  # fmt: skip
    # One state may fail: the criterion passes as it stands, and that is no sure thing.
    (criterion,) = criteria_of([passed, check(1450.0, FORCE)])
    assert criterion.grade == "pass"
    assert criterion.deciding_check == passed
    # One check may pass where another fails for sure: nothing is open.
    (sure,) = criteria_of([failed, replace(failed, value=9000.0, within=None)])
    assert sure.deciding_check is None
    found = approved("protractor")
    (result, *others) = found.study_results
    made = replace(result, checks=(failed, passed))
    lines = " ".join(screen(replace(found, study_results=(made, *others))))
    said = re.sub(" +", " ", lines)
    worse = said.index("dynamic force 0.900 to 2.60 kN: a worse verdict is possible")
    assert worse < said.index("peak force 2.13 to 7.67 kN: a better verdict is possible")


def test_limits_of_one_quantity_have_different_names():
    found = approved("heavy-truck")
    qualifiers = limit_qualifiers(found.checks, found.application)
    by_quantity: dict[str, list[str]] = {}
    for (quantity, _, _), qualifier in qualifiers.items():
        by_quantity.setdefault(quantity, []).append(qualifier)
    assert sorted(by_quantity["joint_angle"]) == ["maximum", "recommended", "size rating"]
    assert "torsional_acceleration" not in by_quantity


@pytest.mark.parametrize("code", LANGUAGE_CODES[1:])
def test_short_names_are_translated(code):
    assert [t for t in NAMES_BY_PART.values() if ("", t) not in message_catalogue(code)] == [
        "{part}"  # a part by itself
    ]


@pytest.mark.parametrize("code", LANGUAGE_CODES)
def test_screen_and_reports_name_a_criterion_alike(code):
    """A part takes the place of its kind in a name; every other name is that of reports."""
    say = Translator(code)
    bearing = say.name("centre_bearing_peak").partition(",")[0]
    for quantity, text in NAMES_BY_PART.items():
        if quantity.startswith("centre_bearing"):
            assert say(text, part=bearing) == say.name(quantity)
    found = approved("heavy-truck")
    table = next(iter(verdict_report_blocks(found, say)))
    in_report = {row[1].casefold() for row in table.rows}
    qualifiers = limit_qualifiers([*found.checks, *found.coverage.unevaluated], found.application)
    on_screen = {short_name(c, say, qualifiers).casefold() for c in found.checks}
    assert on_screen == in_report


# --------------------------------------------------------------------------- budget


MANY = (
    "joint_angle", "side_angle", "compound_angle", "end_angle_difference", "equivalent_angle",
    "torsional_acceleration", "inertia_drive_acceleration", "inertia_coast_acceleration",
    "irregularity", "angle_for_speed", "n_beta", "joint_speed", "joint_force",
    "critical_speed_ratio", "tube_shear_utilisation", "joint_torque_utilisation", "torque",
    "speed", "shaft_length", "bending_moment", "couple_ahead", "couple_behind", "journal_force",
)  # fmt: skip


@pytest.mark.parametrize("code", LANGUAGE_CODES)
def test_screen_of_many_exceeded_criteria_stays_one_screen(code):
    rows = ", ".join(f"{{quantity: {q}, maximum: 0.00001, source: us}}" for q in MANY)
    missing = ", ".join(
        f"{{quantity: {q}, maximum: 1, source: us}}"
        for q in ("joint_life", "spline_travel_margin", "suspension_frequency", "spline_force")
    )
    found = approved(f"[{rows}, {missing}]")
    assert len([c for c in criteria_of(found.checks) if c.grade == "fail"]) >= 20
    lines = screen(found, code)
    assert len(lines) <= MAX_LINES
    assert max(map(len, lines)) <= 80
    counted = re.search(r"\+(\d+)[^+]*\(--all\)", " ".join(lines))
    assert counted
    assert int(counted[1]) > 5


def test_worst_case_keeps_speed_and_stuck_spline_in_every_language():
    """Portuguese and Italian names are longer: gear and speed were dropped there."""
    found = approve_driveline(reader.read(ROOT / "examples/mtv-6x6.yaml"))
    points = [c.worst.point for c in criteria_of(found.checks) if c.grade == "fail"]
    speeds = [round(at.speed / rpm) for at in points if at and at.speed]
    assert len(speeds) >= 3
    for code in LANGUAGE_CODES:
        say, shown = Translator(code), " ".join(" ".join(screen(found, code)).split())
        for speed in speeds:
            assert shown.count(f"{speed} rpm") >= speeds.count(speed)
        if any(at.is_spline_stuck for at in points if at):
            assert say("spline stuck") in shown


# --------------------------------------------------------------------------- data


@pytest.mark.parametrize("most", [9, 2, 1])
@pytest.mark.parametrize("lines", [MAX_LINES, 12])
def test_unverified_data_is_shown_however_many_points_come_before(most, lines, monkeypatch):
    monkeypatch.setattr(first_screen, "MAX_SIGNATURE_LINES", most)
    monkeypatch.setattr(first_screen, "MAX_LINES", lines)
    odd = SHAFT.replace("tube: 100x3", "tube: 100x3, phase_deg: 1.5708")
    found = approve_driveline(reader.loads(odd.replace("LIMITS", "heavy-truck")))
    shown = screen(found)
    points = points_before_signing(found, ENGLISH)
    assert next(k for k, p in enumerate(points) if p.startswith("data ")) > 0
    assert "data unverified: joint 2040" in " ".join(" ".join(shown).split())
    at = shown.index("Before you sign")
    assert len(shown[at + 1 :]) <= max(lines - at - 1, 20)


def test_values_read_worse_than_their_row_are_named():
    text = SHAFT.replace('"2040"', '"1810"').replace("LIMITS", "heavy-truck")
    shown = " ".join(" ".join(screen(approve_driveline(reader.loads(text)))).split())
    assert "data unverified: joint 1810 (cross_width, cup_diameter); quoted: joint 1810;" in shown


FATIGUE = "  fatigue: {amplitude_MPa: 150, cycles: 1.0e+6, slope: 5, cut_edge: iiw-edge-125}\n"


def test_rows_of_a_bracket_are_data_of_a_verdict_that_includes_it():
    application = reader.loads(LINE + BRACKET + "  material: LNE380\n" + FATIGUE)
    of_lines = list(catalogue_data_of(application, (DRIVELINE_STUDY_NAME,)))
    every = list(catalogue_data_of(application, (DRIVELINE_STUDY_NAME, BRACKET_STUDY_NAME)))
    assert every[: len(of_lines)] == of_lines
    assert [
        (d.kind, d.name, d.part_numbers, d.source.how_read) for d in every[len(of_lines) :]
    ] == [
        ("bracket material", "LNE380", (1,), "from memory"),
        ("fatigue detail", "iiw-edge-125", (1,), "from memory"),
    ]
    jsonschema.validate(
        [catalogue_datum_json(d) for d in every], schema()["properties"]["data"] | {"$defs": {}}
    )


# --------------------------------------------------------------------------- why


@pytest.fixture(scope="module")
def truck() -> Approval:
    return approve_application(reader.read(ROOT / "examples" / "medium-truck-4x2.yaml"))


def numbers(of: Approval, name: str) -> tuple[float, dict[str, float]]:
    """The value of a criterion, and the numbers that `--why` prints by their symbol or name."""
    (one,) = criteria_named(of, name)
    lines = without_colours(explanation_lines([one], of, helps=(), say=ENGLISH)).splitlines()
    block = lines[lines.index("  Numbers put in") + 1 :]
    found: dict[str, float] = {}
    for line in block:
        if not line.startswith("    "):
            break
        label, number = re.fullmatch(r" {4}(\S.*?) {2,}(-?[\d.]+).*", line).groups()
        symbol = re.search(r"\(([^()]+)\)$", label)
        found[symbol[1] if symbol else label] = float(number)
    return one.criterion.worst.value, found


PI_30 = 3.141592653589793 / 30


@pytest.mark.parametrize(
    ("name", "equation"),
    [
        ("joint angle x speed", lambda n: n["n"] * PI_30 * n["β"] * PI_30 / 6),
        ("single-joint acceleration", lambda n: (n["n"] * PI_30 * n["β"] * PI_30 / 6) ** 2),
        ("tube_shear_utilisation",
         lambda n: 16 * abs(n["T"]) * n["K"] * n["D"] * 3**0.5
         / (30 * PI_30 * (n["D"] ** 4 - n["d"] ** 4) * 1e-9 * n["Re"] * 1e6)),
        ("joint_torque_utilisation", lambda n: n["T"] / n["Tcs"]),
        ("centre_bearing_peak", lambda n: n["Fs"] + n["Fd"]),
        ("critical_speed_ratio", lambda n: n["n"] / n["nl"]),
    ],
)  # fmt: skip
def test_numbers_put_in_give_the_value(truck, name, equation):
    """They are those of the worst operating point, in the units shown."""
    value, put_in = numbers(truck, name)
    assert abs(equation(put_in)) == pytest.approx(value, rel=2e-3)


def test_why_rejects_unknown_criterion_with_nearest_name(tmp_path):
    file = tmp_path / "line.yaml"
    file.write_text(SHAFT.replace("LIMITS", "protractor"), encoding="utf-8")
    done = CliRunner().invoke(cli, ["check", str(file), "--why", "torsional aceleration"])
    assert done.exit_code == 2
    assert "did you mean torsional acceleration?" in done.output
    two = CliRunner().invoke(cli, ["check", str(file), str(file), "--why", "joint angle"])
    assert two.exit_code == 2
    assert "give one file with --why" in two.output


def test_why_names_missing_input_of_criterion_not_evaluated():
    found = approved("[{quantity: spline_force, maximum: 5000, source: us}]")
    named = criteria_named(found, "slip force of the spline")
    said = without_colours(explanation_lines(named, found, helps=(), say=ENGLISH))
    assert "not evaluated (input missing: spline mean_radius_mm)" in said
    assert "Fa = T μ / rm" in said


def test_missing_torque_is_said_by_its_sentence_and_is_no_value_that_looks_wrong():
    """The line ended in a colon with nothing behind it: such a warning is about no key."""
    text = SHAFT.replace("torque_Nm: 3000\n", "").replace('joints: "2040"', "joints: 1710")
    found = approve_driveline(reader.loads(text.replace("LIMITS", "body-builder")))
    shown = screen(found)
    assert "  no torque is given: loads, strength and life cannot be checked" in shown
    assert not any("look wrong" in line for line in shown)
    assert doubtful_value_count_text(found, ENGLISH) == ""
