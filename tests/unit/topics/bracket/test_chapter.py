"""The bracket's chapter in page and document, in every language: needs cardan[bracket]."""

import json
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from brackets import BRACKET, LINE
from click.testing import CliRunner

from cardan.application import reader
from cardan.approval.approval import Approval, approve_driveline
from cardan.approval.study import StudyResult
from cardan.cli import cli
from cardan.core.labels import OperatingPoint
from cardan.model.bracket import FATIGUE_ZONES
from cardan.physics.fem.solve import ConstrainedBracketSolution
from cardan.physics.fem.strain_gauges import recover_loads
from cardan.physics.fem.stress import normal_stress, superpose, von_mises
from cardan.render.blocks import Figures, Picture, Table
from cardan.render.i18n import LANGUAGE_CODES, Translator
from cardan.topics.bracket import presentation_picture
from cardan.topics.bracket.assessment import BracketResult, analyse_bracket, duty_cycle_cases
from cardan.topics.bracket.chapter import bracket_blocks
from cardan.topics.bracket.life import fatigue_strength_by_zone, load_history_of_forces
from cardan.topics.bracket.load_cases import WIDEST_STRESS_SWING_CASE_NAMES, BearingLoadCase
from cardan.topics.bracket.phrases import hours_text, utilisation_label, variant_comparison_sentence
from cardan.topics.bracket.presentation import terminal_lines
from cardan.topics.bracket.presentation_json import json_document
from cardan.topics.bracket.presentation_values import feature_hours_to_failure, highest_stress
from cardan.topics.bracket.shape_assessment import _worst_first, assess_shape

pytestmark = pytest.mark.bracket

FILE = (
    LINE
    + "duty: [{share_percent: 100, torque_Nm: 8000, speed_rpm: 2500}]\n"
    + BRACKET
    + """\
  element_mm: 16
  carried_mass_kg: 18
  fatigue: {amplitude_MPa: 2, cycles: 1.0e+6, slope: 5}
  gauges: [{name: S1, point_mm: [0, 56, 20], direction: [0, 0, 1]}]
  cases: [{name: kerb, force_N: [0, 1000, 0]}]
"""
)


@pytest.fixture(scope="module")
def found() -> BracketResult:
    """A study, its one solution shown as two variants: what is told needs no second solve."""
    one = analyse_bracket(reader.loads(FILE))
    first = one.variants[0]
    return replace(one, variants=(first, replace(first, name="reinforced")))


def approved(found: BracketResult) -> Approval:
    finding = StudyResult(study="bracket", answer=found)
    return Approval(application=reader.loads(FILE), study_results=(finding,))


def test_bracket_damage_follows_from_reported_amplitudes(found):
    """One cycle in half a turn: two a turn, of the amplitude reported where it is worst."""
    v = found.variants[0]
    kerb, static, second, combined, worst = v.case_results
    assert kerb.damage_result is None
    assert np.isnan(kerb.utilisation).all()
    assert static.damage_result is None
    assert worst.case.operating_point is not None
    # Order 2 has no mean; above the knee the slope is 5, below it 9. At a feature's place of the
    # highest stress; another may swing an eighth more, 1.8 by a slope of 5, and counts for it.
    sheet = np.array([f.zone == "sheet" for f in v.features])
    swing = second.amplitude / 2e6
    expected = (swing ** np.where(swing >= 1, 5, 9) / 1e6)[sheet]
    damage = second.damage_result.hot_spot_damage[sheet]
    told = expected > 1e-3 * expected.max()
    assert np.all(damage[told] > 0.8 * expected[told])
    assert np.all(damage[told] < 1.8 * expected[told])
    # Off by a stress's error, a damage is off by that to the power of the curve's slope.
    error = np.array([f.error for f in v.features])[sheet][told]
    least, most = (second.damage_result.damage_bounds[sheet][told] / damage[told, None]).T
    assert np.all((1 + error) ** 4.9 < most)
    assert np.all(most < (1 + error) ** 9.1)
    assert np.all(least < (1 - error) ** 4.9)
    assert np.all((1 - error) ** 9.1 < least)
    assert (
        second.damage_result.hours_bounds[0]
        < second.damage_result.hours_to_failure
        < second.damage_result.hours_bounds[1]
    )
    # Of two ways of holding the worse: by stress for what is shown, by swing for its use.
    assert np.all(second.utilisation[sheet] >= swing[sheet] * (1 - 1e-9))
    assert second.utilisation[sheet] == pytest.approx(swing[sheet], rel=0.1)
    assert second.damage_result.damage_per_turn == pytest.approx(
        2 * second.damage_result.hot_spot_damage.max()
    )
    assert second.damage_result.damage_per_hour == pytest.approx(
        2 * second.damage_result.hot_spot_damage.max() * 2500 * 60
    )
    # At the check's own torque and speed the duty cycle is the check's combined load, but for
    # the shafts' inertia: a ten-thousandth of the force; every place of the surface is asked.
    (duty,) = v.duty_damage
    assert duty.hours_to_failure == pytest.approx(combined.damage_result.hours_to_failure, rel=0.1)
    assert duty.hours_to_failure <= 1.01 * combined.damage_result.hours_to_failure
    assert duty_cycle_cases(found.bracket, approve_driveline(reader.loads(FILE)).line_responses[0])
    # The map is that of an hour, and holds the worst.
    assert v.damage_map.shape == v.solved.nodes.surface_nodes.shape
    assert v.damage_map.max() == pytest.approx(duty.damage_per_hour, rel=1e-6)
    # A gauge on the leg reads half a range of strain: times E, its amplitude.
    read = np.ptp(second.gauge_strain_range[0]) / 2 * found.bracket.material.youngs_modulus / 2e6
    assert second.damage_result.gauge_damage == pytest.approx(
        [read ** (5 if read >= 1 else 9) / 1e6]
    )


def test_feature_position_matches_its_highest_stress(found):
    """Held the way that makes it worse: it had been the place of the sliding flange for both.

    A cut edge's 485 MPa then stood at the bolts, 137 mm from the other leg's bend that has them.
    """
    solved, kerb = found.variants[0].solved, found.variants[0].case_results[0].case
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "cardan.topics.bracket.shape_assessment.solve_in_subprocess", lambda *_, **__: solved
        )
        told = assess_shape(found.bracket, found.bracket.shape, [kerb])
    by = set()
    for f, hot in zip(told.features, told.case_results[0].feature_stress, strict=True):
        there = {}
        for held in solved.boundary_cases:
            own = [k for k, (zone, n) in enumerate(held.zones.features)
                   if (FATIGUE_ZONES[zone], n) == (f.zone, f.number)]  # fmt: skip
            mine = np.isin(held.zones.feature, own)
            mine &= (held.zones.points(solved.nodes) == f.point).all(axis=1)
            level = von_mises(superpose(held.unit_stress[mine], kerb.loads))
            there[held.hold] = level.max(initial=0.0)
        by.add(max(there, key=there.get))
        assert max(there.values()) == pytest.approx(hot, rel=1e-9), f
    assert by == {"sliding", "clamped"}


def test_utilisation_and_damage_are_those_of_worst_point_and_plane(found):
    """By brute force: every place and degree, a swing's cycles are alike and need no counting.

    A steady pull had moved where they were read to where von Mises stress was highest.
    """
    solved = found.variants[0].solved
    t = np.arange(240) / 20
    loads = np.zeros((len(t), 9))
    loads[:, 1], loads[:, 2] = 800.0 * np.sin(2 * np.pi * t), -30e3
    case = BearingLoadCase("pulled", loads, duration=12.0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "cardan.topics.bracket.shape_assessment.solve_in_subprocess", lambda *_, **__: solved
        )
        told = assess_shape(found.bracket, found.bracket.shape, [case])
    (o,), strength = told.case_results, fatigue_strength_by_zone(found.bracket)
    moved = []
    for k, f in enumerate(told.features):
        used, harm, seen = [], [], []
        for held in solved.boundary_cases:
            own = [j for j, (zone, n) in enumerate(held.zones.features)
                   if (FATIGUE_ZONES[zone], n) == (f.zone, f.number)]  # fmt: skip
            mine = np.isin(held.zones.feature, own)
            if not mine.any():
                continue
            n = held.zones.normals[mine]
            u = np.linalg.svd(n[:, None])[2][:, 1]  # square to the normal
            v, angle = np.cross(n, u), np.radians(np.arange(180))[:, None, None]
            ways = np.cos(angle) * u + np.sin(angle) * v
            mean, top = (
                normal_stress(superpose(held.unit_stress[mine], at[None])[:, 0], ways)
                for at in (loads.mean(axis=0), loads.mean(axis=0) + np.eye(9)[1] * 800)
            )
            swing = np.abs(top - mean)
            used.append(strength[f.zone].utilisation(swing, mean).max())
            harm.append(12 * strength[f.zone].cycle_damage(swing, mean).max())
            level = von_mises(superpose(held.unit_stress[mine], loads)).max(axis=-1)
            there = strength[f.zone].utilisation(swing, mean).max(axis=0)
            seen.append((level.max(), there[level.argmax()]))
        assert max(used) * 0.98 < o.utilisation[k] <= max(used) * 1.001, f
        assert max(harm) * 0.85 < o.damage_result.hot_spot_damage[k] <= max(harm) * 1.01, f
        moved.append(max(seen)[1] / max(used))
    assert min(moved) < 0.7  # else this would hold of the place where stress is highest too


def test_gauge_uncertainty_propagates_to_stress_and_life(found):
    """Against 300 influences off by chance: by how much stress scatters, and what swings alone."""
    solved, t = found.variants[0].solved, np.arange(12) / 12
    forces = np.stack([500 + 0 * t, 800 * np.sin(2 * np.pi * t), 0 * t], axis=-1)
    random = np.random.default_rng(7)
    influence = 1e-8 * random.standard_normal((4, 3))
    strains = forces @ influence.T

    def judged(*unsure):
        read = recover_loads(influence, strains, unsure=unsure)
        case = BearingLoadCase(
            "field", load_history_of_forces(read.loads), duration=1.0, recovered_loads=read
        )
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(
                "cardan.topics.bracket.shape_assessment.solve_in_subprocess",
                lambda *_, **__: solved,
            )
            return assess_shape(found.bracket, found.bracket.shape, [case])

    exact, steady, swung = judged(0, 0, 0), judged(3e-10, 0, 0), judged(0, 3e-10, 0)
    known = exact.case_results[0]
    # What swings is not read wrong where the steady pull is.
    assert steady.case_results[0].damage_result.hours_bounds == known.damage_result.hours_bounds
    assert steady.case_results[0].utilisation_bounds == pytest.approx(known.utilisation_bounds)
    assert (steady.case_results[0].feature_stress_error > known.feature_stress_error).all()
    low, high = known.damage_result.hours_bounds
    lower, higher = swung.case_results[0].damage_result.hours_bounds
    assert lower < 0.95 * low
    assert higher > 1.05 * high
    assert (swung.case_results[0].utilisation_bounds[:5, 1] > known.utilisation_bounds[:5, 1]).all()
    # The scatter of the highest stress of each feature, each way of holding the flange.
    off = np.zeros((300, 4, 3))
    off[..., 1] = 3e-10 * random.standard_normal((300, 4))
    scattered = np.stack([recover_loads(influence + d, strains).loads for d in off])
    for k, f in enumerate(swung.features[:5]):
        held = max(
            solved.boundary_cases, key=lambda held: _hot(held, f, forces[None]).max(initial=0.0)
        )
        scatter = _hot(held, f, scattered).std()
        told = swung.case_results[0].feature_stress_error[k] - known.feature_stress_error[k]
        assert 0.8 * scatter < told < 4 * scatter, f
        assert f.error * swung.case_results[0].feature_stress[k] == pytest.approx(
            swung.case_results[0].feature_stress_error[k]
        )


def _hot(held, f, forces):
    """Return the highest stress (m,) of a feature under histories of forces (m, t, 3)."""
    own = [j for j, (zone, n) in enumerate(held.zones.features)
           if (FATIGUE_ZONES[zone], n) == (f.zone, f.number)]  # fmt: skip
    mine = np.isin(held.zones.feature, own)
    if not mine.any():
        return np.zeros(0)
    return np.array([
        von_mises(superpose(held.unit_stress[mine][:, :3], one)).max() for one in forces
    ])  # fmt: skip


def test_load_case_on_state_is_reported_at_worst_operating_point(found):
    """Each of its operating points judged by itself: at one the kick relieves, at another adds."""
    solved, kick = found.variants[0].solved, np.array([0, 1000.0, *7 * [0]])
    under = [[0, -2500, 300], [0, 900, 100], [0, 1600, -200], [1200, -400, 0]]
    points = [OperatingPoint(f"gear {k}", "drive", 20.0 + k, 1000.0) for k in range(len(under))]
    among = tuple(
        BearingLoadCase(
            "kick", np.pad([f], ((0, 0), (0, 6))) + kick, operating_point=p, occurs_once=True
        )
        for f, p in zip(under, points, strict=True)
    )
    case = BearingLoadCase("kick", np.concatenate([one.loads for one in among]), alternatives=among)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "cardan.topics.bracket.shape_assessment.solve_in_subprocess", lambda *_, **__: solved
        )
        told, *apart = (
            assess_shape(found.bracket, found.bracket.shape, [one]).case_results[0]
            for one in (case, *(replace(one, alternatives=()) for one in among))
        )
    each = [o.feature_stress.max() for o in apart]
    assert np.argmax(each) == 2  # not where the state alone is worst
    assert told.feature_stress.max() == pytest.approx(max(each), rel=1e-12)
    assert told.case.operating_point == points[2]
    assert told.damage_result is None


def test_state_is_reported_at_highest_stress_and_highest_amplitude(found):
    """Each operating point judged by itself: what adds up to most force is worst in neither."""
    solved, turn = found.variants[0].solved, np.linspace(0, 2 * np.pi, 32, endpoint=False)[:, None]
    means = [[0, 0, 5000.0], [0, 1500, 0], [0, 100, 0], [100, 0, 0]]
    waves = [[0, 0, 100.0], [0, 300, 100], [200, 700, 0], [100, 100, 0]]
    among = tuple(
        BearingLoadCase(
            "gvw",
            np.pad(m + np.cos(turn) * w, ((0, 0), (0, 6))),
            0.5,
            0.01,
            component="worst point",
            operating_point=OperatingPoint(f"gear {k}", "drive", 20.0 + k, 1000.0),
        )
        for k, (m, w) in enumerate(zip(means, np.array(waves), strict=True))
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "cardan.topics.bracket.shape_assessment.solve_in_subprocess", lambda *_, **__: solved
        )

        def judged(*cases):
            v = assess_shape(found.bracket, found.bracket.shape, cases)
            zones = np.array([f.zone for f in v.features])
            return v.case_results, [
                {z: np.nanmax(o.utilisation[zones == z]) for z in zones.tolist()}
                for o in v.case_results
            ]

        (stressed, *swung), told = judged(replace(among[0], alternatives=among))
        apart, used = judged(*among)
        (both, *_), _ = judged(replace(among[0], alternatives=(among[0], among[3], among[1])))
    hot = [o.feature_stress.max() for o in apart]
    assert (np.linalg.norm(means, axis=1).argmax(), np.argmax(hot)) == (0, 1)
    assert (stressed.case.operating_point, both.case.operating_point) == (
        among[1].operating_point,
        among[1].operating_point,
    )
    assert stressed.feature_stress.max() == pytest.approx(max(hot), rel=1e-12)
    assert swung[0].case.operating_point == among[2].operating_point
    assert {o.case.when.what for o in swung} <= {*WIDEST_STRESS_SWING_CASE_NAMES.values()}
    for zone in used[0]:  # each is told at its own worst point
        most = max(of[zone] for of in used)
        assert max(of[zone] for of in told) == pytest.approx(most, rel=0.01)
        assert told[0][zone] < 0.9 * most


@pytest.fixture(scope="module")
def hung(found) -> BracketResult:
    """The same bracket under a line on rubber: the solution is the same."""
    softly = FILE.replace("element_mm", "rubber_N_mm: [150, 120, 200]\n  element_mm")
    solved = found.variants[0].solved
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "cardan.topics.bracket.shape_assessment.solve_in_subprocess", lambda *_, **__: solved
        )
        return analyse_bracket(reader.loads(softly))


def test_bracket_response_includes_line_modes_on_rubber(found, hung):
    """Force and stress are those of the line in series with what the finite elements give."""
    v = hung.variants[0]
    assert found.variants[0].forced_response is None
    of = v.forced_response.sweep
    assert of.mode_names[:2] == ("lateral", "bounce")
    assert "bracket" in of.mode_names
    # One mass on rubber and bracket in series, by hand: what hangs on the bearing of a two-piece
    # line does, to the tilt of its shafts.
    give = v.compliance[1, 1], v.compliance[2, 2]
    hung_, free = of.frequencies[:2], np.sqrt([120e3, 200e3])
    series = np.sqrt([1 / (1 / 120e3 + give[0]), 1 / (1 / 200e3 + give[1])])
    assert hung_[0] / hung_[1] == pytest.approx(series[0] / series[1], rel=0.01)
    assert hung_[0] / hung_[1] != pytest.approx(free[0] / free[1], rel=0.01)
    # The worst point is the crest of a curve: speeds stand 1.2 % apart, the rubber loses 0.1.
    worst = next(o for o in v.case_results if o.case.is_dynamic)
    acts = np.abs(of.force_amplitudes).sum(axis=-2)[:, :, 1]
    c, q = np.unravel_index(int(np.nan_to_num(acts).argmax()), acts.shape)
    assert np.ptp(worst.case.loads[:, 1]) / 2 == pytest.approx(acts[c, q], rel=0.02)
    assert worst.case.operating_point.speed == pytest.approx(of.speed[q], rel=0.015)
    c, q, k = v.forced_response.worst
    # Below every mode a bracket that gives is none: 2 % from the stiffness's own share.
    slow = v.forced_response.stress[c, 0, k], v.forced_response.rigid_stress[c, 0, k]
    assert slow[0] == pytest.approx(slow[1], rel=0.02)
    assert not np.allclose(
        v.forced_response.stress[c, q], v.forced_response.rigid_stress[c, q], rtol=0.05
    )


def test_bracket_vibration_increases_stress(hung, found):
    """With modes eight times as slow, and as stiff, the same loads stress it more."""
    solved = hung.variants[0].solved

    def slower(held: ConstrainedBracketSolution) -> ConstrainedBracketSolution:
        own = held.modal_model.bracket_compliance
        seat = replace(
            own, frequencies=own.frequencies / 8, seat_mode_shapes=own.seat_mode_shapes / 8
        )
        assert seat.static_compliance == pytest.approx(own.static_compliance)
        return replace(held, modal_model=replace(held.modal_model, bracket_compliance=seat))

    made = replace(solved, sliding=slower(solved.sliding), clamped=slower(solved.clamped))
    case = replace(hung.variants[0].case_results[-1].case, alternatives=())
    assert case.is_dynamic
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "cardan.topics.bracket.shape_assessment.solve_in_subprocess", lambda *_, **__: made
        )
        shaken, still = (
            assess_shape(
                found.bracket, found.bracket.shape, [replace(case, is_dynamic=s)]
            ).case_results[0]
            for s in (True, False)
        )
    assert shaken.amplitude.max() > 1.001 * still.amplitude.max()
    assert shaken.bolt_forces.max() != pytest.approx(still.bolt_forces.max(), rel=1e-6)
    assert shaken.gauge_strain_range != pytest.approx(still.gauge_strain_range, rel=1e-6)


def test_forced_response_is_reported_in_terminal_and_json(hung):
    text = "\n".join(terminal_lines(approved(hung), width=400))
    assert "on rubber and bracket the line swings at lateral" in text
    told = json.loads(json.dumps(json_document(approved(hung)), allow_nan=False))["variants"][0]
    response = told["response"]
    assert response["modes"][0]["name"] == "lateral"
    (curve,) = (c for c in response["curves"] if c["direction"] == "drive")
    assert len(curve["stress_MPa"][0]) == len(response["speed_rpm"]) == len(curve["force_N"])
    assert len(told["frequencies_Hz"]) == 6
    figures = [
        f for b in bracket_blocks(StudyResult(study="bracket", answer=hung), Translator("en"))
        if isinstance(b, Figures) for f in b.figures
    ]  # fmt: skip
    assert len(figures) == 4
    assert "rigid bracket" in figures[0].svg
    assert "lateral" in figures[1].svg


def test_variant_is_better_only_if_its_worst_zone_is_better(found):
    """Less stress in the sheet, and a toe that lives half as long: not better."""
    first = found.variants[0]
    worse = replace(
        first,
        duty_damage=tuple(
            replace(e, hot_spot_damage=2 * e.hot_spot_damage) for e in first.duty_damage
        ),
    )
    assert "the variant is not better" in variant_comparison_sentence(first, worse)
    assert "the variant is better" in variant_comparison_sentence(worse, first)
    bare = [replace(v, duty_damage=()) for v in (first, worse)]
    used = [replace(o, utilisation=0.5 * o.utilisation) for o in first.case_results]
    assert "is better: " in variant_comparison_sentence(
        bare[0], replace(bare[0], case_results=tuple(used))
    )


def test_variant_comparison_is_undetermined_without_sn_curve(found):
    """A cast toe bears what nobody says, and is stressed most: that the rest lives tells nothing.

    Where it is stressed less than its zone was, whatever it bears, it is better as well.
    """
    first = replace(found.variants[0], duty_damage=())
    k = int(highest_stress(first)[0].argmax())
    unknown = np.array([f.zone == first.features[k].zone for f in first.features])

    def of(v, share, stress):
        return replace(
            v,
            case_results=tuple(
                replace(
                    o,
                    utilisation=np.where(unknown, np.nan, share * o.utilisation),
                    feature_stress=stress * o.feature_stress,
                )
                for o in v.case_results
            ),
        )

    before = of(first, 1, 1)
    told = variant_comparison_sentence(before, of(first, 0.5, 1))
    assert "Comparison undetermined" in told
    assert first.features[k].zone in told
    assert "is better: " in variant_comparison_sentence(before, of(first, 0.5, 0.9))
    assert "is not better: " in variant_comparison_sentence(before, of(first, 1.1, 1))
    assert "worst zone known" in utilisation_label(
        replace(found, variants=(before,)), Translator("en")
    )
    assert "known" not in utilisation_label(found, Translator("en"))


def test_life_hours_refer_to_duty_cycle_or_recording(found):
    """A recording repeats as it was driven; a state's turns are driven by nobody all the time."""
    v = replace(found.variants[0], duty_damage=())
    assert np.isnan(feature_hours_to_failure(v)).all()
    assert v.life_results == ()
    kerb, static, second, *rest = v.case_results
    assert (
        second.damage_result.duration > 0
    )  # of a state's turns too it is known how long they take
    spots = np.linspace(1e-4, 1e-3, len(v.features))
    field = replace(
        second, case=BearingLoadCase("field", second.case.loads, duration=20.0),
        damage_result=replace(
            second.damage_result, hot_spot_damage=spots, turns=np.nan, duration=20.0
        ),
    )  # fmt: skip
    driven = replace(v, case_results=(kerb, static, second, field, *rest))
    assert [e.duration for e in driven.life_results] == [20.0]
    assert feature_hours_to_failure(driven) == pytest.approx(20 / 3600 / spots)
    lines = terminal_lines(approved(replace(found, variants=(driven,))), width=200)
    text = " ".join(" ".join(lines).split())
    assert "Hours: of the recording that wears it most" in text
    finding = StudyResult(study="bracket", answer=replace(found, variants=(driven,)))
    heads = [
        cell
        for b in bracket_blocks(finding, Translator("en"))
        if isinstance(b, Table)
        for cell in b.head
    ]
    assert "hours to failure, driven as recorded" in heads


def test_worst_feature_is_the_one_that_fails_first():
    """More stressed, and less worn: a sheet's curve falls sooner than a cut edge's."""
    known, hot = ((0, 1), (1, 1)), SimpleNamespace(feature_stress=np.array([3.0, 2.0]))
    worn = SimpleNamespace(hot_spot_damage=np.array([1e-6, 2e-6]), duration=1.0)
    longer = SimpleNamespace(hot_spot_damage=np.array([6e-6, 1e-6]), duration=10.0)
    for lasting, order in (([], [0, 1]), ([worn], [1, 0]), ([worn, longer], [1, 0])):
        assert _worst_first(known, [hot], lasting, (1.0, 1.0)).tolist() == order


def test_life_above_one_million_hours_is_shown_as_bound():
    assert hours_text(1.1e16, Translator("en")) == "> 1000000"
    assert hours_text(np.inf, Translator("en")) == "> 1000000"
    assert hours_text(0.25, Translator("en")) == "0.25"
    for value, told in (
        (4330.4, "4330"),
        (999.6, "1000"),
        (999.4, "999"),
        (1234567.0, "> 1000000"),
    ):
        assert hours_text(value, Translator("en")) == told
    assert hours_text(475.1, Translator("it"), (353, 1090)) == "475\N{NO-BREAK SPACE}(353…1090)"
    assert hours_text(np.nan, Translator("en")) == "-"


def test_terminal_and_json_show_bracket_life(found):
    text = "\n".join(terminal_lines(approved(found), width=400))
    assert "original, damage" in text
    assert "duty cycle, as given" in text
    told = json.loads(json.dumps(json_document(approved(found)), allow_nan=False))["variants"][0]
    by = {c["name"]: c["damage"] for c in told["cases"]}
    assert by["kerb"] is None
    life = found.variants[0].duty_damage[0]
    assert told["duty"][0]["life_hours"] == pytest.approx(life.hours_to_failure)
    assert told["duty"][0]["gauges"] == {"S1": pytest.approx(life.gauge_damage[0])}
    assert by["as given: combined"]["turns"] == 0.5


@pytest.mark.parametrize("code", LANGUAGE_CODES)
def test_bracket_chapter_is_translated_in_every_language(found, code):
    told = list(bracket_blocks(StudyResult(study="bracket", answer=found), Translator(code)))
    tables = [b for b in told if isinstance(b, Table)]
    assert len(tables) == 1 + 2 * 4
    assert sum(len(b.figures) for b in told if isinstance(b, Figures)) == 3
    for table in tables:
        assert {len(row) for row in table.rows} == {len(table.head)}
        assert not any("nan" in cell for row in table.rows for cell in row)
    words = " ".join(cell for t in tables for row in (t.head, *t.rows) for cell in row)
    assert ("combined" in words) == (code == "en")
    (picture,) = [b for b in told if isinstance(b, Picture)]
    assert picture.png.startswith(b"\x89PNG")
    highest = found.variants[0].worst_case.von_mises.value / 1e6
    assert f"{highest:.1f}".replace(".", "." if code == "en" else ",") in picture.alt
    assert not re.search(r"@\w+@", picture.scene)
    tops = [float(top) for top in re.findall(r'"top":([\d.e+-]+)', picture.scene)]
    assert tops[0] == pytest.approx(highest)
    many = len(tops) // len(found.variants)
    assert tops[:many] == sorted(tops[:many], reverse=True)


def test_check_adds_bracket_chapter_to_page_and_pdf(tmp_path):
    (tmp_path / "a.yaml").write_text(FILE)
    page, document = tmp_path / "a.html", tmp_path / "a.pdf"
    args = ["check", str(tmp_path / "a.yaml"), "-q", "--bracket", "--lang", "pt"]
    done = CliRunner().invoke(cli, [*args, "--html", str(page), "--pdf", str(document)])
    assert isinstance(done.exception, SystemExit | None), repr(done.exception)
    text = page.read_text(encoding="utf-8")
    assert "O suporte do mancal 1" in text
    assert 'class="bracket-scene"' in text
    assert 'alt="O suporte deformado' in text
    # The scene's script is the only one, and the page's policy lets it run.
    assert len(re.findall(r"<script>", text)) == 1
    assert "script-src &#39;sha256" in text or "script-src 'sha256" in text
    data = document.read_bytes()
    assert data.startswith(b"%PDF-")
    assert b"/Subtype/Image" in data.replace(b" ", b"")


def test_bracket_page_and_picture_show_its_verdict(tmp_path, monkeypatch):
    """It fails: the page showed the mesh alone, and so did the picture."""
    (tmp_path / "a.yaml").write_text(FILE)
    page, over = tmp_path / "a.html", []
    drawn = presentation_picture.write_picture
    monkeypatch.setattr(
        presentation_picture, "write_picture",
        lambda *a, **k: over.append(k["over"]) or drawn(*a, **k),
    )  # fmt: skip
    args = ["bracket", str(tmp_path / "a.yaml"), "-q", "--all", "--html", str(page)]
    done = CliRunner().invoke(cli, [*args, "--png", str(tmp_path / "a.png")])
    assert done.exit_code == 1
    said = " ".join(done.stdout.split())
    headline = said[: said.index(")") + 1]
    assert headline.startswith("Two-piece line: NOT APPROVED (")
    assert f"<strong>{headline}</strong>" in page.read_text(encoding="utf-8")
    assert over == [headline]
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def test_bracket_check_without_bracket_names_missing_input(tmp_path):
    (tmp_path / "a.yaml").write_text(FILE[: FILE.index("bracket:")])
    done = CliRunner().invoke(cli, ["check", str(tmp_path / "a.yaml"), "--bracket"])
    assert done.exit_code == 1
    assert "INCOMPLETE" in done.output
    assert "the shape of the bracket" in " ".join(done.output.split())
