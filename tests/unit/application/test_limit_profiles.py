"""Limit profiles: shipped ones and the user's own."""

# ruff: noqa: E501  messages stand here as they are printed

import pytest

from cardan.application.limit_profiles import DEFAULT_PROFILE_NAME, load_profile, profile_names
from cardan.checks.quantities.registry import QUANTITIES
from cardan.core.errors import InvalidFileError
from cardan.core.units import deg, mm, rpm


def own(tmp_path, text):
    file = tmp_path / "ours.yaml"
    file.write_text(f"profile: ours\nlimits:\n{text}", encoding="utf-8")
    return str(file)


def refused(tmp_path, text):
    name = own(tmp_path, text)
    with pytest.raises(InvalidFileError) as error:
        load_profile(name)
    return str(error.value).replace(name, "f.yaml").splitlines()


@pytest.mark.parametrize("name", profile_names())
def test_every_shipped_profile_is_read_under_its_own_name(name):
    found, held = load_profile(name)
    assert found == name
    assert held
    assert all(limit.quantity in QUANTITIES and limit.source.title for limit in held)


def test_the_default_profile_is_shipped():
    assert DEFAULT_PROFILE_NAME in profile_names()


@pytest.mark.parametrize(
    ("limit", "normal", "maximum"),
    [
        ("quantity: joint_angle, normal: 6, maximum: 11.5", 6 * deg, 11.5 * deg),
        ("quantity: joint_angle, unit: rad, normal: 0.1, maximum: 0.2", 0.1, 0.2),
        ("quantity: torsional_acceleration, unit: rad/s2, normal: 300, maximum: 500", 300, 500),
        ("quantity: torsional_acceleration, unit: rad/s², maximum: 500", None, 500),
        ("quantity: clearance, unit: in, normal: 2, maximum: 1", 50.8 * mm, 25.4 * mm),
        ("quantity: joint_life, maximum: 5000", None, 5000 * 3600),
        ("quantity: n_beta, unit: deg/min, maximum: 18000", None, 2000 * rpm * 9 * deg),
        ("quantity: tube_shear_utilisation, unit: '1', maximum: 1", None, 1),
        ("quantity: tube_shear_utilisation, unit: percent, maximum: 67", None, 0.67),
    ],
)
def test_limits_are_read_in_their_units(tmp_path, limit, normal, maximum):
    _, (found,) = load_profile(own(tmp_path, f"  - {{{limit}, source: us}}\n"))
    assert found.normal == (None if normal is None else pytest.approx(normal))
    assert found.maximum == pytest.approx(maximum)


@pytest.mark.parametrize("unit", ["mm", "in"])
def test_margin_to_clearance_limit_of_zero_is_share_of_10_mm(tmp_path, unit):
    """Of a metre, 5 mm were a margin of 0.5 %, and a search went 20 mm further for its reserve."""
    _, (found,) = load_profile(
        own(tmp_path, f"  - {{quantity: clearance, unit: {unit}, maximum: 0, source: us}}\n")
    )
    assert found.margin(5 * mm, to="maximum") == pytest.approx(0.5)
    assert found.margin(-2 * mm, to="maximum") == pytest.approx(-0.2)


def test_the_sense_follows_the_quantity_unless_said(tmp_path):
    text = "".join(
        f"  - {{quantity: {what}, maximum: 1, source: us}}\n"
        for what in ("clearance", "joint_life", "joint_angle", "suspension_frequency, sense: '>='")
    )
    _, held = load_profile(own(tmp_path, text))
    assert [limit.sense for limit in held] == [">=", ">=", "<=", ">="]


def test_a_band_and_the_angle_it_matters_above(tmp_path):
    text = "  - {quantity: half_critical_band, band: [0.42, 0.58], above_angle: 3, source: us}\n"
    _, (found,) = load_profile(own(tmp_path, text))
    assert found.band == (0.42, 0.58)
    assert found.above_angle == pytest.approx(3 * deg)


def test_a_band_in_per_cent_is_the_same_band(tmp_path):
    text = "  - {quantity: half_critical_band, unit: percent, band: [42, 58], source: us}\n"
    _, (found,) = load_profile(own(tmp_path, text))
    assert found.band == pytest.approx((0.42, 0.58))


@pytest.mark.parametrize(
    ("written", "kinds"),
    [
        ("", None),
        (", states: [riding]", {"curb", "empty", "gvw", "overload", "given"}),
        (", states: [stops]", {"full rebound", "rebound", "jounce"}),
        (", states: [wound up]", {"windup", "windup brake"}),
        (", states: [stops, gvw]", {"full rebound", "rebound", "jounce", "gvw"}),
        (", states: [windup]", {"windup"}),
    ],
)
def test_groups_of_states_stand_for_their_kinds(tmp_path, written, kinds):
    """Riding is a state the axle is driven in for long, as given or under its load."""
    text = f"  - {{quantity: joint_angle, maximum: 3, source: us{written}}}\n"
    _, (found,) = load_profile(own(tmp_path, text))
    assert found.states == kinds


@pytest.mark.parametrize("required", ["true", "false"])
def test_a_limit_is_required_where_it_says_so(tmp_path, required):
    text = f"  - {{quantity: joint_angle, maximum: 3, required: {required}, source: us}}\n"
    text += "  - {quantity: joint_angle, maximum: 3, source: us}\n"
    _, (said, unsaid) = load_profile(own(tmp_path, text))
    assert (said.required, unsaid.required) == (required == "true", False)


@pytest.mark.parametrize(
    ("limit", "message"),
    [
        ("quantity: joint_angel, maximum: 3, source: us", "f.yaml:3:16: limits[1].quantity: unknown "
         "quantity (got joint_angel); did you mean joint_angle?"),
        ("quantity: joint_angle, unit: mm, maximum: 3, source: us", "f.yaml:3:35: limits[1].unit: "
         "joint_angle is limited in deg or rad (got mm)"),
        ("quantity: joint_angle, maximum: 3", "f.yaml:3:5: limits[1]: source is missing: who says "
         "so"),
        ("quantity: joint_angle, source: us", "f.yaml:3:5: limits[1]: a limit of joint_angle needs "
         "a finite normal, maximum or band"),
        ("quantity: joint_angle, normal: 7, maximum: 3, source: us", "f.yaml:3:37: limits[1].normal:"
         " must lie on the safe side of the maximum, joint_angle <= 3 (got 7); sense: \"<=\" is an "
         "upper limit, \">=\" a lower one"),
        ("quantity: joint_angle, maximum: 3, sense: <, source: us", "f.yaml:3:48: limits[1].sense: "
         "must be one of <=, >= (got <); did you mean <=?"),
        ("quantity: half_critical_band, band: [0.4], source: us", "f.yaml:3:42: limits[1].band: must "
         "be a list of 2 numbers, [from, to] (got a list of 1)"),
        ("quantity: half_critical_band, band: [0.6, 0.4], source: us", "f.yaml:3:36: limits[1].band: "
         "must rise from above 0 (got 0.6, 0.4)"),
        ("quantity: joint_angle, band: [2, 1], source: us", "f.yaml:3:29: limits[1].band: must rise "
         "from above 0 (got 2, 1)"),
        ("quantity: joint_angle, band: [1, 2], maximum: 5, source: us", "f.yaml:3:52: limits[1]."
         "maximum: a band is a limit of its own: list another of this quantity separately"),
        ("quantity: joint_angle, band: [1, 2], normal: 5, source: us", "f.yaml:3:51: limits[1]."
         "normal: a band is a limit of its own: list another of this quantity separately"),
    ],
)  # fmt: skip
def test_a_wrong_limit_is_told_what_is_wrong(tmp_path, limit, message):
    assert refused(tmp_path, f"  - {{{limit}}}\n") == [message]


def test_an_unknown_profile_hears_of_the_nearest():
    with pytest.raises(InvalidFileError) as error:
        load_profile("spycer")
    assert str(error.value) == (
        "spycer: there is no limit profile of this name; did you mean spicer? "
        "A file of your own ends in .yaml"
    )
