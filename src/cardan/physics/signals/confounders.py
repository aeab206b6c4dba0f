"""What else a stress holds near a shaft's order, and what else may turn as the shaft does."""

from collections.abc import Sequence

import numpy as np

from cardan.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from cardan.physics.signals.order_kernels import running_mean, unit_phasor_of_turns
from cardan.physics.signals.order_tracking import ShaftRotation
from cardan.physics.signals.speed_alignment import (
    MIN_ORDER_FREQUENCY_HZ,
    SampledShaftMotion,
    remove_running_mean,
)

MIN_HIGH_TORQUE_SHARE_OF_MAX = 0.5
"""Of the largest torque, from which it is strong."""
MIN_IMPACT_CREST_FACTOR = 1.8
"""Of what half seconds within ten usually reach, from which one holds a blow."""
MIN_IMPACT_TO_MEAN_ORDER_2_POWER_RATIO = 2.0
"""Of its mean power, that order 2 must have where blows come for these to be its own."""
MIN_IMPACTS = 4
"""From which they are more than chance."""
MIN_CREST_TO_ORDER_2_POWER_CORRELATION = 0.5
"""Correlation from which crests go with order 2: lines without joint damage had 0.31."""
MIN_TORQUE_CORRELATION = 0.4
"""Correlation from which crests go with the torque, or without a measured one with order 2: 13
lines on a stop with missed joint damage had 0.28 to 0.85, 3 % of 168 without it had more.
"""
FOUR_CYLINDER_FIRING_ORDER = 2.0
"""Order of an engine that in direct gear turns as the joints do."""
ROTATION_ORDER = 1.0
"""First order, which every rotor or crankshaft excites, listed among its orders or not."""
IDLE_SPEED_REV_PER_S = 8.0
"""Turns a second below which no engine turns with the shaft: 480 rpm, where it would stall."""
DISENGAGED_TO_IDLE_SPEED_RATIO = 0.85
"""Of that, below which it has let go of the shaft, and takes hold of it elsewhere next time."""
MIN_EFFECTIVE_CLUTCH_ENGAGEMENTS = 1.5
"""Of equal weight above idle, needed to estimate what they have in common."""
MAX_CHANCE_PROBABILITY = 2e-3
"""Chance at which an engine's spells may agree as far: below it they are no evidence."""
MIN_ENGAGEMENT_PHASE_SCATTER_RAD = 0.03
"""Angle, rad, to which spells of a shaft's own agree, whose joints ride: nearer is chance."""
MIN_ORDER_DISTANCE_HZ = 9.0
"""Hz from order 2 at which half a second does not show it any more."""


def bump_stop_impacts(rest: FloatArray, wave: ComplexArray, rate: float) -> BoolArray:
    """Return the half seconds (n,) of blows, if they come where a wave is loud; else none.

    A stop that the bracket reaches when order 2 swings it knocks of everything that swings
    then, and no line explains a knock; a pothole does not wait for order 2. Where it knocks all
    the time no half second stands out, but all crests rise and fall with the wave.
    """
    from scipy.ndimage import median_filter

    n = max(round(0.5 * rate), 1)
    m = rest.size // n
    found = np.zeros(rest.size, bool)
    if m < 2 * MIN_IMPACTS:
        return found
    crest = np.abs(remove_running_mean(rest, rate)[: m * n]).reshape(m, n).max(-1)
    loud = (np.abs(wave[: m * n]) ** 2).reshape(m, n).mean(-1)
    blow = crest > MIN_IMPACT_CREST_FACTOR * median_filter(crest, size=41)
    if (
        np.count_nonzero(blow) >= MIN_IMPACTS
        and loud[blow].mean() > MIN_IMPACT_TO_MEAN_ORDER_2_POWER_RATIO * loud.mean()
    ):
        found[: m * n] = np.repeat(blow, n)
    high, wide = crest - crest.mean(), loud - loud.mean()
    if high @ wide > MIN_CREST_TO_ORDER_2_POWER_CORRELATION * np.sqrt(
        (high @ high) * (wide @ wide)
    ):
        found[: m * n] |= np.repeat(loud > MIN_IMPACT_TO_MEAN_ORDER_2_POWER_RATIO * loud.mean(), n)
    return found


def torque_correlation(
    swings: FloatArray, pull: FloatArray, turning: BoolArray, rate: float
) -> float:
    """Correlation of the crests of half seconds of a stress (n,) with a pull (n,), under way.

    No road knows the torque. Where a line stands on its stop all the time nothing is locked to
    its angle and no blow stands out, but it knocks the harder the more the joints pull. nan where
    that is undetermined.
    """
    n = max(round(0.5 * rate), 1)
    m = swings.size // n
    crest = np.abs(swings[: m * n]).reshape(m, n).max(-1)
    mean, turns = (np.asarray(v[: m * n], float).reshape(m, n).mean(-1) for v in (pull, turning))
    crest, mean = crest[turns > 0.5], mean[turns > 0.5]
    if crest.size < 2 * MIN_IMPACTS or not (np.ptp(crest) > 0 and np.ptp(mean) > 1e-6 * mean.max()):
        return float("nan")
    return float(np.corrcoef(crest, mean)[0, 1])


def high_torque_mask(load: FloatArray, rate: float) -> BoolArray:
    """Return when a torque (n,) is near its largest, with half a second to either side."""
    from scipy.ndimage import maximum_filter1d

    size = maximum_filter1d(np.abs(load), max(round(rate), 1), mode="nearest")
    return size > MIN_HIGH_TORQUE_SHARE_OF_MAX * size.max()


def engine_order_overlap(
    scene: SampledShaftMotion,
    engine: ShaftRotation | None,
    orders: Sequence[float],
    time: FloatArray,
) -> BoolArray | None:
    """Return where an engine order may run with order 2 (n,); None where hardly any does.

    An unmeasured engine may do so above its idle speed, if it has four cylinders. One that
    turns twice as fast as the shaft does so by its own turning.
    """
    if engine is None:
        return above_idle(scene) if FOUR_CYLINDER_FIRING_ORDER in orders else None
    close = order_overlap(scene, engine, (ROTATION_ORDER, *orders), time, within=0.5)
    turning = scene.speed > MIN_ORDER_FREQUENCY_HZ / 2
    return close if turning.any() and np.mean(close[turning]) >= 0.2 else None


def order_overlap(
    scene: SampledShaftMotion,
    engine: ShaftRotation,
    orders: Sequence[float],
    time: FloatArray,
    *,
    within: float,
) -> BoolArray:
    """Return where an order of a measured engine runs within some Hz of order 2 (n,)."""
    fe = engine.speed(time)
    f2 = 2 * scene.speed
    # Its channel lags: while the speed changes, what runs as one looks some per cent apart.
    near = np.maximum(within, 0.03 * f2)
    beside = np.any([np.abs(k * fe - f2) < near for k in orders], axis=0)
    return (scene.speed > MIN_ORDER_FREQUENCY_HZ / 2) & beside


def above_idle(scene: SampledShaftMotion) -> BoolArray:
    """Return where an engine may turn with the shaft (n,): from idle up, until it lets go."""
    says = np.where(
        scene.speed > IDLE_SPEED_REV_PER_S,
        1,
        np.where(scene.speed < DISENGAGED_TO_IDLE_SPEED_RATIO * IDLE_SPEED_REV_PER_S, -1, 0),
    )
    last = np.maximum.accumulate(np.where(says != 0, np.arange(says.size), 0))
    return says[last] > 0


def smooth_share_over_one_second(share: FloatArray | BoolArray, rate: float) -> FloatArray:
    """Return a share (n,) that goes over a second from one value to the next."""
    return running_mean(np.asarray(share, float), max(round(0.5 * rate), 1))


def order_share_not_from_engine(
    may: BoolArray, wave: ComplexArray, y: FloatArray, *, stretch: IntArray, turns: FloatArray,
    given: FloatArray,
) -> FloatArray:  # fmt: skip
    """Share (n,) of an order's wave that is no engine's, though one `may` (n,) do the same.

    Where it does it is locked to the shaft as the joints are; but whenever it has let go it
    takes hold of it at another angle. So what all spells have in common is the shaft's own, as
    far as they show: those within one stretch (n,) of the angle, for each stretch has been turned
    until it fits the others, and where that is more than chance makes of angles, at the speed as
    `given` (n,) turns or at the best of all its ratios, that of the wave's turns (n,).
    """
    share = np.where(may, 0.0, 1.0)
    spell: IntArray = np.cumsum(np.diff(may, prepend=False) & may, dtype=np.int64)
    locked = np.asarray(2 * y * np.conj(wave), np.complex128)
    power, back = np.abs(wave) ** 2, np.exp(4j * np.pi * (turns - given))
    for one in np.unique(stretch[may]):
        here = may & (stretch == one)
        share[here] = _common_share(spell[here], locked[here], power[here], turns[here], back[here])
    return share


def _common_share(
    spell: IntArray, locked: ComplexArray, power: FloatArray, turns: FloatArray,
    back: ComplexArray,
) -> float:  # fmt: skip
    """Return the share that spells have in common of gains `locked` (n,) over `power` (n,).

    `back` (n,) turns them to the speed as it was given.
    """
    from scipy.special import stdtrit

    weight = np.bincount(spell, power)
    heard = weight > 0
    w = weight[heard] / max(float(weight.sum()), 1e-300)

    def gains(z: ComplexArray) -> tuple[ComplexArray, complex, float]:
        """Return each spell's gain, their mean, and how far apart their angles are, rad."""
        sums = np.bincount(spell, z.real) + 1j * np.bincount(spell, z.imag)
        gain = np.asarray(sums[heard] / weight[heard], np.complex128)
        mean = complex(w @ gain)
        return gain, mean, float(np.sqrt(w @ np.angle(gain * np.conj(mean)) ** 2))

    gain, mean, apart = gains(locked)
    many = 1 / max(float(w @ w), 1e-300)
    if many <= MIN_EFFECTIVE_CLUTCH_ENGAGEMENTS or not abs(mean) > 0:
        return 0.0
    own = np.bincount(spell, np.gradient(turns))[heard]
    middle = np.bincount(spell, turns)[heard] / np.bincount(spell)[heard]
    off = middle - w @ middle
    far = float(np.sqrt(w @ off**2) / max(float(w @ own), 1e-300))
    tried = (
        _chance_probability(gains(locked * back)[2], many),
        _chance_probability(apart, many, far=far),
    )
    if 2 * min(tried) > MAX_CHANCE_PROBABILITY:
        return 0.0
    # Along the mean lies half of the scatter of a complex number.
    scatter = float(w**2 @ np.abs(gain - mean) ** 2) * many / (many - 1) / 2
    doubt = float(stdtrit(2 * (many - 1), 0.95)) * np.sqrt(scatter) / abs(mean)
    return max(1.0 - doubt, 0.0)


def _chance_probability(apart: float, many: float, *, far: float | None = None) -> float:
    """Odds that so many angles by chance lie `apart` rad (rms) about their mean.

    Those that do fill a ball in the space of all angles against one. Where a ratio of the speed
    was sought that suits them it is a tube, for the ratio moves the angles along a line: as long
    as none turns a spell by more than a cycle in itself, and the spells lie so `far` (rms) from
    each other, in lengths of one.
    """
    from scipy.special import gamma

    radius = (
        np.hypot(apart, MIN_ENGAGEMENT_PHASE_SCATTER_RAD) * np.sqrt(many) / (2 * np.sqrt(np.pi))
    )
    free, length = (many - 1, 1.0) if far is None else (many - 2, 2 * far * np.sqrt(many))
    return float(np.sqrt(many) * length * radius**free / gamma(free / 2 + 1))


def near_order(
    x: FloatArray, scene: SampledShaftMotion, rate: float, *, span: float = 0.5, beside: float = 0.0
) -> FloatArray:
    """Return all (n,) that a span of some seconds holds near order 2: within 0.5/span Hz.

    Of the order, or of the band so many Hz `beside` it.
    """
    order = unit_phasor_of_turns(2 * scene.turns + beside / rate * np.arange(x.size))
    half = max(round(span / 2 * rate), 1)
    return 2 * (running_mean(remove_running_mean(x, rate) * np.conj(order), half) * order).real


def intermittent_energy_share(
    x: FloatArray, scene: SampledShaftMotion, rate: float, *, where: BoolArray | None = None
) -> float:
    """Share of the energy within 3 Hz of order 2 that is not there at other times.

    A road shakes a mode wherever the order is: what half-second periods show at a frequency is
    then how loud the road is, by how the bracket answers there. Both are taken from where the
    order is `MIN_ORDER_DISTANCE_HZ` off, and periods in which the level of the road is unknown
    are left out; nan if that is undetermined, at steady speed.

    To accuse, `where` (n,) it counts, only what rolls is compared with what rolls: a vehicle that
    stands has an idling engine and no road, and next to that every road came with the shaft.
    """
    n = max(2 * round(0.25 * rate), 8)
    if x.size < 8 * n:
        return float("nan")
    rows = np.lib.stride_tricks.sliding_window_view(x, n)[:: n // 2]
    level = (rows - rows.mean(-1, keepdims=True)) * np.hanning(n)
    order = 2 * scene.speed[n // 2 :: n // 2][: len(rows)]
    frequency = np.fft.rfftfreq(n, 1 / rate)
    use = (frequency > MIN_ORDER_FREQUENCY_HZ + 2) & (
        frequency < min(order.max() + 2 * MIN_ORDER_DISTANCE_HZ, 0.45 * rate)
    )
    power = np.abs(np.fft.rfft(level)[:, use]) ** 2
    off = np.abs(frequency[use] - order[:, None])
    far = off > MIN_ORDER_DISTANCE_HZ
    if where is not None:
        far &= order[:, None] > MIN_ORDER_FREQUENCY_HZ
    heard = far.sum(0) > 8
    far &= heard
    if not far.any() or not power[far].any():
        return float("nan")
    power = power / power[far].max()
    loud = np.ones(len(rows))
    answer: FloatArray = np.zeros(int(np.count_nonzero(use)))
    for _ in range(3):
        answer = (power / loud[:, None] * far).sum(0) / np.maximum(far.sum(0), 1)
        over = np.divide(power, answer, out=np.zeros_like(power), where=far & (answer > 0))
        loud = over.sum(1) / np.maximum(far.sum(1), 1)
        loud = np.maximum(loud, 1e-6 * loud.max())
    told = (far.sum(1) > 1) & (order > MIN_ORDER_FREQUENCY_HZ + 2)
    if where is not None:
        told &= where[n // 2 :: n // 2][: len(rows)]
    near = (off < 3) & heard & told[:, None]
    there = float(power[near].sum())
    return 1 - float((loud[:, None] * answer)[near].sum()) / there if there > 0 else float("nan")
