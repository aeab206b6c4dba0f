"""A sheet: the numbers of a line as rows over its states, before any medium shapes them.

Terminal, pages and workbook all print these rows, so they cannot disagree about what a
number is called, which unit it has or in which order it comes.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from cardan.base.arrays import ArrayLike, FloatArray
from cardan.kinematics.equivalent import Excitation
from cardan.quantity.quantities import QUANTITIES
from cardan.quantity.response import Response
from cardan.report.language import Language


@dataclass(frozen=True, kw_only=True)
class Row:
    """One number for each state, in the unit its quantity is shown in.

    `part` says of what ("joint 2"), `method` by which approximation; an exact value has
    none. nan is what could not be computed.
    """

    quantity: str
    values: FloatArray
    part: str = ""
    method: str = ""

    @property
    def unit(self) -> str:
        """Unit of the values as people write it."""
        return QUANTITIES[self.quantity].unit_name

    def label(self, say: Language) -> str:
        """Return the row's name with its part or, in brackets, its approximation."""
        if self.method:
            return f"  ({say(METHODS.get(self.method, self.method))})"
        return say.list(say.name(self.quantity), say.part(self.part))


@dataclass(frozen=True, kw_only=True)
class Section:
    """Rows that belong together."""

    title: str
    rows: tuple[Row, ...]


METHODS = {
    "ae7": "AE-7", "in_plane": "all joints in one plane", "spicer_sine": "ω² sin²",
    "spicer_rpm": "3.3403e-6 N²θ²", "small_angle": "small angle",
}  # fmt: skip
"""How the approximations are called in print, by their names in the JSON contract."""


def sections(response: Response) -> tuple[Section, ...]:
    """Return everything a line does, state by state, without what nothing is known of."""
    parts = (
        ("Demand", _demand(response)),
        ("Joints", _joints(response)),
        ("Excitation", _excitation(response)),
        ("Centre bearings", _bearings(response)),
        ("Gearbox, axle and spline", _ends(response)),
        ("Speed and strength", _strength(response)),
        ("Room", _room(response)),
    )
    kept = (
        Section(title=title, rows=tuple(r for r in rows if not np.isnan(r.values).all()))
        for title, rows in parts
    )
    return tuple(s for s in kept if s.rows)


def line_title(response: Response, say: Language) -> str:
    """Return the heading of a line: its name, its shafts and joints."""
    shafts = len(response.line.shafts)
    said = (
        "Line {line}: {shafts} shaft, {joints} joints"
        if shafts == 1
        else "Line {line}: {shafts} shafts, {joints} joints"
    )
    return say(said, line=response.line.name, shafts=shafts, joints=shafts + 1)


def _row(quantity: str, values: ArrayLike, *, part: str = "", method: str = "") -> Row:
    """Return a row of SI values."""
    shown = np.asarray(values, dtype=float) / QUANTITIES[quantity].factor
    return Row(quantity=quantity, values=shown, part=part, method=method)


def _each(quantity: str, kind: str, values: FloatArray) -> Iterator[Row]:
    """Yield a row for each part of values (S, parts)."""
    for k, column in enumerate(values.T, 1):
        yield _row(quantity, column, part=f"{kind} {k}")


def _demand(r: Response) -> Iterator[Row]:
    yield _row("torque", r.demand.torque)
    yield _row("engine_torque", r.demand.engine_torque)
    yield _row("slip_torque", r.demand.slip_torque)
    yield _row("coast_torque", r.demand.coast_torque)
    yield _row("speed", r.demand.speed)
    if r.demand.travel.any():
        yield _row("axle_travel", r.demand.travel)
        yield _row("pinion_pitch", r.demand.pitch)
    yield _row("suspension_frequency", r.demand.suspension_frequency)


def _joints(r: Response) -> Iterator[Row]:
    columns = zip(r.angles.T, r.positions.T, r.side_angles.T, r.top_angles.T, strict=True)
    for k, (angle, position, side, top) in enumerate(columns, 1):
        part = f"joint {k}"
        yield _row("joint_angle", angle, part=part)
        yield _row("joint_position", position, part=part)
        yield _row("side_angle", side, part=part)
        yield _row("top_angle", top, part=part)


def _excitation(r: Response) -> Iterator[Row]:
    exact, others = r.excitation, r.approximations

    def with_others(
        quantity: str, of: Callable[[Excitation], FloatArray], *names: str
    ) -> Iterator[Row]:
        yield _row(quantity, of(exact))
        for name in names:
            yield _row(quantity, of(others[name]), method=name)

    yield from with_others("equivalent_angle", lambda e: e.torsional.angle, "ae7", "in_plane")
    yield from with_others(
        "torsional_acceleration", lambda e: e.torsional.acceleration, "ae7", "in_plane"
    )
    yield from with_others("inertia_drive_acceleration", lambda e: e.drive.acceleration, "ae7")
    yield from with_others("inertia_coast_acceleration", lambda e: e.coast.acceleration, "ae7")
    if exact.drive_torque is not None and exact.coast_torque is not None:
        yield _row("inertia_drive_torque", exact.drive_torque)
        yield _row("inertia_coast_torque", exact.coast_torque)
    yield _row("irregularity", exact.irregularity)


def _bearings(r: Response) -> Iterator[Row]:
    cycle = r.loads.bearing_forces
    static, dynamic, peak = np.linalg.norm(cycle.static, axis=-1), cycle.dynamic, r.bearing_peaks
    small_static, small_dynamic = r.small_angle_bearings
    small_static = np.linalg.norm(small_static, axis=-1)
    for k in range(static.shape[-1]):
        part = f"bearing {k + 1}"
        yield _row("centre_bearing_static", static[:, k], part=part)
        yield _row("centre_bearing_static", small_static[:, k], part=part, method="small_angle")
        yield _row("centre_bearing_dynamic", dynamic[:, k], part=part)
        yield _row("centre_bearing_dynamic", small_dynamic[:, k], part=part, method="small_angle")
        yield _row("centre_bearing_peak", peak[:, k], part=part)


def _ends(r: Response) -> Iterator[Row]:
    for letter, force in r.end_bearings.items():
        end = "gearbox" if letter in "AB" else "pinion"
        yield _row(f"{end}_bearing_force", force, part=f"bearing {letter}")
    yield _row("spline_force", r.spline_force)


def _strength(r: Response) -> Iterator[Row]:
    yield from _each("critical_speed", "shaft", r.critical_speeds)
    states = len(r.demand.states)
    yield _row("line_critical_speed", np.full(states, r.line_critical_speed))
    yield from _each("tube_shear_utilisation", "shaft", r.tube_shear_utilisation)
    yield from _each("joint_torque_utilisation", "joint", r.joint_torque_utilisation)
    yield from _each("joint_fatigue_utilisation", "joint", r.joint_fatigue_utilisation)
    yield from _each("joint_life", "joint", r.life)
    yield from _each("joint_force", "joint", r.loads.joint_forces.peak)


def _room(r: Response) -> Iterator[Row]:
    yield _row("spline_travel", r.spline_travel)
    for k, obstacle in enumerate(r.obstacles):
        yield _row("clearance", r.clearances[..., k].min(-1), part=obstacle.name)
