"""Numbers that go into a criterion where it is worst: its operating point, angles, ratings."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from cardan.checks.line_response import LineResponse
from cardan.checks.quantities.registry import LINE_QUANTITIES, QUANTITIES
from cardan.core.arrays import FloatArray
from cardan.core.labels import WHOLE_LINE, Part
from cardan.core.units import MPa, mm, rpm
from cardan.core.verdict import Check
from cardan.model.parts import Tube
from cardan.physics.loads.rubber_mount import DEFAULT_LOSS_FACTOR
from cardan.render.i18n import Translator

N_MM = 1000.0
"""SI value of 1 N/mm."""

Row = tuple[str, str]
"""What a number is, and the number with its unit."""

QUANTITIES_PUT_IN = {
    "angle_for_speed": ("speed", "joint_angle"),
    "centre_bearing_static": ("torque",),
    "clearance_on_rubber": ("clearance",),
    "compound_angle": ("side_angle", "top_angle"),
    "critical_speed_ratio": ("critical_speed", "line_critical_speed"),
    "end_angle_difference": ("joint_angle", "joint_position"),
    "equivalent_angle": ("joint_angle", "joint_position"),
    "half_critical_band": ("critical_speed", "line_critical_speed"),
    "inertia_coast_acceleration": ("speed", "joint_angle", "joint_position"),
    "inertia_coast_torque": ("speed", "joint_angle", "joint_position"),
    "inertia_drive_acceleration": ("speed", "joint_angle", "joint_position"),
    "inertia_drive_torque": ("speed", "joint_angle", "joint_position"),
    "irregularity": ("joint_angle", "joint_position"),
    "joint_angle": ("side_angle", "top_angle"),
    "joint_angle_min": ("side_angle", "top_angle"),
    "joint_fatigue_utilisation": ("torque", "coast_torque"),
    "joint_life": ("joint_angle",),
    "n_beta": ("speed", "joint_angle"),
    "odd_joint_angle": ("joint_angle",),
    "resonance_distance": ("bearing_resonance",),
    "spline_force": ("torque",),
    "spline_travel_margin": ("spline_travel",),
    "torsional_acceleration": ("speed", "equivalent_angle", "joint_angle", "joint_position"),
    "tube_buckling_utilisation": ("torque",),
    "tube_fatigue_utilisation": ("torque",),
    "tube_shear_utilisation": ("torque",),
    "tube_stress_utilisation": ("torque", "bending_moment"),
}
"""Quantities that the equation of another one uses, those of all parts where it is of the line."""

FORCES_ON_RUBBER = {
    "centre_bearing_dynamic": ("dynamic", ("dynamic",)),
    "centre_bearing_peak": ("peak", ("static", "dynamic")),
}
"""Force whose worst operating point counts, and its parts there."""


@dataclass(frozen=True, kw_only=True)
class _Place:
    """A line where a check of it is worst: its response, and the indices of the case in it."""

    check: Check
    own: LineResponse
    response: LineResponse
    case: tuple[int, ...]
    """Indices of the case among the leading axes of values of `response`."""
    state: int

    def values(self, quantity: str) -> FloatArray:
        """Return the values of a quantity there, (parts,) SI."""
        values = LINE_QUANTITIES[quantity].values(self.response)
        lead = self.response.layout.directions.shape[:-2]
        return np.broadcast_to(values, (*lead, values.shape[-1]))[self.case]


def input_rows(c: Check, r: LineResponse, say: Translator) -> Iterator[Row]:
    """Yield the numbers put into a check: point, quantities of its equation, ratings, sections."""
    at = _place(c, r)
    if c.point is not None:
        if not QUANTITIES[c.quantity].uses_engine_torque:  # then the sizing torque below counts
            yield f"{say.name('torque')} (T)", f"{say.number(c.point.torque)} N·m"
        yield f"{say.name('speed')} (n)", f"{say.number(c.point.speed / rpm)} rpm"
    elsewhere = c.point is not None and at.response is r  # a point that only rubber needed
    for quantity in () if elsewhere else QUANTITIES_PUT_IN.get(c.quantity, ()):
        if c.point is None or quantity not in ("torque", "speed"):
            yield from _quantity_rows(at, quantity, say)
    if c.quantity in FORCES_ON_RUBBER:
        yield from _force_rows(at, say)
    for rows in _ROWS_BY_QUANTITY.get(c.quantity, ()):
        yield from rows(at, say)


def is_at_line_torque(c: Check) -> bool:
    """Return whether a check is of its point's torque, not of the engine's beyond tyre slip."""
    drives = c.point is not None and c.point.direction == "drive"
    return not (drives and QUANTITIES[c.quantity].uses_engine_torque)


def _place(c: Check, r: LineResponse) -> _Place:
    """Return where a check is: its own operating point where angles were evaluated there."""
    state = r.demand.states.index(c.when.name)
    envelope = r.operating_envelope
    if c.point is not None and envelope is not None:
        points = envelope.points
        for p in range(len(points.speed)):
            case = (p, *(0,) * (points.speed.ndim - 2), state)
            if points.operating_point(case) == c.point:
                return _Place(check=c, own=r, response=envelope.response, case=case, state=state)
    return _Place(check=c, own=r, response=r, case=(state,), state=state)


def _quantity_rows(at: _Place, quantity: str, say: Translator) -> Iterator[Row]:
    """Yield a quantity of the check's own part, or of every part where that has none."""
    q = QUANTITIES[quantity]
    parts = q.parts_of(at.own)
    numbers = dict(zip(parts, (at.values(quantity) / q.si_factor).tolist(), strict=True))
    chosen = [at.check.part] if at.check.part in numbers else list(parts)
    for part in chosen:
        if np.isfinite(numbers[part]):
            of = "" if part == WHOLE_LINE else say.part(part)
            name = f"{say.join(say.name(quantity), of)} ({q.symbol})"
            yield name, f"{say.number(numbers[part])} {q.unit_symbol}".rstrip()


def _force_rows(at: _Place, say: Translator) -> Iterator[Row]:
    """Yield the parts of a force on rubber at the point where the whole is largest."""
    force, parts = FORCES_ON_RUBBER[at.check.quantity]
    loads, bearing = at.own.mount_loads, int(at.check.part.number) - 1
    worst, solved = loads.worst_bearing_forces, loads.stop_response
    if force in worst:
        stuck = loads.stuck_forces_of(force, at.state, bearing)
        for name in parts:
            value, least = getattr(worst[force].results, name)[at.state, bearing], ""
            if solved is not None and solved.is_solved[at.state]:
                own = solved.peak_parts[name] if force == "peak" else solved.force(name)
                value = own[at.state, bearing]
            elif at.check.is_lower_bound:
                value, least = loads.force_at_stop(name)[at.state, bearing], "≥ "
            if name in stuck:
                value = stuck[name]
            quantity = f"centre_bearing_{name}"
            symbol = QUANTITIES[quantity].symbol
            yield f"{say.name(quantity)} ({symbol})", f"{least}{say.number(float(value))} N"


# --------------------------------------------------------------------------- parts


def _tube_rows(at: _Place, say: Translator) -> Iterator[Row]:
    shaft = at.own.line.shafts[int(at.check.part.number) - 1]
    if isinstance(shaft.tube, Tube):
        yield f"{say('outer diameter')} (D)", f"{say.compact_number(shaft.tube.outer / mm)} mm"
        yield f"{say('inner diameter')} (d)", f"{say.compact_number(shaft.tube.inner / mm)} mm"
        strength = shaft.tube.material.yield_strength
        if strength is not None:
            yield f"{say('yield strength')} (Re)", f"{say.compact_number(strength / MPa)} MPa"


def _shock_rows(at: _Place, say: Translator) -> Iterator[Row]:
    yield f"{say('shock factor')} (K)", say.compact_number(at.own.application.shock_factor)


def _rating_rows(name: str, label: str) -> Callable[[_Place, Translator], Iterator[Row]]:
    def rows(at: _Place, say: Translator) -> Iterator[Row]:
        value = float(at.own.inputs.rating(name)[..., int(at.check.part.number) - 1].flat[0])
        if np.isfinite(value):
            yield say(label), f"{say.number(value)} N·m"

    return rows


def _sizing_torque_rows(at: _Place, say: Translator) -> Iterator[Row]:
    values = at.response.strength.sizing_torque[at.case]
    value = float(values[int(at.check.part.number) - 1])
    yield say("largest torque round a turn, shocks included (T)"), f"{say.number(value)} N·m"


def _life_rows(at: _Place, say: Translator) -> Iterator[Row]:
    value = float(at.own.strength.life_ratings[..., int(at.check.part.number) - 1].flat[0])
    if np.isfinite(value):
        yield f"{say('life rating')} (Td)", f"{say.number(value)} N·m"
    factor = say.compact_number(at.own.application.prime_mover_factor)
    yield f"{say('prime mover factor')} (K1)", factor
    if not at.own.inputs.duty_points:
        yield from _quantity_rows(at, "torque", say)
        yield from _quantity_rows(at, "speed", say)
    for point in at.own.inputs.duty_points:
        torque, speed = (float(np.ravel(v)[0]) for v in (point.torque, point.speed))
        share = say.percentage(float(np.ravel(point.share)[0]))
        numbers = f"{share}: {say.number(torque)} N·m, {say.number(speed / rpm)} rpm"
        yield say("duty cycle"), numbers


def _mount_rows(at: _Place, say: Translator) -> Iterator[Row]:
    bearings = at.own.line.centre_bearings
    chosen = [int(at.check.part.number)] if at.check.part.kind == "centre bearing" else None
    for k in chosen or range(1, len(bearings) + 1):
        bearing, part = bearings[k - 1], say.part(Part("centre bearing", k))
        if bearing.stiffness is None:
            continue
        values = (say.compact_number(v / N_MM, 4) for v in bearing.stiffness)
        yield (
            f"{say.join(say('stiffness, vertical and lateral'), part)} (k)",
            f"{say.join(*values)} N/mm",
        )
        loss = bearing.loss_factor
        number = say.compact_number(DEFAULT_LOSS_FACTOR if loss is None else loss)
        assumed = say("{value} (assumed)", value=number) if loss is None else number
        yield f"{say.join(say('loss factor'), part)} (η)", assumed


def _travel_rows(at: _Place, say: Translator) -> Iterator[Row]:
    stop = at.own.line.centre_bearings[int(at.check.part.number) - 1].travel
    if stop is not None:
        yield f"{say('travel of the rubber to its stop')} (u0)", f"{say.number(stop / mm)} mm"


def _spline_rows(at: _Place, say: Translator) -> Iterator[Row]:
    spline = at.own.line.shafts[-1].spline
    given = (("plunge", spline.plunge), ("draw", spline.draw)) if spline else ()
    for name, value in given:
        if value is not None:
            yield say(name), f"{say.number(value / mm)} mm"


def _friction_rows(at: _Place, say: Translator) -> Iterator[Row]:
    spline = at.own.line.shafts[-1].spline
    if spline is not None:
        yield f"{say('friction of the spline')} (μ)", say.compact_number(spline.friction)
        if spline.mean_radius is not None:
            radius = f"{say.number(spline.mean_radius / mm)} mm"
            yield f"{say('mean spline radius')} (rm)", radius


def _phase_rows(at: _Place, say: Translator) -> Iterator[Row]:
    for k, phase in enumerate(at.own.line.phases, 1):
        degrees = f"{say.compact_number(float(np.degrees(phase)))} deg"
        yield f"{say.join(say('yoke phase'), say.part(Part('shaft', k)))} (ε)", degrees


def _reached_speed_rows(at: _Place, say: Translator) -> Iterator[Row]:
    reached = float(at.own.inputs.reached_speed[at.state])
    if np.isfinite(reached):
        yield (
            f"{say('largest speed that the line reaches')} (n)",
            f"{say.number(reached / rpm)} rpm",
        )


_ROWS_BY_QUANTITY: dict[str, tuple[Callable[[_Place, Translator], Iterator[Row]], ...]] = {
    **dict.fromkeys(
        (
            "equivalent_angle", "torsional_acceleration", "inertia_drive_acceleration",
            "inertia_coast_acceleration", "inertia_drive_torque", "inertia_coast_torque",
            "irregularity", "end_angle_difference",
        ),
        (_phase_rows,),
    ),
    "centre_bearing_static": (_mount_rows, _friction_rows),
    "centre_bearing_dynamic": (_mount_rows,),
    "centre_bearing_peak": (_mount_rows,),
    "centre_bearing_travel": (_mount_rows,),
    "centre_bearing_travel_utilisation": (_mount_rows, _travel_rows),
    "clearance_on_rubber": (_mount_rows,),
    "resonance_distance": (_mount_rows,),
    "spline_compression_utilisation": (_mount_rows, _friction_rows),
    "spline_force": (_friction_rows,),
    "spline_travel_margin": (_spline_rows,),
    "swing_growth": (_mount_rows,),
    "critical_speed_ratio": (_reached_speed_rows,),
    "half_critical_band": (_reached_speed_rows,),
    "tube_shear_utilisation": (_shock_rows, _tube_rows),
    "tube_stress_utilisation": (_shock_rows, _tube_rows),
    "tube_buckling_utilisation": (_shock_rows, _tube_rows),
    "tube_fatigue_utilisation": (_tube_rows,),
    "joint_torque_utilisation": (
        _sizing_torque_rows, _rating_rows("peak_torque", "functional limit torque (Tcs)"),
    ),
    "joint_fatigue_utilisation": (
        _rating_rows("reversing_torque", "reversing torque (Tdw)"),
        _rating_rows("pulsating_torque", "pulsating torque (Tds)"),
    ),
    "joint_life": (_life_rows,),
}  # fmt: skip
"""What an equation uses in addition to quantities: sections, ratings, rubber."""
