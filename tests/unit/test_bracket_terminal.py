"""A bracket's numbers in a terminal, in every language: without solving one."""

import re
from dataclasses import replace
from html import escape
from types import SimpleNamespace

import jsonschema
import numpy as np
import pytest
from brackets import BRACKET, LINE

from cardan import files
from cardan.base.part import Occasion, Part
from cardan.base.source import MINER
from cardan.base.units import hour
from cardan.base.verdict import Check, Limit
from cardan.bracket.gauges import recover
from cardan.bracket.shape import Picked
from cardan.model.bracket import Bolts, BracketRecording
from cardan.report import bracket_chapter, bracket_scene
from cardan.report.blocks import Text
from cardan.report.bracket import (
    bent_far,
    in_contact,
    pulled_off,
    remarks,
    terminal,
    verdict,
    worn,
)
from cardan.report.contract import check
from cardan.report.contract_schema import schema
from cardan.report.language import CODES, Language
from cardan.report.terminal import bare
from cardan.study.approval import Approval
from cardan.study.bracket import BracketAnswer
from cardan.study.bracket_contact import InBolts
from cardan.study.bracket_judge import Case, Crossing, Feature, Found, Judged, Outcome, Slip
from cardan.study.bracket_life import Endured
from cardan.study.finding import Finding, silence

FILE = (
    LINE
    + BRACKET
    + """\
  gauges: [{name: S1, point_mm: [0, 56, 20], direction: [0, 0, 1]}]
"""
)

HOT = np.array([120.5e6, 80.25e6])


def outcome() -> Outcome:
    at = (0.0, 0.05, 0.02)
    when = Occasion("case", "gvw", "combined")
    life = Endured(when=when, spots=np.array([1e-7, 2e-8]), gauges=np.array([1e-9]), turns=0.5,
                   duration=0.012)  # fmt: skip
    return Outcome(
        case=Case("gvw", np.zeros((1, 9)), turns=0.5, duration=0.012, what="combined"),
        von_mises=Found(110e6, at), highest=Found(115e6, at), lowest=Found(-90e6, at),
        on_edge=Found(200e6, at), hot=HOT, error=HOT / 100, mean=HOT / 2, amplitude=HOT / 2,
        used=HOT / 150e6, used_kinder=HOT / 150e6,
        used_within=np.outer(HOT / 150e6, [0.99, 1.01]), least=HOT,
        strain=np.array([[-1e-4, 2e-4]]), bolts=np.array([1e3]), motion=1e-4, life=life,
    )  # fmt: skip


def judged(name: str, wear: float = 1.0) -> Judged:
    held = SimpleNamespace(
        compliance=np.diag([1e-7] * 6), influence=np.full((1, 9), 1e-7),
        frequencies=np.full(6, 310.5), carried=np.full(6, 60.25),
        too_stiff=np.array([0.031, 0.012, 0.02]), too_high=np.full(6, 0.01),
    )  # fmt: skip
    solved = SimpleNamespace(
        unknowns=72705, mass=1.25, sliding=held, clamped=held, influence_change=0.012,
        fillet=(0.006, 0.0042), nodes=SimpleNamespace(points=np.array([[0.0] * 3, [0.24] * 3])),
        found=(
            Picked(name="seat", faces=2, area=5.655e-3, radius=0.03),
            Picked(name="bolt 1", faces=1, area=3e-4),
        ),
    )  # fmt: skip
    features = tuple(
        Feature(zone=zone, number=k, point=(0, 0.05, 0.02), error=0.01)
        for k, zone in enumerate(("weld toe", "sheet"), 1)
    )
    life = outcome().life
    return Judged(
        name=name, solved=solved, features=features, listed=1,
        crossings=(Crossing(1, 60.25, 2, 189.3, in_range=True),),
        outcomes=(outcome(),) * 9, damage=np.zeros(0),
        duty=(replace(life, when=Occasion("duty", "gvw"), spots=life.spots * wear),),
    )  # fmt: skip


def approved(*variants: str) -> Approval:
    application = files.loads(FILE)
    answer = BracketAnswer(
        title=application.title, bracket=application.bracket, top_speed=262.0,
        variants=tuple(map(judged, variants)),
    )  # fmt: skip
    missed = tuple(silence("bracket", application, ("duty, and bracket.fatigue",)))
    finding = Finding(study="bracket", answer=answer, unanswered=missed)
    return Approval(application=application, findings=(finding,))


def told(code: str, *variants: str, width: int = 400) -> str:
    return bare(terminal(approved(*variants), Language(code), width=width))


@pytest.mark.parametrize("width", [80, 120])
@pytest.mark.parametrize("code", CODES)
def test_it_fits_the_screen(code, width):
    """Its tables were 110 wide, and what swings on the rubber 200."""
    lines = told(code, "original", "reinforced", width=width).splitlines()
    assert len(lines) > 60
    assert [line for line in lines if len(line) > width] == []
    assert max(map(len, lines)) > width - 12


@pytest.mark.parametrize("code", [c for c in CODES if c != "en"])
def test_everything_is_told_in_the_language(code):
    """No line of words stays as it is in English, but a material with its standard, and a unit."""
    english = told("en", "original", "reinforced").splitlines()
    other = told(code, "original", "reinforced").splitlines()
    assert len(other) == len(english)
    words = [line for line in english if re.search("[a-z]{4}", line)]
    assert len(words) > 30
    alike = [w for w in words if w in other and "EN 13906-1" not in w]
    assert [w for w in alike if w != "original, MPa"] == []


@pytest.mark.parametrize("code", CODES)
def test_a_bracket_s_page_says_the_verdict_and_the_limits_that_a_terminal_says(code, monkeypatch):
    """It showed the mesh in its colours, in English, and no verdict."""
    monkeypatch.setattr(bracket_scene, "scene", lambda _, say: f"<p>{say.code}</p>")
    of, say = approved("original"), Language(code)
    page = bracket_scene.page(of, say=say)
    first, _, limits = bare(verdict(of, say)).partition("\n")
    assert limits.splitlines()[-1] in told(code, "original")
    assert f'lang="{code}"' in page
    assert f'<p class="incomplete" style="font-size:1.2em"><strong>{first}</strong></p>' in page
    assert len(limits.splitlines()) > 3
    assert f">{escape(limits)}</pre>" in page
    assert page.index("</pre>") < page.index(f"<p>{code}</p>")


@pytest.mark.parametrize(("code", "sign"), [("en", "."), ("pt", ","), ("it", ",")])
def test_the_scale_of_a_scene_has_the_languages_decimal_sign(code, sign):
    nothing = SimpleNamespace(outcomes=())
    of = SimpleNamespace(variants=(nothing,), bracket=SimpleNamespace(gauges=()))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bracket_scene, "variant", lambda *_: {})
        shown = bracket_scene.scene(of, say=Language(code))
    assert f'"point":"{sign}"' in shown


def test_what_the_brackets_terminal_says():
    said = told("en", "original", "reinforced")
    for words in (
        "Two-piece line: INCOMPLETE",
        "Two-piece line: bracket of line main, bearing 1",
        "stiffness at the bearing along x, N/mm",
        "original: loaded, without the line, order 2 meets 60.25 Hz at 1808 rpm.",
        "gvw: combined",
        "original, where a crack may start",
        "0  50  20",
        "120.5 ±  1.2 ",
        " 80 %",
        "and 1 more, each less worn",
        "original: solved with a fillet of 4.200 mm; the CAD kernel breaks on the 6.000 mm drawn.",
        "original: seat is a bore of 30.00 mm radius, 2 faces, 5655 mm²",
        "original: bolt 1 is 1 face, 300.0 mm²",
        "and 1 milder case: --json",
        "original, microstrain",
        "Refining changes the gauges' influence by 1.2 % of the largest at most, 1.2",
        "original, damage",
        "duty cycle, gvw",
        "What the reinforcement changes",
    ):
        assert words in said, words
    portuguese = told("pt", "original")
    assert "120,5" in portuguese
    assert "120.5" not in portuguese
    assert "bolt 1: 1 face, 300,0 mm²" in portuguese
    assert "bolt 1: 1 faccia, 300,0 mm²" in told("it", "original")
    assert "O que o reforço muda" not in portuguese


@pytest.mark.parametrize("code", CODES)
def test_the_hours_of_all_places_are_told_as_such(code):
    """One place had two lives: its own, and those between which the first of all places fails."""
    say, settled = Language(code), approved("original")
    (v,) = settled.findings[0].answer.variants
    places, lives = bare(terminal(settled, say, width=400)).split(say("damage per turn"))
    first = say("hours to the first failure")
    assert first != say("hours")
    assert first not in places
    assert first in lives
    assert first in bracket_chapter._damage(v, say).head
    assert first not in bracket_chapter._features(v, say).head


@pytest.mark.parametrize("code", CODES)
def test_a_bar_too_wide_to_use_says_what_would_narrow_it(code):
    """Told to 45 %, a bolt's border is to 18 with smaller elements; 25 is what nobody followed."""
    say, settled = Language(code), approved("original")
    answer = settled.findings[0].answer
    (first,) = answer.variants
    wide = tuple(replace(f, error=0.45) for f in first.features)
    vague = replace(answer, variants=(replace(first, features=wide),))
    vague = replace(settled, findings=(replace(settled.findings[0], answer=vague),))
    before, after = (bare(terminal(a, say, width=400)).splitlines() for a in (settled, vague))
    more = [line for line in after if line not in before and "`element_mm`" in line]
    assert len(more) == 1
    assert say.part(first.features[0].part) in more[0]


def changed(**how) -> BracketAnswer:
    """The answer with something else in its one variant."""
    answer = approved("original").findings[0].answer
    return replace(answer, variants=(replace(answer.variants[0], **how),))


@pytest.mark.parametrize("code", CODES)
def test_a_seat_that_moves_as_far_as_the_bracket_is_large_is_told(code):
    """A gigannewton moved one of 240 mm by 12 km, and all that was asked of it passed."""
    say = Language(code)
    (still,) = approved("original").findings[0].answer.variants
    assert not [*bent_far(still, say)]
    far = replace(still, outcomes=(replace(still.outcomes[0], motion=11.9e3), *still.outcomes[1:]))
    (said,) = bent_far(far, say)
    assert "240 mm" in said
    assert said in report_of(changed(outcomes=far.outcomes), say)


@pytest.mark.parametrize("code", CODES)
def test_a_report_says_what_narrows_a_bar_as_the_terminal_does(code):
    """45 % stood in the report by itself: the terminal alone said what to do."""
    say = Language(code)
    (first,) = approved("original").findings[0].answer.variants
    wide = tuple(replace(f, error=0.45) for f in first.features)
    assert not [line for line in report_of(changed(), say) if "`element_mm`" in line]
    assert [line for line in report_of(changed(features=wide), say) if "`element_mm`" in line]


@pytest.mark.slow
@pytest.mark.parametrize("code", CODES)
def test_what_the_flange_leaves_open_is_told_with_what_settles_it(code):
    """Between 20 and 22.6 million hours helped nobody, and nothing said that `bolts` tells more."""
    say, settled = Language(code), approved("original")
    (finding,) = settled.findings
    limit = Limit(quantity="bracket_life", maximum=5000.0 * hour, sense=">=", source=MINER)
    life = Check(
        quantity="bracket_life", line="main", when=Occasion("duty", "gvw"), part=Part("sheet", 1),
        value=900 * hour, limit=limit, within=(20 * hour, 22.6e6 * hour),
    )  # fmt: skip
    wide = replace(life, settled_by=("bracket.bolts",))
    written = "bolts: {preload_kN: 27, friction: 0.15}"
    for one, there in ((life, False), (wide, True)):
        told = replace(finding, checks=(one,))
        of = replace(settled, findings=(told,))
        said = bare(terminal(of, say, width=400))
        assert ("`bracket.bolts`" in said) is there
        assert (written in said) is there
        document = check(one)
        assert document.get("settled_by", []) == ["bracket.bolts"] * there
        jsonschema.validate(document, schema()["$defs"]["check"] | {"$defs": schema()["$defs"]})
        blocks = [*bracket_chapter.told(told, say)]
        notes = [p for b in blocks if isinstance(b, Text) for p in b.paragraphs]
        assert any(written in p for p in notes) is there


@pytest.mark.parametrize("code", CODES)
def test_cases_of_which_the_table_says_the_same_are_told_once(code):
    """Order 2, and that with a mean which adds nothing, were two rows of the same numbers."""
    say = Language(code)
    answer = approved("original").findings[0].answer
    (v,) = answer.variants
    (first, *_) = v.outcomes
    two = [
        replace(first, life=replace(first.life, when=replace(first.life.when, what=what)))
        for what in ("order 2", "combined")
    ]
    same = replace(v, outcomes=tuple(two), duty=())
    assert [e.when.what for e in worn(same)] == ["combined"]
    assert len(bracket_chapter._damage(same, say).rows) == 1
    other = replace(two[0], life=replace(two[0].life, spots=1.01 * two[0].life.spots))
    assert [e.when.what for e in worn(replace(same, outcomes=(other, two[1])))] == [
        "order 2", "combined",
    ]  # fmt: skip
    elsewhere = replace(two[0].life.when, name="jounce")
    other = replace(two[0], life=replace(two[0].life, when=elsewhere))
    assert len(worn(replace(same, outcomes=(other, two[1])))) == 2


CONTACT = InBolts(
    bolts=Bolts(preload=35e3), when=Occasion("case", "gvw", "combined"),
    times=np.array([0.65, 1.0]), told=np.array([11.8, 5.0]), life_told=120.0,
)  # fmt: skip


@pytest.mark.parametrize("code", CODES)
def test_what_pulls_a_flange_off_its_frame_is_said_and_what_judges_it(code):
    """Neither way held bounds it; in contact it has been judged, and nobody need ask for that."""
    say = Language(code)
    (first,) = approved("original").findings[0].answer.variants
    assert not [*pulled_off(first, say)]
    off = replace(first, outcomes=(replace(first.outcomes[0], pulls_off=True),))
    said, more = pulled_off(off, say)
    assert "11 %" in said
    assert "`bolts`" in more
    assert [*pulled_off(replace(off, in_bolts=CONTACT), say)] == [said]


@pytest.mark.parametrize("code", CODES)
def test_contact_is_told_with_the_two_ways_beside_it(code):
    """0.8 of its limit in its bolts, 11.8 times where the flange slides or is clamped."""
    (said,) = [x for x in report_of(changed(in_bolts=CONTACT), Language(code)) if "1180 %" in x]
    assert "80 %" in said
    assert "120" in said


def test_frequencies_that_lie_close_are_drawn_as_one_line():
    """Three within 2 Hz were a black bar of dashes; their names all stand beside it."""
    of = changed()
    held = SimpleNamespace(**vars(of.variants[0].solved.sliding))
    held.carried = np.array([40.0, 60.0, 60.3, 60.9, 500.0, 600.0])
    solved = SimpleNamespace(**vars(of.variants[0].solved) | {"sliding": held})
    drawn = next(bracket_chapter.figures(changed(solved=solved), Language("en"))).svg
    assert "mode 2 60.0, mode 3 60.3, mode 4 60.9 Hz" in drawn
    rest = next(bracket_chapter.figures(changed(solved=alone_at(solved, 60.0)), Language("en"))).svg
    assert drawn.count("stroke-dasharray") == rest.count("stroke-dasharray")
    # A ring where an order meets a line stays clear of its name above it.
    names = [float(y) for y in re.findall(r'<text [^>]*y="([\d.]+)"[^>]*>mode', drawn)]
    rings = [(float(y), float(r)) for y, r in re.findall(r'cy="([\d.]+)" r="([\d.]+)"', drawn)]
    assert names
    assert rings
    assert all(not y - 12 < cy - r - 1 < y for y in names for cy, r in rings)


def alone_at(solved: SimpleNamespace, frequency: float) -> SimpleNamespace:
    """The same with one mode there."""
    held = SimpleNamespace(**vars(solved.sliding))
    held.carried = np.array([40.0, frequency, 500.0, 600.0, 700.0, 800.0])
    return SimpleNamespace(**vars(solved) | {"sliding": held})


@pytest.mark.parametrize("code", CODES)
def test_bolts_that_slip_are_told_by_their_case(code):
    """What is told of a flange that slides is not what it feels."""
    say = Language(code)
    of = changed()
    (variant,) = of.variants
    still = replace(variant, outcomes=(replace(outcome(), slips=0.9),))
    slid = replace(variant, outcomes=(replace(outcome(), slips=1.2),))
    assert [*in_contact(still, say)] == []
    (said,) = in_contact(slid, say)
    assert said.startswith(say.occasion(outcome().case.when))
    rides = Slip(Occasion("duty", "laden"), 1.3)
    (said,) = in_contact(replace(still, riding=(rides,)), say)
    assert said.startswith(say.occasion(rides.when))


def report_of(answer: BracketAnswer, say: Language) -> list[str]:
    """What a report says of its numbers."""
    return [*bracket_chapter.notes(answer, say)]


def test_a_stiffness_to_paste_tells_how_far_elements_may_be_too_stiff():
    assert "its elements are too stiff, by 3.1 % at most" in told("en", "original")


def test_forces_read_from_gauges_tell_what_noise_makes_of_them():
    """Against the scatter of forces read from 4000 readings of noise alone."""
    random = np.random.default_rng(3)
    influence = 1e-8 * random.standard_normal((4, 9))
    noise = 1e-6 * random.standard_normal((4000, 4))
    field = BracketRecording(name="field", rate=200.0, strain=noise)
    (finding,) = approved("original").findings
    of = replace(finding.answer, bracket=replace(finding.answer.bracket, recordings=(field,)))
    v = of.variants[0]
    back = recover(influence[:, :3], noise, unsure=[2e-9, 0, 0])
    case = replace(v.outcomes[0].case, name="field", read=back)
    v = replace(v, outcomes=(replace(v.outcomes[0], case=case),))
    said = next(r for r in remarks(of, v) if "field" in r)
    forces = np.linalg.lstsq(influence[:, :3], noise.T, rcond=None)[0]
    read = [
        float(n) for n in re.findall(r"([0-9.]+) N along|([0-9.]+) along", said) for n in n if n
    ]
    assert read == pytest.approx(forces.std(axis=1), rel=0.05)
    # One of four gauges is left over: half of its noise.
    left = float(re.search("([0-9.]+) microstrain of what", said)[1])
    assert left == pytest.approx(0.5, rel=0.05)
    # Of noise alone no force explains half, by all of which the forces may be off.
    wrong = next(r for r in remarks(of, v) if "may be off" in r)
    off = [float(n) for n in re.findall(r"([0-9.]+)(?: N)? along", wrong)]
    assert off == pytest.approx(back.off, rel=0.05)
    assert np.all(off > 3 * forces.std(axis=1))
    # Who read forces back himself kept that.
    read = replace(field, force=forces.T, strain=None, read=True)
    of = replace(of, bracket=replace(of.bracket, recordings=(read,)))
    assert any("explains is not known here" in r for r in remarks(of, v))
