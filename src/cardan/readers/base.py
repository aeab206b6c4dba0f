"""What every recording format returns and which errors it raises."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.errors import FileIssue, InvalidFileError
from cardan.physics.signals.recording import Channel


def unreadable_recording_error(
    path: Path, message: str, *, hint: str = "", line: int = 0, value: str = ""
) -> InvalidFileError:
    """Return the error of a recording that cannot be read as meant."""
    return InvalidFileError(
        str(path), (FileIssue(message=message, hint=hint, line=line, value=value),)
    )


@dataclass(frozen=True, kw_only=True)
class RecordingFileColumns:
    """What a reader found: columns of equal length, time perhaps among them.

    Attributes
    ----------
    columns
        Their names and units.
    read_rows
        Takes places of columns and yields pieces (k, n).
    rate : Hz
        What the file itself says, if it does.
    samples
        Of each column, where it is known.
    notes
        What is to be said of it.
    start : s
        When its first sample was taken, on one clock of the file.
    clock
        The column that the container says is time, if it does.
    no_time
        What the container says that its samples are counted by, where that is not time.
    group
        Its name among the other tables of the file.
    other_tables
        Those of other rates, starts or lengths, each with a time axis of its own.
    frames
        Whether its rows are frames of a bus, which come when they come: they give the clock only
        where nothing else does.
    held
        Columns whose values are states, a gear: each holds until the next.
    """

    columns: tuple[Channel, ...]
    read_rows: Callable[[tuple[int, ...]], Iterable[FloatArray]]
    rate: float | None = None
    samples: int | None = None
    notes: tuple[str, ...] = ()
    start: float = 0.0
    clock: int | None = None
    no_time: str = ""
    group: str = ""
    other_tables: tuple["RecordingFileColumns", ...] = ()
    frames: bool = False
    held: tuple[int, ...] = ()


def as_one_file(tables: Iterable[RecordingFileColumns]) -> RecordingFileColumns:
    """Return the tables of a file as one: the first, with the others joined to it."""
    first, *others = tables
    return replace(first, other_tables=tuple(others))


@dataclass(frozen=True, kw_only=True)
class RecordingFormat:
    """A file format of recordings, as a module of this package declares it.

    Attributes
    ----------
    name
        As messages say it.
    extensions
        Endings of file names, in lower case and with the dot.
    open_columns
        Returns the columns of a file, given its path and a group; "" is no group. One that takes
        CAN databases is given their paths besides, in a tuple.
    extra
        The extra of cardan that installs the libraries that it needs.
    has_groups
        Whether its files hold groups of channels, one of which may be chosen.
    takes_dbc
        Whether its files may hold frames of CAN, which a database decodes.
    recognises
        Whether the first bytes of a file, some kB, are of this format.
    """

    name: str
    extensions: tuple[str, ...]
    open_columns: Callable[..., RecordingFileColumns]
    extra: str = "recordings"
    has_groups: bool = False
    takes_dbc: bool = False
    recognises: Callable[[bytes], bool] = lambda _: False


MIN_SAMPLE_RATE_HZ, MAX_SAMPLE_RATE_HZ = 1e-4, 1e7
"""Sample rates of anything that records a driveline: from a value in hours to a digitiser's.
Beyond them it is the number that is wrong. Engineering judgement, assumed."""


def no_frames_note(databases: tuple[Path, ...]) -> str:
    """Return what is said of CAN databases that a file has no use for."""
    names = ", ".join(path.name for path in databases)
    return f"no CAN frames in it: {names} decodes nothing"


def check_sample_rate(path: Path, rate: float) -> None:
    """Refuse a rate that no recording has.

    Raises
    ------
    InvalidFileError
        With the rate and what is allowed.
    """
    if not rate > 0:
        raise unreadable_recording_error(
            path, "the sample rate must be above 0", value=f"{rate:g} Hz"
        )
    if not MIN_SAMPLE_RATE_HZ <= rate <= MAX_SAMPLE_RATE_HZ:
        raise unreadable_recording_error(
            path, "no recording has such a sample rate", value=f"{rate:g} Hz",
            hint=f"{MIN_SAMPLE_RATE_HZ:g} to {MAX_SAMPLE_RATE_HZ:g} Hz are read; give the true "
            "one (--rate HZ)",
        )  # fmt: skip


MAX_PLAUSIBLE_SAMPLES_PER_FILE_BYTE = 50
"""Samples a byte of a file that it may hold at most: a real one holds less than one."""


def rate_of_printed_step(step: float, digits: int) -> float:
    """Return the rate of a step as it was printed: 204.8 Hz of 4.882812E-03.

    The roundest of those whose step has these digits, to a thousandth; else one over the step.
    """
    half = 0.5000001 * 10.0 ** (math.floor(math.log10(step)) - digits + 1)
    rounded = (round(1 / step, decimals) for decimals in range(4))
    return next((r for r in rounded if r and abs(1 / r - step) <= half), 1 / step)


def check_sample_count(path: Path, samples: int, channels: int = 1) -> None:
    """Refuse a file that claims more samples than its bytes can hold.

    Raises
    ------
    InvalidFileError
        Before anything of it is read.
    """
    size = path.stat().st_size
    if samples > MAX_PLAUSIBLE_SAMPLES_PER_FILE_BYTE * size:
        raise unreadable_recording_error(
            path, "it claims more samples than it can hold",
            value=f"{samples:.4g} samples of {channels} channels in {size} bytes",
            hint="a file of one value throughout is no recording",
        )  # fmt: skip


def missing_rows_error(path: Path, claimed: int, read: int) -> InvalidFileError:
    """Return the error of a file that holds fewer rows than it claims."""
    return unreadable_recording_error(path, f"it is damaged: of {claimed} rows it holds {read}")


def oversized_data_error(path: Path, name: str, size: int, samples: int) -> InvalidFileError:
    """Return the error of data that claim more bytes than their samples take."""
    return unreadable_recording_error(
        path, f"{name} claims more bytes than its samples take",
        value=f"{size} bytes at once for {samples} samples",
        hint="write it anew with the program that made it",
    )  # fmt: skip


MAX_BYTES_PER_SAMPLE = 16
"""Bytes that a sample takes at most, of any number or clock."""


MAX_PAGE_BYTES_WITHOUT_CHECK, MAX_PAGE_BYTES = 1 << 26, 1 << 30
"""Bytes of a page that need no check, and that are too many for any page."""


def max_page_bytes(samples: int) -> int:
    """Return how many bytes may be taken at once for what holds so many samples."""
    return min(max(MAX_PAGE_BYTES_WITHOUT_CHECK, MAX_BYTES_PER_SAMPLE * samples), MAX_PAGE_BYTES)


RATE_ATTRIBUTES = ("rate_Hz", "rate", "sample_rate", "sampling_rate", "samplerate", "fs")


def attribute_text(value: Any) -> str:
    """Return an attribute of a file as text; the first of a list."""
    if isinstance(value, np.ndarray) and value.size:  # many write a list of one
        value = value.flat[0]
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def rate_from_attributes(path: Path, attributes: Any) -> float | None:
    """Return the sample rate that attributes of a file give, Hz; None if none does."""
    for name in RATE_ATTRIBUTES:
        for key in (name, name.encode()):
            if key in attributes:
                return number_of_attribute(path, name, attributes[key])
    return None


def number_of_attribute(path: Path, name: str, value: Any) -> float:
    """Return the number that an attribute of a file is, written as text or in a list of one.

    Raises
    ------
    InvalidFileError
        If it is none, or several.
    """
    several = np.unique(np.asarray(value).ravel()) if isinstance(value, np.ndarray) else ()
    if len(several) > 1:
        raise unreadable_recording_error(
            path, f"its {name} is more than one number",
            value=", ".join(attribute_text(v) for v in several[:6]),
        )  # fmt: skip
    try:
        return float(attribute_text(value))
    except ValueError as error:
        raise unreadable_recording_error(
            path, f"its {name} is not a number", value=attribute_text(value)
        ) from error
