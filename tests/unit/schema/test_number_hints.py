"""Numbers by hand: angles in minutes are read, and no hint changes what was meant."""

import re
from typing import Annotated

import numpy as np
import pytest

from cardan.application.reader import loads
from cardan.core.units import UNITS, deg, inch, mm
from cardan.schema.field_types import IntegerField, NumberField
from cardan.schema.node_reader import InvalidValueError, NodeReader, TableReadContext
from cardan.schema.tables import Table, table_key_field
from cardan.schema.yaml_tree import Scalar, parse_yaml

ANGLE, LENGTH = NumberField("deg", "rad"), NumberField("mm", "m", "in")
TORQUE, SPEED = NumberField("Nm", "kNm", "lbft"), NumberField("rpm", "rad_s")
RATIO = NumberField()
FIELDS = {
    "deg": ANGLE, "rad": ANGLE, "mm": LENGTH, "m": LENGTH, "in": LENGTH,
    "Nm": TORQUE, "rpm": SPEED, "": RATIO,
}  # fmt: skip


def attempt(field, text, unit):
    """Return the value read, SI, or None, and the hint."""
    context = TableReadContext()
    try:
        return field.read(NodeReader(Scalar(text, 1, 1), "key", context, unit)), ""
    except InvalidValueError:
        (problem,) = context.problems
        return None, problem.hint


MINUTES = {
    "-36'": -0.6, "36′": 0.6, "1°02'": 1 + 2 / 60, "1° 2' 30\"": 1 + 2.5 / 60, "-0°36’": -0.6,
    "−1°02′30″": -1 - 2.5 / 60, "+4deg30min": 4.5, "0°": 0.0, "-4º": -4.0, "7'30''": 0.125,
    "30\"": 30 / 3600, "1°0.5'": 1 + 0.5 / 60, "4°30´": 4.5, "90'": 1.5,
}  # fmt: skip


@pytest.mark.parametrize(("text", "degrees"), MINUTES.items())
@pytest.mark.parametrize("unit", ["deg", "rad"])
def test_angle_in_minutes_is_read_under_every_key_of_angle(text, degrees, unit):
    assert attempt(ANGLE, text, unit)[0] == pytest.approx(degrees * deg, rel=1e-12)


MEANT = {
    # text: (what it means in SI, units of its dimension)
    **{text: (degrees * deg, "angle") for text, degrees in MINUTES.items()},
    "12 in": (12 * inch, "length"), "3.5in": (3.5 * inch, "length"),
    "55 1/4 in": (55.25 * inch, "length"), "3½ in": (3.5 * inch, "length"),
    "1.2 m": (1.2, "length"), "1200mm": (1.2, "length"), "120 cm": (1.2, "length"),
    "4 ft": (4 * 12 * inch, "length"), "1.5 kNm": (1500.0, "torque"), "900 N·m": (900, "torque"),
    "700 lb ft": (700 * UNITS["lbft"], "torque"), "50 Hz": (50 * 2 * 3.141592653589793, "speed"),
    "100 rad/s": (100.0, "speed"), "2100 r/min": (2100 * UNITS["rpm"], "speed"),
    "93 %": (0.93, "ratio"), "93%": (0.93, "ratio"), "0.2 rad": (0.2, "angle"),
    "4.5 deg": (4.5 * deg, "angle"), "3 grad": (3 * deg, "angle"),
    # What is no single number.
    "10-20": (None, ""), "5 ± 0.5": (None, ""), "4*5": (None, ""), "3 + 2": (None, ""),
    "1°02": (None, ""), "1'30": (None, ""), "5k": (None, ""), "1,234": (None, ""),
    "1,234 mm": (None, ""), "4.5.6 deg": (None, ""), "3.5 furlongs": (None, ""),
    "12 in to 13 in": (None, ""), "1:30": (None, ""), "1e3 x 2": (None, ""),
    "1°75'": (None, ""), "−1.2.3": (None, ""),
}  # fmt: skip
DIMENSIONS = {
    "deg": "angle", "rad": "angle", "mm": "length", "m": "length", "in": "length",
    "Nm": "torque", "rpm": "speed", "": "ratio",
}  # fmt: skip


@pytest.mark.parametrize("text", MEANT)
@pytest.mark.parametrize("unit", FIELDS)
def test_number_that_hint_proposes_is_what_was_meant(text, unit):
    """Read it, propose the same quantity in the key's unit, or propose no number at all."""
    value, dimension = MEANT[text]
    if text == '30"' and DIMENSIONS[unit] == "length":  # inches there, as drawings have it
        value, dimension = 30 * inch, "length"
    read, hint = attempt(FIELDS[unit], text, unit)
    proposed = re.search(r"write ([-+]?[\d.]+(?:e[-+]?\d+)?)", hint)
    if proposed:
        assert dimension == DIMENSIONS[unit]
        again, _ = attempt(FIELDS[unit], proposed[1], unit)
        assert again == pytest.approx(value, rel=1e-11)
    if read is not None:
        assert dimension == DIMENSIONS[unit] == "angle"
        assert read == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "unit", "hint"),
    [
        ("12 in", "mm", "the unit stands in the key: write 304.8 (mm)"),
        ("12 in", "in", "the unit stands in the key: write 12"),
        ("1 1/2 in", "in", "the unit stands in the key: write 1.5"),
        ("4 ft", "m", "the unit stands in the key: write 1.2192 (m)"),
        ("93%", "", "write 0.93"),
        ("1.2 kN", "Nm", "the unit stands in the key: write the number alone, in Nm"),
        ("-36'", "Nm", "the unit stands in the key: write the number alone, in Nm"),
        ("1/8", "in", "a fraction is written with a decimal point: write 0.125"),
    ],
)
def test_unit_of_its_own_is_converted_or_left_to_writer(text, unit, hint):
    assert attempt(FIELDS[unit], text, unit) == (None, hint)


def test_angles_of_application_are_read_as_car_makers_print_them():
    text = """
title: saloon, angles in minutes as its manual prints them
speed_rpm: 5000
driveline:
  joint_angles: {side_deg: [0, -36', 1°02']}
  gearbox_slope: {side_deg: "2° 30' 0\\""}
  shafts: [{}, {}]
limits: protractor
"""
    slopes = np.degrees(loads(text).lines[0].layout.side)
    assert slopes == pytest.approx([2.5, 2.5, 1.9, 1.9 + 1 + 2 / 60])


def test_whole_number_with_unit_is_not_proposed_as_other_number():
    assert attempt(IntegerField(), "36'", "") == (None, "write the number alone")


def test_everyday_unit_is_converted_to_last_digit():
    """123.456 cm of a shaft is 1234.56 mm, not 1235."""
    _, hint = attempt(NumberField("mm", most=10 * mm, usual=(1, 60)), "123.456", "mm")
    assert hint == "is it in cm? then write 1234.56 mm"


class Sized(Table):
    """A part with keys in one unit, and in several."""

    pitch: Annotated[float, NumberField("deg")] = table_key_field("its pitch", default=0.0)
    length: Annotated[float, LENGTH] = table_key_field("its length", default=0.0)
    shaft_length: Annotated[float, NumberField("mm")] = table_key_field("its", default=0.0)


@pytest.mark.parametrize(
    ("key", "hint"),
    [
        ("shaft_lenght_cm", "did you mean shaft_length_mm? its number is in mm"),
        ("length_cm", "not in this unit: convert the number and write length_mm, length_m or "
         "length_in"),
        ("pitch_rad", "not in this unit: convert the number and write pitch_deg"),
        ("pitch_mrad", "did you mean pitch_deg?"),
    ],
)  # fmt: skip
def test_key_of_another_unit_is_not_renamed_without_its_number(key, hint):
    root, problems = parse_yaml(f"{key}: 4", "file")
    with pytest.raises(InvalidValueError):
        Sized.read(NodeReader(root, "", TableReadContext(problems=problems)))
    assert problems[0].hint.endswith(hint)
