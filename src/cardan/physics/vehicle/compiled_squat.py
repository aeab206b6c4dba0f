"""How far an axle squats, many cases side by side: a loop compiled where numba is installed.

The same steps as `cardan.physics.vehicle.suspension.squat_travel`, which stays the reference: that
runs each step over all cases, this all steps over a few cases at a time. They stand side by side
in short rows, over which each inner loop goes, so that the processor computes several at once.
"""

from collections.abc import Callable
from math import sqrt
from typing import Any, TypeAlias

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.compiled import compiled

SquatKernel: TypeAlias = Callable[..., None]

SQUAT_ROW_CASES = 32
"""Cases side by side: a few times what a processor computes at once."""


def squat_of_rows(
    cases: FloatArray, lines: FloatArray, link: FloatArray, steps: int, gone: FloatArray
) -> None:
    """Fill how much further each of C axles rises, (C,) m.

    Parameters
    ----------
    cases : (6, C)
        Travel at rest m; load of a spring without what follows the link, what each unit of the
        link's slope dx/dz takes off it, N; deflection at rest m; least and largest rise m.
    lines : (4, L)
        Load at which each line of the spring begins N, its slope m/N, and between which loads
        from there it counts.
    link : (3,)
        Sine of the angle, 1/radius (0 without one) and the spring's first deflection m.
    steps
        Steps of each.
    """
    C = gone.shape[0]
    rise, held = np.zeros(SQUAT_ROW_CASES), np.zeros(SQUAT_ROW_CASES)
    load, row = np.zeros(SQUAT_ROW_CASES), np.zeros((6, SQUAT_ROW_CASES))
    for first in range(0, C, SQUAT_ROW_CASES):
        count = min(SQUAT_ROW_CASES, C - first)
        for k in range(6):
            for i in range(count):
                row[k, i] = cases[k, first + i]
        for i in range(SQUAT_ROW_CASES):
            rise[i] = 0.0
        for _ in range(steps):
            for i in range(SQUAT_ROW_CASES):
                sine = link[0] - (row[0, i] + rise[i]) * link[1]
                load[i] = row[1, i] - row[2, i] * (sine / sqrt(1 - sine * sine))
                held[i] = link[2] - row[3, i]
            for k in range(lines.shape[1]):
                begin, slope, low, high = lines[0, k], lines[1, k], lines[2, k], lines[3, k]
                for i in range(SQUAT_ROW_CASES):
                    along = load[i] - begin
                    along = low if along < low else along
                    along = high if along > high else along
                    held[i] += slope * along
            for i in range(SQUAT_ROW_CASES):
                moved = held[i]
                moved = row[4, i] if moved < row[4, i] else moved
                rise[i] = row[5, i] if moved > row[5, i] else moved
        for i in range(count):
            gone[first + i] = rise[i]


def squat_kernel() -> SquatKernel | None:
    """Return the compiled `squat_of_rows`; None without numba."""
    loop: Any = compiled(squat_of_rows)
    return loop
