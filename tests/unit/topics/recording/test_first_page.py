"""First page of a life report: its figures show the numbers of the recording and of its count."""

import re
import shutil
import subprocess
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from cardan.core.units import MPa, hour
from cardan.physics.fatigue.damage import miner_damage
from cardan.physics.fatigue.mean_stress import uncorrected
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.physics.signals.recording import Channel, recording_from_arrays
from cardan.render.blocks import BulletList, Figures, ReportDateAndSourceStamp, Table, Text
from cardan.render.chart import logarithmic_ticks, power_of_ten_text
from cardan.render.html import html_page
from cardan.render.i18n import LANGUAGE_CODES, Translator
from cardan.render.pdf import pdf_document
from cardan.topics.recording import life_figures_report as figures
from cardan.topics.recording.campaign_study import analyse_campaign
from cardan.topics.recording.first_page_report import first_page_chapter, governing_gauge
from cardan.topics.recording.load_collective import (
    curve_amplitude,
    load_collective,
    stress_reserve,
)
from cardan.topics.recording.options import AnalysisOptions
from cardan.topics.recording.report import campaign_report, recording_report
from cardan.topics.recording.screen_presentation import gauge_results
from cardan.topics.recording.stress_history import (
    MAX_ENVELOPE_COLUMNS,
    MAX_STRETCHES,
    StressHistoryCounter,
    marked_stretches,
    samples_per_stretch,
)
from cardan.topics.recording.study import RecordingStudy

RATE, SECONDS = 200.0, 90.0
SAY = Translator("en")


def stress(seed=1, *, burst=30.0):
    """MPa: a quiet sine in noise, and from `burst` on five seconds of large cycles."""
    t = np.arange(int(RATE * SECONDS)) / RATE
    noise = np.random.default_rng(seed).standard_normal(t.size)
    loud = (t >= burst + 1) & (t < burst + 4)
    return np.where(loud, 60.0, 6.0) * np.sin(2 * np.pi * 4 * t) + 0.5 * noise


def study(*rows, **options):
    names = [f"S{k + 1}" for k in range(len(rows))]
    recording = recording_from_arrays(np.stack(rows), rate=RATE, names=names)
    recording = replace(recording, channels=tuple(Channel(n, "MPa") for n in names), name="run")
    asked = {"sn": (30, 2e6, 5), "gauges": [f"{n}:MPa" for n in names]} | options
    return RecordingStudy(AnalysisOptions.from_values(**asked), draw=True).run(recording)


@pytest.fixture(scope="module")
def found():
    return study(stress(), 0.4 * stress(2), scatter=0.1, target_hours=1.0)


def chapter_figures(chapter):
    return [f for b in chapter.blocks if isinstance(b, Figures) for f in b.figures]


def test_envelope_holds_extremes_of_every_column(found):
    x = stress()
    history = found.answer.figures.histories[0]
    size = round(history.column_length * RATE)
    assert size == x.size / MAX_ENVELOPE_COLUMNS
    columns = x.reshape(-1, size)
    assert history.low / MPa == pytest.approx(columns.min(1), rel=1e-9)
    assert history.high / MPa == pytest.approx(columns.max(1), rel=1e-9)


def test_damage_of_stretches_adds_up_to_that_of_the_recording(found):
    for history, life in zip(found.answer.figures.histories, found.answer.lives, strict=True):
        assert history.damage.sum() == pytest.approx(life.life.damage, rel=1e-9)
        assert history.damage_shares.sum() == pytest.approx(1)
    shares = found.answer.figures.histories[0].damage_shares
    length = found.answer.figures.histories[0].stretch_length
    assert (length, shares.size) == (2.0, 45)
    # The large cycles close from 31 to 34 s, but for the half one that a later minimum ends.
    assert shares[15:17].sum() > 0.99
    assert shares[15:17].min() > 0.1


@pytest.mark.parametrize("options", [{"residue": "repeat"}, {"between_samples": "yes"}])
def test_damage_of_stretches_is_counted_as_the_life_is(options):
    of = study(stress(), **options).answer
    assert of.figures.histories[0].damage.sum() == pytest.approx(of.lives[0].life.damage, rel=1e-9)


def test_history_does_not_depend_on_the_pieces(found):
    x = np.stack([stress(), stress(2)]) * MPa
    x[0, 3000:3900] = np.nan
    plan = found.answer.plan

    def histories(size):
        counter = StressHistoryCounter(
            plan, samples=x.shape[1], rate=RATE, interpolated=[False, False]
        )
        pieces = [x[:, k : k + size] for k in range(0, x.shape[1], size)]
        assert sum(p.shape[1] for p in counter.observed(pieces)) == x.shape[1]
        return counter.histories()

    for whole, cut in zip(histories(x.shape[1]), histories(777), strict=True):
        np.testing.assert_array_equal(whole.low, cut.low)
        np.testing.assert_array_equal(whole.high, cut.high)
        assert cut.damage == pytest.approx(whole.damage, rel=1e-9, abs=1e-25)
    assert np.isnan(histories(777)[0].low[100:130]).all()


def test_history_of_a_long_recording_takes_the_memory_of_a_piece(found):
    """Of forty pieces less than ten are held at once, with what their count needs."""
    piece = np.tile(stress(), 5)[None] * MPa
    counter = StressHistoryCounter(
        found.answer.plan, samples=40 * piece.size, rate=RATE, interpolated=[False]
    )
    for _ in counter.observed(iter([piece])):  # imports and compiles
        pass
    tracemalloc.start()
    for _ in counter.observed(piece.copy() for _ in range(40)):
        pass
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 10 * piece.nbytes


@pytest.mark.parametrize("seconds", [0.5, 44.0, 1000.0, 3.7e4, 4e6])
def test_a_recording_of_any_length_has_few_stretches(seconds):
    samples = round(seconds * RATE)
    size = samples_per_stretch(samples, rate=RATE)
    assert 1 <= -(-samples // size) <= MAX_STRETCHES


def test_drawn_matrix_holds_every_counted_cycle(found):
    one = found.answer.lives[0]
    drawn = figures.drawn_matrix(one.matrices[0])
    assert drawn.total == pytest.approx(one.cycles.count.sum(), rel=1e-12)
    assert np.ptp(np.concatenate([drawn.row, drawn.column])) < figures.MATRIX_BINS
    svg = figures.matrix_figure(one.matrices[0], SAY, gauge="S1").svg
    # A cell for each bin, the background, and a key for each power of ten.
    powers = {np.floor(np.log10(c) + 1e-9) for c in drawn.count}
    lowest, highest = min(powers), max(powers)
    assert svg.count("<rect") == drawn.count.size + 1 + highest - lowest + 1
    top = power_of_ten_text(4) if highest == 3 else f"{10 ** (highest + 1):g}"
    assert f"… {top}</text>" in svg


def test_load_collective_counts_cycles_from_an_amplitude_on(found):
    cycles = found.answer.lives[0].cycles
    of = load_collective(cycles, uncorrected)
    assert of.amplitude[-1] == cycles.amplitude.max()
    for k in (0, 50, 120, -1):
        reached = cycles.amplitude >= of.amplitude[k]
        assert of.cycles[k] == pytest.approx(cycles.count[reached].sum())
    assert load_collective(cycles.scaled(0.0), uncorrected) is None


def test_drawn_curve_inverts_the_sn_curve():
    for curve in (
        SNCurve(amplitude=30 * MPa, cycles=2e6, slope=5).modified(),
        SNCurve(amplitude=30 * MPa, cycles=2e6, slope=5, slope_beyond_knee=5),
    ):
        lives = np.geomspace(1e3, 1e9, 20)
        assert curve.life(curve_amplitude(curve, lives)) == pytest.approx(lives, rel=1e-9)
    limit = SNCurve(amplitude=30 * MPa, cycles=2e6, slope=5)
    assert curve_amplitude(limit, 1e9) == 30 * MPa


def test_stress_reserve_uses_up_the_life():
    """With one slope, damage goes by its power: the factor follows from the life alone."""
    of = study(stress(), miner="elementary", allowed=0.7).answer
    life, cycles, wanted = of.lives[0].life, of.lives[0].cycles, 25 * hour
    factor = stress_reserve(cycles, life, of.plan, seconds=wanted)
    assert factor == pytest.approx((life.hours / 25) ** (1 / 5), rel=1e-6)
    counted = miner_damage(cycles.scaled(factor), curve=of.plan.curve)
    bins = miner_damage(cycles, curve=of.plan.curve) / life.damage
    assert counted / bins * wanted / life.duration == pytest.approx(0.7, rel=1e-6)


def test_suspects_are_marked_by_what_rules_make_of_them():
    x = stress()
    x[[2000, 9000, 15000]] += 500
    x[4000:4600] = np.nan
    of = study(x, mask=("spike@0..20", "80..85"), accept=("spike@40..50",)).answer
    marks = marked_stretches(
        of.lives[0].channel_reports, rules=of.plan.fault_rules, rate=of.recording.rate
    )
    by_kind = {one.kind: one for one in marks}
    spikes = by_kind["spike"]
    assert [r[0, 0] for r in (spikes.masked, spikes.accepted, spikes.undecided)] == pytest.approx(
        [10, 45, 75], abs=0.02
    )
    assert by_kind["hole"].undecided == pytest.approx(np.array([[20, 23]]))
    assert by_kind[""].masked == pytest.approx(np.array([[80, 85]]), abs=0.01)
    drawn = figures.history_figure(
        of.figures.histories[0], marks, SAY, gauge="S1", recording="run", duration=SECONDS
    )
    for text in ("spike: 1 masked, 1 undecided, 1 accepted", "hole: 1", "masked by time: 1"):
        assert f">{text}</text>" in drawn.svg
        assert text in drawn.alt
    # Masked data are not drawn: what stays is the accepted and the undecided spike.
    high = of.figures.histories[0].high / MPa
    assert np.flatnonzero(high > 300).tolist() == [300, 500]


@pytest.mark.parametrize("code", LANGUAGE_CODES)
def test_first_page_has_life_cause_and_four_figures(found, code):
    say = Translator(code)
    chapter = first_page_chapter(found, say)
    (table,) = (b for b in chapter.blocks if isinstance(b, Table))
    assert [row[0] for row in table.rows] == ["S1", "S2"]  # the shorter life first
    assert table.grades[0][0] in ("pass", "fail")
    assert any(isinstance(b, BulletList) for b in chapter.blocks)
    drawn = chapter_figures(chapter)
    assert len(drawn) == 4
    other = recording_report(found, say=say, issue=ReportDateAndSourceStamp()).chapters[2]
    title = say(
        "{gauge} in {recording}: smallest and largest stress over time", gauge="S2", recording="run"
    )
    assert [f.title for f in chapter_figures(other)].count(title) == 1
    assert drawn[0].title not in [f.title for f in chapter_figures(other)]
    assert all(f.alt and "S1" in f.title for f in drawn)
    x = stress()
    assert say.compact_number(x.max(), 4) in drawn[0].alt
    largest = governing_gauge(found, gauge_results(found)).cycles.amplitude.max() / MPa
    assert say.compact_number(largest, 3) in drawn[2].note
    assert say.percentage(found.answer.figures.histories[0].damage_shares.max()) in drawn[3].note


def test_first_page_has_the_life_required():
    """The page to sign had the verdict and the life, and not the hours it is compared with."""
    blocks = first_page_chapter(study(stress(), target_hours=1e9), SAY).blocks
    (said,) = (p for b in blocks if isinstance(b, Text) for p in b.paragraphs)
    assert said.startswith("Limit: fatigue life min 1e+09 h: 1 exceeded, 0 met; worst S1: ")
    assert said.endswith(" h")


def test_rejected_gauge_is_shown_without_a_life():
    x = stress()
    x[[2000, 9000, 15000]] += 2000
    found = study(x, 0.4 * stress(2), target_hours=1.0)
    one = governing_gauge(found, gauge_results(found))
    assert (one.name, one.known) == ("S1", False)
    collective = chapter_figures(first_page_chapter(found, SAY))[2]
    assert "collective at the life" not in collective.svg
    assert "Safety" not in collective.note


def test_recording_without_signal_has_no_figures():
    assert chapter_figures(first_page_chapter(study(np.zeros(6000)), SAY)) == []


@pytest.fixture(scope="module")
def campaign_file(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mix")
    t = np.arange(int(RATE * SECONDS)) / RATE
    for k, name in enumerate(("road", "city", "track")):
        np.savetxt(
            folder / f"{name}.csv", np.column_stack([t, (1 + k) * stress(k)]), "%.6g",
            delimiter=",", comments="", header="time,S1 [MPa]",
        )  # fmt: skip
    path = folder / "plan.yaml"
    path.write_text(
        "campaign: Mix\nrecordings:\n- {file: road.csv, times: 20}\n- {file: city.csv, times: 3}\n"
        "- {file: track.csv}\ngauges: [S1]\nstrength: {amplitude_MPa: 30, cycles: 2e6, slope: 5}\n"
    )
    return path


@pytest.fixture(scope="module")
def campaign(campaign_file):
    return analyse_campaign(campaign_file)


def test_campaign_shows_damage_and_cycles_of_the_mix(campaign):
    one = governing_gauge(campaign, gauge_results(campaign))
    parts = [times * heard.lives[0].life.damage for _, times, heard in campaign.answer.parts]
    assert one.part_damages == pytest.approx(parts)
    assert one.part_damages.sum() == pytest.approx(one.life.damage)
    counts = [t * h.lives[0].cycles.count.sum() for _, t, h in campaign.answer.parts]
    assert one.matrix.total == pytest.approx(sum(counts)) == one.cycles.count.sum()
    assert one.recording.recording.name == campaign.answer.parts[int(np.argmax(parts))][0]
    bars = chapter_figures(first_page_chapter(campaign, SAY))[-1]
    shown = [float(v) for v in re.findall(r">(\d+) %</text>", bars.svg)]
    assert shown == pytest.approx(100 * np.array(parts) / sum(parts), abs=0.51)


def test_small_recordings_of_a_long_campaign_share_a_bar():
    damages = np.arange(1.0, 21.0)
    names = [f"r{k}" for k in range(20)]
    bars = figures.recording_damage_figure(names, damages, SAY, gauge="S1")
    kept = 100 * np.append(damages[9:], damages[:9].sum()) / damages.sum()
    shown = [float(v) for v in re.findall(r">(\d+) %</text>", bars.svg)]
    assert shown == pytest.approx(kept, abs=0.51)
    assert "9 others" in bars.alt


def test_many_files_stand_in_the_annex(campaign):
    names = tuple(f"file {k}" for k in range(5))
    prints = tuple(f"print {k}" for k in range(5))
    issue = ReportDateAndSourceStamp(file_names=names, fingerprints=prints)
    report = campaign_report(campaign, say=SAY, issue=issue)
    assert [value for name, value in report.facts if name == "File"] == [
        "file 0 (SHA-256 print 0); 4 more in the annex"
    ]
    assert report.chapters[-1].blocks[0].rows == tuple(zip(names, prints, strict=True))


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("pdftotext"), reason="pdftotext of poppler is not installed")
def test_first_page_of_pdf_holds_all_figures(found, campaign_file, tmp_path):
    """The damage stood on the second page, where legends took two lines."""
    campaign = analyse_campaign(campaign_file, draw=True)
    for code, report, of in (("en", recording_report, found), ("it", campaign_report, campaign)):
        say = Translator(code)
        story = report(of, say=say, issue=ReportDateAndSourceStamp())
        page = html_page(story)
        path = tmp_path / "a.pdf"
        path.write_bytes(pdf_document(story))
        read = subprocess.run(
            ["pdftotext", str(path), "-"], capture_output=True, text=True, check=True
        )
        first, second, *_ = read.stdout.split("\f")
        for figure in chapter_figures(story.chapters[0]):
            assert figure.title in first
            assert figure.title in page
            assert figure.svg in page
        assert f"2 {say('Verdict')}" in second


@pytest.mark.parametrize(
    ("low", "high", "numbers"),
    [(0.6, 2.2, [5, 10, 20, 50, 100]), (-0.5, 5.0, [1, 10, 100, 1e3, 1e4, 1e5])],
)
def test_logarithmic_axis_has_round_numbers(low, high, numbers):
    assert 10 ** logarithmic_ticks(low, high) == pytest.approx(np.array(numbers))
    assert len(logarithmic_ticks(-0.5, 31.0)) <= 12
    assert (power_of_ten_text(6), power_of_ten_text(-12)) == ("10⁶", "10⁻¹²")
