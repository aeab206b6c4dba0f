"""Joints dominate, do not dominate, or undetermined: misleading recordings of known truth."""

import json
from dataclasses import replace

import numpy as np
import pytest
from adversarial import bracket, colour, made, oscillator, smooth
from click.testing import CliRunner

from cardan.cli.life import life as command
from cardan.core.errors import DesignError
from cardan.core.finding import Finding
from cardan.physics.fatigue.damage import miner_damage
from cardan.physics.fatigue.rainflow import rainflow
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.physics.signals.attribution_result import (
    DOUBT_CONSTANT_FREQUENCY,
    DOUBT_DOUBLE_SPEED,
    DOUBT_ENGINE_ORDER_OVERLAP,
    DOUBT_NO_ENGINE_SPEED,
    DOUBT_NO_RELIABLE_SHAFT_ANGLE,
    DOUBT_SPEED_OF_OTHER_SHAFT,
    DOUBT_SPEED_SCALE,
    DOUBT_TORQUE_INDEPENDENT,
    JOINTS_DOMINANT,
    JOINTS_NOT_DOMINANT,
    UNDETERMINED,
    JointAttribution,
    combine_attributions,
)
from cardan.physics.signals.cause_assessment import DOUBT_OF_NAMED_GAUGE
from cardan.physics.signals.confounders import order_share_not_from_engine
from cardan.physics.signals.joint_attribution import separate_joint_caused_stress
from cardan.physics.signals.recording import recording_from_arrays
from cardan.physics.signals.shaft_angle import shaft_angle, speed_readings
from cardan.physics.signals.synchronous_fit import MIN_DETECTION_F_STATISTIC
from cardan.topics.recording.finding_phrases import finding_message
from cardan.topics.recording.options import AnalysisOptions
from cardan.topics.recording.shaft_signals import measured_shaft_angle
from cardan.topics.recording.study import RecordingStudy

CURVE = SNCurve(amplitude=30e6, cycles=2e6, slope=5).modified()


def damage(stress):
    return miner_damage(rainflow(stress), curve=CURVE)


def asked(case):
    """Truth of the removed share, and the answer."""
    stress = case.stress * 1e6
    truth = 1 - damage((case.stress - case.joints) * 1e6) / damage(stress)
    engine = None
    if case.engine is not None:
        engine = shaft_angle(case.engine, rate=case.rate).rotation
    answer = separate_joint_caused_stress(
        stress, rate=case.rate, angle=shaft_angle(case.speed, rate=case.rate, engine=case.engine),
        torque=case.torque, damage=damage, engine=engine,
        engine_orders=(case.about["order"], 2 * case.about["order"]),
    )  # fmt: skip
    return truth, answer


PLAIN = {
    "fault": "none", "ratio_off": 0.0, "engine_known": True, "contact": False,
    "engine_order": 3.0, "kind": "mixed", "modes": [], "seconds": 75.0,
}  # fmt: skip
GUILTY_ONE = PLAIN | {"guilt": 1.5, "road": 3.0}


def mode(hertz, damping):
    return [{"hertz": hertz, "damping": damping, "share": 1.0}]


CASES = {
    "a mode at 25 Hz, shaken by the road": (
        PLAIN | {"guilt": 0.0, "road": 8.0, "modes": mode(25, 0.015)},
        JOINTS_NOT_DOMINANT,
    ),
    "the same at steady speed": (
        PLAIN | {"guilt": 0.0, "road": 8.0, "modes": mode(25, 0.015), "kind": "steady"},
        JOINTS_NOT_DOMINANT,
    ),
    "order 2 passing a mode at 55 Hz": (GUILTY_ONE | {"modes": mode(55, 0.02)}, JOINTS_DOMINANT),
    "a run-up through a mode at 60 Hz": (
        GUILTY_ONE | {"modes": mode(60, 0.02), "kind": "run-up"},
        JOINTS_DOMINANT,
    ),
    "a speed 1 % off": (GUILTY_ONE | {"ratio_off": 0.01}, JOINTS_DOMINANT),
    "a speed 3 % off": (GUILTY_ONE | {"ratio_off": 0.03}, JOINTS_DOMINANT),
    "a speed of another shaft, twice as fast": (GUILTY_ONE | {"ratio_off": 1.0}, UNDETERMINED),
    "a speed of another shaft, half as fast": (GUILTY_ONE | {"ratio_off": -0.5}, UNDETERMINED),
    "angles that ride on the springs": (GUILTY_ONE | {"rides": 1.5}, JOINTS_DOMINANT),
    "angles that ride, and a mode passed quickly": (
        GUILTY_ONE
        | {
            "rides": 2.3,
            "modes": mode(40, 0.02),
            "fourth": 0.0,
            "inertia": 0.0,
            "seconds": 90.0,
            "seed": 8,
        },
        UNDETERMINED,
    ),
    "a GPS staircase half a second late": (
        GUILTY_ONE | {"fault": "staircase", "steps": 1.0, "late": 0.5, "seed": 7},
        JOINTS_DOMINANT,
    ),
    "crawling": (GUILTY_ONE | {"kind": "crawl", "road": 1.0, "blows": 0}, JOINTS_DOMINANT),
    "four cylinders in direct gear": (
        PLAIN | {"guilt": 0.0, "kind": "direct", "engine": 25.0, "engine_order": 2.0, "road": 3.0},
        UNDETERMINED,
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_known_misleading_recordings_get_correct_finding(name):
    how, finding = CASES[name]
    truth, answer = asked(made(how.get("seed", 5), **{k: v for k, v in how.items() if k != "seed"}))
    low, high = answer.attribution.interval
    assert answer.attribution.verdict == finding
    assert low <= truth <= high
    if finding == JOINTS_DOMINANT:
        assert answer.attribution.damage_share == pytest.approx(truth, abs=0.03)
    if how["ratio_off"] and finding == JOINTS_DOMINANT:
        # A cell of the search is 0.35 turns over the recording: some 1e-4.
        assert answer.attribution.ratio == pytest.approx(1 / (1 + how["ratio_off"]), abs=2e-4)


@pytest.mark.slow
def test_unspecified_engine_may_have_four_cylinders(tmp_path):
    case = made(5, **CASES["four cylinders in direct gear"][0])
    path = tmp_path / "direct.csv"
    table = [np.arange(case.stress.size) / case.rate, case.stress, 60 * case.speed,
             60 * case.engine, case.torque]  # fmt: skip
    np.savetxt(path, np.stack(table, -1), fmt="%.9g", delimiter=",", comments="",
               header="time_s,S1_MPa,shaft_rpm,engine_rpm,torque_Nm")  # fmt: skip
    asks = [str(path), "--gauge", "S1_MPa:MPa", "--sn", "30,2e6,5", "--speed", "shaft_rpm:rpm",
            "--engine", "engine_rpm:rpm", "--torque", "torque_Nm:Nm", "-q"]  # fmt: skip

    def told(*options):
        out = tmp_path / "out.json"
        done = CliRunner().invoke(command, ["--all", *asks, *options, "--json", str(out)])
        assert done.exit_code in (0, 1), done.output
        (gauge,) = json.loads(out.read_text())["gauges"]
        doubts = " ".join(json.loads(out.read_text())["doubts"])
        return gauge["finding"], [
            d
            for d in (DOUBT_ENGINE_ORDER_OVERLAP, DOUBT_TORQUE_INDEPENDENT)
            if str(finding_message(d)) in doubts
        ]

    assert told() == (UNDETERMINED, [DOUBT_ENGINE_ORDER_OVERLAP])
    # Six cylinders have nothing at order 2; but this does not turn its sign with the torque.
    assert told("--engine-orders", "3,6") == (UNDETERMINED, [DOUBT_TORQUE_INDEPENDENT])


def stop_and_go(seed, *, engine, joints, starts=3, seconds=70.0, rate=400.0):
    """Starts from rest into direct gear: MPa of a four-cylinder engine there, and of the joints.

    Derived: the engine turns with the shaft, at another angle each time that the clutch takes it.
    """
    rng, n = np.random.default_rng(seed), int(seconds * rate)
    t = np.arange(n) / rate
    speed = np.tile(30 * np.clip(np.minimum(t / 15, (seconds - 8 - t) / 10), 0, 1), starts)
    taken = np.repeat(rng.uniform(0, 2 * np.pi, starts), n)
    pull = np.where(np.gradient(speed) < 0, -0.3, np.where(speed > 0, 1.0, 0.0))
    pull *= 1 + 0.3 * colour(rng, speed.size, rate, low=0.02, high=0.3, slope=0.5)
    twice = 4 * np.pi * np.cumsum(speed) / rate
    road = colour(rng, speed.size, rate, low=0.8, high=150, slope=0.7) * np.sqrt(speed / 20)
    stress = joints * pull * np.cos(twice + 1) + 3 * road
    stress += engine * (0.35 + 0.65 * np.abs(pull)) * np.cos(twice + taken) * (speed > 15)
    return separate_joint_caused_stress(
        1e6 * stress, rate=rate, angle=shaft_angle(speed, rate=rate), torque=1500 * pull,
        damage=damage, engine_orders=(3.0, 6.0, 2.0),
    ).attribution  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_few_spells_of_unknown_engine_give_undetermined(seed):
    """Of 12 gauges all were convicted: some ratio of the speed makes three spells agree."""
    found = stop_and_go(seed, engine=12.0, joints=0.0)
    assert found.verdict == UNDETERMINED
    assert found.f_statistic < MIN_DETECTION_F_STATISTIC or DOUBT_NO_ENGINE_SPEED in found.doubts
    # What the joints do agrees at the ratio that the speed has, far better than by chance.
    assert stop_and_go(seed, engine=0.0, joints=12.0).verdict == JOINTS_DOMINANT


def spells_of(angles, *, at, extent, steps=20):
    """Order 2 of spells that hold the shaft at angles of their own: may, wave by the shaft, y.

    With turns, `own`, the wave at the ratio of the speed that makes the spells agree most, and
    the turns there.
    """
    x = np.linspace(-1, 1, steps + 2)[1:-1]
    turns = np.concatenate([2000 * (a + extent * np.append(x, 1.1)) for a in np.sort(at)])
    may = np.arange(turns.size) % (steps + 1) < steps
    shaft = np.exp(4j * np.pi * turns)
    engine = np.repeat(np.exp(1j * np.asarray(angles)), steps + 1) * shaft
    ratios = np.arange(-60, 60, 0.1) / 2000  # cycles over the recording
    met = np.exp(-2j * np.pi * np.outer(ratios, turns[may])) @ (engine * shaft.conj())[may]
    k = np.abs(met).argmax()
    own = shaft * np.exp(2j * np.pi * ratios[k] * turns) * met[k] / abs(met[k])
    return may, own, engine.real, turns, (1 + ratios[k] / 2) * turns


@pytest.mark.slow
@pytest.mark.parametrize("spells", [2, 3, 5, 8])
@pytest.mark.parametrize("extent", [0.02, 0.05])
def test_best_fitting_speed_ratio_does_not_attribute_engine_to_shaft(spells, extent):
    """Of 126 innocent gauges eleven were convicted: few spells always agree at some ratio.

    Derived: angles by chance, and the ratio of the speed that suits them best.
    """
    rng, shares = np.random.default_rng(spells), []
    for _ in range(200):
        at = (np.arange(spells) + rng.uniform(0.2, 0.8, spells)) / spells
        may, own, y, turns, best = spells_of(rng.uniform(0, 6.3, spells), at=at, extent=extent)
        stretch = np.zeros(may.size, int)
        shares.append(
            order_share_not_from_engine(may, own, y, stretch=stretch, turns=best, given=turns).min()
        )
    # A tenth of an order's swing is two fifths of its damage, at a slope of 5.
    assert np.mean(np.array(shares) > 0.1) <= 0.01


def test_consistent_spells_within_one_stretch_belong_to_shaft():
    """Derived: twelve of angles within 0.1 rad have all but their scatter in common."""
    angles = 0.1 * np.random.default_rng(1).normal(size=12)
    may, own, y, turns, best = spells_of(angles, at=(np.arange(12) + 0.5) / 12, extent=0.03)
    one, each = np.zeros(may.size, int), np.arange(may.size) // 21
    assert (
        order_share_not_from_engine(may, own, y, stretch=one, turns=best, given=turns).min() > 0.9
    )
    assert (
        order_share_not_from_engine(may, own, y, stretch=each, turns=best, given=turns).min() == 0.0
    )


@pytest.mark.slow
def test_shaft_speed_uses_all_gauges():
    """S2 was acquitted (true 0.99) beside S1 that said that the shaft turns twice as fast.

    S3 feels once a turn what goes with the torque: by half the speed that is order 2.
    """
    case = made(8, **PLAIN | {"guilt": 1.5, "road": 2.0, "engine": 0.0})
    rng = np.random.default_rng(3)
    road = 8 * colour(rng, case.stress.size, case.rate, low=0.8, high=150, slope=0.7)
    once = 25 * case.torque / 1e4 * np.cos(2 * np.pi * case.turns) + 0.1 * road

    def told(speed, *gauges):
        data = np.stack([case.stress, road, once, speed, case.torque])
        recording = recording_from_arrays(
            data, rate=case.rate, names=["S1", "S2", "S3", "v", "T"],
            units=["MPa", "MPa", "MPa", "rpm", "Nm"],
        )  # fmt: skip
        campaign = AnalysisOptions(sn="30,2e6,5", gauges=gauges, speed="v", torque="T")
        heard = RecordingStudy(campaign).run(recording).answer.causes
        return heard.joint_attributions[-1], heard.doubts

    found, doubts = told(60 * case.speed, "S1", "S2")
    assert found.verdict == JOINTS_NOT_DOMINANT
    of_s2 = DOUBT_OF_NAMED_GAUGE.with_values(gauge="S2", doubt=DOUBT_DOUBLE_SPEED)
    assert of_s2 not in doubts
    found, doubts = told(30 * case.speed, "S1", "S2")
    assert found.verdict == UNDETERMINED
    assert found.interval[1] == 1
    assert DOUBT_DOUBLE_SPEED in found.doubts
    assert of_s2 in doubts
    assert told(30 * case.speed, "S3")[0].verdict == JOINTS_DOMINANT
    assert told(30 * case.speed, "S1", "S3")[0].verdict == UNDETERMINED


@pytest.mark.slow
@pytest.mark.parametrize("seed", [913_082, 913_175, 913_004])
def test_removed_damage_equals_reported_removed_share(seed):
    """Guilty of 100 % by what follows order 2, unlocked: the table of causes gave joints 0 %."""
    case = made(seed)
    truth, answer = asked(case)
    stress = 1e6 * case.stress
    gone = 1 - damage(stress - answer.stress) / damage(stress)
    assert (answer.attribution.verdict == JOINTS_DOMINANT) == (truth > 0.5)
    assert max(gone, 0.0) == pytest.approx(answer.attribution.damage_share, abs=1e-3)


@pytest.mark.parametrize("seed", [0, 1])
def test_road_not_recorded_at_rest_is_not_attributed_to_shaft(seed):
    """Of 60 gauges one was convicted of a crawl's road: when it stood, its engine idled.

    Derived: a hop of 12 Hz while it rolls, whatever the speed; at rest 21.7 Hz of an idle.
    """
    rng, rate, n = np.random.default_rng(seed), 400.0, 48_000
    t = np.arange(n) / rate
    speed = 6 * np.clip(3 * np.sin(2 * np.pi * t / 20), 0, 1) * (1 + 0.05 * np.sin(t))
    rolls = speed > 0
    hop = oscillator(rng.normal(size=n), hertz=12.0, damping=0.1, rate=rate)
    idle = np.cos(2 * np.pi * 21.7 * t + 0.1 * np.cumsum(rng.normal(size=n)))
    stress = 20 * hop / hop.std() * rolls + 3 * idle * ~rolls + 0.1 * rng.normal(size=n)
    found = separate_joint_caused_stress(
        1e6 * stress, rate=rate, angle=shaft_angle(speed, rate=rate), torque=1500.0 * rolls,
        damage=damage, engine_orders=(3.0, 6.0),
    ).attribution  # fmt: skip
    assert found.verdict != JOINTS_DOMINANT
    assert found.interval[0] <= 0


@pytest.mark.slow
def test_untrusted_angle_still_finds_joints_dominant_by_frequency():
    """A staircase once a second and no engine: phases slip, and that is no innocence.

    What follows the shaft below any engine's idle speed convicts them, by its frequency alone.
    """
    case = made(6, **GUILTY_ONE | {
        "fault": "staircase", "steps": 1.0, "late": 0.5, "engine_known": False,
    })  # fmt: skip
    truth, answer = asked(case)
    assert truth > 0.9
    low, high = answer.attribution.interval
    assert low <= truth <= high
    assert answer.attribution.damage_share > 0.85
    assert answer.attribution.verdict == JOINTS_DOMINANT
    assert answer.attribution.doubts[0] == DOUBT_NO_RELIABLE_SHAFT_ANGLE


def test_bracket_mode_is_identified():
    case = made(5, **GUILTY_ONE | {"modes": mode(55, 0.02)})
    _, answer = asked(case)
    hertz, damping = answer.attribution.modes[0]
    assert hertz == pytest.approx(55, rel=0.02)
    assert damping == pytest.approx(0.02, rel=0.3)
    off = answer.stress / 1e6 - case.joints
    # A fifty-fifth of its energy is left; what wanders within six seconds is not followed.
    assert off.std() < 0.2 * case.joints.std()


def late(seed, seconds, **about):
    """A recording whose stress comes so many seconds after its speed."""
    case = made(seed, **GUILTY_ONE | about)
    time = np.arange(case.speed.size) / case.rate
    return replace(case, speed=np.interp(time + seconds, time, case.speed))


LAGS = np.random.default_rng(11).uniform(-0.1, 0.1, 12)


@pytest.mark.slow
def test_lag_lies_within_its_interval():
    """Nine times in ten: four or more of twelve lie outside once in 38 times, if that holds."""
    rng, inside, wide = np.random.default_rng(12), 0, []
    for k, seconds in enumerate(np.where(LAGS < -0.05, 0.0, LAGS)):
        modes = mode(float(rng.uniform(20, 70)), float(rng.choice([0.015, 0.05, 0.12])))
        _, answer = asked(late(5100 + k, seconds, kind=("mixed", "run-up")[k % 2], modes=modes))
        low, high = answer.attribution.lag_interval
        inside += low <= seconds <= high
        wide.append(high - low)
        assert low <= answer.attribution.lag <= high
    assert inside >= 9
    assert np.median(wide) < 0.02


@pytest.mark.slow
def test_lag_imitated_by_mode_is_not_reported():
    """49 ms had been told of none, for a mode that order 2 passed; 40 ms of another."""
    for seed, kind, hertz, damping in ((7022, "mixed", 29.0, 0.03), (5203, "direct", 66.0, 0.015)):
        case = made(seed, **GUILTY_ONE | {"kind": kind, "modes": mode(hertz, damping)})
        evidence = asked(case)[1].attribution
        low, high = evidence.lag_interval
        assert low <= evidence.lag == 0 <= high
        assert high - low < 0.07


@pytest.mark.slow
@pytest.mark.parametrize("road", [1.0, 3.0])
def test_impact_at_order_2_is_not_attributed_to_joints(road):
    """One pothole at the frequency of order 2 did all: at least 58 % were theirs, it had said."""
    case = made(7033, **PLAIN | {"guilt": 0.2, "road": road, "kind": "mixed"})
    truth, answer = asked(case)
    low, high = answer.attribution.interval
    assert truth < 0.01
    assert answer.attribution.damage_share == pytest.approx(truth, abs=0.04)
    assert low <= 0.04
    assert truth <= high


TORQUE_LAWS = {
    "a bent flange, the same under any torque": (lambda t: np.ones_like(t), UNDETERMINED),
    "the shaft's speed squared, whatever the torque": (None, UNDETERMINED),
    "less of it the more torque there is": (
        lambda t: np.clip(2 - np.abs(t), 0, None),
        UNDETERMINED,
    ),
    "proportional to the torque": (lambda t: t, JOINTS_DOMINANT),
    "rubber that yields ever less": (lambda t: np.tanh(2 * t), JOINTS_DOMINANT),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", TORQUE_LAWS)
@pytest.mark.parametrize("modes", [[], mode(35, 0.05)], ids=["rigid", "mode"])
@pytest.mark.parametrize("coasting", [True, False], ids=["coasting", "pulling"])
def test_order_2_independent_of_torque_is_not_attributed_to_joints(name, modes, coasting):
    """A gain that wanders from block to block had taken the torque out of it again."""
    law, finding = TORQUE_LAWS[name]
    case = made(
        5, **PLAIN | {"guilt": 0.0, "road": 2.0, "blows": 0, "engine": 0.0, "seconds": 90.0}
    )
    case.torque = case.torque if coasting else np.abs(case.torque)
    torque = case.torque / np.sqrt(np.mean(case.torque**2))
    speed = np.gradient(case.turns) * case.rate
    size = (speed / np.sqrt(np.mean(speed**2))) ** 2 if law is None else law(torque)
    wave = bracket(size * np.cos(4 * np.pi * case.turns), modes, case.rate)
    case.stress += 25 * wave / np.sqrt(2 * np.mean(wave**2))
    _, answer = asked(case)
    assert answer.attribution.verdict == finding
    assert (DOUBT_TORQUE_INDEPENDENT in answer.attribution.doubts) == (finding == UNDETERMINED)
    if finding == UNDETERMINED:
        assert answer.attribution.interval[0] <= 0  # the joints' own share


@pytest.mark.slow
@pytest.mark.parametrize("off", [0.12, -0.1, -0.2, 0.25])
def test_speed_with_wrong_tooth_count_gives_undetermined(off):
    """Far enough off, order 2 is found at no order of it, and had acquitted."""
    truth, answer = asked(made(5, **GUILTY_ONE | {"ratio_off": off}))
    low, high = answer.attribution.interval
    assert answer.attribution.verdict == UNDETERMINED
    assert DOUBT_SPEED_SCALE in answer.attribution.doubts
    assert low <= truth <= high + 0.05


def wobbling(kind, noise=0.0):
    """A recording with orders 1 and 3, its tone wheel 8 rpm eccentric: once a turn."""
    case = made(8, **PLAIN | {"guilt": 0.1, "road": 2.0, "blows": 0, "engine": 0.0, "kind": kind})
    case.stress += 8 * np.cos(6 * np.pi * case.turns) + 3 * np.cos(2 * np.pi * case.turns)
    rng = np.random.default_rng(8)
    wobble = 8 * np.cos(2 * np.pi * case.turns) + noise * rng.normal(size=case.turns.size)
    case.speed[case.speed > 1] += wobble[case.speed > 1] / 60
    return case


def test_tone_wheel_wobble_is_not_attributed_to_joints():
    """Through it a mode near order 3 had made order 3 of order 2: guilty, 0.63 at least of 0.06."""
    truth, answer = asked(wobbling("steady"))
    low, high = answer.attribution.interval
    assert truth < 0.1
    assert low <= truth <= high
    assert answer.attribution.verdict != JOINTS_DOMINANT


def test_speed_noise_does_not_accumulate_in_angle():
    """Of five readings one had counted: F was 30, and is some 600 as of a clean speed."""
    truth, answer = asked(wobbling("mixed", noise=5.0))
    assert answer.attribution.f_statistic > 300
    assert answer.attribution.interval[0] <= truth <= answer.attribution.interval[1]
    assert answer.attribution.verdict == JOINTS_NOT_DOMINANT


def test_all_speed_readings_count_in_angle():
    """A minute of 20 turns/s that scatter by 0.5: a hundredth is what rounding its ends leaves."""
    rate, n = 500.0, 30_000
    speed = 20 + 0.5 * np.random.default_rng(1).normal(size=n)
    turned = np.diff(shaft_angle(speed, rate=rate).rotation.at(np.array([0.5, n / rate - 0.5])))[0]
    assert turned == pytest.approx(speed[250:-250].sum() / rate, abs=0.02)


@pytest.mark.parametrize("changes", [False, True])
def test_tone_at_steady_speed_and_torque_gives_undetermined(changes):
    """Guilty, F 763,293, of a pump's 40.02 Hz beside a shaft at 1200 rpm: nothing tells which."""
    rate, n = 500.0, 30_000
    rng = np.random.default_rng(0)
    time = np.arange(n) / rate
    speed = 20 * (1 + changes * 0.03 * np.sin(0.3 * time)) + 1e-3 * rng.normal(size=n)
    turns = np.cumsum(speed) / rate
    tone = np.cos(4 * np.pi * turns) if changes else np.cos(2 * np.pi * 40.02 * time)
    found = separate_joint_caused_stress(
        1e6 * (40 * tone + rng.normal(size=n)), rate=rate, angle=shaft_angle(speed, rate=rate),
        torque=np.full(n, 1000.0), damage=damage, engine_orders=(3.0, 6.0),
    ).attribution  # fmt: skip
    # Where the speed changes a tone of fixed frequency is none of the shaft's.
    assert (DOUBT_CONSTANT_FREQUENCY in found.doubts) != changes
    assert (found.interval[0] <= 0) != changes


def beside_order_2(seed, *, at, by_torque, size=8.0, guilt=0.0):
    """A recording with something locked at another multiple of the shaft's speed."""
    case = made(seed, **PLAIN | {"guilt": guilt, "road": 2.0, "blows": 0, "engine": 0.0})
    load = case.torque / np.sqrt(np.mean(case.torque**2)) if by_torque else 1.0
    case.stress += size * load * np.cos(2 * np.pi * at * case.turns)
    return case


@pytest.mark.slow
@pytest.mark.parametrize("by_torque", [False, True])
@pytest.mark.parametrize("seed", [6, 8])
def test_tone_near_order_2_is_not_attributed_to_joints(seed, by_torque):
    """A tyre's or a pump's 1.8 comes and goes with the shaft as order 2 does, and is none of it."""
    _, answer = asked(beside_order_2(seed, at=1.8, by_torque=by_torque))
    assert answer.attribution.verdict == UNDETERMINED
    assert DOUBT_SPEED_SCALE in answer.attribution.doubts


def test_tone_near_order_2_is_not_added_to_joint_share():
    _, answer = asked(beside_order_2(5, at=1.8, by_torque=True, size=10.0, guilt=0.2))
    assert answer.attribution.f_statistic > MIN_DETECTION_F_STATISTIC
    assert answer.attribution.interval[0] < 0.3
    assert DOUBT_SPEED_SCALE in answer.attribution.doubts


def lugs(seed, *, order, axle, direct):
    """A recording in which 18 lugs of a tyre strike the harder the more it pulls, and no joint.

    Derived: a wheel turns once where the shaft turns as often as the axle's ratio says.
    """
    case = beside_order_2(seed, at=order, by_torque=True, size=25.0)
    angle = shaft_angle(case.speed, rate=case.rate)
    engine = angle.rotation.geared(1.0 if direct else 1.37)
    stress = case.stress * 1e6
    return separate_joint_caused_stress(
        stress, rate=case.rate, angle=angle, torque=case.torque, damage=damage, engine=engine,
        engine_orders=(3.0, 6.0), wheel=angle.rotation.geared(1 / axle) if axle else None,
    ).attribution  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(
    ("order", "axle", "direct", "finding"),
    [
        (18 / 9.067, 9.067, False, UNDETERMINED),
        (18 / 9.067, None, True, UNDETERMINED),
        (2.0, 9.0, False, UNDETERMINED),
        (18 / 9.067, 9.3, False, JOINTS_DOMINANT),
        (2.0, 4.5, True, JOINTS_DOMINANT),
    ],
    ids=[
        "at a wheel's whole order",
        "in direct gear",
        "at the shaft's own",
        "where nothing says so",
        "of too few lugs",
    ],
)
def test_tyre_lug_order_near_order_2_gives_undetermined(order, axle, direct, finding):
    """Of 58 gauges beside lugged tyres most were called guilty, at a speed 0.7 % off its own."""
    found = lugs(8, order=order, axle=axle, direct=direct)
    assert found.verdict == finding
    assert (DOUBT_SPEED_OF_OTHER_SHAFT in found.doubts) == (finding == UNDETERMINED)


def test_motor_at_twice_shaft_speed_gives_undetermined():
    """Of 24 gauges beside such a motor 21 were called guilty of what its rotor did."""
    case = made(8, **PLAIN | {"guilt": 1.5, "road": 2.0, "blows": 0, "engine": 0.0})
    angle = shaft_angle(case.speed, rate=case.rate)
    for times, finding in ((2.0, UNDETERMINED), (3.0, JOINTS_DOMINANT)):
        found = separate_joint_caused_stress(
            case.stress * 1e6, rate=case.rate, angle=angle, torque=case.torque, damage=damage,
            engine=angle.rotation.geared(times), engine_orders=(8.0, 24.0),
        ).attribution  # fmt: skip
        assert found.verdict == finding
        assert (DOUBT_ENGINE_ORDER_OVERLAP in found.doubts) == (finding == UNDETERMINED)


def gears_in_turn(*, joints, engine, share, pull, offset, phase, mode, blocks=2, seed=210):
    """Steady driving in an indirect gear, and for a share of it in direct gear: truth, answer.

    In direct gear order 2 of a four-cylinder engine is the shaft's order 2, at one angle to it.
    The engine's part of the torque is `offset` without any, the joints' goes with the torque.
    """
    rate, seconds = 400.0, 100.0
    rng, n = np.random.default_rng(seed), int(rate * seconds)
    t = np.arange(n) / rate
    direct = ((t / seconds * blocks) % 1) >= 1 - share
    speed = np.clip(20 + smooth(rng.normal(size=n), int(3 * rate)) * 40, 12, 30)
    motor = speed * smooth(np.where(direct, 1.0, 1.37), int(0.3 * rate))
    torque = smooth(np.where(direct, pull, 1.0), int(0.5 * rate))
    torque *= 1 + 0.25 * smooth(rng.normal(size=n), int(2 * rate)) * 25
    turns, motor_turns = np.cumsum(speed) / rate, np.cumsum(motor) / rate
    theirs = bracket(joints * torque * np.cos(4 * np.pi * turns + 1), mode, rate)
    force = (
        engine * (offset + (1 - offset) * np.abs(torque)) * np.cos(4 * np.pi * motor_turns + phase)
    )
    road = 2 * colour(rng, n, rate, low=0.8, high=150, slope=0.7) * np.sqrt(speed / 20)
    stress = 1e6 * (theirs + bracket(force, mode, rate) + bracket(road, mode, rate))
    found = separate_joint_caused_stress(
        stress, rate=rate, angle=shaft_angle(speed, rate=rate, engine=motor),
        torque=1500 * torque, damage=damage, engine=shaft_angle(motor, rate=rate).rotation,
        engine_orders=(2.0, 4.0),
    ).attribution  # fmt: skip
    return 1 - damage(stress - 1e6 * theirs) / damage(stress), found


def soft(hertz):
    return [{"hertz": hertz, "damping": 0.02, "share": 0.7}]


BESIDE_ENGINE = {
    "45 % of the joints, told as 99 % before": (
        {"joints": 15.6, "engine": 19.3, "share": 0.42, "pull": 0.7574, "offset": 0.7,
         "phase": 0.8426, "mode": soft(39.61335484340909)},
        0.45, UNDETERMINED,
    ),
    "an engine that works against the joints": (
        {"joints": 18.065720048684, "engine": 28.428092212016583, "share": 0.3082408520775228,
         "pull": 1.09796480698504, "offset": 0.0, "phase": 3.2115525870322363,
         "mode": soft(44.610014650235556), "seed": 14},
        -0.03, UNDETERMINED,
    ),
    "joints alone": (
        {"joints": 25.0, "engine": 0.0, "share": 0.42, "pull": 0.76, "offset": 0.7, "phase": 0.8,
         "mode": soft(39.6)},
        1.0, JOINTS_DOMINANT,
    ),
    "a weak engine beside strong joints": (
        {"joints": 25.0, "engine": 4.0, "share": 0.3, "pull": 0.76, "offset": 0.3, "phase": 0.8,
         "mode": []},
        1.0, JOINTS_DOMINANT,
    ),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", BESIDE_ENGINE)
def test_engine_order_on_order_2_for_part_of_drive_is_not_attributed_to_joints(name):
    how, share, finding = BESIDE_ENGINE[name]
    truth, found = gears_in_turn(**how)
    assert truth == pytest.approx(share, abs=0.05)
    assert found.verdict == finding
    assert DOUBT_ENGINE_ORDER_OVERLAP in found.doubts
    # Near a mode an engine that works against them can hide more than any interval holds.
    assert found.interval[1] >= truth
    assert found.interval[0] <= (0.5 if finding == UNDETERMINED else truth)


@pytest.mark.slow
def test_torque_dependent_tone_off_order_2_raises_speed_scale_doubt():
    _, answer = asked(beside_order_2(10, at=2.35, by_torque=False, size=11.0))
    assert answer.attribution.verdict == JOINTS_NOT_DOMINANT
    _, answer = asked(beside_order_2(10, at=2.35, by_torque=True, size=11.0))
    assert answer.attribution.verdict == UNDETERMINED
    assert DOUBT_SPEED_SCALE in answer.attribution.doubts


@pytest.mark.slow
def test_additional_gauge_does_not_change_result():
    """A second, noisy gauge listed beside S1 had changed S1's share."""
    case = made(5, **PLAIN | {"guilt": 0.5, "seconds": 60.0})
    noise = 60 * np.random.default_rng(0).normal(size=case.stress.size)
    channels = [case.stress, noise, case.speed * 60, case.torque / 1e3]
    told = []
    for gauges in (("S1",), ("S1", "S2")):
        recording = recording_from_arrays(
            np.stack(channels), rate=case.rate, names=["S1", "S2", "speed", "torque"],
            units=["MPa", "MPa", "rpm", "kNm"],
        )  # fmt: skip
        from cardan.topics.recording.study import RecordingStudy

        campaign = AnalysisOptions(
            sn="30,2e6,5", gauges=gauges, speed="speed", torque="torque", mask=(),
            between_samples="no",
        )  # fmt: skip
        causes = RecordingStudy(campaign).run(recording).answer.causes
        told.append((causes.joint_attributions[0], causes.attributions[0].damage_by_coalition))
    (one, alone), (other, beside) = told
    assert one == other
    np.testing.assert_allclose(beside[-1], alone[-1], rtol=1e-9)


SEEDS = range(7001, 7013)


def statistics(seeds):
    """Share inside, wrong ones, clear ones told."""
    rows = [(seed, *asked(made(seed))) for seed in seeds]
    inside = [t for _, t, a in rows if a.attribution.interval[0] <= t <= a.attribution.interval[1]]
    wrong = [
        (seed, t, a.attribution)
        for seed, t, a in rows
        if (a.attribution.verdict == JOINTS_DOMINANT and t < 0.25)
        or (a.attribution.verdict == JOINTS_NOT_DOMINANT and t >= 0.5)
    ]
    clear = [(t, a) for _, t, a in rows if t <= 0.1 or t >= 0.6]
    told = [
        a
        for t, a in clear
        if a.attribution.verdict == (JOINTS_DOMINANT if t >= 0.6 else JOINTS_NOT_DOMINANT)
    ]
    return len(inside) / len(rows), wrong, len(told) / max(len(clear), 1)


@pytest.mark.slow
def test_findings_of_12_misleading_recordings_are_not_wrong():
    """Of twelve, 90 % intervals miss three or more once in nine times at most; none is wrong.

    Of nine clear ones, told six times in ten, fewer than four are told once in ten times.
    """
    inside, wrong, told = statistics(SEEDS)
    assert not wrong
    assert inside >= 0.75
    assert told >= 0.4


@pytest.mark.parametrize(
    "count", [pytest.param(50, marks=pytest.mark.slow), pytest.param(200, marks=pytest.mark.long)]
)
def test_findings_of_misleading_recordings_are_not_wrong(count):
    inside, wrong, told = statistics(range(8000, 8000 + count))
    assert not wrong
    assert inside >= 0.85
    assert told >= 0.6


def test_finding_requires_both_interval_ends():
    def told(removed, low, high):
        return JointAttribution(
            damage_share=removed, interval=(low, high), f_statistic=99.0
        ).verdict

    assert told(0.6, 0.36, 0.9) == JOINTS_DOMINANT
    assert told(0.45, 0.36, 0.9) == UNDETERMINED
    assert told(0.6, 0.34, 0.9) == UNDETERMINED
    assert told(0.1, 0.0, 0.25) == JOINTS_NOT_DOMINANT
    assert told(0.1, 0.0, 0.26) == UNDETERMINED


def test_stretches_are_weighted_by_damage():
    parts = [
        JointAttribution(
            damage_share=r, interval=(r - 0.1, r + 0.1), f_statistic=s, doubts=(Finding(d),)
        )
        for r, s, d in ((0.8, 90.0, "a"), (0.2, 9.0, "b"))
    ]
    both = combine_attributions(parts, [3.0, 1.0])
    assert both.damage_share == pytest.approx(0.65)
    assert both.interval == pytest.approx((0.55, 0.75))
    assert (both.f_statistic, both.doubts) == (90.0, (Finding("a"), Finding("b")))


# --------------------------------------------------------------------------- the angle


def test_isolated_zero_speeds_are_gaps_and_standstill_is_kept():
    t = np.arange(6000) / 100
    v = np.clip(np.minimum(t, 60 - t), 0, 20)
    spoiled = v.copy()
    spoiled[3000:3100] = 0.0
    read = speed_readings(spoiled, rate=100.0)
    np.testing.assert_allclose(read.at(t), v, atol=1e-9)
    stopped = np.clip(v - 5, 0, None)
    np.testing.assert_allclose(speed_readings(stopped, rate=100.0).at(t), stopped, atol=1e-9)
    with pytest.raises(DesignError, match="two or more positive values"):
        speed_readings(np.full(100, np.nan), rate=100.0)


def test_speed_held_by_bus_is_steady_until_it_changes():
    """Half a minute at one speed, in steps of a tenth of a second: no ramp to the next one."""
    t = np.arange(0, 100, 0.005)
    drive = np.interp(t, [0, 30, 33, 63, 63.1, 100], [12, 12, 20, 20, 6, 6])
    held = np.repeat(np.round(drive[::20], 2), 20)
    read = speed_readings(held, rate=200.0).at(t)
    assert np.abs(read - drive)[(t < 62.8) | (t > 63.3)].max() < 0.4
    # And where it says but three values in all.
    few = np.where(t < 30, 12.0, np.where(t < 63, 20.0, 6.0))
    off = np.abs(speed_readings(few, rate=200.0).at(t) - few) > 0.01
    assert np.mean(off) * 100 <= 2.1


def test_coarse_shaft_speed_is_refined_by_engine_speed():
    """Once a second and half a second late: the engine's channel knows better."""
    case = made(7, **GUILTY_ONE | {"fault": "staircase", "steps": 1.0, "late": 0.5})
    angle = shaft_angle(case.speed, rate=case.rate, engine=case.engine)
    alone = shaft_angle(case.speed, rate=case.rate)
    assert angle.trusted
    assert not alone.trusted
    t = np.arange(2, 70, 0.1)
    true = np.interp(t, np.arange(case.turns.size) / case.rate, np.gradient(case.turns) * case.rate)
    moving = true > 2
    off = np.abs(angle.rotation.speed(t) - true)[moving]
    by_itself = np.abs(alone.rotation.speed(t) - true)[moving]
    assert off.mean() < 0.1
    assert off.mean() < 0.2 * by_itself.mean()


def test_tacho_too_fast_for_sample_rate_is_rejected():
    """60 pulses a turn at 2 kHz: from 800 rpm on they fold, and look like a slower shaft."""
    t = np.arange(20_000) / 2000
    pulses = (np.sin(2 * np.pi * 60 * 40 * t) > 0).astype(float)
    recording = recording_from_arrays(
        np.stack([pulses, pulses]), rate=2000.0, names=["S1", "tacho"]
    )
    with pytest.raises(DesignError, match="800 rpm"):
        measured_shaft_angle(AnalysisOptions(sn="30,2e6,5", tacho="tacho", pulses=60), recording)
    once = measured_shaft_angle(AnalysisOptions(sn="30,2e6,5", tacho="tacho", pulses=1), recording)
    assert once is not None


@pytest.mark.parametrize("speed", [lambda t: 40 + 0 * t, lambda t: 8 + 34 * t / 90])
def test_tacho_aliasing_at_higher_speed_is_rejected(speed):
    """At 4 kHz 1500 rpm are held apart; 2400 were told as 1732, and a ramp up to it as well."""
    t = np.arange(360_000) / 4000
    pulses = (np.sin(2 * np.pi * 60 * np.cumsum(speed(t)) / 4000) > 0).astype(float)
    recording = recording_from_arrays(
        np.stack([pulses, pulses]), rate=4000.0, names=["S1", "tacho"]
    )
    with pytest.raises(DesignError, match=r"read up to [12]\d\d\d rpm.* held apart up to 1600 rpm"):
        measured_shaft_angle(AnalysisOptions(sn="30,2e6,5", tacho="tacho", pulses=60), recording)


def test_highest_readable_tacho_speed_is_noted():
    t = np.arange(40_000) / 4000
    stress, pulses = np.sin(60 * t), (np.sin(2 * np.pi * 60 * 20 * t) > 0).astype(float)
    recording = recording_from_arrays(
        np.stack([stress, pulses]), rate=4000.0, names=["S1", "tacho"], units=["MPa", ""],
    )  # fmt: skip
    asked = AnalysisOptions(sn="30,2e6,5", gauges=("S1",), tacho="tacho", pulses=60)
    notes = RecordingStudy(asked).run(recording).answer.recording.notes
    assert any("held apart up to 1600 rpm" in str(n) for n in notes)


@pytest.mark.slow
def test_command_reports_finding(tmp_path):
    case = made(5, **GUILTY_ONE | {"modes": mode(55, 0.02), "seconds": 60.0})
    t = np.arange(case.stress.size) / case.rate
    rows = np.stack([t, case.stress, case.speed * 60, case.engine * 60, case.torque / 1e3], -1)
    head = "time [s],S1 [MPa],speed [rpm],engine [rpm],torque [kNm]"
    np.savetxt(tmp_path / "a.csv", rows, "%.7g", delimiter=",", header=head, comments="")
    more = ("--gauge", "S1", "--sn", "30,2e6,5", "--speed", "speed", "--torque", "torque",
            "--engine-orders", "3,6")  # fmt: skip
    done = CliRunner().invoke(
        command, [str(tmp_path / "a.csv"), *more, "--engine", "engine", "--json"]
    )
    assert done.exit_code == 0, done.output
    (gauge,) = json.loads(done.output)["gauges"]
    joints = next(c for c in gauge["causes"] if c["cause"] == "joints")
    for told in (gauge, joints):
        assert told["finding"] == JOINTS_DOMINANT
        low, high = told["removed_interval"]
        assert 0.35 < low <= told["removed"] <= high
    assert gauge["modes"][0]["frequency_Hz"] == pytest.approx(55, rel=0.02)
    whole = gauge["damage"]
    assert 1 - joints["damage_without"] / whole == pytest.approx(gauge["removed"], abs=0.02)
    blind = CliRunner().invoke(command, ["--all", str(tmp_path / "a.csv"), *more])
    assert "90 % interval" in blind.output
    assert "JOINTS DOMINATE" in blind.output
    assert "no engine speed was given" in blind.output
