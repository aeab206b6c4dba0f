"""Largest sums of turning shafts, case by case: a loop compiled where numba is installed.

The same as `cardan.physics.kinematics.equivalent_angle`, which stays the reference: that runs each
step over all cases, this all steps over one case.
"""

from collections.abc import Callable
from math import sqrt
from typing import Any, TypeAlias

from cardan.core.arrays import BoolArray, ComplexArray, FloatArray
from cardan.core.compiled import compiled

CrestKernel: TypeAlias = Callable[..., None]


def plain_crests(
    phasors: ComplexArray,
    weights: FloatArray,
    share: float,
    steps: int,
    found: FloatArray,
    plain: BoolArray,
) -> None:
    """Fill the largest sums (C,) where there is one peak on either side, and where that is so.

    Parameters
    ----------
    phasors, weights : (M, C), (M, C or 1)
        Of M members.
    share
        `MAX_HIGHER_HARMONIC_SHARE`
    steps
        `THREE_HARMONIC_NEWTON_STEPS`
    """
    M, C = phasors.shape
    for c in range(C):
        own = min(c, weights.shape[1] - 1)
        first, bent = 0j, 0.0
        for k in range(M):
            phasor, weight = phasors[k, c], weights[k, own]
            e2 = phasor.real * phasor.real + phasor.imag * phasor.imag
            near = 1 - sqrt(e2)
            near *= near
            first += weight * phasor
            bent += abs(weight) * 8 * e2 / (near * near)
        most = sqrt(first.real * first.real + first.imag * first.imag)
        plain[c] = bent <= share * most
        if not plain[c]:
            continue
        size = most if most > 0 else 1.0
        turn = complex(first.imag / size, first.real / size)  # i times its conjugate
        second, third = 0j, 0j
        for k in range(M):
            x, weight = phasors[k, c] * turn, weights[k, own]
            second += 2 * weight * (x * x)
            third += 3 * weight * (x * x * x)
        largest = 0.0
        for side in range(2):
            z = complex(1.0 - 2 * side, 0.0)
            for _ in range(steps):
                z2 = z * z
                one = most * z
                a, b, d = complex(-one.imag, one.real), second * z2, third * (z2 * z)
                slope, bend = (a + 2 * b + 3 * d).real, (a + 4 * b + 9 * d).imag
                length = sqrt(slope * slope + bend * bend) + 1e-300
                sign = 1.0 if bend > 0 else (-1.0 if bend < 0 else 0.0)
                z = z * complex(abs(bend) / length, slope / length * sign)
            swing, slope, bend = 0.0, 0.0, 0.0
            for k in range(M):
                weight = weights[k, own]
                gain = 1 / (1 - phasors[k, c] * turn * z)
                p = gain - 1
                g = p * gain
                swing += weight * g.imag
                slope += weight * (g * (gain + p)).real
                bend += weight * (g + 6 * (g * g)).imag
            rise = slope * slope / (2 * (abs(bend) if most > 0 else 1.0))
            largest = max(largest, abs(swing) + rise)
        found[c] = 4 * largest


def crest_kernel() -> CrestKernel | None:
    """Return the compiled `plain_crests`; None without numba."""
    loop: Any = compiled(plain_crests)
    return loop
