"""What a recording holds, as lines of text and as JSON."""

import math
from collections.abc import Iterator
from typing import Any

from cardan.core.version import __version__
from cardan.physics.signals.data_quality import MIN_SAMPLE_RATE_HZ
from cardan.render.i18n import ENGLISH, Translator
from cardan.render.terminal import aligned_column_lines
from cardan.render.text_layout import DEFAULT_WIDTH_COLUMNS, fold_lines
from cardan.topics.recording.channel_reading import channel_unit
from cardan.topics.recording.channel_roles import ChannelRole
from cardan.topics.recording.json_presentation import channel_json
from cardan.topics.recording.presentation import (
    fault_messages,
    recording_note_text,
    valid_share_text,
)
from cardan.topics.recording.recording_overview import ChannelOverview, RecordingOverview

_ROLE_NAMES = {
    "gauge": "gauge", "speed": "shaft speed", "engine": "engine speed", "tacho": "tacho",
    "vehicle speed": "vehicle speed", "torque": "shaft torque", "gear": "gear",
    "acceleration": "acceleration", "temperature": "temperature", "": "unknown",
}  # fmt: skip


def overview_rows(of: RecordingOverview, say: Translator) -> list[tuple[str, ...]]:
    """Return the channels as rows, their heads first."""
    return [
        (say("channel"), say("unit"), say("it is (a guess)"), "Hz", say("from s"), say("length s"),
         say("smallest"), say("largest"), say("valid")),
        *(
            (c.channel.name, channel_unit(c.channel) or "-", say(_ROLE_NAMES[c.role]),
             say.compact_number(c.rate), say.compact_number(c.first),
             say.compact_number(c.length), _value(c.low, say), _value(c.high, say),
             valid_share_text(c.valid_share, say))
            for c in of.channels
        ),
    ]  # fmt: skip


def _value(value: float, say: Translator) -> str:
    return "-" if math.isnan(value) else say.compact_number(value)


def overview_lines(
    of: RecordingOverview, say: Translator = ENGLISH, *, width: int = DEFAULT_WIDTH_COLUMNS
) -> Iterator[str]:
    """Yield a recording's channels, and what looks wrong in them, as lines of text.

    All but the table are folded to a width: its columns stay below each other.
    """
    yield from fold_lines(_head_lines(of, say), width)
    yield ""
    yield from aligned_column_lines(overview_rows(of, say), words=(0, 1, 2))
    yield ""
    yield from fold_lines(suspect_lines(of, say), width)


def _head_lines(of: RecordingOverview, say: Translator) -> Iterator[str]:
    yield say(
        "{recording}: {seconds} s at {rate} Hz", recording=of.recording.name,
        seconds=say.compact_number(of.duration), rate=say.compact_number(of.recording.rate),
    )  # fmt: skip
    for note in of.recording.notes:
        yield say("  note: {note}", note=recording_note_text(note, say))


ROLES_THAT_MOVE: tuple[ChannelRole, ...] = ("gauge", "speed", "engine", "tacho", "torque")
"""What stands still only in a channel that is dead: a gear and a temperature may."""


def suspect_lines(of: RecordingOverview, say: Translator) -> Iterator[str]:
    """Yield what looks wrong in the channels of a recording, or that nothing does."""
    found = [line for c in of.channels for line in _fault_lines(of, c, say)]
    if of.recording.rate < MIN_SAMPLE_RATE_HZ:
        text = say(
            "{rate} Hz is too slow for stress: is the time in another unit (--time NAME:ms)?",
            rate=say.compact_number(of.recording.rate),
        )
        found.insert(0, text)
    yield say("Suspect data:") if found else say("No suspect data found.")
    yield from (f"  {line}" for line in found)


def _fault_lines(of: RecordingOverview, one: ChannelOverview, say: Translator) -> Iterator[str]:
    name = one.channel.name
    if one.report.dead and one.role not in ROLES_THAT_MOVE:
        return
    for message in fault_messages(of.recording, name, one.report):
        yield f"{name}: {say.translate_message(message)}"


def next_step_lines(command: str | None, say: Translator = ENGLISH) -> Iterator[str]:
    """Yield how to go on; the words in capitals of the command are the reader's to fill in."""
    if command is None:
        yield say("No channel looks like a gauge: name one with --gauge CHANNEL:UNIT.")
        return
    yield say("To go on, with the S-N curve at the gauge and what else stands in capitals:")
    yield f"  {command}"


def overview_json(of: RecordingOverview, command: str | None) -> dict[str, Any]:
    """Return what a recording holds; what is unknown is null."""
    return {
        "cardan": __version__,
        "recording": of.recording.name,
        "rate_Hz": of.recording.rate,
        "duration_s": of.duration,
        "notes": list(of.recording.notes),
        "channels": [
            {
                **channel_json(of.recording, c.channel.name, c.report),
                "unit": channel_unit(c.channel), "role": c.role or None, "rate_Hz": c.rate,
                "from_s": c.first, "length_s": c.length, "low": _known(c.low),
                "high": _known(c.high), "valid_share": c.valid_share,
            }
            for c in of.channels
        ],
        "next": command,
    }  # fmt: skip


def _known(value: float) -> float | None:
    return None if math.isnan(value) else value
