"""Room to move: spline and clearances."""

import numpy as np

from cardan.checks.line_response import LineResponse
from cardan.checks.quantities.bearings import NEEDS_STABLE_LINE, NEEDS_THRUST_EQUILIBRIUM
from cardan.checks.quantities.declaration import (
    NEEDS_MOUNT_STIFFNESS,
    NEEDS_SHAFT_LENGTHS,
    NEEDS_SPEED_ZERO_ALLOWED,
    NEEDS_SPLINE_STROKE,
    NEEDS_TORQUE,
    Quantity,
    Requirement,
    last_shaft,
    make_whole_line_quantity_function,
)
from cardan.core.arrays import FloatArray
from cardan.core.labels import Part
from cardan.core.provenance import SOURCE_DERIVED, Source
from cardan.core.verdict import Limit


def _pairs(r: LineResponse) -> tuple[Part, ...]:
    """Return each shaft with each obstacle."""
    return tuple(
        Part("clearance", k, o.name)
        for k in range(1, r.line.joint_count)
        for o in r.inputs.obstacles
    )


def _discs(r: LineResponse) -> tuple[Part, ...]:
    """Return the flexible discs that take up the last shaft's length."""
    return tuple(Part("joint", k + 1) for k in r.clearances.length_taking_discs)


def _sliding_shaft(r: LineResponse) -> tuple[Part, ...]:
    """Return the last shaft, unless flexible discs take up its length: those slide nowhere."""
    return () if _discs(r) else last_shaft(r)


_NEEDS_AXIAL_LIMIT = Requirement(
    required_input="plunge_mm of the flexible disc",
    is_met=lambda r: np.array(
        [[all((s := r.joint_sizes[k]) and s.plunge is not None
              for k in r.clearances.length_taking_discs)]]
    ),
)  # fmt: skip
"""Of both ends of the shaft, where both are discs: they share its length."""


def _hung_pairs(r: LineResponse) -> tuple[Part, ...]:
    """Return the same of a line that hangs in centre bearings that give."""
    return _pairs(r) if r.line.joint_count > 2 and not r.mounts.is_rigid else ()


def _on_rubber(r: LineResponse) -> FloatArray:
    """Return what rubber leaves of the clearances, (..., S, parts) m; nan if unknown."""
    worst, parts = r.mount_loads.worst_obstacle_clearance, len(_hung_pairs(r))
    if worst is None:
        return np.full((*r.joint_angles.shape[:-1], parts), np.nan)
    left, at_stop = -worst.results.reach, r.mount_loads.stop_response
    # A stop holds back what linear rubber lets go away from an obstacle.
    return left if at_stop is None else np.minimum(left, -at_stop.reach)


def _stop_margin(r: LineResponse) -> FloatArray:
    """Return the share of the travel to a stop that bearings have left, (..., S, 1).

    1 where the line is solved with its stops: then the clearance has them in it.
    """
    margin = r.mount_loads.stop_margin("peak").min(axis=-1, keepdims=True, initial=1.0)
    return np.where(r.mount_loads.is_solved_at_stop, 1.0, margin)


def _worst_beyond_stop(r: LineResponse) -> FloatArray:
    """Return the same if a stop made shafts go further by all that rubber travels, (..., S, parts).

    Far more than stops do: in the examples they make shafts go further by 2.3 mm at most.
    """
    left, goes = _on_rubber(r), r.mount_loads.worst_bearing_travel
    if goes is None:
        return left
    return left - np.nan_to_num(goes.results.peak).max(axis=-1, keepdims=True)


DECLARATIONS = (
    Quantity(
        key="spline_travel",
        at_all_points=True,
        signed=True,
        name="Spline travel",
        symbol="ΔL",
        unit="mm",
        equation="ΔL = length of the last shaft − its length in the reference state",
        source=SOURCE_DERIVED,
        compute=make_whole_line_quantity_function(lambda r: r.clearances.spline_travel),
        parts=last_shaft,
        requirements=(NEEDS_SHAFT_LENGTHS,),
        section="Room",
        json_path="spline_travel_mm",
    ),
    Quantity(
        key="spline_travel_margin",
        at_all_points=True,
        name="Spline travel left",
        symbol="s",
        unit="mm",
        equation="s = min(plunge + ΔL, draw − ΔL)",
        symbol_meanings={"plunge, draw": "travel from the installed place, in and out"},
        source=SOURCE_DERIVED,
        compute=lambda r: r.clearances.spline_travel_margin[..., None][
            ..., : len(_sliding_shaft(r))
        ],
        parts=_sliding_shaft,
        sense=">=",
        requirements=(NEEDS_SHAFT_LENGTHS, NEEDS_SPLINE_STROKE),
        section="Room",
    ),
    Quantity(
        key="disc_axial_utilisation",
        at_all_points=True,
        name="Axial deflection of a flexible disc over its limit",
        symbol="a/a0",
        unit="1",
        equation="|ΔL| / Σ a0",
        symbol_meanings={
            "ΔL": "change of the last shaft's length (spline_travel)",
            "a0": "what each flexible disc at its ends may give along the line, either way",
        },
        source=SOURCE_DERIVED,
        validity="Of a last shaft without a spline; with one it is the spline that slides.",
        compute=lambda r: r.clearances.disc_axial_utilisation,
        parts=_discs,
        limit_by_definition=Limit(
            quantity="disc_axial_utilisation",
            maximum=1.0,
            source=Source("By definition of the joint's own limit", how_read="by definition"),
        ),
        requirements=(NEEDS_SHAFT_LENGTHS, _NEEDS_AXIAL_LIMIT),
        section="Room",
    ),
    Quantity(
        key="clearance",
        at_all_points=True,
        name="Clearance",
        symbol="c",
        unit="mm",
        equation="c = distance of shaft axis and obstacle axis − their radii",
        source=SOURCE_DERIVED,
        validity="At a joint whose swing_diameter is known, the radius is that of its yokes there.",
        compute=lambda r: r.clearances.obstacle_clearances.reshape(
            *r.clearances.obstacle_clearances.shape[:-2], -1
        ),
        parts=_pairs,
        sense=">=",
        requirements=(NEEDS_SHAFT_LENGTHS,),
        section="Room",
        json_path="clearances_mm{}",
    ),
    Quantity(
        key="clearance_on_rubber",
        name="Dynamic clearance",
        symbol="cr",
        unit="mm",
        equation="cr = c + a · us + min(0, a · ut) − Σ |a · uk|",
        symbol_meanings={
            "c": "clearance, without deflection of the rubber (clearance)",
            "a": "direction from obstacle to shaft, where they are nearest",
            "us": "how far the torque takes the shaft there on its rubber, from where it hangs",
            "ut": "what thrust of the sliding fit adds, pushed in or drawn out by the suspension",
            "uk": "complex amplitude of orders 2, 4 and 6, and of the unbalance where it counts",
        },
        source=SOURCE_DERIVED,
        validity="At the worst operating point of the state, steadily: passing a resonance quickly "
        "takes less. A distance is convex, so this is never more than what is left. Below 0 the "
        "shaft hits what is in its way. Beyond a stop it is the lesser of what linear rubber and "
        "the stop leave; brackets and flanges that give are in it.",
        compute=_on_rubber,
        validity_margin=_stop_margin,
        lower_bound=_on_rubber,
        worst_beyond=_worst_beyond_stop,
        find_worst_points=lambda r: r.mount_loads.worst_obstacle_clearance,
        has_resonance=True,
        depends_on_mounts=True,
        parts=_hung_pairs,
        sense=">=",
        requirements=(
            NEEDS_SHAFT_LENGTHS,
            NEEDS_TORQUE,
            NEEDS_SPEED_ZERO_ALLOWED,
            NEEDS_MOUNT_STIFFNESS,
            NEEDS_STABLE_LINE,
            NEEDS_THRUST_EQUILIBRIUM,
        ),
        section="Room",
        json_path="clearances_on_rubber_mm{}",
    ),
)
