"""A duty cycle from a recording: its shaft torque and speed as a collective."""

from pathlib import Path

import numpy as np

from cardan.application.duty_collective import DutyCollective, duty_collective
from cardan.core.errors import DesignError
from cardan.core.message import translatable_message
from cardan.physics.signals.channel_units import RADIANS_PER_TURN, TORQUE_UNITS
from cardan.physics.signals.recording import Recording
from cardan.physics.signals.shaft_angle import torque_error_runs
from cardan.readers.dispatch import open_recording
from cardan.schema.yaml_tree import to_one_line
from cardan.topics.recording.channel_reading import sampled_channel, split_unit, unit_factor
from cardan.topics.recording.channel_roles import ChannelRole, guess_channel_role, names_propshaft
from cardan.topics.recording.shaft_signals import speed_samples

MIN_KNOWN_SHARE = 0.5
"""Share of a recording in which torque and speed are known, below which it is no duty."""


def read_measured_duty(
    path: Path,
    *,
    speed: str | None = None,
    torque: str | None = None,
    axle_ratio: float | None = None,
    tyre_radius: float | None = None,
) -> DutyCollective:
    """Return the duty cycle of the shaft torque and speed in a recording.

    Samples in which either has no value count as not recorded. Torque counts against the sense of
    rotation as overrun, in reverse too.

    Parameters
    ----------
    path
        A recording of any format that is read.
    speed, torque
        `CHANNEL` or `CHANNEL:UNIT` of the shaft; None: the one that looks like it by unit and name.
        A speed of the vehicle turns the shaft by `axle_ratio` and `tyre_radius`, m.

    Raises
    ------
    CardanError
        If the recording cannot be read, a channel cannot be told or has another unit, or less than
        half of the recording is known.
    """
    recording = open_recording(path)
    speed = speed or _channel_by_role(recording, "speed", "--speed")
    torque = torque or _channel_by_role(recording, "torque", "--torque")
    wheel = None
    if axle_ratio is not None and tyre_radius is not None:
        wheel = axle_ratio / (RADIANS_PER_TURN * tyre_radius)
    turns, rate, without_speed = speed_samples(recording, speed, wheel=wheel)
    channel, unit = split_unit(torque)
    factor = unit_factor(recording, channel, unit, TORQUE_UNITS)
    moments, _ = sampled_channel(recording, channel)
    for first, last in torque_error_runs(moments, rate=rate):
        moments[first:last] = np.nan
    for first, last in without_speed:
        turns[first:last] = np.nan
    known = np.isfinite(turns) & np.isfinite(moments)
    if not known.mean() >= MIN_KNOWN_SHARE:
        msg = (
            f"{recording.name}: torque and speed are known in {100 * known.mean():.0f} % of it; a "
            f"duty cycle needs {100 * MIN_KNOWN_SHARE:.0f} %"
        )
        raise DesignError(msg)
    of_shaft = turns[known] * RADIANS_PER_TURN
    origin = translatable_message(
        "measured: {file}, channels {channels}",
        file=to_one_line(path.name),
        channels=tuple(map(to_one_line, (channel, split_unit(speed)[0]))),
    )
    return duty_collective(
        np.full(of_shaft.size, 1 / rate),
        factor * moments[known] * np.where(of_shaft < 0, -1.0, 1.0),
        np.abs(of_shaft),
        origin=origin,
    )


def _channel_by_role(recording: Recording, role: ChannelRole, option: str) -> str:
    """Return the name of the one channel of a role, or of the vehicle's speed for a speed."""
    roles = {c.name: guess_channel_role(c) for c in recording.channels}
    found = [c for c in recording.channels if roles[c.name] == role]
    found = [c for c in found if names_propshaft(c)] or found
    if not found and role == "speed":
        found = [c for c in recording.channels if roles[c.name] == "vehicle speed"]
    if len(found) == 1:
        return found[0].name
    what = ", ".join(c.name for c in found) or "none"
    msg = (
        f"{recording.name}: one channel must be the shaft {role}; {what} could be; name it with "
        f"{option} CHANNEL[:UNIT]; its channels: {', '.join(recording.names)}"
    )
    raise DesignError(msg)
