"""Changes of a gauge's gain, by what it is held against: another gauge, or the shaft's torque.

Two channels that feel the same forces keep their ratio in each band of frequencies, as long as
nobody touches an amplifier. What shakes them may change, and with it the ratio in the bands that it
is heard in; but only a gain changes it in all of them at once, and by the same factor.
"""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from cardan.base.arrays import FloatArray, IntArray
from cardan.fatigue.fault import Places, places

SECONDS = 5.0
"""Length of a span in which channels are held against each other."""
BANDS, FEWEST = 4, 16
"""Octaves that have to agree, and the fewest differences in a span that say something of one."""
ALIKE = 0.6
"""Coherence from which two channels feel the same forces in a band."""
ABOUT, LEAST = 6, 3
"""Spans to either side that are held against each other, and the fewest."""
CHANGED, AGREED = 0.2, 0.25
"""Least change of the logarithm of a ratio, and how far bands may differ in it, relative to it; a
band that scatters by more than that says nothing."""


class Ratios:
    """Holds channels against each other, span by span: `add` each piece, then ask `found`."""

    def __init__(self, rate: float, count: int) -> None:
        self.size, self.count = max(round(SECONDS * rate), 1), count
        self.tail = np.empty((count, 0), np.float32)
        self.met: list[npt.NDArray[np.float32]] = []

    def add(self, x: FloatArray) -> None:
        """Take samples (channels, n) without holes."""
        if self.count < 2:
            return
        whole = np.concatenate([self.tail, x.astype(np.float32)], axis=-1, dtype=np.float32)
        full = whole.shape[-1] // self.size * self.size
        self.tail = whole[:, full:].copy()
        if not full:
            return
        rows = np.moveaxis(whole[:, :full].reshape(self.count, -1, self.size), 0, 1)
        bands: list[npt.NDArray[np.float32]] = []
        while rows.shape[-1] // 2 >= FEWEST:
            a, b, c, d = (rows[..., k : rows.shape[-1] - 3 + k : 2] for k in range(4))
            high, rows = (a - d + 3 * (c - b)) / 8, (a + d + 3 * (b + c)) / 8
            bands.append((high @ np.swapaxes(high, -1, -2)).astype(np.float32))
        if len(bands) >= BANDS:
            self.met.append(np.stack(bands, 1))

    def found(self) -> list[Places]:
        """Return where the gain of each channel changes, and by what factor.

        Of two that change against each other nobody knows which it was: either may be.
        """
        told: list[list[tuple[int, float]]] = [[] for _ in range(self.count)]
        if not self.met:
            return [places(()) for _ in told]
        met = np.concatenate(self.met)
        for i in range(self.count):
            for j in range(i):
                own, other, both = (
                    met[..., a, b].astype(float) for a, b in ((i, i), (j, j), (i, j))
                )
                for at, factor in changes(own, other, both):
                    told[i].append((at, factor))
                    told[j].append((at, 1 / factor))
        return [self._places(one) for one in _accused(told)]

    def _places(self, told: Sequence[tuple[int, float]]) -> Places:
        once: list[tuple[int, float]] = []
        for k, factor in sorted(told):
            if not once or k - once[-1][0] > LEAST:
                once.append((k, factor))
        at = [k * self.size for k, _ in once]
        return places([(k, k + 1) for k in at], [factor for _, factor in once])


def _accused(told: list[list[tuple[int, float]]]) -> list[list[tuple[int, float]]]:
    """Keep of each channel the changes that no other shows against more channels."""

    def heard(one: list[tuple[int, float]], at: int) -> int:
        return sum(abs(k - at) <= LEAST for k, _ in one)

    return [
        [c for c in one if heard(one, c[0]) >= max(heard(other, c[0]) for other in told)]
        for one in told
    ]


def changes(own: FloatArray, other: FloatArray, both: FloatArray) -> list[tuple[int, float]]:
    """Return the spans before which a ratio changes in all bands, and by what factor.

    Powers of two channels in spans and bands (m, b), and what they have in common.
    """
    if len(own) < 2 * LEAST:
        return []
    with np.errstate(divide="ignore", invalid="ignore"):
        known = both**2 > ALIKE * own * other
        ratio = np.where(known, np.log(own / other) / 2, np.nan)
        sign = np.where(known, np.sign(both), np.nan)
    pad = np.full((ABOUT, own.shape[-1]), np.nan)

    def windows(x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return what lies before and behind each span, (m - ABOUT + 1, b, ABOUT)."""
        every = np.lib.stride_tricks.sliding_window_view(np.vstack([pad, x, pad]), ABOUT, axis=0)
        return every[:-ABOUT], every[ABOUT:]

    (before, n), (behind, m) = map(_median, windows(ratio))
    heard = (n >= LEAST) & (m >= LEAST)
    change = np.where(heard, behind - before, np.nan)
    scatter = np.maximum(
        *(_median(np.abs(w - mid[..., None]))[0] for w, mid in zip(
            windows(ratio), (before, behind), strict=True)
        )
    )  # fmt: skip
    bar = AGREED * np.abs(_median(change)[0])
    change = np.where(scatter < bar[:, None], change, np.nan)  # else it says nothing
    middle, bands = _median(change)
    off = np.where(np.isnan(change), 0.0, np.abs(change - middle[:, None])).max(-1)
    by = np.where((bands >= BANDS) & (np.abs(middle) > CHANGED) & (off <= bar), middle, 0.0)
    turned = np.multiply(*(_median(w)[0] for w in windows(sign)))
    over = (~heard | (turned < 0)).all(-1) & (heard.sum(-1) >= BANDS)
    # The median is as large some spans before and behind: it changes where the mean does most.
    full = np.abs(np.nan_to_num(_mean(windows(ratio)[1]) - _mean(windows(ratio)[0]))).mean(-1)
    kept: list[tuple[int, float]] = []
    for k in np.argsort(-full - 10 * over, kind="stable"):
        factor = (-1 if over[k] else 1) * float(np.exp(by[k]))
        if factor != 1 and all(
            abs(k - one) >= (ABOUT if (factor > 1) == (other > 1) else LEAST) for one, other in kept
        ):
            kept.append((int(k), factor))
    return sorted(kept)


def _mean(x: FloatArray) -> FloatArray:
    """Return the mean along the last axis without what is unknown (nan), nan of nothing."""
    known = ~np.isnan(x)
    total = np.where(known, x, 0.0).sum(-1)
    return np.where(known.any(-1), total / np.maximum(known.sum(-1), 1), np.nan)


def _median(x: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the median along the last axis without what is unknown, and how many it is of."""
    count = x.shape[-1] - np.isnan(x).sum(-1)
    order = np.sort(x, axis=-1)
    low, high = (
        np.take_along_axis(order, np.maximum(k, 0)[..., None], -1)[..., 0]
        for k in ((count - 1) // 2, np.minimum(count // 2, x.shape[-1] - 1))
    )
    return np.where(count > 0, (low + high) / 2, np.nan), count
