"""First screen of `cardan life`: verdict, life and cause of each gauge, and its budget of lines."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from cardan.approval.study import StudyResult
from cardan.physics.signals.attribution_result import (
    DOUBT_NO_TORQUE,
    DOUBT_RESPONSE_STEP,
    JointAttribution,
)
from cardan.physics.signals.cause_assessment import (
    DOUBT_OF_NAMED_GAUGE,
    DOUBT_ORDERS_COINCIDE,
)
from cardan.physics.signals.damage_attribution import (
    CAUSE_JOINTS,
    CAUSE_SUDDEN_EVENTS,
    ShapleyAttribution,
)
from cardan.physics.signals.recording import recording_from_arrays
from cardan.render.i18n import LANGUAGE_CODES, Translator
from cardan.render.text_layout import without_colours
from cardan.topics.recording.options import AnalysisOptions
from cardan.topics.recording.presentation import recording_note_text, valid_share_text
from cardan.topics.recording.recording_assessment import RecordingAssessment
from cardan.topics.recording.screen_presentation import MAX_LINES, screen_lines
from cardan.topics.recording.study import RecordingStudy

RATE = 500.0
SECONDS = np.arange(7_000) / RATE
TARGET_H = 100.0


def signal(size: float) -> np.ndarray:
    noise = np.random.default_rng(1).normal(size=SECONDS.size)
    return size * np.sin(2 * np.pi * 11 * SECONDS) + noise


def found(*channels: np.ndarray, **more: object) -> StudyResult[RecordingAssessment]:
    names = [f"S{k}" for k in range(1, len(channels) + 1)]
    units = ["MPa"] * len(names)
    recording = recording_from_arrays(np.stack(channels), rate=RATE, names=names, units=units)
    options = AnalysisOptions(gauges=tuple(names), sn="30,2e6,5", **more)
    return RecordingStudy(options).run(recording)


def with_causes(of: StudyResult[RecordingAssessment], *, doubts: int = 0) -> object:
    """The result with joints that do half of the damage for sure, or for what the speed says."""
    names = tuple(one.name for one in of.answer.lives)
    sure = JointAttribution(damage_share=0.97, interval=(0.9, 1.0), f_statistic=99.0)
    open_ = replace(sure, damage_share=0.4, interval=(0.1, 0.9), doubts=(DOUBT_NO_TORQUE,))
    shares = ShapleyAttribution((CAUSE_JOINTS, CAUSE_SUDDEN_EVENTS), np.array([0, 0.2, 0.7, 1.0]))
    together = tuple(
        DOUBT_ORDERS_COINCIDE.with_values(
            one="unbalance", order=k, other="joints", second=2, share=k / 100
        )
        for k in range(doubts)
    )
    causes = SimpleNamespace(
        gauges=names,
        attributions=(shares,) * len(names),
        joint_attributions=(sure, *(open_ for _ in names[1:])),
        doubts=together,
    )
    return replace(of, answer=replace(of.answer, causes=causes))


def screen(of: object, code: str = "en") -> list[str]:
    return without_colours(screen_lines(of, Translator(code))).splitlines()


def test_screen_has_verdict_life_with_interval_and_cause_worst_gauge_first():
    of = found(signal(20.0), signal(40.0), target_hours=TARGET_H, scatter=0.05)
    lines = screen(with_causes(of))
    assert lines[0].endswith("  NOT APPROVED")
    head = next(k for k, line in enumerate(lines) if line.startswith("  gauge "))
    worst, better = (line.split() for line in lines[head + 1 : head + 3])
    lives = {one.name: one for one in of.answer.lives}
    assert (worst[:2], better[0]) == (["X", "S2"], "S1")
    for row, name in ((worst[2:], "S2"), (better[1:], "S1")):
        life = lives[name].life
        hours, low, _, high = row[:4]
        assert float(hours) == pytest.approx(life.hours, rel=5e-3)
        ends = [lives[name].repeats[share] * life.duration / 3600 for share in (0.1, 0.9)]
        assert [float(low), float(high)] == pytest.approx(ends, rel=5e-3)
    assert " ".join(worst[6:]) == "40 % (10 … 90) undetermined"
    assert " ".join(better[5:]) == "97 % (90 … 100) joints dominate"
    said = " ".join(" ".join(lines).split())
    assert "fatigue life min 100 h: 1 exceeded, 1 met; worst S2" in said
    assert (
        "Largest damage that goes without one cause, apart from the joints: S2 events 80 %" in said
    )
    assert "cause at S2 undetermined: no torque shows when the joints pull" in said


def test_screen_has_one_share_of_the_joints():
    """That by phase and torque; the orders' Shapley share, here the largest, is another number."""
    of = with_causes(found(signal(20.0), signal(40.0)))
    shares = ShapleyAttribution((CAUSE_JOINTS, CAUSE_SUDDEN_EVENTS), np.array([0, 0.7, 0.2, 1.0]))
    causes = of.answer.causes
    causes.attributions = (shares,) * len(causes.gauges)
    said = " ".join(" ".join(screen(of)).split())
    assert (
        "Largest damage that goes without one cause, apart from the joints: S2 events 30 %" in said
    )
    assert "75 %" not in said


def test_doubt_about_the_damage_itself_stands_before_other_doubts():
    of = with_causes(found(signal(20.0), signal(40.0)), doubts=9)
    step = DOUBT_RESPONSE_STEP.with_values(time=48.0, factor=1.7, low=0.1, high=2.3)
    of.answer.causes.doubts += (DOUBT_OF_NAMED_GAUGE.with_values(gauge="S2", doubt=step),)
    lines = screen(of)
    begin = lines.index("Before you sign")
    said = " ".join(" ".join(lines[begin + 1 : begin + 5]).split())
    assert said.startswith("S2: order 2 per torque is 1.70 times as large from about 48 s on")
    assert "the damage may be 0.1 to 2.3 times that shown" in said
    assert " ".join(lines).count("order 2 per torque") == 1


def test_rejected_gauge_has_no_life_and_next_command_decides_on_its_fault():
    spoiled = signal(20.0)
    spoiled[3000::1500] = -9999.0
    lines = screen(found(spoiled, signal(20.0), target_hours=1e-6))
    assert lines[0].endswith("  INCOMPLETE")
    assert "? S1     data rejected" in lines
    said = " ".join(" ".join(lines).split())
    assert "S1: DATA REJECTED (review needed): the damage depends on sentinel" in said
    assert "--mask KIND | --accept KIND" in said
    assert "Not evaluated: Fatigue life, S1: required" in said
    assert "an interval of the life (--scatter and --gauge-error)" in said


def test_screen_of_many_gauges_and_doubts_stays_one_screen():
    channels = [signal(20.0 + k) for k in range(14)]
    for channel in channels:
        channel[3000::1500] = -9999.0
    of = with_causes(found(*channels), doubts=30)
    for code in LANGUAGE_CODES:
        lines = screen(of, code)
        assert len(lines) <= MAX_LINES == 32, code
        assert max(map(len, lines)) <= 80, code
        assert " ".join(lines).count("(--all)") >= 3, code


def test_valid_share_and_notes_read_as_in_the_list_of_channels():
    """Of 98.78 % the list of channels said 98.7 %, and the screen of lives 98.8 %."""
    assert valid_share_text(0.98779, Translator("en")) == "98.7 %"
    assert valid_share_text(1.0, Translator("en")) == "100.0 %"
    note = (
        "n: no speed for 2.19 s, longest hole 2.19 s, the first at 61.01 s: damage there is of "
        "no band of speed"
    )
    assert "2,19 s, la prima a 61,01 s" in recording_note_text(note, Translator("it"))
