"""A layout as the numbers of a file that say it: what `files.geometry` reads, the other way.

A file gives slopes, joint angles or points. Whichever it gives is what changes, and no other
number does but the lengths that follow.
"""

from collections.abc import Iterable
from typing import Any, Literal

import numpy as np

from cardan.application.yaml_edit import YamlEditor
from cardan.core.arrays import FloatArray
from cardan.core.errors import DesignError
from cardan.core.units import UNITS, deg, mm
from cardan.model.application import InstalledLine
from cardan.model.layout import Layout
from cardan.model.parts import CentreBearing, Line

ROUNDING_STEP_SI_BY_QUANTITY = {"length": 0.01 * mm, "slope": 1e-3 * deg}
"""What a written number is rounded to: a tenth of what can be measured in a frame."""

FileChanges = dict[str, float | str | list[Any]]
"""By address, in the unit of its key."""


def yaml_address_of_line(of: InstalledLine, text: YamlEditor) -> str:
    """Return the key that a line stands under."""
    return "driveline" if "driveline" in text else f"drivelines.{of.line.name}"


def geometry_input_style(
    of: InstalledLine, text: YamlEditor
) -> Literal["points", "slopes", "joint_angles"]:
    """Return how a text says where a line runs."""
    at = yaml_address_of_line(of, text)
    if f"{at}.slopes" in text:
        return "slopes"
    return "joint_angles" if f"{at}.joint_angles" in text else "points"


def layout_changes(of: InstalledLine, layout: Layout, text: YamlEditor) -> FileChanges:
    """Return what changes in a text so that a line runs as a layout says.

    Parameters
    ----------
    of
        The line as the text has it now.
    layout : (n, 3) m
        Where it is to run. Joint 1 of a file without points is its origin and stays.
    text
        What it was read from.

    Raises
    ------
    DesignError
        If the text cannot say it: joint angles begin at a gearbox that is level.
    """
    at = yaml_address_of_line(of, text)
    return _geometry_changes(at, geometry_input_style(of, text), of.layout, layout, text)


def state_layout_changes(
    state: str, of: InstalledLine, was: Layout, layout: Layout, text: YamlEditor
) -> FileChanges:
    """Return what changes in a text so that a line runs as a layout says in a state of its own.

    Nothing where the state leaves the line as it is in the reference.
    """
    names = (f"states[{k}]" for k in range(1, len(text.addresses) + 1))
    at = next((a for a in names if text.scalar_text(f"{a}.name") == state), "")
    at = next((a for a in (f"{at}.drivelines.{of.line.name}", at) if a in text), "")
    for said, key in (
        ("slopes", "slopes"),
        ("joint_angles", "joint_angles"),
        ("points", f"points_{_unit(f'{at}.points', text)}"),
    ):
        if f"{at}.{key}" in text:
            return _geometry_changes(at, said, was, layout, text, inherits=True)
    return {}


def _unit(stem: str, text: YamlEditor) -> str:
    found = _list(stem, text)
    return found[1] if found else ""


def _geometry_changes(
    at: str, said: str, was: Layout, layout: Layout, text: YamlEditor, *, inherits: bool = False
) -> FileChanges:
    """Return what changes below an address; a state `inherits` the ends that it does not give."""
    changes: FileChanges = {}
    if points := _list(f"{at}.points", text):
        key, unit = points
        for k, c in zip(*np.nonzero(np.abs(layout.points - was.points) > 1e-9), strict=True):
            now, before = (
                round_in_unit(float(o.points[k, c]), unit, "length") for o in (layout, was)
            )
            if now != before:
                changes[f"{key}[{k + 1}][{c + 1}]"] = now
        for name, end in (("gearbox_slope", 0), ("pinion_slope", -1)):
            if inherits and f"{at}.{name}" not in text:
                continue
            changes |= _slopes(f"{at}.{name}", was, layout, end, text)
    elif said == "slopes":
        for view in ("side", "top"):
            changes |= _listed(
                f"{at}.slopes.{view}", getattr(was, view), getattr(layout, view), text
            )
    else:
        if not inherits or f"{at}.gearbox_slope" in text:
            changes |= _slopes(f"{at}.gearbox_slope", was, layout, 0, text)
        for view in ("side", "top"):
            before, after = (np.diff(getattr(o, view)) for o in (was, layout))
            changes |= _listed(f"{at}.joint_angles.{view}", before, after, text)
    for k in np.flatnonzero(
        np.abs(layout.lengths - was.lengths) > 0.5 * ROUNDING_STEP_SI_BY_QUANTITY["length"]
    ):
        length = _list(f"{at}.shafts[{k + 1}].length", text)
        if inherits and k == len(layout.lengths) - 1:
            length = _list(f"{at}.last_length", text)
        if length:
            key, unit = length
            changes[key] = round_in_unit(float(layout.lengths[k]), unit, "length")
    return changes


def phase_changes(of: InstalledLine, phases: Iterable[float], text: YamlEditor) -> FileChanges:
    """Return what changes in a text so that a line's shafts have other yoke phases, rad."""
    changes: FileChanges = {}
    for k, (shaft, phase) in enumerate(zip(of.line.shafts, phases, strict=True), 1):
        if abs(shaft.phase - phase) > 1e-9:
            key = yaml_address_of_yoke_phase(of, k, text)
            changes[key] = round_in_unit(phase, "rad" if key.endswith("_rad") else "deg", "slope")
    return changes


def bearing_changes(of: InstalledLine, line: Line, text: YamlEditor) -> FileChanges:
    """Return what changes in a text so that a line hangs on the centre bearings of another."""
    changes: FileChanges = {}
    for k, (shaft, other) in enumerate(zip(of.line.shafts, line.shafts, strict=True), 1):
        was, now = shaft.centre_bearing, other.centre_bearing
        if was is None or now is None or was == now:
            continue
        at = f"{yaml_address_of_line(of, text)}.shafts[{k}].centre_bearing"
        each = {
            "from_rear_joint": (was.from_rear_joint, now.from_rear_joint),
            "stiffness": _pair(was, now, 0),
            "vertical_stiffness": _pair(was, now, 0),
            "lateral_stiffness": _pair(was, now, 1),
            "axial_stiffness": (was.axial_stiffness, now.axial_stiffness),
        }
        for stem, (before, value) in each.items():
            found = _list(f"{at}.{stem}", text)
            if found and value is not None and value != before:
                changes[found[0]] = float(f"{value / UNITS[found[1]]:.4g}")
        if now.loss_factor is not None and now.loss_factor != was.loss_factor:
            changes[f"{at}.loss_factor"] = float(f"{now.loss_factor:.3g}")
    return changes


def spline_changes(of: InstalledLine, longer: float, text: YamlEditor) -> FileChanges:
    """Return the travel left in the spline of a line whose last shaft gets `longer`, m."""
    spline = of.line.shafts[-1].spline
    changes: FileChanges = {}
    if spline is None or abs(longer) < 0.5 * ROUNDING_STEP_SI_BY_QUANTITY["length"]:
        return changes
    at = f"{yaml_address_of_line(of, text)}.shafts[{len(of.line.shafts)}].spline"
    for stem, left in (("plunge", spline.plunge), ("draw", spline.draw)):
        found = _list(f"{at}.{stem}", text)
        if found and left is not None:
            now = float(left) + (longer if stem == "plunge" else -longer)
            changes[found[0]] = round_in_unit(max(now, 0.0), found[1], "length")
    return changes


def joint_place_changes(
    at: str, was: tuple[float, float], now: tuple[float, float], text: YamlEditor
) -> FileChanges:
    """Return what changes where a joint sits on its axle, (x, z) m from the wheel centre."""
    changes: FileChanges = {}
    if at not in text:
        return changes
    for k, stems in enumerate((("behind", "ahead"), ("above", "below"))):
        found = next(
            ((sign, key) for sign, stem in zip((1, -1), stems, strict=True)
             if (key := _list(f"{at}.{stem}", text))),
            (1, (f"{at}.{stems[0]}_mm", "mm")),
        )  # fmt: skip
        sign, (key, unit) = found
        before, after = (round_in_unit(sign * float(o[k]), unit, "length") for o in (was, now))
        if before != after:
            changes[key] = after
    return changes


def adjustment_range_changes(
    stem: str, part: int, amount: float, parts: int, text: YamlEditor
) -> FileChanges:
    """Return the range of `adjust` that counts from where a part is after it moved, SI.

    One range for several parts stays as it is written.
    """
    found = _list(stem, text)
    if not found:
        return {}
    key, unit = found
    at = next((a for a in (f"{key}.{part}", key) if f"{a}[1]" in text), "")
    if not at or (at == key and parts > 1):
        return {}
    changes: FileChanges = {}
    for k in (1, 2):
        written = text.scalar_text(f"{at}[{k}]")
        if written is None:
            return {}
        changes[f"{at}[{k}]"] = round(float(written) - amount / UNITS[unit], 6) + 0.0
    return changes


def yaml_address_of_yoke_phase(of: InstalledLine, shaft: int, text: YamlEditor) -> str:
    """Return the key that a shaft's yoke phase stands under, or would."""
    at = f"{yaml_address_of_line(of, text)}.shafts[{shaft}].phase"
    return f"{at}_rad" if f"{at}_rad" in text else f"{at}_deg"


def yaml_address_of_part_name(
    of: InstalledLine, text: YamlEditor, *, joint: int = 0, shaft: int = 0
) -> str:
    """Return the key under which the name of a joint or of a shaft's tube stands.

    Where the file gives no joints at all it is where a size for all of them would stand, of a
    tube likewise. Nothing where the part is given in place: there is no name to change.
    """
    at = yaml_address_of_line(of, text)
    whole = f"{at}.joints" if joint else f"{at}.shafts[{shaft}].tube"
    if whole not in text:
        return whole
    return next((key for key in (whole, f"{whole}[{joint}]") if text.scalar_text(key)), "")


def round_in_unit(value: float, unit: str, sort: str) -> float:
    """Return a value in SI in a unit, without digits beyond any measurement."""
    worth = UNITS[unit]
    decimals = max(0, int(np.ceil(-np.log10(ROUNDING_STEP_SI_BY_QUANTITY[sort] / worth) - 1e-9)))
    return round(value / worth, decimals) + 0.0


def _pair(was: CentreBearing, now: CentreBearing, way: int) -> tuple[float | None, float | None]:
    """Return the stiffness of two bearings up (0) or sideways (1); None where rigid."""
    before, after = (b.stiffness[way] if b.stiffness else None for b in (was, now))
    return before, after


def _list(stem: str, text: YamlEditor) -> tuple[str, str] | None:
    """Return the key that begins so and ends in a unit, with the unit; None if none is given."""
    keys = ((f"{stem}_{unit}", unit) for unit in UNITS)
    return next(((key, unit) for key, unit in keys if key in text), None)


def _slopes(at: str, was: Layout, now: Layout, end: int, text: YamlEditor) -> FileChanges:
    """Return changes to the slope of one end of a line."""
    changes: FileChanges = {}
    for view in ("side", "top"):
        before, after = (float(getattr(o, view)[end]) for o in (was, now))
        if abs(after - before) > 1e-9:
            if at not in text:
                msg = f"{at} is not in the file: give it a {view}_deg first"
                raise DesignError(msg, about=at)
            key, unit = _list(f"{at}.{view}", text) or (f"{at}.{view}_deg", "deg")
            changes[key] = round_in_unit(after, unit, "slope")
    return changes


def _listed(stem: str, was: FloatArray, now: FloatArray, text: YamlEditor) -> FileChanges:
    """Return changes to a list of angles, which is put there whole where it is not given."""
    moved = np.flatnonzero(np.abs(now - was) > 1e-9)
    if not len(moved):
        return {}
    given = _list(stem, text)
    if given is None:
        return {f"{stem}_deg": [round_in_unit(float(v), "deg", "slope") for v in now]}
    key, unit = given
    rounds = {
        int(k): [round_in_unit(float(o[k]), unit, "slope") for o in (now, was)] for k in moved
    }
    return {f"{key}[{k + 1}]": new for k, (new, old) in rounds.items() if new != old}
