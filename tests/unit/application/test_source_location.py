"""Where things stand in a file: numbers by their address, and errors found after the reading."""

import pytest
from repository import EXAMPLES

from cardan.application.reader import loads, read
from cardan.application.source_location import error_with_location, locate_yaml_address
from cardan.application.templates import template_text
from cardan.approval.approval import approve_driveline
from cardan.core.errors import DesignError, SourceLocation, prefix_error_address
from cardan.topics.torsion.study import analyse_vibration

SMALL, TRUCK = template_text("small"), template_text("truck")
TOO_SHORT = "too short"


def at(text: str, mark: str) -> tuple[int, int]:
    """Line and column, from 1, of a mark in a text."""
    start = text.index(mark)
    return text.count("\n", 0, start) + 1, start - (text.rfind("\n", 0, start) + 1) + 1


@pytest.mark.parametrize(
    ("address", "mark"),
    [
        ("title", "Two-piece"),
        ("speed_rpm", "2500"),
        ("driveline", "driveline:"),
        ("driveline.slopes.side_deg[3]", "4.5"),
        ("driveline.shafts[2]", "length_mm: 1500"),
        ("driveline.shafts[2].length_mm", "1500"),
        ("driveline.shafts[1].tube.wall_mm", "3.2"),
        ("driveline.shafts[1].centre_bearing.from_rear_joint_mm", "140"),
    ],
)
def test_every_value_is_found_by_the_key_its_errors_print(address, mark):
    origins = loads(SMALL).source_locations
    line, column = at(SMALL, mark)
    assert origins[address] == SourceLocation(key=address, line=line, column=column)


def test_an_address_needs_no_unit_and_no_way_through_the_only_line():
    small = loads(SMALL)
    found = [
        locate_yaml_address(small, "drivelines.main.shafts[1].tube.wall"),
        locate_yaml_address(small, "driveline.shafts[1].tube.wall"),
        locate_yaml_address(small, "drivelines.main.nothing", "driveline.shafts[1].tube.wall"),
    ]
    assert {f.key for f in found} == {"driveline.shafts[1].tube.wall_mm"}


def test_what_is_not_given_stands_where_it_would():
    small = loads(SMALL)
    assert (
        locate_yaml_address(small, "driveline.shafts[2].spline.plunge").key == "driveline.shafts[2]"
    )
    assert locate_yaml_address(small, "driveline.suspension.linkage").key == "driveline"
    assert locate_yaml_address(small, "vehicle.wheelbase") is None


def test_origins_are_no_part_of_what_an_application_is():
    """The same truck, a line further down, is the same truck."""
    assert loads(f"\n{SMALL}").source_locations != loads(SMALL).source_locations
    assert loads(f"\n{SMALL}").states == loads(SMALL).states
    assert "origins" not in repr(loads(SMALL))


def test_callers_say_where_a_part_is():
    with (
        pytest.raises(DesignError) as error,
        prefix_error_address("suspension"),
        prefix_error_address("linkage"),
    ):
        raise DesignError(TOO_SHORT, about="radius")
    assert (str(error.value), error.value.about) == (TOO_SHORT, "suspension.linkage.radius")


REFUSED_LATER = {
    "a link too short": (
        TRUCK.replace("front_half_length_mm: 760", "front_half_length_mm: 60"),
        "linkage:", "suspension.linkage: a link of radius 45 mm cannot follow",
    ),
    "a joint that locks": (
        TRUCK.replace("windup_stiffness_kNm_deg: 16", "windup_stiffness_Nm_deg: 300"),
        "- windup ", "states[6]: joint 3 of line main locks in state windup",
    ),
    "a state without a load": (
        TRUCK.replace("    gvw: {mass_kg", "    full: {mass_kg"),
        "reference: gvw", "suspension.reference: suspension state gvw needs the axle's load",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED_LATER)
def test_what_only_the_answer_shows_is_told_with_its_place(case):
    """These named a file at best: `error: truck.yaml: a link of radius ...`, in 140 lines."""
    text, mark, message = REFUSED_LATER[case]
    application = loads(text)
    with pytest.raises(DesignError) as error:
        approve_driveline(application)
    line, _ = at(text, mark)
    told = error_with_location(error.value, application, "f.yaml")
    assert told.startswith(f"f.yaml:{line}:")
    assert message in told


def test_a_shaft_without_a_tube_is_found_by_who_needs_it():
    text = TRUCK.replace("    - tube: 5.000x0.134in", "    - # no tube", 1)
    application = loads(text)
    with pytest.raises(DesignError) as error:
        analyse_vibration(application)
    assert (
        error_with_location(error.value, application, "f").split(": ")[1] == "driveline.shafts[1]"
    )


def test_an_error_without_a_place_names_the_file_alone():
    assert error_with_location(DesignError("no"), loads(SMALL), "f.yaml") == "f.yaml: no"
    assert (
        error_with_location(DesignError("no", about="vehicle"), loads(SMALL), "f.yaml")
        == "f.yaml: no"
    )


def test_a_line_of_several_has_its_own_places():
    tandem = read(EXAMPLES / "tandem-6x4.yaml")
    ratio = "drivelines.inter-axle.axle.ratio"
    assert locate_yaml_address(tandem, ratio).key == ratio
