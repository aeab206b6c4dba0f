"""An application before and after a change of its vehicle's wheelbase, as texts of files.

The rear axle moves along the frame and the gearbox stays, with all centre bearings: the last
shaft of each line between them takes up the difference.
"""

from pathlib import Path

import numpy as np

from cardan.application.layout_writer import FileChanges, layout_changes, yaml_address_of_line
from cardan.application.reader import loads
from cardan.application.yaml_edit import YamlEditor
from cardan.core.errors import DesignError
from cardan.core.units import UNITS, Metre, mm
from cardan.model.application import Application, InstalledLine
from cardan.model.layout import layout_from_points

MIN_LAST_SHAFT_M = 300 * mm
"""Length that a last shaft keeps at least: two yokes and a spline fill less."""


def text_with_wheelbase(
    text: str,
    *,
    wheelbase: Metre,
    from_wheelbase: Metre | None = None,
    name: str = "application",
    folder: Path | None = None,
) -> str:
    """Return the text of an application with its rear axle moved to another wheelbase.

    Parameters
    ----------
    text, name, folder
        The application, what errors call it, and where the files that it names lie.
    wheelbase : m
        The new one.
    from_wheelbase : m
        That of the text, if it has no `vehicle.wheelbase`.

    Raises
    ------
    DesignError
        If the last shaft would be shorter than `MIN_LAST_SHAFT_M`, or states give a geometry of
        their own, which only their author can change.
    """
    application, editor = loads(text, name=name, folder=folder), YamlEditor(text, name)
    own = application.vehicle.wheelbase if application.vehicle else None
    now = float(own) if isinstance(own, (int, float)) else from_wheelbase
    if now is None:
        msg = "the wheelbase is not known: give vehicle.wheelbase_mm, or the one to start from"
        raise DesignError(msg)
    if any(state.layouts for state in application.states):
        msg = "states with a geometry of their own stay as they are: change the wheelbase by hand"
        raise DesignError(msg)
    shift, changes = wheelbase - now, FileChanges()
    for installed in lines_that_follow_rear_axle(application) if abs(shift) > 1e-9 else ():
        changes |= _line_changes(installed, shift, editor)
    for unit in UNITS:
        if f"vehicle.wheelbase_{unit}" in editor:
            changes[f"vehicle.wheelbase_{unit}"] = round(wheelbase / UNITS[unit], 6)
    return editor.with_changes(changes)


def lines_that_follow_rear_axle(application: Application) -> tuple[InstalledLine, ...]:
    """Return the lines from the gearbox to a rear axle: those between axles move as they are."""
    return tuple(
        i
        for i in application.lines
        if i.output_joint is None and i.drives != "front" and not i.forward and i.line.has_lengths
    )


def _line_changes(installed: InstalledLine, shift: Metre, text: YamlEditor) -> FileChanges:
    """Return what changes of a line whose last joint moves rearward by a shift."""
    was = installed.layout
    points = np.array(was.points)
    points[-1, 0] += shift
    moved = layout_from_points(points, gearbox=was.directions[0], pinion=was.directions[-1])
    length, reach = float(moved.lengths[-1]), float(points[-1, 0] - points[-2, 0])
    if reach < MIN_LAST_SHAFT_M:
        msg = (
            f"the last joint of line {installed.line.name} must lie at least "
            f"{MIN_LAST_SHAFT_M / mm:.0f} mm behind the one ahead, got {reach / mm:.0f} mm: such a "
            "wheelbase needs a line with one shaft less"
        )
        raise DesignError(msg)
    changes = layout_changes(installed, moved, text)
    last = len(installed.line.shafts)
    at = f"{yaml_address_of_line(installed, text)}.shafts[{last}].tube_length"
    tube = installed.line.shafts[-1].tube_length
    for unit in UNITS:
        if tube is not None and f"{at}_{unit}" in text:
            longer = tube + length - float(was.lengths[-1])
            changes[f"{at}_{unit}"] = round(longer / UNITS[unit], 6)
    return changes
