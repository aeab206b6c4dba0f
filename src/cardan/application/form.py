"""A first application file from a protractor's readings, as a form takes them.

What was typed is read here and nowhere else; the file that comes of it is one like any other.
"""

import re
from collections.abc import Iterator, Mapping
from typing import Any

from cardan.application.paste_import import parse_hardpoints, parse_localised_number
from cardan.application.wheelbase import text_with_wheelbase
from cardan.application.yaml_edit import format_as_yaml_value
from cardan.core.errors import FileIssue, InvalidFileError
from cardan.core.units import UNITS

FORM_NAME_IN_ERRORS = "form"

MAX_FORM_SHAFTS = 6
"""Shafts of a form; a file may have more."""

FORM_LENGTH_UNITS = {"mm": "mm", "in": "in"}

FormData = Mapping[str, Any]

OWN_PART = "own"
"""What a form calls a joint or a tube whose sizes are typed, not chosen."""


def application_text_from_form(form: FormData, *, decimal: str = ".") -> str:
    """Return the text of an application from what a form holds, all of it as it was typed.

    Parameters
    ----------
    form
        `title`, `speed` in rpm, `torque` in N m, `unit` of lengths (mm, in), `joint`, the size
        of all joints by name, or "own" with its ratings `joint_peak`, `joint_reversing` and
        `joint_bearing` in N m, its `joint_angle` in deg and its `joint_name`; `engine_torque` in
        N m, `engine_speed` in rpm, `ratios` of the gears in a row and the `reverse` one; `limits`,
        the name of a profile; `members`, the `side` and `top`
        slope in deg of gearbox, shafts and pinion, down to the rear and to the right positive;
        `shafts`, each with `length`, `phase` in deg, `tube` by name, or "own" with its `outer`
        diameter and `wall`, and how far ahead of its rear joint its `bearing` sits, with its
        `vertical` and `lateral` stiffness in N/mm. `points`, a pasted table of the joints' centres,
        goes before the slopes of the shafts and their lengths; its x goes to the rear and its y to
        the right, or ahead and to the left where `axes` is "front".
    decimal
        What the language of the form writes before decimals. The other sign before three
        digits may be one of thousands: both readings are named, and none is chosen.

    Raises
    ------
    InvalidFileError
        With every field that holds no number where there must be one, by its key.
    """
    reader = _Reader(form, decimal)
    shafts, members = form.get("shafts") or [], form.get("members") or []
    text = "\n".join((*reader.head(), *reader.line(shafts, members), *reader.foot())) + "\n"
    if reader.problems:
        raise InvalidFileError(FORM_NAME_IN_ERRORS, tuple(reader.problems))
    return text


def texts_of_both_wheelbases(text: str, form: FormData, *, decimal: str = ".") -> tuple[str, ...]:
    """Return a form's text for the wheelbase before a change and for that after; or it alone.

    Parameters
    ----------
    text
        The application that the form comes to: that of `wheelbase_from`.
    form
        `wheelbase_from` and `wheelbase_to` in the `unit` of lengths, as they were typed.

    Raises
    ------
    InvalidFileError
        If one of the two is given alone, or is no length above zero.
    DesignError
        If the last shaft would be too short.
    """
    keys = ("wheelbase_from", "wheelbase_to")
    if not any(str(form.get(key) or "").strip() for key in keys):
        return (text,)
    reader = _Reader(form, decimal)
    typed = [reader.number(form.get(key), key, needed=True) or "0" for key in keys]
    for key, value in zip(keys, typed, strict=True):
        if not reader.problems and float(value) <= 0:
            reader.wrong(key, "must be above 0", value)
    if reader.problems:
        raise InvalidFileError(FORM_NAME_IN_ERRORS, tuple(reader.problems))
    before, after = (float(value) * UNITS[reader.unit] for value in typed)
    moved = text_with_wheelbase(
        text, wheelbase=after, from_wheelbase=before, name=FORM_NAME_IN_ERRORS
    )
    now, then = (f"{value} {reader.unit}" for value in typed)
    return (
        f"# Wheelbase {now}, before the change to {then}\n{text}",
        f"# Wheelbase {then}, changed from {now}: the last shaft takes up the difference\n{moved}",
    )


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
        yield from self.engine()
        yield ""

    def engine(self) -> Iterator[str]:
        """Yield engine and gearbox, if the form gives any of them."""
        keys = ("engine_speed", "engine_torque", "ratios", "reverse")
        if not any(str(self.form.get(key) or "").strip() for key in keys):
            return
        speed, torque = (self.number(self.form.get(key), key, needed=True) for key in keys[:2])
        typed = str(self.form.get("ratios") or "").strip()
        # A comma before a blank separates, whatever it means within a number.
        parts = re.split(r"[;/\s,]+" if self.decimal == "." else r",?[;/\s]+", typed.strip(";,/ "))
        ratios = [self.number(part, "ratios", needed=True) or "0" for part in parts]
        reverse = self.number(self.form.get("reverse"), "reverse")
        yield f"engine: {{speed_rpm: {speed}, torque_Nm: {torque}}}"
        backward = "" if reverse is None else f", reverse_ratio: {reverse}"
        yield f"gearbox: {{ratios: [{', '.join(ratios)}]{backward}}}"

    def own_joint(self) -> str:
        """Return a joint by its ratings, as a file has it."""
        name = str(self.form.get("joint_name") or "").strip() or OWN_PART
        ratings = (
            ("peak_Nm", "joint_peak"),
            ("reversing_Nm", "joint_reversing"),
            ("bearing_Td_Nm", "joint_bearing"),
            ("angle_max_deg", "joint_angle"),
        )
        said = [f"name: {format_as_yaml_value(name, '')}"]
        for key, field in ratings:
            value = self.number(self.form.get(field), field, needed=key == "peak_Nm")
            if value is not None:
                said.append(f"{key}: {value}")
        return f"{{{', '.join(said)}}}"

    def foot(self) -> Iterator[str]:
        if limits := str(self.form.get("limits") or ""):
            yield ""
            yield f"limits: {format_as_yaml_value(limits, '')}"

    def line(self, shafts: list[FormData], members: list[FormData]) -> Iterator[str]:
        yield "driveline:"
        if joint := str(self.form.get("joint") or "").strip():
            own = joint == OWN_PART
            yield f"  joints: {self.own_joint() if own else format_as_yaml_value(joint, '')}"
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
        tube = str(shaft.get("tube") or "")
        if tube == OWN_PART:
            outer = self.number(shaft.get("outer"), f"{at}.outer", needed=True)
            wall = self.number(shaft.get("wall"), f"{at}.wall", needed=True)
            yield f"tube: {{outer_{self.unit}: {outer}, wall_{self.unit}: {wall}}}"
        elif tube:
            yield f"tube: {format_as_yaml_value(tube, '')}"
        yield f"phase_deg: {self.number(shaft.get('phase'), f'{at}.phase') or '0'}"
        if k < count:
            ahead = self.number(shaft.get("bearing"), f"{at}.bearing", needed=True)
            stiff = [
                f", {way}_stiffness_N_mm: {value}"
                for way in ("vertical", "lateral")
                if (value := self.number(shaft.get(way), f"{at}.{way}")) is not None
            ]
            yield f"centre_bearing: {{from_rear_joint_{self.unit}: {ahead}{''.join(stiff)}}}"

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
