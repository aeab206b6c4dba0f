"""Units that channels of a recording are written in, and what each is worth in SI."""

import math
from collections.abc import Mapping

from cardan.core.units import rpm

RADIANS_PER_TURN = 2 * math.pi
STRESS_UNITS = {
    "MPa": 1e6, "N/mm2": 1e6, "N/mm²": 1e6, "kPa": 1e3, "Pa": 1.0, "ksi": 6.894757293e6,
}  # fmt: skip
STRAIN_UNITS = {
    "um/m": 1e-6, "µm/m": 1e-6, "μm/m": 1e-6, "ue": 1e-6, "uE": 1e-6, "µε": 1e-6, "με": 1e-6,
    "ustrain": 1e-6, "microstrain": 1e-6, "m/m": 1.0, "mm/m": 1e-3, "%": 1e-2,
}  # fmt: skip
ROTATION_SPEED_UNITS = {
    "rpm": rpm / RADIANS_PER_TURN,
    "1/min": rpm / RADIANS_PER_TURN,
    "U/min": rpm / RADIANS_PER_TURN,
    "min-1": rpm / RADIANS_PER_TURN,
    "Hz": 1.0,
    "1/s": 1.0,
    "rad/s": 1 / RADIANS_PER_TURN,
}
AMPLIFIER_UNITS = ("V", "mV", "mV/V", "V/V", "mA", "A", "count", "counts", "")
"""Units of what an amplifier gives, and not of what it measures."""
VEHICLE_SPEED_UNITS = {"km/h": 1 / 3.6, "kph": 1 / 3.6, "mph": 0.44704, "m/s": 1.0}
"""Speeds of the vehicle, m/s, that turn the shaft by axle ratio and tyre."""
TORQUE_UNITS = {
    f"{force}{times}m": factor
    for force, factor in (("N", 1.0), ("kN", 1e3)) for times in ("", "·", ".", "*", " ")
}  # fmt: skip

KIND_AND_SI_FACTOR_BY_UNIT: Mapping[str, tuple[str, float]] = {
    unit: (kind, factor)
    for kind, table in (
        ("stress", STRESS_UNITS),
        ("strain", STRAIN_UNITS),
        ("speed", ROTATION_SPEED_UNITS),
        ("way", VEHICLE_SPEED_UNITS),
        ("torque", TORQUE_UNITS),
    )
    for unit, factor in table.items()
}
"""What each unit measures, and how much it is in SI."""

_POWER_SIGNS = str.maketrans({"²": "2", "³": "3", "^": "", "⁻": "-", "¹": "1"})
_SPELLINGS = {
    "r/min": "rpm", "rev/min": "rpm", "upm": "rpm", "1/min": "1/min", "min-1": "min-1",
    "/min": "1/min", "n-m": "Nm", "newtonmeter": "Nm", "newton-meter": "Nm", "kn-m": "kNm",
    "n/mm**2": "N/mm2", "n/mm2": "N/mm2", "n.mm-2": "N/mm2", "nmm-2": "N/mm2",
    "megapascal": "MPa", "pascal": "Pa", "kmh": "km/h", "km/hr": "km/h", "kmph": "km/h",
    "microm/m": "um/m", "mum/m": "um/m", "µstrain": "um/m", "μstrain": "um/m", "mue": "um/m",
    "hertz": "Hz", "meter/sec": "m/s", "m/sec": "m/s",
}  # fmt: skip
_KNOWN_BY_LOWER_CASE = {
    u.lower(): u for u in KIND_AND_SI_FACTOR_BY_UNIT
    if sum(u.lower() == other.lower() for other in KIND_AND_SI_FACTOR_BY_UNIT) == 1
}  # fmt: skip
UNITS_THAT_SAY_NOTHING = ("", "-", "--", "n/a", "none", "null", "?", "unknown", "no unit", "*")
"""What files write where they state no unit."""


def usual_unit(unit: str) -> str:
    """Return the usual spelling of a unit of a file, or the unit as it is; "" if it says nothing.

    Letters of either case where no two units differ by it: mPa is no MPa.
    """
    bare = unit.strip()
    if bare.lower() in UNITS_THAT_SAY_NOTHING:
        return ""
    if bare in KIND_AND_SI_FACTOR_BY_UNIT:
        return bare
    plain = bare.translate(_POWER_SIGNS)
    low = plain.replace(" ", "").lower()
    if low in _SPELLINGS:
        return _SPELLINGS[low]
    if plain == "mPa":
        return bare
    return _KNOWN_BY_LOWER_CASE.get(low, _KNOWN_BY_LOWER_CASE.get(plain.lower(), bare))
