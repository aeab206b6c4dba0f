"""Units of time as files write them, UDUNITS' among them, and instants."""

import re
from datetime import UTC, datetime

SECONDS_PER_TIME_UNIT = {
    "": 1.0, "s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "μs": 1e-6, "ns": 1e-9,
    "min": 60.0, "h": 3600.0,
}  # fmt: skip
"""The usual spellings, as messages list them."""
_SPELLINGS = {
    1.0: "secs second seconds sek sekunde sekunden segundo segundos secondo secondi seconde",
    1e-3: "msec msecs msek millisec millisecs millisecond milliseconds millisekunden",
    1e-6: "usec usecs microsec microsecs microsecond microseconds mikrosekunden",
    1e-9: "nsec nsecs nanosec nanosecs nanosecond nanoseconds nanosekunden",
    60.0: "mins minute minutes minuten minuto minutos minuti",
    3600.0: "hr hrs hour hours stunde stunden hora horas ora ore",
    86400.0: "d day days",
}
_SECONDS_BY_SPELLING = {u: s for s, words in _SPELLINGS.items() for u in words.split()}
"""UDUNITS-2 names of units of time, and those of German, Portuguese and Italian."""

_SINCE = re.compile(r"\s*(\S+)\s+(?:since|after|from|ref|@)\s+(.+)", re.IGNORECASE)


def seconds_per_time_unit(unit: str) -> float | None:
    """Return the seconds of a unit of time, of `milliseconds since ...` too; None if it is none."""
    match = _SINCE.fullmatch(unit)
    name = (match[1] if match else unit).strip().strip("[]()").strip()
    for one in (name, name.lower()):
        found = SECONDS_PER_TIME_UNIT.get(one, _SECONDS_BY_SPELLING.get(one))
        if found is not None:
            return found
    return None


def reference_instant(unit: str) -> float:
    """Return the instant since which a unit counts, s since 1970; 0 if it says none."""
    match = _SINCE.fullmatch(unit)
    return (match and instant(match[2])) or 0.0


def instant(text: str) -> float | None:
    """Return an instant by ISO 8601, s since 1970 (UTC without a zone); None if it is none."""
    text = text.strip().removesuffix(" UTC").removesuffix(" GMT")
    text = re.sub(r"^(\d{4})-(\d)-", r"\1-0\2-", text)
    text = re.sub(r"-(\d)(?=[ T]|$)", r"-0\1", text)
    text = re.sub(r"([ T])(\d):", r"\g<1>0\2:", text)
    fraction = re.search(r"(:\d\d)\.(\d+)", text)
    try:
        at = datetime.fromisoformat(text.replace(fraction[0], fraction[1], 1) if fraction else text)
    except ValueError:
        return None
    at = at if at.tzinfo else at.replace(tzinfo=UTC)
    return at.timestamp() + (float(f"0.{fraction[2]}") if fraction else 0.0)


_EPOCH_RANGE_S = (1e8, 5e9)
"""Seconds since 1970 from 1973 to 2128: what a count of them may be."""


def seconds_per_count_of_instants(count: float) -> float | None:
    """Return the seconds of a count since 1970 by its size; None if it is no such count.

    Milliseconds, microseconds and nanoseconds of the years that recordings are of do not overlap.
    """
    for seconds in (1.0, 1e-3, 1e-6, 1e-9):
        if _EPOCH_RANGE_S[0] <= count * seconds <= _EPOCH_RANGE_S[1]:
            return seconds
    return None
