"""A collective of torque and speed, in time at level, and the section `duty` that it makes."""

import re

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.errors import DesignError
from cardan.core.lazy_dataclass import dataclass
from cardan.core.message import TranslatableMessage
from cardan.core.units import rpm
from cardan.schema.yaml_tree import to_one_line

LIFE_EXPONENT = 10 / 3
"""Exponent of torque in the life of needle bearings, ISO 281."""
TORQUE_CLASSES, SPEED_CLASSES = 8, 6
MIN_DRIVING_SPEED_RPM = 1.0
"""Speed of the line below which the vehicle stands."""
MAX_ORIGIN_CHARACTERS = 160
DUTY_HINT = "# duty: regional                  # how the life is spent; or `cardan new --vmod`"
"""A line of an imported application that a section `duty` replaces."""
_DUTY_HEAD = """\
duty:                             # {origin}
  # {duration:.0f} s, {driving:.1f} % of it in motion: shares and hours are of that time
  # {overrun:.1f} % of that in overrun, with the size of its torque; power means of torque, 10/3"""
_DUTY_SECTION = re.compile(
    r"(?m)^duty:[^\n]*(?:\n|\Z)(?:(?:#[^\n]*\n)*(?:[ \t]+|- )[^\n]*(?:\n|\Z))*"
)


@dataclass(frozen=True, kw_only=True)
class DutyCollective:
    """Time at level of torque and speed of a trip.

    Attributes
    ----------
    origin
        Where it is from, and whether that is measured or simulated.
    share, torque, speed
        Of the time in motion, 1; size of the torque, N m; speed, rad/s; each (classes,).
    duration, driving_share, overrun_share
        Of the trip, s; of it in motion; of the motion with torque from the wheels.
    """

    origin: TranslatableMessage
    share: FloatArray
    torque: FloatArray
    speed: FloatArray
    duration: float
    driving_share: float
    overrun_share: float


def duty_collective(
    step: FloatArray, torque: FloatArray, speed: FloatArray, *, origin: TranslatableMessage
) -> DutyCollective:
    """Return the collective of a trip at the gearbox output.

    Parameters
    ----------
    step, torque, speed
        Duration of each interval, s; its torque, N m, negative in overrun; its speed, rad/s;
        (rows,).
    origin
        Where they are from.

    Raises
    ------
    DesignError
        If the vehicle never moves.
    """
    drives = speed > MIN_DRIVING_SPEED_RPM * rpm
    moving = float(step[drives].sum())
    if not moving > 0:
        msg = "the vehicle never moves"
        raise DesignError(msg)
    share, size, turns = duty_classes(step[drives], torque[drives], speed[drives])
    return DutyCollective(
        origin=origin,
        share=share,
        torque=size,
        speed=turns,
        duration=float(step.sum()),
        driving_share=moving / float(step.sum()),
        overrun_share=float(step[drives & (torque < 0)].sum()) / moving,
    )


def duty_classes(
    step: FloatArray, torque: FloatArray, speed: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return share, torque (N m) and speed (rad/s) of each class that occurs, (classes,).

    A class has the mean speed of its time, and the power mean of its torques over its turns that
    wears needle bearings as much at the same joint angle (exponent 10/3, ISO 281).

    Parameters
    ----------
    step, torque, speed
        Duration of each interval in motion, s; its torque, N m, negative in overrun; its speed,
        rad/s; (rows,).
    """
    size = np.abs(torque)
    rows = _class_of(size, TORQUE_CLASSES) * SPEED_CLASSES + _class_of(speed, SPEED_CLASSES)
    count = TORQUE_CLASSES * SPEED_CLASSES
    time = np.bincount(rows, step, count)
    turns = np.bincount(rows, step * speed, count)
    wear = np.bincount(rows, step * speed * size**LIFE_EXPONENT, count)
    there = time > 0
    return (
        time[there] / time.sum(),
        (wear[there] / turns[there]) ** (1 / LIFE_EXPONENT),
        turns[there] / time[there],
    )


def _class_of(values: FloatArray, count: int) -> FloatArray:
    """Return the class of each value, from 0: equal parts up to the largest."""
    most = float(values.max()) or 1.0
    return np.minimum((values / most * count).astype(int), count - 1)


def duty_section(of: DutyCollective) -> str:
    """Return the section `duty` of an application, with where it is from."""
    head = _DUTY_HEAD.format(
        origin=to_one_line(str(of.origin))[:MAX_ORIGIN_CHARACTERS],
        duration=of.duration,
        driving=100 * of.driving_share,
        overrun=100 * of.overrun_share,
    )
    rows = [
        f"  - {{share_percent: {100 * share:.4g}, torque_Nm: {torque:.4g}, "
        f"speed_rpm: {speed / rpm:.4g}}}"
        for share, torque, speed in zip(of.share, of.torque, of.speed, strict=True)
    ]
    return "\n".join([head, *rows])


def text_with_duty(text: str, section: str) -> str:
    """Return the text of an application with another section `duty`, where that stood or last."""
    if DUTY_HINT in text:
        return text.replace(DUTY_HINT, section, 1)
    found = _DUTY_SECTION.search(text)
    if found is None:
        return f"{text.rstrip()}\n\n{section}\n"
    return f"{text[: found.start()]}{section}\n{text[found.end() :]}"
