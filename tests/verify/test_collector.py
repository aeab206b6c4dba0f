"""Who broke the bracket of the refuse collector? The case from beginning to end, against its truth.

The recordings of `examples/refuse-collector` were made by an engine of another hand
(`collector_day.py`), which also knows what is true: it drove each day again with a line whose
joints shake nothing, and the first one with the rubber that the cure asks for.
"""

import json
import re
import tempfile
from functools import cache
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import cardan
from cardan.application import reader
from cardan.cli import cli
from cardan.documents import approval_report as story
from cardan.model.bracket import StepFileShape
from cardan.physics.signals.operational_modes import identify_operational_modes, order_free_spectra
from cardan.physics.signals.shaft_angle import shaft_angle
from cardan.render.i18n import LANGUAGE_CODES, Translator
from cardan.topics.recording.campaign_study import analyse_campaign
from cardan.topics.recording.identification_presentation import parameter_row

CASE = Path(__file__).parents[2] / "examples" / "refuse-collector"
pytestmark = pytest.mark.filterwarnings("ignore")


def truth(day):
    return json.loads((CASE / f"{day}.truth.json").read_text())


@cache
def mix(campaign):
    return analyse_campaign(CASE / campaign).answer


def heard(campaign):
    return mix(campaign).parts[0][2]


@cache
def without_model():
    """The morning's damage and cause alone: the campaign's file without its identification."""
    text = (CASE / "campaign.yaml").read_text()
    told = text.replace("identify: true", "identify: false")
    assert told != text
    with tempfile.TemporaryDirectory() as folder:
        for name in ("joints.parquet", "application.yaml"):
            Path(folder, name).write_bytes((CASE / name).read_bytes())
        path = Path(folder, "campaign.yaml")
        path.write_text(told)
        return analyse_campaign(path).answer.parts[0][2]


# ----------------------------------------------------------- 1, 2: what the drawing says


def test_refuse_collector_passes_standard_check():
    assert cardan.check(cardan.read(CASE / "standard.yaml")).verdict == "pass"


def test_refuse_collector_on_rubber_fails_in_first_gear():
    found = cardan.check(cardan.read(CASE / "application.yaml"))
    assert found.verdict == "fail"
    failed = [c for c in found.checks if c.grade == "fail"]
    assert {c.quantity for c in failed} == {"centre_bearing_dynamic", "centre_bearing_peak"}
    # The first bearing's is of a spline that slides under its thrust, at a lower speed.
    worst = min((c for c in failed if c.part.number == 2), key=lambda c: c.margin)
    assert worst.point.gear == "1"
    assert worst.point.direction == "drive"
    # As much as the tyres hold of the 3707 N m that first gear has.
    assert worst.point.torque == pytest.approx(3370, rel=0.01)
    # Order 2 at 220 rpm is the sideways mode, 7.3 Hz; the stop takes its crest to 1.22 of that.
    assert worst.point.speed * 30 / np.pi == pytest.approx(269, rel=0.04)
    assert worst.mode is None  # modes are of linear rubber
    speed = worst.point.speed * 30 / np.pi
    for name, point in (("case", "."), ("case.pt", ",")):
        page = (CASE.parents[1] / "docs" / f"{name}.md").read_text(encoding="utf-8")
        (row,) = re.findall(
            r"\| ([\d.,]+) kN [^|]* 20 (?:times|vezes) [^|]*\|[^|]* (\d+) rpm", page
        )
        assert row == (f"{worst.value / 1e3:.2f}".replace(".", point), f"{speed:.0f}"), name


# ----------------------------------------------------------- 3: damage, life, peaks, cause


@pytest.mark.slow
def test_damage_life_and_peaks_are_within_5_percent_of_truth():
    known = truth("joints")["gauges"]
    for one in without_model().lives:
        true = known[one.name]
        assert one.life.damage == pytest.approx(true["damage"], rel=0.05), one.name
        assert one.life.hours == pytest.approx(true["hours"], rel=0.05), one.name
        assert one.min_stress / 1e6 == pytest.approx(true["low_MPa"], rel=0.05, abs=1), one.name
        assert one.max_stress / 1e6 == pytest.approx(true["high_MPa"], rel=0.05, abs=1), one.name


@pytest.mark.slow
def test_faulty_stretches_are_named():
    spoiled = truth("joints")["spoiled_s"]
    health = {one.name: one.channel_reports[one.name] for one in without_model().lives}
    faults = {name: of.faults for name, of in health.items()}
    assert not faults["S1"]
    assert health["S3"].drift == pytest.approx(900 * (1 - np.exp(-2.5)), rel=0.2)
    for name, kind in (("S2", "spike"), ("S4", "dropout")):
        starts = faults[name][kind].runs[:, 0] / 1000
        first, last = spoiled[name][0][0], spoiled[name][-1][1]
        assert starts.min() == pytest.approx(first, abs=0.01)
        assert starts.max() <= last + 0.01
    assert faults["S2"]["spike"].count == 14
    assert faults["S4"]["dropout"].count == 5


@pytest.mark.slow
def test_joints_dominate_and_interval_holds_truth():
    known, causes = truth("joints")["gauges"], without_model().causes
    assert causes.gauges == ("S1", "S2", "S3", "S4")
    for name, found in zip(causes.gauges, causes.joint_attributions, strict=True):
        low, high = found.interval
        assert found.verdict == "joints dominate", name
        assert low <= known[name]["removed"] <= high, name


@pytest.mark.slow
@pytest.mark.parametrize(
    ("campaign", "day", "said"),
    [("tracks.yaml", "road", "joints do not dominate"), ("direct.yaml", "engine", "undetermined")],
)
def test_finding_on_days_with_other_causes_matches_truth(campaign, day, said):
    known, causes = truth(day)["gauges"], heard(campaign).causes
    for name, found in zip(causes.gauges, causes.joint_attributions, strict=True):
        low, high = found.interval
        assert found.verdict == said, (name, found.interval)
        assert low <= known[name]["removed"] <= high, name


# ----------------------------------------------------------- 4: what is otherwise than drawn


@pytest.mark.slow
@pytest.mark.long
def test_deviations_of_vehicle_from_file_are_identified():
    known = truth("joints")["parameters"]
    found = {(p.name, p.part.number): p for p in heard("promise.yaml").identification.parameters}
    outside = 0
    for bearing in (1, 2):
        for way in ("vertical", "lateral"):
            p = found[way, bearing]
            true = known[f"{way}_{bearing}_N_mm"]
            low, high = p.in_display_unit(p.low), p.in_display_unit(p.high)
            outside += not low <= true <= high
            assert 0.99 * low <= true <= 1.01 * high, (way, bearing, p)
    # Of ten that are to hold nine in ten: the page says which.
    assert outside <= 1
    # What explains the rest as well is no mode: no order reaches 206 Hz.
    assert not {name for name, _ in found} & {"mode", "mode damping"}
    # Rubber of 200 and 100 N/mm is contradicted at the bearing whose force is felt.
    assert found["vertical", 2].contradicts_file
    assert found["lateral", 2].contradicts_file
    p = found["unbalance", 2]
    assert p.in_display_unit(p.low) <= known["unbalance_2_g_mm"] <= p.in_display_unit(p.high)
    for shaft in (1, 2, 3):
        p = found["phase", shaft]
        true = known["phase_2_deg"] if shaft == 2 else 0.0
        assert p.in_display_unit(p.low) <= true <= p.in_display_unit(p.high), p
    before, after = heard("promise.yaml").identification.misfit
    assert after < 0.07 < 0.15 < before  # what is left is the road


@pytest.mark.long
@pytest.mark.parametrize(("vertical", "lateral"), [(300, 80), (90, 50)])
def test_rubber_stiffness_is_identified_from_wrong_start_values(tmp_path, vertical, lateral):
    """Least squares from the file ended elsewhere, and told it surely: 353 for 163, 22 for 92."""
    known = truth("joints")["parameters"]
    asked = (CASE / "promise.yaml").read_text().replace("changed: cured.yaml\n", "")
    (tmp_path / "promise.yaml").write_text(asked)
    (tmp_path / "joints.parquet").write_bytes((CASE / "joints.parquet").read_bytes())
    rubber = "vertical_stiffness_N_mm: {}, lateral_stiffness_N_mm: {}"
    file = (CASE / "application.yaml").read_text()
    assert file.count(rubber.format(200, 100)) == 2
    written = file.replace(rubber.format(200, 100), rubber.format(vertical, lateral))
    (tmp_path / "application.yaml").write_text(written)
    found = analyse_campaign(tmp_path / "promise.yaml").answer.parts[0][2].identification
    numbers = {(p.name, p.part.number): p for p in found.parameters}
    for bearing in (1, 2):
        for way in ("vertical", "lateral"):
            p, true = numbers[way, bearing], known[f"{way}_{bearing}_N_mm"]
            assert p.identifiable
            # To a last per cent: 91.6 and 92.0.
            assert 0.99 * p.in_display_unit(p.low) <= true <= 1.01 * p.in_display_unit(p.high), (
                way,
                p,
            )


@pytest.mark.slow
def test_case_study_pages_state_identified_values():
    found = heard("promise.yaml").identification
    for name, code, to in (("case", "en", "to"), ("case.pt", "pt", "a")):
        page = (CASE.parents[1] / "docs" / f"{name}.md").read_text()
        assert_page_states(page, found, to=to, say=Translator(code))


def assert_page_states(page, found, *, to, say):
    """Every number that the page's fourth section has of the recording."""

    def states(low, high, atol=0.0):
        """A range of the page is this one, to half a per cent: a minimiser's last digit moves."""
        return any(np.allclose(r, (low, high), rtol=5e-3, atol=atol) for r in ranges)

    number = r"(-?\d+(?:[.,]\d+)?)"
    read = [
        (pair.start(), tuple(float(x.replace(",", ".")) for x in pair.groups()))
        for pair in re.finditer(f"{number} {to} {number}", page)
    ]
    ranges = [values for _, values in read]
    welds = next(p for p in found.parameters if (p.name, p.part.number) == ("phase", 2))
    bounds = welds.in_display_unit(welds.low), welds.in_display_unit(welds.high)
    at = next(at for at, values in read if np.allclose(values, bounds, atol=0.05))
    sentence = page[page.rindex(":", 0, at) : page.index(". ", at)]
    turned = [float(x.replace(",", ".")) for x in re.findall(number, sentence)]
    for p in found.parameters:
        shown = p.name in ("vertical", "lateral", "unbalance")
        low, value, high = (p.in_display_unit(v) for v in (p.low, p.value, p.high))
        if shown or (p.name, p.part.number) in (("loss", 2), ("phase", 2)):
            # Of an angle known to 3 degrees, a twentieth of a degree.
            assert states(low, high, atol=0.05 if p.name == "phase" else 0.0), p
        if p.name == "phase":
            assert np.min(np.abs(np.array(turned) - value)) < 0.05
            # The width is what is assumed of welds more than what the recording says.
            assert p.identifiable == (p.part.number == 1)
            assert p.assumed != p.identifiable
            *_, remark = parameter_row(p, say)
            assert (f"*{remark}*" in page) == (p.part.number == 2)
    (mode,) = found.operational_modes
    assert states(mode.frequency[0], mode.frequency[2])
    assert states(mode.damping[0], mode.damping[2])
    for share in found.misfit:
        assert f"{100 * share:.0f} %" in page


@pytest.mark.slow
def test_gauge_sensitivities_match_calculix():
    """Sideways to 3.5 %, by CalculiX, whose gauges the recording is of; the file is up to 6 % off.

    A gain goes with how soft the bearings are, whose intervals are 5 % to either side.
    """
    from collector_bracket import TABLE

    strain, of = json.loads(TABLE.read_text())["strain_per_N"], heard("promise.yaml").identification
    true = 210e9 * np.array([strain[name][1] for name in ("S1", "S2", "S3")])
    np.testing.assert_allclose(of.unit_stress[:3, 1], true, rtol=0.035)


@pytest.mark.slow
def test_bracket_mode_is_identified_from_road_excitation():
    known, found = truth("joints")["parameters"], heard("promise.yaml").identification
    (mode,) = found.operational_modes
    assert mode.frequency[0] <= known["bracket_mode_Hz"] <= mode.frequency[2]
    assert mode.damping[0] <= known["bracket_mode_damping"] <= mode.damping[2]
    assert mode.frequency[2] < 1.04 * mode.frequency[0]
    # Three gauges feel it as they feel a force sideways; the fourth has it next to not at all.
    assert mode.felt_by_gauge == (True, True, True, False)
    assert found.force_direction(mode) == 1
    assert found.line_frequency(mode) is None


@pytest.mark.slow
@pytest.mark.parametrize(("day", "orders"), [("road", (3, 6)), ("engine", (2, 4))])
def test_bracket_mode_is_equal_on_another_day(day, orders):
    """Bad tracks shake it, and an engine runs through it: the same truck, the same mode."""
    import pyarrow.parquet as pq

    table, known = pq.read_table(CASE / f"{day}.parquet"), truth("joints")["parameters"]
    stress = np.stack([table[n].to_numpy().astype(float) for n in ("S1", "S3")])
    shaft, engine = (
        shaft_angle(table[n].to_numpy() / 60.0, rate=1000.0) for n in ("shaft_rpm", "engine_rpm")
    )
    (mode,) = identify_operational_modes(
        order_free_spectra(
            [stress], rate=1000.0, seconds=stress.shape[1] / 1000, angle=shaft,
            engine=engine.rotation, engine_orders=orders,
        )
    )  # fmt: skip
    assert mode.frequency[0] <= known["bracket_mode_Hz"] <= mode.frequency[2]
    assert mode.damping[0] <= known["bracket_mode_damping"] <= mode.damping[2]
    assert mode.felt_by_gauge == (True, True)


# ----------------------------------------------------------- 6: the cure keeps its promise


@pytest.mark.slow
def test_correction_achieves_predicted_life():
    known = truth("joints")["cured"]["gauges"]
    for one in heard("promise.yaml").predicted_lives:
        true = known[one.gauge]["hours"]
        assert true / 2 <= one.changed.hours <= 2 * true, (one.gauge, one.changed.hours, true)
        assert one.changed.hours > 1.3 * one.recorded.hours


def test_corrected_line_passes_every_limit_if_its_rubber_has_the_travel():
    """With a stop at 15 mm, assumed where none is given, its bearing goes against it."""
    as_shipped = cardan.check(reader.read(CASE / "cured.yaml"))
    failed = {c.quantity for c in as_shipped.checks if c.grade == "fail"}
    assert failed == {"centre_bearing_dynamic", "centre_bearing_peak"}
    force = max(c.value for c in as_shipped.checks if c.quantity == "centre_bearing_dynamic")
    for name, stated in (("case", f"to {force / 1e3:.1f} kN"),
                         ("case.pt", f"para {force / 1e3:.1f} kN".replace(".", ","))):  # fmt: skip
        assert stated in (CASE.parents[1] / "docs" / f"{name}.md").read_text(encoding="utf-8")
    text = (CASE / "cured.yaml").read_text(encoding="utf-8")
    assert text.count("from_rear_joint_mm") == 2
    free = text.replace("from_rear_joint_mm", "travel_mm: 35, from_rear_joint_mm")
    assert cardan.check(reader.loads(free, folder=CASE)).verdict == "warn"


# ----------------------------------------------------------- 7: the report to sign


def remembered(function):
    """Return a function that is asked once."""
    kept = []

    def answer(*args, **how):
        if not kept:
            kept.append(function(*args, **how))
        return kept[0]

    return answer


@pytest.mark.bracket
@pytest.mark.slow
@pytest.mark.long
def test_report_has_ten_pages_in_every_language(tmp_path, monkeypatch):
    """The command as documented; what is not words is asked for once."""
    command = import_module("cardan.cli.check")
    for module, name in (
        (command, "approve_file"), (story, "check_sensitivities"), (story, "find_corrections")
    ):  # fmt: skip
        monkeypatch.setattr(module, name, remembered(getattr(module, name)))
    monkeypatch.chdir(CASE)
    asked = "check application.yaml --with bracket --recording promise.yaml --short"
    for code in LANGUAGE_CODES:
        out = tmp_path / f"{code}.pdf"
        result = CliRunner().invoke(cli, [*asked.split(), "--lang", code, "--pdf", str(out)])
        assert result.exit_code == 1, result.output
        assert Translator(code)("mode that road and engine shake") in result.output
        (count,) = re.findall(rb"/Type/Pages/Count (\d+)", out.read_bytes())
        assert 6 <= int(count) <= 10, (code, count)


# ----------------------------------------------------------- the world itself


@pytest.mark.oracle
def test_multibody_bracket_mode_matches_truth():
    pytest.importorskip("exudyn")
    from collector_day import bracket_mode

    known = truth("joints")["parameters"]
    hertz, damping = bracket_mode()
    assert hertz == pytest.approx(known["bracket_mode_Hz"], rel=1e-4)
    assert damping == pytest.approx(known["bracket_mode_damping"], rel=1e-3)


@pytest.mark.oracle
def test_multibody_drive_matches_recorded_stress():
    pytest.importorskip("exudyn")
    import pyarrow.parquet as pq
    from collector_day import DAYS, drive, strains

    day = DAYS["joints"]
    felt = strains(drive(day, seconds=8), day.gauges)[:, 1::2]
    table = pq.read_table(CASE / "joints.parquet")
    for name, true in zip(("S1", "S4"), felt[[0, 3]], strict=True):
        written = table[name].to_numpy()[: true.size]
        assert np.std(written - true) < 1.3  # the amplifier's noise and digit
        assert np.std(true) > 20


@pytest.mark.oracle
@pytest.mark.bracket
def test_calculix_reproduces_strain_table():
    from collector_bracket import TABLE, solved

    table, again = json.loads(TABLE.read_text()), solved(size=3.5e-3)
    np.testing.assert_allclose(again["compliance_m_N"], table["compliance_m_N"], rtol=1e-3)
    for name in ("S1", "S2", "S3"):
        assert again["strain_per_N"][name][1] == pytest.approx(
            table["strain_per_N"][name][1], rel=1e-3
        )


def test_bracket_from_cad_differs_only_in_shape():
    drawn, sent = (reader.read(CASE / name) for name in ("application.yaml", "from-step.yaml"))
    assert isinstance(sent.bracket.shape, StepFileShape)
    assert sent.bracket.material == drawn.bracket.material
    assert sent.bracket.gauges == drawn.bracket.gauges
    assert sent.bracket.fatigue == drawn.bracket.fatigue
    line = [
        (CASE / name).read_text().partition("title:")[2].partition("bracket:")[0]
        for name in ("application.yaml", "from-step.yaml")
    ]
    assert line[0] == line[1] != ""


@pytest.mark.bracket
def test_step_file_holds_drawn_shape():
    """As `cardan bracket application.yaml --step bracket.step` writes it, face by face."""
    from cardan.physics.fem.geometry import build_solid

    drawn, sent = (
        build_solid(reader.read(CASE / name).bracket.shape)
        for name in ("application.yaml", "from-step.yaml")
    )
    assert sent.volume == pytest.approx(drawn.volume, rel=1e-9)
    areas = [{}, {}]
    for of, into in zip((drawn, sent), areas, strict=True):
        for face in of.shape.faces:
            into[face.name] = into.get(face.name, 0.0) + face.mass
    for name in ("seat", *(f"bolt {k}" for k in range(1, 5))):
        assert areas[1][name] == pytest.approx(areas[0][name], rel=1e-9)
    assert (CASE / "bracket.step").stat().st_size < 300e3


@pytest.mark.bracket
@pytest.mark.long
def test_crack_site_has_shortest_life(tmp_path):
    """Life from the force on the bearing that the recording says, on the flange that is worse."""
    from cardan.topics.bracket.assessment import analyse_bracket
    from cardan.topics.recording.study import recorded_bearing_force

    of = heard("promise.yaml")
    time, force = recorded_bearing_force(mix("promise.yaml").options, of)
    rows = np.column_stack([time, force])
    np.savetxt(tmp_path / "b.csv", rows, "%.7g", ",", header="time_s,x_N,y_N,z_N", comments="")
    text = of.identification.file_text().replace(
        "  fatigue:", "  recordings: [{name: morning, file: b.csv, from_gauges: true}]\n  fatigue:"
    )
    (tmp_path / "a.yaml").write_text(text)
    judged = analyse_bracket(reader.read(tmp_path / "a.yaml")).variants[0]
    (outcome,) = [o for o in judged.case_results if o.case.when.name == "morning"]
    known, lives = truth("joints")["crack"], [
        outcome.damage_result.at_spots([k]) for k in range(len(judged.features))
    ]  # fmt: skip
    true = np.array(known["place_mm"])
    # Both legs are alike: the bend, on one side or the other, and where along it.
    off = [np.abs(1e3 * np.abs(f.point) - np.abs(true)) for f in judged.features]
    bend = [k for k, one in enumerate(off) if (one < (20, 4, 4)).all()]
    hours = min(lives[k].hours_to_failure for k in bend)
    assert known["hours"] / 2 <= hours <= 2 * known["hours"]
    assert hours == pytest.approx(told(r"upper bend, ([\d ]+) hours")[0], rel=1 / 3)
    # Its end, a line where the flat sheet begins, may be told less by 2 % of stress, not surely.
    assert outcome.damage_result.hours_to_failure > hours / 1.02**9
    assert int(np.argmin([life.hours_bounds[1] for life in lives])) in bend


@pytest.mark.bracket
@pytest.mark.long
def test_predicted_life_of_bend_matches_page(tmp_path):
    """Step 6: between its hours lie those that CalculiX has under what the engine then drove.

    In the bend of each leg, which are alike; of elements alone one left the truth out. Beside the
    washers nobody knows it.
    """
    from cardan.topics.bracket.assessment import analyse_bracket

    asked = ["life", str(CASE / "promise.yaml"), "--changed-history", str(tmp_path / "cured.csv")]
    CliRunner().invoke(cli, asked)
    text = (CASE / "cured.yaml").read_text().replace(
        "  fatigue:",
        "  recordings: [{name: promised, file: cured.csv, from_gauges: true}]\n  fatigue:",
    )  # fmt: skip
    (tmp_path / "a.yaml").write_text(text)
    judged = analyse_bracket(reader.read(tmp_path / "a.yaml")).variants[0]
    (life,) = [o.damage_result for o in judged.case_results if o.case.when.name == "promised"]
    hours, low, high, true = told(
        r"promised ([\d ]+) hours, between ([\d ]+) and ([\d ]+), and has ([\d ]+)\."
    )
    _, y, z = truth("joints")["cured"]["crack"]["place_mm"]
    at = [1e3 * np.array(f.point) for f in judged.features]
    bend = [k for k, p in enumerate(at) if abs(abs(p[1]) - y) < 4 and abs(p[2] - z) < 4]
    legs = [life.at_spots([k]) for k in sorted(bend, key=lambda k: -life.hot_spot_damage[k])[:2]]
    assert min(leg.hours_to_failure for leg in legs) == pytest.approx(hours, rel=1 / 3)
    ends = np.array([leg.hours_bounds for leg in legs])
    assert (ends.min(), ends.max()) == pytest.approx((low, high), rel=1 / 3)
    assert life.hours_to_failure == pytest.approx(hours, rel=1 / 3)  # nowhere less
    assert all(one < true < other for one, other in ends)


def told(sentence):
    """Return the numbers that a sentence of the page has, its spaces for thousands left out."""
    found = re.search(sentence, (CASE.parents[1] / "docs/case.md").read_text(encoding="utf-8"))
    return [float(number.replace(" ", "")) for number in found.groups()]


@pytest.mark.bracket
@pytest.mark.long
def test_lightest_sheet_matches_page():
    """Step 6: sizes and masses as told, lives to a third; they were a fifth of that, unnoticed."""
    from cardan.topics.bracket.optimisation import find_lightest_bracket

    thick, heavy, light, *lives = told(
        r"is (\d+) mm: ([\d.]+) kg for ([\d.]+), ([\d ]+) hours for ([\d ]+) \("
    )
    searched = find_lightest_bracket(reader.read(CASE / "cured.yaml"))
    # By the first mesh, then by finer ones: by its error it might have lived long enough.
    *_, drawn = (one for one in searched.evaluated if one.sizes["thickness"] == pytest.approx(5e-3))
    assert searched.best.sizes["thickness"] == pytest.approx(thick / 1e3)
    assert [searched.best.mass, drawn.mass] == pytest.approx([heavy, light], abs=6e-4)
    assert [searched.best.life, drawn.life] == pytest.approx(lives, rel=1 / 3)
