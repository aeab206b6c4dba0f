"""A line anywhere between rebound and jounce, under any torque: what a slider moves it through.

The same demand as that of the states, asked at heights of the axle and torques that no state
names. The axle winds up by the torque where the suspension says how stiff it is.
"""

from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from cardan.base.arrays import ArrayLike, BoolArray, FloatArray
from cardan.base.errors import DesignError
from cardan.base.part import Point
from cardan.demand.points import Direction
from cardan.demand.states import Demand, demand, demand_under, resolve, ride_under
from cardan.model.application import Application, Installed, State
from cardan.model.vehicle import Suspension, SuspensionState
from cardan.quantity.response import Response, respond

ENDS: tuple[SuspensionState, ...] = ("full rebound", "jounce")


@dataclass(frozen=True, slots=True, kw_only=True)
class Reach:
    """How far a line's axle goes, and what torques it may carry; (0, 0) where nobody says.

    Attributes
    ----------
    travel : m
        Lowest and highest rise of the axle from the reference state.
    torque : N m
        Most in reverse or coast, below 0, and in drive, of its states and operating points;
        (0, 0) where no torque winds the axle up.
    brakes
        Whether it is known what brakes make of the axle.
    """

    travel: tuple[float, float]
    torque: tuple[float, float]
    brakes: bool = False


def reach(response: Response) -> Reach:
    """Return how far a line's axle goes, states and stops of the suspension together."""
    application, installed = response.application, response.demand.installed
    line = response.demand.standing.line
    if line.suspension is None:
        return Reach(travel=(0.0, 0.0), torque=(0.0, 0.0))
    travels = [float(t) for t in response.demand.travel]
    for kind in ENDS:
        with suppress(DesignError):  # a suspension without one of its ends
            at = replace(application, states=(State(name=kind, kind=kind),))
            travels.append(float(demand(resolve(at, installed)).travel[0]))
    asked = response.demand
    may = [np.zeros(1)]
    if winds(response):
        may += [np.ravel(asked.torque), -np.ravel(asked.coast_torque)]
        if response.spread is not None:
            may.append(np.ravel(response.spread.spots.torque))
    every = np.concatenate(may)
    torque = float(np.nanmin(every)), float(np.nanmax(every))
    still = np.zeros((1, len(asked.states)))
    held, free = (ride_under(asked, still, coasts=k, brakes=k).pitch for k in (True, False))
    braked = winds(response) and bool(np.any(held != free))
    return Reach(travel=(min(travels), max(travels)), torque=torque, brakes=braked)


def winds(response: Response) -> bool:
    """Return whether torque winds the axle of a line up."""
    line = response.demand.standing.line
    stiff = line.suspension is not None and line.suspension.windup_stiffness is not None
    return stiff and line.axle is not None


def under(response: Response, point: Point) -> Response:
    """Return a line in its states as an operating point moves its axle, (S,)."""
    asked = response.demand
    wound = demand_under(
        asked, torque=np.full((1, len(asked.states)), point.torque), speed=point.speed,
        coasts=point.direction == "coast", brakes=point.direction == "brake",
    )  # fmt: skip
    layout, there = wound.layout[0], replace(asked, travel=wound.travel[0], pitch=wound.pitch[0])
    return respond(response.application, there, lay=lambda _: layout)


def ride(
    application: Application,
    installed: Installed,
    *,
    travel: ArrayLike,
    torque: ArrayLike,
    brakes: bool = False,
) -> Response:
    """Return the response of a line with its axle at heights, under torques.

    Parameters
    ----------
    travel : (N,) m
        Rise of the axle from the reference state, as it rides: no squat comes on top.
    torque : (N,) N m
        Of the line; negative holds back, and more than coasting can is driven in reverse.
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
        states=tuple(State(name=f"{k}", travel=float(h)) for k, h in enumerate(heights, 1)),
    )
    asked = demand(resolve(at, replace(installed, suspension=_held(installed.suspension))))
    wound: FloatArray = (np.minimum(turned, 0.0) if brakes else turned)[None]
    coasts = brakes | ((wound < 0) & ~_reverses(wound, asked))
    under = demand_under(
        asked, torque=wound, speed=asked.speed, coasts=coasts, brakes=brakes
    )  # points of its own come first: here there is one
    layout = under.layout[0]
    return respond(at, asked, lay=lambda _: layout)


def _held(suspension: Suspension | None) -> Suspension | None:
    """Return a suspension that holds its axle as high as somebody puts it."""
    return suspension and replace(suspension, squats=False)


def way(response: Response, torque: float) -> Direction:
    """Return how a line is turned that a torque stands for in `ride`, without brakes."""
    if torque >= 0:
        return "drive"
    return "reverse" if np.any(_reverses(np.asarray(torque), response.demand)) else "coast"


def _reverses(torque: FloatArray, asked: Demand) -> BoolArray:
    """Return where a torque is more than coasting can hold; nowhere where nobody knows."""
    return torque < -asked.coast_torque * (1 + 1e-6)
