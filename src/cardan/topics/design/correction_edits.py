"""A correction as the numbers of the file that change, so that its check gives what was proposed.

A bearing that moves shifts the joints after it, a shim the last one too; a file by slopes changes
its slopes and lengths, a file by points its points. States with a geometry of their own, the place
of the last joint on its axle, the travel left in the spline and the ranges of `adjust`, which count
from where things are, change with them.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cardan.application.layout_writer import (
    FileChanges,
    adjustment_range_changes,
    bearing_changes,
    joint_place_changes,
    layout_changes,
    phase_changes,
    spline_changes,
    state_layout_changes,
    yaml_address_of_line,
)
from cardan.application.yaml_edit import YamlEditor, format_as_yaml_value
from cardan.approval.applied_adjustments import AppliedAdjustment, corrected_application
from cardan.checks.line_response import LineResponse
from cardan.core.errors import DesignError
from cardan.model.adjustments import ADJUSTMENTS
from cardan.model.application import Application, InstalledLine
from cardan.topics.design.correction import Correction


def correction_changes(
    response: LineResponse, moves: Sequence[AppliedAdjustment], text: YamlEditor
) -> FileChanges:
    """Return the numbers of a text that change with moves of one line, by address.

    Parameters
    ----------
    response
        The line as the text has it.
    moves
        What is moved, and by how much.
    text
        The application's own text.

    Raises
    ------
    DesignError
        If the text cannot say where the line would run.
    """
    before = response.application
    after = corrected_application(
        response, tuple(m.adjustable for m in moves), np.array([m.amount for m in moves])
    )
    changes: FileChanges = {}
    for was, now in zip(before.lines, after.lines, strict=True):
        if was is not now:
            changes |= _line_changes(was, now, before, text)
    for was, now in zip(before.states, after.states, strict=True):
        for name, layout in (now.layouts or {}).items():
            line = next(i for i in before.lines if i.line.name == name)
            old = (was.layouts or {})[name]
            changes |= state_layout_changes(was.name, line, old, layout, text)
    at = yaml_address_of_line(response.demand.installed, text)
    for m in moves:
        kind = ADJUSTMENTS[m.adjustable.adjustment_key]
        key = f"{at}.adjust.{kind.key}" if f"{at}.adjust" in text else f"adjust.{kind.key}"
        changes |= adjustment_range_changes(
            key, m.adjustable.part, m.amount, kind.count(response.line), text
        )
    return changes


@dataclass(frozen=True, slots=True, kw_only=True)
class CorrectedText:
    """An application's text with a correction in it, and the numbers that differ.

    Attributes
    ----------
    text
        The file as it reads then; comments and order stay.
    changes
        Address, value as written before ("" where none stood), value written now.
    """

    text: str
    changes: tuple[tuple[str, str, str], ...]


def corrected_text(of: Correction) -> CorrectedText:
    """Return the text of an application with a correction of it written in.

    Raises
    ------
    DesignError
        If the text cannot say where the line would run, or nothing was read from a text.
    InvalidFileError
        If a number cannot be changed where it stands, as of a name that stands for several.
    """
    application = of.installed_approval.application
    if application.written is None:
        msg = "a correction is written into the text of a file: this application was not read"
        raise DesignError(msg)
    editor = YamlEditor(application.written.text, application.written.name)
    response = next(r for r in of.installed_approval.line_responses if r.line.name == of.line)
    changes = correction_changes(response, of.adjustments, editor)
    return CorrectedText(
        text=editor.with_changes(changes),
        changes=tuple(
            (at, editor.scalar_text(at) or "", format_as_yaml_value(to, ""))
            for at, to in changes.items()
        ),
    )


def _line_changes(
    was: InstalledLine, now: InstalledLine, of: Application, text: YamlEditor
) -> FileChanges:
    """Return what changes of one line: where it runs, how it is built, where its ends sit."""
    at = yaml_address_of_line(was, text)
    changes = layout_changes(was, now.layout, text)
    changes |= phase_changes(was, now.line.phases, text)
    changes |= bearing_changes(was, now.line, text)
    changes |= spline_changes(was, float(now.layout.lengths[-1] - was.layout.lengths[-1]), text)
    if was.axle and now.axle:
        # The axle of several lines stays as it is written: only one of them was moved.
        own = f"{at}.axle" if f"{at}.axle" in text else "axle" if len(of.lines) == 1 else ""
        changes |= joint_place_changes(
            f"{own}.pinion", was.axle.pinion_joint, now.axle.pinion_joint, text
        )
    if was.output_joint and now.output_joint:
        changes |= joint_place_changes(
            f"{at}.output_joint", was.output_joint, now.output_joint, text
        )
    return changes
