"""Changes of a gauge's gain at a break, found by linear prediction, without another gauge.

Filtered samples are predicted from those before them to some hundredths of their swing. Where the
gain changes at once, the next samples are off by what the old and the new gain make of the same
course: `PREDICTION_ORDER` errors that one factor, and perhaps another zero, explain to the noise.
Neither a blow nor a kerb does so. The prediction is autoregressive, its coefficients are by the
autocorrelation (Yule and Walker), at a suspect anew by least squares over both sides.
"""

from dataclasses import dataclass

import numpy as np

from cardan.core.arrays import BoolArray, FloatArray
from cardan.physics.signals.faults.fault_kind import SignalBlock
from cardan.physics.signals.faults.intervals import FaultIntervals, fault_intervals

SEARCH_ORDER, PREDICTION_ORDER = 10, 24
"""Samples that predict the next where suspects are looked for, a number that NumPy is quick with;
and at a suspect: the impulse response of a usual anti-alias filter, and more."""
WINDOW_SAMPLES, AUTOCORRELATION_PARTS, AUTOCORRELATION_SAMPLES = 16384, 8, 1024
"""Samples searched at once, and parts of them, each as loud as the others, and their samples, that
give the first prediction."""
SIDE_SAMPLES = 512
"""Samples before a break and behind that give its prediction, and the noise of either side."""
MARGIN = SIDE_SAMPLES + 3 * PREDICTION_ORDER
"""Samples at the ends of what is searched in which no break is found."""
RIDGE = 1e-10
"""Share of the power that is added as white noise: a tone alone is predicted without error."""
ERROR_BLOCK_SAMPLES, CELL_SAMPLES = 64, 8
"""Samples whose mean squared error is one number, and those whose sum is."""
MIN_ERROR_POWER_RATIO, MAX_SUSPECTS_PER_WINDOW, MAX_SUSPECTS = 4.0, 6, 48
"""Times the errors' usual power of the louder side, over the prediction's order, from which a place
is looked at, and the most places of a window and of a channel: those that stand out most."""
MAX_MISFIT, MAX_MISFIT_WITH_OTHER_NOISE, MAX_NOISE_LAG = 1.8, 1.3, 0.7
"""Power of the errors that a change leaves, in that of the noise. Of 357 true changes 98 % leave
less than 1.65, of 260 other places with large errors 1 in 20 less than 1.8. It has to be smaller if
the noise changes by less than three tenths of the gain's logarithm, as a converter's does."""
MIN_EVIDENCE = 60.0
"""F statistic of a change against none: other places that leave as little reach 15."""
MIN_EVIDENCE_AGAINST_ZERO_STEP = 40.0
"""F statistic of another gain and zero against another zero alone."""
MIN_GAIN_CHANGE_LN, MAX_NOISE_MISMATCH_LN = 0.15, 0.15
"""Logarithm of the least change of the gain where the zero stayed, and how far that of the noise
may be from it: where only the zero steps, the noise stays the same."""
MAX_JUMP_OF_KINK = 1.0
"""Jump of the value, in changes of the slope a sample, of a load whose slope alone changes: a rig
changes its amplitude where the load crosses zero."""
MAX_REVERSAL_RATIO = 1.35
"""How far a gain that turns a channel over, and leaves its noise as it was, may be off 1."""
MAX_GAIN_CHANGE = 20.0
"""Factor beyond which a channel is dead on one side."""


@dataclass(frozen=True)
class _Suspect:
    """A place from which on errors stand out.

    Attributes
    ----------
    ratio
        Power of the errors there, in that of the louder side.
    start
        Sample of the recording that `near` begins with.
    near
        Samples about it.
    """

    ratio: float
    start: int
    near: FloatArray


class GainBreakDetector:
    """Looks for breaks of the gain as a channel's pieces pass."""

    def __init__(self) -> None:
        self.start = 0
        self.tail: FloatArray = np.empty(0)
        self.missing: BoolArray = np.empty(0, bool)
        self.suspects: list[_Suspect] = []

    def update(self, block: SignalBlock) -> None:
        """Take the next piece."""
        self.tail = np.concatenate([self.tail, block.filled_samples])
        self.missing = np.concatenate([self.missing, np.isnan(block.samples)])
        first, whole = 0, WINDOW_SAMPLES + 2 * MARGIN
        while self.tail.size - first >= whole:
            self._search(first, first + whole)
            first += WINDOW_SAMPLES
        self.start += first
        self.tail, self.missing = self.tail[first:].copy(), self.missing[first:].copy()

    @np.errstate(all="ignore")  # of numbers near the largest nothing is found
    def _search(self, first: int, last: int) -> None:
        x, missing = self.tail[first:last], self.missing[first:last]
        by = _prediction_by_autocorrelation(x)
        for k, ratio in [] if by is None else _suspects(x, by):
            near = slice(
                k - PREDICTION_ORDER - SIDE_SAMPLES, k + 2 * PREDICTION_ORDER + SIDE_SAMPLES
            )
            if not missing[k - 2 * PREDICTION_ORDER : k + 3 * PREDICTION_ORDER].any():
                start = self.start + first + near.start
                self.suspects.append(_Suspect(ratio, start, x[near].copy()))
        self.suspects = sorted(self.suspects, key=lambda s: -s.ratio)[:MAX_SUSPECTS]

    def result(self) -> FaultIntervals:
        """Return the breaks, each by what the gain is multiplied there."""
        if self.tail.size:
            self._search(0, self.tail.size)
        found: dict[int, float] = {}
        for one in self.suspects:  # those that stand out most first
            change = _gain_change(one.near)
            at = one.start + change[0] if change else 0
            # What has a break next to it is compared with both its sides.
            if change and all(abs(at - other) > MARGIN for other in found):
                found[at] = change[1]
        return fault_intervals([(k, k + 1) for k in found], list(found.values()))


def _prediction_by_autocorrelation(x: FloatArray) -> FloatArray | None:
    """Return the filter (SEARCH_ORDER + 1,) that leaves the prediction errors of x (n,)."""
    from scipy.fft import irfft, next_fast_len, rfft
    from scipy.linalg import toeplitz

    size = min(AUTOCORRELATION_SAMPLES, x.size)
    starts = np.linspace(0, x.size - size, AUTOCORRELATION_PARTS).astype(np.intp)
    parts = x[starts[:, None] + np.arange(size)]
    parts -= parts.mean(-1, keepdims=True)
    n = next_fast_len(size + SEARCH_ORDER + 1, real=True)
    power = np.abs(rfft(parts * np.hanning(size), n)) ** 2
    total = power.sum(-1, keepdims=True)
    r = irfft((power[total[:, 0] > 0] / total[total[:, 0] > 0]).sum(0), n)[: SEARCH_ORDER + 1]
    return _prediction(toeplitz(r))


def _prediction_by_least_squares(parts: tuple[FloatArray, FloatArray]) -> FloatArray | None:
    """Return the same of higher order of two parts, each about its own mean."""
    rows = np.concatenate([_latest_first(x - x.mean()) for x in parts])
    return _prediction(rows.T @ rows)


def _prediction(products: FloatArray) -> FloatArray | None:
    """Return the same by the mean products (order + 1, order + 1) of samples; None of zeros."""
    size = float(products.trace())
    if not size > 0:
        return None
    products = products + RIDGE * size / len(products) * np.eye(len(products))
    return np.append(1.0, -np.linalg.solve(products[1:, 1:], products[1:, 0]))


def _latest_first(x: FloatArray) -> FloatArray:
    """Return each sample from `PREDICTION_ORDER` on, and those before it (k, order + 1)."""
    return np.lib.stride_tricks.sliding_window_view(x, PREDICTION_ORDER + 1)[:, ::-1]


def _errors(x: FloatArray, by: FloatArray) -> FloatArray:
    """Return the errors (n,) of a prediction of x (n,), zero where nothing predicts."""
    errors = np.convolve(x, by)[: x.size]
    errors[: by.size - 1] = 0.0
    return errors


def _suspects(x: FloatArray, by: FloatArray) -> list[tuple[int, float]]:
    """Return the samples from which on errors stand out of those on both sides, by how much."""
    blocks = x.size // ERROR_BLOCK_SAMPLES
    side = SIDE_SAMPLES // ERROR_BLOCK_SAMPLES
    inner = np.arange(side, blocks - side - 2)
    if x.size < 2 * MARGIN + ERROR_BLOCK_SAMPLES or not inner.size:
        return []
    errors = _errors(x - x.mean(), by)[: blocks * ERROR_BLOCK_SAMPLES]
    cells = np.einsum("ij,ij->i", *[errors.reshape(-1, CELL_SAMPLES)] * 2).astype(float)
    usual = cells.reshape(blocks, -1).sum(-1) / ERROR_BLOCK_SAMPLES
    level = np.median(np.lib.stride_tricks.sliding_window_view(usual, side - 1), axis=-1)
    louder = np.maximum(level[inner - side], level[inner + 2])
    ahead = np.convolve(cells, np.ones(PREDICTION_ORDER // CELL_SAMPLES))[-cells.size :]
    ahead = ahead.reshape(blocks, -1)[inner] / PREDICTION_ORDER
    ratio = ahead.max(-1) / np.maximum(louder, np.finfo(float).tiny)
    found: list[tuple[int, float]] = []
    for row in np.argsort(-ratio, kind="stable")[: 2 * MAX_SUSPECTS_PER_WINDOW].tolist():
        k = int(inner[row]) * ERROR_BLOCK_SAMPLES + CELL_SAMPLES * int(np.argmax(ahead[row]))
        apart = all(abs(k - other) > 2 * PREDICTION_ORDER for other, _ in found)
        if ratio[row] > MIN_ERROR_POWER_RATIO and apart and MARGIN <= k < x.size - MARGIN:
            found.append((k, float(ratio[row])))
    return found[:MAX_SUSPECTS_PER_WINDOW]


_ROW = np.arange(PREDICTION_ORDER)
_BEHIND = np.tri(PREDICTION_ORDER, PREDICTION_ORDER + 1, dtype=bool)
"""Samples behind a change, and which of those that predict them lie behind it as well."""


@np.errstate(all="ignore")
def _gain_change(near: FloatArray) -> tuple[int, float] | None:
    """Return from which sample on the gain changes in the middle of samples, and by what factor.

    Before it the prediction holds of the samples, behind it of `old` times them and a zero; the
    errors are normal, of the noise of their side. `old` is the reciprocal of the gain.
    """
    order, side = PREDICTION_ORDER, SIDE_SAMPLES
    end = side + 3 * order
    sides = near[:side], near[-side:]
    by = _prediction_by_least_squares(sides)
    if by is None:
        return None
    errors = _errors(near, by)
    levels = [float(part.mean() * by.sum()) for part in sides]
    noise = float(errors[order:side].std()), float(errors[end + order :].std())
    if not min(noise) > 0:
        return None
    at = np.arange(side, side + 2 * order + 1)
    rows = near[at[:, None, None] + _ROW[:, None] - np.arange(order + 1)]
    new = np.where(_BEHIND, rows, 0.0) @ by
    kept = errors[at[:, None] + _ROW] - levels[0] - new
    zero = np.cumsum(by)[:order]
    length = float(np.sqrt(zero @ zero))
    zero /= length
    apart = new - (new @ zero)[:, None] * zero, kept - (kept @ zero)[:, None] * zero
    old, squares, cost = _most_likely_factor(*apart, noise[0])
    before, behind = (np.append(0.0, np.cumsum((errors - level) ** 2)) for level in levels)
    louder = float(np.log(noise[1] / noise[0]))
    cost += (before[at] - before[side]) / noise[0] ** 2
    cost += (behind[end] - behind[at + order]) / noise[1] ** 2 + 2 * (end - order - at) * louder
    k = int(np.argmin(cost))
    unchanged, zero_only = (float(((of[0] + of[1])[k] ** 2).sum()) for of in ((new, kept), apart))
    if not _f_statistic(unchanged, squares[k], 2) > MIN_EVIDENCE:
        return None
    # Where the zero stayed, the size of the break is of the gain alone.
    one, rest, _ = (float(v[0]) for v in _most_likely_factor(new[[k]], kept[[k]], noise[0]))
    same_zero = (
        _misfit(rest, one, noise) < MAX_MISFIT
        and abs(louder) > MIN_GAIN_CHANGE_LN
        and abs(louder + np.log(abs(one))) < MAX_NOISE_MISMATCH_LN
    )
    size = float(np.log(abs(old[k])))
    noise_follows = abs(louder + size) < max(MAX_NOISE_LAG * abs(size), MAX_NOISE_MISMATCH_LN)
    other_zero = (
        _misfit(squares[k], old[k], noise)
        < (MAX_MISFIT if noise_follows else MAX_MISFIT_WITH_OTHER_NOISE)
        and _f_statistic(zero_only, squares[k], 1) > MIN_EVIDENCE_AGAINST_ZERO_STEP
        and (old[k] < 0 or abs(size) > MIN_GAIN_CHANGE_LN)
    )
    factor = one if same_zero else float(old[k])
    offset = 0.0 if same_zero else float(-(factor * new[k] + kept[k]) @ zero / length)
    bent = (1 - factor) * (near[at[k] + 1] - near[at[k]])
    torn = (1 - factor) * near[at[k]] - offset
    if not (same_zero or other_zero) or abs(torn - bent / 2) < MAX_JUMP_OF_KINK * abs(bent):
        return None
    gain = 1 / factor
    if not same_zero and abs(louder) < MAX_NOISE_MISMATCH_LN:
        gain = -1.0 if 1 / MAX_REVERSAL_RATIO < -gain < MAX_REVERSAL_RATIO else gain
    return (int(at[k]), gain) if 1 / MAX_GAIN_CHANGE < abs(gain) < MAX_GAIN_CHANGE else None


def _misfit(squares: float, old: float, noise: tuple[float, float]) -> float:
    """Return the power of the errors that a factor leaves, in that of the quieter side's noise."""
    return float(squares / (PREDICTION_ORDER - 2) / min(noise[0], abs(old) * noise[1]) ** 2)


def _most_likely_factor(
    new: FloatArray, kept: FloatArray, noise: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return factors f (k,) of rows (k, n) such that f new + kept is noise; and squares, cost.

    The cost is twice the negative logarithm of the likelihood. Of smaller factors the samples are
    the less likely, so that zero is none.
    """
    size, both, rest = (
        np.einsum("ij,ij->i", a, b) for a, b in ((new, new), (new, kept), (kept, kept))
    )
    size = np.maximum(size, 1e-12 * rest + np.finfo(float).tiny)
    count = new.shape[-1]
    root = np.sqrt(both**2 + 4 * size * count * noise**2)
    # Of the two extrema the one of the sign that the samples have brings the squares down more.
    factors = -(both + np.copysign(root, both)) / (2 * size)
    squares = size * factors**2 + 2 * both * factors + rest
    return factors, squares, squares / noise**2 - 2 * count * np.log(np.abs(factors))


def _f_statistic(without: float, squares: float, parameters: int) -> float:
    """Return the F statistic of parameters that bring a sum of squares down."""
    return (without - squares) / parameters / squares * (PREDICTION_ORDER - 2)
