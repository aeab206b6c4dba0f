"""Critical speeds, strength and life of tubes and joints."""

from typing import Any

import numpy as np

from cardan.base.arrays import ArrayLike, FloatArray, stacked
from cardan.base.formula import Constant, written
from cardan.base.part import LINE, Part
from cardan.base.source import AE7, DERIVED, GWB, SEHERR, SOUZA, Source
from cardan.base.units import rpm
from cardan.quantity.declared import (
    ALL_TUBES,
    DUTY,
    FATIGUE_RATING,
    LENGTHS,
    LIFE_RATING,
    PEAK_RATING,
    RIDING,
    RUBBER,
    SPEED,
    TORQUE,
    TUBES,
    YIELD,
    Need,
    Quantity,
    hung,
    joints,
    line,
    shafts,
)
from cardan.quantity.response import Response
from cardan.shaft.life import n_beta, wear
from cardan.shaft.strength import cup_pressure, tube_utilisation
from cardan.shaft.whirl import HALF_CRITICAL, critical_speed

_RPM = Constant(1 / rpm, "30/π", "30/PI()")


def _whirling(r: Response) -> tuple[Part, ...]:
    return (*shafts(r), LINE)


_WHIRLING = Need(
    gives=TUBES.gives,
    met=lambda r: np.concatenate([TUBES.met(r), ALL_TUBES.met(r)], axis=-1),
)


_CUPS = Need(
    gives="a joint size with cross_width_mm, cup_length_mm and cup_diameter_mm",
    met=lambda r: np.array([[s is not None and s.across is not None for s in r.sizes]]),
)


def _share(speed: Any, critical: Any) -> Any:
    """Return a speed over the critical one."""
    return speed / critical


def _speed_ratios(r: Response) -> FloatArray:
    """Return top speed over the critical speed of each shaft, and over that of the line."""
    critical = [*np.moveaxis(r.critical_speeds, -1, 0), r.line_critical_speed]
    return _share(r.demand.speed[..., None], stacked(critical))


def near_half(r: Response) -> FloatArray:
    """Return the speed over the critical one that lies nearest to the half-critical band.

    Of top speed and, in states that last, of the duty cycle's speeds up to it: what turns
    faster than the band passes through it, and what counts is whether it stays there.
    """
    critical = stacked([*np.moveaxis(r.critical_speeds, -1, 0), r.line_critical_speed])
    found = _share(r.demand.speed[..., None], critical)
    low, high = HALF_CRITICAL
    for point in r.duty:
        speed = np.asarray(point.speed, dtype=float)[..., None]
        driven = _share(np.where(speed <= r.demand.speed[..., None], speed, np.nan), critical)
        off, other = (np.maximum((low - v) / low, (v - high) / high) for v in (found, driven))
        found = np.where(r.lasting[:, None] & (other < off), driven, found)
    return found


def _with_tubes(r: Response) -> list[int]:
    """Return the shafts, from 0, that have a tube: nobody misses the wall of others."""
    return [k for k, s in enumerate(r.line.shafts) if s.tube is not None]


def _in_every_state(r: Response, value: ArrayLike) -> FloatArray:
    """Return what does not depend on the state, (..., states, 1)."""
    cases = np.zeros(r.layout.directions.shape[:-2])
    return (cases + np.asarray(value, dtype=float))[..., None]


DECLARED = (
    Quantity(
        key="critical_speed",
        name="Critical speed",
        symbol="nc",
        unit="rpm",
        equation=_RPM
        * written(critical_speed, "L", outer="D", inner="d", youngs_modulus="E", density="ρ"),
        where={"L": "joint centre distance", "D, d": "tube diameters", "E, ρ": "steel"},
        source=AE7.at("p. 267"),
        use="Uniform tube pinned at its ends; the line as beams on its bearings stands beside it. "
        "A tube of plies counts with its shear, which slows it more.",
        of=lambda r: r.critical_speeds,
        parts=shafts,
        needs=(LENGTHS, TUBES),
        section="Speed and strength",
        contract="critical_speeds_rpm[]",
    ),
    Quantity(
        key="line_critical_speed",
        name="Critical speed of the line",
        symbol="nl",
        unit="rpm",
        equation="nl = (30/π) Ω, the lowest with det(K − Ω² (M − G)) = 0 that bends the shafts",
        where={
            "K": "stiffness of tubes and centre bearings",
            "M": "mass of tubes, yokes, spline",
            "G": "gyroscopic matrix",
        },
        source=Source(
            "Nelson, A finite rotating shaft element using Timoshenko beam theory, "
            "J. Mechanical Design 102, 1980"
        ),
        use="Timoshenko beams hinged at the joints, taken as straight, without torque.",
        of=lambda r: _in_every_state(r, r.line_critical_speed),
        parts=line,
        needs=(LENGTHS, ALL_TUBES),
        section="Speed and strength",
        contract="line_critical_speed_rpm",
    ),
    Quantity(
        key="bearing_resonance",
        name="Bounce on the centre bearings",
        symbol="nb",
        unit="rpm",
        equation="nb = (30/π) Ω, the lowest with det(K − Ω² (M − G)) = 0 that strains the rubber",
        source=DERIVED,
        use="Passed at every start and damped by the rubber; joints excite it at half of nb.",
        of=lambda r: _in_every_state(r, r.bearing_resonance),
        parts=line,
        needs=(LENGTHS, ALL_TUBES),
        section="Speed and strength",
    ),
    Quantity(
        key="resonance_distance",
        name="Duty speed off a resonance on the rubber",
        symbol="|k n/nb − 1|",
        unit="1",
        equation="least |k Ω / ω − 1| of the duty cycle's speeds, k = 2, and 1 with unbalance",
        where={
            "Ω": "a speed of the duty cycle",
            "ω": "a mode of the line on its rubber, under the torque of that speed",
        },
        source=DERIVED,
        use="Every start passes the modes, and the bearing forces count that; this is of speeds "
        "driven in for long. 20 % off a mode it makes at most 2.8 times of a force.",
        of=lambda r: r.resonance_distance[..., None][..., : len(hung(r))],
        on_rubber=True,
        parts=hung,
        sense=">=",
        needs=(LENGTHS, *DUTY, RUBBER),
        states=RIDING,
        section="Speed and strength",
        contract="resonance_distance",
    ),
    Quantity(
        key="critical_speed_ratio",
        name="Speed over critical speed",
        symbol="n/nc",
        unit="1",
        equation=written(_share, "n", "nc"),
        source=AE7.at("p. 267"),
        of=_speed_ratios,
        parts=_whirling,
        needs=(LENGTHS, SPEED, _WHIRLING),
    ),
    Quantity(
        key="half_critical_band",
        name="Speed near half critical",
        symbol="n/nc",
        unit="1",
        equation="n / nc outside 0.42 … 0.58",
        source=AE7.at("p. 267"),
        use="The joints excite twice a turn; matters above about 3 deg of joint angle. Of top "
        "speed and the duty cycle's speeds the nearest: a line that turns faster passes through.",
        of=near_half,
        parts=_whirling,
        needs=(LENGTHS, SPEED, _WHIRLING),
    ),
    Quantity(
        key="tube_shear_utilisation",
        at_points=True,
        name="Tube shear over yield",
        symbol="τ/τy",
        unit="1",
        equation=written(
            tube_utilisation, "T", outer="D", inner="d", yield_strength="Re", shock_factor="K"
        ),
        where={"K": "shock factor", "D, d": "tube diameters", "Re": "yield strength"},
        source=SEHERR,
        use="Of a tube of plies: the torque's share of what fails the first of them, by Tsai-Wu "
        "or by its largest stress, whichever is stricter; without stresses from curing.",
        of=lambda r: r.tube_shear_utilisation,
        parts=shafts,
        needs=(TORQUE, TUBES, YIELD),
        section="Speed and strength",
    ),
    Quantity(
        key="tube_stress_utilisation",
        name="Tube shear and bending over yield",
        symbol="σv/Re",
        unit="1",
        equation="K √(σ² + 3 τ²) / Re, σ = 32 M D / (π (D⁴ − d⁴)), τ = 16 T D / (π (D⁴ − d⁴))",
        where={
            "K": "shock factor",
            "M": "bending moment of the secondary couples, largest round a turn",
            "D, d": "tube diameters",
            "Re": "yield strength",
        },
        source=SEHERR,
        use="Of a steel tube away from welds and yokes, at the state's torque; the largest bending "
        "taken together with the largest torque.",
        of=lambda r: r.tube_stress_utilisation,
        parts=shafts,
        needs=(TORQUE, TUBES, YIELD),
        section="Speed and strength",
        contract="shafts.tube_stress_utilisation",
    ),
    Quantity(
        key="couple_ahead",
        name="Secondary couple on the member ahead",
        symbol="Mv",
        unit="Nm",
        equation="Mv = max over a turn of |M − (M · d) d|, T tan β of one joint",
        where={"M": "moment of the cross", "d": "direction of the member"},
        source=SOUZA.at("figure 39"),
        use="At the state's torque, rigid and without friction.",
        of=lambda r: r.couples[0],
        parts=joints,
        needs=(TORQUE,),
        section="Couples and forks",
        contract="joints.couple_ahead_Nm",
    ),
    Quantity(
        key="couple_behind",
        name="Secondary couple on the member behind",
        symbol="Mh",
        unit="Nm",
        equation="Mh = max over a turn of |M − (M · d) d|, T sin β of one joint",
        where={"M": "moment of the cross", "d": "direction of the member"},
        source=SOUZA.at("figure 40"),
        use="At the state's torque, rigid and without friction.",
        of=lambda r: r.couples[1],
        parts=joints,
        needs=(TORQUE,),
        section="Couples and forks",
        contract="joints.couple_behind_Nm",
    ),
    Quantity(
        key="bending_moment",
        name="Bending moment in the shaft",
        symbol="M",
        unit="Nm",
        equation="largest of the secondary couples at its ends and the moment at its bearing",
        source=SOUZA.at("figures 41, 42"),
        use="At the state's torque, rigid and without friction.",
        of=lambda r: r.bending,
        parts=shafts,
        needs=(TORQUE,),
        section="Couples and forks",
        contract="shafts.bending_Nm",
    ),
    Quantity(
        key="journal_force",
        name="Force on a journal and its fork arm",
        symbol="F",
        unit="N",
        equation="F = T / (a cos β)",
        where={"T": "largest torque of the driving yoke", "a": "between the middles of the cups"},
        source=SOUZA.at("figure 39"),
        use="At the state's torque, without shock.",
        of=lambda r: r.journal_force,
        parts=joints,
        needs=(TORQUE, _CUPS),
        section="Couples and forks",
        contract="joints.journal_force_N",
    ),
    Quantity(
        key="cup_pressure",
        name="Pressure of a cup in its yoke",
        symbol="p",
        unit="MPa",
        equation=written(cup_pressure, "F", diameter="d", length="l"),
        where={"F": "force on a journal", "d, l": "diameter and length of a cup"},
        source=DERIVED,
        use="Mean over the projected area.",
        of=lambda r: r.cup_pressure,
        parts=joints,
        needs=(TORQUE, _CUPS),
        section="Couples and forks",
        contract="joints.cup_pressure_MPa",
    ),
    Quantity(
        key="tube_buckling_utilisation",
        at_points=True,
        name="Torque over the tube's buckling torque",
        symbol="T/Tb",
        unit="1",
        equation="K |T| / Tb, the lowest Tb with det(K(n) − Tb G(n)) = 0 in n waves round",
        where={
            "K": "shock factor",
            "K(n)": "stiffness of the wall, each ply in its place",
            "G(n)": "work of the shear flow of 1 N·m on the wall's turning",
        },
        source=Source("Flügge, Stresses in Shells, 1973", "ch. 8"),
        use="Perfectly round, ends pinned at the joint centres, in the sense of torque that plies "
        "hold less well. Of metal by a curve up to 6 % below that; a thick wall yields before.",
        of=lambda r: r.tube_buckling_utilisation[..., _with_tubes(r)],
        parts=lambda r: tuple(Part("shaft", k + 1) for k in _with_tubes(r)),
        needs=(TORQUE,),
        section="Speed and strength",
    ),
    Quantity(
        key="tube_fatigue_utilisation",
        name="Tube shear over endurance",
        symbol="τa/τf",
        unit="1",
        equation="τa/τf + |τm|/τu",
        where={
            "τa, τm": "amplitude and mean of the shear stress",
            "τf": "amplitude endured about zero",
            "τu": "ultimate shear strength",
        },
        source=Source("Shigley, Mechanical Engineering Design"),
        use="The weld decides: its endurance, not the tube's, belongs here.",
    ),
    Quantity(
        key="joint_torque_utilisation",
        at_points=True,
        sizes=True,
        name="Joint torque over its elastic limit",
        symbol="T/Tcs",
        unit="1",
        equation="max over a turn of T / Tcs, from the engine torque times the shock factor",
        where={"Tcs": "functional limit torque of the joint"},
        use="Ahead of what the engine gives in a gear, even where the tyres slip before; in "
        "reverse and held back of what the line carries.",
        source=GWB,
        of=lambda r: r.joint_torque_utilisation,
        parts=joints,
        needs=(TORQUE, PEAK_RATING),
        section="Speed and strength",
    ),
    Quantity(
        key="joint_fatigue_utilisation",
        name="Joint torque swing over its fatigue rating",
        symbol="T/Tdw",
        unit="1",
        equation="(Ta + (2 Tdw/Tds − 1) |Tm|) / Tdw",
        where={
            "Ta, Tm": "amplitude and mean of the torque",
            "Tdw": "reversing torque endured",
            "Tds": "pulsating torque endured",
        },
        source=GWB,
        use="T/Tdw for reversing, T/Tds for pulsating torque; a straight line between. From coast "
        "to drive: reverse, which comes seldom, is not in the swing.",
        of=lambda r: r.joint_fatigue_utilisation,
        parts=joints,
        needs=(TORQUE, FATIGUE_RATING),
        section="Speed and strength",
    ),
    Quantity(
        key="joint_life",
        name="Needle bearing life",
        symbol="Lh",
        unit="h",
        equation=1
        / written(wear, "T", speed="n", angle="β", rated_torque="Td", prime_mover_factor="K1"),
        where={
            "n": "speed, rpm",
            "β": "joint angle, deg",
            "Td": "torque for 5000 h at 100 rpm and 3 deg",
            "K1": "prime mover factor",
        },
        source=AE7.at("p. 31"),
        use="B10 life of the needle bearings, greased. Over a duty cycle 1/L is the mean by time.",
        of=lambda r: r.life,
        parts=joints,
        sense=">=",
        needs=(*DUTY, LIFE_RATING),
        states=RIDING,
        section="Speed and strength",
        contract="joints.life_h",
    ),
    Quantity(
        key="n_beta",
        at_points=True,
        name="Speed times joint angle",
        symbol="n β",
        unit="deg_min",
        equation=written(n_beta, "n", angle="β"),
        source=GWB,
        of=lambda r: n_beta(r.demand.speed[..., None], angle=r.angles),
        parts=joints,
        needs=(SPEED,),
        rating="speed_angle_max",
        own_first=True,
    ),
    Quantity(
        key="joint_speed",
        name="Speed of the joint",
        symbol="n",
        unit="rpm",
        equation="n against the joint's own limit",
        source=GWB,
        of=lambda r: np.broadcast_to(r.demand.speed[..., None], r.angles.shape),
        parts=joints,
        needs=(SPEED,),
        rating="speed_max",
        own_first=True,
    ),
)
