"""How a crack grows under counted cycles. Any consistent units: m and Pa√m inside.

A law gives growth per cycle from the largest and smallest stress intensity of the cycle,
`law(top, bottom)`; a shape gives Y(a) of K = Y S √(πa). Bind their constants with
`functools.partial`. Cycles act in their order but know nothing of each other: no
retardation after an overload, which is the safe side.
"""

import math
from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray
from cardan.core.errors import DesignError
from cardan.physics.fatigue.rainflow import Cycles

CrackGrowthLaw: TypeAlias = Callable[[FloatArray, FloatArray], FloatArray]
GeometryFactor: TypeAlias = Callable[[FloatArray], FloatArray]


def paris(
    top: ArrayLike, bottom: ArrayLike, *, C: float, m: float, threshold: float = 0.0
) -> FloatArray:
    """da/dN = C ΔK^m above the threshold; only the open part of a cycle counts.

    Source: Paris & Erdogan, J. Basic Eng. 85 (1963); ΔK = Kmax for R <= 0, ASTM E647.
    """
    dK = np.maximum(top, 0.0) - np.maximum(bottom, 0.0)
    return np.where(dK > threshold, C * dK**m, 0.0)


def walker(top: ArrayLike, bottom: ArrayLike, *, C: float, m: float, exponent: float) -> FloatArray:
    """da/dN = C (ΔK / (1-R)^(1-γ))^m, R not below 0. Source: Walker, ASTM STP 462 (1970)."""
    high, low = np.maximum(top, 0.0), np.maximum(bottom, 0.0)
    ratio = low / np.where(high > 0, high, 1.0)
    dK = high - low
    return C * (dK / np.maximum(1 - ratio, 1e-300) ** (1 - exponent)) ** m


def paris_cycles(
    *, start: ArrayLike, end: ArrayLike, stress: ArrayLike, C: ArrayLike, m: ArrayLike,
    Y: ArrayLike = 1.0,
) -> FloatArray:  # fmt: skip
    """Cycles of constant range from one crack length to another, Y constant; closed form.

    N = (e^x - 1)/x · a0^(1-m/2) ln(ac/a0) / (C (Y S √π)^m) with x = (1 - m/2) ln(ac/a0):
    one form for every m, 2 included. All arguments broadcast.
    """
    a0, ratio, m = np.asarray(start, float), np.log(np.divide(end, start)), np.asarray(m, float)
    x = (1 - m / 2) * ratio
    mean = np.where(x == 0, 1.0, np.expm1(x) / np.where(x == 0, 1.0, x))
    rate = np.asarray(C) * (np.asarray(Y) * np.asarray(stress) * math.sqrt(math.pi)) ** m
    return mean * a0 ** (1 - m / 2) * ratio / rate


def constant_geometry_factor(a: ArrayLike, *, Y: float = 1.0) -> FloatArray:
    """Return the same Y at every length: 1 through a wide plate, 1.12 from its edge."""
    return np.full_like(np.asarray(a, dtype=float), Y)


def crack_growth_per_sequence(
    a: ArrayLike,
    *,
    cycles: Cycles,
    law: CrackGrowthLaw,
    shape: GeometryFactor = constant_geometry_factor,
) -> FloatArray:
    """Growth (...) of a crack of length a (...) in one passage of the cycles, a held still."""
    a = np.asarray(a, dtype=float)
    unit = (shape(a) * np.sqrt(np.pi * a))[..., None]
    bottom = np.minimum(cycles.start, cycles.end)
    return (cycles.count * law(unit * cycles.top, unit * bottom)).sum(-1)


def sequences_between_crack_lengths(
    *,
    start: float,
    end: float,
    cycles: Cycles,
    law: CrackGrowthLaw,
    shape: GeometryFactor = constant_geometry_factor,
    panels: int = 64,
) -> float:
    """Passages of a history that grow a crack from `start` to `end`.

    ∫ da / (growth per passage), by Gauss-Legendre in ln a: right when one passage grows the
    crack by little. Infinite if it stops on the way.
    """
    if not 0 < start < end:
        msg = f"a crack must grow from above 0 to more, got {start:g} to {end:g}"
        raise DesignError(msg)
    nodes, weights = np.polynomial.legendre.leggauss(8)
    edges = np.linspace(math.log(start), math.log(end), panels + 1)
    half = np.diff(edges)[:, None] / 2
    a = np.exp(edges[:-1, None] + half * (nodes + 1)).ravel()
    # One length at a time: a history may hold millions of cycles.
    rate = np.array(
        [float(crack_growth_per_sequence(x, cycles=cycles, law=law, shape=shape)) for x in a]
    )
    if not rate.min() > 0:
        return math.inf
    return float((half * weights).ravel() @ (a / rate))
