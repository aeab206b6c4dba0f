"""Rotations, speeds and accelerations of spatial lines against a multibody engine, Drake.

The engine knows rigid bodies and pins and nothing of this program's equations (`engine.py`).
"""

import numpy as np
import pytest

from cardan.core.units import deg
from cardan.model.layout import layout_from_slopes
from cardan.physics.kinematics.joint_chain import rotate_chain

SAMPLES = 12

# Side and top slopes in deg, yoke phases in deg: two to four joints, in space, odd phases.
LINES = {
    "two joints, aligned": ([0, 4, 1], [0, -1, 2], [0]),
    "two joints, odd phase": ([3, 9, -2], [1, -7, 4], [31]),
    "three joints of a truck": ([3, 1, 4.5, 2], [0, 1.5, -0.8, 0.6], [0, 0]),
    "three joints, crossed": ([5, 0, 7, 2], [-2, 3, -4, 1], [90, 0]),
    "three joints, odd phases, steep": ([14, -11, 20, 3], [-8, 15, -12, 6], [-47, 112]),
    "four joints of a refuse collector": ([4, 3, 2, 7, 3], [0, 1, -1, 0.5, 0], [0, 90, 0]),
    "four joints, odd phases": ([6, -3, 8, 1, 5], [-4, 5, 0, -6, 2], [13, -77, 141]),
    "four joints, steep": ([18, -9, 22, -15, 4], [10, -16, 7, 12, -20], [200, 61, -5]),
}


@pytest.mark.oracle
@pytest.mark.parametrize("line", LINES.values(), ids=LINES.keys())
def test_motion_of_every_member_matches_drake(line):
    """To 1e-9, as the engine's pose is found to 1e-14 and conditioning costs little."""
    from engine import Mechanism

    side, top, phases = (np.radians(x) for x in line)
    layout = layout_from_slopes(side=side, top=top, lengths=np.linspace(0.9, 1.6, len(phases)))
    found = rotate_chain(layout.directions, phases=phases, samples=SAMPLES)
    mechanism = Mechanism(layout.points, layout.directions, phases)
    x, speed, acceleration = (
        np.array(values)
        for values in zip(*(mechanism.motion(theta) for theta in found.theta), strict=True)
    )
    assert found.speed.transpose() == pytest.approx(speed, rel=1e-9)
    largest = abs(acceleration).max()
    assert found.acceleration.transpose() == pytest.approx(acceleration, abs=1e-9 * largest)
    # How far each member has turned since θ = 0, right-handed about its own direction.
    about = layout.directions[1:]
    angle = np.arctan2((np.cross(x[:1], x) * about).sum(-1), (x[:1] * x).sum(-1))
    turned = (found.theta + found.lead - found.lead[:, :1]).T
    gap = (turned - angle + np.pi) % (2 * np.pi) - np.pi
    assert abs(gap).max() < 1e-9
    # And it moves at all: the swing is thousands of times what is compared.
    assert abs(found.lead).max() > 0.01 * deg
