"""Numbers as people write them by hand: degrees and minutes, inches and fractions.

A file holds decimal numbers, so what is written like this is refused there with the number
to write; a command's option, which no other program reads, takes it.
"""

import re
from collections.abc import Mapping

from cardan.base.errors import DesignError
from cardan.base.units import deg

_COUNT = r"(\d+(?:\.\d*)?|\.\d+)"
# Texts, and compiled where one is asked: most files hold plain numbers alone.
_DEGREES = (
    rf"(?i)([-+\u2212]?)\s*{_COUNT}\s*(?:°|º|deg|degrees?|graus?|gradi)\s*"
    rf"(?:{_COUNT}\s*(?:'|′|’|min)\s*)?(?:{_COUNT}\s*(?:\"|″|”|''|s|sec))?"
)
_FRACTION = r"([-+\u2212]?)\s*(?:(\d+)[\s-]+)?(\d+)\s*[/\u2044]\s*(\d+)"
_VULGAR = "¼½¾⅓⅔⅛⅜⅝⅞"
_QUARTERS = dict(zip(_VULGAR, ("1/4", "1/2", "3/4", "1/3", "2/3", "1/8", "3/8", "5/8", "7/8"),
                     strict=True))  # fmt: skip
_MEASURE = r"\s*([-+\u2212]?[\d.,\s/⁄¼½¾⅓⅔⅛⅜⅝⅞]*?)\s*([^\d\s.,][^\d]*)?\s*"
_NUMBER = r"(?a)[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?"


def degrees(text: str) -> float | None:
    """Return the degrees of an angle in degrees, minutes and seconds; None if it has neither.

    Examples
    --------
    >>> degrees("3°30'"), degrees("-4 deg 30 min"), degrees("4.5deg")
    (3.5, -4.5, None)
    """
    found = re.fullmatch(_DEGREES, text.strip())
    if found is None or (found[3] is None and found[4] is None):
        return None
    whole, minutes, seconds = (float(part or 0) for part in found.groups()[1:])
    if max(minutes, seconds) >= 60:
        return None
    size = whole + minutes / 60 + seconds / 3600
    return -size if found[1] in ("-", "\u2212") else size


def fraction(text: str) -> float | None:
    """Return a number with a fraction, or a fraction; None if it is none.

    Examples
    --------
    >>> fraction("55 1/4"), fraction("3½"), fraction("55.25")
    (55.25, 3.5, None)
    """
    for sign, said in _QUARTERS.items():
        text = text.replace(sign, f" {said}")
    found = re.fullmatch(_FRACTION, text.strip())
    if found is None or int(found[4]) == 0:
        return None
    size = int(found[2] or 0) + int(found[3]) / int(found[4])
    return -size if found[1] in ("-", "\u2212") else size


def hint(text: str) -> str:
    """Return the decimal number to write in place of one by hand; "" if it is none."""
    if (angle := degrees(text)) is not None:
        return f"degrees take a decimal point: write {angle:.7g} (deg)"
    if (number := fraction(text)) is not None:
        return f"a fraction is written with a decimal point: write {number:.7g}"
    return ""


def measure(text: str, units: Mapping[str, float]) -> float:
    """Return a number with its unit, SI; the first of the units is meant where there is none.

    `units` says what each is worth. An angle may stand in degrees and minutes, any number
    with a fraction.

    Raises
    ------
    DesignError
        If it is no number, or in no such unit: with what to write.
    """
    if "deg" in units and (angle := degrees(text)) is not None:
        return angle * deg
    found = re.fullmatch(_MEASURE, text)
    first = next(iter(units))
    example = f"like 4.5{first}" if "deg" in units else f"like 100{first}"
    if found is None or not found[1].strip():
        msg = f"must be a number with its unit, {example} (got {text})"
        raise DesignError(msg)
    said, unit = found[1].strip(), _unit(found[2] or first)
    if unit not in units:
        written = " or ".join(name.replace("_", "/") for name in units)
        msg = f"must be in {written} (got {text})"
        raise DesignError(msg)
    if (number := fraction(said)) is not None:
        return number * units[unit]
    if not re.fullmatch(_NUMBER, said):
        pointed = said.replace(",", ".")
        advice = f"; write {pointed}{unit}" if re.fullmatch(_NUMBER, pointed) else ""
        msg = f"must be a number with its unit, {example} (got {text}){advice}"
        raise DesignError(msg)
    return float(said) * units[unit]


def _unit(written: str) -> str:
    """Return a unit by the name that keys end in."""
    plain = written.strip().replace("/", "_").replace("·", "").replace(".", "").replace("-", "")
    return {
        "°": "deg", "º": "deg", "degrees": "deg", "degree": "deg", "grad": "deg", "graus": "deg",
        "gradi": "deg", "rad_s": "rad_s", "r_min": "rpm", "1_min": "rpm", "min⁻¹": "rpm",
        "giri_min": "rpm", "N m": "Nm", "kN m": "kNm", '"': "in", "inch": "in", "lbf ft": "lbft",
        "lb ft": "lbft", "lbfft": "lbft",
    }.get(plain, plain)  # fmt: skip
