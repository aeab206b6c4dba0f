"""A mass on rubber with a stop, as METHOD section 20 has it, and what its stop's crests carry."""

import numpy as np

from cardan.physics.loads.rubber_stop_response import (
    STOP_ORDERS,
    StoppedLine,
    StoppedMotion,
    components,
    forces_at_stop,
)

STIFFNESS, LOSS, STOP = 200e3, 0.1, 15e-3
RESONANCE = 10.4
MASS = STIFFNESS / (2 * np.pi * RESONANCE) ** 2
SWING, STEADY = 398.0, 2020.0
"""A mass of 47 kg, order 2 of 398 N on a mean of 2020 N: linear rubber carries 6.0 kN at most."""

FREQUENCIES = np.linspace(7.0, 16.0, 91)


def one_mass(ratio: float, *, steady: float = STEADY) -> StoppedLine:
    """Return one mass on rubber at `FREQUENCIES` of order 2, its other way four times as stiff.

    Its losses are those of dampers, as integration in time has them.
    """
    W = 2 * np.pi * FREQUENCIES
    k = STIFFNESS * np.array([1.0, 4.0])
    orders = np.arange(1, len(STOP_ORDERS) + 1)
    moves = 1 / (
        k * (1 + 1j * LOSS * orders[:, None]) - (orders[:, None] * W[:, None, None]) ** 2 * MASS
    )
    waves = np.zeros((len(W), len(orders), 2), dtype=complex)
    waves[:, 0, 0] = SWING * moves[:, 0, 0]
    free = components(np.tile([steady / STIFFNESS, 0.0], (len(W), 1)), waves)
    size = 1 + 2 * len(orders)
    found = np.zeros((len(W), size, 2, size, 2))
    lossy = moves * (1 + 1j * LOSS * orders[:, None])
    for d in (0, 1):
        found[:, 0, d, 0, d] = 1 / k[d]
        for j in range(len(orders)):
            a, h = 1 + 2 * j, lossy[:, j, d]
            found[:, a, d, a, d] = found[:, a + 1, d, a + 1, d] = h.real
            found[:, a, d, a + 1, d], found[:, a + 1, d, a, d] = -h.imag, h.imag
    return StoppedLine(
        free=free[:, None],
        receptance=found.reshape(len(W), 1, 2 * size, 2 * size),
        stiffness=k.reshape(1, 1, 2),
        stop=np.array([[STOP]]),
        ratio=np.array([[ratio]]),
    )


def elastic(x: np.ndarray, ratio: float) -> np.ndarray:
    """Return the force of rubber and stop, N, at a travel m."""
    return STIFFNESS * (x + (ratio - 1) * np.sign(x) * np.maximum(np.abs(x) - STOP, 0))


def crests(line: StoppedLine, motion: StoppedMotion) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies and largest elastic forces of the motions found of one mass."""
    there = ~np.isnan(motion.place[:, 0])
    travel = motion.travel[there, 0]
    found = forces_at_stop(
        travel, travel, components(STIFFNESS * np.insert(travel[:, 0], 2, 0, axis=-1),
        STIFFNESS * np.insert(travel[:, 1::2] + 1j * travel[:, 2::2], 2, 0, axis=-1)),
        stiffness=line.stiffness.repeat(len(travel), axis=0), loss=np.zeros((len(travel), 1)),
        stop=line.stop.repeat(len(travel), axis=0), ratio=line.ratio.repeat(len(travel), axis=0),
    )  # fmt: skip
    at = np.interp(motion.place[there, 0], np.arange(len(FREQUENCIES)), FREQUENCIES)
    return at, (found.static + found.dynamic)[:, 0]
