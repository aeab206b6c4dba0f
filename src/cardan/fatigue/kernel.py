"""The inner loop of rainflow counting: compiled where numba is installed, plain where not."""

from collections.abc import Callable
from functools import cache
from typing import Any, TypeAlias

import numpy as np

from cardan.base.arrays import ComplexArray, FloatArray, IntArray

Kernel: TypeAlias = Callable[..., tuple[int, int]]


def close(
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


def followed_on(
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
    closed, n, last, way = close(x, stack, n, last, way, start, end)
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


def in_rows(
    x: FloatArray, sizes: IntArray, left: FloatArray, had: IntArray, stack: FloatArray,
    start: FloatArray, end: FloatArray, many: IntArray,
) -> None:  # fmt: skip
    """Close cycles of rows `x`, of `sizes` one after the other, that follow what they `had` `left`.

    Writes how many each row closes and opens to `many` (rows, 2), and all of them in turn.
    """
    at, before, closed, opened = 0, 0, 0, 0
    for k in range(sizes.size):
        c, n = followed_on(
            x[at : at + sizes[k]], left[before : before + had[k]], stack[opened:], start[closed:],
            end[closed:],
        )  # fmt: skip
        many[k] = c, n
        at, before, closed, opened = at + sizes[k], before + had[k], closed + c, opened + n


def in_choices(
    parts: FloatArray, first: int, gate: float, x: FloatArray, left: FloatArray, had: IntArray,
    stack: FloatArray, start: FloatArray, end: FloatArray, many: IntArray,
) -> None:  # fmt: skip
    """Close cycles of sums of parts (k, n), from the `first` choice of them on, in Gray's order.

    From one to the next a single part comes or goes; `x` is the sum before, and is left as the
    last. Cycles of a range below the gate may be passed over. The rest is as in `in_rows`.
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
            seen = kept[: gated(x, gate, kept)]
        c, n = followed_on(
            seen, left[before : before + had[k]], stack[opened:], start[closed:], end[closed:]
        )
        many[k] = c, n
        before, closed, opened = before + had[k], closed + c, opened + n


def close_rows(x: FloatArray, top: IntArray, amplitude: FloatArray, mean: FloatArray) -> int:
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


def gated(x: Any, gate: float, out: FloatArray) -> int:
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


def followed(force: ComplexArray, stays: complex, out: ComplexArray) -> None:
    """Write y[i] = force[i] + stays y[i - 1] of each row to `out`."""
    for row in range(force.shape[0]):
        y = 0j
        for i in range(force.shape[1]):
            y = force[row, i] + stays * y
            out[row, i] = y


def turned(
    forces: ComplexArray, spin: ComplexArray, back: ComplexArray, p: ComplexArray,
    stays: ComplexArray, share: FloatArray, out: ComplexArray,
) -> None:  # fmt: skip
    """Write to `out` what `answered` returns."""
    for i in range(spin.size):
        # All modes in step: no one waits for what another remembers.
        for k in range(p.size):
            d = p[k] - spin[i]
            size = d.real * d.real + d.imag * d.imag
            gain = (stays[k] * back[i] - 1) * d.conjugate() * (share[k] / size)
            for row in range(forces.shape[0]):
                before = out[k, row, i - 1] if i else 0j
                out[k, row, i] = forces[row, i] * gain + stays[k] * before


def answered(
    forces: ComplexArray, spin: ComplexArray, back: ComplexArray, p: ComplexArray,
    stays: ComplexArray, share: FloatArray,
) -> ComplexArray:  # fmt: skip
    """Return what forces (rows, n) that spin do to modes (m,), steady ones exactly followed.

    Parameters
    ----------
    forces : (rows, n)
        As they turn.
    spin : (n,) 1/s
        Their i times rad/s; `back` (n,) turns them back by a step.
    p : (m,) 1/s
        Of each mode, that keeps `stays` (m,) of itself each step.
    share : (m,)
        The response's scale.

    Returns
    -------
    (m, rows, n)
        Of each mode to each force.
    """
    out = np.empty((p.size, *forces.shape), complex)
    compiled = _compiled(turned)
    if compiled is None:
        for one, q, kept, scale in zip(out, p, stays, share, strict=True):
            one[:] = remembered(forces * ((kept * back - 1) * (scale / (q - spin))), kept)
        return out
    compiled(forces, spin, back, p, stays, share, out)
    return out


def remembered(force: ComplexArray, stays: complex) -> ComplexArray:
    """Return what forces (rows, n) do to something that keeps a share of itself each sample."""
    compiled = _compiled(followed)
    if compiled is None:
        from scipy.signal import lfilter

        return np.asarray(lfilter([1], [1, -stays], force, axis=-1), complex)
    out = np.empty_like(force)
    compiled(force, stays, out)
    return out


def averaged(x: Any, half: int, out: Any) -> None:
    """Write to `out` what `running_mean` returns."""
    last, width = x.size - 1, 2 * half + 1
    total = x[0] * 0
    for k in range(-half, half + 1):
        total += x[min(max(k, 0), last)]
    for i in range(x.size):
        out[i] = total / width
        total += x[min(i + half + 1, last)] - x[max(i - half, 0)]


def running_mean(x: np.ndarray, half: int) -> np.ndarray:
    """Mean (n,) of each value and those up to `half` places from it, level at the ends."""
    compiled = _compiled(averaged)
    if compiled is None or not x.size:
        from scipy.ndimage import uniform_filter1d

        return uniform_filter1d(x, 2 * half + 1, mode="nearest")
    out = np.empty_like(x)
    compiled(x, half, out)
    return out


def heaped(
    place: IntArray, slot: IntArray, values: ComplexArray, ahead: ComplexArray,
    square: FloatArray, speed: FloatArray, cells: ComplexArray, sums: FloatArray,
) -> None:  # fmt: skip
    """Write to `cells` and `sums` what `gathered` returns."""
    for i in range(place.size):
        k = place[i]
        if k >= 0:
            cells[k] += values[i] * ahead[i]
            into = sums[:, slot[i]]
            into[0] += square[i]
            into[1] += speed[i]
            into[2] += 1


def gathered(
    place: IntArray, slot: IntArray, values: ComplexArray, ahead: ComplexArray,
    square: FloatArray, speed: FloatArray, *, cells: int, slots: int,
) -> tuple[ComplexArray, FloatArray]:  # fmt: skip
    """Return sums of values (n,) turned ahead by their places, and of what goes with them by slots.

    Parameters
    ----------
    place, slot : (n,)
        Of each; places below 0 are left out.
    square, speed : (n,)
        What goes with them.

    Returns
    -------
    (cells,), (3, slots)
        The second of squares, speeds and how many.
    """
    compiled = _compiled(heaped)
    if compiled is not None:
        there, sums = np.zeros(cells, complex), np.zeros((3, slots))
        compiled(place, slot, values, ahead, square, speed, there, sums)
        return there, sums
    here = np.flatnonzero(place >= 0)
    place, slot, values = place[here], slot[here], values[here] * ahead[here]
    real, imag = (np.bincount(place, part, cells) for part in (values.real, values.imag))
    each = (square[here], speed[here], np.ones(here.size))
    sums = np.array([np.bincount(slot, x, slots) for x in each], float)
    return real + 1j * imag, sums


def climbed(
    best: FloatArray, reach: int, slope: float, key: FloatArray, queue: IntArray,
    back: IntArray, after: FloatArray,
) -> None:  # fmt: skip
    """Write to `back` and `after` what `farther` returns; `key` and `queue` (n,) are its paper.

    Who is behind in the queue is a better one that came later; whoever is out of reach leaves it.
    """
    n = best.size
    first, last = 0, 0
    for j in range(n):
        key[j] = best[j] + slope * j
        while last > first and key[queue[last - 1]] < key[j]:
            last -= 1
        queue[last] = j
        last += 1
        if queue[first] < j - reach:
            first += 1
        back[j] = queue[first]
        after[j] = best[queue[first]] - slope * (j - queue[first])
    first, last = 0, 0
    for j in range(n - 1, -1, -1):
        key[j] = best[j] - slope * j
        while last > first and key[queue[last - 1]] <= key[j]:
            last -= 1
        queue[last] = j
        last += 1
        if queue[first] > j + reach:
            first += 1
        there = best[queue[first]] - slope * (queue[first] - j)
        if there > after[j]:
            back[j], after[j] = queue[first], there


def farther(best: FloatArray, *, reach: int, slope: float) -> tuple[IntArray, FloatArray]:
    """Return from where (n,) up to so many places away most is left, and what is.

    Each place on the way costs the slope.
    """
    n = best.size
    back, after = np.empty(n, np.intp), np.empty(n)
    compiled = _compiled(climbed)
    if compiled is not None:
        compiled(best, reach, slope, np.empty(n), np.empty(n, np.intp), back, after)
        return back, after
    padded = np.pad(best, reach, constant_values=-np.inf)
    options = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1)
    options = options - slope * np.abs(np.arange(-reach, reach + 1))
    return options.argmax(-1) + np.arange(n) - reach, options.max(-1)


def placed(turns: FloatArray, marks: ComplexArray, out: ComplexArray) -> None:
    """Write to `out` where what began at 1 stands after so many turns (n,).

    The `marks` are 2^k points of the circle: from the nearest on by the series of what is left.
    """
    many = marks.size
    for i in range(turns.size):
        place = many * turns[i]
        near = np.rint(place)
        left = (place - near) * (2 * np.pi / many)
        square = left * left
        mark = marks[np.int64(near) & (many - 1)]
        # What the series leave out is (1e-3)⁵ / 120 and less.
        on, up = 1 - square * (0.5 - square / 24), left * (1 - square / 6)
        out[i] = complex(mark.real * on - mark.imag * up, mark.real * up + mark.imag * on)


_MARKS = np.exp(2j * np.pi * np.arange(4096) / 4096)


def on_circle(turns: FloatArray) -> ComplexArray:
    """Return e^{2πi n} of turns n (...)."""
    compiled = _compiled(placed)
    if compiled is None:
        return np.exp(2j * np.pi * (turns - np.rint(turns)))
    out = np.empty(turns.shape, complex)
    compiled(turns.ravel(), _MARKS, out.reshape(-1))
    return out


def reversals(x: FloatArray) -> FloatArray:
    """Return the samples where `x` turns, with its first and last; nan is left out."""
    x = x[~np.isnan(x)]
    x = x[np.append(True, np.diff(x) != 0)[: x.size]]
    if x.size < 3:
        return x
    step = np.diff(x)
    return x[np.concatenate([[True], step[1:] * step[:-1] < 0, [True]])]


def plain(x: FloatArray, *state: Any) -> tuple[int, int]:
    """Close cycles without numba: NumPy finds the reversals, Python pairs only those."""
    return followed_on(reversals(x), *state)


def compiled_rows() -> Callable[..., None] | None:
    """Return the compiled loop over rows if numba is installed."""
    return _compiled(in_rows)


def compiled_choices() -> Callable[..., None] | None:
    """Return the compiled loop over choices if numba is installed."""
    return _compiled(in_choices)


@cache
def _compiled(function: Callable[..., Any]) -> Callable[..., Any] | None:
    """Return a function compiled where numba is installed, else None."""
    try:
        import numba  # pyright: ignore[reportMissingTypeStubs]
        from numba.extending import (  # pyright: ignore[reportMissingTypeStubs]
            register_jitable,
        )
    except ImportError:
        return None
    for called in (close, gated, followed_on):  # by others here
        register_jitable(called)
    return numba.njit(cache=True, nogil=True, error_model="numpy")(function)


def gate_of_all() -> Callable[[Any, float, FloatArray], int] | None:
    """Return the compiled filter if numba is installed; without it no filter pays."""
    return _compiled(gated)


def rows_at_once() -> Callable[[FloatArray, IntArray, FloatArray, FloatArray], int] | None:
    """Return the compiled loop over rows if numba is installed; without it NumPy is faster."""
    return _compiled(close_rows)


def fastest() -> Kernel:
    """Return the compiled loop if numba is installed, else the plain one: same answer."""
    return _compiled(followed_on) or plain
