"""What a bracket bears by its metal, by hand from the FKM guideline, IIW and EN 1999-1-3."""

from dataclasses import replace

import numpy as np
import pytest
from brackets import BRACKET, LINE

from cardan.application import reader
from cardan.application.catalogue import find_shipped_part, read_shipped_catalogue
from cardan.approval.approval import Approval
from cardan.approval.study import BRACKET_STUDY_NAME as STUDY
from cardan.approval.study import StudyResult, limits_of_study
from cardan.core.errors import DesignError, InvalidFileError
from cardan.core.units import MPa, mm
from cardan.model.bracket import FATIGUE_ZONES
from cardan.model.material import METAL_KINDS, Material
from cardan.physics.fatigue.mean_stress import goodman
from cardan.render.i18n import ENGLISH, LANGUAGE_CODES, Translator
from cardan.topics.bracket import assessment as study_of
from cardan.topics.bracket.assessment import analyse_bracket
from cardan.topics.bracket.chapter import bracket_blocks
from cardan.topics.bracket.life import ZoneFatigueStrength, fatigue_strength_by_zone
from cardan.topics.bracket.metal_fatigue_data import (
    DETAIL_NAME_SAME_AS_SHEET,
    fatigue_data_of_metal,
    zone_curve_key,
)
from cardan.topics.bracket.optimisation import find_lightest_bracket
from cardan.topics.bracket.presentation import terminal_lines
from cardan.topics.bracket.presentation_json import json_document
from cardan.topics.bracket.presentation_values import (
    feature_hours_to_failure,
    max_fatigue_utilisation,
)
from cardan.topics.bracket.shape_result import ShapeAssessment

FILE = (
    LINE
    + "duty: [{share_percent: 100, torque_Nm: 8000, speed_rpm: 2500}]\n"
    + BRACKET.replace("bolt_pitch_mm: 40", "bolt_pitch_mm: 42, gusset_mm: 5, gusset_height_mm: 50")
    + "  element_mm: 16\n  material: S355MC\n"
)
ROUGH = "  fatigue: {roughness_um: 100}\n"
IN_PLACE = "{youngs_modulus_GPa: 45, density_kg_m3: 1800, yield_MPa: 150, ultimate_MPa: 230}"


def of(material, fatigue=ROUGH):
    """Return the bracket of a file, of a material."""
    return reader.loads(FILE.replace("S355MC", material) + fatigue)


SHEETS = {
    # f Rm (1 - a lg 100 lg(2 Rm / Rm,N,min))
    "S355MC": 0.45 * 430 * (1 - 0.22 * 2 * np.log10(860 / 400)),
    "EN-GJS-500-7": 0.34 * 500 * (1 - 0.16 * 2 * np.log10(1000 / 400)),
    "6061-T6": 0.30 * 310 * (1 - 0.22 * 2 * np.log10(620 / 133)),
}


@pytest.mark.parametrize("material", SHEETS)
def test_a_sheet_bears_by_its_own_metal_s_factors(material):
    """EN-GJS-500-7 bears 148 MPa = 0.297 Rm, and was told as 185, steel's 0.371 Rm."""
    curve = fatigue_strength_by_zone(of(material).bracket)["sheet"].curve
    assert curve.amplitude / MPa == pytest.approx(SHEETS[material], rel=1e-9)
    assert (curve.cycles, curve.slope, curve.slope_beyond_knee) == (1e6, 5, 9)


CLASSES = {
    # class, its slope, and the life at a range of 100 MPa: two million (class / range)^slope
    "6061-T6": {"weld toe": (36, 3), "cut edge": (40, 3), "bolt border": (56, 4)},
    "S355MC": {"weld toe": (90, 3), "cut edge": (125, 3), "bolt border": (90, 3)},
}


@pytest.mark.parametrize("material", CLASSES)
def test_details_are_those_of_the_metal(material):
    """A weld toe of 6061-T6 was judged by steel's class: 2.5 times in stress, 16 in life."""
    found = fatigue_strength_by_zone(of(material).bracket)
    for zone, (range_, slope) in CLASSES[material].items():
        life = found[zone].curve.life(50 * MPa)
        assert life == pytest.approx(2e6 * (range_ / 100) ** slope, rel=1e-9)


def test_of_what_no_code_speaks_nobody_knows():
    """Castings have no class of a bolted hole; an edge is skin as the rest. Magnesium has none."""
    iron = fatigue_strength_by_zone(of("EN-GJS-500-7").bracket)
    assert set(iron) == {"sheet", "cut edge"}
    assert iron["cut edge"].curve == iron["sheet"].curve
    assert set(
        fatigue_strength_by_zone(of(IN_PLACE, "  fatigue: {amplitude_MPa: 50}\n").bracket)
    ) == {"sheet"}
    own = "  fatigue: {roughness_um: 100, bolt_border: {range_MPa: 50}}\n"
    told = fatigue_strength_by_zone(of("EN-GJS-500-7", own).bracket)
    assert set(told) == {"sheet", "cut edge", "bolt border"}
    assert told["bolt border"].curve.life(25 * MPa) == pytest.approx(2e6)


@pytest.mark.parametrize(
    ("material", "fatigue", "says"),
    [
        ("6061-T6", "{amplitude_MPa: 60, weld_toe: iiw-hotspot-90}",
         r"fatigue.weld_toe.*iiw-hotspot-90 is of steel, and 6061-T6 is aluminium.*in place"),
        ("S355MC", "{amplitude_MPa: 60, bolt_border: ec9-bolted-56}",
         r"fatigue.bolt_border.*ec9-bolted-56 is of aluminium, and S355MC is steel"),
        ("EN-GJS-500-7", "{amplitude_MPa: 60, cut_edge: iiw-edge-100}",
         r"fatigue.cut_edge.*of steel, and EN-GJS-500-7 is ductile iron"),
        (IN_PLACE, "{roughness_um: 100}", r"roughness_um.*FKM guideline.*in place is other"),
        (IN_PLACE[:-1] + ", metal: tin}", "{amplitude_MPa: 50}", r"metal.*one of steel, cast st"),
    ],
)  # fmt: skip
def test_what_is_of_another_metal_is_refused_with_its_line(material, fatigue, says):
    with pytest.raises(InvalidFileError, match=says) as refused:
        of(material, f"  fatigue: {fatigue}\n")
    assert all(p.line > LINE.count("\n") for p in refused.value.problems)


def test_a_metal_is_as_said_or_steel_where_it_is_as_stiff():
    """Files that were written before anybody asked are read as they were."""
    assert Material(name="a", youngs_modulus=206e9, density=7850).metal == "steel"
    assert Material(name="a", youngs_modulus=170e9, density=7100).metal == "other"
    assert Material(name="a", youngs_modulus=206e9, density=7850, kind="cast steel").metal == (
        "cast steel"
    )
    assert of(IN_PLACE[:-1] + ", metal: magnesium}", "").bracket.material.metal == "magnesium"
    rows = [find_shipped_part(name, "material") for name in read_shipped_catalogue("material").rows]
    assert all(row.kind for row in rows)


def test_every_metal_s_details_are_in_the_catalogue_and_of_it():
    for metal in METAL_KINDS:
        found = fatigue_data_of_metal(metal)
        for name in found.details.values() if found else ():
            assert name == DETAIL_NAME_SAME_AS_SHEET or find_shipped_part(
                name, "detail"
            ).metal == metal.removeprefix("cast ")
    assert [zone_curve_key(zone) for zone in FATIGUE_ZONES][2] == "weld_toe"


def test_a_mean_stress_counts_by_what_makes_more_of_it():
    """Grey iron, Rm 250: M 0.5, so 50 ± 50 MPa is 75; Goodman has 62.5, which steel keeps."""
    steel = of(
        IN_PLACE.replace("45", "206").replace("230", "250"), "  fatigue: {amplitude_MPa: 50}\n"
    )
    iron = of(
        IN_PLACE.replace("45", "110").replace("230", "250")[:-1] + ", metal: grey iron}",
        "  fatigue: {amplitude_MPa: 50}\n",
    )
    for application, told in ((steel, 62.5), (iron, 75.0)):
        strength = ZoneFatigueStrength.from_bracket(application.bracket)
        assert strength.correction(50 * MPa, 50 * MPa) / MPa == pytest.approx(told)
        # Near the strength Goodman's line is the harsher of any metal; a push earns nothing.
        assert strength.correction(10 * MPa, 240 * MPa) / MPa == pytest.approx(
            float(goodman(10, 240, ultimate=250))
        )
        assert strength.correction(50 * MPa, -50 * MPa) / MPa == pytest.approx(50)


def test_a_bolt_s_border_of_aluminium_bears_nowhere_more_than_the_code_says():
    """EN 1999-1-3, 56-4: slope 4 to 5e6 cycles, 6 from there to the cut-off at 1e8."""
    curve = fatigue_strength_by_zone(of("6061-T6").bracket)["bolt border"].curve
    cycles = np.logspace(5, 8, 61)
    knee = 56 * (2e6 / 5e6) ** (1 / 4)
    code = np.where(cycles < 5e6, 56 * (2e6 / cycles) ** (1 / 4), knee * (5e6 / cycles) ** (1 / 6))
    assert np.all(curve.life(code / 2 * MPa) <= 1.001 * cycles)
    assert curve.life(28 * MPa) == pytest.approx(2e6)


@pytest.fixture(scope="module")
def solved():
    """One solution of a U with gussets: as linear in any metal."""
    return analyse_bracket(of("S355MC")).variants[0].solved


def judged(solved, application):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "cardan.topics.bracket.shape_assessment.solve_in_subprocess", lambda *_, **__: solved
        )
        answer = analyse_bracket(application)
    limits = limits_of_study(STUDY, application)
    finding = StudyResult(
        study=STUDY, answer=answer,
        checks=tuple(study_of.bracket_checks(answer, answer.variants[0], limits)),
        unevaluated=tuple(study_of._unanswered(answer, answer.variants[0], limits)),
    )  # fmt: skip
    return answer.variants[0], Approval(application=application, study_results=(finding,))


@pytest.mark.bracket
def test_a_weld_of_aluminium_lives_shorter_by_its_class(solved):
    """At most (90 / 36)^3 = 15.6 times, above both knees, and (90 / 36)^5 = 98 below them."""
    (steel, _), (aluminium, approval) = (judged(solved, of(m)) for m in ("S355MC", "6061-T6"))

    def toes(v: ShapeAssessment):
        return {
            f.number: e
            for f, e in zip(v.features, v.duty_damage[0].hot_spot_damage, strict=True)
            if f.zone == "weld toe"
        }

    before, after = toes(steel), toes(aluminium)
    times = np.array([after[k] / before[k] for k in before])
    assert np.all((times > 2.5**3 * 0.999) & (times < 2.5**5 * 1.001))
    assert not any(f.beside_weld for f in steel.features)
    # The heat of the ribs' welds reaches their toes, and the flanges' bends 20 mm from them.
    assert all(f.beside_weld for f in aluminium.features if f.zone == "weld toe")
    worst = max(c.value for c in approval.checks if c.quantity == "bracket_stress_utilisation")
    hot = np.array([o.feature_stress for o in aluminium.case_results]).max(axis=0) / MPa
    limit = np.where([f.beside_weld for f in aluminium.features], 115, 276)
    assert worst == pytest.approx((hot / limit).max())
    assert not approval.coverage.missing_required


@pytest.mark.bracket
def test_only_what_lies_near_a_weld_is_softer(solved):
    """Within 20 mm in a wall of 6 mm: not the round the bearing sits in, 40 mm below the ribs."""
    v, _ = judged(solved, of("6061-T6"))
    toes = np.array([f.point for f in v.features if f.zone == "weld toe"])
    away = {f.number: np.linalg.norm(toes - f.point, axis=1).min() for f in v.features}
    assert {f.beside_weld for f in v.features} == {True, False}
    near = [f for f in v.features if f.zone == "sheet" and away[f.number] < 20 * mm]
    assert near or any(f.beside_weld for f in v.features if f.zone == "sheet")


@pytest.mark.bracket
def test_where_nobody_knows_nothing_is_approved(solved):
    """A U of ductile iron: welds and bolts have no number, and say what they need."""
    v, approval = judged(solved, of("EN-GJS-500-7"))
    missed = {
        (u.quantity, u.part.kind, u.missing_inputs) for u in approval.coverage.missing_required
    }
    assert missed == {
        (quantity, zone, (f"bracket.fatigue.{zone_curve_key(zone)}",))
        for quantity in ("bracket_fatigue_utilisation", "bracket_life")
        for zone in ("weld toe", "bolt border")
    }
    assert approval.verdict in ("incomplete", "fail")
    for quantity in ("bracket_fatigue_utilisation", "bracket_life"):
        zones = {c.part.kind for c in approval.checks if c.quantity == quantity}
        assert zones == {"sheet", "cut edge"}
    known = np.array([f.zone in ("sheet", "cut edge") for f in v.features])
    assert np.array_equal(
        np.isfinite(feature_hours_to_failure(v)) | (feature_hours_to_failure(v) == np.inf),
        known,
    )
    assert np.array_equal(~np.isnan(max_fatigue_utilisation(v)), known)
    assert v.life_hours == pytest.approx(feature_hours_to_failure(v)[known].min())
    assert v.life_hours_bounds[0] < v.life_hours < v.life_hours_bounds[1]
    contract = json_document(approval)
    (variant,) = contract["variants"]
    told = {h["zone"]: h["fatigue_utilisation"] for h in variant["hot_spots"]}
    assert told["weld toe"] is None
    assert told["sheet"] is not None
    assert contract["metal"] == "ductile iron"
    assert contract["bears"]["sheet"]["amplitude_MPa"] == pytest.approx(SHEETS["EN-GJS-500-7"])
    assert "weld toe" not in contract["bears"]
    for code in LANGUAGE_CODES:
        say = Translator(code)
        text = " ".join("\n".join(terminal_lines(approval, say)).split())
        assert "bracket.fatigue.weld_toe" in text
        assert say("ductile iron") in text
        assert bracket_blocks(approval.study_results[0], say)
    assert "not evaluated: no code gives the strength" in " ".join(
        "\n".join(terminal_lines(approval, ENGLISH)).split()
    )


@pytest.mark.bracket
def test_a_weld_that_softens_by_nobody_knows_how_much_has_no_yield(solved):
    application = of("6061-T6")
    bare = replace(application.bracket.material, welded_yield=None)
    application = replace(application, bracket=replace(application.bracket, material=bare))
    v, approval = judged(solved, application)
    (missed,) = approval.coverage.missing_required
    assert missed.quantity == "bracket_stress_utilisation"
    assert missed.missing_inputs == ("bracket.material with its welded_yield_MPa",)
    told = {c.part for c in approval.checks if c.quantity == "bracket_stress_utilisation"}
    assert told
    assert told <= {f.part for f in v.features if not f.beside_weld}


def test_sizes_are_not_searched_by_a_life_that_nobody_can_tell():
    wanted = "  optimise: {life_h: 5000, thickness_mm: [5, 6]}\n"
    with pytest.raises(DesignError, match=r"needs `weld_toe` in `fatigue`.*EN-GJS-500-7, ductile"):
        find_lightest_bracket(of("EN-GJS-500-7", ROUGH + wanted))
