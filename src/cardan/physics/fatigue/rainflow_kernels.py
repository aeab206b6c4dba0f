"""The inner loop of rainflow counting: compiled where numba is installed, plain where not."""

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from cardan.core.arrays import FloatArray, IntArray
from cardan.core.compiled import compiled

RainflowKernel: TypeAlias = Callable[..., tuple[int, int]]


def extract_closed_cycles(
    x: Any, stack: FloatArray, n: int, last: float, way: int, start: FloatArray, end: FloatArray
) -> tuple[int, int, float, int]:
    """Walk the samples `x`, closing cycles by the four-point rule.

    `stack[:n]` holds the open reversals, `last` the running extreme behind them and `way`
    its direction (1 up, -1 down, 0 before the first move). Closed cycles are written to
    `start` and `end`. Missing samples (nan) are stepped over. Returns the number of closed
    cycles and the new n, last and way.
    """
    closed = 0
    for i in range(x.size):
        v = x[i]
        if v != v:
            continue
        if way == 0:
            if last != last:  # the first sample of all
                last = v
            elif v != last:
                stack[n] = last
                n += 1
                way = 1 if v > last else -1
                last = v
            continue
        if (way > 0 and v >= last) or (way < 0 and v <= last):
            last = v
            continue
        # `last` was a reversal, and the fourth point of the rule.
        while n >= 3:
            a, b, c = stack[n - 3], stack[n - 2], stack[n - 1]
            inner = abs(c - b)
            if inner > abs(b - a) or inner > abs(last - c):
                break
            start[closed] = b
            end[closed] = c
            closed += 1
            n -= 2
        stack[n] = last
        n += 1
        way = -way
        last = v
    return closed, n, last, way


def extract_closed_cycles_after_residue(
    x: Any, residue: FloatArray, stack: FloatArray, start: FloatArray, end: FloatArray
) -> tuple[int, int]:
    """Close cycles of the samples `x` that follow a residue.

    The reversals that are open then are written to `stack`, closed cycles to `start` and `end`.
    Returns how many are closed and open.
    """
    n, last, way = 0, np.nan, 0
    if residue.size:
        n, last = residue.size - 1, residue[-1]
        stack[:n] = residue[:-1]
        if n:
            way = int(np.sign(last - residue[-2]))
    closed, n, last, way = extract_closed_cycles(x, stack, n, last, way, start, end)
    # Close against the running extreme too: it can only move farther out.
    while n >= 3 and abs(stack[n - 1] - stack[n - 2]) <= min(
        abs(stack[n - 2] - stack[n - 3]), abs(last - stack[n - 1])
    ):
        start[closed], end[closed] = stack[n - 2], stack[n - 1]
        closed, n = closed + 1, n - 2
    if last == last:
        stack[n] = last
        n += 1
    return closed, n


def count_cycles_of_signals_into(
    x: FloatArray, sizes: IntArray, left: FloatArray, had: IntArray, stack: FloatArray,
    start: FloatArray, end: FloatArray, many: IntArray,
) -> None:  # fmt: skip
    """Close cycles of rows `x`, of `sizes` one after the other, that follow what they `had` `left`.

    Writes how many each row closes and opens to `many` (rows, 2), and all of them in turn.
    """
    at, before, closed, opened = 0, 0, 0, 0
    for k in range(sizes.size):
        c, n = extract_closed_cycles_after_residue(
            x[at : at + sizes[k]], left[before : before + had[k]], stack[opened:], start[closed:],
            end[closed:],
        )  # fmt: skip
        many[k] = c, n
        at, before, closed, opened = at + sizes[k], before + had[k], closed + c, opened + n


def count_cycles_of_cause_coalitions_into(
    parts: FloatArray, first: int, gate: float, x: FloatArray, left: FloatArray, had: IntArray,
    stack: FloatArray, start: FloatArray, end: FloatArray, many: IntArray,
) -> None:  # fmt: skip
    """Close cycles of sums of parts (k, n), from the `first` choice of them on, in Gray's order.

    From one to the next a single part comes or goes; `x` is the sum before, and is left as the
    last. Cycles of a range below the gate may be passed over. The rest is as in
    `count_cycles_of_signals_into`.
    """
    before, closed, opened = 0, 0, 0
    kept = np.empty(x.size + 2)
    for k in range(had.size):
        step = first + k
        part = 0
        while step and not step >> part & 1:
            part += 1
        if step:
            sign = 1.0 if (step ^ step >> 1) >> part & 1 else -1.0
            for i in range(x.size):
                x[i] += sign * parts[part, i]
        seen = x
        if gate > 0:
            seen = kept[: omit_small_reversals_into(x, gate, kept)]
        c, n = extract_closed_cycles_after_residue(
            seen, left[before : before + had[k]], stack[opened:], start[closed:], end[closed:]
        )
        many[k] = c, n
        before, closed, opened = before + had[k], closed + c, opened + n


def count_cycles_of_repeating_signals_into(
    x: FloatArray, top: IntArray, amplitude: FloatArray, mean: FloatArray
) -> int:
    """Write the cycles of rows (rows, t), each from its `top` (rows,) round to it; return most.

    By the four-point rule; what stays open is the largest, from the top down and back.
    """
    rows, t = x.shape
    stack, most = np.empty(t + 1), 0
    for r in range(rows):
        n, closed, way, last, k = 0, 0, 0.0, x[r, top[r]], top[r]
        for i in range(1, t + 2):
            k = k + 1 if k + 1 < t else 0
            v = x[r, k] if i <= t else last - way  # behind its end every row turns
            if (v - last) * way > 0 or v == last:
                last = v
                continue
            stack[n] = last
            n += 1
            while n >= 4:
                a, b, c, d = stack[n - 4], stack[n - 3], stack[n - 2], stack[n - 1]
                inner = abs(c - b)
                if inner > abs(b - a) or inner > abs(d - c):
                    break
                amplitude[r, closed] = inner / 2
                mean[r, closed] = (b + c) / 2
                closed += 1
                stack[n - 3] = d
                n -= 2
            way, last = (1.0 if v > last else -1.0), v
        if n >= 2:
            amplitude[r, closed] = abs(stack[0] - stack[1]) / 2
            mean[r, closed] = (stack[0] + stack[1]) / 2
            closed += 1
        most = max(most, closed)
    return most


def omit_small_reversals_into(x: Any, gate: float, out: FloatArray) -> int:
    """Write the samples at which `x` turns by more than `gate`, with its first and last, to `out`.

    What is left closes the same cycles as all of it, but for those of a range below the gate.
    Missing samples (nan) are stepped over. Returns how many were written.
    """
    n, way = 0, 0.0
    last = low = high = end = np.nan
    for i in range(x.size):
        v = x[i]
        if v != v:
            continue
        end = v
        if way != 0:
            # Upwards, whichever way it goes: then a largest value is no branch that is foreseen.
            up = way * v
            last = up if up > last else last
            if last - up > gate:
                out[n] = way * last
                n, way, last = n + 1, -way, -up
        elif n == 0:
            out[0] = v
            n, low, high = 1, v, v
        else:
            # No way yet: the first sample and what goes away from it on both sides.
            low, high = min(low, v), max(high, v)
            if high - low > gate:
                other = low if v == high else high
                if other != out[0]:
                    out[n] = other
                    n += 1
                way = 1.0 if v == high else -1.0
                last = way * v
    if way != 0:
        out[n] = way * last
        n += 1
    if n and out[n - 1] != end:
        out[n] = end
        n += 1
    return n


def reversals(x: FloatArray) -> FloatArray:
    """Return the samples where `x` turns, with its first and last; nan is left out."""
    x = x[~np.isnan(x)]
    x = x[np.append(True, np.diff(x) != 0)[: x.size]]
    if x.size < 3:
        return x
    step = np.diff(x)
    return x[np.concatenate([[True], step[1:] * step[:-1] < 0, [True]])]


def extract_closed_cycles_without_numba(x: FloatArray, *state: Any) -> tuple[int, int]:
    """Close cycles without numba: NumPy finds the reversals, Python pairs only those."""
    return extract_closed_cycles_after_residue(reversals(x), *state)


def compiled_signal_cycle_counter() -> Callable[..., None] | None:
    """Return the compiled loop over rows if numba is installed."""
    return _compiled(count_cycles_of_signals_into)


def compiled_cause_coalition_cycle_counter() -> Callable[..., None] | None:
    """Return the compiled loop over choices if numba is installed."""
    return _compiled(count_cycles_of_cause_coalitions_into)


def _compiled(function: Callable[..., Any]) -> Callable[..., Any] | None:
    """Return a function compiled where numba is installed, else None."""
    return compiled(
        function,
        extract_closed_cycles,
        omit_small_reversals_into,
        extract_closed_cycles_after_residue,
    )


def compiled_small_reversal_filter() -> Callable[[Any, float, FloatArray], int] | None:
    """Return the compiled filter if numba is installed; without it no filter pays."""
    return _compiled(omit_small_reversals_into)


def compiled_repeating_signal_cycle_counter() -> (
    Callable[[FloatArray, IntArray, FloatArray, FloatArray], int] | None
):
    """Return the compiled loop over rows if numba is installed; without it NumPy is faster."""
    return _compiled(count_cycles_of_repeating_signals_into)


def fastest_kernel() -> RainflowKernel:
    """Return the compiled loop if numba is installed, else the plain one: same answer."""
    return _compiled(extract_closed_cycles_after_residue) or extract_closed_cycles_without_numba
