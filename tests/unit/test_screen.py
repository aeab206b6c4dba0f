"""Tables of the terminal on screens of any width."""

import re

from hypothesis import given
from hypothesis import strategies as st

from cardan.report.screen import folded, long, table, wrapped

WORDS = st.lists(st.text("abcxyz.", min_size=1, max_size=11), max_size=5).map(" ".join)


@st.composite
def tables(draw):
    columns = draw(st.integers(2, 7))
    row = st.lists(WORDS, min_size=columns, max_size=columns)
    return draw(row), draw(st.lists(row, min_size=1, max_size=5))


@given(tables(), st.integers(40, 120))
def test_a_table_fits_its_screen_and_leaves_nothing_out(of, width):
    head, rows = of
    lines = list(table(head, rows, width))
    assert max(map(long, lines), default=0) <= width
    told = sorted(re.findall(r"[^ ]+", " ".join(lines)))
    meant = sorted(re.findall(r"[^ ]+", " ".join(cell for row in (head, *rows) for cell in row)))
    if len(rows) < 2:  # on its side a long one says its heads again
        assert told == meant
    else:
        assert set(told) == set(meant)


def test_what_fits_stands_in_columns():
    lines = list(table(("gear", "peak [N·m]"), [("1", "5399"), ("R", "-3007")], 30))
    assert lines == ["gear  peak [N·m]", "1     5399", "R     -3007"]


def test_a_row_of_numbers_breaks_between_them():
    """An engine's speeds came as "1000, 1600, 2400, 2" and "800 rpm"."""
    rows = wrapped("1000, 1600, 2400, 2800 rpm", 20)
    assert rows == ["1000, 1600, 2400,", "2800 rpm"]


def test_a_number_stays_with_what_it_counts():
    (_, *lines) = table(("what", "where"), [("x", "gear 1, mode 12: far away from here")], 24)
    assert not any(line.rstrip().endswith(("gear", "mode")) for line in lines)


def test_a_number_stays_with_its_unit():
    said = "marcha 1 a 241 rpm, 3372 N·m, a ordem 2 encontra guinada a 8 Hz, mancal central 2"
    for width in range(30, 82):
        (_, *cells) = table(("what", "where"), [("x", said)], width)
        for line in (*folded([said], width), *cells):
            assert not re.match(r" *(Hz|N·m|rpm)", line), (width, line)


def test_a_name_above_its_row_fits_too():
    name = "a circumstance of so many words that forty columns have no room for it"
    lines = list(table(("", "", "", "x" * 11), [(name, "aa", "b" * 11, "")], 40))
    assert max(map(long, lines)) <= 40
