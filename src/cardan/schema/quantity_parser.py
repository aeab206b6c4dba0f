"""Numbers as people write them by hand: degrees and minutes, inches and fractions.

A file holds decimal numbers in the units of its keys. Angles in degrees, minutes and seconds
are read there too, as car makers print them: they name their unit, and mean one thing. What
else is written by hand is refused there with the number to write, if that is certain; a
command's option takes it.
"""

import re
from collections.abc import Mapping, Sequence

from cardan.core.errors import DesignError
from cardan.core.units import UNITS, deg

_COUNT = r"(\d+(?:\.\d*)?|\.\d+)"
_DASHES = "\u2212\u2013\u2014"
_PRIME = "['\u2032\u2019\u2018\u00b4\u02b9\u02bc\uff07`]"
"""What stands for minutes: the prime, and what keyboards and fonts make of it."""
_DEGREE_SIGN = "[\u00b0\u00ba\u02da\u25e6]"
# Texts, and compiled where one is needed: most files hold plain numbers alone.
_DEGREES = (
    rf"(?i)([-+{_DASHES}]?)\s*(?:{_COUNT}\s*(?:{_DEGREE_SIGN}|deg|degrees?|graus?|gradi)\s*)?"
    rf"(?:{_COUNT}\s*(?:{_PRIME}(?!{_PRIME})|min)\s*)?"
    rf"(?:{_COUNT}\s*(?:[\"\u2033\u201d\u201c\u02ba]|{_PRIME}{{2}}|s|sec))?"
)
_WHOLE_DEGREES = rf"([-+{_DASHES}]?)\s*{_COUNT}\s*{_DEGREE_SIGN}"
MARKED_ANGLE_PATTERN = "[0-9] *(°|º|deg|grad|grau|min|['′’´\"″”])"
"""What a JSON Schema can say of an angle that bears its own mark."""
_FRACTION = r"([-+\u2212]?)\s*(?:(\d+)[\s-]+)?(\d+)\s*[/\u2044]\s*(\d+)"
_VULGAR = "¼½¾⅓⅔⅛⅜⅝⅞"
_QUARTERS = dict(zip(_VULGAR, ("1/4", "1/2", "3/4", "1/3", "2/3", "1/8", "3/8", "5/8", "7/8"),
                     strict=True))  # fmt: skip
_MEASURE = r"\s*([-+\u2212]?[\d.,\s/⁄¼½¾⅓⅔⅛⅜⅝⅞]*?)\s*([^\d\s.,][^\d]*(?:/s\^?2)?)?\s*"
_THOUSANDS = r"[-+]?\d{1,3}(,\d{3})+"
"""Digits in threes: thousands to some, decimals to others."""
_NUMBER = r"(?a)[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?"


def parse_degrees(text: str) -> float | None:
    """Return the degrees of an angle in degrees, minutes and seconds; None if it has neither.

    Examples
    --------
    >>> parse_degrees("3°30'"), parse_degrees("-4 deg 30 min"), parse_degrees("-36'")
    (3.5, -4.5, -0.6)
    """
    found = re.fullmatch(_DEGREES, text.strip())
    if found is None or (found[3] is None and found[4] is None):
        return None
    whole, minutes, seconds = (float(part or 0) for part in found.groups()[1:])
    # Alone, minutes go on past 60; behind degrees they do not.
    if (found[2] and minutes >= 60) or ((found[2] or found[3]) and seconds >= 60):
        return None
    size = whole + minutes / 60 + seconds / 3600
    return -size if found[1] and found[1] in f"-{_DASHES}" else size


def parse_marked_angle(text: str) -> float | None:
    """Return the degrees of an angle that bears its own mark: 4°, 1°02', -36'; else None."""
    if (angle := parse_degrees(text)) is not None:
        return angle
    found = re.fullmatch(_WHOLE_DEGREES, text.strip())
    if found is None:
        return None
    return -float(found[2]) if found[1] and found[1] in f"-{_DASHES}" else float(found[2])


def parse_fraction(text: str) -> float | None:
    """Return a number with a fraction, or a fraction; None if it is none.

    Examples
    --------
    >>> parse_fraction("55 1/4"), parse_fraction("3½"), parse_fraction("55.25")
    (55.25, 3.5, None)
    """
    for sign, said in _QUARTERS.items():
        text = text.replace(sign, f" {said}")
    found = re.fullmatch(_FRACTION, text.strip())
    if found is None or int(found[4]) == 0:
        return None
    size = int(found[2] or 0) + int(found[3]) / int(found[4])
    return -size if found[1] in ("-", "\u2212") else size


def decimal_number_hint(
    text: str, *, unit: str = "", units: Mapping[str, float] | None = None
) -> str:
    """Return what to write in place of a number by hand; "" if it is none.

    A number is proposed only where it is the same quantity in the key's `unit`: `units` says
    what those of its dimension are worth, SI.
    """
    if (number := parse_fraction(text)) is not None:
        return f"a fraction is written with a decimal point: write {number:.12g}"
    found = re.fullmatch(_MEASURE, text)
    if found is None or not found[1].strip() or not found[2]:
        return ""
    said, written, known = found[1].strip(), _unit(found[2]), units or {}
    number = parse_fraction(said)
    if number is None and re.fullmatch(_NUMBER, said):
        number = float(said)
    if number is not None and written == unit and unit:
        same = said if re.fullmatch(_NUMBER, said) else f"{number:.12g}"
        return f"the unit stands in the key: write {same}"
    if number is not None and written in known and (unit in known or not unit):
        same = f"{number * known[written] / known.get(unit, 1.0):.12g}"
        return f"the unit stands in the key: write {same} ({unit})" if unit else f"write {same}"
    if unit:
        return f"the unit stands in the key: write the number alone, in {unit.replace('_', '/')}"
    return "write the number alone"


def parse_quantity(text: str, units: Mapping[str, float]) -> float:
    """Return a number with its unit, SI; the first of the units is meant where there is none.

    `units` says what each is worth. An angle may stand in degrees and minutes, any number
    with a fraction.

    Raises
    ------
    DesignError
        If it is no number, or in no such unit: with what to write.
    """
    if "deg" in units and (angle := parse_marked_angle(text)) is not None:
        return angle * deg
    found = re.fullmatch(_MEASURE, text)
    first = next(iter(units))
    example = f"like 4.5{first}" if "deg" in units else f"like 100{first.replace('_', '/')}"
    if found is None or not found[1].strip():
        msg = f"must be a number with its unit, {example} (got {text})"
        raise DesignError(msg)
    said, unit = found[1].strip(), _unit(found[2] or first)
    if unit not in units:
        written = " or ".join(name.replace("_", "/") for name in units)
        msg = f"must be in {written} (got {text})"
        raise DesignError(msg)
    if (number := parse_fraction(said)) is not None:
        return number * units[unit]
    if not re.fullmatch(_NUMBER, said):
        pointed = said.replace(",", ".")
        sure = re.fullmatch(_NUMBER, pointed) and not re.fullmatch(_THOUSANDS, said)
        advice = f"; write {pointed}{unit}" if sure else ""
        msg = f"must be a number with its unit, {example} (got {text}){advice}"
        raise DesignError(msg)
    return float(said) * units[unit]


def argument_value(name: str, value: str | float, units: Sequence[str]) -> float:
    """Return an argument of a function as an SI number; a number alone is in the first unit.

    Raises
    ------
    DesignError
        If it is no number, or in another unit; the message names the argument.
    """
    if not isinstance(value, str):
        return float(value) * UNITS[units[0]]
    try:
        return parse_quantity(value, {unit: UNITS[unit] for unit in units})
    except DesignError as error:
        msg = f"{name}: {error}"
        raise DesignError(msg) from error


def _unit(written: str) -> str:
    """Return a unit by the name that keys end in."""
    plain = written.strip().replace("/", "_").replace("·", "").replace(".", "").replace("-", "")
    return {
        "°": "deg", "º": "deg", "degrees": "deg", "degree": "deg", "grad": "deg", "graus": "deg",
        "gradi": "deg", "%": "percent", "rad_s": "rad_s", "r_min": "rpm", "1_min": "rpm",
        "min⁻¹": "rpm", "giri_min": "rpm", "N m": "Nm", "kN m": "kNm", '"': "in", "inch": "in",
        "rad_s²": "rad_s2", "rad_s^2": "rad_s2", "lbf ft": "lbft", "lb ft": "lbft", "lbfft": "lbft",
    }.get(plain, plain)  # fmt: skip
