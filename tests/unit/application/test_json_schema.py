"""The JSON Schema says what `read` says, as far as a schema can."""

import jsonschema
import pytest

from cardan.application.json_schema import application_schema
from cardan.application.reader import loads
from cardan.application.templates import template_text
from cardan.core.errors import InvalidFileError
from cardan.schema.yaml_tree import parse_yaml

SCHEMA = application_schema()
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)
SMALL, TRUCK = template_text("small"), template_text("truck")


def accepted(text):
    root, _ = parse_yaml(text, "f.yaml")
    return VALIDATOR.is_valid(root.value)


@pytest.mark.slow
def test_the_schema_is_one():
    jsonschema.Draft202012Validator.check_schema(SCHEMA)


@pytest.mark.parametrize("text", [SMALL, TRUCK])
def test_the_starters_are_valid(text):
    root, _ = parse_yaml(text, "f.yaml")
    VALIDATOR.validate(root.value)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("length_mm: 1200", "length_mm: '1200'"),
        ("length_mm: 1200", "length_mm: -1200"),
        ("length_mm: 1200", "length_mm: 0"),
        ("length_mm: 1200", "length_mm: true"),
        ("length_mm: 1200", "length_mm: [1200]"),
        ("length_mm: 1200", "length: 1200"),
        ("length_mm: 1200", "lenght_mm: 1200"),
        ("length_mm: 1200", "length_mm: 1200\n      length_in: 47"),
        ("title: Two-piece", "tilte: Two-piece"),
        ("tube: {outer_mm: 101.6, wall_mm: 3.2}", "tube: {outer_mm: 101.6}"),
        ("tube: {outer_mm: 101.6, wall_mm: 3.2}", "tube: {wall_mm: 3.2, outer_mm: 1, outer_in: 1}"),
        ("[3.0, 1.0, 4.5, 2.0]", "[3.0, 1.0, 90, 2.0]"),
        ("[3.0, 1.0, 4.5, 2.0]", "3.0"),
        ("  shafts:", "  joint_angles: {side_deg: [1, 2, 3]}\n  shafts:"),
        ("driveline:", "driveline: {}\ndrivelines:"),
        ("limits: body-builder", "limits: {profile: heavy-truck}"),
        ("limits: body-builder", "states: [gwv]"),
        ("limits: body-builder", "prime_mover: gas"),
        ("limits: body-builder", "adjust: {bearing_height_mm: {one: [-1, 1]}}"),
        ("limits: body-builder", "adjust: {shim_deg: [1]}"),
        ("limits: body-builder", "suspension: {spring: {}}"),
        ("limits: body-builder", "duty: [{share_percent: 100, torque_Nm: 900}]"),
        ("limits: body-builder", "duty: [{share_percent: 0, torque_Nm: 900, speed_rpm: 900}]"),
    ],
)
def test_what_the_schema_refuses_the_reader_refuses(old, new):
    assert old in SMALL
    text = SMALL.replace(old, new, 1)
    assert not accepted(text)
    with pytest.raises(InvalidFileError):
        loads(text)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("length_mm: 1200", "length_in: 47"),
        ("speed_rpm: 2500", "speed_rad_s: 260"),
        ("torque_Nm: 8000", "torque_lbft: 5900"),
        ("title: Two-piece driveline", "title: 1810"),
        ("limits: body-builder", "limits: [{quantity: clearance, maximum: 20, source: us}]"),
        ("limits: body-builder", "states: [gvw, {name: a, slopes: {side_deg: [1, 2, 3, 4]}}]"),
        ("limits: body-builder", "adjust: {bearing_height_mm: {1: [-1, 1]}, phase_deg: [0, 90]}"),
        ("limits: body-builder", "engine: {speed_rpm: 2000, torque_Nm: [900]}"),
        ("limits: body-builder", "suspension: {spring: {rates_N_mm: [9, 10], contact_mm: 80}}"),
        ("  joints: 1710", "  joints: [1810, SPL140, {peak_Nm: 9000}]"),
        ("phase_deg: 0  ", "balance_grade: G40  "),
        ("phase_deg: 0  ", "phase_deg: 1°02'  "),
        ("phase_deg: 0  ", "phase_deg: 0°36′  "),
    ],
)
def test_what_the_reader_accepts_the_schema_accepts(old, new):
    assert old in SMALL
    text = SMALL.replace(old, new, 1)
    loads(text)
    assert accepted(text)


def test_every_key_says_what_it_is_and_in_which_unit():
    for name, table in SCHEMA["$defs"].items():
        assert table["description"], name
        for key, entry in table["properties"].items():
            assert entry["description"], f"{name}.{key}"
    shaft = SCHEMA["$defs"]["Shaft"]["properties"]
    assert shaft["length_in"]["description"] == "joint centre to joint centre, in"
    number, by_hand = shaft["phase_rad"]["anyOf"]
    assert (by_hand["type"], number["type"]) == ("string", "number")
    assert number["maximum"] == pytest.approx(2 * 3.141592653589793)
    efficiency = SCHEMA["$defs"]["Gearbox"]["properties"]["efficiency"]
    assert efficiency["description"] == "of the gearbox (default 1.0)"


def offered(entry):
    """Every value that some alternative of a key enumerates."""
    return [name for one in entry["anyOf"] for name in one.get("enum", [])]


@pytest.mark.parametrize(
    ("table", "key", "names"),
    [
        ("Line", "joints", ["1810", "2040", "SWP 160"]), ("Shaft", "tube", ["120x4"]),
        ("Tube", "material", ["E355-SR"]), ("Layer", "ply", ["T300/5208"]),
        ("Wheels", "tyre", ["315/80 R22.5"]), ("Application", "limits", ["heavy-truck"]),
    ],
)  # fmt: skip
def test_the_schema_names_what_catalogues_have(table, key, names):
    """An editor offers them; a file's own catalogue may bring others."""
    listed = offered(SCHEMA["$defs"][table]["properties"][key])
    assert set(names) <= set(listed)
    own = SMALL.replace("  shafts:", "  joints: of-our-own-catalogue\n  shafts:")
    assert accepted(own)
