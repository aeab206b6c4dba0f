"""Every code that the physics of recordings gives has words, and its values fill them."""

import string

import pytest

from cardan.core.finding import Finding
from cardan.core.units import MPa
from cardan.physics.signals import (
    assessment,
    attribution_result,
    cause_assessment,
    conditioning,
    data_quality,
)
from cardan.physics.signals.data_quality import DeclaredRecordingProperties
from cardan.topics.recording.finding_phrases import (
    OTHER_FAULT_PHRASE,
    PHRASES,
    finding_message,
    finding_messages,
)

MODULES = (assessment, attribution_result, cause_assessment, conditioning, data_quality)


def test_every_finding_has_a_phrase_of_its_own():
    found = [one for m in MODULES for one in vars(m).values() if isinstance(one, Finding)]
    assert len(found) > 30
    assert {one.code for one in found} <= set(PHRASES)
    assert len(set(PHRASES.values())) == len(PHRASES)


@pytest.mark.parametrize("size", [5e9, 1e3])
def test_numbers_of_contradiction_fill_its_phrase(size):
    stated = DeclaredRecordingProperties(
        rate=20.0, bend_share=1.0, max_known_frequency=30.0, stuck_bit_value=12.5
    )
    found = stated.contradictions(low=0.0, high=size, typical=size, sound=True)
    assert set(found) == {"unit", "rate", "bit"}
    for one in found.values():
        sentence = finding_message(one)
        fields = {name for _, name, _, _ in string.Formatter().parse(sentence.text) if name}
        assert fields == {name for name, _ in sentence.values}
    assert ("5e+03 MPa" if size > 1e9 else "0.001 MPa") in str(finding_message(found["unit"]))


def test_stress_is_written_in_mpa():
    found = data_quality.REASON_ABOVE_TENSILE_STRENGTH.with_values(
        size=812.34 * MPa, ultimate=600 * MPa
    )
    assert "reach 812.3 MPa, and the tensile strength that was given is 600 MPa" in str(
        finding_message(found)
    )


def test_doubt_of_a_gauge_holds_the_doubt():
    doubt = attribution_result.DOUBT_SHAFT_ANGLE_MAY_SLIP
    found = cause_assessment.DOUBT_OF_NAMED_GAUGE.with_values(gauge="S1", doubt=doubt)
    assert str(finding_message(found)) == f"S1: {finding_message(doubt)}"


def test_fault_kind_without_phrase_is_named_by_its_places():
    found = Finding("ones").with_values(samples=2, places=1, first=8.0)
    message = finding_message(found)
    assert message.text == OTHER_FAULT_PHRASE
    assert str(message) == "samples that look wrong: 2; places: 1, the first at 8 s"


def test_equal_sentences_are_shown_once():
    share = cause_assessment.DOUBT_ENGINE_AT_SHAFT_SPEED
    found = [share.with_values(share=0.251), share.with_values(share=0.2514)]
    assert len(finding_messages(found)) == 1
