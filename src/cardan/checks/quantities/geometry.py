"""How a line lies: angles of its joints, by themselves and in pairs."""

from cardan.checks.line_response import LineResponse
from cardan.checks.quantities.declaration import (
    Quantity,
    all_joints,
    all_shafts,
    cross_joints,
    double_cardan_joints,
    joint_indices_of_kind,
    tripod_joints,
)
from cardan.core.labels import Part
from cardan.core.provenance import (
    SEHERR_THOSS_2006,
    SOURCE_DERIVED,
    SOUZA_2014_BRACKET_FAILURE,
    SPICER_J3311,
    Source,
)
from cardan.core.symbolic import trace_expression
from cardan.physics.kinematics.equivalent_angle import true_angle_by_pythagoras


def _pairing_shafts(r: LineResponse) -> tuple[Part, ...]:
    """Return the shafts whose two joints are there to cancel: every other one, from the rear."""
    return tuple(Part("shaft", k + 1) for k in r.kinematics.paired_shafts)


def _odd_joints(r: LineResponse) -> tuple[Part, ...]:
    """Return the crosses that no other is paired with: one at most, where all are crosses."""
    return tuple(Part("joint", k + 1) for k in r.kinematics.unpaired_joints)


def _members(r: LineResponse) -> tuple[Part, ...]:
    """Return the members: gearbox output, shafts, pinion."""
    return (Part("gearbox"), *all_shafts(r), Part("pinion"))


DECLARATIONS = (
    Quantity(
        key="side_slope",
        signed=True,
        name="Slope in side view",
        symbol="σv",
        unit="deg",
        equation="σv = atan(−dz / dx), down to the rear is positive",
        symbol_meanings={"d": "direction of the member"},
        source=SOUZA_2014_BRACKET_FAILURE.with_place("table 8"),
        compute=lambda r: r.layout.side,
        parts=_members,
        section="Slopes and lengths",
        json_path="members.side_slope_deg",
    ),
    Quantity(
        key="top_slope",
        signed=True,
        name="Slope in plan view",
        symbol="σh",
        unit="deg",
        equation="σh = atan(dy / dx), to the right going rearward is positive",
        symbol_meanings={"d": "direction of the member"},
        source=SOUZA_2014_BRACKET_FAILURE.with_place("table 8"),
        compute=lambda r: r.layout.top,
        hidden_if_zero=True,
        parts=_members,
        section="Slopes and lengths",
        json_path="members.top_slope_deg",
    ),
    Quantity(
        key="shaft_length",
        name="Shaft length",
        symbol="L",
        unit="mm",
        equation="L = |Pk₊₁ − Pk|, joint centre to joint centre",
        symbol_meanings={"Pk": "centre of joint k"},
        source=SOUZA_2014_BRACKET_FAILURE.with_place("table 10"),
        compute=lambda r: r.layout.lengths,
        parts=all_shafts,
        section="Slopes and lengths",
        json_path="shafts.length_mm",
    ),
    Quantity(
        key="joint_angle",
        at_all_points=True,
        name="Joint angle",
        symbol="β",
        unit="deg",
        equation="β = atan2(|d₁ × d₂|, d₁ · d₂)",
        symbol_meanings={"d₁, d₂": "unit vectors along the members before and behind the joint"},
        source=SOURCE_DERIVED,
        validity="Exact for any layout. View angles combine to it only approximately.",
        compute=lambda r: r.joint_angles,
        parts=all_joints,
        rating_attribute="angle_max",
        rating_of_other_kinds="angle_max",
        section="Joints",
        json_path="joints.angle_deg",
    ),
    Quantity(
        key="joint_angle_min",
        name="Smallest joint angle",
        symbol="β",
        unit="deg",
        equation="β = atan2(|d₁ × d₂|, d₁ · d₂), held against a lower limit",
        symbol_meanings={"d₁, d₂": "unit vectors along the members before and behind the joint"},
        source=SPICER_J3311,
        validity=(
            "Needles that never roll wear grooves (false brinelling): a cross needs some angle."
        ),
        compute=lambda r: r.joint_angles[..., joint_indices_of_kind(r, "cross")],
        parts=cross_joints,
        sense=">=",
    ),
    Quantity(
        key="joint_swing",
        at_all_points=True,
        name="Speed swing of a double cardan",
        symbol="U₂",
        unit="percent",
        equation="U₂ = sin β' tan β', cos β' = cos β₁ / cos β₂, tan β₁ = r sin β / (f + r cos β)",
        symbol_meanings={
            "β₁, β₂": "angles of its two crosses",
            "f": "−r cos β + √(L² − r² sin² β), from the front cross to the centring point",
            "L, r": "centre piece, and centring ball to rear cross",
        },
        source=SOURCE_DERIVED,
        validity="Of the joint by itself; the line counts it as keeping the speed.",
        compute=lambda r: r.kinematics.double_cardan_speed_fluctuation[
            ..., joint_indices_of_kind(r, "double cardan")
        ],
        parts=double_cardan_joints,
        section="Joints",
    ),
    Quantity(
        key="joint_orbit",
        at_all_points=True,
        name="Orbit of a tripod's centre",
        symbol="e",
        unit="mm",
        equation="e = r (1/cos β − 1)/2, three times a turn",
        symbol_meanings={"r": "from the axis to the middle of the rollers"},
        source=SEHERR_THOSS_2006,
        validity="What the driven shaft must be free to follow; its ratio then stays 1.",
        compute=lambda r: r.kinematics.tripod_orbit_radius[..., joint_indices_of_kind(r, "tripod")],
        parts=tripod_joints,
        section="Joints",
    ),
    Quantity(
        key="joint_position",
        name="Position of the joint plane",
        symbol="φ",
        unit="deg",
        equation="φ = atan2(βv, βh), in [0, 360) deg",
        symbol_meanings={"βv, βh": "change of side and plan view slope at the joint"},
        source=SOUZA_2014_BRACKET_FAILURE.with_place("table 3"),
        compute=lambda r: r.kinematics.joint_plane_positions,
        parts=all_joints,
        section="Joints",
        json_path="joints.position_deg",
    ),
    Quantity(
        key="side_angle",
        at_all_points=True,
        signed=True,
        name="Angle in side view",
        symbol="βv",
        unit="deg",
        equation="βv = side slope behind the joint − side slope before it",
        source=SOUZA_2014_BRACKET_FAILURE.with_place("table 2"),
        compute=lambda r: r.kinematics.side_angles,
        parts=all_joints,
        section="Joints",
        json_path="joints.side_deg",
    ),
    Quantity(
        key="top_angle",
        at_all_points=True,
        signed=True,
        name="Angle in plan view",
        symbol="βh",
        unit="deg",
        equation="βh = top slope behind the joint − top slope before it",
        source=SOUZA_2014_BRACKET_FAILURE.with_place("table 2"),
        compute=lambda r: r.kinematics.top_angles,
        parts=all_joints,
        section="Joints",
        json_path="joints.top_deg",
    ),
    Quantity(
        key="compound_angle",
        at_all_points=True,
        name="Compound angle",
        symbol="βc",
        unit="deg",
        equation=trace_expression(true_angle_by_pythagoras, "βv", "βh"),
        symbol_meanings={"βv, βh": "view angles at the joint"},
        source=Source("Meritor, MM-96147 driveline maintenance manual", "p. 87"),
        validity="Of a joint whose view angles are small: the square-root approximation.",
        compute=lambda r: true_angle_by_pythagoras(
            r.kinematics.side_angles, r.kinematics.top_angles
        ),
        parts=all_joints,
        rating_of_other_kinds="angle_max",
    ),
    Quantity(
        key="end_angle_difference",
        name="Difference of the joint angles",
        symbol="Δβ",
        unit="deg",
        equation="Δβ = |Dk² − e^(2iε) Dk₊₁²| / (|Dk| + |Dk₊₁|)",
        symbol_meanings={
            "Dk": "true angle and plane of a joint, β e^(iφ)",
            "ε": "yoke phase of the shaft between the two",
        },
        source=SPICER_J3311,
        validity=(
            "|βk − βk₊₁| in one plane with yokes in line. Shafts pair their joints from the rear."
        ),
        compute=lambda r: r.kinematics.pair_angle_differences,
        parts=_pairing_shafts,
    ),
    Quantity(
        key="odd_joint_angle",
        name="Angle of the unpaired joint",
        symbol="β₁",
        unit="deg",
        equation="β₁ of a line with an odd number of joints",
        symbol_meanings={"β₁": "true angle of the first joint: the others pair from the rear"},
        source=SPICER_J3311,
        validity="Nothing cancels what it does, so it should be small.",
        compute=lambda r: r.joint_angles[..., list(r.kinematics.unpaired_joints)],
        parts=_odd_joints,
    ),
)
