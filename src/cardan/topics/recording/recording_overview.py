"""What a recording holds, channel by channel, before anything is evaluated."""

import math
import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from cardan.core.errors import MissingDependencyError
from cardan.core.status import ProgressCallback, ignore_status
from cardan.physics.signals.assessment import survey_channel_quality
from cardan.physics.signals.channel_units import (
    KIND_AND_SI_FACTOR_BY_UNIT,
    STRAIN_UNITS,
    STRESS_UNITS,
)
from cardan.physics.signals.conditioning import ChannelReport
from cardan.physics.signals.faults.waveform import FAULT_MISSING_SAMPLES
from cardan.physics.signals.recording import Channel, ChannelSampling, Recording
from cardan.readers.dispatch import open_recording
from cardan.topics.recording.channel_reading import channel_unit
from cardan.topics.recording.channel_roles import ChannelRole, guess_channel_role, names_propshaft

CHANNELS_PER_PASS = 32
"""Channels that are surveyed at once: some 100 MB."""

ROLES_THAT_SWING: tuple[ChannelRole, ...] = ("gauge", "acceleration")
"""What moves about a zero of its own: a speed stands, creeps and jumps as it is driven."""

ROLES_WITH_OPTION: tuple[tuple[ChannelRole, str], ...] = (
    ("speed", "--speed"), ("engine", "--engine"), ("torque", "--torque"),
)  # fmt: skip
"""What `cardan life` takes one channel of, and by which option."""


@dataclass(frozen=True, kw_only=True)
class ChannelOverview:
    """What a channel holds.

    Attributes
    ----------
    channel
        Its name and unit.
    role
        What it is, guessed by unit and name.
    rate : Hz
        Samples a second, as the file has it.
    first, length : s
        Where it begins behind the recording, and how long it is.
    low, high
        Its smallest and largest value, in its unit; nan where it has none.
    valid_share
        Share of the recording's time in which it has a value.
    report
        Where it looks wrong; of what stands or jumps as it is driven, only what no channel can be.
    """

    channel: Channel
    role: ChannelRole
    rate: float
    first: float
    length: float
    low: float
    high: float
    valid_share: float
    report: ChannelReport


@dataclass(frozen=True, kw_only=True)
class RecordingOverview:
    """What a recording holds; `duration` is from its first sample to behind its last, s."""

    recording: Recording
    duration: float
    channels: tuple[ChannelOverview, ...]

    def candidates(self, role: ChannelRole) -> tuple[ChannelOverview, ...]:
        """Return the channels of a role that move; where some name a propshaft, those."""
        found = tuple(c for c in self.channels if c.role == role and not c.report.dead)
        return tuple(c for c in found if names_propshaft(c.channel)) or found

    def only(self, role: ChannelRole) -> ChannelOverview | None:
        """Return the one channel of a role; None if there is none, or more than one."""
        found = self.candidates(role)
        return found[0] if len(found) == 1 else None

    @property
    def gauges(self) -> tuple[ChannelOverview, ...]:
        """Channels that look like gauges and move."""
        return tuple(c for c in self.channels if c.role == "gauge" and not c.report.dead)


def survey_recording(
    path: Path, *, rate: float | None = None, time: str | None = None, group: str = "",
    dbc: Sequence[str] = (),
    tell: ProgressCallback = ignore_status,
) -> RecordingOverview:  # fmt: skip
    """Read a recording once and return what it holds.

    Raises
    ------
    CardanError
        If it cannot be read as meant, holds no samples, or an optional library is absent.
    """
    try:
        recording = open_recording(path, rate=rate, time=time, group=group, dbc=map(Path, dbc))
        return overview_of(recording, tell=tell)
    except ImportError as error:
        msg = f"this needs {error.name}; pip install 'cardan[fatigue,recordings]'"
        raise MissingDependencyError(msg) from error


def overview_of(
    recording: Recording, *, tell: ProgressCallback = ignore_status
) -> RecordingOverview:
    """Return what a recording holds, of up to 32 channels at once.

    Gauges are surveyed first, because a gauge's gain shows next to another gauge's.
    """
    roles: dict[str, ChannelRole] = {c.name: guess_channel_role(c) for c in recording.channels}
    names = sorted(recording.names, key=lambda name: roles[name] != "gauge")
    whole = (recording.samples or 0) / recording.rate

    def progress(doing: str, seconds: float) -> None:
        tell(f"{doing} {seconds / whole:.0%}" if whole else f"{doing} {seconds:.0f} s", 0, 0)

    reports: dict[str, ChannelReport] = {}
    for first in range(0, len(names), CHANNELS_PER_PASS):
        some = names[first : first + CHANNELS_PER_PASS]
        reports |= survey_channel_quality(recording, channels=some, progress=progress)
    samples = max(r.samples for r in reports.values())
    duration = samples / recording.rate
    sampling = recording.sampling or (ChannelSampling(rate=recording.rate),) * len(names)
    return RecordingOverview(
        recording=recording,
        duration=duration,
        channels=tuple(
            _channel_overview(c, roles[c.name], reports[c.name], of, duration)
            for c, of in zip(recording.channels, sampling, strict=True)
        ),
    )


def _channel_overview(
    channel: Channel, role: ChannelRole, report: ChannelReport, of: ChannelSampling, duration: float
) -> ChannelOverview:
    last = duration if of.last is None else of.last
    known = (report.samples - report.missing) / report.samples
    if of.known is not None:
        known = min(of.known / max(duration * of.rate, 1.0), 1.0)
    if known == 1 and not report.dead:  # behind its last sample a slower one has none to come
        faults = {k: v for k, v in report.faults.items() if k != FAULT_MISSING_SAMPLES}
        report = replace(report, missing=0, faults=faults)
    swings = role in ROLES_THAT_SWING or not (role or channel.unit)
    low, high = (of.low, of.high) if not math.isnan(of.low) else (report.low, report.high)
    return ChannelOverview(
        channel=channel,
        role=role,
        rate=of.rate,
        first=of.first,
        length=last - of.first,
        low=low if math.isfinite(low) else math.nan,
        high=high if math.isfinite(high) else math.nan,
        valid_share=known,
        report=report if swings else report.without_gauge_faults(),
    )


def next_command(of: RecordingOverview, file: str, *, reading: tuple[str, ...] = ()) -> str | None:
    """Return the command that evaluates a recording, or None if no channel looks like a gauge.

    Capitals in it stand for what the file does not say: the S-N curve, a unit, a calibration,
    which of several channels is the shaft's.
    `reading` holds options by which it was opened.
    """
    if not of.gauges:
        return None
    words = [*reading]
    for gauge in of.gauges:
        words += _gauge_words(gauge.channel)
    for role, option in ROLES_WITH_OPTION:
        if (one := of.only(role)) is not None:
            words += [option, channel_with_unit(one.channel)]
        elif of.candidates(role):
            words += [option, option.removeprefix("--").upper()]
    if not of.candidates("speed"):
        vehicle = of.only("vehicle speed")
        if (tacho := of.only("tacho")) is not None:
            words += ["--tacho", tacho.channel.name]
        elif vehicle is not None:
            words += ["--speed", channel_with_unit(vehicle.channel), "--axle-ratio", "RATIO"]
            words += ["--tyre-radius-m", "RADIUS"]
    return shlex.join(["cardan", "life", file, *words, "--sn", "MPa,CYCLES,SLOPE"])


def _gauge_words(channel: Channel) -> Iterator[str]:
    """Yield the options of a gauge: with its unit, or with the scale that gives it one."""
    unit = channel_unit(channel)
    if unit in STRESS_UNITS or unit in STRAIN_UNITS:
        yield from ("--gauge", f"{channel.name}:{unit}")
    elif channel.unit:
        yield from ("--gauge", channel.name, "--scale", f"{channel.name}=FACTOR,OFFSET:MPa")
    else:
        yield from ("--gauge", f"{channel.name}:UNIT")


def channel_with_unit(channel: Channel) -> str:
    """Return a channel with its unit as an option has it; UNIT where nothing says it."""
    unit = channel_unit(channel)
    return f"{channel.name}:{unit if unit in KIND_AND_SI_FACTOR_BY_UNIT else 'UNIT'}"
