"""Torque and speed of a line: what the engine gives in each gear, what the tyres can hold."""

from dataclasses import dataclass
from math import nan

import numpy as np

from cardan.base.arrays import ArrayLike, FloatArray
from cardan.model.vehicle import Engine, Gearbox

DIRECT = Gearbox(ratios=(1.0,))
"""No gearbox: the motor turns the line itself."""


@dataclass(frozen=True, kw_only=True)
class Gears:
    """What a line gets in every gear, lowest first; a transfer case's low range follows.

    Attributes
    ----------
    names
        "1", "2", ... and "low 1", "low 2", ... where there is a low range.
    ratios : (G,) 1
        Engine speed over line speed.
    speed : (G, E) rad/s
        Line speed at each point of the engine's curve, a converter locked.
    torque : (G, E) N m
        Line torque at full load, a converter stalled.
    """

    names: tuple[str, ...]
    ratios: FloatArray
    speed: FloatArray
    torque: FloatArray

    @property
    def peak(self) -> FloatArray:
        """Largest torque in each gear, (G,) N m."""
        return self.torque.max(axis=-1)

    @property
    def speed_range(self) -> FloatArray:
        """Lowest and highest line speed in each gear, (G, 2) rad/s."""
        return np.stack([self.speed.min(axis=-1), self.speed.max(axis=-1)], axis=-1)


def gears(
    engine: Engine,
    gearbox: Gearbox = DIRECT,
    *,
    torque_ratio: float = 1.0,
    speed_ratio: float = 1.0,
) -> Gears:
    """Torque and speed of a line in every gear and at every point of the engine's curve.

    T = Tm i η, with the transfer case's and the converter's ratio where there is one. The
    curve is straight between its points, so its largest torque is at one of them.

    Parameters
    ----------
    engine, gearbox
        The engine, and what stands between it and the line.
    torque_ratio, speed_ratio
        Torque and speed of the line over those of the gearbox output.

    Notes
    -----
    A converter multiplies torque fully only at stall, where the line stands; taken in every
    gear and at every speed it is an upper bound. The low range counts for torque; the
    gearbox's own speeds stand in the high range. Source: Souza (2014), eq. 1.
    """
    ranges = {"": 1.0} if gearbox.transfer_ratio == 1 else {"": 1.0, "low ": gearbox.transfer_ratio}
    ratios = np.multiply.outer(list(ranges.values()), gearbox.ratios).ravel()
    gain = gearbox.efficiency * gearbox.converter_ratio * torque_ratio
    return Gears(
        names=tuple(f"{low}{k + 1}" for low in ranges for k in range(len(gearbox.ratios))),
        ratios=ratios / speed_ratio,
        speed=speed_ratio * np.asarray(engine.speed) / ratios[:, None],
        torque=gain * ratios[:, None] * np.asarray(engine.torque),
    )


def brake_torque(engine: Engine, gearbox: Gearbox = DIRECT) -> float:
    """Torque at the gearbox output that engine brake or retarder hold, in the lowest gear, N m.

    T = Tb i / η: what gears lose helps to brake; nan where nobody says what brakes. Derived
    from Souza (2014), eq. 1.
    """
    if engine.brake_torque is None:
        return nan
    lowest = max(gearbox.ratios) * max(gearbox.transfer_ratio, 1.0)
    return engine.brake_torque * lowest / gearbox.efficiency


def slip_torque(
    load: ArrayLike, *, friction: float, radius: float, ratio: float, efficiency: float = 1.0
) -> FloatArray:
    """Torque of a line at which its wheels slip, (...) N m.

    T = μ N r / (i η): every wheel holds μ times its load, and N is the sum behind the line.

    Parameters
    ----------
    load : (...) N
        Load N on all wheels behind the line.
    friction, ratio, efficiency
        Of tyre on ground; of the axle, pinion over wheel speed; of the axle. When the
        wheels drive the line (coast), power runs the other way: give 1/η.
    radius : m
        Static loaded radius.

    Notes
    -----
    Source: Souza (2014), eq. 2 and 3, with the load of all driven points.

    Examples
    --------
    >>> slip_torque(100e3, friction=0.8, radius=0.5, ratio=4.0, efficiency=0.95).round(1)
    np.float64(10526.3)
    """
    return friction * np.asarray(load, dtype=float) * radius / (ratio * efficiency)


def governing_torque(engine: ArrayLike, slip: ArrayLike) -> FloatArray:
    """Return the smaller of engine and slip torque (...); nan stands for unknown.

    Loads are computed with it; a joint's size is held against the engine torque. Source:
    Souza (2014), section 2.4.
    """
    return np.fmin(np.asarray(engine, dtype=float), np.asarray(slip, dtype=float))


def low_gear_torque(
    torque: ArrayLike,
    *,
    ratio: float,
    efficiency: float = 0.85,
    stall_ratio: float = 1.0,
    transfer_ratio: float = 1.0,
    transfer_efficiency: float = 1.0,
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
    >>> low_gear_torque(1567.5, ratio=10.96).round()
    np.float64(14603.0)
    """
    gain = ratio * efficiency * stall_ratio * transfer_ratio * transfer_efficiency
    return np.asarray(torque, dtype=float) * gain


def wheel_slip_torque(load: ArrayLike, *, radius: float, ratio: float) -> FloatArray:
    """J3311's wheel slip torque WST of axle capacity (...) N, in N m.

    WST = 0.71 W RR / (11.4 AR) lb-ft with RR in inches: 11.4 is 12 in/ft times 0.95, so it
    is `slip_torque` at friction 0.71 and axle efficiency 0.95.

    Parameters
    ----------
    load : (...) N
        Capacity W of the axles behind the line.
    radius : m
        Rolling radius RR of the tyre.
    ratio
        Axle ratio AR.

    Notes
    -----
    Source: Dana Spicer J3311-1, Driveshaft torque.
    """
    return slip_torque(load, friction=0.71, radius=radius, ratio=ratio, efficiency=0.95)
