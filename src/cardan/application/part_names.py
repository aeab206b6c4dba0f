"""Names of tubes and joints as people write them, and the parts that are nearest in size."""

import re
from collections.abc import Mapping
from math import inf, log

from cardan.core.errors import DesignError
from cardan.core.units import inch, mm
from cardan.model.material import ASSUMED_TUBE_STEEL
from cardan.model.parts import Tube

MIN_TUBE_OUTER_M, MAX_TUBE_OUTER_M = 15 * mm, 400 * mm
"""Outside diameters of tubes that a text may give: steering shafts to rolling mills."""

MAX_NEIGHBOURS = 3
"""Parts that a hint proposes at most."""

_NUMBER = r"(\d+(?:[.,]\d*)?|[.,]\d+)"
_UNIT = r"\s*(mm|inches|inch|in|\"|″|''|)\s*"
_SIZES = re.compile(rf"(?:tube\b|[øØ⌀])?\s*{_NUMBER}{_UNIT}[x×*]\s*{_NUMBER}{_UNIT}", re.IGNORECASE)


def tube_of_sizes(text: str) -> Tube | None:
    """Return the tube that a text gives by its sizes, OUTERxWALL; None if it gives none.

    Sizes are in mm unless an inch sign follows. The material is `ASSUMED_TUBE_STEEL`.

    Raises
    ------
    DesignError
        If no tube has such sizes.

    Examples
    --------
    >>> tube_of_sizes("100 x 4").name, tube_of_sizes('4.000x0.134"').name
    ('100x4', '4x0.134in')
    """
    found = _SIZES.fullmatch(text.strip())
    if found is None:
        return None
    first, second = (unit.casefold() for unit in (found[2], found[4]))
    units = first or second, second or first
    # A German or Italian drawing has 88,9x2,4.
    outer, wall = (
        float(number.replace(",", ".")) * (mm if unit in ("", "mm") else inch)
        for number, unit in zip((found[1], found[3]), units, strict=True)
    )
    if not MIN_TUBE_OUTER_M <= outer <= MAX_TUBE_OUTER_M:
        msg = (
            f"the outside diameter of a tube must be within {MIN_TUBE_OUTER_M / mm:g} to "
            f"{MAX_TUBE_OUTER_M / mm:g} mm, got {outer / mm:.6g} mm; write the unit behind the "
            "sizes, mm or in"
        )
        raise DesignError(msg)
    inches = not {"", "mm"} & set(units)
    unit_size, suffix = (inch, "in") if inches else (mm, "")
    return Tube(
        outer=outer,
        wall=wall,
        material=ASSUMED_TUBE_STEEL,
        name=f"{outer / unit_size:.6g}x{wall / unit_size:.6g}{suffix}",
    )


def tube_size_hint(text: str, tubes: Mapping[str, Tube]) -> str:
    """Return what to write for a tube that no catalogue has: sizes, and its neighbours in size."""
    written = [float(n.replace(",", ".")) for n in re.findall(_NUMBER, text)[:2]]
    advice = "write outside diameter x wall: 100x4 in mm, 4.000x0.134in in inches"
    if not written or not written[0]:
        return advice
    inches = re.search(r"in\b|\"|″|''", text) is not None
    sizes = [n * (inch if inches else mm) for n in written]

    def distance(of: Tube) -> float:
        own = (of.outer, of.wall)
        return sum(abs(log(a / b)) for a, b in zip(own, sizes, strict=False) if b > 0)

    near = sorted(tubes, key=lambda name: distance(tubes[name]))[:MAX_NEIGHBOURS]
    return f"{advice}; nearest in size: {', '.join(near)}"


def joint_size_hint(text: str, peak_torques: Mapping[str, float | None]) -> str:
    """Return the neighbours in size of a joint that no catalogue has, by its series' number.

    A name is a series and a number: 1715 lies between 1710 and 1760 of the same series. Joints
    of another series have no order with it: without a series of its own the hint is empty.
    """
    series, number = _series_and_number(text)
    same = {
        name: own
        for name in peak_torques
        if (parts := _series_and_number(name))[0] == series and (own := parts[1]) < inf
    }
    if number == inf or not same:
        return ""
    below = sorted((n for n in same if same[n] <= number), key=same.__getitem__)[-1:]
    above = sorted((n for n in same if same[n] > number), key=same.__getitem__)[:1]
    return "neighbours in size: " + ", ".join(_rated(n, peak_torques[n]) for n in below + above)


def _rated(name: str, peak_torque: float | None) -> str:
    return name if peak_torque is None else f"{name} (peak {peak_torque:.5g} N·m)"


def _series_and_number(name: str) -> tuple[str, float]:
    """Return the letters of a name, in order, and its number: SPL140 is ("spl", 140)."""
    bare = re.sub(r"[\s_-]|\bjoint\b", "", name.casefold())
    digits = re.findall(r"\d+(?:\.\d+)?", bare)
    series = re.sub(r"\d+(?:\.\d+)?", "#", bare)
    if digits and series == "#":  # Spicer's 1310 and GWB's 2015 are four digits each
        series = f"#{digits[0][0] if len(digits[0]) == 4 else len(digits[0])}"
    return series, float(digits[-1]) if digits else inf
