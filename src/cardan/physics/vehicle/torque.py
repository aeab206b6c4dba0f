"""Torque and speed of a line: what the engine gives in each gear, what the tyres can hold."""

from dataclasses import replace

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray, array_library_and_floats, stack_on_last_axis
from cardan.core.lazy_dataclass import dataclass
from cardan.model.vehicle import Engine, Gearbox

DIRECT_DRIVE = Gearbox(ratios=(1.0,))
"""No gearbox: the motor turns the line itself."""


@dataclass(frozen=True, kw_only=True)
class GearTable:
    """What a line gets in every gear, lowest first; a transfer case's low range follows.

    Leading axes are those of the numbers it follows from.

    Attributes
    ----------
    names
        "1", "2", ... and "low 1", "low 2", ... where there is a low range; "R" in reverse.
    ratios : (..., G) 1
        Engine speed over line speed.
    speed : (..., G, E) rad/s
        Line speed at each point of the engine's curve, a converter locked.
    torque : (..., G, E) N m
        Line torque at full load, a converter stalled.
    """

    names: tuple[str, ...]
    ratios: FloatArray
    speed: FloatArray
    torque: FloatArray

    @property
    def peak_torque(self) -> FloatArray:
        """Largest torque in each gear, (..., G) N m."""
        return self.torque.max(axis=-1)

    @property
    def top_speed(self) -> FloatArray:
        """Highest line speed in any gear, (...) rad/s."""
        return self.speed.max((-2, -1))

    @property
    def max_torque_and_speed(self) -> tuple[FloatArray, FloatArray]:
        """Largest torque in any gear, and the highest speed in that gear, (...) N m, rad/s."""
        gear = self.peak_torque.argmax(-1)[..., None]
        fastest = np.take_along_axis(self.speed.max(-1), gear, axis=-1)
        return self.peak_torque.max(-1), fastest[..., 0]

    @property
    def speed_range(self) -> FloatArray:
        """Lowest and highest line speed in each gear, (..., G, 2) rad/s."""
        return np.stack([self.speed.min(axis=-1), self.speed.max(axis=-1)], axis=-1)


def gear_table(
    engine: Engine,
    gearbox: Gearbox = DIRECT_DRIVE,
    *,
    torque_ratio: ArrayLike = 1.0,
    speed_ratio: ArrayLike = 1.0,
) -> GearTable:
    """Torque and speed of a line in every gear and at every point of the engine's curve.

    T = Tm i η, with the transfer case's and the converter's ratio where there is one. The
    curve is straight between its points, so its largest torque is at one of them.

    Parameters
    ----------
    engine, gearbox
        The engine, and what stands between it and the line.
    torque_ratio, speed_ratio : (...) 1
        Torque and speed of the line over those of the gearbox output.

    Notes
    -----
    A converter multiplies torque fully only at stall, where the line stands; taken in every
    gear and at every speed it is an upper bound. The low range counts for torque; the
    gearbox's own speeds stand in the high range. Source: Souza (2014), eq. 1.
    """
    ranges = _ranges(gearbox)
    ratios = stack_on_last_axis(low * ratio for low in ranges.values() for ratio in gearbox.ratios)
    _, pace, share, eta, stall = array_library_and_floats(
        speed_ratio, torque_ratio, gearbox.efficiency, gearbox.converter_ratio
    )
    pace, gain = pace[..., None], (eta * stall * share)[..., None, None]
    turns, pulls = map(stack_on_last_axis, engine.full_load)
    speed, torque = np.broadcast_arrays(
        pace[..., None] * turns[..., None, :] / ratios[..., None],
        gain * ratios[..., None] * pulls[..., None, :],
    )
    return GearTable(
        names=tuple(f"{low}{k + 1}" for low in ranges for k in range(len(gearbox.ratios))),
        ratios=ratios / pace,
        speed=speed,
        torque=torque,
    )


def _ranges(gearbox: Gearbox) -> dict[str, FloatArray]:
    """Return what the ranges of a transfer case multiply ratios by, high range first."""
    high, low = np.asarray(1.0), np.asarray(gearbox.transfer_ratio, dtype=float)
    return {"": high} if np.all(low == 1) else {"": high, "low ": low}


def reverse_gear_table(
    engine: Engine,
    gearbox: Gearbox,
    *,
    torque_ratio: ArrayLike = 1.0,
    speed_ratio: ArrayLike = 1.0,
) -> GearTable | None:
    """Torque and speed of a line in reverse, by size; None if its ratio is not given.

    `gears` of the reverse ratio alone, in every range of the transfer case.
    """
    if gearbox.reverse_ratio is None:
        return None
    alone = replace(gearbox, ratios=(gearbox.reverse_ratio,))
    found = gear_table(engine, alone, torque_ratio=torque_ratio, speed_ratio=speed_ratio)
    return replace(found, names=tuple(f"{low}R" for low in _ranges(gearbox)))


def largest_torque_from_standstill(
    speed: FloatArray, torque: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Largest torque that a gear can give at line speeds from standstill on, as a curve.

    A slipping clutch or a stalled converter lets the engine turn faster than the line, so at
    a line speed n it is the largest torque at engine speeds of n and above: constant from
    standstill to the last peak, then along the full-load curve.

    Parameters
    ----------
    speed, torque : (..., E) rad/s, N m
        Full load of a gear, straight between points.

    Returns
    -------
    (..., 2 E) rad/s, (..., 2 E) N m
        Its corners, exactly: speeds from 0, which may repeat; torques that never rise.
    """
    rest = np.maximum.accumulate(torque[..., ::-1], axis=-1)[..., ::-1]
    after, fall = rest[..., 1:], torque[..., :-1] - torque[..., 1:]
    falls = torque[..., :-1] > after
    # Where the curve falls to a later peak's torque, which holds from there on.
    share = np.where(falls, (torque[..., :-1] - after) / np.where(falls, fall, 1.0), 1.0)
    bends = speed[..., :-1] + share * np.diff(speed, axis=-1)
    corners = np.stack([np.concatenate([np.zeros_like(speed[..., :1]), bends], -1), speed], -1)
    held = np.stack([np.concatenate([rest[..., :1], after], -1), rest], -1)
    many = (*speed.shape[:-1], -1)
    return corners.reshape(many), held.reshape(many)


def retarding_torques(engine: Engine, gearbox: Gearbox = DIRECT_DRIVE) -> FloatArray:
    """Torque at the gearbox output that engine brake and retarder hold in each gear.

    (..., G) N m, gears as `gears` has them.

    T = Tb i / η + Tr: what gears lose helps to brake; a low range behind the retarder
    multiplies that too. What is unknown holds nothing; nan if both are unknown.
    Derived from Souza (2014), eq. 1.
    """
    brake, retarder = engine.brake_torque, gearbox.retarder_torque
    none = np.nan if brake is None and retarder is None else 0.0
    brake, retarder = (none if held is None else held for held in (brake, retarder))
    return stack_on_last_axis(
        brake * (ratio * low) / gearbox.efficiency + retarder * low
        for low in _ranges(gearbox).values()
        for ratio in gearbox.ratios
    )


def max_retarding_torque(engine: Engine, gearbox: Gearbox = DIRECT_DRIVE) -> FloatArray:
    """Largest torque at the gearbox output that engine brake and retarder hold, (...) N m.

    That of the lowest gear; nan if what holds is unknown.
    """
    return retarding_torques(engine, gearbox).max(axis=-1)


def slip_torque_at_friction(
    load: ArrayLike,
    *,
    friction: ArrayLike,
    radius: ArrayLike,
    ratio: ArrayLike,
    efficiency: ArrayLike = 1.0,
) -> FloatArray:
    """Torque of a line at which its wheels slip, (...) N m.

    T = μ N r / (i η): every wheel holds μ times its load, and N is the sum behind the line.

    Parameters
    ----------
    load : (...) N
        Load N on all wheels behind the line.
    friction, ratio, efficiency : (...) 1
        Of tyre on ground; of the axle, pinion over wheel speed; of the axle. When the
        wheels drive the line (overrun), power runs the other way: give 1/η.
    radius : (...) m
        Static loaded radius.

    Notes
    -----
    Source: Souza (2014), eq. 2 and 3, with the load of all driven points.

    Examples
    --------
    >>> held = slip_torque_at_friction(
    ...     100e3, friction=0.8, radius=0.5, ratio=4.0, efficiency=0.95
    ... )
    >>> held.round(1)
    np.float64(10526.3)
    """
    _, N, mu, r, i, eta = array_library_and_floats(load, friction, radius, ratio, efficiency)
    return mu * N * r / (i * eta)


def smaller_of_engine_and_slip_torque(engine: ArrayLike, slip: ArrayLike) -> FloatArray:
    """Return the smaller of engine and slip torque (...); nan stands for unknown.

    Loads are computed with it; a joint's size is held against the engine torque. Source:
    Souza (2014), section 2.4.
    """
    return np.fmin(np.asarray(engine, dtype=float), np.asarray(slip, dtype=float))


def j3311_low_gear_torque(
    torque: ArrayLike,
    *,
    ratio: ArrayLike,
    efficiency: ArrayLike = 0.85,
    stall_ratio: ArrayLike = 1.0,
    transfer_ratio: ArrayLike = 1.0,
    transfer_efficiency: ArrayLike = 1.0,
) -> FloatArray:
    """J3311's low gear torque LGT of net engine torque (...), in its unit.

    LGT = T TLGR TE SR TCR C. T is the net engine torque, or 95 % of the gross one.

    Parameters
    ----------
    torque : (...)
        Net engine torque T, N m or lb-ft.
    ratio, efficiency
        Lowest forward gear TLGR; TE, 0.85 of a manual and 0.80 of an automatic gearbox.
    stall_ratio, transfer_ratio, transfer_efficiency
        SR of a converter; TCR and C (0.95) of a transfer case, where there is one.

    Notes
    -----
    Source: Dana Spicer J3311-1, Driveshaft torque.

    Examples
    --------
    >>> j3311_low_gear_torque(1567.5, ratio=10.96).round()
    np.float64(14603.0)
    """
    _, T, i, eta, stall, low, C = array_library_and_floats(
        torque, ratio, efficiency, stall_ratio, transfer_ratio, transfer_efficiency
    )
    return T * (i * eta * stall * low * C)


def j3311_wheel_slip_torque(load: ArrayLike, *, radius: ArrayLike, ratio: ArrayLike) -> FloatArray:
    """J3311's wheel slip torque WST of axle capacity (...) N, in N m.

    WST = 0.71 W RR / (11.4 AR) lb-ft with RR in inches: 11.4 is 12 in/ft times 0.95, so it
    is `slip_torque_at_friction` at friction 0.71 and axle efficiency 0.95.

    Parameters
    ----------
    load : (...) N
        Capacity W of the axles behind the line.
    radius : (...) m
        Rolling radius RR of the tyre.
    ratio : (...) 1
        Axle ratio AR.

    Notes
    -----
    Source: Dana Spicer J3311-1, Driveshaft torque.
    """
    return slip_torque_at_friction(load, friction=0.71, radius=radius, ratio=ratio, efficiency=0.95)
