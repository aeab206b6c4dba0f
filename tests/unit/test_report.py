"""Reports: the same story in three languages, whole and self-contained in every medium."""

import ast
import base64
import hashlib
import re
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
from chief import chief
from click.testing import CliRunner

from cardan import files
from cardan.base.errors import DesignError
from cardan.base.part import Occasion, Part
from cardan.base.said import said
from cardan.base.units import deg, mm, rpm
from cardan.cli import cli
from cardan.model.application import Surroundings
from cardan.model.movable import MOVABLES
from cardan.quantity.quantities import QUANTITIES
from cardan.report import extra, story, terminal
from cardan.report.blocks import Chapter, Picture, Table
from cardan.report.book import column
from cardan.report.chart import Chart, bounds, ticks
from cardan.report.compare import Variant, differences, effects
from cardan.report.drawing import drawings, worst_state
from cardan.report.html import page
from cardan.report.inputs import inputs
from cardan.report.language import CODES, EN, LACKED, Language, catalogue
from cardan.report.pdf import _told, document, pages
from cardan.report.plots import plots, round_the_turn
from cardan.report.sheet import sections
from cardan.report.svg import GRADED
from cardan.report.wording import counts, sense
from cardan.report.workbook import workbook
from cardan.study.approval import approve, assess
from cardan.study.driveline import DrivelineStudy
from cardan.study.fix import fix
from cardan.study.sensitivity import sensitivities
from cardan.study.stability import stability
from cardan.study.studies import STUDIES, VibrationStudy
from cardan.web.words import WORDS

ROOT = Path(__file__).parents[2]
SOURCES = [*(ROOT / "src/cardan/report").glob("*.py"), *(ROOT / "src/cardan/cli").glob("*.py")]
EXAMPLES = sorted((ROOT / "examples").glob("*.yaml"))
TOLD = "refuse-collector-6x2", "van"
"""Examples that have between them most of what a report tells."""
ISSUE = story.Issue(date="2026-11-20", files=("a.yaml",), prints=("0" * 16,), texts=("title: a",))


@pytest.fixture(scope="module")
def truck():
    return assess(files.loads(files.starter("truck")))


def with_vibration(application, surroundings=None):
    return approve(application, (DrivelineStudy(), VibrationStudy(surroundings)))


@pytest.fixture(scope="module")
def told(truck):
    """The starter's story by language."""
    helps = sensitivities(truck)
    fixes = fix(truck.application, count=2, hold=["phase"])
    shaken = with_vibration(truck.application)
    return {
        code: story.approval(shaken, helps=helps, fixes=fixes, say=Language(code), issue=ISSUE)
        for code in CODES
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


def test_every_text_is_translated():
    said = {text for source in SOURCES for text in said_in(source)}
    assert len(said) > 200
    said |= (
        {w for m in MOVABLES.values() for w in (m.called, m.forth, m.back)}
        | set(STUDIES)
        | set(WORDS)
    )
    for code in CODES[1:]:
        assert sorted(said - {text for _, text in catalogue(code)}) == []


def test_a_catalogue_is_what_translators_tools_read():
    """Babel reads the same texts from a .po file as the reports do."""
    for code in CODES[1:]:
        path = ROOT / "src/cardan/report/text" / f"{code}.po"
        with path.open("rb") as file:
            theirs = {
                (m.context or "", m.id[0] if m.pluralizable else m.id):
                    "\0".join(m.string) if m.pluralizable else m.string
                for m in read_po(file) if m.id and m.string
            }  # fmt: skip
        ours = {key: text for key, text in catalogue(code).items() if key[1]}
        assert ours == theirs


def test_every_quantity_has_a_name_in_every_language():
    for code in CODES:
        names = [Language(code).name(key) for key in QUANTITIES]
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
        for text in (q.stated, *q.where.values(), q.use):
            words = set(re.findall(r"[A-Za-z]{3,}", text)) - names
            for code in CODES[1:]:
                assert not words or ("", text) in catalogue(code), f"{q.key}: {text}"


def test_translations_keep_what_is_filled_in():
    for code in CODES[1:]:
        for (_, english), other in catalogue(code).items():
            assert other.strip()
            assert set(re.findall(r"{(\w+)}", other)) == set(re.findall(r"{(\w+)}", english))


@pytest.mark.slow
@pytest.mark.parametrize("path", chief(EXAMPLES, *TOLD, ids=lambda p: p.stem))
def test_every_example_is_told_in_every_language(path):
    """A text composed at run time and missing in the catalogue is found here."""
    found = with_vibration(files.read(path))
    helps = sensitivities(found)
    for say in map(Language, ("pt", "it")):
        LACKED.clear()
        whole = story.approval(found, helps=helps, fixes=(), say=say, issue=ISSUE)
        shown = page(whole)
        assert len(shown) > 50_000
        assert not any(
            f" {w} " in shown[: shown.index("<pre")] for w in ("gear", "mode", "zone of")
        )
        lines = list(terminal.approval(found, helps=helps, states=True, say=say))
        assert len(lines) > 60
        assert sorted(LACKED) == []
        # Publications keep the language they are written in.
        ours = [line for line in lines if not line.startswith("  [")]
        assert not any(f" {w} " in line for line in ours for w in ("joint", "shaft", "against"))


def test_a_language_nobody_speaks_is_refused():
    with pytest.raises(ValueError, match="there are: en, it, pt"):
        Language("la")


@pytest.mark.parametrize(
    ("code", "shown"), [("en", "0.03116"), ("pt", "0,03116"), ("it", "0,03116")]
)
def test_decimal_sign_of_the_language(code, shown):
    assert Language(code).number(0.0311591) == shown


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
def test_numbers_as_engineers_write_them(value, shown):
    assert EN.number(value) == shown


def test_parts_in_the_language():
    assert Language("pt").part(Part("centre bearing", 2)) == "mancal central 2"
    assert Language("it").part(Part("clearance", 1, "tank")) == "albero 1 da tank"
    # What the user calls a thing is its name, whatever else the word may mean.
    assert Language("it").part(Part("clearance", 1, "pass")) == "albero 1 da pass"
    assert Language("it").occasion(Occasion("state", "fail")) == "fail"
    assert Language("it").occasion(Occasion("state", "jounce")) != "jounce"


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
@pytest.mark.parametrize("code", CODES)
def test_page_needs_nothing_else(told, code):
    text = page(told[code])
    reader = read(text)
    assert not {"script", "link", "img", "iframe", "object"} & set(reader.tags)
    links = [v for k, v in reader.attrs if k in ("src", "href", "xlink:href", "action")]
    assert links
    assert all(v.startswith("#") for v in links)
    assert "url(" not in text
    assert "@import" not in text
    assert len(text.encode()) < 2_000_000
    assert dict(reader.attrs)["lang"] == {"pt": "pt-BR"}.get(code, code)


def test_page_has_no_place_twice(told):
    ids = [v for k, v in read(page(told["en"])).attrs if k == "id"]
    assert len(ids) == len(set(ids))


def test_page_tells_the_verdict_first(told, truck):
    text = page(told["en"])
    body = text[text.index("<body>") :]
    verdict = EN(truck.verdict).upper()
    assert body.index(verdict) < body.index("What to change") < body.index("Approval")


def test_page_escapes_what_a_file_says():
    text = files.starter("small").replace("Two-piece driveline", "<script>alert(1)</script>")
    found = assess(files.loads(text))
    shown = page(story.approval(found, helps=(), fixes=(), say=EN, issue=story.Issue()))
    assert "<script>" not in shown
    assert "&lt;script&gt;alert(1)" in shown


def test_every_figure_is_well_formed_and_described(told):
    figures = list(story.figures(told["en"]))
    assert len(figures) > 12
    for figure in figures:
        root = ET.fromstring(figure.svg)
        assert root.attrib["aria-label"] == figure.alt
        assert len(figure.alt) > 20
        assert "nan" not in figure.svg


def test_table_rows_are_as_long_as_their_heads(told):
    for chapter in told["it"].chapters:
        for block in chapter.blocks:
            if isinstance(block, Table):
                assert {len(row) for row in block.rows} == {len(block.head)}
                assert {len(row) for row in block.grades} <= {len(block.head)}


def test_document_is_kept_and_self_contained(told):
    data = document(told["pt"])
    assert data.startswith(b"%PDF-")
    assert b"<pdfaid:part>3</pdfaid:part>" in data
    assert b"<pdfaid:conformance>A</pdfaid:conformance>" in data
    assert len(data) < 2_000_000
    assert b"/Suspects" not in data  # poppler takes a false one for a mistake
    assert data == document(told["pt"])  # the same story, the same document


def test_a_missing_library_says_how_to_get_it():
    with pytest.raises(extra.MissingExtra, match=r"pip install 'cardan\[report\]'"):
        extra.needed("no_such_library_at_all")


def test_variants_differ_where_they_were_changed():
    text = files.starter("small").replace("limits: protractor", "limits: heavy-truck")
    other = text.replace("torque_Nm: 8000", "torque_Nm: 4000")
    assert other != text
    variants = [Variant(name=n, approval=assess(files.loads(t)))
                for n, t in (("a", text), ("b", other))]  # fmt: skip
    (row,) = differences(variants, EN)
    assert row.values == ("8000 N·m", "4000 N·m")
    forces = [r for r in effects(variants, EN) if r.name.startswith("Centre bearing, static")]
    first, second = (float(v.split()[0]) for v in forces[0].values)
    assert first == pytest.approx(2 * second, rel=1e-3)  # four figures are printed
    assert read(page(story.comparison(variants, say=EN, issue=story.Issue())))


def test_variants_together_are_as_good_as_the_worst():
    """One that passes and one that fails: whoever reads the head of the page alone knows."""
    text = files.starter("small").replace("limits: protractor", "limits: [LIMIT]")
    limit = "{quantity: joint_angle, maximum: %s, unit: deg, source: us}"
    variants = [
        Variant(name=name, approval=assess(files.loads(text.replace("LIMIT", limit % most))))
        for name, most in (("good", 40), ("bad", 0.01))
    ]
    assert [v.approval.verdict for v in variants] == ["pass", "fail"]
    for some in (variants, variants[::-1]):
        assert story.comparison(some, say=EN, issue=story.Issue()).grade == "fail"
    (row,) = effects(variants, EN)
    worst = max(c.value for c in variants[1].approval.checks)
    assert row.values[1].startswith(f"{EN.number(worst / deg)} (")
    assert (row.grades, row.changed) == (("pass", "fail"), True)


def test_inputs_are_quoted_in_the_units_they_name():
    """As the starter's file gives them, read by eye."""
    rows = {(i.group, i.name): i.value for i in inputs(files.loads(files.starter("truck")), EN)}
    text = files.starter("truck")
    given = dict(re.findall(r"(\w+?): ([\d.]+)", text))
    stiffness = given["windup_stiffness_kNm_deg"]
    assert rows["Suspension", "wind-up stiffness"] == f"{stiffness} kN·m/deg"
    half = float(given["front_half_length_mm"])
    assert rows["Suspension", "equivalent link radius"] == f"{0.75 * half:g} mm"
    assert rows["Vehicle", "wheelbase"] == f"{given['wheelbase_mm']} mm"


def test_columns_of_a_workbook_go_on_behind_z():
    """As spreadsheets letter them: 26 is AA, 27 AB, 51 AZ, 52 BA, 701 ZZ, 702 AAA."""
    lettered = {0: "A", 25: "Z", 26: "AA", 27: "AB", 51: "AZ", 52: "BA", 701: "ZZ", 702: "AAA"}
    assert {k: column(k) for k in lettered} == lettered


def test_side_view_is_to_scale():
    """Pixels between neighbouring joints are as their distances along the line."""
    found = assess(files.loads(files.starter("truck")))
    r = found.responses[0]
    figure = drawings(r, EN)[0]
    joints = [
        (float(c.attrib["cx"]), float(c.attrib["cy"]))
        for c in ET.fromstring(figure.svg).iter("{http://www.w3.org/2000/svg}circle")
        if c.attrib["r"] == "9"
    ]
    points = r.demand.installed.layout.points
    pixels, metres = np.diff(np.array(joints), axis=0), np.diff(points, axis=0)
    scale = pixels[:, 0] / metres[:, 0]
    times = int(re.search(r"exaggerated (\d+) times", figure.title)[1])
    assert scale[0] == pytest.approx(scale[1], rel=1e-3)  # pixels are written to a hundredth
    np.testing.assert_allclose(-pixels[:, 1] / metres[:, 2], times * scale, rtol=5e-3)


def test_ride_curve_goes_through_the_states(truck):
    """States that the suspension places without winding the axle up lie on the curve."""
    from cardan.report.plots import _ride

    r = truck.responses[0]
    places, ridden = _ride(r)
    for s, name in enumerate(r.demand.states):
        if name in ("full rebound", "empty", "gvw", "jounce"):
            curve = np.interp(r.demand.travel[s] / mm, places, ridden.layout.side[:, -1] / deg)
            # Straight between 41 places; the slope bends by microdegrees over one of them.
            assert curve == pytest.approx(r.layout.side[s, -1] / deg, abs=1e-3)


def test_plots_have_a_chart_for_each_question(truck):
    titles = [f.title for f in plots(truck.responses[0], EN)]
    assert len(titles) == len(set(titles))
    for word in ("Speed round", "over the travel", "by order", "by gear", "Critical", "Spring"):
        assert any(word in t for t in titles)


@pytest.mark.parametrize(("low", "high"), [(0, 1), (-3.2, 7.9), (1e-5, 3e-5), (0, 12146)])
def test_ticks_are_round_and_inside(low, high):
    found = ticks(low, high)
    assert 3 <= len(found) <= 9
    assert low - 1e-9 * (high - low) <= found[0]
    assert found[-1] <= high + 1e-9 * (high - low)
    assert set(np.round(np.diff(found) / np.diff(found)[0], 6)) == {1}


def test_equal_axes_keep_circles_round():
    chart = Chart(say=EN, x=bounds(np.array([0, 1.0])), y=bounds(np.array([0, 9.0])),
                  x_label="", y_label="", equal=True)  # fmt: skip
    (x0, y0), (x1, y1) = chart.spot(0, 0), chart.spot(1, 1)
    assert x1 - x0 == pytest.approx(y0 - y1)


def test_cells_of_results_are_graded_as_their_checks():
    """Every state of a line in which a clearance fails is marked in the obstacle's row."""
    path = next(p for p in EXAMPLES if p.stem == "refuse-collector-6x2")
    found = assess(files.read(path))
    whole = story.approval(found, helps=(), fixes=(), say=EN, issue=story.Issue())
    rows = {
        row[0]: dict(zip(block.head, grades, strict=True))
        for chapter in whole.chapters
        for block in chapter.blocks
        if isinstance(block, Table) and block.head[0] == "quantity" and block.grades
        for row, grades in zip(block.rows, block.grades, strict=True)
    }
    bad = {
        c.state: c.grade for c in found.checks if c.quantity == "clearance" and c.grade != "pass"
    }
    assert bad
    shown = rows["Clearance, auxiliary beam"]
    assert {s: g for s, g in shown.items() if g} == bad


def test_a_turn_is_plotted_in_the_units_it_names(truck):
    """The pinion swings as far to either side as the check says; points miss a crest by 0.1 %."""
    (response,) = truck.responses
    s = worst_state(response)
    speed, acceleration = round_the_turn(response, EN)
    rpms, rates = (float(f.alt.split()[-1]) for f in (speed, acceleration))
    whole = response.excitation
    assert rates == pytest.approx(2 * whole.torsional.acceleration[s], rel=2e-3)
    turning = response.demand.speed[s] / rpm
    assert rpms == pytest.approx(whole.irregularity[s] * turning, rel=2e-3)


@pytest.mark.parametrize("bounds", [("normal", "maximum"), ("maximum", "normal")])
def test_a_cell_has_the_colour_of_its_worst_check(bounds):
    """Two limits on one angle: one warns, the other fails."""
    first, second = (f"{{quantity: joint_angle, {b}: 0.001, source: us}}" for b in bounds)
    limits = f"limits: [{first}, {second}]"
    found = assess(files.loads(files.starter("small").replace("limits: protractor", limits)))
    assert {c.grade for c in found.checks} == {"warn", "fail"}
    whole = story.approval(found, helps=(), fixes=(), say=EN, issue=story.Issue())
    cells = {
        grade
        for block in chapter(whole, "Results by state").blocks
        if isinstance(block, Table)
        for row in block.grades
        for grade in row
    }
    assert cells == {"", "fail"}


def test_a_cell_has_the_colour_of_its_own_line_and_an_approximation_has_none():
    """Both lines of a tandem have a joint 1; what AE-7 says of a line nothing is held against."""
    text = yaml.safe_load((ROOT / "examples" / "tandem-6x4.yaml").read_text(encoding="utf-8"))
    lines = assess(files.loads(yaml.safe_dump(text))).responses
    between = float(np.mean([r.angles[:, 0].max() for r in lines])) / deg
    rows = [{"quantity": "joint_angle", "maximum": between, "source": "us"},
            {"quantity": "torsional_acceleration", "maximum": 1e-3, "source": "us"}]  # fmt: skip
    found = assess(files.loads(yaml.safe_dump(text | {"limits": rows})))
    whole = story.approval(found, helps=(), fixes=(), say=EN, issue=story.Issue())
    failed = {(c.line, c.quantity, c.part, c.state) for c in found.checks if c.grade == "fail"}
    first = [line for line, quantity, part, _ in failed
             if (quantity, part) == ("joint_angle", Part("joint", 1))]  # fmt: skip
    assert len(set(first)) == 1
    plain = 0
    for r in found.responses:
        tables = [
            b
            for b in chapter(whole, f"Results by state: {r.line.name}").blocks
            if isinstance(b, Table)
        ]
        for section, table in zip(sections(r), tables, strict=True):
            for row, grades in zip(section.rows, table.grades, strict=True):
                held = [
                    not row.method and (r.line.name, row.quantity, row.part, state) in failed
                    for state in r.demand.states
                ]
                assert [g == "fail" for g in grades[2:]] == held, row
                plain += bool(row.method) and row.quantity == "torsional_acceleration"
    assert plain > 2


def test_a_limit_s_number_leads_to_its_source():
    """[1] in the table of limits is [1] in the list below it."""
    rows = [{"quantity": q, "maximum": 45, "source": f"what {q} says"}
            for q in ("joint_angle", "compound_angle", "torsional_acceleration")]  # fmt: skip
    text = yaml.safe_load(files.starter("small")) | {"limits": rows}
    found = assess(files.loads(yaml.safe_dump(text)))
    table, listed, *_ = story.verdict(found, EN)
    said = dict(point.split(" ", 1) for point, _ in listed.points)
    by_name = {EN.name(row["quantity"]): row["source"] for row in rows}
    assert {row[1]: said[row[-1]] for row in table.rows} == by_name
    assert list(said) == ["[1]", "[2]", "[3]"]


@pytest.mark.parametrize("quantity", ["joint_angle", "joint_angle_min", "odd_joint_angle"])
def test_an_angle_is_coloured_by_every_limit_on_it(quantity):
    """Too large, too small, or too large for the one that stands alone: one row shows them all."""
    bound = 85 if quantity == "joint_angle_min" else 0.001
    limits = f"limits: [{{quantity: {quantity}, maximum: {bound}, source: us}}]"
    found = assess(files.loads(files.starter("small").replace("limits: protractor", limits)))
    bad = {str(c.part) for c in found.checks if c.grade == "fail"}
    assert bad
    whole = story.approval(found, helps=(), fixes=(), say=EN, issue=story.Issue())
    shown = {
        row[0].removeprefix("Joint angle, "): grades[2]
        for block in chapter(whole, "Results by state").blocks
        if isinstance(block, Table)
        for row, grades in zip(block.rows, block.grades, strict=True)
        if row[0].startswith("Joint angle, ")
    }
    assert {joint for joint, grade in shown.items() if grade == "fail"} == bad


def test_a_sheet_shows_the_shaft_that_is_nearest_to_an_obstacle():
    """One row for an obstacle: the smallest of its clearances in each state, as it stands."""
    path = next(p for p in EXAMPLES if p.stem == "refuse-collector-6x2")
    asked = files.read(path)
    found = assess(replace(asked, limits=tuple(replace(k, points="own") for k in asked.limits)))
    (response,) = found.responses
    shown = [row for s in sections(response) for row in s.rows if row.quantity == "clearance"]
    assert len(shown) == len(response.obstacles)
    for row in shown:
        for state, value in zip(response.demand.states, row.values, strict=True):
            each = [
                c.value for c in found.checks
                if (c.quantity, c.state, c.part.other) == ("clearance", state, row.part.other)
            ]  # fmt: skip
            assert len(each) == response.line.joint_count - 1
            assert value == pytest.approx(min(each) / mm)
            assert min(each) < max(each)


def test_every_medium_says_which_side_of_a_limit_is_safe():
    """A lower limit is ≥, an upper one ≤, a band is to be kept out of."""
    text = files.starter("small").replace("limits: protractor", "limits: [LIMITS]")
    limits = "{quantity: joint_angle_min, maximum: 0.1, source: us}, " \
             "{quantity: joint_angle, maximum: 40, source: us}, " \
             "{quantity: half_critical_band, band: [0.42, 0.58], source: us}"  # fmt: skip
    found = assess(files.loads(text.replace("LIMITS", limits)))
    assert {c.quantity: sense(c, EN) for c in found.checks} == {
        "joint_angle_min": "≥", "joint_angle": "≤", "half_critical_band": "outside",
    }  # fmt: skip
    printed = "\n".join(terminal.approval(found, helps=(), say=EN))
    assert re.search(r"Smallest joint angle .* >= +0\.1000", printed)
    assert re.search(r"Joint angle .* <= +40\.00", printed)


def test_what_has_no_answer_is_counted_whether_required_or_not():
    text = files.starter("small").replace("limits: protractor", "limits: [LIMITS]")
    limits = "{quantity: joint_angle, maximum: 40, source: us}, " \
             "{quantity: joint_life, maximum: 5000, source: us}"  # fmt: skip
    found = assess(files.loads(text.replace("LIMITS", limits)))
    assert found.verdict == "pass"
    assert counts(found, EN) == "0 fail, 0 warn, 3 pass, 3 unanswered"


# One white pixel.
PIXEL = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4//8/AAX+Av4N70a4AAAAAElFTkSuQmCC"
)


def test_a_picture_stands_in_page_and_document_and_only_its_script_may_run(told):
    """The policy holds the hash a browser computes: SHA-256 of what stands in the script."""
    script = "console.log(1)"
    scene = f'<div class="here"><script>{script}</script></div>'
    picture = Picture(title="A", png=PIXEL, alt="One white pixel.", scene=scene)
    plain = told["en"]
    whole = replace(plain, chapters=(*plain.chapters, Chapter(title="B", blocks=(picture,))))
    text = page(whole)
    allowed = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert f"script-src 'sha256-{allowed}'\"" in text
    assert scene in text
    assert 'alt="One white pixel."' in text
    assert "script-src" not in page(plain)
    data = document(whole)
    assert len(re.findall(rb"/Subtype ?/Image", data)) > len(
        re.findall(rb"/Subtype ?/Image", document(plain))
    )


def test_a_picture_taller_than_a_page_is_whole_on_one():
    """The lower half of a bracket's damage was cut off at the foot of its page."""
    plt = pytest.importorskip("matplotlib.image")
    tall = np.zeros((900, 300, 3))
    tall[:20, :, 0] = tall[-20:, :, 2] = 1.0  # red above, blue below
    drawn = BytesIO()
    plt.imsave(drawn, tall, format="png")
    picture = Picture(title="A", png=drawn.getvalue(), alt="A tall one.", scene="")
    found = approve(limited(FLAT))
    plain = story.approval(found, helps=(), fixes=(), say=EN, issue=ISSUE)
    whole = replace(plain, chapters=(Chapter(title="B", blocks=(picture,)),))
    shown = [plt.imread(BytesIO(png))[..., :3] for png in pages(whole, ppi=40)]
    ends = [[(np.abs(one - of).max(-1) < 0.2).any() for of in np.eye(3)[[0, 2]]] for one in shown]
    assert [True, True] in ends


def chapter(whole: story.Story, title: str) -> Chapter:
    return next(c for c in whole.chapters if c.title == title)


@pytest.mark.slow
def test_vibration_is_told_as_the_command_answers_it(truck):
    """A gear that runs through a resonance stands at 0 %, coloured as the command grades it."""
    approval = with_vibration(truck.application, Surroundings(axle_inertia=3.0))
    found = approval.of("vibration")
    whole = story.approval(approval, helps=(), fixes=(), say=EN, issue=story.Issue())
    said, distances, limits, *tables, modes, drawn = chapter(
        whole, "Vibration and stability"
    ).blocks
    assert said.paragraphs[0].startswith("Vibration: WARN")
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
def test_what_grows_fails_in_the_chapter_and_the_headline(truck):
    """Next to undamped, its tyres too: zones open, and their triangles are red."""
    app = truck.application
    loose = replace(app, tyre=replace(app.tyre, slip_stiffness=9e8))
    found = with_vibration(loose, Surroundings(damping_ratio=1e-4))
    whole = story.approval(found, helps=(), fixes=(), say=EN, issue=story.Issue())
    assert whole.grade == "fail"  # the headline is never better than a chapter
    said, _, limits, *_, modes, _ = chapter(whole, "Vibration and stability").blocks
    assert said.paragraphs[0].startswith("Vibration: FAIL")
    assert limits.grades[0][0] == "fail"
    assert limits.rows[0][1] in {"Growth of torsional vibration", "Vibratory torque over endurance"}
    assert any(GRADED["fail"] in f.svg for f in modes.figures)


def test_a_line_that_cannot_be_asked_says_so(tmp_path):
    """Without tubes nobody knows how stiff it is; the page is written all the same."""
    file, out = tmp_path / "bare.yaml", tmp_path / "bare.html"
    text = re.sub(r"(?m)^ *tube:.*\n", "", files.starter("small"))
    file.write_text(text, encoding="utf-8")
    run = CliRunner().invoke(cli, ["check", str(file), "--with", "vibration", "--html", str(out)])
    assert run.exit_code in (0, 1), run.output
    assert "vibration could not be asked: the tube of each shaft" in out.read_text("utf-8")


@pytest.mark.parametrize("key", ["speed_rpm", "torque_Nm"])
def test_vibration_needs_a_speed_and_a_torque(key):
    text = re.sub(rf"(?m)^{key}:.*\n", "", files.starter("small"))
    with pytest.raises(DesignError, match="needs a speed and a torque"):
        stability(files.loads(text))


def test_given_torsion_stands_among_the_inputs():
    text = files.starter("small") + "torsion: {axle_inertia_kgm2: 3, damping_ratio: 0.03}\n"
    rows = {i.name: i.value for i in inputs(files.loads(text), EN) if i.group == "Torsion"}
    assert rows == {"axle inertia": "3 kg·m²", "damping ratio of the first mode": "0.03"}


@pytest.mark.parametrize("key", ["speed_rpm", "torque_Nm"])
def test_a_file_without_speed_or_torque_is_told_all_the_same(key, tmp_path):
    """A page of it crashed once: the worst state was looked for among unknown numbers."""
    file, out = tmp_path / "some.yaml", tmp_path / "some.html"
    file.write_text(re.sub(rf"(?m)^{key}:.*\n", "", files.starter("small")), encoding="utf-8")
    run = CliRunner().invoke(cli, ["check", str(file), "--html", str(out), "-q"])
    assert run.exit_code in (0, 1), run.output
    assert out.exists()


# --------------------------------------------------------------------------- what to change


def what_to_change(found, code="en"):
    """All that a report says under that heading, without corrections."""
    told = story.approval(
        found, helps=sensitivities(found), fixes=(), say=Language(code), issue=ISSUE
    )
    (chapter,) = [c for c in told.chapters if c.title == Language(code)("What to change")]
    for block in chapter.blocks:
        yield from getattr(block, "paragraphs", ())
        for point, more in getattr(block, "points", ()):
            yield from (point, *more)


def limited(*rows, profile="protractor", **more):
    """The truck starter under other limits."""
    text = yaml.safe_load(files.starter("truck")) | more
    return files.loads(yaml.safe_dump(text | {"limits": list(rows) or profile}))


FLAT = {"quantity": "joint_angle", "maximum": 45, "source": "made up"}
GROWS = {"quantity": "torsional_growth", "unit": "1/s", "maximum": -100, "source": "made up"}
LIVES = {"quantity": "fatigue_life", "unit": "h", "maximum": 5000, "source": "made up"}


def test_a_report_says_that_all_passes_only_where_all_does():
    assert list(what_to_change(approve(limited(FLAT)))) == [
        "Everything passes; nothing needs to change."
    ]
    assert list(what_to_change(approve(limited(FLAT, LIVES)))) == [
        "What has an answer passes; nothing needs to change."
    ]


@pytest.mark.slow
def test_a_report_names_the_study_that_fails_where_no_move_helps():
    """It said "Everything passes; nothing needs to change." under a headline that said FAIL."""
    found = with_vibration(limited(FLAT, GROWS))
    assert found.verdict == "fail"
    (said,) = what_to_change(found)
    assert re.fullmatch(
        r"fail \(vibration\): Growth of torsional vibration, zone of .*: −\S+ against −100.0 1/s",
        said,
    )
    assert next(what_to_change(found, "pt")).startswith("reprovado (vibração): ")
    # Its first page says so beside what would help elsewhere, as a warning's remedy stood there.
    told = story.approval(found, helps=(), fixes=(), say=EN, issue=ISSUE)
    assert "no move was tried against it" in str(told.chapters[0])


def test_a_report_names_what_is_required_and_unanswered():
    found = approve(limited(FLAT, LIVES | {"required": True}))
    assert found.verdict == "incomplete"
    (said,) = what_to_change(found)
    assert said.endswith("required, and needs a campaign of recordings, by --recording")


def test_the_first_page_says_what_an_incomplete_verdict_lacks():
    """It showed limits that warn and pass, and none of those that made it incomplete."""
    found = approve(limited(FLAT, LIVES | {"required": True}))
    told = story.approval(found, helps=(), fixes=(), say=Language("it"), issue=ISSUE)
    (points,) = [b for b in told.chapters[0].blocks
                 if getattr(b, "caption", "") == "Richiesto, e senza risposta"]  # fmt: skip
    assert [one for one, _ in points.points] == [next(what_to_change(found, "it"))]
    told = story.approval(approve(limited(FLAT)), helps=(), fixes=(), say=EN, issue=ISSUE)
    assert "without an answer" not in str(told.chapters[0])


def test_document_and_workbook_count_as_the_page_does():
    found = approve(limited(FLAT, LIVES))
    told = story.approval(found, helps=(), fixes=(), say=EN, issue=ISSUE)
    assert told.summary.endswith("unanswered")
    assert _told(told)[0]["summary"] == told.summary
    front = openpyxl.load_workbook(BytesIO(workbook(found, say=EN))).worksheets[0]
    assert any(told.summary in str(c.value) for row in front.iter_rows() for c in row)


def test_a_report_of_nothing_says_that_nothing_is_approved():
    small = yaml.safe_load(files.starter("small")) | {"limits": [LIVES]}
    found = approve(files.loads(yaml.safe_dump(small)))
    assert found.verdict == "incomplete"
    assert list(what_to_change(found)) == [
        "Nothing was held against a limit, so nothing is approved."
    ]


@pytest.mark.parametrize(
    ("margin", "shown"),
    [(99.99, "+9999 %"), (100.0, ">9999 %"), (4.7e19, ">9999 %"), (-20, "< -999 %")],
)
def test_a_margin_keeps_to_its_column(margin, shown):
    """A bracket that nothing wears had +4783813770319300132864 % of its life left."""
    assert EN.percent(margin) == shown


def test_a_shaft_without_a_tube_has_no_bar_and_no_warning():
    """What is not known of one shaft warned of an empty slice, on the way to a page."""
    text = yaml.safe_load(files.starter("small"))
    del text["driveline"]["shafts"][0]["tube"]
    (response,) = assess(files.loads(yaml.safe_dump(text))).responses
    assert np.isnan(response.critical_speeds[..., 0]).all()
    assert "shaft 1" not in plots(response, EN)[-1].svg


@pytest.mark.parametrize(
    ("bounds", "graded"),
    [
        ("band: [0.42, 0.58]", r'IF\(FALSE,"fail",.*IF\(SUMPRODUCT\([^"]*\)>0,"warn","pass"\)'),
        ("maximum: 0.58", r'IF\(IF\(ISNUMBER\(\$D\d+\),SUMPRODUCT.*,"fail",'),
    ],
)
def test_a_workbook_asks_where_a_limit_asks_and_grades_as_it_does(bounds, graded):
    """Above 3 deg, in the sheet's own unit; a band warns, a maximum fails.

    What the formulas come to is LibreOffice's to say, in tests/office.
    """
    limit = f"{{quantity: half_critical_band, {bounds}, above_angle: 3, source: us}}"
    text = files.starter("small").replace("limits: protractor", f"limits: [{limit}]")
    found = assess(files.loads(text))
    book = openpyxl.load_workbook(BytesIO(workbook(found, say=EN)))
    results, calculation = book["Results"], book["Calculation"]
    (row,) = (c.row for c in results["A"] if c.value == "Speed near half critical, shaft 1")
    judged = next(c.value for c in results[row] if str(c.value).startswith("=IF(changed_inputs"))
    assert re.search(graded, judged)
    largest = re.search(r"'Calculation'!\$E\$(\d+):\$\w+\$(\d+)>3\)", judged)
    assert largest
    assert largest[1] == largest[2]
    assert [calculation.cell(int(largest[1]), k).value for k in (1, 2)] == [
        "largest joint angle", "deg"
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


def test_a_sheet_of_a_recording_has_its_title_and_heads(tmp_path):
    """It was called `recording` in every language, over a column headed `, as computed`."""
    from zipfile import ZipFile

    found = approve(limited(FLAT, LIVES))
    for code, title in (("en", "Recording"), ("pt", "Medição"), ("it", "Registrazione")):
        book = tmp_path / f"{code}.xlsx"
        book.write_bytes(workbook(found, say=Language(code)))
        with ZipFile(book) as file:
            assert f'name="{title}"' in file.read("xl/workbook.xml").decode()
            texts = file.read("xl/sharedStrings.xml").decode()
        assert not re.search(r">, ", texts)


def test_no_word_over_a_column_is_broken_and_a_long_name_hangs(truck):
    lines = list(terminal.approval(truck, helps=(), states=True, say=Language("pt"), width=80))
    assert any("sobrecarga" in line for line in lines)
    at = next(k for k, line in enumerate(lines) if line == "Torque alternado na junta")
    assert lines[at + 1] == "  sobre a sua resistência à"


# ------------------------------------------------------------------ signs

HYPHENED = re.compile(r"(?<![\w.,])-\s?[\d∞]")
"""A number below nothing, written with a hyphen."""


@pytest.mark.parametrize("code", CODES)
def test_a_page_has_minus_signs_and_a_terminal_hyphens(told, truck, code):
    """On the workbench -5969 N·m stood beside −63 %, in a report -63 % beside −3 in an equation."""
    bare = re.sub(r"<(pre|style|script).*?</\1>", "", page(told[code]), flags=re.DOTALL)
    texts = re.findall(r">([^<]+)<", bare)
    assert [t for t in texts if HYPHENED.search(t)] == []
    assert any(re.search(r"−\d", t) for t in texts)
    printed = "\n".join(terminal.approval(truck, helps=(), states=True, say=Language(code)))
    assert HYPHENED.search(printed)
    assert not re.search(r"−\d", printed)


def test_signs_and_decimals_are_the_languages():
    pt = Language("pt").typeset
    assert [pt.percent(v) for v in (-0.634, -0.0046, -20.0, 0.5)] == [
        "−63 %", "−0,46 %", "< −999 %", "+50 %"
    ]  # fmt: skip
    assert [pt.number(v) for v in (-3.25, float("-inf"))] == ["−3,250", "−∞"]
    assert pt.pointed("12-34 Hz") == "12-34 Hz"  # from, to
    assert [Language("pt").percent(v) for v in (-0.634, -20.0)] == ["-63 %", "< -999 %"]
    assert pt.said(said("the first at {first} s", first="7.5")) == "the first at 7,5 s"
    assert pt.said(said("{channel}: dead", channel="run.2.csv")) == "run.2.csv: dead"
