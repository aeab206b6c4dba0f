"""A bracket's numbers in a terminal, in every language: without solving one."""

import re
from dataclasses import replace
from html import escape
from types import SimpleNamespace

import jsonschema
import numpy as np
import pytest
from brackets import BRACKET, LINE

from cardan.application import reader
from cardan.approval.approval import Approval
from cardan.approval.study import StudyResult, unevaluated_checks
from cardan.core.labels import EvaluationCondition, Part
from cardan.core.provenance import MINER_1945
from cardan.core.units import hour
from cardan.core.verdict import Check, Limit
from cardan.documents.approval_schema import schema
from cardan.model.bracket import Bolts, BracketRecording
from cardan.physics.fem.bracket_solid import FaceSelection
from cardan.physics.fem.strain_gauges import recover_loads
from cardan.render.blocks import Text
from cardan.render.i18n import LANGUAGE_CODES, Translator
from cardan.render.json_contract import check_json
from cardan.render.text_layout import without_colours
from cardan.topics.bracket import chapter as bracket_chapter
from cardan.topics.bracket import scene as bracket_scene
from cardan.topics.bracket.assessment import BracketResult
from cardan.topics.bracket.contact_assessment import ContactResult
from cardan.topics.bracket.life import DamageResult
from cardan.topics.bracket.load_cases import BearingLoadCase
from cardan.topics.bracket.phrases import (
    contact_notes,
    finite_element_solution_remarks,
    joint_face_lift_off_notes,
    large_displacement_notes,
)
from cardan.topics.bracket.presentation import terminal_lines, verdict_lines
from cardan.topics.bracket.presentation_values import most_damaging_results
from cardan.topics.bracket.screen_presentation import MAX_LINES, screen_lines
from cardan.topics.bracket.shape_result import (
    BoltSlipUtilisation,
    CaseResult,
    FatigueFeature,
    LocatedStress,
    ResonanceCrossing,
    ShapeAssessment,
)

FILE = (
    LINE
    + BRACKET
    + """\
  gauges: [{name: S1, point_mm: [0, 56, 20], direction: [0, 0, 1]}]
"""
)

HOT = np.array([120.5e6, 80.25e6])


def outcome() -> CaseResult:
    at = (0.0, 0.05, 0.02)
    when = EvaluationCondition("case", "gvw", "combined")
    life = DamageResult(
        when=when,
        hot_spot_damage=np.array([1e-7, 2e-8]),
        gauge_damage=np.array([1e-9]),
        turns=0.5,
        duration=0.012,
    )
    return CaseResult(
        case=BearingLoadCase(
            "gvw", np.zeros((1, 9)), turns=0.5, duration=0.012, component="combined"
        ),
        von_mises=LocatedStress(110e6, at),
        max_principal=LocatedStress(115e6, at),
        min_principal=LocatedStress(-90e6, at),
        max_nodal_von_mises=LocatedStress(200e6, at),
        feature_stress=HOT,
        feature_stress_error=HOT / 100,
        mean=HOT / 2,
        amplitude=HOT / 2,
        utilisation=HOT / 150e6,
        favourable_utilisation=HOT / 150e6,
        utilisation_bounds=np.outer(HOT / 150e6, [0.99, 1.01]),
        min_feature_stress=HOT,
        gauge_strain_range=np.array([[-1e-4, 2e-4]]),
        bolt_forces=np.array([1e3]),
        seat_displacement=1e-4,
        damage_result=life,
    )


def judged(name: str, wear: float = 1.0) -> ShapeAssessment:
    held = SimpleNamespace(
        compliance=np.diag([1e-7] * 6),
        influence=np.full((1, 9), 1e-7),
        frequencies=np.full(6, 310.5),
        loaded_frequencies=np.full(6, 60.25),
        stiffness_error=np.array([0.031, 0.012, 0.02]),
        frequency_error=np.full(6, 0.01),
    )
    solved = SimpleNamespace(
        unknowns=72705, mass=1.25, sliding=held, clamped=held, influence_change=0.012,
        fillet=(0.006, 0.0042), nodes=SimpleNamespace(points=np.array([[0.0] * 3, [0.24] * 3])),
        face_selections=(
            FaceSelection(name="seat", face_count=2, area=5.655e-3, radius=0.03),
            FaceSelection(name="bolt 1", face_count=1, area=3e-4),
        ),
    )  # fmt: skip
    features = tuple(
        FatigueFeature(zone=zone, number=k, point=(0, 0.05, 0.02), error=0.01)
        for k, zone in enumerate(("weld toe", "sheet"), 1)
    )
    life = outcome().damage_result
    return ShapeAssessment(
        name=name,
        solved=solved,
        features=features,
        listed_count=1,
        crossings=(ResonanceCrossing(1, 60.25, 2, 189.3, in_range=True),),
        case_results=(outcome(),) * 9,
        damage_map=np.zeros(0),
        duty_damage=(
            replace(
                life,
                when=EvaluationCondition("duty", "gvw"),
                hot_spot_damage=life.hot_spot_damage * wear,
            ),
        ),
    )


def approved(*variants: str) -> Approval:
    application = reader.loads(FILE)
    answer = BracketResult(
        title=application.title, bracket=application.bracket, top_speed=262.0,
        variants=tuple(map(judged, variants)),
    )  # fmt: skip
    missed = tuple(unevaluated_checks("bracket", application, ("duty, and bracket.fatigue",)))
    finding = StudyResult(study="bracket", answer=answer, unevaluated=missed)
    return Approval(application=application, study_results=(finding,))


def told(code: str, *variants: str, width: int = 400) -> str:
    return without_colours(terminal_lines(approved(*variants), Translator(code), width=width))


@pytest.mark.parametrize("width", [80, 120])
@pytest.mark.parametrize("code", LANGUAGE_CODES)
def test_life_output_fits_terminal_width(code, width):
    """Its tables were 110 wide, and what swings on the rubber 200."""
    lines = told(code, "original", "reinforced", width=width).splitlines()
    assert len(lines) > 60
    assert [line for line in lines if len(line) > width] == []
    assert max(map(len, lines)) > width - 12


def screen(code: str, *variants: str) -> list[str]:
    return without_colours(screen_lines(approved(*variants), Translator(code))).splitlines()


@pytest.mark.parametrize("variants", [("original",), ("original", "reinforced")])
def test_bracket_screen_stays_one_screen_in_every_language(variants):
    english = screen("en", *variants)
    for code in LANGUAGE_CODES:
        lines = screen(code, *variants)
        assert len(lines) <= MAX_LINES == 32
        assert max(map(len, lines)) <= 80
        if code != "en":
            words = {line for line in english if re.search("[a-z]{4} [a-z]", line)}
            assert {w for w in words & set(lines) if "--with" not in w} == set()


def test_bracket_screen_has_verdict_stress_life_and_gravest_doubt_first():
    of = approved("original", "reinforced")
    moved = replace(of.answer_of("bracket").variants[0].case_results[0], seat_displacement=0.1)
    first = replace(of.answer_of("bracket").variants[0], case_results=(moved,))
    answer = replace(
        of.answer_of("bracket"), variants=(first, *of.answer_of("bracket").variants[1:])
    )
    of = replace(of, study_results=(replace(of.study_results[0], answer=answer),))
    lines = without_colours(screen_lines(of)).splitlines()
    assert lines[0].endswith("  INCOMPLETE")
    said = " ".join(" ".join(lines).split())
    assert "highest stress 120.5 ± 1.205 MPa at weld toe 1 (gvw: combined)" in said
    assert "80 % of the fatigue limit at weld toe 1" in said  # 120.5 of 150 MPa
    assert "h to the first failure" in said
    assert "the variant is" in said
    gravest = lines[lines.index("Before you sign") + 1]
    assert "moves the bearing's seat by 100.0 mm" in gravest
    assert "Not evaluated: " in said
    assert "cardan bracket FILE --all" in said


@pytest.mark.parametrize("code", [c for c in LANGUAGE_CODES if c != "en"])
def test_everything_is_told_in_the_language(code):
    """No line of words stays as it is in English, but a material with its standard, and a unit."""
    english = told("en", "original", "reinforced").splitlines()
    other = told(code, "original", "reinforced").splitlines()
    assert len(other) == len(english)
    words = [line for line in english if re.search("[a-z]{4}", line)]
    assert len(words) > 30
    alike = [w for w in words if w in other and "EN 13906-1" not in w]
    assert [w for w in alike if w != "original, MPa"] == []


@pytest.mark.parametrize("code", LANGUAGE_CODES)
def test_a_bracket_s_page_says_the_verdict_and_the_limits_that_a_terminal_says(code, monkeypatch):
    """It showed the mesh in its colours, in English, and no verdict."""
    monkeypatch.setattr(bracket_scene, "scene_html", lambda _, say: f"<p>{say.code}</p>")
    of, say = approved("original"), Translator(code)
    page = bracket_scene.html_page(of, say=say)
    first, _, limits = without_colours(verdict_lines(of, say)).partition("\n")
    assert limits.splitlines()[-1] in told(code, "original")
    assert f'lang="{code}"' in page
    assert f'<p class="incomplete" style="font-size:1.2em"><strong>{first}</strong></p>' in page
    assert len(limits.splitlines()) > 3
    assert f">{escape(limits)}</pre>" in page
    assert page.index("</pre>") < page.index(f"<p>{code}</p>")


@pytest.mark.parametrize(("code", "sign"), [("en", "."), ("pt", ","), ("it", ",")])
def test_the_scale_of_a_scene_has_the_languages_decimal_sign(code, sign):
    nothing = SimpleNamespace(case_results=())
    of = SimpleNamespace(variants=(nothing,), bracket=SimpleNamespace(gauges=()))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bracket_scene, "variant_scene_data", lambda *_: {})
        shown = bracket_scene.scene_html(of, say=Translator(code))
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


@pytest.mark.parametrize("code", LANGUAGE_CODES)
def test_the_hours_of_all_places_are_told_as_such(code):
    """One place had two lives: its own, and those between which the first of all places fails."""
    say, settled = Translator(code), approved("original")
    (v,) = settled.study_results[0].answer.variants
    places, lives = without_colours(terminal_lines(settled, say, width=400)).split(
        say("damage per turn")
    )
    first = say("hours to the first failure")
    assert first != say("hours")
    assert first not in places
    assert first in lives
    assert first in bracket_chapter._damage(v, say).head
    assert first not in bracket_chapter._features(v, say).head


@pytest.mark.parametrize("code", LANGUAGE_CODES)
def test_a_bar_too_wide_to_use_says_what_would_narrow_it(code):
    """Told to 45 %, a bolt's border is to 18 with smaller elements; 25 is what nobody followed."""
    say, settled = Translator(code), approved("original")
    answer = settled.study_results[0].answer
    (first,) = answer.variants
    wide = tuple(replace(f, error=0.45) for f in first.features)
    vague = replace(answer, variants=(replace(first, features=wide),))
    vague = replace(settled, study_results=(replace(settled.study_results[0], answer=vague),))
    before, after = (
        without_colours(terminal_lines(a, say, width=400)).splitlines() for a in (settled, vague)
    )
    more = [line for line in after if line not in before and "`element_mm`" in line]
    assert len(more) == 1
    assert say.part(first.features[0].part) in more[0]


def changed(**how) -> BracketResult:
    """The answer with something else in its one variant."""
    answer = approved("original").study_results[0].answer
    return replace(answer, variants=(replace(answer.variants[0], **how),))


@pytest.mark.parametrize("code", LANGUAGE_CODES)
def test_a_seat_that_moves_as_far_as_the_bracket_is_large_is_told(code):
    """A gigannewton moved one of 240 mm by 12 km, and all that was asked of it passed."""
    say = Translator(code)
    (still,) = approved("original").study_results[0].answer.variants
    assert not [*large_displacement_notes(still, say)]
    far = replace(
        still,
        case_results=(
            replace(still.case_results[0], seat_displacement=11.9e3),
            *still.case_results[1:],
        ),
    )
    (said,) = large_displacement_notes(far, say)
    assert "240 mm" in said
    assert said in report_of(changed(case_results=far.case_results), say)


@pytest.mark.parametrize("code", LANGUAGE_CODES)
def test_a_report_says_what_narrows_a_bar_as_the_terminal_does(code):
    """45 % stood in the report by itself: the terminal alone said what to do."""
    say = Translator(code)
    (first,) = approved("original").study_results[0].answer.variants
    wide = tuple(replace(f, error=0.45) for f in first.features)
    assert not [line for line in report_of(changed(), say) if "`element_mm`" in line]
    assert [line for line in report_of(changed(features=wide), say) if "`element_mm`" in line]


@pytest.mark.slow
@pytest.mark.parametrize("code", LANGUAGE_CODES)
def test_what_the_flange_leaves_open_is_told_with_what_settles_it(code):
    """Between 20 and 22.6 million hours helped nobody, and nothing said that `bolts` tells more."""
    say, settled = Translator(code), approved("original")
    (finding,) = settled.study_results
    limit = Limit(quantity="bracket_life", maximum=5000.0 * hour, sense=">=", source=MINER_1945)
    life = Check(
        quantity="bracket_life",
        line="main",
        when=EvaluationCondition("duty", "gvw"),
        part=Part("sheet", 1),
        value=900 * hour,
        limit=limit,
        within=(20 * hour, 22.6e6 * hour),
    )
    wide = replace(life, deciding_inputs=("bracket.bolts",))
    written = "bolts: {preload_kN: 27, friction: 0.15}"
    for one, there in ((life, False), (wide, True)):
        told = replace(finding, checks=(one,))
        of = replace(settled, study_results=(told,))
        said = without_colours(terminal_lines(of, say, width=400))
        assert ("`bracket.bolts`" in said) is there
        assert (written in said) is there
        document = check_json(one)
        assert document.get("settled_by", []) == ["bracket.bolts"] * there
        jsonschema.validate(document, schema()["$defs"]["check"] | {"$defs": schema()["$defs"]})
        blocks = [*bracket_chapter.bracket_blocks_without_picture(told, say)]
        notes = [p for b in blocks if isinstance(b, Text) for p in b.paragraphs]
        assert any(written in p for p in notes) is there


@pytest.mark.parametrize("code", LANGUAGE_CODES)
def test_cases_of_which_the_table_says_the_same_are_told_once(code):
    """Order 2, and that with a mean which adds nothing, were two rows of the same numbers."""
    say = Translator(code)
    answer = approved("original").study_results[0].answer
    (v,) = answer.variants
    (first, *_) = v.case_results
    two = [
        replace(
            first,
            damage_result=replace(
                first.damage_result, when=replace(first.damage_result.when, what=what)
            ),
        )
        for what in ("order 2", "combined")
    ]
    same = replace(v, case_results=tuple(two), duty_damage=())
    assert [e.when.what for e in most_damaging_results(same)] == ["combined"]
    assert len(bracket_chapter._damage(same, say).rows) == 1
    other = replace(
        two[0],
        damage_result=replace(
            two[0].damage_result, hot_spot_damage=1.01 * two[0].damage_result.hot_spot_damage
        ),
    )
    assert [
        e.when.what for e in most_damaging_results(replace(same, case_results=(other, two[1])))
    ] == [
        "order 2",
        "combined",
    ]
    elsewhere = replace(two[0].damage_result.when, name="jounce")
    other = replace(two[0], damage_result=replace(two[0].damage_result, when=elsewhere))
    assert len(most_damaging_results(replace(same, case_results=(other, two[1])))) == 2


CONTACT = ContactResult(
    bolts=Bolts(preload=35e3),
    when=EvaluationCondition("case", "gvw", "combined"),
    stress_factors=np.array([0.65, 1.0]),
    utilisation_without_contact=np.array([11.8, 5.0]),
    life_without_contact=120.0,
)


@pytest.mark.parametrize("code", LANGUAGE_CODES)
def test_what_pulls_a_flange_off_its_frame_is_said_and_what_judges_it(code):
    """Neither way held bounds it; in contact it has been judged, and nobody need ask for that."""
    say = Translator(code)
    (first,) = approved("original").study_results[0].answer.variants
    assert not [*joint_face_lift_off_notes(first, say)]
    off = replace(first, case_results=(replace(first.case_results[0], pulls_off=True),))
    said, more = joint_face_lift_off_notes(off, say)
    assert "11 %" in said
    assert "`bolts`" in more
    assert [*joint_face_lift_off_notes(replace(off, contact_result=CONTACT), say)] == [said]


@pytest.mark.parametrize("code", LANGUAGE_CODES)
def test_contact_is_told_with_the_two_ways_beside_it(code):
    """0.8 of its limit in its bolts, 11.8 times where the flange slides or is clamped."""
    (said,) = [
        x for x in report_of(changed(contact_result=CONTACT), Translator(code)) if "1180 %" in x
    ]
    assert "80 %" in said
    assert "120" in said


def test_frequencies_that_lie_close_are_drawn_as_one_line():
    """Three within 2 Hz were a black bar of dashes; their names all stand beside it."""
    of = changed()
    held = SimpleNamespace(**vars(of.variants[0].solved.sliding))
    held.loaded_frequencies = np.array([40.0, 60.0, 60.3, 60.9, 500.0, 600.0])
    solved = SimpleNamespace(**vars(of.variants[0].solved) | {"sliding": held})
    drawn = next(bracket_chapter.bracket_figures(changed(solved=solved), Translator("en"))).svg
    assert "mode 2 60.0, mode 3 60.3, mode 4 60.9 Hz" in drawn
    rest = next(
        bracket_chapter.bracket_figures(changed(solved=alone_at(solved, 60.0)), Translator("en"))
    ).svg
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
    held.loaded_frequencies = np.array([40.0, frequency, 500.0, 600.0, 700.0, 800.0])
    return SimpleNamespace(**vars(solved) | {"sliding": held})


@pytest.mark.parametrize("code", LANGUAGE_CODES)
def test_bolts_that_slip_are_told_by_their_case(code):
    """What is told of a flange that slides is not what it feels."""
    say = Translator(code)
    of = changed()
    (variant,) = of.variants
    still = replace(variant, case_results=(replace(outcome(), slip_utilisation=0.9),))
    slid = replace(variant, case_results=(replace(outcome(), slip_utilisation=1.2),))
    assert [*contact_notes(still, say)] == []
    (said,) = contact_notes(slid, say)
    assert said.startswith(say.occasion(outcome().case.when))
    rides = BoltSlipUtilisation(EvaluationCondition("duty", "laden"), 1.3)
    (said,) = contact_notes(replace(still, duty_slips=(rides,)), say)
    assert said.startswith(say.occasion(rides.when))


def report_of(answer: BracketResult, say: Translator) -> list[str]:
    """What a report says of its numbers."""
    return [*bracket_chapter.bracket_notes(answer, say)]


def test_a_stiffness_to_paste_tells_how_far_elements_may_be_too_stiff():
    assert "its elements are too stiff, by 3.1 % at most" in told("en", "original")


def test_forces_read_from_gauges_tell_what_noise_makes_of_them():
    """Against the scatter of forces read from 4000 readings of noise alone."""
    random = np.random.default_rng(3)
    influence = 1e-8 * random.standard_normal((4, 9))
    noise = 1e-6 * random.standard_normal((4000, 4))
    field = BracketRecording(name="field", rate=200.0, strain=noise)
    (finding,) = approved("original").study_results
    of = replace(finding.answer, bracket=replace(finding.answer.bracket, recordings=(field,)))
    v = of.variants[0]
    back = recover_loads(influence[:, :3], noise, unsure=[2e-9, 0, 0])
    case = replace(v.case_results[0].case, name="field", recovered_loads=back)
    v = replace(v, case_results=(replace(v.case_results[0], case=case),))
    said = next(r for r in finite_element_solution_remarks(of, v) if "field" in r)
    forces = np.linalg.lstsq(influence[:, :3], noise.T, rcond=None)[0]
    read = [
        float(n) for n in re.findall(r"([0-9.]+) N along|([0-9.]+) along", said) for n in n if n
    ]
    assert read == pytest.approx(forces.std(axis=1), rel=0.05)
    # One of four gauges is left over: half of its noise.
    left = float(re.search("([0-9.]+) microstrain of what", said)[1])
    assert left == pytest.approx(0.5, rel=0.05)
    # Of noise alone no force explains half, by all of which the forces may be off.
    wrong = next(r for r in finite_element_solution_remarks(of, v) if "may be off" in r)
    off = [float(n) for n in re.findall(r"([0-9.]+)(?: N)? along", wrong)]
    assert off == pytest.approx(back.load_error, rel=0.05)
    assert np.all(off > 3 * forces.std(axis=1))
    # Who read forces back himself kept that.
    read = replace(field, force=forces.T, strain=None, read=True)
    of = replace(of, bracket=replace(of.bracket, recordings=(read,)))
    assert any("explains is not known here" in r for r in finite_element_solution_remarks(of, v))
