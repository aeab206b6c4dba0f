"""Critical speeds, strength and life of tubes and joints."""

from typing import Any

import numpy as np

from cardan.checks.line_response import LineResponse
from cardan.checks.quantities.declaration import (
    NEEDS_ALL_TUBES,
    NEEDS_DUTY_CYCLE,
    NEEDS_FATIGUE_TORQUE_RATING,
    NEEDS_LIFE_RATING,
    NEEDS_MOUNT_STIFFNESS,
    NEEDS_PEAK_TORQUE_RATING,
    NEEDS_SHAFT_LENGTHS,
    NEEDS_SPEED,
    NEEDS_TORQUE,
    NEEDS_TUBE_OF_SHAFT,
    NEEDS_YIELD_STRENGTH,
    STATE_KINDS_AT_LOADED_RIDE_HEIGHT,
    Quantity,
    Requirement,
    all_joints,
    all_shafts,
    line_on_rubber,
    whole_line,
)
from cardan.core.arrays import ArrayLike, FloatArray, stack_on_last_axis
from cardan.core.labels import WHOLE_LINE, Part
from cardan.core.provenance import (
    GWB_CATALOGUE,
    SAE_AE7,
    SEHERR_THOSS_2006,
    SOURCE_DERIVED,
    SOUZA_2014_BRACKET_FAILURE,
    Source,
)
from cardan.core.symbolic import ConstantWithDisplayText, trace_expression
from cardan.core.units import rpm
from cardan.model.parts import JointKind, Tube
from cardan.physics.strength.bearing_life import (
    cross_joint_life_consumption_rate,
    speed_angle_product,
)
from cardan.physics.strength.critical_speed import (
    HALF_CRITICAL_SPEED_RATIO_RANGE,
    slender_tube_critical_speed,
)
from cardan.physics.strength.torsional_strength import bearing_cup_pressure, tube_utilisation

_RPM = ConstantWithDisplayText(1 / rpm, "30/π", "30/PI()")


def _whirling(r: LineResponse) -> tuple[Part, ...]:
    return (*all_shafts(r), WHOLE_LINE)


_WHIRLING = Requirement(
    required_input=NEEDS_TUBE_OF_SHAFT.required_input,
    is_met=lambda r: np.concatenate(
        [NEEDS_TUBE_OF_SHAFT.is_met(r), NEEDS_ALL_TUBES.is_met(r)], axis=-1
    ),
)


_JOINTS_WITH_CROSSES: frozenset[JointKind] = frozenset({"cross", "double cardan"})
_JOINTS_WITH_BEARINGS: frozenset[JointKind] = frozenset({
    "cross", "double cardan", "rzeppa", "tripod"
})  # fmt: skip

_CUPS = Requirement(
    required_input="a joint size with cross_width_mm, cup_length_mm and cup_diameter_mm",
    is_met=lambda r: np.array(
        [[s is not None and s.cup_spacing is not None for s in r.joint_sizes]]
    ),
)


_FATIGUE_SHEAR = Requirement(
    required_input="a tube material with its fatigue_shear_MPa",
    is_met=lambda r: np.array(
        [
            [
                isinstance(s.tube, Tube) and s.tube.material.fatigue_shear is not None
                for s in r.line.shafts
            ]
        ]
    ),
)


def _share(speed: Any, critical: Any) -> Any:
    """Return a speed over the critical one."""
    return speed / critical


def _speed_ratios(r: LineResponse) -> FloatArray:
    """Return the reached speed over the critical speed of each shaft, and over the line's."""
    critical = [*np.moveaxis(r.strength.critical_speeds, -1, 0), r.strength.line_critical_speed]
    return _share(r.inputs.reached_speed[..., None], stack_on_last_axis(critical))


def half_critical_speed_ratio(r: LineResponse) -> FloatArray:
    """Return the speed over the critical one that lies nearest to the half-critical band.

    Of top speed, of the larger one that engine and gears reach and, in states that last, of the
    duty cycle's speeds up to it: what turns faster than the band passes through it, and what
    counts is whether it stays there.
    """
    critical = stack_on_last_axis(
        [*np.moveaxis(r.strength.critical_speeds, -1, 0), r.strength.line_critical_speed]
    )
    found = _share(r.demand.speed[..., None], critical)
    top = r.inputs.reached_speed[..., None]
    lasting = r.inputs.sustained_states[:, None]
    duty = [(np.asarray(p.speed, dtype=float)[..., None], lasting) for p in r.inputs.duty_points]
    for speed, counts in ((top, np.ones_like(lasting)), *duty):
        driven = _share(np.where(speed <= top, speed, np.nan), critical)
        nearer = distance_from_half_critical(driven) < distance_from_half_critical(found)
        found = np.where(counts & nearer, driven, found)
    return found


def distance_from_half_critical(ratio: FloatArray) -> FloatArray:
    """Return how far speed ratios (...) lie off the half-critical band, below 0 within it, 1."""
    low, high = HALF_CRITICAL_SPEED_RATIO_RANGE
    return np.maximum((low - ratio) / low, (ratio - high) / high)


def _with_tubes(r: LineResponse) -> list[int]:
    """Return the shafts, from 0, that have a tube: the wall of others is not needed."""
    return [k for k, s in enumerate(r.line.shafts) if s.tube is not None]


def _in_every_state(r: LineResponse, value: ArrayLike) -> FloatArray:
    """Return what does not depend on the state, (..., states, 1)."""
    cases = np.zeros(r.layout.directions.shape[:-2])
    return (cases + np.asarray(value, dtype=float))[..., None]


DECLARATIONS = (
    Quantity(
        key="critical_speed",
        name="Critical speed",
        symbol="nc",
        unit="rpm",
        equation=_RPM
        * trace_expression(
            slender_tube_critical_speed, "L", outer="D", inner="d", youngs_modulus="E", density="ρ"
        ),
        symbol_meanings={"L": "joint centre distance", "D, d": "tube diameters", "E, ρ": "steel"},
        source=SAE_AE7.with_place("p. 267"),
        validity="Uniform tube pinned at its ends; the line as beams on its bearings is computed "
        "too. A tube of plies counts with its shear, which slows it more.",
        compute=lambda r: r.strength.critical_speeds,
        parts=all_shafts,
        requirements=(NEEDS_SHAFT_LENGTHS, NEEDS_TUBE_OF_SHAFT),
        section="Speed and strength",
        json_path="critical_speeds_rpm[]",
    ),
    Quantity(
        key="line_critical_speed",
        name="Critical speed of the line",
        symbol="nl",
        unit="rpm",
        equation="nl = (30/π) Ω, the lowest with det(K − Ω² (M − G)) = 0 that bends the shafts",
        symbol_meanings={
            "K": "stiffness of tubes and centre bearings",
            "M": "mass of tubes, yokes, spline",
            "G": "gyroscopic matrix",
        },
        source=Source(
            "Nelson, A finite rotating shaft element using Timoshenko beam theory, "
            "J. Mechanical Design 102, 1980"
        ),
        validity="Timoshenko beams hinged at the joints, taken as straight, without torque.",
        compute=lambda r: _in_every_state(r, r.strength.line_critical_speed),
        parts=whole_line,
        requirements=(NEEDS_SHAFT_LENGTHS, NEEDS_ALL_TUBES),
        section="Speed and strength",
        json_path="line_critical_speed_rpm",
    ),
    Quantity(
        key="bearing_resonance",
        name="Bounce on the centre bearings",
        symbol="nb",
        unit="rpm",
        equation="nb = (30/π) Ω, the lowest with det(K − Ω² (M − G)) = 0 that strains the rubber",
        source=SOURCE_DERIVED,
        validity="Passed at every start and damped by the rubber; joints excite it at half of nb.",
        compute=lambda r: _in_every_state(r, r.strength.mount_resonance_speed),
        parts=whole_line,
        requirements=(NEEDS_SHAFT_LENGTHS, NEEDS_ALL_TUBES),
        section="Speed and strength",
    ),
    Quantity(
        key="resonance_distance",
        name="Duty speed off a resonance",
        symbol="|k n/nb − 1|",
        unit="1",
        equation="least |k Ω / ω − 1| of the duty cycle's speeds, k = 2, and 1 with unbalance",
        symbol_meanings={
            "Ω": "a speed of the duty cycle",
            "ω": "a mode of the line on its rubber, under the torque of that speed",
        },
        source=SOURCE_DERIVED,
        validity="Every start passes the modes, and the bearing forces count that; this is of "
        "speeds "
        "driven in for long. 20 % off a mode it makes at most 2.8 times of a force.",
        compute=lambda r: r.mount_loads.resonance_distance[..., None][
            ..., : len(line_on_rubber(r))
        ],
        depends_on_mounts=True,
        parts=line_on_rubber,
        sense=">=",
        requirements=(NEEDS_SHAFT_LENGTHS, *NEEDS_DUTY_CYCLE, NEEDS_MOUNT_STIFFNESS),
        states=STATE_KINDS_AT_LOADED_RIDE_HEIGHT,
        section="Speed and strength",
        json_path="resonance_distance",
    ),
    Quantity(
        key="critical_speed_ratio",
        name="Speed / critical speed",
        symbol="n/nc",
        unit="1",
        equation=trace_expression(_share, "n", "nc"),
        source=SAE_AE7.with_place("p. 267"),
        validity="At the larger of the file's top speed and of what engine and highest gear reach, "
        "in states without a speed of their own.",
        compute=_speed_ratios,
        parts=_whirling,
        requirements=(NEEDS_SHAFT_LENGTHS, NEEDS_SPEED, _WHIRLING),
    ),
    Quantity(
        key="half_critical_band",
        name="Speed near half critical",
        symbol="n/nc",
        unit="1",
        equation="n / nc outside 0.42 … 0.58",
        source=SAE_AE7.with_place("p. 267"),
        validity="The joints excite twice a turn; matters above about 3 deg of joint angle. Of top "
        "speed and the duty cycle's speeds the nearest: a line that turns faster passes through.",
        compute=half_critical_speed_ratio,
        parts=_whirling,
        requirements=(NEEDS_SHAFT_LENGTHS, NEEDS_SPEED, _WHIRLING),
    ),
    Quantity(
        key="tube_shear_utilisation",
        at_all_points=True,
        name="Tube shear / yield",
        symbol="τ/τy",
        unit="1",
        equation=trace_expression(
            tube_utilisation, "T", outer="D", inner="d", yield_strength="Re", shock_factor="K"
        ),
        symbol_meanings={"K": "shock factor", "D, d": "tube diameters", "Re": "yield strength"},
        source=SEHERR_THOSS_2006,
        validity="Of a tube of plies: the torque's share of what fails the first of them, by "
        "Tsai-Wu "
        "or by its largest stress, whichever is stricter; without stresses from curing.",
        compute=lambda r: r.strength.tube_shear_utilisation,
        parts=all_shafts,
        requirements=(NEEDS_TORQUE, NEEDS_TUBE_OF_SHAFT, NEEDS_YIELD_STRENGTH),
        section="Speed and strength",
    ),
    Quantity(
        key="tube_stress_utilisation",
        name="Tube shear and bending / yield",
        symbol="σv/Re",
        unit="1",
        equation="K √(σ² + 3 τ²) / Re, σ = 32 M D / (π (D⁴ − d⁴)), τ = 16 T D / (π (D⁴ − d⁴))",
        symbol_meanings={
            "K": "shock factor",
            "M": "bending moment of the secondary couples, largest round a turn",
            "D, d": "tube diameters",
            "Re": "yield strength",
        },
        source=SEHERR_THOSS_2006,
        validity="Of a steel tube away from welds and yokes, at the state's torque; the largest "
        "bending "
        "taken together with the largest torque.",
        compute=lambda r: r.strength.tube_stress_utilisation,
        parts=all_shafts,
        requirements=(NEEDS_TORQUE, NEEDS_TUBE_OF_SHAFT, NEEDS_YIELD_STRENGTH),
        section="Speed and strength",
        json_path="shafts.tube_stress_utilisation",
    ),
    Quantity(
        key="couple_ahead",
        name="Secondary couple on the member ahead",
        symbol="Mv",
        unit="Nm",
        equation="Mv = max over a turn of |M − (M · d) d|, T tan β of one joint",
        symbol_meanings={"M": "moment of the cross", "d": "direction of the member"},
        source=SOUZA_2014_BRACKET_FAILURE.with_place("figure 39"),
        validity="At the state's torque, rigid and without friction.",
        compute=lambda r: r.rigid_loads.secondary_couples[0],
        parts=all_joints,
        requirements=(NEEDS_TORQUE,),
        section="Couples and forks",
        json_path="joints.couple_ahead_Nm",
    ),
    Quantity(
        key="couple_behind",
        name="Secondary couple on the member behind",
        symbol="Mh",
        unit="Nm",
        equation="Mh = max over a turn of |M − (M · d) d|, T sin β of one joint",
        symbol_meanings={"M": "moment of the cross", "d": "direction of the member"},
        source=SOUZA_2014_BRACKET_FAILURE.with_place("figure 40"),
        validity="At the state's torque, rigid and without friction.",
        compute=lambda r: r.rigid_loads.secondary_couples[1],
        parts=all_joints,
        requirements=(NEEDS_TORQUE,),
        section="Couples and forks",
        json_path="joints.couple_behind_Nm",
    ),
    Quantity(
        key="bending_moment",
        name="Bending moment in the shaft",
        symbol="M",
        unit="Nm",
        equation="largest of the secondary couples at its ends and the moment at its bearing",
        source=SOUZA_2014_BRACKET_FAILURE.with_place("figures 41, 42"),
        validity="At the state's torque, rigid and without friction.",
        compute=lambda r: r.rigid_loads.bending_moments,
        parts=all_shafts,
        requirements=(NEEDS_TORQUE,),
        section="Couples and forks",
        json_path="shafts.bending_Nm",
    ),
    Quantity(
        key="journal_force",
        name="Force on a journal and its fork arm",
        symbol="F",
        unit="N",
        equation="F = T / (a cos β)",
        symbol_meanings={
            "T": "largest torque of the driving yoke",
            "a": "between the middles of the cups",
        },
        source=SOUZA_2014_BRACKET_FAILURE.with_place("figure 39"),
        validity="At the state's torque, without shock.",
        compute=lambda r: r.rigid_loads.journal_force,
        parts=all_joints,
        requirements=(NEEDS_TORQUE, _CUPS),
        joint_kinds=_JOINTS_WITH_CROSSES,
        section="Couples and forks",
        json_path="joints.journal_force_N",
    ),
    Quantity(
        key="cup_pressure",
        name="Pressure of a cup in its yoke",
        symbol="p",
        unit="MPa",
        equation=trace_expression(bearing_cup_pressure, "F", diameter="d", length="l"),
        symbol_meanings={"F": "force on a journal", "d, l": "diameter and length of a cup"},
        source=SOURCE_DERIVED,
        validity="Mean over the projected area.",
        compute=lambda r: r.rigid_loads.cup_pressure,
        parts=all_joints,
        requirements=(NEEDS_TORQUE, _CUPS),
        joint_kinds=_JOINTS_WITH_CROSSES,
        section="Couples and forks",
        json_path="joints.cup_pressure_MPa",
    ),
    Quantity(
        key="tube_buckling_utilisation",
        at_all_points=True,
        name="Torque / buckling torque",
        symbol="T/Tb",
        unit="1",
        equation="K |T| / Tb, the lowest Tb with det(K(n) − Tb G(n)) = 0 in n waves round",
        symbol_meanings={
            "K": "shock factor",
            "K(n)": "stiffness of the wall, each ply in its place",
            "G(n)": "work of the shear flow of 1 N·m on the wall's turning",
        },
        source=Source("Flügge, Stresses in Shells, 1973", "ch. 8"),
        validity="Perfectly round, ends pinned at the joint centres, in the sense of torque that "
        "plies "
        "hold less well. Of metal by a curve up to 6 % below that; a thick wall yields before.",
        compute=lambda r: r.strength.tube_buckling_utilisation[..., _with_tubes(r)],
        parts=lambda r: tuple(Part("shaft", k + 1) for k in _with_tubes(r)),
        requirements=(NEEDS_TORQUE,),
        section="Speed and strength",
    ),
    Quantity(
        key="tube_fatigue_utilisation",
        name="Tube shear / endurance",
        symbol="τa/τf",
        unit="1",
        equation="τa/τf + |τm|/τu",
        symbol_meanings={
            "τa, τm": "amplitude and mean of the shear stress",
            "τf": "amplitude endured about zero",
            "τu": "ultimate shear strength",
        },
        source=Source("Shigley, Mechanical Engineering Design"),
        validity="The weld decides: its endurance, not the tube's, belongs here. From overrun to "
        "drive torque; τu is 0.67 of the ultimate strength, and without that the mean "
        "is left out.",
        compute=lambda r: r.strength.tube_fatigue_utilisation,
        parts=all_shafts,
        requirements=(NEEDS_TORQUE, NEEDS_TUBE_OF_SHAFT, _FATIGUE_SHEAR),
    ),
    Quantity(
        key="joint_torque_utilisation",
        at_all_points=True,
        uses_engine_torque=True,
        name="Joint torque / elastic limit",
        symbol="T/Tcs",
        unit="1",
        equation="max over a turn of T / Tcs, from the engine torque times the shock factor",
        symbol_meanings={"Tcs": "functional limit torque of the joint"},
        validity="Ahead of what the engine gives in a gear, even where the tyres slip before; in "
        "reverse and held back of what the line carries.",
        source=GWB_CATALOGUE,
        compute=lambda r: r.strength.joint_torque_utilisation,
        parts=all_joints,
        requirements=(NEEDS_TORQUE, NEEDS_PEAK_TORQUE_RATING),
        section="Speed and strength",
    ),
    Quantity(
        key="joint_fatigue_utilisation",
        name="Alternating joint torque / fatigue rating",
        symbol="T/Tdw",
        unit="1",
        equation="(Ta + (2 Tdw/Tds − 1) |Tm|) / Tdw",
        symbol_meanings={
            "Ta, Tm": "amplitude and mean of the torque",
            "Tdw": "reversing torque endured",
            "Tds": "pulsating torque endured",
        },
        source=GWB_CATALOGUE,
        validity="T/Tdw for reversing, T/Tds for pulsating torque; a straight line between. From "
        "overrun to drive: reverse, which is rare, does not count in the alternating "
        "torque.",
        compute=lambda r: r.strength.joint_fatigue_utilisation,
        parts=all_joints,
        requirements=(NEEDS_TORQUE, NEEDS_FATIGUE_TORQUE_RATING),
        section="Speed and strength",
    ),
    Quantity(
        key="joint_life",
        name="Needle bearing life",
        symbol="Lh",
        unit="h",
        equation=1
        / trace_expression(
            cross_joint_life_consumption_rate,
            "T",
            speed="n",
            angle="β",
            rated_torque="Td",
            prime_mover_factor="K1",
        ),
        symbol_meanings={
            "n": "speed, rpm",
            "β": "joint angle, deg",
            "Td": "torque for 5000 h at 100 rpm and 3 deg",
            "K1": "prime mover factor",
        },
        source=SAE_AE7.with_place("p. 31"),
        validity=(
            "B10 life of the needle bearings, greased. Over a duty cycle 1/L is the mean by time."
        ),
        compute=lambda r: r.strength.needle_bearing_life,
        parts=all_joints,
        sense=">=",
        requirements=(*NEEDS_DUTY_CYCLE, NEEDS_LIFE_RATING),
        joint_kinds=_JOINTS_WITH_BEARINGS,
        states=STATE_KINDS_AT_LOADED_RIDE_HEIGHT,
        section="Speed and strength",
        json_path="joints.life_h",
    ),
    Quantity(
        key="n_beta",
        at_all_points=True,
        name="Joint angle x speed",
        symbol="n β",
        unit="deg_min",
        equation=trace_expression(speed_angle_product, "n", angle="β"),
        source=GWB_CATALOGUE,
        compute=lambda r: speed_angle_product(r.demand.speed[..., None], angle=r.joint_angles),
        parts=all_joints,
        requirements=(NEEDS_SPEED,),
        rating_attribute="speed_angle_max",
        rating_of_other_kinds="speed_angle_max",
        rating_replaces_profile=True,
    ),
    Quantity(
        key="joint_speed",
        name="Speed of the joint",
        symbol="n",
        unit="rpm",
        equation="n against the joint's own limit",
        source=GWB_CATALOGUE,
        compute=lambda r: np.broadcast_to(r.demand.speed[..., None], r.joint_angles.shape),
        parts=all_joints,
        requirements=(NEEDS_SPEED,),
        rating_attribute="speed_max",
        rating_of_other_kinds="speed_max",
        rating_replaces_profile=True,
    ),
)
