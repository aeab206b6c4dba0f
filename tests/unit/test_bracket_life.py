"""From a load history on a bracket to damage: made-up unit stresses, no solver."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from brackets import BRACKET, LINE

from cardan import files
from cardan.base.errors import BadFile, DesignError
from cardan.base.part import Occasion
from cardan.base.source import MINER
from cardan.base.units import MPa, hour, rpm
from cardan.base.verdict import Limit, badness
from cardan.bracket.gauges import recover
from cardan.fatigue.strength import SNCurve
from cardan.loads.cycle import Cycle
from cardan.loads.statics import loads
from cardan.model.application import DutyPoint
from cardan.model.bracket import Bolts, Bracket, FatigueCurve, UShape
from cardan.model.material import Material
from cardan.report.contract import check
from cardan.report.language import Language
from cardan.report.wording import place
from cardan.study.approval import assess
from cardan.study.bracket import (
    Bench,
    BracketAnswer,
    _unanswered,
    cases_of,
    checks_of,
    duty_of,
)
from cardan.study.bracket_judge import Case, Feature, Judged
from cardan.study.bracket_life import (
    ALONE,
    Endured,
    Strength,
    endured,
    gauge_damage,
    loads_of,
    mixed,
    round_the_turn,
    spot_damage,
)

TRUCK = Path(__file__).parents[2] / "examples" / "medium-truck-4x2.yaml"
SHAPE = UShape(
    seat_diameter=0.1, width=0.07, thickness=0.006, height=0.09, flange=0.055,
    bend_radius=0.01, bolt_diameter=0.011, bolt_pitch=0.04,
)  # fmt: skip
CURVE = FatigueCurve(amplitude=100 * MPa, cycles=1e6, slope=5)
PLAIN = Material(name="plain", youngs_modulus=200e9, density=7850)
STRONG = Material(name="strong", youngs_modulus=200e9, density=7850, ultimate_strength=600 * MPa)
UNIT = np.zeros((2, 9, 6))
UNIT[0, 2, 2] = 1 * MPa  # 1 MPa along z for a newton up
UNIT[1, 1, 3] = 1 * MPa  # shear for a newton sideways: swings most at 45 degrees


def strength(material=PLAIN):
    found = Strength.of(Bracket(shape=SHAPE, material=material, fatigue=CURVE))
    assert found is not None
    return found


def up(mean, amplitude, order=2, samples=64):
    return round_the_turn([0, 0, mean], {order: [0, 0, amplitude]}, samples=samples)


def test_a_sine_does_the_damage_of_its_cycles():
    """Two cycles of 200 MPa a turn: 2 (200 / 100)^5 / 1e6, by hand; the crests are sampled."""
    spots = spot_damage(UNIT, up(0, 200), strength=strength())
    assert spots == pytest.approx([2 * 2**5 / 1e6, 0], rel=1e-12)
    # Half a turn holds one of the two.
    half = spot_damage(UNIT, up(0, 200)[:32], strength=strength())
    assert half == pytest.approx([2**5 / 1e6, 0], rel=1e-12)


def test_shear_counts_on_its_own_plane():
    loads = round_the_turn(np.zeros(3), {2: [0, 200, 0]})
    assert spot_damage(UNIT, loads, strength=strength())[1] == pytest.approx(2 * 2**5 / 1e6)


def test_small_cycles_count_by_haibach_and_no_cycle_does_nothing():
    """Beyond the knee k is 2 * 5 - 1 = 9."""
    assert spot_damage(UNIT, up(0, 50), strength=strength())[0] == pytest.approx(2 * 0.5**9 / 1e6)
    assert spot_damage(UNIT, loads_of([[0, 0, 500.0]]), strength=strength()) == pytest.approx(0)


def test_a_tensile_mean_counts_where_the_strength_is_known():
    """Goodman: 150 MPa on a mean of 150 is 150 / (1 - 150 / 600) = 200 MPa."""
    pulled = spot_damage(UNIT, up(150, 150), strength=strength(STRONG))[0]
    assert pulled == pytest.approx(2 * 2**5 / 1e6)
    ignored = spot_damage(UNIT, up(150, 150), strength=strength())[0]
    assert ignored == pytest.approx(2 * 1.5**5 / 1e6)
    assert Strength.of(Bracket(shape=SHAPE)) is None


def test_order_content_is_the_sum_of_its_waves():
    c1, c2 = np.array([3 + 4j, 0, 1]), np.array([0, 2j, 5])
    loads = round_the_turn([1, 2, 3], {1: c1, 2: c2}, samples=8)
    theta = 2 * np.pi * 3 / 8
    expected = np.array([1, 2, 3]) + (c1 * np.exp(1j * theta)).real + (c2 * np.exp(2j * theta)).real
    assert loads.shape == (8, 9)
    assert loads[3, :3] == pytest.approx(expected)
    six = round_the_turn(np.arange(6), {0.5: np.ones(6)}, turns=2)
    assert six.shape == (128, 9)
    assert six[64, :6] == pytest.approx(np.arange(6) - 1)  # half order: a turn on, the other way
    assert np.all(six[:, 6:] == 0)


@pytest.mark.parametrize("bad", [np.zeros((5, 4)), np.zeros(3)])
def test_a_history_has_three_or_six_components(bad):
    with pytest.raises(ValueError, match="samples, 3, 6 or 9"):
        loads_of(bad)


def test_a_history_with_holes_is_refused():
    with pytest.raises(DesignError, match="mend it first"):
        loads_of([[0, 0, np.nan]])


def test_a_gauge_counts_the_stress_it_shows():
    """1 MPa in 200 GPa is five microstrain."""
    influence = np.zeros((1, 9))
    influence[0, 2] = MPa / 200e9
    found = gauge_damage(influence, up(0, 200), modulus=200e9, strength=strength())
    assert found == pytest.approx([2 * 2**5 / 1e6])


def test_a_gauge_s_mean_stress_counts():
    """By Goodman as at a spot; of two gauges each counts its own, of none nothing is counted."""
    influence = np.zeros((2, 9))
    influence[:, 2] = MPa / 200e9, -MPa / 200e9
    pull, push = gauge_damage(influence, up(150, 150), modulus=200e9, strength=strength(STRONG))
    assert pull == pytest.approx(2 * 2**5 / 1e6)
    assert push < pull / 2
    assert not gauge_damage(influence[:0], up(0, 1), modulus=200e9, strength=strength()).size


def test_gauges_read_in_the_field_make_life_at_the_hot_spots():
    """What gauges read gives the force, the force the stress, the stress the damage."""
    random = np.random.default_rng(1)
    influence = 1e-8 * random.standard_normal((4, 3))
    force = random.normal(scale=150, size=(500, 3))
    back = recover(influence, force @ influence.T)
    straight = spot_damage(UNIT, loads_of(force), strength=strength())
    assert spot_damage(UNIT, loads_of(back.loads), strength=strength()) == pytest.approx(straight)
    assert straight.min() > 0


def test_a_duty_cycle_adds_rates_and_the_worst_place_counts():
    how = {"unit": UNIT, "influence": np.zeros((0, 9)), "modulus": 2e11, "strength": strength()}
    # 2 turns a second, 1 in 4 of the time; the other part runs 4 times as fast and half as high.
    slow = endured(up(0, 200), **how, turns=1, duration=0.5)
    fast = endured(
        np.concatenate([up(0, 50), up(0, 100)]), **how, places=2, turns=1, duration=0.125
    )
    assert fast.spots[0] == pytest.approx(2e-6)  # of 100 MPa; 50 MPa does less
    assert (slow.per_turn, slow.per_hour) == pytest.approx((64e-6, 64e-6 * 2 * 3600))
    both = mixed("duty", [(1.0, slow), (3.0, fast)])
    assert both.spots[0] == pytest.approx(0.25 * 2 * 64e-6 + 0.75 * 8 * 2e-6)
    assert both.turns == pytest.approx(0.25 * 2 + 0.75 * 8)
    assert both.hours == pytest.approx(1 / (3600 * both.spots[0]))
    rest = endured(loads_of([[0, 0, 1.0]]), **how, turns=1, duration=1)
    assert rest.hours == np.inf
    assert np.isnan(endured(up(0, 200), **how, turns=1).hours)


TEXT = (
    LINE.replace("speed_rpm: 2500", "speed_rpm: 2400")
    + """\
duty:
  - {share_percent: 75, torque_Nm: 8000, speed_rpm: 2400}
  - {share_percent: 25, torque_Nm: 4000, speed_rpm: 600}
include: [unbalance]
"""
    + BRACKET
    + """\
  fatigue: {amplitude_MPa: 150, cycles: 2.0e+6, slope: 5}
"""
)


def test_the_file_gives_the_curve():
    application = files.loads(TEXT)
    assert application.bracket.fatigue == FatigueCurve(amplitude=150e6, cycles=2e6, slope=5)
    assert Strength.of(application.bracket).curve == SNCurve(
        amplitude=150e6, cycles=2e6, slope=5, beyond=9
    )
    properties = files.schema()["$defs"]["Fatigue"]["properties"]
    assert {"amplitude_MPa", "cycles", "slope"} <= set(properties)
    with pytest.raises(BadFile, match="slope"):
        files.loads(TEXT.replace("slope: 5", "slope: 0.5"))
    with pytest.raises(DesignError, match="slope of at least 1"):
        FatigueCurve(amplitude=1.0, cycles=1.0, slope=0.5)


def test_cases_and_duty_know_how_long_a_pass_lasts():
    application = files.loads(TEXT)
    (response,) = assess(application).responses
    by = {c.what: c for c in cases_of(application.bracket, response)}
    turn = 2 * np.pi / (2400 * rpm)
    assert (by["combined"].turns, by["combined"].duration) == pytest.approx((0.5, turn / 2))
    assert (by["peak"].turns, by["peak"].duration) == pytest.approx((1, turn))
    assert not by["static"].repeats
    ((when, parts),) = duty_of(application.bracket, response).items()
    assert str(when) == "duty cycle, as given"
    (most, first), (rest, second) = parts
    assert (most, rest) == (0.75, 0.25)
    # At the check's own torque and speed the cycle's loads are the check's, but for half a
    # newton of the shafts' inertia.
    assert first.loads == pytest.approx(by["peak"].loads, abs=0.5)
    assert second.duration == pytest.approx(4 * turn)
    # Half the torque halves order 2; a quarter of the speed leaves a 16th of the unbalance.
    passes = second.loads.reshape(4, 64, 9)[..., :3]
    mean = by["static"].loads[0, :3]
    once = np.abs(np.fft.rfft(passes[0], axis=0)[1]) / 32
    whole = np.abs(np.fft.rfft(first.loads.reshape(4, 64, 9)[0, :, :3], axis=0)[1]) / 32
    assert passes[0].mean(axis=0) == pytest.approx(mean / 2, abs=0.02)
    assert once == pytest.approx(whole / 16)


def test_heavy_spots_opposite_are_the_same_half_a_turn_later():
    """Of eight heavy spots round the turn the four told leave out none: each is one, or late."""
    application = files.loads(TEXT)
    (response,) = assess(application).responses
    (peak,) = (c for c in cases_of(application.bracket, response) if c.what == "peak")
    waves = response.loads.bearing_forces.waves[0, 0]
    turn = Cycle(waves).values(64)
    theta = 2 * np.pi * np.arange(64) / 64
    size = float(response.unbalance.bearing_forces[0, 0])
    told = peak.loads.reshape(peak.places, 64, 9)[..., :3]
    for k in range(8):
        at = theta - k * np.pi / 4
        spot = turn + size * np.stack([0 * at, np.cos(at), np.sin(at)], axis=-1)
        late = (spot, np.roll(spot, 32, axis=0))
        assert any(np.allclose(a, b, rtol=1e-9, atol=1e-6) for a in late for b in told)


def test_a_bracket_gets_what_its_bearing_carries_on_rubber():
    """Medium truck, jounce: 225 N of order 2 on a rigid bearing, ten times that in first gear.

    Far above its modes rubber lets little through: cruising in top gear hands the bracket
    less of order 2 than a rigid bearing would, and what it wears out follows that.
    """
    application = files.read(TRUCK)
    bracket = Bracket(shape=SHAPE, material=STRONG, fatigue=CURVE, line="main", bearing=1)
    (response,) = assess(application).responses
    cases = {(c.name, c.what): c for c in cases_of(bracket, response)}
    rigid, worst = cases["jounce", "order 2"], cases["jounce", "worst point"]
    assert worst.point == response.worst["peak"].named((response.demand.states.index("jounce"), 0))
    assert rigid.point is None

    def shaken(case):
        """Return the largest 0-to-peak of order 2 along any direction, N."""
        force = case.loads.reshape(case.places, -1, 9)[0, :, :3]
        turns = {1.0: 2, 0.5: 1}[case.turns]
        wave = np.fft.fft(force, axis=0)[turns] * 2 / len(force)
        directions = np.random.default_rng(0).normal(size=(4000, 3))
        directions /= np.linalg.norm(directions, axis=-1)[:, None]
        return np.abs(directions @ wave).max()

    assert shaken(rigid) == pytest.approx(227, abs=1)
    peak = response.worst["peak"].running
    assert shaken(worst) == pytest.approx(peak.orders[4, 0, 0], rel=2e-3)
    assert shaken(worst) > 8 * shaken(rigid)
    mean = worst.loads[:, :3].reshape(8, -1, 3).mean(axis=(0, 1))
    assert np.linalg.norm(mean) == pytest.approx(peak.static[4, 0], rel=1e-9)
    cruising = replace(application, duty=(DutyPoint(share=1.0, torque=600.0, speed=2250 * rpm),))
    (response,) = assess(cruising).responses
    ((_, ((_, case),)), *_) = duty_of(bracket, response).items()
    still = loads(
        response.layout, response.turn, response.line, torque=600.0
    ).bearing_forces.amplitude(2)
    s = [x.name for x in application.states].index(case.name)
    assert 0 < shaken(case) < 0.1 * still[s, 0]


def test_what_rides_on_a_bracket_weighs_on_it():
    """Standing still is felt as 1 g up: 12 kg pull down with 117.7 N beside what is given."""
    text = TEXT + "  carried_mass_kg: 12\n  cases: [{name: still, force_N: [0, 0, -50], "
    application = files.loads(text + "acceleration_g: [0, 0, 1]}]\n")
    (response,) = assess(application).responses
    still = next(iter(cases_of(application.bracket, response)))
    assert still.loads[0, :3] == pytest.approx([0, 0, -50 - 12 * 9.80665])
    assert still.loads[0, 6:] == pytest.approx([0, 0, 9.80665])


def test_the_highest_speed_is_the_line_s_whichever_states_are_listed():
    """A file whose one state turns at 600 rpm had 8.4 times the excitation that has 2.1."""
    states = "states: [{name: empty, travel_mm: 0, speed_rpm: 600}]\n"
    application = files.loads(TEXT + states)
    assert Bench.of(application).top_speed == pytest.approx(2400 * rpm)
    assert Bench.of(files.loads(TEXT)).top_speed == pytest.approx(2400 * rpm)


def test_nobody_drives_for_hours_on_the_bump_stop():
    """A state with its own geometry counts as what its name says."""
    states = "states: [{name: gvw, travel_mm: 0}, {name: jounce, travel_mm: 0}, {name: turning}]\n"
    application = files.loads(TEXT + states)
    (response,) = assess(application).responses
    lasting = duty_of(application.bracket, response)
    assert [str(when) for when in lasting] == ["duty cycle, gvw", "duty cycle, turning"]
    assert [len(parts) for parts in lasting.values()] == [2, 2]


def test_a_bracket_is_held_against_its_limits_where_it_fares_worst():
    """250 MPa of 500 at spot 2; a mean second that does 2e-9 there lives 5e8 s."""
    strong = replace(STRONG, yield_strength=500 * MPa)
    answer = BracketAnswer(
        title="", bracket=Bracket(shape=SHAPE, material=strong), top_speed=100.0, variants=()
    )
    features = tuple(
        Feature(zone=zone, number=k, point=(0, 0, 0), error=0.0)
        for k, zone in enumerate(("sheet", "weld toe", "sheet"), 1)
    )
    outcome = SimpleNamespace(
        case=Case("pothole", np.zeros((1, 9))), hot=np.array([100, 250, 50]) * MPa,
        used=np.array([0.5, 0.75, np.nan]), life=None, error=np.array([10, 50, 2.5]) * MPa,
        used_kinder=np.array([0.5, 0.7, np.nan]),
        used_within=np.array([[0.45, 0.55], [0.6, 1.2], [np.nan, np.nan]]),
        least=np.array([90, 235, 50]) * MPa,
    )  # fmt: skip
    spent = Endured(
        when=Occasion("duty", "gvw"), spots=np.array([1e-9, 2e-9, 3e-9]), gauges=np.zeros(0),
        turns=30.0, duration=1.0, span=np.array([[5e-10, 2e-9], [1e-9, 4e-9], [2e-9, 5e-9]]),
    )  # fmt: skip
    judged: Any = SimpleNamespace(
        outcomes=(outcome,), duty=(spent,), features=features, carried=np.array([50.0]),
        frequencies=np.array([150.0]), forced=None, first=(50.0, 0.05),
    )  # fmt: skip
    limits = (
        Limit(quantity="bracket_stress_utilisation", maximum=0.6, source=MINER),
        Limit(quantity="bracket_fatigue_utilisation", normal=1.0, source=MINER),
        Limit(quantity="bracket_life", maximum=1e8, sense=">=", source=MINER),
        Limit(quantity="bracket_resonance", maximum=1.15, sense=">=", source=MINER),
    )
    stress, sheet, toe, *lives, far = checks_of(answer, judged, limits)
    assert (str(stress.part), stress.state) == ("weld toe 2", "pothole")
    assert stress.value == pytest.approx(0.5)
    # A zone each: its own worst feature.
    assert [(str(c.part), c.value) for c in (sheet, toe)] == [
        ("sheet 1", 0.5),
        ("weld toe 2", 0.75),
    ]
    found = {str(c.part): (c.state, c.value) for c in lives}
    assert found == {
        "sheet 3": ("duty cycle, gvw", pytest.approx(1 / 3e-9)),
        "weld toe 2": ("duty cycle, gvw", pytest.approx(1 / 2e-9)),
    }
    assert {str(c.part): c.within for c in lives} == {
        "sheet 3": pytest.approx((1 / 5e-9, 1 / 2e-9)),
        "weld toe 2": pytest.approx((1 / 4e-9, 1 / 1e-9)),
    }
    # 250 and 50 MPa of 500; its error reaches past the limit of 0.6 to no more than equality. Held
    # the kinder way it is 235.
    assert stress.within == pytest.approx((0.37, 0.6))
    assert (stress.grade, stress.may_be) == ("pass", "pass")
    # Up to 1.2 of the limit by its error: it passes, and may not.
    assert (sheet.within, toe.within) == ((0.45, 0.55), (0.6, 1.2))
    assert [(c.grade, c.may_be) for c in (sheet, toe)] == [("pass", "pass"), ("pass", "warn")]
    assert "between 0.6 and 1.2 by what elements, flange" in place(toe, Language("en"))
    for code, word in (
        ("en", "may warn"),
        ("pt", "pode ser um alerta"),
        ("it", "può dare attenzione"),
    ):
        assert word in place(toe, Language(code))
        assert word not in place(sheet, Language(code))
    assert sorted((sheet, toe), key=badness)[0] is toe
    assert check(toe)["may_be"] == "warn"
    # 50 Hz over twice 100 rad/s; its elements are too stiff, by up to 5 % here.
    assert (far.state, far.value) == ("highest speed", pytest.approx(50 / (2 * 100 / (2 * np.pi))))
    assert far.within == pytest.approx((far.value / 1.05, far.value))


def test_a_bracket_swings_itself_where_it_gives_more_than_the_rubber():
    """What rides on soft rubber swings by itself; on stiff rubber the bracket swings with it.

    Rubber of 1e6 N/mm had a bracket told by itself, 2.0 times order 2, that met it at 1027 rpm.
    """

    def first(bends: Any, names: Any = None) -> Any:
        sliding = SimpleNamespace(
            bends=np.array(bends), too_high=np.array([0.02]), too_stiff=np.array([0.1, 0.05, 0.02])
        )
        swept = SimpleNamespace(frequencies=np.array([8.0, 34.0, 90.0]), names=names)
        judged: Any = SimpleNamespace(
            solved=SimpleNamespace(sliding=sliding), frequencies=np.array([150.0]),
            carried=np.array([22.0, 55.0]), forced=names and SimpleNamespace(swept=swept),
        )  # fmt: skip
        return Judged.first.fget(judged)

    assert first([1.0, 1.0]) == pytest.approx((22, 0.05))  # rigidly carried
    assert first([0.3, 0.8]) == pytest.approx((55, 0.05))
    assert first([0.1, 0.2]) == pytest.approx((150, 0.02))
    # Where the line is known, by its own modes.
    assert first([1.0, 1.0], ("yaw", "bracket", "bracket")) == pytest.approx((34, 0.05))
    assert first([1.0, 1.0], ("yaw", "pitch", "bending")) == pytest.approx((150, 0.02))


@pytest.mark.parametrize(
    ("use", "kinder", "life", "longer", "needs"),
    [
        (0.9, 0.5, 4000, 1.5, (False, True)),  # long enough, held the kinder way
        # A third less stress, as contact leaves open, is 6.2 times the life at slope 5.
        (1.2, 0.9, 100, 6.5, (True, True)),
        (1.2, 1.1, 100, 6.0, (False, False)),
        (0.9, 0.5, 9000, 9.0, (False, False)),  # it lives, whichever is right
    ],
)
@pytest.mark.parametrize("bolts", [None, Bolts(preload=27e3)])
def test_a_verdict_that_the_flange_parts_says_what_settles_it(
    use, kinder, life, longer, needs, bolts
):
    """5000 h are asked, and the fatigue limit; in contact there is but one answer."""
    bracket = Bracket(shape=SHAPE, material=PLAIN, fatigue=CURVE, bolts=bolts)
    of: Any = SimpleNamespace(bracket=bracket)
    outcome = SimpleNamespace(
        case=Case("gvw", np.zeros((1, 9))), used=np.array([use]), used_kinder=np.array([kinder]),
        used_within=np.array([[kinder, use]]), life=None,
    )  # fmt: skip
    spots = np.array([1 / life])
    spent = Endured(
        when=Occasion("duty", "gvw"), spots=spots, gauges=np.zeros(0), turns=1.0, duration=hour,
        span=np.stack([spots, spots], axis=-1), eased=spots / longer, kinder=spots / longer,
    )  # fmt: skip
    sheet = Feature(zone="sheet", number=1, point=(0, 0, 0), error=0.0)
    judged: Any = SimpleNamespace(outcomes=(outcome,), duty=(spent,), features=(sheet,))
    limits = (
        Limit(quantity="bracket_fatigue_utilisation", normal=1.0, source=MINER),
        Limit(quantity="bracket_life", maximum=5000 * hour, sense=">=", source=MINER),
    )
    found = [c.settled_by for c in checks_of(of, judged, limits)]
    assert found == [("bracket.bolts",) if bolts is None and one else () for one in needs]


def test_a_recording_s_life_is_held_against_the_limit():
    """Measured damage can fail beside a duty cycle that passes; a case by hand has no life."""
    features = tuple(
        Feature(zone=zone, number=k, point=(0, 0, 0), error=0.0)
        for k, zone in enumerate(("sheet", "weld toe"), 1)
    )

    def lived(name: str, *, damage: float, kind: Any = "case") -> Endured:
        spots = np.array([damage, damage / 2])
        return Endured(when=Occasion(kind, name), spots=spots, gauges=np.zeros(0), turns=np.nan,
                       duration=10.0)  # fmt: skip

    def case(name: str, damage: float, what: str = "") -> Any:
        own = Case(name, np.zeros((1, 9)), what=what)
        return SimpleNamespace(case=own, life=lived(name, damage=damage))

    judged: Any = SimpleNamespace(
        # A state of the recording's name, whose turn at its worst point nobody drives for hours.
        outcomes=(case("pothole", 1.0), case("morning", 1e-3), case("morning", 1.0, "worst point")),
        features=features,
        duty=(lived("gvw", damage=1e-9, kind="duty"),),
    )  # fmt: skip
    of: Any = SimpleNamespace(
        bracket=SimpleNamespace(
            line="main",
            bolts=None,
            material=SimpleNamespace(yield_strength=None),
            recordings=(SimpleNamespace(name="morning"),),
        )
    )
    limit = Limit(quantity="bracket_life", maximum=1e6, sense=">=", source=MINER)
    found = {(c.state, str(c.part)): (c.value, c.grade) for c in checks_of(of, judged, (limit,))}
    assert found == {
        ("duty cycle, gvw", "sheet 1"): (pytest.approx(1e10), "pass"),
        ("duty cycle, gvw", "weld toe 2"): (pytest.approx(2e10), "pass"),
        ("morning", "sheet 1"): (pytest.approx(1e4), "fail"),
        ("morning", "weld toe 2"): (pytest.approx(2e4), "fail"),
    }


@pytest.mark.parametrize(
    ("curve", "lasts", "needs"),
    [
        (None, False, "duty, and bracket.fatigue"), (CURVE, False, "duty"),
        (None, True, "bracket.fatigue"),
    ],
)  # fmt: skip
def test_a_life_that_is_not_known_asks_for_nothing_the_file_has(curve, lasts, needs):
    """A bracket with `fatigue` or with a duty cycle, and without the other, was told to give both.

    Of recordings curves alone make lives, too.
    """
    bracket = Bracket(shape=SHAPE, material=PLAIN, fatigue=curve)
    of: Any = SimpleNamespace(bracket=bracket, lasts=lasts)
    judged: Any = SimpleNamespace(features=(), outcomes=(), duty=())
    limit = Limit(quantity="bracket_life", maximum=1e6, sense=">=", source=MINER)
    (found,) = _unanswered(of, judged, (limit,))
    assert found.needs == (needs,)


def test_a_life_says_between_what_it_lies():
    """A tenth more stress at slope 5 is 1.1^5 times the damage; what fails first may change."""
    spent = Endured(
        when=ALONE, spots=np.array([2.0, 1.0]), gauges=np.zeros(0), turns=np.nan, duration=hour,
        span=np.array([[2 * 0.9**5, 2 * 1.1**5], [0.5**5, 1.5**5]]),
    )  # fmt: skip
    assert spent.hours == 0.5
    assert spent.hours_within == pytest.approx((1 / 1.5**5, 0.5 / 0.9**5))
    assert spent.at([0]).hours_within == pytest.approx((0.5 / 1.1**5, 0.5 / 0.9**5))
    assert all(map(np.isnan, replace(spent, span=None).hours_within))
    # Held the kinder way the first does a third: then the second fails first, if anything.
    kinder = replace(spent, eased=np.array([0.2, 0.3]))
    assert kinder.hours_within == pytest.approx((1 / 1.5**5, 1 / 0.3))
    assert kinder.at([0]).hours_within == pytest.approx((0.5 / 1.1**5, 5))
    assert kinder.hours_meshed == pytest.approx(0.5 / 0.9**5)
