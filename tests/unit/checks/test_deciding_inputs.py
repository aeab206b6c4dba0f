"""Given values that the verdict rests on: how far each may be off before a criterion fails."""

import pytest
from repository import ROOT

from cardan.application.overrides import change
from cardan.application.reader import loads, read
from cardan.application.templates import template_text
from cardan.approval.approval import approve_driveline
from cardan.approval.deciding_inputs import DecidingInput
from cardan.documents.first_screen import screen_lines

SMALL = loads(template_text("small"))


def test_criterion_fails_at_the_section_modulus_that_its_value_asks_for():
    """Shear is torque by polar section modulus, (D^4 - d^4)/D: its cubic says where it fails."""
    found = approve_driveline(SMALL).deciding_inputs
    assert found is not None
    assert found.check.quantity == "tube_shear_utilisation"
    outer, wall = found.inputs
    assert (outer.key, wall.key) == tuple(
        f"driveline.shafts[1].tube.{key}" for key in ("outer_mm", "wall_mm")
    )
    assert (outer.given, wall.given) == (101.6, 3.2)

    def modulus(outer_mm: float, wall_mm: float) -> float:
        return (outer_mm**4 - (outer_mm - 2 * wall_mm) ** 4) / outer_mm

    needed = found.check.value * modulus(101.6, 3.2)
    assert modulus(outer.fails_at, 3.2) == pytest.approx(needed, rel=1e-4)
    assert modulus(101.6, wall.fails_at) == pytest.approx(needed, rel=1e-4)


@pytest.mark.parametrize("name", ["three-joint-chain", "composite-van", "van", "pick-up-4x4"])
def test_printed_value_is_exceeded_and_little_less_is_not(name):
    """Speed enters acceleration squared, life by a power: a slope alone said too much room."""
    app = read(ROOT / "examples" / f"{name}.yaml")
    found = approve_driveline(app).deciding_inputs
    assert found is not None
    check, one = found.check, found.inputs[0]
    for share, exceeded in ((0.98, False), (1.0, True)):
        changed = change(
            app, {one.key: one.given + share * (one.rounded_outward - one.given)}, warn=False
        )
        same = [
            c.grade == "fail"
            for c in approve_driveline(changed).checks
            if (c.limit, c.part, c.line) == (check.limit, check.part, check.line)
        ]
        assert same
        assert any(same) == exceeded, one


@pytest.mark.parametrize(
    ("given", "fails_at", "printed"),
    [(8000, 9664.3, 9670), (2800, 3410.2, 3411), (400, 404.36, 404.4), (5, 4.9926, 4.9925),
     (-5, -5.634, -5.64), (101.6, 91.32, 91.3)],
)  # fmt: skip
def test_printed_value_is_rounded_away_from_given_one(given, fails_at, printed):
    assert DecidingInput(key="x", given=given, fails_at=fails_at).rounded_outward == printed


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


def test_screen_names_the_values_rounded_outward():
    approval = approve_driveline(SMALL)
    text = " ".join(" ".join(screen_lines(approval)).split())
    assert "tube shear / yield, shaft 1 is exceeded from about" in text
    assert "shafts[1].tube.outer_mm 92.8 (101.6 given)" in text
    assert "shafts[1].tube.wall_mm 2.599 (3.2 given)" in text
