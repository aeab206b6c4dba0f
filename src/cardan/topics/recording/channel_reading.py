"""Channels of a recording: their units, by hand, by file or by name, and slow values of them."""

import re
from collections.abc import Mapping, Sequence

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.errors import DesignError
from cardan.core.finding import Finding
from cardan.physics.signals.channel_units import (
    AMPLIFIER_UNITS,
    KIND_AND_SI_FACTOR_BY_UNIT,
    ROTATION_SPEED_UNITS,
    STRAIN_UNITS,
    STRESS_UNITS,
    TORQUE_UNITS,
    VEHICLE_SPEED_UNITS,
)
from cardan.physics.signals.data_quality import (
    DOUBT_STRAIN_NAMED_AS_STRESS,
    DOUBT_STRESS_NAMED_AS_STRAIN,
)
from cardan.physics.signals.recording import Channel, Recording
from cardan.physics.signals.shaft_angle import MAX_ROTATION_TIME_POINTS

_WRITTEN = re.compile(
    r"(?<=[\s_\[(])("
    + "|".join(
        sorted(
            map(re.escape, [u for u in KIND_AND_SI_FACTOR_BY_UNIT if u != "%"] + ["mV/V", "mV"]),
            key=len,
        )[::-1]
    )
    + r")[\])]?\s*$"
)
"""The unit a channel's name ends in: `S1_MPa`, `torque [Nm]`."""
_STRAINS = re.compile(
    r"(?<![a-z])(strain(?!\W*_*gau)|dehnung|deforma[çz]|epsilon|mikrodehn)", re.IGNORECASE
)
_STRESSES = re.compile(r"(?<![a-z])(stress|spannung|tens[ãi]o|sigma)", re.IGNORECASE)

UNIT_CONFUSED_WITH_BY_UNIT: Mapping[str, str] = {
    u: "um/m" if u in ("MPa", "N/mm2", "N/mm²") else "MPa"
    for u in KIND_AND_SI_FACTOR_BY_UNIT
    if u in ("MPa", "N/mm2", "N/mm²") or STRAIN_UNITS.get(u) == STRAIN_UNITS["um/m"]
}
"""Units whose numbers look alike, some tens to hundreds: which it may be as well."""

MAX_SPEED_READING_RATE_HZ = 200.0
"""Readings a second of a channel of speed that are looked at."""


def split_unit(text: str) -> tuple[str, str | None]:
    """Split CHANNEL:UNIT; channel names may hold colons, units do not."""
    name, _, unit = text.rpartition(":")
    known = (
        *STRESS_UNITS,
        *STRAIN_UNITS,
        *ROTATION_SPEED_UNITS,
        *VEHICLE_SPEED_UNITS,
        *TORQUE_UNITS,
    )
    return (name, unit) if name and unit in known else (text, None)


def unit_factor(
    recording: Recording, channel: str, given: str | None, table: Mapping[str, float]
) -> float:
    """Return the SI value of a channel's unit, given by hand or by the file."""
    of = recording.channel(channel)
    name = given or channel_unit(of)
    check_unit_agrees(of, name)
    if name not in table:
        none = repr(name) if name else "no unit"
        msg = f"{channel}: {none}; write {channel}:UNIT with one of {', '.join(table)}"
        if name in AMPLIFIER_UNITS or of.unit:
            msg += f", or scale it: --scale {channel}=FACTOR[,OFFSET]:UNIT"
        raise DesignError(msg)
    return table[name]


def channel_unit(channel: Channel) -> str:
    """Return the unit of a channel by its file, or else by its name; "" if neither says one."""
    return channel.unit or named_unit(channel)


def named_unit(channel: Channel) -> str:
    """Return the unit that a channel's name ends in; "" if none."""
    named = _WRITTEN.search(channel.name)
    return named[1] if named else ""


def check_unit_agrees(channel: Channel, taken: str) -> None:
    """Refuse a channel that is taken for another unit than its file or its name says.

    A factor of a million is easily read over, and nothing later shows one of five.
    """
    if taken not in KIND_AND_SI_FACTOR_BY_UNIT:
        return
    if channel.unit_declared:
        if KIND_AND_SI_FACTOR_BY_UNIT.get(channel.unit) != KIND_AND_SI_FACTOR_BY_UNIT[taken]:
            msg = (
                f"{channel.name}: --scale turns it into {channel.unit}, and it is taken for "
                f"{taken}; write {channel.name} without a unit, or --scale into {taken}"
            )
            raise DesignError(msg)
        return
    for who, unit in (("the file", channel.unit), ("its name", named_unit(channel))):
        if unit and KIND_AND_SI_FACTOR_BY_UNIT.get(unit) != KIND_AND_SI_FACTOR_BY_UNIT[taken]:
            msg = (
                f"{channel.name}: {who} says {unit}, and it is taken for {taken}; if it is in "
                f"{taken} in truth, say so: --scale {channel.name}=1:{taken}"
            )
            raise DesignError(msg)


def check_sampled_evenly(recording: Recording, channel: str) -> None:
    """Refuse a gauge that was sampled at uneven instants: between them its crests are lost."""
    of = recording.channel(channel)
    if of.uneven:
        msg = (
            f"{of.name}: its samples came at uneven instants and lie straight between them; a "
            "gauge needs an even clock"
        )
        raise DesignError(msg)


def unit_doubts(channel: Channel, taken: str) -> tuple[Finding, ...]:
    """Return a doubt where a gauge's name speaks of a strain and it is taken for a stress."""
    if channel.unit_declared:
        return ()
    if taken in STRESS_UNITS and _STRAINS.search(channel.name):
        return (DOUBT_STRESS_NAMED_AS_STRAIN.with_values(unit=taken),)
    if taken in STRAIN_UNITS and _STRESSES.search(channel.name):
        return (DOUBT_STRAIN_NAMED_AS_STRESS.with_values(unit=taken),)
    return ()


def sampled_channel(recording: Recording, channel: str) -> tuple[FloatArray, float]:
    """Return a slow channel as it is looked at, and how often: of a day's drive less often."""
    values, rate = sampled_channels(recording, [channel])
    return values[0], rate


def sampled_channels(recording: Recording, channels: Sequence[str]) -> tuple[FloatArray, float]:
    """Return channels (k, n) as they are looked at, and how often."""
    every, start, count = max(int(recording.rate / MAX_SPEED_READING_RATE_HZ), 1), 0, 0
    read: list[FloatArray] = []
    for piece in recording.pieces(channels):
        read.append(np.array(piece[:, -start % every :: every], float))
        start, count = start + piece.shape[1], count + read[-1].shape[1]
        while count > MAX_ROTATION_TIME_POINTS:
            before = np.cumsum([0, *(part.shape[1] for part in read)])
            read = [part[:, at % 2 :: 2].copy() for part, at in zip(read, before, strict=False)]
            every, count = 2 * every, sum(part.shape[1] for part in read)
    whole = np.concatenate(read, axis=1) if read else np.empty((len(channels), 0))
    return whole, recording.rate / every
