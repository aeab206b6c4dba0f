"""A duty cycle from a simulated trip: classes of torque and speed of VECTO's modal results.

Source: VECTO User Manual, chapter on modal results (.vmod): each row is the mean of an interval.
"""

import re
from pathlib import Path

import numpy as np

from cardan.application.vecto_files import read_table
from cardan.core.arrays import FloatArray
from cardan.core.errors import FileIssue, InvalidFileError
from cardan.core.lazy_dataclass import dataclass
from cardan.core.units import rpm

LIFE_EXPONENT = 10 / 3
"""Exponent of torque in the life of needle bearings, ISO 281."""
TORQUE_CLASSES, SPEED_CLASSES = 8, 6
MIN_DRIVING_SPEED_RPM = 1.0
"""Speed of the line below which the vehicle stands."""
DUTY_HINT = "# duty: regional                  # how the life is spent; or `cardan new --vmod`"
"""A line of an imported application that a section `duty` replaces."""
_DUTY_HEAD = """\
duty:                             # simulated, not measured: VECTO, {file}, columns {columns}
  # {duration:.0f} s, {driving:.1f} % of it in motion: shares and hours are of that time
  # {overrun:.1f} % of that in overrun, with the size of its torque; power means of torque, 10/3"""
_DUTY_SECTION = re.compile(r"(?m)^duty:[^\n]*(?:\n|\Z)(?:(?:[ \t]+|- )[^\n]*(?:\n|\Z))*")
_COLUMNS = frozenset({"time", "dt", "v_act", "n_gbx_out_avg", "t_gbx_out", "p_axle_in"})


@dataclass(frozen=True, kw_only=True)
class SimulatedDuty:
    """Classes of a trip.

    Attributes
    ----------
    file
        Its name.
    share, torque, speed
        Of the time in motion, 1; size of the torque, N m; speed, rad/s; each (classes,).
    duration, driving_share, overrun_share
        Of the trip, s; of it in motion; of the motion with torque from the wheels.
    columns
        The columns that torque and speed are of.
    """

    file: str
    share: FloatArray
    torque: FloatArray
    speed: FloatArray
    duration: float
    driving_share: float
    overrun_share: float
    columns: str


def read_simulated_duty(
    path: Path,
    *,
    axle_ratio: float | None = None,
    dynamic_radius: float | None = None,
    largest_torque: float = np.inf,
) -> SimulatedDuty:
    """Return the duty cycle of the gearbox output in modal results of VECTO.

    Torque and speed are those of the gearbox output where the file has them. Else they follow from
    the power into the axle and the road speed, by `axle_ratio` and `dynamic_radius` (m), up to the
    `largest_torque` (N m) that the engine gives there: close to rest, means of power and speed
    over an interval do not make a torque.

    Raises
    ------
    InvalidFileError
        If a column is missing, or the vehicle never moves.
    """
    table = read_table(path, only=_COLUMNS)
    step, time = table.find("dt"), table.find("time")
    if step is None and time is not None:
        step = np.diff(time, append=time[-1])
    if step is None or not (step >= 0).all():
        raise table.missing(("dt [s]", "time [s]"))
    torque, speed, columns = table.find("T_gbx_out"), table.find("n_gbx_out_avg"), ""
    if torque is not None and speed is not None and not np.isnan(torque + speed).any():
        speed, columns = speed * rpm, "T_gbx_out and n_gbx_out_avg"
    else:
        power, road = table.find("P_axle_in"), table.find("v_act")
        if power is None or road is None or np.isnan(power + road).any():
            raise table.missing(("T_gbx_out and n_gbx_out_avg", "P_axle_in and v_act"))
        if axle_ratio is None or dynamic_radius is None:
            issue = FileIssue(
                message="gives power and road speed: torque needs axle.ratio and a tyre radius",
                hint="enter axle and tyre in the application",
            )
            raise InvalidFileError(str(path), (issue,))
        speed = road / 3.6 / dynamic_radius * axle_ratio
        turning = np.where(speed > 0, speed, np.inf)
        torque = np.clip(1e3 * power / turning, -largest_torque, largest_torque)
        columns = "P_axle_in and v_act"
    drives = speed > MIN_DRIVING_SPEED_RPM * rpm
    if not (step[drives] > 0).any():
        issue = FileIssue(message="the vehicle never moves in these results")
        raise InvalidFileError(str(path), (issue,))
    moving = float(step[drives].sum())
    share, size, turns = duty_classes(step[drives], torque[drives], speed[drives])
    return SimulatedDuty(
        file=path.name,
        share=share,
        torque=size,
        speed=turns,
        duration=float(step.sum()),
        driving_share=moving / float(step.sum()),
        overrun_share=float(step[drives & (torque < 0)].sum()) / moving,
        columns=columns,
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


def duty_section(of: SimulatedDuty) -> str:
    """Return the section `duty` of an application, with where it is from."""
    head = (
        _DUTY_HEAD.format(file=of.file, columns=of.columns, duration=of.duration,
                          driving=100 * of.driving_share, overrun=100 * of.overrun_share),
    )  # fmt: skip
    rows = [
        f"  - {{share_percent: {100 * share:.4g}, torque_Nm: {torque:.4g}, "
        f"speed_rpm: {speed / rpm:.4g}}}"
        for share, torque, speed in zip(of.share, of.torque, of.speed, strict=True)
    ]
    return "\n".join([*head, *rows])


def text_with_duty(text: str, section: str) -> str:
    """Return the text of an application with another section `duty`, where that stood or last."""
    if DUTY_HINT in text:
        return text.replace(DUTY_HINT, section, 1)
    found = _DUTY_SECTION.search(text)
    if found is None:
        return f"{text.rstrip()}\n\n{section}\n"
    return f"{text[: found.start()]}{section}\n{text[found.end() :]}"
