"""Measures of a chassis by the codes of ISO 21308, as body builders exchange them.

Source: ISO 21308-2, dimensional exchange parameters (BEP), by the codes that Scania publishes for
body builders (*Chassis and bodywork dimensions*); rules of numbering and signs as published with
the standard's first edition. The standard has more codes than those that are public.
"""

import re
from collections.abc import Mapping
from pathlib import Path

from cardan.application.delimited_table import (
    LENGTH_UNITS,
    decimal_sign,
    divided_rows,
    has_more_cells,
)
from cardan.application.paste_import import (
    parse_localised_number,
    parse_number_of_unknown_locale,
)
from cardan.application.placeholders import text_with_value_entered
from cardan.application.source_comment import changed_addresses, text_with_source
from cardan.application.wheelbase import lines_that_follow_rear_axle, text_with_wheelbase
from cardan.application.yaml_edit import YamlEditor
from cardan.core.errors import FileIssue, InvalidFileError
from cardan.core.lazy_dataclass import dataclass
from cardan.core.message import TranslatableMessage, translatable_message
from cardan.core.units import UNITS, Metre, mm
from cardan.model.application import Application
from cardan.model.vehicle import Vehicle
from cardan.schema.yaml_tree import read_table_text, to_one_line

MAX_ROWS = 500
MAX_CONTRADICTION_M = 2 * mm
"""Measures that differ by more contradict each other: sheets round to whole mm."""
WHEELBASE_RANGE_MM = (500.0, 20_000.0)

KNOWN_CODES: Mapping[str, str] = {
    "L001": "overall length",
    "L002": "front reference point",
    "L003": "rear reference point",
    "L010": "total wheelbase, first front to last axle",
    "L011": "wheelbase, first front to first driven rear axle",
    "L012": "spacing of axles n and n+1",
    "L013": "load point of the front axles behind the first",
    "L014": "load point of the rear axles behind the first driven one",
    "L015": "theoretical wheelbase, between load points",
    "L016": "front overhang of the vehicle",
    "L017": "rear overhang of the vehicle",
    "L018": "front overhang of the frame",
    "L019": "rear overhang of the frame",
    "L030": "objects on the frame, lengthwise",
    "H030": "objects on the frame, height",
    "W030": "objects on the frame, sideways",
}
"""Codes whose meaning is public, in our words."""
_USED = ("L010", "L011", "L012", "L013", "L014", "L015")
_CODE = re.compile(r"(?:BEP[\s_-]*)?([A-Z])[\s_-]*(\d{3})(?:\.(\d{1,2}))?([RL]?)", re.IGNORECASE)
_UNIT = re.compile(r"[\[(]\s*(mm|cm|m|in|ft)\s*[\])]|(?<=[\s_])(mm|cm|m|in|ft)$", re.IGNORECASE)


@dataclass(frozen=True, kw_only=True)
class ChassisMeasures:
    """Measures of a chassis.

    Attributes
    ----------
    source
        The table's name.
    values
        By code, `L012.1` with its number, m.
    unused, unknown
        Codes of the table that say nothing of a line or its vehicle, and those that are not public.
    """

    source: str
    values: Mapping[str, Metre]
    unused: tuple[str, ...]
    unknown: tuple[str, ...]


def read_measures(path: Path) -> ChassisMeasures:
    """Return the measures of a table with the columns code and value; others are passed over.

    Columns are divided by tabs, semicolons or commas; numbers may have decimal commas, between
    commas in quotes. The column whose heading names a unit is the value, `value [mm]`; without one
    it is the only number behind the code, in mm.

    Raises
    ------
    InvalidFileError
        If no row has a code, two columns may be the value, or with every code whose value cannot
        be read or stands there twice.
    """
    rows = divided_rows(read_table_text(path), str(path))[:MAX_ROWS]
    coded = [(at, *found, cells) for at, cells in rows if (found := _coded(cells)) is not None]
    if not coded:
        issue = FileIssue(
            message="no row has a code of ISO 21308 and a value", hint="BEP-L011,4100 with mm"
        )
        raise InvalidFileError(str(path), (issue,))
    head = [cells for at, cells in rows if at < coded[0][0]]
    units = {(m[1] or m[2]).lower() for cells in head for c in cells if (m := _UNIT.search(c))}
    heading = next((cells for cells in reversed(head) if sum(map(bool, cells)) > 1), [])
    columns = [k for k, c in enumerate(heading) if _UNIT.search(c)]
    problems: list[FileIssue] = []
    if len(units) > 1:
        hint = f"one of {', '.join(sorted(units))}"
        problems.append(FileIssue(message="the heading must name one unit", hint=hint))
    elif len(columns) > 1:
        named = " and ".join(to_one_line(heading[k])[:30] for k in columns)
        message = "the heading must name the unit of one column, the value"
        problems.append(FileIssue(message=message, value=named, line=_line_of(heading, rows)))
    if problems:
        raise InvalidFileError(str(path), tuple(problems))
    unit = LENGTH_UNITS[units.pop()] if units else mm
    table = [(at, code, *_value(cells, k, columns), cells) for at, code, k, cells in coded]
    decimal = decimal_sign([v for _, code, v, *_ in table if code.partition(".")[0] in _USED])
    values: dict[str, Metre] = {}
    unused: list[str] = []
    unknown: list[str] = []
    for at, code, value, alone, cells in table:
        kind = code.partition(".")[0].rstrip("RL")
        if kind not in KNOWN_CODES:
            unknown.append(code)
        elif kind not in _USED:
            unused.append(code)
        elif (longer := bool(heading) and has_more_cells(cells, heading)) or not alone:
            message = "has more cells than the heading" if longer else "has several numbers"
            hint = "write a number with a decimal comma in quotes" if longer else ""
            hint = hint or "the heading names the unit: value [mm]"
            got = to_one_line(" ".join(cells))[:60]
            issue = FileIssue(message=message, key=f"BEP-{code}", value=got, hint=hint, line=at)
            problems.append(issue)
        else:
            try:
                read = parse_localised_number(value, decimal=decimal) * unit
            except ValueError as error:
                got = to_one_line(value)[:60]
                problems.append(
                    FileIssue(message=str(error), key=f"BEP-{code}", value=got, line=at)
                )
                continue
            if code in values:
                problems.append(FileIssue(message="stands there twice", key=f"BEP-{code}", line=at))
            values[code] = read
    if problems:
        raise InvalidFileError(str(path), tuple(problems))
    return ChassisMeasures(
        source=str(path), values=values, unused=tuple(unused), unknown=tuple(unknown)
    )


def _line_of(heading: list[str], rows: list[tuple[int, list[str]]]) -> int:
    return next(at for at, cells in rows if cells is heading)


def _value(cells: list[str], code: int, columns: list[int]) -> tuple[str, bool]:
    """Return the value of a row with its code in a column, and whether nothing else may be it."""
    if columns and columns[0] != code:
        return (cells[columns[0]] if columns[0] < len(cells) else ""), True
    behind = [c for c in cells[code + 1 :] if re.match(r"[-+\u2212]?[\d.,]", c)]
    numbers = sum(parse_number_of_unknown_locale(c) is not None for c in behind)
    return next(iter(behind), ""), numbers < 2


def _coded(cells: list[str]) -> tuple[str, int] | None:
    """Return the code of a row and its column."""
    for k, cell in enumerate(cells):
        if (found := _CODE.fullmatch(cell)) and (not found[4] or found[1].upper() == "W"):
            number = f".{int(found[3])}" if found[3] else ""
            return f"{found[1].upper()}{found[2]}{number}{found[4].upper()}", k
    return None


# --------------------------------------------------------------------------- into an application


def text_with_measures(
    text: str,
    application: Application,
    measures: ChassisMeasures,
    *,
    moves_line: bool = True,
    folder: Path | None = None,
) -> tuple[str, tuple[TranslatableMessage, ...]]:
    """Return the text of an application with the wheelbase of a chassis, and what to say of it.

    The wheelbase is from the load point of the front axles to that of the rear ones: L015, or L011
    with L014 and L013. Where the line stands by points, slopes or angles, its last joint moves with
    the axle. A bogie with one driven axle has its `driven_share` by L014 and the axles' spacing.

    Parameters
    ----------
    text, application
        An application with a vehicle, as text and as read.
    moves_line
        Whether the line follows the axle; False where its points are given, too.
    folder
        Where the files lie that the application names.

    Raises
    ------
    InvalidFileError
        If the vehicle's wheelbase is not among the measures, or they contradict each other.
    """
    vehicle = application.vehicle
    if vehicle is None:
        message = "measures of a chassis need an application with a `vehicle`"
        raise InvalidFileError(measures.source, (FileIssue(message=message),))
    wheelbase, how = _wheelbase(measures, vehicle)
    size = f"{wheelbase / mm:.0f}"
    before = text
    notes = [translatable_message("wheelbase {size} mm, {codes}", size=size, codes=how)]
    editor = YamlEditor(text)
    key = next((f"vehicle.wheelbase_{u}" for u in UNITS if f"vehicle.wheelbase_{u}" in editor), "")
    placeholder = key in application.placeholders
    if moves_line and not placeholder:
        text = text_with_wheelbase(text, wheelbase=wheelbase, name=measures.source, folder=folder)
        if lines_that_follow_rear_axle(application):
            notes.append(
                translatable_message(
                    "the last joint of each line to a rear axle stands where the axle does"
                )
            )
    else:
        unit = UNITS[key.rpartition("_")[2]]
        text = editor.with_changes({key: round(wheelbase / unit, 6)})
    text = text_with_value_entered(text, key) if placeholder else text
    share = _driven_share(measures, vehicle)
    if share is not None:
        text = YamlEditor(text).with_changes({"vehicle.driven_share": round(share, 4)})
        if "vehicle.driven_share" in application.placeholders:
            text = text_with_value_entered(text, "vehicle.driven_share")
        notes.append(
            translatable_message(
                "driven_share {share}, BEP-L014 and the spacing of the rear axles",
                share=f"{share:.3g}",
            )
        )
    text = text_with_source(changed_addresses(before, text), text, Path(measures.source).name)
    for codes, said in (
        (measures.unused, "not used: {codes}"),
        (measures.unknown, "not public, not read: {codes}"),
    ):
        if codes:
            notes.append(translatable_message(said, codes=tuple(map(_code_name, codes))))
    return text, tuple(notes)


def _code_name(code: str) -> TranslatableMessage:
    """Return a code of ISO 21308 with what it measures, where that is public."""
    meaning = KNOWN_CODES.get(code.partition(".")[0])
    if meaning is None:
        return translatable_message("BEP-{code}", code=code)
    return translatable_message("BEP-{code} {meaning}", code=code, meaning=meaning)


def _wheelbase(measures: ChassisMeasures, vehicle: Vehicle) -> tuple[Metre, str]:
    """Return the wheelbase between the load points, and the codes that it is from."""
    values, found = measures.values, dict[str, Metre]()
    rear_axles, front_axles = vehicle.rear_group, vehicle.front_group
    front = 0.0 if front_axles == 1 else values.get("L013")
    rear = 0.0 if rear_axles == 1 else values.get("L014")
    if "L015" in values and not vehicle.auxiliary:  # theirs is a load point of all rear axles
        found["BEP-L015"] = values["L015"]
    if "L011" in values and front is not None and rear is not None:
        codes = ["BEP-L011", *(["BEP-L014"] if rear_axles > 1 else [])]
        codes += ["BEP-L013"] if front_axles > 1 else []
        found[", ".join(codes)] = values["L011"] + rear - front
    if vehicle.axle_count == 2:
        found |= {f"BEP-{c}": values[c] for c in ("L010", "L012.1", "L012") if c in values}
    if not found:
        needs = "BEP-L011" if rear_axles == 1 else "BEP-L011 + BEP-L014"
        needs += "" if front_axles == 1 else " + BEP-L013"
        given = ", ".join(f"BEP-{c}" for c in values) or "none"
        issue = FileIssue(
            message="gives no wheelbase between the load points of the axles",
            hint=f"BEP-L015, or {needs}; it has {given}",
        )
        raise InvalidFileError(measures.source, (issue,))
    (how, wheelbase), *others = found.items()
    for other, value in others:
        if abs(value - wheelbase) > MAX_CONTRADICTION_M:
            message = (
                f"{how} and {other} contradict each other: wheelbases of "
                f"{wheelbase / mm:.0f} mm and {value / mm:.0f} mm"
            )
            raise InvalidFileError(measures.source, (FileIssue(message=message),))
    low, high = WHEELBASE_RANGE_MM
    if not low * mm <= wheelbase <= high * mm:
        issue = FileIssue(
            message=f"the wheelbase must be {low:.0f} to {high:.0f} mm", key=how,
            value=f"{wheelbase / mm:.6g} mm", hint="the heading names the unit: value [mm]",
        )  # fmt: skip
        raise InvalidFileError(measures.source, (issue,))
    return wheelbase, how


def _driven_share(measures: ChassisMeasures, vehicle: Vehicle) -> float | None:
    """Return the driven axle's share of a bogie of two axles; None where nothing says it."""
    values = measures.values
    bogie = (vehicle.axle_count, vehicle.rear_group, vehicle.driven_rear)
    if bogie != (3, 2, 1) or "L014" not in values or "L011" not in values:
        return None
    behind = values["L010"] - values["L011"] if "L010" in values else 0.0
    spacing = behind if behind > 0 else values.get("L012.2")
    if not spacing:
        return None
    share = 1 - abs(values["L014"]) / spacing
    if not 0 < share <= 1:
        message = "the load point lies outside the bogie: BEP-L014 is more than the axles' spacing"
        raise InvalidFileError(measures.source, (FileIssue(message=message),))
    return share
