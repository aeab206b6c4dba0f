"""A line that swings by itself: against Floquet multipliers, and mechanics of another hand.

Of the equations of `cardan.physics.loads.rubber_mount`, stepped through half a turn by Runge and
Kutta; and of the crosses by virtual work alone (`shaken.py`), which knows nothing of those: there
two lines a hair apart go apart, or come together, at the rate that is asked.
"""

import numpy as np
import pytest
from shaken import _pushed
from test_rubber import BENT, PUBLISHED, THREE, TWO, laid

from cardan.physics.kinematics.joint_chain import rotate_chain
from cardan.physics.loads.mounted_line_model import mounted_line
from cardan.physics.loads.parametric_instability import line_swing_growth_rate, two_mode_growth

LOSS = 0.01
SOFT = (200e3, 120e3, 0.0)


def line(of, slopes, *, loss=LOSS):
    where = laid(of, **slopes)
    on = mounted_line(where, of, stiffness=SOFT, loss=loss, sines=0)
    return on, on.order2_coupling(
        rotate_chain(where.directions, phases=np.array(of.phases), samples=16)
    )


def floquet(on, swing, *, speed, torque, steps=400):
    """Growth of the line as its matrices have it, its loss that of dampers of each mode."""
    squares, shapes, decay = on.modes_with_decay(torque)
    n = len(squares)
    kicks = torque * (shapes.mT @ swing @ shapes)
    C = np.diag(2 * decay) + speed * (shapes.mT @ on.gyroscopic @ shapes)

    def slope(t, x):
        K = np.diag(squares) - (kicks * np.exp(2j * speed * t)).real
        return np.concatenate([x[n:], -C @ x[n:] - K @ x[:n]])

    h, x = np.pi / speed / steps, np.eye(2 * n)
    for k in range(steps):
        t = k * h
        a = slope(t, x)
        b = slope(t + h / 2, x + h / 2 * a)
        c = slope(t + h / 2, x + h / 2 * b)
        d = slope(t + h, x + h * c)
        x = x + h / 6 * (a + 2 * b + 2 * c + d)
    return np.log(np.abs(np.linalg.eigvals(x)).max()) * speed / np.pi


@pytest.mark.slow
@pytest.mark.parametrize(("of", "slopes", "least"), [(TWO, PUBLISHED, 5e3), (THREE, BENT, 5e2)])
@pytest.mark.parametrize("torque", [1e3, -4e3, 6e3])
def test_growth_rate_of_every_sum_combination_matches_floquet(of, slopes, least, torque):
    """In the middle of each zone and beside it, growing and dying away."""
    on, swing = line(of, slopes)
    w = np.sqrt(on.modes_with_decay(torque)[0])
    grows = 0
    for i in range(len(w)):
        for j in range(i + 1):
            for beside in (0.997, 1.0, 1.004):
                speed = beside * (w[i] + w[j]) / 2
                exact = floquet(on, swing, speed=speed, torque=torque)
                found = float(line_swing_growth_rate(on, swing, speed=speed, torque=torque))
                # Left out is order 3 in the motion: (T S/ω²)² of the rate.
                assert found == pytest.approx(exact, rel=0.04, abs=0.02)
                alone = float(two_mode_growth(on, swing, speed=speed, torque=torque))
                assert alone == pytest.approx(exact, rel=0.25, abs=0.25)
                grows += exact > 0
    assert (grows > 0) == (abs(torque) > least)


def test_damping_closes_instability_zones_at_predicted_torque():
    """T |S| = 4 √(ωi ωj di dj): just below it dies away, just above it grows."""
    on, swing = line(TWO, PUBLISHED)
    squares, shapes, d = on.modes_with_decay(0.0)
    w, S = np.sqrt(squares), np.abs(shapes.mT @ swing @ shapes)
    torque = 4 * np.sqrt(w[0] * w[1] * d[0] * d[1]) / S[0, 1]
    for share, grows in ((0.97, False), (1.03, True)):
        asked = {"speed": (w[0] + w[1]) / 2, "torque": share * torque}
        assert (floquet(on, swing, **asked) > 0) == grows
        assert (float(line_swing_growth_rate(on, swing, **asked)) > 0) == grows


@pytest.mark.slow
def test_subharmonic_zones_are_closed_by_rubber_damping():
    """At 2 Ω = (ωi + ωj)/2 and /3, with a torque that opens the first by far."""
    on, swing = line(THREE, BENT, loss=0.05)
    torque = 8e3
    w = np.sqrt(on.modes_with_decay(torque)[0])
    sums = [(w[i] + w[j]) / 2 for i in range(len(w)) for j in range(i + 1)]
    assert max(floquet(on, swing, speed=s, torque=torque) for s in sums) > 0
    for share in (2, 3):
        assert max(floquet(on, swing, speed=s / share, torque=torque) for s in sums) < 0


def apart(speed, torque, *, loss, turns=60, steps=120):
    """Growth of what is between two lines that start a hair apart, 1/s: by virtual work."""
    where = laid(TWO, **PUBLISHED)
    p1, joint, p3 = where.points
    d0, d1, d2, last = where.directions
    level = np.cross([0.0, 0.0, 1.0], d1)
    level /= np.linalg.norm(level)
    axes = np.stack([np.cross(d1, level), level])
    across = axes - np.outer(axes @ d2, d2)
    M = 20 / 3 * np.eye(2) + 25 / 3 * across @ across.T
    K = np.diag(SOFT[:2])
    w2, shapes = np.linalg.eigh(np.linalg.solve(M, K))
    C = np.linalg.inv(shapes.T) @ np.diag(
        loss * np.sqrt(w2) * np.diag(shapes.T @ M @ shapes)
    ) @ np.linalg.inv(shapes)  # fmt: skip
    h = 2 * np.pi / speed / steps
    A = np.linalg.inv(M + h / 2 * C + h * h / 4 * K)
    x = np.array([[0.0, 0.0], [1e-6, -1e-6]])
    v, a = np.zeros((2, 2)), np.zeros((2, 2))
    told = []
    for i in range(turns * steps):
        for k in (0, 1):
            xp, vp = x[k] + h * v[k] + h * h / 4 * a[k], v[k] + h / 2 * a[k]
            f = _pushed(
                i * h * speed, torque, xp, joint, axes, d0, last, p1, p3, np.zeros(2)
            ) - C @ vp - K @ xp  # fmt: skip
            a[k] = A @ f
            x[k], v[k] = xp + h * h / 4 * a[k], vp + h / 2 * a[k]
        if i % steps == steps - 1:
            e, r = x[1] - x[0], v[1] - v[0]
            told.append(np.log(r @ M @ r + e @ K @ e) / 2)
    late = np.array(told[turns // 3 :])
    return np.polyfit(np.arange(len(late)) * 2 * np.pi / speed, late, 1)[0]


@pytest.mark.slow
@pytest.mark.parametrize("torque", [4e3, 6e3, 8e3])
def test_growth_rate_matches_two_diverging_simulations(torque):
    on, swing = line(TWO, PUBLISHED)
    w = np.sqrt(on.modes_with_decay(0.0)[0])
    speed = (w[0] + w[1]) / 2
    found = float(line_swing_growth_rate(on, swing, speed=speed, torque=torque))
    told = apart(speed, torque, loss=LOSS)
    assert found == pytest.approx(told, rel=0.05, abs=0.03)
    assert (found > 0) == (torque > 5e3)
