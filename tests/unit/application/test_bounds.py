"""The boundary: what is physical, how many, which files, which names; and zero, and cycles."""

import json
from dataclasses import replace
from pathlib import Path

import jsonschema
import pytest
from repository import ROOT

from cardan.application.duty_cycles import duty_cycle_names, load_duty_cycle
from cardan.application.json_schema import application_schema
from cardan.application.reader import loads, read
from cardan.application.templates import template_text
from cardan.core.errors import InvalidFileError
from cardan.core.units import kNm, rpm
from cardan.model.application import DutyCycle, DutyPointInSharesOfMaximum, duty_cycle_points
from cardan.model.vehicle import Engine
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references
from cardan.physics.vehicle.torque import max_retarding_torque

SMALL, TRUCK = template_text("small"), template_text("truck")
SHAFT = "    - {length_mm: 1000, centre_bearing: {from_rear_joint_mm: 100}}\n"


def refused(text: str, **given: object) -> list[str]:
    with pytest.raises(InvalidFileError) as error:
        loads(text, name="f", **given)
    return str(error.value).splitlines()


# --- what is physical ---------------------------------------------------------------------

MODEL_CAR = """\
title: A model car, 1 to 10
torque_Nm: 0.4
speed_rpm: 60000
tyre: {static_radius_mm: 33, friction: 0.9}
axle: {ratio: 2.6, pinion: {ahead_mm: 14}}
vehicle:
  drive: 4x2
  wheelbase_mm: 257
  loads: {gvw: {mass_kg: 1.6, cg_behind_front_mm: 140, cg_height_mm: 30}}
driveline:
  slopes: {side_deg: [0, 3, 0]}
  shafts:
    - length_mm: 90
      tube: {outer_mm: 3, wall_mm: 0.25}
      spline: {plunge_mm: 2, mean_radius_mm: 1.2}
      yoke_mass_kg: 0.002
"""
SHIP = """\
title: A container ship's shaft line
torque_kNm: 7000
speed_rpm: 100
engine: {speed_rpm: [40, 100], torque_kNm: [3000, 7000]}
driveline:
  slopes: {side_deg: [0, 0.3, 0]}
  shafts:
    - {length_m: 14, tube: {outer_mm: 900, wall_mm: 450}, yoke_mass_t: 8}
"""


@pytest.mark.parametrize("text", [MODEL_CAR, SHIP])
def test_model_car_and_ship_files_load_with_warnings(text):
    assert loads(text).warnings


@pytest.mark.parametrize(
    ("base", "old", "new", "message"),
    [
        (SMALL, "length_mm: 1500", "length_mm: 0.001", "must be a number of at least 5 and at most "
         "50000 mm (got 0.001)"),
        (SMALL, "length_mm: 1500", "length_m: 60", "must be a number of at least 0.005 and at most "
         "50 m (got 60)"),
        (SMALL, "length_mm: 1500", "length_in: 0.1", "must be a number of at least 0.19685 and at "
         "most 1968.5 in (got 0.1)"),
        (SMALL, "length_mm: 1500", "length_mm: 1.5", "(got 1.5); did you mean length_m?"),
        (TRUCK, "efficiency: 0.95", "efficiency: 1e-300", "must be a number of at least 0.1 and at "
         "most 1 (got 1e-300)"),
        (TRUCK, "ratio: 4.88", "ratio: 1e-9", "must be a number of at least 0.02 and below 100"),
        (TRUCK, "friction: 0.8 ", "friction: 1e-30 ", "must be a number of at least 0.001 and"),
        (TRUCK, "wheelbase_mm: 4800", "wheelbase_mm: 1e9", "at most 100000 mm (got 1e9)"),
        (TRUCK, "unsprung_mass_kg: 900", "unsprung_mass_kg: 9e9", "at most 1e+06 kg (got 9e9)"),
        (TRUCK, "windup_stiffness_kNm_deg: 16", "windup_stiffness_kNm_deg: 1e-300", "of at least "),
        (TRUCK, "travel_mm: -30", "travel_mm: -30000", "of at least -5000 and at most 5000 mm"),
        (TRUCK, "share_percent: 30", "share_percent: 1e-20", "of at least 1e-06 and at most 100"),
        (TRUCK, "[1240, 0, -60]", "[1240, 0, -1e11]", "of at least -200000 and at most 200000 mm"),
    ],
)  # fmt: skip
def test_value_outside_physical_bounds_is_rejected_in_unit_of_key(base, old, new, message):
    """An efficiency of 1e-300 was taken, and a shaft of 0.001 mm became a LinAlgError later."""
    assert base.count(old)
    assert any(message in m for m in refused(base.replace(old, new, 1)))


def test_schema_contains_bounds():
    shaft = application_schema()["$defs"]["Shaft"]["properties"]
    assert (shaft["length_mm"]["minimum"], shaft["length_mm"]["maximum"]) == (5, 50000)
    line = application_schema()["$defs"]["Line"]["properties"]["shafts"]
    assert (line["minItems"], line["maxItems"]) == (1, 12)


# --- how many -----------------------------------------------------------------------------


def many(item: str, count: int) -> str:
    return "[" + ", ".join([item] * count) + "]"


ENDLESS = {
    "driveline.shafts": ("driveline:\n  slopes: {side_deg: [1, 2]}\n  shafts:\n" + SHAFT * 2000,
                         "12 items", "2000 items"),
    "states": ("states: " + many("gvw", 201), "200 items", "201 items"),
    "obstacles": ("obstacles: " + many("{name: a, start_mm: [0, 0, 0]}", 201),
                  "200 items", "201 items"),
    "duty": ("duty: " + many("{share_percent: 1, torque_Nm: 1, speed_rpm: 1}", 1001),
             "1000 items", "1001 items"),
    "engine.speed_rpm": (f"engine: {{speed_rpm: {many('900', 1001)}, torque_Nm: 900}}",
                         "1000 items", "1001 items"),
    "engine.torque_Nm": (f"engine: {{speed_rpm: 900, torque_Nm: {many('900', 1001)}}}",
                         "1000 items", "1001 items"),
    "gearbox.ratios": (f"gearbox: {{ratios: {many('2', 65)}}}", "64 items", "65 items"),
    "suspension.spring.load_N": (f"suspension: {{spring: {{load_N: {many('2000', 2001)}}}}}",
                                 "2000 items", "2001 items"),
    "suspension.linkage.travel_mm": (
        f"suspension: {{spring: {{rates_N_mm: [90]}}, linkage: {{travel_mm: {many('20', 2001)}}}}}",
        "2000 items", "2001 items"),
    "vehicle.loads": ("vehicle: {drive: 4x2, wheelbase_m: 4, loads: {"
                      + ", ".join(f"a{k}: {{}}" for k in range(51)) + "}}",
                      "50 entries", "51 entries"),
    "bracket.gauges": (f"bracket: {{gauges: {many('{name: a}', 101)}}}", "100 items", "101 items"),
    "limits": (f"limits: {many('{quantity: clearance, source: a}', 501)}", "500 items",
               "501 items"),
}  # fmt: skip


@pytest.mark.parametrize("key", ENDLESS)
def test_oversized_list_is_rejected_once_at_its_key(key):
    """2000 shafts were 2000 messages, and took a second for each key of theirs."""
    text, most, got = ENDLESS[key]
    answers = [a for a in refused(f"title: a\n{text}\n") if f": {key}: " in a]
    assert len(answers) == 1
    assert answers[0].endswith(f": {key}: may hold up to {most} (got {got})")


def test_catalogue_count_and_row_count_are_limited(tmp_path):
    answers = refused(f"{SMALL}catalogues: {many('a', 21)}\n")
    assert any("catalogues: may hold up to 20 items (got 21 items)" in a for a in answers)
    rows = "".join(f"t{k},90,3\n" for k in range(5001))
    (tmp_path / "a.csv").write_text(f"name,outer_mm,wall_mm\n{rows}")
    (message,) = refused(f"{SMALL}catalogues: a.csv\n", folder=tmp_path)
    assert message.endswith("a.csv:5002:1: a catalogue may have up to 5000 rows")


def test_driveline_count_is_limited():
    lines = "".join(f"  a{k}: {{}}\n" for k in range(9))
    (message,) = refused(f"title: a\ndrivelines:\n{lines}")
    assert message == "f:3:3: drivelines: may hold up to 8 entries (got 9 entries)"


def test_name_length_is_limited():
    (message,) = refused(SMALL.replace("Two-piece driveline", "a" * 301))
    assert message.endswith("title: may have up to 300 characters (got 301 characters); shorten it")
    assert loads(SMALL.replace("Two-piece driveline", "a" * 300)).title == "a" * 300
    (message,) = refused(f"{SMALL}obstacles: [{{name: {'a' * 201}, start_mm: [900, 0, 0]}}]\n")
    assert "obstacles[1].name: may have up to 200 characters" in message


@pytest.mark.parametrize(
    "title",
    [
        "|\n  Two\n  lines\n",
        ">\n  Two\n  lines\n",
        "Two\n  lines\n",
        '"Two\\nlines" ',
        '"Two\\tlines" ',
    ],
)
def test_multiline_title_is_folded_to_one_line(title):
    """YAML folds a long title by itself; one that keeps its lines is folded like it."""
    file = loads(SMALL.replace("title: Two-piece driveline ", f"title: {title}#"))
    assert file.title == "Two lines"


def test_excessive_number_of_checks_is_rejected():
    obstacles = ", ".join(f"{{name: o{k}, start_mm: [900, 0, 90]}}" for k in range(190))
    states = ", ".join(f"{{name: s{k}, travel_mm: {k / 10}}}" for k in range(190))
    answers = refused(f"{SMALL}obstacles: [{obstacles}]\nstates: [{states}]\n")
    said = "states: 190 states of 2 shafts and 190 obstacles are some 72200 checks"
    assert any(said in a for a in answers)


# --- which files --------------------------------------------------------------------------

TUBES = "name,outer_mm,wall_mm,source\nours,90,3,drawing\n"
PROFILE = (
    "profile: ours\nlimits: [{quantity: clearance, unit: mm, maximum: 20, source: ours}]\n"
)  # fmt: skip


@pytest.fixture
def folders(tmp_path):
    (tmp_path / "inside" / "deeper").mkdir(parents=True)
    for folder in (tmp_path, tmp_path / "inside", tmp_path / "inside" / "deeper"):
        (folder / "ours.csv").write_text(TUBES)
        (folder / "ours.yaml").write_text(PROFILE)
        (folder / "ours.step").write_text("ISO-10303-21;")
    return tmp_path


def named(folders, what: str, name: str, **given: object):
    text = SMALL.replace("limits: body-builder ", "# ")
    step = (
        "bracket:\n  step: {{file: {}, centre_mm: [0, 0, 0], seat: [{{name: a}}], "
        "bolts: [{{name: b}}], thickness_mm: 6}}\n"
    )
    text += {"csv": f"catalogues: {name}\n", "yaml": f"limits: {name}\n"}.get(
        what, step.format(name)
    )
    file = folders / "inside" / "truck.yaml"
    file.write_text(text)
    return read(file, **given)


@pytest.mark.parametrize("what", ["csv", "yaml", "step"])
@pytest.mark.parametrize("name", ["ours", "deeper/ours", "deeper/../ours", "./ours"])
def test_referenced_file_in_application_folder_is_read(folders, what, name):
    assert named(folders, what, f"{name}.{what}")


@pytest.mark.parametrize("what", ["csv", "yaml", "step"])
@pytest.mark.parametrize("name", ["../ours", "deeper/../../ours", "{absolute}", "link", "ring"])
def test_referenced_file_outside_folder_is_rejected_unless_allowed(folders, what, name):
    """A file from somebody else read whatever this machine has, and printed it in errors."""
    inside = folders / "inside"
    (inside / f"link.{what}").symlink_to(folders / f"ours.{what}")
    (inside / f"ring.{what}").symlink_to(inside / f"ring.{what}")
    name = name.format(absolute=folders / "ours")
    with pytest.raises(InvalidFileError) as error:
        named(folders, what, f"{name}.{what}")
    if name == "ring":
        return
    assert f"lies outside the folder of this file, {inside} " in str(error.value)
    assert "put it next to this file, or use --allow-outside" in str(error.value)
    assert named(folders, what, f"{name}.{what}", allow_outside=True)


def test_application_file_is_read_from_any_folder(folders, monkeypatch):
    named(folders, "csv", "ours.csv")
    monkeypatch.chdir(folders / "inside" / "deeper")
    assert read(Path("../truck.yaml"))
    (folders / "link.yaml").symlink_to(folders / "inside" / "truck.yaml")
    assert read(folders / "link.yaml")


# --- which names --------------------------------------------------------------------------

CASE = "{name: a, force_N: [1, 0, 0]}"
GAUGE = "{name: a, point_mm: [1, 0, 0], direction: [1, 0, 0], length_mm: 3}"
BRACKET = (
    "bracket: {{u_shape: {{seat_diameter_mm: 80, width_mm: 60, thickness_mm: 6, height_mm: 110, "
    "flange_mm: 50, bend_radius_mm: 8, bolt_diameter_mm: 11, bolt_pitch_mm: 30}}, {}}}\n"
)


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("obstacles: [{name: beam, start_mm: [900, 0, 90]}, {name: beam, start_mm: [700, 0, 90]}]",
         "obstacles[2]: this name is above already (got beam); give it another"),
        ("obstacles: [{name: beam, start_mm: [900, 0, 90]}, {name: ' beam', start_mm: [9, 0, 90]}]",
         "obstacles[2]: this name is above already (got beam); give it another"),
        ("states: [gvw, {name: 'gvw ', travel_mm: 9}]",
         "states[2]: this name is above already (got gvw); give it another"),
        (BRACKET.format(f"cases: [{CASE}, {CASE}]"),
         "bracket.cases[2]: this name is above already (got a); give it another"),
        (BRACKET.format(f"gauges: [{GAUGE}, {GAUGE}]"),
         "bracket.gauges[2]: this name is above already (got a); give it another"),
        ("vehicle: {drive: 4x2, wheelbase_m: 4, loads: {gvw: {mass_t: 9, cg_behind_front_m: 2}, "
         "' gvw': {mass_t: 9, cg_behind_front_m: 2}}}",
         "vehicle.loads. gvw: this name is given twice: names differ by more than spaces"),
        ("obstacles: [{name: '  ', start_mm: [900, 0, 90]}]", "obstacles[1].name: must be a text"),
        ("obstacles: [{name: \"\\u2003\", start_mm: [900, 0, 90]}]", "obstacles[1].name: must"),
        ("vehicle: {drive: 4x2, wheelbase_m: 4, loads: {' ': {mass_t: 9, cg_behind_front_m: 2}}}",
         "vehicle.loads. : must be a text"),
    ],
)  # fmt: skip
def test_duplicate_name_is_rejected(text, key):
    """Two obstacles called beam were one in the JSON: the second wrote over the first."""
    assert any(key in answer for answer in refused(f"{SMALL}{text}\n"))


def test_duplicate_driveline_name_is_rejected():
    line = "{slopes: {side_deg: [1, 2, 3]}, shafts: [{length_mm: 900}]}"
    answers = refused(f"title: a\ndrivelines:\n  main: {line}\n  ' main': {line}\n")
    assert any(a.startswith("f:4:3: drivelines. main: this name is given twice") for a in answers)


def test_part_name_in_two_catalogues_is_rejected(tmp_path):
    (tmp_path / "a.csv").write_text(TUBES)
    (tmp_path / "b.csv").write_text(TUBES)
    (message,) = refused(f"{SMALL}catalogues: [a.csv, b.csv]\n", folder=tmp_path)
    assert "b.csv:2:1: ours: this name is in a.csv too" in message


# --- zero, and what nobody says -----------------------------------------------------------


@pytest.mark.parametrize(
    ("old", "new", "warning"),
    [
        ("speed_rpm: 2500", "speed_rpm: 0", "f:6:12: speed_rpm: nothing turns: accelerations and "
         "critical speeds cannot be checked"),
        ("torque_Nm: 8000", "torque_Nm: 0", "f:7:12: torque_Nm: nothing pulls: loads, strength and "
         "life cannot be checked"),
    ],
)  # fmt: skip
def test_zero_value_is_accepted_with_warning(old, new, warning):
    application = loads(SMALL.replace(old, new), name="f")
    assert [w.format_with_location("f") for w in application.warnings] == [warning]


def test_missing_engine_brake_torque_is_unknown_not_zero():
    """It was zero: an engine that does not hold back at all, in every check of coasting."""
    truck = loads(TRUCK.replace("  brake_torque_Nm: 350", "  # "))
    assert truck.engine.brake_torque is None
    assert max_retarding_torque(truck.engine) != max_retarding_torque(truck.engine)
    assert all(line_state_demand(resolve_line_references(truck, truck.lines[0])).coast_torque != 0)
    assert max_retarding_torque(Engine(speed=(1.0,), torque=(1.0,), brake_torque=0.0)) == 0


# --- duty cycles by name ------------------------------------------------------------------


@pytest.mark.parametrize("name", duty_cycle_names())
def test_duty_cycle_shares_sum_to_one_and_have_source(name):
    found = load_duty_cycle(name)
    assert found.name == name
    assert found.description.endswith(".")
    assert "assumed" in str(found.source)
    assert sum(p.share for p in found.points) == pytest.approx(1, abs=1e-12)


def test_duty_cycle_torque_and_speed_shares_are_not_swapped():
    """The first two points of its file, as they stand there."""
    first, second, *_ = load_duty_cycle("construction").points
    assert (first.share, first.torque_share, first.speed_share) == pytest.approx((0.05, 1.0, 0.04))
    assert (second.share, second.torque_share, second.speed_share) == pytest.approx(
        (0.10, 0.60, 0.08)
    )


@pytest.mark.parametrize("name", duty_cycle_names())
@pytest.mark.parametrize("truck", ["medium-truck-4x2", "refuse-collector-6x2", "tandem-6x4"])
def test_duty_cycle_point_does_not_exceed_full_engine_power(name, truck):
    """Torque and speed of a point are shares of what never meets; their product must."""
    application = read(ROOT / "examples" / f"{truck}.yaml")
    engine = application.engine
    power = max(w * m for w, m in zip(engine.speed, engine.torque, strict=True))
    power *= application.gearbox.efficiency
    shown = replace(application, states=application.states[:3])
    asked = line_state_demand(resolve_line_references(shown, application.lines[0]))
    line = application.lines[0]
    torque = max(asked.torque) / (line.torque_ratio * line.torque_share)
    for p in duty_cycle_points(load_duty_cycle(name), torque=torque, speed=application.speed):
        assert p.torque * p.speed <= power


def test_duty_cycle_shares_are_scaled_to_vehicle_torque_and_speed():
    both = DutyPointInSharesOfMaximum(share=0.5, torque_share=0.25, speed_share=0.5)
    found = duty_cycle_points(
        DutyCycle(
            name="a", description="b.", source=load_duty_cycle("refuse").source, points=(both, both)
        ),
        torque=8 * kNm,
        speed=2400 * rpm,
    )
    assert [(p.share, p.torque, p.speed, p.angle) for p in found] == [
        (0.5, 2 * kNm, pytest.approx(1200 * rpm), None)
    ] * 2


def test_application_file_selects_duty_cycle_by_name():
    application = loads(f"{SMALL}duty: long-haul\n")
    assert application.duty == ()
    assert application.duty_cycle == load_duty_cycle("long-haul")
    (message,) = refused(f"{SMALL}duty: longhaul\n")
    assert message.endswith("did you mean long-haul?")
    assert loads(TRUCK).duty_cycle is None


def test_schema_lists_duty_cycle_names():
    validator = jsonschema.Draft202012Validator(application_schema())
    line = {"slopes": {"side_deg": [1, 2, 3]}, "shafts": [{"length_mm": 900}]}
    document = {"title": "a", "driveline": line, "duty": "long-haul"}
    validator.validate(document)
    assert not validator.is_valid({**document, "duty": "longhaul"})
    assert all(name in json.dumps(application_schema()) for name in duty_cycle_names())
