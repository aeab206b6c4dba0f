"""Drawings of a line: labels stand clear of parts, obstacles and each other; parts to one scale."""

import re
from functools import cache
from itertools import combinations
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from repository import ROOT

from cardan.application import reader
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.documents import line_drawing
from cardan.documents.approval_report import _rows_that_state_something
from cardan.documents.driveline_symbols import STEEL_COLOUR
from cardan.documents.line_drawing import line_drawings, side_or_top_view_drawing
from cardan.documents.yoke_phasing_drawing import yoke_phasing_drawing
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references
from cardan.render.chart import DataSeries, ReferenceLine, line_chart
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.label_placement import Box, text_box
from cardan.render.state_table import state_table_sections

SVG = "{http://www.w3.org/2000/svg}"
OBSTACLE_COLOUR = "#c08a5a"


@cache
def response(example: str, line: int = 0) -> LineResponse:
    application = reader.read(ROOT / f"examples/{example}.yaml")
    demand = line_state_demand(resolve_line_references(application, application.lines[line]))
    return compute_line_response(application, demand)


def text_boxes(svg: str) -> dict[str, Box]:
    """The texts of a drawing with where they stand."""
    found = {}
    for n, e in enumerate(ET.fromstring(svg).iter(f"{SVG}text")):
        size = float(e.attrib.get("font-size", 12))
        x, y = float(e.attrib["x"]), float(e.attrib["y"])
        found[f"{n} {e.text}"] = text_box(
            x, y, (e.text,), font_size=size, anchor=e.attrib["text-anchor"]
        )
    return found


def paths(svg: str, **wanted: str) -> list[np.ndarray]:
    """The corners of the paths of a drawing with such attributes."""
    return [
        np.array(re.findall(r"-?[\d.]+", e.attrib["d"]), float).reshape(-1, 2)
        for e in ET.fromstring(svg).iter(f"{SVG}path")
        if all(e.attrib.get(k.replace("_", "-")) == v for k, v in wanted.items())
    ]


def test_no_label_lies_on_obstacle():
    """The length of shaft 3 lay on the cross member in the top view."""
    drawn = side_or_top_view_drawing(response("refuse-collector-6x2"), ENGLISH, name="top").svg
    (bar,) = [e for e in ET.fromstring(drawn).iter(f"{SVG}path")
              if e.attrib["stroke"] == OBSTACLE_COLOUR]  # fmt: skip
    (corners,) = paths(drawn, stroke=OBSTACLE_COLOUR)
    half = float(bar.attrib["stroke-width"]) / 2
    beam = Box(corners[:, 0].min() - half, corners[:, 1].min() - half,
               corners[:, 0].max() + half, corners[:, 1].max() + half)  # fmt: skip
    labels = text_boxes(drawn)
    assert any("1351 mm" in said for said in labels)
    assert [said for said, box in labels.items() if box.overlap(beam) > 0] == []


@pytest.mark.parametrize("code", ["en", "pt"])
@pytest.mark.parametrize("example", ["refuse-collector-6x2", "tandem-6x4", "van"])
def test_labels_of_views_do_not_cover_each_other(example, code):
    for figure in line_drawings(response(example), Translator(code))[:-3]:
        pairs = combinations(text_boxes(figure.svg).items(), 2)
        assert [(a, b) for (a, p), (b, q) in pairs if p.overlap(q) > 2] == []  # px², a corner


def test_short_line_is_drawn_smaller_than_the_page():
    """A tube 120 mm thick and 642 mm long filled the page."""
    drawn = side_or_top_view_drawing(response("tandem-6x4", 1), ENGLISH, name="side").svg
    (tube,) = paths(drawn, fill=STEEL_COLOUR)
    assert (
        np.hypot(*(tube[3] - tube[0])) <= line_drawing.MAX_THICKNESS_PX + 0.02
    )  # hundredths of a pixel


def test_yokes_of_one_shaft_are_drawn_as_large_as_those_of_three():
    width = {
        name: float(ET.fromstring(yoke_phasing_drawing(response(name), ENGLISH).svg).get("width"))
        for name in ("van", "refuse-collector-6x2")
    }
    assert width["van"] == width["refuse-collector-6x2"]


def test_line_of_one_state_has_no_second_line_of_that_state():
    figure = side_or_top_view_drawing(response("three-joint-chain"), ENGLISH, name="side")
    assert "Light" not in figure.note
    assert "as given" not in figure.svg
    assert "Light" in side_or_top_view_drawing(response("van"), ENGLISH, name="side").note


def test_frame_ends_before_line_that_rises_through_it():
    """The chain climbs to the rear by more than its bearing hangs below the frame."""
    drawn = side_or_top_view_drawing(response("three-joint-chain"), ENGLISH, name="side").svg
    (frame,) = [e for e in ET.fromstring(drawn).iter(f"{SVG}line")
                if e.attrib.get("stroke-dasharray") == "14 4 2 4"]  # fmt: skip
    (axis,) = paths(drawn, stroke_dasharray="12 3 2 3")
    ends = [float(frame.attrib[k]) for k in ("x1", "x2")]
    height = np.interp(np.linspace(*ends, 50), axis[:, 0], axis[:, 1])
    assert (height > float(frame.attrib["y1"])).all()
    assert ends[1] < axis[-1, 0]


def test_names_of_close_levels_in_chart_stand_apart():
    """Three slip torques within 3 % of each other were written over each other."""
    levels = [ReferenceLine(value=v, name=f"tyres slip, state {v:g}") for v in (2320, 2360, 2380)]
    curve = DataSeries(name="gear 1", x=np.array([0.0, 5000]), y=np.array([1300.0, 1000]))
    figure = line_chart(
        ENGLISH, title="t", alt="t", series=[curve], levels=levels, zero=True,
        x_label="n", y_label="T",
    )  # fmt: skip
    boxes = [b for said, b in text_boxes(figure.svg).items() if "tyres slip" in said]
    assert len(boxes) == 3
    assert all(p.overlap(q) == 0 for p, q in combinations(boxes, 2))


def test_state_tables_of_reports_have_no_row_of_dashes():
    """A line without rubber has no dynamic force of its joints, its approximation alone."""
    rows = [
        (name, row)
        for section in state_table_sections(response("van"))
        for name, row in _rows_that_state_something(section.rows, ENGLISH)
    ]
    assert [name for name, row in rows if np.isnan(row.values).all()] == []
    names = [name for name, _ in rows]
    assert "Joint, dynamic force, joint 1 (rigid bearing, at its own torque)" in names
