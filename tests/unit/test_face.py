"""The public face: what `import cardan` costs, asks and shows."""

import json
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest
from chief import chief

import cardan
from cardan import files
from cardan.base.errors import CardanError, DesignError
from cardan.report import contract, terminal
from cardan.study.approval import assess

ROOT = Path(__file__).parents[2]
TRUCK = ROOT / "examples" / "refuse-collector-6x2.yaml"


@pytest.fixture(scope="module")
def app():
    return cardan.read(TRUCK)


@pytest.fixture(scope="module")
def found(app):
    return cardan.check(app)


def run(code: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT
    )
    return done.stdout.strip()


def test_importing_costs_nothing_until_something_is_asked_for():
    heavy = "{m.partition('.')[0] for m in sys.modules} & {'numpy', 'scipy', 'yaml', 'click'}"
    loaded = "sorted(m for m in sys.modules if m.startswith('cardan'))"
    assert run(f"import cardan, sys; print({heavy}, {loaded})") == "set() ['cardan']"
    # Nor do rooms bring the face along.
    assert run("import cardan.study.approval, sys; print('cardan.face' in sys.modules)") == "False"


@pytest.mark.slow
@pytest.mark.parametrize(
    "first", ["import cardan.study.fix, cardan.loads, cardan.bracket.gauges", "pass"]
)
def test_rooms_are_asked_by_their_names_whoever_came_first(first):
    code = f"import cardan; {first}; app = cardan.loads(open({str(TRUCK)!r}).read()); "
    code += "print(cardan.study(app, {'axle.ratio': [5, 6]}, n=4).count)"
    code += "; from cardan.study.fix import fix; import cardan.study"
    code += "; print(cardan.study.fix.fix is fix)"
    assert run(code).split() == ["4", "True"]


def test_every_public_name_is_there():
    assert set(cardan.__all__) <= set(dir(cardan))
    for name in cardan.__all__:
        assert getattr(cardan, name) is not None
    with pytest.raises(AttributeError, match="tubes"):
        _ = cardan.tubes
    face = sys.modules["cardan.face"]
    assert set(face.__all__) == set(cardan.__all__) - {"__version__"}


def test_a_check_is_the_approval_of_all_media(app, found):
    plain = assess(app)
    assert found.verdict == plain.verdict == "fail"
    assert found.to_dict() == contract.approval(plain)
    said = repr(found).splitlines()
    assert said[0].startswith("Refuse collector 6x2, three shafts: FAIL (")
    assert "\x1b" not in repr(found)
    coloured = list(terminal.verdict(plain))
    assert len(said) == len(coloured)
    assert found.coverage == plain.coverage


class Tags(HTMLParser):
    """Counts what is open, and keeps what is said."""

    def __init__(self):
        super().__init__()
        self.open, self.seen, self.said = [], set(), []

    def handle_starttag(self, tag, _):
        self.open.append(tag)
        self.seen.add(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.said.append(data)


def shown(html: str) -> Tags:
    tags = Tags()
    tags.feed(html)
    assert tags.open == []
    return tags


def test_a_notebook_shows_the_verdict_and_each_limit(found):
    tags = shown(found._repr_html_())
    said = " ".join(tags.said)
    assert "FAIL" in said
    assert {"table", "td", "svg"} <= tags.seen
    for text in (
        "Clearance",
        "jounce, pulling away in reverse, -7866 N·m, shaft 3",
        "-74 %",
        "Not part of this",
    ):
        assert text in said
    assert not {"script", "link", "img", "style"} & tags.seen


def test_figures_and_grades_are_read_in_a_dark_notebook_too(found):
    """They had been black on black: their colours are those of print, and so is what is behind."""
    shown = found._repr_html_()
    assert shown.count("<svg") == shown.count('<div style="background:#fff"><svg') > 0
    colours = re.findall(r'style="[^"]*?(?<!-)color:[^"]*"', shown.split("<svg")[0])
    colours += re.findall(r'<td style="[^"]*;color:[^"]*"', shown)
    assert len(colours) > 5
    assert all("background:#fff" in c for c in colours)


@pytest.mark.slow
def test_what_a_user_wrote_is_text_in_a_notebook():
    evil = '<script>alert("&")</script>'
    text = TRUCK.read_text(encoding="utf-8")
    text = text.replace("title: Refuse collector 6x2, three shafts", f"title: '{evil}'")
    text = text.replace("name: auxiliary beam", f"name: '{evil}'")
    app = cardan.loads(text)
    for thing in (
        cardan.check(app), cardan.fix(app, count=1, hold=["bearing_height"]),
        cardan.study(app, {"axle.ratio": [5, 6]}, n=4),
    ):  # fmt: skip
        html = thing._repr_html_()
        assert "<script" not in html
        assert "script" not in shown(html).seen
        assert evil in "".join(shown(html).said)


def test_a_frame_has_a_row_for_each_check_and_each_that_has_no_answer(found):
    pytest.importorskip("pandas")
    frame = found.to_frame()
    assert len(frame) == found.coverage.asked
    assert frame["verdict"].isna().sum() == len(found.coverage.unanswered) == 10
    counted = frame["verdict"].value_counts()
    assert (counted["fail"], counted["warn"]) == (17, 40)
    row = frame[(frame.quantity == "clearance") & (frame.verdict == "fail")].iloc[0]
    assert (row.state, row.part, row.unit) == ("overload", "shaft 3 to auxiliary beam", "mm")
    assert row.value == pytest.approx(13.681, abs=0.005)
    assert row.limit == 15
    assert row.required
    assert frame[frame.verdict.isna()].needs.map(len).min() > 0


def test_a_quantity_by_line_state_and_part(found):
    peaks = found.quantity("centre_bearing_peak")
    assert len(peaks.values) == 7 * 2
    worst = peaks.worst
    assert (str(worst.when), str(worst.part)) == ("jounce", "centre bearing 2")
    assert worst.value == max(v.value for v in peaks.values) == pytest.approx(5523, abs=0.5)
    document = found.to_dict()["states"]
    for v in peaks.values:
        state = next(s for s in document if s["name"] == v.when.name)
        worst_there = state["centre_bearings"][v.part.number - 1]["on_rubber"]["worst"]
        assert worst_there["peak_N"] == pytest.approx(v.value)
    assert repr(peaks).startswith("Centre bearing, peak force [N]\n  main, full rebound")
    assert str(found.quantity("clearance").worst.part) == "shaft 3 to auxiliary beam"
    with pytest.raises(ValueError, match=r"did you mean joint_angle\?"):
        found.quantity("joint_angel")


@pytest.mark.slow
def test_quantities_of_other_studies_are_those_they_checked(app):
    found = cardan.stability(app)
    assert found.verdict == "warn"
    assert found.quantity("torsional_resonance").worst is not None
    assert found.to_dict()["verdict"] == "warn"
    assert cardan.check(app, studies=("vibration",)).studies == ("driveline", "vibration")
    with pytest.raises(ValueError, match=r"did you mean vibration\?"):
        cardan.check(app, studies=("vibrations",))


def test_other_limits(app):
    found = cardan.check(app, limits="protractor")
    assert found.application.profile == "protractor"
    assert len(found.checks) < len(cardan.check(app).checks)


def test_a_changed_number_is_checked_as_a_file_with_it(app):
    address = "driveline.shafts[2].tube.wall_mm"
    thinner = cardan.change(app, {address: 2.0})
    assert cardan.addresses(thinner)[address] == 2.0
    shear = [cardan.check(a).quantity("tube_shear_utilisation").worst.value for a in (app, thinner)]
    assert shear[1] > shear[0]


@pytest.mark.slow
def test_proposals_read_as_the_command_prints_them(app):
    found = cardan.fix(app, count=2)
    assert len(found) == 2
    assert repr(found) == terminal.bare(terminal.proposals(tuple(found)))
    assert "bearing 2 up 20 mm" in repr(found)
    assert found.to_dict()[0]["line"] == "main"


def test_a_study_has_a_row_for_each_variant(app):
    pd = pytest.importorskip("pandas")
    found = cardan.study(app, {"shim_deg": [-1, 2], "axle.ratio": {"choice": [5.0, 6.0]}}, n=32)
    frame = found.to_frame()
    assert len(frame) == 32
    assert set(frame["axle.ratio"]) == {5.0, 6.0}
    assert list(frame["verdict"]) == list(found.verdicts)
    assert frame["clearance"].max() < 100  # mm, as people read it
    margins = frame.filter(regex=" margin$")
    assert (margins.min(axis=1) <= frame["margin"]).all()  # a warning may lie below a failure
    assert margins.eq(frame["margin"], axis=0).any(axis=1).all()
    assert isinstance(frame["verdict"].dtype, pd.CategoricalDtype)
    assert "32 variants" in repr(found)
    assert "\x1b" not in repr(found)


@pytest.mark.parametrize("kind", chief(["html", "pdf", "xlsx", "json"], "pdf", "xlsx", "json"))
def test_reports_by_the_ending_of_their_name(found, kind, tmp_path):
    pytest.importorskip({"html": "jinja2", "pdf": "typst", "xlsx": "xlsxwriter"}.get(kind, "json"))
    lang, corrections = ("it", True) if kind == "html" else ("en", False)
    out = found.report(tmp_path / f"truck.{kind}", lang=lang, corrections=corrections)
    assert out.stat().st_size > 1000
    if kind == "json":
        assert json.loads(out.read_text(encoding="utf-8")) == found.to_dict()
    if kind == "html":
        assert 'lang="it"' in out.read_text(encoding="utf-8")


def test_a_report_of_no_known_kind(found, tmp_path):
    with pytest.raises(CardanError, match=r"truck\.doc"):
        found.report(tmp_path / "truck.doc")


def test_a_report_says_what_was_changed_in_its_file(app, tmp_path):
    pytest.importorskip("jinja2")
    address = "driveline.shafts[2].tube.wall_mm"
    changed = cardan.check(cardan.change(app, {address: 3.5}))
    out = changed.report(tmp_path / "truck.html", corrections=False)
    page = out.read_text(encoding="utf-8")
    assert f"# changed: {address}: 3.5" in page
    assert "Corrections over all states were not looked for" in page


def test_what_cannot_exist_is_told_where_it_stands(app):
    steep = cardan.change(app, {"suspension.linkage.front_half_length_mm": 120.0})
    with pytest.raises(DesignError, match=r"refuse-collector-6x2\.yaml:\d+:\d+: suspension"):
        cardan.check(steep)


def test_a_recording_takes_the_options_of_the_command(tmp_path):
    pytest.importorskip("numba")
    import numpy as np

    t = np.arange(0, 4, 1e-3)
    rows = "\n".join(f"{a:.3f},{100 * np.sin(2 * np.pi * 10 * a):.4f}" for a in t)
    recording = tmp_path / "run.csv"
    recording.write_text(f"time [s],bracket [MPa]\n{rows}\n", encoding="utf-8")
    found = cardan.life(recording, gauges="bracket:MPa", sn=(90, 2e6, 5), residue="repeat")
    assert found.answer.plan.rule.__name__ == "repeating"
    gauge = found.to_dict()["gauges"][0]
    assert gauge["high_MPa"] == pytest.approx(100, abs=0.1)
    assert found.verdict is None
    assert "run.csv: " in repr(found)
    with pytest.raises(CardanError, match="residues; did you mean residue"):
        cardan.life(recording, gauges="bracket:MPa", sn=(90, 2e6, 5), residues="repeat")


def test_the_same_names_as_in_files():
    assert cardan.read is files.read
    assert cardan.change is files.change
