"""Parameters of the lines for multibody and 1D models: CSV, MATLAB script and MATLAB data.

One tree of named values in SI units, with unit and meaning, written in three ways. What is not
known is nan; what is rigid has an infinite stiffness.
"""

import csv
import io
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from cardan.approval.approval import Approval
from cardan.checks.line_response import LineResponse
from cardan.core.version import __version__
from cardan.model.parts import CentreBearing, Flange, JointSize, Shaft
from cardan.physics.loads.rubber_mount import DEFAULT_LOSS_FACTOR


class Parameter(NamedTuple):
    """A value, or a vector of three, in SI units."""

    value: float | tuple[float, ...] | str
    unit: str = ""
    meaning: str = ""


Group: TypeAlias = Mapping[str, Any]
"""Parameters, and lists of groups, by name."""

_HEAD = (
    "SI units; x rearward, y to the right, z up; NaN is not known, Inf is rigid.",
    "Yoke phase: rear yoke ahead of the front one, clockwise seen from the gearbox; 0 in phase.",
)


def parameter_sheet(of: Approval) -> Group:
    """Return inertias, stiffness, angles and phases of each line, in each state."""
    return {
        "title": Parameter(of.application.title),
        "line": [_line(r) for r in of.line_responses],
    }


def _line(r: LineResponse) -> Group:
    """Return the parameters of one line."""
    line = r.line
    bearings = line.centre_bearings
    return {
        "name": Parameter(line.name),
        "joint": [
            _joint(k, size) for k, size in zip(line.joint_kinds, r.inputs.joint_sizes, strict=True)
        ],
        "shaft": [_shaft(s) for s in line.shafts],
        "centre_bearing": [_bearing(b) for b in bearings],
        "gearbox_flange": [_flange(line.gearbox_flange)],
        "pinion_flange": [_flange(line.pinion_flange)],
        "state": [_state(r, s) for s in range(len(r.demand.states))],
    }


def _joint(kind: str, size: JointSize | None) -> Group:
    torsion = size.torsional_stiffness if size else None
    bending = size.bending_stiffness if size else None
    return {
        "kind": Parameter(kind),
        "torsional_stiffness": Parameter(_or(torsion, np.inf), "N m/rad", "of a flexible disc"),
        "bending_stiffness": Parameter(_or(bending, 0.0), "N m/rad", "against its angle"),
    }


def _shaft(of: Shaft) -> Group:
    tube = of.tube
    flexibility = of.torsional_flexibility
    # Yokes weigh on the axis twice what a tube does: without them no inertia is the shaft's.
    whole = of.polar_inertia_given is not None or of.yoke_inertia or of.yoke_inertias
    along = tube.polar_inertia_per_length * of.length if tube else np.nan
    return {
        "length": Parameter(of.length, "m", "joint centre to joint centre"),
        "mass": Parameter(of.mass if tube else np.nan, "kg", "tube, yokes and spline"),
        "polar_inertia": Parameter(
            _or(of.polar_inertia) if whole else np.nan, "kg m^2", "about its axis, with its yokes"
        ),
        "tube_polar_inertia": Parameter(along, "kg m^2", "the tube's share of it"),
        "torsional_stiffness": Parameter(
            1 / flexibility if flexibility else np.nan, "N m/rad", "tube between its yokes"
        ),
        "bending_stiffness": Parameter(
            tube.bending_stiffness if tube else np.nan, "N m^2", "E I of the tube"
        ),
        "yoke_phase": Parameter(of.phase, "rad", "without torque"),
    }


def _bearing(of: CentreBearing) -> Group:
    across = of.transverse_stiffness or (np.inf, np.inf)
    assumed = of.loss_factor is None
    return {
        "from_rear_joint": Parameter(of.from_rear_joint, "m", "ahead of the shaft's rear joint"),
        "vertical_stiffness": Parameter(across[0], "N/m", "rubber and bracket"),
        "lateral_stiffness": Parameter(across[1], "N/m", "rubber and bracket"),
        "axial_stiffness": Parameter(_or(of.axial_stiffness, 0.0), "N/m", "0 slides freely"),
        "loss_factor": Parameter(
            _or(of.loss_factor, DEFAULT_LOSS_FACTOR),
            "1",
            "of the rubber" + (", assumed" if assumed else ""),
        ),
    }


def _flange(of: Flange) -> Group:
    vertical, lateral = of.stiffness or (np.inf, np.inf)
    return {
        "vertical_stiffness": Parameter(vertical, "N/m", "at the joint centre"),
        "lateral_stiffness": Parameter(lateral, "N/m", "at the joint centre"),
        "loss_factor": Parameter(of.loss_factor, "1"),
        "mass": Parameter(of.mass, "kg", "that moves with the joint centre"),
    }


def _state(r: LineResponse, s: int) -> Group:
    """Return where a line runs in a state, and under what."""
    layout, demand = r.inputs.layout, r.demand
    twisted = r.line.phases_under_torque(r.inputs.phases, np.nan_to_num(demand.torque))
    phases = np.broadcast_to(twisted, (len(demand.states), len(r.line.shafts)))
    return {
        "name": Parameter(demand.states[s]),
        "kind": Parameter(r.inputs.state_kinds[s]),
        "torque": Parameter(float(demand.torque[s]), "N m", "largest, at the line's front"),
        "speed": Parameter(float(demand.speed[s]), "rad/s", "top speed"),
        "joint": [
            {
                "position": Parameter(tuple(x), "m", "of the joint centre"),
                "angle": Parameter(angle, "rad", "between its two members, in space"),
            }
            for x, angle in zip(
                layout.points[s].tolist(), r.inputs.joint_angles[s].tolist(), strict=True
            )
        ],
        "member": [
            {
                "direction": Parameter(
                    tuple(d), "1", "unit vector rearward; gearbox output first, pinion last"
                ),
            }
            for d in layout.directions[s].tolist()
        ],
        "shaft": [
            {"yoke_phase": Parameter(phase, "rad", "as the torque twists it")}
            for phase in phases[s].tolist()
        ],
    }


def _or(value: float | None, other: float = np.nan) -> float:
    return other if value is None else value


# --------------------------------------------------------------------------- writing


def _csv(sheet: Group) -> bytes:
    """Return a row for each number: its name as MATLAB writes it, value, unit, meaning."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(("parameter", "value", "unit", "meaning"))
    for path, p in _leaves(sheet):
        if isinstance(p.value, tuple):
            for k, value in enumerate(p.value, 1):
                table.writerow((f"{path}({k})", _text(value), p.unit, p.meaning))
        else:
            table.writerow(
                (path, p.value if isinstance(p.value, str) else _text(p.value), p.unit, p.meaning)
            )
    return text.getvalue().encode()


def _script(sheet: Group) -> bytes:
    """Return a MATLAB script that makes the struct `cardan`."""
    lines = [f"% cardan {__version__}", *(f"% {line}" for line in _HEAD)]
    for path, p in _leaves(sheet):
        if isinstance(p.value, str):
            value = "'" + p.value.replace("'", "''").replace("\n", " ") + "'"
        elif isinstance(p.value, tuple):
            value = "[" + " ".join(map(_text, p.value)) + "]"
        else:
            value = _text(p.value)
        said = ", ".join(filter(None, (p.unit, p.meaning)))
        lines.append(f"cardan.{path} = {value};" + (f" % {said}" if said else ""))
    return ("\n".join(lines) + "\n").encode()


def _data(sheet: Group) -> bytes:
    """Return MATLAB data of version 5 with the same struct."""
    from scipy.io import savemat

    found: Any = io.BytesIO()  # which it takes as well as a name
    savemat(found, {"cardan": _struct(sheet)}, long_field_names=True)
    return found.getvalue()


WRITERS: Mapping[str, Callable[[Group], bytes]] = {".csv": _csv, ".m": _script, ".mat": _data}
"""Writers of a parameter sheet, by the ending of the file's name."""


def _leaves(group: Group, path: str = "") -> Iterator[tuple[str, Parameter]]:
    """Yield every parameter with its name, those of lists numbered from 1."""
    for name, value in group.items():
        if isinstance(value, Parameter):
            yield f"{path}{name}", value
        else:
            for k, each in enumerate(value, 1):
                yield from _leaves(each, f"{path}{name}({k}).")


def _struct(group: Group) -> dict[str, Any]:
    """Return a group as a struct, and lists of groups as arrays of them."""
    found: dict[str, Any] = {}
    for name, value in group.items():
        if isinstance(value, Parameter):
            found[name] = (
                value.value if isinstance(value.value, str) else np.array(value.value, float)
            )
        elif not value:  # another line may have some: structs of an array have the same fields
            found[name] = np.zeros((0, 0))
        else:
            each = [_struct(g) for g in value]
            kinds = [(key, object) for key in each[0]]
            found[name] = np.array([tuple(e.values()) for e in each], dtype=kinds)
    return found


def _text(value: float) -> str:
    """Return a number as MATLAB reads it, to nine digits."""
    return {"nan": "NaN", "inf": "Inf", "-inf": "-Inf"}.get(text := f"{value:.9g}", text)
