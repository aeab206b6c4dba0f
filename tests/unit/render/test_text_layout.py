"""Tables of the terminal on screens of any width."""

import re

from hypothesis import given
from hypothesis import strategies as st

from cardan.render.text_layout import display_width, fold_lines, table_lines, wrap_text

WORDS = st.lists(st.text("abcxyz.", min_size=1, max_size=11), max_size=5).map(" ".join)


@st.composite
def tables(draw):
    columns = draw(st.integers(2, 7))
    row = st.lists(WORDS, min_size=columns, max_size=columns)
    return draw(row), draw(st.lists(row, min_size=1, max_size=5))


@given(tables(), st.integers(40, 120))
def test_table_fits_screen_width_without_losing_words(of, width):
    head, rows = of
    lines = list(table_lines(head, rows, width))
    assert max(map(display_width, lines), default=0) <= width
    told = sorted(re.findall(r"[^ ]+", " ".join(lines)))
    meant = sorted(re.findall(r"[^ ]+", " ".join(cell for row in (head, *rows) for cell in row)))
    if len(rows) < 2:  # on its side a long one says its heads again
        assert told == meant
    else:
        assert set(told) == set(meant)


def test_narrow_table_is_laid_out_in_columns():
    lines = list(table_lines(("gear", "peak [N·m]"), [("1", "5399"), ("R", "-3007")], 30))
    assert lines == ["gear  peak [N·m]", "1     5399", "R     -3007"]


def test_list_of_numbers_wraps_between_numbers():
    """An engine's speeds came as "1000, 1600, 2400, 2" and "800 rpm"."""
    rows = wrap_text("1000, 1600, 2400, 2800 rpm", 20)
    assert rows == ["1000, 1600, 2400,", "2800 rpm"]


def test_number_wraps_with_its_preceding_noun():
    (_, *lines) = table_lines(("what", "where"), [("x", "gear 1, mode 12: far away from here")], 24)
    assert not any(line.rstrip().endswith(("gear", "mode")) for line in lines)


def test_number_wraps_with_its_unit():
    said = "marcha 1 a 241 rpm, 3372 N·m, a ordem 2 encontra guinada a 8 Hz, mancal central 2"
    for width in range(30, 82):
        (_, *cells) = table_lines(("what", "where"), [("x", said)], width)
        for line in (*fold_lines([said], width), *cells):
            assert not re.match(r" *(Hz|N·m|rpm)", line), (width, line)


def test_long_row_name_fits_screen_width():
    name = "a circumstance of so many words that forty columns have no room for it"
    lines = list(table_lines(("", "", "", "x" * 11), [(name, "aa", "b" * 11, "")], 40))
    assert max(map(display_width, lines)) <= 40
