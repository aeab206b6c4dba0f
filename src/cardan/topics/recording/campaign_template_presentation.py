"""A campaign's file to start from, of one recording; what that does not say stands open."""

import json
import re
from collections.abc import Iterator

from cardan.physics.signals.channel_units import STRAIN_UNITS, STRESS_UNITS
from cardan.physics.signals.faults.registry import MASKABLE_OR_CORRECTABLE_FAULTS
from cardan.physics.signals.recording import Channel
from cardan.render.i18n import ENGLISH
from cardan.render.terminal import aligned_column_lines
from cardan.topics.recording.channel_reading import channel_unit
from cardan.topics.recording.overview_presentation import overview_rows, suspect_lines
from cardan.topics.recording.recording_overview import (
    ROLES_WITH_OPTION,
    RecordingOverview,
    channel_with_unit,
)

_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_./]*")
"""A text that YAML takes for itself without quotes; yes, no, on and off are names of no channel."""
_TRUTHS = ("yes", "no", "on", "off", "true", "false", "null", "y", "n")


def campaign_template(of: RecordingOverview) -> str:
    """Return a campaign of a recording, without its S-N curve: that needs knowledge of the part.

    A unit that the file does not say is UNIT, and a factor of an amplifier's channel is left out:
    both are refused until they are filled in.
    """
    return "\n".join(line.rstrip() for line in _lines(of)) + "\n"


def _lines(of: RecordingOverview) -> Iterator[str]:
    name = of.recording.name
    yield f"# A campaign of {name}. Evaluate it with: cardan life FILE"
    yield "# Every option of cardan life is a key of the same name: cardan schema --campaign."
    yield "# What only you know stands open: strength, and what is called UNIT or factor."
    yield "#"
    yield f"# {name} holds, {of.duration:g} s at {of.recording.rate:g} Hz:"
    table = aligned_column_lines(overview_rows(of, ENGLISH), words=(0, 1, 2))
    yield from (f"#   {row}" for row in table)
    yield from (f"# {line}" for line in suspect_lines(of, ENGLISH))
    yield ""
    yield f"campaign: {_text('Campaign of ' + name)}"
    yield ""
    yield "recordings:                     # add others; segments count in place of the whole"
    yield f"  - file: {_text(name)}"
    yield "    times: 1                    # how often it is driven in the mix"
    yield f"    mask: []                    # suspect data no part felt: [{_example_rule(of)}]"
    yield "    accept: []                  # suspect data that the part felt"
    yield ""
    scaled = [c.channel for c in of.gauges if _needs_scale(c.channel)]
    if scaled:
        yield "channels:                       # value times factor plus offset is in the unit"
        for channel in scaled:
            calibration = "{unit: MPa, factor: , offset: 0}"
            yield f"  {_text(channel.name)}: {calibration}    # recorded in {channel.unit}"
        yield ""
    if of.gauges:
        yield "gauges:                         # CHANNEL:UNIT of stress or strain"
        for one in of.gauges:
            yield f"  - {_text(_gauge(one.channel))}"
    else:
        yield "gauges: []                      # no channel looks like one: add CHANNEL:UNIT"
    yield ""
    yield "strength:                       # S-N curve at the gauges, half failed"
    yield "  amplitude_MPa:                # at the knee"
    yield "  cycles:                       # at the knee"
    yield "  slope:                        # above the knee"
    yield "  scatter: 0                    # standard deviation of log10 strength"
    yield ""
    yield from _turning(of)
    yield "zero: none                      # what is taken off as zero: start, median, drift"
    yield "# target_hours: 10000           # hours to live, for a verdict"
    yield "# modulus_GPa: 206              # Young's modulus, for strain"
    yield "# usage: true                   # where and when the damage came: gear, speed, torque"


def _turning(of: RecordingOverview) -> Iterator[str]:
    """Yield the keys of what turns, and of what else causes need."""
    for role, option in ROLES_WITH_OPTION:
        key, several = option.removeprefix("--"), of.candidates(role)
        if (one := of.only(role)) is not None:
            yield f"{key}: {_text(channel_with_unit(one.channel))}"
        elif several:
            yield f"# {key}: one of {', '.join(channel_with_unit(c.channel) for c in several)}"
        else:
            yield f"# {key}: CHANNEL:UNIT"
    tacho, vehicle = of.only("tacho"), of.only("vehicle speed")
    if not of.candidates("speed") and tacho is not None:
        yield f"tacho: {_text(tacho.channel.name)}"
    elif not of.candidates("speed") and vehicle is not None:
        yield f"speed: {_text(channel_with_unit(vehicle.channel))}    # needs the two below"
    yield "# axle_ratio: 4.3               # shaft turns a wheel turn"
    yield "# tyre_radius_m: 0.5            # with it: kilometres"
    yield ""


def _needs_scale(channel: Channel) -> bool:
    unit = channel_unit(channel)
    return bool(channel.unit) and unit not in STRESS_UNITS and unit not in STRAIN_UNITS


def _gauge(channel: Channel) -> str:
    if _needs_scale(channel):
        return channel.name
    return f"{channel.name}:{channel_unit(channel) or 'UNIT'}"


def _example_rule(of: RecordingOverview) -> str:
    """Return a rule that may be wanted: of the first thing that looks wrong in a gauge."""
    rules = (
        f"{c.channel.name}={kind}"
        for c in of.gauges
        for kind in c.report.faults
        if kind in MASKABLE_OR_CORRECTABLE_FAULTS
    )
    return next(rules, "S1=spike")


def _text(text: str) -> str:
    """Return a text as YAML has it: in quotes where it would be taken for something else."""
    if _PLAIN.fullmatch(text) and text.lower() not in _TRUTHS:
        return text
    return json.dumps(text, ensure_ascii=False)
