"""A line anywhere between rebound and bump, under any torque: what a slider moves it through.

The same demand as that of the states, evaluated at heights of the axle and torques that no state
names. The axle winds up by the torque where the suspension says how stiff it is.
"""

from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.core.arrays import ArrayLike, BoolArray, FloatArray
from cardan.core.errors import DesignError
from cardan.core.labels import OperatingPoint
from cardan.model.application import Application, InstalledLine, VehicleState
from cardan.model.vehicle import Suspension, SuspensionState
from cardan.physics.vehicle.operating_points import DriveMode
from cardan.physics.vehicle.state_demand import (
    LineStateDemand,
    axle_motion_under_torque,
    demand_with_axle_moved_by_torque,
    line_state_demand,
    resolve_line_references,
)

SPRING_TRAVEL_LIMIT_STATES: tuple[SuspensionState, ...] = ("full rebound", "jounce")


@dataclass(frozen=True, slots=True, kw_only=True)
class TravelRange:
    """How far a line's axle goes, and what torques it may carry; (0, 0) if not given.

    Attributes
    ----------
    travel : m
        Lowest and highest rise of the axle from the reference state.
    torque : N m
        Most in reverse or overrun, below 0, and in drive, of its states and operating points;
        (0, 0) where no torque winds the axle up.
    brake_windup_known
        Whether it is known what brakes make of the axle.
    """

    travel: tuple[float, float]
    torque: tuple[float, float]
    brake_windup_known: bool = False


def travel_range(response: LineResponse) -> TravelRange:
    """Return how far a line's axle goes, states and stops of the suspension together."""
    application, installed = response.application, response.demand.installed
    line = response.demand.static_state.line
    if line.suspension is None:
        return TravelRange(travel=(0.0, 0.0), torque=(0.0, 0.0))
    travels = [float(t) for t in response.demand.travel]
    for kind in SPRING_TRAVEL_LIMIT_STATES:
        with suppress(DesignError):  # a suspension without one of its ends
            at = replace(application, states=(VehicleState(name=kind, kind=kind),))
            travels.append(
                float(line_state_demand(resolve_line_references(at, installed)).travel[0])
            )
    asked = response.demand
    may = [np.zeros(1)]
    if does_torque_wind_up_axle(response):
        may += [np.ravel(asked.torque), -np.ravel(asked.coast_torque)]
        if response.operating_envelope is not None:
            may.append(np.ravel(response.operating_envelope.points.torque))
    every = np.concatenate(may)
    torque = float(np.nanmin(every)), float(np.nanmax(every))
    still = np.zeros((1, len(asked.states)))
    held, free = (
        axle_motion_under_torque(asked, still, coasts=k, brakes=k).pitch for k in (True, False)
    )
    braked = does_torque_wind_up_axle(response) and bool(np.any(held != free))
    return TravelRange(
        travel=(min(travels), max(travels)), torque=torque, brake_windup_known=braked
    )


def does_torque_wind_up_axle(response: LineResponse) -> bool:
    """Return whether torque winds the axle of a line up."""
    line = response.demand.static_state.line
    stiff = line.suspension is not None and line.suspension.windup_stiffness is not None
    return stiff and line.axle is not None


def line_at_operating_point(response: LineResponse, point: OperatingPoint) -> LineResponse:
    """Return a line in its states as an operating point moves its axle, (S,)."""
    asked = response.demand
    wound = demand_with_axle_moved_by_torque(
        asked, torque=np.full((1, len(asked.states)), point.torque), speed=point.speed,
        coasts=point.direction == "coast", brakes=point.direction == "brake",
    )  # fmt: skip
    layout, there = wound.layout[0], replace(asked, travel=wound.travel[0], pitch=wound.pitch[0])
    return compute_line_response(response.application, there, lay=lambda _: layout)


def line_at_axle_position(
    application: Application,
    installed: InstalledLine,
    *,
    travel: ArrayLike,
    torque: ArrayLike,
    brakes: bool = False,
) -> LineResponse:
    """Return the response of a line with its axle at heights, under torques.

    Parameters
    ----------
    travel : (N,) m
        Rise of the axle from the reference state, as it rides: no squat comes on top.
    torque : (N,) N m
        Of the line; negative holds back, and more than overrun can is driven in reverse.
    brakes
        Whether brakes hold the axle as well, to what its tyres take: then no torque drives it.

    Returns
    -------
    Response
        (N,) on the axis of the states.

    Raises
    ------
    DesignError
        If the line cannot be there: the linkage does not follow, a joint locks.
    """
    heights, turned = np.broadcast_arrays(
        np.atleast_1d(np.asarray(travel, dtype=float)), np.asarray(torque, dtype=float)
    )
    at = replace(
        application,
        suspension=_held(application.suspension),
        states=tuple(VehicleState(name=f"{k}", travel=float(h)) for k, h in enumerate(heights, 1)),
    )
    asked = line_state_demand(
        resolve_line_references(at, replace(installed, suspension=_held(installed.suspension)))
    )
    wound: FloatArray = (np.minimum(turned, 0.0) if brakes else turned)[None]
    coasts = brakes | ((wound < 0) & ~_reverses(wound, asked))
    under = demand_with_axle_moved_by_torque(
        asked, torque=wound, speed=asked.speed, coasts=coasts, brakes=brakes
    )  # points of its own come first: here there is one
    layout = under.layout[0]
    return compute_line_response(at, asked, lay=lambda _: layout)


def _held(suspension: Suspension | None) -> Suspension | None:
    """Return a suspension that holds its axle as high as it is put."""
    return suspension and replace(suspension, squats=False)


def drive_mode_of_torque(response: LineResponse, torque: float) -> DriveMode:
    """Return how a line is turned by a torque in `line_at_axle_position`, without brakes."""
    if torque >= 0:
        return "drive"
    return "reverse" if np.any(_reverses(np.asarray(torque), response.demand)) else "coast"


def _reverses(torque: FloatArray, asked: LineStateDemand) -> BoolArray:
    """Return where a torque is more than overrun can hold; nowhere if unknown."""
    return torque < -asked.coast_torque * (1 + 1e-6)
