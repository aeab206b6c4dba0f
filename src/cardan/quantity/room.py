"""Room to move: spline and clearances."""

import numpy as np

from cardan.base.arrays import FloatArray
from cardan.base.part import Part
from cardan.base.source import DERIVED
from cardan.quantity.bearings import STEADY
from cardan.quantity.declared import (
    LENGTHS,
    REACH,
    RUBBER,
    STROKE,
    TORQUE,
    Quantity,
    last_shaft,
    of_line,
)
from cardan.quantity.response import Response


def _pairs(r: Response) -> tuple[Part, ...]:
    """Return each shaft with each obstacle."""
    return tuple(
        Part("clearance", k, o.name) for k in range(1, r.line.joint_count) for o in r.obstacles
    )


def _hung_pairs(r: Response) -> tuple[Part, ...]:
    """Return the same of a line that hangs in centre bearings."""
    return _pairs(r) if r.line.joint_count > 2 else ()


def _on_rubber(r: Response) -> FloatArray:
    """Return what rubber leaves of the clearances, (..., S, parts) m; nan if nobody knows."""
    worst, parts = r.worst_reach, len(_hung_pairs(r))
    none = np.full((*r.angles.shape[:-1], parts), np.nan)
    return none if worst is None else -worst.running.reach


DECLARED = (
    Quantity(
        key="spline_travel",
        at_points=True,
        signed=True,
        name="Spline travel",
        symbol="ΔL",
        unit="mm",
        equation="ΔL = length of the last shaft − its length in the reference state",
        source=DERIVED,
        of=of_line(lambda r: r.spline_travel),
        parts=last_shaft,
        needs=(LENGTHS,),
        section="Room",
        contract="spline_travel_mm",
    ),
    Quantity(
        key="spline_travel_margin",
        at_points=True,
        name="Spline travel left",
        symbol="s",
        unit="mm",
        equation="s = min(plunge + ΔL, draw − ΔL)",
        where={"plunge, draw": "travel from the installed place, in and out"},
        source=DERIVED,
        of=of_line(lambda r: r.spline_travel_margin),
        parts=last_shaft,
        sense=">=",
        needs=(LENGTHS, STROKE),
        section="Room",
    ),
    Quantity(
        key="clearance",
        at_points=True,
        name="Clearance",
        symbol="c",
        unit="mm",
        equation="c = distance of shaft axis and obstacle axis − their radii",
        source=DERIVED,
        use="At a joint whose swing_diameter is known, the radius is that of its yokes there.",
        of=lambda r: r.clearances.reshape(*r.clearances.shape[:-2], -1),
        parts=_pairs,
        sense=">=",
        needs=(LENGTHS,),
        section="Room",
        contract="clearances_mm{}",
    ),
    Quantity(
        key="clearance_on_rubber",
        name="Clearance on rubber",
        symbol="cr",
        unit="mm",
        equation="cr = c + a · us − |a · ut| − Σ |a · uk|",
        where={
            "c": "clearance, with rubber that does not give (clearance)",
            "a": "direction from obstacle to shaft, where they are nearest",
            "us": "how far the torque takes the shaft there on its rubber, from where it hangs",
            "ut": "what the worst thrust of the sliding fit adds",
            "uk": "complex amplitude of orders 2, 4 and 6, and of the unbalance where it counts",
        },
        source=DERIVED,
        use="At the worst operating point of the state, steadily: passing a resonance quickly "
        "takes less. A distance is convex, so this is never more than what is left. Below 0 the "
        "shaft hits what is in its way. The rubber goes on as it begins, beyond a stop too; "
        "brackets and flanges that give are in it.",
        of=_on_rubber,
        sought=lambda r: r.worst_reach,
        shaken=True,
        on_rubber=True,
        parts=_hung_pairs,
        sense=">=",
        needs=(LENGTHS, TORQUE, REACH, RUBBER, STEADY),
        section="Room",
        contract="clearances_on_rubber_mm{}",
    ),
)
