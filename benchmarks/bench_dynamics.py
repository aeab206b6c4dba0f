"""A 200 x 200 stability chart against a loop of SciPy monodromies, and against its boundary.

    python benchmarks/bench_dynamics.py

Equal accuracy: both sides are held against one far finer solution, and SciPy gets the
loosest tolerance with which it is as accurate. The loop is timed on a sample of the points.
"""

import time

import numpy as np
from scipy.integrate import solve_ivp

from cardan.physics.dynamics.floquet import evaluate_in_chunks, growth_rate, monodromy_matrix
from cardan.physics.dynamics.stability_chart import zero_contour
from cardan.physics.dynamics.torsional_line import TorsionalLine, linearised_about_rigid_rotation

SPEEDS, ANGLES = np.linspace(0.4, 2.0, 200), np.radians(np.linspace(1, 40, 200))


def system(speed, beta):
    """Asokanthan's two coordinates, all ones, lightly damped."""
    line = TorsionalLine(
        beta=np.stack([beta, np.zeros_like(beta)], axis=-1), stiffness=np.ones(2),
        driving=np.ones(2), driven=np.zeros(2), damping=0.01,
    )  # fmt: skip
    return linearised_about_rigid_rotation(line, speed)


def rate(speed, beta, tolerance=1e-7):
    return growth_rate(system(speed, beta), tolerance=tolerance)


def loop_monodromy(speed, beta, tolerance):
    """The same equations as a user of SciPy would write them."""
    r = np.tan(beta / 2) ** 2
    c = 0.01

    def derivative(t, z):
        theta = speed * t
        sin, cos = np.sin(2 * theta), np.cos(2 * theta)
        below = 1 - 2 * r * cos + r**2
        gain = (1 - r**2) / below
        bend = -gain * 4 * r * sin / below
        lead = np.arctan2(r * sin, 1 - r * cos)
        torque = lead + c * (gain - 1) * speed
        pull = gain + c * bend * speed
        q, v = z.reshape(2, 2, 4)
        first = -((1 + gain * pull + bend * torque) * q[0] + c * (1 + gain**2) * v[0]
                  - gain * q[1] - c * gain * v[1])  # fmt: skip
        second = pull * q[0] - q[1] + c * gain * v[0] - c * v[1]
        return np.concatenate([v[0], v[1], first, second])

    done = solve_ivp(
        derivative, (0, np.pi / speed), np.eye(4).ravel(), method="DOP853",
        rtol=tolerance, atol=tolerance,
    )  # fmt: skip
    return done.y[:, -1].reshape(4, 4)


def chart_against_a_loop():
    """Print a row: our chart, the loop's, and their ratio."""
    x, y = np.meshgrid(SPEEDS, ANGLES, indexing="ij")
    start = time.perf_counter()
    chart = evaluate_in_chunks(rate, x, y)
    ours = time.perf_counter() - start

    rng = np.random.default_rng(1)
    picked = rng.integers(0, x.size, 60)
    s, b = x.ravel()[picked], y.ravel()[picked]
    exact = monodromy_matrix(system(s, b), tolerance=1e-13)
    error = np.abs(monodromy_matrix(system(s, b), tolerance=1e-7) - exact).max()
    for tolerance in 10.0 ** np.arange(-3, -13, -1):
        start = time.perf_counter()
        looped = np.stack([loop_monodromy(*p, tolerance) for p in zip(s, b, strict=True)])
        theirs = (time.perf_counter() - start) / picked.size * x.size
        if np.abs(looped - exact).max() <= error:
            break
    else:
        tolerance = 1e-12  # not even then: the loop is let off
    print(
        f"| 200 x 200 stability chart, error {error:.0e}, against a loop of solve_ivp "
        f"| 100 | {theirs / ours:.0f} ({ours:.2f} s; {theirs:.0f} s at {tolerance:.0e}) |"
    )
    assert np.abs(chart.ravel()[picked] - rate(s, b, 1e-12)).max() < 1e-6
    assert theirs / ours >= 100


def boundary_against_the_grid():
    """Print a row: the boundary by refinement, and a grid that knows it to a cell."""
    calls = 0

    def margin(speed, beta):
        nonlocal calls
        calls += speed.size
        return evaluate_in_chunks(rate, speed, beta)

    start = time.perf_counter()
    line = zero_contour(
        margin, x=(0.4, 2.0), y=(np.radians(1), np.radians(40)), start=(200, 12), levels=3
    )
    refined = time.perf_counter() - start
    start = time.perf_counter()
    grid = evaluate_in_chunks(rate, *np.meshgrid(SPEEDS, ANGLES, indexing="ij"))
    brute = time.perf_counter() - start
    # Every boundary of the grid has a point of the line within a cell of it, and far closer
    # on the line: the grid knows it to a cell, the line to a millionth of one.
    crossed = np.argwhere((grid[1:] > 0) != (grid[:-1] > 0))
    places = np.stack([SPEEDS[crossed[:, 0]], ANGLES[crossed[:, 1]]], axis=-1)
    cell = np.array([SPEEDS[1] - SPEEDS[0], ANGLES[1] - ANGLES[0]])
    apart = np.array([np.abs((line.points - p) / cell).max(-1).min() for p in places])
    fine = 1600 * 96 / grid.size * brute
    print(
        f"| its boundary by refinement, against a grid as fine as its cells "
        f"| 1 | {fine / refined:.0f} ({refined:.2f} s, {calls} points; {fine:.2f} s, 153600) |"
    )
    assert np.mean(apart < 2) == 1.0
    assert np.abs(rate(*line.points.T)).max() < 1e-5


if __name__ == "__main__":
    print("| what | target | measured |\n| --- | --- | --- |")
    chart_against_a_loop()
    boundary_against_the_grid()
