"""What limits can ask about: each quantity, the parts that have it, and its values."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from cardan.base.arrays import FloatArray, stacked
from cardan.base.verdict import Limit
from cardan.kinematics.equivalent import Excitation, pythagorean_angle
from cardan.model.parts import JointSize
from cardan.quantity.response import Response

Of: TypeAlias = Callable[[Response], FloatArray]


@dataclass(frozen=True, kw_only=True)
class Held:
    """A quantity that limits may ask about.

    `parts` names what has it, `of` computes it for those parts, (..., states, parts), nan
    where nothing is known. `rating` is where a catalogue's joint brings a limit of its own
    along, beside a profile's, or with `own_first` in place of it.
    """

    parts: Callable[[Response], tuple[str, ...]]
    of: Of
    rating: str = ""
    own_first: bool = False

    def own(self, response: Response, quantity: str) -> tuple[Limit | None, ...]:
        """Return the limit of each joint's own, None where its catalogue has none."""
        return tuple(_own(size, quantity, self.rating) for size in response.sizes)


def _own(size: JointSize | None, quantity: str, rating: str) -> Limit | None:
    value = getattr(size, rating) if size and rating else None
    return Limit(quantity=quantity, maximum=value, source=size.source) if size and value else None


def _joints(r: Response) -> tuple[str, ...]:
    return tuple(f"joint {k}" for k in range(1, r.line.joint_count + 1))


def _shafts(r: Response) -> tuple[str, ...]:
    return tuple(f"shaft {k}" for k in range(1, r.line.joint_count))


def _bearings(r: Response) -> tuple[str, ...]:
    return tuple(f"centre bearing {k}" for k in range(1, r.line.joint_count - 1))


def _lettered(letters: str) -> Callable[[Response], tuple[str, ...]]:
    return lambda _: tuple(f"bearing {letter}" for letter in letters)


def _end_bearings(letters: str) -> Of:
    return lambda r: stacked(r.end_bearings[letter] for letter in letters)


def _line(_: Response) -> tuple[str, ...]:
    return ("line",)


def _suspended(r: Response) -> tuple[str, ...]:
    """Return the line, if its suspension is not that of a line before it."""
    installed = r.demand.installed
    first = installed.line.name == r.application.lines[0].line.name
    return ("line",) if first or installed.suspension else ()


def _whirling(r: Response) -> tuple[str, ...]:
    return (*_shafts(r), "line")


def _pairs(r: Response) -> tuple[str, ...]:
    return tuple(f"{s} to {o.name}" for s in _shafts(r) for o in r.obstacles)


def _of_excitation(value: Callable[[Excitation], FloatArray | None]) -> Held:
    """Return a quantity of the line's excitation, nan where inertias are not known."""

    def of(r: Response) -> FloatArray:
        found = value(r.excitation)
        cases = np.zeros(r.layout.directions.shape[:-2])
        return (cases + (np.nan if found is None else found))[..., None]

    return Held(parts=_line, of=of)


def _speed(r: Response) -> FloatArray:
    return np.broadcast_to(r.demand.speed[..., None], r.angles.shape)


def _speed_ratios(r: Response) -> FloatArray:
    critical = [*np.moveaxis(r.critical_speeds, -1, 0), r.line_critical_speed]
    return r.demand.speed[..., None] / stacked(critical)


def _clearances(r: Response) -> FloatArray:
    return r.clearances.reshape(*r.clearances.shape[:-2], -1)


def _suspension_frequency(r: Response) -> FloatArray:
    frequency = np.broadcast_to(r.demand.suspension_frequency, r.angles.shape[:-1])
    return np.repeat(frequency[..., None], len(_suspended(r)), axis=-1)


HELD: dict[str, Held] = {
    "joint_angle": Held(parts=_joints, of=lambda r: r.angles, rating="angle_max"),
    "joint_angle_min": Held(parts=_joints, of=lambda r: r.angles),
    "compound_angle": Held(
        parts=_joints, of=lambda r: pythagorean_angle(r.side_angles, r.top_angles)
    ),
    "end_angle_difference": Held(
        parts=_line, of=lambda r: np.abs(r.angles[..., :1] - r.angles[..., -1:])
    ),
    "angle_for_speed": Held(parts=_joints, of=lambda r: (_speed(r) * r.angles) ** 2),
    "equivalent_angle": _of_excitation(lambda e: e.torsional.angle),
    "torsional_acceleration": _of_excitation(lambda e: e.torsional.acceleration),
    "inertia_drive_acceleration": _of_excitation(lambda e: e.drive.acceleration),
    "inertia_coast_acceleration": _of_excitation(lambda e: e.coast.acceleration),
    "inertia_drive_torque": _of_excitation(lambda e: e.drive_torque),
    "inertia_coast_torque": _of_excitation(lambda e: e.coast_torque),
    "irregularity": _of_excitation(lambda e: e.irregularity),
    "centre_bearing_static": Held(
        parts=_bearings, of=lambda r: np.linalg.norm(r.loads.bearing_forces.static, axis=-1)
    ),
    "centre_bearing_dynamic": Held(
        parts=_bearings, of=lambda r: r.loads.bearing_forces.dynamic
    ),
    "centre_bearing_peak": Held(parts=_bearings, of=lambda r: r.bearing_peaks),
    "gearbox_bearing_force": Held(parts=_lettered("AB"), of=_end_bearings("AB")),
    "pinion_bearing_force": Held(parts=_lettered("EF"), of=_end_bearings("EF")),
    "spline_force": Held(
        parts=lambda r: _shafts(r)[-1:], of=lambda r: r.spline_force[..., None]
    ),
    "critical_speed_ratio": Held(parts=_whirling, of=_speed_ratios),
    "half_critical_band": Held(parts=_whirling, of=_speed_ratios),
    "joint_torque_utilisation": Held(parts=_joints, of=lambda r: r.joint_torque_utilisation),
    "joint_fatigue_utilisation": Held(parts=_joints, of=lambda r: r.joint_fatigue_utilisation),
    "tube_shear_utilisation": Held(parts=_shafts, of=lambda r: r.tube_shear_utilisation),
    "joint_life": Held(parts=_joints, of=lambda r: r.life),
    "n_beta": Held(
        parts=_joints, of=lambda r: _speed(r) * r.angles, rating="speed_angle_max",
        own_first=True,
    ),
    "joint_speed": Held(parts=_joints, of=_speed, rating="speed_max", own_first=True),
    "spline_travel_margin": Held(
        parts=lambda r: _shafts(r)[-1:], of=lambda r: r.spline_travel_margin[..., None]
    ),
    "clearance": Held(parts=_pairs, of=_clearances),
    "suspension_frequency": Held(parts=_suspended, of=_suspension_frequency),
}  # fmt: skip
"""What limits can ask about, by quantity."""
