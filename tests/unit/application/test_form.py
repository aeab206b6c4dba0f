"""A first file from what was typed or pasted, by people who write 3,5 and copy tables."""

from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cardan.application import reader
from cardan.application.form import application_text_from_form
from cardan.application.paste_import import parse_hardpoints, parse_number_of_unknown_locale
from cardan.core.errors import InvalidFileError

FORM = {
    "title": "Tipper", "speed": "2 500", "torque": "8000", "unit": "mm", "limits": "protractor",
    "members": [{"side": "3"}, {"side": "1,0"}, {"side": "4.5°"}, {"side": "2", "top": "-0,5"}],
    "shafts": [{"length": "1200", "bearing": "140", "tube": "100x3"},
               {"length": "1500", "phase": "90"}],
}  # fmt: skip


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
