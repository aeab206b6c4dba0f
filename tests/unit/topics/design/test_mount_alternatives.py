"""Other mounts are asked as the file would say them: stiffer, lossier, nearer their joints."""

import numpy as np
import pytest
from repository import EXAMPLES

from cardan.application import reader
from cardan.application.layout_writer import bearing_changes
from cardan.application.overrides import change
from cardan.application.yaml_edit import YamlEditor
from cardan.approval.applied_adjustments import (
    allowed_adjustments,
    alternative_mount_adjustments,
    corrected_application,
    response_with_adjustments,
)
from cardan.approval.approval import approve_driveline
from cardan.checks.line_response import LineResponse, compute_line_response
from cardan.checks.mount_loads import MountLoads
from cardan.checks.quantities.registry import LINE_QUANTITIES
from cardan.core.errors import CardanError
from cardan.core.units import mm
from cardan.model.application import PermittedAdjustment
from cardan.physics.vehicle.state_demand import line_state_demand, resolve_line_references
from cardan.render.i18n import ENGLISH
from cardan.topics.design.corrections import find_corrections
from cardan.topics.design.phrases import helpful_adjustment_phrases
from cardan.topics.design.sensitivity import _deciding, check_sensitivities

TRUCK = EXAMPLES / "medium-truck-4x2.yaml"
BEARING = "driveline.shafts[1].centre_bearing"


ONE = "lateral_stiffness_N_mm: 100"
WITH_LOSS = TRUCK.read_text().replace(ONE, f"{ONE}, loss_factor: 0.1")
"""As it is assumed where the file has none."""


@pytest.fixture(scope="module")
def truck() -> LineResponse:
    application = reader.read(TRUCK)
    return compute_line_response(
        application, line_state_demand(resolve_line_references(application, application.lines[0]))
    )


def peaks(r: LineResponse) -> np.ndarray:
    return r.mount_loads.bearing_force("peak")


def of(what: str) -> PermittedAdjustment:
    return PermittedAdjustment(adjustment_key=what, part=1, low=-0.5, high=1.0)


CHANGES = {
    "bearing_stiffness": (0.3, lambda b: {
        f"{BEARING}.vertical_stiffness_N_mm": 1.3 * b.stiffness[0] / 1e3,
        f"{BEARING}.lateral_stiffness_N_mm": 1.3 * b.stiffness[1] / 1e3,
    }),
    "bearing_loss": (0.5, lambda _: {f"{BEARING}.loss_factor": 0.15}),  # of the assumed 0.1
    "bearing_place": (-25 * mm, lambda b: {
        f"{BEARING}.from_rear_joint_mm": b.from_rear_joint / mm - 25,
    }),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("what", CHANGES)
def test_mount_adjustment_matches_file_with_changed_mount(truck, what):
    amount, by = CHANGES[what]
    application = reader.loads(WITH_LOSS, folder=TRUCK.parent)
    application = change(application, by(truck.line.shafts[0].centre_bearing))
    by_file = compute_line_response(
        application, line_state_demand(resolve_line_references(application, application.lines[0]))
    )
    found = response_with_adjustments(truck, (of(what),), np.array([[0.0], [amount]]))
    assert peaks(found)[0] == pytest.approx(peaks(truck), rel=1e-12)
    assert peaks(found)[1] == pytest.approx(peaks(by_file), rel=1e-9)
    assert not np.allclose(peaks(by_file), peaks(truck), rtol=1e-3)
    alone = response_with_adjustments(truck, (of(what),), np.array([amount]))
    assert peaks(alone) == pytest.approx(peaks(by_file), rel=1e-9)
    after = corrected_application(truck, (of(what),), np.array([amount])).lines[0].line.shafts[0]
    mount, same = after.centre_bearing, application.lines[0].line.shafts[0].centre_bearing
    assert mount.stiffness == pytest.approx(same.stiffness)
    assert mount.from_rear_joint == pytest.approx(same.from_rear_joint)
    if what == "bearing_loss":
        assert mount.loss_factor == pytest.approx(same.loss_factor)


@pytest.mark.slow
def test_single_corrections_include_other_mounts(truck, monkeypatch):
    monkeypatch.setattr(MountLoads, "stop_response", None)  # of a move at a stop it is estimated
    monkeypatch.setattr(MountLoads, "stuck_forces", None)
    found = check_sensitivities(approve_driveline(truck.application))
    (force,) = (s for s in found if s.check.quantity == "centre_bearing_dynamic")
    told = {e.adjustable.adjustment_key: e for e in force.effects}
    assert {"bearing_loss", "bearing_place", "bearing_height"} <= set(told)
    effect = told["bearing_loss"]
    (state,) = np.flatnonzero([n == force.check.when.name for n in truck.demand.states])
    after = response_with_adjustments(truck, (effect.adjustable,), np.array([effect.high]))
    assert effect.forth == pytest.approx(
        after.mount_loads.bearing_force("dynamic")[state, 0], rel=1e-9
    )
    assert effect.forth < 0.8 * force.check.value
    assert helpful_adjustment_phrases(force, ENGLISH)[0].startswith(
        "rubber of all bearings with 50 % more loss"
    )


@pytest.mark.slow
def test_range_ends_are_evaluated_if_no_single_step_helps(truck):
    """A duty speed stands between two modes: other rubber has to bring one of them past it."""
    found = check_sensitivities(approve_driveline(truck.application))
    (off,) = (s for s in found if s.check.quantity == "resonance_distance")
    (effect,) = off.helpful_effects
    assert (effect.adjustable.adjustment_key, effect.low, effect.high) == (
        "bearing_stiffness",
        -0.5,
        1.0,
    )
    by = {amount: change(truck.application, {
        f"{BEARING}.{key}_stiffness_N_mm": stiffness * (1 + amount)
        for key, stiffness in (("vertical", 150.0), ("lateral", 100.0))
    }) for amount in (effect.low, -0.3, 0.3, effect.high)}  # fmt: skip
    given = {
        amount: next(c.value for c in approve_driveline(a).checks
                     if c.quantity == "resonance_distance" and c.when == off.check.when)
        for amount, a in by.items()
    }  # fmt: skip
    # What helps is told as it is in the worst of all states.
    least = min(
        c.value for c in approve_driveline(by[-0.5]).checks if c.quantity == "resonance_distance"
    )
    assert (effect.back, effect.forth) == pytest.approx((least, given[1.0]), rel=1e-9)
    assert max(given[-0.3], given[0.3]) < off.check.value < off.check.limit.normal < given[-0.5]
    assert helpful_adjustment_phrases(off, ENGLISH) == [
        "rubber of all bearings softer by 50 % gives 0.2297, but then exceeded: Thrust / critical "
        "compression in gvw: 0.8226 against 0.7000"
    ]


@pytest.mark.slow
def test_mounts_are_not_proposed_for_checks_independent_of_mounts(truck):
    others = [s for s in check_sensitivities(approve_driveline(truck.application))
              if not LINE_QUANTITIES[s.check.quantity].depends_on_mounts]  # fmt: skip
    mounts = {a.adjustment_key for a in alternative_mount_adjustments(truck)}
    assert others
    assert not {e.adjustable.adjustment_key for s in others for e in s.effects} & mounts


def adjusted(name: str, allowed: str) -> str:
    text = (TRUCK.parent / f"{name}.yaml").read_text()
    return text[: text.index("\nadjust:")] + f"\nadjust: {{{allowed}}}\n"


@pytest.mark.slow
def test_mounts_are_adjusted_only_if_file_allows(truck):
    assert not {a.adjustment_key for a in allowed_adjustments(truck)} & {
        "bearing_loss",
        "bearing_stiffness",
    }
    text = adjusted("medium-truck-4x2", "bearing_loss_percent: [0, 100]")
    application = reader.loads(text, folder=TRUCK.parent)
    (moved,) = {
        m.adjustable.adjustment_key for p in find_corrections(application) for m in p.adjustments
    }
    assert moved == "bearing_loss"


def test_mount_adjustment_without_rubber_mount_is_rejected():
    van = adjusted("van", "bearing_loss_percent: [0, 100]")
    with pytest.raises(CardanError, match="has nothing of this kind to move"):
        reader.loads(van, folder=TRUCK.parent)


def test_workbench_writes_mount_change_into_file_text(truck):
    manuscript = YamlEditor(TRUCK.read_text())
    new = corrected_application(truck, (of("bearing_stiffness"),), np.array([0.5])).lines[0].line
    changes = bearing_changes(truck.demand.installed, new, manuscript)
    assert changes == {
        f"{BEARING}.vertical_stiffness_N_mm": 225.0,
        f"{BEARING}.lateral_stiffness_N_mm": 150.0,
    }
    lossy = corrected_application(truck, (of("bearing_loss"),), np.array([0.5])).lines[0].line
    assert bearing_changes(truck.demand.installed, lossy, manuscript) == {
        f"{BEARING}.loss_factor": 0.15
    }
    near = corrected_application(truck, (of("bearing_place"),), np.array([-30 * mm])).lines[0].line
    changes = bearing_changes(truck.demand.installed, near, manuscript)
    assert changes == {f"{BEARING}.from_rear_joint_mm": 100.0}


def test_axial_mount_stiffness_varies_in_variant_arrays():
    text = TRUCK.read_text().replace(ONE, f"{ONE}, axial_stiffness_N_mm: 60")
    address = f"{BEARING}.axial_stiffness_N_mm"
    several = change(reader.loads(text, folder=TRUCK.parent), {address: np.array([30.0, 60.0])})
    both = peaks(
        compute_line_response(
            several, line_state_demand(resolve_line_references(several, several.lines[0]))
        )
    )
    for k, along in enumerate((30.0, 60.0)):
        one = change(reader.loads(text, folder=TRUCK.parent), {address: along})
        alone = compute_line_response(
            one, line_state_demand(resolve_line_references(one, one.lines[0]))
        )
        assert both[k] == pytest.approx(peaks(alone), rel=1e-9)
    softer = response_with_adjustments(alone, (of("bearing_stiffness"),), np.array([[0.0], [-0.5]]))
    assert softer.mounts.mounted_line.stiffness[1, 0, 0, 2] == pytest.approx(30e3)


def test_resonance_distance_is_smallest_gap_of_duty_speed_to_mode(truck):
    """Recomputed from the modes' own list: 300 rpm of the duty lies beside one of 275 or so."""
    for s, state in enumerate(truck.demand.states):
        value = truck.mount_loads.resonance_distance[s]
        if not truck.inputs.sustained_states[s]:
            assert np.isnan(value), state
            continue
        each = []
        for p in truck.inputs.duty_points:
            held = truck.mounts.mounted_line
            stiffness = held._held[0][s] + p.torque * held.torsion[s]
            modes = np.sqrt(np.linalg.eigvals(np.linalg.solve(held.mass[s], stiffness)).real)
            slow = np.sort(modes)[:2]
            each += [abs(k * p.speed / w - 1) for k in (1, 2) for w in slow]
        assert value == pytest.approx(min(each), rel=1e-9)
    (check,) = {
        c.limit.quantity: c
        for c in approve_driveline(truck.application).checks
        if c.quantity == "resonance_distance"
    }.values()
    assert check.grade == "warn"


def test_deciding_load_states_include_top_speed_and_lasting_states(truck):
    """Shafts are balanced for the top speed of all states: a slow one alone would not know it."""
    speed = truck.demand.speed
    slow, fast = int(speed.argmin()), float(speed.max())
    assert speed[slow] < fast
    within = _deciding(truck, {slow})
    assert slow in within
    assert speed[within].max() == fast
    lasting = np.flatnonzero(truck.inputs.sustained_states)
    torque = np.abs(truck.demand.torque)
    assert torque[[s for s in within if s in lasting]].max() == torque[lasting].max()


def test_bearing_position_is_not_varied_beyond_its_shaft():
    """A shaft of 851 mm has no 25 mm behind 830: what would help is told without it."""
    far = TRUCK.read_text().replace("from_rear_joint_mm: 130", "from_rear_joint_mm: 830")
    assert far != TRUCK.read_text()
    found = approve_driveline(reader.loads(far, folder=TRUCK.parent))
    (place,) = [
        a
        for a in alternative_mount_adjustments(found.line_responses[0])
        if a.adjustment_key == "bearing_place"
    ]
    assert place.high == 0
    assert place.low == -50 * mm
    assert check_sensitivities(found)
