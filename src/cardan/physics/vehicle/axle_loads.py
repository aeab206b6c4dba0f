"""Loads on the axles: at rest, on a slope, under any force at the ground, at the slip limit.

The vehicle stands on two groups of axles, front and rear, the wheelbase apart; a group
hands its load on to its axles in fixed shares. Auxiliary axles on air carry their own load.
"""

from dataclasses import replace

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray, array_library_and_floats, stack_on_last_axis
from cardan.core.errors import DesignError, values_of_first_violating_case
from cardan.core.lazy_dataclass import dataclass
from cardan.core.units import g
from cardan.model.vehicle import DrivenAxles, LoadState, Vehicle


@dataclass(frozen=True, kw_only=True)
class AxleLoads:
    """Loads normal to the ground.

    Attributes
    ----------
    front, rear : (...) N
        Of all front axles, and of the rear group.
    auxiliary : (..., A) N
        Of each auxiliary axle on air.
    """

    front: FloatArray
    rear: FloatArray
    auxiliary: FloatArray

    @property
    def total(self) -> FloatArray:
        """Load of all axles, (...) N."""
        return self.front + self.rear + self.auxiliary.sum(-1)

    def scaled(self, times: float) -> "AxleLoads":
        """Return the loads of a vehicle so many times as heavy."""
        return AxleLoads(
            front=times * self.front, rear=times * self.rear, auxiliary=times * self.auxiliary
        )

    def with_transfer_to_rear(self, load: ArrayLike) -> "AxleLoads":
        """Return the loads with some (...) N moved from the front to the rear.

        An axle cannot be pulled down: no more is moved than there is to move.
        """
        rear = np.clip(self.rear + np.asarray(load, dtype=float), 0.0, self.front + self.rear)
        return replace(self, front=self.front + self.rear - rear, rear=rear)


def static_axle_loads(vehicle: Vehicle, load: LoadState, *, grade: ArrayLike = 0.0) -> AxleLoads:
    """Return the loads of a vehicle in a load state before anything is transferred, N.

    From mass and centre of gravity, Nr L = W cos α lf − Σ A x and Nf = W cos α − Nr − Σ A,
    with A the loads of auxiliary axles and x their distance behind the front axles; or the
    loads given.

    Parameters
    ----------
    vehicle, load
        The vehicle and how it is loaded.
    grade : (...) rad
        Slope α, up positive. The slope's own part, W sin α, acts along the ground: the
        tyres' force holds it, and `axle_loads_at_wheel_slip` moves load for all of that.

    Raises
    ------
    DesignError
        If a group of axles would have to be pulled down.

    Notes
    -----
    Source: Gillespie, Fundamentals of Vehicle Dynamics (1992), ch. 1.
    """
    held = () if load.auxiliary_lifted else vehicle.auxiliary
    auxiliary = stack_on_last_axis(a.load for a in held)
    levered = sum(a.load * a.behind_front for a in held) / vehicle.wheelbase
    front, rear = load.front_load, load.rear_load
    weight = None if load.mass is None else load.mass * g
    if weight is None:
        assert front is not None  # LoadState holds two of the three
        assert rear is not None
        weight = front + rear + auxiliary.sum(-1)
    if rear is None:
        if front is not None:
            rear = weight - auxiliary.sum(-1) - front
        else:
            assert load.cg_behind_front is not None
            rear = weight * load.cg_behind_front / vehicle.wheelbase - levered
    # On a slope what weight there is shrinks by cos α, but not what air holds.
    rear = (rear + levered) * np.cos(grade) - levered
    front = weight * np.cos(grade) - auxiliary.sum(-1) - rear
    nothing = -1e-9 * np.abs(weight)
    if wrong := values_of_first_violating_case(rear >= nothing, rear):
        msg = (
            f"the rear axles would bear {wrong[0]:.0f} N: the centre of gravity, or what "
            "auxiliary axles bear, lifts them"
        )
        raise DesignError(msg)
    if wrong := values_of_first_violating_case(front >= nothing, front):
        msg = (
            f"the front axles would bear {wrong[0]:.0f} N: the centre of gravity, or what "
            "auxiliary axles bear, lifts them"
        )
        raise DesignError(msg)
    return AxleLoads(front=np.asarray(front), rear=np.asarray(rear), auxiliary=auxiliary)


def axle_loads_at_wheel_slip(
    loads: AxleLoads,
    *,
    friction: ArrayLike,
    cg_height: ArrayLike,
    wheelbase: ArrayLike,
    front_share: ArrayLike = 0.0,
    rear_share: ArrayLike = 1.0,
    auxiliary_share: float = 0.0,
) -> AxleLoads:
    r"""Return the loads while the driven wheels are about to slip.

    With F = μ (sf Nf + sr Nr + sa A) the transfer feeds the force that makes it; solved for
    the rear, from loads Nf, Nr without transfer and A of axles on air,

    $$N_r' = \frac{N_r + \mu (s_f (N_f + N_r) + s_a A) h/L}{1 - \mu (s_r - s_f) h/L}$$

    Rear drive gives W lf/(L − μ h), front drive Nf' = W lr/(L + μ h), all-wheel drive
    W (lf + μ h)/L, a bogie driven by a share s of its load W lf/(L − μ s h).

    Parameters
    ----------
    loads : (...) N
        Loads before transfer, `axle_loads`.
    friction : (...) 1
        Of tyre on ground; negative when the driven wheels brake.
    cg_height, wheelbase : (...) m
        Height of the centre of gravity; wheelbase.
    front_share, rear_share : (...) 1
        Share of each group's load on its driven wheels.

    Notes
    -----
    All wheels of the shares slip at once. Where the front would lift it carries nothing and
    the rear all. Rolling resistance and air drag are left out. On a slope start from its loads;
    W sin α needs no term of its own, for F holds it. Source: Gillespie (1992), ch. 2; Wong
    (2008), ch. 3; the form for shares of both groups is derived.
    """
    _, mu, h, L, front, rear = array_library_and_floats(
        friction, cg_height, wheelbase, front_share, rear_share
    )
    lever = mu * h / L
    both = loads.front + loads.rear
    relief = 1 - lever * (rear - front)
    lifted = relief <= 0
    fed = lever * (front * both + auxiliary_share * loads.auxiliary.sum(-1))
    rear = (loads.rear + fed) / np.where(lifted, 1.0, relief)
    return loads.with_transfer_to_rear(np.where(lifted, both, rear) - loads.rear)


@dataclass(frozen=True, kw_only=True)
class DrivelineAxleLoads:
    """Loads that one line feels in a load state.

    Attributes
    ----------
    axle : (...) N
        At rest, on the axle its pinion is part of.
    rest, traction, coast : (...) N
        On all wheels behind the line: at rest, about to slip as the line drives them, and
        as it holds them back.
    braked : (...) N
        On its axle, with every wheel of the vehicle braked to its limit.
    transfer_traction, transfer_coast, transfer_braking : (...) N
        What moves onto its axle as all driven wheels slip, in traction and overrun, and in
        braking; nan if the height of the centre of gravity is not given.
    transfer_per_force : (...) 1
        What a newton that pushes the vehicle ahead moves there.
    grade_transfer : (...) N
        What the grade itself adds, below 0: its cosine takes some off.
    """

    axle: FloatArray
    rest: FloatArray
    traction: FloatArray
    coast: FloatArray
    braked: FloatArray
    transfer_traction: FloatArray
    transfer_coast: FloatArray
    transfer_braking: FloatArray
    transfer_per_force: FloatArray
    grade_transfer: FloatArray


def driveline_axle_loads(
    vehicle: Vehicle,
    load: LoadState,
    *,
    drives: DrivenAxles = "rear",
    load_share: ArrayLike = 1.0,
    push_share: ArrayLike = 1.0,
    friction: ArrayLike = 0.0,
    times: float = 1.0,
) -> DrivelineAxleLoads:
    """Return the loads felt by a line that drives a group of axles, N.

    At rest means on level ground, where the springs find their height; the slip limits are
    those on the vehicle's grade. They are the most that its wheels can carry then: where what
    the others push loads this group all slip at once, as with locked differentials, and
    elsewhere they push no more than the line's share leaves them, as with one on ice.

    Parameters
    ----------
    vehicle, load
        The vehicle and how it is loaded.
    drives, load_share
        The group of axles the line drives, and the share of their load behind it.
    push_share
        Share of what all driven wheels push that its own do.
    friction
        Of tyre on ground.
    times
        How many times as heavy all axles are (overload).

    Raises
    ------
    DesignError
        If the vehicle drives no axle there.
    """
    axles = driven_axle_count(vehicle, drives=drives)
    if not axles:
        msg = f"a {vehicle.drive} drives no {drives} axle for a line to turn"
        raise DesignError(msg, about="drives")
    level, slope = (
        static_axle_loads(vehicle, load, grade=a).scaled(times) for a in (0, vehicle.grade)
    )
    _, mu, part, pushes = array_library_and_floats(friction, load_share, push_share)
    driven_front, driven_rear = float(vehicle.driven_front > 0), vehicle.rear_share

    def driven(loads: AxleLoads) -> FloatArray:
        front, rear = driven_front * loads.front, driven_rear * loads.rear
        return {"rear": rear, "front": front, "all": front + rear}[drives]

    height = 0.0 if load.cg_height is None else load.cg_height

    def limit(
        friction: ArrayLike, front: ArrayLike, rear: ArrayLike, auxiliary: float = 0.0
    ) -> FloatArray:
        loads = axle_loads_at_wheel_slip(
            slope,
            friction=friction,
            cg_height=height,
            wheelbase=vehicle.wheelbase,
            front_share=front,
            rear_share=rear,
            auxiliary_share=auxiliary,
        )
        return driven(loads)

    drive, back = (limit(k * mu, driven_front, driven_rear) for k in (1, -1))
    braked = limit(-mu, 1.0, 1.0, 1.0)
    own = part / pushes
    lone_front, lone_rear = (own * driven_front, 0.0), (0.0, own * driven_rear)
    traction = np.maximum(drive, limit(mu, *lone_front)) if drives == "front" else drive
    coast = np.maximum(back, limit(-mu, *lone_rear)) if drives == "rear" else back
    known = np.nan if load.cg_height is None else 1.0
    drawn = [known * (there - driven(slope)) / axles for there in (drive, back, braked)]
    onto = {"rear": driven_rear, "front": -driven_front, "all": driven_rear - driven_front}[drives]
    return DrivelineAxleLoads(
        axle=driven(level) / axles,
        rest=part * driven(level),
        traction=part * traction,
        coast=part * coast,
        braked=braked / axles,
        transfer_traction=drawn[0],
        transfer_coast=drawn[1],
        transfer_braking=drawn[2],
        transfer_per_force=known * onto * np.asarray(height) / vehicle.wheelbase / axles,
        grade_transfer=(driven(slope) - driven(level)) / axles,
    )


def axle_loads_at_rest_and_slip(
    vehicle: Vehicle, load: LoadState, *, friction: ArrayLike = 0.0, times: float = 1.0
) -> tuple[FloatArray, FloatArray]:
    """Return the load of every axle at rest, and as all driven wheels are about to slip.

    At rest on level ground, at slip on the vehicle's grade; `times` as heavy.

    Returns
    -------
    (..., axles) N twice
        In the order of `load_of_each_axle`.
    """
    level, slope = (
        static_axle_loads(vehicle, load, grade=a).scaled(times) for a in (0, vehicle.grade)
    )
    pulled = axle_loads_at_wheel_slip(
        slope,
        friction=friction,
        cg_height=0.0 if load.cg_height is None else load.cg_height,
        wheelbase=vehicle.wheelbase,
        front_share=float(vehicle.driven_front > 0),
        rear_share=vehicle.rear_share,
    )
    return load_of_each_axle(level, vehicle), load_of_each_axle(pulled, vehicle)


def driven_axle_count(vehicle: Vehicle, *, drives: DrivenAxles) -> int:
    """Return the number of driven axles in a group; each has two driven points."""
    rear, front = vehicle.driven_rear, vehicle.driven_front
    return {"rear": rear, "front": front, "all": front + rear}[drives]


def load_of_each_axle(loads: AxleLoads, vehicle: Vehicle) -> FloatArray:
    """Load of every axle, (..., axles) N: front, driven rear, other rear, auxiliary on air.

    The axles of one kind in a group carry alike; all sum up to the total.
    """
    driven, other = vehicle.driven_rear, vehicle.rear_group - vehicle.driven_rear
    parts = [
        (loads.front, vehicle.front_group),
        (loads.rear * vehicle.rear_share, driven),
        (loads.rear * (1 - vehicle.rear_share), other),
        *((a, 1) for a in np.moveaxis(loads.auxiliary, -1, 0)),
    ]
    return stack_on_last_axis(load / n for load, n in parts for _ in range(n))
