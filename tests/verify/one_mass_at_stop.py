"""A mass on rubber with a stop, as METHOD section 20 has it, and what its stop's crests carry."""

import numpy as np

from cardan.physics.loads.rubber_stop_contact import STOP_ORDERS, components, forces_at_stop
from cardan.physics.loads.rubber_stop_receptance import StoppedLine, StopReceptance
from cardan.physics.loads.rubber_stop_response import StoppedMotion

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
    lossy = moves * (1 + 1j * LOSS * orders[:, None])
    blocks = np.zeros((len(W), len(orders), 2, 2, 2, 2))
    for d in (0, 1):
        h = lossy[..., d]
        blocks[..., 0, d, 0, d] = blocks[..., 1, d, 1, d] = h.real
        blocks[..., 0, d, 1, d], blocks[..., 1, d, 0, d] = -h.imag, h.imag
    blocks = blocks.reshape(len(W), len(orders), 4, 4)
    tied = np.zeros((len(W), 10, 10))
    tied[:, [0, 1], [0, 1]] = 1 / k
    for j in (0, 1):
        some = slice(2 + 4 * j, 6 + 4 * j)
        tied[:, some, some] = blocks[:, j]
    none = np.zeros(1, dtype=int)
    return StoppedLine(
        free=free[:, None],
        receptance=StopReceptance(
            tied=tied[:, None], alone=blocks[:, None, 2:], tied_of=none, alone_of=none
        ),
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
