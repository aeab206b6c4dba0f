"""The application file's bracket, read into parts."""

import pytest
from brackets import BRACKET, LINE
from repository import EXAMPLES

from cardan.application import json_schema, reader
from cardan.approval.approval import approve_driveline
from cardan.core.errors import InvalidFileError
from cardan.core.units import g, mm
from cardan.topics.bracket.assessment import load_cases
from cardan.topics.bracket.load_cases import WIDEST_STRESS_SWING_CASE_NAMES
from cardan.topics.bracket.schema import VEHICLE_STATE_LOAD_CASE_NAMES

FULL = (
    BRACKET
    + """\
  material: S355MC
  order: 2
  carried_mass_kg: 18
  rubber_N_mm: [150, 300, 300]
  gauges: [{name: S1, point_mm: [0, 56, 20], direction: [0, 0, 1], length_mm: 6}]
  cases:
    - {name: down, force_kN: [0, 0, -1]}
    - {name: pothole, acceleration_g: [0, 0, 5]}
  reinforced: {thickness_mm: 8}
"""
)


def bracket(text):
    return reader.loads(LINE + text).bracket


def test_a_bracket_is_read_in_si():
    found = bracket(FULL)
    assert found.shape.seat_diameter == pytest.approx(0.1)
    assert found.material.name == "S355MC"
    assert found.rubber == pytest.approx((150e3, 300e3, 300e3))
    assert found.gauges[0].length == pytest.approx(6 * mm)
    assert found.cases[0].force == pytest.approx((0, 0, -1000))
    assert found.cases[1].acceleration == pytest.approx((0, 0, 5 * g))
    assert found.reinforced.thickness == pytest.approx(8 * mm)
    assert found.reinforced.width == found.shape.width
    assert reader.loads(LINE).bracket is None


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("material: S355MC", "material: S355MD"), "did you mean S355MC"),
        (("material: S355MC", "bearing: 2"), "has 1 centre bearing"),
        (("material: S355MC", "line: rear"), "no driveline of this name"),
        (("bolt_pitch_mm: 40", "bolt_pitch_mm: 60"), "bolt_pitch of a U bracket is 60 mm"),
        (("reinforced: {thickness_mm: 8}", "reinforced: {depth_mm: 8}"), "has no depth"),
        (("reinforced: {thickness_mm: 8}", "reinforced: {}"), "nothing that is different"),
        (("force_kN: [0, 0, -1]", "force_kN: [0, 0, 0]"), "loads nothing"),
        (("direction: [0, 0, 1]", "direction: [0, 0, 0]"), "direction that is not zero"),
        (("reinforced: {thickness_mm: 8}", "recordings: [{name: down, file: down.csv}]"),
         r"recordings\[1\].*name is above already"),
        (("name: pothole", 'name: "as given: worst point"'), r"cases\[2\].*state has this name"),
        (("order: 2", "order: 0"), "order.*a whole number from 2 to 4"),
        (("reinforced: {thickness_mm: 8}", 'recordings: [{name: "as given: peak", file: a.csv}]'),
         r"recordings\[1\].*name is above already"),
        (("u_shape:", "step: {file: a.step, centre_mm: [0, 0, 0], seat: [{name: bore}], "
          "bolts: [{name: b}], thickness_mm: 8}\n  u_shape:"), "exclude each other"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_with_its_place(change, says):
    text = FULL.replace(*change)
    with pytest.raises(InvalidFileError, match=says) as refused:
        bracket(text)
    assert all(p.line > LINE.count("\n") for p in refused.value.problems)


def test_a_file_that_says_order_1_is_read_with_order_2_and_says_so():
    """Files that were written when it was taken are read."""
    application = reader.loads(LINE + FULL.replace("order: 2", "order: 1"))
    assert application.bracket.order == 2
    assert [w.key for w in application.warnings if "read as 2" in w.message] == ["bracket.order"]
    assert not any("read as 2" in w.message for w in reader.loads(LINE + FULL).warnings)


def test_a_loss_that_the_file_gives_is_not_assumed():
    """Nor is one that is as large as what is assumed of others."""
    given = bracket(FULL + "  loss_factor: 0.02\n")
    assert (given.loss, given.loss_assumed) == (0.02, False)
    assert (bracket(FULL).loss, bracket(FULL).loss_assumed) == (0.02, True)


def test_the_schema_knows_the_bracket():
    schema = json_schema.application_schema()
    assert "bracket" in schema["$defs"]["Application"]["properties"]
    assert "thickness_mm" in schema["$defs"]["UShape"]["properties"]
    assert (
        schema["$defs"]["Bracket"]["properties"]["order"]["minimum"] == 2
    )  # as docs, and errors, say


def test_the_names_a_state_s_cases_have_are_those_that_are_kept_from_others():
    """What a study calls them, of a line with every kind of case."""
    truck = EXAMPLES / "medium-truck-4x2.yaml"
    (response,) = approve_driveline(reader.read(truck)).line_responses
    own = {case.component for case in load_cases(bracket(BRACKET), response)}
    assert own | {*WIDEST_STRESS_SWING_CASE_NAMES.values()} == set(VEHICLE_STATE_LOAD_CASE_NAMES)
