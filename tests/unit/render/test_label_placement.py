"""Labels of drawings: the first free place, else the one that covers least, on the page."""

import numpy as np
import pytest

from cardan.render.label_placement import Box, LabelPlacer, bar_boxes, text_box

PAGE = Box(0, 0, 200, 100)


@pytest.mark.parametrize(
    ("taken", "chosen"),
    [
        ([], 0),
        ([Box(0, 40, 30, 60)], 1),  # lies on the first
        ([Box(0, 40, 30, 60), Box(60, 40, 65, 60)], 1),  # on both, on the second less
    ],
)
def test_label_takes_first_place_that_covers_least(taken, chosen):
    placer = LabelPlacer(PAGE, list(taken))
    places = [Box(10, 45, 30, 55), Box(60, 45, 80, 55)]
    assert placer.place(places) == chosen
    assert placer.taken[-1] == places[chosen]


def test_two_labels_do_not_take_one_place():
    placer = LabelPlacer(PAGE)
    places = [Box(10, 10, 40, 20), Box(10, 30, 40, 40)]
    assert [placer.place(places), placer.place(places)] == [0, 1]


def test_label_stays_on_page():
    placer = LabelPlacer(PAGE, [Box(0, 0, 150, 100)])
    assert placer.place([Box(180, 10, 220, 20), Box(160, 10, 190, 20)]) == 1


def test_slanted_bar_is_covered_and_its_corners_are_not():
    boxes = list(bar_boxes(np.array([0.0, 0.0]), np.array([100.0, 100.0]), 8.0))
    on, off = Box(49, 49, 51, 51), Box(80, 10, 90, 20)
    assert sum(b.overlap(on) for b in boxes) > 0
    assert sum(b.overlap(off) for b in boxes) == 0


def test_text_box_holds_its_lines_at_its_anchor():
    one = text_box(100, 50, ("1351 mm",), font_size=10, anchor="middle")
    two = text_box(100, 50, ("1351 mm", "x"), font_size=10, anchor="middle")
    assert (one.left + one.right) / 2 == 100
    assert one.top < 50 - 7  # capitals are 0.7 of the size high
    assert one.bottom > 50
    assert two.bottom == one.bottom + 12.5
    assert text_box(100, 50, ("ab",), font_size=10, anchor="end").right == 100
