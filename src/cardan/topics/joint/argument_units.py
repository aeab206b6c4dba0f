"""Units that the arguments of `cardan joint` and `cardan.joint` take; the first is the default."""

ANGLE_UNITS = ("deg", "rad")
SPEED_UNITS = ("rpm", "rad_s")
TORQUE_UNITS = ("Nm", "kNm", "lbft")
LENGTH_UNITS = ("mm", "m", "in")
ACCELERATION_UNITS = ("rad_s2",)
SHARE_UNITS = ("percent", "1")

ARGUMENT_UNITS: dict[str, tuple[str, ...]] = {
    "angle": ANGLE_UNITS,
    "speed": SPEED_UNITS,
    "angle2": ANGLE_UNITS,
    "phase": ANGLE_UNITS,
    "plane_angle": ANGLE_UNITS,
    "torque": TORQUE_UNITS,
    "across": LENGTH_UNITS,
    "acceleration_limit": ACCELERATION_UNITS,
    "irregularity_limit": SHARE_UNITS,
}
"""Units of each argument, by its name in Python."""
