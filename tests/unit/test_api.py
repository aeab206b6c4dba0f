"""The public face: what `import cardan` costs, asks and shows."""

import json
import re
import subprocess
import sys
from html.parser import HTMLParser

import pytest
from case_selection import select
from repository import ROOT

import cardan
from cardan.application import overrides, reader
from cardan.approval.approval import approve_driveline
from cardan.core.errors import CardanError, DesignError
from cardan.documents import approval_json as contract
from cardan.render.terminal import verdict_lines
from cardan.render.text_layout import without_colours
from cardan.topics.design.presentation import correction_lines

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


def test_import_loads_no_dependency_before_first_use():
    heavy = "{m.partition('.')[0] for m in sys.modules} & {'numpy', 'scipy', 'yaml', 'click'}"
    loaded = "sorted(m for m in sys.modules if m.startswith('cardan'))"
    assert run(f"import cardan, sys; print({heavy}, {loaded})") == (
        "set() ['cardan', 'cardan.core', 'cardan.core.version']"
    )
    # Nor do rooms bring the face along.
    assert (
        run("import cardan.approval.approval, sys; print('cardan.api' in sys.modules)") == "False"
    )


def test_every_public_name_is_importable():
    assert set(dir(cardan)) < set(cardan.__all__)
    assert {"check", "joint", "read", "study"} < set(dir(cardan))
    results = {"Approval", "Joint", "Sweep", "api", "TYPE_CHECKING", "core"}
    assert not results & set(dir(cardan))
    for name in cardan.__all__:
        assert getattr(cardan, name) is not None
    with pytest.raises(AttributeError, match="tubes"):
        _ = cardan.tubes
    face = sys.modules["cardan.api"]
    assert set(face.__all__) == set(cardan.__all__) - {"__version__"}


@pytest.mark.slow
def test_api_check_equals_command_line_check(app, found):
    plain = approve_driveline(app)
    assert found.verdict == plain.verdict == "fail"
    assert found.to_dict() == contract.json_document(plain)
    said = str(found).splitlines()
    assert said[0].startswith("Refuse collector 6x2, three shafts: NOT APPROVED (")
    assert "\x1b" not in str(found)
    coloured = list(verdict_lines(plain))
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


def test_notebook_shows_verdict_and_each_limit(found):
    tags = shown(found._repr_html_())
    said = " ".join(tags.said)
    assert "NOT APPROVED" in said
    assert {"table", "td", "svg"} <= tags.seen
    for text in (
        "Clearance",
        "bump, pulling away in reverse, -7866 N·m, shaft 3",
        "-74 %",
        "Not part of this",
    ):
        assert text in said
    assert not {"script", "link", "img", "style"} & tags.seen


def test_notebook_output_is_readable_on_dark_background(found):
    """They had been black on black: their colours are those of print, and so is what is behind."""
    shown = found._repr_html_()
    assert shown.count("<svg") == shown.count('<div style="background:#fff"><svg') > 0
    colours = re.findall(r'style="[^"]*?(?<!-)color:[^"]*"', shown.split("<svg")[0])
    colours += re.findall(r'<td style="[^"]*;color:[^"]*"', shown)
    assert len(colours) > 5
    assert all("background:#fff" in c for c in colours)


@pytest.mark.slow
def test_notebook_escapes_user_text():
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


def test_data_frame_has_row_for_each_check_evaluated_or_not(found):
    pytest.importorskip("pandas")
    frame = found.to_frame()
    assert len(frame) == found.coverage.total
    assert frame["verdict"].isna().sum() == len(found.coverage.unevaluated) == 10
    counted = frame["verdict"].value_counts()
    assert (counted["fail"], counted["warn"]) == (26, 35)
    row = frame[(frame.quantity == "clearance") & (frame.verdict == "fail")].iloc[0]
    assert (row.state, row.part, row.unit) == ("overload", "shaft 3 to auxiliary beam", "mm")
    assert row.value == pytest.approx(13.681, abs=0.005)
    assert row.limit == 15
    assert row.required
    assert frame[frame.verdict.isna()].needs.map(len).min() > 0


def test_quantity_is_listed_by_line_state_and_part(found):
    peaks = found.quantity("centre_bearing_peak")
    assert len(peaks.values) == 7 * 2
    worst = peaks.worst
    assert (str(worst.when), str(worst.part)) == ("jounce", "centre bearing 2")
    assert worst.value == max(v.value for v in peaks.values) == pytest.approx(8026, rel=0.02)
    document = found.to_dict()["states"]
    for v in peaks.values:
        state = next(s for s in document if s["name"] == v.when.name)
        on_rubber = state["centre_bearings"][v.part.number - 1]["on_rubber"]
        solved = on_rubber.get("at_stop")
        peak = solved["peak_N"][-1] if solved else on_rubber["worst"]["peak_N"]
        if stuck := on_rubber.get("spline_stuck", {}).get("peak"):
            peak = stuck["force_N"]
        assert peak == pytest.approx(v.value)
    assert str(peaks).startswith("Centre bearing, peak force [N]\n  main, full rebound")
    assert str(found.quantity("clearance").worst.part) == "shaft 3 to auxiliary beam"
    with pytest.raises(ValueError, match=r"did you mean joint_angle\?"):
        found.quantity("joint_angel")


@pytest.mark.slow
def test_public_objects_have_a_short_repr(app, found):
    peaks = found.quantity("centre_bearing_peak")
    for shown, first in (
        (app, "Application('Refuse collector 6x2, three shafts', lines=1, states=7"),
        (found, "Refuse collector 6x2, three shafts: NOT APPROVED ("),
        (peaks, "Centre bearing, peak force [N]"),
    ):
        lines = repr(shown).splitlines()
        assert lines[0].startswith(first)
        assert len(lines) <= 5
        assert max(map(len, lines)) < 120
    assert repr(peaks).splitlines()[1] == f"  worst: {peaks.worst}"
    assert "+" in repr(found).splitlines()[-1]
    assert str(found.quantity("joint_fatigue_utilisation")).count("\n") >= 1


def test_plot_returns_drawing_of_a_view(found, tmp_path):
    drawing = found.plot("side")
    assert shown(drawing._repr_html_()).seen >= {"svg", "path"}
    assert drawing.svg in found._repr_html_()
    assert len(repr(drawing)) < 100
    path = drawing.save(tmp_path / "side.svg")
    assert path.read_text(encoding="utf-8") == drawing.svg
    for view in ("top", "yokes", "planes", "phasors"):
        assert found.plot(view, line="main").svg.startswith("<svg")
    with pytest.raises(CardanError, match=r"ends in \.svg; got side\.png"):
        drawing.save(tmp_path / "side.png")
    with pytest.raises(CardanError, match=r"side\.svg"):
        drawing.save(path)  # an existing file stays
    with pytest.raises(ValueError, match="no view sid; did you mean side"):
        found.plot("sid")
    with pytest.raises(ValueError, match="no line man; did you mean main"):
        found.plot(line="man")


def test_quantity_of_another_study_is_available(app):
    found = cardan.stability(app)
    assert found.verdict == "warn"
    assert found.quantity("torsional_resonance").worst is not None
    assert found.to_dict()["verdict"] == "warn"
    assert cardan.check(app, studies=("vibration",)).studies == ("driveline", "vibration")
    with pytest.raises(ValueError, match=r"did you mean vibration\?"):
        cardan.check(app, studies=("vibrations",))


def test_check_accepts_another_limit_profile(app):
    found = cardan.check(app, limits="protractor")
    assert found.application.profile == "protractor"
    assert len(found.checks) < len(cardan.check(app).checks)


def test_changed_value_is_checked_like_a_changed_file(app):
    address = "driveline.shafts[2].tube.wall_mm"
    thinner = cardan.change(app, {address: 2.0})
    assert cardan.addresses(thinner)[address] == 2.0
    shear = [cardan.check(a).quantity("tube_shear_utilisation").worst.value for a in (app, thinner)]
    assert shear[1] > shear[0]


@pytest.mark.slow
@pytest.mark.long
def test_proposals_repr_equals_command_output(app):
    found = cardan.fix(app, count=2)
    assert len(found) == 2
    assert str(found) == without_colours(correction_lines(tuple(found)))
    assert "bearing 2 up 20 mm" in str(found)
    assert found.to_dict()[0]["line"] == "main"


@pytest.mark.slow
def test_study_data_frame_has_row_for_each_variant(app):
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


@pytest.mark.slow
@pytest.mark.parametrize("kind", select(["html", "pdf", "xlsx", "json"], "pdf", "xlsx", "json"))
def test_report_format_follows_file_extension(found, kind, tmp_path):
    pytest.importorskip({"html": "jinja2", "pdf": "typst", "xlsx": "xlsxwriter"}.get(kind, "json"))
    lang, corrections = ("it", True) if kind == "html" else ("en", False)
    out = found.report(tmp_path / f"truck.{kind}", lang=lang, corrections=corrections)
    assert out.stat().st_size > 1000
    if kind == "json":
        assert json.loads(out.read_text(encoding="utf-8")) == found.to_dict()
    if kind == "html":
        assert 'lang="it"' in out.read_text(encoding="utf-8")


def test_report_with_unknown_extension_is_rejected(found, tmp_path):
    with pytest.raises(CardanError, match=r"truck\.doc"):
        found.report(tmp_path / "truck.doc")


@pytest.mark.slow
def test_report_lists_changed_values(app, tmp_path):
    pytest.importorskip("jinja2")
    address = "driveline.shafts[2].tube.wall_mm"
    changed = cardan.check(cardan.change(app, {address: 3.5}))
    out = changed.report(tmp_path / "truck.html", corrections=False)
    page = out.read_text(encoding="utf-8")
    assert f"# changed: {address}: 3.5" in page
    assert "Corrections over all states were not looked for" in page


def test_impossible_design_is_reported_with_file_and_line(app):
    steep = cardan.change(app, {"suspension.linkage.front_half_length_mm": 120.0})
    with pytest.raises(DesignError, match=r"refuse-collector-6x2\.yaml:\d+:\d+: suspension"):
        cardan.check(steep)


def test_life_accepts_options_of_the_command(tmp_path):
    pytest.importorskip("numba")
    import numpy as np

    t = np.arange(0, 4, 1e-3)
    rows = "\n".join(f"{a:.3f},{100 * np.sin(2 * np.pi * 10 * a):.4f}" for a in t)
    recording = tmp_path / "run.csv"
    recording.write_text(f"time [s],bracket [MPa]\n{rows}\n", encoding="utf-8")
    found = cardan.life(recording, gauges="bracket:MPa", sn=(90, 2e6, 5), residue="repeat")
    assert found.answer.plan.residue_rule.__name__ == "repeating"
    gauge = found.to_dict()["gauges"][0]
    assert gauge["high_MPa"] == pytest.approx(100, abs=0.1)
    assert found.verdict is None
    assert "run.csv: " in repr(found)
    with pytest.raises(CardanError, match="residues; did you mean residue"):
        cardan.life(recording, gauges="bracket:MPa", sn=(90, 2e6, 5), residues="repeat")


def test_api_functions_are_those_of_the_modules():
    assert cardan.read is reader.read
    assert cardan.change is overrides.change
