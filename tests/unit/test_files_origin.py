"""Where things stand in a file: numbers by their address, and errors found after the reading."""

from pathlib import Path

import pytest

from cardan.base.errors import DesignError, Place, about
from cardan.files import loads, located, place, read, starter
from cardan.study.approval import assess
from cardan.study.stability import stability

SMALL, TRUCK = starter("small"), starter("truck")
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
    origins = loads(SMALL).origins
    line, column = at(SMALL, mark)
    assert origins[address] == Place(key=address, line=line, column=column)


def test_an_address_needs_no_unit_and_no_way_through_the_only_line():
    small = loads(SMALL)
    found = [
        place(small, "drivelines.main.shafts[1].tube.wall"),
        place(small, "driveline.shafts[1].tube.wall"),
        place(small, "drivelines.main.nothing", "driveline.shafts[1].tube.wall"),
    ]
    assert {f.key for f in found} == {"driveline.shafts[1].tube.wall_mm"}


def test_what_is_not_given_stands_where_it_would():
    small = loads(SMALL)
    assert place(small, "driveline.shafts[2].spline.plunge").key == "driveline.shafts[2]"
    assert place(small, "driveline.suspension.linkage").key == "driveline"
    assert place(small, "vehicle.wheelbase") is None


def test_origins_are_no_part_of_what_an_application_is():
    """The same truck, a line further down, is the same truck."""
    assert loads(f"\n{SMALL}").origins != loads(SMALL).origins
    assert loads(f"\n{SMALL}").states == loads(SMALL).states
    assert "origins" not in repr(loads(SMALL))


def test_callers_say_where_a_part_is():
    with pytest.raises(DesignError) as error, about("suspension"), about("linkage"):
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
        assess(application)
    line, _ = at(text, mark)
    told = located(error.value, application, "f.yaml")
    assert told.startswith(f"f.yaml:{line}:")
    assert message in told


def test_a_shaft_without_a_tube_is_found_by_who_needs_it():
    text = TRUCK.replace("    - tube: 5.000x0.134in", "    - # no tube", 1)
    application = loads(text)
    with pytest.raises(DesignError) as error:
        stability(application)
    assert located(error.value, application, "f").split(": ")[1] == "driveline.shafts[1]"


def test_an_error_without_a_place_names_the_file_alone():
    assert located(DesignError("no"), loads(SMALL), "f.yaml") == "f.yaml: no"
    assert located(DesignError("no", about="vehicle"), loads(SMALL), "f.yaml") == "f.yaml: no"


def test_a_line_of_several_has_its_own_places():
    tandem = read(Path(__file__).parents[2] / "examples" / "tandem-6x4.yaml")
    ratio = "drivelines.inter-axle.axle.ratio"
    assert place(tandem, ratio).key == ratio
