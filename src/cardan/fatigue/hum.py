"""Hum of the mains in a channel: a tone of 50 or 60 Hz that nothing of the vehicle moves.

The grid holds its frequency to some hundredths of a hertz, and what couples it into a wire
holds still. Met second by second at the mains' own frequency, hum is therefore one number
that hardly turns and hardly grows, which no shaft that is driven and no bracket that a road
shakes gives: in a second they are elsewhere. A machine driven by a motor on the mains is the
exception, which whoever measured it has to say: so it is a suspect, and nothing is taken off
unasked.
"""

from dataclasses import dataclass

import numpy as np

from cardan.base.arrays import ComplexArray, FloatArray

MAINS = (50.0, 60.0)
"""Frequencies of the world's grids, Hz."""
STRAYS = 0.1
"""Hz that a grid strays by at most; by 0.2 Hz it sheds load. ENTSO-E, System Operation Guideline
(2017), article 127."""
LEAST = 0.05
"""Amplitude over the channel's deviation from which hum is a suspect."""
LEAST_SECONDS = 8
"""Seconds in which a steady tone is told from one that passes."""


@dataclass(frozen=True, kw_only=True)
class Hum:
    """A tone of the mains in a channel, Re z(t) e^{2πift}.

    Attributes
    ----------
    frequency : Hz
        Of the grid.
    seconds : (m,) complex
        z in the middle of each second, in the channel's unit; straight between them.
    rate : Hz
        Of the channel's samples.
    """

    frequency: float
    seconds: ComplexArray
    rate: float

    @property
    def amplitude(self) -> float:
        """0-to-peak amplitude, rms over the time."""
        return float(np.sqrt(np.mean(np.abs(self.seconds) ** 2)))

    def at(self, start: int, n: int) -> FloatArray:
        """Return the tone (n,) from sample `start` on."""
        time = np.arange(start, start + n) / self.rate
        middle = np.arange(self.seconds.size) * (round(self.rate) / self.rate) + 0.5
        angle = 2 * np.pi * ((self.frequency * time) % 1.0)
        real, imag = (
            np.interp(time, middle, part) for part in (self.seconds.real, self.seconds.imag)
        )
        return real * np.cos(angle) - imag * np.sin(angle)


class Listener:
    """Meets a channel second by second at the mains' frequencies, and a hertz to either side."""

    def __init__(self, rate: float) -> None:
        self.rate, self.size = rate, max(round(rate), 1)
        self.mains = [f for f in MAINS if f + 1 < 0.5 * rate]
        self.met: list[ComplexArray] = []
        self.tail: FloatArray = np.empty(0)
        at = np.array([f + k for f in self.mains for k in (0, -1, 1)])
        time = np.arange(self.size) / rate
        self.table = np.exp(-2j * np.pi * np.outer(time, at)) * (2 / self.size)

    def add(self, x: FloatArray) -> None:
        """Take samples (n,) without holes."""
        if not self.mains:
            return
        whole = np.concatenate([self.tail, x]) if self.tail.size else x
        full = whole.size // self.size * self.size
        rows = whole[:full].reshape(-1, self.size)
        self.tail = whole[full:].copy()
        if len(rows):
            level = rows - rows.mean(-1, keepdims=True)
            self.met.append(np.asarray(level @ self.table, np.complex128))

    def found(self, *, deviation: float) -> Hum | None:
        """Return the hum in a channel of such a standard deviation; None without."""
        if not self.met:
            return None
        met = np.concatenate(self.met).reshape(-1, len(self.mains), 3)
        if len(met) < LEAST_SECONDS:
            return None
        # A second begins whole samples after the one before: where the tone is by then.
        begun = np.arange(len(met)) * self.size / self.rate
        for k, f in enumerate(self.mains):
            z = met[:, k, 0] * np.exp(-2j * np.pi * ((f * begun) % 1.0))
            power = np.abs(z) ** 2
            typical = float(np.median(power))
            beside = float(np.median(np.abs(met[:, k, 1:]) ** 2))
            turned = np.vdot(z[:-1], z[1:])
            still = abs(turned) > 0.9 * float(power.sum())
            grid = abs(np.angle(turned)) < 2 * np.pi * STRAYS
            even = float(np.quantile(power, 0.1)) > 0.5 * float(np.quantile(power, 0.9))
            loud = np.sqrt(typical) > LEAST * deviation and typical > 8 * beside
            if still and grid and even and loud:
                return Hum(frequency=f, seconds=z, rate=self.rate)
        return None
