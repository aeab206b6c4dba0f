"""Given values that the verdict rests on: how far each may be off before a criterion fails."""

import pytest
from repository import ROOT

from cardan.application.overrides import change
from cardan.application.reader import loads, read
from cardan.application.templates import template_text
from cardan.approval.approval import approve_driveline
from cardan.documents.first_screen import screen_lines

SMALL = loads(template_text("small"))


def test_criterion_fails_just_beyond_the_value_that_is_named():
    """Shear is proportional to torque: linear prediction is exact; of a diameter it is near."""
    found = approve_driveline(SMALL).deciding_inputs
    assert found is not None
    assert found.check.quantity == "tube_shear_utilisation"
    at = {one.key: one for one in found.inputs}
    torque = at["torque_Nm"]
    assert torque.given == 8000
    assert torque.fails_at == pytest.approx(8000 / found.check.value, rel=1e-6)
    for key, beyond in (("torque_Nm", 1.001), ("driveline.shafts[1].tube.outer_mm", 0.98)):
        one = at[key]
        fails = approve_driveline(change(SMALL, {key: one.fails_at * beyond}))
        passes = approve_driveline(change(SMALL, {key: one.given * (2 - beyond)}))
        assert (fails.verdict, passes.verdict) == ("fail", "warn"), key


def test_file_that_fails_names_no_value():
    assert approve_driveline(read(ROOT / "examples" / "vecto-4x2.yaml")).deciding_inputs is None


def test_values_of_catalogues_and_ratings_that_are_limits_are_left_out():
    """n_beta decides: it has no variants in a joint's own rating, and needs none."""
    found = approve_driveline(loads(template_text("truck"))).deciding_inputs
    assert found is not None
    assert found.check.quantity == "n_beta"
    assert all("joints" not in one.key for one in found.inputs)
    assert all("5.000" not in one.key for one in found.inputs)


def test_values_beside_a_geometry_that_states_repeat_are_named():
    """Settings of a machine give every point again: one point moved alone is refused."""
    text = template_text("industrial").replace("torque_Nm: 4200 ", "torque_Nm: 9000 ")
    found = approve_driveline(loads(text)).deciding_inputs
    assert found is not None
    assert found.check.quantity == "joint_torque_utilisation"
    assert [one.key for one in found.inputs] == ["shock_factor", "torque_Nm"]
    # The torque enters by its product with the shock factor: both may rise by the same share.
    shares = [one.fails_at / one.given for one in found.inputs]
    assert shares == pytest.approx([1 / found.check.value] * 2, rel=1e-6)


def test_screen_names_the_values_in_three_digits():
    approval = approve_driveline(SMALL)
    text = " ".join(" ".join(screen_lines(approval)).split())
    assert "tube shear / yield, shaft 1 is exceeded from about" in text
    assert "shafts[1].tube.outer_mm 91.3 (101.6 given), torque_Nm 9670 (8000 given)" in text
