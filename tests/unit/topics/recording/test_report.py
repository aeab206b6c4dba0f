"""A recording's report: the same numbers on every medium, in every language."""

import json
import shutil
import subprocess
from dataclasses import replace
from hashlib import sha256
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

from cardan.cli.life import life as command
from cardan.core.labels import Part
from cardan.core.units import MPa
from cardan.physics.fatigue.mean_stress import fkm, goodman, uncorrected
from cardan.physics.signals import attribution_result as evidence
from cardan.physics.signals.faults.registry import FAULT_KINDS
from cardan.physics.signals.order_cuts import order_windows
from cardan.physics.signals.order_tracking import ShaftRotation
from cardan.physics.signals.recording import recording_from_arrays
from cardan.physics.signals.spectrograms import order_maps, spectrograms
from cardan.physics.signals.synthetic import GaugeStressPerCause, synthetic_recording
from cardan.render.blocks import (
    Chapter,
    Figures,
    Picture,
    ReportDateAndSourceStamp,
    ReportDocument,
    Table,
    Text,
)
from cardan.render.html import html_page
from cardan.render.i18n import LANGUAGE_CODES, Translator, message_catalogue
from cardan.render.pdf import pdf_document
from cardan.topics.recording import alternative_life_presentation as otherwise
from cardan.topics.recording import finding_phrases as phrases
from cardan.topics.recording import gauge_consistency as agreement
from cardan.topics.recording import json_presentation
from cardan.topics.recording import method_presentation as counting
from cardan.topics.recording import presentation as recorded
from cardan.topics.recording import report as recording_story
from cardan.topics.recording.alternative_life_models import AlternativeLives
from cardan.topics.recording.chapter import equal_damage_amplitude_at_mean, order_cut_figures
from cardan.topics.recording.identification_presentation import PARAMETER_TITLES, parameter_row
from cardan.topics.recording.identification_result import IdentifiedParameter
from cardan.topics.recording.options import AnalysisOptions
from cardan.topics.recording.study import RecordingStudy


@pytest.fixture(scope="module")
def found():
    gains = {
        "S1": GaugeStressPerCause(joints=40 * MPa, events=25 * MPa),
        "S<2>": GaugeStressPerCause(joints=3 * MPa),
    }
    drive = synthetic_recording(seconds=60, rate=400.0, gains=gains, seed=5).recording
    campaign = AnalysisOptions.from_values(
        sn=(30, 2e6, 5), gauges=["S1", "S<2>"], speed="shaft_speed", torque="torque",
        mean_stress="goodman", ultimate_MPa=500.0, target_hours=1e5,
    )  # fmt: skip
    return RecordingStudy(campaign, draw=True).run(drive)


def test_unidentifiable_parameter_is_shown_with_interval_only():
    """A weld was "not told", where what was found of it left out what is drawn."""
    deg = np.pi / 180
    turned = IdentifiedParameter(
        name="phase", part=Part("shaft", 2), file_value=0.0, value=5.7 * deg, low=2.6 * deg,
        high=8.8 * deg, identifiable=False, assumed=True, address="phase",
    )  # fmt: skip
    say = Translator("en")
    assert parameter_row(turned, say) == (
        "yoke phase [deg]", "shaft 2", "0", "5.7", "2.6 to 8.8",
        "otherwise than written, but more assumed than measured",
    )  # fmt: skip
    assert not turned.needs_rewrite
    assert not turned.contradicts_file
    *_, said = parameter_row(replace(turned, low=-deg), say)
    assert said == "more assumed than measured"
    assert parameter_row(replace(turned, assumed=False), say)[3:] == (
        "-", "-", "not identified from this recording",
    )  # fmt: skip
    assert parameter_row(replace(turned, identifiable=True), say)[-1] == "otherwise than written"


@pytest.mark.slow
@pytest.mark.parametrize("code", LANGUAGE_CODES)
def test_html_and_pdf_reports_are_complete_in_every_language(found, code, tmp_path):
    say = Translator(code)
    story = recording_story.recording_report(found, say=say, issue=ReportDateAndSourceStamp())
    shown = html_page(story)
    for text in ("Haigh", "S1", "S&lt;2&gt;", say("Gauges"), say("What goes with the joints")):
        assert text in shown
    assert "<2>" not in shown
    hours = say.compact_number(found.answer.lives[0].life.hours, 4)
    assert hours in shown
    pictures = [b for c in story.chapters for b in c.blocks if isinstance(b, Picture)]
    assert [p.title for p in pictures] == [
        say("{gauge} in {recording}", gauge=g, recording=found.answer.recording.name)
        for g in ("S1", "S<2>")
    ]
    drawn = [
        f for c in story.chapters for b in c.blocks if isinstance(b, Figures) for f in b.figures
    ]
    assert sum(say("Order {order}", order=k) in f.title for f in drawn for k in (1, 2, 4)) == 6
    assert story.grade == "fail"
    if code == "en" or not shutil.which("pdftotext"):
        return
    path = tmp_path / "told.pdf"
    path.write_bytes(pdf_document(story))
    read = subprocess.run(["pdftotext", str(path), "-"], capture_output=True, text=True, check=True)
    assert hours in read.stdout
    assert say(found.answer.causes.joint_attributions[0].verdict).upper() in read.stdout


def test_computed_order_is_plotted_per_gauge(found):
    """Twelve series of dots in one picture, two of each colour, told nobody anything."""
    cuts = found.answer.figures.cuts
    names, say = ["S1", "S<2>"], Translator("en")
    assert [f.title for f in order_cut_figures(cuts, names, 2.0, say)] == [
        "Order 2: amplitude", "Order 2: phase",
    ]  # fmt: skip
    half, late = 0.5 * cuts.amplitude[:1], (-0.005, 0.02)
    told = SimpleNamespace(
        gauges=("S1",), cuts=cuts, computed_before=half, computed_after=cuts.amplitude[:1]
    )
    size, phase, *other = order_cut_figures(cuts, names, 2.0, say, found=told, late=late)
    assert size.title == "Order 2, S1: amplitude"
    for said in ("recorded", "as written", "found"):
        assert said in size.svg
        assert said not in other[0].svg or said == "recorded"
    assert "-5 to 20 ms after its speed" in phase.note
    assert "4.5 deg up or down for each hertz" in phase.note


ASKED = [
    {"sn": "30,2e6,6"}, {"sn": "31,2e6,5"}, {"sn": "30,1e6,5"}, {"miner": "original"},
    {"miner": "elementary"}, {"mean_stress": "swt"},
    {"mean_stress": "goodman", "ultimate_MPa": 500},
    {"mean_stress": "goodman", "ultimate_MPa": 600},
    {"mean_stress": "fkm", "mean_sensitivity": 0.2},
    {"residue": "repeat"}, {"residue": "discard"}, {"allowed": 0.5}, {"zero": "median"},
    {"zero": "drift"}, {"low_pass_Hz": 50.0}, {"low_pass_Hz": 60.0}, {"scale": ("S1=2:MPa",)},
    {"scale": ("S1=2,5:MPa",)}, {"between_samples": "yes"}, {"mask": ("spike",)},
    {"accept": ("spike",)}, {"mask": ("S1=spike",)}, {"mask": ("spike@3..4",)}, {"scatter": 0.1},
    {"gauges": ("S1:um/m",)}, {"gauges": ("S1:um/m",), "modulus_GPa": 70.0}, {"gauge_error": 0.1},
    {"strain_life": "900,-0.09,0.6,-0.6"}, {"strain_life": "900,-0.09,0.6,-0.6", "notch": 2.0},
    {"strain_life": "900,-0.09,0.6,-0.6", "strain_mean": "morrow"}, {"crack": "1,20,1e-11,3"},
    {"crack": "1,20,1e-11,3", "crack_threshold": 2.0},
    {"crack": "1,20,1e-11,3", "crack_shape": 1.0},
    {"accept": ("3..4",)},
]  # fmt: skip
"""Whatever makes other numbers of one recording."""


@pytest.mark.slow
def test_report_states_differing_analysis_options():
    """Two documents of one recording, 37 times apart in life, had the same words."""
    x = 60 * np.sin(2 * np.pi * 5 * np.arange(4000) / 400) + 10
    recording = recording_from_arrays(x[None], rate=400.0, names=["S1"])

    def told(code="en", **asked):
        campaign = AnalysisOptions(**{"sn": "30,2e6,5", "gauges": ("S1:MPa",)} | asked)
        found = RecordingStudy(campaign).run(recording)
        say = Translator(code)
        story = recording_story.recording_report(found, say=say, issue=ReportDateAndSourceStamp())
        tables = [b for c in story.chapters for b in c.blocks if isinstance(b, Table)]
        (counted,) = (t for t in tables if t.caption == say.with_minus_sign("Counted by"))
        terminal = next(
            t for t in recorded.terminal_lines(found, say) if t.startswith(say("Counted by"))
        )
        options = json_presentation.json_document(found)["rules"]["options"]
        # One truth on every medium.
        for name, value in counting.assessment_rule_rows(found.answer, say):
            assert f"{name}: {value}" in terminal
        assert counted.rows == tuple(
            counting.assessment_rule_rows(found.answer, say.with_minus_sign)
        )
        return counted.rows, json.dumps(options)

    every = [told(), *(told(**asked) for asked in ASKED)]
    for media in zip(*every, strict=True):
        assert len(set(media)) == len(every)
    asked = {k: v for one in ASKED[::-1] for k, v in one.items() if k not in ("gauges", "accept")}
    asked |= {"mean_stress": "fkm"}
    english = {w for row in told(**asked)[0] for w in row if " " in w and not w[0].isdigit()}
    for code in LANGUAGE_CODES[1:]:
        same = {word for row in told(code, **asked)[0] for word in row if word in english}
        assert same == set()


def test_small_damage_is_not_displayed_as_zero():
    """Damage 0 of the recording had stood beside a crack that is there after 9.6e8 h."""
    of = AlternativeLives(
        gauge="S1",
        duration=120.0,
        damage_at_failure=1.0,
        strain_damage=3.466e-11,
        strain_amplitude=1e-3,
    )
    assert "damage 3.466e-11 of the recording" in next(otherwise.text_lines(of))


def test_messages_of_analysis_modules_are_translated():
    """Those that are made where no report is: by their English text."""
    below = {
        *PARAMETER_TITLES.values(),
        *phrases.PHRASES.values(),
        *FAULT_KINDS,
        *(text for name, text in vars(agreement).items() if name.startswith("DOUBT_")),
        evidence.JOINTS_DOMINANT,
        evidence.JOINTS_NOT_DOMINANT,
        evidence.UNDETERMINED,
        "half cycles",
        "repeating",
        "discarded",
    }
    of_a_gauge = {"unit", "rate", "strength", "bit"}
    assert set(phrases.CHANNEL_PHRASES) | of_a_gauge == {*FAULT_KINDS, "dead"}
    for code in LANGUAGE_CODES[1:]:
        assert sorted(below - {text for _, text in message_catalogue(code)}) == []


def test_equal_damage_line_inverts_mean_stress_correction():
    mean = np.linspace(-100, 300, 9) * MPa
    line = equal_damage_amplitude_at_mean(
        mean, amplitude=30 * MPa, correction=lambda a, m: goodman(a, m, ultimate=500 * MPa)
    )
    assert line == pytest.approx(30 * MPa * (1 - np.maximum(mean, 0) / (500 * MPa)), rel=1e-9)
    assert equal_damage_amplitude_at_mean(
        mean, amplitude=30 * MPa, correction=uncorrected
    ) == pytest.approx(30 * MPa)
    bent = equal_damage_amplitude_at_mean(
        mean, amplitude=30 * MPa, correction=lambda a, m: fkm(a, m, sensitivity=0.2)
    )
    assert fkm(bent, mean, sensitivity=0.2) == pytest.approx(30 * MPa, rel=1e-9)


@pytest.mark.slow
def test_spectrogram_shows_tone_at_its_frequency_and_order():
    """12 Hz beside order 3 of a run-up: one stays in frequency, the other in order."""
    rate, n = 500.0, 60_000
    t = np.arange(n) / rate
    turns = 5 * t + 0.05 * t**2
    rotation = ShaftRotation(t[::10], turns[::10])
    x = 2 * np.cos(2 * np.pi * 12 * t) + 5 * np.cos(2 * np.pi * 3 * turns)
    (power,) = spectrograms([x[None, :1000], x[None, 1000:]], rate=rate, seconds=120.0, top=60.0)
    row = int(np.searchsorted(power.frequency, 12.0, side="right")) - 1
    width = power.frequency[1]
    # A sine of 2 has power 2; its column holds most of it wherever order 3 is elsewhere.
    late = power.time[:-1] > 30
    assert np.nansum(power.density[row - 1 : row + 2, late], axis=0) * width == pytest.approx(
        2.0, rel=0.1
    )
    (orders,) = order_maps(
        [x[None]], rate=rate, rotation=rotation, at=order_windows(rotation, until=120)
    )
    third = int(np.searchsorted(orders.order, 3.0, side="right")) - 1
    fast = orders.speed[:-1] > 7
    heard = orders.amplitude[third, fast]
    assert heard[~np.isnan(heard)] == pytest.approx(5.0, rel=0.02)


def test_spectrogram_leaves_gaps_at_missing_samples():
    x = np.sin(np.arange(20_000) / 9)
    x[4000:9000] = np.nan
    (power,) = spectrograms([x[None]], rate=500.0, seconds=40.0)
    known = ~np.isnan(power.density).any(axis=0)
    assert not known[5:8].any()
    assert known[:3].all()


@pytest.mark.slow
def test_life_command_writes_reports(tmp_path):
    drive = synthetic_recording(seconds=20, rate=200.0, seed=3).recording
    path = tmp_path / "run.csv"
    names = ["S1", "shaft_speed"]
    t = np.arange(4000) / 200.0
    np.savetxt(
        path, np.vstack([t, drive.read_all(names)]).T, delimiter=",", comments="",
        header="time,S1 [MPa],shaft_speed [rpm]",
    )  # fmt: skip
    plan = tmp_path / "plan.yaml"
    plan.write_text(
        "campaign: Two laps\nrecordings: [{file: run.csv, times: 2}]\ngauges: [S1]\n"
        "strength: {amplitude_MPa: 30, cycles: 2e6, slope: 5}\n"
    )
    out = tmp_path / "out.html"
    done = CliRunner().invoke(
        command,
        [str(path), "--gauge", "S1", "--sn", "30,2e6,5", "--html", str(out), "--lang", "it"],
    )
    assert done.exit_code == 0, done.output
    assert "Estensimetri" in out.read_text()
    both = tmp_path / "both.html"
    done = CliRunner().invoke(
        command, [str(plan), "--html", str(both), "--json", str(tmp_path / "a.json")]
    )
    assert done.exit_code == 0, done.output
    assert "Two laps" in both.read_text()
    # A recording that is exchanged under a campaign is another report's.
    for file in (plan, path):
        assert sha256(file.read_bytes()).hexdigest()[:16] in both.read_text()
    assert json.loads((tmp_path / "a.json").read_text())["campaign"] == "Two laps"


@pytest.mark.skipif(not shutil.which("pdftotext"), reason="pdftotext of poppler is not installed")
def test_percent_sign_and_short_table_do_not_break(tmp_path):
    """A note ended "at 25" and went on "% or below"; of seven rows one was overleaf."""
    said = "a sentence that goes on to the end of its line, wherever that may be, to 25 % or less"
    prose = Text(paragraphs=tuple("w" * k + said for k in range(3, 40)))
    rows = tuple((f"row {k}", "1", "2") for k in range(7))
    table = Table(caption="caption", head=("cause", "share", "alone"), rows=rows)
    # Lines of prose push the tables down to the end of a page and over it.
    spread = [part for k in range(12) for part in (Text(paragraphs=("line",) * (k % 9 + 1)), table)]
    for blocks in ((prose,), tuple(spread)):
        story = ReportDocument(
            language="en", title="t", subtitle="", grade="", verdict="", facts=(),
            chapters=(Chapter(title="x", blocks=blocks),),
        )  # fmt: skip
        path = tmp_path / "a.pdf"
        path.write_bytes(pdf_document(story))
        read = subprocess.run(
            ["pdftotext", "-layout", str(path), "-"], capture_output=True, text=True, check=True
        )
        for page_ in read.stdout.split("\f"):
            lines = page_.splitlines()
            assert not [line for line in lines if line.lstrip().startswith("%")]
            told = [line.split()[1] for line in lines if line.lstrip().startswith("row ")]
            assert told == list("0123456") * (len(told) // 7)
