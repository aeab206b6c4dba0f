"""Units that channels of a recording are written in, and what each is worth in SI."""

import math
from collections.abc import Mapping

from cardan.base.units import rpm

TURN = 2 * math.pi
STRESS = {
    "MPa": 1e6, "N/mm2": 1e6, "N/mm²": 1e6, "kPa": 1e3, "Pa": 1.0, "ksi": 6.894757293e6,
}  # fmt: skip
STRAIN = {
    "um/m": 1e-6, "µm/m": 1e-6, "μm/m": 1e-6, "ue": 1e-6, "uE": 1e-6, "µε": 1e-6, "με": 1e-6,
    "ustrain": 1e-6, "microstrain": 1e-6, "m/m": 1.0, "mm/m": 1e-3, "%": 1e-2,
}  # fmt: skip
SPEED = {
    "rpm": rpm / TURN, "1/min": rpm / TURN, "U/min": rpm / TURN, "min-1": rpm / TURN,
    "Hz": 1.0, "1/s": 1.0, "rad/s": 1 / TURN,
}  # fmt: skip
VOLTS = ("V", "mV", "mV/V", "V/V", "mA", "A", "count", "counts", "")
"""Units of what an amplifier gives, and not of what it measures."""
DRIVEN = {"km/h": 1 / 3.6, "kph": 1 / 3.6, "mph": 0.44704, "m/s": 1.0}
"""Speeds of the vehicle, m/s, that turn the shaft by axle ratio and tyre."""
TORQUE = {
    f"{force}{times}m": factor
    for force, factor in (("N", 1.0), ("kN", 1e3)) for times in ("", "·", ".", "*", " ")
}  # fmt: skip

UNITS: Mapping[str, tuple[str, float]] = {
    unit: (kind, factor)
    for kind, table in (
        ("stress", STRESS), ("strain", STRAIN), ("speed", SPEED), ("way", DRIVEN),
        ("torque", TORQUE),
    )
    for unit, factor in table.items()
}  # fmt: skip
"""What each unit measures, and how much it is in SI."""
