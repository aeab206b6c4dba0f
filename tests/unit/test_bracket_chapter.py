"""The bracket's chapter in page and document, in every language: needs cardan[bracket]."""

import json
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from brackets import BRACKET, LINE
from click.testing import CliRunner

from cardan import files
from cardan.base.part import Point
from cardan.bracket.gauges import recover
from cardan.bracket.solve import Held
from cardan.bracket.stress import along, superpose, von_mises
from cardan.cli import cli
from cardan.model.bracket import ZONES
from cardan.report import bracket as shown
from cardan.report.blocks import Figures, Picture, Table
from cardan.report.bracket_chapter import chapter
from cardan.report.language import CODES, Language
from cardan.study.approval import Approval, assess
from cardan.study.bracket import BracketAnswer, duty_of, study
from cardan.study.bracket_judge import SWINGS, Case, _worst_first, judge
from cardan.study.bracket_life import loads_of, strengths
from cardan.study.finding import Finding

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
def found() -> BracketAnswer:
    """A study, its one solution shown as two variants: what is told needs no second solve."""
    one = study(files.loads(FILE))
    first = one.variants[0]
    return replace(one, variants=(first, replace(first, name="reinforced")))


def approved(found: BracketAnswer) -> Approval:
    finding = Finding(study="bracket", answer=found)
    return Approval(application=files.loads(FILE), findings=(finding,))


def test_damage_follows_from_the_amplitudes_shown(found):
    """One cycle in half a turn: two a turn, of the amplitude reported where it is worst."""
    v = found.variants[0]
    kerb, static, second, combined, worst = v.outcomes
    assert kerb.life is None
    assert np.isnan(kerb.used).all()
    assert static.life is None
    assert worst.case.point is not None
    # Order 2 has no mean; above the knee the slope is 5, below it 9. At a feature's place of the
    # highest stress; another may swing an eighth more, 1.8 by a slope of 5, and counts for it.
    sheet = np.array([f.zone == "sheet" for f in v.features])
    swing = second.amplitude / 2e6
    expected = (swing ** np.where(swing >= 1, 5, 9) / 1e6)[sheet]
    damage = second.life.spots[sheet]
    told = expected > 1e-3 * expected.max()
    assert np.all(damage[told] > 0.8 * expected[told])
    assert np.all(damage[told] < 1.8 * expected[told])
    # Off by a stress's error, a damage is off by that to the power of the curve's slope.
    error = np.array([f.error for f in v.features])[sheet][told]
    least, most = (second.life.span[sheet][told] / damage[told, None]).T
    assert np.all((1 + error) ** 4.9 < most)
    assert np.all(most < (1 + error) ** 9.1)
    assert np.all(least < (1 - error) ** 4.9)
    assert np.all((1 - error) ** 9.1 < least)
    assert second.life.hours_within[0] < second.life.hours < second.life.hours_within[1]
    # Of two ways of holding the worse: by stress for what is shown, by swing for its use.
    assert np.all(second.used[sheet] >= swing[sheet] * (1 - 1e-9))
    assert second.used[sheet] == pytest.approx(swing[sheet], rel=0.1)
    assert second.life.per_turn == pytest.approx(2 * second.life.spots.max())
    assert second.life.per_hour == pytest.approx(2 * second.life.spots.max() * 2500 * 60)
    # At the check's own torque and speed the duty cycle is the check's combined load, but for
    # the shafts' inertia: a ten-thousandth of the force; every place of the surface is asked.
    (duty,) = v.duty
    assert duty.hours == pytest.approx(combined.life.hours, rel=0.1)
    assert duty.hours <= 1.01 * combined.life.hours
    assert duty_of(found.bracket, assess(files.loads(FILE)).responses[0])
    # The map is that of an hour, and holds the worst.
    assert v.damage.shape == v.solved.nodes.surface.shape
    assert v.damage.max() == pytest.approx(duty.per_hour, rel=1e-6)
    # A gauge on the leg reads half a range of strain: times E, its amplitude.
    read = np.ptp(second.strain[0]) / 2 * found.bracket.material.youngs_modulus / 2e6
    assert second.life.gauges == pytest.approx([read ** (5 if read >= 1 else 9) / 1e6])


def test_a_feature_stands_where_what_is_told_of_it_is(found):
    """Held the way that makes it worse: it had been the place of the sliding flange for both.

    A cut edge's 485 MPa then stood at the bolts, 137 mm from the other leg's bend that has them.
    """
    solved, kerb = found.variants[0].solved, found.variants[0].outcomes[0].case
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("cardan.study.bracket_judge.solved_apart", lambda *_, **__: solved)
        told = judge(found.bracket, found.bracket.shape, [kerb])
    by = set()
    for f, hot in zip(told.features, told.outcomes[0].hot, strict=True):
        there = {}
        for held in solved.both:
            own = [k for k, (zone, n) in enumerate(held.zones.features)
                   if (ZONES[zone], n) == (f.zone, f.number)]  # fmt: skip
            mine = np.isin(held.zones.feature, own)
            mine &= (held.zones.points(solved.nodes) == f.point).all(axis=1)
            level = von_mises(superpose(held.unit[mine], kerb.loads))
            there[held.hold] = level.max(initial=0.0)
        by.add(max(there, key=there.get))
        assert max(there.values()) == pytest.approx(hot, rel=1e-9), f
    assert by == {"sliding", "clamped"}


def test_use_and_damage_are_those_of_the_worst_place_and_plane(found):
    """By brute force: every place and degree, a swing's cycles are alike and need no counting.

    A steady pull had moved where they were read to where von Mises stress was highest.
    """
    solved = found.variants[0].solved
    t = np.arange(240) / 20
    loads = np.zeros((len(t), 9))
    loads[:, 1], loads[:, 2] = 800.0 * np.sin(2 * np.pi * t), -30e3
    case = Case("pulled", loads, duration=12.0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("cardan.study.bracket_judge.solved_apart", lambda *_, **__: solved)
        told = judge(found.bracket, found.bracket.shape, [case])
    (o,), strength = told.outcomes, strengths(found.bracket)
    moved = []
    for k, f in enumerate(told.features):
        used, harm, seen = [], [], []
        for held in solved.both:
            own = [j for j, (zone, n) in enumerate(held.zones.features)
                   if (ZONES[zone], n) == (f.zone, f.number)]  # fmt: skip
            mine = np.isin(held.zones.feature, own)
            if not mine.any():
                continue
            n = held.zones.normals[mine]
            u = np.linalg.svd(n[:, None])[2][:, 1]  # square to the normal
            v, angle = np.cross(n, u), np.radians(np.arange(180))[:, None, None]
            ways = np.cos(angle) * u + np.sin(angle) * v
            mean, top = (
                along(superpose(held.unit[mine], at[None])[:, 0], ways)
                for at in (loads.mean(axis=0), loads.mean(axis=0) + np.eye(9)[1] * 800)
            )
            swing = np.abs(top - mean)
            used.append(strength[f.zone].used(swing, mean).max())
            harm.append(12 * strength[f.zone].harm(swing, mean).max())
            level = von_mises(superpose(held.unit[mine], loads)).max(axis=-1)
            there = strength[f.zone].used(swing, mean).max(axis=0)
            seen.append((level.max(), there[level.argmax()]))
        assert max(used) * 0.98 < o.used[k] <= max(used) * 1.001, f
        assert max(harm) * 0.85 < o.life.spots[k] <= max(harm) * 1.01, f
        moved.append(max(seen)[1] / max(used))
    assert min(moved) < 0.7  # else this would hold of the place where stress is highest too


def test_what_gauges_may_read_wrong_is_in_stress_and_life(found):
    """Against 300 influences off by chance: by how much stress scatters, and what swings alone."""
    solved, t = found.variants[0].solved, np.arange(12) / 12
    forces = np.stack([500 + 0 * t, 800 * np.sin(2 * np.pi * t), 0 * t], axis=-1)
    random = np.random.default_rng(7)
    influence = 1e-8 * random.standard_normal((4, 3))
    strains = forces @ influence.T

    def judged(*unsure):
        read = recover(influence, strains, unsure=unsure)
        case = Case("field", loads_of(read.loads), duration=1.0, read=read)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("cardan.study.bracket_judge.solved_apart", lambda *_, **__: solved)
            return judge(found.bracket, found.bracket.shape, [case])

    exact, steady, swung = judged(0, 0, 0), judged(3e-10, 0, 0), judged(0, 3e-10, 0)
    known = exact.outcomes[0]
    # What swings is not read wrong where the steady pull is.
    assert steady.outcomes[0].life.hours_within == known.life.hours_within
    assert steady.outcomes[0].used_within == pytest.approx(known.used_within)
    assert (steady.outcomes[0].error > known.error).all()
    low, high = known.life.hours_within
    lower, higher = swung.outcomes[0].life.hours_within
    assert lower < 0.95 * low
    assert higher > 1.05 * high
    assert (swung.outcomes[0].used_within[:5, 1] > known.used_within[:5, 1]).all()
    # The scatter of the highest stress of each feature, each way of holding the flange.
    off = np.zeros((300, 4, 3))
    off[..., 1] = 3e-10 * random.standard_normal((300, 4))
    scattered = np.stack([recover(influence + d, strains).loads for d in off])
    for k, f in enumerate(swung.features[:5]):
        held = max(solved.both, key=lambda held: _hot(held, f, forces[None]).max(initial=0.0))
        scatter = _hot(held, f, scattered).std()
        told = swung.outcomes[0].error[k] - known.error[k]
        assert 0.8 * scatter < told < 4 * scatter, f
        assert f.error * swung.outcomes[0].hot[k] == pytest.approx(swung.outcomes[0].error[k])


def _hot(held, f, forces):
    """Return the highest stress (m,) of a feature under histories of forces (m, t, 3)."""
    own = [j for j, (zone, n) in enumerate(held.zones.features)
           if (ZONES[zone], n) == (f.zone, f.number)]  # fmt: skip
    mine = np.isin(held.zones.feature, own)
    if not mine.any():
        return np.zeros(0)
    return np.array([
        von_mises(superpose(held.unit[mine][:, :3], one)).max() for one in forces
    ])  # fmt: skip


def test_a_case_on_a_state_is_told_at_the_worst_of_its_points(found):
    """Each of its operating points judged by itself: at one the kick relieves, at another adds."""
    solved, kick = found.variants[0].solved, np.array([0, 1000.0, *7 * [0]])
    under = [[0, -2500, 300], [0, 900, 100], [0, 1600, -200], [1200, -400, 0]]
    points = [Point(f"gear {k}", "drive", 20.0 + k, 1000.0) for k in range(len(under))]
    among = tuple(
        Case("kick", np.pad([f], ((0, 0), (0, 6))) + kick, point=p, once=True)
        for f, p in zip(under, points, strict=True)
    )
    case = Case("kick", np.concatenate([one.loads for one in among]), among=among)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("cardan.study.bracket_judge.solved_apart", lambda *_, **__: solved)
        told, *apart = (
            judge(found.bracket, found.bracket.shape, [one]).outcomes[0]
            for one in (case, *(replace(one, among=()) for one in among))
        )
    each = [o.hot.max() for o in apart]
    assert np.argmax(each) == 2  # not where the state alone is worst
    assert told.hot.max() == pytest.approx(max(each), rel=1e-12)
    assert told.case.point == points[2]
    assert told.life is None


def test_a_state_is_told_where_it_stresses_most_and_where_it_swings_most(found):
    """Each operating point judged by itself: what adds up to most force is worst in neither."""
    solved, turn = found.variants[0].solved, np.linspace(0, 2 * np.pi, 32, endpoint=False)[:, None]
    means = [[0, 0, 5000.0], [0, 1500, 0], [0, 100, 0], [100, 0, 0]]
    waves = [[0, 0, 100.0], [0, 300, 100], [200, 700, 0], [100, 100, 0]]
    among = tuple(
        Case("gvw", np.pad(m + np.cos(turn) * w, ((0, 0), (0, 6))), 0.5, 0.01,
             what="worst point", point=Point(f"gear {k}", "drive", 20.0 + k, 1000.0))
        for k, (m, w) in enumerate(zip(means, np.array(waves), strict=True))
    )  # fmt: skip
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("cardan.study.bracket_judge.solved_apart", lambda *_, **__: solved)

        def judged(*cases):
            v = judge(found.bracket, found.bracket.shape, cases)
            zones = np.array([f.zone for f in v.features])
            return v.outcomes, [
                {z: np.nanmax(o.used[zones == z]) for z in zones.tolist()} for o in v.outcomes
            ]

        (stressed, *swung), told = judged(replace(among[0], among=among))
        apart, used = judged(*among)
        (both, *_), _ = judged(replace(among[0], among=(among[0], among[3], among[1])))
    hot = [o.hot.max() for o in apart]
    assert (np.linalg.norm(means, axis=1).argmax(), np.argmax(hot)) == (0, 1)
    assert (stressed.case.point, both.case.point) == (among[1].point, among[1].point)
    assert stressed.hot.max() == pytest.approx(max(hot), rel=1e-12)
    assert swung[0].case.point == among[2].point
    assert {o.case.when.what for o in swung} <= {*SWINGS.values()}
    for zone in used[0]:  # each is told at its own worst point
        most = max(of[zone] for of in used)
        assert max(of[zone] for of in told) == pytest.approx(most, rel=0.01)
        assert told[0][zone] < 0.9 * most


@pytest.fixture(scope="module")
def hung(found) -> BracketAnswer:
    """The same bracket under a line on rubber: the solution is the same."""
    softly = FILE.replace("element_mm", "rubber_N_mm: [150, 120, 200]\n  element_mm")
    solved = found.variants[0].solved
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("cardan.study.bracket_judge.solved_apart", lambda *_, **__: solved)
        return study(files.loads(softly))


def test_a_line_on_rubber_shakes_its_bracket(found, hung):
    """Force and stress are those of the line in series with what the finite elements give."""
    v = hung.variants[0]
    assert found.variants[0].forced is None
    of = v.forced.swept
    assert of.names[:2] == ("lateral", "bounce")
    assert "bracket" in of.names
    # One mass on rubber and bracket in series, by hand: what hangs on the bearing of a two-piece
    # line does, to the tilt of its shafts.
    give = v.compliance[1, 1], v.compliance[2, 2]
    hung_, free = of.frequencies[:2], np.sqrt([120e3, 200e3])
    series = np.sqrt([1 / (1 / 120e3 + give[0]), 1 / (1 / 200e3 + give[1])])
    assert hung_[0] / hung_[1] == pytest.approx(series[0] / series[1], rel=0.01)
    assert hung_[0] / hung_[1] != pytest.approx(free[0] / free[1], rel=0.01)
    # The worst point is the crest of a curve: speeds stand 1.2 % apart, the rubber loses 0.1.
    worst = next(o for o in v.outcomes if o.case.shakes)
    acts = np.abs(of.waves).sum(axis=-2)[:, :, 1]
    c, q = np.unravel_index(int(np.nan_to_num(acts).argmax()), acts.shape)
    assert np.ptp(worst.case.loads[:, 1]) / 2 == pytest.approx(acts[c, q], rel=0.02)
    assert worst.case.point.speed == pytest.approx(of.speed[q], rel=0.015)
    c, q, k = v.forced.worst
    # Below every mode a bracket that gives is none: 2 % from the stiffness's own share.
    slow = v.forced.stress[c, 0, k], v.forced.rigid[c, 0, k]
    assert slow[0] == pytest.approx(slow[1], rel=0.02)
    assert not np.allclose(v.forced.stress[c, q], v.forced.rigid[c, q], rtol=0.05)


def test_the_bracket_s_own_swing_counts(hung, found):
    """With modes eight times as slow, and as stiff, the same loads stress it more."""
    solved = hung.variants[0].solved

    def slower(held: Held) -> Held:
        own = held.swing.seat
        seat = replace(own, frequencies=own.frequencies / 8, motion=own.motion / 8)
        assert seat.compliance == pytest.approx(own.compliance)
        return replace(held, swing=replace(held.swing, seat=seat))

    made = replace(solved, sliding=slower(solved.sliding), clamped=slower(solved.clamped))
    case = replace(hung.variants[0].outcomes[-1].case, among=())
    assert case.shakes
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("cardan.study.bracket_judge.solved_apart", lambda *_, **__: made)
        shaken, still = (
            judge(found.bracket, found.bracket.shape, [replace(case, shakes=s)]).outcomes[0]
            for s in (True, False)
        )
    assert shaken.amplitude.max() > 1.001 * still.amplitude.max()
    assert shaken.bolts.max() != pytest.approx(still.bolts.max(), rel=1e-6)
    assert shaken.strain != pytest.approx(still.strain, rel=1e-6)


def test_the_response_is_told(hung):
    text = "\n".join(shown.terminal(approved(hung), width=400))
    assert "on rubber and bracket the line swings at lateral" in text
    told = json.loads(json.dumps(shown.contract(approved(hung)), allow_nan=False))["variants"][0]
    response = told["response"]
    assert response["modes"][0]["name"] == "lateral"
    (curve,) = (c for c in response["curves"] if c["direction"] == "drive")
    assert len(curve["stress_MPa"][0]) == len(response["speed_rpm"]) == len(curve["force_N"])
    assert len(told["frequencies_Hz"]) == 6
    figures = [
        f for b in chapter(Finding(study="bracket", answer=hung), Language("en"))
        if isinstance(b, Figures) for f in b.figures
    ]  # fmt: skip
    assert len(figures) == 4
    assert "rigid bracket" in figures[0].svg
    assert "lateral" in figures[1].svg


def test_a_variant_is_better_only_where_its_worst_zone_is(found):
    """Less stress in the sheet, and a toe that lives half as long: not better."""
    first = found.variants[0]
    worse = replace(first, duty=tuple(replace(e, spots=2 * e.spots) for e in first.duty))
    assert "the variant is not better" in shown.better(first, worse)
    assert "the variant is better" in shown.better(worse, first)
    bare = [replace(v, duty=()) for v in (first, worse)]
    used = [replace(o, used=0.5 * o.used) for o in first.outcomes]
    assert "is better: " in shown.better(bare[0], replace(bare[0], outcomes=tuple(used)))


def test_nobody_knows_whether_a_variant_is_better_where_no_curve_is_known(found):
    """A cast toe bears what nobody says, and is stressed most: that the rest lives tells nothing.

    Where it is stressed less than its zone was, whatever it bears, it is better as well.
    """
    first = replace(found.variants[0], duty=())
    k = int(shown.highest(first)[0].argmax())
    unknown = np.array([f.zone == first.features[k].zone for f in first.features])

    def of(v, share, stress):
        return replace(v, outcomes=tuple(
            replace(o, used=np.where(unknown, np.nan, share * o.used), hot=stress * o.hot)
            for o in v.outcomes
        ))  # fmt: skip

    before = of(first, 1, 1)
    told = shown.better(before, of(first, 0.5, 1))
    assert "Whether the variant is better cannot be told" in told
    assert first.features[k].zone in told
    assert "is better: " in shown.better(before, of(first, 0.5, 0.9))
    assert "is not better: " in shown.better(before, of(first, 1.1, 1))
    assert "worst zone known" in shown.worst_use(replace(found, variants=(before,)), Language("en"))
    assert "known" not in shown.worst_use(found, Language("en"))


def test_hours_are_of_the_duty_cycle_or_of_what_was_recorded(found):
    """A recording repeats as it was driven; a state's turns are driven by nobody all the time."""
    v = replace(found.variants[0], duty=())
    assert np.isnan(shown.hours_of(v)).all()
    assert v.lasting == ()
    kerb, static, second, *rest = v.outcomes
    assert second.life.duration > 0  # of a state's turns too it is known how long they take
    spots = np.linspace(1e-4, 1e-3, len(v.features))
    field = replace(
        second, case=Case("field", second.case.loads, duration=20.0),
        life=replace(second.life, spots=spots, turns=np.nan, duration=20.0),
    )  # fmt: skip
    driven = replace(v, outcomes=(kerb, static, second, field, *rest))
    assert [e.duration for e in driven.lasting] == [20.0]
    assert shown.hours_of(driven) == pytest.approx(20 / 3600 / spots)
    lines = shown.terminal(approved(replace(found, variants=(driven,))), width=200)
    text = " ".join(" ".join(lines).split())
    assert "Hours: of the recording that wears it most" in text
    finding = Finding(study="bracket", answer=replace(found, variants=(driven,)))
    heads = [
        cell for b in chapter(finding, Language("en")) if isinstance(b, Table) for cell in b.head
    ]
    assert "hours to failure, driven as recorded" in heads


def test_the_worst_feature_is_the_one_that_fails_first():
    """More stressed, and less worn: a sheet's curve falls sooner than a cut edge's."""
    known, hot = ((0, 1), (1, 1)), SimpleNamespace(hot=np.array([3.0, 2.0]))
    worn = SimpleNamespace(spots=np.array([1e-6, 2e-6]), duration=1.0)
    longer = SimpleNamespace(spots=np.array([6e-6, 1e-6]), duration=10.0)
    for lasting, order in (([], [0, 1]), ([worn], [1, 0]), ([worn, longer], [1, 0])):
        assert _worst_first(known, [hot], lasting, (1.0, 1.0)).tolist() == order


def test_a_long_life_is_not_told_in_figures():
    assert shown.hours(1.1e16, Language("en")) == "> 1000000"
    assert shown.hours(np.inf, Language("en")) == "> 1000000"
    assert shown.hours(0.25, Language("en")) == "0.25"
    for value, told in (
        (4330.4, "4330"),
        (999.6, "1000"),
        (999.4, "999"),
        (1234567.0, "> 1000000"),
    ):
        assert shown.hours(value, Language("en")) == told
    assert shown.hours(475.1, Language("it"), (353, 1090)) == "475\N{NO-BREAK SPACE}(353…1090)"
    assert shown.hours(np.nan, Language("en")) == "-"


def test_terminal_and_contract_show_life(found):
    text = "\n".join(shown.terminal(approved(found), width=400))
    assert "original, damage" in text
    assert "duty cycle, as given" in text
    told = json.loads(json.dumps(shown.contract(approved(found)), allow_nan=False))["variants"][0]
    by = {c["name"]: c["damage"] for c in told["cases"]}
    assert by["kerb"] is None
    life = found.variants[0].duty[0]
    assert told["duty"][0]["life_hours"] == pytest.approx(life.hours)
    assert told["duty"][0]["gauges"] == {"S1": pytest.approx(life.gauges[0])}
    assert by["as given: combined"]["turns"] == 0.5


@pytest.mark.parametrize("code", CODES)
def test_the_chapter_is_told_in_every_language(found, code):
    told = list(chapter(Finding(study="bracket", answer=found), Language(code)))
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
    highest = found.variants[0].worst.von_mises.value / 1e6
    assert f"{highest:.1f}".replace(".", "." if code == "en" else ",") in picture.alt
    assert not re.search(r"@\w+@", picture.scene)
    tops = [float(top) for top in re.findall(r'"top":([\d.e+-]+)', picture.scene)]
    assert tops[0] == pytest.approx(highest)
    many = len(tops) // len(found.variants)
    assert tops[:many] == sorted(tops[:many], reverse=True)


def test_check_puts_the_bracket_into_page_and_document(tmp_path):
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


def test_a_bracket_s_page_and_picture_bear_its_verdict(tmp_path, monkeypatch):
    """It fails: the page showed the mesh alone, and so did the picture."""
    (tmp_path / "a.yaml").write_text(FILE)
    page, over = tmp_path / "a.html", []
    drawn = shown.picture
    monkeypatch.setattr(shown, "picture", lambda *a, **k: over.append(k["over"]) or drawn(*a, **k))
    args = ["bracket", str(tmp_path / "a.yaml"), "-q", "--html", str(page)]
    done = CliRunner().invoke(cli, [*args, "--png", str(tmp_path / "a.png")])
    assert done.exit_code == 1
    headline = done.stdout.splitlines()[0]
    assert headline.startswith("Two-piece line: FAIL (")
    assert f"<strong>{headline}</strong>" in page.read_text(encoding="utf-8")
    assert over == [headline]
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def test_check_without_a_bracket_says_what_it_needs(tmp_path):
    (tmp_path / "a.yaml").write_text(FILE[: FILE.index("bracket:")])
    done = CliRunner().invoke(cli, ["check", str(tmp_path / "a.yaml"), "--bracket"])
    assert done.exit_code == 1
    assert "INCOMPLETE" in done.output
    assert "needs bracket, with a shape" in done.output
