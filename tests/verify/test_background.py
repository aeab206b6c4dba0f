"""Modes of a bracket found in what the road shakes, in recordings of other hands.

`adversarial` and `proving_ground` know the modes of their brackets; their drives launch, shift
and coast, with order 2 and engine orders across the modes. What is told has to hold the truth,
and what is no mode must not be told: noise, wheels that hop, a pump, an order nobody named.
"""

from dataclasses import dataclass

import adversarial
import numpy as np
import proving_ground
import pytest
from adversarial import colour

from cardan.physics.signals.operational_modes import identify_operational_modes, order_free_spectra
from cardan.physics.signals.order_tracking import ShaftRotation
from cardan.physics.signals.shaft_angle import ShaftAngle, shaft_angle

RATE = 500.0


def some_modes(seed):
    """Modes as `adversarial` draws them, to all their digits."""
    rng = np.random.default_rng([seed, 5])
    return [
        {
            "hertz": rng.uniform(18, 75), "damping": rng.uniform(0.008, 0.06),
            "share": rng.uniform(0.3, 1.0) * rng.choice([-1, 1]),
        }
        for _ in range(rng.integers(0, 3))
    ]  # fmt: skip


def misled(seed):
    """What is told of a recording made to mislead, and its modes: (Hz, damping)."""
    true = some_modes(seed)
    one = adversarial.made(seed, modes=true)
    engine = None if one.engine is None else shaft_angle(one.engine, rate=one.rate).rotation
    told = identify_operational_modes(
        order_free_spectra(
            [one.stress[None]], rate=one.rate, seconds=one.stress.size / one.rate,
            angle=shaft_angle(one.speed, rate=one.rate), engine=engine,
            engine_orders=(one.about["order"],),
        )
    )  # fmt: skip
    return told, [(m["hertz"], m["damping"]) for m in true], []


def stepped(hertz, damping):
    """Frequency and damping of an oscillator as `proving_ground` steps it."""
    w, dt = 2 * np.pi * hertz, 1 / proving_ground.FINE
    push = np.array([[1, 0], [-dt * w * w, 1 - 2 * damping * w * dt]])
    pole = np.log(np.linalg.eigvals(np.array([[1, dt], [0, 1]]) @ push)[0].astype(complex)) / dt
    return abs(pole) / (2 * np.pi), -pole.real / abs(pole)


def driven(seed):
    """What is told of a whole drive, its bracket's modes, and Hz at which its rubber swings."""
    one = proving_ground.drive(seed)
    at = one.names.index
    engine = None
    if "engine" in one.names:
        engine = shaft_angle(one.data[at("engine")] / 60, rate=one.rate).rotation
    firing = one.about["cylinders"] / 2
    stress = np.where(one.data[:2] < -9000, np.nan, one.data[:2])
    told = identify_operational_modes(
        order_free_spectra(
            [stress], rate=one.rate, seconds=stress.shape[1] / one.rate,
            angle=shaft_angle(one.data[at("speed")] / 60, rate=one.rate), engine=engine,
            engine_orders=(firing, 2 * firing) if one.orders else (2.0, 3.0, 4.0, 6.0),
        )
    )  # fmt: skip
    return told, [stepped(*m) for m in one.about["modes"]], one.about["hung"]


def statistics(made, seeds):
    """Share of frequencies and dampings inside, share of modes told, and what is told wrongly.

    What lies within a tenth of a mode was meant to be it.
    """
    frequency, damping, wrong, true = [], [], [], 0
    for seed in seeds:
        told, known, others = made(seed)
        true += len(known)
        for mode in told:
            low, found, high = mode.frequency
            every = [*known, *((f, None) for f in others)]
            f, d = min(every, key=lambda m: abs(m[0] - found), default=(np.inf, None))
            if abs(np.log(f / found)) > 0.1:
                wrong.append((seed, mode))
            elif d is not None:
                frequency.append(low <= f <= high)
                damping.append(mode.damping[0] <= d <= mode.damping[2])
    return np.mean(frequency), np.mean(damping), len(frequency) / true, wrong


@pytest.mark.slow
def test_modes_of_12_recordings_lie_within_intervals():
    """Of a dozen 90 % intervals four miss once in forty times."""
    frequency, damping, told, wrong = statistics(misled, range(300, 314))
    assert not wrong
    assert frequency >= 0.7
    assert damping >= 0.7
    assert told > 0.4


@pytest.mark.long
def test_modes_of_100_recordings_lie_within_intervals():
    frequency, damping, told, wrong = statistics(misled, range(600, 700))
    assert frequency >= 0.85
    assert damping >= 0.85
    assert told > 0.6
    assert len(wrong) <= 1


@pytest.mark.long
def test_modes_of_50_drives_lie_within_intervals():
    """Of 34 told 28 hold it: a bracket shaken from both its ends is more than the model has."""
    frequency, damping, told, wrong = statistics(driven, range(72_000, 72_050))
    assert frequency >= 0.8
    assert damping >= 0.85
    assert told > 0.25
    assert len(wrong) <= 2


# ----------------------------------------------------------- what is no mode of a bracket


@dataclass
class World:
    """A minute and a half at a speed, and what is shaken in it."""

    seconds: float = 90.0
    seed: int = 0
    turns: float = 20.0

    def __post_init__(self):
        self.rng = np.random.default_rng(self.seed)
        self.n = int(self.seconds * RATE)
        self.t = np.arange(self.n) / RATE

    def road(self, size=1.0, *, low=0.8, high=240.0, slope=0.7):
        return size * colour(self.rng, self.n, RATE, low=low, high=high, slope=slope)

    def shaken(self, force, *modes):
        return adversarial.bracket(
            force, [{"hertz": f, "damping": d, "share": s} for f, d, s in modes], RATE
        )

    def told(self, *stress, speed=None, engine=None, orders=()):
        speed = np.full(self.n, self.turns) if speed is None else speed
        angle = ShaftAngle(ShaftRotation(self.t, np.cumsum(speed) / RATE))
        found = order_free_spectra(
            [np.stack(stress)], rate=RATE, seconds=self.seconds, angle=angle, engine=engine,
            engine_orders=orders,
        )  # fmt: skip
        return identify_operational_modes(found)


@pytest.mark.parametrize("seed", range(4))
def test_noise_gives_no_mode(seed):
    w = World(seed=seed)
    assert not w.told(w.rng.normal(size=w.n))
    assert not w.told(w.road())


@pytest.mark.slow
def test_constant_or_missing_gauge_gives_no_mode():
    w = World()
    assert not w.told(np.zeros(w.n))
    assert not w.told(np.full(w.n, np.nan))
    assert not World(seconds=12.0).told(World(seconds=12.0).road())
    w = World(turns=21.0)
    felt = w.shaken(w.road(), (51.0, 0.03, 1.0))
    assert w.told(felt)
    assert not w.told(np.where(w.t % 1 < 0.25, np.nan, felt))


def test_wheel_hop_is_not_a_bracket_mode():
    w = World()
    assert not w.told(w.shaken(w.road(), (12.0, 0.1, 1.0)))


@pytest.mark.parametrize(
    ("hertz", "size", "seed"), [(24.8, 0.3, 0), (29.22, 0.6, 1), (44.9, 0.6, 1), (50.0, 0.5, 0)]
)
def test_pump_tone_and_mains_hum_are_not_modes(hertz, size, seed):
    w = World(seed=seed)
    assert not w.told(w.road() + size * np.cos(2 * np.pi * hertz * w.t))


def test_engine_order_is_not_a_mode():
    """An engine's order 3 in two gears: it stands where the speed puts it."""
    w = World()
    speed = 20 + 3 * np.sin(2 * np.pi * w.t / 30)
    engine = np.cumsum(speed * np.where(w.t < 45, 0.75, 0.62)) / RATE
    assert not w.told(w.road() + 0.4 * np.cos(2 * np.pi * 3 * engine), speed=speed)


@pytest.mark.slow
def test_order_2_is_not_a_mode_and_can_hide_one():
    """At one speed all day the order stands on the mode: nobody sees its top."""
    w = World(turns=20.0)
    order2 = np.cos(4 * np.pi * 20.0 * w.t)
    assert not w.told(w.road() + order2)
    assert not w.told(w.shaken(w.road() + 0.2 * order2, (40.0, 0.02, 0.5)))


@pytest.mark.slow
def test_order_2_passing_through_mode_does_not_bias_it():
    """Order 2 goes through the mode, ten times as loud as what the road makes of it."""
    w = World(seconds=180.0)
    speed = 20 + 8 * np.sin(2 * np.pi * w.t / 40)
    order2 = 3 * np.cos(4 * np.pi * np.cumsum(speed) / RATE)
    (mode,) = w.told(w.shaken(w.road() + order2, (40.0, 0.03, 1.0)), speed=speed)
    assert mode.frequency[0] <= 40.0 <= mode.frequency[2]
    assert mode.damping[0] <= 0.03 <= mode.damping[2]
    assert mode.frequency[2] / mode.frequency[0] < 1.04


@pytest.mark.slow
def test_mode_shape_and_participating_gauges_are_reported():
    w = World(seconds=150.0)
    one, other = w.road(), w.road()
    felt = w.shaken(one, (47.0, 0.03, 1.0))
    (mode,) = w.told(0.5 * felt, -felt + 0.02 * other, other)
    assert mode.felt_by_gauge == (True, True, False)
    assert mode.shape == pytest.approx((-0.5, 1.0, 0.0), abs=0.05)
    assert mode.frequency[0] <= 47.0 <= mode.frequency[2]


@pytest.mark.slow
def test_two_close_modes_are_separated():
    w = World(seconds=240.0)
    told = w.told(w.shaken(w.road(), (46.0, 0.015, 0.8), (54.0, 0.015, 0.8)))
    assert [round(m.frequency[1]) for m in told] == [46, 54]
    for mode, true in zip(told, (46.0, 54.0), strict=True):
        assert mode.frequency[0] <= true <= mode.frequency[2]


@pytest.mark.slow
def test_gaps_and_standstill_do_not_bias_mode():
    """A third of the time the truck stands and a gauge hears itself; a tenth is missing."""
    w = World(seconds=180.0)
    stress = w.shaken(w.road(), (48.0, 0.03, 1.0)) * np.where(w.t < 120, 1.0, 0.003)
    stress += 0.05 * w.rng.normal(size=w.n)
    for at in w.rng.uniform(0, 110, 6):
        stress[int(at * RATE) : int((at + 2) * RATE)] = np.nan
    (mode,) = w.told(stress)
    assert mode.frequency[0] <= 48.0 <= mode.frequency[2]
    assert mode.damping[0] <= 0.03 <= mode.damping[2]
