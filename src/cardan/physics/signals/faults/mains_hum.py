"""Hum of the mains in a channel: 50 or 60 Hz or a few times that, that nothing of it moves.

The grid holds its frequency to some hundredths of a hertz, and what couples it into a wire
holds still. Met second by second at the mains' own frequency, hum is therefore one number
that hardly turns and hardly grows, which no shaft that is driven and no bracket that a road
shakes gives: in a second they are elsewhere. A machine driven by a motor on the mains is the
exception, which the user has to declare: so the tone is a suspect, and is not removed
without a rule.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cardan.core.arrays import ComplexArray, FloatArray, IntArray
from cardan.physics.signals.faults.fault_kind import (
    ChannelStatistics,
    FaultKind,
    FaultSource,
    SignalBlock,
)

FAULT_HUM = "hum"

MAINS_FREQUENCIES_HZ = (50.0, 60.0)
"""Frequencies of the world's grids, Hz."""
MAINS_HARMONICS = (1, 2, 3, 4, 5, 6)
"""Of them, that what hangs on the grid hums at: transformers and rectifiers at 100 and 300 Hz."""
MAINS_FREQUENCY_TOLERANCE_HZ = 0.1
"""Hz that a grid strays by at most; by 0.2 Hz it sheds load. ENTSO-E, System Operation Guideline
(2017), article 127."""
MIN_HUM_AMPLITUDE_TO_DEVIATION_RATIO = 0.05
"""Amplitude over the channel's deviation from which hum is a suspect."""
MIN_STEADY_S, MIN_TOTAL_HUM_S = 8, 20
"""Seconds in which a steady tone is distinguished from one that passes, and of which it has to be
there in all, or in the whole recording: at cruise an order of a shaft holds still for some."""

SECONDS_PER_BLOCK = 256
"""Seconds that are held until it is known which tones stand still."""


@dataclass(frozen=True, kw_only=True)
class MainsHum:
    """Tones of the mains in a channel, Σ Re z(t) e^{2πift}.

    Attributes
    ----------
    frequencies : (k,) Hz
        Of the grid and its harmonics.
    phasors : (k, m) complex
        z in the middle of each second, in the channel's unit, zero where it does not hum;
        straight between them.
    rate : Hz
        Of the channel's samples.
    """

    frequencies: tuple[float, ...]
    phasors: ComplexArray
    rate: float

    @property
    def size(self) -> float:
        """0-to-peak amplitude of the largest, rms over the time in which it hums."""
        power = np.abs(self.phasors) ** 2
        return float(np.sqrt((power.sum(-1) / np.maximum((power > 0).sum(-1), 1)).max()))

    @property
    def details(self) -> dict[str, object]:
        """Frequencies that it hums at."""
        return {"frequencies": self.frequencies}

    def removed_from(self, x: FloatArray, start: int) -> FloatArray:
        """Return samples (n,) from `start` on without it."""
        return x - self.waveform(start, x.size)

    def waveform(self, start: int, n: int) -> FloatArray:
        """Return the tones (n,) from sample `start` on."""
        time = np.arange(start, start + n) / self.rate
        middle = np.arange(self.phasors.shape[-1]) * (round(self.rate) / self.rate) + 0.5
        total = np.zeros(n)
        for f, z in zip(self.frequencies, self.phasors, strict=True):
            angle = 2 * np.pi * ((f * time) % 1.0)
            real, imag = (np.interp(time, middle, part) for part in (z.real, z.imag))
            total += real * np.cos(angle) - imag * np.sin(angle)
        return total


class MainsHumDetector:
    """Meets a channel second by second at the mains' frequencies, and a hertz to either side."""

    def __init__(self, rate: float) -> None:
        self.rate, self.size = rate, max(round(rate), 1)
        each = {
            f * k: k
            for k in MAINS_HARMONICS
            for f in MAINS_FREQUENCIES_HZ
            if f * k + 1 < 0.5 * rate
        }
        self.mains = sorted(each.items())
        self.tail: FloatArray = np.empty(0)
        self.met = np.empty((0, len(self.mains), 3), complex)
        self.seconds = 0
        self.steady: list[list[_SteadyTone]] = [[] for _ in self.mains]
        self.at = np.array([f + k for f, _ in self.mains for k in (0, -1, 1)])

    def update(self, block: SignalBlock) -> None:
        """Take a piece."""
        if not self.mains:
            return
        x = block.filled_samples
        whole = np.concatenate([self.tail, x]) if self.tail.size else x
        full = whole.size // self.size * self.size
        rows = whole[:full].reshape(-1, self.size)
        self.tail = whole[full:].copy()
        if len(rows):
            met = (self._lines(rows) * (2 / self.size)).reshape(-1, len(self.mains), 3)
            self.met = np.concatenate([self.met, met])
            self.seconds += len(met)
        if len(self.met) >= SECONDS_PER_BLOCK:
            self._hear()

    def _hear(self) -> None:
        """Keep of what was met the seconds that stand still: of a day few, if nothing hums."""
        # A second begins whole samples after the one before: where the tone is by then.
        first = self.seconds - len(self.met)
        begun = (first + np.arange(len(self.met))) * self.size / self.rate
        f, k = np.array(self.mains).T
        z = self.met[..., 0] * np.exp(-2j * np.pi * ((f * begun[:, None]) % 1.0))
        beside = (np.abs(self.met[..., 1:]) ** 2).mean(-1)
        for book, one in zip(
            self.steady,
            _find_steady_tones(z, beside, first, k * MAINS_FREQUENCY_TOLERANCE_HZ),
            strict=True,
        ):
            book.append(one)
        self.met = self.met[len(self.met) - (MIN_STEADY_S - 1) :].copy()

    def _lines(self, rows: FloatArray) -> ComplexArray:
        """Return the spectrum (seconds, tones) of seconds (seconds, n) at the tones looked for."""
        if self.rate == self.size:  # of whole seconds they are lines of its transform
            return np.fft.rfft(rows, axis=-1)[:, self.at.astype(np.intp)]
        turning = np.exp(-2j * np.pi * np.outer(np.arange(self.size) / self.rate, self.at))
        return (rows - rows.mean(-1, keepdims=True)) @ turning

    def result(self, of: ChannelStatistics) -> dict[str, MainsHum]:
        """Return the hum that is loud compared with the channel's deviation, if there is one."""
        hum = self.hum(deviation=of.deviation)
        return {} if hum is None else {FAULT_HUM: hum}

    def hum(self, *, deviation: float) -> MainsHum | None:
        """Return the hum in a channel of such a standard deviation; None without."""
        if self.seconds < MIN_STEADY_S:
            return None
        if len(self.met) >= MIN_STEADY_S:
            self._hear()
        loudest: dict[float, ComplexArray] = {}
        for (f, _), steady in zip(self.mains, self.steady, strict=True):
            z, hums = np.zeros(self.seconds, complex), np.zeros(self.seconds, bool)
            for one in steady:
                loud = one.begins[
                    one.typical > (MIN_HUM_AMPLITUDE_TO_DEVIATION_RATIO * deviation) ** 2
                ]
                hums[(loud[:, None] + np.arange(MIN_STEADY_S)).ravel()] = True
                z[one.at] = one.z
            if hums.sum() >= min(MIN_TOTAL_HUM_S, self.seconds):
                loudest[f] = np.where(hums, z, 0.0)
        if not loudest:
            return None
        return MainsHum(
            frequencies=tuple(loudest), phasors=np.stack(list(loudest.values())), rate=self.rate
        )


@dataclass(frozen=True)
class _SteadyTone:
    """Where a tone stands as the mains do, for `MIN_STEADY_S` from each second it `begins`.

    Attributes
    ----------
    begins, typical : (k,)
        Those seconds, and the tone's median power in the time from each on.
    at, z : (m,)
        The seconds of these times, and the tone in each.
    """

    begins: IntArray
    typical: FloatArray
    at: IntArray
    z: ComplexArray


def _find_steady_tones(
    z: ComplexArray, beside: FloatArray, first: int, strays: FloatArray
) -> Iterator[_SteadyTone]:
    """Yield where each of tones z (m, tones), from second `first` on, stands as the mains do.

    `beside` (m, tones) is the power of what is near it, `strays` (tones,) Hz how far it may be off.
    """
    power, turned = np.abs(z) ** 2, z[1:] * np.conj(z[:-1])

    def over(x: np.ndarray, size: int = MIN_STEADY_S) -> np.ndarray:
        return np.lib.stride_tricks.sliding_window_view(x, size, axis=0)

    own, turn = over(power), over(turned, MIN_STEADY_S - 1).sum(-1)
    still = np.abs(turn) > 0.93 * own[..., 1:].sum(-1)
    # Few: the costly test is run on them alone.
    begins, tone = np.nonzero(still & (np.abs(np.angle(turn)) < 2 * np.pi * strays))
    low, typical, high = np.quantile(own[begins, tone], [0.1, 0.5, 0.9], axis=-1)
    loud = typical > 8 * np.median(over(beside)[begins, tone], axis=-1)
    loud &= low > 0.5 * high
    for k in range(strays.size):
        mine = loud & (tone == k)
        at = np.unique(begins[mine, None] + np.arange(MIN_STEADY_S))
        yield _SteadyTone(first + begins[mine], typical[mine], first + at, z[at, k])


FAULT_SOURCE = FaultSource(
    kinds=(FaultKind(code=FAULT_HUM, correctable=True),), detector=MainsHumDetector
)
