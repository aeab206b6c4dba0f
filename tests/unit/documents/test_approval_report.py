"""Reports: the same story in three languages, whole and self-contained in every medium."""

import ast
import base64
import hashlib
import re
import shutil
import subprocess
from dataclasses import replace
from html.parser import HTMLParser
from io import BytesIO
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import openpyxl
import pytest
import yaml
from babel.messages.pofile import read_po
from case_selection import select
from click.testing import CliRunner
from repository import ROOT

from cardan.application import reader, templates
from cardan.approval.approval import approve_application, approve_driveline
from cardan.approval.driveline_study import DrivelineStudy
from cardan.approval.registry import studies_of_application
from cardan.checks.quantities.registry import QUANTITIES
from cardan.cli import cli
from cardan.core import optional_import as extra
from cardan.core.errors import DesignError, InvalidFileError, MissingDependencyError
from cardan.core.labels import EvaluationCondition, Part
from cardan.core.message import translatable_message
from cardan.core.units import deg, mm, rpm
from cardan.core.verdict import worst_verdict
from cardan.documents import approval_report as story
from cardan.documents import terminal
from cardan.documents.approval_sheet import approval_sheet
from cardan.documents.comparison import Variant, input_differences, limit_differences
from cardan.documents.criterion_explanation import explained_criteria, explanation_lines
from cardan.documents.driveline_symbols import CROSS_RADIUS_PX
from cardan.documents.inputs_table import input_rows
from cardan.documents.line_drawing import line_drawings, worst_state_index
from cardan.documents.line_plots import all_line_plots, motion_over_turn_plots
from cardan.documents.workbook import workbook_bytes
from cardan.model.adjustments import ADJUSTMENTS
from cardan.model.application import GearboxAndAxleRotors
from cardan.render.blocks import BulletList, Chapter, Figures, Picture, Table
from cardan.render.chart import Chart, axis_range, ticks
from cardan.render.html import html_page
from cardan.render.i18n import (
    ENGLISH,
    LANGUAGE_CODES,
    UNTRANSLATED_MESSAGES_SEEN,
    Translator,
    message_catalogue,
)
from cardan.render.pdf import _document_data, page_images, pdf_document
from cardan.render.phrases import approval_counts_text, limit_sense_symbol, verdict_text
from cardan.render.state_table import state_table_sections
from cardan.render.svg import VERDICT_COLOURS
from cardan.render.xlsx import column_letters
from cardan.topics.design.corrections import find_corrections
from cardan.topics.design.sensitivity import check_sensitivities
from cardan.topics.torsion.registration import VibrationStudy
from cardan.topics.torsion.study import analyse_vibration
from cardan.web.ui_texts import UI_TEXTS

UNRATED = re.sub(r"  joints:.*\n", "", templates.template_text("small"))
"""The small starter without joints, whose ratings are limits of their own."""
SOURCES = [
    *(ROOT / "src/cardan/render").glob("*.py"),
    *(ROOT / "src/cardan/documents").glob("*.py"),
    *(ROOT / "src/cardan/topics").rglob("*.py"),
    *(ROOT / "src/cardan/cli").glob("*.py"),
]
EXAMPLES = sorted((ROOT / "examples").glob("*.yaml"))
TOLD = "refuse-collector-6x2", "van"
"""Examples that have between them most of what a report tells."""
ISSUE = story.ReportDateAndSourceStamp(
    date="2026-11-20", file_names=("a.yaml",), fingerprints=("0" * 16,), file_texts=("title: a",)
)


@pytest.fixture(scope="module")
def truck():
    return approve_driveline(reader.loads(templates.template_text("truck")))


def with_vibration(application, surroundings=None):
    return approve_application(application, (DrivelineStudy(), VibrationStudy(surroundings)))


@pytest.fixture(scope="module")
def told(truck):
    """The starter's story by language."""
    helps = check_sensitivities(truck)
    fixes = find_corrections(truck.application, count=2, hold=["phase"])
    shaken = with_vibration(truck.application)
    return {
        code: story.approval_report_from_results(
            shaken, helps=helps, fixes=fixes, say=Translator(code), issue=ISSUE
        )
        for code in LANGUAGE_CODES
    }


def said_in(source: Path):
    """Every text that a module says, where it is written out at the call."""
    for node in ast.walk(ast.parse(source.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.Call) or not node.args:
            continue
        counts = ast.unparse(node.func) in ("say.count", "self.say.count")
        if getattr(node.func, "id", "") == "say" or counts:
            text = node.args[0]
            if isinstance(text, ast.Constant):
                yield text.value


@pytest.mark.slow
def test_every_text_is_translated():
    said = {text for source in SOURCES for text in said_in(source)}
    assert len(said) > 200
    said |= (
        {w for m in ADJUSTMENTS.values() for w in (m.label, m.increase_text, m.decrease_text)}
        | set(studies_of_application())
        | set(UI_TEXTS)
    )
    for code in LANGUAGE_CODES[1:]:
        assert sorted(said - {text for _, text in message_catalogue(code)}) == []


def test_translation_catalogue_is_readable_by_babel():
    """Babel reads the same texts from a .po file as the reports do."""
    for code in LANGUAGE_CODES[1:]:
        path = ROOT / "src/cardan/render/locales" / f"{code}.po"
        with path.open("rb") as file:
            theirs = {
                (m.context or "", m.id[0] if m.pluralizable else m.id):
                    "\0".join(m.string) if m.pluralizable else m.string
                for m in read_po(file) if m.id and m.string
            }  # fmt: skip
        ours = {key: text for key, text in message_catalogue(code).items() if key[1]}
        assert ours == theirs


def test_every_quantity_has_a_name_in_every_language():
    for code in LANGUAGE_CODES:
        names = [Translator(code).name(key) for key in QUANTITIES]
        assert all(names)


def test_every_quantity_is_explained_in_every_language():
    """What has no words, like Ts = μ N re / (iD ηD), needs no translation."""
    names = {
        "atan",
        "cos",
        "max",
        "min",
        "det",
        "abs",
        "LGT",
        "TLGR",
        "TCR",
        "WST",
        "Tcs",
        "Tdw",
        "Tds",
    }
    for q in QUANTITIES.values():
        for text in (q.equation_text, *q.symbol_meanings.values(), q.validity):
            words = set(re.findall(r"[A-Za-z]{3,}", text)) - names
            for code in LANGUAGE_CODES[1:]:
                assert not words or ("", text) in message_catalogue(code), f"{q.key}: {text}"


def test_translations_keep_placeholders():
    for code in LANGUAGE_CODES[1:]:
        for (_, english), other in message_catalogue(code).items():
            assert other.strip()
            assert set(re.findall(r"{(\w+)}", other)) == set(re.findall(r"{(\w+)}", english))


@pytest.mark.slow
@pytest.mark.parametrize("path", select(EXAMPLES, *TOLD, ids=lambda p: p.stem))
def test_every_example_report_is_fully_translated(path):
    """A text composed at run time and missing in the catalogue is found here."""
    found = with_vibration(reader.read(path))
    helps = check_sensitivities(found)
    for say in map(Translator, ("pt", "it")):
        UNTRANSLATED_MESSAGES_SEEN.clear()
        whole = story.approval_report_from_results(
            found, helps=helps, fixes=(), say=say, issue=ISSUE
        )
        shown = html_page(whole)
        assert len(shown) > 50_000
        assert not any(
            f" {w} " in shown[: shown.index("<pre")] for w in ("gear", "mode", "zone of")
        )
        screen = list(terminal.approval_lines(found, helps=helps, states=True, say=say))
        lines = list(terminal.approval_lines(found, helps=helps, every=True, say=say))
        why = list(explanation_lines(explained_criteria(found), found, helps=helps, say=say))
        assert min(map(len, (screen, lines, why))) > 60
        assert sorted(UNTRANSLATED_MESSAGES_SEEN) == []
        # Publications keep the language they are written in.
        ours = [line for line in (*screen, *lines) if not line.startswith("  [")]
        assert not any(f" {w} " in line for line in ours for w in ("joint", "shaft", "against"))


def test_unknown_language_is_rejected():
    with pytest.raises(ValueError, match="there are: en, it, pt"):
        Translator("la")


@pytest.mark.parametrize(
    ("code", "shown"), [("en", "0.03116"), ("pt", "0,03116"), ("it", "0,03116")]
)
def test_decimal_sign_follows_language(code, shown):
    assert Translator(code).number(0.0311591) == shown


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (0, "0"),
        (np.nan, "-"),
        (np.inf, "∞"),
        (-np.inf, "-∞"),
        (12345.6, "12346"),
        (8.41e-5, "8.410e-05"),
        (5.8e-8, "5.800e-08"),
        (1e-13, "0"),
    ],
)
def test_numbers_are_formatted_in_engineering_notation(value, shown):
    assert ENGLISH.number(value) == shown


def test_part_names_are_translated():
    assert Translator("pt").part(Part("centre bearing", 2)) == "mancal central 2"
    assert Translator("it").part(Part("clearance", 1, "tank")) == "albero 1 da tank"
    # What the user calls a thing is its name, whatever else the word may mean.
    assert Translator("it").part(Part("clearance", 1, "pass")) == "albero 1 da pass"
    assert Translator("it").occasion(EvaluationCondition("state", "fail")) == "fail"
    assert Translator("it").occasion(EvaluationCondition("state", "jounce")) != "jounce"


class Reader(HTMLParser):
    """Collects what a page is made of, and checks that its elements nest."""

    VOID = frozenset({"meta", "br", "link", "img", "input", "hr"})

    def __init__(self):
        super().__init__()
        self.open, self.tags, self.attrs = [], [], []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attrs += attrs
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.append(tag)
        self.attrs += attrs

    def handle_endtag(self, tag):
        if tag not in self.VOID:
            assert self.open.pop() == tag


def read(text: str) -> Reader:
    reader = Reader()
    reader.feed(text)
    assert reader.open == []
    return reader


@pytest.mark.slow
@pytest.mark.parametrize("code", LANGUAGE_CODES)
def test_page_is_self_contained(told, code):
    text = html_page(told[code])
    reader = read(text)
    assert not {"script", "link", "img", "iframe", "object"} & set(reader.tags)
    links = [v for k, v in reader.attrs if k in ("src", "href", "xlink:href", "action")]
    assert links
    assert all(v.startswith("#") for v in links)
    assert "url(" not in text
    assert "@import" not in text
    assert len(text.encode()) < 2_000_000
    assert dict(reader.attrs)["lang"] == {"pt": "pt-BR"}.get(code, code)


@pytest.mark.slow
def test_page_anchors_are_unique(told):
    ids = [v for k, v in read(html_page(told["en"])).attrs if k == "id"]
    assert len(ids) == len(set(ids))


@pytest.mark.slow
def test_page_shows_verdict_first(told, truck):
    text = html_page(told["en"])
    body = text[text.index("<body>") :]
    verdict = verdict_text(truck, ENGLISH)
    assert body.index(verdict) < body.index("What to change") < body.index("Revisions")


def test_page_escapes_text_of_application_file():
    text = UNRATED.replace("Two-piece driveline", "<script>alert(1)</script>")
    found = approve_driveline(reader.loads(text))
    shown = html_page(
        story.approval_report_from_results(
            found, helps=(), fixes=(), say=ENGLISH, issue=story.ReportDateAndSourceStamp()
        )
    )
    assert "<script>" not in shown
    assert "&lt;script&gt;alert(1)" in shown


@pytest.mark.slow
def test_every_figure_is_valid_svg_with_alt_text(told):
    figures = list(story.all_figures(told["en"]))
    assert len(figures) > 12
    for figure in figures:
        root = ET.fromstring(figure.svg)
        assert root.attrib["aria-label"] == figure.alt
        assert len(figure.alt) > 20
        assert "nan" not in figure.svg


@pytest.mark.slow
def test_table_rows_match_header_length(told):
    for chapter in told["it"].chapters:
        for block in chapter.blocks:
            if isinstance(block, Table):
                assert {len(row) for row in block.rows} == {len(block.head)}
                assert {len(row) for row in block.grades} <= {len(block.head)}


@pytest.mark.slow
def test_pdf_is_archivable_and_reproducible(told):
    data = pdf_document(told["pt"])
    assert data.startswith(b"%PDF-")
    assert b"<pdfaid:part>3</pdfaid:part>" in data
    assert b"<pdfaid:conformance>A</pdfaid:conformance>" in data
    assert len(data) < 2_000_000
    assert b"/Suspects" not in data  # poppler takes a false one for a mistake
    assert data == pdf_document(told["pt"])  # the same story, the same document


def test_missing_library_error_names_install_command():
    with pytest.raises(MissingDependencyError, match=r"pip install 'cardan\[report\]'"):
        extra.import_optional("no_such_library_at_all")


def test_variant_comparison_lists_changed_inputs_and_effects():
    text = UNRATED.replace("limits: body-builder", "limits: heavy-truck")
    other = text.replace("torque_Nm: 8000", "torque_Nm: 4000")
    assert other != text
    variants = [Variant(name=n, approval=approve_driveline(reader.loads(t)))
                for n, t in (("a", text), ("b", other))]  # fmt: skip
    (row,) = input_differences(variants, ENGLISH)
    assert row.values == ("8000 N·m", "4000 N·m")
    forces = [
        r
        for r in limit_differences(variants, ENGLISH)
        if r.name.startswith("Centre bearing, static")
    ]
    first, second = (float(v.split()[0]) for v in forces[0].values)
    assert first == pytest.approx(2 * second, rel=1e-3)  # four figures are printed
    assert read(
        html_page(
            story.comparison_report(variants, say=ENGLISH, issue=story.ReportDateAndSourceStamp())
        )
    )


def test_verdict_of_variants_is_the_worst():
    """One that passes and one that fails: whoever reads the head of the page alone knows."""
    text = UNRATED.replace("limits: body-builder", "limits: [LIMIT]")
    limit = "{quantity: joint_angle, maximum: %s, unit: deg, source: us}"
    variants = [
        Variant(
            name=name, approval=approve_driveline(reader.loads(text.replace("LIMIT", limit % most)))
        )
        for name, most in (("good", 40), ("bad", 0.01))
    ]
    assert [v.approval.verdict for v in variants] == ["pass", "fail"]
    for some in (variants, variants[::-1]):
        assert (
            story.comparison_report(some, say=ENGLISH, issue=story.ReportDateAndSourceStamp()).grade
            == "fail"
        )
    (row,) = limit_differences(variants, ENGLISH)
    worst = max(c.value for c in variants[1].approval.checks)
    assert row.values[1].startswith(f"{ENGLISH.number(worst / deg)} (")
    assert (row.grades, row.grades_differ) == (("pass", "fail"), True)


def test_inputs_are_listed_in_their_stated_units():
    """As the starter's file gives them, read by eye."""
    rows = {
        (i.group, i.name): i.value
        for i in input_rows(reader.loads(templates.template_text("truck")), ENGLISH)
    }
    text = templates.template_text("truck")
    given = dict(re.findall(r"(\w+?): ([\d.]+)", text))
    stiffness = given["windup_stiffness_kNm_deg"]
    assert rows["Suspension", "wind-up stiffness"] == f"{stiffness} kN·m/deg"
    half = float(given["front_half_length_mm"])
    assert rows["Suspension", "equivalent link radius"] == f"{0.75 * half:g} mm"
    assert rows["Vehicle", "wheelbase"] == f"{given['wheelbase_mm']} mm"


def test_workbook_columns_continue_after_z():
    """As spreadsheets letter them: 26 is AA, 27 AB, 51 AZ, 52 BA, 701 ZZ, 702 AAA."""
    lettered = {0: "A", 25: "Z", 26: "AA", 27: "AB", 51: "AZ", 52: "BA", 701: "ZZ", 702: "AAA"}
    assert {k: column_letters(k) for k in lettered} == lettered


def test_side_view_is_to_scale():
    """Pixels between neighbouring joints are as their distances along the line."""
    found = approve_driveline(reader.loads(templates.template_text("truck")))
    r = found.line_responses[0]
    figure = line_drawings(r, ENGLISH)[0]
    joints = [
        (float(c.attrib["cx"]), float(c.attrib["cy"]))
        for c in ET.fromstring(figure.svg).iter("{http://www.w3.org/2000/svg}circle")
        if c.attrib["r"] == f"{CROSS_RADIUS_PX:g}"
    ]
    points = r.demand.installed.layout.points
    pixels, metres = np.diff(np.array(joints), axis=0), np.diff(points, axis=0)
    scale = pixels[:, 0] / metres[:, 0]
    times = int(re.search(r"exaggerated (\d+) times", figure.title)[1])
    assert scale[0] == pytest.approx(scale[1], rel=1e-3)  # pixels are written to a hundredth
    np.testing.assert_allclose(-pixels[:, 1] / metres[:, 2], times * scale, rtol=5e-3)


def _polygons(drawing: str) -> list[np.ndarray]:
    paths = ET.fromstring(drawing).iter("{http://www.w3.org/2000/svg}path")
    closed = (p.attrib["d"] for p in paths if p.attrib["d"].endswith("Z"))
    return [np.array(re.findall(r"-?[\d.]+", d), float).reshape(-1, 2) for d in closed]


def test_tube_is_drawn_as_thick_as_it_is_whatever_is_exaggerated():
    """A tube 100 mm thick and its length have one scale, where offsets are drawn ten times."""
    found = approve_driveline(reader.loads(templates.template_text("truck")))
    r = found.line_responses[0]
    figure = line_drawings(r, ENGLISH)[0]
    times = int(re.search(r"exaggerated (\d+) times", figure.title)[1])
    assert times > 1
    joints = [
        float(c.attrib["cx"])
        for c in ET.fromstring(figure.svg).iter("{http://www.w3.org/2000/svg}circle")
        if c.attrib["r"] == f"{CROSS_RADIUS_PX:g}"
    ]
    scale = np.ptp(joints) / np.ptp(r.demand.installed.layout.points[:, 0])
    thick = [float(np.hypot(*(p[3] - p[0]))) for p in _polygons(figure.svg) if len(p) == 4]
    for shaft in r.line.shafts:
        wide = shaft.tube.outer * scale
        assert any(abs(t - wide) < 0.03 for t in thick), (wide, thick)  # hundredths of a pixel


@pytest.mark.parametrize(("phase", "drawn_alike"), [(0, True), (90, False)])
def test_yoke_phase_is_seen_in_side_view(phase, drawn_alike):
    """Aligned yokes of a shaft are both forks or both ears; crossed ones are one of each."""
    text = templates.template_text("truck").replace("phase_deg: 0 ", f"phase_deg: {phase} ")
    assert text.count(f"phase_deg: {phase} ") == 1
    r = approve_driveline(reader.loads(text)).line_responses[0]
    drawing = line_drawings(r, ENGLISH)[0].svg
    # Along the line: gearbox yoke, then front and rear yoke of each shaft; forks have 11 corners.
    yokes = [p for p in _polygons(drawing) if len(p) in (6, 11)]
    forks = [len(p) == 11 for p in yokes]
    assert forks[0]
    assert (forks[1] == forks[2]) == drawn_alike


def test_straight_line_has_no_top_view():
    found = approve_driveline(reader.read(ROOT / "examples/van.yaml"))
    titles = [f.title for f in line_drawings(found.line_responses[0], ENGLISH)]
    assert not any("Plan view" in t for t in titles)


def test_suspension_travel_curve_passes_through_states(truck):
    """States that the suspension places without winding the axle up lie on the curve."""
    from cardan.documents.line_plots import _line_over_travel

    r = truck.line_responses[0]
    places, ridden = _line_over_travel(r)
    for s, name in enumerate(r.demand.states):
        if name in ("full rebound", "empty", "gvw", "jounce"):
            curve = np.interp(r.demand.travel[s] / mm, places, ridden.layout.side[:, -1] / deg)
            # Straight between 41 places; the slope bends by microdegrees over one of them.
            assert curve == pytest.approx(r.layout.side[s, -1] / deg, abs=1e-3)


def test_plots_contain_every_expected_chart(truck):
    titles = [f.title for f in all_line_plots(truck.line_responses[0], ENGLISH)]
    assert len(titles) == len(set(titles))
    for word in ("Speed round", "over the travel", "by order", "by gear", "Critical", "Spring"):
        assert any(word in t for t in titles)


@pytest.mark.parametrize(("low", "high"), [(0, 1), (-3.2, 7.9), (1e-5, 3e-5), (0, 12146)])
def test_axis_ticks_are_round_and_within_range(low, high):
    found = ticks(low, high)
    assert 3 <= len(found) <= 9
    assert low - 1e-9 * (high - low) <= found[0]
    assert found[-1] <= high + 1e-9 * (high - low)
    assert set(np.round(np.diff(found) / np.diff(found)[0], 6)) == {1}


def test_equal_axes_have_equal_scale():
    chart = Chart(say=ENGLISH, x=axis_range(np.array([0, 1.0])), y=axis_range(np.array([0, 9.0])),
                  x_label="", y_label="", equal_aspect=True)  # fmt: skip
    (x0, y0), (x1, y1) = chart.point_to_pixels(0, 0), chart.point_to_pixels(1, 1)
    assert x1 - x0 == pytest.approx(y0 - y1)


@pytest.mark.slow
def test_result_cells_are_graded_like_their_checks():
    """Every state of a line in which a clearance fails is marked in the obstacle's row."""
    path = next(p for p in EXAMPLES if p.stem == "refuse-collector-6x2")
    found = approve_driveline(reader.read(path))
    whole = story.approval_report_from_results(
        found, helps=(), fixes=(), say=ENGLISH, issue=story.ReportDateAndSourceStamp()
    )
    rows = {
        row[0]: dict(zip(block.head, grades, strict=True))
        for chapter in whole.chapters
        for block in chapter.blocks
        if isinstance(block, Table) and block.head[0] == "quantity" and block.grades
        for row, grades in zip(block.rows, block.grades, strict=True)
    }
    bad = {
        ENGLISH.state(c.state): c.grade
        for c in found.checks
        if c.quantity == "clearance" and c.grade != "pass"
    }
    assert bad
    shown = rows["Clearance, auxiliary beam"]
    assert {s: g for s, g in shown.items() if g} == bad


def test_plot_over_one_turn_matches_stated_units(truck):
    """The pinion swings as far to either side as the check says; points miss a crest by 0.1 %."""
    (response,) = truck.line_responses
    s = worst_state_index(response)
    speed, acceleration = motion_over_turn_plots(response, ENGLISH)
    rpms, rates = (float(f.alt.split()[-1]) for f in (speed, acceleration))
    whole = response.kinematics.excitation
    assert rates == pytest.approx(2 * whole.torsional.acceleration[s], rel=2e-3)
    turning = response.demand.speed[s] / rpm
    assert rpms == pytest.approx(whole.irregularity[s] * turning, rel=2e-3)


@pytest.mark.parametrize("bounds", [("normal", "maximum"), ("maximum", "normal")])
def test_result_cell_colour_is_that_of_worst_check(bounds):
    """Two limits on one angle: one warns, the other fails."""
    first, second = (f"{{quantity: joint_angle, {b}: 0.001, source: us}}" for b in bounds)
    limits = f"limits: [{first}, {second}]"
    found = approve_driveline(reader.loads(UNRATED.replace("limits: body-builder", limits)))
    assert {c.grade for c in found.checks} == {"warn", "fail"}
    whole = story.approval_report_from_results(
        found, helps=(), fixes=(), say=ENGLISH, issue=story.ReportDateAndSourceStamp()
    )
    cells = {
        grade
        for block in chapter(whole, "Results by state").blocks
        if isinstance(block, Table)
        for row in block.grades
        for grade in row
    }
    assert cells == {"", "fail"}


@pytest.mark.slow
def test_result_cell_colour_is_per_line_and_not_for_approximations():
    """Both lines of a tandem have a joint 1; what AE-7 says of a line nothing is held against."""
    text = yaml.safe_load((ROOT / "examples" / "tandem-6x4.yaml").read_text(encoding="utf-8"))
    lines = approve_driveline(reader.loads(yaml.safe_dump(text))).line_responses
    between = float(np.mean([r.joint_angles[:, 0].max() for r in lines])) / deg
    rows = [{"quantity": "joint_angle", "maximum": between, "source": "us"},
            {"quantity": "torsional_acceleration", "maximum": 1e-3, "source": "us"}]  # fmt: skip
    found = approve_driveline(reader.loads(yaml.safe_dump(text | {"limits": rows})))
    whole = story.approval_report_from_results(
        found, helps=(), fixes=(), say=ENGLISH, issue=story.ReportDateAndSourceStamp()
    )
    failed = {(c.line, c.quantity, c.part, c.state) for c in found.checks if c.grade == "fail"}
    first = [line for line, quantity, part, _ in failed
             if (quantity, part) == ("joint_angle", Part("joint", 1))]  # fmt: skip
    assert len(set(first)) == 1
    plain = 0
    for r in found.line_responses:
        tables = [
            b
            for b in chapter(whole, f"Results by state: {r.line.name}").blocks
            if isinstance(b, Table)
        ]
        for section, table in zip(state_table_sections(r), tables, strict=True):
            shown = [row for row in section.rows if row.method or not np.isnan(row.values).all()]
            for row, grades in zip(shown, table.grades, strict=True):
                held = [
                    not row.method and (r.line.name, row.quantity, row.part, state) in failed
                    for state in r.demand.states
                ]
                assert [g == "fail" for g in grades[2:]] == held, row
                plain += bool(row.method) and row.quantity == "torsional_acceleration"
    assert plain > 2


def test_limit_reference_number_matches_source_list():
    """[1] in the table of limits is [1] in the list below it."""
    rows = [{"quantity": q, "maximum": 45, "source": f"what {q} says"}
            for q in ("joint_angle", "compound_angle", "torsional_acceleration")]  # fmt: skip
    text = yaml.safe_load(UNRATED) | {"limits": rows}
    found = approve_driveline(reader.loads(yaml.safe_dump(text)))
    table, listed, *_ = story.verdict_report_blocks(found, ENGLISH)
    said = dict(point.split(" ", 1) for point, _ in listed.points)
    by_name = {ENGLISH.name(row["quantity"]): row["source"] for row in rows}
    assert {row[1]: said[row[-1]] for row in table.rows} == by_name
    assert list(said) == ["[1]", "[2]", "[3]"]


@pytest.mark.parametrize("quantity", ["joint_angle", "joint_angle_min", "odd_joint_angle"])
def test_angle_cell_is_coloured_by_every_limit_on_the_angle(quantity):
    """Too large, too small, or too large for the one that stands alone: one row shows them all."""
    bound = 85 if quantity == "joint_angle_min" else 0.001
    limits = f"limits: [{{quantity: {quantity}, maximum: {bound}, source: us}}]"
    found = approve_driveline(reader.loads(UNRATED.replace("limits: body-builder", limits)))
    bad = {str(c.part) for c in found.checks if c.grade == "fail"}
    assert bad
    whole = story.approval_report_from_results(
        found, helps=(), fixes=(), say=ENGLISH, issue=story.ReportDateAndSourceStamp()
    )
    shown = {
        row[0].removeprefix("Joint angle, "): grades[2]
        for block in chapter(whole, "Results by state").blocks
        if isinstance(block, Table)
        for row, grades in zip(block.rows, block.grades, strict=True)
        if row[0].startswith("Joint angle, ")
    }
    assert {joint for joint, grade in shown.items() if grade == "fail"} == bad


def test_workbook_shows_smallest_clearance_per_obstacle():
    """One row for an obstacle: the smallest of its clearances in each state, as it stands."""
    path = next(p for p in EXAMPLES if p.stem == "refuse-collector-6x2")
    asked = reader.read(path)
    found = approve_driveline(
        replace(asked, limits=tuple(replace(k, points="own") for k in asked.limits))
    )
    (response,) = found.line_responses
    shown = [
        row for s in state_table_sections(response) for row in s.rows if row.quantity == "clearance"
    ]
    assert len(shown) == len(response.inputs.obstacles)
    for row in shown:
        for state, value in zip(response.demand.states, row.values, strict=True):
            each = [
                c.value for c in found.checks
                if (c.quantity, c.state, c.part.other) == ("clearance", state, row.part.other)
            ]  # fmt: skip
            assert len(each) == response.line.joint_count - 1
            assert value == pytest.approx(min(each) / mm)
            assert min(each) < max(each)


def test_every_medium_shows_direction_of_limit():
    """A lower limit is ≥, an upper one ≤, a band is to be kept out of."""
    text = UNRATED.replace("limits: body-builder", "limits: [LIMITS]")
    limits = "{quantity: joint_angle_min, maximum: 0.1, source: us}, " \
             "{quantity: joint_angle, maximum: 40, source: us}, " \
             "{quantity: half_critical_band, band: [0.42, 0.58], source: us}"  # fmt: skip
    found = approve_driveline(reader.loads(text.replace("LIMITS", limits)))
    assert {c.quantity: limit_sense_symbol(c, ENGLISH) for c in found.checks} == {
        "joint_angle_min": "≥", "joint_angle": "≤", "half_critical_band": "outside",
    }  # fmt: skip
    printed = "\n".join(terminal.approval_lines(found, helps=(), every=True, say=ENGLISH))
    assert re.search(r"Smallest joint angle .* >= +0\.1000", printed)
    assert re.search(r"Joint angle .* <= +40\.00", printed)
    screen = "\n".join(terminal.approval_lines(found, helps=(), say=ENGLISH))
    for row in (r"smallest joint angle.* min 0\.1 deg ", r"joint angle.* max 40 deg ",
                r"speed near half critical.* outside 0\.42 to 0\.58 "):  # fmt: skip
        assert re.search(row, screen)


def test_checks_not_evaluated_are_counted_if_required_or_not():
    text = UNRATED.replace("limits: body-builder", "limits: [LIMITS]")
    limits = "{quantity: joint_angle, maximum: 40, source: us}, " \
             "{quantity: joint_life, maximum: 5000, source: us}"  # fmt: skip
    found = approve_driveline(reader.loads(text.replace("LIMITS", limits)))
    assert found.verdict == "pass"
    assert approval_counts_text(found, ENGLISH) == (
        "0 exceeded, 0 beyond recommended, 3 met, 3 not evaluated"
    )


# One white pixel.
PIXEL = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4//8/AAX+Av4N70a4AAAAAElFTkSuQmCC"
)


@pytest.mark.slow
def test_page_allows_only_the_script_of_its_picture(told):
    """The policy holds the hash a browser computes: SHA-256 of what stands in the script."""
    script = "console.log(1)"
    scene = f'<div class="here"><script>{script}</script></div>'
    picture = Picture(title="A", png=PIXEL, alt="One white pixel.", scene=scene)
    plain = told["en"]
    whole = replace(plain, chapters=(*plain.chapters, Chapter(title="B", blocks=(picture,))))
    text = html_page(whole)
    allowed = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert f"script-src 'sha256-{allowed}'\"" in text
    assert scene in text
    assert 'alt="One white pixel."' in text
    assert "script-src" not in html_page(plain)
    data = pdf_document(whole)
    assert len(re.findall(rb"/Subtype ?/Image", data)) > len(
        re.findall(rb"/Subtype ?/Image", pdf_document(plain))
    )


@pytest.mark.slow
def test_tall_picture_is_scaled_to_one_page():
    """The lower half of a bracket's damage was cut off at the foot of its page."""
    plt = pytest.importorskip("matplotlib.image")
    tall = np.zeros((900, 300, 3))
    tall[:20, :, 0] = tall[-20:, :, 2] = 1.0  # red above, blue below
    drawn = BytesIO()
    plt.imsave(drawn, tall, format="png")
    picture = Picture(title="A", png=drawn.getvalue(), alt="A tall one.", scene="")
    found = approve_application(limited(FLAT))
    plain = story.approval_report_from_results(found, helps=(), fixes=(), say=ENGLISH, issue=ISSUE)
    whole = replace(plain, chapters=(Chapter(title="B", blocks=(picture,)),))
    shown = [plt.imread(BytesIO(png))[..., :3] for png in page_images(whole, ppi=40)]
    ends = [[(np.abs(one - of).max(-1) < 0.2).any() for of in np.eye(3)[[0, 2]]] for one in shown]
    assert [True, True] in ends


def chapter(whole: story.ReportDocument, title: str) -> Chapter:
    return next(c for c in whole.chapters if c.title == title)


@pytest.mark.slow
def test_vibration_chapter_matches_stability_command(truck):
    """A gear that runs through a resonance stands at 0 %, coloured as the command grades it."""
    approval = with_vibration(truck.application, GearboxAndAxleRotors(axle_inertia=3.0))
    found = approval.answer_of("vibration")
    whole = story.approval_report_from_results(
        approval, helps=(), fixes=(), say=ENGLISH, issue=story.ReportDateAndSourceStamp()
    )
    said, distances, limits, *tables, modes, drawn = chapter(
        whole, "Vibration and stability"
    ).blocks
    assert said.paragraphs[0].startswith("Vibration: APPROVED WITH WARNINGS")
    assert said.paragraphs[1] == "Given in place of parts: axle 3.000 kg m²."
    assert said.paragraphs[2].startswith("Assumed: ")
    names = [r[0] for r in distances.rows]
    at = names.index("mode 2, order 2")
    row = dict(zip(distances.head, distances.rows[at], strict=True))
    grade = dict(zip(distances.head, distances.grades[at], strict=True))
    met = found.closed.frequencies[..., 1] / 2
    low, high = np.moveaxis(found.closed.ranges, -1, 0)
    for g, gear in enumerate(found.gears):
        through = ((low[g] <= met[g]) & (met[g] <= high[g])).any()
        assert (row[str(gear)] == "0 %") == through
        if through:
            assert grade[str(gear)] == "warn"
    assert len(tables) == 5  # modes, amplitudes, zones, launches, assumptions
    assert {r[1] for r in limits.rows} >= {"Growth of torsional vibration", "Reversal in a launch"}
    assert "mode 1, " in modes.figures[0].svg
    assert any("start from rest" in f.title for f in drawn.figures)


@pytest.mark.slow
def test_unstable_vibration_fails_in_chapter_and_headline(truck):
    """Next to undamped, its tyres too: zones open, and their triangles are red."""
    app = truck.application
    loose = replace(app, tyre=replace(app.tyre, slip_stiffness=9e8))
    found = with_vibration(loose, GearboxAndAxleRotors(damping_ratio=1e-4))
    whole = story.approval_report_from_results(
        found, helps=(), fixes=(), say=ENGLISH, issue=story.ReportDateAndSourceStamp()
    )
    assert whole.grade == "fail"  # the headline is never better than a chapter
    said, _, limits, *_, modes, _ = chapter(whole, "Vibration and stability").blocks
    assert said.paragraphs[0].startswith("Vibration: NOT APPROVED")
    assert limits.grades[0][0] == "fail"
    assert limits.rows[0][1] in {"Growth of torsional vibration", "Vibratory torque / endurance"}
    assert any(VERDICT_COLOURS["fail"] in f.svg for f in modes.figures)


def test_vibration_without_tubes_is_reported_as_not_evaluated(tmp_path):
    """Without tubes nobody knows how stiff it is; the page is written all the same."""
    file, out = tmp_path / "bare.yaml", tmp_path / "bare.html"
    text = re.sub(r"(?m)^ *tube:.*\n", "", UNRATED)
    file.write_text(text, encoding="utf-8")
    run = CliRunner().invoke(cli, ["check", str(file), "--with", "vibration", "--html", str(out)])
    assert run.exit_code in (0, 1), run.output
    assert "vibration could not be evaluated: the tube of each shaft" in out.read_text("utf-8")


@pytest.mark.parametrize("key", ["speed_rpm", "torque_Nm"])
def test_vibration_needs_a_speed_and_a_torque(key):
    text = re.sub(rf"(?m)^{key}:.*\n", "", UNRATED)
    with pytest.raises(DesignError, match="needs a speed and a torque"):
        analyse_vibration(reader.loads(text))


def test_torsion_inputs_are_listed():
    text = UNRATED + "torsion: {axle_inertia_kgm2: 3, damping_ratio: 0.03}\n"
    rows = {
        i.name: i.value for i in input_rows(reader.loads(text), ENGLISH) if i.group == "Torsion"
    }
    assert rows == {"axle inertia": "3 kg·m²", "damping ratio of the first mode": "0.03"}


@pytest.mark.long
@pytest.mark.parametrize("key", ["speed_rpm", "torque_Nm"])
def test_report_is_written_without_speed_or_torque(key, tmp_path):
    """A page of it crashed once: the worst state was looked for among unknown numbers."""
    file, out = tmp_path / "some.yaml", tmp_path / "some.html"
    file.write_text(re.sub(rf"(?m)^{key}:.*\n", "", UNRATED), encoding="utf-8")
    run = CliRunner().invoke(cli, ["check", str(file), "--html", str(out), "-q"])
    assert run.exit_code in (0, 1), run.output
    assert out.exists()


# --------------------------------------------------------------------------- what to change


def what_to_change(found, code="en"):
    """All that a report says under that heading, without corrections."""
    told = story.approval_report_from_results(
        found, helps=check_sensitivities(found), fixes=(), say=Translator(code), issue=ISSUE
    )
    (chapter,) = [c for c in told.chapters if c.title == Translator(code)("What to change")]
    for block in chapter.blocks:
        yield from getattr(block, "paragraphs", ())
        for point, more in getattr(block, "points", ()):
            yield from (point, *more)


def limited(*rows, profile="protractor", **more):
    """The truck starter under other limits."""
    text = yaml.safe_load(templates.template_text("truck")) | more
    return reader.loads(yaml.safe_dump(text | {"limits": list(rows) or profile}))


FLAT = {"quantity": "joint_angle", "maximum": 45, "source": "made up"}
GROWS = {"quantity": "torsional_growth", "unit": "1/s", "maximum": -100, "source": "made up"}
LIVES = {"quantity": "fatigue_life", "unit": "h", "maximum": 5000, "source": "made up"}


@pytest.mark.slow
def test_report_declares_all_passed_only_if_all_are_evaluated():
    assert list(what_to_change(approve_application(limited(FLAT)))) == [
        "Everything passes; nothing needs to change."
    ]
    assert list(what_to_change(approve_application(limited(FLAT, LIVES)))) == [
        "What has an answer passes; nothing needs to change."
    ]


@pytest.mark.slow
def test_report_names_failing_study_without_correction():
    """It said "Everything passes; nothing needs to change." under a headline that said FAIL."""
    found = with_vibration(limited(FLAT, GROWS))
    assert found.verdict == "fail"
    (said,) = what_to_change(found)
    assert re.fullmatch(
        r"exceeded \(vibration\): Growth of torsional vibration, zone of .*: "
        r"−\S+ against −100.0 1/s",
        said,
    )
    assert next(what_to_change(found, "pt")).startswith("excedido (vibração): ")
    # Its first page has it among the criteria that are not met.
    told = story.approval_report_from_results(found, helps=(), fixes=(), say=ENGLISH, issue=ISSUE)
    first, *_ = told.chapters[0].blocks[0].rows
    assert first[0] == "exceeded"
    assert first[1].startswith("Growth of torsional vibration")


def test_report_names_required_checks_not_evaluated():
    found = approve_application(limited(FLAT, LIVES | {"required": True}))
    assert found.verdict == "incomplete"
    (said,) = what_to_change(found)
    assert said.endswith("required, input missing: a campaign of recordings, by --recording")


# --------------------------------------------------------------------------- the sheet to sign

REPORT = """
report:
  {customer: Frotas do Sul, company: Encarroçadora Silva, vehicle: "26.280", drawing: AB-12,
   revision: C, author: L. Silva, checker: M. Costa, approver: A. Reis}
"""


def test_report_section_fills_the_approval_sheet():
    found = approve_driveline(reader.loads(UNRATED + REPORT))
    told = story.approval_report_from_results(
        found, helps=(), fixes=(), say=Translator("pt"), issue=ISSUE
    )
    assert told.facts[:4] == (
        ("Cliente", "Frotas do Sul"), ("Veículo", "26.280"), ("Desenho", "AB-12"),
        ("Revisão", "C"),
    )  # fmt: skip
    assert told.chapters[0].title == "Folha de aprovação"
    company, name, *_ = told.chapters[0].blocks[-1].rows
    assert company == ("empresa", "Encarroçadora Silva", "", "", "Frotas do Sul")
    assert name == ("nome", "L. Silva", "M. Costa", "A. Reis", "")
    (revisions,) = next(c for c in told.chapters if c.title == "Revisões").blocks
    assert revisions.rows[0] == ("C", ISSUE.date, "", "L. Silva", "M. Costa")


@pytest.mark.parametrize(
    ("text", "key", "says"),
    [
        ("report: {custmer: us}", "report.custmer", "did you mean customer?"),
        ("report: {drawing: true}", "report.drawing", "must be a text (got true)"),
        (f"report: {{author: {'x' * 61}}}", "report.author", "may have up to 60 characters"),
    ],
)
def test_wrong_report_section_is_refused_with_key_and_line(text, key, says):
    with pytest.raises(InvalidFileError) as caught:
        reader.loads(UNRATED + text, name="a.yaml")
    line = UNRATED.count("\n") + 1
    assert f"a.yaml:{line}:" in str(caught.value)
    assert f"{key}: " in str(caught.value)
    assert says in str(caught.value)


def test_sheet_sets_what_is_required_against_what_is_achieved():
    """Every criterion that is not met has a row, or is counted below the table."""
    bounds = [
        {"quantity": "joint_angle", "maximum": 0.01 * k, "source": "us"} for k in range(1, 15)
    ]
    found = approve_driveline(limited(*bounds))
    table, count, *_ = approval_sheet(found, helps=(), fixes=(), say=ENGLISH, state=None).blocks
    worst = max(c.value for c in found.checks if c.quantity == "joint_angle") / deg
    verdict, name, _, required, achieved, margin = table.rows[0]
    assert (verdict, required, margin) == ("exceeded", "max 0.01 deg", "far beyond")
    assert name.startswith("Joint angle")
    assert achieved == f"{worst:.3g} deg"
    criteria = {(c.quantity, c.limit) for c in found.checks}
    assert len(table.rows) + int(re.search(r"(\d+) more in the annex", str(count))[1]) == len(
        criteria
    )


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("pdftotext"), reason="pdftotext of poppler is not installed")
@pytest.mark.parametrize("code", LANGUAGE_CODES)
def test_sheet_has_the_first_page_for_itself(told, code, tmp_path):
    path, say = tmp_path / "out.pdf", Translator(code)
    path.write_bytes(pdf_document(told[code]))
    read = subprocess.run(
        ["pdftotext", "-layout", str(path), "-"], capture_output=True, text=True, check=True
    )
    first, second, *_ = read.stdout.split("\f")
    for text in ("Criteria: required and achieved", "Open points", "Signatures"):
        assert say(text) in first
    assert second.split("\n")[0].strip() == f"2 {say('Limits')}"


def test_comparison_sheet_shows_before_and_after(truck):
    """The verdict of each stands in its column; the later one is signed."""
    text = templates.template_text("truck")
    after = approve_driveline(reader.loads(text + REPORT))
    variants = [Variant(name="a", approval=truck), Variant(name="b", approval=after)]
    told = story.comparison_report(variants, say=ENGLISH, issue=ISSUE)
    table = told.chapters[0].blocks[0]
    assert table.head == ("criterion", "required", "1. a", "2. b")
    worst = worst_verdict(c.grade for c in after.checks)
    assert table.grades[0][2:] == (worst, worst)
    assert table.rows[0][2] == table.rows[0][3]
    assert ("Customer", "Frotas do Sul") in told.facts
    (drawn,) = (b for b in told.chapters[0].blocks if isinstance(b, Figures))
    assert drawn.figures[0].title.startswith("2. b: the line (")
    (points,) = (b for b in told.chapters[0].blocks if isinstance(b, BulletList)
                 if b.caption.endswith("open points"))  # fmt: skip
    assert points.caption == "2. b: open points"


def test_limits_of_one_quantity_are_told_apart_in_the_table_of_limits():
    """Two rows were both called "Joint angle", with other bounds."""
    text = templates.template_text("small")
    found = approve_driveline(reader.loads(text))
    told = story.approval_report_from_results(found, helps=(), fixes=(), say=ENGLISH, issue=ISSUE)
    tables = (b for c in told.chapters for b in c.blocks if isinstance(b, Table))
    (table,) = (t for t in tables if t.caption == "Every limit, where it is worst")
    names = [row[1] for row in table.rows]
    assert {"Joint angle (recommended)", "Joint angle (maximum)"} < set(names)
    assert len(set(names)) == len(names)


# --------------------------------------------------------------------------- its counts


@pytest.mark.slow
def test_first_page_lists_missing_input_of_incomplete_verdict():
    """It showed limits that warn and pass, and none of those that made it incomplete."""
    found = approve_application(limited(FLAT, LIVES | {"required": True}))
    told = story.approval_report_from_results(
        found, helps=(), fixes=(), say=Translator("it"), issue=ISSUE
    )
    (points,) = [b for b in told.chapters[0].blocks
                 if getattr(b, "caption", "") == "Punti aperti"]  # fmt: skip
    assert points.points[0][0] == next(what_to_change(found, "it"))
    told = story.approval_report_from_results(
        approve_application(limited(FLAT)), helps=(), fixes=(), say=ENGLISH, issue=ISSUE
    )
    assert "without an answer" not in str(told.chapters[0])


@pytest.mark.slow
def test_pdf_and_workbook_counts_match_page():
    found = approve_application(limited(FLAT, LIVES))
    told = story.approval_report_from_results(found, helps=(), fixes=(), say=ENGLISH, issue=ISSUE)
    assert told.summary.endswith("4 met; 1 not evaluated")
    assert _document_data(told)[0]["summary"] == told.summary
    front = openpyxl.load_workbook(BytesIO(workbook_bytes(found, say=ENGLISH))).worksheets[0]
    assert any(told.summary in str(c.value) for row in front.iter_rows() for c in row)


def test_report_without_evaluated_limit_approves_nothing():
    small = yaml.safe_load(UNRATED) | {"limits": [LIVES]}
    found = approve_application(reader.loads(yaml.safe_dump(small)))
    assert found.verdict == "incomplete"
    assert list(what_to_change(found)) == [
        "Nothing was held against a limit, so nothing is approved."
    ]


@pytest.mark.parametrize(
    ("margin", "shown"),
    [(99.99, "+9999 %"), (100.0, ">9999 %"), (4.7e19, ">9999 %"), (-20, "< -999 %")],
)
def test_extreme_margin_fits_its_column(margin, shown):
    """A bracket that nothing wears had +4783813770319300132864 % of its life left."""
    assert ENGLISH.margin_percent(margin) == shown


def test_shaft_without_tube_has_no_critical_speed_bar():
    """What is not known of one shaft warned of an empty slice, on the way to a page."""
    text = yaml.safe_load(UNRATED)
    del text["driveline"]["shafts"][0]["tube"]
    (response,) = approve_driveline(reader.loads(yaml.safe_dump(text))).line_responses
    assert np.isnan(response.strength.critical_speeds[..., 0]).all()
    assert "shaft 1" not in all_line_plots(response, ENGLISH)[-1].svg


@pytest.mark.parametrize(
    ("bounds", "graded"),
    [
        (
            "band: [0.42, 0.58]",
            r'IF\(FALSE,"exceeded",.*IF\(SUMPRODUCT\([^"]*\)>0,"beyond recommended","met"\)',
        ),
        ("maximum: 0.58", r'IF\(IF\(ISNUMBER\(\$D\d+\),SUMPRODUCT.*,"exceeded",'),
    ],
)
def test_workbook_grades_limit_above_angle_as_check_does(bounds, graded):
    """Above 3 deg, in the sheet's own unit; a band warns, a maximum fails.

    What the formulas come to is LibreOffice's to say, in tests/office.
    """
    limit = f"{{quantity: half_critical_band, {bounds}, above_angle: 3, source: us}}"
    text = UNRATED.replace("limits: body-builder", f"limits: [{limit}]")
    found = approve_driveline(reader.loads(text))
    book = openpyxl.load_workbook(BytesIO(workbook_bytes(found, say=ENGLISH)))
    results, calculation = book["Results"], book["Calculation"]
    (row,) = (c.row for c in results["A"] if c.value == "Speed near half critical, shaft 1")
    judged = next(c.value for c in results[row] if str(c.value).startswith("=IF(changed_inputs"))
    assert re.search(graded, judged)
    largest = re.search(r"'Calculation'!\$E\$(\d+):\$\w+\$(\d+)>3\)", judged)
    assert largest
    assert largest[1] == largest[2]
    assert [calculation.cell(int(largest[1]), k).value for k in (1, 2)] == [
        "largest angle of a cross", "deg"
    ]  # fmt: skip
    rules = [
        f
        for place in results.conditional_formatting
        if any(f"E{row}" in str(r) for r in place.sqref.ranges)
        for rule in place.rules
        for f in rule.formula
    ]
    assert rules
    assert all(f"$E${largest[1]}>3," in f or f"!E{largest[1]}>3," in f for f in rules)


@pytest.mark.slow
def test_recording_sheet_has_translated_title_and_headers(tmp_path):
    """It was called `recording` in every language, over a column headed `, as computed`."""
    from zipfile import ZipFile

    found = approve_application(limited(FLAT, LIVES))
    for code, title in (("en", "Recording"), ("pt", "Medição"), ("it", "Registrazione")):
        book = tmp_path / f"{code}.xlsx"
        book.write_bytes(workbook_bytes(found, say=Translator(code)))
        with ZipFile(book) as file:
            assert f'name="{title}"' in file.read("xl/workbook.xml").decode()
            texts = file.read("xl/sharedStrings.xml").decode()
        assert not re.search(r">, ", texts)


def test_column_headers_keep_words_and_long_names_wrap(truck):
    lines = list(
        terminal.approval_lines(truck, helps=(), states=True, say=Translator("pt"), width=80)
    )
    assert any("sobrecarga" in line for line in lines)
    at = next(k for k, line in enumerate(lines) if line == "Torque alternado / limite de")
    assert lines[at + 1].startswith("  fadiga da junta")


# ------------------------------------------------------------------ signs

HYPHENED = re.compile(r"(?<![\w.,])-\s?[\d∞]")
"""A number below nothing, written with a hyphen."""


@pytest.mark.slow
@pytest.mark.parametrize("code", LANGUAGE_CODES)
def test_page_uses_minus_signs_and_terminal_hyphens(told, truck, code):
    """On the workbench -5969 N·m stood beside −63 %, in a report -63 % beside −3 in an equation."""
    bare = re.sub(r"<(pre|style|script).*?</\1>", "", html_page(told[code]), flags=re.DOTALL)
    texts = re.findall(r">([^<]+)<", bare)
    assert [t for t in texts if HYPHENED.search(t)] == []
    assert any(re.search(r"−\d", t) for t in texts)
    printed = "\n".join(terminal.approval_lines(truck, helps=(), states=True, say=Translator(code)))
    assert HYPHENED.search(printed)
    assert not re.search(r"−\d", printed)


def test_signs_and_decimals_follow_language():
    pt = Translator("pt").with_minus_sign
    assert [pt.margin_percent(v) for v in (-0.634, -0.0046, -20.0, 0.5)] == [
        "−63 %", "−0,46 %", "< −999 %", "+50 %"
    ]  # fmt: skip
    assert [pt.number(v) for v in (-3.25, float("-inf"))] == ["−3,250", "−∞"]
    assert pt.with_decimal_sign("12-34 Hz") == "12-34 Hz"  # from, to
    assert [Translator("pt").margin_percent(v) for v in (-0.634, -20.0)] == ["-63 %", "< -999 %"]
    assert (
        pt.translate_message(translatable_message("the first at {first} s", first="7.5"))
        == "the first at 7,5 s"
    )
    assert (
        pt.translate_message(translatable_message("{channel}: dead", channel="run.2.csv"))
        == "run.2.csv: dead"
    )
