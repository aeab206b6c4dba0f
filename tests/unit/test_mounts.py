"""Other mounts are asked as the file would say them: stiffer, lossier, nearer their joints."""

from pathlib import Path

import numpy as np
import pytest

from cardan import files
from cardan.base.errors import CardanError
from cardan.base.units import mm
from cardan.demand.states import demand, resolve
from cardan.files.change import change
from cardan.files.manuscript import Manuscript
from cardan.files.placing import mounted
from cardan.model.application import Adjustable
from cardan.quantity.quantities import ANSWERED
from cardan.quantity.response import Response, respond
from cardan.report.language import EN
from cardan.report.wording import moves_that_help
from cardan.study.approval import assess
from cardan.study.fix import fix
from cardan.study.moves import adjustables, corrected, fitted, tried
from cardan.study.sensitivity import _deciding, sensitivities

TRUCK = Path(__file__).parents[2] / "examples" / "medium-truck-4x2.yaml"
BEARING = "driveline.shafts[1].centre_bearing"


ONE = "lateral_stiffness_N_mm: 100"
WITH_LOSS = TRUCK.read_text().replace(ONE, f"{ONE}, loss_factor: 0.1")
"""As it is assumed where the file has none."""


@pytest.fixture(scope="module")
def truck() -> Response:
    application = files.read(TRUCK)
    return respond(application, demand(resolve(application, application.lines[0])))


def peaks(r: Response) -> np.ndarray:
    return r.bearing_force("peak")


def of(what: str) -> Adjustable:
    return Adjustable(what=what, part=1, low=-0.5, high=1.0)


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


@pytest.mark.parametrize("what", CHANGES)
def test_other_mounts_are_those_of_a_file_that_says_them(truck, what):
    amount, by = CHANGES[what]
    application = files.loads(WITH_LOSS, folder=TRUCK.parent)
    application = change(application, by(truck.line.shafts[0].centre_bearing))
    by_file = respond(application, demand(resolve(application, application.lines[0])))
    found = tried(truck, (of(what),), np.array([[0.0], [amount]]))
    assert peaks(found)[0] == pytest.approx(peaks(truck), rel=1e-12)
    assert peaks(found)[1] == pytest.approx(peaks(by_file), rel=1e-9)
    assert not np.allclose(peaks(by_file), peaks(truck), rtol=1e-3)
    alone = tried(truck, (of(what),), np.array([amount]))
    assert peaks(alone) == pytest.approx(peaks(by_file), rel=1e-9)
    after = corrected(truck, (of(what),), np.array([amount])).lines[0].line.shafts[0]
    mount, same = after.centre_bearing, application.lines[0].line.shafts[0].centre_bearing
    assert mount.stiffness == pytest.approx(same.stiffness)
    assert mount.from_rear_joint == pytest.approx(same.from_rear_joint)
    if what == "bearing_loss":
        assert mount.loss_factor == pytest.approx(same.loss_factor)


def test_what_other_mounts_do_is_told_beside_what_a_workshop_can_move(truck):
    found = sensitivities(assess(truck.application))
    (force,) = (s for s in found if s.check.quantity == "centre_bearing_dynamic")
    told = {e.adjustable.what: e for e in force.effects}
    assert {"bearing_loss", "bearing_place", "bearing_height"} <= set(told)
    effect = told["bearing_loss"]
    (state,) = np.flatnonzero([n == force.check.when.name for n in truck.demand.states])
    after = tried(truck, (effect.adjustable,), np.array([effect.high]))
    assert effect.forth == pytest.approx(after.bearing_force("dynamic")[state, 0], rel=1e-9)
    assert effect.forth < 0.8 * force.check.value
    assert moves_that_help(force, EN)[0].startswith("rubber of all bearings with 50 % more loss")


def test_where_no_step_helps_the_ends_of_the_ranges_are_asked(truck):
    """A duty speed stands between two modes: other rubber has to bring one of them past it."""
    found = sensitivities(assess(truck.application))
    (off,) = (s for s in found if s.check.quantity == "resonance_distance")
    (effect,) = off.helpful
    assert (effect.adjustable.what, effect.low, effect.high) == ("bearing_stiffness", -0.5, 1.0)
    by = {amount: change(truck.application, {
        f"{BEARING}.{key}_stiffness_N_mm": stiffness * (1 + amount)
        for key, stiffness in (("vertical", 150.0), ("lateral", 100.0))
    }) for amount in (effect.low, -0.3, 0.3, effect.high)}  # fmt: skip
    given = {
        amount: next(c.value for c in assess(a).checks
                     if c.quantity == "resonance_distance" and c.when == off.check.when)
        for amount, a in by.items()
    }  # fmt: skip
    # What helps is told as it is in the worst of all states.
    least = min(c.value for c in assess(by[-0.5]).checks if c.quantity == "resonance_distance")
    assert (effect.back, effect.forth) == pytest.approx((least, given[1.0]), rel=1e-9)
    assert max(given[-0.3], given[0.3]) < off.check.value < off.check.limit.normal < given[-0.5]
    assert moves_that_help(off, EN) == ["rubber of all bearings softer by 50 % gives 0.2297"]


def test_nobody_is_told_of_mounts_where_no_bearing_is_short(truck):
    others = [s for s in sensitivities(assess(truck.application))
              if not ANSWERED[s.check.quantity].on_rubber]  # fmt: skip
    mounts = {a.what for a in fitted(truck)}
    assert others
    assert not {e.adjustable.what for s in others for e in s.effects} & mounts


def adjusted(name: str, allowed: str) -> str:
    text = (TRUCK.parent / f"{name}.yaml").read_text()
    return text[: text.index("\nadjust:")] + f"\nadjust: {{{allowed}}}\n"


def test_mounts_move_only_where_the_file_says_so(truck):
    assert not {a.what for a in adjustables(truck)} & {"bearing_loss", "bearing_stiffness"}
    text = adjusted("medium-truck-4x2", "bearing_loss_percent: [0, 100]")
    application = files.loads(text, folder=TRUCK.parent)
    (moved,) = {m.adjustable.what for p in fix(application) for m in p.moves}
    assert moved == "bearing_loss"


def test_a_line_without_rubber_has_none_to_change():
    van = adjusted("van", "bearing_loss_percent: [0, 100]")
    with pytest.raises(CardanError, match="has nothing of this kind to move"):
        files.loads(van, folder=TRUCK.parent)


def test_the_workbench_writes_other_mounts_into_the_text(truck):
    manuscript = Manuscript(TRUCK.read_text())
    new = corrected(truck, (of("bearing_stiffness"),), np.array([0.5])).lines[0].line
    changes = mounted(truck.demand.installed, new, manuscript)
    assert changes == {
        f"{BEARING}.vertical_stiffness_N_mm": 225.0,
        f"{BEARING}.lateral_stiffness_N_mm": 150.0,
    }
    lossy = corrected(truck, (of("bearing_loss"),), np.array([0.5])).lines[0].line
    assert mounted(truck.demand.installed, lossy, manuscript) == {f"{BEARING}.loss_factor": 0.15}
    near = corrected(truck, (of("bearing_place"),), np.array([-30 * mm])).lines[0].line
    changes = mounted(truck.demand.installed, near, manuscript)
    assert changes == {f"{BEARING}.from_rear_joint_mm": 100.0}


def test_rubber_along_the_shaft_varies_like_the_rest():
    text = TRUCK.read_text().replace(ONE, f"{ONE}, axial_stiffness_N_mm: 60")
    address = f"{BEARING}.axial_stiffness_N_mm"
    several = change(files.loads(text, folder=TRUCK.parent), {address: np.array([30.0, 60.0])})
    both = peaks(respond(several, demand(resolve(several, several.lines[0]))))
    for k, along in enumerate((30.0, 60.0)):
        one = change(files.loads(text, folder=TRUCK.parent), {address: along})
        alone = respond(one, demand(resolve(one, one.lines[0])))
        assert both[k] == pytest.approx(peaks(alone), rel=1e-9)
    softer = tried(alone, (of("bearing_stiffness"),), np.array([[0.0], [-0.5]]))
    assert softer.held.stiffness[1, 0, 0, 2] == pytest.approx(30e3)


def test_duty_speeds_are_told_by_how_far_they_stay_off_a_mode(truck):
    """Recomputed from the modes' own list: 300 rpm of the duty lies beside one of 275 or so."""
    for s, state in enumerate(truck.demand.states):
        value = truck.resonance_distance[s]
        if not truck.lasting[s]:
            assert np.isnan(value), state
            continue
        each = []
        for p in truck.duty:
            modes = np.sqrt(np.linalg.eigvals(
                np.linalg.solve(truck.held.mass[s], truck.held._held[0][s]
                                + p.torque * truck.held.torsion[s])).real)  # fmt: skip
            slow = np.sort(modes)[:2]
            each += [abs(k * p.speed / w - 1) for k in (1, 2) for w in slow]
        assert value == pytest.approx(min(each), rel=1e-9)
    (check,) = {
        c.limit.quantity: c
        for c in assess(truck.application).checks
        if c.quantity == "resonance_distance"
    }.values()
    assert check.grade == "warn"


def test_things_are_moved_in_the_states_that_others_are_measured_by(truck):
    """Shafts are balanced for the top speed of all states: a slow one alone would not know it."""
    speed = truck.demand.speed
    slow, fast = int(speed.argmin()), float(speed.max())
    assert speed[slow] < fast
    within = _deciding(truck, {slow})
    assert slow in within
    assert speed[within].max() == fast
    lasting = np.flatnonzero(truck.lasting)
    torque = np.abs(truck.demand.torque)
    assert torque[[s for s in within if s in lasting]].max() == torque[lasting].max()


def test_a_bearing_is_not_tried_beyond_its_shaft():
    """A shaft of 851 mm has no 25 mm behind 830: what would help is told without it."""
    far = TRUCK.read_text().replace("from_rear_joint_mm: 130", "from_rear_joint_mm: 830")
    assert far != TRUCK.read_text()
    found = assess(files.loads(far, folder=TRUCK.parent))
    (place,) = [a for a in fitted(found.responses[0]) if a.what == "bearing_place"]
    assert place.high == 0
    assert place.low == -50 * mm
    assert sensitivities(found)
