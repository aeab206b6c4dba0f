"""Sizing: the smallest part on offer that answers, held against asking every one of them."""

from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from repository import ROOT

from cardan.application import reader
from cardan.application.catalogue import Catalogue, find_shipped_part
from cardan.approval.approval import approve_driveline
from cardan.cli import cli
from cardan.core.units import mm
from cardan.core.verdict import CHECK_GRADES
from cardan.model.parts import JointSize, Tube
from cardan.physics.strength.bearing_life import rated_torque_from_catalogue
from cardan.topics.design.robustness import ToleranceModel, ToleranceYield
from cardan.topics.design.sizing import (
    Remedy,
    UnresolvedCheck,
    application_with_proposal,
    next_part_sizes,
    propose_parts,
    resolvable_checks,
    smallest_sufficient_proposals,
)
from cardan.topics.design.sizing_presentation import text_lines

TRUCK = (ROOT / "examples/medium-truck-4x2.yaml").read_text(encoding="utf-8")
WEAK = TRUCK.replace("- tube: 100x3    ", "- tube: 3.000x0.065in ", 1).replace('"2035"', '"2025"')
"""Its first tube twists beyond yield, and its joints are too small."""


LONG = """
title: Long shaft
speed_rpm: 3300
torque_Nm: 1500
driveline:
  slopes: {side_deg: [3.0, 1.0, 2.5, 1.5]}
  joints: "2025"
  shafts:
    - {length_mm: 1300, tube: 3.500x0.083in, centre_bearing: {from_rear_joint_mm: 140}}
    - {length_mm: 1950, tube: 3.500x0.083in}
limits: spicer
"""


@pytest.fixture(scope="module")
def weak():
    assert "3.000x0.065in" in WEAK
    assert '"2025"' in WEAK
    return reader.loads(WEAK)


def graded(application):
    """The worst grade of each quantity, state and part."""
    found = {}
    for c in approve_driveline(application).checks:
        key = c.line, c.quantity, c.state, str(c.part)
        found[key] = max(found.get(key, "pass"), c.grade, key=CHECK_GRADES.index)
    return found


def does(application, before, quantity, part):
    """Whether a line answers, by its own approval: all passes there, and nothing is worse."""
    after = graded(application)
    mine = {k: g for k, g in after.items() if k[1] == quantity and k[3] == part}
    return (
        set(mine.values()) == {"pass"}
        and before.keys() <= after.keys()
        and all(CHECK_GRADES.index(after[k]) <= CHECK_GRADES.index(g) for k, g in before.items())
    )


def problem(application, quantity, number):
    return next(
        p
        for p in resolvable_checks(application)
        if (p.quantity, p.part.number) == (quantity, number)
    )


def with_tube(application, number, tube):
    (one,) = application.lines
    shafts = list(one.line.shafts)
    shafts[number - 1] = replace(shafts[number - 1], tube=tube)
    return replace(application, lines=(replace(one, line=replace(one.line, shafts=tuple(shafts))),))


def with_joints(application, joint):
    (one,) = application.lines
    return replace(application, lines=(replace(one, line=replace(one.line, joints=(joint,) * 3)),))


@pytest.mark.slow
def test_proposed_tube_is_lightest_sufficient_tube(weak):
    """Every steel tube of the catalogue is approved by itself, and the lightest that does taken."""
    before = graded(weak)
    steel = [t for t in Catalogue().parts("tube") if t.material.youngs_modulus > 150e9]
    enough = [
        t for t in steel
        if does(with_tube(weak, 1, t), before, "tube_shear_utilisation", "shaft 1")
    ]  # fmt: skip
    assert 3 < len(enough) < len(steel) - 3
    (found,) = smallest_sufficient_proposals(weak, problem(weak, "tube_shear_utilisation", 1))
    assert isinstance(found, Remedy)
    lightest = min(enough, key=lambda t: t.mass_per_length)
    assert found.offer.part == lightest
    length = weak.lines[0].line.shafts[0].length
    lost = find_shipped_part("3.000x0.065in", "tube").mass_per_length
    assert found.offer.mass_change == pytest.approx((lightest.mass_per_length - lost) * length)


@pytest.mark.slow
def test_proposed_joint_is_smallest_sufficient_joint(weak):
    """Every cross with a peak torque is approved by itself, at all three joints."""
    before = graded(weak)
    rated = [j for j in Catalogue().parts("joint") if j.peak_torque]
    enough = [
        j for j in rated
        if does(with_joints(weak, j), before, "joint_fatigue_utilisation", "joint 1")
    ]  # fmt: skip
    assert 3 < len(enough) < len(rated) - 10
    (found,) = smallest_sufficient_proposals(weak, problem(weak, "joint_fatigue_utilisation", 1))
    assert isinstance(found, Remedy)
    smallest = min(enough, key=lambda j: (j.peak_torque, rated_torque_from_catalogue(j)))
    assert (found.offer.part, found.offer.part_numbers) == (smallest, (1, 2, 3))


@pytest.mark.slow
def test_joint_leaving_checks_not_evaluated_is_not_proposed(weak):
    """Smaller ones would carry the torque, but nobody rates their life or their fatigue."""
    one = problem(weak, "joint_torque_utilisation", 1)
    needed = one.value * find_shipped_part("2025", "joint").peak_torque
    (found,) = smallest_sufficient_proposals(weak, one)
    joint = found.offer.part
    assert joint.peak_torque >= needed
    assert joint.reversing_torque
    assert rated_torque_from_catalogue(joint)
    passed_over = [
        j for j in Catalogue().parts("joint")
        if j.peak_torque and needed <= j.peak_torque < joint.peak_torque
    ]  # fmt: skip
    assert passed_over
    assert all(not j.reversing_torque or not rated_torque_from_catalogue(j) for j in passed_over)


@pytest.mark.slow
def test_joint_without_rating_is_not_proposed_for_rating_check():
    """687.55, whose turning nobody rates, was offered for a 2055: the same joint by its series."""
    bent = reader.loads("""
title: Fast and bent
torque_Nm: 22000
speed_rpm: 3000
driveline:
  slopes: {side_deg: [0, 7, 0]}
  joints: 2055
  shafts: [{length_mm: 1000, tube: 120x6}]
limits: heavy-truck
""")
    one = problem(bent, "n_beta", 1)
    assert one.limit.maximum == find_shipped_part("2055", "joint").speed_angle_max
    (found,) = smallest_sufficient_proposals(bent, one, kinds=("joint",))
    assert found.offer is None or found.offer.part.speed_angle_max > one.value


@pytest.mark.slow
def test_tube_without_clearance_is_not_proposed():
    """A beam 62 mm below the line leaves room for tubes of 92 mm: the heavier 89x2.4 steps in."""
    beam = """
obstacles:
  - {name: beam, start_mm: [2200, -400, ROOM], end_mm: [2200, 400, ROOM], radius_mm: 10}
"""
    free = reader.loads(LONG)
    of = problem(free, "critical_speed_ratio", 2)
    (tube,) = smallest_sufficient_proposals(free, of, kinds=("tube",))
    z = float(free.lines[0].layout.points[..., 1, 2]) * 1e3
    drop = (2200 - 1300) * np.tan(np.radians(2.5))
    room = z - drop - tube.offer.part.outer / mm / 2 - 10 - 14
    tight = reader.loads(LONG + beam.replace("ROOM", f"{room:.1f}"))
    found = smallest_sufficient_proposals(tight, problem(tight, "critical_speed_ratio", 2))[0]
    assert isinstance(found, UnresolvedCheck) or found.offer.part != tube.offer.part
    if isinstance(found, UnresolvedCheck):
        assert found.newly_failing_check is not None
        assert found.newly_failing_check.quantity == "clearance"


@pytest.fixture(scope="module")
def sized(weak):
    return propose_parts(weak)


@pytest.mark.slow
@pytest.mark.long
def test_combined_proposals_give_the_reported_approval(weak, sized):
    application = weak
    for remedy in sized.remedies:
        application = application_with_proposal(application, remedy.offer)
    assert approve_driveline(application).checks == sized.approval.checks
    now = {(c.quantity, str(c.part)) for c in sized.approval.checks if c.grade != "pass"}
    assert not now & {("tube_shear_utilisation", "shaft 1"), ("joint_life", "joint 3")}
    for remedy in sized.remedies:
        for was, after in remedy.resolved_checks:
            (same,) = (
                c for c in sized.approval.checks
                if (c.quantity, c.when, c.part, c.limit)
                == (after.quantity, after.when, after.part, after.limit)
            )  # fmt: skip
            assert same.value == pytest.approx(after.value, rel=1e-12)
            assert same.grade == after.grade
            assert CHECK_GRADES.index(after.grade) < CHECK_GRADES.index(was.grade)


@pytest.mark.slow
def test_each_part_change_is_proposed_once(sized):
    kinds = [(r.offer.kind, r.offer.part_numbers) for r in sized.remedies]
    assert len(kinds) == len(set(kinds))
    (joint,) = (r.offer for r in sized.remedies if r.offer.kind == "joint")
    assert (joint.replaced_part_name, joint.part.name) == ("2025", "2040")
    assert sized.mass_change is None  # no maker publishes what the joint weighs


@pytest.mark.slow
def test_checks_without_sufficient_part_are_reported(sized):
    assert all(isinstance(h, UnresolvedCheck) for h in sized.unresolved)
    missed = {h.check.quantity for h in sized.unresolved}
    assert missed == {"centre_bearing_static", "centre_bearing_dynamic", "centre_bearing_peak"}
    # A joint's acceleration is of its angle: no part's, but of where the line lies.
    (worst,) = sized.failures_without_remedy
    (same,) = {c.quantity for c in sized.approval.checks if c.grade == "fail"} - missed
    assert worst.quantity == same == "angle_for_speed"
    assert worst.margin == min(c.margin for c in sized.approval.checks if c.quantity == same)
    assert "No part is sought for what fails all the same" in list(text_lines(sized))


@pytest.mark.slow
def test_critical_speed_failure_gets_larger_tube_or_split_shaft():
    """Both ways are told; the split keeps the line where it was and is the nearest that does.

    A further shaft is tried too, and none is told that would make something else fail.
    """
    application = reader.loads(
        LONG.replace("length_mm: 1950", "length_mm: 1950, tube_length_mm: 1800")
    )
    tube, split, further = smallest_sufficient_proposals(
        application, problem(application, "critical_speed_ratio", 2)
    )
    assert isinstance(further, UnresolvedCheck)
    assert isinstance(tube.offer.part, Tube)
    assert tube.offer.part.outer > 88.9 * mm
    assert split.offer.part_numbers == (1,)
    assert 0 < split.offer.rearward_shift < 400 * mm
    before = application.lines[0].line
    after = application_with_proposal(application, split.offer).lines[0].line
    assert after.lengths[1] < before.lengths[1]
    assert sum(after.lengths) == pytest.approx(sum(before.lengths), rel=1e-3)
    # Of a shorter shaft the tube is what is cut.
    was, now = before.shafts[1], after.shafts[1]
    assert now.tube_length == pytest.approx(was.tube_length + now.length - was.length)
    ((_, then),) = split.resolved_checks
    assert then.grade == "pass"
    less = application_with_proposal(
        application, replace(split.offer, rearward_shift=split.offer.rearward_shift - 25 * mm)
    )
    checks = [c for c in approve_driveline(less).checks if c.quantity == "critical_speed_ratio"]
    assert any(c.grade != "pass" for c in checks)


@pytest.mark.slow
def test_resolved_checks_did_not_pass_before_resizing():
    """The MTV's joints have no reversing torque; one taken for their life warned by its own."""
    application = reader.read(ROOT / "examples/mtv-6x6.yaml")
    bad = {(c.line, c.quantity) for c in approve_driveline(application).checks if c.grade != "pass"}
    remedies = propose_parts(application).remedies
    assert remedies
    assert {(was.line, was.quantity) for r in remedies for was, _ in r.resolved_checks} <= bad


@pytest.mark.slow
def test_yield_of_part_change_matches_individual_evaluation():
    application = reader.loads(LONG)
    (remedy,) = propose_parts(application).remedies
    assert {w.offer.kind for w in (remedy, *remedy.alternatives)} == {"tube", "split"}
    for way in (remedy, *remedy.alternatives):
        there = ToleranceModel.from_application(
            application_with_proposal(application, way.offer), "main"
        )
        each = there.survival((), np.empty(0), asked=2000).share
        assert way.tolerance_yield.share == pytest.approx(each, abs=4 * (0.25 / 2000) ** 0.5)
        assert way.tolerance_yield.share < 1  # or nothing is told here
    # Where the file's own numbers scatter nothing is known of a line it does not have.
    own = 'study: {tolerances: {"driveline.shafts[2].length_mm": {uniform: 30}}}\n'
    (remedy,) = propose_parts(reader.loads(LONG + own)).remedies
    assert remedy.tolerance_yield is None


@pytest.mark.slow
def test_remedy_with_highest_yield_is_listed_first(monkeypatch):
    """The usual one, another tube, where as many keep both."""
    application = reader.loads(LONG)
    now = application.lines[0].line.lengths

    def survival(self, *_, **__):
        split = self.application.lines[0].line.lengths != now
        return ToleranceYield(
            share=0.9 if split else 0.8, share_without_warnings=0.5, individually_evaluated=False
        )

    assert propose_parts(application).remedies[0].offer.kind == "tube"
    monkeypatch.setattr(ToleranceModel, "survival", survival)
    assert propose_parts(application).remedies[0].offer.kind == "split"


@pytest.mark.slow
def test_tubes_of_user_catalogue_are_proposed(tmp_path):
    """A tube of a file's own, lighter than any shipped that does, is the one proposed."""
    row = "name,outer_mm,wall_mm,material,source\nours,110,1.2,E355-SR,drawing 4\n"
    (tmp_path / "ours.csv").write_text(row, encoding="utf-8")
    file = tmp_path / "truck.yaml"
    file.write_text(LONG + "catalogues: ours.csv\n", encoding="utf-8")
    application = reader.read(file)
    (tube,) = smallest_sufficient_proposals(
        application, problem(application, "critical_speed_ratio", 2), kinds=("tube",)
    )
    assert tube.offer.part.name == "ours"
    assert str(tube.offer.part.source) == "drawing 4"


@pytest.mark.slow
def test_check_lists_next_part_size_without_geometric_correction(weak, tmp_path):
    file = tmp_path / "truck.yaml"
    file.write_text(WEAK, encoding="utf-8")
    printed = CliRunner(env={"COLUMNS": "200"}).invoke(cli, ["check", "--moves", str(file)]).output
    assert "shaft 1: tube 5.000x0.083in in place of 3.000x0.065in gives 0.6326" in printed
    assert "nothing that can be moved; `cardan size` tries other parts" in printed  # of a warning
    sizes = next_part_sizes(weak, resolvable_checks(weak))
    assert {k[1] for k in sizes} >= {"tube_shear_utilisation", "joint_life"}
    assert all(isinstance(r.offer.part, Tube | JointSize) for r in sizes.values())


@pytest.mark.slow
def test_size_command_fits_terminal_width_and_writes_json(tmp_path):
    file = tmp_path / "truck.yaml"
    file.write_text(LONG, encoding="utf-8")
    result = CliRunner().invoke(cli, ["size", str(file), "--json", str(tmp_path / "o.json")])
    assert result.exit_code == 1  # other limits have no answer
    assert max(map(len, result.output.splitlines())) <= 80
    assert (tmp_path / "o.json").exists()
    bad = CliRunner().invoke(cli, ["size", str(file), "--line", "rear"])
    assert bad.exit_code == 2
    assert "no line rear" in bad.output


def test_size_command_without_joints_refers_to_joint_catalogue(tmp_path):
    file = tmp_path / "truck.yaml"
    file.write_text(LONG.replace('  joints: "2025"\n', "").replace("3300", "1500"), "utf-8")
    result = CliRunner().invoke(cli, ["size", str(file)])
    assert result.exit_code == 1  # what is required has no answer
    assert "cardan catalogue joints --for" in result.output
    assert "a joint size with its peak torque" in " ".join(result.output.split())
