"""Self-calibration: published cases, recomputed by this program on this machine.

Each case is a printed number, with its place; the tolerance is half a unit of its last
printed digit, unless the source is known to round more, and then the case says so. Numbers
that no publication holds, worked by hand or by engines of another kind, stand apart.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from cardan.application.typical_values import typical_value
from cardan.core.arrays import FloatArray
from cardan.core.message import TranslatableMessage, translatable_message
from cardan.core.provenance import (
    ASTM_E1049,
    ELBE_CATALOGUE,
    PME2540_AUTOMOTIVE_COURSE_EXERCISE_E2,
    SAE_AE7,
    SOUZA_2014_BRACKET_FAILURE,
    SPICER_J3311,
    Source,
)
from cardan.core.units import GPa, MPa, deg, hour, inch, lb, lbf, lbft, mm, psi, rpm
from cardan.model.laminate import CARBON_EPOXY, CompositeTube
from cardan.model.layout import Layout, layout_from_joint_angles, layout_from_slopes
from cardan.model.parts import CentreBearing, Line, Shaft, Tube
from cardan.model.vehicle import Engine, Gearbox, Spring
from cardan.physics.dynamics.floquet import PeriodicSystem, monodromy_matrix
from cardan.physics.dynamics.stability_chart import find_zeros
from cardan.physics.fatigue import sn_curve as strength
from cardan.physics.fatigue.rainflow import rainflow
from cardan.physics.kinematics import equivalent_angle as equivalent
from cardan.physics.kinematics import hooke_joint as joint
from cardan.physics.kinematics.joint_chain import joint_angles, rotate_chain
from cardan.physics.loads.half_turn_fourier import HalfTurnSeries
from cardan.physics.loads.small_angle import small_angle_bearing_forces
from cardan.physics.loads.statics import joint_loads
from cardan.physics.strength import bearing_life as life
from cardan.physics.strength import composite_tube as composite
from cardan.physics.strength import critical_speed as whirl
from cardan.physics.vehicle.suspension import spring_table_rates
from cardan.physics.vehicle.torque import gear_table, j3311_low_gear_torque, j3311_wheel_slip_torque

SOURCE_PARKER_CHELSEA = Source(
    "Parker Chelsea, manual HY25-1890-M1/US", "p. 5, Spicer joint operating angles"
)
SOURCE_NIAGARA_DRIVETRAIN = Source(
    "Niagara Drivetrain, U-joints & driveline", "operating angles, Spicer's table"
)
SOURCE_PSS_CALCULATIONS = Source(
    "PSS.DriveshaftCalculations (anderjeff, commit ed6a288, 2014)",
    "Calibration/AccelerationCalibration.cs",
)
SOURCE_TOYOTA_SUPRA = Source("Toyota Supra repair manual, propeller shaft", "PR-19")
SOURCE_LEXUS_LS400 = Source(
    "Lexus LS 400, example of joint angles", "as Toyota's repair manuals print it"
)
SOURCE_UNIMOG_GUIDELINES = Source(
    "Unimog, Body and implement mounting guidelines (August 2005)", "p. 178, PTO N08"
)
SOURCE_VECTO_ENGINES = Source(
    "VECTO generic vehicles", "engines of 6871 and 12,730 cm³, declaration data"
)
SOURCE_CALCADY_ONLINE_CALCULATOR = Source(
    "calcady.com, driveshaft critical speed", "rounds I, w and g on the way, 0.105 % together"
)
SOURCE_SHIGLEY = Source("Shigley, Mechanical Engineering Design, 9th ed.", "ch. 6")
SOURCE_TSAI_HAHN = Source(
    "Tsai & Hahn, Introduction to Composite Materials (1980)", "tables 1.8 and 3.6"
)
SOURCE_KHOSHRAVAN_PAYKANI = Source(
    "Khoshravan & Paykani, Int. J. Engineering 25 (2012)", "the steel tube"
)
SOURCE_NIST_DLMF = Source("NIST Digital Library of Mathematical Functions", "table 28.6.1")
SOURCE_AISCO_SIZING = Source(
    "AISCO, Universal joint sizing (aiscoinc.com)", "definitions: the rating's basis"
)
SOURCE_AISCO_LIFE_FORMULA_BY_HAND = Source("AISCO's life formula, worked by hand")
SOURCE_MULTIBODY_SIMULATION = Source(
    "Derived; confirmed by two independent multibody engines to 1e-9"
)
SOURCE_SOUZA_TABLE_1 = Source("Derived from Souza (2014), table 1", "which states 120.6 and 192.2")
SOURCE_MECHANICS_COURSES = Source(
    "Hooke's joint problems of mechanics courses; their book is not traced"
)
SOURCE_MACHINECALCS = Source("Derived: machinecalcs.com prints 7200 rpm; its own model gives 8284")

CaseKind: TypeAlias = Literal["published", "untraced", "derived"]
"""Printed where a reader can look; printed in an unknown place; computed by other means."""


@dataclass(frozen=True, kw_only=True)
class BenchmarkCase:
    """One published number, and what this program computes for it, in the unit printed.

    `tolerance` is the largest difference that rounding in print explains.
    """

    title: TranslatableMessage
    source: Source
    expected: float
    computed: float
    tolerance: float
    kind: CaseKind = "published"

    @property
    def relative_difference(self) -> float:
        """Computed over published, less 1."""
        return self.computed / self.expected - 1

    @property
    def is_within_tolerance(self) -> bool:
        """Whether the printed digits are met; nan is not."""
        return abs(self.computed - self.expected) <= self.tolerance


def benchmark_cases() -> tuple[BenchmarkCase, ...]:
    """Recompute every case: the published ones, those not traced, and at the end derived ones."""
    cases = (
        *_one_joint(),
        *_chains(),
        *_demands(),
        *_forces(),
        *_speeds(),
        *_lives(),
        *_strengths(),
        *_composites(),
        *_stability(),
    )
    kinds: tuple[CaseKind, ...] = ("published", "untraced", "derived")
    return tuple(sorted(cases, key=lambda c: kinds.index(c.kind)))


_APART: dict[Source, CaseKind] = {
    SOURCE_MECHANICS_COURSES: "untraced",
    SOURCE_MULTIBODY_SIMULATION: "derived",
    SOURCE_AISCO_LIFE_FORMULA_BY_HAND: "derived",
    SOURCE_SOUZA_TABLE_1: "derived",
    SOURCE_MACHINECALCS: "derived",
    PME2540_AUTOMOTIVE_COURSE_EXERCISE_E2: "derived",
    ELBE_CATALOGUE: "derived",
}
"""Sources whose numbers cannot be looked up; E2 and Elbe print the formula and the limit."""


def _case(
    title: str,
    source: Source,
    expected: float,
    computed: object,
    within: float,
    **values: object,
) -> BenchmarkCase:
    """Return a case of a number that may come as an array without axes.

    `values` are those that the title names.
    """
    return BenchmarkCase(
        title=translatable_message(title, **values),
        source=source,
        expected=expected,
        computed=float(np.asarray(computed)),
        tolerance=within,
        kind=_APART.get(source, "published"),
    )


def _one_joint() -> Iterator[BenchmarkCase]:
    """Yield cases of one Hooke joint."""
    low, high = joint.speed_range(25 * deg)
    yield _case(
        "Hooke joint 25 deg at 100 rad/s: highest speed, rad/s",
        SOURCE_MECHANICS_COURSES,
        110.34,
        100 * high,
        5e-3,
    )
    yield _case(
        "Hooke joint 25 deg at 100 rad/s: lowest speed, rad/s",
        SOURCE_MECHANICS_COURSES,
        90.63,
        100 * low,
        5e-3,
    )
    for angle, percent in ((10, 3.062), (15, 6.935)):
        yield _case("Irregularity of a joint at {angle} deg, %", SOURCE_MECHANICS_COURSES, percent,
                    100 * joint.irregularity(angle * deg), 5e-4, angle=angle)  # fmt: skip
    yield _case("Joint angle of 12.5 % irregularity, deg", SOURCE_MECHANICS_COURSES, 20.04,
                joint.angle_for_irregularity(0.125) / deg, 5e-3)  # fmt: skip
    at = joint.speed_ratio(np.pi / 2, beta=30 * deg, pin=joint.PIN_NORMAL_TO_PLANE)
    yield _case(
        "Speed ratio at 30 deg, pin normal, a quarter on",
        PME2540_AUTOMOTIVE_COURSE_EXERCISE_E2,
        1 / np.cos(30 * deg),
        at,
        1e-12,
    )


def _chains() -> Iterator[BenchmarkCase]:
    """Yield cases of joint angles and lines."""
    side = np.array([-2.70, -1.25, 2.45]) * deg
    top = np.array([0.67, 0.13, -0.80]) * deg
    angles = equivalent.true_angle_by_pythagoras(side, top) / deg
    places = equivalent.joint_plane_angle(side, top) / deg
    for k, (angle, place) in enumerate(((2.7819, 283.94), (1.2567, 275.94), (2.5773, 108.08))):
        yield _case(
            "True angle of joint {number}, deg",
            SOUZA_2014_BRACKET_FAILURE.with_place("table 3"),
            angle,
            angles[k],
            5e-5,
            number=k + 1,
        )
        yield _case(
            "Position of joint {number}, deg",
            SOUZA_2014_BRACKET_FAILURE.with_place("table 3"),
            place,
            places[k],
            6e-3,
            number=k + 1,
        )
    yield _case("Compound angle of 2.15 and 2.50 deg, deg", SPICER_J3311.with_place("fig. 6"), 3.3,
                equivalent.true_angle_by_pythagoras(2.5 * deg, 2.15 * deg) / deg, 0.05)  # fmt: skip
    exact = {(0, 0): 3.5864, (90, 0): 1.7392, (0, 90): 0.7912, (90, 90): 3.9782}
    layout = layout_from_joint_angles(side=side, top=top, lengths=[1.0, 1.0])
    for phases, angle in exact.items():
        found = equivalent.excitation_of_rotating_chain(
            rotate_chain(layout.directions, phases=np.array(phases) * deg), speed=1.0
        )
        yield _case(
            "Equivalent angle of the chain, {phases}, deg",
            SOURCE_MULTIBODY_SIMULATION,
            angle,
            found.torsional.angle / deg,
            5e-5,
            phases=tuple("90° out of phase" if p else "in phase" for p in phases),
        )
    yield _case("Equivalent angle of U = 0.0027, deg", ELBE_CATALOGUE, 2.98,
                joint.angle_for_irregularity(0.0027) / deg, 5e-3)  # fmt: skip
    minutes = {
        SOURCE_PARKER_CHELSEA: {3000: 350, 2500: 420, 2000: 520, 1500: 690},
        SOURCE_NIAGARA_DRIVETRAIN: {4000: 255, 3500: 300},
    }
    for source, table in minutes.items():
        for n, angle in table.items():
            # Printed in steps of 10 minutes of arc.
            found = equivalent.angle_for_acceleration(1000.0, speed=n * rpm) / deg
            yield _case("Largest joint angle at {speed} rpm, deg", source, angle / 60, found,
                        5 / 60, speed=n)  # fmt: skip
    yield from _calibration()
    yield from _workshop()


def _calibration() -> Iterator[BenchmarkCase]:
    """Yield the check of a driveshaft shop's program: four joints, the first shaft out of phase."""
    found = equivalent.spicer_sine_squared_excitation(
        np.array([5.0, 4.0, 3.0, 2.0]) * deg, np.zeros(4),
        phases=np.array([90.0, 0.0, 0.0]) * deg, speed=2500 * rpm,
    )  # fmt: skip
    for name, of, angle, rate in (
        ("Drive inertia", found.drive, 9.90, 2026),
        ("Overrun inertia", found.coast, 3.16, 209),
        ("Torsional", found.torsional, 6.00, 749),
    ):
        yield _case(
            "{excitation}, joints of 5, 4, 3, 2 deg, deg",
            SOURCE_PSS_CALCULATIONS,
            angle,
            of.angle / deg,
            5e-3,
            excitation=name,
        )
        yield _case(
            "{excitation}, the same at 2500 rpm, rad/s2",
            SOURCE_PSS_CALCULATIONS,
            rate,
            of.acceleration,
            0.5,
            excitation=name,
        )


def _workshop() -> Iterator[BenchmarkCase]:
    """Yield joint angles from the slopes a workshop measures, in minutes of arc."""
    for source, slopes, printed in (
        (SOURCE_TOYOTA_SUPRA, ((1, 50), (2, 14), (2, 15)), (24, 1)),
        (SOURCE_LEXUS_LS400, ((2, 0), (2, 51), (1, 54)), (51, 57)),
    ):
        side = np.array([whole + minutes / 60 for whole, minutes in slopes]) * deg
        layout = layout_from_slopes(side=side, top=np.zeros(3), lengths=[1.0])
        angles = joint_angles(layout.directions) / deg * 60
        for number, angle, found in zip((2, 3), printed, angles, strict=True):
            yield _case("Angle of joint {number} from slopes, minutes", source, angle, found, 0.5,
                        number=number)  # fmt: skip


def _demands() -> Iterator[BenchmarkCase]:
    """Yield cases of torque and suspension."""
    yield _case("Low gear torque LGT, lb-ft", SPICER_J3311.with_place("p. 2"), 14603,
                j3311_low_gear_torque(1567.5 * lbft, ratio=10.96, efficiency=0.85) / lbft,
                0.5)  # fmt: skip
    yield _case("Wheel slip torque WST, lb-ft", SPICER_J3311.with_place("p. 2"), 13024,
                j3311_wheel_slip_torque(40000 * lbf, radius=19.5 * inch, ratio=3.73) / lbft,
                0.5)  # fmt: skip
    spring = Spring(
        load=(0.0, 11562.0, 12749.0, 26233.0, 43345.0),
        deflection=tuple(x * mm for x in (0.0, 96.0, 105.0, 185.0, 273.0)),
    )
    first, *_, last = spring_table_rates(spring) * mm
    yield _case("Spring rate before contact, N/mm (stated 120.6)", SOURCE_SOUZA_TABLE_1, 120.4,
                first, 0.05)  # fmt: skip
    yield _case("Spring rate after contact, N/mm (stated 192.2)", SOURCE_SOUZA_TABLE_1, 194.5,
                last, 0.05)  # fmt: skip

    pto = gear_table(Engine(speed=(2200 * rpm,), torque=(1.0,)), Gearbox(ratios=(2.139,)))
    yield _case("Power take-off at 2200 rpm, i = 2.139, rpm", SOURCE_UNIMOG_GUIDELINES, 1029,
                np.squeeze(pto.speed) / rpm, 0.5)  # fmt: skip
    base, litre = (
        typical_value(f"engine.inertia_{part}", "heavy truck").value
        for part in ("base", "per_litre")
    )
    for volume, inertia, within in ((6.871, 3.56517, 5e-6), (12.73, 5.1471, 5e-5)):
        yield _case(
            "Engine of {volume} l with flywheel and clutch, kg m2",
            SOURCE_VECTO_ENGINES,
            inertia,
            base + litre * volume,
            within,
            volume=f"{volume:g}",
        )


def _forces() -> Iterator[BenchmarkCase]:
    """Yield the centre-bearing force of a two-piece line."""
    layout = layout_from_slopes(
        side=np.array([3.0, 1.0, 4.5, 2.0]) * deg,
        top=np.array([0.0, 1.5, -0.8, 0.6]) * deg,
        lengths=[1.2, 1.5],
    )
    line = Line(shafts=(Shaft(length=1.2, centre_bearing=CentreBearing()), Shaft(length=1.5)))
    cases = {
        "exact": (_exact_force(layout, line), 5.139, 20.090),
        "small angle": (small_angle_bearing_forces(layout, line, torque=1000.0), 5.124, 20.049),
    }
    for name, (cycle, static, dynamic) in cases.items():
        yield _case("Centre bearing, static force, {method}, N", SOURCE_MULTIBODY_SIMULATION,
                    static, np.linalg.norm(cycle.static), 5e-4, method=name)  # fmt: skip
        yield _case(
            "Centre bearing, twice a turn, {method}, N",
            SOURCE_MULTIBODY_SIMULATION,
            dynamic,
            cycle.dynamic[0],
            5e-4,
            method=name,
        )


def _exact_force(layout: Layout, line: Line) -> HalfTurnSeries:
    found = rotate_chain(layout.directions, phases=line.phases)
    return joint_loads(layout, found, line, torque=1000.0).bearing_forces


def _speeds() -> Iterator[BenchmarkCase]:
    """Yield critical speeds."""
    found = whirl.inch_formula_critical_speed(60 * inch, outer=3.5 * inch, inner=3.26 * inch)
    yield _case("Critical speed, 3.5 x 0.120 x 60 in, rpm", SAE_AE7.with_place("p. 267"), 6251,
                found / rpm, 0.5)  # fmt: skip
    found = whirl.slender_tube_critical_speed(
        48 * inch, outer=3 * inch, inner=2.76 * inch, youngs_modulus=200e9, density=7850.0
    )
    yield _case(
        "Critical speed, 3 x 0.120 x 48 in, rpm", SOURCE_MACHINECALCS, 8284, found / rpm, 0.5
    )
    found = whirl.slender_tube_critical_speed(
        45 * inch, outer=3.5 * inch, inner=3.334 * inch,
        youngs_modulus=30e6 * psi, density=0.283 * lb / inch**3,
    )  # fmt: skip
    yield _case(
        "Critical speed, 3.5 x 0.083 x 45 in, rpm",
        SOURCE_CALCADY_ONLINE_CALCULATOR,
        11390,
        found / rpm,
        12,
    )


def _lives() -> Iterator[BenchmarkCase]:
    """Yield needle bearing lives."""
    for title, source, torque, n, beta, expected in (
        (
            "Joint life, Td 2000, T 500 N·m, 1500 rpm, 5 deg, h",
            SOURCE_AISCO_LIFE_FORMULA_BY_HAND,
            500.0,
            1500,
            5,
            20319,
        ),
        (
            "Joint life at the rated torque, 100 rpm, 3 deg, h",
            SOURCE_AISCO_SIZING,
            2000.0,
            100,
            3,
            5000,
        ),
    ):
        worn = life.cross_joint_life_consumption_rate(
            torque, speed=n * rpm, angle=beta * deg, rated_torque=2000.0, prime_mover_factor=1.0
        )
        yield _case(title, source, expected, life.joint_life(worn) / hour, 0.5)


def _strengths() -> Iterator[BenchmarkCase]:
    """Yield what fatigue strength is multiplied by, and cycles counted."""
    counted = rainflow([-2, 1, -3, 5, -1, 3, -4, 4, -2])
    for size, cycles in {3: 0.5, 4: 1.5, 6: 0.5, 8: 1.0, 9: 0.5}.items():
        yield _case(
            "Rainflow cycles of range {range}",
            ASTM_E1049.with_place("5.4.4, figure 6"),
            cycles,
            counted.count[counted.range == size].sum(),
            0.0,
            range=size,
        )
    yield _case(
        "Surface factor, machined, 400 MPa",
        SOURCE_SHIGLEY.with_place("example 6-3"),
        0.922,
        strength.surface_factor("machined", ultimate=400 * MPa),
        5e-4,
    )
    yield _case("Size factor, 32 mm", SOURCE_SHIGLEY.with_place("example 6-4"), 0.858,
                strength.size_factor(32 * mm), 5e-4)  # fmt: skip
    q = strength.neuber_sensitivity(radius=3 * mm, ultimate=690 * MPa)
    yield _case(
        "Fatigue notch factor, 3 mm, 690 MPa, Kt 1.65",
        SOURCE_SHIGLEY.with_place("example 6-6"),
        1.55,
        strength.notch_factor(concentration=1.65, sensitivity=q),
        5e-3,
    )
    for survive, factor in {90: 0.897, 95: 0.868, 99: 0.814, 99.9: 0.753, 99.99: 0.702}.items():
        # ka = 1 - 0.08 z, and the table's own z has three digits.
        yield _case(
            "Reliability factor, {share} %",
            SOURCE_SHIGLEY.with_place("table 6-5"),
            factor,
            strength.reliability_factor(1 - survive / 100),
            6e-4,
            share=f"{survive:g}",
        )
    for ultimate, limit in {400: 200, 1200: 600, 1750: 700}.items():
        yield _case(
            "Endurance limit of {ultimate} MPa steel, MPa",
            SOURCE_SHIGLEY.with_place("equation 6-8"),
            limit,
            strength.endurance_limit(ultimate * MPa) / MPa,
            0.5,
            ultimate=ultimate,
        )


def _composites() -> Iterator[BenchmarkCase]:
    """Yield stiffnesses of carbon plies, and the steel tube a composite one is compared with."""
    Q = CARBON_EPOXY.stiffness / GPa
    turned = CompositeTube.from_ply_angles(CARBON_EPOXY, [45 * deg], outer=0.1)
    R = turned.membrane_stiffness / turned.wall / GPa
    for name, expected, found, within in (
        ("Qxx", 181.81, Q[0, 0], 5e-3), ("Qyy", 10.346, Q[1, 1], 5e-4),
        ("Qxy", 2.897, Q[0, 1], 5e-4), ("Qss", 7.17, Q[2, 2], 5e-3),
    ):  # fmt: skip
        yield _case(
            "T300/5208, {stiffness}, GPa",
            SOURCE_TSAI_HAHN.with_place("table 1.8"),
            expected,
            found,
            within,
            stiffness=name,
        )
    for name, expected, found in (
        ("Q11", 56.66, R[0, 0]), ("Q12", 42.32, R[0, 1]), ("Q66", 46.59, R[2, 2]),
        ("Q16", 42.87, R[0, 2]),
    ):  # fmt: skip
        # The table turns rounded stiffnesses: 0.03 %.
        yield _case(
            "T300/5208 at 45 deg, {stiffness}, GPa",
            SOURCE_TSAI_HAHN.with_place("table 3.6"),
            expected,
            found,
            3e-4 * expected,
            stiffness=name,
        )
    wall = composite.equivalent_steel_wall_thickness(
        5000.0, outer_radius=30 * mm, yield_strength=750 * MPa, at="middle"
    )
    tube = Tube(outer=60 * mm, wall=float(wall))
    yield _case(
        "Steel tube for 5 kN·m, 60 mm, 750 MPa: wall, mm",
        SOURCE_KHOSHRAVAN_PAYKANI,
        2.200,
        wall / mm,
        5e-4,
    )
    yield _case("The same at 7800 kg/m3, kg/m", SOURCE_KHOSHRAVAN_PAYKANI, 3.117, tube.area * 7800,
                5.1e-4)  # fmt: skip


def _stability() -> Iterator[BenchmarkCase]:
    """Yield edges of Mathieu's equation, y'' + (a - 2 q cos 2t) y = 0 at q = 1."""

    def excess(a: FloatArray) -> FloatArray:
        system = PeriodicSystem(
            period=np.full(a.shape, np.pi),
            matrices=lambda t: (
                np.eye(1),
                np.zeros((1, 1)),
                (a[..., None] - 2 * np.cos(2 * np.pi * t))[..., None, None],
            ),
        )
        return np.abs(np.trace(monodromy_matrix(system, tolerance=1e-10), axis1=-2, axis2=-1)) - 2

    found = find_zeros(excess, between=(-1, 4.2))
    for name, value in (("a0", -0.455139), ("a1", 1.859108), ("b1", -0.110249), ("b2", 3.917025)):
        yield _case("Mathieu's {edge}(1)", SOURCE_NIST_DLMF, value,
                    found[np.abs(found - value).argmin()], 5e-7, edge=name)  # fmt: skip
