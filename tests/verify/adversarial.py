"""Recordings made to mislead, whose truth is known: a bracket shaken by whoever was asked to.

Nothing of the program's analysis is in here. A bracket has a static stiffness and up to two
modes, each an oscillator that remembers; every force goes through it: the joints' (order 2
and 4 by torque, order 2 by speed squared, contact that chops it), unbalance, engine orders,
a road of all frequencies, blows. The vehicle launches, shifts, crawls, cruises and coasts.
The channels of speed are then spoiled: a wrong ratio, a staircase that comes late, a bus that
lags, holes and zeros.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.signal import lfilter

GEARS = (6.4, 3.6, 2.1, 1.37, 1.0)


@dataclass
class Case:
    """A recording and the truth behind it."""

    rate: float
    stress: np.ndarray  # MPa
    joints: np.ndarray  # MPa, of that
    speed: np.ndarray  # turns/s, as written
    engine: np.ndarray | None
    torque: np.ndarray  # N m
    turns: np.ndarray
    about: dict = field(default_factory=dict)


def oscillator(u, *, hertz, damping, rate):
    """Response of a mode of unit static gain to real forces held between samples."""
    w = 2 * np.pi * hertz
    s = w * (-damping + 1j * np.sqrt(1 - damping**2))
    z = np.exp(s / rate)
    # x'' + 2 d w x' + w² x = w² u is Im of a one-pole filter: x = w/√(1-d²) Im z.
    y = lfilter([(z - 1) / s], [1, -z], u.astype(complex))
    return w / np.sqrt(1 - damping**2) * y.imag


def bracket(u, modes, rate):
    return u + sum(
        m["share"] * oscillator(u, hertz=m["hertz"], damping=m["damping"], rate=rate) for m in modes
    )


def smooth(x, width):
    for _ in range(2):
        pad = np.pad(x, (width // 2, width - width // 2), mode="edge")
        total = np.cumsum(pad)
        x = (total[width:] - total[:-width]) / width
    return x


def colour(rng, n, rate, *, low, high, slope):
    f = np.fft.rfftfreq(n, 1 / rate)
    shape = np.where((f > low) & (f < high), np.maximum(f, 1.0) ** -slope, 0.0)
    x = np.fft.irfft(shape * (rng.normal(size=f.size) + 1j * rng.normal(size=f.size)), n)
    return x / x.std()


def route(rng, t, rate, kind):
    """Shaft turns a second, gear ratio and torque, by the kind of drive."""
    n, seconds = t.size, t[-1]
    if kind == "run-up":
        v = 8 + (45 - 8) * (0.5 - 0.5 * np.cos(2 * np.pi * t / rng.uniform(40, 60)))
        gear = np.ones(n)
    elif kind == "crawl":
        v = np.maximum(1.7 + 0.3 * smooth(rng.normal(size=n), int(3 * rate)) * 30, 0.5)
        gear = np.full(n, GEARS[0])
    elif kind == "direct":
        v = 24 + 8 * smooth(rng.normal(size=n), int(5 * rate)) * 40
        v = np.clip(v, 16, 36)
        gear = np.ones(n)
    elif kind == "steady":
        v = rng.uniform(14, 34) + 0.3 * smooth(rng.normal(size=n), int(4 * rate)) * 40
        gear = np.ones(n)
    else:
        holds = rng.uniform(8, 20, int(seconds / 8) + 2)
        target = rng.choice(
            [0, 8, 14, 20, 26, 34], size=holds.size, p=[0.1, 0.15, 0.2, 0.2, 0.2, 0.15]
        )
        target = np.where(target > 0, target + rng.normal(0, 1, holds.size), 0.0)
        v = np.maximum(
            smooth(
                target[np.minimum(np.searchsorted(np.cumsum(holds), t), holds.size - 1)],
                int(4 * rate),
            ),
            0,
        )
        gear = np.full(n, GEARS[0])
        for g in GEARS[1:]:
            gear = np.where(v * g > 18, g, gear)
        gear = smooth(gear, max(int(0.2 * rate), 2))
    pull = np.gradient(v, t) * 500 + 900 + 0.9 * v**2
    pull = pull + 2500 * smooth(rng.normal(size=n), int(6 * rate)) * np.sqrt(6 * rate) / 2
    torque = np.clip(np.where(v > 0.05, pull, 0.0), -2500, 11_000)
    return v, gear, smooth(torque, int(0.3 * rate))


def staircase(x, rate, hertz, late):
    """Values that come `hertz` times a second, and late."""
    step = int(rate / hertz)
    old = np.concatenate([np.full(int(late * rate), x[0]), x])[: x.size]
    return old[(np.arange(x.size) // step) * step]


def made(seed, *, seconds=None, rate=500.0, **asked):
    """A recording; what is not asked is drawn by the seed."""
    rng = np.random.default_rng(seed)

    def draw(name, value):
        return asked.get(name, value)

    seconds = seconds or float(rng.uniform(60, 120))
    n = int(seconds * rate)
    t = np.arange(n) / rate
    kind = draw(
        "kind",
        rng.choice(["mixed", "run-up", "steady", "direct", "crawl"], p=[0.5, 0.2, 0.12, 0.1, 0.08]),
    )
    v, gear, torque = route(rng, t, rate, kind)
    turns = np.cumsum(v) / rate
    motor = np.maximum(v * gear, 10.0)
    motor_turns = np.cumsum(motor) / rate
    modes = draw("modes", [
        {
            "hertz": rng.uniform(18, 75), "damping": rng.uniform(0.008, 0.06),
            "share": rng.uniform(0.3, 1.0) * rng.choice([-1, 1]),
        }
        for _ in range(rng.integers(0, 3))
    ])  # fmt: skip
    guilt = draw("guilt", rng.choice([0.0, 0.15, 0.5, 1.5], p=[0.4, 0.1, 0.2, 0.3]))
    unit = 40.0  # MPa at 10 kN m
    a = 2 * np.pi * 2 * turns
    wander = 1 + 0.1 * np.sin(2 * np.pi * t / rng.uniform(20, 60))
    if "rides" in asked:  # straight where it stands: the springs' travel makes the angle
        wander = np.sin(2 * np.pi * asked["rides"] * t + np.sin(0.9 * t))
    force = unit * guilt * torque / 1e4 * wander * np.cos(a + rng.uniform(0, 6))
    force += (
        unit
        * guilt
        * draw("fourth", rng.uniform(0, 0.25))
        * torque
        / 1e4
        * np.cos(2 * a + rng.uniform(0, 6))
    )
    force += (
        guilt * draw("inertia", rng.uniform(0, 4)) * (v / 40) ** 2 * np.cos(a + rng.uniform(0, 6))
    )
    if draw("contact", rng.uniform() < 0.1):
        force = np.maximum(force, -0.3 * np.abs(force).max())
    joints = bracket(force, modes, rate)
    road = colour(rng, n, rate, low=0.8, high=200, slope=rng.uniform(0.3, 1.2))
    road *= draw("road", rng.uniform(2, 12)) * np.sqrt(v / 20)
    other = bracket(road, modes, rate)
    other += bracket(
        draw("unbalance", rng.uniform(0, 6)) * (v / 40) ** 2 * np.cos(a / 2 + 1), modes, rate
    )
    order = draw("engine_order", rng.choice([3.0, 2.0], p=[0.8, 0.2]))
    size = draw("engine", rng.uniform(0, 5))
    other += bracket(
        size * (0.3 + np.abs(torque) / 1e4) * np.cos(2 * np.pi * order * motor_turns + 2),
        modes,
        rate,
    )
    for start in np.sort(rng.uniform(0, seconds - 1, rng.poisson(draw("blows", 4) * seconds / 60))):
        s = t[: int(0.5 * rate)]
        k = int(start * rate)
        blow = (
            rng.lognormal(0, 0.3)
            * 40
            * np.exp(-10 * s)
            * np.sin(2 * np.pi * rng.uniform(8, 20) * s)
        )
        other[k : k + s.size] += bracket(blow, modes, rate) * (v[k] > 1)
    stress = joints + other + 15 * torque / 1e4 + 0.3 * rng.normal(size=n)
    ratio = 1 + draw("ratio_off", rng.choice([0.0, 0.002, -0.01, 0.03], p=[0.4, 0.2, 0.2, 0.2]))
    fault = draw(
        "fault",
        rng.choice(["none", "staircase", "bus", "holes", "zeros"], p=[0.35, 0.2, 0.25, 0.1, 0.1]),
    )
    speed, engine = v * ratio, motor.copy()
    if fault == "staircase":
        speed = staircase(
            speed,
            rate,
            draw("steps", rng.choice([1.0, 2.0, 5.0])),
            draw("late", rng.uniform(0, 0.8)),
        )
    elif fault == "bus":
        speed = staircase(speed, rate, 50, rng.uniform(0, 0.12))
    elif fault in ("holes", "zeros"):
        for start in rng.uniform(0, seconds, 4):
            k = slice(int(start * rate), int((start + rng.uniform(0.5, 3)) * rate))
            speed[k] = np.nan if fault == "holes" else 0.0
    engine = staircase(engine, rate, 50, rng.uniform(0, 0.05))
    known = draw("engine_known", rng.uniform() < 0.7)
    about = {
        "seed": seed, "kind": str(kind), "fault": str(fault), "guilt": float(guilt), "ratio": ratio,
        "modes": [(round(m["hertz"], 1), round(m["damping"], 3)) for m in modes],
        "order": float(order), "engine": bool(known),
    }  # fmt: skip
    return Case(
        rate=rate, stress=stress, joints=joints, speed=speed, engine=engine if known else None,
        torque=torque, turns=turns, about=about,
    )  # fmt: skip
