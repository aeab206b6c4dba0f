"""How a line lies: angles of its joints, by themselves and in pairs."""

from cardan.base.formula import written
from cardan.base.part import Part
from cardan.base.source import DERIVED, J3311, SEHERR, SOUZA, Source
from cardan.kinematics.equivalent import pythagorean_angle
from cardan.quantity.declared import (
    Quantity,
    crosses,
    double_cardans,
    joints,
    of_kind,
    shafts,
    tripods,
)
from cardan.quantity.response import Response


def _pairing_shafts(r: Response) -> tuple[Part, ...]:
    """Return the shafts whose two joints are there to cancel: every other one, from the rear."""
    return tuple(Part("shaft", k + 1) for k in r.pairs)


def _odd_joints(r: Response) -> tuple[Part, ...]:
    """Return the crosses that no other is paired with: one at most, where all are crosses."""
    return tuple(Part("joint", k + 1) for k in r.lone)


def _members(r: Response) -> tuple[Part, ...]:
    """Return the members: gearbox output, shafts, pinion."""
    return (Part("gearbox"), *shafts(r), Part("pinion"))


DECLARED = (
    Quantity(
        key="side_slope",
        signed=True,
        name="Side view slope",
        symbol="σv",
        unit="deg",
        equation="σv = atan(−dz / dx), down to the rear is positive",
        where={"d": "direction of the member"},
        source=SOUZA.at("table 8"),
        of=lambda r: r.layout.side,
        parts=_members,
        section="Slopes and lengths",
        contract="members.side_slope_deg",
    ),
    Quantity(
        key="top_slope",
        signed=True,
        name="Top view slope",
        symbol="σh",
        unit="deg",
        equation="σh = atan(dy / dx), to the right going rearward is positive",
        where={"d": "direction of the member"},
        source=SOUZA.at("table 8"),
        of=lambda r: r.layout.top,
        quiet=True,
        parts=_members,
        section="Slopes and lengths",
        contract="members.top_slope_deg",
    ),
    Quantity(
        key="shaft_length",
        name="Shaft length",
        symbol="L",
        unit="mm",
        equation="L = |Pk₊₁ − Pk|, joint centre to joint centre",
        where={"Pk": "centre of joint k"},
        source=SOUZA.at("table 10"),
        of=lambda r: r.layout.lengths,
        parts=shafts,
        section="Slopes and lengths",
        contract="shafts.length_mm",
    ),
    Quantity(
        key="joint_angle",
        at_points=True,
        name="Joint angle",
        symbol="β",
        unit="deg",
        equation="β = atan2(|d₁ × d₂|, d₁ · d₂)",
        where={"d₁, d₂": "unit vectors along the members before and behind the joint"},
        source=DERIVED,
        use="Exact for any layout. View angles combine to it only approximately.",
        of=lambda r: r.angles,
        parts=joints,
        rating="angle_max",
        section="Joints",
        contract="joints.angle_deg",
    ),
    Quantity(
        key="joint_angle_min",
        name="Smallest joint angle",
        symbol="β",
        unit="deg",
        equation="β = atan2(|d₁ × d₂|, d₁ · d₂), held against a lower limit",
        where={"d₁, d₂": "unit vectors along the members before and behind the joint"},
        source=J3311,
        use="Needles that never roll wear grooves (false brinelling): a cross needs some angle.",
        of=lambda r: r.angles[..., of_kind(r, "cross")],
        parts=crosses,
        sense=">=",
    ),
    Quantity(
        key="joint_swing",
        at_points=True,
        name="Speed swing of a double cardan",
        symbol="U₂",
        unit="percent",
        equation="U₂ = sin β' tan β', cos β' = cos β₁ / cos β₂, tan β₁ = r sin β / (f + r cos β)",
        where={
            "β₁, β₂": "angles of its two crosses",
            "f": "−r cos β + √(L² − r² sin² β), from the front cross to the centring point",
            "L, r": "centre piece, and centring ball to rear cross",
        },
        source=DERIVED,
        use="Of the joint by itself; the line counts it as keeping the speed.",
        of=lambda r: r.joint_swing[..., of_kind(r, "double cardan")],
        parts=double_cardans,
        section="Joints",
    ),
    Quantity(
        key="joint_orbit",
        at_points=True,
        name="Orbit of a tripod's centre",
        symbol="e",
        unit="mm",
        equation="e = r (1/cos β − 1)/2, three times a turn",
        where={"r": "from the axis to the middle of the rollers"},
        source=SEHERR,
        use="What the driven shaft must be free to follow; its ratio then stays 1.",
        of=lambda r: r.joint_orbit[..., of_kind(r, "tripod")],
        parts=tripods,
        section="Joints",
    ),
    Quantity(
        key="joint_position",
        name="Position of the joint plane",
        symbol="φ",
        unit="deg",
        equation="φ = atan2(βv, βh), in [0, 360) deg",
        where={"βv, βh": "change of side and top view slope at the joint"},
        source=SOUZA.at("table 3"),
        of=lambda r: r.positions,
        parts=joints,
        section="Joints",
        contract="joints.position_deg",
    ),
    Quantity(
        key="side_angle",
        at_points=True,
        signed=True,
        name="Side view angle",
        symbol="βv",
        unit="deg",
        equation="βv = side slope behind the joint − side slope before it",
        source=SOUZA.at("table 2"),
        of=lambda r: r.side_angles,
        parts=joints,
        section="Joints",
        contract="joints.side_deg",
    ),
    Quantity(
        key="top_angle",
        at_points=True,
        signed=True,
        name="Top view angle",
        symbol="βh",
        unit="deg",
        equation="βh = top slope behind the joint − top slope before it",
        source=SOUZA.at("table 2"),
        of=lambda r: r.top_angles,
        parts=joints,
        section="Joints",
        contract="joints.top_deg",
    ),
    Quantity(
        key="compound_angle",
        at_points=True,
        name="Compound angle",
        symbol="βc",
        unit="deg",
        equation=written(pythagorean_angle, "βv", "βh"),
        where={"βv, βh": "view angles at the joint"},
        source=Source("Meritor, MM-96147 driveline maintenance manual", "p. 87"),
        use="Of a joint whose view angles are small: the square-root approximation.",
        of=lambda r: pythagorean_angle(r.side_angles, r.top_angles),
        parts=joints,
    ),
    Quantity(
        key="end_angle_difference",
        name="Difference of a shaft's joint angles",
        symbol="Δβ",
        unit="deg",
        equation="Δβ = |Dk² − e^(2iε) Dk₊₁²| / (|Dk| + |Dk₊₁|)",
        where={
            "Dk": "true angle and plane of a joint, β e^(iφ)",
            "ε": "yoke phase of the shaft between the two",
        },
        source=J3311,
        use="|βk − βk₊₁| in one plane with yokes in line. Shafts pair their joints from the rear.",
        of=lambda r: r.pair_differences,
        parts=_pairing_shafts,
    ),
    Quantity(
        key="odd_joint_angle",
        name="Angle of the joint that stands alone",
        symbol="β₁",
        unit="deg",
        equation="β₁ of a line with an odd number of joints",
        where={"β₁": "true angle of the first joint: the others pair from the rear"},
        source=J3311,
        use="Nothing cancels what it does, so it should be small.",
        of=lambda r: r.angles[..., list(r.lone)],
        parts=_odd_joints,
    ),
)
