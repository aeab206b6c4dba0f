"""What the vehicle requires of one line in every state, and under other torques.

Every line is seen in its own frame, x along the flow of torque. An axle moves fore and aft,
and is wound up, in the vehicle's frame; for a line that runs forward, to a front axle, both
change sign on the way. Pitch that is given is of the pinion's nose, and so the line's own.

All of it is array code: the states are the last leading axis, the variants of a study,
whose numbers come as (V, 1), the one before it.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from cardan.core.arrays import (
    ArrayLike,
    FloatArray,
    make_components_contiguous,
    stack_on_last_axis,
)
from cardan.core.errors import DesignError
from cardan.core.lazy_dataclass import dataclass
from cardan.model.application import InstalledLine
from cardan.model.layout import Layout
from cardan.physics.vehicle.axle_motion import AxleMotion, layout_after_axle_motion
from cardan.physics.vehicle.resolved_line import (
    LineWithResolvedReferences,
    resolve_line_references,
)
from cardan.physics.vehicle.state_torques import (
    axle_loads_at_travel_limits,
    axle_loads_by_state,
    axle_loads_of_load_states,
    speed_by_state,
    torques_by_state,
)
from cardan.physics.vehicle.static_state import (
    LineBeforeAxleWindup,
    axle_travel_by_state,
    housing_torque,
    own_axle_motion,
    stands_in_state,
    static_state_of,
    suspension_frequency_by_state,
)
from cardan.physics.vehicle.torque import (
    GearTable,
)

__all__ = [
    "LineStateDemand",
    "LineWithResolvedReferences",
    "axle_housing_torque",
    "axle_motion_under_torque",
    "demand_at_axle_motion",
    "demand_with_axle_moved_by_torque",
    "layout_after_axle_motion",
    "line_state_demand",
    "resolve_line_references",
]


@dataclass(frozen=True, kw_only=True, eq=False)
class LineStateDemand:
    """What one line has to bear, (variants ..., states). What cannot be derived is nan.

    For `demand_with_axle_moved_by_torque` the points come before all other axes, so
    that numbers of the line, which come as (V, 1), broadcast with both.

    Attributes
    ----------
    installed
        The line this is about.
    states
        Names of the S states.
    layout : (..., S, n, 3) m
        Where the line runs.
    undisplaced_layout : (..., S, n, 3) m
        The layouts before the suspension moved them: the reference, or a state's own.
    axle_motion : shift (..., S, 3) m, pitch (..., S) rad, arm (..., 3) m
        How the suspension moves the axle; corrections repeat it with other changes.
    torque : (..., S) N m
        For the loads: the smaller of engine and slip torque, or as the application says.
        Negative where the line holds back: in brake wind-up it carries the overrun torque.
    engine_torque, slip_torque : (..., S) N m
        Of the lowest gear; at which the wheels behind this line slip.
    coast_torque : (..., S) N m
        Size of the torque with which engine brake or retarder hold back, at most wheel slip.
    low_gear_torque, wheel_slip_torque : (..., S) N m
        Engine and slip torque by J3311 (its efficiencies; the state's load as capacity).
    speed : (..., S) rad/s
        Top speed of the line, its size.
    sense : (..., S) 1
        Which way that is: -1 where the line turns backwards.
    travel, pitch : (..., S) m, rad
        Rise of the axle and of the pinion's nose from the reference layout.
    spline_travel : (..., S) m
        Length of the last shaft less its length in the reference layout.
    axle_load, driven_load : (..., S) N
        Of the state's load: at rest, on the axle this line's pinion is part of; at the slip
        limit, on all wheels behind the line.
    suspension_frequency : (..., S) Hz
        nan in states that are no equilibrium: `rebound` and `jounce`.
    gears
        Torque and speed of the line gear by gear; None without an engine.
    static_state
        Where it stands before torque winds its axle up.
    """

    installed: InstalledLine
    states: tuple[str, ...]
    layout: Layout
    undisplaced_layout: Layout
    axle_motion: AxleMotion
    torque: FloatArray
    engine_torque: FloatArray
    slip_torque: FloatArray
    coast_torque: FloatArray
    low_gear_torque: FloatArray
    wheel_slip_torque: FloatArray
    speed: FloatArray
    sense: FloatArray
    travel: FloatArray
    pitch: FloatArray
    spline_travel: FloatArray
    axle_load: FloatArray
    driven_load: FloatArray
    suspension_frequency: FloatArray
    gears: GearTable | None
    static_state: LineBeforeAxleWindup

    @property
    def signed_speed(self) -> FloatArray:
        """The speed with its sign, (..., S) rad/s."""
        return self.sense * self.speed

    def corrected_layout(
        self,
        *,
        bearing_shift: ArrayLike = 0.0,
        shim: ArrayLike = 0.0,
        shim_ahead: ArrayLike = 0.0,
    ) -> Layout:
        """Return the layout in every state with bearings moved and the pinion shimmed.

        Parameters
        ----------
        bearing_shift : (..., n-2, 3) m
            Of each centre bearing; of the axes before, the last is that of the states:
            V variants alike in every state are (V, 1, n-2, 3).
        shim : (...) rad
            Turn of the axle on its springs, the pinion's nose rising; (V, 1) for variants.
        shim_ahead : (...) rad
            The same of the axle that the line leaves, if it leaves one.

        Returns
        -------
        Layout
            (..., S, n, 3).
        """
        return _ridden(
            self.undisplaced_layout,
            self.installed,
            self.axle_motion,
            offsets=self.static_state.line.bearing_offsets,
            bearing_shift=bearing_shift,
            shim=shim,
            shim_ahead=shim_ahead,
        )


def line_state_demand(line: LineWithResolvedReferences) -> LineStateDemand:
    """Return what the vehicle requires of a line in each of its states.

    Raises
    ------
    DesignError
        If a state cannot be derived from what is given: the message says what is missing.

    Notes
    -----
    Static loads on level ground place the axle; wind-up turns it where it is then. Where travel
    ends the spring says what the tyres carry, and so what they hold. Source: Souza (2014),
    sections 2.3 and 2.4; the loads where travel ends are derived.
    """
    each = axle_loads_of_load_states(line)
    axle_loads = {key: found.axle for key, found in each.items()}
    travel = axle_travel_by_state(line, axle_loads)
    loads = axle_loads_at_travel_limits(
        line, axle_loads_by_state(each[loading.key] for loading in line.load_states)
    )
    torques = torques_by_state(line, loads)
    stands = stands_in_state(line, travel, reference=axle_loads[line.reference_load_state.key])
    standing = static_state_of(line, travel, loads, stands=stands)
    ride = own_axle_motion(standing, torques["torque"])
    given, installed = _given(line), line.installed
    asked = torques | {
        "speed": speed_by_state(line),
        "sense": np.ones(()),
        "travel": np.where(
            line.placed_by_suspension,
            np.asarray(ride.shift)[..., 2],
            _rise(given) - _rise(installed.layout),
        ),
        "axle_load": loads.axle,
        "driven_load": loads.traction,
        "suspension_frequency": suspension_frequency_by_state(line, loads),
    }
    return _demand(standing, given, ride, asked)


def demand_with_axle_moved_by_torque(
    asked: LineStateDemand,
    *,
    torque: ArrayLike,
    speed: ArrayLike,
    sense: ArrayLike = 1.0,
    coasts: ArrayLike = False,
    brakes: ArrayLike = False,
    named: Callable[[tuple[int, ...]], str] = str,
) -> LineStateDemand:
    """Return what a line has to bear at P points, its axle moved by each point's torque.

    Parameters
    ----------
    asked
        The line in its states.
    torque, speed : (P, ..., S) N m, rad/s
        Of the points; where a torque is nan there is no point, and the layout is the state's.
    sense : (P, ..., S) 1
        -1 where the line turns backwards: the speed is a size.
    coasts, brakes : (P, ..., S)
        Where the wheels turn the line, and where brakes hold the axle as well.
    named
        Names the point of an index (P, ..., S), for errors.

    Returns
    -------
    LineStateDemand
        (P, ..., S). Loads and slip torques are those of the states.

    Raises
    ------
    DesignError
        If a joint reaches a right angle at a point: it has no solution, and to leave the point
        out would approve what was not evaluated.

    Notes
    -----
    The axle pitches by its torque over `windup_stiffness`, in any state in which the
    suspension places it and its pitch is not given; without a stiffness it stays. Where
    springs hold it, it squats by what its tyres pull
    (`cardan.physics.vehicle.suspension.squat_travel`).
    """
    T = np.asarray(torque, dtype=float)
    return demand_at_axle_motion(
        asked,
        axle_motion_under_torque(asked, T, coasts=coasts, brakes=brakes),
        torque=T,
        speed=np.where(np.isnan(T), np.nan, speed),
        sense=sense,
        named=named,
    )


def axle_motion_under_torque(
    asked: LineStateDemand,
    torque: FloatArray,
    *,
    coasts: ArrayLike = False,
    brakes: ArrayLike = False,
) -> AxleMotion:
    """Return how the axle rides under torques of its own (P, ..., S)."""
    found = asked.static_state.axle_motion_under(torque, coasts=coasts, brakes=brakes)
    return found.where(~np.isnan(torque), asked.axle_motion)


def axle_housing_torque(
    asked: LineStateDemand,
    torque: FloatArray,
    *,
    coasts: ArrayLike = False,
    brakes: ArrayLike = False,
) -> FloatArray:
    """Return the torque on the axle's housing, (P, ..., S) N m; nan where not known."""
    of = asked.static_state
    return housing_torque(of.line, torque, braked=of.loads.braked, coasts=coasts, brakes=brakes)


def demand_at_axle_motion(
    asked: LineStateDemand,
    ride: AxleMotion,
    *,
    torque: FloatArray,
    speed: FloatArray,
    sense: ArrayLike = 1.0,
    named: Callable[[tuple[int, ...]], str] = str,
) -> LineStateDemand:
    """Return the demand of a torque and a speed with the axle ridden somewhere, (P, ..., S).

    See `demand_with_axle_moved_by_torque`, which knows where a torque has it.
    """
    same = (
        "engine_torque", "slip_torque", "coast_torque", "low_gear_torque", "wheel_slip_torque",
        "axle_load", "driven_load", "suspension_frequency",
    )  # fmt: skip
    numbers = {name: getattr(asked, name) for name in same}
    numbers |= {"torque": torque, "speed": speed, "sense": np.asarray(sense, dtype=float)}
    risen = np.asarray(ride.shift)[..., 2] - np.asarray(asked.axle_motion.shift)[..., 2]
    numbers["travel"] = asked.travel + risen
    return _demand(asked.static_state, asked.undisplaced_layout, ride, numbers, named=named)


def _demand(
    standing: LineBeforeAxleWindup,
    given: Layout,
    ride: AxleMotion,
    asked: dict[str, FloatArray],
    *,
    named: Callable[[tuple[int, ...]], str] | None = None,
) -> LineStateDemand:
    """Return what a line has to bear where its axle rides: some numbers, and what follows."""
    line, installed = standing.line, standing.line.installed
    layout = _ridden(given, installed, ride, offsets=line.bearing_offsets)
    _bending(line, layout, named)
    asked = asked | {
        "pitch": layout.side[..., -1] - installed.layout.side[..., -1],
        "spline_travel": layout.lengths[..., -1] - installed.layout.lengths[..., -1],
    }
    cases = np.broadcast_shapes(layout.points.shape[:-2], *(v.shape for v in asked.values()))
    return LineStateDemand(
        installed=installed,
        static_state=standing,
        states=tuple(s.name for s in line.states),
        layout=Layout(
            points=np.broadcast_to(layout.points, (*cases, *layout.points.shape[-2:])),
            directions=np.broadcast_to(layout.directions, (*cases, *layout.directions.shape[-2:])),
        ),
        undisplaced_layout=given,
        axle_motion=ride,
        gears=line.gears,
        **{name: np.broadcast_to(value, cases) for name, value in asked.items()},
    )


def _bending(
    line: LineWithResolvedReferences, layout: Layout, named: Callable[[tuple[int, ...]], str] | None
) -> None:
    """Refuse a layout (..., S) in which a joint reaches a right angle and locks."""
    d = layout.directions
    cosines = (d[..., :-1, :] * d[..., 1:, :]).sum(axis=-1)
    for *case, s, k in np.argwhere(~(cosines > 0)).tolist():
        worst = cosines[..., s, k].min() if named is None else cosines[(*case, s, k)]
        angle = np.degrees(np.arccos(np.clip(worst, -1, 1)))
        where = "" if named is None else f", {named((*case, s))}"
        msg = (
            f"joint {k + 1} of line {line.line.name} locks in state "
            f"{line.states[s].name}{where}: its angle must stay below 90 deg, got {angle:.4g} deg"
        )
        raise DesignError(msg, about=f"states[{s + 1}]")


# --------------------------------------------------------------------------- loads


# --------------------------------------------------------------------------- torque and speed


# --------------------------------------------------------------------------- places


def _given(line: LineWithResolvedReferences) -> Layout:
    """Layouts (..., S, n, 3) before anything moves: a state's own, or the reference."""
    layouts = [o or line.installed.layout for o in line.own_layouts]

    def side_by_side(vectors: list[FloatArray]) -> FloatArray:
        each = [v if v.ndim > 2 else v[None] for v in vectors]
        return np.concatenate(np.broadcast_arrays(*each), axis=-3)

    return Layout(
        points=make_components_contiguous(side_by_side([o.points for o in layouts]), of=2),
        directions=make_components_contiguous(side_by_side([o.directions for o in layouts]), of=2),
    )


def _rise(layout: Layout) -> FloatArray:
    """Height of the last joint above the first, (...) m."""
    return layout.points[..., -1, 2] - layout.points[..., 0, 2]


def _ridden(
    given: Layout,
    installed: InstalledLine,
    ride: AxleMotion,
    *,
    offsets: FloatArray | None,
    bearing_shift: ArrayLike = 0.0,
    shim: ArrayLike = 0.0,
    shim_ahead: ArrayLike = 0.0,
) -> Layout:
    """Layout with its axle ridden and, where joint 1 leaves an axle, that one likewise.

    `offsets` (..., S, n-2, 3) m are how far the frame itself has moved the bearings.
    """
    if offsets is not None:
        bearing_shift = np.asarray(bearing_shift) + offsets
    first: AxleMotion | None = None
    if (joint := installed.output_joint) is not None:
        first = ride.of_axle_ahead(stack_on_last_axis((joint[0], 0.0, joint[1])))
        first = replace(first, pitch=np.asarray(first.pitch) + np.asarray(shim_ahead))
    return layout_after_axle_motion(
        given,
        installed.line,
        bearing_shift=bearing_shift,
        last_shift=ride.shift,
        pinion_pitch=np.asarray(ride.pitch) + np.asarray(shim),
        pinion_arm=ride.joint_offset,
        first=first,
    )
