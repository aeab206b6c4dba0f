# ruff: noqa: ARG001  (every fault is asked the same)
"""Recordings of two gauges and a torque, whole or spoiled in a known way.

Nothing of the program's analysis is in here. A truck launches, shifts, cruises on a road of all
frequencies, meets kerbs, clunks and lines that stick and slip; a bracket with modes feels it, two
gauges at it in their own measure, behind an anti-alias filter or none, in the steps of a
converter. `FAULTS` then spoil the first gauge: each is given the samples, their rate, how bad it
is from 0 to 1, and chance.
"""

from dataclasses import dataclass

import numpy as np
from adversarial import colour, oscillator, smooth
from scipy.signal import butter, sosfilt, sosfiltfilt

KINDS = ("road", "route", "launches", "quiet", "violent", "cruise", "stick-slip", "rig")


@dataclass
class Case:
    """A whole recording: gauges (2, n) MPa, torque (n,) N m, speed (n,) turns/s."""

    kind: str
    rate: float
    gauges: np.ndarray
    torque: np.ndarray
    speed: np.ndarray


def edge(t, at, rise):
    """A rise from 0 to 1 from `at` on, within `rise` seconds: a quarter of a turn each way."""
    return 0.5 - 0.5 * np.cos(np.pi * np.clip((t - at) / rise, 0, 1))


def held(rng, t, levels, shortest, longest, rise):
    """Levels held for some seconds each, with edges between them."""
    x, at, level = np.zeros(t.size), 0.0, 0.0
    while at < t[-1]:
        new = float(rng.choice(levels)) * rng.uniform(0.8, 1.2)
        x += (new - level) * edge(t, at, rng.uniform(*rise))
        level, at = new, at + rng.uniform(shortest, longest)
    return x


def blows(rng, t, rate, *, per_minute, size):
    """Half sines of 20 to 80 ms: kerbs and potholes."""
    x = np.zeros(t.size)
    for at in rng.uniform(0, t[-1], rng.poisson(per_minute * t[-1] / 60)):
        width = rng.uniform(0.02, 0.08)
        k = slice(int(at * rate), int((at + width) * rate) + 1)
        x[k] += rng.choice([-1, 1]) * size * rng.lognormal(0, 0.4) * np.sin(
            np.pi * np.clip((t[k] - at) / width, 0, 1)
        )  # fmt: skip
    return x


def clunks(rng, t, *, per_minute, size):
    """Backlash that is taken up: a force that is there within 4 to 15 ms, and is let go later."""
    x = np.zeros(t.size)
    for at in rng.uniform(0, t[-1], rng.poisson(per_minute * t[-1] / 60)):
        h = size * rng.normal()
        x += h * (edge(t, at, rng.uniform(0.004, 0.015)) - edge(t, at + rng.uniform(0.3, 3), 0.3))
    return x


def sticking(rng, t, size):
    """Force that creeps up and slips within 3 to 8 ms, again and again."""
    x, at = np.zeros(t.size), 0.0
    while at < t[-1]:
        last, h = at + rng.uniform(0.3, 2), size * rng.uniform(0.5, 1)
        x += h * (np.clip((t - at) / (last - at), 0, 1) - edge(t, last, rng.uniform(0.003, 0.008)))
        at = last
    return x


def whole(seed, *, kind=None, rate=None, seconds=None):
    """A recording by its seed, of a kind and a rate that are drawn unless given."""
    rng = np.random.default_rng(seed)
    kind = kind or str(rng.choice(KINDS))
    rate = rate or float(rng.choice([200, 500, 1000, 2000], p=[0.15, 0.4, 0.3, 0.15]))
    fine = rate * (4 if rate < 1000 else 2)  # forces and bracket are finer than what is written
    seconds = seconds or float(rng.uniform(60, 150))
    n = int(seconds * fine)
    t = np.arange(n) / fine
    wander = np.abs(smooth(rng.normal(size=n), int(6 * fine))) * np.sqrt(6 * fine)
    speed = np.minimum(12 + 20 * wander, 45)
    if kind in ("cruise", "rig"):
        speed = np.full(n, rng.uniform(12, 40))
    torque = {
        "launches": lambda: held(rng, t, [0, 0, 8000, 10_000, -1500], 2, 9, (0.15, 0.8)),
        "cruise": lambda: np.full(n, 2000.0),
        "quiet": lambda: np.full(n, 200.0),
        "rig": lambda: 4000 + 4000 * np.sin(2 * np.pi * rng.uniform(0.5, 3) * t),
    }.get(kind, lambda: held(rng, t, [0, 1000, 3000, 6000, -1000], 3, 20, (0.2, 1.5)))()
    turned = 2 * np.pi * np.cumsum(speed) / fine
    loud = {"quiet": 0.15, "violent": 2.5, "rig": 0.05}.get(kind, 1.0)
    forces = {
        "road": loud * rng.uniform(3, 9) * colour(
            rng, n, fine, low=0.7, high=min(250, fine / 4), slope=rng.uniform(0.6, 1.5)
        ),
        "pull": 18 * torque / 1e4,
        "joints": 18 * rng.uniform(0, 1.5) * torque / 1e4 * np.cos(2 * turned + 1),
        "turns": rng.uniform(0, 3) * (speed / 40) ** 2 * np.cos(turned),
        "blows": blows(rng, t, fine, per_minute=8 * loud, size=15 * loud),
        "clunks": clunks(rng, t, per_minute={"launches": 12, "violent": 12}.get(kind, 2) * loud,
                         size=12),
    }  # fmt: skip
    if kind == "road":  # what changes under the wheels changes at once
        forces["road"] = forces["road"] * held(rng, t, [0.5, 1, 2], 5, 30, (0.1, 0.5))
    if kind == "stick-slip":
        forces["slips"] = sticking(rng, t, rng.uniform(10, 40))
    gauges = []
    modes = [(rng.uniform(15, 70), rng.uniform(0.02, 0.08)) for _ in range(rng.integers(1, 3))]
    for k in range(2):
        x = np.zeros(n)
        for force in forces.values():
            x += force * (1 if k == 0 else rng.uniform(0.3, 0.9) * rng.choice([-1, 1]))
        x = x + sum(rng.uniform(0.2, 0.6) * oscillator(x, hertz=f, damping=d, rate=fine)
                    for f, d in modes)  # fmt: skip
        size = rng.uniform(0.8, 2) if kind == "quiet" else rng.uniform(8, 25)
        gauges.append((x - x.mean()) * size / x.std() + rng.uniform(-1, 2) * size)
    x = np.stack([*gauges, torque, speed])
    every = round(fine / rate)
    if rng.uniform() < 0.8:  # an anti-alias filter, seldom forgotten
        sos = butter(6, 0.35 * rate, fs=fine, output="sos")
        x[:2] = sosfiltfilt(sos, x[:2]) if rng.uniform() < 0.5 else sosfilt(sos, x[:2])
    # Of a filter's ends nothing is kept.
    x = x[:, int(0.3 * fine) : -int(0.3 * fine) : every].copy()
    x[:2] += rng.uniform(0.002, 0.02) * x[:2].std() * rng.normal(size=x[:2].shape)
    step = np.ptp(x[0]) * float(rng.choice([0, 1e-5, 2e-3, 8e-3], p=[0.3, 0.4, 0.2, 0.1]))
    if step:
        x[:2] = np.round(x[:2] / step) * step
    x[2] = np.round(x[2] + 20 * rng.normal(size=x[2].size))
    return Case(kind=kind, rate=rate, gauges=x[:2], torque=x[2], speed=x[3])


def spans(rng, n, length, count):
    """Starts of so many spans of samples that do not overlap."""
    cells = rng.choice(n // length, min(count, n // length), replace=False)
    return np.sort(cells) * length


def scale(x):
    """How far it usually swings: what a fault's size goes by."""
    return float(np.median(np.abs(x - np.median(x)))) + 1.0


def stuck_bit(x, rate, bad, rng):
    lsb = (np.ptp(x) * 1.6) / 4096
    code = np.round((x - x.min()) / lsb).astype(int) + 200
    bit = 1 << round(8 + 2 * bad)
    code = code | bit if rng.uniform() < 0.5 else code & ~bit
    return (code - 200) * lsb + x.min()


def chatter(x, rate, bad, rng):
    y = x.copy()
    for a in spans(rng, x.size, int(rate), 4 + int(8 * bad)):
        n = int(rng.uniform(0.1, 0.4) * rate)
        y[a : a + n] += rng.normal(size=n)[: y[a : a + n].size] * scale(x) * (2 + 6 * bad)
    return y


def contact_lost(x, rate, bad, rng):
    """Comes and goes: some tenths of a second of another level, by the dozen."""
    y, dead = x.copy(), scale(x) * (3 + 5 * bad)
    for a in spans(rng, x.size, int(rate), 10 + int(30 * bad)):
        y[a : a + int(rng.uniform(0.005, 0.3) * rate) + 1] = dead
    return y


def steps(x, rate, bad, rng):
    y = x.copy()
    for a in rng.integers(0, x.size, 10 + int(30 * bad)):
        y[a:] += rng.choice([-1, 1]) * scale(x) * (1 + 2 * bad)
    return y


def pulses(x, rate, bad, rng):
    y, every = x.copy(), int(rng.uniform(0.3, 1.5) * rate)
    for a in range(every // 2, x.size, every):
        y[a : a + max(int(0.02 * rate), 2)] += scale(x) * (2 + 3 * bad)
    return y


def ignition(x, rate, bad, rng):
    y = x.copy()
    y[:: int(rng.integers(30, 90))] += scale(x) * (2 + 4 * bad)
    return y


def gain_for_a_while(x, rate, bad, rng):
    a = int(rng.uniform(0.2, 0.4) * x.size)
    y = x.copy()
    y[a : a + x.size // 3] *= 1.3 + bad
    return y


def gain_from_midway(x, rate, bad, rng):
    y = x.copy()
    y[int(rng.uniform(0.4, 0.6) * x.size) :] *= rng.choice([1.3 + bad, 1 / (1.3 + bad)])
    return y


def hum(x, rate, bad, rng, *, of=None):
    t = np.arange(x.size) / rate
    f = float(rng.choice([50, 60])) if of is None else of(t, rng)
    turned = f * t if np.ndim(f) == 0 else np.cumsum(f) / rate
    return x + scale(x) * (1 + 1.5 * bad) * np.sin(2 * np.pi * turned + 1)


def hum_on_and_off(x, rate, bad, rng):
    t = np.arange(x.size) / rate
    on = (t % rng.uniform(18, 25)) < rng.uniform(9, 12)
    return np.where(on, hum(x, rate, bad, rng), x)


def hum_wanders(x, rate, bad, rng):
    about = rng.choice([50, 60])
    return hum(
        x, rate, bad, rng,
        of=lambda t, rng: about + 0.15 * np.sin(2 * np.pi * t / rng.uniform(30, 60)),
    )  # fmt: skip


def wrapped(x, rate, bad, rng):
    middle = np.median(x)
    reach = (np.quantile(x, 0.999 - 0.02 * bad) - middle) * 1.0
    return (x - middle + reach) % (2 * reach) - reach + middle


def doubled(x, rate, bad, rng):
    """Blocks of a second or more that were written twice, in the place of others."""
    y, n = x.copy(), int(rng.uniform(1, 4) * rate)
    for a in spans(rng, x.size - n, 2 * n, 2 + int(10 * bad)):
        y[a + n : a + 2 * n] = y[a : a + n]
    return y


def lost(x, rate, bad, rng):
    """Samples that a buffer lost, the time closed up."""
    keep = (np.arange(x.size) / rate) % 2 >= 0.05 + 0.3 * bad
    return x[keep]


def absolute(x, rate, bad, rng):
    return np.abs(x - np.median(x) * (1 - bad))


def inverted(x, rate, bad, rng):
    y = x.copy()
    y[int(rng.uniform(0.3, 0.7) * x.size) :] *= -1
    return y


def bends(x, rate, bad, rng):
    m, s = np.median(x), (4 - 2.5 * bad) * scale(x)
    return m + s * np.tanh((x - m) / s)


def smoothed(x, rate, bad, rng):
    return sosfiltfilt(butter(2, 20 - 15 * bad, fs=rate, output="sos"), x)


def gain(x, rate, bad, rng):
    return x * (1.1 + bad)


def noise(x, rate, bad, rng):
    return x + scale(x) * (0.3 + bad) * rng.normal(size=x.size)


def spikes(x, rate, bad, rng):
    y = x.copy()
    y[rng.integers(0, x.size, 3 + int(20 * bad))] += scale(x) * (6 + 10 * bad)
    return y


def clipped(x, rate, bad, rng):
    return np.minimum(x, np.quantile(x, 0.999 - 0.05 * bad))


def drifts(x, rate, bad, rng):
    return x + scale(x) * (4 + 8 * bad) * np.linspace(0, 1, x.size)


def sun(x, rate, bad, rng):
    """The zero goes with the sun on the part, there and back."""
    t = np.linspace(0, 1, x.size)
    return x + scale(x) * (4 + 8 * bad) * np.sin(np.pi * rng.uniform(0.6, 1.4) * t) ** 2


def lead(x, rate, bad, rng):
    """A plug of the bridge that gains some ohms: less gain, and another zero."""
    y = x.copy()
    a = int(rng.uniform(0.3, 0.7) * x.size)
    y[a:] = y[a:] * (0.85 - 0.35 * bad) + rng.choice([-1, 1]) * scale(x) * (0.5 + bad)
    return y


def supply(x, rate, bad, rng):
    """A battery that fades, or an amplifier that warms: the gain goes all the time."""
    last = 1.3 + bad
    return x * np.linspace(1, last if rng.uniform() < 0.5 else 1 / last, x.size)


def loose(x, rate, bad, rng):
    """A gain that goes to another value and back, for some seconds at a time."""
    y, n = x.copy(), int(rng.uniform(2, 6) * rate)
    for a in spans(rng, x.size, 2 * n, 3 + int(4 * bad)):
        y[a : a + n] *= 1.4 + bad
    return y


def holds(x, rate, bad, rng):
    """Telemetry that keeps the last value while it hears nothing."""
    y = x.copy()
    for a in spans(rng, x.size, int(0.5 * rate), 10 + int(60 * bad)):
        y[a : a + int(rng.uniform(0.03, 0.3) * rate) + 2] = y[a]
    return y


def packets(x, rate, bad, rng):
    """Packets that overtake each other."""
    y, n = x.copy(), max(int(rng.uniform(0.02, 0.1) * rate), 4)
    for a in spans(rng, x.size - 2 * n, 2 * n, 10 + int(90 * bad)):
        y[a : a + n], y[a + n : a + 2 * n] = x[a + n : a + 2 * n], x[a : a + n]
    return y


def again(x, rate, bad, rng):
    """Packets that came twice, each in the place of the next."""
    y, n = x.copy(), max(int(rng.uniform(0.02, 0.1) * rate), 4)
    for a in spans(rng, x.size - 2 * n, 2 * n, 10 + int(90 * bad)):
        y[a + n : a + 2 * n] = x[a : a + n]
    return y


def pairs(x, rate, bad, rng):
    """Two samples lost here and there, the time closed up."""
    keep = np.ones(x.size, bool)
    for a in spans(rng, x.size - 2, 4, int(x.size / 4 * (0.02 + 0.2 * bad))):
        keep[a : a + 2] = False
    return x[keep]


def nearest(x, rate, bad, rng):
    """Resampled by the nearest sample of a slower one."""
    slow = 0.7 - 0.5 * bad
    return x[np.round(np.floor(np.arange(x.size) * slow) / slow).astype(int).clip(0, x.size - 1)]


def generator(x, rate, bad, rng):
    """Hum of a generator that turns with the engine, while it runs."""
    t = np.arange(x.size) / rate
    f = rng.uniform(0.06, 0.2) * rate
    turned = np.cumsum(f * (1 + 0.3 * np.sin(2 * np.pi * t / rng.uniform(15, 40)))) / rate
    on = (t % 40) < 30
    return x + on * scale(x) * (1 + 1.5 * bad) * np.sin(2 * np.pi * turned)


def folds(x, rate, bad, rng):
    """A tone from above half the rate that nobody filtered: it lies somewhere, and wanders."""
    t = np.arange(x.size) / rate
    turned = np.cumsum(rng.uniform(0.1, 0.45) * rate + 2 * np.sin(2 * np.pi * t / 25)) / rate
    return x + scale(x) * (0.7 + 1.5 * bad) * np.sin(2 * np.pi * turned)


def switched(x, rate, bad, rng):
    """Cross-talk of a line that is switched on and off."""
    t, y = np.arange(x.size) / rate, np.zeros(x.size)
    for a in np.cumsum(rng.uniform(0.4, 4, int(t[-1] / 0.4))):
        y[t > a] = 1 - y[t > a]
    return x + scale(x) * (1 + 2.5 * bad) * y


def coarse(x, rate, bad, rng):
    """Few codes of a converter whose range is far too wide."""
    step = scale(x) * (0.5 + 2 * bad)
    return np.round(x / step) * step


def slow(x, rate, bad, rng):
    """An amplifier of the first order."""
    return sosfilt(butter(1, 20 - 15 * bad, fs=rate, output="sos"), x - x[0]) + x[0]


def slews(x, rate, bad, rng):
    """An amplifier that goes no faster."""
    fastest, y = np.quantile(np.abs(np.diff(x)), 0.95 - 0.45 * bad), x.copy()
    for k in range(1, x.size):
        y[k] = y[k - 1] + min(max(x[k] - y[k - 1], -fastest), fastest)
    return y


def debonds(x, rate, bad, rng):
    """A gauge that comes off: it follows pressure, and less of what pulls."""
    m = np.median(x)
    return m + np.where(x > m, 0.8 - 0.6 * bad, 1.0) * (x - m)


def recovers(x, rate, bad, rng):
    """An amplifier that is lost for a while after what was too much for it."""
    y, m = x.copy(), np.median(x)
    top = np.quantile(np.abs(x - m), 0.999 - 0.02 * bad)
    n, k = int(rng.uniform(0.02, 0.1) * rate) + 1, 0
    over = np.flatnonzero(np.abs(x - m) > top)
    while over.size:
        k = over[0]
        y[k : k + n] = m
        over = over[over > k + n]
    return y


def bytes_swapped(x, rate, bad, rng):
    """Samples whose two bytes changed places."""
    lsb = np.ptp(x) * 1.6 / 65536
    code = (np.round((x - x.min()) / lsb) + 8000).astype(np.uint16)
    at = rng.integers(0, x.size, 5 + int(60 * bad))
    code[at] = code[at].byteswap()
    return (code.astype(float) - 8000) * lsb + x.min()


def frozen(x, rate, bad, rng, *, noise=0.0, bridged=False):
    """A channel that stands for seconds at a time: as it was, with noise, or bridged by lines."""
    y, longest = x.copy(), 2 + 4 * bad
    for a in spans(rng, x.size, int(8 * rate), 3 + int(4 * bad)):
        part = y[a : a + int(rng.uniform(1, longest) * rate)]
        end = part[-1] if bridged else part[0]
        part[:] = np.linspace(part[0], end, part.size) + noise * x.std() * rng.normal(
            size=part.size
        )
    return y


def frozen_with_noise(x, rate, bad, rng):
    return frozen(x, rate, bad, rng, noise=0.005)


def frozen_under_noise(x, rate, bad, rng):
    """A gauge that stands for a third of the time under the noise of its amplifier."""
    y, n = x.copy(), x.size // 3
    a = int(rng.uniform(0.2, 0.5) * x.size)
    y[a : a + n] = y[a] + (0.005 + 0.03 * bad) * x.std() * rng.normal(size=n)
    return y


def filter_switched_on(x, rate, bad, rng):
    """A low-pass filter of the amplifier that is switched on part-way."""
    y, a = x.copy(), int(rng.uniform(0.3, 0.6) * x.size)
    sos = butter(4, 30 - 22 * bad, fs=rate, output="sos")
    y[a:] = (sosfilt(sos, x - x[0]) + x[0])[a:]
    return y


def bridged(x, rate, bad, rng):
    return frozen(x, rate, bad, rng, bridged=True)


def frozen_at_worst(x, rate, bad, rng):
    """A contact that a blow opens for a second or more: the worst of all is not there."""
    y, n = x.copy(), int((1 + 3 * bad) * rate)
    a = max(int(np.argmax(np.abs(x - np.median(x)))) - n // 2, 0)
    y[a : a + n] = y[a]
    return y


def frozen_under_load(x, rate, bad, rng):
    """An amplifier that stands for a while whenever it is loaded."""
    y, m, n = x.copy(), np.median(x), int((0.2 + bad) * rate)
    over = np.flatnonzero(np.abs(x - m) > 3 * scale(x))
    while over.size:
        a = over[0]
        y[a : a + n] = y[a]
        over = over[over > a + n]
    return y


FAULTS = {
    "spikes": spikes, "clipped": clipped, "drift": drifts, "hum": hum,
    "hum on and off": hum_on_and_off, "hum that wanders": hum_wanders,
    "stuck bit": stuck_bit, "chatter": chatter, "contact lost": contact_lost, "steps": steps,
    "pulses": pulses, "ignition": ignition, "gain for a while": gain_for_a_while,
    "gain from midway": gain_from_midway, "wrapped": wrapped, "doubled": doubled,
    "lost samples": lost, "absolute": absolute, "inverted": inverted, "bends": bends,
    "smoothed": smoothed, "gain": gain, "noise": noise,
    "sun": sun, "lead": lead, "supply": supply, "loose gain": loose, "held": holds,
    "out of order": packets, "packets twice": again, "pairs lost": pairs, "nearest": nearest,
    "generator": generator, "folded tone": folds, "switched": switched, "coarse": coarse,
    "slow amplifier": slow, "slew rate": slews, "debonds": debonds, "recovers": recovers,
    "bytes swapped": bytes_swapped, "frozen": frozen, "frozen with noise": frozen_with_noise,
    "frozen under noise": frozen_under_noise, "filter switched on": filter_switched_on,
    "bridged": bridged, "frozen at the worst": frozen_at_worst,
    "frozen under load": frozen_under_load,
}  # fmt: skip
