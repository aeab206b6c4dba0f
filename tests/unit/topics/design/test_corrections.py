"""Assessing and correcting an application: what a check promises, a correction keeps."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from one_shaft import ONE_SHAFT
from repository import EXAMPLES, ROOT

from cardan.application import reader
from cardan.application.limit_profiles import INLINE_LIMITS_NAME
from cardan.approval.applied_adjustments import (
    AppliedAdjustment,
    allowed_adjustments,
    response_with_adjustments,
)
from cardan.approval.approval import approve_application, approve_driveline, with_default_limits
from cardan.approval.driveline_study import DrivelineStudy, evaluate_limits, line_checks
from cardan.approval.margins import MARGIN_CAP, margins
from cardan.approval.registry import studies_of_application
from cardan.checks.line_response import compute_line_response
from cardan.checks.mount_loads import MountLoads
from cardan.checks.quantities.registry import QUANTITIES
from cardan.checks.rubber_at_stop import FORCE_KINDS
from cardan.core.errors import DesignError
from cardan.core.labels import OperatingPoint
from cardan.core.provenance import Source
from cardan.core.units import deg, mm
from cardan.core.verdict import CHECK_GRADES, Limit
from cardan.model.adjustments import ADJUSTMENTS
from cardan.model.application import (
    STATE_KIND_GROUPS,
    Application,
    DutyPoint,
    PermittedAdjustment,
    VehicleState,
)
from cardan.model.parts import JointSize
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references
from cardan.render import phrases as wording
from cardan.render.i18n import Translator
from cardan.topics.design import correction_search, corrections
from cardan.topics.design.correction import standing_of
from cardan.topics.design.correction_search import CorrectionSearch, SettingEvaluator
from cardan.topics.design.corrections import (
    MIN_MARGIN_ADVANTAGE_OVER_CHEAPER,
    Correction,
    find_corrections,
)
from cardan.topics.design.presentation import correction_lines
from cardan.topics.design.robustness import ToleranceYield
from cardan.topics.design.sensitivity import check_sensitivities

HOUSE = Source("House rules")


@pytest.fixture(scope="module")
def truck() -> Application:
    return reader.read(ROOT / "tests" / "truck.yaml")


def only(application: Application, *limits: Limit) -> Application:
    return replace(application, limits=limits, profile=INLINE_LIMITS_NAME)


TORSIONAL = Limit(
    quantity="torsional_acceleration", normal=200.0, maximum=500.0, source=HOUSE, points="own"
)
SMALLEST = Limit(quantity="joint_angle_min", normal=0.5 * deg, sense=">=", source=HOUSE)
SPLINE = Limit(quantity="spline_travel_margin", maximum=20 * mm, sense=">=", source=HOUSE)


def test_check_exists_for_each_limit_state_and_part(truck):
    bare = replace(only(truck, TORSIONAL, SMALLEST), lines=_without_sizes(truck))
    states, joints = len(truck.states), truck.lines[0].line.joint_count
    assert len(approve_driveline(bare).checks) == states + states * joints


def test_joint_limit_replaces_profile_limit(truck):
    """The first joint is rated for 100 rad/s; the others fall back on the profile's 1000."""
    profile = Limit(quantity="joint_speed", maximum=1000.0, source=HOUSE)
    (installed,) = truck.lines
    sizes = (JointSize(name="slow", speed_max=100.0), None, None)
    line = replace(installed.line, joints=sizes)
    rated = replace(only(truck, profile), lines=(replace(installed, line=line),))
    bounds = {(str(c.part), c.bound) for c in approve_driveline(rated).checks}
    assert bounds == {("joint 1", 100.0), ("joint 2", 1000.0), ("joint 3", 1000.0)}


@pytest.mark.parametrize(
    ("size", "answered", "missed", "needs"),
    [
        (JointSize(name="p", peak_torque=20e3), "torque", "fatigue", "its reversing torque"),
        (JointSize(name="f", reversing_torque=9e3), "fatigue", "torque", "its peak torque"),
    ],
)
def test_each_joint_rating_is_checked_against_its_own_limit(truck, size, answered, missed, needs):
    """A catalogue may print one of the two; what it does not print is asked for by its name."""
    asked = [f"joint_{what}_utilisation" for what in ("torque", "fatigue")]
    limits = [Limit(quantity=q, maximum=1.0, source=HOUSE) for q in asked]
    (installed,) = truck.lines
    line = replace(installed.line, joints=(size,) * installed.line.joint_count)
    found = approve_driveline(replace(only(truck, *limits), lines=(replace(installed, line=line),)))
    carries = [s for s in truck.states if s.kind != "full rebound"]  # there the axle hangs
    everywhere = len(carries) * line.joint_count
    assert [c.quantity for c in found.checks] == [f"joint_{answered}_utilisation"] * everywhere
    unanswered = found.coverage.unevaluated
    assert [u.quantity for u in unanswered] == [f"joint_{missed}_utilisation"] * everywhere
    assert {u.missing_inputs for u in unanswered} == {(f"a joint size with {needs}",)}


def test_joint_limit_applies_to_that_joint_only(truck):
    """Only the second joint is rated: the others have the profile's limit, or none."""
    (installed,) = truck.lines
    rated = JointSize(name="slow", speed_max=100.0)
    line = replace(installed.line, joints=(None, rated, None))
    bare = replace(only(truck), lines=(replace(installed, line=line),))
    found = {(str(c.part), c.bound, c.grade) for c in approve_driveline(bare).checks}
    assert {(part, bound) for part, bound, _ in found} == {("joint 2", 100.0)}
    assert {grade for *_, grade in found} == {"pass", "fail"}  # in first gear it is slow enough


def test_joint_sizing_uses_state_torque_above_engine_torque(truck):
    """Twice the engine's torque given in one state: twice the share of the peak torque there."""
    rated = JointSize(name="r", peak_torque=20e3)
    (installed,) = truck.lines
    line = replace(installed.line, joints=(rated,) * installed.line.joint_count)
    limit = Limit(quantity="joint_torque_utilisation", maximum=1.0, source=HOUSE, points="own")
    truck = replace(only(truck, limit), lines=(replace(installed, line=line),))
    _, first, *others = truck.states  # the axle that hangs carries nothing
    engine = line_state_demand(resolve_line_references(truck, truck.lines[0])).engine_torque[0]

    def used(torque: float | None) -> list[float]:
        found = approve_driveline(replace(truck, states=(replace(first, torque=torque), *others)))
        return [c.value for c in found.checks if c.state == first.name]

    assert used(2 * engine) == pytest.approx([2 * u for u in used(None)], rel=1e-9)
    assert used(engine / 2) == pytest.approx(used(None), rel=1e-9)


def test_joint_sizing_uses_engine_torque_per_gear_and_angle(truck):
    """950 · 9.2 · 0.95 N m in first gear, slip or not, wound up by what the tyres hold of it.

    Reverse had first gear's torque at its own angles, which nothing has, and was told with the
    torque that the tyres leave.
    """
    rated = JointSize(name="r", peak_torque=20e3)
    (installed,) = truck.lines
    line = replace(installed.line, joints=(rated,) * installed.line.joint_count)
    limit = Limit(quantity="joint_torque_utilisation", maximum=1.0, source=HOUSE)
    truck = replace(
        only(truck, limit), lines=(replace(installed, line=line),),
        gearbox=replace(truck.gearbox, reverse_ratio=6.6),
    )  # fmt: skip
    found = [c for c in approve_driveline(truck).checks if c.state == "empty"]
    share = truck.shock_factor * 950 * 9.2 * 0.95 / 20e3
    assert found[0].value == pytest.approx(share, rel=1e-12)  # joint 1 turns evenly
    (last,) = (c for c in found if c.part.number == 3)
    assert last.point is None or last.point.direction == "drive"
    assert last.value > share
    told = replace(last, point=OperatingPoint("1", "drive", 0.0, 4000.0))
    assert (
        wording.check_location(told, Translator("en")) == "empty, pulling away in gear 1, joint 3"
    )
    told = replace(last, point=OperatingPoint("R", "reverse", 0.0, -4000.0))
    assert "-4000" in wording.check_location(told, Translator("en"))


def test_missing_brake_torque_is_reported_for_braking_state(truck):
    """The engine is there; what winds the axle up under brakes is not."""
    bare = replace(truck, engine=replace(truck.engine, brake_torque=None))
    shear = Limit(quantity="tube_shear_utilisation", maximum=1.0, source=HOUSE)
    braked = replace(only(bare, shear), states=(VehicleState(name="held", kind="windup brake"),))
    assert {
        u.missing_inputs
        for u in approve_driveline(braked).coverage.unevaluated
        if u.quantity == shear.quantity
    } == {("coast_torque_Nm, or the brake torque of the engine",)}


def test_line_without_centre_bearing_has_no_rubber_stability_check():
    """One shaft has no rubber that anybody could give."""
    van = reader.read(EXAMPLES / "van.yaml")
    found = approve_driveline(only(van, Limit(quantity="swing_growth", maximum=0.0, source=HOUSE)))
    assert "swing_growth" not in {u.quantity for u in found.coverage.unevaluated}


VIBRATES = {q.key for q in QUANTITIES.values() if q.study == "vibration"}

LENGTHLESS = """
title: Under the truck with a protractor, and with the drawings of tubes and rubber
torque_Nm: 3000
coast_torque_Nm: 800
speed_rpm: 2500
duty: regional
driveline:
  slopes: {side_deg: [3, 1, 4, 2]}
  joints: 2040
  shafts:
    - tube: 100x3
      centre_bearing: {from_rear_joint_mm: 140, stiffness_N_mm: 200}
      balance_grade: G40
    - {tube: 100x3, spline: {plunge_mm: 50, draw_mm: 50, mean_radius_mm: 30}, balance_grade: G40}
obstacles:
  - {name: beam, start_mm: [500, -200, -300], end_mm: [500, 200, -300], radius_mm: 20}
limits: heavy-truck
include: [gravity, unbalance]
"""


def test_checks_needing_lengths_report_missing_lengths():
    """On rubber `check` was at fault; else a stroke that the file gives was asked for."""
    found = approve_driveline(reader.loads(LENGTHLESS))
    missed = [u for u in found.coverage.unevaluated if u.quantity not in VIBRATES]
    assert {u.missing_inputs for u in missed} == {("the length of each shaft",)}
    assert {"centre_bearing_static", "swing_growth", "critical_speed_ratio", "clearance",
            "spline_travel_margin"} <= {u.quantity for u in missed}  # fmt: skip
    assert studies_of_application()["vibration"].missing_inputs(found.application) == (
        "the length of each shaft",
    )


def test_named_duty_cycle_needs_speed_and_torque():
    """Of no speed a life was said to need a number that nobody could compute."""
    slow = reader.loads(LENGTHLESS.replace("speed_rpm: 2500\n", ""))
    missed = {u.quantity: u.missing_inputs for u in approve_driveline(slow).coverage.unevaluated}
    assert missed["joint_life"] == ("speed_rpm, or engine and gearbox",)
    weak = reader.loads(LENGTHLESS.replace("torque_Nm: 3000\n", "", 1))
    missed = {u.quantity: u.missing_inputs for u in approve_driveline(weak).coverage.unevaluated}
    assert missed["joint_life"] == ("torque_Nm, or engine, gearbox, axle and tyre",)


SPRUNG = Limit(quantity="suspension_frequency", normal=1.3, source=HOUSE)


def test_missing_suspension_spring_is_reported_for_first_line_only(truck):
    """A line alone without them is asked, or silence would pass; a second line is not again."""
    states = tuple(s for s in truck.states if s.kind in ("empty", "gvw"))
    (installed,) = truck.lines
    rigid = replace(
        only(truck, SPRUNG), suspension=None, states=tuple(replace(s, kind="") for s in states)
    )
    missed = approve_driveline(rigid).coverage.unevaluated
    assert [(u.quantity, u.line) for u in missed] == [("suspension_frequency", "main")] * 2
    other = replace(installed, line=replace(installed.line, name="other"))
    both = replace(rigid, lines=(installed, other))
    assert [u.line for u in approve_driveline(both).coverage.unevaluated] == ["main"] * 2


def test_verdict_is_that_of_worst_check(truck):
    easy = replace(TORSIONAL, normal=1e6, maximum=1e7)
    hard = replace(TORSIONAL, normal=1e-6, maximum=1e-5)
    warn = replace(TORSIONAL, normal=1e-6, maximum=1e7)
    for limit, verdict in ((easy, "pass"), (warn, "warn"), (hard, "fail")):
        bare = replace(only(truck, limit), lines=_without_sizes(truck))
        assert approve_driveline(bare).verdict == verdict


def _without_sizes(application):
    return tuple(replace(i, line=replace(i.line, joints=())) for i in application.lines)


def test_limit_not_evaluated_is_reported(truck):
    life = Limit(quantity="joint_life", maximum=1.0, sense=">=", source=HOUSE)
    bare = replace(only(truck, life, TORSIONAL), lines=_without_sizes(truck))
    assert approve_driveline(bare).unevaluated_quantities() == ("joint_life",)


def test_limit_above_angle_is_checked_above_that_angle_only(truck):
    band = Limit(quantity="half_critical_band", band=(0.01, 0.99), source=HOUSE)
    shallow = replace(band, above_angle=0.0)
    steep = replace(band, above_angle=89 * deg)
    assert any(c.quantity == band.quantity for c in approve_driveline(only(truck, shallow)).checks)
    assert not any(
        c.quantity == band.quantity for c in approve_driveline(only(truck, steep)).checks
    )


def test_limit_is_checked_in_its_states_only(truck):
    """A kind of state, not a name: what is parked on a kerb counts as given, and rides."""
    kinds = {s.name: s.limit_state_kind for s in truck.states}
    for group in (
        {"gvw"},
        {"windup", "jounce"},
        STATE_KIND_GROUPS["riding"],
        STATE_KIND_GROUPS["stops"],
    ):
        limit = replace(TORSIONAL, states=frozenset(group))
        found = approve_driveline(only(truck, limit))
        states = {c.state for c in found.checks if c.quantity == limit.quantity}
        assert states == {name for name, kind in kinds.items() if kind in group}
        assert states
        assert found.coverage.unevaluated == ()


def test_limit_on_signed_quantity_uses_absolute_value(truck):
    """View angles bend down or up, to the right or left; 1 deg is as much either way."""
    limit = Limit(quantity="side_angle", maximum=1 * deg, source=HOUSE, points="own")
    found = approve_driveline(only(truck, limit))
    (response,) = found.line_responses
    assert (response.kinematics.side_angles < -1 * deg).any()
    assert (response.kinematics.side_angles > 1 * deg).any()
    mine = [c for c in found.checks if c.quantity == "side_angle"]
    assert [c.value for c in mine] == pytest.approx(np.abs(response.kinematics.side_angles).ravel())
    assert {c.grade for c in mine} == {"pass", "fail"}


def test_limit_above_angle_uses_largest_joint_angle(truck):
    """A line with one steep joint is asked, with its other joints straight or not."""
    response = compute_line_response(
        truck, line_state_demand(resolve_line_references(truck, truck.lines[0]))
    )
    largest, smallest = response.joint_angles.max(-1), response.joint_angles.min(-1)
    between = float((largest[0] + smallest[0]) / 2)
    band = Limit(
        quantity="half_critical_band", band=(0.01, 0.99), above_angle=between, source=HOUSE
    )
    asked = {
        c.state for c in approve_driveline(only(truck, band)).checks if c.quantity == band.quantity
    }
    states = response.demand.states
    assert asked == {s for s, a in zip(states, largest, strict=True) if a > between}
    assert states[0] in asked


def test_study_limits_come_from_file_before_default_profile(truck):
    """Where the file limits nothing of it, the default profile does, beside the file's own."""
    own = only(truck, TORSIONAL)
    held = with_default_limits(own, "vibration")
    assert held.limits[0] == TORSIONAL
    more = held.limits[1:]
    assert {m.quantity for m in more} == {
        "torsional_resonance", "torsional_growth", "lateral_growth",
        "torsional_amplitude_utilisation", "torsional_peak_utilisation", "torsional_reversal",
        "torsional_pinion_acceleration", "launch_peak_utilisation", "launch_reversal",
        "launch_bearing_force",
    }  # fmt: skip
    assert held.profile == f"{own.profile}; vibration: heavy-truck"
    own = only(truck, Limit(quantity="torsional_growth", maximum=1.0, source=HOUSE))
    assert with_default_limits(own, "vibration") is own


@pytest.mark.slow
def test_batch_of_corrections_equals_single_corrections(truck):
    """A batch of corrections gives what each gives alone: one code path for any number."""
    response = compute_line_response(
        truck, line_state_demand(resolve_line_references(truck, truck.lines[0]))
    )
    movable = allowed_adjustments(response)
    amounts = np.random.default_rng(0).uniform(-0.01, 0.01, (5, len(movable)))
    batch = margins(response_with_adjustments(response, movable, amounts), to="normal")
    single = [
        margins(response_with_adjustments(response, movable, a[None]), to="normal")[0]
        for a in amounts
    ]
    assert batch == pytest.approx(np.array(single), rel=1e-9, abs=1e-9)


def test_zero_correction_keeps_margins(truck, monkeypatch):
    """Of forces that are lower bounds: with their stop they are solved of one design alone."""
    monkeypatch.setattr(MountLoads, "stop_response_on", lambda *_: None)
    monkeypatch.setattr(MountLoads, "stuck_forces", None)
    response = compute_line_response(
        truck, line_state_demand(resolve_line_references(truck, truck.lines[0]))
    )
    movable = allowed_adjustments(response)
    still = response_with_adjustments(response, movable, np.zeros((1, len(movable))))
    assert margins(still, to="normal")[0] == pytest.approx(
        margins(response, to="normal"), rel=1e-9, abs=1e-9
    )


@pytest.mark.slow
def test_correction_turns_failing_verdict_into_pass(truck):
    """Full rebound shakes too much as installed; a bearing or a shim mends it."""
    tight = replace(TORSIONAL, normal=180.0, maximum=250.0)
    failing = replace(only(truck, tight, SPLINE), lines=_without_sizes(truck))
    assert approve_driveline(failing).verdict == "fail"
    (best,) = find_corrections(failing, count=1)
    assert best.verdict == "pass"
    assert best.margin > 0 > best.margin_before
    for move in best.adjustments:
        assert move.adjustable.low <= move.amount <= move.adjustable.high


@pytest.mark.slow
@pytest.mark.parametrize("hold", [("phase",), ("phase", "shim")])
def test_exhaustive_search_finds_cheapest_passing_correction(truck, hold):
    """Bearing by 5 mm, axle by half degrees: 13 settings of either, each asked by itself here."""
    tight = replace(TORSIONAL, normal=300.0)
    warning = replace(only(truck, tight, SPLINE), lines=_without_sizes(truck))
    response = compute_line_response(
        warning, line_state_demand(resolve_line_references(warning, warning.lines[0]))
    )
    movable = tuple(
        a for a in allowed_adjustments(response) if a.adjustment_key in ("bearing_height", "shim")
    )
    assert [a.part for a in movable] == [1, 1]
    shims = [0] if "shim" in hold else range(-6, 7)
    every = [(h * mm, s / 2 * deg) for h in range(-30, 31, 5) for s in shims]
    least = {
        amounts: min(
            c.margin
            for c in line_checks(response_with_adjustments(response, movable, np.array(amounts)))
        )
        for amounts in every
    }
    share = {(h, s): abs(h) / (30 * mm) + abs(s) / (3 * deg) for h, s in every}
    found = find_corrections(warning, hold=hold)
    passing = [amounts for amounts in every if least[amounts] >= 0]
    assert 0 < len(passing) < len(every)
    assert found[0].verdict == "pass"
    assert found[0].cost == pytest.approx(min(share[amounts] for amounts in passing))
    assert max(p.margin for p in found) == pytest.approx(
        max(least.values()), abs=MIN_MARGIN_ADVANTAGE_OVER_CHEAPER
    )


@pytest.mark.slow
@pytest.mark.parametrize("asked", ["all settings", "some", "what fails too"])
def test_proposal_for_warning_does_not_fail(asked, monkeypatch):
    """A truck that warns was told three moves, each of which made it fail: -54 % to -31 %."""
    if asked == "some":
        monkeypatch.setattr(correction_search, "MAX_EXHAUSTIVE_SEARCH_SETTINGS", 0)
    if asked == "what fails too":  # as where yokes are turned, and no setting stands
        monkeypatch.setattr(
            CorrectionSearch,
            "least_margins",
            lambda self, amounts, *, to: self.asked(amounts)[to].min(-1),
        )
    app = reader.read(EXAMPLES / "vecto-4x2.yaml")
    # What its bearing carries fails, whatever is moved; with the next two no setting is better
    # in all that warns.
    out = {f"centre_bearing_{kind}" for kind in FORCE_KINDS}
    out |= {"resonance_distance", "spline_compression_utilisation"}
    app = replace(app, limits=tuple(m for m in app.limits if m.quantity not in out))
    found = find_corrections(app)
    assert all(p.verdict == p.installed_approval.verdict == "warn" for p in found)
    if asked == "what fails too":
        return
    assert found
    assert max(p.margin for p in found) > found[0].margin_before + 0.03  # -17.6 to -6.9 %


def test_forbidden_band_is_not_treated_as_maximum(truck):
    """To the maximum a band counted as one: a line that met it was searched as if it failed."""
    installed, *_ = truck.lines
    band = Limit(quantity="torsional_acceleration", band=(1.0, 1e6), source=HOUSE)
    asked = only(truck, band)
    response = compute_line_response(
        asked, line_state_demand(resolve_line_references(asked, installed))
    )
    assert min(c.margin for c in line_checks(response)) < 0
    assert (margins(response, to="maximum") >= 0).all()
    assert margins(response, to="normal").min() < 0


def test_costlier_proposal_has_larger_margin(truck):
    """Among equal verdicts a dearer proposal leaves more margin."""
    found = find_corrections(replace(only(truck, SMALLEST, TORSIONAL), lines=_without_sizes(truck)))
    assert found
    for verdict in {p.verdict for p in found}:
        alike = [p for p in found if p.verdict == verdict]
        assert [p.cost for p in alike] == sorted(p.cost for p in alike)
        assert [p.margin for p in alike] == sorted(p.margin for p in alike)


def test_better_verdict_ranks_before_lower_cost():
    shim = PermittedAdjustment(adjustment_key="shim", part=1, low=-3 * deg, high=3 * deg)
    proposals = [
        Correction(
            line="main",
            adjustments=(AppliedAdjustment(adjustable=shim, amount=amount * deg),),
            margin_before=-1.0,
            margin=0.1,
            approval=SimpleNamespace(verdict=verdict, checks=()),
            installed_approval=SimpleNamespace(),
            changeable=frozenset(),
        )
        for amount, verdict in ((1.0, "fail"), (3.0, "pass"), (2.0, "pass"), (0.5, "warn"))
    ]
    ranked = sorted(proposals, key=lambda p: p.sort_key)
    assert [(p.verdict, p.cost > 0.5) for p in ranked] == [
        ("pass", True),
        ("pass", True),
        ("warn", False),
        ("fail", False),
    ]
    assert ranked[0].cost < ranked[1].cost


def graded(*grades: str) -> list[SimpleNamespace]:
    """Checks of one criterion each; "at least" is a lower bound that warns."""
    return [
        SimpleNamespace(
            grade={"at least": "warn"}.get(g, g),
            grade_as_exceeded={"at least": "fail"}.get(g, g),
            is_lower_bound=g == "at least",
            quantity=str(k),
            line="x",
            limit=None,
        )
        for k, g in enumerate(grades)
    ]


def test_fewer_criteria_exceeded_then_fewer_warnings_rank_before_lower_cost():
    """A proposal with five exceeded stood before one with two, for its cost and its trucks."""
    shim = PermittedAdjustment(adjustment_key="shim", part=1, low=-3 * deg, high=3 * deg)
    order = [
        ("fail", "pass", "pass"), ("fail", "warn", "pass"), ("at least", "fail"),
        ("fail", "fail", "pass"), ("fail", "fail", "warn"),
    ]  # fmt: skip

    def proposal(grades, cost):
        return Correction(
            line="x",
            adjustments=(AppliedAdjustment(adjustable=shim, amount=cost * 3 * deg),),
            margin_before=-1.0,
            margin=-0.5,
            approval=SimpleNamespace(verdict="fail", checks=graded(*grades)),
            installed_approval=SimpleNamespace(),
            changeable=frozenset(),
            tolerance_yield=ToleranceYield(
                share=1 - cost, share_without_warnings=0.0, individually_evaluated=False
            ),
        )

    given = [proposal(grades, 0.9 - 0.1 * k) for k, grades in reversed([*enumerate(order)])]
    ranked = sorted(given, key=lambda p: p.sort_key)
    assert [tuple(c.grade_as_exceeded for c in p.checks) for p in ranked] == [
        tuple(c.grade_as_exceeded for c in graded(*grades)) for grades in order
    ]
    # Of equal counts what more trucks keep, then what costs less.
    alike = [proposal(order[0], cost) for cost in (0.5, 0.52, 0.2)]
    assert sorted(alike, key=lambda p: p.sort_key) == [alike[2], alike[0], alike[1]]


def test_trial_is_beaten_only_by_one_that_stands_as_well_costs_and_leaves_no_less():
    def trial(standing, cost, margin):
        return SimpleNamespace(
            standing=standing, cost=cost, margin=margin, rank=(standing, cost, -margin)
        )

    few, cheap, wide = trial((3, 2), 2.2, -3.5), trial((3, 5), 0.3, -3.6), trial((3, 5), 1.0, -2.9)
    installed = trial((3, 5), 0.0, -3.7)
    beaten = [trial((3, 5), 0.7, -3.6), trial((3, 6), 2.2, -3.495), trial((3, 6), 0.1, -3.7)]
    assert corrections._unbeaten(installed, [*beaten, wide, cheap, few]) == [few, cheap, wide]


def test_settings_are_evaluated_once_in_batches(monkeypatch):
    """What was evaluated is known by itself, and what is expected of it is what it comes to."""
    application = reader.loads(ONE_SHAFT)
    response = approve_driveline(application).line_responses[0]
    movable = allowed_adjustments(response)
    evaluator, batches = SettingEvaluator((response,), movable), []
    evaluate = correction_search.adjusted_lines

    def counted(lines, movable, amounts):
        batches.append(len(amounts))
        return evaluate(lines, movable, amounts)

    monkeypatch.setattr(correction_search, "adjusted_lines", counted)
    amounts = np.array([[0.0], [1.0], [2.0]]) * deg
    first = evaluator.evaluate(amounts)
    mixed = evaluator.evaluate(np.array([[2.0], [-1.0], [2.0], [0.0]]) * deg)
    assert batches == [3, 1]
    assert (mixed.margins["normal"][[0, 2, 3]] == first.margins["normal"][[2, 2, 0]]).all()
    for k, amount in enumerate(amounts):
        alone = list(line_checks(response_with_adjustments(response, movable, amount)))
        standing = standing_of("fail", alone)
        assert (first.exceeded[k], first.warned[k]) == standing[2:]
    assert first.exceeded[0] > 0


def test_trials_that_others_surely_beat_are_not_evaluated_in_full(monkeypatch):
    """Seven trials of a wedge, of which no two that are compared tell anything new."""
    evaluated = []
    evaluate = corrections.adjusted_lines

    def counted(lines, movable, amounts):
        evaluated.append(tuple(amounts))
        return evaluate(lines, movable, amounts)

    monkeypatch.setattr(corrections, "adjusted_lines", counted)
    found = find_corrections(reader.loads(ONE_SHAFT), count=1)
    assert found[0].verdict == "pass"
    assert len(evaluated) == len(set(evaluated)) <= 3


def test_search_by_slopes_ends_where_it_gets_no_further():
    """Which of two limits is worst changes from step to step: 684 steps of a line on rubber."""
    steps = []

    def needed(x):
        steps.append(float(x[0]))
        k = len(steps)  # a slope that points another way each time
        return np.array([-1.0 - 1e-6 * k]), np.array([[(-1.0) ** k * 40.0]])

    best = CorrectionSearch._solve(
        SimpleNamespace(free=(0,)),
        np.array([0.3]),
        cost=lambda x: (float(x[0] ** 2), 2 * x),
        needed=needed,
        merit=lambda _, left: -float(left.min()),
    )
    assert best == pytest.approx([0.3])
    assert len(steps) <= 2 + correction_search.MAX_STALLED_STEPS


@pytest.mark.parametrize(
    ("verdict", "margin", "grades", "stands"),
    [
        ("fail", -2.02, ["fail", "fail", "warn"], True), ("fail", -2.03, ["fail", "warn"], True),
        ("fail", -2.03, ["fail", "fail", "warn"], False), ("fail", -2.03, ["fail", "fail"], True),
        ("fail", -2.03, ["fail", "fail", "warn", "warn"], False), ("warn", -0.4, ["warn"], True),
        ("fail", -1.5, ["fail", "fail", "fail"], False),
        ("fail", -2.03, ["fail", "at least", "warn"], False),
    ],
)  # fmt: skip
def test_proposal_without_improvement_is_dropped(verdict, margin, grades, stands):
    """-203 % after -202 % was listed, for margin that it won where all passes.

    And a shim that had 4 criteria exceeded after 3, for margin of the worst. What is known as
    "at least" some force is not less exceeded.
    """

    def approval(verdict, margin, grades):
        return SimpleNamespace(verdict=verdict, smallest_margin=margin, checks=graded(*grades))

    was = approval("fail", -2.02, ["fail", "fail", "warn"])
    now = approval(verdict, margin, grades)
    one = Correction(
        line="x",
        adjustments=(),
        margin_before=-2,
        margin=-1,
        approval=now,
        installed_approval=was,
        changeable=frozenset(),
    )
    assert one.is_acceptable == stands


@pytest.mark.slow
@pytest.mark.parametrize("limits", [(SMALLEST, TORSIONAL), (SMALLEST,)])
def test_interim_proposals_precede_search_and_only_improve(truck, limits):
    """And what the search ends with is what it ends with where nobody looks on."""
    told: list[Correction | str] = []
    app = replace(only(truck, *limits), lines=_without_sizes(truck))
    found = find_corrections(app, tell=lambda *_: told.append("search"), show=told.append)
    assert [(p.adjustments, p.sort_key) for p in found] == [
        (p.adjustments, p.sort_key) for p in find_corrections(app)
    ]
    assert isinstance(told[0], Correction)
    shown = [p for p in told if isinstance(p, Correction)]
    gains = [(p.standing, -p.margin) for p in shown]
    assert gains == sorted(set(gains), reverse=True)
    assert all(p.margin > p.margin_before for p in shown)
    for move in told[0].adjustments:  # as a workshop can set it
        a = move.adjustable
        assert a.low <= move.amount <= a.high
        assert not a.step or move.amount / a.step == pytest.approx(round(move.amount / a.step))


def test_held_adjustment_is_not_moved(truck):
    response = compute_line_response(
        truck, line_state_demand(resolve_line_references(truck, truck.lines[0]))
    )
    whats = {a.adjustment_key for a in allowed_adjustments(response)}
    assert "shim" in whats
    for proposal in find_corrections(only(truck, SMALLEST), hold=("shim",)):
        assert all(m.adjustable.adjustment_key != "shim" for m in proposal.adjustments)


def test_hold_of_unknown_adjustment_is_rejected(truck):
    with pytest.raises(DesignError, match=r"nothing that may move is called nonsense.*shim"):
        find_corrections(truck, hold=("nonsense",))


def test_joint_life_excludes_transient_states(truck):
    """Nobody drives for hours on the bump stop; gvw is where the joints wear."""
    duty = (DutyPoint(share=1.0, torque=1000.0, speed=100.0),)
    sized = JointSize(name="any", bearing_torque=3000.0)
    (installed,) = truck.lines
    joints = (sized,) * installed.line.joint_count
    line = replace(installed.line, joints=joints)
    worn = replace(truck, duty=duty, lines=(replace(installed, line=line),))
    response = compute_line_response(
        worn, line_state_demand(resolve_line_references(worn, worn.lines[0]))
    )
    names = response.demand.states
    lasting = {
        n
        for n, life in zip(names, response.strength.needle_bearing_life[:, 0], strict=True)
        if not np.isnan(life)
    }
    assert lasting == {"empty", "gvw", "overload", "parked on a kerb"}
    # Nor does anybody ask for one there: nothing required goes without an answer.
    limit = Limit(quantity="joint_life", maximum=1.0, sense=">=", required=True, source=HOUSE)
    found = approve_driveline(only(worn, limit))
    assert {c.state for c in found.checks} == lasting
    assert found.coverage.unevaluated == ()
    assert found.verdict == "pass"


@pytest.mark.slow
def test_proposal_equals_check_of_corrected_truck(truck):
    """Move the bearing in the application itself: the same checks, to rounding."""
    up = PermittedAdjustment(adjustment_key="bearing_height", part=1, low=0.0, high=20 * mm)
    application = replace(only(truck, TORSIONAL, SMALLEST, SPLINE), adjustables=(up,))
    proposal = next(p for p in find_corrections(application) if p.adjustments)
    rise = proposal.adjustments[0].amount
    found = line_state_demand(resolve_line_references(application, application.lines[0]))
    shift = np.zeros((1, found.layout.points.shape[-2] - 2, 3))
    shift[..., 2] = rise
    by_hand = compute_line_response(
        application, found, lay=lambda of: of.corrected_layout(bearing_shift=shift)
    )
    expected = margins(by_hand, to="normal").min()
    assert min(c.limit.margin(c.value, to="normal") for c in proposal.checks) == pytest.approx(
        expected, rel=1e-9
    )


def test_single_correction_effect_equals_result_of_moved_line(truck):
    """Where it helps in the worst of all states, for another may be the worst then."""
    application = only(truck, TORSIONAL)
    worst = next(s for s in check_sensitivities(approve_driveline(application)) if s.effects)
    response = compute_line_response(
        application, line_state_demand(resolve_line_references(application, truck.lines[0]))
    )
    state = response.demand.states.index(worst.check.state)
    helped = 0
    for effect in worst.effects:
        moved = response_with_adjustments(
            response, (effect.adjustable,), np.array([[effect.low], [effect.high]])
        )
        (question,) = evaluate_limits(moved, quantities={TORSIONAL.quantity})
        for (_, value), each in zip(
            effect.amounts_and_values, question.values[..., 0], strict=True
        ):
            helps = worst.closes_gap(each[state])
            assert value == pytest.approx(np.nanmax(each) if helps else each[state], rel=1e-9)
            helped += helps
    assert helped


@pytest.mark.slow
def test_single_corrections_stay_within_adjustment_range(truck):
    """A step of 10 mm was told where 7 down and 12 up are all there is, and down where up is."""
    ranges = ((-7.0, 12.0), (0.0, 5.0), (-2.0, 2.0))
    for low, high in ranges:
        way = PermittedAdjustment(
            adjustment_key="bearing_height", part=1, low=low * mm, high=high * mm, line="main"
        )
        found = check_sensitivities(approve_driveline(replace(truck, adjustables=(way,))))
        of = [e for s in found for e in s.effects if e.adjustable == way]
        assert of
        for e in of:
            assert low * mm <= e.low <= e.high <= high * mm


@pytest.mark.slow
def test_single_correction_lists_checks_that_it_makes_fail(monkeypatch):
    """Each move by itself, every check of it: the refuse collector's bearing up fails a joint.

    On linear rubber, as of a move at a stop the value is estimated.

    Half a move stands in place of a whole that spoils something where the half does not: 11 of
    42 spoilt something when the whole was all that was asked, 4 do now.
    """
    monkeypatch.setattr(MountLoads, "stop_response", None)
    monkeypatch.setattr(MountLoads, "stuck_forces", None)
    collector = reader.read(EXAMPLES / "refuse-collector-6x2.yaml")
    found = approve_driveline(collector)
    (response,) = found.line_responses

    def worst(of):
        """Return the worst grade and margin of each limit's part."""
        grades = {}
        for c in of:
            grades.setdefault((c.quantity, c.part), []).append(
                (CHECK_GRADES.index(c.grade), -c.margin)
            )
        return {key: max(of) for key, of in grades.items()}

    def answers(moved, s):
        """Return what a move spoils, and the value of a check, of the line moved by itself."""
        line = response_with_adjustments(response, (moved.adjustable,), np.array([moved.amount]))
        after = list(line_checks(line))
        new = {k: v for k, v in worst(after).items() if v[0] > before.get(k, (0, 0))[0]}
        where = s.check.quantity, s.check.part, s.check.limit
        same = [c for c in after if (c.quantity, c.part, c.limit) == where]
        return new, min(
            same, key=lambda c: by_value(s, c.value), default=None
        )  # in the worst state

    def by_value(s, value):
        """Margin of a value: how far rubber is beyond its stop no move is weighed by."""
        to = "maximum" if s.check.grade == "fail" else "normal"
        return float(s.check.limit.margin(value, to=to))

    before, seen, halves = worst(found.checks), {True: 0, False: 0}, 0
    for s in check_sensitivities(found):
        grades = [
            CHECK_GRADES.index(e.side_effect.grade) if e.side_effect else 0
            for e in s.helpful_effects
        ]
        assert grades == sorted(grades), s.check.quantity
        for e in s.helpful_effects:
            moved, value = s.best_adjustment(e)
            spoilt, after = answers(moved, s)
            assert value == pytest.approx(after.value, rel=1e-9)
            seen[bool(spoilt)] += 1
            step = ADJUSTMENTS[e.adjustable.adjustment_key].probe_step
            halves += abs(moved.amount) == pytest.approx(step / 2)
            half = replace(moved, amount=moved.amount / 2)
            if spoilt and abs(moved.amount) == step and e.adjustable.adjustment_key != "phase":
                still, less = answers(half, s)
                own = by_value(s, s.check.value)
                worth = less and by_value(s, less.value) - own >= -0.05 * own
                back = [
                    v for a, v in e.amounts_and_values if a != moved.amount
                ]  # the other way may do more
                best = max(float(s.check.limit.margin(v, to="normal")) for v in back)
                mine = less and float(s.check.limit.margin(less.value, to="normal"))
                assert still or not worth or best > mine
            if e.side_effect is None:
                assert not spoilt, (s.check.quantity, moved)
            else:
                key = max(spoilt, key=spoilt.__getitem__)
                assert (e.side_effect.quantity, e.side_effect.part) == key, (
                    s.check.quantity,
                    moved,
                )
                assert -e.side_effect.margin == pytest.approx(spoilt[key][1], rel=1e-9)
    assert min(seen.values()) > 3
    assert halves > 5


@pytest.mark.slow
def test_failing_line_is_corrected_before_warning_line():
    """The tandem's inter-axle line has the larger angles, its main line the larger acceleration."""
    tandem = reader.read(EXAMPLES / "tandem-6x4.yaml")
    by_far = Limit(quantity="torsional_acceleration", normal=1.0, source=HOUSE)
    by_a_hair = Limit(quantity="joint_angle", maximum=10.9 * deg, source=HOUSE)
    for limits, line in (((by_far,), "main"), ((by_far, by_a_hair), "inter-axle")):
        found = find_corrections(only(tandem, *limits), count=1)
        assert {p.line for p in found} == {line}


def test_order_of_states_does_not_change_checks(truck):
    backwards = replace(truck, states=truck.states[::-1])
    assert {(c.quantity, c.state, c.part, c.value) for c in approve_driveline(truck).checks} == {
        (c.quantity, c.state, c.part, c.value) for c in approve_driveline(backwards).checks
    }


def test_spring_rate_contradicting_its_table_is_noted(truck):
    """The dissertation's spring: 120.6 and 192.2 N/mm stated, 120.4 and 194.5 in its table."""
    spring = replace(
        truck.suspension.spring,
        load=(0.0, 11562.0, 12749.0, 26233.0, 43345.0),
        deflection=tuple(x * mm for x in (0, 96, 105, 185, 273)),
        stated_rates=(120.6 / mm, 192.2 / mm),
    )
    suspension = replace(truck.suspension, spring=spring)
    note, *others = approve_driveline(replace(truck, suspension=suspension)).notes
    assert not any("spring" in other for other in others)
    assert "192.2" in note
    assert "194.5" in note
    # By hand, the second rate from 96 mm on: 120.6 · 96 + 192.2 · 89 = 28 683 N for 26 233.
    assert "+9.3 % off the load of its own table at 185 mm" in note
    rates = tuple(np.diff(spring.load) / np.diff(spring.deflection))
    true = replace(spring, stated_rates=rates)
    notes = approve_driveline(replace(truck, suspension=replace(suspension, spring=true))).notes
    assert not any("spring" in note for note in notes)


def test_flange_bearing_forces_satisfy_static_equilibrium(truck):
    """Moments about bearing A and the sum of forces, by hand, for the peak of a turn."""
    (installed,) = truck.lines
    line = replace(installed.line, gearbox_bearing_spacing=0.2, gearbox_bearing_overhang=0.1)
    found = compute_line_response(
        replace(truck, lines=(replace(installed, line=line),)),
        line_state_demand(resolve_line_references(truck, replace(installed, line=line))),
    )
    force = found.rigid_loads.joint_loads.gearbox_force.values(64)
    moment = found.rigid_loads.joint_loads.gearbox_moment.values(64)
    out = found.layout.directions[:, None, 0, :]
    across = force - (force * out).sum(-1, keepdims=True) * out
    # About A, 0.3 m behind the joint: near bearing 0.2 m ahead of A.
    near = np.cross(moment + np.cross(0.3 * out, force), out) / 0.2
    far = across - near
    assert found.rigid_loads.static_end_bearing_forces["B"] == pytest.approx(
        np.linalg.norm(near, axis=-1).max(-1), rel=1e-2
    )
    assert found.rigid_loads.static_end_bearing_forces["A"] == pytest.approx(
        np.linalg.norm(far, axis=-1).max(-1), rel=1e-2
    )
    assert np.isnan(found.rigid_loads.static_end_bearing_forces["E"]).all()


def test_limit_without_maximum_has_ample_margin_to_maximum(truck):
    def left(**bounds: float) -> float:
        limit = Limit(quantity="joint_angle", source=HOUSE, **bounds)
        one = only(truck, limit)
        response = compute_line_response(
            one, line_state_demand(resolve_line_references(one, one.lines[0]))
        )
        return float(margins(response, to="maximum").min())

    assert left(normal=1e-3) == MARGIN_CAP
    assert left(maximum=1e-3) < 0


def test_recording_limit_without_recording_is_not_evaluated():
    text = (EXAMPLES / "van.yaml").read_text(encoding="utf-8")
    row = "{quantity: fatigue_life, unit: h, maximum: 100, required: true, source: asked}"
    lines = [f"limits: [{row}]" if t.startswith("limits:") else t for t in text.splitlines()]
    found = approve_driveline(reader.loads("\n".join(lines) + "\n"))
    assert found.verdict == "incomplete"
    (open_,) = found.coverage.unevaluated
    assert open_.missing_inputs == ("a campaign of recordings, by --recording",)


def test_limit_not_evaluated_is_reported_for_first_line():
    """Of a vehicle with several lines the first speaks for what none was asked about."""
    life = Limit(quantity="fatigue_life", maximum=1.0, sense=">=", source=HOUSE)
    tandem = only(reader.read(EXAMPLES / "tandem-6x4.yaml"), TORSIONAL, life)
    first, *others = (i.line.name for i in tandem.lines)
    assert others
    (open_,) = [u for u in approve_driveline(tandem).coverage.unevaluated if u.limit == life]
    assert (open_.line, open_.when.name) == (first, tandem.states[0].name)


def test_correction_cost_is_sum_of_its_moves(truck):
    found = [
        p for p in find_corrections(only(truck, SMALLEST, TORSIONAL)) if len(p.adjustments) > 1
    ]
    assert found
    for proposal in found:
        assert proposal.cost == pytest.approx(sum(m.cost for m in proposal.adjustments), rel=1e-12)
        assert proposal.cost > max(m.cost for m in proposal.adjustments)


def test_failed_study_prevents_approval(truck):
    """Asked for, and without an answer: what else passes is not approved with it."""

    def refused(*_):
        msg = "elements of 0.5 mm would make 151 million unknowns"
        raise DesignError(msg)

    study = SimpleNamespace(
        name="bracket", concerns=lambda _: True, missing_inputs=lambda _: (), run=refused
    )
    lenient = only(truck, replace(TORSIONAL, normal=1e6, maximum=1e6))
    alone = approve_application(lenient, (DrivelineStudy(),))
    both = approve_application(lenient, (DrivelineStudy(), study))
    assert (alone.verdict, both.verdict) == ("pass", "incomplete")
    assert "151 million" in both.study_results[1].failure_reasons[0]


@pytest.mark.parametrize("joint", ["1410", "1310"])
def test_correction_heads_with_the_smallest_margin_that_moving_changes(joint):
    """A joint beyond its elastic limit stays so however the axle is turned."""
    text = (EXAMPLES / "three-joint-chain.yaml").read_text("utf-8")
    small = text.replace("\n  shafts:", f'\n  joints: "{joint}"\n  shafts:')
    (best, *_) = found = find_corrections(
        reader.loads(small), hold=("bearing_height", "bearing_side", "phase")
    )
    overloaded = min(c.margin for c in best.installed_approval.checks)
    assert {c.quantity for c in best.unchangeable_checks} == {"joint_torque_utilisation"}
    assert best.installed_approval.smallest_margin == overloaded < -0.5
    head, fixed, *_ = correction_lines(found)
    assert head.endswith("smallest margin that moving changes -12 % to what is recommended.")
    assert fixed.startswith("No move corrects: Joint torque / elastic limit, joint ")
    assert best.worst_changeable_check(best.approval).margin > 0
