"""How a line shakes: as the one joint that does the same, and as accelerations."""

from collections.abc import Callable
from typing import Any

import numpy as np

from cardan.checks.line_response import LineResponse
from cardan.checks.quantities.declaration import (
    NEEDS_SHAFT_INERTIAS,
    NEEDS_SPEED,
    Quantity,
    QuantityFunction,
    cross_joints,
    joint_indices_of_kind,
    whole_line,
)
from cardan.core.arrays import FloatArray
from cardan.core.provenance import ELBE_CATALOGUE, SAE_AE7, SOURCE_DERIVED, SPICER_J3311
from cardan.core.symbolic import trace_expression
from cardan.physics.kinematics.equivalent_angle import KinematicExcitation


def _of(
    e: KinematicExcitation,
    value: Callable[[KinematicExcitation], FloatArray | None],
    r: LineResponse,
) -> FloatArray:
    found = value(e)
    return _told(np.nan if found is None else found, r)


def _told(found: FloatArray | float, r: LineResponse) -> FloatArray:
    """Return numbers of the line as a whole, in each case of its layouts."""
    return (np.zeros(r.layout.directions.shape[:-2]) + found)[..., None]


def _exact(value: Callable[[KinematicExcitation], FloatArray | None]) -> QuantityFunction:
    """Return how to compute something of a line's excitation; nan without inertias."""
    return lambda r: _of(r.kinematics.excitation, value, r)


def _approximated(
    name: str, value: Callable[[KinematicExcitation], FloatArray | None]
) -> QuantityFunction:
    """Return the same by one of the field's approximations."""
    return lambda r: _of(r.kinematics.approximate_excitations[name], value, r)


def _by_itself(speed: Any, angle: Any) -> Any:
    """Return about the largest acceleration that a joint alone makes."""
    return speed**2 * angle**2


DECLARATIONS = (
    Quantity(
        key="equivalent_angle",
        at_all_points=True,
        name="Torsional equivalent angle",
        symbol="βR",
        unit="deg",
        equation="βR = 2 atan √|E|",
        symbol_meanings={
            "E": "phasor of the pinion: it turns as one joint of angle βR would drive it"
        },
        source=SOURCE_DERIVED,
        validity="The angle of the one joint that shakes as much as the whole line, exactly.",
        compute=_exact(lambda e: e.torsional.angle),
        parts=whole_line,
        section="Excitation",
        approximations={
            "ae7": _approximated("ae7", lambda e: e.torsional.angle),
            "in_plane": _approximated("in_plane", lambda e: e.torsional.angle),
        },
        json_path="torsional.equivalent_angle_deg",
    ),
    Quantity(
        key="torsional_acceleration",
        at_all_points=True,
        name="Torsional acceleration",
        symbol="αR",
        unit="rad_s2",
        equation="αR = max over a turn of |αn| at constant gearbox speed",
        symbol_meanings={"αn": "angular acceleration of the pinion"},
        source=SOURCE_DERIVED,
        validity="Kinematic, members rigid. AE-7's approximation is ω² |Σ sk Dk²|.",
        compute=_exact(lambda e: e.torsional.acceleration),
        parts=whole_line,
        requirements=(NEEDS_SPEED,),
        section="Excitation",
        approximations={
            "ae7": _approximated("ae7", lambda e: e.torsional.acceleration),
            "in_plane": _approximated("in_plane", lambda e: e.torsional.acceleration),
        },
        json_path="torsional.acceleration_rad_s2",
    ),
    Quantity(
        key="inertia_drive_acceleration",
        at_all_points=True,
        name="Inertia acceleration, drive",
        symbol="αD",
        unit="rad_s2",
        equation="αD = max over a turn of |Σ αj|, j over the shafts, gearbox turning uniformly",
        symbol_meanings={"αj": "angular acceleration of shaft j"},
        source=SAE_AE7.with_place("p. 50"),
        validity="A sum over shafts of equal inertia; `inertia_drive_torque` uses the real ones.",
        compute=_exact(lambda e: e.drive.acceleration),
        parts=whole_line,
        requirements=(NEEDS_SPEED,),
        section="Excitation",
        approximations={"ae7": _approximated("ae7", lambda e: e.drive.acceleration)},
        json_path="drive.acceleration_rad_s2",
    ),
    Quantity(
        key="inertia_coast_acceleration",
        at_all_points=True,
        name="Inertia acceleration, overrun",
        symbol="αC",
        unit="rad_s2",
        equation="αC = max over a turn of |Σ αj|, j over the shafts, pinion turning uniformly",
        symbol_meanings={"αj": "angular acceleration of shaft j"},
        source=SAE_AE7.with_place("p. 50"),
        validity="A sum over shafts of equal inertia; `inertia_coast_torque` uses the real ones.",
        compute=_exact(lambda e: e.coast.acceleration),
        parts=whole_line,
        requirements=(NEEDS_SPEED,),
        section="Excitation",
        approximations={"ae7": _approximated("ae7", lambda e: e.coast.acceleration)},
        json_path="coast.acceleration_rad_s2",
    ),
    Quantity(
        key="inertia_drive_torque",
        at_all_points=True,
        name="Inertia torque, drive",
        symbol="TD",
        unit="Nm",
        equation="TD = max over a turn of |Σ Jj αj|, gearbox turning uniformly",
        symbol_meanings={"Jj": "polar mass moment of inertia of shaft j", "αj": "its acceleration"},
        source=SOURCE_DERIVED,
        compute=lambda r: _told(r.kinematics.inertia_torques[0], r),
        parts=whole_line,
        requirements=(
            NEEDS_SPEED,
            NEEDS_SHAFT_INERTIAS,
        ),
        section="Excitation",
        json_path="drive.torque_Nm",
    ),
    Quantity(
        key="inertia_coast_torque",
        at_all_points=True,
        name="Inertia torque, overrun",
        symbol="TC",
        unit="Nm",
        equation="TC = max over a turn of |Σ Jj αj|, pinion turning uniformly",
        symbol_meanings={"Jj": "polar mass moment of inertia of shaft j", "αj": "its acceleration"},
        source=SOURCE_DERIVED,
        compute=lambda r: _told(r.kinematics.inertia_torques[1], r),
        parts=whole_line,
        requirements=(
            NEEDS_SPEED,
            NEEDS_SHAFT_INERTIAS,
        ),
        section="Excitation",
        json_path="coast.torque_Nm",
    ),
    Quantity(
        key="irregularity",
        at_all_points=True,
        name="Irregularity of the line",
        symbol="U",
        unit="1",
        equation="U = (ωn,max − ωn,min) / ω₀",
        symbol_meanings={"ωn": "pinion speed round the turn", "ω₀": "gearbox speed"},
        source=ELBE_CATALOGUE,
        compute=_exact(lambda e: e.irregularity),
        parts=whole_line,
        section="Excitation",
        json_path="torsional.irregularity",
    ),
    Quantity(
        key="angle_for_speed",
        at_all_points=True,
        name="Single-joint acceleration",
        symbol="ω²β²",
        unit="rad_s2",
        equation=trace_expression(_by_itself, "ω", "β"),
        symbol_meanings={"ω": "shaft speed", "β": "true joint angle, rad"},
        source=SPICER_J3311,
        validity="The largest angle for a speed: 1000 rad/s² is 5.8 deg at 3000 rpm.",
        compute=lambda r: _by_itself(
            r.demand.speed[..., None], r.joint_angles[..., joint_indices_of_kind(r, "cross")]
        ),
        parts=cross_joints,
        requirements=(NEEDS_SPEED,),
    ),
)
