"""What a recording was counted by, so that two reports of one recording can be distinguished."""

import math
from collections.abc import Iterator
from typing import Any

from cardan.core.units import MPa
from cardan.physics.signals.data_quality import FaultRule
from cardan.render.blocks import Block, Table
from cardan.render.i18n import ENGLISH, Translator
from cardan.topics.recording.option_table import OPTIONS, statement_rows
from cardan.topics.recording.options import AnalysisOptions
from cardan.topics.recording.recording_assessment import RecordingAssessment


def json_document(of: AnalysisOptions) -> dict[str, Any]:
    """Return the options in force, in their own words; null is not given."""
    options = {
        name: list(value) if isinstance(value, tuple) else value
        for name, one in OPTIONS.items()
        if not one.is_application and name != "limits"
        for value in (getattr(of, name),)
    }
    return options | {"mean_sensitivity": of.effective_mean_sensitivity}


def assessment_rule_rows(of: RecordingAssessment, say: Translator) -> Iterator[tuple[str, str]]:
    """Yield each rule and what it says."""
    asked, curve = of.options, of.plan.curve
    yield (
        say("S-N curve"),
        say(
            "{amplitude} MPa at {cycles} cycles, slope {slope}",
            amplitude=say.compact_number(curve.amplitude / MPa),
            cycles=say.compact_number(curve.cycles),
            slope=say.compact_number(curve.slope),
        ),
    )
    yield say("below its knee"), (
        say("no damage ({rule} Miner)", rule=say(asked.miner))
        if math.isinf(curve.slope_beyond_knee)
        else say("slope {slope} ({rule} Miner)", slope=say.compact_number(curve.slope_beyond_knee),
                 rule=say(asked.miner))
    )  # fmt: skip
    yield from _option_rows(of, say)
    for channel, (factor, offset, unit) in asked.channel_scales.items():
        plus = f" + {say.compact_number(offset)}" if offset else ""
        yield channel, say(
            "{factor} times what is written{plus}, in {unit}",
            factor=say.compact_number(factor), plus=plus, unit=unit,
        )  # fmt: skip
    for name, mask in ((say("masked"), True), (say("accepted"), False)):
        told = [
            _ruled(r, of.recording.start_time, say) for r in of.plan.fault_rules if r.mask == mask
        ]
        if told:
            yield name, say.join(*told)
    turning = [
        f"{say(role)} {channel}"
        for role in ("speed", "tacho", "torque", "engine")
        if (channel := getattr(asked, role))
    ]
    if of.causes is not None and turning:
        yield say("causes by"), say.join(*turning)


def _option_rows(of: RecordingAssessment, say: Translator) -> Iterator[tuple[str, str]]:
    """Yield the rows of the options that have one, as the table declares them."""
    asked = of.options
    strained = asked.modulus_GPa if asked.has_strain_gauges(of.recording) else None
    in_force = {
        "mean_sensitivity": asked.effective_mean_sensitivity,
        "modulus_GPa": strained,
    }
    for option, row in statement_rows():
        value: Any = in_force.get(option.name, getattr(asked, option.name))
        needed = not option.needs or getattr(asked, option.needs)
        shown = row.shown != "if not default" or value != option.default
        if value is None or not (needed and shown):
            continue
        if row.texts is not None:
            value = say(row.texts[value])
        elif not isinstance(value, str):
            value = say.compact_number(value)
        yield say(row.label), value + row.unit


def _ruled(rule: FaultRule, begins: float, say: Translator) -> str:
    """Return what a rule is of: a kind, a channel, a time of the file."""
    what = say(rule.kind) if rule.kind else say("all that was recorded")
    of = f"{rule.channel}: " if rule.channel else ""
    if rule.covers_all_time:
        return f"{of}{what}"
    first = say.compact_number(begins + rule.first)
    if math.isinf(rule.last):
        return of + say("{what} from {first} s on", what=what, first=first)
    last = say.compact_number(begins + rule.last)
    return of + say("{what} from {first} to {last} s", what=what, first=first, last=last)


def text_lines(of: RecordingAssessment, say: Translator = ENGLISH) -> Iterator[str]:
    """Yield it as lines of text."""
    told = "; ".join(f"{name}: {said}" for name, said in assessment_rule_rows(of, say))
    yield say("Counted by: {rules}.", rules=told)


def report_blocks(of: RecordingAssessment, say: Translator) -> Iterator[Block]:
    """Yield it as a report has it."""
    yield Table(
        caption=say("Counted by"),
        head=(say("rule"), ""),
        rows=tuple(assessment_rule_rows(of, say)),
        words=2,
    )
