"""Damage on the plane that suffers most, at many places at once.

A surface bears no load across it, so a crack opens under the normal stress on a plane square
to the surface. Of each place and plane the stress history is counted by rainflow, as one
that repeats for ever, and the damage of all histories adds up on the same plane.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TypeAlias

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray, IntArray
from cardan.physics.fatigue.rainflow_kernels import compiled_repeating_signal_cycle_counter

PLANE_COUNT = 36
"""Planes tried at each place, 5 degrees apart: of shear at most 0.4 % is missed."""
_PRINCIPAL_LOAD_DIRECTIONS = 3
"""Ways in which loads vary most: along these and between them those moments are sought that show
how far stress swings."""
MIN_FULL_COUNT_DAMAGE_SHARE = 1e-3
"""Share of the worst damage below which the largest cycle alone is counted."""
_FIRST_COUNTED_PLANES, _COUNTED_PLANE_STRIDE, _NEIGHBOUR_PLANES, _MAX_SHORT_PASS_SAMPLES = (
    3,
    3,
    2,
    256,
)
"""Planes of a place that are counted closely, those of the largest cycle; and moments up to which a
pass has so few cycles that any plane which may be worse is known. Beyond, of so many one is
counted, and from the worst on so many to either side until none is worse."""
_MIN_WAVE_AMPLITUDE_RATIO, _MAX_SEPARATE_ORDERS = 1e-6, 4
"""Share of the largest wave below which one is none; and how many are few."""
CYCLE_SIZE_LEVEL_COUNT = 16
"""Shares of a reach by which cycles are distinguished."""
_MAX_ELLIPSOID_ITERATIONS, _ELLIPSOID_TOLERANCE = 200, 0.01
"""Of the search for an ellipsoid at most; and how near it is enough."""
_CACHE_BLOCK_NUMBERS, _MEMORY_BLOCK_NUMBERS = 200_000, 4_000_000
"""Numbers that stay near a processor: extremes of few moments are found five times as fast. And
numbers held at once of a long history, whose moments are counted one by one."""
_LONG_HISTORY_SAMPLES = 1000
"""Moments of a long history; and of one twice as long those whose extremes are evaluated first."""

CycleDamageFunction: TypeAlias = Callable[[FloatArray, FloatArray, IntArray], FloatArray]
"""From amplitude and mean of cycles (k, ...) Pa, at places numbered (k,), to damage of each."""


@dataclass(frozen=True)
class LoadHistory:
    """A load history that repeats, and how often it happens.

    Attributes
    ----------
    loads : (places, t, c)
        One pass; of as many `places` only the worst happens.
    repeats
        Passes in the time that damage refers to: a second, the life.
    scale : (m,) or one
        By how much what it stresses is more, at each place, than its unit stresses make it.
    """

    loads: FloatArray
    repeats: float = 1.0
    scale: FloatArray | float = 1.0


def rainflow_of_repeating_signals(signals: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Rainflow cycles of many signals (rows, t) at once, each repeating for ever.

    Returns
    -------
    amplitude, mean : (rows, k)
        One cycle each; amplitudes are 0 where a row has fewer than others. The same cycles as
        `rainflow(row, rule=repeating)`: a signal that repeats is counted from its highest
        point on, where no cycle stays open but the largest. ASTM E1049-85, section 5.4.5.
    """
    x = np.asarray(signals, dtype=float)
    rows, t = x.shape
    start = x.argmax(axis=1)
    if (close := compiled_repeating_signal_cycle_counter()) is not None:
        # Cycle by cycle: most rows have few, and memory that is not written costs nothing.
        amplitude, mean = np.zeros((2, t // 2 + 2, rows)).mT
        most = close(x, start, amplitude, mean)
        return amplitude[:, :most], mean[:, :most]
    x = np.take_along_axis(x, (start[:, None] + np.arange(t + 1)) % t, axis=1)
    # Reversals, pressed together to the left; what is left of a row repeats its end.
    step = np.sign(np.diff(x, axis=1))
    last = np.maximum.accumulate(np.where(step != 0, np.arange(t), 0), axis=1)
    step = np.take_along_axis(step, last, axis=1)
    turns = np.ones((rows, t + 1), dtype=bool)
    turns[:, 1:-1] = step[:, 1:] * step[:, :-1] < 0
    place = np.cumsum(turns, axis=1) - 1
    most = int(place[:, -1].max(initial=0)) + 1
    reversals = np.repeat(x[:, -1:], most, axis=1)
    row, column = np.nonzero(turns)
    reversals[row, place[row, column]] = x[row, column]
    size = place[:, -1] + 1

    stack, depth = np.zeros((rows, most + 1)), np.zeros(rows, dtype=np.int64)
    first, second = np.zeros((2, rows, max(most // 2, 1)))
    closed = np.zeros(rows, dtype=np.int64)
    for k in range(most):
        here = np.flatnonzero(k < size)
        stack[here, depth[here]] = reversals[here, k]
        depth[here] += 1
        while True:
            here = here[depth[here] >= 4]
            if not here.size:
                break
            n = depth[here]
            a, b, c, d = (stack[here, n - j] for j in (4, 3, 2, 1))
            inner = np.abs(c - b)
            here = here[shut := (inner <= np.abs(b - a)) & (inner <= np.abs(d - c))]
            first[here, closed[here]], second[here, closed[here]] = b[shut], c[shut]
            closed[here] += 1
            stack[here, depth[here] - 3] = d[shut]
            depth[here] -= 2
    # What stays open is the largest cycle: from the highest point down and back.
    open_ = depth >= 2
    at = closed[open_]
    first[open_, at], second[open_, at] = stack[open_, 0], stack[open_, 1]
    return np.abs(first - second) / 2, (first + second) / 2


def plane_directions(normals: ArrayLike, *, planes: int = PLANE_COUNT) -> FloatArray:
    """Directions (m, planes, 3) in the surfaces square to normals (m, 3), evenly spread."""
    n = np.asarray(normals, dtype=float)
    aside = np.eye(3)[np.abs(n).argmin(axis=1)]
    u = np.cross(n, aside)
    u /= np.maximum(np.linalg.norm(u, axis=1, keepdims=True), 1e-300)
    v = np.cross(n, u)
    angle = np.pi * np.arange(planes) / planes
    return np.cos(angle)[:, None] * u[:, None] + np.sin(angle)[:, None] * v[:, None]


def mohr_components(unit: ArrayLike, normals: ArrayLike) -> FloatArray:
    """Return what unit stresses (m, c, 6) are in surfaces square to normals (m, 3), (m, 3, c) Pa.

    The middle of Mohr's circle and the two legs of its radius: on a plane turned by φ normal stress
    is the first, plus cos 2φ times the second, plus sin 2φ times the third.
    """
    one, up, other, down = np.moveaxis(
        normal_stress_on_planes(unit, plane_directions(normals, planes=4)), 1, 0
    )
    return np.stack([one + other, one - other, up - down], axis=1) / 2


def normal_stress_on_planes(unit: ArrayLike, directions: ArrayLike) -> FloatArray:
    """Return normal stress (m, planes, c) Pa of unit stresses (m, c, 6) along (m, planes, 3)."""
    x, y, z = np.moveaxis(np.asarray(directions, dtype=float), -1, 0)
    squares = np.stack([x * x, y * y, z * z, 2 * x * y, 2 * y * z, 2 * z * x], axis=-1)
    return squares @ np.asarray(unit, dtype=float).mT


def mean_and_amplitude(stress: FloatArray, loads: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return mean and amplitude (m, planes) Pa of unit stresses (m, planes, c) under loads (t, c).

    Of the whole history: its largest cycle. Of a long one the moments that go farthest are
    evaluated first, and all of them where one of the others may go farther.
    """
    every = stress.reshape(-1, stress.shape[-1])
    top, low = (of.reshape(stress.shape[:2]) for of in _stress_extremes(every, loads))
    return (top + low) / 2, (top - low) / 2


def _stress_extremes(stress: FloatArray, loads: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the highest and lowest (m,) Pa of unit stresses (m, c) under loads (t, c)."""
    if len(loads) <= 2 * _LONG_HISTORY_SAMPLES:
        return _stress_extremes_of_all(stress, loads)
    mean = loads.mean(axis=0)
    few, ways = extreme_load_vectors(loads, np.sqrt(np.mean(stress**2, axis=0)), about=mean)
    top, low = _stress_extremes_of_all(stress, few)
    middle = stress @ mean
    least = np.linalg.norm(stress @ ways, axis=1)
    left = np.flatnonzero(np.minimum(top - middle, middle - low) < least)
    top[left], low[left] = _stress_extremes_of_all(stress[left], loads) if len(left) else (0.0, 0.0)
    return top, low


def _stress_extremes_of_all(stress: FloatArray, loads: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the same, evaluated at every moment."""
    top, low = np.empty((2, len(stress)))
    for rows in _row_blocks(len(stress), len(loads)):
        history = loads @ stress[rows].T  # moments in rows: extremes of many planes at once
        top[rows], low[rows] = history.max(axis=0), history.min(axis=0)
    return top, low


def extreme_load_vectors(
    loads: FloatArray, worth: FloatArray | float = 1.0, *, about: FloatArray | float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Return the moments of loads (t, c) that lie farthest out, all of a short history.

    And ways (c, r) of which all others are `about` and a sum, each at most as large that their
    squares add up to 1: by the inequality of Cauchy and Schwarz what these make of a stress bounds
    it. Of a short history there are none.
    """
    if len(loads) <= 2 * _LONG_HISTORY_SAMPLES:
        return loads, np.zeros((loads.shape[1], 0))
    scale = np.broadcast_to(np.asarray(worth, dtype=float), loads.shape[1:])
    goes, size, ways = np.linalg.svd((loads - about) * scale, full_matrices=False)
    far = np.linalg.norm(goes, axis=1)
    order = np.argsort(-far)
    spread = (size[:, None] * ways / np.where(scale > 0, scale, np.inf)).T
    return loads[order[:_LONG_HISTORY_SAMPLES]], far[order[_LONG_HISTORY_SAMPLES]] * spread


@dataclass(frozen=True)
class LoadEnvelope:
    """What holds all moments of a load history: a middle, and about it the sum of ellipsoids.

    Attributes
    ----------
    centre : (c,)
    axes : ((c, r), ...)
        Of each ellipsoid.
    max_cycles : (`CYCLE_SIZE_LEVEL_COUNT`,)
        More than any sum of the loads has in a pass, by the share of the reach that they go to at
        most: the last reach all of it, the first one level of it. A road all day long has as many
        small ones as samples, and few as large as its worst blow.
    """

    centre: FloatArray
    axes: tuple[FloatArray, ...]
    max_cycles: FloatArray

    @property
    def cycle_levels(self) -> tuple[tuple[float, float], ...]:
        """Shares of the reach, and how many cycles there may be of each."""
        return tuple(
            ((k + 1) / CYCLE_SIZE_LEVEL_COUNT, float(self.max_cycles[k]))
            for k in np.flatnonzero(self.max_cycles).tolist()
        )

    def mean_and_amplitude(self, stress: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return mean and amplitude (m,) Pa that harm as any cycle on any plane, or more.

        Of stresses (m, 3, c) `mohr_components`. No moment is higher or lower on a plane; and of
        cycles with one top the larger fares worse, of two as large the one about the higher mean.
        """
        size = np.zeros(len(stress))
        for axes in self.axes:
            middle, *legs = np.moveaxis(stress @ axes, 1, 0)
            size += np.linalg.norm(np.abs(middle) + np.hypot(*legs), axis=-1)
        middle, *legs = np.moveaxis(stress @ self.centre, 1, 0)
        return middle + np.hypot(*legs), size


def load_envelope(passes: FloatArray, worth: FloatArray | float = 1.0) -> LoadEnvelope:
    """Return what holds all moments of passes (p, t, c) of loads, each worth so much stress (c,).

    Of few orders each has its ellipse, which one order fills; else it is about the smallest
    ellipsoid. A sum of waves has no more cycles than its highest order. Else a cycle goes no
    farther than the farther of the two moments at its ends, and no moment ends two.
    """
    waves = np.fft.rfft(passes, axis=1) * 2 / passes.shape[1]
    orders = _present_orders(passes, worth)
    middles, cycles = passes.mean(axis=1), np.zeros(CYCLE_SIZE_LEVEL_COUNT)
    cycles[-1] = orders.max(initial=1)
    if len(orders) <= _MAX_SEPARATE_ORDERS:
        # Passes may differ in where their waves begin.
        spans = (waves[:, orders, :, None] * waves[:, orders, None].conj()).real
        if _all_equal(spans) and _all_equal(middles):
            axes = tuple(np.stack([w.real, w.imag], axis=-1) for w in waves[0, orders])
            return LoadEnvelope(middles[0], axes, cycles)
    middle, held, far = _enclosing_ellipsoid(passes.reshape(-1, passes.shape[-1]), worth)
    if (
        len(far) > CYCLE_SIZE_LEVEL_COUNT * cycles[-1]
    ):  # few orders in many samples are found better by these
        return LoadEnvelope(middle, (held,), cycles)
    level = np.minimum(np.ceil(far * CYCLE_SIZE_LEVEL_COUNT).astype(int), CYCLE_SIZE_LEVEL_COUNT)
    return LoadEnvelope(
        middle, (held,), np.bincount(level, minlength=CYCLE_SIZE_LEVEL_COUNT + 1)[1:].astype(float)
    )


def _all_equal(passes: FloatArray) -> bool:
    return np.allclose(
        passes, passes[0], atol=_MIN_WAVE_AMPLITUDE_RATIO * np.abs(passes).max(initial=0.0)
    )


def _enclosing_ellipsoid(
    points: FloatArray, worth: FloatArray | float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return middle (c,) and axes (c, r) of about the smallest ellipsoid that holds points (t, c).

    And how far each of them is (t,), 1 on its skin. Source: Khachiyan, Math. Oper. Res. 21 (1996)
    307.
    """
    scale = np.broadcast_to(np.asarray(worth, dtype=float), points.shape[1:])
    mean = points.mean(axis=0)
    goes, size, ways = np.linalg.svd((points - mean) * scale, full_matrices=False)
    kept = size > _MIN_WAVE_AMPLITUDE_RATIO * size[0]
    goes, n = goes[:, kept], int(kept.sum()) + 1
    back = size[kept, None] * ways[kept] / np.where(scale > 0, scale, np.inf)
    lifted = np.column_stack([goes, np.ones(len(points))])
    weight = np.full(len(points), 1 / len(points))
    for _ in range(_MAX_ELLIPSOID_ITERATIONS):
        out = ((lifted @ np.linalg.inv((lifted.T * weight) @ lifted)) * lifted).sum(axis=1)
        k = int(out.argmax())
        if out[k] <= n * (1 + _ELLIPSOID_TOLERANCE):
            break
        step = (out[k] - n) / (n * (out[k] - 1))
        weight *= 1 - step
        weight[k] += step
    middle = weight @ goes
    away = goes - middle
    axes = np.linalg.cholesky((away.T * weight) @ away)
    # Wherever the search ended, it is made as large as holds them all.
    far = np.sqrt((np.linalg.solve(axes, away.T) ** 2).sum(axis=0))
    axes *= far.max()
    return mean + middle @ back, (axes.T @ back).T, far / far.max()


def _largest_cycle_damage(
    stress: FloatArray, passes: Sequence[LoadHistory], harm: CycleDamageFunction
) -> tuple[FloatArray, FloatArray]:
    """Return damage (m, planes) of the largest cycle alone, and of as many as there may be.

    Of a pass no longer than a turn no plane suffers more than that: of cycles with one top the
    larger fares worse, of two as large the one about the higher mean.
    """
    # Of planes half a right angle apart the mean is that of all.
    worth = np.sqrt(np.mean(stress[:, :: max(stress.shape[1] // 4, 1)] ** 2, axis=(0, 1)))
    once, often = np.zeros(stress.shape[:2]), np.zeros(stress.shape[:2])
    for one in passes:
        more = np.broadcast_to(one.scale, len(stress))[:, None]
        loads = np.concatenate(one.loads)
        brief = one.loads.shape[1] <= _MAX_SHORT_PASS_SAMPLES
        mean, amplitude = mean_and_amplitude(
            stress, loads if brief else principal_extremes(loads, worth)
        )
        top, each = mean + amplitude, np.arange(len(stress))
        largest = one.repeats * harm(more * amplitude, more * mean, each)
        once += largest
        if not brief:
            often += np.inf
            continue
        count, rest = _bound_cycles(stress, one.loads, worth, amplitude)
        often += count * largest
        for size in rest:
            often += one.repeats * harm(more * size, more * (top - size), each)
    return once, often


def _bound_cycles(
    stress: FloatArray, passes: FloatArray, worth: FloatArray, largest: FloatArray
) -> tuple[int, list[FloatArray]]:
    """Return how many cycles of a pass may be as large as the largest; amplitudes of the others.

    Amplitudes (m, planes) Pa that none goes beyond, of stresses (m, planes, c) under passes
    (p, t, c), whose `largest` is known. There are no more than the highest order has; of few orders
    the k-th largest is at most a k-th of all together.
    """
    orders = _present_orders(passes, worth)
    count = int(orders.max(initial=1))
    if count == 1 or len(orders) > _MAX_SEPARATE_ORDERS:
        return count, []
    whole = _bound_travel(stress, passes, orders) / 4
    return 1, [np.minimum(largest, whole / k) for k in range(2, count + 1)]


def _bound_travel(stress: FloatArray, passes: FloatArray, orders: IntArray) -> FloatArray:
    """Return how far normal stress (m, planes) goes up and down in a pass, Pa, or more.

    Of stresses (m, planes, c) under passes (p, t, c) of few orders: a wave goes four times its
    amplitude each time it comes back, and a cycle four times its own.
    """
    waves = np.fft.rfft(passes, axis=1)[:, orders] * 2 / passes.shape[1]
    every, far = stress.reshape(-1, stress.shape[-1]), np.zeros(stress[..., 0].size)
    for wave in waves:
        size = np.sqrt((every @ wave.real.T) ** 2 + (every @ wave.imag.T) ** 2)
        far = np.maximum(far, 4 * size @ orders)
    return far.reshape(stress.shape[:2])


def _present_orders(passes: FloatArray, worth: FloatArray | float) -> IntArray:
    """Return which orders passes (p, t, c) have, (k,): a sum of them has no more cycles each."""
    size = (np.abs(np.fft.rfft(passes, axis=1)) * worth).max(axis=(0, 2))[1:]
    return np.flatnonzero(size > _MIN_WAVE_AMPLITUDE_RATIO * size.max(initial=0.0)) + 1


def principal_extremes(loads: FloatArray, worth: FloatArray | float = 1.0) -> FloatArray:
    """Return the moments of loads (t, c), each worth so much stress (c,), that go farthest.

    Along the ways of `along`.
    """
    gone = principal_load_projections(loads, worth)
    return loads[np.unique([gone.argmin(axis=0), gone.argmax(axis=0)])]


def principal_load_projections(
    loads: FloatArray, worth: FloatArray | float = 1.0, *, alike: bool = True
) -> FloatArray:
    """Return how far loads (t, c), each worth so much stress (c,), go, (t, ways).

    Along the three ways in which they vary most, and between them: a stress is nearly one of these.
    They are made `alike` in size, or left as much as they are worth.
    """
    weighed = (loads - loads.mean(axis=0)) * worth
    _, axes = np.linalg.eigh(weighed.T @ weighed)
    main = weighed @ axes[:, -_PRINCIPAL_LOAD_DIRECTIONS:]
    if alike:
        main /= np.maximum(main.std(axis=0), 1e-300)
    ways = list(product((-1, 0, 1), repeat=main.shape[1]))
    return main @ np.transpose(ways[len(ways) // 2 + 1 :])  # of a way and its opposite, one


def plane_damage(
    unit: ArrayLike,
    normals: ArrayLike,
    passes: Sequence[LoadHistory],
    *,
    harm: CycleDamageFunction,
    closely: float = MIN_FULL_COUNT_DAMAGE_SHARE,
    least: ArrayLike = 0.0,
) -> tuple[FloatArray, FloatArray]:
    """Damage at places of a surface, each on the plane that suffers most.

    Parameters
    ----------
    unit : (m, c, 6) Pa
        Stress of each unit load.
    normals : (m, 3)
        Of the surface.
    passes
        Histories of the loads; their damage adds up.
    harm
        Damage of cycles: S-N curve and mean-stress correction, of each place its own.
    closely
        Share of the worst place's damage below which the largest cycle alone is counted.
    least : (m,)
        Damage of each place up to which that is enough too: where all its cycles cannot do more.

    Returns
    -------
    damage : (m,)
    direction : (m, 3)
        Along which the stress acts that does it: a crack opens square to it.
    """
    directions = plane_directions(normals)
    stress = normal_stress_on_planes(unit, directions)
    rough, most = _largest_cycle_damage(stress, passes, harm)
    damage, best = rough.max(axis=1), rough.argmax(axis=1)
    # What breaks at once does endless damage, and no share of that is a number.
    share = closely * damage.max(initial=0.0) if closely else 0.0
    # Where each pass has one cycle and no more, that is all of them.
    more = (most > rough).any(axis=1) | any(len(one.loads) > 1 for one in passes)
    counts = np.flatnonzero((damage > share) & (most.max(axis=1) > least) & more)
    every, most = np.arange(len(counts)), most[counts]
    brief = np.isfinite(most).all()
    exact = np.full(most.shape, -1.0)
    asked = np.zeros(most.shape, dtype=bool)
    asked[every[:, None], np.argsort(-rough[counts], axis=1)[:, :_FIRST_COUNTED_PLANES]] = True
    asked[:, ::_COUNTED_PLANE_STRIDE] |= not brief
    while asked.any():
        row, plane = np.nonzero(asked)
        exact[asked] = _rainflow_damage(stress[counts[row], plane], counts[row], passes, harm)
        if brief:
            asked = most > exact.max(axis=1, initial=0.0)[:, None]
        else:  # one hard pull one way may hide the many that tire another
            asked = np.zeros(most.shape, dtype=bool)
            beside = exact.argmax(axis=1)[:, None] + np.arange(
                -_NEIGHBOUR_PLANES, _NEIGHBOUR_PLANES + 1
            )
            asked[every[:, None], beside % len(directions[0])] = True
        asked &= exact < 0
    damage[counts], best[counts] = exact.max(axis=1, initial=0.0), exact.argmax(axis=1)
    return damage, directions[np.arange(len(best)), best]


def _rainflow_damage(
    stress: FloatArray, at: IntArray, passes: Sequence[LoadHistory], harm: CycleDamageFunction
) -> FloatArray:
    """Return the damage (k,) of stresses (k, c) on planes of places (k,), every cycle counted."""
    found = np.zeros(len(stress))
    for one in passes:
        scale = np.asarray(one.scale)
        scaled = stress * (scale[at, None] if scale.ndim else scale)
        many, t, _ = one.loads.shape
        for rows in _row_blocks(
            len(at),
            many * t,
            most=_MEMORY_BLOCK_NUMBERS if t > _LONG_HISTORY_SAMPLES else _CACHE_BLOCK_NUMBERS,
        ):
            signals = scaled[rows] @ np.concatenate(one.loads).T
            amplitude, mean = (
                v.reshape(len(signals), many, v.shape[1])
                for v in rainflow_of_repeating_signals(signals.reshape(-1, t))
            )
            each = harm(amplitude, mean, at[rows]).sum(axis=-1).max(axis=-1)
            found[rows] += one.repeats * each
    return found


def _row_blocks(count: int, width: int, *, most: int = _CACHE_BLOCK_NUMBERS) -> list[slice]:
    """Return slices of `count` rows that hold no more than `most` numbers."""
    step = max(1, most // max(width, 1))
    return [slice(k, k + step) for k in range(0, count, step)]
