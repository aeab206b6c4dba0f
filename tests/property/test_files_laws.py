"""Laws of the application file: one part in any unit, one line in any geometry, no surprises."""

import re

import jsonschema
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cardan.application.json_schema import application_schema
from cardan.application.reader import ApplicationTable, loads
from cardan.application.templates import template_text
from cardan.core.errors import InvalidFileError
from cardan.core.units import UNITS, deg, mm
from cardan.model.application import Application
from cardan.schema.yaml_tree import parse_yaml

SMALL, TRUCK = template_text("small"), template_text("truck")
VALIDATOR = jsonschema.Draft202012Validator(application_schema())
LINE = """\
title: line
driveline:
  shafts:
    - {{length_m: {0!r}, centre_bearing: {{from_rear_joint_mm: 100}}}}
    - {{length_m: {1!r}, centre_bearing: {{from_rear_joint_mm: 100}}}}
    - {{length_m: {2!r}}}
"""

slopes = st.floats(-15, 15)
members = st.lists(slopes, min_size=5, max_size=5)
lengths = st.tuples(*[st.floats(0.4, 3)] * 3)


def line(text, lengths):
    return loads(LINE.format(*lengths) + text).lines[0]


def numbers(values):
    return "[" + ", ".join(repr(float(v)) for v in values) + "]"


@pytest.mark.slow
@given(length=st.floats(0.3, 4), outer=st.floats(0.05, 0.2), wall=st.floats(0.002, 0.02))
def test_part_is_equal_in_every_unit(length, outer, wall):
    """One rounding on the way to the file and one on the way back: a few parts in 1e16."""
    text = "title: a\ndriveline: {{slopes: {{side_deg: [1, 2, 3]}}, shafts: [{{{}}}]}}".format
    shafts = []
    for unit in ("mm", "m", "in"):
        sizes = {"length": length, "outer": outer, "wall": wall}
        a, b, c = (f"{k}_{unit}: {v / UNITS[unit]!r}" for k, v in sizes.items())
        shafts.append(loads(text(f"{a}, tube: {{{b}, {c}}}")).lines[0].line.shafts[0])
    for shaft in shafts:
        found = shaft.length, shaft.tube.outer, shaft.tube.wall
        assert found == pytest.approx((length, outer, wall), rel=1e-15)


@given(value=st.floats(0.01, 1e4), key=st.sampled_from(sorted(ApplicationTable.keys())))
def test_key_value_is_number_times_unit(value, key):
    """Every key of the file's top that ends in a unit, read alone."""
    entry, unit = ApplicationTable.keys()[key]
    if not unit:
        return
    found = getattr(loads(f"{SMALL_BARE}{key}: {value!r}\n"), entry.name)
    assert found == pytest.approx(value * UNITS[unit], rel=1e-15)


SMALL_BARE = SMALL.replace("speed_rpm: 2500 ", "# ").replace("torque_Nm: 8000 ", "# ")


@pytest.mark.slow
@given(side=members, top=members, lengths=lengths)
def test_slopes_joint_angles_and_points_give_equal_geometry(side, top, lengths):
    """Three ways to say a line of up to 9 m; rounding and its sums stay below 1e-13 m."""
    by_slopes = line(f"  slopes: {{side_deg: {numbers(side)}, top_deg: {numbers(top)}}}\n", lengths)
    bends = numbers(np.diff(side)), numbers(np.diff(top))
    by_angles = line(
        f"  joint_angles: {{side_deg: {bends[0]}, top_deg: {bends[1]}}}\n"
        f"  gearbox_slope: {{side_deg: {side[0]!r}, top_deg: {top[0]!r}}}\n",
        lengths,
    )
    points = ", ".join(numbers(p / mm) for p in by_slopes.layout.points)
    by_points = line(
        f"  points_mm: [{points}]\n"
        f"  gearbox_slope: {{side_deg: {side[0]!r}, top_deg: {top[0]!r}}}\n"
        f"  pinion_slope: {{side_deg: {side[-1]!r}, top_deg: {top[-1]!r}}}\n",
        lengths,
    )
    for other in (by_angles, by_points):
        assert other.layout.points == pytest.approx(by_slopes.layout.points, abs=1e-13)
        assert other.layout.directions == pytest.approx(by_slopes.layout.directions, abs=1e-13)
    assert by_slopes.layout.side / deg == pytest.approx(np.array(side), abs=1e-12)
    assert by_slopes.layout.top / deg == pytest.approx(np.array(top), abs=1e-12)


@pytest.mark.slow
@given(side=members, lengths=lengths)
def test_state_with_geometry_of_line_equals_line(side, lengths):
    text = f"  slopes: {{side_deg: {numbers(side)}}}\n"
    state = f"states: [{{name: a, slopes: {{side_deg: {numbers(side)}}}}}]\n"
    application = loads(LINE.format(*lengths) + text + state)
    layout = application.states[0].layouts["main"]
    assert np.array_equal(layout.points, application.lines[0].layout.points)


@pytest.mark.slow
@given(order=st.permutations(range(len(SMALL.split("\n\n")))))
def test_order_of_keys_does_not_change_result(order):
    parts = SMALL.split("\n\n")
    shuffled = loads("\n\n".join(parts[k] for k in order))
    assert shuffled.limits == loads(SMALL).limits
    assert np.array_equal(shuffled.lines[0].layout.points, loads(SMALL).lines[0].layout.points)


# --- any text is an application or a bad file, never a traceback ----------------------------

WORDS = st.sampled_from(
    ["", " ", "\n", "\t", "\r", ":", ": ", ",", ", ", "-", "- ", "[", "]", "{", "}", "#", "&a ",
     "*a", "'", '"', "|", ">", "!", "!!int ", "%", "@", "`", "?", "~", "null", "true", "no", "on",
     "<<: ", "---\n", "...\n", "0", "-1", "1e9", "1e-300", "1e308", "9" * 400, "1:30", "010",
     "0x1F", ".nan", "-.inf", "2,7", "1 800", "\u2212", "é", "\x00", "\x85", "\u2028", "\ufeff",
     "\ud800", "name: ", "gvw", "points_mm: ", "slopes: ", "length_mm: ", "drivelines: ",
     "{1: [-1, 1]}", "[0, 0, 0]", "G40", "limits: ", "states: ", "../", "\\", '"\\0"', '"\\n"']
)  # fmt: skip


def read_or_refused(text):
    """Return the application of a text, None where it is refused: nothing else may happen."""
    try:
        application = loads(text, name="f.yaml")
    except InvalidFileError as error:
        bad = error
    else:
        assert isinstance(application, Application)
        for installed in application.lines:
            assert np.all(np.isfinite(installed.layout.points))
            assert np.all(np.isfinite(installed.layout.directions))
        return application
    assert bad.problems
    assert all(line.startswith("f.yaml:") for line in str(bad).splitlines())
    for problem in bad.problems:
        assert problem.message
        assert 1 <= problem.line <= len(text.splitlines()) + 1
    return None


@pytest.mark.slow
@given(base=st.sampled_from([SMALL, TRUCK]), data=st.data())
def test_file_with_inserted_or_deleted_text_is_read_or_rejected(base, data):
    text = base
    for _ in range(data.draw(st.integers(1, 3))):
        start = data.draw(st.integers(0, len(text)))
        length = data.draw(st.sampled_from([0, 0, 1, 2, 5, 20, 80]))
        text = text[:start] + data.draw(WORDS) + text[start + length :]
    read_or_refused(text)


@pytest.mark.slow
@given(base=st.sampled_from([SMALL, TRUCK]), data=st.data())
def test_file_with_changed_number_is_read_or_rejected(base, data):
    places = [m.span() for m in re.finditer(r"(?<![\w.#])-?\d[\d.]*(?![\w.])", base)]
    start, end = data.draw(st.sampled_from(places))
    number = data.draw(
        st.one_of(
            st.floats(allow_nan=True, allow_infinity=True).map(repr),
            st.integers(-3, 3).map(str),
            WORDS,
        )
    )
    read_or_refused(base[:start] + number + base[end:])


@pytest.mark.slow
@given(base=st.sampled_from([SMALL, TRUCK]), data=st.data())
def test_file_with_missing_or_repeated_line_is_read_or_rejected(base, data):
    lines = base.splitlines(keepends=True)
    k = data.draw(st.integers(0, len(lines) - 1))
    times = data.draw(st.sampled_from([0, 2]))
    read_or_refused("".join(lines[:k] + [lines[k]] * times + lines[k + 1 :]))


@pytest.mark.slow
@given(text=st.text())
def test_any_text_is_read_or_rejected(text):
    read_or_refused(text)


@given(words=st.lists(WORDS, max_size=30))
def test_any_sequence_of_yaml_words_is_read_or_rejected(words):
    read_or_refused("".join(words))


@settings(max_examples=40)
@given(base=st.sampled_from([SMALL, TRUCK]), data=st.data())
def test_schema_accepts_every_readable_file(base, data):
    start, end = data.draw(st.sampled_from([m.span() for m in re.finditer(r"[\w.-]+", base)]))
    text = base[:start] + data.draw(WORDS) + base[end:]
    if read_or_refused(text) is not None:
        VALIDATOR.validate(parse_yaml(text, "f.yaml")[0].value)
