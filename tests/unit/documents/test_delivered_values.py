"""What a line does beside its limits: axle loads, slopes, couples, forks, bending."""

import re
from dataclasses import replace

import numpy as np
import pytest
from repository import EXAMPLES

from cardan.application import reader
from cardan.approval.approval import approve_driveline
from cardan.core.errors import CardanError
from cardan.core.units import MPa, deg, mm
from cardan.documents import approval_json as contract
from cardan.documents import approval_report as story
from cardan.documents import terminal
from cardan.render.blocks import all_figures
from cardan.render.i18n import Translator
from cardan.render.phrases import check_state_phrase
from cardan.render.text_layout import without_colours as bare_text
from cardan.topics.design.sensitivity import check_sensitivities
from cardan.topics.design.yoke_phasing import yoke_phasings

TRUCK = approve_driveline(reader.read(EXAMPLES / "refuse-collector-6x2.yaml"))


def test_static_axle_loads_sum_to_weight_and_shift_rearward_at_slip():
    (response,) = TRUCK.line_responses
    rest, slip = response.axle_loads
    vehicle = response.application.vehicle
    assert vehicle is not None
    load = next(x for x in vehicle.loads if x.name == "gvw")
    assert rest[2].sum() == pytest.approx(load.front_load + load.rear_load, rel=1e-12)
    assert slip.sum(-1) == pytest.approx(rest.sum(-1), rel=1e-12)  # on the level nothing is lost
    assert (slip[:, 0] < rest[:, 0]).all()
    # What the driven axle gains comes from μ N h / L of its own load, N the load it slips with.
    driven, mu = slip[2, 1], 0.8
    moved = mu * driven * load.cg_height / vehicle.wheelbase
    assert rest[2, 0] - slip[2, 0] == pytest.approx(moved, rel=1e-9)


def test_slopes_and_lengths_match_hardpoints():
    (response,) = TRUCK.line_responses
    state = contract.json_document(TRUCK)["states"][0]
    steps = np.diff(response.layout.points[0], axis=0)
    assert [s["length_mm"] for s in state["shafts"]] == pytest.approx(
        np.linalg.norm(steps, axis=1) / mm, rel=1e-11
    )
    slopes = [m["side_slope_deg"] for m in state["members"]]
    assert slopes[1:-1] == pytest.approx(np.arctan2(-steps[:, 2], steps[:, 0]) / deg, rel=1e-9)
    assert [m["member"] for m in state["members"]] == [
        "gearbox", "shaft 1", "shaft 2", "shaft 3", "pinion",
    ]  # fmt: skip
    assert [a["axle"] for a in state["axles"]] == ["front axle", "driven rear axle", "rear axle"]


ONE = """
title: One shaft
speed_rpm: 1000
torque_Nm: 1000
driveline:
  slopes: {side_deg: [0, 20, 20.0001]}
  joints: [{cross_width_mm: 100, cup_length_mm: 20, cup_diameter_mm: 30}, {}]
  shafts: [{length_mm: 1000, tube: {outer_mm: 60, wall_mm: 3, material: {youngs_modulus_GPa: 206,
            density_kg_m3: 7850, yield_MPa: 400}}}]
limits: protractor
"""


def test_single_joint_forces_match_textbook():
    (response,) = approve_driveline(reader.loads(ONE)).line_responses
    ahead, behind = response.rigid_loads.secondary_couples
    beta = 20 * deg
    assert ahead[0, 0] == pytest.approx(1000 * np.tan(beta), rel=1e-9)
    assert behind[0, 0] == pytest.approx(1000 * np.sin(beta), rel=1e-9)
    assert response.rigid_loads.bending_moments[0, 0] == pytest.approx(
        1000 * np.sin(beta), rel=1e-9
    )
    force = 1000 / (0.08 * np.cos(beta))
    assert response.rigid_loads.journal_force[0, 0] == pytest.approx(force, rel=1e-9)
    assert response.rigid_loads.cup_pressure[0, 0] == pytest.approx(force / (0.03 * 0.02), rel=1e-9)
    # Thin walls by hand: I = π (D⁴ - d⁴)/64, σ = M D/2I, τ = T D/4I.
    second = np.pi * (0.06**4 - 0.054**4) / 64
    sigma, tau = 1000 * np.sin(beta) * 0.03 / second, 1000 * 0.015 / second
    used = np.sqrt(sigma**2 + 3 * tau**2) / (400 * MPa)
    assert response.strength.tube_stress_utilisation[0, 0] == pytest.approx(used, rel=1e-9)


def test_bending_moment_at_bearing_agrees_from_both_sides():
    text = (EXAMPLES / "refuse-collector-6x2.yaml").read_text(encoding="utf-8")
    (response,) = approve_driveline(
        reader.loads(text.replace("include: [gravity, unbalance]", ""))
    ).line_responses
    line, layout = response.line, response.layout
    loads = response.rigid_loads.joint_loads
    assert response.rigid_loads.bending_moments == pytest.approx(
        TRUCK.line_responses[0].rigid_loads.bending_moments, rel=1e-9
    )
    for k, shaft in enumerate(line.shafts[:-1]):
        assert shaft.centre_bearing is not None
        d = layout.directions[:, k + 1]
        lever = (shaft.length - shaft.centre_bearing.from_rear_joint) * d
        moment = loads.joint_moments.values()[:, k] - np.cross(
            lever[:, None], loads.joint_forces.values()[:, k]
        )
        across = moment - (moment * d[:, None]).sum(-1, keepdims=True) * d[:, None]
        size = np.linalg.norm(across, axis=-1).max(-1)
        # Samples of a turn miss a peak; bending is at least that and no less than at the ends.
        assert (response.rigid_loads.bending_moments[:, k] >= size * (1 - 1e-9)).all()
        ends = np.maximum(
            response.rigid_loads.secondary_couples[1][:, k],
            response.rigid_loads.secondary_couples[0][:, k + 1],
        )
        assert response.rigid_loads.bending_moments[:, k] == pytest.approx(
            np.maximum(size, ends), rel=0.02
        )


@pytest.mark.slow
def test_axle_to_frame_distance_decreases_in_bump():
    text = (EXAMPLES / "refuse-collector-6x2.yaml").read_text(encoding="utf-8")
    text = text.replace("suspension:", "suspension:\n  axle_to_frame_mm: 300", 1)
    (response,) = approve_driveline(reader.loads(text)).line_responses
    state = contract.json_document(approve_driveline(reader.loads(text)))["states"]
    for one, travel in zip(state, response.demand.travel, strict=True):
        assert one["axle_to_frame_mm"] == pytest.approx(300 - travel / mm, rel=1e-9)
    assert np.isnan(TRUCK.line_responses[0].axle_to_frame).all()


def test_phasing_options_equal_files_with_those_phases():
    """Souza's figure 36 without editing the file: each is what a file with those phases gives."""
    text = (EXAMPLES / "three-joint-chain.yaml").read_text(encoding="utf-8")
    app = reader.loads(text)
    found = yoke_phasings(approve_driveline(app).line_responses[0])
    assert [tuple(round(p / deg) for p in one.phases) for one in found] == [
        (0, 0), (0, 90), (90, 0), (90, 90),
    ]  # fmt: skip
    assert [one.is_installed for one in found] == [True, False, False, False]
    for one in found:
        line = app.lines[0].line
        shafts = tuple(replace(s, phase=p) for s, p in zip(line.shafts, one.phases, strict=True))
        other = replace(app, lines=(replace(app.lines[0], line=replace(line, shafts=shafts)),))
        exact = approve_driveline(other).line_responses[0].kinematics.excitation
        for kind in ("torsional", "drive", "coast"):
            now, then = getattr(one.exact_excitation, kind), getattr(exact, kind)
            assert now.angle == pytest.approx(then.angle, rel=1e-9)
            assert now.acceleration == pytest.approx(then.acceleration, rel=1e-9)
    document = contract.json_document(approve_driveline(app))["phasings"]["main"]
    assert document[1]["phases_deg"] == pytest.approx([0, 90])
    # β² = β1² - β2² + β3² of its view angles in one plane, squares added as complex numbers.
    assert document[0]["states"][0]["ae7"]["torsional"]["equivalent_angle_deg"] == pytest.approx(
        3.587, abs=5e-4
    )


PROTRACTOR = """
title: Protractor alone
speed_rpm: 2500
torque_Nm: 8000
driveline:
  slopes: {side_deg: [3.0, 1.0, 4.5, 2.0], top_deg: [0, 1.5, -0.8, 0.6]}
  shafts: [LENGTHS]
limits: protractor
"""


def test_slopes_without_lengths_are_sufficient_for_angles(recwarn):
    """What turns does not ask how long the shafts are; what does is left open."""
    bare = approve_driveline(reader.loads(PROTRACTOR.replace("LENGTHS", "{}, {phase_deg: 30}")))
    hung = "{length_mm: 1200, centre_bearing: {from_rear_joint_mm: 100}}"
    full = f"{hung}, {{length_mm: 1500, phase_deg: 30}}"
    known = approve_driveline(reader.loads(PROTRACTOR.replace("LENGTHS", full)))
    assert bare.verdict == known.verdict
    assert [c.value for c in bare.checks] == pytest.approx(
        [c.value for c in known.checks], rel=1e-12
    )
    (one,), (other,) = (
        contract.json_document(bare)["states"],
        contract.json_document(known)["states"],
    )
    assert one["torsional"] == pytest.approx(other["torsional"], rel=1e-12)
    assert one["joints"][1]["couple_ahead_Nm"] == pytest.approx(
        other["joints"][1]["couple_ahead_Nm"], rel=1e-9
    )
    assert one["shafts"][0]["length_mm"] is None
    assert one["joint_forces"][0]["peak_N"] is None
    assert one["centre_bearings"][0]["peak_N"] is None
    said = bare_text(terminal.approval_lines(bare, helps=check_sensitivities(bare), states=True))
    assert not re.search(r"\bnan\b", said)  # "unanswered" holds those letters
    assert "Bounce" not in said
    whole = story.approval_report(
        bare, say=Translator("en"), issue=story.ReportDateAndSourceStamp()
    )
    assert "nan" not in "".join(f.svg for f in all_figures(whole))
    assert not [str(w.message) for w in recwarn]


def test_axle_travel_needs_shaft_lengths():
    text = PROTRACTOR.replace("LENGTHS", "{}, {}") + "states: [{name: up, travel_mm: 10}]\n"
    with pytest.raises(CardanError, match="length_mm of every shaft"):
        approve_driveline(reader.loads(text))


@pytest.mark.slow
def test_articulation_tilts_inter_axle_shaft():
    """Forward axle up, the other down: only the heights of two axles tell the shaft's slope."""
    text = (EXAMPLES / "tandem-6x4.yaml").read_text(encoding="utf-8")
    states = "  - {name: level, kind: gvw}\n  - {name: rocked, kind: gvw, articulation_mm: 50}\n"
    found = approve_driveline(reader.loads(text.replace("  - jounce\n", states)))
    main, between = found.line_responses
    level, rocked = (main.demand.states.index(name) for name in ("level", "rocked"))
    risen, moved = (r.layout.points[rocked] - r.layout.points[level] for r in found.line_responses)
    # The links pitch an axle on its way by some hundredths of a degree: 1 mm at its joints.
    heights = [risen[-1, 2], moved[0, 2], moved[-1, 2]]
    assert heights == pytest.approx([50 * mm, 50 * mm, -50 * mm], abs=1.5 * mm)
    start, end = between.layout.points[level][[0, -1]]
    slope = np.arctan2(start[2] - end[2] + 100 * mm, end[0] - start[0])
    assert between.layout.side[rocked, 1] == pytest.approx(slope, rel=0.02)
    assert main.layout.side[rocked, 1:-2] == pytest.approx(main.layout.side[level, 1:-2])
    # From an engine behind the bogie the torque comes to the hindmost axle first.
    turned = text.replace("  - jounce\n", states)
    turned = turned.replace("    points_mm:", "    runs: forward\n    points_mm:")
    found = approve_driveline(reader.loads(turned))
    risen, moved = (r.layout.points[rocked] - r.layout.points[level] for r in found.line_responses)
    heights = [risen[-1, 2], moved[0, 2], moved[-1, 2]]
    assert heights == pytest.approx([-50 * mm, -50 * mm, 50 * mm], abs=1.5 * mm)
    with pytest.raises(CardanError, match="no line runs from axle to axle"):
        reader.loads(ONE + "states: [{name: gvw, articulation_mm: 10}]\n")


@pytest.mark.slow
def test_report_draws_requested_state_or_worst_state():
    say = Translator("en")
    helps = check_sensitivities(TRUCK)

    def drawn(state: str | None) -> str:
        told = story.approval_report_from_results(
            TRUCK,
            helps=helps,
            fixes=(),
            say=say,
            issue=story.ReportDateAndSourceStamp(),
            state=state,
        )
        return next(all_figures(told)).title

    worst = min((c for c in TRUCK.checks if c.grade == "fail"), key=lambda c: c.margin)
    assert (
        drawn(None) == f"The line ({check_state_phrase(worst, say)}) from the left, true to scale"
    )
    assert drawn("gvw") == "The line (gvw) from the left, true to scale"
    with pytest.raises(CardanError, match="there is no state gw to draw; there are: full rebound"):
        drawn("gw")
    told = story.approval_report_from_results(
        TRUCK, helps=helps, fixes=(), say=say, issue=story.ReportDateAndSourceStamp()
    )
    first, *_, inputs, _ = told.chapters
    table = first.blocks[0]
    grades = ["exceeded", "beyond recommended", "met"]
    assert [row[0] for row in table.rows] == sorted((r[0] for r in table.rows), key=grades.index)
    assert len(table.rows) == 10
    assert table.rows[0][-1] == say.margin_text(worst.margin).replace("-", "−")
    assert inputs.title == "Inputs"


@pytest.mark.slow
def test_first_page_shows_clearance_of_worst_check():
    """The obstacle is nearest at an operating point, and the drawing is of that."""
    say = Translator("en")
    told = story.approval_report_from_results(
        TRUCK, helps=(), fixes=(), say=say, issue=story.ReportDateAndSourceStamp()
    )
    worst = min((c for c in TRUCK.checks if c.grade == "fail"), key=lambda c: c.margin)
    assert (worst.quantity, worst.point is not None) == ("clearance_on_rubber", True)
    room = say(
        "{room} mm free on rubber", room=say.compact_number(worst.value / mm, 4).replace("-", "−")
    )
    assert room in next(all_figures(told)).svg
