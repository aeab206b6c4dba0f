"""Writes RPC III time histories: a drive file for a test rig, as MTS's programs read it.

Source: MTS, RPC File Formats, "Time History Files". Samples are 16-bit numbers, the one kind that
all programs of RPC III read; the largest of each channel is 32752.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.errors import DesignError
from cardan.physics.signals.recording import SAMPLES_PER_BLOCK, Channel, Recording
from cardan.readers.rpc import HEADER_BLOCK_BYTES, KEY_BYTES, RECORD_BYTES

INT_FULL_SCALE = 32752
"""The largest 16-bit number of a channel: the format's default."""
POINTS_PER_GROUP = 2048
"""Of a channel, in one frame: the longest frame and the shortest group of the format."""
MAX_CHANNELS = 128
"""Channels that the format allows."""
_LETTERS_IN_LATIN_1 = str.maketrans({"μ": "u", "µ": "u", "ε": "e"})


def rpc_chunks(recording: Recording, *, time_type: str = "DRIVE") -> Iterator[bytes]:
    """Yield an RPC III file of a recording, header first, in chunks of bounded size.

    The recording is read twice: for the range of each channel, and for its samples. A sample is
    kept to 1/65504 of its channel's largest value. The last group is filled up with the last
    value, and `SAMPLES` says how many are true.

    Raises
    ------
    DesignError
        If a sample is missing, a rate is none, or the format does not hold as many channels, a
        name or a unit.
    """
    if not (np.isfinite(recording.rate) and recording.rate > 0):
        msg = f"{recording.name}: the sample rate must be above 0, got {recording.rate:g} Hz"
        raise DesignError(msg)
    if not 1 <= len(recording.channels) <= MAX_CHANNELS:
        msg = (
            f"{recording.name}: an RPC III file holds 1 to {MAX_CHANNELS} channels, got "
            f"{len(recording.channels)}"
        )
        raise DesignError(msg)
    low, high, samples = _ranges(recording)
    largest = np.maximum(np.abs(low), np.abs(high))
    # As the header prints it, so that who reads the file multiplies by the same number.
    scale = np.array([float(f"{x / INT_FULL_SCALE:.6E}") if x else 1.0 for x in largest])
    groups = -(-samples // POINTS_PER_GROUP)
    keys = _keys(recording, low, high, scale, samples=samples, groups=groups, time_type=time_type)
    yield _header(keys)
    for piece in recording.pieces(size=SAMPLES_PER_BLOCK):
        filling = -piece.shape[1] % POINTS_PER_GROUP
        whole = np.pad(piece, ((0, 0), (0, filling)), mode="edge")
        stored = np.rint(whole / scale[:, None]).astype("<i2")
        by_group = stored.reshape(len(scale), -1, POINTS_PER_GROUP)
        yield np.ascontiguousarray(np.moveaxis(by_group, 1, 0)).tobytes()


def _ranges(recording: Recording) -> tuple[FloatArray, FloatArray, int]:
    """Return the lowest and highest sample of each channel (k,) and how many samples there are."""
    low = np.full(len(recording.channels), np.inf)
    high, samples = -low, 0
    for piece in recording.pieces():
        for name, x in zip(recording.names, piece, strict=True):
            if not np.isfinite(x).all():
                at = samples + int(np.flatnonzero(~np.isfinite(x))[0])
                msg = (
                    f"{recording.name}: {name} has no value at sample {at + 1}: a test rig cannot "
                    "follow it"
                )
                raise DesignError(msg)
        low, high = np.minimum(low, piece.min(axis=1)), np.maximum(high, piece.max(axis=1))
        samples += piece.shape[1]
    if not samples:
        msg = f"{recording.name}: it holds no samples"
        raise DesignError(msg)
    return low, high, samples


def _keys(
    recording: Recording, low: FloatArray, high: FloatArray, scale: FloatArray, *, samples: int,
    groups: int, time_type: str,
) -> list[tuple[str, str]]:  # fmt: skip
    """Return keys and values of a header, those first that stand first."""
    channels = recording.channels
    keys = [
        ("FILE_TYPE", "TIME_HISTORY"), ("TIME_TYPE", time_type), ("DATA_TYPE", "SHORT_INTEGER"),
        ("OPERATION", "cardan"), ("DELTA_T", f"{1 / recording.rate:.6E}"),
        ("CHANNELS", str(len(channels))), ("PTS_PER_FRAME", str(POINTS_PER_GROUP)),
        ("PTS_PER_GROUP", str(POINTS_PER_GROUP)), ("FRAMES", str(groups)),
        ("SAMPLES", str(samples)), ("INT_FULL_SCALE", str(INT_FULL_SCALE)), ("HALF_FRAMES", "0"),
        ("REPEATS", "1"), ("BYPASS_FILTER", "0"), ("PARTITIONS", "1"), ("PART.CHAN_1", "1"),
        ("PART.NCHAN_1", str(len(channels))),
    ]  # fmt: skip
    for k, (channel, unit) in enumerate(zip(channels, _units(channels), strict=True), 1):
        keys += [
            (f"DESC.CHAN_{k}", channel.name), (f"UNITS.CHAN_{k}", unit),
            (f"SCALE.CHAN_{k}", f"{scale[k - 1]:.6E}"),
            (f"LOWER_LIMIT.CHAN_{k}", f"{low[k - 1]:.6E}"),
            (f"UPPER_LIMIT.CHAN_{k}", f"{high[k - 1]:.6E}"), (f"MAP.CHAN_{k}", str(k)),
        ]  # fmt: skip
    count = len(keys) + 3
    blocks = -(-count * RECORD_BYTES // HEADER_BLOCK_BYTES)
    first = [
        ("FORMAT", "BINARY_IEEE_LITTLE_END"), ("NUM_HEADER_BLOCKS", str(blocks)),
        ("NUM_PARAMS", str(count)),
    ]  # fmt: skip
    return first + keys


def _units(channels: Sequence[Channel]) -> list[str]:
    """Return units in the letters of the format: Greek ones are none."""
    return [c.unit.translate(_LETTERS_IN_LATIN_1) or "NONE" for c in channels]


def _header(keys: Sequence[tuple[str, str]]) -> bytes:
    """Return the header of keys and values, filled up to whole blocks."""
    records = bytearray()
    for key, value in keys:
        try:
            text = value.encode("cp1252")
        except UnicodeEncodeError as error:
            letter = value[error.start]
            msg = f"{value!r} cannot stand in an RPC III file: it has no letter {letter!r}"
            raise DesignError(msg) from error
        if len(text) >= RECORD_BYTES - KEY_BYTES or b"\0" in text:
            msg = (
                f"{value!r} cannot stand in an RPC III file: up to {RECORD_BYTES - KEY_BYTES - 1} "
                "letters, none of them NUL"
            )
            raise DesignError(msg)
        records += key.encode().ljust(KEY_BYTES, b"\0")
        records += text.ljust(RECORD_BYTES - KEY_BYTES, b"\0")
    return bytes(records) + bytes(-len(records) % HEADER_BLOCK_BYTES)
