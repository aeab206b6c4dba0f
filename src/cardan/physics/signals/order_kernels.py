"""Inner loops of order tracking: compiled where numba is installed, NumPy or SciPy where not."""

from typing import Any

import numpy as np

from cardan.core.arrays import ComplexArray, FloatArray, IntArray
from cardan.core.compiled import compiled


def first_order_filter_into(force: ComplexArray, stays: complex, out: ComplexArray) -> None:
    """Write y[i] = force[i] + stays y[i - 1] of each row to `out`."""
    for row in range(force.shape[0]):
        y = 0j
        for i in range(force.shape[1]):
            y = force[row, i] + stays * y
            out[row, i] = y


def modal_response_into(
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


def modal_response(
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
    loop = compiled(modal_response_into)
    if loop is None:
        for one, q, kept, scale in zip(out, p, stays, share, strict=True):
            one[:] = first_order_filter(forces * ((kept * back - 1) * (scale / (q - spin))), kept)
        return out
    loop(forces, spin, back, p, stays, share, out)
    return out


def first_order_filter(force: ComplexArray, stays: complex) -> ComplexArray:
    """Return what forces (rows, n) do to something that keeps a share of itself each sample."""
    loop = compiled(first_order_filter_into)
    if loop is None:
        from scipy.signal import lfilter

        return np.asarray(lfilter([1], [1, -stays], force, axis=-1), complex)
    out = np.empty_like(force)
    loop(force, stays, out)
    return out


def running_mean_into(x: Any, half: int, out: Any) -> None:
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
    loop = compiled(running_mean_into)
    if loop is None or not x.size:
        from scipy.ndimage import uniform_filter1d

        return uniform_filter1d(x, 2 * half + 1, mode="nearest")
    out = np.empty_like(x)
    loop(x, half, out)
    return out


def bin_sums_into(
    place: IntArray, slot: IntArray, values: ComplexArray, ahead: ComplexArray,
    square: FloatArray, speed: FloatArray, cells: ComplexArray, sums: FloatArray,
) -> None:  # fmt: skip
    """Write to `cells` and `sums` what `bin_sums` returns."""
    for i in range(place.size):
        k = place[i]
        if k >= 0:
            cells[k] += values[i] * ahead[i]
            into = sums[:, slot[i]]
            into[0] += square[i]
            into[1] += speed[i]
            into[2] += 1


def bin_sums(
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
    loop = compiled(bin_sums_into)
    if loop is not None:
        there, sums = np.zeros(cells, complex), np.zeros((3, slots))
        loop(place, slot, values, ahead, square, speed, there, sums)
        return there, sums
    here = np.flatnonzero(place >= 0)
    place, slot, values = place[here], slot[here], values[here] * ahead[here]
    real, imag = (np.bincount(place, part, cells) for part in (values.real, values.imag))
    each = (square[here], speed[here], np.ones(here.size))
    sums = np.array([np.bincount(slot, x, slots) for x in each], float)
    return real + 1j * imag, sums


def fill_best_predecessors_within_reach(
    best: FloatArray, reach: int, slope: float, key: FloatArray, queue: IntArray,
    back: IntArray, after: FloatArray,
) -> None:  # fmt: skip
    """Fill `back` and `after`: the best neighbour of each place by its worth less its distance.

    `key` and `queue` (n,) are working memory.

    What is behind in the queue is a better one that came later; what is out of reach leaves it.
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


def best_predecessor_within_reach(
    best: FloatArray, *, reach: int, slope: float
) -> tuple[IntArray, FloatArray]:
    """Return from where (n,) up to so many places away most is left, and what is.

    Each place on the way costs the slope.
    """
    n = best.size
    back, after = np.empty(n, np.intp), np.empty(n)
    loop = compiled(fill_best_predecessors_within_reach)
    if loop is not None:
        loop(best, reach, slope, np.empty(n), np.empty(n, np.intp), back, after)
        return back, after
    padded = np.pad(best, reach, constant_values=-np.inf)
    options = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1)
    options = options - slope * np.abs(np.arange(-reach, reach + 1))
    return options.argmax(-1) + np.arange(n) - reach, options.max(-1)


def phasor_of_turns_into(turns: FloatArray, marks: ComplexArray, out: ComplexArray) -> None:
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


_CIRCLE_TABLE = np.exp(2j * np.pi * np.arange(4096) / 4096)


def unit_phasor_of_turns(turns: FloatArray) -> ComplexArray:
    r"""Return $e^{2\pi i n}$: where what began at 1 stands after so many turns.

    Parameters
    ----------
    turns : (...) 1
        Turns n, whole ones included: as near as rounding of them allows.
    """
    loop = compiled(phasor_of_turns_into)
    if loop is None:
        return np.exp(2j * np.pi * (turns - np.rint(turns)))
    out = np.empty(turns.shape, complex)
    loop(turns.ravel(), _CIRCLE_TABLE, out.reshape(-1))
    return out
