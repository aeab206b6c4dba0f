"""Hardpoints of a line from a table: a CSV file, or what a spreadsheet copies."""

import re
from itertools import pairwise
from pathlib import Path

import numpy as np

from cardan.application.delimited_table import (
    LENGTH_UNITS,
    decimal_sign,
    divided_rows,
    has_more_cells,
)
from cardan.application.paste_import import parse_localised_number
from cardan.application.placeholders import text_with_value_entered
from cardan.application.source_comment import text_with_source
from cardan.application.yaml_edit import YamlEditor
from cardan.core.arrays import FloatArray
from cardan.core.errors import FileIssue, InvalidFileError
from cardan.core.lazy_dataclass import dataclass
from cardan.core.units import UNITS, deg, mm
from cardan.model.application import Application
from cardan.schema.yaml_tree import read_table_text, to_one_line

MAX_ROWS = 200
MAX_BEARING_OFFSET_M = 20 * mm
"""How far a centre bearing may be off the shaft that it carries: engineering judgement."""

_AXES = ("xyz", "lwh")
"""Headings of the axes; length, width and height of ISO 21308: rearward, right and up, too."""
_HEADING = re.compile(r"([xyzlwh])\s*[\[(_ ]?\s*(mm|cm|m|in|ft)?\s*[\])]?", re.IGNORECASE)
_JOINT = re.compile(r"joint(\d{1,2})")
_BEARING = re.compile(r"(?:cent(?:re|er))?bearing(\d{1,2})")


@dataclass(frozen=True, slots=True, kw_only=True)
class Hardpoint:
    """A named point, m, and the row of the table that it stands in."""

    name: str
    position: tuple[float, float, float]
    row: int


def read_hardpoints(path: Path) -> tuple[Hardpoint, ...]:
    """Return the points of a table: name, x, y and z, with the unit in the heading.

    Columns are divided by tabs, semicolons or commas. Numbers may have decimal commas, between
    commas in quotes. L, W and H of ISO 21308 are x, y and z: behind the first front axle, right of
    the chassis' centre line, above the frame's top.

    Raises
    ------
    InvalidFileError
        If the heading lacks a column or the unit, or with every row that cannot be read.
    """
    rows = divided_rows(read_table_text(path), str(path))[: MAX_ROWS + 1]
    if not rows:
        raise InvalidFileError(str(path), (FileIssue(message="holds no row"),))
    (at, heading), *body = rows
    axes, unit = _columns_of(heading, at, path)
    names = next(k for k in range(len(heading)) if k not in axes)
    numbers = [c[k] for _, c in body for k in axes if k < len(c)]
    decimal = decimal_sign(numbers)
    problems: list[FileIssue] = []
    found: list[Hardpoint] = []
    for line, cells in body:
        if has_more_cells(cells, heading):
            problems.append(
                FileIssue(
                    message="has more cells than the heading",
                    value=_brief(" ".join(cells)),
                    hint="write a number with a decimal comma in quotes",
                    line=line,
                )
            )
            continue
        try:
            x, y, z = (
                parse_localised_number(cells[k], decimal=decimal) * LENGTH_UNITS[unit] for k in axes
            )
            found.append(Hardpoint(name=cells[names], position=(x, y, z), row=line))
        except (ValueError, IndexError) as error:
            said = str(error) if isinstance(error, ValueError) else "needs a name, x, y and z"
            problems.append(FileIssue(message=said, value=_brief(" ".join(cells)), line=line))
    if problems:
        raise InvalidFileError(str(path), tuple(problems))
    return tuple(found)


def _brief(said: str) -> str:
    return to_one_line(said)[:60]


def _columns_of(heading: list[str], line: int, path: Path) -> tuple[tuple[int, int, int], str]:
    """Return the columns of x, y and z, and their unit."""
    named = [(k, m) for k, c in enumerate(heading) if (m := _HEADING.fullmatch(c))]
    found = {m[1].lower(): (k, m[2]) for k, m in named}
    axes = next((letters for letters in _AXES if set(letters) <= set(found)), "")
    twice = sum(m[1].lower() in axes for _, m in named) > 3
    units = {unit.lower() for letter, (_, unit) in found.items() if unit and letter in axes}
    message = ""
    if not axes or twice or len(heading) < 4:
        message = "the heading must name four columns: name, x, y and z"
    elif len(units) != 1:
        message = "the heading must name one unit: mm, cm, m, in or ft"
    if message:
        issue = FileIssue(
            message=message,
            value=_brief(" ".join(heading)),
            hint="name,x [mm],y [mm],z [mm]",
            line=line,
        )
        raise InvalidFileError(str(path), (issue,))
    first, second, third = (found[letter][0] for letter in axes)
    return (first, second, third), units.pop()


# --------------------------------------------------------------------------- into an application


def text_with_hardpoints(
    text: str, application: Application, points: tuple[Hardpoint, ...], *, source: str
) -> str:
    """Return the text of an application with the line through these points.

    Parameters
    ----------
    text, application
        An application of one line that its points describe, as text and as read.
    source
        The table's name, for errors.

    Raises
    ------
    InvalidFileError
        With every name that the line lacks, or point that cannot be where it is.
    """
    editor = YamlEditor(text)
    stem = next((a for a in editor.addresses if re.fullmatch(r"driveline\.points_\w+", a)), "")
    if len(application.lines) != 1 or not stem:
        message = "hardpoints need an application with one `driveline`, described by points"
        hint = "in it, write points_mm in place of slopes or joint_angles"
        raise InvalidFileError(source, (FileIssue(message=message, hint=hint),))
    count = len(application.lines[0].line.shafts) + 1
    named = _named(points, count, source)
    joints = np.array([named[f"joint {k}"].position for k in range(1, count + 1)])
    unit = stem.rpartition("_")[2]
    changes: dict[str, float | str | list[object]] = {
        f"{stem}[{k}][{axis}]": round(float(joints[k - 1, axis - 1] / UNITS[unit]), 4)
        for k in range(1, count + 1)
        for axis in (1, 2, 3)
    }
    if point := named.get("gearbox"):
        along = joints[0] - np.array(point.position)
        changes |= _slope_changes("driveline.gearbox_slope", along, point, source)
    if point := named.get("pinion"):
        along = np.array(point.position) - joints[-1]
        changes |= _slope_changes("driveline.pinion_slope", along, point, source)
    for k, (front, rear) in enumerate(pairwise(joints), 1):
        if point := named.get(f"centre bearing {k}"):
            place = _from_rear_joint(front, rear, point, source, k)
            changes[f"driveline.shafts[{k}].centre_bearing.from_rear_joint_mm"] = round(
                place / mm, 3
            )
    done = [stem, *(f"driveline.{n}_slope" for n in ("gearbox", "pinion") if n in named)]
    changed = editor.with_changes(changes)
    for key in done:
        if key in application.placeholders:
            changed = text_with_value_entered(changed, key)
    return text_with_source((*changes, stem), changed, Path(source).name)


def _named(points: tuple[Hardpoint, ...], joints: int, source: str) -> dict[str, Hardpoint]:
    """Return the points by their names, in the program's spelling; every joint is there."""
    allowed = [f"joint {k}" for k in range(1, joints + 1)]
    allowed += [f"centre bearing {k}" for k in range(1, joints - 1)] + ["gearbox", "pinion"]
    found: dict[str, Hardpoint] = {}
    problems: list[FileIssue] = []
    for point in points:
        name = _spelled(point.name)
        if name not in allowed:
            message, hint = "names no point of this line", f"its points: {', '.join(allowed)}"
            problems.append(
                FileIssue(message=message, value=_brief(point.name), hint=hint, line=point.row)
            )
        elif name in found:
            message = f"{name} stands in line {found[name].row} already"
            problems.append(FileIssue(message=message, value=_brief(point.name), line=point.row))
        else:
            found[name] = point
    lacking = [name for name in allowed[:joints] if name not in found]
    if lacking and not problems:
        message = f"lacks {', '.join(lacking)}: the line has {joints} joints"
        hint = "another --kind, or an application of your own with --of, has another number"
        problems.append(FileIssue(message=message, hint=hint))
    if problems:
        raise InvalidFileError(source, tuple(problems))
    return found


def _spelled(name: str) -> str:
    bare = re.sub(r"[\s_.-]+", "", name).casefold()
    if found := _JOINT.fullmatch(bare):
        return f"joint {int(found[1])}"
    if found := _BEARING.fullmatch(bare):
        return f"centre bearing {int(found[1])}"
    return bare


def _slope_changes(key: str, along: FloatArray, point: Hardpoint, source: str) -> dict[str, float]:
    """Return the slopes of a member by its direction: down to the rear and right are positive."""
    if not along[0] > 0:
        message = "must lie ahead of joint 1 (gearbox) or behind the last joint (pinion), in x"
        issue = FileIssue(message=message, value=_brief(point.name), line=point.row)
        raise InvalidFileError(source, (issue,))
    return {
        f"{key}.side_deg": round(float(np.arctan2(-along[2], along[0]) / deg), 4),
        f"{key}.top_deg": round(float(np.arctan2(along[1], along[0]) / deg), 4),
    }


def _from_rear_joint(
    front: FloatArray, rear: FloatArray, point: Hardpoint, source: str, k: int
) -> float:
    """Return how far ahead of its shaft's rear joint a centre bearing sits, m."""
    along = front - rear
    length = float(np.linalg.norm(along))
    offset = np.array(point.position) - rear
    place = float(offset @ along / length)
    off = float(np.linalg.norm(offset - place * along / length))
    if not 0 < place < length or off > MAX_BEARING_OFFSET_M:
        message = f"lies {off / mm:.0f} mm off shaft {k}, between joints {k} and {k + 1}"
        issue = FileIssue(
            message=message, value=_brief(point.name), line=point.row,
            hint=f"up to {MAX_BEARING_OFFSET_M / mm:.0f} mm off it is allowed",
        )  # fmt: skip
        raise InvalidFileError(source, (issue,))
    return place
