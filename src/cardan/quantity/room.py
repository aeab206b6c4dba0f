"""Room to move: spline and clearances."""

from cardan.base.part import Part
from cardan.base.source import DERIVED
from cardan.quantity.declared import LENGTHS, STROKE, Quantity, last_shaft, of_line
from cardan.quantity.response import Response


def _pairs(r: Response) -> tuple[Part, ...]:
    """Return each shaft with each obstacle."""
    return tuple(
        Part("clearance", k, o.name) for k in range(1, r.line.joint_count) for o in r.obstacles
    )


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
        of=lambda r: r.clearances.reshape(*r.clearances.shape[:-2], -1),
        parts=_pairs,
        sense=">=",
        needs=(LENGTHS,),
        section="Room",
        contract="clearances_mm{}",
    ),
)
