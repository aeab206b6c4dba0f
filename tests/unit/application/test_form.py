"""A first file from what was typed or pasted, by people who write 3,5 and copy tables."""

from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cardan.application import reader
from cardan.application.form import application_text_from_form, texts_of_both_wheelbases
from cardan.application.paste_import import parse_hardpoints, parse_number_of_unknown_locale
from cardan.core.errors import DesignError, InvalidFileError
from cardan.core.units import deg

FORM = {
    "title": "Tipper", "speed": "2 500", "torque": "8000", "unit": "mm", "limits": "protractor",
    "members": [{"side": "3"}, {"side": "1,0"}, {"side": "4.5°"}, {"side": "2", "top": "-0,5"}],
    "shafts": [{"length": "1200", "bearing": "140", "tube": "100x3"},
               {"length": "1500", "phase": "90"}],
}  # fmt: skip


OWN_PARTS = {
    **FORM, "joint": "own", "joint_name": "K-2: 80", "joint_peak": "12000",
    "joint_reversing": "4000", "joint_angle": "25",
    "shafts": [{"length": "1200", "bearing": "140", "tube": "own", "outer": "100", "wall": "3.5",
                "vertical": "200", "lateral": "120"},
               {"length": "1500", "phase": "90", "tube": "100x3", "outer": "90"}],
}  # fmt: skip


@pytest.mark.parametrize("unit", ["mm", "in"])
def test_own_joint_tube_and_bearing_stiffness_are_written(unit):
    """A form offered shipped sizes alone: a tube from a drawing took an editor."""
    app = reader.loads(application_text_from_form({**OWN_PARTS, "unit": unit}))
    line, size = app.lines[0].line, {"mm": 1e-3, "in": 0.0254}[unit]
    joint, first, second = line.joints[0], line.shafts[0].tube, line.shafts[1].tube
    assert (joint.name, joint.peak_torque, joint.reversing_torque) == ("K-2: 80", 12000, 4000)
    assert joint.angle_max == pytest.approx(25 * deg)
    assert joint.bearing_torque is None
    assert (first.outer, first.wall) == pytest.approx((100 * size, 3.5 * size))
    assert (second.outer, second.wall) == pytest.approx((0.1, 0.003))  # of the catalogue
    assert line.shafts[0].centre_bearing.stiffness == pytest.approx((200e3, 120e3))


@pytest.mark.parametrize(
    ("decimal", "ratios"),
    [(".", "6.7 3.8 2.3 1"), (".", "6.7, 3.8,2.3/1"), (",", "6,7 3,8 2,3 1"),
     (",", "6,7; 3,8;2,3; 1"), (",", "6,7, 3,8, 2,3, 1")],
)  # fmt: skip
def test_engine_and_ratios_are_written(decimal, ratios):
    gears = {"engine_torque": "900", "engine_speed": "1400", "ratios": ratios, "reverse": "6"}
    form = {**FORM, "members": [{"side": k} for k in "3142"], **gears, "torque": ""}
    app = reader.loads(application_text_from_form(form, decimal=decimal))
    assert tuple(app.gearbox.ratios) == (6.7, 3.8, 2.3, 1)
    assert app.gearbox.reverse_ratio == 6
    assert float(np.max(app.engine.torque)) == 900


def test_incomplete_own_parts_and_gears_name_their_fields():
    bare = {**FORM, "joint": "own", "ratios": "6.7", "members": [{"side": k} for k in "3142"],
            "shafts": [{"length": "1200", "bearing": "140", "tube": "own", "wall": "x"},
                       {"length": "1500"}]}  # fmt: skip
    with pytest.raises(InvalidFileError) as found:
        application_text_from_form(bare)
    assert {p.key for p in found.value.problems} == {
        "joint_peak", "engine_speed", "engine_torque", "shafts[1].outer", "shafts[1].wall",
    }  # fmt: skip


def test_wheelbase_change_moves_last_joint_by_difference():
    text = application_text_from_form(FORM)
    assert texts_of_both_wheelbases(text, FORM) == (text,)
    form = {**FORM, "wheelbase_from": "3 600", "wheelbase_to": "4500"}
    before, after = texts_of_both_wheelbases(text, form)
    assert before.splitlines()[1:] == text.splitlines()
    assert "# Wheelbase 4500 mm, changed from 3600 mm" in after
    was, now = (reader.loads(t).lines[0].layout.points for t in (before, after))
    assert now[-1] - was[-1] == pytest.approx([0.9, 0, 0], abs=1e-4)  # slopes to 0.001 deg
    assert now[:-1] == pytest.approx(was[:-1], abs=1e-4)


@pytest.mark.parametrize(
    ("from_", "to", "keys"),
    [("3600", "", {"wheelbase_to"}), ("", "x", {"wheelbase_from", "wheelbase_to"}),
     ("3600", "-1", {"wheelbase_to"}), ("0", "3600", {"wheelbase_from"})],
)  # fmt: skip
def test_unusable_wheelbase_names_its_field(from_, to, keys):
    form = {**FORM, "wheelbase_from": from_, "wheelbase_to": to}
    with pytest.raises(InvalidFileError) as found:
        texts_of_both_wheelbases(application_text_from_form(form), form)
    assert {p.key for p in found.value.problems} == keys


def test_wheelbase_too_short_for_last_shaft_is_rejected():
    form = {**FORM, "wheelbase_from": "3600", "wheelbase_to": "2300"}
    with pytest.raises(DesignError, match="such a wheelbase needs a line with one shaft less"):
        texts_of_both_wheelbases(application_text_from_form(form), form)


@pytest.mark.parametrize(
    ("said", "value"),
    [
        ("3,5", 3.5), ("3.5", 3.5), (" -3,5° ", -3.5), ("1 234,5", 1234.5), ("1.234,5", 1234.5),
        ("1,234.5", 1234.5), ("1,234", 1.234), ("1\u00a0800", 1800.0), ("\u22122", -2.0),
        ("2e3", 2000.0), (".5", 0.5), ("", None), ("3 mm", None), ("about 3", None),
        ("1,2,3", None), ("nan", None), ("inf", None), ("1 2", None), ("--1", None),
    ],
)  # fmt: skip
def test_typed_number_is_parsed(said, value):
    assert parse_number_of_unknown_locale(said) == value


@pytest.mark.parametrize(
    ("said", "either"),
    [("8.000", "8,000 or 8000"), ("-1.500°", "-1,500 or -1500"), ("0.125", None), ("2.5", None),
     ("1.2345", None), ("1.234,5", None), ("2500.125", None)],
)  # fmt: skip
def test_ambiguous_thousands_separator_is_rejected(said, either):
    """A file of a form in Portuguese or Italian had 8 N m for 8.000; in English 8,000 was eight."""
    turned = str.maketrans(",.", ".,")
    for decimal in ",.":
        if decimal == ".":
            said, either = said.translate(turned), either and either.translate(turned)
        form = {**FORM, "torque": said}
        if either:
            with pytest.raises(InvalidFileError) as found:
                application_text_from_form(form, decimal=decimal)
            (problem,) = found.value.problems
            assert problem.message == f"decimals or thousands? write {either}"
            assert (problem.key, problem.value) == ("torque", said)
        else:
            assert (
                f"torque_Nm: {parse_number_of_unknown_locale(said):.10g}\n"
                in application_text_from_form(form, decimal=decimal)
            )


@pytest.mark.parametrize("unit", ["mm", "in"])
def test_heading_unit_contradicting_chosen_unit_is_rejected(unit):
    """A sheet in inches became a line of 59 mm, with a word that it is unusually small."""
    sheet = "Joint\tX [in]\tY [in]\tZ [in]\nA\t0\t0\t0\nB\t59.2\t0\t-3"
    if unit == "in":
        assert parse_hardpoints(sheet, unit=unit)[1] == (59.2, 0, -3)
        assert parse_hardpoints(sheet) == parse_hardpoints(sheet, unit=unit)
    else:
        with pytest.raises(InvalidFileError, match="the heading says in, and mm was chosen"):
            parse_hardpoints(sheet, unit=unit)


@given(st.floats(-1e6, 1e6).map(lambda v: round(v, 3)))
def test_number_parses_with_either_decimal_sign(value):
    for said in (f"{value:.3f}", f"{value:.3f}".replace(".", ",")):
        assert parse_number_of_unknown_locale(said) == pytest.approx(value, abs=1e-9)


@pytest.mark.parametrize(
    "sheet",
    [
        "1\t2\t3\n4\t5\t6", "x y z\n1 2 3\n4 5 6\n", "A;1;2;3\nB;4;5;6",
        "J1\t1,0\t2\t3\r\nJ2\t4\t5\t6,0",
        "| 1 | 2 | 3 |\n| 4 | 5 | 6 |", "Z [mm]\tnote\tx\ty\n3\tfront\t1\t2\n6\t\t4\t5",
        "\tx\ty\tz\t\nA\t1\t2\t3\t\nB\t4\t5\t6\t",
        "name\tnote\tx\ty\tz\nA\tfront\t1\t2\t3\nB\t\t4\t5\t6\n\n",
    ],
)  # fmt: skip
def test_pasted_spreadsheet_table_is_parsed(sheet):
    assert parse_hardpoints(sheet) == ((1, 2, 3), (4, 5, 6))


def test_invalid_hardpoint_row_is_rejected_by_row_number():
    with pytest.raises(InvalidFileError) as found:
        parse_hardpoints("A\t1\t2\t3\nB\t4\tfive\t6\nC\t7\t8\n")
    assert [(p.key, p.value, p.line) for p in found.value.problems] == [
        ("row 2", "five", 2), ("row 3", "C 7 8", 3),
    ]  # fmt: skip
    with pytest.raises(InvalidFileError, match="last three"):
        parse_hardpoints("1\t0\t0\t0\n2\t1200\t\t-20\n3\t2600\t0\t-150")  # not 2, 1200, -20
    for heading in ("joint\tx\ty", "x\ty\ty"):
        with pytest.raises(InvalidFileError, match="each once"):
            parse_hardpoints(f"{heading}\n1\t0\t0\n2\t1200\t0")
    for sheet in ("", "x y z", "1 2 3"):
        with pytest.raises(InvalidFileError, match="a row of x, y and z"):
            parse_hardpoints(sheet)


def test_form_input_produces_equivalent_application_file():
    app = reader.loads(application_text_from_form(FORM))
    (installed,) = app.lines
    assert np.degrees(installed.layout.side) == pytest.approx([3, 1, 4.5, 2])
    assert np.degrees(installed.layout.top) == pytest.approx([0, 0, 0, -0.5])
    first, second = installed.line.shafts
    assert first.tube.outer == 0.1
    assert first.centre_bearing.from_rear_joint == pytest.approx(0.14)
    assert np.degrees(second.phase) == pytest.approx(90)
    assert (app.title, app.profile) == ("Tipper", "protractor")


def test_form_accepts_inches_and_hardpoints():
    app = reader.loads(application_text_from_form({**FORM, "unit": "in", "shafts": [
        {"length": "48", "bearing": "6"}, {"length": "60"}]}))  # fmt: skip
    assert app.lines[0].layout.lengths == pytest.approx([48 * 0.0254, 60 * 0.0254])
    form = {**FORM, "points": "0 0 0\n-1000 50 -20\n-2500 0 -100", "axes": "front"}
    app = reader.loads(application_text_from_form(form))
    assert app.lines[0].layout.points[1] == pytest.approx([1.0, -0.05, -0.02])
    assert np.degrees(app.lines[0].layout.side[[0, -1]]) == pytest.approx([3, 2])
    with pytest.raises(InvalidFileError, match="the line has 3 joints"):
        application_text_from_form({**FORM, "points": "0 0 0\n1000 50 -20"})


def test_every_invalid_form_field_is_reported():
    form = {**FORM, "speed": "fast", "members": [{"side": "x"}, {}, {"side": "1"}, {"side": "2"}]}
    with pytest.raises(InvalidFileError) as found:
        application_text_from_form({**form, "shafts": [{}, {"length": "1"}]})
    assert {p.key for p in found.value.problems} == {
        "speed", "members[1].side", "members[2].side", "shafts[1].length", "shafts[1].bearing",
    }  # fmt: skip
    with pytest.raises(InvalidFileError, match="1 to 6 shafts"):
        application_text_from_form({**FORM, "shafts": []})


@pytest.mark.slow
@given(st.text(max_size=30), st.text(max_size=12))
def test_any_form_input_yields_file_or_error(title, typed):
    try:
        text = application_text_from_form({**FORM, "title": title, "torque": typed})
    except InvalidFileError:
        return
    # What it cannot be is said as of any file: nothing else goes wrong.
    with suppress(InvalidFileError):
        assert reader.loads(text).lines
