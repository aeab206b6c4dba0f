"""How a line shakes: as the one joint that does the same, and as accelerations."""

from collections.abc import Callable
from typing import Any

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.formula import written
from cardan.base.source import AE7, DERIVED, ELBE, J3311
from cardan.kinematics.equivalent import Excitation
from cardan.quantity.declared import INERTIAS, SPEED, Of, Quantity, crosses, line, of_kind
from cardan.quantity.response import Response


def _of(e: Excitation, value: Callable[[Excitation], FloatArray | None], r: Response) -> FloatArray:
    found = value(e)
    return _told(np.nan if found is None else found, r)


def _told(found: FloatArray | float, r: Response) -> FloatArray:
    """Return numbers of the line as a whole, in each case of its layouts."""
    return (np.zeros(r.layout.directions.shape[:-2]) + found)[..., None]


def _exact(value: Callable[[Excitation], FloatArray | None]) -> Of:
    """Return how to compute something of a line's excitation; nan without inertias."""
    return lambda r: _of(r.excitation, value, r)


def _approximated(name: str, value: Callable[[Excitation], FloatArray | None]) -> Of:
    """Return the same by one of the field's approximations."""
    return lambda r: _of(r.approximations[name], value, r)


def _by_itself(speed: Any, angle: Any) -> Any:
    """Return about the largest acceleration that a joint alone makes."""
    return speed**2 * angle**2


DECLARED = (
    Quantity(
        key="equivalent_angle",
        at_points=True,
        name="Torsional equivalent angle",
        symbol="βR",
        unit="deg",
        equation="βR = 2 atan √|E|",
        where={"E": "phasor of the pinion: it turns as one joint of angle βR would drive it"},
        source=DERIVED,
        use="The angle of the one joint that shakes as much as the whole line, exactly.",
        of=_exact(lambda e: e.torsional.angle),
        parts=line,
        section="Excitation",
        methods={
            "ae7": _approximated("ae7", lambda e: e.torsional.angle),
            "in_plane": _approximated("in_plane", lambda e: e.torsional.angle),
        },
        contract="torsional.equivalent_angle_deg",
    ),
    Quantity(
        key="torsional_acceleration",
        at_points=True,
        name="Torsional acceleration",
        symbol="αR",
        unit="rad_s2",
        equation="αR = max over a turn of |αn| at constant gearbox speed",
        where={"αn": "angular acceleration of the pinion"},
        source=DERIVED,
        use="Kinematic, members rigid. AE-7's approximation is ω² |Σ sk Dk²|.",
        of=_exact(lambda e: e.torsional.acceleration),
        parts=line,
        needs=(SPEED,),
        section="Excitation",
        methods={
            "ae7": _approximated("ae7", lambda e: e.torsional.acceleration),
            "in_plane": _approximated("in_plane", lambda e: e.torsional.acceleration),
        },
        contract="torsional.acceleration_rad_s2",
    ),
    Quantity(
        key="inertia_drive_acceleration",
        at_points=True,
        name="Inertia acceleration, drive",
        symbol="αD",
        unit="rad_s2",
        equation="αD = max over a turn of |Σ αj|, j over the shafts, gearbox turning uniformly",
        where={"αj": "angular acceleration of shaft j"},
        source=AE7.at("p. 50"),
        use="A sum over shafts of equal inertia; `inertia_drive_torque` uses the real ones.",
        of=_exact(lambda e: e.drive.acceleration),
        parts=line,
        needs=(SPEED,),
        section="Excitation",
        methods={"ae7": _approximated("ae7", lambda e: e.drive.acceleration)},
        contract="drive.acceleration_rad_s2",
    ),
    Quantity(
        key="inertia_coast_acceleration",
        at_points=True,
        name="Inertia acceleration, coast",
        symbol="αC",
        unit="rad_s2",
        equation="αC = max over a turn of |Σ αj|, j over the shafts, pinion turning uniformly",
        where={"αj": "angular acceleration of shaft j"},
        source=AE7.at("p. 50"),
        use="A sum over shafts of equal inertia; `inertia_coast_torque` uses the real ones.",
        of=_exact(lambda e: e.coast.acceleration),
        parts=line,
        needs=(SPEED,),
        section="Excitation",
        methods={"ae7": _approximated("ae7", lambda e: e.coast.acceleration)},
        contract="coast.acceleration_rad_s2",
    ),
    Quantity(
        key="inertia_drive_torque",
        at_points=True,
        name="Inertia torque, drive",
        symbol="TD",
        unit="Nm",
        equation="TD = max over a turn of |Σ Jj αj|, gearbox turning uniformly",
        where={"Jj": "polar mass moment of inertia of shaft j", "αj": "its acceleration"},
        source=DERIVED,
        of=lambda r: _told(r.shaft_torques[0], r),
        parts=line,
        needs=(
            SPEED,
            INERTIAS,
        ),
        section="Excitation",
        contract="drive.torque_Nm",
    ),
    Quantity(
        key="inertia_coast_torque",
        at_points=True,
        name="Inertia torque, coast",
        symbol="TC",
        unit="Nm",
        equation="TC = max over a turn of |Σ Jj αj|, pinion turning uniformly",
        where={"Jj": "polar mass moment of inertia of shaft j", "αj": "its acceleration"},
        source=DERIVED,
        of=lambda r: _told(r.shaft_torques[1], r),
        parts=line,
        needs=(
            SPEED,
            INERTIAS,
        ),
        section="Excitation",
        contract="coast.torque_Nm",
    ),
    Quantity(
        key="irregularity",
        at_points=True,
        name="Irregularity of the line",
        symbol="U",
        unit="1",
        equation="U = (ωn,max − ωn,min) / ω₀",
        where={"ωn": "pinion speed round the turn", "ω₀": "gearbox speed"},
        source=ELBE,
        of=_exact(lambda e: e.irregularity),
        parts=line,
        section="Excitation",
        contract="torsional.irregularity",
    ),
    Quantity(
        key="angle_for_speed",
        at_points=True,
        name="Acceleration of a joint by itself",
        symbol="ω²β²",
        unit="rad_s2",
        equation=written(_by_itself, "ω", "β"),
        where={"ω": "shaft speed", "β": "true joint angle, rad"},
        source=J3311,
        use="The largest angle for a speed: 1000 rad/s² is 5.8 deg at 3000 rpm.",
        of=lambda r: _by_itself(r.demand.speed[..., None], r.angles[..., of_kind(r, "cross")]),
        parts=crosses,
        needs=(SPEED,),
    ),
)
