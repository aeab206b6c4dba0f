"""Where an axle stands in each state of an application, before torque moves it."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from cardan.core.arrays import (
    ArrayLike,
    BoolArray,
    FloatArray,
    stack_on_last_axis,
)
from cardan.core.errors import DesignError, prefix_error_address
from cardan.core.lazy_dataclass import dataclass
from cardan.core.units import Metre, g
from cardan.model.application import VehicleState
from cardan.model.vehicle import Linkage
from cardan.physics.vehicle.axle_loads import (
    DrivelineAxleLoads,
    driven_axle_count,
)
from cardan.physics.vehicle.axle_motion import AxleMotion
from cardan.physics.vehicle.resolved_line import (
    LineWithResolvedReferences,
    LoadStateWithMultiplier,
    axle_height_grouping_key,
)
from cardan.physics.vehicle.state_torques import slip_torques_by_state, values_by_state
from cardan.physics.vehicle.suspension import (
    STATES_AT_SUSPENSION_TRAVEL_LIMIT,
    axle_path,
    axle_windup,
    deflection_in_state,
    load_per_spring,
    natural_frequency,
    squat_travel,
)


@dataclass(frozen=True, kw_only=True, eq=False)
class LineBeforeAxleWindup:
    """A line in its states before any torque moves its axle: what all its points share.

    Attributes
    ----------
    line
        The line.
    loads : (..., S) N
        What it feels of the vehicle's weight.
    axle_motion : shift (..., S, 3) m, pitch (..., S) rad, arm (..., 3) m
        Where the springs have the axle.
    spring_deflection : (..., S) m
        Deflection of its springs; nan where not known.
    winds_up : (S,)
        Where torque winds it up: the suspension places it, and its pitch is not given.
    squats : (S,)
        Where what the tyres pull moves it on its springs: these carry its load.
    slip_torque, slip_torque_coast, slip_torque_reverse : (..., S) N m
        Torques at which the wheels slip as the line drives them, holds them back, and drives
        them in reverse; nan where unknown.
    """

    line: LineWithResolvedReferences
    loads: DrivelineAxleLoads
    axle_motion: AxleMotion
    spring_deflection: FloatArray
    winds_up: BoolArray
    squats: BoolArray
    slip_torque: FloatArray
    slip_torque_coast: FloatArray
    slip_torque_reverse: FloatArray

    @property
    def moved_by_own_torque(self) -> BoolArray:
        """In which states the layout is that of the state's own torque, (S,)."""
        driven, braking = (
            self.line.in_suspension_state(kind) for kind in ("windup", "windup brake")
        )
        return (driven | braking) & (self.winds_up | self.squats)

    def axle_motion_under(
        self, torque: FloatArray, *, coasts: ArrayLike = False, brakes: ArrayLike = False
    ) -> AxleMotion:
        """Return the ride under torques of the line (..., S) N m.

        If an effect is unknown the axle stays.
        """
        on_axle = housing_torque(
            self.line, torque, braked=self.loads.braked, coasts=coasts, brakes=brakes
        )
        travel = np.asarray(self.axle_motion.shift)[..., 2]
        if self.squats.any():
            travel = self._squatting(on_axle, brakes=brakes)
        return self.axle_motion_at(on_axle, travel)

    def axle_motion_at(self, on_axle: FloatArray, travel: FloatArray) -> AxleMotion:
        """Return the ride with torques on the axle's housing (..., S) N m, risen to (..., S) m."""
        ride = self.axle_motion
        if self.squats.any():
            moved = _motion_on_links(self.line, travel, yields=self.winds_up)
            moved = replace(moved, pitch=np.where(self.winds_up, moved.pitch, ride.pitch))
            ride = replace(moved.where(self.squats, ride), joint_offset=ride.joint_offset)
        wound = np.asarray(ride.pitch) + self.line.forward_sign * np.asarray(
            _pitch(self.line, on_axle)
        )
        stays = ~self.winds_up | np.isnan(wound)
        return replace(ride, pitch=np.where(stays, ride.pitch, wound))

    def _squatting(self, on_axle: FloatArray, *, brakes: ArrayLike) -> FloatArray:
        """Return how high the axle is (..., S) m as springs hold what the tyres pull."""
        line, loads = self.line, self.loads
        assert line.suspension is not None
        assert line.tyre is not None  # or it squats nowhere
        pulls = on_axle / line.tyre.static_radius
        driven = np.clip(
            loads.transfer_per_force * pulls * _axles_behind(line) / line.traction_share,
            np.minimum(loads.transfer_traction, loads.transfer_coast),
            np.maximum(loads.transfer_traction, loads.transfer_coast),
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            braked = -pulls / (line.tyre.friction * loads.braked) * loads.transfer_braking
        moved = np.where(brakes, braked, driven) + loads.grade_transfer
        known = self.squats & np.isfinite(moved)
        pulled = np.where(known, on_axle, 0.0)
        rest = np.asarray(self.axle_motion.shift)[..., 2]
        risen = squat_travel(
            line.suspension,
            rest,
            axle_load=np.where(self.squats, loads.axle, line.suspension.unsprung_mass * g),
            drawn=np.where(known, moved, 0.0),
            force=pulled / line.tyre.static_radius,
            torque=pulled,
            ahead=line.forward_sign,
            stands=self.spring_deflection,
        )
        return rest + np.where(known, risen, 0.0)


def axle_travel_by_state(
    line: LineWithResolvedReferences, axle_loads: dict[tuple[str, float], FloatArray]
) -> FloatArray:
    """Rise of the axle from the reference layout in each state, (..., S) m; 0 where held."""
    at_rest = axle_height_grouping_key(line.reference_state, line.reference_load_state)
    placed = [
        free
        and s.kind is not None
        and s.travel is None
        and axle_height_grouping_key(s, loading) != at_rest
        for s, loading, free in zip(
            line.states, line.load_states, line.placed_by_suspension, strict=True
        )
    ]
    start: FloatArray | None = None
    if any(placed) and (springs := line.suspension) is not None:
        with prefix_error_address(f"{_of_suspension(line)}.reference"):
            load = axle_loads[line.reference_load_state.key]
            start = deflection_in_state(springs, springs.reference, axle_load=load)

    def rise(state: VehicleState, loading: LoadStateWithMultiplier) -> ArrayLike:
        if line.suspension is None or start is None:
            msg = (
                f"state {state.name} cannot place the {line.installed.drives} axle of line "
                f"{line.line.name}: give that axle a suspension, or the state a travel"
            )
            raise DesignError(msg)
        assert state.kind is not None  # or nothing places it
        return (
            deflection_in_state(line.suspension, state.kind, axle_load=axle_loads[loading.key])
            - start
        )

    risen: list[ArrayLike] = []
    for k, (s, loading) in enumerate(zip(line.states, line.load_states, strict=True)):
        with prefix_error_address(f"states[{k + 1}]"):
            said = s.travel if line.placed_by_suspension[k] and s.travel is not None else 0.0
            risen.append(rise(s, loading) if placed[k] else said)
    # A tandem's forward axle is behind its main line, the other behind that from axle to axle;
    # where torque flows forward the hindmost is the first.
    sign = 1.0 if line.installed.output_joint is None else -1.0
    rocked = (sign * a if line.installed.drives == "rear" else 0.0 for a in _rocked(line))
    return values_by_state(risen) + values_by_state(rocked)


def _of_suspension(line: LineWithResolvedReferences) -> str:
    """Return where a file has a line's suspension: its own, or the vehicle's."""
    own = f"drivelines.{line.line.name}." if line.installed.suspension else ""
    return f"{own}suspension"


def stands_in_state(
    line: LineWithResolvedReferences, travel: FloatArray, *, reference: FloatArray
) -> FloatArray:
    """Deflection of the axle's springs that has risen to (..., S) m, whatever its load.

    nan where not known in the reference state, by the load there, N.
    """
    suspension = line.suspension
    if suspension is None or (
        suspension.reference not in STATES_AT_SUSPENSION_TRAVEL_LIMIT and np.isnan(reference).any()
    ):
        return np.full_like(travel, np.nan)
    return travel + deflection_in_state(suspension, suspension.reference, axle_load=reference)


def _rocked(line: LineWithResolvedReferences) -> Iterator[Metre]:
    """Yield how far a tandem's first axle rises over the mean of both, state by state."""
    first = line.forward_sign if line.installed.drives == "rear" else 1.0
    for state, free in zip(line.states, line.placed_by_suspension, strict=True):
        yield first * state.articulation if free else 0.0


def static_state_of(
    line: LineWithResolvedReferences,
    travel: FloatArray,
    loads: DrivelineAxleLoads,
    *,
    stands: FloatArray,
) -> LineBeforeAxleWindup:
    """Return the line with its axle where springs and linkage have it, (..., S)."""
    free, states = line.placed_by_suspension, line.states
    turned = values_by_state(s.pitch if f else 0.0 for s, f in zip(states, free, strict=True))
    yields = free & np.array([s.pitch is None for s in states])
    with prefix_error_address(_of_suspension(line)):
        motion = _motion_on_links(line, travel, yields=yields)
    x, z = line.axle.pinion_joint if line.axle else (0.0, 0.0)
    slip, slip_back, slip_reverse = slip_torques_by_state(line, loads)
    moves = line.tyre is not None and line.suspension is not None and line.suspension.squats
    return LineBeforeAxleWindup(
        line=line,
        loads=loads,
        axle_motion=replace(
            motion,
            # the pinion's nose up, whichever way it faces
            pitch=np.where(yields, motion.pitch, turned),
            joint_offset=stack_on_last_axis((x, 0.0, z)),
        ),
        spring_deflection=stands,
        winds_up=yields,
        squats=free & line.between_stops & moves,
        slip_torque=slip,
        slip_torque_coast=slip_back,
        slip_torque_reverse=slip_reverse,
    )


def _motion_on_links(
    line: LineWithResolvedReferences, travel: FloatArray, *, yields: BoolArray
) -> AxleMotion:
    """Return where links have an axle that has risen to (..., S) m, and the axle ahead.

    Each axle of a tandem rides on its own links at its own travel: the same articulation
    that lowers one lifts the other, so they move and pitch by different amounts. The pitch of
    both is the links' where it `yields` (S,); elsewhere a state gives it, and both have that.
    """
    linkage = line.suspension.linkage if line.suspension else Linkage()
    dx, pitch = axle_path(linkage, travel)
    shift = stack_on_last_axis((line.forward_sign * dx, 0.0, travel))
    if line.linkage_ahead is None:
        return AxleMotion(shift=shift, pitch=pitch)
    lead = values_by_state(2 * a for a in _rocked(line))
    dx_ahead, pitch_ahead = axle_path(line.linkage_ahead, travel + lead)
    return AxleMotion(
        shift=shift,
        pitch=pitch,
        lead_shift=stack_on_last_axis((line.forward_sign * (dx_ahead - dx), 0.0, lead)),
        lead_pitch=np.where(yields, pitch_ahead - pitch, 0.0),
    )


def own_axle_motion(standing: LineBeforeAxleWindup, torque: FloatArray) -> AxleMotion:
    """Return the ride of a line in its states, its axle moved by torque in those of wind-up.

    Raises
    ------
    DesignError
        If one of these does not say enough to know it.
    """
    line = standing.line
    driven, winds = line.in_suspension_state("windup"), standing.moved_by_own_torque
    if not winds.any():
        return standing.axle_motion
    on_axle = housing_torque(line, torque, braked=standing.loads.braked, brakes=~driven)
    pitch = _pitch(line, on_axle)
    for k in np.flatnonzero(winds & standing.winds_up):
        if np.isnan(pitch[..., k]).any():
            msg = (
                f"state {line.states[k].name} of line {line.line.name} needs a windup_stiffness, "
                "the axle's ratio and a torque (traction) or brake_torque (brake); or a pitch"
            )
            raise DesignError(msg, about=f"states[{k + 1}]")
    found = standing.axle_motion_under(torque, brakes=~driven)
    return found.where(winds, standing.axle_motion)


def housing_torque(
    line: LineWithResolvedReferences,
    torque: FloatArray,
    *,
    braked: FloatArray,
    coasts: ArrayLike = False,
    brakes: ArrayLike = False,
) -> FloatArray:
    """Torque on the axle's housing, (...) N m, where a line carries some, (...) N m.

    The line's torque splits between the axles it drives. Brakes and engine braking together hold
    no more than the tyres do.
    """
    suspension, axle, tyre = line.suspension, line.axle, line.tyre
    ratio, efficiency = (axle.ratio / _axles_behind(line), axle.efficiency) if axle else (np.nan, 1)
    turned = torque * ratio / efficiency  # by the wheels, which turn the line
    by_brakes = np.asarray(suspension.brake_torque if suspension else 0.0)
    held = np.where(by_brakes > 0, by_brakes + np.nan_to_num(-turned), np.nan)
    grip = tyre.friction * tyre.static_radius * braked if tyre else np.nan
    driven = np.where(coasts, turned, torque * ratio * efficiency)
    return np.where(brakes, -np.fmin(held, grip), driven)


def _axles_behind(line: LineWithResolvedReferences) -> FloatArray:
    """How many axles stand behind a line; how they share their load is no matter of it."""
    if line.vehicle is None:
        return np.ones(())
    axles = driven_axle_count(line.vehicle, drives=line.installed.drives)
    return np.maximum(np.round(line.installed.load_share * axles), 1.0)


def _pitch(line: LineWithResolvedReferences, on_axle: FloatArray) -> FloatArray:
    """Wind-up of the axle under torques on its housing, (...) rad; nan without a stiffness."""
    stiffness = line.suspension.windup_stiffness if line.suspension else None
    if stiffness is None:
        return np.full(on_axle.shape, np.nan)
    return axle_windup(on_axle, stiffness=stiffness)


def suspension_frequency_by_state(
    line: LineWithResolvedReferences, loads: DrivelineAxleLoads
) -> FloatArray:
    """Natural frequency on the springs in each state, (..., S) Hz; nan where there is none.

    Nor has a state of no kind one, which says nothing of how it is loaded.
    """
    if line.suspension is None:
        return np.full(len(line.states), np.nan)
    load = load_per_spring(line.suspension, loads.axle)
    rests = line.between_stops & np.array([s.kind is not None for s in line.states])
    return natural_frequency(line.suspension.spring, np.where(rests & (load > 0), load, np.nan))
