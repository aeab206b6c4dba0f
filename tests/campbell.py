"""Whirl of a line at given speeds: another eigenproblem than that of its critical speeds."""

from types import SimpleNamespace

import numpy as np

from cardan.physics.strength.beams import assemble_beams
from cardan.physics.strength.critical_speed import _modes


def campbell_diagram(beams, *, speeds, modes=4, elements=4):
    """Return frequency rad/s, forward_share and bending_share, (speeds, modes).

    K - ω² M + ω Ω G = 0 is linear in 1/ω, with ω √M x next to x.
    """
    system = assemble_beams(beams, elements)
    flexibility, V = np.linalg.eigh(system.flexibility)
    up, level = (np.diag(np.sqrt(np.maximum(f, 0.0))) for f in flexibility)
    zero = np.zeros(up.shape)
    found = []
    for speed in speeds:
        G = speed * V[0].T @ system.gyroscopic @ V[1]
        inverse, x = np.linalg.eigh(
            np.block([
                [zero, -G, up, zero], [-G.T, zero, zero, level],
                [up, zero, zero, zero], [zero, level, zero, zero],
            ])
        )  # fmt: skip
        whirl = V @ x[: 2 * len(up)].reshape(2, len(up), -1)
        found.append(_modes(system, inverse**2, whirl, modes))
    return SimpleNamespace(**{
        name: np.stack([getattr(one, name) for one in found])
        for name in ("frequency", "forward_share", "bending_share")
    })  # fmt: skip
