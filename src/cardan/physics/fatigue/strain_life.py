r"""Strain-life at a notch: local stress and strain with memory, and what their loops cost.

Where a part yields, a stress is no longer its strain times E. Loading for the first time
follows the cyclic curve, and each way back the same curve doubled, from where it turned
(Masing); what closes a loop goes on as if the loop had not been (memory). At a notch of
concentration K_t elastic stress and local stress and strain go by Neuber:

    σ ε = (K_t S)² / E,    ε = σ/E + (σ/K')^{1/n'}

and of ranges, Δσ Δε = (K_t ΔS)²/E with Δε = Δσ/E + 2 (Δσ/2K')^{1/n'}.
Sources: Neuber, J. Appl. Mech. 28 (1961); Masing, 2nd Int. Congr. Appl. Mech. (1926);
Clormann & Seeger, Stahlbau 55 (1986), which counts so; Smith, Watson & Topper, J. Materials 5
(1970); Morrow, Fatigue Design Handbook, SAE (1968).
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from cardan.core.arrays import FloatArray
from cardan.core.compiled import compiled
from cardan.core.errors import DesignError
from cardan.core.units import Pascal
from cardan.physics.fatigue.rainflow import significant_reversals

MIN_LOOP_RANGE_RATIO = 1e-3
"""Range over the largest below which no loop is followed: it costs nothing next to others."""
HYSTERESIS_CURVE_TABLE_STEP_COUNT = 8192
"""Steps of the doubled curve that is looked up; between them it is straight to 1e-7."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CyclicMaterial:
    """Cyclic curve and strain-life curve of a material.

    Attributes
    ----------
    modulus : Pa
        E.
    strength, exponent : Pa and 1
        σf' and b of Basquin's line.
    ductility, ductility_exponent : 1
        εf' and c of Coffin and Manson's.
    hardening, hardening_exponent : Pa and 1
        K' and n' of the cyclic curve.
    """

    modulus: Pascal
    strength: Pascal
    exponent: float
    ductility: float
    ductility_exponent: float
    hardening: Pascal
    hardening_exponent: float

    def __post_init__(self) -> None:
        for name in ("modulus", "strength", "ductility", "hardening", "hardening_exponent"):
            value = getattr(self, name)
            if not 0 < value < math.inf:
                msg = f"{name} of a strain-life curve must be above 0, got {value:g}"
                raise DesignError(msg)
        for name in ("exponent", "ductility_exponent"):
            value = getattr(self, name)
            if not -2 < value < 0:
                msg = f"{name} of a strain-life curve must lie within (-2, 0), got {value:g}"
                raise DesignError(msg)

    def strain(self, stress: FloatArray) -> FloatArray:
        """Return strain (...) at each stress amplitude (...) Pa of the cyclic curve."""
        return stress / self.modulus + (stress / self.hardening) ** (1 / self.hardening_exponent)

    def stress(self, elastic: FloatArray, *, notch: float | None) -> FloatArray:
        """Return stress (...) of the cyclic curve that were `elastic` (...) Pa without yielding.

        By Neuber at a notch; without one the strain is that measured, `elastic` over E.
        """
        target = np.asarray(elastic, float) * (1.0 if notch is None else notch)
        low, high = np.zeros_like(target), np.maximum(target, 0.0)
        for _ in range(60):
            middle = (low + high) / 2
            strain = self.strain(middle)
            over = (
                strain * self.modulus > target
                if notch is None
                else middle * strain * self.modulus > target**2
            )
            low, high = np.where(over, low, middle), np.where(over, middle, high)
        return (low + high) / 2

    def cycles_to_failure(
        self, amplitude: FloatArray, mean: FloatArray, top: FloatArray, law: str
    ) -> FloatArray:
        """Return cycles to failure (...) of loops of strain amplitude (...).

        `law` is one of `MEAN_STRESS_LAWS`.

        `mean` and `top` : (...) Pa, mean and largest stress of the loop. Infinite where it
        never opens.
        """
        target, basquin = np.asarray(amplitude, float), self.strength / self.modulus
        b, c = self.exponent, self.ductility_exponent
        lift = np.ones_like(target)
        if law == "swt":
            # σmax εa = σf'²/E (2N)^2b + σf' εf' (2N)^(b+c), both sides over σf'.
            target, b, c = np.maximum(top, 0.0) * target / self.strength, 2 * b, b + c
        elif law == "morrow":
            lift = np.maximum(1 - mean / self.strength, 0.0)
        low, high = np.full(target.shape, -3.0), np.full(target.shape, 40.0)
        for _ in range(60):
            middle = (low + high) / 2
            bears = lift * basquin * np.exp(b * middle) + self.ductility * np.exp(c * middle)
            low, high = (
                np.where(bears > target, middle, low),
                np.where(bears > target, high, middle),
            )
        return np.where(high >= 40.0, np.inf, np.exp((low + high) / 2) / 2)


MEAN_STRESS_LAWS = ("swt", "morrow", "none")
"""What the mean stress of a loop does: Smith, Watson and Topper, Morrow, or nothing."""


def material_from_strain_life_curve(
    *, modulus: Pascal, strength: Pascal, exponent: float, ductility: float,
    ductility_exponent: float,
) -> CyclicMaterial:  # fmt: skip
    """Return a material whose cyclic curve follows from its strain-life curve.

    n' = b/c and K' = σf'/εf'^n', where elastic and plastic parts of both belong together.
    """
    n = hardening = 1.0  # `Material` says what is wrong
    if exponent < 0 and ductility_exponent < 0 and ductility > 0:
        n = exponent / ductility_exponent
        hardening = strength / ductility**n
    return CyclicMaterial(
        modulus=modulus, strength=strength, exponent=exponent, ductility=ductility,
        ductility_exponent=ductility_exponent, hardening=hardening,
        hardening_exponent=n,
    )  # fmt: skip


def track_hysteresis(
    x: Any, stack: FloatArray, local: FloatArray, n: int, first: int, most: float,
    once: FloatArray, doubled: FloatArray, step: float, out: FloatArray,
) -> tuple[int, int, int, float]:  # fmt: skip
    """Follow reversals `x`, closing loops: memory and Masing, with curves looked up.

    `stack[:n]` and `local[:n]` hold elastic and local stress of the open reversals, of which the
    first `first` lie on the curve of first loading; `most` is how far that has gone. Loops go
    to `out` (k, 2): local stress at both ends. Returns their number and the new
    n, first and most.
    """
    closed = 0
    for i in range(x.size):
        v = x[i]
        while n - first >= 1 and n >= 2:
            if abs(v - stack[n - 1]) < abs(stack[n - 1] - stack[n - 2]):
                break
            out[closed, 0], out[closed, 1] = local[n - 2], local[n - 1]
            closed += 1
            n -= 2
            first = min(first, n)
        way = abs(v) if abs(v) >= most else abs(v - stack[n - 1])
        place = way / step
        k = min(int(place), once.size - 2)
        if abs(v) >= most:
            size = once[k] + (place - k) * (once[k + 1] - once[k])
            stress = size if v > 0 else -size
            most = abs(v)
            first = n + 1
        else:
            size = doubled[k] + (place - k) * (doubled[k + 1] - doubled[k])
            stress = local[n - 1] + (size if v > stack[n - 1] else -size)
        stack[n], local[n] = v, stress
        n += 1
    return closed, n, first, most


@dataclass(frozen=True)
class HysteresisLoops:
    """Closed hysteresis loops, and open legs as half ones.

    Attributes
    ----------
    amplitude : (n,) 1
        Of the local strain.
    mean, top : (n,) Pa
        Mean and largest local stress.
    count : (n,) 1
        1 of a loop, 0.5 of a leg.
    """

    amplitude: FloatArray
    mean: FloatArray
    top: FloatArray
    count: FloatArray

    def damage(self, material: CyclicMaterial, *, law: str) -> float:
        """Return their damage by Miner."""
        cycles = material.cycles_to_failure(self.amplitude, self.mean, self.top, law)
        return float((self.count / cycles).sum())


class NotchStrainTracker:
    """Follows the elastic stress of a place, piece by piece."""

    def __init__(
        self, material: CyclicMaterial, *, largest: Pascal, notch: float | None = None
    ) -> None:
        self.material, self.notch = material, notch
        # A range is at most twice the largest stress.
        self.step = 2 * largest * 1.001 / HYSTERESIS_CURVE_TABLE_STEP_COUNT
        table = np.asarray(np.arange(HYSTERESIS_CURVE_TABLE_STEP_COUNT + 2) * self.step, float)
        self.once = material.stress(table, notch=notch)
        self.doubled = 2 * material.stress(table / 2, notch=notch)
        self.gate = MIN_LOOP_RANGE_RATIO * 2 * largest
        self.stack, self.local = np.empty(0), np.empty(0)
        self.first, self.most, self.held = 0, 0.0, np.empty(0)

    def update(self, stress: FloatArray) -> HysteresisLoops:
        """Take a piece (n,) Pa of elastic stress, nan where missing; return what it closes."""
        turns = significant_reversals(np.concatenate([self.held, stress]), gate=self.gate)
        new = turns[self.held.size // 2 : -1]
        # The last may yet go on: it comes again with the next piece, behind the turn before it.
        self.held = turns[-2:].copy()
        return self._followed(new)

    def _followed(self, turns: FloatArray) -> HysteresisLoops:
        n = self.stack.size
        stack, local = (np.concatenate([a, np.empty(turns.size)]) for a in (self.stack, self.local))
        out = np.empty((n + turns.size, 2))
        closed, n, self.first, self.most = (compiled(track_hysteresis) or track_hysteresis)(
            turns, stack, local, n, self.first, self.most, self.once, self.doubled, self.step, out
        )
        self.stack, self.local = stack[:n].copy(), local[:n].copy()
        return self._loops(*out[:closed].T)

    def remaining_loops(self, *, legs: bool = True) -> HysteresisLoops:
        """Return what the last turn closes, and the legs that nothing closed as halves."""
        done = self._followed(self.held[self.held.size // 2 :])
        if not legs or self.stack.size < 2:
            return done
        left = self._legs()
        return HysteresisLoops(
            *(
                np.concatenate([getattr(done, k), getattr(left, k)])
                for k in ("amplitude", "mean", "top", "count")
            )
        )

    def _legs(self) -> HysteresisLoops:
        """Return the open legs as half loops.

        First loading goes along the curve itself, from strain to strain; the ways behind it are
        that curve doubled.
        """
        one, other, n = self.local[:-1], self.local[1:], self.first
        virgin = np.sign(self.local[:n]) * self.material.strain(np.abs(self.local[:n]))
        amplitude = self.material.strain(np.abs(other - one) / 2)
        amplitude[: max(n - 1, 0)] = np.abs(np.diff(virgin)) / 2
        return HysteresisLoops(
            amplitude, (one + other) / 2, np.maximum(one, other), np.full(one.size, 0.5)
        )

    def _loops(self, one: FloatArray, other: FloatArray) -> HysteresisLoops:
        """Return loops between two local stresses (n,) Pa; their strain is on the doubled curve."""
        amplitude = self.material.strain(np.abs(other - one) / 2)
        return HysteresisLoops(
            amplitude, (one + other) / 2, np.maximum(one, other), np.ones(one.size)
        )
