"""What comes back every half turn: its mean, its orders, its peak."""

import numpy as np

from cardan.core.arrays import ComplexArray, FloatArray, array_namespace
from cardan.core.lazy_dataclass import dataclass
from cardan.physics.kinematics.joint_chain import SAMPLES_PER_TURN


@dataclass(frozen=True)
class HalfTurnSeries:
    """A vector or a number that comes back every half turn.

    Attributes
    ----------
    waves : (..., K, m) complex
        Amplitudes c of the orders 0, 2, 4, ... of m components (x, y, z of a force; one of
        a torque): the value at θ is Re Σ c_j e^{2ijθ}.
    """

    waves: ComplexArray

    def values(self, samples: int = SAMPLES_PER_TURN) -> FloatArray:
        """Return the values at equally spaced angles of a turn, (..., samples, m)."""
        xp = array_namespace(self.waves)
        theta = 2 * np.pi * np.arange(samples) / samples
        phi = 2 * theta[:, None] * np.arange(self.waves.shape[-2])
        cos, sin = xp.asarray(np.cos(phi)), xp.asarray(np.sin(phi))
        return cos @ xp.real(self.waves) - sin @ xp.imag(self.waves)

    @classmethod
    def from_samples(cls, values: FloatArray) -> "HalfTurnSeries":
        """Return the cycle through values (..., samples, m) of even orders."""
        waves = np.fft.rfft(values, axis=-2)[..., ::2, :] * (2 / values.shape[-2])
        waves[..., 0, :] /= 2
        return cls(waves)

    @property
    def static(self) -> FloatArray:
        """Mean over the turn, (..., m)."""
        return array_namespace(self.waves).real(self.waves[..., 0, :])

    def order(self, k: int) -> ComplexArray:
        """Return the complex amplitude c of the part Re c e^{ikθ}, (..., m)."""
        if k % 2 or k // 2 >= self.waves.shape[-2]:
            return 0 * self.waves[..., 0, :]
        return self.waves[..., k // 2, :]

    def amplitude(self, k: int) -> FloatArray:
        """Return the 0-to-peak along the major axis of the ellipse of order k, (...)."""
        return semi_major_axis(self.order(k))

    @property
    def dynamic(self) -> FloatArray:
        """0-to-peak along the major axis of the order 2 ellipse, (...)."""
        return self.amplitude(2)

    @property
    def peak(self) -> FloatArray:
        """Largest size over the turn, (...): that of a turn without steps."""
        count = self.waves.shape[-2]
        n = 8 * count
        # The square is smooth where the value passes through zero; its size is not.
        square = np.sum(self.values(2 * n)[..., :n, :] ** 2, axis=-1)
        crest = (square >= np.roll(square, 1, -1)) & (square >= np.roll(square, -1, -1))
        # The highest sample may stand on the lower of two crests: climb both.
        phi = np.argsort(np.where(crest, square, -1.0), axis=-1)[..., -2:] * (2 * np.pi / n)
        k = np.arange(2 * count - 1)
        s = np.fft.rfft(square, axis=-1)[..., None, : len(k)] * (np.where(k, 2.0, 1.0) / n)
        for _ in range(4):
            wave = s * np.exp(1j * k * phi[..., None])
            slope, bend = -np.imag(wave) @ k, -np.real(wave) @ k**2
            step = -slope / np.where(bend < 0, bend, np.inf)
            phi = phi + np.clip(step, -np.pi / n, np.pi / n)
        top = np.sum(np.real(s * np.exp(1j * k * phi[..., None])), axis=-1)
        return np.sqrt(np.maximum(top.max(-1), square.max(-1)))


def semi_major_axis(amplitude: ComplexArray) -> FloatArray:
    """Return the longer half axis (...) of the ellipse Re c e^{iφ}, c (..., m) complex."""
    xp = array_namespace(amplitude)
    parts = xp.real(amplitude), xp.imag(amplitude)
    size2 = sum(p[..., k] ** 2 for p in parts for k in range(amplitude.shape[-1]))
    skew = sum(amplitude[..., k] ** 2 for k in range(amplitude.shape[-1]))
    return xp.sqrt((size2 + xp.abs(skew)) / 2)
