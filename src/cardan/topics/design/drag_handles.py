"""What a hand can take hold of in a drawing, and the numbers of the file that follow it.

A bearing takes the line with it, the chain stays connected, as `cardan fix` moves one. A joint
is moved alone. Gearbox and pinion turn about their joint, held at the end of their stub.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import numpy as np

from cardan.application.layout_writer import (
    FileChanges,
    geometry_input_style,
    layout_changes,
    round_in_unit,
    yaml_address_of_line,
)
from cardan.application.yaml_edit import YamlEditor
from cardan.core.arrays import ArrayLike, FloatArray
from cardan.core.errors import DesignError
from cardan.core.units import UNITS, mm
from cardan.model.application import Application, InstalledLine
from cardan.model.layout import Layout, layout_from_points, unit_vector
from cardan.physics.vehicle.axle_motion import layout_after_axle_motion

HandleKind: TypeAlias = Literal["joint", "bearing", "gearbox", "pinion", "obstacle"]
HANDLE_KINDS: tuple[HandleKind, ...] = get_args(HandleKind)

STUB_SHAFT_TO_LINE_LENGTH_RATIO = 0.07
"""Length of the gearbox and pinion stubs, over that of the line; drawings show them so."""

STUB_END_DRAG_STEP_M = 2e-3
"""A slope is turned in steps of this at the stub's end, m: about a hundredth of a degree."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DragHandle:
    """Something that can be moved: the k-th of its kind, from 1, of a line.

    Obstacles count as the file lists them. `axes` are those it moves along.
    """

    kind: HandleKind
    number: int
    line: str
    axes: str


def drag_handles_of(application: Application, text: YamlEditor) -> Iterator[DragHandle]:
    """Yield what of an application can be moved by changing numbers of its text."""
    for installed in application.lines:
        name, at = installed.line.name, yaml_address_of_line(installed, text)
        said = geometry_input_style(installed, text)
        for k in range(1 if said == "points" else 2, installed.line.joint_count + 1):
            yield DragHandle(kind="joint", number=k, line=name, axes="yz")
        for k, shaft in enumerate(installed.line.shafts, 1):
            if shaft.centre_bearing:
                yield DragHandle(kind="bearing", number=k, line=name, axes="yz")
        if said == "slopes" or f"{at}.gearbox_slope" in text:
            yield DragHandle(kind="gearbox", number=1, line=name, axes="yz")
        yield DragHandle(kind="pinion", number=1, line=name, axes="yz")
    for k, obstacle in enumerate(application.obstacles, 1):
        yield DragHandle(kind="obstacle", number=k, line=obstacle.line, axes="xyz")


def input_changes_for_drag(
    application: Application, handle: DragHandle, by: ArrayLike, text: YamlEditor
) -> FileChanges:
    """Return the numbers of a text that change where something is moved by (3,) m.

    By address, in the units of their keys. Moving along an axis that the handle does not
    have moves nothing.

    Raises
    ------
    DesignError
        If there is no such handle, or its text cannot say where it would be.
    """
    asked = handle.kind, handle.number, handle.line
    known = (h for h in drag_handles_of(application, text) if (h.kind, h.number, h.line) == asked)
    found = next(known, None)
    if found is None:
        msg = f"there is no {handle.kind} {handle.number} to move in line {handle.line}"
        raise DesignError(msg)
    way = np.array([axis in found.axes for axis in "xyz"])
    shift = np.where(way, np.asarray(by, dtype=float), 0.0)
    if found.kind == "obstacle":
        return _carried(found.number, shift, text)
    installed = next(i for i in application.lines if i.line.name == found.line)
    return layout_changes(installed, _layout(installed, found, shift, text), text)


def _layout(of: InstalledLine, handle: DragHandle, shift: FloatArray, text: YamlEditor) -> Layout:
    """Return where a line runs once something of it has moved by (3,) m."""
    layout, k = of.layout, handle.number
    points, d = layout.points, layout.directions
    if handle.kind == "bearing":
        shifts = np.zeros((len(points) - 2, 3))
        shifts[k - 1] = shift
        return layout_after_axle_motion(layout, of.line, bearing_shift=shifts)
    if handle.kind == "joint":
        joints = points.copy()
        joints[k - 1] += shift
        if geometry_input_style(of, text) != "points":
            joints = _strung(joints, layout.lengths)
        return layout_from_points(joints, gearbox=d[0], pinion=d[-1])
    stub = STUB_SHAFT_TO_LINE_LENGTH_RATIO * float(np.linalg.norm(points[-1] - points[0]))
    tip = STUB_END_DRAG_STEP_M * np.round(shift / STUB_END_DRAG_STEP_M) if stub > 1 else shift
    ends = {"gearbox": d[0], "pinion": d[-1]}
    # The gearbox's stub points ahead: its end goes down where its output goes up.
    sign = -1.0 if handle.kind == "gearbox" else 1.0
    ends[handle.kind] = unit_vector(stub * ends[handle.kind] + sign * tip)
    return layout_from_points(points, **ends)


def _strung(joints: FloatArray, lengths: FloatArray) -> FloatArray:
    """Return joint centres (n, 3) m as high and as far aside, as far apart as shafts are long."""
    across = np.diff(joints[:, 1:], axis=0)
    left = lengths**2 - (across**2).sum(-1)
    if not (left > 0).all():
        msg = f"shaft {int(np.argmin(left)) + 1} is too short to reach there"
        raise DesignError(msg)
    x = joints[0, 0] + np.concatenate([[0.0], np.cumsum(np.sqrt(left))])
    return np.column_stack([x, joints[:, 1:]])


def _carried(number: int, shift: FloatArray, text: YamlEditor) -> FileChanges:
    """Return the ends of an obstacle, moved."""
    changes: FileChanges = {}
    for end in ("start", "end"):
        for u in UNITS:
            at = f"obstacles[{number}].{end}_{u}"
            for c in range(3):
                written = text.scalar_text(f"{at}[{c + 1}]")
                if written is not None and abs(shift[c]) > 1e-6 * mm:
                    now = float(written) * UNITS[u] + float(shift[c])
                    changes[f"{at}[{c + 1}]"] = round_in_unit(now, u, "length")
    return changes
