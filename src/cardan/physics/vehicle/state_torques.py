"""Axle loads, torques and speeds of a line in each state of an application."""

from collections.abc import Iterable
from dataclasses import fields, replace
from functools import partial

import numpy as np

from cardan.core.arrays import (
    ArrayLike,
    FloatArray,
    stack_on_last_axis,
)
from cardan.core.errors import prefix_error_address
from cardan.model.vehicle import SuspensionState
from cardan.physics.vehicle.axle_loads import (
    DrivelineAxleLoads,
    axle_loads_at_rest_and_slip,
    driveline_axle_loads,
    driven_axle_count,
    static_axle_loads,
)
from cardan.physics.vehicle.resolved_line import (
    LineWithResolvedReferences,
    LoadStateWithMultiplier,
)
from cardan.physics.vehicle.suspension import (
    STATES_AT_SUSPENSION_TRAVEL_LIMIT,
    tyre_load_at_travel_limit,
)
from cardan.physics.vehicle.torque import (
    j3311_low_gear_torque,
    j3311_wheel_slip_torque,
    max_retarding_torque,
    slip_torque_at_friction,
    smaller_of_engine_and_slip_torque,
)


def individual_axle_loads_by_state(
    line: LineWithResolvedReferences,
) -> tuple[FloatArray, FloatArray]:
    """Return the load of every axle of the vehicle in each state, at rest and at slip.

    Returns
    -------
    (..., S, axles) N twice
        In the order of `cardan.physics.vehicle.axle_loads.load_of_each_axle`; nan where a
        state's load is not given, no axles at all without a vehicle.
    """
    vehicle = line.vehicle
    if vehicle is None:
        none = np.zeros((len(line.states), 0))
        return none, none
    friction = line.tyre.friction if line.tyre else 0.0
    unknown = np.full((1, vehicle.axle_count), np.nan)
    found = [
        (unknown, unknown)
        if loading.load_state is None
        else axle_loads_at_rest_and_slip(
            vehicle, loading.load_state, friction=friction, times=loading.load_factor
        )
        for loading in line.load_states
    ]
    return _side_by_side(rest for rest, _ in found), _side_by_side(slip for _, slip in found)


def _side_by_side(each: Iterable[FloatArray]) -> FloatArray:
    """Return loads of the states one by one, (..., 1, A) or (A,), as (..., S, A).

    A state without an axle that others let down has nan for it.
    """
    rows = [row if row.ndim > 1 else row[None] for row in each]
    most = max(row.shape[-1] for row in rows)
    rows = [
        np.concatenate([row, np.full((*row.shape[:-1], most - row.shape[-1]), np.nan)], axis=-1)
        for row in rows
    ]
    return np.concatenate(np.broadcast_arrays(*rows), axis=-2)


def axle_loads_of_load_states(
    line: LineWithResolvedReferences,
) -> dict[tuple[str, float], DrivelineAxleLoads]:
    """Return the loads that a line feels under each loading of the vehicle, by its key."""
    every = {loading.key: loading for loading in (*line.load_states, line.reference_load_state)}
    return {key: _line_loads(line, loading) for key, loading in every.items()}


def _line_loads(
    line: LineWithResolvedReferences, loading: LoadStateWithMultiplier
) -> DrivelineAxleLoads:
    """Return the loads that a line feels under a loading, (...) N; nan where none is given."""
    if line.vehicle is None or loading.load_state is None:
        return DrivelineAxleLoads(
            **dict.fromkeys((f.name for f in fields(DrivelineAxleLoads)), np.asarray(np.nan))
        )
    with prefix_error_address(f"vehicle.loads.{loading.load_state.name}"):
        static_axle_loads(line.vehicle, loading.load_state)  # refuses what cannot stand
    with prefix_error_address(f"drivelines.{line.line.name}"):
        return driveline_axle_loads(
            line.vehicle,
            loading.load_state,
            drives=line.installed.drives,
            load_share=line.installed.load_share,
            push_share=line.traction_share,
            friction=line.tyre.friction if line.tyre else 0.0,
            times=loading.load_factor,
        )


def axle_loads_by_state(each: Iterable[DrivelineAxleLoads]) -> DrivelineAxleLoads:
    """Return the loads of the states one by one as loads (..., S) of all of them."""
    loads = list(each)
    return DrivelineAxleLoads(
        **{
            f.name: values_by_state(getattr(o, f.name) for o in loads)
            for f in fields(DrivelineAxleLoads)
        }
    )


def axle_loads_at_travel_limits(
    line: LineWithResolvedReferences, loads: DrivelineAxleLoads
) -> DrivelineAxleLoads:
    """Return the loads (..., S), in states where travel ends those that the springs carry there.

    The load that brought the axle there, traction too, is in them. What a bump stop bears besides
    the spring is unknown. A load that a state names is what it has.
    """
    suspension, vehicle = line.suspension, line.vehicle
    if suspension is None or vehicle is None:
        return loads
    kinds: list[SuspensionState | None] = [
        s.kind
        if free
        and s.kind in STATES_AT_SUSPENSION_TRAVEL_LIMIT
        and s.load is None
        and s.travel is None
        else None
        for s, free in zip(line.states, line.placed_by_suspension, strict=True)
    ]
    if not any(kinds):
        return loads
    drives, part = line.installed.drives, line.installed.load_share
    behind = np.asarray(part) * driven_axle_count(vehicle, drives=drives)
    borne = values_by_state(
        np.nan if k is None else tyre_load_at_travel_limit(suspension, k) for k in kinds
    )
    held = np.array([k is not None for k in kinds])
    changed = {name: np.where(held, borne, getattr(loads, name)) for name in ("axle", "braked")}
    changed |= {
        name: np.where(held, behind * borne, getattr(loads, name)) for name in ("traction", "coast")
    }
    return replace(loads, **changed)


def torques_by_state(
    line: LineWithResolvedReferences, loads: DrivelineAxleLoads
) -> dict[str, FloatArray]:
    """Return `LineStateDemand`'s torques by name: as given, or the smaller of engine and slip."""
    engine, held, low_gear = _engine_torques(line)
    slip, slip_back, _ = slip_torques_by_state(line, loads)
    wheel_slip = np.asarray(np.nan)
    axle, tyre = line.axle, line.tyre
    if axle and tyre:
        rolling = tyre.static_radius if tyre.dynamic_radius is None else tyre.dynamic_radius
        wheel_slip = j3311_wheel_slip_torque(loads.rest, radius=rolling, ratio=axle.ratio)
    own = line.max_torque_share * values_by_state(s.torque for s in line.states)
    given = line.max_torque_share * values_by_state(
        first_given(s.torque, line.torque) for s in line.states
    )
    drive = np.where(np.isnan(given), smaller_of_engine_and_slip_torque(engine, slip), given)
    # What holds back is unknown until a brake is given, not even that the tyres slip.
    back = np.where(np.isnan(held), held, smaller_of_engine_and_slip_torque(held, slip_back))
    given_back = line.max_torque_share * np.asarray(first_given(line.coast_torque), dtype=float)
    coast = np.where(np.isnan(given_back), back, given_back)
    # From 0, so that no torque at all is not a negative zero.
    coasting = 0.0 - np.where(np.isnan(own), coast, own)
    return {
        "torque": np.where(line.in_suspension_state("windup brake"), coasting, drive),
        "engine_torque": engine,
        "slip_torque": slip,
        "coast_torque": coast,
        "low_gear_torque": low_gear,
        "wheel_slip_torque": wheel_slip,
    }


def slip_torques_by_state(
    line: LineWithResolvedReferences, loads: DrivelineAxleLoads
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the line's torque at which its wheels slip: in drive, overrun and reverse, (...) N m.

    Driven in reverse the wheels push as they do in overrun, and load moves off the rear axle
    alike; but power runs to them as in drive.
    """
    axle, tyre = line.axle, line.tyre
    if not (axle and tyre):
        unknown = np.asarray(np.nan)
        return unknown, unknown, unknown
    grip = partial(
        slip_torque_at_friction, friction=tyre.friction, radius=tyre.static_radius, ratio=axle.ratio
    )
    return (
        grip(loads.traction, efficiency=axle.efficiency),
        grip(loads.coast, efficiency=1 / axle.efficiency),
        grip(loads.coast, efficiency=axle.efficiency),
    )


def _engine_torques(line: LineWithResolvedReferences) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the line's engine torque, brake torque, and low gear torque by J3311, (...) N m."""
    engine, gearbox = line.engine, line.gearbox
    if engine is None or line.gears is None:
        held = np.asarray(first_given(gearbox.retarder_torque), dtype=float)
        return np.asarray(np.nan), line.max_torque_share * held, np.asarray(np.nan)
    low = np.asarray(gearbox.transfer_ratio)
    by_j3311 = j3311_low_gear_torque(
        engine.peak_torque,
        ratio=stack_on_last_axis(gearbox.ratios).max(-1),
        efficiency=np.where(np.asarray(gearbox.converter_ratio) == 1, 0.85, 0.80),
        stall_ratio=gearbox.converter_ratio,
        transfer_ratio=low,
        transfer_efficiency=np.where(low == 1, 1.0, 0.95),
    )
    strongest, _ = line.gears.max_torque_and_speed
    return (
        strongest,
        line.max_torque_share * max_retarding_torque(engine, gearbox),
        line.max_torque_share * by_j3311,
    )


def speed_stated_by_application(line: LineWithResolvedReferences) -> FloatArray:
    """Speed of the line that state or application give, (..., S) rad/s; nan where neither does.

    A top speed is none of the gear that winds the axle up.
    """
    wound = line.in_suspension_state("windup") & (line.gears is not None)
    return np.asarray(line.installed.speed_ratio, dtype=float) * values_by_state(
        first_given(s.speed, None if low else line.speed)
        for s, low in zip(line.states, wound, strict=True)
    )


def speed_by_state(line: LineWithResolvedReferences) -> FloatArray:
    """Top speed of the line in each state, (..., S) rad/s.

    The torque that winds an axle up is that of the lowest gear, and so is the speed.
    """
    given = speed_stated_by_application(line)
    if line.gears is None:
        return given
    _, low = line.gears.max_torque_and_speed
    top = np.where(line.in_suspension_state("windup"), low, line.gears.top_speed)
    return np.where(np.isnan(given), top, given)


def values_by_state(values: Iterable[ArrayLike | None]) -> FloatArray:
    """Return numbers of the states one by one, (..., 1) each, as (..., S); None is nan."""
    columns = [np.atleast_1d(np.asarray(v, dtype=float)) for v in values]
    return np.concatenate(np.broadcast_arrays(*columns), axis=-1)


def first_given(*values: ArrayLike | None) -> ArrayLike | None:
    """Return the first value that is given."""
    return next((v for v in values if v is not None), None)
