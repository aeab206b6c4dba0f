"""A first application file from a protractor's readings, as a form takes them.

What was typed is read here and nowhere else; the file that comes of it is one like any other.
"""

from collections.abc import Iterator, Mapping
from typing import Any

from cardan.application.paste_import import parse_hardpoints, parse_localised_number
from cardan.application.yaml_edit import format_as_yaml_value
from cardan.core.errors import FileIssue, InvalidFileError

FORM_FILE_NAME = "form"

MAX_FORM_SHAFTS = 6
"""Shafts of a form; a file may have more."""

FORM_LENGTH_UNITS = {"mm": "mm", "in": "in"}

FormData = Mapping[str, Any]


def application_text_from_form(form: FormData, *, decimal: str = ".") -> str:
    """Return the text of an application from what a form holds, all of it as it was typed.

    Parameters
    ----------
    form
        `title`, `speed` in rpm, `torque` in N m, `unit` of lengths (mm, in), `joint`, the size
        of all joints by name, `limits`, the name of a profile; `members`, the `side` and `top`
        slope in deg of gearbox, shafts and pinion, down to the rear and to the right positive;
        `shafts`, each with `length`, `phase` in deg, `tube` by name, and how far ahead of its rear
        joint its `bearing` sits. `points`, a pasted table of the joints' centres, goes before the
        slopes of the shafts and their lengths; its x goes to the rear and its y to the right, or
        ahead and to the left where `axes` is "front".
    decimal
        What the language of the form writes before decimals. The other sign before three
        digits may be one of thousands: nobody guesses, both readings are named.

    Raises
    ------
    BadFile
        With every field that holds no number where there must be one, by its key.
    """
    reader = _Reader(form, decimal)
    shafts, members = form.get("shafts") or [], form.get("members") or []
    text = "\n".join((*reader.head(), *reader.line(shafts, members), *reader.foot())) + "\n"
    if reader.problems:
        raise InvalidFileError(FORM_FILE_NAME, tuple(reader.problems))
    return text


class _Reader:
    """Reads fields, and remembers what is wrong in them."""

    def __init__(self, form: FormData, decimal: str) -> None:
        self.form = form
        self.decimal = decimal
        self.problems: list[FileIssue] = []
        self.unit = FORM_LENGTH_UNITS.get(str(form.get("unit")), "mm")

    def head(self) -> Iterator[str]:
        title = str(self.form.get("title") or "").strip() or "Driveline"
        yield f"title: {format_as_yaml_value(title, '')}"
        for key, name in (("speed", "speed_rpm"), ("torque", "torque_Nm")):
            value = self.number(self.form.get(key), key)
            if value is not None:
                yield f"{name}: {value}"
        yield ""

    def foot(self) -> Iterator[str]:
        if limits := str(self.form.get("limits") or ""):
            yield ""
            yield f"limits: {format_as_yaml_value(limits, '')}"

    def line(self, shafts: list[FormData], members: list[FormData]) -> Iterator[str]:
        yield "driveline:"
        if joint := str(self.form.get("joint") or "").strip():
            yield f"  joints: {format_as_yaml_value(joint, '')}"
        pasted = str(self.form.get("points") or "").strip()
        count = len(shafts)
        if pasted:
            yield from self.points(pasted, members, count)
            count = self.joints - 1
        else:
            if not 1 <= count <= MAX_FORM_SHAFTS or len(members) != count + 2:
                self.wrong("shafts", "a line has 1 to 6 shafts, each with its slope", str(count))
            yield "  slopes:            # gearbox, shafts, pinion; down to the rear is positive"
            for view in ("side", "top"):
                found = [
                    self.number(m.get(view), f"members[{k}].{view}", needed=view == "side") or "0"
                    for k, m in enumerate(members, 1)
                ]
                if view == "side" or any(float(v) for v in found):
                    yield f"    {view}_deg: [{', '.join(found)}]"
        yield "  shafts:"
        for k in range(1, count + 1):
            shaft = shafts[k - 1] if k <= len(shafts) else {}
            yield "    - {" + ", ".join(self.shaft(shaft, k, count, placed=bool(pasted))) + "}"

    joints = 0

    def points(self, pasted: str, members: list[FormData], shafts: int) -> Iterator[str]:
        try:
            rows = parse_hardpoints(pasted, unit=self.unit)
        except InvalidFileError as error:
            self.problems += error.problems
            return
        self.joints = len(rows)
        if self.joints != shafts + 1:
            message = f"the line has {shafts + 1} joints; choose another number of shafts"
            self.wrong("points", message, f"{self.joints} rows")
        if self.form.get("axes") == "front":
            rows = tuple((-x, -y, z) for x, y, z in rows)
        said = ", ".join(f"[{', '.join(f'{v + 0.0:.10g}' for v in row)}]" for row in rows)
        yield f"  points_{self.unit}: [{said}]"
        ends = [("gearbox_slope", 1), ("pinion_slope", len(members))]
        for name, k in ends if len(members) > 1 else ():
            views = [
                f"{view}_deg: {value}"
                for view in ("side", "top")
                if (value := self.number(members[k - 1].get(view), f"members[{k}].{view}"))
            ]
            if views:
                yield f"  {name}: {{{', '.join(views)}}}"

    def shaft(self, shaft: FormData, k: int, count: int, *, placed: bool) -> Iterator[str]:
        at = f"shafts[{k}]"
        if not placed:
            length = self.number(shaft.get("length"), f"{at}.length", needed=True)
            yield f"length_{self.unit}: {length}"
        if tube := str(shaft.get("tube") or ""):
            yield f"tube: {format_as_yaml_value(tube, '')}"
        yield f"phase_deg: {self.number(shaft.get('phase'), f'{at}.phase') or '0'}"
        if k < count:
            ahead = self.number(shaft.get("bearing"), f"{at}.bearing", needed=True)
            yield f"centre_bearing: {{from_rear_joint_{self.unit}: {ahead}}}"

    def number(self, said: Any, key: str, *, needed: bool = False) -> str | None:
        """Return a number as a file has it; None where a field is empty."""
        typed = "" if said is None else str(said).strip()
        if not typed:
            if needed:
                self.wrong(key, "give a number", "")
            return "0" if needed else None
        try:
            return f"{parse_localised_number(typed, decimal=self.decimal):.10g}"
        except ValueError as error:
            self.wrong(key, str(error), typed[:40])
            return "0"

    def wrong(self, key: str, message: str, value: str) -> None:
        self.problems.append(FileIssue(message=message, key=key, value=value))
