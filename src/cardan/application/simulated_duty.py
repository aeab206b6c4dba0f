"""A duty cycle from a simulated trip: torque and speed of VECTO's modal results.

Sources: VECTO User Manual, chapter on modal results (.vmod): each row is the mean of an interval;
for VECTO 2, results of its 40 t truck that the Commission published with VECTO 3 beta.
"""

from pathlib import Path

import numpy as np

from cardan.application.duty_collective import DutyCollective, duty_collective
from cardan.application.vecto_files import (
    POWER,
    ROAD_SPEED,
    ROTATION_SPEED,
    TIME,
    TORQUE,
    VectoTable,
    read_table,
)
from cardan.core.arrays import FloatArray
from cardan.core.errors import DesignError, FileIssue, InvalidFileError
from cardan.core.message import translatable_message

_COLUMNS = frozenset({
    "time", "dt", "v_act", "n_gbx_out_avg", "t_gbx_out", "p_axle_in", "pwheel", "pbrake",
    "ploss diff",
})  # fmt: skip
_ASKED = (
    "T_gbx_out and n_gbx_out_avg", "P_axle_in and v_act", "Pwheel, Pbrake, Ploss Diff and v_act",
)  # fmt: skip
_UNITS = {
    "time": TIME, "dt": TIME, "v_act": ROAD_SPEED, "n_gbx_out_avg": ROTATION_SPEED,
    "T_gbx_out": TORQUE, "P_axle_in": POWER, "Pwheel": POWER, "Pbrake": POWER, "Ploss Diff": POWER,
}  # fmt: skip


def read_simulated_duty(
    path: Path,
    *,
    axle_ratio: float | None = None,
    dynamic_radius: float | None = None,
    largest_torque: float = np.inf,
) -> DutyCollective:
    """Return the duty cycle of the gearbox output in modal results of VECTO.

    Torque and speed are those of the gearbox output where the file has them. Else they follow from
    the power into the axle and the road speed, by `axle_ratio` and `dynamic_radius` (m), up to the
    `largest_torque` (N m) that the engine gives there: close to rest, means of power and speed
    over an interval do not make a torque. Units are those of the headings. VECTO 2 writes
    no power into the axle: it is that at the wheels, less that of the brakes (0 or below), and the
    loss of the axle.

    Raises
    ------
    InvalidFileError
        If a column is missing or in an unknown unit, or the vehicle never moves.
    """
    table = read_table(path, only=_COLUMNS)
    step, time = _in_si(table, "dt"), _in_si(table, "time")
    if step is None and time is not None:
        step = np.diff(time, append=time[-1])
    if step is None or not (step >= 0).all():
        raise table.missing(("dt [s]", "time [s]"))
    torque, speed = _in_si(table, "T_gbx_out"), _in_si(table, "n_gbx_out_avg")
    if torque is not None and speed is not None and not np.isnan(torque + speed).any():
        columns: tuple[str, ...] = ("T_gbx_out", "n_gbx_out_avg")
    else:
        power, columns = _axle_power(table)
        road = _in_si(table, "v_act")
        if power is None or road is None or np.isnan(power + road).any():
            raise table.missing(_ASKED)
        if axle_ratio is None or dynamic_radius is None:
            issue = FileIssue(
                message="gives power and road speed: torque needs axle.ratio and a tyre radius",
                hint="enter axle and tyre in the application",
            )
            raise InvalidFileError(str(path), (issue,))
        speed = road / dynamic_radius * axle_ratio
        turning = np.where(speed > 0, speed, np.inf)
        torque = np.clip(power / turning, -largest_torque, largest_torque)
    origin = translatable_message(
        "simulated, not measured: VECTO, {file}, columns {columns}",
        file=path.name,
        columns=columns,
    )
    try:
        return duty_collective(step, torque, speed, origin=origin)
    except DesignError as error:
        raise InvalidFileError(str(path), (FileIssue(message=str(error)),)) from None


def _axle_power(table: VectoTable) -> tuple[FloatArray | None, tuple[str, ...]]:
    """Return the power into the axle, W, (rows,), and its columns; None where there are none."""
    if (power := _in_si(table, "P_axle_in")) is not None:
        return power, ("P_axle_in", "v_act")
    wheel, brake, loss = (_in_si(table, name) for name in ("Pwheel", "Pbrake", "Ploss Diff"))
    if wheel is None or brake is None or loss is None:
        return None, ()
    return wheel - brake + loss, ("Pwheel", "Pbrake", "Ploss Diff", "v_act")


def _in_si(table: VectoTable, name: str) -> FloatArray | None:
    """Return a column in SI by the unit of its heading, (rows,); None where there is none."""
    return table.find_in_si(name, unit=_UNITS[name])
