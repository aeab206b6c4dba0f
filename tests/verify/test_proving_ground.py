"""Who broke the bracket, asked of drives that another hand stepped through time."""

import numpy as np
import pytest
from proving_ground import drive

from cardan.physics.fatigue.damage import miner_damage
from cardan.physics.fatigue.rainflow import rainflow
from cardan.physics.fatigue.sn_curve import SNCurve
from cardan.physics.signals.attribution_result import (
    DOUBT_BUMP_STOP_IMPACTS,
    DOUBT_ENGINE_ORDER_OVERLAP,
    DOUBT_HALF_SPEED,
    DOUBT_LINE_RESTS_ON_BUMP_STOP,
    DOUBT_NO_ENGINE_SPEED,
    DOUBT_NO_TORQUE,
    DOUBT_SHORT_TORQUE_PULSE,
    JOINTS_DOMINANT,
    JOINTS_NOT_DOMINANT,
    UNDETERMINED,
)  # fmt: skip
from cardan.physics.signals.joint_attribution import FULL_CONFIDENCE_F_STATISTIC
from cardan.physics.signals.recording import recording_from_arrays
from cardan.physics.signals.shaft_angle import shaft_angle
from cardan.physics.signals.synchronous_fit import MIN_DETECTION_F_STATISTIC
from cardan.topics.recording.options import AnalysisOptions
from cardan.topics.recording.study import RecordingStudy

CURVE = SNCurve(amplitude=30e6, cycles=2e6, slope=5).modified()


def damage(stress):
    return miner_damage(rainflow(1e6 * stress), curve=CURVE)


def heard(of):
    """What a user is told of each gauge: its life and the joints' evidence."""
    recording = recording_from_arrays(of.data, rate=of.rate, names=of.names, units=of.units)
    engine = "engine" if "engine" in of.names else None
    campaign = AnalysisOptions(
        sn="30,2e6,5", gauges=("S1", "S2"), speed="speed", engine=engine,
        engine_orders=of.orders,
        torque="torque" if "torque" in of.names else None,
        mask=("sentinel", "spike", "dropout"), between_samples="no",
    )  # fmt: skip
    answer = RecordingStudy(campaign).run(recording).answer
    return list(zip(answer.lives, answer.causes.joint_attributions, strict=True))


def truths(of):
    return [1 - damage(b) / damage(a) for a, b in zip(of.stress, of.without, strict=True)]


def statistics(seeds, **asked):
    """Share inside, wrong ones, clear ones told, and damages wrong by a fifth without a veto."""
    inside, wrong, clear, told, spoiled = [], [], 0, 0, []
    for seed in seeds:
        of = drive(seed, **asked)
        for k, (truth, (life, found)) in enumerate(zip(truths(of), heard(of), strict=True)):
            if life.vetoed:
                continue
            low, high = found.interval
            inside.append(low <= truth <= high)
            guilty = truth >= 0.6
            if guilty or truth <= 0.1:
                clear += 1
                told += found.verdict == (JOINTS_DOMINANT if guilty else JOINTS_NOT_DOMINANT)
            if (found.verdict == JOINTS_DOMINANT and truth < 0.25) or (
                found.verdict == JOINTS_NOT_DOMINANT and truth >= 0.5
            ):
                wrong.append((seed, k, truth, found))
            # What happened in a hole nobody knows, and its time is not counted as lived.
            off = life.life.damage / damage(of.stress[k][~np.isnan(of.data[k])])
            if not 0.8 < off < 1.25:
                spoiled.append((seed, k, off))
    return np.mean(inside), wrong, told / clear, spoiled


@pytest.mark.slow
def test_bracket_resonance_on_rough_road_is_not_contact_noise():
    """A mode at a fifth of the sample rate: five of its spells were flat enough in frequency."""
    of = drive(650023)
    (life, _), _ = heard(of)
    assert not {"noise"} & {effect.kind for effect in life.quality.effects}
    assert not life.vetoed
    assert life.life.damage == pytest.approx(damage(of.stress[0]), rel=0.02)


@pytest.mark.parametrize(
    "count", [pytest.param(8, marks=pytest.mark.slow), pytest.param(30, marks=pytest.mark.long)]
)
def test_findings_of_drives_are_not_wrong(count):
    """Sixty gauges: 90 % intervals miss thirteen or more once in 180 times; none is wrong.

    Of 46 clear ones eighteen or fewer are told once in 300 times, if 60 % are of many. 25 are: of
    the first ten drives two of fourteen, for most have no torque, or no engine that is known.
    """
    inside, wrong, told, spoiled = statistics(range(50_000, 50_000 + count))
    assert not wrong
    assert not spoiled
    assert inside >= 0.8
    assert told >= 0.4 or count < 30


@pytest.mark.long
def test_findings_of_100_drives_on_two_gauges_are_not_wrong():
    inside, wrong, told, spoiled = statistics(range(60_000, 60_100))
    assert not wrong
    assert not spoiled
    assert inside >= 0.85
    assert told >= 0.6


@pytest.mark.long
def test_intervals_of_30_drives_on_stop_hold_truth():
    """Of 58 gauges 90 % intervals miss fifteen once in 200 times if they hold 85 %.

    They had held 67 %: what a stop makes of the joints' swing no line's wave tells.
    """
    inside, _, told, _ = statistics(range(50_100, 50_130), stop=True)
    assert inside >= 0.75
    assert told > 0.35


@pytest.mark.slow
@pytest.mark.parametrize("seed", [730_177, 730_060])
def test_torque_correlated_peaks_on_stop_raise_upper_bound_to_one(seed):
    """Line on its stop: of all that was theirs 84 % at most, and 66 %, it had said."""
    of = drive(seed, stop=True)
    for truth, (_, found) in zip(truths(of), heard(of), strict=True):
        assert truth > 0.99
        assert found.interval[1] == 1
        assert DOUBT_LINE_RESTS_ON_BUMP_STOP in found.doubts


@pytest.mark.slow
def test_missing_torque_leaves_order_correlated_damage_undetermined():
    """Without one nothing says whether crests go with it: half was theirs, not a fifth."""
    of = drive(730_171, stop=True)
    assert "torque" not in of.names
    for truth, (_, found) in zip(truths(of), heard(of), strict=True):
        assert truth > 0.5
        assert found.verdict == UNDETERMINED


@pytest.mark.slow
def test_torque_correlated_peaks_do_not_widen_interval_without_stop():
    """A straight bracket: its interval is no wider for crests that go with the torque."""
    of = drive(31, kind="run-ups", bent=2.4, seconds=90.0, engine=0.0, stop=False, **CALM)
    for truth, (_, found) in zip(truths(of), heard(of), strict=True):
        low, high = found.interval
        assert DOUBT_LINE_RESTS_ON_BUMP_STOP not in found.doubts
        assert low <= truth <= high
        assert found.verdict == JOINTS_DOMINANT


@pytest.mark.slow
def test_joint_stress_that_reduces_damage_gives_negative_lower_bound():
    """Its share was 0 at least: taken off, what holds the line off its stop does damage.

    A line on its stop goes by the last digit of a machine: from -0.09 on one to 0.01 on another.
    """
    of = drive(730_017, stop=True)
    for truth, (_, found) in zip(truths(of), heard(of), strict=True):
        assert truth < 0.03
        assert found.interval[0] < -0.03
        assert found.verdict == JOINTS_NOT_DOMINANT


CALM = {
    "gauge_fault": "none", "speed_fault": "none", "source": "fine", "torque": "shaft",
    "engine_known": True, "rate": 500.0, "cylinders": 6,
}  # fmt: skip


@pytest.mark.slow
def test_engine_speed_fills_gap_in_shaft_speed():
    of = drive(21, kind="town", **CALM)
    speed, engine = (of.data[of.names.index(n)] / 60 for n in ("speed", "engine"))
    time = np.arange(speed.size) / of.rate
    hurt = speed.copy()
    # In gear and pulling: the longest stretch above six turns a second in which its ratio stays.
    ratio = np.round(engine / np.maximum(speed, 0.1), 1)
    steady = np.convolve(np.abs(np.gradient(ratio)) < 1e-9, np.ones(1500), "same")
    at = int(np.argmax(np.where(speed > 6, steady, 0)))
    hurt[at : at + int(0.8 * of.rate)] = np.nan
    whole, filled, alone = (
        shaft_angle(s, rate=of.rate, engine=e)
        for s, e in ((speed, engine), (hurt, engine), (hurt, None))
    )
    assert not len(whole.lost_intervals)
    assert not len(filled.lost_intervals)
    assert len(alone.lost_intervals) == 1
    assert all(angle.trusted for angle in (whole, filled, alone))
    # Beside the hole the channel itself counts: shifts are in it, and in no gear's ratio.
    # Within half of a third of a second the hole's cubics reach beyond it.
    beside = (time < time[at] - 0.25) | (time > time[at] + 1)
    off = filled.rotation.speed(time[beside]) - whole.rotation.speed(time[beside])
    np.testing.assert_allclose(off, 0, atol=1e-9)


@pytest.mark.slow
def test_lost_angle_restarts_from_new_zero():
    """Three holes of two seconds, and nobody knows how far it turned in them."""
    of = drive(31, kind="run-ups", bent=2.4, seconds=90.0, **CALM)
    truth = truths(of)
    assert min(truth) > 0.9
    row = of.names.index("speed")
    for at in (20.0, 45.0, 70.0):
        of.data[row, int(at * of.rate) : int((at + 2) * of.rate)] = np.nan
    kept = [k for k, name in enumerate(of.names) if name != "engine"]
    of.data = of.data[kept]
    of.names, of.units = ([of_all[k] for k in kept] for of_all in (of.names, of.units))
    for t, (_, found) in zip(truth, heard(of), strict=True):
        low, high = found.interval
        assert found.verdict == JOINTS_DOMINANT
        assert 0.7 < low <= t <= high


@pytest.mark.slow
def test_unknown_engine_leaves_doubt():
    """A drive that had been told wrongly: four cylinders in direct gear, and no word of them."""
    of = drive(90_000)
    assert "engine" not in of.names
    assert of.orders == ""
    (_, one), _ = heard(of)
    low, high = one.interval
    assert low <= truths(of)[0] <= high
    assert one.verdict == UNDETERMINED
    assert DOUBT_NO_ENGINE_SPEED in one.doubts
    of.orders = "3,6"  # who says that it has six is believed, and answers for it
    (_, other), _ = heard(of)
    assert DOUBT_NO_ENGINE_SPEED not in other.doubts


@pytest.mark.slow
@pytest.mark.parametrize("seed", [110_096, 710_101])
def test_order_correlated_damage_alone_gives_undetermined(seed):
    """Drives that had been told wrongly: order 2 knocks a stop, and little stays locked.

    The second one's speed gives no angle, and its line is just not found.
    """
    of = drive(seed)
    for truth, (_, found) in zip(truths(of), heard(of), strict=True):
        assert truth > 0.99
        assert found.verdict == UNDETERMINED


@pytest.mark.slow
def test_joints_dominate_without_torque_channel_if_order_2_is_followed():
    """No torque, so nothing is locked; but it goes with order 2 through all frequencies."""
    of = drive(90_044)
    assert "torque" not in of.names
    for truth, (_, found) in zip(truths(of), heard(of), strict=True):
        low, high = found.interval
        assert found.f_statistic < MIN_DETECTION_F_STATISTIC
        assert found.verdict == JOINTS_DOMINANT
        assert 0.5 < low <= truth <= high
    # Of another half of it comes with order 2 where a road shook a mode: it convicts nobody.
    other = drive(60_078)
    (_, found), _ = heard(other)
    assert abs(truths(other)[0]) < 0.01
    assert found.verdict == JOINTS_NOT_DOMINANT
    assert found.interval[0] < 0


@pytest.mark.slow
def test_other_gears_decide_if_engine_order_coincides_with_order_2():
    of = drive(90_065)
    (_, found), _ = heard(of)
    low, high = found.interval
    assert DOUBT_ENGINE_ORDER_OVERLAP in found.doubts
    assert found.verdict == JOINTS_DOMINANT
    assert low <= truths(of)[0] <= high
    # A motorway has no other gear.
    of = drive(90_008)
    for truth, (_, found) in zip(truths(of), heard(of), strict=True):
        assert truth > 0.9
        assert DOUBT_ENGINE_ORDER_OVERLAP in found.doubts
        assert found.verdict == UNDETERMINED


@pytest.mark.slow
def test_unbalance_is_not_order_2_of_half_speed_shaft():
    """It goes with the square of the speed; a shaft's order 2 with the torque, if it is that."""
    of = drive(90_064)
    for truth, (_, found) in zip(truths(of), heard(of), strict=True):
        assert truth == pytest.approx(0, abs=0.01)
        assert found.verdict == JOINTS_NOT_DOMINANT
    of = drive(60_007)
    of.data[of.names.index("speed")] *= 2
    for truth, (_, found) in zip(truths(of), heard(of), strict=True):
        assert truth > 0.99
        assert DOUBT_HALF_SPEED in found.doubts
        assert found.verdict == UNDETERMINED


@pytest.mark.slow
def test_permanent_stop_contact_without_impacts_gives_undetermined():
    """A drive that had been told wrongly: all crests rise with order 2, a fifth is locked."""
    of = drive(120_091)
    for truth, (_, found) in zip(truths(of), heard(of), strict=True):
        assert truth > 0.9
        assert DOUBT_BUMP_STOP_IMPACTS in found.doubts
        assert found.verdict == UNDETERMINED


@pytest.mark.slow
def test_faint_order_line_without_torque_gives_undetermined():
    """A drive that had been told wrongly: on its stop, with no torque; 24 % at most, it said."""
    of = drive(610_046)
    assert "torque" not in of.names
    for truth, (_, found) in zip(truths(of), heard(of), strict=True):
        assert truth > 0.99
        assert MIN_DETECTION_F_STATISTIC <= found.f_statistic < FULL_CONFIDENCE_F_STATISTIC
        assert found.verdict == UNDETERMINED


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "doubt"),
    [
        (130_096, DOUBT_BUMP_STOP_IMPACTS),
        (140_025, DOUBT_LINE_RESTS_ON_BUMP_STOP),
        (140_078, DOUBT_LINE_RESTS_ON_BUMP_STOP),
        (630_081, DOUBT_LINE_RESTS_ON_BUMP_STOP),
    ],
)
def test_torque_correlated_peaks_give_undetermined(seed, doubt):
    """Drives that had been told wrongly: on their stop all the time, little locked, no blows.

    Of the first nobody measured the torque: its crests go with order 2, faint as it is.
    """
    of = drive(seed)
    told = list(zip(truths(of), (found for _, found in heard(of)), strict=True))
    assert all(truth > 0.8 and found.verdict != JOINTS_NOT_DOMINANT for truth, found in told)
    held = [(t, found.interval) for t, found in told if doubt in found.doubts]
    assert held
    assert all(low <= t <= high + 0.25 for t, (low, high) in held)


@pytest.mark.slow
def test_untrusted_angle_gives_undetermined_if_order_2_is_found():
    """A drive that had been told wrongly: the line meets its stop, and only a GPS turns it."""
    of = drive(90_001)
    for truth, (_, found) in zip(truths(of), heard(of), strict=True):
        assert truth > 0.9
        assert found.f_statistic > MIN_DETECTION_F_STATISTIC
        assert found.verdict == UNDETERMINED


@pytest.mark.slow
def test_missing_torque_leaves_doubt_and_interval_holds_truth():
    of = drive(40, kind="highway", bent=2.4, seconds=80.0, **CALM | {"torque": "none"})
    truth = truths(of)
    for t, (_, found) in zip(truth, heard(of), strict=True):
        low, high = found.interval
        assert low <= t <= high
        assert t > 0.5
        assert DOUBT_NO_TORQUE in found.doubts


@pytest.mark.slow
def test_damage_of_single_launch_gives_undetermined():
    """In one start the line knocks at its stop, twice a turn: that is near no order."""
    of = drive(40, kind="country", bent=0.0, rough=0.02, seconds=80.0, **CALM)
    for row in (*of.data[:2], *of.stress, *of.without):
        row *= 0.2
    rate, n = of.rate, of.stress.shape[1]
    t = np.arange(n) / rate
    pull = np.exp(-(((t - 40) / 0.6) ** 2))
    torque, speed = of.names.index("torque"), of.names.index("speed")
    angle = 2 * np.pi * np.cumsum(of.data[speed] / 60) / rate
    of.data[torque] = 600 + 7000 * pull
    knocks = np.diff(np.floor(angle / np.pi), prepend=0) > 0
    ring = np.exp(-25 * t[:100]) * np.sin(2 * np.pi * 70 * t[:100])
    swing = 120 * np.convolve(knocks * pull, ring)[:n]
    of.data[0] += swing
    of.stress[0] += swing
    assert truths(of)[0] > 0.8
    _, found = heard(of)[0]
    assert found.verdict == UNDETERMINED


@pytest.mark.slow
def test_stop_impacts_at_order_2_give_undetermined():
    """A drive that had been told wrongly: a seventh is locked, and blows come where it is loud."""
    of = drive(60_051)
    _, (_, found) = heard(of)
    low, high = found.interval
    assert found.verdict == UNDETERMINED
    assert low <= truths(of)[1] <= high
    assert DOUBT_BUMP_STOP_IMPACTS in found.doubts


@pytest.mark.slow
def test_chance_damage_at_high_torque_is_not_attributed_to_joints():
    """Its crests do not go with the torque: of 21 innocent gauges untold for it, seven were so."""
    of = drive(660016)
    assert max(truths(of)) < 0.01
    for _, found in heard(of):
        assert found.verdict == JOINTS_NOT_DOMINANT
    # Where they do, nobody is acquitted.
    of = drive(660034)
    assert min(truths(of)) > 0.9
    for _, found in heard(of):
        assert DOUBT_SHORT_TORQUE_PULSE in found.doubts
        assert found.verdict == UNDETERMINED
