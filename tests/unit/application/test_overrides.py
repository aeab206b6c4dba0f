"""Numbers of a file by their address: what there is, and what may stand in its place."""

from dataclasses import replace

import numpy as np
import pytest
from repository import ROOT

from cardan.application import overrides, reader
from cardan.core.errors import DesignError, InvalidFileError
from cardan.core.units import kNm, mm

TRUCK = reader.read(ROOT / "tests" / "truck.yaml")
COLLECTOR = reader.read(ROOT / "examples" / "refuse-collector-6x2.yaml")


def test_the_address_of_a_number_is_the_key_its_errors_print():
    found = overrides.addresses(TRUCK)
    assert found["suspension.spring.load_N[3]"] == 46000
    assert found["vehicle.loads.gvw.mass_kg"] == 23000
    assert found["driveline.points_mm[2][3]"] == -75
    assert found["driveline.shafts[1].centre_bearing.lateral_stiffness_N_mm"] == 120
    assert found["states[7].travel_mm"] == 40
    assert found["driveline.shafts[2].balance_grade"] == 40
    with pytest.raises(InvalidFileError, match=r"suspension\.spring\.load_N\[3\]: must be above"):
        overrides.change(TRUCK, {"suspension.spring.load_N[3]": 10.0})


def test_a_part_of_a_catalogue_has_its_numbers_beneath_its_name():
    found = overrides.addresses(COLLECTOR)
    assert found["driveline.shafts[2].tube.wall_mm"] == 4
    thick = overrides.change(COLLECTOR, {"driveline.shafts[2].tube.wall_mm": 5})
    assert [s.tube.wall for s in thick.lines[0].line.shafts] == [4 * mm, 5 * mm, 4 * mm]
    assert thick.lines[0].line.joints == COLLECTOR.lines[0].line.joints


def test_limits_ranges_and_the_bracket_are_no_part_of_the_design():
    assert not [at for at in overrides.addresses(TRUCK) if at.startswith(("limits", "adjust"))]
    at = "limits.overrides[1].normal"
    assert overrides.change(TRUCK, {at: 25.0}).limits[-1].normal == pytest.approx(25 * mm)
    with pytest.raises(InvalidFileError, match="no part of the design: give it one number"):
        overrides.change(TRUCK, {at: [25.0, 26.0]})


def test_values_are_in_the_unit_of_the_key():
    changed = overrides.change(TRUCK, {"suspension.windup_stiffness_kNm_deg": 20.0})
    stiffness = TRUCK.suspension.windup_stiffness
    assert changed.suspension.windup_stiffness == pytest.approx(stiffness * 20 / 16, rel=1e-14)
    assert changed.suspension.windup_stiffness > 1000 * kNm


def test_an_array_becomes_variants_ahead_of_the_states():
    walls = np.array([3.0, 4.0, 5.0])
    changed = overrides.change(COLLECTOR, {"driveline.shafts[1].tube.wall_mm": walls})
    np.testing.assert_allclose(changed.lines[0].line.shafts[0].tube.wall, walls[:, None] * mm)
    found = overrides.addresses(changed)["driveline.shafts[1].tube.wall_mm"]
    np.testing.assert_array_equal(found, walls)


def test_what_was_warned_of_can_be_changed_and_is_warned_of_again():
    """A file that was wondered at was refused: "has had its warnings replaced"."""
    text = (ROOT / "tests" / "truck.yaml").read_text(encoding="utf-8")
    odd = reader.loads(text.replace("  friction: 0.8", "  friction: 1.9"))
    (warning,) = odd.warnings
    assert overrides.addresses(odd) == overrides.addresses(TRUCK) | {"tyre.friction": 1.9}
    softer = overrides.change(odd, {"suspension.windup_stiffness_kNm_deg": 15.0})
    assert softer.warnings == (warning,)
    cured = overrides.change(softer, {"tyre.friction": 0.8})
    assert cured.warnings == ()
    assert overrides.change(cured, {"tyre.friction": 1.9}).warnings[0].message == warning.message


def test_changes_add_up_and_leave_the_first_as_it_was():
    one = overrides.change(TRUCK, {"tyre.friction": 0.7})
    two = overrides.change(one, {"tyre.static_radius_mm": 470})
    assert (two.tyre.friction, two.tyre.static_radius) == (0.7, 470 * mm)
    assert TRUCK.tyre.friction == 0.8
    back = overrides.change(two, {"tyre.friction": 0.8, "tyre.static_radius_mm": 480})
    assert overrides.addresses(back) == overrides.addresses(TRUCK)
    assert back.tyre == TRUCK.tyre


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"tyre.frction": 0.7}, "tyre.frction: no number has this address; did you mean tyre.fric"),
        (
            {"tyre.friction": -1.0},
            r"truck.yaml:\d+:13: tyre.friction: must be a number of at",
        ),
        ({"tyre.friction": [0.5, 0.9, 3.0]}, r"at most 2 \(got 0.5 ... 3\)"),
        ({"tyre.friction": [0.5, np.nan]}, r"tyre.friction: must be a number of at least 0.001"),
        ({"driveline.shafts[2].tube.wall_mm": [4.0, 80.0]}, "at most half its outside diameter"),
        ({"duty[1].share_percent": [30.0, 40.0]}, r"the shares must make 100 % \(got 110 %\)"),
    ],
)
def test_what_cannot_be_is_refused_like_the_file_itself(changes, message):
    with pytest.raises(InvalidFileError, match=message):
        overrides.change(TRUCK, changes)


def test_arrays_are_of_one_length():
    with pytest.raises(ValueError, match="one length"):
        overrides.change(TRUCK, {"tyre.friction": [0.7, 0.8], "tyre.static_radius_mm": [470.0] * 3})


def test_only_what_the_file_still_says_can_be_changed():
    """A correction replaces parts; reading the file again would undo it without a word."""
    other = replace(TRUCK, lines=(replace(TRUCK.lines[0], load_share=0.9),), title="corrected")
    with pytest.raises(DesignError, match="title, lines replaced"):
        overrides.change(other, {"tyre.friction": 0.7})
    with pytest.raises(DesignError, match="not read from a file"):
        overrides.addresses(replace(TRUCK, written=None))
