"""What a recording says of its application: terminal and JSON."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from cardan.core.units import MPa
from cardan.physics.fatigue.damage import LifeEstimate
from cardan.physics.signals.operational_modes import OperationalMode
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.terminal import aligned_column_lines
from cardan.topics.recording.identification_result import (
    IdentificationResult,
    IdentifiedParameter,
    ParameterChange,
)
from cardan.topics.recording.predicted_life import PredictedLife
from cardan.topics.recording.recording_assessment import RecordingAssessment

PARAMETER_TITLES = {
    "vertical": "vertical stiffness",
    "lateral": "lateral stiffness",
    "loss": "loss factor",
    "phase": "yoke phase",
    "gain": "measured over computed stress",
    "mode": "mode of the bracket",
    "mode damping": "damping of that mode",
    "unbalance": "unbalance at the rear end",
}
"""What the numbers are called."""


def parameter_row(of: IdentifiedParameter, say: Translator) -> tuple[str, ...]:
    """Return a number as a row: name, part, as written, as found, its interval, what of it."""

    def told(value: float) -> str:
        return "-" if math.isnan(value) else say.compact_number(of.in_display_unit(value), 4)

    name = say(PARAMETER_TITLES[of.name]) + (f" [{of.unit}]" if of.unit else "")
    where = say("bracket") if of.name.startswith("mode") else say.part(of.part)
    if of.identifiable:
        said = say("otherwise than written") if of.differs else (
            say("as written") if not math.isnan(of.file_value) else ""
        )  # fmt: skip
    elif of.assumed:
        said = say("more assumed than measured") if not of.differs else (
            say("otherwise than written, but more assumed than measured")
        )  # fmt: skip
    else:
        return name, where, told(of.file_value), "-", "-", say("not identified from this recording")
    between = say("{low} to {high}", low=told(of.low), high=told(of.high))
    return name, where, told(of.file_value), told(of.value), between, said


FORCE_DIRECTION_NAMES = "along the shaft", "sideways", "vertical"
"""Ways of a force on the bearing."""

OPERATIONAL_MODE_TITLE = "mode that road and engine shake"
MODE_DAMPING_TITLE = "its damping ratio"


def mode_rows(of: IdentificationResult, say: Translator) -> list[tuple[str, ...]]:
    """Return modes felt in addition to the orders, as rows like those of numbers."""
    if not of.operational_modes:
        return [
            (
                say(OPERATIONAL_MODE_TITLE) + " [Hz]",
                "-",
                "-",
                "-",
                "-",
                say("not identified from this recording"),
            )
        ]
    return [row for mode in of.operational_modes for row in _mode(of, mode, say)]


def _mode(
    of: IdentificationResult, mode: OperationalMode, say: Translator
) -> Iterator[tuple[str, ...]]:
    """Yield a mode's frequency, with what may be known of it, and its damping."""
    felt = ", ".join(g for g, one in zip(of.gauges, mode.felt_by_gauge, strict=True) if one)
    way, line = of.force_direction(mode), of.line_frequency(mode)
    remarks = (
        [] if way is None else [say("felt as a force {way}", way=say(FORCE_DIRECTION_NAMES[way]))]
    )
    if line is not None:
        remarks.append(
            say("the line on its rubber, {hertz} Hz?", hertz=say.compact_number(line, 3))
        )
    for name, (low, found, high), remark in (
        (say(OPERATIONAL_MODE_TITLE) + " [Hz]", mode.frequency, "; ".join(remarks)),
        (say(MODE_DAMPING_TITLE), mode.damping, ""),
    ):
        between = say(
            "{low} to {high}", low=say.compact_number(low, 3), high=say.compact_number(high, 3)
        )
        yield name, felt, "-", say.compact_number(found, 3), between, remark


def doubt_sentences(of: IdentificationResult, say: Translator) -> list[str]:
    """Return why nothing is reported, a sentence each."""
    return [say("no result: {doubt}", doubt=say.translate_message(doubt)) for doubt in of.doubts]


def no_change_prediction_sentence(say: Translator) -> str:
    """Return that for a line without a result no change is predicted."""
    return say("nothing is promised of the changed line")


def text_lines(of: IdentificationResult, say: Translator = ENGLISH) -> Iterator[str]:
    """Yield what a recording says of its application as lines of text."""
    yield say(
        "{application}, {state}: order 2 as recorded against computed",
        application=of.application.title, state=say.state(of.state),
    )  # fmt: skip
    before, after = (say.number(100 * m) for m in of.misfit)
    yield say(
        "  unexplained of its energy: {before} % as written, {after} % as identified",
        before=before, after=after,
    )  # fmt: skip
    yield from (f"  {line}" for line in doubt_sentences(of, say))
    head = (say("number"), say("of"), say("written"), say("found"), say("90 % interval"), "")
    rows = [head, *(parameter_row(p, say) for p in of.parameters), *mode_rows(of, say)]
    yield from (f"  {line}" for line in aligned_column_lines(rows, words=(0, 1, 5)))


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def json_document(of: IdentificationResult) -> dict[str, Any]:
    """Return what was found as the JSON contract has it; null is not known."""
    at = of.cuts.windows
    return {
        "application": of.application.title,
        "state": of.state,
        "centre_bearing": of.bearing,
        "unexplained": {"written": of.misfit[0], "found": of.misfit[1]},
        "doubts": [str(doubt) for doubt in of.doubts],
        "parameters": [
            {
                "name": PARAMETER_TITLES[p.name],
                "part": str(p.part),
                "unit": p.unit or None,
                "written": _number(p.in_display_unit(p.file_value)),
                "found": _number(p.in_display_unit(p.value)) if p.identifiable else None,
                "interval": [p.in_display_unit(p.low), p.in_display_unit(p.high)]
                if p.identifiable
                else None,
                "otherwise": p.contradicts_file,
                "assumed": [p.in_display_unit(v) for v in (p.value, p.low, p.high)]
                if p.assumed
                else None,
                "address": p.address or None,
            }
            for p in of.parameters
        ],
        "modes": [
            {
                "frequency_Hz": m.frequency[1],
                "interval_Hz": [m.frequency[0], m.frequency[2]],
                "damping": m.damping[1],
                "damping_interval": [m.damping[0], m.damping[2]],
                "gauges": [g for g, felt in zip(of.gauges, m.felt_by_gauge, strict=True) if felt],
                "shape": list(m.shape),
                "way": None
                if (way := of.force_direction(m)) is None
                else FORCE_DIRECTION_NAMES[way],
                "line_Hz": of.line_frequency(m),
            }
            for m in of.operational_modes
        ],
        "orders": [
            {
                "gauge": gauge,
                "order": order,
                "windows": [
                    {
                        "time_s": at.time[w],
                        "rpm": at.speed[w] * 60,
                        "torque_Nm": of.torque[w],
                        "measured_MPa": _number(abs(of.cuts.amplitude[g, k, w]) / MPa),
                        "measured_deg": _number(np.angle(of.cuts.amplitude[g, k, w], deg=True)),
                        "noise_MPa": _number(of.cuts.noise[g, k, w] / MPa),
                        "written_MPa": _number(abs(of.computed_before[g, k, w]) / MPa),
                        "written_deg": _number(np.angle(of.computed_before[g, k, w], deg=True)),
                        "found_MPa": _number(abs(of.computed_after[g, k, w]) / MPa),
                        "found_deg": _number(np.angle(of.computed_after[g, k, w], deg=True)),
                    }
                    for w in range(at.time.size)
                ],
            }
            for g, gauge in enumerate(of.gauges)
            for k, order in enumerate(of.cuts.orders)
        ],
    }


def predicted_life_lines(of: RecordingAssessment, say: Translator = ENGLISH) -> Iterator[str]:
    """Yield what a changed line promises as lines of text."""
    yield say("Driven so with the changed line")
    yield from (
        f"  {line}"
        for line in aligned_column_lines(predicted_life_rows(of.predicted_lives, say), words=(0,))
    )
    yield from (f"  {line}" for line in parameter_change_sentences(of.parameter_changes, say))


def parameter_change_sentences(of: Sequence[ParameterChange], say: Translator) -> Iterator[str]:
    """Yield where a changed line is not what was found, a sentence each."""
    for one in of:
        p, unit = one.identified, f" {one.identified.unit}".rstrip()
        low, found, high = (
            say.compact_number(p.in_display_unit(v), 4) for v in (p.low, p.value, p.high)
        )
        own = say("not given")
        if not math.isnan(one.value):
            own = say.compact_number(p.in_display_unit(one.value), 4) + unit
        yield say(
            "{name} of {part}: in the changed application {value}, in the recording {found}{unit} "
            "({low} to {high})",
            name=say(PARAMETER_TITLES[p.name]),
            part=say.part(p.part),
            value=own,
            found=found,
            unit=unit,
            low=low,
            high=high,
        )
    if of:
        yield say(
            "unless these are the change that is meant, the promise is of another line: write the "
            "change into the application as --corrected writes it"
        )


def predicted_life_rows(of: Sequence[PredictedLife], say: Translator) -> list[tuple[str, ...]]:
    """Return what a changed line promises as rows, their heads first."""

    def long(life: LifeEstimate) -> str:
        return say.compact_number(life.hours, 4) if math.isfinite(life.hours) else say("no end")

    head = (say("gauge"), say("damage"), say("with the change"), say("hours"),
            say("with the change"))  # fmt: skip
    return [head] + [
        (
            p.gauge,
            say.significant_number(p.recorded.damage, 4),
            say.significant_number(p.changed.damage, 4),
            long(p.recorded),
            long(p.changed),
        )
        for p in of
    ]


def parameter_changes_json(of: Sequence[ParameterChange]) -> list[dict[str, Any]]:
    """Return where a changed line is not what was found as the JSON contract has it."""
    return [
        {
            "name": PARAMETER_TITLES[one.identified.name],
            "part": str(one.identified.part),
            "unit": one.identified.unit or None,
            "found": one.identified.in_display_unit(one.identified.value),
            "interval": [
                one.identified.in_display_unit(v) for v in (one.identified.low, one.identified.high)
            ],
            "changed": _number(one.identified.in_display_unit(one.value)),
            "address": one.identified.address,
        }
        for one in of
    ]


def predicted_lives_json(of: Sequence[PredictedLife]) -> list[dict[str, Any]]:
    """Return what a changed line promises as the JSON contract has it; null lasts for ever."""
    return [
        {
            "gauge": p.gauge, "damage_recorded": _number(p.recorded.damage),
            "hours_recorded": _number(p.recorded.hours), "damage": _number(p.changed.damage),
            "hours": _number(p.changed.hours),
        }
        for p in of
    ]  # fmt: skip
